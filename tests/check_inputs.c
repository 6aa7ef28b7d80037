/* SPDX-License-Identifier: MIT */
/* Files as people have them: cubes in every layout, faces in any order, curves,
 * orientations, and what is no image at all. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "exr.h"
#include "files.h"
#include "ibl/io.h"
#include "maps.h"
#include "textures.h"
#include "truth.h"

enum {
    N = 32,   /* edge of faces */
    EDGE = 16 /* of those of layouts */
};

static ibl_ctx *ctx;
static test_messages kept;

static void begin(const char *bridge)
{
    memset(&kept, 0, sizeof kept);
    ctx = file_ctx(2, &kept, bridge);
}

static ibl_image read_as(const char *name, const ibl_read_options *opts)
{
    ibl_image map = {0};

    memset(&kept, 0, sizeof kept);
    CHECK_MSG(!ibl_image_read(ctx, file_path(name), opts, &map, NULL), "%s: %s",
              name, kept.text[IBL_LOG_ERROR]);
    return map;
}

static void refused(const char *name, ibl_input_layout layout, const char *why)
{
    ibl_read_options opts = ibl_read_options_default();
    ibl_image map = {0};

    memset(&kept, 0, sizeof kept);
    opts.layout = layout;
    CHECK_MSG(ibl_image_read(ctx, file_path(name), &opts, &map, NULL) ==
                      IBL_ERR_FORMAT &&
                  test_said(&kept, why),
              "%s: %s", name, kept.text[IBL_LOG_ERROR]);
}

static bool warned(const char *words)
{
    return strstr(kept.text[IBL_LOG_WARNING], words);
}

/* ---- faces --------------------------------------------------------------- */

/* The map of faces in memory, as opts say. */
static ibl_image map_of(const float *faces, const ibl_read_options *opts)
{
    const ibl_pixels strip = {
        .data = faces, .width = N, .height = 6 * N, .channels = 3};
    ibl_source *source = NULL;
    ibl_image map = {0};

    memset(&kept, 0, sizeof kept);
    NEED(!ibl_source_of_pixels(ctx, "cube", &strip, opts, &source));
    CHECK(!ibl_source_image(source, &map));
    ibl_source_close(source);
    return map;
}

static bool same_map(const ibl_image *a, const ibl_image *b)
{
    return a->width == b->width && a->height == b->height &&
           !memcmp(a->data, b->data, map_floats(a) * sizeof *a->data);
}

/* Face `from` of a cube at another place, turned clockwise by quarters after it
 * was mirrored. */
static void put_face(const ibl_cube *cube, int from, int quarters,
                     bool mirrored, float *to)
{
    const float *face = ibl_cube_face(cube, 0, from);

    for (int y = 0; y < N; y++)
        for (int x = 0; x < N; x++) {
            int u = mirrored ? N - 1 - x : x, v = y;
            for (int q = 0; q < quarters; q++) {
                const int t = u; /* of the face, clockwise */
                u = N - 1 - v;
                v = t;
            }
            memcpy(to + 3 * (v * N + u), face + 3 * (y * N + x),
                   3 * sizeof *to);
        }
}

/* A cube in a wrong order, its file's faces by letter, with quarters and `m`;
 * and what mends it. */
static const struct {
    const char *faces, *mend;
} orders[] = {
    {"1 0 2 3 4 5", "nx,px,py,ny,pz,nz"},
    {"4 5 0 1 2 3", "pz,nz,px,nx,py,ny"},
    {"0 1 2 3 4 52", "px,nx,py,ny,pz,nz/180"},
    {"0 1 21 3 4 5", "px,nx,py/270,ny,pz,nz"},
    {"0 1 3 2 4 5", "px,nx,ny,py,pz,nz"},
    {"4 0 5 1 2 3", "pz,px,nz,nx,py,ny"},
    {"5 3 4 1 0 2", "nz,ny,pz,nx,px,py"},
};

static void check_orders(const char *name)
{
    static float faces[6 * N * N * 3];
    ibl_image photograph = {0};

    NEED(!ibl_image_read(ctx, name, NULL, &photograph, NULL));
    for (double yaw = 10; yaw < 360; yaw += 90) {
        const ibl_cube turned = cube_level0(ctx, &photograph, yaw, N);
        ibl_image map = map_of(turned.data, NULL);
        CHECK_MSG(!*kept.text[IBL_LOG_WARNING], "%s: %s", name,
                  kept.text[IBL_LOG_WARNING]);
        ibl_image_free(&map);
    }
    const ibl_cube cube = cube_level0(ctx, &photograph, 20, N);
    ibl_image_free(&photograph);
    ibl_read_options opts = ibl_read_options_default();
    ibl_image right = map_of(cube.data, NULL);

    CHECK_MSG(!*kept.text[IBL_LOG_WARNING], "%s", kept.text[IBL_LOG_WARNING]);
    for (size_t i = 0; i < sizeof orders / sizeof *orders; i++) {
        const char *t = orders[i].faces;
        char words[80];
        for (int f = 0; f < 6; f++, t += *t == ' ') {
            const int from = *t++ - '0';
            const int quarters = *t > ' ' ? *t++ - '0' : 0;
            put_face(&cube, from, quarters, false, faces + 3 * N * N * f);
        }
        snprintf(words, sizeof words, "--face-order=%s", orders[i].mend);
        ibl_image map = map_of(faces, NULL);
        CHECK_MSG(warned("do not meet") && warned(words), "%s: %s: %s", name,
                  orders[i].faces, kept.text[IBL_LOG_WARNING]);
        ibl_image_free(&map);
        NEED(ibl_face_order_parse(orders[i].mend, opts.face_order));
        map = map_of(faces, &opts);
        CHECK_MSG(!*kept.text[IBL_LOG_WARNING] && same_map(&map, &right),
                  "%s: %s: %s", name, orders[i].faces,
                  kept.text[IBL_LOG_WARNING]);
        ibl_image_free(&map);
    }
    ibl_image_free(&right);
}

