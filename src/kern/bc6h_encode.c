/* SPDX-License-Identifier: MIT */
/*
 * The encoder of BC6H. A candidate starts from the longest axis of a region's
 * texels, in the nearly logarithmic scale in which colours are mixed. Then
 * indices and endpoints take turns: nearest colours, least squares. The best
 * quality also tries endpoints beyond the texels and the neighbours of each
 * endpoint and of a channel's pairs of them. The best candidate by its decoded
 * texels wins.
 *
 * The error of a texel t that is decoded as d is, p being the texel's share of
 * sum |t|^2 in its block,
 *     e = |d - t|^2 / (|t|^2 + 2^-32) (1 + sun p^2).
 * Without the last factor that is what one sees after any exposure. With it a
 * sun keeps its light, which is most of the error of a whole level. The error
 * of a block is the sum of e; with the best quality that of their roots, which
 * makes mean relative errors 2 % less, and a smaller sun is enough.
 */
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/half.h"
#include "kern/bc6h.h"
#include "kern/bc6h_fit.h"

enum {
    N = IBL_BC6H_TEXELS,
    ALL = 0xFFFF /* texels, as a region */
};

typedef struct candidate {
    const ibl_bc6h_mode *mode;
    int partition;
    int q[IBL_BC6H_ENDPOINTS][3]; /* quantised endpoints, without deltas */
    int index[N];
    float errors[N], error; /* of texels and their sum */
} candidate;

/* What a quality takes. */
typedef struct effort {
    float sun;        /* see above */
    int stretches[2]; /* at each end, with one region and with two; 1: none */
    int partitions;   /* the likeliest of them */
    int refined;      /* the best of those */
    int descents;     /* rounds over the endpoints' neighbours */
    bool squeezed;    /* also tries modes that cannot hold the endpoints */
    bool roots;       /* of texels' errors */
} effort;

static const effort efforts[] = {
    [IBL_QUALITY_FAST] = {.sun = 512, .stretches = {1}},
    [IBL_QUALITY_NORMAL] = {.sun = 512,
                            .stretches = {1, 1},
                            .partitions = 1,
                            .refined = 1},
    [IBL_QUALITY_BEST] = {48, {6, 4}, 14, 6, 4, true, true},
};

typedef struct search {
    const ibl_bc6h_fit *fit;
    const effort *effort;
    ibl_bc6h_texels t;
    candidate best;
} search;

/* ---- texels ------------------------------------------------------------ */

/* The bits of x as a half, with a fraction, as what endpoints are. */
static float u_of(float x)
{
    const float half = (float)ibl_bits_of(x * 0x1p-112f) * 0x1p-13f;
    return (half + 0.5f) * (64 / 31.0f);
}

/* The change of a half with u. */
static float slope_of(float x)
{
    const float ulp = ibl_float_of(ibl_bits_of(x) & 0x7F800000) * 0x1p-10f;
    return fmaxf(ulp, 0x1p-24f) * (31 / 64.0f);
}

static void load_weights(float sun, ibl_bc6h_texels *t)
{
    float size[N], sum = 0;
    for (int i = 0; i < N; i++) {
        size[i] = t->rgb[0][i] * t->rgb[0][i] + t->rgb[1][i] * t->rgb[1][i] +
                  t->rgb[2][i] * t->rgb[2][i];
        sum += size[i];
    }
    const float share = 1 / (sum + 0x1p-28f);
    for (int i = 0; i < N; i++)
        t->weight[i] = 1 / (size[i] + 0x1p-32f) + sun * size[i] * share * share;
}

