/* SPDX-License-Identifier: MIT */
/* The lookups of least error in a chain, of each target, and the ladder whose
 * lookups have the least. */
#include <math.h>

#include "bake/expectation.h"
#include "bake/lobe_fit.h"
#include "bake/spectral/lobe_coefficients.h"
#include "core/alloc.h"
#include "core/context.h"
#include "image/cube.h"

enum {
    VIEWS = IBL_EXPECTED_VIEWS,
    NODES = IBL_EXPECTED_NODES,
    TARGETS = IBL_EXPECTED_TARGETS,
    DEGREES = IBL_EXPECTED_DEGREES,
    GRID = IBL_EXPECTED_GRID,
    LEAST = 7 /* of the grid above 0 */
};

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

typedef struct ibl_best_lookups {
    ibl_expectation *e;
    ibl_specular_layout layout;
    level level[IBL_MAX_LEVELS];
    double cost[IBL_MAX_LEVELS][TARGETS];    /* between a level and the next */
    double best[IBL_MAX_LEVELS][TARGETS][2]; /* ibl_lobe_least's at */
} ladder;

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
    const ibl_expected_target *t = &s->e->target[i];
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
        const ibl_expected_target *t = &e->target[i];
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
    return ibl_lobe_ggx(e->ctx, (double)at / GRID, e->lobe[at]);
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

/* ---- lookups --------------------------------------------------------------
 */

ibl_status ibl_best_lookups_of(const ibl_expectation *e,
                               const ibl_specular_layout *layout,
                               ibl_best_lookups **out)
{
    ladder *s = *out = new_ladder(e, 1, 1);
    double k[DEGREES];
    ibl_status status = IBL_OK;
    if (!s)
        return ibl_no_memory(e->ctx, "the expected error");
    s->layout = *layout;
    for (int m = 0; m < s->layout.levels && !status; m++) {
        status = ibl_lobe_ggx(s->e->ctx, s->layout.roughness[m], k);
        if (!status)
            make_level(s, m, k);
    }
    for (int m = 0; m < pairs_of(s) && !status; m++)
        make_costs(s, m);
    return status;
}

void ibl_best_lookup(const ibl_best_lookups *s, int target, double *lod,
                     double *weight)
{
    const int m = best_pair(s, target);
    const double *best = s->best[m][target], own = 1 - best[1];
    *lod = m + (own > 0 ? fmin(best[0] / own, 1) : 0);
    *weight = best[1];
}
