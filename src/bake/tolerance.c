/* SPDX-License-Identifier: MIT */
/*
 * The error of a level is not told by its samples alone: what their number
 * leaves falls with it, what the footprint of the lookups and the source's
 * pixels leave does not. So it is measured, not extrapolated: at some texels,
 * against the sum over the source that the level stands for (bake/tree.h).
 *
 * Those texels are drawn at random, one for each of equal cells of the faces,
 * so of their errors a number that is at most binomial with 0.05 lies above
 * the level's 95th percentile. The error that is taken is the largest of which
 * that leaves less than one chance in a hundred of being too small. Where every
 * texel of a small level is looked at, the same rank is for those who look at
 * some of them and should not find more.
 */
#include "bake/tolerance.h"

#include <float.h>
#include <math.h>
#include <stdint.h>
#include <stdlib.h>

#include "bake/filter.h"
#include "bake/tree.h"
#include "brdf/lobe.h"
#include "core/alloc.h"
#include "core/context.h"

enum {
    CELLS = 6,     /* along the edge of a face */
    ALL_BELOW = 8, /* every texel of levels up to this edge */
    MAX_PILOTS = IBL_FACES * ALL_BELOW * ALL_BELOW,
    FIRST_SAMPLES = 8,
    PILOTS_PER_JOB = 8
};

/* Errors that are as good as the least. */
static const double AS_NEAR = 1.1;

/* The texels of a level that are looked at. */
typedef struct pilots {
    int level, edge, count;
    int texels[MAX_PILOTS];
    double want[MAX_PILOTS][3];
} pilots;

/* What was settled on, with one cube for lookups. */
typedef struct choice {
    ibl_specular_level level[IBL_MAX_LEVELS];
    int missed;  /* levels above the tolerance */
    double cost; /* of their lookups */
    ibl_pyramid pyramid;
} choice;

typedef struct trial {
    const ibl_specular_bake *b;
    ibl_tree *tree;
    pilots *levels; /* [IBL_MAX_LEVELS] */
    double mean[3];
    double accuracy; /* of what the tree says */
    /* The level at work. */
    pilots *at;
    ibl_lobe_shape lobe;
    float got[3 * MAX_PILOTS];
    double errors[MAX_PILOTS];
} trial;

/* ---- relative error ---------------------------------------------------- */

static double length(const double v[3])
{
    return sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
}

double ibl_relative_error(const double rgb[3], const double truth[3],
                          const double mean[3])
{
    const double d[3] = {rgb[0] - truth[0], rgb[1] - truth[1],
                         rgb[2] - truth[2]};
    const double floor = IBL_RELATIVE_FLOOR * length(mean);
    const double scale = fmax(length(truth), floor);
    /* So that a black map has finite errors. */
    return length(d) / fmax(scale, (double)FLT_MIN);
}

/* ---- pilots ------------------------------------------------------------ */

/* 0..1, splitmix64. */
static double unit(uint64_t *state)
{
    uint64_t z = *state += 0x9E3779B97F4A7C15u;
    z = (z ^ z >> 30) * 0xBF58476D1CE4E5B9u;
    z = (z ^ z >> 27) * 0x94D049BB133111EBu;
    return 0x1p-53 * (double)((z ^ z >> 31) >> 11);
}

/* A point in each cell, wherever the texels' edges run: each texel has the
 * same chance. */
static void place_pilots(pilots *p)
{
    const int n = p->edge, cells = n <= ALL_BELOW ? n : CELLS;
    uint64_t state = (uint64_t)p->level;
    p->count = IBL_FACES * cells * cells;
    for (int i = 0; i < p->count; i++) {
        int x = i % cells, y = i / cells % cells;
        const int face = i / (cells * cells);
        if (cells < n) {
            x = (int)((x + unit(&state)) * n / cells);
            y = (int)((y + unit(&state)) * n / cells);
        }
        p->texels[i] = (face * n + y) * n + x;
    }
}

static void truth_job(void *arg, int job, int worker)
{
    trial *t = arg;
    pilots *p = t->at;
    const int n = p->edge, begin = PILOTS_PER_JOB * job;
    (void)worker;
    for (int i = begin; i < begin + PILOTS_PER_JOB && i < p->count; i++) {
        const int texel = p->texels[i];
        double dir[3];
        ibl_cube_direction(n, texel / (n * n), texel % n, texel / n % n, dir);
        ibl_tree_specular(t->tree, &t->lobe, dir, t->accuracy, p->want[i]);
    }
}

