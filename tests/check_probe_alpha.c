/* SPDX-License-Identifier: MIT */
/*
 * Captures with alpha, from `iblbake probes` to what a shader makes of the
 * arrays: the sums over the captures' own pixels in double, and what another
 * probe fills in.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "files.h"
#include "ibl/ibl.h"
#include "ibl/io.h"
#include "ibl/probes.h"
#include "ibl/reference.h"
#include "test.h"
#include "truth.h"

#define PI 3.14159265358979323846

enum {
    W = 256, /* of equirectangular captures */
    H = 128,
    FACE =
        64, /* of faces: twice what is baked, so that level 0 is their means */
    SIZE = 32, /* of what is baked */
    LEVELS = 4,
    IRRADIANCE = 8,
    PICKS = TEST_SANITIZED ? 24 : 150 /* texels of a level that are judged */
};

static ibl_ctx *ctx;
static const double hole[3] = {0.6, 0.3, 0.74}, veil[3] = {-1, 0.2, 0};
static const double hole_cosine = 0.85, veil_cosine = 0.9;

/* ---- what is captured -------------------------------------------------- */

static double cosine(const double a[3], const double b[3])
{
    double dot = 0, aa = 0, bb = 0;
    for (int k = 0; k < 3; k++) {
        dot += a[k] * b[k];
        aa += a[k] * a[k];
        bb += b[k] * b[k];
    }
    return dot / sqrt(aa * bb);
}

/* A hole, a place that is half seen, and bits of a few pixels in between. */
static float seen_at(const double d[3], int x, int y)
{
    if (cosine(d, hole) > hole_cosine)
        return 0;
    if (cosine(d, veil) > veil_cosine)
        return 0.5f;
    return d[1] < -0.5 && (x / 3 + y / 2) % 4 == 0 ? 0.25f : 1;
}

static float light(int probe, int k, const double d[3], int x, int y)
{
    const double wave = sin(3 * d[k] + probe) * cos(5 * d[(k + 1) % 3]);
    const double spots = (x / 4 * 7 + y / 4 * 13) % 11 == 0 ? 6 : 0;
    return (float)(probe ? 2.5 - wave : 1.2 + wave + spots);
}

typedef struct picture {
    ibl_image img; /* multiplied by alpha */
    float *alpha;
} picture;

static picture new_picture(int w, int h)
{
    picture p = {{0}, malloc(sizeof(float) * (size_t)w * (size_t)h)};
    if (!p.alpha || ibl_image_alloc(ctx, w, h, &p.img))
        exit(1);
    return p;
}

static void free_picture(picture *p)
{
    ibl_image_free(&p->img);
    free(p->alpha);
}

static picture paint(int probe)
{
    picture p = new_picture(W, H);
    for (int y = 0; y < H; y++)
        for (int x = 0; x < W; x++) {
            double d[3];
            const size_t i = (size_t)y * W + (size_t)x;
            truth_latlong_direction(W, H, x, y, d);
            p.alpha[i] = probe ? 1 : seen_at(d, x, y);
            for (int k = 0; k < 3; k++)
                p.img.data[3 * i + (size_t)k] =
                    p.alpha[i] * light(probe, k, d, x, y);
        }
    return p;
}

/* Alpha as an image. */
static ibl_image greys(const picture *p)
{
    ibl_image g;
    if (ibl_image_alloc(ctx, p->img.width, p->img.height, &g))
        exit(1);
    for (int i = 0; i < 3 * g.width * g.height; i++)
        g.data[i] = p->alpha[i / 3];
    return g;
}

static bool save(const char *name, const picture *p, bool with_alpha)
{
    return file_save_exr(file_path(name), &p->img,
                         with_alpha ? p->alpha : NULL);
}

/* ---- what is baked ----------------------------------------------------- */

