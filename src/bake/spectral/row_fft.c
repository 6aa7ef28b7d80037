/* SPDX-License-Identifier: MIT */
#include "bake/spectral/row_fft.h"

#include <assert.h>
#include <complex.h>
#include <math.h>
#include <stdbool.h>
#include <string.h>

#include "core/alloc.h"
#include "core/context.h"
#include "core/pi.h"
#include "kern/fft.h"
#include "kern/row_block.h"

enum {
    LANES = IBL_ROW_BLOCK_LANES,
    BLOCK = 64, /* pixels taken into lanes at a time before they are spread */
    MOST_PIXELS = 8, /* a sample */
    MIN_RING = 16,   /* samples: more than IBL_ROW_BLOCK_TAPS */
    NODES = 12       /* of the filter's transform */
};

static const double TAPS = IBL_ROW_BLOCK_TAPS;

struct ibl_row_fft {
    int width; /* pixels of a row */
    int orders;
    int ring;     /* samples of the real transforms, a power of two */
    bool spreads; /* else pixels are samples */
    ibl_row_block_spread spread;
    ibl_fft fft; /* of ring / 2 */
    ibl_fft_pair *pairs;
    ibl_fft_dsp fft_dsp;
    ibl_row_block_dsp block_dsp;
};

/* ---- spreading ---------------------------------------------------------- */

/*
 * The filter, in samples: g(x) = e^(beta (sqrt(1 - (2 x / taps)^2) - 1)) for
 * |x| <= taps / 2, "exponential of semicircle" (Barnett, Magland, af
 * Klinteberg 2019, A parallel nonuniform fast Fourier transform library
 * based on an "exponential of semicircle" kernel, section 2).
 */
typedef struct window {
    double beta;
    double weight[NODES], angle[NODES]; /* its transform: weight cos(f angle) */
} window;

/* The filter for orders below `orders` on a ring of n >= 4 (orders - 1)
 * samples: |g^(k + m / n)| / g^(m / n) summed over k != 0 is at most 5e-8
 * for all m < orders, where g^ is the Fourier transform of g: a sum over
 * midpoints in the angle a of x = taps / 2 sin a, where the integrand is smooth
 * but for e^-beta at the ends. */
static window window_of(int n, int orders)
{
    /* The first alias of the highest order begins at 1 - f. The factor balances
     * its leakage against that of g's edge everywhere. */
    const double f = (double)(orders - 1) / (double)n;
    window g = {.beta = 0.98 * IBL_PI * TAPS * (1 - f)};
    for (int i = 0; i < NODES; i++) {
        const double a = IBL_PI / 2 * (i + 0.5) / NODES;
        g.weight[i] =
            TAPS * IBL_PI / 2 / NODES * cos(a) * exp(g.beta * (cos(a) - 1));
        g.angle[i] = IBL_PI * TAPS * sin(a);
    }
    return g;
}

/* g(x), 0 outside. */
static double window_at(const window *g, double x)
{
    const double z = 2 * x / TAPS;
    const double square = 1 - z * z;
    return square < 0 ? 0 : exp(g->beta * (sqrt(square) - 1));
}

/* g^(f): the integral of g(x) cos(2 pi f x) dx, |f| <= 1/4; error 1e-10. */
static double window_transform(const window *g, double f)
{
    double sum = 0;
    for (int i = 0; i < NODES; i++)
        sum += g->weight[i] * cos(f * g->angle[i]);
    return sum;
}

static int common_divisor(int a, int b)
{
    while (b) {
        const int rest = a % b;
        a = b;
        b = rest;
    }
    return a;
}

/* The first sample not below x - taps / 2, x = (2 i + 1) n / 2 w. */
static int64_t first_sample(int64_t i, int64_t w, int64_t n)
{
    const int64_t above = (2 * i + 1) * n - IBL_ROW_BLOCK_TAPS * w;
    const int64_t floor_of =
        above >= 0 ? above / (2 * w) : -((-above + 2 * w - 1) / (2 * w));
    return floor_of + (floor_of * 2 * w < above);
}

/* The taps for rows of width pixels onto n samples. Pixel 0 adds to ring sample
 * *origin (may be negative) first, which is sample 0 of the spread. False if
 * there is no memory. */
static bool make_spread(ibl_row_block_spread *spread, int width, int n,
                        const window *g, int *origin)
{
    const int common = common_divisor(width, n);
    /* Short periods are repeated: each is a turn of a loop. */
    const int times = 1 + 63 / (width / common);
    const int period = width / common * times;
    *spread =
        (ibl_row_block_spread){.period = period, .step = n / common * times};
    spread->first = ibl_alloc_array((size_t)period, sizeof *spread->first);
    spread->taps = ibl_alloc_array((size_t)period * IBL_ROW_BLOCK_TAPS,
                                   sizeof *spread->taps);
    if (!spread->first || !spread->taps)
        return false;
    const int64_t zero = first_sample(0, width, n);
    for (int i = 0; i < period; i++) {
        const int64_t first = first_sample(i, width, n);
        const double x = (i + 0.5) * (double)n / (double)width;
        spread->first[i] = (int32_t)(first - zero);
        for (int t = 0; t < IBL_ROW_BLOCK_TAPS; t++)
            spread->taps[(size_t)i * IBL_ROW_BLOCK_TAPS + (size_t)t] =
                (float)window_at(g, (double)(first + t) - x);
    }
    *origin = (int)zero;
    return true;
}

