/* SPDX-License-Identifier: MIT */
/* Kernels that give the same bytes in every version: each against what it is
 * to give by its definition or, where that is a sum, against plain C. */
#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "core/half.h"
#include "image/strip_coverage.h"
#include "kern.h"
#include "kern/astc_hdr.h"
#include "kern/half_planes.h"
#include "kern/interp.h"
#include "kern/max_finite.h"
#include "kern/octant_sums.h"
#include "kern/pixel.h"
#include "kern/rgbe.h"
#include "kern/row_block.h"
#include "kern/texel_error.h"

/* The version to take where the definition is plain C. */
static ibl_isa plain_or(ibl_isa isa)
{
    return isa == IBL_ISA_AUTO ? IBL_ISA_C : isa;
}

static unsigned char *random_bytes(test_random *r, size_t count)
{
    unsigned char *p = kern_alloc(count, 1);
    for (size_t i = 0; i < count; i++)
        p[i] = (unsigned char)test_random_u64(r);
    return p;
}

/* Any bits, or values at which formats change. */
static float hostile(test_random *r)
{
    static const float values[] = {
        0,        -0.0f,    NAN,        INFINITY,   -INFINITY, 65504,
        65505,    65519.9f, 65520,      -65504,     -65520,    FLT_MAX,
        -FLT_MAX, FLT_MIN,  0x1p-14f,   0x1p-24f,   0x1p-25f,  0x1.000002p-25f,
        -1e-40f,  1,        0x1.ffcp0f, 0x1.ffep0f, 65408,     65024};
    const uint64_t u = test_random_u64(r);
    const uint32_t bits = (uint32_t)u;
    float f;
    memcpy(&f, &bits, sizeof f);
    return u >> 62 == 0 ? values[u % (sizeof values / sizeof values[0])]
           : u >> 62 == 1
               ? f
               : (float)ldexp(2 * test_random_unit(r) - 1, (int)(u % 44) - 26);
}

/* ---- pixels of files --------------------------------------------------- */

/* value = m 2^(e - 136) scale: every mantissa and exponent, if count allows. */
static size_t rgbe_to_rgb(ibl_isa isa, test_random *r, int n, void *out)
{
    const size_t plane = (size_t)n + (size_t)test_random_below(r, 9);
    unsigned char *src = random_bytes(r, 3 * plane + (size_t)n);
    const float scale[3] = {(float)test_random_unit(r), 1e-30f, 1e30f};
    float *rgb = out;
    ibl_rgbe_dsp dsp;
    for (int i = 0; n == 65536 && i < n; i++) {
        src[i] = src[plane + i] = src[2 * plane + i] = (unsigned char)i;
        src[3 * plane + i] = (unsigned char)(i >> 8);
    }
    if (isa == IBL_ISA_AUTO) {
        for (int i = 0; i < 3 * n; i++) {
            const int e = src[3 * plane + i / 3],
                      m = src[i % 3 * plane + i / 3];
            rgb[i] = (e ? (float)ldexp(m, e - 136) : 0) * scale[i % 3];
        }
    } else {
        ibl_rgbe_dsp_init(&dsp, isa);
        dsp.to_rgb(src, plane, n, scale, rgb);
    }
    kern_free(src);
    return 0;
}

/* Random runs and literals, of count bytes in plain. Returns their end. */
static unsigned char *make_record(test_random *r, int count, int longest,
                                  unsigned char *p, unsigned char *plain)
{
    while (count > 0) {
        const int some = 1 + test_random_below(r, longest);
        int n = some < count ? some : count;
        if (test_random_below(r, 2)) {
            n = n < 127 ? n : 127;
            *p++ = (unsigned char)(128 + n);
            memset(plain, *p++ = (unsigned char)test_random_below(r, 256),
                   (size_t)n);
        } else {
            *p++ = (unsigned char)n;
            for (int i = 0; i < n; i++)
                *p++ = plain[i] = (unsigned char)test_random_below(r, 256);
        }
        plain += n;
        count -= n;
    }
    return p;
}

