/* SPDX-License-Identifier: MIT */
/*
 * Models: small files made by hand, whose triangles, materials and surveys are
 * known, files that are damaged or lie, and the collections of other people
 * where they are installed.
 */
#include "scene/survey.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "engine/png.h"
#include "files.h"
#include "scene/gltf_reader.h"
#include "test.h"

static ibl_ctx *quiet; /* keeps its messages in kept */
static test_messages kept;
static bool strict; /* how scenes are read */

void test_setup(void)
{
    quiet = test_keeping_ctx(2, &kept);
}

static void free_scene(void *scene)
{
    ibl_scene_free(scene);
}

/* A scene that is freed after the test, and the status of reading it. */
static ibl_scene *read_scene(const char *path, ibl_status *status)
{
    ibl_scene *s = test_alloc(1, sizeof *s);

    kept = (test_messages){0};
    *status = ibl_scene_read(quiet, path, strict, s);
    test_defer(free_scene, s);
    return s;
}

/* Saves JSON, whose quotes are ' here. */
static const char *save(const char *name, const char *text)
{
    const char *path = file_path(name);
    char *json = test_alloc(strlen(text) + 1, 1);

    for (size_t i = 0; text[i]; i++)
        json[i] = text[i] == '\'' ? '"' : text[i];
    NEED(file_save(path, json, strlen(json)));
    return path;
}

static ibl_scene *read_text(const char *text)
{
    ibl_status status;
    ibl_scene *s = read_scene(save("x.gltf", text), &status);

    CHECK_MSG(!status, "%s: %s", text, kept.text[IBL_LOG_ERROR]);
    NEED(!status);
    return s;
}

/* The bytes of mesh.bin: a square of 4 vertices in z = 2, from -1 to 1 in x and
 * y, as floats; then its texture coordinates as unsigned bytes, 0 to 255, and
 * the indices 0 1 2 3 as bytes and as words. */
enum {
    PLACES = 48,
    COORDINATES = 8,
    SHORT = 4,
    LONG = 16
};

static void save_mesh(void)
{
    static const float places[12] = {-1, -1, 2, 1, -1, 2, -1, 1, 2, 1, 1, 2};
    static const unsigned char rest[COORDINATES + SHORT] = {
        0, 255, 255, 255, 0, 0, 255, 0, 0, 1, 2, 3};
    static const uint32_t indices[4] = {0, 1, 2, 3};
    unsigned char all[PLACES + COORDINATES + SHORT + LONG];

    memcpy(all, places, PLACES);
    memcpy(all + PLACES, rest, sizeof rest);
    memcpy(all + PLACES + sizeof rest, indices, LONG);
    NEED(file_save(file_path("mesh.bin"), all, sizeof all));
}

#define BUFFER                                                                 \
    "'asset':{'version':'2.0'},'buffers':[{'uri':'mesh.bin',"                  \
    "'byteLength':76}],'bufferViews':[{'buffer':0,'byteLength':48},{'buffer':" \
    "0,'byteOffset':48,"                                                       \
    "'byteLength':8},{'buffer':0,'byteOffset':56,'byteLength':4},{'buffer':0," \
    "'byteOffset':60,'byteLength':16}]"
#define ACCESSORS                                                              \
    "'accessors':[{'bufferView':0,'componentType':5126,'count':4,"             \
    "'type':'VEC3'},{'bufferView':1,'componentType':5121,'count':4,"           \
    "'type':'VEC2','normalized':true},{'bufferView':2,'componentType':5121,"   \
    "'count':4,'type':'SCALAR'},{'bufferView':3,'componentType':5125,"         \
    "'count':4,'type':'SCALAR'}]"
#define ATTRIBUTES "'attributes':{'POSITION':0,'TEXCOORD_0':1}"
#define STRIP "{'mode':5," ATTRIBUTES ",'indices':2"
#define SCENE "'scenes':[{'nodes':[0]}],'nodes':[{'mesh':0,'scale':[2,1,1]}]"
/* The whole file, but for what follows the strip. */
#define STRIPS                                                                 \
    "{" BUFFER "," ACCESSORS "," SCENE ",'meshes':[{'primitives':[" STRIP

/* The square as a strip, with these members of the root besides. */
static ibl_scene *read_square(const char *more)
{
    save_mesh();
    return read_text(test_text(STRIPS ",'material':0}]}],%s}", more));
}

TEST(square)
{
    const ibl_scene *s = read_square("'materials':[{}]");
    const ibl_scene_primitive *p = s->primitives;

    CHECK(s->primitive_count == 1 && s->draw_count == 1);
    CHECK(s->material_count == 2 && p->material == 0 && s->file_count == 2);
    /* Without normals each corner is a vertex: both triangles face +z. */
    CHECK(p->index_count == 6 && p->vertex_count == 6);
    for (int i = 0; i < 18; i++)
        CHECK_NEAR(p->normal[i], i % 3 == 2, 0);
    CHECK_NEAR(s->bounds[0][0], -2, 1e-6);
    CHECK_NEAR(s->bounds[1][1], 1, 1e-6);
    CHECK_NEAR(s->bounds[0][2], 2, 1e-6);
    /* Texture coordinates follow the positions: u = (x + 1) / 2, v = (1 - y)
     * / 2. */
    for (int i = 0; i < 6; i++) {
        CHECK_NEAR(p->texcoord[0][2 * i], (p->position[3 * i] + 1) / 2, 1e-6);
        CHECK_NEAR(p->texcoord[0][2 * i + 1], (1 - p->position[3 * i + 1]) / 2,
                   1e-6);
    }
}

/* A matrix by columns on a point, or with w = 0 a direction. */
static void apply(const double m[16], double w, double v[3])
{
    const double from[3] = {v[0], v[1], v[2]};

    for (int k = 0; k < 3; k++)
        v[k] = m[k] * from[0] + m[4 + k] * from[1] + m[8 + k] * from[2] +
               w * m[12 + k];
}

static void cross(const double a[3], const double b[3], double to[3])
{
    for (int k = 0; k < 3; k++)
        to[k] =
            a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
}

/* What is drawn in the world. area: the sum of the triangles' normals, as long
 * as their areas. corner: the first of the last draw, which packed files may
 * have anywhere (NAN). */
typedef struct drawing {
    int draws, triangles;
    double low[3], high[3], area[3], corner[3];
} drawing;

static void check_drawn(const ibl_scene *s, const drawing *want,
                        double tolerance)
{
    double low[3] = {1e30, 1e30, 1e30}, high[3] = {-1e30, -1e30, -1e30};
    double area[3] = {0}, corner[3] = {0};
    int triangles = 0;

    NEED(s->draw_count == want->draws);
    for (int i = 0; i < s->draw_count; i++) {
        const ibl_scene_primitive *p = &s->primitives[s->draws[i].primitive];
        triangles += (int)p->index_count / 3;
        for (uint32_t t = 0; t < p->index_count; t += 3) {
            double at[3][3], n[3];
            for (int c = 0; c < 3; c++) {
                for (int k = 0; k < 3; k++)
                    at[c][k] = p->position[3 * p->index[t + c] + k];
                apply(s->draws[i].to_world, 1, at[c]);
                for (int k = 0; k < 3; k++) {
                    low[k] = fmin(low[k], at[c][k]);
                    high[k] = fmax(high[k], at[c][k]);
                    at[c][k] -= c ? at[0][k] : 0;
                }
            }
            cross(at[1], at[2], n);
            for (int k = 0; k < 3; k++) {
                area[k] += n[k] / 2;
                corner[k] = t ? corner[k] : at[0][k];
            }
        }
    }
    CHECK_MSG(triangles == want->triangles, "%d triangles", triangles);
    for (int k = 0; k < 3; k++) {
        CHECK_NEAR(low[k], want->low[k], tolerance);
        CHECK_NEAR(high[k], want->high[k], tolerance);
        CHECK_NEAR(s->bounds[0][k], low[k], tolerance);
        CHECK_NEAR(s->bounds[1][k], high[k], tolerance);
        CHECK_NEAR(area[k], want->area[k], 10 * tolerance);
        CHECK(isnan(want->corner[k]) ||
              fabs(corner[k] - want->corner[k]) <= tolerance);
    }
}