/* ---- plans ------------------------------------------------------------ */

static bool power_of_two(int n)
{
    return !(n & (n - 1));
}

/* Samples onto which width pixels are spread: at least one for MOST_PIXELS
 * pixels, so that sums are not too long for floats. */
static int ring_of(int width, int orders)
{
    int n = MIN_RING;
    while (n < IBL_ROW_FFT_OVER * (orders - 1) || n < width / MOST_PIXELS)
        n *= 2;
    return n;
}

/* Whether rows of a power of two are better spread. From four pixels a sample
 * on it takes less time than a straight transform with AVX2 (as
 * much with SSE2), and a fourth of the scratch or less. */
static bool spreading_pays(int width, int ring)
{
    return ring <= width / 4;
}

static ibl_row_fft *new_plan(ibl_ctx *ctx, int width, int orders)
{
    ibl_row_fft *plan = ibl_alloc_zeroed(1, sizeof *plan);
    if (!plan)
        return NULL;
    plan->width = width;
    plan->orders = orders;
    ibl_fft_dsp_init(&plan->fft_dsp, ibl_ctx_isa(ctx));
    ibl_row_block_dsp_init(&plan->block_dsp, ibl_ctx_isa(ctx));
    return plan;
}

/* Room for `pairs` pairs and as many factors, and the transform of ring. */
static bool make_tables(ibl_row_fft *plan, int pairs, double **factor)
{
    *factor = ibl_alloc_array((size_t)pairs, 2 * sizeof **factor);
    plan->pairs = ibl_alloc_array((size_t)pairs, sizeof *plan->pairs);
    return *factor && plan->pairs && ibl_fft_init(&plan->fft, plan->ring / 2);
}

static void set_factor(double *factor, int m, double complex value)
{
    factor[2 * m] = creal(value);
    factor[2 * m + 1] = cimag(value);
}

/* (-1)^m */
static double sign_of(int m)
{
    return m & 1 ? -1 : 1;
}

/*
 * With x_i = (i + 1/2) n / width, phi_i = 2 pi x_i / n - pi. Straight: sample
 * i is at x_0 + i. Spread: sample j is at origin + j, and its transform has
 * the filter's as a factor.
 */
static void forward_factors(const ibl_row_fft *plan, double turn_rad,
                            const window *g, int origin, double *factor)
{
    const double n = plan->ring;
    const double first = plan->spreads ? (double)origin : 0.5 * n / plan->width;
    for (int m = 0; m < plan->orders; m++) {
        const double size = plan->spreads ? 1 / window_transform(g, m / n) : 1;
        /* Whole turns are removed before the product is rounded. */
        const double turns = fmod(m * first, n) / n;
        set_factor(factor, m,
                   size * sign_of(m) * cexp(-2 * IBL_PI * I * turns) *
                       cexp(I * fmod(m * turn_rad, 2 * IBL_PI)));
    }
}

ibl_status ibl_row_fft_create(ibl_ctx *ctx, int width, int orders,
                              double turn_rad, ibl_row_fft **out)
{
    window g = {0};
    double *factor = NULL;
    int origin = 0;
    *out = NULL;
    assert(width >= 1 && width <= IBL_MAX_EDGE && orders >= 1 &&
           orders <= IBL_SHT_MAX_DEGREE + 1);
    ibl_row_fft *plan = new_plan(ctx, width, orders);
    if (!plan)
        goto fail;
    plan->ring = ring_of(width, orders);
    plan->spreads =
        width < 4 || !power_of_two(width) || spreading_pays(width, plan->ring);
    if (plan->spreads) {
        g = window_of(plan->ring, orders);
        if (!make_spread(&plan->spread, width, plan->ring, &g, &origin))
            goto fail;
    } else {
        plan->ring = width;
    }
    if (!make_tables(plan, orders, &factor))
        goto fail;
    forward_factors(plan, turn_rad, &g, origin, factor);
    ibl_fft_real_pairs(plan->ring / 2, factor, orders, plan->pairs);
    ibl_free(factor);
    *out = plan;
    return IBL_OK;
fail:
    ibl_free(factor);
    ibl_row_fft_free(plan);
    return ibl_no_memory(ctx, "the transform along the rows");
}

ibl_status ibl_row_fft_create_inverse(ibl_ctx *ctx, int columns, int orders,
                                      ibl_row_fft **out)
{
    double *factor = NULL;
    *out = NULL;
    assert(columns >= 4 && columns <= IBL_MAX_EDGE && power_of_two(columns) &&
           orders >= 1 && orders <= columns / 2);
    ibl_row_fft *plan = new_plan(ctx, columns, orders);
    if (!plan)
        goto fail;
    plan->ring = columns;
    if (!make_tables(plan, columns / 2, &factor))
        goto fail;
    for (int m = 0; m < orders; m++)
        set_factor(factor, m, sign_of(m) * cexp(I * (IBL_PI * m / columns)));
    ibl_fft_real_pairs_inverse(columns / 2, factor, orders, plan->pairs);
    ibl_free(factor);
    *out = plan;
    return IBL_OK;
fail:
    ibl_free(factor);
    ibl_row_fft_free(plan);
    return ibl_no_memory(ctx, "the transform along the rings");
}

