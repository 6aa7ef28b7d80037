/* SPDX-License-Identifier: MIT */
#include "view/window.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "view/app.h"
#include "view/clock.h"
#include "view/gl.h"
#include "view/key_bindings.h"
#include "view/message.h"
#include "view/motion.h"
#include "view/truth.h"
#include "view/window_text.h"

static const double POLL_S = 0.5;    /* how often files are looked at */
static const double BAKING_S = 0.1;  /* how often a bake is asked */
static const double SETTLE_S = 0.25; /* files left alone so long are whole */

/* ---- opening ------------------------------------------------------------ */

static baked_set *free_slot(view_app *app)
{
    return app->set == &app->sets[0] ? &app->sets[1] : &app->sets[0];
}

/* Shows what is in the free slot. If that fails, restores what was shown and
 * empties the slot. */
static bool show(view_app *app)
{
    baked_set *set = free_slot(app);
    const int levels = set->texture[VIEW_SPECULAR].levels;

    if (!view_renderer_load(app->renderer, set)) {
        view_set_free(set);
        if (app->set && !view_renderer_load(app->renderer, app->set))
            app->set = NULL;
        return false;
    }
    app->set = set;
    app->drew = false;
    view_set_free(free_slot(app)); /* what was shown */
    app->stamp = set->read;
    if (app->settings.level >= levels)
        app->settings.level = levels - 1;
    if (app->settings.diffuse == VIEW_DIFFUSE_SH && set->sh_degree < 0)
        app->settings.diffuse = VIEW_DIFFUSE_MAP;
    app->redraw = true;
    if (app->options->verbose)
        view_report_set(set);
    return true;
}

static void stop_bake(view_app *app)
{
    if (app->baker)
        view_baker_finish(app->baker, NULL);
    app->baker = NULL;
}

static bool start_bake(view_app *app, const char *path)
{
    stop_bake(app);
    free(app->baking);
    app->baking = strdup(path);
    if (!app->baking)
        return view_fail("%s: no memory for its name", path);
    app->baker = view_baker_start(app->baking);
    app->baked = 0;
    snprintf(app->stage, sizeof app->stage, "starting");
    app->redraw = true;
    return app->baker;
}

/* Shows what is in the free slot and watches its files. If that fails, the old
 * ones are watched on. */
static bool show_from(view_app *app, const view_request *what)
{
    char *path = strdup(what->path);

    if (!path) {
        view_set_free(free_slot(app));
        return view_fail("%s: no memory for its name", what->path);
    }
    if (!show(app)) {
        free(path);
        return false;
    }
    app->request = *what;
    app->request.path = path;
    free(app->path); /* perhaps what->path */
    app->path = path;
    return true;
}

/* Opens a set, or begins to bake a map. False after a message; the picture
 * stays. */
static bool open_path(view_app *app, const view_request *what)
{
    if (view_is_map(what->path))
        return start_bake(app, what->path);
    if (!view_set_open(app->ctx, what, free_slot(app)) || !show_from(app, what))
        return false;
    /* What was asked for before would come over it. */
    stop_bake(app);
    return true;
}

/* The end of a long path tells more than its beginning. */
static void say_why(view_app *app, const char *path)
{
    enum {
        MOST = 60
    };
    const size_t length = strlen(path), cut = length > MOST ? length - MOST : 0;

    view_app_notice(app, "%s%s is not shown: the terminal says why",
                    cut ? ".." : "", path + cut);
}

static void drop(void *cookie, const char *path)
{
    view_app *app = cookie;

    if (!open_path(app, &(view_request){.path = path}))
        say_why(app, path);
}

/* ---- between frames ------------------------------------------------------ */

/* Asks for the progress of the bake, and shows its result. False: the first
 * thing to show has failed. */
static bool tend_bake(view_app *app)
{
    view_baker *baker = app->baker;

    if (!baker)
        return true;
    app->redraw = true;
    if (!view_baker_poll(baker, app->stage, &app->baked))
        return true;
    app->baker = NULL;
    if (view_baker_finish(baker, free_slot(app)) &&
        show_from(app, &(view_request){.path = app->baking}))
        return true;
    say_why(app, app->baking);
    return app->set;
}

/* Reads the files anew if they have changed. */
static void tend_files(view_app *app)
{
    if (!app->set || app->baker ||
        !view_stamp_changed(app->set, &app->stamp, SETTLE_S))
        return;
    /* If that fails, it is tried again after the next change. */
    view_stamp_take(app->set, &app->stamp);
    if (!open_path(app, &app->request))
        view_app_notice(app, "the files have changed, but cannot be shown: "
                             "the terminal says why");
    else if (!app->baker)
        view_note("%s: read anew", app->request.path);
}

/* The same of baked probes. Those that cannot be read leave the old ones. */
static void tend_probes(view_app *app)
{
    view_probe_set *set;

    if (!app->probes || !view_probe_set_changed(app->probes, SETTLE_S))
        return;
    view_probe_set_seen(app->probes);
    set = view_probe_set_load(app->ctx, view_probe_set_path(app->probes));
    if (!set) {
        say_why(app, view_probe_set_path(app->probes));
        return;
    }
    view_note("%s: read anew", view_probe_set_path(set));
    view_renderer_probes(app->renderer, set);
    view_probe_set_free(app->probes);
    app->probes = set;
    app->redraw = true;
}