static const drawing a_square = {1,         2,         {-2, -1, 2},
                                 {2, 1, 2}, {0, 0, 8}, {NAN, NAN, NAN}};

#define FILE_OF(nodes, more)                                                   \
    "{" BUFFER "," ACCESSORS ",'scenes':[{'nodes':[0]}],'nodes':[" nodes       \
    "],'meshes':[{'primitives':[" STRIP "}]}]" more "}"
#define PLACES_OF(uri, size, accessor, primitives)                             \
    "{'asset':{'version':'2.0'},'buffers':[{'uri':'mesh.bin','byteLength':76}" \
    ",{'uri':'" uri "','byteLength':" size "}],'bufferViews':[{'buffer':0,"    \
    "'byteLength':48},{'buffer':1,'byteLength':" size                          \
    "}],'accessors':[{" accessor                                               \
    "'componentType':5126,'count':4,'type':'VEC3'}]," SCENE                    \
    ",'meshes':[" primitives "]}"
#define ONE_STRIP "{'primitives':[{'mode':5,'attributes':{'POSITION':0}}]}"
#define SPARSE                                                                 \
    "'sparse':{'count':1,'indices':{'bufferView':1,'byteOffset':12,"           \
    "'componentType':5123},'values':{'bufferView':1}},"

TEST(small_files)
{
    static const struct {
        const char *name, *text, *warning;
        drawing drawn;
    } cases[] = {
        {"a fan, lines, which are left out, and a triangle",
         "{" BUFFER "," ACCESSORS "," SCENE
         ",'meshes':[{'primitives':[{'mode':6,'attributes':{'POSITION':0"
         "},'indices':3},{'mode':1,'attributes':{'POSITION':0}},{"
         "'attributes':{'POSITION':0,'NORMAL':0}}]}]}",
         "1 primitives are points, lines",
         {2, 3, {-2, -1, 2}, {2, 1, 2}, {0, 0, 4}, {-2, -1, 2}}},
        {"a turn by 90 degrees about z below a move: x becomes y",
         "{" BUFFER "," ACCESSORS ",'meshes':[{'primitives':[" STRIP
         "}]}],'scene':1,'scenes':[{},{'nodes':[1]}],'nodes':[{'mesh':0,"
         "'rotation':[0,0,0.70710678118,0.70710678118]},{'children':[0],"
         "'translation':[10,20,30]}]}",
         "",
         {1, 2, {9, 19, 32}, {11, 21, 32}, {0, 0, 4}, {11, 19, 32}}},
        {"a matrix",
         FILE_OF("{'mesh':0,'matrix':[0,2,0,0,-3,0,0,0,0,0,4,0,5,6,7,1]}", ""),
         "",
         {1, 2, {2, 4, 15}, {8, 8, 15}, {0, 0, 24}, {8, 4, 15}}},
        {"a turn about no axis",
         FILE_OF("{'mesh':0,'rotation':[0.1,0.5,-0.7,0.5]}", ""),
         "",
         {1,
          2,
          {-0.56, -2.2, -0.28},
          {2, -1, 2.2},
          {1.44, -3.2, 1.92},
          {0.4, -1, 2.2}}},
        {"far from the origin",
         FILE_OF("{'children':[1,2],'translation':[4131346.164399078,0,0]},{"
                 "'mesh':0,'translation':[0.3,0,0]},{'mesh':0,'translation':[0"
                 ".7,4659713.478714659,0]}",
                 ""),
         "",
         {2,
          4,
          {4131345.464399078, -1, 2},
          {4131347.864399078, 4659714.478714659, 2},
          {0, 0, 8},
          {4131345.864399078, 4659712.478714659, 2}}},
        {"instances: the second turned by 90 degrees, moved and larger",
         "{'asset':{'version':'2.0'},'buffers':[{'uri':'mesh.bin','byteLength':"
         "76},{'uri':'i.bin','byteLength':80}],'bufferViews':[{'buffer':0,"
         "'byteLength':48},{'buffer':1,'byteStride':40,'byteLength':80}],"
         "'accessors':[{'bufferView':0,'componentType':5126,'count':4,'type':"
         "'VEC3'},{'bufferView':1,'componentType':5126,'count':2,'type':"
         "'VEC3'},{'bufferView':1,'componentType':5126,'count':2,'type':"
         "'VEC4','byteOffset':12},{'bufferView':1,'componentType':5126,"
         "'count':2,'type':'VEC3','byteOffset':28}],'scenes':[{'nodes':[0]}],"
         "'nodes':[{'mesh':0,'translation':[100,0,0],'extensions':{"
         "'EXT_mesh_gpu_instancing':{'attributes':{'TRANSLATION':1,'ROTATION':"
         "2,'SCALE':3}}}}],'meshes':[" ONE_STRIP "]}",
         "",
         {2, 4, {99, -1, 2}, {108, 8, 15}, {0, 0, 28}, {108, 4, 15}}},
        {"nodes that are hidden, with what is below them",
         FILE_OF("{'mesh':0,'children':[1,3]},{'children':[2],'extensions':{"
                 "'KHR_node_visibility':{'visible':false}}},{'mesh':0},{'mesh'"
                 ":0,'extensions':{'KHR_node_visibility':{'visible':true}}}",
                 ""),
         "",
         {2, 4, {-1, -1, 2}, {1, 1, 2}, {0, 0, 8}, {-1, -1, 2}}},
        {"one vertex of z = 7 in place of 2",
         PLACES_OF("s.bin", "16", "'bufferView':0," SPARSE, ONE_STRIP),
         "",
         {1, 2, {-2, -1, 2}, {2, 1, 7}, {-5, 10, 8}, {-2, -1, 2}}},
        {"the same among zeros",
         PLACES_OF("s.bin", "16", SPARSE, ONE_STRIP),
         "",
         {1, 2, {0, -1, 0}, {2, 0, 7}, {0, 0, 0}, {0, 0, 0}}},
        {"a vertex that is nowhere, an empty primitive and mesh",
         PLACES_OF("n.bin", "48",
                   "'componentType':5123,'count':0,'type':'SCALAR'},{"
                   "'bufferView':1,",
                   "{'primitives':[{'attributes':{'POSITION':1},'indices':0},{"
                   "'mode':5,'attributes':{'POSITION':1}}]},{'primitives':[]}"),
         "1 values are no numbers",
         {1, 1, {-2, -1, 2}, {2, 1, 2}, {0, 0, 4}, {NAN, NAN, NAN}}},
    };
    static const float instances[2][10] = {
        {0, 0, 0, 0, 0, 0, 1, 1, 1, 1},
        {5, 6, 7, 0, 0, 0.70710678f, 0.70710678f, 2, 3, 4}};
    static const float nowhere[12] = {NAN, -1, 2, 1, -1, 2, -1, 1, 2, 1, 1, 2};
    static const struct {
        float place[3];
        uint16_t index, pad;
    } sparse = {{1, -1, 7}, 1, 0};

    save_mesh();
    NEED(file_save(file_path("i.bin"), instances, sizeof instances) &&
         file_save(file_path("n.bin"), nowhere, sizeof nowhere) &&
         file_save(file_path("s.bin"), &sparse, sizeof sparse));
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        const ibl_scene *s = read_text(cases[i].text);
        CHECK_MSG(strstr(kept.text[IBL_LOG_WARNING], cases[i].warning), "%s",
                  cases[i].name);
        if (s->draw_count != cases[i].drawn.draws)
            test_fail(__FILE__, __LINE__, "%s", cases[i].name);
        check_drawn(s, &cases[i].drawn, 1e-5);
    }
}

