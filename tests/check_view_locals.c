/* SPDX-License-Identifier: MIT */
/* Local probes of the scene: where they are put, and that pictures with many of
 * them are those of ibl/probes.h, with masks of tiles as without. */
#include "room.h"
#include "view.h"
#include "view/program.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "ibl/probes.h"
#include "view/scene_captures.h"

enum {
    MOST = IBL_MAX_PROBES,
    PLACED = VIEW_MAX_LOCALS, /* by the viewer, as many as in a mask */
    WIDTH = 150,              /* no whole tiles */
    HEIGHT = 100
};

static const struct {
    double eye[3], at[3], fov;
} views[] = {
    {{3.4, 2.3, 4.6}, {-0.8, 1.2, -1}, 70},
    {{-4.5, 1.3, -0.3}, {3, 1, 0.4}, 100},
    {{0.2, 3.8, 0.3}, {0.3, 0, 0.1}, 40},
    {{-9, 3, 8}, {0, 1, 0}, 50}, /* from outside */
};
enum {
    VIEWS = sizeof views / sizeof *views
};

/* ---- where they are ------------------------------------------------------ */

static bool is_free(const double p[3])
{
    double middle[3], radius, away = 0;

    for (int i = 0; i < VIEW_ROOM_BOXES; i++) {
        const view_room_box *b = view_room_box_at(i);
        int in = 0;
        for (int k = 0; k < 3; k++)
            in += p[k] > b->low[k] - 0.1 && p[k] < b->high[k] + 0.1;
        if (in == 3)
            return false;
    }
    view_room_sphere(0, 0, middle, &radius);
    for (int k = 0; k < 3; k++)
        away += (p[k] - middle[k]) * (p[k] - middle[k]);
    return sqrt(away) > radius + 0.1;
}

/* Of all there are 1 at least everywhere in the room, walls and all. */
static double least_sum(const ibl_probe *probes, int count, test_random *r)
{
    double least = INFINITY;

    for (int i = 0; i < 500; i++) {
        double p[3], sum = 0;
        for (int k = 0; k < 3; k++)
            p[k] = view_room_centre[k] +
                   view_room_half[k] *
                       fmin(fmax(test_random_between(r, -1.1, 1.1), -1), 1);
        for (int n = 0; n < count; n++)
            sum += ibl_probe_influence(&probes[n], p);
        least = fmin(least, sum);
    }
    return least;
}

TEST(placed)
{
    ibl_probe probes[PLACED];
    int order[PLACED];
    test_random r = {5};

    for (int count = 1; count <= PLACED; count++) {
        view_scene_place(probes, count);
        ibl_probes_order(probes, count, order);
        for (int i = 0; i < count; i++) {
            const ibl_probe *p = &probes[i];
            CHECK(order[i] == i && p->layer == i);
            CHECK_MSG(is_free(p->position), "%d of %d: %g %g", i, count,
                      p->position[0], p->position[2]);
            CHECK_MSG(ibl_probe_influence(p, p->position) > 0, "%d of %d", i,
                      count);
            CHECK(p->has_proxy && p->blend > 0.3);
        }
        const double least = least_sum(probes, count, &r);
        CHECK_MSG(least > 1 - 1e-9, "%d: %g", count, least);
    }
}

/* ---- pictures ------------------------------------------------------------ */

/* A room of metal that reflects only probes, each of one colour. */
typedef struct look {
    ibl_probe probes[MOST + 1]; /* the dynamic one is the last */
    float colour[MOST + 1][4];
    view_room_draw draw;
} look;

static void fill_colours(look *l, test_random *r, double least_alpha)
{
    for (int i = 0; i <= MOST; i++) {
        const double a = test_random_between(r, least_alpha, 1);
        for (int k = 0; k < 3; k++)
            l->colour[i][k] = (float)(a * test_random_between(r, 0, 2));
        l->colour[i][3] = (float)a;
    }
}

/* Small boxes all over the room, of two priorities around the dynamic one's. */
static void scatter(ibl_probe *probes, int count)
{
    test_random r = {11};

    for (int i = 0; i < count; i++) {
        ibl_probe *p = &probes[i];
        *p = (ibl_probe){.blend = 0.2, .priority = i < 40 ? 2 : 0, .layer = i};
        for (int k = 0; k < 3; k++) {
            p->position[k] = view_room_centre[k] +
                             view_room_half[k] * test_random_between(&r, -1, 1);
            p->influence.centre[k] = p->position[k];
            p->influence.half[k] = 0.4 + 1e-3 * i;
        }
    }
}

/* In order, with the last one's cell by itself: about the mirror. */
static void place(look *l, int count)
{
    ibl_probe *dynamic = &l->probes[MOST];

    (count > PLACED ? scatter : view_scene_place)(l->probes, count);
    *dynamic = (ibl_probe){.position = {0, 0.9, 0},
                           .influence = {.half = {1.7, 2.3, 1.5}},
                           .blend = 0.7,
                           .priority = 1};
}

