/* SPDX-License-Identifier: MIT */
/*
 * Nothing here uses the library's code: the cube rule, the latlong rule and the
 * lobes are written again from the conventions in ibl/ibl.h, so that a mistake
 * in one of the two shows.
 */
#include "truth.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "test.h"

/* ---- directions ------------------------------------------------------ */

void truth_latlong_direction(int w, int h, int i, int j, double dir[3])
{
    const double phi = 2.0 * M_PI * ((i + 0.5) / w - 0.5);
    const double theta = M_PI * (j + 0.5) / h;
    dir[0] = sin(theta) * cos(phi);
    dir[1] = cos(theta);
    dir[2] = sin(theta) * sin(phi);
}

double truth_latlong_solid_angle(int w, int h, int j)
{
    /* cos(a) - cos(b) as a product, which cancels nothing at the poles. */
    return 2.0 * M_PI / w * 2.0 * sin(M_PI * (j + 0.5) / h) *
           sin(0.5 * M_PI / h);
}

void truth_latlong_pixel(int w, int h, const double dir[3], int *i, int *j)
{
    const double u = atan2(dir[2], dir[0]) / (2.0 * M_PI) + 0.5;
    const double theta = atan2(hypot(dir[0], dir[2]), dir[1]);
    const int x = (int)floor(u * w), y = (int)floor(theta / M_PI * h);
    *i = x >= w ? x - w : x;
    *j = y >= h ? h - 1 : y;
}

static void cube_point(int face, double u, double v, double p[3])
{
    const double rule[6][3] = {{1, -v, -u}, {-1, -v, u}, {u, 1, v},
                               {u, -1, -v}, {u, -v, 1},  {-u, -v, -1}};
    for (int k = 0; k < 3; k++)
        p[k] = rule[face][k];
}

void truth_cube_direction(int n, int face, double x, double y, double dir[3])
{
    const double u = 2.0 * (x + 0.5) / n - 1.0, v = 2.0 * (y + 0.5) / n - 1.0;
    const double length = sqrt(1.0 + u * u + v * v);
    cube_point(face, u, v, dir);
    for (int k = 0; k < 3; k++)
        dir[k] /= length;
}

/*
 * With N = V = R and q = sin^2(psi / 2), N.L = 1 - 2 q, N.H^2 = 1 - q, and the
 * sine of the angle to H is sqrt(q).
 */
double truth_lobe_weight(ibl_lobe lobe, double alpha, double q)
{
    const double a2 = alpha * alpha, nl = 1.0 - 2.0 * q;

    if (nl <= 0.0)
        return 0.0;
    if (lobe == IBL_LOBE_PHONG)
        return pow(nl, 0.5 * (1.0 / a2 - 1.0) + 1.0);
    if (lobe == IBL_LOBE_CHARLIE)
        return pow(q, 0.5 / alpha) * nl;
    const double t = q + a2 * (1.0 - q);
    return nl / (t * t);
}

/*
 * 4 pi times the integral of w over q from 0 to 1/2. Phong: a power. Charlie:
 * a beta integral. GGX: over t = a^2 + (1 - a^2) q, 1 - 2 q =
 * (1 + a^2 - 2 t) / (1 - a^2).
 */
double truth_lobe_integral(ibl_lobe lobe, double alpha)
{
    const double a2 = alpha * alpha;

    if (lobe == IBL_LOBE_PHONG)
        return 2.0 * M_PI / (0.5 * (1.0 / a2 - 1.0) + 2.0);
    if (lobe == IBL_LOBE_CHARLIE) {
        const double b = 0.5 / alpha;
        return 4.0 * M_PI * pow(0.5, b + 1.0) / ((b + 1.0) * (b + 2.0));
    }
    if (alpha == 1.0)
        return M_PI;
    return 4.0 * M_PI / ((1.0 - a2) * (1.0 - a2)) *
           ((1.0 + a2) / a2 - 2.0 - 2.0 * log((1.0 + a2) / (2.0 * a2)));
}

/* A lobe seen from R. */
struct seen {
    ibl_lobe lobe;
    double alpha, theta, phi, sine;
    double cut; /* how far patches are halved on the horizon */
};

static struct seen seen_from(const double dir[3], ibl_lobe lobe,
                             double roughness, double cut)
{
    const double across = hypot(dir[0], dir[2]);
    return (struct seen){lobe,
                         roughness * roughness,
                         atan2(across, dir[1]),
                         atan2(dir[2], dir[0]),
                         across,
                         cut};
}

