/* SPDX-License-Identifier: MIT */
/*
 * Properties that every bake has, over random maps: of 1x1 to 64x40, sparse
 * suns, noise, smooth, black rows, denormals (maps.h). Map k is made from the
 * seed IBL_TEST_SEED + k (default 1), k < IBL_TEST_MAPS (default 120, fewer
 * under a sanitizer). A failure prints the seed of its map:
 *
 *     IBL_TEST_SEED=17 IBL_TEST_MAPS=1 build/tests/check_property linear
 *
 * IBL_TEST_VERBOSE=1 prints how near each property came to its bound. Bounds
 * are derived beside the tests; u is the unit roundoff of float, 2^-24, v that
 * of double, 2^-53.
 */
#include <float.h>
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "image/cube.h"
#include "maps.h"
#include "truth.h"

enum {
    MAPS = TEST_RACES ? 8 : TEST_SANITIZED ? 20 : 120
};

static const double u = 0x1p-24, v = 0x1p-53;

enum {
    SAMPLES = 128 /* of a specular texel */
};

/* Denormals are rounded to 2^-149: 8 products a lookup, 2 lookups a sample. */
static const double underflow = 16 * SAMPLES * 0x1p-150;
/* Groups of 256 samples, 8 products each, are summed in float; all terms are
 * >= 0, so the sum is off by at most so much of itself (Higham 2002, 4.2). */
static const double gathered = 8 * 256 * 0x1p-24;
/*
 * Standard deviation of what a small sun gives, as a share of it, if the
 * samples were drawn at random. A lookup spreads each over a footprint of
 * variance v = 5/12 h^2 an axis, h the edge of a texel (bake/samples.c), and
 * the mip is chosen so that h^2 holds 4 samples (lod_bias 1). A Gaussian of
 * that variance has (integral)^2 / integral of squares = 4 pi v, which is
 * 5/3 pi h^2: 20.9 samples see the sun. Hammersley points must do better.
 */
static const double random_error = 0.2186; /* 1 / sqrt(4 * 5 / 3 * pi) */

typedef struct subject {
    ibl_ctx *ctx;
    test_random random; /* for further choices */
    uint64_t seed;
    map_kind kind;
    ibl_image map;
} subject;

typedef void property(subject *s);

/* One failure a map is enough. */
static bool fails(const subject *s, const char *what, double seen, double limit)
{
    if (seen <= limit)
        return false;
    test_fail(__FILE__, __LINE__,
              "seed %" PRIu64 ", %dx%d %s: %s: %.4g, not within %.4g", s->seed,
              s->map.width, s->map.height, map_kind_name(s->kind), what, seen,
              limit);
    return true;
}

/* The largest share of its limit that a property came to, for the table. */
static double most;

static bool within(const subject *s, const char *what, double seen,
                   double limit)
{
    if (limit > 0 && seen / limit > most)
        most = seen / limit;
    return !fails(s, what, seen, limit);
}

static uint64_t number(const char *name, uint64_t otherwise)
{
    const char *text = getenv(name);
    return text && *text ? strtoull(text, NULL, 10) : otherwise;
}

static void for_each_map(const char *name, property *f)
{
    const uint64_t seed = number("IBL_TEST_SEED", 1);
    const uint64_t maps = number("IBL_TEST_MAPS", MAPS);
    ibl_ctx *ctx = test_ctx(2, IBL_ISA_AUTO);
    most = 0;
    for (uint64_t k = 0; k < maps; k++) {
        subject s = {.ctx = ctx, .random = {seed + k}, .seed = seed + k};
        s.map = map_random(ctx, &s.random, &s.kind);
        f(&s);
    }
    if (number("IBL_TEST_VERBOSE", 0))
        printf("%s: at most %.3g of its bound\n", name, most);
}

static int below(subject *s, int n)
{
    return (int)(test_random_u64(&s->random) % (uint64_t)n);
}

/* Rounding of level 0, absolute: sums of positive terms, a few for each pixel
 * that a texel meets, which are up to h + 2n rows of some columns; and the
 * cosines' own, where a row and a column meet at a pole. */
static double level0_noise(const subject *s, int n, double peak)
{
    return 4 * v * (s->map.height + 2 * n) * n * n * peak + 0x1p-149;
}

static double peak_of(const ibl_image *map)
{
    double low, high, peak = 0;
    for (int c = 0; c < 3; c++) {
        map_range(map, c, &low, &high);
        peak = fmax(peak, high);
    }
    return peak;
}

/* ---- energy ----------------------------------------------------------- */