static void load_channel(ibl_bc6h_texels *t, int c)
{
    float u[N], sum = 0, slopes = 0;
    for (int i = 0; i < N; i++) {
        const float slope = slope_of(t->rgb[c][i]);
        u[i] = u_of(t->rgb[c][i]);
        t->slope[c][i] = slope * slope * t->weight[i];
        sum += u[i];
        slopes += t->slope[c][i];
    }
    const float unit = sqrtf(slopes / N);
    t->mean[c] = sum / N;
    for (int i = 0; i < N; i++) {
        t->u[c][i] = u[i] - t->mean[c];
        t->slope_u[c][i] = t->slope[c][i] * t->u[c][i];
        t->y[c][i] = t->u[c][i] * unit;
    }
}

static void load(const float *rgb, float sun, ibl_bc6h_texels *t)
{
    for (int i = 0; i < 3 * N; i++)
        t->rgb[i % 3][i / 3] = rgb[i] + 0.0f; /* -0 becomes 0 */
    load_weights(sun, t);
    for (int c = 0; c < 3; c++)
        load_channel(t, c);
}

/* ---- candidates -------------------------------------------------------- */

static bool two_regions(const candidate *x)
{
    return x->mode->regions == 2;
}

static unsigned second_region(const candidate *x)
{
    return two_regions(x) ? ibl_bc6h_partitions[x->partition] : 0;
}

static int anchor_of(const candidate *x, int region)
{
    return region ? ibl_bc6h_anchors[x->partition] : 0;
}

/* Whether the differences have few enough bits. */
static bool fits(const candidate *x)
{
    if (!x->mode->deltas)
        return true;
    for (int e = 1; e < 2 * x->mode->regions; e++)
        for (int c = 0; c < 3; c++) {
            const int limit = 1 << (x->mode->other_bits[c] - 1);
            const int delta = x->q[e][c] - x->q[0][c];
            if (delta < -limit || delta >= limit)
                return false;
        }
    return true;
}

static void swap_ends(candidate *x, int region)
{
    const int top = two_regions(x) ? 7 : 15;
    int *a = x->q[2 * region], *b = x->q[2 * region + 1];
    for (int c = 0; c < 3; c++) {
        const int q = a[c];
        a[c] = b[c];
        b[c] = q;
    }
    for (int i = 0; i < N; i++)
        if ((int)(second_region(x) >> i & 1) == region)
            x->index[i] = top - x->index[i];
}

/* The error of a texel with the colour of its index. */
static float error_of(const search *s, const candidate *x, int region, int i)
{
    const int weight = ibl_bc6h_weights[!two_regions(x)][x->index[i]];
    float error = 0;
    for (int c = 0; c < 3; c++) {
        const int *a = x->q[2 * region], *b = x->q[2 * region + 1];
        const int half =
            ibl_bc6h_half(ibl_bc6h_unquantise(a[c], x->mode->bits),
                          ibl_bc6h_unquantise(b[c], x->mode->bits), weight);
        const float d = s->t.rgb[c][i] - ibl_half_to_float((uint16_t)half);
        error += d * d;
    }
    error *= s->t.weight[i];
    return s->effort->roots ? sqrtf(error) : error;
}

/* Gives a region's anchor an index whose highest bit is 0: by exchange of the
 * endpoints or, where those do not fit then, the colour next to the middle. */
static void settle_anchor(const search *s, candidate *x, int region)
{
    const int half = two_regions(x) ? 4 : 8, anchor = anchor_of(x, region);
    if (x->index[anchor] < half)
        return;
    swap_ends(x, region);
    if (fits(x))
        return;
    swap_ends(x, region);
    x->index[anchor] = half - 1;
    x->error -= x->errors[anchor];
    x->errors[anchor] = error_of(s, x, region, anchor);
    x->error += x->errors[anchor];
}

/* Finds indices for x->q, and the errors. */
static void evaluate(const search *s, candidate *x)
{
    int ends[IBL_BC6H_ENDPOINTS][3];
    for (int e = 0; e < 2 * x->mode->regions; e++)
        for (int c = 0; c < 3; c++)
            ends[e][c] = ibl_bc6h_unquantise(x->q[e][c], x->mode->bits);
    x->error = s->fit->assign(&s->t, (const int(*)[3])ends, second_region(x),
                              s->effort->roots, x->index, x->errors);
    for (int r = 0; r < x->mode->regions; r++)
        settle_anchor(s, x, r);
}

