/* SPDX-License-Identifier: MIT */
/*
 * ibl_reference_brdf against the BRDF written out here from the papers, closed
 * forms, symmetry and the other integrals of ibl/reference.h.
 */
#include <math.h>
#include <string.h>

#include "reference.h"

enum {
    SUMS = IBL_REFERENCE_BRDF,
    MOST = 16 /* views, roughnesses */
};

/* Normals and views. */
typedef struct pairs {
    size_t count;
    double normal[3 * MOST], view[3 * MOST];
} pairs;

/* A random normal, and a view at n_dot_v from it. */
static void add_pair(pairs *p, test_random *rnd, double nv)
{
    double *n = p->normal + 3 * p->count, *v = p->view + 3 * p->count, t[3];
    double length;

    random_direction(rnd, n);
    do {
        random_direction(rnd, t);
        const double along = test_dot(t, n);
        for (int k = 0; k < 3; k++)
            t[k] -= along * n[k];
        length = sqrt(test_dot(t, t));
    } while (length < 0.1);
    for (int k = 0; k < 3; k++)
        v[k] = nv * n[k] + sqrt(1 - nv * nv) * t[k] / length;
    p->count++;
}

static pairs some_pairs(uint64_t seed)
{
    static const double nv[] = {1, 0.9, 0.7, 0.4, 0.15, 0.04};
    pairs p = {0};
    test_random rnd = {seed};

    for (int i = 0; i < 6; i++)
        add_pair(&p, &rnd, nv[i]);
    return p;
}

static const double *brdf(const ibl_reference *ref, ibl_geometry g,
                          const double *roughness, int n, const pairs *p)
{
    double *out = test_alloc(p->count * (size_t)n, SUMS * sizeof *out);

    CHECK(!ibl_reference_brdf(ref, g, roughness, n, p->normal, p->view,
                              p->count, out));
    return out;
}

/* ---- written out ------------------------------------------------------- */

static double squared(double x)
{
    return x * x;
}

/* f N.L / F and 1 - V.H to the fifth (Walter 2007 eq. 33, Heitz 2014 eq. 99,
 * Karis 2013). */
static double reflected(ibl_geometry g, double alpha, const double n[3],
                        const double v[3], const double l[3], double *fc)
{
    double h[3];
    const double nl = test_dot(n, l), nv = test_dot(n, v);

    *fc = 0;
    if (nl <= 0)
        return 0;
    for (int k = 0; k < 3; k++)
        h[k] = v[k] + l[k];
    const double length = sqrt(test_dot(h, h));
    const double nh = test_dot(n, h) / length, vh = test_dot(v, h) / length;
    const double tan2 = 1 / squared(nh) - 1, cos4 = squared(squared(nh));
    const double d =
        1 / (M_PI * squared(alpha) * cos4 * squared(1 + tan2 / squared(alpha)));
    const double of_l =
        (sqrt(1 + squared(alpha) * (1 / squared(nl) - 1)) - 1) / 2;
    const double of_v =
        (sqrt(1 + squared(alpha) * (1 / squared(nv) - 1)) - 1) / 2;
    const double k = alpha / 2;
    const double shadow =
        g == IBL_GEOMETRY_SMITH
            ? 1 / (1 + of_l + of_v)
            : nl / (nl * (1 - k) + k) * (nv / (nv * (1 - k) + k));
    *fc = pow(1 - vh, 5);
    return d * shadow / (4 * nv);
}

