/* SPDX-License-Identifier: MIT */
/* Controls for the mouse. A choice is what its keys do; a slider sets a number
 * itself. */
#include "view/app.h"

#include <math.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>

#include "view/key_bindings.h"

static const double MARGIN = 8; /* pixels, at display scale 1 */
static const double TEXT = 2;   /* scale of text, at display scale 1 */

/* Columns, in pixels at a text scale of 1: values begin at a tab. */
enum {
    VALUE = VIEW_TEXT_TAB,
    SLIDER = VALUE + 42,
    WIDTH = VALUE + 100,
    ROW_BYTES = 128
};

/* How a row shows its setting. */
typedef enum kind {
    CHOICE, /* an enumeration with names */
    COUNT,  /* an int */
    SWITCH, /* a bool */
    SLIDE   /* a double */
} kind;

typedef struct row {
    const char *label;
    kind kind;
    size_t offset;
    int key, back;            /* that change it: for view_keys_press */
    const char *const *names; /* of a choice; NULL: materials */
    double low, high, step;   /* of a slider */
    unsigned modes;           /* bits of view_mode */
} row;

#define FIELD(field) offsetof(view_settings, field)
#define PICK(field, key, back, names) CHOICE, FIELD(field), key, back, names
#define NUMBER(field, key, back) COUNT, FIELD(field), key, back
#define ON(field, key) SWITCH, FIELD(field), key, key
#define DRAG(field, lo, hi, by)                                                \
    SLIDE, FIELD(field), .low = (lo), .high = (hi), .step = (by)
enum {
    SPHERES = 1 << VIEW_SPHERES,
    MATERIALS = SPHERES | 1 << VIEW_MODEL,
    SCENE = 1 << VIEW_SCENE,
    MAPS = 1 << VIEW_LEVELS | 1 << VIEW_IRRADIANCE_MAP,
    ALL = ~0
};

static const row rows[] = {
    {"mode", PICK(mode, 'm', 'M', view_mode_names), .modes = (unsigned)ALL},
    {"material", PICK(material, 'n', 'N', NULL), .modes = MATERIALS},
    {"roughness from", DRAG(roughness[0], 0, 1, 0.01), .modes = MATERIALS},
    {"roughness to", DRAG(roughness[1], 0, 1, 0.01), .modes = MATERIALS},
    {"metallic from", DRAG(metallic[0], 0, 1, 0.01), .modes = SPHERES},
    {"metallic to", DRAG(metallic[1], 0, 1, 0.01), .modes = MATERIALS},
    {"columns", NUMBER(columns, '}', '{'), .modes = SPHERES},
    {"rows", NUMBER(rows, ')', '('), .modes = SPHERES},
    {"reflection", PICK(reflection, 'r', 'R', view_reflection_names),
     .modes = MATERIALS},
    {"compare", PICK(compare, 'f', 'F', view_compare_names),
     .modes = MATERIALS},
    {"against", PICK(against, 'D', 'D', view_reflection_names),
     .modes = MATERIALS},
    {"split", DRAG(split, 0, 1, 0.01), .modes = MATERIALS},
    {"diffuse", PICK(diffuse, 'd', 'd', view_diffuse_names),
     .modes = MATERIALS},
    {"lights", NUMBER(light_count, 'i', 'I'), .modes = MATERIALS},
    {"level", NUMBER(level, ']', '['), .modes = 1 << VIEW_LEVELS},
    {"layout", PICK(layout, 'l', 'L', view_layout_names), .modes = MAPS},
    {"probes", NUMBER(probes, 'h', 'H'), .modes = SCENE},
    {"parallax", ON(parallax, 'x'), .modes = SCENE},
    {"walls", ON(walls, 'X'), .modes = SCENE},
    {"volumes", ON(volumes, 'V'), .modes = SCENE},
    {"sun", ON(sun, 'Z'), .modes = SCENE},
    {"environment", DRAG(turn, -180, 180, 1), .modes = (unsigned)(ALL & ~MAPS)},
    {"sky", ON(sky, 'b'), .modes = MATERIALS},
    {"exposure", DRAG(ev, -8, 8, 0.05), .modes = (unsigned)ALL},
    {"tone", PICK(tone, 't', 'T', view_tone_names), .modes = (unsigned)ALL},
    {"false colour", ON(false_colour, 'v'), .modes = (unsigned)ALL},
};
enum {
    ROWS = sizeof rows / sizeof *rows
};

/* ---- rows --------------------------------------------------------------- */

static bool is_shown(const view_app *app, const row *r)
{
    return r->modes >> app->settings.mode & 1;
}

static double *number_of(view_settings *s, const row *r)
{
    return (double *)(void *)((char *)s + r->offset);
}

