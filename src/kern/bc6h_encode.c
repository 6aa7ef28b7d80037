/* SPDX-License-Identifier: MIT */
/*
 * The encoder of BC6H. A candidate starts from the longest axis of a region's
 * texels, in the nearly logarithmic scale in which colours are mixed. Then
 * indices and endpoints take turns: nearest colours, least squares. The best
 * candidate by its decoded texels wins.
 *
 * The error of a texel t that is decoded as d is, p being the texel's share of
 * sum |t|^2 in its block,
 *     |d - t|^2 / (|t|^2 + 2^-32) (1 + 512 p^2).
 * Without the last factor that is what one sees after any exposure. With it a
 * sun keeps its light, which is most of the error of a whole level.
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

/* How many partitions are tried, the likeliest first. */
static const int tried[] = {
    [IBL_QUALITY_FAST] = 0, [IBL_QUALITY_NORMAL] = 1, [IBL_QUALITY_BEST] = 8};

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
        t->weight[i] = 1 / (size[i] + 0x1p-32f) + 512 * size[i] * share * share;
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
        t->rgb[i % 3][i / 3] = rgb[i] + 0.0f; /* -0 becomes 0 */
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

/* Gives a region's anchor an index whose highest bit is 0, by exchange of the
 * endpoints. */
static void settle_anchor(candidate *x, int region)
{
    const int top = two_regions(x) ? 7 : 15, anchor = anchor_of(x, region);
    if (x->index[anchor] <= top / 2)
        return;
    for (int c = 0; c < 3; c++) {
        const int q = x->q[2 * region][c];
        x->q[2 * region][c] = x->q[2 * region + 1][c];
        x->q[2 * region + 1][c] = q;
    }
    for (int i = 0; i < N; i++)
        if ((int)(second_region(x) >> i & 1) == region)
            x->index[i] = top - x->index[i];
}

/* Finds indices for x->q, and the error; FLT_MAX: the block cannot have them.
 */
