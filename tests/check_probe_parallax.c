/* SPDX-License-Identifier: MIT */
/* Parallax correction against a search, in long double, for where a ray leaves
 * the proxy: all it asks is whether a point is inside. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "ibl/probes.h"
#include "test.h"

static long double length3(const double v[3])
{
    return hypotl(hypotl(v[0], v[1]), v[2]);
}

/* To rounding of the proxy's own coordinates. */
static bool inside(const ibl_volume *v, const double p[3],
                   const long double d[3], long double t)
{
    long double square = 0;

    for (int i = 0; i < 3; i++) {
        const long double half = v->half[v->shape == IBL_SHAPE_BOX ? i : 0];
        const long double off = p[i] + t * d[i] - v->centre[i];
        const long double error =
            4e-19L * (half + fabsl((long double)v->centre[i]));

        if (v->shape == IBL_SHAPE_BOX && fabsl(off) > half + error)
            return false;
        square += off * off;
    }
    return v->shape == IBL_SHAPE_BOX ||
           sqrtl(square) <= v->half[0] * (1 + 4e-19L);
}

/* Unit direction from the probe to where the ray leaves; returns how far. */
static double true_lookup(const ibl_probe *probe, const double p[3],
                          const double direction[3], double lookup[3])
{
    const ibl_volume *v = &probe->proxy;
    const int n = v->shape == IBL_SHAPE_BOX ? 3 : 1;
    long double d[3], to[3], low = 0, high = 0;
    const long double length = length3(direction);

    for (int i = 0; i < 3; i++)
        d[i] = direction[i] / length;
    for (int i = 0; i < n; i++)
        high += 4 * (long double)v->half[i];
    for (int i = 0; i < 200; i++) {
        const long double middle = (low + high) / 2;
        if (inside(v, p, d, middle))
            low = middle;
        else
            high = middle;
    }
    for (int i = 0; i < 3; i++)
        to[i] = p[i] + low * d[i] - probe->position[i];
    const long double away = hypotl(hypotl(to[0], to[1]), to[2]);
    for (int i = 0; i < 3; i++)
        lookup[i] = (double)(to[i] / away);
    return (double)away;
}

static void check_unit(const double v[3])
{
    CHECK_NEAR((double)length3(v), 1, 4e-16);
}

static double apart(const double a[3], const double b[3])
{
    const double d[3] = {a[0] - b[0], a[1] - b[1], a[2] - b[2]};

    return (double)length3(d);
}

/* error: of where the ray meets, in units of the proxy. */
static void check_ray(const ibl_probe *probe, const double p[3],
                      const double d[3], double error)
{
    double truth[3], lookup[3] = {0, 0, 0}, size = 0;
    const double away = true_lookup(probe, p, d, truth);

    CHECK(ibl_probe_parallax(probe, p, d, lookup) == 1);
    check_unit(lookup);
    for (int i = 0; i < 3; i++) {
        const int k = probe->proxy.shape == IBL_SHAPE_BOX ? i : 0;
        size += probe->proxy.half[k] + fabs(probe->proxy.centre[i]);
    }
    const double bound = error * size / away + 4e-16;
    CHECK_MSG(apart(lookup, truth) <= bound,
              "off by %g, at most %g: p %g %g %g, d %g %g %g",
              apart(lookup, truth), bound, p[0], p[1], p[2], d[0], d[1], d[2]);
}

static ibl_probe random_probe(test_random *r, ibl_shape shape, double scale)
{
    ibl_probe probe = {.has_proxy = 1};

    probe.proxy.shape = shape;
    for (int i = 0; i < 3; i++) {
        probe.proxy.half[i] = scale * test_random_between(r, 0.2, 3);
        probe.proxy.centre[i] = scale * test_random_between(r, -5, 5);
    }
    for (int i = 0; i < 3; i++)
        probe.position[i] =
            probe.proxy.centre[i] + scale * test_random_between(r, -0.1, 0.1);
    return probe;
}

/* Some components 0, some tiny, any length. */
static void random_direction(test_random *r, double d[3])
{
    static const double lengths[] = {1, 1, 7, 1e-300, 1e300};
    const double length = lengths[test_random_below(r, 5)];

    do {
        for (int i = 0; i < 3; i++) {
            d[i] = test_random_between(r, -1, 1) * length;
            if (test_random_below(r, 4) == 0)
                d[i] = test_random_below(r, 2) ? 0 : -0.;
            else if (test_random_below(r, 8) == 0)
                d[i] *= 1e-20;
        }
    } while (length3(d) == 0);
}

TEST(points_inside)
{
    static const double scales[] = {1, 1, 1e-6, 1e6, 1e-70, 1e70};
    test_random r = {1};
    double p[3], d[3];

    for (int n = 0; n < (TEST_SANITIZED ? 4000 : 40000); n++) {
        const bool box = n % 2;
        const ibl_probe probe = random_probe(
            &r, box ? IBL_SHAPE_BOX : IBL_SHAPE_SPHERE, scales[n / 2 % 6]);
        const double most = box ? 0.999 : 0.57;
        for (int i = 0; i < 3; i++)
            p[i] =
                probe.proxy.centre[i] + test_random_between(&r, -most, most) *
                                            probe.proxy.half[box ? i : 0];
        random_direction(&r, d);
        check_ray(&probe, p, d, box ? 2e-15 : 1e-14);
    }
}

