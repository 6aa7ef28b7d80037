/* SPDX-License-Identifier: MIT */
/* Maps laid out flat: what the shader shows of a texel and what is read out
 * of it are the same texel, in every pixel, and it lies where it should. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "sets.h"
#include "test.h"
#include "truth.h"
#include "view.h"
#include "view/gl.h"
#include "view/inspect.h"
#include "view/renderer.h"
#include "view/sphere_grid.h"

#define PI 3.14159265358979323846

enum {
    MOST = 256 /* pixels of a window's side */
};

static view_renderer *renderer;
static float seen[MOST * MOST][4]; /* rows from the bottom */

/* ---- sets --------------------------------------------------------------- */

static ibl_ctx *ctx;
static baked_set set; /* of the running test */

/* A cube that tells of each texel which it is, all different. */
static void name_texels(ibl_texture *tex, int edge, int levels, double extra)
{
    ibl_cube cube = {0};

    CHECK(!ibl_cube_alloc(ctx, edge, levels, &cube));
    for (int level = 0; level < levels; level++)
        for (int face = 0; face < IBL_FACES; face++) {
            const int n = ibl_cube_edge(edge, level);
            float *to = ibl_cube_face(&cube, level, face);
            for (int i = 0; i < n * n; i++, to += 3) {
                to[0] = (float)(face + 10 * level + extra);
                to[1] = (float)(i % n);
                to[2] = (float)(i / n);
            }
        }
    CHECK(!ibl_texture_from_cube(
        ctx, &cube,
        &(ibl_texel_options){.pixel = IBL_PIXEL_RGBA32F,
                             .overflow = IBL_OVERFLOW_CLIP},
        tex, NULL));
    ibl_cube_free(&cube);
}

/* R is N.V, G is half of the roughness. */
static void ramp_table(ibl_texture *tex)
{
    enum {
        size = 64
    };
    float texels[2 * size * size];
    const ibl_lut lut = {size, texels, IBL_LUT_SPLIT};

    for (int y = 0; y < size; y++)
        for (int x = 0; x < size; x++) {
            texels[2 * (y * size + x)] = (float)((x + 0.5) / size);
            texels[2 * (y * size + x) + 1] = (float)((y + 0.5) / size / 2);
        }
    CHECK(!ibl_texture_from_lut(ctx, &lut, IBL_PIXEL_RG32F, tex, NULL));
}

static void free_textures(void *unused)
{
    (void)unused;
    for (int i = 0; i < IBL_CONTENTS; i++)
        ibl_texture_free(&set.baked.file[i].texture);
}

static void make_set(int edge, int levels)
{
    free_textures(NULL);
    ctx = view_test_ctx(1);
    test_defer(free_textures, NULL);
    set = (baked_set){.sh_degree = -1};
    set.baked.file[IBL_CONTENT_SPECULAR].facts.lod_scale = levels - 1;
    set.baked.file[IBL_CONTENT_IRRADIANCE].facts.irradiance_scale = 1;
    name_texels(&set.baked.file[IBL_CONTENT_SPECULAR].texture, edge, levels, 0);
    name_texels(&set.baked.file[IBL_CONTENT_IRRADIANCE].texture, edge / 2 + 1,
                1, 100);
    ramp_table(&set.baked.file[IBL_CONTENT_LUT].texture);
}

/* ---- drawing ------------------------------------------------------------ */

static void end(void *unused)
{
    (void)unused;
    view_renderer_free(renderer);
}

static void begin(void)
{
    view_test_begin(16, 16);
    renderer = view_renderer_create();
    NEED(renderer);
    test_defer(end, NULL);
}

static void draw(const view_settings *s, int width, int height)
{
    CHECK(view_renderer_load(renderer, &set));
    CHECK(view_test_draw(renderer, s, width, height));
    gl.ActiveTexture(GL_TEXTURE0 + VIEW_UNIT_PICTURE);
    gl.GetTexImage(GL_TEXTURE_2D, 0, GL_RGBA, GL_FLOAT, seen);
    CHECK(view_gl_check("test"));
}

/* ---- cubes -------------------------------------------------------------- */