/* As browsers read them: three floats 1, 2, 3 in the first corner, with a mark
 * of UTF-8 and whole numbers in any form. */
TEST(names_and_data)
{
    static const char *const uris[] = {
        "three.bin",
        "./a/../three.bin",
        "three%2ebin",
        ".\\\\three.bin",
        "three.bin?v=1#x",
        "100%_%zz.bin",
        "data:application/octet-stream;base64,AACAPwAAAEAAAEBA",
        "data:;base64,AACAPwAAAEAAAEBA==",
        "data:;BASE64 ,AACA%50wAAAEAAAEBA",
        "DATA:;base64, AACAPwAA%0A AEAAAEBA",
        "data:,%00%00%80%3f%00%00%00@%00%00@@"};
    static const float three[3] = {1, 2, 3};

    NEED(file_run("mkdir -p a") &&
         file_save(file_path("three.bin"), three, sizeof three) &&
         file_run("cp three.bin '100%%_%%zz.bin'"));
    for (size_t i = 0; i < sizeof uris / sizeof *uris; i++)
        check_drawn(
            read_text(test_text(
                "\xef\xbb\xbf{'asset':{'version':'2.0'},'buffers':[{'uri':'%s',"
                "'byteLength':12.0}],'bufferViews':[{'buffer':0.0,'byteLength':"
                "1.2e1}],'accessors':[{'componentType':5126.0,'count':3,"
                "'type':'VEC3','sparse':{'count':1,'indices':{'bufferView':0,"
                "'componentType':5121},'values':{'bufferView':0}}}],'scenes':[{"
                "'nodes':[0]}],'nodes':[{'mesh':0}],'meshes':[{'primitives':[{"
                "'mode':4.0,'attributes':{'POSITION':0}}]}]}",
                uris[i])),
            &(drawing){1, 1, {0}, {1, 2, 3}, {0}, {1, 2, 3}}, 0);
}

/* By a node's camera, where it stands; what is wrong is left out. */
TEST(cameras)
{
    save_mesh();
    const ibl_scene *s = read_text(
        "{" BUFFER "," ACCESSORS ",'meshes':[{'primitives':[" STRIP "}]}],"
        "'scenes':[{'nodes':[0,1,3]}],'nodes':[{'mesh':0},{'name':'eye',"
        "'camera':0,'children':[2],'translation':[1,2,3]},{'camera':1,"
        "'scale':[-1,1,1],'name':'n'},{'camera':2,'children':[4]},"
        "{'camera':3,'children':[5]},{'camera':9,'children':[6]},"
        "{'camera':4}],'cameras':[{'type':'perspective','perspective':{'yfov':"
        "0.7,'znear':0.1}},{'type':'perspective','name':'tele','perspective':"
        "{'yfov':0.2,'aspectRatio':1.5,'znear':1}},{'type':'orthographic',"
        "'orthographic':{}},{'type':'perspective'},{'type':'perspective',"
        "'perspective':{'yfov':0}}]}");

    NEED(s->camera_count == 2);
    const ibl_scene_camera *c = s->cameras;
    CHECK(!strcmp(c[0].name, "eye") && !strcmp(c[1].name, "tele"));
    CHECK(c[0].yfov == 0.7 && c[1].yfov == 0.2);
    CHECK(c[0].aspect == 0 && c[1].aspect == 1.5);
    for (int i = 0; i < 2; i++)
        for (int k = 0; k < 3; k++)
            CHECK(c[i].to_world[12 + k] == k + 1);
    CHECK(c[0].to_world[0] == 1 && c[1].to_world[0] == -1);
    CHECK(strstr(kept.text[IBL_LOG_WARNING], "cameras[4].perspective.yfov"));
}

TEST(materials)
{
    const ibl_scene *s = read_square(
        "'materials':[{'name':'m','alphaMode':'MASK','pbrMetallicRoughness':{"
        "'roughnessFactor':0.25,'metallicFactor':0,'baseColorTexture':{'index':"
        "0,'extensions':{'KHR_texture_transform':{'offset':[0.5,0.25],"
        "'rotation':1,'scale':[2,3]}}}},'emissiveFactor':[1,2,3],"
        "'normalTexture':{'index':0,'scale':0.5},'extensions':{"
        "'KHR_materials_sheen':{'sheenColorFactor':[0.1,0.2,0.3],"
        "'sheenRoughnessFactor':0.4},'KHR_materials_ior':{'ior':1.33},"
        "'KHR_materials_emissive_strength':{'emissiveStrength':4},"
        "'KHR_materials_unlit':{}}}],'textures':[{'source':0,'sampler':0}],"
        "'samplers':[{'wrapS':33071}],'images':[{'uri':'data:image/png;base64,"
        "AAAA'}]");
    const ibl_scene_material *m = s->materials;
    const ibl_scene_texture *t = &m->base_colour_texture;

    CHECK(!strcmp(m->name, "m") && m->alpha_mode == IBL_SCENE_MASK && m->unlit);
    CHECK_NEAR(m->roughness, 0.25, 0);
    CHECK_NEAR(m->metallic, 0, 0);
    CHECK_NEAR(m->emissive[2], 12, 0);
    CHECK_NEAR(m->normal_scale, 0.5, 0);
    CHECK_NEAR(m->sheen_colour[1], 0.2, 1e-6);
    CHECK_NEAR(m->sheen_roughness, 0.4, 1e-6);
    CHECK_NEAR(m->ior, 1.33, 1e-6);
    CHECK(t->image == 0 && t->wrap_s == 33071 && t->wrap_t == 10497);
    CHECK_NEAR(t->offset[1], 0.25, 0);
    CHECK_NEAR(t->scale[1], 3, 0);
    CHECK_NEAR(t->rotation, 1, 0);
    CHECK(m->occlusion_texture.image == -1);
    CHECK(s->images->encoded_size == 3);
    CHECK_NEAR(m[1].metallic, 1, 0);
}

/* ---- surveys ----------------------------------------------------------- */

/* Writes x.png of 2x1 texels. */
static void save_texels(const unsigned char rgba[8])
{
    ibl_blob png;

    NEED(ibl_png_encode(rgba, 4, 2, 1, NULL, &png));
    NEED(file_save(file_path("x.png"), png.bytes, png.size));
    ibl_blob_free(&png);
}

/* The survey of the square, of this material; textures 0 is x.png. */
static ibl_scene_survey survey_square(const char *material)
{
    ibl_scene_survey survey = {0};
    ibl_scene *s =
        read_square(test_text("'materials':[%s],'textures':[{'source':0}],"
                              "'images':[{'uri':'x%%2Epng'}]",
                              material));

    NEED(!ibl_scene_survey_add(quiet, s, &survey));
    CHECK_NEAR(survey.area, 8, 1e-5);
    return survey;
}

