/* SPDX-License-Identifier: MIT */
/*
 * The Radiance reader against an encoder of every variant written here;
 * check_exr compares it with OpenImageIO.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "files.h"
#include "test.h"

#define R "#?RADIANCE\n"
#define FORMAT "FORMAT=32-bit_rle_rgbe\n"
#define PIXEL "\n-Y 1 +X 1\n"
#define HEADER R FORMAT "\n"

/* ---- the encoder ---------------------------------------------------- */

typedef struct file {
    char *data;
    size_t size;
} file;

typedef enum coding {
    FLAT,
    NEW,
    MIXED, /* each scanline another */
    CODINGS
} coding;

static const char *const orientations[8] = {
    "-Y %d +X %d", "-Y %d -X %d", "+Y %d +X %d", "+Y %d -X %d",
    "+X %d -Y %d", "+X %d +Y %d", "-X %d -Y %d", "-X %d +Y %d"};

static test_random rng = {4};

static int below(int n)
{
    return test_random_below(&rng, n);
}

static void put_new(FILE *f, const unsigned char *px, int n)
{
    fwrite((unsigned char[]){2, 2, (unsigned char)(n >> 8), (unsigned char)n},
           1, 4, f);
    for (int c = 0; c < 4; c++) {
        for (int i = 0; i < n;) {
            int run = 1, raw = 0;
            while (run < 127 && i + run < n &&
                   px[4 * (i + run) + c] == px[4 * i + c])
                run++;
            if (run > 2) {
                fputc(128 + run, f);
                fputc(px[4 * i + c], f);
                i += run;
                continue;
            }
            while (raw < 128 && i + raw < n &&
                   !(i + raw + 2 < n &&
                     px[4 * (i + raw) + c] == px[4 * (i + raw + 1) + c] &&
                     px[4 * (i + raw) + c] == px[4 * (i + raw + 2) + c]))
                raw++;
            raw += !raw;
            fputc(raw, f);
            for (; raw; raw--, i++)
                fputc(px[4 * i + c], f);
        }
    }
}

/* A w x h picture, top row first in px. */
static file encode(coding kind, const char *orientation,
                   const unsigned char *px, int w, int h)
{
    const bool by_column = orientation[1] == 'X';
    const bool y_up = strstr(orientation, "+Y") != NULL;
    const bool x_down = strstr(orientation, "-X") != NULL;
    const int rows = by_column ? w : h, length = by_column ? h : w;
    unsigned char *row = malloc(4 * (size_t)length);
    file made = {0};
    FILE *f = open_memstream(&made.data, &made.size);

    NEED(f && row);
    /* the formats are the eight above */
    fprintf(f, HEADER "%.2s %d %.2s %d\n", orientation, rows, orientation + 6,
            length);
    for (int k = 0; k < rows; k++) {
        for (int j = 0; j < length; j++) {
            int x = by_column ? k : j, y = by_column ? j : k;
            x = x_down ? w - 1 - x : x;
            y = y_up ? h - 1 - y : y;
            memcpy(row + 4 * j, px + 4 * (y * w + x), 4);
        }
        const coding as = kind == MIXED ? (coding)below(MIXED) : kind;
        if (as == NEW && length >= 8 && length <= 32767)
            put_new(f, row, length);
        else
            fwrite(row, 4, (size_t)length, f);
    }
    fclose(f);
    free(row);
    test_defer(free, made.data);
    return made;
}

/* Normalised pixels as an encoder writes them, with repeats and blacks. */
static unsigned char *picture(int w, int h)
{
    unsigned char *px = test_alloc((size_t)w * (size_t)h, 4);
    int repeat = 0;
    for (int i = 0; i < w * h; i++) {
        unsigned char *p = px + 4 * i;
        if (i && repeat-- > 0) {
            memcpy(p, p - 4, 4);
            continue;
        }
        for (int c = 0; c < 4; c++)
            p[c] = (unsigned char)below(256);
        p[below(3)] |= 128;
        if (below(20) == 0)
            memset(p, 0, 4);
        if (below(3) == 0)
            repeat = below(below(8) ? 12 : 1000);
    }
    return px;
}

