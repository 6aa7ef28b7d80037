/* SPDX-License-Identifier: MIT */
/*
 * Kernels by every instruction set, at every length, in one table. The truth is
 * what they are to give by their definition, in double where that is a sum,
 * within what roundings leave; where it is many steps, plain C.
 */
#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "kern.h"
#include "kern/astc_hdr.h"
#include "kern/fft.h"
#include "kern/gather.h"
#include "kern/half_planes.h"
#include "kern/interp.h"
#include "kern/max_finite.h"
#include "kern/pixel.h"
#include "kern/rgbe.h"
#include "kern/row_block.h"

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

/* ---- sums: values and what they may be off by ---------------------------- */

static const double pi = 3.14159265358979323846;

static float *random_floats(test_random *r, size_t count, size_t align)
{
    float *p = kern_alloc(count * sizeof *p, align);
    for (size_t i = 0; i < count; i++)
        p[i] = (float)test_random_between(r, -1, 1);
    return p;
}

/* ---- gather ------------------------------------------------------------- */

enum {
    MAX_SAMPLES = 512
};

/* Two levels, and two groups of samples: count from the first on, about half
 * of that from 256 on. Weights past a group's end are never used. */
typedef struct lookups {
    ibl_gather_level levels[2];
    float *texels[2];
    float *arrays; /* 5 x MAX_SAMPLES */
    ibl_gather_group groups[2];
    ibl_gather_samples set;
    float frame[9];
} lookups;

/* Directions of every kind: axes, diagonals, near ties, any length. */
static void random_direction(test_random *r, double d[3])
{
    static const double special[] = {0, 1, -1, 0.5, -0.5, 1.0000001, 1e-6};
    const int kind = test_random_below(r, 3);
    const double scale =
        kind == 2 ? ldexp(1, test_random_below(r, 120) - 60) : 1;
    do {
        for (int k = 0; k < 3; k++)
            d[k] = kind ? scale * test_random_between(r, -1, 1)
                        : special[test_random_below(r, 7)];
    } while (test_dot(d, d) < 0x1p-124);
}

/* flat: all of a level's texels are the same, so that it does not matter which
 * of two faces a tie is looked up in; else directions have no ties. */
static void lookups_make(lookups *x, int edge, int count, int mips, bool flat,
                         test_random *r)
{
    float *a = x->arrays = kern_alloc(5 * MAX_SAMPLES * sizeof *a, 64);
    for (int l = 0; l < 2; l++) {
        const int n = l ? 1 + edge / 2 : edge;
        const size_t floats = 24 * (size_t)((n + 2) * (n + 2));
        float *t = x->texels[l] = kern_alloc(floats * sizeof *t, 4);
        for (size_t i = 0; i < floats; i++)
            t[i] =
                (float)(flat ? 3 + l : pow(10, test_random_between(r, -3, 5)));
        x->levels[l] = (ibl_gather_level){t, n};
    }
    x->groups[0] = (ibl_gather_group){0, count, 0, mips};
    x->groups[1] = (ibl_gather_group){256, 1 + count / 2, mips == 1, mips};
    x->set = (ibl_gather_samples){a,
                                  a + MAX_SAMPLES,
                                  a + 2 * MAX_SAMPLES,
                                  a + 3 * MAX_SAMPLES,
                                  a + 4 * MAX_SAMPLES,
                                  x->groups,
                                  2};
    for (int i = 0; i < MAX_SAMPLES; i++) {
        const ibl_gather_group *g = &x->groups[i / 256];
        const bool used = i < g->first + g->count;
        double d[3];
        random_direction(r, d);
        for (int k = 0; k < 3; k++)
            a[k * MAX_SAMPLES + i] =
                (float)(flat ? d[k] : test_random_between(r, -1, 1));
        for (int k = 3; k < 5; k++)
            a[k * MAX_SAMPLES + i] = used ? (float)test_random_unit(r) : NAN;
    }
    const double p = test_random_between(r, 0, 6.3) * (edge % 3 > 0);
    const double q = test_random_between(r, 0, 6.3) * (edge % 3 > 0);
    const double f[9] = {cos(p),           sin(p),           0,
                         -sin(p) * cos(q), cos(p) * cos(q),  sin(q),
                         sin(p) * sin(q),  -cos(p) * sin(q), cos(q)};
    for (int k = 0; k < 9; k++)
        x->frame[k] = (float)f[k];
}