/* Right cubes are silent, and wrong ones mended. */
TEST(wrong_orders)
{
    file_need_oiio(); /* the photographs are DWA */
    begin(file_bridge());
    check_orders(test_data("sky.exr"));
    if (TEST_SANITIZED)
        return;
    check_orders(test_data("forest.exr"));
    check_orders(test_data("studio.exr"));
}

/* Cubes of which nobody can say. */
TEST(silent_cubes)
{
    static float faces[6 * N * N * 3];
    test_random r = {5};
    begin(NULL);
    for (int kind = 0; kind < 4; kind++) {
        for (int i = 0; i < 6 * N * N * 3; i++) {
            const int face = i / (3 * N * N);
            faces[i] = kind == 0   ? 1
                       : kind == 1 ? (float)(face == 0 || face == 2)
                       : kind == 2 ? (float)test_random_unit(&r)
                                   : 1e-3f;
        }
        faces[3000] = 1e6f; /* a sun */
        ibl_image map = map_of(faces, NULL);
        CHECK_MSG(!*kept.text[IBL_LOG_WARNING], "%d: %s", kind,
                  kept.text[IBL_LOG_WARNING]);
        ibl_image_free(&map);
    }
}

TEST(face_order_text)
{
    static const char *const wrong[] = {"",
                                        "px,nx,py,ny,pz",
                                        "px,nx,py,ny,pz,pz",
                                        "px,nx,py,ny,pz,nz,",
                                        ",px,nx,py,ny,pz",
                                        "px,nx,py,ny,pz,nz/45",
                                        "px,nx,py,ny,pz,nz/m/90",
                                        "px,nx,py,ny,pz, nz"};
    unsigned char order[6];
    char text[IBL_FACE_ORDER];

    CHECK(ibl_face_order_parse("nx/m,PX/m90,py/m180,ny/m270,nz/180,pz/270",
                               order));
    CHECK(order[0] == 25 && order[1] == 30 && order[5] == 22);
    ibl_face_order_text(order, text);
    CHECK(!strcmp(text, "nx/m,px/m90,py/m180,ny/m270,nz/180,pz/270"));
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++)
        CHECK_MSG(!ibl_face_order_parse(wrong[i], order), "%s", wrong[i]);
}

/* ---- OpenEXR's cubes ----------------------------------------------------- */

/* The direction of a place of a face, x and y from 0 to 1, by ImfEnvmap.h:
 * CubeMap::pixelPosition(), solved for the position in the face, and
 * direction(). */
static void envmap_direction(int face, double x, double y, double d[3])
{
    const double a = face == 1 ? 1 - 2 * x : 2 * x - 1, b = 1 - 2 * y;
    const double all[6][3] = {{1, b, a},   {-1, b, a}, {a, 1, b},
                              {a, -1, -b}, {-a, b, 1}, {a, b, -1}};
    memcpy(d, all[face], sizeof all[face]);
}

/* Its latitude-longitude maps have +Z in the centre and -X to the right of it;
 * ours +X and +Z. */
TEST(envmap_cubes)
{
    static float planes[3][6 * N * N];
    const test_exr_channel channels[] = {{"B", EXR_PIXEL_HALF, 1, planes[2]},
                                         {"G", EXR_PIXEL_HALF, 1, planes[1]},
                                         {"R", EXR_PIXEL_HALF, 1, planes[0]}};
    double wrong = 0;

    begin(NULL);
    test_exr_ctx = ctx;
    for (int i = 0; i < 6 * N * N; i++) {
        double d[3];
        envmap_direction(i / (N * N), i % N / (N - 1.0), i / N % N / (N - 1.0),
                         d);
        const double length = sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
        planes[0][i] = (float)(1 + d[2] / length);
        planes[1][i] = (float)(1 + d[1] / length);
        planes[2][i] = (float)(1 - d[0] / length);
    }
    NEED(test_exr_write(file_path("cube.exr"), N, 6 * N, EXR_COMPRESSION_ZIP,
                        channels, 3, NULL, EXR_ENVMAP_CUBE));
    ibl_image map = read_as("cube.exr", NULL);
    for (int i = 0; i < map.width * map.height; i++) {
        double d[3];
        truth_latlong_direction(map.width, map.height, i % map.width,
                                i / map.width, d);
        for (int k = 0; k < 3; k++)
            wrong += pow((double)map.data[3 * i + k] - 1 - d[k], 2);
    }
    wrong = sqrt(wrong / (map.width * map.height));
    /* of a texel about 2 / N wide; centres for edges would be 0.6 / N off */
    CHECK_MSG(wrong < 0.5 / N, "%g", wrong);
    CHECK(!warned("do not meet"));
    ibl_image_free(&map);
}

/* ---- how pixels lie, and their curve ----------------------------------- */

/* What was turned back before it was said to be turned. */
TEST(orientations)
{
    static const char *const back[] = {"",
                                       "--flop",
                                       "--rotate180",
                                       "--flip",
                                       "--transpose",
                                       "--rotate270",
                                       "--rotate180 --transpose",
                                       "--rotate90"};
    file_need_oiio();
    begin(file_bridge());
    char command[1024] = "oiiotool --pattern noise:seed=3 16x8 4 -d float -o "
                         "u.tif";
    for (int o = 1; o <= 8; o++) {
        char *end = command + strlen(command);
        snprintf(end, sizeof command - (size_t)(end - command),
                 " u.tif %s --attrib:type=int Orientation %d -o o%d.tif",
                 back[o - 1], o, o);
    }
    NEED(file_run("%s", command));
    ibl_read_options opts = ibl_read_options_default();
    for (int o = 1; o <= 8; o++) {
        char name[24];
        snprintf(name, sizeof name, "o%d.tif", o);
        opts.alpha = o % 2 ? IBL_ALPHA_FILE : IBL_ALPHA_IGNORE;
        ibl_image got = read_as(name, &opts), want = read_as("u.tif", &opts);
        CHECK_MSG(got.width == 16 && same_map(&got, &want), "%d", o);
        ibl_image_free(&got);
        ibl_image_free(&want);
    }
}

