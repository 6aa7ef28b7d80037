/* SPDX-License-Identifier: MIT */
/* What sidecars and keys say of facts that are made up, as iblbake(1) has it,
 * read by jansson; and what is refused. check-cli.sh and check_set judge what
 * the program says of its bakes. */
#include <jansson.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "files.h"
#include "ibl/sidecar.h"
#include "test.h"

static int lines;

static void count_line(void *cookie, ibl_log_level level, const char *text)
{
    lines += level == IBL_LOG_ERROR && !strchr(text, '\n');
    test_keep(cookie, level, text);
}

static ibl_ctx *counting(test_messages *kept)
{
    ibl_ctx_options o = ibl_ctx_options_default();

    o.threads = 1;
    o.log = count_line;
    o.log_cookie = kept;
    lines = 0;
    return test_ctx_of(&o);
}

static const ibl_read_report no_report;
static const ibl_bake_result no_bake;

/* As little as there can be. */
static ibl_sidecar_options least(void)
{
    ibl_sidecar_options o = ibl_sidecar_options_default();

    o.source = "a map";
    o.report = &no_report;
    o.made = &no_bake;
    return o;
}

/* ---- what is said -------------------------------------------------------- */

/* Made up, and no two alike. */
static const double sh[12] = {1,   2,   3,   0.1, 0.2, 0.3,
                              0.4, 0.5, 0.6, 0.7, 0.8, 0.9};
static const ibl_read_options read_as = {.primaries = IBL_PRIMARIES_ACESCG,
                                         .exposure = 1.5,
                                         .clamp = 90,
                                         .transfer = IBL_TRANSFER_LINEAR,
                                         .face_order = {5, 4, 3, 2, 1, 0}};
static const ibl_read_report report = {.format = "OpenEXR, ZIP",
                                       .nonfinite = 3,
                                       .negative = 4,
                                       .peak = 70,
                                       .low_range = 1,
                                       .layout = IBL_INPUT_VCROSS,
                                       .primaries = {1, 2, 3, 4, 5, 6, 7, 8},
                                       .luma = {0.25, 0.5, 0.25},
                                       .outside = 5,
                                       .clamped = 6,
                                       .clamp_removed = 0.125,
                                       .hash = "0123"};
static const ibl_specular_options levels_as = {.size = 64,
                                               .roughness_min = 0.25,
                                               .roughness_max = 0.75,
                                               .tolerance = 0.001,
                                               .lod_bias = 0.5,
                                               .jitter = 1,
                                               .lobe = IBL_LOBE_CHARLIE};
static const ibl_irradiance_options matte_as = {.step = 0.125};
static const ibl_lut_options lut_as = {.samples = 64,
                                       .geometry = IBL_GEOMETRY_SCHLICK_IBL};
static const ibl_texel_options texels_as = {.quality = IBL_QUALITY_BEST,
                                            .overflow = IBL_OVERFLOW_CLIP};
static const ibl_light light = {
    {0, 0.6, 0.8}, 0.125, {3, 2, 1}, {300, 200, 100}};
static const ibl_overflow_report overflow = {7, {{0}, {2, 0.25, 0.5}}};
static const ibl_pixel_error error[2] = {{0.25, 0.5, 0}, {0.125, 0.0625, 0.5}};
#define TEXTURE(of, edge, count, sides, packed)                                \
    {                                                                          \
        .pixel = of, .width = edge, .height = edge, .levels = count,           \
        .layers = 1, .faces = sides, .zstd = packed                            \
    }
static const ibl_texture textures[] = {
    TEXTURE(IBL_PIXEL_BC6H, 8, 1, 6, 9), TEXTURE(IBL_PIXEL_RGBA16F, 4, 2, 1, 0),
    TEXTURE(IBL_PIXEL_RGB9E5, 2, 1, 6, 0), TEXTURE(IBL_PIXEL_RG16F, 3, 1, 1, 0),
    TEXTURE(IBL_PIXEL_RGBA32F, 5, 1, 1, 0)};
