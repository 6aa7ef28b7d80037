/* SPDX-License-Identifier: MIT */
/*
 * The error that can be expected of what is drawn with a distribution of
 * materials. Where no lobe table is given, a target is looked up between the
 * two levels and with the share of irradiance of least error (bake/lobe_fit.h),
 * in the direction of ibl/ibl.glsl's ibl_lobe_fit: what a table fitted to that
 * chain comes near to.
 */
#include <math.h>
#include <stdbool.h>
#include <string.h>

#include "bake/expectation.h"
#include "bake/options.h"
#include "bake/true_lobe.h"
#include "brdf/ggx.h"
#include "core/alloc.h"
#include "core/context.h"
#include "kern/brdf_quadrature.h"

enum {
    VIEWS = IBL_EXPECTED_VIEWS,
    NODES = IBL_EXPECTED_NODES,
    TARGETS = IBL_EXPECTED_TARGETS,
    DEGREES = IBL_EXPECTED_DEGREES,
    BENT = IBL_EXPECTED_BENT,
    TABLE = 128, /* edge of the BRDF table that counts as the truth */
    BEYOND = 8   /* half octaves beyond the degrees that are known */
};

static const ibl_specular_layout none = {
    .size = 1, .levels = 1, .roughness = {1}};

/* Bins of roughness that stand for the others, if there are many. */
static const int bins[NODES] = {0,  3,  4,  6,  8,  10, 12, 16, 20, 24,
                                28, 32, 36, 40, 44, 48, 52, 56, 60, 64};

ibl_materials ibl_materials_all(void)
{
    ibl_materials m;
    for (int i = 0; i <= IBL_MATERIAL_STEPS; i++)
        for (int f = 0; f < 2; f++) {
            m.weight[i][f] = 1;
            m.diffuse[i][f] = f ? 0.18 : 0;
        }
    return m;
}

/* ---- nodes -------------------------------------------------------------- */

static bool has_bin(const ibl_materials *m, int i)
{
    return m->weight[i][0] > 0 || m->weight[i][1] > 0;
}

static void add_bin(const ibl_materials *m, int i, double share,
                    ibl_expected_node *to)
{
    for (int f = 0; f < 2; f++) {
        const double w = share * m->weight[i][f];
        to->weight[f] += w;
        to->diffuse[f] += w * m->diffuse[i][f];
    }
}

/* Bins between two of the list count for both. */
static void merge_bins(const ibl_materials *m, ibl_expected_node all[NODES])
{
    for (int i = 0, k = 0; i <= IBL_MATERIAL_STEPS; i++) {
        if (i > bins[k + 1])
            k++;
        const double t = (double)(i - bins[k]) / (bins[k + 1] - bins[k]);
        add_bin(m, i, 1 - t, &all[k]);
        add_bin(m, i, t, &all[k + 1]);
    }
}

static double roughness_of(int bin)
{
    const double r = (double)bin / IBL_MATERIAL_STEPS;
    return 2 * r < IBL_EXPECTED_LEAST ? 0 : fmax(r, IBL_EXPECTED_LEAST);
}

static void make_nodes(ibl_expectation *e, const ibl_materials *m)
{
    ibl_expected_node all[NODES] = {{0}};
    int count = 0, at[IBL_MATERIAL_STEPS + 1];
    for (int i = 0; i <= IBL_MATERIAL_STEPS; i++)
        if (has_bin(m, i))
            at[count++] = i;
    if (count > NODES)
        merge_bins(m, all);
    for (int i = 0; i < (count > NODES ? NODES : count); i++) {
        const int bin = count > NODES ? bins[i] : at[i];
        if (count <= NODES)
            add_bin(m, bin, 1, &all[i]);
        all[i].roughness = roughness_of(bin);
        for (int f = 0; f < 2; f++)
            all[i].diffuse[f] /= fmax(all[i].weight[f], 1e-300);
        if (all[i].weight[0] > 0 || all[i].weight[1] > 0)
            e->node[e->nodes++] = all[i];
    }
}

/* ---- lobes of surfaces --------------------------------------------------- */

/* Degrees of a mirror, which sees all of the map. Beyond the last that is known
 * are the steps between pixels: C_l falls as l^-3, so that each half octave has
 * 1 / sqrt(2) of what the one before has. */
static void mirror_degrees(const ibl_expectation *e, ibl_lobe_bands *b)
{
    const int last = e->degree < IBL_LOBE_DEGREE ? e->degree : IBL_LOBE_DEGREE;
    double rest = e->kernels.mean;
    ibl_bands_fill(e->kernels.power, last, 8, b);
    for (int i = 0; i < b->count; i++)
        rest += b->share[i];
    rest *= e->beyond;
    for (int i = 0; i < BEYOND; i++, b->count++) {
        b->degree[b->count] = (int)(last * pow(2, 0.5 * i + 0.25));
        b->share[b->count] = i + 1 < BEYOND ? (1 - sqrt(0.5)) * rest : rest;
        rest *= sqrt(0.5);
    }
}

