/* SPDX-License-Identifier: MIT */
/*
 * The lobe over a pixel that is not small against it.
 *
 * In theta and phi, which are offsets from the peak here so that the
 * narrowest lobe keeps its digits, the integrand
 *     (a2 / t)^2 (1 - 2q) sin(theta),  t = q + a2 (1 - q),
 *     q = sin^2(dtheta / 2) + sin(theta) sin(theta_N) sin^2(dphi / 2)
 * is analytic but for the horizon, and its nearest singularities are about
 * 2 sqrt(t) away. A cell takes 4 x 4 Gauss points; it is halved, along its
 * longer side or along both, until halving changes nothing. A cell that holds
 * the peak is first cut there: from a corner at 0 halving is exact in floating
 * point however deep it goes.
 */
#include <stdbool.h>

#include "bake/reference_sums.h"

enum {
    GAUSS = 4,
    MAX_DEPTH = 1000
};

static const double relative = 1e-8;
/* Of the whole, for cells that the horizon cuts. */
static const double absolute = 1e-10;

static const double node[GAUSS] = {-0.861136311594052575, -0.339981043584856265,
                                   0.339981043584856265, 0.861136311594052575};
static const double mass[GAUSS] = {0.347854845137453857, 0.652145154862546143,
                                   0.652145154862546143, 0.347854845137453857};

struct lobe {
    const ibl_aim *aim;
    double a2;
    double enough; /* an error too small to matter */
};

static double gauss(const struct lobe *lobe, const ibl_patch *c)
{
    const double mx = 0.5 * (c->x0 + c->x1), hx = 0.5 * (c->x1 - c->x0);
    const double my = 0.5 * (c->y0 + c->y1), hy = 0.5 * (c->y1 - c->y0);
    double across[GAUSS], sum = 0;

    for (int k = 0; k < GAUSS; k++) {
        const double s = sin(0.5 * (my + hy * node[k]));
        across[k] = s * s;
    }
    for (int i = 0; i < GAUSS; i++) {
        const double x = mx + hx * node[i], s = sin(0.5 * x);
        const double sin_theta = sin(lobe->aim->theta + x);
        const double scale = sin_theta * lobe->aim->sin_theta;
        double line = 0;
        for (int k = 0; k < GAUSS; k++) {
            const double q = s * s + scale * across[k];
            const double g = lobe->a2 / (q + lobe->a2 * (1 - q));
            line += q < 0.5 ? mass[k] * (1 - 2 * q) * g * g : 0;
        }
        sum += mass[i] * sin_theta * line;
    }
    return sum * hx * hy;
}

/* Cuts a cell; returns the number of parts. */
static int cut(const struct lobe *lobe, const ibl_patch *c, ibl_patch parts[4])
{
    const double x = 0.5 * (c->x0 + c->x1), y = 0.5 * (c->y0 + c->y1);
    const double top = lobe->aim->theta + c->x0;
    const double bottom = lobe->aim->theta + c->x1;
    const double equator = 0.5 * REFERENCE_PI;
    const double widest =
        top < equator && bottom > equator ? 1 : fmax(sin(top), sin(bottom));
    const double tall = c->x1 - c->x0, wide = widest * (c->y1 - c->y0);

    if (tall > 2 * wide) {
        parts[0] = (ibl_patch){c->x0, x, c->y0, c->y1};
        parts[1] = (ibl_patch){x, c->x1, c->y0, c->y1};
        return 2;
    }
    if (wide > 2 * tall) {
        parts[0] = (ibl_patch){c->x0, c->x1, c->y0, y};
        parts[1] = (ibl_patch){c->x0, c->x1, y, c->y1};
        return 2;
    }
    parts[0] = (ibl_patch){c->x0, x, c->y0, y};
    parts[1] = (ibl_patch){c->x0, x, y, c->y1};
    parts[2] = (ibl_patch){x, c->x1, c->y0, y};
    parts[3] = (ibl_patch){x, c->x1, y, c->y1};
    return 4;
}

static double refine(const struct lobe *lobe, const ibl_patch *cell,
                     double whole, int depth)
{
    ibl_patch parts[4];
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

/* Where the ends of the parts of [from, to], cut at 0, are. */
static int cut_at_zero(double from, double to, double ends[3])
{
    int n = 0;

    ends[n++] = from;
    if (from < 0 && to > 0)
        ends[n++] = 0;
    ends[n] = to;
    return n;
}

double ibl_reference_patch(const ibl_aim *aim, double a2,
                           const ibl_patch *patch)
{
    struct lobe lobe = {aim, a2, 0};
    double x[3], y[3], of[4], whole = 0, sum = 0;
    ibl_patch parts[4];
    const int nx = cut_at_zero(patch->x0, patch->x1, x);
    const int ny = cut_at_zero(patch->y0, patch->y1, y);

    for (int k = 0; k < nx * ny; k++) {
        const int i = k / ny, j = k % ny;
        parts[k] = (ibl_patch){x[i], x[i + 1], y[j], y[j + 1]};
        of[k] = gauss(&lobe, &parts[k]);
        whole += of[k];
    }
    /* A point near the peak makes too much of it; but the integral over the
     * sphere is at most 4 pi a2, as that of D N.L is at most 4. */
    lobe.enough = absolute * fmin(whole, 4 * REFERENCE_PI * a2);
    for (int k = 0; k < nx * ny; k++)
        sum += refine(&lobe, &parts[k], of[k], MAX_DEPTH);
    return sum;
}