/* Texels partition the sphere, and what one loses at its border the other
 * gains. Each divides by a solid angle that is off by what its edges are, cut
 * by 512 columns and taken as lines with a bow: 1.3e-5 of it up to 24 texels
 * an edge, against atan(t / (a sqrt(1 + a^2 + t^2))); and rounds to float. */
static void energy_of_level0(subject *s)
{
    const int n = 1 + below(s, 24);
    double mean[3];
    ibl_cube cube = cube_level0(s->ctx, &s->map, 360.0 * below(s, 97) / 97, n);
    truth_mean(&s->map, mean);
    for (int c = 0; c < 3; c++)
        if (!within(s, "mean of level 0",
                    fabs(cube_mean(&cube, 0, c) - mean[c]),
                    (u + 1.3e-5) * mean[c] + 0x1p-150))
            break;
}

/*
 * A level's mean is off by what its texels' centres miss of a lobe, and by
 * three deviations of as many samples as texels see a sun, drawn at random
 * (random_error): for 16 x 16 texels of r = 0.5 and 8 x 8 of r = 1 that is the
 * most over 400 suns.
 */
static void energy_of_levels(subject *s)
{
    static const double bounds[3] = {0, 0.0647, 0.0631};
    double mean[3];
    ibl_cube cube = cube_specular(s->ctx, &s->map, 0, 32, 3, SAMPLES);
    truth_mean(&s->map, mean);
    for (int l = 1; l < 3; l++)
        for (int c = 0; c < 3; c++)
            within(s, l == 1 ? "mean at r = 0.5" : "mean at r = 1",
                   fabs(cube_mean(&cube, l, c) - mean[c]),
                   bounds[l] * mean[c] + underflow);
}

/* ---- ranges ----------------------------------------------------------- */

static void check_range(subject *s, const char *what, const ibl_cube *cube,
                        double relative, double absolute)
{
    for (int k = 0; k < 3 * cube->levels; k++) {
        double low, high, from, to;
        map_range(&s->map, k % 3, &low, &high);
        cube_range(cube, k / 3, k % 3, &from, &to);
        const double slack = relative * high + absolute;
        if (!(from >= 0 && to <= FLT_MAX)) {
            fails(s, what, NAN, 0);
            return;
        }
        if (!within(s, what, to - high, slack) ||
            !within(s, what, low - from, slack))
            return;
    }
}

/* Averages: no texel is above the brightest pixel or below the darkest, but
 * for one rounding; so nothing is negative or infinite. */
static void range_of_level0(subject *s)
{
    const int n = 1 + below(s, 24);
    ibl_cube cube = cube_level0(s->ctx, &s->map, 360.0 * below(s, 97) / 97, n);
    check_range(s, "range of level 0", &cube, u, 0);
}

static void range_of_irradiance(subject *s)
{
    ibl_cube cube =
        cube_irradiance(s->ctx, &s->map, 1000.0 / 97, 1 + below(s, 7));
    check_range(s, "range of irradiance", &cube, u, 0);
}

static void range_of_specular(subject *s)
{
    const int n = 1 + below(s, 20);
    ibl_cube cube = cube_specular(s->ctx, &s->map, 1000.0 / 97, n, 0, SAMPLES);
    check_range(s, "range of specular", &cube, gathered, underflow);
}

/* The same where floats end: a sum of weights that rounds to more than 1 must
 * not make the largest float infinite. */
static void range_at_the_top(subject *s)
{
    const int n = 1 + below(s, 20);
    const float top = FLT_MAX / 2 / (float)fmax(peak_of(&s->map), 1);
    for (size_t i = 0; i < map_floats(&s->map); i++)
        s->map.data[i] = below(s, 300) ? FLT_MAX : s->map.data[i] * top;
    ibl_cube a = cube_specular(s->ctx, &s->map, 33, n, 0, SAMPLES);
    ibl_cube b = cube_irradiance(s->ctx, &s->map, 33, 3);
    check_range(s, "specular of the largest floats", &a, gathered, 0);
    check_range(s, "irradiance of the largest floats", &b, u, 0);
}

/* ---- three outputs ----------------------------------------------------- */

typedef struct outputs {
    ibl_cube cube[3]; /* level 0, irradiance, specular levels */
} outputs;

/* levels: of the specular cube; 0: all down to one texel. */
static outputs bake(ibl_ctx *ctx, const ibl_image *map, double yaw, int n,
                    int levels)
{
    return (outputs){{cube_level0(ctx, map, yaw, n),
                      cube_irradiance(ctx, map, yaw, n),
                      cube_specular(ctx, map, yaw, n, levels, SAMPLES)}};
}

