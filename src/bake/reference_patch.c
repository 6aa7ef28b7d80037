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
 * theta only what is above the horizon; it is halved, along theta or phi,
 * until neither changes anything. A patch that holds the peak is first cut
 * there: from a corner at 0 halving is exact in floating point however deep it
 * goes. One that the horizon crosses is cut where it enters and where it
 * leaves.
 */
#include <stdbool.h>

#include "bake/reference_sums.h"

enum {
    GAUSS = 4,
    MAX_DEPTH = 1000,
    MAX_PARTS = 10
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
    double y0, y1;  /* the strip of phi, 0..pi */
    double across1; /* sin^2(y1 / 2) */
    double sum;     /* of the patch so far */
    double floor;   /* of the sum, before there is any */
};

/* A part of a strip: theta as an offset, and shares of y0..y1 or, where the
 * horizon cuts that, of y0..horizon. */
struct cell {
    double x0, x1, h0, h1;
};

/* Where y0..y1 dives below the horizon, q = 1/2. */
static double horizon(const struct lobe *lobe, double polar, double scale)
{
    if (polar + scale * lobe->across1 <= 0.5)
        return lobe->y1;
    if (polar >= 0.5)
        return lobe->y0;
    return fmax(lobe->y0, 2 * asin(fmin(1, sqrt((0.5 - polar) / scale))));
}

/* sin^2(phi / 2) at a cell's points, of y0..end; returns half its length. */
static double fill_across(const struct lobe *lobe, const struct cell *c,
                          double end, double across[GAUSS])
{
    const double length = end - lobe->y0;
    const double middle = lobe->y0 + 0.5 * length * (c->h0 + c->h1);
    const double half = 0.5 * length * (c->h1 - c->h0);

    for (int k = 0; k < GAUSS; k++) {
        const double s = sin(0.5 * (middle + half * node[k]));
        across[k] = s * s;
    }
    return half;
}

static double gauss_line(double a2, double polar, double scale,
                         const double across[GAUSS])
{
    double line = 0;

    for (int k = 0; k < GAUSS; k++) {
        const double q = polar + scale * across[k];
        const double g = a2 / (q + a2 * (1 - q));
        line += q < 0.5 ? mass[k] * (1 - 2 * q) * g * g : 0;
    }
    return line;
}

static double gauss(const struct lobe *lobe, const struct cell *c)
{
    const double middle = 0.5 * (c->x0 + c->x1), half = 0.5 * (c->x1 - c->x0);
    double full[GAUSS], part[GAUSS], sum = 0;
    const double full_half = fill_across(lobe, c, lobe->y1, full);

    for (int i = 0; i < GAUSS; i++) {
        const double x = middle + half * node[i], p = sin(0.5 * x);
        const double sin_theta = sin(lobe->aim->theta + x);
        const double polar = p * p, scale = sin_theta * lobe->aim->sin_theta;
        const double end = horizon(lobe, polar, scale);
        if (end <= lobe->y0)
            continue;
        const bool cut = end < lobe->y1;
        const double line_half =
            cut ? fill_across(lobe, c, end, part) : full_half;
        sum += mass[i] * sin_theta * line_half *
               gauss_line(lobe->a2, polar, scale, cut ? part : full);
    }
    return sum * half;
}

/*
 * Adds a cell. It is halved either way for the test; where one of the two
 * changes something it is halved so for good, the part next to the peak first:
 * against that the others seldom matter.
 */
static void refine(struct lobe *lobe, const struct cell *c, double whole,
                   int depth)
{
    const double x = 0.5 * (c->x0 + c->x1), h = 0.5 * (c->h0 + c->h1);
    const struct cell parts[4] = {{c->x0, x, c->h0, c->h1},
                                  {x, c->x1, c->h0, c->h1},
                                  {c->x0, c->x1, c->h0, h},
                                  {c->x0, c->x1, h, c->h1}};
    double of[4];

    for (int k = 0; k < 4; k++)
        of[k] = gauss(lobe, &parts[k]);
    const double by_x = of[0] + of[1] - whole, by_h = of[2] + of[3] - whole;
    const double change = fabs(by_x) + fabs(by_h);
    const double better = whole + by_x + by_h;
    if (change <= relative * better ||
        change <= absolute * fmax(lobe->floor, lobe->sum) || !depth) {
        lobe->sum += better;
        return;
    }
    const int first = fabs(by_x) < fabs(by_h) ? 2 : c->x0 >= 0 ? 0 : 1;
    const int second = first ^ 1;
    refine(lobe, &parts[first], of[first], depth - 1);
    refine(lobe, &parts[second], of[second], depth - 1);
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
 * Cuts the lobe's strip at the peak, beside it, so that the way there is
 * short, and where the horizon enters and leaves. There N.L = cos(theta)
 * cos(theta_N) + sin(theta) sin(theta_N) cos(y) is 0: a quarter turn from
 * where it is largest.
 */
static int cut_strip(const struct lobe *lobe, const ibl_patch *patch,
                     struct cell parts[MAX_PARTS])
{
    const ibl_aim *aim = lobe->aim;
    const double beside = 32 * sqrt(lobe->a2);
    double x[MAX_PARTS + 1] = {patch->x0, patch->x1};
    int count = insert(x, 2, 0);

    count = insert(x, count, -beside);
    count = insert(x, count, beside);
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

/* Distance in theta from the peak. */
static double away(const struct cell *c)
{
    return c->x0 >= 0 ? c->x0 : c->x1 <= 0 ? -c->x1 : 0;
}

static void add_strip(struct lobe *lobe, const ibl_patch *patch)
{
    struct cell parts[MAX_PARTS];
    double of[MAX_PARTS], whole = 0;
    const int count = cut_strip(lobe, patch, parts);

    for (int k = 0; k < count; k++) {
        of[k] = gauss(lobe, &parts[k]);
        whole += of[k];
    }
    /* A point near the peak makes too much of it; but the integral over the
     * sphere is at most 4 pi a2, as that of D N.L is at most 4. */
    lobe->floor = fmin(whole, 4 * REFERENCE_PI * lobe->a2);
    for (int done = 0; done < count; done++) {
        int next = -1;
        for (int k = 0; k < count; k++) {
            if (of[k] >= 0 &&
                (next < 0 || away(&parts[k]) < away(&parts[next])))
                next = k;
        }
        refine(lobe, &parts[next], of[next], MAX_DEPTH);
        of[next] = -1;
    }
}

/* By half turns of phi, folded to 0..pi; those at the peak first. */
double ibl_reference_patch(const ibl_aim *aim, double a2,
                           const ibl_patch *patch)
{
    static const int order[4] = {0, -1, 1, -2};
    struct lobe lobe = {.aim = aim, .a2 = a2};

    for (int n = 0; n < 4; n++) {
        const int k = order[n], turn = k == -2 ? -2 : k == 1 ? 2 : 0;
        const double begin = fmax(patch->y0, k * REFERENCE_PI);
        const double end = fmin(patch->y1, (k + 1) * REFERENCE_PI);
        const double a = fabs(begin - turn * REFERENCE_PI);
        const double b = fabs(end - turn * REFERENCE_PI);
        if (begin < end) {
            lobe.y0 = fmin(a, b);
            lobe.y1 = fmax(a, b);
            lobe.across1 = pow(sin(0.5 * lobe.y1), 2);
            add_strip(&lobe, patch);
        }
    }
    return lobe.sum;
}
