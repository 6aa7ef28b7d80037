/* SPDX-License-Identifier: MIT */
/* Alpha of images that are read, and of textures. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "files.h"
#include "ibl/io.h"
#include "maps.h"
#include "textures.h"

enum {
    W = 48,
    H = 24
};

static test_messages kept;
static float alpha[W * H];
static ibl_image img;

/* Colours multiplied by alpha, of all sizes, with pieces of 0 and 1. */
static void make(void)
{
    static float data[3 * W * H];
    test_random r = {7};

    for (int i = 0; i < W * H; i++) {
        const int kind = i / 5 % 3;
        alpha[i] = kind < 2 ? (float)kind : (float)test_random_unit(&r);
        for (int k = 0; k < 3; k++)
            data[3 * i + k] = alpha[i] * (float)(4 * test_random_unit(&r));
    }
    img = (ibl_image){W, H, data};
}

typedef struct seen {
    ibl_status status;
    ibl_image img;
    float *alpha; /* NULL: none */
    ibl_read_report report;
} seen;

/* Reads a file by `rows` rows at a time. */
static seen see(ibl_ctx *ctx, const char *name, ibl_alpha want, int rows,
                int strict)
{
    ibl_read_options opts = ibl_read_options_default();
    ibl_source *source;
    seen s = {0};

    memset(&kept, 0, sizeof kept);
    opts.alpha = want;
    opts.any_aspect = 1;
    opts.strict = strict;
    s.status = ibl_source_open(ctx, file_path(name), &opts, &source);
    if (s.status)
        return s;
    const int w = ibl_source_width(source), h = ibl_source_height(source);
    s.img = map_constant(ctx, w, h, 0);
    for (int y = 0; y < h && !s.status; y += rows)
        s.status = ibl_source_read(source, h - y < rows ? h - y : rows,
                                   s.img.data + 3 * (size_t)y * (size_t)w);
    const float *a = ibl_source_alpha(source);
    if (a) {
        s.alpha = test_alloc((size_t)w * (size_t)h, sizeof *a);
        memcpy(s.alpha, a, sizeof *a * (size_t)w * (size_t)h);
    }
    s.report = *ibl_source_report(source);
    ibl_source_close(source);
    return s;
}

/* Largest differences from what make() made, whose colours may be divided. */
static double off_colour(const seen *s, bool black_holes)
{
    double worst = 0;
    for (int i = 0; i < 3 * W * H; i++) {
        const float want = black_holes && alpha[i / 3] <= 0 ? 0 : img.data[i];
        worst = fmax(worst, fabs((double)s->img.data[i] - (double)want));
    }
    return worst;
}

static double off_alpha(const seen *s)
{
    double worst = 0;
    for (int i = 0; i < W * H; i++)
        worst = fmax(worst, fabs((double)s->alpha[i] - (double)alpha[i]));
    return worst;
}

/* ---- reading ----------------------------------------------------------- */

/* Without being asked for, alpha changes nothing and is not there. */
TEST(dropped_by_default)
{
    ibl_ctx *ctx = file_ctx(2, &kept, NULL);
    make();
    img.data[0] = 3; /* where alpha is 0 */
    NEED(file_save_exr(file_path("a.exr"), &img, alpha));
    seen s = see(ctx, "a.exr", IBL_ALPHA_IGNORE, 5, 0);
    CHECK(!s.status && !s.alpha && !s.report.has_alpha);
    CHECK(s.report.alpha_least >= 1 && s.report.alpha_most <= 1);
    CHECK(off_colour(&s, false) <= 0);
    CHECK(!kept.text[IBL_LOG_WARNING][0]);
}

