/* SPDX-License-Identifier: MIT */
/*
 * BC6H. The decoder against OpenImageIO's; the encoder by what comes out of
 * that decoder: never worse than the best block of one colour, close where a
 * block can be.
 */
#include <math.h>
#include <string.h>

#include "core/half.h"
#include "files.h"
#include "kern.h"
#include "kern/bc6h.h"
#include "kern/bc6h_modes.h"
#include "test.h"

enum {
    N = IBL_BLOCK_TEXELS,
    BYTES = IBL_BLOCK_BYTES
};

typedef uint16_t halves[N][3];

/* ---- decoder, against OpenImageIO's ------------------------------------ */

enum {
    ROUNDS = 4,
    BLOCKS_X = 32 * ROUNDS, /* partitions, as the lowest bits of the rest */
    BLOCKS_Y = 18           /* modes, the reserved ones too */
};

static int mode_of_row(int y)
{
    return y < IBL_BC6H_MODES ? ibl_bc6h_modes[y].number
                              : 19 + 4 * (y - IBL_BC6H_MODES);
}

/* Random bits, but the mode and the partition; where a mode has no partition,
 * those bits are random numbers, too. */
static unsigned char *make_blocks(test_random *r)
{
    unsigned char *blocks = test_alloc(BLOCKS_X * BLOCKS_Y, BYTES);
    for (int i = 0; i < BLOCKS_X * BLOCKS_Y; i++) {
        unsigned char *block = blocks + i * BYTES;
        const int mode = mode_of_row(i / BLOCKS_X), part = i % 32;
        const int mask = mode < 2 ? 3 : 31;
        for (int k = 0; k < BYTES; k++)
            block[k] = (unsigned char)test_random_u64(r);
        block[0] = (unsigned char)((block[0] & ~mask) | mode);
        block[9] = (unsigned char)((block[9] & 0x1F) | part << 5);
        block[10] = (unsigned char)((block[10] & ~3) | part >> 3);
    }
    return blocks;
}

static bool save_dds(const char *name, const unsigned char *blocks,
                     uint32_t format)
{
    const size_t bytes = BLOCKS_X * BLOCKS_Y * BYTES;
    unsigned char *file = test_alloc(148 + bytes, 1);
    const uint32_t header[37] = {
        [0] = 0x20534444, /* "DDS " */
        [1] = 124,
        [2] = 0x81007, /* caps, height, width, pixel format, size */
        [3] = 4 * BLOCKS_Y,
        [4] = 4 * BLOCKS_X,
        [5] = (uint32_t)bytes,
        [19] = 32,
        [20] = 4,          /* four letters */
        [21] = 0x30315844, /* "DX10" */
        [27] = 0x1000,     /* texture */
        [32] = format,
        [33] = 3, /* two-dimensional */
        [35] = 1};
    for (int i = 0; i < 37; i++)
        file_set_u32(file + 4 * i, header[i]);
    memcpy(file + 148, blocks, bytes);
    return file_save(file_path(name), file, 148 + bytes);
}

static void compare(const unsigned char *blocks, const ibl_image *img,
                    ibl_decode_block_fn *decode)
{
    for (int i = 0; i < BLOCKS_X * BLOCKS_Y; i++) {
        halves got;
        int same = 0;
        const int x = i % BLOCKS_X, y = i / BLOCKS_X;
        CHECK(decode(blocks + i * BYTES, got) == (y < IBL_BC6H_MODES));
        for (int k = 0; k < 3 * N; k++) {
            const int column = 4 * x + k / 3 % 4, row = 4 * y + k / 12;
            const float want =
                img->data[3 * (row * img->width + column) + k % 3];
            const float is = ibl_half_to_float(got[k / 3][k % 3]);
            same += is == want && !signbit(is) == !signbit(want);
        }
        CHECK_MSG(same == 3 * N, "mode %d, partition %d: %d of 48 right",
                  mode_of_row(y), x % 32, same);
    }
}

TEST(decoded_as_by_others)
{
    ibl_ctx *ctx = test_ctx(1, IBL_ISA_AUTO);
    ibl_read_options opts = ibl_read_options_default();
    test_random r = {6};
    ibl_rows *rows;
    size_t size;

    file_need_oiio();
    opts.any_aspect = 1;
    for (int is_signed = 0; is_signed < 2; is_signed++) {
        ibl_image img = {0};
        unsigned char *blocks = make_blocks(&r);
        NEED(save_dds("b.dds", blocks, is_signed ? 96 : 95));
        NEED(file_run("oiiotool b.dds --ch R,G,B -d half --compression none -o "
                      "b.exr"));
        const void *bytes = file_load(file_path("b.exr"), &size);
        ibl_input in = ibl_input_of(ctx, "b.exr", bytes, size);
        NEED(!ibl_rows_open(&in, &opts, &rows) && !file_read_rows(rows, &img));
        test_image(img);
        ibl_rows_close(rows);
        NEED(img.width == 4 * BLOCKS_X && img.height == 4 * BLOCKS_Y);
        compare(blocks, &img,
                is_signed ? ibl_bc6h_decode_signed_block
                          : ibl_bc6h_decode_block);
    }
}

