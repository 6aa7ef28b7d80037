/* SPDX-License-Identifier: MIT */
/*
 * The integral of a lobe over a patch, from the patch's edges.
 *
 * A weight w(q), q = sin^2(psi / 2), is the divergence of a field that points
 * away from the aim and has length M / sin(psi), M the integral of w sin(psi)
 * dpsi = 2 w dq from the aim. The integral over a patch is the flux through its
 * edges. With x and y the offsets from the aim in theta and phi, sin^2(psi) = 4
 * q (1 - q), and U the integral of w dq, an edge contributes
 *     parallel   U / (2 q (1 - q)) sin(theta)
 *                (sin(x) + 2 cos(theta) sin(theta_N) sin^2(y / 2)) dy
 *     meridian   U / (2 q (1 - q)) sin(theta_N) sin(y) dx
 * In patches at the aim or near it, U starts at the aim, where it is smooth.
 * Elsewhere U is minus the integral from q to the horizon, which keeps its
 * digits where weights are small. Both have closed forms, so that only
 * integrals along lines are left. The horizon only ends lines. Offsets keep the
 * digits of the narrowest lobe.
 *
 * A line is cut where q is least and where the horizon crosses it. The parts
 * are halved down to a fraction of the distance to the nearest singularity,
 * where Gauss points give all digits.
 */
#include <stdbool.h>

#include "bake/reference_sums.h"

static const double pi = REFERENCE_PI;

/* Weights below exp(nothing) = 1e-20 are left out. */
static const double nothing = -46;

/* ---- weights ---------------------------------------------------------- */

/* GGX's integral over q from q to the horizon: with c = 1 - 2 q and z = k c,
 * k = (1 - a2) / (1 + a2), it is
 *     2 (a2 / (1 + a2))^2 c^2 (z / (1 - z) + log(1 - z)) / z^2. */
static double ggx_beyond(double a2, double q)
{
    const double c = 1 - 2 * q, z = (1 - a2) / (1 + a2) * c;
    const double left = 2 * (q + a2 * (1 - q)) / (1 + a2);
    const double f = a2 / (1 + a2);
    double sum = 0;

    if (z > 0.01)
        return 2 * f * f * c * c * (z / left + log(left)) / (z * z);
    for (int n = 8; n >= 0; n--)
        sum = sum * z + (n + 1.0) / (n + 2);
    return 2 * f * f * c * c * sum;
}

/* Integral of the weight over q: from 0 to q, or from q to the horizon. */
static double ggx_within(const ibl_weight *w, double q)
{
    if (w->a2 > 0.5)
        return w->total - ggx_beyond(w->a2, q);
    const double b = 1 - w->a2, f = w->a2 / b;
    return w->a2 * (1 + 2 * f) * q / (q + w->a2 * (1 - q)) -
           2 * f * f * log1p(q / f);
}

static double within(const ibl_weight *w, double q)
{
    if (q >= 0.5)
        return w->total;
    switch (w->lobe) {
    case IBL_LOBE_GGX:
        break;
    case IBL_LOBE_CHARLIE:
        return 0.5 * w->scale * pow(2 * q, w->power + 1) *
               (1 / (w->power + 1) - 2 * q / (w->power + 2));
    case IBL_LOBE_PHONG:
        return -0.5 / (w->power + 1) * expm1((w->power + 1) * log1p(-2 * q));
    }
    return ggx_within(w, q);
}

static double beyond(const ibl_weight *w, double q)
{
    if (q >= 0.5)
        return 0;
    switch (w->lobe) {
    case IBL_LOBE_GGX:
        break;
    case IBL_LOBE_CHARLIE:
        return w->total - within(w, q);
    case IBL_LOBE_PHONG:
        return 0.5 / (w->power + 1) * exp((w->power + 1) * log1p(-2 * q));
    }
    return ggx_beyond(w->a2, q);
}

