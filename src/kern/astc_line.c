/* SPDX-License-Identifier: MIT */
#include "kern/astc_line.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "core/half.h"

/* ---- texels ------------------------------------------------------------ */

/* q of a light, real; half a step of a half more, since halves are cut. step:
 * the light of one q there. */
static float q_of(float light, float *step)
{
    const uint32_t bits = ibl_bits_of(light);
    float unit, steps, e;

    if (light < 0x1p-14f) {
        e = 0;
        unit = 0x1p-24f;
        steps = light * 0x1p24f;
    } else {
        e = (float)((int)(bits >> 23) - 112);
        unit = ibl_float_of((bits & 0x7F800000) - (10u << 23));
        steps = (float)(bits & 0x7FFFFF) * 0x1p-13f;
    }
    steps = 8 * steps + 3.5f;
    const float slope = steps < 1536 ? 3 : steps < 5632 ? 4 : 5;
    const float base = steps < 1536 ? 0 : steps < 5632 ? 512 : 2048;
    *step = unit * slope / 8;
    return 2048 * e + (steps + base) / slope;
}

/* What is smaller than these parts of the texel, or of the brightest one of the
 * block, is no colour to keep. */
#define OF_TEXEL 0x1p-11f
#define OF_BLOCK 0x1p-17f

/* The part of a texel's square in the level's matters besides its own: of even
 * light a half, of a sun nearly all. */
#define OF_SUM 128

/* What an error's square counts, and the least light whose colour does. */
static void set_share(ibl_astc_texels *t, float most, float least[16])
{
    const float low = OF_BLOCK * most;
    float square[16], total = 0x1p-60f;

    for (int i = 0; i < 16; i++) {
        const float r = t->light[0][i], g = t->light[1][i], b = t->light[2][i];
        square[i] = r * r + g * g + b * b;
        total += square[i];
        least[i] = OF_TEXEL * sqrtf(square[i]) + .5f * low;
    }
    for (int i = 0; i < 16; i++)
        t->share[i] = 1 / (square[i] + low * low + 0x1p-60f) +
                      OF_SUM * (square[i] / total) / total;
}

/* q of a channel, less its mean. */
static void set_channel(ibl_astc_texels *t, int c, int black,
                        const float least[16])
{
    float sum = 0;

    for (int i = 0; i < 16; i++) {
        const float light = t->light[c][i];
        float step;
        t->q[c][i] = q_of(!black && light < least[i] ? least[i] : light, &step);
        t->weight[c][i] = step * step * t->share[i];
        sum += t->q[c][i];
    }
    t->origin[c] = (int)(sum / 16);
    for (int i = 0; i < 16; i++)
        t->q[c][i] -= (float)t->origin[c];
}

void ibl_astc_load(const float *texels, ibl_astc_texels *t)
{
    float most[3] = {0}, least[16];

    for (int i = 0; i < 48; i++) {
        const float light =
            texels[i] < IBL_ASTC_HDR_MAX ? texels[i] : IBL_ASTC_HDR_MAX;
        t->light[i % 3][i / 3] = light;
        most[i % 3] = light > most[i % 3] ? light : most[i % 3];
    }
    set_share(t, fmaxf(most[0], fmaxf(most[1], most[2])), least);
    for (int c = 0; c < 3; c++)
        set_channel(t, c, most[c] <= 0, least);
}

/* Others have no weight. */
void ibl_astc_take(const ibl_astc_tables *tb, const ibl_astc_texels *all,
                   int pattern, int subset, ibl_astc_texels *t)
{
    *t = *all;
    for (int i = 0; i < 16; i++) {
        const float second = tb->second[i][pattern];
        const float in = subset ? second : 1 - second;
        t->share[i] *= in;
        for (int c = 0; c < 3; c++)
            t->weight[c][i] *= in;
    }
}

/* ---- lines ------------------------------------------------------------- */

