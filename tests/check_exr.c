/* SPDX-License-Identifier: MIT */
/*
 * The EXR reader against OpenImageIO's own: files are written by oiiotool and
 * compared with what it makes of them, uncompressed floats, of which those that
 * went in come out. Which part and channels are the picture; windows; headers
 * and blocks that lie. Files that are cut, and rows in any order of calls, are
 * check_read's.
 */
#include <fnmatch.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <zlib.h>

#include "files.h"
#include "maps.h"

enum {
    W = 70,
    H = 35
};

static test_messages kept;
static ibl_ctx *ctx;
static ibl_image source; /* also s.pfm */

/* Values of every size, signs, zeros, denormal halves, no two rows alike. */
static void begin(int threads, int width, int height)
{
    test_random r = {(uint64_t)width * 1000 + (uint64_t)height};

    file_need_oiio();
    ctx = file_ctx(threads, &kept, file_bridge());
    source = map_constant(ctx, width, height, 0);
    for (int i = 0; i < 3 * width * height; i++) {
        const double kind = test_random_unit(&r);
        const double u = test_random_unit(&r);
        source.data[i] = (float)(kind < 0.4    ? 0.25 * (i % 3) + 0.01 * i
                                 : kind < 0.9  ? exp(u * 16 - 8)
                                 : kind < 0.95 ? -u
                                               : u * 1e-6);
    }
    CHECK(file_save_pfm(file_path("s.pfm"), &source));
}

/* ---- reading both ways -------------------------------------------------- */

/* By our reader alone, pixels not mended. */
static ibl_status decode_bytes(const char *name, const void *bytes, size_t size,
                               const ibl_read_options *opts, ibl_image *img,
                               ibl_read_report *report)
{
    ibl_input in = ibl_input_of(ctx, name, bytes, size);
    ibl_rows *rows = NULL;

    memset(&kept, 0, sizeof kept);
    ibl_status status = ibl_rows_open(&in, opts, &rows);
    *img = (ibl_image){0};
    if (!status)
        status = file_read_rows(rows, img);
    if (!status && report)
        *report = rows->report;
    ibl_rows_close(rows);
    test_image(*img);
    return status;
}

static ibl_status decode(const char *name, const char *layer, int part,
                         ibl_image *img, ibl_read_report *report)
{
    ibl_read_options opts = ibl_read_options_default();
    size_t size;
    unsigned char *bytes = file_load(file_path(name), &size);

    opts.any_aspect = 1;
    opts.layer = layer;
    opts.part = part;
    return decode_bytes(name, bytes, size, &opts, img, report);
}

/* Files as OpenImageIO reads them. */
static void convert(const char *names)
{
    NEED(file_run("set --; for f in %s; do set -- \"$@\" $f --selectmip 0 "
                  "--scanline -d float "
                  "--compression none -o plain_$f.exr; done; oiiotool \"$@\"",
                  names));
}

/* Reads both, which give the same bits; returns them. */
static ibl_image compare(const char *file)
{
    ibl_image ours, theirs;
    ibl_read_report report = {.format = ""};

    CHECK_MSG(!decode(file, NULL, -1, &ours, &report), "%s: %s", file,
              kept.text[0]);
    CHECK_MSG(!report.bridged &&
                  !strstr(report.format, "tiled") == !strstr(file, "tile"),
              "%s: %s", file, report.format);
    CHECK_MSG(
        !decode(test_text("plain_%s.exr", file), NULL, -1, &theirs, NULL) &&
            map_same(&ours, &theirs),
        "%s differs from OpenImageIO", file);
    return ours;
}

/* Compares a layer or part with a plain file of the same pixels. */
static void same_as(const char *plain, const char *file, const char *layer,
                    int part)
{
    ibl_image a, b;

    CHECK_MSG(!decode(plain, NULL, -1, &a, NULL) &&
                  !decode(file, layer, part, &b, NULL) && map_same(&a, &b),
              "%s is not %s: %s", file, plain, kept.text[0]);
}

