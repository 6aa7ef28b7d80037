/* SPDX-License-Identifier: MIT */
/*
 * The EXR reader against OpenImageIO: files are written by oiiotool and read
 * both here and through the bridge, which is OpenImageIO's own reader.
 * Luminance and half-size chroma by OpenEXRCore, against sums in double.
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
#include "io/bridge/bridge.h"
#include "test.h"

enum {
    W = 70,
    H = 35
};

static int take_memory(void *user, const ibl_bridge_info *info, float **rgb,
                       float **alpha)
{
    ibl_image *img = user;

    (void)alpha;
    CHECK(!ibl_image_alloc(test_exr_ctx, info->width, info->height, img));
    test_image(*img);
    *rgb = img->data;
    return 1;
}

static int go_on(void *user)
{
    (void)user;
    return 1;
}

/* OpenImageIO's reading of the same. */
static ibl_status decode_oiio(const char *name, ibl_image *img)
{
    static char message[IBL_BRIDGE_MESSAGE];
    ibl_bridge_request request = {.reader = "openexr",
                                  .threads = 1,
                                  .user = img,
                                  .begin = take_memory,
                                  .go_on = go_on};
    ibl_input in = ibl_input_of(test_exr_ctx, name, NULL, 0);
    ibl_bridge_read_fn *read;

    *img = (ibl_image){0};
    request.bytes = file_load(file_path(name), &request.size);
    NEED(!ibl_bridge_find(&in, NULL, name, IBL_BRIDGE_READ, &read));
    return read(&request, message) ? IBL_ERR_FORMAT : IBL_OK;
}

/* Reads both ways and compares to the bit. */
static ibl_read_report compared; /* of the last file */

static void compare(const char *file, ibl_image *out)
{
    ibl_image ours, theirs;
    CHECK_MSG(!test_exr_decode(file, NULL, -1, &ours, &compared), "%s: %s",
              file, test_exr_kept.text[0]);
    CHECK_MSG(!compared.bridged, "%s went through the bridge", file);
    CHECK_MSG(!decode_oiio(file, &theirs), "%s by OpenImageIO: %s", file,
              test_exr_kept.text[0]);
    if (ours.data && theirs.data)
        CHECK_MSG(test_exr_same(&ours, &theirs), "%s differs from OpenImageIO",
                  file);
    if (out)
        *out = ours;
}

/* Compares a layer or part with a plain file of the same pixels. */
static void same_as(const char *plain, const char *file, const char *layer,
                    int part)
{
    ibl_image a, b;
    CHECK_MSG(!test_exr_decode(plain, NULL, -1, &a, NULL), "%s: %s", plain,
              test_exr_kept.text[0]);
    CHECK_MSG(!test_exr_decode(file, layer, part, &b, NULL), "%s: %s", file,
              test_exr_kept.text[0]);
    if (a.data && b.data)
        CHECK_MSG(test_exr_same(&a, &b), "%s differs from %s", file, plain);
}

static void compare_all(const char *const *files, int count)
{
    for (int i = 0; i < count; i++)
        compare(files[i], NULL);
}

static const char *const shapes[] = {"--scanline", "--tile 32 16"};

TEST(every_compression)
{
    test_exr_begin(3, W, H);
    const char *command = "oiiotool s.pfm", *name[3 * 8 * 2];
    ibl_image back;

    for (int i = 0; i < 3 * 8 * 2; i++) {
        const char *type = test_exr_types[i / 16];
        const char *compression = test_exr_compressions[i / 2 % 8];
        name[i] = test_text("%s_%s_%d.exr", type, compression, i % 2);
        command = test_text("%s -d %s %s --compression %s -o %s", command, type,
                            shapes[i % 2], compression, name[i]);
    }
    NEED(file_run("%s", command));
    for (int i = 0; i < 3 * 8 * 2; i++) {
        if (i / 16 == 2) { /* OpenImageIO makes fractions of them */
            same_as(name[32], name[i], NULL, -1);
            continue;
        }
        compare(name[i], &back);
        CHECK_MSG(!strstr(compared.format, "tiled") == !(i % 2), "%s: %s",
                  name[i], compared.format);
        /* Floats without loss: what went in, not only what another reader
         * says. */
        if (i / 16 == 1 && i / 2 % 8 < 5 && back.data)
            CHECK_MSG(test_exr_same(&back, &test_exr_img),
                      "%s: not what was saved", name[i]);
    }
    NEED(!test_exr_decode(name[32], NULL, -1, &back, NULL));
    for (int i = 0; i < 3 * W * H; i++) {
        const double share = (double)test_exr_img.data[i];
        CHECK_NEAR((double)back.data[i], fmax(fmin(share, 1), 0) * 4294967295,
                   1024);
    }
}

