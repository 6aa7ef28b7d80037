/* SPDX-License-Identifier: MIT */
#include "view/app.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "common/process.h"
#include "view/message.h"
#include "view/picture.h"

/* Files that were not written to for so long are complete. */
static const double SETTLE_S = 0.25;

void view_app_notice(view_app *app, const char *fmt, ...)
{
    va_list ap;

    va_start(ap, fmt);
    vsnprintf(app->notice, sizeof app->notice, fmt, ap);
    va_end(ap);
    ibl_one_line(app->notice);
    app->redraw = true;
}

const char *view_path_end(const char *path, size_t most)
{
    const size_t length = strlen(path);
    return path + (length > most ? length - most : 0);
}

void view_app_notice_path(view_app *app, const char *path)
{
    const char *end = view_path_end(path, 60);

    view_app_notice(app, "%s%s is not shown: the terminal says why",
                    end > path ? ".." : "", end);
}

/* ---- opening ------------------------------------------------------------ */

static baked_set *free_slot(view_app *app)
{
    return app->set == &app->sets[0] ? &app->sets[1] : &app->sets[0];
}

void view_app_fit(view_app *app)
{
    const int levels = app->set->texture[VIEW_SPECULAR].levels;

    if (!app->set->path[VIEW_SPECULAR]) /* a map's */
        app->settings.layer = 0;
    if (app->settings.level >= levels)
        app->settings.level = levels - 1;
    if (app->settings.diffuse == VIEW_DIFFUSE_SH && app->set->sh_degree < 0) {
        app->settings.diffuse = VIEW_DIFFUSE_MAP;
        view_app_notice(app, "there are no spherical harmonics: the sidecar "
                             "has them");
    }
    if (!app->set->texture[VIEW_LOBES].data &&
        (view_needs_lobes(app->settings.reflection) ||
         view_needs_lobes(app->settings.against))) {
        app->settings.reflection = VIEW_SPLIT_SUM;
        app->settings.against = VIEW_REFERENCE;
        view_app_notice(app, "there is no table of lobes: iblbake --lobe-table "
                             "writes it");
    }
    app->redraw = true;
}

/* Shows the set in the free slot. If that fails, restores the previous set and
 * empties the slot. */
static bool show(view_app *app, const view_request *what)
{
    baked_set *set = free_slot(app);

    if (!view_renderer_load(app->renderer, set)) {
        view_set_free(set);
        if (app->set && !view_renderer_load(app->renderer, app->set))
            app->set = NULL;
        return false;
    }
    app->set = set;
    app->drew = false;
    view_set_free(free_slot(app)); /* the previous set */
    view_app_fit(app);
    if (app->options->verbose)
        view_report_set(set);
    app->request = *what;
    if (what->path != app->path)
        snprintf(app->path, sizeof app->path, "%s", what->path);
    app->request.path = app->path;
    return true;
}

static void stop_bake(view_app *app)
{
    if (app->baker)
        view_baker_finish(app->baker, NULL);
    app->baker = NULL;
}

static bool start_bake(view_app *app, const view_request *what)
{
    stop_bake(app);
    snprintf(app->baking, sizeof app->baking, "%s", what->path);
    app->baker = view_baker_start(what);
    app->baked = 0;
    snprintf(app->stage, sizeof app->stage, "starting");
    app->redraw = true;
    return app->baker;
}

static bool load_model(view_app *app, const char *path)
{
    char *const file = app->model_path;
    ibl_scene scene;
    view_model *model = NULL;

    if (path != file)
        snprintf(file, sizeof app->model_path, "%s", path);
    view_files_see(&file, 1, &app->model_seen);
    if (!ibl_scene_read(app->ctx, path, false, &scene))
        model = view_model_create(app->ctx, &scene, path);
    ibl_scene_free(&scene);
    if (!model)
        return false;
    view_renderer_model(app->renderer, model);
    view_model_free(app->model);
    app->model = model;
    app->redraw = true;
    return true;
}

static bool open_model(view_app *app, const char *path)
{
    if (!load_model(app, path))
        return false;
    app->settings.mode = VIEW_MODEL;
    return true;
}

bool view_app_open(view_app *app, const view_request *what)
{
    if (view_is_model(what->path))
        return open_model(app, what->path);
    if (view_is_map(what->path, what->layout))
        return start_bake(app, what);
    if (!view_set_open(app->ctx, what, free_slot(app)) || !show(app, what))
        return false;
    /* A bake that was started earlier would replace this set. */
    stop_bake(app);
    return true;
}

static bool load_probes(view_app *app)
{
    view_probe_set *set =
        view_probe_set_load(app->ctx, app->options->probe_set);

    if (!set)
        return false;
    view_renderer_probes(app->renderer, set);
    view_probe_set_free(app->probes);
    app->probes = set;
    app->redraw = true;
    return true;
}

static bool load_other(view_app *app)
{
    const view_request what = {.path = app->options->against_set};
    baked_set set;

    if (!(view_is_map(what.path, IBL_INPUT_AUTO)
              ? view_set_bake(app->ctx, &what, &set)
              : view_set_open(app->ctx, &what, &set)))
        return false;
    view_set_free(&app->other);
    app->other = set;
    app->redraw = true;
    return view_renderer_against(app->renderer, &app->other);
}

