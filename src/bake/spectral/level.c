/* SPDX-License-Identifier: MIT */
/*
 * Makes a level from the analysis: synthesis onto rings, interpolation to
 * texels, and the lights on top.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "bake/spectral/engine.h"
#include "bake/spectral/lobe_coefficients.h"
#include "bake/spectral/plan.h"
#include "brdf/lobe.h"
#include "core/alloc.h"
#include "core/context.h"
#include "image/cube.h"

enum {
    GROUP = IBL_ROW_GROUP,
    RINGS = GROUP + 1, /* of the probes, all but the middle one */
    PROBES = 32,       /* on each of them */
    SMALLEST = 16,     /* degree that is tried */
    TRIES = 3
};

/* Azimuth of the first probe, in distances between them. Places must not lie
 * where a grid of pixels puts nothing of what degrees add. */
static const double first_probe = 0.381966;

/* Value of the kernel to which degrees show how bright a level is. */
static const double small = 0.03;

/* Error of floats beside light that is brighter on a ring, as a part of its
 * rms. */
static const double noise_part = 1e-7;

/* A level in progress. */
struct level {
    ibl_spectral *s;
    const ibl_spectral_target *target;
    double *kernel; /* most + 1, and room for as many factors and tails */
    int degree;
    double error;             /* of the degrees, relative, */
    double noise;             /* and of floats beside brighter light */
    ibl_point_lights *bright; /* NULL: no lights */
    ibl_ring_grid grid;
    int first;                /* pair of the spectra's first ring */
    ibl_ring_spectra spectra; /* of the bands and what is around them */
    ibl_row_fft *azimuth;
    float *scratch;
    size_t scratch_floats;
};

/* ---- the degree -------------------------------------------------------- */

typedef float probe_rings __attribute__((vector_size(4 * GROUP), may_alias));

/* Places at which the level is made to see what its degrees add. */
struct probes {
    ibl_ring_spectra spectra; /* of GROUP rings */
    double *factor;
    float wave[PROBES][2]; /* cos and sin of the azimuths */
    probe_rings rgb[PROBES][3];
    double size[PROBES][GROUP]; /* of the level, at least the floor */
    double around[GROUP];       /* rms of a ring, without lights */
    double area[GROUP];         /* of a probe, in any unit */
};

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

/* The sum over the degrees from..until, scaled. Orders that are the same at the
 * probes are added up before their waves are. */
static ibl_status make_probes(const struct level *v, struct probes *p, int from,
                              int until)
{
    probe_rings folded[PROBES][2][3] = {{{{0}}}};
    const double turn = 2 * IBL_PI / PROBES * first_probe;

    for (int l = 0; l <= until; l++)
        p->factor[l] = l < from ? 0 : v->kernel[l];
    const ibl_status status = ibl_sht_synthesise(
        v->s->ctx, &v->s->harmonics, p->factor, until, RINGS, 0, &p->spectra);
    if (status)
        return status;
    for (int m = 0; m <= until; m++) {
        const float both = m ? 2 : 1, c = both * (float)cos(m * turn);
        const float s = both * (float)sin(m * turn);
        for (int part = 0; part < 6; part += 2) {
            const probe_rings re =
                *(const probe_rings *)ibl_ring_spectra_at(&p->spectra, m, part);
            const probe_rings im = *(const probe_rings *)ibl_ring_spectra_at(
                &p->spectra, m, part + 1);
            folded[m % PROBES][0][part / 2] += c * re - s * im;
            folded[m % PROBES][1][part / 2] += s * re + c * im;
        }
    }
    memset(p->rgb, 0, sizeof p->rgb);
    for (int i = 0; i < PROBES; i++)
        for (int m = 0; m < PROBES; m++) {
            const float *wave = p->wave[m * i % PROBES];
            for (int c = 0; c < 3; c++)
                p->rgb[i][c] +=
                    wave[0] * folded[m][0][c] - wave[1] * folded[m][1][c];
        }
    return IBL_OK;
}

