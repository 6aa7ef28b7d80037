/* SPDX-License-Identifier: MIT */
/* Captures that see what is in their own boxes alone: what is beyond is marked
 * by alpha, and in the picture the next probe fills in, as ibl/probes.h says.
 */
#include "room.h"
#include "shade.h"
#include "view.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "ibl/ibl.h"
#include "ibl/probes.h"
#include "view/scene_captures.h"

enum {
    WIDTH = 96,
    HEIGHT = 64,
    SIZE = 32, /* of captures */
    LEVELS = 2 /* that the floor looks up */
};

static const float light[3] = {0.5F, 0.6F, 0.8F}; /* of the environment */
/* Nothing is lost: the split sum of a surface is F0 R + G and the rest. */
static const float table[2] = {0.95F, 0.05F};

static room_stage on;

static void begin(void)
{
    room_stage_begin(&on, WIDTH, HEIGHT, light, table);
    on.s.probe_size = SIZE;
    on.s.probes = 1;
    on.s.probe_limit = true;
}

/* What the captures of a picture were drawn by; *rgba is the picture. */
static const view_room_draw *draw(const float **rgba)
{
    *rgba = room_stage_draw(&on);
    NEED(*rgba);
    return &view_scene_state_of(on.stage)->draw;
}

/* ---- what probes hold --------------------------------------------------- */

typedef struct probe_texels {
    float specular[LEVELS][IBL_FACES][4 * SIZE * SIZE];
    float irradiance[IBL_FACES]
                    [4 * VIEW_CAPTURE_IRRADIANCE * VIEW_CAPTURE_IRRADIANCE];
} probe_texels;

enum {
    MOST = 4 /* probes of a test */
};

/* With a limit the mirror's is the last, as it is for all of the room. */
static int count_probes(const view_room_draw *d)
{
    CHECK(d->locals.count < MOST);
    return d->locals.count + 1;
}

static ibl_probe probe_of(const view_room_draw *d, int i)
{
    return i < d->locals.count ? d->locals.probe[i] : *d->dynamic.probe;
}

/* A level of a layer of cubes, from count layers. */
static void read_layer(GLuint cubes, int count, int layer, int level, int n,
                       float *rgba)
{
    const size_t floats = (size_t)4 * IBL_FACES * (size_t)(n * n);
    const float *all = room_cubes_read(cubes, count, level, n);

    memcpy(rgba, all + floats * (size_t)layer, floats * sizeof *rgba);
}

static probe_texels *read_probe(const view_room_draw *d, int i)
{
    const bool local = i < d->locals.count;
    const view_probe_maps *m = local ? &d->locals : &d->dynamic;
    const int count = local ? m->count : 2, layer = probe_of(d, i).layer;
    probe_texels *t = test_alloc(1, sizeof *t);

    for (int level = 0; level < LEVELS; level++) {
        const int n = SIZE >> level;
        float all[IBL_FACES * 4 * SIZE * SIZE];
        read_layer(m->specular, count, layer, level, n, all);
        for (int face = 0; face < IBL_FACES; face++)
            memcpy(t->specular[level][face], all + 4 * n * n * face,
                   (size_t)(4 * n * n) * sizeof *all);
    }
    read_layer(m->irradiance, count, layer, 0, VIEW_CAPTURE_IRRADIANCE,
               t->irradiance[0]);
    return t;
}

/* ---- marks -------------------------------------------------------------- */

/* How far a hit is inside a box; below 0 beyond it, as the sky is. What is on
 * the border is inside, and a side of a pillar is. */
static double depth_in(const ibl_volume *box, const room_hit *h)
{
    double least = h->what < 0 ? -1 : INFINITY;

    for (int k = 0; k < 3; k++)
        least = fmin(least, box->half[k] - fabs(h->point[k] - box->centre[k]));
    return least;
}

/* Whether what a texel sees is in the box: 1 or 0; or -1 where it may see
 * both, `around` texels from its middle. */
static int texel_is_in(const view_room_draw *d, const ibl_probe *p, int face,
                       int x, int y, double around)
{
    enum {
        FINE = 64
    };
    const int step = (int)(around * FINE);
    int in = 0;

    for (int i = 0; i < 9; i++) {
        double direction[3];
        ibl_cube_direction(SIZE * FINE, face,
                           x * FINE + FINE / 2 + step * (i % 3 - 1),
                           y * FINE + FINE / 2 + step * (i / 3 - 1), direction);
        const room_hit h = room_cast(d, p->position, direction);
        in += depth_in(&p->influence, &h) > -1e-3;
    }
    return in == 9 ? 1 : in == 0 ? 0 : -1;
}

