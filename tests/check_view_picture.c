/* SPDX-License-Identifier: MIT */
/* Pictures as files and what is written on them: linear floats, spheres that
 * are split one by one, labels. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "files.h"
#include "maps.h"
#include "shade.h"
#include "view.h"
#include "view/inspect.h"
#include "view/labels.h"
#include "view/picture.h"

enum {
    WIDTH = 480,
    HEIGHT = 320,
    FLOATS = 3 * WIDTH * HEIGHT
};

static shade_set *const set = &shade_sets[0];

static float *floats(void)
{
    return test_alloc(FLOATS, sizeof(float));
}

/* Two reflections of noise on 2 x 3 spheres. */
static view_settings two(view_compare compare)
{
    ibl_specular_options o = ibl_specular_options_default();
    view_settings s = view_settings_default();

    shade_begin(WIDTH, HEIGHT);
    const ibl_image map = map_constant(shade_ctx(), 32, 16, 0);
    map_fill(&map, 5);
    o.size = 16;
    o.levels = 4;
    shade_bake(set, &map, &o);
    s.rows = 2;
    s.columns = 3;
    s.compare = compare;
    s.against = VIEW_BENT;
    s.ev = 2;
    s.roughness[0] = 0.4;
    shade_draw(&set->set, &s);
    return s;
}

/* What the file holds is what was drawn, without exposure and tone curve. */
TEST(exr_holds_radiance)
{
    const view_settings s = two(VIEW_ALONE);
    view_renderer *r = shade_renderer();
    float *drawn = floats(), *linear = floats();
    ibl_image back = {0};
    const char *path = file_path("a.exr");

    CHECK(s.ev > 1 && view_renderer_read(r, false, drawn));
    CHECK(view_renderer_linear(r, linear));
    CHECK(!memcmp(drawn, linear, FLOATS * sizeof *drawn));
    CHECK(view_picture_is_linear(path) && !view_picture_is_linear("a.png"));
    CHECK(view_picture_write(shade_ctx(), path, WIDTH, HEIGHT, linear));
    ibl_read_options o = ibl_read_options_default();
    o.any_aspect = 1;
    CHECK(!ibl_image_read(shade_ctx(), path, &o, &back, NULL));
    CHECK(back.width == WIDTH && back.height == HEIGHT);
    CHECK(!memcmp(back.data, linear, FLOATS * sizeof *linear));
    ibl_image_free(&back);
}

TEST(differences_without_gain)
{
    two(VIEW_DIFFERENCE);
    view_renderer *r = shade_renderer();
    float *a = floats(), *b = floats(), *linear = floats();

    CHECK(view_renderer_read(r, false, a) && view_renderer_read(r, true, b) &&
          view_renderer_linear(r, linear));
    for (int i = 0; i < FLOATS; i++)
        CHECK_NEAR(linear[i], fabs((double)a[i] - b[i]), 1e-7);
}

/* The left half of each sphere is one reflection, the right half the other. */
TEST(each_sphere_is_split)
{
    view_settings s = two(VIEW_SPLIT);
    view_sphere balls[VIEW_MAX_GRID * VIEW_MAX_GRID];
    view_renderer *r = shade_renderer();
    float *side[2] = {floats(), floats()}, *linear = floats();
    int seen[2] = {0};

    CHECK(view_renderer_read(r, false, side[0]) &&
          view_renderer_read(r, true, side[1]) &&
          view_renderer_linear(r, linear));
    view_grid(&s, balls);
    const view_camera c = view_camera_of(&s, WIDTH, HEIGHT);
    const shade_pixel *shown = shade_pixels(&s);
    for (int i = 0; i < WIDTH * HEIGHT; i++) {
        double d[3];
        if (shown[i].sphere < 0)
            continue;
        view_camera_ray(&c, WIDTH, HEIGHT, i % WIDTH, i / WIDTH, d);
        const double x = c.eye[0] - c.eye[2] / d[2] * d[0];
        const double off = x - balls[shown[i].sphere].centre[0];
        if (fabs(off) < 1e-3)
            continue;
        CHECK(!memcmp(linear + 3 * i, side[off > 0] + 3 * i, 12));
        seen[off > 0] += memcmp(side[0] + 3 * i, side[1] + 3 * i, 12) != 0;
    }
    CHECK_MSG(seen[0] > 2000 && seen[1] > 2000, "%d, %d", seen[0], seen[1]);
}