TEST(transfer)
{
    static const struct {
        const char *file;
        ibl_transfer transfer;
        bool linear;
    } cases[] = {{"l.png", IBL_TRANSFER_FILE, true},
                 {"l.png", IBL_TRANSFER_SRGB, false},
                 {"l.png", IBL_TRANSFER_LINEAR, true},
                 {"s.png", IBL_TRANSFER_FILE, false},
                 {"s.png", IBL_TRANSFER_LINEAR, true},
                 {"l.tif", IBL_TRANSFER_FILE, false},
                 {"l.tif", IBL_TRANSFER_LINEAR, true}};
    file_need_oiio();
    begin(file_bridge());
    ibl_read_options opts = ibl_read_options_default();
    ibl_image map = {0};
    NEED(file_run("oiiotool --create 4x2 3 --fill:color=.25,.5,.75 4x2 -d "
                  "uint16 -o l.tif --attrib oiio:ColorSpace Linear -o l.png "
                  "--attrib oiio:ColorSpace sRGB -o s.png -d float -o f.tif"));
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        opts.transfer = cases[i].transfer;
        map = read_as(cases[i].file, &opts);
        const double want = cases[i].linear ? .25 : pow(.305 / 1.055, 2.4);
        CHECK_MSG(fabs((double)map.data[0] - want) < 1e-4, "%s %d: %g",
                  cases[i].file, (int)cases[i].transfer, (double)map.data[0]);
        CHECK(warned(cases[i].linear ? "taken for linear" : "taken for sRGB"));
        ibl_image_free(&map);
    }
    CHECK(ibl_image_read(ctx, file_path("f.tif"), &opts, &map, NULL) ==
          IBL_ERR_FORMAT);
    CHECK(test_said(&kept, "holds floats"));
}

/* ---- textures ---------------------------------------------------------- */

/* A grey cube of halves. */
static ibl_texture grey(void)
{
    ibl_texture tex =
        texture_random(ctx, IBL_PIXEL_RGBA16F, (int[]){8, 8, 1, 6}, 1);

    for (size_t i = 0; i < tex.bytes; i += 2)
        memcpy(tex.data + i, "\x00\x3c", 2);
    return tex;
}

TEST(primaries_of_ktx2)
{
    static const struct {
        int number;
        const char *name;
    } cases[] = {{0, "Rec.709"}, {1, "Rec.709"},    {4, "Rec.2020"},
                 {7, "ACEScg"},  {6, "ACES2065-1"}, {10, "Display P3"},
                 {-1, "Rec.709"}};
    begin(NULL);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        ibl_texture tex = grey();
        ibl_read_report report;
        ibl_image map = {0};
        size_t size;
        tex.primaries = cases[i].number;
        const unsigned char *b =
            texture_encode(ctx, &tex, IBL_CONTAINER_KTX2, &size);
        const int stored = b[file_u32(b + 48) + 13];
        CHECK(stored == (cases[i].number < 0    ? 0
                         : cases[i].number == 0 ? 1
                                                : cases[i].number));
        memset(&kept, 0, sizeof kept);
        NEED(!ibl_image_decode(ctx, "cube", b, size, NULL, &map, &report));
        CHECK_MSG(!strcmp(report.primaries_name, cases[i].name), "%d: %s",
                  cases[i].number, report.primaries_name);
        CHECK(warned("its primaries are") ==
              (strcmp(cases[i].name, "Rec.709") != 0));
        ibl_image_free(&map);
        texture_owned(tex);
    }
}

/* DDS cubes of 8 bits, of which OpenImageIO is told what it does not know, and
 * cubes whose headers say so in one place or count faces. */
TEST(dds_cubes)
{
    static const struct {
        int at;
        uint32_t value;
        int at2;
        uint32_t value2;
        bool cube;
    } cases[] = {{136, 0, 112, 0xfe00, true}, /* old flags alone */
                 {136, 4, 112, 0, true},      /* new one alone */
                 {140, 6, 112, 0xfe00, true}, /* faces counted */
                 {140, 6, 136, 0, true},      /* and old flags */
                 {136, 0, 112, 0, false}};
    begin(NULL);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        const ibl_texture tex = grey();
        ibl_texture back = {0};
        size_t size;
        unsigned char *b = texture_encode(ctx, &tex, IBL_CONTAINER_DDS, &size);
        file_set_u32(b + cases[i].at, cases[i].value);
        file_set_u32(b + cases[i].at2, cases[i].value2);
        CHECK(!ibl_texture_decode(ctx, "dds", b, size, &back, NULL));
        CHECK_MSG((back.faces == 6) == cases[i].cube && back.layers == 1,
                  "%zu: %d faces, %d layers", i, back.faces, back.layers);
        ibl_texture_free(&back);
        texture_owned(tex);
    }
}

