/* SPDX-License-Identifier: MIT */
#include "box.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "view.h"
#include "view/program.h"

enum {
    SQUARES = 8,
    FINE = 4, /* a square is so many quads along an edge: paraboloids bend */
    FLOATS = 7
};

/* Lower and upper corners: the room, the block. */
static const double boxes[2][2][3] = {
    {{-2, -1, -3}, {2, 1.5, 3}},
    {{0.8, -1, 0.9}, {1.4, 0.2, 1.5}},
};

/* ---- colours ----------------------------------------------------------- */

/* Of the square (i, j) of a wall: i along the next axis, j the one after. */
static void square_colour(const box_scene *s, int which, int wall, int i, int j,
                          double rgba[4])
{
    static const double walls[6][3] = {{0.9, 0.1, 0.1}, {0.1, 0.8, 0.2},
                                       {0.7, 0.7, 0.9}, {0.3, 0.2, 0.1},
                                       {0.1, 0.2, 0.9}, {0.8, 0.7, 0.1}};
    const double shade = (i + j) & 1 ? 1 : 0.6;
    const bool panel = s->panel > 0 && !which && wall == 4 && i >= 4 && i < 6 &&
                       j >= 4 && j < 6;

    for (int k = 0; k < 3; k++) {
        rgba[k] = shade * walls[(wall + 3 * which) % 6][k];
        if (!i && !j)
            rgba[k] = 1.5 - walls[wall][k];
        if (panel)
            rgba[k] = s->panel;
    }
    rgba[3] = 1;
    if (s->open && !which && wall == 2)
        rgba[0] = rgba[1] = rgba[2] = rgba[3] = 0;
}

/* ---- rays -------------------------------------------------------------- */

/* The wall of a box that a ray meets, from inside or outside; -1: none. */
static int meet(int which, const double eye[3], const double dir[3], double *at)
{
    double enter = -1e30, leave = 1e30;
    int in = -1, out = -1;

    for (int k = 0; k < 3; k++) {
        const int up = dir[k] > 0;
        if (dir[k] == 0) {
            if (eye[k] < boxes[which][0][k] || eye[k] > boxes[which][1][k])
                return -1;
            continue;
        }
        const double a = (boxes[which][!up][k] - eye[k]) / dir[k];
        const double b = (boxes[which][up][k] - eye[k]) / dir[k];
        if (a > enter)
            enter = a, in = 2 * k + up;
        if (b < leave)
            leave = b, out = 2 * k + !up;
    }
    if (enter > leave || leave <= 0)
        return -1;
    *at = enter > 0 ? enter : leave;
    return enter > 0 ? in : out;
}

void box_trace(const box_scene *s, const double eye[3], const double dir[3],
               double rgba[4])
{
    double nearest = 1e30;

    memset(rgba, 0, 4 * sizeof *rgba);
    for (int which = 0; which < 2; which++) {
        double at = 0;
        const int wall = meet(which, eye, dir, &at);
        int square[2];
        if (wall < 0 || at >= nearest)
            continue;
        nearest = at;
        for (int k = 0; k < 2; k++) {
            const int axis = (wall / 2 + 1 + k) % 3;
            const double *lo = boxes[which][0], *hi = boxes[which][1];
            const double share =
                (eye[axis] + at * dir[axis] - lo[axis]) / (hi[axis] - lo[axis]);
            square[k] = (int)fmin(fmax(floor(share * SQUARES), 0), SQUARES - 1);
        }
        square_colour(s, which, wall, square[0], square[1], rgba);
    }
}

/* ---- triangles --------------------------------------------------------- */

static void add_vertex(float **to, int which, int wall, int i, int j,
                       const double rgba[4])
{
    const double *lo = boxes[which][0], *hi = boxes[which][1];
    const int axis = wall / 2, b = (axis + 1) % 3, c = (axis + 2) % 3;

    (*to)[axis] = (float)(wall & 1 ? lo[axis] : hi[axis]);
    (*to)[b] = (float)(lo[b] + (hi[b] - lo[b]) * i / (SQUARES * FINE));
    (*to)[c] = (float)(lo[c] + (hi[c] - lo[c]) * j / (SQUARES * FINE));
    for (int k = 0; k < 4; k++)
        (*to)[3 + k] = (float)rgba[k];
    *to += FLOATS;
}