/* Reads and writes no more than the slack; in plain C not even that. */
static size_t rgbe_expand(ibl_isa isa, test_random *r, int n, void *out)
{
    const size_t slack = isa == IBL_ISA_C ? 0 : IBL_RGBE_SLACK;
    unsigned char *record = malloc(2 * (size_t)n + 1);
    const size_t size =
        (size_t)(make_record(r, n, 1 + test_random_below(r, 128), record, out) -
                 record);
    if (isa != IBL_ISA_AUTO) {
        unsigned char *src = kern_alloc(size + slack, 1);
        unsigned char *dst = kern_alloc((size_t)n + slack, 1);
        ibl_rgbe_dsp dsp;
        ibl_rgbe_dsp_init(&dsp, isa);
        memcpy(src, record, size);
        CHECK(dsp.expand(src, n, dst) == src + size);
        memcpy(out, dst, (size_t)n);
        kern_free(src);
        kern_free(dst);
    }
    free(record);
    return size;
}

/* IEEE 754: (-1)^s 2^(e - 15) 1.m, and below it 2^-14 0.m. */
static float half_value(unsigned half)
{
    const int e = (int)(half >> 10 & 31);
    const double m = half & 1023;
    const double sign = half & 0x8000 ? -1 : 1;
    if (e == 31)
        return m > 0 ? NAN : (float)(sign * (double)INFINITY);
    return (float)(sign * (e ? ldexp(1024 + m, e - 25) : ldexp(m, -24)));
}

/* B is R, as of grey files. All halves, if there are as many pixels. */
static size_t half_planes(ibl_isa isa, test_random *r, int n, void *out)
{
    unsigned char *src = random_bytes(r, 4 * (size_t)n);
    const unsigned char *const plane[3] = {src, src + 2 * n, src};
    float *rgb = out;
    ibl_half_planes_dsp dsp;
    for (int i = 0; n == 32768 && i < 2 * n; i++) {
        src[2 * i] = (unsigned char)i;
        src[2 * i + 1] = (unsigned char)(i >> 8);
    }
    ibl_half_planes_dsp_init(&dsp, plain_or(isa));
    if (isa)
        dsp.to_rgb(plane, n, rgb);
    for (int i = 0; i < 3 * n; i++) {
        const unsigned char *p = plane[i % 3] + i / 3 * 2;
        if (!isa)
            rgb[i] = half_value((unsigned)(p[0] | p[1] << 8));
        if (isnan(rgb[i])) /* any will do */
            rgb[i] = NAN;
    }
    kern_free(src);
    return 0;
}

/* What a writer does, as OpenEXR's file layout says: bytes at even places,
 * those at odd ones, then differences. */
static void predict(const unsigned char *src, int size, unsigned char *dst)
{
    int n = 0, last;
    for (int first = 0; first < 2; first++)
        for (int i = first; i < size; i += 2)
            dst[n++] = src[i];
    last = size ? dst[0] : 0;
    for (int i = 1; i < size; i++) {
        const int now = dst[i];
        dst[i] = (unsigned char)(now - last + 128);
        last = now;
    }
}

/* In pieces, as lines of a block are. */
static size_t unzip(ibl_isa isa, test_random *r, int n, void *out)
{
    unsigned char *bytes = random_bytes(r, 2 * (size_t)n), last[2];
    unsigned char *even = kern_alloc((size_t)n, 1);
    unsigned char *odd = kern_alloc((size_t)n, 1);
    unsigned char *packed = malloc(2 * (size_t)n + 1);
    ibl_half_planes_dsp dsp;
    predict(bytes, 2 * n, packed);
    memcpy(even, packed, (size_t)n);
    memcpy(odd, packed + n, (size_t)n);
    ibl_half_planes_dsp_init(&dsp, plain_or(isa));
    ibl_unzip_begin(&dsp, even, (size_t)n, last);
    for (int i = 0; isa && i < n;) {
        const int some = 1 + test_random_below(r, 300), left = n - i;
        const int count = some < left ? some : left;
        dsp.unzip(even + i, odd + i, (size_t)count, last,
                  (unsigned char *)out + 2 * i);
        i += count;
    }
    if (!isa)
        memcpy(out, bytes, 2 * (size_t)n);
    kern_free(bytes);
    kern_free(even);
    kern_free(odd);
    free(packed);
    return 0;
}