TEST(dds_of_bytes)
{
    file_need_oiio();
    begin(file_bridge());
    const ibl_texture tex = texture_owned(
        texture_random(ctx, IBL_PIXEL_RGB9E5, (int[]){8, 8, 1, 6}, 1));
    size_t size;
    unsigned char *dds = texture_encode(ctx, &tex, IBL_CONTAINER_DDS, &size);
    for (int dxgi = 28; dxgi <= 87; dxgi += 59) {
        file_set_u32(dds + 128, (uint32_t)dxgi);
        for (int i = 0; i < 6 * 64; i++)
            memcpy(dds + 148 + 4 * i, "\xff\x80\x00\xff", 4);
        NEED(file_save(file_path("b.dds"), dds, size));
        ibl_image map = read_as("b.dds", NULL);
        const bool bgr = dxgi == 87;
        CHECK(map.width == 256 && warned("low dynamic range"));
        CHECK(map.data[bgr ? 2 : 0] > .999f && map.data[bgr ? 0 : 2] <= 0 &&
              fabsf(map.data[1] - .2158f) < 1e-3f);
        ibl_image_free(&map);
    }
    ibl_read_options opts = ibl_read_options_default();
    ibl_image map = {0};
    opts.layout = IBL_INPUT_VSTRIP;
    CHECK(ibl_image_read(ctx, file_path("b.dds"), &opts, &map, NULL) ==
          IBL_ERR_FORMAT);
    CHECK(test_said(&kept, "is a cube"));
}

TEST(baked_maps)
{
    begin(NULL);
    static const char *const contents[] = {"skybox", "specular", "irradiance"};
    for (int i = 0; i < 3; i++) {
        ibl_texture tex = grey();
        size_t size;
        NEED(!ibl_texture_set(ctx, &tex, "iblbake.content", contents[i]));
        const unsigned char *b =
            texture_encode(ctx, &tex, IBL_CONTAINER_KTX, &size);
        NEED(file_save(file_path("c.ktx"), b, size));
        ibl_image map = read_as("c.ktx", NULL);
        CHECK(warned("is a baked map") == (i > 0));
        ibl_image_free(&map);
        texture_owned(tex);
    }
}

/* ---- names and other files --------------------------------------------- */

TEST(names_of_faces)
{
    static const char *const sets[][6] = {
        {"px", "nx", "py", "ny", "pz", "nz"},
        {"PX", "NX", "PY", "NY", "PZ", "NZ"},
        {"posX", "negX", "posY", "negY", "posZ", "negZ"},
        {"+X", "-X", "+Y", "-Y", "+Z", "-Z"},
        {"Right", "Left", "Up", "Down", "Front", "Back"},
        {"right", "left", "top", "bottom", "front", "back"},
        {"rt", "lf", "up", "dn", "ft", "bk"},
        {"0", "1", "2", "3", "4", "5"},
        {"c00", "c01", "c02", "c03", "c04", "c05"}};
    begin(NULL);
    for (size_t i = 0; i < sizeof sets / sizeof *sets; i++) {
        char *files[6], pattern[32];
        int count;
        snprintf(pattern, sizeof pattern, "set%zu_%%f.hdr", i);
        for (int f = 0; f < 6; f++) {
            char name[32];
            snprintf(name, sizeof name, "set%zu_%s.hdr", i, sets[i][f]);
            NEED(file_save(file_path(name), "", 0));
        }
        NEED(!ibl_input_files(ctx, file_path(pattern), files, &count));
        CHECK(count == 6);
        for (int f = 0; f < count; f++) {
            char want[32];
            snprintf(want, sizeof want, "set%zu_%s.hdr", i, sets[i][f]);
            CHECK_MSG(!strcmp(files[f], file_path(want)), "%s", files[f]);
        }
        ibl_input_files_free(files);
    }
    char *files[6];
    int count;
    NEED(!ibl_input_files(ctx, file_path("100%final.hdr"), files, &count));
    CHECK(count == 1);
    ibl_input_files_free(files);
}

TEST(not_the_file)
{
    begin(NULL);
    const char lfs[] = "version https://git-lfs.github.com/spec/v1\noid sha256:"
                       "4d7a214614ab\nsize 12345\n";
    const char html[] = "\xef\xbb\xbf\n<!DOCTYPE HTML>\n<html><head><title>404";
    const char plain[] = "<?xml version=\"1.0\"?><Error>";
    NEED(file_save(file_path("a.hdr"), lfs, sizeof lfs - 1));
    NEED(file_save(file_path("b.hdr"), html, sizeof html - 1));
    NEED(file_save(file_path("c.hdr"), plain, sizeof plain - 1));
    refused("a.hdr", IBL_INPUT_AUTO, "Git LFS");
    refused("b.hdr", IBL_INPUT_AUTO, "HTML");
    refused("c.hdr", IBL_INPUT_AUTO, "HTML");
}

/* Negative pixels are worth a word by their share of the light. */
TEST(dark_maps)
{
    begin(NULL);
    ibl_image map = map_constant(ctx, 16, 8, 0);
    NEED(file_save_exr(file_path("black.exr"), &map, NULL));
    ibl_image got = read_as("black.exr", NULL);
    CHECK(warned("black everywhere"));
    ibl_image_free(&got);
    for (int loud = 0; loud < 2; loud++) {
        for (size_t i = 0; i < map_floats(&map); i++)
            map.data[i] = 1;
        map.data[7] = loud ? -.1f : -.01f; /* of 384 */
        NEED(file_save_exr(file_path("negative.exr"), &map, NULL));
        got = read_as("negative.exr", NULL);
        CHECK_MSG(warned("negative") == loud, "%s", kept.text[IBL_LOG_WARNING]);
        CHECK(got.data[7] == 0);
        ibl_image_free(&got);
    }
}

/* ---- layouts ----------------------------------------------------------- */

/* The unit vector that "+x" or another axis names. */
static void axis(const char *name, double v[3])
{
    memset(v, 0, 3 * sizeof *v);
    v[name[1] - 'x'] = name[0] == '-' ? -1 : 1;
}