/* A range of theta or phi, at Gauss's three nodes the sine and sin^2 of half
 * the distance from R's. */
struct span {
    double from, to, sine[3], turn[3];
};

static struct span span_of(double from, double to, double centre)
{
    static const double node[3] = {-0.774596669241483377, 0.0,
                                   0.774596669241483377};
    struct span s = {.from = from, .to = to};

    for (int k = 0; k < 3; k++) {
        const double x = 0.5 * (from + to) + 0.5 * (to - from) * node[k];
        const double half = sin(0.5 * (x - centre));
        s.sine[k] = sin(x);
        s.turn[k] = half * half;
    }
    return s;
}

static struct span row_span(const struct seen *r, int h, int j)
{
    return span_of(M_PI * j / h, M_PI * (j + 1) / h, r->theta);
}

static struct span column_span(const struct seen *r, int w, int i)
{
    return span_of(2.0 * M_PI * ((double)i / w - 0.5),
                   2.0 * M_PI * ((i + 1.0) / w - 0.5), r->phi);
}

/* Both terms are >= 0, so nothing cancels in the narrowest lobe. */
static double q_at(const struct seen *r, const struct span *theta, int j,
                   const struct span *phi, int i)
{
    return theta->turn[j] + theta->sine[j] * r->sine * phi->turn[i];
}

static double gauss_patch(const struct seen *r, const struct span *theta,
                          const struct span *phi)
{
    static const double mass[3] = {5.0 / 18.0, 8.0 / 18.0, 5.0 / 18.0};
    double all = 0.0;

    for (int j = 0; j < 3; j++)
        for (int i = 0; i < 3; i++)
            all +=
                mass[i] * mass[j] * theta->sine[j] *
                truth_lobe_weight(r->lobe, r->alpha, q_at(r, theta, j, phi, i));
    return all * (theta->to - theta->from) * (phi->to - phi->from);
}

/* The same, of each parallel where it is above the horizon, which is within an
 * angle of R's meridian on either side. */
static double cut_rows(const struct seen *r, const struct span *theta,
                       const struct span *phi)
{
    static const double mass[3] = {5.0 / 18.0, 8.0 / 18.0, 5.0 / 18.0};
    const double middle = 0.5 * (phi->from + phi->to);
    const double turn = 2.0 * M_PI * round((middle - r->phi) / (2.0 * M_PI));
    double all = 0.0;

    for (int j = 0; j < 3; j++) {
        /* Its height is least + most cos(phi - phi of R). */
        const double most = theta->sine[j] * r->sine;
        const double least = 1.0 - 2.0 * theta->turn[j] - most;
        const double away = acos(fmin(fmax(-least / most, -1.0), 1.0));
        for (int k = -1; k <= 1; k++) {
            const double centre = r->phi + turn + 2.0 * M_PI * k;
            const double from = fmax(phi->from, centre - away);
            const double to = fmin(phi->to, centre + away);
            if (from >= to)
                continue;
            const struct span above = span_of(from, to, r->phi);
            for (int i = 0; i < 3; i++)
                all += mass[i] * mass[j] * theta->sine[j] * (to - from) *
                       truth_lobe_weight(r->lobe, r->alpha,
                                         q_at(r, theta, j, &above, i));
        }
    }
    return all * (theta->to - theta->from);
}

/* The same, its rows apart where the horizon leaves the patch. */
static double cut_patch(const struct seen *r, const struct span *theta,
                        const struct span *phi)
{
    const double height = cos(r->theta), edge[2] = {phi->from, phi->to};
    double at[4] = {theta->from, theta->from, theta->to, theta->to}, all = 0.0;

    for (int k = 0; k < 2; k++) {
        const double across = -r->sine * cos(edge[k] - r->phi);
        const double crossed =
            height > 0 ? atan2(height, across) : atan2(-height, -across);
        at[1 + k] = fmin(fmax(crossed, theta->from), theta->to);
    }
    if (at[1] > at[2]) {
        const double swap = at[1];
        at[1] = at[2];
        at[2] = swap;
    }
    for (int k = 0; k < 3; k++) {
        if (at[k] >= at[k + 1])
            continue;
        const struct span part = span_of(at[k], at[k + 1], r->theta);
        all += cut_rows(r, &part, phi);
    }
    return all;
}