/* The bits of the largest; all set if one is odd. Most have one odd float. */
static size_t max_finite(ibl_isa isa, test_random *r, int n, void *out)
{
    static const float odd[] = {INFINITY, -INFINITY, NAN,   -NAN,    -0.0f,
                                -1e-45f,  1e-45f,    3e38f, 65504.0f};
    float *src = kern_alloc((size_t)n * sizeof *src, sizeof *src), most = 0;
    bool clean = true;
    uint32_t bits;
    (void)out;
    const bool any = test_random_below(r, 4) == 0;
    for (int i = 0; i < n; i++)
        src[i] = any ? fabsf(hostile(r)) : (float)test_random_unit(r);
    if (n > 0)
        src[test_random_below(r, n)] = odd[test_random_below(r, 9)];
    for (int i = 0; i < n; i++) {
        clean = clean && isfinite(src[i]) && !signbit(src[i]);
        most = src[i] > most ? src[i] : most;
    }
    memcpy(&bits, &most, sizeof bits);
    const uint32_t got = isa     ? ibl_max_finite(isa)(src, (size_t)n)
                         : clean ? bits
                                 : UINT32_MAX;
    kern_free(src);
    return got < IBL_INFINITE_BITS ? got : UINT32_MAX;
}

/* Three of the four halves of a texel; all halves, if there are so many. */
static size_t halves_to_floats(ibl_isa isa, test_random *r, int n, void *out)
{
    uint16_t *src = (uint16_t *)random_bytes(r, 8 * (size_t)n);
    float *rgb = out;
    ibl_pixel_dsp dsp;

    for (int i = 0; n == 65536 && i < n; i++)
        src[4 * i + i % 3] = (uint16_t)i;
    if (isa == IBL_ISA_AUTO) {
        for (int i = 0; i < 3 * n; i++)
            rgb[i] = half_value(src[i / 3 * 4 + i % 3]);
    } else {
        ibl_pixel_dsp_init(&dsp, isa);
        dsp.decode_rgba16f(src, (size_t)n, rgb);
    }
    for (int i = 0; i < 3 * n; i++)
        rgb[i] = rgb[i] == rgb[i] ? rgb[i] : 0; /* any NaN */
    kern_free(src);
    return 0;
}

/* Against plain C, which check_pixel judges. Many values cover all floats. */
static size_t encode(ibl_pixel pixel, ibl_isa isa, test_random *r, int n,
                     void *out)
{
    const size_t floats = (size_t)n * (size_t)ibl_pixel_channels(pixel);
    float *src = kern_alloc(floats * sizeof *src, sizeof *src);
    ibl_pixel_dsp dsp;
    for (size_t i = 0; i < floats; i++) {
        const uint32_t bits = (uint32_t)i * 4771u;
        src[i] = hostile(r);
        if (n > 1000)
            memcpy(src + i, &bits, sizeof bits);
    }
    ibl_pixel_dsp_init(&dsp, plain_or(isa));
    const size_t beyond = dsp.encode[pixel](src, (size_t)n, out);
    kern_free(src);
    return beyond;
}

static size_t rgba16f(ibl_isa isa, test_random *r, int n, void *out)
{
    return encode(IBL_PIXEL_RGBA16F, isa, r, n, out);
}

static size_t rg16f(ibl_isa isa, test_random *r, int n, void *out)
{
    return encode(IBL_PIXEL_RG16F, isa, r, n, out);
}

/* ---- rows -------------------------------------------------------------- */

enum {
    ROWS = IBL_ROW_BLOCK_LANES
};