/* The best compression is no damage: large blocks of one colour, also black. */
TEST(constant_maps)
{
    const char *command = "oiiotool -d half";
    test_exr_begin(1, 2, 1);

    for (int i = 0; i < 16; i++)
        command = test_text("%s --create 4096x32 3 --fill:color=.625,.5,.25 "
                            "4096x32 %s --compression %s -o %d.exr",
                            command, i / 8 ? "" : "--mulc 0",
                            test_exr_compressions[i % 8], i);
    NEED(file_run("%s", command));
    for (int i = 0; i < 16; i++)
        compare(test_text("%d.exr", i), NULL);
}

/* Every block deflated, of ZIPS too: those of every_compression's short lines
 * are stored as they are. The last block of 16 lines has one. */
TEST(every_block_zipped)
{
    static const int sample[] = {2, 4, 4};
    char name[64];
    test_exr_begin(3, 301, 33);

    for (int i = 0; i < 3 * 301 * 33; i++)
        test_exr_img.data[i] =
            (float)(i % 3 + 1) * (float)(i / 3 % 301 / 7) / 128;
    NEED(file_save_pfm(file_path("s.pfm"), &test_exr_img));
    NEED(file_run("set --; for type in half float uint32; do set -- \"$@\" -d "
                  "$type --compression none -o $type.exr --compression zip "
                  "-o ${type}_0.exr --compression zips -o ${type}_1.exr; done; "
                  "oiiotool s.pfm \"$@\""));
    for (int i = 0; i < 6; i++) {
        size_t size;
        sprintf(name, "%s_%d.exr", test_exr_types[i / 2], i % 2);
        file_load(file_path(name), &size);
        CHECK(size < (size_t)(301 * 33 * 3 * sample[i / 2] / 2));
        same_as(test_text("%s.exr", test_exr_types[i / 2]), name, NULL, -1);
    }
    compare("half_0.exr", NULL);
    compare("float_1.exr", NULL);
}

TEST(dwa)
{
    test_exr_begin(2, 64, 300);
    ibl_ctx *with = test_exr_ctx, *without = file_ctx(1, &test_exr_kept, NULL);
    ibl_image a, b;
    ibl_read_report report;

    /* Noise does not shrink, and what does not shrink is stored as it is. */
    for (int i = 0; i < 3 * 64 * 300; i++)
        test_exr_img.data[i] =
            0.001f * (float)(i % 192) + 0.01f * (float)(i / 192);
    NEED(file_save_pfm(file_path("s.pfm"), &test_exr_img));
    NEED(file_run(
        "oiiotool s.pfm -d half --compression dwaa -o a.exr --compression dwab "
        "-o b.exr --tile 32 32 --origin +3-7 --fullsize 70x310-1-9 -o c.exr "
        "s.pfm --scanline --fullsize 80x310-5-4 --compression dwaa -o d.exr "
        "s.pfm --ch R=0.25,G=0.5,B=1 "
        "--chnames a.R,a.G,a.B -d uint32 -o e.exr "
        "--scanline --compression zip -d float a.exr -o a_zip.exr "
        "b.exr -o b_zip.exr c.exr -o c_zip.exr d.exr -o d_zip.exr e.exr -d "
        "uint32 -o e_zip.exr"));
    for (char f[] = "a.exr", g[] = "a_zip.exr"; *f <= 'e'; ++*f, ++*g) {
        a = b = (ibl_image){0};
        CHECK_MSG(!test_exr_decode(f, NULL, -1, &a, &report), "%s: %s", f,
                  test_exr_kept.text[0]);
        CHECK(!report.bridged && strstr(report.format, "DWA"));
        CHECK_MSG(!test_exr_decode(g, NULL, -1, &b, &report), "%s", g);
        CHECK(!report.bridged);
        if (a.data && b.data)
            CHECK_MSG(test_exr_same(&a, &b), "%s differs from %s", f, g);
        test_exr_ctx = without;
        test_exr_refused(f, NULL, -1, IBL_ERR_UNSUPPORTED,
                         "DWA*needs libiblexr.so*");
        test_exr_ctx = with;
    }
}

TEST(mixed_types_and_names)
{
    static const char *const mixed[] = {"mixed.exr", "mixed_piz.exr",
                                        "mixed_b44.exr", "extra.exr",
                                        "extra_tiled.exr"};
    static const char *const names[] = {"extra.exr", "long.exr", "low.exr"};
    test_exr_begin(2, W, H);
    ibl_image a, b;

    NEED(file_run(
        "oiiotool s.pfm --ch R,G,B,A=0.5,Z=3,M.a=1,aa=7 -d half --compression "
        "zip -o extra.exr --tile 16 16 -o extra_tiled.exr "
        "s.pfm --scanline -o plain.exr --chnames red,green,blue -o long.exr "
        "--chnames x.y.r,x.y.g,x.y.b -o low.exr s.pfm -d R=half -d G=float -d "
        "B=half -o mixed.exr --compression piz -o mixed_piz.exr --compression "
        "b44 -o mixed_b44.exr"));
    compare_all(mixed, 5);
    NEED(!test_exr_decode("plain.exr", NULL, -1, &a, NULL));
    for (int i = 0; i < 3; i++) {
        CHECK_MSG(!test_exr_decode(names[i], NULL, -1, &b, NULL) &&
                      test_exr_same(&a, &b),
                  "%s: %s", names[i], test_exr_kept.text[0]);
    }
}

