/* SPDX-License-Identifier: MIT */
/* ibl/ibl.glsl, and ibl/ibl.hlsl by way of SPIR-V, on what OSMesa has for a
 * GPU, against the same written out in double: each pixel of a draw is a
 * surface. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "brdf/ggx.h"
#include "files.h"
#include "shade.h"
#include "test.h"
#include "truth.h"
#include "view.h"
#include "view/gl.h"
#include "view/program.h"
#include "view/upload.h"

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
    DISC,
    SH2,
    SH4,
    NUMBERS,
    BENT,
    KINDS,
    OCTAHEDRAL = KINDS, /* lod and edge for roughness and metallic */
    EQUIRECT
};

static const char vertex_text[] =
    "void main() {\n"
    "    vec2 corner = vec2(gl_VertexID & 1, gl_VertexID >> 1);\n"
    "    gl_Position = vec4(4.0 * corner - 1.0, 0.0, 1.0);\n"
    "}\n";

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
    GLuint program, frame, vertices, textures[6];
    texel points[ROWS][COUNT], seen[COUNT];
    texel lobes[LAYERS][TABLE * TABLE];
    int layers; /* of it: LAYERS, or 2 of one F0 */
} on;

enum {
    SPECULAR,
    IRRADIANCE,
    BRDF,
    LOBE,
    POINTS,
    SEEN
};

/* ---- the same in double -------------------------------------------------- */

typedef struct lobe {
    double bend, lod, diffuse, half_distance;
} lobe;

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

static double table_at(int layer, int channel, double x, double y)
{
    const int last = TABLE - 1;

    x = clamp(x * TABLE - 0.5, 0, last);
    y = clamp(y * TABLE - 0.5, 0, last);
    const int i = (int)fmin(x, last - 1), j = (int)fmin(y, last - 1);
    const texel *t = on.lobes[layer] + j * TABLE + i;
    return mix(
        mix((double)t[0][channel], (double)t[1][channel], x - i),
        mix((double)t[TABLE][channel], (double)t[TABLE + 1][channel], x - i),
        y - j);
}

static lobe lobe_of(int kind, int i, double n_v)
{
    const double r = (double)on.points[A][i][0], m = (double)on.points[A][i][1];
    const float *chain = on.points[CHAIN][i];
    double q[4];

    if (kind == SPLIT)
        return (lobe){0, level(chain, r), 0, 0};
    if (kind == BENT)
        return (lobe){
            pow(r, 2.1 + 1.8 * n_v),
            level(chain, fmin(1, r * (0.75 + 0.28 * n_v + 0.27 * r * r))), 0,
            0};
    if (kind == FIT)
        return (lobe){
            mix(1.4, 3.3, m) * pow(r, 3) * (1 - r) * (1 - n_v),
            level(chain,
                  fmin(1, r * (mix(0.56, 0.68, m) + mix(0.53, 0.38, m) * n_v))),
            fmin(1, mix(0.4 + 0.8 * n_v, 1, m) *
                        pow(r, mix(2.3, 1.5, m) + mix(1.75, 1.95, m) * n_v)),
            0};
    const bool one = on.layers == 2;
    const int first = kind == TWO_TAPS ? (one ? 1 : 2) : 0;
    const int second = one ? first : first + 1;
    for (int k = 0; k < 4; k++)
        q[k] = mix(table_at(second, k, n_v, r), table_at(first, k, n_v, r), m);
    return (lobe){
        q[0], fmin(q[1] * (double)chain[2], level(chain, fmin(1.25 * r, 1))),
        q[2], q[3]};
}

static void cross(const double a[3], const double b[3], double c[3])
{
    for (int k = 0; k < 3; k++)
        c[k] =
            a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
}

static void unit(double v[3])
{
    const double length = sqrt(test_dot(v, v));

    for (int k = 0; k < 3; k++)
        v[k] /= length;
}

