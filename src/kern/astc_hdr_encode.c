/* SPDX-License-Identifier: MIT */
/*
 * A block is tried in several of the 24 ways that UASTC HDR allows: with one
 * line of colours or two, between ends of one mode or the other. Each try puts
 * the texels on a line by least squares, and goes on in turns: where they are
 * on it gives the best ends, ends give where texels are. What it decodes to
 * decides.
 */
#include <float.h>
#include <math.h>
#include <string.h>

#include "core/half.h"
#include "kern/astc_fit.h"
#include "kern/astc_hdr_block.h"
#include "kern/astc_hdr_endpoints.h"
#include "kern/astc_quantise.h"

/* What UASTC HDR allows besides blocks of one colour. */
typedef struct way {
    unsigned char subsets, mode, weight_range, value_range;
} way;
static const way ways[] = {{1, IBL_ASTC_DIRECT, IBL_ISE_16, IBL_ISE_192},
                           {1, IBL_ASTC_DIRECT, IBL_ISE_12, IBL_ISE_256},
                           {1, IBL_ASTC_DIRECT, IBL_ISE_10, IBL_ISE_256},
                           {1, IBL_ASTC_DIRECT, IBL_ISE_8, IBL_ISE_256},
                           {1, IBL_ASTC_DIRECT, IBL_ISE_6, IBL_ISE_256},
                           {1, IBL_ASTC_DIRECT, IBL_ISE_5, IBL_ISE_256},
                           {1, IBL_ASTC_DIRECT, IBL_ISE_4, IBL_ISE_256},
                           {1, IBL_ASTC_DIRECT, IBL_ISE_3, IBL_ISE_256},
                           {1, IBL_ASTC_SCALE, IBL_ISE_16, IBL_ISE_256},
                           {1, IBL_ASTC_SCALE, IBL_ISE_12, IBL_ISE_256},
                           {1, IBL_ASTC_SCALE, IBL_ISE_10, IBL_ISE_256},
                           {1, IBL_ASTC_SCALE, IBL_ISE_8, IBL_ISE_256},
                           {1, IBL_ASTC_SCALE, IBL_ISE_6, IBL_ISE_256},
                           {1, IBL_ASTC_SCALE, IBL_ISE_5, IBL_ISE_256},
                           {1, IBL_ASTC_SCALE, IBL_ISE_4, IBL_ISE_256},
                           {1, IBL_ASTC_SCALE, IBL_ISE_3, IBL_ISE_256},
                           {2, IBL_ASTC_SCALE, IBL_ISE_8, IBL_ISE_80},
                           {2, IBL_ASTC_SCALE, IBL_ISE_6, IBL_ISE_128},
                           {2, IBL_ASTC_SCALE, IBL_ISE_5, IBL_ISE_192},
                           {2, IBL_ASTC_SCALE, IBL_ISE_4, IBL_ISE_256},
                           {2, IBL_ASTC_SCALE, IBL_ISE_3, IBL_ISE_256},
                           {2, IBL_ASTC_DIRECT, IBL_ISE_4, IBL_ISE_40},
                           {2, IBL_ASTC_DIRECT, IBL_ISE_3, IBL_ISE_64}};
enum {
    WAYS = sizeof ways / sizeof *ways
};

/* The patterns of two subsets that BC6H has, too. */
static const unsigned short patterns[IBL_ASTC_PATTERNS] = {
    28, 20, 16,  29,  91, 9,   107, 72,  149, 204, 50,  114, 496, 17,
    78, 39, 252, 828, 43, 156, 116, 210, 476, 273, 684, 359, 246};

/* What is the same for all blocks. */
typedef struct tables {
    const ibl_astc_fit_dsp *fit;
    ibl_quality quality;
    ibl_astc_levels levels[IBL_ISE_16 + 1];
    ibl_astc_codes codes[IBL_ISE_RANGES];
    float second[16][IBL_ASTC_PATTERNS_PADDED];
    float count[IBL_ASTC_PATTERNS_PADDED];
} tables;

/* A subset's line as it is stored, and what it leaves. */
typedef struct line {
    float error;
    unsigned char values[6];
    unsigned char level[16];
} line;

/* A block as it is stored. way < 0: one colour. */
typedef struct trial {
    int way, pattern;
    line lines[2];
    float error;
} trial;

/* ---- tables ------------------------------------------------------------ */

