/* SPDX-License-Identifier: MIT */
/* Milliseconds of a frame of the room, and what it looks like. Arguments:
 * width, height, and a PNG to write. */
#include "room.h"
#include "view.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "view/clock.h"
#include "view/picture.h"
#include "view/set.h"
#include "view/upload.h"

enum {
    RUNS = 9
};

static int compare(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static double measure(view_room *room, const room_target *target,
                      const view_room_draw *d)
{
    double ms[RUNS];

    for (int i = -1; i < RUNS; i++) {
        const double before = view_clock();
        room_target_bind(target);
        view_room_render(room, d);
        gl.Finish();
        if (i >= 0)
            ms[i] = 1e3 * (view_clock() - before);
    }
    qsort(ms, RUNS, sizeof ms[0], compare);
    return ms[RUNS / 2];
}

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

static bool load(const view_set *set, view_room_draw *d)
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

int main(int argc, char **argv)
{
    const int width = argc > 1 ? atoi(argv[1]) : 640;
    const int height = argc > 2 ? atoi(argv[2]) : 360;
    const double eye[3] = {3.8, 2.3, 4.4}, at[3] = {-0.8, 1.2, -1};
    ibl_ctx *ctx;
    view_set set = {0};
    view_room *room = NULL;
    int status = 1;

    if (width < 1 || height < 1) {
        fprintf(stderr, "bench_room [WIDTH HEIGHT [PICTURE.png]]\n");
        return 2;
    }
    ctx = test_ctx(0, IBL_ISA_AUTO);
    if (view_test_begin(width, height))
        room = view_room_create();
    if (room && view_set_bake(ctx, test_data("sky.exr"), &set)) {
        const view_camera camera = room_camera(eye, at, 65, width, height);
        view_room_draw d = room_draw_by(&camera);
        room_target target;
        room_target_make(&target, width, height);
        if (load(&set, &d)) {
            printf("%d x %d, no probes: %.2f ms\n", width, height,
                   measure(room, &target, &d));
            status = argc > 3 && !write_picture(ctx, argv[3], &target);
        }
        room_target_free(&target);
    }
    view_room_free(room);
    view_set_free(&set);
    view_test_end();
    ibl_ctx_free(ctx);
    return status;
}
