/* SPDX-License-Identifier: MIT */
/* ibl/probes.glsl on a GPU, or what OSMesa has for one, against the functions
 * of ibl/probes.h: each pixel of a draw is a point, a ray or a tile. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "ibl/probes.h"
#include "room.h"
#include "test.h"
#include "view.h"
#include "view/gl.h"

enum {
    EDGE = 64,
    PIXELS = EDGE * EDGE,
    MOST = 64
};

/* what: 0 blend of count, 1 of a mask: the mean of the probes' keys, and rest.
 * 2 parallax, 3 a tile's mask. */
static const char fragment_text[] =
    "uniform samplerBuffer probes;\n"
    "uniform usampler2D mask;\n"
    "uniform sampler2D points, directions, camera;\n"
    "uniform int what, count, width, height, tile;\n"
    "out vec4 result;\n"
    "void main()\n"
    "{\n"
    "    ivec2 at = ivec2(gl_FragCoord.xy);\n"
    "    vec3 point = texelFetch(points, at, 0).xyz, lookup = vec3(0);\n"
    "    if (what < 2) {\n"
    "        ibl_mix m = ibl_probes_blend(probes, count, point);\n"
    "        if (what == 1)\n"
    "            m = ibl_probes_blend(probes, ibl_tile_mask(mask,\n"
    "                                     gl_FragCoord.xy, 16), point);\n"
    "        for (int i = 0; i < m.count; i++)\n"
    "            lookup += m.weight[i] * fract(float(m.probe[i] + 1) *\n"
    "                          vec3(0.618034, 0.754878, 0.569840));\n"
    "        result = vec4(lookup, m.rest);\n"
    "    } else if (what == 2) {\n"
    "        bool hit = ibl_probe_parallax(\n"
    "            ibl_probe_fetch(probes, 0), point,\n"
    "            texelFetch(directions, at, 0).xyz, lookup);\n"
    "        result = vec4(lookup, hit);\n"
    "    } else {\n"
    "        mat4 clip;\n"
    "        for (int i = 0; i < 4; i++)\n"
    "            clip[i] = texelFetch(camera, ivec2(i, 0), 0);\n"
    "        uvec2 m = ibl_tile_cull(probes, 0, count, clip,\n"
    "                                ivec2(width, height), tile, at);\n"
    "        result = vec4(m.x & 65535u, m.x >> 16,\n"
    "                      m.y & 65535u, m.y >> 16);\n"
    "    }\n"
    "}\n";

typedef float texel[4];

/* What draws with it: units 0..4 in the order of the samplers. */
static struct {
    GLuint program, buffer, masks, texels;
    view_image image;
    ibl_probe probes[MOST];
    int order[MOST];
    texel points[PIXELS], directions[PIXELS], seen[PIXELS];
} on;

enum {
    BUFFER,
    MASK,
    POINTS,
    DIRECTIONS,
    CAMERA
};

static void set(const char *name, int value)
{
    gl.Uniform1i(gl.GetUniformLocation(on.program, name), value);
}

static void upload(int unit, int width, int height, const texel *texels)
{
    gl.ActiveTexture(GL_TEXTURE0 + (GLenum)unit);
    view_float_image(GL_RGBA, width, height, texels[0]);
}

/* Masks of 4 x 4 tiles. */
static void upload_masks(const unsigned long long *masks)
{
    unsigned words[32];

    for (int i = 0; i < 16; i++) {
        words[2 * i] = (unsigned)masks[i];
        words[2 * i + 1] = (unsigned)(masks[i] >> 32);
    }
    view_gl_bind(MASK, GL_TEXTURE_2D, on.masks);
    view_gl_filter(GL_TEXTURE_2D, GL_NEAREST, 1);
    gl.TexImage2D(GL_TEXTURE_2D, 0, GL_RG32UI, 4, 4, 0, GL_RG_INTEGER,
                  GL_UNSIGNED_INT, words);
}

/* Gives the shader the probes in on.order. */
static void upload_probes(int count)
{
    float texels[MOST * IBL_PROBE_FLOATS];

    ibl_probes_pack(on.probes, count, on.order, texels);
    gl.BindBuffer(GL_TEXTURE_BUFFER, on.buffer);
    gl.BufferData(GL_TEXTURE_BUFFER,
                  (GLsizeiptr)sizeof(float) * IBL_PROBE_FLOATS * count, texels,
                  GL_DYNAMIC_DRAW);
    view_gl_bind(BUFFER, GL_TEXTURE_BUFFER, on.texels);
    gl.TexBuffer(GL_TEXTURE_BUFFER, GL_RGBA32F, on.buffer);
    gl.UseProgram(on.program);
    set("count", count);
}