/* How many pixels differ; of how many the map is. */
static int differ(const view_settings *s, int width, int height, int *inside)
{
    int bad = 0;

    *inside = 0;
    for (int y = 0; y < height; y++)
        for (int x = 0; x < width; x++) {
            const float *c = seen[(height - 1 - y) * width + x];
            const view_texel t = view_inspect(&set, s, width, height, x, y);
            *inside += t.inside;
            if (t.inside)
                bad += c[3] != 1 || memcmp(c, t.value, sizeof t.value);
            else
                bad += c[3] != 0 || c[0] != 0;
        }
    return bad;
}

static void compare_views(view_settings *s)
{
    static const struct {
        int width, height;
        double zoom, pan[2];
    } views[] = {
        {128, 96, 1, {0, 0}},         {128, 64, 1, {0, 0}},
        {192, 32, 1, {0, 0}},         {97, 61, 1, {0, 0}},
        {37, 90, 1, {0, 0}},          {100, 75, 0.5, {0, 0}},
        {120, 90, 7.3, {0.21, -0.1}}, {64, 64, 60, {-0.125, 1 / 3.0}},
        {90, 40, 2, {0.5, 0.5}},
    };
    for (size_t i = 0; i < sizeof views / sizeof *views; i++)
        for (int kind = 0; kind < VIEW_LAYOUTS; kind++) {
            const int w = views[i].width, h = views[i].height;
            int inside;
            s->layout = (view_layout)kind;
            s->zoom = views[i].zoom;
            memcpy(s->pan, views[i].pan, sizeof s->pan);
            draw(s, w, h);
            const int bad = differ(s, w, h, &inside);
            CHECK_MSG(!bad, "%s, view %d, level %d: %d of %d pixels differ",
                      view_layout_names[s->layout], (int)i, s->level, bad,
                      w * h);
            CHECK(inside > 0 || i >= 7);
        }
}

TEST(shader_and_readout_agree)
{
    static const int edges[][2] = {{32, 6}, {12, 3}, {7, 2}, {1, 1}};
    view_settings s = view_settings_default();

    begin();
    for (size_t i = 0; i < sizeof edges / sizeof *edges; i++) {
        make_set(edges[i][0], edges[i][1]);
        s.mode = VIEW_LEVELS;
        for (s.level = 0; s.level < edges[i][1]; s.level += 2)
            compare_views(&s);
        s.mode = VIEW_IRRADIANCE_MAP;
        compare_views(&s);
    }
}

static double length(const double a[3], const double b[3])
{
    return sqrt((a[0] - b[0]) * (a[0] - b[0]) + (a[1] - b[1]) * (a[1] - b[1]) +
                (a[2] - b[2]) * (a[2] - b[2]));
}

/* One channel as grey, and the harmonics or the last level as irradiance. */
TEST(channels_and_kinds_of_irradiance)
{
    view_settings s = view_settings_default();
    int bad = 0;

    begin();
    make_set(8, 3);
    set.sh_degree = 2;
    for (int i = 0; i < 27; i++)
        set.sh[i] = i < 3 ? 9 : 0.25 * (i % 7);
    s.mode = VIEW_LEVELS;
    s.layout = VIEW_EQUIRECT;
    for (int channel = 0; channel < VIEW_CHANNELS; channel++) {
        s.channel = (view_channel)channel;
        draw(&s, 32, 16);
        for (int i = 0; i < 32 * 16; i++) {
            const view_texel t =
                view_inspect(&set, &s, 32, 16, i % 32, 15 - i / 32);
            const float *v = t.value;
            const float grey =
                channel < VIEW_ALPHA && channel ? v[channel - 1]
                : channel == VIEW_ALPHA
                    ? 1
                    : 0.2126F * v[0] + 0.7152F * v[1] + 0.0722F * v[2];
            for (int k = 0; k < 3; k++)
                bad += !(fabsf(seen[i][k] - (channel ? grey : v[k])) <= 1e-4F);
        }
    }
    CHECK_MSG(!bad, "%d channels differ", bad);
    s.channel = VIEW_RGB;
    s.mode = VIEW_IRRADIANCE_MAP;
    for (int kind = VIEW_DIFFUSE_SH; kind <= VIEW_DIFFUSE_LAST; kind++) {
        s.diffuse = (view_diffuse)kind;
        draw(&s, 32, 16);
        for (int i = 0; i < 32 * 16; i++) {
            const view_texel t =
                view_inspect(&set, &s, 32, 16, i % 32, 15 - i / 32);
            for (int k = 0; k < 3; k++)
                bad += !(fabsf(seen[i][k] - t.value[k]) <= 1e-4F);
            CHECK(kind != VIEW_DIFFUSE_LAST || t.value[0] >= 20);
        }
    }
    CHECK_MSG(!bad, "%d of irradiance differ", bad);
}

