/* SPDX-License-Identifier: MIT */
/* The room against rays that are cast in double into its boxes and spheres, and
 * the weights of its probes in C, in GLSL and as the library has them. */
#include "maps.h"
#include "room.h"
#include "view.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "ibl/ibl.h"
#include "view/room.h"

enum {
    MOST = IBL_MAX_PROBES,
    WIDTH = 150, /* no whole tiles */
    HEIGHT = 100,
    CUBE = 64
};

static const struct {
    double eye[3], at[3], seconds;
} views[] = {
    {{3.4, 2.3, 4.6}, {-0.8, 1.2, -1}, 0},
    {{-4.5, 1.3, -0.3}, {3, 1, 0.4}, 1.7},
    {{0.2, 3.8, 0.3}, {0.3, 0, 0.1}, 3.1},
    {{-9, 3, 8}, {0, 1, 0}, 4.4}, /* from outside */
};
enum {
    VIEWS = sizeof views / sizeof *views
};

static view_camera camera_of(int view)
{
    return room_camera(views[view].eye, views[view].at, 70, WIDTH, HEIGHT);
}

/* What pixel i shows. */
static room_hit hit_of(const view_room_draw *d, int i, double ray[3])
{
    view_camera_ray(&d->camera, WIDTH, HEIGHT, i % WIDTH, i / WIDTH, ray);
    return room_cast(d, d->camera.eye, ray);
}

/* ---- what is before what ------------------------------------------------ */

/* Whether a ray near the pixel's centre sees that colour at that depth, which
 * is read the other way round than view_camera_matrix makes it. Edges of
 * spheres are those of triangles. */
static bool is_seen(const view_room_draw *d, int pixel, const float *rgba,
                    double z)
{
    const view_camera *c = &d->camera;
    const double a = (c->far + c->near) / (c->far - c->near);
    const double b = -2 * c->far * c->near / (c->far - c->near);
    const double depth = b / (2 * z - 1 - a);

    for (int i = 0; i < 9; i++) {
        double direction[3];
        view_camera_ray(
            c, WIDTH, HEIGHT, pixel % WIDTH + 0.06 * ((i + 1) % 3 - 1),
            pixel / WIDTH + 0.06 * ((i + 4) / 3 % 3 - 1), direction);
        const room_hit h = room_cast(d, c->eye, direction);
        const double away = h.distance * test_dot(direction, c->forward);
        const bool round = h.what >= VIEW_ROOM_BOXES;
        if (lit_has_colour(rgba, &h, 1e-4) &&
            (h.what < 0 ? depth > 39
                        : fabs(away - depth) < (round ? .06 : .004)))
            return true;
    }
    return false;
}

TEST(depth_order)
{
    float *depths = test_alloc((size_t)WIDTH * HEIGHT, sizeof *depths);

    lit_begin(WIDTH, HEIGHT);
    for (int v = 0; v < VIEWS; v++) {
        const view_camera c = camera_of(v);
        view_room_draw d = lit_draw(&c);
        int bad = 0;
        d.seconds = views[v].seconds;
        d.environment.turn = 40 * v;
        float *picture = lit_render(&d);
        gl.ReadPixels(0, 0, WIDTH, HEIGHT, GL_DEPTH_COMPONENT, GL_FLOAT,
                      depths);
        for (int i = 0; i < WIDTH * HEIGHT; i++)
            bad += !is_seen(
                &d, i, picture + 4 * i,
                (double)depths[WIDTH * (HEIGHT - 1 - i / WIDTH) + i % WIDTH]);
        CHECK_MSG(bad == 0, "view %d: %d pixels", v, bad);
    }
}

/* ---- parallax ------------------------------------------------------------ */

/* Where one looks at the inside of the room's box, or of the sphere around it.
 */
typedef struct inside {
    double from[3];
    bool round;
} inside;

static void look_inside(const inside *in, const double from[3],
                        const double d[3], double at[3])
{
    double t = INFINITY, off[3];

    for (int k = 0; k < 3; k++) {
        off[k] = from[k] - view_room_centre[k];
        if (d[k] != 0)
            t = fmin(t, (copysign(view_room_half[k], d[k]) - off[k]) / d[k]);
    }
    if (in->round) {
        const double along = test_dot(off, d);
        t = sqrt(along * along - test_dot(off, off) +
                 test_dot(view_room_half, view_room_half)) -
            along;
    }
    for (int k = 0; k < 3; k++)
        at[k] = from[k] + t * d[k];
}

