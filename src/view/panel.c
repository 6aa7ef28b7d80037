/* SPDX-License-Identifier: MIT */
/* Controls for the mouse. A choice is what its keys do; a slider sets a number
 * itself. */
#include "view/app.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "common/process.h"
#include "view/inspect.h"
#include "view/key_bindings.h"
#include "view/message.h"

static const double MARGIN = 8; /* pixels, at display scale 1 */
static const double TEXT = 2;   /* scale of text, at display scale 1 */

/* Columns, in pixels at a text scale of 1: values begin at a tab. */
enum {
    VALUE = VIEW_TEXT_TAB,
    SLIDER = VALUE + 42,
    WIDTH = VALUE + 100,
    TEXT_BYTES = 4096
};

/* ---- rows --------------------------------------------------------------- */

static bool is_shown(const view_app *app, const view_control *c)
{
    return c->modes >> app->settings.mode & 1;
}

static void value_text(view_settings s, const view_control *c, char text[64])
{
    const void *field = view_control_field(c, &s);

    if (c->change == VIEW_SLIDES)
        snprintf(text, 64, "%.4g", *(const double *)field);
    else if (c->change == VIEW_SWITCHES)
        snprintf(text, 64, "%s", *(const bool *)field ? "on" : "off");
    else if (c->change == VIEW_COUNTS)
        snprintf(text, 64, "%d", *(const int *)field);
    else
        snprintf(text, 64, "%s",
                 c->names ? c->names[*(const int *)field]
                          : view_materials[*(const int *)field].name);
}

/* ---- places ------------------------------------------------------------- */

/* Of the panel in pixels: the upper left corner of its text. */
typedef struct place {
    double x, y, scale;
} place;

/* Lines above the rows. */
static int heads(const view_app *app)
{
    return view_shows_materials(&app->settings) && app->other.name ? 2 : 1;
}

static place place_of(const view_app *app)
{
    const double margin = MARGIN * app->scale;
    const double top =
        margin + (app->settings.false_colour ? 32 * TEXT * app->scale : 0);
    int lines = heads(app);
    place p = {.scale = TEXT * app->scale};

    for (const view_control *c = view_controls; c->key; c++)
        lines += app->settings.panel && is_shown(app, c);
    const double width = WIDTH + 2 * VIEW_TEXT_MARGIN;
    const double height = VIEW_TEXT_LINE * lines + 2 * VIEW_TEXT_MARGIN;
    p.scale = fmin(p.scale, (app->height - top - margin) / height);
    p.scale = fmax(fmin(p.scale, 0.4 * app->width / width), 0.25);
    p.x = floor(app->width - margin - width * p.scale + 0.5);
    p.y = floor(top + 0.5);
    return p;
}

double view_panel_share(const view_app *app)
{
    return app->settings.panel ? 1 - place_of(app).x / app->width : 0;
}

/* The row at the pointer, -1 for the title or -2 for none; *x: the place in it,
 * at a scale of 1. */
static int find(const view_app *app, double *x)
{
    const place p = place_of(app);
    const double y = (app->mouse[1] - p.y) / p.scale - VIEW_TEXT_MARGIN;
    int line = (int)floor(y / VIEW_TEXT_LINE) - heads(app);

    *x = (app->mouse[0] - p.x) / p.scale - VIEW_TEXT_MARGIN;
    if (*x < -VIEW_TEXT_MARGIN || *x > WIDTH + VIEW_TEXT_MARGIN ||
        y < -VIEW_TEXT_MARGIN)
        return -2;
    if (line < 0)
        return -1;
    for (int i = 0; view_controls[i].key && app->settings.panel; i++)
        if (is_shown(app, &view_controls[i]) && line-- == 0)
            return i;
    return -2;
}

/* ---- drawing ------------------------------------------------------------ */

