/* SPDX-License-Identifier: MIT */
/* The panel: which settings a press at any place of the picture changes; and
 * two sets side by side. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "sets.h"
#include "test.h"
#include "view.h"
#include "view/app.h"
#include "view/errors.h"
#include "view/key_bindings.h"

enum {
    WIDTH = 1280,
    HEIGHT = 720,
    STEP = 3 /* pixels between presses; a line of text has 24 */
};

static view_app app;
static view_options options;

static void begin(view_mode mode)
{
    view_test_app(&app, &options, WIDTH, HEIGHT);
    options.settings.mode = mode;
    options.settings.panel = true;
}

/* Presses at a place with the settings of the beginning. */
static bool press(double x, double y)
{
    app.settings = options.settings;
    app.dragged = 0;
    app.mouse[0] = x;
    app.mouse[1] = y;
    return view_panel_point(&app, false);
}

/* Whether a press somewhere along x makes settings those that are wanted. */
static bool reaches(const view_settings *want, double x)
{
    for (int y = 0; y < HEIGHT; y += STEP)
        if (press(x, y) && !memcmp(&app.settings, want, sizeof *want))
            return true;
    return false;
}

/* Right ends of sliders, and right and left parts of choices. */
static const double END = WIDTH - 12, NEXT = WIDTH - 170, BACK = WIDTH - 300;

#define REACHES(x, field, value)                                               \
    do {                                                                       \
        view_settings want = options.settings;                                 \
        want.field = value;                                                    \
        CHECK_MSG(reaches(&want, x), "%s", #field);                            \
    } while (0)

TEST(spheres)
{
    begin(VIEW_SPHERES);
    REACHES(NEXT, mode, VIEW_LEVELS);
    REACHES(NEXT, material, 1);
    REACHES(NEXT, rows, 8);
    REACHES(BACK, rows, 6);
    REACHES(BACK, columns, 6);
    REACHES(NEXT, reflection, VIEW_BENT);
    REACHES(NEXT, compare, VIEW_SPLIT);
    REACHES(BACK, compare, VIEW_DIFFERENCE);
    REACHES(NEXT, light_count, 1);
    REACHES(NEXT, sky, false);
    REACHES(NEXT, tone, VIEW_TONE_LINEAR);
    REACHES(NEXT, false_colour, true);
    REACHES(END, roughness[0], 1);
    REACHES(END, metallic[0], 1);
    REACHES(END, split, 1);
    REACHES(END, turn, 180);
    REACHES(END, ev, 8);
}

TEST(scene)
{
    begin(VIEW_SCENE);
    REACHES(NEXT, probes, 1);
    REACHES(NEXT, parallax, false);
    REACHES(NEXT, walls, false);
    REACHES(NEXT, volumes, true);
    REACHES(END, ev, 8);
    /* There are no spheres. */
    view_settings want = options.settings;
    want.material = 1;
    CHECK(!reaches(&want, NEXT));
}

/* A slider follows the pointer, and stops at its ends. */
TEST(drags)
{
    begin(VIEW_SPHERES);
    view_settings want = options.settings;
    want.ev = 8;
    NEED(reaches(&want, END));
    CHECK(app.dragged);
    app.mouse[0] = END - 62; /* half of its length */
    CHECK(view_panel_point(&app, true));
    CHECK_NEAR(app.settings.ev, 0, 0.3);
    /* A little to the left of the middle is 0, and not -0. */
    for (double x = END - 75; x < END - 50; x += 0.1) {
        app.mouse[0] = x;
        view_panel_point(&app, true);
        CHECK(fabs(app.settings.ev) > 1e-9 || !signbit(app.settings.ev));
    }
    app.mouse[0] = 0;
    view_panel_point(&app, true);
    CHECK_NEAR(app.settings.ev, -8, 1e-9);
    app.mouse[0] = WIDTH + 99;
    view_panel_point(&app, true);
    CHECK_NEAR(app.settings.ev, 8, 1e-9);
}

/* The leftmost place with a control, at the height of the first one. */
static double left_of_panel(void)
{
    double x = 0;

    while (x < app.width && !press(x, 40 * app.width / 1280.0))
        x += 1;
    return x;
}

/* The panel covers no sphere, and all are seen, in more than half of the rest.
 */
TEST(covers_no_sphere)
{
    static const int sizes[][2] = {{1280, 720}, {640, 480}, {500, 900}};

    begin(VIEW_SPHERES);
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) {
        const int width = sizes[i][0], height = sizes[i][1];
        bool seen[VIEW_MAX_GRID * VIEW_MAX_GRID] = {false};
        int *shown = malloc(sizeof *shown * (size_t)(width * height)),
            count = 0;
        NEED(shown);
        app.width = width;
        app.height = height;
        const double left = left_of_panel();
        int right = 0;
        app.settings = options.settings;
        app.settings.covered = view_panel_share(&app);
        view_errors_spheres(&app.settings, width, height, shown);
        for (int k = 0; k < width * height; k++) {
            if (shown[k] < 0)
                continue;
            right = k % width > right ? k % width : right;
            count += !seen[shown[k]];
            seen[shown[k]] = true;
        }
        CHECK(count == app.settings.rows * app.settings.columns);
        CHECK_MSG(right < left && right > 0.5 * left, "%d, %g", right, left);
        free(shown);
    }
}

