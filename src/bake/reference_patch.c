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
 *
 * Phong and Charlie are nothing but for a disk and for a ring, and points might
 * miss those in a large cell: lines of constant theta are cut to where they
 * are, and so is the patch.
 */
#include <stdbool.h>

#include "bake/reference_sums.h"

enum {
    GAUSS = 4,
    MAX_DEPTH = 1000,
    MAX_PARTS = 20
};

static const double relative = 1e-8;
/* Of the whole patch, for the ends of the horizon's curve. */
static const double absolute = 1e-10;

static const double node[GAUSS] = {-0.861136311594052575, -0.339981043584856265,
                                   0.339981043584856265, 0.861136311594052575};
static const double mass[GAUSS] = {0.347854845137453857, 0.652145154862546143,
                                   0.652145154862546143, 0.347854845137453857};

/* ---- weights ---------------------------------------------------------- */

ibl_weight ibl_reference_weight(ibl_lobe lobe, double alpha)
{
    /* exp(-46) = 1e-20. */
    const double a2 = alpha * alpha, nothing = -46;
    ibl_weight w = {.lobe = lobe, .a2 = a2, .scale = 1, .most = 0.5};

    switch (lobe) {
    case IBL_LOBE_GGX:
        /* That of D N.L is at most 4. */
        w.whole = 4 * REFERENCE_PI * a2;
        break;
    case IBL_LOBE_CHARLIE:
        w.power = 0.5 / alpha;
        w.scale = (w.power + 1) * exp(1);
        w.least = 0.5 * exp(nothing / w.power);
        w.whole = 2 * REFERENCE_PI * exp(1) / (w.power + 2);
        break;
    case IBL_LOBE_PHONG:
        w.power = 1 + 0.5 * (1 / alpha - 1) * (1 / alpha + 1);
        w.most = -0.5 * expm1(nothing / w.power);
        w.whole = 2 * REFERENCE_PI / (w.power + 1);
        break;
    }
    return w;
}

double ibl_reference_weight_at(const ibl_weight *w, double q)
{
    if (!(q < 0.5))
        return 0;
    if (w->lobe == IBL_LOBE_CHARLIE)
        return w->scale * pow(2 * q, w->power) * (1 - 2 * q);
    if (w->lobe == IBL_LOBE_PHONG)
        return exp(w->power * log1p(-2 * q));
    const double g = w->a2 / (q + w->a2 * (1 - q));
    return (1 - 2 * q) * g * g;
}

/* ---- cells ------------------------------------------------------------ */

struct lobe {
    const ibl_aim *aim;
    const ibl_weight *weight;
    double y0, y1;           /* the strip of phi, 0..pi */
    double across0, across1; /* sin^2(y / 2) of those */
    double sum;              /* of the patch so far */
    double floor;            /* of the sum, before there is any */
};

/* A part of a strip: theta as an offset, and shares of y0..y1 or of the part of
 * that where the weight is something. */
struct cell {
    double x0, x1, h0, h1;
};

/* Where in y0..y1 q comes to a value. */
static double crossing(const struct lobe *lobe, double polar, double scale,
                       double q)
{
    if (polar + scale * lobe->across1 <= q)
        return lobe->y1;
    if (polar + scale * lobe->across0 >= q)
        return lobe->y0;
    return fmax(lobe->y0, 2 * asin(fmin(1, sqrt((q - polar) / scale))));
}

/* sin^2(phi / 2) at a cell's points, of begin..end; returns half its length. */
static double fill_across(const struct cell *c, double begin, double end,
                          double across[GAUSS])
{
    const double length = end - begin;
    const double middle = begin + 0.5 * length * (c->h0 + c->h1);
    const double half = 0.5 * length * (c->h1 - c->h0);

    for (int k = 0; k < GAUSS; k++) {
        const double s = sin(0.5 * (middle + half * node[k]));
        across[k] = s * s;
    }
    return half;
}

static double gauss_line(const ibl_weight *weight, double polar, double scale,
                         const double across[GAUSS])
{
    double line = 0;

    for (int k = 0; k < GAUSS; k++)
        line += mass[k] *
                ibl_reference_weight_at(weight, polar + scale * across[k]);
    return line;
}

