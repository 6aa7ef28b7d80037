/* SPDX-License-Identifier: MIT */
#include "view/settings.h"

/* Radiant intensity of lights before the corners of the default grid; each
 * gives about as much as a bright overcast sky. */
static const double lamp = 60;

view_settings view_settings_default(void)
{
    view_settings s = {
        .mode = VIEW_SPHERES,
        .rows = 7,
        .columns = 7,
        .metallic = {0, 1},
        .roughness = {0, 1},
        .diffuse = VIEW_DIFFUSE_MAP,
        .multiscatter = true,
        .fov = 30,
        .border = 0.04,
        .sky = true,
        .tone = VIEW_TONE_NEUTRAL,
        .layout = VIEW_CROSS,
        .zoom = 1,
        .antialias = 1,
        .multisample = 1,
        .against = VIEW_REFERENCE,
        .split = 0.5,
        .gain = 10,
        .parallax = true,
        .walls = true,
        .blend = true,
        .probe_size = 256,
        .probe_interval = 0.5,
        .capture_shadows = true,
        .mirror_priority = VIEW_MIRROR_AUTO,
    };
    for (int i = 0; i < VIEW_MAX_LIGHTS; i++) {
        view_light *l = &s.light[i];
        l->position[0] = i % 2 ? 4 : -4;
        l->position[1] = i < 2 ? 4 : -4;
        l->position[2] = 5;
        for (int k = 0; k < 3; k++)
            l->intensity[k] = lamp;
    }
    return s;
}

bool view_shows_materials(const view_settings *s)
{
    return s->mode == VIEW_SPHERES || s->mode == VIEW_MODEL;
}

bool view_compares(const view_settings *s)
{
    return view_shows_materials(s) && s->compare != VIEW_ALONE;
}

bool view_wants_reference(const view_settings *s)
{
    return view_shows_materials(s) &&
           (s->reflection == VIEW_REFERENCE ||
            (s->compare != VIEW_ALONE && s->against == VIEW_REFERENCE));
}

int view_places(const view_settings *s)
{
    const bool smooth = view_shows_materials(s) ||
                        (s->mode == VIEW_SCENE && s->multisample == 1);

    return smooth ? s->antialias * s->antialias : 1;
}

void view_set_place(view_settings *s, int i)
{
    const double n = s->antialias, x = i % s->antialias, y = i / s->antialias;

    s->pixel[0] = (x + (n - y - 0.5) / n) / n - 0.5;
    s->pixel[1] = (y + (x + 0.5) / n) / n - 0.5;
}

double view_widening(const view_settings *s)
{
    return s->antialias > 1 && !view_compares(s) && !view_wants_reference(s)
               ? 1.0 / s->antialias
               : 0;
}

bool view_needs_lobes(view_reflection reflection)
{
    return reflection >= VIEW_TABLE_LOBES && reflection <= VIEW_FOUR_TAPS;
}

const char *const view_mode_names[VIEW_MODES + 1] = {
    "spheres", "levels", "irradiance", "table", "scene", "model"};

const char *const view_layout_names[VIEW_LAYOUTS + 1] = {"cross", "strip",
                                                         "equirect"};

const char *const view_tone_names[VIEW_TONES + 1] = {"linear", "reinhard",
                                                     "aces", "neutral"};

const char *const view_diffuse_names[VIEW_DIFFUSES + 1] = {"map", "sh"};

const char *const view_reflection_names[VIEW_REFLECTIONS + 1] = {
    "split", "bent", "fit", "table", "two-taps", "four-taps", "reference"};

const char *const view_compare_names[VIEW_COMPARES + 1] = {"no", "split",
                                                           "difference"};

const char *const view_probe_capture_names[VIEW_PROBE_CAPTURES + 1] = {
    "faces", "paraboloids"};