/* ---- linear ----------------------------------------------------------- */

/* Makes sums of two such maps exact in float: multiples of 1/8 below 2^20. */
static void quantise(ibl_image *map)
{
    for (size_t i = 0; i < map_floats(map); i++)
        map->data[i] = floorf(fminf(map->data[i], 0x1p20f) * 8) / 8;
}

static double worst_sum(const ibl_cube *a, const ibl_cube *b, const ibl_cube *c,
                        double relative, double absolute)
{
    double worst = 0;
    for (size_t i = 0; i < cube_floats(a); i++) {
        const double off =
            fabs((double)a->data[i] + (double)b->data[i] - (double)c->data[i]);
        worst = fmax(worst, off / (relative * (double)c->data[i] + absolute));
    }
    return worst;
}

/* What the default tolerance lets a spectral result lack: of the mean. */
static double spectral_noise(const ibl_image *map)
{
    double mean[3];
    truth_mean(map, mean);
    return IBL_TOLERANCE_DEFAULT * (mean[0] + mean[1] + mean[2]) + 1e-44;
}

static void linear(subject *s)
{
    const int n = 1 + below(s, 16);
    const bool tiny = s->kind == MAP_DENORMAL;
    map_kind kind = tiny ? MAP_DENORMAL : (map_kind)below(s, MAP_KINDS);
    ibl_image b =
        map_of_kind(s->ctx, &s->random, kind, s->map.width, s->map.height);
    ibl_image sum = map_constant(s->ctx, b.width, b.height, 0);
    if (!tiny) {
        quantise(&s->map);
        quantise(&b);
    }
    for (size_t i = 0; i < map_floats(&sum); i++)
        sum.data[i] = s->map.data[i] + b.data[i];
    const double noise = 3 * level0_noise(s, 64, peak_of(&sum));
    static const char *const what[3] = {
        "level 0 of a sum", "irradiance of a sum", "specular of a sum"};
    const double relative[3] = {2 * u, 3 * IBL_TOLERANCE_DEFAULT, 2 * gathered};
    const double absolute[3] = {noise, 3 * spectral_noise(&sum),
                                noise + 3 * underflow};
    outputs x = bake(s->ctx, &s->map, 20, n, 0);
    outputs y = bake(s->ctx, &b, 20, n, 0);
    outputs z = bake(s->ctx, &sum, 20, n, 0);
    for (int k = 0; k < 3; k++)
        within(s, what[k],
               worst_sum(&x.cube[k], &y.cube[k], &z.cube[k], relative[k],
                         absolute[k]),
               1);
}

/* a_lm are sums in double of |L| dO |Y_lm| at most, |Y_lm| <= sqrt((2l + 1) /
 * 4 pi); w + h additions along the rows and over them, and l steps of each
 * recurrence, round. */
static void linear_harmonics(subject *s)
{
    enum {
        DEGREE = 6,
        COUNT = 3 * (DEGREE + 1) * (DEGREE + 1)
    };
    double a[COUNT], b[COUNT], sum[COUNT], mean[3];
    ibl_image other = map_turned(s->ctx, &s->map, s->map.width / 3);
    ibl_image both = map_constant(s->ctx, other.width, other.height, 0);
    if (s->kind != MAP_DENORMAL) {
        quantise(&s->map);
        quantise(&other);
    }
    for (size_t i = 0; i < map_floats(&both); i++)
        both.data[i] = s->map.data[i] + other.data[i];
    if (ibl_bake_sh(s->ctx, &s->map, DEGREE, 77, a) ||
        ibl_bake_sh(s->ctx, &other, DEGREE, 77, b) ||
        ibl_bake_sh(s->ctx, &both, DEGREE, 77, sum))
        exit(1);
    truth_mean(&both, mean);
    for (int i = 0; i < COUNT; i++)
        if (!within(
                s, "harmonics of a sum", fabs(a[i] + b[i] - sum[i]),
                2 * u * (s->map.width + s->map.height + 4 * DEGREE) *
                        sqrt(4 * 3.14159265358979323846 * (2 * DEGREE + 1)) *
                        mean[i % 3] +
                    1e-44))
            break;
}