static look *begin(int count, double least_alpha)
{
    static float dark[MOST][4];
    look *l = test_alloc(1, sizeof *l);
    test_random r = {7};

    lit_begin(WIDTH, HEIGHT);
    place(l, count);
    fill_colours(l, &r, least_alpha);
    for (int i = 0; i < MOST; i++)
        dark[i][3] = 1;
    l->draw.locals = (view_probe_maps){
        .count = count,
        .probe = l->probes,
        .specular = room_cubes_of(count, (const float(*)[4])l->colour),
        .irradiance = room_cubes_of(count, (const float(*)[4])dark),
        .irradiance_scale = 1};
    l->draw.dynamic = (view_probe_maps){
        .count = 1,
        .probe = &l->probes[MOST],
        .specular = room_cubes_of(1, (const float(*)[4])l->colour[MOST]),
        .irradiance = lit.black_layer};
    return l;
}

static void look_at(look *l, int view)
{
    const view_camera c = room_camera(views[view].eye, views[view].at,
                                      views[view].fov, WIDTH, HEIGHT);
    const view_room_draw before = l->draw;

    l->draw = lit_draw(&c);
    l->draw.moving = false;
    l->draw.locals = before.locals;
    l->draw.dynamic = before.dynamic;
    l->draw.environment.irradiance = lit.black;
    l->draw.environment.sky = lit.black;
}

/* ---- masks --------------------------------------------------------------- */

static unsigned long long *read_masks(int *columns, int *rows)
{
    GLuint framebuffer;
    GLint masks;

    *columns = (WIDTH + VIEW_ROOM_TILE - 1) / VIEW_ROOM_TILE;
    *rows = (HEIGHT + VIEW_ROOM_TILE - 1) / VIEW_ROOM_TILE;
    const size_t count = (size_t)(*columns * *rows);
    gl.ActiveTexture(GL_TEXTURE0 + VIEW_ROOM_UNIT_MASKS);
    gl.GetIntegerv(GL_TEXTURE_BINDING_2D, &masks);
    unsigned *words = test_alloc(count, 2 * sizeof *words);
    unsigned long long *all = test_alloc(count, sizeof *all);
    gl.GenFramebuffers(1, &framebuffer);
    gl.BindFramebuffer(GL_FRAMEBUFFER, framebuffer);
    gl.FramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D,
                            (GLuint)masks, 0);
    gl.ReadPixels(0, 0, *columns, *rows, GL_RG_INTEGER, GL_UNSIGNED_INT, words);
    gl.DeleteFramebuffers(1, &framebuffer);
    for (size_t i = 0; i < count; i++)
        all[i] = words[2 * i] | (unsigned long long)words[2 * i + 1] << 32;
    return all;
}

/* Each tile in which a point of a probe is seen has its bit. */
static void check_masks(const look *l, int view, test_random *r)
{
    const int locals = l->draw.locals.count;
    int columns, rows, at[2], bits = 0;
    unsigned long long *masks = read_masks(&columns, &rows);
    double p[3];

    for (int i = 0; i < locals; i++) {
        for (int k = 0; k < 1000; k++) {
            view_test_point_of(r, &l->probes[i].influence, p);
            if (view_test_pixel(l->draw.clip, WIDTH, HEIGHT, p, at))
                CHECK_MSG(masks[at[1] / VIEW_ROOM_TILE * columns +
                                at[0] / VIEW_ROOM_TILE] >>
                                  i &
                              1,
                          "view %d, probe %d: not at %d, %d", view, i, at[0],
                          at[1]);
        }
    }
    for (int i = 0; i < columns * rows; i++)
        bits += __builtin_popcountll(masks[i]);
    /* Else there is nothing to be gained. */
    CHECK_MSG(bits < columns * rows * locals * 3 / 4 && bits > columns * rows,
              "view %d: %d of %d", view, bits, columns * rows * locals);
}

TEST(masks_miss_nothing)
{
    look *l = begin(PLACED, 1);
    test_random r = {3};

    for (int view = 0; view < VIEWS; view++) {
        look_at(l, view);
        lit_render(&l->draw);
        check_masks(l, view, &r);
    }
}

static void compare_tiles(look *l, int view)
{
    int bad = 0;

    l->draw.untiled = false;
    float *with = lit_render(&l->draw);
    l->draw.untiled = true;
    float *without = lit_render(&l->draw);
    for (int i = 0; i < WIDTH * HEIGHT; i++)
        bad += memcmp(with + 4 * i, without + 4 * i, 4 * sizeof *with) != 0;
    CHECK_MSG(bad == 0, "view %d: %d pixels", view, bad);
}

