/* SPDX-License-Identifier: MIT */
/*
 * The transform along the rows against the sums that define it, in double,
 * for every kind of width; what leaks is within the stated stop band.
 */
#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bake/spectral/row_fft.h"
#include "core/alloc.h"
#include "test.h"

#define PI 3.1415926535897932384626433832795

enum {
    ROWS = IBL_ROW_FFT_ROWS,
    BEFORE = 16, /* rings before those written */
    RINGS = BEFORE + ROWS + 7,
    GUARD = 32
};

static const float marker = 7654321;

static float *floats(size_t n)
{
    float *p = ibl_alloc_array(n, sizeof *p);
    if (!p)
        exit(1);
    for (size_t i = 0; i < n; i++)
        p[i] = marker;
    return p;
}

/* ---- forward ---------------------------------------------------------- */

typedef struct fixture {
    int width, orders, count;
    double turn;
    size_t stride;
    float *rgb;
    ibl_ring_spectra out;
} fixture;

static void fixture_init(ibl_ctx *ctx, fixture *x, int width, int orders,
                         int count)
{
    *x = (fixture){.width = width,
                   .orders = orders,
                   .count = count,
                   .turn = 0.1 + width % 7,
                   .stride = (size_t)width * 3 + 5};
    test_random r = {(uint64_t)(width * 31 + orders)};
    x->rgb = floats(x->stride * (size_t)count);
    for (int j = 0; j < count; j++)
        for (int i = 0; i < 3 * width; i++)
            x->rgb[(size_t)j * x->stride + (size_t)i] =
                (float)(2 * test_random_unit(&r) - 1);
    if (ibl_ring_spectra_alloc(ctx, RINGS, orders, &x->out))
        exit(1);
    const size_t n = (size_t)orders * 6 * x->out.stride;
    for (size_t i = 0; i < n; i++)
        x->out.data[i] = marker;
}

static void fixture_free(fixture *x)
{
    ibl_free(x->rgb);
    ibl_ring_spectra_free(&x->out);
}

static void forward(ibl_ctx *ctx, fixture *x)
{
    ibl_row_fft *plan;
    ibl_row_spectra group; /* at the equator, which all orders reach */
    if (ibl_row_fft_create(ctx, x->width, x->orders, x->turn, &plan) ||
        ibl_row_spectra_alloc(ctx, IBL_ROW_GROUP, x->orders - 1, &group))
        exit(1);
    const size_t n = ibl_row_fft_scratch(plan);
    float *scratch = floats(n + GUARD);
    const ibl_row_fft_rows rows = {x->rgb, x->stride, x->count, 1};
    ibl_row_fft_forward(plan, &rows, scratch, &group, 0);
    for (int i = 0; i < 6 * x->orders; i++)
        memcpy(ibl_ring_spectra_at(&x->out, 0, i) + BEFORE,
               ibl_row_spectra_at(&group, 0, 0, i),
               IBL_ROW_GROUP * sizeof(float));
    ibl_row_spectra_free(&group);
    for (size_t i = n; i < n + GUARD; i++)
        CHECK(scratch[i] == marker);
    ibl_free(scratch);
    ibl_row_fft_free(plan);
}

static float pixel(const fixture *x, int row, int i, int channel)
{
    return x->rgb[(size_t)row * x->stride + (size_t)(3 * i + channel)];
}

static void direct(const fixture *x, int m, int row, int channel, double f[2])
{
    f[0] = f[1] = 0;
    for (int i = 0; i < x->width; i++) {
        const double phi = 2 * PI * (i + 0.5) / x->width - PI;
        const double v = (double)pixel(x, row, i, channel);
        f[0] += v * cos(m * (phi - x->turn));
        f[1] -= v * sin(m * (phi - x->turn));
    }
}

/* Largest error over bins and rings, relative to the row's l2 and l1 norm. */
typedef struct worst {
    double l2, l1;
} worst;