/* Finds how bright the level is at the probes, from its low degrees. */
static void find_sizes(const struct level *v, struct probes *p)
{
    const ibl_spectral *s = v->s;
    const double floor_of = IBL_RELATIVE_FLOOR * mean_of(s);
    float point[6 * PROBES] = {0}, light[4 * PROBES];
    ibl_radial_dsp dsp;

    ibl_radial_dsp_init(&dsp, ibl_ctx_isa(s->ctx));
    for (int j = 0; j < GROUP; j++) {
        const int ring = j < GROUP / 2 ? j : j + 1;
        const double theta = IBL_PI * (ring + 0.5) / RINGS;
        for (int i = 0; i < PROBES; i++) {
            const double phi = 2 * IBL_PI * (i + first_probe) / PROBES;
            point[i] = (float)(sin(theta) * cos(phi));
            point[PROBES + i] = (float)cos(theta);
            point[2 * PROBES + i] = (float)(sin(theta) * sin(phi));
        }
        memset(light, 0, sizeof light);
        for (int i = 0; v->bright && i < PROBES; i += IBL_RADIAL_BLOCK)
            ibl_point_lights_add(v->bright, &dsp, point + i, PROBES,
                                 light + 4 * (ptrdiff_t)i);
        p->area[j] = sin(theta);
        p->around[j] = 0;
        for (int i = 0; i < PROBES; i++) {
            double sum = 0;
            for (int c = 0; c < 3; c++) {
                const double field = (double)p->rgb[i][c][j];
                const double whole =
                    (field + (double)light[4 * i + c]) / s->scale +
                    (double)s->mean[c];
                p->around[j] += field * field / PROBES;
                sum += whole * whole;
            }
            p->size[i][j] = fmax(sqrt(sum), floor_of);
        }
        p->around[j] = sqrt(p->around[j]);
    }
}

/* The 95th percentile of relative errors at the probes: halves the range of its
 * logarithm. */
static double measure(const struct level *v, const struct probes *p)
{
    double at[PROBES][GROUP], whole = 0, low = -100, high = 100;

    for (int i = 0; i < PROBES; i++)
        for (int j = 0; j < GROUP; j++) {
            const double size = p->size[i][j] * v->s->scale;
            double sum = 0;
            for (int c = 0; c < 3; c++)
                sum += (double)p->rgb[i][c][j] * (double)p->rgb[i][c][j];
            at[i][j] = size > 0 ? sum / size / size : 0;
        }
    for (int j = 0; j < GROUP; j++)
        whole += PROBES * p->area[j];
    for (int step = 0; step < 20; step++) {
        const double middle = 0.5 * (low + high), limit = exp2(middle);
        double above = 0;
        for (int i = 0; i < PROBES; i++)
            for (int j = 0; j < GROUP; j++)
                above += at[i][j] > limit ? p->area[j] : 0;
        *(above > 0.05 * whole ? &low : &high) = middle;
    }
    return exp2(0.5 * high);
}

/* The 95th percentile of the rounding of floats at the probes. */
static double measure_noise(const struct level *v, struct probes *p)
{
    memset(p->rgb, 0, sizeof p->rgb);
    for (int i = 0; i < PROBES; i++)
        for (int j = 0; j < GROUP; j++)
            p->rgb[i][0][j] = (float)(noise_part * p->around[j]);
    return measure(v, p);
}

/* Fills tail[l], l = 0..most, with the rms of what the degrees above l add.
 * What those above the most would add is extrapolated from its last quarters.
 */
static void find_tails(const struct level *v, double *tail)
{
    const int most = v->target->most;
    double sum = 0;

    for (int l = most; l >= 0; l--) {
        tail[l] = sum;
        sum += v->kernel[l] * v->kernel[l] * v->s->power[l];
    }
    const double half = tail[most / 2], quarter = tail[most - most / 4];
    const double beyond = half > 0 ? quarter * quarter / half : 0;
    for (int l = 0; l <= most; l++)
        tail[l] = sqrt((tail[l] + beyond) / (4 * IBL_PI));
}

/* The first degree from SMALLEST on whose tail is at most `limit`, or the most.
 */
static int degree_below(const struct level *v, const double *tail, double limit)
{
    int l = SMALLEST < v->target->most ? SMALLEST : v->target->most;
    while (l < v->target->most && tail[l] > limit)
        l++;
    return l;
}

/*
 * Chooses the smallest degree that leaves at most its part of the tolerance.
 * How what a degree leaves falls is known from the power in each; how the 95th
 * percentile of its relative error compares with its rms is measured at the
 * probes, from the degrees up to half as high again.
 */
