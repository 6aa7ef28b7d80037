/* SPDX-License-Identifier: MIT */
/* The error to expect of a distribution of materials. */
#include <math.h>
#include <string.h>

#include "cli/lookup.h"
#include "ibl/reference.h"
#include "maps.h"
#include "test.h"

enum {
    LAST = 256
};

static const double pi = 3.14159265358979323846;

static void fill_power(double fall, double power[LAST + 1])
{
    power[0] = 30;
    for (int l = 1; l <= LAST; l++)
        power[l] = pow(l, -fall);
}

static void free_expectation(void *e)
{
    ibl_expectation_free(*(ibl_expectation **)e);
}

static ibl_expectation *expect(ibl_ctx *ctx, const ibl_materials *m,
                               const double *power)
{
    ibl_expectation *e;
    NEED(!ibl_expectation_create(ctx, m, power, LAST, 512, 0, &e));
    test_defer_copy(free_expectation, &e, sizeof e);
    return e;
}

static double error_of(const ibl_expectation *e, const ibl_expected_set *set)
{
    double nrmse;
    NEED(!ibl_expectation_of(e, set, &nrmse));
    return nrmse;
}

static ibl_expected_set usual_set(ibl_lookup lookup)
{
    const ibl_lobe_table_options o = ibl_lobe_table_options_default();
    return (ibl_expected_set){
        .layout = o.layout, .lookup = lookup, .irradiance = -1};
}

/* Of a white surface of roughness 1 without levels, nothing is off but the
 * reflection, of which irradiance takes the place; harmonics of degree 2 lack
 * what sum (2 l + 1) C_l k_l^2 / 4 pi says, k_4 = -1/24 of k_0 and so on. */
TEST(of_diffuse_light)
{
    ibl_ctx *ctx = test_ctx(2, IBL_ISA_AUTO);
    const double albedo = 1000; /* so that nothing else counts */
    ibl_materials m = {.weight = {{0}}};
    double power[LAST + 1], lacks = 0, all = 0;
    fill_power(0.5, power);
    m.weight[64][1] = 1;
    m.diffuse[64][1] = albedo;
    for (int l = 0; l <= LAST; l++) {
        const double k = ibl_sh_cosine(l);
        const double part = (2 * l + 1) * power[l] * k * k;
        all += part;
        lacks += l > 2 ? part : 0;
    }
    const ibl_expectation *e = expect(ctx, &m, power);
    ibl_expected_set set = {.irradiance = 0};
    CHECK_NEAR(error_of(e, &set) / sqrt(lacks / all), 1, 0.02);
    set.irradiance = -1;
    CHECK(error_of(e, &set) < 1e-4);
    double before = 1;
    for (int edge = 2; edge <= 64; edge *= 2) {
        set.irradiance = edge;
        const double now = error_of(e, &set);
        CHECK(now < before);
        before = now;
    }
    set.step = 0.01; /* four ninths of its square are left */
    CHECK_NEAR(error_of(e, &set), 0.01 * 2 / 3, 1e-3);
}

/* Squares of what bilinear lookups in level 0 are off from the map's pixels,
 * and of these, along random directions in each pixel. */
static double off_in_level0(const ibl_image *map, const ibl_cube *cube,
                            test_random *rnd, double *square)
{
    double off = 0;
    *square = 0;
    for (int i = 0; i < 16 * map->width * map->height; i++) {
        const int x = i / 16 % map->width, y = i / 16 / map->width;
        const float *want = map_pixel(map, x, y);
        const double theta = pi * (y + test_random_unit(rnd)) / map->height;
        const double phi =
            2 * pi * ((x + test_random_unit(rnd)) / map->width - 0.5);
        const double d[3] = {sin(theta) * cos(phi), cos(theta),
                             sin(theta) * sin(phi)};
        double rgb[3];
        ibl_lookup_cube(cube, d, rgb);
        for (int k = 0; k < 3; k++) {
            off += sin(theta) * pow(rgb[k] - want[k], 2);
            *square += sin(theta) * want[k] * want[k];
        }
    }
    const double of_one = pi / 2 / (16 * map->width * map->height);
    *square *= of_one;
    return off * of_one;
}