static worst compare(const fixture *x, int step)
{
    worst w = {0, 0};
    for (int k = 0; k < x->orders * x->count * 3; k += step) {
        const int c = k % 3, row = k / 3 % x->count, m = k / 3 / x->count;
        double f[2], l1 = 0, l2 = 0;
        direct(x, m, row, c, f);
        for (int i = 0; i < x->width; i++) {
            const double v = (double)pixel(x, row, i, c);
            l1 += fabs(v);
            l2 += v * v;
        }
        const double error = hypot(
            ibl_ring_spectra_at(&x->out, m, 2 * c)[BEFORE + row] - f[0],
            ibl_ring_spectra_at(&x->out, m, 2 * c + 1)[BEFORE + row] - f[1]);
        w.l1 = fmax(w.l1, error / l1);
        w.l2 = fmax(w.l2, error / sqrt(l2));
    }
    return w;
}

/* F_0 is real; rings before and behind the batch stay as they are. */
static void check_exact(const fixture *x)
{
    for (int c = 0; c < 3; c++)
        for (int j = 0; j < x->count; j++)
            CHECK(ibl_ring_spectra_at(&x->out, 0, 2 * c + 1)[BEFORE + j] == 0);
    for (int m = 0; m < x->orders; m++)
        for (int part = 0; part < 6; part++) {
            const float *f = ibl_ring_spectra_at(&x->out, m, part);
            for (int j = 0; j < BEFORE; j++)
                CHECK(f[j] == marker);
            for (int j = BEFORE + ROWS; j < RINGS; j++)
                CHECK(f[j] == marker);
        }
}

/*
 * Noise is white: rounding of the values, of some 20 stages, relative to
 * the l2 norm, and up to 1 / 0.3 times as much where the filter's transform
 * is divided out; worst of many. Leakage relative to the l1 norm.
 */
static void check_width(ibl_ctx *ctx, int width, int orders, int count,
                        int step)
{
    fixture x;
    fixture_init(ctx, &x, width, orders, count);
    forward(ctx, &x);
    const worst w = compare(&x, step);
    CHECK_MSG(w.l1 <= IBL_ROW_FFT_STOP + 2 * FLT_EPSILON &&
                  w.l2 <= IBL_ROW_FFT_STOP * sqrt(width) + 12 * FLT_EPSILON,
              "%s, width %d, %d orders: error %.3g of the l1 norm, %.3g of "
              "the l2 norm",
              ibl_isa_name(ibl_ctx_isa(ctx)), width, orders, w.l1, w.l2);
    check_exact(&x);
    fixture_free(&x);
}

static void each_isa(void (*run)(ibl_ctx *ctx))
{
    for (ibl_isa isa = IBL_ISA_C; isa < IBL_ISA_COUNT;
         isa = test_next_isa(isa)) {
        ibl_ctx *ctx = test_ctx(1, isa);
        run(ctx);
    }
}

static void small(ibl_ctx *ctx)
{
    static const int orders[] = {1, 2, 3, 5, 17, 40, 65};
    for (int w = 1; w <= 40; w++)
        for (size_t k = 0; k < sizeof orders / sizeof orders[0]; k++)
            check_width(ctx, w, orders[k], 1 + (w + (int)k) % ROWS, 1 + w / 2);
}

TEST(every_small_width)
{
    each_isa(small);
}

static void large(ibl_ctx *ctx)
{
    static const struct {
        int width, orders;
    } cases[] = {
        {64, 33},    {127, 100},  {128, 257},  {200, 101},
        {256, 129},  {333, 129},  {1000, 257}, {1024, 257},
        {1024, 5},   {1600, 300}, {2048, 257}, {2047, 40},
        {4096, 257}, {4096, 513}, {4099, 65},  {8192, 129},
    };
    for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++)
        check_width(ctx, cases[k].width, cases[k].orders, 3 + (int)k % 14,
                    cases[k].orders * cases[k].width / 1200 + 1);
}

TEST(larger_widths)
{
    each_isa(large);
}

