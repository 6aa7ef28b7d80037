/* SPDX-License-Identifier: MIT */
/*
 * Codecs of blocks: BC6H and ASTC HDR. The decoders against OpenImageIO's and
 * astcenc, as BC6H against a transcoder's blocks; the encoders by what comes
 * out of the decoders, by laws for kinds of blocks: never worse than the best
 * block of one colour, close where a block can be, of what UASTC HDR allows,
 * and the same bytes by each instruction set.
 */
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
#include "kern/bc6h_modes.h"
#include "test.h"
#include "textures.h"

enum {
    N = IBL_BLOCK_TEXELS,
    BYTES = IBL_BLOCK_BYTES
};

typedef uint16_t halves[N][3];
typedef float texels[N][3];

/* ---- decoding BC6H ------------------------------------------------------- */

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
    ibl_ctx *ctx = test_ctx(1, IBL_ISA_C);
    ibl_read_options opts = ibl_read_options_default();
    test_random r = {6};
    ibl_rows *rows;

    file_need_oiio();
    opts.any_aspect = 1;
    for (int is_signed = 0; is_signed < 2; is_signed++) {
        ibl_image img = {0};
        const ibl_texture tex = {.pixel = IBL_PIXEL_BC6H,
                                 .width = 4 * BLOCKS_X,
                                 .height = 4 * BLOCKS_Y,
                                 .levels = 1,
                                 .layers = 1,
                                 .faces = 1,
                                 .bytes = (size_t)BLOCKS_X * BLOCKS_Y * BYTES,
                                 .data = make_blocks(&r)};
        size_t size;
        unsigned char *dds =
            texture_encode(ctx, &tex, IBL_CONTAINER_DDS, &size);
        file_set_u32(dds + 128, is_signed ? 96 : 95);
        NEED(file_save(file_path("b.dds"), dds, size));
        NEED(file_run("oiiotool b.dds --ch R,G,B -d half --compression none -o "
                      "b.exr"));
        const void *bytes = file_load(file_path("b.exr"), &size);
        ibl_input in = ibl_input_of(ctx, "b.exr", bytes, size);
        NEED(!ibl_rows_open(&in, &opts, &rows) && !file_read_rows(rows, &img));
        test_image(img);
        ibl_rows_close(rows);
        NEED(img.width == 4 * BLOCKS_X && img.height == 4 * BLOCKS_Y);
        compare(tex.data, &img,
                is_signed ? ibl_bc6h_decode_signed_block
                          : ibl_bc6h_decode_block);
    }
}

/* ---- decoding ASTC ------------------------------------------------------- */

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
        halves t;
        int wrong = 0;
        const int ok = ibl_astc_hdr_decode_block(blocks + 16 * i, t);
        for (int k = 0; k < 48; k++) {
            const unsigned char *h = p + k / 3 * 8 + k % 3 * 2;
            const unsigned want = (unsigned)(h[0] | h[1] << 8);
            wrong += is_nan(want) ? !is_nan(t[k / 3][k % 3])
                                  : want != t[k / 3][k % 3];
        }
        if (!ok) {
            const halves none = {{0}};
            CHECK_MSG(i % 2 == 0 && !memcmp(t, none, sizeof t), "block %d", i);
            wrong = 0;
        }
        valid += ok;
        CHECK_MSG(!wrong, "block %d, valid %d: %d differ", i, ok, wrong);
    }
    CHECK(valid > BLOCKS / 2 && valid < BLOCKS * 6 / 10);
}

/* ---- kinds of blocks ----------------------------------------------------- */

typedef enum kind {
    CONSTANT,
    BLACK,
    RAMP, /* from 0.1 to 0.2 along x */
    GREY_SLOPE,
    SLOPE,
    CHECKER,
    BLACK_AND_WHITE,
    TWO_COLOURS,
    TWO_SIDES,
    SUN,
    SUN_AND_NOISE,
    SPREAD_SUN, /* what was too bright of red lies beside it */
    DENORMAL,
    NOISE,
    HUES,
    DECADES,
    LARGEST,
    KINDS
} kind;

static float level_of(test_random *r, double lowest, double highest)
{
    return (float)exp2(test_random_between(r, lowest, highest));
}

