/* SPDX-License-Identifier: MIT */
/*
 * Models: squares that face the camera under a constant light, whose every
 * layer has a closed form; a mesh of a sphere against the sphere of the grid,
 * which is ray-traced; and what is in front of what.
 */
#include <math.h>
#include <string.h>
#include <time.h>

#include "ibl/reference.h"
#include "maps.h"
#include "shade.h"
#include "view/model.h"
#include "view/set_parts.h"

enum {
    EDGE = 64, /* of pictures */
    MIDDLE = EDGE / 2 * EDGE + EDGE / 2
};

static const float sky[3] = {2, 0.5f, 0.25f};
static const ibl_scene_texture none = {.image = -1,
                                       .scale = {1, 1},
                                       .wrap_s = GL_REPEAT,
                                       .wrap_t = GL_REPEAT,
                                       .filter_min = GL_NEAREST,
                                       .filter_mag = GL_NEAREST};
static const double identity[16] = {[0] = 1, [5] = 1, [10] = 1, [15] = 1};

/* Of the running test: up to three squares, or a sphere. */
static struct {
    ibl_scene scene;
    ibl_scene_primitive part[3];
    ibl_scene_material material[3];
    ibl_scene_draw draw[3];
    ibl_scene_image image[2];
    unsigned char texels[2][16];
    view_settings settings;
} on;

static void free_model(void *model)
{
    view_renderer_model(shade_renderer(), NULL);
    view_model_free(model);
}

static ibl_scene_material plain(void)
{
    static char name[] = "plain";
    ibl_scene_material m = {.name = name,
                            .base_colour = {1, 1, 1, 1},
                            .roughness = 1,
                            .normal_scale = 1,
                            .occlusion_strength = 1,
                            .alpha_cutoff = 0.5f,
                            .ior = 1.5f,
                            .specular = 1,
                            .specular_colour = {1, 1, 1},
                            .clearcoat_normal_scale = 1};
    ibl_scene_texture *t = &m.base_colour_texture;

    for (; t <= &m.transmission_texture; t++)
        *t = none;
    return m;
}

/* A square at z, from -x to x along its edges, facing +Z. */
static void square(int i, double x, double z)
{
    static const float corner[4][2] = {{-1, -1}, {1, -1}, {-1, 1}, {1, 1}};
    static uint32_t index[6] = {0, 1, 2, 2, 1, 3};
    float *floats = test_alloc(4 * 8, sizeof *floats);
    float *normal = floats + 12, *texcoord = floats + 24;

    for (int v = 0; v < 4; v++) {
        for (int k = 0; k < 2; k++)
            floats[3 * v + k] = (float)x * corner[v][k];
        floats[3 * v + 2] = (float)z;
        normal[3 * v + 2] = 1;
        texcoord[2 * v] = 0.5f + 0.5f * corner[v][0];
        texcoord[2 * v + 1] = 0.5f - 0.5f * corner[v][1];
    }
    on.part[i] = (ibl_scene_primitive){.material = i,
                                       .vertex_count = 4,
                                       .index_count = 6,
                                       .position = floats,
                                       .normal = normal,
                                       .texcoord = {texcoord},
                                       .index = index};
    on.material[i] = plain();
    on.draw[i].primitive = i;
    memcpy(on.draw[i].to_world, identity, sizeof identity);
    on.scene.primitive_count = on.scene.material_count = on.scene.draw_count =
        i + 1;
}

/* An image of 2 x 2 texels, row by row from the top. */
static ibl_scene_texture image(int i, const unsigned char texels[16])
{
    static char name[] = "image";
    ibl_scene_texture t = none;

    memcpy(on.texels[i], texels, 16);
    on.image[i] = (ibl_scene_image){
        .name = name, .width = 2, .height = 2, .rgba = on.texels[i]};
    on.scene.image_count = i + 1;
    t.image = i;
    return t;
}

/* A screen, and a constant light; the squares fill the picture's middle. */
static void begin(void)
{
    memset(&on, 0, sizeof on);
    on.scene.primitives = on.part;
    on.scene.materials = on.material;
    on.scene.draws = on.draw;
    on.scene.images = on.image;
    on.scene.bounds[0][0] = on.scene.bounds[0][1] = -1;
    on.scene.bounds[1][0] = on.scene.bounds[1][1] = 1;
    shade_begin(EDGE, EDGE);
    shade_constant(&shade_sets[0], sky);
    on.settings = view_settings_default();
    on.settings.mode = VIEW_MODEL;
    on.settings.multiscatter = false;
    on.settings.fov = 20;
    square(0, 1, 0);
}

