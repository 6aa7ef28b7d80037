/* SPDX-License-Identifier: MIT */
/*
 * For waves of power p at w radians per sample, weights c_k of samples at x_k
 * have at position g the mean square error
 *     sum over w of p |e^(i w g) - sum over k of c_k e^(i w x_k)|^2
 * It is least where A c = b - mu 1 with
 *     A_jk = sum p cos(w (x_j - x_k)), b_k = sum p cos(w (g - x_k)),
 * where mu makes the c_k sum to 1. White noise as large as a float's rounding
 * is added to A's diagonal: it limits weights that the waves do not determine.
 * The solutions at Chebyshev nodes of g become polynomials of g by Newton's
 * divided differences.
 */
#include "bake/spectral/interp_weights.h"
#include "bake/spectral/gauss.h"
#include "core/pi.h"

#include <math.h>
#include <string.h>

enum {
    WAVES = 32, /* that represent the spectrum */
    NODES = IBL_TAPS_DEGREE + 1
};
_Static_assert(NODES % 2 == 0, "no node in the middle");

static const double noise_power = 1e-14;

typedef struct waves {
    int count;
    double angle[WAVES]; /* radians per sample */
    double turn[WAVES];  /* 2 cos(angle) */
    double power[WAVES]; /* sum 1 */
} waves;

static double sample_place(int k)
{
    return k - IBL_TAPS_FIRST - 0.5;
}

/* Along a line a field of one degree has waves of all lengths above its own. */
static void make_waves(const double *spectrum, int degree, double circle,
                       waves *s)
{
    double sum = 0;
    s->count = degree < WAVES ? degree : WAVES;
    for (int i = 0; i < s->count; i++) {
        const int l = (int)((i + 1.0) * degree / s->count + 0.5);
        const double amplitude =
            spectrum ? spectrum[l] : pow(10, -5.0 * l / degree);
        s->angle[i] = 2 * IBL_PI * l / circle;
        s->turn[i] = 2 * cos(s->angle[i]);
        s->power[i] = amplitude * amplitude;
    }
    for (int i = s->count - 2; i >= 0; i--)
        s->power[i] += s->power[i + 1];
    for (int i = 0; i < s->count; i++)
        sum += s->power[i];
    for (int i = 0; i < s->count; i++)
        s->power[i] = sum > 0 ? s->power[i] / sum : 1.0 / s->count;
}

/* A = L L^T in place, in the lower triangle. */
static void factorise(double a[IBL_TAPS][IBL_TAPS])
{
    for (int i = 0; i < IBL_TAPS; i++) {
        for (int j = 0; j <= i; j++) {
            double x = a[i][j];
            for (int k = 0; k < j; k++)
                x -= a[i][k] * a[j][k];
            /* Rounding may leave less than the added noise. */
            a[i][j] = i == j ? sqrt(fmax(x, 0.1 * noise_power)) : x / a[j][j];
        }
    }
}

static void solve(double a[IBL_TAPS][IBL_TAPS], double x[IBL_TAPS])
{
    for (int i = 0; i < IBL_TAPS; i++) {
        for (int k = 0; k < i; k++)
            x[i] -= a[i][k] * x[k];
        x[i] /= a[i][i];
    }
    for (int i = IBL_TAPS - 1; i >= 0; i--) {
        for (int k = i + 1; k < IBL_TAPS; k++)
            x[i] -= a[k][i] * x[k];
        x[i] /= a[i][i];
    }
}

/* Adds p cos(w (g - x_k)) for every k, by cos(a + w) = 2 cos(w) cos(a)
 * - cos(a - w). */
static void add_wave(double p, double w, double turn, double g,
                     double b[IBL_TAPS])
{
    double last = p * cos(w * (sample_place(0) - g));
    double next = p * cos(w * (sample_place(1) - g));
    for (int k = 0; k < IBL_TAPS; k++) {
        const double after = turn * next - last;
        b[k] += last;
        last = next;
        next = after;
    }
}

/* A_jk is lag[|j - k|]. */
static void make_matrix(const waves *s, double lag[IBL_TAPS],
                        double a[IBL_TAPS][IBL_TAPS])
{
    memset(lag, 0, IBL_TAPS * sizeof *lag);
    for (int i = 0; i < s->count; i++)
        add_wave(s->power[i], s->angle[i], s->turn[i], sample_place(0), lag);
    lag[0] += noise_power;
    for (int i = 0; i < IBL_TAPS; i++)
        for (int j = 0; j < IBL_TAPS; j++)
            a[i][j] = lag[i > j ? i - j : j - i];
}

static double sum_of(const double x[IBL_TAPS])
{
    double sum = 0;
    for (int k = 0; k < IBL_TAPS; k++)
        sum += x[k];
    return sum;
}

/* Mean square error: 1 - 2 c b + c A c. */
static double error_of(const double lag[IBL_TAPS], const double b[IBL_TAPS],
                       const double c[IBL_TAPS])
{
    double sum = 1;
    for (int j = 0; j < IBL_TAPS; j++) {
        double x = -2 * b[j];
        for (int k = 0; k < IBL_TAPS; k++)
            x += lag[j > k ? j - k : k - j] * c[k];
        sum += c[j] * x;
    }
    return sum;
}

/* The weights c at g; returns their error. */
static double weights_at(const waves *s, const double lag[IBL_TAPS],
                         double a[IBL_TAPS][IBL_TAPS],
                         const double ones[IBL_TAPS], double g,
                         double c[IBL_TAPS])
{
    double b[IBL_TAPS] = {0};
    for (int i = 0; i < s->count; i++)
        add_wave(s->power[i], s->angle[i], s->turn[i], g, b);
    memcpy(c, b, sizeof b);
    solve(a, c);
    const double mu = (sum_of(c) - 1) / sum_of(ones);
    for (int k = 0; k < IBL_TAPS; k++)
        c[k] -= mu * ones[k];
    return error_of(lag, b, c);
}

double ibl_interp_weights_design(const double *spectrum, int degree,
                                 double circle, ibl_interp_weights *taps)
{
    double a[IBL_TAPS][IBL_TAPS], lag[IBL_TAPS], ones[IBL_TAPS], g[NODES];
    double c[NODES / 2][IBL_TAPS], error = 0, whole = 0;
    waves s;
    make_waves(spectrum, degree, circle, &s);
    make_matrix(&s, lag, a);
    factorise(a);
    for (int k = 0; k < IBL_TAPS; k++)
        ones[k] = 1;
    solve(a, ones);
    /* The others are their mirror images, and the weights are, too. */
    for (int i = 0; i < NODES / 2; i++) {
        /* The sine compensates for the denser nodes near the ends. */
        const double angle = IBL_PI * (i + 0.5) / NODES;
        g[i] = 0.5 * cos(angle);
        g[NODES - 1 - i] = -g[i];
        error += sin(angle) * weights_at(&s, lag, a, ones, g[i], c[i]);
        whole += sin(angle);
    }
    for (int k = 0; k < IBL_TAPS / 2; k++) {
        double f[NODES];
        for (int i = 0; i < NODES / 2; i++) {
            f[i] = c[i][k];
            f[NODES - 1 - i] = c[i][IBL_TAPS - 1 - k];
        }
        ibl_polynomial_through(NODES, g, f);
        for (int d = 0; d < NODES; d++) {
            taps->coef[d][k] = f[d];
            taps->coef[d][IBL_TAPS - 1 - k] = d % 2 ? -f[d] : f[d];
        }
    }
    return s.count ? sqrt(fmax(error / whole, 0)) : 0;
}
