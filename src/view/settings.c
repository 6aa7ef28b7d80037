/* SPDX-License-Identifier: MIT */
#include "view/settings.h"

view_settings view_settings_default(void)
{
    view_settings s = {
        .mode = VIEW_SPHERES,
        .rows = 7,
        .columns = 7,
        .metallic = {0, 1},
        .roughness = {0, 1},
        .diffuse = VIEW_DIFFUSE_AUTO,
        .multiscatter = true,
        .fov = 30,
        .border = 0.04,
        .blur = 0.4,
        .tone = VIEW_TONE_NEUTRAL,
        .layout = VIEW_CROSS,
        .zoom = 1,
        .antialias = 1,
        .split = 0.5,
        .gain = 10,
        .parallax = VIEW_PARALLAX_BOX,
        .nearest = 4,
        .probe_size = 4,
        .probe_interval = 0.5,
    };
    /* Those of LearnOpenGL's chapter "Lighting" of PBR: 300 at +-10, +-10, 10,
     * before spheres 2.5 apart. Here these are 1 apart, so lengths are times
     * 0.4, and intensities, irradiance times a squared length, times 0.16. */
    for (int i = 0; i < VIEW_MAX_LIGHTS; i++) {
        view_light *l = &s.light[i];
        l->position[0] = i % 2 ? 4 : -4;
        l->position[1] = i < 2 ? 4 : -4;
        l->position[2] = 4;
        for (int k = 0; k < 3; k++)
            l->intensity[k] = 0.16 * 300;
    }
    return s;
}

bool view_shows_materials(const view_settings *s)
{
    return s->mode == VIEW_SPHERES || s->mode == VIEW_MODEL;
}

bool view_is_lit(const view_settings *s)
{
    return view_shows_materials(s) || s->mode == VIEW_SCENE;
}

bool view_wants_reference(const view_settings *s)
{
    return view_shows_materials(s) && s->reflection == VIEW_REFERENCE;
}

bool view_is_sampled(const view_settings *s, const view_settings *other)
{
    return view_wants_reference(s) ||
           (s->compare && view_wants_reference(other));
}

int view_places(const view_settings *s)
{
    return view_is_lit(s) ? s->antialias * s->antialias : 1;
}

void view_set_place(view_settings *s, int i)
{
    const double n = s->antialias, x = i % s->antialias, y = i / s->antialias;

    s->pixel[0] = (x + (n - y - 0.5) / n) / n - 0.5;
    s->pixel[1] = (y + (x + 0.5) / n) / n - 0.5;
}

bool view_needs_lobes(view_reflection reflection)
{
    return reflection >= VIEW_TABLE_LOBES && reflection <= VIEW_FOUR_TAPS;
}

const char *const view_mode_names[VIEW_MODES + 1] = {
    "spheres", "levels", "irradiance", "table", "scene", "model", "map"};

const char *const view_layout_names[VIEW_LAYOUTS + 1] = {"cross", "strip",
                                                         "equirect"};

const char *const view_diffuse_names[VIEW_DIFFUSES + 1] = {"map", "sh", "last",
                                                           "auto"};

const char *const view_reflection_names[VIEW_REFLECTIONS + 1] = {
    "split",      "fit",       "table",    "two-taps",
    "three-taps", "four-taps", "reference"};

const char *const view_channel_names[VIEW_CHANNELS + 1] = {
    "rgb", "red", "green", "blue", "alpha", "luminance"};
