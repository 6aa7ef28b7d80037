/* SPDX-License-Identifier: MIT */
/* Keys: each changes its own setting alone, stays within its range however
 * often it is pressed, and together they reach every setting. */
#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "sets.h"
#include "test.h"
#include "view.h"
#include "view/key_bindings.h"

/* A key and the setting that it changes; back: what takes that back. */
typedef struct key_case {
    int key, back;
    size_t offset, size;
    view_mode mode;
} key_case;

#define CHANGES(field)                                                         \
    offsetof(view_settings, field), sizeof((view_settings *)0)->field
#define PLAIN(key, back, field)                                                \
    {                                                                          \
        key, back, CHANGES(field), VIEW_SPHERES                                \
    }
#define MAP(key, back, field)                                                  \
    {                                                                          \
        key, back, CHANGES(field), VIEW_LEVELS                                 \
    }

static const key_case cases[] = {
    PLAIN('m', 'M', mode),
    PLAIN(VIEW_KEY(GLFW_KEY_TAB), VIEW_KEY_BACK_TAB, mode),
    PLAIN(VIEW_KEY_BACK_TAB, VIEW_KEY(GLFW_KEY_TAB), mode),
    PLAIN('l', 'L', layout),
    PLAIN(']', '[', level),
    PLAIN('a', 'A', layer),
    PLAIN('r', 'R', reflection),
    PLAIN('f', 'F', compare),
    PLAIN('D', 0, against),
    PLAIN('s', 'S', split),
    PLAIN('g', 'G', gain),
    PLAIN('2', '1', material),
    PLAIN('9', '1', material),
    PLAIN('n', 'N', material),
    PLAIN('}', '{', columns),
    PLAIN(')', '(', rows),
    PLAIN('d', 'd', diffuse),
    PLAIN('c', 'c', multiscatter),
    PLAIN('i', 'I', light_count),
    PLAIN('e', 'E', ev),
    PLAIN('t', 'T', tone),
    PLAIN('v', 'v', false_colour),
    PLAIN('b', 'b', sky),
    PLAIN('x', 'x', parallax),
    PLAIN('k', 'k', probe_capture),
    PLAIN('h', 'H', probes),
    PLAIN('V', 'V', volumes),
    PLAIN('B', 'B', blend),
    PLAIN('j', 'J', probe_interval),
    PLAIN('z', 'z', capture_shadows),
    PLAIN('o', 'O', fov),
    PLAIN('.', ',', turn),
    PLAIN('?', '?', help),
    PLAIN('P', 'P', panel),
    PLAIN('X', 'X', walls),
    PLAIN(VIEW_KEY(GLFW_KEY_RIGHT), VIEW_KEY(GLFW_KEY_LEFT), yaw),
    PLAIN(VIEW_KEY(GLFW_KEY_UP), VIEW_KEY(GLFW_KEY_DOWN), pitch),
    PLAIN('+', 0, distance),
    PLAIN(VIEW_KEY(GLFW_KEY_PAGE_DOWN), 0, distance),
    MAP(VIEW_KEY(GLFW_KEY_RIGHT), VIEW_KEY(GLFW_KEY_LEFT), pan),
    MAP(VIEW_KEY(GLFW_KEY_UP), VIEW_KEY(GLFW_KEY_DOWN), pan),
    MAP('+', 0, zoom),
    MAP(VIEW_KEY(GLFW_KEY_PAGE_DOWN), 0, zoom),
};
enum {
    CASES = sizeof cases / sizeof *cases
};

/* What keys work on: an app with a set. */
static view_app app;
static view_options options;

static void begin(void)
{
    view_test_app(&app, &options, 64, 48);
    app.set->path[VIEW_SPECULAR] = strdup("white");
}

/* Whether a and b differ in the field alone, or, with no size, at all. */
static bool same_but(view_settings a, const view_settings *b, size_t offset,
                     size_t size)
{
    memcpy((char *)&a + offset, (const char *)b + offset, size);
    return !memcmp(&a, b, sizeof a);
}

static void start_case(const key_case *c)
{
    app.settings = options.settings;
    app.settings.mode = c->mode;
    if (c->mode == VIEW_LEVELS)
        app.settings.zoom = 4;
}

static void try_case(const key_case *c)
{
    start_case(c);
    const view_settings before = app.settings;

    view_keys_press(&app, c->key);
    CHECK_MSG(!same_but(app.settings, &before, 0, 0), "key %d changes nothing",
              c->key);
    CHECK_MSG(same_but(app.settings, &before, c->offset, c->size),
              "key %d changes something else", c->key);
    CHECK_MSG(app.redraw, "key %d is not seen", c->key);
    app.redraw = false;
    if (!c->back)
        return;
    view_keys_press(&app, c->back);
    CHECK_NEAR(app.settings.yaw, before.yaw, 1e-9);
    CHECK_NEAR(app.settings.pitch, before.pitch, 1e-9);
    CHECK_NEAR(app.settings.pan[0], before.pan[0], 1e-9);
    CHECK_NEAR(app.settings.pan[1], before.pan[1], 1e-9);
    CHECK_NEAR(app.settings.split, before.split, 1e-9);
    if (c->offset != offsetof(view_settings, yaw) &&
        c->offset != offsetof(view_settings, pitch) &&
        c->offset != offsetof(view_settings, pan) &&
        c->offset != offsetof(view_settings, split))
        CHECK_MSG(same_but(app.settings, &before, 0, 0),
                  "key %d is not taken back by %d", c->key, c->back);
}

