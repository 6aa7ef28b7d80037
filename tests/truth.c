/* SPDX-License-Identifier: MIT */
/* The conventions of ibl/ibl.h, written again without the library's code. */
#include "truth.h"

#include <math.h>

void truth_latlong_direction(int w, int h, double i, double j, double dir[3])
{
    const double phi = 2 * M_PI * ((i + 0.5) / w - 0.5);
    const double theta = M_PI * (j + 0.5) / h;
    dir[0] = sin(theta) * cos(phi);
    dir[1] = cos(theta);
    dir[2] = sin(theta) * sin(phi);
}

/* cos(a) - cos(b) as a product, which cancels nothing at the poles. */
double truth_latlong_solid_angle(int w, int h, int j)
{
    return 4 * M_PI / w * sin(M_PI * (j + 0.5) / h) * sin(0.5 * M_PI / h);
}

void truth_latlong_pixel(int w, int h, const double dir[3], int *i, int *j)
{
    const double u = atan2(dir[2], dir[0]) / (2 * M_PI) + 0.5;
    *i = (int)floor(u * w) % w;
    *j = (int)fmin(floor(acos(dir[1]) / M_PI * h), h - 1);
}

void truth_cube_direction(int n, int face, double x, double y, double dir[3])
{
    const double u = 2 * (x + 0.5) / n - 1, v = 2 * (y + 0.5) / n - 1;
    const double rule[6][3] = {{1, -v, -u}, {-1, -v, u}, {u, 1, v},
                               {u, -1, -v}, {u, -v, 1},  {-u, -v, -1}};
    for (int k = 0; k < 3; k++)
        dir[k] = rule[face][k] / sqrt(1 + u * u + v * v);
}

/* With N = V = R and q = sin^2(psi / 2), N.L = 1 - 2 q, N.H^2 = 1 - q, and the
 * sine of the angle to H is sqrt(q). */
double truth_lobe_weight(ibl_lobe lobe, double alpha, double q)
{
    const double a2 = alpha * alpha, nl = 1 - 2 * q, t = q + a2 * (1 - q);

    if (nl <= 0)
        return 0;
    if (lobe == IBL_LOBE_PHONG)
        return pow(nl, 0.5 * (1 / a2 - 1) + 1);
    if (lobe == IBL_LOBE_CHARLIE)
        return pow(q, 0.5 / alpha) * nl;
    return nl / (t * t);
}

/* 4 pi times the integral of w over q from 0 to 1/2. Charlie: a beta integral.
 * GGX: over t = a^2 + (1 - a^2) q, 1 - 2 q = (1 + a^2 - 2 t) / (1 - a^2). */
double truth_lobe_integral(ibl_lobe lobe, double alpha)
{
    const double a2 = alpha * alpha, b = 0.5 / alpha;

    if (lobe == IBL_LOBE_PHONG)
        return 2 * M_PI / (0.5 * (1 / a2 - 1) + 2);
    if (lobe == IBL_LOBE_CHARLIE)
        return 4 * M_PI * pow(0.5, b + 1) / ((b + 1) * (b + 2));
    if (alpha == 1)
        return M_PI;
    return 4 * M_PI / ((1 - a2) * (1 - a2)) *
           ((1 + a2) / a2 - 2 - 2 * log((1 + a2) / (2 * a2)));
}

/* A lobe seen from R, and how small the patches on its horizon become. */
struct seen {
    ibl_lobe lobe;
    double alpha, theta, phi, least;
};

/* Both terms are >= 0, so nothing cancels in the narrowest lobe. */
static double q_at(const struct seen *r, double theta, double phi)
{
    const double down = sin(0.5 * (theta - r->theta));
    const double across = sin(0.5 * (phi - r->phi));
    return down * down + sin(theta) * sin(r->theta) * across * across;
}

/* The integral of the weight over a patch, by 3 x 3 points of Gauss where it is
 * a quarter as long as what the weight changes over, 2 sqrt(t) or about alpha;
 * else halved, and further where the horizon crosses it or Charlie bends. */