/* niche is the first layer, then hall, then the sky. */
static bool bake(const char *niche, const char *hall, const char *sky,
                 const char *options)
{
    char set[2000];
    const char *program = file_built("iblbake");
    const int n = snprintf(
        set, sizeof set,
        "{\"version\": 1, \"defaults\": {\"size\": %d, \"levels\": %d, "
        "\"irradiance\": %d, \"lut_size\": 4, \"method\": \"spectral\"},\n"
        "\"global\": {\"capture\": {%s}}, \"probes\": [\n"
        "{\"name\": \"hall\", \"position\": [0, 0, 0], \"capture\": {%s},\n"
        " \"influence\": {\"sphere\": {\"centre\": [0, 0, 0], \"radius\": 4}},"
        " \"blend\": 1},\n"
        "{\"name\": \"niche\", \"position\": [0, 0, 0], \"capture\": {%s},\n"
        " \"influence\": {\"sphere\": {\"centre\": [0, 0, 0], \"radius\": 1}},"
        " \"blend\": 1}]}\n",
        SIZE, LEVELS, IRRADIANCE, sky, hall, niche);

    return program && file_save(file_path("set.json"), set, (size_t)n) &&
           file_run("'%s' probes -q -j 2 set.json -o out %s", program, options);
}

static const ibl_probe probes[] = {
    {.influence = {IBL_SHAPE_SPHERE, {0, 0, 0}, {1, 1, 1}}, .blend = 1},
    {.influence = {IBL_SHAPE_SPHERE, {0, 0, 0}, {4, 4, 4}}, .blend = 1},
};
static const int order[] = {0, 1};

typedef struct layer {
    ibl_cube colour, alpha;
} layer;

static bool load_layers(const char *name, layer out[3])
{
    ibl_texture array, one;
    bool ok = !ibl_texture_read(ctx, file_path(name), &array, NULL);

    ok = ok && array.layers == 3 && array.premultiplied;
    for (int i = 0; i < 3 && ok; i++) {
        ok = !ibl_texture_layer(ctx, &array, i, &one) &&
             !ibl_texture_to_cube(ctx, &one, &out[i].colour) &&
             !ibl_texture_get_alpha(ctx, &one, &out[i].alpha);
        ibl_texture_free(&one);
    }
    ibl_texture_free(&array);
    return ok;
}

static void free_layers(layer l[3])
{
    for (int i = 0; i < 3; i++) {
        ibl_cube_free(&l[i].colour);
        ibl_cube_free(&l[i].alpha);
    }
}

static size_t texel_of(const ibl_cube *cube, int level, int face, int x, int y)
{
    const int n = ibl_cube_edge(cube->size, level);
    return (size_t)(ibl_cube_face(cube, level, face) - cube->data) / 3 +
           (size_t)y * (size_t)n + (size_t)x;
}

/* What iblbake-probes(1) says that a shader does, by ibl_probes_blend. */
static void mix_at(const double rgb[3][3], const double a[3],
                   const double point[3], double out[3])
{
    const double alpha[] = {fmin(fmax(a[0], 0), 1), fmin(fmax(a[1], 0), 1)};
    ibl_probe_mix mix;

    ibl_probes_blend(probes, 2, order, point, alpha, &mix);
    for (int k = 0; k < 3; k++) {
        out[k] = mix.rest * rgb[2][k];
        for (int i = 0; i < mix.count; i++)
            out[k] += mix.weight[i] * rgb[mix.probe[i]][k] / a[mix.probe[i]];
    }
}

static void mix_texel(const layer l[3], size_t texel, const double point[3],
                      double out[3])
{
    double rgb[3][3], a[3];

    for (int i = 0; i < 3; i++) {
        a[i] = (double)l[i].alpha.data[3 * texel];
        for (int k = 0; k < 3; k++)
            rgb[i][k] = (double)l[i].colour.data[3 * texel + (size_t)k];
    }
    mix_at(rgb, a, point, out);
}

/* ---- against sums over the captures ------------------------------------ */

typedef struct truths {
    ibl_image grey;
    ibl_reference *colour[3], *alpha;
} truths;

static bool prepare(truths *t, const picture p[3])
{
    t->grey = greys(&p[0]);
    for (int i = 0; i < 3; i++)
        if (ibl_reference_create(ctx, &p[i].img, 0, &t->colour[i]))
            return false;
    return !ibl_reference_create(ctx, &t->grey, 0, &t->alpha);
}

static void forget(truths *t)
{
    for (int i = 0; i < 3; i++)
        ibl_reference_free(t->colour[i]);
    ibl_reference_free(t->alpha);
    ibl_image_free(&t->grey);
}

