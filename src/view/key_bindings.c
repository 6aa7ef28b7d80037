/* SPDX-License-Identifier: MIT */
#include "view/app.h"

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <math.h>
#include <string.h>

#include "common/process.h"
#include "view/room.h"
#include "view/sphere_grid.h"
#include "view/vector.h"

/* ---- the mouse, and keys for it ------------------------------------------ */

/* The same angle in (-180, 180]. */
static double turned(double degrees)
{
    const double x = remainder(degrees, 360);
    return x == -180 ? 180 : x;
}

/* Moves a map or a model by fractions of its size. */
static void move(view_settings *s, double dx, double dy)
{
    s->pan[0] = fmin(fmax(s->pan[0] - dx, -0.5), 0.5);
    s->pan[1] = fmin(fmax(s->pan[1] - dy, -0.5), 0.5);
}

void view_drag(view_app *app, double dx, double dy)
{
    view_settings *s = &app->side[0];
    const view_area area = view_app_area(app);
    double size[2];

    if (!view_is_lit(s)) {
        view_app_map_size(app, size);
        move(s, dx / size[0], dy / size[1]);
    } else {
        s->yaw = turned(s->yaw - 180 * dx / area.height);
        s->pitch = fmin(fmax(s->pitch + 180 * dy / area.height, -89), 89);
        s->file_camera = 0;
    }
    view_app_fit(app);
}

void view_approach(view_app *app, double x, double y, double steps)
{
    view_settings *s = &app->side[0];
    const view_area area = view_app_area(app);
    const double factor = pow(1.1, steps);

    if (!view_is_lit(s)) {
        const double from[2] = {x - area.x - 0.5 * area.width,
                                y - app->height + area.y + 0.5 * area.height};
        double before[2], after[2];
        view_app_map_size(app, before);
        s->zoom = fmin(fmax(s->zoom * factor, 0.25), 10000); /* as --zoom */
        view_app_map_size(app, after);
        move(s, from[0] / after[0] - from[0] / before[0],
             from[1] / after[1] - from[1] / before[1]);
    } else {
        if (s->distance <= 0 && s->mode == VIEW_SCENE)
            s->distance = view_scene_distance;
        if (s->distance <= 0) {
            const view_camera c = view_camera_of(s, area.width, area.height);
            s->distance = -dot3(c.eye, c.forward);
        }
        s->distance =
            fmin(fmax(s->distance / factor, s->mode == VIEW_MODEL ? 0.05 : 0.6),
                 1000);
        s->file_camera = 0;
    }
    view_app_fit(app);
}

void view_pan(view_app *app, double dx, double dy)
{
    const view_area area = view_app_area(app);
    const view_camera c =
        view_camera_of(&app->side[0], area.width, area.height);
    const double pixel =
        sqrt(dot3(c.up, c.up)) / area.height * -dot3(c.eye, c.forward);

    move(&app->side[0], pixel * dx, pixel * dy);
    view_app_fit(app);
}

void view_spin(view_app *app, double degrees)
{
    app->side[0].turn = turned(app->side[0].turn + degrees);
    view_app_fit(app);
}

/* ---- keys ---------------------------------------------------------------- */

/* The other side becomes as this one, to be changed from there. */
static void copy_side(view_app *app)
{
    app->side[!app->edited] = app->side[app->edited];
    if (!app->side[0].compare)
        app->side[0].compare = VIEW_SPLIT;
    app->edited = !app->edited;
    view_app_fit(app);
    view_app_notice(app, "both sides are alike: changes are of the %s one",
                    app->edited ? "right" : "left");
}

static void pause_time(view_app *app)
{
    const double now = ibl_now();

    for (int i = 0; i < 2 && !app->paused; i++)
        app->side[i].seconds += now - app->begun;
    app->begun = now;
    app->paused = !app->paused;
    view_app_notice(app, app->paused ? "time stands still" : "time goes on");
}

