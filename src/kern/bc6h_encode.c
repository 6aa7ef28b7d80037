/* SPDX-License-Identifier: MIT */
/*
 * The encoder of BC6H. A candidate starts from the longest axis of a region's
 * texels, in the nearly logarithmic scale in which colours are mixed. Then
 * indices and endpoints take turns: nearest colours, least squares. The best
 * candidate by its decoded texels wins.
 *
 * The error of a block is, with t its texels and d the decoded ones,
 *     sum |d - t|^2 (1 / (|t|^2 + 2^-32) + 256 |t|^2 / (sum |t|^2)^2).
 * The first term is what one sees after any exposure. The second keeps the
 * light of a sun in the block, which is most of a whole level's error.
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
    float error;
} candidate;

typedef struct search {
    const ibl_bc6h_fit *fit;
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

static void load_weights(ibl_bc6h_texels *t)
{
    float size[N], sum = 0;
    for (int i = 0; i < N; i++) {
        size[i] = t->rgb[0][i] * t->rgb[0][i] + t->rgb[1][i] * t->rgb[1][i] +
                  t->rgb[2][i] * t->rgb[2][i];
        sum += size[i];
    }
    const float share = 1 / (sum + 0x1p-28f);
    for (int i = 0; i < N; i++)
        t->weight[i] = 1 / (size[i] + 0x1p-32f) + 256 * size[i] * share * share;
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

static void load(const float *rgb, ibl_bc6h_texels *t)
{
    for (int i = 0; i < 3 * N; i++)
        t->rgb[i % 3][i / 3] = rgb[i];
    load_weights(t);
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

/* Squared distance of a texel to the colour of an index, times its weight. */
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
    return error * s->t.weight[i];
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
    x->error -= error_of(s, x, region, anchor);
    x->index[anchor] = half - 1;
    x->error += error_of(s, x, region, anchor);
}

/* Finds indices for x->q, and the error. */
static void evaluate(const search *s, candidate *x)
{
    int ends[IBL_BC6H_ENDPOINTS][3];
    float errors[N];
    for (int e = 0; e < 2 * x->mode->regions; e++)
        for (int c = 0; c < 3; c++)
            ends[e][c] = ibl_bc6h_unquantise(x->q[e][c], x->mode->bits);
    x->error = s->fit->assign(&s->t, (const int(*)[3])ends, second_region(x),
                              x->index, errors);
    for (int r = 0; r < x->mode->regions; r++)
        settle_anchor(s, x, r);
}

static void keep(candidate *best, const candidate *x)
{
    if (x->error < best->error)
        *best = *x;
}

static int quantise(float u, int bits)
{
    const int top = (1 << bits) - 1;
    const float q = bits == 16 ? u + 0.5f : u * (float)(1 << bits) * 0x1p-16f;
    return q < 0 ? 0 : q >= (float)top ? top : (int)q;
}