/* A point at R. */
static void mirror_bands(double n_v, ibl_lobe_bands *b)
{
    double angle[IBL_BANDS_DIRECTIONS];
    double p[IBL_BANDS_DIRECTIONS][IBL_BANDS_MOST];
    for (int k = 0; k < b->directions; k++)
        angle[k] = b->angle[k] - b->angle[IBL_TO_R];
    ibl_lookup_legendre(angle, b->directions, b, p);
    for (int f = 0; f < 2; f++) {
        b->energy[f] = f ? IBL_DIELECTRIC_F0 +
                               (1 - IBL_DIELECTRIC_F0) * ibl_fresnel_weight(n_v)
                         : 1;
        for (int i = 0; i < b->count; i++) {
            const double n = (2 * b->degree[i] + 1) / (4 * IBL_PI);
            b->power[f][i] = n;
            for (int k = 0; k < b->directions; k++)
                b->toward[f][k][i] = n * p[k][i];
        }
    }
}

static void make_bands(const ibl_expectation *e, int job, ibl_lobe_bands *b)
{
    const double n_v = e->at[job % VIEWS], r = e->node[job / VIEWS].roughness;
    if (r > 0)
        ibl_lobe_bands_make(&e->rule, n_v, r * r, b);
    else
        mirror_bands(n_v, b);
}

static void fill_target(const ibl_expectation *e, int job, int f,
                        ibl_expected_target *t)
{
    const ibl_expected_node *n = &e->node[job / VIEWS];
    const ibl_lobe_bands *b = &e->view[job].bands;
    const double *cosine = ibl_lobe_of(&e->kernels, e->kernels.layout.levels);
    const double n_v = e->at[job % VIEWS];
    *t = (ibl_expected_target){.weight = n->weight[f] * e->weight[job % VIEWS] *
                                         2 * n_v * b->energy[f] * b->energy[f],
                               .diffuse = n->diffuse[f] / b->energy[f]};
    for (int i = 0; i < b->count; i++) {
        const int l = b->degree[i];
        const double k = l < DEGREES ? cosine[l] : 0;
        const double c = 4 * IBL_PI / (2 * l + 1) * b->share[i];
        t->power += c * b->power[f][i];
        t->even += c * k * b->toward[f][IBL_TO_N][i];
        t->both += b->share[i] * k * k;
        t->seen[i] = c * b->toward[f][BENT + f][i];
        t->lit[i] = b->share[i] * k * e->view[job].p[BENT + f][i];
    }
}

static void view_job(void *arg, int job, int worker)
{
    ibl_expectation *e = arg;
    ibl_lobe_bands *b = &e->view[job].bands;
    const double n_v = e->at[job % VIEWS], r = e->node[job / VIEWS].roughness;
    (void)worker;
    b->directions = 0;
    if (r > 0)
        ibl_bands_degrees(e->kernels.power, r, b);
    else
        mirror_degrees(e, b);
    ibl_lookup_direction(b, n_v, 1); /* IBL_TO_N */
    ibl_lookup_direction(b, n_v, 0); /* IBL_TO_R */
    for (int f = 0; f < 2; f++)      /* BENT */
        ibl_lookup_direction(b, n_v,
                             (f ? 1.4 : 3.3) * r * r * r * (1 - r) * (1 - n_v));
    ibl_lookup_legendre(b->angle, b->directions, b, e->view[job].p);
    make_bands(e, job, b);
    for (int f = 0; f < 2; f++)
        fill_target(e, job, f, &e->target[2 * job + f]);
}

/* ---- a set ----------------------------------------------------------------
 */

typedef struct judging {
    const ibl_expectation *e;
    const ibl_expected_set *set;
    ibl_lobe_kernels kernels;
    ibl_best_lookups *best; /* NULL: lookups follow from the set */
    double sum[TARGETS];
} judging;

/* A BRDF table's F0 A + B, for F0 = 1 and .04. */
static void fetch_table(const ibl_lut *t, double n_v, double r, double to[2])
{
    const double x = fmin(fmax(n_v * t->size - 0.5, 0), t->size - 1);
    const double y = fmin(fmax(r * t->size - 0.5, 0), t->size - 1);
    const int i = (int)fmin(x, t->size - 2), j = (int)fmin(y, t->size - 2);
    double ab[2] = {0, 0};
    for (int k = 0; k < 4; k++) {
        const double u = k % 2 ? x - i : 1 - (x - i);
        const double v = k / 2 ? y - j : 1 - (y - j);
        const float *at = t->data + 2 * ((size_t)(j + k / 2) * (size_t)t->size +
                                         (size_t)(i + k % 2));
        ab[0] += u * v * at[0];
        ab[1] += u * v * at[1];
    }
    to[0] = ab[0] + ab[1];
    to[1] = IBL_DIELECTRIC_F0 * ab[0] + ab[1];
}

