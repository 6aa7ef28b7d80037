/* SPDX-License-Identifier: MIT */
#include "reference.h"

#include <math.h>
#include <stdlib.h>

const long double pi_l = 3.14159265358979323846264338327950288L;

static void free_reference(void *reference)
{
    ibl_reference_free(reference);
}

ibl_reference *reference_of(ibl_ctx *ctx, const ibl_image *map, double yaw_deg)
{
    ibl_reference *ref;

    if (ibl_reference_create(ctx, map, yaw_deg, &ref))
        exit(1);
    test_defer(free_reference, ref);
    return ref;
}

subject *subject_make(int threads, int width, int height, uint64_t seed,
                      double yaw_deg)
{
    subject *s = test_alloc(1, sizeof *s);
    test_random rnd = {seed};

    s->ctx = test_ctx(threads, IBL_ISA_AUTO);
    s->env = map_constant(s->ctx, width, height, 0);
    for (size_t k = 0; seed && k < map_floats(&s->env); k++)
        s->env.data[k] = (float)pow(test_random_unit(&rnd), 6.0);
    s->yaw_deg = yaw_deg;
    return s;
}

ibl_reference *subject_ref(const subject *s)
{
    return reference_of(s->ctx, &s->env, s->yaw_deg);
}

void polar_direction(double theta, double phi, double d[3])
{
    d[0] = sin(theta) * cos(phi);
    d[1] = cos(theta);
    d[2] = sin(theta) * sin(phi);
}

void random_direction(test_random *rnd, double d[3])
{
    const double theta = acos(2 * test_random_unit(rnd) - 1);

    polar_direction(theta, 2 * (double)pi_l * test_random_unit(rnd), d);
}

void random_view(test_random *rnd, const double normal[3], double n_dot_v,
                 double view[3])
{
    double t[3];
    do {
        random_direction(rnd, t);
        const double along = test_dot(t, normal);
        for (int k = 0; k < 3; k++)
            t[k] -= along * normal[k];
    } while (test_dot(t, t) < 0.01);
    for (int k = 0; k < 3; k++)
        view[k] = n_dot_v * normal[k] +
                  sqrt((1 - n_dot_v * n_dot_v) / test_dot(t, t)) * t[k];
}

long double row_angle(int w, int h, int j)
{
    return 2 * pi_l / w * 2 * sinl(pi_l * (j + 0.5L) / h) * sinl(pi_l / 2 / h);
}

/* A context for the whole program. */
static ibl_ctx *any_ctx(void)
{
    static ibl_ctx *ctx;

    if (!ctx && ibl_ctx_create(NULL, &ctx))
        exit(1);
    return ctx;
}

void reference_mean(const ibl_image *map, double rgb[3])
{
    if (ibl_reference_mean(reference_of(any_ctx(), map, 0), rgb))
        exit(1);
}

void reference_irradiance(const ibl_image *map, const double normal[3],
                          double rgb[3])
{
    if (ibl_reference_irradiance(reference_of(any_ctx(), map, 0), normal, 1,
                                 rgb))
        exit(1);
}

void reference_lut(double n_dot_v, double roughness, ibl_geometry geometry,
                   double scale_bias[2])
{
    if (ibl_reference_lut(any_ctx(), n_dot_v, roughness, geometry, scale_bias))
        exit(1);
}
