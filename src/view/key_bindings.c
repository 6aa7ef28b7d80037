/* SPDX-License-Identifier: MIT */
#include "view/key_bindings.h"

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <math.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>

#include "view/inspect.h"
#include "view/report.h"
#include "view/scene_captures.h"
#include "view/sphere_grid.h"
#include "view/vector.h"

/* The next of count values, or the previous one for step -1. */
static int next(int value, int step, int count)
{
    return (value + step + count) % count;
}

/* ---- scene -------------------------------------------------------------- */

/* Goes through 0 and the powers of two. */
static void change_probes(view_app *app, int step)
{
    int *n = &app->settings.probes, power = 1;

    if (app->probes) {
        view_app_notice(app, "the %d local probes are of a file",
                        view_probe_set_locals(app->probes)->count);
        return;
    }
    while (step > 0 ? power <= *n : 2 * power < *n)
        power *= 2;
    if (step < 0 && *n <= 1)
        *n = 0;
    else if (power <= VIEW_MAX_LOCALS)
        *n = power;
}

/* ---- camera and environment --------------------------------------------- */

static void move_across(view_app *app, int step)
{
    view_drag(&app->settings, app->set, app->width, app->height,
              -step * app->height / 36.0, 0);
}

static void move_up(view_app *app, int step)
{
    view_drag(&app->settings, app->set, app->width, app->height, 0,
              step * app->height / 36.0);
}

static void approach(view_app *app, int step)
{
    const view_place at = {app->width, app->height, 0.5 * app->width,
                           0.5 * app->height};

    view_approach(&app->settings, app->set, at, step);
}

static void move_light(view_app *app, int step)
{
    view_move_light(&app->settings, 5 * step, 0);
}

static void turn(view_app *app, int step)
{
    view_spin(&app->settings, 5 * step);
}

/* ---- the rest ----------------------------------------------------------- */

static void reset(view_app *app, int step)
{
    (void)step;
    app->settings = app->options->settings;
}

static void take_picture(view_app *app, int step)
{
    (void)step;
    view_app_picture(app);
}

static void print_errors(view_app *app, int step)
{
    (void)step;
    if (!view_report_print(app->renderer, &app->settings))
        view_app_notice(app, "no errors yet: compare (f)");
}

static void quit(view_app *app, int step)
{
    (void)step;
    app->quit = true;
}

/* ---- the table ----------------------------------------------------------- */

enum {
    SPHERES = 1 << VIEW_SPHERES,
    MATERIALS = SPHERES | 1 << VIEW_MODEL,
    SCENE = 1 << VIEW_SCENE,
    MAPS = 1 << VIEW_LEVELS | 1 << VIEW_IRRADIANCE_MAP,
    LEVELS = 1 << VIEW_LEVELS,
    TABLE = 1 << VIEW_TABLE,
    ALL = MATERIALS | SCENE | MAPS | TABLE
};

#define ACT(function) .act = (function)
#define CHANGE(how, field)                                                     \
    .change = VIEW_##how, .offset = offsetof(view_settings, field)
#define SWITCH(field) CHANGE(SWITCHES, field)
#define CYCLE(field, count) CHANGE(CYCLES, field), .high = (count)
#define COUNT(field, lo, hi) CHANGE(COUNTS, field), .low = (lo), .high = (hi)
#define ADD(field, step, lo, hi)                                               \
    CHANGE(ADDS, field), .by = (step), .low = (lo), .high = (hi)
#define MULTIPLY(field, factor, lo, hi)                                        \
    CHANGE(MULTIPLIES, field), .by = (factor), .low = (lo), .high = (hi)
#define NAMED(code) VIEW_KEY(GLFW_KEY_##code)
/* On the panel. */
#define SHOWN(in, name) .modes = (in), .label = (name)
#define CHOICE(in, name, list) SHOWN(in, name), .names = (list)
#define SLIDER(in, name, field, lo, hi, step)                                  \
    {                                                                          \
        .key = -1, CHANGE(SLIDES, field), .low = (lo), .high = (hi),           \
        .by = (step), SHOWN(in, name)                                          \
    }

