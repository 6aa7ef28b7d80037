/* SPDX-License-Identifier: MIT */
/* Maps laid out flat: what is shown at each pixel, and what is read out there,
 * are of the texel that a layout in double finds. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "sets.h"
#include "test.h"
#include "truth.h"
#include "view.h"

enum {
    MOST = 256 /* pixels of a window's side */
};

static view_renderer *renderer;
static baked_set set;              /* of the running test */
static float seen[MOST * MOST][4]; /* rows from the bottom */

/* ---- sets --------------------------------------------------------------- */

/* A cube that tells of each texel which it is, all different. */
static void name_texels(ibl_ctx *ctx, ibl_texture *tex, int edge, int levels,
                        int extra)
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

/* A table of N.V and roughness themselves. */
static void ramp_table(ibl_ctx *ctx, ibl_texture *tex)
{
    enum {
        SIZE = 64
    };
    float texels[2 * SIZE * SIZE];
    const ibl_lut lut = {SIZE, texels, IBL_LUT_SPLIT};

    for (int i = 0; i < SIZE * SIZE; i++) {
        texels[2 * i] = ((float)(i % SIZE) + 0.5F) / SIZE;
        texels[2 * i + 1] = ((float)(i / SIZE) + 0.5F) / SIZE;
    }
    CHECK(!ibl_texture_from_lut(ctx, &lut, IBL_PIXEL_RG32F, tex, NULL));
}

static void end(void *unused)
{
    (void)unused;
    view_renderer_free(renderer);
    renderer = NULL;
    view_set_free(&set);
}

static void begin(int edge, int levels)
{
    ibl_ctx *ctx = view_test_ctx(1);

    end(NULL);
    view_test_begin(16, 16);
    renderer = view_renderer_create();
    NEED(renderer);
    set = (baked_set){.sh_degree = 2};
    set.baked.file[IBL_CONTENT_SPECULAR].facts.lod_scale = levels - 1;
    set.baked.file[IBL_CONTENT_IRRADIANCE].facts.irradiance_scale = 1;
    test_defer(end, NULL);
    for (int i = 0; i < 27; i++)
        set.sh[i] = i < 3 ? 9 : 0.25 * (i % 7);
    name_texels(ctx, &set.baked.file[IBL_CONTENT_SPECULAR].texture, edge,
                levels, 0);
    name_texels(ctx, &set.baked.file[IBL_CONTENT_IRRADIANCE].texture,
                edge / 2 + 1, 1, 100);
    NEED(view_renderer_load(renderer, &set));
}

static void draw(const view_settings *s, int width, int height)
{
    CHECK(view_test_draw(renderer, s, width, height));
    gl.ActiveTexture(GL_TEXTURE0 + VIEW_UNIT_PICTURE);
    gl.GetTexImage(GL_TEXTURE_2D, 0, GL_RGBA, GL_FLOAT, seen);
    CHECK(view_gl_check("test"));
}

/* ---- the layout in double ------------------------------------------------ */

typedef struct texel {
    int face, level, x, y;
    double direction[3], value[3];
} texel;

/* The point of a map, in texels from its upper left, at a pixel from the upper
 * left of the window; false: beside it. Pixels' centres are off the edges of
 * texels, and what the shader has as floats are floats. */
static bool find_point(const view_settings *s, const double size[2], int width,
                       int height, int x, int y, double p[2])
{
    const double at[2] = {x + 0.5 + 1.0 / 32 - 0.5 * width,
                          y + 0.5 + 1.0 / 32 - 0.5 * height};
    const double scale =
        (float)s->zoom * fmin(width / size[0], height / size[1]);

    for (int k = 0; k < 2; k++)
        p[k] = size[k] * (0.5 + (float)s->pan[k]) + at[k] / scale;
    return p[0] >= 0 && p[0] < size[0] && p[1] >= 0 && p[1] < size[1];
}

