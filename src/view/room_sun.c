/* SPDX-License-Identifier: MIT */
#include "view/room_sun.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "view/message.h"
#include "view/vector.h"

/* Wide enough for a sun of a coarse cube and for much of its glow. */
static const double cone_deg = 10;
/* Of the mean luminance outside: skies without their sun have less. */
static const double times_mean = 8;
/* Root mean square angle to the middle of the sun. Discs 6 degrees wide cast
 * softer shadows than one direction can. */
static const double most_spread_deg = 2;
/* Of the irradiance that the mean outside gives. */
static const double least_share = 0.1;

#define DEGREE (M_PI / 180)

enum {
    SETTLED = 8 /* times that the cone comes to the middle of what is in it */
};

/* Linear Rec. 709, as everywhere in the viewer. */
static double luminance(const double rgb[3])
{
    return 0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2];
}

/* ---- texels ------------------------------------------------------------- */

typedef struct texel {
    double direction[3], rgb[3], solid_angle;
} texel;

/* A row at a time of level 0. */
typedef struct rows {
    const ibl_texture *sky;
    float *rgb;           /* of a row; what is not finite, or less, is 0 */
    double *solid_angles; /* of a face */
    int face, y;
} rows;

static bool start_rows(rows *r, const ibl_texture *sky)
{
    const size_t n = (size_t)sky->width;

    *r = (rows){.sky = sky};
    r->rgb = malloc(3 * n * sizeof *r->rgb);
    r->solid_angles = malloc(n * n * sizeof *r->solid_angles);
    if (!r->rgb || !r->solid_angles)
        return view_fail("no memory to look for the sun");
    for (size_t i = 0; i < n * n; i++)
        r->solid_angles[i] =
            ibl_cube_solid_angle((int)n, (int)(i % n), (int)(i / n));
    return true;
}

static void again(rows *r)
{
    r->face = 0;
    r->y = -1;
}

static bool next_row(rows *r)
{
    const ibl_texture *t = r->sky;
    const size_t n = (size_t)t->width;

    if (++r->y == t->width) {
        r->y = 0;
        r->face++;
    }
    if (r->face == IBL_FACES)
        return false;
    ibl_pixel_decode(t->pixel,
                     t->data + ibl_texture_offset(t, 0, r->face) +
                         (size_t)r->y * n * ibl_pixel_bytes(t->pixel),
                     n, r->rgb);
    for (size_t i = 0; i < 3 * n; i++)
        if (!isfinite(r->rgb[i]) || r->rgb[i] < 0)
            r->rgb[i] = 0;
    return true;
}

static void copy_rgb(const rows *r, int x, double rgb[3])
{
    for (int k = 0; k < 3; k++)
        rgb[k] = (double)r->rgb[3 * x + k];
}

/* Its luminance; 0 and no direction if all is black. */
static double brightest(rows *r, double direction[3])
{
    double most = 0, rgb[3];

    again(r);
    while (next_row(r))
        for (int x = 0; x < r->sky->width; x++) {
            copy_rgb(r, x, rgb);
            if (luminance(rgb) <= most)
                continue;
            most = luminance(rgb);
            ibl_cube_direction(r->sky->width, r->face, x, r->y, direction);
        }
    return most;
}

/* What is near the brightest texel, and all the rest in one. */
typedef struct region {
    texel *texels;
    size_t count, room;
    double rest, rest_angle; /* integrals of what is not in the cone */
} region;

static bool keep(region *g, const texel *t)
{
    if (g->count == g->room) {
        const size_t room = 2 * g->room + 1024;
        texel *grown = realloc(g->texels, room * sizeof *grown);
        if (!grown)
            return view_fail("no memory to look for the sun");
        g->texels = grown;
        g->room = room;
    }
    g->texels[g->count++] = *t;
    return true;
}

/* Keeps the texels in twice the cone, which will move from the peak to the
 * middle, and the mean outside of the cone. */
static bool gather(rows *r, const double peak[3], region *g)
{
    const double inner = cos(cone_deg * DEGREE);
    const double outer = cos(2 * cone_deg * DEGREE);
    const int n = r->sky->width;

    again(r);
    while (next_row(r))
        for (int x = 0; x < n; x++) {
            texel t = {.solid_angle = r->solid_angles[r->y * n + x]};
            copy_rgb(r, x, t.rgb);
            ibl_cube_direction(n, r->face, x, r->y, t.direction);
            const double c = dot3(t.direction, peak);
            if (c < inner) {
                g->rest += luminance(t.rgb) * t.solid_angle;
                g->rest_angle += t.solid_angle;
            }
            if (c >= outer && !keep(g, &t))
                return false;
        }
    return true;
}

/* ---- the sun ------------------------------------------------------------ */

bool view_room_sun_shines(const view_room_sun *sun)
{
    return luminance(sun->irradiance) > 0;
}

void view_room_sun_cut(const view_room_sun *sun, const double direction[3],
                       double rgb[3])
{
    const double y = luminance(rgb);

    if (!view_room_sun_shines(sun) || y <= sun->limit ||
        dot3(direction, sun->direction) < sun->cosine)
        return;
    for (int k = 0; k < 3; k++)
        rgb[k] *= sun->limit / y;
}

/* Sums the light in the sun's cone above the limit. Returns its middle (not of
 * unit length), and the mean squared distance of direction to it. */
static double take(const region *g, view_room_sun *sun, double middle[3])
{
    double sum = 0, square = 0;

    memset(sun->irradiance, 0, sizeof sun->irradiance);
    memset(middle, 0, 3 * sizeof *middle);
    for (size_t i = 0; i < g->count; i++) {
        const texel *t = &g->texels[i];
        const double y = luminance(t->rgb);
        const double c = dot3(t->direction, sun->direction);
        if (c < sun->cosine || y <= sun->limit)
            continue;
        const double share = (1 - sun->limit / y) * t->solid_angle;
        for (int k = 0; k < 3; k++) {
            sun->irradiance[k] += share * t->rgb[k];
            middle[k] += share * y * t->direction[k];
        }
        sum += share * y;
        square += share * y * 2 * (1 - c);
    }
    return sum > 0 ? square / sum : 0;
}

/* About the middle of what it takes, which a cone beside it has less of. */
static double settle(const region *g, view_room_sun *sun)
{
    double middle[3], square = take(g, sun, middle);

    for (int i = 0; i < SETTLED && dot3(middle, middle) > 0; i++) {
        normalise3(middle);
        memcpy(sun->direction, middle, sizeof middle);
        square = take(g, sun, middle);
    }
    return square;
}

bool view_room_sun_find(const ibl_texture *sky, view_room_sun *sun)
{
    const double most_square = pow(most_spread_deg * DEGREE, 2);
    rows r;
    region g = {0};
    double square = 0;

    *sun = (view_room_sun){.cosine = cos(cone_deg * DEGREE)};
    bool ok = start_rows(&r, sky);
    if (ok && brightest(&r, sun->direction) > 0)
        ok = gather(&r, sun->direction, &g);
    const double mean = g.rest_angle > 0 ? g.rest / g.rest_angle : 0;
    sun->limit = times_mean * mean;
    if (ok)
        square = settle(&g, sun);
    if (square > most_square ||
        luminance(sun->irradiance) <= least_share * M_PI * mean)
        *sun = (view_room_sun){0};
    free(g.texels);
    free(r.solid_angles);
    free(r.rgb);
    return ok;
}
