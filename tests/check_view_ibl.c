/* SPDX-License-Identifier: MIT */
/* ibl/ibl.glsl, and ibl/ibl.hlsl by way of SPIR-V, on what OSMesa has for a
 * GPU, against the same written out in double: each pixel of a draw is a
 * surface. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "files.h"
#include "maps.h"
#include "shade.h"
#include "test.h"
#include "truth.h"
#include "view.h"
#include "view/gl.h"
#include "view/vector.h"

enum {
    COUNT = 2048, /* surfaces */
    ROWS = 6,     /* texels of each; the last row has the harmonics */
    TABLE = 16,   /* edge of the table of lobes */
    LAYERS = 4
};

/* What a texel of a surface is. */
enum {
    A, /* roughness, metallic, kind, radius of a light */
    NORMAL,
    VIEW,
    LIGHT,
    CHAIN,
    SH
};

enum {
    SPLIT,
    FIT,
    TABLE_LOBES,
    TWO_TAPS,
    THREE_TAPS,
    FOUR_TAPS,
    DISC,
    SH2,
    SH4,
    NUMBERS,
    BENT,
    KINDS,
    OCTAHEDRAL = KINDS, /* lod and edge for roughness and metallic */
    EQUIRECT
};

static const char glsl_text[] =
    "uniform samplerCube specular, irradiance;\n"
    "uniform sampler2D brdf, points;\n"
    "uniform sampler2DArray lobe;\n"
    "out vec4 result;\n"
    "void main()\n"
    "{\n"
    "    vec4 sh[25], p[5];\n"
    "    for (int i = 0; i < 25; i++)\n"
    "        sh[i] = texelFetch(points, ivec2(i, 5), 0);\n"
    "    for (int i = 0; i < 5; i++)\n"
    "        p[i] = texelFetch(points, ivec2(gl_FragCoord.x, i), 0);\n"
    "    result = seen_by(specular, irradiance, brdf, lobe, p[4], p[0], p[1],\n"
    "                     p[2], p[3], sh);\n"
    "}\n";

static const char hlsl_text[] =
    "TextureCube specular : register(t0), irradiance : register(t1);\n"
    "Texture2D brdf : register(t2), points : register(t4);\n"
    "Texture2DArray lobe : register(t3);\n"
    "SamplerState s : register(s0);\n"
    "float4 main(float4 at : SV_Position) : SV_Target\n"
    "{\n"
    "    float4 sh[25], p[5];\n"
    "    for (int i = 0; i < 25; i++)\n"
    "        sh[i] = points.Load(int3(i, 5, 0));\n"
    "    for (int k = 0; k < 5; k++)\n"
    "        p[k] = points.Load(int3(int(at.x), k, 0));\n"
    "    return seen_by(specular, s, irradiance, s, brdf, s, lobe, s, p[4],\n"
    "                   p[0], p[1], p[2], p[3], sh);\n"
    "}\n";

typedef float texel[4];

static shade_set *const set = &shade_sets[0];

static struct {
    GLuint program;
    view_image image;
    texel points[ROWS][COUNT], seen[COUNT], texels[LAYERS * TABLE * TABLE];
    ibl_lobe_table lobes; /* of the texels: LAYERS, or 2 of one F0 */
} on;

enum { /* units, after those of the set */
    LOBE = 3,
    POINTS
};

/* ---- the same in double -------------------------------------------------- */

static double clamp(double x, double low, double high)
{
    return fmin(fmax(x, low), high);
}

static double mix(double a, double b, double t)
{
    return a + (b - a) * t;
}

static double level(const float chain[4], double r)
{
    return clamp((chain[3] == 1 ? r * (2 - r) : r) * (double)chain[0] +
                     (double)chain[1],
                 0, (double)chain[2]);
}

