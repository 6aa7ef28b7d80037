/* SPDX-License-Identifier: MIT */
#include "view/key_bindings.h"

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <math.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>

#include "view/motion.h"
#include "view/report.h"

/* The next of count values, or the previous one for step -1. */
static int next(int value, int step, int count)
{
    return (value + step + count) % count;
}

/* ---- spheres ------------------------------------------------------------ */

/* Selects the next of some ranges; a range from the command line is followed by
 * the first. */
static void change_range(double range[2], const double (*ranges)[2], int count,
                         int step)
{
    int at = 0;

    while (at < count && memcmp(range, ranges[at], sizeof ranges[at]) != 0)
        at++;
    at = at == count ? 0 : next(at, step, count);
    memcpy(range, ranges[at], sizeof ranges[at]);
}

static void change_metallic(view_app *app, int step)
{
    static const double ranges[][2] = {{0, 1}, {1, 1}, {0, 0}};
    change_range(app->settings.metallic, ranges, 3, step);
}

static void change_roughness(view_app *app, int step)
{
    static const double ranges[][2] = {
        {0, 1}, {0, 0.25}, {0.25, 0.5}, {0.5, 1}};
    change_range(app->settings.roughness, ranges, 4, step);
}

/* Selects the next reflection that the set allows. */
static void change_lookup(const view_app *app, view_reflection *r, int step)
{
    do
        *r = (view_reflection)next((int)*r, step, VIEW_REFLECTIONS);
    while (view_needs_lobes(*r) && !app->set->texture[VIEW_LOBES].data);
}

static void change_reflection(view_app *app, int step)
{
    change_lookup(app, &app->settings.reflection, step);
}