static void add_slider(const view_app *app, const place *p,
                       const view_control *c, int line)
{
    view_settings s = app->settings;
    const double value = *(double *)view_control_field(c, &s);
    const double share = (value - c->low) / (c->high - c->low);
    const double top = VIEW_TEXT_MARGIN + VIEW_TEXT_LINE * line;

    view_overlay_bar(app->overlay,
                     p->x + (VIEW_TEXT_MARGIN + SLIDER) * p->scale,
                     p->y + (top + 1) * p->scale, (WIDTH - SLIDER) * p->scale,
                     (VIEW_TEXT_LINE - 5) * p->scale, share);
}

/* Names what the sides are drawn by. */
static void add_sides(const view_app *app, char *text, size_t size)
{
    const view_options *o = app->options;

    view_add(text, size, "A %s\tB %s\n",
             view_path_end(*app->path ? app->path : o->request.path, 14),
             view_path_end(o->against_set, 14));
}

static void write_panel(const view_app *app, char *text, size_t size)
{
    snprintf(text, size, "controls\tP hides them\t\n");
    if (heads(app) > 1)
        add_sides(app, text, size);
    for (const view_control *c = view_controls; c->key; c++) {
        const bool both = c->change == VIEW_CYCLES || c->change == VIEW_COUNTS;
        char value[64];
        if (!is_shown(app, c))
            continue;
        value_text(app->settings, c, value);
        view_add(text, size, both ? "%s\t< %.16s >\n" : "%s\t%s\n", c->label,
                 value);
    }
}

/* Appends what is not as it is by default. */
static void add_changes(const view_app *app, char *text, size_t size)
{
    const view_settings usual = view_settings_default();

    for (const view_control *c = view_controls; c->key; c++) {
        char value[64], before[64];
        if (!is_shown(app, c))
            continue;
        value_text(app->settings, c, value);
        value_text(usual, c, before);
        if (strcmp(value, before) != 0)
            view_add(text, size, " | %s %s", c->label, value);
    }
}

void view_panel_draw(const view_app *app)
{
    const place p = place_of(app);
    char text[TEXT_BYTES];
    int line = heads(app);

    if (!app->settings.panel) {
        if (app->mouse[0] > 0.5 * app->width &&
            app->mouse[1] < 0.25 * app->height)
            view_overlay_text(app->overlay, p.x, p.y, p.scale,
                              "\tcontrols: P\t");
        return;
    }
    write_panel(app, text, sizeof text);
    view_overlay_text(app->overlay, p.x, p.y, p.scale, text);
    for (const view_control *c = view_controls; c->key; c++) {
        if (is_shown(app, c) && c->change == VIEW_SLIDES)
            add_slider(app, &p, c, line);
        line += is_shown(app, c);
    }
}

/* ---- the pointer -------------------------------------------------------- */

static void slide(view_app *app, const view_control *c, double x)
{
    const double share = fmin(fmax((x - SLIDER) / (WIDTH - SLIDER), 0), 1);
    const double value = c->low + share * (c->high - c->low);

    /* 0 is not -0. */
    *(double *)view_control_field(c, &app->settings) =
        c->by * round(value / c->by) + 0.0;
}

bool view_panel_point(view_app *app, bool drag)
{
    double x;
    const int i = find(app, &x);
    const view_control *c = &view_controls[i < 0 ? 0 : i];

    if (drag) {
        slide(app, &view_controls[app->dragged - 1], x);
        return true;
    }
    if (i == -2 || (i == -1 && !app->settings.panel && x < VALUE))
        return false;
    if (i == -1)
        app->settings.panel = !app->settings.panel;
    else if (c->change != VIEW_SLIDES)
        view_keys_press(app, x < VALUE + 12 && c->back ? c->back : c->key);
    else if (x >= SLIDER) {
        app->dragged = i + 1;
        slide(app, c, x);
    }
    return true;
}

/* ---- the rest of the text ------------------------------------------------ */

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
    add_changes(app, text, size);
    view_add(text, size, " | %.1f ms", app->frame_ms);
}