/* ---- the decoder ---------------------------------------------------- */

static test_messages kept;

/* Decodes a copy of exactly size bytes, so that a read beyond is seen. */
static ibl_status decode(ibl_ctx *ctx, const void *bytes, size_t size,
                         ibl_image *img)
{
    unsigned char *copy = malloc(size ? size : 1);
    ibl_read_options opts = ibl_read_options_default();

    memcpy(copy, bytes, size);
    memset(&kept, 0, sizeof kept);
    *img = (ibl_image){0};
    opts.any_aspect = 1;
    const ibl_status status =
        ibl_image_decode(ctx, "test.hdr", copy, size, &opts, img, NULL);
    free(copy);
    return status;
}

static void check_file(ibl_ctx *ctx, const file *f, size_t more,
                       const unsigned char *px, int w, int h, const char *what)
{
    ibl_image img;
    const ibl_status status = decode(ctx, f->data, f->size + more, &img);
    int wrong = 0;

    CHECK_MSG(!status, "%s: %s", what, kept.text[IBL_LOG_ERROR]);
    if (status)
        return;
    CHECK_MSG(img.width == w && img.height == h, "%s: %dx%d", what, img.width,
              img.height);
    for (int i = 0; i < 3 * w * h; i++) {
        const unsigned char *p = px + i / 3 * 4;
        wrong +=
            img.data[i] != (p[3] ? (float)ldexp(p[i % 3], p[3] - 136) : 0.0f);
    }
    CHECK_MSG(!wrong, "%s, %dx%d: %d components wrong", what, w, h, wrong);
    ibl_image_free(&img);
}

/* One also with a byte after the last pixel. */
TEST(every_variant)
{
    static const int sizes[][2] = {
        {1, 1},   {1, 9},    {9, 1},     {7, 5},     {8, 8},     {13, 30},
        {40, 17}, {300, 20}, {21, 700},  {2, 3},     {3, 3},     {15, 3},
        {127, 3}, {128, 3},  {129, 3},   {255, 3},   {256, 3},   {257, 3},
        {511, 3}, {1000, 3}, {32767, 3}, {32768, 3}, {65535, 3}, {65536, 3}};
    ibl_ctx *ctxs[IBL_ISA_COUNT + 1] = {0};
    int n = 0;

    for (ibl_isa isa = IBL_ISA_C; isa < IBL_ISA_COUNT;
         isa = test_next_isa(isa)) {
        ibl_ctx_options opts = ibl_ctx_options_default();
        opts.threads = 1;
        opts.isa = isa;
        opts.log = test_keep;
        opts.log_cookie = &kept;
        ctxs[n++] = test_ctx_of(&opts);
    }
    ctxs[n++] = test_keeping_ctx(2, &kept);
    for (size_t s = 0; s < sizeof sizes / sizeof *sizes; s++) {
        const int w = sizes[s][0], h = sizes[s][1];
        unsigned char *px = picture(w, h);
        for (int i = 0; i < 8 * CODINGS; i += TEST_RACES       ? 5
                                              : TEST_SANITIZED ? 3
                                                               : 1) {
            const coding kind = (coding)(i % CODINGS);
            const char *orientation = orientations[w > 300 ? 0 : i / CODINGS];
            const file f = encode(kind, orientation, px, w, h);
            if (w > 300 && i >= CODINGS)
                break;
            for (int c = 0; c < n; c++)
                check_file(ctxs[c], &f, c == 0, px, w, h, orientation);
        }
    }
}

/* ---- headers -------------------------------------------------------- */

/* Decodes one flat pixel (128, 64, 32, 129) = (1, .5, .25) under a header. */
static ibl_status one_pixel(ibl_ctx *ctx, const char *header, float rgb[3])
{
    const char *text = test_text("%s\200\100\040\201", header);
    ibl_image img;
    const ibl_status status = decode(ctx, text, strlen(text), &img);

    if (!status)
        memcpy(rgb, img.data, 3 * sizeof *rgb);
    ibl_image_free(&img);
    return status;
}