/* A file is refused with these words, * between them for any. */
static void refused(const char *name, const char *layer, int part,
                    ibl_status want, const char *words)
{
    ibl_image img;
    const ibl_status status = decode(name, layer, part, &img, NULL);

    CHECK_MSG(status == want && !img.data &&
                  !fnmatch(test_text("*%s*", words), kept.text[0], 0),
              "%s: %d %s", name, status, kept.text[0]);
}

/* ---- blocks ------------------------------------------------------------ */

static const char *const types[] = {"half", "float", "uint32"};
static const char *const compressions[] = {"none", "rle",   "zips", "zip",
                                           "piz",  "pxr24", "b44",  "b44a",
                                           "dwaa", "dwab"};

/* Noise, which is stored as it is where it does not shrink; a ramp, of which
 * every block is deflated, the last one of 16 lines having one; and large
 * blocks of one colour, also of black: the best compression is no damage. */
static const struct {
    const char *make;
    int types, shapes;
} pictures[] = {
    {"s.pfm", 3, 2},
    {"ramp.pfm", 2, 1},
    {"--create 4096x64 3 --fill:color=.625,.5,.25 4096x32+0+32", 1, 1},
};

/* The name of file i of a picture: types, compressions, lines or tiles. */
static const char *name_of(int picture, int i)
{
    const int shapes = pictures[picture].shapes;

    return test_text("%d_%s_%s_%s.exr", picture, types[i / shapes / 10],
                     compressions[i / shapes % 10],
                     i % shapes ? "tile" : "line");
}

TEST_SLOW(every_compression)
{
    const char *command = "oiiotool";
    ibl_image back;

    begin(3, 301, 33);
    for (int i = 0; i < 3 * 301 * 33; i++)
        source.data[i] = (float)(i % 3 + 1) * (float)(i / 3 % 301 / 7) / 128;
    NEED(file_save_pfm(file_path("ramp.pfm"), &source));
    begin(3, W, H);
    for (int p = 0; p < 3; p++)
        for (int i = 0; i < pictures[p].types * 10 * pictures[p].shapes; i++) {
            const int k = i / pictures[p].shapes;
            command = test_text("%s %s -d %s %s --compression %s -o %s",
                                command, pictures[p].make, types[k / 10],
                                i % pictures[p].shapes ? "--tile 32 16"
                                                       : "--scanline",
                                compressions[k % 10], name_of(p, i));
        }
    NEED(file_run("%s", command));
    convert("?_half_* ?_float_*");
    for (int p = 0; p < 3; p++)
        for (int i = 0; i < pictures[p].types * 10 * pictures[p].shapes; i++) {
            const int type = i / pictures[p].shapes / 10;
            const int c = i / pictures[p].shapes % 10;
            const char *name = name_of(p, i);
            size_t size;
            if (type == 2) { /* OpenImageIO makes fractions of them */
                same_as("0_uint32_none_line.exr", name, NULL, -1);
                continue;
            }
            back = compare(name);
            /* Floats without loss: what went in, not only what another reader
             * says. */
            if (!p && type == 1 && c < 5)
                CHECK_MSG(map_same(&back, &source), "%s: not what was saved",
                          name);
            file_load(file_path(name), &size);
            if (p == 1 && c / 2 == 1)
                CHECK(size < (size_t)(301 * 33 * 3 * (type ? 2 : 1)));
        }
    NEED(!decode("0_uint32_none_line.exr", NULL, -1, &back, NULL));
    for (int i = 0; i < 3 * W * H; i++)
        CHECK_NEAR((double)back.data[i],
                   fmax(fmin((double)source.data[i], 1), 0) * 4294967295, 1024);
    ctx = file_ctx(1, &kept, NULL);
    refused("0_half_dwaa_line.exr", NULL, -1, IBL_ERR_UNSUPPORTED,
            "DWA*needs libiblexr.so*");
}

/* Types side by side, mip levels, values that are not finite, grey; orders of
 * lines, which are of what went in; and Radiance's files, of which OpenImageIO
 * 2.4 leaves scanlines as they lie and EXPOSURE alone: its own, and others'
 * where they are there. Its 2^(e - 136) is one unit in the last place low where
 * e is 40, 223 or 226. */
