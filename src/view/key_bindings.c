/* SPDX-License-Identifier: MIT */
#include "view/key_bindings.h"

#include <stddef.h>
#include <stdio.h>
#include <string.h>

#include "view/motion.h"
#include "view/report.h"

/* The next of count values, or the one before. */
static int next(int value, int step, int count)
{
    return (value + step + count) % count;
}

static void clamp(double *x, double low, double high)
{
    *x = *x < low ? low : *x > high ? high : *x;
}

/* ---- what is shown ------------------------------------------------------ */

static void change_level(view_app *app, int step)
{
    const int levels = app->set->texture[VIEW_SPECULAR].levels;
    const int level = app->settings.level + step;

    if (level >= 0 && level < levels)
        app->settings.level = level;
}

static void change_split(view_app *app, int step)
{
    app->settings.split += 0.05 * step;
    clamp(&app->settings.split, 0, 1);
}

static void change_gain(view_app *app, int step)
{
    app->settings.gain *= step > 0 ? 2 : 0.5;
    clamp(&app->settings.gain, 1e-3, 1e6);
}

/* ---- spheres ------------------------------------------------------------ */

static void choose_material(view_app *app, int index)
{
    if (index < view_material_count())
        app->settings.material = index;
}

static void change_material(view_app *app, int step)
{
    view_settings *s = &app->settings;
    s->material = next(s->material, step, view_material_count());
}

static void change_columns(view_app *app, int step)
{
    const int columns = app->settings.columns + step;
    if (columns >= 1 && columns <= VIEW_MAX_GRID)
        app->settings.columns = columns;
}

static void change_rows(view_app *app, int step)
{
    const int rows = app->settings.rows + step;
    if (rows >= 1 && rows <= VIEW_MAX_GRID)
        app->settings.rows = rows;
}

/* The next of some ranges; the command line's own range comes to the first. */
static void change_range(double range[2], const double (*ranges)[2], int count,
                         int step)
{
    int at = 0;

    while (at < count &&
           (range[0] < ranges[at][0] || range[0] > ranges[at][0] ||
            range[1] < ranges[at][1] || range[1] > ranges[at][1]))
        at++;
    at = at == count ? 0 : next(at, step, count);
    range[0] = ranges[at][0];
    range[1] = ranges[at][1];
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

static void change_diffuse(view_app *app, int step)
{
    view_settings *s = &app->settings;

    s->diffuse = (view_diffuse)next((int)s->diffuse, step, VIEW_DIFFUSES);
    if (s->diffuse == VIEW_DIFFUSE_SH && app->set->sh_degree < 0) {
        s->diffuse = VIEW_DIFFUSE_MAP;
        view_app_notice(app, "there are no spherical harmonics: the sidecar "
                             "has them");
    }
}

static void change_lights(view_app *app, int step)
{
    const int count = app->settings.light_count + step;
    if (count >= 0 && count <= VIEW_MAX_LIGHTS)
        app->settings.light_count = count;
}

/* ---- scene -------------------------------------------------------------- */

/* None, then powers of two. */
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
    int width, height;

    view_screen_size(app->screen, &width, &height);
    view_drag(&app->settings, app->set, width, height, -step * height / 36.0,
              0);
}

static void move_up(view_app *app, int step)
{
    int width, height;

    view_screen_size(app->screen, &width, &height);
    view_drag(&app->settings, app->set, width, height, 0, step * height / 36.0);
}

static void approach(view_app *app, int step)
{
    view_place at;

    view_screen_size(app->screen, &at.width, &at.height);
    at.x = 0.5 * at.width;
    at.y = 0.5 * at.height;
    view_approach(&app->settings, app->set, at, step);
}

static void change_fov(view_app *app, int step)
{
    app->settings.fov += 5 * step;
    clamp(&app->settings.fov, 1, 120);
}

static void turn(view_app *app, int step)
{
    view_spin(&app->settings, 5 * step);
}

/* ---- display ------------------------------------------------------------ */

static void change_exposure(view_app *app, int step)
{
    app->settings.ev += 0.25 * step;
    clamp(&app->settings.ev, -30, 30);
}

/* ---- the rest ----------------------------------------------------------- */

static void reset(view_app *app, int step)
{
    (void)step;
    view_app_reset(app);
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
        view_app_notice(app, "no errors yet: compare with the reference (r)");
}

static void quit(view_app *app, int step)
{
    (void)step;
    app->quit = true;
}

typedef struct key_row {
    const char *name;
    int key;  /* act(app, 1) */
    int back; /* act(app, -1), 0: none */
    int last; /* key..last: act(app, which of them) */
    void (*act)(view_app *app, int step); /* NULL: it changes a setting: */
    size_t offset;                        /* where that is, */
    int count;        /* and its values, an enumeration's; 0: a bool */
    const char *what; /* what it is for */
} key_row;

#define ACT(function) (function), 0, 0
#define SWITCH(field) NULL, offsetof(view_settings, field), 0
#define CYCLE(field, count) NULL, offsetof(view_settings, field), (count)

