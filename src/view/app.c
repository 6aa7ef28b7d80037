/* SPDX-License-Identifier: MIT */
#include "view/app.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/path.h"
#include "common/process.h"
#include "common/signals.h"
#include "view/message.h"

static const double NOTICE_S = 4;

void view_app_notice(view_app *app, const char *fmt, ...)
{
    va_list ap;

    va_start(ap, fmt);
    vsnprintf(app->notice, sizeof app->notice, fmt, ap);
    va_end(ap);
    ibl_one_line(app->notice);
    app->notice_ends = ibl_now() + NOTICE_S;
    app->failed = false;
    app->redraw = true;
}

void view_app_notice_failure(view_app *app)
{
    view_app_notice(app, "%s", view_last_failure());
    app->notice_ends += 2 * NOTICE_S;
    app->failed = true;
    /* Without a set, only the folder's list can show another. */
    app->files = app->files || (!app->set && app->folder.path);
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
    const int levels =
        app->set->baked.file[IBL_CONTENT_SPECULAR].texture.levels;

    for (int i = 0; i < 2; i++) {
        view_settings *s = &app->side[i];
        if (s->mode == VIEW_MODEL && !app->model) {
            s->mode = VIEW_SPHERES;
            view_app_notice(app, "there is no model: open a .gltf or .glb");
        }
        if (!app->set->baked.file[IBL_CONTENT_SPECULAR].path) /* a map's */
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
        if (!app->set->baked.file[IBL_CONTENT_LOBE_TABLE].texture.data &&
            view_needs_lobes(s->reflection)) {
            s->reflection = VIEW_SPLIT_SUM;
            view_app_notice(app, "there is no table of lobes: iblbake "
                                 "--lobe-table writes it");
        }
    }
    view_controls_share(&app->side[0], &app->side[1]);
    /* A comparison begins with the reference, as on the command line. */
    if (!app->side[0].compare && !app->options->against &&
        !app->options->against_set) {
        app->side[1] = app->side[0];
        if (view_shows_materials(&app->side[0]))
            app->side[1].reflection = VIEW_REFERENCE;
    }
    app->edited = app->side[0].compare ? app->edited : 0;
    app->redraw = true;
}

