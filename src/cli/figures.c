/* SPDX-License-Identifier: MIT */
#include "cli/figures.h"

#include <float.h>
#include <ibl/reference.h>
#include <math.h>
#include <stdint.h>
#include <stdlib.h>

#include "common/signals.h"

const char *const ibl_figure_names[] = {"nrmse", "median", "p95", "bias"};

/* ---- figures --------------------------------------------------------------
 */

void ibl_see(ibl_seen *sample, const double judged[3], const double truth[3],
             const double mean[3])
{
    sample->error = ibl_relative_error(judged, truth, mean);
    sample->wrong = sample->truth = sample->light[0] = sample->light[1] = 0;
    for (int c = 0; c < 3; c++) {
        sample->wrong += (judged[c] - truth[c]) * (judged[c] - truth[c]);
        sample->truth += truth[c] * truth[c];
        sample->light[0] += truth[c];
        sample->light[1] += judged[c];
    }
}

static int by_error(const void *a, const void *b)
{
    const ibl_seen *x = a, *y = b;
    return (x->error > y->error) - (x->error < y->error);
}

/* The figures of samples, sorted by error, without a batch, for which the
 * others stand, too; IBL_BATCHES: of all. */
static void find_figures(const ibl_seen *samples, size_t count, int batch,
                         double value[IBL_FIGURES])
{
    static const double quantile[] = {0.5, 0.95};
    const double least = (double)FLT_MIN * (double)FLT_MIN;
    ibl_seen all = {0};
    double below = 0;

    for (int pass = 0; pass < 2; pass++)
        for (const ibl_seen *s = samples; s < samples + count; s++) {
            const double w = s->batch == batch ? 0
                             : s->batch < 0 || batch == IBL_BATCHES
                                 ? s->weight
                                 : s->weight * IBL_BATCHES / (IBL_BATCHES - 1);
            for (int k = 0; k < 2 && pass; k++)
                if (below < quantile[k] * all.weight)
                    value[IBL_FIGURE_MEDIAN + k] = s->error;
            below += pass * w;
            if (pass)
                continue;
            all.weight += w;
            all.wrong += w * s->wrong;
            all.truth += w * s->truth;
            for (int k = 0; k < 2; k++)
                all.light[k] += w * s->light[k];
        }
    value[IBL_FIGURE_NRMSE] = sqrt(all.wrong / fmax(all.truth, least));
    value[IBL_FIGURE_BIAS] =
        all.light[0] > 0 ? all.light[1] / all.light[0] - 1 : 0;
}

double ibl_jackknife(const double without[IBL_BATCHES])
{
    double mean = 0, square = 0;

    for (int b = 0; b < IBL_BATCHES; b++)
        mean += without[b] / IBL_BATCHES;
    for (int b = 0; b < IBL_BATCHES; b++)
        square += (without[b] - mean) * (without[b] - mean);
    return sqrt(square * (IBL_BATCHES - 1) / IBL_BATCHES);
}

static void find_errors(ibl_measured *m)
{
    for (int f = 0; f < IBL_FIGURES; f++) {
        double without[IBL_BATCHES];
        for (int b = 0; b < IBL_BATCHES; b++)
            without[b] = m->without[b][f];
        m->error[f] = ibl_jackknife(without);
        if (m->error[f] < 1e-12 * fabs(m->value[f]))
            m->error[f] = 0; /* rounding */
    }
}

ibl_measured ibl_measured_of(ibl_seen *samples, size_t count)
{
    ibl_measured m = {.value = {0}};

    qsort(samples, count, sizeof *samples, by_error);
    find_figures(samples, count, IBL_BATCHES, m.value);
    for (int b = 0; b < IBL_BATCHES; b++)
        find_figures(samples, count, b, m.without[b]);
    find_errors(&m);
    return m;
}

ibl_measured ibl_measured_mean(const ibl_measured *rows, int count)
{
    ibl_measured mean = {.value = {0}};

    for (int k = 0; k < count; k++)
        for (int f = 0; f < IBL_FIGURES; f++) {
            mean.value[f] += rows[k].value[f] / count;
            for (int b = 0; b < IBL_BATCHES; b++)
                mean.without[b][f] += rows[k].without[b][f] / count;
        }
    find_errors(&mean);
    return mean;
}

/* ---- samples --------------------------------------------------------------
 */