/* clang-format off */
const view_control view_controls[] = {
    {"m M", "mode: spheres, levels, irradiance, table, scene, model", 'm', 'M',
     CYCLE(mode, VIEW_MODES), CHOICE(ALL, "mode", view_mode_names)},
    {"Tab", "the same; back with Shift", NAMED(TAB), VIEW_KEY_BACK_TAB,
     CYCLE(mode, VIEW_MODES)},
    {"l L", "layout: cross, strip, equirect", 'l', 'L',
     CYCLE(layout, VIEW_LAYOUTS), CHOICE(MAPS, "layout", view_layout_names)},
    {"] [", "next level, the one before", ']', '[',
     COUNT(level, 0, IBL_MAX_LEVELS - 1), SHOWN(LEVELS, "level")},
    {"a A", "next layer of an array, the one before", 'a', 'A',
     COUNT(layer, 0, VIEW_MAX_LAYER)},
    {"r R", "reflection: split sum, bent, fit, table, taps, reference", 'r',
     'R', CYCLE(reflection, VIEW_REFLECTIONS),
     CHOICE(MATERIALS, "reflection", view_reflection_names)},
    {"f F", "compare: no, side by side, difference", 'f', 'F',
     CYCLE(compare, VIEW_COMPARES),
     CHOICE(MATERIALS, "compare", view_compare_names)},
    {"D", "what it is compared with", 'D', CYCLE(against, VIEW_REFLECTIONS),
     CHOICE(MATERIALS, "against", view_reflection_names)},
    {"s S", "move the split right, left", 's', 'S', ADD(split, 0.05, 0, 1)},
    SLIDER(MATERIALS, "split", split, 0, 1, 0.01),
    {"g G", "more gain of the difference, less", 'g', 'G',
     MULTIPLY(gain, 2, 1e-3, 1e6)},
    {"1 to 9", "material", '1', .last = '9', CHANGE(CYCLES, material)},
    {"n N", "next material, the one before", 'n', 'N',
     CYCLE(material, VIEW_MATERIALS), SHOWN(MATERIALS, "material")},
    {"} {", "more columns, fewer", '}', '{', COUNT(columns, 1, VIEW_MAX_GRID),
     SHOWN(SPHERES, "columns")},
    {") (", "more rows, fewer", ')', '(', COUNT(rows, 1, VIEW_MAX_GRID),
     SHOWN(SPHERES, "rows")},
    SLIDER(SPHERES, "metallic from", metallic[0], 0, 1, 0.01),
    SLIDER(MATERIALS, "metallic to", metallic[1], 0, 1, 0.01),
    SLIDER(MATERIALS, "roughness from", roughness[0], 0, 1, 0.01),
    SLIDER(MATERIALS, "roughness to", roughness[1], 0, 1, 0.01),
    {"d", "diffuse: map, spherical harmonics", 'd',
     CYCLE(diffuse, VIEW_DIFFUSES),
     CHOICE(MATERIALS, "diffuse", view_diffuse_names)},
    {"c", "multiple scattering", 'c', SWITCH(multiscatter)},
    {"i I", "more point lights, fewer", 'i', 'I',
     COUNT(light_count, 0, VIEW_MAX_LIGHTS), SHOWN(MATERIALS, "lights")},
    {"x", "parallax of the scene's probe", 'x', SWITCH(parallax),
     SHOWN(SCENE, "parallax")},
    {"k", "its capture: faces, paraboloids", 'k',
     CYCLE(probe_capture, VIEW_PROBE_CAPTURES)},
    {"j J", "captured more rarely, more often", 'j', 'J',
     ADD(probe_interval, 0.25, 0, 2)},
    {"h H", "more local probes, fewer", 'h', 'H', CHANGE(COUNTS, probes),
     ACT(change_probes), SHOWN(SCENE, "probes")},
    {"B", "blending of probes", 'B', SWITCH(blend)},
    {"X", "walls hide probes", 'X', SWITCH(walls), SHOWN(SCENE, "walls")},
    {"V", "volumes of probes as wires", 'V', SWITCH(volumes),
     SHOWN(SCENE, "volumes")},
    {"z", "shadows in captures", 'z', SWITCH(capture_shadows)},
    {"e E", "exposure: a quarter stop up, down", 'e', 'E',
     ADD(ev, 0.25, -30, 30)},
    SLIDER(ALL, "exposure", ev, -8, 8, 0.05),
    {"t T", "tone: linear, Reinhard, ACES, neutral", 't', 'T',
     CYCLE(tone, VIEW_TONES), CHOICE(ALL, "tone", view_tone_names)},
    {"v", "false colours of luminance", 'v', SWITCH(false_colour),
     SHOWN(ALL, "false colour")},
    {"b", "sky behind the spheres", 'b', SWITCH(sky), SHOWN(MATERIALS, "sky")},
    {"Right Left", "camera round, or map sideways; mouse: drag", NAMED(RIGHT),
     NAMED(LEFT), ACT(move_across)},
    {"Up Down", "camera or map up, down", NAMED(UP), NAMED(DOWN), ACT(move_up)},
    {"+ -", "nearer, farther; mouse: wheel", '+', '-', ACT(approach)},
    {"PageUp PageDown", "the same", NAMED(PAGE_UP), NAMED(PAGE_DOWN),
     ACT(approach)},
    {"o O", "wider field of view, narrower", 'o', 'O', ADD(fov, 5, 1, 120)},
    {". ,", "turn the environment; mouse: right drag", '.', ',', ACT(turn)},
    SLIDER(ALL & ~MAPS, "environment", turn, -180, 180, 1),
    {"> <", "move the first light round; mouse: left drag with Ctrl", '>', '<',
     ACT(move_light)},
    {"0", "all as it was in the beginning", '0', ACT(reset)},
    {"Home", "the same", NAMED(HOME), ACT(reset)},
    {"w", "print the error of each sphere or material", 'w', ACT(print_errors)},
    {"p", "write iblview-NNN.png", 'p', ACT(take_picture)},
    {"P", "controls for the mouse", 'P', SWITCH(panel)},
    {"?", "this list", '?', SWITCH(help)},
    {"q", "quit", 'q', ACT(quit)},
    {"Escape", "the same", NAMED(ESCAPE), ACT(quit)},
    {.key = 0},
};
/* clang-format on */

