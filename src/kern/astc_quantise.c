/* SPDX-License-Identifier: MIT */
#include "kern/astc_quantise.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "kern/astc_hdr_endpoints.h"
#include "kern/astc_ise.h"

void ibl_astc_set_codes(int range, ibl_astc_codes *codes)
{
    for (int v = 0; v < 256; v++)
        codes->of[v] = IBL_ASTC_NO_CODE;
    for (int i = 0; i < ibl_ise_levels(range); i++)
        codes->of[ibl_ise_endpoint(range, i)] = (short)i;
}

static void solve_direct(const ibl_astc_sums sums[3], float ends[2][3])
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
static void solve_scale(const ibl_astc_sums sums[3], float ends[2][3])
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

void ibl_astc_solve(int mode, const ibl_astc_sums sums[3], float ends[2][3])
{
    if (mode == IBL_ASTC_SCALE)
        solve_scale(sums, ends);
    else
        solve_direct(sums, ends);
}

/* ---- fields ------------------------------------------------------------ */

/* A form being filled, a field after the other: byte i has bits of field i and
 * of those before it. A bit above a field's own that its byte has room for is
 * there in its place. */
typedef struct filling {
    const ibl_astc_form *form;
    const unsigned char *places; /* NULL: fields have no bits elsewhere */
    const ibl_astc_codes *codes;
    int field[6];
    unsigned char byte[6];
    unsigned char own[6]; /* which bits of its byte are a field's own */
} filling;

enum {
    REACH = 8 /* how far from what is wanted a value may be */
};

/* Gives field i the integer nearest to v, from low to high, that its byte can
 * have. False: none is near. */
static int put(filling *f, int i, float v, int low, int high)
{
    const float from = (float)low, to = (float)high;
    const float clamped = v > from ? v < to ? v : to : from; /* NaN: from */
    const int at = (int)floorf(clamped + .5f);
    const int side = clamped < (float)at ? -1 : 1;

    for (int k = 0; k < 2 * REACH; k++) {
        const int value = at + (k & 1 ? side : -side) * ((k + 1) / 2);
        const int byte = f->byte[i] | (value & f->own[i]);
        if (value < low || value > high ||
            f->codes->of[byte] == IBL_ASTC_NO_CODE)
            continue;
        f->field[i] = value;
        f->byte[i] = (unsigned char)byte;
        for (int p = 0; f->places && p < IBL_ASTC_PLACES; p++) {
            const int place = f->places[p], bit = f->form->codes[p];
            if (bit >> 4 == i && place >> 4 != i)
                f->byte[place >> 4] |=
                    (unsigned char)((value >> (bit & 15) & 1) << (place & 15));
        }
        return 1;
    }
    return 0;
}

/* The same of a form's field, which may be negative from `signed_from` on. */
static int put_field(filling *f, int i, float v, int signed_from)
{
    const int half = 1 << (f->form->bits[i] - 1);
    const int low = i < signed_from ? 0 : -half, high = low + 2 * half - 1;
    const int largest = IBL_ASTC_LARGEST >> f->form->drop;
    return put(f, i, v, low, i == 0 && high > largest ? largest : high);
}