static shade_lobe lobe_of(int kind, int i, double n_v)
{
    const double r = (double)on.points[A][i][0], m = (double)on.points[A][i][1];
    const float *chain = on.points[CHAIN][i];
    double q[4];

    if (kind == SPLIT)
        return (shade_lobe){0, level(chain, r), 0, 0, 1};
    if (kind == BENT)
        return (shade_lobe){
            pow(r, 2.1 + 1.8 * n_v),
            level(chain, fmin(1, r * (0.75 + 0.28 * n_v + 0.27 * r * r))), 0, 0,
            1};
    if (kind == FIT)
        return (shade_lobe){
            mix(3.1, 5.2, m) * pow(r, 3.5) * (1 - r) * (1 - n_v),
            level(chain,
                  r * (1 + clamp(3 * r, 0, 1) * (mix(0.55, 0.64, m) - 1 +
                                                 mix(0.54, 0.44, m) * n_v))),
            fmin(1,
                 (mix(0.49, 0.87, m) + mix(0.58, 0.43, m) * n_v) *
                     pow(fmax(r - 0.15, 0) / 0.85, mix(2.6, 1 + 2.5 * n_v, m))),
            0, 1};
    const int taps = kind - TABLE_LOBES + 1;
    ibl_lookup_lobes(&on.lobes, taps, m, n_v, r, q);
    return (shade_lobe){q[0], q[1] * (double)chain[2], q[2], q[3], taps};
}

static void widen(const float from[4], double to[3])
{
    for (int k = 0; k < 3; k++)
        to[k] = (double)from[k];
}

static void harmonics(int degree, const double n[3], double rgb[3])
{
    memset(rgb, 0, 3 * sizeof *rgb);
    for (int l = 0; l <= degree; l++)
        for (int m = -l; m <= l && l != 3; m++)
            for (int k = 0; k < 3; k++)
                rgb[k] +=
                    (double)on.points[SH][l * l + l + m][k] * truth_sh(l, m, n);
    for (int k = 0; k < 3; k++)
        rgb[k] = fmax(rgb[k], 0);
}

/* Karis 2013 and Fdez-Aguera 2019: shade_split_sum, of the use's material. */
static void expect(int kind, int i, double result[4])
{
    const double r = (double)on.points[A][i][0];
    const double radius = (double)on.points[A][i][3], edge = sin(radius);
    const double f0 = (double)on.points[NORMAL][i][3], f = (1.5 * f0 + 1) / 3;
    const view_sphere ball = {.f0 = {f0, 0.5 * f0, 1}, .albedo = {0.8, 0.5, 0}};
    const view_settings s = {.multiscatter = true};
    double n[3], v[3], l[3];
    shade_light light;

    widen(on.points[NORMAL][i], n);
    widen(on.points[VIEW][i], v);
    widen(on.points[LIGHT][i], l);
    const double n_v = clamp(test_dot(n, v), 0, 1), n_l = test_dot(n, l);
    const double *rg = light.table;
    ibl_lookup_lut(&set->lut, n_v, r, light.table);
    result[3] = 1;
    if (kind == NUMBERS) {
        result[0] = level(on.points[CHAIN][i], r);
        result[1] = clamp(
            (f - 0.04) / 0.96 * (rg[0] + rg[1]) / (f * rg[0] + rg[1]), 0, 1);
        memcpy(result + 2, rg, sizeof light.table);
    } else if (kind == SH2 || kind == SH4)
        harmonics(kind == SH2 ? 2 : 4, n, result);
    else if (kind == DISC) {
        for (int k = 0; k < 3; k++)
            result[k] = (k + 1) * ibl_disc_brdf(IBL_GEOMETRY_SMITH, r * r,
                                                ball.f0[k], radius, n, v, l);
        /* A part of it may be below. */
        result[3] =
            3 / M_PI *
            (fabs(n_l) < edge ? pow(n_l + edge, 2) / (4 * edge) : fmax(n_l, 0));
    } else {
        const shade_lobe q = lobe_of(kind, i, n_v);
        ibl_lookup_chain(&set->irradiance, n, 0, light.irradiance);
        shade_see(&set->specular, &q, n, v, light.irradiance, light.specular);
        shade_split_sum(&s, &ball, &light, result);
        result[3] = light.specular[1];
    }
}

/* ---- drawing ------------------------------------------------------------- */