/* Tab with Shift, as it is everywhere, goes the other way. */
static const key_row rows[] = {
    {"m M", 'm', 'M', 0, CYCLE(mode, VIEW_MODES),
     "mode: spheres, levels, irradiance, table, scene"},
    {"Tab", VIEW_KEY_TAB, 0, 0, CYCLE(mode, VIEW_MODES),
     "the same; back with Shift"},
    {"l L", 'l', 'L', 0, CYCLE(layout, VIEW_LAYOUTS),
     "layout: cross, strip, equirect"},
    {"] [", ']', '[', 0, ACT(change_level), "next level, the one before"},
    {"r R", 'r', 'R', 0, CYCLE(compare, VIEW_COMPARES),
     "split sum, reference, split, difference"},
    {"s S", 's', 'S', 0, ACT(change_split), "move the split right, left"},
    {"g G", 'g', 'G', 0, ACT(change_gain), "more gain of the difference, less"},
    {"1 to 9", '1', 0, '9', ACT(choose_material), "material"},
    {"n N", 'n', 'N', 0, ACT(change_material), "next material, the one before"},
    {"} {", '}', '{', 0, ACT(change_columns), "more columns, fewer"},
    {") (", ')', '(', 0, ACT(change_rows), "more rows, fewer"},
    {"a A", 'a', 'A', 0, ACT(change_metallic), "range of metallic"},
    {"u U", 'u', 'U', 0, ACT(change_roughness), "range of roughness"},
    {"d", 'd', 0, 0, ACT(change_diffuse), "diffuse: map, spherical harmonics"},
    {"c", 'c', 0, 0, SWITCH(multiscatter), "multiple scattering"},
    {"i I", 'i', 'I', 0, ACT(change_lights), "more point lights, fewer"},
    {"x", 'x', 0, 0, SWITCH(parallax), "parallax of the scene's probe"},
    {"k", 'k', 0, 0, CYCLE(probe_capture, VIEW_PROBE_CAPTURES),
     "its capture: faces, paraboloids"},
    {"y", 'y', 0, 0, CYCLE(probe_filter, VIEW_PROBE_FILTERS),
     "its filter: OpenGL, the library"},
    {"j J", 'j', 'J', 0, ACT(change_interval),
     "captured more rarely, more often"},
    {"h H", 'h', 'H', 0, ACT(change_probes), "more local probes, fewer"},
    {"B", 'B', 0, 0, SWITCH(blend), "blending of probes"},
    {"V", 'V', 0, 0, SWITCH(volumes), "volumes of probes as wires"},
    {"z", 'z', 0, 0, SWITCH(capture_shadows), "shadows in captures"},
    {"Z", 'Z', 0, 0, SWITCH(sun), "the sun as a light with shadows"},
    {"e E", 'e', 'E', 0, ACT(change_exposure),
     "exposure: a quarter stop up, down"},
    {"t T", 't', 'T', 0, CYCLE(tone, VIEW_TONES),
     "tone: linear, Reinhard, ACES, neutral"},
    {"v", 'v', 0, 0, SWITCH(false_colour), "false colours of luminance"},
    {"b", 'b', 0, 0, SWITCH(sky), "sky behind the spheres"},
    {"Right Left", VIEW_KEY_RIGHT, VIEW_KEY_LEFT, 0, ACT(move_across),
     "camera round, or map sideways; mouse: drag"},
    {"Up Down", VIEW_KEY_UP, VIEW_KEY_DOWN, 0, ACT(move_up),
     "camera or map up, down"},
    {"+ -", '+', '-', 0, ACT(approach), "nearer, farther; mouse: wheel"},
    {"PageUp PageDown", VIEW_KEY_PAGE_UP, VIEW_KEY_PAGE_DOWN, 0, ACT(approach),
     "the same"},
    {"o O", 'o', 'O', 0, ACT(change_fov), "wider field of view, narrower"},
    {". ,", '.', ',', 0, ACT(turn), "turn the environment; mouse: right drag"},
    {"0", '0', 0, 0, ACT(reset), "all as it was in the beginning"},
    {"Home", VIEW_KEY_HOME, 0, 0, ACT(reset), "the same"},
    {"w", 'w', 0, 0, ACT(print_errors), "print the error of each sphere"},
    {"p", 'p', 0, 0, ACT(take_picture), "write iblview-NNN.png"},
    {"?", '?', 0, 0, SWITCH(help), "this list"},
    {"q", 'q', 0, 0, ACT(quit), "quit"},
    {"Escape", VIEW_KEY_ESCAPE, 0, 0, ACT(quit), "the same"},
};

/* Enumerations are as wide as an int, but may be unsigned. */
_Static_assert(sizeof(view_mode) == sizeof(int),
               "enumerations are not as wide as an int");

static void change_setting(view_settings *s, const key_row *r, int step)
{
    void *field = (char *)s + r->offset;
    int value;

    if (!r->count) {
        *(bool *)field = !*(bool *)field;
        return;
    }
    memcpy(&value, field, sizeof value);
    value = next(value, step, r->count);
    memcpy(field, &value, sizeof value);
}

void view_keys_press(view_app *app, int key, bool shift)
{
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        const key_row *r = &rows[i];
        int step = 0;
        if (r->last && key >= r->key && key <= r->last)
            r->act(app, key - r->key);
        else if (!r->last && key == r->key)
            step = key == VIEW_KEY_TAB && shift ? -1 : 1;
        else if (r->back && key == r->back)
            step = -1;
        if (step && r->act)
            r->act(app, step);
        else if (step)
            change_setting(&app->settings, r, step);
    }
    app->redraw = true;
}

void view_keys_text(char *text, int size)
{
    int used = 0;

    for (size_t i = 0; i < sizeof rows / sizeof *rows && used < size; i++)
        used += snprintf(text + used, (size_t)(size - used), "%-15s %s\n",
                         rows[i].name, rows[i].what);
}

void view_print_keys(FILE *to)
{
    char text[VIEW_KEYS_BYTES];

    view_keys_text(text, sizeof text);
    fputs(text, to);
}