static double gauss(const struct lobe *lobe, const struct cell *c)
{
    const ibl_weight *weight = lobe->weight;
    const double middle = 0.5 * (c->x0 + c->x1), half = 0.5 * (c->x1 - c->x0);
    double full[GAUSS], part[GAUSS], sum = 0;
    const double full_half = fill_across(c, lobe->y0, lobe->y1, full);

    for (int i = 0; i < GAUSS; i++) {
        const double x = middle + half * node[i], p = sin(0.5 * x);
        const double sin_theta = sin(lobe->aim->theta + x);
        const double polar = p * p, scale = sin_theta * lobe->aim->sin_theta;
        const double begin = crossing(lobe, polar, scale, weight->least);
        const double end = crossing(lobe, polar, scale, weight->most);
        if (end <= begin)
            continue;
        const bool cut = begin > lobe->y0 || end < lobe->y1;
        const double line_half =
            cut ? fill_across(c, begin, end, part) : full_half;
        sum += mass[i] * sin_theta * line_half *
               gauss_line(weight, polar, scale, cut ? part : full);
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

/* Cuts where a meridian comes to an angle from the aim whose cosine is c0:
 * there c = cos(theta) cos(theta_N) + sin(theta) sin(theta_N) cos(y) is a
 * cosine of theta from where it is largest. */
static int cut_angle(const ibl_aim *aim, double y, double c0, double *x,
                     int count)
{
    const double across = aim->sin_theta * cos(y), up = cos(aim->theta);
    const double highest = atan2(across, up) - aim->theta;
    const double c = c0 / hypot(across, up);

    for (int turn = -1; turn <= 1 && c <= 1; turn++) {
        const double around = highest + turn * 2 * REFERENCE_PI;
        count = insert(x, count, around - acos(c));
        count = insert(x, count, around + acos(c));
    }
    return count;
}

/* Cuts the lobe's strip at the peak, beside it, so that the way there is
 * short, and where the horizon and the edge of a ring enter and leave. */
static int cut_strip(const struct lobe *lobe, const ibl_patch *patch,
                     struct cell parts[MAX_PARTS])
{
    const ibl_weight *weight = lobe->weight;
    const bool disk = weight->lobe == IBL_LOBE_PHONG;
    const double reach = 2 * asin(sqrt(weight->most));
    double x[MAX_PARTS + 1] = {fmax(patch->x0, disk ? -reach : patch->x0),
                               fmin(patch->x1, disk ? reach : patch->x1)};
    int count = 2;

    if (x[0] >= x[1])
        return 0;
    count = insert(x, count, 0);
    if (weight->lobe == IBL_LOBE_GGX) {
        count = insert(x, count, -32 * sqrt(weight->a2));
        count = insert(x, count, 32 * sqrt(weight->a2));
    }
    for (int k = 0; k < 2; k++) {
        const double y = k ? lobe->y1 : lobe->y0;
        count = cut_angle(lobe->aim, y, 0, x, count);
        if (weight->least > 0)
            count = cut_angle(lobe->aim, y, 1 - 2 * weight->least, x, count);
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

/* What of a weight needs no digits. Charlie and Phong are next to nothing in
 * places; GGX never is, but for slivers above the horizon that are rounding
 * alone, a few times 1e-16 of (a2 / t)^2, and do not settle however often they
 * are halved. */
static double worthless(const ibl_weight *w)
{
    const double horizon = 2 * w->a2 / (1 + w->a2);

    return w->lobe == IBL_LOBE_GGX ? 1e-4 * horizon * horizon : 1e-5 * w->whole;
}

static void add_strip(struct lobe *lobe, const ibl_patch *patch)
{
    struct cell parts[MAX_PARTS];
    double of[MAX_PARTS], whole = 0;
    bool taken[MAX_PARTS] = {false};
    const int count = cut_strip(lobe, patch, parts);

    for (int k = 0; k < count; k++) {
        of[k] = gauss(lobe, &parts[k]);
        whole += of[k];
    }
    /* A point near the peak makes too much of it. */
    lobe->floor = fmin(whole, lobe->weight->whole);
    lobe->floor =
        fmax(lobe->floor, (patch->x1 - patch->x0) * (patch->y1 - patch->y0) *
                              worthless(lobe->weight));
    for (int done = 0; done < count; done++) {
        int next = -1;
        for (int k = 0; k < count; k++) {
            if (!taken[k] && (next < 0 || away(&parts[k]) < away(&parts[next])))
                next = k;
        }
        refine(lobe, &parts[next], of[next], MAX_DEPTH);
        taken[next] = true;
    }
}

/* By half turns of phi, folded to 0..pi; those at the peak first. */
double ibl_reference_patch(const ibl_aim *aim, const ibl_weight *weight,
                           const ibl_patch *patch)
{
    static const int order[4] = {0, -1, 1, -2};
    struct lobe lobe = {.aim = aim, .weight = weight};

    for (int n = 0; n < 4; n++) {
        const int k = order[n], turn = k == -2 ? -2 : k == 1 ? 2 : 0;
        const double begin = fmax(patch->y0, k * REFERENCE_PI);
        const double end = fmin(patch->y1, (k + 1) * REFERENCE_PI);
        const double a = fabs(begin - turn * REFERENCE_PI);
        const double b = fabs(end - turn * REFERENCE_PI);
        if (begin < end) {
            lobe.y0 = fmin(a, b);
            lobe.y1 = fmax(a, b);
            lobe.across0 = pow(sin(0.5 * lobe.y0), 2);
            lobe.across1 = pow(sin(0.5 * lobe.y1), 2);
            add_strip(&lobe, patch);
        }
    }
    return lobe.sum;
}