static void set_levels(int range, ibl_astc_levels *l)
{
    l->count = ibl_ise_levels(range);
    for (int i = 0; i < l->count; i++) {
        const int step = ibl_ise_weight(range, i);
        int k = i;
        for (; k > 0 && l->step[k - 1] > step; k--) {
            l->step[k] = l->step[k - 1];
            l->code[k] = l->code[k - 1];
        }
        l->step[k] = (unsigned char)step;
        l->code[k] = (unsigned char)i;
    }
}

static void set_patterns(tables *t)
{
    for (int p = 0; p < IBL_ASTC_PATTERNS_PADDED; p++) {
        const int pattern = patterns[p < IBL_ASTC_PATTERNS ? p : 0];
        t->count[p] = 0;
        for (int i = 0; i < 16; i++) {
            const int s = ibl_astc_subset(pattern, 2, i % 4, i / 4);
            t->second[i][p] = (float)s;
            t->count[p] += (float)s;
        }
    }
}

static void set_tables(tables *t)
{
    for (int i = 0; i < WAYS; i++) {
        set_levels(ways[i].weight_range, &t->levels[ways[i].weight_range]);
        ibl_astc_set_codes(ways[i].value_range, &t->codes[ways[i].value_range]);
    }
    set_patterns(t);
}

/* ---- texels ------------------------------------------------------------ */

/* q of a light, real; half a step of a half more, since halves are cut. step:
 * the light of one q there. */
static float q_of(float light, float *step)
{
    const uint32_t bits = ibl_bits_of(light);
    float unit, steps, e;

    if (light < 0x1p-14f) {
        e = 0;
        unit = 0x1p-24f;
        steps = light * 0x1p24f;
    } else {
        e = (float)((int)(bits >> 23) - 112);
        unit = ibl_float_of((bits & 0x7F800000) - (10u << 23));
        steps = (float)(bits & 0x7FFFFF) * 0x1p-13f;
    }
    steps = 8 * steps + 3.5f;
    const float slope = steps < 1536 ? 3 : steps < 5632 ? 4 : 5;
    const float base = steps < 1536 ? 0 : steps < 5632 ? 512 : 2048;
    *step = unit * slope / 8;
    return 2048 * e + (steps + base) / slope;
}

/* What is smaller than these parts of the texel, or of the brightest one of the
 * block, is no colour to keep. */
#define OF_TEXEL 0x1p-11f
#define OF_BLOCK 0x1p-17f

static void load(const float *texels, ibl_astc_texels *t)
{
    float most = 0, channel[3] = {0};

    for (int i = 0; i < 16; i++)
        for (int c = 0; c < 3; c++) {
            const float light = texels[3 * i + c] < IBL_ASTC_HDR_MAX
                                    ? texels[3 * i + c]
                                    : IBL_ASTC_HDR_MAX;
            t->light[c][i] = light;
            channel[c] = light > channel[c] ? light : channel[c];
            most = light > most ? light : most;
        }
    for (int i = 0; i < 16; i++) {
        const float r = t->light[0][i], g = t->light[1][i], b = t->light[2][i];
        const float square = r * r + g * g + b * b;
        const float floor_of_block = OF_BLOCK * most;
        t->share[i] = 1 / (square + floor_of_block * floor_of_block + 0x1p-60f);
        const float least = OF_TEXEL * sqrtf(square) + .5f * floor_of_block;
        for (int c = 0; c < 3; c++) {
            const float l = t->light[c][i];
            float step;
            t->q[c][i] = q_of(channel[c] > 0 && l < least ? least : l, &step);
            t->weight[c][i] = step * step * t->share[i];
        }
    }
    for (int c = 0; c < 3; c++) {
        float sum = 0, mean;
        for (int i = 0; i < 16; i++)
            sum += t->q[c][i];
        mean = sum / 16;
        t->origin[c] = (int)mean;
        for (int i = 0; i < 16; i++)
            t->q[c][i] -= (float)t->origin[c];
    }
}

/* The texels of one subset: others have no weight. */
static void take(const ibl_astc_texels *all, const float *second, int stride,
                 int subset, ibl_astc_texels *t)
{
    *t = *all;
    for (int i = 0; i < 16; i++) {
        const float in = subset ? second[i * stride] : 1 - second[i * stride];
        t->share[i] *= in;
        for (int c = 0; c < 3; c++)
            t->weight[c][i] *= in;
    }
}

/* ---- lines ------------------------------------------------------------- */

