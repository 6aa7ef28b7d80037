/* SPDX-License-Identifier: MIT */
/* The window, by GLFW, whose error texts become part of our messages. */

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <math.h>
#include <stdio.h>

#include "common/process.h"
#include "view/app.h"
#include "view/gl.h"
#include "view/message.h"
#include "view/truth.h"
#include "view/ui.h"

/* Seconds between looks at a bake, at a message. */
static const double BAKING_S = 0.01, NOTICE_S = 0.1;

/* Values of view_app.held. */
enum {
    LEFT = 1 + GLFW_MOUSE_BUTTON_LEFT,
    RIGHT = 1 + GLFW_MOUSE_BUTTON_RIGHT,
    MIDDLE = 1 + GLFW_MOUSE_BUTTON_MIDDLE
};

static char reason[512];

static void keep_reason(int code, const char *text)
{
    (void)code;
    snprintf(reason, sizeof reason, "%s", text);
}

/* ---- events -------------------------------------------------------------- */

static view_app *app_of(GLFWwindow *window)
{
    return glfwGetWindowUserPointer(window);
}

static void press(view_app *app, int key)
{
    if (app->set || key == 'q' || key == VIEW_KEY(GLFW_KEY_ESCAPE) ||
        key == '?')
        view_keys_press(app, key);
}

static void on_character(GLFWwindow *window, unsigned int code)
{
    if (!view_ui_has_keys())
        press(app_of(window), (int)code);
}

/* Keys with a character arrive in on_character, by the keyboard's layout. */
static void on_key(GLFWwindow *window, int key, int scancode, int action,
                   int mods)
{
    (void)scancode, (void)mods;
    app_of(window)->redraw = true;
    if (action != GLFW_RELEASE && key >= GLFW_KEY_ESCAPE && !view_ui_has_keys())
        press(app_of(window), VIEW_KEY(key));
}

/* Handles the pointer at a pixel of the framebuffer; it may not have moved. */
static void move_to(view_app *app, double x, double y)
{
    const view_area area = view_app_area(app);
    view_settings *s = &app->side[0];
    const double dx = x - app->mouse[0], dy = y - app->mouse[1];

    app->mouse[0] = x;
    app->mouse[1] = y;
    app->redraw = true;
    if (!app->set)
        return;
    if (app->held == LEFT)
        view_drag(app, dx, dy);
    else if (app->held == RIGHT)
        view_spin(app, 180 * dx / area.height);
    else if (app->held == MIDDLE && s->compare == VIEW_SPLIT)
        s->split = fmin(fmax((x - area.x) / area.width, 0), 1);
    else if (app->held == MIDDLE && s->mode == VIEW_MODEL)
        view_pan(app, dx, dy);
}

/* Converts positions from screen coordinates. */
static void on_move(GLFWwindow *window, double x, double y)
{
    view_app *app = app_of(window);
    int width, height;

    glfwGetWindowSize(window, &width, &height);
    if (width > 0 && height > 0)
        move_to(app, x * app->width / width, y * app->height / height);
}

/* Takes the split of a picture that is split as a whole as the middle button
 * does. Uses the last position: glfwGetCursorPos may be ahead of pending
 * events. */
static void on_button(GLFWwindow *window, int button, int action, int mods)
{
    view_app *app = app_of(window);
    const view_area area = view_app_area(app);
    const view_settings *s = &app->side[0];
    const double away = app->mouse[0] - area.x - s->split * area.width;

    (void)mods;
    app->held = action == GLFW_PRESS && !view_ui_has_pointer() ? 1 + button : 0;
    if (app->held == LEFT && s->compare == VIEW_SPLIT &&
        s->mode != VIEW_SPHERES && fabs(away) < 6 * app->scale)
        app->held = MIDDLE;
    move_to(app, app->mouse[0], app->mouse[1]);
}

/* While a button is held, the window still gets the pointer's positions. */
static void on_enter(GLFWwindow *window, int entered)
{
    view_app *app = app_of(window);

    if (!entered && !app->held)
        move_to(app, -1, -1);
}

static void on_wheel(GLFWwindow *window, double x, double steps)
{
    view_app *app = app_of(window);

    (void)x;
    if (app->set && !view_ui_has_pointer())
        view_approach(app, app->mouse[0], app->mouse[1], steps);
    app->redraw = true;
}

static void on_drop(GLFWwindow *window, int count, const char **paths)
{
    view_app *app = app_of(window);

    for (int i = 0; i < count; i++)
        view_app_open(app, &(view_request){.path = paths[i]});
}

static void on_refresh(GLFWwindow *window)
{
    app_of(window)->redraw = true;
}

/* A minimized window may have no pixels: it gets one here. */
static void on_size(GLFWwindow *window, int width, int height)
{
    view_app *app = app_of(window);
    float x = 1, y = 1;

    glfwGetWindowContentScale(window, &x, &y);
    app->scale = (double)(y > 1 ? y : 1);
    app->width = width > 1 ? width : 1;
    app->height = height > 1 ? height : 1;
    app->redraw = true;
}

/* ---- the window ---------------------------------------------------------- */