/* Pixel for pixel, whichever way round the picture is. */
TEST_SLOW(tiles_change_nothing)
{
    look *l = begin(MOST, 0.3);

    for (int view = 0; view < VIEWS; view += 3) {
        look_at(l, view);
        compare_tiles(l, view);
        l->draw.sharp = true;
        compare_tiles(l, view);
        l->draw.sharp = false;
        for (int i = 0; i < 16; i += 4)
            l->draw.clip[i] = -l->draw.clip[i];
        compare_tiles(l, view);
    }
}

/* ---- weights ------------------------------------------------------------- */

/* How many have a share. */
static int count_shares(const ibl_probe *probes, int count, const int *order,
                        const double *alpha, const double point[3])
{
    double rest = 1;
    int shares = 0;

    for (int i = 0; i < count && rest > 0; i++) {
        const double share =
            ibl_probe_influence(&probes[order[i]], point) * alpha[order[i]];
        rest -= share;
        shares += share > 0;
    }
    return shares;
}

/* The light of a point by the library, of colours that are multiplied by alpha;
 * false where it leaves out a probe with a share. */
static bool blend(const look *l, const double point[3], double rgb[3])
{
    const int count = l->draw.locals.count;
    ibl_probe probes[MOST + 1];
    double alpha[MOST + 1];
    int order[MOST + 1];
    ibl_probe_mix mix;

    for (int i = 0; i <= count; i++) {
        const int from = i < count ? i : MOST;
        probes[i] = l->probes[from];
        alpha[i] = (double)l->colour[from][3];
    }
    ibl_probes_order(probes, count + 1, order);
    ibl_probes_blend(probes, count + 1, order, point, alpha, &mix);
    for (int k = 0; k < 3; k++) {
        rgb[k] = mix.rest;
        for (int i = 0; i < mix.count; i++) {
            const int at = mix.probe[i] < count ? mix.probe[i] : MOST;
            rgb[k] +=
                mix.weight[i] * (double)l->colour[at][k] / alpha[mix.probe[i]];
        }
    }
    return count_shares(probes, count + 1, order, alpha, point) <=
           IBL_MAX_PROBES_AT;
}

static void compare_weights(look *l, int view)
{
    const view_camera c = room_camera(views[view].eye, views[view].at,
                                      views[view].fov, WIDTH, HEIGHT);
    float *picture = lit_render(&l->draw);
    int all = 0, bad = 0;

    for (int i = 0; i < WIDTH * HEIGHT; i++) {
        double ray[3], rgb[3], worst = 0;
        view_camera_ray(&c, WIDTH, HEIGHT, i % WIDTH, i / WIDTH, ray);
        const room_hit h = room_cast(&l->draw, c.eye, ray);
        /* Spheres are of triangles. */
        if (h.what < 0 || h.what >= VIEW_ROOM_BOXES ||
            h.material->emission[0] > 0 || !blend(l, h.point, rgb))
            continue;
        for (int k = 0; k < 3; k++)
            worst = fmax(worst, fabs((double)picture[4 * i + k] /
                                         (double)h.material->f0[k] -
                                     rgb[k]));
        all++;
        bad += !(worst < 1e-3);
    }
    /* But where two things meet. */
    CHECK_MSG(all > WIDTH * HEIGHT / 3, "view %d: %d pixels", view, all);
    CHECK_MSG(bad * 200 <= all, "view %d: %d of %d pixels", view, bad, all);
}

TEST(weights_are_those_of_the_library)
{
    look *l = begin(MOST, 0.6);

    for (int view = 0; view < VIEWS - 1; view++) {
        look_at(l, view);
        compare_weights(l, view);
    }
}

/* ---- walls --------------------------------------------------------------- */

/* The length of the way between two points that is in a wall or a pillar. */
static double hidden_length(const double a[3], const double b[3])
{
    enum {
        PARTS = 2000
    };
    int in = 0;
    double length = 0;

    for (int k = 0; k < 3; k++)
        length += (b[k] - a[k]) * (b[k] - a[k]);
    for (int n = 0; n < PARTS; n++)
        for (int i = 0; i < VIEW_ROOM_BOXES; i++) {
            const view_room_box *box = view_room_box_at(i);
            bool inside = true;
            for (int k = 0; k < 3; k++) {
                const double x = a[k] + (b[k] - a[k]) * (n + 0.5) / PARTS;
                inside = inside && x > box->low[k] && x < box->high[k];
            }
            in += inside;
        }
    return sqrt(length) * in / PARTS;
}

/* Red and green on either side of the wall in the corner, red first; blue in
 * the middle of the room. */