/* Adds a pixel in sub x sub parts. */
static void add_pixel(const ibl_image *env, double yaw, ibl_geometry g,
                      double r, const double n[3], const double v[3], int sub,
                      int x, int y, double out[SUMS])
{
    const int w = env->width * sub, h = env->height * sub;
    const float *p = map_pixel(env, x, y);
    const double rgb[4] = {(double)p[0], (double)p[1], (double)p[2], 1};

    for (int k = 0; k < sub * sub; k++) {
        const int i = x * sub + k % sub, j = y * sub + k / sub;
        double l[3], fc;
        polar_direction(M_PI * (j + 0.5) / h,
                        2 * M_PI * ((i + 0.5) / w - 0.5) - yaw, l);
        const double f =
            (double)row_angle(w, h, j) * reflected(g, r * r, n, v, l, &fc);
        for (int c = 0; c < 4; c++) {
            out[c] += f * (1 - fc) * rgb[c];
            out[4 + c] += f * fc * rgb[c];
        }
    }
}

/* Compares with the sums in parts half as large as the widest that see the
 * lobe; they are off by less than the promise. */
static void compare(int w, int h, double yaw_deg, double r, double nv, int sub)
{
    const subject *it = subject_make(2, w, h, 7, yaw_deg);
    test_random rnd = {(uint64_t)(1000 * nv)};
    pairs p = {0};

    map_set(&it->env, w / 3, h / 3, 900, 500, 100);
    add_pair(&p, &rnd, nv);
    for (int g = 0; g < 2; g++) {
        double want[SUMS] = {0};
        const double *got = brdf(subject_ref(it), (ibl_geometry)g, &r, 1, &p);
        for (int i = 0; i < w * h; i++)
            add_pixel(&it->env, yaw_deg * M_PI / 180, (ibl_geometry)g, r,
                      p.normal, p.view, sub, i % w, i / w, want);
        for (int c = 0; c < SUMS; c++)
            CHECK_MSG(fabs(got[c] - want[c]) <= 1e-3 * (want[c] + want[c % 4]),
                      "%dx%d r %g N.V %g geometry %d: sum %d is %.9g, not %.9g",
                      w, h, r, nv, g, c, got[c], want[c]);
    }
}

TEST(against_brute_force)
{
    compare(32, 16, 0, 0.3, 0.8, 32);
    compare(32, 16, 30, 0.5, 0.4, 16);
    compare(32, 16, -100, 0.7, 0.1, 16);
    compare(32, 16, 0, 1, 0.6, 8);
    compare(5, 3, 0, 0.6, 0.5, 96);
    compare(1, 1, 0, 0.8, 0.3, 256);
    compare(70, 3, 0, 0.8, 0.9, 32);
}

/* A light on the horizon, of which a part is below. */
TEST(pixel_on_the_horizon)
{
    static const double above[] = {-0.02, -0.005, 0.001, 0.01, 0.03, 0.08};
    const subject *it = subject_make(1, 128, 64, 0, 0);
    const double r = 1, phi = 2 * M_PI * (40.5 / 128 - 0.5);
    pairs p = {.count = 1};

    map_set(&it->env, 40, 20, 8, 4, 2);
    for (int k = 0; k < 6; k++) {
        double want[SUMS] = {0};
        polar_direction(M_PI * (20.5 / 64 + 0.5) - above[k], phi, p.normal);
        polar_direction(M_PI * (20.5 / 64 + 0.5) - 0.5, phi + 0.3, p.view);
        add_pixel(&it->env, 0, IBL_GEOMETRY_SMITH, r, p.normal, p.view, 128, 40,
                  20, want);
        const double *got =
            brdf(subject_ref(it), IBL_GEOMETRY_SMITH, &r, 1, &p);
        CHECK_NEAR(got[0], want[0], 2e-3 * want[0] + 2e-8);
        CHECK_NEAR(got[4], want[4], 2e-3 * want[4] + 2e-8);
    }
}

/* A narrow lobe, for which brute force would take long: it is the same over a
 * finer map of the same patches. */