TEST(headers)
{
    static const struct {
        const char *text, *warning;
        double factor[3]; /* 0: 1, 1, 1 */
    } cases[] = {
        {R FORMAT PIXEL, NULL, {0}},
        {"#?RGBE\n" FORMAT PIXEL, NULL, {0}},
        {"#?AUTOPANO\r\nFORMAT=32-bit_rle_rgbe\r\n\r\n-Y 1 +X 1\r\n",
         NULL,
         {0}},
        {R PIXEL, "no FORMAT", {0}},
        {R FORMAT "-Y 1 +X 1\n", NULL, {0}},
        {R "FORMAT = 32-bit_rle_rgbe \n\n+X   1\t+Y 1  \n", NULL, {0}},
        /* any order, comments, unknown variables, cumulative factors */
        {R "# EXPOSURE=9\nEXPOSURE=2\nVIEW= -vtv\nrpict -x "
           "1\nPIXASPECT=0.5\nCOLORCORR=.5 1 2\n" FORMAT
           "EXPOSURE= 4e0\nSOFTWARE=EXPOSURE=3\nCOLORCORR= 1 4 1.0e+0 "
           "\nPRIMARIES=0 0 0 0 0 0 0 0\n" PIXEL,
         NULL,
         {1 / 4., 1 / 32., 1 / 16.}},
        /* the history of another picture is indented, and is not this one's */
        {R "\tEXPOSURE=2\n EXPOSURE=2\nEXPOSURE=0.5\n" FORMAT PIXEL,
         NULL,
         {2, 2, 2}},
        {R "EXPOSURE=0\nEXPOSURE=2\n" FORMAT PIXEL,
         "EXPOSURE of 0",
         {.5, .5, .5}},
        {R "EXPOSURE=0e9999\nEXPOSURE=2\n" FORMAT PIXEL,
         "EXPOSURE of 0",
         {.5, .5, .5}},
        {R "EXPOSURE=0.000244140625000000000000000\n" FORMAT PIXEL,
         NULL,
         {4096, 4096, 4096}},
        {R "EXPOSURE=12345678901234567890123e-20\n" FORMAT PIXEL,
         NULL,
         {1 / 123.45678901234567890123, 1 / 123.45678901234567890123,
          1 / 123.45678901234567890123}},
    };
    ibl_ctx *ctx = test_keeping_ctx(1, &kept);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        const char *want = cases[i].warning, *got = kept.text[IBL_LOG_WARNING];
        float rgb[3] = {0};
        CHECK_MSG(!one_pixel(ctx, cases[i].text, rgb), "case %zu: %s", i,
                  kept.text[IBL_LOG_ERROR]);
        for (int c = 0; c < 3; c++) {
            const double f = cases[i].factor[c];
            CHECK_MSG(rgb[c] == (float)((f > 0 ? f : 1) / (1 << c)),
                      "case %zu: %g", i, (double)rgb[c]);
        }
        CHECK_MSG(want ? strstr(got, want) != NULL : !*got,
                  "case %zu warns \"%s\"", i, got);
    }
}

/* Of any length. */
TEST(long_header)
{
    enum {
        MORE = 900000
    };
    char *text = test_alloc(MORE + 200, 1);
    float rgb[3] = {0};

    memset(text, '\t', MORE);
    memcpy(text, R FORMAT, sizeof R FORMAT - 1);
    strcpy(text + MORE, "\n" PIXEL);
    for (int i = 200; i < MORE; i += 100)
        text[i - 1] = '\n';
    CHECK(!one_pixel(test_keeping_ctx(1, &kept), text, rgb) && rgb[2] == .25f);
}

/* ---- damage --------------------------------------------------------- */

