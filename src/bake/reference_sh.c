/* SPDX-License-Identifier: MIT */
/*
 * Spherical harmonics of the source, pixel by pixel, and its mean.
 *
 * A pixel is a patch. The number of its Gauss points in theta and phi keeps the
 * error below 1e-10 of it. With p its larger edge and x = (degree + 1) p, n
 * points miss at most x^2n (n!)^4 / ((2n + 1) (2n)!^3) of a wave's amplitude:
 * two are enough up to x = 0.025, three to 0.24, four to 0.8, and six to 3. A
 * larger pixel is divided.
 *
 * With the polar axis +Z, sin^m(t) cos(m phi) and sin^m(t) sin(m phi) are the
 * parts of (x + iy)^m, and Q_l = P_lm / sin^m(t) without Condon-Shortley phase
 * follows from Q_m = (2m - 1)!! by
 *     (l - m) Q_l = (2l - 1) z Q_l-1 - (l + m - 1) Q_l-2.
 * The norm comes last; at degree 64 the largest Q is below 1e120.
 */
#include "bake/reference_sums.h"
#include "core/alloc.h"
#include "core/context.h"

enum {
    MAX_DEGREE = IBL_MAX_SH_DEGREE,
    PARTS = 6 /* R, G, B of the cosine terms, then of the sine terms */
};

static const double pi = REFERENCE_PI;

/* ---- coefficients ----------------------------------------------------- */

struct harmonics {
    const ibl_reference *ref;
    int degree;
    int points;                /* in a pixel along an axis */
    double *place, *mass;      /* of each point: 0..1 in the pixel; sum 1 */
    double *cos_phi, *sin_phi; /* of a row's points, in the world */
    ibl_exact *sums;           /* offset(degree, degree + 1) sums */
};

/* Index of order m in sums. It has PARTS sums for each degree m..degree. */
static size_t offset(int degree, int m)
{
    return PARTS * ((size_t)m * (size_t)(2 * degree + 3 - m) / 2);
}

/* (x + iy)^m, by squaring. */
static void power(int m, double x, double y, double *re, double *im)
{
    *re = 1, *im = 0;
    for (; m; m >>= 1) {
        const double next = (x - y) * (x + y), r = *re;
        if (m & 1) {
            *re = r * x - *im * y;
            *im = r * y + *im * x;
        }
        y *= 2 * x;
        x = next;
    }
}

/* Adds a point to order m: direction, and colour times solid angle. */
static void add_point(int m, int degree, const double d[3],
                      const double flux[3], double *sums)
{
    double q = 1, before = 0, part[PARTS], re, im;

    power(m, d[0], d[1], &re, &im);
    for (int c = 0; c < 3; c++) {
        part[c] = flux[c] * re;
        part[3 + c] = flux[c] * im;
    }
    for (int k = 2; k <= m; k++)
        q *= 2 * k - 1;
    for (int l = m; l <= degree; l++, sums += PARTS) {
        for (int c = 0; c < PARTS; c++)
            sums[c] += q * part[c];
        const double next =
            ((2 * l + 1) * d[2] * q - (l + m) * before) / (l + 1 - m);
        before = q;
        q = next;
    }
}

/* Adds the points of a row at one theta. */
static void add_line(const struct harmonics *h, int m, int row, int line,
                     ibl_exact *sums)
{
    const ibl_image *env = h->ref->env;
    const double tall = pi / env->height, wide = 2 * pi / env->width;
    const double theta = tall * (row + h->place[line]), s = sin(theta);
    const float *p = env->data + 3 * (size_t)row * (size_t)env->width;
    double plain[PARTS * (MAX_DEGREE + 1)] = {0};

    for (int i = 0; i < env->width * h->points; i++) {
        const float *rgb = p + 3 * (i / h->points);
        const double angle =
            s * tall * wide * h->mass[line] * h->mass[i % h->points];
        const double d[3] = {s * h->cos_phi[i], cos(theta), s * h->sin_phi[i]};
        const double flux[3] = {(double)rgb[0] * angle, (double)rgb[1] * angle,
                                (double)rgb[2] * angle};
        add_point(m, h->degree, d, flux, plain);
    }
    for (int k = 0; k < PARTS * (h->degree - m + 1); k++)
        ibl_exact_add(&sums[k], plain[k]);
}

static void order_job(void *arg, int m, int worker)
{
    const struct harmonics *h = arg;
    const int lines = h->ref->env->height * h->points;
    (void)worker;

    for (int k = 0; k < lines && !ibl_cancelled(h->ref->ctx); k++)
        add_line(h, m, k / h->points, k % h->points,
                 h->sums + offset(h->degree, m));
}

