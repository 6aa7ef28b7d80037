/* SPDX-License-Identifier: MIT */
/*
 * Primaries, exposure, clamp, and what a report says of a map's light. The
 * matrices are those that others publish: ITU-R BT.2087 (table of BT.2020 to
 * BT.709), and of AP1 those of the ACES configurations of OpenColorIO.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <xxhash.h>

#include "files.h"
#include "ibl/io.h"
#include "io/colour_space.h"
#include "test.h"

static test_messages kept;

static const double rec709_of_2020[9] = {1.6604910,  -0.5876411, -0.0728499,
                                         -0.1245505, 1.1328999,  -0.0083494,
                                         -0.0181508, -0.1005789, 1.1187297};
static const double rec709_of_acescg[9] = {
    1.7050509926,  -0.6217921205, -0.0832588720, -0.1302564175, 1.1408047365,
    -0.0105483191, -0.0240033568, -0.1289689761, 1.1529723329};
static const double rec2020_line[8] = {.708, .292, .17,   .797,
                                       .131, .046, .3127, .329};
static const double acescg_line[8] = {.713, .293, .165,   .83,
                                      .128, .044, .32168, .33767};

/* A flat .hdr of width x width / 2 pixels of random colours, or of one. */
static size_t make_hdr(unsigned char *bytes, int width, const char *lines,
                       const unsigned char *pixel)
{
    test_random r = {7};
    size_t n = (size_t)sprintf((char *)bytes,
                               "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n%s\n-Y %d "
                               "+X %d\n",
                               lines, width / 2, width);
    for (int i = 0; i < width * width / 2; i++, n += 4)
        for (int c = 0; c < 4; c++)
            bytes[n + (size_t)c] =
                (unsigned char)(pixel    ? pixel[c]
                                : c == 3 ? 126 + i % 5
                                         : 128 + test_random_below(&r, 64));
    return n;
}

static const char *primaries_line(const double xy[8])
{
    return test_text("PRIMARIES= %.5f %.5f %.5f %.5f %.5f %.5f %.5f %.5f\n",
                     xy[0], xy[1], xy[2], xy[3], xy[4], xy[5], xy[6], xy[7]);
}

static ibl_image read_hdr(ibl_ctx *ctx, const void *bytes, size_t size,
                          const ibl_read_options *o, ibl_read_report *report)
{
    ibl_image img = {0};
    memset(&kept, 0, sizeof kept);
    NEED(!ibl_image_decode(ctx, "m.hdr", bytes, size, o, &img, report));
    return test_image(img);
}

static void check_matrix(const double xy[8], ibl_primaries to,
                         const double m[9], const char *name, double bound)
{
    static unsigned char bytes[8192];
    ibl_ctx *ctx = test_keeping_ctx(2, &kept);
    ibl_read_options o = ibl_read_options_default();
    ibl_read_report report;
    const size_t size = make_hdr(bytes, 32, primaries_line(xy), NULL);
    const ibl_image was = read_hdr(ctx, bytes, size, &o, &report);

    CHECK(report.has_primaries && !strcmp(report.primaries_name, name));
    CHECK(strstr(kept.text[IBL_LOG_WARNING], name));
    o.primaries = to;
    const ibl_image is = read_hdr(ctx, bytes, size, &o, &report);
    CHECK(!*kept.text[IBL_LOG_WARNING] && !report.outside);
    for (int i = 0; i < 32 * 16; i++) {
        const float *p = was.data + 3 * i;
        for (int c = 0; c < 3; c++)
            CHECK_NEAR((double)is.data[3 * i + c],
                       m[3 * c] * (double)p[0] + m[3 * c + 1] * (double)p[1] +
                           m[3 * c + 2] * (double)p[2],
                       bound * (double)p[0]);
    }
}

TEST(rec2020_is_converted)
{
    check_matrix(rec2020_line, IBL_PRIMARIES_REC709, rec709_of_2020, "Rec.2020",
                 3e-6);
}

/* Bradford's adaptation from the white of ACES to D65. */
TEST(acescg_is_converted)
{
    check_matrix(acescg_line, IBL_PRIMARIES_REC709, rec709_of_acescg, "ACEScg",
                 3e-5);
}

