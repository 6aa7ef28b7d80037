/* SPDX-License-Identifier: MIT */
/*
 * The EXR reader against OpenImageIO: files are written by oiiotool and read
 * both here and through the bridge, which is OpenImageIO's own reader. What
 * oiiotool cannot write (half-size chroma, odd channel lists) is written by
 * OpenEXR's libraries.
 */
#include <OpenEXR/openexr.h>
#include <dlfcn.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "core/context.h"
#include "core/half.h"
#include "files.h"
#include "ibl/io.h"
#include "io/bridge.h"
#include "io/exr.h"
#include "io/exr_file.h"
#include "test.h"

enum {
    W = 70,
    H = 35
};

static test_messages kept;

/* Values of every size, signs, zeros, denormal halves; no two rows alike. */
static void fill(ibl_image *img, uint64_t seed)
{
    test_random r = {seed};
    for (int i = 0; i < 3 * img->width * img->height; i++) {
        const double kind = test_random_unit(&r);
        const double u = test_random_unit(&r);
        img->data[i] = (float)(kind < 0.4    ? 0.25 * (i % 3) + 0.01 * i
                               : kind < 0.9  ? exp(u * 16 - 8)
                               : kind < 0.95 ? -u
                                             : u * 1e-6);
    }
}

static ibl_image source(ibl_ctx *ctx, int width, int height)
{
    ibl_image img;
    if (ibl_image_alloc(ctx, width, height, &img))
        exit(1);
    fill(&img, (uint64_t)width * 1000 + (uint64_t)height);
    return img;
}

/* All rows, in calls of a few at a time, and what was found in each. */
static ibl_status read_rows(ibl_rows *rows, ibl_image *img)
{
    static test_random r = {12};
    const size_t floats = 3 * (size_t)rows->width;
    uint32_t *most = malloc((size_t)rows->height * sizeof *most);
    ibl_status status =
        ibl_image_alloc(rows->ctx, rows->width, rows->height, img);
    const int longest = test_random_u64(&r) % 2 ? 3 : 80;
    while (!status && rows->row < rows->height) {
        const int left = rows->height - rows->row;
        const int some = 1 + (int)(test_random_u64(&r) % (uint64_t)longest);
        status = ibl_rows_read(rows, some < left ? some : left,
                               img->data + floats * (size_t)rows->row,
                               most + rows->row);
    }
    for (int y = 0; !status && y < rows->height; y++) {
        const uint32_t want =
            ibl_most_c(img->data + floats * (size_t)y, floats);
        CHECK(want == most[y] ||
              (want >= IBL_MOST_INFINITE && most[y] >= IBL_MOST_INFINITE));
    }
    if (status)
        ibl_image_free(img);
    free(most);
    return status;
}

static ibl_status decode_bytes(ibl_ctx *ctx, const void *bytes, size_t size,
                               const ibl_read_options *opts, ibl_image *img,
                               ibl_read_report *report)
{
    ibl_input in = ibl_input_of("f.exr", bytes, size);
    ibl_rows *rows;
    ibl_status status = ibl_exr_open(ctx, &in, opts, &rows);
    *img = (ibl_image){0};
    if (!status)
        status = read_rows(rows, img);
    if (!status)
        *report = rows->report;
    ibl_rows_close(rows);
    return status;
}

/* The reader alone, pixels not mended. */
static ibl_status decode(ibl_ctx *ctx, const char *path, const char *layer,
                         int part, ibl_image *img, ibl_read_report *report)
{
    ibl_read_options opts = ibl_read_options_default();
    size_t size;
    unsigned char *bytes = file_load(path, &size);
    opts.any_aspect = 1;
    opts.layer = layer;
    opts.part = part;
    *report = (ibl_read_report){.format = ""};
    memset(&kept, 0, sizeof kept);
    const ibl_status status =
        decode_bytes(ctx, bytes, size, &opts, img, report);
    free(bytes);
    return status;
}

/* OpenImageIO's reading of the same. */
static ibl_status decode_oiio(ibl_ctx *ctx, const char *path, int part,
                              const char *const channels[3], ibl_image *img)
{
    ibl_read_options opts = ibl_read_options_default();
    ibl_rows *rows;
    size_t size;
    unsigned char *bytes = file_load(path, &size);
    ibl_bridge_source s = {.name = "f.exr",
                           .bytes = bytes,
                           .size = size,
                           .kind = "OpenEXR",
                           .reader = "openexr",
                           .subimage = part};
    for (int c = 0; channels && c < 3; c++)
        s.channels[c] = channels[c];
    opts.any_aspect = 1;
    ibl_status status = ibl_bridge_rows(ctx, &s, &opts, &rows);
    *img = (ibl_image){0};
    if (!status)
        status = read_rows(rows, img);
    ibl_rows_close(rows);
    free(bytes);
    return status;
}

static bool same(const ibl_image *a, const ibl_image *b)
{
    return a->width == b->width && a->height == b->height &&
           !memcmp(a->data, b->data,
                   3 * sizeof(float) * (size_t)a->width * (size_t)a->height);
}