/* What is in the middle of each face, at its right and at its lower edge; and
 * where they lie in an image. The files' rules, folded by hand. */
static const char *const sides[IBL_FACES][3] = {
    {"+x", "-z", "-y"}, {"-x", "+z", "-y"}, {"+y", "+x", "+z"},
    {"-y", "+x", "-z"}, {"+z", "+x", "-y"}, {"-z", "-x", "-y"}};

typedef struct sheet {
    ibl_input_layout layout;
    int columns, rows;
    const char *at; /* column and row of each */
    bool turned;    /* -Z lies on its head */
} sheet;

static const sheet sheets[] = {
    {IBL_INPUT_HCROSS, 4, 3, "21 01 10 12 11 31", false},
    {IBL_INPUT_VCROSS, 3, 4, "21 01 10 12 11 13", true},
    {IBL_INPUT_HSTRIP, 6, 1, "00 10 20 30 40 50", false},
    {IBL_INPUT_VSTRIP, 1, 6, "00 01 02 03 04 05", false}};

enum {
    SHEETS = sizeof sheets / sizeof *sheets
};

/* A colour that says where it lies: 1 + its direction. */
static void put_direction(float *rgb, const double d[3])
{
    const double length = sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
    for (int k = 0; k < 3; k++)
        rgb[k] = (float)(1 + d[k] / length);
}

static ibl_image draw_sheet(const sheet *s)
{
    ibl_image img = map_constant(ctx, EDGE * s->columns, EDGE * s->rows, 0);

    for (int f = 0; f < IBL_FACES; f++) {
        const char *at = s->at + 3 * f;
        const double sign = s->turned && f == 5 ? -1 : 1;
        double middle[3], right[3], down[3], d[3];
        axis(sides[f][0], middle);
        axis(sides[f][1], right);
        axis(sides[f][2], down);
        for (int i = 0; i < EDGE * EDGE; i++) {
            const int x = i % EDGE, y = i / EDGE;
            const double u = sign * ((2 * x + 1.0) / EDGE - 1);
            const double v = sign * ((2 * y + 1.0) / EDGE - 1);
            for (int k = 0; k < 3; k++)
                d[k] = middle[k] + u * right[k] + v * down[k];
            put_direction(map_pixel(&img, EDGE * (at[0] - '0') + x,
                                    EDGE * (at[1] - '0') + y),
                          d);
        }
    }
    return img;
}

/* Of a point of the square, -1..1. */
static void octahedral(double u, double v, double d[3])
{
    d[0] = u;
    d[1] = 1 - fabs(u) - fabs(v);
    d[2] = v;
    if (d[1] < 0) {
        d[0] = copysign(1 - fabs(v), u);
        d[2] = copysign(1 - fabs(u), v);
    }
}

/* The largest error of a map against the colours of put_direction. */
static double worst_direction(const ibl_image *map)
{
    double worst = 0;

    for (int i = 0; i < map->width * map->height; i++) {
        double d[3];
        float want[3];
        truth_latlong_direction(map->width, map->height, i % map->width,
                                i / map->width, d);
        put_direction(want, d);
        for (int k = 0; k < 3; k++)
            worst = fmax(worst,
                         fabs((double)map->data[3 * i + k] - (double)want[k]));
    }
    return worst;
}

static ibl_image read_map(const char *path, ibl_input_layout asked,
                          ibl_input_layout found)
{
    ibl_read_options opts = ibl_read_options_default();
    ibl_read_report report = {0};
    ibl_image map = {0};

    opts.layout = asked;
    if (ibl_image_read(ctx, path, &opts, &map, &report)) {
        CHECK_MSG(false, "%s: %s", path, kept.text[IBL_LOG_ERROR]);
        return map_constant(ctx, 8, 4, 0);
    }
    test_image(map);
    CHECK_MSG(report.layout == found, "layout %s, not %s",
              ibl_input_layout_name(report.layout),
              ibl_input_layout_name(found));
    return map;
}

TEST(octahedral_directions)
{
    static const int sizes[] = {1, 2, 33, 64};
    const ibl_texel_options opts = {.pixel = IBL_PIXEL_RGBA32F};
    ibl_texture tex;
    ibl_cube flat;
    size_t size;
    ibl_image map = {0};

    begin(NULL);
    for (int i = 0; i < 4; i++) {
        const int n = sizes[i];
        ibl_image img = map_constant(ctx, n, n, 0);
        for (int k = 0; k < n * n; k++) {
            double d[3];
            octahedral((2 * (k % n) + 1.0) / n - 1, (2 * (k / n) + 1.0) / n - 1,
                       d);
            put_direction(map_pixel(&img, k % n, k / n), d);
        }
        const char *path = file_path("octahedral.exr");
        NEED(file_save_exr(path, &img, NULL));
        map = read_map(path, IBL_INPUT_OCTAHEDRAL, IBL_INPUT_OCTAHEDRAL);
        CHECK(map.width == 256 && map.height == 128);
        CHECK_MSG(n < 3 || worst_direction(&map) < 3.0 / n,
                  "%d pixels: off by %g", n, worst_direction(&map));
    }
    /* One of the library, which says so itself, of that map. */
    NEED(!ibl_cube_alloc_as(ctx, IBL_PROJECTION_OCTAHEDRAL, 32, 1, &flat));
    CHECK(!ibl_flat_from_latlong(ctx, &map, 0, &flat));
    NEED(!ibl_texture_from_cube(ctx, &flat, &opts, &tex, NULL));
    ibl_cube_free(&flat);
    texture_owned(tex);
    const void *bytes = texture_encode(ctx, &tex, IBL_CONTAINER_KTX2, &size);
    NEED(file_save(file_path("flat"), bytes, size));
    map = read_map(file_path("flat"), IBL_INPUT_AUTO, IBL_INPUT_OCTAHEDRAL);
    CHECK_MSG(worst_direction(&map) < 4.0 / 64, "off by %g",
              worst_direction(&map));
}