static double patch(const struct seen *r, double top, double down, double left,
                    double turn)
{
    static const double at[] = {0.1127016653792583, 0.5, 0.8872983346207417};
    const double middle = top + 0.5 * down;
    const double across = turn * fmin(1, sin(middle) + 0.5 * down);
    const double reach = 0.5 * hypot(down, across);
    const double psi =
        2 * asin(sqrt(fmin(1, q_at(r, middle, left + turn / 2))));
    const double length = r->lobe == IBL_LOBE_GGX
                              ? hypot(fmax(0, psi - reach), 2 * r->alpha)
                              : r->alpha;
    const int sharp = fabs(psi - 0.5 * M_PI) < 1.1 * reach ||
                      (r->lobe == IBL_LOBE_CHARLIE && psi < reach);
    double sum = 0;

    if (psi - 1.1 * reach > 0.5 * M_PI)
        return 0;
    if (fmax(down, across) > 0.25 * length || turn > 1 ||
        (sharp && reach > r->least)) {
        if (down > across && turn < 1)
            return patch(r, top, down / 2, left, turn) +
                   patch(r, middle, down / 2, left, turn);
        return patch(r, top, down, left, turn / 2) +
               patch(r, top, down, left + turn / 2, turn / 2);
    }
    for (int k = 0; k < 9; k++) {
        const double theta = top + down * at[k / 3];
        sum += (k / 3 == 1 ? 8 : 5) * (k % 3 == 1 ? 8 : 5) * sin(theta) *
               truth_lobe_weight(r->lobe, r->alpha,
                                 q_at(r, theta, left + turn * at[k % 3]));
    }
    return sum * down * turn / 324;
}

double truth_pixel_weight(int w, int h, int i, int j, const double dir[3],
                          ibl_lobe lobe, double roughness)
{
    const double down = M_PI / h, turn = 2 * M_PI / w;
    const struct seen r = {lobe, roughness * roughness,
                           atan2(hypot(dir[0], dir[2]), dir[1]),
                           atan2(dir[2], dir[0]), down / 64};
    return patch(&r, down * j, down, turn * (i - 0.5 * w), turn);
}

double truth_shadowing(ibl_geometry geometry, double alpha, double n_dot_l,
                       double n_dot_v)
{
    const double x[2] = {n_dot_l, n_dot_v}, a2 = alpha * alpha, k = alpha / 2;
    double root[2];
    if (geometry == IBL_GEOMETRY_SCHLICK_IBL)
        return x[0] / (x[0] * (1 - k) + k) * x[1] / (x[1] * (1 - k) + k);
    for (int i = 0; i < 2; i++) /* 1 + 2 Lambda */
        root[i] = sqrt(1 + a2 * (1 - x[i] * x[i]) / (x[i] * x[i]));
    return 2 / (root[0] + root[1]);
}

double truth_ggx(ibl_geometry geometry, double alpha, const double n[3],
                 const double v[3], const double l[3], double *fresnel)
{
    const double a2 = alpha * alpha;
    double nl = 0, nv = 0, nh = 0, vh = 0, length = 0;
    for (int k = 0; k < 3; k++) {
        const double h = v[k] + l[k];
        nl += n[k] * l[k];
        nv += n[k] * v[k];
        nh += n[k] * h;
        vh += v[k] * h;
        length += h * h;
    }
    nh /= sqrt(length);
    *fresnel = nl > 0 ? pow(1 - vh / sqrt(length), 5) : 0;
    const double t = nh * nh * (a2 - 1) + 1;
    return nl > 0 ? a2 / (M_PI * t * t) *
                        truth_shadowing(geometry, alpha, nl, nv) / (4 * nv)
                  : 0;
}

void truth_gauss(int n, long double *node, long double *weight)
{
    for (int i = 0; i < n; i++) {
        long double x = cosl(acosl(-1) * (i + 0.75L) / (n + 0.5L)), slope = 1;
        for (int step = 0; step < 12; step++) {
            long double p = 1, below = 0;
            for (int l = 0; l < n; l++) {
                const long double next =
                    ((2 * l + 1) * x * p - l * below) / (l + 1);
                below = p;
                p = next;
            }
            slope = n * (x * p - below) / (x * x - 1);
            x -= p / slope;
        }
        node[i] = x;
        weight[i] = 2 / ((1 - x * x) * slope * slope);
    }
}

/* P_lm / sin^m without Condon-Shortley phase follows in l from (2m - 1)!! by
 * (l - m) P_l = (2l - 1) z P_{l-1} - (l + m - 1) P_{l-2}. */
double truth_sh(int l, int m, const double dir[3])
{
    const int k = m < 0 ? -m : m;
    const double s = hypot(dir[0], dir[1]), phi = atan2(dir[1], dir[0]);
    double p = 1, before = 0, norm = (2 * l + 1) / (4 * M_PI);
    for (int n = 1; n <= k; n++)
        p *= (2 * n - 1) * s;
    for (int n = k + 1; n <= l; n++) {
        const double next =
            ((2 * n - 1) * dir[2] * p - (n + k - 1) * before) / (n - k);
        before = p;
        p = next;
    }
    for (int n = l - k + 1; n <= l + k; n++)
        norm /= n;
    return sqrt(m ? 2 * norm : norm) * p *
           (m < 0 ? sin(k * phi) : cos(k * phi));
}
