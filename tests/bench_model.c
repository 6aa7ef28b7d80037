/* SPDX-License-Identifier: MIT */
/*
 * The error of what the viewer draws of a model by a set, over all rotations of
 * the map and all views: pictures of copies of the model, each turned at
 * random, that lookups draw, against the same by the integral over the map's
 * pixels.
 *
 *     bench_model SET MODEL [PICTURES [COPIES [EDGE [SAMPLES]]]]
 *
 * Prints the nRMSE, in %: the root of the sum of squared differences over all
 * pixels and pictures, over that of the squares of the integral. Then its
 * standard error, by leaving out each picture in turn, and the noise of the
 * integral, which has no part in the nRMSE but makes it uncertain. Occlusion
 * and emission are left out: neither is looked up.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "scene/scene.h"
#include "view.h"
#include "view/renderer.h"

enum {
    MOST_PICTURES = 256
};

static const double degree = 3.14159265358979323846 / 180;

typedef struct bench {
    ibl_ctx *ctx;
    baked_set set;
    ibl_scene scene;
    ibl_scene_draw *own; /* of the scene; its draws are those of all copies */
    int own_count;
    double middle[3], radius; /* of a sphere around the model */
    view_renderer *renderer;
    test_random random;
    int pictures, copies, edge, samples; /* edge: pixels of a copy */
    /* Sums of squares of each picture. */
    double error2[MOST_PICTURES], truth2[MOST_PICTURES], noise2[MOST_PICTURES];
    float *wide, *drawn, *truth[2]; /* RGB of pictures */
} bench;

/* ---- copies --------------------------------------------------------------
 */

static void place(const double m[16], const float p[3], double to[3])
{
    for (int k = 0; k < 3; k++)
        to[k] = m[k] * p[0] + m[4 + k] * p[1] + m[8 + k] * p[2] + m[12 + k];
}

static void find_sphere(bench *b)
{
    const ibl_scene *s = &b->scene;
    for (int k = 0; k < 3; k++)
        b->middle[k] = 0.5 * (s->bounds[0][k] + s->bounds[1][k]);
    for (int i = 0; i < s->draw_count; i++) {
        const ibl_scene_primitive *p = &s->primitives[s->draws[i].primitive];
        for (size_t v = 0; v < p->vertex_count; v++) {
            double at[3], sum = 0;
            place(s->draws[i].to_world, p->position + 3 * v, at);
            for (int k = 0; k < 3; k++)
                sum += pow(at[k] - b->middle[k], 2);
            b->radius = fmax(b->radius, sqrt(sum));
        }
    }
}

static bool load(bench *b, const char *set, const char *model)
{
    if (!view_set_open(b->ctx, &(view_request){.path = set}, &b->set) ||
        ibl_scene_read(b->ctx, model, false, &b->scene))
        return false;
    ibl_scene *s = &b->scene;
    for (int i = 0; i < s->material_count; i++) {
        memset(s->materials[i].emissive, 0, sizeof s->materials[i].emissive);
        s->materials[i].occlusion_strength = 0;
    }
    find_sphere(b);
    b->own = s->draws;
    b->own_count = s->draw_count;
    s->draw_count *= b->copies;
    s->draws = calloc((size_t)s->draw_count, sizeof *s->draws);
    return s->draws && b->radius > 0;
}

/* A rotation, all alike probable: Shoemake 1992, "Uniform Random Rotations". */
static void draw_rotation(test_random *random, double m[3][3])
{
    const double u = test_random_unit(random), turn = 360 * degree;
    const double a = turn * test_random_unit(random);
    const double b = turn * test_random_unit(random);
    const double x = sqrt(1 - u) * sin(a), y = sqrt(1 - u) * cos(a);
    const double z = sqrt(u) * sin(b), w = sqrt(u) * cos(b);
    const double rows[3][3] = {
        {1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)},
        {2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)},
        {2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)}};
    memcpy(m, rows, sizeof rows);
}

static void turn_draw(const bench *b, const double m[3][3],
                      const double centre[3], const ibl_scene_draw *from,
                      ibl_scene_draw *to)
{
    *to = *from;
    for (int i = 0; i < 16; i++) {
        double sum = i < 12 ? 0 : centre[i % 4 % 3];
        for (int k = 0; k < 3 && i % 4 < 3; k++)
            sum += m[i % 4][k] * (from->to_world[i / 4 * 4 + k] -
                                  (i < 12 ? 0 : b->middle[k]));
        if (i % 4 < 3)
            to->to_world[i] = sum;
    }
}

/* Turns the copies and places them along X, where a camera without yaw sees
 * each beside the others at any pitch. */
static void place_copies(bench *b)
{
    ibl_scene *s = &b->scene;
    for (int k = 0; k < 3; k++) {
        s->bounds[1][k] = b->radius * (k ? 1 : b->copies);
        s->bounds[0][k] = -s->bounds[1][k];
    }
    for (int i = 0; i < b->copies; i++) {
        const double centre[3] = {(2 * i + 1 - b->copies) * b->radius, 0, 0};
        double m[3][3];
        draw_rotation(&b->random, m);
        for (int k = 0; k < b->own_count; k++)
            turn_draw(b, m, centre, &b->own[k],
                      &s->draws[i * b->own_count + k]);
    }
}

/* ---- pictures ------------------------------------------------------------
 */