void ibl_row_fft_free(ibl_row_fft *plan)
{
    if (!plan)
        return;
    ibl_free(plan->spread.first);
    ibl_free(plan->spread.taps);
    ibl_fft_free(&plan->fft);
    ibl_free(plan->pairs);
    ibl_free(plan);
}

/* ---- batches ---------------------------------------------------------- */

/* Floats of one channel's ring, with room beyond its end for spreading. */
static size_t channel_floats(const ibl_row_fft *plan)
{
    const int beyond = plan->spreads ? MIN_RING : 0;
    return (size_t)(plan->ring + beyond) * LANES;
}

size_t ibl_row_fft_scratch(const ibl_row_fft *plan)
{
    const size_t block = !plan->spreads ? 0 : (size_t)BLOCK * LANES;
    return 3 * (channel_floats(plan) + block);
}

/* Zeroes samples without pixels, and adds those past the end to the start. */
static void close_ring(const ibl_row_fft *plan, float *samples)
{
    const size_t end = ((size_t)plan->ring + IBL_ROW_BLOCK_TAPS) * LANES;
    const size_t n = (size_t)plan->ring * LANES;
    const int64_t last = ibl_row_block_first(&plan->spread, plan->width - 1);
    const size_t done = (size_t)(last + IBL_ROW_BLOCK_TAPS) * LANES;
    if (done < end)
        memset(samples + done, 0, (end - done) * sizeof *samples);
    for (size_t k = n; k < end; k++)
        samples[k - n] += samples[k];
}

static void load_spread(const ibl_row_fft *plan, const float **rows,
                        float scale, float *ring)
{
    const size_t channel = channel_floats(plan);
    float *pixels = ring + 3 * channel;
    for (int start = 0; start < plan->width; start += BLOCK) {
        const int left = plan->width - start;
        const int count = left < BLOCK ? left : BLOCK;
        plan->block_dsp.load(rows, count, scale, pixels, BLOCK * LANES);
        for (size_t c = 0; c < 3; c++)
            plan->block_dsp.spread(&plan->spread, pixels + c * BLOCK * LANES,
                                   start, count, ring + c * channel);
        for (int r = 0; r < LANES; r++)
            rows[r] += 3 * (size_t)count;
    }
    for (size_t c = 0; c < 3; c++)
        close_ring(plan, ring + c * channel);
}

void ibl_row_fft_forward(const ibl_row_fft *plan, const ibl_row_fft_rows *rows,
                         float *scratch, ibl_row_spectra *out, int group)
{
    const size_t channel = channel_floats(plan);
    const int orders = ibl_row_spectra_orders(out, group);
    const float *row[LANES];
    assert(rows->count >= 1 && rows->count <= LANES && orders <= plan->orders);
    /* Lanes without a row repeat the last one. */
    for (int r = 0; r < LANES; r++) {
        const int from = r < rows->count ? r : rows->count - 1;
        row[r] = rows->rgb + (size_t)from * rows->stride;
    }
    if (plan->spreads)
        load_spread(plan, row, rows->scale, scratch);
    else
        plan->block_dsp.load(row, plan->width, rows->scale, scratch, channel);
    for (int c = 0; c < 3; c++) {
        const ibl_fft_spectrum to = {ibl_row_spectra_at(out, group, 0, 2 * c),
                                     6 * LANES, LANES};
        float *z = scratch + (size_t)c * channel;
        plan->fft_dsp.forward(&plan->fft, z);
        plan->fft_dsp.split(z, plan->pairs, orders, &to);
        /* A real row's mean is real, without rounding errors. */
        memset(to.data + to.part, 0, LANES * sizeof *to.data);
    }
}

void ibl_row_fft_inverse(const ibl_row_fft *plan, const ibl_ring_spectra *in,
                         int first_ring, int count, float *scratch,
                         float *const rgba[])
{
    const size_t channel = channel_floats(plan);
    float *row[LANES];
    assert(count >= 1 && count <= LANES);
    assert(first_ring % LANES == 0 && in->orders >= plan->orders);
    for (int r = 0; r < LANES; r++)
        row[r] = rgba[r < count ? r : 0];
    for (int c = 0; c < 3; c++) {
        const ibl_fft_spectrum from = {ibl_ring_spectra_at(in, 0, 2 * c) +
                                           first_ring,
                                       6 * in->stride, in->stride};
        float *z = scratch + (size_t)c * channel;
        plan->fft_dsp.merge(&from, plan->pairs, plan->fft.size, z);
        plan->fft_dsp.inverse(&plan->fft, z);
    }
    plan->block_dsp.store(scratch, channel, plan->width, row, count);
}
