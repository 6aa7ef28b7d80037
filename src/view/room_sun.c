/* SPDX-License-Identifier: MIT */
#include "view/room_sun.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "view/message.h"
#include "view/vector.h"

/* Half angle of the cone, for a sun of a coarse cube and much of its glow. */
static const double cone_deg = 10;
/* Limit, in mean luminances outside; skies without their sun stay below. */
static const double times_mean = 8;
/* Maximum root mean square angle to the middle of the sun: a disc about 6
 * degrees wide. Wider ones cast softer shadows than one direction can. */
static const double most_spread_deg = 2;
/* Minimum irradiance, relative to that of the mean outside the cone. */
static const double least_share = 0.1;

#define DEGREE (M_PI / 180)

enum {
    CENTRINGS = 8 /* times that the cone moves to the middle of its light */
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

/* Reads a row of level 0; values below 0 or not finite become 0. */
static void read_row(const ibl_texture *sky, int face, int y, float *rgb)
{
    const size_t n = (size_t)sky->width;

    ibl_pixel_decode(sky->pixel,
                     sky->data + ibl_texture_offset(sky, 0, face) +
                         (size_t)y * n * ibl_pixel_bytes(sky->pixel),
                     n, rgb);
    for (size_t i = 0; i < 3 * n; i++)
        if (!isfinite(rgb[i]) || rgb[i] < 0)
            rgb[i] = 0;
}

static void copy_rgb(const float *row, int x, double rgb[3])
{
    for (int k = 0; k < 3; k++)
        rgb[k] = (double)row[3 * x + k];
}

/* Returns the highest luminance: 0, and no direction, if all is black. */
static double find_brightest(const ibl_texture *sky, float *row,
                             double direction[3])
{
    const int n = sky->width;
    double most = 0, rgb[3];

    for (int i = 0; i < IBL_FACES * n; i++) {
        read_row(sky, i / n, i % n, row);
        for (int x = 0; x < n; x++) {
            copy_rgb(row, x, rgb);
            if (luminance(rgb) <= most)
                continue;
            most = luminance(rgb);
            ibl_cube_direction(n, i / n, x, i % n, direction);
        }
    }
    return most;
}

/* The texels near the brightest one, and integrals of the rest. */
typedef struct region {
    texel *texels;
    int count;
    double rest, rest_angle; /* integrals outside the cone: luminance, 1 */
} region;

/* More than twice the cone has: 0.38 sr, the smallest texel 0.77 / n^2. */
static size_t max_texels(size_t n)
{
    return n * n / 2 + 4;
}

static void add_texel(region *g, const texel *t, const double peak[3])
{
    const double c = dot3(t->direction, peak);

    if (c < cos(cone_deg * DEGREE)) {
        g->rest += luminance(t->rgb) * t->solid_angle;
        g->rest_angle += t->solid_angle;
    }
    if (c >= cos(2 * cone_deg * DEGREE))
        g->texels[g->count++] = *t;
}

/* Collects the texels in twice the cone, which will move to the middle of the
 * light, and integrates outside the cone. All faces have the same angles. */
static void gather(const ibl_texture *sky, float *row, double *angles,
                   const double peak[3], region *g)
{
    const int n = sky->width;

    for (int i = 0; i < IBL_FACES * n; i++) {
        const int face = i % IBL_FACES, y = i / IBL_FACES;
        for (int x = 0; x < n && !face; x++)
            angles[x] = ibl_cube_solid_angle(n, x, y);
        read_row(sky, face, y, row);
        for (int x = 0; x < n; x++) {
            texel t = {.solid_angle = angles[x]};
            copy_rgb(row, x, t.rgb);
            ibl_cube_direction(n, face, x, y, t.direction);
            add_texel(g, &t, peak);
        }
    }
}

/* ---- the sun ------------------------------------------------------------ */

bool view_room_sun_shines(const view_room_sun *sun)
{
    return luminance(sun->irradiance) > 0;
}

/* Sums the light in the cone above the limit. Returns its middle, not of unit
 * length, and the mean squared distance of directions to the cone's axis. */
static double sum_light(const region *g, view_room_sun *sun, double middle[3])
{
    double sum = 0, square = 0;

    memset(sun->irradiance, 0, sizeof sun->irradiance);
    memset(middle, 0, 3 * sizeof *middle);
    for (int i = 0; i < g->count; i++) {
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

/* Centres the cone on its light. Returns the mean squared distance. */
static double centre_cone(const region *g, view_room_sun *sun)
{
    double middle[3], square = sum_light(g, sun, middle);

    for (int i = 0; i < CENTRINGS && dot3(middle, middle) > 0; i++) {
        normalise3(middle);
        memcpy(sun->direction, middle, sizeof middle);
        square = sum_light(g, sun, middle);
    }
    return square;
}

/* Finds the sun from the peak at sun->direction. */
static void find(const ibl_texture *sky, float *row, double *angles, region *g,
                 view_room_sun *sun)
{
    const double most_square = pow(most_spread_deg * DEGREE, 2);

    gather(sky, row, angles, sun->direction, g);
    const double mean = g->rest_angle > 0 ? g->rest / g->rest_angle : 0;
    sun->limit = times_mean * mean;
    const double square = centre_cone(g, sun);
    if (square > most_square ||
        luminance(sun->irradiance) <= least_share * M_PI * mean)
        *sun = (view_room_sun){0};
}

bool view_room_sun_find(const ibl_texture *sky, view_room_sun *sun)
{
    const size_t n = (size_t)sky->width;
    float *row = malloc(3 * n * sizeof *row);
    double *angles = malloc(n * sizeof *angles);
    region g = {.texels = malloc(max_texels(n) * sizeof *g.texels)};
    const bool ok = row && angles && g.texels;

    *sun = (view_room_sun){.cosine = cos(cone_deg * DEGREE)};
    if (!ok)
        view_fail("no memory to look for the sun");
    else if (find_brightest(sky, row, sun->direction) > 0)
        find(sky, row, angles, &g, sun);
    else
        *sun = (view_room_sun){0};
    free(g.texels);
    free(angles);
    free(row);
    return ok;
}
