/* SPDX-License-Identifier: MIT */
/* Luminance and half-size chroma by OpenEXRCore, against sums in double. */
#include <OpenEXR/openexr.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "core/half.h"
#include "exr.h"
#include "files.h"
#include "io/exr.h"
#include "io/exr_file.h"

/* Interpolation of one row or column of half-size samples in double. */
static double half_band(const double *s, int n, int stride, int i)
{
    static const double taps[] = {0.627123, -0.186077, 0.087929, -0.043159,
                                  0.019597, -0.007540, 0.002128};
    double sum = 0;
    if (i % 2 == 0)
        return s[i / 2 * stride];
    for (int t = -7; t < 7; t++) {
        int k = i / 2 + 1 + t;
        k = k < 0 ? 0 : k >= n ? n - 1 : k;
        sum += taps[t < 0 ? -1 - t : t] * s[k * stride];
    }
    return sum;
}

/* Wild chroma and chromaticities, against the definition in double. */
TEST(luma_chroma_core)
{
    enum {
        w = 40,
        h = 36
    };
    static float luma[h * w], chroma[2][h / 2 * (w / 2)];
    static double wide[2][h / 2 * w], full[2][h * w];
    /* ACES primaries; weights of Y by solving for the white point. */
    const exr_attr_chromaticities_t aces = {
        0.7347f, 0.2653f, 0.0f, 1.0f, 0.0001f, -0.077f, 0.32168f, 0.33767f};
    const double yw[3] = {0.3439664498, 0.7281660966, -0.0721325464};
    const test_exr_channel channels[] = {{"BY", EXR_PIXEL_HALF, 2, chroma[1]},
                                         {"RY", EXR_PIXEL_HALF, 2, chroma[0]},
                                         {"Y", EXR_PIXEL_FLOAT, 1, luma}};
    test_random r = {5};
    test_exr_ctx = file_ctx(2, &test_exr_kept, NULL);
    ibl_image img = {0};
    ibl_read_report report;

    for (int i = 0; i < w * h; i++)
        luma[i] = (float)exp(6 * test_random_unit(&r));
    for (int i = 0; i < w * h / 2; i++)
        chroma[i % 2][i / 2] = ibl_half_to_float(ibl_half_from_float(
            i % 5 ? (float)(2 * test_random_unit(&r) - 1) : 0));
    for (int p = 0; p < 2; p++) {
        for (int y = 0; y < h / 2; y++) {
            double row[w / 2];
            for (int x = 0; x < w / 2; x++)
                row[x] = (double)chroma[p][y * (w / 2) + x];
            for (int x = 0; x < w; x++)
                wide[p][y * w + x] = half_band(row, w / 2, 1, x);
        }
        for (int y = 0; y < h; y++)
            for (int x = 0; x < w; x++)
                full[p][y * w + x] = half_band(&wide[p][x], h / 2, w, y);
    }
    for (int comp = 0; comp < 4; comp++) {
        NEED(test_exr_write(file_path("core.exr"), w, h,
                            (exr_compression_t)comp, channels, 3, &aces, -1));
        CHECK_MSG(!test_exr_decode("core.exr", NULL, -1, &img, &report), "%s",
                  test_exr_kept.text[0]);
        NEED(img.data);
        for (int i = 0; i < w * h; i++) {
            const double y = (double)luma[i];
            const double red = (full[0][i] + 1) * y;
            const double blue = (full[1][i] + 1) * y;
            const double green = (y - red * yw[0] - blue * yw[2]) / yw[1];
            CHECK_NEAR((double)img.data[3 * i], red, 4e-6 * y);
            CHECK_NEAR((double)img.data[3 * i + 1], green, 1e-5 * y);
            CHECK_NEAR((double)img.data[3 * i + 2], blue, 4e-6 * y);
        }
    }
}

/* Without chroma all three are the luminance, to the bit. */
TEST(grey_is_exact)
{
    enum {
        w = 32,
        h = 16
    };
    static float zero[w * h], luma[w * h];
    test_random r = {8};
    test_exr_ctx = file_ctx(1, &test_exr_kept, NULL);
    for (int i = 0; i < w * h; i++)
        luma[i] = (float)exp(20 * test_random_unit(&r) - 10);
    for (int step = 1; step <= 2; step++) {
        const test_exr_channel channels[] = {
            {"BY", EXR_PIXEL_FLOAT, step, zero},
            {"RY", EXR_PIXEL_FLOAT, step, zero},
            {"Y", EXR_PIXEL_FLOAT, 1, luma}};
        ibl_image img = {0};
        ibl_read_report report;
        NEED(test_exr_write(file_path("grey.exr"), w, h, EXR_COMPRESSION_NONE,
                            channels, 3, NULL, -1));
        NEED(!test_exr_decode("grey.exr", NULL, -1, &img, &report));
        for (int i = 0; i < 3 * w * h; i++)
            CHECK(img.data[i] == luma[i / 3]);
    }
}

/* A map is read whether it says so or not; a cube is no map. */
TEST(environments)
{
    static float zero[32 * 16];
    const test_exr_channel y[] = {{"Y", EXR_PIXEL_HALF, 1, zero}};
    test_exr_ctx = file_ctx(1, &test_exr_kept, NULL);
    for (int envmap = EXR_ENVMAP_LATLONG; envmap <= EXR_ENVMAP_CUBE; envmap++) {
        ibl_image img = {0};
        ibl_read_report report;
        NEED(test_exr_write(file_path("env.exr"), 32, 16, EXR_COMPRESSION_ZIP,
                            y, 1, NULL, envmap));
        CHECK(test_exr_decode("env.exr", NULL, -1, &img, &report) ==
              (envmap == EXR_ENVMAP_CUBE ? IBL_ERR_FORMAT : IBL_OK));
    }
    CHECK_MSG(strstr(test_exr_kept.text[0], "the layout cube"), "%s",
              test_exr_kept.text[0]);
}