#define MR(more)                                                               \
    "{'pbrMetallicRoughness':{'baseColorFactor':[0.5,0.5,0.5,0.75],"           \
    "'metallicRoughnessTexture':{'index':0" more "}}}"
#define TRANSFORM(text) ",'extensions':{'KHR_texture_transform':{" text "}}"

/* The left texel is a metal of roughness 1/4, the right one none of 1. */
static const unsigned char two[8] = {9, 64, 255, 9, 9, 255, 0, 9};
/* The right texel has an alpha of a fifth. */
static const unsigned char clear[8] = {255, 255, 255, 255, 255, 255, 255, 51};
/* F0 of 1 by A = 1, and of 0 by 0. */
static const unsigned char glossy[8] = {255, 255, 255, 255, 0, 0, 0, 0};

#define COLOUR "'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}"
#define TURNED(turn, more)                                                     \
    MR(TRANSFORM("'rotation':" turn "1.5707963267948966,'scale':[9,0."         \
                 "25]" more))
#define GLOSS(more)                                                            \
    "{'pbrMetallicRoughness':{'metallicFactor':1,'baseColorFactor':[0,0,0,1]}" \
    ",'extensions':{'KHR_materials_pbrSpecularGlossiness':{'diffuseFactor':["  \
    "0.5,0.5,0.5,1]," more "}}}"

/* All that is in a survey: the bins that are not empty, with share, power and
 * diffuse light. */
static const char *survey_text(const ibl_scene_survey *s)
{
    static const char *const names[] = {"metal", "other", "coat", "sheen"};
    const ibl_survey_bin *const lists[] = {s->metal, s->dielectric,
                                           s->clearcoat, s->sheen};
    const char *text = test_text("%d", s->triangles);

    for (int i = 0; i < 4 * IBL_SURVEY_BINS; i++) {
        const int bin = i % IBL_SURVEY_BINS;
        const ibl_survey_bin *b = &lists[i / IBL_SURVEY_BINS][bin];
        if (b->share > 1e-4)
            text = test_text("%s, %s %d: %.3f %.3f %.3f", text,
                             names[i / IBL_SURVEY_BINS], bin, b->share,
                             b->power, b->diffuse);
    }
    return test_text("%s%s%s%s", text, s->unlit > 0.999 ? ", unlit" : "",
                     s->anisotropic > 0.999 ? ", anisotropic" : "",
                     fabs(s->transmission - 0.25) < 1e-6 ? ", clear" : "");
}

/* By material and texels. u goes over the left half only; over a quarter of the
 * right one; turned by 90 degrees, v goes over it, from right to left;
 * mirrored, as repeated. F0 of an ior of 3 is ((3 - 1) / (3 + 1))^2 = 1/4 =
 * mix(.04, 1, .21875). */
TEST(surveys)
{
    static const struct {
        const char *material;
        const unsigned char *texels;
        const char *survey;
    } cases[] = {
        {MR(""), two,
         "2, metal 16: 0.500 0.125 0.000, other 64: 0.500 0.500 0.250"},
        {MR(TRANSFORM("'scale':[0.5,1]")), two,
         "2, metal 16: 1.000 0.250 0.000"},
        {MR(TRANSFORM("'scale':[0.5,1],'offset':[0.5,0]")), two,
         "2, other 64: 1.000 1.000 0.500"},
        {MR(TRANSFORM("'scale':[0.75,1]")), two,
         "2, metal 16: 0.667 0.167 0.000, other 64: 0.333 0.333 0.167"},
        {TURNED("", ""), two, "2, metal 16: 1.000 0.250 0.000"},
        {TURNED("", ",'offset':[0.5,0]"), two,
         "2, other 64: 1.000 1.000 0.500"},
        {TURNED("-", ""), two, "2, other 64: 1.000 1.000 0.500"},
        {"{'alphaMode':'MASK'," COLOUR "}", clear,
         "2, metal 64: 0.500 0.500 0.000"},
        {"{'alphaMode':'BLEND'," COLOUR "}", clear,
         "2, metal 64: 0.600 0.600 0.000"},
        {"{" COLOUR "}", clear, "2, metal 64: 1.000 1.000 0.000"},
        {"{'extensions':{'KHR_materials_unlit':{}}}", clear, "2, unlit"},
        {"{'pbrMetallicRoughness':{'metallicFactor':0,'roughnessFactor':0.5},"
         "'extensions':{'KHR_materials_clearcoat':{'clearcoatFactor':0.5,"
         "'clearcoatRoughnessFactor':0.125},'KHR_materials_sheen':{"
         "'sheenColorFactor':[0.5,0.5,0.5],'sheenRoughnessFactor':0.75},"
         "'KHR_materials_transmission':{'transmissionFactor':0.25},"
         "'KHR_materials_ior':{'ior':3},'KHR_materials_anisotropy':{"
         "'anisotropyStrength':1}}}",
         two,
         "2, metal 32: 0.219 0.219 0.000, other 32: 0.781 0.781 0.586, coat 8: "
         "0.500 0.250 0.000, sheen 48: 1.000 0.250 0.000, anisotropic, clear"},
        {GLOSS("'specularFactor':[0.04,0.04,0.04],'glossinessFactor':0.75"),
         two, "2, other 16: 1.000 1.000 0.500"},
        {GLOSS(
             "'glossinessFactor':0.5,'specularGlossinessTexture':{'index':0}"),
         glossy, "2, metal 32: 0.500 0.500 0.000, other 64: 0.500 0.000 0.250"},
    };

    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        save_texels(cases[i].texels);
        const ibl_scene_survey s = survey_square(cases[i].material);
        const char *got = survey_text(&s);
        CHECK_MSG(!strcmp(got, cases[i].survey), "%s: %s, not %s",
                  cases[i].material, got, cases[i].survey);
    }
}

/* Three times the area counts three times as much. */
TEST(surveys_add_up)
{
    ibl_scene_survey survey = {0};

    ibl_scene *a = read_square(
        "'materials':[{'pbrMetallicRoughness':{'roughnessFactor':0}}]");
    NEED(!ibl_scene_survey_add(quiet, a, &survey));
    ibl_scene *b = read_square("'materials':[{}]");
    for (int i = 0; i < 3; i++)
        NEED(!ibl_scene_survey_add(quiet, b, &survey));
    CHECK_NEAR(survey.metal[0].share, 0.25, 1e-6);
    CHECK_NEAR(survey.metal[64].share, 0.75, 1e-6);
    CHECK(survey.scenes == 4);
}

/* An image that is cut short, or of another kind, is refused, or else warned
 * of, and its factor stands for it. */
