/* SPDX-License-Identifier: MIT */
/* ASTC HDR blocks: decoding against the specification and astcenc, encoding
 * against what a block of one colour would be, and against what UASTC HDR
 * allows. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "core/half.h"
#include "files.h"
#include "kern.h"
#include "kern/astc_hdr.h"
#include "kern/astc_hdr_block.h"
#include "kern/astc_hdr_endpoints.h"
#include "kern/astc_line.h"
#include "kern/bc6h.h"
#include "test.h"

/* ---- decoding ---------------------------------------------------------- */

/* What UASTC HDR allows: subsets, mode, levels of weights and of values. */
static const int ways[][4] = {
    {1, 7, 3, 256},  {1, 7, 4, 256},   {1, 7, 5, 256},   {1, 7, 6, 256},
    {1, 7, 8, 256},  {1, 7, 10, 256},  {1, 7, 12, 256},  {1, 7, 16, 256},
    {1, 11, 3, 256}, {1, 11, 4, 256},  {1, 11, 5, 256},  {1, 11, 6, 256},
    {1, 11, 8, 256}, {1, 11, 10, 256}, {1, 11, 12, 256}, {1, 11, 16, 192},
    {2, 7, 3, 256},  {2, 7, 4, 256},   {2, 7, 5, 192},   {2, 7, 6, 128},
    {2, 7, 8, 80},   {2, 11, 3, 64},   {2, 11, 4, 40}};
enum {
    WAYS = sizeof ways / sizeof *ways
};

/* The first 17 or 29 bits of a block: 4x4 weights of a plane, subsets, a mode
 * for all. Ranges by their number in ASTC's order, from that of 2 levels on. */
static uint64_t header_of(const int way[4], unsigned pattern)
{
    static const int levels[] = {2, 3, 4, 5, 6, 8, 10, 12, 16};
    unsigned range = 0;
    while (levels[range] != way[2])
        range++;
    const unsigned fine = range >= 6, code = range + 2 - 6 * fine;
    const uint64_t grid = code >> 1 | (code & 1) << 4 | 2u << 5 | fine << 9;
    const uint64_t mode = (uint64_t)way[1];
    return way[0] == 1 ? grid | mode << 13
                       : grid | 1u << 11 | (uint64_t)pattern << 13 | mode << 25;
}

/* A block of random bits with the start of one of UASTC HDR; every fourth one
 * has its kind of grid only, others nothing. */
static void random_block(test_random *r, int kind, unsigned char *block)
{
    ibl_bits128 b = {test_random_u64(r), test_random_u64(r)};
    const int *way = ways[kind / 2 % WAYS];
    const int bits = way[0] == 1 ? 17 : 29;
    if (kind % 2)
        b.low =
            header_of(way, (unsigned)(b.high & 1023)) | b.low >> bits << bits;
    else if (kind % 4)
        b.low = (b.low & ~UINT64_C(0x5EC)) | 0x40;
    if (kind % 50 == 0)
        b.low = UINT64_C(0xFFFFFFFFFFFFFFFC);
    ibl_bits128_store(b, block);
}

enum {
    BLOCKS = 20000
};

static unsigned char *save_blocks(test_random *r)
{
    unsigned char *file = test_alloc(16 + 16 * BLOCKS, 1);
    file_set_u32(file, 0x5CA1AB13);
    memcpy(file + 4, "\4\4\1\4", 5);
    file[10] = (unsigned char)(4 * BLOCKS);
    file[11] = (unsigned char)(4 * BLOCKS >> 8);
    file[12] = (unsigned char)(4 * BLOCKS >> 16);
    file[13] = 1;
    for (int i = 0; i < BLOCKS; i++)
        random_block(r, i, file + 16 + 16 * i);
    CHECK(file_save(file_path("b.astc"), file, 16 + 16 * BLOCKS));
    return file + 16;
}

static int is_nan(unsigned half)
{
    return (half & 0x7FFF) > 0x7C00;
}

/* Of blocks of UASTC HDR all are read, of others none is. Of an invalid block
 * astcenc makes NaN. Halves that are NaN it may change. */
