/* SPDX-License-Identifier: MIT */
/* Texels are lanes; in split and match, patterns and blocks are. */
#include "kern/astc_fit.h"
#include "kern/lanes.h"

enum {
    VECTORS = 16 / VF
};

/* The sum of 16 values: halves are added until one is left. */
static inline float sum_of(const vf v[VECTORS])
{
    const vq four = vf_fold_16(v);
    return (four[0] + four[2]) + (four[1] + four[3]);
}

static void project(const ibl_astc_texels *t, const float ends[2][3],
                    float s[16])
{
    const vf zero = vf_all(0), one = vf_all(1);

    for (int i = 0; i < 16; i += VF) {
        vf along = zero, length = vf_all(0x1p-100f);
        for (int c = 0; c < 3; c++) {
            const vf way = vf_all(ends[1][c] - ends[0][c]);
            const vf w = vf_load(&t->weight[c][i]) * way;
            along += w * (vf_load(&t->q[c][i]) - vf_all(ends[0][c]));
            length += w * way;
        }
        const vf part = along / length;
        vf_store(s + i, vf_min(vf_max(part, zero), one));
    }
}

static void sums(const ibl_astc_texels *t, const float s[16],
                 ibl_astc_sums out[3])
{
    for (int c = 0; c < 3; c++) {
        vf aa[VECTORS], ab[VECTORS], bb[VECTORS], a[VECTORS], b[VECTORS];
        for (int k = 0; k < VECTORS; k++) {
            const vf at = vf_load(s + VF * k);
            const vf q = vf_load(&t->q[c][VF * k]);
            const vf w = vf_load(&t->weight[c][VF * k]);
            const vf wb = w * at, wa = w - wb;
            ab[k] = wa * at;
            aa[k] = wa - ab[k];
            bb[k] = wb * at;
            a[k] = wa * q;
            b[k] = wb * q;
        }
        out[c] = (ibl_astc_sums){sum_of(aa), sum_of(ab), sum_of(bb), sum_of(a),
                                 sum_of(b)};
    }
}

#define VI_ALL(x) ((vi)vf_all(0) + (x))

static vf widen(vi half)
{
    const vi bits = (half << 13) + (112 << 23);
    const vf denormal = (vf)(bits + (1 << 23)) - vf_all(0x1p-14f);
    return vf_either(half < 0x400, denormal, (vf)bits);
}

/* As ibl_astc_half. */
static vi half_of(vi q)
{
    const vi m = q & 2047;
    const vi low = 3 * m, mid = 4 * m - 512, high = 5 * m - 2048;
    const vi mantissa =
        (vi)vf_either(m < 512, (vf)low, vf_either(m < 1536, (vf)mid, (vf)high));
    const vi raw = (q >> 11 << 10) | mantissa >> 3;
    return (vi)vf_either(raw < 0x7C00, (vf)raw, (vf)VI_ALL(0x7BFF));
}

static inline float errors(const ibl_astc_texels *t, const int ends[2][3],
                           const int steps[16], int bc6h)
{
    vf sum[VECTORS];

    for (int k = 0; k < VECTORS; k++) {
        const vi step =
            (vi)vf_load((const float *)(const void *)steps + VF * k);
        vf squares = vf_all(0);
        for (int c = 0; c < 3; c++) {
            /* Both are below 2^16 and 2^7: floats hold their product. */
            const vf way = vf_all((float)(ends[1][c] - ends[0][c]));
            const vi from = VI_ALL(ends[0][c] * 64 + 32);
            const vf product = way * __builtin_convertvector(step, vf);
            const vi q = (from + __builtin_convertvector(product, vi)) >> 6;
            const vi half = bc6h ? q * 31 >> 6 : half_of(q);
            const vf d = widen(half) - vf_load(&t->light[c][VF * k]);
            squares += d * d;
        }
        sum[k] = squares * vf_load(t->share + VF * k);
    }
    return sum_of(sum);
}

static float error(const ibl_astc_texels *t, const int ends[2][3],
                   const int steps[16])
{
    return errors(t, ends, steps, 0);
}

static float error_bc6h(const ibl_astc_texels *t, const int ends[2][3],
                        const int steps[16])
{
    return errors(t, ends, steps, 1);
}

static void split(const float points[3][16],
                  const float second[16][IBL_ASTC_PATTERNS_PADDED],
                  const float count[IBL_ASTC_PATTERNS_PADDED],
                  float gain[IBL_ASTC_PATTERNS_PADDED])
{
    for (int p = 0; p < IBL_ASTC_PATTERNS_PADDED; p += VF) {
        const vf n = vf_load(count + p), others = vf_all(16) - n;
        vf sum = vf_all(0);
        for (int c = 0; c < 3; c++) {
            vf all = vf_all(0), part = vf_all(0);
            for (int i = 0; i < 16; i++) {
                const vf point = vf_all(points[c][i]);
                all += point;
                part += point * vf_load(&second[i][p]);
            }
            const vf rest = all - part;
            sum += part * part / n + rest * rest / others;
        }
        vf_store(gain + p, sum);
    }
}

static void match(const ibl_astc_texels *t,
                  const float places[16][IBL_ASTC_PAST], int count,
                  float gain[IBL_ASTC_PAST])
{
    float x[3][16], inverse[3];

    for (int c = 0; c < 3; c++)
        inverse[c] = ibl_astc_centre(t, c, x[c]);
    for (int k = 0; k < count; k += VF) {
        vf sum = vf_all(0);
        for (int c = 0; c < 3; c++) {
            vf one = vf_all(0), two = vf_all(0), both = vf_all(0);
            for (int i = 0; i < 16; i++) {
                const vf p = vf_load(&places[i][k]);
                const vf wp = vf_all(t->weight[c][i]) * p;
                one += wp;
                two += wp * p;
                both += vf_all(x[c][i]) * p;
            }
            const vf apart = two - one * one * vf_all(inverse[c]);
            sum += both * both / vf_max(apart, vf_all(1e-20f));
        }
        vf_store(gain + k, sum);
    }
}

static const ibl_astc_fit_dsp fit = {project,    sums,  error,
                                     error_bc6h, split, match};

static void encode(const float *texels, size_t count, ibl_quality quality,
                   unsigned char *blocks)
{
    ibl_astc_hdr_encode(&fit, texels, count, quality, NULL, blocks);
}

static void encode_alike(const float *texels, size_t count, ibl_quality quality,
                         ibl_astc_past *past, unsigned char *blocks)
{
    ibl_astc_hdr_encode(&fit, texels, count, quality, past, blocks);
}

IBL_VECTOR_KERNEL(ibl_astc_hdr, encode, encode_alike)