/* Reads both ways and compares to the bit. */
static void compare(ibl_ctx *ctx, const char *file, const char *layer, int part,
                    const char *const channels[3], ibl_image *out)
{
    ibl_image ours = {0}, theirs = {0};
    ibl_read_report report;
    const char *path = file_path(file);
    CHECK_MSG(!decode(ctx, path, layer, part, &ours, &report), "%s: %s", file,
              kept.text[0]);
    CHECK_MSG(!report.bridged, "%s went through the bridge", file);
    CHECK_MSG(!decode_oiio(ctx, path, part < 0 ? 0 : part, channels, &theirs),
              "%s by OpenImageIO: %s", file, kept.text[0]);
    if (ours.data && theirs.data)
        CHECK_MSG(same(&ours, &theirs), "%s differs from OpenImageIO", file);
    ibl_image_free(&theirs);
    if (out)
        *out = ours;
    else
        ibl_image_free(&ours);
}

static bool ready(void)
{
    if (!file_bridge() || !file_have("oiiotool")) {
        test_skip("needs the image bridge and oiiotool");
        return false;
    }
    return true;
}

static const char *const compressions[] = {"none", "rle",   "zips", "zip",
                                           "piz",  "pxr24", "b44",  "b44a"};
static const char *const types[] = {"half", "float", "uint32"};
static const char *const shapes[] = {"--scanline", "--tile 32 16"};

static void every_compression(void)
{
    if (!ready())
        return;
    ibl_ctx *ctx = file_ctx(3, &kept, file_bridge());
    ibl_image img = source(ctx, W, H), back;
    char command[8000] = "oiiotool s.pfm", name[64];

    NEED(file_save_pfm(file_path("s.pfm"), &img));
    for (int t = 0; t < 3; t++)
        for (int c = 0; c < 8; c++)
            for (int s = 0; s < 2; s++)
                sprintf(command + strlen(command),
                        " -d %s %s --compression %s -o %s_%s_%d.exr", types[t],
                        shapes[s], compressions[c], types[t], compressions[c],
                        s);
    NEED(file_run("%s", command));
    for (int t = 0; t < 3; t++) {
        for (int c = 0; c < 8; c++) {
            for (int s = 0; s < 2; s++) {
                sprintf(name, "%s_%s_%d.exr", types[t], compressions[c], s);
                compare(ctx, name, NULL, -1, NULL, &back);
                /* Floats without loss: what went in, not only what another
                 * reader says. */
                if (t == 1 && c < 5 && back.data)
                    CHECK_MSG(same(&back, &img), "%s: not what was saved",
                              name);
                ibl_image_free(&back);
            }
        }
    }
    ibl_image_free(&img);
    ibl_ctx_free(ctx);
}

static void dwa_by_bridge(void)
{
    if (!ready())
        return;
    ibl_ctx *ctx = file_ctx(2, &kept, file_bridge());
    ibl_ctx *without = file_ctx(1, &kept, NULL);
    ibl_image img = source(ctx, 64, 300), a, b;
    ibl_read_report report;

    /* Noise does not shrink, and what does not shrink is stored as it is. */
    for (int i = 0; i < 3 * 64 * 300; i++)
        img.data[i] = 0.001f * (float)(i % 192) + 0.01f * (float)(i / 192);
    NEED(file_save_pfm(file_path("s.pfm"), &img));
    NEED(file_run("oiiotool s.pfm -d half --compression dwaa -o a.exr "
                  "--compression dwab -o b.exr --tile 32 32 --compression "
                  "dwab -o c.exr && for f in a b c; do oiiotool $f.exr -d "
                  "float --scanline --compression zip -o ${f}_zip.exr; done && "
                  "oiiotool s.pfm --fullsize 80x310-5-4 -d half --compression "
                  "dwaa -o d.exr && oiiotool d.exr -d float --compression zip "
                  "-o d_zip.exr && oiiotool s.pfm --ch R=0.25,G=0.5,B=1 "
                  "--chnames a.R,a.G,a.B -d uint32 --compression dwaa -o e.exr "
                  "&& oiiotool e.exr "
                  "--compression zip -d uint32 -o e_zip.exr"));
    for (char f[] = "a.exr", g[] = "a_zip.exr"; *f <= 'e'; ++*f, ++*g) {
        a = b = (ibl_image){0};
        CHECK_MSG(!decode(ctx, file_path(f), NULL, -1, &a, &report), "%s: %s",
                  f, kept.text[0]);
        CHECK(report.bridged && strstr(report.format, "DWA"));
        CHECK_MSG(!decode(ctx, file_path(g), NULL, -1, &b, &report), "%s", g);
        CHECK(!report.bridged);
        if (a.data && b.data)
            CHECK_MSG(same(&a, &b), "%s differs from %s", f, g);
        ibl_image_free(&a);
        ibl_image_free(&b);
        CHECK(decode(without, file_path(f), NULL, -1, &a, &report) ==
              IBL_ERR_UNSUPPORTED);
        CHECK_MSG(strstr(kept.text[0], "DWA") &&
                      strstr(kept.text[0], "libopenimageio-dev"),
                  "%s", kept.text[0]);
    }
    ibl_image_free(&img);
    ibl_ctx_free(without);
    ibl_ctx_free(ctx);
}

