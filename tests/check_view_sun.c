/* SPDX-License-Identifier: MIT */
/* Lights that were taken out of an environment, in the room: their reflections
 * and shadows against rays that are cast to them. */
#include "room.h"
#include "view.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "view/vector.h"

enum {
    WIDTH = 160,
    HEIGHT = 96,
    FEW = 2 /* pixels */
};

/* Whether a point is in a box: such have no light. */
static bool is_inside(const double p[3])
{
    for (int i = 0; i < VIEW_ROOM_BOXES; i++) {
        const view_room_box *b = view_room_box_at(i);
        if (p[0] > b->low[0] && p[0] < b->high[0] && p[1] > b->low[1] &&
            p[1] < b->high[1] && p[2] > b->low[2] && p[2] < b->high[2])
            return true;
    }
    return false;
}

/* How many of nine points about that of a hit see the sun: as far away across
 * its light as the texels that are looked up, in the plane of the surface. */
static int count_seen(const view_room_draw *d, const room_hit *h,
                      const double l[3], double away)
{
    double right[3] = {l[2], 0, -l[0]}, up[3];
    int seen = 0;

    normalise3(right);
    for (int k = 0; k < 3; k++)
        up[k] = l[(k + 1) % 3] * right[(k + 2) % 3] -
                l[(k + 2) % 3] * right[(k + 1) % 3];
    for (int i = 0; i < 9; i++) {
        const double a = away * (i % 3 - 1), b = away * (i / 3 - 1);
        const double rise =
            -(a * test_dot(h->normal, right) + b * test_dot(h->normal, up)) /
            test_dot(h->normal, l);
        double p[3];
        for (int k = 0; k < 3; k++)
            p[k] = h->point[k] + a * right[k] + b * up[k] + rise * l[k] +
                   1e-5 * h->normal[k];
        seen += !is_inside(p) && room_cast(d, p, l).what < 0;
    }
    return seen;
}

/* What it gives a surface. */
static void sun_term(const float irradiance[4], const room_hit *h,
                     const double l[3], const double eye_ray[3], double rgb[3])
{
    const view_room_material *m = h->material;
    const double v[3] = {-eye_ray[0], -eye_ray[1], -eye_ray[2]};
    const double alpha = (double)m->roughness * (double)m->roughness;

    for (int k = 0; k < 3; k++) {
        const double f0 = (double)m->f0[k], albedo = (double)m->albedo[k];
        const double specular = alpha <= 0 || f0 <= 0
                                    ? 0
                                    : ibl_disc_brdf(IBL_GEOMETRY_SMITH, alpha,
                                                    f0, 0, h->normal, v, l);
        rgb[k] = (double)irradiance[k] *
                 (specular + (1 - f0) * albedo * test_dot(h->normal, l) / M_PI);
    }
}

/* Whether a pixel has what is expected, in the sun or not. */
static bool has_colour(const float *pixel, const view_room_draw *d,
                       const room_hit *h, const double l[3],
                       const double ray[3], bool in_sun, double tolerance)
{
    double rgb[3] = {0};

    if (in_sun)
        sun_term(d->environment.frame.disc_irradiance[0], h, l, ray, rgb);
    for (int k = 0; k < 3; k++) {
        const double f0 = (double)h->material->f0[k];
        rgb[k] += f0 + (1 - f0) * (double)h->material->albedo[k] +
                  (double)h->material->emission[k];
        if (!(fabs((double)pixel[k] - rgb[k]) < tolerance * rgb[k]))
            return false;
    }
    return true;
}

/* bad: wrong lit and dark ones; a few shadow corners lie between the points. */
typedef struct counts {
    int lit, dark, unsure, bad;
} counts;

/* The hit of all rays near a pixel's centre; what -2: on different sides. */
static room_hit hit_of(const view_camera *c, const view_room_draw *d, int i,
                       double ray[3])
{
    room_hit h = {.what = -2};

    for (int j = 8; j >= 0; j--) {
        const room_hit other = h;
        view_camera_ray(c, WIDTH, HEIGHT, i % WIDTH + 0.6 * ((j + 1) % 3 - 1),
                        i / WIDTH + 0.6 * ((j + 4) / 3 % 3 - 1), ray);
        h = room_cast(d, c->eye, ray);
        if (j < 8 &&
            (h.what != other.what || test_dot(h.normal, other.normal) < 0.8)) {
            h.what = -2;
            return h;
        }
    }
    return h;
}