/* However the file is made and its rows are asked for. */
TEST(premultiplied_exr)
{
    static const char *const names[] = {"a.exr",     "zip.exr",   "tiled.exr",
                                        "mixed.exr", "layer.exr", "dwa.exr"};
    static const int rows[] = {1, 7, H};
    const bool more = file_have("oiiotool") && file_bridge();
    ibl_ctx *ctx = file_ctx(3, &kept, file_bridge());

    make();
    NEED(file_save_exr(file_path("a.exr"), &img, alpha));
    if (more)
        NEED(file_run("oiiotool a.exr --compression zip -o zip.exr --tile 16 "
                      "16 -o tiled.exr --scanline a.exr --chnames "
                      "x.R,x.G,x.B,x.A -o layer.exr a.exr --compression "
                      "dwaa:0.01 -o dwa.exr a.exr --compression zip -d half -o "
                      "h.exr a.exr -d float -d R=half -o mixed.exr"));
    for (size_t i = 0; i < (more ? 6 : 1); i++) {
        for (size_t k = 0; k < 3; k++) {
            const double least = i < 3 || i == 4 ? 0 : i == 3 ? 2e-3 : 0.1;
            seen s = see(ctx, names[i], IBL_ALPHA_FILE, rows[k], 0);
            CHECK_MSG(!s.status && s.alpha, "%s: %s", names[i], kept.text[0]);
            if (s.alpha) {
                CHECK_MSG(off_colour(&s, false) <= least, "%s: colours by %g",
                          names[i], off_colour(&s, false));
                CHECK_MSG(off_alpha(&s) <= (i == 5 ? 1e-2 : 0),
                          "%s: alpha by %g", names[i], off_alpha(&s));
                CHECK(s.report.has_alpha && s.report.alpha_least <= 0 &&
                      s.report.alpha_most >= 1);
            }
        }
    }
}

/* Half-size chroma, and a data window that is not all of the map. */
TEST(windows)
{
    file_need_oiio();
    ibl_ctx *ctx = file_ctx(2, &kept, file_bridge());
    make();
    NEED(file_save_exr(file_path("a.exr"), &img, alpha));
    NEED(file_run("oiiotool a.exr --crop 20x10+8+6 --compression zip -o "
                  "crop.exr --compression dwaa -o cropdwa.exr --tile 8 8 "
                  "--compression zip -o croptile.exr"));
    static const char *const names[] = {"crop.exr", "cropdwa.exr",
                                        "croptile.exr"};
    for (int i = 0; i < 3; i++) {
        seen s = see(ctx, names[i], IBL_ALPHA_FILE, 7, 0);
        CHECK_MSG(!s.status && s.alpha && s.img.width == W, "%s: %s", names[i],
                  kept.text[0]);
        for (int k = 0; s.alpha && k < W * H; k++) {
            const int x = k % W, y = k / W;
            const bool in = x >= 8 && x < 28 && y >= 6 && y < 16;
            CHECK_NEAR((double)s.alpha[k], in ? (double)alpha[k] : 0,
                       i == 1 ? 1e-2 : 0);
        }
    }
}

/* Formats with straight alpha are multiplied by it, in linear light. */
TEST(integer_formats)
{
    static const struct {
        const char *name;
        bool straight;
    } cases[] = {{"s.png", true}, {"s16.png", true}, {"grey.png", true},
                 {"s.tif", true}, {"p.tif", false},  {"s.tga", true}};
    file_need_oiio();
    ibl_ctx *ctx = file_ctx(1, &kept, file_bridge());
    NEED(file_run(
        "oiiotool --create 8x4 4 -d uint8 --fill:color=0.6,0.6,0.6,0.4 8x4 "
        "--attrib oiio:UnassociatedAlpha 1 -o s.png -o s.tga -o s.tif "
        "-d uint16 -o s16.png "
        "--create 8x4 2 --chnames Y,A -d uint8 --fill:color=0.6,0.4 8x4 "
        "--attrib oiio:UnassociatedAlpha 1 -o grey.png "
        "--create 8x4 4 --fill:color=0.6,0.6,0.6,0.4 8x4 -o p.tif"));
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        const double full = pow((153 / 255. + 0.055) / 1.055, 2.4);
        seen s = see(ctx, cases[i].name, IBL_ALPHA_FILE, 3, 0);
        CHECK_MSG(!s.status && s.alpha, "%s: %s", cases[i].name, kept.text[0]);
        if (s.alpha) {
            CHECK_MSG(fabs((double)s.alpha[9] - 0.4) < 1e-6, "%s: alpha %g",
                      cases[i].name, (double)s.alpha[9]);
            CHECK_MSG(fabs((double)s.img.data[27] -
                           full * (cases[i].straight ? 0.4 : 1)) < 1e-5,
                      "%s: colour %g", cases[i].name, (double)s.img.data[27]);
        }
        s = see(ctx, cases[i].name, IBL_ALPHA_IGNORE, 3, 0);
        CHECK_MSG(!s.status && !s.alpha &&
                      fabs((double)s.img.data[27] - full) < 1e-5,
                  "%s: without alpha %g", cases[i].name,
                  s.img.data ? (double)s.img.data[27] : -1);
    }
}