/* What one or two taps see. */
static void look(const lobe *q, const double n[3], const double v[3],
                 const double light[3], double seen[3])
{
    double taps[2][3], rgb[2][3];

    for (int i = 0; i < 2; i++) {
        const double bend =
            q->bend + (i ? q->half_distance : -q->half_distance);
        for (int k = 0; k < 3; k++)
            taps[i][k] = mix(2 * test_dot(n, v) * n[k] - v[k], n[k], bend);
        shade_cube(&set->specular, q->lod, taps[i], rgb[i]);
    }
    for (int k = 0; k < 3; k++)
        seen[k] = mix(0.5 * (rgb[0][k] + rgb[1][k]), light[k], q->diffuse);
}

static void widen(const float from[4], double to[3])
{
    for (int k = 0; k < 3; k++)
        to[k] = (double)from[k];
}

/* Cosines of a direction with normal and view, and of the half vector. */
typedef struct angles {
    double n_l, n_v, n_h, v_h;
} angles;

static angles angles_of(const double n[3], const double v[3], const double l[3])
{
    double h[3];

    for (int k = 0; k < 3; k++)
        h[k] = v[k] + l[k];
    unit(h);
    return (angles){test_dot(n, l), test_dot(n, v), fmax(test_dot(n, h), 0.05),
                    fmax(test_dot(v, h), 1e-3)};
}

/* Mean of GGX's D over the ellipse, by the root of its cubic, bisected. */
static double disc_d(const angles *s, double alpha, double a)
{
    const double scale = pow(s->n_h * alpha, 2);
    const double t = (1 - s->n_h * s->n_h) / scale, b = a / (s->v_h * s->v_h);
    const double x = fmin(pow(s->n_l - s->n_v, 2) /
                              (4 * fmax(1 - s->v_h * s->v_h, 1e-6) * scale),
                          t);
    const double m = 1 + t - a - b, n = a + b + b * x + a * (t - x) - a * b;
    double low = 1, high = 1 + t;

    for (int i = 0; i < 100; i++) {
        const double nu = 0.5 * (low + high);
        *(((nu - m) * nu - n) * nu < a * b ? &low : &high) = nu;
    }
    return sqrt((low + a) * (low + b)) / ((low * low + n) * low + 2 * a * b) /
           (IBL_PI * scale * s->n_h * s->n_h);
}

static double shown(double n_l, double radius)
{
    const double edge = sin(radius);

    return fabs(n_l) < edge ? pow(n_l + edge, 2) / (4 * edge) : fmax(n_l, 0);
}