/* d: what the capture was drawn by. */
static void check_marks(const view_room_draw *d, const probe_texels *t,
                        const ibl_probe *p, double around)
{
    int bad = 0, marked = 0, seen = 0, none = 0;

    for (int i = 0; i < IBL_FACES * SIZE * SIZE; i++) {
        const int face = i / (SIZE * SIZE), at = i % (SIZE * SIZE);
        const float *rgba = t->specular[0][face] + 4 * at;
        const int in = texel_is_in(d, p, face, at % SIZE, at / SIZE, around);
        static const float zeros[4] = {0};
        if (in == 0)
            bad += memcmp(rgba, zeros, sizeof zeros) != 0;
        else if (in > 0)
            bad += rgba[3] < 0.999F;
        marked += in == 0;
        seen += in > 0;
        none += in < 0;
    }
    CHECK_MSG(bad == 0, "%d of %d texels", bad, marked + seen);
    CHECK_MSG(marked > 20 && seen > 500 && none < 1500, "%d, %d, %d", marked,
              seen, none);
}

TEST_SLOW(marks_what_is_beyond)
{
    static const double around[VIEW_PROBE_CAPTURES] = {0.5, 2};
    const float *rgba;

    begin();
    for (int kind = 0; kind < VIEW_PROBE_CAPTURES; kind++) {
        on.s.probe_capture = (view_probe_capture)kind;
        const view_room_draw *d = draw(&rgba);
        NEED(count_probes(d) == 2);
        for (int i = 0; i < count_probes(d); i++) {
            view_room_draw captured = *d;
            const ibl_probe p = probe_of(d, i);
            probe_texels *t = read_probe(d, i);
            captured.moving = i == 1;
            check_marks(&captured, t, &p, around[kind]);
        }
    }
}

/* Without the limit nothing is marked. */
TEST(sees_all_without)
{
    const float *rgba;
    int marked = 0;

    begin();
    on.s.probe_limit = false;
    const view_room_draw *d = draw(&rgba);
    NEED(count_probes(d) == 2);
    for (int i = 0; i < 2; i++) {
        probe_texels *t = read_probe(d, i);
        for (int at = 0; at < IBL_FACES * SIZE * SIZE; at++)
            marked += t->specular[0][at / (SIZE * SIZE)]
                                 [4 * (at % (SIZE * SIZE)) + 3] < 1;
    }
    CHECK_MSG(marked == 0, "%d texels", marked);
}

/* ---- what fills in ------------------------------------------------------ */

/* Bilinear. False near edges, where other faces have a share. */
static bool lookup(const float *const faces[IBL_FACES], int size,
                   const double direction[3], double rgba[4])
{
    double s, t;
    const float *texels = faces[shade_face(direction, &s, &t)];
    const double x = (s + 1) / 2 * size - 0.5, y = (t + 1) / 2 * size - 0.5;

    memset(rgba, 0, 4 * sizeof *rgba);
    if (!(x >= 0 && y >= 0 && x < size - 1 && y < size - 1))
        return false;
    for (int i = 0; i < 4; i++) {
        const int at_x = (int)x + i % 2, at_y = (int)y + i / 2;
        const double share = (1 - fabs(x - at_x)) * (1 - fabs(y - at_y));
        for (int k = 0; k < 4; k++)
            rgba[k] += share * (double)texels[4 * (at_y * size + at_x) + k];
    }
    return true;
}

static bool lookup_specular(const probe_texels *t, double lod,
                            const double direction[3], double rgba[4])
{
    double level[LEVELS][4];

    for (int i = 0; i < LEVELS; i++) {
        const float *faces[IBL_FACES];
        for (int f = 0; f < IBL_FACES; f++)
            faces[f] = t->specular[i][f];
        if (!lookup(faces, SIZE >> i, direction, level[i]))
            return false;
    }
    for (int k = 0; k < 4; k++)
        rgba[k] = (1 - lod) * level[0][k] + lod * level[1][k];
    return true;
}

static bool lookup_irradiance(const probe_texels *t, const double normal[3],
                              double rgba[4])
{
    const float *faces[IBL_FACES];

    for (int f = 0; f < IBL_FACES; f++)
        faces[f] = t->irradiance[f];
    return lookup(faces, VIEW_CAPTURE_IRRADIANCE, normal, rgba);
}

/* What the probes and the environment have together, of colours that are
 * multiplied by alpha; and the first one's share, and alpha. */
