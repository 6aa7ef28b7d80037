/* SPDX-License-Identifier: MIT */
/*
 * A block is tried with one line of colours between any ends and, where that is
 * too far off, with two whose ends differ in brightness only. Each try puts the
 * texels on a line by least squares; what it decodes to decides.
 */
#include <math.h>
#include <string.h>

#include "core/half.h"
#include "kern/astc_hdr_block.h"
#include "kern/astc_line.h"

/* What is tried: rounds of fitting a line, ways of one subset and of two, with
 * how many patterns of two. Two subsets only where the error, rms of a texel,
 * is more than `far`: files compress better if most blocks are stored alike. */
typedef struct plan {
    int rounds, patterns, two;
    float far;
} plan;
static const plan plans[] = {[IBL_QUALITY_FAST] = {1, 0, 0, .05f},
                             [IBL_QUALITY_NORMAL] = {1, 1, 2, .03f},
                             [IBL_QUALITY_BEST] = {2, 6, 3, 0}};

/* A block as it is stored. way < 0: one colour. */
typedef struct trial {
    int way, pattern;
    ibl_astc_line lines[2];
    float error;
} trial;

/* One colour is enough if it is nearly as good as halves are. */
#define AS_HALVES 1e-9f

/* ---- ways -------------------------------------------------------------- */

static int is_far(const plan *p, const trial *best)
{
    return best->error > IBL_BLOCK_TEXELS * p->far * p->far;
}

/* A way of one subset. */
static void try_one(const ibl_astc_tables *tb, const plan *p,
                    const ibl_astc_texels *t, int way, trial *best)
{
    const ibl_astc_way *w = &ibl_astc_ways[way];
    float ends[2][3];
    ibl_astc_line l;

    ibl_astc_find_line(tb, t, w->mode, ends);
    ibl_astc_fit_line(tb, t, w, p->rounds, ends, &l);
    if (l.error < best->error)
        *best = (trial){way, 0, {l}, l.error};
}

/* Ways of two subsets, of a pattern. */
static void try_two(const ibl_astc_tables *tb, const plan *p,
                    const ibl_astc_texels *t, int pattern, trial *best)
{
    ibl_astc_texels part[2];
    float ends[2][2][3];

    for (int s = 0; s < 2; s++) {
        ibl_astc_take(tb, t, pattern, s, &part[s]);
        ibl_astc_find_line(tb, &part[s], IBL_ASTC_SCALE, ends[s]);
    }
    for (int k = IBL_ASTC_SCALE_2; k < IBL_ASTC_SCALE_2 + p->two; k++) {
        const ibl_astc_way *w = &ibl_astc_ways[k];
        ibl_astc_line l[2];
        float error = 0;
        for (int s = 0; s < 2 && error < best->error; s++) {
            ibl_astc_fit_line(tb, &part[s], w, p->rounds, ends[s], &l[s]);
            error += l[s].error;
        }
        if (error < best->error)
            error = ibl_astc_both(
                error, ibl_astc_error_as_bc6h(tb, w, pattern, part, l));
        if (error < best->error) {
            best->error = error;
            best->way = k;
            best->pattern = pattern;
            memcpy(best->lines, l, sizeof l);
        }
    }
}

/* What counts of the way along grey, which each subset has as its line: by the
 * distance of 8 levels. */
#define ALONG .14f

/* Points whose distances are errors, nearly. */
static void set_points(const ibl_astc_texels *t, float points[3][16])
{
    float g[3], length = 0x1p-100f;

    for (int c = 0; c < 3; c++) {
        float sum = 0;
        for (int i = 0; i < IBL_BLOCK_TEXELS; i++)
            sum += t->weight[c][i];
        g[c] = sqrtf(sum);
        length += sum;
    }
    for (int i = 0; i < IBL_BLOCK_TEXELS; i++) {
        float along = 0;
        for (int c = 0; c < 3; c++)
            along += t->q[c][i] * g[c] * g[c];
        for (int c = 0; c < 3; c++)
            points[c][i] =
                t->q[c][i] * g[c] - (1 - ALONG) * along * g[c] / length;
    }
}

