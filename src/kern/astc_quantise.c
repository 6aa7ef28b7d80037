/* SPDX-License-Identifier: MIT */
#include "kern/astc_quantise.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "kern/astc_hdr_endpoints.h"
#include "kern/astc_ise.h"

/* The largest end, of 12 bits, below Inf. */
#define LARGEST 3967

void ibl_astc_set_codes(int range, ibl_astc_codes *codes)
{
    const int levels = ibl_ise_levels(range);
    codes->range = range;
    codes->gap = 256.0f / (float)levels;
    memset(codes->of, IBL_ASTC_NO_CODE, sizeof codes->of);
    for (int i = 0; i < levels; i++)
        codes->of[ibl_ise_endpoint(range, i)] = (unsigned char)i;
}

void ibl_astc_solve(const ibl_astc_sums sums[3], float ends[2][3])
{
    for (int c = 0; c < 3; c++) {
        const ibl_astc_sums *s = &sums[c];
        const float det = s->aa * s->bb - s->ab * s->ab;
        const float all = s->aa + 2 * s->ab + s->bb;
        if (det <= 1e-6f * all * all) {
            ends[0][c] = ends[1][c] = all > 0 ? (s->a + s->b) / all : 0;
            continue;
        }
        ends[0][c] = (s->a * s->bb - s->b * s->ab) / det;
        ends[1][c] = (s->b * s->aa - s->a * s->ab) / det;
    }
}

/* Ends are r - d and r: of each channel r follows from d by its mean. */
void ibl_astc_solve_scale(const ibl_astc_sums sums[3], float ends[2][3])
{
    float above = 0, below = 0, d;

    for (int c = 0; c < 3; c++) {
        const ibl_astc_sums *s = &sums[c];
        const float all = s->aa + 2 * s->ab + s->bb, u = s->aa + s->ab;
        if (all <= 0)
            continue;
        above += (s->a + s->b) * u / all - s->a;
        below += s->aa - u * u / all;
    }
    d = below > 0 && above > 0 ? above / below : 0;
    for (int c = 0; c < 3; c++) {
        const ibl_astc_sums *s = &sums[c];
        const float all = s->aa + 2 * s->ab + s->bb, u = s->aa + s->ab;
        ends[1][c] = all > 0 ? (s->a + s->b + u * d) / all : 0;
        ends[0][c] = ends[1][c] - d;
    }
}

static float cost(const ibl_astc_sums *s, float e0, float e1)
{
    return e0 * (s->aa * e0 + 2 * (s->ab * e1 - s->a)) +
           e1 * (s->bb * e1 - 2 * s->b);
}

/* ---- fields ------------------------------------------------------------ */

/* A form being filled: fields so far, and the bytes that they make. */
typedef struct filling {
    const ibl_astc_form *form;
    const unsigned char *places, *codes;
    int own; /* bits of each field's own byte, 4 each, the first lowest */
    int least[6], most[6];
    int field[6];
    unsigned char fixed[6]; /* bits that tell the form */
} filling;

/* Byte i, which has bits of the fields up to i alone. */
static unsigned byte_of(const filling *f, int i)
{
    const int own = f->own >> 4 * i & 15;
    unsigned v = f->fixed[i] | ((unsigned)f->field[i] & ((1u << own) - 1));

    for (int k = 0; k < IBL_ASTC_PLACES; k++) {
        const int at = f->places[k], from = f->form->codes[k];
        if (at >> 4 == i)
            v |= ((unsigned)f->field[from >> 4] >> (from & 15) & 1)
                 << (at & 15);
    }
    return v;
}

/* The next value of field i from `from` on that its byte can have; INT_MIN is
 * none. */
#define NONE (-100000)
static int next(filling *f, int i, int from, int step)
{
    for (; from >= f->least[i] && from <= f->most[i]; from += step) {
        f->field[i] = from;
        if (f->codes[byte_of(f, i)] != IBL_ASTC_NO_CODE)
            return from;
    }
    return NONE;
}

/* Up to 2 n values of field i around v, NONE between them. */
static void around(filling *f, int i, float v, int n, int *values)
{
    const float low = (float)f->least[i], high = (float)f->most[i];
    int down = (int)floorf(v < low ? low : v > high ? high : v), up = down + 1;

    for (int k = 0; k < n; k++) {
        values[2 * k] = down = next(f, i, down, -1);
        values[2 * k + 1] = up = next(f, i, up, 1);
        down--;
        up++;
    }
}

static void set_limits(filling *f, int fields, int signed_from)
{
    const int largest = LARGEST >> f->form->drop;

    for (int i = 0; i < fields; i++) {
        const int n = f->form->bits[i], half = 1 << (n - 1);
        f->least[i] = i < signed_from ? 0 : -half;
        f->most[i] = i < signed_from ? 2 * half - 1 : half - 1;
    }
    if (f->most[0] > largest)
        f->most[0] = largest;
}

/* Where channel c is stored: the largest comes first, in turn for it. */
static int stored(int c, int major)
{
    return c == 0 ? major : c == major ? 0 : c;
}