/* Rows of n times so many floats, which end where memory ends. */
static void make_rows(test_random *r, int n, int channels, float *rows[ROWS])
{
    for (int l = 0; l < ROWS; l++) {
        rows[l] =
            kern_alloc((size_t)(n * channels) * sizeof(float), sizeof(float));
        for (int i = 0; r && i < n * channels; i++)
            rows[l][i] = (float)test_random_between(r, -1, 1);
    }
}

static void free_rows(float *rows[ROWS])
{
    for (int l = 0; l < ROWS; l++)
        kern_free(rows[l]);
}

static size_t rows_to_lanes(ibl_isa isa, test_random *r, int n, void *out)
{
    const float scale = 0.5f;
    const size_t channel = (size_t)n * ROWS;
    float *rows[ROWS], *lanes = out;
    ibl_row_block_dsp dsp;
    make_rows(r, n, 3, rows);
    if (isa) {
        ibl_row_block_dsp_init(&dsp, isa);
        dsp.load((const float *const *)rows, n, scale, lanes, channel);
    }
    for (size_t k = 0; !isa && k < 3 * channel; k++) {
        const size_t c = k / channel, i = k % channel / ROWS;
        lanes[k] = rows[k % ROWS][3 * i + c] * scale;
    }
    free_rows(rows);
    return 0;
}

static size_t lanes_to_rows(ibl_isa isa, test_random *r, int n, void *out)
{
    const size_t channel = ((size_t)n + 2) * ROWS;
    const int used = n % 3 ? ROWS : 1 + n % ROWS;
    float *rows[ROWS], *texels = out;
    float *lanes = kern_alloc(3 * channel * sizeof *lanes, 64);
    ibl_row_block_dsp dsp;
    for (size_t i = 0; i < 3 * channel; i++)
        lanes[i] = (float)test_random_between(r, -1, 1);
    make_rows(NULL, n, 4, rows);
    if (isa) {
        ibl_row_block_dsp_init(&dsp, isa);
        dsp.store(lanes, channel, n, rows, used);
    }
    for (int l = 0; l < ROWS; l++)
        for (int i = 0; i < 4 * n; i++) {
            if (!isa && l < used)
                rows[l][i] = i % 4 == 3 ? 0
                                        : lanes[(size_t)(i % 4) * channel +
                                                (size_t)(i / 4 * ROWS + l)];
            texels[l * 4 * n + i] = rows[l][i];
        }
    free_rows(rows);
    kern_free(lanes);
    return 0;
}

/* ---- sums of octants --------------------------------------------------- */

enum {
    WIDTH = 61,
    FINE = 2 * WIDTH
};

/* Ordinary, huge, tiny and denormal. */
static float value(test_random *r)
{
    const float unit = (float)test_random_unit(r);
    const float of[] = {unit, unit * 1e6f,   FLT_MAX,
                        0,    unit * 1e-38f, 0x1p-149f};
    return of[test_random_below(r, 6)];
}

/* Ends where memory ends. */
static float *make_source(test_random *r)
{
    float *row = kern_alloc(3 * WIDTH * sizeof *row, sizeof *row);
    for (int i = 0; i < 3 * WIDTH; i++)
        row[i] = value(r);
    return row;
}

static double *make_doubles(test_random *r, int count)
{
    double *p = kern_alloc((size_t)count * sizeof *p, 64);
    for (int i = 0; i < count; i++)
        p[i] = (double)value(r);
    return p;
}

static size_t collect(ibl_isa isa, test_random *r, int n, void *out)
{
    float *row = make_source(r);
    int *offset = malloc((size_t)(n * IBL_OCTANTS + 1) * sizeof *offset);
    double *pixels = out;
    ibl_octants_dsp dsp;
    for (int i = 0; i < n * IBL_OCTANTS; i++)
        offset[i] = 3 * (i % 5 ? test_random_below(r, WIDTH) : WIDTH - 1);
    ibl_octants_dsp_init(&dsp, plain_or(isa));
    if (isa)
        dsp.collect(row, offset, n, pixels);
    for (int i = 0; !isa && i < n * IBL_OCTANT_RGB; i++) {
        const int m = i / IBL_OCTANT_RGB * IBL_OCTANTS + i % IBL_OCTANTS;
        pixels[i] = (double)row[offset[m] + i / IBL_OCTANTS % 3];
    }
    kern_free(row);
    free(offset);
    return 0;
}

