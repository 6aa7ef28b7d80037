/* SPDX-License-Identifier: MIT */
/*
 * The lobe table against a search of its own: the lobe of the surface and those
 * of the levels in spherical harmonics about N, summed in double over a grid of
 * the hemisphere.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "bake/lobe_fit.h"
#include "bake/spectral/lobe_coefficients.h"
#include "test.h"
#include "truth.h"

enum {
    DEGREE = 40,
    COUNT = (DEGREE + 1) * (DEGREE + 2) / 2, /* l, m >= 0: symmetric in y */
    RINGS = 240,
    COLUMNS = 160, /* of half a ring */
    CHANNELS = 4,
    TAPS = 4
};

/* The most irradiance at r = 1; 1 below. */
static const double most_weight = 2.5;

static const double pi = 3.14159265358979323846;

static void free_table(void *table)
{
    ibl_lobe_table_free(table);
}

static ibl_lobe_table bake(ibl_ctx *ctx, const ibl_lobe_table_options *opts)
{
    ibl_lobe_table table = {0};
    if (ibl_bake_lobe_table(ctx, opts, &table))
        exit(1);
    test_defer_copy(free_table, &table, sizeof table);
    return table;
}

static const float *texel(const ibl_lobe_table *t, int layer, int i, int j)
{
    const size_t n = (size_t)t->size;
    return t->data +
           CHANNELS * (((size_t)layer * n + (size_t)j) * n + (size_t)i);
}

static size_t floats(const ibl_lobe_table *t)
{
    return CHANNELS * (size_t)t->layers * (size_t)t->size * (size_t)t->size;
}

/* ---- the truth: harmonics about N, R at azimuth 0 ------------------------ */

/* Y_lm(theta, 0) for l, m >= 0, times sqrt(2) for m > 0: the recurrences of
 * the associated Legendre functions, as in books. */
static void harmonics_at(double theta, double y[COUNT])
{
    const double x = cos(theta), s = sin(theta);
    double top = sqrt(1 / (4 * pi));
    for (int m = 0, i = 0; m <= DEGREE; m++) {
        const double scale = m ? sqrt(2) : 1;
        double before = 0, here = top;
        for (int l = m; l <= DEGREE; l++) {
            const double n = l + 1;
            const double a = sqrt((4 * n * n - 1) / (n * n - m * m));
            const double b = l > m ? sqrt(((n - 1) * (n - 1) - m * m) /
                                          (4 * (n - 1) * (n - 1) - 1))
                                   : 0;
            const double next = a * (x * here - b * before);
            y[i++] = scale * here;
            before = here;
            here = next;
        }
        top *= s * sqrt((2 * m + 3) / (2.0 * m + 2));
    }
}

/* Of a surface with N = Z: f F N.L. */
static double surface(double n_v, double alpha, double f0, const double l[3])
{
    const double n[3] = {0, 0, 1}, v[3] = {-sqrt(1 - n_v * n_v), 0, n_v};
    double fc;
    const double f = truth_ggx(IBL_GEOMETRY_SMITH, alpha, n, v, l, &fc);
    return f * (f0 + (1 - f0) * fc);
}

/* Returns its energy. */
static double true_lobe(double n_v, double r, double f0, double out[COUNT])
{
    double *wave = test_alloc(DEGREE + 1, sizeof *wave);
    double energy = 0;
    memset(out, 0, COUNT * sizeof *out);
    for (int j = 0; j < RINGS; j++) {
        const double theta = 0.5 * pi * (j + 0.5) / RINGS;
        double y[COUNT];
        memset(wave, 0, (DEGREE + 1) * sizeof *wave);
        for (int k = 0; k < COLUMNS; k++) {
            const double phi = pi * (k + 0.5) / COLUMNS;
            const double l[3] = {sin(theta) * cos(phi), sin(theta) * sin(phi),
                                 cos(theta)};
            const double f = surface(n_v, r * r, f0, l) * sin(theta) *
                             (0.5 * pi / RINGS) * (2 * pi / COLUMNS);
            double before = cos(phi),
                   here = 1; /* cos((m - 1) phi), cos(m phi) */
            for (int m = 0; m <= DEGREE; m++) {
                const double next = 2 * cos(phi) * here - before;
                wave[m] += f * here;
                before = here;
                here = next;
            }
        }
        harmonics_at(theta, y);
        energy += wave[0];
        for (int m = 0, i = 0; m <= DEGREE; m++)
            for (int l = m; l <= DEGREE; l++, i++)
                out[i] += wave[m] * y[i];
    }
    for (int i = 0; i < COUNT; i++)
        out[i] /= energy;
    return energy;
}

