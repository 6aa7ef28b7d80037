/* SPDX-License-Identifier: MIT */
/*
 * The EXR reader against OpenImageIO: files are written by oiiotool and read
 * both here and through the bridge, which is OpenImageIO's own reader.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "core/half.h"
#include "exr.h"
#include "files.h"
#include "ibl/io.h"
#include "io/bridge.h"
#include "test.h"

enum {
    W = 70,
    H = 35
};

/* OpenImageIO's reading of the same. */
static ibl_status decode_oiio(ibl_ctx *ctx, const char *path, int part,
                              const char *const channels[3], ibl_image *img)
{
    ibl_read_options opts = ibl_read_options_default();
    ibl_rows *rows;
    size_t size;
    unsigned char *bytes = file_load(path, &size);
    const ibl_input in = ibl_input_of(ctx, "f.exr", bytes, size);
    ibl_bridge_source s = {.in = &in,
                           .kind = "OpenEXR",
                           .request = {.reader = "openexr", .subimage = part}};
    for (int c = 0; channels && c < 3; c++)
        s.request.channels[c] = channels[c];
    opts.any_aspect = 1;
    ibl_status status = ibl_bridge_rows(&s, &opts, &rows);
    *img = (ibl_image){0};
    if (!status)
        status = test_exr_read_rows(rows, img);
    ibl_rows_close(rows);
    free(bytes);
    return status;
}

/* Reads both ways and compares to the bit. */
static ibl_read_report compared; /* of the last file */

static void compare(ibl_ctx *ctx, const char *file, const char *layer, int part,
                    const char *const channels[3], ibl_image *out)
{
    ibl_image ours = {0}, theirs = {0};
    ibl_read_report report;
    const char *path = file_path(file);
    CHECK_MSG(!test_exr_decode(ctx, path, layer, part, &ours, &report),
              "%s: %s", file, test_exr_kept.text[0]);
    CHECK_MSG(!report.bridged, "%s went through the bridge", file);
    compared = report;
    CHECK_MSG(!decode_oiio(ctx, path, part < 0 ? 0 : part, channels, &theirs),
              "%s by OpenImageIO: %s", file, test_exr_kept.text[0]);
    if (ours.data && theirs.data)
        CHECK_MSG(test_exr_same(&ours, &theirs), "%s differs from OpenImageIO",
                  file);
    ibl_image_free(&theirs);
    if (out)
        *out = ours;
    else
        ibl_image_free(&ours);
}

static const char *const shapes[] = {"--scanline", "--tile 32 16"};

static void every_compression(void)
{
    if (!test_exr_ready())
        return;
    ibl_ctx *ctx = file_ctx(3, &test_exr_kept, file_bridge());
    ibl_image img = test_exr_source(ctx, W, H), back;
    char command[8000] = "oiiotool s.pfm", name[64];

    NEED(file_save_pfm(file_path("s.pfm"), &img));
    for (int t = 0; t < 3; t++)
        for (int c = 0; c < 8; c++)
            for (int s = 0; s < 2; s++)
                sprintf(command + strlen(command),
                        " -d %s %s --compression %s -o %s_%s_%d.exr",
                        test_exr_types[t], shapes[s], test_exr_compressions[c],
                        test_exr_types[t], test_exr_compressions[c], s);
    NEED(file_run("%s", command));
    for (int t = 0; t < 3; t++) {
        for (int c = 0; c < 8; c++) {
            for (int s = 0; s < 2; s++) {
                sprintf(name, "%s_%s_%d.exr", test_exr_types[t],
                        test_exr_compressions[c], s);
                compare(ctx, name, NULL, -1, NULL, &back);
                CHECK_MSG(!strstr(compared.format, "tiled") == !s, "%s: %s",
                          name, compared.format);
                /* Floats without loss: what went in, not only what another
                 * reader says. */
                if (t == 1 && c < 5 && back.data)
                    CHECK_MSG(test_exr_same(&back, &img),
                              "%s: not what was saved", name);
                ibl_image_free(&back);
            }
        }
    }
    ibl_image_free(&img);
    ibl_ctx_free(ctx);
}

/* Every block deflated, of ZIPS too: those of every_compression's short lines
 * are stored as they are. The last block of 16 lines has one. */
/* What a compression packs best, which is no damage: maps of one colour, black
 * or not, in blocks that are large. */
