/* SPDX-License-Identifier: MIT */
/* Alpha of images that are read, and of textures. The truth is what was saved,
 * multiplied where it is straight; check_read has rows, threads, pipes and
 * formats of integers. */
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

static seen see(ibl_ctx *ctx, const char *name, ibl_alpha want, int strict)
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
    s.status = ibl_source_read(source, h, s.img.data);
    const float *a = ibl_source_alpha(source);
    if (a) {
        s.alpha = test_alloc((size_t)w * (size_t)h, sizeof *a);
        memcpy(s.alpha, a, sizeof *a * (size_t)w * (size_t)h);
    }
    s.report = *ibl_source_report(source);
    ibl_source_close(source);
    return s;
}

/* ---- reading ----------------------------------------------------------- */

/* Colours multiplied by alpha, as OpenEXR has them, however the file is made;
 * of a part of the map, whose rest is not seen; of none; and as straight ones,
 * which break OpenEXR's rule. Without being asked for, alpha changes nothing
 * and is not there. */
static const struct {
    const char *name, *make;
    double colour, alpha; /* how far they may be off */
    bool part;
} files[] = {
    {"a.exr", NULL, 0, 0, false},
    {"zip.exr", "a.exr --compression zip", 0, 0, false},
    {"tiled.exr", "a.exr --compression zip --tile 16 16", 0, 0, false},
    {"layer.exr", "a.exr --chnames x.R,x.G,x.B,x.A", 0, 0, false},
    {"mixed.exr", "a.exr -d R=half", 2e-3, 0, false},
    {"dwa.exr", "a.exr --compression dwaa:0.01", 0.1, 1e-2, false},
    {"crop.exr", "a.exr --crop 20x10+8+6 --compression zip", 0, 0, true},
    {"cropdwa.exr", "a.exr --crop 20x10+8+6 --compression dwaa:0.01", 0.1, 1e-2,
     true},
    {"croptile.exr", "a.exr --crop 20x10+8+6 --compression zip --tile 8 8", 0,
     0, true},
};

static void check_file(const seen *s, int file, ibl_alpha how)
{
    double colour = 0, off = 0;

    NEED(!s->status && s->img.width == W && s->img.height == H);
    for (int i = 0; i < W * H; i++) {
        const int x = i % W, y = i / W;
        const bool in =
            !files[file].part || (x >= 8 && x < 28 && y >= 6 && y < 16);
        const double a = in ? (double)alpha[i] : 0;
        for (int k = 0; k < 3; k++)
            colour =
                fmax(colour, fabs((double)s->img.data[3 * i + k] -
                                  (double)img.data[3 * i + k] *
                                      (how == IBL_ALPHA_STRAIGHT ? a : in)));
        off = fmax(off, s->alpha ? fabs((double)s->alpha[i] - a) : 0);
    }
    CHECK_MSG(colour <= files[file].colour + 2e-7 && off <= files[file].alpha,
              "%s, %d: off by %g and %g", files[file].name, (int)how, colour,
              off);
    CHECK(s->report.has_alpha == (how != IBL_ALPHA_IGNORE) &&
          !s->alpha == !s->report.has_alpha);
    /* else some alpha may have become 0 */
    CHECK(files[file].colour > 0 ||
          (!s->report.alpha_hidden && !kept.text[IBL_LOG_WARNING][0]));
    CHECK(s->alpha ? s->report.alpha_least <= 0 && s->report.alpha_most >= 1
                   : s->report.alpha_least >= 1 && s->report.alpha_most <= 1);
}

TEST(of_files)
{
    const char *command = "oiiotool";
    const bool more = file_have("oiiotool") && file_bridge();
    ibl_ctx *ctx = file_ctx(3, &kept, file_bridge());

    make();
    NEED(file_save_exr(file_path("a.exr"), &img, alpha));
    for (int i = 1; i < 9; i++)
        command = test_text("%s --scanline -d float %s -o %s", command,
                            files[i].make, files[i].name);
    NEED(!more || file_run("%s", command));
    for (int i = 0; i < (more ? 9 : 1); i++)
        for (int how = IBL_ALPHA_IGNORE; how <= IBL_ALPHA_STRAIGHT; how++) {
            const seen s = see(ctx, files[i].name, (ibl_alpha)how, 0);
            check_file(&s, i, (ibl_alpha)how);
        }
    NEED(file_save_exr(file_path("none.exr"), &img, NULL));
    seen s = see(ctx, "none.exr", IBL_ALPHA_STRAIGHT, 0);
    CHECK(!s.status && !s.alpha && s.report.alpha_least >= 1 &&
          s.report.alpha_most >= 1 &&
          !memcmp(s.img.data, img.data, 3 * W * H * sizeof *img.data));
    /* Straight colours of what is not seen are nothing to tell of. */
    for (int i = 0; i < 3 * W * H; i++)
        img.data[i] = 1;
    NEED(file_save_exr(file_path("white.exr"), &img, alpha));
    for (int how = IBL_ALPHA_FILE; how <= IBL_ALPHA_STRAIGHT; how++) {
        s = see(ctx, "white.exr", (ibl_alpha)how, 0);
        const bool hidden = how == IBL_ALPHA_FILE;
        CHECK(!s.status && (s.report.alpha_hidden > 0) == hidden &&
              !kept.text[IBL_LOG_WARNING][0] != hidden);
    }
}

/* Alpha of pixels 30 on that is not finite, below 0, above 1 or nearly so: what
 * becomes of it, and of colours of 5. */