/* A colour of any hue. */
static void some_colour(test_random *r, double low, double high, float c[3])
{
    const float level = level_of(r, low, high);
    for (int i = 0; i < 3; i++)
        c[i] = level * (float)test_random_between(r, 0.1, 1);
}

static void make_block(test_random *r, kind of, texels t)
{
    float a[3], b[3], c[3];
    const int edge = test_random_below(r, 3) + 1, sun = test_random_below(r, N);
    const float x = (float)test_random_unit(r), y = 1 - x;
    const float dim = level_of(r, -9, 0);

    some_colour(r, -8, 8, a);
    some_colour(r, -8, 8, b);
    some_colour(r, -26, -14, c);
    for (int i = 0; i < N; i++)
        for (int k = 0; k < 3; k++) {
            const float at =
                (x * (float)(i % 4) + y * (float)(i / 4)) * (1.0f / 3);
            const float noise = (float)test_random_between(r, 0.9, 1.1);
            const float of_kind[KINDS] = {
                [CONSTANT] = a[k],
                [RAMP] = 0.1f + 0.1f / 3 * (float)(i % 4),
                [GREY_SLOPE] = a[0] * (1 + at),
                [SLOPE] = a[k] + (b[k] - a[k]) * at,
                [CHECKER] = (i ^ i / 4) & 1 ? a[k] : b[k],
                [BLACK_AND_WHITE] = (float)((i ^ i / 4) & 1),
                [TWO_COLOURS] = i < 8    ? k ? 0.25f : 0.5f
                                : k == 0 ? 0.01f
                                         : 0.04f,
                [TWO_SIDES] = (i % 4 < edge ? a[k] : b[k]) * noise,
                [SUN] = i == sun ? 60000 : 0.001f,
                [SUN_AND_NOISE] =
                    i == sun ? 6e4f : dim * (float)test_random_unit(r),
                [SPREAD_SUN] = i == sun                 ? 6e4f
                               : i / 4 == sun / 4 && !k ? 651
                                                        : a[k] * noise,
                [DENORMAL] = c[k] * noise,
                [NOISE] = (float)test_random_unit(r),
                [HUES] = a[k] * (float)test_random_between(r, 0.7, 1.4),
                [DECADES] = level_of(r, -24, 15.9),
                [LARGEST] = i % 3 ? IBL_ASTC_HDR_MAX : a[k],
            };
            t[i][k] = of_kind[of];
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

/* Whether UASTC HDR has it. */
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

/* ---- encoding ------------------------------------------------------------ */

/* What an error's square counts: see bc6h_encode.c and kern/astc_hdr.h. */
static void bc6h_shares(const double square[N], double most, double sum,
                        double share[N])
{
    (void)most;
    for (int i = 0; i < N; i++) {
        const double of = square[i] / (sum + 0x1p-28);
        share[i] = (1 + 512 * of * of) / (square[i] + 0x1p-32);
    }
}

static void astc_shares(const double square[N], double most, double sum,
                        double share[N])
{
    const double total = sum + 0x1p-60;
    for (int i = 0; i < N; i++)
        share[i] = 1 / (square[i] + ldexp(most * most, -34) + 0x1p-60) +
                   128 * square[i] / total / total;
}

static ibl_encode_blocks_fn *bc6h_encoder(ibl_isa isa)
{
    ibl_bc6h_dsp dsp;
    ibl_bc6h_dsp_init(&dsp, isa);
    return dsp.encode;
}

static ibl_encode_blocks_fn *astc_encoder(ibl_isa isa)
{
    ibl_astc_hdr_dsp dsp;
    ibl_astc_hdr_dsp_init(&dsp, isa);
    return dsp.encode;
}

static int any(const unsigned char *block)
{
    (void)block;
    return 1;
}

static const struct codec {
    const char *name;
    ibl_encode_blocks_fn *(*encoder)(ibl_isa isa);
    ibl_decode_block_fn *decode;
    void (*shares)(const double square[N], double most, double sum,
                   double share[N]);
    int (*allowed)(const unsigned char *block);
    /* Most that the light of a sun is off; 1 / 8 octave of BC6H's ends, twice
     * half of ASTC's, in blue, and that of its fast ones. */
    double sun[3];
    /* The root mean square of relative errors, of kinds that blocks nearly
     * have: BC6H's steps, 1/32 octave for a sun, ASTC's 16 levels of an octave
     * evenly spread. Two colours without a line need two regions. */
    double most[KINDS];
} codecs[] = {{"BC6H",
               bc6h_encoder,
               ibl_bc6h_decode_block,
               bc6h_shares,
               any,
               {0.1, 0.1, 0.1},
               {[RAMP] = 0.003,
                [BLACK_AND_WHITE] = 1e-9,
                [SUN] = 0.016,
                [TWO_COLOURS] = 0.008}},
              {"ASTC",
               astc_encoder,
               ibl_astc_hdr_decode_block,
               astc_shares,
               allowed,
               {0.189, 0.095, 0.095},
               {[RAMP] = 0.0143, [GREY_SLOPE] = 0.0143}}};

enum {
    CODECS = sizeof codecs / sizeof *codecs
};

static void find_shares(const struct codec *c, texels t, double share[N])
{
    double most = 0, sum = 0, square[N] = {0};
    for (int i = 0; i < 3 * N; i++) {
        const double v = (double)t[i / 3][i % 3];
        most = fmax(most, v);
        square[i / 3] += v * v;
        sum += v * v;
    }
    c->shares(square, most, sum, share);
}

static double off_of(texels t, halves d, int i)
{
    double off = 0;
    for (int k = 0; k < 3; k++) {
        const double e = (double)ibl_half_to_float(d[i][k]) - (double)t[i][k];
        off += e * e;
    }
    return off;
}

/* The error that the encoder minimises. */
static double error_of(const struct codec *c, texels t, halves d)
{
    double share[N], sum = 0;
    find_shares(c, t, share);
    for (int i = 0; i < N; i++)
        sum += off_of(t, d, i) * share[i];
    return sum;
}

/* The best block of one colour is the mean by the same weights. */
static void flat(const struct codec *c, texels t, halves d)
{
    double share[N];
    find_shares(c, t, share);
    for (int k = 0; k < 3; k++) {
        double sum = 0, all = 0;
        for (int i = 0; i < N; i++) {
            sum += (double)t[i][k] * share[i];
            all += share[i];
        }
        for (int i = 0; i < N; i++)
            d[i][k] = ibl_half_from_float((float)(sum / all));
    }
}

/* Root of the mean squared relative error of texels. */
static double relative(texels t, halves d)
{
    double sum = 0;
    for (int i = 0; i < N; i++) {
        const double off = off_of(t, d, i);
        double size = 0;
        for (int k = 0; k < 3; k++)
            size += (double)t[i][k] * (double)t[i][k];
        sum += off > 0 ? off / size : 0;
    }
    return sqrt(sum / N);
}

/* Encodes and decodes a block, which is one of the codec's and finite. */
static void round_trip(const struct codec *c, texels t, int quality, halves d)
{
    unsigned char block[BYTES];
    c->encoder(IBL_ISA_C)(&t[0][0], 1, (ibl_quality)quality, block);
    NEED(c->decode(block, d) && c->allowed(block));
    for (int i = 0; i < 3 * N; i++)
        CHECK(d[i / 3][i % 3] <= 0x7BFF);
}

/* Laws for each kind of block. */
TEST(each_kind)
{
    static const char *const qualities[] = {"fast", "normal", "best"};
    test_random r = {5};
    double sum[CODECS][KINDS][3] = {{{0}}}, errors[CODECS][KINDS][3] = {{{0}}};
    const int rounds = TEST_SANITIZED ? 3 : 100;
    for (int n = 0; n < rounds * CODECS * KINDS; n++) {
        const struct codec *c = &codecs[n / KINDS % CODECS];
        const kind of = (kind)(n % KINDS);
        texels t;
        halves d, even;
        double before = (double)INFINITY;
        make_block(&r, of, t);
        flat(c, t, even);
        for (int q = 0; q < 3; q++) {
            round_trip(c, t, q, d);
            const double error = error_of(c, t, d);
            const double rms = relative(t, d);
            const char *what =
                test_text("%s, %s, kind %d", c->name, qualities[q], of);
            CHECK_MSG(error <= error_of(c, t, even) * 1.0001 + 1e-8,
                      "%s: error %g, %g of one colour", what, error,
                      error_of(c, t, even));
            /* BC6H's next quality tries what the one before it does. */
            CHECK_MSG(c != codecs || error <= before * 1.0001,
                      "%s: error %g, %g of the lower quality", what, error,
                      before);
            before = error;
            if (of == CONSTANT || of == BLACK)
                CHECK_MSG(!memcmp(d, even, sizeof d), "%s", what);
            sum[n / KINDS % CODECS][of][q] += rms * rms;
            errors[n / KINDS % CODECS][of][q] += error;
            for (int i = 0; i < 3 * N && (of == SUN || of == SUN_AND_NOISE ||
                                          of == SPREAD_SUN);
                 i++) {
                const double light = (double)t[i / 3][i % 3];
                const double got = (double)ibl_half_to_float(d[i / 3][i % 3]);
                CHECK_MSG(light < 5e4 || fabs(got / light - 1) <= c->sun[q],
                          "%s: a sun of %g", what, got);
            }
        }
    }
    for (int n = 0; n < 3 * CODECS * KINDS; n++) {
        const int c = n / 3 / KINDS, of = n / 3 % KINDS, q = n % 3;
        const double rms = sqrt(sum[c][of][q] / rounds);
        if (codecs[c].most[of] > 0 &&
            (q || (of != TWO_COLOURS && of != GREY_SLOPE)))
            CHECK_MSG(rms <= codecs[c].most[of], "%s, %s, kind %d: %g",
                      codecs[c].name, qualities[q], of, rms);
        /* What ASTC's regions are for. */
        if (c == 1 && q && !TEST_SANITIZED && (of == HUES || of == TWO_SIDES))
            CHECK_MSG(errors[c][of][q] < 0.99 * errors[c][of][q - 1],
                      "%s, %s, kind %d: %g, %g of the lower quality",
                      codecs[c].name, qualities[q], of, errors[c][of][q],
                      errors[c][of][q - 1]);
    }
}

/* Halves as blocks of one colour: exact. To BC6H -0 is 0. */
TEST(constant)
{
    for (int n = 0; n < 3 * CODECS; n++)
        for (int h = 0; h <= 0x7BFF; h += n % 3 ? 97 : 3) {
            const struct codec *c = &codecs[n / 3];
            texels t;
            halves d;
            for (int i = 0; i < 3 * N; i++)
                t[i / 3][i % 3] =
                    fminf(ibl_half_to_float((uint16_t)(i % 3 == 0   ? h
                                                       : i % 3 == 1 ? 0x7BFF - h
                                                                    : h / 2)),
                          n < 3 ? IBL_BC6H_MAX : IBL_ASTC_HDR_MAX);
            if (!h && n < 3)
                t[3][0] = -0.0f;
            round_trip(c, t, n % 3, d);
            for (int i = 0; i < 3 * N; i++)
                CHECK_MSG(ibl_half_to_float(d[i / 3][i % 3]) == t[i / 3][i % 3],
                          "%s, quality %d: %04x", c->name, n % 3, h);
        }
}

/* n blocks, each of another kind and quality. */
static size_t encode(int codec, ibl_isa isa, test_random *r, int n, void *out)
{
    texels *t = kern_alloc((size_t)n * sizeof *t, sizeof(float));
    for (int i = 0; i < n; i++)
        make_block(r, (kind)test_random_below(r, KINDS), t[i]);
    codecs[codec].encoder(isa == IBL_ISA_AUTO ? IBL_ISA_C : isa)(
        &t[0][0][0], (size_t)n, (ibl_quality)(n % 3), out);
    kern_free(t);
    return 0;
}

static size_t encode_bc6h(ibl_isa isa, test_random *r, int n, void *out)
{
    return encode(0, isa, r, n, out);
}

static size_t encode_astc(ibl_isa isa, test_random *r, int n, void *out)
{
    return encode(1, isa, r, n, out);
}

TEST(same_bytes)
{
    static const int longest = TEST_SANITIZED ? 6 : 16;
    static const kern_same k[] = {
        {"BC6H", encode_bc6h, BYTES, 1, longest, 20, 0, false},
        {"ASTC", encode_astc, BYTES, 1, longest, 4, 0, false}};
    kern_check_same(&k[0]);
    kern_check_same(&k[1]);
}

/* BC6H of noise of a percent: the differences of endpoints use all their bits,
 * so that they cannot always be exchanged for an anchor's sake. */
TEST(anchors)
{
    test_random r = {4};
    for (int k = 0; k < (TEST_SANITIZED ? 100 : 1000); k++) {
        const double noise = test_random_between(&r, 0.003, 0.03);
        texels t;
        halves d[2];
        for (int i = 0; i < 3 * N; i++)
            t[i / 3][i % 3] =
                (float)test_random_between(&r, 1 - noise, 1 + noise);
        round_trip(codecs, t, IBL_QUALITY_NORMAL, d[0]);
        round_trip(codecs, t, IBL_QUALITY_BEST, d[1]);
        const double e = error_of(codecs, t, d[1]);
        const double at = error_of(codecs, t, d[0]);
        CHECK_MSG(e <= at * 1.1, "block %d: %g, normal %g", k, e, at);
    }
}

/* ASTC of sixteen denormal halves in even steps of 13 units: a line has them
 * all, but for the rounding of its ends and weights. */
static void denormal_slope_of(ibl_isa isa)
{
    texels t;
    halves d;
    unsigned char block[BYTES];
    for (int i = 0; i < 3 * N; i++)
        t[i / 3][i % 3] = (float)(200 + 13 * (i / 3)) * 0x1p-24f;
    astc_encoder(isa)(&t[0][0], 1, IBL_QUALITY_NORMAL, block);
    ibl_astc_hdr_decode_block(block, d);
    for (int i = 0; i < 3 * N; i++)
        CHECK_MSG(abs(d[i / 3][i % 3] - (200 + 13 * (i / 3))) < 13, "%d %d", i,
                  d[i / 3][i % 3]);
}

KERN_TEST(denormal_slope)

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
static double error_as_bc6h(const float *rgb, const unsigned char *block)
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
    ibl_astc_load(rgb, &t[0]);
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
        float rgb[48];
        uint16_t d[16][3];
        set_bytes(blocks[i][0], astc);
        set_bytes(blocks[i][1], bc6h);
        NEED(ibl_bc6h_decode_block(bc6h, d));
        for (int k = 0; k < 48; k++)
            rgb[k] = ibl_half_to_float(d[k / 3][k % 3]);
        const double error = error_as_bc6h(rgb, astc);
        CHECK_MSG(error == 0, "block %zu: %g", i, error);
    }
}