TEST(damaged_images)
{
    static const char *const text = "'materials':[" MR(
        "") "],'textures':[{'source':0}],'images':[{'uri':'x.png'}]";
    static const struct {
        const char *bytes, *said;
    } others[] = {{"GIF89a", "neither PNG nor JPEG"},
                  {"\xabKTX 20", "KTX"},
                  {"\1\1\1\1ftypavif.", "AVIF"},
                  {"RIFF\1\1\1\1WEBPVP8 ", "WebP"}};
    size_t size;

    save_texels(two);
    const char *path = file_path("x.png");
    const unsigned char *png = file_load(path, &size);
    for (size_t n = 4; n < size - 12; n++) {
        ibl_scene_survey survey = {0};
        NEED(file_save(path, png, n));
        strict = n % 2;
        ibl_scene *s = read_square(text);
        CHECK_MSG(!ibl_scene_survey_add(quiet, s, &survey) == !strict,
                  "%zu of %zu bytes", n, size);
        CHECK(strstr(kept.text[strict ? IBL_LOG_ERROR : IBL_LOG_WARNING],
                     "x.gltf: images[0]: x.png: a damaged image"));
        CHECK(strict || survey.metal[64].share > 0.999);
        CHECK(s->materials->metallic_roughness_texture.image == -1);
    }
    strict = false;
    for (size_t i = 0; i < sizeof others / sizeof *others; i++) {
        ibl_scene_survey survey = {0};
        NEED(file_save(path, others[i].bytes, strlen(others[i].bytes)));
        CHECK(!ibl_scene_survey_add(quiet, read_square(text), &survey));
        CHECK_MSG(strstr(kept.text[IBL_LOG_WARNING], others[i].said) ||
                      strstr(kept.text[IBL_LOG_WARNING], "damaged image"),
                  "%zu: %s", i, kept.text[IBL_LOG_WARNING]);
    }
}

TEST(jpeg)
{
    ibl_scene_survey survey = {0};
    static const char *const text = "'materials':[" MR(
        "") "],'textures':[{'source':0}],'images':[{'uri':'x.jpg'}]";
    size_t size;

    if (!file_have("cjpeg"))
        test_skip("no cjpeg");
    NEED(file_run("{ echo P6 64 32 255; for i in $(seq 2048); do printf "
                  "'\\100\\200\\377'; done; } | cjpeg -quality 95 >x.jpg"));
    NEED(!ibl_scene_survey_add(quiet, read_square(text), &survey));
    CHECK_NEAR(ibl_survey_share(survey.metal), 1, 0.02);
    CHECK_NEAR(survey.metal[32].share, 1, 0.02);
    /* cut short in its pixels */
    NEED(file_run("{ echo P6 64 32 255; seq 9999 | head -c 6144; } | cjpeg "
                  "-quality 95 >x.jpg"));
    const unsigned char *jpeg = file_load(file_path("x.jpg"), &size);
    NEED(file_save(file_path("x.jpg"), jpeg, size - 500));
    CHECK(!ibl_scene_survey_add(quiet, read_square(text), &survey) &&
          strstr(kept.text[IBL_LOG_WARNING], "damaged"));
    /* four components in its frame, then the end of it */
    NEED(file_save(
        file_path("x.jpg"),
        "\xff\xd8\xff\xc0\0\x14\x08\0\x08\0\x08\x04\x01\x11\0\x02\x11\0\x03\x11"
        "\0\x04\x11\0\xff\xda\0\x0e\x04\x01\0\x02\0\x03\0\x04\0\0\x3f\0",
        40));
    CHECK(!ibl_scene_survey_add(quiet, read_square(text), &survey) &&
          strstr(kept.text[IBL_LOG_WARNING], "CMYK"));
}

/* ---- skins ------------------------------------------------------------- */

enum {
    SKINNED = 40, /* vertices, of which each three are a triangle */
    BONES = 3
};

/* As the file has them: places, normals and tangents, joints and two sets of
 * weights of four for each vertex, then the inverse binds by columns. */
typedef struct skinned {
    int16_t place[SKINNED][4]; /* 3 of 1 / 32767 */
    float normal[SKINNED][3], tangent[SKINNED][4];
    unsigned char joints[2][SKINNED][4];
    unsigned char weights[2][SKINNED][4]; /* of 255 in all */
    float inverse[BONES][16];
} skinned;

/* The mean over joints that are there of where they take it, by weights. World
 * matrices: bone 0 is the parent of the others and stands below root. */
static void skin(const skinned *s, double all[BONES + 1][16], int v, double w,
                 const double p[3], double to[3])
{
    double sum = 0;
    to[0] = to[1] = to[2] = 0;
    for (int i = 0; i < 8; i++) {
        const double weight = s->weights[i / 4][v][i % 4] / 255.0;
        const int j = s->joints[i / 4][v][i % 4];
        double inverse[16], at[3] = {p[0], p[1], p[2]};
        if (j >= BONES)
            continue;
        for (int k = 0; k < 16; k++)
            inverse[k] = (double)s->inverse[j][k];
        apply(inverse, w, at);
        apply(all[j], w, at);
        if (j)
            apply(all[0], w, at);
        apply(all[BONES], w, at);
        for (int k = 0; k < 3; k++)
            to[k] += weight * at[k];
        sum += weight;
    }
    for (int k = 0; k < 3; k++)
        to[k] /= sum;
}

static test_random rng = {1};

static double spin(void)
{
    return test_random_between(&rng, -1, 1);
}

static void make_skinned(skinned *s)
{
    for (int v = 0; v < SKINNED; v++) {
        int left[2] = {0, 255};
        for (int k = 0; k < 3; k++)
            s->place[v][k] = (int16_t)(32767 * spin());
        for (int i = 0; i < 8; i++) {
            const int part =
                i < 7 ? (int)(left[1] * (spin() + 1) / 4) : left[1];
            s->joints[i / 4][v][i % 4] =
                v == 7 && i == 5 ? 250 : (unsigned char)(v + i) % BONES;
            s->weights[i / 4][v][i % 4] = (unsigned char)part;
            left[1] -= part;
        }
    }
    for (int v = 0; v < SKINNED; v++) {
        const double n[3] = {spin(), spin(), spin()};
        const double length = sqrt(test_dot(n, n));
        for (int k = 0; k < 3; k++)
            s->normal[v][k] = s->tangent[v][(k + 1) % 3] =
                (float)(n[k] / length);
        s->tangent[v][3] = 1;
    }
    for (int i = 0; i < BONES; i++)
        for (int k = 0; k < 16; k++)
            s->inverse[i][k] =
                (float)(k % 4 == 3 ? k == 15 : spin() + (k % 5 == 0));
}

static const char *node_text(const double m[16], const char *more)
{
    const char *text = "{'matrix':[";

    for (int k = 0; k < 16; k++)
        text = test_text("%s%.17g%s", text, m[k], k < 15 ? "," : "]");
    return test_text("%s%s}", text, more);
}

/* Views of the parts of skinned, and accessors to them. */
static const char *views_text(void)
{
    static const struct {
        size_t at;
        int type;
        const char *kind;
    } parts[] = {{offsetof(skinned, place), 5122, "VEC3"},
                 {offsetof(skinned, normal), 5126, "VEC3"},
                 {offsetof(skinned, tangent), 5126, "VEC4"},
                 {offsetof(skinned, joints[0]), 5121, "VEC4"},
                 {offsetof(skinned, joints[1]), 5121, "VEC4"},
                 {offsetof(skinned, weights[0]), 5121, "VEC4"},
                 {offsetof(skinned, weights[1]), 5121, "VEC4"},
                 {offsetof(skinned, inverse), 5126, "MAT4"},
                 {sizeof(skinned), 0, NULL}};
    const char *views = "", *accessors = "";

    for (int i = 0; i < 8; i++) {
        views = test_text(
            "%s%s{'buffer':0,'byteOffset':%zu,'byteLength':%zu%s}", views,
            i ? "," : "", parts[i].at, parts[i + 1].at - parts[i].at,
            i ? "" : ",'byteStride':8");
        accessors = test_text("%s%s{'bufferView':%d,'componentType':%d,'count':"
                              "%d,'type':'%s','normalized':%s}",
                              accessors, i ? "," : "", i, parts[i].type,
                              i < 7 ? SKINNED : BONES, parts[i].kind,
                              i == 0 || i == 5 || i == 6 ? "true" : "false");
    }
    return test_text("'bufferViews':[%s],'accessors':[%s]", views, accessors);
}

