/* SPDX-License-Identifier: MIT */
/*
 * Milliseconds of a capture's update by size and method, medians of runs in
 * turns, and how far the methods' levels are from each other: of the room that
 * the viewer shows, or of the box of tests/box.h with a panel of radiance 50.
 *
 *     bench_capture [room|box [SAMPLES [SIZE...]]]
 *
 * room, 64 and 64 128 256 512 by default.
 */
#include "box.h"
#include "room.h"
#include "view.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "view/capture.h"
#include "view/clock.h"

enum {
    RUNS = 7, /* of large captures fewer */
    LARGE_RUNS = 5,
    TIMES = 3, /* drawing, levels, irradiance */
    ALL = TIMES,
    LONGEST, /* step */
    CPU,     /* time of all threads */
    PARTS
};

/* Filtered on the GPU, or by the library. */
enum {
    FACES,
    PARABOLOIDS,
    FACES_LIBRARY,
    PARABOLOIDS_LIBRARY,
    METHODS
};

static const char *const names[METHODS] = {
    "faces, GPU", "paraboloids, GPU", "faces, library", "paraboloids, library"};

typedef struct job {
    ibl_ctx *ctx;
    view_capture_scene *scene;
    void *cookie;
    const double *eye;
    int size, samples;
    view_capture *capture[METHODS];
    ibl_cube cube[METHODS], irradiance[METHODS];
    double ms[METHODS][PARTS][RUNS];
} job;

static void fail(const char *what)
{
    fprintf(stderr, "bench_capture: %s\n", what);
    exit(1);
}

static int runs(const job *j)
{
    return j->size < 512 ? RUNS : LARGE_RUNS;
}

static void make(job *j)
{
    for (int m = 0; m < METHODS; m++) {
        view_capture_options o = view_capture_options_default();
        o.kind = m == PARABOLOIDS || m == PARABOLOIDS_LIBRARY
                     ? VIEW_CAPTURE_PARABOLOIDS
                     : VIEW_CAPTURE_FACES;
        o.size = j->size;
        o.samples = j->samples;
        o.cpu = m >= FACES_LIBRARY ? j->ctx : NULL;
        o.timed = true;
        j->capture[m] = view_capture_create(&o);
        if (!j->capture[m] ||
            ibl_cube_alloc(j->ctx, j->size, view_capture_levels(j->capture[m]),
                           &j->cube[m]) ||
            ibl_cube_alloc(j->ctx, VIEW_CAPTURE_IRRADIANCE, 1,
                           &j->irradiance[m]))
            fail("no captures");
    }
}

static void drop(job *j)
{
    for (int m = 0; m < METHODS; m++) {
        view_capture_free(j->capture[m]);
        ibl_cube_free(&j->cube[m]);
        ibl_cube_free(&j->irradiance[m]);
    }
}

/* An update in steps, as it is spread over frames: all, and the longest. */
static void update(job *j, int method, double ms[PARTS])
{
    view_capture *c = j->capture[method];
    bool done = false;

    ms[ALL] = ms[LONGEST] = 0;
    ms[CPU] = -test_ms(CLOCK_PROCESS_CPUTIME_ID);
    for (int i = view_capture_steps(c); i > 0; i--) {
        const double begin = view_clock();
        done = view_capture_advance(c, j->eye, j->scene, j->cookie, 1);
        const double step = 1e3 * (view_clock() - begin);
        ms[ALL] += step;
        ms[LONGEST] = fmax(ms[LONGEST], step);
    }
    ms[CPU] += test_ms(CLOCK_PROCESS_CPUTIME_ID);
    if (!done)
        fail("no update");
    view_capture_times(c, ms);
}

/* The methods take turns, so that a busy machine is busy for all. */
static void measure(job *j)
{
    for (int run = -1; run < runs(j); run++)
        for (int m = 0; m < METHODS; m++) {
            double ms[PARTS];
            update(j, m, ms);
            for (int p = 0; p < PARTS && run >= 0; p++)
                j->ms[m][p][run] = ms[p];
        }
    for (int m = 0; m < METHODS; m++)
        if (!view_capture_read(j->capture[m], &j->cube[m]) ||
            !view_capture_read_irradiance(j->capture[m], &j->irradiance[m]))
            fail("nothing to read");
}

