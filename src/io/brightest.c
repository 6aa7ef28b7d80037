/* SPDX-License-Identifier: MIT */
#include "io/brightest.h"

#include <math.h>
#include <string.h>

#include "core/alloc.h"
#include "core/pi.h"

enum {
    MOST = 1 << 17 /* pixels; a lamp of 3 degrees in a map of 16384 */
};

/* Of the peak, for a pixel of the source: the most is for maps where too many
 * pixels have the least. */
static const float least_share = 0.1f, most_share = 0.5f;

/* A cap of 10 degrees has 1 / 130 of the sphere. */
static size_t most_pixels(const ibl_bright_pixels *b)
{
    const size_t most = (size_t)b->width * (size_t)b->height / 64 + 64;
    return most < MOST ? most : MOST;
}

static float largest(const float *p)
{
    const float rg = p[0] > p[1] ? p[0] : p[1];
    return rg > p[2] ? rg : p[2];
}

/* Drops the pixels that a new peak leaves too dark. */
static void prune(ibl_bright_pixels *b)
{
    size_t kept = 0;
    for (size_t i = 0; i < b->count; i++)
        if (largest(b->list[i].rgb) >= b->least)
            b->list[kept++] = b->list[i];
    b->count = kept;
}

static void set_least(ibl_bright_pixels *b)
{
    b->least = fmaxf(least_share * b->peak, b->dropped);
}

/* Asks more of the pixels; if that leaves too many, drops them all. */
static void thin_out(ibl_bright_pixels *b)
{
    b->dropped = fmaxf(b->dropped, most_share * b->peak);
    set_least(b);
    prune(b);
    if (b->count <= b->room / 2)
        return;
    b->dropped = b->peak;
    b->count = 0;
    set_least(b);
}

/* Makes room for one more pixel. Memory that is not touched costs nothing. */
static bool make_room(ibl_bright_pixels *b)
{
    if (!b->list) {
        b->room = most_pixels(b);
        b->list = ibl_alloc_sparse(b->room, sizeof *b->list);
    }
    if (b->list && b->count == b->room) {
        prune(b);
        if (b->count > b->room / 2)
            thin_out(b);
    }
    return b->list;
}

static bool add(ibl_bright_pixels *b, const float *p, int x, int y)
{
    const float value = largest(p);

    if (value > b->peak) {
        b->peak = value;
        b->peak_x = x;
        b->peak_y = y;
        set_least(b);
    }
    if (!make_room(b))
        return false;
    if (value >= b->least)
        b->list[b->count++] =
            (ibl_bright_pixel){(uint16_t)x, (uint16_t)y, {p[0], p[1], p[2]}};
    return true;
}

bool ibl_bright_take(ibl_bright_pixels *b, const float *rgb, int y, float most)
{
    if (!(most > 0) || most < b->least)
        return true;
    for (int x = 0; x < b->width; x++, rgb += 3)
        if (largest(rgb) >= b->least && largest(rgb) > 0 && !add(b, rgb, x, y))
            return false;
    return true;
}

/* ---- the sum ---------------------------------------------------------- */

typedef struct row {
    int y;
    double sine, cosine; /* of the angle from +Y */
    double solid_angle;  /* of a pixel */
} row;

static row row_of(const ibl_bright_pixels *b, int y)
{
    const double theta = IBL_PI * (y + 0.5) / b->height;
    const double height =
        cos(IBL_PI * y / b->height) - cos(IBL_PI * (y + 1) / b->height);

    return (row){y, sin(theta), cos(theta), 2 * IBL_PI / b->width * height};
}

static void direction_of(const ibl_bright_pixels *b, const row *r, int x,
                         double d[3])
{
    const double phi = 2 * IBL_PI * ((x + 0.5) / b->width - 0.5);

    d[0] = cos(phi) * r->sine;
    d[1] = r->cosine;
    d[2] = sin(phi) * r->sine;
}

void ibl_bright_sum(const ibl_bright_pixels *b, ibl_brightest *out)
{
    const double near = cos(10 * IBL_PI / 180);
    const float share =
        b->dropped <= least_share * b->peak ? least_share : most_share;
    double peak[3], length = 0;

    *out = (ibl_brightest){.found = b->count && b->dropped <= share * b->peak};
    if (!out->found)
        return;
    out->share = (double)share;
    row r = row_of(b, b->peak_y);
    direction_of(b, &r, b->peak_x, peak);
    for (size_t i = 0; i < b->count; i++) {
        const ibl_bright_pixel *p = &b->list[i];
        double d[3], light = 0;

        if (largest(p->rgb) < share * b->peak)
            continue;
        if (p->y != r.y)
            r = row_of(b, p->y);
        direction_of(b, &r, p->x, d);
        if (d[0] * peak[0] + d[1] * peak[1] + d[2] * peak[2] < near)
            continue;
        for (int c = 0; c < 3; c++) {
            out->irradiance[c] += r.solid_angle * (double)p->rgb[c];
            light += r.solid_angle * (double)p->rgb[c];
        }
        for (int k = 0; k < 3; k++)
            out->direction[k] += light * d[k];
        out->solid_angle += r.solid_angle;
    }
    for (int k = 0; k < 3; k++)
        length += out->direction[k] * out->direction[k];
    for (int k = 0; k < 3; k++)
        out->direction[k] /= sqrt(length);
}

void ibl_bright_free(ibl_bright_pixels *b)
{
    ibl_free(b->list);
    *b = (ibl_bright_pixels){0};
}