/* Quantises endpoints that solve gave. */
static void set_ends(const search *s, candidate *x, float ends[4][3])
{
    for (int e = 0; e < 2 * x->mode->regions; e++)
        for (int c = 0; c < 3; c++)
            x->q[e][c] = quantise(ends[e][c] + s->t.mean[c], x->mode->bits);
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

/* What a quality takes. */
typedef struct effort {
    int partitions; /* the likeliest of them */
    int stretches;  /* of the places of texels, at each end */
    int steps;      /* of least squares */
} effort;

static const effort efforts[] = {
    [IBL_QUALITY_FAST] = {0, 1, 1},
    [IBL_QUALITY_NORMAL] = {2, 2, 2},
    [IBL_QUALITY_BEST] = {IBL_BC6H_PARTITIONS, 3, 3},
};

/* Steps from indices to endpoints and back. */
static void refine(search *s, candidate *x, int steps)
{
    for (int i = 0; i < steps; i++) {
        float b[N], ends[IBL_BC6H_ENDPOINTS][3];
        for (int k = 0; k < N; k++)
            b[k] = ibl_bc6h_weights[!two_regions(x)][x->index[k]] * 0x1p-6f;
        solve(s, b, second_region(x), ends);
        set_ends(s, x, ends);
        if (!fits(x))
            return;
        evaluate(s, x);
        keep(&s->best, x);
    }
}

/* Tries places b of the texels between endpoints with the finest mode that can
 * hold these, from m on; all such modes have as many regions. */
static void try_places(search *s, int m, int partition, const float b[N],
                       int steps)
{
    const int regions = ibl_bc6h_modes[m].regions;
    float ends[IBL_BC6H_ENDPOINTS][3];
    candidate x = {&ibl_bc6h_modes[m], .partition = partition};
    solve(s, b, second_region(&x), ends);
    for (; m < IBL_BC6H_MODES && ibl_bc6h_modes[m].regions == regions; m++) {
        x.mode = &ibl_bc6h_modes[m];
        set_ends(s, &x, ends);
        if (!fits(&x))
            continue;
        evaluate(s, &x);
        keep(&s->best, &x);
        refine(s, &x, steps);
        return;
    }
}

/* The same with places at colours that are not at the ends: others between them
 * may then fit better. */
static void try_stretched(search *s, int mode, int partition, const float b[N],
                          const effort *e)
{
    const float top = ibl_bc6h_modes[mode].regions == 2 ? 7 : 15;
    for (int i = 0; i < e->stretches * e->stretches; i++) {
        const int low = i / e->stretches, high = i % e->stretches;
        float places[N];
        for (int k = 0; k < N; k++)
            places[k] = ((float)low + b[k] * (top - (float)(low + high))) / top;
        try_places(s, mode, partition, places, e->steps);
    }
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

static void try_one_region(search *s, const effort *e)
{
    float axis[3], b[N];
    find_axis(s, axis);
    project(s, axis, ALL, 0, b);
    try_stretched(s, IBL_BC6H_ONE_REGION, 0, b, e);
}

static void try_partition(search *s, const ibl_bc6h_guesses *g, int p,
                          const effort *e)
{
    const unsigned second = ibl_bc6h_partitions[p];
    float b[N];
    for (int r = 0; r < 2; r++)
        project(s,
                (float[]){g->axis[r][0][p], g->axis[r][1][p], g->axis[r][2][p]},
                r ? second : ~second, r ? ibl_bc6h_anchors[p] : 0, b);
    try_stretched(s, 0, p, b, e);
}

static void try_two_regions(search *s, const effort *e)
{
    ibl_bc6h_guesses g;
    if (e->partitions)
        s->fit->guess(&s->t, &g);
    for (int i = 0; i < e->partitions; i++) {
        int best = 0;
        for (int p = 1; p < IBL_BC6H_PARTITIONS; p++)
            best = g.error[p] < g.error[best] ? p : best;
        try_partition(s, &g, best, e);
        g.error[best] = FLT_MAX;
    }
}

/* The best block of one colour: mode 15 has all halves. */
static void try_flat(search *s)
{
    candidate *x = &s->best;
    *x = (candidate){.mode = &ibl_bc6h_modes[IBL_BC6H_ONE_REGION]};
    for (int c = 0; c < 3; c++) {
        float sum = 0, weights = 0;
        for (int i = 0; i < N; i++) {
            sum += s->t.weight[i] * s->t.rgb[c][i];
            weights += s->t.weight[i];
        }
        const int half =
            ibl_half_from_float(fminf(sum / weights, IBL_BC6H_MAX));
        x->q[0][c] = x->q[1][c] = (half * 64 + 63) / 31;
    }
    evaluate(s, x);
}

/* ---- blocks ------------------------------------------------------------ */

/* Puts the lowest count bits of value at bit *at, which is then behind them. */
static void put(unsigned char *block, int *at, int value, int count)
{
    for (int i = 0; i < count; i++, ++*at)
        block[*at / 8] |= (unsigned char)((value >> i & 1) << *at % 8);
}

static void put_run(unsigned char *block, int *at, const candidate *x,
                    ibl_bc6h_run run)
{
    const int e = run.value / 3, c = run.value % 3,
              step = run.from <= run.to ? 1 : -1;
    const int value =
        e && x->mode->deltas ? x->q[e][c] - x->q[0][c] : x->q[e][c];
    for (int i = run.from; i != run.to + step; i += step)
        put(block, at, value >> i, 1);
}

static void write_block(const candidate *x, unsigned char *block)
{
    int at = 0;
    memset(block, 0, IBL_BLOCK_BYTES);
    put(block, &at, x->mode->number, x->mode->number < 2 ? 2 : 5);
    const int header = at + ibl_bc6h_header_bits(x->mode);
    for (const ibl_bc6h_run *run = x->mode->runs; at < header; run++)
        put_run(block, &at, x, *run);
    const bool two = two_regions(x);
    if (two)
        put(block, &at, x->partition, 5);
    for (int i = 0; i < N; i++) {
        const bool anchor = i == 0 || (two && i == anchor_of(x, 1));
        put(block, &at, x->index[i], (two ? 3 : 4) - anchor);
    }
}

void ibl_bc6h_encode(const ibl_bc6h_fit *fit, const float *texels, size_t count,
                     ibl_quality quality, unsigned char *blocks)
{
    search s = {.fit = fit};
    for (size_t i = 0; i < count; i++) {
        load(texels + i * 3 * N, &s.t);
        try_flat(&s);
        if (s.best.error > 0) {
            try_one_region(&s, &efforts[quality]);
            try_two_regions(&s, &efforts[quality]);
        }
        write_block(&s.best, blocks + i * IBL_BLOCK_BYTES);
    }
}

static void encode(const float *texels, size_t count, ibl_quality quality,
                   unsigned char *blocks)
{
    ibl_bc6h_encode(&ibl_bc6h_fit_c, texels, count, quality, blocks);
}

IBL_KERNEL(ibl_bc6h, encode)