/* A mirror is off by what its texels blur and, where they are finer than the
 * map's pixels, by what these are interpolated. */
TEST(of_a_mirror)
{
    static const map_kind kinds[3] = {MAP_SMOOTH, MAP_NOISE, MAP_SMOOTH};
    ibl_ctx *ctx = test_ctx(2, IBL_ISA_AUTO);
    const ibl_materials m = {.weight = {{1, 0}}};
    test_random rnd = {11};
    for (int kind = TEST_SANITIZED ? 2 : 0; kind < 3; kind++) {
        const ibl_image map = map_of_kind(ctx, &rnd, kinds[kind], 64, 32);
        ibl_bake_options o = ibl_bake_options_default();
        for (int i = 0; i < 30 && kind == 2; i++) /* a window */
            map_set(&map, 16 + i % 6, 8 + i / 6, 6, 5, 4);
        o.power = 32;
        const ibl_bake_result spectrum = map_bake(ctx, &map, &o);
        for (int size = 4; size <= 64; size *= TEST_SANITIZED ? 16 : 2) {
            const ibl_expected_set set = {
                .layout = {.size = size, .levels = 1, .roughness = {0}},
                .lookup = IBL_LOOKUP_SPLIT};
            const ibl_cube cube = cube_level0(ctx, &map, 0, size);
            double square;
            const double off = off_in_level0(&map, &cube, &rnd, &square);
            ibl_expectation *e;
            NEED(!ibl_expectation_create(ctx, &m, spectrum.power, 32, 32,
                                         square, &e));
            const double ratio = sqrt(off / square) / error_of(e, &set);
            ibl_expectation_free(e);
            test_measured("measured over or under the expected",
                          fmax(ratio, 1 / ratio), 1.5);
            CHECK_MSG(fmax(ratio, 1 / ratio) < 1.5, "map %d size %d: ratio %g",
                      kind, size, ratio);
        }
    }
}

/* A table of few texels is off by more; a fitted ladder serves its materials
 * better than the usual levels of more bytes. */
TEST(ladders)
{
    ibl_ctx *ctx = test_ctx(2, IBL_ISA_AUTO);
    ibl_materials m = {.weight = {{0}}};
    ibl_specular_layout layout;
    double power[LAST + 1], nrmse, before = 1;
    fill_power(1.2, power);
    for (int i = 24; i < 36; i++)
        m.weight[i][0] = 1;
    ibl_expectation *e = expect(ctx, &m, power);
    const ibl_expected_set usual = usual_set(IBL_LOOKUP_TABLE);
    for (int levels = 1; levels <= 4; levels++) {
        NEED(!ibl_expectation_fit(e, 64, levels, &layout, &nrmse));
        CHECK(nrmse < before * 1.001);
        before = nrmse;
        for (int l = 1; l < levels; l++)
            CHECK(layout.roughness[l] > layout.roughness[l - 1]);
        const ibl_expected_set set = {
            .layout = layout, .lookup = IBL_LOOKUP_TABLE, .irradiance = -1};
        CHECK_NEAR(error_of(e, &set) / nrmse, 1, 0.01);
        /* no step of two levels lessens it */
        for (int l = 0; l < levels && levels == 2; l++)
            for (int way = -1; way <= 1; way += 2) {
                ibl_expected_set other = set;
                other.layout.roughness[l] += way * 2 / 128.0;
                CHECK(error_of(e, &other) > nrmse * 0.999);
            }
    }
    CHECK(before < error_of(e, &usual));
}

/* With a table of twice F0 A + B a reflection is twice as bright as it should
 * be: it is off by itself, the mean included. */
