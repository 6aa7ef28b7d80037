/* SPDX-License-Identifier: MIT */
/* A window by GLFW, whose error texts become part of our messages. */
#include "view/gl.h"
#include "view/message.h"
#include "view/screen.h"

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <dlfcn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct window_screen {
    view_screen base;
    GLFWwindow *window;
    const view_events *events;
    double x, y;     /* where the pointer was told to be */
    char title[512]; /* as it is: setting it is a message to the display */
} window_screen;

static char reason[512];

static void keep_reason(int code, const char *text)
{
    (void)code;
    snprintf(reason, sizeof reason, "%s", text);
}

/* ---- events ---------------------------------------------------------- */

static window_screen *screen_of(GLFWwindow *window)
{
    return glfwGetWindowUserPointer(window);
}

static void on_character(GLFWwindow *window, unsigned int code)
{
    const view_events *e = screen_of(window)->events;
    const bool shift = glfwGetKey(window, GLFW_KEY_LEFT_SHIFT) == GLFW_PRESS ||
                       glfwGetKey(window, GLFW_KEY_RIGHT_SHIFT) == GLFW_PRESS;

    if (e->key)
        e->key(e->cookie, (int)code, shift);
}

/* Characters come by on_character, as the keyboard's layout has them. */
static void on_key(GLFWwindow *window, int key, int scancode, int action,
                   int mods)
{
    static const struct {
        int glfw, key;
    } keys[] = {
        {GLFW_KEY_ESCAPE, VIEW_KEY_ESCAPE},
        {GLFW_KEY_LEFT, VIEW_KEY_LEFT},
        {GLFW_KEY_RIGHT, VIEW_KEY_RIGHT},
        {GLFW_KEY_UP, VIEW_KEY_UP},
        {GLFW_KEY_DOWN, VIEW_KEY_DOWN},
        {GLFW_KEY_PAGE_UP, VIEW_KEY_PAGE_UP},
        {GLFW_KEY_PAGE_DOWN, VIEW_KEY_PAGE_DOWN},
        {GLFW_KEY_HOME, VIEW_KEY_HOME},
        {GLFW_KEY_END, VIEW_KEY_END},
        {GLFW_KEY_TAB, VIEW_KEY_TAB},
        {GLFW_KEY_ENTER, VIEW_KEY_ENTER},
        {GLFW_KEY_KP_ENTER, VIEW_KEY_ENTER},
        {GLFW_KEY_BACKSPACE, VIEW_KEY_BACKSPACE},
    };
    const view_events *e = screen_of(window)->events;

    (void)scancode;
    if (action == GLFW_RELEASE || !e->key)
        return;
    for (size_t i = 0; i < sizeof keys / sizeof keys[0]; i++)
        if (keys[i].glfw == key)
            e->key(e->cookie, keys[i].key, mods & GLFW_MOD_SHIFT);
}

/* Positions come in screen coordinates. */
static void tell_mouse(GLFWwindow *window, int button, bool down)
{
    const window_screen *s = screen_of(window);
    const view_events *e = s->events;
    int width, height, width_px, height_px;

    glfwGetWindowSize(window, &width, &height);
    glfwGetFramebufferSize(window, &width_px, &height_px);
    if (e->mouse && width > 0 && height > 0)
        e->mouse(e->cookie, s->x * width_px / width, s->y * height_px / height,
                 button, down);
}

static void on_move(GLFWwindow *window, double x, double y)
{
    window_screen *s = screen_of(window);
    s->x = x, s->y = y;
    tell_mouse(window, -1, false);
}

/* The place at that event: glfwGetCursorPos is ahead of events still to
 * come. */
static void on_button(GLFWwindow *window, int button, int action, int mods)
{
    (void)mods;
    if (button <= GLFW_MOUSE_BUTTON_MIDDLE)
        tell_mouse(window, button, action == GLFW_PRESS);
}

/* While a button is held the window hears of the pointer out there as well. */
static void on_enter(GLFWwindow *window, int entered)
{
    const view_events *e = screen_of(window)->events;
    bool held = false;

    for (int button = 0; button <= GLFW_MOUSE_BUTTON_MIDDLE; button++)
        held |= glfwGetMouseButton(window, button) == GLFW_PRESS;
    if (!entered && !held && e->mouse)
        e->mouse(e->cookie, -1, -1, -1, false);
}

static void on_wheel(GLFWwindow *window, double x, double y)
{
    const view_events *e = screen_of(window)->events;
    (void)x;
    if (e->wheel)
        e->wheel(e->cookie, y);
}

static void on_drop(GLFWwindow *window, int count, const char **paths)
{
    const view_events *e = screen_of(window)->events;
    for (int i = 0; i < count && e->drop; i++)
        e->drop(e->cookie, paths[i]);
}

static void on_refresh(GLFWwindow *window)
{
    const view_events *e = screen_of(window)->events;
    if (e->refresh)
        e->refresh(e->cookie);
}

static void on_size(GLFWwindow *window, int width, int height)
{
    (void)width, (void)height;
    on_refresh(window);
}

