/* SPDX-License-Identifier: MIT */
/* Environments in other layouts than equirectangular ones. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "core/pi.h"
#include "files.h"
#include "ibl/io.h"
#include "maps.h"
#include "textures.h"

enum {
    N = 16 /* edge of faces */
};

static ibl_ctx *ctx;
static test_messages kept;

static void begin(void)
{
    memset(&kept, 0, sizeof kept);
    ctx = file_ctx(2, &kept, NULL);
}

/* The unit vector that "+x" or another axis names. */
static void axis(const char *name, double v[3])
{
    memset(v, 0, 3 * sizeof *v);
    v[name[1] - 'x'] = name[0] == '-' ? -1 : 1;
}

/* A face as it lies in an image: what is in its middle, at its right and at its
 * lower edge. The files' rules, folded by hand. */
typedef struct cell {
    int column, row;
    const char *middle, *right, *down;
} cell;

typedef struct sheet {
    ibl_input_layout layout;
    int columns, rows;
    cell cells[IBL_FACES];
} sheet;

static const sheet sheets[] = {
    {IBL_INPUT_HCROSS,
     4,
     3,
     {{1, 0, "+y", "+x", "+z"},
      {0, 1, "-x", "+z", "-y"},
      {1, 1, "+z", "+x", "-y"},
      {2, 1, "+x", "-z", "-y"},
      {3, 1, "-z", "-x", "-y"},
      {1, 2, "-y", "+x", "-z"}}},
    {IBL_INPUT_VCROSS,
     3,
     4,
     {{1, 0, "+y", "+x", "+z"},
      {0, 1, "-x", "+z", "-y"},
      {1, 1, "+z", "+x", "-y"},
      {2, 1, "+x", "-z", "-y"},
      {1, 2, "-y", "+x", "-z"},
      {1, 3, "-z", "+x", "+y"}}},
    {IBL_INPUT_HSTRIP,
     6,
     1,
     {{0, 0, "+x", "-z", "-y"},
      {1, 0, "-x", "+z", "-y"},
      {2, 0, "+y", "+x", "+z"},
      {3, 0, "-y", "+x", "-z"},
      {4, 0, "+z", "+x", "-y"},
      {5, 0, "-z", "-x", "-y"}}},
    {IBL_INPUT_VSTRIP,
     1,
     6,
     {{0, 0, "+x", "-z", "-y"},
      {0, 1, "-x", "+z", "-y"},
      {0, 2, "+y", "+x", "+z"},
      {0, 3, "-y", "+x", "-z"},
      {0, 4, "+z", "+x", "-y"},
      {0, 5, "-z", "-x", "-y"}}},
};

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
    ibl_image img = map_constant(ctx, N * s->columns, N * s->rows, 0);

    for (int f = 0; f < IBL_FACES; f++) {
        const cell *c = &s->cells[f];
        double middle[3], right[3], down[3], d[3];
        axis(c->middle, middle);
        axis(c->right, right);
        axis(c->down, down);
        for (int i = 0; i < N * N; i++) {
            const double u = (2 * (i % N) + 1.0) / N - 1;
            const double v = (2 * (i / N) + 1.0) / N - 1;
            for (int k = 0; k < 3; k++)
                d[k] = middle[k] + u * right[k] + v * down[k];
            put_direction(
                map_pixel(&img, N * c->column + i % N, N * c->row + i / N), d);
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

    for (int y = 0; y < map->height; y++)
        for (int x = 0; x < map->width; x++) {
            const double from_top = IBL_PI * (y + 0.5) / map->height;
            const double azimuth = 2 * IBL_PI * ((x + 0.5) / map->width - 0.5);
            const double d[3] = {sin(from_top) * cos(azimuth), cos(from_top),
                                 sin(from_top) * sin(azimuth)};
            float want[3];
            put_direction(want, d);
            for (int k = 0; k < 3; k++)
                worst = fmax(worst, fabs((double)map_pixel(map, x, y)[k] -
                                         (double)want[k]));
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

/* Each layout is drawn by directions; its map must show them where they are. */
TEST(directions)
{
    begin();
    for (int i = 0; i < SHEETS; i++) {
        const ibl_image img = draw_sheet(&sheets[i]);
        const ibl_input_layout layout = sheets[i].layout;
        const char *path = file_path("sheet.exr");
        NEED(file_save_exr(path, &img, NULL));
        const ibl_image map = read_map(path, IBL_INPUT_AUTO, layout);
        CHECK(map.width == 256 && map.height == 128);
        /* Half a texel is 1 / N. */
        CHECK_MSG(worst_direction(&map) < 1.2 / N, "%s: off by %g",
                  ibl_input_layout_name(layout), worst_direction(&map));
    }
}

TEST(octahedral_directions)
{
    static const int sizes[] = {1, 2, 33, 64};

    begin();
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
        const ibl_image map =
            read_map(path, IBL_INPUT_OCTAHEDRAL, IBL_INPUT_OCTAHEDRAL);
        CHECK(map.width == 256 && map.height == 128);
        CHECK_MSG(n < 3 || worst_direction(&map) < 3.0 / n,
                  "%d pixels: off by %g", n, worst_direction(&map));
    }
}

static double solid_angle(const ibl_image *map, int y)
{
    return 2 * IBL_PI / map->width *
           (cos(IBL_PI * y / map->height) -
            cos(IBL_PI * (y + 1) / map->height));
}

static double energy(const ibl_image *map)
{
    double sum = 0;

    for (int y = 0; y < map->height; y++)
        for (int x = 0; x < map->width; x++)
            sum += solid_angle(map, y) * (double)map_pixel(map, x, y)[1];
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

    begin();
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

/* An octahedral map of the library, which says so itself, is the map that it
 * was made from. */
TEST(octahedral_texture)
{
    begin();
    ibl_image map = map_constant(ctx, 256, 128, 0);
    for (int i = 0; i < 256 * 128; i++) {
        const double from_top = IBL_PI * (i / 256 + 0.5) / 128;
        const double azimuth = 2 * IBL_PI * ((i % 256 + 0.5) / 256 - 0.5);
        const double d[3] = {sin(from_top) * cos(azimuth), cos(from_top),
                             sin(from_top) * sin(azimuth)};
        put_direction(map_pixel(&map, i % 256, i / 256), d);
    }
    const ibl_texel_options opts = {.struct_size = sizeof opts,
                                    .pixel = IBL_PIXEL_RGBA32F};
    ibl_texture tex = {0};
    ibl_cube flat = {0};
    size_t size;
    NEED(!ibl_cube_alloc_as(ctx, IBL_PROJECTION_OCTAHEDRAL, 32, 1, &flat));
    CHECK(!ibl_flat_from_latlong(ctx, &map, 0, &flat));
    NEED(!ibl_texture_from_cube(ctx, &flat, &opts, &tex, NULL));
    ibl_cube_free(&flat);
    texture_owned(tex);
    const unsigned char *bytes =
        texture_encode(ctx, &tex, IBL_CONTAINER_KTX2, &size);
    NEED(file_save(file_path("flat"), bytes, size));
    const ibl_image back =
        read_map(file_path("flat"), IBL_INPUT_AUTO, IBL_INPUT_OCTAHEDRAL);
    CHECK_MSG(worst_direction(&back) < 3.0 / 64, "off by %g",
              worst_direction(&back));
}

/* ---- one cube in every form -------------------------------------------- */

static bool same_map(const ibl_image *a, const ibl_image *b)
{
    return a->width == b->width && a->height == b->height &&
           !memcmp(a->data, b->data, map_floats(a) * sizeof(float));
}

/* The strip of a cube as another sheet, cell by cell. */
static ibl_image sheet_of(const sheet *s, const ibl_image *strip)
{
    ibl_image img = map_constant(ctx, N * s->columns, N * s->rows, 0);

    for (int f = 0; f < IBL_FACES; f++) {
        const cell *c = &s->cells[f];
        const int face = 2 * (c->middle[1] - 'x') + (c->middle[0] == '-');
        const bool turned = s->layout == IBL_INPUT_VCROSS && face == 5;
        for (int i = 0; i < N * N; i++)
            memcpy(map_pixel(&img, N * c->column + i % N, N * c->row + i / N),
                   strip->data +
                       3 * (face * N * N + (turned ? N * N - 1 - i : i)),
                   3 * sizeof(float));
    }
    return img;
}

static bool save_texture(const char *path, const ibl_image *strip,
                         ibl_container container, ibl_pixel pixel)
{
    const ibl_cube cube = {.size = N, .levels = 1, .data = strip->data};
    const ibl_texel_options opts = {.struct_size = sizeof opts, .pixel = pixel};
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
        const ibl_image face = {N, N, strip->data + (size_t)(3 * f * N * N)};
        char name[64];
        snprintf(name, sizeof name, "%s.exr", names[f]);
        ok = file_save_exr(file_path(name), &face, NULL);
    }
    return ok;
}

TEST(all_forms_are_one_map)
{
    static const char *const names[3][IBL_FACES] = {
        {"a_px", "a_nx", "a_py", "a_ny", "a_pz", "a_nz"},
        {"posx", "negx", "posy", "negy", "posz", "negz"},
        {"right", "left", "top", "bottom", "front", "back"}};
    static const char *const patterns[3] = {"a_%f.exr", "%f.exr", "%f.exr"};

    begin();
    ibl_image strip = map_constant(ctx, N, IBL_FACES * N, 0);
    map_fill(&strip, 7);
    const ibl_cube cube = {.size = N, .levels = 1, .data = strip.data};
    ibl_image want = map_constant(ctx, 256, 128, 0);
    NEED(!ibl_latlong_from_cube(ctx, &cube, &want));
    for (int i = 0; i < SHEETS; i++) {
        const ibl_image img = sheet_of(&sheets[i], &strip);
        NEED(file_save_exr(file_path("s.exr"), &img, NULL));
        const ibl_image got =
            read_map(file_path("s.exr"), IBL_INPUT_AUTO, sheets[i].layout);
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
}

TEST(a_list_of_files)
{
    char list[6 * 4200] = "";

    begin();
    ibl_image strip = map_constant(ctx, N, IBL_FACES * N, 0);
    map_fill(&strip, 8);
    for (int f = 0; f < IBL_FACES; f++) {
        const ibl_image face = {N, N, strip.data + (size_t)(3 * f * N * N)};
        char name[8];
        snprintf(name, sizeof name, "%d.exr", f);
        NEED(file_save_exr(file_path(name), &face, NULL));
        snprintf(list + strlen(list), sizeof list - strlen(list), "%s%s",
                 f ? "," : "", file_path(name));
    }
    NEED(file_save_exr(file_path("strip.exr"), &strip, NULL));
    const ibl_image got = read_map(list, IBL_INPUT_FACES, IBL_INPUT_FACES);
    const ibl_image want =
        read_map(file_path("strip.exr"), IBL_INPUT_AUTO, IBL_INPUT_VSTRIP);
    CHECK(same_map(&got, &want));
}

/* A cube in pixels that lose something is the map of what was kept. */
TEST(other_pixels)
{
    static const ibl_pixel pixels[] = {IBL_PIXEL_RGB9E5, IBL_PIXEL_BC6H,
                                       IBL_PIXEL_UASTC_HDR};

    begin();
    ibl_image strip = map_constant(ctx, N, IBL_FACES * N, 0);
    map_fill(&strip, 9);
    for (int i = 0; i < 3; i++) {
        const char *path = file_path("cube");
        ibl_texture tex = {0};
        ibl_cube cube = {0};
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

    begin();
    ibl_image strip = map_constant(ctx, N, IBL_FACES * N, 0);
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
    begin();
    const ibl_image img = draw_sheet(&sheets[0]);
    ibl_read_options opts = ibl_read_options_default();
    float alpha[12 * N * N];
    ibl_source *s;

    for (int i = 0; i < 12 * N * N; i++)
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
    begin();
    ibl_image img = map_constant(ctx, N, 6 * N, 1);
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

static void refused(const char *path, ibl_input_layout layout, const char *why)
{
    ibl_read_options opts = ibl_read_options_default();
    ibl_image map = {0};

    memset(&kept, 0, sizeof kept);
    opts.layout = layout;
    CHECK(ibl_image_read(ctx, path, &opts, &map, NULL) == IBL_ERR_FORMAT);
    CHECK_MSG(test_said(&kept, why), "%s", kept.text[IBL_LOG_ERROR]);
}

TEST(refused_shapes)
{
    begin();
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
    refused(path, IBL_INPUT_AUTO, "2 layers");
    bytes = texture_encode(ctx, &one, IBL_CONTAINER_DDS, &size);
    NEED(file_save(path, bytes, size));
    refused(path, IBL_INPUT_EQUIRECT, "is a cube, not in the layout equirect");
    NEED(file_save(path, bytes, size - 1));
    refused(path, IBL_INPUT_AUTO, "cut short");
    ibl_image img = map_constant(ctx, 9, 9, 1);
    NEED(file_save_exr(path, &img, NULL));
    refused(path, IBL_INPUT_AUTO, "is square");
    refused(path, IBL_INPUT_VCROSS, "layout vcross");
    refused(path, IBL_INPUT_CUBE, "does not say that it holds a cube");
    refused(path, IBL_INPUT_FACES, "one file");
}

/* Sheets that another program wrote, in a format of its own. */
TEST(written_by_openimageio)
{
    file_need_oiio();
    memset(&kept, 0, sizeof kept);
    ctx = file_ctx(2, &kept, file_bridge());
    for (int i = 0; i < SHEETS; i++) {
        const ibl_image img = draw_sheet(&sheets[i]);
        NEED(file_save_exr(file_path("s.exr"), &img, NULL));
        NEED(file_run("oiiotool s.exr -d float --tile 16 16 -o s.tif"));
        const ibl_image want =
            read_map(file_path("s.exr"), IBL_INPUT_AUTO, sheets[i].layout);
        const ibl_image got =
            read_map(file_path("s.tif"), IBL_INPUT_AUTO, sheets[i].layout);
        CHECK(same_map(&got, &want));
    }
}