/* ---- labels ----------------------------------------------------------------
 */

/* Pixels above half of white in a part of the picture after labels on black. */
static int ink(const unsigned char *rgb, int x0, int y0, int x1, int y1)
{
    int count = 0;

    for (int y = y0; y < y1; y++)
        for (int x = x0; x < x1; x++)
            count += rgb[3 * (y * WIDTH + x)] > 128;
    return count;
}

static unsigned char *labelled(const view_settings *s, int width,
                               const char *title)
{
    view_overlay *o = view_overlay_create();

    gl.BindFramebuffer(GL_FRAMEBUFFER, 0);
    gl.Viewport(0, 0, WIDTH, HEIGHT);
    gl.ClearColor(0, 0, 0, 1);
    gl.Clear(GL_COLOR_BUFFER_BIT);
    view_labels_draw(o, s, &set->set, width, HEIGHT, title);
    view_overlay_free(o);
    unsigned char *rgb = view_picture_read(0, WIDTH, HEIGHT);
    test_defer(free, rgb);
    return rgb;
}

TEST(labels_are_beside_the_grid)
{
    char title[VIEW_LABEL_BYTES];
    view_settings s = two(VIEW_SPLIT);

    s.border = 0.2;
    set->set.name = (char *)"noise";
    view_labels_title(&s, shade_renderer(), &set->set, title);
    CHECK_MSG(!strcmp(title, "noise, gold\nof each sphere left: split, right: "
                             "bent, EV +2"),
              "%s", title);
    const unsigned char *rgb = labelled(&s, WIDTH, title);
    const shade_pixel *shown = shade_pixels(&s);
    int low = HEIGHT, high = 0, left = WIDTH, right = 0;
    for (int i = 0; i < WIDTH * HEIGHT; i++)
        if (shown[i].sphere >= 0) {
            low = low < i / WIDTH ? low : i / WIDTH;
            high = high > i / WIDTH ? high : i / WIDTH;
            left = left < i % WIDTH ? left : i % WIDTH;
            right = right > i % WIDTH ? right : i % WIDTH;
        }
    CHECK(ink(rgb, 0, 0, WIDTH, low) > 100);          /* the title */
    CHECK(ink(rgb, left, high, right, HEIGHT) > 20);  /* of columns */
    CHECK(ink(rgb, 0, low, left, high) > 20);         /* of rows */
    CHECK(ink(rgb, left + 2, low, right, high) == 0); /* the spheres */
    CHECK(ink(labelled(&s, 40, title), 0, 0, WIDTH, HEIGHT) == 0);
    set->set.name = NULL;
}

/* In the faces, also where these are cut: nothing is written beside them. */
TEST(faces_are_named_inside)
{
    view_settings s = two(VIEW_ALONE);
    int inside = 0, beside = 0;

    s.mode = VIEW_LEVELS;
    s.zoom = 2.5;
    s.pan[0] = 0.2;
    s.pan[1] = 0.1;
    const unsigned char *rgb = labelled(&s, WIDTH, "");
    for (int y = 0; y < HEIGHT; y++)
        for (int x = 0; x < WIDTH; x++)
            *(view_inspect(&set->set, &s, WIDTH, HEIGHT, x, y).inside
                  ? &inside
                  : &beside) += ink(rgb, x, y, x + 1, y + 1);
    CHECK_MSG(inside > 20 && !beside, "%d, %d", inside, beside);
}

/* Greys from black to white, and what is white. */
TEST(differences_have_a_scale)
{
    view_settings s = two(VIEW_DIFFERENCE);
    char title[VIEW_LABEL_BYTES];

    set->set.name = (char *)"noise";
    view_labels_title(&s, shade_renderer(), &set->set, title);
    CHECK(strstr(title, "|split - bent|"));
    const unsigned char *rgb = labelled(&s, WIDTH, title);
    const unsigned char *row = rgb + (size_t)(3 * 12 * WIDTH);
    int last = -1;
    for (int x = WIDTH - 215; x < WIDTH - 10; x++) {
        CHECK(row[3 * x] >= last && row[3 * x] == row[3 * x + 1]);
        last = row[3 * x];
    }
    CHECK(last > 250);
    set->set.name = NULL;
}