/* The patterns that tell the texels apart best, in order. */
static void rank_patterns(const ibl_astc_tables *tb, const ibl_astc_texels *t,
                          int n, int *found)
{
    float points[3][16], gain[IBL_ASTC_PATTERNS_PADDED];

    set_points(t, points);
    tb->fit->split(points, tb->second, tb->count, gain);
    for (int k = 0; k < n; k++) {
        int best = 0;
        for (int p = 1; p < IBL_ASTC_PATTERNS; p++)
            if (gain[p] > gain[best])
                best = p;
        found[k] = best;
        gain[best] = -1;
    }
}

/* The best colour for all, as halves. */
static void try_flat(const ibl_astc_texels *t, uint16_t colour[3], trial *best)
{
    float error = 0, weight = 0;

    for (int i = 0; i < IBL_BLOCK_TEXELS; i++)
        weight += t->share[i];
    for (int c = 0; c < 3; c++) {
        float sum = 0;
        for (int i = 0; i < IBL_BLOCK_TEXELS; i++)
            sum += t->share[i] / weight * t->light[c][i];
        colour[c] = ibl_half_from_float(sum);
        for (int i = 0; i < IBL_BLOCK_TEXELS; i++) {
            const float d = ibl_half_to_float(colour[c]) - t->light[c][i];
            error += d * d * t->share[i];
        }
    }
    best->way = -1;
    best->error = error;
}

/* ---- blocks ------------------------------------------------------------ */

static void write_flat(const uint16_t colour[3], unsigned char *block)
{
    ibl_bits128 bits = {IBL_ASTC_ONE_COLOUR, 0};
    for (int c = 0; c < 3; c++)
        ibl_bits128_put(&bits, 64 + 16 * c, 16, colour[c]);
    ibl_bits128_put(&bits, 112, 16, 0x3C00);
    ibl_bits128_store(bits, block);
}

static void write_block(const ibl_astc_tables *tb, const trial *b,
                        unsigned char *block)
{
    const ibl_astc_way *w = &ibl_astc_ways[b->way];
    const int each = w->mode == IBL_ASTC_SCALE ? 4 : 6;
    ibl_astc_block a = {.subsets = w->subsets,
                        .pattern = ibl_astc_patterns[b->pattern],
                        .mode = w->mode,
                        .values = each * w->subsets,
                        .value_range = w->value_range,
                        .weight_range = w->weight_range};

    for (int i = 0; i < a.values; i++) {
        const int v = b->lines[i / each].values[i % each];
        a.value[i] = (unsigned char)tb->codes[w->value_range].of[v];
    }
    for (int i = 0; i < IBL_BLOCK_TEXELS; i++) {
        const int s = w->subsets == 2 && tb->second[i][b->pattern] > 0;
        a.weight[i] = tb->levels[w->weight_range].code[b->lines[s].level[i]];
    }
    ibl_bits128_store(ibl_astc_pack(&a), block);
}

static void try_ways(const ibl_astc_tables *tb, const plan *p,
                     const ibl_astc_texels *t, trial *best)
{
    int found[IBL_ASTC_PATTERNS];

    try_one(tb, p, t, IBL_ASTC_DIRECT_1, best);
    /* The 192 values of its ends leave out some that a sun may want. */
    if (is_far(p, best))
        try_one(tb, p, t, IBL_ASTC_DIRECT_1 + 1, best);
    if (!p->patterns || !is_far(p, best))
        return;
    rank_patterns(tb, t, p->patterns, found);
    for (int k = 0; k < p->patterns; k++)
        try_two(tb, p, t, found[k], best);
}

/* ---- blocks alike ------------------------------------------------------ */

/* The way of blocks alike, whose weights are bytes of their own. */
#define ALIKE IBL_ASTC_DIRECT_1

enum {
    NEAREST = 3 /* of earlier blocks, are tried */
};