TEST(tables)
{
    ibl_ctx *ctx = test_ctx(1, IBL_ISA_AUTO);
    const ibl_lut_options o = {.struct_size = sizeof o, .size = 64};
    ibl_materials m = {.weight = {{0}}};
    double power[LAST + 1];
    ibl_lut lut;
    fill_power(2, power);
    m.weight[40][0] = 1;
    NEED(!ibl_bake_lut(ctx, &o, &lut));
    const ibl_expectation *e = expect(ctx, &m, power);
    ibl_expected_set set = usual_set(IBL_LOOKUP_TABLE);
    const double exact = error_of(e, &set);
    set.lut = &lut;
    CHECK_NEAR(error_of(e, &set), exact, 1e-3);
    for (size_t i = 0; i < 2 * 64 * 64; i++)
        lut.data[i] *= 2;
    CHECK_NEAR(error_of(e, &set), 1, 0.05);
    ibl_lut_free(&lut);
}

/* ---- measured -------------------------------------------------------------
 */

enum {
    PAIRS = 400,
    MOST_LEVELS = 4
};

/* Random pairs of a normal and a view, which are all rotations of the map and
 * all views of a sphere; N.V has the density 2 N.V. */
typedef struct pairs {
    double normal[PAIRS][3], view[PAIRS][3], mirror[PAIRS][3], n_v[PAIRS];
    double light[PAIRS][3]; /* irradiance / pi */
    bool known[IBL_MATERIAL_STEPS + 1];
    double truth[IBL_MATERIAL_STEPS + 1][PAIRS][IBL_REFERENCE_BRDF];
} pairs;

static void draw_pairs(test_random *rnd, pairs *p)
{
    for (int i = 0; i < PAIRS; i++) {
        double *n = p->normal[i], *v = p->view[i], t[3];
        const double z = test_random_between(rnd, -1, 1);
        const double phi = test_random_between(rnd, 0, 2 * pi);
        const double psi = test_random_between(rnd, 0, 2 * pi);
        const double rho = sqrt(1 - z * z), c = sqrt(test_random_unit(rnd));
        const double x[3] = {-sin(phi), cos(phi), 0};
        n[0] = rho * cos(phi), n[1] = rho * sin(phi), n[2] = z;
        for (int k = 0; k < 3; k++)
            t[k] =
                cos(psi) * x[k] + sin(psi) * (n[(k + 1) % 3] * x[(k + 2) % 3] -
                                              n[(k + 2) % 3] * x[(k + 1) % 3]);
        for (int k = 0; k < 3; k++) {
            v[k] = c * n[k] + sqrt(1 - c * c) * t[k];
            p->mirror[i][k] = 2 * c * n[k] - v[k];
        }
        p->n_v[i] = c;
    }
}

/* What is drawn with: all of it in memory. */
typedef struct baked {
    ibl_expected_set as; /* with its tables */
    ibl_lut lut;
    ibl_lobe_table lobes;
    ibl_bake_result made;
} baked;

static void free_set(void *p)
{
    baked *s = p;
    ibl_lut_free(&s->lut);
    ibl_lobe_table_free(&s->lobes);
    ibl_bake_result_free(&s->made);
}

static void make_set(ibl_ctx *ctx, const ibl_image *map,
                     const ibl_specular_layout *layout, int irradiance,
                     baked *s)
{
    const ibl_lut_options lut = {.struct_size = sizeof lut, .size = 24};
    const ibl_environment env = {.image = map};
    ibl_lobe_table_options lobes = ibl_lobe_table_options_default();
    ibl_bake_options o = ibl_bake_options_default();
    *s = (baked){.as = {.layout = *layout,
                        .lookup = IBL_LOOKUP_TABLE,
                        .irradiance = irradiance}};
    lobes.layout = *layout;
    o.specular_options.size = layout->size;
    o.specular_options.levels = layout->levels;
    o.specular_options.roughness = layout->roughness;
    o.irradiance_options.size = irradiance;
    NEED(!ibl_bake_lut(ctx, &lut, &s->lut));
    NEED(!ibl_bake_lobe_table(ctx, &lobes, &s->lobes));
    NEED(!ibl_bake_environment(ctx, &env, &o, &s->made));
}