/* u = atan2(z, x) / 2pi + 1/2, v from the zenith. */
static void equirect_texel(double u, double v, int edge, int at[3])
{
    const double phi = 2 * M_PI * (u - 0.5), theta = M_PI * v;
    const double d[3] = {sin(theta) * cos(phi), cos(theta),
                         sin(theta) * sin(phi)};
    const ibl_level_shape shape = ibl_level_shape_of(IBL_PROJECTION_CUBE, edge);

    ibl_level_texel(&shape, d, at);
}

static bool find_texel(const view_settings *s, int width, int height, int x,
                       int y, texel *t)
{
    static const int cells[VIEW_LAYOUTS][2] = {{4, 3}, {6, 1}, {4, 2}};
    static const int cross[3][4] = {
        {-1, 2, -1, -1}, {1, 4, 0, 5}, {-1, 3, -1, -1}};
    const bool matte = s->mode == VIEW_IRRADIANCE_MAP;
    const view_diffuse by = view_diffuse_of(s, &set);
    const bool own = matte && by != VIEW_DIFFUSE_LAST;
    const ibl_texture *map =
        &set.baked.file[own ? IBL_CONTENT_IRRADIANCE : IBL_CONTENT_SPECULAR]
             .texture;
    double p[2];

    t->level = !matte && s->level < map->levels ? s->level : map->levels - 1;
    const int edge =
        own && by == VIEW_DIFFUSE_SH ? 32 : ibl_cube_edge(map->width, t->level);
    const double size[2] = {cells[s->layout][0] * edge,
                            cells[s->layout][1] * edge};
    if (!find_point(s, size, width, height, x, y, p))
        return false;
    const int column = (int)p[0] / edge, row = (int)p[1] / edge;
    int at[3] = {s->layout == VIEW_STRIP ? column : cross[row][column],
                 (int)p[0] - column * edge, (int)p[1] - row * edge};
    if (s->layout == VIEW_EQUIRECT)
        equirect_texel(p[0] / size[0], p[1] / size[1], edge, at);
    t->face = at[0], t->x = at[1], t->y = at[2];
    if (t->face < 0)
        return false;
    ibl_cube_direction(edge, t->face, t->x, t->y, t->direction);
    t->value[0] = t->face + 10 * t->level + 100 * own;
    t->value[1] = t->x, t->value[2] = t->y;
    if (own && by == VIEW_DIFFUSE_SH)
        view_harmonics_sum(set.sh, 9, 3, t->direction, t->value);
    return true;
}

/* ---- cubes -------------------------------------------------------------- */

/* How many of the numbers that are told of a pixel are wrong. */
static int check_told(const view_settings *s, int width, int height, int x,
                      int y)
{
    float told[3][4];
    texel t;
    int bad = 0;

    const bool inside = find_texel(s, width, height, x, y, &t);
    if (view_renderer_texel(renderer, x, height - 1 - y, told) != inside)
        return 1;
    for (int k = 0; inside && k < 3; k++)
        bad += !(fabs(told[1][k] - t.direction[k]) < 1e-6) +
               !(fabs(told[2][k] - t.value[k]) < 1e-4);
    return inside ? bad + ((int)told[0][0] != t.face) +
                        ((int)told[0][1] != t.level) +
                        ((int)told[0][2] != t.x) + ((int)told[0][3] != t.y)
                  : 0;
}

/* Draws and compares each pixel, and what is told of some; how many are of the
 * map. */
static int compare(const view_settings *s, int width, int height)
{
    int bad = 0, told = 0, inside = 0;
    texel t;

    draw(s, width, height);
    for (int i = 0; i < width * height; i++) {
        const int x = i % width, y = height - 1 - i / width;
        if (!find_texel(s, width, height, x, y, &t)) {
            bad += seen[i][3] != 0 || seen[i][0] != 0;
            continue;
        }
        const double *v = t.value;
        const double grey = s->channel == VIEW_ALPHA ? 1
                            : s->channel == VIEW_LUMINANCE
                                ? 0.2126 * v[0] + 0.7152 * v[1] + 0.0722 * v[2]
                            : s->channel ? v[s->channel - 1]
                                         : 0;
        for (int k = 0; k < 3; k++)
            bad += !(fabs(seen[i][k] - (s->channel ? grey : v[k])) <= 1e-4);
        bad += seen[i][3] != 1;
        inside++;
    }
    for (int i = 0; i < width * height; i += 97)
        told += check_told(s, width, height, i % width, i / width);
    CHECK_MSG(!bad && !told,
              "%s, %s, level %d, channel %d, zoom %g: %d of %d are wrong, and "
              "%d of what is told",
              view_mode_names[s->mode], view_layout_names[s->layout], s->level,
              (int)s->channel, s->zoom, bad, width * height, told);
    return inside;
}