struct truth {
    ibl_specular_layout layout;
    double k[IBL_MAX_LEVELS][DEGREE + 1];
    double cosine[DEGREE + 1]; /* of irradiance */
    double lobe[COUNT];
    double power; /* of lobe */
    double energy;
    double angle; /* of R */
    double most_weight;
};

/* k_l of a level, which check_lobe_coefficients judges. */
static void level_lobe(ibl_ctx *ctx, double r, double k[DEGREE + 1])
{
    const ibl_lobe_shape shape = ibl_lobe_shape_of(IBL_LOBE_GGX, r * r);
    NEED(!ibl_lobe_coefficients(ctx, &shape, DEGREE, k));
}

static double c_of(int l)
{
    return l ? pow(l, -1.5) : 0;
}

static struct truth *truth_of(ibl_ctx *ctx, const ibl_specular_layout *layout)
{
    struct truth *t = test_alloc(1, sizeof *t);
    t->layout = *layout;
    for (int a = 0; a < layout->levels; a++) {
        const double edge = layout->size >> a;
        level_lobe(ctx, fmax(layout->roughness[a], 1e-3), t->k[a]);
        /* What bilinear lookups blur between texels. */
        for (int l = 0; l <= DEGREE; l++)
            t->k[a][l] *= exp(-l * (l + 1.0) * pi / (18 * edge * edge));
    }
    level_lobe(ctx, 1, t->cosine);
    return t;
}

static void view(struct truth *t, double n_v, double r, double f0)
{
    t->energy = true_lobe(n_v, r, f0, t->lobe);
    t->angle = acos(n_v);
    t->most_weight = r < 1 ? 1 : most_weight;
    t->power = 0;
    for (int m = 0, i = 0; m <= DEGREE; m++)
        for (int l = m; l <= DEGREE; l++, i++)
            t->power += c_of(l) * t->lobe[i] * t->lobe[i];
}

/* What a shader looks up: directions, angles from N towards R, and the lod. */
struct lookup {
    int taps;
    double angle[TAPS], lod;
};

/* S - T of a lookup: rest[0] without irradiance, to which its weight adds
 * rest[1]. A lobe of k_l about d has the harmonics k_l Y_lm(d). */
static void rest_of(const struct truth *t, const struct lookup *at,
                    double rest[2][COUNT])
{
    const int a = (int)fmin(at->lod, t->layout.levels - 2);
    const double share = at->lod - a;
    static double tap[TAPS][COUNT];
    double pole[COUNT];
    for (int k = 0; k < at->taps; k++)
        harmonics_at(fabs(at->angle[k]), tap[k]);
    harmonics_at(0, pole);
    for (int m = 0, i = 0; m <= DEGREE; m++)
        for (int l = m; l <= DEGREE; l++, i++) {
            const double k = (1 - share) * t->k[a][l] + share * t->k[a + 1][l];
            double s = 0;
            for (int n = 0; n < at->taps; n++)
                s += k / at->taps * (m % 2 && at->angle[n] < 0 ? -1 : 1) *
                     tap[n][i];
            rest[0][i] = s - t->lobe[i];
            rest[1][i] = t->cosine[l] * pole[i] - s;
        }
}

/* The squared error, over the power of the lobe, of a lookup with this weight,
 * or with the best one, which *weight becomes, if that is below 0. */
static double error_of(const struct truth *t, const struct lookup *at,
                       double *weight)
{
    static double rest[2][COUNT];
    double aa = 0, ab = 0, bb = 0;
    rest_of(t, at, rest);
    for (int m = 0, i = 0; m <= DEGREE; m++)
        for (int l = m; l <= DEGREE; l++, i++) {
            aa += c_of(l) * rest[0][i] * rest[0][i];
            ab += c_of(l) * rest[0][i] * rest[1][i];
            bb += c_of(l) * rest[1][i] * rest[1][i];
        }
    if (*weight < 0)
        *weight = bb > 0 ? fmin(fmax(-ab / bb, 0), t->most_weight) : 0;
    return (aa + 2 * *weight * ab + *weight * *weight * bb) / t->power;
}

