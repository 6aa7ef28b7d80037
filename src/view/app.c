/* SPDX-License-Identifier: MIT */
#include "view/app.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

#include "common/stderr_line.h"
#include "view/clock.h"
#include "view/gl.h"
#include "view/picture.h"

void view_app_notice(view_app *app, const char *fmt, ...)
{
    va_list ap;

    va_start(ap, fmt);
    vsnprintf(app->notice, sizeof app->notice, fmt, ap);
    va_end(ap);
    ibl_one_line(app->notice);
    app->redraw = true;
}

void view_app_reset(view_app *app)
{
    app->settings = app->options->settings;
    if (app->set && app->settings.level >= app->set->texture[0].levels)
        app->settings.level = app->set->texture[0].levels - 1;
    app->redraw = true;
}

/* ---- frames -------------------------------------------------------------- */

static bool draw_as_set(view_app *app, bool spread, int width, int height)
{
    view_settings now = app->settings;

    now.spread = spread;
    now.seconds += view_clock() - app->begun;
    return view_renderer_draw(app->renderer, &now, width, height);
}

/* What has just been asked for may need more memory than there is. */
static bool go_back(view_app *app)
{
    if (!app->drew)
        return false;
    app->drew = false;
    app->settings = app->drawn;
    view_app_notice(app, "as it was before: the terminal says why");
    return true;
}

bool view_app_draw(view_app *app, bool spread, int width, int height)
{
    if (!app->set) {
        gl.BindFramebuffer(GL_FRAMEBUFFER, 0);
        gl.Viewport(0, 0, width, height);
        gl.ClearColor(0, 0, 0, 1);
        gl.Clear(GL_COLOR_BUFFER_BIT);
        return true;
    }
    if (!draw_as_set(app, spread, width, height) &&
        !(go_back(app) && draw_as_set(app, spread, width, height)))
        return false;
    app->drawn = app->settings;
    app->drew = true;
    return true;
}

/* A name that no file has yet. */
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
    int width, height;
    unsigned char *rgb = NULL;

    if (!free_name(path, sizeof path)) {
        view_app_notice(app, "no picture is written: up to %s all are there",
                        path);
        return;
    }
    view_screen_size(app->screen, &width, &height);
    if (view_app_draw(app, false, width, height))
        rgb = view_renderer_picture(app->renderer);
    if (rgb && view_picture_write(app->ctx, path, width, height, rgb))
        view_app_notice(app, "%s is written", path);
    else
        view_app_notice(app, "%s is not written: the terminal says why", path);
    free(rgb);
}