static void true_lookup(const ibl_gather_level *level, const double d[3],
                        double weight, double rgb[3])
{
    const double rows[6][2][3] = {
        {{0, 0, -1}, {0, -1, 0}}, {{0, 0, 1}, {0, -1, 0}},
        {{1, 0, 0}, {0, 0, 1}},   {{1, 0, 0}, {0, 0, -1}},
        {{1, 0, 0}, {0, -1, 0}},  {{-1, 0, 0}, {0, -1, 0}}};
    int axis = 0;
    for (int k = 1; k < 3; k++)
        axis = fabs(d[k]) > fabs(d[axis]) ? k : axis;
    const int face = 2 * axis + (d[axis] < 0), n = level->edge;
    double p[2];
    for (int k = 0; k < 2; k++) {
        const double *e = rows[face][k];
        const double u = (e[0] * d[0] + e[1] * d[1] + e[2] * d[2]);
        p[k] = (u / fabs(d[axis]) + 1) / 2 * n - 0.5;
    }
    const double x = floor(p[0]), y = floor(p[1]);
    for (int tap = 0; tap < 4; tap++) {
        const int i = (int)x + 1 + tap % 2, j = (int)y + 1 + tap / 2;
        const double w = (tap % 2 ? p[0] - x : 1 - (p[0] - x)) *
                         (tap / 2 ? p[1] - y : 1 - (p[1] - y));
        const float *t =
            level->texels + 4 * ((face * (n + 2) + j) * (n + 2) + i);
        for (int c = 0; c < 3; c++)
            rgb[c] += w > 1e-9 ? weight * w * (double)t[c] : 0;
    }
}

static void true_gather(const lookups *x, double rgb[3])
{
    rgb[0] = rgb[1] = rgb[2] = 0;
    for (int g = 0; g < 2; g++) {
        const ibl_gather_group *group = &x->groups[g];
        for (int i = group->first; i < group->first + group->count; i++) {
            double d[3];
            for (int k = 0; k < 3; k++)
                d[k] = (double)x->set.x[i] * (double)x->frame[k] +
                       (double)x->set.y[i] * (double)x->frame[3 + k] +
                       (double)x->set.z[i] * (double)x->frame[6 + k];
            true_lookup(&x->levels[group->level], d, (double)x->set.fine[i],
                        rgb);
            if (group->mips == 2)
                true_lookup(&x->levels[group->level + 1], d,
                            (double)x->set.coarse[i], rgb);
        }
    }
}

/* Eight terms >= 0 for each sample, in any order; a position is rounded by some
 * n ulp, which counts where texels differ. */
static size_t gather(ibl_isa isa, test_random *r, int n, void *out)
{
    const int edge = 1 + test_random_below(r, n > 99 ? 301 : 40);
    const bool flat = test_random_below(r, 2);
    kern_near *to = out;
    double rgb[3];
    ibl_gather_dsp dsp;
    lookups x;
    if (n < 1)
        return 0;
    lookups_make(&x, edge, n, 1 + test_random_below(r, 2), flat, r);
    if (isa)
        ibl_gather_dsp_init(&dsp, isa);
    if (isa)
        dsp.gather(&x.set, x.levels, x.frame, rgb);
    else
        true_gather(&x, rgb);
    for (int c = 0; c < 3; c++)
        to[c] = (kern_near){rgb[c], (8 * n + (flat ? 8 : 100 * edge)) *
                                        (double)FLT_EPSILON * rgb[c]};
    kern_free(x.texels[0]);
    kern_free(x.texels[1]);
    kern_free(x.arrays);
    return 0;
}

/* ---- interpolation ------------------------------------------------------ */

