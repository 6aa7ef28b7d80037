/* SPDX-License-Identifier: MIT */
#include "view/window_text.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "common/line.h"
#include "view/inspect.h"
#include "view/key_bindings.h"

static const double MARGIN = 8; /* pixels of a display without a scale */
static const double TEXT = 2;   /* scale of text there */

/* A scale at which a text that is as large at another one has room. */
static double fit(double scale, double size, double room)
{
    return size > room && room > 0 ? scale * room / size : scale;
}

/* In two columns: keys, then what they do. Letters are of different widths,
 * so each column is a plate of its own. */
static void add_keys(view_app *app, double scale, int width, int height)
{
    enum {
        COLUMN = 16
    };
    char text[VIEW_KEYS_BYTES], left[VIEW_KEYS_BYTES] = "",
                                right[VIEW_KEYS_BYTES] = "";
    double w, more, h, size = TEXT * scale;

    view_keys_text(text, sizeof text);
    for (char *line = strtok(text, "\n"); line; line = strtok(NULL, "\n")) {
        strncat(left, line, COLUMN);
        strcat(left, "\n");
        strcat(strcat(right, line + COLUMN), "\n");
    }
    left[strlen(left) - 1] = right[strlen(right) - 1] = '\0';
    view_overlay_measure(right, size, &more, &h);
    view_overlay_measure(left, size, &w, &h);
    size = fmin(fit(size, h, height - 2 * MARGIN * scale),
                fit(size, w + more, width - 2 * MARGIN * scale));
    view_overlay_measure(left, size, &w, &h);
    view_overlay_text(app->overlay, MARGIN * scale, MARGIN * scale, size, left);
    view_overlay_text(app->overlay, MARGIN * scale + w, MARGIN * scale, size,
                      right);
}

static void add_progress(view_app *app, double scale, int width, int height)
{
    char text[400];
    double w, h, size = TEXT * scale;
    const double bar_width = 0.5 * width, bar_height = 12 * scale;

    snprintf(text, sizeof text, "baking %s: %s", app->baking, app->stage);
    ibl_one_line(text);
    view_overlay_measure(text, size, &w, &h);
    size = fit(size, w, width - 2 * MARGIN * scale);
    view_overlay_measure(text, size, &w, &h);
    view_overlay_text(app->overlay, 0.5 * (width - w),
                      0.5 * height - h - bar_height, size, text);
    view_overlay_bar(app->overlay, 0.5 * (width - bar_width), 0.5 * height,
                     bar_width, bar_height, app->baked);
}

/* A line of text at the lower left, above what is there already. */
static double add_line(view_app *app, double scale, int width, double below,
                       const char *text)
{
    double w, h, size = TEXT * scale;

    view_overlay_measure(text, size, &w, &h);
    size = fit(size, w, width - 2 * MARGIN * scale);
    view_overlay_measure(text, size, &w, &h);
    view_overlay_text(app->overlay, MARGIN * scale, below - h, size, text);
    return below - h;
}

void view_window_text(view_app *app, int width, int height)
{
    const double scale = view_screen_scale(app->screen);
    const view_settings *s = &app->settings;
    double below = height - MARGIN * scale;
    char text[200];

    if (app->set) {
        const view_texel t = view_inspect(app->set, s, width, height,
                                          app->mouse[0], app->mouse[1]);
        view_texel_text(&t, text, sizeof text);
        if (t.inside && !s->help)
            below = add_line(app, scale, width, below, text);
        if (s->false_colour)
            view_overlay_legend(app->overlay, 0.5 * width, MARGIN * scale,
                                0.5 * width - MARGIN * scale, TEXT * scale);
    }
    if (app->notice[0])
        add_line(app, scale, width, below, app->notice);
    if (app->baker)
        add_progress(app, scale, width, height);
    if (s->help)
        add_keys(app, scale, width, height);
}