TEST(decodes_as_astcenc)
{
    test_random r = {3};
    size_t size;
    int valid = 0;
    if (!file_have("astcenc"))
        test_skip("package astcenc is missing");
    const unsigned char *blocks = save_blocks(&r);
    NEED(file_run("astcenc -dH b.astc b.dds"));
    const unsigned char *out = file_load(file_path("b.dds"), &size);
    NEED(size == 148 + 128 * (size_t)BLOCKS);
    for (int i = 0; i < BLOCKS; i++) {
        const unsigned char *p = out + 148 + 128 * (size_t)i;
        uint16_t t[16][3];
        int wrong = 0;
        const int ok = ibl_astc_hdr_decode_block(blocks + 16 * i, t);
        for (int k = 0; k < 48; k++) {
            const unsigned char *h = p + k / 3 * 8 + k % 3 * 2;
            const unsigned want = (unsigned)(h[0] | h[1] << 8);
            wrong += is_nan(want) ? !is_nan(t[k / 3][k % 3])
                                  : want != t[k / 3][k % 3];
        }
        if (!ok) {
            const uint16_t none[16][3] = {{0}};
            CHECK_MSG(i % 2 == 0 && !memcmp(t, none, sizeof t), "block %d", i);
            wrong = 0;
        }
        valid += ok;
        CHECK_MSG(!wrong, "block %d, valid %d: %d differ", i, ok, wrong);
    }
    CHECK(valid > BLOCKS / 2 && valid < BLOCKS * 6 / 10);
}

/* ---- encoding ---------------------------------------------------------- */

static float level_of(test_random *r, double lowest, double highest)
{
    return (float)exp2(test_random_between(r, lowest, highest));
}

enum {
    CONSTANT,
    BLACK,
    GREY_SLOPE,
    SLOPE,
    CHECKER,
    SUN,
    DENORMAL,
    ANY,
    HUES,
    TWO_SIDES,
    LARGEST,
    KINDS
};

/* A colour of any hue. */
static void some_colour(test_random *r, double low, double high, float c[3])
{
    const float level = level_of(r, low, high);
    for (int i = 0; i < 3; i++)
        c[i] = level * (float)test_random_between(r, 0.1, 1);
}

static void make_block(test_random *r, int kind, float t[16][3])
{
    float a[3], b[3], c[3];
    const int edge = test_random_below(r, 3) + 1;
    const float x = (float)test_random_unit(r), y = 1 - x;

    some_colour(r, -8, 8, a);
    some_colour(r, -8, 8, b);
    some_colour(r, -26, -14, c);
    for (int i = 0; i < 16; i++)
        for (int k = 0; k < 3; k++) {
            const float at =
                (x * (float)(i % 4) + y * (float)(i / 4)) * (1.0f / 3);
            const float noise = (float)test_random_between(r, 0.9, 1.1);
            float v = a[k];
            switch (kind) {
            case BLACK:
                v = 0;
                break;
            case GREY_SLOPE:
                v = a[0] * (1 + at);
                break;
            case SLOPE:
                v = a[k] + (b[k] - a[k]) * at;
                break;
            case CHECKER:
                v = (i ^ i / 4) & 1 ? a[k] : b[k];
                break;
            case SUN:
                v = i == 5 ? 50000 : 1 + a[k];
                break;
            case DENORMAL:
                v = c[k] * noise;
                break;
            case ANY:
                v = level_of(r, -20, 15.9);
                break;
            case HUES:
                v = a[k] * (float)test_random_between(r, 0.7, 1.4);
                break;
            case TWO_SIDES:
                v = (i % 4 < edge ? a[k] : b[k]) * noise;
                break;
            case LARGEST:
                v = i % 3 ? IBL_ASTC_HDR_MAX : a[k];
                break;
            default:
                break;
            }
            t[i][k] = v;
        }
}