static void draw(int what)
{
    set("what", what);
    gl.BindFramebuffer(GL_FRAMEBUFFER, on.image.framebuffer);
    gl.Viewport(0, 0, EDGE, EDGE);
    view_gl_draw_full(on.program);
    gl.ReadPixels(0, 0, EDGE, EDGE, GL_RGBA, GL_FLOAT, on.seen);
    if (!view_gl_check("test"))
        exit(1);
}

static void end(void *unused)
{
    (void)unused;
    view_image_free(&on.image);
}

static void begin(void)
{
    static const char *const names[] = {"probes", "mask", "points",
                                        "directions", "camera"};

    view_test_begin(EDGE, EDGE);
    memset(&on, 0, sizeof on);
    test_defer(end, NULL);
    on.program = view_test_program(
        test_text("%s%s", view_test_shader("probes.glsl"), fragment_text));
    gl.GenBuffers(1, &on.buffer);
    gl.GenTextures(1, &on.masks);
    gl.GenTextures(1, &on.texels);
    gl.UseProgram(on.program);
    for (int i = 0; i < 5; i++)
        set(names[i], i);
    for (int i = 0; i < MOST; i++)
        on.order[i] = i;
    upload(POINTS, EDGE, EDGE, on.points);
    upload(DIRECTIONS, EDGE, EDGE, on.points);
    upload(CAMERA, 4, 1, on.points);
    upload_masks((unsigned long long[16]){0});
    NEED(view_image_make(&on.image, EDGE, EDGE));
    NEED(view_gl_check("test"));
}

/* ---- what is drawn: numbers of float, as the shader gets them ------------ */

static void random_probes(test_random *r, int count, bool crowded)
{
    for (int i = 0; i < count; i++) {
        ibl_probe *p = &on.probes[i];

        *p = (ibl_probe){.blend = crowded ? test_random_between(r, 3, 12)
                                          : test_random_between(r, 0.1, 1.5)};
        p->influence.shape = (ibl_shape)test_random_below(r, 2);
        p->priority = test_random_below(r, 5) == 0;
        for (int k = 0; k < 3; k++) {
            p->position[k] = test_random_between(r, -2, 2);
            p->influence.centre[k] =
                test_random_between(r, -2, 2) * (crowded ? 0.25 : 1);
            p->influence.half[k] = test_random_between(r, 0.3, 2.5);
        }
        if (i > 0 && test_random_below(r, 6) == 0)
            p->influence = on.probes[i - 1].influence;
    }
    ibl_probes_order(on.probes, count, on.order);
    for (int i = count; i < MOST; i++)
        on.order[i] = i;
}

static void random_texels(test_random *r, texel *texels, double reach)
{
    for (int i = 0; i < PIXELS; i++) {
        for (int k = 0; k < 3; k++)
            texels[i][k] = (float)test_random_between(r, -reach, reach);
    }
}

static void widen(const float v[4], double d[3])
{
    for (int i = 0; i < 3; i++)
        d[i] = (double)v[i];
}

/* ---- tests -------------------------------------------------------------- */

/* Of all probes, or of those of a tile's mask: weights of probes are told apart
 * by their keys. */
TEST(blends)
{
    static const double keys[3] = {0.618034, 0.754878, 0.569840};
    test_random r = {1};
    ibl_probe_mix mix;
    unsigned long long masks[16];
    double worst = 0;
    int full = 0;

    begin();
    for (int n = 0; n < 10; n++) {
        const bool masked = n % 2;
        const int all = masked ? MOST : n % 4 ? 16 : test_random_below(&r, 17);
        int place[MOST];
        random_probes(&r, all, n / 2 % 2);
        random_texels(&r, on.points, 2.5);
        upload(POINTS, EDGE, EDGE, on.points);
        upload_probes(all);
        for (int i = 0; i < 16; i++)
            masks[i] =
                test_random_u64(&r) & test_random_u64(&r) & test_random_u64(&r);
        masks[5] = 1ULL << 63;
        masks[6] = 1;
        masks[7] = 0;
        upload_masks(masks);
        draw(masked);
        for (int i = 0; i < all; i++)
            place[on.order[i]] = i;
        for (int i = 0; i < PIXELS; i++) {
            const unsigned long long mask =
                masks[i / EDGE / 16 * 4 + i % EDGE / 16];
            double p[3], seen[3], sum[3] = {0};
            int some[MOST], count = 0;
            for (int k = 0; k < all; k++)
                if (!masked || mask >> k & 1)
                    some[count++] = on.order[k];
            widen(on.points[i], p);
            widen(on.seen[i], seen);
            ibl_probes_blend(on.probes, count, some, p, NULL, &mix);
            for (int k = 0; k < 3 * mix.count; k++)
                sum[k % 3] +=
                    mix.weight[k / 3] *
                    fmod((place[mix.probe[k / 3]] + 1) * keys[k % 3], 1);
            for (int k = 0; k < 3; k++)
                worst = fmax(worst, fabs(sum[k] - seen[k]));
            worst = fmax(worst, fabs((double)on.seen[i][3] - mix.rest));
            CHECK(isfinite(seen[0] + seen[1] + seen[2]));
            full += mix.count == IBL_MAX_PROBES_AT;
        }
    }
    /* Slopes to 15 a unit, at coordinates to 5, by some roundings. */
    CHECK_MSG(worst < 1e-5, "differs by %g", worst);
    CHECK(full > 500);
}

