/* SPDX-License-Identifier: MIT */
/* Texels are lanes; in guess, partitions are. */
#include <float.h>
#include <string.h>

#include "kern/bc6h_fit.h"
#include "kern/lanes.h"

enum {
    N = IBL_BC6H_TEXELS
};

static const float weights[2][16] = {
    {0, 9, 18, 27, 37, 46, 55, 64},
    {0, 4, 9, 13, 17, 21, 26, 30, 34, 38, 43, 47, 51, 55, 60, 64}};

static const int bit[N] = {1,       1 << 1,  1 << 2,  1 << 3, 1 << 4,  1 << 5,
                           1 << 6,  1 << 7,  1 << 8,  1 << 9, 1 << 10, 1 << 11,
                           1 << 12, 1 << 13, 1 << 14, 1 << 15};

static inline vi vi_load(const int *p)
{
    return (vi)vf_load((const float *)(const void *)p);
}

static inline void vi_store(int *p, vi v)
{
    vf_store((float *)(void *)p, (vf)v);
}

static inline vf vf_and(vi mask, vf v)
{
    return (vf)(mask & (vi)v);
}

/* The texels i to i + VF - 1 that are members. */
static inline vi lanes_of(unsigned members, int i)
{
    const vi bits = vi_load(bit + i);
    return (bits & (int)members) == bits;
}

static inline float sum(const vf x[N / VF])
{
    const vq four = vf_fold_16(x);
    return (four[0] + four[1]) + (four[2] + four[3]);
}

/* The colours between two endpoints; the sums are integers below 2^24. */
static inline void mix(int first, int second, const float w[16], int count,
                       float *colours)
{
    const vf a = vf_all((float)first), b = vf_all((float)second);
    for (int k = 0; k < count; k += VF) {
        const vf share = vf_load(w + k);
        const vf sum = a * (vf_all(64) - share) + b * share + vf_all(32);
        const vi u = __builtin_convertvector(sum, vi) >> 6;
        const vi half = ((u << 5) - u) >> 6;
        vf_store(colours + k, (vf)(half << 13) * vf_all(0x1p112f));
    }
}

static inline vf colour_of(const float colours[2][16], int k, vi second,
                           bool two)
{
    const vf a = vf_all(colours[0][k]);
    return two ? vf_either(second, vf_all(colours[1][k]), a) : a;
}

/* The nearest colours to the texels from i on. Squared distances have the index
 * in place of their lowest bits, so that the least of them is enough to know.
 */
static inline vi nearest(const ibl_bc6h_texels *t,
                         const float colours[3][2][16], int i, vi second,
                         bool two)
{
    const vf red = vf_load(t->rgb[0] + i), green = vf_load(t->rgb[1] + i),
             blue = vf_load(t->rgb[2] + i);
    vf best = vf_all(FLT_MAX);
    for (int k = 0; k < (two ? 8 : 16); k++) {
        const vf r = red - colour_of(colours[0], k, second, two);
        const vf g = green - colour_of(colours[1], k, second, two);
        const vf b = blue - colour_of(colours[2], k, second, two);
        const vi bits = (vi)(r * r + g * g + b * b);
        best = vf_min((vf)((bits & ~15) | k), best);
    }
    return (vi)best;
}

static inline float assign_of(const ibl_bc6h_texels *t, const int ends[4][3],
                              unsigned second, bool two, int index[N])
{
    float colours[3][2][16];
    vf e[N / VF];
    for (int r = 0; r <= two; r++)
        for (int c = 0; c < 3; c++)
            mix(ends[2 * r][c], ends[2 * r + 1][c], weights[!two], two ? 8 : 16,
                colours[c][r]);
    for (int i = 0; i < N; i += VF) {
        const vi best = nearest(t, (const float(*)[2][16])colours, i,
                                lanes_of(second, i), two);
        vi_store(index + i, best & 15);
        e[i / VF] = (vf)(best & ~15) * vf_load(t->weight + i);
    }
    return sum(e);
}

static float assign(const ibl_bc6h_texels *t, const int ends[4][3],
                    unsigned second, int index[N])
{
    return second ? assign_of(t, ends, second, true, index)
                  : assign_of(t, ends, 0, false, index);
}

static inline void sum_region(const ibl_bc6h_texels *t, const float b[N],
                              unsigned members, ibl_bc6h_sums sums[3])
{
    for (int c = 0; c < 3; c++) {
        vf x[5][N / VF];
        for (int i = 0; i < N / VF; i++) {
            const vi in = lanes_of(members, i * VF);
            const vf share = vf_load(b + i * VF);
            x[0][i] = vf_and(in, vf_load(t->slope[c] + i * VF));
            x[1][i] = vf_and(in, vf_load(t->slope_u[c] + i * VF));
            x[2][i] = x[0][i] * share;
            x[3][i] = x[2][i] * share;
            x[4][i] = x[1][i] * share;
        }
        sums[c] = (ibl_bc6h_sums){sum(x[0]), sum(x[1]), sum(x[2]), sum(x[3]),
                                  sum(x[4])};
    }
}