TEST_SLOW(as_openimageio)
{
    static const char *const names[] = {"down.exr",
                                        "down_tile.exr",
                                        "random_tile.exr",
                                        "mixed.exr",
                                        "mixed_piz.exr",
                                        "mixed_b44.exr",
                                        "extra.exr",
                                        "extra_tile.exr",
                                        "tile_mip.exr",
                                        "h.exr",
                                        "f.exr",
                                        "y.exr",
                                        "y_tile.exr",
                                        "y_l.exr",
                                        "a.hdr",
                                        "flat.hdr",
                                        "quarry_01_1k.hdr",
                                        "royal_esplanade_1k.hdr"};

    begin(2, W, H);
    source.data[0] = INFINITY;
    source.data[4] = -INFINITY;
    source.data[8] = NAN;
    source.data[9] = 70000;
    source.data[10] = -0.0f;
    NEED(file_save_pfm(file_path("s.pfm"), &source));
    NEED(file_run(
        "for f in \"$OLDPWD\"/../shared/data/*.hdr; do "
        "[ ! -e \"$f\" ] || ln -s \"$f\" .; done; "
        "oiiotool s.pfm -d float --compression zip -o f.exr --attrib "
        "openexr:lineOrder decreasingY -o down.exr --tile 16 16 -o "
        "down_tile.exr --attrib openexr:lineOrder randomY -o random_tile.exr "
        "--scanline s.pfm --ch R,G,B,A=0.5,Z=3,M.a=1,aa=7 -d half "
        "-o extra.exr --tile 16 16 -o extra_tile.exr s.pfm --scanline -d "
        "R=half -d G=float -d B=half -o mixed.exr --compression piz -o "
        "mixed_piz.exr --compression b44 -o mixed_b44.exr "
        "s.pfm --compression zip -d half -o h.exr -d float "
        "--ch R --chnames Y -o y.exr -d half --tile 16 16 "
        "-o y_tile.exr --scanline --chnames back.Y -o y_l.exr "
        "s.pfm -otex tile_mip.exr --create 640x70 3 --fill:topleft=9,5,1:"
        "topright=0,1,2:bottomleft=1e3,0,1e-3:bottomright=1,1,1 640x70 -o "
        "a.hdr --crop 7x70+0+0 -o flat.hdr"));
    convert("down* random* mixed* extra* tile_mip.exr ?.exr y_* *.hdr");
    for (int i = 0; i < (test_shared_data(names[16]) ? 18 : 16); i++) {
        const ibl_image back = compare(names[i]);
        CHECK_MSG(i > 2 || map_same(&back, &source), "%s", names[i]);
    }
}

/* ---- parts and channels ------------------------------------------------- */

/* A name or a part of a file that is a plain one, or the words of a refusal.
 * Combined is the picture of Combined, Depth and Normal; coordinates are none,
 * nor is Cryptomatte; of parts it is the one with R, G and B. Luminance beside
 * chroma is no grey. */
static const struct {
    const char *file, *layer;
    int part;
    const char *same, *words;
} choices[] = {
    {"long.exr", NULL, -1, "one.exr", NULL},
    {"low.exr", NULL, -1, "one.exr", NULL},
    {"all.exr", NULL, -1, "one.exr", NULL},
    {"all.exr", "diffuse", -1, "two.exr", NULL},
    {"all.exr", "View.Gloss", 0, "three.exr", NULL},
    {"only.exr", NULL, -1, "two.exr", NULL},
    {"both.exr", NULL, -1, NULL, "View.Gloss, diffuse"},
    {"both.exr", "spec", -1, NULL, "'spec'*View.Gloss, diffuse"},
    {"none.exr", NULL, -1, NULL, "no colour*diffuse.R"},
    {"parts.exr", NULL, 1, "one.exr", NULL},
    {"parts.exr", NULL, 2, "three.exr", NULL},
    {"parts.exr", "beauty", -1, "one.exr", NULL},
    {"parts.exr", NULL, -1, NULL, "beauty (part 1), other (part 2)"},
    {"parts.exr", NULL, 0, NULL, "no colour"},
    {"parts.exr", NULL, 3, NULL, "depth (part 0), beauty (part 1)"},
    {"tiles.exr", NULL, 1, "one.exr", NULL},
    {"tiles.exr", NULL, 2, "three.exr", NULL},
    {"one.exr", NULL, 1, NULL, "part"},
    {"blender.exr", NULL, -1, "one.exr", NULL},
    {"blender.exr", "Combined", -1, "one.exr", NULL},
    {"xyz.exr", NULL, -1, NULL, "no colour*X, Y, Z"},
    {"matte.exr", NULL, 1, "one.exr", NULL},
    {"matte.exr", NULL, -1, "one.exr", NULL},
    {"matte.exr", "matte", -1, "matte.exr", NULL},
    {"matte.exr", "list", -1, NULL, "matte (part 0), beauty (part 1)"},
    {"chroma.exr", NULL, -1, NULL, "it has BY, RY, Y; R, G and B or Y alone"},
    {"z.exr", NULL, -1, NULL, "Z, id"},
};