/* Between texel centres of a face values are linear in the place. */
TEST(filtering_interpolates)
{
    view_settings s = view_settings_default();

    begin();
    make_set(8, 1);
    s.mode = VIEW_LEVELS;
    s.layout = VIEW_STRIP;
    s.filter = true;
    draw(&s, 6 * 40, 40);
    for (int x = 5; x < 35; x++)
        for (int y = 5; y < 35; y++) {
            const float *c = seen[(39 - y) * 240 + 40 + x];
            CHECK_NEAR(c[1], (x + 0.5 + 1 / 32.0) / 5 - 0.5, 0.01);
            CHECK_NEAR(c[2], (y + 0.5 + 1 / 32.0) / 5 - 0.5, 0.01);
        }
}

/* The environment at its own resolution, and the directions of its texels. */
TEST(the_map_itself_is_shown)
{
    ibl_ctx *const reader = view_test_ctx(1);
    const ibl_image map = sets_read_map(reader);
    view_settings s = view_settings_default();
    baked_set baked;
    int bad = 0;

    begin();
    NEED(view_set_bake(reader, &(view_request){.path = sets_file()}, &baked));
    s.mode = VIEW_SOURCE_MAP;
    CHECK(view_renderer_load(renderer, &baked));
    CHECK(view_test_draw(renderer, &s, 64, 32));
    gl.ActiveTexture(GL_TEXTURE0 + VIEW_UNIT_PICTURE);
    gl.GetTexImage(GL_TEXTURE_2D, 0, GL_RGBA, GL_FLOAT, seen);
    for (int i = 0; i < 64 * 32; i++) {
        const float *want = map.data + 3 * i,
                    *c = seen[(31 - i / 64) * 64 + i % 64];
        const view_texel t = view_inspect(&baked, &s, 64, 32, i % 64, i / 64);
        double d[3];
        truth_latlong_direction(64, 32, i % 64, i / 64, d);
        bad += memcmp(want, c, 3 * sizeof *c) ||
               memcmp(want, t.value, sizeof t.value) ||
               !(length(d, t.direction) < 1e-6);
    }
    CHECK_MSG(!bad, "%d texels differ", bad);
    view_set_free(&baked);
}

/* ---- where things are ---------------------------------------------------- */

/* The faces of a cross and of a strip have their texels as the file has. */
TEST(faces_are_in_place)
{
    static const int cross[6][2] = {{2, 1}, {0, 1}, {1, 0},
                                    {1, 2}, {1, 1}, {3, 1}};
    make_set(8, 4);
    view_settings s = view_settings_default();

    s.mode = VIEW_LEVELS;
    s.level = 1;
    for (int face = 0; face < 6; face++)
        for (int i = 0; i < 16; i++) {
            const int x = i % 4, y = i / 4;
            double d[3];
            ibl_cube_direction(4, face, x, y, d);
            s.layout = VIEW_CROSS;
            view_texel t = view_inspect(&set, &s, 160, 120,
                                        cross[face][0] * 40 + x * 10 + 5,
                                        cross[face][1] * 40 + y * 10 + 5);
            CHECK(t.inside && t.face == face && t.x == x && t.y == y);
            CHECK(t.level == 1 && t.value[0] == (float)(10 + face));
            CHECK(length(t.direction, d) == 0);
            s.layout = VIEW_STRIP;
            t = view_inspect(&set, &s, 240, 60, face * 40 + x * 10 + 5,
                             10 + y * 10 + 5);
            CHECK(t.inside && t.face == face && t.x == x && t.y == y);
        }
    s.layout = VIEW_CROSS;
    CHECK(!view_inspect(&set, &s, 160, 120, 0, 0).inside);
    CHECK(!view_inspect(&set, &s, 160, 120, 80, 39).inside);
    CHECK(!view_inspect(&set, &s, 160, 120, -1, 60).inside);
    CHECK(!view_inspect(&set, &s, 160, 120, 160, 60).inside);
    s.level = 99;
    CHECK(view_inspect(&set, &s, 160, 120, 50, 50).level == 3);
}