/* Of a light with irradiance 1: reflection for F0, and irradiance / pi. */
static void reflect_disc(int i, double f0, double radius, double to[2])
{
    const double alpha = pow((double)on.points[A][i][0], 2);
    double n[3], v[3], l[3], mirror[3];

    widen(on.points[NORMAL][i], n);
    widen(on.points[VIEW][i], v);
    widen(on.points[LIGHT][i], l);
    unit(n);
    unit(v);
    unit(l);
    to[0] = 0;
    to[1] = shown(test_dot(n, l), radius) / IBL_PI;
    if (to[1] <= 0)
        return;
    const angles s = angles_of(n, v, l);
    const double a = pow(radius / alpha, 2) / (4 * pow(s.n_h, 3));
    const double share = a / (1 + a);
    for (int k = 0; k < 3; k++)
        mirror[k] = 2 * s.n_v * n[k] - v[k] - l[k];
    const double step =
        share * fmin(1, radius / fmax(sqrt(test_dot(mirror, mirror)), 1e-6));
    for (int k = 0; k < 3; k++)
        l[k] += step * mirror[k];
    unit(l);
    const angles at = angles_of(n, v, l);
    const double n_l = shown(at.n_l, radius * (1 - share));
    to[0] = n_l * disc_d(&s, alpha, a) * (at.v_h / at.n_h) / (s.v_h / s.n_h) *
            ibl_smith_visibility(n_l, s.n_v, alpha) *
            mix(f0, 1, ibl_fresnel_weight(at.v_h));
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
static void surface(int kind, int i, double result[4])
{
    const double f0 = (double)on.points[NORMAL][i][3];
    const view_sphere ball = {.f0 = {f0, 0.5 * f0, 1}, .albedo = {0.8, 0.5, 0}};
    const view_settings s = {.multiscatter = true};
    double n[3], v[3];
    shade_light light;

    widen(on.points[NORMAL][i], n);
    widen(on.points[VIEW][i], v);
    const double n_v = clamp(test_dot(n, v), 0, 1);
    shade_cube(&set->irradiance, 0, n, light.irradiance);
    shade_table(&set->lut, n_v, (double)on.points[A][i][0], light.table);
    const lobe q = lobe_of(kind, i, n_v);
    look(&q, n, v, light.irradiance, light.specular);
    shade_split_sum(&s, &ball, &light, result);
    result[3] = light.specular[1];
}

static void numbers(int i, double result[4])
{
    const double f0 = (double)on.points[NORMAL][i][3], f = (1.5 * f0 + 1) / 3;
    const double r = (double)on.points[A][i][0];
    double n[3], v[3], *rg = result + 2;

    widen(on.points[NORMAL][i], n);
    widen(on.points[VIEW][i], v);
    shade_table(&set->lut, clamp(test_dot(n, v), 0, 1), r, rg);
    result[0] = level(on.points[CHAIN][i], r);
    result[1] =
        clamp((f - 0.04) / 0.96 * (rg[0] + rg[1]) / (f * rg[0] + rg[1]), 0, 1);
}

static void expect(int kind, int i, double result[4])
{
    const double f0 = (double)on.points[NORMAL][i][3];
    double n[3], to[2];

    widen(on.points[NORMAL][i], n);
    result[3] = 1;
    if (kind < DISC || kind == BENT)
        surface(kind, i, result);
    else if (kind == NUMBERS)
        numbers(i, result);
    else if (kind != DISC)
        harmonics(kind == SH2 ? 2 : 4, n, result);
    for (int k = 0; k < 3 && kind == DISC; k++) {
        reflect_disc(i, k == 2 ? 1 : f0 * (1 - 0.5 * k),
                     (double)on.points[A][i][3], to);
        result[k] = (k + 1) * to[0];
        result[3] = 3 * to[1];
    }
}

/* ---- drawing ------------------------------------------------------------- */

static void bind(int unit, GLenum target, GLuint texture)
{
    gl.ActiveTexture(GL_TEXTURE0 + (GLenum)unit);
    gl.BindTexture(target, texture);
}

static void upload(int unit, int width, int height, const void *texels)
{
    bind(unit, GL_TEXTURE_2D, on.textures[unit]);
    gl.TexImage2D(GL_TEXTURE_2D, 0, GL_RGBA32F, width, height, 0, GL_RGBA,
                  GL_FLOAT, texels);
    view_gl_filter(GL_TEXTURE_2D, GL_NEAREST, 1);
}

static void upload_set(void)
{
    static const view_content contents[] = {VIEW_SPECULAR, VIEW_IRRADIANCE,
                                            VIEW_LUT};

    for (int i = 0; i < 3; i++) {
        gl.ActiveTexture(GL_TEXTURE0 + (GLenum)i);
        NEED(view_upload(&set->set.texture[contents[i]], false, "test"));
    }
    bind(LOBE, GL_TEXTURE_2D_ARRAY, on.textures[LOBE]);
    gl.TexImage3D(GL_TEXTURE_2D_ARRAY, 0, GL_RGBA32F, TABLE, TABLE, on.layers,
                  0, GL_RGBA, GL_FLOAT, on.lobes);
    view_gl_filter(GL_TEXTURE_2D_ARRAY, GL_LINEAR, 1);
    upload(POINTS, COUNT, ROWS, on.points);
}

/* SPIRV-Cross names a sampler by the texture and its state. */
static void bind_samplers(void)
{
    static const char *const names[] = {"specular", "irradiance", "brdf",
                                        "lobe", "points"};
    static const char *const forms[] = {
        "%s", "SPIRV_Cross_Combined%ss",
        "SPIRV_Cross_Combined%sSPIRV_Cross_DummySampler"};
    char name[128];

    gl.UseProgram(on.program);
    for (int i = 0; i < 15; i++) {
        snprintf(name, sizeof name, forms[i / 5], names[i % 5]);
        gl.Uniform1i(gl.GetUniformLocation(on.program, name), i % 5);
    }
}

static void begin(void)
{
    shade_begin(16, 16);
    memset(&on, 0, sizeof on);
    on.layers = LAYERS;
    gl.GenFramebuffers(1, &on.frame);
    gl.GenVertexArrays(1, &on.vertices);
    gl.GenTextures(6, on.textures);
}

static void draw(void)
{
    upload_set();
    upload(SEEN, COUNT, 1, NULL);
    bind_samplers();
    gl.BindFramebuffer(GL_FRAMEBUFFER, on.frame);
    gl.FramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D,
                            on.textures[SEEN], 0);
    gl.Viewport(0, 0, COUNT, 1);
    gl.BindVertexArray(on.vertices);
    gl.DrawArrays(GL_TRIANGLES, 0, 3);
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

static void use(const char *fragment)
{
    const view_shader_file files[] = {
        {"all.vert", {vertex_text}}, {"use.frag", {fragment}}, {NULL, {NULL}}};

    on.program = view_program_from(files, "", "all.vert", "use.frag");
    NEED(on.program);
}

static void use_glsl(void)
{
    use(test_text("%s%s%s", view_test_shader("ibl.glsl"),
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
    use(text_of(file_path("all.frag")));
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
    unit(v);
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

/* Channels 0..1, of the last one less, and 0 for some. */
static void random_lobes(void)
{
    test_random r = {9};

    for (int i = 0; i < LAYERS * TABLE * TABLE; i++)
        for (int k = 0; k < 4; k++)
            on.lobes[i / (TABLE * TABLE)][i % (TABLE * TABLE)][k] =
                (float)(k < 3 ? test_random_unit(&r)
                              : i % TABLE / 8 * test_random_unit(&r) / 4);
}

/* A sky with colours, of a few bands. */
static void bake(void)
{
    ibl_specular_options opts = ibl_specular_options_default();
    ibl_image map;

    NEED(!ibl_image_alloc(shade_ctx(), 64, 32, &map));
    for (int i = 0; i < 3 * map.width * map.height; i++)
        map.data[i] =
            1.0F + 0.9F * sinf((float)(i % 192) * 0.098F * (float)(1 + i % 3)) *
                       sinf((float)(i / 192) * 0.098F);
    opts.size = 32;
    shade_bake(set, &map, &opts);
    ibl_image_free(&map);
}

/* The worst of each kind; relative above 1. */
static void compare(void)
{
    double worst[KINDS] = {0}, result[4];

    for (int i = 0; i < COUNT; i++) {
        const int kind = i % KINDS;
        expect(kind, i, result);
        for (int k = 0; k < 4; k++) {
            const double off = fabs((double)on.seen[i][k] - result[k]) /
                               fmax(1, fabs(result[k]));
            worst[kind] = off <= worst[kind] ? worst[kind] : off;
        }
    }
    for (int kind = 0; kind < KINDS; kind++) {
        CHECK_MSG(worst[kind] < 1e-4, "kind %d differs by %g", kind,
                  worst[kind]);
        test_measured("shader", worst[kind], 1e-4);
    }
}

static void differential(void (*language)(void))
{
    begin();
    bake();
    random_lobes();
    random_points(1);
    language();
    for (on.layers = 2; on.layers <= LAYERS; on.layers += 2) {
        draw();
        compare();
    }
}

/* ---- tests --------------------------------------------------------------- */

TEST(glsl)
{
    differential(use_glsl);
}

TEST(hlsl)
{
    differential(use_hlsl);
}

/* ---- flat maps ----------------------------------------------------------- */

/* A texel of random colours, and what is beyond the edges: of an octahedral map
 * (x, y) beyond a border is at -x about it and 1 - y along it, each in 0..1. */
static const float *flat_texel(const ibl_cube *map, int level, int x, int y)
{
    const ibl_level_shape s =
        ibl_level_shape_of(map->projection, map->size >> level);
    const bool out_x = x < 0 || x >= s.width, out_y = y < 0 || y >= s.height;

    if (map->projection == IBL_PROJECTION_EQUIRECT) {
        x += out_y ? s.width / 2 : 0;
        x = (x + s.width) % s.width;
        y = y < 0 ? -1 - y : out_y ? 2 * s.height - 1 - y : y;
    } else {
        const int turned_x = out_y ? s.width - 1 - x : x;
        const int turned_y = out_x ? s.height - 1 - y : y;
        x = turned_x < 0          ? -1 - turned_x
            : turned_x >= s.width ? 2 * s.width - 1 - turned_x
                                  : turned_x;
        y = turned_y < 0           ? -1 - turned_y
            : turned_y >= s.height ? 2 * s.height - 1 - turned_y
                                   : turned_y;
    }
    return ibl_cube_face(map, level, 0) +
           3 * ((ptrdiff_t)y * s.width + (ptrdiff_t)x);
}

static void flat_bilinear(const ibl_cube *map, int level, const double at[2],
                          double rgb[3])
{
    const ibl_level_shape s =
        ibl_level_shape_of(map->projection, map->size >> level);
    const double x = at[0] * s.width - 0.5, y = at[1] * s.height - 0.5;
    const double p = x - floor(x), q = y - floor(y);

    rgb[0] = rgb[1] = rgb[2] = 0;
    for (int k = 0; k < 4; k++)
        for (int c = 0; c < 3; c++)
            rgb[c] += (k % 2 ? p : 1 - p) * (k / 2 ? q : 1 - q) *
                      (double)flat_texel(map, level, (int)floor(x) + k % 2,
                                         (int)floor(y) + k / 2)[c];
}

/* Directions, many of them at seams and poles, and the point they are at, the
 * octahedron's by its three symmetries. */
static void flat_point(ibl_projection projection, test_random *r, double d[3],
                       double at[2])
{
    random_unit(r, d);
    if (test_random_below(r, 2))
        d[test_random_below(r, 3)] *= 0.02;
    if (test_random_below(r, 4) == 0)
        d[0] *= 0.02, d[2] *= 0.02;
    unit(d);
    for (int k = 0; k < 3; k++)
        d[k] = (double)(float)d[k];
    at[0] = atan2(d[2], d[0]) / (2 * IBL_PI) + 0.5;
    at[1] = atan2(hypot(d[0], d[2]), d[1]) / IBL_PI;
    if (projection == IBL_PROJECTION_EQUIRECT)
        return;
    const double sum = fabs(d[0]) + fabs(d[1]) + fabs(d[2]);
    for (int k = 0; k < 2; k++) {
        const double own = d[2 * k] / sum, other = fabs(d[2 - 2 * k]) / sum;
        at[k] = 0.5 + 0.5 * (d[1] < 0 ? copysign(1 - other, own) : own);
    }
}

static void flat_lookups(ibl_projection projection, void (*language)(void))
{
    const int kind =
        projection == IBL_PROJECTION_OCTAHEDRAL ? OCTAHEDRAL : EQUIRECT;
    ibl_texture *tex = &set->set.texture[VIEW_LUT];
    test_random r = {31};
    static double at[COUNT][2];
    double worst = 0;
    ibl_cube map;

    begin();
    shade_constant(set, (float[]){0, 0, 0});
    random_points(3);
    NEED(!ibl_cube_alloc_as(shade_ctx(), projection, 16, 5, &map));
    map = test_cube(map);
    for (int l = 0; l < 5; l++) {
        const ibl_level_shape s = ibl_level_shape_of(projection, 16 >> l);
        for (int i = 0; i < 3 * s.width * s.height; i++)
            ibl_cube_face(&map, l, 0)[i] = (float)test_random_unit(&r);
    }
    ibl_texture_free(tex);
    const ibl_texel_options as = {.struct_size = sizeof as,
                                  .pixel = IBL_PIXEL_RGBA32F};
    NEED(!ibl_texture_from_cube(shade_ctx(), &map, &as, tex, NULL));
    for (int i = 0; i < COUNT; i++) {
        double d[3];
        flat_point(projection, &r, d, at[i]);
        put(on.points[NORMAL][i], d);
        on.points[A][i][0] =
            i % 3 ? (float)(4 * test_random_unit(&r)) : (float)(i % 5);
        on.points[A][i][1] = 32;
        on.points[A][i][2] = (float)kind;
    }
    language();
    draw();
    for (int i = 0; i < COUNT; i++) {
        const double lod = (double)on.points[A][i][0];
        const int low = (int)lod, high = low < 4 ? low + 1 : 4;
        double a[3], b[3];
        flat_bilinear(&map, low, at[i], a);
        flat_bilinear(&map, high, at[i], b);
        for (int c = 0; c < 3; c++)
            worst = fmax(worst, fabs((double)on.seen[i][c] -
                                     mix(a[c], b[c], lod - low)));
    }
    test_measured("flat lookup", worst, 1e-4);
    CHECK_MSG(worst < 1e-4, "%s: differs by %g",
              ibl_projection_name(projection), worst);
}

TEST(octahedral_maps_are_looked_up_without_seams)
{
    flat_lookups(IBL_PROJECTION_OCTAHEDRAL, use_glsl);
}

TEST(equirectangular_maps_are_looked_up_without_seams)
{
    flat_lookups(IBL_PROJECTION_EQUIRECT, use_glsl);
}

TEST(octahedral_maps_in_hlsl)
{
    flat_lookups(IBL_PROJECTION_OCTAHEDRAL, use_hlsl);
}

TEST(equirectangular_maps_in_hlsl)
{
    flat_lookups(IBL_PROJECTION_EQUIRECT, use_hlsl);
}

/* Under a constant sky every lobe sees that constant, to rounding. */
TEST(constant_sky)
{
    begin();
    shade_constant(set, (float[]){0.25F, 0.25F, 0.25F});
    random_lobes();
    random_points(2);
    use_glsl();
    draw();
    for (int i = 0; i < COUNT; i++)
        CHECK((i % KINDS > TWO_TAPS && i % KINDS != BENT) ||
              fabsf(on.seen[i][3] - 0.25F) < 6e-8F);
}

/* Discs on and about surfaces from mirrors to rough ones, at every angle. */
TEST(discs_are_finite)
{
    test_random r = {4};

    begin();
    shade_constant(set, (float[]){0, 0, 0});
    random_points(4);
    for (int i = 0; i < COUNT; i++) {
        const float at = (float)test_random_unit(&r);
        on.points[A][i][0] = at * at * at * (float)(i % 9 > 0);
        on.points[A][i][2] = DISC;
        on.points[A][i][3] = 0.1F * (float)(i % 3) * at;
    }
    use_glsl();
    draw();
    for (int i = 0; i < 4 * COUNT; i++)
        CHECK(on.seen[i / 4][i % 4] >= 0 && isfinite(on.seen[i / 4][i % 4]));
}

/* A disc by parts of it, without the closed form. */
static double by_parts(int i, double radius, double f0)
{
    enum {
        PARTS = 24
    };
    texel *l = &on.points[LIGHT][i], middle;
    double d[3], x[3], y[3], sum = 0, one[2];

    memcpy(middle, *l, sizeof middle);
    widen(middle, d);
    cross(d, fabs(d[0]) < 0.5 ? (double[]){1, 0, 0} : (double[]){0, 1, 0}, x);
    unit(x);
    cross(d, x, y);
    for (int k = 0; k < PARTS * PARTS; k++) {
        const double phi = 2 * IBL_PI * (k % PARTS + 0.5) / PARTS;
        const double s = radius * sqrt((k / PARTS + 0.5) / PARTS);
        for (int c = 0; c < 3; c++)
            (*l)[c] = (float)(cos(s) * d[c] +
                              sin(s) * (cos(phi) * x[c] + sin(phi) * y[c]));
        reflect_disc(i, f0, 0, one);
        sum += one[0] / (PARTS * PARTS);
    }
    memcpy(*l, middle, sizeof middle);
    return sum;
}

TEST(discs_are_their_parts)
{
    double square = 0, all = 0, one[2];

    begin();
    random_points(3);
    for (int i = 0; i < COUNT; i += 4) {
        const double radius = 0.005 + 0.03 * (i % 8 / 4);
        reflect_disc(i, 1, radius, one);
        const double parts = by_parts(i, radius, 1);
        square += pow(one[0] - parts, 2);
        all += parts * parts;
    }
    CHECK_MSG(sqrt(square / all) < 0.01, "off by %g", sqrt(square / all));
}