static void mixed_types_and_names(void)
{
    if (!ready())
        return;
    ibl_ctx *ctx = file_ctx(2, &kept, file_bridge());
    ibl_image img = source(ctx, W, H), a, b;
    ibl_read_report report;

    NEED(file_save_pfm(file_path("s.pfm"), &img));
    NEED(file_run(
        "oiiotool s.pfm --compression zip -d R=half -d G=float -d B=half -o "
        "mixed.exr --compression piz -o mixed_piz.exr --compression b44 -o "
        "mixed_b44.exr && "
        "oiiotool s.pfm --ch R,G,B,A=0.5,Z=3,M.a=1,aa=7 -d half --compression "
        "zip -o extra.exr --tile 16 16 -o extra_tiled.exr && "
        "oiiotool s.pfm -d half --compression zip -o plain.exr --chnames "
        "red,green,blue -o long.exr --chnames x.y.r,x.y.g,x.y.b -o low.exr"));
    compare(ctx, "mixed.exr", NULL, -1, NULL, NULL);
    compare(ctx, "mixed_piz.exr", NULL, -1, NULL, NULL);
    compare(ctx, "mixed_b44.exr", NULL, -1, NULL, NULL);
    compare(ctx, "extra.exr", NULL, -1, NULL, NULL);
    compare(ctx, "extra_tiled.exr", NULL, -1, NULL, NULL);
    CHECK(!decode(ctx, file_path("plain.exr"), NULL, -1, &a, &report));
    for (int i = 0; i < 3; i++) {
        static const char *const names[] = {"extra.exr", "long.exr", "low.exr"};
        if (decode(ctx, file_path(names[i]), NULL, -1, &b, &report))
            CHECK_MSG(false, "%s: %s", names[i], kept.text[0]);
        else
            CHECK_MSG(same(&a, &b), "%s", names[i]);
        ibl_image_free(&b);
    }
    ibl_image_free(&a);
    ibl_image_free(&img);
    ibl_ctx_free(ctx);
}

static void layers(void)
{
    if (!ready())
        return;
    ibl_ctx *ctx = file_ctx(2, &kept, file_bridge());
    ibl_image img = source(ctx, W, H), a = {0};
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
    CHECK(decode(ctx, file_path("two.exr"), NULL, -1, &a, &report) ==
          IBL_ERR_FORMAT);
    CHECK_MSG(strstr(kept.text[0], "View.Gloss, diffuse"), "%s", kept.text[0]);
    CHECK(decode(ctx, file_path("two.exr"), "spec", -1, &a, &report) ==
          IBL_ERR_FORMAT);
    CHECK_MSG(strstr(kept.text[0], "'spec'") &&
                  strstr(kept.text[0], "View.Gloss, diffuse"),
              "%s", kept.text[0]);
    CHECK(decode(ctx, file_path("none.exr"), NULL, -1, &a, &report) ==
          IBL_ERR_FORMAT);
    CHECK_MSG(strstr(kept.text[0], "no colour") &&
                  strstr(kept.text[0], "diffuse.R"),
              "%s", kept.text[0]);
    CHECK(!a.data);
    ibl_image_free(&img);
    ibl_ctx_free(ctx);
}