/* SPIRV-Cross names a sampler by the texture and its state. */
static void draw(void)
{
    static const ibl_content contents[] = {
        IBL_CONTENT_SPECULAR, IBL_CONTENT_IRRADIANCE, IBL_CONTENT_LUT};
    static const char *const names[] = {"specular", "irradiance", "brdf",
                                        "lobe", "points"};
    static const char *const forms[] = {
        "%s", "SPIRV_Cross_Combined%ss",
        "SPIRV_Cross_Combined%sSPIRV_Cross_DummySampler"};
    char name[128];
    GLuint lobes;

    for (int i = 0; i < 3; i++) {
        gl.ActiveTexture(GL_TEXTURE0 + (GLenum)i);
        NEED(view_upload(&set->set.baked.file[contents[i]].texture, false,
                         "test"));
    }
    gl.GenTextures(1, &lobes);
    view_gl_bind(LOBE, GL_TEXTURE_2D_ARRAY, lobes);
    gl.TexImage3D(GL_TEXTURE_2D_ARRAY, 0, GL_RGBA32F, TABLE, TABLE,
                  on.lobes.layers, 0, GL_RGBA, GL_FLOAT, on.texels);
    view_gl_filter(GL_TEXTURE_2D_ARRAY, GL_LINEAR, 1);
    gl.ActiveTexture(GL_TEXTURE0 + POINTS);
    view_float_image(GL_RGBA, COUNT, ROWS, on.points[0][0]);
    NEED(view_image_make(&on.image, COUNT, 1));
    gl.UseProgram(on.program);
    for (int i = 0; i < 15; i++) {
        snprintf(name, sizeof name, forms[i / 5], names[i % 5]);
        gl.Uniform1i(gl.GetUniformLocation(on.program, name), i % 5);
    }
    gl.BindFramebuffer(GL_FRAMEBUFFER, on.image.framebuffer);
    gl.Viewport(0, 0, COUNT, 1);
    view_gl_draw_full(on.program);
    gl.ReadPixels(0, 0, COUNT, 1, GL_RGBA, GL_FLOAT, on.seen);
    NEED(view_gl_check("test"));
}

/* A text file of the tree, or of test_dir(). */
static const char *text_of(const char *path)
{
    size_t size;
    const unsigned char *bytes = file_load(path, &size);

    return test_text("%.*s", (int)size, (const char *)bytes);
}

static void use_glsl(void)
{
    on.program = view_test_program(
        test_text("%s%s%s", view_test_shader("ibl.glsl"),
                  text_of("tests/shader_use.glsl"), glsl_text));
}

/* By glslang to SPIR-V, by SPIRV-Cross to GLSL without its #version. */
static void use_hlsl(void)
{
    char tree[4096];

    if (!file_have("glslangValidator") || !file_have("spirv-cross"))
        test_skip("no glslangValidator or spirv-cross");
    NEED(getcwd(tree, sizeof tree));
    NEED(file_save(file_path("main.hlsl"), hlsl_text, strlen(hlsl_text)));
    NEED(file_run("sed -E -f '%s/include/ibl/hlsl.sed' "
                  "'%s/include/ibl/ibl.glsl' '%s/tests/shader_use.glsl' | "
                  "cat - main.hlsl >all.hlsl && "
                  "glslangValidator -D -e main -S frag -V "
                  "--auto-map-bindings -o all.spv all.hlsl && "
                  "spirv-cross all.spv --version 330 --no-es | "
                  "sed 1d >all.frag",
                  tree, tree, tree));
    on.program = view_test_program(text_of(file_path("all.frag")));
}

/* ---- what is drawn ------------------------------------------------------- */

static void put(float to[4], const double from[3])
{
    for (int k = 0; k < 3; k++)
        to[k] = (float)from[k];
}

static void random_unit(test_random *r, double v[3])
{
    do
        for (int k = 0; k < 3; k++)
            v[k] = test_random_between(r, -1, 1);
    while (test_dot(v, v) > 1 || test_dot(v, v) < 0.01);
    normalise3(v);
}

/* A direction above a surface, straight above some. */
static void random_above(test_random *r, const double n[3], double least,
                         double v[3])
{
    do
        random_unit(r, v);
    while (test_dot(v, n) < least || test_dot(v, n) > 0.999);
    if (test_random_below(r, 8) == 0)
        memcpy(v, n, 3 * sizeof *v);
}

static void random_points(int seed)
{
    test_random r = {(uint64_t)seed};
    double n[3], v[3], l[3];

    for (int i = 0; i < COUNT; i++) {
        random_unit(&r, n);
        random_above(&r, n, 0.02, v);
        random_above(&r, n, -0.1, l);
        put(on.points[NORMAL][i], n);
        put(on.points[VIEW][i], v);
        put(on.points[LIGHT][i], l);
        on.points[NORMAL][i][3] = (float)test_random_unit(&r);
        on.points[A][i][0] = (float)test_random_between(&r, 0.15, 1);
        on.points[A][i][1] = (float)test_random_unit(&r);
        on.points[A][i][2] = (float)(i % KINDS);
        on.points[A][i][3] = (float)(i / KINDS % 2 * test_random_unit(&r) / 20);
        on.points[CHAIN][i][0] = (float)(set->specular.levels - 1);
        on.points[CHAIN][i][2] = on.points[CHAIN][i][0];
        on.points[CHAIN][i][3] = (float)(i / KINDS % 2);
    }
    for (int i = 0; i < 25; i++)
        for (int k = 0; k < 3; k++)
            on.points[SH][i][k] =
                (float)(test_random_between(&r, -1, 1) / (1 + i) + (i == 0));
}