static float *draw(void)
{
    view_model *m = view_model_create(shade_ctx(), &on.scene, "test");

    NEED(m);
    test_defer(free_model, m);
    view_renderer_model(shade_renderer(), m);
    return shade_draw(&shade_sets[0].set, &on.settings);
}

/* Light that varies slowly, of another colour in each direction. */
static void vary(void)
{
    ibl_specular_options opts = ibl_specular_options_default();
    const ibl_image map = map_constant(shade_ctx(), 64, 32, 0);

    for (int y = 0; y < 32; y++)
        for (int x = 0; x < 64; x++)
            map_set(&map, x, y, 1 + 0.9f * sinf((float)x * 0.0982f),
                    1 + 0.9f * cosf((float)x * 0.0982f), 0.1f * (float)y);
    opts.size = 32;
    opts.levels = 4;
    shade_bake(&shade_sets[0], &map, &opts);
}

/* Colours at a pixel against light times the factors. */
static void expect(const char *what, const float *rgb, const double factor[3],
                   double most)
{
    for (int k = 0; k < 3; k++)
        CHECK_MSG(fabs(rgb[k] / (double)sky[k] - factor[k]) <= most,
                  "%s: %g of %d, not %g", what, rgb[k] / (double)sky[k], k,
                  factor[k]);
}

/* N.V in the picture's middle is 1 but for half a pixel. */
static void table(double roughness, double rg[2])
{
    ibl_lookup_lut(&shade_sets[0].lut, 1, roughness, rg);
}

/* ---- layers in closed form ----------------------------------------------- */

TEST(metallic_roughness)
{
    static const double cases[][2] = {{0, 1}, {1, 0.3}, {0.5, 0.6}};

    begin();
    for (int i = 0; i < 3; i++) {
        ibl_scene_material *m = &on.material[0];
        const double metallic = cases[i][0], base[3] = {0.8, 0.4, 0.1};
        double rg[2], wanted[3];
        m->metallic = (float)metallic;
        m->roughness = (float)cases[i][1];
        table(cases[i][1], rg);
        for (int k = 0; k < 3; k++) {
            const double f0 = 0.04 + metallic * (base[k] - 0.04);
            const double once = f0 * rg[0] + rg[1];
            m->base_colour[k] = (float)base[k];
            wanted[k] = once + base[k] * (1 - metallic) * (1 - once);
        }
        expect("looked up", draw() + 3 * MIDDLE, wanted, 1e-4);
    }
}

/* The integral of the same, as far as its samples go. */
TEST(reference)
{
    double rg[2], wanted[3];

    begin();
    on.settings.reflection = VIEW_REFERENCE;
    on.material[0].metallic = 1;
    on.material[0].roughness = 0.5f;
    on.material[0].clearcoat = 1;
    view_renderer_pace(shade_renderer(), 256);
    table(0.5, rg);
    for (int k = 0; k < 3; k++)
        wanted[k] = 0.96 * (rg[0] + rg[1]) + 0.04;
    expect("integral", draw() + 3 * MIDDLE, wanted, 5e-3);
}

TEST(coat)
{
    double rg[2], over[2], wanted[3];

    begin();
    on.material[0].metallic = 1;
    on.material[0].roughness = 0.7f;
    on.material[0].clearcoat = 0.5f;
    on.material[0].clearcoat_roughness = 0.2f;
    table(0.7, rg);
    table(0.2, over);
    for (int k = 0; k < 3; k++)
        wanted[k] = (1 - 0.5 * 0.04) * (rg[0] + rg[1]) +
                    0.5 * (0.04 * over[0] + over[1]);
    expect("coat", draw() + 3 * MIDDLE, wanted, 1e-4);
}