static void fill_in(const ibl_probe *probes, int count, const double point[3],
                    double rgba[][4], double rgb[3])
{
    double alpha[MOST];
    int order[MOST];
    ibl_probe_mix mix;

    for (int i = 0; i < count; i++) {
        alpha[i] = rgba[i][3];
        order[i] = i;
    }
    ibl_probes_blend(probes, count, order, point, alpha, &mix);
    for (int k = 0; k < 3; k++) {
        rgb[k] = mix.rest * (double)light[k];
        for (int i = 0; i < mix.count; i++)
            rgb[k] +=
                mix.weight[i] * rgba[mix.probe[i]][k] / alpha[mix.probe[i]];
    }
}

typedef struct scene_light {
    const view_room_draw *d;
    ibl_probe probes[MOST];
    probe_texels *texels[MOST];
} scene_light;

/* What is to be seen of a hit. False where that is hard to say. holes: the
 * first probe, of which there is a share there, has not seen what is
 * reflected. */
static bool shade(const scene_light *m, const room_hit *h, const double ray[3],
                  double rgb[3], bool *holes)
{
    double r[3], seen[MOST][4], from[MOST][4];
    double specular[3], diffuse[3], cosine = 0;
    const int count = count_probes(m->d);

    for (int k = 0; k < 3; k++)
        cosine += ray[k] * h->normal[k];
    for (int k = 0; k < 3; k++)
        r[k] = ray[k] - 2 * cosine * h->normal[k];
    for (int i = 0; i < count; i++) {
        const double lod =
            (double)(h->material->roughness * m->d->dynamic.lod_scale);
        double to[3];
        ibl_probe_parallax(&m->probes[i], h->point, r, to);
        if (!lookup_specular(m->texels[i], lod, to, seen[i]) ||
            !lookup_irradiance(m->texels[i], h->normal, from[i]))
            return false;
    }
    fill_in(m->probes, count, h->point, seen, specular);
    fill_in(m->probes, count, h->point, from, diffuse);
    for (int k = 0; k < 3; k++) {
        const double fss = (double)(h->material->f0[k] * table[0] + table[1]);
        rgb[k] = fss * specular[k] +
                 (1 - fss) * (double)h->material->albedo[k] * diffuse[k];
    }
    *holes =
        ibl_probe_influence(&m->probes[0], h->point) > 0.5 && seen[0][3] < 0.5;
    return true;
}

static double error_of(const float *pixel, const double rgb[3])
{
    double worst = 0;

    for (int k = 0; k < 3; k++)
        worst = fmax(worst,
                     fabs((double)pixel[k] - rgb[k]) / (0.02 + fabs(rgb[k])));
    return worst;
}

/* Whether a point is where a probe's influence falls to 0. */
static bool is_between(const scene_light *m, const double point[3])
{
    for (int i = 0; i < count_probes(m->d); i++) {
        const double x = ibl_probe_influence(&m->probes[i], point);
        if (x > 0.05 && x < 0.95)
            return true;
    }
    return false;
}

/* The floor, by what is said in C of the probes there are. Without blending
 * their influences have sharp borders. */
static void fills_holes_of(bool blend)
{
    const float *rgba;
    int floor = 0, filled = 0, between = 0, bad = 0;

    begin();
    on.s.blend = blend;
    on.s.seconds = 1;
    on.s.probes = 2;
    on.s.pitch = 35;
    on.s.fov = 75;
    const view_room_draw *d = draw(&rgba);
    NEED(count_probes(d) == 3);
    const view_camera c = view_scene_camera(&on.s, WIDTH, HEIGHT);
    scene_light m = {.d = d};
    for (int i = 0; i < count_probes(d); i++) {
        m.probes[i] = probe_of(d, i);
        m.texels[i] = read_probe(d, i);
        if (!blend)
            m.probes[i].blend = 0;
    }
    for (int i = 0; i < WIDTH * HEIGHT; i++) {
        double ray[3], rgb[3];
        bool hole;
        view_camera_ray(&c, WIDTH, HEIGHT, i % WIDTH, i / WIDTH, ray);
        const room_hit h = room_cast(d, c.eye, ray);
        if (!room_is_floor(&h) || !shade(&m, &h, ray, rgb, &hole))
            continue;
        floor++;
        filled += hole;
        between += is_between(&m, h.point);
        bad += !(error_of(rgba + 4 * i, rgb) < 0.02);
    }
    CHECK_MSG(floor > 1000 && filled > 100, "%d, %d", floor, filled);
    CHECK_MSG((between > 100) == blend, "%d", between);
    CHECK_MSG(bad <= floor / 100, "%d of %d pixels", bad, floor);
}

TEST(fills_holes)
{
    fills_holes_of(true);
}

TEST(without_blending)
{
    fills_holes_of(false);
}