static void constant_maps(void)
{
    static const char *const values[] = {"0", "0.625"};
    if (!test_exr_ready())
        return;
    ibl_ctx *ctx = file_ctx(1, &test_exr_kept, file_bridge());
    char command[4000] = "oiiotool -d half", name[64];

    for (int v = 0; v < 2; v++) {
        sprintf(command + strlen(command),
                " --create 4096x32 3 --fill:color=%s,%s,%s 4096x32", values[v],
                values[v], values[v]);
        for (int c = 0; c < 8; c++)
            sprintf(command + strlen(command), " --compression %s -o %s_%d.exr",
                    test_exr_compressions[c], test_exr_compressions[c], v);
    }
    NEED(file_run("%s", command));
    for (int i = 0; i < 16; i++) {
        ibl_read_report report;
        ibl_image img = {0};
        bool same = true;
        sprintf(name, "%s_%d.exr", test_exr_compressions[i % 8], i / 8);
        CHECK_MSG(
            !test_exr_decode(ctx, file_path(name), NULL, -1, &img, &report),
            "%s: %s", name, test_exr_kept.text[0]);
        for (int k = 0; img.data && k < 3 * 4096 * 32; k++)
            same = same && img.data[k] == (i / 8 ? 0.625f : 0.0f);
        CHECK_MSG(same, "%s is not of one colour", name);
        ibl_image_free(&img);
    }
    ibl_ctx_free(ctx);
}

static void every_block_zipped(void)
{
    static const int sample[] = {2, 4, 4};
    if (!test_exr_ready())
        return;
    ibl_ctx *ctx = file_ctx(3, &test_exr_kept, file_bridge());
    ibl_image img;
    char name[64];

    NEED(!ibl_image_alloc(ctx, 301, 33, &img));
    for (int i = 0; i < 3 * 301 * 33; i++)
        img.data[i] = (float)(i % 3 + 1) * (float)(i / 3 % 301 / 7) / 128;
    NEED(file_save_pfm(file_path("s.pfm"), &img));
    for (int t = 0; t < 3; t++) {
        for (int s = 0; s < 2; s++) {
            size_t size;
            sprintf(name, "%s_%d.exr", test_exr_types[t], s);
            NEED(file_run("oiiotool s.pfm -d %s --origin +2-7 --fullsize "
                          "310x50+0-9 --compression %s -o %s",
                          test_exr_types[t], s ? "zips" : "zip", name));
            free(file_load(file_path(name), &size));
            CHECK(size < (size_t)(301 * 33 * 3 * sample[t] / 2));
            compare(ctx, name, NULL, -1, NULL, NULL);
        }
    }
    ibl_image_free(&img);
    ibl_ctx_free(ctx);
}

static void dwa_by_bridge(void)
{
    if (!test_exr_ready())
        return;
    ibl_ctx *ctx = file_ctx(2, &test_exr_kept, file_bridge());
    ibl_ctx *without = file_ctx(1, &test_exr_kept, NULL);
    ibl_image img = test_exr_source(ctx, 64, 300), a, b;
    ibl_read_report report;

    /* Noise does not shrink, and what does not shrink is stored as it is. */
    for (int i = 0; i < 3 * 64 * 300; i++)
        img.data[i] = 0.001f * (float)(i % 192) + 0.01f * (float)(i / 192);
    NEED(file_save_pfm(file_path("s.pfm"), &img));
    NEED(file_run(
        "oiiotool s.pfm -d half --compression dwaa -o a.exr --compression dwab "
        "-o b.exr --tile 32 32 -o c.exr s.pfm --scanline --fullsize "
        "80x310-5-4 --compression dwaa -o d.exr s.pfm --ch R=0.25,G=0.5,B=1 "
        "--chnames a.R,a.G,a.B -d uint32 -o e.exr && "
        "oiiotool --scanline --compression zip -d float a.exr -o a_zip.exr "
        "b.exr -o b_zip.exr c.exr -o c_zip.exr d.exr -o d_zip.exr e.exr -d "
        "uint32 -o e_zip.exr"));
    for (char f[] = "a.exr", g[] = "a_zip.exr"; *f <= 'e'; ++*f, ++*g) {
        a = b = (ibl_image){0};
        CHECK_MSG(!test_exr_decode(ctx, file_path(f), NULL, -1, &a, &report),
                  "%s: %s", f, test_exr_kept.text[0]);
        CHECK(report.bridged && strstr(report.format, "DWA"));
        CHECK_MSG(!test_exr_decode(ctx, file_path(g), NULL, -1, &b, &report),
                  "%s", g);
        CHECK(!report.bridged);
        if (a.data && b.data)
            CHECK_MSG(test_exr_same(&a, &b), "%s differs from %s", f, g);
        ibl_image_free(&a);
        ibl_image_free(&b);
        CHECK(test_exr_decode(without, file_path(f), NULL, -1, &a, &report) ==
              IBL_ERR_UNSUPPORTED);
        CHECK_MSG(strstr(test_exr_kept.text[0], "DWA") &&
                      strstr(test_exr_kept.text[0], "libopenimageio-dev"),
                  "%s", test_exr_kept.text[0]);
    }
    ibl_image_free(&img);
    ibl_ctx_free(without);
    ibl_ctx_free(ctx);
}

