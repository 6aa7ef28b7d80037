/* SPDX-License-Identifier: MIT */
/*
 * The lobe over a pixel that is not small against it.
 *
 * In theta and phi, which are offsets from the peak here so that the
 * narrowest lobe keeps its digits, the integrand
 *     (a2 / t)^2 (1 - 2q) sin(theta),  t = q + a2 (1 - q),
 *     q = sin^2(dtheta / 2) + sin(theta) sin(theta_N) sin^2(dphi / 2)
 * is analytic above the horizon, and its nearest singularities are about
 * 2 sqrt(t) away. A cell takes 4 x 4 Gauss points, of its lines of constant
 * theta only what is above the horizon; it is halved, along its longer side or
 * along both, until halving changes nothing. A patch that holds the peak is
 * first cut there: from a corner at 0 halving is exact in floating point
 * however deep it goes. One that the horizon crosses is cut where it enters
 * and where it leaves.
 */
#include <stdbool.h>

#include "bake/reference_sums.h"

enum {
    GAUSS = 4,
    MAX_DEPTH = 1000
};

static const double relative = 1e-8;
/* Of the whole patch, for the ends of the horizon's curve. */
static const double absolute = 1e-10;

static const double node[GAUSS] = {-0.861136311594052575, -0.339981043584856265,
                                   0.339981043584856265, 0.861136311594052575};
static const double mass[GAUSS] = {0.347854845137453857, 0.652145154862546143,
                                   0.652145154862546143, 0.347854845137453857};

struct lobe {
    const ibl_aim *aim;
    double a2;
    double y0, y1; /* the strip of phi, 0..pi */
    double enough; /* an error too small to matter */
};

/* A part of a strip: theta as an offset, and shares of y0..y1 or, where the
 * horizon cuts that, of y0..horizon. */
struct cell {
    double x0, x1, h0, h1;
};

/* Where y0..y1 dives below the horizon, q = 1/2. */
static double horizon(const struct lobe *lobe, double polar, double scale)
{
    const double s = sin(0.5 * lobe->y1);

    if (polar + scale * (s * s) <= 0.5)
        return lobe->y1;
    if (polar >= 0.5)
        return lobe->y0;
    return fmax(lobe->y0, 2 * asin(fmin(1, sqrt((0.5 - polar) / scale))));
}

static double gauss_line(const struct lobe *lobe, const struct cell *c,
                         double x, double sin_theta)
{
    const double p = sin(0.5 * x), polar = p * p;
    const double scale = sin_theta * lobe->aim->sin_theta;
    const double length = horizon(lobe, polar, scale) - lobe->y0;
    const double middle = lobe->y0 + 0.5 * length * (c->h0 + c->h1);
    const double half = 0.5 * length * (c->h1 - c->h0);
    double line = 0;

    for (int k = 0; k < GAUSS && half > 0; k++) {
        const double s = sin(0.5 * (middle + half * node[k]));
        const double q = polar + scale * (s * s);
        const double g = lobe->a2 / (q + lobe->a2 * (1 - q));
        line += q < 0.5 ? mass[k] * (1 - 2 * q) * g * g : 0;
    }
    return line * half * sin_theta;
}

static double gauss(const struct lobe *lobe, const struct cell *c)
{
    const double middle = 0.5 * (c->x0 + c->x1), half = 0.5 * (c->x1 - c->x0);
    double sum = 0;

    for (int i = 0; i < GAUSS; i++) {
        const double x = middle + half * node[i];
        sum += mass[i] * gauss_line(lobe, c, x, sin(lobe->aim->theta + x));
    }
    return sum * half;
}

/* Cuts a cell; returns the number of parts. */
static int cut(const struct lobe *lobe, const struct cell *c,
               struct cell parts[4])
{
    const double x = 0.5 * (c->x0 + c->x1), h = 0.5 * (c->h0 + c->h1);
    const double top = lobe->aim->theta + c->x0;
    const double bottom = lobe->aim->theta + c->x1;
    const double equator = 0.5 * REFERENCE_PI;
    const double widest =
        top < equator && bottom > equator ? 1 : fmax(sin(top), sin(bottom));
    const double tall = c->x1 - c->x0;
    const double wide = widest * (c->h1 - c->h0) * (lobe->y1 - lobe->y0);