/* Of points, as floats with what they lack, in eights. */
static size_t angles(ibl_isa isa, test_random *r, int n, void *out)
{
    const int count = 8 * n;
    float *point = kern_alloc((size_t)count * 6 * sizeof *point, 64);
    double *theta = kern_alloc((size_t)count * sizeof *theta, 64);
    double *phi = kern_alloc((size_t)count * sizeof *phi, 64);
    kern_near *to = out;
    ibl_interp_dsp dsp;
    for (int i = 0; i < count; i++) {
        double d[3];
        random_direction(r, d);
        const double length = sqrt(test_dot(d, d));
        for (int k = 0; k < 3; k++) {
            d[k] /= length;
            point[k * count + i] = (float)d[k];
            point[(k + 3) * count + i] =
                (float)(d[k] - (double)point[k * count + i]);
        }
        theta[i] = atan2(hypot(d[0], d[2]), d[1]);
        phi[i] = atan2(d[2], d[0]);
        to[3 * i].bound = 1e-11;
        to[3 * i + 1].bound = to[3 * i + 2].bound =
            fmin(1e-11 / hypot(d[0], d[2]), 2);
    }
    if (isa) {
        ibl_interp_dsp_init(&dsp, isa);
        dsp.angles(point, count, count, theta, phi);
    }
    for (int i = 0; i < count; i++) {
        to[3 * i].value = theta[i];
        to[3 * i + 1].value = cos(phi[i]);
        to[3 * i + 2].value = sin(phi[i]);
    }
    kern_free(point);
    kern_free(theta);
    kern_free(phi);
    return 0;
}

/* Solves n equations; row i is a[i][0..n - 1] and the right side a[i][n]. */
static void solve(int n, long double a[][10])
{
    for (int k = 0; k < n; k++) {
        int best = k;
        for (int i = k; i < n; i++)
            best = fabsl(a[i][k]) > fabsl(a[best][k]) ? i : best;
        for (int j = 0; j <= n; j++) {
            const long double x = a[k][j];
            a[k][j] = a[best][j];
            a[best][j] = x;
        }
        for (int i = 0; i < n; i++) {
            const long double f = a[i][k] / a[k][k];
            for (int j = k; i != k && j <= n; j++)
                a[i][j] -= f * a[k][j];
        }
    }
    for (int i = 0; i < n; i++)
        a[i][n] /= a[i][i];
}

/*
 * The constants of kern/interp_simd.c. Along a line a field of one degree has
 * waves of all lengths above its own. For waves of power p and w radians per
 * sample, weights c_k of samples at x_k have at g the mean square error
 *     sum over w of p |e^(i w g) - sum over k of c_k e^(i w x_k)|^2
 * with a noise as large as a float's rounding. It is made least, with a sum
 * of 1, at Chebyshev's nodes, and polynomials go through these weights.
 */
static void design(long double coef[6][8])
{
    long double node[6], w[6][8];
    for (int n = 0; n < 6; n++) {
        long double a[9][10] = {{0}}, power = 0, total = 0;
        node[n] = 0.5L * cosl((long double)pi * (n + 0.5L) / 6);
        for (int l = 32; l > 0; l--) {
            const long double turn = 2 * (long double)pi * l / 32 / 3;
            power += powl(10, -10.0L * l / 32);
            total += power;
            for (int i = 0; i < 8; i++) {
                for (int j = 0; j < 8; j++)
                    a[i][j] += power * cosl(turn * (i - j));
                a[i][9] += power * cosl(turn * (node[n] - i + 3.5L));
            }
        }
        for (int i = 0; i < 8; i++) {
            a[i][i] += 1e-14L * total;
            a[i][8] = a[8][i] = total;
        }
        a[8][9] = total;
        solve(9, a);
        for (int k = 0; k < 8; k++)
            w[n][k] = a[k][9];
    }
    for (int k = 0; k < 8; k++) {
        long double a[6][10] = {{0}};
        for (int n = 0; n < 6; n++) {
            for (int d = 0; d < 6; d++)
                a[n][d] = powl(node[n], d);
            a[n][6] = w[n][k];
        }
        solve(6, a);
        for (int d = 0; d < 6; d++)
            coef[d][k] = a[d][6];
    }
}

/* Positions of every kind, whole ones and those below 0 among them. With
 * IBL_TEST_VERBOSE=1 the constants are printed. */