static void mixed_types_and_names(void)
{
    if (!test_exr_ready())
        return;
    ibl_ctx *ctx = file_ctx(2, &test_exr_kept, file_bridge());
    ibl_image img = test_exr_source(ctx, W, H), a, b;
    ibl_read_report report;

    NEED(file_save_pfm(file_path("s.pfm"), &img));
    NEED(file_run(
        "oiiotool s.pfm --ch R,G,B,A=0.5,Z=3,M.a=1,aa=7 -d half --compression "
        "zip -o extra.exr --tile 16 16 -o extra_tiled.exr "
        "s.pfm --scanline -o plain.exr --chnames red,green,blue -o long.exr "
        "--chnames x.y.r,x.y.g,x.y.b -o low.exr s.pfm -d R=half -d G=float -d "
        "B=half -o mixed.exr --compression piz -o mixed_piz.exr --compression "
        "b44 -o mixed_b44.exr"));
    compare(ctx, "mixed.exr", NULL, -1, NULL, NULL);
    compare(ctx, "mixed_piz.exr", NULL, -1, NULL, NULL);
    compare(ctx, "mixed_b44.exr", NULL, -1, NULL, NULL);
    compare(ctx, "extra.exr", NULL, -1, NULL, NULL);
    compare(ctx, "extra_tiled.exr", NULL, -1, NULL, NULL);
    CHECK(!test_exr_decode(ctx, file_path("plain.exr"), NULL, -1, &a, &report));
    for (int i = 0; i < 3; i++) {
        static const char *const names[] = {"extra.exr", "long.exr", "low.exr"};
        if (test_exr_decode(ctx, file_path(names[i]), NULL, -1, &b, &report))
            CHECK_MSG(false, "%s: %s", names[i], test_exr_kept.text[0]);
        else
            CHECK_MSG(test_exr_same(&a, &b), "%s", names[i]);
        ibl_image_free(&b);
    }
    ibl_image_free(&a);
    ibl_image_free(&img);
    ibl_ctx_free(ctx);
}

static void layers(void)
{
    if (!test_exr_ready())
        return;
    ibl_ctx *ctx = file_ctx(2, &test_exr_kept, file_bridge());
    ibl_image img = test_exr_source(ctx, W, H), a = {0};
    ibl_read_report report;
    static const char *const diffuse[] = {"diffuse.R", "diffuse.G",
                                          "diffuse.B"};
    static const char *const nested[] = {"View.Gloss.R", "View.Gloss.G",
                                         "View.Gloss.B"};

    NEED(file_save_pfm(file_path("s.pfm"), &img));
    NEED(file_run(
        "oiiotool s.pfm s.pfm --mulc 2 --chnames diffuse.R,diffuse.G,diffuse.B "
        "--chappend s.pfm --mulc 3 --chnames "
        "View.Gloss.R,View.Gloss.G,View.Gloss.B --chappend -d half "
        "--compression zip -o all.exr --ch diffuse.R,diffuse.G,diffuse.B,"
        "View.Gloss.R,View.Gloss.G,View.Gloss.B,depth.Z=1 -o two.exr "
        "--ch diffuse.R,diffuse.G,diffuse.B,depth.Z -o one.exr "
        "--ch depth.Z,diffuse.R -o none.exr"));
    compare(ctx, "all.exr", NULL, -1, NULL, NULL);
    compare(ctx, "all.exr", "diffuse", -1, diffuse, NULL);
    compare(ctx, "all.exr", "View.Gloss", 0, nested, NULL);
    compare(ctx, "one.exr", NULL, -1, diffuse, NULL);
    CHECK(test_exr_decode(ctx, file_path("two.exr"), NULL, -1, &a, &report) ==
          IBL_ERR_FORMAT);
    CHECK_MSG(strstr(test_exr_kept.text[0], "View.Gloss, diffuse"), "%s",
              test_exr_kept.text[0]);
    CHECK(test_exr_decode(ctx, file_path("two.exr"), "spec", -1, &a, &report) ==
          IBL_ERR_FORMAT);
    CHECK_MSG(strstr(test_exr_kept.text[0], "'spec'") &&
                  strstr(test_exr_kept.text[0], "View.Gloss, diffuse"),
              "%s", test_exr_kept.text[0]);
    CHECK(test_exr_decode(ctx, file_path("none.exr"), NULL, -1, &a, &report) ==
          IBL_ERR_FORMAT);
    CHECK_MSG(strstr(test_exr_kept.text[0], "no colour") &&
                  strstr(test_exr_kept.text[0], "diffuse.R"),
              "%s", test_exr_kept.text[0]);
    CHECK(!a.data);
    ibl_image_free(&img);
    ibl_ctx_free(ctx);
}

