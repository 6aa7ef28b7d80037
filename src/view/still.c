/* SPDX-License-Identifier: MIT */
#include "view/still.h"

#include <stdio.h>
#include <stdlib.h>

#include "view/clock.h"
#include "view/contact.h"
#include "view/gl.h"
#include "view/inspect.h"
#include "view/message.h"
#include "view/picture.h"
#include "view/report.h"
#include "view/screen.h"

enum {
    TIMED = 101,    /* frames whose times are kept, the last ones */
    SMALL_EDGE = 16 /* of a picture that nobody asked for */
};

static int compare_times(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static double median(double *times, int count)
{
    qsort(times, (size_t)count, sizeof *times, compare_times);
    return times[count / 2];
}

/* A frame, and how long it took. */
static bool time_frame(view_renderer *r, const view_options *o,
                       const view_settings *s, int samples, double *ms)
{
    const double begun = view_clock();

    view_renderer_pace(r, samples);
    if (!view_renderer_draw(r, s, o->size[0], o->size[1]))
        return false;
    gl.Finish();
    *ms = 1e3 * (view_clock() - begun);
    return true;
}

bool view_still_draw(view_renderer *r, const view_options *o,
                     const view_settings *s, double *ms, view_stats *stats)
{
    const bool compares =
        s->mode == VIEW_SPHERES && s->compare != VIEW_SPLIT_SUM;
    const int wanted = o->frames    ? o->frames * VIEW_FRAME_SAMPLES
                       : !compares  ? VIEW_FRAME_SAMPLES
                       : o->samples ? o->samples
                                    : VIEW_DEFAULT_SAMPLES;
    double times[TIMED];
    int frames = 0;

    view_renderer_restart(r); /* of a sheet each is a picture of its own */
    for (int samples = 0; samples < wanted; samples += VIEW_FRAME_SAMPLES) {
        const int left = wanted - samples;
        double *last = &times[frames++ % TIMED];
        if (!time_frame(r, o, s,
                        left < VIEW_FRAME_SAMPLES ? left : VIEW_FRAME_SAMPLES,
                        last))
            return false;
        view_stats_add(stats, *last);
    }
    *ms = median(times, frames < TIMED ? frames : TIMED);
    return true;
}

static bool write_picture(ibl_ctx *ctx, const view_options *o)
{
    unsigned char *rgb = view_picture_read(0, o->size[0], o->size[1]);
    const bool ok = rgb && view_picture_write(ctx, o->offscreen, o->size[0],
                                              o->size[1], rgb);
    free(rgb);
    return ok;
}

static bool draw_picture(ibl_ctx *ctx, const view_options *o, view_renderer *r)
{
    view_stats stats = {0};
    double ms;

    if (!view_still_draw(r, o, &o->settings, &ms, &stats))
        return false;
    if (o->verbose)
        printf("%.1f ms a frame\n", ms);
    if (o->verbose && o->settings.mode == VIEW_SCENE) {
        view_report_sun(view_renderer_stage(r));
        view_report_probe(view_renderer_stage(r), o->settings.probe_filter);
    }
    if (!o->quiet && o->settings.compare != VIEW_SPLIT_SUM)
        view_report_print(r, &o->settings);
    return write_picture(ctx, o) &&
           (!o->stats || view_stats_end(&stats, r, &o->settings));
}

/* Captures are the same in every picture: a small one will do. */
static bool save_probes(ibl_ctx *ctx, const view_options *o, view_renderer *r)
{
    if (!o->offscreen &&
        !view_renderer_draw(r, &o->settings, SMALL_EDGE, SMALL_EDGE))
        return false;
    if (!view_scene_save(view_renderer_stage(r), ctx, o->save_probes))
        return false;
    if (o->verbose)
        view_tell("probes: %d, faces of %d, written to %s", o->settings.probes,
                  o->settings.probe_size, o->save_probes);
    return true;
}

/* What is asked for. */
static bool make(ibl_ctx *ctx, const view_options *o, const baked_set *set,
                 view_renderer *r)
{
    if (o->contact_sheet)
        return view_contact_sheet(ctx, o, set, r);
    return (!o->offscreen || draw_picture(ctx, o, r)) &&
           (!o->save_probes || save_probes(ctx, o, r));
}

static view_screen *open_screen(const view_options *o)
{
    const bool picture = o->offscreen || o->contact_sheet;

    return picture ? view_screen_memory(o->size[0], o->size[1])
                   : view_screen_memory(SMALL_EDGE, SMALL_EDGE);
}

static bool draw(ibl_ctx *ctx, const view_options *o, const baked_set *set)
{
    view_screen *screen = open_screen(o);
    view_probe_set *probes = NULL;
    view_renderer *r = NULL;
    bool ok = false;

    if (!screen)
        return false;
    if (o->verbose)
        printf("%s\n", view_screen_about(screen));
    if (o->probe_set && !(probes = view_probe_set_load(ctx, o->probe_set)))
        goto fail;
    if (probes && o->verbose)
        view_report_probe_set(probes);
    r = view_renderer_create();
    if (!r || !view_renderer_load(r, set))
        goto fail;
    view_renderer_probes(r, probes);
    ok = make(ctx, o, set, r);
fail:
    view_renderer_free(r);
    view_probe_set_free(probes);
    view_screen_close(screen);
    return ok;
}

static void print_texel(const view_options *o, const baked_set *set)
{
    char text[200];
    const view_texel t = view_inspect(set, &o->settings, o->size[0], o->size[1],
                                      o->texel[0] + 0.5, o->texel[1] + 0.5);

    view_texel_text(&t, text, sizeof text);
    printf("%s\n", t.inside ? text : "nothing of a map is there");
}

bool view_still_run(ibl_ctx *ctx, const view_options *o)
{
    baked_set set = {0};
    bool ok;

    if (!view_options_may(o))
        return false;
    ok = view_is_map(o->request.path)
             ? view_set_bake(ctx, o->request.path, &set)
             : view_set_open(ctx, &o->request, &set);
    ok = ok && view_options_suit(o, &set);
    if (ok && o->verbose)
        view_report_set(&set);
    if (ok && (o->offscreen || o->contact_sheet || o->save_probes))
        ok = draw(ctx, o, &set);
    if (ok && o->texel[0] >= 0)
        print_texel(o, &set);
    view_set_free(&set);
    return ok;
}