static const char *const more[] = {"there/b.png"};
static const ibl_sidecar_output outputs[] = {
    {IBL_CONTENT_SKYBOX, "a.ktx2", "ktx2", &textures[0], NULL, 10, "4567", NULL,
     0, IBL_PROJECTION_CUBE, &texels_as, NULL, NULL},
    {IBL_CONTENT_SPECULAR, "b.dds", "dds", &textures[1], NULL, 20, NULL, NULL,
     0, IBL_PROJECTION_OCTAHEDRAL, NULL, &overflow, error},
    {IBL_CONTENT_IRRADIANCE, "c.ktx", "ktx", &textures[2], "png", 0, NULL, more,
     1, IBL_PROJECTION_CUBE, NULL, NULL, NULL},
    {IBL_CONTENT_LUT, "d.ktx", "ktx", &textures[3], NULL, 0, NULL, NULL, 0,
     IBL_PROJECTION_CUBE, NULL, NULL, NULL},
    {IBL_CONTENT_LOBE_TABLE, "e.ktx", "ktx", &textures[4], NULL, 0, NULL, NULL,
     0, IBL_PROJECTION_CUBE, NULL, NULL, NULL}};
enum {
    OUTPUTS = sizeof outputs / sizeof *outputs
};
static const ibl_key_value options[] = {{"a\n\\", "\xff"}, {"sync", NULL}};
static const ibl_bake_result result = {
    .report = {{4, 2, {0.25, 0.75}, IBL_ROUGHNESS_LINEAR, 2, -0.5},
               {{0, 12, 0.0625}, {128, 0, -1}},
               32},
    .irradiance_degree = 7,
    .sh = (double *)(uintptr_t)sh};
static const ibl_lobe_table_options lobes_as = {
    .size = 5, .layout = {4, 2, {0.25, 0.75}, IBL_ROUGHNESS_LINEAR, 2, -0.5}};

static ibl_sidecar_options all_facts(void)
{
    return (ibl_sidecar_options){.source = "map.exr",
                                 .width = 30,
                                 .height = 20,
                                 .read = &read_as,
                                 .report = &report,
                                 .specular = &levels_as,
                                 .irradiance = &matte_as,
                                 .lut = &lut_as,
                                 .lobe_table = &lobes_as,
                                 .yaw_deg = 30,
                                 .axes = {IBL_MIRROR_X, IBL_UP_Z},
                                 .sh_degree = 1,
                                 .made = &result,
                                 .lights = &light,
                                 .light_count = 1,
                                 .outputs = outputs,
                                 .output_count = OUTPUTS,
                                 .revision = "r \xc3\xa9",
                                 .target = "\xfd",
                                 .more = "{\"mine\": {\"of\": \"a program\"}}",
                                 .options = options,
                                 .option_count = 2};
}

/* Mean luminance: sqrt(1 / 4 pi) (sh . luma) + light / 4 pi. Irradiance of a
 * degree: radiance times 1 and 2 / 3. Axes: (x, y, z) becomes (-x, -z, y). */