static void sum_regions(const ibl_bc6h_texels *t, const float b[N],
                        unsigned second, ibl_bc6h_sums sums[2][3])
{
    sum_region(t, b, ~second, sums[0]);
    if (second)
        sum_region(t, b, second, sums[1]);
}

/* Sums over a region of 1, y and its products: x y z, xx yy zz xy xz yz. */
enum {
    SUMS = 10
};

static inline void terms_of(const ibl_bc6h_texels *t, int i, float terms[SUMS])
{
    const float x = t->y[0][i], y = t->y[1][i], z = t->y[2][i];
    const float all[SUMS] = {1,     x,     y,     z,     x * x,
                             y * y, z * z, x * y, x * z, y * z};
    memcpy(terms, all, sizeof all);
}

static inline void multiply(const vf m[6], const vf v[3], vf out[3])
{
    out[0] = m[0] * v[0] + m[3] * v[1] + m[4] * v[2];
    out[1] = m[3] * v[0] + m[1] * v[1] + m[5] * v[2];
    out[2] = m[4] * v[0] + m[5] * v[1] + m[2] * v[2];
}

static inline vf pick(vi y, vi z, vf a, vf b, vf c)
{
    return vf_either(z, c, vf_either(y, b, a));
}

/*
 * The longest axis of a region, by four steps of the power method from the
 * longest row of the covariances. What it does not explain is an error; of what
 * it does, even steps of 1/7 leave 1/49.
 */
static inline vf guess_region(const vf s[SUMS], vf axis[3])
{
    const vf scale = vf_all(1) / s[0];
    vf m[6], v[3], w[3];
    for (int c = 0; c < 3; c++)
        m[c] = s[4 + c] - s[1 + c] * s[1 + c] * scale;
    m[3] = s[7] - s[1] * s[2] * scale;
    m[4] = s[8] - s[1] * s[3] * scale;
    m[5] = s[9] - s[2] * s[3] * scale;
    const vf trace = m[0] + m[1] + m[2] + vf_all(FLT_MIN);
    const vf unit = vf_all(1) / trace;
    for (int i = 0; i < 6; i++)
        m[i] *= unit;
    const vi y = m[1] > m[0], z = m[2] > vf_either(y, m[1], m[0]);
    v[0] = pick(y, z, m[0], m[3], m[4]);
    v[1] = pick(y, z, m[3], m[1], m[5]);
    v[2] = pick(y, z, m[4], m[5], m[2]);
    multiply(m, v, w);
    multiply(m, w, v);
    multiply(m, v, w);
    multiply(m, w, axis);
    const vf along = w[0] * axis[0] + w[1] * axis[1] + w[2] * axis[2];
    const vf length = w[0] * w[0] + w[1] * w[1] + w[2] * w[2] + vf_all(FLT_MIN);
    return trace * (vf_all(1) - along / length * vf_all(48 / 49.0f));
}

/* Partitions from p on. */
static inline vi load_partitions(int p)
{
    int bits[VF];
    for (int i = 0; i < VF; i++)
        bits[i] = ibl_bc6h_partitions[p + i];
    return vi_load(bits);
}

/* What the first region has is what the second has not. */
static void guess(const ibl_bc6h_texels *t, ibl_bc6h_guesses *guesses)
{
    float terms[N][SUMS], all[SUMS] = {0};
    for (int i = 0; i < N; i++) {
        terms_of(t, i, terms[i]);
        for (int k = 0; k < SUMS; k++)
            all[k] += terms[i][k];
    }
    for (int p = 0; p < IBL_BC6H_PARTITIONS; p += VF) {
        const vi partitions = load_partitions(p);
        vf first[SUMS], second[SUMS] = {{0}}, axis[2][3];
        for (int i = 0; i < N; i++) {
            const vi in = (partitions & 1 << i) != 0;
            for (int k = 0; k < SUMS; k++)
                second[k] += vf_and(in, vf_all(terms[i][k]));
        }
        for (int k = 0; k < SUMS; k++)
            first[k] = vf_all(all[k]) - second[k];
        vf error = guess_region(first, axis[0]);
        error += guess_region(second, axis[1]);
        vf_store(guesses->error + p, error);
        for (int i = 0; i < 6; i++)
            vf_store(guesses->axis[i / 3][i % 3] + p, axis[i / 3][i % 3]);
    }
}

static void encode(const float *texels, size_t count, ibl_quality quality,
                   unsigned char *blocks)
{
    static const ibl_bc6h_fit fit = {assign, sum_regions, guess};
    ibl_bc6h_encode(&fit, texels, count, quality, blocks);
}

IBL_VECTOR_KERNEL(ibl_bc6h, encode)
