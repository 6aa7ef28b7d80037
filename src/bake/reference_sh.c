/* SPDX-License-Identifier: MIT */
/*
 * Spherical harmonics of the source, pixel by pixel, and its mean.
 *
 * A pixel is a patch: Gauss' points in theta and phi, so many that they err by
 * less than 1e-10 of it. With x = (degree + 1) p, p its larger edge, n points
 * miss x^2n (n!)^4 / ((2n + 1) (2n)!^3) of a wave's amplitude at most: two are
 * enough up to x = 0.025, three to 0.24, four to 0.8, and six to 3; a larger
 * pixel is divided.
 *
 * With the polar axis +Z, sin^m(t) cos(m phi) and sin^m(t) sin(m phi) are the
 * parts of (x + iy)^m, and Q_l = P_lm / sin^m(t) without Condon-Shortley phase
 * follows from Q_m = (2m - 1)!! by
 *     (l - m) Q_l = (2l - 1) z Q_l-1 - (l + m - 1) Q_l-2.
 * Nothing of it is normalised before the end; at degree 64 the largest Q is
 * below 1e120.
 */
#include "bake/reference_sums.h"
#include "core/alloc.h"
#include "core/context.h"

enum {
    MAX_DEGREE = 64,
    BLOCK = 64, /* pixels at a time */
    LANES = 8,
    PARTS = 6 /* R, G, B of the cosine's, then of the sine's */
};

static const double pi = REFERENCE_PI;

/* ---- coefficients ----------------------------------------------------- */

struct harmonics {
    const ibl_reference *ref;
    int degree;
    int parts, points;         /* of a pixel along an axis, and of a part */
    double *cos_phi, *sin_phi; /* of the points, in the world: width of each
                                  in a pixel */
    ibl_exact *sums;           /* offset(degree + 1) */
};

/* Where order m starts; PARTS sums for each degree m..degree. */
static size_t offset(int degree, int m)
{
    return PARTS * ((size_t)m * (size_t)(2 * degree + 3 - m) / 2);
}

/* (x + iy)^m for a block, by squaring. */
static void power(int m, const double *x, double y, double *re, double *im)
{
    double bre[BLOCK], bim[BLOCK];

    for (int k = 0; k < BLOCK; k++) {
        bre[k] = x[k], bim[k] = y;
        re[k] = 1, im[k] = 0;
    }
    for (; m; m >>= 1) {
        for (int k = 0; k < BLOCK && m & 1; k++) {
            const double t = re[k] * bre[k] - im[k] * bim[k];
            im[k] = re[k] * bim[k] + im[k] * bre[k];
            re[k] = t;
        }
        for (int k = 0; k < BLOCK; k++) {
            const double t = (bre[k] - bim[k]) * (bre[k] + bim[k]);
            bim[k] = 2 * bre[k] * bim[k];
            bre[k] = t;
        }
    }
}

static double dot(const double *a, const double *b)
{
    double s[LANES] = {0};

    for (int k = 0; k < BLOCK; k += LANES) {
        for (int i = 0; i < LANES; i++)
            s[i] += a[k + i] * b[k + i];
    }
    return ((s[0] + s[4]) + (s[2] + s[6])) + ((s[1] + s[5]) + (s[3] + s[7]));
}

/* Adds a block of one order; f holds the colours times (x + iy)^m. */
static void add_block(int m, int degree, const double *z, double (*f)[BLOCK],
                      ibl_exact *sums)
{
    double q[BLOCK], before[BLOCK] = {0}, first = 1;

    for (int k = 2; k <= m; k++)
        first *= 2 * k - 1;
    for (int k = 0; k < BLOCK; k++)
        q[k] = first;
    for (int l = m; l <= degree; l++, sums += PARTS) {
        if (l > m) {
            const double a = (2.0 * l - 1) / (l - m);
            const double b = (l + m - 1.0) / (l - m);
            for (int k = 0; k < BLOCK; k++) {
                const double next = a * z[k] * q[k] - b * before[k];
                before[k] = q[k];
                q[k] = next;
            }
        }
        for (int c = 0; c < PARTS; c++)
            ibl_exact_add(&sums[c], dot(q, f[c]));
    }
}

/* Place in a pixel, 0..1, of one of its points along an axis; returns its
 * share of the pixel. */
static double point_at(const struct harmonics *h, int k, double *place)
{
    const ibl_gauss *rule = ibl_reference_gauss(h->points);
    const int part = k / h->points, n = k % h->points;

    *place = (part + 0.5 + 0.5 * rule->node[n]) / h->parts;
    return 0.5 * rule->mass[n] / h->parts;
}

/* A block of columns: their points k, of theta what up, across and the solid
 * angle say. */