/* Where texels are from the darkest to the brightest, by their light. */
static void by_light(const ibl_astc_texels *t, float s[16])
{
    float along[16], least = FLT_MAX, most = -FLT_MAX;

    for (int i = 0; i < 16; i++) {
        float sum = 0, weight = 0x1p-100f;
        for (int c = 0; c < 3; c++) {
            sum += t->weight[c][i] * t->q[c][i];
            weight += t->weight[c][i];
        }
        along[i] = sum / weight;
        if (t->share[i] > 0) {
            least = along[i] < least ? along[i] : least;
            most = along[i] > most ? along[i] : most;
        }
    }
    for (int i = 0; i < 16; i++)
        s[i] = most > least ? (along[i] - least) / (most - least) : 0;
}

/* Ends so that texels of the subset fill what is between them. */
static void stretch(const ibl_astc_texels *t, const float s[16],
                    float ends[2][3])
{
    float least = 1, most = 0;
    for (int i = 0; i < 16; i++)
        if (t->share[i] > 0) {
            least = s[i] < least ? s[i] : least;
            most = s[i] > most ? s[i] : most;
        }
    for (int c = 0; c < 3; c++) {
        const float from = ends[0][c], length = ends[1][c] - from;
        ends[0][c] = from + length * least;
        ends[1][c] = from + length * most;
    }
}

void ibl_astc_find_line(const ibl_astc_tables *tb, const ibl_astc_texels *t,
                        int mode, float ends[2][3])
{
    ibl_astc_sums sums[3];
    float s[16];

    by_light(t, s);
    tb->fit->sums(t, s, sums);
    ibl_astc_solve(mode, sums, ends);
    /* As long as the line may be. */
    for (int c = 0; c < 3; c++) {
        const float length = ends[1][c] - ends[0][c];
        ends[0][c] -= length;
        ends[1][c] += length;
    }
    tb->fit->project(t, ends, s);
    stretch(t, s, ends);
}

static void snap(const ibl_astc_levels *l, float s[16], unsigned char level[16],
                 int steps[16])
{
    for (int i = 0; i < 16; i++) {
        const int k = (int)(s[i] * (float)(l->count - 1) + .5f);
        level[i] = (unsigned char)k;
        steps[i] = l->step[k];
        s[i] = (float)l->step[k] * (1.0f / 64);
    }
}

/* ---- lines as they are stored ------------------------------------------ */

/* The ends of 16 bits that values have. False: beyond the largest. */
static int get_ends(const ibl_astc_way *w, const unsigned char values[6],
                    int e[2][3])
{
    ibl_astc_line_ends(w->mode, values, e);
    for (int i = 0; i < 6; i++) {
        int *end = &e[i / 3][i % 3];
        if (*end > IBL_ASTC_LARGEST)
            return 0;
        *end <<= 4;
    }
    return 1;
}

/* The error of a line with ends e and texels at steps; of one subset that as
 * BC6H is left out if it is not below `least` without. */
static float error_of(const ibl_astc_tables *tb, const ibl_astc_texels *t,
                      const ibl_astc_way *w, const ibl_astc_line *l,
                      const int e[2][3], const int steps[16], float least)
{
    const float error = tb->fit->error(t, e, steps);
    if (w->subsets == 2 || error >= least)
        return error;
    return ibl_astc_both(error, ibl_astc_error_as_bc6h(tb, w, 0, t, l));
}

/* Puts the texels on the line of values, and takes it if it is better. s: where
 * they are on it. */
static int try_values(const ibl_astc_tables *tb, const ibl_astc_texels *t,
                      const ibl_astc_way *w, const unsigned char values[6],
                      ibl_astc_line *best, float s[16])
{
    int e[2][3], steps[16];
    float ends[2][3];
    ibl_astc_line at;

    if (!get_ends(w, values, e))
        return 0;
    for (int i = 0; i < 6; i++)
        ends[i / 3][i % 3] = (float)(e[i / 3][i % 3] - t->origin[i % 3]);
    tb->fit->project(t, ends, s);
    snap(&tb->levels[w->weight_range], s, at.level, steps);
    memcpy(at.values, values, sizeof at.values);
    at.error = error_of(tb, t, w, &at, e, steps, best->error);
    if (!(at.error < best->error))
        return 0;
    *best = at;
    return 1;
}

/* The squares of errors of a line, less what they are without, with texels as
 * in sums; FLT_MAX: its ends are beyond the largest. */