TEST(what_is_colour)
{
    begin(2, W, H);
    NEED(file_run(
        "oiiotool -d half --compression zip s.pfm --ch Z=1 --attrib "
        "oiio:subimagename depth s.pfm "
        "--attrib oiio:subimagename beauty s.pfm --mulc 3 --attrib "
        "oiio:subimagename other --siappendall -o "
        "parts.exr --tile 16 16 -o tiles.exr --scanline "
        "s.pfm -o one.exr --chnames "
        "red,green,blue -o long.exr --chnames x.y.r,x.y.g,x.y.b -o low.exr "
        "--chnames BY,RY,Y -o chroma.exr "
        "s.pfm --mulc 2 -o two.exr s.pfm --mulc 3 -o three.exr "
        "s.pfm s.pfm --mulc 2 --chnames diffuse.R,diffuse.G,diffuse.B "
        "--chappend s.pfm --mulc 3 --chnames "
        "View.Gloss.R,View.Gloss.G,View.Gloss.B --chappend -o all.exr "
        "--ch diffuse.R,diffuse.G,diffuse.B,"
        "View.Gloss.R,View.Gloss.G,View.Gloss.B,depth.Z=1 -o both.exr "
        "--ch diffuse.R,diffuse.G,diffuse.B,depth.Z -o only.exr "
        "--ch depth.Z,diffuse.R -o none.exr "
        "s.pfm --chnames V.Combined.R,V.Combined.G,V.Combined.B "
        "s.pfm --chnames V.Normal.X,V.Normal.Y,V.Normal.Z --chappend s.pfm "
        "--chnames V.CryptoObject00.r,V.CryptoObject00.g,V.CryptoObject00.b "
        "--chappend -o blender.exr s.pfm --chnames X,Y,Z -o xyz.exr "
        "s.pfm --ch R --chnames Y --attrib oiio:subimagename matte s.pfm "
        "--attrib oiio:subimagename beauty --siappend -o matte.exr "
        "s.pfm --ch Z=1,id=2 -o z.exr "
        "s.pfm --ch R,G,B,A=1,Z=1 --deepen -o deep.exr"));
    for (size_t i = 0; i < sizeof choices / sizeof *choices; i++) {
        const char *file = choices[i].file, *layer = choices[i].layer;
        ibl_image img;
        if (!choices[i].same)
            refused(file, layer, choices[i].part, IBL_ERR_FORMAT,
                    choices[i].words);
        else if (strcmp(file, choices[i].same))
            same_as(choices[i].same, file, layer, choices[i].part);
        else
            CHECK(!decode(file, layer, -1, &img, NULL));
    }
    refused("deep.exr", NULL, -1, IBL_ERR_UNSUPPORTED, "deep");
}

/* ---- windows ------------------------------------------------------------ */