/* Whether all ends are below Inf: the largest is 3967 of 12 bits. */
static int finite_ends(const ibl_astc_block *b)
{
    const int each = b->mode == 7 ? 4 : 6;
    int largest = 0;
    for (int s = 0; s < b->subsets; s++) {
        unsigned char v[6];
        int e[2][3];
        for (int i = 0; i < each; i++)
            v[i] = (unsigned char)ibl_ise_endpoint(b->value_range,
                                                   b->value[each * s + i]);
        ibl_astc_line_ends(b->mode, v, e);
        for (int i = 0; i < 6; i++)
            largest = e[i / 3][i % 3] > largest ? e[i / 3][i % 3] : largest;
    }
    return largest <= 3967;
}

static int allowed(const unsigned char *block)
{
    static const short patterns[] = {
        28, 20, 16,  29,  91, 9,   107, 72,  149, 204, 50,  114, 496, 17,
        78, 39, 252, 828, 43, 156, 116, 210, 476, 273, 684, 359, 246};
    const ibl_bits128 bits = ibl_bits128_load(block);
    ibl_astc_block b;
    int found = 0;

    if (bits.low == UINT64_C(0xFFFFFFFFFFFFFFFC))
        return 1;
    if (!ibl_astc_unpack(bits, &b) || !finite_ends(&b))
        return 0;
    for (size_t i = 0; i < WAYS; i++)
        found |= ways[i][0] == b.subsets && ways[i][1] == b.mode &&
                 ways[i][2] == ibl_ise_levels(b.weight_range) &&
                 ways[i][3] == ibl_ise_levels(b.value_range);
    for (int i = 0; b.subsets == 2; i++) {
        if (i == 27)
            return 0;
        if (patterns[i] == b.pattern)
            break;
    }
    return found;
}

/* What an error's square counts: see kern/astc_hdr.h. */
static void shares(const float t[16][3], double share[16])
{
    double most = 0, square[16] = {0}, total = 0x1p-60;
    for (int i = 0; i < 48; i++) {
        const double v = (double)t[i / 3][i % 3];
        most = fmax(most, v);
        square[i / 3] += v * v;
        total += v * v;
    }
    for (int i = 0; i < 16; i++)
        share[i] = 1 / (square[i] + ldexp(most * most, -34) + 0x1p-60) +
                   128 * square[i] / total / total;
}

static double error_of(const float t[16][3], const uint16_t d[16][3])
{
    double share[16], sum = 0;
    shares(t, share);
    for (int i = 0; i < 16; i++) {
        double off = 0;
        for (int k = 0; k < 3; k++) {
            const double e =
                (double)ibl_half_to_float(d[i][k]) - (double)t[i][k];
            off += e * e;
        }
        sum += off * share[i];
    }
    return sum;
}

/* The best of one colour is the mean by the same weights. */
static void flat(const float t[16][3], uint16_t d[16][3])
{
    double share[16];
    shares(t, share);
    for (int k = 0; k < 3; k++) {
        double sum = 0, all = 0;
        for (int i = 0; i < 16; i++) {
            sum += (double)t[i][k] * share[i];
            all += share[i];
        }
        for (int i = 0; i < 16; i++)
            d[i][k] = ibl_half_from_float((float)(sum / all));
    }
}

static void check_block(const float t[16][3], const unsigned char *block,
                        int kind, int quality)
{
    uint16_t d[16][3], even[16][3];
    CHECK_MSG(allowed(block), "kind %d: not of UASTC HDR", kind);
    NEED(ibl_astc_hdr_decode_block(block, d));
    for (int i = 0; i < 48; i++)
        CHECK(d[i / 3][i % 3] < 0x7C00);
    flat(t, even);
    const double ours = error_of(t, d), most = error_of(t, even);
    CHECK_MSG(ours <= most * 1.0001 + 1e-8,
              "kind %d, quality %d: error %g, %g of one colour", kind, quality,
              ours, most);
    if (kind == CONSTANT || kind == BLACK)
        CHECK(!memcmp(d, even, sizeof d));
}

static void each_kind_of(ibl_isa isa)
{
    test_random r = {5};
    ibl_astc_hdr_dsp dsp;
    ibl_astc_hdr_dsp_init(&dsp, isa);
    for (int n = 0; n < (TEST_SANITIZED ? 12 : 90) * KINDS; n++) {
        float t[16][3];
        unsigned char block[16];
        const int quality = n / KINDS % 3;
        make_block(&r, n % KINDS, t);
        dsp.encode(&t[0][0], 1, (ibl_quality)quality, block);
        check_block(t, block, n % KINDS, quality);
    }
}