double ibl_reference_weight_at(const ibl_weight *w, double c)
{
    switch (w->lobe) {
    case IBL_LOBE_GGX:
        break;
    case IBL_LOBE_CHARLIE:
        return w->scale * pow(1 - c, w->power) * c;
    case IBL_LOBE_PHONG:
        return w->power > 1 ? pow(fmax(c, 0), w->power) : c;
    }
    const double g = 2 * w->a2 / ((1 + w->a2) - (1 - w->a2) * c);
    return c * g * g;
}

ibl_weight ibl_reference_weight(ibl_lobe lobe, double alpha)
{
    ibl_weight w = {.lobe = lobe,
                    .alpha = alpha,
                    .a2 = alpha * alpha,
                    .scale = 1,
                    .most = 0.5};

    switch (lobe) {
    case IBL_LOBE_GGX:
        w.total = ggx_beyond(w.a2, 0);
        break;
    case IBL_LOBE_CHARLIE:
        w.alpha = fmax(alpha, 1e-9);
        w.a2 = w.alpha * w.alpha;
        w.power = 0.5 / w.alpha;
        w.scale = (w.power + 1) * exp(1);
        w.least = 0.5 * exp(nothing / w.power);
        w.total = 0.5 * exp(1) / (w.power + 2);
        w.width = 4 * w.alpha;
        w.ring = true;
        break;
    case IBL_LOBE_PHONG:
        w.power = 1 + 0.5 * (1 / alpha - 1) * (1 / alpha + 1);
        w.most = -0.5 * expm1(nothing / w.power);
        w.total = 0.5 / (w.power + 1);
        w.width = 3 * alpha;
        w.fractional = w.power > 1;
        break;
    }
    return w;
}

/* ---- lines ------------------------------------------------------------ */

/* A parallel or a meridian; s runs along it, y or x. */
struct line {
    const ibl_weight *weight;
    bool inside;         /* U starts at the aim; else minus the rest */
    bool parallel;       /* q = polar + scale sin^2(s / 2) */
    double polar, scale; /* meridian: sin^2(s / 2) + scale sin(polar + s) */
    double lean, turn;   /* factor of the field: lean + turn sin^2(s / 2) */
    double pace;         /* length on the sphere per unit of s */
    double foot;         /* s where q is least */
};

/* An end of a part of a line. */
struct end {
    double s, q;
};

static struct line parallel_at(const ibl_aim *aim, double x)
{
    const double half = sin(0.5 * x), s = sin(aim->theta + x);

    return (struct line){.parallel = true,
                         .polar = half * half,
                         .scale = s * aim->sin_theta,
                         .lean = s * sin(x),
                         .turn = 2 * s * cos(aim->theta + x) * aim->sin_theta,
                         .pace = s};
}

static struct line meridian_at(const ibl_aim *aim, double y)
{
    const double half = sin(0.5 * y), s = aim->sin_theta;
    const double across = half * half * s;

    return (struct line){
        .polar = aim->theta,
        .scale = across,
        .lean = 2 * half * cos(0.5 * y) * s,
        .pace = 1,
        .foot = atan2(-2 * across * aim->cos_theta, 1 - 2 * across * s)};
}

static double q_at(const struct line *line, double s)
{
    const double half = sin(0.5 * s), square = half * half;

    return line->parallel ? line->polar + line->scale * square
                          : square + line->scale * sin(line->polar + s);
}

static double flux_at(const struct line *line, double s)
{
    const ibl_weight *w = line->weight;
    const double half = sin(0.5 * s), square = half * half;
    const double q = line->parallel
                         ? line->polar + line->scale * square
                         : square + line->scale * sin(line->polar + s);
    const double lean = line->lean + line->turn * square;

    if (!(q > 0)) /* U is w q near 0. */
        return w->ring ? 0 : 0.5 * lean;
    return (line->inside ? within(w, q) : -beyond(w, q)) / (2 * q * (1 - q)) *
           lean;
}

