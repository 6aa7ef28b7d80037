/* SPDX-License-Identifier: MIT */
#include "view/room_geometry.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "view/message.h"

/* Edge of a cell, at most; and cells around a sphere and from pole to pole. */
static const double cell = 0.5;
enum {
    AROUND = 64,
    DOWN = 32
};

static bool make_room(view_room_mesh *mesh, int vertices, int indices)
{
    mesh->vertices = calloc((size_t)vertices, sizeof *mesh->vertices);
    mesh->indices = calloc((size_t)indices, sizeof *mesh->indices);
    if (mesh->vertices && mesh->indices)
        return true;
    view_room_mesh_free(mesh);
    return view_fail("no memory for the room");
}

void view_room_mesh_free(view_room_mesh *mesh)
{
    free(mesh->indices);
    free(mesh->vertices);
    *mesh = (view_room_mesh){0};
}

/* Corners a b in the first row, c d in the next. */
static void add_quad(view_room_mesh *mesh, GLuint a, GLuint b, GLuint c,
                     GLuint d)
{
    const GLuint corners[6] = {a, b, d, a, d, c};

    memcpy(mesh->indices + mesh->index_count, corners, sizeof corners);
    mesh->index_count += 6;
}

/* ---- boxes ------------------------------------------------------------- */

/* A side: its normal is along axis, and u x v is that normal. */
typedef struct side {
    int axis, u, v;
    bool high;
    int columns, rows; /* cells */
} side;

static side side_of(const view_room_box *box, int i)
{
    side s = {.axis = i / 2, .high = i % 2};

    s.u = (s.axis + (s.high ? 1 : 2)) % 3;
    s.v = (s.axis + (s.high ? 2 : 1)) % 3;
    s.columns = (int)ceil((box->high[s.u] - box->low[s.u]) / cell);
    s.rows = (int)ceil((box->high[s.v] - box->low[s.v]) / cell);
    return s;
}

static int side_vertices(const side *s)
{
    return (s->columns + 1) * (s->rows + 1);
}

static double between(const view_room_box *box, int axis, int i, int n)
{
    return i == n ? box->high[axis]
                  : box->low[axis] + (box->high[axis] - box->low[axis]) * i / n;
}

static void add_side_vertices(view_room_mesh *mesh, const view_room_box *box,
                              const side *s)
{
    for (int y = 0; y <= s->rows; y++)
        for (int x = 0; x <= s->columns; x++) {
            view_room_vertex *to = &mesh->vertices[mesh->vertex_count++];
            to->position[s->axis] =
                (float)(s->high ? box->high : box->low)[s->axis];
            to->position[s->u] = (float)between(box, s->u, x, s->columns);
            to->position[s->v] = (float)between(box, s->v, y, s->rows);
            to->normal[s->axis] = s->high ? 1 : -1;
            to->material = box->material;
        }
}

/* In cells of so many steps. */
static void add_side_quads(view_room_mesh *mesh, const side *s, GLuint first,
                           int step_x, int step_y)
{
    const GLuint row = (GLuint)s->columns + 1;

    for (int y = 0; y < s->rows; y += step_y)
        for (int x = 0; x < s->columns; x += step_x) {
            const GLuint a = first + (GLuint)y * row + (GLuint)x;
            const GLuint c = a + (GLuint)step_y * row;
            add_quad(mesh, a, a + (GLuint)step_x, c, c + (GLuint)step_x);
        }
}

bool view_room_mesh_boxes(view_room_mesh *mesh)
{
    int vertices = 0, cells = 0;
    const int sides = 6 * view_room_boxes();

    *mesh = (view_room_mesh){0};
    for (int i = 0; i < sides; i++) {
        const side s = side_of(view_room_box_at(i / 6), i % 6);
        vertices += side_vertices(&s);
        cells += s.columns * s.rows;
    }
    if (!make_room(mesh, vertices, 6 * (sides + cells)))
        return false;
    for (int fine = 0; fine < 2; fine++) {
        GLuint first = 0;
        for (int i = 0; i < sides; i++) {
            const view_room_box *box = view_room_box_at(i / 6);
            const side s = side_of(box, i % 6);
            if (!fine)
                add_side_vertices(mesh, box, &s);
            add_side_quads(mesh, &s, first, fine ? 1 : s.columns,
                           fine ? 1 : s.rows);
            first += (GLuint)side_vertices(&s);
        }
        if (!fine)
            mesh->coarse = mesh->index_count;
    }
    return true;
}

/* ---- a sphere ---------------------------------------------------------- */

bool view_room_mesh_sphere(view_room_mesh *mesh)
{
    *mesh = (view_room_mesh){0};
    if (!make_room(mesh, (AROUND + 1) * (DOWN + 1), 6 * AROUND * DOWN))
        return false;
    for (int y = 0; y <= DOWN; y++)
        for (int x = 0; x <= AROUND; x++) {
            view_room_vertex *to = &mesh->vertices[mesh->vertex_count++];
            const double theta = M_PI * y / DOWN, phi = 2 * M_PI * x / AROUND;
            to->position[0] = (float)(sin(theta) * sin(phi));
            to->position[1] = (float)-cos(theta);
            to->position[2] = (float)(sin(theta) * cos(phi));
            memcpy(to->normal, to->position, sizeof to->normal);
        }
    for (GLuint y = 0; y < DOWN; y++)
        for (GLuint x = 0; x < AROUND; x++) {
            const GLuint a = y * (AROUND + 1) + x, c = a + AROUND + 1;
            add_quad(mesh, a, a + 1, c, c + 1);
        }
    mesh->coarse = mesh->index_count;
    return true;
}