TEST(finer_map_of_the_same_patches)
{
    static const double roughness[] = {0.05, 0.1, 0.2, 0.4, 1};
    const subject *coarse = subject_make(2, 16, 8, 3, 0);
    const subject *fine = subject_make(2, 16 * 40, 8 * 40, 3, 0);
    const pairs p = some_pairs(5);

    for (int i = 0; i < 640 * 320; i++)
        memcpy(fine->env.data + 3 * i,
               map_pixel(&coarse->env, i % 640 / 40, i / 640 / 40),
               3 * sizeof(float));
    const double *a =
        brdf(subject_ref(coarse), IBL_GEOMETRY_SMITH, roughness, 5, &p);
    const double *b =
        brdf(subject_ref(fine), IBL_GEOMETRY_SMITH, roughness, 5, &p);
    for (size_t k = 0; k < p.count * 5 * SUMS; k++)
        CHECK_MSG(fabs(a[k] - b[k]) <= 1e-3 * (fabs(b[k]) + b[k & ~7u]),
                  "sum %zu of pair %zu, r %g: %.9g, not %.9g", k % SUMS,
                  k / SUMS / 5, roughness[k / SUMS % 5], a[k], b[k]);
}

/* ---- closed forms ------------------------------------------------------ */

/* Radiance 1 reflects what the table says, and any constant its multiple. */
TEST(constant_map_is_the_table)
{
    static const double roughness[] = {0, 0.02, 0.1, 0.35, 0.7, 1};
    static const int sizes[][2] = {{1, 1}, {7, 40}, {64, 32}, {200, 100}};
    const pairs p = some_pairs(9);

    for (int m = 0; m < 4; m++) {
        const subject *it = subject_make(2, sizes[m][0], sizes[m][1], 0, 0);
        const ibl_geometry g = (ibl_geometry)(m % 2);
        for (size_t k = 0; k < map_floats(&it->env); k++)
            it->env.data[k] = 0.75f;
        const double *got = brdf(subject_ref(it), g, roughness, 6, &p);
        for (size_t k = 0; k < p.count * 6; k++, got += SUMS) {
            double lut[2];
            const double nv =
                test_dot(p.normal + 3 * (k / 6), p.view + 3 * (k / 6));
            CHECK(!ibl_reference_lut(it->ctx, fmin(nv, 1), roughness[k % 6], g,
                                     lut));
            CHECK_NEAR(got[3], lut[0], 5e-4);
            CHECK_NEAR(got[7], lut[1], 5e-4);
            for (int c = 0; c < 3; c++) {
                CHECK_NEAR(got[c], 0.75 * got[3], 1e-7);
                CHECK_NEAR(got[4 + c], 0.75 * got[7], 1e-7);
            }
        }
    }
}

/* At roughness 1 D is 1 / pi, and Smith's G / (4 N.L N.V) is
 * 1 / (2 (N.L + N.V)). */
TEST(one_pixel_at_roughness_1)
{
    const subject *it = subject_make(1, 128, 64, 0, 0);
    const pairs p = some_pairs(2);
    const double one = 1;

    map_set(&it->env, 40, 20, 8, 4, 2);
    const double *got = brdf(subject_ref(it), IBL_GEOMETRY_SMITH, &one, 1, &p);
    double l[3];
    polar_direction(M_PI * 20.5 / 64, 2 * M_PI * (40.5 / 128 - 0.5), l);
    for (size_t i = 0; i < p.count; i++, got += SUMS) {
        const double nl = fmax(test_dot(p.normal + 3 * i, l), 0);
        const double nv = test_dot(p.normal + 3 * i, p.view + 3 * i);
        const double want =
            (double)row_angle(128, 64, 20) * nl / (2 * M_PI * (nl + nv));
        if (nl == 0 || nl > 0.1)
            CHECK_NEAR((got[0] + got[4]) / 8, want, 1e-3 * want);
        CHECK_NEAR(got[1] + got[5], (got[0] + got[4]) / 2, 1e-15);
    }
}

