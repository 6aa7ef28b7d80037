/* SPDX-License-Identifier: MIT */
#include "kern/astc_quantise.h"

#include <float.h>
#include <string.h>

#include "kern/astc_hdr_endpoints.h"
#include "kern/astc_ise.h"

void ibl_astc_set_codes(int range, ibl_astc_codes *codes)
{
    const int levels = ibl_ise_levels(range);
    codes->range = range;
    codes->gap = 256.0f / (float)levels;
    for (int v = 0; v < 256; v++)
        codes->of[v] = IBL_ASTC_NO_CODE;
    for (int i = 0; i < levels; i++)
        codes->of[ibl_ise_endpoint(range, i)] = (short)i;
    /* Each range has 0 and 255. */
    for (int v = 0, last = 0; v < 256; v++) {
        last = codes->of[v] == IBL_ASTC_NO_CODE ? last : v;
        codes->below[v] = (unsigned char)last;
    }
    for (int v = 255, last = 255; v >= 0; v--) {
        last = codes->of[v] == IBL_ASTC_NO_CODE ? last : v;
        codes->above[v] = (unsigned char)last;
    }
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

/* ---- fields ------------------------------------------------------------ */

/* A form being filled, a field after the other: byte i has bits of field i and
 * of those before it. A bit above a field's own that its byte has room for is
 * there in its place. */
typedef struct filling {
    const ibl_astc_form *form;
    const unsigned char *places;
    const ibl_astc_codes *codes;
    int least[6], most[6];
    int field[6];
    unsigned char byte[6]; /* without the field's own bits */
    unsigned char own[6];  /* which these are */
} filling;

/* Moves the bits of field i that are elsewhere to their bytes. */
static void hand_on(filling *f, int i)
{
    for (int k = 0; k < IBL_ASTC_PLACES; k++) {
        const int at = f->places[k], from = f->form->codes[k];
        if (from >> 4 == i && at >> 4 != i)
            f->byte[at >> 4] |=
                (unsigned char)((f->field[i] >> (from & 15) & 1) << (at & 15));
    }
}

static unsigned byte_of(const filling *f, int i)
{
    return f->byte[i] | ((unsigned)f->field[i] & f->own[i]);
}

/* The next value of field i from `from` on, downwards or upwards, that its byte
 * can have; NONE: there is none. */
#define NONE (-100000)
static int next(const filling *f, int i, int from, int up)
{
    const int own = f->own[i];

    while (from >= f->least[i] && from <= f->most[i]) {
        const int want = f->byte[i] | (from & own);
        const int got = up ? f->codes->above[want] : f->codes->below[want];
        if ((got & ~own) == f->byte[i]) {
            from += got - want;
            return from >= f->least[i] && from <= f->most[i] ? from : NONE;
        }
        /* Its own bits go round. */
        from = up ? (from | own) + 1 : (from & ~own) - 1;
    }
    return NONE;
}

/* The integer at or below v, of low to high. */
static int whole(float v, int low, int high)
{
    const float from = (float)low, to = (float)high;
    return low + (int)((v > from ? v < to ? v : to : from) - from);
}

/* Up to 2 n values of field i around v, NONE between them. */
static void around(const filling *f, int i, float v, int n, int *values)
{
    int down = whole(v, f->least[i], f->most[i]), up = down + 1;

    for (int k = 0; k < n; k++) {
        values[2 * k] = down = next(f, i, down, 0);
        values[2 * k + 1] = up = next(f, i, up, 1);
        down--;
        up++;
    }
}

/* own: as many bits of each field's byte as it has in any form. */
static void set_limits(filling *f, int fields, int signed_from)
{
    const int largest = IBL_ASTC_LARGEST >> f->form->drop;

    for (int k = 0; k < IBL_ASTC_PLACES; k++)
        if (f->places[k] >> 4 == f->form->codes[k] >> 4)
            f->own[f->places[k] >> 4] |=
                (unsigned char)(1 << (f->places[k] & 15));
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

/* Both ends of a channel, in steps of a form, `unit` of q each: where the
 * second one is to be, and of the first one where it is best for a second one
 * of q = 0 and how that grows with it. */
typedef struct pair {
    const ibl_astc_sums *sums;
    float end1, unit, inverse_unit, origin;
    float at0, slope;
} pair;

static pair pair_of(const ibl_astc_sums *s, float end1, float unit, int origin)
{
    const float inverse = s->aa > 0 ? 1 / s->aa : 0;
    return (pair){s,
                  end1,
                  unit,
                  1 / unit,
                  (float)origin,
                  s->a * inverse,
                  s->aa > 0 ? -s->ab * inverse : 1};
}

static float end_q(const pair *p, int steps)
{
    const int e = steps < 0 ? 0 : steps;
    return (float)e * p->unit - p->origin;
}

/* The first end that is best with the second one, in steps. */
static float best_first(const pair *p, float e1)
{
    return (p->at0 + p->slope * e1 + p->origin) * p->inverse_unit;
}

/* Sets fields i and k, of which the second end is top - field i (of the first
 * channel field i itself) and the first one that less `more` and field k. */
static int fill_pair(filling *f, const pair *p, int top, int more, int i, int k)
{
    const float want = (p->end1 + p->origin) * p->inverse_unit;
    int first[4], best[2] = {NONE, NONE};
    unsigned char byte[6];
    float least = FLT_MAX;

    memcpy(byte, f->byte, sizeof byte);
    around(f, i, i ? (float)top - want : want, 2, first);
    for (int a = 0; a < 4; a++) {
        if (first[a] == NONE)
            continue;
        const int high = i ? top - first[a] : first[a];
        const float e1 = end_q(p, high);
        int second[2];
        if (f->codes->range != IBL_ISE_256) {
            f->field[i] = first[a];
            hand_on(f, i);
        }
        around(f, k, (float)(high - more) - best_first(p, e1), 1, second);
        for (int b = 0; b < 2; b++) {
            if (second[b] == NONE)
                continue;
            const float e =
                ibl_astc_cost(p->sums, end_q(p, high - more - second[b]), e1);
            if (e < least) {
                least = e;
                best[0] = first[a];
                best[1] = second[b];
            }
        }
        memcpy(f->byte, byte, sizeof byte);
    }
    if (best[1] == NONE)
        return 0;
    f->field[i] = best[0];
    hand_on(f, i);
    f->field[k] = best[1];
    hand_on(f, k);
    return 1;
}

/* Without differences: a byte for each end of each channel. */
static int quantise_plain(const ibl_astc_sums sums[3], const float ends[2][3],
                          const int origin[3], const signed short *codes,
                          unsigned char values[6])
{
    for (int c = 0; c < 3; c++) {
        const float unit = c == 2 ? 512 : 256;
        const pair p = pair_of(&sums[c], ends[1][c], unit, origin[c]);
        const int most = IBL_ASTC_LARGEST >> (c == 2 ? 5 : 4),
                  flag = c == 2 ? 128 : 0;
        const int at1 = whole((p.end1 + p.origin) * p.inverse_unit, 0, most);
        float least = FLT_MAX;
        for (int e1 = at1 - 4; e1 <= at1 + 5; e1++) {
            if (e1 < 0 || e1 > most || codes[e1 | flag] == IBL_ASTC_NO_CODE)
                continue;
            const int at0 = whole(best_first(&p, end_q(&p, e1)), 0, most);
            for (int e0 = at0 - 3; e0 <= at0 + 4; e0++) {
                if (e0 < 0 || e0 > most || codes[e0 | flag] == IBL_ASTC_NO_CODE)
                    continue;
                const float e =
                    ibl_astc_cost(p.sums, end_q(&p, e0), end_q(&p, e1));
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
                 .codes = codes,
                 .own = {255, 63, 63, 63, 31, 31}};
    const int major = major_of(ends[1], origin);
    set_limits(&f, 6, 4);
    for (int i = 0; i < 3; i++)
        f.byte[1 + i] = (unsigned char)((form >> i & 1) << 7);
    f.byte[4] = (unsigned char)((major & 1) << 7);
    f.byte[5] = (unsigned char)((major >> 1) << 7);
    for (int i = 0; i < 3; i++) {
        const int c = stored(i, major);
        const pair p = pair_of(&sums[c], ends[1][c],
                               (float)(16 << f.form->drop), origin[c]);
        if (!(i ? fill_pair(&f, &p, f.field[0], f.field[1], 1 + i, 3 + i)
                : fill_pair(&f, &p, 0, 0, 0, 1)))
            return 0;
    }
    for (int i = 0; i < 6; i++)
        values[i] = (unsigned char)byte_of(&f, i);
    return 1;
}

/* ---- one end and a scale ----------------------------------------------- */

/* A channel, in steps of a form: the best second end for a scale of 0, and how
 * that grows with it. */
typedef struct channel {
    const ibl_astc_sums *sums;
    float at0, slope, unit, origin;
} channel;

static channel channel_of(const ibl_astc_sums *s, float end1, float unit,
                          int origin)
{
    const float all = s->aa + 2 * s->ab + s->bb;
    const float at0 = all > 0 ? (s->a + s->b) / all : end1;
    return (channel){s, (at0 + (float)origin) / unit,
                     all > 0 ? (s->aa + s->ab) / all : 0, unit, (float)origin};
}

static float scale_cost(const channel *p, int high, int d)
{
    const int low = high < d ? 0 : high - d;
    return ibl_astc_cost(p->sums, (float)low * p->unit - p->origin,
                         (float)high * p->unit - p->origin);
}

/* Sets field i, which is what the channel's second end is less than top (or it
 * itself, if that is 0), given the scale; returns the squares. */
static float fill_channel(filling *f, const channel *p, int top, int i)
{
    const float want = p->at0 + p->slope * (float)f->field[3];
    int values[2], best = NONE;
    float least = FLT_MAX;

    around(f, i, top ? (float)top - want : want, 1, values);
    for (int k = 0; k < 2; k++) {
        if (values[k] == NONE)
            continue;
        const float e =
            scale_cost(p, top ? top - values[k] : values[k], f->field[3]);
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
                 .codes = codes,
                 .own = {63, 31, 31, 31}};
    const int plain = form == IBL_ASTC_SCALE_FORMS - 1;
    const int major = plain ? 3 : major_of(ends[1], origin);
    const int bits = form < 4 ? major << 2 | form : 12 | major;
    const float unit = (float)(16 << f.form->drop);
    const int mid = whole((ends[1][0] - ends[0][0]) / unit, 0, 255);
    channel channels[3];
    unsigned char byte[6];
    float least = FLT_MAX;

    set_limits(&f, 4, 4);
    f.byte[0] = (unsigned char)((bits & 3) << 6);
    f.byte[1] = (unsigned char)((bits >> 2 & 1) << 7);
    f.byte[2] = (unsigned char)((bits >> 3) << 7);
    memcpy(byte, f.byte, sizeof byte);
    for (int i = 0; i < 3; i++) {
        const int c = stored(i, plain ? 0 : major);
        channels[i] = channel_of(&sums[c], ends[1][c], unit, origin[c]);
    }
    for (int d = mid - 1; d <= mid + 2; d++) {
        float e = 0;
        if (d < 0 || d > f.most[3])
            continue;
        memcpy(f.byte, byte, sizeof byte);
        f.field[3] = d;
        for (int i = 0; i < 3 && e < FLT_MAX; i++) {
            const float more =
                fill_channel(&f, &channels[i], i && !plain ? f.field[0] : 0, i);
            e = more < FLT_MAX ? e + more : FLT_MAX;
            if (!i)
                hand_on(&f, 0);
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