static void parts(void)
{
    if (!test_exr_ready())
        return;
    ibl_ctx *ctx = file_ctx(2, &test_exr_kept, file_bridge());
    ibl_image img = test_exr_source(ctx, W, H), a, b;
    ibl_read_report report;

    NEED(file_save_pfm(file_path("s.pfm"), &img));
    NEED(file_run(
        "oiiotool s.pfm --ch Z=1 --attrib oiio:subimagename depth s.pfm "
        "--attrib oiio:subimagename beauty s.pfm --mulc 5 --attrib "
        "oiio:subimagename other --siappendall -d half --compression zip -o "
        "parts.exr --tile 16 16 -o tiles.exr s.pfm --scanline -o one.exr"));
    for (int tiled = 0; tiled < 2; tiled++) {
        const char *name = tiled ? "tiles.exr" : "parts.exr";
        compare(ctx, name, NULL, 1, NULL, &a);
        compare(ctx, name, NULL, 2, NULL, &b);
        CHECK(a.data && b.data && !test_exr_same(&a, &b));
        ibl_image_free(&b);
        CHECK(!test_exr_decode(ctx, file_path(name), NULL, -1, &b, &report));
        CHECK(a.data && b.data &&
              test_exr_same(&a, &b)); /* the first with colour */
        ibl_image_free(&a);
        ibl_image_free(&b);
    }
    CHECK(test_exr_decode(ctx, file_path("parts.exr"), NULL, 0, &a, &report) ==
          IBL_ERR_FORMAT);
    CHECK_MSG(strstr(test_exr_kept.text[0], "no colour"), "%s",
              test_exr_kept.text[0]);
    CHECK(test_exr_decode(ctx, file_path("parts.exr"), NULL, 3, &a, &report) ==
          IBL_ERR_FORMAT);
    CHECK_MSG(strstr(test_exr_kept.text[0], "0 depth, 1 beauty, 2 other"), "%s",
              test_exr_kept.text[0]);
    CHECK(test_exr_decode(ctx, file_path("one.exr"), NULL, 1, &a, &report) ==
          IBL_ERR_FORMAT);
    ibl_image_free(&img);
    ibl_ctx_free(ctx);
}

/* img placed at (x, y) of the map, computed here. */
static void check_placed(ibl_ctx *ctx, const char *file, const ibl_image *img,
                         int x, int y, int width, int height)
{
    ibl_image a = {0};
    compare(ctx, file, NULL, -1, NULL, &a);
    NEED(a.data);
    CHECK(a.width == width && a.height == height);
    for (int j = 0; j < height; j++) {
        for (int i = 0; i < width; i++) {
            const int u = i - x, v = j - y;
            const bool in =
                u >= 0 && v >= 0 && u < img->width && v < img->height;
            const float black[3] = {0, 0, 0};
            const float *want =
                in ? img->data + 3 * (v * img->width + u) : black;
            if (memcmp(a.data + 3 * (j * width + i), want, sizeof black)) {
                test_fail(__FILE__, __LINE__, "%s: pixel %d, %d", file, i, j);
                ibl_image_free(&a);
                return;
            }
        }
    }
    ibl_image_free(&a);
}

