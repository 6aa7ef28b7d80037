/* SPDX-License-Identifier: MIT */
/* Pictures in files: of the command line and of the window's key. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "common/process.h"
#include "common/signals.h"
#include "view/app.h"
#include "view/folder.h"
#include "view/message.h"
#include "view/ui.h"

enum {
    SAMPLES = 16, /* of the reference that a frame adds */
    GAP = 4,      /* pixels of a sheet between pictures and around them */
    SHADE = 32    /* grey of a sheet's background */
};

bool view_still_load(ibl_ctx *ctx, const view_request *what, baked_set *set)
{
    const char *why;

    return view_kind_of(what->path, &why) == VIEW_KIND_MAP
               ? view_set_bake(ctx, what, set)
               : view_set_open(ctx, what, set);
}

/* ---- one picture --------------------------------------------------------- */

/* Draws until the reference has the samples of the options, the same number at
 * each place in a pixel; for --stats as often without a reference. False, with
 * a message. */
static bool draw_frames(view_app *app)
{
    const view_options *o = app->options;
    view_settings *s = app->side;
    const bool sampled = view_is_sampled(&s[0], &s[1]);

    for (int i = 0; i < 2 && sampled && o->samples < view_places(&s[0]); i++)
        s[i].antialias = 1;
    const int places = view_places(&s[0]);
    const int least = sampled || o->stats ? (o->samples - 1) / SAMPLES + 1 : 1;
    const int frames = (least + places - 1) / places * places;
    app->judged = -1;
    view_renderer_restart(app->renderer);
    for (int i = 0; i < frames; i++) {
        const double begun = ibl_now();
        view_renderer_pace(app->renderer, (i + 1) * o->samples / frames -
                                              i * o->samples / frames);
        if (!sampled && i % places == 0)
            view_renderer_restart(app->renderer);
        view_gl_time_begin();
        if (!view_app_draw(app, false))
            return false;
        gl.Finish();
        view_stats_add(&app->stats, 1e3 * (ibl_now() - begun),
                       view_gl_time_end());
    }
    if (o->mean_exposure && view_app_expose(app))
        view_renderer_show(app->renderer, app->side[0].ev);
    return true;
}

/* What was drawn, for that file: with labels, or linear floats; to be freed.
 * NULL, with a message. */
static void *read_picture(view_app *app, const char *file, int channels)
{
    const size_t pixels = (size_t)app->width * (size_t)app->height;

    if (!view_picture_is_linear(file)) {
        view_labels_draw(app);
        return view_picture_read(app->target, app->width, app->height,
                                 channels);
    }
    float *rgb = ibl_need(malloc(3 * sizeof *rgb * pixels));
    if (view_renderer_linear(app->renderer, rgb))
        return rgb;
    free(rgb);
    return NULL;
}

static bool write_picture(view_app *app, const char *file)
{
    const int channels =
        app->side[0].background == VIEW_BACKGROUND_TRANSPARENT ? 4 : 3;
    void *pixels = read_picture(app, file, channels);
    const bool ok = pixels && view_picture_write(app->ctx, file, app->width,
                                                 app->height, channels, pixels);

    free(pixels);
    return ok;
}

