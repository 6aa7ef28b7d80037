/* SPDX-License-Identifier: MIT */
#include "view/app.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "common/path.h"
#include "common/stderr_line.h"
#include "view/inspect.h"
#include "view/key_bindings.h"
#include "view/truth.h"

static const double MARGIN = 8; /* pixels, at display scale 1 */
static const double TEXT = 2;   /* scale of text, at display scale 1 */

/* The scale at which a text, of that size at `scale`, fits in room. */
static double fit(double scale, double size, double room)
{
    return size > room && room > 0 ? scale * room / size : scale;
}

static void add_keys(view_app *app)
{
    const double margin = MARGIN * app->scale;
    char text[VIEW_KEYS_BYTES];
    double w, h, size = TEXT * app->scale;

    view_keys_text(text, sizeof text);
    view_overlay_measure(text, size, &w, &h);
    size = fmin(fit(size, h, app->height - 2 * margin),
                fit(size, w, app->width - 2 * margin));
    view_overlay_text(app->overlay, margin, margin, size, text);
}

/* The scale at which a line of text is at most as wide as the window; *w, *h:
 * its size in pixels. */
static double fit_line(const view_app *app, const char *text, double *w,
                       double *h)
{
    double size = TEXT * app->scale;

    view_overlay_measure(text, size, w, h);
    size = fit(size, *w, app->width - 2 * MARGIN * app->scale);
    view_overlay_measure(text, size, w, h);
    return size;
}

static void add_progress(view_app *app)
{
    const double bar_width = 0.5 * app->width, bar_height = 12 * app->scale;
    char text[400];
    double w, h;

    snprintf(text, sizeof text, "baking %.300s: %s", app->baking, app->stage);
    ibl_one_line(text);
    const double size = fit_line(app, text, &w, &h);
    view_overlay_text(app->overlay, 0.5 * (app->width - w),
                      0.5 * app->height - h - bar_height, size, text);
    view_overlay_bar(app->overlay, 0.5 * (app->width - bar_width),
                     0.5 * app->height, bar_width, bar_height, app->baked);
}

/* Draws a line of text at the lower left, above `below`; returns its upper
 * edge. */
static double add_line(view_app *app, double below, const char *text)
{
    double w, h;
    const double size = fit_line(app, text, &w, &h);

    view_overlay_text(app->overlay, MARGIN * app->scale, below - h, size, text);
    return below - h;
}

void view_window_text(view_app *app)
{
    const double margin = MARGIN * app->scale;
    const view_settings *s = &app->settings;
    double below = app->height - margin;
    char text[200];

    view_overlay_begin(app->overlay, app->width, app->height);
    if (app->set) {
        const view_texel t = view_inspect(app->set, s, app->width, app->height,
                                          app->mouse[0], app->mouse[1]);
        view_texel_text(&t, text, sizeof text);
        if (t.inside && !s->help)
            below = add_line(app, below, text);
        if (s->false_colour)
            view_overlay_legend(app->overlay, 0.5 * app->width, margin,
                                0.5 * app->width - margin, TEXT * app->scale,
                                0);
    }
    if (app->set && !s->help)
        view_panel_draw(app);
    if (app->notice[0])
        add_line(app, below, app->notice);
    if (app->baker)
        add_progress(app);
    if (s->help)
        add_keys(app);
    view_overlay_end(app->overlay);
}

static void append(view_app *app, const char *fmt, ...)
    __attribute__((format(printf, 2, 3)));
static void append(view_app *app, const char *fmt, ...)
{
    const size_t used = strlen(app->title);
    va_list ap;

    va_start(ap, fmt);
    vsnprintf(app->title + used, sizeof app->title - used, fmt, ap);
    va_end(ap);
}

/* Adds a range of rows or columns unless it is the default. */
static void add_range(view_app *app, const char *name, const double range[2])
{
    if (range[0] > 0 || range[1] < 1)
        append(app, " | %s %.3g:%.3g", name, range[0], range[1]);
}

/* Adds a number unless it is the default. */
static void add_number(view_app *app, const char *name, double x, double usual)
{
    if (x < usual || x > usual)
        append(app, " | %s %.4g", name, x);
}

/* Adds the turn of the environment and the camera. */
static void add_aim(view_app *app)
{
    const view_settings usual = view_settings_default(), *s = &app->settings;

    add_number(app, "turn", s->turn, usual.turn);
    add_number(app, "yaw", s->yaw, usual.yaw);
    add_number(app, "pitch", s->pitch, usual.pitch);
    add_number(app, "distance", s->distance, usual.distance);
    add_number(app, "fov", s->fov, usual.fov);
}