/* Where texels are from the darkest to the brightest, by their light. */
static void by_light(const ibl_astc_texels *t, float s[16])
{
    float along[16], least = FLT_MAX, most = -FLT_MAX;

    for (int i = 0; i < 16; i++) {
        float sum = 0, weight = 0x1p-100f;
        for (int c = 0; c < 3; c++) {
            sum += t->weight[c][i] * t->q[c][i];
            weight += t->weight[c][i];
        }
        along[i] = sum / weight;
        if (t->share[i] > 0) {
            least = along[i] < least ? along[i] : least;
            most = along[i] > most ? along[i] : most;
        }
    }
    for (int i = 0; i < 16; i++)
        s[i] = most > least ? (along[i] - least) / (most - least) : 0;
}

/* Ends so that texels of the subset fill what is between them. */
static void stretch(const ibl_astc_texels *t, const float s[16],
                    float ends[2][3])
{
    float least = 1, most = 0;
    for (int i = 0; i < 16; i++)
        if (t->share[i] > 0) {
            least = s[i] < least ? s[i] : least;
            most = s[i] > most ? s[i] : most;
        }
    for (int c = 0; c < 3; c++) {
        const float from = ends[0][c], length = ends[1][c] - from;
        ends[0][c] = from + length * least;
        ends[1][c] = from + length * most;
    }
}

static void solve(int mode, const ibl_astc_sums sums[3], float ends[2][3])
{
    if (mode == IBL_ASTC_SCALE)
        ibl_astc_solve_scale(sums, ends);
    else
        ibl_astc_solve(sums, ends);
}

/* A line without quantisation. */
static void find_line(const tables *tb, const ibl_astc_texels *t, int mode,
                      float ends[2][3])
{
    ibl_astc_sums sums[3];
    float s[16];

    by_light(t, s);
    for (int turn = 0; turn < 3; turn++) {
        tb->fit->sums(t, s, sums);
        solve(mode, sums, ends);
        /* As long as the line may be. */
        for (int c = 0; c < 3; c++) {
            const float length = ends[1][c] - ends[0][c];
            ends[0][c] -= length;
            ends[1][c] += length;
        }
        tb->fit->project(t, ends, s);
        stretch(t, s, ends);
        tb->fit->project(t, ends, s);
    }
}

static void snap(const ibl_astc_levels *l, float s[16], unsigned char level[16],
                 int steps[16])
{
    for (int i = 0; i < 16; i++) {
        const int k = (int)(s[i] * (float)(l->count - 1) + .5f);
        level[i] = (unsigned char)k;
        steps[i] = l->step[k];
        s[i] = (float)l->step[k] * (1.0f / 64);
    }
}

/* Puts the texels on the line of values, and takes it if it is better. */
static int try_values(const tables *tb, const ibl_astc_texels *t, int mode,
                      const ibl_astc_levels *l, const unsigned char *values,
                      line *best, float s[16])
{
    int e[2][3], steps[16];
    float ends[2][3];
    unsigned char level[16];

    if (mode == IBL_ASTC_SCALE)
        ibl_astc_scale_endpoints(values, e);
    else
        ibl_astc_direct_endpoints(values, e);
    for (int i = 0; i < 6; i++) {
        e[i / 3][i % 3] <<= 4;
        ends[i / 3][i % 3] = (float)(e[i / 3][i % 3] - t->origin[i % 3]);
    }
    tb->fit->project(t, ends, s);
    snap(l, s, level, steps);
    const float error = tb->fit->error(t, e, steps);
    if (!(error < best->error))
        return 0;
    best->error = error;
    memcpy(best->values, values, sizeof best->values);
    memcpy(best->level, level, sizeof level);
    return 1;
}

/* Turns the line so that its second end has the largest value. */
static void turn(const ibl_astc_texels *t, ibl_astc_sums sums[3],
                 float ends[2][3])
{
    float most[2] = {-FLT_MAX, -FLT_MAX};
    for (int i = 0; i < 6; i++) {
        const float v = ends[i / 3][i % 3] + (float)t->origin[i % 3];
        most[i / 3] = v > most[i / 3] ? v : most[i / 3];
    }
    if (most[1] >= most[0])
        return;
    for (int c = 0; c < 3; c++) {
        const ibl_astc_sums s = sums[c];
        const float end = ends[0][c];
        sums[c] = (ibl_astc_sums){s.bb, s.ab, s.aa, s.b, s.a};
        ends[0][c] = ends[1][c];
        ends[1][c] = end;
    }
}