TEST(texels_are_where_they_should)
{
    static const int edges[][2] = {{32, 6}, {12, 3}, {7, 2}, {1, 1}};
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
    view_settings s = view_settings_default();

    for (int e = 0; e < 4; e++) {
        const int modes = (edges[e][1] + 1) / 2 + 1;
        begin(edges[e][0], edges[e][1]);
        for (int i = 0; i < 9 * VIEW_LAYOUTS * modes; i++) {
            const int view = i / VIEW_LAYOUTS % 9;
            s.layout = (view_layout)(i % VIEW_LAYOUTS);
            s.level = i / VIEW_LAYOUTS / 9 * 2;
            s.mode = s.level < edges[e][1] ? VIEW_LEVELS : VIEW_IRRADIANCE_MAP;
            s.zoom = views[view].zoom;
            memcpy(s.pan, views[view].pan, sizeof s.pan);
            const int inside =
                compare(&s, views[view].width, views[view].height);
            CHECK(inside > 0 || view >= 7);
        }
    }
}

/* One channel as grey, and the harmonics or the last level as irradiance; what
 * is told is the texel as it is. */
TEST(channels_and_kinds_of_irradiance)
{
    view_settings s = view_settings_default();

    begin(8, 3);
    s.layout = VIEW_EQUIRECT;
    s.mode = VIEW_LEVELS;
    for (int channel = 0; channel < VIEW_CHANNELS; channel++) {
        s.channel = (view_channel)channel;
        CHECK(compare(&s, 64, 32) == 64 * 32);
    }
    s.level = 99;
    CHECK(compare(&s, 64, 32));
    s.mode = VIEW_IRRADIANCE_MAP;
    s.channel = VIEW_RGB;
    for (int by = 0; by < VIEW_DIFFUSES; by++) {
        s.diffuse = (view_diffuse)by;
        CHECK(compare(&s, 64, 32) == 64 * 32);
    }
}

/* Between texel centres of a face values are linear in the place. */
TEST(filtering_interpolates)
{
    view_settings s = view_settings_default();

    begin(8, 1);
    s.mode = VIEW_LEVELS;
    s.layout = VIEW_STRIP;
    s.filter = true;
    draw(&s, 6 * 40, 40);
    for (int x = 5; x < 35; x++)
        for (int y = 5; y < 35; y++) {
            const float *c = seen[(39 - y) * 240 + 40 + x];
            CHECK_NEAR(c[1], (x + 0.5 + 1 / 32.0) / 5 - 0.5, 0.01);
            CHECK_NEAR(c[2], (y + 0.5 + 1 / 32.0) / 5 - 0.5, 0.01);
            CHECK(!check_told(&s, 240, 40, 40 + x, y));
        }
}