static size_t weights(ibl_isa isa, test_random *r, int n, void *out)
{
    static long double coef[6][8];
    double *angle = kern_alloc((size_t)n * sizeof *angle, 8);
    int *first = kern_alloc((size_t)n * sizeof *first, 4);
    float *weight = kern_alloc((size_t)n * 8 * sizeof *weight, 4);
    kern_near *to = out;
    ibl_interp_dsp dsp;
    if (coef[0][0] == 0)
        design(coef);
    if (getenv("IBL_TEST_VERBOSE") && !n && !isa)
        for (int i = 0; i < 48; i++)
            printf("%.15Lg,%c", coef[i / 8][i % 8], i % 8 == 7 ? '\n' : ' ');
    for (int i = 0; i < n; i++) {
        angle[i] = i % 5 ? test_random_between(r, -3, 40) : i / 5;
        const double position = 10 * angle[i] - 0.5;
        const double t = position - floor(position);
        first[i] = (int)floor(position) - 3;
        for (int k = 0; k < 8 && !isa; k++) {
            double want = 0;
            for (int d = 5; d >= 0; d--)
                want = want * (t - 0.5) + (double)coef[d][k];
            to[9 * i + k + 1] = (kern_near){want, 1.3e-7};
        }
    }
    if (isa) {
        ibl_interp_dsp_init(&dsp, isa);
        dsp.weights(-0.5, 10, angle, n, first, weight);
    }
    for (int i = 0; i < n; i++) {
        to[9 * i] = (kern_near){first[i], 0};
        for (int k = 0; k < 8 && isa; k++)
            to[9 * i + k + 1].value = (double)weight[8 * i + k];
    }
    kern_free(angle);
    kern_free(first);
    kern_free(weight);
    return 0;
}

/* One texel's channel in double, and the sum of the terms' sizes. */
static double true_texel(const ibl_interp_row *row, int i, int channel,
                         double *size)
{
    double sum = 0;
    *size = 0;
    for (int j = 0; j < 8; j++)
        for (int k = 0; k < 8; k++) {
            const double x =
                (double)row->ring_weight[8 * i + j] *
                (double)row->column_weight[8 * i + k] *
                (double)row->grid[(row->ring[i] + j) * row->stride +
                                  4 * (row->column[i] + k) + channel];
            sum += x;
            *size += fabs(x);
        }
    return sum;
}

/* A grid of NaN but for the samples that texels touch. */
static size_t rows(ibl_isa isa, test_random *r, int count, void *out)
{
    enum {
        MAX_TEXELS = 40,
        RINGS = 24,
        COLUMNS = 64
    };
    const size_t floats = 4 * COLUMNS;
    float *grid = kern_alloc(RINGS * floats * sizeof *grid, 4);
    float *ring_weight = random_floats(r, 8 * (size_t)count, 4);
    float *column_weight = random_floats(r, 8 * (size_t)count, 4);
    int ring[MAX_TEXELS], column[MAX_TEXELS];
    ibl_interp_dsp dsp;
    kern_near *to = out;
    for (size_t i = 0; i < RINGS * floats; i++)
        grid[i] = NAN;
    for (int i = 0; i < MAX_TEXELS; i++) {
        ring[i] = test_random_below(r, RINGS - 7);
        column[i] = test_random_below(r, COLUMNS - 7);
    }
    const ibl_interp_row row = {
        .grid = grid,
        .stride = (ptrdiff_t)floats,
        .ring = ring,
        .column = column,
        .ring_weight = ring_weight,
        .column_weight = column_weight,
        .count = count,
        .rgba = kern_alloc((size_t)count * 4 * sizeof(float), 4)};
    for (int i = 0; i < count * 8 * 32; i++)
        grid[(ring[i / 256] + i / 32 % 8) * row.stride + 4 * column[i / 256] +
             i % 32] = (float)(test_random_between(r, -0.3, 0.7) *
                               pow(10, test_random_between(r, 0, 6)));
    if (isa) {
        ibl_interp_dsp_init(&dsp, isa);
        dsp.row(&row);
    }
    for (int i = 0; i < 4 * count; i++) {
        double size = 0;
        to[i].value =
            isa ? (double)row.rgba[i] : true_texel(&row, i / 4, i % 4, &size);
        to[i].bound = 9 * (double)FLT_EPSILON * size;
    }
    kern_free(row.rgba);
    kern_free(ring_weight);
    kern_free(column_weight);
    kern_free(grid);
    return 0;
}

