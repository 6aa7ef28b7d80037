/* SPDX-License-Identifier: MIT */
#include "view/display.h"

#include <math.h>
#include <stdlib.h>

#include "view/message.h"
#include "view/program.h"

struct view_display {
    GLuint show, inspect; /* programs */
    GLuint nearest;       /* sampler */
};

view_display *view_display_create(void)
{
    view_display *d = calloc(1, sizeof *d);
    if (!d) {
        view_fail("no memory for the display pass");
        return NULL;
    }
    d->show = view_program("full.vert", "display.frag");
    d->inspect = view_program("full.vert", "inspect.frag");
    if (!d->show || !d->inspect)
        goto fail;
    gl.GenSamplers(1, &d->nearest);
    gl.SamplerParameteri(d->nearest, GL_TEXTURE_MIN_FILTER,
                         GL_NEAREST_MIPMAP_NEAREST);
    gl.SamplerParameteri(d->nearest, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    if (!view_gl_check("making the display pass"))
        goto fail;
    return d;

fail:
    view_display_free(d);
    return NULL;
}

void view_display_free(view_display *d)
{
    if (!d)
        return;
    gl.DeleteSamplers(1, &d->nearest);
    gl.DeleteProgram(d->inspect);
    gl.DeleteProgram(d->show);
    free(d);
}

void view_display_draw(view_display *d, GLuint picture, GLuint truth)
{
    view_gl_bind(VIEW_UNIT_PICTURE, GL_TEXTURE_2D, picture);
    view_gl_bind(VIEW_UNIT_TRUTH, GL_TEXTURE_2D, truth);
    view_gl_draw_full(d->show);
}

void view_display_inspect(view_display *d)
{
    gl.BindSampler(VIEW_UNIT_SPECULAR, d->nearest);
    gl.BindSampler(VIEW_UNIT_IRRADIANCE, d->nearest);
    view_gl_draw_full(d->inspect);
    gl.BindSampler(VIEW_UNIT_SPECULAR, 0);
    gl.BindSampler(VIEW_UNIT_IRRADIANCE, 0);
}

void view_false_colour(double stops, double srgb[3])
{
    const double at = fmin(fmax(stops + VIEW_STOPS, 0), 2 * VIEW_STOPS - 1e-9);
    const double share =
        (floor(at) + 0.5 * (at - floor(at))) / (2 * VIEW_STOPS);
    const double level = 0.1 + 0.8 * share;
    const double angle = 2 * M_PI * (0.5 / 3 + 1 - 1.5 * level);
    const double swing = level * (1 - level) / 2;
    const double c = swing * cos(angle), s = swing * sin(angle);

    srgb[0] = level - 0.14861 * c + 1.78277 * s;
    srgb[1] = level - 0.29227 * c - 0.90649 * s;
    srgb[2] = level + 1.97294 * c;
    for (int i = 0; i < 3; i++)
        srgb[i] = fmin(fmax(srgb[i], 0), 1);
}