/* f(V, L) = f(L, V): a pixel at L seen from V, and one at V seen from L. */
TEST(reciprocal)
{
    const subject *it = subject_make(2, 512, 256, 0, 0);
    static const double roughness[] = {0.3, 0.6, 1};
    const int row[2] = {90, 130}, column[2] = {60, 110};
    pairs p = {.count = 1};
    double sum[2][3][SUMS], dir[2][3];

    for (int k = 0; k < 2; k++)
        polar_direction(M_PI * (row[k] + 0.5) / 256,
                        2 * M_PI * ((column[k] + 0.5) / 512 - 0.5), dir[k]);
    for (int c = 0; c < 3; c++)
        p.normal[c] = dir[0][c] + 0.4 * dir[1][c] + (c ? 0 : 0.2);
    for (int k = 0; k < 2; k++) {
        memset(it->env.data, 0, map_floats(&it->env) * sizeof(float));
        map_set(&it->env, column[k], row[k], 1, 1, 1);
        memcpy(p.view, dir[!k], sizeof dir[k]);
        memcpy(sum[k],
               brdf(subject_ref(it), IBL_GEOMETRY_SMITH, roughness, 3, &p),
               sizeof sum[k]);
        for (int r = 0; r < 3; r++)
            for (int c = 0; c < SUMS; c++)
                sum[k][r][c] /= (double)row_angle(512, 256, row[k]) *
                                test_dot(p.normal, dir[k]);
    }
    for (int r = 0; r < 3; r++) {
        CHECK_NEAR(sum[0][r][0], sum[1][r][0], 2e-3 * sum[1][r][0]);
        CHECK_NEAR(sum[0][r][4], sum[1][r][4], 2e-3 * sum[1][r][4]);
    }
}

TEST(mirror)
{
    static const double roughness[] = {0, 1e-4, 4e-4, 0.01};
    const subject *it = subject_make(1, 16, 8, 4, 65);
    const double n[3] = {0.3, 2, -0.5}, v[3] = {-1, 0.9, 1.1};
    const double length = sqrt(test_dot(n, n) * test_dot(v, v));
    const double nv = test_dot(n, v) / length, fc = pow(1 - nv, 5);
    pairs p = {.count = 1};
    double r[3], rgb[3];

    memcpy(p.normal, n, sizeof n);
    memcpy(p.view, v, sizeof v);
    for (int k = 0; k < 3; k++)
        r[k] = 2 * test_dot(n, v) / test_dot(n, n) * n[k] - v[k];
    CHECK(!ibl_reference_lobe(subject_ref(it), IBL_LOBE_GGX, 0, r, 1, rgb));
    const double *got =
        brdf(subject_ref(it), IBL_GEOMETRY_SMITH, roughness, 4, &p);
    for (int k = 0; k < 4; k++, got += SUMS)
        for (int c = 0; c < 3; c++) {
            const double off = k < 2 ? 1e-12 : 5e-3;
            CHECK_NEAR(got[c], (1 - fc) * rgb[c], off * (rgb[c] + 0.01));
            CHECK_NEAR(got[4 + c], fc * rgb[c], off * (rgb[c] + 0.01));
        }
}

/* ---- promises ---------------------------------------------------------- */

/* Under a sun and not: metals, then lobes, of which those of roughness 1 are
 * irradiance / pi. */
