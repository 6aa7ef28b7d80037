/* SPDX-License-Identifier: MIT */
/*
 * Milliseconds of a capture of the viewer's room by size and method, medians of
 * runs in turns, and how far the methods' levels are from each other.
 */
#include "maps.h"
#include "room.h"
#include "view.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "common/clock.h"
#include "view/capture.h"

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
    view_room_draw draw;
    int size;
    view_capture *capture[METHODS];
    view_cubes cubes[METHODS];
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
        const bool bent = m == PARABOLOIDS || m == PARABOLOIDS_LIBRARY;
        j->capture[m] = view_capture_create(
            bent ? VIEW_PROBE_PARABOLOIDS : VIEW_PROBE_FACES, j->size);
        if (!j->capture[m] || !view_cubes_make(&j->cubes[m], j->size, 1) ||
            ibl_cube_alloc(j->ctx, j->size, ibl_default_levels(j->size),
                           &j->cube[m]) ||
            ibl_cube_alloc(j->ctx, VIEW_CAPTURE_IRRADIANCE, 1,
                           &j->irradiance[m]))
            fail("no captures");
    }
}

static void drop(job *j)
{
    for (int m = 0; m < METHODS; m++) {
        view_cubes_free(&j->cubes[m]);
        view_capture_free(j->capture[m]);
        ibl_cube_free(&j->cube[m]);
        ibl_cube_free(&j->irradiance[m]);
    }
}

/* An update in steps, as it is spread over frames: all, and the longest. */
static void update(job *j, int method, double ms[PARTS])
{
    view_capture *c = j->capture[method];
    const view_capture_shot shot = {.room = lit.room,
                                    .draw = j->draw,
                                    .far = 100,
                                    .to = &j->cubes[method],
                                    .cpu =
                                        method >= FACES_LIBRARY ? j->ctx : NULL,
                                    .timed = true};
    view_capture_state state = VIEW_CAPTURE_BEGUN;

    ms[ALL] = ms[LONGEST] = 0;
    ms[CPU] = -test_ms(CLOCK_PROCESS_CPUTIME_ID);
    while (state == VIEW_CAPTURE_BEGUN) {
        const double begin = ibl_now();
        state = view_capture_update(c, &shot, 1);
        const double step = 1e3 * (ibl_now() - begin);
        ms[ALL] += step;
        ms[LONGEST] = fmax(ms[LONGEST], step);
    }
    ms[CPU] += test_ms(CLOCK_PROCESS_CPUTIME_ID);
    if (state != VIEW_CAPTURE_DONE)
        fail("no update");
    memcpy(ms, view_capture_times(c), TIMES * sizeof *ms);
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
    for (int m = 0; m < METHODS; m++) {
        room_cube_read(j->cubes[m].specular, &j->cube[m]);
        room_cube_read(j->cubes[m].irradiance, &j->irradiance[m]);
    }
}

/* ---- report ------------------------------------------------------------ */

static void tell_error(const job *j, const char *what, int a, int b)
{
    printf("      %s: nRMSE of levels", what);
    for (int l = 0; l < j->cube[a].levels; l++)
        printf(" %.4f", cube_nrmse(&j->cube[a], &j->cube[b], l));
    printf(", irradiance %.4f\n",
           cube_nrmse(&j->irradiance[a], &j->irradiance[b], 0));
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

int main(void)
{
    job j = {.ctx = test_ctx(0, IBL_ISA_AUTO)};
    const view_camera any = {.near = 1, .far = 2};

    lit_begin(32, 32);
    const GLuint sky = room_cube_of(0.5F, 0.6F, 0.8F, 1);
    j.draw = lit_draw(&any);
    j.draw.eye[1] = 1.2;
    j.draw.environment = (view_room_environment){
        .specular = sky, .irradiance = sky, .sky = sky, .frame.diffuse = {1}};
    j.draw.table = room_table_of(0.9F, 0.05F);
    printf("%s\n", view_test_about());
    printf("%5s %-20s %10s %10s %10s %10s %10s %10s  ms\n", "size", "",
           "drawing", "levels", "irradiance", "all", "a step", "cpu");
    for (j.size = 64; j.size <= 512; j.size *= 2) {
        make(&j);
        measure(&j);
        tell(&j);
        drop(&j);
    }
    return 0;
}