/* Level -1: irradiance. */
static void sum(const ibl_reference *ref, int level, int n, ibl_texel at,
                double rgb[3])
{
    double d[3];
    ibl_cube_direction(n, at.face, at.x, at.y, d);
    if (level == 0)
        CHECK(!ibl_reference_texels(ref, n, n, &at, 1, rgb));
    else if (level < 0)
        CHECK(!ibl_reference_irradiance(ref, d, 1, rgb));
    else
        CHECK(!ibl_reference_specular(ref, (double)level / (LEVELS - 1), d, 1,
                                      rgb));
}

/* Points where the niche's influence is 1, a half and 0.15625. */
static const double points[3][3] = {{0, 0, 0}, {0.5, 0, 0}, {0, 0.75, 0}};

static void judge_texel(const truths *t, const layer l[3], int level,
                        ibl_texel at)
{
    const int n = ibl_cube_edge(l[0].colour.size, level < 0 ? 0 : level);
    const size_t texel =
        texel_of(&l[0].colour, level < 0 ? 0 : level, at.face, at.x, at.y);
    double rgb[3][3], grey[3], a[3] = {0, 1, 1}, want[3], got[3];

    for (int i = 0; i < 3; i++)
        sum(t->colour[i], level, n, at, rgb[i]);
    sum(t->alpha, level, n, at, grey);
    a[0] = grey[0];
    for (int i = 0; i < 3; i++) {
        CHECK_NEAR((double)l[i].alpha.data[3 * texel], a[i], 1e-3);
        for (int k = 0; k < 3; k++)
            CHECK_NEAR((double)l[i].colour.data[3 * texel + (size_t)k],
                       rgb[i][k], 4e-3);
    }
    for (int i = 0; i < 3; i++) {
        mix_at(rgb, a, points[i], want);
        mix_texel(l, texel, points[i], got);
        for (int k = 0; k < 3; k++)
            CHECK_NEAR(got[k], want[k], 6e-3);
    }
}

static void every_level(void)
{
    picture p[3] = {paint(0), paint(1), paint(2)};
    layer specular[3] = {0}, irradiance[3] = {0};
    test_random r = {5};
    truths t = {0};

    NEED(save("niche.exr", &p[0], true) && save("hall.exr", &p[1], true) &&
         save("sky.exr", &p[2], false));
    NEED(bake("\"equirect\": \"niche.exr\"", "\"equirect\": \"hall.exr\"",
              "\"equirect\": \"sky.exr\"", "--pixel rgba32f"));
    NEED(load_layers("out/probes_specular.ktx2", specular));
    NEED(load_layers("out/probes_irradiance.ktx2", irradiance));
    NEED(prepare(&t, p));
    for (int level = -1; level < LEVELS; level++) {
        const int n = level < 0 ? IRRADIANCE : ibl_cube_edge(SIZE, level);
        for (int i = 0; i < PICKS; i++) {
            const uint64_t u = test_random_u64(&r);
            const ibl_texel at = {(int)(u % 6), (int)(u / 6 % (unsigned)n),
                                  (int)(u / 777777 % (unsigned)n)};
            judge_texel(&t, level < 0 ? irradiance : specular, level, at);
        }
    }
    forget(&t);
    free_layers(specular);
    free_layers(irradiance);
    for (int i = 0; i < 3; i++)
        free_picture(&p[i]);
}

/* In the hole the hall, elsewhere the niche; to the captures' own pixels. Of
 * the last bake's files. */