static const char wanted[] =
    "{'target': '\xef\xbf\xbd', 'source': {'path': 'map.exr', 'format': "
    "'OpenEXR, ZIP', 'width': 30, 'height': 20, 'peak': 70.0, "
    "'nonfinite_pixels': 3, 'negative_pixels': 4, 'low_range': true, "
    "'bridged': false, 'xxh3_128': '0123', 'primaries': [1.0, 2.0, 3.0, 4.0, "
    "5.0, 6.0, 7.0, 8.0], 'layout': 'vcross', 'face_order': "
    "'nz,pz,ny,py,nx,px'}, 'colour': {'primaries': 'acescg', 'exposure_ev': "
    "1.5, 'transfer': 'linear', 'outside_pixels': 5, 'clamp': 90.0, "
    "'clamped_pixels': 6, 'clamp_removed': 0.125}, 'options': {'a\\n\\\\': "
    "'\xef\xbf\xbd', 'sync': true}, 'environment': {'mean_luminance': "
    "0.723344527, 'luminance_weights': [0.25, 0.5, 0.25]}, 'orientation': "
    "{'yaw_deg': 30.0, 'mirror': 'x', 'up': 'z'}, 'outputs': [{'content': "
    "'skybox', 'file': 'a.ktx2', 'container': 'ktx2', 'pixel': 'bc6h', "
    "'width': 8, 'height': 8, 'faces': 6, 'bytes': 10, 'saturated': 0, "
    "'xxh3_128': '4567', 'zstd': 9, 'quality': 'best', 'overflow': 'clip', "
    "'levels': [{'size': 8}]}, {'content': 'specular', 'file': 'b.dds', "
    "'container': 'dds', 'pixel': 'rgba16f', 'width': 4, 'height': 4, "
    "'faces': 1, 'bytes': 20, 'saturated': 7, 'layout': 'octahedral', "
    "'overflow': 'spread', 'lobe': 'charlie', 'method': 'spectral', "
    "'mapping': 'linear', 'lod_scale': 2.0, 'lod_offset': -0.5, "
    "'roughness_range': [0.25, 0.75], 'whole_chain': {'size': 64, 'levels': "
    "4}, 'tolerance': 0.001, 'lookup_size': 32, 'lod_bias': 0.5, 'jitter': "
    "true, 'pdf_mip': false, 'levels': [{'size': 4, 'roughness': 0.25, "
    "'method': 'spectral', 'degree': 12, 'estimated_error': 0.0625, "
    "'pixel_error': {'nrmse': 0.25, 'relative': 0.5}}, {'size': 2, "
    "'roughness': 0.75, 'method': 'sampled', 'samples': 128, 'pixel_error': "
    "{'nrmse': 0.125, 'relative': 0.0625}, 'beyond': {'texels': 2, 'moved': "
    "0.25, 'lost': 0.5}}]}, {'content': 'irradiance', 'file': 'c.ktx', "
    "'container': 'ktx', 'pixel': 'png', 'width': 2, 'height': 2, 'faces': 6,"
    " 'bytes': 0, 'saturated': 0, 'files': ['c.ktx', 'b.png'], 'overflow': "
    "'spread', 'scale': 'E/pi', 'method': 'spectral', 'degree': 7, "
    "'step_rad': 0.125, 'levels': [{'size': 2}]}, {'content': 'brdf_lut', "
    "'file': 'd.ktx', 'container': 'ktx', 'pixel': 'rg16f', 'width': 3, "
    "'height': 3, 'faces': 1, 'bytes': 0, 'saturated': 0, 'axes': "
    "'u=N.V,v=roughness', 'geometry': 'schlick-ibl', 'method': 'hammersley', "
    "'samples': 64}, {'content': 'lobe_lut', 'file': 'e.ktx', 'container': "
    "'ktx', 'pixel': 'rgba32f', 'width': 5, 'height': 5, 'faces': 1, 'bytes':"
    " 0, 'saturated': 0, 'axes': 'u=N.V,v=roughness', 'layers': ['one tap, F0"
    " = 1', 'one tap, F0 = 0.04', 'four taps, F0 = 1', 'four taps, F0 = "
    "0.04'], 'level_roughness': [0.25, 0.75]}], 'sh': {'degree': 1, "
    "'radiance': [[1.0, 2.0, 3.0], [0.1, 0.2, 0.3], [0.4, 0.5, 0.6], [0.7, "
    "0.8, 0.9]], 'irradiance_scale': 'E/pi', 'irradiance': [[1.0, 2.0, 3.0], "
    "[0.0666666667, 0.133333333, 0.2], [0.266666667, 0.333333333, 0.4], "
    "[0.466666667, 0.533333333, 0.6]]}, 'lights': [{'direction': [0.0, -0.8, "
    "0.6], 'radius_rad': 0.125, 'radius_deg': 7.16197244, 'irradiance': [3.0,"
    " 2.0, 1.0], 'radiance': [300.0, 200.0, 100.0]}], 'gltf': {'asset': "
    "{'version': '2.0', 'generator': 'iblbake " IBL_VERSION
    "'}, 'extensionsUsed': "
    "['KHR_lights_punctual'], 'extensions': {'KHR_lights_punctual': "
    "{'lights': [{'type': 'directional', 'color': [1.0, 0.666666667, "
    "0.333333333], 'intensity': 3.0}]}}, 'scene': 0, 'scenes': [{'nodes': "
    "[0]}], 'nodes': [{'rotation': [0.447213595, 0.0, 0.0, 0.894427191], "
    "'extensions': {'KHR_lights_punctual': {'light': 0}}}]}, 'mine': {'of': "
    "'a program'}}";