static bool make_picture(view_app *app, const char *file)
{
    if (!draw_frames(app))
        return false;
    if (!app->options->quiet)
        view_labels_print(app);
    return write_picture(app, file);
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

/* Draws a picture of the sheet: a material at a quarter turn, or a level at an
 * exposure from 2 stops down to 2 stops up. To be freed; NULL, with a message.
 */
static void *make_tile(view_app *app, int row, int column)
{
    const view_options *o = app->options;
    view_settings *s = &app->side[0];
    char caption[160];

    app->side[0] = o->settings;
    app->side[1] = o->other;
    if (s->mode == VIEW_LEVELS) {
        s->level = row;
        s->ev += column - 2;
        snprintf(
            caption, sizeof caption, "level %d, r %.3g, EV %+g", row,
            app->set->baked.file[IBL_CONTENT_SPECULAR].facts.roughness[row],
            s->ev);
    } else {
        s->material = row;
        s->turn += 90 * column;
        snprintf(caption, sizeof caption, "%s, turn %g",
                 view_material_names[row], s->turn);
    }
    view_app_fit(app);
    app->caption = caption;
    void *pixels =
        draw_frames(app) ? read_picture(app, o->contact_sheet, 3) : NULL;
    app->caption = NULL;
    return pixels;
}

static bool make_sheet(view_app *app)
{
    const view_options *o = app->options;
    const bool levels = o->settings.mode == VIEW_LEVELS;
    const int rows =
        levels ? app->set->baked.file[IBL_CONTENT_SPECULAR].texture.levels
               : VIEW_MATERIALS;
    const int columns = levels ? 5 : 4;
    const size_t width = (size_t)app->width, height = (size_t)app->height,
                 wide = GAP + (size_t)columns * (width + GAP),
                 high = GAP + (size_t)rows * (height + GAP);
    const bool linear = view_picture_is_linear(o->contact_sheet);
    const size_t pixel = 3 * (linear ? sizeof(float) : 1);
    bool ok = true;

    if (wide > IBL_MAX_EDGE || high > IBL_MAX_EDGE)
        return view_fail("%s: a sheet of %zux%zu pixels: more than %d along "
                         "an edge: choose a smaller --size",
                         o->contact_sheet, wide, high, IBL_MAX_EDGE);
    char *sheet = ibl_need(malloc(pixel * wide * high));
    memset(sheet, linear ? 0 : SHADE, pixel * wide * high);
    for (int i = 0; i < rows * columns && ok; i++) {
        char *tile = make_tile(app, i / columns, i % columns);
        const size_t x = GAP + (size_t)(i % columns) * (width + GAP),
                     y = GAP + (size_t)(i / columns) * (height + GAP);
        for (size_t k = 0; k < height && tile; k++)
            memcpy(sheet + pixel * ((y + k) * wide + x),
                   tile + pixel * k * width, pixel * width);
        ok = tile;
        free(tile);
    }
    ok = ok && view_picture_write(app->ctx, o->contact_sheet, (int)wide,
                                  (int)high, 3, sheet);
    free(sheet);
    return ok;
}

bool view_still_run(ibl_ctx *ctx, const view_options *o)
{
    const char *file = view_options_file(o);
    view_app app = {.ctx = ctx,
                    .options = o,
                    .side = {o->settings, o->other},
                    .labels = o->labels && !view_picture_is_linear(file),
                    .panel = o->panel,
                    .paused = true,
                    .width = o->size[0],
                    .height = o->size[1],
                    .scale = o->size[0] > 1920 ? o->size[0] / 1280.0 : 1,
                    .mouse = {-1, -1}};
    bool screen = false;

    app.set = &app.sets[0];
    bool ok = view_options_may(o) && view_still_load(ctx, &o->request, app.set);
    ok = ok && view_options_suit(o, app.set) &&
         (screen = view_screen_memory(o->size[0], o->size[1], NULL)) &&
         view_app_make(&app) && view_ui_make(app.scale) &&
         view_renderer_load(app.renderer, app.set) &&
         (o->contact_sheet ? make_sheet(&app)
          : o->turntable   ? make_turntable(&app)
                           : make_picture(&app, o->offscreen));
    if (ok && o->stats)
        view_stats_print(&app.stats, app.renderer, &o->settings);
    if (screen) {
        view_ui_free();
        view_app_end(&app);
    }
    view_screen_close();
    view_set_free(app.set);
    return ok;
}

/* ---- from a window ------------------------------------------------------- */

/* Finds a name that no file has yet. */
static bool free_name(char *path, size_t size)
{
    for (int number = 1; number <= 999; number++) {
        snprintf(path, size, "iblview-%03d.png", number);
        if (access(path, F_OK))
            return true;
    }
    return view_fail("no picture is written: up to %s all are there", path);
}

/* Draws in a framebuffer of its own, since covered pixels of a window are
 * undefined. */
void view_still_write(view_app *app)
{
    const bool panel = app->panel, help = app->help, files = app->files;
    const double mouse = app->mouse[0];
    GLuint colours, framebuffer;
    char path[32];

    app->wants_picture = app->panel = app->help = app->files = false;
    app->notice[0] = '\0';
    app->mouse[0] = -1;
    bool ok = free_name(path, sizeof path);
    gl.GenRenderbuffers(1, &colours);
    gl.BindRenderbuffer(GL_RENDERBUFFER, colours);
    gl.RenderbufferStorage(GL_RENDERBUFFER, GL_RGBA8, app->width, app->height);
    gl.GenFramebuffers(1, &framebuffer);
    gl.BindFramebuffer(GL_FRAMEBUFFER, framebuffer);
    gl.FramebufferRenderbuffer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0,
                               GL_RENDERBUFFER, colours);
    app->target = framebuffer;
    do
        ok = ok && view_app_draw(app, false);
    while (ok && !view_renderer_complete(app->renderer));
    ok = ok && write_picture(app, path);
    app->target = 0;
    gl.DeleteFramebuffers(1, &framebuffer);
    gl.DeleteRenderbuffers(1, &colours);
    app->panel = panel, app->help = help, app->files = files;
    app->mouse[0] = mouse;
    if (ok)
        view_app_notice(app, "%s is written", path);
    else
        view_app_notice_failure(app);
}