void ibl_spread(int seed, size_t i, double u[IBL_DIMENSIONS])
{
    static const size_t prime[IBL_DIMENSIONS] = {2, 3, 5, 7, 11, 13};

    for (int k = 0; k < IBL_DIMENSIONS; k++) {
        /* Where it begins: splitmix64, Steele et al. 2014. */
        uint64_t x = (uint64_t)seed * 0xD1B54A32D192ED03u +
                     (uint64_t)(k + 1) * 0x9E3779B97F4A7C15u;
        x = (x ^ (x >> 30)) * 0xBF58476D1CE4E5B9u;
        x = (x ^ (x >> 27)) * 0x94D049BB133111EBu;
        x ^= x >> 31;
        u[k] = (double)(x >> 11) / 9007199254740992.0;
        /* Halton 1960. */
        double step = 1;
        for (size_t n = i; n; n /= prime[k])
            u[k] += (step /= (double)prime[k]) * (double)(n % prime[k]);
        u[k] -= floor(u[k]);
    }
}

double ibl_dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

void ibl_normalise(double v[3])
{
    const double length = sqrt(ibl_dot(v, v));

    for (int k = 0; k < 3; k++)
        v[k] /= length;
}

void ibl_around(const double *axis, double cosine, double azimuth,
                double out[3])
{
    static const double up[3] = {0, 1, 0};

    axis = axis ? axis : up;
    double x[3] = {fabs(axis[0]) < 0.5, fabs(axis[0]) >= 0.5, 0}, y[3];
    const double sine = sqrt(fmax(1 - cosine * cosine, 0));
    const double along = ibl_dot(x, axis);

    for (int k = 0; k < 3; k++)
        x[k] -= along * axis[k];
    ibl_normalise(x);
    for (int k = 0; k < 3; k++)
        y[k] = axis[(k + 1) % 3] * x[(k + 2) % 3] -
               axis[(k + 2) % 3] * x[(k + 1) % 3];
    for (int k = 0; k < 3; k++)
        out[k] = cosine * axis[k] +
                 sine * (cos(azimuth) * x[k] + sin(azimuth) * y[k]);
}

ibl_spot *ibl_spots_of(const ibl_image *env, double yaw_deg)
{
    const int w = env->width, h = env->height;
    const int columns = w < IBL_SPOT_COLUMNS ? w : IBL_SPOT_COLUMNS;
    const int rows = h < IBL_SPOT_COLUMNS / 2 ? h : IBL_SPOT_COLUMNS / 2;
    const double pixel = M_PI / h;
    ibl_spot *spots = ibl_need(calloc(IBL_SPOTS, sizeof *spots));
    double *turn = ibl_need(malloc(2 * (size_t)w * sizeof *turn));
    const float *p = env->data;
    double light = 0, squares = 0;

    for (int x = 0; x < w; x++) {
        const double u = (x + 0.5) / w - 0.5 - yaw_deg / 360;
        turn[2 * x] = cos(2 * M_PI * u);
        turn[2 * x + 1] = sin(2 * M_PI * u);
    }
    /* At first the direction is the sum of the pixels' times light, and the
     * share the sum of light. */
    for (long long y = 0; y < h; y++) {
        const double c = cos(pixel * ((double)y + 0.5)), r = sqrt(1 - c * c);
        ibl_spot *row = spots + y * rows / h * IBL_SPOT_COLUMNS;
        for (long long x = 0; x < w; x++, p += 3) {
            ibl_spot *s = &row[x * columns / w];
            const double here =
                r * ((double)p[0] + (double)p[1] + (double)p[2]);
            s->direction[0] += here * r * turn[2 * x];
            s->direction[1] += here * c;
            s->direction[2] += here * r * turn[2 * x + 1];
            s->share += here;
        }
    }
    free(turn);
    for (ibl_spot *s = spots; s < spots + IBL_SPOTS; s++) {
        if (!(s->share > 0))
            continue;
        const double length = sqrt(ibl_dot(s->direction, s->direction));
        s->spread = fmax(1 - length / s->share, 0) + pixel * pixel / 16 + 4e-6;
        ibl_normalise(s->direction);
        light += s->share;
        squares += s->share * s->share / (s->spread + 4e-4);
    }
    /* Half by light, half by its square over the room that it takes. */
    for (ibl_spot *s = spots; light > 0 && s < spots + IBL_SPOTS; s++)
        s->share *= 0.5 / light + 0.5 * s->share / (s->spread + 4e-4) / squares;
    return spots;
}

const ibl_spot *ibl_spot_at(const ibl_spot *spots, double u)
{
    const ibl_spot *last = NULL;

    for (const ibl_spot *s = spots; s < spots + IBL_SPOTS && u >= 0; s++)
        if (s->share > 0) {
            u -= s->share;
            last = s;
        }
    return last;
}

double ibl_spot_draw(double spread, double u)
{
    return 1 + spread - spread * pow(2 / spread + 1, u);
}

double ibl_spot_density(double spread, double cosine)
{
    return 1 /
           (2 * M_PI * (fmax(1 - cosine, 0) + spread) * log(2 / spread + 1));
}
