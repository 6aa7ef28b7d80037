/* SPDX-License-Identifier: MIT */
/*
 * Models: squares that face the camera under a constant light, whose every
 * layer has a closed form; a ball against a sphere of the grid, which is
 * ray-traced; and what is in front of what.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "ibl/reference.h"
#include "maps.h"
#include "shade.h"
#include "view.h"
#include "view/model.h"

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

static view_renderer *renderer;

/* Of the running test: up to three squares, or a sphere. */
static struct {
    ibl_scene scene;
    ibl_scene_primitive part[3];
    ibl_scene_material material[3];
    ibl_scene_draw draw[3];
    ibl_scene_image image[3];
    unsigned char texels[3][16];
    view_settings settings;
} on;

static void free_model(void *model)
{
    view_renderer_model(renderer, NULL);
    view_model_free(model);
}

static ibl_scene_material plain(void)
{
    ibl_scene_material m = ibl_scene_material_default();

    m.metallic = 0;
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

static ibl_scene_texture even(int i, int r, int g, int b, int a)
{
    unsigned char texels[16];

    for (int k = 0; k < 16; k++)
        texels[k] = (unsigned char)(const int[]){r, g, b, a}[k % 4];
    return image(i, texels);
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
    renderer = shade_begin(EDGE, EDGE);
    shade_constant(&shade_sets[0], sky);
    on.settings = view_settings_default();
    on.settings.mode = VIEW_MODEL;
    on.settings.multiscatter = false;
    on.settings.fov = 20;
    square(0, 1, 0);
}

static float *draw_of(view_model *m)
{
    NEED(m);
    test_defer(free_model, m);
    view_renderer_model(renderer, m);
    return shade_draw(&shade_sets[0].set, &on.settings);
}

static float *draw(void)
{
    return draw_of(view_model_create(shade_ctx(), &on.scene, "test"));
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

/* What is seen of a material along its normal, where R of its occlusion is 0.2
 * and its vertices have no half of the red. */
static void layered(const ibl_scene_material *m, double wanted[3])
{
    const double metallic = (double)m->metallic, coat = (double)m->clearcoat;
    const double ior = (double)m->ior, weight = (double)m->specular;
    const double open =
        m->occlusion_texture.image < 0 ? 1 : 1 - 0.8 * m->occlusion_strength;
    double rg[2], over[2];

    table((double)m->roughness, rg);
    table((double)m->clearcoat_roughness, over);
    for (int k = 0; k < 3; k++) {
        const double base =
            m->base_colour[k] * (on.part[0].colour && !k ? 0.5 : 1);
        const double own =
            pow((ior - 1) / (ior + 1), 2) * m->specular_colour[k];
        const double once = (metallic + (1 - metallic) * weight) *
                            ((own + metallic * (base - own)) * rg[0] + rg[1]);
        wanted[k] = once + base * (1 - metallic) * (1 - once);
        wanted[k] = wanted[k] * open + m->emissive[k] / (double)sky[k];
        wanted[k] = wanted[k] * (1 - 0.04 * coat) +
                    coat * open * (0.04 * over[0] + over[1]);
    }
}

/* The same by textures, each in its channels, which are as factors. */
static void move_to_textures(ibl_scene_material *m)
{
    const float linear = powf((128 / 255.0F + 0.055F) / 1.055F, 2.4F);

    m->base_colour_texture = m->emissive_texture = m->specular_colour_texture =
        even(1, 128, 128, 128, 255);
    m->metallic_roughness_texture = m->specular_texture = m->clearcoat_texture =
        m->clearcoat_roughness_texture = even(2, 200, 128, 64, 100);
    for (int k = 0; k < 3; k++) {
        m->base_colour[k] /= linear;
        m->emissive[k] /= linear;
        m->specular_colour[k] /= linear;
    }
    m->metallic *= 255 / 64.0F;
    m->roughness *= 255 / 128.0F;
    m->specular *= 255 / 100.0F;
    m->clearcoat *= 255 / 200.0F;
    m->clearcoat_roughness *= 255 / 128.0F;
}

/* Metallic, roughness, IOR, KHR_materials_specular and a coat, by lookups, of
 * textures too, and by the integral as far as its samples go; or unlit. Sheen
 * is not drawn. */
TEST(layers)
{
    static const struct {
        float metallic, roughness, ior, specular, tint, coat;
    } cases[] = {{0, 1, 1.5f, 1, 1, 0},       {1, 0.3f, 1.5f, 1, 1, 0},
                 {0.5f, 0.6f, 1.5f, 1, 1, 0}, {0, 0.5f, 2, 0.5f, 0.5f, 0},
                 {1, 0.7f, 1.5f, 1, 1, 0.5f}, {0, 0.5f, 1.5f, 1, 1, 0.5f}};
    static float tint[16] = {.5f, 1, 1, 1, .5f, 1, 1, 1,
                             .5f, 1, 1, 1, .5f, 1, 1, 1};
    ibl_scene_material *m = &on.material[0];
    double wanted[3];

    begin();
    view_renderer_pace(renderer, 256);
    on.part[0].colour = tint;
    memcpy(m->base_colour, (const float[]){0.8f, 0.4f, 0.1f}, 12);
    m->emissive[2] = 0.5f;
    m->occlusion_texture = even(0, 51, 0, 0, 0);
    m->occlusion_strength = 0.5f;
    m->clearcoat_roughness = 0.2f;
    m->sheen_roughness = m->sheen_colour[0] = 0.5f;
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        m->metallic = cases[i].metallic;
        m->roughness = cases[i].roughness;
        m->ior = cases[i].ior;
        m->specular = cases[i].specular;
        m->specular_colour[1] = cases[i].tint;
        m->clearcoat = cases[i].coat;
        layered(m, wanted);
        for (int exact = 0; exact < 2; exact++) {
            on.settings.reflection = exact ? VIEW_REFERENCE : VIEW_SPLIT_SUM;
            expect("layers", draw() + 3 * MIDDLE, wanted, exact ? 1e-2 : 1e-4);
        }
        const ibl_scene_material kept = *m;
        on.settings.reflection = VIEW_SPLIT_SUM;
        move_to_textures(m);
        expect("textures", draw() + 3 * MIDDLE, wanted, 1e-2);
        *m = kept;
    }
    m->unlit = true;
    for (int k = 0; k < 3; k++)
        wanted[k] = m->base_colour[k] * (k ? 1 : 0.5) / (double)sky[k];
    expect("unlit", draw() + 3 * MIDDLE, wanted, 1e-5);
}

/* Whatever the file says: clay, chrome and a material of the table. */
TEST(override)
{
    static const struct {
        view_override by;
        float base[3], roughness, metallic;
    } cases[] = {{VIEW_CLAY, {0.5f, 0.5f, 0.5f}, 0.6f, 0},
                 {VIEW_CHROME, {0.55f, 0.556f, 0.554f}, 0.05f, 1},
                 {VIEW_MATERIAL, {1, 0.782f, 0.344f}, 0.3f, 1}};
    ibl_scene_material *m = &on.material[0];

    begin();
    m->base_colour_texture = even(0, 0, 255, 0, 255);
    m->clearcoat = m->emissive[0] = 1;
    on.settings.roughness[0] = 0.2;
    on.settings.roughness[1] = 0.4;
    for (int i = 0; i < 6; i++) {
        ibl_scene_material is = plain();
        double wanted[3];
        m->unlit = i >= 3;
        on.settings.override = cases[i % 3].by;
        memcpy(is.base_colour, cases[i % 3].base, sizeof cases[0].base);
        is.roughness = cases[i % 3].roughness;
        is.metallic = cases[i % 3].metallic;
        layered(&is, wanted);
        expect("override", draw() + 3 * MIDDLE, wanted, 1e-4);
    }
}

/* ---- textures ------------------------------------------------------------ */

static const unsigned char four[16] = {255, 0, 0,   255, 0,   255, 0, 255,
                                       0,   0, 255, 255, 255, 255, 0, 0};

/* Which texel the middle of each quarter of the square shows, row by row from
 * the upper left: KHR_texture_transform turned by 90 degrees, u' = v and v' =
 * -u, and moved by half of it, which is a texel; the second coordinates; masks;
 * both sides, or one, of squares that are mirrored. */
TEST(quarters)
{
    enum {
        SKY = -1
    };
    static const struct {
        const char *what;
        int texel[4];
        double rotation, offset;
        bool second, mask, behind, both, mirrored;
    } cases[] = {
        {.what = "plain", .texel = {0, 1, 2, 3}},
        {"turned", {2, 0, 3, 1}, .rotation = M_PI / 2},
        {"moved", {1, 0, 3, 2}, .offset = 0.5},
        {"second coordinates", {1, 0, 3, 2}, .offset = 0.5, .second = true},
        {"mask", {0, 1, 2, SKY}, .mask = true},
        {"back", {SKY, SKY, SKY, SKY}, .behind = true},
        {"both sides", {1, 0, 3, 2}, .behind = true, .both = true},
        {"mirrored", {1, 0, 3, 2}, .mirrored = true},
        {"its back", {SKY, SKY, SKY, SKY}, .behind = true, .mirrored = true},
        {"its sides",
         {0, 1, 2, 3},
         .behind = true,
         .both = true,
         .mirrored = true}};
    ibl_scene_material *m = &on.material[0];

    begin();
    m->unlit = true;
    m->base_colour_texture = image(0, four);
    on.part[0].texcoord[1] = on.part[0].texcoord[0];
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        m->base_colour_texture.rotation = cases[i].rotation;
        m->base_colour_texture.offset[0] = cases[i].offset;
        m->base_colour_texture.texcoord = cases[i].second;
        m->alpha_mode = cases[i].mask ? IBL_SCENE_MASK : IBL_SCENE_OPAQUE;
        m->double_sided = cases[i].both;
        on.settings.yaw = cases[i].behind ? 180 : 0;
        on.draw[0].to_world[0] = cases[i].mirrored ? -1 : 1;
        const float *picture = draw();
        for (int k = 0; k < 12; k++) {
            const int at = (EDGE / 2 + (k / 6 ? 10 : -10)) * EDGE + EDGE / 2 +
                           (k / 3 % 2 ? 10 : -10);
            const int texel = cases[i].texel[k / 3];
            const double wanted = texel == SKY
                                      ? (double)sky[k % 3]
                                      : four[4 * texel + k % 3] / 255.0;
            CHECK_MSG(fabs((double)picture[3 * at + k % 3] - wanted) < 1e-3,
                      "%s: quarter %d", cases[i].what, k / 3);
        }
    }
}