/* ---- report ------------------------------------------------------------ */

static double nrmse(const ibl_cube *a, const ibl_cube *b, int level)
{
    const int n = ibl_cube_edge(a->size, level);
    const float *p = ibl_cube_face(a, level, 0);
    const float *q = ibl_cube_face(b, level, 0);
    double error = 0, sum = 0;

    for (int i = 0; i < 3 * IBL_FACES * n * n; i++) {
        error += pow((double)p[i] - q[i], 2);
        sum += pow(q[i], 2);
    }
    return sqrt(error / sum);
}

static void tell_error(const job *j, const char *what, int a, int b)
{
    printf("      %s: nRMSE of levels", what);
    for (int l = 0; l < j->cube[a].levels; l++)
        printf(" %.4f", nrmse(&j->cube[a], &j->cube[b], l));
    printf(", irradiance %.4f\n",
           nrmse(&j->irradiance[a], &j->irradiance[b], 0));
}

static void tell(job *j)
{
    for (int m = 0; m < METHODS; m++) {
        printf("%5d %-20s", j->size, names[m]);
        for (int p = 0; p < PARTS; p++)
            printf(" %10.1f", test_median(j->ms[m][p], runs(j)));
        printf("\n");
    }
    tell_error(j, "paraboloids from faces", PARABOLOIDS, FACES);
    tell_error(j, "GPU from library", FACES, FACES_LIBRARY);
}

/* ---- scenes ------------------------------------------------------------ */

typedef struct room_scene {
    view_room *room;
    view_room_draw draw;
} room_scene;

static void room_draw(void *cookie, const double clip[16], const double eye[3],
                      int size, int side)
{
    room_scene *s = cookie;

    (void)size;
    for (int i = 0; i < 16; i++)
        s->draw.clip[i] = clip[i];
    for (int k = 0; k < 3; k++)
        s->draw.eye[k] = eye[k];
    s->draw.paraboloid = side >= 0;
    view_room_render(s->room, &s->draw);
}

static void room_begin(room_scene *s)
{
    const GLuint sky = room_cube_of(0.5F, 0.6F, 0.8F, 1);

    *s = (room_scene){.room = view_room_create()};
    if (!s->room)
        fail("no room");
    s->draw.moving = true;
    s->draw.environment = (view_room_environment){
        .specular = sky, .irradiance = sky, .sky = sky, .irradiance_scale = 1};
    s->draw.table = room_table_of(0.9F, 0.05F);
}

static void bench(job *j, const char *name, int count, char **sizes)
{
    static char *usual[] = {"64", "128", "256", "512"};

    printf("%s, %d samples, %s\n", name, j->samples, view_test_about());
    printf("%5s %-20s %10s %10s %10s %10s %10s %10s  ms\n", "size", "",
           "drawing", "levels", "irradiance", "all", "a step", "cpu");
    for (int i = 0; i < (count ? count : 4); i++) {
        j->size = atoi(count ? sizes[i] : usual[i]);
        make(j);
        measure(j);
        tell(j);
        drop(j);
    }
}

int main(int argc, char **argv)
{
    static const double in_box[3] = {0.3, 0.2, -0.4}, in_room[3] = {0, 1.2, 0};
    const char *name = argc > 1 ? argv[1] : "room";
    const bool is_box = !strcmp(name, "box");
    job j = {.samples = argc > 2 ? atoi(argv[2]) : 64};
    const int count = argc > 3 ? argc - 3 : 0;
    box_scene box = {.panel = 50};
    room_scene room;

    if (!is_box && strcmp(name, "room") != 0) {
        fprintf(stderr,
                "usage: bench_capture [room|box [SAMPLES [SIZE...]]]\n");
        return 2;
    }
    j.ctx = test_ctx(0, IBL_ISA_AUTO);
    if (!view_test_begin(32, 32) || !box_begin(&box))
        fail("no OpenGL in memory");
    room_begin(&room);
    j.scene = is_box ? box_draw : room_draw;
    j.cookie = is_box ? (void *)&box : (void *)&room;
    j.eye = is_box ? in_box : in_room;
    bench(&j, name, count, argv + 3);
    view_room_free(room.room);
    box_end(&box);
    view_test_end();
    ibl_ctx_free(j.ctx);
    return 0;
}
