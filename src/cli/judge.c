/* SPDX-License-Identifier: MIT */
#include "cli/judge.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "cli/lookup.h"
#include "common/signals.h"
#include "json/json_text.h"

struct ibl_judge {
    ibl_reference *reference;
    ibl_spot *spots;
    double brightest[3], mean[3];
};

ibl_judge *ibl_judge_create(ibl_ctx *ctx, const ibl_image *env, double yaw_deg)
{
    ibl_judge *j = ibl_need(calloc(1, sizeof *j));
    double most = 0;

    *j = (ibl_judge){.spots = ibl_spots_of(env, yaw_deg),
                     .brightest = {0, 1, 0}};
    for (int i = 0; i < IBL_SPOTS; i++)
        if (j->spots[i].share > most) {
            most = j->spots[i].share;
            memcpy(j->brightest, j->spots[i].direction, sizeof j->brightest);
        }
    if (!ibl_reference_create(ctx, env, yaw_deg, &j->reference) &&
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

/* ---- rows ------------------------------------------------------------- */

static json_t *figure(double x)
{
    return isfinite(x) ? json_real(ibl_json_digits(x)) : json_null();
}

static void put_figures(json_t **row, const ibl_measured *m)
{
    json_t *errors = json_object();

    for (int f = 0; f < IBL_FIGURES; f++) {
        put(row, ibl_figure_names[f], figure(m->value[f]));
        put(&errors, ibl_figure_names[f], figure(m->error[f]));
    }
    put(row, "standard_error", errors);
}

static void begin(ibl_report *report)
{
    if (!report->json)
        report->json = json_pack("{si so}", "seed", report->options.seed,
                                 "levels", json_array());
}

/* The verdict on samples; worst_at: of each of them a direction, or a place in
 * a table. */
static json_t *row_of(ibl_report *report, const char *content, int level,
                      int size, ibl_seen *seen, size_t count, size_t nonfinite,
                      const double (*at)[3])
{
    const ibl_judge_options *o = &report->options;
    size_t worst = 0;

    begin(report);
    put(&report->json, "texels",
        o->all ? json_string("all") : json_integer(o->texels));
    for (size_t i = 0; i < count; i++)
        worst = seen[i].error > seen[worst].error ? i : worst;
    json_t *row =
        json_pack("{ss si si sI sI sf s[fff]}", "content", content, "level",
                  level, "size", size, "texels", (json_int_t)count, "nonfinite",
                  (json_int_t)nonfinite, "worst",
                  count ? ibl_json_digits(seen[worst].error) : 0, "worst_at",
                  count ? ibl_json_digits(at[worst][0]) : 0,
                  count ? ibl_json_digits(at[worst][1]) : 0,
                  count ? ibl_json_digits(at[worst][2]) : 0);
    const ibl_measured m = ibl_measured_of(seen, count);
    put_figures(&row, &m);
    return row;
}

static bool is_finite(const float *texel, int channels)
{
    bool finite = true;

    for (int c = 0; c < channels; c++)
        finite = finite && isfinite(texel[c]);
    return finite;
}

/* ---- levels ----------------------------------------------------------- */

/* The texels that are judged, what they stand for, and truths. */
typedef struct picks {
    size_t count;
    ibl_texel *at;
    double (*dir)[3], (*truth)[3];
    ibl_seen *seen; /* weights and batches */
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

static void choose(const ibl_judge_options *o, const ibl_judge *j,
                   const ibl_level_shape *s, picks *p)
{
    const size_t texels =
        (size_t)s->faces * (size_t)s->width * (size_t)s->height;
    const bool all = o->all || 2 * texels <= 3 * (size_t)o->texels;
    double u[IBL_DIMENSIONS];

    p->count = all ? texels : (size_t)o->texels;
    p->at = ibl_need(malloc(p->count * sizeof *p->at));
    p->dir = ibl_need(malloc(2 * p->count * sizeof *p->dir));
    p->truth = p->dir + p->count;
    p->seen = ibl_need(calloc(p->count, sizeof *p->seen));
    for (size_t i = 0; i < p->count; i++) {
        const int line = (int)(i / (size_t)s->width);
        int at[3] = {line / s->height, (int)(i % (size_t)s->width),
                     line % s->height};
        ibl_seen *seen = &p->seen[i];
        *seen = (ibl_seen){.weight = 1, .batch = -1};
        if (!all && !i) { /* certain: no other stands for it */
            ibl_level_texel(s, j->brightest, at);
        } else if (!all) {
            ibl_spread(o->seed, i, u);
            seen->batch = ibl_batch_of(i, p->count);
            seen->weight = 1 / draw(j, u, p->dir[i]);
            ibl_level_texel(s, p->dir[i], at);
            seen->weight /=
                ibl_level_solid_angle(s, at[1], at[2]) * (double)(p->count - 1);
        }
        p->at[i] = (ibl_texel){at[0], at[1], at[2]};
        if (i && !memcmp(&p->at[i], p->at, sizeof *p->at))
            seen->weight = 0;
        ibl_level_direction(s, at[0], at[1], at[2], p->dir[i]);
    }
}

/* Judges one level; NULL: failed. */
static json_t *judge_level(ibl_report *report, const ibl_judge *j,
                           const ibl_judged *of, int level)
{
    const int size = ibl_cube_edge(of->chain.size, level);
    const ibl_level_shape shape =
        ibl_level_shape_of(of->chain.projection, size);
    const float *texels = ibl_cube_face(&of->chain, level, 0);
    const double roughness = of->roughness ? of->roughness[level] : 0;
    const bool sky = of->content == IBL_OUTPUT_SKYBOX;
    const bool mirror = of->content == IBL_OUTPUT_SPECULAR && !(roughness > 0);
    const int line = shape.width, lines = shape.height;
    picks p;
    size_t count = 0, nonfinite = 0;
    json_t *row = NULL;

    choose(&report->options, j, &shape, &p);
    const bool ok =
        sky || mirror
            ? !ibl_reference_texels(j->reference, of->chain.projection,
                                    mirror ? size : of->chain.size, size, p.at,
                                    p.count, *p.truth)
        : of->content == IBL_OUTPUT_IRRADIANCE
            ? !ibl_reference_irradiance(j->reference, *p.dir, p.count, *p.truth)
            : !ibl_reference_lobe(j->reference, of->lobe, roughness, *p.dir,
                                  p.count, *p.truth);
    for (int i = 0; i < shape.faces * line * lines; i++)
        nonfinite += !is_finite(texels + 3 * (size_t)i, 3);
    for (size_t i = 0; i < p.count && ok; i++) {
        const ibl_texel *at = &p.at[i];
        const float *x =
            texels + 3 * ((size_t)(at->face * lines + at->y) * (size_t)line +
                          (size_t)at->x);
        const double got[3] = {(double)x[0], (double)x[1], (double)x[2]};
        if (!is_finite(x, 3) || p.seen[i].weight <= 0)
            continue;
        memcpy(p.dir[count], p.dir[i], sizeof *p.dir);
        p.seen[count] = p.seen[i];
        ibl_see(&p.seen[count++], got, p.truth[i], j->mean);
    }
    if (ok)
        row = row_of(report, ibl_output_content(of->content), level, size,
                     p.seen, count, nonfinite, (const double(*)[3])p.dir);
    if (ok && of->content == IBL_OUTPUT_SPECULAR)
        put_all(&row, json_pack("{ss sf}", "lobe", ibl_lobe_name(of->lobe),
                                "roughness", roughness));
    free(p.at);
    free(p.dir);
    free(p.seen);
    return row;
}

bool ibl_report_levels(ibl_report *report, const ibl_judge *judge,
                       const ibl_judged *of)
{
    begin(report);
    json_t *row, *levels = json_object_get(report->json, "levels");
    for (int l = 0; l < of->levels; l++) {
        if (!(row = judge_level(report, judge, of, l)))
            return false;
        json_array_append_new(levels, row);
    }
    return true;
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
    double *exact = ibl_need(malloc((size_t)count * sizeof *exact));
    double wrong = 0, all = 0;
    float irradiance[3 * TEXELS];
    const ibl_judged judged = {.content = IBL_OUTPUT_IRRADIANCE,
                               .chain = {N, 1, irradiance, 0}};
    json_t *row = NULL;

    for (int i = 0; i < TEXELS; i++) {
        double dir[3], rgb[3];
        ibl_cube_direction(N, i / N / N, i % N, i / N % N, dir);
        ibl_lookup_sh(sh, degree, dir, rgb);
        for (int c = 0; c < 3; c++)
            irradiance[3 * i + c] = (float)rgb[c];
    }
    if (!ibl_reference_sh(judge->reference, degree, exact))
        row = judge_level(report, judge, &judged, 0);
    for (int i = 0; i < count && row; i++) {
        wrong += (sh[i] - exact[i]) * (sh[i] - exact[i]);
        all += exact[i] * exact[i];
    }
    free(exact);
    if (row)
        put_all(&row, json_pack("{ss si sf}", "content", "harmonics", "level",
                                degree, "coefficients",
                                ibl_json_digits(
                                    sqrt(wrong / fmax(all, (double)FLT_MIN)))));
    return !json_object_set_new(report->json, "harmonics", row);
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
    const size_t most = all ? n * n : (size_t)o->texels;
    ibl_seen *seen = ibl_need(malloc(most * sizeof *seen));
    double(*place)[3] = ibl_need(calloc(most, sizeof *place));
    size_t count = 0, nonfinite = 0;
    bool ok = true;

    for (size_t i = 0; i < n * n; i++)
        nonfinite += !is_finite(lut->data + (size_t)channels * i, channels);
    for (size_t i = 0; i < most && ok; i++) {
        size_t at[2] = {i % n, i / n};
        ibl_seen s = {.weight = 1, .truth = channels, .batch = -1};
        double u[IBL_DIMENSIONS], truth[3];
        if (!all) { /* N.V and r by squares: they change most near 0 */
            s.batch = ibl_batch_of(i, most);
            ibl_spread(o->seed, i, u);
            for (int k = 0; k < 2; k++) {
                at[k] = (size_t)(u[k] * u[k] * (double)n);
                s.weight *= u[k];
            }
        }
        const float *x = lut->data + (size_t)channels * (at[1] * n + at[0]);
        for (int k = 0; k < 2; k++)
            place[count][k] = ((double)at[k] + 0.5) / lut->size;
        ok = integrate(ctx, lut->kind, place[count], geometry, truth);
        for (int c = 0; c < channels && ok; c++) {
            const double off =
                fabs((double)x[c] - truth[c]) / fmax(truth[c], 1);
            s.error = fmax(s.error, off);
            s.wrong += off * off;
        }
        if (ok && is_finite(x, channels))
            seen[count++] = s;
    }
    if (ok)
        put(&report->json, "lut",
            row_of(report, ibl_output_content(IBL_OUTPUT_LUT), 0, lut->size,
                   seen, count, nonfinite, (const double(*)[3])place));
    free(seen);
    free(place);
    return ok;
}

/* ---- what is rendered -----------------------------------------------------
 */

void ibl_report_drawn(ibl_report *report, const ibl_truth *truth,
                      const ibl_drawn *set)
{
    const ibl_truth_options *o = &truth->options;
    const int n = o->roughness_count;
    ibl_measured *rows = ibl_need(malloc((size_t)truth->rows * sizeof *rows));
    json_t *list[] = {json_array(), json_array()}; /* rows and means */

    ibl_measure(truth, set, rows);
    for (int i = 0; i < truth->rows + o->f0_count; i++) {
        const int f0 = i / (n + 1), r = i % (n + 1);
        const ibl_measured m =
            r < n ? rows[f0 * n + r] : ibl_measured_mean(rows + f0 * n, n);
        json_t *row = json_pack("{sf}", "f0", o->f0[f0]);
        if (r < n)
            put(&row, "roughness", json_real(o->roughness[r]));
        put_figures(&row, &m);
        append(&list[r == n], row);
    }
    free(rows);
    begin(report);
    put(&report->json, "rendered",
        json_pack("{ss si so so}", "shader", ibl_shader_names[set->shader],
                  "directions", o->directions, "rows", list[0], "means",
                  list[1]));
}