/* The part that the last block has in the share of those alike. */
#define LAST (1.0f / 64)

static int has_bytes_of_weights(const trial *b)
{
    return b->way >= 0 && ibl_astc_ways[b->way].subsets == 1 &&
           ibl_astc_ways[b->way].weight_range ==
               ibl_astc_ways[ALIKE].weight_range;
}

static void remember(const ibl_astc_tables *tb, const ibl_astc_line *l,
                     ibl_astc_past *past)
{
    const unsigned char *step = tb->levels[IBL_ISE_16].step;

    for (int i = 0; i < IBL_BLOCK_TEXELS; i++)
        past->places[i][past->next] = (float)step[l->level[i]] * (1.0f / 64);
    memcpy(past->level[past->next++], l->level, IBL_BLOCK_TEXELS);
    if (past->count < past->next)
        past->count = past->next;
    past->next %= IBL_ASTC_PAST;
}

/* The weighted squares of the distances from the mean. */
static float spread_of(const ibl_astc_texels *t)
{
    float sum = 0;

    for (int c = 0; c < 3; c++) {
        float x[IBL_BLOCK_TEXELS];
        ibl_astc_centre(t, c, x);
        for (int i = 0; i < IBL_BLOCK_TEXELS; i++)
            sum += x[i] * t->q[c][i]; /* the sum of x is 0 */
    }
    return sum;
}

/* The best line with levels of an earlier block, if its error is less than
 * line->error. What the gain leaves is less than the error as stored. */
static void try_past(const ibl_astc_tables *tb, const ibl_astc_texels *t,
                     const ibl_astc_past *past, ibl_astc_line *line)
{
    const float spread = spread_of(t);
    float gain[IBL_ASTC_PAST];

    tb->fit->match(t, past->places, past->count, gain);
    for (int n = 0; n < NEAREST && n < past->count; n++) {
        int best = 0;
        for (int i = 1; i < past->count; i++)
            best = gain[i] > gain[best] ? i : best;
        if (spread - gain[best] >= line->error)
            return;
        gain[best] = -1;
        ibl_astc_fit_levels(tb, t, &ibl_astc_ways[ALIKE], past->level[best],
                            line);
    }
}

/* Takes a block that is alike an earlier one if it is good enough. */
static void try_alike(const ibl_astc_tables *tb, const ibl_astc_texels *t,
                      ibl_astc_past *past, trial *best)
{
    const float wanted = 1 - past->alike / IBL_ASTC_ALIKE;
    const float most =
        best->error * (1 + IBL_ASTC_ALIKE_LOSS * (wanted > 0 ? wanted : 0));
    ibl_astc_line line = {.error = most};

    try_past(tb, t, past, &line);
    const int taken = line.error < most;
    past->alike += ((float)taken - past->alike) * LAST;
    if (taken)
        *best = (trial){ALIKE, 0, {line}, line.error};
    else if (has_bytes_of_weights(best))
        remember(tb, &best->lines[0], past);
}

void ibl_astc_hdr_encode(const ibl_astc_fit_dsp *fit, const float *texels,
                         size_t count, ibl_quality quality, ibl_astc_past *past,
                         unsigned char *blocks)
{
    ibl_astc_tables tables;

    ibl_astc_set_tables(fit, &tables);
    for (size_t i = 0; i < count; i++) {
        ibl_astc_texels t;
        trial best = {0};
        uint16_t colour[3];
        ibl_astc_load(texels + 3 * IBL_BLOCK_TEXELS * i, &t);
        try_flat(&t, colour, &best);
        if (best.error > AS_HALVES)
            try_ways(&tables, &plans[quality], &t, &best);
        if (past && best.way >= 0)
            try_alike(&tables, &t, past, &best);
        if (best.way < 0)
            write_flat(colour, blocks + IBL_BLOCK_BYTES * i);
        else
            write_block(&tables, &best, blocks + IBL_BLOCK_BYTES * i);
    }
}