static void set_own(filling *f)
{
    for (int p = 0; p < IBL_ASTC_PLACES; p++)
        if (f->places[p] >> 4 == f->form->codes[p] >> 4)
            f->own[f->places[p] >> 4] |=
                (unsigned char)(1 << (f->places[p] & 15));
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

/* The first end that is best with a second one, both without origin. */
static float first_for(const ibl_astc_sums *s, int origin, float end1)
{
    const float e1 = end1 - (float)origin;
    return (s->aa > 0 ? (s->a - s->ab * e1) / s->aa : e1) + (float)origin;
}

/* Without differences: a byte for each end of each channel. */
static int fill_plain(filling *f, const ibl_astc_sums sums[3],
                      const float ends[2][3], const int origin[3])
{
    memcpy(f->own, (unsigned char[]){255, 255, 255, 255, 127, 127}, 6);
    f->byte[4] = f->byte[5] = 128;
    f->places = NULL;
    for (int c = 0; c < 3; c++) {
        const float unit = c == 2 ? 512 : 256;
        const int most = IBL_ASTC_LARGEST >> (c == 2 ? 5 : 4);
        const float e1 = ends[1][c] + (float)origin[c];
        if (!put(f, 2 * c + 1, e1 / unit, 0, most))
            return 0;
        const float e0 =
            first_for(&sums[c], origin[c], (float)f->field[2 * c + 1] * unit);
        if (!put(f, 2 * c, e0 / unit, 0, most))
            return 0;
    }
    return 1;
}

static int fill_direct(filling *f, const ibl_astc_sums sums[3],
                       const float ends[2][3], const int origin[3], int form)
{
    const float unit = (float)(16 << f->form->drop);
    const int major = major_of(ends[1], origin);

    memcpy(f->own, (unsigned char[]){255, 63, 63, 63, 31, 31}, 6);
    for (int i = 0; i < 3; i++)
        f->byte[1 + i] = (unsigned char)((form >> i & 1) << 7);
    f->byte[4] = (unsigned char)((major & 1) << 7);
    f->byte[5] = (unsigned char)((major >> 1) << 7);
    set_own(f);
    for (int i = 0; i < 6; i++) {
        /* a, c, b0, b1, d0, d1 */
        const int c = stored(i < 2 ? 0 : (i - 2) % 2 + 1, major);
        const float e1 = (ends[1][c] + (float)origin[c]) / unit;
        const int high = f->field[0] - (i > 3 ? f->field[i - 2] : 0);
        const float e0 =
            first_for(&sums[c], origin[c], (float)high * unit) / unit;
        const float want = i == 0   ? e1
                           : i == 1 ? (float)high - e0
                           : i < 4  ? (float)high - e1
                                    : (float)(high - f->field[1]) - e0;
        if (!put_field(f, i, want, 4))
            return 0;
    }
    return 1;
}

static int fill_scale(filling *f, const ibl_astc_sums sums[3],
                      const float ends[2][3], const int origin[3], int form)
{
    const float unit = (float)(16 << f->form->drop);
    const int plain = form == IBL_ASTC_SCALE_FORMS - 1;
    const int major = plain ? 3 : major_of(ends[1], origin);
    const int bits = form < 4 ? major << 2 | form : 12 | major;
    float slope = 0, all = 0;

    memcpy(f->own, (unsigned char[]){63, 31, 31, 31}, 4);
    f->byte[0] = (unsigned char)((bits & 3) << 6);
    f->byte[1] = (unsigned char)((bits >> 2 & 1) << 7);
    f->byte[2] = (unsigned char)((bits >> 3) << 7);
    set_own(f);
    for (int i = 0; i < 3; i++) {
        const int c = stored(i, plain ? 0 : major);
        const int top = i && !plain ? f->field[0] : 0;
        const float e1 = (ends[1][c] + (float)origin[c]) / unit;
        if (!put_field(f, i, top ? (float)top - e1 : e1, 6))
            return 0;
        const int high = top ? top - f->field[i] : f->field[i];
        const float e = (float)high * unit - (float)origin[c];
        slope += sums[c].aa * e + sums[c].ab * e - sums[c].a;
        all += sums[c].aa;
    }
    return put_field(f, 3, all > 0 ? slope / all / unit : 0, 6);
}

int ibl_astc_quantise(int mode, const ibl_astc_sums sums[3],
                      const float ends[2][3], const int origin[3], int form,
                      const ibl_astc_codes *codes, unsigned char values[6])
{
    filling f = {.codes = codes};
    int done;

    if (mode == IBL_ASTC_SCALE) {
        f.form = &ibl_astc_scale_forms[form];
        f.places = ibl_astc_scale_places;
        done = fill_scale(&f, sums, ends, origin, form);
    } else if (form == IBL_ASTC_DIRECT_FORMS - 1) {
        done = fill_plain(&f, sums, ends, origin);
    } else {
        f.form = &ibl_astc_direct_forms[form];
        f.places = ibl_astc_direct_places;
        done = fill_direct(&f, sums, ends, origin, form);
    }
    memcpy(values, f.byte, sizeof f.byte);
    return done;
}
