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
#include "view/scene_captures.h"

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
    PLAIN(VIEW_KEY(GLFW_KEY_TAB), 'M', mode),
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
    PLAIN('y', 'y', probe_filter),
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
    memset(&app, 0, sizeof app);
    memset(&options, 0, sizeof options);
    options.settings = view_settings_default();
    app.options = &options;
    app.settings = options.settings;
    app.width = 64;
    app.height = 48;
    sets_white(&app.sets[0]);
    app.set = &app.sets[0];
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

/* To the first step up, as the list of keys says. */
TEST(go_the_right_way)
{
    static const struct {
        int key;
        size_t offset;
        double value;
    } reals[] = {
        {'s', offsetof(view_settings, split), 0.55},
        {'g', offsetof(view_settings, gain), 20},
        {'e', offsetof(view_settings, ev), 0.25},
        {'o', offsetof(view_settings, fov), 35},
        {'.', offsetof(view_settings, turn), 5},
        {'j', offsetof(view_settings, probe_interval), 0.75},
    };
    static const struct {
        int key;
        size_t offset;
        int value;
    } numbers[] = {
        {']', offsetof(view_settings, level), 1},
        {'}', offsetof(view_settings, columns), 8},
        {')', offsetof(view_settings, rows), 8},
        {'i', offsetof(view_settings, light_count), 1},
        {'h', offsetof(view_settings, probes), 1},
    };

    begin();
    for (size_t i = 0; i < sizeof reals / sizeof *reals; i++) {
        double x;
        app.settings = options.settings;
        view_keys_press(&app, reals[i].key);
        memcpy(&x, (const char *)&app.settings + reals[i].offset, sizeof x);
        CHECK_MSG(fabs(x - reals[i].value) < 1e-12, "%c: %g", reals[i].key, x);
    }
    for (size_t i = 0; i < sizeof numbers / sizeof *numbers; i++) {
        int n;
        app.settings = options.settings;
        view_keys_press(&app, numbers[i].key);
        memcpy(&n, (const char *)&app.settings + numbers[i].offset, sizeof n);
        CHECK_MSG(n == numbers[i].value, "%c: %d", numbers[i].key, n);
    }
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

/* A tenth from where the camera is without a distance of its own. */
TEST(nearer_by_a_tenth)
{
    const view_place at = {640, 480, 0, 0};

    begin();
    for (int scene = 0; scene < 2; scene++) {
        view_settings s = options.settings;
        s.mode = scene ? VIEW_SCENE : VIEW_SPHERES;
        const view_camera c = scene ? view_scene_camera(&s, 640, 480)
                                    : view_camera_of(&s, 640, 480);
        double middle[3] = {0}, away = 0, radius;
        if (scene)
            view_room_sphere(VIEW_SCENE_MIRROR, 0, middle, &radius);
        for (int k = 0; k < 3; k++)
            away += (c.eye[k] - middle[k]) * (c.eye[k] - middle[k]);
        view_approach(&s, app.set, at, 1);
        CHECK_NEAR(s.distance, sqrt(away) / 1.1, 1e-9);
    }
}

TEST(tab_goes_back_with_shift)
{
    begin();
    view_keys_press(&app, VIEW_KEY_BACK_TAB);
    CHECK(app.settings.mode == VIEW_MODEL);
    view_keys_press(&app, VIEW_KEY(GLFW_KEY_TAB));
    CHECK(app.settings.mode == VIEW_SPHERES);
}

static void check_ranges(int key)
{
    const view_settings *s = &app.settings;

    CHECK_MSG(s->rows >= 1 && s->rows <= VIEW_MAX_GRID && s->columns >= 1 &&
                  s->columns <= VIEW_MAX_GRID,
              "key %d: %dx%d", key, s->rows, s->columns);
    CHECK_MSG(s->level >= 0 && s->level < 3, "key %d: level %d", key, s->level);
    CHECK_MSG(s->light_count >= 0 && s->light_count <= VIEW_MAX_LIGHTS,
              "key %d: %d lights", key, s->light_count);
    CHECK_MSG(s->material >= 0 && s->material < VIEW_MATERIALS,
              "key %d: material %d", key, s->material);
    CHECK_MSG(s->fov >= 1 && s->fov <= 120, "key %d: fov %g", key, s->fov);
    CHECK_MSG(s->ev >= -30 && s->ev <= 30, "key %d: ev %g", key, s->ev);
    CHECK_MSG(s->split >= 0 && s->split <= 1, "key %d: %g", key, s->split);
    CHECK_MSG(s->gain >= 1e-3 && s->gain <= 1e6, "key %d: gain %g", key,
              s->gain);
    CHECK_MSG(s->pitch >= -89 && s->pitch <= 89 && s->yaw > -181 &&
                  s->yaw < 181 && s->turn > -181 && s->turn < 181,
              "key %d: angles %g %g %g", key, s->pitch, s->yaw, s->turn);
    CHECK_MSG(s->probes >= 0 && s->probes <= VIEW_MAX_LOCALS,
              "key %d: %d probes", key, s->probes);
    CHECK_MSG(s->probe_interval >= 0 && s->probe_interval <= 2,
              "key %d: interval %g", key, s->probe_interval);
    CHECK_MSG(s->distance >= 0 && s->distance <= 1000, "key %d: distance %g",
              key, s->distance);
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

/* Every line fits the columns that --keys and the list on screen have. */
TEST(list_fits)
{
    char text[VIEW_KEYS_BYTES];
    int lines = 0;

    view_keys_text(text, sizeof text);
    CHECK(strlen(text) < sizeof text - 80);
    for (char *line = strtok(text, "\n"); line; line = strtok(NULL, "\n")) {
        const char *tab = strchr(line, '\t');
        CHECK_MSG(tab && tab - line <= 15 && tab[1], "\"%s\"", line);
        lines++;
    }
    CHECK(lines > 30);
}
