/* SPDX-License-Identifier: MIT */
#include "bake/spectral/lights.h"

#include <math.h>
#include <stddef.h>

enum {
    LANES = 16, /* pixels looked at together, for the vectoriser */
    OUTSHINE = 64
};

/* ---- range ------------------------------------------------------------- */

/* Sums of the largest floats stay floats. */
static const float small = 0x1p-24f;

static void look(float v, float *low, float *high, float *sum)
{
    *low = v < *low ? v : *low;
    *high = v > *high ? v : *high;
    *sum += v * small;
}

void ibl_row_range_of(const float *rgb, int width, int rows,
                      ibl_row_range *range)
{
    const size_t pixels = (size_t)width * (size_t)rows;
    const size_t blocks = pixels / LANES;
    float low[3 * LANES], high[3 * LANES], sum[3 * LANES];
    double total[3] = {0};

    for (int k = 0; k < 3 * LANES; k++) {
        low[k] = INFINITY;
        high[k] = sum[k] = 0;
    }
    for (size_t b = 0; b < blocks; b++, rgb += 3 * LANES)
        for (int k = 0; k < 3 * LANES; k++)
            look(rgb[k], &low[k], &high[k], &sum[k]);
    for (size_t i = 0; i < 3 * (pixels - blocks * LANES); i++)
        look(rgb[i], &low[i], &high[i], &sum[i]);
    for (int k = 0; k < 3 * LANES; k++) {
        const int c = k % 3;
        if (k < 3 || low[k] < range->low[c])
            range->low[c] = low[k];
        if (k < 3 || high[k] > range->high[c])
            range->high[c] = high[k];
        total[c] += (double)sum[k];
    }
    for (int c = 0; c < 3; c++)
        range->mean[c] = total[c] / (double)small / (double)pixels;
}

double ibl_row_squares(const float *rgb, int width, const float base[3],
                       const ibl_row_range *range)
{
    const size_t pixels = (size_t)width, blocks = pixels / LANES;
    float most = 0x1p-100f;
    for (int c = 0; c < 3; c++)
        most = fmaxf(most, fmaxf(range->high[c], base[c]));
    /* Nothing is above 1, nor is its square. */
    const float scale = 1 / most;
    float sum[3 * LANES] = {0}, from[3 * LANES];
    double total = 0;

    for (int k = 0; k < 3 * LANES; k++)
        from[k] = base[k % 3];
    for (size_t b = 0; b < blocks; b++, rgb += 3 * LANES)
        for (int k = 0; k < 3 * LANES; k++) {
            const float v = (rgb[k] - from[k]) * scale;
            sum[k] += v * v;
        }
    for (size_t i = 0; i < 3 * (pixels - blocks * LANES); i++) {
        const float v = (rgb[i] - from[i]) * scale;
        sum[i] += v * v;
    }
    for (int k = 0; k < 3 * LANES; k++)
        total += (double)sum[k];
    return total * (double)most * (double)most;
}

/* ---- lights ------------------------------------------------------------ */

/* What a mean may lack: half the last bit of what is smallest in sums. */
static const double lost = 0x1p-126;

static bool is_above(const float *p, const ibl_row_range *r, double times)
{
    for (int c = 0; c < 3; c++)
        if ((double)p[c] > times * (r->mean[c] + lost))
            return true;
    return false;
}

bool ibl_lights_any(const ibl_row_range *r)
{
    return is_above(r->high, r, OUTSHINE);
}

static size_t count_above(const float *rgb, size_t pixels,
                          const ibl_row_range *r, double times)
{
    size_t count = 0;
    for (size_t i = 0; i < pixels; i++)
        count += is_above(rgb + 3 * i, r, times);
    return count;
}

/* What a group's other pixels are on average. */
static void mean_without(const ibl_row_range *range, size_t pixels,
                         const ibl_pixel_light *lights, int count,
                         float rest[3])
{
    for (int c = 0; c < 3; c++) {
        double sum = range->mean[c] * (double)pixels;
        for (int i = 0; i < count; i++)
            sum -= (double)lights[i].rgb[c];
        rest[c] = (float)fmax(sum / (double)(pixels - (size_t)count),
                              (double)range->low[c]);
    }
}

int ibl_lights_take(float *rgb, int width, int rows, int first_row,
                    const ibl_row_range *range, ibl_pixel_light *lights)
{
    const size_t w = (size_t)width, pixels = w * (size_t)rows;
    double times = OUTSHINE;
    float rest[3];
    int count = 0;

    while (count_above(rgb, pixels, range, times) > IBL_LIGHTS_GROUP)
        times *= 1.5;
    for (size_t i = 0; i < pixels; i++) {
        const float *p = rgb + 3 * i;
        if (is_above(p, range, times))
            lights[count++] = (ibl_pixel_light){.row = first_row + (int)(i / w),
                                                .column = (int)(i % w),
                                                .rgb = {p[0], p[1], p[2]}};
    }
    mean_without(range, pixels, lights, count, rest);
    for (int k = 0; k < count; k++) {
        ibl_pixel_light *l = &lights[k];
        const size_t row = (size_t)(l->row - first_row);
        float *p = rgb + 3 * (row * w + (size_t)l->column);
        for (int c = 0; c < 3; c++) {
            l->rgb[c] -= rest[c];
            p[c] = rest[c];
        }
    }
    return count;
}