/* Of a normal is known that where tangents go stays at right angles to it, and
 * the side on which it is. Tangents go with the vertex, and change their side
 * in a mirror. */
static void check_skinned(const ibl_scene *s, const skinned *from,
                          double all[BONES + 1][16])
{
    const ibl_scene_primitive *p = s->primitives;
    double size = 0;

    NEED(s->draw_count == 1 && p->vertex_count == SKINNED && !p->joints[0] &&
         p->tangent);
    for (int k = 0; k < 3; k++)
        size = fmax(size, s->bounds[1][k] - s->bounds[0][k]);
    for (int v = 0; v < SKINNED; v++) {
        const double at[3] = {from->place[v][0] / 32767.0,
                              from->place[v][1] / 32767.0,
                              from->place[v][2] / 32767.0};
        double n[3], normal[3], world[3], axis[3] = {0}, tangent[3], moved[3];
        for (int k = 0; k < 3; k++) {
            n[k] = (double)p->normal[3 * v + k];
            normal[k] = (double)from->normal[v][k];
        }
        skin(from, all, v, 1, at, world);
        for (int k = 0; k < 3; k++)
            CHECK_NEAR((double)p->position[3 * v + k] +
                           s->draws->to_world[12 + k],
                       world[k], 1e-6 * size);
        axis[v % 3] = 1;
        cross(normal, axis, tangent);
        skin(from, all, v, 0, tangent, moved);
        CHECK_NEAR(test_dot(n, n), 1, 1e-5);
        CHECK_NEAR(test_dot(n, moved), 0, 1e-5 * sqrt(test_dot(moved, moved)));
        skin(from, all, v, 0, normal, moved);
        CHECK(test_dot(n, moved) > 0);
        double frame[3][3], side[3];
        for (int k = 0; k < 3; k++) {
            const double unit[3] = {k == 0, k == 1, k == 2};
            skin(from, all, v, 0, unit, frame[k]);
            tangent[k] = (double)from->tangent[v][k];
            n[k] = (double)p->tangent[4 * v + k];
        }
        cross(frame[0], frame[1], side);
        CHECK((p->tangent[4 * v + 3] > 0) == (test_dot(side, frame[2]) > 0));
        skin(from, all, v, 0, tangent, moved);
        CHECK_NEAR(test_dot(n, moved) / sqrt(test_dot(moved, moved)), 1, 1e-5);
    }
}

/* A skin against the same in double; the node's own place does not count. */
TEST(skins)
{
    skinned *from = test_alloc(1, sizeof *from);

    make_skinned(from);
    NEED(file_save(file_path("skin.bin"), from, sizeof *from));
    for (int i = 0; i < 4; i++) {
        double all[BONES + 1][16]; /* the last: the root */
        for (int b = 0; b <= BONES; b++)
            for (int k = 0; k < 16; k++)
                all[b][k] = k % 4 == 3 ? k == 15 : spin() + (k % 5 == 0);
        all[BONES][12] += i & 2 ? 4e6 : 0; /* from the middle of the earth */
        const char *nodes = test_text(
            "%s,%s,%s,%s,%s", node_text(all[BONES], ",'children':[1]"),
            node_text(all[0], ",'children':[2,3]"), node_text(all[1], ""),
            node_text(all[2], ""), node_text(all[1], ",'mesh':0,'skin':0"));
        const ibl_scene *s = read_text(test_text(
            "{'asset':{'version':'2.0'},'scenes':[{'nodes':[0,4]}],'nodes':["
            "%s],'buffers':[{'uri':'skin.bin','byteLength':%zu}],%s,'skins':[{"
            "'joints':[1,2,3],'inverseBindMatrices':7}],'meshes':[{"
            "'primitives':[{'attributes':{'POSITION':0,'NORMAL':1,'TANGENT':2,"
            "'JOINTS_0':3,'JOINTS_1':4,'WEIGHTS_0':5,'WEIGHTS_1':6}}]}]}",
            nodes, sizeof *from, views_text()));
        check_skinned(s, from, all);
    }
}

/* ---- extensions, and what files have in place of what they should ------ */

/* Sets 2 and 7 of texture coordinates, the second by the transform. */
TEST(sets_of_coordinates)
{
    save_texels(two);
    save_mesh();
    ibl_scene *s = read_text(
        "{" BUFFER "," ACCESSORS "," SCENE
        ",'meshes':[{'primitives':[{'mode':5,'attributes':{'POSITION':0,"
        "'TEXCOORD_0':0,'TEXCOORD_2':1,'TEXCOORD_7':1},'indices':2,'material':"
        "0}]}],'images':[{'uri':'x.png'}],'textures':[{'source':0}],"
        "'materials':[{'occlusionTexture':{'index':0,'texCoord':2},"
        "'pbrMetallicRoughness':{'metallicRoughnessTexture':{'index':0,"
        "'texCoord':4,'extensions':{'KHR_texture_transform':{'texCoord':"
        "7}}}}}]}");
    const ibl_scene_material *m = s->materials;
    const int seventh = m->metallic_roughness_texture.texcoord;
    ibl_scene_survey survey = {0};

    CHECK(m->sets[m->occlusion_texture.texcoord] == 2 && m->sets[seventh] == 7);
    CHECK(s->primitives->texcoord[seventh]);
    NEED(!ibl_scene_survey_add(quiet, s, &survey));
    CHECK_NEAR(survey.metal[16].share, 0.5, 1e-4);
}

static int named; /* lines that name what is looked for */
static const char *looked_for;

static void count_names(void *cookie, ibl_log_level level, const char *text)
{
    (void)cookie;
    named += level == IBL_LOG_WARNING && strstr(text, looked_for);
}

/* Each that is not read is named once, whichever lists have it; strict, one
 * that the file needs is an error. */
TEST(extensions)
{
    static const struct {
        const char *name;
        int named;
    } cases[] = {{"KHR_texture_basisu", 1},
                 {"X_new", 1},
                 {"KHR_mesh_quantization", 0},
                 {"KHR_materials_pbrSpecularGlossiness", 0}};
    ibl_ctx_options opts = ibl_ctx_options_default();
    ibl_ctx *ctx;

    opts.log = count_names;
    ctx = test_ctx_of(&opts);
    save_mesh();
    for (size_t i = 0; i < 2 * (sizeof cases / sizeof *cases); i++) {
        ibl_scene s;
        looked_for = cases[i / 2].name;
        named = 0;
        const char *path =
            save("x.gltf", test_text(FILE_OF("{'mesh':0}",
                                             ",'extensionsUsed':['%s','%s',7],"
                                             "'extensionsRequired':['%s']"),
                                     looked_for, looked_for, looked_for));
        const bool refused = i % 2 && cases[i / 2].named;
        CHECK(!ibl_scene_read(ctx, path, i % 2, &s) == !refused);
        CHECK_MSG(named == cases[i / 2].named, "%s: %d", looked_for, named);
        ibl_scene_free(&s);
    }
}

/* ---- what is packed ---------------------------------------------------- */

