/* SPDX-License-Identifier: MIT */
#include "kern/bc6h_fit.h"

#include <float.h>
#include <math.h>

#include "core/half.h"

enum {
    N = IBL_BC6H_TEXELS
};

static float sum(const float x[N])
{
    float s[4];
    for (int i = 0; i < 4; i++)
        s[i] = (x[i] + x[i + 8]) + (x[i + 4] + x[i + 12]);
    return (s[0] + s[1]) + (s[2] + s[3]);
}

/* The float of a finite half: its bits give it times 2^-112. */
static float float_of_half(int half)
{
    return ibl_float_of((uint32_t)half << 13) * 0x1p112f;
}

/* Squared distances have the index in place of their lowest bits, so that the
 * least of them is enough to know. */
static float assign(const ibl_bc6h_texels *t, const int ends[4][3],
                    unsigned second, bool roots, int index[N], float errors[N])
{
    const bool two = second != 0;
    const unsigned char *weights = ibl_bc6h_weights[!two];
    float colours[2][16][3];
    for (int r = 0; r <= two; r++)
        for (int k = 0; k < (two ? 8 : 16); k++)
            for (int c = 0; c < 3; c++)
                colours[r][k][c] = float_of_half(ibl_bc6h_half(
                    ends[2 * r][c], ends[2 * r + 1][c], weights[k]));
    for (int i = 0; i < N; i++) {
        float best = FLT_MAX;
        for (uint32_t k = 0; k < (two ? 8 : 16); k++) {
            const float *colour = colours[second >> i & 1][k];
            const float r = t->rgb[0][i] - colour[0];
            const float g = t->rgb[1][i] - colour[1];
            const float b = t->rgb[2][i] - colour[2];
            const uint32_t bits = ibl_bits_of(r * r + g * g + b * b);
            const float e = ibl_float_of((bits & ~15u) | k);
            best = e < best ? e : best;
        }
        const uint32_t bits = ibl_bits_of(best);
        index[i] = (int)(bits & 15u);
        const float error = ibl_float_of(bits & ~15u) * t->weight[i];
        errors[i] = roots ? sqrtf(error) : error;
    }
    return sum(errors);
}

static void sum_region(const ibl_bc6h_texels *t, const float b[N],
                       unsigned members, int c, ibl_bc6h_sums *sums)
{
    float x[5][N];
    for (int i = 0; i < N; i++) {
        const float s = members >> i & 1 ? t->slope[c][i] : 0;
        const float su = members >> i & 1 ? t->slope_u[c][i] : 0;
        x[0][i] = s;
        x[1][i] = su;
        x[2][i] = s * b[i];
        x[3][i] = s * b[i] * b[i];
        x[4][i] = su * b[i];
    }
    *sums =
        (ibl_bc6h_sums){sum(x[0]), sum(x[1]), sum(x[2]), sum(x[3]), sum(x[4])};
}

static void sum_regions(const ibl_bc6h_texels *t, const float b[N],
                        unsigned second, ibl_bc6h_sums sums[2][3])
{
    for (int c = 0; c < 3; c++) {
        sum_region(t, b, ~second, c, &sums[0][c]);
        if (second)
            sum_region(t, b, second, c, &sums[1][c]);
    }
}

/* Sums over a region of 1, y and its products: x y z, xx yy zz xy xz yz. */
enum {
    SUMS = 10
};

static void add_texel(const ibl_bc6h_texels *t, int i, float sums[SUMS])
{
    const float x = t->y[0][i], y = t->y[1][i], z = t->y[2][i];
    const float terms[SUMS] = {1,     x,     y,     z,     x * x,
                               y * y, z * z, x * y, x * z, y * z};
    for (int k = 0; k < SUMS; k++)
        sums[k] += terms[k];
}

static void multiply(const float m[6], const float v[3], float out[3])
{
    out[0] = m[0] * v[0] + m[3] * v[1] + m[4] * v[2];
    out[1] = m[3] * v[0] + m[1] * v[1] + m[5] * v[2];
    out[2] = m[4] * v[0] + m[5] * v[1] + m[2] * v[2];
}

/*
 * The longest axis of a region, by four steps of the power method from the
 * longest row of the covariances. What it does not explain is an error; of what
 * it does, even steps of 1/7 leave 1/49.
 */
static float guess_region(const float s[SUMS], float axis[3])
{
    const float scale = 1 / s[0];
    float m[6], v[3], w[3];
    for (int c = 0; c < 3; c++)
        m[c] = s[4 + c] - s[1 + c] * s[1 + c] * scale;
    m[3] = s[7] - s[1] * s[2] * scale;
    m[4] = s[8] - s[1] * s[3] * scale;
    m[5] = s[9] - s[2] * s[3] * scale;
    const float trace = m[0] + m[1] + m[2] + FLT_MIN, unit = 1 / trace;
    for (int i = 0; i < 6; i++)
        m[i] *= unit;
    const bool y = m[1] > m[0], z = m[2] > (y ? m[1] : m[0]);
    v[0] = z ? m[4] : y ? m[3] : m[0];
    v[1] = z ? m[5] : y ? m[1] : m[3];
    v[2] = z ? m[2] : y ? m[5] : m[4];
    multiply(m, v, w);
    multiply(m, w, v);
    multiply(m, v, w);
    multiply(m, w, axis);
    const float along = w[0] * axis[0] + w[1] * axis[1] + w[2] * axis[2];
    const float length = w[0] * w[0] + w[1] * w[1] + w[2] * w[2] + FLT_MIN;
    return trace * (1 - along / length * (48 / 49.0f));
}

/* What the first region has is what the second has not. */
static void guess(const ibl_bc6h_texels *t, ibl_bc6h_guesses *guesses)
{
    float all[SUMS] = {0};
    for (int i = 0; i < N; i++)
        add_texel(t, i, all);
    for (int p = 0; p < IBL_BC6H_PARTITIONS; p++) {
        float sums[2][SUMS] = {{0}}, axis[3];
        for (int i = 0; i < N; i++)
            if (ibl_bc6h_partitions[p] >> i & 1)
                add_texel(t, i, sums[1]);
        for (int k = 0; k < SUMS; k++)
            sums[0][k] = all[k] - sums[1][k];
        guesses->error[p] = 0;
        for (int r = 0; r < 2; r++) {
            guesses->error[p] += guess_region(sums[r], axis);
            for (int c = 0; c < 3; c++)
                guesses->axis[r][c][p] = axis[c];
        }
    }
}

const ibl_bc6h_fit ibl_bc6h_fit_c = {assign, sum_regions, guess};