static ibl_status find_truth(trial *t, int level)
{
    const double r = t->b->layout.roughness[level];
    t->at = &t->levels[level];
    t->at->level = level;
    t->at->edge = ibl_cube_edge(t->b->layout.size, level);
    t->lobe = ibl_lobe_shape_of(t->b->opts->lobe, r * r);
    place_pilots(t->at);
    return ibl_run(t->b->ctx, NULL,
                   (t->at->count + PILOTS_PER_JOB - 1) / PILOTS_PER_JOB,
                   truth_job, t);
}

/* ---- the estimate ------------------------------------------------------ */

int ibl_tolerance_rank(int count)
{
    static const double above = 0.05, chance = 0.01;
    /* Probability that `rank` of them are above, and that no more are. */
    double exactly = pow(1 - above, count), at_most = exactly;
    int rank = 0;
    while (at_most <= chance && rank < count) {
        rank++;
        exactly *= (double)(count - rank + 1) / rank * above / (1 - above);
        at_most += exactly;
    }
    return rank > 0 ? rank - 1 : 0;
}

static int falling(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return x < y ? 1 : x > y ? -1 : 0;
}

static ibl_status try_samples(trial *t, const ibl_pyramid *pyramid, int samples,
                              double *error)
{
    const ibl_specular_bake *b = t->b;
    const pilots *p = t->at;
    ibl_samples set;
    ibl_status status =
        ibl_specular_samples(b, pyramid, p->level, samples, &set);
    if (status)
        return status;
    status = ibl_filter_texels(b->ctx, pyramid, &set, b->opts->jitter, p->level,
                               p->edge, p->texels, p->count, t->got);
    ibl_samples_free(&set);
    if (status)
        return status;
    for (int i = 0; i < p->count; i++) {
        const float *f = t->got + 3 * i;
        const double got[3] = {(double)f[0], (double)f[1], (double)f[2]};
        t->errors[i] = ibl_relative_error(got, p->want[i], t->mean);
    }
    qsort(t->errors, (size_t)p->count, sizeof *t->errors, falling);
    /* What the tree leaves may hide as much of the error. */
    *error = t->errors[ibl_tolerance_rank(p->count)] + t->accuracy;
    return IBL_OK;
}

/* ---- choosing ---------------------------------------------------------- */

static ibl_status consider(trial *t, const ibl_pyramid *pyramid, int samples,
                           ibl_specular_level *level)
{
    double error = INFINITY;
    const ibl_status status = try_samples(t, pyramid, samples, &error);
    /* Beyond the largest floats nothing is known. */
    *level = (ibl_specular_level){.samples = samples,
                                  .error = error < INFINITY ? error : INFINITY};
    return status;
}

/* The count of the level's own, or a power of two from FIRST_SAMPLES on: the
 * first that suffices. If none does, the first that comes about as near as any:
 * what more samples do not change they are not spent on. */
static ibl_status try_powers(trial *t, const ibl_pyramid *pyramid,
                             ibl_specular_level *best)
{
    const ibl_specular_options *o = t->b->opts;
    const int own = o->level_samples[t->at->level];
    const int most = own ? own : o->samples;
    ibl_specular_level tries[32];
    int count = 0, samples = own || most < FIRST_SAMPLES ? most : FIRST_SAMPLES;
    double least = INFINITY;
    for (;;) {
        ibl_specular_level *now = &tries[count++];
        const ibl_status status = consider(t, pyramid, samples, now);
        if (status)
            return status;
        *best = *now;
        least = fmin(least, now->error);
        if (now->error <= o->tolerance)
            return IBL_OK;
        if (samples == most)
            break;
        samples = samples > most / 2 ? most : 2 * samples;
    }
    for (int i = count - 1; i >= 0; i--)
        if (!(tries[i].error > AS_NEAR * least))
            *best = tries[i];
    return IBL_OK;
}

static ibl_status choose_samples(trial *t, const ibl_pyramid *pyramid,
                                 ibl_specular_level *best)
{
    const ibl_specular_options *o = t->b->opts;
    ibl_specular_level less;
    ibl_status status = try_powers(t, pyramid, best);
    if (status || best->error > o->tolerance ||
        best->samples <= FIRST_SAMPLES || o->level_samples[t->at->level])
        return status;
    status = consider(t, pyramid, best->samples / 4 * 3, &less);
    if (!status && less.error <= o->tolerance)
        *best = less;
    return status;
}

/* With the pyramid that c has. */
static ibl_status choose_levels(trial *t, choice *c)
{
    const ibl_specular_layout *layout = &t->b->layout;
    ibl_status status = IBL_OK;
    c->missed = 0;
    c->cost = 0;
    for (int l = 0; l < layout->levels && !status; l++) {
        const double n = ibl_cube_edge(layout->size, l);
        c->level[l] = (ibl_specular_level){.error = -1};
        if (!t->b->sampled[l])
            continue;
        t->at = &t->levels[l];
        status = choose_samples(t, &c->pyramid, &c->level[l]);
        c->missed += c->level[l].error > t->b->opts->tolerance;
        c->cost += IBL_FACES * n * n * c->level[l].samples;
    }
    return status;
}