/* No depth, no samples: only finished pictures are drawn here. */
static GLFWwindow *create(const view_options *o)
{
    glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 3);
    glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 3);
    glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
    glfwWindowHint(GLFW_OPENGL_FORWARD_COMPAT, GLFW_TRUE);
    glfwWindowHint(GLFW_DEPTH_BITS, 0);
    glfwWindowHint(GLFW_STENCIL_BITS, 0);
    glfwWindowHint(GLFW_SCALE_TO_MONITOR, GLFW_TRUE);
    /* names by which desktops identify windows */
    glfwWindowHintString(GLFW_X11_CLASS_NAME, "iblview");
    glfwWindowHintString(GLFW_X11_INSTANCE_NAME, "iblview");
    return glfwCreateWindow(o->size[0], o->size[1], "iblview", NULL, NULL);
}

/* Opens the window with a current context and gl loaded. */
static bool open_window(view_app *app)
{
    static const char advice[] =
        "--offscreen OUT.png makes pictures without one";
    int width, height;
    double x, y;

    glfwSetErrorCallback(keep_reason);
    if (!glfwInit())
        return view_fail("no window: %s; %s", reason, advice);
    app->window = create(app->options);
    if (!app->window)
        return view_fail("no window with OpenGL 3.3 core: %s; %s", reason,
                         advice);
    glfwSetWindowUserPointer(app->window, app);
    glfwMakeContextCurrent(app->window);
    if (!view_gl_load(glfwGetProcAddress))
        return false;
    glfwSwapInterval(1);
    glfwSetCharCallback(app->window, on_character);
    glfwSetKeyCallback(app->window, on_key);
    glfwSetCursorPosCallback(app->window, on_move);
    glfwSetMouseButtonCallback(app->window, on_button);
    glfwSetCursorEnterCallback(app->window, on_enter);
    glfwSetScrollCallback(app->window, on_wheel);
    glfwSetDropCallback(app->window, on_drop);
    glfwSetWindowRefreshCallback(app->window, on_refresh);
    glfwSetFramebufferSizeCallback(app->window, on_size);
    glfwGetFramebufferSize(app->window, &width, &height);
    on_size(app->window, width, height);
    glfwGetCursorPos(app->window, &x, &y);
    on_move(app->window, x, y);
    return true;
}

/* ---- frames -------------------------------------------------------------- */

/* Whether the next frame differs without any event. */
static bool goes_on(const view_app *app)
{
    const view_settings *s = app->side;
    const bool sampled = view_is_sampled(&s[0], &s[1]);

    return app->set && ((s->mode == VIEW_SCENE && !app->paused) ||
                        !view_renderer_complete(app->renderer) ||
                        (sampled && view_renderer_samples(app->renderer) <
                                        VIEW_TRUTH_SAMPLES));
}

static bool draw(view_app *app)
{
    const double begun = ibl_now();
    char title[200];

    app->redraw = false;
    view_gl_time_begin();
    if (!view_app_draw(app, true))
        return false;
    view_labels_draw(app);
    const double gpu_ms = view_gl_time_end();
    gl.Finish();
    app->frame_ms = 1e3 * (ibl_now() - begun);
    glfwSwapBuffers(app->window);
    if (app->options->stats && app->set) {
        view_stats_add(&app->stats, app->frame_ms, gpu_ms);
        if (ibl_now() - app->stats.begun >= 1)
            view_stats_print(&app->stats, app->renderer, &app->side[0]);
    }
    snprintf(title, sizeof title, "%s | %.1f ms",
             app->set ? app->set->baked.name : "iblview", app->frame_ms);
    ibl_one_line(title);
    glfwSetWindowTitle(app->window, title);
    return true;
}

static bool loop(view_app *app)
{
    if (!app->notice[0])
        view_app_notice(app, "? lists the keys, p shows the controls");
    app->redraw = true;
    for (;;) {
        if (!view_app_tend(app))
            return false;
        if ((app->redraw || goes_on(app)) && !draw(app))
            return false;
        if (app->redraw || goes_on(app))
            glfwPollEvents();
        else if (app->baker || app->notice[0])
            glfwWaitEventsTimeout(app->baker ? BAKING_S : NOTICE_S);
        else
            glfwWaitEvents();
        if (glfwWindowShouldClose(app->window) || app->quit)
            return true;
        if (app->wants_picture)
            view_still_write(app);
    }
}

bool view_window_run(ibl_ctx *ctx, const view_options *options)
{
    view_app app = {.ctx = ctx,
                    .options = options,
                    .side = {options->settings, options->other},
                    .labels = options->labels,
                    .mouse = {-1, -1},
                    .begun = ibl_now()};
    const char *why;
    const bool map = view_kind_of(options->request.path, &why) == VIEW_KIND_MAP;
    /* A map is baked while the window opens. */
    bool ok = view_options_may(options) &&
              (!map || view_app_open(&app, &options->request)) &&
              open_window(&app) && view_app_make(&app) &&
              view_ui_make(app.scale);

    if (ok)
        view_ui_attach(app.window);
    ok = ok && (map || view_app_open(&app, &options->request)) &&
         (!app.set || view_options_suit(options, app.set)) && loop(&app);
    view_ui_free();
    view_app_end(&app);
    view_set_free(&app.sets[0]);
    view_set_free(&app.sets[1]);
    glfwTerminate(); /* also destroys the window */
    return ok;
}
