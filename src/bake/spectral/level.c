/* SPDX-License-Identifier: MIT */
/*
 * A level from the analysis: synthesis onto rings, from there to texels, and
 * the lights on top.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "bake/spectral/kernel.h"
#include "bake/spectral/plan.h"
#include "bake/spectral/state.h"
#include "brdf/lobe.h"
#include "core/alloc.h"
#include "core/context.h"

enum {
    GROUP = IBL_AZIMUTH_ROWS,
    MIN_COLUMNS = 64,
    STEP = 8, /* degrees are multiples, less one */
    LAST = 8, /* degrees of the kernel's end that are averaged */
    PICKED = 1024
};

/* What the transforms and the texels leave, in floats. */
static const double rounding = 1e-6;

/* A level in the making. */
struct level {
    ibl_spectral *s;
    const ibl_spectral_target *target;
    double *kernel; /* known_degree of the analysis + 1 */
    float *gain;    /* of each ring */
    int degree, rings, columns;
    double rms; /* estimate of what is left out */
    ibl_azimuth *azimuth;
    float *scratch;
    size_t scratch_floats;
};

void ibl_spectral_work_free(ibl_spectral_work *work)
{
    ibl_ring_spectra_free(&work->spectra);
    ibl_ring_grid_free(&work->grid);
}

static int known_degree(int degree)
{
    return degree + degree / 2 + LAST;
}

/* ---- the degree -------------------------------------------------------- */

/*
 * Mean square, over the sphere, of what the degrees beyond the analysis would
 * add: the map's power there is taken to be what it is in the last quarter.
 * The kernel is known for half as many degrees again; from there it is taken
 * to fall as l^-2.5, the slowest, as a lobe with a corner on the horizon does.
 */
static double beyond(const struct level *v)
{
    const int d = v->s->degree, most = known_degree(d);
    const int from = d - d / 4;
    double power = 0, sum = 0, last = 0;

    for (int l = from; l <= d; l++)
        power += ibl_sht_power(&v->s->harmonics, l) / (2 * l + 1);
    power /= d - from + 1;
    for (int l = d + 1; l <= most; l++) {
        const double k = v->kernel[l];
        sum += (2 * l + 1) * k * k;
        if (l > most - LAST)
            last += k * k / LAST;
    }
    return power * (sum + last * (2 * most + 1) * most / 3) / (4 * IBL_PI);
}

/* Norm of the mean radiance. */
static double mean_of(const ibl_spectral *s)
{
    const double *a = ibl_harmonics_at(&s->harmonics, 0);
    double sum = 0;
    for (int c = 0; c < 3; c++) {
        double light = 0;
        for (int i = 0; i < s->light_count; i++)
            light += (double)s->lights[i].rgb[c] * s->weight[s->lights[i].row];
        const double mean =
            (a[2 * c] * sqrt(1 / (4 * IBL_PI)) + light / (4 * IBL_PI)) /
                (double)IBL_SPECTRAL_SCALE +
            (double)s->base[c];
        sum += mean * mean;
    }
    return sqrt(sum);
}

/* The smallest degree that leaves an error, in the root mean square, of a
 * twentieth of the tolerance times the mean: texels may be that much darker
 * than the mean and still keep it. */
static void choose_degree(struct level *v)
{
    const ibl_spectral *s = v->s;
    const double wanted =
        v->target->tolerance / 20 * mean_of(s) * (double)IBL_SPECTRAL_SCALE;
    double left = beyond(v);
    int l = s->degree;

    while (l > STEP) {
        const double k = v->kernel[l];
        const double more =
            left + k * k * ibl_sht_power(&s->harmonics, l) / (4 * IBL_PI);
        if (more > wanted * wanted)
            break;
        left = more;
        l--;
    }
    v->degree = l;
    v->rms = sqrt(left) / (double)IBL_SPECTRAL_SCALE;
}

/* ---- the grid ---------------------------------------------------------- */

/* At least 2.5 samples for the shortest wave. */
static void choose_grid(struct level *v)
{
    v->columns = MIN_COLUMNS;
    while (v->columns < 2.5 * v->degree)
        v->columns *= 2;
    v->rings = v->columns / 2;
}

/*
 * 1 / sum of K dO over the map's pixels, at the polar angle of each ring: 1
 * but for what the midpoints of rows leave.
 */
static void fill_gain(const struct level *v)
{
    const ibl_spectral *s = v->s;
    for (int j = 0; j < v->rings; j++) {
        const double x = cos(IBL_PI * (j + 0.5) / v->rings);
        double p = 1, below = 0, sum = 0;
        for (int l = 0; l <= s->degree; l++) {
            sum += (2 * l + 1) / (4 * IBL_PI) * v->kernel[l] * s->zonal[l] * p;
            const double next = ((2 * l + 1) * x * p - l * below) / (l + 1);
            below = p;
            p = next;
        }
        v->gain[j] = (float)(1 / (sum * (double)IBL_SPECTRAL_SCALE));
    }
}

static void rings_job(void *arg, int job, int worker)
{
    const struct level *v = arg;
    const int first = job * GROUP, left = v->rings - first;
    const ibl_ring_grid *grid = &v->s->work.grid;
    const ibl_azimuth_samples out = {.rgba = ibl_ring_grid_at(grid, first),
                                     .stride = grid->stride,
                                     .count = left < GROUP ? left : GROUP};
    ibl_azimuth_inverse(v->azimuth, &v->s->work.spectra, first,
                        v->scratch + (size_t)worker * v->scratch_floats, &out);
    ibl_ring_grid_close(grid, first, out.count);
}

