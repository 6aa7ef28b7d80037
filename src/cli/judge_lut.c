/* SPDX-License-Identifier: MIT */
#include <math.h>
#include <stdlib.h>

#include "cli/judge.h"
#include "cli/lookup.h"

/* A row or column of the table and how many of them it represents. */
typedef struct line {
    int at;
    int weight;
} line;

/*
 * Picks the first and last of n lines, where the integrals change fastest, and
 * one from each of `parts` equal stretches between them; all lines if parts >=
 * n - 2. Returns their number.
 */
static int pick_lines(int n, int parts, int seed, int stream, line *lines)
{
    const int between = n - 2;
    int count = 0;

    if (parts >= between) {
        for (int i = 0; i < n; i++)
            lines[count++] = (line){i, 1};
        return count;
    }
    lines[count++] = (line){0, 1};
    for (int i = 0; i < parts; i++) {
        const int from = 1 + (int)((long long)i * between / parts);
        const int to = 1 + (int)((i + 1LL) * between / parts);
        const double u = ibl_pick_random(seed, (unsigned)stream, (unsigned)i);
        lines[count++] = (line){from + (int)(u * (to - from)), to - from};
    }
    lines[count++] = (line){n - 1, 1};
    return count;
}

/* The integrals that the table's channels are of. */
static bool find_truth(ibl_ctx *ctx, ibl_lut_kind kind, double n_dot_v,
                       double roughness, ibl_geometry geometry, double truth[3])
{
    double sheen[2] = {0}, split[2] = {0};

    if (kind && ibl_reference_sheen(ctx, n_dot_v, roughness, sheen))
        return false;
    if (kind != IBL_LUT_CHARLIE &&
        ibl_reference_lut(ctx, n_dot_v, roughness, geometry, split))
        return false;
    if (kind == IBL_LUT_MULTISCATTER) {
        truth[0] = split[1];
        truth[1] = split[0] + split[1];
        truth[2] = sheen[0];
    } else {
        truth[0] = kind ? sheen[0] : split[0];
        truth[1] = kind ? sheen[1] : split[1];
    }
    return true;
}

static bool is_finite(const float *texel, int channels)
{
    bool finite = true;

    for (int c = 0; c < channels; c++)
        finite = finite && isfinite(texel[c]);
    return finite;
}

static bool judge_texel(ibl_ctx *ctx, const ibl_lut *lut, ibl_pixel pixel,
                        ibl_geometry geometry, line u, line v,
                        ibl_lut_verdict *out)
{
    const int channels = ibl_lut_channels(lut->kind);
    const float *x =
        lut->data +
        (size_t)channels * ((size_t)v.at * (size_t)lut->size + (size_t)u.at);
    const double n_dot_v = (u.at + 0.5) / lut->size;
    const double roughness = (v.at + 0.5) / lut->size;
    const double weight = (double)u.weight * v.weight;
    double truth[3], loss[3];

    if (!find_truth(ctx, lut->kind, n_dot_v, roughness, geometry, truth))
        return false;
    if (!is_finite(x, channels))
        return true;
    ibl_judge_loss(pixel, 1, truth, channels, loss);
    for (int c = 0; c < channels; c++) {
        const double unit = fmax(truth[c], 1);
        const double off = fabs((double)x[c] - truth[c]) / unit;
        if (out->count == 0 || off > out->max) {
            out->max = off;
            out->worst_n_dot_v = n_dot_v;
            out->worst_roughness = roughness;
        }
        out->rms += weight / channels * off * off;
        out->rounding += weight / channels * loss[c] * loss[c] / (unit * unit);
    }
    out->count++;
    return true;
}

bool ibl_judge_lut(ibl_ctx *ctx, const ibl_lut *lut, ibl_pixel pixel,
                   ibl_geometry geometry, const ibl_judge_options *opts,
                   ibl_lut_verdict *out)
{
    const int n = lut->size, channels = ibl_lut_channels(lut->kind);
    const size_t texels = (size_t)n * (size_t)n;
    const int parts = opts->all ? n : (int)sqrt(opts->texels / 2.0) - 1;
    line *u = malloc((size_t)n * sizeof *u), *v = malloc((size_t)n * sizeof *v);
    bool ok = u && v;
    double total = 0;

    *out = (ibl_lut_verdict){.size = n};
    const int columns = ok ? pick_lines(n, parts, opts->seed, 0, u) : 0;
    const int rows = ok ? pick_lines(n, parts, opts->seed, 1, v) : 0;
    for (int j = 0; j < rows; j++)
        for (int i = 0; i < columns && ok; i++) {
            ok = judge_texel(ctx, lut, pixel, geometry, u[i], v[j], out);
            total += (double)u[i].weight * v[j].weight;
        }
    out->rms = sqrt(out->rms / total);
    out->rounding = sqrt(out->rounding / total);
    for (size_t i = 0; i < texels; i++)
        out->nonfinite +=
            !is_finite(lut->data + (size_t)channels * i, channels);
    free(u);
    free(v);
    return ok;
}