KERN_TEST(each_kind)

/* The largest error of a texel, relative to its length, in 40 blocks; its root
 * mean square. */
static double largest_of(int kind, ibl_quality quality, double *rms)
{
    test_random r = {7};
    ibl_astc_hdr_dsp dsp;
    double largest = 0, sum = 0;
    ibl_astc_hdr_dsp_init(&dsp, IBL_ISA_C);
    for (int n = 0; n < 640; n++) {
        static float t[16][3];
        static uint16_t d[16][3];
        unsigned char block[16];
        double off = 0, square = 0;
        if (n % 16 == 0) {
            make_block(&r, kind, t);
            dsp.encode(&t[0][0], 1, quality, block);
            ibl_astc_hdr_decode_block(block, d);
        }
        for (int k = 0; k < 3; k++) {
            const double v = (double)t[n % 16][k];
            const double e = (double)ibl_half_to_float(d[n % 16][k]) - v;
            off += e * e;
            square += v * v;
        }
        largest = fmax(largest, off / square);
        sum += off / square;
    }
    *rms = sqrt(sum / 640);
    return sqrt(largest);
}

/* A line of greys of one octave: 16 levels of it are 1/15 octave apart, so no
 * texel is off by more than half of it; evenly spread, that is 1.4 %. */
TEST(slopes)
{
    double rms;
    largest_of(GREY_SLOPE, IBL_QUALITY_NORMAL, &rms);
    CHECK_MSG(rms < 0.0143, "%g", rms);
}

/* Sixteen denormal halves in even steps of 13 units: a line has them all, but
 * for the rounding of its ends and weights. */
TEST(denormal_slope)
{
    float t[16][3];
    uint16_t d[16][3];
    unsigned char block[16];
    ibl_astc_hdr_dsp dsp;
    for (int i = 0; i < 48; i++)
        t[i / 3][i % 3] = (float)(200 + 13 * (i / 3)) * 0x1p-24f;
    for (ibl_isa isa = IBL_ISA_C; isa < IBL_ISA_COUNT;
         isa = test_next_isa(isa)) {
        ibl_astc_hdr_dsp_init(&dsp, isa);
        dsp.encode(&t[0][0], 1, IBL_QUALITY_NORMAL, block);
        ibl_astc_hdr_decode_block(block, d);
        for (int i = 0; i < 48; i++)
            CHECK_MSG(abs(d[i / 3][i % 3] - (200 + 13 * (i / 3))) < 13, "%d %d",
                      i, d[i / 3][i % 3]);
    }
}

/* The ends have 8 bits, 1/8 octave: half of it is 4.4 %, and blue twice that.
 */
TEST(sun_stays)
{
    for (int q = IBL_QUALITY_FAST; q <= IBL_QUALITY_BEST; q++) {
        double rms;
        const double largest = largest_of(SUN, (ibl_quality)q, &rms);
        CHECK_MSG(largest < (q ? 256 : 512) * 3.0 / 8 / 1024 + 1e-3, "%g",
                  largest);
    }
}

/* ---- as BC6H ----------------------------------------------------------- */

static void set_bytes(const char *hex, unsigned char *bytes)
{
    for (int i = 0; i < 16; i++) {
        unsigned v = 0;
        sscanf(hex + 2 * i, "%2x", &v);
        bytes[i] = (unsigned char)v;
    }
}

/* A block as its encoder had it before it was written. Returns its pattern. */
static int lines_of(const ibl_astc_tables *tb, const ibl_astc_block *b,
                    const ibl_astc_way **way, ibl_astc_line l[2])
{
    const int each = b->mode == 7 ? 4 : 6;
    int p = 0;
    for (int i = 0; i < IBL_ASTC_WAYS; i++)
        if (ibl_astc_ways[i].subsets == b->subsets &&
            ibl_astc_ways[i].mode == b->mode &&
            ibl_astc_ways[i].weight_range == b->weight_range)
            *way = &ibl_astc_ways[i];
    for (int i = 0; i < b->values; i++)
        l[i / each].values[i % each] =
            (unsigned char)ibl_ise_endpoint(b->value_range, b->value[i]);
    for (int i = 0; i < 16; i++)
        for (int k = 0; k < tb->levels[b->weight_range].count; k++)
            if (tb->levels[b->weight_range].code[k] == b->weight[i])
                l[0].level[i] = l[1].level[i] = (unsigned char)k;
    while (b->subsets == 2 && ibl_astc_patterns[p] != b->pattern)
        p++;
    return p;
}