static void parts(void)
{
    if (!ready())
        return;
    ibl_ctx *ctx = file_ctx(2, &kept, file_bridge());
    ibl_image img = source(ctx, W, H), a, b;
    ibl_read_report report;

    NEED(file_save_pfm(file_path("s.pfm"), &img));
    NEED(file_run(
        "oiiotool s.pfm --ch Z=1 --attrib oiio:subimagename depth s.pfm "
        "--attrib oiio:subimagename beauty s.pfm --mulc 5 --attrib "
        "oiio:subimagename other --siappendall -d half --compression zip -o "
        "parts.exr && oiiotool parts.exr --tile 16 16 -o tiles.exr && oiiotool "
        "s.pfm -d half --compression zip -o one.exr"));
    for (int tiled = 0; tiled < 2; tiled++) {
        const char *name = tiled ? "tiles.exr" : "parts.exr";
        compare(ctx, name, NULL, 1, NULL, &a);
        compare(ctx, name, NULL, 2, NULL, &b);
        CHECK(a.data && b.data && !same(&a, &b));
        ibl_image_free(&b);
        CHECK(!decode(ctx, file_path(name), NULL, -1, &b, &report));
        CHECK(a.data && b.data && same(&a, &b)); /* the first with colour */
        ibl_image_free(&a);
        ibl_image_free(&b);
    }
    CHECK(decode(ctx, file_path("parts.exr"), NULL, 0, &a, &report) ==
          IBL_ERR_FORMAT);
    CHECK_MSG(strstr(kept.text[0], "no colour"), "%s", kept.text[0]);
    CHECK(decode(ctx, file_path("parts.exr"), NULL, 3, &a, &report) ==
          IBL_ERR_FORMAT);
    CHECK_MSG(strstr(kept.text[0], "0 depth, 1 beauty, 2 other"), "%s",
              kept.text[0]);
    CHECK(decode(ctx, file_path("one.exr"), NULL, 1, &a, &report) ==
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

static void windows(void)
{
    if (!ready())
        return;
    ibl_ctx *ctx = file_ctx(2, &kept, file_bridge());
    ibl_image img = source(ctx, W, H);

    NEED(file_save_pfm(file_path("s.pfm"), &img));
    NEED(file_run(
        "oiiotool s.pfm --compression zip -d float --origin +20+9 --fullsize "
        "100x50+0+0 -o inside.exr --tile 16 16 -o inside_t.exr && "
        "oiiotool s.pfm --compression zip -d float --origin -10-7 --fullsize "
        "40x20+0+0 -o over.exr --tile 16 16 -o over_t.exr && "
        "oiiotool s.pfm --compression none -d float --origin -1000+500 "
        "--fullsize 100x50-980+490 -o far.exr --tile 8 64 -o far_t.exr && "
        "oiiotool s.pfm --compression zips -d float --origin +0+0 --fullsize "
        "40x80+31+0 -o tall.exr && "
        "oiiotool s.pfm --compression zip --origin +200+0 --fullsize 40x20+0+0 "
        "-o empty.exr && oiiotool s.pfm --compression zip --fullsize "
        "60000x30000+0+0 -o vast.exr"));
    for (int t = 0; t < 2; t++) {
        check_placed(ctx, t ? "inside_t.exr" : "inside.exr", &img, 20, 9, 100,
                     50);
        check_placed(ctx, t ? "over_t.exr" : "over.exr", &img, -10, -7, 40, 20);
        check_placed(ctx, t ? "far_t.exr" : "far.exr", &img, -20, 10, 100, 50);
    }
    check_placed(ctx, "tall.exr", &img, -31, 0, 40, 80);
    ibl_image a = {0};
    ibl_read_report report;
    CHECK(decode(ctx, file_path("empty.exr"), NULL, -1, &a, &report) ==
          IBL_ERR_FORMAT);
    CHECK_MSG(strstr(kept.text[0], "outside"), "%s", kept.text[0]);
    CHECK(decode(ctx, file_path("vast.exr"), NULL, -1, &a, &report) ==
          IBL_ERR_FORMAT);
    CHECK_MSG(strstr(kept.text[0], "60000x30000"), "%s", kept.text[0]);
    ibl_image_free(&img);
    ibl_ctx_free(ctx);
}

static void line_orders_and_mips(void)
{
    if (!ready())
        return;
    ibl_ctx *ctx = file_ctx(2, &kept, file_bridge());
    ibl_image img = source(ctx, W, H), a;

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
        CHECK_MSG(a.data && same(&a, &img), "%s", names[i]);
        ibl_image_free(&a);
    }
    compare(ctx, "mip.exr", NULL, -1, NULL, NULL);
    ibl_image_free(&img);
    ibl_ctx_free(ctx);
}

static void nonfinite_and_grey(void)
{
    if (!ready())
        return;
    ibl_ctx *ctx = file_ctx(2, &kept, file_bridge());
    ibl_image img = source(ctx, W, H), a;
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
    ibl_ctx *ctx = file_ctx(2, &kept, NULL);
    if (!ready())
        return;
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
    NEED(!decode(ctx, file_path("h.exr"), NULL, -1, &a, &report));
    CHECK(same(&a, &img));
    ibl_image_free(&a);
    ibl_image_free(&img);
    ibl_ctx_free(ctx);
}

static void threads(void)
{
    if (!ready())
        return;
    ibl_ctx *one = file_ctx(1, &kept, NULL), *five = file_ctx(5, &kept, NULL);
    ibl_image img = source(one, 300, 150), a, b;
    ibl_read_report report;

    NEED(file_save_pfm(file_path("s.pfm"), &img));
    NEED(file_run("oiiotool s.pfm --compression piz -d half -o p.exr "
                  "--compression zips -o z.exr --tile 16 16 -o t.exr"));
    for (char name[] = "p.exr\0z.exr\0t.exr", *p = name; p < name + 18;
         p += 6) {
        NEED(!decode(one, file_path(p), NULL, -1, &a, &report));
        NEED(!decode(five, file_path(p), NULL, -1, &b, &report));
        CHECK(same(&a, &b));
        ibl_image_free(&a);
        ibl_image_free(&b);
    }
    ibl_image_free(&img);
    ibl_ctx_free(one);
    ibl_ctx_free(five);
}

/* ---- luminance and chroma ------------------------------------------- */

/* OpenEXR's own RGBA interface (ImfCRgbaFile.h), opened at run time. */
typedef struct imf {
    void *library;
    void *(*new_header)(void);
    void (*delete_header)(void *);
    void (*set_display)(void *, int, int, int, int);
    void (*set_data)(void *, int, int, int, int);
    void (*set_compression)(void *, int);
    void *(*open_output)(const char *, const void *, int);
    int (*set_output)(void *, const void *, size_t, size_t);
    int (*write)(void *, int);
    int (*close_output)(void *);
    void *(*open_input)(const char *);
    int (*set_input)(void *, void *, size_t, size_t);
    int (*read)(void *, int, int);
    int (*close_input)(void *);
} imf;

static bool imf_symbol(imf *l, const char *name, void *call)
{
    void *symbol = l->library ? dlsym(l->library, name) : NULL;
    memcpy(call, &symbol, sizeof symbol);
    return symbol != NULL;
}

static bool imf_open(imf *l)
{
    l->library = dlopen("libOpenEXR-3_1.so.30", RTLD_NOW | RTLD_LOCAL);
    return imf_symbol(l, "ImfNewHeader", &l->new_header) &&
           imf_symbol(l, "ImfDeleteHeader", &l->delete_header) &&
           imf_symbol(l, "ImfHeaderSetDisplayWindow", &l->set_display) &&
           imf_symbol(l, "ImfHeaderSetDataWindow", &l->set_data) &&
           imf_symbol(l, "ImfHeaderSetCompression", &l->set_compression) &&
           imf_symbol(l, "ImfOpenOutputFile", &l->open_output) &&
           imf_symbol(l, "ImfOutputSetFrameBuffer", &l->set_output) &&
           imf_symbol(l, "ImfOutputWritePixels", &l->write) &&
           imf_symbol(l, "ImfCloseOutputFile", &l->close_output) &&
           imf_symbol(l, "ImfOpenInputFile", &l->open_input) &&
           imf_symbol(l, "ImfInputSetFrameBuffer", &l->set_input) &&
           imf_symbol(l, "ImfInputReadPixels", &l->read) &&
           imf_symbol(l, "ImfCloseInputFile", &l->close_input);
}

/* A smooth picture, so that OpenEXR's own reader leaves saturation alone. */
static void smooth(int w, int h, uint16_t *rgba)
{
    for (int y = 0; y < h; y++) {
        for (int x = 0; x < w; x++, rgba += 4) {
            const double a = 0.11 * x + 0.07 * y, b = 0.05 * x - 0.09 * y;
            rgba[0] = ibl_half_from_float((float)(2 + sin(a) + cos(b)));
            rgba[1] = ibl_half_from_float((float)(2.2 + sin(a + 0.4)));
            rgba[2] = ibl_half_from_float((float)(2.4 + cos(b + 0.3)));
            rgba[3] = ibl_half_from_float(1);
        }
    }
}

static void luma_chroma(void)
{
    enum {
        w = 96,
        h = 64,
        left = 4,
        top = 6,
        pad = left + top * w /* so that pixel (0, 0) lies in the arrays */
    };
    static uint16_t saved[pad + w * h][4], theirs[pad + w * h][4];
    static const int codes[] = {0, 1, 2, 3, 4, 5, 6, 7};
    imf l;
    if (!imf_open(&l)) {
        test_skip("libOpenEXR-3_1.so.30 is not here");
        return;
    }
    ibl_ctx *ctx = file_ctx(3, &kept, NULL);
    smooth(w, h, saved[pad]);
    for (int i = 0; i < 8; i++) {
        const char *path = file_path("yc.exr");
        ibl_image ours = {0};
        ibl_read_report report;
        double worst = 0;
        void *header = l.new_header();
        l.set_display(header, left, top, left + w - 1, top + h - 1);
        l.set_data(header, left, top, left + w - 1, top + h - 1);
        l.set_compression(header, codes[i]);
        void *out = l.open_output(path, header, 0x30 /* IMF_WRITE_YC */);
        NEED(out);
        NEED(l.set_output(out, saved[0], 1, w));
        NEED(l.write(out, h));
        l.close_output(out);
        l.delete_header(header);
        void *in = l.open_input(path);
        NEED(in);
        NEED(l.set_input(in, theirs[0], 1, w));
        NEED(l.read(in, top, top + h - 1));
        l.close_input(in);
        CHECK_MSG(!decode(ctx, path, NULL, -1, &ours, &report), "%d: %s", i,
                  kept.text[0]);
        NEED(ours.data && ours.width == w && ours.height == h);
        CHECK(strstr(report.format, "Y RY BY") != NULL);
        for (int j = 0; j < h * w; j++)
            for (int c = 0; c < 3; c++)
                worst = fmax(
                    worst, fabs((double)ours.data[3 * j + c] -
                                (double)ibl_half_to_float(theirs[pad + j][c])));
        /* Values below 4; theirs rounds to half at some four steps, and
         * lowers saturation where B44 has made it uneven. */
        CHECK_NEAR(worst, 0, (codes[i] < 6 ? 4 : 16) * 4 * 0x1p-11);
        ibl_image_free(&ours);
    }
    ibl_ctx_free(ctx);
}

/* A file by OpenEXRCore's writer: channels in any list, one chunk of lines
 * after another. */
typedef struct writer_channel {
    const char *name;
    exr_pixel_type_t type;
    int step;
    const float *data; /* of the samples that there are */
} writer_channel;

static bool write_core(const char *path, int w, int h, exr_compression_t comp,
                       const writer_channel *channels, int count,
                       const exr_attr_chromaticities_t *chroma)
{
    exr_context_initializer_t init = EXR_DEFAULT_CONTEXT_INITIALIZER;
    exr_context_t f;
    exr_encode_pipeline_t pipe = EXR_ENCODE_PIPELINE_INITIALIZER;
    int part, lines;
    bool ok = true;

    if (exr_start_write(&f, path, EXR_WRITE_FILE_DIRECTLY, &init))
        return false;
    ok &= !exr_add_part(f, "p", EXR_STORAGE_SCANLINE, &part);
    ok &= !exr_initialize_required_attr_simple(f, part, w, h, comp);
    for (int i = 0; i < count; i++)
        ok &= !exr_add_channel(f, part, channels[i].name, channels[i].type,
                               EXR_PERCEPTUALLY_LOGARITHMIC, channels[i].step,
                               channels[i].step);
    if (chroma)
        ok &= !exr_attr_set_chromaticities(f, part, "chromaticities", chroma);
    ok &= !exr_write_header(f);
    ok = ok && !exr_get_scanlines_per_chunk(f, part, &lines);
    for (int y = 0; ok && y < h; y += lines) {
        exr_chunk_info_t info;
        ok &= !exr_write_scanline_chunk_info(f, part, y, &info);
        ok &= y ? !exr_encoding_update(f, part, &info, &pipe)
                : !exr_encoding_initialize(f, part, &info, &pipe);
        for (int i = 0; ok && i < pipe.channel_count; i++) {
            exr_coding_channel_info_t *c = &pipe.channels[i];
            const writer_channel *from = channels;
            while (strcmp(from->name, c->channel_name))
                from++;
            c->user_data_type = EXR_PIXEL_FLOAT;
            c->user_bytes_per_element = 4;
            c->user_pixel_stride = 4;
            c->user_line_stride = 4 * w / from->step;
            c->encode_from_ptr =
                (const uint8_t *)(from->data + (size_t)(y / from->step) *
                                                   (size_t)(w / from->step));
        }
        if (!y)
            ok &= !exr_encoding_choose_default_routines(f, part, &pipe);
        ok &= !exr_encoding_run(f, part, &pipe);
    }
    exr_encoding_destroy(f, &pipe);
    return !exr_finish(&f) && ok;
}

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
static void luma_chroma_core(void)
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
    const writer_channel channels[] = {{"BY", EXR_PIXEL_HALF, 2, chroma[1]},
                                       {"RY", EXR_PIXEL_HALF, 2, chroma[0]},
                                       {"Y", EXR_PIXEL_FLOAT, 1, luma}};
    test_random r = {5};
    ibl_ctx *ctx = file_ctx(2, &kept, NULL);
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
        NEED(write_core(file_path("core.exr"), w, h, (exr_compression_t)comp,
                        channels, 3, &aces));
        CHECK_MSG(!decode(ctx, file_path("core.exr"), NULL, -1, &img, &report),
                  "%s", kept.text[0]);
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
        ibl_image_free(&img);
    }
    ibl_ctx_free(ctx);
}