static double energy(const ibl_image *map)
{
    double sum = 0;

    for (int i = 0; i < map->width * map->height; i++)
        sum +=
            truth_latlong_solid_angle(map->width, map->height, i / map->width) *
            (double)map->data[3 * i + 1];
    return sum;
}

/* Solid angle of an octahedral texel by many points: du dv / r^3 on the plane
 * at distance 1 / sqrt 3, whose area is sqrt 3 times that of (u, v). */
static double octahedral_angle(int n, int x, int y)
{
    const int many = 64;
    double sum = 0;

    for (int i = 0; i < many * many; i++) {
        double d[3];
        octahedral(2 * (x + (i % many + 0.5) / many) / n - 1,
                   2 * (y + ((double)(i / many) + 0.5) / many) / n - 1, d);
        sum += pow(d[0] * d[0] + d[1] * d[1] + d[2] * d[2], -1.5);
    }
    return sum * 4 / ((double)n * n * many * many);
}

TEST(octahedral_energy)
{
    static const int at[][3] = {{8, 3, 3}, {8, 0, 0}, {8, 5, 1},
                                {8, 7, 4}, {9, 4, 4}, {33, 7, 21}};

    begin(NULL);
    const char *path = file_path("octahedral.exr");
    for (size_t i = 0; i < sizeof at / sizeof *at; i++) {
        const int n = at[i][0];
        ibl_image img = map_constant(ctx, n, n, 0);
        map_set(&img, at[i][1], at[i][2], 0, 1000, 0);
        NEED(file_save_exr(path, &img, NULL));
        const ibl_image map =
            read_map(path, IBL_INPUT_OCTAHEDRAL, IBL_INPUT_OCTAHEDRAL);
        const double want = 1000 * octahedral_angle(n, at[i][1], at[i][2]);
        CHECK_NEAR(energy(&map) / want, 1, 1e-4);
    }
    ibl_image even = map_constant(ctx, 5, 5, 0.7f);
    NEED(file_save_exr(path, &even, NULL));
    const ibl_image map =
        read_map(path, IBL_INPUT_OCTAHEDRAL, IBL_INPUT_OCTAHEDRAL);
    for (size_t i = 0; i < map_floats(&map); i++)
        CHECK_NEAR((double)map.data[i], 0.7, 1e-6);
}

static bool save_texture(const char *path, const ibl_image *strip,
                         ibl_container container, ibl_pixel pixel)
{
    const ibl_cube cube = {.size = EDGE, .levels = 1, .data = strip->data};
    const ibl_texel_options opts = {.pixel = pixel};
    ibl_texture tex = {0};
    size_t size;

    if (ibl_texture_from_cube(ctx, &cube, &opts, &tex, NULL))
        return false;
    tex.zstd = container == IBL_CONTAINER_KTX2 ? 3 : 0;
    const unsigned char *bytes = texture_encode(ctx, &tex, container, &size);
    const bool ok = file_save(path, bytes, size);
    ibl_texture_free(&tex);
    return ok;
}

static bool save_faces(const char *const names[IBL_FACES],
                       const ibl_image *strip)
{
    bool ok = true;

    for (int f = 0; f < IBL_FACES && ok; f++) {
        const ibl_image face = {EDGE, EDGE,
                                strip->data + (size_t)(3 * f * EDGE * EDGE)};
        char name[64];
        snprintf(name, sizeof name, "%s.exr", names[f]);
        ok = file_save_exr(file_path(name), &face, NULL);
    }
    return ok;
}

/* Each layout is drawn by directions: the map shows them where they are, and
 * all are the same map, also by another program and in a format of its own. */
TEST(all_forms_are_one_map)
{
    static const char *const names[3][IBL_FACES] = {
        {"a_px", "a_nx", "a_py", "a_ny", "a_pz", "a_nz"},
        {"posx", "negx", "posy", "negy", "posz", "negz"},
        {"right", "left", "top", "bottom", "front", "back"}};
    static const char *const patterns[3] = {"a_%f.exr", "%f.exr", "%f.exr"};
    const bool oiio = file_bridge() && file_have("oiiotool");
    const char *list = "";

    begin(NULL);
    ctx = file_ctx(2, &kept, file_bridge());
    ibl_image strip = draw_sheet(&sheets[SHEETS - 1]);
    const ibl_cube cube = {.size = EDGE, .levels = 1, .data = strip.data};
    ibl_image want = map_constant(ctx, 256, 128, 0);
    NEED(!ibl_latlong_from_cube(ctx, &cube, &want));
    /* Half a texel is 1 / EDGE. */
    CHECK_MSG(worst_direction(&want) < 1.2 / EDGE, "off by %g",
              worst_direction(&want));
    for (int i = 0; i < SHEETS * (oiio ? 2 : 1); i++) {
        const sheet *s = &sheets[i % SHEETS];
        const ibl_image img = draw_sheet(s);
        NEED(file_save_exr(file_path("s.exr"), &img, NULL));
        if (i >= SHEETS)
            NEED(file_run("oiiotool s.exr -d float --tile 16 16 -o s.tif"));
        const ibl_image got =
            read_map(file_path(i < SHEETS ? "s.exr" : "s.tif"), IBL_INPUT_AUTO,
                     s->layout);
        CHECK_MSG(same_map(&got, &want), "sheet %d", i);
    }
    for (int c = 0; c < IBL_CONTAINER_COUNT; c++) {
        NEED(save_texture(file_path("cube"), &strip, (ibl_container)c,
                          IBL_PIXEL_RGBA32F));
        const ibl_image got =
            read_map(file_path("cube"), IBL_INPUT_AUTO, IBL_INPUT_CUBE);
        CHECK_MSG(same_map(&got, &want), "container %d", c);
    }
    for (int i = 0; i < 3; i++) {
        NEED(save_faces(names[i], &strip));
        const ibl_image got =
            read_map(file_path(patterns[i]), IBL_INPUT_AUTO, IBL_INPUT_FACES);
        CHECK_MSG(same_map(&got, &want), "names %d", i);
        remove(file_path("posx.exr"));
    }
    for (int f = 0; f < IBL_FACES; f++)
        list =
            test_text("%s%s%s.exr", list, f ? "," : "", file_path(names[2][f]));
    const ibl_image got = read_map(list, IBL_INPUT_FACES, IBL_INPUT_FACES);
    CHECK(same_map(&got, &want));
}