/* Walls, edges, corners and within, with every kind of direction, in a box of
 * numbers that are exact: what leaves at once, along a wall, and through. */
TEST(boxes_on_the_wall)
{
    ibl_probe probe = {.has_proxy = 1, .position = {1.25, -0.5, 0.375}};
    const double part[3] = {-1, 0.25, 1};

    probe.proxy = (ibl_volume){IBL_SHAPE_BOX, {1, -1, 0.5}, {0.75, 2, 0.625}};
    for (int at = 0; at < 27; at++) {
        const int step[3] = {at % 3, at / 3 % 3, at / 9};
        double p[3], d[3];

        for (int i = 0; i < 3; i++)
            p[i] = probe.proxy.centre[i] + part[step[i]] * probe.proxy.half[i];
        for (int to = 0; to < 125; to++) {
            const double parts[5] = {-1, -0.375, 0, 0.5, 1};
            d[0] = parts[to % 5];
            d[1] = parts[to / 5 % 5];
            d[2] = parts[to / 25];
            if (length3(d) > 0)
                check_ray(&probe, p, d, 2e-15);
        }
    }
}

/* On the poles exactly: outwards at once, along the tangent, and across. */
TEST(spheres_on_the_wall)
{
    ibl_probe probe = {.has_proxy = 1, .position = {0.25, 0.5, 0.125}};

    probe.proxy = (ibl_volume){IBL_SHAPE_SPHERE, {0.5, 0, -0.25}, {2, 0, 0}};
    for (int axis = 0; axis < 6; axis++) {
        double p[3], d[3];

        memcpy(p, probe.proxy.centre, sizeof p);
        p[axis / 2] += axis % 2 ? 2 : -2;
        for (int to = 0; to < 125; to++) {
            d[0] = to % 5 - 2;
            d[1] = to / 5 % 5 - 2;
            d[2] = to / 25 - 2;
            /* The search ends along the tangent at the root of its error. */
            if (length3(d) > 0)
                check_ray(&probe, p, d, d[axis / 2] == 0 ? 1e-8 : 2e-15);
        }
    }
}

/* How it falls back: the direction itself, unit. */
TEST(falls_back)
{
    test_random r = {3};
    double p[3], d[3], lookup[3];

    for (int n = 0; n < 4000; n++) {
        ibl_probe probe = random_probe(&r, (ibl_shape)(n % 2), 1);
        const int axis = test_random_below(&r, 3);
        const double off = probe.proxy.half[n % 2 ? 0 : axis] *
                           test_random_between(&r, 1.002, 9);

        memcpy(p, probe.proxy.centre, sizeof p);
        p[axis] += test_random_below(&r, 2) ? off : -off;
        random_direction(&r, d);
        if (n % 3 == 0) {
            memcpy(p, probe.position, sizeof p);
            probe.has_proxy = 0;
        }
        CHECK(ibl_probe_parallax(&probe, p, d, lookup) == 0);
        const long double length = length3(d);
        for (int i = 0; i < 3; i++)
            CHECK_NEAR(lookup[i], (double)(d[i] / length), 4e-16);
    }
    /* No direction; the probe on the wall, where the ray meets it. */
    ibl_probe probe = {.position = {1, 0, 0}, .has_proxy = 1};
    probe.proxy = (ibl_volume){IBL_SHAPE_BOX, {0, 0, 0}, {1, 1, 1}};
    for (int i = 0; i < 2; i++) {
        CHECK(ibl_probe_parallax(&probe, (double[]){0, 0, 0},
                                 (double[]){3 * i, 0, 0}, lookup) == 0);
        CHECK(lookup[0] == i && lookup[1] == 0 && lookup[2] == 0);
    }
}

/* A hair outside is on the wall, and what is looked up is what would be there:
 * a thousandth of the half width is a thousandth of it off at most. */
TEST(a_hair_outside)
{
    test_random r = {4};
    double p[3], q[3], d[3], lookup[3], wall[3];

    for (int n = 0; n < 4000; n++) {
        const ibl_probe probe = random_probe(&r, (ibl_shape)(n % 2), 1);
        const int axis = test_random_below(&r, 3),
                  side = test_random_below(&r, 2) ? 1 : -1;
        const double half = probe.proxy.half[n % 2 ? 0 : axis];
        const double hair = half * test_random_between(&r, 1e-16, 0.9 / 1024);

        memcpy(p, probe.proxy.centre, sizeof p);
        p[axis] += side * half;
        memcpy(q, p, sizeof q);
        q[axis] += side * hair;
        /* All but along the wall, a ray outwards is one or the other. */
        do
            random_direction(&r, d);
        while (d[axis] != 0 && fabsl(d[axis] / length3(d)) < 1e-3L);
        CHECK(ibl_probe_parallax(&probe, p, d, wall) == 1);
        CHECK(ibl_probe_parallax(&probe, q, d, lookup) == 1);
        CHECK_NEAR(apart(wall, lookup), 0, n % 2 ? 1e-7 : 1e-12);
    }
}