static void listen(GLFWwindow *window)
{
    glfwSetCharCallback(window, on_character);
    glfwSetKeyCallback(window, on_key);
    glfwSetCursorPosCallback(window, on_move);
    glfwSetMouseButtonCallback(window, on_button);
    glfwSetCursorEnterCallback(window, on_enter);
    glfwSetScrollCallback(window, on_wheel);
    glfwSetDropCallback(window, on_drop);
    glfwSetWindowRefreshCallback(window, on_refresh);
    glfwSetFramebufferSizeCallback(window, on_size);
}

/* ---- errors of the X11 display ---------------------------------------- */

/* From X11/Xlib.h, which need not be there to build with GLFW. */
typedef struct x_error {
    int type;
    void *display;
    unsigned long resource, serial;
    unsigned char code, request, minor;
} x_error;
typedef int x_handler(void *display, x_error *error);
enum {
    BAD_WINDOW = 3
};

static x_handler *other_errors;

static int on_error(void *display, x_error *error)
{
    return error->code == BAD_WINDOW ? 0 : other_errors(display, error);
}

/* GLFW answers the window that something is dragged from. If it is gone, Xlib
 * would end this program. */
static void survive_others_windows(void)
{
    x_handler *(*set)(x_handler *);
    void *library = dlopen("libX11.so.6", RTLD_LAZY | RTLD_LOCAL);
    void *symbol = library ? dlsym(library, "XSetErrorHandler") : NULL;

    memcpy(&set, &symbol, sizeof set);
    if (set)
        other_errors = set(on_error);
}

/* ---- the screen ------------------------------------------------------ */

static void close_window(view_screen *screen)
{
    window_screen *s = (window_screen *)screen;

    if (s->window)
        glfwDestroyWindow(s->window);
    glfwTerminate();
    free(s);
}

/* A window that is minimized may have no pixels: told as one. */
static void size_window(const view_screen *screen, int *width, int *height)
{
    const window_screen *s = (const window_screen *)screen;

    glfwGetFramebufferSize(s->window, width, height);
    if (*width < 1)
        *width = 1;
    if (*height < 1)
        *height = 1;
}

static double scale_window(const view_screen *screen)
{
    const window_screen *s = (const window_screen *)screen;
    float x = 1, y = 1;

    glfwGetWindowContentScale(s->window, &x, &y);
    return (double)(y > 1 ? y : 1);
}

static void show_window(view_screen *screen)
{
    glfwSwapBuffers(((window_screen *)screen)->window);
}

static bool poll_window(view_screen *screen, double wait)
{
    window_screen *s = (window_screen *)screen;

    if (wait > 0)
        glfwWaitEventsTimeout(wait);
    else
        glfwPollEvents();
    return !glfwWindowShouldClose(s->window);
}

static void title_window(view_screen *screen, const char *title)
{
    window_screen *s = (window_screen *)screen;

    if (!strncmp(s->title, title, sizeof s->title - 1))
        return;
    snprintf(s->title, sizeof s->title, "%s", title);
    glfwSetWindowTitle(s->window, s->title);
}

static const view_screen_kind window_kind = {
    .close = close_window,
    .size = size_window,
    .scale = scale_window,
    .show = show_window,
    .poll = poll_window,
    .title = title_window,
};

/* No depth, no samples: what is drawn here is a picture that is ready. */
static GLFWwindow *create(int width, int height, const char *title)
{
    glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 3);
    glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 3);
    glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
    glfwWindowHint(GLFW_OPENGL_FORWARD_COMPAT, GLFW_TRUE);
    glfwWindowHint(GLFW_DEPTH_BITS, 0);
    glfwWindowHint(GLFW_STENCIL_BITS, 0);
    glfwWindowHint(GLFW_SCALE_TO_MONITOR, GLFW_TRUE);
    /* What a desktop knows the program's windows by. */
    glfwWindowHintString(GLFW_X11_CLASS_NAME, "iblview");
    glfwWindowHintString(GLFW_X11_INSTANCE_NAME, "iblview");
    return glfwCreateWindow(width, height, title, NULL, NULL);
}

view_screen *view_screen_window(int width, int height, const char *title,
                                const view_events *events)
{
    static const char advice[] =
        "--offscreen OUT.png makes pictures without one";
    window_screen *s = calloc(1, sizeof *s);

    if (!s) {
        view_fail("no memory for a window");
        return NULL;
    }
    s->base.kind = &window_kind;
    s->events = events;
    glfwSetErrorCallback(keep_reason);
    if (!glfwInit()) {
        view_fail("no window: %s; %s", reason, advice);
        free(s);
        return NULL;
    }
    snprintf(s->title, sizeof s->title, "%s", title);
    s->window = create(width, height, s->title);
    if (!s->window) {
        view_fail("no window with OpenGL 3.3 core: %s; %s", reason, advice);
        goto fail;
    }
    glfwSetWindowUserPointer(s->window, s);
    glfwGetCursorPos(s->window, &s->x, &s->y);
    glfwMakeContextCurrent(s->window);
    if (!view_gl_load(glfwGetProcAddress))
        goto fail;
    glfwSwapInterval(1);
    survive_others_windows(); /* of GLFW's own it has taken care by now */
    listen(s->window);
    view_screen_describe(&s->base);
    return &s->base;
fail:
    close_window(&s->base);
    return NULL;
}