/* Lane m of pixel i, channel c, and the largest value it is made of. */
static double true_blend(const ibl_octant_blend *row, int column, int c,
                         double *most)
{
    double sum = 0;
    *most = 0;
    for (int k = 0; k < 4; k++) {
        const ibl_octant_tap *tap =
            &row->taps[(column + row->turn[k / 2]) % FINE];
        const double part = k % 2 ? tap->weight : 1 - tap->weight;
        const double v = (double)row->source[k / 2][tap->at[k % 2] + c];
        sum += row->weight[k / 2] * part * v;
        *most = fmax(*most, v);
    }
    return sum;
}

/* Pixels between those of two rows, which turn, and some lanes only. */
static size_t blend(ibl_isa isa, test_random *r, int n, void *out)
{
    const int lanes = 1 + n % IBL_OCTANTS;
    const double t = test_random_unit(r);
    float *source[2] = {make_source(r), make_source(r)};
    int *column = malloc((size_t)(n * IBL_OCTANTS + 1) * sizeof *column);
    ibl_octant_tap taps[FINE];
    double *pixels = out;
    ibl_octants_dsp dsp;
    for (int i = 0; i < FINE; i++)
        taps[i] =
            (ibl_octant_tap){{3 * test_random_below(r, WIDTH), 3 * (WIDTH - 1)},
                             test_random_unit(r)};
    for (int i = 0; i < n * IBL_OCTANTS; i++)
        column[i] = test_random_below(r, FINE);
    const ibl_octant_blend row = {
        .source = {source[0], source[1]},
        .weight = {1 - t, t},
        .turn = {n % 2 * WIDTH, test_random_below(r, FINE)},
        .columns = FINE,
        .taps = taps};
    ibl_octants_dsp_init(&dsp, plain_or(isa));
    dsp.blend(&row, column, n, lanes, pixels);
    for (int i = 0; !isa && i < n * IBL_OCTANT_RGB; i++) {
        const int pixel = i / IBL_OCTANT_RGB, m = i % IBL_OCTANTS;
        double most, want = true_blend(&row, column[pixel * IBL_OCTANTS + m],
                                       i / IBL_OCTANTS % 3, &most);
        if (m < lanes)
            CHECK_NEAR(pixels[i], want, 1e-15 * most);
        else
            CHECK(((unsigned char *)&pixels[i])[7] == KERN_FILL);
    }
    kern_free(source[0]);
    kern_free(source[1]);
    free(column);
    return 0;
}

/* Runs of every length, spans that follow each other in a sum. */
static size_t add(ibl_isa isa, test_random *r, int n, void *out)
{
    enum {
        PIXELS = 40
    };
    double *pixels = make_doubles(r, PIXELS * IBL_OCTANT_RGB), *sums = out;
    ibl_octant_span *spans = malloc((size_t)(n + 1) * sizeof *spans);
    ibl_octants_dsp dsp;
    for (int i = 0; i < n; i++) {
        const int count =
            1 + test_random_below(r, test_random_below(r, 3) ? 2 : PIXELS);
        spans[i] = (ibl_octant_span){
            (float)test_random_unit(r),
            test_random_below(r, 3) ? i : test_random_below(r, n),
            (uint16_t)test_random_below(r, PIXELS - count + 1),
            (uint16_t)count};
    }
    for (int i = 0; i < n * (IBL_OCTANT_RGB + 1); i++)
        sums[i] = (double)value(r);
    ibl_octants_dsp_init(&dsp, plain_or(isa));
    dsp.add(spans, n, pixels, sums, sums + n * IBL_OCTANT_RGB);
    kern_free(pixels);
    free(spans);
    return 0;
}