enum {
    ALIKE_BLOCKS = 900
};

/* Blocks alike are of UASTC HDR, repeat the last 8 bytes of one before, and
 * lose no more than they may. */
TEST(alike)
{
    static texels t[ALIKE_BLOCKS];
    static unsigned char plain[16 * ALIKE_BLOCKS], alike[16 * ALIKE_BLOCKS];
    static ibl_astc_past past;
    test_random r = {11};
    ibl_astc_hdr_dsp dsp;
    double whole = 0, lost = 0;
    int others = 0;
    ibl_astc_hdr_dsp_init(&dsp, IBL_ISA_C);
    for (int n = 0; n < ALIKE_BLOCKS; n++)
        make_block(&r, n & 1 ? SLOPE : HUES, t[n]);
    dsp.encode(&t[0][0][0], ALIKE_BLOCKS, IBL_QUALITY_NORMAL, plain);
    dsp.encode_alike(&t[0][0][0], ALIKE_BLOCKS, IBL_QUALITY_NORMAL, &past,
                     alike);
    for (int n = 0; n < ALIKE_BLOCKS; n++) {
        const unsigned char *a = plain + 16 * n, *b = alike + 16 * n;
        bool repeats = false;
        CHECK(allowed(b));
        if (!memcmp(a, b, 16))
            continue;
        halves d[2];
        ibl_astc_hdr_decode_block(a, d[0]);
        ibl_astc_hdr_decode_block(b, d[1]);
        whole += error_of(&codecs[1], t[n], d[0]);
        lost += error_of(&codecs[1], t[n], d[1]);
        for (int i = 0; i < n && !repeats; i++)
            repeats = !memcmp(alike + 16 * i + 8, b + 8, 8);
        CHECK(repeats);
        others++;
    }
    CHECK_MSG(lost < whole * (1 + IBL_ASTC_ALIKE_LOSS), "%g, %g", lost, whole);
    CHECK_MSG(others > ALIKE_BLOCKS / 4 && others < ALIKE_BLOCKS * 0.7, "%d",
              others);
}