static float plain_error_bc6h(const ibl_astc_texels *t, const int ends[2][3],
                              const int steps[16])
{
    float sum = 0;
    for (int i = 0; i < 48; i++) {
        const int c = i % 3, w = steps[i / 3];
        const int q = (ends[0][c] * (64 - w) + ends[1][c] * w + 32) >> 6;
        const float d =
            ibl_half_to_float((uint16_t)(q * 31 >> 6)) - t->light[c][i / 3];
        sum += d * d * t->share[i / 3];
    }
    return sum;
}

/* The error of a block as BC6H for texels. */
static double error_as_bc6h(const float *texels, const unsigned char *block)
{
    static const ibl_astc_fit_dsp fit = {.error_bc6h = plain_error_bc6h};
    static ibl_astc_tables tb;
    ibl_astc_block b;
    ibl_astc_texels t[2];
    ibl_astc_line l[2];
    const ibl_astc_way *way = NULL;

    ibl_astc_set_tables(&fit, &tb);
    NEED(ibl_astc_unpack(ibl_bits128_load(block), &b));
    const int pattern = lines_of(&tb, &b, &way, l);
    NEED(way);
    ibl_astc_load(texels, &t[0]);
    if (b.subsets == 2) {
        ibl_astc_take(&tb, &t[0], pattern, 1, &t[1]);
        ibl_astc_take(&tb, &t[0], pattern, 0, &t[0]);
    }
    return (double)ibl_astc_error_as_bc6h(&tb, way, pattern, t, l);
}

/* Blocks of ours, and what the Basis Universal transcoder that three.js r187
 * has made of them: of texels that are BC6H's the error is 0. */
TEST(as_bc6h)
{
    static const char *const blocks[][2] = {
        {"5162b504b7fe587901004036e36a9188",
         "c3c205df8babaeb500001122aabaffff"},
        {"5162ed883a887f0681bab5aeab1f5e36",
         "4b506d2b7ef0c00543b652da64da96eb"},
        {"426277439d87be0262026a82c244bf25",
         "a337e3a6dbd1482ba9fd224341564046"},
        {"42629183d06f822fff7777d3db69e50c",
         "c74f48492de4104130a796dbcbeeeeff"},
        {"432802ce7c680dca06d640be504755cc",
         "8ca382d6a144028ab0a2451af3bde0e6"},
        {"43e8042e96805b83182e0488b6bc5d0d",
         "41a4114a2194582295e5918ca47ffb03"},
        {"43a803ce42530c2e34c600002dfaf6b2",
         "42e89c5bce58111577710c7cf149f200"},
        {"43c8092e2d5811eb835410e2a7f688e4",
         "920db5c2da75db9d17c67d2220fddf1c"},
        {"5308090e3a83509903ca4f533984b587",
         "a031c60c636601f604efc45b83b98a1a"},
        {"532822cea43573132f21168992b97019",
         "e133104239eed8e38e05330f9d499168"},
        {"5328024ec8b73881ef3ca0d4ed70d2ee",
         "32ed35d9f6c1d31f62bd1169e36f570a"},
    };
    for (size_t i = 0; i < sizeof blocks / sizeof *blocks; i++) {
        unsigned char astc[16], bc6h[16];
        float texels[48];
        uint16_t d[16][3];
        set_bytes(blocks[i][0], astc);
        set_bytes(blocks[i][1], bc6h);
        NEED(ibl_bc6h_decode_block(bc6h, d));
        for (int k = 0; k < 48; k++)
            texels[k] = ibl_half_to_float(d[k / 3][k % 3]);
        const double error = error_as_bc6h(texels, astc);
        CHECK_MSG(error == 0, "block %zu: %g", i, error);
    }
}

