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
#include "maps.h"
#include "truth.h"

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

enum {
    W = 32,
    H = 16
};

static ibl_read_report report; /* of the last file */

/* Reads a flat .hdr of random colours, or of one. */
static ibl_image read_hdr(const char *lines, const unsigned char *pixel,
                          const ibl_read_options *o)
{
    static unsigned char bytes[8192];
    test_random r = {7};
    ibl_image img = {0};
    size_t n = (size_t)sprintf((char *)bytes,
                               "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n%s\n-Y %d "
                               "+X %d\n",
                               lines, H, W);

    for (int i = 0; i < 4 * W * H; i++)
        bytes[n++] =
            (unsigned char)(pixel        ? pixel[i % 4]
                            : i % 4 == 3 ? 126 + i / 4 % 5
                                         : 128 + test_random_below(&r, 64));
    memset(&kept, 0, sizeof kept);
    NEED(!ibl_image_decode(test_keeping_ctx(3, &kept), "m.hdr", bytes, n, o,
                           &img, &report));
    return test_image(img);
}

static bool warned(const char *words)
{
    return strstr(kept.text[IBL_LOG_WARNING], words);
}

static const char *primaries_line(const double xy[8])
{
    return test_text("PRIMARIES= %.5f %.5f %.5f %.5f %.5f %.5f %.5f %.5f\n",
                     xy[0], xy[1], xy[2], xy[3], xy[4], xy[5], xy[6], xy[7]);
}

static void check_matrix(const double xy[8], const double m[9],
                         const char *name, double bound)
{
    ibl_read_options o = ibl_read_options_default();
    const ibl_image was = read_hdr(primaries_line(xy), NULL, &o);

    CHECK(report.has_primaries && !strcmp(report.primaries_name, name));
    CHECK(warned(name));
    o.primaries = IBL_PRIMARIES_REC709;
    const ibl_image is = read_hdr(primaries_line(xy), NULL, &o);
    CHECK(!*kept.text[IBL_LOG_WARNING] && !report.outside);
    for (int i = 0; i < 3 * W * H; i++) {
        const float *p = was.data + i / 3 * 3;
        const double *row = m + 3 * (i % 3);
        CHECK_NEAR((double)is.data[i],
                   row[0] * (double)p[0] + row[1] * (double)p[1] +
                       row[2] * (double)p[2],
                   bound * (double)p[0]);
    }
}

/* With Bradford's adaptation from the white of ACES to D65. */
TEST(as_published)
{
    check_matrix(rec2020_line, rec709_of_2020, "Rec.2020", 3e-6);
    check_matrix(acescg_line, rec709_of_acescg, "ACEScg", 3e-5);
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
    const unsigned char red[4] = {128, 0, 0, 129};
    const ibl_read_options o = {.part = -1, .primaries = IBL_PRIMARIES_REC709};
    const ibl_image img = read_hdr(primaries_line(rec2020_line), red, &o);
    const double y = .2627002, grey = y + .1245505;
    const double unit = (double)img.data[0] / (y + y / grey * (1.6604910 - y));

    CHECK_NEAR(unit, 1, 0.01); /* RGBE decodes 128 / 256 or 128.5 / 256 */
    CHECK_NEAR((double)img.data[1], 0, 1e-6);
    CHECK_NEAR((double)img.data[2] / unit, y + y / grey * (-.0181508 - y),
               2e-6);
    CHECK(report.outside == W * H && report.negative == 0);
    CHECK(warned("512 pixels were outside the gamut of rec709"));
}

/* Also where primaries are no triangle. */
TEST(rec709_is_left_alone)
{
    static const double lines[2][8] = {
        {.64, .33, .3, .6, .15, .06, .3127, .329},
        {.3, .3, .3, .3, .3, .3, .3, .3}};
    ibl_read_options o = ibl_read_options_default();
    const ibl_image plain = read_hdr("", NULL, &o);

    CHECK(!report.has_primaries && !strcmp(report.primaries_name, "Rec.709"));
    CHECK_NEAR(report.luma[1], 0.7152, 1e-4);
    for (int i = 0; i < 4; i++) {
        o.primaries = i % 2 ? IBL_PRIMARIES_REC709 : IBL_PRIMARIES_KEEP;
        const ibl_image img = read_hdr(primaries_line(lines[i / 2]), NULL, &o);
        CHECK(report.has_primaries == (i < 2) && !*kept.text[IBL_LOG_WARNING] &&
              !strcmp(report.primaries_name, "Rec.709"));
        CHECK(!memcmp(img.data, plain.data, 3 * sizeof(float) * W * H));
    }
}

