/* SPDX-License-Identifier: MIT */
#include "bake/spectral/lights.h"

#include <math.h>
#include <stddef.h>

enum {
    LANES = 16,    /* pixels looked at together, for the vectoriser */
    OUTSHINE = 64, /* times the mean of the others */
    MOST_STEPS = 40
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

static double sum_of(const double v[3])
{
    return v[0] + v[1] + v[2];
}

static double brightness(const float *p)
{
    return (double)p[0] + (double)p[1] + (double)p[2];
}

bool ibl_lights_any(const ibl_row_range *r, size_t pixels)
{
    /* At the most, and the mean that the others then have at the least. */
    const double high = brightness(r->high);
    const double taken = IBL_LIGHTS_GROUP * high / (double)pixels;
    return high > brightness(r->low) &&
           high > OUTSHINE * (sum_of(r->mean) + lost - taken);
}

/* Pixels above a brightness, and what is left to the others. */
struct split {
    size_t above;
    double rest; /* mean of the others */
};

static struct split split_at(const float *rgb, size_t pixels,
                             const ibl_row_range *range, double threshold)
{
    struct split s = {0};
    double sum = sum_of(range->mean) * (double)pixels;
    for (size_t i = 0; i < pixels; i++) {
        const double b = brightness(rgb + 3 * i);
        s.above += b > threshold;
        sum -= b > threshold ? b : 0;
    }
    if (s.above < pixels)
        s.rest = sum / (double)(pixels - s.above);
    return s;
}

/* The lowest of some thresholds above which all pixels outshine the others,
 * and are not too many; infinite if there is none. */
static double find_threshold(const float *rgb, size_t pixels,
                             const ibl_row_range *range)
{
    double at = brightness(range->high) / 2, found = INFINITY;
    for (int step = 0; step < MOST_STEPS; step++, at /= 2) {
        const struct split s = split_at(rgb, pixels, range, at);
        if (s.above > IBL_LIGHTS_GROUP || s.above > pixels / 2)
            break;
        if (at > OUTSHINE * (s.rest + lost))
            found = at;
        else if (found < INFINITY)
            break;
        if (s.rest <= lost)
            break;
    }
    return found;
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
    const double threshold = find_threshold(rgb, pixels, range);
    float rest[3];
    int count = 0;

    for (size_t i = 0; i < pixels; i++) {
        const float *p = rgb + 3 * i;
        if (brightness(p) > threshold)
            lights[count++] = (ibl_pixel_light){.row = first_row + (int)(i / w),
                                                .column = (int)(i % w),
                                                .rgb = {p[0], p[1], p[2]}};
    }
    if (!count)
        return 0;
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