/* Texels of eight places, forwards and backwards, near each other. */
static size_t write(ibl_isa isa, test_random *r, int n, void *out)
{
    const ptrdiff_t place = 4 * n;
    double *sums = make_doubles(r, n * IBL_OCTANT_RGB);
    double *weights = make_doubles(r, n);
    float *to[IBL_OCTANTS];
    ptrdiff_t step[IBL_OCTANTS];
    ibl_octants_dsp dsp;
    for (int i = 0; i < n; i++)
        weights[i] = test_random_unit(r) + 0.1;
    for (int m = 0; m < IBL_OCTANTS; m++) {
        step[m] = (m % 2 ? -1 : 1) * (3 + m / 2 % 2);
        to[m] = (float *)out + m * place + (m % 2 && n ? place - 3 : 0);
    }
    ibl_octants_dsp_init(&dsp, plain_or(isa));
    if (isa)
        dsp.write(sums, weights, n, to, step);
    for (int i = 0; !isa && i < n * IBL_OCTANT_RGB; i++) {
        const int at = i / IBL_OCTANT_RGB, m = i % IBL_OCTANTS;
        to[m][at * step[m] + i / IBL_OCTANTS % 3] =
            (float)(sums[i] * (1 / weights[at]));
    }
    kern_free(sums);
    kern_free(weights);
    return 0;
}

/* ---- strips under a border ---------------------------------------------- */

static ibl_coverage_row make_row(double theta, double height)
{
    const double to = fmin(theta + height, M_PI / 2);
    return (ibl_coverage_row){cos(theta), cos(to), 1 / tan(theta), 1 / tan(to)};
}

static double cosine(double a, double psi)
{
    const double q = cos(psi);
    return q / sqrt(a * a + q * q);
}

/* The largest fourth derivative of a border along a strip, by differences. */
static double fourth(double a, double psi, double width)
{
    const double h = fmax(width / 8, 1e-3);
    double most = 0;
    for (int k = 0; k <= 8; k++) {
        const double x = psi + width * k / 8;
        const double d = cosine(a, x - 2 * h) - 4 * cosine(a, x - h) +
                         6 * cosine(a, x) - 4 * cosine(a, x + h) +
                         cosine(a, x + 2 * h);
        most = fmax(most, fabs(d) / (h * h * h * h));
    }
    return most;
}

/*
 * By midpoints, which miss a kink by step^2 / 8 of its slope at most. The value
 * and the curvature in the middle leave d^5 / 1920 of the fourth derivative, d
 * the part of the strip in which the border is inside the row.
 */
static double true_share(const ibl_coverage_row *row, double a, double psi,
                         double width, double *bound)
{
    enum {
        POINTS = 4000
    };
    const double high = row->top - row->bottom, step = width / POINTS;
    double sum = 0, slope = 0, last = NAN;
    int inside = 1;
    for (int j = 0; j < POINTS; j++) {
        const double x = (row->top - cosine(a, psi + step * (j + 0.5))) / high;
        sum += fmin(fmax(x, 0), 1) / POINTS;
        inside += x > 0 && x < 1;
        slope = fmax(slope, fabs(x - last));
        last = x;
    }
    *bound =
        pow(inside * step, 5) / 1920 / width / high * fourth(a, psi, width) +
        2 * slope / 8 / POINTS + 1e-9;
    return sum;
}

/* Strips where a border of the sphere's octant can be, most of them in the row.
 * No closer to the pole than pixels are wide: these are no wider than texels.
 */
