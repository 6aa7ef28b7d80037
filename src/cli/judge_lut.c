/* SPDX-License-Identifier: MIT */
#include <math.h>
#include <stdlib.h>

#include "cli/judge.h"

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

static bool judge_texel(ibl_ctx *ctx, const ibl_lut *lut, ibl_pixel pixel,
                        ibl_geometry geometry, line u, line v,
                        ibl_lut_verdict *out)
{
    const float *x =
        lut->data + 2 * ((size_t)v.at * (size_t)lut->size + (size_t)u.at);
    const double n_dot_v = (u.at + 0.5) / lut->size;
    const double roughness = (v.at + 0.5) / lut->size;
    const double weight = (double)u.weight * v.weight;
    double truth[2], loss[2];

    if (ibl_reference_lut(ctx, n_dot_v, roughness, geometry, truth))
        return false;
    if (!isfinite(x[0]) || !isfinite(x[1]))
        return true;
    ibl_judge_loss(pixel, 1, truth, 2, loss);
    for (int c = 0; c < 2; c++) {
        const double off = fabs((double)x[c] - truth[c]);
        if (out->count == 0 || off > out->max) {
            out->max = off;
            out->worst_n_dot_v = n_dot_v;
            out->worst_roughness = roughness;
        }
        out->rms += weight / 2 * off * off;
        out->rounding += weight / 2 * loss[c] * loss[c];
    }
    out->count++;
    return true;
}

bool ibl_judge_lut(ibl_ctx *ctx, const ibl_lut *lut, ibl_pixel pixel,
                   ibl_geometry geometry, const ibl_judge_options *opts,
                   ibl_lut_verdict *out)
{
    const int n = lut->size;
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
            !isfinite(lut->data[2 * i]) || !isfinite(lut->data[2 * i + 1]);
    free(u);
    free(v);
    return ok;
}