/* A factor of 2^k changes only exponents, except where denormals round. */
static void powers_of_two(subject *s)
{
    const int k = s->kind == MAP_DENORMAL ? 20 : below(s, 41) - 20;
    const int n = 1 + below(s, 16);
    ibl_image scaled = map_scaled(s->ctx, &s->map, ldexpf(1, k));
    outputs a = bake(s->ctx, &s->map, 20, n, 0);
    outputs b = bake(s->ctx, &scaled, 20, n, 0);
    for (int j = 0; j < 3; j++) {
        double worst = 0;
        for (size_t i = 0; i < cube_floats(&a.cube[j]); i++)
            worst = fmax(worst, fabs(ldexp((double)b.cube[j].data[i], -k) -
                                     (double)a.cube[j].data[i]));
        within(s, "scaled by a power of two", worst,
               s->kind == MAP_DENORMAL ? 4 * underflow : 0);
    }
}

/* ---- symmetry --------------------------------------------------------- */

/* A map of such a size that turns and lobes say something. */
static void replace_map(subject *s, int width, int height)
{
    s->map = map_of_kind(s->ctx, &s->random, s->kind, width, height);
}

/* Of a level of b against where it was in a: the worst texel over what is
 * allowed, of the sides only or all; and nRMSE. */
typedef struct moved {
    double worst, nrmse;
} moved;

static moved compare(const ibl_cube *a, const ibl_cube *b, int level,
                     int from(int n, int i), bool sides, double relative,
                     double absolute)
{
    const int n = ibl_cube_edge(a->size, level);
    const float *p = ibl_cube_face(a, level, 0);
    const float *q = ibl_cube_face(b, level, 0);
    double worst = 0, error = 0, norm = 0;
    for (int i = 0; i < IBL_FACES * n * n; i++) {
        const int k = from(n, i), face = i / (n * n);
        for (int c = 0; c < 3; c++) {
            const double want = p[3 * k + c], off = fabs(q[3 * i + c] - want);
            if (!sides || (face != 2 && face != 3))
                worst = fmax(worst, off / (relative * want + absolute));
            error += off * off;
            norm += want * want;
        }
    }
    return (moved){worst, norm > 0 ? sqrt(error / norm) : 0};
}

/*
 * The sums of level 0 and of irradiance are the same but for their order and
 * the rounding of the angles: two floats rounded, and level0_noise for each.
 * Specular: the pattern of samples follows the faces' rows, so on the sides it
 * turns with the map: the same sums, but for frames whose last bit differs,
 * which moves a lookup by u times the edge of the cube looked up (at most 64
 * here) in texels of at most the peak. On top and bottom, and in a mirror, two
 * patterns see the same light, each with its own error.
 */
static void check_moved(subject *s, const ibl_image *map, double yaw,
                        int from(int n, int i), bool mirror)
{
    const int n = 8 + 8 * below(s, 2);
    const double noise = 2 * level0_noise(s, 64, peak_of(&s->map));
    const double frames = 8 * u * 64 * peak_of(&s->map);
    outputs a = bake(s->ctx, &s->map, 0, n, 3);
    outputs b = bake(s->ctx, map, yaw, n, 3);
    within(s, "level 0 moved",
           compare(&a.cube[0], &b.cube[0], 0, from, false, 2 * u, noise).worst,
           1);
    within(s, "irradiance moved",
           compare(&a.cube[1], &b.cube[1], 0, from, false,
                   2 * IBL_TOLERANCE_DEFAULT, 2 * spectral_noise(&s->map))
               .worst,
           1);
    for (int l = 1; l < 3; l++) {
        const moved m = compare(&a.cube[2], &b.cube[2], l, from, true,
                                2 * gathered, frames + noise + 2 * underflow);
        if (!mirror)
            within(s, "sides of a level moved", m.worst, 1);
        if (s->kind != MAP_DENORMAL)
            within(s, "level moved", m.nrmse, sqrt(2) * random_error);
    }
}

static void turned(subject *s)
{
    const int height = 4 + below(s, 28);
    if (below(s, 2)) {
        check_moved(s, &s->map, 90, cube_turned_from, false);
    } else {
        replace_map(s, 4 * (1 + below(s, 16)), height);
        ibl_image map = map_turned(s->ctx, &s->map, s->map.width / 4);
        check_moved(s, &map, 0, cube_turned_from, false);
    }
}

static void mirrored(subject *s)
{
    ibl_image map = map_mirrored(s->ctx, &s->map);
    check_moved(s, &map, 0, cube_mirrored_from, true);
}

/* ---- specular against the truth --------------------------------------- */