static void fill_screen(view_app *app)
{
    GLFWmonitor *const monitor = glfwGetPrimaryMonitor();
    const GLFWvidmode *mode = monitor ? glfwGetVideoMode(monitor) : NULL;

    if (mode && !glfwGetWindowMonitor(app->window))
        glfwSetWindowMonitor(app->window, monitor, 0, 0, mode->width,
                             mode->height, mode->refreshRate);
    else
        glfwSetWindowMonitor(app->window, NULL, 60, 60, app->options->size[0],
                             app->options->size[1], GLFW_DONT_CARE);
}

static void act(view_app *app, view_act what, int step)
{
    switch (what) {
    case VIEW_COPY_SIDE:
        copy_side(app);
        break;
    case VIEW_OTHER_SIDE:
        app->edited = app->side[0].compare && !app->edited;
        if (app->side[0].compare)
            view_app_notice(app, "changes are of the %s side",
                            app->edited ? "right" : "left");
        else
            view_app_notice(app, "nothing is compared: f compares");
        break;
    case VIEW_MOVE_ACROSS:
        view_drag(app, -step * app->height / 36.0, 0);
        break;
    case VIEW_MOVE_UP:
        view_drag(app, 0, step * app->height / 36.0);
        break;
    case VIEW_APPROACH:
        view_approach(app, 0.5 * app->width, 0.5 * app->height, step);
        break;
    case VIEW_PAUSE:
        pause_time(app);
        break;
    case VIEW_EXPOSE:
        if (view_app_expose(app))
            view_app_notice(app, "exposure %+.2f: the mean is middle grey",
                            app->side[0].ev);
        break;
    case VIEW_RESET:
        app->side[0] = app->options->settings;
        app->side[1] = app->options->other;
        app->edited = 0;
        view_app_fit(app);
        view_app_notice(app, "all as it was in the beginning");
        break;
    case VIEW_LIST_FILES:
        if (app->files)
            app->files = false;
        else
            view_app_list(app);
        break;
    case VIEW_STEP_FILE:
        view_app_step(app, step);
        break;
    case VIEW_OPEN_AGAIN:
        if (view_app_open(app, &app->request))
            view_app_notice(app, "%s is read again", app->request.path);
        break;
    case VIEW_WRITE_PICTURE:
        app->wants_picture = true;
        break;
    case VIEW_SHOW_PANEL:
        app->panel = !app->panel;
        break;
    case VIEW_SHOW_KEYS:
        app->help = !app->help;
        break;
    case VIEW_FILL_SCREEN:
        fill_screen(app);
        break;
    case VIEW_CLOSE:
        app->panel = app->panel && (app->help || app->files);
        app->help = app->files = false;
        app->notice[0] = '\0';
        break;
    case VIEW_QUIT:
        app->quit = true;
        break;
    }
}

/* Changes a setting, or says why that would change nothing. */
static void change(view_app *app, const view_control *c, int step)
{
    const int side = view_control_of_side(c) ? app->edited : 0;
    view_settings *s = &app->side[side];
    const char *why = view_app_why(app, c);
    char value[80];

    if (why) {
        view_app_notice(app, "%s: %s", c->label, why);
        return;
    }
    do
        view_control_step(c, s, step);
    while ((s->mode == VIEW_MODEL && !app->model) ||
           (!strcmp(c->option.name, "reflection") &&
            ((view_needs_lobes(s->reflection) &&
              !app->set->baked.file[IBL_CONTENT_LOBE_TABLE].texture.data) ||
             (s->mode == VIEW_SCENE && s->reflection == VIEW_REFERENCE))));
    view_control_text(c, s, value);
    view_app_notice(app, "%s: %s", c->label, value);
    view_app_fit(app);
}

void view_keys_press(view_app *app, int key)
{
    const view_control *c;

    app->redraw = true;
    for (const view_action *a = view_actions; a->title; a++)
        if (key == a->key || (key == a->back && key))
            act(app, a->act, key == a->key ? 1 : -1);
    for (int i = 0; (c = view_control_at(i)); i++)
        if (c->key && (key == c->key || key == c->back))
            change(app, c, key == c->key ? 1 : -1);
}