static void sampling_refused(void)
{
    static float zero[32 * 16];
    const writer_channel rgb[] = {{"B", EXR_PIXEL_HALF, 1, zero},
                                  {"G", EXR_PIXEL_HALF, 2, zero},
                                  {"R", EXR_PIXEL_HALF, 1, zero}};
    const writer_channel yc[] = {{"BY", EXR_PIXEL_HALF, 4, zero},
                                 {"RY", EXR_PIXEL_HALF, 4, zero},
                                 {"Y", EXR_PIXEL_HALF, 1, zero}};
    const exr_attr_chromaticities_t flat = {0.3f, 0.3f, 0.3f, 0.3f,
                                            0.3f, 0.3f, 0.3f, 0.3f};
    const writer_channel plain[] = {{"BY", EXR_PIXEL_HALF, 1, zero},
                                    {"RY", EXR_PIXEL_HALF, 1, zero},
                                    {"Y", EXR_PIXEL_HALF, 1, zero}};
    ibl_ctx *ctx = file_ctx(1, &kept, NULL);
    ibl_image img;
    ibl_read_report report;

    NEED(write_core(file_path("a.exr"), 32, 16, 0, rgb, 3, NULL));
    CHECK(decode(ctx, file_path("a.exr"), NULL, -1, &img, &report) ==
          IBL_ERR_UNSUPPORTED);
    CHECK_MSG(strstr(kept.text[0], "channel G is sampled"), "%s", kept.text[0]);
    NEED(write_core(file_path("b.exr"), 32, 16, 0, yc, 3, NULL));
    CHECK(decode(ctx, file_path("b.exr"), NULL, -1, &img, &report) ==
          IBL_ERR_UNSUPPORTED);
    NEED(write_core(file_path("c.exr"), 32, 16, 0, plain, 3, &flat));
    CHECK(decode(ctx, file_path("c.exr"), NULL, -1, &img, &report) ==
          IBL_ERR_FORMAT);
    NEED(write_core(file_path("d.exr"), 32, 16, 0, plain, 3, NULL));
    CHECK(!decode(ctx, file_path("d.exr"), NULL, -1, &img, &report));
    ibl_image_free(&img);
    ibl_ctx_free(ctx);
}