#define NEED_DECODER(name)                                                     \
    do                                                                         \
        if (!ibl_gltf_decoders()->name)                                        \
            test_skip("built without " #name);                                 \
    while (0)

/* A file whose buffer has these bytes, with a view of all of them. */
static const char *packed_text(const char *base64, const char *more)
{
    return test_text("{'asset':{'version':'2.0'},'buffers':[{'uri':'data:;"
                     "base64,%s','byteLength':%zu}]," SCENE ",%s}",
                     base64, strlen(base64) / 4 * 3 - 2, more);
}

/* As draco::Encoder made them: floats in sequence, and quantized to 11 bits. */
TEST(draco)
{
    static const struct {
        const char *bytes;
        double tolerance;
    } cases[] = {{"RFJBQ08CAgEAAAACBAEAAQICAQMBAgAJAwAAAwICAAEAAQAAgL8AAIC/"
                  "AAAAQAAAgD8AAIC/AAAAQAAAgL8AAIA/AAAAQAAAgD8AAIA/"
                  "AAAAQAABAQADAwEwARADACiCpgEAAAAA/wAAAA==",
                  1e-6},
                 {"RFJBQ08CAgEBAAAABAIBAgAAAR//ARH/AREC/"
                  "wAAAAAAAQAJAwAAAgEDAgIAAQEBAQEAAwMBMAEQAwAkgkoEAAAAAP8HAAAAA"
                  "IC/AACAvwAAAEAAAABACwEBAQADAwEwARADACiCjAAAAAAA/wAAAA==",
                  2e-3}};

    NEED_DECODER(draco);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        const ibl_scene *s = read_text(packed_text(
            cases[i].bytes,
            test_text("'bufferViews':[{'buffer':0,'byteLength':%zu}],"
                      "'accessors':[{'componentType':5126,'count':4,'type':"
                      "'VEC3'},{'componentType':5121,'count':4,'type':'VEC2',"
                      "'normalized':true},{'componentType':5123,'count':6,"
                      "'type':'SCALAR'}],'meshes':[{'primitives':[{"
                      "'attributes':{'POSITION':0,'TEXCOORD_0':1},'indices':2,"
                      "'extensions':{'KHR_draco_mesh_compression':{"
                      "'bufferView':0,'attributes':{'POSITION':0,'TEXCOORD_0':"
                      "1}}}}]}]",
                      strlen(cases[i].bytes) / 4 * 3 - 2)));
        const ibl_scene_primitive *p = s->primitives;
        check_drawn(s, &a_square, cases[i].tolerance);
        for (size_t v = 0; v < p->vertex_count; v++)
            CHECK_NEAR(p->texcoord[0][2 * v], (p->position[3 * v] + 1) / 2,
                       cases[i].tolerance);
    }
}

/* As meshopt_encode made them, one behind the other: positions, the normal
 * .6 0 .8 in octahedra, triangles, and the strip 0 1 2 3. */
TEST(meshopt)
{
    static const char *const streams[] = {
        ("oAAAAAE/AAAA////AAAAAQwAAAD/"
         "AAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAACAvwAAgL8AAABA"),
        "oAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAANgB/AA==",
        "4fAQAHaHVmd4qYZliWiYAWkAAA==", "0QAEBAQAAAAA"};
    static const int sizes[] = {57, 37, 19, 9}, counts[] = {4, 4, 6, 4},
                     strides[] = {12, 4, 2, 2};
    static const char *const modes[] = {"ATTRIBUTES",
                                        "ATTRIBUTES','filter':'OCTAHEDRAL",
                                        "TRIANGLES", "INDICES"};
    const char *buffers = "", *views = "";

    NEED_DECODER(meshopt);
    for (int i = 0; i < 4; i++) {
        buffers = test_text("%s{'uri':'data:;base64,%s','byteLength':%d},",
                            buffers, streams[i], sizes[i]);
        views = test_text("%s%s{'buffer':4,'byteLength':%d,'extensions':{"
                          "'EXT_meshopt_compression':{'buffer':%d,'byteLength':"
                          "%d,'byteStride':%d,'count':%d,'mode':'%s'}}}",
                          views, i ? "," : "", counts[i] * strides[i], i,
                          sizes[i], strides[i], counts[i], modes[i]);
    }
    for (int i = 0; i < 2; i++) {
        const ibl_scene *s = read_text(test_text(
            "{'asset':{'version':'2.0'},'buffers':[%s{'byteLength':999,"
            "'extensions':{'EXT_meshopt_compression':{'fallback':true}}}],"
            "'bufferViews':[%s],'accessors':[{'bufferView':0,'componentType':"
            "5126,'count':4,'type':'VEC3'},{'bufferView':1,'componentType':"
            "5120,'normalized':true,'count':4,'type':'VEC3'},{'bufferView':%d,"
            "'componentType':5123,'count':%d,'type':'SCALAR'}]," SCENE
            ",'meshes':[{'primitives':[{'attributes':{'POSITION':0,'NORMAL':1},"
            "'indices':2,'mode':%d}]}]}",
            buffers, views, 2 + i, counts[2 + i], 4 + i));
        const float *n = s->primitives->normal;
        check_drawn(s, &a_square, 1e-6);
        CHECK(s->primitives->vertex_count == 4);
        CHECK_NEAR(n[0], 0.6, 0.02);
        CHECK_NEAR(n[2], 0.8, 0.02);
    }
}

TEST(webp)
{
    static const char *const text =
        "'materials':[" MR("") "],'textures':[{'extensions':{'EXT_texture_webp'"
                               ":{'source':0}}}],'images':[{'uri':'data:"
                               "image/webp;base64,UklGRiAAAABXRUJQVlA4TBMAAAAvA"
                               "QAAAA/woP9JmP/5jyVkRP8DAA=='}]";
    ibl_scene_survey survey = {0};

    NEED_DECODER(webp);
    NEED(!ibl_scene_survey_add(quiet, read_square(text), &survey));
    CHECK_NEAR(survey.metal[16].share, 0.5, 1e-4);
    CHECK_NEAR(survey.dielectric[64].share, 0.5, 1e-4);
}

/* ---- what is no scene ------------------------------------------------- */

/* A part that is wrong is warned of and left out, or, strict, an error; some
 * leave nothing to draw. */