static void place_texel(void *cookie, const double direction[3], float rgba[4])
{
    const inside *in = cookie;
    double at[3];

    look_inside(in, in->from, direction, at);
    for (int k = 0; k < 3; k++)
        rgba[k] = (float)at[k];
    rgba[3] = 1;
}

/* For all of the room. */
static ibl_probe room_probe(const double position[3])
{
    ibl_probe p = {.influence = {.half = {6, 6, 6}}, .has_proxy = 1};

    for (int k = 0; k < 3; k++) {
        p.position[k] = position[k];
        p.influence.centre[k] = p.proxy.centre[k] = view_room_centre[k];
        p.proxy.half[k] = view_room_half[k];
    }
    return p;
}

/* The share of pixels of floor and mirror that do not reflect what is seen from
 * there, to within a texel. */
static double wrong_share(const view_room_draw *d, const inside *in)
{
    const float *picture = lit_render(d);
    int all = 0, wrong = 0;

    for (int i = 0; i < WIDTH * HEIGHT; i++) {
        double ray[3], r[3], at[3], apart = 0, away = 0;
        const room_hit h = hit_of(d, i, ray);
        const double cosine = test_dot(ray, h.normal);
        if ((h.what != VIEW_ROOM_BOXES && !room_is_floor(&h)) || cosine > -0.1)
            continue;
        for (int k = 0; k < 3; k++)
            r[k] = ray[k] - 2 * cosine * h.normal[k];
        look_inside(in, h.point, r, at);
        for (int k = 0; k < 3; k++) {
            const double f0 = (double)h.material->f0[k];
            apart += pow((double)picture[4 * i + k] / f0 - at[k], 2);
            away += pow(at[k] - in->from[k], 2);
        }
        all++;
        wrong += !(sqrt(apart) <= 3.5 / CUBE * sqrt(away)); /* in a corner */
    }
    CHECK(all > 500);
    return (double)wrong / all;
}

TEST(parallax)
{
    lit_begin(WIDTH, HEIGHT);
    for (int i = 0; i < 8; i++) {
        const double eye[3] = {1.7, 1.9, 1.9}, at[3] = {-0.3, 0.6, -0.2};
        const view_camera c = room_camera(eye, at, 60, WIDTH, HEIGHT);
        inside in = {{1.1, 1.7, -0.9}, i / 4};
        view_room_draw d = lit_draw(&c);
        ibl_probe probe = room_probe(in.from);
        d.moving = false;
        *(i % 2 ? &d.locals : &d.dynamic) =
            (view_probe_maps){.count = 1,
                              .probe = &probe,
                              .specular = room_layer(CUBE, place_texel, &in),
                              .irradiance = lit.black_layer};
        d.parallax = in.round ? VIEW_PARALLAX_SPHERE : VIEW_PARALLAX_BOX;
        const double with = wrong_share(&d, &in);
        if (i % 4 < 2)
            d.parallax = VIEW_PARALLAX_NONE;
        else
            probe.has_proxy = 0;
        const double without = wrong_share(&d, &in);
        CHECK_MSG(with < 0.01 && without > 0.7, "%d: %g, without: %g", i, with,
                  without);
    }
}

/* Its specular cubes have two levels, black then red, whose mix is the level
 * that is looked up; irradiance is scaled. */