TEST(layers)
{
    test_exr_begin(2, W, H);
    NEED(file_run(
        "oiiotool s.pfm s.pfm --mulc 2 --chnames diffuse.R,diffuse.G,diffuse.B "
        "--chappend s.pfm --mulc 3 --chnames "
        "View.Gloss.R,View.Gloss.G,View.Gloss.B --chappend -d half "
        "--compression zip -o all.exr --ch diffuse.R,diffuse.G,diffuse.B,"
        "View.Gloss.R,View.Gloss.G,View.Gloss.B,depth.Z=1 -o two.exr "
        "--ch diffuse.R,diffuse.G,diffuse.B,depth.Z -o one.exr "
        "--ch depth.Z,diffuse.R -o none.exr s.pfm --mulc 2 -o twice.exr "
        "s.pfm --mulc 3 -o thrice.exr"));
    compare("all.exr", NULL);
    same_as("twice.exr", "all.exr", "diffuse", -1);
    same_as("thrice.exr", "all.exr", "View.Gloss", 0);
    same_as("twice.exr", "one.exr", NULL, -1);
    test_exr_refused("two.exr", NULL, -1, IBL_ERR_FORMAT,
                     "View.Gloss, diffuse");
    test_exr_refused("two.exr", "spec", -1, IBL_ERR_FORMAT,
                     "'spec'*View.Gloss, diffuse");
    test_exr_refused("none.exr", NULL, -1, IBL_ERR_FORMAT,
                     "no colour*diffuse.R");
}

TEST(parts)
{
    test_exr_begin(2, W, H);

    NEED(file_run(
        "oiiotool s.pfm --ch Z=1 --attrib oiio:subimagename depth s.pfm "
        "--attrib oiio:subimagename beauty s.pfm --mulc 5 --attrib "
        "oiio:subimagename other --siappendall -d half --compression zip -o "
        "parts.exr --tile 16 16 -o tiles.exr s.pfm --scanline -o one.exr "
        "s.pfm --mulc 5 -o five.exr"));
    for (int tiled = 0; tiled < 2; tiled++) {
        const char *name = tiled ? "tiles.exr" : "parts.exr";
        same_as("one.exr", name, NULL, 1);
        same_as("five.exr", name, NULL, 2);
        same_as("one.exr", name, "beauty", -1);
        test_exr_refused(name, NULL, -1, IBL_ERR_FORMAT,
                         "beauty (part 1), other (part 2)");
    }
    test_exr_refused("parts.exr", NULL, 0, IBL_ERR_FORMAT, "no colour");
    test_exr_refused("parts.exr", NULL, 3, IBL_ERR_FORMAT,
                     "depth (part 0), beauty (part 1)");
    test_exr_refused("one.exr", NULL, 1, IBL_ERR_FORMAT, "part");
}

/* Combined of Combined, Depth and Normal; no coordinates, no Cryptomatte; of
 * parts the one with R, G and B. */
TEST(what_is_colour)
{
    ibl_image a;

    test_exr_begin(2, W, H);
    NEED(file_run(
        "oiiotool s.pfm --chnames V.Combined.R,V.Combined.G,V.Combined.B "
        "s.pfm --chnames V.Normal.X,V.Normal.Y,V.Normal.Z --chappend s.pfm "
        "--chnames V.CryptoObject00.r,V.CryptoObject00.g,V.CryptoObject00.b "
        "--chappend -d half --compression zip -o blender.exr "
        "s.pfm --chnames X,Y,Z -o xyz.exr s.pfm --ch R --chnames Y --attrib "
        "oiio:subimagename matte s.pfm --attrib oiio:subimagename beauty "
        "--siappend -d half -o matte.exr s.pfm -o plain.exr"));
    same_as("plain.exr", "blender.exr", NULL, -1);
    same_as("plain.exr", "blender.exr", "Combined", -1);
    test_exr_refused("xyz.exr", NULL, -1, IBL_ERR_FORMAT, "no colour*X, Y, Z");
    same_as("plain.exr", "matte.exr", NULL, 1);
    same_as("plain.exr", "matte.exr", NULL, -1);
    CHECK(!test_exr_decode("matte.exr", "matte", -1, &a, NULL));
    test_exr_refused("matte.exr", "list", -1, IBL_ERR_FORMAT,
                     "matte (part 0), beauty (part 1)");
}

