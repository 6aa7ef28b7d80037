/* SPDX-License-Identifier: MIT */
/*
 * The error that can be expected of what is drawn with a distribution of
 * materials, and the ladder of least error for it.
 *
 * A target is the lobe of a surface, of a roughness, a view and F0. Where no
 * lobe table is given, it is looked up between the two levels and with the
 * share of irradiance of least error (bake/lobe_fit.h), in the direction of
 * ibl/ibl.glsl's ibl_lobe_fit: what a table fitted to that chain comes near to.
 */
#include <math.h>
#include <stdbool.h>
#include <string.h>

#include "bake/lobe_fit.h"
#include "bake/lookup_error.h"
#include "bake/options.h"
#include "bake/spectral/lobe_coefficients.h"
#include "bake/true_lobe.h"
#include "brdf/ggx.h"
#include "core/alloc.h"
#include "core/context.h"
#include "image/cube.h"
#include "kern/brdf_quadrature.h"

enum {
    VIEWS = 5,  /* Gauss-Legendre points of N.V */
    NODES = 20, /* roughnesses, at most */
    TARGETS = NODES * VIEWS * 2,
    GRID = 128,  /* roughnesses of ladders: i / GRID */
    LEAST = 7,   /* of them above 0 */
    TABLE = 128, /* edge of the BRDF table that counts as the truth */
    DEGREES = IBL_LOBE_DEGREE + 1,
    MOST_ROUGHNESSES = 64,
    BEYOND = 8, /* half octaves beyond the degrees that are known */
    BENT = 2    /* directions of a view, after IBL_TO_R: for F0 = 1, and .04 */
};

static const ibl_specular_layout none = {
    .size = 1, .levels = 1, .roughness = {1}};

/* Bins of roughness that stand for the others, if there are many. */
static const int bins[NODES] = {0,  3,  4,  6,  8,  10, 12, 16, 20, 24,
                                28, 32, 36, 40, 44, 48, 52, 56, 60, 64};

typedef struct node {
    double roughness; /* below IBL_EXPECTED_LEAST: a mirror */
    double weight[2], diffuse[2];
} node;

typedef struct target {
    double seen[IBL_BANDS_MOST]; /* C_l of the lobe, in the direction BENT */
    double lit[IBL_BANDS_MOST];  /* and of the cosine lobe */
    double weight;               /* of squares in units of its energy */
    double diffuse;              /* albedo, in units of its energy */
    double power;                /* |T|^2 without the mean */
    double both, even;           /* <cosine, cosine>, <cosine, T> */
} target;

struct ibl_expectation {
    ibl_ctx *ctx;
    bool exact; /* only lookups are judged, each way, and no ladders */
    ibl_bands_rule rule;
    double at[VIEWS], weight[VIEWS];
    ibl_lobe_kernels kernels; /* of no chain: the spectrum and the cosine */
    const double *given;      /* C_l as given, or NULL */
    int degree, most;         /* its last; the map's */
    double beyond;            /* power beyond `degree`, of that up to it */
    ibl_lut truth;
    int nodes;
    node node[NODES];
    ibl_lookup_view *view; /* VIEWS of each node */
    target target[TARGETS];
    double total;            /* of |T + a c|^2 */
    double (*lobe)[DEGREES]; /* of ladders; NULL: none was fitted */
    bool has_lobe[GRID + 1];
};

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

static void add_bin(const ibl_materials *m, int i, double share, node *to)
{
    for (int f = 0; f < 2; f++) {
        const double w = share * m->weight[i][f];
        to->weight[f] += w;
        to->diffuse[f] += w * m->diffuse[i][f];
    }
}

/* Bins between two of the list count for both. */
static void merge_bins(const ibl_materials *m, node all[NODES])
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
    node all[NODES] = {{0}};
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