static void look_up(const baked *s, const pairs *p, int i, double r, int f,
                    const double even[3], double rgb[3])
{
    const ibl_specular_layout *l = &s->as.layout;
    ibl_cube level[MOST_LEVELS];
    double q[4], d[3];
    for (int m = 0; m < l->levels; m++)
        level[m] = (ibl_cube){.size = ibl_cube_edge(l->size, m),
                              .levels = 1,
                              .data = ibl_cube_face(&s->made.specular, m, 0)};
    ibl_lookup_lobes(&s->lobes, 1, f ? 0 : 1, p->n_v[i], r, q);
    for (int k = 0; k < 3; k++)
        d[k] = p->mirror[i][k] + q[0] * (p->normal[i][k] - p->mirror[i][k]);
    const double most = ibl_lod_of_roughness(l, fmin(1.25 * r, 1));
    ibl_lookup_chain(level, l->levels, d, fmin(q[1] * (l->levels - 1), most),
                     rgb);
    for (int k = 0; k < 3; k++)
        rgb[k] += q[2] * (even[k] - rgb[k]);
}

/* Adds the squares of what is drawn less what is sent out, and of that. */
static void add_squares(const ibl_reference *ref, pairs *p,
                        const ibl_materials *m, int bin, const baked *s,
                        double sum[2])
{
    const double r = (double)bin / IBL_MATERIAL_STEPS;
    if (!p->known[bin])
        NEED(!ibl_reference_brdf(ref, IBL_GEOMETRY_SMITH, &r, 1, p->normal[0],
                                 p->view[0], PAIRS, p->truth[bin][0]));
    p->known[bin] = true;
    for (int i = 0; i < PAIRS; i++)
        for (int f = 0; f < 2; f++) {
            const double *t = p->truth[bin][i], f0 = f ? 0.04 : 1;
            const double albedo = m->diffuse[bin][f];
            double even[3], rgb[3], ab[2];
            ibl_lookup_cube(&s->made.irradiance, p->normal[i], even);
            ibl_lookup_lut(&s->lut, p->n_v[i], r, ab);
            look_up(s, p, i, r, f, even, rgb);
            for (int k = 0; k < 3; k++) {
                const double sent =
                    f0 * t[k] + t[4 + k] + albedo * p->light[i][k];
                const double drawn =
                    rgb[k] * (f0 * ab[0] + ab[1]) + albedo * even[k];
                sum[0] += m->weight[bin][f] * pow(drawn - sent, 2);
                sum[1] += m->weight[bin][f] * sent * sent;
            }
        }
}

static double measured(const ibl_reference *ref, pairs *p,
                       const ibl_materials *m, const baked *s)
{
    double sum[2] = {0, 0};
    for (int i = 0; i <= IBL_MATERIAL_STEPS; i++)
        if (m->weight[i][0] > 0 || m->weight[i][1] > 0)
            add_squares(ref, p, m, i, s, sum);
    return sqrt(sum[0] / sum[1]);
}

/* Plastic, metal, a mixture, something glossy and something matte. */
static ibl_materials materials_of(int which)
{
    static const int bin[5][3] = {
        {28, 36, 44}, {20, 20, 20}, {16, 40, 64}, {14, 14, 18}, {56, 60, 64}};
    static const double metal[5] = {0, 1, 0.3, 0.05, 0};
    static const double albedo[5] = {0.3, 0, 0.25, 0.5, 0.5};
    ibl_materials m = {.weight = {{0}}};
    for (int i = 0; i < 3; i++) {
        m.weight[bin[which][i]][0] = metal[which];
        m.weight[bin[which][i]][1] = 1 - metal[which];
        m.diffuse[bin[which][i]][1] = albedo[which];
    }
    return m;
}