static void value_text(const view_settings *s, const row *r, char text[64])
{
    const char *field = (const char *)s + r->offset;
    int value = 0;
    double number;

    if (r->kind == SLIDE) {
        memcpy(&number, field, sizeof number);
        snprintf(text, 64, "%.3g", number);
        return;
    }
    memcpy(&value, field, r->kind == SWITCH ? 1 : sizeof value);
    if (r->kind == SWITCH)
        snprintf(text, 64, "%s", value ? "on" : "off");
    else if (r->kind == COUNT)
        snprintf(text, 64, "< %d >", value);
    else
        snprintf(text, 64, "< %s >",
                 r->names ? r->names[value] : view_materials[value].name);
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

    for (int i = 0; i < ROWS && app->settings.panel; i++)
        lines += is_shown(app, &rows[i]);
    const double width = WIDTH + 2 * VIEW_TEXT_MARGIN;
    const double height = VIEW_TEXT_LINE * lines + 2 * VIEW_TEXT_MARGIN;
    p.scale = fmin(p.scale, (app->height - top - margin) / height);
    p.scale = fmax(fmin(p.scale, 0.4 * app->width / width), 0.25);
    p.x = floor(app->width - margin - width * p.scale + 0.5);
    p.y = floor(top + 0.5);
    return p;
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
    for (int i = 0; i < ROWS && app->settings.panel; i++)
        if (is_shown(app, &rows[i]) && line-- == 0)
            return i;
    return -2;
}

/* ---- drawing ------------------------------------------------------------ */

static void add_slider(const view_app *app, const place *p, const row *r,
                       int line)
{
    view_settings s = app->settings;
    const double share = (*number_of(&s, r) - r->low) / (r->high - r->low);
    const double top = VIEW_TEXT_MARGIN + VIEW_TEXT_LINE * line;

    view_overlay_bar(app->overlay,
                     p->x + (VIEW_TEXT_MARGIN + SLIDER) * p->scale,
                     p->y + (top + 1) * p->scale, (WIDTH - SLIDER) * p->scale,
                     (VIEW_TEXT_LINE - 5) * p->scale, share);
}

/* Appends "label<tab>value". */
static void add_line(char *text, size_t size, const char *label,
                     const char *value)
{
    const size_t used = strlen(text);
    snprintf(text + used, size - used, "%s\t%.20s\n", label, value);
}

/* The end of a path, which says more than its beginning. */
static const char *end_of(const char *path)
{
    enum {
        MOST = 14
    };
    const size_t length = strlen(path);
    return path + (length > MOST ? length - MOST : 0);
}

/* Names what the sides are drawn by. */
static void add_sides(const view_app *app, char *text, size_t size)
{
    const view_options *o = app->options;
    char a[20], b[20];

    snprintf(a, sizeof a, "A %s",
             end_of(*app->path ? app->path : o->request.path));
    snprintf(b, sizeof b, "B %s", end_of(o->against_set));
    add_line(text, size, a, b);
}

static void write_panel(const view_app *app, char *text, size_t size)
{
    snprintf(text, size, "controls\tP hides them\t\n");
    if (heads(app) > 1)
        add_sides(app, text, size);
    for (int i = 0; i < ROWS; i++) {
        char value[64];
        if (!is_shown(app, &rows[i]))
            continue;
        value_text(&app->settings, &rows[i], value);
        add_line(text, size, rows[i].label, value);
    }
}

void view_panel_draw(const view_app *app)
{
    const place p = place_of(app);
    char text[ROWS * ROW_BYTES];
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
    for (int i = 0; i < ROWS; i++) {
        if (!is_shown(app, &rows[i]))
            continue;
        if (rows[i].kind == SLIDE)
            add_slider(app, &p, &rows[i], line);
        line++;
    }
}

/* ---- the pointer -------------------------------------------------------- */

static void slide(view_app *app, const row *r, double x)
{
    const double share = fmin(fmax((x - SLIDER) / (WIDTH - SLIDER), 0), 1);
    const double value = r->low + share * (r->high - r->low);

    *number_of(&app->settings, r) = r->step * round(value / r->step);
}

bool view_panel_point(view_app *app, bool drag)
{
    double x;
    const int i = find(app, &x);

    if (drag) {
        slide(app, &rows[app->dragged - 1], x);
        return true;
    }
    if (i == -2 || (i == -1 && !app->settings.panel && x < VALUE))
        return false;
    if (i == -1)
        app->settings.panel = !app->settings.panel;
    else if (rows[i].kind != SLIDE)
        view_keys_press(app, x < VALUE + 12 ? rows[i].back : rows[i].key);
    else if (x >= SLIDER) {
        app->dragged = i + 1;
        slide(app, &rows[i], x);
    }
    return true;
}
