/* SPDX-License-Identifier: MIT */
#include "bake/lookup_error.h"

#include <math.h>
#include <stdbool.h>

#include "core/pi.h"

enum {
    APART = IBL_LOOKUP_APART
};

/* ---- what is looked up ---------------------------------------------------
 */

/* A table's bilinear value, clamped to its edges. */
static void fetch(const ibl_lobe_table *t, int layer, double u, double v,
                  double q[4])
{
    const size_t n = (size_t)t->size;
    const double x = fmin(fmax(u * t->size - 0.5, 0), t->size - 1);
    const double y = fmin(fmax(v * t->size - 0.5, 0), t->size - 1);
    const size_t i = (size_t)x, j = (size_t)y;
    const size_t i1 = i + 1 < n ? i + 1 : i, j1 = j + 1 < n ? j + 1 : j;
    const float *rows = t->data + 4 * (size_t)layer * n * n;
    for (size_t c = 0; c < 4; c++) {
        const double top = rows[4 * (j * n + i) + c] * (1 - (x - (double)i)) +
                           rows[4 * (j * n + i1) + c] * (x - (double)i);
        const double low = rows[4 * (j1 * n + i) + c] * (1 - (x - (double)i)) +
                           rows[4 * (j1 * n + i1) + c] * (x - (double)i);
        q[c] = top + (y - (double)j) * (low - top);
    }
}

int ibl_lookup_direction(ibl_lobe_bands *b, double n_dot_v, double bend)
{
    const double sine = sqrt((1 - n_dot_v) * (1 + n_dot_v));
    b->angle[b->directions] =
        atan2((1 - bend) * sine, (1 - bend) * n_dot_v + bend);
    return b->directions++;
}

ibl_lookup_use ibl_lookup_by_table(const ibl_lobe_table *t,
                                   const ibl_lobe_kernels *k, int f, int taps,
                                   double n_dot_v, double r, ibl_lobe_bands *b)
{
    double q[4];
    fetch(t, (taps - 1) * t->layers / 2 + (t->layers > 2 ? f : 0), n_dot_v, r,
          q);
    const double most = ibl_lod_of_roughness(&k->layout, fmin(1.25 * r, 1));
    ibl_lookup_use l = {.taps = taps,
                        .lod = fmin(q[1] * (k->layout.levels - 1), most),
                        .weight = q[2]};
    for (int i = 0; i < taps; i++)
        l.at[i] = ibl_lookup_direction(
            b, n_dot_v, q[0] + (taps > 1 ? 2 * i - 1 : 0) * q[3]);
    return l;
}

void ibl_lookup_legendre(const double *angle, int count,
                         const ibl_lobe_bands *b, double p[][IBL_BANDS_MOST])
{
    double c[IBL_LOOKUP_ANGLES], here[IBL_LOOKUP_ANGLES];
    double before[IBL_LOOKUP_ANGLES] = {0};
    int l = 0;
    for (int k = 0; k < count; k++) {
        c[k] = cos(angle[k]);
        here[k] = 1;
    }
    for (int i = 0; i < b->count; i++) {
        for (; l < b->degree[i]; l++) {
            const double inverse = 1.0 / (l + 1);
            const double up = (2 * l + 1) * inverse, down = l * inverse;
            for (int k = 0; k < count; k++) {
                const double next = up * c[k] * here[k] - down * before[k];
                before[k] = here[k];
                here[k] = next;
            }
        }
        for (int k = 0; k < count; k++)
            p[k][i] = here[k];
    }
}

/* ---- texels ----------------------------------------------------------------
 */

/* Constant over each pixel is how a map is meant. Interpolation blurs that by
 * the square of a pixel once more; along rows, pixels have 2/3 of the square of
 * those at the equator. */
double ibl_lookup_pixels(int edge, int most, int degree)
{
    const double x = IBL_PI * degree / fmax(most, 1);
    return most > 0 && 2 * edge > most ? exp(-5 / 6.0 * x * x / 24) : 1;
}

static bool is_mirror(const ibl_lobe_kernels *k, int level)
{
    return level < k->layout.levels && k->layout.roughness[level] <= 0;
}

/* k_l of a level but for the blur of its texels. */
static double sharp_kernel(const ibl_lobe_kernels *k, int level, int degree)
{
    if (is_mirror(k, level))
        return ibl_lookup_pixels(k->layout.size >> level, k->most, degree);
    return degree <= IBL_LOBE_DEGREE
               ? k->sharp[(size_t)level * (IBL_LOBE_DEGREE + 1) +
                          (size_t)degree]
               : 0;
}

/* k_l of a level at any degree, 0 or more. */
static double kernel(const ibl_lobe_kernels *k, int level, int degree)
{
    if (is_mirror(k, level))
        return sharp_kernel(k, level, degree) *
               ibl_lobe_blur_at(&k->layout, level, degree);
    return degree <= IBL_LOBE_DEGREE ? ibl_lobe_of(k, level)[degree] : 0;
}

/* Radians of a wave of a degree in a texel of mean edge. */
static double wave(int edge, int degree)
{
    return sqrt(4 * IBL_PI / 6 * degree * (degree + 1)) / edge;
}

/*
 * x: radians of the wave in a texel. Between texels, at t and s of one, lookups
 * lack (t (1 - t) x^2 cos^2 + s (1 - s) x^2 sin^2) / 2 of a wave: the square of
 * that is 1.15 times the square of its mean, and 1.69 times for the texels of a
 * cube, the largest of which are 5.2 times the smallest. The mean square of
 * four texels' weighted sum is a product of 2/3 + cos(x cos) / 3 and the same
 * of sin, as a mean over directions. Texels of the environment are means.
 */