/* u = atan2(z, x) / 2pi + 1/2, v from the zenith: pixels show their texels. */
TEST(equirects_are_mapped)
{
    make_set(64, 1);
    view_settings s = view_settings_default();

    s.mode = VIEW_LEVELS;
    s.layout = VIEW_EQUIRECT;
    for (int y = 0; y < 128; y++)
        for (int x = 0; x < 256; x++) {
            const view_texel t = view_inspect(&set, &s, 256, 128, x, y);
            const double phi = 2 * PI * ((x + 0.5) / 256 - 0.5);
            const double theta = PI * (y + 0.5) / 128;
            const double d[3] = {sin(theta) * cos(phi), cos(theta),
                                 sin(theta) * sin(phi)};
            /* Half of the diagonal of the largest texel, and some. */
            CHECK_MSG(t.inside && length(t.direction, d) < 1.45 / 64,
                      "%d, %d: %g away", x, y, length(t.direction, d));
        }
}

/* The sky behind spheres: the direction of a pixel's ray, turned. */
TEST(skies_are_read)
{
    static const double turns[] = {0, 30, 90, -135};
    make_set(256, 1);
    view_settings s = view_settings_default();
    view_sphere spheres[VIEW_MAX_GRID * VIEW_MAX_GRID];

    for (int i = 0; i < 4; i++) {
        s.turn = turns[i];
        s.yaw = 20 * i;
        s.pitch = 10 * i;
        const view_camera c = view_camera_of(&s, 80, 60);
        const int count = view_grid(&s, spheres);
        for (int y = 0; y < 60; y++)
            for (int x = 0; x < 80; x++) {
                const view_texel t =
                    view_inspect(&set, &s, 80, 60, x + 0.9, y + 0.9);
                double world[3], d[3];
                view_camera_ray(&c, 80, 60, x, y, world);
                view_turn(s.turn, world, d);
                const bool sphere =
                    view_grid_hit(spheres, count, c.eye, world, NULL) >= 0;
                CHECK(t.inside == !sphere);
                CHECK(!t.inside || (length(t.direction, d) < 1.45 / 256 &&
                                    t.value[0] == (float)t.face));
            }
    }
    s.turn = s.yaw = s.pitch = 0;
    view_texel t = view_inspect(&set, &s, 400, 60, 0, 30);
    CHECK(t.inside && t.direction[0] < -0.5 && t.direction[2] < -0.1);
    s.turn = 90; /* what was ahead, -Z, is now to the left */
    const double world[3] = {-1, 0, 0};
    double d[3];
    view_turn(s.turn, world, d);
    CHECK_NEAR(d[2], -1, 1e-12);
    name_texels(&set.baked.file[IBL_CONTENT_SKYBOX].texture, 8, 1, 50);
    t = view_inspect(&set, &s, 400, 60, 0, 30);
    CHECK(t.value[0] == (float)(50 + t.face) && t.x < 8);
    CHECK(!view_inspect(&set, &s, 400, 60, -1, 30).inside);
    CHECK(!view_inspect(&set, &s, 400, 60, 0, 60).inside);
    s.background = VIEW_BACKGROUND_COLOUR;
    CHECK(!view_inspect(&set, &s, 400, 60, 0, 30).inside);
}

/* ---- the table ---------------------------------------------------------- */

/* Lines lie where R (white) and G (blue) are 0.1, 0.2, .., and elsewhere the
 * texels are as they are. The table's ramps say where: R to the right, G up. */
