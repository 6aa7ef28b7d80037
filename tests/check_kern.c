/* SPDX-License-Identifier: MIT */
/* Kernels that give the same bytes in every version: each against what it is
 * to give by its definition or, where that is a sum, against plain C. */
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "kern.h"
#include "kern/astc_hdr.h"
#include "kern/half_planes.h"
#include "kern/max_finite.h"
#include "kern/pixel.h"
#include "kern/rgbe.h"

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
    ibl_max_finite_dsp dsp;
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
    if (isa)
        ibl_max_finite_dsp_init(&dsp, isa);
    const uint32_t got = isa     ? dsp.look(src, (size_t)n)
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
    {"ASTC", astc_blocks, 16, 1, 12, 3, 0},
};

TEST(same_bytes)
{
    for (size_t i = 0; i < sizeof kernels / sizeof *kernels; i++)
        kern_check_same(&kernels[i]);
}