static void add_wall(const box_scene *s, float **to, int which, int wall)
{
    static const int corner[6][2] = {{0, 0}, {1, 0}, {1, 1},
                                     {0, 0}, {1, 1}, {0, 1}};

    for (int j = 0; j < SQUARES * FINE; j++)
        for (int i = 0; i < SQUARES * FINE; i++) {
            double rgba[4];
            square_colour(s, which, wall, i / FINE, j / FINE, rgba);
            for (int v = 0; v < 6; v++)
                add_vertex(to, which, wall, i + corner[v][0], j + corner[v][1],
                           rgba);
        }
}

static const view_shader_file *shader_files(void)
{
    static view_shader_file files[] = {
        {"box.vert", "#include \"paraboloid.glsl\"\n"
                     "uniform int side;\n"
                     "layout(location = 0) in vec4 place;\n"
                     "layout(location = 1) in vec4 rgba;\n"
                     "out vec4 paint;\n"
                     "out float front;\n"
                     "void main() {\n"
                     "    gl_Position = side < 0 ? place :\n"
                     "                  paraboloid_position(place);\n"
                     "    front = side < 0 ? 1.0 : paraboloid_front(place);\n"
                     "    paint = rgba;\n"
                     "}\n"},
        {"box.frag", "#include \"paraboloid.glsl\"\n"
                     "in vec4 paint;\n"
                     "in float front;\n"
                     "out vec4 colour;\n"
                     "void main() {\n"
                     "    if (front < PARABOLOID_BACK) discard;\n"
                     "    colour = paint;\n"
                     "}\n"},
        {"paraboloid.glsl", NULL},
        {NULL, NULL},
    };

    files[2].text = view_test_shader("paraboloid.glsl");
    return files;
}

static void describe(const box_scene *s)
{
    const GLsizei stride = FLOATS * sizeof(float);

    gl.BindVertexArray(s->array);
    gl.BindBuffer(GL_ARRAY_BUFFER, s->buffer);
    gl.EnableVertexAttribArray(0);
    gl.EnableVertexAttribArray(1);
    gl.VertexAttribPointer(0, 4, GL_FLOAT, GL_FALSE, stride + 4, NULL);
    gl.VertexAttribPointer(1, 4, GL_FLOAT, GL_FALSE, stride + 4,
                           (const void *)(4 * sizeof(float)));
}

bool box_begin(box_scene *s)
{
    float *to;

    s->program = view_program_from(shader_files(), "box.vert", "box.frag");
    s->vertices = 2 * 6 * SQUARES * FINE * SQUARES * FINE * 6;
    s->mesh = malloc((size_t)s->vertices * FLOATS * sizeof *s->mesh);
    s->moved = malloc((size_t)s->vertices * (FLOATS + 1) * sizeof *s->moved);
    if (!s->program || !s->mesh || !s->moved)
        return false;
    to = s->mesh;
    for (int which = 1; which >= 0; which--)
        for (int wall = 0; wall < 6; wall++)
            if (which || wall != 2 || !s->open)
                add_wall(s, &to, which, wall);
    s->vertices = (int)((to - s->mesh) / FLOATS);
    gl.GenVertexArrays(1, &s->array);
    gl.GenBuffers(1, &s->buffer);
    describe(s);
    return true;
}

void box_end(box_scene *s)
{
    gl.DeleteBuffers(1, &s->buffer);
    gl.DeleteVertexArrays(1, &s->array);
    gl.DeleteProgram(s->program);
    free(s->moved);
    free(s->mesh);
}

/* Vertices are few enough to be moved here. */
void box_draw(void *cookie, const double clip[16], const double eye[3],
              int size, int side)
{
    box_scene *s = cookie;

    (void)eye, (void)size;
    s->calls++;
    for (int i = 0; i < s->vertices; i++) {
        const float *v = s->mesh + (size_t)FLOATS * i;
        float *to = s->moved + (size_t)(FLOATS + 1) * i;
        for (int r = 0; r < 4; r++)
            to[r] = (float)(clip[r] * v[0] + clip[4 + r] * v[1] +
                            clip[8 + r] * v[2] + clip[12 + r]);
        memcpy(to + 4, v + 3, 4 * sizeof *to);
    }
    gl.UseProgram(s->program);
    gl.Uniform1i(gl.GetUniformLocation(s->program, "side"), side);
    gl.BindVertexArray(s->array);
    gl.BindBuffer(GL_ARRAY_BUFFER, s->buffer);
    gl.BufferData(GL_ARRAY_BUFFER,
                  (GLsizeiptr)s->vertices * (FLOATS + 1) *
                      (GLsizeiptr)sizeof *s->moved,
                  s->moved, GL_STREAM_DRAW);
    gl.DrawArrays(GL_TRIANGLES, 0, s->vertices);
}
