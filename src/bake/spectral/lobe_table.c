/* SPDX-License-Identifier: MIT */
#include "bake/spectral/lobe_table.h"

#include <math.h>

#include "bake/spectral/gauss.h"
#include "core/alloc.h"
#include "core/context.h"
#include "core/half.h"

enum {
    MIN_BITS = 3, /* log2 of pieces per octave */
    MAX_BITS = 7,
    MIN_OCTAVES = 2, /* from 2^-k to 1 */
    MAX_OCTAVES = 40,
    NODES = IBL_GAUSS_POINTS
};

/* A lobe from the peak, v = q, or the horizon, v = 2 - q; q = chord^2. */
typedef struct side {
    ibl_chord_fn *at;
    const void *arg;
    int horizon;
    int octaves; /* start is 2^-octaves */
} side;

static double value(const side *s, double v)
{
    const double q = s->horizon ? 2 - v : v;
    return s->at(sqrt(q > 0 ? q : 0), s->arg);
}

static double start_of(const side *s)
{
    return ldexp(1, -s->octaves);
}

/* About the largest value. */
static double peak_of(const side s[2])
{
    double peak = 0;
    for (int h = 0; h < 2; h++) {
        peak = fmax(peak, value(&s[h], 0));
        for (int k = 0; k <= 2 * MAX_OCTAVES; k++)
            peak = fmax(peak, value(&s[h], exp2(-0.5 * k)));
    }
    return peak;
}

/* Octaves go down to where the lobe is close to its value at v = 0. */
static int octaves_of(const side *s, double peak)
{
    const double end = value(s, 0);
    int k = MIN_OCTAVES;
    while (k < MAX_OCTAVES &&
           fabs(value(s, ldexp(1, -k)) - end) > fmax(0.25 * end, 1e-6 * peak))
        k++;
    return k;
}

static int pieces_of(const side *s, int bits)
{
    /* v + start runs to 1 + start. */
    return (s->octaves << bits) + (int)(start_of(s) * (1 << bits)) + 1;
}

/* The cubic of x = 0..1 through the lobe's values at the nodes of a piece. */
static void fit(const side *s, int bits, int piece, double c[4])
{
    const double octave = ldexp(1, (piece >> bits) - s->octaves);
    const double width = octave / (1 << bits);
    const double from =
        octave + width * (piece & ((1 << bits) - 1)) - start_of(s);
    for (int k = 0; k < NODES; k++)
        c[k] = value(s, from + ibl_gauss_node[k] * width);
    ibl_polynomial_through(NODES, ibl_gauss_node, c);
}

/* Whether a piece is as exact as ibl_radial_table promises. Below the first
 * whole octave a lobe that ends in a fractional power of v has fallen to a
 * millionth; the error may be a little larger there. */
static int near_enough(const side *s, int bits, int piece, double peak)
{
    const double octave = ldexp(1, (piece >> bits) - s->octaves);
    const double width = octave / (1 << bits);
    const double from =
        octave + width * (piece & ((1 << bits) - 1)) - start_of(s);
    const double slack = piece >> bits ? 0 : 3e-8 * peak;
    double c[4];
    fit(s, bits, piece, c);
    for (int i = 0; i <= 2; i++) {
        const double x = 0.5 * i, truth = value(s, from + x * width);
        const double fitted = ((c[3] * x + c[2]) * x + c[1]) * x + c[0];
        const double limit = 8e-7 * fmax(truth, 1e-8 * peak) + slack;
        if (fabs(fitted - truth) > limit)
            return 0;
    }
    return 1;
}

/* The fewest pieces that are exact enough, judged by the first and the middle
 * one of each octave. */
static int bits_of(const side *s, double peak)
{
    int bits = MIN_BITS;
    for (int k = 0; k < s->octaves && bits < MAX_BITS;) {
        if (near_enough(s, bits, k << bits, peak) &&
            near_enough(s, bits, (2 * k + 1) << (bits - 1), peak))
            k++;
        else
            bits++;
    }
    return bits;
}

static void fill(const side *s, int bits, float *coef)
{
    for (int piece = 0; piece < pieces_of(s, bits); piece++) {
        double c[4];
        fit(s, bits, piece, c);
        /* Denormals are slow, and negligible beside a peak. */
        for (int k = 0; k < 4; k++)
            coef[4 * piece + k] = fabs(c[k]) < 1e-36 ? 0 : (float)c[k];
    }
}

ibl_status ibl_radial_table(ibl_ctx *ctx, ibl_chord_fn *at, const void *arg,
                            ibl_radial *out)
{
    side s[2] = {{at, arg, 0, MAX_OCTAVES}, {at, arg, 1, MAX_OCTAVES}};
    const double peak = peak_of(s);
    int bits = MIN_BITS;
    *out = (ibl_radial){0};
    for (int h = 0; h < 2; h++) {
        s[h].octaves = octaves_of(&s[h], peak);
        const int wanted = bits_of(&s[h], peak);
        bits = wanted > bits ? wanted : bits;
    }
    const int pieces = pieces_of(&s[0], bits);
    out->coef = ibl_alloc_array((size_t)(pieces + pieces_of(&s[1], bits)),
                                4 * sizeof *out->coef);
    if (!out->coef)
        return ibl_no_memory(ctx, "a lobe's table");
    out->bits = bits;
    fill(&s[0], bits, out->coef);
    fill(&s[1], bits, out->coef + 4 * (size_t)pieces);
    for (int h = 0; h < 2; h++) {
        out->start[h] = (float)start_of(&s[h]);
        out->base[h] =
            (int)(ibl_bits_of(out->start[h]) >> (23 - bits)) - h * pieces;
    }
    return IBL_OK;
}

static double lobe_at(double chord, const void *shape)
{
    const double q = chord * chord / 4;
    return ibl_lobe_value(shape, q, 1 - 2 * q);
}

/* sin^2 h + alpha^2 cos^2 h = alpha^2 + (1 - alpha^2) q / 4, q = chord^2. */
ibl_status ibl_radial_make(ibl_ctx *ctx, const ibl_lobe_shape *shape,
                           ibl_radial *out)
{
    const double a2 = shape->alpha * shape->alpha;

    if (shape->lobe != IBL_LOBE_GGX)
        return ibl_radial_table(ctx, lobe_at, shape, out);
    *out = (ibl_radial){.peak = (float)ibl_lobe_value(shape, 0, 1),
                        .slope = (float)(0.25 * (1 - a2) / a2)};
    return IBL_OK;
}

void ibl_radial_free(ibl_radial *lobe)
{
    ibl_free(lobe->coef);
    *lobe = (ibl_radial){0};
}