double ibl_lookup_scatter(int edge, bool mirror, int degree)
{
    const double x = wave(edge, degree), blur = exp(-x * x / 12);
    const double square = (4 + 4 * j0(x) + j0(sqrt(2) * x)) / 9;
    const double lacks = blur * (1 - blur);
    return (0.69 * lacks * lacks + fmax(square - blur * blur, 0)) *
           (mirror ? blur : 1);
}

/* Relative mean square error of texels by their format. The lookup's mean over
 * texels leaves four ninths of what is of each texel's own, and all that texels
 * of a block have in common. */
static double format_error(const ibl_lookup_set *set, double variation)
{
    return 4 / 9.0 * set->step * set->step +
           set->slope * set->slope * variation;
}

/* Sums of a level or of irradiance over the degrees. */
typedef struct light {
    double square;  /* of what it shows, without the mean */
    double between; /* of the differences of neighbouring texels */
    double scatter; /* what bilinear lookups add */
} light;

/* k: of sharp_kernel. */
static void add_light(double share, double k, int edge, bool mirror, int degree,
                      light *to)
{
    const double x = wave(edge, degree);
    const double one = share * k * k * (mirror ? exp(-x * x / 12) : 1);
    to->square += one;
    to->between += one * fmin(x * x / 2, 2);
    to->scatter += share * k * k * ibl_lookup_scatter(edge, mirror, degree);
}

static double texel_error(const ibl_lobe_kernels *k, const light *l,
                          const ibl_lookup_set *set)
{
    const double all = k->mean + l->square;
    return l->scatter + format_error(set, all > 0 ? l->between / all : 0) * all;
}

/* The errors of the texels of two levels, blended by t, and of irradiance,
 * with their weights in what is drawn. */
static double texels_error(const ibl_lobe_kernels *k, const ibl_lobe_bands *b,
                           int a, const double part[3],
                           const ibl_lookup_set *set)
{
    double sum = 0;
    for (int n = 0; n < 3; n++) {
        const int level = n < 2 ? a + n : k->layout.levels;
        int edge = n < 2 ? k->layout.size >> level : set->irradiance;
        light of = {0, 0, 0};
        if (part[n] <= 0 || (n == 2 && edge <= 0))
            continue;
        if (edge < 1)
            edge = 1;
        const bool mirror = is_mirror(k, level);
        for (int i = 0; i < b->count; i++)
            add_light(b->share[i], sharp_kernel(k, level, b->degree[i]), edge,
                      mirror, b->degree[i], &of);
        sum += part[n] * part[n] * texel_error(k, &of, set);
    }
    return sum;
}

/* Irradiance as baked over irradiance as it is. By solid angle, texels are 1.14
 * times as large as their mean. */
static double irradiance_kept(int edge, int degree)
{
    if (edge < 0)
        return 1;
    if (edge == 0)
        return degree <= 2;
    const double x = wave(edge, degree);
    return exp(-1.14 * x * x / 12);
}

/* ---- sums ------------------------------------------------------------------
 */

double ibl_lookup_error(const ibl_lobe_kernels *k, const ibl_lookup_view *v,
                        int f, const ibl_lookup_use *s,
                        const ibl_lookup_set *set)
{
    const ibl_lobe_bands *b = &v->bands;
    const int a = (int)fmin(s->lod, k->layout.levels - 2);
    const int first = s->at[0], last = s->at[s->taps - 1];
    const double t = s->lod - a, own = set->table * (1 - s->weight);
    const double even_share = set->table * s->weight + set->diffuse;
    double sum = k->mean * (set->table - 1) * (set->table - 1);
    for (int i = b->count - 1; i >= 0; i--) {
        const int l = b->degree[i];
        const double lobe =
            own * ((1 - t) * kernel(k, a, l) + t * kernel(k, a + 1, l));
        const double cosine = kernel(k, k->layout.levels, l);
        /* The surface's own diffuse light is taken from both. */
        const double even =
            cosine *
            (even_share * irradiance_kept(set->irradiance, l) - set->diffuse);
        const double apart = s->taps > 1 ? v->p[APART + f][i] : 1;
        const double towards = 0.5 * (v->p[first][i] + v->p[last][i]);
        const double seen =
            0.5 * (b->toward[f][first][i] + b->toward[f][last][i]);
        const double ss = lobe * lobe * 0.5 * (1 + apart) +
                          2 * lobe * even * towards + even * even;
        const double st = lobe * seen + even * b->toward[f][IBL_TO_N][i];
        const double n = (2 * l + 1) / (4 * IBL_PI);
        sum += b->share[i] * (ss + (b->power[f][i] - 2 * st) / n);
    }
    const double part[3] = {own * (1 - t), own * t, even_share};
    return fmax(sum, 0) + texels_error(k, b, a, part, set);
}

double ibl_lookup_power(const ibl_lobe_kernels *k, const ibl_lookup_view *v,
                        int f, double diffuse)
{
    const ibl_lobe_bands *b = &v->bands;
    double power = k->mean * (1 + diffuse) * (1 + diffuse);
    for (int i = b->count - 1; i >= 0; i--) {
        const int l = b->degree[i];
        const double cosine = kernel(k, k->layout.levels, l);
        const double n = (2 * l + 1) / (4 * IBL_PI);
        power +=
            b->share[i] * ((b->power[f][i] +
                            2 * diffuse * cosine * b->toward[f][IBL_TO_N][i]) /
                               n +
                           diffuse * diffuse * cosine * cosine);
    }
    return power;
}