bool view_app_make(view_app *app)
{
    const view_options *o = app->options;

    if (o->verbose)
        printf("OpenGL %s, %s\n", (const char *)gl.GetString(GL_VERSION),
               (const char *)gl.GetString(GL_RENDERER));
    app->renderer = view_renderer_create();
    app->overlay = app->renderer ? view_overlay_create() : NULL;
    if (!app->renderer || !app->overlay)
        return false;
    if ((o->probe_set && !load_probes(app)) ||
        (o->against_set && !load_other(app)))
        return false;
    if (o->model && !load_model(app, o->model))
        return false;
    if (o->verbose && o->probe_set)
        view_report_probe_set(app->probes, o->probe_set);
    return true;
}

void view_app_end(view_app *app)
{
    stop_bake(app);
    view_overlay_free(app->overlay);
    view_renderer_free(app->renderer);
    view_model_free(app->model);
    view_probe_set_free(app->probes);
    view_set_free(&app->other);
}

/* ---- between frames ------------------------------------------------------ */

bool view_app_tend_bake(view_app *app)
{
    view_baker *baker = app->baker;

    if (!baker)
        return true;
    app->redraw = true;
    if (!view_baker_poll(baker, app->stage, &app->baked))
        return true;
    app->baker = NULL;
    if (view_baker_finish(baker, free_slot(app)) &&
        show(app, &(view_request){.path = app->baking}))
        return true;
    view_app_notice_path(app, app->baking);
    return app->set;
}

/* Says that a file was read again, or could not be. */
static void tell(view_app *app, const char *path, bool ok)
{
    if (ok)
        view_note("%s: read anew", path);
    else
        view_app_notice_path(app, path);
}

/* After a failure the next attempt follows the next change. */
void view_app_tend_files(view_app *app)
{
    char *const model = app->model_path;

    if (app->model &&
        view_files_changed(&model, 1, &app->model_seen, SETTLE_S, SETTLE_S))
        tell(app, model, load_model(app, model));
    if (app->set && !app->baker && app->settings.layer != app->set->layer) {
        app->request.layer = app->settings.layer;
        if (!view_app_open(app, &app->request))
            view_app_notice(app, "no layer %d", app->settings.layer);
        app->settings.layer = app->request.layer = app->set->layer;
    }
    if (app->set && !app->baker && view_set_changed(app->set, SETTLE_S)) {
        view_set_seen(app->set);
        const bool ok = view_app_open(app, &app->request);
        if (!ok || !app->baker)
            tell(app, app->request.path, ok);
    }
    if (app->probes && view_probe_set_changed(app->probes, SETTLE_S)) {
        view_probe_set_seen(app->probes);
        tell(app, app->options->probe_set, load_probes(app));
    }
    if (app->other.name && view_set_changed(&app->other, SETTLE_S)) {
        view_set_seen(&app->other);
        tell(app, app->options->against_set, load_other(app));
    }
}

/* ---- frames -------------------------------------------------------------- */

static bool draw_as_set(view_app *app, bool spread)
{
    view_settings now = app->settings;

    now.spread = spread;
    now.seconds += ibl_now() - app->begun;
    return view_renderer_draw(app->renderer, &now, app->width, app->height);
}

/* The new settings may need more memory than there is: returns to the last ones
 * that could be drawn. */
static bool go_back(view_app *app)
{
    if (!app->drew)
        return false;
    app->drew = false;
    app->settings = app->drawn;
    view_app_notice(app, "as it was before: the terminal says why");
    return true;
}

bool view_app_draw(view_app *app, bool spread)
{
    if (!app->set) {
        gl.BindFramebuffer(GL_FRAMEBUFFER, 0);
        gl.Viewport(0, 0, app->width, app->height);
        gl.ClearColor(0, 0, 0, 1);
        gl.Clear(GL_COLOR_BUFFER_BIT);
        return true;
    }
    app->settings.covered = view_panel_share(app);
    if (!draw_as_set(app, spread) &&
        !(go_back(app) && draw_as_set(app, spread)))
        return false;
    app->drawn = app->settings;
    app->drew = true;
    return true;
}

/* ---- what keys do ------------------------------------------------------- */

/* Finds a name that no file has yet. */
static bool free_name(char *path, size_t size)
{
    for (int number = 1; number <= 999; number++) {
        snprintf(path, size, "iblview-%03d.png", number);
        if (access(path, F_OK))
            return true;
    }
    return false;
}

void view_app_picture(view_app *app)
{
    char path[32];
    unsigned char *rgb = NULL;

    if (!free_name(path, sizeof path)) {
        view_app_notice(app, "no picture is written: up to %s all are there",
                        path);
        return;
    }
    bool drawn = view_app_draw(app, false);
    while (drawn && !view_renderer_complete(app->renderer))
        drawn = view_app_draw(app, false);
    if (drawn)
        rgb = view_renderer_picture(app->renderer);
    if (rgb && view_picture_write(app->ctx, path, app->width, app->height, rgb))
        view_app_notice(app, "%s is written", path);
    else
        view_app_notice(app, "%s is not written: the terminal says why", path);
    free(rgb);
}