/* More rows than the bridge is asked for at once. */
TEST(tall)
{
    enum {
        ROWS = 200
    };
    float data[3 * ROWS], alphas[ROWS];
    const ibl_image column = {1, ROWS, data};
    file_need_oiio();
    ibl_ctx *ctx = file_ctx(1, &kept, file_bridge());
    for (int y = 0; y < ROWS; y++) {
        alphas[y] = (float)(y + 1) / 256;
        for (int c = 0; c < 3; c++)
            data[3 * y + c] = alphas[y] * (float)(1 + c);
    }
    NEED(file_save_exr(file_path("tall.exr"), &column, alphas) &&
         file_run("oiiotool tall.exr -o tall.tif"));
    seen s = see(ctx, "tall.tif", IBL_ALPHA_FILE, ROWS, 0);
    CHECK_MSG(!s.status && s.alpha && s.report.bridged, "%s", kept.text[0]);
    for (int y = 0; s.alpha && y < ROWS; y++)
        CHECK(s.alpha[y] == alphas[y] &&
              !memcmp(s.img.data + 3 * y, data + 3 * y, 3 * sizeof *data));
}

/* Files that break OpenEXR's rule, and those that have none. */
TEST(straight_and_none)
{
    ibl_ctx *ctx = file_ctx(2, &kept, NULL);
    make();
    NEED(file_save_exr(file_path("a.exr"), &img, alpha));
    NEED(file_save_exr(file_path("none.exr"), &img, NULL));
    seen s = see(ctx, "a.exr", IBL_ALPHA_STRAIGHT, 7, 0);
    NEED(!s.status && s.alpha);
    for (int i = 0; i < 3 * W * H; i++)
        CHECK(s.img.data[i] == img.data[i] * alpha[i / 3]);
    CHECK(!s.report.alpha_hidden && !kept.text[IBL_LOG_WARNING][0]);
    s = see(ctx, "none.exr", IBL_ALPHA_STRAIGHT, 7, 0);
    CHECK(!s.status && !s.alpha && off_colour(&s, false) <= 0);
    CHECK(s.report.alpha_least >= 1 && s.report.alpha_most >= 1);
    /* Straight colours of what is not seen are nothing to tell of. */
    for (int i = 0; i < 3 * W * H; i++)
        img.data[i] = 1;
    NEED(file_save_exr(file_path("white.exr"), &img, alpha));
    s = see(ctx, "white.exr", IBL_ALPHA_STRAIGHT, 7, 0);
    CHECK(!s.status && !s.report.alpha_hidden);
    CHECK(!kept.text[IBL_LOG_WARNING][0]);
    s = see(ctx, "white.exr", IBL_ALPHA_FILE, 7, 0);
    CHECK(!s.status && s.report.alpha_hidden);
}