static float expected(const ibl_astc_texels *t, const ibl_astc_way *w,
                      const unsigned char values[6],
                      const ibl_astc_sums sums[3])
{
    int e[2][3];
    float sum = 0;

    if (!get_ends(w, values, e))
        return FLT_MAX;
    for (int c = 0; c < 3; c++)
        sum += ibl_astc_cost(&sums[c], (float)(e[0][c] - t->origin[c]),
                             (float)(e[1][c] - t->origin[c]));
    return sum;
}

/* Whether the first end has the largest value. */
static int is_turned(const ibl_astc_texels *t, const float ends[2][3])
{
    float most[2] = {-FLT_MAX, -FLT_MAX};
    for (int i = 0; i < 6; i++) {
        const float v = ends[i / 3][i % 3] + (float)t->origin[i % 3];
        most[i / 3] = v > most[i / 3] ? v : most[i / 3];
    }
    return most[1] < most[0];
}

/* Turns the line so that its second end has the largest value. */
static void turn(const ibl_astc_texels *t, ibl_astc_sums sums[3],
                 float ends[2][3])
{
    if (!is_turned(t, ends))
        return;
    for (int c = 0; c < 3; c++) {
        const ibl_astc_sums s = sums[c];
        const float end = ends[0][c];
        sums[c] = (ibl_astc_sums){s.bb, s.ab, s.aa, s.b, s.a};
        ends[0][c] = ends[1][c];
        ends[1][c] = end;
    }
}

/* The values of the form that is expected to have the least error for sums,
 * near ends. False: no form has any. */
static int choose_values(const ibl_astc_tables *tb, const ibl_astc_texels *t,
                         const ibl_astc_way *w, const ibl_astc_sums sums[3],
                         const float ends[2][3], unsigned char values[6])
{
    const int forms = w->mode == IBL_ASTC_SCALE ? IBL_ASTC_SCALE_FORMS
                                                : IBL_ASTC_DIRECT_FORMS;
    float least = FLT_MAX;

    for (int form = 0; form < forms; form++) {
        unsigned char now[6];
        if (!ibl_astc_quantise(w->mode, sums, ends, t->origin, form,
                               &tb->codes[w->value_range], now))
            continue;
        const float error = expected(t, w, now, sums);
        if (error < least) {
            least = error;
            memcpy(values, now, sizeof now);
        }
    }
    return least < FLT_MAX;
}

void ibl_astc_fit_line(const ibl_astc_tables *tb, const ibl_astc_texels *t,
                       const ibl_astc_way *w, int rounds,
                       const float from[2][3], ibl_astc_line *best)
{
    ibl_astc_sums sums[3];
    float ends[2][3], s[16];
    unsigned char values[6];
    int steps[16];

    best->error = FLT_MAX;
    tb->fit->project(t, from, s);
    snap(&tb->levels[w->weight_range], s, best->level, steps);
    do {
        tb->fit->sums(t, s, sums);
        ibl_astc_solve(w->mode, sums, ends);
        turn(t, sums, ends);
    } while (choose_values(tb, t, w, sums, ends, values) &&
             try_values(tb, t, w, values, best, s) && --rounds > 0);
}

void ibl_astc_fit_levels(const ibl_astc_tables *tb, const ibl_astc_texels *t,
                         const ibl_astc_way *w, const unsigned char level[16],
                         ibl_astc_line *best)
{
    ibl_astc_line l = {0};
    ibl_astc_sums sums[3];
    float ends[2][3], s[16];
    int e[2][3], steps[16];

    memcpy(l.level, level, sizeof l.level);
    for (int i = 0; i < 16; i++) {
        steps[i] = tb->levels[w->weight_range].step[level[i]];
        s[i] = (float)steps[i] * (1.0f / 64);
    }
    tb->fit->sums(t, s, sums);
    ibl_astc_solve(w->mode, sums, ends);
    if (is_turned(t, ends) || !choose_values(tb, t, w, sums, ends, l.values) ||
        !get_ends(w, l.values, e))
        return;
    l.error = error_of(tb, t, w, &l, e, steps, best->error);
    if (l.error < best->error)
        *best = l;
}