/* The same values, numbers to 1e-6 of themselves. */
static void same_json(const json_t *a, const json_t *b, const char *at)
{
    const char *key;
    json_t *member;
    const char *in;

    if (json_is_object(a) && json_is_object(b)) {
        json_object_foreach((json_t *)(uintptr_t)a, key, member) same_json(
            member, json_object_get(b, key), test_text("%s/%s", at, key));
        json_object_foreach((json_t *)(uintptr_t)b, key, member)
            CHECK_MSG(json_object_get(a, key), "%s/%s is not there", at, key);
    } else if (json_is_array(a) && json_array_size(a) == json_array_size(b)) {
        for (size_t i = 0; i < json_array_size(a); i++)
            same_json(json_array_get(a, i), json_array_get(b, i),
                      test_text("%s/%zu", at, i));
    } else if (json_is_number(a) && json_is_number(b)) {
        const double x = json_number_value(a), y = json_number_value(b);
        CHECK_MSG(fabs(x - y) <= 1e-6 * fabs(y), "%s is %g, not %g", at, x, y);
    } else {
        in = json_string_value(a);
        CHECK_MSG(json_equal(a, b), "%s is another: %s", at, in ? in : "");
    }
}

TEST(every_fact)
{
    const ibl_sidecar_options o = all_facts();
    test_messages kept;
    char *text, *want = test_alloc(1, sizeof wanted);

    for (size_t i = 0; i < sizeof wanted; i++)
        want[i] = wanted[i] == '\'' ? '"' : wanted[i];
    NEED(!ibl_sidecar_text(counting(&kept), &o, &text));
    json_t *root = json_loads(text, JSON_REJECT_DUPLICATES, NULL);
    json_t *truth = json_loads(want, JSON_REJECT_DUPLICATES, NULL);
    const char *name = NULL, *revision = NULL;
    NEED(root && truth);
    CHECK(!json_unpack(root, "{s:{s:s s:s}}", "generator", "name", &name,
                       "revision", &revision) &&
          !strcmp(name, "iblbake") && !strcmp(revision, "r \xc3\xa9"));
    CHECK(text[strlen(text) - 1] == '\n');
    json_object_del(root, "generator");
    same_json(root, truth, "");
    json_decref(root);
    json_decref(truth);
    ibl_bytes_free(text);
}

/* The keys of each output; then those that follow from options alone. */
TEST(every_key)
{
    static const char *const want[2][OUTPUTS] = {
        {"clamp=90 content=skybox exposure=1.5 mirror=x pixel=bc6h "
         "primaries=acescg quality=best transfer=linear up=z yaw_deg=30 ",
         "clamp=90 content=specular degrees=12,0 estimate=0.0625,0 "
         "exposure=1.5 jitter=yes lights=1 lobe=charlie lod_bias=0.5 "
         "lod_offset=-0.5 lod_scale=2 mapping=linear method=spectral "
         "mirror=x pdf_mip=no primaries=acescg roughness=0.25,0.75 "
         "roughness_range=0.25:0.75 samples=0,128 tolerance=0.001 "
         "transfer=linear up=z yaw_deg=30 ",
         "clamp=90 content=irradiance exposure=1.5 irradiance_scale=E/pi "
         "lights=1 method=spectral mirror=x primaries=acescg step=0.125 "
         "transfer=linear up=z yaw_deg=30 ",
         "axes=u=N.V,v=roughness content=brdf_lut geometry=schlick-ibl "
         "method=hammersley samples=64 ",
         "axes=u=N.V,v=roughness content=lobe_lut layers=one tap, F0 = "
         "1;one tap, F0 = 0.04;four taps, F0 = 1;four taps, F0 = 0.04 "
         "roughness=0.25,0.75 "},
        {"content=skybox ",
         "content=specular lobe=charlie lod_offset=-1 lod_scale=4 "
         "mapping=linear roughness=0.25,0.5,0.75 ",
         "content=irradiance irradiance_scale=E/pi ",
         "axes=u=N.V,v=roughness content=brdf_lut geometry=schlick-ibl "
         "method=hammersley samples=64 ",
         "axes=u=N.V,v=roughness content=lobe_lut layers=one tap, F0 = "
         "1;one tap, F0 = 0.04;four taps, F0 = 1;four taps, F0 = 0.04 "
         "roughness=0.25,0.75 "}};
    test_messages kept;
    ibl_ctx *ctx = counting(&kept);

    for (int i = 0; i < 2 * OUTPUTS; i++) {
        ibl_sidecar_options o = all_facts();
        ibl_texture tex = {.pixel = textures[i % OUTPUTS].pixel};
        char got[2000] = "";
        if (i >= OUTPUTS)
            o.made = NULL;
        CHECK(!ibl_texture_describe(ctx, &tex, &o, &outputs[i % OUTPUTS]));
        for (int k = 0; k < tex.key_count; k++)
            snprintf(got + strlen(got), sizeof got - strlen(got), "%s=%s ",
                     tex.keys[k].key + strlen("iblbake."), tex.keys[k].value);
        CHECK_MSG(!strcmp(got, want[i / OUTPUTS][i % OUTPUTS]), "%d: %s", i,
                  got);
        ibl_texture_free(&tex);
    }
}