/* A cube in pixels that lose something is the map of what was kept. */
TEST(other_pixels)
{
    static const ibl_pixel pixels[] = {IBL_PIXEL_RGB9E5, IBL_PIXEL_BC6H,
                                       IBL_PIXEL_UASTC_HDR};

    begin(NULL);
    const char *path = file_path("cube");
    const ibl_image strip = draw_sheet(&sheets[SHEETS - 1]);
    for (int i = 0; i < 3; i++) {
        ibl_texture tex;
        ibl_cube cube;
        ibl_image want = map_constant(ctx, 256, 128, 0);
        NEED(save_texture(path, &strip, IBL_CONTAINER_KTX2, pixels[i]));
        NEED(!ibl_texture_read(ctx, path, &tex, NULL));
        texture_owned(tex);
        NEED(!ibl_texture_to_cube(ctx, &tex, &cube));
        CHECK(!ibl_latlong_from_cube(ctx, &cube, &want));
        ibl_cube_free(&cube);
        const ibl_image got = read_map(path, IBL_INPUT_CUBE, IBL_INPUT_CUBE);
        CHECK_MSG(same_map(&got, &want), "%s", ibl_pixel_name(pixels[i]));
    }
}

/* Exposure is exact, so the map is twice that of the file as it is; the clamp
 * acts on the file's pixels, and the peak is the file's. */
TEST(colours_change_once)
{
    static const char *const names[] = {"px", "nx", "py", "ny", "pz", "nz"};

    begin(NULL);
    ibl_image strip = map_constant(ctx, EDGE, IBL_FACES * EDGE, 0);
    map_fill(&strip, 10);
    map_set(&strip, 7, 9, 8, 8, 8);
    NEED(file_save_exr(file_path("s.exr"), &strip, NULL) &&
         save_faces(names, &strip));
    map_set(&strip, 7, 9, 2, 2, 2); /* clamped to 4 after exposure */
    NEED(file_save_exr(file_path("clamped.exr"), &strip, NULL));
    const ibl_image plain =
        read_map(file_path("clamped.exr"), IBL_INPUT_AUTO, IBL_INPUT_VSTRIP);
    const ibl_image want = map_scaled(ctx, &plain, 2);
    for (int i = 0; i < 2; i++) {
        ibl_read_options opts = ibl_read_options_default();
        ibl_read_report report;
        ibl_image map = {0};
        opts.exposure = 1;
        opts.clamp = 4;
        NEED(!ibl_image_read(ctx, file_path(i ? "%f.exr" : "s.exr"), &opts,
                             &map, &report));
        CHECK(same_map(&map, &want));
        CHECK(report.clamped == 1 && report.peak >= 8 && report.peak <= 8);
        CHECK(report.clamp_removed > 0.001 && report.clamp_removed < 0.5);
        ibl_image_free(&map);
    }
}

/* ---- alpha, repair, refusal -------------------------------------------- */

TEST(alpha_is_unwrapped)
{
    begin(NULL);
    const ibl_image img = draw_sheet(&sheets[0]);
    ibl_read_options opts = ibl_read_options_default();
    float alpha[12 * EDGE * EDGE];
    ibl_source *s;

    for (int i = 0; i < 12 * EDGE * EDGE; i++)
        alpha[i] = 0.25f;
    NEED(file_save_exr(file_path("s.exr"), &img, alpha));
    opts.alpha = IBL_ALPHA_STRAIGHT;
    NEED(!ibl_source_open(ctx, file_path("s.exr"), &opts, &s));
    float *rgb = test_alloc(3 * 256 * 128, sizeof *rgb);
    CHECK(!ibl_source_read(s, 128, rgb));
    NEED(ibl_source_alpha(s));
    for (int i = 0; i < 256 * 128; i++)
        CHECK_NEAR((double)ibl_source_alpha(s)[i], 0.25, 1e-6);
    CHECK_NEAR((double)rgb[3 * 128 + 1], 0.25 * 2, 0.01); /* +Y */
    ibl_source_close(s);
}

TEST(mended_once)
{
    begin(NULL);
    ibl_image img = map_constant(ctx, EDGE, 6 * EDGE, 1);
    ibl_read_options opts = ibl_read_options_default();
    ibl_read_report report = {0};
    ibl_image map = {0};

    map_set(&img, 3, 4, NAN, 1, 1);
    map_set(&img, 5, 40, 1, -1, 1);
    NEED(file_save_exr(file_path("s.exr"), &img, NULL));
    ibl_source *source;
    NEED(!ibl_source_open(ctx, file_path("s.exr"), NULL, &source));
    CHECK(*kept.text[IBL_LOG_WARNING]);
    memset(&kept, 0, sizeof kept);
    float *rgb = test_alloc(3 * 256 * 128, sizeof *rgb);
    CHECK(!ibl_source_read(source, 128, rgb));
    CHECK(!*kept.text[IBL_LOG_WARNING]);
    ibl_source_close(source);
    NEED(!ibl_image_read(ctx, file_path("s.exr"), NULL, &map, &report));
    CHECK(report.nonfinite == 1 && report.negative == 1);
    CHECK(isfinite(energy(&map)));
    ibl_image_free(&map);
    opts.strict = 1;
    CHECK(ibl_image_read(ctx, file_path("s.exr"), &opts, &map, NULL) ==
          IBL_ERR_FORMAT);
}