/* ---- alpha beside luminance ------------------------------------------ */

/* Beside half-size chroma, of which an image is made before rows are read. */
static void luma_chroma_alpha(void)
{
    enum {
        w = 40,
        h = 36
    };
    static float luma[h * w], chroma[h / 2 * (w / 2)], alpha[h * w];
    const writer_channel channels[] = {{"A", EXR_PIXEL_FLOAT, 1, alpha},
                                       {"BY", EXR_PIXEL_HALF, 2, chroma},
                                       {"RY", EXR_PIXEL_HALF, 2, chroma},
                                       {"Y", EXR_PIXEL_FLOAT, 1, luma}};
    const writer_channel coarse[] = {{"A", EXR_PIXEL_HALF, 2, chroma},
                                     {"B", EXR_PIXEL_HALF, 1, luma},
                                     {"G", EXR_PIXEL_HALF, 1, luma},
                                     {"R", EXR_PIXEL_HALF, 1, luma}};
    ibl_ctx *ctx = file_ctx(2, &kept, NULL);
    ibl_read_options opts = ibl_read_options_default();
    ibl_source *source;
    static float rgb[3 * w * h];

    opts.any_aspect = 1;
    for (int i = 0; i < w * h; i++) {
        alpha[i] = (float)(i % 7) / 6;
        luma[i] = 2 * alpha[i];
    }
    for (int comp = 0; comp < 4; comp++) {
        NEED(write_core(file_path("core.exr"), w, h, (exr_compression_t)comp,
                        channels, 4, NULL));
        for (int want = 0; want < 2; want++) {
            opts.alpha = want ? IBL_ALPHA_FILE : IBL_ALPHA_IGNORE;
            NEED(!ibl_source_open(ctx, file_path("core.exr"), &opts, &source));
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
    NEED(write_core(file_path("a.exr"), w, h, 0, coarse, 4, NULL));
    CHECK(ibl_source_open(ctx, file_path("a.exr"), &opts, &source) ==
          IBL_ERR_UNSUPPORTED);
    CHECK_MSG(strstr(kept.text[0], "channel A is sampled"), "%s", kept.text[0]);
    opts.alpha = IBL_ALPHA_IGNORE;
    NEED(!ibl_source_open(ctx, file_path("a.exr"), &opts, &source));
    ibl_source_close(source);
    ibl_ctx_free(ctx);
}

/* ---- damage --------------------------------------------------------- */

/* Decodes bytes in memory of just their size, so that a sanitizer sees every
 * byte too far. True if it went well or was refused with one line. */
static bool survives(ibl_ctx *ctx, const unsigned char *bytes, size_t size,
                     ibl_status *status)
{
    ibl_read_options opts = ibl_read_options_default();
    ibl_read_report report = {.format = ""};
    ibl_image img = {0};
    unsigned char *copy = malloc(size ? size : 1);
    memcpy(copy, bytes, size);
    memset(&kept, 0, sizeof kept);
    opts.any_aspect = 1;
    opts.alpha = IBL_ALPHA_FILE;
    *status = decode_bytes(ctx, copy, size, &opts, &img, &report);
    free(copy);
    if (!*status) {
        ibl_image_free(&img);
        return true;
    }
    return kept.text[0][0] && !img.data && !strchr(kept.text[0], '\n');
}

static void cut_short(void)
{
    if (!ready())
        return;
    ibl_ctx *ctx = file_ctx(2, &kept, NULL);
    ibl_image img = source(ctx, 24, 40);

    NEED(file_save_pfm(file_path("s.pfm"), &img));
    NEED(file_run("oiiotool s.pfm -d half --compression zip -o 0.exr "
                  "--compression piz -o 1.exr --tile 16 16 --compression b44 "
                  "-o 2.exr && oiiotool 0.exr 0.exr --siappend -o 3.exr"));
    for (int i = 0; i < 4; i++) {
        char name[] = "0.exr";
        size_t size;
        name[0] = (char)('0' + i);
        unsigned char *bytes = file_load(file_path(name), &size);
        ibl_status status;
        /* A multi-part file's first part may be whole in a cut file. */
        const size_t end = i == 3 ? size / 2 : size;
        for (size_t n = 0; n < end; n += n < 600 ? 1 : 7) {
            CHECK_MSG(survives(ctx, bytes, n, &status), "%s at %zu", name, n);
            CHECK_MSG(status == IBL_ERR_FORMAT, "%s at %zu: %d", name, n,
                      status);
        }
        free(bytes);
    }
    ibl_image_free(&img);
    ibl_ctx_free(ctx);
}

static void bits_flipped(void)
{
    if (!ready())
        return;
    ibl_ctx *ctx = file_ctx(2, &kept, NULL);
    ibl_image img = source(ctx, 24, 40);
    test_random r = {2024};
    char command[2000] = "oiiotool s.pfm --ch R,G,B,A=0.5";
    int refused = 0;

    NEED(file_save_pfm(file_path("s.pfm"), &img));
    for (int c = 0; c < 8; c++)
        sprintf(command + strlen(command),
                " -d %s --compression %s --scanline -o %d.exr --tile 16 16 -o "
                "%d.exr",
                types[c % 2], compressions[c], 2 * c, 2 * c + 1);
    NEED(file_run("%s", command));
    for (int i = 0; i < 16; i++) {
        char name[16];
        size_t size;
        sprintf(name, "%d.exr", i);
        unsigned char *bytes = file_load(file_path(name), &size);
        for (int round = 0; round < 250; round++) {
            unsigned char was[3];
            size_t at[3];
            ibl_status status;
            for (int k = 0; k < 3; k++) {
                const size_t range = round % 2 ? size : 700;
                at[k] = (size_t)(test_random_unit(&r) *
                                 (double)(range < size ? range : size));
                was[k] = bytes[at[k]];
                bytes[at[k]] ^= (unsigned char)(1 << test_random_u64(&r) % 8);
            }
            CHECK_MSG(survives(ctx, bytes, size, &status), "%s round %d", name,
                      round);
            refused += status != IBL_OK;
            for (int k = 3; k-- > 0;)
                bytes[at[k]] = was[k];
        }
        free(bytes);
    }
    CHECK(refused > 100);
    ibl_image_free(&img);
    ibl_ctx_free(ctx);
}

/* Where the value of an attribute begins. */
static unsigned char *attribute(unsigned char *bytes, size_t size,
                                const char *name, const char *type)
{
    const size_t n = strlen(name) + 1, t = strlen(type) + 1;
    for (size_t i = 8; i + n + t + 4 < size; i++)
        if (!memcmp(bytes + i, name, n) && !memcmp(bytes + i + n, type, t))
            return bytes + i + n + t + 4;
    return NULL;
}

static void patch32(unsigned char *at, uint32_t v)
{
    for (int i = 0; i < 4; i++)
        at[i] = (unsigned char)(v >> 8 * i);
}

static void absurd_claims(void)
{
    static const int32_t boxes[][4] = {{0, 0, 65535, 32767},
                                       {0, 0, 0x3ffffffe, 0x3ffffffe},
                                       {0, 0, -1, -1},
                                       {5, 5, 4, 4},
                                       {-0x7fffffff, 0, 0, 9},
                                       {0, 0, 0x7fffffff, 9},
                                       {0, 0, 65535, 39},
                                       {0, 0, 23, 0x3ffffff},
                                       {0x3ffffff0, 0, 0x3ffffff8, 9}};
    if (!ready())
        return;
    ibl_ctx *ctx = file_ctx(2, &kept, NULL);
    ibl_image img = source(ctx, 24, 40);

    NEED(file_save_pfm(file_path("s.pfm"), &img));
    NEED(file_run("oiiotool s.pfm -d half --compression zip -o 0.exr --tile 16 "
                  "16 -o 1.exr --compression none --scanline -o 2.exr"));
    for (int i = 0; i < 3; i++) {
        char name[] = "0.exr";
        size_t size;
        ibl_status status;
        name[0] = (char)('0' + i);
        unsigned char *bytes = file_load(file_path(name), &size);
        for (size_t b = 0; b < sizeof boxes / sizeof boxes[0]; b++) {
            for (int both = 0; both < 2; both++) {
                unsigned char *copy = malloc(size);
                memcpy(copy, bytes, size);
                for (int k = 0; k < 4; k++) {
                    patch32(attribute(copy, size, "dataWindow", "box2i") +
                                4 * k,
                            (uint32_t)boxes[b][k]);
                    if (both)
                        patch32(
                            attribute(copy, size, "displayWindow", "box2i") +
                                4 * k,
                            (uint32_t)boxes[b][k]);
                }
                CHECK_MSG(survives(ctx, copy, size, &status) &&
                              (status == IBL_ERR_FORMAT ||
                               status == IBL_ERR_UNSUPPORTED),
                          "%s box %zu: %d %s", name, b, status, kept.text[0]);
                free(copy);
            }
        }
        if (i == 1) {
            unsigned char *copy = malloc(size);
            memcpy(copy, bytes, size);
            for (uint32_t v = 0; v < 0x40000000u; v = v * 2 + 1) {
                patch32(attribute(copy, size, "tiles", "tiledesc"), v);
                CHECK(survives(ctx, copy, size, &status));
            }
            free(copy);
        }
        free(bytes);
    }
    ibl_image_free(&img);
    ibl_ctx_free(ctx);
}

static void refused_kinds(void)
{
    if (!ready())
        return;
    ibl_ctx *ctx = file_ctx(2, &kept, NULL);
    ibl_image img = source(ctx, W, H), a = {0};
    ibl_read_report report;

    NEED(file_save_pfm(file_path("s.pfm"), &img));
    NEED(file_run("oiiotool s.pfm --ch R,G,B,A=1,Z=1 -d half --deepen -o "
                  "deep.exr && oiiotool s.pfm --ch Z=1,id=2 -o z.exr && "
                  "oiiotool s.pfm -d half --compression zip -o cube.exr"));
    CHECK(decode(ctx, file_path("deep.exr"), NULL, -1, &a, &report) ==
          IBL_ERR_UNSUPPORTED);
    CHECK_MSG(strstr(kept.text[0], "deep"), "%s", kept.text[0]);
    CHECK(decode(ctx, file_path("z.exr"), NULL, -1, &a, &report) ==
          IBL_ERR_FORMAT);
    CHECK_MSG(strstr(kept.text[0], "Z, id"), "%s", kept.text[0]);
    ibl_image_free(&img);
    ibl_ctx_free(ctx);
}

static const test tests[] = {TEST(every_compression),
                             TEST(dwa_by_bridge),
                             TEST(mixed_types_and_names),
                             TEST(layers),
                             TEST(parts),
                             TEST(windows),
                             TEST(line_orders_and_mips),
                             TEST(nonfinite_and_grey),
                             TEST(every_half),
                             TEST(threads),
                             TEST(luma_chroma),
                             TEST(luma_chroma_core),
                             TEST(sampling_refused),
                             TEST(luma_chroma_alpha),
                             TEST(cut_short),
                             TEST(bits_flipped),
                             TEST(absurd_claims),
                             TEST(refused_kinds)};
TEST_MAIN(tests)