static void hole_shows_what_is_behind(void)
{
    layer l[3] = {0};
    int in = 0, out = 0;

    every_level();
    NEED(load_layers("out/probes_specular.ktx2", l));
    for (int f = 0; f < 6; f++)
        for (int i = 0; i < SIZE * SIZE; i++) {
            double d[3], got[3];
            ibl_cube_direction(SIZE, f, i % SIZE, i / SIZE, d);
            const double c = cosine(d, hole);
            const size_t texel =
                texel_of(&l[0].colour, 0, f, i % SIZE, i / SIZE);
            const bool inside = c > hole_cosine + 0.05;
            const bool outside = c < hole_cosine - 0.05 && d[1] > -0.4 &&
                                 cosine(d, veil) < veil_cosine - 0.05;
            mix_texel(l, texel, points[0], got);
            in += inside;
            out += outside;
            for (int k = 0; k < 3 && (inside || outside); k++)
                CHECK_NEAR(got[k],
                           (double)l[inside].colour.data[3 * texel + (size_t)k],
                           1e-6);
            if (inside || outside)
                CHECK_NEAR((double)l[0].alpha.data[3 * texel], outside, 1e-6);
        }
    CHECK(in > 100 && out > 1000);
    /* What the hole takes away is its solid angle. */
    double missing = 0, whole = 0;
    for (int f = 0; f < 6; f++)
        for (int i = 0; i < SIZE * SIZE; i++) {
            double d[3];
            const double w = ibl_cube_solid_angle(SIZE, i % SIZE, i / SIZE);
            const size_t texel =
                texel_of(&l[0].colour, 0, f, i % SIZE, i / SIZE);
            ibl_cube_direction(SIZE, f, i % SIZE, i / SIZE, d);
            if (cosine(d, hole) > hole_cosine - 0.1)
                missing += w * (1 - (double)l[0].alpha.data[3 * texel]);
            whole += w;
        }
    CHECK_NEAR(missing / whole, (1 - hole_cosine) / 2, 1e-3);
    free_layers(l);
}

/* ---- no rims ----------------------------------------------------------- */

/* Faces of a constant colour under any alpha. */
static bool save_faces(const char *name, double colour, bool with_alpha,
                       uint64_t seed)
{
    test_random r = {seed};
    bool ok = true;

    for (int f = 0; f < 6; f++) {
        picture p = new_picture(FACE, FACE);
        char file[40];
        for (int i = 0; i < FACE * FACE; i++) {
            const int block = i % FACE / 4 + i / FACE / 4;
            p.alpha[i] = !with_alpha                  ? 1
                         : (block + f) % 3 == 0       ? 0
                         : test_random_unit(&r) < 0.3 ? 0
                         : test_random_unit(&r) < 0.5
                             ? 1
                             : (float)test_random_unit(&r);
            for (int k = 0; k < 3; k++)
                p.img.data[3 * i + k] = (float)(colour * (double)p.alpha[i]);
        }
        snprintf(file, sizeof file, "%s%d.exr", name, f);
        ok = ok && save(file, &p, with_alpha);
        free_picture(&p);
    }
    return ok;
}

static const char *faces(const char *name)
{
    static char text[2][300];
    static int next;
    char *to = text[next++ % 2];
    snprintf(to, sizeof text[0],
             "\"faces\": [\"%s0.exr\", \"%s1.exr\", \"%s2.exr\", \"%s3.exr\", "
             "\"%s4.exr\", \"%s5.exr\"]",
             name, name, name, name, name, name);
    return to;
}

/* All texels of what was baked, mixed, are from lo to hi. */
static void all_between(const char *file, double lo, double hi)
{
    layer l[3] = {0};

    NEED(load_layers(file, l));
    const size_t count = ibl_cube_texels(l[0].colour.size, l[0].colour.levels);
    double least = 1e9, most = -1e9;
    for (size_t i = 0; i < count; i++)
        for (int k = 0; k < 3; k++) {
            double got[3];
            mix_texel(l, i, points[k], got);
            least = fmin(least, fmin(got[0], fmin(got[1], got[2])));
            most = fmax(most, fmax(got[0], fmax(got[1], got[2])));
        }
    CHECK_MSG(least >= lo && most <= hi, "%s: %g to %g, not %g to %g", file,
              least, most, lo, hi);
    free_layers(l);
}

static void constant_under_any_alpha(void)
{
    static const char *const pixels[] = {"--pixel rgba16f", "--pixel rgba32f"};
    layer l[3] = {0};

    NEED(save_faces("n", 0.7, true, 9) && save_faces("h", 0.7, true, 10) &&
         save_faces("s", 0.7, false, 11));
    for (int i = 0; i < 2; i++) {
        const double off = i ? 3e-4 : 1e-3;
        char sky[300];
        snprintf(sky, sizeof sky, "%s", faces("s"));
        NEED(bake(faces("n"), faces("h"), sky, pixels[i]));
        all_between("out/probes_specular.ktx2", 0.7 * (1 - off),
                    0.7 * (1 + off));
        all_between("out/probes_irradiance.ktx2", 0.7 * (1 - off),
                    0.7 * (1 + off));
        NEED(load_layers("out/probes_specular.ktx2", l));
        for (size_t k = 0; k < ibl_cube_texels(SIZE, LEVELS); k++) {
            const double a = (double)l[0].alpha.data[3 * k];
            if (a > 0.05)
                CHECK_NEAR((double)l[0].colour.data[3 * k] / a, 0.7, 1e-3);
        }
        free_layers(l);
    }
}

