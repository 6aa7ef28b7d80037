/* SPDX-License-Identifier: MIT */
#include "cli/judge.h"

#include <assert.h>
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "cli/faces.h"
#include "cli/lookup.h"

enum {
    GRID = 16 /* cells along a face's edge, for a heat map */
};

struct ibl_judge {
    ibl_judge_options opts;
    ibl_reference *reference;
    ibl_spot *spots;
    double brightest[3], mean[3];
};

ibl_judge_options ibl_judge_options_default(void)
{
    return (ibl_judge_options){.texels = 128, .seed = 1};
}

ibl_judge *ibl_judge_create(ibl_ctx *ctx, const ibl_image *env, double yaw_deg,
                            const ibl_judge_options *opts)
{
    ibl_judge *j = calloc(1, sizeof *j);

    if (!j)
        return NULL;
    *j = (ibl_judge){.opts = *opts,
                     .spots = ibl_spots_of(env, yaw_deg),
                     .brightest = {0, 1, 0}};
    double most = 0;
    for (int i = 0; j->spots && i < IBL_SPOTS; i++)
        if (j->spots[i].share > most) {
            most = j->spots[i].share;
            memcpy(j->brightest, j->spots[i].direction, sizeof j->brightest);
        }
    if (j->spots && !ibl_reference_create(ctx, env, yaw_deg, &j->reference) &&
        !ibl_reference_mean(j->reference, j->mean))
        return j;
    ibl_judge_free(j);
    return NULL;
}

void ibl_judge_free(ibl_judge *j)
{
    if (j) {
        ibl_reference_free(j->reference);
        free(j->spots);
    }
    free(j);
}

/* ---- levels ----------------------------------------------------------- */

/* The texels that are judged, what they stand for, and truths. */
typedef struct picks {
    size_t count; /* those after the first `judged` are only for a heat map */
    size_t judged;
    ibl_texel *at;
    double *dirs, *truth; /* 3 for each */
    ibl_seen *seen;       /* weights and batches */
} picks;

/* Draws a direction; returns its density by solid angle. */
static double draw(const ibl_judge *j, const double *u, double dir[3])
{
    const ibl_spot *spot = ibl_spot_at(j->spots, 2 * u[0]);
    const double even = 1 / (4 * M_PI);
    double density = 0;

    if (spot && u[0] < 0.5)
        ibl_around(spot->direction, ibl_spot_draw(spot->spread, u[1]),
                   2 * M_PI * u[2], dir);
    else
        ibl_around(NULL, 1 - 2 * u[1], 2 * M_PI * u[2], dir);
    for (const ibl_spot *s = j->spots; spot && s < j->spots + IBL_SPOTS; s++)
        if (s->share > 0)
            density += s->share *
                       ibl_spot_density(s->spread, ibl_dot(s->direction, dir));
    return spot ? 0.5 * density + 0.5 * even : even;
}

static bool choose(const ibl_judge *j, const ibl_level_shape *s, picks *p)
{
    const size_t texels =
        (size_t)s->faces * (size_t)s->width * (size_t)s->height;
    const bool all = j->opts.all || 2 * texels <= 3 * (size_t)j->opts.texels;
    double u[IBL_DIMENSIONS];

    p->judged = all ? texels : (size_t)j->opts.texels;
    p->count = p->judged + (j->opts.grid ? IBL_FACES * GRID * GRID : 0);
    p->at = malloc(p->count * sizeof *p->at);
    p->dirs = malloc(6 * p->count * sizeof *p->dirs);
    p->truth = p->dirs + 3 * p->count;
    p->seen = calloc(p->count, sizeof *p->seen);
    for (size_t i = 0; p->at && p->dirs && p->seen && i < p->count; i++) {
        const int line = (int)(i / (size_t)s->width);
        const int cell = (int)(i - p->judged);
        double *dir = p->dirs + 3 * i;
        p->seen[i].weight = 1;
        p->seen[i].batch = -1;
        if (i < p->judged && all) {
            p->at[i] =
                (ibl_texel){line / s->height, (int)(i % (size_t)s->width),
                            line % s->height};
        } else if (i == 0) { /* certain: no other stands for it */
            p->at[i] = ibl_level_hit(s, j->brightest);
        } else if (i < p->judged) {
            p->seen[i].batch = ibl_batch_of(i, p->judged);
            ibl_spread(j->opts.seed, i, u);
            p->seen[i].weight = 1 / draw(j, u, dir);
            p->at[i] = ibl_level_hit(s, dir);
            p->seen[i].weight /=
                ibl_level_solid_angle(s, p->at[i].x, p->at[i].y) *
                (double)(p->judged - 1);
            if (!memcmp(&p->at[i], p->at, sizeof *p->at))
                p->seen[i].weight = 0;
        } else {
            ibl_cube_direction(GRID, cell / GRID / GRID, cell % GRID,
                               cell / GRID % GRID, dir);
            p->at[i] = ibl_level_hit(s, dir);
        }
        ibl_level_direction(s, p->at[i].face, p->at[i].x, p->at[i].y, dir);
    }
    return p->at && p->dirs && p->seen;
}

