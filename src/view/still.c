/* SPDX-License-Identifier: MIT */
#include "view/app.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/process.h"
#include "common/signals.h"
#include "view/inspect.h"
#include "view/labels.h"
#include "view/message.h"
#include "view/picture.h"
#include "view/screen.h"

enum {
    GAP = 4,   /* pixels of a sheet between pictures and around them */
    SHADE = 32 /* grey of a sheet's background */
};

bool view_still_draw(view_renderer *r, const view_options *o,
                     const view_settings *s, double *ms, view_stats *stats)
{
    const int samples = o->frames    ? o->frames * VIEW_FRAME_SAMPLES
                        : o->samples ? o->samples
                                     : VIEW_DEFAULT_SAMPLES;
    const bool few = view_wants_reference(s) && samples < view_places(s);
    view_settings at = *s;

    if (few)
        at.antialias = 1;
    /* All places in a pixel get as many samples. */
    const int all = view_places(&at);
    int frames = !view_wants_reference(s)
                     ? (o->frames ? o->frames : 1)
                     : (samples - 1) / VIEW_FRAME_SAMPLES + 1;
    frames = (frames + all - 1) / all * all;
    view_renderer_restart(r); /* each picture of a sheet has its own samples */
    for (int i = 0; i < frames; i++) {
        const double begun = ibl_now();
        view_renderer_pace(r,
                           (i + 1) * samples / frames - i * samples / frames);
        if (!view_renderer_draw(r, &at, o->size[0], o->size[1]))
            return false;
        gl.Finish();
        *ms = 1e3 * (ibl_now() - begun);
        view_stats_add(stats, *ms);
    }
    return true;
}

/* As in a window of this size. */
static void draw_panel(const view_app *app)
{
    gl.BindFramebuffer(GL_FRAMEBUFFER, 0);
    view_overlay_begin(app->overlay, app->width, app->height);
    view_panel_draw(app);
    view_overlay_end(app->overlay);
}

/* Reads the last draw, with its labels; before: what they begin with. 8-bit RGB
 * or, for that file, linear floats; NULL, with a message. */
static void *read_picture(const view_app *app, const view_settings *s,
                          const char *file, const char *before)
{
    const view_options *o = app->options;
    const int width = o->size[0], height = o->size[1];
    char what[VIEW_LABEL_BYTES], title[2 * VIEW_LABEL_BYTES];

    if (view_picture_is_linear(file)) {
        float *rgb =
            ibl_need(malloc(3 * sizeof *rgb * (size_t)width * (size_t)height));
        if (view_renderer_linear(app->renderer, rgb))
            return rgb;
        free(rgb);
        return NULL;
    }
    view_labels_title(s, app->renderer, app->set, what);
    snprintf(title, sizeof title, "%s%s%s", before,
             *before && view_compares(s) ? "\n" : "",
             !*before || view_compares(s) ? what
             : s->mode == VIEW_SPHERES    ? "\nup metallic, right roughness"
                                          : "");
    gl.BindFramebuffer(GL_FRAMEBUFFER, 0);
    if (o->labels)
        view_labels_draw(app->overlay, s, app->set, width, height, title);
    if (o->settings.panel)
        draw_panel(app);
    return view_picture_read(0, width, height);
}

static bool write_picture(const view_app *app)
{
    const view_options *o = app->options;
    void *rgb = read_picture(app, &app->settings, o->offscreen, "");
    const bool ok = rgb && view_picture_write(app->ctx, o->offscreen,
                                              o->size[0], o->size[1], rgb);
    free(rgb);
    return ok;
}

static bool draw_picture(view_app *app)
{
    const view_options *o = app->options;
    view_renderer *r = app->renderer;
    double ms;

    if (!view_still_draw(r, o, &app->settings, &ms, &app->stats))
        return false;
    if (o->verbose)
        printf("%.1f ms a frame\n", ms);
    if (!o->quiet)
        view_report_print(r, &app->settings);
    if (!write_picture(app))
        return false;
    if (o->stats)
        view_stats_end(&app->stats, r, &app->settings);
    return true;
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
    [VIEW_SCENE] = {TURN, EV},          [VIEW_MODEL] = {REFLECTION, TURN}};

static int axis_count(axis of, const baked_set *set)
{
    const bool lobes = set->texture[VIEW_LOBES].data;
    const int counts[] = {[MATERIAL] = VIEW_MATERIALS,
                          [TURN] = 4,
                          [TONE] = VIEW_TONES,
                          [EV] = 5,
                          [LEVEL] = set->texture[VIEW_SPECULAR].levels,
                          [REFLECTION] = lobes ? VIEW_REFLECTIONS : 4};

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
        snprintf(label, size, "level %d, r %.3g", i, set->roughness[i]);
        break;
    case REFLECTION:
        s->reflection = (view_reflection)i;
        if (view_needs_lobes(s->reflection) && !set->texture[VIEW_LOBES].data)
            s->reflection = VIEW_REFERENCE;
        snprintf(label, size, "%s", view_reflection_names[s->reflection]);
    }
}