/* img placed at (x, y) of the map, computed here. */
static void check_placed(const char *file, const ibl_image *img, int x, int y,
                         int width, int height)
{
    ibl_image a = {0};
    NEED(!test_exr_decode(file, NULL, -1, &a, NULL) && a.data);
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
                return;
            }
        }
    }
}

static bool opens(const char *name)
{
    ibl_source *source;
    const bool is_open =
        !ibl_source_open(test_exr_ctx, file_path(name), NULL, &source);
    if (is_open)
        ibl_source_close(source);
    return is_open;
}

TEST(windows)
{
    test_exr_begin(2, W, H);

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
        check_placed(t ? "inside_t.exr" : "inside.exr", &test_exr_img, 20, 9,
                     100, 50);
        check_placed(t ? "over_t.exr" : "over.exr", &test_exr_img, -10, -7, 40,
                     20);
        check_placed(t ? "far_t.exr" : "far.exr", &test_exr_img, -20, 10, 100,
                     50);
    }
    check_placed("tall.exr", &test_exr_img, -31, 0, 40, 80);
    ibl_image a = {0};
    NEED(!test_exr_decode("h.exr", NULL, -1, &a, NULL));
    check_placed("over_h.exr", &a, -10, -7, 40, 20);
    check_placed("over_th.exr", &a, -10, -7, 40, 20);
    /* A frame of up to 64 times the data. */
    CHECK(!opens("wide.exr") && opens("less.exr"));
    test_exr_refused("empty.exr", NULL, -1, IBL_ERR_FORMAT, "outside");
    test_exr_refused("vast.exr", NULL, -1, IBL_ERR_FORMAT, "60000x30000");
}

TEST(line_orders_and_mips)
{
    test_exr_begin(2, W, H);
    ibl_image a;

    NEED(file_run(
        "oiiotool s.pfm -d float --compression zip --attrib openexr:lineOrder "
        "decreasingY -o down.exr --tile 16 16 -o down_t.exr --attrib "
        "openexr:lineOrder randomY -o random_t.exr s.pfm -otex mip.exr"));
    static const char *const names[] = {"down.exr", "down_t.exr",
                                        "random_t.exr"};
    for (int i = 0; i < 3; i++) {
        compare(names[i], &a);
        CHECK_MSG(a.data && test_exr_same(&a, &test_exr_img), "%s", names[i]);
    }
    compare("mip.exr", NULL);
}

TEST(nonfinite_and_grey)
{
    test_exr_begin(2, W, H);
    ibl_image a;

    test_exr_img.data[0] = INFINITY;
    test_exr_img.data[4] = -INFINITY;
    test_exr_img.data[8] = NAN;
    test_exr_img.data[9] = 70000;
    test_exr_img.data[10] = -0.0f;
    NEED(file_save_pfm(file_path("s.pfm"), &test_exr_img));
    NEED(file_run("oiiotool s.pfm --compression zip -d half -o h.exr -d float "
                  "-o f.exr --ch R --chnames Y -o y.exr -d half --tile 16 16 "
                  "-o y_t.exr --chnames back.Y -o y_l.exr"));
    compare("h.exr", &a);
    CHECK(a.data && isinf(a.data[0]) && isinf(a.data[9]));
    compare("f.exr", NULL);
    compare("y.exr", NULL);
    compare("y_t.exr", NULL);
    compare("y_l.exr", NULL);
}

/* Luminance beside chroma is no grey, and every channel has every pixel. */
TEST(sampling_refused)
{
    static float zero[32 * 16];
    const test_exr_channel rgb[] = {{"B", EXR_PIXEL_HALF, 1, zero},
                                    {"G", EXR_PIXEL_HALF, 2, zero},
                                    {"R", EXR_PIXEL_HALF, 1, zero}};
    const test_exr_channel yc[] = {{"BY", EXR_PIXEL_HALF, 2, zero},
                                   {"RY", EXR_PIXEL_HALF, 2, zero},
                                   {"Y", EXR_PIXEL_HALF, 1, zero}};
    test_exr_ctx = file_ctx(1, &test_exr_kept, NULL);

    NEED(test_exr_write(file_path("a.exr"), 32, 16, 0, rgb, 3, NULL, -1));
    test_exr_refused("a.exr", NULL, -1, IBL_ERR_UNSUPPORTED,
                     "channel G is sampled");
    NEED(test_exr_write(file_path("b.exr"), 32, 16, 0, yc, 3, NULL, -1));
    test_exr_refused("b.exr", NULL, -1, IBL_ERR_FORMAT,
                     "it has BY, RY, Y; R, G and B or Y alone");
}