/* ---- what will not do ---------------------------------------------------- */

/* The least facts but for what is set are refused, in one line with words. */
#define REFUSED(call, set, words)                                              \
    do {                                                                       \
        ibl_sidecar_options o = least();                                       \
        ibl_sidecar_output of = {                                              \
            .file = "a", .container = "ktx2", .texture = &textures[0]};        \
        o.outputs = &of;                                                       \
        lines = 0;                                                             \
        set;                                                                   \
        CHECK((call) == IBL_ERR_ARGUMENT);                                     \
        CHECK_MSG(lines == 1 && test_said(&kept, words), "%s: %d lines: %s",   \
                  #set, lines, kept.text[IBL_LOG_ERROR]);                      \
    } while (0)
#define TEXT(set, words) REFUSED(ibl_sidecar_text(ctx, &o, &text), set, words)
/* Of one output. */
#define OUTPUT(set, words) TEXT((o.output_count = 1, set), words)
#define KEYS(set, words)                                                       \
    REFUSED(ibl_texture_describe(ctx, &tex, &o, &of), set, words)

TEST(wrong_facts_are_refused_in_one_line)
{
    static const ibl_texture none = {.levels = 0};
    static const ibl_key_value option = {"\xff", "1"};
    ibl_lobe_table_options table = lobes_as;
    ibl_texture tex = {0};
    test_messages kept;
    ibl_ctx *ctx = counting(&kept);
    char *text = "";

    TEXT(o.made = NULL, "made is NULL");
    TEXT(o.source = NULL, "source, report");
    TEXT(o.report = NULL, "source, report");
    TEXT(o.light_count = 65, "facts of a bake: lights: 65");
    TEXT(o.light_count = 1, "facts of a bake: lights: 1: must be -1 to 0");
    TEXT(o.output_count = -1, "bake: outputs: -1");
    TEXT(o.axes.mirror = (ibl_mirror)9, "mirror 9");
    TEXT((o.options = &option, o.option_count = 1), "a key is no UTF-8");
    TEXT(o.more = "[]", "more of a sidecar");
    TEXT(o.more = "{", "more of a sidecar");
    TEXT((o.made = &result, o.sh_degree = 65), "degree of sh: ");
    OUTPUT(of.texture = NULL, "texture is NULL");
    OUTPUT(of.texture = &none, "a: 0 levels: must be 1 to 15");
    OUTPUT(of.content = IBL_CONTENT_SPECULAR, "a: 1 levels: must be 1 to 0");
    OUTPUT(of.content = (ibl_content)5, "content 5: must be 0 to 4");
    OUTPUT(of.file = "\xff", "no UTF-8");
    KEYS(of.content = (ibl_content)5, "content 5: must be 0 to 4");
    KEYS(o.axes.mirror = (ibl_mirror)9, "mirror 9");
    table.f0 = (ibl_f0)3;
    KEYS(o.lobe_table = &table, "F0 of the lobe table: 3: must be 0 to 2");
    table.f0 = IBL_F0_BOTH;
    table.layout.levels = IBL_MAX_LEVELS + 1;
    KEYS(o.lobe_table = &table, "levels of the lobe table: 16");
    CHECK(!text && !tex.key_count);
}