/* NaN, infinite, below 0, above 1, and colours without alpha. */
TEST(wild_values)
{
    ibl_ctx *ctx = file_ctx(2, &kept, NULL);
    make();
    for (int i = 0; i < W * H; i++)
        alpha[i] = 1;
    alpha[30] = NAN;
    alpha[31] = INFINITY;
    alpha[300] = -2;
    alpha[301] = 7;
    alpha[302] = 1.0005f; /* rounding */
    alpha[303] = -0.0005f;
    for (int i = 30; i < 304; i += 1)
        img.data[3 * i] = 5;
    NEED(file_save_exr(file_path("wild.exr"), &img, alpha));
    for (int rows = 1; rows <= H; rows += H - 1) {
        seen s = see(ctx, "wild.exr", IBL_ALPHA_FILE, rows, 0);
        NEED(!s.status && s.alpha);
        static const int zero[] = {30, 31, 300, 303};
        for (int i = 0; i < 4; i++)
            CHECK(s.alpha[zero[i]] == 0 && s.img.data[3 * zero[i]] == 0 &&
                  s.img.data[3 * zero[i] + 2] == 0);
        CHECK(s.alpha[301] == 1 && s.alpha[302] == 1);
        CHECK(s.img.data[3 * 301] == 5 && s.img.data[3 * 299] == 5);
        CHECK(s.report.alpha_nonfinite == 2 && s.report.alpha_beyond == 2);
        CHECK(s.report.alpha_hidden == 2);
        CHECK(s.report.alpha_least == 0 && s.report.alpha_most == 1);
        CHECK(!s.report.nonfinite && !s.report.negative);
    }
    seen s = see(ctx, "wild.exr", IBL_ALPHA_FILE, 5, 1);
    CHECK(s.status == IBL_ERR_FORMAT);
    CHECK_MSG(strstr(kept.text[0], "alpha is not finite in 2"), "%s",
              kept.text[0]);
    s = see(ctx, "wild.exr", IBL_ALPHA_IGNORE, 5, 1);
    CHECK(!s.status);
    /* One alone, or none. */
    static const float odd[] = {NAN, -2, 7, 0.25f};
    for (int i = 0; i < 4; i++) {
        for (int k = 0; k < W * H; k++)
            alpha[k] = 0.5f;
        alpha[40] = odd[i];
        NEED(file_save_exr(file_path("odd.exr"), &img, alpha));
        s = see(ctx, "odd.exr", IBL_ALPHA_FILE, 5, 1);
        CHECK_MSG(s.status == (i < 3 ? IBL_ERR_FORMAT : IBL_OK),
                  "strict with %g", (double)odd[i]);
        CHECK(i < 3 ||
              (s.report.alpha_least == 0.25f && s.report.alpha_most == 0.5f));
    }
}

/* Colours are mended before alpha is applied, whatever rows are read ahead. */
TEST(mended_beside_holes)
{
    ibl_ctx *ctx = file_ctx(2, &kept, NULL);
    make();
    for (int i = 0; i < W * H; i++)
        alpha[i] = i / W < 10 ? 1 : 0.5f;
    for (int i = 0; i < 3 * W * H; i++)
        img.data[i] = 2;
    img.data[3 * (9 * W + 7)] = NAN;
    NEED(file_save_exr(file_path("mend.exr"), &img, alpha));
    for (int rows = 1; rows <= 10; rows++) {
        seen s = see(ctx, "mend.exr", IBL_ALPHA_STRAIGHT, rows, 0);
        NEED(!s.status && s.alpha);
        for (int i = 0; i < W * H; i++)
            CHECK(s.img.data[3 * i] == 2 * alpha[i]);
        CHECK(s.report.nonfinite == 1);
    }
}

/* ---- textures ---------------------------------------------------------- */

static bool same_alpha(const ibl_cube *got, const ibl_cube *want, double rel)
{
    const size_t n = 3 * ibl_cube_texels(want->size, want->levels);
    for (size_t i = 0; i < n; i++) {
        const double w = fmin(fmax((double)want->data[i / 3 * 3], 0), 1);
        if (!(fabs((double)got->data[i] - w) <= rel * w + rel * 1e-4))
            return false;
    }
    return true;
}