/* The least error of a grid over angles and lods, then of finer ones. */
static double search(const struct truth *t, double at[3])
{
    double best = HUGE_VAL, angle = 0.5 * t->angle;
    double lod = 0.5 * (t->layout.levels - 1);
    double wide = 0.5 * t->angle, high = lod;
    for (int round = 0; round < 5; round++, wide *= 0.3, high *= 0.3) {
        const double a0 = angle, l0 = lod;
        for (int i = -6; i <= 6; i++)
            for (int j = -6; j <= 6; j++) {
                const double a = fmin(fmax(a0 + wide * i / 6, 0), t->angle);
                const double l =
                    fmin(fmax(l0 + high * j / 6, 0), t->layout.levels - 1);
                double weight = -1;
                const struct lookup here = {1, {a}, l};
                const double e = error_of(t, &here, &weight);
                if (e < best) {
                    best = e;
                    angle = a;
                    lod = l;
                    at[2] = weight;
                }
            }
    }
    at[0] = angle;
    at[1] = lod;
    return best;
}

/* ---- the fit --------------------------------------------------------------
 */

/* The angle of mix(R, N, bend). */
static double bent(const struct truth *t, double bend)
{
    return atan2((1 - bend) * sin(t->angle), (1 - bend) * cos(t->angle) + bend);
}

/* The error of an entry, as a shader uses it with 1 or 4 taps. */
static double entry_error(const struct truth *t, const float *q, int taps)
{
    struct lookup at = {.taps = taps, .lod = q[1] * (t->layout.levels - 1.0)};
    double weight = q[2];
    for (int i = 0; i < taps; i++)
        at.angle[i] = bent(t, (double)q[0] + (double)q[3] * (2 * i / 3.0 - 1) *
                                                 (taps > 1));
    return error_of(t, &at, &weight);
}

struct place {
    int i, j; /* of 32 */
};

static const struct place places[] = {{3, 14},  {3, 24},  {8, 18},  {8, 30},
                                      {14, 14}, {14, 22}, {20, 18}, {20, 26},
                                      {27, 16}, {30, 30}, {8, 31},  {20, 31}};

/* Halves of distances between the outer taps, as changes of bend. */
static const float halves[] = {0, 0.05F, 0.1F, 0.2F, 0.4F};

/* The entry's error is at most a little above the least of its kind; four taps
 * are at least as near. */
static void near_best(const ibl_lobe_table *table, struct truth *t,
                      struct place p, int layer)
{
    const double n_v = p.i / (table->size - 1.0);
    const double r = p.j / (table->size - 1.0);
    double at[3] = {0, 0, 0};
    view(t, n_v, r, layer ? 0.04 : 1);
    const double least = sqrt(search(t, at));
    const double one = sqrt(entry_error(t, texel(table, layer, p.i, p.j), 1));
    const double four =
        sqrt(entry_error(t, texel(table, layer + 2, p.i, p.j), TAPS));
    test_measured("nRMSE above the least", one - least, 0.004);
    CHECK_MSG(one <= least + 0.004, "N.V %g r %g: %g, least %g at %g %g %g",
              n_v, r, one, least, at[0] / t->angle, at[1], at[2]);
    CHECK_MSG(four <= one + 0.003, "N.V %g r %g: four taps %g, one %g", n_v, r,
              four, one);
    for (size_t k = 0; k < sizeof halves / sizeof *halves; k++) {
        float q[4];
        memcpy(q, texel(table, layer + 2, p.i, p.j), sizeof q);
        q[3] = halves[k];
        const double other = sqrt(entry_error(t, q, TAPS));
        test_measured("nRMSE above taps of another distance", four - other,
                      0.003);
        CHECK_MSG(four <= other + 0.003, "N.V %g r %g: %g, %g with half %g",
                  n_v, r, four, other, (double)q[3]);
    }
}

TEST_SLOW(against_search)
{
    ibl_ctx *ctx = test_ctx(2, IBL_ISA_AUTO);
    for (int k = 0; k < 2; k++) {
        ibl_lobe_table_options o = ibl_lobe_table_options_default();
        ibl_specular_options s = ibl_specular_options_default();
        s.mapping = k ? IBL_ROUGHNESS_FILAMENT : IBL_ROUGHNESS_LINEAR;
        NEED(!ibl_specular_layout_of(&s, &o.layout));
        o.size = 32;
        const ibl_lobe_table table = bake(ctx, &o);
        struct truth *t = truth_of(ctx, &o.layout);
        for (size_t i = 0; i < sizeof places / sizeof *places; i++)
            near_best(&table, t, places[i], (int)i % 2);
        for (size_t i = 0; i < sizeof places / sizeof *places; i += 3)
            near_best(&table, t, places[i], 1 - (int)i % 2);
    }
}

