/* SPDX-License-Identifier: MIT */
#include <math.h>

#include "core/vector.h"
#include "ibl/probes.h"

/* Points up to this many half widths or radii from the centre are inside, so
 * that rounding does not lose points of a floor that is the wall. */
static const double slack = 1 + 1.0 / 1024;

/* Moves q to the point where the ray from q along unit d leaves the box around
 * the origin. False: q is outside. */
static bool leave_box(const double half[3], double q[3], const double d[3])
{
    double least = HUGE_VAL;

    for (int i = 0; i < 3; i++) {
        if (!(fabs(q[i]) <= half[i] * slack))
            return false;
        q[i] = fmax(-half[i], fmin(q[i], half[i]));
        if (d[i] == 0)
            continue;
        const double t = (copysign(half[i], d[i]) - q[i]) / d[i];
        least = fmin(least, t);
    }
    for (int i = 0; i < 3; i++)
        q[i] = fmax(-half[i], fmin(q[i] + least * d[i], half[i]));
    return true;
}

/* The same for the sphere: |q + t d| = radius, t >= 0. */
static bool leave_sphere(double radius, double q[3], const double d[3])
{
    double far = sqrt(dot3(q, q));

    if (!(far <= radius * slack))
        return false;
    if (far > radius) {
        for (int i = 0; i < 3; i++)
            q[i] *= radius / far;
        far = radius;
    }
    const double along = dot3(q, d);
    const double inside = (radius - far) * (radius + far);
    const double root = sqrt(along * along + inside);
    const double t = root - along;

    for (int i = 0; i < 3; i++)
        q[i] += t * d[i];
    return true;
}

int ibl_probe_parallax(const ibl_probe *probe, const double point[3],
                       const double direction[3], double lookup[3])
{
    const ibl_volume *proxy = &probe->proxy;
    double d[3] = {direction[0], direction[1], direction[2]}, q[3], to[3];
    bool hit = unit3(d);

    for (int i = 0; i < 3; i++)
        lookup[i] = d[i];
    if (!hit || !probe->has_proxy)
        return 0;
    subtract3(point, proxy->centre, q);
    hit = proxy->shape == IBL_SHAPE_SPHERE ? leave_sphere(proxy->half[0], q, d)
                                           : leave_box(proxy->half, q, d);
    if (!hit)
        return 0;
    for (int i = 0; i < 3; i++)
        to[i] = proxy->centre[i] - probe->position[i] + q[i];
    if (!unit3(to))
        return 0;
    for (int i = 0; i < 3; i++)
        lookup[i] = to[i];
    return 1;
}