static void fill_target(const ibl_expectation *e, int job, int f, target *t)
{
    const node *n = &e->node[job / VIEWS];
    const ibl_lobe_bands *b = &e->view[job].bands;
    const double *cosine = ibl_lobe_of(&e->kernels, e->kernels.layout.levels);
    const double n_v = e->at[job % VIEWS];
    *t = (target){.weight = n->weight[f] * e->weight[job % VIEWS] * 2 * n_v *
                            b->energy[f] * b->energy[f],
                  .diffuse = n->diffuse[f] / b->energy[f]};
    for (int i = 0; i < b->count && !e->exact; i++) {
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
    ibl_lookup_direction(b, n_v, 1);         /* IBL_TO_N */
    ibl_lookup_direction(b, n_v, 0);         /* IBL_TO_R */
    for (int f = 0; f < 2 && !e->exact; f++) /* BENT */
        ibl_lookup_direction(b, n_v,
                             (f ? 1.4 : 3.3) * r * r * r * (1 - r) * (1 - n_v));
    ibl_lookup_legendre(b->angle, b->directions, b, e->view[job].p);
    make_bands(e, job, b);
    for (int f = 0; f < 2; f++)
        fill_target(e, job, f, &e->target[2 * job + f]);
}

/* ---- ladders --------------------------------------------------------------
 */

/* Products of a level with the targets and, for each node, with itself and the
 * level before. */
typedef struct level {
    double with[TARGETS], even[TARGETS];
    double same[NODES], next[NODES];
    /* At the degrees of a node: k_l with the blur of texels, that blur, and
     * what texels add to the square. */
    double lobe[NODES][IBL_BANDS_MOST];
    double blur[NODES][IBL_BANDS_MOST], texels[NODES][IBL_BANDS_MOST];
    int blurred; /* 0: not yet; 1: a level of a lobe; 2: a mirror */
} level;

typedef struct ladder {
    ibl_expectation *e;
    ibl_specular_layout layout;
    level level[IBL_MAX_LEVELS];
    double cost[IBL_MAX_LEVELS][TARGETS];    /* between a level and the next */
    double best[IBL_MAX_LEVELS][TARGETS][2]; /* ibl_lobe_least's at */
} ladder;

static ibl_status fill_lobe(ibl_ctx *ctx, double r, double *k)
{
    for (int l = 0; l < DEGREES; l++)
        k[l] = 1;
    const ibl_lobe_shape shape = ibl_lobe_shape_of(IBL_LOBE_GGX, r * r);
    return r > 0 ? ibl_lobe_coefficients(ctx, &shape, DEGREES - 1, k) : IBL_OK;
}

/* What the texels of a level do, for its size and whether it is a mirror. */
static void blur_level(ladder *s, int m)
{
    const int kind = s->layout.roughness[m] > 0 ? 1 : 2;
    const int edge = (int)fmax(s->layout.size >> m, 1);
    level *to = &s->level[m];
    if (to->blurred == kind)
        return;
    to->blurred = kind;
    for (int n = 0; n < s->e->nodes; n++) {
        const ibl_lobe_bands *b = &s->e->view[n * VIEWS].bands;
        for (int i = 0; i < b->count; i++) {
            const double own =
                kind == 2 ? ibl_lookup_pixels(edge, s->e->most, b->degree[i])
                          : 1;
            to->blur[n][i] =
                own * ibl_lobe_blur_at(&s->layout, m, b->degree[i]);
            to->texels[n][i] =
                own * own * b->share[i] *
                ibl_lookup_scatter(edge, kind == 2, b->degree[i]);
        }
    }
}

/* k: of the level's lobe. Its texels blur it, and add to its square. */
static void level_of_node(ladder *s, int m, const double *k, int n)
{
    const ibl_lobe_bands *b = &s->e->view[n * VIEWS].bands;
    const double beyond = s->layout.roughness[m] > 0 ? 0 : 1;
    level *to = &s->level[m];
    const double *before = m ? to[-1].lobe[n] : to->lobe[n];
    double same = 0, next = 0;
    for (int i = 0; i < b->count; i++) {
        const int l = b->degree[i];
        const double own = l < DEGREES ? k[l] : beyond;
        const double lobe = own * to->blur[n][i];
        to->lobe[n][i] = lobe;
        same += b->share[i] * lobe * lobe + to->texels[n][i] * own * own;
        next += b->share[i] * lobe * before[i];
    }
    to->same[n] = same;
    to->next[n] = next;
}

static void level_of_target(ladder *s, int m, int i)
{
    const target *t = &s->e->target[i];
    const int n = i / (2 * VIEWS), count = s->e->view[i / 2].bands.count;
    const double *lobe = s->level[m].lobe[n];
    double with = 0, even = 0;
    for (int k = 0; k < count; k++) {
        with += lobe[k] * t->seen[k];
        even += lobe[k] * t->lit[k];
    }
    s->level[m].with[i] = with;
    s->level[m].even[i] = even;
}

/* The products of level m. Those of the level before must be there. */
static void make_level(ladder *s, int m, const double *k)
{
    const ibl_expectation *e = s->e;
    blur_level(s, m);
    for (int n = 0; n < e->nodes; n++)
        level_of_node(s, m, k, n);
    for (int i = 0; i < e->nodes * VIEWS * 2; i++)
        if (e->target[i].weight > 0)
            level_of_target(s, m, i);
}

/* The least costs between level m and the next or, if that is the last, with
 * itself. */
static void make_costs(ladder *s, int m)
{
    const ibl_expectation *e = s->e;
    const int two = m + 1 < s->layout.levels ? m + 1 : m;
    const level *a = &s->level[m], *b = &s->level[two];
    for (int i = 0; i < e->nodes * VIEWS * 2; i++) {
        const target *t = &e->target[i];
        const int n = i / (2 * VIEWS);
        const ibl_lobe_products p = {
            .h = {a->with[i], b->with[i]},
            .same = {a->same[n], b->same[n]},
            .next = {two > m ? b->next[n] : a->same[n]},
            .cosine = {a->even[i], b->even[i]},
            .both = t->both,
            .diffuse = t->even};
        s->cost[m][i] =
            t->weight > 0
                ? fmax(t->power + ibl_lobe_least(&p, 0, s->best[m][i]), 0)
                : 0;
    }
}

static int pairs_of(const ladder *s)
{
    return s->layout.levels > 1 ? s->layout.levels - 1 : 1;
}

/* The level below the best place of a target. */
static int best_pair(const ladder *s, int which)
{
    int best = 0;
    for (int m = 1; m < pairs_of(s); m++)
        if (s->cost[m][which] < s->cost[best][which])
            best = m;
    return best;
}

static double ladder_error(const ladder *s)
{
    double sum = 0;
    for (int i = 0; i < s->e->nodes * VIEWS * 2; i++)
        sum += s->e->target[i].weight * s->cost[best_pair(s, i)][i];
    return sum;
}

/* ---- the ladder of least error ------------------------------------------- */

static ibl_status grid_lobe(ibl_expectation *e, int at)
{
    if (e->has_lobe[at])
        return IBL_OK;
    if (!e->lobe)
        e->lobe = ibl_alloc_array(GRID + 1, sizeof *e->lobe);
    if (!e->lobe)
        return ibl_no_memory(e->ctx, "the fit of a ladder");
    e->has_lobe[at] = true;
    return fill_lobe(e->ctx, (double)at / GRID, e->lobe[at]);
}

/* Sets the roughnesses of the levels first.. last anew, and what depends on
 * them. */
static ibl_status set_levels(ladder *s, const int *at, int first, int last)
{
    ibl_status status = IBL_OK;
    for (int m = first; m <= last && !status; m++) {
        s->layout.roughness[m] = (double)at[m] / GRID;
        status = grid_lobe(s->e, at[m]);
        if (!status)
            make_level(s, m, s->e->lobe[at[m]]);
    }
    if (!status && last + 1 < s->layout.levels) /* its product with last */
        make_level(s, last + 1, s->e->lobe[at[last + 1]]);
    for (int m = first ? first - 1 : 0; m <= last && m < pairs_of(s); m++)
        make_costs(s, m);
    return status;
}

static bool is_rising(const int *at, int levels)
{
    if (at[0] < 0 || (at[0] > 0 && at[0] < LEAST) || at[levels - 1] > GRID)
        return false;
    for (int m = 1; m < levels; m++)
        if (at[m] < LEAST || at[m] <= at[m - 1])
            return false;
    return true;
}

/* Moves a level by a step if that lessens the error. */
static ibl_status try_step(ladder *s, int *at, int m, int step, double *error)
{
    ibl_status status = IBL_OK;
    for (int way = -1; way <= 1 && !status; way += 2) {
        const int was = at[m];
        at[m] += way * step;
        if (at[m] > 0 && at[m] < LEAST && way < 0)
            at[m] = 0;
        if (!is_rising(at, s->layout.levels)) {
            at[m] = was;
            continue;
        }
        status = set_levels(s, at, m, m);
        const double now = ladder_error(s);
        if (now < *error) {
            *error = now;
            continue;
        }
        at[m] = was;
        if (!status)
            status = set_levels(s, at, m, m);
    }
    return status;
}

/* From the sharpest roughness to the dullest in equal steps of r (2 - r). */
static void start_ladder(const ibl_expectation *e, int levels, int *at)
{
    const double low = e->node[0].roughness * 0.85;
    const double high = e->node[e->nodes - 1].roughness;
    const double first = low * (2 - low), range = high * (2 - high) - first;
    for (int m = 0; m < levels; m++) {
        const double x =
            first + range * (levels > 1 ? (double)m / (levels - 1) : 0.5);
        at[m] = (int)round(GRID * (1 - sqrt(fmax(1 - x, 0))));
        if (at[m] > 0 && at[m] < LEAST)
            at[m] = m ? LEAST : 0;
        if (m && at[m] <= at[m - 1])
            at[m] = at[m - 1] + 1 > LEAST ? at[m - 1] + 1 : LEAST;
    }
    for (int m = levels - 1, most = GRID; m >= 0 && at[m] > most; m--)
        at[m] = most--;
}

static ladder *new_ladder(const ibl_expectation *e, int size, int levels)
{
    ladder *s = ibl_alloc_zeroed(1, sizeof *s);
    if (!s)
        return NULL;
    s->e = (ibl_expectation *)e;
    s->layout = (ibl_specular_layout){.size = size,
                                      .levels = levels,
                                      .mapping = IBL_ROUGHNESS_BEST,
                                      .lod_scale = 1};
    return s;
}

ibl_status ibl_expectation_fit(ibl_expectation *e, int size, int levels,
                               ibl_specular_layout *layout, double *nrmse)
{
    int at[IBL_MAX_LEVELS];
    if (!e || !layout || !nrmse)
        return ibl_missing(e ? e->ctx : NULL,
                           "ibl_expectation_fit: layout or nrmse");
    if (size < 1 || size > IBL_MAX_CUBE_SIZE || levels < 1 ||
        levels > ibl_cube_most_levels(size))
        return ibl_fail(e->ctx, IBL_ERR_ARGUMENT,
                        "a ladder of %d levels from %d texels: there is none",
                        levels, size);
    ladder *s = new_ladder(e, size, levels);
    if (!s)
        return ibl_no_memory(e->ctx, "the fit of a ladder");
    start_ladder(e, levels, at);
    ibl_status status = set_levels(s, at, 0, levels - 1);
    double error = ladder_error(s);
    for (int step = 16; step > 0 && !status; step /= 2)
        for (int m = 0; m < levels && !status; m++)
            status = try_step(s, at, m, step, &error);
    *layout = s->layout;
    *nrmse = sqrt(error / e->total);
    ibl_free(s);
    return status;
}

/* ---- a set ----------------------------------------------------------------
 */

typedef struct judging {
    const ibl_expectation *e;
    const ibl_expected_set *set;
    ibl_lobe_kernels kernels;
    const ladder *ladder; /* NULL: lookups follow from the set */
    double sum[IBL_LOOKUP_COUNT][TARGETS];
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

static ibl_lookup_use use_of(const judging *j, int way, int job, int f,
                             ibl_lobe_bands *b)
{
    const ibl_expectation *e = j->e;
    const double r = e->node[job / VIEWS].roughness, n_v = e->at[job % VIEWS];
    ibl_lookup_use use = {.taps = 1, .at = {IBL_TO_R, IBL_TO_R}};
    if (!j->set->layout.levels) {
        use.weight = 1;
    } else if (way == IBL_LOOKUP_SPLIT) {
        use.lod = ibl_lod_of_roughness(&j->kernels.layout, r);
    } else if (j->set->lobes) {
        use =
            ibl_lookup_by_table(j->set->lobes, &j->kernels, f,
                                way == IBL_LOOKUP_TWO_TAPS ? 2 : 1, n_v, r, b);
    } else {
        const int i = 2 * job + f, m = best_pair(j->ladder, i);
        const double *best = j->ladder->best[m][i], own = 1 - best[1];
        use.at[0] = use.at[1] = BENT + f;
        use.lod = m + (own > 0 ? fmin(best[0] / own, 1) : 0);
        use.weight = best[1];
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
        ibl_lobe_bands_toward(n_v, known, &v->bands);
    else
        mirror_bands(n_v, &v->bands);
}

/* The last way to look up that is judged. */
static int last_way(const judging *j)
{
    return j->e->exact && j->set->lobes ? IBL_LOOKUP_COUNT - 1
                                        : (int)j->set->lookup;
}

static void judge_job(void *arg, int job, int worker)
{
    judging *j = arg;
    const ibl_expectation *e = j->e;
    const double r = e->node[job / VIEWS].roughness, n_v = e->at[job % VIEWS];
    const int first = (int)j->set->lookup, last = last_way(j);
    ibl_lookup_view v = e->view[job];
    ibl_lookup_use use[IBL_LOOKUP_COUNT][2];
    double apart[2] = {0, 0}, truth[2] = {1, 1}, own[2] = {1, 1};
    (void)worker;
    for (int i = 0; i < 2 * (last - first + 1); i++) {
        ibl_lookup_use *u = &use[first + i / 2][i % 2];
        *u = use_of(j, first + i / 2, job, i % 2, &v.bands);
        apart[i % 2] =
            v.bands.angle[u->at[0]] - v.bands.angle[u->at[u->taps - 1]];
    }
    add_directions(e, job, e->view[job].bands.directions, apart, &v);
    if (j->set->lut) {
        fetch_table(&e->truth, n_v, r, truth);
        fetch_table(j->set->lut, n_v, r, own);
    }
    for (int f = 0; f < 2; f++) {
        const target *t = &e->target[2 * job + f];
        const ibl_lookup_set set = {.diffuse = t->diffuse,
                                    .table = own[f] / truth[f],
                                    .irradiance = j->set->irradiance,
                                    .step = j->set->step,
                                    .slope = j->set->slope};
        for (int way = first; way <= last && t->weight > 0; way++)
            j->sum[way][2 * job + f] =
                t->weight * ibl_lookup_error(&j->kernels, &v, f, &use[way][f],
                                             e->exact ? NULL : &set);
    }
}

/* The best lookups of a chain without its table. */
static ibl_status find_lookups(const judging *j, ladder *s)
{
    double k[DEGREES];
    ibl_status status = IBL_OK;
    s->layout = j->set->layout;
    for (int m = 0; m < s->layout.levels && !status; m++) {
        status = fill_lobe(s->e->ctx, s->layout.roughness[m], k);
        if (!status)
            make_level(s, m, k);
    }
    for (int m = 0; m < pairs_of(s) && !status; m++)
        make_costs(s, m);
    return status;
}

/* Fills the sums of all targets. */
static ibl_status judge(judging *j)
{
    const ibl_expectation *e = j->e;
    const bool free = !j->set->lobes && j->set->lookup != IBL_LOOKUP_SPLIT;
    ladder *s = free ? new_ladder(e, 1, 1) : NULL;
    ibl_status status = IBL_OK;
    j->ladder = s;
    memset(j->sum, 0, sizeof j->sum);
    if (free && !s)
        status = ibl_no_memory(e->ctx, "the expected error");
    if (!status && s && j->set->layout.levels)
        status = find_lookups(j, s);
    if (!status)
        status = ibl_run(e->ctx, NULL, e->nodes * VIEWS, judge_job, j);
    ibl_free(s);
    return status;
}

static ibl_status check_set(ibl_ctx *ctx, const ibl_expected_set *set)
{
    const ibl_lobe_table_options o = {.size = 16, .layout = set->layout};
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
        sum += j.sum[set->lookup][i];
    if (!status)
        *nrmse = sqrt(sum / e->total);
    ibl_lobe_kernels_free(&j.kernels);
    return status;
}

/* ---- single roughnesses ---------------------------------------------------
 */

/* The power of targets and the errors of each way to look up, of the nodes. */
static void divide(const ibl_expectation *e, const double *sum, int way,
                   ibl_expected_error *errors)
{
    for (int n = 0; n < e->nodes; n++)
        for (int f = 0; f < 2; f++) {
            double power = 0, error = 0;
            for (int v = n * VIEWS; v < (n + 1) * VIEWS; v++) {
                power += e->target[2 * v + f].weight *
                         ibl_lookup_power(&e->kernels, &e->view[v], f, 0);
                error += sum[2 * v + f];
            }
            errors[n].nrmse[f][way] = power > 0 ? sqrt(error / power) : 0;
        }
}

static ibl_status make_views(ibl_expectation *e)
{
    if (!e->view)
        e->view = ibl_alloc_array((size_t)e->nodes * VIEWS, sizeof *e->view);
    if (!e->view)
        return ibl_no_memory(e->ctx, "the expected error");
    ibl_gauss_points(VIEWS, e->at, e->weight);
    ibl_bands_rule_init(&e->rule);
    return ibl_run(e->ctx, NULL, e->nodes * VIEWS, view_job, e);
}

static ibl_status judge_nodes(ibl_expectation *e, judging *j,
                              ibl_expected_error *errors)
{
    ibl_status status = make_views(e);
    if (!status)
        status = judge(j);
    for (int way = 0; way < IBL_LOOKUP_COUNT && !status; way++) {
        if (way <= last_way(j))
            divide(e, j->sum[way], way, errors);
        for (int n = 0; n < e->nodes && way > last_way(j); n++)
            errors[n].nrmse[0][way] = errors[n].nrmse[1][way] = -1;
    }
    return status;
}

static ibl_status check_roughness(ibl_ctx *ctx, const double *roughness,
                                  int count)
{
    if (count < 1 || count > MOST_ROUGHNESSES)
        return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                        "the error at %d roughnesses: must be 1 to %d", count,
                        MOST_ROUGHNESSES);
    for (int i = 0; i < count; i++)
        if (!(roughness[i] >= IBL_EXPECTED_LEAST && roughness[i] <= 1))
            return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                            "the error at roughness %g: must be %g to 1",
                            roughness[i], IBL_EXPECTED_LEAST);
    return IBL_OK;
}

static ibl_status judge_all(ibl_expectation *e, judging *j,
                            const double *roughness, int count,
                            ibl_expected_error *errors)
{
    ibl_status status =
        ibl_lobe_kernels_make(e->ctx, &none, e->given, e->degree, &e->kernels);
    if (!status)
        status = ibl_lobe_kernels_make(e->ctx, &j->set->layout, e->given,
                                       e->degree, &j->kernels);
    for (int i = 0; i < count && !status; i += NODES) {
        e->nodes = count - i < NODES ? count - i : NODES;
        for (int n = 0; n < e->nodes; n++)
            e->node[n] = (node){roughness[i + n], {1, 1}, {0, 0}};
        status = judge_nodes(e, j, &errors[i]);
    }
    ibl_lobe_kernels_free(&j->kernels);
    return status;
}

ibl_status ibl_bake_expected_error(ibl_ctx *ctx,
                                   const ibl_lobe_table_options *opts,
                                   const ibl_lobe_table *table,
                                   const double *roughness, int count,
                                   ibl_expected_error *errors)
{
    const ibl_lobe_table_options defaults = ibl_lobe_table_options_default();
    if (!ctx || !roughness || !errors || (table && !table->data))
        return ibl_missing(ctx, "ibl_bake_expected_error: table's data, "
                                "roughness or errors");
    if (!opts)
        opts = &defaults;
    ibl_status status = check_roughness(ctx, roughness, count);
    if (!status)
        status = ibl_lobe_table_check(ctx, opts);
    if (status)
        return status;
    ibl_expectation *e = ibl_alloc_zeroed(1, sizeof *e);
    if (!e)
        return ibl_no_memory(ctx, "the expected error");
    const ibl_expected_set set = {
        .layout = opts->layout, .lobes = table, .lookup = IBL_LOOKUP_SPLIT};
    judging j = {.e = e, .set = &set};
    e->ctx = ctx;
    e->exact = true;
    e->given = opts->power;
    e->degree = opts->power_degree;
    status = judge_all(e, &j, roughness, count, errors);
    e->given = NULL; /* the caller's */
    ibl_expectation_free(e);
    return status;
}

/* ---- the call -------------------------------------------------------------
 */

static ibl_status make(ibl_expectation *e)
{
    const ibl_lut_options lut = {.size = TABLE};
    ibl_status status =
        ibl_lobe_kernels_make(e->ctx, &none, e->given, e->degree, &e->kernels);
    if (!status)
        status = ibl_bake_lut(e->ctx, &lut, &e->truth);
    if (status)
        return status;
    status = make_views(e);
    for (int i = 0; i < 2 * e->nodes * VIEWS; i++) {
        const target *t = &e->target[i];
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