/* A tilt by a normal map is one of the vertices' normals: on the front and the
 * back, mirrored and stretched, with tangents of the file and without; of a
 * coat over nothing, too. */
TEST_SLOW(normal_maps)
{
    static float tangent[16] = {1, 0, 0, 1, 1, 0, 0, 1, 1, 0, 0, 1, 1, 0, 0, 1};
    const double n[3] = {0.28, 0.48, sqrt(1 - 0.28 * 0.28 - 0.48 * 0.48)};
    ibl_scene_texture map;

    begin();
    shade_kind(&shade_sets[0], IBL_ROUGHNESS_LINEAR, MAP_SMOOTH);
    map =
        even(0, (int)lrint(127.5 * (n[0] + 1)), (int)lrint(127.5 * (n[1] + 1)),
             (int)lrint(127.5 * (n[2] + 1)), 255);
    for (int i = 0; i < 10; i++) {
        const bool coat = i >= 8, behind = i & 2, tangents = i & 4;
        const double stretch = !(i & 1) ? 1 : tangents ? -1.25 : -1;
        float rgb[2][3];
        on.settings.yaw = behind ? 180 : 0;
        for (int by_map = 0; by_map < 2; by_map++) {
            ibl_scene_material *m = &on.material[0];
            square(0, 1, 0);
            m->double_sided = true;
            m->metallic = m->specular = !coat;
            m->clearcoat = coat;
            m->roughness = 0;
            memset(m->base_colour, 0, (coat ? 3 : 0) * sizeof(float));
            if (by_map)
                *(coat ? &m->clearcoat_normal_texture : &m->normal_texture) =
                    map;
            for (int v = 0; v < 12 && !by_map; v++)
                on.part[0].normal[v] =
                    (float)(n[v % 3] * (v % 3 ? 1 : fabs(stretch)));
            on.part[0].tangent = tangents ? tangent : NULL;
            on.draw[0].to_world[0] = stretch;
            memcpy(rgb[by_map], draw() + 3 * MIDDLE, sizeof rgb[0]);
        }
        for (int k = 0; k < 3; k++)
            CHECK_MSG(fabs(rgb[0][k] - rgb[1][k]) < 0.03 * rgb[0][k],
                      "case %d: %g, not %g", i, rgb[1][k], rgb[0][k]);
    }
}