/* Spheres, of triangles, count where the tolerance is less than theirs. */
static void count_pixels(const view_camera *c, const view_room_draw *d,
                         double tolerance, counts *n)
{
    const view_room_environment *e = &d->environment;
    const double away = 0.016; /* more than an edge is wide */
    const bool spheres = tolerance < 0.08;
    float *picture = lit_render(d);
    double env[3], l[3], ray[3];

    *n = (counts){0};
    for (int k = 0; k < 3; k++)
        env[k] = (double)e->frame.disc_direction[0][k];
    view_turn(-e->turn, env, l);
    for (int i = 0; i < WIDTH * HEIGHT; i++) {
        const room_hit h = hit_of(c, d, i, ray);
        const double n_l = h.what >= 0 ? test_dot(h.normal, l) : 0;
        const bool round = h.what >= VIEW_ROOM_BOXES;
        if (h.what < 0 ||
            (round &&
             (!spheres || test_dot(h.normal, ray) > -0.4 || fabs(n_l) < 0.1)))
            continue;
        const int seen = n_l <= 0      ? 0
                         : !d->shadows ? 9
                                       : count_seen(d, &h, l, away);
        const bool ok = has_colour(picture + 4 * i, d, &h, l, ray, seen > 0,
                                   round ? 0.08 : tolerance);
        n->lit += seen == 9;
        n->dark += seen == 0;
        n->unsure += seen > 0 && seen < 9;
        n->bad += !ok && seen % 9 == 0;
    }
}

/* Whole pictures: the sun where it comes through these or those windows, or
 * from above; spheres that move take their shadow along, or have none where
 * they are not drawn; the sun turns with the environment. */
TEST(shadows_are_those_of_rays)
{
    static const struct {
        double eye[3], at[3], sun[3], seconds, turn;
        bool still;
    } views[] = {
        {{3.4, 2.3, 4.6}, {-0.8, 0.6, -1}, {-0.8, 0.5, 0.55}, 0, 0, false},
        {{0.2, 3.8, 0.3}, {0.3, 0, 0.1}, {-0.4, 0.35, 0.8}, 3.1, 70, false},
        {{-9, 5, 8}, {0, 1, 0}, {-0.3, 0.8, 0.5}, 4.4, 0, false},
        /* on the mirror, before which another sphere comes */
        {{1.5, 2.8, 0.5}, {3.3, 0, -1.7}, {-5, 1.1, 2.5}, 1.6, 0, false},
        {{1.5, 2.8, 0.5}, {3.3, 0, -1.7}, {-5, 1.1, 2.5}, 1.6, 0, true},
    };
    static const ibl_probe all = {.influence = {.half = {20, 20, 20}}};
    int lit_by[sizeof views / sizeof *views];
    counts n;

    lit_begin(WIDTH, HEIGHT);
    for (size_t v = 0; v < sizeof views / sizeof views[0]; v++) {
        const view_camera c =
            room_camera(views[v].eye, views[v].at, 70, WIDTH, HEIGHT);
        view_room_draw d = lit_draw(&c);
        view_frame *f = &d.environment.frame;
        double world[3], sun[3];
        memcpy(world, views[v].sun, sizeof world);
        normalise3(world);
        view_turn(views[v].turn, world, sun);
        f->reflection[2] = 1;
        for (int k = 0; k < 3; k++) {
            f->disc_direction[0][k] = (float)sun[k];
            f->disc_irradiance[0][k] = (float)(6 - 1.5 * k);
        }
        /* One probe has all, so that nothing is taken off what is white. */
        d.dynamic = (view_probe_maps){.count = 1,
                                      .probe = &all,
                                      .specular = lit.white_layer,
                                      .irradiance = lit.white_layer,
                                      .irradiance_scale = 1};
        d.moving = !views[v].still;
        d.seconds = views[v].seconds;
        d.environment.turn = views[v].turn;
        for (int shadows = 0; shadows < 2; shadows++) {
            d.shadows = shadows;
            count_pixels(&c, &d, 0.004, &n);
            CHECK_MSG(n.bad <= (v > 2 ? FEW : 0) && n.lit > 300 &&
                          (n.dark > 100 || !shadows) && n.unsure < 2000,
                      "view %zu, shadows %d: %d wrong, %d lit, %d dark, "
                      "%d unsure",
                      v, shadows, n.bad, n.lit, n.dark, n.unsure);
        }
        lit_by[v] = n.lit;
    }
    CHECK_MSG(lit_by[3] < lit_by[4] - 50, "%d, %d", lit_by[3], lit_by[4]);
}