TEST(refused_shapes)
{
    begin(NULL);
    const ibl_texture one =
        texture_random(ctx, IBL_PIXEL_RGBA32F, (int[]){4, 4, 1, 6}, 1);
    const ibl_texture two =
        texture_random(ctx, IBL_PIXEL_RGBA32F, (int[]){4, 4, 1, 6}, 2);
    const char *path = file_path("file");
    size_t size;

    texture_owned(one);
    texture_owned(two);
    const unsigned char *bytes =
        texture_encode(ctx, &two, IBL_CONTAINER_KTX2, &size);
    NEED(file_save(path, bytes, size));
    refused("file", IBL_INPUT_AUTO, "2 layers");
    bytes = texture_encode(ctx, &one, IBL_CONTAINER_DDS, &size);
    NEED(file_save(path, bytes, size));
    refused("file", IBL_INPUT_EQUIRECT,
            "is a cube, not in the layout equirect");
    NEED(file_save(path, bytes, size - 1));
    refused("file", IBL_INPUT_AUTO, "cut short");
}

/* ---- files that users met ---------------------------------------------- */

/* The means of a map and of its colours times direction. */
static void moments(const ibl_image *map, double m[12])
{
    memset(m, 0, 12 * sizeof *m);
    for (int i = 0; i < map->width * map->height; i++) {
        const int x = i % map->width, y = i / map->width;
        double d[4] = {1};
        truth_latlong_direction(map->width, map->height, x, y, d + 1);
        const double w = truth_latlong_solid_angle(map->width, map->height, y);
        for (int k = 0; k < 12; k++)
            m[k] += w * d[k / 3] * (double)map->data[3 * i + k % 3];
    }
}

static const struct {
    const char *file, *error, *warning;
    double most; /* of the moments' difference from those of base.hdr */
} met[] = {
    {"acescg.exr", NULL, "ACEScg", .01},
    {"black.exr", NULL, "black everywhere", 2},
    {"d_bc1.dds", NULL, "low dynamic range", 2},
    {"d_rgba8_mask.dds", NULL, "low dynamic range", .2},
    {"ddx10_gli171.dds", NULL, NULL, .02},
    {"exr_envcube.exr", NULL, NULL, .03},
    {"exr_xyz.exr", "X, Y, Z", NULL, 0},
    {"hstrip_dx.exr", NULL, "--face-order=pz,px,nz,nx,py,ny", 2},
    {"vcross_nt.exr", NULL, "--face-order=px,nx,py,ny,pz,nz", 2},
    {"k1_d1_a1_s0.ktx", NULL, NULL, .02},
    {"k2_dfdlen0.ktx2", NULL, NULL, .02},
    {"k2_primbt2020.ktx2", NULL, "Rec.2020", .02},
    {"lin16.png", NULL, "linear", .2},
    {"logluv.tif", "LogLuv", NULL, 0},
    {"mp_mono.exr", NULL, NULL, .01},
    {"mp_two.exr", "specular (part 0), beauty (part 1)", NULL, 0},
    {"no_lfs.hdr", "Git LFS", NULL, 0},
    {"orient4.tif", NULL, NULL, .01},
    {"orient6.jpg", NULL, "low dynamic range", 2},
    {"pf_crlf.pfm", NULL, NULL, .01},
    {"sunsat.exr", NULL, NULL, 1e3},
};

TEST(files_that_users_met)
{
    ibl_image map = {0};
    double base[12], m[12];

    file_need_oiio();
    begin(file_bridge());
    const char *path = test_shared_data("../cases/inputs/base.hdr");
    if (!path) {
        printf("skipped files_that_users_met: no ../shared/cases\n");
        return;
    }
    NEED(!ibl_image_read(ctx, path, NULL, &map, NULL));
    moments(&map, base);
    ibl_image_free(&map);
    for (size_t i = 0; i < sizeof met / sizeof *met; i++) {
        char name[64];
        double wrong = 0, all = 0;
        snprintf(name, sizeof name, "../cases/inputs/%s", met[i].file);
        path = test_shared_data(name);
        if (!path)
            continue;
        memset(&kept, 0, sizeof kept);
        const bool failed = ibl_image_read(ctx, path, NULL, &map, NULL);
        CHECK_MSG(failed == (met[i].error != NULL), "%s: %s", met[i].file,
                  kept.text[IBL_LOG_ERROR]);
        if (met[i].error)
            CHECK_MSG(test_said(&kept, met[i].error), "%s: %s", met[i].file,
                      kept.text[IBL_LOG_ERROR]);
        if (met[i].warning)
            CHECK_MSG(warned(met[i].warning), "%s: %s", met[i].file,
                      kept.text[IBL_LOG_WARNING]);
        else
            CHECK_MSG(!*kept.text[IBL_LOG_WARNING], "%s: %s", met[i].file,
                      kept.text[IBL_LOG_WARNING]);
        if (failed)
            continue;
        moments(&map, m);
        for (int k = 0; k < 12; k++) {
            wrong += pow(m[k] - base[k], 2);
            all += pow(base[k], 2);
        }
        CHECK_MSG(sqrt(wrong / all) < met[i].most, "%s: %g", met[i].file,
                  sqrt(wrong / all));
        ibl_image_free(&map);
    }
}