/* ---- what holds for every table -------------------------------------------
 */

static void check_range(const ibl_lobe_table *t)
{
    int bad = 0;
    for (size_t i = 0; i < floats(t); i++)
        bad += !(t->data[i] >= 0 &&
                 (double)t->data[i] <= (i % CHANNELS == 2 ? most_weight : 1));
    CHECK_MSG(!bad, "%d entries are out of range", bad);
}

/* A mirror is looked up in R at level 0. One tap has no distance. */
TEST(ends)
{
    ibl_ctx *ctx = test_ctx(2, IBL_ISA_AUTO);
    const ibl_lobe_table t = bake(ctx, NULL);
    NEED(t.size == 16);
    for (int layer = 0; layer < IBL_LOBE_LAYERS; layer++)
        for (int i = 0; i < t.size; i++) {
            const float *q = texel(&t, layer, i, 0);
            for (int c = 0; c < CHANNELS; c++)
                CHECK(q[c] <= 0);
            /* At r = 1 the lobe of F0 = 1, c / (c + N.V), is broader than a
             * cosine. */
            CHECK(texel(&t, layer, i, t.size - 1)[2] > 1 || layer % 2);
            for (int j = 0; j < t.size && layer < 2; j++)
                CHECK(texel(&t, layer, i, j)[3] <= 0);
        }
}

/* A table of one F0 has the layers that are of it in the other, in order. */
TEST(of_one_f0)
{
    ibl_ctx *ctx = test_ctx(2, IBL_ISA_AUTO);
    ibl_lobe_table_options o = ibl_lobe_table_options_default();
    const ibl_lobe_table both = bake(ctx, &o);
    const size_t n = CHANNELS * (size_t)o.size * (size_t)o.size;
    for (int f = 0; f < 2; f++) {
        o.f0 = f ? IBL_F0_DIELECTRICS : IBL_F0_METALS;
        const ibl_lobe_table one = bake(ctx, &o);
        NEED(one.layers == 2 && both.layers == 4);
        for (int taps = 0; taps < 2; taps++)
            CHECK(!memcmp(texel(&one, taps, 0, 0),
                          texel(&both, 2 * taps + f, 0, 0), n * sizeof(float)));
    }
}

/* Those of lobe_tables.f16 are what a fit says, by any number of threads. */
TEST_SLOW(known_tables)
{
    ibl_ctx *ctx = test_ctx(2, IBL_ISA_AUTO);
    for (int i = 0; i < (TEST_SANITIZED ? 1 : IBL_LOBE_KNOWN); i++) {
        ibl_lobe_table_options o = ibl_lobe_table_options_default();
        ibl_specular_options s = ibl_specular_options_default();
        static float fit[IBL_LOBE_KNOWN_BYTES / 2];
        s.size = IBL_LOBE_KNOWN_SIZE << i;
        NEED(!ibl_specular_layout_of(&s, &o.layout) &&
             !ibl_lobe_table_fit(ctx, &o, fit));
        const ibl_lobe_table t = bake(ctx, &o);
        CHECK_MSG(!memcmp(t.data, fit, sizeof fit), "size %d: make lobe-tables",
                  s.size);
    }
}

/* Any chain has a table in range: one level, many, parts of the range. */
TEST(chains)
{
    ibl_ctx *ctx = test_ctx(2, IBL_ISA_AUTO);
    static const struct {
        int size, levels;
        double from, to;
    } chains[] = {{1, 1, 0, 1},      {2, 2, 0, 1},       {4, 3, 0, 1},
                  {64, 1, 0.5, 0.5}, {256, 0, 0.3, 0.8}, {16384, 15, 0, 1}};
    for (size_t i = 0; i < sizeof chains / sizeof *chains; i++) {
        ibl_lobe_table_options o = ibl_lobe_table_options_default();
        ibl_specular_options s = ibl_specular_options_default();
        s.size = chains[i].size;
        s.levels = chains[i].levels;
        s.roughness_min = chains[i].from;
        s.roughness_max = chains[i].to;
        NEED(!ibl_specular_layout_of(&s, &o.layout));
        o.size = 8;
        const ibl_lobe_table t = bake(ctx, &o);
        check_range(&t);
        if (o.layout.levels == 1)
            CHECK(texel(&t, 0, 4, 7)[1] <= 0);
    }
}
