/* SPDX-License-Identifier: MIT */
/* Takes what is within a circle out of a map. */
#ifndef IBL_BAKE_DISC_TAKE_H
#define IBL_BAKE_DISC_TAKE_H

#include <math.h>

#include "core/pi.h"
#include "image/map_cap.h"

/* A circle on the sphere; its centre is a unit vector, not turned by a yaw. */
typedef struct ibl_disc {
    double centre[3], radius;
} ibl_disc;

static inline double ibl_disc_solid_angle(double radius)
{
    return 4 * IBL_PI * sin(0.5 * radius) * sin(0.5 * radius);
}

static inline double ibl_disc_radius(double solid_angle)
{
    return 2 * asin(fmin(sqrt(solid_angle / (4 * IBL_PI)), 1));
}

/* Rec. 709. */
static inline double ibl_luminance(const double rgb[3])
{
    return 0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2];
}

static inline double ibl_pixel_luminance(const float *rgb)
{
    return ibl_luminance(
        (const double[]){(double)rgb[0], (double)rgb[1], (double)rgb[2]});
}

/*
 * Makes map smooth within a circle and adds what was there to the lights, of
 * which there are *count and then at most `most`: one, or several if it is of
 * several parts, which leave room for others unless they are clearly apart.
 * Their directions are not turned. Channels that would become brighter keep
 * their pixels. A light of no luminance changes nothing, and is not added.
 */
ibl_status ibl_disc_take(ibl_ctx *ctx, const ibl_map_grid *grid, ibl_image *map,
                         const ibl_disc *disc, int most, int others,
                         ibl_light *lights, int *count);

#endif