/* ---- pixels to samples --------------------------------------------------- */

enum {
    LANES = IBL_ROW_BLOCK_LANES,
    TAPS = IBL_ROW_BLOCK_TAPS,
    STEP = 23 /* samples of 5 pixels */
};

/* Random taps, firsts that stand, step and jump; blocks of any length. */
static size_t spread(ibl_isa isa, test_random *r, int n, void *out)
{
    int32_t first[] = {0, 0, 1, 2, 22};
    float *taps = random_floats(r, 5 * TAPS, 4);
    float *pixels = random_floats(r, (size_t)n * LANES, 64);
    kern_near *to = out;
    ibl_row_block_dsp dsp;
    const ibl_row_block_spread by = {5, STEP, first, taps};
    const int used =
        n ? ((int)ibl_row_block_first(&by, n - 1) + TAPS) * LANES : 0;
    float *samples = kern_alloc((size_t)used * sizeof *samples, 64);
    ibl_row_block_dsp_init(&dsp, plain_or(isa));
    for (int k = 0; k < used; k++)
        to[k] = (kern_near){0, 20 * (double)FLT_EPSILON};
    for (int i = 0; i < n * TAPS * LANES && !isa; i++) {
        const int p = i / (TAPS * LANES), k = i % (TAPS * LANES);
        to[(first[p % 5] + p / 5 * STEP) * LANES + k].value +=
            (double)taps[p % 5 * TAPS + k / LANES] *
            (double)pixels[p * LANES + k % LANES];
    }
    for (int i = 0; isa && i < n;) {
        const int some = 1 + test_random_below(r, n), left = n - i;
        const int block = some < left ? some : left;
        dsp.spread(&by, pixels + (ptrdiff_t)i * LANES, i, block, samples);
        i += block;
    }
    for (int k = 0; k < used && isa; k++)
        to[k].value = (double)samples[k];
    kern_free(samples);
    kern_free(pixels);
    kern_free(taps);
    return 0;
}

/* ---- Fourier transforms -------------------------------------------------- */

enum {
    FFT = IBL_FFT_LANES,
    PROBES = 40 /* of a transform's values are judged */
};

/* The real transforms of 2^(n + 1) values with everything around them: bins
 * times factors, and back. Each of log2 stages adds about 0.4 epsilon; of what
 * a transform does, 5 standard deviations. Bins are of period 2^(n + 1),
 * however many are asked for. */
