/* SPDX-License-Identifier: MIT */
#include "view/truth.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "common/process.h"
#include "common/signals.h"
#include "view/gl.h"
#include "view/settings.h"

/* ---- the table of lights ----------------------------------------------- */

/* Least share of the light above the mean that the table is made for: less is
 * rounding in an even environment, and would only add noise. */
static const double worth = 1.0 / 64;

/* Gives each token k the cell where the running sum of light reaches (k + 1/2)
 * / VIEW_AIM_TOKENS of all. Cells follow a Morton curve (Morton 1966): in rows,
 * sequences of numbers converge more slowly. chance holds light before, chances
 * after. */
void view_aim_make(const ibl_image *map, view_aim *aim)
{
    const int width = map->width < VIEW_AIM_MOST ? map->width : VIEW_AIM_MOST;
    const int height =
        map->height < VIEW_AIM_MOST ? map->height : VIEW_AIM_MOST;
    const size_t count = (size_t)width * (size_t)height;
    double all = 0, above = 0, sum = 0;
    unsigned side = 1;
    int token = 0;

    *aim = (view_aim){width, height, ibl_need(calloc(count, sizeof(float))),
                      ibl_need(malloc(VIEW_AIM_TOKENS * sizeof(float)))};
    for (int i = 0; i < 2 * map->height; i++) {
        const bool second = i >= map->height;
        const int y = i % map->height;
        const double angle =
            2 * M_PI / map->width *
            (cos(M_PI * y / map->height) - cos(M_PI * (y + 1) / map->height));
        const float *p = map->data + (size_t)3 * y * map->width;
        float *row = aim->chance + (size_t)y * height / map->height * width;
        for (int x = 0; x < map->width; x++, p += 3) {
            const double bright = (double)p[0] + p[1] + p[2];
            const double mean = second ? all / (4 * M_PI) : 0;
            const double light = fmax(bright - mean, 0) * angle;
            *(second ? &above : &all) += light;
            row[(size_t)x * width / map->width] += second ? (float)light : 0;
        }
    }
    if (!(above > worth * all)) {
        view_aim_free(aim);
        return;
    }
    while (side < (unsigned)width || side < (unsigned)height)
        side *= 2;
    for (unsigned k = 0; k < side * side; k++) {
        int x = 0, y = 0; /* the bits of k at even and at odd places */
        for (unsigned bit = 1; bit < side; bit *= 2) {
            x |= (int)(k / bit & bit);
            y |= (int)(k / bit / 2 & bit);
        }
        const int cell = y * width + x, first = token;
        if (x >= width || y >= height)
            continue;
        sum += aim->chance[cell];
        while (token < VIEW_AIM_TOKENS &&
               (token + 0.5) * (above / VIEW_AIM_TOKENS) < sum)
            aim->tokens[token++] = (float)cell;
        aim->chance[cell] = (float)(token - first) / VIEW_AIM_TOKENS;
    }
}

void view_aim_free(view_aim *aim)
{
    free(aim->tokens);
    free(aim->chance);
    *aim = (view_aim){0};
}

/* ---- samples ----------------------------------------------------------- */

/* Most samples of a draw call: systems reset a GPU that is busy for seconds. */
#define MOST_SAMPLES 16
/* With samples set by the clock: most samples of a frame, and the time limits
 * between which their number stays. A changed picture starts with few, so only
 * a still picture takes that long. */
#define MOST_BY_CLOCK 64
static const double quick_seconds = 0.05, slow_seconds = 0.1;

void view_truth_free(view_truth *t)
{
    if (!t)
        return;
    gl.DeleteTextures(1, &t->chance);
    gl.DeleteTextures(1, &t->tokens);
    view_image_free(&t->pass);
    view_image_free(&t->mean);
    view_image_free(&t->second);
    free(t);
}

view_truth *view_truth_create(const baked_set *set)
{
    view_truth *t = ibl_need(calloc(1, sizeof *t));
    ibl_image map;
    view_aim aim;

    if (!view_set_environment(set, &map, &t->environment)) {
        free(t);
        return NULL;
    }
    view_aim_make(&map, &aim);
    if (map.data != set->map.data)
        ibl_image_free(&map);
    if (aim.width) {
        gl.ActiveTexture(GL_TEXTURE0 + VIEW_TRUTH_UNIT_TOKENS);
        t->tokens =
            view_float_image(GL_RED, VIEW_AIM_ROW, VIEW_AIM_ROW, aim.tokens);
        gl.ActiveTexture(GL_TEXTURE0 + VIEW_TRUTH_UNIT_CHANCE);
        t->chance = view_float_image(GL_RED, aim.width, aim.height, aim.chance);
        gl.ActiveTexture(GL_TEXTURE0);
    }
    t->by_clock = 1;
    t->sampling[2] = aim.width > 0;
    t->sampling[3] =
        view_set_lit_by(set) == VIEW_BY_LEVEL0 ? set->baked.light_count : 0;
    view_aim_free(&aim);
    return t;
}