/* The forms that lose least, in order. */
static void rank_forms(const ibl_astc_texels *t, int mode,
                       const float ends[2][3], float gap, int n, int *forms)
{
    const int count =
        mode == IBL_ASTC_SCALE ? IBL_ASTC_SCALE_FORMS : IBL_ASTC_DIRECT_FORMS;
    float loss[IBL_ASTC_DIRECT_FORMS];

    for (int i = 0; i < count; i++)
        loss[i] = mode == IBL_ASTC_SCALE
                      ? ibl_astc_scale_loss(ends, t->origin, i, gap)
                      : ibl_astc_direct_loss(ends, t->origin, i, gap);
    for (int k = 0; k < n; k++) {
        int best = 0;
        for (int i = 1; i < count; i++)
            if (loss[i] < loss[best])
                best = i;
        forms[k] = best;
        loss[best] = FLT_MAX;
    }
}

/* Finds the line of a subset from ends without quantisation. */
static void fit_line(const tables *tb, const ibl_astc_texels *t, const way *w,
                     const float from[2][3], line *best)
{
    const ibl_astc_levels *l = &tb->levels[w->weight_range];
    const ibl_astc_codes *codes = &tb->codes[w->value_range];
    const int tries = tb->quality == IBL_QUALITY_FAST     ? 1
                      : tb->quality == IBL_QUALITY_NORMAL ? 2
                                                          : 4;
    const int rounds = tb->quality == IBL_QUALITY_FAST     ? 1
                       : tb->quality == IBL_QUALITY_NORMAL ? 3
                                                           : 6;
    ibl_astc_sums sums[3];
    float ends[2][3], s[16];
    unsigned char level[16], values[6] = {0};
    int steps[16], forms[4];

    best->error = FLT_MAX;
    memcpy(ends, from, sizeof ends);
    for (int round = 0; round < rounds; round++) {
        int better = 0;
        float kept[16];
        if (!round) {
            tb->fit->project(t, ends, s);
            snap(l, s, level, steps);
        }
        tb->fit->sums(t, s, sums);
        solve(w->mode, sums, ends);
        turn(t, sums, ends);
        rank_forms(t, w->mode, ends, codes->gap, tries, forms);
        for (int k = 0; k < tries; k++) {
            float at[16];
            if (!(w->mode == IBL_ASTC_SCALE
                      ? ibl_astc_quantise_scale(sums, ends, t->origin, forms[k],
                                                codes, values)
                      : ibl_astc_quantise_direct(sums, ends, t->origin,
                                                 forms[k], codes, values)))
                continue;
            if (try_values(tb, t, w->mode, l, values, best, at)) {
                better = 1;
                memcpy(kept, at, sizeof kept);
            }
        }
        if (!better)
            break;
        memcpy(s, kept, sizeof s);
    }
}

/* ---- blocks ------------------------------------------------------------ */

static void try_one(const tables *tb, const ibl_astc_texels *t, int way_index,
                    const float ends[2][3], trial *best)
{
    line l;
    fit_line(tb, t, &ways[way_index], ends, &l);
    if (l.error < best->error) {
        best->error = l.error;
        best->way = way_index;
        best->lines[0] = l;
    }
}

static void try_two(const tables *tb, const ibl_astc_texels *t, int way_index,
                    int pattern, trial *best)
{
    line l[2];
    for (int s = 0; s < 2; s++) {
        ibl_astc_texels part;
        float ends[2][3];
        take(t, &tb->second[0][pattern], IBL_ASTC_PATTERNS_PADDED, s, &part);
        find_line(tb, &part, ways[way_index].mode, ends);
        fit_line(tb, &part, &ways[way_index], ends, &l[s]);
    }
    if (l[0].error < FLT_MAX && l[1].error < FLT_MAX &&
        l[0].error + l[1].error < best->error) {
        best->error = l[0].error + l[1].error;
        best->way = way_index;
        best->pattern = patterns[pattern];
        memcpy(best->lines, l, sizeof l);
    }
}

/* The patterns that tell the texels apart best, in order. along: what counts of
 * the way along grey, the direction of what each subset can have by its scale.
 */