TEST(damaged)
{
    static const struct {
        const char *text, *said;
        bool drawn;
    } cases[] = {
        {"{}", "no asset.version", false},
        {"{'asset':{'version':'1.0'}}", "glTF 1.0: only", false},
        {"{'meshes':{}}", "glTF 1.0: only", false},
        {"[", "no glTF", false},
        {"{'asset':{'version':'2.0'}}", "it has no scenes", false},
        {"{'asset':{'version':'2.0'},'scenes':[{}]}", "has no triangles",
         false},
        {"{" BUFFER ",'accessors':[{'bufferView':0,'componentType':5126,'count'"
         ":5,'type':'VEC3'}]," SCENE
         ",'meshes':[{'primitives':[{'attributes':{'POSITION':0}}]}]}",
         "5 elements of 12 bytes", false},
        {"{" BUFFER ",'accessors':[{'componentType':5126,'count':200000000,'"
         "type':'VEC3'}]," SCENE
         ",'meshes':[{'primitives':[{'attributes':{'POSITION':0}}]}]}",
         "million numbers", false},
        {"{" BUFFER "," ACCESSORS "," SCENE
         ",'meshes':[{'primitives':[{'attributes':{'POSITION':0},'indices':1}"
         "," STRIP "}]}]}",
         "expected 1 to 1 components", true},
        {"{" BUFFER "," ACCESSORS
         ",'scenes':[{'nodes':[0]}],'nodes':[{'children':[0]}]}",
         "node 0 is in two places", false},
        {"{" BUFFER "," ACCESSORS ",'scenes':[{'nodes':[7,0]}],'nodes':[{'mesh'"
         ":0}],'meshes':[{'primitives':[" STRIP "}]}]}",
         "expected 0, found 7", true},
        {"{'asset':{'version':'2.0'},'scenes':[{}],'buffers':[{'byteLength':4,"
         "'uri':'data:;base64,AA'}]}",
         "only 1", false},
        {"{'asset':{'version':'2.0'},'scenes':[{}],'buffers':[{'byteLength':4,"
         "'uri':'data:;base64,A*A'}]}",
         "no base64", false},
        {"{'asset':{'version':'2.0'},'scenes':[{}],'buffers':[{'byteLength':4,"
         "'uri':'https://x.y/z'}]}",
         "https://x.y/z cannot be read: No such", false},
        {STRIPS ",'material':0}]}]}", "no index", true},
        {STRIPS
         "}]}],'materials':[{'pbrMetallicRoughness':{'roughnessFactor':'x'}}]}",
         "expected a number", true},
        {"{'asset':{'version':'2.0'},'buffers':[{'byteLength':48,'uri':'data:;"
         "base64,AADAfwAAgL8AAABAAACAPwAAgL8AAABAAACAvwAAgD8AAABAAACAPwAAgD8AAA"
         "BA'}],'bufferViews':[{'buffer':0,'byteLength':48}],'accessors':[{"
         "'bufferView':0,'componentType':5126,'count':4,'type':'VEC3'}]," SCENE
         ",'meshes':[" ONE_STRIP "]}",
         "1 values are no numbers", true},
        {STRIPS "}]}],'images':[{'uri':'a/none.png'}]}",
         "x.gltf: images[0].uri: ", true},
    };

    save_mesh();
    for (size_t i = 0; i < 2 * (sizeof cases / sizeof *cases); i++) {
        const bool drawn = cases[i / 2].drawn;
        ibl_status status;
        strict = i % 2;
        read_scene(save("x.gltf", cases[i / 2].text), &status);
        CHECK_MSG(!status == (drawn && !strict) &&
                      (test_said(&kept, cases[i / 2].said) ||
                       (!strict &&
                        strstr(kept.text[IBL_LOG_WARNING], cases[i / 2].said))),
                  "%zu: %d: %s", i, (int)status, kept.text[IBL_LOG_ERROR]);
    }
    strict = false;
}

/* A .glb of the square, cut short at each length: the words of the sizes in it
 * then lie. */
TEST(glb_cut_short)
{
    const char *text =
        "{'asset':{'version':'2.0'},'buffers':[{'byteLength':76}],"
        "'bufferViews':[{'buffer':0,'byteLength':48}],'accessors':[{"
        "'bufferView':0,'componentType':5126,'count':4,'type':'VEC3'}]," SCENE
        ",'meshes':[{'primitives':[{'attributes':{'POSITION':0}}]}]}";
    unsigned char all[2048] = "glTF";
    size_t size, first;
    ibl_status status;

    save_mesh();
    const unsigned char *json = file_load(save("x.gltf", text), &first);
    const unsigned char *mesh = file_load(file_path("mesh.bin"), &size);
    const size_t at = 20 + first;
    file_set_u32(all + 4, 2);
    file_set_u32(all + 8, (uint32_t)(at + 8 + size));
    file_set_u32(all + 12, (uint32_t)first);
    memcpy(all + 16, "JSON", 4);
    memcpy(all + 20, json, first);
    file_set_u32(all + at, (uint32_t)size);
    memcpy(all + at + 4, "BIN", 4);
    memcpy(all + at + 8, mesh, size);
    for (size_t n = 1; n <= at + 8 + size; n += n < at + 8 ? 37 : 1) {
        const char *path = file_path("x.glb");
        NEED(file_save(path, all, n));
        read_scene(path, &status);
        CHECK_MSG(!status == (n == at + 8 + size), "%zu of %zu bytes: %d", n,
                  at + 8 + size, (int)status);
    }
}

/* ---- what others made -------------------------------------------------- */

static bool is_among(const char *path, const char *const names[])
{
    int i = 0;

    while (names[i] && !strstr(path, names[i]))
        i++;
    return names[i];
}

/* The same scene in two files: both are surveyed as the same. */
static void check_same(const char *a, const char *b)
{
    const char *const names[] = {a, b};
    ibl_scene_survey survey[2] = {0};

    for (int i = 0; i < 2; i++) {
        ibl_status status;
        ibl_scene *s = read_scene(
            test_text("../shared/cases/models/%s", names[i]), &status);
        NEED(!status && !ibl_scene_survey_add(quiet, s, &survey[i]));
    }
    CHECK_NEAR(survey[0].area / survey[1].area, 1, 1e-5);
    for (int i = 0; i < IBL_SURVEY_BINS; i++)
        CHECK_NEAR(survey[0].dielectric[i].share, survey[1].dielectric[i].share,
                   1e-5);
}

/* Reads and surveys the files that a command lists, of which some are refused;
 * returns how many there are. */
static int survey_all(const char *command, const char *const refused[])
{
    char path[512];
    int count = 0;
    FILE *list = popen(command, "r");

    NEED(list);
    for (; fgets(path, sizeof path, list); count++) {
        ibl_scene_survey survey = {0};
        ibl_status status;
        path[strcspn(path, "\n")] = '\0';
        ibl_scene *s = read_scene(path, &status);
        const bool read = !is_among(path, refused);
        if (!status && read)
            status = ibl_scene_survey_add(quiet, s, &survey);
        CHECK_MSG(!status == read && !status == !*kept.text[IBL_LOG_ERROR],
                  "%s: %d: %s", path, (int)status, kept.text[IBL_LOG_ERROR]);
    }
    pclose(list);
    return count;
}

/* Small files as users have them: all are drawn but one, whose Draco is made
 * up. */
TEST(cases_of_users)
{
    static const char *const refused[] = {"/61_", NULL};

    if (!survey_all("ls ../shared/cases/models/* 2>/dev/null", refused))
        test_skip("no ../shared/cases/models");
    check_same("13c_skin_cm.glb", "13cr_reference.glb");
    check_same("03a_ecef.glb", "03r_reference.glb");
}

/* Assimp's models of glTF 2: those that have no triangles or are damaged on
 * purpose are refused, all others are read. */
TEST(models_of_assimp)
{
    const char *const draco = ibl_gltf_decoders()->draco ? NULL : "/draco/";
    const char *const refused[] = {"IndexOutOfRange",
                                   "MissingBin",
                                   "RecursiveNodes",
                                   "SchemaFailures",
                                   "TestNoRootNode",
                                   "Mode_00",
                                   "Mode_01",
                                   "Mode_02",
                                   "Mode_03",
                                   "Mode_07",
                                   "Mode_08",
                                   "Mode_09",
                                   "Mode_10",
                                   "badArray",
                                   "WithInfinites",
                                   draco,
                                   NULL};

    if (!survey_all("find /usr/share/assimp/models/glTF2 -name '*.glb' -o "
                    "-name '*.gltf'",
                    refused))
        test_skip("no package assimp-testmodels");
}
