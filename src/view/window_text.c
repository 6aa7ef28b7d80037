/* SPDX-License-Identifier: MIT */
#include "view/app.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "common/stderr_line.h"
#include "view/inspect.h"
#include "view/key_bindings.h"

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

void view_app_title(view_app *app)
{
    const size_t size = sizeof app->title;
    char *text = app->title;

    snprintf(text, size, "%s", app->set ? app->set->name : "iblview");
    if (!app->set)
        return;
    ibl_one_line(text);
    view_panel_title(app, text, size);
    const size_t used = strlen(text);
    snprintf(text + used, size - used, " | %.1f ms", app->frame_ms);
}
