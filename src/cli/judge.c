/* SPDX-License-Identifier: MIT */
#include "cli/judge.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "cli/faces.h"

enum {
    COARSE = 32,     /* columns of the reduced map that finds the dark texels */
    DARK_TENTH = 10, /* one cell or texel in this many is dark */
    CELLS = IBL_FACES * IBL_DARK_CELLS * IBL_DARK_CELLS
};

/* The chosen texels of a level and their reference values, kept for the next
 * level with the same properties. */
typedef struct known {
    ibl_output_kind content;
    ibl_lobe lobe;
    double roughness;
    ibl_projection projection;
    int base, size;
    size_t count;
    ibl_judged_texel *picks;
    double *truth; /* [count][3], linear RGB */
    struct known *next;
} known;

struct ibl_judge {
    ibl_ctx *ctx;
    ibl_judge_options opts;
    ibl_reference *reference;
    ibl_image coarse;
    ibl_reference *coarse_reference;
    ibl_pick_scene scene; /* shape and dark are unset */
    double mean[3];
    known *known;
};

ibl_judge_options ibl_judge_options_default(void)
{
    return (ibl_judge_options){.texels = IBL_JUDGE_TEXELS, .seed = 1};
}

void ibl_verdict_free(ibl_verdict *v)
{
    if (!v)
        return;
    free(v->texels);
    *v = (ibl_verdict){0};
}

/* Encodes and decodes a pixel's channels in its format. */
static void round_to(ibl_pixel pixel, float values[4])
{
    unsigned char bytes[16];

    ibl_pixel_encode(pixel, values, 1, bytes);
    ibl_pixel_decode(pixel, bytes, 1, values);
}

static bool is_of_blocks(ibl_pixel pixel)
{
    return pixel != IBL_PIXEL_COUNT && ibl_pixel_block(pixel) > 1;
}

void ibl_judge_loss(ibl_pixel pixel, double scale, const double *values, int n,
                    double *loss)
{
    const bool rounds = pixel != IBL_PIXEL_COUNT && !is_of_blocks(pixel);
    float rounded[4] = {0};

    for (int c = 0; c < n; c++)
        rounded[c] = (float)(values[c] * scale);
    if (rounds)
        round_to(pixel, rounded);
    for (int c = 0; c < n; c++)
        loss[c] = rounds ? (double)rounded[c] / scale - values[c] : 0;
}

/* ---- the judge ------------------------------------------------------- */

/* Reduces a map; each small pixel is the mean of the pixels it covers. */
static void shrink(const ibl_image *env, ibl_image *small)
{
    for (int j = 0; j < small->height; j++)
        for (int i = 0; i < small->width; i++) {
            double rgb[3];
            ibl_mean_rgb(env->data, env->width,
                         (int)((long long)i * env->width / small->width),
                         (int)((i + 1LL) * env->width / small->width),
                         (int)((long long)j * env->height / small->height),
                         (int)((j + 1LL) * env->height / small->height), rgb);
            for (int k = 0; k < 3; k++)
                small->data[3 * (j * small->width + i) + k] = (float)rgb[k];
        }
}

static int at_most(int n, int most)
{
    return n < most ? n : most;
}

ibl_judge *ibl_judge_create(ibl_ctx *ctx, const ibl_image *env, double yaw_deg,
                            const ibl_judge_options *opts)
{
    ibl_judge *j = calloc(1, sizeof *j);

    if (!j)
        return NULL;
    j->ctx = ctx;
    j->opts = *opts;
    bool ok = !ibl_image_alloc(ctx, at_most(env->width, COARSE),
                               at_most(env->height, COARSE / 2), &j->coarse);
    if (ok)
        shrink(env, &j->coarse);
    ok =
        ok && !ibl_reference_create(ctx, env, yaw_deg, &j->reference) &&
        !ibl_reference_create(ctx, &j->coarse, yaw_deg, &j->coarse_reference) &&
        !ibl_reference_mean(j->reference, j->mean);
    if (!ok) {
        ibl_judge_free(j);
        return NULL;
    }
    j->scene.light_count =
        ibl_find_lights(env, yaw_deg, IBL_JUDGE_LIGHTS, j->scene.lights);
    return j;
}