/* Approximate distance to the nearest singularity. */
static double reach_at(const struct line *line, double q)
{
    const ibl_weight *w = line->weight;
    const bool peak = line->inside && !w->ring;
    const double t = peak ? q + w->a2 * (1 - q) : q, rest = 1 - q;
    const double reach = 2 * sqrt(t < rest ? t : rest > 0 ? rest : 0);

    return w->width > 0 && q >= w->least && q <= w->most ? fmin(reach, w->width)
                                                         : reach;
}

/* Whether Gauss points on a whole part have all digits; reach: its distance
 * from the nearest singularity. A fractional power is not smooth on the horizon
 * either, but the values beside the horizon are negligible. */
static bool is_smooth(const struct line *line, struct end a, struct end b,
                      double reach)
{
    const double c = fmax(1 - 2 * fmax(a.q, b.q), 1e-5);
    const double length = (b.s - a.s) * line->pace;
    const double near = fmin(a.q, b.q), far = fmax(a.q, b.q);

    /* The weight hardly changes along a line at a constant distance. */
    return (length <= 0.5 * reach ||
            (length <= 0.5 &&
             far - near <= 0.2 * reach * sqrt(near * (1 - far)))) &&
           (!line->weight->fractional || fmin(a.q, b.q) >= 0.5 ||
            fabs(a.q - b.q) <= 0.25 * c);
}

static double gauss(const struct line *line, double begin, double end, int n)
{
    const ibl_gauss *rule = ibl_reference_gauss(n);
    const double middle = 0.5 * (begin + end), half = 0.5 * (end - begin);
    double sum = 0;

    for (int k = 0; k < n; k++)
        sum += rule->mass[k] * flux_at(line, middle + half * rule->node[k]);
    return sum * half;
}

/* Integrates a part on one side of the horizon in which q is monotone. */
static double integrate(const struct line *line, struct end a, struct end b)
{
    struct end middle = {0.5 * (a.s + b.s), 0};

    if (line->inside ? fmax(a.q, b.q) <= line->weight->least
                     : fmin(a.q, b.q) >= line->weight->most)
        return 0;
    const double reach0 = reach_at(line, a.q), reach1 = reach_at(line, b.q);
    const double reach = reach0 < reach1 ? reach0 : reach1;
    if (is_smooth(line, a, b, reach) || !(middle.s > a.s && middle.s < b.s)) {
        const double share = (b.s - a.s) * line->pace / reach;
        return gauss(line, a.s, b.s, share < 0.007 ? 2 : share < 0.03 ? 3 : 6);
    }
    middle.q = q_at(line, middle.s);
    return integrate(line, a, middle) + integrate(line, middle, b);
}

/* Integrates a part in which q is monotone. Cuts it at the horizon. */
static double cut_horizon(const struct line *line, struct end a, struct end b)
{
    if ((a.q < 0.5) == (b.q < 0.5))
        return integrate(line, a, b);
    const double away =
        line->parallel
            ? 2 * asin(sqrt(fmin((0.5 - line->polar) / line->scale, 1)))
            : 0.5 * pi;
    const double middle = 0.5 * (a.s + b.s);
    const double turn =
        2 * pi * round((middle - line->foot) / (2 * pi)) + line->foot;
    const double s = middle < turn ? turn - away : turn + away;
    const struct end cut = {fmin(fmax(s, a.s), b.s), 0.5};
    return integrate(line, a, cut) + integrate(line, cut, b);
}

/* Integrates a line. Cuts it where q is least and where it is largest. */
static double line_flux(const struct line *line, struct end a, struct end b)
{
    double sum = 0;

    if (line->lean == 0 && line->turn == 0)
        return 0;
    for (int k = -2; k <= 2; k++) {
        const double s = line->foot + k * pi;
        if (s > a.s && s < b.s) {
            const struct end cut = {s, q_at(line, s)};
            sum += cut_horizon(line, a, cut);
            a = cut;
        }
    }
    return sum + cut_horizon(line, a, b);
}