static void keep(candidate *best, const candidate *x)
{
    if (x->error < best->error)
        *best = *x;
}

/* Quantises endpoints that solve gave. */
static void set_ends(const search *s, candidate *x, const float ends[4][3])
{
    const int bits = x->mode->bits;
    const float top = (float)((1 << bits) - 1), half = bits == 16 ? 0.5f : 0;
    const float unit = (float)(1 << bits) * 0x1p-16f;
    for (int e = 0; e < 2 * x->mode->regions; e++)
        for (int c = 0; c < 3; c++) {
            const float q = (ends[e][c] + s->t.mean[c]) * unit + half;
            x->q[e][c] = (int)(q < 0 ? 0 : q < top ? q : top);
        }
}

/* Endpoints, minus the mean, of least squares for the texels' shares b of the
 * second ones. */
static void solve(const search *s, const float b[N], unsigned second,
                  float ends[4][3])
{
    ibl_bc6h_sums sums[2][3];
    s->fit->sum(&s->t, b, second, sums);
    for (int r = 0; r <= (second != 0); r++)
        for (int c = 0; c < 3; c++) {
            const ibl_bc6h_sums *z = &sums[r][c];
            const float aa = z->one - 2 * z->b + z->bb, ab = z->b - z->bb;
            const float au = z->u - z->ub, det = aa * z->bb - ab * ab;
            const bool line = det > 1e-4f * aa * z->bb;
            ends[2 * r][c] =
                line ? (au * z->bb - z->ub * ab) / det : z->u / z->one;
            ends[2 * r + 1][c] =
                line ? (z->ub * aa - au * ab) / det : z->u / z->one;
        }
}

/* Places of a region's texels along its axis, 0 to 1, the anchor below 1/2. */
static void project(const search *s, const float axis[3], unsigned members,
                    int anchor, float b[N])
{
    float p[N], low = FLT_MAX, high = -FLT_MAX;
    for (int i = 0; i < N; i++) {
        p[i] = s->t.y[0][i] * axis[0] + s->t.y[1][i] * axis[1] +
               s->t.y[2][i] * axis[2];
        if (members >> i & 1) {
            low = p[i] < low ? p[i] : low;
            high = p[i] > high ? p[i] : high;
        }
    }
    const bool turned = p[anchor] - low > high - p[anchor];
    const float from = turned ? high : low,
                unit = high > low ? 1 / ((turned ? low : high) - from) : 0;
    for (int i = 0; i < N; i++)
        if (members >> i & 1)
            b[i] = (p[i] - from) * unit;
}

/* A step from indices to endpoints and back. */
static void refine(const search *s, candidate *best)
{
    candidate x = *best;
    float b[N], ends[IBL_BC6H_ENDPOINTS][3];
    for (int i = 0; i < N; i++)
        b[i] = ibl_bc6h_weights[!two_regions(&x)][x.index[i]] * 0x1p-6f;
    solve(s, b, second_region(&x), ends);
    set_ends(s, &x, (const float(*)[3])ends);
    if (!fits(&x))
        return;
    evaluate(s, &x);
    keep(best, &x);
}

static bool within(const candidate *x, int end, int c)
{
    return x->q[end][c] >= 0 && x->q[end][c] < 1 << x->mode->bits;
}

/* Moves a channel of an endpoint by step, and of the region's other endpoint by
 * `other`, as long as that is better. */
static bool descend(const search *s, candidate *best, int end, int c, int step,
                    int other)
{
    for (bool moved = false;; moved = true) {
        candidate x = *best;
        x.q[end][c] += step;
        x.q[end ^ 1][c] += other;
        if (!within(&x, end, c) || !within(&x, end ^ 1, c) || !fits(&x))
            return moved;
        evaluate(s, &x);
        if (!(x.error < best->error))
            return moved;
        *best = x;
    }
}

