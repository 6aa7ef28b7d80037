/* SPDX-License-Identifier: MIT */
#include "view/scene_captures.h"

#include <math.h>
#include <stddef.h>
#include <stdint.h>

#include "view/program.h"

enum {
    EDGES = 12,
    PARTS = 64, /* lines of a circle */
    MOST = 2 * 3 * PARTS
};

const float view_volumes_influence[3] = {0, 0.7f, 0.7f};
const float view_volumes_proxy[3] = {0.7f, 0, 0.7f};

/* Wires are nearer to the eye by this part of their distance, more than the
 * error of 24-bit depth, so that wires on a wall are visible. */
static const double nearer = 1.0 / 256;

/* In clip space. */
typedef struct vertex {
    float position[4], colour[3];
} vertex;

static bool make(view_volumes *v)
{
    v->program = view_program("volume.vert", "volume.frag");
    gl.GenVertexArrays(1, &v->array);
    gl.BindVertexArray(v->array);
    v->buffer = view_gl_buffer(GL_ARRAY_BUFFER, MOST * sizeof(vertex), NULL);
    view_gl_attribute(0, 4, sizeof(vertex), 0, 0);
    view_gl_attribute(1, 3, sizeof(vertex), offsetof(vertex, colour), 0);
    if (v->program && view_gl_check("making the wires of probes"))
        return true;
    view_volumes_free(v);
    return false;
}

void view_volumes_free(view_volumes *v)
{
    gl.DeleteBuffers(1, &v->buffer);
    gl.DeleteVertexArrays(1, &v->array);
    gl.DeleteProgram(v->program);
    *v = (view_volumes){0};
}

/* ---- lines ------------------------------------------------------------- */

/* End 0 or 1 of an edge, which runs along one axis at one of four places. */
static void box_point(int edge, int end, double p[3])
{
    const int axis = edge / 4;

    p[axis] = end ? 1 : -1;
    p[(axis + 1) % 3] = edge & 1 ? 1 : -1;
    p[(axis + 2) % 3] = edge & 2 ? 1 : -1;
}

/* The same for a part of three circles of radius 1. */
static void sphere_point(int part, int end, double p[3])
{
    const int axis = part / PARTS;
    const double turn = 2 * M_PI * (part + end) / PARTS;

    p[axis] = 0;
    p[(axis + 1) % 3] = cos(turn);
    p[(axis + 2) % 3] = sin(turn);
}

/* From -1..1 in a volume to clip space. */
static void project(const view_room_draw *d, const ibl_volume *volume,
                    const double p[3], float clip[4])
{
    double at[4] = {0, 0, 0, 1};

    for (int k = 0; k < 3; k++) {
        const double half =
            volume->half[volume->shape == IBL_SHAPE_SPHERE ? 0 : k];
        const double world = volume->centre[k] + half * p[k];
        at[k] = d->eye[k] + (1 - nearer) * (world - d->eye[k]);
    }
    for (int i = 0; i < 4; i++) {
        double sum = 0;
        for (int k = 0; k < 4; k++)
            sum += d->clip[4 * k + i] * at[k];
        clip[i] = (float)sum;
    }
}

static void upload(const view_room_draw *d, double ev, const ibl_volume *volume,
                   const float colour[3], int count)
{
    const float scale = (float)exp2(-ev);
    vertex vertices[MOST];

    for (int i = 0; i < count; i++) {
        double p[3];
        if (volume->shape == IBL_SHAPE_SPHERE)
            sphere_point(i / 2, i % 2, p);
        else
            box_point(i / 2, i % 2, p);
        project(d, volume, p, vertices[i].position);
        for (int k = 0; k < 3; k++)
            vertices[i].colour[k] = scale * colour[k];
    }
    gl.BufferData(GL_ARRAY_BUFFER,
                  (GLsizeiptr)((size_t)count * sizeof *vertices), vertices,
                  GL_STREAM_DRAW);
}

bool view_volumes_render(view_volumes *v, const view_room_draw *d, double ev,
                         const ibl_volume *volume, const float colour[3])
{
    const int count = volume->shape == IBL_SHAPE_SPHERE ? MOST : 2 * EDGES;

    if (!v->program && !make(v))
        return false;
    gl.Disable(GL_BLEND);
    gl.Enable(GL_DEPTH_TEST);
    gl.DepthFunc(GL_LEQUAL);
    gl.DepthMask(GL_FALSE);
    gl.UseProgram(v->program);
    gl.BindVertexArray(v->array);
    gl.BindBuffer(GL_ARRAY_BUFFER, v->buffer);
    upload(d, ev, volume, colour, count);
    gl.DrawArrays(GL_LINES, 0, count);
    gl.DepthMask(GL_TRUE);
    gl.DepthFunc(GL_LESS);
    gl.Disable(GL_DEPTH_TEST);
    return true;
}