TEST(longest_rows)
{
    ibl_ctx *ctx = test_ctx(1, IBL_ISA_AUTO);
    check_width(ctx, 65536, 257, 2, 151);
    check_width(ctx, 65521, 257, 2, 151);
    check_width(ctx, 65536, 16385, 1, 4999);
    check_width(ctx, 65535, 16385, 1, 4999);
}

/* ---- leaks ------------------------------------------------------------ */

/* An impulse at every position of a row, sixteen at a time. */
static void impulses(ibl_ctx *ctx)
{
    static const int widths[] = {4096, 1001};
    const int rarer = TEST_SANITIZED ? 16 : 1;
    for (int k = 0; k < 2; k++) {
        fixture x;
        fixture_init(ctx, &x, widths[k], 65, ROWS);
        double worst_error = 0;
        for (int from = 0; from < x.width; from += rarer * (k ? 1 : 61)) {
            memset(x.rgb, 0, x.stride * ROWS * sizeof *x.rgb);
            for (int j = 0; j < ROWS; j++)
                x.rgb[(size_t)j * x.stride +
                      (size_t)(3 * ((from + j) % x.width) + j % 3)] = 1;
            forward(ctx, &x);
            for (int m = 0; m < x.orders; m += m % 8 ? 1 : 7)
                for (int j = 0; j < ROWS; j++) {
                    const int i = (from + j) % x.width, c = j % 3;
                    const double a =
                        m * (2 * PI * (i + 0.5) / x.width - PI - x.turn);
                    const float *re = ibl_ring_spectra_at(&x.out, m, 2 * c);
                    const float *im = ibl_ring_spectra_at(&x.out, m, 2 * c + 1);
                    worst_error =
                        fmax(worst_error, hypot(re[BEFORE + j] - cos(a),
                                                im[BEFORE + j] + sin(a)));
                }
            if (ibl_ctx_isa(ctx) == IBL_ISA_C)
                from += 97;
        }
        CHECK_MSG(worst_error <= IBL_ROW_FFT_STOP + 3 * FLT_EPSILON,
                  "width %d: error %.3g", x.width, worst_error);
        fixture_free(&x);
    }
}

TEST(an_impulse_anywhere)
{
    each_isa(impulses);
}

/* Cosines above the orders that are kept must not show in any of those. */
TEST(high_frequencies)
{
    enum {
        WIDTH = 4096,
        ORDERS = 257
    };
    ibl_ctx *ctx = test_ctx(1, IBL_ISA_AUTO);
    fixture x;
    fixture_init(ctx, &x, WIDTH, ORDERS, ROWS);
    double leak = 0;
    for (int k = ORDERS; k <= WIDTH / 2; k += 3 * ROWS * 7 + 1) {
        for (int j = 0; j < ROWS; j++)
            for (int i = 0; i < 3 * WIDTH; i++)
                x.rgb[(size_t)j * x.stride + (size_t)i] = (float)cos(
                    2 * PI * (i / 3 + 0.5) / WIDTH * (k + 7 * (3 * j + i % 3)));
        forward(ctx, &x);
        for (int j = 0; j < ROWS; j++)
            for (int c = 0; c < 3; c++)
                for (int m = 0; m < ORDERS; m++) {
                    const int order = k + 7 * (3 * j + c);
                    if (order > WIDTH - ORDERS)
                        continue; /* is one of the orders that are kept */
                    leak = fmax(
                        leak,
                        hypot(ibl_ring_spectra_at(&x.out, m, 2 * c)[BEFORE + j],
                              ibl_ring_spectra_at(&x.out, m,
                                                  2 * c + 1)[BEFORE + j]));
                }
    }
    /* The sum of |cos| over a row is 2 / pi of the width. */
    CHECK_MSG(leak <= IBL_ROW_FFT_STOP * WIDTH * 2 / PI, "leak %.3g of l1",
              leak / (WIDTH * 2 / PI));
    fixture_free(&x);
}