/* One endpoint, or both: the line's place, its length. */
static bool descend_each(const search *s, candidate *x, int end, int c)
{
    bool moved = false;
    for (int step = -1; step <= 1; step += 2) {
        moved |= descend(s, x, end, c, step, 0);
        if (end % 2 == 0) {
            moved |= descend(s, x, end, c, step, step);
            moved |= descend(s, x, end, c, step, -step);
        }
    }
    return moved;
}

static void descend_all(const search *s, candidate *x)
{
    bool moved = true;
    for (int i = 0; i < s->effort->descents && moved; i++) {
        moved = false;
        for (int k = 0; k < 6 * x->mode->regions; k++)
            moved |= descend_each(s, x, k / 3, k % 3);
    }
}

static void finish(search *s, candidate *x)
{
    refine(s, x);
    if (x->error < 1.2f * s->best.error)
        descend_all(s, x);
    keep(&s->best, x);
}

/* Whether a difference of endpoints is far more than what a mode can hold. */
static bool is_beyond(const search *s, const ibl_bc6h_mode *mode,
                      const float range[3])
{
    const float part = s->effort->squeezed ? 1.5f : 1;
    bool beyond = false;
    for (int c = 0; c < 3; c++) {
        const int limit = (1 << (mode->other_bits[c] - 1)) + 1;
        beyond |= range[c] > part * (float)(limit << (16 - mode->bits));
    }
    return beyond && mode->deltas;
}

static void squeeze(candidate *x)
{
    for (int e = 1; e < 2 * x->mode->regions; e++)
        for (int c = 0; c < 3; c++) {
            const int limit = 1 << (x->mode->other_bits[c] - 1);
            const int least = x->q[0][c] - limit, most = least + 2 * limit - 1;
            const int q = x->q[e][c];
            x->q[e][c] = q < least ? least : q > most ? most : q;
        }
}

/* Tries endpoints with the finest mode that can hold them, from m on; all such
 * modes have as many regions. */
static void try_ends(const search *s, int m, int partition,
                     const float ends[4][3], candidate *best)
{
    const int regions = ibl_bc6h_modes[m].regions;
    candidate x = {.partition = partition};
    float range[3] = {0};
    for (int i = 3; i < 6 * regions; i++)
        range[i % 3] =
            fmaxf(range[i % 3], fabsf(ends[i / 3][i % 3] - ends[0][i % 3]));
    for (; m < IBL_BC6H_MODES && ibl_bc6h_modes[m].regions == regions; m++) {
        x.mode = &ibl_bc6h_modes[m];
        if (is_beyond(s, x.mode, range))
            continue;
        set_ends(s, &x, ends);
        const bool fit = fits(&x);
        if (!fit && !s->effort->squeezed)
            continue;
        if (!fit)
            squeeze(&x);
        evaluate(s, &x);
        keep(best, &x);
        if (fit)
            return;
    }
}

/* Moves a region's endpoints out by low and high of the steps between colours,
 * so that colours between the texels' places may fit better. */
static void stretch(const float ends[2][3], int low, int high, int steps,
                    float out[2][3])
{
    for (int c = 0; c < 3; c++) {
        const float step =
            (ends[1][c] - ends[0][c]) / (float)(steps - low - high);
        out[0][c] = ends[0][c] - (float)low * step;
        out[1][c] = ends[1][c] + (float)high * step;
    }
}

/* Keeps the endpoints of each region that have the least error in it. */
static void keep_ends(const candidate *x, const float ends[4][3],
                      float least[2], float best[4][3])
{
    float error[2] = {0};
    for (int i = 0; i < N; i++)
        error[second_region(x) >> i & 1] += x->errors[i];
    for (int r = 0; r < 2; r++)
        if (error[r] < least[r]) {
            least[r] = error[r];
            memcpy(best[2 * r], ends[2 * r], 2 * sizeof *ends);
        }
}

