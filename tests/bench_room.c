/* SPDX-License-Identifier: MIT */
/* Milliseconds of a frame of the room by how many probes light it, with masks
 * of tiles and with each pixel going through all probes; and what it looks
 * like. Arguments: width, height, and how the names of PNGs begin that are to
 * be written. */
#include "room.h"
#include "view.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "view/baked_set.h"
#include "view/capture.h"
#include "view/clock.h"
#include "view/picture.h"
#include "view/scene_locals.h"
#include "view/upload.h"

enum {
    RUNS = 5
};

static bool write_picture(ibl_ctx *ctx, const char *path,
                          const room_target *target)
{
    const size_t values = 3 * (size_t)target->width * target->height;
    float *linear = room_target_read(target);
    unsigned char *rgb = malloc(values);

    for (size_t i = 0; rgb && i < values; i++) {
        const double x = linear[4 * (i / 3) + i % 3];
        rgb[i] = (unsigned char)(255 * pow(x / (1 + x), 1 / 2.2) + 0.5);
    }
    const bool ok = rgb && view_picture_write(ctx, path, target->width,
                                              target->height, rgb);
    free(rgb);
    free(linear);
    return ok;
}

static bool load(const baked_set *set, view_room_draw *d)
{
    view_room_environment *e = &d->environment;

    e->specular = view_upload(&set->texture[VIEW_SPECULAR], "specular");
    e->irradiance = view_upload(&set->texture[VIEW_IRRADIANCE], "irradiance");
    e->sky = set->texture[VIEW_SKY].data
                 ? view_upload(&set->texture[VIEW_SKY], "sky")
                 : e->specular;
    e->lod[0] = (float)set->lod_scale;
    e->lod[1] = (float)set->lod_offset;
    e->lod[2] = (float)(set->texture[VIEW_SPECULAR].levels - 1);
    e->lod[3] = (float)set->mapping;
    e->irradiance_scale = (float)set->irradiance_scale;
    d->table = view_upload(&set->texture[VIEW_LUT], "table");
    return e->specular && e->irradiance && e->sky && d->table;
}

/* ---- what is measured ---------------------------------------------------- */

typedef enum sun_kind {
    NO_SUN,
    UNSHADOWED,
    SHADOWED,
    MOVED /* its shadows have to be made anew */
} sun_kind;

static const struct {
    const char *name;
    int locals; /* place in counts + 1, 0: none */
    bool dynamic, untiled, flat;
    sun_kind sun;
} cases[] = {
    {"none", 0, false, false, false, NO_SUN},
    {"dynamic", 0, true, false, false, NO_SUN},
    {"dynamic-flat", 0, true, false, true, NO_SUN},
    {"local-1", 1, false, false, false, NO_SUN},
    {"local-1-untiled", 1, false, true, false, NO_SUN},
    {"local-8", 2, false, false, false, NO_SUN},
    {"local-8-untiled", 2, false, true, false, NO_SUN},
    {"local-64", 3, false, false, false, NO_SUN},
    {"local-64-untiled", 3, false, true, false, NO_SUN},
    {"both-64", 3, true, false, false, NO_SUN},
    {"dynamic-sun-unshadowed", 0, true, false, false, UNSHADOWED},
    {"dynamic-sun", 0, true, false, false, SHADOWED},
    {"dynamic-sun-moved", 0, true, false, false, MOVED},
};
static const int counts[] = {1, 8, 64};
enum {
    CASES = sizeof cases / sizeof *cases,
    COUNTS = sizeof counts / sizeof *counts
};

typedef struct bench {
    ibl_ctx *ctx;
    view_room *room;
    view_room_draw draw; /* what of it all draws share */
    room_target target;
    view_room_sun sun;
    view_capture *capture;
    view_scene_locals *locals[COUNTS];
    const char *name; /* of pictures; NULL: none */
} bench;

static void capture_scene(void *cookie, const double clip[16],
                          const double eye[3], int size, int side)
{
    const bench *b = cookie;
    view_room_draw d = b->draw;

    (void)size;
    memcpy(d.clip, clip, sizeof d.clip);
    memcpy(d.eye, eye, sizeof d.eye);
    d.paraboloid = side >= 0;
    view_room_render(b->room, &d);
}

