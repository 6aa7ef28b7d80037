/* SPDX-License-Identifier: MIT */
#include "bake/spectral/lights.h"

#include <math.h>
#include <stddef.h>
#include <string.h>

#include "core/pi.h"

enum {
    LANES = 4,        /* pixels at a time: their results stay in registers */
    OUTSHINE = 64,    /* times the mean of the other pixels */
    AT_EQUATOR = 256, /* most lights of a group there */
    MOST_STEPS = 40
};

/* ---- range ------------------------------------------------------------- */

/* Results for each float of LANES pixels. */
typedef struct lanes {
    float low[3 * LANES], high[3 * LANES];
    float sum[3 * LANES]; /* of a row */
} lanes;

static void add_float(const float *rgb, int k, lanes *s)
{
    const float v = rgb[k];
    s->low[k] = v < s->low[k] ? v : s->low[k];
    s->high[k] = v > s->high[k] ? v : s->high[k];
    s->sum[k] += v;
}

/* If gcc 12 inlines it, the sums do not stay in registers. */
__attribute__((noinline)) static void add_pixels(const float *rgb, int pixels,
                                                 lanes *to)
{
    const int blocks = pixels / LANES;
    lanes s = *to;

    for (int b = 0; b < blocks; b++, rgb += 3 * LANES)
#pragma GCC unroll 3
        for (int at = 0; at < 3 * LANES; at += LANES)
            for (int k = at; k < at + LANES; k++)
                add_float(rgb, k, &s);
    for (int k = 0; k < 3 * (pixels - blocks * LANES); k++)
        add_float(rgb, k, &s);
    *to = s;
}

void ibl_row_range_of(const float *rgb, int width, int rows,
                      ibl_row_range *range)
{
    double total[3] = {0};
    lanes s = {.high = {0}};

    for (int k = 0; k < 3 * LANES; k++)
        s.low[k] = INFINITY;
    for (int j = 0; j < rows; j++) {
        memset(s.sum, 0, sizeof s.sum);
        add_pixels(rgb + 3 * (size_t)width * (size_t)j, width, &s);
        for (int k = 0; k < 3 * LANES; k++)
            total[k % 3] += (double)s.sum[k];
    }
    for (int c = 0; c < 3; c++) {
        range->low[c] = s.low[c];
        range->high[c] = s.high[c];
        for (int k = c; k < 3 * LANES; k += 3) {
            range->low[c] = fminf(range->low[c], s.low[k]);
            range->high[c] = fmaxf(range->high[c], s.high[k]);
        }
        /* A row of the largest floats. */
        if (!isfinite(total[c])) {
            total[c] = 0;
            for (int k = c; k < 3 * width * rows; k += 3)
                total[c] += (double)rgb[k];
        }
        range->mean[c] = total[c] / width / rows;
    }
}

/* ---- lights ------------------------------------------------------------ */

static double sum_of(const double v[3])
{
    return v[0] + v[1] + v[2];
}

static double brightness(const float *p)
{
    return (double)p[0] + (double)p[1] + (double)p[2];
}

int ibl_lights_most(int height, int first_row, int rows)
{
    const double middle = IBL_PI * (first_row + 0.5 * rows) / height;
    return (int)fmin(AT_EQUATOR / sin(middle), IBL_LIGHTS_GROUP);
}

bool ibl_lights_any(const ibl_row_range *r, size_t pixels, int most)
{
    /* The most that can be taken, and the least mean of the rest. */
    const double high = brightness(r->high);
    const double taken = most * high / (double)pixels;
    return high > brightness(r->low) &&
           high > OUTSHINE * (sum_of(r->mean) - taken);
}

/* The pixels above a brightness, and the rest. */
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

/* The lowest of some thresholds above which all pixels outshine the rest and
 * are not too many; infinite if there is none. */
static double find_threshold(const float *rgb, size_t pixels,
                             const ibl_row_range *range, int most)
{
    double at = brightness(range->high) / 2, found = INFINITY;
    for (int step = 0; step < MOST_STEPS; step++, at /= 2) {
        const struct split s = split_at(rgb, pixels, range, at);
        if (s.above > (size_t)most || s.above > pixels / 2)
            break;
        if (at > OUTSHINE * s.rest)
            found = at;
        else if (found < INFINITY)
            break;
        if (s.rest <= 0)
            break;
    }
    return found;
}

/* The mean of a group's other pixels. */
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
                    const ibl_row_range *range, int most,
                    ibl_pixel_light *lights)
{
    const size_t w = (size_t)width, pixels = w * (size_t)rows;
    const double threshold = find_threshold(rgb, pixels, range, most);
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
