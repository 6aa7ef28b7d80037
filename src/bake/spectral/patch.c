/* SPDX-License-Identifier: MIT */
/*
 * GGX as a function of the angle has its nearest singularities 2 alpha i from
 * the peak. n points leave rho^-2n of an integral over a length e, with
 * rho = r + sqrt(1 + r^2), r = 4 alpha / e (the largest ellipse around the
 * interval without a singularity). Phong is about a Gaussian of that width.
 */
#include "bake/spectral/patch.h"

#include <math.h>
#include <stdbool.h>

#include "core/pi.h"

static double height_of(const ibl_patch *p)
{
    return p->theta[1] - p->theta[0];
}

static double middle_of(const ibl_patch *p)
{
    return 0.5 * (p->theta[0] + p->theta[1]);
}

static void direction(double theta, double phi, double d[3])
{
    d[0] = sin(theta) * cos(phi);
    d[1] = cos(theta);
    d[2] = sin(theta) * sin(phi);
}

void ibl_patch_middle(const ibl_patch *p, double d[3])
{
    direction(middle_of(p), p->phi, d);
}

/* A product without cancellation. */
double ibl_patch_angle(const ibl_patch *p)
{
    return 2 * p->width * sin(middle_of(p)) * sin(0.5 * height_of(p));
}

/* First along a parallel, then along a meridian. */
double ibl_patch_radius(const ibl_patch *p)
{
    const double height = height_of(p);
    return 0.5 * height +
           0.5 * p->width * sin(middle_of(p)) * (1 + 0.5 * height);
}

/* ---- points ------------------------------------------------------------ */

/* Newton's method. */
void ibl_rule_make(int n, ibl_rule *r)
{
    if (r->count == n)
        return;
    r->count = n;
    for (int i = 0; i < n; i++) {
        double x = cos(IBL_PI * (i + 0.75) / (n + 0.5)), slope = 1;
        for (int step = 0; step < 8; step++) {
            double p = 1, below = 0;
            for (int l = 0; l < n; l++) {
                const double next = ((2 * l + 1) * x * p - l * below) / (l + 1);
                below = p;
                p = next;
            }
            slope = n * (x * p - below) / (x * x - 1);
            x -= p / slope;
        }
        r->node[i] = x;
        r->mass[i] = 2 / ((1 - x * x) * slope * slope);
    }
}

int ibl_rule_nodes(double extent, double reach, double error)
{
    /* One point misses (extent / reach)^2 2/3 of a function that falls as the
     * fourth power of the distance. */
    const int least = extent * extent * 2 > 3 * error * reach * reach ? 2 : 1;
    const double left = -log(fmin(0.6 * error, 0.1));
    const double n = fmax(ceil(0.5 * left / asinh(2 * reach / extent)), least);
    return n < IBL_RULE_MOST - 2 ? (int)n : IBL_RULE_MOST - 2;
}

int ibl_patch_points(const ibl_patch *p, double reach, double error,
                     ibl_patch_rules *rules, ibl_patch_light *out)
{
    const double theta = middle_of(p), height = height_of(p);
    const int down = ibl_rule_nodes(height, reach, error);
    const int across = ibl_rule_nodes(p->width * sin(theta), reach, error);
    double at[IBL_RULE_MOST], row[IBL_RULE_MOST], sum = 0;

    if (!out)
        return down * across;
    ibl_rule_make(down, &rules->down);
    ibl_rule_make(across, &rules->across);
    for (int j = 0; j < down; j++) {
        at[j] = theta + 0.5 * height * rules->down.node[j];
        /* A single point is the centroid, on a parallel that of its arc. */
        if (down == 1)
            at[j] += (1 - 0.5 * height / tan(0.5 * height)) / tan(theta);
        row[j] = rules->down.mass[j] * sin(at[j]);
        sum += row[j];
        if (across == 1)
            at[j] = atan2(sin(at[j]) * sin(0.5 * p->width) / (0.5 * p->width),
                          cos(at[j]));
    }
    for (int j = 0; j < down; j++) {
        const double light = ibl_patch_angle(p) * row[j] / sum;
        for (int i = 0; i < across; i++, out++) {
            const double share = light * rules->across.mass[i] / 2;
            direction(at[j], p->phi + 0.5 * p->width * rules->across.node[i],
                      out->direction);
            for (int c = 0; c < 3; c++)
                out->rgb[c] = (double)p->rgb[c] * share;
        }
    }
    return down * across;
}

/* ---- the horizon -------------------------------------------------------- */

/* A part of a patch, seen from d. */
struct part {
    const ibl_lobe_shape *shape;
    const ibl_rule *rule;
    double theta[2], sin_theta[2], cos_theta[2];
    double from, width; /* azimuths relative to d's */
    double up, sine;    /* d's Y, and sqrt(1 - Y^2) */
};