/*
 * The integral of the weight over a patch. It changes over 2 sqrt(t) (GGX) or
 * about alpha (the others): patches are halved until they are a quarter as
 * long. The middle of Charlie bends: there they are halved further, and where
 * the horizon may touch a parallel, until what is left is below 1e-6 of the
 * whole.
 */
static double patch_weight(const struct seen *r, const struct span *theta,
                           const struct span *phi)
{
    const double down = theta->to - theta->from, turn = phi->to - phi->from;
    const double across = turn * fmin(1.0, theta->sine[1] + 0.5 * down);
    const double reach = 0.5 * hypot(down, across);
    const double q = fmin(1.0, q_at(r, theta, 1, phi, 1));
    const double psi = 2.0 * asin(sqrt(q));
    const double nearest = 0.5 * fmax(0.0, psi - reach);
    const double length =
        r->lobe == IBL_LOBE_GGX ? 2.0 * hypot(nearest, r->alpha) : r->alpha;
    const int cut = fabs(psi - 0.5 * M_PI) < 1.1 * reach;
    const int bent = r->lobe == IBL_LOBE_CHARLIE && psi < reach;
    struct span one, other;

    if (psi - 1.1 * reach > 0.5 * M_PI)
        return 0.0;
    if (fmax(down, across) < 0.25 * length && turn < 1.0 &&
        (!bent || reach < 2e-3) && (!cut || reach < r->cut))
        return cut ? cut_patch(r, theta, phi) : gauss_patch(r, theta, phi);
    if (down > across && turn < 1.0) {
        const double middle = 0.5 * (theta->from + theta->to);
        one = span_of(theta->from, middle, r->theta);
        other = span_of(middle, theta->to, r->theta);
        return patch_weight(r, &one, phi) + patch_weight(r, &other, phi);
    }
    const double middle = 0.5 * (phi->from + phi->to);
    one = span_of(phi->from, middle, r->phi);
    other = span_of(middle, phi->to, r->phi);
    return patch_weight(r, theta, &one) + patch_weight(r, theta, &other);
}

double truth_pixel_weight(int w, int h, int i, int j, const double dir[3],
                          ibl_lobe lobe, double roughness)
{
    const struct seen r = seen_from(dir, lobe, roughness, 0.01);
    const struct span theta = row_span(&r, h, j), phi = column_span(&r, w, i);
    return patch_weight(&r, &theta, &phi);
}

/* ---- spherical harmonics --------------------------------------------- */

/*
 * sin^m(t) cos(m phi) and sin^m(t) sin(m phi) are the parts of (x + iy)^m;
 * P_lm / sin^m(t) without Condon-Shortley phase follows in l from
 * (2m - 1)!! by (l - m) P_l = (2l - 1) z P_{l-1} - (l + m - 1) P_{l-2}.
 */
double truth_sh(int l, int m, const double dir[3])
{
    const int k = m < 0 ? -m : m;
    double re = 1.0, im = 0.0, p = 1.0, before = 0.0;
    double norm = (2 * l + 1) / (4.0 * M_PI);
    for (int n = 1; n <= k; n++) {
        const double x = re * dir[0] - im * dir[1];
        im = re * dir[1] + im * dir[0];
        re = x;
        p *= 2 * n - 1;
    }
    for (int n = k + 1; n <= l; n++) {
        const double next =
            ((2 * n - 1) * dir[2] * p - (n + k - 1) * before) / (n - k);
        before = p;
        p = next;
    }
    for (int n = l - k + 1; n <= l + k; n++)
        norm /= n;
    return sqrt(m == 0 ? norm : 2.0 * norm) * p * (m < 0 ? im : re);
}

/*
 * Adds every Y_lm, l <= degree, at a direction times weight. The recurrence in
 * l of functions that are normalised, which keeps them from growing.
 */
static void add_harmonics(const double d[3], double weight, int degree,
                          double *sums)
{
    const double phi = atan2(d[1], d[0]), s = hypot(d[0], d[1]);
    double start = weight * sqrt(1.0 / (4.0 * M_PI));
    for (int m = 0; m <= degree; m++) {
        if (m)
            start *= s * sqrt((2.0 * m + 1.0) / (2.0 * m));
        const double re = (m ? sqrt(2.0) : 1.0) * cos(m * phi);
        const double im = sqrt(2.0) * sin(m * phi), m2 = (double)m * m;
        double p = start, before = 0.0;
        for (int l = m; l <= degree; l++) {
            const double l2 = (double)l * l, n2 = (l + 1.0) * (l + 1.0);
            const double next =
                sqrt((4.0 * n2 - 1.0) / (n2 - m2)) *
                (d[2] * p - sqrt((l2 - m2) / (4.0 * l2 - 1.0)) * before);
            sums[l * (l + 1) + m] += re * p;
            if (m)
                sums[l * (l + 1) - m] += im * p;
            before = p;
            p = next;
        }
    }
}

