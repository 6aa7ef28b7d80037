/* SPDX-License-Identifier: MIT */
/* Each call that returns a status refuses missing pointers, and options out of
 * range, in one line. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "ibl/io.h"
#include "ibl/probes.h"
#include "ibl/reference.h"
#include "ibl/set.h"
#include "maps.h"
#include "test.h"

static int lines;
static char last[512];

static void count_line(void *cookie, ibl_log_level level, const char *text)
{
    (void)cookie;
    lines += level == IBL_LOG_ERROR;
    snprintf(last, sizeof last, "%s", text);
}

/* With so many lines since the one before. */
static void expect(ibl_status status, int said, const char *call)
{
    CHECK_MSG(status == IBL_ERR_ARGUMENT, "%s: %s", call,
              ibl_status_text(status));
    CHECK_MSG(lines == said, "%s: %d lines", call, lines);
    lines = 0;
}

#define REFUSES(call) expect((call), 1, #call)
/* Where there is no context to tell. */
#define SILENT(call) expect((call), 0, #call)
/* Without one of its pointers at a time, from 1; 0 is the context, or what has
 * one. */
static int gone;
#define P(k, p) (gone == (k) ? NULL : (p))
#define EACH(count, call)                                                      \
    for (gone = 0; gone <= (count); gone++)                                    \
    expect((call), gone > 0, #call)
/* With the default options but for what is set; the line has these words. */
#define OUT_OF_RANGE(options, set, call, words)                                \
    do {                                                                       \
        o = options;                                                           \
        set;                                                                   \
        expect((call), 1, #set);                                               \
        CHECK_MSG(strstr(last, words), "%s: %s", #set, last);                  \
    } while (0)

static ibl_ctx *counting(void)
{
    ibl_ctx_options o = ibl_ctx_options_default();
    o.threads = 1;
    o.log = count_line;
    lines = 0;
    return test_ctx_of(&o);
}

#define CONTEXT(set, words)                                                    \
    OUT_OF_RANGE(ibl_ctx_options_default(), (set, o.log = count_line),         \
                 ibl_ctx_create(&o, &none_made), words)

TEST(contexts_and_images)
{
    ibl_ctx *ctx = counting(), *none_made;
    ibl_ctx_options o = ibl_ctx_options_default();
    ibl_image map = map_constant(ctx, 16, 8, 1),
              none = {.width = 16, .height = 8};
    ibl_cube cube, hollow = {.size = 8, .levels = 1};
    ibl_specular_options s = ibl_specular_options_default();
    ibl_specular_layout layout;
    ibl_light light;
    int count;

    o.log = count_line;
    REFUSES(ibl_ctx_create(&o, NULL));
    CONTEXT(o.threads = -1, "-1 threads");
    CONTEXT(o.threads = 1025, "1025 threads");
    CONTEXT(o.isa = (ibl_isa)-1, "instruction set -1");
    CONTEXT(o.isa = IBL_ISA_COUNT, "instruction set 5");
    SILENT(ibl_ctx_create(NULL, NULL));
    EACH(1, ibl_image_alloc(P(0, ctx), 2, 1, P(1, &none)));
    EACH(1, ibl_cube_alloc(P(0, ctx), 8, 1, P(1, &hollow)));
    EACH(1, ibl_cube_alloc_as(P(0, ctx), IBL_PROJECTION_EQUIRECT, 8, 1,
                              P(1, &hollow)));
    NEED(!ibl_cube_alloc(ctx, 8, 4, &cube));
    EACH(2, ibl_cube_from_latlong(P(0, ctx), P(1, &map), 0, P(2, &cube)));
    REFUSES(ibl_cube_from_latlong(ctx, &none, 0, &cube));
    REFUSES(ibl_cube_from_latlong(ctx, &map, 0, &hollow));
    EACH(2, ibl_flat_from_latlong(P(0, ctx), P(1, &map), 0, P(2, &cube)));
    EACH(1, ibl_cube_from_flat(P(0, ctx), P(1, &cube), &hollow));
    REFUSES(ibl_cube_from_flat(ctx, &cube, &hollow));
    EACH(2, ibl_latlong_from_cube(P(0, ctx), P(1, &cube), P(2, &map)));
    REFUSES(ibl_latlong_from_cube(ctx, &hollow, &map));
    REFUSES(ibl_latlong_from_cube(ctx, &cube, &none));
    REFUSES(ibl_cube_build_mips(ctx, NULL));
    REFUSES(ibl_cube_build_mips(ctx, &hollow));
    SILENT(ibl_cube_build_mips(NULL, &cube));
    EACH(3, ibl_image_take_lights(P(0, ctx), P(1, &map), 0, 1, P(2, &light),
                                  P(3, &count)));
    REFUSES(ibl_image_take_lights(ctx, &none, 0, 1, &light, &count));
    SILENT(ibl_specular_layout_of(NULL, &layout));
    SILENT(ibl_specular_layout_of(&s, NULL));
    ibl_cube_free(&cube);
}

TEST(bakes)
{
    ibl_ctx *ctx = counting();
    ibl_image map = map_constant(ctx, 16, 8, 1),
              none = {.width = 16, .height = 8};
    const ibl_environment env = {.image = &map}, hollow = {.image = &none},
                          silent = {.width = 16, .height = 8};
    const ibl_cube level0 = {.size = 8, .levels = 1};
    ibl_bake_options o = ibl_bake_options_default();
    ibl_bake_result result;
    ibl_cube cube;
    ibl_lobe_table lobes = {0};
    ibl_lut lut;
    double sh[27];

    EACH(2, ibl_bake_specular(P(0, ctx), P(1, &map), NULL, P(2, &cube), NULL));
    REFUSES(ibl_bake_specular(ctx, &none, NULL, &cube, NULL));
    EACH(2, ibl_bake_irradiance(P(0, ctx), P(1, &map), NULL, P(2, &cube)));
    REFUSES(ibl_bake_irradiance(ctx, &none, NULL, &cube));
    EACH(2, ibl_bake_sh(P(0, ctx), P(1, &map), 2, 0, P(2, sh)));
    REFUSES(ibl_bake_sh(ctx, &none, 2, 0, sh));
    EACH(2, ibl_bake_environment(P(0, ctx), P(1, &env), NULL, P(2, &result)));
    REFUSES(ibl_bake_environment(ctx, &hollow, NULL, &result));
    REFUSES(ibl_bake_environment(ctx, &silent, NULL, &result));
    o.specular_options.size = 8;
    o.level0 = &level0;
    REFUSES(ibl_bake_environment(ctx, &env, &o, &result));
    EACH(1, ibl_bake_lut(P(0, ctx), NULL, P(1, &lut)));
    EACH(1, ibl_bake_lobe_table(P(0, ctx), NULL, P(1, &lobes)));
}

#define SPECULAR(set, words)                                                   \
    OUT_OF_RANGE(usual, set, ibl_bake_specular(ctx, &map, &o, &cube, NULL),    \
                 words)

TEST(specular_options)
{
    ibl_ctx *ctx = counting();
    const ibl_image map = map_constant(ctx, 4, 2, 1);
    ibl_specular_options usual = ibl_specular_options_default(), o;
    ibl_specular_layout layout;
    ibl_cube cube = {0};

    usual.method = IBL_METHOD_SAMPLED;
    usual.size = 16;
    usual.levels = 2;
    SPECULAR(o.size = 0, "size 0");
    SPECULAR(o.size = 99999, "99999");
    SPECULAR(o.levels = 6, "6 levels");
    SPECULAR(o.levels = -1, "-1 levels");
    SPECULAR(o.samples = 0, "0 samples");
    SPECULAR(o.samples = 1048577, "1048577");
    SPECULAR(o.lod_bias = 4.5, "4.5");
    SPECULAR(o.lod_bias = -(double)INFINITY, "bias");
    SPECULAR(o.yaw_deg = (double)INFINITY, "yaw");
    SPECULAR(o.mapping = (ibl_roughness_map)7, "mapping 7");
    SPECULAR(o.tolerance = 2, "tolerance of 2");
    SPECULAR(o.tolerance = (double)NAN, "tolerance");
    SPECULAR(o.roughness_min = -0.1, "roughness range");
    SPECULAR(o.roughness_max = 1.1, "roughness range");
    SPECULAR(o.roughness_max = (double)NAN, "roughness range");
    SPECULAR(o.roughness_min = o.roughness_max, "2 levels");
    SPECULAR((o.roughness_min = 0.6, o.roughness_max = 0.5), "roughness range");
    SILENT(ibl_specular_layout_of(&o, &layout));
    o = usual;
    o.projection = IBL_PROJECTION_OCTAHEDRAL;
    REFUSES(ibl_bake_specular(ctx, &map, &o, &cube, NULL)); /* by samples */
    CHECK(!cube.data);
}

#define IRRADIANCE(set, words)                                                 \
    OUT_OF_RANGE(ibl_irradiance_options_default(), set,                        \
                 ibl_bake_irradiance(ctx, &map, &o, &cube), words)

TEST(irradiance_options)
{
    ibl_ctx *ctx = counting();
    const ibl_image map = map_constant(ctx, 4, 2, 1);
    ibl_irradiance_options o;
    ibl_cube cube = {0};
    double sh[3];

    IRRADIANCE(o.size = 0, "size 0");
    IRRADIANCE(o.size = IBL_MAX_CUBE_SIZE + 1, "size");
    IRRADIANCE(o.step = 0.6, "0.6");
    IRRADIANCE(o.step = -0.1, "-0.1");
    IRRADIANCE(o.step = (double)NAN, "step");
    IRRADIANCE(o.yaw_deg = (double)INFINITY, "yaw");
    IRRADIANCE((o.projection = IBL_PROJECTION_OCTAHEDRAL, o.step = 0.1), "");
    o = ibl_irradiance_options_default();
    o.step = 1e-9;
    CHECK(ibl_bake_irradiance(ctx, &map, &o, &cube) == IBL_ERR_MEMORY);
    CHECK(strstr(last, "hemisphere") && !cube.data);
    lines = 0;
    REFUSES(ibl_bake_sh(ctx, &map, -1, 0, sh));
    REFUSES(ibl_bake_sh(ctx, &map, IBL_MAX_SH_DEGREE + 1, 0, sh));
    REFUSES(ibl_bake_sh(ctx, &map, 0, (double)NAN, sh));
}

#define LUT(set, words)                                                        \
    OUT_OF_RANGE(ibl_lut_options_default(), set, ibl_bake_lut(ctx, &o, &lut),  \
                 words)

TEST(lut_options)
{
    ibl_ctx *ctx = counting();
    ibl_lut_options o;
    ibl_lut lut = {0};

    LUT(o.size = 0, "size 0");
    LUT(o.size = 4097, "4097");
    LUT(o.samples = -1, "-1");
    LUT(o.samples = 1048577, "1048577");
    LUT(o.kind = (ibl_lut_kind)3, "3");
    LUT((o.kind = IBL_LUT_CHARLIE, o.samples = 4), "samples");
    LUT(o.geometry = (ibl_geometry)9, "9");
    CHECK(!lut.data);
}

#define LOBES(set, words)                                                      \
    OUT_OF_RANGE(ibl_lobe_table_options_default(), set,                        \
                 ibl_bake_lobe_table(ctx, &o, &lobes), words)

TEST(lobe_table_options)
{
    ibl_ctx *ctx = counting();
    ibl_lobe_table_options o;
    ibl_lobe_table lobes = {0};

    LOBES(o.size = 3, "must be 4 to 256");
    LOBES(o.size = 257, "must be 4 to 256");
    LOBES(o.f0 = (ibl_f0)3, "");
    LOBES(o.layout.levels = 0, "");
    LOBES(o.layout.size = 0, "from 0 texels");
    LOBES(o.layout.roughness[3] = o.layout.roughness[2] - 0.1, "rising");
    CHECK(!lobes.data);
}

#define BAKE(set, words)                                                       \
    OUT_OF_RANGE(ibl_bake_options_default(), set,                              \
                 ibl_bake_environment(ctx, &env, &o, &out), words)

TEST(bake_options)
{
    ibl_ctx *ctx = counting();
    ibl_image map = map_constant(ctx, 8, 4, 1);
    const ibl_environment env = {.image = &map};
    const ibl_environment empty = {.width = 0, .height = 4, .cookie = &map};
    ibl_specular_options more[IBL_MAX_MORE_CHAINS + 1];
    ibl_bake_options o = ibl_bake_options_default();
    ibl_bake_result out = {0};
    ibl_cube cube = {0};
    ibl_light light;
    int count;

    for (int i = 0; i <= IBL_MAX_MORE_CHAINS; i++)
        more[i] = o.specular_options;
    REFUSES(ibl_bake_environment(ctx, &empty, NULL, &out));
    BAKE(o.yaw_deg = (double)NAN, "yaw");
    BAKE(o.sh_degree = IBL_MAX_SH_DEGREE + 1, "65");
    BAKE(o.level0 = &(ibl_cube){.size = 8}, "a level 0 of size 8");
    BAKE(o.skybox = IBL_MAX_CUBE_SIZE + 1, "size");
    BAKE(o.skybox = -1, "size -1");
    BAKE(o.specular_options.size = 0, "size 0");
    BAKE(o.specular_options.method = (ibl_method)9, "method 9");
    BAKE(o.irradiance_options.step = 9, "9");
    BAKE(o.more_count = 1, "1 more specular chains");
    BAKE((o.more = more, o.more_count = IBL_MAX_MORE_CHAINS + 1),
         "32 more specular chains");
    more[0].tolerance = 0;
    BAKE((o.more = more, o.more_count = 1), "a tolerance of 0");
    CHECK(!out.more && !out.specular.data && !out.sh);
    o = ibl_bake_options_default();
    o.specular_options.size = 12;
    o.specular_options.levels = 4;
    o.specular_options.projection = IBL_PROJECTION_OCTAHEDRAL;
    REFUSES(ibl_bake_environment(ctx, &env, &o, &out));
    REFUSES(ibl_cube_alloc_as(ctx, (ibl_projection)3, 8, 1, &cube));
    NEED(!ibl_cube_alloc_as(ctx, IBL_PROJECTION_EQUIRECT, 8, 1, &cube));
    REFUSES(ibl_cube_from_latlong(ctx, &map, 0, &cube));
    REFUSES(ibl_cube_build_mips(ctx, &cube));
    REFUSES(ibl_flat_from_latlong(ctx, &map, (double)INFINITY, &cube));
    ibl_cube_free(&cube);
    REFUSES(ibl_image_take_lights(ctx, &map, 0, 0, &light, &count));
    REFUSES(ibl_image_take_lights(ctx, &map, (double)NAN, 1, &light, &count));
    CHECK(count == 0);
}

TEST(references)
{
    ibl_ctx *ctx = counting();
    ibl_image map = map_constant(ctx, 16, 8, 1),
              none = {.width = 16, .height = 8};
    const double dir[3] = {0, 1, 0}, one = 1;
    const ibl_texel texel = {0, 0, 0};
    const ibl_geometry smith = IBL_GEOMETRY_SMITH;
    ibl_reference *ref;
    double rgb[3], sums[IBL_REFERENCE_BRDF];

    EACH(2, ibl_reference_create(P(0, ctx), P(1, &map), 0, P(2, &ref)));
    REFUSES(ibl_reference_create(ctx, &none, 0, &ref));
    NEED(!ibl_reference_create(ctx, &map, 0, &ref));
    EACH(2, ibl_reference_lobe(P(0, ref), IBL_LOBE_GGX, 1, P(1, dir), 1,
                               P(2, rgb)));
    REFUSES(ibl_reference_lobe(ref, IBL_LOBE_PHONG, 1, NULL, 1, rgb));
    REFUSES(ibl_reference_lobe(ref, IBL_LOBE_PHONG, 1, dir, 1, NULL));
    EACH(4, ibl_reference_brdf(P(0, ref), smith, P(1, &one), 1, P(2, dir),
                               P(3, dir), 1, P(4, sums)));
    EACH(2, ibl_reference_irradiance(P(0, ref), P(1, dir), 1, P(2, rgb)));
    EACH(2, ibl_reference_texels(P(0, ref), IBL_PROJECTION_CUBE, 4, 4,
                                 P(1, &texel), 1, P(2, rgb)));
    EACH(1, ibl_reference_sh(P(0, ref), 0, P(1, rgb)));
    EACH(1, ibl_reference_mean(P(0, ref), P(1, rgb)));
    EACH(1, ibl_reference_lut(P(0, ctx), 1, 1, IBL_GEOMETRY_SMITH, P(1, rgb)));
    EACH(1, ibl_reference_sheen(P(0, ctx), 1, 1, P(1, rgb)));
    ibl_reference_free(ref);
}

TEST(reading)
{
    ibl_ctx *ctx = counting();
    static const char hdr[] = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n"
                              "-Y 1 +X 2\n\1\1\1\1\1\1\1\1";
    ibl_image img;
    ibl_texture tex;
    ibl_source *source;

    EACH(2, ibl_image_read(P(0, ctx), P(1, "-"), NULL, P(2, &img), NULL));
    EACH(2, ibl_image_decode(P(0, ctx), P(1, "a"), hdr, sizeof hdr, NULL,
                             P(2, &img), NULL));
    REFUSES(ibl_image_decode(ctx, "a", NULL, 9, NULL, &img, NULL));
    EACH(2, ibl_source_open(P(0, ctx), P(1, "data/forest.exr"), NULL,
                            P(2, &source)));
    NEED(!ibl_source_open(ctx, test_data("forest.exr"), NULL, &source));
    REFUSES(ibl_source_read(source, 1, NULL));
    SILENT(ibl_source_read(NULL, 1, NULL));
    ibl_source_close(source);
    EACH(2, ibl_texture_read(P(0, ctx), P(1, "-"), P(2, &tex), NULL));
    EACH(3, ibl_texture_decode(P(0, ctx), P(1, "a"), P(2, hdr), 9, P(3, &tex),
                               NULL));
}

TEST(textures)
{
    ibl_ctx *ctx = counting();
    ibl_cube cube, no_cube = {.size = 4, .levels = 1};
    float texels[2] = {0, 0};
    ibl_lut lut = {1, texels, 0}, no_lut = {1, NULL, 0};
    const ibl_lobe_table no_lobes = {.size = 8};
    ibl_texture tex, none, out;
    void *bytes;
    size_t size;

    NEED(!ibl_cube_alloc(ctx, 4, 1, &cube));
    for (int i = 0; i < 3 * 96; i++)
        cube.data[i] = 1;
    EACH(2,
         ibl_texture_from_cube(P(0, ctx), P(1, &cube), NULL, P(2, &tex), NULL));
    REFUSES(ibl_texture_from_cube(ctx, &no_cube, NULL, &tex, NULL));
    EACH(2, ibl_texture_from_lut(P(0, ctx), P(1, &lut), IBL_PIXEL_RG16F,
                                 P(2, &tex), NULL));
    REFUSES(ibl_texture_from_lut(ctx, &no_lut, IBL_PIXEL_RG16F, &tex, NULL));
    EACH(2,
         ibl_texture_from_lobe_table(P(0, ctx), P(1, &no_lobes), P(2, &tex)));
    REFUSES(ibl_texture_from_lobe_table(ctx, &no_lobes, &tex));

    NEED(!ibl_texture_from_cube(ctx, &cube, NULL, &tex, NULL));
    none = tex;
    none.data = NULL;
    EACH(2, ibl_texture_to_cube(P(0, ctx), P(1, &tex), P(2, &cube)));
    REFUSES(ibl_texture_to_cube(ctx, &none, &cube));
    EACH(2, ibl_texture_to_lut(P(0, ctx), P(1, &tex), P(2, &lut)));
    REFUSES(ibl_texture_to_lut(ctx, &none, &lut));
    EACH(2, ibl_texture_set_alpha(P(0, ctx), P(1, &tex), P(2, &cube)));
    REFUSES(ibl_texture_set_alpha(ctx, &none, &cube));
    REFUSES(ibl_texture_set_alpha(ctx, &tex, &no_cube));
    EACH(2, ibl_texture_get_alpha(P(0, ctx), P(1, &tex), P(2, &no_cube)));
    REFUSES(ibl_texture_get_alpha(ctx, &none, &no_cube));
    REFUSES(ibl_texture_layer(ctx, NULL, 0, &out));
    REFUSES(ibl_texture_layer(ctx, &none, 0, &out));
    REFUSES(ibl_texture_layer(ctx, &tex, 0, NULL));
    REFUSES(ibl_texture_array_begin(ctx, NULL, 2, &out));
    REFUSES(ibl_texture_array_begin(ctx, &none, 2, &out));
    REFUSES(ibl_texture_array_begin(ctx, &tex, 2, NULL));
    REFUSES(ibl_texture_array_put(ctx, NULL, 0, &tex));
    REFUSES(ibl_texture_array_put(ctx, &none, 0, &tex));
    REFUSES(ibl_texture_array_put(ctx, &tex, 0, NULL));
    EACH(3, ibl_texture_set(P(0, ctx), P(1, &tex), P(2, "k"), P(3, "v")));
    EACH(3, ibl_texture_encode(P(0, ctx), P(1, &tex), IBL_CONTAINER_DDS,
                               P(2, &bytes), P(3, &size)));
    REFUSES(ibl_texture_encode(ctx, &none, IBL_CONTAINER_DDS, &bytes, &size));
    ibl_texture_free(&tex);
    ibl_cube_free(&cube);
}

TEST(files)
{
    const ibl_container dds = IBL_CONTAINER_DDS;
    ibl_ctx *ctx = counting();
    ibl_texture none = {0};
    ibl_probe_index index;
    const ibl_sidecar_options facts = ibl_sidecar_options_default();
    const ibl_sidecar_output output = {.content = IBL_CONTENT_IRRADIANCE};
    char *text;
    ibl_set set;
    ibl_outputs *out;

    EACH(1, ibl_outputs_create(P(0, ctx), 0, P(1, &out)));
    NEED(!ibl_outputs_create(ctx, 0, &out));
    EACH(1, ibl_outputs_mkdir(P(0, out), P(1, "x")));
    EACH(1, ibl_outputs_add(P(0, out), P(1, "x"), "", 0));
    REFUSES(ibl_outputs_add(out, "x", NULL, 1));
    EACH(2, ibl_outputs_take_texture(P(0, out), P(1, "x"), P(2, &none), dds,
                                     NULL));
    SILENT(ibl_outputs_wait(NULL));
    SILENT(ibl_outputs_commit(NULL));
    ibl_outputs_free(out);
    EACH(2, ibl_sidecar_text(P(0, ctx), P(1, &facts), P(2, &text)));
    REFUSES(ibl_sidecar_text(ctx, &facts, &text));
    REFUSES(ibl_texture_describe(ctx, NULL, &facts, &output));
    REFUSES(ibl_texture_describe(ctx, &none, NULL, &output));
    REFUSES(ibl_texture_describe(ctx, &none, &facts, NULL));
    EACH(2, ibl_set_open(P(0, ctx), P(1, "x"), NULL, P(2, &set)));
    ibl_set_free(NULL);
    REFUSES(ibl_probe_index_read(ctx, NULL, &index));
    REFUSES(ibl_probe_index_read(ctx, "x", NULL));
    SILENT(ibl_probe_index_read(NULL, NULL, &index));
}