static void check_strip(test_random *r, int i, double theta, double height)
{
    const ibl_coverage_row row = make_row(theta, height);
    const double psi = test_random_between(r, 0, M_PI / 2 - 0.02);
    const double width = test_random_between(r, 1e-5, 0.0125),
                 end = psi + width;
    const double at =
        test_random_between(r, theta - height, theta + 2 * height);
    const double tangent = tan(fmin(fmax(at, 1e-3), M_PI / 2 - 1e-3));
    const double a = i % 9
                         ? tangent * cos(psi + test_random_between(r, 0, width))
                         : test_random_between(r, 1e-4, 2);
    const double share = ibl_coverage_above(&row, a, cos(psi), sin(psi),
                                            cos(end), sin(end), width) /
                         (width * (row.top - row.bottom));
    double bound;
    const double want = true_share(&row, a, psi, width, &bound);
    CHECK_MSG(fabs(share - want) <= bound,
              "theta %g + %g, psi %g + %g, a %g: %.9g, not %.9g +- %g", theta,
              height, psi, width, a, share, want, bound);
}

TEST(integral)
{
    test_random r = {9};
    for (int k = 0; k < 30; k++) {
        const double height = test_random_between(&r, 2e-4, 0.02);
        const double theta =
            k % 10 ? test_random_between(&r, 0, M_PI / 2 - height) : 0;
        for (int i = 0; i < 64; i++)
            check_strip(&r, i, theta, height);
    }
}

/* ---- the last step of a texel ------------------------------------------- */

static void finish_texels(test_random *r, int n)
{
    const float gain = n % 2 ? 1.125f : 1;
    const ibl_interp_range range = {
        gain, {1, -2, 0, 0}, {0, -INFINITY, 0.25f, 0}, {INFINITY, 3, 1e4f, 0}};
    float *rgba = kern_alloc((size_t)n * 4 * sizeof *rgba, sizeof *rgba);
    float *rgb = kern_alloc((size_t)n * 3 * sizeof *rgb, sizeof *rgb);
    for (int i = 0; i < 4 * n; i++)
        rgba[i] = hostile(r);
    ibl_interp_finish(rgba, &range, n, rgb);
    for (int i = 0; i < 3 * n; i++) {
        const double offset = (double)range.offset[i % 3];
        const double part = (double)rgba[i / 3 * 4 + i % 3] * (double)gain;
        const double x = part + offset, size = fabs(part) + fabs(offset);
        const double y =
            fmin(fmax(isnan(x) ? -INFINITY : x, (double)range.low[i % 3]),
                 (double)range.high[i % 3]);
        CHECK(rgb[i] == (float)y || fabs((double)rgb[i] - y) <= 2e-7 * size);
    }
    kern_free(rgba);
    kern_free(rgb);
}

TEST(finish)
{
    test_random r = {11};
    for (int n = 0; n <= 160; n++)
        finish_texels(&r, n);
}

/* ---- blocks ------------------------------------------------------------- */

/* Texels near a colour, of any light, or denormal. */
static float astc_light(test_random *r, int kind)
{
    const double unit = test_random_unit(r);
    const double light = kind == 0 ? 1 + unit
                         : kind == 1
                             ? ldexp(unit, test_random_below(r, 40) - 24)
                             : ldexp(unit, -14);
    return (float)light;
}

static size_t astc_blocks(ibl_isa isa, test_random *r, int n, void *out)
{
    float *texels = kern_alloc((size_t)n * 48 * sizeof *texels, sizeof *texels);
    const ibl_quality quality = (ibl_quality)test_random_below(r, 3);
    ibl_astc_hdr_dsp dsp;
    for (int i = 0; i < 48 * n; i++)
        texels[i] = astc_light(r, i / 48 % 3);
    ibl_astc_hdr_dsp_init(&dsp, plain_or(isa));
    if (n % 3)
        dsp.encode(texels, (size_t)n, quality, out);
    else
        dsp.encode_alike(texels, (size_t)n, quality, &(ibl_astc_past){0}, out);
    kern_free(texels);
    return 0;
}

/* ---- texels compared ---------------------------------------------------- */