static ibl_status try_degrees(struct level *v, struct probes *p,
                              const double *tail)
{
    const int most = v->target->most;
    const double wanted = ibl_error_parts.degrees * v->target->tolerance;
    double ratio = 0;
    int seen = 0, last, next;

    while (seen < most && fabs(v->kernel[seen]) > small)
        seen++;
    ibl_status status = make_probes(v, p, 0, seen);
    if (status)
        return status;
    find_sizes(v, p);
    v->noise = measure_noise(v, p);
    next = degree_below(v, tail, wanted * mean_of(v->s) * v->s->scale);
    for (int i = 0; i < TRIES; i++) {
        last = next;
        const int from = last < most / 3 ? last : most / 3;
        const int until = 3 * from / 2 < most ? 3 * from / 2 : most;
        status = make_probes(v, p, from + 1, until);
        if (status)
            return status;
        const double rms =
            sqrt(tail[from] * tail[from] - tail[until] * tail[until]);
        ratio = rms > 0 ? measure(v, p) / rms : 0;
        next = degree_below(v, tail, ratio > 0 ? wanted / ratio : INFINITY);
        if (abs(next - last) <= last / 8)
            break;
    }
    v->degree = next;
    v->error = ibl_error_parts.elsewhere * ratio * tail[next];
    return IBL_OK;
}

static ibl_status choose_degree(struct level *v)
{
    const int most = v->target->most;
    struct probes *p = ibl_alloc_array(1, sizeof *p);
    ibl_status status =
        p ? ibl_ring_spectra_alloc(v->s->ctx, GROUP, most + 1, &p->spectra)
          : ibl_no_memory(v->s->ctx, "the degree of a level");
    if (!status) {
        p->factor = v->kernel + most + 1;
        for (int i = 0; i < PROBES; i++) {
            p->wave[i][0] = (float)cos(2 * IBL_PI * i / PROBES);
            p->wave[i][1] = (float)sin(2 * IBL_PI * i / PROBES);
        }
        find_tails(v, p->factor + most + 1);
        status = try_degrees(v, p, p->factor + most + 1);
        ibl_ring_spectra_free(&p->spectra);
    }
    ibl_free(p);
    return status;
}

/* ---- the grid ---------------------------------------------------------- */

static void rings_job(void *arg, int job, int worker)
{
    const struct level *v = arg;
    const int first = job * GROUP, rings = v->spectra.rings;
    const int count = rings - first < GROUP ? rings - first : GROUP;
    int south[GROUP], ring[GROUP];
    float *row[GROUP] = {NULL};

    for (int i = 0; i < count; i++) {
        const int at = first + i;
        south[i] = at >= rings / 2;
        ring[i] = v->first + (south[i] ? rings - 1 - at : at);
        row[i] = ibl_ring_grid_at(&v->grid, south[i], ring[i]);
    }
    ibl_row_fft_inverse(v->azimuth, &v->spectra, first, count,
                        v->scratch + (size_t)worker * v->scratch_floats, row);
    for (int i = 0; i < count; i++)
        ibl_ring_grid_close(&v->grid, south[i], ring[i]);
}

static ibl_status prepare_rings(struct level *v)
{
    const ibl_spectral *s = v->s;
    const int most = v->grid.pairs + 2 * IBL_GRID_BORDER;
    const int half = v->grid.rings / 2, pairs = most < half ? most : half;
    ibl_status status =
        ibl_ring_spectra_alloc(s->ctx, 2 * pairs, v->degree + 1, &v->spectra);
    if (!status)
        status = ibl_row_fft_create_inverse(s->ctx, v->grid.columns,
                                            v->degree + 1, &v->azimuth);
    if (status)
        return status;
    v->scratch_floats = (ibl_row_fft_scratch(v->azimuth) + 15) / 16 * 16;
    v->scratch = ibl_alloc_array((size_t)ibl_ctx_threads(s->ctx),
                                 v->scratch_floats * sizeof(float));
    return v->scratch ? IBL_OK : ibl_no_memory(s->ctx, "the rings of a level");
}

