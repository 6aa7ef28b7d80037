/* SPDX-License-Identifier: MIT */
#include "view/still.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "view/clock.h"
#include "view/inspect.h"
#include "view/message.h"
#include "view/overlay.h"
#include "view/picture.h"
#include "view/report.h"
#include "view/screen.h"

enum {
    TIMED = 101,     /* frames whose times are kept, the last ones */
    SMALL_EDGE = 16, /* of a picture that nobody asked for */
    GAP = 4,         /* of a sheet: pixels between pictures and around them */
    SHADE = 32       /* its grey */
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

/* ---- a sheet ------------------------------------------------------------- */

static int axis_count(view_axis axis, const baked_set *set)
{
    switch (axis) {
    case VIEW_AXIS_MATERIAL:
        return VIEW_MATERIALS;
    case VIEW_AXIS_TURN:
        return 4;
    case VIEW_AXIS_TONE:
        return VIEW_TONES;
    case VIEW_AXIS_EV:
        return 5;
    case VIEW_AXIS_LEVEL:
        return set->texture[VIEW_SPECULAR].levels;
    case VIEW_AXIS_COMPARE:
        return VIEW_COMPARES;
    case VIEW_AXES:
        break;
    }
    return 0;
}

/* Sets the settings of place i along an axis, and its label. */
static void axis_apply(view_axis axis, const baked_set *set, int i,
                       view_settings *s, char *label, size_t size)
{
    switch (axis) {
    case VIEW_AXIS_MATERIAL:
        s->material = i;
        snprintf(label, size, "%s", view_materials[i].name);
        break;
    case VIEW_AXIS_TURN:
        s->turn += 90 * i;
        snprintf(label, size, "turn %g", s->turn);
        break;
    case VIEW_AXIS_TONE:
        s->tone = (view_tone)i;
        snprintf(label, size, "%s", view_tone_names[s->tone]);
        break;
    case VIEW_AXIS_EV:
        s->ev += i - 2;
        snprintf(label, size, "EV %+g", s->ev);
        break;
    case VIEW_AXIS_LEVEL:
        s->mode = VIEW_LEVELS;
        s->level = i;
        snprintf(label, size, "level %d, r %.3g", i, set->roughness[i]);
        break;
    case VIEW_AXIS_COMPARE:
        s->compare = (view_compare)i;
        snprintf(label, size, "%s", view_compare_names[s->compare]);
        break;
    case VIEW_AXES:
        break;
    }
}

typedef struct sheet {
    const view_options *o;
    const baked_set *set;
    view_renderer *renderer;
    view_overlay *overlay;
    int rows, columns;
    int width, height;  /* of the whole */
    unsigned char *rgb; /* of the whole */
    view_stats stats;
} sheet;

static bool prepare_sheet(sheet *h)
{
    const int w = h->o->size[0], height = h->o->size[1];
    const long long wide = GAP + (long long)h->columns * (w + GAP),
                    high = GAP + (long long)h->rows * (height + GAP);

    if (wide > IBL_MAX_EDGE || high > IBL_MAX_EDGE)
        return view_fail("%s: a sheet of %lldx%lld pixels: more than %d along "
                         "an edge: choose a smaller --size",
                         h->o->contact_sheet, wide, high, IBL_MAX_EDGE);
    h->width = (int)wide;
    h->height = (int)high;
    h->rgb = malloc((size_t)(3 * wide) * (size_t)high);
    if (!h->rgb)
        return view_fail("%s: no memory for a sheet of %lldx%lld pixels: "
                         "choose a smaller --size",
                         h->o->contact_sheet, wide, high);
    memset(h->rgb, SHADE, (size_t)(3 * wide) * (size_t)high);
    h->overlay = view_overlay_create();
    return h->overlay;
}

/* Draws a picture with its label and copies it to its place. */
static bool draw_tile(sheet *h, int row, int column, double *ms)
{
    const view_options *o = h->o;
    const int w = o->size[0], height = o->size[1];
    view_settings s = o->settings;
    char row_label[64] = "", column_label[64] = "", label[160];

    axis_apply((view_axis)o->rows, h->set, row, &s, row_label,
               sizeof row_label);
    axis_apply((view_axis)o->columns, h->set, column, &s, column_label,
               sizeof column_label);
    if (!view_still_draw(h->renderer, o, &s, ms, &h->stats))
        return false;
    snprintf(label, sizeof label, "%s, %s", row_label, column_label);
    gl.BindFramebuffer(GL_FRAMEBUFFER, 0);
    view_overlay_begin(h->overlay, w, height);
    view_overlay_text(h->overlay, 4, 4, w < 640 ? 1 : 2, label);
    view_overlay_end(h->overlay);

    unsigned char *tile = view_picture_read(0, w, height);
    if (!tile)
        return false;
    for (int y = 0; y < height; y++) {
        const size_t to_row = (size_t)GAP + (size_t)row * (height + GAP) + y,
                     to = to_row * h->width + GAP + (size_t)column * (w + GAP);
        memcpy(h->rgb + 3 * to, tile + (size_t)3 * y * w, (size_t)3 * w);
    }
    free(tile);
    return true;
}

static bool draw_tiles(sheet *h)
{
    double ms = 0;

    for (int row = 0; row < h->rows; row++)
        for (int column = 0; column < h->columns; column++)
            if (!draw_tile(h, row, column, &ms))
                return false;
    if (h->o->verbose)
        printf("%d pictures, the last one %.1f ms a frame\n",
               h->rows * h->columns, ms);
    return true;
}

static bool write_sheet(ibl_ctx *ctx, const view_options *o,
                        const baked_set *set, view_renderer *r)
{
    sheet h = {.o = o, .set = set, .renderer = r};
    bool ok;

    h.rows = axis_count((view_axis)o->rows, set);
    h.columns = axis_count((view_axis)o->columns, set);
    ok = prepare_sheet(&h) && draw_tiles(&h) &&
         view_picture_write(ctx, o->contact_sheet, h.width, h.height, h.rgb) &&
         (!o->stats || view_stats_end(&h.stats, r, &o->settings));
    view_overlay_free(h.overlay);
    free(h.rgb);
    return ok;
}

/* ---- the whole ----------------------------------------------------------- */

/* What is asked for. */
static bool make(ibl_ctx *ctx, const view_options *o, const baked_set *set,
                 view_renderer *r)
{
    if (o->contact_sheet)
        return write_sheet(ctx, o, set, r);
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
        view_report_gl();
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
