/* SPDX-License-Identifier: MIT */
#include "kern/astc_fit.h"

#include "core/half.h"
#include "kern/astc_hdr_endpoints.h"

/* The order of addition of a vector version of any width. */
static float sum_of(float v[16])
{
    for (int n = 8; n; n /= 2)
        for (int i = 0; i < n; i++)
            v[i] += v[i + n];
    return v[0];
}

static void project(const ibl_astc_texels *t, const float ends[2][3],
                    float s[16])
{
    float way[3];

    for (int c = 0; c < 3; c++)
        way[c] = ends[1][c] - ends[0][c];
    for (int i = 0; i < 16; i++) {
        float along = 0, length = 0x1p-100f;
        for (int c = 0; c < 3; c++) {
            const float w = t->weight[c][i] * way[c];
            along += w * (t->q[c][i] - ends[0][c]);
            length += w * way[c];
        }
        const float part = along / length;
        s[i] = !(part > 0) ? 0 : part < 1 ? part : 1;
    }
}

static void sums(const ibl_astc_texels *t, const float s[16],
                 ibl_astc_sums out[3])
{
    for (int c = 0; c < 3; c++) {
        float aa[16], ab[16], bb[16], a[16], b[16];
        for (int i = 0; i < 16; i++) {
            const float w = t->weight[c][i], wb = w * s[i], wa = w - wb;
            ab[i] = wa * s[i];
            aa[i] = wa - ab[i];
            bb[i] = wb * s[i];
            a[i] = wa * t->q[c][i];
            b[i] = wb * t->q[c][i];
        }
        out[c] = (ibl_astc_sums){sum_of(aa), sum_of(ab), sum_of(bb), sum_of(a),
                                 sum_of(b)};
    }
}

static float errors(const ibl_astc_texels *t, const int ends[2][3],
                    const int steps[16], int bc6h)
{
    float sum[16];

    for (int i = 0; i < 16; i++) {
        float squares = 0;
        for (int c = 0; c < 3; c++) {
            const int q =
                (ends[0][c] * 64 + (ends[1][c] - ends[0][c]) * steps[i] + 32) >>
                6;
            const uint16_t half =
                bc6h ? (uint16_t)(q * 31 >> 6) : ibl_astc_half(q);
            const float d = ibl_half_to_float(half) - t->light[c][i];
            squares += d * d;
        }
        sum[i] = squares * t->share[i];
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
    for (int p = 0; p < IBL_ASTC_PATTERNS_PADDED; p++) {
        gain[p] = 0;
        for (int c = 0; c < 3; c++) {
            float all = 0, part = 0;
            for (int i = 0; i < 16; i++) {
                all += points[c][i];
                part += points[c][i] * second[i][p];
            }
            const float rest = all - part;
            gain[p] += part * part / count[p] + rest * rest / (16 - count[p]);
        }
    }
}

static void match(const ibl_astc_texels *t,
                  const float places[16][IBL_ASTC_PAST], int count,
                  float gain[IBL_ASTC_PAST])
{
    for (int k = 0; k < count; k++)
        gain[k] = 0;
    for (int c = 0; c < 3; c++) {
        float x[16];
        const float inverse = ibl_astc_centre(t, c, x);
        for (int k = 0; k < count; k++) {
            float one = 0, two = 0, both = 0;
            for (int i = 0; i < 16; i++) {
                const float p = places[i][k], wp = t->weight[c][i] * p;
                one += wp;
                two += wp * p;
                both += x[i] * p;
            }
            const float apart = two - one * one * inverse;
            gain[k] += both * both / (apart > 1e-20f ? apart : 1e-20f);
        }
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

IBL_KERNEL(ibl_astc_hdr, encode, encode_alike)