static void add_points(const struct harmonics *h, int m, int k, int begin,
                       const double point[3], const float *p, ibl_exact *sums)
{
    const int w = h->ref->env->width, left = w - begin;
    const int n = left < BLOCK ? left : BLOCK;
    const size_t at = (size_t)k * (size_t)w + (size_t)begin;
    double x[BLOCK] = {0}, z[BLOCK] = {0}, re[BLOCK], im[BLOCK];
    double f[PARTS][BLOCK] = {{0}};

    for (int i = 0; i < n; i++) {
        x[i] = point[1] * h->cos_phi[at + (size_t)i];
        z[i] = point[1] * h->sin_phi[at + (size_t)i];
    }
    power(m, x, point[0], re, im);
    for (int i = 0; i < n; i++) {
        for (int c = 0; c < 3; c++) {
            const double flux = (double)p[3 * i + c] * point[2];
            f[c][i] = flux * re[i];
            f[3 + c][i] = flux * im[i];
        }
    }
    add_block(m, h->degree, z, f, sums);
}

static void add_row(const struct harmonics *h, int m, int row, ibl_exact *sums)
{
    const ibl_image *env = h->ref->env;
    const int count = h->parts * h->points;
    const double tall = pi / env->height, wide = 2 * pi / env->width;
    const float *p = env->data + 3 * (size_t)row * (size_t)env->width;

    for (int k = 0; k < count * count; k++) {
        double place;
        double mass = point_at(h, k / count, &place);
        const double theta = tall * (row + place), s = sin(theta);
        mass *= point_at(h, k % count, &place);
        const double point[3] = {cos(theta), s, s * tall * wide * mass};
        for (int i = 0; i < env->width; i += BLOCK)
            add_points(h, m, k % count, i, point, p + 3 * i, sums);
    }
}

static void order_job(void *arg, int m, int worker)
{
    const struct harmonics *h = arg;
    (void)worker;

    for (int j = 0; j < h->ref->env->height && !ibl_cancelled(h->ref->ctx); j++)
        add_row(h, m, j, h->sums + offset(h->degree, m));
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

static void set_points(struct harmonics *h)
{
    const ibl_image *env = h->ref->env;
    const double waves =
        (h->degree + 1) * fmax(pi / env->height, 2 * pi / env->width);

    h->parts = (int)ceil(waves / 3);
    h->points = waves <= 0.025 ? 2 : waves <= 0.24 ? 3 : waves <= 0.8 ? 4 : 6;
}

static void fill_phi(const struct harmonics *h)
{
    const int w = h->ref->env->width;

    for (int k = 0; k < h->parts * h->points; k++) {
        double place;
        point_at(h, k, &place);
        for (int i = 0; i < w; i++) {
            const double phi = 2 * pi * ((i + place) / w - 0.5) - h->ref->yaw;
            h->cos_phi[(size_t)k * (size_t)w + (size_t)i] = cos(phi);
            h->sin_phi[(size_t)k * (size_t)w + (size_t)i] = sin(phi);
        }
    }
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
    set_points(&h);
    const size_t columns =
        (size_t)(h.parts * h.points) * (size_t)ref->env->width;
    h.cos_phi = ibl_alloc_array(columns, sizeof(double));
    h.sin_phi = ibl_alloc_array(columns, sizeof(double));
    h.sums = ibl_alloc_zeroed(offset(degree, degree + 1), sizeof *h.sums);
    if (h.cos_phi && h.sin_phi && h.sums) {
        fill_phi(&h);
        status = ibl_run(ref->ctx, NULL, degree + 1, order_job, &h);
    } else {
        status = ibl_no_memory(ref->ctx, "the reference's coefficients");
    }
    if (!status)
        write_coefficients(degree, h.sums, coeffs);
    ibl_free(h.sums);
    ibl_free(h.cos_phi);
    ibl_free(h.sin_phi);
    return status;
}

/* ---- mean ------------------------------------------------------------- */

ibl_status ibl_reference_mean(const ibl_reference *ref, double rgb[3])
{
    const ibl_status status = ibl_reference_check(ref, 1, ref, rgb);
    ibl_exact total[3] = {{0, 0}};

    if (status)
        return status;
    for (int j = 0; j < ref->env->height; j++) {
        const int w = ref->env->width;
        const float *p = ref->env->data + 3 * (size_t)j * (size_t)w;
        double row[3] = {0};
        if (ibl_cancelled(ref->ctx))
            return IBL_ERR_CANCELLED;
        for (int i = 0; i < 3 * w; i += 3)
            for (int c = 0; c < 3; c++)
                row[c] += (double)p[i + c];
        for (int c = 0; c < 3; c++)
            ibl_exact_add(&total[c], row[c] * ref->row_angle[j]);
    }
    for (int c = 0; c < 3; c++)
        rgb[c] = ibl_exact_total(&total[c]) / (4 * pi);
    return IBL_OK;
}