/* The smallest cube that is worth having, or level 0 if that is no loss. */
static int first_edge(const ibl_specular_bake *b)
{
    const int limit = ibl_lookup_limit(b->env);
    const int cheap =
        limit < IBL_LOOKUP_CHEAP_EDGE ? limit : IBL_LOOKUP_CHEAP_EDGE;
    if (ibl_lookup_has_level0(b) && b->layout.size >= cheap &&
        b->layout.size <= 4 * cheap)
        return b->layout.size;
    return cheap;
}

/* Whether c is better for the time that its cube took. */
static bool is_better(const choice *c, const choice *than)
{
    if (c->missed != than->missed)
        return c->missed < than->missed;
    return c->cost < than->cost;
}

/* Doubles the edge of the cube as long as a level is above the tolerance or
 * lookups could be saved that are worth the cube. */
static ibl_status choose(trial *t, choice *best)
{
    const ibl_specular_bake *b = t->b;
    const int limit = ibl_lookup_limit(b->env);
    int edge = first_edge(b);
    ibl_status status = ibl_lookup_make(b, edge, &best->pyramid);
    if (!status)
        status = choose_levels(t, best);
    for (edge *= 2; edge <= limit && !status; edge *= 2) {
        choice next = {0};
        if (!best->missed && best->cost < 2 * ibl_lookup_cost(edge))
            break;
        status = ibl_lookup_make(b, edge, &next.pyramid);
        if (!status)
            status = choose_levels(t, &next);
        if (status || !is_better(&next, best)) {
            ibl_pyramid_free(&next.pyramid);
            break;
        }
        ibl_pyramid_free(&best->pyramid);
        *best = next;
    }
    return status;
}

static void tell(const ibl_specular_bake *b, const choice *c)
{
    const ibl_specular_options *o = b->opts;
    for (int l = 0; l < b->layout.levels; l++) {
        const ibl_specular_level *level = &c->level[l];
        if (level->error > o->tolerance && o->level_samples[l])
            ibl_warn(b->ctx,
                     "specular level %d: %d samples leave an estimated error "
                     "of %.2g, above the tolerance of %g: leave the choice to "
                     "the tolerance",
                     l, level->samples, level->error, o->tolerance);
        else if (level->error > o->tolerance)
            ibl_warn(b->ctx,
                     "specular level %d: a tolerance of %g is not reached with "
                     "up to %d samples: %d leave an estimated error of %.2g: "
                     "allow more samples or a larger error",
                     l, o->tolerance, o->samples, level->samples, level->error);
        else if (level->error >= 0)
            ibl_info(b->ctx,
                     "specular level %d: %d samples, estimated error %.2g", l,
                     level->samples, level->error);
    }
}

static ibl_status find_truths(trial *t)
{
    const ibl_specular_bake *b = t->b;
    ibl_status status =
        ibl_tree_create(b->ctx, b->env, b->opts->yaw_deg, &t->tree);
    if (status)
        return status;
    ibl_tree_mean(t->tree, t->mean);
    for (int l = 0; l < b->layout.levels && !status; l++) {
        if (b->sampled[l])
            status = find_truth(t, l);
        ibl_progress(b->ctx, "estimate", 0.5 * (l + 1) / b->layout.levels);
    }
    return status;
}

ibl_status ibl_tolerance_choose(ibl_specular_bake *b,
                                ibl_specular_level levels[IBL_MAX_LEVELS])
{
    ibl_status status = IBL_OK;
    choice best = {0};
    trial *t = ibl_alloc_zeroed(1, sizeof *t);
    if (t)
        t->levels = ibl_alloc_zeroed(IBL_MAX_LEVELS, sizeof *t->levels);
    if (!t || !t->levels) {
        ibl_free(t);
        return ibl_no_memory(b->ctx, "the estimate of the error");
    }
    t->b = b;
    t->accuracy = fmin(b->opts->tolerance / 20, 5e-3);
    ibl_progress(b->ctx, "estimate", 0);
    status = find_truths(t);
    if (!status)
        status = choose(t, &best);
    ibl_tree_free(t->tree);
    ibl_free(t->levels);
    ibl_free(t);
    if (status) {
        ibl_pyramid_free(&best.pyramid);
        return status;
    }
    ibl_progress(b->ctx, "estimate", 1);
    tell(b, &best);
    b->pyramid = best.pyramid;
    for (int l = 0; l < IBL_MAX_LEVELS; l++)
        if (b->sampled[l])
            levels[l] = best.level[l];
    return IBL_OK;
}