/* What sheen reflects is taken from what is below, by its largest channel. */
TEST(sheen)
{
    const double levels[] = {0, 0.3, 0.6, 1}, colour[3] = {0.8, 0.4, 0.2};
    shade_set *set = &shade_sets[0];
    double rg[2], albedo[2], wanted[3];

    begin();
    NEED(!ibl_texture_from_cube(shade_ctx(), &set->specular, NULL,
                                &set->set.texture[VIEW_SHEEN], NULL) &&
         view_set_fill_sheen(shade_ctx(), levels, 4, &set->set));
    for (int k = 0; k < 3; k++)
        on.material[0].sheen_colour[k] = (float)colour[k];
    on.material[0].sheen_roughness = 0.5f;
    on.material[0].metallic = 1;
    NEED(!ibl_reference_sheen(shade_ctx(), 1, 0.5, albedo));
    table(1, rg);
    for (int k = 0; k < 3; k++)
        wanted[k] =
            (rg[0] + rg[1]) * (1 - 0.8 * albedo[0]) + colour[k] * albedo[0];
    expect("sheen", draw() + 3 * MIDDLE, wanted, 5e-3);
    on.settings.reflection = VIEW_REFERENCE;
    view_renderer_pace(shade_renderer(), 256);
    expect("its integral", draw() + 3 * MIDDLE, wanted, 1e-2);
}

TEST(specular_and_ior)
{
    double rg[2], wanted[3];

    begin();
    on.material[0].roughness = 0.5f;
    on.material[0].ior = 2;
    on.material[0].specular = 0.5f;
    on.material[0].specular_colour[1] = 0.5f;
    memset(on.material[0].base_colour, 0, 3 * sizeof(float));
    table(0.5, rg);
    for (int k = 0; k < 3; k++)
        wanted[k] = 0.5 * ((k == 1 ? 0.5 : 1) / 9 * rg[0] + rg[1]);
    expect("specular", draw() + 3 * MIDDLE, wanted, 1e-4);
}

/* Vertex colours, occlusion, emission, and none of it if unlit. */
TEST(factors)
{
    static const unsigned char dark[16] = {51, 0, 0, 0, 51, 0, 0, 0,
                                           51, 0, 0, 0, 51, 0, 0, 0};
    static float tint[16] = {.5f, 1, 1, 1, .5f, 1, 1, 1,
                             .5f, 1, 1, 1, .5f, 1, 1, 1};
    ibl_scene_material *m = &on.material[0];
    double rg[2], wanted[3];

    begin();
    table(1, rg);
    on.part[0].colour = tint;
    m->occlusion_texture = image(0, dark);
    m->occlusion_strength = 0.5f;
    m->emissive[2] = 3;
    for (int k = 0; k < 3; k++) {
        const double once = 0.04 * rg[0] + rg[1];
        wanted[k] =
            0.6 * (once + (k ? 1 : 0.5) * (1 - once)) + (k == 2 ? 3 / 0.25 : 0);
    }
    expect("occluded", draw() + 3 * MIDDLE, wanted, 1e-4);
    m->unlit = true;
    for (int k = 0; k < 3; k++)
        wanted[k] = (k ? 1 : 0.5) / (double)sky[k];
    expect("unlit", draw() + 3 * MIDDLE, wanted, 1e-5);
}

/* White that loses nothing is the colour of the light. */
TEST(furnace)
{
    const double white[3] = {1, 1, 1};

    begin();
    on.settings.multiscatter = true;
    on.material[0].metallic = 1;
    for (int i = 0; i < 5; i++) {
        on.material[0].roughness = 0.25f * (float)i;
        expect("white", draw() + 3 * MIDDLE, white, 1e-5);
    }
}

/* ---- textures ------------------------------------------------------------ */

static const unsigned char four[16] = {255, 0, 0,   255, 0,   255, 0, 255,
                                       0,   0, 255, 255, 255, 255, 0, 0};

/* A pixel in the middle of a quarter of the square: 0 upper left, 1 upper
 * right, 2 lower left, 3 lower right. */
static const float *quarter(const float *picture, int i)
{
    const int x = EDGE / 2 + (i % 2 ? 10 : -10);
    const int y = EDGE / 2 + (i / 2 ? 10 : -10);

    return picture + 3 * (y * EDGE + x);
}

static bool is(const float *rgb, int texel)
{
    for (int k = 0; k < 3; k++)
        if (fabs(rgb[k] - four[4 * texel + k] / 255.0) > 1e-3)
            return false;
    return true;
}

