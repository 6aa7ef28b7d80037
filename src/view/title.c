/* SPDX-License-Identifier: MIT */
#include "view/title.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "common/line.h"
#include "view/sphere_grid.h"
#include "view/truth.h"

static void add(char *text, size_t size, const char *fmt, ...)
    __attribute__((format(printf, 3, 4)));
static void add(char *text, size_t size, const char *fmt, ...)
{
    const size_t used = strlen(text);
    va_list ap;

    va_start(ap, fmt);
    vsnprintf(text + used, size - used, fmt, ap);
    va_end(ap);
}

/* Of rows or columns, where it is not the usual one. */
static void add_range(const char *name, const double range[2], char *text,
                      size_t size)
{
    if (range[0] > 0 || range[1] < 1)
        add(text, size, " | %s %.3g:%.3g", name, range[0], range[1]);
}

/* A number, where it is not the usual one. */
static void add_number(const char *name, double x, double usual, char *text,
                       size_t size)
{
    if (x < usual || x > usual)
        add(text, size, " | %s %.4g", name, x);
}

/* How the environment is turned, and from where it is looked at. */
static void add_aim(const view_settings *s, char *text, size_t size)
{
    const view_settings usual = view_settings_default();

    add_number("turn", s->turn, usual.turn, text, size);
    add_number("yaw", s->yaw, usual.yaw, text, size);
    add_number("pitch", s->pitch, usual.pitch, text, size);
    add_number("distance", s->distance, usual.distance, text, size);
    add_number("fov", s->fov, usual.fov, text, size);
}

static void add_spheres(const view_app *app, char *text, size_t size)
{
    const view_settings *s = &app->settings;

    add(text, size, " | %s %dx%d | fresnel %s | diffuse %s | multiscatter %s",
        view_materials[s->material].name, s->rows, s->columns,
        view_fresnel_names[s->fresnel], view_diffuse_names[s->diffuse],
        s->multiscatter ? "on" : "off");
    add_range("metallic", s->metallic, text, size);
    add_range("roughness", s->roughness, text, size);
    if (s->light_count)
        add(text, size, " | lights %d", s->light_count);
    add_aim(s, text, size);
    if (!s->sky)
        add(text, size, " | no sky");
    if (s->compare == VIEW_SPLIT_SUM)
        return;
    add(text, size, " | %s %d/%d", view_compare_names[s->compare],
        view_renderer_samples(app->renderer), VIEW_TRUTH_SAMPLES);
    if (s->compare == VIEW_SPLIT)
        add(text, size, " at %.3g", s->split);
    if (s->compare == VIEW_DIFFERENCE)
        add(text, size, " x %.4g", s->gain);
}

static void add_map(const view_app *app, char *text, size_t size)
{
    const view_settings *s = &app->settings;

    add(text, size, " | %s", view_mode_names[s->mode]);
    if (s->mode == VIEW_LEVELS)
        add(text, size, " %d, roughness %.3g", s->level,
            app->set->roughness[s->level]);
    if (s->mode != VIEW_TABLE)
        add(text, size, " | %s", view_layout_names[s->layout]);
    add(text, size, " | zoom %.3g", s->zoom);
    if (s->pan[0] < 0 || s->pan[0] > 0 || s->pan[1] < 0 || s->pan[1] > 0)
        add(text, size, " | pan %.3g,%.3g", s->pan[0], s->pan[1]);
}

/* The parts of the one in use, and what the other one took. */
static void add_times(const view_scene *stage, view_probe_filter filter,
                      bool parts, char *text, size_t size)
{
    double ms[3];

    if (!view_scene_times(stage, filter, ms))
        return;
    add(text, size, " | %s %.1f ms", view_probe_filter_names[filter],
        ms[0] + ms[1] + ms[2]);
    if (parts)
        add(text, size, ": drawing %.1f levels %.1f irradiance %.1f", ms[0],
            ms[1], ms[2]);
}

static void add_scene(const view_app *app, char *text, size_t size)
{
    const view_settings *s = &app->settings;
    const view_scene *stage = view_renderer_stage(app->renderer);
    const view_room_locals *baked =
        app->probes ? view_probe_set_locals(app->probes) : NULL;

    add(text, size,
        " | scene | parallax %s | blend %s | local %d%s | probe %d, %s, %s, "
        "%.3g s",
        s->parallax ? "on" : "off", s->blend ? "on" : "off",
        baked ? baked->count : s->probes, baked ? " of a file" : "",
        s->probe_size, view_probe_capture_names[s->probe_capture],
        view_probe_filter_names[s->probe_filter], s->probe_interval);
    if (s->probe_faces)
        add(text, size, " | faces %d", s->probe_faces);
    add(text, size, "%s%s%s%s", s->probe_limit ? " | limit" : "",
        s->volumes ? " | volumes" : "", s->sun ? "" : " | no sun",
        s->capture_shadows ? "" : " | no capture shadows");
    add_aim(s, text, size);
    if (!stage)
        return;
    for (int i = 0; i < VIEW_PROBE_FILTERS; i++)
        add_times(stage, (view_probe_filter)i, i == (int)s->probe_filter, text,
                  size);
}

void view_title_text(const view_app *app, char *text, size_t size)
{
    const view_settings *s = &app->settings;

    snprintf(text, size, "iblview");
    if (!app->set)
        return;
    snprintf(text, size, "%s", app->set->name);
    ibl_one_line(text);
    if (s->mode == VIEW_SPHERES)
        add_spheres(app, text, size);
    else if (s->mode == VIEW_SCENE)
        add_scene(app, text, size);
    else
        add_map(app, text, size);
    add(text, size, " | EV %+.4g | %s", s->ev,
        s->false_colour ? "false colour" : view_tone_names[s->tone]);
    add(text, size, " | %.1f ms", app->frame_ms);
}
