/* SPDX-License-Identifier: MIT */
/*
 * Makes a level from the analysis: synthesis onto rings, interpolation to
 * texels, and the lights on top.
 */
#include <math.h>
#include <string.h>

#include "bake/spectral/engine.h"
#include "bake/spectral/lobe_coefficients.h"
#include "brdf/lobe.h"
#include "core/alloc.h"
#include "core/context.h"
#include "image/cube.h"

enum {
    GROUP = IBL_ROW_FFT_ROWS,
    MIN_COLUMNS = 64,
    LEAST_DEGREE = 8,
    MOST_MARGIN = 10000, /* darker texels are measured by the floor */
    LAST = 8,            /* degrees at the kernel's end, to extrapolate it */
    PICKED = 1024
};

/* Part of the tolerance that the points of lights may use. */
static const double lights_part = 0.2;

/* Part of that, times the mean radiance, that one light may miss where the
 * horizon cuts it: texels may be darker than the mean, and lights many. */
static const double horizon_part = 0.5;

/* Relative error of the transforms, in floats. */
static const double rounding = 5e-6;

/* A level in progress. */
struct level {
    ibl_spectral *s;
    const ibl_spectral_target *target;
    double *kernel; /* ibl_spectral_known(target->most) + 1 */
    int degree, rings, columns;
    double *field;            /* amplitude of the level in each degree */
    double margin;            /* see wanted_rms */
    double rms;               /* estimate of the error, absolute */
    double around;            /* and as a share of what is around a texel */
    ibl_point_lights *bright; /* NULL: no lights */
    ibl_ring_spectra spectra;
    ibl_ring_grid grid;
    ibl_row_fft *azimuth;
    float *scratch;
    size_t scratch_floats;
};

/* ---- the degree -------------------------------------------------------- */

/* Estimates the mean square that degrees beyond the level's most would add.
 * Where the kernel is known, they have twice the largest power of the last
 * degrees; beyond that, all power that is left at the kernel's last values. */
static double unresolved_power(const struct level *v)
{
    const ibl_spectral *s = v->s;
    const int most = v->target->most, known = ibl_spectral_known(most);
    double power = 0, sum = 0, end = 0, left = 0;

    for (int l = most - most / 8; l <= most; l++)
        power = fmax(power, s->power[l]);
    for (int l = s->degree; l > most; l--)
        left += s->power[l] / (4 * IBL_PI);
    for (int l = most + 1; l <= known; l++)
        sum += v->kernel[l] * v->kernel[l];
    for (int l = known - LAST; l <= known; l++)
        end = fmax(end, fabs(v->kernel[l]));
    return sum * 2 * power / (4 * IBL_PI) +
           end * end * (left + s->unresolved * s->scale * s->scale);
}

/* Norm of the mean radiance. */
static double mean_of(const ibl_spectral *s)
{
    double sum = 0;
    for (int c = 0; c < 3; c++) {
        double light = 0;
        for (int i = 0; i < s->light_count; i++)
            light += (double)s->lights[i].rgb[c] * s->weight[s->lights[i].row];
        const double mean =
            (double)s->mean[c] + light / (4 * IBL_PI) / s->scale;
        sum += mean * mean;
    }
    return sqrt(sum);
}

/* The target rms error, scaled: tolerance times mean / margin. Texels that are
 * darker than the mean by the margin still keep the tolerance. */
static double wanted_rms(const struct level *v)
{
    return v->target->tolerance / v->margin * mean_of(v->s) * v->s->scale;
}

/* Chooses the smallest degree that leaves at most the wanted rms. */
static void choose_degree(struct level *v)
{
    const double wanted = wanted_rms(v);
    double left;
    int l = v->target->most;

    left = unresolved_power(v);
    while (l > LEAST_DEGREE) {
        const double k = v->kernel[l];
        const double more = left + k * k * v->s->power[l] / (4 * IBL_PI);
        if (more > wanted * wanted)
            break;
        left = more;
        l--;
    }
    v->degree = l;
    v->rms = sqrt(left);
}

/* ---- the grid ---------------------------------------------------------- */

/* Chooses the coarsest grid, of 2 to 8 samples for the shortest wave, that
 * leaves at most the wanted rms or a quarter of what the degrees leave; or, of
 * the field around each texel, twice the share of the mean that the degrees
 * leave. */