/* Tries places b of the texels between endpoints, and stretched ones. */
static void try_places(const search *s, int mode, int partition,
                       const float b[N], candidate *best)
{
    const bool two = mode < IBL_BC6H_ONE_REGION;
    const int count = s->effort->stretches[two];
    float ends[4][3], each[4][3], least[2] = {FLT_MAX, FLT_MAX};
    solve(s, b, two ? ibl_bc6h_partitions[partition] : 0, ends);
    best->error = FLT_MAX;
    for (int i = 0; i < count * count; i++) {
        float now[4][3];
        candidate x = {.error = FLT_MAX};
        for (int r = 0; r <= two; r++)
            stretch((const float(*)[3])ends + 2 * r, i / count, i % count,
                    two ? 7 : 15, now + 2 * r);
        try_ends(s, mode, partition, (const float(*)[3])now, &x);
        keep(best, &x);
        if (two)
            keep_ends(&x, (const float(*)[3])now, least, each);
    }
    if (two && count > 1)
        try_ends(s, mode, partition, (const float(*)[3])each, best);
}

static void multiply(const float m[3][3], const float v[3], float out[3])
{
    for (int i = 0; i < 3; i++)
        out[i] = m[i][0] * v[0] + m[i][1] * v[1] + m[i][2] * v[2];
}

/* As the axes of guesses, of all texels. */
static void find_axis(const search *s, float axis[3])
{
    float m[3][3] = {{0}}, v[3];
    for (int i = 0; i < N; i++)
        for (int a = 0; a < 3; a++)
            for (int b = 0; b < 3; b++)
                m[a][b] += s->t.y[a][i] * s->t.y[b][i];
    const float unit = 1 / (m[0][0] + m[1][1] + m[2][2] + FLT_MIN);
    for (int i = 0; i < 9; i++)
        m[i / 3][i % 3] *= unit;
    const int row = m[1][1] > m[0][0];
    multiply(m, m[m[2][2] > m[row][row] ? 2 : row], axis);
    multiply(m, axis, v);
    multiply(m, v, axis);
}

static void try_one_region(search *s)
{
    float axis[3], b[N];
    candidate x;
    find_axis(s, axis);
    project(s, axis, ALL, 0, b);
    try_places(s, IBL_BC6H_ONE_REGION, 0, b, &x);
    finish(s, &x);
}

static void try_partition(const search *s, const ibl_bc6h_guesses *g, int p,
                          candidate *best)
{
    const unsigned second = ibl_bc6h_partitions[p];
    float b[N];
    for (int r = 0; r < 2; r++)
        project(s,
                (float[]){g->axis[r][0][p], g->axis[r][1][p], g->axis[r][2][p]},
                r ? second : ~second, r ? ibl_bc6h_anchors[p] : 0, b);
    try_places(s, 0, p, b, best);
}

static int least_of(const float *errors, int count)
{
    int best = 0;
    for (int i = 1; i < count; i++)
        best = errors[i] < errors[best] ? i : best;
    return best;
}

static void try_two_regions(search *s)
{
    const int count = s->effort->partitions;
    ibl_bc6h_guesses g;
    candidate x[IBL_BC6H_PARTITIONS];
    float errors[IBL_BC6H_PARTITIONS];
    s->fit->guess(&s->t, &g);
    for (int i = 0; i < count; i++) {
        const int p = least_of(g.error, IBL_BC6H_PARTITIONS);
        try_partition(s, &g, p, &x[i]);
        g.error[p] = FLT_MAX;
        errors[i] = x[i].error;
    }
    for (int i = 0; i < s->effort->refined; i++) {
        const int k = least_of(errors, count);
        finish(s, &x[k]);
        errors[k] = FLT_MAX;
    }
}