/* A patch: theta from a to b, phi from c to d. */
struct patch {
    double a, b, c, d;
};

/* The integrals of every Y_lm over a patch, by cells so small that three
 * points each way leave 6e-8 of a wave of that degree. */
static void patch_harmonics(const struct patch *p, int degree, double yaw,
                            double *sums)
{
    static const double node[3] = {-0.774596669241483377, 0.0,
                                   0.774596669241483377};
    static const double mass[3] = {5.0 / 18.0, 8.0 / 18.0, 5.0 / 18.0};
    const double most = 0.7 / (degree + 1);
    const int rows = (int)ceil((p->b - p->a) / most);
    const int columns = (int)ceil((p->d - p->c) / most);
    const double down = (p->b - p->a) / rows, across = (p->d - p->c) / columns;

    for (int j = 0; j < 3 * rows; j++) {
        const double theta = p->a + down * (j / 3 + 0.5 + 0.5 * node[j % 3]);
        for (int i = 0; i < 3 * columns; i++) {
            const double phi =
                p->c + across * (i / 3 + 0.5 + 0.5 * node[i % 3]) - yaw;
            const double d[3] = {sin(theta) * cos(phi), cos(theta),
                                 sin(theta) * sin(phi)};
            add_harmonics(
                d, mass[i % 3] * mass[j % 3] * down * across * sin(theta),
                degree, sums);
        }
    }
}

void truth_harmonics(const ibl_image *env, int degree, double yaw_deg,
                     double *coeffs)
{
    const int w = env->width, h = env->height;
    const size_t count = (size_t)(degree + 1) * (size_t)(degree + 1);
    double *pixel = malloc(count * sizeof *pixel);

    if (!pixel)
        exit(1);
    for (size_t n = 0; n < 3 * count; n++)
        coeffs[n] = 0.0;
    for (int at = 0; at < w * h; at++) {
        const float *rgb = env->data + 3 * (size_t)at;
        const int i = at % w, j = at / w;
        const struct patch p = {M_PI * j / h, M_PI * (j + 1) / h,
                                2.0 * M_PI * ((double)i / w - 0.5),
                                2.0 * M_PI * ((i + 1.0) / w - 0.5)};
        if (rgb[0] == 0.0f && rgb[1] == 0.0f && rgb[2] == 0.0f)
            continue;
        for (size_t n = 0; n < count; n++)
            pixel[n] = 0.0;
        patch_harmonics(&p, degree, yaw_deg / 180.0 * M_PI, pixel);
        for (size_t n = 0; n < 3 * count; n++)
            coeffs[n] += pixel[n / 3] * (double)rgb[n % 3];
    }
    free(pixel);
}

/*
 * By the recurrence of truth_sh for functions divided by (2m - 1)!! s^m,
 * times sqrt((2l + 1) / 4 pi (l - m)! / (l + m)!) (2m - 1)!! s^m, whose
 * logarithm is kept; what grows is scaled.
 */
void truth_legendre(long double x, long double s, int m, int degree,
                    long double *p)
{
    long double q = 1.0L, last = 0.0L, shift = 0.0L, scale = m * log2l(s);

    /* (2m - 1)!!^2 / (2m)! = (2m - 1)!! / (2m)!! */
    for (int i = 1; i <= m; i++)
        scale += log2l((2 * i - 1) / (2.0L * i)) / 2;
    for (int l = m; l <= degree; l++) {
        if (l > m) {
            const long double next =
                ((2 * l - 1) * x * q - (l + m - 1) * last) / (l - m);
            last = q;
            q = next;
            scale += log2l((long double)(l - m) / (l + m)) / 2;
        }
        if (fabsl(q) > 0x1p1000L) {
            q *= 0x1p-1000L;
            last *= 0x1p-1000L;
            shift += 1000;
        }
        p[l - m] = q * exp2l(scale + shift) *
                   sqrtl((2 * l + 1) / (4 * 3.14159265358979323846264L));
    }
}