/* Lookups in the real levels and tables, against the integrals over the map's
 * pixels. */
TEST_SLOW(as_measured)
{
    static const map_kind kinds[3] = {MAP_SMOOTH, MAP_NOISE, MAP_SMOOTH};
    static const int sizes[2][2] = {{64, 3}, {16, 2}};
    if (TEST_RACES)
        test_skip("takes a minute, and has no threads of its own");
    ibl_ctx *ctx = test_ctx(2, IBL_ISA_AUTO);
    static pairs p;
    test_random rnd = {17};
    for (int k = TEST_SANITIZED ? 2 : 0; k < 3; k++) {
        const ibl_image map = map_of_kind(ctx, &rnd, kinds[k], 32, 16);
        ibl_bake_options o = ibl_bake_options_default();
        ibl_reference *ref;
        for (int i = 0; i < 30 && k == 2; i++) /* a window */
            map_set(&map, 16 + i % 6, 4 + i / 6, 6, 5, 4);
        o.power = LAST;
        const ibl_bake_result spectrum = map_bake(ctx, &map, &o);
        memset(&p, 0, sizeof p);
        draw_pairs(&rnd, &p);
        NEED(!ibl_reference_create(ctx, &map, 0, &ref));
        NEED(!ibl_reference_lobe(ref, IBL_LOBE_GGX, 1, p.normal[0], PAIRS,
                                 p.light[0]));
        for (int which = 0; which < 5; which += TEST_SANITIZED ? 5 : 1)
            for (int i = 0; i < 2; i++) {
                const ibl_materials m = materials_of(which);
                ibl_specular_layout layout;
                ibl_expectation *e = expect(ctx, &m, spectrum.power);
                double nrmse;
                baked s;
                NEED(!ibl_expectation_fit(e, sizes[i][0], sizes[i][1], &layout,
                                          &nrmse));
                make_set(ctx, &map, &layout, i ? 8 : 32, &s);
                s.as.lut = &s.lut;
                s.as.lobes = &s.lobes;
                const double want = error_of(e, &s.as);
                const double ratio = measured(ref, &p, &m, &s) / want;
                test_measured("measured over or under the expected",
                              fmax(ratio, 1 / ratio), 1.5);
                CHECK_MSG(fmax(ratio, 1 / ratio) < 1.5,
                          "map %d materials %d size %d: expected %g, ratio %g",
                          k, which, sizes[i][0], want, ratio);
                free_set(&s);
            }
        ibl_reference_free(ref);
    }
}

TEST(refused)
{
    ibl_ctx *ctx = test_ctx(1, IBL_ISA_AUTO);
    const ibl_materials none = {.weight = {{0}}}, all = ibl_materials_all();
    double power[LAST + 1], nrmse;
    ibl_specular_layout layout;
    ibl_expectation *e;
    fill_power(1, power);
    CHECK(ibl_expectation_create(ctx, &none, power, LAST, 64, 1, &e) ==
          IBL_ERR_ARGUMENT);
    CHECK(ibl_expectation_create(ctx, &all, power, 0, 64, 1, &e) ==
          IBL_ERR_ARGUMENT);
    e = expect(ctx, &all, power);
    ibl_expected_set set = {.irradiance = -2};
    CHECK(ibl_expectation_of(e, &set, &nrmse) == IBL_ERR_ARGUMENT);
    set = usual_set(IBL_LOOKUP_TWO_TAPS);
    CHECK(ibl_expectation_of(e, &set, &nrmse) == IBL_ERR_ARGUMENT);
    set.layout.levels = 99;
    set.lookup = IBL_LOOKUP_SPLIT;
    CHECK(ibl_expectation_of(e, &set, &nrmse) == IBL_ERR_ARGUMENT);
    CHECK(ibl_expectation_fit(e, 8, 5, &layout, &nrmse) == IBL_ERR_ARGUMENT);
}