static void choose_grid(struct level *v)
{
    static const double samples[] = {2, 2.25, 2.5, 3, 4, 5, 6, 8};
    const double wanted = fmax(wanted_rms(v), 0.25 * v->rms);
    const double mean = mean_of(v->s) * v->s->scale;
    double field = 0, left = 0;

    for (int l = 0; l <= v->degree; l++) {
        const double k = v->kernel[l];
        const double square = k * k * v->s->power[l] / (4 * IBL_PI);
        v->field[l] = sqrt(square / (2 * l + 1));
        field += l ? square : 0;
    }
    for (size_t i = 0; i < sizeof samples / sizeof *samples; i++) {
        const double needed = samples[i] * v->degree;
        v->columns = MIN_COLUMNS;
        while (v->columns < needed || v->columns < 2 * (v->degree + 1))
            v->columns *= 2;
        v->rings = GROUP * (int)ceil(needed / (2 * GROUP));
        left = sqrt(field) *
               ibl_ring_grid_error(v->field, v->degree, v->rings, v->columns);
        v->around = 2 * left / fmax(sqrt(field), mean);
        if (left <= wanted || v->around * mean <= 4 * v->rms)
            break;
    }
    v->rms = 2 * v->rms / v->s->scale;
}

static void rings_job(void *arg, int job, int worker)
{
    const struct level *v = arg;
    const int first = job * GROUP, left = v->rings - first;
    const ibl_row_fft_samples out = {.rgba = ibl_ring_grid_at(&v->grid, first),
                                     .stride = v->grid.stride,
                                     .count = left < GROUP ? left : GROUP};
    ibl_row_fft_inverse(v->azimuth, &v->spectra, first,
                        v->scratch + (size_t)worker * v->scratch_floats, &out);
    ibl_ring_grid_close(&v->grid, first, out.count);
}

static ibl_status fill_grid(struct level *v)
{
    const ibl_spectral *s = v->s;
    ibl_status status =
        ibl_ring_spectra_alloc(s->ctx, v->rings, v->degree + 1, &v->spectra);
    if (!status)
        status = ibl_ring_grid_alloc(s->ctx, v->rings, v->columns, &v->grid);
    if (!status)
        status = ibl_sht_synthesise(s->ctx, &s->harmonics, v->kernel, v->degree,
                                    &v->spectra);
    if (!status)
        status = ibl_row_fft_create_inverse(s->ctx, v->columns, v->degree + 1,
                                            &v->azimuth);
    if (status)
        return status;
    v->scratch_floats = (ibl_row_fft_scratch(v->azimuth) + 15) / 16 * 16;
    v->scratch = ibl_alloc_array((size_t)ibl_ctx_threads(s->ctx),
                                 v->scratch_floats * sizeof(float));
    if (!v->scratch)
        return ibl_no_memory(s->ctx, "the rings of a level");
    return ibl_run(s->ctx, NULL, (v->rings + GROUP - 1) / GROUP, rings_job, v);
}

static void free_grid(struct level *v)
{
    ibl_ring_spectra_free(&v->spectra);
    ibl_ring_grid_free(&v->grid);
    ibl_row_fft_free(v->azimuth);
    ibl_free(v->scratch);
    v->azimuth = NULL;
    v->scratch = NULL;
}

/* ---- texels ------------------------------------------------------------ */

static ibl_patch patch_of(const ibl_spectral *s, const ibl_pixel_light *l)
{
    const double height = IBL_PI / s->height;
    return (ibl_patch){.theta = {height * l->row, height * (l->row + 1)},
                       .phi = ibl_spectral_azimuth(s, l),
                       .width = 2 * IBL_PI / s->width,
                       .rgb = {l->rgb[0], l->rgb[1], l->rgb[2]}};
}

static ibl_status make_lights(struct level *v)
{
    const ibl_spectral *s = v->s;
    const double error = lights_part * v->target->tolerance;
    ibl_patch *patches;

    if (!s->light_count)
        return IBL_OK;
    patches = ibl_alloc_array((size_t)s->light_count, sizeof *patches);
    if (!patches)
        return ibl_no_memory(s->ctx, "the lights");
    for (int i = 0; i < s->light_count; i++)
        patches[i] = patch_of(s, &s->lights[i]);
    const ibl_status status = ibl_point_lights_create(
        s->ctx, patches, s->light_count, v->target->shape, error,
        horizon_part * error * mean_of(s) * s->scale, &v->bright);
    ibl_free(patches);
    return status;
}