TEST(coarse)
{
    static const double roughness[] = {0.05, 0.1, 0.3, 0.6, 1};
    const pairs p = some_pairs(3);
    const size_t n = 5 * p.count;
    double worst = 0, mean = 0, lobes[2][15 * MOST], rgb[3];

    for (int sun = 0; sun < 2; sun++) {
        const subject *it = subject_make(2, 512, 256, 6, 20);
        const double *out[2];
        ibl_reference *ref;
        map_set(&it->env, 100, 80, 5, sun ? 20000 : 5, 5);
        NEED(!ibl_reference_create(it->ctx, &it->env, 20, &ref));
        for (int k = 0; k < 2; k++) {
            out[k] = brdf(ref, IBL_GEOMETRY_SMITH, roughness, 5, &p);
            for (size_t i = 0; i < n; i++)
                CHECK(!ibl_reference_lobe(ref, IBL_LOBE_GGX, roughness[i % 5],
                                          p.normal + i / 5 * 3, 1,
                                          lobes[k] + 3 * i));
            CHECK(!ibl_reference_irradiance(ref, p.normal, 1, rgb));
            CHECK_NEAR(lobes[k][12], rgb[0], 1e-9);
            ibl_reference_coarsen(ref);
        }
        for (size_t k = 0; k < 6 * n; k++) {
            const size_t at = k / 6 * SUMS + k % 3, lobe = k / 6 * 3 + k % 3;
            const double a = out[0][at] + out[0][at + 4];
            const double off = k % 6 < 3 ? (out[1][at] + out[1][at + 4]) / a - 1
                                         : lobes[1][lobe] / lobes[0][lobe] - 1;
            worst = fmax(worst, fabs(off));
            mean += fabs(off) / (double)(12 * n);
        }
        ibl_reference_free(ref);
    }
    CHECK(worst > 1e-6 && worst < 1e-3);
    CHECK(mean < 1e-4);
}

TEST(any_threads_and_isa)
{
    static const double roughness[] = {0.1, 0.5, 1};
    const subject *one = subject_make(1, 100, 50, 6, 0);
    const subject *three = subject_make(3, 100, 50, 6, 0);
    ibl_ctx *plain = test_ctx(2, IBL_ISA_C);
    const pairs p = some_pairs(4);
    const size_t n = p.count * 3 * SUMS;
    const double *a =
        brdf(subject_ref(one), IBL_GEOMETRY_SMITH, roughness, 3, &p);
    const double *b =
        brdf(subject_ref(three), IBL_GEOMETRY_SMITH, roughness, 3, &p);
    const double *c = brdf(reference_of(plain, &one->env, 0),
                           IBL_GEOMETRY_SMITH, roughness, 3, &p);

    CHECK(!memcmp(a, b, n * sizeof *a));
    for (size_t k = 0; k < n; k++)
        CHECK_NEAR(a[k], c[k], 1e-11 * fabs(c[k]) + 1e-14);
}

TEST(refuses)
{
    test_messages kept = {0};
    ibl_ctx *ctx = test_keeping_ctx(1, &kept);
    const ibl_image env = map_constant(ctx, 4, 2, 1);
    const ibl_reference *ref = reference_of(ctx, &env, 0);
    const double up[3] = {0, 1, 0}, down[3] = {0.1, -1, 0}, none[3] = {0};
    const double r[2] = {0.5, 1.5};
    double out[2 * SUMS];

#define REFUSED(words, ...)                                                    \
    CHECK(ibl_reference_brdf(ref, __VA_ARGS__, 1, out) == IBL_ERR_ARGUMENT &&  \
          test_said(&kept, words))
    REFUSED("roughness of 1.5", IBL_GEOMETRY_SMITH, r, 2, up, up);
    REFUSED("0 roughnesses", IBL_GEOMETRY_SMITH, r, 0, up, up);
    REFUSED("geometry 7", (ibl_geometry)7, r, 1, up, up);
    REFUSED("below the surface", IBL_GEOMETRY_SMITH, r, 1, up, down);
    REFUSED("must be a unit", IBL_GEOMETRY_SMITH, r, 1, none, up);
    REFUSED("must be a unit", IBL_GEOMETRY_SMITH, r, 1, up, none);
#undef REFUSED
    CHECK(ibl_reference_lobe(ref, IBL_LOBE_GGX, 1.5, up, 1, out) ==
          IBL_ERR_ARGUMENT);
    CHECK(ibl_reference_lobe(ref, IBL_LOBE_GGX, 1, none, 1, out) ==
          IBL_ERR_ARGUMENT);
}