static size_t fft(ibl_isa isa, test_random *r, int n, void *out)
{
    if (n < 1)
        return 0;
    const bool forward = test_random_below(r, 2);
    const int length = 2 << n, more = n < 6 ? test_random_below(r, 40) : 0;
    const int count = forward ? length / 2 + 1 + more : length >> (1 + n % 3);
    const int pairs = forward ? count : length / 2;
    double *factor = kern_alloc(2 * (size_t)pairs * sizeof *factor, 64);
    ibl_fft_pair *pair = kern_alloc((size_t)pairs * sizeof *pair, 64);
    float *z = random_floats(r, (size_t)length * FFT, 64);
    float *spectrum = random_floats(r, 2 * (size_t)count * FFT, 64);
    const ibl_fft_spectrum where = {spectrum, 2 * FFT, FFT};
    const double rms =
        sqrt(length / 3.0) * (forward ? 1.6 : 2.0) * (double)FLT_EPSILON;
    kern_near *to = out;
    ibl_fft_dsp dsp;
    ibl_fft plan;
    NEED(ibl_fft_init(&plan, length / 2));
    for (int m = 0; m < pairs; m++) { /* those beyond count do not exist */
        const double a = m ? 6.3 * test_random_unit(r) : 0;
        const double size = m < count ? 0.5 + test_random_unit(r) : NAN;
        factor[2 * m] = size * cos(a);
        factor[2 * m + 1] = size * sin(a);
    }
    for (int p = 0; p < PROBES; p++) {
        const int lane = p % FFT;
        const int at = test_random_below(r, forward ? count : length);
        double sum[2] = {0};
        const double *f = factor + 2 * at;
        for (int i = 0; i < (forward ? length : count) && !isa; i++) {
            const double turn =
                2 * pi * (int)((int64_t)at * i % length) / length;
            const double c = cos(turn), s = sin(turn);
            if (forward) {
                const double v = (double)z[i * FFT + lane];
                sum[0] += v * (c * f[0] + s * f[1]);
                sum[1] += v * (c * f[1] - s * f[0]);
            } else {
                const float *g = spectrum + 2 * i * FFT + lane;
                const double *k = factor + 2 * i;
                const double re = (double)g[0] * k[0] - (double)g[FFT] * k[1];
                const double im = (double)g[0] * k[1] + (double)g[FFT] * k[0];
                sum[0] += i ? 2 * (re * c - im * s) : re;
            }
        }
        for (int k = 0; k < 2; k++)
            to[2 * p + k] =
                (kern_near){sum[k], 5 * rms * (0.6 + 0.18 * (n + 1))};
        to[2 * PROBES + p].value = at; /* of which */
        to[2 * PROBES + p].bound = 0;
    }
    if (isa)
        ibl_fft_dsp_init(&dsp, isa);
    if (forward) {
        ibl_fft_real_pairs(length / 2, factor, count, pair);
        if (isa) {
            dsp.forward(&plan, z);
            dsp.split(z, pair, count, &where);
        }
    } else {
        ibl_fft_real_pairs_inverse(length / 2, factor, count, pair);
        if (isa) {
            dsp.merge(&where, pair, plan.size, z);
            dsp.inverse(&plan, z);
        }
    }
    for (int p = 0; p < PROBES && isa; p++) {
        const int at = (int)to[2 * PROBES + p].value, lane = p % FFT;
        to[2 * p].value = (double)(forward ? spectrum[2 * at * FFT + lane]
                                           : z[at * FFT + lane]);
        if (forward)
            to[2 * p + 1].value = (double)spectrum[(2 * at + 1) * FFT + lane];
    }
    ibl_fft_free(&plan);
    kern_free(factor);
    kern_free(pair);
    kern_free(z);
    kern_free(spectrum);
    return 0;
}

/* ---- all of them -------------------------------------------------------- */

#define NEAR(values) (values) * sizeof(kern_near)
static const kern_same kernels[] = {
    {"rgbe", rgbe_to_rgb, 12, 4, 130, 1, 65536, false},
    {"run lengths", rgbe_expand, 1, 1, 300, 2, 4096, false},
    {"planes of halves", half_planes, 12, 4, 70, 1, 32768, false},
    {"unzip", unzip, 2, 1, 350, 1, 0, false},
    {"largest float", max_finite, 0, 1, 150, 6, 0, false},
    {"RGBA16F", rgba16f, 8, 1, 70, 2, 100000, false},
    {"RG16F", rg16f, 4, 1, 70, 2, 100000, false},
    {"halves to floats", halves_to_floats, 12, 4, 70, 1, 65536, false},
    {"ASTC", astc_blocks, 16, 1, 12, 3, 0, false},
    {"gather", gather, NEAR(3), 8, 50, 2, IBL_GATHER_MAX_GROUP, true},
    {"angles", angles, NEAR(24), 8, 8, 1, 0, true},
    {"weights", weights, NEAR(9), 8, 40, 1, 0, true},
    {"rows", rows, NEAR(4), 8, 40, 2, 0, true},
    {"spread", spread, NEAR((8 + TAPS) * LANES), 8, 64, 1, 0, true},
    {"fft", fft, NEAR(3 * PROBES), 8, 15, 2, 0, true},
};

TEST(kernels_of_every_length)
{
    for (size_t i = 0; i < sizeof kernels / sizeof *kernels; i++)
        kern_check_same(&kernels[i]);
}