/* Within, on the wall and outside, where numbers are exact in float;
 * directions with components of 0 and of any length. */
static void random_rays(test_random *r)
{
    static const float lengths[] = {1, 1, 5, 1e-25F, 1e25F};
    const ibl_volume *v = &on.probes[0].proxy;
    const bool round = v->shape == IBL_SHAPE_SPHERE;

    for (int i = 0; i < PIXELS; i++) {
        const float length = lengths[test_random_below(r, 5)];
        const int axis = test_random_below(r, 3);
        for (int k = 0; k < 3; k++) {
            double part = test_random_between(r, -1, 1) * (round ? 0.6 : 1.1);
            if (i % 4 == 0) /* a wall's middle, or a pole */
                part = k == axis ? (i % 8 ? 1 : -1) : 0;
            on.points[i][k] =
                (float)(v->centre[k] + part * v->half[round ? 0 : k]);
            on.directions[i][k] = (float)test_random_between(r, -1, 1) * length;
            if (test_random_below(r, 4) == 0)
                on.directions[i][k] = 0;
        }
        if (i % 500 == 0)
            memset(on.directions[i], 0, sizeof on.directions[i]);
    }
    upload(POINTS, EDGE, EDGE, on.points);
    upload(DIRECTIONS, EDGE, EDGE, on.directions);
}

/* Whether float and double may tell apart what is inside, in the proxy's size;
 * walls themselves they have exactly. */
static bool on_an_edge(const ibl_volume *v, const double p[3])
{
    double square = 0, most = 0;

    for (int k = 0; k < 3; k++) {
        const double part = fabs(p[k] - v->centre[k]) /
                            v->half[v->shape == IBL_SHAPE_SPHERE ? 0 : k];
        square += part * part;
        most = fmax(most, part);
    }
    if (v->shape == IBL_SHAPE_SPHERE)
        most = sqrt(square);
    return most != 1 && fabs(most - 1) < 2e-3;
}

TEST(parallax)
{
    test_random r = {4};
    int hits = 0, misses = 0;
    double worst = 0;

    begin();
    for (int n = 0; n < (TEST_SANITIZED ? 6 : 40); n++) {
        ibl_probe *probe = &on.probes[0];
        ibl_volume *v = &probe->proxy;
        *probe = (ibl_probe){.has_proxy = n % 10 != 9, .blend = 1};
        v->shape = (ibl_shape)(n % 2);
        for (int k = 0; k < 3; k++) {
            /* Of few bits, so that walls are where they are. */
            v->half[k] = (1 + test_random_below(&r, 64)) / 16.;
            v->centre[k] = (test_random_below(&r, 128) - 64) / 16.;
        }
        for (int k = 0; k < 3; k++)
            probe->position[k] =
                (float)(v->centre[k] + v->half[n % 2 ? 0 : k] *
                                           test_random_between(&r, -0.4, 0.4));
        random_rays(&r);
        upload_probes(1);
        draw(2);
        for (int i = 0; i < PIXELS; i++) {
            double p[3], d[3], truth[3], seen[3], apart = 0;
            widen(on.points[i], p);
            widen(on.directions[i], d);
            widen(on.seen[i], seen);
            if (on_an_edge(v, p))
                continue;
            const int hit = ibl_probe_parallax(probe, p, d, truth);
            CHECK(hit == (int)on.seen[i][3]);
            for (int k = 0; k < 3; k++)
                apart = fmax(apart, fabs(seen[k] - truth[k]));
            CHECK(apart == apart && isfinite(seen[0] + seen[1] + seen[2]));
            worst = fmax(worst, apart);
            hits += hit;
            misses += !hit;
        }
    }
    /* Where the ray meets may be an eighth of the size from the probe. */
    CHECK_MSG(!(worst > 1e-5), "differs by %g", worst);
    CHECK(hits > 10000 && misses > (TEST_SANITIZED ? 1000 : 4000));
}