TEST(levels_of_roughness)
{
    static const double origin[3] = {0, 1, 0}, eye[3] = {1.5, 1.5, 0.5},
                        at[3] = {1.5, 0, 0.5};
    const view_camera c = room_camera(eye, at, 0.1, 4, 4);
    const GLenum array = GL_TEXTURE_CUBE_MAP_ARRAY;
    ibl_probe probe = room_probe(origin);
    float texels[2][IBL_FACES * 4][4];

    lit_begin(4, 4);
    const GLuint cubes = room_layer_of(0, 0, 0, 1);
    for (int i = 0; i < IBL_FACES * 4; i++)
        for (int level = 0; level < 2; level++)
            memcpy(texels[level][i], (float[4]){(float)level, 0, 0, 1},
                   sizeof texels[level][i]);
    for (int level = 0; level < 2; level++)
        gl.TexImage3D(array, level, GL_RGBA32F, 2 >> level, 2 >> level,
                      IBL_FACES, 0, GL_RGBA, GL_FLOAT, texels[level]);
    gl.TexParameteri(array, GL_TEXTURE_MAX_LEVEL, 1);
    gl.TexParameteri(array, GL_TEXTURE_MIN_FILTER, GL_LINEAR_MIPMAP_LINEAR);
    for (int filament = 0; filament < 2; filament++) {
        view_room_draw d = lit_draw(&c);
        d.locals =
            (view_probe_maps){.count = 1,
                              .probe = &probe,
                              .specular = cubes,
                              .irradiance = room_layer_of(0, 0.25F, 0, 1),
                              .irradiance_scale = 2,
                              .filament = filament,
                              .lod_scale = 4,
                              .lod_offset = 0.125f,
                              .last_level = 1};
        const room_hit h = room_cast(&d, eye, (const double[3]){0, -1, 0});
        const double r = (double)h.material->roughness,
                     f0 = (double)h.material->f0[0];
        const float *picture = lit_render(&d);
        CHECK_NEAR((double)picture[0] / f0,
                   0.125 + 4 * (filament ? r * (2 - r) : r), 6e-3);
        CHECK_NEAR((double)picture[1],
                   0.5 * (1 - f0) * (double)h.material->albedo[1], 1e-5);
    }
}

/* ---- weights ------------------------------------------------------------- */

/* Probes of one colour each, times its alpha, in light of which there is no
 * other. The dynamic one is the last. */
typedef struct look {
    ibl_probe probes[MOST + 1];
    float colour[MOST + 1][4];
    view_room_draw draw;
} look;

static void look_at(look *l, int view)
{
    const view_camera c = camera_of(view);
    const view_room_draw before = l->draw;

    l->draw = lit_draw(&c);
    l->draw.moving = false;
    l->draw.locals = before.locals;
    l->draw.dynamic = before.dynamic;
    l->draw.environment.irradiance = lit.black;
    l->draw.environment.sky = lit.black;
}

/* Small boxes all over the room, of two priorities around the dynamic one's,
 * which is about the mirror. */