/* Nothing happens beside the panel; hidden, only its title is there. */
TEST(leaves_the_rest)
{
    begin(VIEW_SPHERES);
    for (int y = 0; y < HEIGHT; y += STEP)
        CHECK(!press(0.5 * WIDTH, y));
    CHECK(!press(END, HEIGHT - 2));
    options.settings.panel = false;
    view_settings want = options.settings;
    want.panel = true;
    CHECK(reaches(&want, END));
    for (int y = 60; y < HEIGHT; y += STEP)
        CHECK(!press(END, y));
}

/* ---- two sets ------------------------------------------------------------ */

enum {
    SMALL = 96,
    FLOATS = 3 * SMALL * SMALL
};

static void end(void *renderer)
{
    view_renderer_free(renderer);
}

static view_renderer *draw(const baked_set *a, const baked_set *b,
                           const view_settings *s)
{
    view_renderer *r = view_renderer_create();

    NEED(r);
    test_defer(end, r);
    NEED(view_renderer_load(r, a) && (!b || view_renderer_against(r, b)) &&
         view_renderer_draw(r, s, SMALL, SMALL));
    return r;
}

/* Each side is what its set alone gives, to the bit. */
TEST(two_sets)
{
    static baked_set white, other;
    static float alone[FLOATS], side[FLOATS];
    const ibl_specular_options small = {.size = 8, .levels = 2};
    ibl_ctx *ctx = view_test_ctx(1);
    view_settings s = view_settings_default();
    ibl_image map = sets_map(ctx, 32, 9);

    view_test_begin(SMALL, SMALL);
    sets_white(&white);
    ibl_specular_options o = ibl_specular_options_default();
    o.size = small.size;
    o.levels = small.levels;
    NEED(sets_bake_image(ctx, "other", &map, &o, &other));
    const baked_set *sets[2] = {&white, &other};
    s.rows = s.columns = 3;
    s.turn = 20;
    s.compare = VIEW_DIFFERENCE;
    s.against = s.reflection;
    const view_renderer *both = draw(&white, &other, &s);
    s.compare = VIEW_ALONE;
    for (int i = 0; i < 2; i++) {
        const view_renderer *one = draw(sets[i], NULL, &s);
        NEED(view_renderer_read(one, false, alone) &&
             view_renderer_read(both, i, side));
        CHECK_MSG(!memcmp(alone, side, sizeof side), "side %d", i);
    }
    view_set_free(&other);
}