/* ---- encoder ----------------------------------------------------------- */

static const char *const qualities[] = {"fast", "normal", "best"};

static ibl_encode_blocks_fn *encoder(ibl_isa isa)
{
    ibl_bc6h_dsp dsp;
    ibl_bc6h_dsp_init(&dsp, isa);
    return dsp.encode;
}

/* Weights of a texel's squared distance, as in bc6h_encode.c. */
static void find_weights(const float t[3 * N], double weights[N])
{
    double sizes[N], sum = 0;
    for (int i = 0; i < N; i++) {
        sizes[i] = 0;
        for (int c = 3 * i; c < 3 * i + 3; c++)
            sizes[i] += (double)t[c] * (double)t[c];
        sum += sizes[i];
    }
    for (int i = 0; i < N; i++) {
        const double share = sizes[i] / (sum + 0x1p-28);
        weights[i] = (1 + 512 * share * share) / (sizes[i] + 0x1p-32);
    }
}

static double texel_error(const float t[3 * N], const double *d, int i,
                          const double weights[N])
{
    double error = 0;
    for (int c = 0; c < 3; c++) {
        const double x = d[c] - (double)t[3 * i + c];
        error += x * x * weights[i];
    }
    return error;
}

/* The error that the encoder minimises. */
static double error_of(const float t[3 * N], const double d[3 * N])
{
    double weights[N], sum = 0;
    find_weights(t, weights);
    for (int i = 0; i < N; i++)
        sum += texel_error(t, d + 3 * i, i, weights);
    return sum;
}

/* That of the best block of one colour, a weighted mean. */
static double flat_error(const float t[3 * N])
{
    double weights[N], flat[3 * N], mean[3] = {0}, sum = 0;
    find_weights(t, weights);
    for (int i = 0; i < N; i++) {
        sum += weights[i];
        for (int c = 0; c < 3; c++)
            mean[c] += weights[i] * (double)t[3 * i + c];
    }
    for (int i = 0; i < 3 * N; i++)
        flat[i] = (double)ibl_half_to_float(
            ibl_half_from_float((float)(mean[i % 3] / sum)));
    return error_of(t, flat);
}

/* Encodes and decodes a block; finite, whatever it is. */
static void round_trip(const float t[3 * N], ibl_quality quality,
                       double d[3 * N])
{
    unsigned char block[BYTES];
    halves got;
    encoder(IBL_ISA_C)(t, 1, quality, block);
    CHECK(ibl_bc6h_decode_block(block, got));
    for (int i = 0; i < 3 * N; i++) {
        CHECK(got[i / 3][i % 3] <= 0x7BFF);
        d[i] = (double)ibl_half_to_float(got[i / 3][i % 3]);
    }
}

/* sqrt of the mean squared relative error of texels. */
static double relative(const float t[3 * N], const double d[3 * N])
{
    double sum = 0;
    for (int i = 0; i < N; i++) {
        double e = 0, size = 0;
        for (int c = 3 * i; c < 3 * i + 3; c++) {
            e += (d[c] - (double)t[c]) * (d[c] - (double)t[c]);
            size += (double)t[c] * (double)t[c];
        }
        sum += e > 0 ? e / size : 0;
    }
    return sqrt(sum / N);
}

/* Every half, as blocks of one colour: exact. */
TEST(constant)
{
    for (int q = 0; q < 3; q++)
        for (int h = 0; h <= 0x7BFF; h += q ? 97 : 1) {
            float t[3 * N];
            double d[3 * N];
            for (int i = 0; i < 3 * N; i++)
                t[i] = ibl_half_to_float((uint16_t)(i % 3 == 0   ? h
                                                    : i % 3 == 1 ? 0x7BFF - h
                                                                 : h / 2));
            round_trip(t, q, d);
            for (int i = 0; i < 3 * N; i++)
                CHECK_MSG(d[i] == (double)t[i], "%s %04x", qualities[q], h);
        }
}

/* Blocks of some kinds: from 0.1 to 0.2 along x; black and white; grey with a
 * sun; two colours by partition; and what is random. */
enum {
    GRADIENT,
    CHECKER,
    SUN,
    HALVES,
    DENORMAL,
    NOISE,
    DECADES,
    KINDS
};

static float value_of(test_random *r, int kind, int i)
{
    const int texel = i / 3, c = i % 3;
    switch (kind) {
    case GRADIENT:
        return 0.1f + 0.1f / 3 * (float)(texel % 4);
    case CHECKER:
        return (float)((texel + texel / 4) % 2);
    case SUN:
        return texel == 6 ? 60000 : 0.001f;
    case HALVES:
        return texel < 8 ? c == 0 ? 0.5f : 0.25f : c == 0 ? 0.01f : 0.04f;
    case DENORMAL:
        return (float)test_random_below(r, 1024) * 0x1p-24f;
    case NOISE:
        return (float)test_random_unit(r);
    default:
        return fminf(
            (float)ldexp(test_random_unit(r), test_random_below(r, 40) - 23),
            IBL_BC6H_MAX);
    }
}

