/* SPDX-License-Identifier: MIT */
/*
 * Milliseconds of a capture's update by size and method, and how far the
 * methods' levels are from each other: of the box of tests/box.h with a panel
 * of radiance 50, and of the room that the viewer shows. Arguments: samples,
 * and sizes, 64 and 64 128 256 by default.
 */
#include "box.h"
#include "room.h"
#include "view.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "view/capture.h"
#include "view/clock.h"

enum {
    RUNS = 7,
    PARTS = 4 /* drawing, levels, irradiance, all */
};

/* GPU; GPU of paraboloids; the library. */
enum {
    FACES,
    PARABOLOIDS,
    LIBRARY,
    METHODS
};

static const char *const names[METHODS] = {"faces, GPU", "paraboloids, GPU",
                                           "faces, library"};

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

static void make(job *j)
{
    for (int m = 0; m < METHODS; m++) {
        view_capture_options o = view_capture_options_default();
        o.kind =
            m == PARABOLOIDS ? VIEW_CAPTURE_PARABOLOIDS : VIEW_CAPTURE_FACES;
        o.size = j->size;
        o.samples = j->samples;
        o.cpu = m == LIBRARY ? j->ctx : NULL;
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

/* The methods take turns, so that a busy machine is busy for all. */
static void measure(job *j)
{
    for (int run = -1; run < RUNS; run++)
        for (int m = 0; m < METHODS; m++) {
            const double begin = view_clock();
            double ms[3];
            if (!view_capture_update(j->capture[m], j->eye, j->scene,
                                     j->cookie))
                fail("no update");
            const double all = 1e3 * (view_clock() - begin);
            view_capture_times(j->capture[m], ms);
            for (int p = 0; p < PARTS && run >= 0; p++)
                j->ms[m][p][run] = p < 3 ? ms[p] : all;
        }
    for (int m = 0; m < METHODS; m++)
        if (!view_capture_read(j->capture[m], &j->cube[m]) ||
            !view_capture_read_irradiance(j->capture[m], &j->irradiance[m]))
            fail("nothing to read");
}

/* ---- report ------------------------------------------------------------ */

static int compare(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

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
        printf("%5d %-18s", j->size, names[m]);
        for (int p = 0; p < PARTS; p++) {
            qsort(j->ms[m][p], RUNS, sizeof j->ms[m][p][0], compare);
            printf(" %10.1f", j->ms[m][p][RUNS / 2]);
        }
        printf("\n");
    }
    tell_error(j, "paraboloids from faces", PARABOLOIDS, FACES);
    tell_error(j, "GPU from library", FACES, LIBRARY);
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
    s->draw.hidden = 0;
    s->draw.environment = (view_room_environment){
        .specular = sky, .irradiance = sky, .sky = sky, .irradiance_scale = 1};
    s->draw.table = room_table_of(0.9F, 0.05F);
}

static void bench(job *j, const char *name, int count, char **sizes)
{
    static char *usual[] = {"64", "128", "256"};

    printf("%s\n%5s %-18s %10s %10s %10s %10s  ms\n", name, "size", "",
           "drawing", "levels", "irradiance", "all");
    for (int i = 0; i < (count ? count : 3); i++) {
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
    job j = {.samples = argc > 1 ? atoi(argv[1]) : 64};
    const int count = argc > 2 ? argc - 2 : 0;
    box_scene box = {.panel = 50};
    room_scene room;

    j.ctx = test_ctx(0, IBL_ISA_AUTO);
    if (!view_test_begin(32, 32) || !box_begin(&box))
        fail("no OpenGL in memory");
    room_begin(&room);
    printf("%d samples, %s\n", j.samples, view_test_about());
    j.scene = box_draw, j.cookie = &box, j.eye = in_box;
    bench(&j, "box", count, argv + 2);
    j.scene = room_draw, j.cookie = &room, j.eye = in_room;
    bench(&j, "room", count, argv + 2);
    view_room_free(room.room);
    box_end(&box);
    view_test_end();
    ibl_ctx_free(j.ctx);
    return 0;
}