static ibl_status fill_grid(struct level *v)
{
    ibl_spectral *s = v->s;
    ibl_spectral_work *w = &s->work;
    ibl_status status = IBL_OK;

    if (w->spectra.rings != v->rings || w->spectra.orders <= v->degree) {
        ibl_ring_spectra_free(&w->spectra);
        status = ibl_ring_spectra_alloc(s->ctx, v->rings, v->degree + 1,
                                        &w->spectra);
    }
    if (!status)
        status = ibl_ring_grid_alloc(s->ctx, v->rings, v->columns, &w->grid);
    if (!status)
        status = ibl_sht_synthesise(s->ctx, NULL, &s->harmonics, v->kernel,
                                    v->degree, &w->spectra);
    if (!status)
        status = ibl_azimuth_create_inverse(s->ctx, v->columns, v->degree + 1,
                                            &v->azimuth);
    if (status)
        return status;
    v->scratch_floats = (ibl_azimuth_scratch(v->azimuth) + 15) / 16 * 16;
    v->scratch = ibl_alloc_array((size_t)ibl_ctx_threads(s->ctx),
                                 v->scratch_floats * sizeof(float));
    if (!v->scratch)
        return ibl_no_memory(s->ctx, "the rings of a level");
    return ibl_run(s->ctx, NULL, (v->rings + GROUP - 1) / GROUP, rings_job, v);
}

/* ---- texels ------------------------------------------------------------ */

static double lobe_at(double chord, const void *shape)
{
    const double q = chord * chord / 4;
    return ibl_lobe_value(shape, q, 1 - 2 * q);
}

static ibl_status make_radial(const struct level *v, ibl_radial *radial)
{
    const ibl_spectral_target *t = v->target;
    const ibl_lobe_shape shape = ibl_lobe_shape_of(t->lobe, t->alpha);
    if (t->lobe != IBL_LOBE_GGX)
        return ibl_radial_table(v->s->ctx, lobe_at, &shape, radial);
    ibl_radial_ggx(t->alpha, radial);
    return IBL_OK;
}

static ibl_status fill_texels(const struct level *v, const char *stage)
{
    const ibl_spectral *s = v->s;
    const ibl_spectral_target *t = v->target;
    ibl_radial radial = {0};
    ibl_level_sum sum = {.grid = &s->work.grid,
                         .spectrum = v->kernel,
                         .degree = v->degree,
                         .bright = s->light_count ? s->bright : NULL,
                         .lobe = &radial,
                         .gain = v->gain};

    memcpy(sum.offset, s->base, sizeof sum.offset);
    memcpy(sum.low, s->low, sizeof sum.low);
    memcpy(sum.high, s->high, sizeof sum.high);
    ibl_status status = s->light_count ? make_radial(v, &radial) : IBL_OK;
    if (!status)
        status = ibl_spectral_texels(s->ctx, stage, &sum, t->cube, t->level);
    ibl_radial_free(&radial);
    return status;
}

static int falling(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return x < y ? 1 : x > y ? -1 : 0;
}

/*
 * The 95th percentile of relative errors of twice the rms that is left, over
 * texels spread evenly over the level. What floats round is in it.
 */
static double estimate(const struct level *v)
{
    const ibl_cube *cube = v->target->cube;
    const int n = ibl_cube_edge(cube->size, v->target->level);
    const size_t texels = (size_t)IBL_FACES * (size_t)n * (size_t)n;
    const size_t count = texels < PICKED ? texels : PICKED;
    const float *p = ibl_cube_face(cube, v->target->level, 0);
    const double mean = mean_of(v->s);
    const double points =
        ibl_spectral_shortfall(v->s->width, v->s->height, v->target->alpha);
    double errors[PICKED];

    for (size_t i = 0; i < count; i++) {
        const float *rgb = p + 3 * (i * texels / count);
        double sum = 0;
        for (int c = 0; c < 3; c++)
            sum += (double)rgb[c] * (double)rgb[c];
        const double least = fmax(sqrt(sum), IBL_RELATIVE_FLOOR * mean);
        errors[i] = least > 0 ? 2 * v->rms / least + rounding + points : 0;
    }
    qsort(errors, count, sizeof *errors, falling);
    return errors[count / 20];
}

static ibl_status allocate(struct level *v)
{
    const int degree = known_degree(v->s->degree);
    v->kernel = ibl_alloc_array((size_t)degree + 1, sizeof *v->kernel);
    if (!v->kernel)
        return ibl_no_memory(v->s->ctx, "a lobe");
    return ibl_kernel_make(v->s->ctx, v->target->lobe, v->target->alpha, degree,
                           v->kernel);
}

ibl_status ibl_spectral_bake(ibl_spectral *s, const char *stage,
                             const ibl_spectral_target *target, int *degree,
                             double *error)
{
    struct level v = {.s = s, .target = target};

    ibl_progress(s->ctx, stage, 0);
    ibl_status status = allocate(&v);
    if (!status) {
        choose_degree(&v);
        choose_grid(&v);
        v.gain = ibl_alloc_array((size_t)v.rings, sizeof *v.gain);
        if (!v.gain)
            status = ibl_no_memory(s->ctx, "the rings of a level");
    }
    if (!status) {
        fill_gain(&v);
        status = fill_grid(&v);
    }
    if (!status)
        status = fill_texels(&v, stage);
    if (!status) {
        *degree = v.degree;
        *error = estimate(&v);
    }
    ibl_azimuth_free(v.azimuth);
    ibl_free(v.scratch);
    ibl_free(v.gain);
    ibl_free(v.kernel);
    return status;
}