static look *begin(int count, double least_alpha)
{
    static float dark[MOST][4];
    look *l = test_alloc(1, sizeof *l);
    test_random r = {7};

    lit_begin(WIDTH, HEIGHT);
    for (int i = 0; i < count; i++) {
        ibl_probe *p = &l->probes[i];
        *p = (ibl_probe){.blend = 0.2, .priority = i < 40 ? 2 : 0, .layer = i};
        for (int k = 0; k < 3; k++) {
            p->position[k] = view_room_centre[k] +
                             view_room_half[k] * test_random_between(&r, -1, 1);
            p->influence.centre[k] = p->position[k];
            p->influence.half[k] = 0.4 + 1e-3 * i;
        }
    }
    l->probes[MOST] = (ibl_probe){.position = {0, 0.9, 0},
                                  .influence = {.half = {1.7, 2.3, 1.5}},
                                  .blend = 0.7,
                                  .priority = 1};
    for (int i = 0; i <= MOST; i++) {
        const double a = test_random_between(&r, least_alpha, 1);
        for (int k = 0; k < 3; k++)
            l->colour[i][k] = (float)(a * test_random_between(&r, 0, 2));
        l->colour[i][3] = (float)a;
        dark[i % MOST][3] = 1;
    }
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

/* The library's weights of a point, in the order of view_room_weights; false
 * where it leaves out a probe with a share. */
static bool blend(const look *l, bool with_alpha, const double point[3],
                  double *weights)
{
    const int count = l->draw.locals.count;
    ibl_probe probes[MOST + 1];
    double alpha[MOST + 1], rest = 1;
    int order[MOST + 1], shares = 0;
    ibl_probe_mix mix;

    for (int i = 0; i <= count; i++) {
        const int from = i < count ? i : MOST;
        probes[i] = l->probes[from];
        alpha[i] = with_alpha ? (double)l->colour[from][3] : 1;
        weights[i] = 0;
    }
    ibl_probes_order(probes, count + 1, order);
    ibl_probes_blend(probes, count + 1, order, point, alpha, &mix);
    for (int i = 0; i < mix.count; i++)
        weights[mix.probe[i]] = mix.weight[i];
    weights[count + 1] = mix.rest;
    for (int i = 0; i <= count && rest > 0; i++) {
        const double share =
            ibl_probe_influence(&probes[order[i]], point) * alpha[order[i]];
        rest -= share;
        shares += share > 0;
    }
    return shares <= IBL_MAX_PROBES_AT;
}

/* Colours are multiplied by alpha. */
TEST(weights_are_those_of_the_library)
{
    look *l = begin(MOST, 0.6);

    for (int view = 0; view < VIEWS - 1; view++) {
        int all = 0, bad = 0;
        look_at(l, view);
        const float *picture = lit_render(&l->draw);
        for (int i = 0; i < WIDTH * HEIGHT; i++) {
            double ray[3], weights[MOST + 2], worst = 0;
            const room_hit h = hit_of(&l->draw, i, ray);
            /* Spheres are of triangles. */
            if (h.what < 0 || h.what >= VIEW_ROOM_BOXES ||
                h.material->emission[0] > 0 ||
                !blend(l, true, h.point, weights))
                continue;
            for (int k = 0; k < 3; k++) {
                double sum = weights[MOST + 1];
                for (int n = 0; n <= MOST; n++)
                    sum += weights[n] * (double)l->colour[n][k] /
                           (double)l->colour[n][3];
                worst = fmax(worst, fabs((double)picture[4 * i + k] /
                                             (double)h.material->f0[k] -
                                         sum));
            }
            all++;
            bad += !(worst < 1e-3);
        }
        /* But where two things meet. */
        CHECK_MSG(all > WIDTH * HEIGHT / 3 && bad * 200 <= all,
                  "view %d: %d of %d pixels", view, bad, all);
    }
}

/* view_room_weights against the library, and against probes sorted by distance.
 */
TEST(weights_in_c)
{
    look *l = begin(60, 1);
    double w[MOST + 2], truth[MOST + 2];
    test_random r = {3};

    for (int n = 0; n < 600; n++) {
        const int count = l->draw.locals.count, k_of = 1 + n % 5;
        double p[3], away[MOST], sum = 0, all = 0;
        for (int k = 0; k < 3; k++)
            p[k] = view_room_centre[k] +
                   view_room_half[k] * test_random_between(&r, -1, 1);
        l->draw.choice = VIEW_PROBES_BLEND;
        view_room_weights(&l->draw, p, w);
        for (int i = 0; i <= count + 1 && blend(l, false, p, truth); i++)
            CHECK_NEAR(w[i], truth[i], 1e-9);
        l->draw.choice =
            k_of == 1 ? VIEW_PROBES_NEAREST : VIEW_PROBES_NEAREST_K;
        l->draw.nearest = k_of;
        view_room_weights(&l->draw, p, w);
        for (int i = 0; i < count; i++)
            away[i] = hypot(hypot(p[0] - l->probes[i].position[0],
                                  p[1] - l->probes[i].position[1]),
                            p[2] - l->probes[i].position[2]);
        for (int pass = 0; pass < 2; pass++)
            for (int i = 0; i < count; i++) {
                int nearer = 0;
                for (int j = 0; j < count; j++)
                    nearer += away[j] < away[i];
                if (!pass && nearer < k_of)
                    sum += 1 / away[i];
                if (pass)
                    CHECK_NEAR(w[i], nearer < k_of ? 1 / away[i] / sum : 0,
                               1e-9);
                all += pass * w[i];
            }
        CHECK_NEAR(all + w[count] + w[count + 1], 1, 1e-9);
    }
}

/* The hues that GLSL mixes are those that view_room_weights has, whichever
 * probes count, in mirrored pictures too. */
TEST(weights_are_drawn)
{
    look *l = begin(MOST, 1);

    for (int n = 0; n < 12; n++) {
        int bad = 0;
        look_at(l, n % VIEWS);
        l->draw.weights = true;
        l->draw.choice = (view_probe_choice)(n % VIEW_PROBE_CHOICES);
        l->draw.nearest = 1 + n / 2;
        l->probes[MOST].priority = n < 6 ? 1 : 3;
        for (int k = 0; k < 3 && n % 2; k++)
            l->draw.camera.right[k] *= -1;
        const float *picture = lit_render(&l->draw);
        for (int i = 0; i < WIDTH * HEIGHT; i += n ? 7 : 1) {
            double ray[3], w[MOST + 2], off = 0;
            const room_hit h = hit_of(&l->draw, i, ray);
            if (h.what < 0 || h.what >= VIEW_ROOM_BOXES)
                continue;
            view_room_weights(&l->draw, h.point, w);
            for (int k = 0; k < 3; k++) {
                double sum = -(double)picture[4 * i + k];
                for (int p = 0; p <= MOST + 1; p++) {
                    float rgb[3];
                    view_room_hue(&l->draw, p > MOST ? -1 : p, rgb);
                    sum += w[p] * (double)rgb[k];
                }
                off = fmax(off, fabs(sum));
            }
            bad += off > 2e-3;
        }
        CHECK_MSG(bad < (n ? 12 : 80), "%d: %d pixels", n, bad);
    }
}

/* ---- captures ------------------------------------------------------------ */

/* Whether a texel sees that, or what is up to so many texels away; or it is
 * between two things, and may be a mix of them. */
static bool texel_sees(const view_room_draw *d, const double from[3],
                       const ibl_cube *cube, int face, int x, int y,
                       double around)
{
    enum {
        FINE = 64
    };
    const view_room_material *first = NULL;
    const float *texel =
        ibl_cube_face(cube, 0, face) + 3 * ((size_t)y * cube->size + x);

    for (int i = 0; i < 9; i++) {
        double direction[3];
        ibl_cube_direction(
            cube->size * FINE, face,
            x * FINE + FINE / 2 + (int)(around * FINE) * ((i + 1) % 3 - 1),
            y * FINE + FINE / 2 + (int)(around * FINE) * ((i + 4) / 3 % 3 - 1),
            direction);
        const room_hit h = room_cast(d, from, direction);
        if (lit_has_colour(texel, &h, 2e-3) || (i && h.material != first))
            return true;
        first = h.material;
    }
    return false;
}

/* Captures of the room see what is there, whichever way they are made. */
static void captured(view_probe_capture kind, const double from[3],
                     double around, int most)
{
    enum {
        SIZE = 64
    };
    const ibl_cube cube = cube_alloc(view_test_ctx(1), SIZE, 1);
    int bad = 0;

    room_capture *c = room_capture_begin(kind, SIZE, from);
    room_capture_update(c);
    room_cube_read(c->cubes.specular, &cube);
    for (int i = 0; i < IBL_FACES * SIZE * SIZE; i++)
        bad += !texel_sees(&c->draw, from, &cube, i / (SIZE * SIZE), i % SIZE,
                           i / SIZE % SIZE, around);
    CHECK_MSG(bad <= most, "%d of %d texels", bad, IBL_FACES * SIZE * SIZE);
}

/* Edges of triangles are straight in paraboloids, so that some are further
 * away. The mirror is not in the way of what is captured within it. */
TEST(captures)
{
    double places[2][3] = {{1.11, 2.07, 0.83}}, radius;

    lit_begin(4, 4);
    view_room_sphere(0, 0, places[1], &radius);
    for (int i = 0; i < 2; i++) {
        captured(VIEW_PROBE_FACES, places[i], 0.1, 0);
        captured(VIEW_PROBE_PARABOLOIDS, places[i], 1.5, i ? 48 : 24);
    }
}

/* ---- where local probes are ---------------------------------------------- */

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
    ibl_probe probes[VIEW_MAX_LOCALS];
    int order[VIEW_MAX_LOCALS];
    test_random r = {5};

    for (int count = 1; count <= VIEW_MAX_LOCALS; count++) {
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