/* A power of two leaves every bit of a fraction. */
TEST(exposure_is_exact)
{
    const ibl_read_options wrong[] = {{.part = -1, .exposure = 65},
                                      {.part = -1, .clamp = -1}};
    ibl_read_options o = ibl_read_options_default();
    const ibl_image was = read_hdr("", NULL, &o);
    ibl_image img;

    o.exposure = -3;
    const ibl_image is = read_hdr("", NULL, &o);
    for (int i = 0; i < 3 * W * H; i++)
        CHECK(is.data[i] * 8 == was.data[i]);
    o.exposure = 0.5;
    const ibl_image half = read_hdr("", NULL, &o);
    CHECK_NEAR((double)half.data[5], sqrt(2) * (double)was.data[5], 1e-6);
    for (int i = 0; i < 2; i++)
        CHECK(ibl_image_decode(test_keeping_ctx(1, &kept), "m", "#?", 2,
                               &wrong[i], &img, NULL) == IBL_ERR_ARGUMENT);
}

/* A grey map with a lamp of a row's 3 pixels, whose light is known. */
TEST(clamp_keeps_hue_and_tells_what_it_took)
{
    const float lamp[3] = {100, 50, 25};
    const ibl_read_options o = {.part = -1, .clamp = 20, .exposure = 1};
    ibl_ctx *ctx = test_keeping_ctx(2, &kept);
    const ibl_image img = map_constant(ctx, 64, 32, 0.25f);
    ibl_image is;

    for (int k = 0; k < 3; k++)
        map_set(&img, (63 + k) % 64, 9, lamp[0], lamp[1], lamp[2]);
    NEED(file_save_exr(file_path("lamp.exr"), &img, NULL));
    memset(&kept, 0, sizeof kept);
    NEED(!ibl_image_read(ctx, file_path("lamp.exr"), &o, &is, &report));
    test_image(is);
    const float *p = map_pixel(&is, 0, 9);
    CHECK(p[0] == 20 && p[1] == 10 && p[2] == 5 && is.data[0] == 0.5f);
    CHECK(report.clamped == 3 && report.peak == 100);
    const double y = .2126390 * 100 + .7151687 * 50 + .0721923 * 25;
    const double lamps = 3 * truth_latlong_solid_angle(64, 32, 9);
    const double all = lamps * y * 2 + (4 * M_PI - lamps) * .5;
    CHECK_NEAR(report.clamp_removed, lamps * y * 2 * .9 / all, 1e-6);
    CHECK(warned("3 pixels were above 20"));
}

TEST(hash_of_the_file)
{
    const ibl_read_options hashed = {.part = -1, .hash = 1};
    ibl_ctx *ctx = test_keeping_ctx(2, &kept);
    const ibl_image img = map_constant(ctx, 512, 256, 0.25f);
    size_t size;

    NEED(file_save_exr(file_path("a.exr"), &img, NULL));
    const unsigned char *bytes = file_load(file_path("a.exr"), &size);
    const XXH128_hash_t h = XXH3_128bits(bytes, size);
    const char *want = test_text("%016llx%016llx", (unsigned long long)h.high64,
                                 (unsigned long long)h.low64);
    for (int i = 0; i < 3; i++) {
        const ibl_read_options *o = i < 2 ? &hashed : NULL;
        ibl_image got;
        NEED(!(i ? ibl_image_read(ctx, file_path("a.exr"), o, &got, &report)
                 : ibl_image_decode(ctx, "m", bytes, size, o, &got, &report)));
        test_image(got);
        CHECK(!strcmp(report.hash, o ? want : ""));
    }
}