    if (tall > 2 * wide) {
        parts[0] = (struct cell){c->x0, x, c->h0, c->h1};
        parts[1] = (struct cell){x, c->x1, c->h0, c->h1};
        return 2;
    }
    if (wide > 2 * tall) {
        parts[0] = (struct cell){c->x0, c->x1, c->h0, h};
        parts[1] = (struct cell){c->x0, c->x1, h, c->h1};
        return 2;
    }
    parts[0] = (struct cell){c->x0, x, c->h0, h};
    parts[1] = (struct cell){c->x0, x, h, c->h1};
    parts[2] = (struct cell){x, c->x1, c->h0, h};
    parts[3] = (struct cell){x, c->x1, h, c->h1};
    return 4;
}

static double refine(const struct lobe *lobe, const struct cell *cell,
                     double whole, int depth)
{
    struct cell parts[4];
    double of[4], sum = 0;
    const int n = cut(lobe, cell, parts);

    for (int k = 0; k < n; k++) {
        of[k] = gauss(lobe, &parts[k]);
        sum += of[k];
    }
    const double change = fabs(sum - whole);
    if (change <= relative * sum || change <= lobe->enough || !depth)
        return sum;
    sum = 0;
    for (int k = 0; k < n; k++)
        sum += refine(lobe, &parts[k], of[k], depth - 1);
    return sum;
}

/* Sorts x into at[0..count - 1] if it is inside at[0]..at[count - 1]. */
static int insert(double *at, int count, double x)
{
    int k = count;

    if (!(x > at[0] && x < at[count - 1]))
        return count;
    for (; at[k - 1] > x; k--)
        at[k] = at[k - 1];
    at[k] = x;
    return count + 1;
}

/*
 * Cuts the lobe's strip at the peak and where the horizon enters and leaves
 * it. There N.L = cos(theta) cos(theta_N) + sin(theta) sin(theta_N) cos(y) is
 * 0: a quarter turn from where it is largest.
 */
static int cut_strip(const struct lobe *lobe, const ibl_patch *patch,
                     struct cell parts[8])
{
    const ibl_aim *aim = lobe->aim;
    double x[9] = {patch->x0, patch->x1};
    int count = insert(x, 2, 0);

    for (int k = 0; k < 2; k++) {
        const double y = k ? lobe->y1 : lobe->y0;
        const double highest =
            atan2(aim->sin_theta * cos(y), cos(aim->theta)) - aim->theta;
        for (int turn = -1; turn <= 3; turn += 2)
            count = insert(x, count, highest + turn * 0.5 * REFERENCE_PI);
    }
    for (int k = 0; k + 1 < count; k++)
        parts[k] = (struct cell){x[k], x[k + 1], 0, 1};
    return count - 1;
}

static double over_strip(const ibl_aim *aim, double a2, const ibl_patch *patch,
                         double y0, double y1)
{
    struct lobe lobe = {aim, a2, y0, y1, 0};
    struct cell parts[8];
    double of[8], whole = 0, sum = 0;
    const int count = cut_strip(&lobe, patch, parts);

    for (int k = 0; k < count; k++) {
        of[k] = gauss(&lobe, &parts[k]);
        whole += of[k];
    }
    /* A point near the peak makes too much of it; but the integral over the
     * sphere is at most 4 pi a2, as that of D N.L is at most 4. */
    lobe.enough = absolute * fmin(whole, 4 * REFERENCE_PI * a2);
    for (int k = 0; k < count; k++)
        sum += refine(&lobe, &parts[k], of[k], MAX_DEPTH);
    return sum;
}

/* By half turns of phi, folded to 0..pi. */
double ibl_reference_patch(const ibl_aim *aim, double a2,
                           const ibl_patch *patch)
{
    double sum = 0;

    for (int k = -2; k < 2; k++) {
        const double begin = fmax(patch->y0, k * REFERENCE_PI);
        const double end = fmin(patch->y1, (k + 1) * REFERENCE_PI);
        const double turn = k == -2 ? -2 : k == 1 ? 2 : 0;
        const double a = fabs(begin - turn * REFERENCE_PI);
        const double b = fabs(end - turn * REFERENCE_PI);
        if (begin < end)
            sum += over_strip(aim, a2, patch, fmin(a, b), fmax(a, b));
    }
    return sum;
}