/* ---- patches ---------------------------------------------------------- */

/* A patch between two parallels and two meridians. */
struct patch {
    double x[2], y[2];
    double square[2];       /* sin^2(y / 2) */
    struct line line[2][2]; /* parallels; meridians */
    double right;           /* the flux through the second meridian */
};

static void set_meridian(const ibl_aim *aim, struct patch *p, int k, double y)
{
    const double half = sin(0.5 * y);

    p->y[k] = y;
    p->square[k] = half * half;
    p->line[1][k] = meridian_at(aim, y);
}

/* Whether U starts at the aim: near the peak, and inside Charlie's ring. */
static bool is_inside(const ibl_aim *aim, const ibl_weight *w,
                      const struct patch *p, double q[2][2])
{
    if (w->ring)
        return q[0][0] + q[0][1] + q[1][0] + q[1][1] < 1;
    const double turn = 2 * pi * round((p->y[0] + p->y[1]) / (4 * pi));
    const bool ahead = p->y[0] <= turn && p->y[1] >= turn;
    const double square = ahead ? 0 : fmin(p->square[0], p->square[1]);
    const bool level = p->x[0] <= 0 && p->x[1] >= 0;
    const struct line *nearer = &p->line[0][p->x[0] < 0];
    const double nearest = level ? aim->sin_theta * aim->sin_theta * square
                                 : nearer->polar + nearer->scale * square;

    return nearest < 0.25 * w->a2;
}

/* new_left: the left meridian is not the right one of the previous patch. */
static double patch_weight(const ibl_aim *aim, const ibl_weight *weight,
                           struct patch *p, bool new_left)
{
    double q[2][2], sum = 0;

    for (int k = 0; k < 4; k++) {
        const struct line *parallel = &p->line[0][k / 2];
        q[k / 2][k % 2] = parallel->polar + parallel->scale * p->square[k % 2];
    }
    const bool inside = is_inside(aim, weight, p, q);
    const double left = p->right;
    new_left = new_left || inside != p->line[1][0].inside;
    for (int k = 0; k < 4; k++) {
        struct line *line = &p->line[k / 2][k % 2];
        const bool along = k < 2, second = k % 2;
        const struct end a = {along ? p->y[0] : p->x[0],
                              along ? q[second][0] : q[0][second]};
        const struct end b = {along ? p->y[1] : p->x[1],
                              along ? q[second][1] : q[1][second]};
        line->weight = weight;
        line->inside = inside;
        const double flux = k == 2 && !new_left ? left : line_flux(line, a, b);
        sum += second ? flux : -flux;
        if (k == 3)
            p->right = flux;
    }
    return fmax(sum, 0);
}

/* Pixels are divided into parts of at most an eighth of a turn along either
 * axis, so that no part touches both the aim and its antipode. */
void ibl_reference_patches(const ibl_aim *aim, const ibl_weight *weight,
                           const ibl_pixels *run, double *out)
{
    const int rows = (3 + run->h) / run->h, columns = (7 + run->w) / run->w;
    struct patch p = {.right = 0};

    for (int i = run->begin; i < run->end; i++)
        out[i - run->begin] = 0;
    for (int k = 0; k < rows; k++) {
        for (int m = 0; m < 2; m++) {
            p.x[m] =
                pi * (run->j + (double)(k + m) / rows) / run->h - aim->theta;
            p.line[0][m] = parallel_at(aim, p.x[m]);
        }
        for (int n = 0; n <= (run->end - run->begin) * columns; n++) {
            const double at = run->begin + (double)n / columns;
            p.y[0] = p.y[1];
            p.square[0] = p.square[1];
            p.line[1][0] = p.line[1][1];
            set_meridian(aim, &p, 1, 2 * pi * (at / run->w - 0.5) - aim->phi);
            if (n)
                out[(n - 1) / columns] += patch_weight(aim, weight, &p, n == 1);
        }
    }
}