/* White stays white and two ways are one, whatever the white points. */
TEST(white_stays_white)
{
    for (int from = IBL_PRIMARIES_REC709; from <= IBL_PRIMARIES_REC2020; from++)
        for (int to = IBL_PRIMARIES_REC709; to <= IBL_PRIMARIES_REC2020; to++) {
            double m[9], back[9];
            const double *a = ibl_primaries_xy((ibl_primaries)from);
            const double *b = ibl_primaries_xy((ibl_primaries)to);
            NEED(ibl_colour_matrix(a, b, m, NULL));
            NEED(ibl_colour_matrix(b, a, back, NULL));
            for (int i = 0; i < 3; i++) {
                CHECK_NEAR(m[3 * i] + m[3 * i + 1] + m[3 * i + 2], 1, 1e-12);
                for (int j = 0; j < 3; j++)
                    CHECK_NEAR(m[3 * i] * back[j] + m[3 * i + 1] * back[3 + j] +
                                   m[3 * i + 2] * back[6 + j],
                               i == j, 1e-12);
            }
        }
}

/* A red of Rec.2020 is 1.6605 -0.1246 -0.0182 in Rec.709: outside. It keeps its
 * luminance, 0.2627, and its least component becomes 0. */
TEST(colours_outside_keep_their_luminance)
{
    static unsigned char bytes[4096];
    const unsigned char red[4] = {128, 0, 0, 129};
    ibl_ctx *ctx = test_keeping_ctx(1, &kept);
    ibl_read_options o = {.part = -1, .primaries = IBL_PRIMARIES_REC709};
    ibl_read_report report;
    const ibl_image img = read_hdr(
        ctx, bytes, make_hdr(bytes, 16, primaries_line(rec2020_line), red), &o,
        &report);
    const double unit =
        (double)img.data[0] /
        (.2627002 + .2627002 / (.2627002 + .1245505) * (1.6604910 - .2627002));
    CHECK_NEAR(unit, 1, 0.01); /* RGBE decodes 128 / 256 or 128.5 / 256 */
    CHECK_NEAR((double)img.data[1], 0, 1e-6);
    CHECK_NEAR((double)img.data[2] / unit,
               .2627002 +
                   .2627002 / (.2627002 + .1245505) * (-.0181508 - .2627002),
               2e-6);
    CHECK(report.outside == 128);
    CHECK(strstr(kept.text[IBL_LOG_WARNING],
                 "128 pixels were outside the gamut "
                 "of rec709"));
    CHECK(report.negative == 0);
}

TEST(rec709_is_left_alone)
{
    static unsigned char bytes[4096];
    ibl_ctx *ctx = test_keeping_ctx(1, &kept);
    ibl_read_options o = ibl_read_options_default();
    ibl_read_report report;
    const double line[8] = {.64, .33, .3, .6, .15, .06, .3127, .329};
    size_t size = make_hdr(bytes, 16, "", NULL);
    const ibl_image plain = read_hdr(ctx, bytes, size, &o, &report);

    CHECK(!report.has_primaries && !strcmp(report.primaries_name, "Rec.709"));
    CHECK_NEAR(report.luma[1], 0.7152, 1e-4);
    size = make_hdr(bytes, 16, primaries_line(line), NULL);
    for (int to = 0; to < 2; to++) {
        o.primaries = to ? IBL_PRIMARIES_REC709 : IBL_PRIMARIES_KEEP;
        const ibl_image img = read_hdr(ctx, bytes, size, &o, &report);
        CHECK(report.has_primaries && !*kept.text[IBL_LOG_WARNING]);
        CHECK(!memcmp(img.data, plain.data, 3 * sizeof(float) * 16 * 8));
    }
}

TEST(primaries_of_no_triangle)
{
    static unsigned char bytes[4096];
    ibl_ctx *ctx = test_keeping_ctx(1, &kept);
    ibl_read_options o = ibl_read_options_default();
    ibl_read_report report;
    const size_t size =
        make_hdr(bytes, 16, "PRIMARIES= .3 .3 .3 .3 .3 .3 .3 .3\n", NULL);

    read_hdr(ctx, bytes, size, &o, &report);
    CHECK(!report.has_primaries && !strcmp(report.primaries_name, "Rec.709"));
}