/* Relative above 1. */
static void compare(void)
{
    double worst = 0, result[4];

    for (int i = 0; i < COUNT; i++) {
        expect(i % KINDS, i, result);
        for (int k = 0; k < 4; k++) {
            const double off = fabs((double)on.seen[i][k] - result[k]) /
                               fmax(1, fabs(result[k]));
            CHECK_MSG(off < 1e-4, "kind %d differs by %g", i % KINDS, off);
            worst = fmax(worst, off);
        }
    }
    test_measured("shader", worst, 1e-4);
}

static void differential(void)
{
    test_random r = {9};

    shade_kind(set, IBL_ROUGHNESS_LINEAR, MAP_SMOOTH);
    /* Channels 0..1; the distance is less, and 0 in the layers of one tap. */
    for (int i = 0; i < LAYERS * TABLE * TABLE; i++)
        for (int k = 0; k < 4; k++)
            on.texels[i][k] = (float)(k < 3 ? test_random_unit(&r)
                                            : i / TABLE / TABLE / 2 *
                                                  test_random_unit(&r) / 4);
    random_points(1);
    for (int layers = 2; layers <= LAYERS; layers += 2) {
        on.lobes.layers = layers;
        draw();
        compare();
    }
}

/* ---- flat maps ----------------------------------------------------------- */

/* Random texels, in directions of which many are at seams and poles, against
 * the lookups of the library. */
static void flat_lookups(void)
{
    ibl_texture *tex = &set->set.baked.file[IBL_CONTENT_LUT].texture;
    const ibl_texel_options as = {.pixel = IBL_PIXEL_RGBA32F};

    for (int kind = OCTAHEDRAL; kind <= EQUIRECT; kind++) {
        test_random r = {31};
        double worst = 0;
        ibl_cube map;
        shade_constant(set, (float[]){0, 0, 0});
        random_points(3);
        NEED(!ibl_cube_alloc_as(shade_ctx(),
                                kind == OCTAHEDRAL ? IBL_PROJECTION_OCTAHEDRAL
                                                   : IBL_PROJECTION_EQUIRECT,
                                16, 5, &map));
        map = test_cube(map);
        for (int l = 0; l < 5; l++) {
            const ibl_level_shape shape =
                ibl_level_shape_of(map.projection, 16 >> l);
            for (int i = 0; i < 3 * shape.width * shape.height; i++)
                ibl_cube_face(&map, l, 0)[i] = (float)test_random_unit(&r);
        }
        ibl_texture_free(tex);
        NEED(!ibl_texture_from_cube(shade_ctx(), &map, &as, tex, NULL));
        for (int i = 0; i < COUNT; i++) {
            double d[3];
            random_unit(&r, d);
            if (test_random_below(&r, 2))
                d[test_random_below(&r, 3)] *= 0.02;
            if (test_random_below(&r, 4) == 0)
                d[0] *= 0.02, d[2] *= 0.02;
            normalise3(d);
            put(on.points[NORMAL][i], d);
            on.points[A][i][0] =
                (float)(i % 3 ? 4 * test_random_unit(&r) : i % 5);
            on.points[A][i][1] = 32;
            on.points[A][i][2] = (float)kind;
        }
        draw();
        for (int i = 0; i < COUNT; i++) {
            double d[3], rgb[3];
            widen(on.points[NORMAL][i], d);
            ibl_lookup_chain(&map, d, (double)on.points[A][i][0], rgb);
            for (int c = 0; c < 3; c++)
                worst = fmax(worst, fabs((double)on.seen[i][c] - rgb[c]));
        }
        test_measured("flat lookup", worst, 1e-4);
        CHECK_MSG(worst < 1e-4, "kind %d: differs by %g", kind, worst);
    }
}

static void all(void (*language)(void))
{
    shade_begin(16, 16);
    memset(&on, 0, sizeof on);
    on.lobes = (ibl_lobe_table){TABLE, on.texels[0], LAYERS};
    language();
    differential();
    flat_lookups();
    view_image_free(&on.image);
}

TEST(glsl)
{
    all(use_glsl);
}

TEST(hlsl)
{
    all(use_hlsl);
}