/* A row gives the same bytes in any lane, beside any others. */
static void alone(ibl_ctx *ctx)
{
    static const int widths[] = {256, 300};
    for (int k = 0; k < 2; k++) {
        fixture x, y;
        fixture_init(ctx, &x, widths[k], 65, ROWS);
        fixture_init(ctx, &y, widths[k], 65, 3);
        memcpy(y.rgb, x.rgb + 9 * x.stride, 3 * x.stride * sizeof *x.rgb);
        forward(ctx, &x);
        forward(ctx, &y);
        for (int m = 0; m < x.orders; m++)
            for (int part = 0; part < 6; part++)
                CHECK(!memcmp(ibl_ring_spectra_at(&x.out, m, part) + BEFORE + 9,
                              ibl_ring_spectra_at(&y.out, m, part) + BEFORE,
                              3 * sizeof(float)));
        fixture_free(&x);
        fixture_free(&y);
    }
}

TEST(rows_are_independent)
{
    each_isa(alone);
}

/* ---- inverse ---------------------------------------------------------- */

static void inverse(ibl_ctx *ctx, int columns, int orders, int count, int step)
{
    enum {
        BORDER = 12 /* floats on either side of a row */
    };
    test_random r = {(uint64_t)(columns + orders)};
    const size_t stride = (size_t)columns * 4 + 2 * BORDER;
    ibl_ring_spectra in;
    ibl_row_fft *plan;
    if (ibl_ring_spectra_alloc(ctx, RINGS, orders + 2, &in) ||
        ibl_row_fft_create_inverse(ctx, columns, orders, &plan))
        exit(1);
    for (size_t i = 0; i < (size_t)(orders + 2) * 6 * in.stride; i++)
        in.data[i] = (float)(2 * test_random_unit(&r) - 1);
    float *rgba = floats(stride * ROWS);
    float *scratch = floats(ibl_row_fft_scratch(plan));
    float *row[ROWS];
    for (int j = 0; j < count; j++)
        row[j] = rgba + (size_t)(count - 1 - j) * stride + BORDER;
    ibl_row_fft_inverse(plan, &in, BEFORE, count, scratch, row);

    double error = 0, truth = 0;
    for (int k = 0; k < columns * count * 3; k += step) {
        const int c = k % 3, j = k / 3 % count, i = k / 3 / count;
        const double phi = 2 * PI * (i + 0.5) / columns - PI;
        double f = 0;
        for (int m = 0; m < orders; m++) {
            const double re = ibl_ring_spectra_at(&in, m, 2 * c)[BEFORE + j];
            const double im =
                ibl_ring_spectra_at(&in, m, 2 * c + 1)[BEFORE + j];
            f += m ? 2 * (re * cos(m * phi) - im * sin(m * phi)) : re;
        }
        const double e = row[j][4 * i + c] - f;
        error += e * e;
        truth += f * f;
    }
    CHECK_MSG(sqrt(error / truth) <= 3e-7, "%s: %d orders to %d: error %.3g",
              ibl_isa_name(ibl_ctx_isa(ctx)), orders, columns,
              sqrt(error / truth));
    for (int j = 0; j < ROWS; j++)
        for (int k = 0; k < (int)stride; k++) {
            const float v = rgba[(size_t)j * stride + (size_t)k];
            if (j >= count || k < BORDER || k >= (int)stride - BORDER)
                CHECK(v == marker);
            else if ((k - BORDER) % 4 == 3)
                CHECK(v == 0);
        }
    ibl_free(rgba);
    ibl_free(scratch);
    ibl_row_fft_free(plan);
    ibl_ring_spectra_free(&in);
}

static void inverses(ibl_ctx *ctx)
{
    for (int n = 4; n <= 64; n *= 2)
        for (int orders = 1; orders <= n / 2; orders++)
            inverse(ctx, n, orders, 1 + (n + orders) % ROWS, n / 8 + 1);
    inverse(ctx, 512, 129, ROWS, 101);
    inverse(ctx, 1024, 257, ROWS, 211);
    inverse(ctx, 1024, 512, 5, 211);
    inverse(ctx, 4096, 1000, ROWS, 1999);
}

TEST(samples_of_rings)
{
    each_isa(inverses);
}