static int major_of(const float end[3], const int origin[3])
{
    int major = 0;
    for (int c = 1; c < 3; c++)
        if (end[c] + (float)origin[c] > end[major] + (float)origin[major])
            major = c;
    return major;
}

/* ---- both ends --------------------------------------------------------- */

/* What both ends of a channel are to be, in steps of a form. */
typedef struct pair {
    const ibl_astc_sums *sums;
    float end1, unit, origin;
} pair;

static float end_q(const pair *p, int steps)
{
    const int e = steps < 0 ? 0 : steps;
    return (float)e * p->unit - p->origin;
}

/* The first end that is best with the second one, in steps. */
static float best_first(const pair *p, float e1)
{
    const ibl_astc_sums *s = p->sums;
    const float e0 = s->aa > 0 ? (s->a - s->ab * e1) / s->aa : e1;
    return (e0 + p->origin) / p->unit;
}

/* Sets fields i and k, of which the second end is top - field i (of the first
 * channel field i itself) and the first one that less `more` and field k. */
static int fill_pair(filling *f, const pair *p, int top, int more, int i, int k)
{
    const float want = (p->end1 + p->origin) / p->unit;
    int first[4], best[2] = {NONE, NONE};
    float least = FLT_MAX;

    around(f, i, i ? (float)top - want : want, 2, first);
    for (int a = 0; a < 4; a++) {
        if (first[a] == NONE)
            continue;
        f->field[i] = first[a];
        const int high = i ? top - first[a] : first[a];
        const float e1 = end_q(p, high);
        int second[2];
        around(f, k, (float)(high - more) - best_first(p, e1), 1, second);
        for (int b = 0; b < 2; b++) {
            if (second[b] == NONE)
                continue;
            const float e =
                cost(p->sums, end_q(p, high - more - second[b]), e1);
            if (e < least) {
                least = e;
                best[0] = first[a];
                best[1] = second[b];
            }
        }
    }
    f->field[i] = best[0];
    f->field[k] = best[1];
    return best[1] != NONE;
}

/* Without differences: a byte for each end of each channel. */
static int quantise_plain(const ibl_astc_sums sums[3], const float ends[2][3],
                          const int origin[3], const unsigned char *codes,
                          unsigned char values[6])
{
    for (int c = 0; c < 3; c++) {
        const float unit = c == 2 ? 512 : 256;
        const pair p = {&sums[c], ends[1][c], unit, (float)origin[c]};
        const int most = LARGEST >> (c == 2 ? 5 : 4), flag = c == 2 ? 128 : 0;
        float least = FLT_MAX;
        int mid = (int)((p.end1 + p.origin) / unit);
        for (int e1 = mid - 4; e1 <= mid + 5; e1++) {
            if (e1 < 0 || e1 > most || codes[e1 | flag] == IBL_ASTC_NO_CODE)
                continue;
            const int at = (int)floorf(best_first(&p, end_q(&p, e1)));
            for (int e0 = at - 3; e0 <= at + 4; e0++) {
                if (e0 < 0 || e0 > most || codes[e0 | flag] == IBL_ASTC_NO_CODE)
                    continue;
                const float e = cost(p.sums, end_q(&p, e0), end_q(&p, e1));
                if (e < least) {
                    least = e;
                    values[2 * c] = (unsigned char)(e0 | flag);
                    values[2 * c + 1] = (unsigned char)(e1 | flag);
                }
            }
        }
        if (least == FLT_MAX)
            return 0;
    }
    return 1;
}

int ibl_astc_quantise_direct(const ibl_astc_sums sums[3],
                             const float ends[2][3], const int origin[3],
                             int form, const ibl_astc_codes *codes,
                             unsigned char values[6])
{
    if (form == IBL_ASTC_DIRECT_FORMS - 1)
        return quantise_plain(sums, ends, origin, codes->of, values);

    filling f = {.form = &ibl_astc_direct_forms[form],
                 .places = ibl_astc_direct_places,
                 .codes = codes->of,
                 .own = 0x556668};
    const int major = major_of(ends[1], origin);
    set_limits(&f, 6, 4);
    for (int i = 0; i < 3; i++)
        f.fixed[1 + i] = (unsigned char)((form >> i & 1) << 7);
    f.fixed[4] = (unsigned char)((major & 1) << 7);
    f.fixed[5] = (unsigned char)((major >> 1) << 7);
    for (int i = 0; i < 3; i++) {
        const int c = stored(i, major);
        const pair p = {&sums[c], ends[1][c], (float)(16 << f.form->drop),
                        (float)origin[c]};
        if (!(i ? fill_pair(&f, &p, f.field[0], f.field[1], 1 + i, 3 + i)
                : fill_pair(&f, &p, 0, 0, 0, 1)))
            return 0;
    }
    for (int i = 0; i < 6; i++)
        values[i] = (unsigned char)byte_of(&f, i);
    return 1;
}

/* ---- one end and a scale ----------------------------------------------- */

/* The squares for the first end `field 3` below the second. */
static float scale_cost(const filling *f, const pair *p, int high)
{
    return cost(p->sums, end_q(p, high - f->field[3]), end_q(p, high));
}