/* Each quality is better than the one before it, over many blocks; as BC6H,
 * too, which cannot tell two sides apart as finely as ASTC but counts. */
TEST(qualities)
{
    ibl_astc_hdr_dsp dsp;
    double sum[3] = {0}, bc6h[3] = {0};
    ibl_astc_hdr_dsp_init(&dsp, IBL_ISA_C);
    for (int q = 0; q < 3; q++) {
        test_random r = {9};
        for (int n = 0; n < 100; n++) {
            float t[16][3];
            unsigned char block[16];
            uint16_t d[16][3];
            make_block(&r, n & 1 ? TWO_SIDES : HUES, t);
            dsp.encode(&t[0][0], 1, (ibl_quality)q, block);
            ibl_astc_hdr_decode_block(block, d);
            sum[q] += error_of(t, d);
            bc6h[q] += error_as_bc6h(&t[0][0], block);
        }
    }
    CHECK_MSG(bc6h[1] < bc6h[0], "%g, %g", bc6h[1], bc6h[0]);
    CHECK_MSG(bc6h[2] < bc6h[1], "%g, %g", bc6h[2], bc6h[1]);
    CHECK_MSG(bc6h[1] < 1.35 * sum[1], "%g, %g", bc6h[1], sum[1]);
    CHECK_MSG(bc6h[2] < 1.35 * sum[2], "%g, %g", bc6h[2], sum[2]);
    CHECK_MSG(sum[1] < 0.95 * sum[0], "%g, %g", sum[1], sum[0]);
    CHECK_MSG(sum[2] < 0.99 * sum[1], "%g, %g", sum[2], sum[1]);
}

enum {
    ALIKE_BLOCKS = 900
};

/* What encode minimises, see kern/astc_hdr.h. */
static double error_of_both(const float t[16][3], const unsigned char *block)
{
    uint16_t d[16][3];
    ibl_astc_hdr_decode_block(block, d);
    const double error = error_of(t, d);
    return fmax(error, 0.7 * error + 0.3 * error_as_bc6h(&t[0][0], block));
}

/* The last 8 bytes are those of one of the blocks before. */
static int repeats(const unsigned char *blocks, int n)
{
    for (int i = 0; i < n; i++)
        if (!memcmp(blocks + 16 * i + 8, blocks + 16 * n + 8, 8))
            return 1;
    return 0;
}

/* Blocks alike are of UASTC HDR, and lose no more than they may. */
TEST(alike)
{
    static float t[ALIKE_BLOCKS][16][3];
    static unsigned char plain[16 * ALIKE_BLOCKS], alike[16 * ALIKE_BLOCKS];
    static ibl_astc_past past;
    test_random r = {11};
    ibl_astc_hdr_dsp dsp;
    int others = 0;
    ibl_astc_hdr_dsp_init(&dsp, IBL_ISA_C);
    for (int n = 0; n < ALIKE_BLOCKS; n++)
        make_block(&r, n & 1 ? SLOPE : HUES, t[n]);
    dsp.encode(&t[0][0][0], ALIKE_BLOCKS, IBL_QUALITY_NORMAL, plain);
    dsp.encode_alike(&t[0][0][0], ALIKE_BLOCKS, IBL_QUALITY_NORMAL, &past,
                     alike);
    for (int n = 0; n < ALIKE_BLOCKS; n++) {
        const unsigned char *a = plain + 16 * n, *b = alike + 16 * n;
        CHECK(allowed(b));
        if (!memcmp(a, b, 16))
            continue;
        const double least = error_of_both(t[n], a),
                     error = error_of_both(t[n], b);
        CHECK_MSG(error < least * 1.001 * (1 + IBL_ASTC_ALIKE_LOSS),
                  "block %d: %g, %g", n, error, least);
        CHECK(repeats(alike, n));
        others++;
    }
    CHECK_MSG(others > ALIKE_BLOCKS / 4, "%d", others);
    CHECK_MSG(others < ALIKE_BLOCKS * 0.7, "%d", others);
}