/* Light that is between that of the two, beside holes of any kind. */
static void no_rims(void)
{
    char sky[300];

    NEED(save_faces("n", 1, true, 12) && save_faces("h", 3, false, 13));
    snprintf(sky, sizeof sky, "%s", faces("h"));
    NEED(bake(faces("n"), faces("h"), sky, ""));
    all_between("out/probes_specular.ktx2", 1 - 2e-3, 3 + 4e-3);
    all_between("out/probes_irradiance.ktx2", 1 - 2e-3, 3 + 4e-3);
    NEED(save_faces("n", 3, true, 14) && save_faces("h", 1, false, 15));
    NEED(bake(faces("n"), faces("h"), sky, ""));
    all_between("out/probes_specular.ktx2", 1 - 2e-3, 3 + 4e-3);
    all_between("out/probes_irradiance.ktx2", 1 - 2e-3, 3 + 4e-3);
}

/* ---- faces against sums over their texels ------------------------------ */

static void read_back(const char *name, picture p[6])
{
    for (int f = 0; f < 6; f++) {
        ibl_read_options opts = ibl_read_options_default();
        ibl_source *source;
        char file[40];
        opts.alpha = IBL_ALPHA_FILE;
        opts.any_aspect = 1;
        snprintf(file, sizeof file, "%s%d.exr", name, f);
        p[f] = new_picture(FACE, FACE);
        NEED(!ibl_source_open(ctx, file_path(file), &opts, &source));
        NEED(!ibl_source_read(source, FACE, p[f].img.data));
        memcpy(p[f].alpha, ibl_source_alpha(source),
               sizeof(float) * FACE * FACE);
        ibl_source_close(source);
    }
}

/* Texels as constant patches, SUB x SUB points in each. */
static double sum_alpha(const picture p[6], const double d[3], double roughness)
{
    enum {
        SUB = 2
    };
    double all = 0, weights = 0;

    for (int f = 0; f < 6; f++)
        for (int i = 0; i < FACE * SUB * FACE * SUB; i++) {
            const int x = i % (FACE * SUB), y = i / (FACE * SUB);
            double v[3];
            ibl_cube_direction(FACE * SUB, f, x, y, v);
            const double c = cosine(v, d);
            if (c <= 0)
                continue;
            const double w =
                truth_lobe_weight(IBL_LOBE_GGX, roughness * roughness,
                                  (1 - c) / 2) *
                ibl_cube_solid_angle(FACE * SUB, x, y);
            all += w * (double)p[f].alpha[y / SUB * FACE + x / SUB];
            weights += w;
        }
    return all / weights;
}

static void faces_are_filtered(void)
{
    picture p[6];
    layer l[3] = {0};
    char sky[300];
    test_random r = {21};

    NEED(save_faces("n", 2, true, 16) && save_faces("h", 1, false, 17));
    snprintf(sky, sizeof sky, "%s", faces("h"));
    NEED(bake(faces("n"), faces("h"), sky, "--pixel rgba32f"));
    NEED(load_layers("out/probes_specular.ktx2", l));
    read_back("n", p);
    for (int level = 1; level < LEVELS; level++)
        for (int i = 0; i < PICKS / 3; i++) {
            const int n = ibl_cube_edge(SIZE, level);
            const uint64_t u = test_random_u64(&r);
            const int f = (int)(u % 6), x = (int)(u / 6 % (unsigned)n);
            const int y = (int)(u / 777777 % (unsigned)n);
            const size_t texel = texel_of(&l[0].colour, level, f, x, y);
            double d[3];
            ibl_cube_direction(n, f, x, y, d);
            const double want = sum_alpha(p, d, (double)level / (LEVELS - 1));
            CHECK_NEAR((double)l[0].alpha.data[3 * texel], want, 6e-3);
            CHECK_NEAR((double)l[0].colour.data[3 * texel], 2 * want, 12e-3);
        }
    for (int f = 0; f < 6; f++)
        free_picture(&p[f]);
    free_layers(l);
}