/* ---- what is seen -------------------------------------------------------- */

/* Three squares in the wrong order: an opaque one between two that are seen
 * through, of which the one behind cannot be seen, and these two alone, the
 * farther one first. From behind it is the other. */
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
    for (int i = 0; i < 4; i++) {
        const int near = i % 2;
        const double through = i < 2 ? 0 : 0.25;
        on.settings.yaw = 180 * near;
        on.scene.draw_count = i < 2 ? 3 : 2;
        const float *rgb = draw() + 3 * MIDDLE;
        CHECK_NEAR(rgb[near], 0.5 + through * (double)sky[near], 1e-6);
        CHECK_NEAR(rgb[!near], through + through * (double)sky[!near], 1e-6);
        CHECK_NEAR(rgb[2], i < 2 ? 0.5 : through * (double)sky[2], 1e-6);
    }
}

/* ---- on the ground, by a file's camera ----------------------------------- */

/* The ball stands on the ground, which is half as bright as a white light. In
 * the dark rays to a light tell what is lit by it; under an even sky the form
 * factor of a ball, 1 / d^3, tells what is left of that. */
TEST(ground)
{
    const double to[3] = {0.48, 0.8, 0.36};
    shade_set *set = &shade_sets[0];
    int dark = 0, lit = 0;

    begin();
    on.settings.ground = true;
    on.settings.pitch = 50;
    on.settings.distance = 6;
    on.settings.fov = 40;
    on.settings.turn = 60;
    const view_camera c = view_camera_of(&on.settings, EDGE, EDGE);
    for (int sun = 0; sun < 2; sun++) {
        shade_constant(set, (const float[]){!sun, !sun, !sun});
        set->set.baked.light_count = sun;
        set->set.baked.light[0] =
            (ibl_light){.radius = 0.01, .irradiance = {M_PI, M_PI, M_PI}};
        view_turn(on.settings.turn, to, set->set.baked.light[0].direction);
        const float *rgb = draw_of(shade_ball(1));
        for (int i = 0; i < EDGE * EDGE; i++) {
            double d[3], p[3], off[3], near[3];
            view_test_ray(&c, EDGE, EDGE, i % EDGE, i / EDGE, d);
            for (int k = 0; k < 3; k++) {
                p[k] = c.eye[k] + (-1 - c.eye[1]) / d[1] * d[k];
                near[k] = c.eye[k] - test_dot(c.eye, d) * d[k];
            }
            for (int k = 0; k < 3; k++)
                off[k] = p[k] - test_dot(p, to) * to[k];
            const double away = hypot(p[0], p[2]), is = rgb[3 * i] / 0.5;
            const double gap = sqrt(test_dot(off, off));
            if (d[1] >= 0 || test_dot(near, near) < 1.1 || away > 1.2)
                continue; /* the ball, or where the ground fades */
            if (!sun)
                CHECK_NEAR(is, 1 - pow(1 + away * away, -1.5), 0.17);
            else if (gap < 0.94 || gap > 1.06)
                CHECK_NEAR(is, gap < 1 ? 0 : to[1], 2e-3);
            dark += sun && gap < 0.94;
            lit += sun && gap > 1.06;
        }
    }
    CHECK_MSG(lit > 50 && dark > 20, "%d, %d", lit, dark);
}