static bool opens(ibl_ctx *ctx, const char *name)
{
    ibl_source *source;
    const bool is_open = !ibl_source_open(ctx, file_path(name), NULL, &source);
    if (is_open)
        ibl_source_close(source);
    return is_open;
}

static void windows(void)
{
    if (!test_exr_ready())
        return;
    ibl_ctx *ctx = file_ctx(2, &test_exr_kept, file_bridge());
    ibl_image img = test_exr_source(ctx, W, H);

    NEED(file_save_pfm(file_path("s.pfm"), &img));
    NEED(file_run(
        "oiiotool -d float --compression zip s.pfm --origin +20+9 --fullsize "
        "100x50+0+0 -o inside.exr --tile 16 16 -o inside_t.exr "
        "s.pfm --scanline --origin -10-7 --fullsize 40x20+0+0 -o over.exr "
        "--tile 16 16 -o over_t.exr --scanline "
        "s.pfm --origin +200+0 --fullsize 40x20+0+0 -o empty.exr "
        "s.pfm --fullsize 60000x30000+0+0 -o vast.exr "
        "--create 500x250 3 --fullsize 4096x2048+0+0 -o wide.exr "
        "--create 520x260 3 --fullsize 4096x2048+0+0 -o less.exr "
        "s.pfm -d half --compression zip -o h.exr --origin -10-7 --fullsize "
        "40x20+0+0 -o over_h.exr --tile 16 16 -o over_th.exr --scanline "
        "-d float "
        "s.pfm --compression zips --origin +0+0 --fullsize 40x80+31+0 -o "
        "tall.exr s.pfm --compression none --origin -1000+500 --fullsize "
        "100x50-980+490 -o far.exr --tile 8 64 -o far_t.exr"));
    for (int t = 0; t < 2; t++) {
        check_placed(ctx, t ? "inside_t.exr" : "inside.exr", &img, 20, 9, 100,
                     50);
        check_placed(ctx, t ? "over_t.exr" : "over.exr", &img, -10, -7, 40, 20);
        check_placed(ctx, t ? "far_t.exr" : "far.exr", &img, -20, 10, 100, 50);
    }
    check_placed(ctx, "tall.exr", &img, -31, 0, 40, 80);
    ibl_image a = {0};
    ibl_read_report report;
    NEED(!test_exr_decode(ctx, file_path("h.exr"), NULL, -1, &a, &report));
    check_placed(ctx, "over_h.exr", &a, -10, -7, 40, 20);
    check_placed(ctx, "over_th.exr", &a, -10, -7, 40, 20);
    ibl_image_free(&a);
    /* A frame of up to 64 times the data. */
    CHECK(!opens(ctx, "wide.exr") && opens(ctx, "less.exr"));
    CHECK(test_exr_decode(ctx, file_path("empty.exr"), NULL, -1, &a, &report) ==
          IBL_ERR_FORMAT);
    CHECK_MSG(strstr(test_exr_kept.text[0], "outside"), "%s",
              test_exr_kept.text[0]);
    CHECK(test_exr_decode(ctx, file_path("vast.exr"), NULL, -1, &a, &report) ==
          IBL_ERR_FORMAT);
    CHECK_MSG(strstr(test_exr_kept.text[0], "60000x30000"), "%s",
              test_exr_kept.text[0]);
    ibl_image_free(&img);
    ibl_ctx_free(ctx);
}

static void line_orders_and_mips(void)
{
    if (!test_exr_ready())
        return;
    ibl_ctx *ctx = file_ctx(2, &test_exr_kept, file_bridge());
    ibl_image img = test_exr_source(ctx, W, H), a;

    NEED(file_save_pfm(file_path("s.pfm"), &img));
    NEED(file_run(
        "oiiotool s.pfm -d float --compression zip --attrib openexr:lineOrder "
        "decreasingY -o down.exr --tile 16 16 -o down_t.exr --attrib "
        "openexr:lineOrder randomY -o random_t.exr && oiiotool s.pfm "
        "--compression zip -otex:forcefloat=1:nomipmap=0:filter=box -d float "
        "--tile 16 16 mip.exr || oiiotool s.pfm -d float -otex mip.exr"));
    static const char *const names[] = {"down.exr", "down_t.exr",
                                        "random_t.exr"};
    for (int i = 0; i < 3; i++) {
        compare(ctx, names[i], NULL, -1, NULL, &a);
        CHECK_MSG(a.data && test_exr_same(&a, &img), "%s", names[i]);
        ibl_image_free(&a);
    }
    compare(ctx, "mip.exr", NULL, -1, NULL, NULL);
    ibl_image_free(&img);
    ibl_ctx_free(ctx);
}