static void evaluate(const search *s, candidate *x)
{
    int ends[IBL_BC6H_ENDPOINTS][3];
    for (int e = 0; e < 2 * x->mode->regions; e++)
        for (int c = 0; c < 3; c++)
            ends[e][c] = ibl_bc6h_unquantise(x->q[e][c], x->mode->bits);
    x->error = s->fit->assign(&s->t, (const int(*)[3])ends, second_region(x),
                              x->index);
    for (int r = 0; r < x->mode->regions; r++)
        settle_anchor(x, r);
    if (!fits(x))
        x->error = FLT_MAX;
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

/* Places of the texels between endpoints, and steps from indices to endpoints
 * and back as long as they help, with the finest mode that can hold these, from
 * `finest` on; the last of as many regions holds all. */
static void try_places(search *s, const ibl_bc6h_mode *finest, int partition,
                       float b[N])
{
    const bool two = finest->regions == 2;
    float ends[4][3], before = FLT_MAX;
    candidate x = {.partition = partition, .error = FLT_MAX};
    do {
        before = x.error;
        solve(s, b, two ? ibl_bc6h_partitions[partition] : 0, ends);
        x.mode = finest;
        set_ends(s, &x, (const float(*)[3])ends);
        while (!fits(&x)) {
            x.mode++;
            set_ends(s, &x, (const float(*)[3])ends);
        }
        evaluate(s, &x);
        keep(&s->best, &x);
        for (int i = 0; i < N; i++)
            b[i] = ibl_bc6h_weights[!two][x.index[i]] * 0x1p-6f;
    } while (x.error < before && x.error < 2 * s->best.error);
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
    find_axis(s, axis);
    project(s, axis, ALL, 0, b);
    try_places(s, &ibl_bc6h_modes[IBL_BC6H_ONE_REGION], 0, b);
}

static void try_partition(search *s, const ibl_bc6h_guesses *g, int p)
{
    const unsigned second = ibl_bc6h_partitions[p];
    float b[N];
    for (int r = 0; r < 2; r++)
        project(s,
                (float[]){g->axis[r][0][p], g->axis[r][1][p], g->axis[r][2][p]},
                r ? second : ~second, r ? ibl_bc6h_anchors[p] : 0, b);
    try_places(s, &ibl_bc6h_modes[0], p, b);
}

static void try_two_regions(search *s, int count)
{
    ibl_bc6h_guesses g;
    s->fit->guess(&s->t, &g);
    while (count-- > 0) {
        int p = 0;
        for (int i = 1; i < IBL_BC6H_PARTITIONS; i++)
            p = g.error[i] < g.error[p] ? i : p;
        try_partition(s, &g, p);
        g.error[p] = FLT_MAX;
    }
}

/* The best block of one colour, which is the weighted mean: mode 15 has all
 * halves. */
static void try_flat(search *s)
{
    candidate x = {.mode = &ibl_bc6h_modes[IBL_BC6H_ONE_REGION]};
    float sum = 0;
    for (int i = 0; i < N; i++)
        sum += s->t.weight[i];
    for (int c = 0; c < 3; c++) {
        float mean = 0;
        for (int i = 0; i < N; i++)
            mean += s->t.weight[i] / sum * s->t.rgb[c][i];
        const int half = ibl_half_from_float(fminf(mean, IBL_BC6H_MAX));
        x.q[0][c] = x.q[1][c] = (half * 64 + 63) / 31;
    }
    evaluate(s, &x);
    keep(&s->best, &x);
}

/* From the brightest texel at one end, and the weighted mean of the others at
 * the other. A sun whose neighbours have other colours, as where one channel's
 * light was spread around it, may lead the steps from the longest axis to a
 * block without it. */
static void try_sun(search *s)
{
    candidate x = {.mode = &ibl_bc6h_modes[IBL_BC6H_MODES - 1]};
    float ends[4][3], b[N], sum = 0;
    int sun = 0;
    for (int i = 1; i < N; i++)
        if (s->t.rgb[0][i] + s->t.rgb[1][i] + s->t.rgb[2][i] >
            s->t.rgb[0][sun] + s->t.rgb[1][sun] + s->t.rgb[2][sun])
            sun = i;
    for (int i = 0; i < N; i++)
        sum += i == sun ? 0 : s->t.weight[i];
    for (int c = 0; c < 3; c++) {
        float mean = 0;
        for (int i = 0; i < N; i++)
            mean += i == sun ? 0 : s->t.weight[i] / sum * s->t.rgb[c][i];
        ends[0][c] = u_of(mean) - s->t.mean[c];
        ends[1][c] = s->t.u[c][sun];
    }
    set_ends(s, &x, (const float(*)[3])ends);
    evaluate(s, &x);
    keep(&s->best, &x);
    for (int i = 0; i < N; i++)
        b[i] = ibl_bc6h_weights[1][x.index[i]] * 0x1p-6f;
    try_places(s, &ibl_bc6h_modes[IBL_BC6H_ONE_REGION], 0, b);
}

/* ---- blocks ------------------------------------------------------------ */

/* Bits that are written from the lowest on. */
typedef struct bits {
    ibl_bits128 all;
    int at;
} bits;

static void put(bits *b, int value, int count)
{
    ibl_bits128_put(&b->all, b->at, count, value);
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
    bits b = {{0, 0}, 0};
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
    ibl_bits128_store(b.all, block);
}

void ibl_bc6h_encode(const ibl_bc6h_fit *fit, const float *texels, size_t count,
                     ibl_quality quality, unsigned char *blocks)
{
    search s = {.fit = fit};
    for (size_t i = 0; i < count; i++) {
        load(texels + i * 3 * N, &s.t);
        s.best.error = FLT_MAX;
        try_flat(&s);
        if (s.best.error > 0) {
            try_one_region(&s);
            if (s.best.error > N)
                try_sun(&s);
            if (tried[quality])
                try_two_regions(&s, tried[quality]);
        }
        write_block(&s.best, blocks + i * IBL_BLOCK_BYTES);
    }
}