static double norm(int l, int m)
{
    double k = (2 * l + 1) / (4 * pi) * (m ? 2 : 1);

    for (int n = l - m + 1; n <= l + m; n++)
        k /= n;
    return sqrt(k);
}

static void write_coefficients(int degree, const ibl_exact *total,
                               double *coeffs)
{
    for (int m = 0; m <= degree; m++) {
        for (int l = m; l <= degree; l++) {
            const ibl_exact *s = total + offset(degree, m) + PARTS * (l - m);
            const double k = norm(l, m);
            double *plus = coeffs + 3 * (l * (l + 1) + m);
            double *minus = coeffs + 3 * (l * (l + 1) - m);
            for (int c = 0; c < 3; c++) {
                if (m)
                    minus[c] = k * ibl_exact_total(&s[3 + c]);
                plus[c] = k * ibl_exact_total(&s[c]);
            }
        }
    }
}

/* Fills place and mass: rule's points in each of `parts` parts of a pixel. */
static void fill_points(const struct harmonics *h, int parts,
                        const ibl_gauss *rule)
{
    const int each = h->points / parts;

    for (int k = 0; k < h->points; k++) {
        h->place[k] = (k / each + 0.5 + 0.5 * rule->node[k % each]) / parts;
        h->mass[k] = 0.5 * rule->mass[k % each] / parts;
    }
}

static ibl_status make_points(struct harmonics *h)
{
    const ibl_image *env = h->ref->env;
    const double waves =
        (h->degree + 1) * fmax(pi / env->height, 2 * pi / env->width);
    const int parts = (int)ceil(waves / 3);
    const int each = waves <= 0.025  ? 2
                     : waves <= 0.24 ? 3
                     : waves <= 0.8  ? 4
                                     : 6;

    h->points = parts * each;
    const size_t points = (size_t)h->points, row = points * (size_t)env->width;
    h->place = ibl_alloc_array(2 * (points + row), sizeof *h->place);
    h->sums =
        ibl_alloc_zeroed(offset(h->degree, h->degree + 1), sizeof *h->sums);
    if (!h->place || !h->sums)
        return ibl_no_memory(h->ref->ctx, "the reference's coefficients");
    h->mass = h->place + points;
    h->cos_phi = h->mass + points;
    h->sin_phi = h->cos_phi + row;
    fill_points(h, parts, ibl_reference_gauss(each));
    for (size_t i = 0; i < row; i++) {
        const double column = (double)(i / points) + h->place[i % points];
        const double phi = 2 * pi * (column / env->width - 0.5) - h->ref->yaw;
        h->cos_phi[i] = cos(phi);
        h->sin_phi[i] = sin(phi);
    }
    return IBL_OK;
}

ibl_status ibl_reference_sh(const ibl_reference *ref, int degree,
                            double *coeffs)
{
    ibl_status status = ibl_reference_check(ref, 1, ref, coeffs);
    if (status)
        return status;
    if (degree < 0 || degree > MAX_DEGREE)
        return ibl_fail(ref->ctx, IBL_ERR_ARGUMENT,
                        "degree %d of a reference: must be 0 to %d", degree,
                        MAX_DEGREE);
    struct harmonics h = {.ref = ref, .degree = degree};
    status = make_points(&h);
    if (!status)
        status = ibl_run(ref->ctx, NULL, degree + 1, order_job, &h);
    if (!status)
        write_coefficients(degree, h.sums, coeffs);
    ibl_free(h.place);
    ibl_free(h.sums);
    return status;
}

/* ---- mean ------------------------------------------------------------- */

ibl_status ibl_reference_mean(const ibl_reference *ref, double rgb[3])
{
    const ibl_status status = ibl_reference_check(ref, 1, ref, rgb);
    ibl_exact total[3] = {{0, 0}};

    if (status)
        return status;
    const int w = ref->env->width, h = ref->env->height;
    for (int j = 0; j < h; j++) {
        const float *p = ref->env->data + 3 * (size_t)j * (size_t)w;
        /* cos(top) - cos(bottom), as a product without cancellation. */
        const double angle =
            2 * pi / w * 2 * sin(pi * (j + 0.5) / h) * sin(0.5 * pi / h);
        double row[3] = {0};
        if (ibl_cancelled(ref->ctx))
            return IBL_ERR_CANCELLED;
        for (int i = 0; i < 3 * w; i += 3)
            for (int c = 0; c < 3; c++)
                row[c] += (double)p[i + c];
        for (int c = 0; c < 3; c++)
            ibl_exact_add(&total[c], row[c] * angle);
    }
    for (int c = 0; c < 3; c++)
        rgb[c] = ibl_exact_total(&total[c]) / (4 * pi);
    return IBL_OK;
}
