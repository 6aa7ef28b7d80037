/* SPDX-License-Identifier: MIT */
#include "view/app.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "common/path.h"
#include "common/process.h"
#include "common/signals.h"
#include "view/inspect.h"
#include "view/message.h"

static const double NOTICE_S = 4;

static void notice(view_app *app, bool failed, const char *text)
{
    snprintf(app->notice, sizeof app->notice, "%s", text);
    ibl_one_line(app->notice);
    app->notice_ends = ibl_now() + (failed ? 3 : 1) * NOTICE_S;
    app->failed = failed;
    app->redraw = true;
}

void view_app_notice(view_app *app, const char *fmt, ...)
{
    char text[sizeof app->notice];
    va_list ap;

    va_start(ap, fmt);
    vsnprintf(text, sizeof text, fmt, ap);
    va_end(ap);
    notice(app, false, text);
}

void view_app_notice_failure(view_app *app)
{
    notice(app, true, view_last_failure());
}

/* ---- opening ------------------------------------------------------------ */

static baked_set *free_slot(view_app *app)
{
    return app->set == &app->sets[0] ? &app->sets[1] : &app->sets[0];
}

void view_app_fit(view_app *app)
{
    if (!app->set)
        return;
    const int levels = app->set->texture[VIEW_SPECULAR].levels;

    for (int i = 0; i < 2; i++) {
        view_settings *s = &app->side[i];
        if (!app->set->path[VIEW_SPECULAR]) /* a map's */
            s->layer = 0;
        if (s->level >= levels)
            s->level = levels - 1;
        if (s->background_level >= levels)
            s->background_level = levels - 1;
        const char *lacks = view_set_lacks(app->set, s->diffuse);
        if (lacks) {
            s->diffuse = VIEW_DIFFUSE_AUTO;
            view_app_notice(app, "there %s", lacks);
        }
        if (!app->set->texture[VIEW_LOBES].data &&
            view_needs_lobes(s->reflection)) {
            s->reflection = VIEW_SPLIT_SUM;
            view_app_notice(app, "there is no table of lobes: iblbake "
                                 "--lobe-table writes it");
        }
    }
    view_controls_share(&app->side[0], &app->side[1]);
    app->redraw = true;
}

const char *view_app_why(const view_app *app, const view_control *c)
{
    return view_control_why(c, &app->side[app->edited], app->model, app->probes,
                            app->options);
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
    app->side[0].layer = set->layer;
    view_app_fit(app);
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
    view_request own = *what;
    own.path = app->baking;
    app->baker = view_baker_start(&own);
    app->baked = 0;
    snprintf(app->stage, sizeof app->stage, "starting");
    app->redraw = true;
    return app->baker;
}

