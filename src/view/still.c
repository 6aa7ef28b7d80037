/* SPDX-License-Identifier: MIT */
#include "view/app.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/process.h"
#include "common/signals.h"
#include "view/folder.h"
#include "view/message.h"
#include "view/ui.h"

enum {
    GAP = 4,   /* pixels of a sheet between pictures and around them */
    SHADE = 32 /* grey of a sheet's background */
};

/* Draws the frames or samples that the options ask for. False, with a message.
 */
static bool draw_frames(view_app *app)
{
    const view_options *o = app->options;
    view_settings *s = app->side;
    const bool sampled = view_wants_reference(&s[0]) ||
                         (s[0].compare && view_wants_reference(&s[1]));
    const int samples = o->frames    ? o->frames * VIEW_FRAME_SAMPLES
                        : o->samples ? o->samples
                                     : VIEW_DEFAULT_SAMPLES;

    for (int i = 0; i < 2 && sampled && samples < view_places(&s[0]); i++)
        s[i].antialias = 1;
    /* All places in a pixel get as many samples. */
    const int all = view_places(&s[0]);
    int frames = sampled ? (samples - 1) / VIEW_FRAME_SAMPLES + 1
                         : (o->frames ? o->frames : 1);
    frames = (frames + all - 1) / all * all;
    view_renderer_restart(app->renderer);
    for (int i = 0; i < frames; i++) {
        const double begun = ibl_now();
        view_renderer_pace(app->renderer,
                           (i + 1) * samples / frames - i * samples / frames);
        if (!sampled && i % all == 0)
            view_renderer_restart(app->renderer);
        view_gl_time_begin();
        if (!view_app_draw(app, false))
            return false;
        gl.Finish();
        app->frame_ms = 1e3 * (ibl_now() - begun);
        view_stats_add(&app->stats, app->frame_ms, view_gl_time_end());
    }
    if (o->mean_exposure && view_app_expose(app))
        view_renderer_show(app->renderer, app->side[0].ev);
    return true;
}

/* Draws a picture for that file, with its labels: 8-bit RGB or RGBA, or linear
 * floats; NULL, with a message. */
static void *draw_picture(view_app *app, const char *file, int channels)
{
    const int width = app->width, height = app->height;

    app->judged = -1;
    if (!draw_frames(app))
        return NULL;
    if (view_picture_is_linear(file)) {
        float *rgb =
            ibl_need(malloc(3 * sizeof *rgb * (size_t)width * (size_t)height));
        if (view_renderer_linear(app->renderer, rgb))
            return rgb;
        free(rgb);
        return NULL;
    }
    view_labels_draw(app);
    return view_picture_read(0, width, height, channels);
}

static void report(view_app *app)
{
    char text[2][200];

    if (app->options->verbose)
        printf("%.1f ms a frame\n", app->frame_ms);
    if (app->options->quiet || !app->side[0].compare)
        return;
    for (int i = 0; i < 2; i++)
        view_report_side(app->side, i, app->set, &app->other, text[i],
                         sizeof text[i]);
    view_report_print(app->renderer, &app->side[0],
                      (const char *const[]){text[0], text[1]});
}

static bool make_picture(view_app *app, const char *file)
{
    const int channels =
        app->side[0].background == VIEW_BACKGROUND_TRANSPARENT ? 4 : 3;
    void *pixels = draw_picture(app, file, channels);
    bool ok = pixels;

    if (ok) {
        report(app);
        ok = view_picture_write(app->ctx, file, app->width, app->height,
                                channels, pixels);
    }
    free(pixels);
    return ok;
}

/* A turn of the camera. */
static bool make_turntable(view_app *app)
{
    const view_options *o = app->options;
    bool ok = true;

    for (int i = 0; i < o->turntable && ok; i++) {
        app->side[0].yaw = o->settings.yaw + 360.0 * i / o->turntable;
        view_app_fit(app);
        char *file = view_picture_name(o->offscreen, i + 1);
        ok = make_picture(app, file);
        free(file);
    }
    return ok;
}

/* ---- a sheet ------------------------------------------------------------- */

/* What changes along rows or columns. */
typedef enum axis {
    MATERIAL,
    TURN, /* by quarter turns */
    TONE,
    EV,        /* 2 stops down to 2 stops up */
    LEVEL,     /* of the specular chain */
    REFLECTION /* those that the set allows */
} axis;

static const axis axes[VIEW_MODES][2] = {
    [VIEW_SPHERES] = {MATERIAL, TURN},  [VIEW_LEVELS] = {LEVEL, EV},
    [VIEW_IRRADIANCE_MAP] = {TONE, EV}, [VIEW_TABLE] = {TONE, EV},
    [VIEW_SCENE] = {TURN, EV},          [VIEW_MODEL] = {REFLECTION, TURN},
    [VIEW_SOURCE_MAP] = {TONE, EV}};

static int axis_count(axis of, const baked_set *set)
{
    const bool lobes = set->baked.file[IBL_CONTENT_LOBE_TABLE].texture.data;
    const int counts[] = {
        [MATERIAL] = VIEW_MATERIALS,
        [TURN] = 4,
        [TONE] = VIEW_TONES,
        [EV] = 5,
        [LEVEL] = set->baked.file[IBL_CONTENT_SPECULAR].texture.levels,
        [REFLECTION] = lobes ? VIEW_REFLECTIONS : 3};

    return counts[of];
}

