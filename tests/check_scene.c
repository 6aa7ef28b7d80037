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

static const char *save(const char *name, const char *text)
{
    const char *path = file_path(name);

    NEED(file_save(path, text, strlen(text)));
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
    "\"asset\":{\"version\":\"2.0\"},\"buffers\":[{\"uri\":\"mesh.bin\","      \
    "\"byteLength\":76}],\"bufferViews\":[{\"buffer\":0,\"byteLength\":48},"   \
    "{\"buffer\":0,\"byteOffset\":48,\"byteLength\":8},{\"buffer\":0,"         \
    "\"byteOffset\":56,\"byteLength\":4},{\"buffer\":0,\"byteOffset\":60,"     \
    "\"byteLength\":16}]"
#define ACCESSORS                                                              \
    "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":4,"     \
    "\"type\":\"VEC3\"},{\"bufferView\":1,\"componentType\":5121,\"count\":4," \
    "\"type\":\"VEC2\",\"normalized\":true},{\"bufferView\":2,"                \
    "\"componentType\":5121,\"count\":4,\"type\":\"SCALAR\"},"                 \
    "{\"bufferView\":3,\"componentType\":5125,\"count\":4,"                    \
    "\"type\":\"SCALAR\"}]"
#define ATTRIBUTES "\"attributes\":{\"POSITION\":0,\"TEXCOORD_0\":1}"
#define STRIP "{\"mode\":5," ATTRIBUTES ",\"indices\":2"
#define SCENE                                                                  \
    "\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{\"mesh\":0,"                     \
    "\"scale\":[2,1,1]}]"

/* The square as a strip, with these members of the root besides. */
static ibl_scene *read_square(const char *more)
{
    save_mesh();
    return read_text(test_text("{" BUFFER "," ACCESSORS "," SCENE
                               ",\"meshes\":[{\"primitives\":[" STRIP
                               ",\"material\":0}]}],%s}",
                               more));
}

TEST(square)
{
    const ibl_scene *s = read_square("\"materials\":[{}]");
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

TEST(strips_and_fans)
{
    static const int fan[] = {1, 2, 0, 2, 3, 0};

    save_mesh();
    const ibl_scene *s = read_text(
        "{" BUFFER "," ACCESSORS "," SCENE ",\"meshes\":[{\"primitives\":["
        "{\"mode\":6,\"attributes\":{\"POSITION\":0,\"NORMAL\":0},\"indices\":"
        "3},{\"mode\":1,\"attributes\":{\"POSITION\":0}},{\"attributes\":{"
        "\"POSITION\":0,\"NORMAL\":0}}]}]}");
    CHECK(s->primitive_count == 2); /* lines are left out */
    CHECK(strstr(kept.text[IBL_LOG_WARNING], "1 primitives are points, lines"));
    for (int i = 0; i < 6; i++)
        CHECK(s->primitives[0].index[i] == (uint32_t)fan[i]);
    CHECK(s->primitives[1].index_count == 3);
}

TEST(nodes)
{
    save_mesh();
    /* A turn by 90 degrees about z below a move: x becomes y. */
    const ibl_scene *s = read_text(
        "{" BUFFER "," ACCESSORS
        ",\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0,"
        "\"NORMAL\":0}}]}],\"scene\":1,\"scenes\":[{},{\"nodes\":[1]}],"
        "\"nodes\":[{\"mesh\":0,\"rotation\":[0,0,0.70710678118,"
        "0.70710678118]},{\"children\":[0],\"translation\":[10,20,30]}]}");
    const double *m = s->draws->to_world;
    static const float expected[16] = {0, 1, 0, 0, -1, 0,  0,  0,
                                       0, 0, 1, 0, 10, 20, 30, 1};

    for (int i = 0; i < 16; i++)
        CHECK_NEAR(m[i], expected[i], 1e-6);
}

TEST(materials)
{
    const ibl_scene *s = read_square(
        "\"materials\":[{\"name\":\"m\",\"alphaMode\":\"MASK\","
        "\"pbrMetallicRoughness\":{\"roughnessFactor\":0.25,"
        "\"metallicFactor\":0,\"baseColorTexture\":{\"index\":0,"
        "\"extensions\":{\"KHR_texture_transform\":{\"offset\":[0.5,0.25],"
        "\"rotation\":1,\"scale\":[2,3]}}}},\"emissiveFactor\":[1,2,3],"
        "\"normalTexture\":{\"index\":0,\"scale\":0.5},\"extensions\":{"
        "\"KHR_materials_sheen\":{\"sheenColorFactor\":[0.1,0.2,0.3],"
        "\"sheenRoughnessFactor\":0.4},\"KHR_materials_ior\":{\"ior\":1.33},"
        "\"KHR_materials_emissive_strength\":{\"emissiveStrength\":4},"
        "\"KHR_materials_unlit\":{}}}],\"textures\":[{\"source\":0,"
        "\"sampler\":0}],\"samplers\":[{\"wrapS\":33071}],\"images\":[{"
        "\"uri\":\"data:image/png;base64,AAAA\"}]");
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

    NEED(ibl_png_encode(rgba, 2, 1, NULL, &png));
    NEED(file_save(file_path("x.png"), png.bytes, png.size));
    ibl_blob_free(&png);
}

/* The survey of the square, of this material; textures 0 is x.png. */
static ibl_scene_survey survey_square(const char *material)
{
    ibl_scene_survey survey = {0};
    ibl_scene *s = read_square(
        test_text("\"materials\":[%s],\"textures\":[{\"source\":0}],"
                  "\"images\":[{\"uri\":\"x%%2Epng\"}]",
                  material));

    NEED(!ibl_scene_survey_add(quiet, s, &survey));
    CHECK_NEAR(survey.area, 8, 1e-5);
    return survey;
}

#define MR(more)                                                               \
    "{\"pbrMetallicRoughness\":{\"baseColorFactor\":[0.5,0.5,0.5,0.75],"       \
    "\"metallicRoughnessTexture\":{\"index\":0" more "}}}"
#define TRANSFORM(text) ",\"extensions\":{\"KHR_texture_transform\":{" text "}}"

/* The left texel is a metal of roughness 1/4, the right one none of 1. */
static const unsigned char two[8] = {9, 64, 255, 9, 9, 255, 0, 9};

TEST(survey_of_textures)
{
    save_texels(two);
    const ibl_scene_survey half = survey_square(MR(""));

    CHECK_NEAR(half.metal[16].share, 0.5, 1e-4);
    CHECK_NEAR(half.metal[16].power, 0.125, 1e-4);
    CHECK_NEAR(half.dielectric[64].share, 0.5, 1e-4);
    CHECK_NEAR(half.dielectric[64].power, 0.5, 1e-4);
    CHECK_NEAR(half.dielectric[64].diffuse, 0.25, 1e-4);
    CHECK_NEAR(ibl_survey_share(half.metal) + ibl_survey_share(half.dielectric),
               1, 1e-9);
    CHECK(half.images == 1 && half.materials == 1 && half.triangles == 2);
}

/* u goes over the left half only; over a quarter of the right one; turned by
 * 90 degrees, v goes over it, from right to left; mirrored, as repeated. */
TEST(survey_of_transforms)
{
    static const struct {
        const char *material;
        double metal;
    } cases[] = {{MR(TRANSFORM("\"scale\":[0.5,1]")), 1},
                 {MR(TRANSFORM("\"scale\":[0.5,1],\"offset\":[0.5,0]")), 0},
                 {MR(TRANSFORM("\"scale\":[0.75,1]")), 2.0 / 3},
                 {MR(TRANSFORM("\"rotation\":1.5707963267948966,"
                               "\"scale\":[9,0.25]")),
                  1},
                 {MR(TRANSFORM("\"rotation\":1.5707963267948966,"
                               "\"scale\":[9,0.25],\"offset\":[0.5,0]")),
                  0},
                 {MR(TRANSFORM("\"rotation\":-1.5707963267948966,"
                               "\"scale\":[9,0.25]")),
                  0}};

    save_texels(two);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        const ibl_scene_survey s = survey_square(cases[i].material);
        CHECK_NEAR(ibl_survey_share(s.metal), cases[i].metal, 1e-4);
    }
}

TEST(survey_of_alpha)
{
    static const unsigned char clear[8] = {255, 255, 255, 255,
                                           255, 255, 255, 51};
#define COLOUR "\"pbrMetallicRoughness\":{\"baseColorTexture\":{\"index\":0}}"

    save_texels(clear);
    CHECK_NEAR(ibl_survey_share(
                   survey_square("{\"alphaMode\":\"MASK\"," COLOUR "}").metal),
               0.5, 1e-4);
    CHECK_NEAR(ibl_survey_share(
                   survey_square("{\"alphaMode\":\"BLEND\"," COLOUR "}").metal),
               0.6, 1e-4);
    CHECK_NEAR(ibl_survey_share(survey_square("{" COLOUR "}").metal), 1, 1e-9);
    CHECK_NEAR(
        survey_square("{\"extensions\":{\"KHR_materials_unlit\":{}}}").unlit, 1,
        1e-9);
}

TEST(survey_of_extensions)
{
    save_texels(two);
    const ibl_scene_survey s = survey_square(
        "{\"pbrMetallicRoughness\":{\"metallicFactor\":0,"
        "\"roughnessFactor\":0.5},\"extensions\":{\"KHR_materials_clearcoat\":"
        "{\"clearcoatFactor\":0.5,\"clearcoatRoughnessFactor\":0.125},"
        "\"KHR_materials_sheen\":{\"sheenColorFactor\":[0.5,0.5,0.5],"
        "\"sheenRoughnessFactor\":0.75},\"KHR_materials_transmission\":{"
        "\"transmissionFactor\":0.25},\"KHR_materials_ior\":{\"ior\":3},"
        "\"KHR_materials_anisotropy\":{\"anisotropyStrength\":1}}}");

    /* F0 = ((3 - 1) / (3 + 1))^2 = 1/4 = mix(.04, 1, .21875) */
    CHECK_NEAR(s.metal[32].share, 0.21875, 1e-6);
    CHECK_NEAR(s.dielectric[32].share, 1 - 0.21875, 1e-6);
    CHECK_NEAR(s.dielectric[32].diffuse, 0.75 * (1 - 0.21875), 1e-6);
    CHECK_NEAR(s.clearcoat[8].power, 0.25, 1e-6);
    CHECK_NEAR(s.sheen[48].share, 1, 1e-6);
    CHECK_NEAR(s.transmission, 0.25, 1e-6);
    CHECK_NEAR(s.anisotropic, 1, 1e-6);
}

/* Three times the area counts three times as much. */
TEST(surveys_add_up)
{
    ibl_scene_survey survey = {0};

    ibl_scene *a = read_square(
        "\"materials\":[{\"pbrMetallicRoughness\":{\"roughnessFactor\":0}}]");
    NEED(!ibl_scene_survey_add(quiet, a, &survey));
    ibl_scene *b = read_square("\"materials\":[{}]");
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
    static const char *const text =
        "\"materials\":[" MR("") "],\"textures\":[{\"source\":0}],\"images\":"
                                 "[{\"uri\":\"x.png\"}]";
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
    static const char *const text =
        "\"materials\":[" MR("") "],\"textures\":[{\"source\":0}],\"images\":"
                                 "[{\"uri\":\"x.jpg\"}]";
    size_t size;

    if (!file_have("cjpeg"))
        test_skip("no cjpeg");
    NEED(file_run("{ echo P6 64 32 255; for i in $(seq 2048); do printf "
                  "'\\100\\200\\377'; done; } | cjpeg -quality 95 >x.jpg"));
    NEED(!ibl_scene_survey_add(quiet, read_square(text), &survey));
    CHECK_NEAR(ibl_survey_share(survey.metal), 1, 0.02);
    CHECK_NEAR(survey.metal[32].share, 1, 0.02);
    /* cut short in its pixels */
    NEED(file_run("{ echo P6 64 32 255; seq 9999 | head -c 6144; } | "
                  "cjpeg -quality 95 >x.jpg"));
    const unsigned char *jpeg = file_load(file_path("x.jpg"), &size);
    NEED(file_save(file_path("x.jpg"), jpeg, size - 500));
    CHECK(!ibl_scene_survey_add(quiet, read_square(text), &survey) &&
          strstr(kept.text[IBL_LOG_WARNING], "damaged"));
    /* four components in its frame, then the end of it */
    NEED(file_save(file_path("x.jpg"),
                   "\xff\xd8\xff\xc0\0\x14\x08\0\x08\0\x08\x04\x01\x11\0"
                   "\x02\x11\0\x03\x11\0\x04\x11\0\xff\xda\0\x0e\x04\x01\0"
                   "\x02\0\x03\0\x04\0\0\x3f\0",
                   40));
    CHECK(!ibl_scene_survey_add(quiet, read_square(text), &survey) &&
          strstr(kept.text[IBL_LOG_WARNING], "CMYK"));
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
        {"{\"asset\":{\"version\":\"1.0\"}}", "glTF 1.0: only", false},
        {"{\"meshes\":{}}", "glTF 1.0: only", false},
        {"[", "no glTF", false},
        {"{\"asset\":{\"version\":\"2.0\"}}", "it has no scenes", false},
        {"{\"asset\":{\"version\":\"2.0\"},\"scenes\":[{}]}",
         "has no triangles", false},
        {"{" BUFFER ",\"accessors\":[{\"bufferView\":0,\"componentType\":5126,"
         "\"count\":5,\"type\":\"VEC3\"}]," SCENE
         ",\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0}}]}]}",
         "5 elements of 12 bytes", false},
        {"{" BUFFER ",\"accessors\":[{\"componentType\":5126,"
         "\"count\":200000000,\"type\":\"VEC3\"}]," SCENE
         ",\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0}}]}]}",
         "million numbers", false},
        {"{" BUFFER "," ACCESSORS "," SCENE
         ",\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0},"
         "\"indices\":1}," STRIP "}]}]}",
         "expected 1 to 1 components", true},
        {"{" BUFFER "," ACCESSORS
         ",\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{\"children\":[0]}]}",
         "node 0 is in two places", false},
        {"{" BUFFER "," ACCESSORS ",\"scenes\":[{\"nodes\":[7,0]}],\"nodes\":[{"
         "\"mesh\":0}],\"meshes\":[{\"primitives\":[" STRIP "}]}]}",
         "expected 0, found 7", true},
        {"{\"asset\":{\"version\":\"2.0\"},\"scenes\":[{}],\"buffers\":[{"
         "\"byteLength\":4,\"uri\":\"data:;base64,AA\"}]}",
         "only 1", false},
        {"{\"asset\":{\"version\":\"2.0\"},\"scenes\":[{}],\"buffers\":[{"
         "\"byteLength\":4,\"uri\":\"data:;base64,A*A\"}]}",
         "no base64", false},
        {"{\"asset\":{\"version\":\"2.0\"},\"scenes\":[{}],\"buffers\":[{"
         "\"byteLength\":4,\"uri\":\"https://x.y/z\"}]}",
         "https://x.y/z cannot be read: No such", false},
        {"{" BUFFER "," ACCESSORS "," SCENE
         ",\"meshes\":[{\"primitives\":[" STRIP ",\"material\":0}]}]}",
         "no index", true},
        {"{" BUFFER "," ACCESSORS "," SCENE
         ",\"meshes\":[{\"primitives\":[" STRIP
         "}]}],\"materials\":[{\"pbrMetallicRoughness\":{\"roughnessFactor\":"
         "\"x\"}}]}",
         "expected a number", true},
        {"{" BUFFER "," ACCESSORS "," SCENE
         ",\"meshes\":[{\"primitives\":[" STRIP
         "}]}],\"images\":[{\"uri\":\"a/none.png\"}]}",
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
    static const char json[] =
        "{\"asset\":{\"version\":\"2.0\"},\"buffers\":[{\"byteLength\":76}],"
        "\"bufferViews\":[{\"buffer\":0,\"byteLength\":48}],\"accessors\":[{"
        "\"bufferView\":0,\"componentType\":5126,\"count\":4,\"type\":\"VEC3\""
        "}]," SCENE
        ",\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0}}]}]}";
    const size_t first = sizeof json - 1;
    unsigned char all[2048] = "glTF";
    size_t size, at = 20 + first;
    ibl_status status;

    save_mesh();
    const unsigned char *mesh = file_load(file_path("mesh.bin"), &size);
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

/* Assimp's models of glTF 2: those that have no triangles or are damaged on
 * purpose are refused, all others are read. */
TEST(models_of_assimp)
{
    static const char *const refused[] = {
        "IndexOutOfRange", "MissingBin", "RecursiveNodes", "SchemaFailures",
        "TestNoRootNode",  "Mode_00",    "Mode_01",        "Mode_02",
        "Mode_03",         "Mode_07",    "Mode_08",        "Mode_09",
        "Mode_10",         "badArray",   "WithInfinites",  NULL};
    char path[512];
    int count = 0;
    FILE *list = popen("find /usr/share/assimp/models/glTF2 -name '*.glb' -o "
                       "-name '*.gltf'",
                       "r");

    NEED(list);
    while (fgets(path, sizeof path, list)) {
        ibl_scene_survey survey = {0};
        ibl_status status;
        path[strcspn(path, "\n")] = '\0';
        ibl_scene *s = read_scene(path, &status);
        if (!status && !is_among(path, refused))
            status = ibl_scene_survey_add(quiet, s, &survey);
        CHECK_MSG(!status == !is_among(path, refused), "%s: %d: %s", path,
                  (int)status, kept.text[IBL_LOG_ERROR]);
        CHECK_MSG(!status == !*kept.text[IBL_LOG_ERROR], "%s", path);
        count++;
    }
    pclose(list);
    if (!count)
        test_skip("no package assimp-testmodels");
}