static bool load_model(view_app *app, const char *path)
{
    ibl_scene scene;
    view_model *model = NULL;

    snprintf(app->model_path, sizeof app->model_path, "%s", path);
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

static bool load_probes(view_app *app, const char *index)
{
    view_probe_set *set = view_probe_set_load(app->ctx, index);

    if (!set)
        return false;
    view_renderer_probes(app->renderer, set);
    view_probe_set_free(app->probes);
    app->probes = set;
    app->redraw = true;
    return true;
}

static bool open_model(view_app *app, const char *path)
{
    if (!load_model(app, path))
        return false;
    app->side[0].mode = VIEW_MODEL;
    view_app_fit(app);
    return true;
}

/* Shows the list of files of a folder. */
static bool open_folder(view_app *app, const char *path)
{
    view_folder folder;

    if (!view_folder_read(path, &folder))
        return false;
    view_folder_free(&app->folder);
    app->folder = folder;
    app->files = app->redraw = true;
    return true;
}

bool view_app_open(view_app *app, const view_request *what)
{
    const char *why;
    const view_kind kind = view_kind_of(what->path, what->layout, &why);

    switch (kind) {
    case VIEW_KIND_NONE:
        return view_fail("%s: %s", what->path, why);
    case VIEW_KIND_MODEL:
        return open_model(app, what->path);
    case VIEW_KIND_MAP:
        return start_bake(app, what);
    case VIEW_KIND_FOLDER:
        return open_folder(app, what->path);
    case VIEW_KIND_PROBES:
        if (app->set && app->side[0].mode == VIEW_SCENE)
            return load_probes(app, what->path);
        break;
    case VIEW_KIND_SET:
        break;
    }
    if (!view_set_open(app->ctx, what, free_slot(app)) || !show(app, what))
        return false;
    /* A bake that was started earlier would replace this set. */
    stop_bake(app);
    return true;
}

bool view_app_list(view_app *app)
{
    char *folder = ibl_need(ibl_path_beside(app->path, ""));
    const bool ok = open_folder(app, *folder ? folder : ".");

    free(folder);
    return ok;
}

void view_app_choose(view_app *app, const char *name)
{
    char *path = ibl_need(ibl_format("%s/%s", app->folder.path, name));

    app->files = false;
    if (!view_app_open(app, &(view_request){.path = path}))
        view_app_notice_failure(app);
    free(path);
}

void view_app_step(view_app *app, int step)
{
    const char *shown = app->baker ? app->baking : app->path;
    char *folder = ibl_need(ibl_path_beside(shown, ""));
    const char *name = ibl_path_name(shown), *why;
    const view_kind kind = view_kind_of(shown, IBL_INPUT_AUTO, &why);
    view_folder list = {0};
    int next = -1;

    if (view_folder_read(*folder ? folder : ".", &list))
        next = view_folder_step(&list, kind, name, step);
    if (next < 0) {
        view_app_notice(app, "there are no others in the folder");
    } else {
        char *path = ibl_need(ibl_path_beside(shown, list.entry[next].name));
        if (!view_app_open(app, &(view_request){.path = path}))
            view_app_notice_failure(app);
        else
            view_app_notice(app, "%s", list.entry[next].name);
        free(path);
    }
    view_folder_free(&list);
    free(folder);
}

static bool load_other(view_app *app)
{
    const view_request what = {.path = app->options->against_set};

    if (!view_still_load(app->ctx, &what, &app->other))
        return false;
    const char *lacks = view_set_lacks(&app->other, app->side[1].diffuse);
    return !lacks ? view_renderer_against(app->renderer, &app->other)
                  : view_fail("%s: --diffuse: there %s", what.path, lacks);
}

bool view_app_make(view_app *app)
{
    const view_options *o = app->options;

    app->renderer = view_renderer_create();
    if (!app->renderer)
        return false;
    return (!o->probe_set || load_probes(app, o->probe_set)) &&
           (!o->against_set || load_other(app)) &&
           (!o->model || load_model(app, o->model));
}

void view_app_end(view_app *app)
{
    stop_bake(app);
    view_renderer_free(app->renderer);
    view_model_free(app->model);
    view_probe_set_free(app->probes);
    view_set_free(&app->other);
    view_folder_free(&app->folder);
}

bool view_app_tend(view_app *app)
{
    view_baker *baker = app->baker;

    if (app->notice[0] && ibl_now() > app->notice_ends) {
        app->notice[0] = '\0';
        app->redraw = true;
    }
    if (app->set && !baker && app->side[0].layer != app->set->layer) {
        app->request.layer = app->side[0].layer;
        if (!view_app_open(app, &app->request))
            view_app_notice_failure(app);
        app->side[0].layer = app->request.layer = app->set->layer;
    }
    if (!baker)
        return true;
    app->redraw = true;
    if (!view_baker_poll(baker, app->stage, &app->baked))
        return true;
    app->baker = NULL;
    if (view_baker_finish(baker, free_slot(app)) &&
        show(app, &(view_request){.path = app->baking}))
        return true;
    view_app_notice_failure(app);
    return app->set;
}

/* ---- frames -------------------------------------------------------------- */

/* Takes the room of labels off a picture's area; less for small ones. */
static void take_margins(const view_settings *s, double scale, view_area *area)
{
    const int line = (int)(VIEW_LINE * scale), space = line / 3;
    const bool axes = s->mode == VIEW_SPHERES || s->mode == VIEW_TABLE;
    const bool names = axes || s->mode == VIEW_SOURCE_MAP ||
                       (!view_is_lit(s) && s->layout != VIEW_CROSS);
    const bool two = s->compare || s->false_colour;
    const bool small = area->width < 24 * line;
    const int above = (two ? 2 : 1) * line + space;
    const int below = !small && names ? line : 0;

    if (area->height < 3 * (above + below))
        return;
    area->height -= above + below;
    area->y += below;
    if (!small && axes) {
        area->x += 4 * line;
        area->width -= 4 * line;
    }
}

int view_app_panel_width(const view_app *app)
{
    return (int)fmin(330 * app->scale, 0.6 * app->width);
}

view_area view_app_area(const view_app *app)
{
    const int right = app->panel ? view_app_panel_width(app) : 0;
    view_area a = {0, 0, app->width - right, app->height};

    if (app->labels)
        take_margins(&app->side[0], app->scale, &a);
    return a;
}

static bool draw_as_set(view_app *app, bool spread)
{
    const view_area area = view_app_area(app);
    view_settings now[2];

    memcpy(now, app->side, sizeof now);
    for (int i = 0; i < 2; i++) {
        now[i].spread = spread;
        now[i].seconds += app->paused ? 0 : ibl_now() - app->begun;
    }
    return view_renderer_draw(app->renderer, now, &area);
}

/* The new settings may need more memory than there is: returns to the last ones
 * that could be drawn. */
static bool go_back(view_app *app)
{
    if (!app->drew)
        return false;
    app->drew = false;
    memcpy(app->side, app->drawn, sizeof app->side);
    view_app_notice_failure(app);
    return true;
}

bool view_app_draw(view_app *app, bool spread)
{
    gl.BindFramebuffer(GL_FRAMEBUFFER, app->target);
    gl.Viewport(0, 0, app->width, app->height);
    gl.ClearColor(0.1F, 0.1F, 0.1F, 1);
    gl.Clear(GL_COLOR_BUFFER_BIT);
    view_renderer_target(app->renderer, app->target);
    if (!app->set)
        return true;
    if (!draw_as_set(app, spread) &&
        !(go_back(app) && draw_as_set(app, spread)))
        return false;
    memcpy(app->drawn, app->side, sizeof app->drawn);
    app->drew = true;
    return true;
}

/* ---- what keys do ------------------------------------------------------- */

bool view_app_expose(view_app *app)
{
    const view_area area = view_app_area(app);
    const size_t count = (size_t)area.width * (size_t)area.height;
    float *rgb = ibl_need(malloc(3 * count * sizeof *rgb));
    double sum = 0;

    const bool ok = view_renderer_read(app->renderer, 0, rgb);
    for (size_t i = 0; i < count && ok; i++) {
        const double y = 0.2126 * (double)rgb[3 * i] +
                         0.7152 * (double)rgb[3 * i + 1] +
                         0.0722 * (double)rgb[3 * i + 2];
        sum += isfinite(y) && y > 0 ? y : 0;
    }
    free(rgb);
    if (!ok || sum <= 0)
        return false;
    app->side[0].ev = fmin(fmax(log2(0.18 * (double)count / sum), -30), 30);
    view_app_fit(app);
    return true;
}