TEST(sampling_refused)
{
    static float zero[32 * 16];
    const test_exr_channel rgb[] = {{"B", EXR_PIXEL_HALF, 1, zero},
                                    {"G", EXR_PIXEL_HALF, 2, zero},
                                    {"R", EXR_PIXEL_HALF, 1, zero}};
    const test_exr_channel yc[] = {{"BY", EXR_PIXEL_HALF, 4, zero},
                                   {"RY", EXR_PIXEL_HALF, 4, zero},
                                   {"Y", EXR_PIXEL_HALF, 1, zero}};
    const exr_attr_chromaticities_t flat = {0.3f, 0.3f, 0.3f, 0.3f,
                                            0.3f, 0.3f, 0.3f, 0.3f};
    const test_exr_channel plain[] = {{"BY", EXR_PIXEL_HALF, 1, zero},
                                      {"RY", EXR_PIXEL_HALF, 1, zero},
                                      {"Y", EXR_PIXEL_HALF, 1, zero}};
    test_exr_ctx = file_ctx(1, &test_exr_kept, NULL);
    ibl_image img;
    ibl_read_report report;

    NEED(test_exr_write(file_path("a.exr"), 32, 16, 0, rgb, 3, NULL, -1));
    test_exr_refused("a.exr", NULL, -1, IBL_ERR_UNSUPPORTED,
                     "channel G is sampled");
    NEED(test_exr_write(file_path("b.exr"), 32, 16, 0, yc, 3, NULL, -1));
    CHECK(test_exr_decode("b.exr", NULL, -1, &img, &report) ==
          IBL_ERR_UNSUPPORTED);
    NEED(test_exr_write(file_path("c.exr"), 32, 16, 0, plain, 3, &flat, -1));
    CHECK(test_exr_decode("c.exr", NULL, -1, &img, &report) == IBL_ERR_FORMAT);
    NEED(test_exr_write(file_path("d.exr"), 32, 16, 0, plain, 3, NULL, -1));
    CHECK(!test_exr_decode("d.exr", NULL, -1, &img, &report));
}

/* ---- alpha beside luminance ------------------------------------------ */

/* Beside half-size chroma, of which an image is made before rows are read. */
TEST(luma_chroma_alpha)
{
    enum {
        w = 40,
        h = 36
    };
    static float luma[h * w], chroma[h / 2 * (w / 2)], alpha[h * w];
    const test_exr_channel channels[] = {{"A", EXR_PIXEL_FLOAT, 1, alpha},
                                         {"BY", EXR_PIXEL_HALF, 2, chroma},
                                         {"RY", EXR_PIXEL_HALF, 2, chroma},
                                         {"Y", EXR_PIXEL_FLOAT, 1, luma}};
    const test_exr_channel coarse[] = {{"A", EXR_PIXEL_HALF, 2, chroma},
                                       {"B", EXR_PIXEL_HALF, 1, luma},
                                       {"G", EXR_PIXEL_HALF, 1, luma},
                                       {"R", EXR_PIXEL_HALF, 1, luma}};
    test_exr_ctx = file_ctx(2, &test_exr_kept, NULL);
    ibl_read_options opts = ibl_read_options_default();
    ibl_source *source;
    static float rgb[3 * w * h];

    opts.any_aspect = 1;
    for (int i = 0; i < w * h; i++) {
        alpha[i] = (float)(i % 7) / 6;
        luma[i] = 2 * alpha[i];
    }
    for (int comp = 0; comp < 4; comp++) {
        NEED(test_exr_write(file_path("core.exr"), w, h,
                            (exr_compression_t)comp, channels, 4, NULL, -1));
        for (int want = 0; want < 2; want++) {
            opts.alpha = want ? IBL_ALPHA_FILE : IBL_ALPHA_IGNORE;
            NEED(!ibl_source_open(test_exr_ctx, file_path("core.exr"), &opts,
                                  &source));
            NEED(!ibl_source_read(source, 5, rgb));
            NEED(!ibl_source_read(source, h - 5, rgb + 3 * 5 * w));
            const float *got = ibl_source_alpha(source);
            CHECK(!got == !want);
            CHECK(!got || !memcmp(got, alpha, sizeof alpha));
            for (int i = 0; i < w * h; i++)
                CHECK_NEAR((double)rgb[3 * i], (double)luma[i], 1e-6);
            ibl_source_close(source);
        }
    }
    NEED(test_exr_write(file_path("a.exr"), w, h, 0, coarse, 4, NULL, -1));
    CHECK(ibl_source_open(test_exr_ctx, file_path("a.exr"), &opts, &source) ==
          IBL_ERR_UNSUPPORTED);
    CHECK_MSG(strstr(test_exr_kept.text[0], "channel A is sampled"), "%s",
              test_exr_kept.text[0]);
    opts.alpha = IBL_ALPHA_IGNORE;
    NEED(!ibl_source_open(test_exr_ctx, file_path("a.exr"), &opts, &source));
    ibl_source_close(source);
}