/* KHR_texture_transform: turned by 90 degrees, u' = v and v' = -u; an offset of
 * a half moves by a texel; the second coordinates. */
TEST(texture_transform)
{
    static const int plain_order[] = {0, 1, 2, 3}, turned[] = {2, 0, 3, 1},
                     moved[] = {1, 0, 3, 2};
    ibl_scene_texture *t = &on.material[0].base_colour_texture;
    const int *orders[] = {plain_order, turned, moved, moved};

    begin();
    on.material[0].unlit = true;
    *t = image(0, four);
    for (int i = 0; i < 4; i++) {
        t->rotation = i == 1 ? (float)acos(0.0) : 0;
        t->offset[0] = i >= 2 ? 0.5f : 0;
        t->texcoord = i == 3;
        on.part[0].texcoord[1] = on.part[0].texcoord[0];
        const float *picture = draw();
        for (int k = 0; k < 4; k++)
            CHECK_MSG(is(quarter(picture, k), orders[i][k]),
                      "case %d, quarter %d", i, k);
    }
}

/* A tilt by a normal map is one of the vertices' normals: on the front and the
 * back, mirrored, with tangents of the file and without. */
static void tilt(const double n[3], bool by_map, bool tangents)
{
    static float tangent[16] = {1, 0, 0, 1, 1, 0, 0, 1, 1, 0, 0, 1, 1, 0, 0, 1};
    unsigned char texels[16];

    square(0, 1, 0);
    on.material[0].metallic = 1;
    on.material[0].roughness = 0;
    on.material[0].double_sided = true;
    if (!by_map) {
        for (int v = 0; v < 4; v++)
            for (int k = 0; k < 3; k++)
                on.part[0].normal[3 * v + k] = (float)n[k];
        return;
    }
    for (int i = 0; i < 16; i++)
        texels[i] =
            i % 4 == 3 ? 255 : (unsigned char)lrint(127.5 * (n[i % 4] + 1));
    on.part[0].tangent = tangents ? tangent : NULL;
    on.material[0].normal_texture = image(0, texels);
}

TEST_SLOW(normal_maps)
{
    const double n[3] = {0.28, 0.48, sqrt(1 - 0.28 * 0.28 - 0.48 * 0.48)};

    begin();
    vary();
    for (int i = 0; i < 8; i++) {
        const bool mirrored = i & 1, behind = i & 2, tangents = i & 4;
        float rgb[2][3];
        on.settings.yaw = behind ? 180 : 0;
        for (int by_map = 0; by_map < 2; by_map++) {
            tilt(n, by_map, tangents);
            on.draw[0].to_world[0] = mirrored ? -1 : 1;
            memcpy(rgb[by_map], draw() + 3 * MIDDLE, sizeof rgb[0]);
        }
        for (int k = 0; k < 3; k++)
            CHECK_MSG(fabs(rgb[0][k] - rgb[1][k]) < 0.03 * rgb[0][k],
                      "case %d: %g, not %g", i, rgb[1][k], rgb[0][k]);
    }
}

/* ---- what is seen -------------------------------------------------------- */

TEST(mask_and_blend)
{
    ibl_scene_material *m = &on.material[0];

    begin();
    m->unlit = true;
    m->base_colour_texture = image(0, four);
    m->alpha_mode = IBL_SCENE_MASK;
    const float *picture = draw();
    for (int i = 0; i < 3; i++)
        CHECK(is(quarter(picture, i), i));
    expect("masked", quarter(picture, 3), (const double[]){1, 1, 1}, 1e-6);

    m->alpha_mode = IBL_SCENE_BLEND;
    m->base_colour[3] = 0.25f;
    picture = draw();
    expect("blended", quarter(picture, 1),
           (const double[]){0.75, 0.75 + 0.25 / 0.5, 0.75}, 1e-6);
}

/* Three squares in the wrong order: an opaque one between two that are seen
 * through, of which the one behind cannot be seen. From behind it is the
 * other. */
