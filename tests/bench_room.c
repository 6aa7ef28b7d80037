/* SPDX-License-Identifier: MIT */
/* Milliseconds of a frame of the room by how many probes light it, and of their
 * captures; and what it looks like. Arguments: width, height, and how the names
 * of PNGs begin that are to be written. */
#include "room.h"
#include "view.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "view/capture.h"
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

/* ---- probes ------------------------------------------------------------- */

/* The first is in the mirror; the others have the room's quarters. */
static const double places[VIEW_ROOM_PROBES][3] = {
    {0, 0.9, 0}, {-2.5, 1.5, 0.4}, {2.5, 1.5, -0.6}, {-0.3, 1.5, 3.4}};

typedef struct bench {
    ibl_ctx *ctx;
    view_room *room;
    view_room_draw draw; /* what of it all draws share */
    room_target target;
    view_capture *capture[VIEW_ROOM_PROBES];
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
    d.hidden = 0;
    view_room_render(b->room, &d);
}

static void copy3(float to[3], const double from[3])
{
    for (int k = 0; k < 3; k++)
        to[k] = (float)from[k];
}

/* As many probes as are wanted of those captured; the last is for everywhere.
 */
static void use_probes(bench *b, int count)
{
    b->draw.probe_count = count;
    for (int i = 0; i < count; i++) {
        view_room_probe *p = &b->draw.probe[i];
        const view_capture *c = b->capture[i];
        const bool last = i == count - 1;
        *p = (view_room_probe){.specular = view_capture_specular(c),
                               .irradiance = view_capture_irradiance(c),
                               .blend = last ? 0 : 1};
        p->last_level = (float)(view_capture_levels(c) - 1);
        p->lod_scale = p->last_level;
        copy3(p->position, places[i]);
        copy3(p->influence_centre, last ? view_room_centre : places[i]);
        for (int k = 0; k < 3; k++)
            p->influence_half[k] = last ? 6 : 2;
        copy3(p->proxy_centre, view_room_centre);
        copy3(p->proxy_half, view_room_half);
    }
}

/* Lit by themselves, and the last time with all compiled. */
static bool capture(bench *b)
{
    view_capture_options o = view_capture_options_default();

    o.size = 128;
    o.timed = true;
    for (int i = 0; i < VIEW_ROOM_PROBES; i++)
        if (!(b->capture[i] = view_capture_create(&o)))
            return false;
    for (int bounce = 0; bounce < 3; bounce++) {
        for (int i = 0; i < VIEW_ROOM_PROBES; i++)
            if (!view_capture_update(b->capture[i], places[i], capture_scene,
                                     b))
                return false;
        use_probes(b, VIEW_ROOM_PROBES);
    }
    double ms[3];
    view_capture_times(b->capture[0], ms);
    printf("captured with %d probes, 128: %.1f ms drawn, %.1f levels, "
           "%.1f irradiance\n",
           VIEW_ROOM_PROBES, ms[0], ms[1], ms[2]);
    return true;
}

static bool show(bench *b, const char *what)
{
    char path[400];

    printf("%-24s %7.2f ms\n", what, measure(b->room, &b->target, &b->draw));
    if (!b->name)
        return true;
    snprintf(path, sizeof path, "%s%s.png", b->name, what);
    return write_picture(b->ctx, path, &b->target);
}

static bool run(bench *b)
{
    bool ok = show(b, "none") && capture(b);

    use_probes(b, 1);
    ok = ok && show(b, "one");
    b->draw.parallax = false;
    ok = ok && show(b, "one-flat");
    b->draw.parallax = true;
    use_probes(b, VIEW_ROOM_PROBES);
    ok = ok && show(b, "four");
    b->draw.seconds = 2;
    ok = ok && show(b, "four-later");
    for (int i = 0; i < VIEW_ROOM_PROBES; i++)
        view_capture_free(b->capture[i]);
    return ok;
}

int main(int argc, char **argv)
{
    const int width = argc > 1 ? atoi(argv[1]) : 640;
    const int height = argc > 2 ? atoi(argv[2]) : 360;
    const double eye[3] = {1.6, 1.9, 3.6}, at[3] = {-0.5, 1, -1};
    bench b = {.name = argc > 3 ? argv[3] : NULL};
    view_set set = {0};
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
        if (load(&set, &b.draw)) {
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