static ibl_status find_truth(const ibl_judge *j, const ibl_judge_level *level,
                             const picks *p)
{
    const bool mirror =
        level->content == IBL_OUTPUT_SPECULAR && !(level->roughness > 0);

    if (level->content == IBL_OUTPUT_SKYBOX || mirror)
        return ibl_reference_texels(j->reference, level->texels.projection,
                                    mirror ? level->texels.size : level->base,
                                    level->texels.size, p->at, p->count,
                                    p->truth);
    return level->content == IBL_OUTPUT_IRRADIANCE
               ? ibl_reference_irradiance(j->reference, p->dirs, p->count,
                                          p->truth)
               : ibl_reference_lobe(j->reference, level->lobe, level->roughness,
                                    p->dirs, p->count, p->truth);
}

static bool is_finite(const float *texel, int channels)
{
    bool finite = true;

    for (int c = 0; c < channels; c++)
        finite = finite && isfinite(texel[c]);
    return finite;
}

/* Adds a sample to those that were seen. */
static void add(ibl_verdict *v, ibl_seen *seen, ibl_seen s, const double at[3])
{
    if (!v->count || s.error > v->worst) {
        v->worst = s.error;
        memcpy(v->worst_at, at, sizeof v->worst_at);
    }
    seen[v->count++] = s;
}

static void judge_texel(const ibl_judge *j, const ibl_judge_level *level,
                        const picks *p, size_t i, ibl_verdict *v)
{
    const ibl_level_shape shape =
        ibl_level_shape_of(level->texels.projection, level->texels.size);
    const float *x = ibl_level_at(level->texels.data, &shape, p->at[i]);
    const double *truth = p->truth + 3 * i;
    ibl_seen s = p->seen[i];
    double got[3];

    if (!is_finite(x, 3))
        return;
    for (int c = 0; c < 3; c++) {
        got[c] = (double)x[c] / level->scale;
        s.wrong += (got[c] - truth[c]) * (got[c] - truth[c]);
        s.truth += truth[c] * truth[c];
        s.light[0] += truth[c];
        s.light[1] += got[c];
        v->over |=
            level->pixel != IBL_PIXEL_COUNT &&
            truth[c] * level->scale > (double)ibl_pixel_max(level->pixel);
    }
    s.error = ibl_relative_error(got, truth, j->mean);
    ibl_judged *judged = &v->texels[v->texel_count++];
    memcpy(judged->direction, p->dirs + 3 * i, sizeof judged->direction);
    judged->error = s.error;
    if (i < p->judged && s.weight > 0)
        add(v, p->seen, s, judged->direction);
}

bool ibl_report_level(ibl_report *report, const ibl_judge *judge,
                      const ibl_judge_level *level)
{
    assert(report->count < IBL_REPORT_ROWS);
    const ibl_level_shape shape =
        ibl_level_shape_of(level->texels.projection, level->texels.size);
    ibl_verdict *v = &report->rows[report->count++];
    picks p = {0};

    *v = (ibl_verdict){.level = *level};
    v->level.texels.data = NULL;
    bool ok = choose(judge, &shape, &p) && !find_truth(judge, level, &p) &&
              (v->texels = malloc(p.count * sizeof *v->texels));
    for (int i = 0; i < shape.faces * shape.width * shape.height; i++)
        v->nonfinite += !is_finite(level->texels.data + 3 * (size_t)i, 3);
    for (size_t i = 0; i < p.count && ok; i++)
        judge_texel(judge, level, &p, i, v);
    if (ok)
        v->measured = ibl_measured_of(p.seen, v->count);
    free(p.at);
    free(p.dirs);
    free(p.seen);
    return ok;
}

/* ---- harmonics ------------------------------------------------------------
 */

bool ibl_report_sh(ibl_report *report, const ibl_judge *judge, int degree,
                   const double *sh)
{
    enum {
        N = 4,
        TEXELS = IBL_FACES * N * N
    };
    const int count = 3 * (degree + 1) * (degree + 1);
    double *exact = malloc((size_t)count * sizeof *exact), wrong = 0, all = 0;
    float irradiance[3 * TEXELS];
    const ibl_judge_level level = {.content = IBL_OUTPUT_IRRADIANCE,
                                   .scale = 1,
                                   .texels = {N, 1, irradiance, 0},
                                   .pixel = IBL_PIXEL_COUNT};

    for (int i = 0; i < TEXELS; i++) {
        double dir[3], rgb[3];
        ibl_cube_direction(N, i / N / N, i % N, i / N % N, dir);
        ibl_lookup_sh(sh, degree, dir, rgb);
        for (int c = 0; c < 3; c++)
            irradiance[3 * i + c] = (float)rgb[c];
    }
    const bool ok = exact &&
                    !ibl_reference_sh(judge->reference, degree, exact) &&
                    ibl_report_level(report, judge, &level);
    for (int i = 0; i < count && ok; i++) {
        wrong += (sh[i] - exact[i]) * (sh[i] - exact[i]);
        all += exact[i] * exact[i];
    }
    if (ok) {
        ibl_verdict *v = &report->rows[report->count - 1];
        v->level.content = IBL_OUTPUT_JSON;
        v->level.number = degree;
        v->coefficients = sqrt(wrong / fmax(all, (double)FLT_MIN));
    }
    free(exact);
    return ok;
}