/* A file that has img at (x, y) of its map: placed here, on black. */
static void check_placed(const char *file, const ibl_image *img, int x, int y,
                         int width, int height)
{
    static const float black[3];
    ibl_image a = {0};

    NEED(!decode(file, NULL, -1, &a, NULL) && a.data);
    CHECK(a.width == width && a.height == height);
    for (int i = 0; i < width * height; i++) {
        const int u = i % width - x, v = i / width - y;
        const bool in = u >= 0 && v >= 0 && u < img->width && v < img->height;
        const float *want = in ? img->data + 3 * (v * img->width + u) : black;
        if (memcmp(a.data + 3 * i, want, sizeof black)) {
            test_fail(__FILE__, __LINE__, "%s: pixel %d", file, i);
            return;
        }
    }
}

TEST_SLOW(windows)
{
    static const struct {
        const char *file, *options;
        int x, y, width, height;
    } cases[] = {
        {"inside.exr", "--origin +20+9 --fullsize 100x50+0+0", 20, 9, 100, 50},
        {"over.exr", "--origin -10-7 --fullsize 40x20+0+0", -10, -7, 40, 20},
        {"far.exr", "--origin -1000+500 --fullsize 100x50-980+490", -20, 10,
         100, 50},
        {"tall.exr", "--origin +0+0 --fullsize 40x80+31+0", -31, 0, 40, 80},
        {"cover.exr", "--origin +3-7 --fullsize 60x20+5-4", -2, -3, 60, 20},
    };
    static const char *const ways[] = {
        "-d float --compression zip",
        "-d float --compression none",
        "-d float --compression zips --tile 16 16",
        "-d half --compression zip",
        "-d half --compression dwaa",
        "-d half --compression dwab --tile 8 64"};
    const char *command = "oiiotool";

    begin(2, W, H);
    for (int i = 0; i < 6 * 6; i++)
        command = i % 6 == 5
                      ? test_text("%s s.pfm --scanline %s -o %d_plain.exr",
                                  command, ways[i / 6], i / 6)
                      : test_text("%s s.pfm --scanline %s %s -o %d_%s", command,
                                  ways[i / 6], cases[i % 6].options, i / 6,
                                  cases[i % 6].file);
    NEED(file_run("%s s.pfm --scanline --fullsize 40x20-300+0 -o empty.exr "
                  "s.pfm --fullsize 60000x30000+0+0 -o vast.exr --create "
                  "500x250 3 --fullsize 4096x2048+0+0 -o wide.exr --create "
                  "520x260 3 --fullsize 4096x2048+0+0 -o less.exr",
                  command));
    for (int i = 0; i < 6 * 5; i++) {
        ibl_image plain;
        const int way = i / 5, c = i % 5;
        NEED(!decode(test_text("%d_plain.exr", way), NULL, -1, &plain, NULL));
        check_placed(test_text("%d_%s", way, cases[c].file), &plain, cases[c].x,
                     cases[c].y, cases[c].width, cases[c].height);
    }
    /* A frame of up to 64 times the data. */
    ibl_image img;
    CHECK(!decode("less.exr", NULL, -1, &img, NULL));
    refused("wide.exr", NULL, -1, IBL_ERR_FORMAT, "4096x2048*500x250");
    refused("empty.exr", NULL, -1, IBL_ERR_FORMAT, "outside");
    refused("vast.exr", NULL, -1, IBL_ERR_FORMAT, "60000x30000");
}

/* ---- lies --------------------------------------------------------------- */

/* Where the value of an attribute begins; of NULL, the table of blocks. */
static unsigned char *attribute(unsigned char *bytes, const char *name)
{
    unsigned char *at = bytes + 8;

    while (*at && (!name || strcmp((char *)at, name) != 0)) {
        at += strlen((char *)at) + 1;
        at += strlen((char *)at) + 1;
        at += 4 + file_u32(at);
    }
    if (!*at)
        return name ? NULL : at + 1;
    at += strlen((char *)at) + 1;
    return at + strlen((char *)at) + 5;
}

/* The status of bytes, with one line if it is refused. */
static ibl_status read_bytes(const unsigned char *bytes, size_t size)
{
    ibl_read_options opts = ibl_read_options_default();
    ibl_image img;

    opts.any_aspect = 1;
    const ibl_status status =
        decode_bytes("f.exr", bytes, size, &opts, &img, NULL);
    CHECK_MSG(!status ||
                  (kept.text[0][0] && !img.data && !strchr(kept.text[0], '\n')),
              "%s", kept.text[0]);
    return status;
}