typedef struct sheet {
    int rows, columns;
    int width, height;  /* of the whole */
    size_t pixel;       /* bytes */
    unsigned char *rgb; /* of the whole */
} sheet;

static bool prepare_sheet(sheet *h, const view_options *o, const baked_set *set)
{
    h->rows = axis_count(axes[o->settings.mode][0], set);
    h->columns = axis_count(axes[o->settings.mode][1], set);
    const long long wide = GAP + (long long)h->columns * (o->size[0] + GAP),
                    high = GAP + (long long)h->rows * (o->size[1] + GAP);

    if (wide > IBL_MAX_EDGE || high > IBL_MAX_EDGE)
        return view_fail("%s: a sheet of %lldx%lld pixels: more than %d along "
                         "an edge: choose a smaller --size",
                         o->contact_sheet, wide, high, IBL_MAX_EDGE);
    h->width = (int)wide;
    h->height = (int)high;
    h->pixel =
        3 * (view_picture_is_linear(o->contact_sheet) ? sizeof(float) : 1);
    h->rgb = ibl_need(malloc(h->pixel * (size_t)wide * (size_t)high));
    memset(h->rgb, h->pixel > 3 ? 0 : SHADE,
           h->pixel * (size_t)wide * (size_t)high);
    return true;
}

/* Draws a picture with its label and copies it to its place. */
static bool draw_tile(view_app *app, const sheet *h, int row, int column,
                      double *ms)
{
    const view_options *o = app->options;
    const int w = o->size[0], height = o->size[1];
    view_settings s = o->settings;
    char row_label[64] = "", column_label[64] = "", label[160];

    axis_apply(axes[s.mode][0], app->set, row, &s, row_label, sizeof row_label);
    axis_apply(axes[s.mode][1], app->set, column, &s, column_label,
               sizeof column_label);
    if (!view_still_draw(app->renderer, o, &s, ms, &app->stats))
        return false;
    snprintf(label, sizeof label, "%s, %s", row_label, column_label);
    char *tile = read_picture(app, &s, o->contact_sheet, label);
    if (!tile)
        return false;
    for (int y = 0; y < height; y++) {
        const size_t to_row = (size_t)GAP + (size_t)row * (height + GAP) + y,
                     to = to_row * h->width + GAP + (size_t)column * (w + GAP);
        memcpy(h->rgb + h->pixel * to, tile + h->pixel * (size_t)(y * w),
               h->pixel * (size_t)w);
    }
    free(tile);
    return true;
}

static bool draw_tiles(view_app *app, const sheet *h)
{
    double ms = 0;

    for (int row = 0; row < h->rows; row++)
        for (int column = 0; column < h->columns; column++)
            if (!draw_tile(app, h, row, column, &ms))
                return false;
    if (app->options->verbose)
        printf("%d pictures, the last one %.1f ms a frame\n",
               h->rows * h->columns, ms);
    return true;
}

static bool draw_sheet(view_app *app)
{
    const view_options *o = app->options;
    sheet h = {0};
    const bool ok = prepare_sheet(&h, o, app->set) && draw_tiles(app, &h) &&
                    view_picture_write(app->ctx, o->contact_sheet, h.width,
                                       h.height, h.rgb);
    if (ok && o->stats)
        view_stats_end(&app->stats, app->renderer, &o->settings);

    free(h.rgb);
    return ok;
}

static bool make(view_app *app)
{
    return view_app_make(app) && view_renderer_load(app->renderer, app->set) &&
           (app->options->contact_sheet ? draw_sheet(app) : draw_picture(app));
}

/* Makes the output on a screen as large as a picture. */
static bool draw(view_app *app)
{
    const view_options *o = app->options;
    view_screen *screen = view_screen_memory(o->size[0], o->size[1], NULL);
    const bool ok = screen && make(app);

    if (screen)
        view_app_end(app);
    view_screen_close(screen);
    return ok;
}

static void print_texel(const view_app *app)
{
    const view_options *o = app->options;
    char text[200];
    const view_texel t =
        view_inspect(app->set, &app->settings, app->width, app->height,
                     o->texel[0] + 0.5, o->texel[1] + 0.5);

    view_texel_text(&t, text, sizeof text);
    printf("%s\n", t.inside ? text : "nothing of a map is there");
}

bool view_still_run(ibl_ctx *ctx, const view_options *o)
{
    view_app app = {.ctx = ctx,
                    .options = o,
                    .settings = o->settings,
                    .width = o->size[0],
                    .height = o->size[1],
                    .scale = 1,
                    .mouse = {-1, -1}};
    baked_set *set = app.set = &app.sets[0];
    bool ok;

    if (!view_options_may(o))
        return false;
    ok = view_is_map(o->request.path, o->request.layout)
             ? view_set_bake(ctx, &o->request, set)
             : view_set_open(ctx, &o->request, set);
    ok = ok && view_options_suit(o, set);
    if (ok && o->verbose)
        view_report_set(set);
    app.settings.covered = view_panel_share(&app);
    if (ok && (o->offscreen || o->contact_sheet))
        ok = draw(&app);
    if (ok && o->texel[0] >= 0)
        print_texel(&app);
    view_set_free(set);
    return ok;
}
