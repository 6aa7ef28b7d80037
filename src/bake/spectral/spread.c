/* SPDX-License-Identifier: MIT */
#include "bake/spectral/spread.h"

#include <math.h>

#include "core/alloc.h"
#include "core/pi.h"

#define TAPS ((double)IBL_ROW_BLOCK_TAPS)

/*
 * The quadrature: midpoints in the angle a of x = taps / 2 sin a, where the
 * integrand is smooth but for e^-beta at the ends.
 */
ibl_spread_window ibl_spread_window_of(int n, int orders)
{
    /* The first alias of the highest order begins at 1 - f. The factor trades
     * what leaks from there against what the edge of g leaks everywhere. */
    const double f = (double)(orders - 1) / (double)n;
    ibl_spread_window window = {.beta = 0.98 * IBL_PI * TAPS * (1 - f)};
    for (int i = 0; i < IBL_SPREAD_NODES; i++) {
        const double a = IBL_PI / 2 * (i + 0.5) / IBL_SPREAD_NODES;
        window.weight[i] = TAPS * IBL_PI / 2 / IBL_SPREAD_NODES * cos(a) *
                           exp(window.beta * (cos(a) - 1));
        window.angle[i] = IBL_PI * TAPS * sin(a);
    }
    return window;
}

double ibl_spread_value(const ibl_spread_window *window, double x)
{
    const double z = 2 * x / TAPS;
    const double square = 1 - z * z;
    return square < 0 ? 0 : exp(window->beta * (sqrt(square) - 1));
}

double ibl_spread_transform(const ibl_spread_window *window, double f)
{
    double sum = 0;
    for (int i = 0; i < IBL_SPREAD_NODES; i++)
        sum += window->weight[i] * cos(f * window->angle[i]);
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

bool ibl_spread_init(ibl_row_block_spread *spread, int width, int n,
                     const ibl_spread_window *window, int *origin)
{
    const int common = common_divisor(width, n);
    /* Short periods some times over: each is a turn of a loop. */
    const int times = 1 + 63 / (width / common);
    const int period = width / common * times;
    *spread =
        (ibl_row_block_spread){.period = period, .step = n / common * times};
    spread->first = ibl_alloc_array((size_t)period, sizeof *spread->first);
    spread->taps = ibl_alloc_array((size_t)period * IBL_ROW_BLOCK_TAPS,
                                   sizeof *spread->taps);
    if (!spread->first || !spread->taps) {
        ibl_spread_free(spread);
        return false;
    }
    const int64_t zero = first_sample(0, width, n);
    for (int i = 0; i < period; i++) {
        const int64_t first = first_sample(i, width, n);
        const double x = (i + 0.5) * (double)n / (double)width;
        spread->first[i] = (int32_t)(first - zero);
        for (int t = 0; t < IBL_ROW_BLOCK_TAPS; t++)
            spread->taps[(size_t)i * IBL_ROW_BLOCK_TAPS + (size_t)t] =
                (float)ibl_spread_value(window, (double)(first + t) - x);
    }
    *origin = (int)zero;
    return true;
}

void ibl_spread_free(ibl_row_block_spread *spread)
{
    ibl_free(spread->first);
    ibl_free(spread->taps);
    *spread = (ibl_row_block_spread){0};
}