static look *begin_walls(void)
{
    look *l = begin(2, 1);

    l->probes[0] = (ibl_probe){.position = {4.2, 1.5, -4},
                               .influence = {.half = {9, 9, 9}},
                               .priority = 2};
    l->probes[1] = (ibl_probe){.position = {1.7, 1.5, -4},
                               .influence = {.half = {9, 9, 9}},
                               .priority = 1,
                               .layer = 1};
    l->probes[MOST] =
        (ibl_probe){.position = {0, 2.5, 0}, .influence = {.half = {9, 9, 9}}};
    memset(l->colour, 0, sizeof l->colour);
    for (int i = 0; i < 3; i++) {
        float *rgba = l->colour[i < 2 ? i : MOST];
        rgba[i] = rgba[3] = 1;
    }
    l->draw.locals.specular = room_cubes_of(2, (const float(*)[4])l->colour);
    l->draw.dynamic.specular =
        room_cubes_of(1, (const float(*)[4])l->colour[MOST]);
    return l;
}

/* The only probe whose light a point may have, in order the first in view; -1:
 * a way touches a wall, or none is in view. */
static int seen_from(const look *l, const double point[3])
{
    for (int i = 0; i < 3; i++) {
        const double in =
            hidden_length(point, l->probes[i < 2 ? i : MOST].position);
        if (in <= 0)
            return i;
        if (in < 0.65) /* a pillar is 0.6 thick */
            return -1;
    }
    return -1;
}

static void compare_walls(look *l, int view, int seen[3])
{
    const view_camera c = room_camera(views[view].eye, views[view].at,
                                      views[view].fov, WIDTH, HEIGHT);
    int bad = 0;

    look_at(l, view);
    l->draw.walls = true;
    float *with = lit_render(&l->draw);
    l->draw.walls = false;
    float *without = lit_render(&l->draw);
    for (int i = 0; i < WIDTH * HEIGHT; i += 7) {
        double ray[3];
        view_camera_ray(&c, WIDTH, HEIGHT, i % WIDTH, i / WIDTH, ray);
        const room_hit h = room_cast(&l->draw, c.eye, ray);
        if (h.what < 0 || h.what >= VIEW_ROOM_BOXES ||
            h.material->emission[0] > 0)
            continue;
        const int only = seen_from(l, h.point);
        for (int k = 0; k < 3; k++) {
            const double f0 = (double)h.material->f0[k];
            bad += only >= 0 &&
                   fabs((double)with[4 * i + k] / f0 - (k == only)) > 4e-3;
            bad += fabs((double)without[4 * i + k] / f0 - !k) > 1e-3;
        }
        if (only >= 0)
            seen[only]++;
    }
    CHECK_MSG(bad < 40, "view %d: %d", view, bad);
}

/* Each point has the light of the first probe that it can see. */
TEST_SLOW(walls_hide_probes)
{
    look *l = begin_walls();
    int seen[3] = {0};

    for (int view = 0; view < VIEWS - 1; view++)
        compare_walls(l, view, seen);
    CHECK_MSG(seen[0] > 200 && seen[1] > 100 && seen[2] > 5, "%d, %d, %d",
              seen[0], seen[1], seen[2]);
}

/* A probe that is alone keeps its light behind a wall, too. */
TEST(hidden_from_all)
{
    look *l = begin_walls();

    l->draw.dynamic.count = 0;
    l->draw.locals.count = 1;
    look_at(l, 0);
    l->draw.locals.count = 1;
    l->draw.dynamic.count = 0;
    l->draw.walls = true;
    float *with = lit_render(&l->draw);
    l->draw.walls = false;
    float *without = lit_render(&l->draw);
    for (int i = 0; i < 4 * WIDTH * HEIGHT; i++)
        CHECK_NEAR(with[i], without[i], 1e-4);
}

/* ---- without arrays of cubes --------------------------------------------- */

static PFNGLGETINTEGERVPROC real_integers;

static void APIENTRY old_integers(GLenum name, GLint *value)
{
    if (name == GL_MAJOR_VERSION)
        *value = 3;
    else
        real_integers(name, value);
}

static const char *named; /* by old_strings */

static const GLubyte *APIENTRY old_strings(GLenum name, GLuint i)
{
    (void)name;
    return (const GLubyte *)(i == 1 ? named : "GL_ARB_other");
}

TEST(needs_cube_arrays)
{
    view_test_begin(16, 16);
    const PFNGLGETSTRINGIPROC strings = gl.GetStringi;
    real_integers = gl.GetIntegerv;
    gl.GetIntegerv = old_integers;
    gl.GetStringi = old_strings;
    named = "GL_ARB_texture_cube_map_array_not";
    view_test_catch();
    view_room *room = view_room_create();
    CHECK(!room);
    CHECK(strstr(view_test_caught(), "ARB_texture_cube_map_array"));
    named = "GL_ARB_texture_cube_map_array";
    room = view_room_create();
    CHECK(room != NULL);
    view_room_free(room);
    gl.GetIntegerv = real_integers;
    gl.GetStringi = strings;
}
