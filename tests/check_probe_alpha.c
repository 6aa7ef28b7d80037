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
#include "test.h"
#include "truth.h"

#define PI 3.14159265358979323846

enum {
    W = 256, /* of equirectangular captures */
    H = 128,
    FACE = 64, /* of faces: twice what is baked: level 0 is their means */
    SIZE = 32, /* of what is baked */
    LEVELS = 4,
    IRRADIANCE = 8
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
        "\"irradiance\": %d, \"lut_size\": 4, \"method\": \"spectral\", "
        "\"mapping\": \"linear\"},\n"
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
static void mix_texel(const layer l[3], size_t texel, const double point[3],
                      double out[3])
{
    const double a[] = {(double)l[0].alpha.data[3 * texel],
                        (double)l[1].alpha.data[3 * texel]};
    const double alpha[] = {fmin(fmax(a[0], 0), 1), fmin(fmax(a[1], 0), 1)};
    ibl_probe_mix mix;

    ibl_probes_blend(probes, 2, order, point, alpha, &mix);
    for (size_t k = 0; k < 3; k++) {
        out[k] = mix.rest * (double)l[2].colour.data[3 * texel + k];
        for (int i = 0; i < mix.count; i++) {
            const int p = mix.probe[i];
            out[k] +=
                mix.weight[i] * (double)l[p].colour.data[3 * texel + k] / a[p];
        }
    }
}

/* ---- what is behind ---------------------------------------------------- */

/* Points where the niche's influence is 1, a half and 0.15625. */
static const double points[3][3] = {{0, 0, 0}, {0.5, 0, 0}, {0, 0.75, 0}};

/* Pictures of all three, the sky's without alpha. */
static bool bake_pictures(void)
{
    static const char *const names[] = {"niche.exr", "hall.exr", "sky.exr"};
    bool ok = true;

    for (int i = 0; i < 3; i++) {
        picture p = paint(i);
        ok = ok && save(names[i], &p, i < 2);
        free_picture(&p);
    }
    return ok &&
           bake("\"equirect\": \"niche.exr\"", "\"equirect\": \"hall.exr\"",
                "\"equirect\": \"sky.exr\"", "--pixel rgba32f");
}

/* In the hole the hall, elsewhere the niche, and what the hole takes away is
 * its solid angle. check-probes.sh: each layer is as a bake of its own. */
TEST(hole_shows_what_is_behind)
{
    layer l[3] = {0};
    int count[2] = {0};
    double missing = 0, whole = 0;

    NEED(bake_pictures() && load_layers("out/probes_specular.ktx2", l));
    for (int i = 0; i < 6 * SIZE * SIZE; i++) {
        const int f = i / (SIZE * SIZE), x = i % SIZE, y = i / SIZE % SIZE;
        const size_t texel = texel_of(&l[0].colour, 0, f, x, y);
        const double a = (double)l[0].alpha.data[3 * texel];
        const double w = ibl_cube_solid_angle(SIZE, x, y);
        double d[3], got[3];

        ibl_cube_direction(SIZE, f, x, y, d);
        const double c = cosine(d, hole);
        const bool inside = c > hole_cosine + 0.05;
        const bool outside = c < hole_cosine - 0.05 && d[1] > -0.4 &&
                             cosine(d, veil) < veil_cosine - 0.05;
        whole += w;
        if (c > hole_cosine - 0.1)
            missing += w * (1 - a);
        if (!inside && !outside)
            continue;
        count[inside]++;
        CHECK_NEAR(a, outside, 1e-6);
        mix_texel(l, texel, points[0], got);
        for (int k = 0; k < 3; k++)
            CHECK_NEAR(got[k],
                       (double)l[inside].colour.data[3 * texel + (size_t)k],
                       1e-6);
    }
    CHECK(count[1] > 100 && count[0] > 1000);
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
    static char text[3][300];
    static int next;
    char *to = text[next++ % 3];
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

/* Constant light in the niche, which has alpha of any kind, and in the hall:
 * nothing is darker or brighter than both, and one of their colour under any
 * alpha. */
TEST(no_rims)
{
    static const struct {
        double niche, hall;
        bool hall_alpha;
        const char *options;
        double lo, hi;
    } cases[] = {
        {0.7, 0.7, true, "--pixel rgba16f", 0.7 * (1 - 1e-3), 0.7 * (1 + 1e-3)},
        {0.7, 0.7, true, "--pixel rgba32f", 0.7 * (1 - 3e-4), 0.7 * (1 + 3e-4)},
        {1, 3, false, "", 1 - 2e-3, 3 + 4e-3},
        {3, 1, false, "", 1 - 2e-3, 3 + 4e-3},
    };

    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        const uint64_t seed = 9 + 3 * i;
        NEED(save_faces("n", cases[i].niche, true, seed) &&
             save_faces("h", cases[i].hall, cases[i].hall_alpha, seed + 1) &&
             save_faces("s", cases[i].hall, false, seed + 2));
        NEED(bake(faces("n"), faces("h"), faces("s"), cases[i].options));
        all_between("out/probes_specular.ktx2", cases[i].lo, cases[i].hi);
        all_between("out/probes_irradiance.ktx2", cases[i].lo, cases[i].hi);
    }
}

/* ---- crosses ------------------------------------------------------------ */

/* Only the faces of a cross count: the rest of the picture has no alpha, for
 * which there is no room here. check-probes.sh: crosses are as faces. */
TEST(crosses_have_alpha_in_their_faces)
{
    for (int upright = 0; upright < 2; upright++) {
        const int w = (upright ? 3 : 4) * FACE, h = (7 * FACE) - w;
        picture cross = new_picture(w, h);
        for (int i = 0; i < 3 * w * h; i++) {
            const int column = i / 3 % w / FACE, row = i / 3 / w / FACE;
            const float seen = column == 1 || row == 1;
            cross.img.data[i] = cross.alpha[i / 3] = seen;
        }
        NEED(save(upright ? "up.exr" : "lying.exr", &cross, true));
        free_picture(&cross);
    }
    CHECK(bake("\"cross\": \"lying.exr\"", "\"cross\": \"up.exr\"",
               "\"cross\": \"up.exr\"", "--pixel rgb9e5"));
}

void test_setup(void)
{
    if (!file_built("iblbake"))
        test_skip("iblbake is not built");
    ctx = test_ctx(2, IBL_ISA_AUTO);
}
