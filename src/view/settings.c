/* SPDX-License-Identifier: MIT */
#include "view/settings.h"

/* Lights that a user switches on stand at the corners of the default grid,
 * before it; each gives about as much as a bright overcast sky. */
static const double lamp = 60;

view_settings view_settings_default(void)
{
    view_settings s = {
        .mode = VIEW_SPHERES,
        .rows = 7,
        .columns = 7,
        .metallic = {0, 1},
        .roughness = {0, 1},
        .fresnel = VIEW_FRESNEL_TABLE,
        .diffuse = VIEW_DIFFUSE_MAP,
        .multiscatter = true,
        .fov = 30,
        .sky = true,
        .tone = VIEW_TONE_NEUTRAL,
        .layout = VIEW_CROSS,
        .zoom = 1,
        .compare = VIEW_SPLIT_SUM,
        .split = 0.5,
        .gain = 10,
        .parallax = true,
        .probe_size = 256,
        .probe_interval = 0.5,
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

const char *view_mode_name(view_mode mode)
{
    static const char *const names[VIEW_MODES] = {
        "spheres", "levels", "irradiance", "table", "scene"};
    return names[mode];
}

const char *view_layout_name(view_layout layout)
{
    static const char *const names[VIEW_LAYOUTS] = {"cross", "strip",
                                                    "equirect"};
    return names[layout];
}

const char *view_tone_name(view_tone tone)
{
    static const char *const names[VIEW_TONES] = {"linear", "reinhard", "aces",
                                                  "neutral"};
    return names[tone];
}

const char *view_fresnel_name(view_fresnel fresnel)
{
    static const char *const names[VIEW_FRESNELS] = {"table", "lagarde"};
    return names[fresnel];
}

const char *view_diffuse_name(view_diffuse diffuse)
{
    static const char *const names[VIEW_DIFFUSES] = {"map", "sh"};
    return names[diffuse];
}

const char *view_compare_name(view_compare compare)
{
    static const char *const names[VIEW_COMPARES] = {"split-sum", "reference",
                                                     "split", "difference"};
    return names[compare];
}

const char *view_probe_capture_name(view_probe_capture capture)
{
    static const char *const names[VIEW_PROBE_CAPTURES] = {"faces",
                                                           "paraboloids"};
    return names[capture];
}

const char *view_probe_filter_name(view_probe_filter filter)
{
    static const char *const names[VIEW_PROBE_FILTERS] = {"gpu", "cpu"};
    return names[filter];
}