static void change_against(view_app *app, int step)
{
    change_lookup(app, &app->settings.against, step);
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

static void change_interval(view_app *app, int step)
{
    static const double times[] = {0, 0.1, 0.25, 0.5, 1, 2};
    enum {
        LAST = sizeof times / sizeof *times - 1
    };
    double *x = &app->settings.probe_interval;
    int i = step > 0 ? 0 : LAST;

    while (step > 0 ? i < LAST && times[i] <= *x : i > 0 && times[i] >= *x)
        i += step;
    *x = times[i];
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
    if (!view_report_print(app->renderer, &app->settings, app->set))
        view_app_notice(app, "no errors yet: compare (f)");
}

static void quit(view_app *app, int step)
{
    (void)step;
    app->quit = true;
}

/* ---- the table ----------------------------------------------------------- */

/* How a key changes a setting. */
typedef enum change {
    SWITCHES,   /* a bool */
    CYCLES,     /* an enumeration, through `high` values */
    COUNTS,     /* an int, by 1 */
    ADDS,       /* a double, by `by` */
    MULTIPLIES, /* a double, by the factor `by` */
} change;

typedef struct key_row {
    const char *name;
    int key;  /* act(app, 1) */
    int back; /* act(app, -1), 0: none */
    int last; /* key..last: set an int to the key's index; 0: none */
    void (*act)(view_app *app, int step); /* NULL: the key changes a setting: */
    change change;
    size_t offset; /* offset of the setting */
    double by;
    double low, high; /* limits of the setting */
    const char *what; /* description */
} key_row;

#define ACT(function) .act = (function)
#define CHANGE(how, field)                                                     \
    .change = (how), .offset = offsetof(view_settings, field)
#define SWITCH(field) CHANGE(SWITCHES, field)
#define CYCLE(field, count) CHANGE(CYCLES, field), .high = (count)
#define COUNT(field, lo, hi) CHANGE(COUNTS, field), .low = (lo), .high = (hi)
#define ADD(field, step, lo, hi)                                               \
    CHANGE(ADDS, field), .by = (step), .low = (lo), .high = (hi)
#define MULTIPLY(field, factor, lo, hi)                                        \
    CHANGE(MULTIPLIES, field), .by = (factor), .low = (lo), .high = (hi)
#define NAMED(code) VIEW_KEY(GLFW_KEY_##code)

/* clang-format off */
static const key_row rows[] = {
    {"m M", 'm', 'M', CYCLE(mode, VIEW_MODES),
     .what = "mode: spheres, levels, irradiance, table, scene, model"},
    {"Tab", NAMED(TAB), VIEW_KEY_BACK_TAB, CYCLE(mode, VIEW_MODES),
     .what = "the same; back with Shift"},
    {"l L", 'l', 'L', CYCLE(layout, VIEW_LAYOUTS),
     .what = "layout: cross, strip, equirect"},
    {"] [", ']', '[', COUNT(level, 0, IBL_MAX_LEVELS - 1),
     .what = "next level, the one before"},
    {"r R", 'r', 'R', ACT(change_reflection),
     .what = "reflection: split sum, bent, fit, table, two taps, reference"},
    {"f F", 'f', 'F', CYCLE(compare, VIEW_COMPARES),
     .what = "compare: no, side by side, difference"},
    {"D", 'D', ACT(change_against), .what = "what it is compared with"},
    {"s S", 's', 'S', ADD(split, 0.05, 0, 1),
     .what = "move the split right, left"},
    {"g G", 'g', 'G', MULTIPLY(gain, 2, 1e-3, 1e6),
     .what = "more gain of the difference, less"},
    {"1 to 9", '1', .last = '9', CHANGE(CYCLES, material), .what = "material"},
    {"n N", 'n', 'N', CYCLE(material, VIEW_MATERIALS),
     .what = "next material, the one before"},
    {"} {", '}', '{', COUNT(columns, 1, VIEW_MAX_GRID),
     .what = "more columns, fewer"},
    {") (", ')', '(', COUNT(rows, 1, VIEW_MAX_GRID),
     .what = "more rows, fewer"},
    {"a A", 'a', 'A', ACT(change_metallic), .what = "range of metallic"},
    {"u U", 'u', 'U', ACT(change_roughness), .what = "range of roughness"},
    {"d", 'd', CYCLE(diffuse, VIEW_DIFFUSES),
     .what = "diffuse: map, spherical harmonics"},
    {"c", 'c', SWITCH(multiscatter), .what = "multiple scattering"},
    {"i I", 'i', 'I', COUNT(light_count, 0, VIEW_MAX_LIGHTS),
     .what = "more point lights, fewer"},
    {"x", 'x', SWITCH(parallax), .what = "parallax of the scene's probe"},
    {"k", 'k', CYCLE(probe_capture, VIEW_PROBE_CAPTURES),
     .what = "its capture: faces, paraboloids"},
    {"y", 'y', CYCLE(probe_filter, VIEW_PROBE_FILTERS),
     .what = "its filter: OpenGL, the library"},
    {"j J", 'j', 'J', ACT(change_interval),
     .what = "captured more rarely, more often"},
    {"h H", 'h', 'H', ACT(change_probes), .what = "more local probes, fewer"},
    {"B", 'B', SWITCH(blend), .what = "blending of probes"},
    {"X", 'X', SWITCH(walls), .what = "walls hide probes"},
    {"V", 'V', SWITCH(volumes), .what = "volumes of probes as wires"},
    {"z", 'z', SWITCH(capture_shadows), .what = "shadows in captures"},
    {"Z", 'Z', SWITCH(sun), .what = "the sun as a light with shadows"},
    {"e E", 'e', 'E', ADD(ev, 0.25, -30, 30),
     .what = "exposure: a quarter stop up, down"},
    {"t T", 't', 'T', CYCLE(tone, VIEW_TONES),
     .what = "tone: linear, Reinhard, ACES, neutral"},
    {"v", 'v', SWITCH(false_colour), .what = "false colours of luminance"},
    {"b", 'b', SWITCH(sky), .what = "sky behind the spheres"},
    {"Right Left", NAMED(RIGHT), NAMED(LEFT), ACT(move_across),
     .what = "camera round, or map sideways; mouse: drag"},
    {"Up Down", NAMED(UP), NAMED(DOWN), ACT(move_up),
     .what = "camera or map up, down"},
    {"+ -", '+', '-', ACT(approach), .what = "nearer, farther; mouse: wheel"},
    {"PageUp PageDown", NAMED(PAGE_UP), NAMED(PAGE_DOWN), ACT(approach),
     .what = "the same"},
    {"o O", 'o', 'O', ADD(fov, 5, 1, 120),
     .what = "wider field of view, narrower"},
    {". ,", '.', ',', ACT(turn),
     .what = "turn the environment; mouse: right drag"},
    {"> <", '>', '<', ACT(move_light),
     .what = "move the first light round; mouse: left drag with Ctrl"},
    {"0", '0', ACT(reset), .what = "all as it was in the beginning"},
    {"Home", NAMED(HOME), ACT(reset), .what = "the same"},
    {"w", 'w', ACT(print_errors),
     .what = "print the error of each sphere or material"},
    {"p", 'p', ACT(take_picture), .what = "write iblview-NNN.png"},
    {"P", 'P', SWITCH(panel), .what = "controls for the mouse"},
    {"?", '?', SWITCH(help), .what = "this list"},
    {"q", 'q', ACT(quit), .what = "quit"},
    {"Escape", NAMED(ESCAPE), ACT(quit), .what = "the same"},
};
/* clang-format on */

/* Enumerations are as wide as an int, but may be unsigned. */
_Static_assert(sizeof(view_mode) == sizeof(int),
               "enumerations are not as wide as an int");

static void change_number(double *x, const key_row *r, int step)
{
    if (r->change == ADDS)
        *x += step * r->by;
    else
        *x *= step > 0 ? r->by : 1 / r->by;
    *x = fmin(fmax(*x, r->low), r->high);
}

static void change_setting(view_settings *s, const key_row *r, int step)
{
    void *field = (char *)s + r->offset;
    int value;

    if (r->change == SWITCHES) {
        *(bool *)field = !*(bool *)field;
        return;
    }
    if (r->change >= ADDS) {
        change_number(field, r, step);
        return;
    }
    memcpy(&value, field, sizeof value);
    if (r->change == CYCLES)
        value = next(value, step, (int)r->high);
    else if (value + step >= r->low && value + step <= r->high)
        value += step;
    memcpy(field, &value, sizeof value);
}

void view_keys_press(view_app *app, int key)
{
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        const key_row *r = &rows[i];
        const int step = key == r->key ? 1 : r->back && key == r->back ? -1 : 0;
        if (key >= r->key && key <= r->last)
            *(int *)((char *)&app->settings + r->offset) = key - r->key;
        else if (step && r->act)
            r->act(app, step);
        else if (step)
            change_setting(&app->settings, r, step);
    }
    view_app_fit(app);
}

void view_keys_text(char *text, int size)
{
    int used = 0;

    for (size_t i = 0; i < sizeof rows / sizeof *rows && used < size; i++)
        used += snprintf(text + used, (size_t)(size - used), "%s\t%s\n",
                         rows[i].name, rows[i].what);
}

void view_print_keys(FILE *to)
{
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++)
        fprintf(to, "%-15s %s\n", rows[i].name, rows[i].what);
}
