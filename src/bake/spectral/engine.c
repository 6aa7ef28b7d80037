/* SPDX-License-Identifier: MIT */
#include "bake/spectral/engine.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/alloc.h"
#include "core/context.h"
#include "core/pi.h"

enum {
    GROUP = IBL_ROW_GROUP
};

/* Least share of the map's energy of a light that is added to texels. */
static const double least_share = 1e-4;

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

/* Finds the range of `rows` rows of `width` pixels, at most 2^31 floats. */
static void find_range(const float *rgb, int width, int rows,
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

/* ---- pixels that outshine the rows around them ------------------------- */

static double sum_of(const double v[3])
{
    return v[0] + v[1] + v[2];
}

static double brightness(const float *p)
{
    return (double)p[0] + (double)p[1] + (double)p[2];
}

/* Most lights that are taken out of rows: 256 at the equator, and as many more
 * towards a pole as pixels are narrower, up to IBL_LIGHTS_GROUP.
 *   height     rows of the map
 *   first_row  the first row's index in the map */
static int lights_most(int height, int first_row, int rows)
{
    const double middle = IBL_PI * (first_row + 0.5 * rows) / height;
    return (int)fmin(AT_EQUATOR / sin(middle), IBL_LIGHTS_GROUP);
}

/* Whether a group of that many pixels may contain lights, `most` at most. */
static bool lights_any(const ibl_row_range *r, size_t pixels, int most)
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

/*
 * Takes the brightest pixels out of rows, if each is 64 times as bright as the
 * mean of the rest, which replaces them. Returns their number.
 *   first_row  the first row's index in the map
 *   lights     room for `most`
 */
static int lights_take(float *rgb, int width, int rows, int first_row,
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

/* ---- create ------------------------------------------------------------ */

static size_t group_floats(const ibl_spectral *s)
{
    return (3 * (size_t)s->width * GROUP + 15) / 16 * 16;
}

static int rows_of(const ibl_spectral *s, int group)
{
    const int left = s->height - group * GROUP;
    return left < GROUP ? left : GROUP;
}

static int most_lights(const ibl_spectral *s, int group)
{
    return lights_most(s->height, group * GROUP, rows_of(s, group));
}

static ibl_status allocate(ibl_spectral *s)
{
    ibl_spectral_reading *r = &s->reading;
    const size_t groups = (size_t)s->groups;
    const size_t threads = (size_t)ibl_ctx_threads(s->ctx);
    const size_t scratch = ibl_row_fft_scratch(r->azimuth);

    s->weight = ibl_alloc_array((size_t)s->height, sizeof *s->weight);
    s->widths = ibl_alloc_array((size_t)s->degree + 1, sizeof *s->widths);
    s->power = ibl_alloc_array((size_t)s->degree + 1, sizeof *s->power);
    r->group = ibl_alloc_zeroed(groups, sizeof *r->group);
    /* Those at the poles have most. */
    r->room = (size_t)fmax(most_lights(s, 0), most_lights(s, s->groups - 1));
    r->taken = ibl_alloc_sparse(groups, r->room * sizeof *r->taken);
    r->worker_floats = (scratch + 15) / 16 * 16 + group_floats(s);
    r->scratch = ibl_alloc_array(threads * r->worker_floats, sizeof(float));
    if (!s->weight || !s->widths || !s->power || !r->group || !r->taken ||
        !r->scratch)
        return ibl_no_memory(s->ctx, "the analysis");
    return ibl_row_spectra_alloc(s->ctx, s->height, s->degree, &r->rows);
}

/* Fills the solid angles of each row's pixels, as a product without
 * cancellation, and the integrals of e^(-i m phi) over a pixel's width. */
static void fill_weights(const ibl_spectral *s)
{
    for (int j = 0; j < s->height; j++)
        s->weight[j] = 4 * IBL_PI / s->width *
                       sin(IBL_PI * (j + 0.5) / s->height) *
                       sin(0.5 * IBL_PI / s->height);
    s->widths[0] = 2 * IBL_PI / s->width;
    for (int m = 1; m <= s->degree; m++)
        s->widths[m] =
            2 / (double)m * sin(IBL_PI * (m % (2 * s->width)) / s->width);
}

ibl_status ibl_spectral_create(ibl_ctx *ctx, int width, int height,
                               double yaw_deg, int degree, int single,
                               ibl_spectral **out)
{
    ibl_spectral *s = ibl_alloc_zeroed(1, sizeof *s);
    *out = NULL;
    if (!s)
        return ibl_no_memory(ctx, "the analysis");
    s->ctx = ctx;
    s->width = width;
    s->height = height;
    s->degree = degree;
    s->single = single;
    s->groups = (height + GROUP - 1) / GROUP;
    s->yaw = (yaw_deg - 360 * floor(yaw_deg / 360)) / 180 * IBL_PI;
    ibl_status status =
        ibl_row_fft_create(ctx, width, degree + 1, s->yaw, &s->reading.azimuth);
    if (!status)
        status = allocate(s);
    if (status) {
        ibl_spectral_free(s);
        return status;
    }
    fill_weights(s);
    *out = s;
    return IBL_OK;
}

static void free_reading(ibl_spectral_reading *r)
{
    ibl_row_fft_free(r->azimuth);
    ibl_row_spectra_free(&r->rows);
    ibl_free(r->scratch);
    ibl_free(r->group);
    ibl_free(r->taken);
    *r = (ibl_spectral_reading){0};
}

void ibl_spectral_free(ibl_spectral *s)
{
    if (!s)
        return;
    free_reading(&s->reading);
    ibl_free(s->weight);
    ibl_free(s->widths);
    ibl_free(s->power);
    ibl_free(s->lights);
    ibl_harmonics_free(&s->harmonics);
    ibl_free(s);
}

/* ---- rows -------------------------------------------------------------- */

/* Takes the lights out of a copy, which replaces the group's rows. */
static void take_lights(const ibl_spectral *s, ibl_row_fft_rows *in, int number,
                        float *copy)
{
    ibl_spectral_group *group = &s->reading.group[number];

    memcpy(copy, in->rgb, in->stride * (size_t)in->count * sizeof *copy);
    in->rgb = copy;
    group->lights =
        lights_take(copy, s->width, in->count, number * GROUP, &group->range,
                    most_lights(s, number),
                    s->reading.taken + (size_t)number * s->reading.room);
}

/*
 * Sums of the largest floats must not overflow, and those of denormals must
 * keep their digits: a peak beyond 2^64 is scaled by 2^-64, one below 2^-64 by
 * 2^64. Returns the exponent of 2.
 */
static int scale_of(const float high[3])
{
    const float peak = fmaxf(fmaxf(high[0], high[1]), high[2]);
    return peak > 0x1p64f ? -64 : peak > 0 && peak < 0x1p-64f ? 64 : 0;
}

/* A pixel of this solid angle is no light: it is cut at the horizon of many
 * texels, in many parts, and the harmonics hold it. */
static const double largest_light = 0.05;

static bool has_lights(const ibl_spectral *s, int group)
{
    const double pixels = (double)s->width * s->height;

    return 2 * IBL_PI * IBL_PI < largest_light * pixels &&
           lights_any(&s->reading.group[group].range,
                      (size_t)s->width * (size_t)rows_of(s, group),
                      most_lights(s, group));
}

static void group_job(void *arg, int job, int worker)
{
    ibl_spectral *s = arg;
    ibl_spectral_reading *r = &s->reading;
    const size_t row = 3 * (size_t)s->width;
    const int first = r->first + job * GROUP, left = r->added - first;
    ibl_spectral_group *group = &r->group[first / GROUP];
    float *scratch = r->scratch + (size_t)worker * r->worker_floats;
    float *own = scratch + r->worker_floats - group_floats(s);
    ibl_row_fft_rows in = {.rgb = r->rgb + row * (size_t)(job * GROUP),
                           .stride = row,
                           .count = left < GROUP ? left : GROUP};

    find_range(in.rgb, s->width, in.count, &group->range);
    group->exponent = scale_of(group->range.high);
    in.scale = ldexpf(1, group->exponent);
    if (has_lights(s, first / GROUP))
        take_lights(s, &in, first / GROUP, own);
    ibl_row_fft_forward(r->azimuth, &in, scratch, &r->rows, first / GROUP);
}

void ibl_spectral_add(ibl_spectral *s, int rows, const float *rgb)
{
    ibl_spectral_reading *r = &s->reading;
    r->rgb = rgb;
    r->first = r->added;
    r->added += rows;
    ibl_run_begin(s->ctx, "analysis", (double)r->first / s->height,
                  (rows + GROUP - 1) / GROUP, group_job, s);
}

/* ---- lights ------------------------------------------------------------ */

/* Integral of all channels over the sphere, without the lights; scaled. */
static double energy_of_rows(const ibl_spectral *s)
{
    double sum = 0;
    for (int j = 0; j < s->height; j++)
        for (int c = 0; c < 3; c++)
            sum += s->weight[j] * (double)ibl_row_spectra_at(&s->reading.rows,
                                                             j / GROUP, 0,
                                                             2 * c)[j % GROUP];
    return sum;
}

/* In the order of the map. */
static int by_place(const void *a, const void *b)
{
    const ibl_pixel_light *x = a, *y = b;
    return x->row != y->row ? x->row - y->row : x->column - y->column;
}

/* By falling energy, then by place. */
static int stronger_first(const void *a, const void *b)
{
    const ibl_pixel_light *x = a, *y = b;
    if (x->energy < y->energy || x->energy > y->energy)
        return x->energy < y->energy ? 1 : -1;
    return by_place(a, b);
}

/* Collects all lights that were taken out: scaled, the strongest first. */
static ibl_status gather_lights(ibl_spectral *s, int *count)
{
    const ibl_spectral_reading *r = &s->reading;
    int n = 0;
    for (int g = 0; g < s->groups; g++)
        n += r->group[g].lights;
    s->lights = ibl_alloc_array((size_t)n, sizeof *s->lights);
    if (!s->lights)
        return ibl_no_memory(s->ctx, "the lights");
    n = 0;
    for (int g = 0; g < s->groups; g++)
        for (int i = 0; i < r->group[g].lights; i++) {
            ibl_pixel_light *l = &s->lights[n++];
            *l = r->taken[(size_t)g * r->room + (size_t)i];
            for (int c = 0; c < 3; c++)
                l->rgb[c] *= (float)s->scale;
            l->energy =
                s->weight[l->row] *
                ((double)l->rgb[0] + (double)l->rgb[1] + (double)l->rgb[2]);
        }
    qsort(s->lights, (size_t)n, sizeof *s->lights, stronger_first);
    *count = n;
    return IBL_OK;
}

struct add_lights {
    const ibl_spectral *s;
    const ibl_pixel_light *lights;
    int count;
    ibl_row_spectra *to;
};

double ibl_spectral_azimuth(const ibl_spectral *s, const ibl_pixel_light *l)
{
    return 2 * IBL_PI * ((l->column + 0.5) / s->width - 0.5) - s->yaw;
}

static void add_lights_job(void *arg, int m, int worker)
{
    const struct add_lights *a = arg;
    const ibl_spectral *s = a->s;
    (void)worker;
    for (int i = 0; i < a->count; i++) {
        const ibl_pixel_light *l = &a->lights[i];
        const int group = l->row / GROUP;
        if (m >= ibl_row_spectra_orders(a->to, group))
            continue;
        const double angle = m * ibl_spectral_azimuth(s, l);
        const float re = (float)cos(angle), im = (float)-sin(angle);
        for (int c = 0; c < 3; c++) {
            float *to = ibl_row_spectra_at(a->to, group, m, 2 * c);
            to[l->row % GROUP] += re * l->rgb[c];
            to[l->row % GROUP + GROUP] += im * l->rgb[c];
        }
    }
}

ibl_status ibl_spectral_add_lights(const ibl_spectral *s,
                                   const ibl_pixel_light *lights, int count,
                                   ibl_row_spectra *to)
{
    struct add_lights a = {s, lights, count, to};
    return count ? ibl_run(s->ctx, NULL, to->degree + 1, add_lights_job, &a)
                 : IBL_OK;
}

/* Chooses the lights that are added to texels; the rest return to their
 * rows. */
static ibl_status choose_lights(ibl_spectral *s)
{
    double total = energy_of_rows(s);
    int count = 0;
    ibl_status status = gather_lights(s, &count);
    if (status)
        return status;
    for (int i = 0; i < count; i++)
        total += s->lights[i].energy;
    while (s->light_count < count && s->light_count < IBL_LIGHTS_MOST &&
           s->lights[s->light_count].energy > least_share * total)
        s->light_count++;
    qsort(s->lights, (size_t)s->light_count, sizeof *s->lights, by_place);
    return ibl_spectral_add_lights(s, s->lights + s->light_count,
                                   count - s->light_count, &s->reading.rows);
}

/* ---- finish ------------------------------------------------------------ */

/* Moves the mean out of the harmonics: it is the same in every texel. */
static void take_mean(ibl_spectral *s)
{
    float *a = ibl_harmonics_at(&s->harmonics, 0);
    for (int c = 0; c < 3; c++) {
        const double whole = sqrt(4 * IBL_PI) * s->scale;
        s->mean[c] = (float)((double)a[2 * c] / whole);
        a[2 * c] -= (float)((double)s->mean[c] * whole);
    }
}

static void merge_ranges(ibl_spectral *s)
{
    const ibl_spectral_group *group = s->reading.group;
    for (int c = 0; c < 3; c++) {
        s->low[c] = group[0].range.low[c];
        s->high[c] = group[0].range.high[c];
        for (int g = 1; g < s->groups; g++) {
            s->low[c] = fminf(s->low[c], group[g].range.low[c]);
            s->high[c] = fmaxf(s->high[c], group[g].range.high[c]);
        }
    }
}

/* Brings every group to the scale of the map. */
static void choose_scale(ibl_spectral *s)
{
    const ibl_row_spectra *rows = &s->reading.rows;
    const int exponent = scale_of(s->high);

    s->scale = ldexp(1, exponent);
    for (int g = 0; g < s->groups; g++) {
        const int change = exponent - s->reading.group[g].exponent;
        for (size_t i = rows->at[g]; change && i < rows->at[g + 1]; i++)
            rows->data[i] = ldexpf(rows->data[i], change);
    }
}

ibl_status ibl_spectral_finish(ibl_spectral *s)
{
    ibl_progress(s->ctx, "analysis", 1);
    merge_ranges(s);
    choose_scale(s);
    ibl_status status = choose_lights(s);
    if (!status)
        status = ibl_harmonics_alloc(s->ctx, s->degree, &s->harmonics);
    if (status)
        return status;
    s->harmonics.single = s->single;
    status = ibl_sht_analyse(s->ctx, "analysis", &s->reading.rows, s->widths,
                             &s->harmonics);
    if (status)
        return status;
    take_mean(s);
    ibl_sht_power(&s->harmonics, s->power);
    free_reading(&s->reading);
    return IBL_OK;
}

/* ---- coefficients of the map, with all that the analysis keeps apart --- */

/* Analyses only the lights. */
static ibl_status analyse_lights(const ibl_spectral *s, ibl_harmonics *out)
{
    ibl_row_spectra rows;
    ibl_status status =
        ibl_row_spectra_alloc(s->ctx, s->height, out->degree, &rows);
    if (status)
        return status;
    out->single = s->single;
    memset(rows.data, 0, rows.at[rows.groups] * sizeof *rows.data);
    status = ibl_spectral_add_lights(s, s->lights, s->light_count, &rows);
    if (!status)
        status = ibl_sht_analyse(s->ctx, NULL, &rows, s->widths, out);
    ibl_row_spectra_free(&rows);
    return status;
}

/* The harmonics of the map. *sum is empty after an error. */
static ibl_status add_all(const ibl_spectral *s, int degree, ibl_harmonics *sum)
{
    const size_t edge = (size_t)degree + 1;
    ibl_status status = ibl_harmonics_alloc(s->ctx, degree, sum);
    if (status)
        return status;
    memset(sum->data, 0, 3 * edge * (edge + 1) * sizeof *sum->data);
    if (s->light_count)
        status = analyse_lights(s, sum);
    for (int m = 0; m <= degree && !status; m++) {
        const float *from = ibl_harmonics_at(&s->harmonics, m);
        float *to = ibl_harmonics_at(sum, m);
        for (int i = 0; i < 6 * (degree - m + 1); i++)
            to[i] = (float)(((double)to[i] + (double)from[i]) / s->scale);
    }
    for (int c = 0; c < 3; c++)
        sum->data[2 * c] += (float)((double)s->mean[c] * sqrt(4 * IBL_PI));
    if (status)
        ibl_harmonics_free(sum);
    return status;
}

ibl_status ibl_spectral_sh(const ibl_spectral *s, int degree, double *coeffs)
{
    const ibl_axes about_y = {.up = IBL_UP_Z}; /* phi backwards */
    ibl_harmonics sum;
    ibl_status status = add_all(s, degree, &sum);
    for (int m = 0; m <= degree && !status; m++)
        for (int l = m; l <= degree; l++)
            for (int c = 0; c < 3; c++) {
                const float *a =
                    ibl_harmonics_at(&sum, m) + 6 * (l - m) + 2 * c;
                const double g = m ? sqrt(2) : 1;
                coeffs[3 * (l * (l + 1) - m) + c] = g * (double)a[1];
                coeffs[3 * (l * (l + 1) + m) + c] = g * (double)a[0];
            }
    if (!status)
        status = ibl_sh_turn_axes(s->ctx, degree, about_y, 1, coeffs);
    ibl_harmonics_free(&sum);
    return status;
}