TEST(order)
{
    begin();
    square(0, 1, 0.2);
    square(1, 1, -0.2);
    square(2, 1, 0);
    for (int i = 0; i < 3; i++) {
        on.material[i].unlit = on.material[i].double_sided = true;
        on.material[i].alpha_mode = i < 2 ? IBL_SCENE_BLEND : IBL_SCENE_OPAQUE;
        for (int k = 0; k < 4; k++)
            on.material[i].base_colour[k] = k == i;
        on.material[i].base_colour[3] = i < 2 ? 0.5f : 1;
    }
    for (int behind = 0; behind < 2; behind++) {
        on.settings.yaw = 180 * behind;
        const float *rgb = draw() + 3 * MIDDLE;
        CHECK_NEAR(rgb[behind], 0.5, 1e-6);
        CHECK_NEAR(rgb[!behind], 0, 1e-6);
        CHECK_NEAR(rgb[2], 0.5, 1e-6);
    }
}

/* What is seen through is drawn from back to front. */
TEST(blended_in_order)
{
    begin();
    square(0, 1, 0.2);
    square(1, 1, -0.2);
    for (int i = 0; i < 2; i++) {
        on.material[i].unlit = on.material[i].double_sided = true;
        on.material[i].alpha_mode = IBL_SCENE_BLEND;
        on.material[i].base_colour[0] = (float)i;
        on.material[i].base_colour[3] = 0.5f;
    }
    for (int behind = 0; behind < 2; behind++) {
        on.settings.yaw = 180 * behind;
        const double red = draw()[3 * MIDDLE];
        CHECK_NEAR(red, behind ? 0.5 + 0.25 * 2 : 0.25 + 0.25 * 2, 1e-6);
    }
}

/* One side only, unless the file says otherwise. */
TEST(sides)
{
    begin();
    on.material[0].unlit = true;
    memset(on.material[0].base_colour, 0, 3 * sizeof(float));
    for (int i = 0; i < 4; i++) {
        const bool behind = i & 1, both = i & 2;
        on.settings.yaw = behind ? 180 : 0;
        on.material[0].double_sided = both;
        const bool seen = draw()[3 * MIDDLE] == 0;
        CHECK(seen == (!behind || both));
    }
}

/* ---- a sphere ------------------------------------------------------------ */

enum {
    ROWS = 96,
    COLUMNS = 192
};

/* A mesh of the unit sphere with each axis scaled by squeeze. */
static void sphere(const double squeeze[3])
{
    const int vertices = (ROWS + 1) * (COLUMNS + 1);
    float *position = test_alloc((size_t)vertices * 3, sizeof *position);
    float *normal = test_alloc((size_t)vertices * 3, sizeof *normal);
    uint32_t *index = test_alloc(ROWS * COLUMNS * 6, sizeof *index);
    const double pi = acos(-1.0);

    for (int i = 0; i < vertices; i++) {
        const double t = pi * (i / (COLUMNS + 1)) / ROWS;
        const double p = 2 * pi * (i % (COLUMNS + 1)) / COLUMNS;
        const double d[3] = {sin(t) * sin(p), cos(t), sin(t) * cos(p)};
        for (int k = 0; k < 3; k++) {
            position[3 * i + k] = (float)(d[k] * squeeze[k]);
            normal[3 * i + k] = (float)(d[k] / squeeze[k]);
        }
    }
    for (int i = 0; i < ROWS * COLUMNS; i++) {
        const uint32_t a =
            (uint32_t)(i / COLUMNS * (COLUMNS + 1) + i % COLUMNS);
        const uint32_t c = a + COLUMNS + 1;
        memcpy(index + 6 * i, (uint32_t[]){a, c, a + 1, a + 1, c, c + 1},
               6 * sizeof *index);
    }
    on.part[0] = (ibl_scene_primitive){.vertex_count = (uint32_t)vertices,
                                       .index_count = 6 * ROWS * COLUMNS,
                                       .position = position,
                                       .normal = normal,
                                       .index = index};
    on.scene.bounds[0][2] = -1;
    on.scene.bounds[1][2] = 1;
}

/* The grid's sphere of radius 0.45 from the same place. */
static float *traced(void)
{
    view_settings s = on.settings;

    s.mode = VIEW_SPHERES;
    s.rows = s.columns = 1;
    s.distance *= 0.45;
    return shade_draw(&shade_sets[0].set, &s);
}

/* The mean error of a mesh that is stretched to a sphere, by a matrix that
 * mirrors, too, against the ray-traced one. */
