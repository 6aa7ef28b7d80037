/* SPDX-License-Identifier: MIT */
#include "view/screen.h"

#include <stdio.h>

#include "view/gl.h"

void view_screen_describe(view_screen *screen)
{
    snprintf(screen->about, sizeof screen->about, "OpenGL %s, %s",
             (const char *)gl.GetString(GL_VERSION),
             (const char *)gl.GetString(GL_RENDERER));
}

void view_screen_close(view_screen *screen)
{
    if (screen)
        screen->kind->close(screen);
}

void view_screen_size(const view_screen *screen, int *width, int *height)
{
    screen->kind->size(screen, width, height);
}

double view_screen_scale(const view_screen *screen)
{
    return screen->kind->scale ? screen->kind->scale(screen) : 1;
}

void view_screen_show(view_screen *screen)
{
    screen->kind->show(screen);
}

bool view_screen_poll(view_screen *screen, double wait)
{
    return !screen->kind->poll || screen->kind->poll(screen, wait);
}

void view_screen_title(view_screen *screen, const char *title)
{
    if (screen->kind->title)
        screen->kind->title(screen, title);
}

const char *view_screen_about(const view_screen *screen)
{
    return screen->about;
}