/* A camera of the file is where the model is, in the picture's or its shape. */
TEST(file_camera)
{
    ibl_scene_camera camera = {.yfov = 0.5};

    begin();
    on.material[0].unlit = true;
    on.material[0].base_colour_texture = image(0, four);
    on.scene.cameras = &camera;
    on.scene.camera_count = 1;
    memcpy(camera.to_world, identity, sizeof identity);
    camera.to_world[14] = 4;
    for (int wide = 0; wide < 2; wide++) {
        camera.aspect = 2 * wide;
        on.settings.file_camera = 1;
        on.settings.distance = 9;
        const float *by_file = draw();
        on.settings.file_camera = 2 * wide; /* none */
        on.settings.distance = 4 / sqrt(2); /* as the farthest corner is at 1 */
        on.settings.fov = 2 * atan((1 + wide) * tan(0.25)) * 180 / M_PI;
        CHECK(!memcmp(by_file, draw(), 3 * sizeof(float) * EDGE * EDGE));
    }
}

/* ---- the ball, and several materials -------------------------------------
 */

/* A ball is a sphere of the grid, from as many radii away. */
TEST(ball)
{
    begin();
    shade_kind(&shade_sets[0], IBL_ROUGHNESS_LINEAR, MAP_SMOOTH);
    on.settings.distance = 5;
    on.settings.fov = 16; /* its edge is outside */
    on.settings.pitch = 50;
    on.settings.override = VIEW_MATERIAL;
    on.settings.turn = 77;
    on.settings.metallic[0] = on.settings.metallic[1] = 1;
    on.settings.roughness[0] = on.settings.roughness[1] = 0.25;
    view_renderer_pace(renderer, 16);
    for (int exact = 0; exact < 2; exact++) {
        view_settings s;
        double sum = 0, all = 0;
        on.settings.reflection = exact ? VIEW_REFERENCE : VIEW_SPLIT_SUM;
        s = on.settings;
        s.mode = VIEW_SPHERES;
        s.rows = s.columns = 1;
        s.distance *= 0.45;
        const float *mesh = draw_of(shade_ball(1));
        const float *traced = shade_draw(&shade_sets[0].set, &s);
        for (int i = 0; i < 3 * EDGE * EDGE; i++) {
            sum += fabs(mesh[i] - (double)traced[i]);
            all += traced[i];
        }
        CHECK_MSG(sum < 8e-3 * all, "off by %g", sum / all);
    }
}

/* Both sides are the same under a constant light, and the pixels of each
 * material are known. */
TEST(errors_by_material)
{
    view_settings side[2];
    int count;

    begin();
    square(1, 0.5, 0.1);
    draw();
    on.settings.compare = VIEW_SPLIT;
    side[0] = side[1] = on.settings;
    side[1].reflection = VIEW_FIT;
    NEED(shade_frame(side));
    view_error *errors = view_renderer_errors(renderer, &count);
    NEED(errors && count == 2);
    test_defer(free, errors);
    CHECK(errors[0].pixels > errors[1].pixels && errors[1].pixels > 50);
    CHECK(errors[2].pixels == errors[0].pixels + errors[1].pixels);
    CHECK(view_error_rmse(errors[0]) < 1e-6);
}
