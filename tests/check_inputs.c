/* SPDX-License-Identifier: MIT */
/* Files as people have them: cubes in every layout, faces in any order, curves,
 * orientations, primaries, names. The truth is colours that say where they lie,
 * solid angles, and maps that are right. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

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
static ibl_read_report report; /* of the last file */

static void begin(const char *bridge)
{
    memset(&kept, 0, sizeof kept);
    ctx = file_ctx(2, &kept, bridge);
}

static ibl_image read_as(const char *name, const ibl_read_options *opts)
{
    ibl_image map = {0};

    memset(&kept, 0, sizeof kept);
    CHECK_MSG(!ibl_image_read(ctx, *name == '/' ? name : file_path(name), opts,
                              &map, &report),
              "%s: %s", name, kept.text[IBL_LOG_ERROR]);
    return test_image(map);
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

/* "": of anything. */
static bool warned(const char *words)
{
    return *kept.text[IBL_LOG_WARNING] &&
           strstr(kept.text[IBL_LOG_WARNING], words);
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
    return test_image(map);
}

/* A face of a cube at another place, turned clockwise by quarters. */
static void put_face(const float *face, int quarters, float *to)
{
    for (int i = 0; i < N * N; i++) {
        int u = i % N, v = i / N;
        for (int q = 0; q < quarters; q++) {
            const int t = u;
            u = N - 1 - v;
            v = t;
        }
        memcpy(to + 3 * (v * N + u), face + 3 * i, 3 * sizeof *to);
    }
}

/* A cube in a wrong order, its file's faces with quarters; and what mends it.
 */
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
    ibl_read_options opts = ibl_read_options_default();
    ibl_image photograph = {0};

    NEED(!ibl_image_read(ctx, name, NULL, &photograph, NULL));
    test_image(photograph);
    for (double yaw = 10; yaw < 360; yaw += 90) {
        map_of(cube_level0(ctx, &photograph, yaw, N).data, NULL);
        CHECK_MSG(!warned(""), "%s: %s", name, kept.text[IBL_LOG_WARNING]);
    }
    const ibl_cube cube = cube_level0(ctx, &photograph, 20, N);
    const ibl_image right = map_of(cube.data, NULL);
    CHECK_MSG(!warned(""), "%s", kept.text[IBL_LOG_WARNING]);
    for (size_t i = 0; i < sizeof orders / sizeof *orders; i++) {
        const char *t = orders[i].faces;
        for (int f = 0; f < 6; f++, t += *t == ' ') {
            const float *from = ibl_cube_face(&cube, 0, *t++ - '0');
            put_face(from, *t > ' ' ? *t++ - '0' : 0, faces + 3 * N * N * f);
        }
        map_of(faces, NULL);
        CHECK_MSG(warned("do not meet") &&
                      warned(test_text("--face-order=%s", orders[i].mend)),
                  "%s: %s: %s", name, orders[i].faces,
                  kept.text[IBL_LOG_WARNING]);
        NEED(ibl_face_order_parse(orders[i].mend, opts.face_order));
        const ibl_image map = map_of(faces, &opts);
        CHECK_MSG(!warned("") && map_same(&map, &right), "%s: %s: %s", name,
                  orders[i].faces, kept.text[IBL_LOG_WARNING]);
    }
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
        map_of(faces, NULL);
        CHECK_MSG(!warned(""), "%d: %s", kind, kept.text[IBL_LOG_WARNING]);
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

/* A colour that says where it lies: 1 + its direction. */
static void put_direction(float *rgb, const double d[3])
{
    const double length = sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
    for (int k = 0; k < 3; k++)
        rgb[k] = (float)(1 + d[k] / length);
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

/* Says in a file of file_save_exr that it is a cube: one attribute more, so
 * that blocks lie 19 bytes further. */
static void say_cube(const char *path, size_t width, size_t height)
{
    size_t size;
    unsigned char *was = file_load(path, &size);
    unsigned char *bytes = test_alloc(1, size + 19);
    unsigned char *table = bytes + 19 + size - height * (16 + 12 * width);

    memcpy(bytes, was, 8);
    memcpy(bytes + 8, "envmap\0envmap\0\1\0\0\0\1", 19);
    memcpy(bytes + 27, was + 8, size - 8);
    for (size_t y = 0; y < height; y++)
        file_set_u32(table + 8 * y, file_u32(table + 8 * y) + 19);
    NEED(file_save(path, bytes, size + 19));
}

/* Its latitude-longitude maps have +Z in the centre and -X to the right of it;
 * ours +X and +Z. */
TEST(envmap_cubes)
{
    double wrong = 0;

    begin(NULL);
    ibl_image strip = map_constant(ctx, N, 6 * N, 0);
    for (int i = 0; i < 6 * N * N; i++) {
        double d[3];
        envmap_direction(i / (N * N), i % N / (N - 1.0), i / N % N / (N - 1.0),
                         d);
        put_direction(strip.data + 3 * i, (double[]){d[2], d[1], -d[0]});
    }
    NEED(file_save_exr(file_path("cube.exr"), &strip, NULL));
    say_cube(file_path("cube.exr"), N, 6 * N);
    const ibl_image map = read_as("cube.exr", NULL);
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
    const char *command = "oiiotool --pattern noise:seed=3 16x8 4 -d float -o "
                          "u.tif";
    for (int o = 1; o <= 8; o++)
        command =
            test_text("%s u.tif %s --attrib:type=int Orientation %d -o o%d.tif",
                      command, back[o - 1], o, o);
    NEED(file_run("%s", command));
    ibl_read_options opts = ibl_read_options_default();
    for (int o = 1; o <= 8; o++) {
        opts.alpha = o % 2 ? IBL_ALPHA_FILE : IBL_ALPHA_IGNORE;
        const ibl_image got = read_as(test_text("o%d.tif", o), &opts),
                        want = read_as("u.tif", &opts);
        CHECK_MSG(got.width == 16 && map_same(&got, &want), "%d", o);
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
    }
    CHECK(ibl_image_read(ctx, file_path("f.tif"), &opts, &map, NULL) ==
          IBL_ERR_FORMAT);
    CHECK(test_said(&kept, "holds floats"));
}

/* ---- textures ---------------------------------------------------------- */

/* A grey cube of halves; content: of a baked map, or NULL. */
static ibl_texture grey(const char *content)
{
    ibl_texture tex =
        texture_random(ctx, IBL_PIXEL_RGBA16F, (int[]){8, 8, 1, 6}, 1);

    for (size_t i = 0; i < tex.bytes; i += 2)
        memcpy(tex.data + i, "\x00\x3c", 2);
    if (content)
        NEED(!ibl_texture_set(ctx, &tex, "iblbake.content", content));
    return texture_owned(tex);
}

TEST(what_textures_say)
{
    static const struct {
        const char *content;
        int number, stored; /* of primaries, as KTX2 has them */
        const char *name;
    } cases[] = {
        {NULL, 0, 1, "Rec.709"},       {NULL, 1, 1, "Rec.709"},
        {NULL, 4, 4, "Rec.2020"},      {NULL, 7, 7, "ACEScg"},
        {NULL, 6, 6, "ACES2065-1"},    {NULL, 10, 10, "Display P3"},
        {NULL, -1, 0, "Rec.709"},      {"skybox", 1, 1, "Rec.709"},
        {"specular", 1, 1, "Rec.709"}, {"irradiance", 1, 1, "Rec.709"}};
    begin(NULL);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        const char *content = cases[i].content;
        ibl_texture tex = grey(content);
        ibl_image map = {0};
        size_t size;
        tex.primaries = cases[i].number;
        const unsigned char *b =
            texture_encode(ctx, &tex, IBL_CONTAINER_KTX2, &size);
        CHECK(b[file_u32(b + 48) + 13] == cases[i].stored);
        memset(&kept, 0, sizeof kept);
        NEED(!ibl_image_decode(ctx, "cube", b, size, NULL, &map, &report));
        test_image(map);
        CHECK_MSG(!strcmp(report.primaries_name, cases[i].name) &&
                      warned("its primaries are") ==
                          (strcmp(cases[i].name, "Rec.709") != 0),
                  "%zu: %s", i, report.primaries_name);
        CHECK(warned("is a baked map") ==
              (content && strcmp(content, "skybox") != 0));
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
    begin(file_bridge());
    const ibl_texture tex = grey(NULL);
    const ibl_texture bytes = texture_owned(
        texture_random(ctx, IBL_PIXEL_RGB9E5, (int[]){8, 8, 1, 6}, 1));
    size_t size;
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        unsigned char *b = texture_encode(ctx, &tex, IBL_CONTAINER_DDS, &size);
        file_set_u32(b + cases[i].at, cases[i].value);
        file_set_u32(b + cases[i].at2, cases[i].value2);
        const ibl_texture back = texture_decode(ctx, b, size);
        CHECK_MSG((back.faces == 6) == cases[i].cube && back.layers == 1,
                  "%zu: %d faces, %d layers", i, back.faces, back.layers);
    }
    file_need_oiio();
    unsigned char *dds = texture_encode(ctx, &bytes, IBL_CONTAINER_DDS, &size);
    for (int dxgi = 28; dxgi <= 87; dxgi += 59) {
        file_set_u32(dds + 128, (uint32_t)dxgi);
        for (int i = 0; i < 6 * 64; i++)
            memcpy(dds + 148 + 4 * i, "\xff\x80\x00\xff", 4);
        NEED(file_save(file_path("b.dds"), dds, size));
        const ibl_image map = read_as("b.dds", NULL);
        const bool bgr = dxgi == 87;
        CHECK(map.width == 256 && warned("low dynamic range"));
        CHECK(map.data[bgr ? 2 : 0] > .999f && map.data[bgr ? 0 : 2] <= 0 &&
              fabsf(map.data[1] - .2158f) < 1e-3f);
    }
    refused("b.dds", IBL_INPUT_VSTRIP, "is a cube, not in the layout");
    const ibl_texture two = texture_owned(
        texture_random(ctx, IBL_PIXEL_RGBA32F, (int[]){4, 4, 1, 6}, 2));
    dds = texture_encode(ctx, &two, IBL_CONTAINER_DDS, &size);
    NEED(file_save(file_path("two.dds"), dds, size));
    refused("two.dds", IBL_INPUT_AUTO, "2 layers");
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
    char *files[6];
    int count;
    for (size_t i = 0; i < sizeof sets / sizeof *sets; i++) {
        const char *want[6];
        for (int f = 0; f < 6; f++) {
            want[f] = file_path(test_text("set%zu_%s.hdr", i, sets[i][f]));
            NEED(file_save(want[f], "", 0));
        }
        NEED(!ibl_input_files(ctx, file_path(test_text("set%zu_%%f.hdr", i)),
                              files, &count));
        CHECK(count == 6);
        for (int f = 0; f < count; f++)
            CHECK_MSG(!strcmp(files[f], want[f]), "%s", files[f]);
        ibl_input_files_free(files);
    }
    NEED(!ibl_input_files(ctx, file_path("100%final.hdr"), files, &count));
    CHECK(count == 1);
    ibl_input_files_free(files);
}

/* Negative pixels are worth a word by their share of the light. */
TEST(dark_maps)
{
    begin(NULL);
    for (int loud = 0; loud < 2; loud++) {
        ibl_image map = map_constant(ctx, 16, 8, 1);
        map.data[7] = loud ? -.1f : -.01f; /* of 384 */
        NEED(file_save_exr(file_path("negative.exr"), &map, NULL));
        map = read_as("negative.exr", NULL);
        CHECK_MSG(warned("negative") == loud && map.data[7] == 0, "%s",
                  kept.text[IBL_LOG_WARNING]);
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

static ibl_image read_map(const char *name, ibl_input_layout asked,
                          ibl_input_layout found)
{
    ibl_read_options opts = ibl_read_options_default();

    opts.layout = asked;
    const ibl_image map = read_as(name, &opts);
    NEED(map.data);
    CHECK_MSG(report.layout == found, "layout %s, not %s",
              ibl_input_layout_name(report.layout),
              ibl_input_layout_name(found));
    return map;
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

/* A constant stays, and what the map has of a texel alone is its solid angle.
 */
TEST(cube_energy)
{
    static const int sizes[] = {1, 2, 5, 33};
    double worst = 0;

    begin(NULL);
    for (int i = 0; i < 4; i++) {
        const int n = sizes[i], step = 1 + n / 4, w = ibl_latlong_width(n);
        ibl_cube cube = cube_alloc(ctx, n, 1);
        ibl_image map = map_constant(ctx, w, w / 2, 0);
        for (size_t k = 0; k < cube_floats(&cube); k++)
            cube.data[k] = 0.7f;
        NEED(!ibl_latlong_from_cube(ctx, &cube, &map));
        for (size_t k = 0; k < map_floats(&map); k++)
            CHECK_NEAR((double)map.data[k], 0.7, 1e-6);
        memset(cube.data, 0, cube_floats(&cube) * sizeof *cube.data);
        for (int t = 0; t < IBL_FACES * n * n; t++) {
            const int x = t % n, y = t / n % n;
            if (x % step || y % step)
                continue;
            cube.data[3 * t + 1] = 1000;
            NEED(!ibl_latlong_from_cube(ctx, &cube, &map));
            cube.data[3 * t + 1] = 0;
            worst = fmax(
                worst,
                fabs(energy(&map) / 1000 / ibl_cube_solid_angle(n, x, y) - 1));
        }
        map.width--;
        CHECK(ibl_latlong_from_cube(ctx, &cube, &map) == IBL_ERR_ARGUMENT);
    }
    CHECK_MSG(worst < 1e-6, "off by %g", worst);
}

/* Of sizes that are odd, and one of the library, which says so itself; a pixel
 * alone has its solid angle, and a constant stays. */
TEST(octahedral_maps)
{
    static const int at[][3] = {{1, 0, 0}, {2, 1, 0}, {8, 3, 3},  {8, 0, 0},
                                {8, 5, 1}, {9, 4, 4}, {33, 7, 21}};
    const ibl_texel_options opts = {.pixel = IBL_PIXEL_RGBA32F};
    ibl_texture tex;
    ibl_cube flat;
    size_t size;
    ibl_image map = {0};

    begin(NULL);
    const char *path = file_path("octahedral.exr");
    for (size_t i = 0; i < sizeof at / sizeof *at; i++) {
        const int n = at[i][0];
        ibl_image img = map_constant(ctx, n, n, 0.7f);
        for (int k = 0; k < 3; k++) {
            for (int t = 0; t < n * n && k == 1; t++) {
                double d[3];
                octahedral((2 * (t % n) + 1.0) / n - 1,
                           (2 * (t / n) + 1.0) / n - 1, d);
                put_direction(img.data + 3 * t, d);
            }
            if (k == 2) {
                memset(img.data, 0, map_floats(&img) * sizeof *img.data);
                map_set(&img, at[i][1], at[i][2], 0, 1000, 0);
            }
            NEED(file_save_exr(path, &img, NULL));
            map = read_map(path, IBL_INPUT_OCTAHEDRAL, IBL_INPUT_OCTAHEDRAL);
            for (size_t t = 0; t < map_floats(&map) && !k; t++)
                CHECK_NEAR((double)map.data[t], 0.7, 1e-6);
            CHECK_MSG(k != 1 || n < 10 || worst_direction(&map) < 3.0 / n,
                      "%d pixels: off by %g", n, worst_direction(&map));
        }
        CHECK_NEAR(energy(&map) / 1000 /
                       octahedral_angle(n, at[i][1], at[i][2]),
                   1, n > 2 ? 1e-4 : 1e-3);
    }
    const ibl_image img = draw_sheet(&sheets[SHEETS - 1]);
    NEED(file_save_exr(path, &img, NULL));
    map = read_map(path, IBL_INPUT_AUTO, IBL_INPUT_VSTRIP);
    NEED(!ibl_cube_alloc_as(ctx, IBL_PROJECTION_OCTAHEDRAL, 32, 1, &flat));
    test_cube(flat);
    CHECK(!ibl_flat_from_latlong(ctx, &map, 0, &flat));
    NEED(!ibl_texture_from_cube(ctx, &flat, &opts, &tex, NULL));
    texture_owned(tex);
    const void *bytes = texture_encode(ctx, &tex, IBL_CONTAINER_KTX2, &size);
    NEED(file_save(file_path("flat"), bytes, size));
    map = read_map("flat", IBL_INPUT_AUTO, IBL_INPUT_OCTAHEDRAL);
    CHECK_MSG(worst_direction(&map) < 4.0 / 32, "off by %g",
              worst_direction(&map));
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
    for (int i = 0; i < SHEETS + oiio; i++) {
        const sheet *s = &sheets[i % SHEETS];
        const ibl_image img = draw_sheet(s);
        NEED(file_save_exr(file_path("s.exr"), &img, NULL));
        if (i >= SHEETS)
            NEED(file_run("oiiotool s.exr -d float --tile 16 16 -o s.tif"));
        const ibl_image got =
            read_map(i < SHEETS ? "s.exr" : "s.tif", IBL_INPUT_AUTO, s->layout);
        CHECK_MSG(map_same(&got, &want), "sheet %d", i);
    }
    for (int c = 0; c < IBL_CONTAINER_COUNT; c++) {
        ibl_texture tex;
        size_t size;
        NEED(!ibl_texture_from_cube(
            ctx, &cube, &(ibl_texel_options){.pixel = IBL_PIXEL_RGBA32F}, &tex,
            NULL));
        tex.zstd = c == IBL_CONTAINER_KTX2 ? 3 : 0;
        texture_owned(tex);
        const void *bytes = texture_encode(ctx, &tex, (ibl_container)c, &size);
        NEED(file_save(file_path("cube"), bytes, size));
        const ibl_image got = read_map("cube", IBL_INPUT_AUTO, IBL_INPUT_CUBE);
        CHECK_MSG(map_same(&got, &want), "container %d", c);
    }
    for (int i = 0; i < 3; i++) {
        NEED(save_faces(names[i], &strip));
        const ibl_image got =
            read_map(patterns[i], IBL_INPUT_AUTO, IBL_INPUT_FACES);
        CHECK_MSG(map_same(&got, &want), "names %d", i);
        remove(file_path("posx.exr"));
    }
    for (int f = 0; f < IBL_FACES; f++)
        list =
            test_text("%s%s%s.exr", list, f ? "," : "", file_path(names[2][f]));
    const ibl_image got = read_map(list, IBL_INPUT_FACES, IBL_INPUT_FACES);
    CHECK(map_same(&got, &want));
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
        read_map("clamped.exr", IBL_INPUT_AUTO, IBL_INPUT_VSTRIP);
    const ibl_image want = map_scaled(ctx, &plain, 2);
    for (int i = 0; i < 2; i++) {
        ibl_read_options opts = ibl_read_options_default();
        opts.exposure = 1;
        opts.clamp = 4;
        const ibl_image map = read_as(i ? "%f.exr" : "s.exr", &opts);
        CHECK(map_same(&map, &want));
        CHECK(report.clamped == 1 && report.peak >= 8 && report.peak <= 8);
        CHECK(report.clamp_removed > 0.001 && report.clamp_removed < 0.5);
    }
}

/* ---- alpha, repair, refusal -------------------------------------------- */

/* Alpha becomes a map as colours do; what is mended is told once, then. */
TEST(alpha_and_mending)
{
    begin(NULL);
    const ibl_image img = draw_sheet(&sheets[0]);
    ibl_read_options opts = ibl_read_options_default();
    float alpha[12 * EDGE * EDGE];
    float *rgb = test_alloc(3 * 256 * 128, sizeof *rgb);
    ibl_source *s;

    for (int i = 0; i < 12 * EDGE * EDGE; i++)
        alpha[i] = 0.25f;
    map_set(&img, EDGE + 3, EDGE + 4, NAN, 1, 1);
    map_set(&img, EDGE + 5, EDGE + 9, 1, -1, 1);
    NEED(file_save_exr(file_path("s.exr"), &img, alpha));
    opts.alpha = IBL_ALPHA_STRAIGHT;
    NEED(!ibl_source_open(ctx, file_path("s.exr"), &opts, &s));
    CHECK(warned(""));
    memset(&kept, 0, sizeof kept);
    CHECK(!ibl_source_read(s, 128, rgb) && !warned(""));
    NEED(ibl_source_alpha(s));
    for (int i = 0; i < 256 * 128; i++)
        CHECK_NEAR((double)ibl_source_alpha(s)[i], 0.25, 1e-6);
    CHECK_NEAR((double)rgb[3 * 128 + 1], 0.25 * 2, 0.01); /* +Y */
    CHECK(ibl_source_report(s)->nonfinite == 1 &&
          ibl_source_report(s)->negative == 1);
    CHECK(isfinite(energy(&(ibl_image){256, 128, rgb})));
    ibl_source_close(s);
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
        const char *name = met[i].file, *error = met[i].error;
        double wrong = 0, all = 0;
        path = test_shared_data(test_text("../cases/inputs/%s", name));
        if (!path)
            continue;
        memset(&kept, 0, sizeof kept);
        const bool failed = ibl_image_read(ctx, path, NULL, &map, NULL);
        CHECK_MSG(failed ? error && test_said(&kept, error) : !error, "%s: %s",
                  name, kept.text[IBL_LOG_ERROR]);
        CHECK_MSG(met[i].warning ? warned(met[i].warning) : !warned(""),
                  "%s: %s", name, kept.text[IBL_LOG_WARNING]);
        if (failed)
            continue;
        moments(&map, m);
        for (int k = 0; k < 12; k++) {
            wrong += pow(m[k] - base[k], 2);
            all += pow(base[k], 2);
        }
        CHECK_MSG(sqrt(wrong / all) < met[i].most, "%s: %g", name,
                  sqrt(wrong / all));
        ibl_image_free(&map);
    }
}