/* Fills the bands and what is around them. */
static ibl_status fill_bands(struct level *v)
{
    const ibl_ring_grid *g = &v->grid;
    const int before = g->first - IBL_GRID_BORDER;
    const int after = g->first + g->pairs + IBL_GRID_BORDER;
    const int end = after < g->rings / 2 ? after : g->rings / 2;

    v->first = before > 0 ? before : 0;
    v->spectra.rings = 2 * (end - v->first);
    const ibl_status status =
        ibl_sht_synthesise(v->s->ctx, &v->s->harmonics, v->kernel, v->degree,
                           g->rings, v->first, &v->spectra);
    return status
               ? status
               : ibl_run(v->s->ctx, NULL,
                         (v->spectra.rings + GROUP - 1) / GROUP, rings_job, v);
}

static void free_rings(struct level *v)
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
    const double error = ibl_error_parts.lights * v->target->tolerance;
    ibl_patch *patches;

    if (!s->light_count)
        return IBL_OK;
    patches = ibl_alloc_array((size_t)s->light_count, sizeof *patches);
    if (!patches)
        return ibl_no_memory(s->ctx, "the lights");
    for (int i = 0; i < s->light_count; i++)
        patches[i] = patch_of(s, &s->lights[i]);
    const ibl_status status = ibl_point_lights_create(
        s->ctx, patches, s->light_count, v->target->shape, error, &v->bright);
    ibl_free(patches);
    return status;
}

/* Makes the texels, band by band. */
static ibl_status fill_texels(struct level *v, const char *stage)
{
    const ibl_spectral *s = v->s;
    const ibl_spectral_target *t = v->target;
    const int half = v->grid.rings / 2, pairs = v->grid.pairs;
    const ibl_level_shape shape = ibl_map_shape(t->cube, t->level);
    const size_t rows = (size_t)shape.faces * (size_t)shape.height;
    const size_t tiles = (size_t)(shape.width - 1) / IBL_LEVEL_TILE + 1;
    ibl_level_sum sum = {.grid = &v->grid,
                         .bright = v->bright,
                         .range.gain = (float)(1 / s->scale)};
    ibl_status status = IBL_OK;

    memcpy(sum.range.offset, s->mean, sizeof s->mean);
    memcpy(sum.range.low, s->low, sizeof s->low);
    memcpy(sum.range.high, s->high, sizeof s->high);
    if (pairs < half) {
        sum.reach = ibl_alloc_array(rows, tiles * sizeof *sum.reach);
        if (!sum.reach)
            return ibl_no_memory(s->ctx, "the rings of a level");
    }
    for (int first = 0; first < half && !status; first += pairs) {
        ibl_progress(s->ctx, stage, first / (double)half);
        v->grid.first = first;
        v->grid.pairs = half - first < pairs ? half - first : pairs;
        status = fill_bands(v);
        if (!status)
            status = ibl_spectral_texels(s->ctx, &sum, t->cube, t->level);
    }
    if (!status)
        ibl_progress(s->ctx, stage, 1);
    ibl_free(sum.reach);
    return status;
}

ibl_status ibl_spectral_bake(ibl_spectral *s, const char *stage,
                             const ibl_spectral_target *target, int *degree,
                             double *error)
{
    struct level v = {.s = s, .target = target};
    const size_t count = (size_t)target->most + 1;

    v.kernel = ibl_alloc_array(3 * count, sizeof *v.kernel);
    ibl_status status = v.kernel ? ibl_lobe_coefficients(s->ctx, target->shape,
                                                         target->most, v.kernel)
                                 : ibl_no_memory(s->ctx, "a lobe");
    if (!status)
        status = make_lights(&v);
    if (!status)
        status = choose_degree(&v);
    const ibl_ring_grid grid = ibl_ring_grid_for(v.degree);
    if (!status)
        status = ibl_ring_grid_alloc(s->ctx, grid.rings, grid.columns,
                                     grid.pairs, &v.grid);
    if (!status)
        status = prepare_rings(&v);
    if (!status)
        status = fill_texels(&v, stage);
    *degree = v.degree;
    *error = v.error + v.noise +
             (ibl_error_parts.taps + ibl_error_parts.rounding) *
                 IBL_TOLERANCE_DEFAULT +
             (v.bright ? ibl_error_parts.lights * target->tolerance : 0);
    free_rings(&v);
    if (v.bright)
        ibl_point_lights_free(v.bright);
    ibl_free(v.kernel);
    return status;
}