static view_settings settings(bench *b)
{
    view_settings s = view_settings_default();
    s.mode = VIEW_MODEL;
    s.background = VIEW_BACKGROUND_COLOUR;
    s.antialias = 1;
    s.distance = 4;
    s.fov = 2 * atan(1.0 / (b->copies * s.distance)) / degree;
    s.pitch = asin(test_random_between(&b->random, -1, 1)) / degree;
    s.pitch = fmin(fmax(s.pitch, -89), 89);
    s.turn = test_random_between(&b->random, 0, 360);
    s.reflection = b->set.baked.file[IBL_CONTENT_LOBE_TABLE].texture.data
                       ? VIEW_TABLE_LOBES
                       : VIEW_SPLIT_SUM;
    s.compare = VIEW_SPLIT;
    return s;
}

/* Draws with `more` columns left and right, which leave all rays as they are
 * and give the integral other samples; reads the columns between. */
static bool draw(const bench *b, const view_settings *s, int more, float *drawn,
                 float *truth)
{
    const int edge = b->edge, row = edge * b->copies, width = row + 2 * more;
    float *const to[2] = {drawn, truth};
    view_renderer_pace(b->renderer, b->samples);
    view_settings side[2] = {*s, *s};
    side[1].reflection = VIEW_REFERENCE;
    if (!view_renderer_draw(b->renderer, side, &(view_area){0, 0, width, edge}))
        return false;
    for (int i = 0; i < 2; i++) {
        if (!view_renderer_read(b->renderer, i, b->wide))
            return false;
        for (int y = 0; y < edge; y++)
            memcpy(to[i] + 3 * row * y, b->wide + 3 * (width * y + more),
                   3 * sizeof(float) * (size_t)row);
    }
    return true;
}

/* The noise of both integrals is independent, so it has no part in the mean of
 * products. */
static void add(bench *b, int picture)
{
    const int floats = 3 * b->copies * b->edge * b->edge;
    for (int i = 0; i < floats; i++) {
        const double drawn = b->drawn[i];
        const double one = b->truth[0][i], two = b->truth[1][i];
        b->error2[picture] += (drawn - one) * (drawn - two);
        b->truth2[picture] += one * two;
        b->noise2[picture] += (one - two) * (one - two) / 2;
    }
}

static bool measure(bench *b, int picture)
{
    const view_settings s = settings(b);
    const bool ok = draw(b, &s, 1, b->drawn, b->truth[1]) &&
                    draw(b, &s, 0, b->drawn, b->truth[0]);
    if (ok)
        add(b, picture);
    return ok;
}

/* ---- figures -------------------------------------------------------------
 */

/* Without a picture; -1: of all. */
static double ratio(const bench *b, const double *sums, int without)
{
    double sum = 0, truth = 0;
    for (int i = 0; i < b->pictures; i++)
        if (i != without) {
            sum += sums[i];
            truth += b->truth2[i];
        }
    return 100 * sqrt(fmax(sum, 0) / truth);
}

static void print(const bench *b)
{
    const double all = ratio(b, b->error2, -1);
    double spread = 0;
    for (int i = 0; i < b->pictures && b->pictures > 1; i++)
        spread += pow(ratio(b, b->error2, i) - all, 2);
    printf("%.3f +- %.3f, noise %.3f\n", all,
           sqrt(spread * (b->pictures - 1) / b->pictures),
           ratio(b, b->noise2, -1));
}

static bool run(bench *b)
{
    const size_t pixels =
        (size_t)b->edge * ((size_t)b->copies * (size_t)b->edge + 2);
    b->wide = test_alloc(3 * pixels, sizeof(float));
    b->drawn = test_alloc(3 * pixels, sizeof(float));
    for (int i = 0; i < 2; i++)
        b->truth[i] = test_alloc(3 * pixels, sizeof(float));
    place_copies(b);
    b->renderer = view_renderer_create();
    view_model *m = view_model_create(b->ctx, &b->scene, "copies");
    bool ok = b->renderer && m && view_renderer_load(b->renderer, &b->set);
    if (ok)
        view_renderer_model(b->renderer, m);
    for (int i = 0; i < b->pictures && ok; i++)
        ok = measure(b, i);
    view_model_free(m);
    view_renderer_free(b->renderer);
    return ok;
}

static int argument(char **argv, int argc, int i, int usual)
{
    return argc > i ? atoi(argv[i]) : usual;
}

int main(int argc, char **argv)
{
    static bench b;
    if (argc < 3) {
        fprintf(stderr, "usage: bench_model SET MODEL [PICTURES [COPIES [EDGE "
                        "[SAMPLES]]]]\n");
        return 2;
    }
    b.pictures = argument(argv, argc, 3, 48);
    b.copies = argument(argv, argc, 4, 16);
    b.edge = argument(argv, argc, 5, 32);
    b.samples = argument(argv, argc, 6, 64);
    b.random.state = 5;
    if (b.pictures < 1 || b.pictures > MOST_PICTURES || b.copies < 1 ||
        b.edge < 1 || b.samples < 1)
        return 2;
    b.ctx = view_test_ctx(0);
    view_test_begin(b.copies * b.edge + 2, b.edge);
    const bool ok = load(&b, argv[1], argv[2]) && run(&b);
    if (ok)
        print(&b);
    free(b.own);
    ibl_scene_free(&b.scene);
    view_set_free(&b.set);
    view_test_close();
    return !ok;
}