/* A power of two leaves every bit of a fraction. */
TEST(exposure_is_exact)
{
    static unsigned char bytes[4096];
    ibl_ctx *ctx = test_keeping_ctx(3, &kept);
    ibl_read_options o = ibl_read_options_default();
    ibl_read_report report;
    const size_t size = make_hdr(bytes, 16, "", NULL);
    const ibl_image was = read_hdr(ctx, bytes, size, &o, &report);

    o.exposure = -3;
    const ibl_image is = read_hdr(ctx, bytes, size, &o, &report);
    for (int i = 0; i < 3 * 16 * 8; i++)
        CHECK(is.data[i] * 8 == was.data[i]);
    o.exposure = 0.5;
    const ibl_image half = read_hdr(ctx, bytes, size, &o, &report);
    CHECK_NEAR((double)half.data[5], sqrt(2) * (double)was.data[5], 1e-6);
    o.exposure = 65;
    ibl_image img;
    CHECK(ibl_image_decode(ctx, "m", bytes, size, &o, &img, NULL) ==
          IBL_ERR_ARGUMENT);
    o = (ibl_read_options){.part = -1, .clamp = -1};
    CHECK(ibl_image_decode(ctx, "m", bytes, size, &o, &img, NULL) ==
          IBL_ERR_ARGUMENT);
}

/* A grey map with a lamp of a row's 3 pixels, whose light is known. */
static ibl_image lamp_map(ibl_ctx *ctx, const float lamp[3], int row, int x)
{
    ibl_image img;
    NEED(!ibl_image_alloc(ctx, 64, 32, &img));
    test_image(img);
    for (int i = 0; i < 3 * 64 * 32; i++)
        img.data[i] = 0.25f;
    for (int k = 0; k < 3; k++)
        memcpy(img.data + 3 * (64 * row + (x + k) % 64), lamp,
               3 * sizeof *lamp);
    return img;
}

static double solid_angle(int row)
{
    return 2 * M_PI / 64 * (cos(M_PI * row / 32) - cos(M_PI * (row + 1) / 32));
}

TEST(clamp_keeps_hue_and_tells_what_it_took)
{
    ibl_ctx *ctx = test_keeping_ctx(2, &kept);
    const float lamp[3] = {100, 50, 25};
    const ibl_image img = lamp_map(ctx, lamp, 9, 63);
    ibl_read_options o = {.part = -1, .clamp = 20, .exposure = 1};
    ibl_read_report report;
    ibl_image is;

    NEED(file_save_exr(file_path("lamp.exr"), &img, NULL));
    memset(&kept, 0, sizeof kept);
    NEED(!ibl_image_read(ctx, file_path("lamp.exr"), &o, &is, &report));
    test_image(is);
    const float *p = is.data + 3 * (64 * 9);
    CHECK(p[0] == 20 && p[1] == 10 && p[2] == 5 && is.data[0] == 0.5f);
    CHECK(report.clamped == 3 && report.peak == 100);
    const double y = .2126390 * 100 + .7151687 * 50 + .0721923 * 25;
    const double lamps = 3 * solid_angle(9);
    const double all = lamps * y * 2 + (4 * M_PI - lamps) * .5;
    CHECK_NEAR(report.clamp_removed, lamps * y * 2 * .9 / all, 1e-6);
    CHECK(strstr(kept.text[IBL_LOG_WARNING], "3 pixels were above 20"));
}

TEST(hash_of_the_file)
{
    static unsigned char bytes[600000];
    ibl_ctx *ctx = test_keeping_ctx(2, &kept);
    const ibl_read_options o = {.part = -1, .hash = 1};
    const size_t size = make_hdr(bytes, 512, "", NULL);
    const XXH128_hash_t h = XXH3_128bits(bytes, size);
    const char *want = test_text("%016llx%016llx", (unsigned long long)h.high64,
                                 (unsigned long long)h.low64);
    ibl_read_report report;

    read_hdr(ctx, bytes, size, &o, &report);
    CHECK(!strcmp(report.hash, want));
    NEED(file_save(file_path("a.hdr"), bytes, size));
    ibl_image img;
    NEED(!ibl_image_read(ctx, file_path("a.hdr"), &o, &img, &report));
    ibl_image_free(&img);
    CHECK(!strcmp(report.hash, want));
    NEED(!ibl_image_read(ctx, file_path("a.hdr"), NULL, &img, &report));
    ibl_image_free(&img);
    CHECK(!*report.hash);
}