TEST(textures)
{
    ibl_ctx *ctx = file_ctx(2, &kept, NULL);
    test_random r = {3};
    ibl_cube colour = cube_alloc(ctx, 8, 3), grey = cube_alloc(ctx, 8, 3), back;

    for (size_t i = 0; i < 3 * ibl_cube_texels(8, 3); i++) {
        colour.data[i] = (float)(9 * test_random_unit(&r));
        grey.data[i] = (float)(1.4 * test_random_unit(&r) - 0.2);
    }
    grey.data[0] = NAN;
    for (ibl_pixel p = IBL_PIXEL_RGBA16F; p <= IBL_PIXEL_RGBA32F; p++) {
        const double rel = p == IBL_PIXEL_RGBA16F ? 5e-4 : 0;
        ibl_texture tex;
        NEED(!ibl_texture_from_cube(
            ctx, &colour,
            &(ibl_texel_options){.pixel = p, .overflow = IBL_OVERFLOW_SPREAD},
            &tex, NULL));
        const ibl_texture one = texture_layer(ctx, &tex, 0);
        CHECK(!tex.premultiplied && ibl_pixel_has_alpha(p));
        NEED(!ibl_texture_get_alpha(ctx, &tex, &back));
        for (size_t i = 0; i < 3 * ibl_cube_texels(8, 3); i++)
            CHECK(back.data[i] == 1);
        ibl_cube_free(&back);
        NEED(!ibl_texture_set_alpha(ctx, &tex, &grey));
        CHECK(tex.premultiplied);
        const ibl_texture *const list[] = {&one, &tex};
        const ibl_texture array = texture_array(ctx, list, 2);
        for (ibl_container c = 0; c < IBL_CONTAINER_DDS_LEGACY; c++) {
            size_t size;
            const void *bytes = texture_encode(ctx, &array, c, &size);
            const ibl_texture read = texture_decode(ctx, bytes, size);
            CHECK(read.premultiplied == (c == IBL_CONTAINER_KTX2));
            const ibl_texture twin = texture_layer(ctx, &read, 1);
            CHECK(twin.bytes == tex.bytes &&
                  !memcmp(twin.data, tex.data, tex.bytes));
            NEED(!ibl_texture_get_alpha(ctx, &twin, &back));
            grey.data[0] = 0;
            CHECK(same_alpha(&back, &grey, rel));
            grey.data[0] = NAN;
            ibl_cube_free(&back);
            /* The colours are none of its business. */
            ibl_cube a, b;
            NEED(!ibl_texture_to_cube(ctx, &twin, &a));
            NEED(!ibl_texture_to_cube(ctx, &one, &b));
            CHECK(!memcmp(a.data, b.data,
                          3 * sizeof(float) * ibl_cube_texels(8, 3)));
            ibl_cube_free(&a);
            ibl_cube_free(&b);
        }
        ibl_texture_free(&tex);
    }
}

TEST(no_room_for_alpha)
{
    ibl_ctx *ctx = file_ctx(1, &kept, NULL);
    ibl_cube colour = cube_alloc(ctx, 4, 1), grey = cube_alloc(ctx, 4, 2), back;
    ibl_texture tex;

    memset(colour.data, 0, 3 * sizeof(float) * ibl_cube_texels(4, 1));
    memset(grey.data, 0, 3 * sizeof(float) * ibl_cube_texels(4, 2));
    for (ibl_pixel p = IBL_PIXEL_RGBA16F; p <= IBL_PIXEL_R11G11B10F; p++) {
        NEED(!ibl_texture_from_cube(
            ctx, &colour,
            &(ibl_texel_options){.pixel = p, .overflow = IBL_OVERFLOW_SPREAD},
            &tex, NULL));
        CHECK(ibl_texture_set_alpha(ctx, &tex, &grey) == IBL_ERR_ARGUMENT);
        CHECK(strstr(kept.text[0],
                     p < IBL_PIXEL_RGB9E5 ? "2 levels" : ibl_pixel_name(p)));
        CHECK(!tex.premultiplied);
        NEED(!ibl_texture_get_alpha(ctx, &tex, &back));
        CHECK(back.data[17] == 1);
        ibl_cube_free(&back);
        ibl_texture_free(&tex);
    }
}