static double sphere_error(double stretch, view_reflection reflection)
{
    const double squeeze[3] = {1 / fabs(stretch), 1, 1};
    const view_material *gold = &view_materials[on.settings.material];
    double sum = 0, all = 0;

    sphere(squeeze);
    on.draw[0].to_world[0] = stretch;
    on.settings.reflection = reflection;
    on.settings.metallic[0] = on.material[0].metallic = 1;
    on.settings.roughness[0] = 0.25;
    on.material[0].roughness = 0.25f;
    for (int k = 0; k < 3; k++)
        on.material[0].base_colour[k] = (float)gold->metal[k];
    const float *mesh = draw(), *exact = traced();
    for (int i = 0; i < 3 * EDGE * EDGE; i++) {
        sum += fabs(mesh[i] - (double)exact[i]);
        all += exact[i];
    }
    return sum / all;
}

TEST_SLOW(sphere_as_traced)
{
    static const double stretches[] = {1, 2, -1, -0.5};

    begin();
    vary();
    on.settings.distance = 5;
    on.settings.fov = 18; /* the sphere's edge is outside */
    on.settings.yaw = 30;
    on.settings.pitch = 40;
    on.settings.turn = 77;
    for (int i = 0; i < 4; i++) {
        const double off = sphere_error(stretches[i], VIEW_SPLIT_SUM);
        CHECK_MSG(off < 2e-3, "stretched by %g: off by %g", stretches[i], off);
    }
    view_renderer_pace(shade_renderer(), 16);
    const double off = sphere_error(1, VIEW_REFERENCE);
    CHECK_MSG(off < 2e-3, "reference: off by %g", off);
}

/* The material ball is a sphere, too, but for its belt. */
TEST(ball)
{
    begin();
    on.settings.multiscatter = true;
    on.settings.material = shade_material("white");
    on.settings.metallic[1] = 1;
    float *picture = shade_draw(&shade_sets[0].set, &on.settings);
    for (int i = 0; i < EDGE * EDGE; i++)
        expect("ball", picture + 3 * i, (const double[]){1, 1, 1}, 1e-5);
}

/* Errors by material: both sides are the same under a constant light, and the
 * pixels of each material are known. */
TEST(errors_by_material)
{
    view_error errors[3];

    begin();
    square(1, 0.5, 0.1);
    on.settings.compare = VIEW_SPLIT;
    on.settings.against = VIEW_FIT;
    draw();
    NEED(view_renderer_errors(shade_renderer(), errors) == 2);
    CHECK(errors[0].pixels > errors[1].pixels && errors[1].pixels > 50);
    for (int i = 0; i < 2; i++)
        CHECK(view_error_rmse(errors[i]) < 1e-6);
}

/* Draws anew; the pixels that the model covers in part. */
static int count_partial(void)
{
    static float rgb[3 * EDGE * EDGE];
    int count = 0;

    NEED(view_renderer_draw(shade_renderer(), &on.settings, EDGE, EDGE) &&
         view_renderer_read(shade_renderer(), false, rgb));
    for (int i = 0; i < EDGE * EDGE; i++)
        count += rgb[3 * i] > 0.01f * sky[0] && rgb[3 * i] < 0.99f * sky[0];
    return count;
}

static PFNGLDRAWELEMENTSPROC draw_elements;

static void APIENTRY draw_late(GLenum kind, GLsizei count, GLenum type,
                               const void *indices)
{
    nanosleep(&(struct timespec){.tv_nsec = 150000000}, NULL);
    draw_elements(kind, count, type, indices);
}

/* After a slow picture the next has one sample of a pixel, for it moves. At
 * rest it has all. */
TEST(samples_of_what_moves)
{
    begin();
    on.settings.multiscatter = true;
    on.settings.sky = false;
    on.settings.fov = 60;
    on.settings.multisample = 4;
    draw_elements = gl.DrawElements;
    gl.DrawElements = draw_late;
    draw();
    gl.DrawElements = draw_elements;
    on.settings.pitch += 20;
    const int moving = count_partial();
    CHECK(!view_renderer_complete(shade_renderer()));
    const int at_rest = count_partial();
    CHECK_MSG(moving == 0 && at_rest > 10, "%d, %d", moving, at_rest);
    CHECK(view_renderer_complete(shade_renderer()));
}
