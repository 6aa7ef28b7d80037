/* SPDX-License-Identifier: MIT */
#include "kern/octant_sums.h"

static void collect(const float *row, const int *offset, int count,
                    double *pixels)
{
    for (int i = 0; i < count; i++) {
        for (int m = 0; m < IBL_OCTANTS; m++) {
            for (int c = 0; c < 3; c++)
                pixels[c * IBL_OCTANTS + m] = (double)row[offset[m] + c];
        }
        offset += IBL_OCTANTS;
        pixels += IBL_OCTANT_RGB;
    }
}

static void blend_one(const ibl_octant_blend *row, int column, double *rgb)
{
    const float *at[4];
    double weight[4];

    for (int k = 0; k < 2; k++) {
        int x = column + row->turn[k];
        x -= x >= row->columns ? row->columns : 0;
        const ibl_octant_tap *tap = &row->taps[x];
        at[2 * k] = row->source[k] + tap->at[0];
        at[2 * k + 1] = row->source[k] + tap->at[1];
        weight[2 * k + 1] = row->weight[k] * tap->weight;
        weight[2 * k] = row->weight[k] - weight[2 * k + 1];
    }
    for (int c = 0; c < 3; c++)
        rgb[c * IBL_OCTANTS] =
            weight[0] * (double)at[0][c] + weight[1] * (double)at[1][c] +
            (weight[2] * (double)at[2][c] + weight[3] * (double)at[3][c]);
}

static void blend(const ibl_octant_blend *row, const int *column, int count,
                  int lanes, double *pixels)
{
    for (int i = 0; i < count; i++) {
        for (int m = 0; m < lanes; m++)
            blend_one(row, column[m], pixels + m);
        column += IBL_OCTANTS;
        pixels += IBL_OCTANT_RGB;
    }
}

static void add_spans(const ibl_octant_span *spans, int count,
                      const double *pixels, double *sums)
{
    for (const ibl_octant_span *s = spans; s < spans + count; s++) {
        const double *first = pixels + IBL_OCTANT_RGB * (size_t)s->pixel;
        double *sum = sums + IBL_OCTANT_RGB * (size_t)s->slot;
        for (int k = 0; k < IBL_OCTANT_RGB; k++) {
            double run = first[k];
            for (int i = 1; i < s->count; i++)
                run += first[IBL_OCTANT_RGB * i + k];
            sum[k] += s->weight * run;
        }
    }
}

static void write_sums(const double *sums, const double *weights, int count,
                       float *const out[IBL_OCTANTS],
                       const ptrdiff_t step[IBL_OCTANTS])
{
    for (int i = 0; i < count; i++) {
        const double scale = 1 / weights[i];
        for (int m = 0; m < IBL_OCTANTS; m++) {
            for (int c = 0; c < 3; c++)
                out[m][i * step[m] + c] =
                    (float)(sums[c * IBL_OCTANTS + m] * scale);
        }
        sums += IBL_OCTANT_RGB;
    }
}

IBL_KERNEL(ibl_octants, collect, blend, add_spans, write_sums)