/* ---- crosses ------------------------------------------------------------ */

/* Unfolded; -Z of the upright one stands on its head below -Y. */
static bool save_cross(const char *name, const picture p[6], bool upright)
{
    static const int places[6][2] = {{2, 1}, {0, 1}, {1, 0},
                                     {1, 2}, {1, 1}, {3, 1}};
    const int w = (upright ? 3 : 4) * FACE, h = (upright ? 4 : 3) * FACE;
    picture cross = new_picture(w, h);

    memset(cross.alpha, 0, sizeof(float) * (size_t)w * (size_t)h);
    memset(cross.img.data, 0, 3 * sizeof(float) * (size_t)w * (size_t)h);
    for (int f = 0; f < 6; f++)
        for (int i = 0; i < FACE * FACE; i++) {
            const bool turned = upright && f == 5;
            const int from = turned ? FACE * FACE - 1 - i : i;
            const int x = (turned ? 1 : places[f][0]) * FACE + i % FACE;
            const int y = (turned ? 3 : places[f][1]) * FACE + i / FACE;
            cross.alpha[y * w + x] = p[f].alpha[from];
            memcpy(cross.img.data + 3 * (y * w + x), p[f].img.data + 3 * from,
                   3 * sizeof(float));
        }
    const bool ok = save(name, &cross, true);
    free_picture(&cross);
    return ok;
}

static void crosses_are_as_faces(void)
{
    picture p[6];
    ibl_texture want, got;

    NEED(save_faces("n", 2, true, 18));
    read_back("n", p);
    NEED(save_cross("lying.exr", p, false) && save_cross("up.exr", p, true));
    NEED(bake(faces("n"), faces("n"), "\"equirect\": \"sky.exr\"", ""));
    NEED(!ibl_texture_read(ctx, file_path("out/probes_specular.ktx2"), &want,
                           NULL));
    NEED(bake("\"cross\": \"lying.exr\"", "\"cross\": \"up.exr\"",
              "\"equirect\": \"sky.exr\"", ""));
    NEED(!ibl_texture_read(ctx, file_path("out/probes_specular.ktx2"), &got,
                           NULL));
    CHECK(want.bytes == got.bytes && !memcmp(want.data, got.data, got.bytes));
    ibl_texture_free(&want);
    ibl_texture_free(&got);
    for (int f = 0; f < 6; f++)
        free_picture(&p[f]);
}

/* Beside the faces a cross is transparent, or has nothing at all: what counts
 * is in them. */
static void crosses_have_alpha_in_their_faces(void)
{
    picture p[6];

    for (int f = 0; f < 6; f++) {
        p[f] = new_picture(FACE, FACE);
        for (int i = 0; i < FACE * FACE; i++) {
            p[f].alpha[i] = 1;
            for (int k = 0; k < 3; k++)
                p[f].img.data[3 * i + k] = 2;
        }
    }
    NEED(save_cross("lying.exr", p, false) && save_cross("up.exr", p, true));
    /* Which has no room for alpha. */
    CHECK(bake("\"cross\": \"lying.exr\"", "\"cross\": \"up.exr\"",
               "\"equirect\": \"sky.exr\"", "--pixel rgb9e5"));
    for (int f = 0; f < 6; f++)
        free_picture(&p[f]);
}

static const test tests[] = {
    TEST(hole_shows_what_is_behind),
    TEST(constant_under_any_alpha),
    TEST(no_rims),
    TEST(faces_are_filtered),
    TEST(crosses_are_as_faces),
    TEST(crosses_have_alpha_in_their_faces),
};

int main(int argc, char **argv)
{
    if (!file_built("iblbake")) {
        printf("skipped: iblbake is not built\n");
        printf("0 passed, 0 failed, 1 skipped\n");
        return 0;
    }
    ctx = test_ctx(2, IBL_ISA_AUTO);
    const int status =
        test_main(argc, argv, tests, sizeof tests / sizeof tests[0]);
    ibl_ctx_free(ctx);
    return status;
}