TEST(damaged)
{
#define V R FORMAT
#define B(text) text, sizeof text - 1
    static const struct {
        const char *bytes;
        size_t size;
        const char *needle;
    } cases[] = {
        {B(V "\n"), "ends in its header"},
        {B(V "\n-Y 2 +X 2"), "ends in its header"},
        {B(V "\n-Y 2 +X 2\n"), "cannot hold 2 scanlines"},
        {B(V "\n-Y 0 +X 2\nabcd"), "1 to 65536"},
        {B(V "\n-Y -2 +X 2\nabcd"), "1 to 65536"},
        {B(V "\n-Y 65537 +X 2\nabcd"), "1 to 65536"},
        {B(V "\n-Y 2 +X 999999999999999999999999999999\nabcd"), "must be like"},
        {B(V "\n-Y 0e9999 +X 10\nabcd"), "must be like"},
        {B(V "\n-Y 2\nabcd"), "must be like"},
        {B(V "\n-Y 2 -Y 2\nabcd"), "must be like"},
        {B(V "\n-Y 2 +X 2 +Z 2\nabcd"), "must be like"},
        {B(V "\n-Y 2 X 2\nabcd"), "must be like"},
        {B(V "\nY 2 X 2\nabcdabcdabcdabcd"), "must be like"},
        {B(V "\n\1\2\3\377\n-Y 2 +X 2\nabcdabcdabcdabcd"), "\"????\""},
        {B(V "EXPOSURE=-0.5\n" PIXEL "abcd"), "EXPOSURE is \"-0.5\""},
        {B(V "EXPOSURE=\n" PIXEL "abcd"), "EXPOSURE"},
        {B(V "EXPOSURE=1e999\n" PIXEL "abcd"), "EXPOSURE"},
        {B(V "EXPOSURE=nan\n" PIXEL "abcd"), "EXPOSURE"},
        {B(V "EXPOSURE=1e30\nEXPOSURE=1e30\n" PIXEL "abcd"), "multiply"},
        {B(V "COLORCORR=1 1\n" PIXEL "abcd"), "COLORCORR"},
        {B(R "FORMAT=32-bit_rle_rgbex\n" PIXEL "abcd"), "32-bit_rle_rgbex"},
        {B("#?RADIANCE\nFORMAT=\n" PIXEL "abcd"), "FORMAT"},
        /* new run lengths */
        {B(V "\n-Y 1 +X 8\n\2\2\0\10\0"
             "and some more"),
         "are not its 8 pixels"},
        {B(V "\n-Y 1 +X 8\n\2\2\0\10\211a"
             "and some more"),
         "are not its 8 pixels"},
        {B(V "\n-Y 1 +X 8\n\2\2\0\10\11abcdefghi"), "are not its 8 pixels"},
        {B(V "\n-Y 1 +X 8\n\2\2\0\10\210a\210a\210a\7a"), "scanline 1 of 1"},
        {B(V "\n-Y 1 +X 8\n\2\2\0\11\210a\210a\210a\210a"),
         "are not its 8 pixels"},
        {B(V "\n-Y 2 +X 8\n\2\2\0\10\210a\210a\210a\4abcd\4abcd\2\2\0\10"),
         "scanline 2 of 2"},
        {B(V "\n-Y 1 +X 8\n\2\2\0\10\377aaaaaaa"), "are not its 8 pixels"},
        /* those of before 1991, and another coding */
        {B(V "\n-Y 1 +X 8\nabcd\1\1\1\7abcdabcd"), "before 1991"},
        {B(R "FORMAT=32-bit_rle_xyze\n" PIXEL "abcd"), "ra_xyze"},
        {B(V "\n-Y 65536 +X 65536\nabcdefgh"), "cannot hold 65536 scanlines"},
        {B(V "\n-Y 2 +X 65536\nabcdefghijkl"), "cannot hold 2 scanlines"},
    };
    ibl_ctx *ctx = test_keeping_ctx(1, &kept);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        ibl_image img;
        const char *text = kept.text[IBL_LOG_ERROR];
        const ibl_status status =
            decode(ctx, cases[i].bytes, cases[i].size, &img);
        CHECK_MSG(status && !img.data && !strncmp(text, "test.hdr: ", 10) &&
                      strstr(text, cases[i].needle) && !strchr(text, '\n') &&
                      strlen(text) < 200,
                  "\"%s\" lacks \"%s\"", text, cases[i].needle);
    }
}