/* ---- tiles -------------------------------------------------------------- */

/* A point of a volume, often on its border, its edges and its corners. */
static void point_of(test_random *r, const ibl_volume *v, double p[3])
{
    double d[3], square = 0;

    for (int i = 0; i < 3; i++) {
        d[i] = test_random_between(r, -1, 1);
        if (v->shape == IBL_SHAPE_BOX && test_random_below(r, 2))
            d[i] = d[i] < 0 ? -1 : 1;
        square += d[i] * d[i];
    }
    const double scale = test_random_below(r, 4) ? 1 : test_random_unit(r);
    for (int i = 0; i < 3; i++)
        p[i] = v->centre[i] + (v->shape == IBL_SHAPE_BOX
                                   ? v->half[i] * d[i]
                                   : v->half[0] * d[i] / sqrt(square) * scale);
}

/* The pixel in which a point is seen by a matrix to clip space; false: out of
 * the picture. */
static bool find_pixel(const double clip[16], int width, int height,
                       const double p[3], int pixel[2])
{
    const int size[2] = {width, height};
    double at[4];

    for (int row = 0; row < 4; row++)
        at[row] = clip[row] * p[0] + clip[4 + row] * p[1] +
                  clip[8 + row] * p[2] + clip[12 + row];
    if (!(at[3] > 0) || fabs(at[0]) >= at[3] || fabs(at[1]) >= at[3])
        return false;
    for (int i = 0; i < 2; i++)
        pixel[i] = (int)((at[i] / at[3] + 1) / 2 * size[i]);
    return true;
}

/* Every tile in which a point of a volume is seen has its bit, and few others
 * have: where a volume is cut slantwise. */
TEST(tiles_miss_nothing)
{
    test_random r = {5};
    static unsigned long long seen_in[PIXELS];
    float clip[16];
    double exact[16], p[3];
    long named = 0, found = 0;

    begin();
    for (int n = 0; n < (TEST_SANITIZED ? 3 : 12); n++) {
        const int tile = 3 + test_random_below(&r, 14);
        const int count = n % 2 ? MOST : 1 + test_random_below(&r, MOST);
        const int width = 1 + test_random_below(&r, tile * 50);
        const int height = 1 + test_random_below(&r, tile * 30);
        const int columns = (width - 1) / tile + 1;
        const int rows = (height - 1) / tile + 1;

        double ends[2][3];
        for (int i = 0; i < 6; i++)
            ends[i / 3][i % 3] = test_random_between(&r, -3, 3);
        const view_camera c = room_camera(
            ends[0], ends[1], test_random_between(&r, 37, 136), 5, 3);
        view_camera_matrix(&c, exact);
        for (int i = 0; i < 16; i++)
            exact[i] = (double)(clip[i] = (float)exact[i]);
        random_probes(&r, count, false);
        memset(seen_in, 0, sizeof seen_in);
        for (int i = 0; i < count; i++) {
            ibl_volume *v = &on.probes[i].influence;
            int at[2];
            for (int k = 0; k < 3; k++) {
                v->centre[k] = (double)(float)test_random_between(&r, -6, 6);
                v->half[k] = (double)(float)(v->half[k] * 0.5);
            }
            for (int k = 0; k < (TEST_SANITIZED ? 500 : 5000); k++) {
                point_of(&r, v, p);
                if (find_pixel(exact, width, height, p, at))
                    seen_in[at[1] / tile * columns + at[0] / tile] |= 1ULL << i;
            }
            on.order[i] = i;
        }
        upload_probes(count);
        upload(CAMERA, 4, 1, (const texel *)clip);
        set("width", width);
        set("height", height);
        set("tile", tile);
        draw(3);
        for (int t = 0; t < columns * rows; t++) {
            const float *seen = on.seen[t / columns * EDGE + t % columns];
            unsigned long long mask = 0;
            for (int k = 3; k >= 0; k--)
                mask = mask << 16 | (unsigned long long)seen[k];
            CHECK_MSG((seen_in[t] & ~mask) == 0, "tile %d lacks %llx", t,
                      seen_in[t] & ~mask);
            found += __builtin_popcountll(seen_in[t]);
            named += __builtin_popcountll(mask);
        }
    }
    CHECK_MSG(found > (TEST_SANITIZED ? 300 : 2000) &&
                  (TEST_SANITIZED || named < 2 * found),
              "%ld, %ld found", named, found);
}