/* The environment at its own resolution, and the directions of its texels. */
TEST(the_map_itself_is_shown)
{
    ibl_ctx *const reader = view_test_ctx(1);
    const ibl_image map = sets_read_map(reader);
    view_settings s = view_settings_default();
    float told[3][4];
    int bad = 0;

    begin(1, 1);
    s.mode = VIEW_SOURCE_MAP;
    draw(&s, 64, 32);
    CHECK(!view_renderer_texel(renderer, 3, 3, told)); /* it is not at hand */
    view_set_free(&set);
    NEED(view_set_bake(reader, &(view_request){.path = sets_file()}, &set) &&
         view_renderer_load(renderer, &set));
    draw(&s, 64, 32);
    for (int i = 0; i < 64 * 32; i++) {
        const int x = i % 64, y = 31 - i / 64;
        const float *want = map.data + (ptrdiff_t)3 * (y * 64 + x);
        double d[3];
        truth_latlong_direction(64, 32, x, y, d);
        bad += memcmp(want, seen[i], 3 * sizeof *want) != 0 ||
               !view_renderer_texel(renderer, x, i / 64, told) ||
               (int)told[0][0] != -1 || (int)told[0][2] != x ||
               (int)told[0][3] != y ||
               memcmp(want, told[2], 3 * sizeof *want) != 0;
        for (int k = 0; k < 3; k++)
            bad += !(fabs(told[1][k] - d[k]) < 1e-6);
    }
    CHECK_MSG(!bad, "%d texels differ", bad);
}

/* ---- the table ---------------------------------------------------------- */

/* N.V to the right, roughness upwards: texels are as they are. */
TEST(table_is_shown)
{
    const ibl_texture *lut = &set.baked.file[IBL_CONTENT_LUT].texture;
    view_settings s = view_settings_default();
    int bad = 0;

    s.mode = VIEW_TABLE;
    begin(4, 1);
    ramp_table(view_test_ctx(1), &set.baked.file[IBL_CONTENT_LUT].texture);
    NEED(view_renderer_load(renderer, &set));
    draw(&s, MOST, MOST);
    for (int n = 0; n < MOST * MOST; n++) {
        const int x = n % MOST, y = n / MOST, size = lut->width;
        const int at[2] = {x * size / MOST, y * size / MOST};
        const float want[3] = {((float)at[0] + 0.5F) / (float)size,
                               ((float)at[1] + 0.5F) / (float)size};
        float told[3][4];
        bad += memcmp(seen[n], want, sizeof want) != 0;
        bad +=
            n % 61 == 0 &&
            (!view_renderer_texel(renderer, x, y, told) ||
             (int)told[0][0] != -1 || (int)told[0][2] != at[0] ||
             (int)told[0][3] != at[1] || memcmp(told[1], want, sizeof want) ||
             memcmp(told[2], want, sizeof want) != 0);
    }
    CHECK_MSG(!bad, "%d are wrong", bad);
}

/* ---- moving ------------------------------------------------------------- */

/* Checks that what was at one pixel is at another. */
static void check_moved(const view_app *app, int x, int y, float was[4])
{
    float told[3][4];

    draw(&app->side[0], app->width, app->height);
    CHECK(view_renderer_texel(renderer, x, app->height - 1 - y, told));
    CHECK_MSG(!(*was > 0) || !memcmp(was, told[0], sizeof told[0]),
              "at %d, %d: face %g (%g, %g)", x, y, told[0][0], told[0][2],
              told[0][3]);
    memcpy(was, told[0], sizeof told[0]);
}

TEST(zoom_keeps_what_is_there)
{
    static view_options options;
    static view_app app;
    float was[4] = {0};

    begin(64, 1);
    view_test_app(&app, &options, 160, 120);
    app.set = &set;
    app.labels = false;
    app.side[0].mode = VIEW_LEVELS;
    check_moved(&app, 50, 65, was);
    CHECK(*was > 0);
    view_approach(&app, 50.5, 65.5, 9);
    CHECK_NEAR(app.side[0].zoom, pow(1.1, 9), 1e-12);
    check_moved(&app, 50, 65, was);
    view_drag(&app, 40, -25);
    check_moved(&app, 90, 40, was);
    view_approach(&app, 90.5, 40.5, -4);
    check_moved(&app, 90, 40, was);
    view_approach(&app, 0, 0, 200);
    CHECK(app.side[0].zoom == 10000);
    view_approach(&app, 0, 0, -400);
    CHECK(app.side[0].zoom == 0.25);
    view_drag(&app, 1e9, -1e9);
    CHECK(app.side[0].pan[0] == -0.5 && app.side[0].pan[1] == 0.5);
}