/* The weighted mean of the texels, which has the least sum of squares. */
static void find_mean(const search *s, const float weights[N], float mean[3])
{
    float sum = 0;
    for (int i = 0; i < N; i++)
        sum += weights[i];
    for (int c = 0; c < 3; c++) {
        mean[c] = 0;
        for (int i = 0; i < N; i++)
            mean[c] += weights[i] / sum * s->t.rgb[c][i];
    }
}

/* Of one colour: mode 15 has all halves. */
static void try_flat(search *s, const float colour[3])
{
    candidate x = {.mode = &ibl_bc6h_modes[IBL_BC6H_ONE_REGION]};
    for (int c = 0; c < 3; c++) {
        const int half = ibl_half_from_float(fminf(colour[c], IBL_BC6H_MAX));
        x.q[0][c] = x.q[1][c] = (half * 64 + 63) / 31;
    }
    evaluate(s, &x);
    keep(&s->best, &x);
}

/*
 * The best block of one colour. The least sum of roots is found by repeated
 * means with weights over distances (Weiszfeld's algorithm), or is at a texel.
 */
static void try_flats(search *s)
{
    float weights[N], mean[3];
    memcpy(weights, s->t.weight, sizeof weights);
    for (int k = 0; k < (s->effort->roots ? 20 : 1); k++) {
        find_mean(s, weights, mean);
        try_flat(s, mean);
        for (int i = 0; i < N; i++)
            weights[i] = s->t.weight[i] / (s->best.errors[i] + 1e-6f);
    }
}

/* ---- blocks ------------------------------------------------------------ */

typedef struct bits {
    uint64_t words[2]; /* from the lowest bit on */
    int at;
} bits;

/* Adds the lowest count bits of value, 1..16. */
static void put(bits *b, int value, int count)
{
    const uint64_t low = (uint64_t)value & ((1u << count) - 1);
    const int at = b->at % 64;
    b->words[b->at / 64] |= low << at;
    if (at + count > 64)
        b->words[1] |= low >> (64 - at);
    b->at += count;
}

static void put_run(bits *b, const candidate *x, const ibl_bc6h_run *run)
{
    const int e = run->value / 3, c = run->value % 3;
    const int base = e && x->mode->deltas ? x->q[0][c] : 0;
    const int value = x->q[e][c] - base;
    if (run->from <= run->to)
        put(b, value >> run->from, run->to - run->from + 1);
    for (int i = run->from; i >= run->to && run->from > run->to; i--)
        put(b, value >> i, 1);
}

static void write_block(const candidate *x, unsigned char *block)
{
    const bool two = two_regions(x);
    bits b = {{0}, 0};
    put(&b, x->mode->number, x->mode->number < 2 ? 2 : 5);
    const int header = b.at + ibl_bc6h_header_bits(x->mode);
    for (const ibl_bc6h_run *run = x->mode->runs; b.at < header; run++)
        put_run(&b, x, run);
    if (two)
        put(&b, x->partition, 5);
    for (int i = 0; i < N; i++) {
        const bool anchor = i == 0 || (two && i == anchor_of(x, 1));
        put(&b, x->index[i], (two ? 3 : 4) - anchor);
    }
    for (int i = 0; i < IBL_BLOCK_BYTES; i++)
        block[i] = (unsigned char)(b.words[i / 8] >> i % 8 * 8);
}

void ibl_bc6h_encode(const ibl_bc6h_fit *fit, const float *texels, size_t count,
                     ibl_quality quality, unsigned char *blocks)
{
    search s = {.fit = fit, .effort = &efforts[quality]};
    for (size_t i = 0; i < count; i++) {
        load(texels + i * 3 * N, s.effort->sun, &s.t);
        s.best.error = FLT_MAX;
        try_flats(&s);
        if (s.best.error > 0) {
            try_one_region(&s);
            if (s.effort->partitions)
                try_two_regions(&s);
        }
        write_block(&s.best, blocks + i * IBL_BLOCK_BYTES);
    }
}
