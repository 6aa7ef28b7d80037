/* SPDX-License-Identifier: MIT */
#include "view/overlay.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <stb/stb_easy_font.h>

#include "common/signals.h"
#include "view/message.h"
#include "view/program.h"

enum {
    BATCH = 4096, /* most rectangles of one draw call */
    GLYPH = 16,   /* most quads of a character; X has 11 */
    LINE = VIEW_TEXT_LINE,
    TAB = VIEW_TEXT_TAB,
    MARGIN = VIEW_TEXT_MARGIN
};

/* Attributes of text.vert. */
typedef struct rectangle {
    float left, top, right, bottom;
    float tint[4];
} rectangle;

struct view_overlay {
    GLuint program, buffer, array;
    GLint window;
    rectangle batch[BATCH]; /* rectangles not drawn yet */
    int count;
};

static const float text_background[4] = {0, 0, 0, 0.65f};
static const float ink[4] = {1, 1, 1, 1};
static const float trough[4] = {1, 1, 1, 0.25f};
/* As text.frag has them. */
static const float false_colours[4] = {0, 0, 0, 2}, greys[4] = {0, 0, 0, 3};

static bool make(view_overlay *o)
{
    o->program = view_program("text.vert", "text.frag");
    if (!o->program)
        return false;
    o->window = gl.GetUniformLocation(o->program, "window");
    gl.GenVertexArrays(1, &o->array);
    gl.BindVertexArray(o->array);
    o->buffer = view_gl_buffer(GL_ARRAY_BUFFER, sizeof o->batch, NULL);
    for (GLuint i = 0; i < 2; i++)
        view_gl_attribute(i, 4, sizeof(rectangle), 4 * i * sizeof(float), 1);
    gl.BindVertexArray(0);
    return view_gl_check("making the text pass");
}

view_overlay *view_overlay_create(void)
{
    view_overlay *o = ibl_need(calloc(1, sizeof *o));

    if (make(o))
        return o;
    view_overlay_free(o);
    return NULL;
}

void view_overlay_free(view_overlay *o)
{
    free(o);
}

void view_overlay_begin(view_overlay *o, int width, int height)
{
    gl.UseProgram(o->program);
    gl.Uniform2f(o->window, (float)width, (float)height);
    gl.BindVertexArray(o->array);
    gl.BindBuffer(GL_ARRAY_BUFFER, o->buffer);
    gl.Enable(GL_BLEND);
}

static void draw_batch(view_overlay *o)
{
    gl.BufferSubData(GL_ARRAY_BUFFER, 0,
                     (GLsizeiptr)o->count * (GLsizeiptr)sizeof *o->batch,
                     o->batch);
    gl.DrawArraysInstanced(GL_TRIANGLE_STRIP, 0, 4, o->count);
    o->count = 0;
}

void view_overlay_end(view_overlay *o)
{
    draw_batch(o);
    gl.Disable(GL_BLEND);
}

static void add(view_overlay *o, double left, double top, double right,
                double bottom, const float tint[4])
{
    if (o->count == BATCH)
        draw_batch(o);
    o->batch[o->count++] = (rectangle){(float)left,
                                       (float)top,
                                       (float)right,
                                       (float)bottom,
                                       {tint[0], tint[1], tint[2], tint[3]}};
}

/* Replaces characters that the font lacks: it would read outside its tables. */
static char printable(char c)
{
    return c >= ' ' && c <= '~' ? c : '?';
}

/* Handles \n and \t: moves the pen, in font units. False: another character. */
static bool control(char c, double *x, double *y)
{
    if (c == '\n')
        *x = 0, *y += LINE;
    else if (c == '\t')
        *x = TAB * (floor(*x / TAB) + 1);
    else
        return false;
    return true;
}

void view_overlay_measure(const char *text, double scale, double *width,
                          double *height)
{
    double x = 0, y = 0, widest = 0;
    const size_t length = strlen(text);

    for (const char *c = text; *c; c++) {
        if (!control(*c, &x, &y))
            x += stb_easy_font_width((char[2]){printable(*c), 0});
        widest = fmax(widest, x);
    }
    if (length && text[length - 1] != '\n')
        y += LINE;
    *width = length ? (widest + 2 * MARGIN) * scale : 0;
    *height = length ? (y + 2 * MARGIN) * scale : 0;
}

/* A corner of the font's quads, each of four. */
typedef struct corner {
    float x, y, z;
    unsigned char colour[4];
} corner;

/* Draws letters without background; left, top is their upper left corner. */
static void write_text(view_overlay *o, double left, double top, double scale,
                       const char *text)
{
    corner quads[GLYPH][4];
    double x = 0, y = 0;

    for (const char *c = text; *c; c++) {
        if (control(*c, &x, &y))
            continue;
        char one[2] = {printable(*c), 0};
        const int n = stb_easy_font_print(0, 0, one, NULL, quads, sizeof quads);
        for (int i = 0; i < n; i++)
            add(o, left + (x + quads[i][0].x) * scale,
                top + (y + quads[i][0].y) * scale,
                left + (x + quads[i][2].x) * scale,
                top + (y + quads[i][2].y) * scale, ink);
        x += stb_easy_font_width(one);
    }
}

void view_overlay_text(view_overlay *o, double x, double y, double scale,
                       const char *text)
{
    double width, height;

    view_overlay_measure(text, scale, &width, &height);
    if (width <= 0)
        return;
    /* Whole pixels keep strokes sharp if scale is whole, too. */
    x = floor(x + 0.5);
    y = floor(y + 0.5);
    add(o, x, y, x + width, y + height, text_background);
    write_text(o, x + MARGIN * scale, y + MARGIN * scale, scale, text);
}

void view_overlay_bar(view_overlay *o, double x, double y, double width,
                      double height, double share)
{
    const double end = x + width * fmin(fmax(share, 0), 1);

    add(o, x, y, x + width, y + height, text_background);
    add(o, x, y, x + width, y + height, trough);
    if (share > 0)
        add(o, x, y, end, y + height, ink);
}

/* Draws text centred at x, moved to stay within left .. right. */
static void write_below(view_overlay *o, double x, double y, double left,
                        double right, double scale, const char *text)
{
    double width, height;

    view_overlay_measure(text, scale, &width, &height);
    width -= 2 * MARGIN * scale;
    write_text(o, floor(fmin(fmax(x - width / 2, left), right - width) + 0.5),
               y, scale, text);
}

void view_overlay_legend(view_overlay *o, double x, double y, double width,
                         double scale, double most)
{
    const double left = x + MARGIN * scale, right = x + width - MARGIN * scale;
    const double top = y + MARGIN * scale, below = top + LINE * scale;
    const double bottom = below - 2 * scale;

    add(o, x, y, x + width, below + (LINE + MARGIN) * scale, text_background);
    add(o, left, top, right, bottom, most > 0 ? greys : false_colours);
    for (int i = 0; i <= 4; i++) {
        const int stop = 4 * i - VIEW_STOPS;
        char text[16];
        if (most > 0)
            snprintf(text, sizeof text, "%.3g", most * i / 4);
        else
            snprintf(text, sizeof text, stop ? "%+d" : "%d EV", stop);
        write_below(o, left + (right - left) * i / 4, below, left, right, scale,
                    text);
    }
}