/* Jumps of the error across a cube's edges, rms over the level's rms. */
static double seam_jumps(int n, const double *error, double rms)
{
    double sum = 0;
    int count = 0;
    for (int i = 0; i < IBL_FACES * n * n; i++) {
        const int face = i / (n * n), x = i % n, y = i / n % n;
        for (int k = 0; k < 4; k++) {
            const int to_x = x + (k == 0) - (k == 1);
            const int to_y = y + (k == 2) - (k == 3);
            if (to_x >= 0 && to_y >= 0 && to_x < n && to_y < n)
                continue;
            const double *a = error + 3 * i;
            const double *b =
                error + 3 * (ptrdiff_t)ibl_cube_neighbour(n, face, to_x, to_y);
            for (int c = 0; c < 3; c++)
                sum += pow(a[c] - b[c], 2);
            count += 3;
        }
    }
    return sqrt(sum / count) / rms;
}

static void near_truth(subject *s)
{
    replace_map(s, 40, 20);
    ibl_cube cube = cube_specular(s->ctx, &s->map, 0, 8, 3, SAMPLES);
    for (int l = 1; l < 3; l++) {
        const int n = 8 >> l;
        const float *p = ibl_cube_face(&cube, l, 0);
        static double error[3 * IBL_FACES * 16];
        double square = 0, norm = 0;
        for (int i = 0; i < IBL_FACES * n * n; i++) {
            double d[3], want[3];
            truth_cube_direction(n, i / (n * n), i % n, i / n % n, d);
            truth_specular(&s->map, d, l / 2.0, want);
            for (int c = 0; c < 3; c++) {
                error[3 * i + c] = (double)p[3 * i + c] - want[c];
                square += pow(error[3 * i + c], 2);
                norm += want[c] * want[c];
            }
        }
        if (s->kind == MAP_DENORMAL)
            continue;
        within(s, l == 1 ? "r = 0.5" : "r = 1", sqrt(square / norm),
               random_error);
        within(s, "jump at a seam",
               seam_jumps(n, error, sqrt(norm / (18.0 * n * n))),
               sqrt(2) * random_error);
    }
}

/* At r = 1 the lobe is the cosine. Irradiance takes its pixels as points, the
 * specular chain as patches or tents of variance up to dO / 6, which changes
 * a cosine by that share (its Laplacian is -2 times it). */
static void roughest_is_irradiance(subject *s)
{
    replace_map(s, 48, 24);
    ibl_cube a = cube_specular(s->ctx, &s->map, 0, 16, 3, SAMPLES);
    ibl_cube b = cube_irradiance(s->ctx, &s->map, 0, 4);
    ibl_cube last = {.size = 4, .levels = 1, .data = ibl_cube_face(&a, 2, 0)};
    const double pixel = 4 * 3.14159265358979323846 / (48 * 24);
    if (s->kind != MAP_DENORMAL)
        within(s, "r = 1 against irradiance", cube_nrmse(&last, &b, 0),
               random_error + pixel / 6);
}

/* ---- threads ---------------------------------------------------------- */

static void any_threads(subject *s)
{
    const int counts[] = {2, 3, 7, 64};
    const int n = 1 + below(s, 16), threads = counts[below(s, 4)];
    ibl_ctx *one = test_ctx(1, IBL_ISA_AUTO);
    ibl_ctx *many = test_ctx(threads, IBL_ISA_AUTO);
    outputs a = bake(one, &s->map, 20, n, 0);
    outputs b = bake(many, &s->map, 20, n, 0);
    double x[48], y[48];
    if (ibl_bake_sh(one, &s->map, 3, 5, x) ||
        ibl_bake_sh(many, &s->map, 3, 5, y))
        exit(1);
    bool same = !memcmp(x, y, sizeof x);
    for (int i = 0; i < 3; i++)
        same = same && !memcmp(a.cube[i].data, b.cube[i].data,
                               cube_floats(&a.cube[i]) * sizeof(float));
    fails(s, "other bytes with more threads", same ? 0 : threads, 0);
}

#define PROPERTY(f, slow)                                                      \
    TEST_OF(each_##f, #f, slow)                                                \
    {                                                                          \
        for_each_map(#f, f);                                                   \
    }
PROPERTY(energy_of_level0, false)
PROPERTY(energy_of_levels, false)
PROPERTY(range_of_level0, false)
PROPERTY(range_of_irradiance, false)
PROPERTY(range_of_specular, false)
PROPERTY(range_at_the_top, false)
PROPERTY(linear, true)
PROPERTY(linear_harmonics, false)
PROPERTY(powers_of_two, true)
PROPERTY(turned, true)
PROPERTY(mirrored, true)
PROPERTY(near_truth, true)
PROPERTY(roughest_is_irradiance, false)
PROPERTY(any_threads, true)