/* Whether the next frame is another though nothing was done. */
static bool goes_on(const view_app *app)
{
    const view_settings *s = &app->settings;

    if (app->set && s->mode == VIEW_SCENE)
        return true;
    return app->set && s->mode == VIEW_SPHERES &&
           s->compare != VIEW_SPLIT_SUM &&
           view_renderer_samples(app->renderer) < VIEW_TRUTH_SAMPLES;
}

/* ---- events -------------------------------------------------------------- */

static void key(void *cookie, int code, bool shift)
{
    view_app *app = cookie;

    app->notice[0] = '\0';
    if (app->set)
        view_keys_press(app, code, shift);
    else if (code == 'q' || code == VIEW_KEY_ESCAPE)
        app->quit = true;
}

static void mouse(void *cookie, double x, double y, int button, bool down)
{
    view_app *app = cookie;
    view_settings *s = &app->settings;
    const double dx = x - app->mouse[0], dy = y - app->mouse[1];
    int width, height;

    view_screen_size(app->screen, &width, &height);
    app->mouse[0] = x;
    app->mouse[1] = y;
    app->redraw = true;
    if (button >= 0 && button < 3)
        app->held[button] = down;
    if (button >= 0 && down)
        app->notice[0] = '\0';
    if (!app->set || width < 1 || height < 1)
        return;
    if (button < 0 && app->held[0])
        view_drag(s, app->set, width, height, dx, dy);
    else if (button < 0 && app->held[1])
        view_spin(s, 180 * dx / height);
    if (app->held[2])
        s->split = x < 0 ? 0 : x > width ? 1 : x / width;
}

static void wheel(void *cookie, double steps)
{
    view_app *app = cookie;
    view_place at = {.x = app->mouse[0], .y = app->mouse[1]};

    view_screen_size(app->screen, &at.width, &at.height);
    if (app->set && at.width > 0 && at.height > 0)
        view_approach(&app->settings, app->set, at, steps);
    app->redraw = true;
}

static void refresh(void *cookie)
{
    ((view_app *)cookie)->redraw = true;
}

/* ---- frames -------------------------------------------------------------- */

static void tell_stats(view_app *app)
{
    if (!app->options->stats || !app->set)
        return;
    view_stats_add(&app->stats, app->frame_ms);
    view_stats_tell(&app->stats, app->renderer, &app->settings);
}

static bool draw(view_app *app)
{
    const double begun = view_clock();
    char title[sizeof app->title];
    int width, height;

    app->redraw = false;
    view_screen_size(app->screen, &width, &height);
    if (width < 1 || height < 1) /* minimised */
        return true;
    if (!view_app_draw(app, true, width, height))
        return false;
    gl.BindFramebuffer(GL_FRAMEBUFFER, 0);
    view_window_text(app, width, height);
    view_overlay_draw(app->overlay, width, height);
    gl.Finish();
    app->frame_ms = 1e3 * (view_clock() - begun);
    view_screen_show(app->screen);
    tell_stats(app);
    view_title_text(app, title, sizeof title);
    if (strcmp(title, app->title) != 0)
        view_screen_title(app->screen, title);
    memcpy(app->title, title, sizeof title);
    return true;
}

/* Waits for events while there is nothing else to do. False: close the
 * window. */
static bool wait(view_app *app)
{
    const double seconds = app->redraw || goes_on(app) ? 0
                           : app->baker                ? BAKING_S
                                                       : POLL_S;

    return view_screen_poll(app->screen, seconds) && !app->quit;
}

static bool loop(view_app *app)
{
    double looked = view_clock();

    if (!app->notice[0])
        view_app_notice(app, "? lists the keys");
    app->redraw = true;
    for (;;) {
        if ((app->redraw || goes_on(app)) && !draw(app))
            return false;
        if (!wait(app))
            return true;
        if (!tend_bake(app))
            return false;
        if (view_clock() - looked >= POLL_S) {
            tend_files(app);
            tend_probes(app);
            looked = view_clock();
        }
    }
}

/* ---- the whole ----------------------------------------------------------- */

static bool use_probes(view_app *app, const char *index)
{
    app->probes = view_probe_set_load(app->ctx, index);
    if (!app->probes)
        return false;
    view_renderer_probes(app->renderer, app->probes);
    if (app->options->verbose)
        view_report_probe_set(app->probes);
    return true;
}

static bool make(view_app *app, const view_events *events)
{
    const view_options *o = app->options;

    app->screen = view_screen_window(o->size[0], o->size[1], "iblview", events);
    if (!app->screen)
        return false;
    if (o->verbose)
        printf("%s\n", view_screen_about(app->screen));
    app->renderer = view_renderer_create();
    app->overlay = view_overlay_create();
    return app->renderer && app->overlay &&
           (!o->probe_set || use_probes(app, o->probe_set));
}

static void unmake(view_app *app)
{
    stop_bake(app);
    view_overlay_free(app->overlay);
    view_renderer_free(app->renderer);
    view_probe_set_free(app->probes);
    view_screen_close(app->screen);
    view_set_free(&app->sets[0]);
    view_set_free(&app->sets[1]);
    free(app->baking);
    free(app->path);
}

bool view_window_run(ibl_ctx *ctx, const view_options *options)
{
    view_app app = {.ctx = ctx,
                    .options = options,
                    .settings = options->settings,
                    .mouse = {-1, -1},
                    .begun = view_clock()};
    const view_events events = {&app, key, mouse, wheel, drop, refresh};
    bool ok;

    ok = view_options_may(options) && make(&app, &events) &&
         open_path(&app, &options->request) &&
         (!app.set || view_options_suit(options, app.set)) && loop(&app);
    unmake(&app);
    return ok;
}