TEST(lines_are_at_values)
{
    enum {
        W = 256
    };
    view_settings s = view_settings_default();
    int white = 0, blue = 0;

    begin();
    make_set(4, 1);
    s.mode = VIEW_TABLE;
    draw(&s, W, W);
    for (int y = 0; y < W; y++)
        for (int x = 0; x < W; x++) {
            const float *c = seen[(W - 1 - y) * W + x];
            const view_texel t = view_inspect(&set, &s, W, W, x, y);
            const double r = (x + 0.5) / W, g = (W - y - 0.5) / W / 2;
            /* pixels from a line */
            const double far_r = fabs(r - fmax(rint(r * 10), 1) / 10) * W;
            const double far_g = fabs(g - fmax(rint(g * 10), 1) / 10) * 2 * W;
            const bool edge_r = r > 0.95, edge_g = g < 0.05;
            CHECK(t.inside && t.face == -1 && t.x == x / 4 &&
                  t.y == (W - 1 - y) / 4);
            CHECK_NEAR(t.direction[0], (x / 4 + 0.5) / 64, 1e-12);
            CHECK_NEAR(t.direction[1], ((W - 1 - y) / 4 + 0.5) / 64, 1e-12);
            CHECK(t.value[0] == (float)t.direction[0]);
            CHECK(t.value[1] == (float)(t.direction[1] / 2));
            if (!edge_r && far_r < 0.3)
                white++, CHECK(c[0] > 0.6 && c[1] > 0.6 && c[2] > 0.6);
            else if ((edge_r || far_r > 1.1) && !edge_g && far_g < 0.3)
                blue++, CHECK(c[2] > 0.6 && c[0] < 0.4 && c[1] < 0.6);
            else if ((edge_r || far_r > 1.1) && (edge_g || far_g > 1.1))
                CHECK(c[0] == t.value[0] && c[1] == t.value[1] && c[2] == 0);
        }
    CHECK(white >= 9 * W / 2 && blue >= 4 * W / 2);
}

/* Whatever values there are, none is at 0 or 1, nor where all are alike. */
TEST(no_lines_at_the_ends)
{
    enum {
        W = 256
    };
    view_settings s = view_settings_default();
    int bad = 0, ends = 0;

    begin();
    make_set(4, 1);
    const ibl_texture *lut = &set.baked.file[IBL_CONTENT_LUT].texture;
    float *rg = (float *)(void *)lut->data;
    for (int i = 0; i < lut->width * lut->height; i++) {
        rg[2 * i] = 1.4f * (float)(i % lut->width) / (float)lut->width - 0.2f;
        rg[2 * i + 1] = 0.5f;
    }
    s.mode = VIEW_TABLE;
    draw(&s, W, W);
    for (int i = 0; i < W * W; i++) {
        const view_texel t = view_inspect(&set, &s, W, W, i % W, W - 1 - i / W);
        const float r = t.value[0];
        if (r > 0.07f && r < 0.93f)
            continue;
        ends++;
        bad += seen[i][0] != r || seen[i][1] != 0.5f || seen[i][2] != 0;
    }
    CHECK_MSG(ends > W * W / 4 && !bad, "%d of %d", bad, ends);
}

/* ---- moving and telling ------------------------------------------------- */

TEST(zoom_keeps_what_is_there)
{
    make_set(64, 1);
    view_settings s = view_settings_default();

    s.mode = VIEW_LEVELS;
    const view_texel t = view_inspect(&set, &s, 320, 240, 100, 130);
    for (int i = 0; i < 4; i++)
        view_inspect_zoom(&set, &s, 320, 240, 100.5, 130.5, 1.25);
    CHECK_NEAR(s.zoom, 1.25 * 1.25 * 1.25 * 1.25, 1e-12);
    view_texel u = view_inspect(&set, &s, 320, 240, 100, 130);
    CHECK(u.inside && u.face == t.face && u.x == t.x && u.y == t.y);
    view_inspect_drag(&set, &s, 320, 240, 40, -25);
    u = view_inspect(&set, &s, 320, 240, 140, 105);
    CHECK(u.inside && u.face == t.face && u.x == t.x && u.y == t.y);
    for (int i = 0; i < 100; i++)
        view_inspect_zoom(&set, &s, 320, 240, 140, 105, 1.25);
    /* a texel is a fourth of the window's smaller side */
    CHECK_NEAR(s.zoom * 320 / 256, 60, 1e-9);
    for (int i = 0; i < 100; i++)
        view_inspect_zoom(&set, &s, 320, 240, 0, 0, 0.8);
    CHECK(s.zoom == 0.25);
    view_inspect_drag(&set, &s, 320, 240, 1e9, -1e9);
    CHECK(s.pan[0] == -0.5 && s.pan[1] == 0.5);
}

TEST(absent_maps_are_not_inside)
{
    view_settings s = view_settings_default();

    for (int mode = 0; mode < VIEW_MODES; mode++) {
        s.mode = (view_mode)mode;
        CHECK(!view_inspect(&set, &s, 64, 48, 32, 24).inside);
        view_inspect_zoom(&set, &s, 64, 48, 0, 0, 2);
        view_inspect_drag(&set, &s, 64, 48, 1, 1);
    }
    CHECK(s.zoom == 1 && s.pan[0] == 0);
}