TEST(wild_values)
{
    const float was[] = {NAN, INFINITY, -INFINITY, -2, 7, 1.0005f, -0.0005f, 1};
    static const float is[] = {0, 0, 0, 0, 1, 1, 0, 1};
    static const float odd[] = {NAN, -2, 7, 0.25f};
    ibl_ctx *ctx = file_ctx(2, &kept, NULL);

    make();
    for (int i = 0; i < W * H; i++) {
        alpha[i] = i < 30 || i >= 38 ? 1 : was[i - 30];
        for (int k = 0; k < 3; k++)
            img.data[3 * i + k] = 5;
    }
    NEED(file_save_exr(file_path("wild.exr"), &img, alpha));
    seen s = see(ctx, "wild.exr", IBL_ALPHA_FILE, 0);
    NEED(!s.status && s.alpha);
    for (int i = 0; i < 8; i++)
        CHECK(s.alpha[30 + i] == is[i] &&
              s.img.data[3 * (30 + i)] == 5 * is[i] &&
              s.img.data[3 * (30 + i) + 2] == 5 * is[i]);
    CHECK(s.report.alpha_nonfinite == 3 && s.report.alpha_beyond == 2 &&
          s.report.alpha_hidden == 2 && s.report.alpha_least == 0 &&
          s.report.alpha_most == 1 && !s.report.nonfinite &&
          !s.report.negative);
    s = see(ctx, "wild.exr", IBL_ALPHA_FILE, 1);
    CHECK(s.status == IBL_ERR_FORMAT);
    CHECK(test_said(&kept, "alpha is not finite in 3"));
    s = see(ctx, "wild.exr", IBL_ALPHA_IGNORE, 1);
    CHECK(!s.status);
    /* One alone, or none. */
    for (int i = 0; i < 4; i++) {
        for (int k = 0; k < W * H; k++)
            alpha[k] = 0.5f;
        alpha[40] = odd[i];
        NEED(file_save_exr(file_path("odd.exr"), &img, alpha));
        s = see(ctx, "odd.exr", IBL_ALPHA_FILE, 1);
        CHECK_MSG(s.status == (i < 3 ? IBL_ERR_FORMAT : IBL_OK),
                  "strict with %g", (double)odd[i]);
        CHECK(i < 3 ||
              (s.report.alpha_least == 0.25f && s.report.alpha_most == 0.5f));
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

/* Of pixels that have room for alpha, alone and in an array; others refuse it,
 * as all do if it has other levels. */
TEST(textures)
{
    ibl_ctx *ctx = file_ctx(2, &kept, NULL);
    test_random r = {3};
    ibl_cube colour = cube_alloc(ctx, 8, 3), grey = cube_alloc(ctx, 8, 3), back;
    const ibl_cube less = {8, 2, grey.data, 0};

    for (size_t i = 0; i < cube_floats(&colour); i++) {
        colour.data[i] = (float)(9 * test_random_unit(&r));
        grey.data[i] = (float)(1.4 * test_random_unit(&r) - 0.2);
    }
    for (ibl_pixel p = IBL_PIXEL_RGBA16F; p <= IBL_PIXEL_R11G11B10F; p++) {
        const double rel = p == IBL_PIXEL_RGBA16F ? 5e-4 : 0;
        const bool room = p <= IBL_PIXEL_RGBA32F;
        ibl_texture tex;
        NEED(!ibl_texture_from_cube(
            ctx, &colour,
            &(ibl_texel_options){.pixel = p, .overflow = IBL_OVERFLOW_SPREAD},
            &tex, NULL));
        texture_owned(tex);
        CHECK(!tex.premultiplied && ibl_pixel_has_alpha(p) == room);
        NEED(!ibl_texture_get_alpha(ctx, &tex, &back));
        test_cube(back);
        for (size_t i = 0; i < cube_floats(&back); i++)
            CHECK(back.data[i] == 1);
        const ibl_cube *wrong = room ? &less : &grey;
        CHECK(ibl_texture_set_alpha(ctx, &tex, wrong) == IBL_ERR_ARGUMENT);
        CHECK(test_said(&kept, room ? "2 levels" : ibl_pixel_name(p)) &&
              !tex.premultiplied);
        if (!room)
            continue;
        const ibl_texture one = texture_layer(ctx, &tex, 0);
        grey.data[0] = NAN;
        NEED(!ibl_texture_set_alpha(ctx, &tex, &grey));
        grey.data[0] = 0;
        CHECK(tex.premultiplied);
        const ibl_texture *const list[] = {&one, &tex};
        const ibl_texture array = texture_array(ctx, list, 2);
        for (ibl_container c = 0; c < IBL_CONTAINER_DDS_LEGACY; c++) {
            size_t size;
            ibl_cube a, b;
            const void *bytes = texture_encode(ctx, &array, c, &size);
            const ibl_texture read = texture_decode(ctx, bytes, size);
            CHECK(read.premultiplied == (c == IBL_CONTAINER_KTX2));
            const ibl_texture twin = texture_layer(ctx, &read, 1);
            CHECK(twin.bytes == tex.bytes &&
                  !memcmp(twin.data, tex.data, tex.bytes));
            NEED(!ibl_texture_get_alpha(ctx, &twin, &back));
            test_cube(back);
            CHECK(same_alpha(&back, &grey, rel));
            /* The colours are none of its business. */
            NEED(!ibl_texture_to_cube(ctx, &twin, &a));
            test_cube(a);
            NEED(!ibl_texture_to_cube(ctx, &one, &b));
            test_cube(b);
            CHECK(!memcmp(a.data, b.data, cube_floats(&a) * sizeof(float)));
        }
    }
}