/* Applies step i of an axis to the settings, and labels it. */
static void axis_apply(axis of, const baked_set *set, int i, view_settings *s,
                       char *label, size_t size)
{
    switch (of) {
    case MATERIAL:
        s->material = i;
        snprintf(label, size, "%s", view_materials[i].name);
        break;
    case TURN:
        s->turn += 90 * i;
        snprintf(label, size, "turn %g", s->turn);
        break;
    case TONE:
        s->tone = (view_tone)i;
        snprintf(label, size, "%s", view_tone_names[s->tone]);
        break;
    case EV:
        s->ev += i - 2;
        snprintf(label, size, "EV %+g", s->ev);
        break;
    case LEVEL:
        s->level = i;
        snprintf(label, size, "level %d, r %.3g", i,
                 set->baked.file[IBL_CONTENT_SPECULAR].facts.roughness[i]);
        break;
    case REFLECTION:
        s->reflection = (view_reflection)i;
        if (view_needs_lobes(s->reflection) &&
            !set->baked.file[IBL_CONTENT_LOBE_TABLE].texture.data)
            s->reflection = VIEW_REFERENCE;
        snprintf(label, size, "%s", view_reflection_names[s->reflection]);
    }
}

/* Draws a picture of the sheet and copies it to its place. */
static bool draw_tile(view_app *app, int row, int column, int width,
                      size_t pixel, unsigned char *sheet)
{
    const view_options *o = app->options;
    const axis *of = axes[o->settings.mode];
    char label[2][64], caption[160];

    app->side[0] = o->settings;
    app->side[1] = o->other;
    axis_apply(of[0], app->set, row, &app->side[0], label[0], sizeof label[0]);
    axis_apply(of[1], app->set, column, &app->side[0], label[1],
               sizeof label[1]);
    view_app_fit(app);
    snprintf(caption, sizeof caption, "%s, %s", label[0], label[1]);
    app->caption = caption;
    unsigned char *tile = draw_picture(app, o->contact_sheet, 3);
    if (!tile)
        return false;
    for (int y = 0; y < app->height; y++) {
        const size_t to_row =
            (size_t)GAP + (size_t)row * (app->height + GAP) + y;
        const size_t to =
            to_row * width + GAP + (size_t)column * (app->width + GAP);
        memcpy(sheet + pixel * to, tile + pixel * (size_t)(y * app->width),
               pixel * (size_t)app->width);
    }
    free(tile);
    return true;
}

static bool make_sheet(view_app *app)
{
    const view_options *o = app->options;
    const axis *of = axes[o->settings.mode];
    const int rows = axis_count(of[0], app->set),
              columns = axis_count(of[1], app->set);
    const long long wide = GAP + (long long)columns * (o->size[0] + GAP),
                    high = GAP + (long long)rows * (o->size[1] + GAP);
    const size_t pixel =
        3 * (view_picture_is_linear(o->contact_sheet) ? sizeof(float) : 1);
    bool ok = true;

    if (wide > IBL_MAX_EDGE || high > IBL_MAX_EDGE)
        return view_fail("%s: a sheet of %lldx%lld pixels: more than %d along "
                         "an edge: choose a smaller --size",
                         o->contact_sheet, wide, high, IBL_MAX_EDGE);
    const size_t bytes = pixel * (size_t)wide * (size_t)high;
    unsigned char *sheet = ibl_need(malloc(bytes));
    memset(sheet, pixel > 3 ? 0 : SHADE, bytes);
    for (int i = 0; i < rows * columns && ok; i++)
        ok = draw_tile(app, i / columns, i % columns, (int)wide, pixel, sheet);
    if (ok && o->verbose)
        printf("%d pictures, the last one %.1f ms a frame\n", rows * columns,
               app->frame_ms);
    ok = ok && view_picture_write(app->ctx, o->contact_sheet, (int)wide,
                                  (int)high, 3, sheet);
    free(sheet);
    return ok;
}

/* ---- all ----------------------------------------------------------------- */

/* Makes the output on a screen as large as a picture. */
static bool draw(view_app *app)
{
    const view_options *o = app->options;
    const bool screen = view_screen_memory(o->size[0], o->size[1], NULL);
    const char *file = o->offscreen ? o->offscreen : o->contact_sheet;

    app->labels = o->labels && !view_picture_is_linear(file);
    const bool ok = screen && view_app_make(app) && view_ui_make(app->scale) &&
                    view_renderer_load(app->renderer, app->set) &&
                    (o->contact_sheet ? make_sheet(app)
                     : o->turntable   ? make_turntable(app)
                                      : make_picture(app, o->offscreen));
    if (ok && o->stats)
        view_stats_end(&app->stats, app->renderer, &o->settings);
    view_ui_free();
    if (screen)
        view_app_end(app);
    view_screen_close();
    return ok;
}

bool view_still_run(ibl_ctx *ctx, const view_options *o)
{
    view_app app = {.ctx = ctx,
                    .options = o,
                    .side = {o->settings, o->other},
                    .panel = o->panel,
                    .paused = true,
                    .width = o->size[0],
                    .height = o->size[1],
                    .scale = o->size[0] > 1920 ? o->size[0] / 1280.0 : 1,
                    .mouse = {-1, -1}};
    baked_set *set = app.set = &app.sets[0];
    const char *why;
    bool ok;

    if (!view_options_may(o))
        return false;
    const view_kind kind = view_kind_of(o->request.path, &why);
    if (kind == VIEW_KIND_FOLDER)
        return view_fail("%s: is a folder, not a set: name a file in it",
                         o->request.path);
    ok = kind == VIEW_KIND_MAP ? view_set_bake(ctx, &o->request, set)
                               : view_set_open(ctx, &o->request, set);
    ok = ok && view_options_suit(o, set);
    if (ok && o->verbose)
        view_report_set(set);
    if (ok && (o->offscreen || o->contact_sheet))
        ok = draw(&app);
    view_set_free(set);
    return ok;
}