static void make_block(test_random *r, int kind, float t[3 * N])
{
    for (int i = 0; i < 3 * N; i++)
        t[i] = value_of(r, kind, i);
}

/* What each quality must keep, and that the better one is not worse. */
TEST(kinds)
{
    /* The sun's block needs all octaves: endpoints of 10 bits, steps of 1/32 of
     * an octave. Two colours without a line need two regions. */
    static const double limit[] = {
        [GRADIENT] = 0.003, [CHECKER] = 0, [SUN] = 0.016, [HALVES] = 0.008};
    test_random r = {1};
    for (int kind = GRADIENT; kind <= HALVES; kind++)
        for (int q = IBL_QUALITY_FAST; q <= IBL_QUALITY_BEST; q++) {
            float t[3 * N];
            double d[3 * N];
            make_block(&r, kind, t);
            round_trip(t, q, d);
            const double e = relative(t, d);
            const bool two = kind == HALVES && q == IBL_QUALITY_FAST;
            test_measured(qualities[q], e, limit[kind]);
            CHECK_MSG(two || e <= limit[kind], "kind %d, %s: %g", kind,
                      qualities[q], e);
        }
}

/* A sun among texels that vary keeps its light, whatever they are. */
TEST(sun_among_others)
{
    test_random r = {2};
    for (int k = 0; k < 300; k++) {
        const int at = test_random_below(&r, N);
        float t[3 * N];
        double d[3 * N];
        for (int i = 0; i < 3 * N; i++)
            t[i] = i / 3 == at ? 60000
                               : (float)ldexp(test_random_unit(&r), -k % 10);
        round_trip(t, k % 3, d);
        for (int c = 0; c < 3; c++)
            CHECK_NEAR(d[3 * at + c], 60000, 0.1 * 60000);
    }
}

TEST(never_worse_than_flat)
{
    test_random r = {3};
    for (int k = 0; k < (TEST_SANITIZED ? 14 : 140); k++) {
        float t[3 * N];
        double d[3][3 * N];
        make_block(&r, k % KINDS, t);
        for (int q = 0; q < 3; q++) {
            round_trip(t, q, d[q]);
            const double e = error_of(t, d[q]), flat = flat_error(t);
            const double worse = q ? error_of(t, d[q - 1]) : INFINITY;
            CHECK_MSG(e <= fmin(flat, worse) * 1.0001,
                      "kind %d, %s: %g, flat %g, lower quality %g", k % KINDS,
                      qualities[q], e, flat, worse);
        }
    }
}

/* -0 is 0. */
TEST(negative_zero)
{
    for (int q = 0; q < 3; q++) {
        float t[3 * N];
        double d[3 * N];
        for (int i = 0; i < 3 * N; i++)
            t[i] = i % 5 == 0 ? -0.0f : i % 5 == 1 ? 1 : 0;
        round_trip(t, q, d);
        const double e = relative(t, d);
        for (int i = 0; i < 3 * N; i++)
            t[i] += 0.0f;
        round_trip(t, q, d);
        CHECK(e == relative(t, d));
    }
}

/* Noise of a percent: the differences of endpoints use all their bits, so that
 * they cannot always be exchanged for an anchor's sake. */
TEST(anchors)
{
    test_random r = {4};
    for (int k = 0; k < (TEST_SANITIZED ? 100 : 1000); k++) {
        const double noise = test_random_between(&r, 0.003, 0.03);
        float t[3 * N];
        double d[2][3 * N];
        for (int i = 0; i < 3 * N; i++)
            t[i] = (float)test_random_between(&r, 1 - noise, 1 + noise);
        round_trip(t, IBL_QUALITY_NORMAL, d[0]);
        round_trip(t, IBL_QUALITY_BEST, d[1]);
        const double e = error_of(t, d[1]), at = error_of(t, d[0]);
        CHECK_MSG(e <= at * 1.1, "block %d: %g, normal %g", k, e, at);
    }
}

/* ---- instruction sets -------------------------------------------------- */

/* n blocks, each of another kind and quality. */
static size_t encode(ibl_isa isa, test_random *r, int n, void *out)
{
    unsigned char *blocks = out;
    float *t = kern_alloc((size_t)n * 3 * N * sizeof *t, sizeof *t);
    for (int i = 0; i < n; i++)
        make_block(r, test_random_below(r, KINDS), t + i * 3 * N);
    encoder(isa == IBL_ISA_AUTO ? IBL_ISA_C : isa)(
        t, (size_t)n, (ibl_quality)(n % 3), blocks);
    kern_free(t);
    return 0;
}

TEST(same_bytes)
{
    static const kern_same k = {
        "encode", encode, BYTES, 1, TEST_SANITIZED ? 6 : 16, 2, 0};
    kern_check_same(&k);
}