static void free_known(known *k)
{
    if (!k)
        return;
    free(k->picks);
    free(k->truth);
    free(k);
}

void ibl_judge_free(ibl_judge *j)
{
    if (!j)
        return;
    while (j->known) {
        known *next = j->known->next;
        free_known(j->known);
        j->known = next;
    }
    ibl_reference_free(j->coarse_reference);
    ibl_reference_free(j->reference);
    ibl_image_free(&j->coarse);
    free(j);
}

/* ---- truth ----------------------------------------------------------- */

static int by_value(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* The reference values in count directions; for SKYBOX the map's values. */
static bool convolve(const ibl_reference *reference, const known *k,
                     const double *dirs, size_t count, double *rgb)
{
    return !(k->content == IBL_OUTPUT_IRRADIANCE
                 ? ibl_reference_irradiance(reference, dirs, count, rgb)
                 : ibl_reference_lobe(reference, k->lobe, k->roughness, dirs,
                                      count, rgb));
}

/* Marks the darkest tenth of the level's cells, judged by the small map. */
static bool find_dark(const ibl_judge *j, const known *k, ibl_pick_scene *scene)
{
    double dirs[3 * CELLS] = {0}, rgb[3 * CELLS];
    double value[CELLS] = {0}, sorted[CELLS];
    const ibl_level_shape cells = {k->projection, IBL_DARK_CELLS,
                                   IBL_DARK_CELLS, scene->shape.faces};
    const size_t count = CELLS / IBL_FACES * (size_t)cells.faces;

    for (size_t c = 0; c < count; c++)
        ibl_level_direction(
            &cells, (int)c / (CELLS / IBL_FACES), (int)c % IBL_DARK_CELLS,
            (int)c / IBL_DARK_CELLS % IBL_DARK_CELLS, dirs + 3 * c);
    if (!convolve(j->coarse_reference, k, dirs, count, rgb))
        return false;
    for (size_t c = 0; c < count; c++)
        value[c] = rgb[3 * c] + rgb[3 * c + 1] + rgb[3 * c + 2];
    memcpy(sorted, value, sizeof sorted);
    qsort(sorted, count, sizeof *sorted, by_value);
    for (size_t c = 0; c < count; c++)
        scene->dark[c] = value[c] <= sorted[count / DARK_TENTH];
    return true;
}

static bool find_truth(const ibl_judge *j, known *k)
{
    const ibl_level_shape shape = ibl_level_shape_of(k->projection, k->size);
    double *dirs = malloc(3 * k->count * sizeof *dirs);
    ibl_texel *texels = malloc(k->count * sizeof *texels);
    bool ok = false;

    k->truth = malloc(3 * k->count * sizeof *k->truth);
    if (dirs && texels && k->truth) {
        for (size_t i = 0; i < k->count; i++) {
            const ibl_texel at = texels[i] = k->picks[i].at;
            ibl_level_direction(&shape, at.face, at.x, at.y, dirs + 3 * i);
        }
        ok = k->content == IBL_OUTPUT_SKYBOX
                 ? !ibl_reference_texels(j->reference, k->projection, k->base,
                                         k->size, texels, k->count, k->truth)
                 : convolve(j->reference, k, dirs, k->count, k->truth);
    }
    free(dirs);
    free(texels);
    return ok;
}

/* A copy of want with texels and reference values; NULL on failure. */
static known *make_known(const ibl_judge *j, const known *want)
{
    ibl_pick_scene scene = j->scene;
    known *k = malloc(sizeof *k);

    if (!k)
        return NULL;
    *k = *want;
    scene.shape = ibl_level_shape_of(k->projection, k->size);
    if (find_dark(j, k, &scene) &&
        ibl_picks(&scene, &j->opts, &k->picks, &k->count) && find_truth(j, k))
        return k;
    free_known(k);
    return NULL;
}

static const known *find_known(ibl_judge *j, const ibl_judge_level *level)
{
    const bool lobe =
        level->content == IBL_OUTPUT_SPECULAR && level->roughness > 0;
    const known want = {
        .content = level->content == IBL_OUTPUT_SPECULAR && !lobe
                       ? IBL_OUTPUT_SKYBOX
                       : level->content,
        .lobe = lobe ? level->lobe : IBL_LOBE_GGX,
        .roughness = lobe ? level->roughness : 0,
        .projection = level->projection,
        .base = level->content == IBL_OUTPUT_SKYBOX ? level->base : level->size,
        .size = level->size};

    for (const known *k = j->known; k; k = k->next)
        if (k->content == want.content && k->size == want.size &&
            k->projection == want.projection && k->base == want.base &&
            k->lobe == want.lobe && k->roughness == want.roughness)
            return k;
    known *made = make_known(j, &want);
    if (made) {
        made->next = j->known;
        j->known = made;
    }
    return made;
}

/* ---- statistics ------------------------------------------------------ */

static ibl_level_shape shape_of(const ibl_judge_level *level)
{
    return ibl_level_shape_of(level->projection, level->size);
}

static bool is_finite(const float *rgb)
{
    return isfinite(rgb[0]) && isfinite(rgb[1]) && isfinite(rgb[2]);
}

/* Finds the bias of the whole level; counts the texels that are not finite. */
static void survey(const ibl_judge *j, const ibl_judge_level *level,
                   ibl_verdict *v)
{
    const ibl_level_shape s = shape_of(level);
    const int texels = s.faces * s.width * s.height;
    double sum = 0, total = 0;

    for (int i = 0; i < texels; i++) {
        const float *x = level->texels + 3 * (size_t)i;
        const double w =
            ibl_level_solid_angle(&s, i % s.width, i / s.width % s.height);
        if (is_finite(x)) {
            sum += w * ((double)x[0] + (double)x[1] + (double)x[2]);
            total += w;
        } else {
            v->nonfinite++;
        }
    }
    const double source = j->mean[0] + j->mean[1] + j->mean[2];
    const double mean = total > 0 ? sum / total / level->scale : 0;
    v->bias = (mean - source) / fmax(source, (double)FLT_MIN);
}

/* Whether a texel or a neighbour holds at least max in a channel. */
static bool is_by_full(const ibl_judge_level *level, ibl_texel at, int channel,
                       float max)
{
    const ibl_level_shape s = shape_of(level);

    for (int k = 0; k < 9; k++) {
        ibl_texel t;
        if (ibl_level_neighbour(&s, at, k % 3 - 1, k / 3 - 1, &t) &&
            ibl_level_at(level->texels, &s, t)[channel] >= max)
            return true;
    }
    return false;
}

static int by_error(const void *a, const void *b)
{
    const ibl_judged_texel *x = a, *y = b;
    return (x->error > y->error) - (x->error < y->error);
}

/* The smallest error that at least `part` of the weight does not exceed. texels
 * must be sorted by error. */
static double quantile(const ibl_judged_texel *texels, size_t count,
                       double part)
{
    double total = 0, sum = 0;

    for (size_t i = 0; i < count; i++)
        total += texels[i].weight;
    for (size_t i = 0; i < count; i++) {
        sum += texels[i].weight;
        if (sum >= part * total)
            return texels[i].error;
    }
    return 0;
}

ibl_error_spread ibl_error_spread_of(ibl_judged_texel *texels, size_t count)
{
    qsort(texels, count, sizeof *texels, by_error);
    return (ibl_error_spread){.count = count,
                              .median = quantile(texels, count, 0.5),
                              .p95 = quantile(texels, count, 0.95),
                              .worst = count ? texels[count - 1].error : 0};
}

static int by_darkness(const void *a, const void *b)
{
    const ibl_judged_texel *x = a, *y = b;
    return (x->value > y->value) - (x->value < y->value);
}

/* Sorts texels by darkness; returns how many make up the darkest tenth of the
 * weight. */
static size_t sort_dark(ibl_judged_texel *texels, size_t count)
{
    double total = 0, sum = 0;
    size_t n = 0;

    for (size_t i = 0; i < count; i++)
        total += texels[i].weight;
    qsort(texels, count, sizeof *texels, by_darkness);
    while (n < count &&
           (sum < total / DARK_TENTH || texels[n].value <= texels[n - 1].value))
        sum += texels[n++].weight;
    return n;
}

/* Weighted sums of squares. */
typedef struct squares {
    double wrong, truth, rounding, overflow;
} squares;

/* Adds a chosen texel to the sums and to the verdict. */
static void judge_texel(const ibl_judge *j, const ibl_judge_level *level,
                        const ibl_judged_texel *pick, const double truth[3],
                        const float max[3], squares *sums, ibl_verdict *v)
{
    const ibl_level_shape shape = shape_of(level);
    const float *x = ibl_level_at(level->texels, &shape, pick->at);
    squares s = {0};
    double got[3], loss[3];

    ibl_judge_loss(level->pixel, level->scale, truth, 3, loss);
    for (int c = 0; c < 3; c++) {
        got[c] = (double)x[c] / level->scale;
        const double error = got[c] - truth[c];
        s.wrong += error * error;
        s.truth += truth[c] * truth[c];
        if (truth[c] * level->scale > (double)max[c] ||
            (error > 0 && is_by_full(level, pick->at, c, max[c])))
            s.overflow += error * error;
        else
            s.rounding += loss[c] * loss[c];
    }
    sums->wrong += pick->weight * s.wrong;
    sums->truth += pick->weight * s.truth;
    sums->rounding += pick->weight * s.rounding;
    sums->overflow += pick->weight * s.overflow;
    ibl_judged_texel *texel = &v->texels[v->error.count++];
    *texel = *pick;
    texel->value = truth[0] + truth[1] + truth[2];
    texel->error = ibl_relative_error(got, truth, j->mean);
    if (v->error.count == 1 || texel->error > v->error.worst) {
        v->error.worst = texel->error;
        ibl_level_direction(&shape, pick->at.face, pick->at.x, pick->at.y,
                            v->worst_dir);
    }
}

/* The largest values of a pixel format. A block with one may be off by some
 * percent. */
static void find_max(ibl_pixel pixel, float max[4])
{
    for (int c = 0; c < 3; c++)
        max[c] = is_of_blocks(pixel) ? 0.95F * ibl_pixel_max(pixel) : FLT_MAX;
    if (pixel != IBL_PIXEL_COUNT && !is_of_blocks(pixel))
        round_to(pixel, max);
}

static bool compare(const ibl_judge *j, const ibl_judge_level *level,
                    const known *k, ibl_verdict *v)
{
    const ibl_level_shape shape = shape_of(level);
    squares sums = {0};
    float max[4];

    find_max(level->pixel, max);
    v->texels = malloc(k->count * sizeof *v->texels);
    ibl_judged_texel *sorted = malloc(k->count * sizeof *sorted);
    if (!v->texels || !sorted) {
        free(sorted);
        return false;
    }
    for (size_t i = 0; i < k->count; i++)
        if (is_finite(ibl_level_at(level->texels, &shape, k->picks[i].at)))
            judge_texel(j, level, &k->picks[i], k->truth + 3 * i, max, &sums,
                        v);
    const size_t count = v->error.count;
    memcpy(sorted, v->texels, count * sizeof *sorted);
    v->error = ibl_error_spread_of(sorted, count);
    v->dark = ibl_error_spread_of(sorted, sort_dark(sorted, count));
    free(sorted);
    const double truth = fmax(sqrt(sums.truth), (double)FLT_MIN);
    v->nrmse = sqrt(sums.wrong) / truth;
    v->rounding = sqrt(sums.rounding) / truth;
    v->overflow = sqrt(sums.overflow) / truth;
    if (sums.wrong > 0) {
        v->rounding_share = fmin(sums.rounding / sums.wrong, 1);
        v->overflow_share = sums.overflow / sums.wrong;
    }
    if (is_of_blocks(level->pixel)) {
        const double share = level->loss / fmax(v->nrmse, (double)FLT_MIN);
        v->rounding = level->loss;
        v->rounding_share = share < 1 ? share * share : share - share + 1;
    }
    return true;
}

bool ibl_judge_cube_level(ibl_judge *judge, const ibl_judge_level *level,
                          ibl_verdict *out)
{
    const known *k = find_known(judge, level);

    *out = (ibl_verdict){.level = *level, .nonfinite = level->mended};
    out->level.texels = NULL;
    if (k && compare(judge, level, k, out)) {
        survey(judge, level, out);
        return true;
    }
    ibl_verdict_free(out);
    return false;
}