TEST(absurd_claims)
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
    static const char *const names[] = {"zip.exr", "none.exr", "tiles.exr"};

    begin(2, 24, 40);
    NEED(file_run("oiiotool s.pfm -d half --compression zip -o zip.exr "
                  "--compression none -o none.exr --tile 16 16 --compression "
                  "zip -o tiles.exr"));
    for (int i = 0; i < 3; i++) {
        size_t size;
        unsigned char *bytes = file_load(file_path(names[i]), &size);
        unsigned char *box[] = {attribute(bytes, "dataWindow"),
                                attribute(bytes, "displayWindow")};
        unsigned char was[2][16];
        for (int w = 0; w < 2; w++)
            memcpy(was[w], box[w], 16);
        for (size_t b = 0; b < sizeof boxes / sizeof boxes[0]; b++) {
            for (int w = 0; w < 2; w++) { /* of the data, and of both */
                for (int k = 0; k < 4; k++)
                    file_set_u32(box[w] + 4 * k, (uint32_t)boxes[b][k]);
                const ibl_status status = read_bytes(bytes, size);
                CHECK_MSG(
                    status == IBL_ERR_FORMAT || status == IBL_ERR_UNSUPPORTED,
                    "%s box %zu: %d %s", names[i], b, status, kept.text[0]);
            }
            memcpy(box[1], was[1], 16);
        }
        memcpy(box[0], was[0], 16);
        unsigned char *tile = attribute(bytes, "tiles");
        for (uint32_t v = 0; tile && v < 0x40000000u; v = v * 2 + 1) {
            file_set_u32(tile, v);
            read_bytes(bytes, size);
        }
    }
    /* G has a sample for each two columns and rows; names have one letter */
    size_t size;
    unsigned char *bytes = file_load(file_path("none.exr"), &size);
    unsigned char *list = attribute(bytes, "channels");
    file_set_u32(list + 18 + 10, 2);
    file_set_u32(list + 18 + 14, 2);
    CHECK(read_bytes(bytes, size) == IBL_ERR_UNSUPPORTED);
    CHECK_MSG(test_said(&kept, "channel G is sampled"), "%s", kept.text[0]);
}

/* A block of ZIP must inflate to what it has pixels for, no byte less or more,
 * and its checksum must be right. What follows it is nobody's. */
TEST(zip_streams)
{
    enum {
        PIXELS = 16 * 24 * 6
    };
    static const struct {
        uLong raw; /* bytes that are deflated */
        int more;  /* bytes that the block is longer than that takes */
        int flip;  /* this many bytes before the end */
        bool good;
    } blocks[] = {{PIXELS, 0, 0, true},      {PIXELS, 9, 0, true},
                  {PIXELS, -1, 0, false},    {PIXELS, 0, 1, false},
                  {PIXELS, 0, 6, false},     {PIXELS - 1, 0, 0, false},
                  {PIXELS + 1, 0, 0, false}, {PIXELS / 2, 0, 0, false},
                  {0, 0, 0, false},          {9 * PIXELS, 0, 0, false}};
    static const Bytef raw[9 * PIXELS];
    size_t size;

    begin(2, 24, 40);
    NEED(file_run("oiiotool s.pfm -d half --compression zip -o zip.exr"));
    unsigned char *bytes = file_load(file_path("zip.exr"), &size);
    unsigned char *data = bytes + file_u32(attribute(bytes, NULL)) + 8;
    for (size_t b = 0; b < sizeof blocks / sizeof blocks[0]; b++) {
        uLongf packed = PIXELS / 2;
        NEED(compress(data, &packed, raw, blocks[b].raw) == Z_OK);
        file_set_u32(data - 4, (uint32_t)((int)packed + blocks[b].more));
        if (blocks[b].flip)
            data[packed - (uLong)blocks[b].flip] ^= 1;
        const ibl_status status = read_bytes(bytes, size);
        CHECK_MSG(status == (blocks[b].good ? IBL_OK : IBL_ERR_FORMAT),
                  "%zu: %d %s", b, status, kept.text[0]);
    }
}