/* Adds samples, at most MOST_SAMPLES. */
static bool draw_pass(view_truth *t, const view_subject *seen, int samples)
{
    view_frame frame = *seen->frame;
    view_subject sampled = *seen;

    t->sampling[0] = t->samples;
    t->sampling[1] = samples;
    memcpy(frame.sampling, t->sampling, sizeof t->sampling);
    sampled.frame = &frame;
    if (!view_subject_draw(&sampled, &t->pass))
        return false;
    t->even = t->samples && !t->even;
    t->seconds = t->samples ? t->seconds + t->even * samples : 0;
    t->samples += samples;
    const float part = (float)samples;
    return view_mean_add(&t->pass, part / (float)t->samples, &t->mean) &&
           (!t->even ||
            view_mean_add(&t->pass, part / (float)t->seconds, &t->second));
}

bool view_truth_draw(view_truth *t, const view_frame *frame,
                     const view_subject *seen, int samples)
{
    const bool by_clock = samples == 0;
    const double start = by_clock ? ibl_now() : 0.0;

    if (!view_image_make(&t->pass, (int)frame->viewport[0],
                         (int)frame->viewport[1]))
        return false;
    if (!t->samples || t->model != seen->model ||
        memcmp(frame, &t->shown, VIEW_FRAME_REFERENCE) != 0) {
        t->samples = 0;
        t->by_clock = t->by_clock > 4 ? t->by_clock / 4 : 1;
    }
    t->model = seen->model;
    t->shown = *frame;
    if (by_clock)
        samples = t->by_clock;
    if (samples > VIEW_TRUTH_SAMPLES - t->samples)
        samples = VIEW_TRUTH_SAMPLES - t->samples;
    /* Two passes at least tell the noise. */
    const int half = by_clock ? samples : (samples + 1) / 2;
    const int most = half < MOST_SAMPLES ? half : MOST_SAMPLES;
    for (int left = samples; left > 0; left -= most)
        if (!draw_pass(t, seen, left < most ? left : most)) {
            t->samples = 0;
            return false;
        }
    if (by_clock && samples > 0) {
        gl.Finish();
        /* By a factor of 2, since a frame also has fixed costs. */
        const double took = ibl_now() - start;
        if (took < quick_seconds && samples <= MOST_BY_CLOCK / 2)
            t->by_clock = 2 * samples;
        else if (took > slow_seconds && samples > 1)
            t->by_clock = samples / 2;
    }
    return true;
}

GLuint view_truth_second(const view_truth *t, double *factor)
{
    const int rest = t->samples - t->seconds;

    *factor = rest > 0 ? (double)t->seconds / rest : 0;
    return *factor > 0 ? t->second.texture : 0;
}

/* ---- errors ------------------------------------------------------------ */

double view_error_rmse(view_error e)
{
    return !e.pixels              ? -1
           : e.difference2 == 0.0 ? 0
                                  : sqrt(e.difference2 / e.truth2);
}

double view_error_noise(view_error e)
{
    return e.noise2 > 0 ? sqrt(e.noise2 / e.truth2) : 0;
}

void view_errors(const int *shown, int count, int width, int height,
                 const float *const pictures[4], view_error *errors)
{
    memset(errors, 0, (size_t)count * sizeof *errors);
    for (int i = 0; i < width * height; i++) {
        const int x = i % width, y = i / width;
        bool inside =
            shown[i] >= 0 && x && y && x + 1 < width && y + 1 < height;
        for (int k = 0; k < 9 && inside; k++)
            inside = shown[i + (k / 3 - 1) * width + k % 3 - 1] == shown[i];
        if (!inside)
            continue;
        view_error *e = &errors[shown[i]];
        e->pixels++;
        for (size_t k = 3 * (size_t)i; k < 3 * (size_t)i + 3; k++) {
            const double truth = pictures[1][k], d = pictures[0][k] - truth;
            e->difference2 += d * d;
            e->truth2 += truth * truth;
            if (pictures[3])
                e->noise2 += pow((double)pictures[2][k] - pictures[3][k], 2);
        }
    }
}