/* Sine and cosine of at most ibl_patch_widest / 2, to 3e-9. */
static void small_turn(double x, double *sine, double *cosine)
{
    const double x2 = x * x;
    *sine = x * (1 - x2 * (1.0 / 6 - x2 * (1.0 / 120)));
    *cosine = 1 - x2 * (1.0 / 2 - x2 * (1.0 / 24 - x2 * (1.0 / 720)));
}

/* Moves that end of a meridian which is below the horizon up to it. */
static void end_at_horizon(double up, double across, double theta[2])
{
    const double bound = up > 0 ? atan2(up, -across) : atan2(-up, across);
    /* Which end is below depends on whether the pole theta = 0 is above. */
    const int below = up > 0;

    theta[below] = fmin(fmax(bound, theta[0]), theta[1]);
}

/* int K sin(theta) dtheta along a meridian above the horizon, which it crosses
 * at most once. across: d's component along the meridian's foot. */
static double meridian_sum(const struct part *p, double across)
{
    const double up = p->up;
    double theta[2] = {p->theta[0], p->theta[1]}, sum = 0;
    int above = 0;

    for (int i = 0; i < 2; i++)
        above += p->cos_theta[i] * up + p->sin_theta[i] * across > 0;
    if (!above)
        return 0;
    if (above < 2)
        end_at_horizon(up, across, theta);
    const double middle = 0.5 * (theta[0] + theta[1]);
    const double half = 0.5 * (theta[1] - theta[0]);
    const double sin_middle = sin(middle), cos_middle = cos(middle);
    for (int k = 0; k < p->rule->count; k++) {
        double sin_x, cos_x;
        small_turn(half * p->rule->node[k], &sin_x, &cos_x);
        const double sine = sin_middle * cos_x + cos_middle * sin_x;
        const double cosine =
            (cos_middle * cos_x - sin_middle * sin_x) * up + sine * across;
        sum += p->rule->mass[k] * sine *
               ibl_lobe_value(p->shape, 0.5 - 0.5 * cosine, cosine);
    }
    return half * sum;
}

/* Writes the azimuths where the horizon crosses the rows' edges, since the
 * integral over a meridian has corners there: sorted, with both ends. Returns
 * their number. */
static int corners(const struct part *p, double out[6])
{
    const double middle = cos(p->from + 0.5 * p->width);
    int count = 0;

    out[count++] = p->from;
    for (int i = 0; i < 2; i++) {
        const double up = p->cos_theta[i] * p->up;
        const double across = p->sin_theta[i] * p->sine;
        if (fabs(up + across * middle) > 0.5 * p->width * across)
            continue;
        for (int k = -1; fabs(up) < across && k <= 1; k += 2) {
            const double at = k * acos(-up / across) - p->from;
            const double past = at - 2 * IBL_PI * floor(at / (2 * IBL_PI));
            if (past < p->width)
                out[count++] = p->from + past;
        }
    }
    out[count++] = p->from + p->width;
    for (int i = 1; i < count; i++)
        for (int k = i; k > 0 && out[k] < out[k - 1]; k--) {
            const double swap = out[k];
            out[k] = out[k - 1];
            out[k - 1] = swap;
        }
    return count;
}

static double part_sum(const struct part *p)
{
    double at[6], sum = 0;
    const int count = corners(p, at);

    for (int i = 1; i < count; i++) {
        const double half = 0.5 * (at[i] - at[i - 1]), middle = at[i] - half;
        const double sine = p->sine * sin(middle);
        const double cosine = p->sine * cos(middle);
        for (int k = 0; half > 0 && k < p->rule->count; k++) {
            double sin_x, cos_x;
            small_turn(half * p->rule->node[k], &sin_x, &cos_x);
            sum += half * p->rule->mass[k] *
                   meridian_sum(p, cosine * cos_x - sine * sin_x);
        }
    }
    return sum;
}

double ibl_patch_lobe(const ibl_patch *patch, const ibl_lobe_shape *shape,
                      const ibl_rule *rule, const double d[3])
{
    const double height = height_of(patch), width = patch->width;
    const double from = patch->phi - 0.5 * width - atan2(d[2], d[0]);
    const int down = (int)ceil(height / ibl_patch_widest);
    const int across = (int)ceil(width / ibl_patch_widest);
    struct part p = {.shape = shape,
                     .rule = rule,
                     .width = width / across,
                     .up = d[1],
                     .sine = hypot(d[0], d[2])};
    double sum = 0;

    for (int j = 0; j < down; j++) {
        for (int k = 0; k < 2; k++) {
            p.theta[k] = patch->theta[0] + height * (j + k) / down;
            p.sin_theta[k] = sin(p.theta[k]);
            p.cos_theta[k] = cos(p.theta[k]);
        }
        for (int i = 0; i < across; i++) {
            p.from = from + width * i / across;
            sum += part_sum(&p);
        }
    }
    return sum;
}