static void rank_patterns(const tables *tb, const ibl_astc_texels *t,
                          float along, int n, int *found)
{
    float points[3][16], gain[IBL_ASTC_PATTERNS_PADDED], g[3], length = 0;

    for (int c = 0; c < 3; c++) {
        float sum = 0;
        for (int i = 0; i < 16; i++)
            sum += t->weight[c][i];
        g[c] = sqrtf(sum);
        length += sum;
    }
    length = sqrtf(length + 0x1p-100f);
    for (int i = 0; i < 16; i++) {
        float p = 0;
        for (int c = 0; c < 3; c++) {
            points[c][i] = t->q[c][i] * g[c];
            p += points[c][i] * g[c] / length;
        }
        for (int c = 0; c < 3; c++)
            points[c][i] -= (1 - along) * p * g[c] / length;
    }
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

/* One colour, as halves. */
static void try_flat(const ibl_astc_texels *t, uint16_t colour[3], trial *best)
{
    float error = 0, weight = 0;
    for (int i = 0; i < 16; i++)
        weight += t->share[i];
    for (int c = 0; c < 3; c++) {
        float sum = 0;
        for (int i = 0; i < 16; i++)
            sum += t->share[i] * t->light[c][i];
        colour[c] = ibl_half_from_float(sum / weight);
        for (int i = 0; i < 16; i++) {
            const float d = ibl_half_to_float(colour[c]) - t->light[c][i];
            error += d * d * t->share[i];
        }
    }
    best->way = -1;
    best->error = error;
}

static void write_flat(const uint16_t colour[3], unsigned char *block)
{
    ibl_bits128 bits = {0, 0};
    ibl_bits128_put(&bits, 0, 12, 0xFFC);
    for (int i = 0; i < 4; i++)
        ibl_bits128_put(&bits, 12 + 13 * i, 13, 8191);
    for (int c = 0; c < 3; c++)
        ibl_bits128_put(&bits, 64 + 16 * c, 16, colour[c]);
    ibl_bits128_put(&bits, 112, 16, 0x3C00);
    ibl_bits128_store(bits, block);
}

static void write_block(const tables *tb, const trial *b, unsigned char *block)
{
    const way *w = &ways[b->way];
    const int each = w->mode == IBL_ASTC_SCALE ? 4 : 6;
    ibl_astc_block a = {.subsets = w->subsets,
                        .pattern = b->pattern,
                        .mode = {w->mode, w->mode},
                        .values = each * w->subsets,
                        .value_range = w->value_range,
                        .weight_range = w->weight_range};

    for (int i = 0; i < a.values; i++)
        a.value[i] =
            tb->codes[w->value_range].of[b->lines[i / each].values[i % each]];
    for (int i = 0; i < 16; i++) {
        const int s =
            w->subsets == 2 ? ibl_astc_subset(b->pattern, 2, i % 4, i / 4) : 0;
        a.weight[i] = tb->levels[w->weight_range].code[b->lines[s].level[i]];
    }
    ibl_bits128_store(ibl_astc_pack(&a), block);
}

/* The squares of errors of 5 % of all texels. */
#define FAR (16 * .05f * .05f)

static void encode_block(const tables *tb, const float *texels,
                         unsigned char *block)
{
    ibl_astc_texels t;
    trial best = {0};
    uint16_t colour[3];
    float direct[2][3], scale[2][3];

    load(texels, &t);
    try_flat(&t, colour, &best);
    if (best.error > 1e-9f) {
        const int n = tb->quality == IBL_QUALITY_BEST ? 6 : 1;
        int found[8];
        find_line(tb, &t, IBL_ASTC_DIRECT, direct);
        find_line(tb, &t, IBL_ASTC_SCALE, scale);
        try_one(tb, &t, 0, direct, &best);
        try_one(tb, &t, 8, scale, &best);
        /* Of 16 levels' ends some are far off. */
        if (best.error > FAR || tb->quality > IBL_QUALITY_FAST)
            try_one(tb, &t, 1, direct, &best);
        if (tb->quality > IBL_QUALITY_FAST) {
            try_one(tb, &t, 3, direct, &best);
            rank_patterns(tb, &t, .1f, n, found);
            for (int k = 0; k < n; k++) {
                try_two(tb, &t, 16, found[k], &best);
                try_two(tb, &t, 17, found[k], &best);
                try_two(tb, &t, 18, found[k], &best);
                try_two(tb, &t, 21, found[k], &best);
            }
        }
    }
    if (best.way < 0)
        write_flat(colour, block);
    else
        write_block(tb, &best, block);
}

void ibl_astc_hdr_encode(const ibl_astc_fit_dsp *fit, const float *texels,
                         size_t count, ibl_quality quality,
                         unsigned char *blocks)
{
    tables t = {.fit = fit, .quality = quality};

    set_tables(&t);
    for (size_t i = 0; i < count; i++)
        encode_block(&t, texels + 48 * i, blocks + 16 * i);
}