static void use_dynamic(bench *b, view_room_draw *d)
{
    const float last = (float)(view_capture_levels(b->capture) - 1);
    ibl_probe *p = &d->dynamic.probe;

    d->dynamic =
        (view_room_dynamic){.specular = view_capture_specular(b->capture),
                            .irradiance = view_capture_irradiance(b->capture),
                            .lod_scale = last,
                            .last_level = last,
                            .probe = {.position = {0, 0.9, 0}, .has_proxy = 1}};
    for (int k = 0; k < 3; k++) {
        p->influence.centre[k] = p->proxy.centre[k] = view_room_centre[k];
        p->influence.half[k] = 6;
        p->proxy.half[k] = view_room_half[k];
    }
}

/* The dynamic one lit by itself, and all local ones by it. */
static bool capture(bench *b)
{
    const double middle[3] = {0, 0.9, 0};
    view_capture_options o = view_capture_options_default();
    double ms[3];

    o.size = 128;
    o.timed = true;
    if (!(b->capture = view_capture_create(&o)))
        return false;
    for (int bounce = 0; bounce < 3; bounce++) {
        if (!view_capture_update(b->capture, middle, capture_scene, b))
            return false;
        use_dynamic(b, &b->draw);
    }
    view_capture_times(b->capture, ms);
    printf("dynamic, 128: %.1f ms drawn, %.1f levels, %.1f irradiance\n", ms[0],
           ms[1], ms[2]);
    o.size = 64;
    for (int i = 0; i < COUNTS; i++) {
        if (!(b->locals[i] = view_scene_locals_create(&o, counts[i])))
            return false;
        const double before = view_clock();
        for (int k = 0; k < counts[i]; k++)
            if (!view_scene_locals_capture(b->locals[i], k, o.far,
                                           capture_scene, b))
                return false;
        gl.Finish();
        printf("%d local, 64: %.1f ms each\n", counts[i],
               1e3 * (view_clock() - before) / counts[i]);
    }
    return true;
}

static double draw(bench *b, int i)
{
    view_room_draw d = b->draw;

    d.dynamic = (view_room_dynamic){0};
    if (cases[i].dynamic)
        use_dynamic(b, &d);
    if (cases[i].locals)
        d.locals = view_scene_locals_drawn(b->locals[cases[i].locals - 1]);
    d.untiled = cases[i].untiled;
    d.parallax = !cases[i].flat;
    d.shadows = cases[i].sun != UNSHADOWED;
    if (cases[i].sun != NO_SUN)
        d.environment.sun = b->sun;
    room_target_bind(&b->target);
    if (cases[i].sun == SHADOWED)
        view_room_render(b->room, &d);
    if (cases[i].sun == MOVED)
        d.environment.turn += 1;
    gl.Finish();
    const double before = view_clock();
    view_room_render(b->room, &d);
    gl.Finish();
    return 1e3 * (view_clock() - before);
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
    for (int i = 0; ok && i < CASES; i++) {
        char path[400];
        printf("%-24s %7.2f ms\n", cases[i].name, test_median(ms[i], RUNS));
        if (!b->name)
            continue;
        draw(b, i);
        snprintf(path, sizeof path, "%s%s.png", b->name, cases[i].name);
        ok = write_picture(b->ctx, path, &b->target);
    }
    for (int i = 0; i < COUNTS; i++)
        view_scene_locals_free(b->locals[i]);
    view_capture_free(b->capture);
    return ok;
}

int main(int argc, char **argv)
{
    const int width = argc > 1 ? atoi(argv[1]) : 1280;
    const int height = argc > 2 ? atoi(argv[2]) : 720;
    const double eye[3] = {1.6, 1.9, 3.6}, at[3] = {-0.5, 1, -1};
    bench b = {.name = argc > 3 ? argv[3] : NULL};
    baked_set set = {0};
    int status = 1;

    if (width < 1 || height < 1) {
        fprintf(stderr, "bench_room [WIDTH HEIGHT [NAME]]\n");
        return 2;
    }
    b.ctx = test_ctx(0, IBL_ISA_AUTO);
    if (view_test_begin(width, height))
        b.room = view_room_create();
    if (b.room && view_set_bake(b.ctx, test_data("sky.exr"), &set)) {
        const view_camera camera = room_camera(eye, at, 65, width, height);
        b.draw = room_draw_by(&camera);
        room_target_make(&b.target, width, height);
        if (load(&set, &b.draw) &&
            view_room_sun_find(&set.texture[VIEW_SPECULAR], &b.sun)) {
            printf("%d x %d, %s\n", width, height, view_test_about());
            status = !run(&b);
        }
        room_target_free(&b.target);
    }
    view_room_free(b.room);
    view_set_free(&set);
    view_test_end();
    ibl_ctx_free(b.ctx);
    return status;
}