static ibl_status fill_texels(const struct level *v)
{
    const ibl_spectral *s = v->s;
    const ibl_spectral_target *t = v->target;
    ibl_level_sum sum = {.grid = &v->grid,
                         .spectrum = v->field,
                         .degree = v->degree,
                         .bright = v->bright,
                         .range.gain = (float)(1 / s->scale)};

    memcpy(sum.range.offset, s->mean, sizeof s->mean);
    memcpy(sum.range.low, s->low, sizeof s->low);
    memcpy(sum.range.high, s->high, sizeof s->high);
    return ibl_spectral_texels(s->ctx, "resampling", &sum, t->cube, t->level);
}

/* The n-th smallest of v, from 0; changes the order of v (Hoare 1961,
 * "Algorithm 65: find", Communications of the ACM 4). */
static double smallest(double *v, size_t count, size_t n)
{
    size_t low = 0, high = count;

    while (high - low > 1) {
        const double middle = v[low + (high - low) / 2];
        size_t below = low, above = high;
        for (size_t i = low; i < above;) {
            const double x = v[i];
            if (x < middle) {
                v[i++] = v[below];
                v[below++] = x;
            } else if (x > middle) {
                v[i] = v[--above];
                v[above] = x;
            } else {
                i++;
            }
        }
        if (n >= below && n < above)
            return middle;
        *(n < below ? &high : &low) = n < below ? below : above;
    }
    return v[low];
}

/*
 * Estimates the 95th percentile of relative errors, from twice the rms that is
 * left, over texels spread evenly over the level. Includes rounding of floats.
 */
static double estimate(const struct level *v)
{
    const ibl_cube *cube = v->target->cube;
    const ibl_level_shape shape = ibl_map_shape(cube, v->target->level);
    const size_t texels = ibl_level_texels(&shape);
    const size_t count = texels < PICKED ? texels : PICKED;
    const float *p = ibl_cube_face(cube, v->target->level, 0);
    const double mean = mean_of(v->s);
    /* At the default tolerance the error of the points is invisible. */
    const double other =
        v->bright && v->target->tolerance > IBL_TOLERANCE_DEFAULT
            ? rounding + lights_part * v->target->tolerance
            : rounding;
    double errors[PICKED];

    for (size_t i = 0; i < count; i++) {
        const float *rgb = p + 3 * (i * texels / count);
        double sum = 0;
        for (int c = 0; c < 3; c++)
            sum += (double)rgb[c] * (double)rgb[c];
        const double least = fmax(sqrt(sum), IBL_RELATIVE_FLOOR * mean);
        errors[i] = least > 0 ? v->rms / least + v->around + other : 0;
    }
    return smallest(errors, count, count - 1 - count / 20);
}

static ibl_status allocate(struct level *v)
{
    const int degree = ibl_spectral_known(v->target->most);
    const size_t count = (size_t)degree + 1;
    v->kernel = ibl_alloc_array(2 * count, sizeof *v->kernel);
    if (!v->kernel)
        return ibl_no_memory(v->s->ctx, "a lobe");
    v->field = v->kernel + count;
    return ibl_lobe_coefficients(v->s->ctx, v->target->shape, degree,
                                 v->kernel);
}

/* Makes the level for the current margin. */
static ibl_status make_level(struct level *v, const char *stage)
{
    ibl_progress(v->s->ctx, stage, 0);
    choose_degree(v);
    choose_grid(v);
    ibl_status status = fill_grid(v);
    if (!status)
        ibl_progress(v->s->ctx, stage, 1);
    if (!status)
        status = fill_texels(v);
    free_grid(v);
    return status;
}

ibl_status ibl_spectral_bake(ibl_spectral *s, const char *stage,
                             const ibl_spectral_target *target, int *degree,
                             double *error)
{
    struct level v = {.s = s, .target = target, .margin = 20};
    bool enough = false;

    ibl_status status = allocate(&v);
    if (!status)
        status = make_lights(&v);
    while (!status && !enough) {
        status = make_level(&v, stage);
        *degree = v.degree;
        *error = status ? INFINITY : estimate(&v);
        enough = *error <= target->tolerance || v.margin >= MOST_MARGIN ||
                 v.degree == target->most;
        /* The dark texels are known now. No degree reduces the rounding. */
        const double asked =
            fmax(target->tolerance - rounding, 0.5 * target->tolerance);
        const double more = (*error - rounding) / asked;
        enough = enough || more <= 1;
        v.margin = fmin(v.margin * fmax(1.1 * more, 2), MOST_MARGIN);
    }
    ibl_point_lights_free(v.bright);
    ibl_free(v.kernel);
    return status;
}