const char *view_app_why(const view_app *app, const view_control *c)
{
    return view_control_why(c, &app->side[app->edited], app->probes,
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
    return app->baker;
}

static bool load_model(view_app *app, const char *path)
{
    ibl_scene scene;
    view_model *model = NULL;

    if (!ibl_scene_read(app->ctx, path, false, &scene))
        model = view_model_create(app->ctx, &scene, path);
    ibl_scene_free(&scene);
    if (!model)
        return false;
    view_renderer_model(app->renderer, model);
    view_model_free(app->model);
    app->model = model;
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
    return true;
}

/* Shows the list of files of a folder. */
static bool load_folder(view_app *app, const char *path)
{
    view_folder folder;

    if (!view_folder_read(path, &folder))
        return false;
    view_folder_free(&app->folder);
    app->folder = folder;
    return app->files = true;
}

static bool load(view_app *app, const view_request *what)
{
    const char *why;

    switch (view_kind_of(what->path, &why)) {
    case VIEW_KIND_NONE:
        return view_fail("%s: %s", what->path, why);
    case VIEW_KIND_MODEL:
        if (!load_model(app, what->path))
            return false;
        app->side[0].mode = VIEW_MODEL;
        view_app_fit(app);
        return true;
    case VIEW_KIND_MAP:
        return start_bake(app, what);
    case VIEW_KIND_FOLDER:
        return load_folder(app, what->path);
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

bool view_app_open(view_app *app, const view_request *what)
{
    const bool ok = load(app, what);

    if (!ok)
        view_app_notice_failure(app);
    app->redraw = true;
    return ok;
}

void view_app_list(view_app *app)
{
    const char *shown = app->baker ? app->baking : app->path;
    char *folder = ibl_need(ibl_path_beside(shown, "."));

    if (!load_folder(app, folder))
        view_app_notice_failure(app);
    free(folder);
}

void view_app_choose(view_app *app, const char *name)
{
    char *path = ibl_need(ibl_path_join(app->folder.path, name));

    app->files = false;
    view_app_open(app, &(view_request){.path = path});
    free(path);
}

void view_app_step(view_app *app, int step)
{
    const char *shown = app->baker ? app->baking : app->path, *why;
    const view_kind kind = view_kind_of(shown, &why);

    app->files = false;
    view_app_list(app);
    const int next = app->files ? view_folder_step(&app->folder, kind,
                                                   ibl_path_name(shown), step)
                                : -1;
    app->files = false;
    if (next < 0)
        view_app_notice(app, "there are no others in the folder");
    else
        view_app_choose(app, app->folder.entry[next].name);
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
    memcpy(app->drawn, app->side, sizeof app->drawn);
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
        view_app_open(app, &app->request);
        app->side[0].layer = app->request.layer = app->set->layer;
    }
    if (!baker)
        return true;
    /* Frames take time from the bake: twenty are enough. */
    const int shown = (int)(20 * app->baked);
    const bool ended = view_baker_poll(baker, &app->baked);
    app->redraw = app->redraw || ended || (int)(20 * app->baked) != shown;
    if (!ended)
        return true;
    app->baker = NULL;
    if (view_baker_finish(baker, free_slot(app)) &&
        show(app, &(view_request){.path = app->baking}))
        return true;
    view_app_notice_failure(app);
    return app->set || app->folder.path;
}

/* ---- frames -------------------------------------------------------------- */

int view_app_panel_width(const view_app *app)
{
    return (int)fmin(330 * app->scale, 0.6 * app->width);
}

view_area view_app_area(const view_app *app)
{
    const view_settings *s = &app->side[0];
    const int line = (int)(VIEW_LINE * app->scale);
    const int panel = app->panel ? view_app_panel_width(app) : 0;
    view_area a = {0, 0, app->width - panel, app->height};
    const bool small = a.width < 24 * line;
    const bool axes = s->mode == VIEW_SPHERES || s->mode == VIEW_TABLE;
    const bool names = axes || s->mode == VIEW_SOURCE_MAP ||
                       (!view_is_lit(s) && s->layout != VIEW_CROSS);
    const int above = (s->compare || s->false_colour ? 2 : 1) * line + line / 3;
    const int below = !small && names ? line : 0;

    if (!app->labels || a.height < 3 * (above + below))
        return a;
    a.x = !small && axes ? 4 * line : 0;
    a.y = below;
    a.width -= a.x;
    a.height -= above + below;
    return a;
}

void view_app_map_size(const view_app *app, double size[2])
{
    static const double cubes[VIEW_LAYOUTS] = {4.0 / 3, 6, 2};
    const view_settings *s = &app->side[0];
    const view_area a = view_app_area(app);
    const ibl_image *map =
        s->mode == VIEW_SOURCE_MAP ? view_set_source(app->set) : NULL;
    const double shape = map ? (double)map->width / map->height
                         : s->mode == VIEW_TABLE ? 1
                                                 : cubes[s->layout];

    size[0] = s->zoom * fmin(a.width, shape * a.height);
    size[1] = size[0] / shape;
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

bool view_app_draw(view_app *app, bool spread)
{
    gl.BindFramebuffer(GL_FRAMEBUFFER, app->target);
    gl.Viewport(0, 0, app->width, app->height);
    gl.ClearColor(0.1F, 0.1F, 0.1F, 1);
    gl.Clear(GL_COLOR_BUFFER_BIT);
    view_renderer_target(app->renderer, app->target);
    if (!app->set)
        return true;
    if (!draw_as_set(app, spread)) {
        /* New settings may need more memory than there is. */
        if (!memcmp(app->side, app->drawn, sizeof app->side))
            return false;
        memcpy(app->side, app->drawn, sizeof app->side);
        view_app_notice_failure(app);
        if (!draw_as_set(app, spread))
            return false;
    }
    memcpy(app->drawn, app->side, sizeof app->drawn);
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