/* The sums are those of plain C, lane by lane. */
static size_t texel_error(ibl_isa isa, test_random *r, int n, void *out)
{
    float *t = kern_alloc((size_t)n * 12, sizeof *t);
    float *d = kern_alloc((size_t)n * 12, sizeof *d);
    ibl_error_sums sums = {0};
    ibl_texel_error_dsp dsp;

    (void)out;
    for (int i = 0; i < 3 * n; i++) {
        t[i] = i / 3 % 5 ? hostile(r) : 0;
        d[i] = i / 3 % 3 ? t[i] : hostile(r);
        d[i] = d[i] == d[i] ? d[i] : 1; /* NaN would be any NaN */
    }
    ibl_texel_error_dsp_init(&dsp, plain_or(isa));
    dsp.add(t, d, (size_t)n, &sums);
    kern_free(t);
    kern_free(d);
    uint64_t hash = 0;
    for (size_t i = 0; i < sizeof sums / 8; i++) {
        uint64_t word;
        memcpy(&word, (char *)&sums + 8 * i, 8);
        hash = hash * 31 + word;
    }
    return (size_t)hash;
}

/* ---- all of them -------------------------------------------------------- */

static const kern_same kernels[] = {
    {"rgbe", rgbe_to_rgb, 12, 4, 130, 1, 65536},
    {"run lengths", rgbe_expand, 1, 1, 300, 8, 4096},
    {"planes of halves", half_planes, 12, 4, 70, 1, 32768},
    {"unzip", unzip, 2, 1, 350, 1, 0},
    {"largest float", max_finite, 0, 1, 300, 40, 0},
    {"RGBA16F", rgba16f, 8, 1, 70, 5, 300000},
    {"RG16F", rg16f, 4, 1, 70, 5, 300000},
    {"halves to floats", halves_to_floats, 12, 4, 70, 1, 65536},
    {"texels compared", texel_error, 0, 1, 70, 5, 3000},
    {"ASTC", astc_blocks, 16, 1, 12, 3, 0},
    {"rows to lanes", rows_to_lanes, 12 * ROWS, 64, 70, 1, 0},
    {"lanes to rows", lanes_to_rows, 16 * ROWS, 4, 70, 1, 0},
    {"octants: collect", collect, 8 * IBL_OCTANT_RGB, 64, 40, 1, 0},
    {"octants: blend", blend, 8 * IBL_OCTANT_RGB, 64, 40, 1, 0},
    {"octants: add", add, 8 * (IBL_OCTANT_RGB + 1), 64, 40, 1, 0},
    {"octants: write", write, 16 * IBL_OCTANTS, 4, 40, 1, 0},
};

TEST_OF(same_bytes, "same_bytes", TEST_RACES || !TEST_SANITIZED)
{
    for (size_t i = 0; i < sizeof kernels / sizeof *kernels; i++)
        kern_check_same(&kernels[i]);
}

/* Rounds to the nearest half (2^16 for Inf), and of ties to the even one. */
TEST(floats_to_halves)
{
    int wrong = 0;
    for (unsigned h = 0; h < 0x7C00; h++) {
        const float low = half_value(h);
        const float high = h == 0x7BFF ? 0x1p16f : half_value(h + 1);
        const float middle = low + 0.5f * (high - low);
        wrong += ibl_half_to_float((uint16_t)h) != low;
        for (unsigned sign = 0; sign <= 0x8000; sign += 0x8000) {
            const float s = sign ? -1 : 1;
            const unsigned even = h % 2 ? h + 1 : h;
            wrong += ibl_half_from_float(s * low) != (sign | h);
            wrong += ibl_half_from_float(s * middle) != (sign | even);
            wrong +=
                ibl_half_from_float(s * nextafterf(middle, low)) != (sign | h);
            wrong += ibl_half_from_float(s * nextafterf(middle, high)) !=
                     (sign | (h + 1));
        }
    }
    CHECK_MSG(!wrong, "%d wrong", wrong);
    CHECK(ibl_half_from_float(INFINITY) == 0x7C00);
    CHECK(isnan(ibl_half_to_float(ibl_half_from_float(NAN))));
}