static ibl_lookup_use use_of(const judging *j, int job, int f,
                             ibl_lobe_bands *b)
{
    const ibl_expectation *e = j->e;
    const double r = e->node[job / VIEWS].roughness, n_v = e->at[job % VIEWS];
    ibl_lookup_use use = {.taps = 1, .at = {IBL_TO_R, IBL_TO_R}};
    if (!j->set->layout.levels) {
        use.weight = 1;
    } else if (j->set->lookup == IBL_LOOKUP_SPLIT) {
        use.lod = ibl_lod_of_roughness(&j->kernels.layout, r);
    } else if (j->set->lobes) {
        use = ibl_lookup_by_table(j->set->lobes, &j->kernels, f,
                                  j->set->lookup == IBL_LOOKUP_TWO_TAPS ? 2 : 1,
                                  n_v, r, b);
    } else {
        ibl_best_lookup(j->best, 2 * job + f, &use.lod, &use.weight);
        use.at[0] = use.at[1] = BENT + f;
    }
    return use;
}

/* The lobe and its Legendre functions in the directions from `known` on, and
 * between two taps. */
static void add_directions(const ibl_expectation *e, int job, int known,
                           const double apart[2], ibl_lookup_view *v)
{
    const double n_v = e->at[job % VIEWS];
    double angle[IBL_LOOKUP_ANGLES];
    if (v->bands.directions == known)
        return;
    memcpy(angle, v->bands.angle, sizeof v->bands.angle);
    memcpy(angle + IBL_LOOKUP_APART, apart, 2 * sizeof *apart);
    ibl_lookup_legendre(angle + known, IBL_LOOKUP_ANGLES - known, &v->bands,
                        v->p + known);
    if (e->node[job / VIEWS].roughness > 0)
        ibl_lobe_bands_toward(&e->rule, n_v, known, &v->bands);
    else
        mirror_bands(n_v, &v->bands);
}

static void judge_job(void *arg, int job, int worker)
{
    judging *j = arg;
    const ibl_expectation *e = j->e;
    const double r = e->node[job / VIEWS].roughness, n_v = e->at[job % VIEWS];
    ibl_lookup_view v = e->view[job];
    ibl_lookup_use use[2];
    double apart[2] = {0, 0}, truth[2] = {1, 1}, own[2] = {1, 1};
    (void)worker;
    for (int f = 0; f < 2; f++) {
        ibl_lookup_use *u = &use[f];
        *u = use_of(j, job, f, &v.bands);
        apart[f] = v.bands.angle[u->at[0]] - v.bands.angle[u->at[u->taps - 1]];
    }
    add_directions(e, job, e->view[job].bands.directions, apart, &v);
    if (j->set->lut) {
        fetch_table(&e->truth, n_v, r, truth);
        fetch_table(j->set->lut, n_v, r, own);
    }
    for (int f = 0; f < 2; f++) {
        const ibl_expected_target *t = &e->target[2 * job + f];
        const ibl_lookup_set set = {.diffuse = t->diffuse,
                                    .table = own[f] / truth[f],
                                    .irradiance = j->set->irradiance,
                                    .step = j->set->step,
                                    .slope = j->set->slope};
        if (t->weight > 0)
            j->sum[2 * job + f] =
                t->weight * ibl_lookup_error(&j->kernels, &v, f, &use[f], &set);
    }
}

/* Fills the sums of all targets. */
static ibl_status judge(judging *j)
{
    const ibl_expectation *e = j->e;
    ibl_status status = IBL_OK;
    memset(j->sum, 0, sizeof j->sum);
    if (!j->set->lobes && j->set->lookup != IBL_LOOKUP_SPLIT &&
        j->set->layout.levels)
        status = ibl_best_lookups_of(e, &j->set->layout, &j->best);
    if (!status)
        status = ibl_run(e->ctx, NULL, e->nodes * VIEWS, judge_job, j);
    ibl_free(j->best);
    j->best = NULL;
    return status;
}

static ibl_status check_set(ibl_ctx *ctx, const ibl_expected_set *set)
{
    const ibl_lobe_table_options o = {
        .struct_size = sizeof o, .size = 16, .layout = set->layout};
    if (set->irradiance < -1 || set->irradiance > IBL_MAX_CUBE_SIZE ||
        !(set->step >= 0) || !(set->slope >= 0) ||
        (set->lut && (set->lut->kind != IBL_LUT_SPLIT || set->lut->size < 2)) ||
        (int)set->lookup < 0 || set->lookup >= IBL_LOOKUP_COUNT ||
        (set->lookup == IBL_LOOKUP_TWO_TAPS && !set->lobes))
        return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                        "a set to expect an error of: a member is out of "
                        "range");
    return set->layout.levels ? ibl_lobe_table_check(ctx, &o) : IBL_OK;
}