/* Sets field i of the channel at p, given the scale; returns the squares. */
static float fill_channel(filling *f, const pair *p, int i, int form)
{
    const ibl_astc_sums *s = p->sums;
    const float all = s->aa + 2 * s->ab + s->bb;
    const float d = (float)f->field[3] * p->unit;
    const float mean =
        all > 0 ? (s->a + s->b + (s->aa + s->ab) * d) / all : p->end1;
    const float want = (mean + p->origin) / p->unit;
    const int from = i && form < IBL_ASTC_SCALE_FORMS - 1;
    int values[2], best = NONE;
    float least = FLT_MAX;

    around(f, i, from ? (float)f->field[0] - want : want, 1, values);
    for (int k = 0; k < 2; k++) {
        if (values[k] == NONE)
            continue;
        const float e =
            scale_cost(f, p, from ? f->field[0] - values[k] : values[k]);
        if (e < least) {
            least = e;
            best = values[k];
        }
    }
    f->field[i] = best;
    return least;
}

int ibl_astc_quantise_scale(const ibl_astc_sums sums[3], const float ends[2][3],
                            const int origin[3], int form,
                            const ibl_astc_codes *codes,
                            unsigned char values[4])
{
    filling f = {.form = &ibl_astc_scale_forms[form],
                 .places = ibl_astc_scale_places,
                 .codes = codes->of,
                 .own = 0x5556};
    const int plain = form == IBL_ASTC_SCALE_FORMS - 1;
    const int major = plain ? 3 : major_of(ends[1], origin);
    const int bits = form < 4 ? major << 2 | form : 12 | major;
    const float unit = (float)(16 << f.form->drop);
    const int mid = (int)floorf((ends[1][0] - ends[0][0]) / unit);
    float least = FLT_MAX;

    set_limits(&f, 4, 4);
    f.fixed[0] = (unsigned char)((bits & 3) << 6);
    f.fixed[1] = (unsigned char)((bits >> 2 & 1) << 7);
    f.fixed[2] = (unsigned char)((bits >> 3) << 7);
    for (int d = mid - 1; d <= mid + 2; d++) {
        float e = 0;
        if (d < 0 || d > f.most[3])
            continue;
        f.field[3] = d;
        for (int i = 0; i < 3 && e < FLT_MAX; i++) {
            const int c = stored(i, plain ? 0 : major);
            const pair p = {&sums[c], ends[1][c], unit, (float)origin[c]};
            const float more = fill_channel(&f, &p, i, form);
            e = more < FLT_MAX ? e + more : FLT_MAX;
        }
        if (e >= least || codes->of[byte_of(&f, 3)] == IBL_ASTC_NO_CODE)
            continue;
        least = e;
        for (int i = 0; i < 4; i++)
            values[i] = (unsigned char)byte_of(&f, i);
    }
    return least < FLT_MAX;
}

/* ---- what is lost ------------------------------------------------------ */

/* A step that is rounded is off by this much of itself, rms. */
#define ROUNDED 0.29f

static float beyond(float v, float least, float most)
{
    return v < least ? least - v : v > most ? v - most : 0;
}

float ibl_astc_direct_loss(const float ends[2][3], const int origin[3],
                           int form, float gap)
{
    if (form == IBL_ASTC_DIRECT_FORMS - 1)
        return ROUNDED * 256 * gap;

    const ibl_astc_form *f = &ibl_astc_direct_forms[form];
    const float unit = (float)(16 << f->drop);
    const int major = major_of(ends[1], origin);
    const float high = ends[1][major] + (float)origin[major];
    const float c = high - ends[0][major] - (float)origin[major];
    float lost = ROUNDED * unit * gap +
                 beyond(c, 0, unit * (float)((1 << f->bits[1]) - 1));

    for (int i = 1; i < 3; i++) {
        const int k = stored(i, major);
        const float half = unit * (float)(1 << (f->bits[3 + i] - 1));
        const float b = high - ends[1][k] - (float)origin[k];
        const float d = ends[1][k] - c - ends[0][k];
        lost += beyond(b, 0, unit * (float)((1 << f->bits[1 + i]) - 1));
        lost += beyond(d, -half, half - unit);
    }
    return lost;
}

float ibl_astc_scale_loss(const float ends[2][3], const int origin[3], int form,
                          float gap)
{
    const ibl_astc_form *f = &ibl_astc_scale_forms[form];
    const float unit = (float)(16 << f->drop);
    const int major = major_of(ends[1], origin);
    const float high = ends[1][major] + (float)origin[major];
    float lost =
        ROUNDED * unit * gap + beyond(ends[1][0] - ends[0][0], 0,
                                      unit * (float)((1 << f->bits[3]) - 1));

    for (int i = 1; i < 3 && form < IBL_ASTC_SCALE_FORMS - 1; i++) {
        const int k = stored(i, major);
        lost += beyond(high - ends[1][k] - (float)origin[k], 0,
                       unit * (float)((1 << f->bits[i]) - 1));
    }
    return lost;
}