/* ---- tables ---------------------------------------------------------------
 */

/* The integrals that a table's channels are of. */
static bool integrate(ibl_ctx *ctx, ibl_lut_kind kind, const double at[3],
                      ibl_geometry geometry, double truth[3])
{
    double split[2] = {0}, sheen[2] = {0};

    if (kind && ibl_reference_sheen(ctx, at[0], at[1], sheen))
        return false;
    if (kind != IBL_LUT_CHARLIE &&
        ibl_reference_lut(ctx, at[0], at[1], geometry, split))
        return false;
    const double all[][3] = {
        [IBL_LUT_SPLIT] = {split[0], split[1]},
        [IBL_LUT_MULTISCATTER] = {split[1], split[0] + split[1], sheen[0]},
        [IBL_LUT_CHARLIE] = {sheen[0], sheen[1]}};
    memcpy(truth, all[kind], sizeof all[kind]);
    return true;
}

bool ibl_report_lut(ibl_report *report, ibl_ctx *ctx, const ibl_lut *lut,
                    ibl_geometry geometry)
{
    const ibl_judge_options *o = &report->options;
    const int channels = ibl_lut_channels(lut->kind);
    const size_t n = (size_t)lut->size;
    const bool all = o->all || 2 * n * n <= 3 * (size_t)o->texels;
    const size_t count = all ? n * n : (size_t)o->texels;
    ibl_verdict *v = &report->rows[report->count++];
    ibl_seen *seen = malloc(count * sizeof *seen);
    bool ok = seen;

    *v = (ibl_verdict){.level = {.content = IBL_OUTPUT_LUT}};
    v->level.texels.size = lut->size;
    for (size_t i = 0; i < n * n; i++)
        v->nonfinite += !is_finite(lut->data + (size_t)channels * i, channels);
    for (size_t i = 0; i < count && ok; i++) {
        size_t at[2] = {i % n, i / n};
        ibl_seen s = {.weight = 1, .truth = channels, .batch = -1};
        double u[IBL_DIMENSIONS], truth[3];
        if (!all) { /* N.V and r by squares: they change most near 0 */
            s.batch = ibl_batch_of(i, count);
            ibl_spread(o->seed, i, u);
            for (int k = 0; k < 2; k++) {
                at[k] = (size_t)(u[k] * u[k] * (double)n);
                s.weight *= u[k];
            }
        }
        const float *x = lut->data + (size_t)channels * (at[1] * n + at[0]);
        const double place[3] = {((double)at[0] + 0.5) / lut->size,
                                 ((double)at[1] + 0.5) / lut->size};
        ok = integrate(ctx, lut->kind, place, geometry, truth);
        for (int c = 0; c < channels && ok; c++) {
            const double off =
                fabs((double)x[c] - truth[c]) / fmax(truth[c], 1);
            s.error = fmax(s.error, off);
            s.wrong += off * off;
        }
        if (ok && is_finite(x, channels))
            add(v, seen, s, place);
    }
    if (ok)
        v->measured = ibl_measured_of(seen, v->count);
    free(seen);
    return ok;
}

/* ---- what is rendered -----------------------------------------------------
 */

bool ibl_report_drawn(ibl_report *report, const ibl_truth *truth,
                      const ibl_drawn *set, const ibl_reference *rest)
{
    const ibl_truth_options *o = &truth->options;
    const int n = o->roughness_count;
    ibl_measured *rows = malloc((size_t)truth->rows * sizeof *rows);
    const bool ok = rows && ibl_measure(truth, set, rest, rows);

    assert(truth->rows + o->f0_count <= IBL_DRAWN_ROWS);
    report->shader = set->shader;
    report->directions = o->directions;
    report->drawn_count = report->vague = 0;
    for (int i = 0; i < truth->rows && ok; i++) {
        report->drawn[report->drawn_count++] =
            (ibl_drawn_row){o->f0[i / n], o->roughness[i % n], rows[i]};
        if (i % n == n - 1)
            report->drawn[report->drawn_count++] = (ibl_drawn_row){
                o->f0[i / n], NAN, ibl_measured_mean(rows + i + 1 - n, n)};
    }
    for (int i = 0; i < report->drawn_count; i++)
        report->vague += ibl_measured_is_vague(&report->drawn[i].measured);
    free(rows);
    return ok;
}

void ibl_report_free(ibl_report *report)
{
    for (int i = 0; i < report->count; i++)
        free(report->rows[i].texels);
    report->count = 0;
}
