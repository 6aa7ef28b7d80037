/* SPDX-License-Identifier: MIT */
/*
 * Sample sets of filtered levels. Points cover the GGX half vectors whose
 * reflection is above the horizon (Walter et al. 2007, eq. 35, 36); each turns
 * by the golden angle from the one before, and counts by N.L (Karis 2013). Each
 * looks up the environment, blurred by the solid angle that the point stands
 * for (Krivanek and Colbert 2008).
 */
#include "view/capture.h"

#include <math.h>
#include <stdlib.h>

#include "common/signals.h"
#include "ibl/ibl.h"

/* Turn from one point to the next: the golden ratio - 1. */
static const double golden = 0.6180339887498949;

int view_capture_lookups(int size)
{
    int levels = 1;

    while (size >> levels >= 4)
        levels++;
    return levels;
}

/* Mixes levels only from 1/6 to 5/6, so one lookup in three needs one level and
 * half the work. */
static double snap_level(double lod)
{
    const double level = floor(lod);

    return level + fmin(fmax(1.5 * (lod - level) - 0.25, 0), 1);
}

/* Fills samples with x, y of a direction about +Z, weight and level of each
 * point. */
static void place_points(double alpha, int count, int size, float *samples)
{
    const double a2 = alpha * alpha, part = 1 / (1 + a2);
    const double texel = 4 * M_PI / (6.0 * size * size); /* of level 0, in sr */
    /* Lookups in level 0 show its texels. Level 1 must do where it is narrow
     * enough for the lobe. */
    const double least = 4 * VIEW_CAPTURE_BLUR * texel < a2;
    const double most = view_capture_lookups(size) - 1;
    double sum = 0;

    for (int i = 0; i < count; i++) {
        const double u = (i + 0.5) / count * part;
        const double s2 = a2 * u, c2 = 1 - u;
        const double sin_h = sqrt(s2 / (s2 + c2)), cos_h = sqrt(c2 / (s2 + c2));
        const double t = sin_h * sin_h + a2 * cos_h * cos_h;
        const double pdf = a2 / (M_PI * t * t) / (4 * part);
        /* A quarter of the point's solid angle: less shows single points, more
         * widens the lobe. */
        const double variance = 0.25 / (count * pdf);
        const double lod = 0.5 * log2(variance / (VIEW_CAPTURE_BLUR * texel));
        const double angle = 2 * atan2(sin_h, cos_h);
        const double phi = 2 * M_PI * fmod(i * golden, 1);
        samples[4 * i] = (float)(sin(angle) * cos(phi));
        samples[4 * i + 1] = (float)(sin(angle) * sin(phi));
        samples[4 * i + 2] = (float)cos(angle);
        samples[4 * i + 3] = (float)snap_level(fmin(fmax(lod, least), most));
        sum += cos(angle);
    }
    for (int i = 0; i < count; i++)
        samples[4 * i + 2] /= (float)sum;
}

float *view_capture_samples(int size, int levels)
{
    const size_t row = (size_t)4 * VIEW_CAPTURE_MOST_SAMPLES;
    float *all = ibl_need(calloc((size_t)levels, row * sizeof *all));

    for (int l = 1; l < levels; l++) {
        const double r = ibl_level_roughness(IBL_ROUGHNESS_LINEAR, l, levels);
        place_points(r * r, VIEW_CAPTURE_SAMPLES, size,
                     all + row * (size_t)(l - 1));
    }
    /* Of roughness 1 is N.L. */
    place_points(1, VIEW_CAPTURE_MOST_SAMPLES, size,
                 all + row * (size_t)(levels - 1));
    return all;
}