TEST(change_one_setting)
{
    begin();
    for (int i = 0; i < CASES; i++)
        try_case(&cases[i]);
}

/* A press from the beginning comes to so much. */
#define COMES_TO(key, field, value)                                            \
    (app.settings = options.settings, view_keys_press(&app, key),              \
     CHECK_NEAR(app.settings.field, value, 1e-12))

/* To the first step up, as the list of keys says. */
TEST(go_the_right_way)
{
    begin();
    COMES_TO('s', split, 0.55);
    COMES_TO('g', gain, 20);
    COMES_TO('e', ev, 0.25);
    COMES_TO('o', fov, 35);
    COMES_TO('.', turn, 5);
    COMES_TO('j', probe_interval, 0.75);
    COMES_TO(']', level, 1);
    COMES_TO('}', columns, 8);
    COMES_TO(')', rows, 8);
    COMES_TO('i', light_count, 1);
    COMES_TO('h', probes, 1);
    /* What the command line has of its own goes to the next that there is. */
    app.settings = options.settings;
    for (int up = 0; up < 2; up++) {
        app.settings.probes = 5;
        view_keys_press(&app, up ? 'h' : 'H');
        CHECK(app.settings.probes == (up ? 8 : 4));
    }
    /* Half a turn is the same either way, and is told so. */
    for (int sign = -1; sign <= 1; sign += 2) {
        app.settings = options.settings;
        view_spin(&app.settings, 180 * sign);
        CHECK_NEAR(app.settings.turn, 180, 0);
    }
}

static bool is_in(double x, double least, double most)
{
    return x >= least && x <= most;
}

static void check_ranges(int key)
{
    const view_settings *s = &app.settings;

    CHECK_MSG(
        is_in(s->rows, 1, VIEW_MAX_GRID) &&
            is_in(s->columns, 1, VIEW_MAX_GRID) && is_in(s->level, 0, 2) &&
            is_in(s->light_count, 0, VIEW_MAX_LIGHTS) &&
            is_in(s->material, 0, VIEW_MATERIALS - 1) &&
            is_in(s->fov, 1, 120) && is_in(s->ev, -30, 30) &&
            is_in(s->split, 0, 1) && is_in(s->gain, 1e-3, 1e6) &&
            is_in(s->pitch, -89, 89) && is_in(s->yaw, -181, 181) &&
            is_in(s->turn, -181, 181) && is_in(s->probes, 0, VIEW_MAX_LOCALS) &&
            is_in(s->probe_interval, 0, 2) && is_in(s->distance, 0, 1000),
        "key %d: beyond a range", key);
}

/* Every key, pressed on and on. */
TEST(stay_in_range)
{
    begin();
    for (int i = 0; i < 2 * CASES; i++) {
        const key_case *c = &cases[i / 2];
        const int key = i % 2 ? c->back : c->key;
        start_case(c);
        for (int n = 0; n < 300; n++) {
            view_keys_press(&app, key);
            check_ranges(key);
        }
    }
}

TEST(moving_stays_in_range)
{
    const view_place at = {640, 480, 0, 0};
    view_settings s;

    begin();
    for (int sign = -1; sign <= 1; sign += 2) {
        s = options.settings;
        for (int n = 0; n < 300; n++) {
            view_drag(&s, app.set, 640, 480, 50 * sign, 50 * sign);
            view_approach(&s, app.set, at, sign);
            view_spin(&s, 50 * sign);
            app.settings = s;
            check_ranges(sign);
        }
        CHECK_NEAR(s.pitch, 89 * sign, 0);
        CHECK_NEAR(s.distance, sign > 0 ? 0.6 : 1000, 0);
    }
}

TEST(reset_brings_all_back)
{
    begin();
    for (int i = 0; i < CASES; i++)
        view_keys_press(&app, cases[i].key);
    view_keys_press(&app, '0');
    CHECK(same_but(app.settings, &options.settings, 0, 0));
}

TEST(others_do_nothing)
{
    begin();
    view_keys_press(&app, 'Q');
    view_keys_press(&app, 0x3b1);
    view_keys_press(&app, VIEW_KEY(GLFW_KEY_ENTER));
    CHECK(same_but(app.settings, &options.settings, 0, 0));
    CHECK(!app.quit);
    view_keys_press(&app, 'q');
    CHECK(app.quit);
}

/* Without harmonics there is nothing to switch to, and that is said. */
TEST(no_harmonics)
{
    begin();
    app.sets[0].sh_degree = -1;
    view_keys_press(&app, 'd');
    CHECK(app.settings.diffuse == VIEW_DIFFUSE_MAP);
    CHECK(strstr(app.notice, "harmonics"));
}