ibl_status ibl_expectation_of(const ibl_expectation *e,
                              const ibl_expected_set *set, double *nrmse)
{
    if (!e || !set || !nrmse)
        return ibl_missing(e ? e->ctx : NULL,
                           "ibl_expectation_of: set or nrmse");
    const ibl_specular_layout *layout =
        set->layout.levels ? &set->layout : &none;
    judging j = {.e = e, .set = set};
    ibl_status status = check_set(e->ctx, set);
    if (!status)
        status = ibl_lobe_kernels_make(e->ctx, layout, e->given, e->degree,
                                       &j.kernels);
    j.kernels.most = e->most;
    if (!status)
        status = judge(&j);
    double sum = 0;
    for (int i = 0; i < 2 * e->nodes * VIEWS && !status; i++)
        sum += j.sum[i];
    if (!status)
        *nrmse = sqrt(sum / e->total);
    ibl_lobe_kernels_free(&j.kernels);
    return status;
}

/* ---- the call -------------------------------------------------------------
 */

static ibl_status make_views(ibl_expectation *e)
{
    e->view = ibl_alloc_array((size_t)e->nodes * VIEWS, sizeof *e->view);
    if (!e->view)
        return ibl_no_memory(e->ctx, "the expected error");
    ibl_gauss_points(VIEWS, e->at, e->weight);
    ibl_bands_rule_init(&e->rule, ibl_ctx_isa(e->ctx));
    return ibl_run(e->ctx, NULL, e->nodes * VIEWS, view_job, e);
}

static ibl_status make(ibl_expectation *e)
{
    const ibl_lut_options lut = {.struct_size = sizeof lut, .size = TABLE};
    ibl_status status =
        ibl_lobe_kernels_make(e->ctx, &none, e->given, e->degree, &e->kernels);
    if (!status)
        status = ibl_bake_lut(e->ctx, &lut, &e->truth);
    if (status)
        return status;
    status = make_views(e);
    for (int i = 0; i < 2 * e->nodes * VIEWS; i++) {
        const ibl_expected_target *t = &e->target[i];
        if (t->weight > 0)
            e->total +=
                t->weight * ibl_lookup_power(&e->kernels, &e->view[i / 2],
                                             i % 2, t->diffuse);
    }
    return status;
}

void ibl_expectation_free(ibl_expectation *e)
{
    if (!e)
        return;
    ibl_lobe_kernels_free(&e->kernels);
    ibl_lut_free(&e->truth);
    ibl_free((void *)e->given);
    ibl_free(e->view);
    ibl_free(e->lobe);
    ibl_free(e);
}

/* The power beyond the degrees that are known, as a share of that up to it. */
static double power_beyond(const double *power, int degree, double square)
{
    double known = 0;
    for (int l = 0; l <= degree && l <= IBL_LOBE_DEGREE; l++)
        known += (2 * l + 1) * power[l] / (4 * IBL_PI);
    return square > known ? square / known - 1 : 0;
}

ibl_status ibl_expectation_create(ibl_ctx *ctx, const ibl_materials *materials,
                                  const double *power, int degree, int most,
                                  double square, ibl_expectation **out)
{
    if (!ctx || !materials || !power || !out)
        return ibl_missing(ctx, "ibl_expectation_create: materials, power or "
                                "out");
    if (degree < 1 || most < 1)
        return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                        "a spectrum of degree %d of a map of degree %d: must "
                        "be 1 or more",
                        degree, most);
    ibl_expectation *e = ibl_alloc_zeroed(1, sizeof *e);
    double *given = ibl_alloc_array((size_t)degree + 1, sizeof *given);
    ibl_status status =
        e && given ? IBL_OK : ibl_no_memory(ctx, "the expected error");
    if (!status) {
        e->ctx = ctx;
        e->degree = degree;
        e->most = most;
        e->beyond = power_beyond(power, degree, square);
        memcpy(given, power, ((size_t)degree + 1) * sizeof *power);
        e->given = given;
        given = NULL;
        make_nodes(e, materials);
        status = e->nodes ? make(e)
                          : ibl_fail(ctx, IBL_ERR_ARGUMENT,
                                     "materials without a weight: at least one "
                                     "must be above 0");
    }
    ibl_free(given);
    if (status) {
        ibl_expectation_free(e);
        e = NULL;
    }
    *out = e;
    return status;
}
