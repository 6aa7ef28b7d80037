/* SPDX-License-Identifier: MIT */
#include <math.h>

#include "core/pi.h"
#include "core/vector.h"
#include "ibl/probes.h"

const char *ibl_shape_name(ibl_shape shape)
{
    switch (shape) {
    case IBL_SHAPE_BOX:
        return "box";
    case IBL_SHAPE_SPHERE:
        return "sphere";
    }
    return "unknown";
}

double ibl_volume_size(const ibl_volume *volume)
{
    const double *h = volume->half;

    if (volume->shape == IBL_SHAPE_SPHERE)
        return 4 * IBL_PI / 3 * h[0] * h[0] * h[0];
    return 8 * h[0] * h[1] * h[2];
}

/* How far inside of a volume a point is; negative outside. No two points
 * differ by more than their distance. */
static double depth_in(const ibl_volume *volume, const double point[3])
{
    const double *c = volume->centre, *h = volume->half;

    if (volume->shape == IBL_SHAPE_SPHERE)
        return h[0] - distance3(point, c);
    const double x = h[0] - fabs(point[0] - c[0]);
    const double y = h[1] - fabs(point[1] - c[1]);
    const double z = h[2] - fabs(point[2] - c[2]);

    return fmin(fmin(x, y), z);
}

double ibl_probe_influence(const ibl_probe *probe, const double point[3])
{
    const double depth = depth_in(&probe->influence, point);

    if (!(depth > 0))
        return 0;
    if (!(depth < probe->blend))
        return 1;
    const double t = depth / probe->blend;

    return t * t * (3 - 2 * t);
}