/* Enumerations are as wide as an int, but may be unsigned. */
_Static_assert(sizeof(view_mode) == sizeof(int),
               "enumerations are not as wide as an int");

static void change_number(double *x, const view_control *r, int step)
{
    if (r->change == VIEW_ADDS)
        *x += step * r->by;
    else
        *x *= step > 0 ? r->by : 1 / r->by;
    *x = fmin(fmax(*x, r->low), r->high);
}

/* Whether the set lacks what a reflection needs. */
static bool lacks(const view_app *app, const view_control *r, int value)
{
    return r->names == view_reflection_names &&
           view_needs_lobes((view_reflection)value) &&
           !app->set->texture[VIEW_LOBES].data;
}

static void change_setting(view_app *app, const view_control *r, int step)
{
    void *field = view_control_field(r, &app->settings);
    int value;

    if (r->change == VIEW_SWITCHES) {
        *(bool *)field = !*(bool *)field;
        return;
    }
    if (r->change >= VIEW_ADDS) {
        change_number(field, r, step);
        return;
    }
    memcpy(&value, field, sizeof value);
    if (r->change == VIEW_CYCLES)
        do
            value = next(value, step, (int)r->high);
        while (lacks(app, r, value));
    else if (value + step >= r->low && value + step <= r->high)
        value += step;
    memcpy(field, &value, sizeof value);
}

void *view_control_field(const view_control *c, view_settings *s)
{
    return (char *)s + c->offset;
}

void view_keys_press(view_app *app, int key)
{
    for (const view_control *c = view_controls; c->key; c++) {
        const int step = key == c->key ? 1 : c->back && key == c->back ? -1 : 0;
        if (key >= c->key && key <= c->last)
            *(int *)view_control_field(c, &app->settings) = key - c->key;
        else if (step && c->act)
            c->act(app, step);
        else if (step)
            change_setting(app, c, step);
    }
    view_app_fit(app);
}

void view_keys_text(char *text, int size)
{
    int used = 0;

    for (const view_control *c = view_controls; c->key && used < size; c++)
        if (c->keys)
            used += snprintf(text + used, (size_t)(size - used), "%s\t%s\n",
                             c->keys, c->what);
}

void view_print_keys(FILE *to)
{
    for (const view_control *c = view_controls; c->key; c++)
        if (c->keys)
            fprintf(to, "%-15s %s\n", c->keys, c->what);
}

/* ---- arrows, mouse and wheel ------------------------------------------- */

/* The same angle in (-180, 180]. */
static double turned(double degrees)
{
    const double x = remainder(degrees, 360);
    return x == -180 ? 180 : x;
}

static bool shows_map(const view_settings *s)
{
    return !view_shows_materials(s) && s->mode != VIEW_SCENE;
}

void view_drag(view_settings *s, const baked_set *set, int width, int height,
               double dx, double dy)
{
    if (shows_map(s)) {
        view_inspect_drag(set, s, width, height, dx, dy);
        return;
    }
    s->yaw = turned(s->yaw - 180 * dx / height);
    s->pitch = fmin(fmax(s->pitch + 180 * dy / height, -89), 89);
}

void view_approach(view_settings *s, const baked_set *set, view_place at,
                   double steps)
{
    const double factor = pow(1.1, steps);

    if (shows_map(s)) {
        view_inspect_zoom(set, s, at.width, at.height, at.x, at.y, factor);
        return;
    }
    if (s->distance <= 0 && s->mode == VIEW_SCENE)
        s->distance = view_scene_distance;
    if (s->distance <= 0) {
        const view_camera c = view_camera_of(s, at.width, at.height);
        s->distance = -dot3(c.eye, c.forward);
    }
    s->distance = fmin(
        fmax(s->distance / factor, s->mode == VIEW_MODEL ? 0.05 : 0.6), 1000);
}

void view_pan(view_settings *s, int width, int height, double dx, double dy)
{
    const view_camera c = view_camera_of(s, width, height);
    const double pixel =
        sqrt(dot3(c.up, c.up)) / height * -dot3(c.eye, c.forward);

    s->pan[0] = fmin(fmax(s->pan[0] - pixel * dx, -0.5), 0.5);
    s->pan[1] = fmin(fmax(s->pan[1] - pixel * dy, -0.5), 0.5);
}

void view_move_light(view_settings *s, double around, double up)
{
    const double degree = M_PI / 180;
    double *p = s->light[0].position;
    const double away = sqrt(dot3(p, p));

    if (!s->light_count)
        s->light_count = 1;
    if (away <= 0)
        return;
    const double height = asin(p[1] / away) + up * degree;
    const double lift = fmin(fmax(height, -89 * degree), 89 * degree);
    const double angle = atan2(p[0], p[2]) + around * degree;
    p[0] = away * cos(lift) * sin(angle);
    p[1] = away * sin(lift);
    p[2] = away * cos(lift) * cos(angle);
}

void view_spin(view_settings *s, double degrees)
{
    s->turn = turned(s->turn + degrees);
}