static void add_spheres(view_app *app)
{
    const view_settings *s = &app->settings;

    if (s->mode == VIEW_MODEL && app->model)
        append(app, " | %.80s", ibl_path_name(app->model_path));
    else if (s->mode == VIEW_MODEL)
        append(app, " | %s ball", view_materials[s->material].name);
    else
        append(app, " | %s %dx%d", view_materials[s->material].name, s->rows,
               s->columns);
    append(app, " | diffuse %s | multiscatter %s",
           view_diffuse_names[s->diffuse], s->multiscatter ? "on" : "off");
    add_range(app, "metallic", s->metallic);
    add_range(app, "roughness", s->roughness);
    if (s->light_count)
        append(app, " | lights %d", s->light_count);
    add_aim(app);
    if (!s->sky)
        append(app, " | no sky");
    append(app, " | %s", view_reflection_names[s->reflection]);
    if (s->compare != VIEW_ALONE)
        append(app, " and %s, %s", view_reflection_names[s->against],
               view_compare_names[s->compare]);
    if (s->compare == VIEW_SPLIT)
        append(app, " at %.3g", s->split);
    if (s->compare == VIEW_DIFFERENCE)
        append(app, " x %.4g", s->gain);
    if (view_wants_reference(s))
        append(app, " | %d/%d", view_renderer_samples(app->renderer),
               VIEW_TRUTH_SAMPLES);
}

static void add_map(view_app *app)
{
    const view_settings *s = &app->settings;

    append(app, " | %s", view_mode_names[s->mode]);
    if (s->mode == VIEW_LEVELS)
        append(app, " %d, roughness %.3g", s->level,
               app->set->roughness[s->level]);
    if (s->mode != VIEW_TABLE)
        append(app, " | %s", view_layout_names[s->layout]);
    append(app, " | zoom %.3g", s->zoom);
    if (s->pan[0] < 0 || s->pan[0] > 0 || s->pan[1] < 0 || s->pan[1] > 0)
        append(app, " | pan %.3g,%.3g", s->pan[0], s->pan[1]);
}

/* Adds the times of a filter; in parts if it is in use. */
static void add_times(view_app *app, const view_scene *stage,
                      view_probe_filter filter)
{
    const view_scene_state *state = view_scene_state_of(stage);
    const double *ms = state->ms[filter];

    if (!state->timed[filter])
        return;
    append(app, " | %s %.1f ms", view_probe_filter_names[filter],
           ms[0] + ms[1] + ms[2]);
    if (filter == app->settings.probe_filter)
        append(app, ": drawing %.1f levels %.1f irradiance %.1f", ms[0], ms[1],
               ms[2]);
}

static void add_scene(view_app *app)
{
    const view_settings *s = &app->settings;
    const view_scene *stage = view_renderer_stage(app->renderer);
    const view_probe_maps *baked =
        app->probes ? view_probe_set_locals(app->probes) : NULL;

    append(app,
           " | scene | parallax %s | blend %s | local %d%s | probe %d, %s, %s, "
           "%.3g s",
           s->parallax ? "on" : "off", s->blend ? "on" : "off",
           baked ? baked->count : s->probes, baked ? " of a file" : "",
           s->probe_size, view_probe_capture_names[s->probe_capture],
           view_probe_filter_names[s->probe_filter], s->probe_interval);
    if (s->probe_faces)
        append(app, " | faces %d", s->probe_faces);
    append(app, "%s%s%s%s%s", s->walls ? "" : " | no walls",
           s->probe_limit ? " | limit" : "", s->volumes ? " | volumes" : "",
           s->sun ? "" : " | no sun",
           s->capture_shadows ? "" : " | no capture shadows");
    add_aim(app);
    if (!stage)
        return;
    for (int i = 0; i < VIEW_PROBE_FILTERS; i++)
        add_times(app, stage, (view_probe_filter)i);
}

void view_app_title(view_app *app)
{
    const view_settings *s = &app->settings;

    snprintf(app->title, sizeof app->title, "%s",
             app->set ? app->set->name : "iblview");
    if (!app->set)
        return;
    ibl_one_line(app->title);
    if (view_shows_materials(s))
        add_spheres(app);
    else if (s->mode == VIEW_SCENE)
        add_scene(app);
    else
        add_map(app);
    append(app, " | EV %+.4g | %s", s->ev,
           s->false_colour ? "false colour" : view_tone_names[s->tone]);
    append(app, " | %.1f ms", app->frame_ms);
}
