/* SPDX-License-Identifier: MIT */
/* Milliseconds of a frame of the room by how many local probes light it, with
 * masks of tiles and with each pixel going through all probes. Arguments: width
 * and height. */
#include "room.h"
#include "view.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/clock.h"
#include "view/baked_set.h"
#include "view/scene_captures.h"
#include "view/upload.h"

enum {
    RUNS = 5
};

static bool load(const baked_set *set, view_room_draw *d)
{
    view_room_environment *e = &d->environment;

    e->specular = view_upload(&set->texture[VIEW_SPECULAR], false, "specular");
    e->irradiance =
        view_upload(&set->texture[VIEW_IRRADIANCE], false, "irradiance");
    e->sky = set->texture[VIEW_SKY].data
                 ? view_upload(&set->texture[VIEW_SKY], false, "sky")
                 : e->specular;
    e->frame.lod[0] = (float)set->lod_scale;
    e->frame.lod[1] = (float)set->lod_offset;
    e->frame.lod[2] = (float)(set->texture[VIEW_SPECULAR].levels - 1);
    e->frame.lod[3] = (float)set->mapping;
    e->frame.diffuse[0] = (float)set->irradiance_scale;
    d->table = view_upload(&set->texture[VIEW_LUT], false, "table");
    return e->specular && e->irradiance && e->sky && d->table;
}

/* ---- what is measured ---------------------------------------------------- */

static const struct {
    const char *name;
    int locals; /* place in counts + 1, 0: none */
    bool untiled;
} cases[] = {{"none", 0, false},     {"local-1", 1, false},
             {"local-8", 2, false},  {"local-64", 3, false},
             {"untiled-1", 1, true}, {"untiled-8", 2, true},
             {"untiled-64", 3, true}};
static const int counts[] = {1, 8, 64};
enum {
    CASES = sizeof cases / sizeof *cases,
    COUNTS = sizeof counts / sizeof *counts
};

typedef struct bench {
    view_room_draw draw; /* what of it all draws share */
    view_cubes cubes[COUNTS];
    ibl_probe probe[COUNTS][VIEW_MAX_LOCALS];
} bench;

enum {
    SIZE = 64
};

static bool capture(bench *b)
{
    view_capture *c = view_capture_create(VIEW_PROBE_FACES, SIZE);
    bool ok = c;

    for (int i = 0; i < COUNTS && ok; i++) {
        ok = view_cubes_make(&b->cubes[i], SIZE, counts[i]);
        view_scene_place(b->probe[i], counts[i]);
        for (int k = 0; k < counts[i] && ok; k++) {
            view_capture_shot s = {.room = lit.room,
                                   .draw = b->draw,
                                   .far = 100,
                                   .to = &b->cubes[i],
                                   .layer = k};
            memcpy(s.draw.eye, b->probe[i][k].position, sizeof s.draw.eye);
            ok = view_capture_update(c, &s, 0) == VIEW_CAPTURE_DONE;
        }
    }
    view_capture_free(c);
    return ok;
}

static view_probe_maps maps_of(const bench *b, int i)
{
    const float last = (float)(ibl_default_levels(SIZE) - 1);

    return (view_probe_maps){.count = counts[i],
                             .probe = b->probe[i],
                             .specular = b->cubes[i].specular,
                             .irradiance = b->cubes[i].irradiance,
                             .lod_scale = last,
                             .last_level = last,
                             .irradiance_scale = 1};
}

static double draw(bench *b, int i)
{
    view_room_draw d = b->draw;

    if (cases[i].locals)
        d.locals = maps_of(b, cases[i].locals - 1);
    d.untiled = cases[i].untiled;
    room_target_bind(&lit.target);
    gl.Finish();
    const double before = ibl_now();
    view_room_render(lit.room, &d);
    gl.Finish();
    return 1e3 * (ibl_now() - before);
}

/* Each in turn, so that other load on the machine is in all of them. */
static bool run(bench *b)
{
    static double ms[CASES][RUNS];
    bool ok = capture(b);

    for (int n = -1; ok && n < RUNS; n++)
        for (int i = 0; i < CASES; i++) {
            const double took = draw(b, i);
            if (n >= 0)
                ms[i][n] = took;
        }
    for (int i = 0; ok && i < CASES; i++)
        printf("%-24s %7.2f ms\n", cases[i].name, test_median(ms[i], RUNS));
    for (int i = 0; i < COUNTS; i++)
        view_cubes_free(&b->cubes[i]);
    return ok;
}

int main(int argc, char **argv)
{
    const int width = argc > 1 ? atoi(argv[1]) : 1280;
    const int height = argc > 2 ? atoi(argv[2]) : 720;
    const double eye[3] = {1.6, 1.9, 3.6}, at[3] = {-0.5, 1, -1};
    bench b = {0};
    baked_set set = {0};
    int status = 1;

    if (width < 1 || height < 1) {
        fprintf(stderr, "bench_room [WIDTH HEIGHT]\n");
        return 2;
    }
    lit_begin(width, height);
    if (view_set_bake(test_ctx(0, IBL_ISA_AUTO),
                      &(view_request){.path = test_data("sky.exr")}, &set)) {
        const view_camera camera = room_camera(eye, at, 65, width, height);
        b.draw = room_draw_by(&camera);
        if (load(&set, &b.draw)) {
            printf("%d x %d, %s\n", width, height, view_test_about());
            status = !run(&b);
        }
    }
    view_set_free(&set);
    return status;
}