static void nonfinite_and_grey(void)
{
    if (!test_exr_ready())
        return;
    ibl_ctx *ctx = file_ctx(2, &test_exr_kept, file_bridge());
    ibl_image img = test_exr_source(ctx, W, H), a;
    static const char *const y[] = {"Y", "Y", "Y"};

    img.data[0] = INFINITY;
    img.data[4] = -INFINITY;
    img.data[8] = NAN;
    img.data[9] = 70000;
    img.data[10] = -0.0f;
    NEED(file_save_pfm(file_path("s.pfm"), &img));
    NEED(file_run("oiiotool s.pfm --compression zip -d half -o h.exr -d float "
                  "-o f.exr --ch R --chnames Y -o y.exr -d half --tile 16 16 "
                  "-o y_t.exr --chnames back.Y -o y_l.exr"));
    compare(ctx, "h.exr", NULL, -1, NULL, &a);
    CHECK(a.data && isinf(a.data[0]) && isinf(a.data[9]));
    ibl_image_free(&a);
    compare(ctx, "f.exr", NULL, -1, NULL, NULL);
    compare(ctx, "y.exr", NULL, -1, y, NULL);
    compare(ctx, "y_t.exr", NULL, -1, y, NULL);
    compare(ctx, "y_l.exr", NULL, -1, NULL, NULL);
    ibl_image_free(&img);
    ibl_ctx_free(ctx);
}

static void every_half(void)
{
    if (!test_exr_ready())
        return;
    ibl_ctx *ctx = file_ctx(2, &test_exr_kept, NULL);
    ibl_image img, a;
    NEED(!ibl_image_alloc(ctx, 256, 86, &img));
    memset(img.data, 0, 3 * sizeof(float) * 256 * 86);
    for (int i = 0; i < 65536; i++) {
        const float f = ibl_half_to_float((uint16_t)i);
        img.data[i] = isnan(f) ? 0 : f;
    }
    NEED(file_save_pfm(file_path("s.pfm"), &img));
    NEED(file_run("oiiotool s.pfm --compression zip -d half -o h.exr"));
    ibl_read_report report;
    NEED(!test_exr_decode(ctx, file_path("h.exr"), NULL, -1, &a, &report));
    CHECK(test_exr_same(&a, &img));
    ibl_image_free(&a);
    ibl_image_free(&img);
    ibl_ctx_free(ctx);
}

static void threads(void)
{
    if (!test_exr_ready())
        return;
    ibl_ctx *one = file_ctx(1, &test_exr_kept, NULL),
            *five = file_ctx(5, &test_exr_kept, NULL);
    ibl_image img = test_exr_source(one, 300, 150), a, b;
    ibl_read_report report;

    NEED(file_save_pfm(file_path("s.pfm"), &img));
    NEED(file_run("oiiotool s.pfm --compression piz -d half -o p.exr "
                  "--compression zips -o z.exr --tile 16 16 -o t.exr"));
    for (char name[] = "p.exr\0z.exr\0t.exr", *p = name; p < name + 18;
         p += 6) {
        NEED(!test_exr_decode(one, file_path(p), NULL, -1, &a, &report));
        NEED(!test_exr_decode(five, file_path(p), NULL, -1, &b, &report));
        CHECK(test_exr_same(&a, &b));
        ibl_image_free(&a);
        ibl_image_free(&b);
    }
    ibl_image_free(&img);
    ibl_ctx_free(one);
    ibl_ctx_free(five);
}

static const test tests[] = {TEST(every_compression),
                             TEST(constant_maps),
                             TEST(every_block_zipped),
                             TEST(dwa_by_bridge),
                             TEST(mixed_types_and_names),
                             TEST(layers),
                             TEST(parts),
                             TEST(windows),
                             TEST(line_orders_and_mips),
                             TEST(nonfinite_and_grey),
                             TEST(every_half),
                             TEST(threads)};
TEST_MAIN(tests)
