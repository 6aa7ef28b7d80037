/* SPDX-License-Identifier: MIT */
#include "view/room_parts.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "common/signals.h"
#include "view/message.h"

/* A grid of vertices, stored row by row. */
typedef struct grid {
    int columns, rows; /* number of cells */
} grid;

/* Maximum edge of a box's cell, in units. */
static const double cell = 0.5;
static const grid around = {64, 32}; /* of a sphere, from pole to pole */

static int grid_vertices(grid g)
{
    return (g.columns + 1) * (g.rows + 1);
}

/* Adds the quads of a grid; each covers step_x x step_y cells. */
static void add_quads(view_room_mesh *mesh, grid g, int first, int step_x,
                      int step_y)
{
    const int row = g.columns + 1;

    for (int y = 0; y < g.rows; y += step_y)
        for (int x = 0; x < g.columns; x += step_x) {
            const GLuint a = (GLuint)(first + y * row + x);
            const GLuint b = a + (GLuint)step_x;
            const GLuint c = a + (GLuint)(step_y * row);
            const GLuint d = c + (GLuint)step_x;
            const GLuint corners[6] = {a, b, d, a, d, c};
            memcpy(mesh->indices + mesh->index_count, corners, sizeof corners);
            mesh->index_count += 6;
        }
}

/* ---- boxes ------------------------------------------------------------- */

/* A side of a box. Its normal is along axis; u x v is the normal. */
typedef struct side {
    const view_room_box *box;
    int axis, u, v;
    bool high;
    grid cells;
} side;

/* Number of sides of all boxes. */
static int side_count(void)
{
    return 6 * VIEW_ROOM_BOXES;
}

static side side_of(int i)
{
    const view_room_box *box = view_room_box_at(i / 6);
    side s = {.box = box, .axis = i % 6 / 2, .high = i % 2};

    s.u = (s.axis + (s.high ? 1 : 2)) % 3;
    s.v = (s.axis + (s.high ? 2 : 1)) % 3;
    s.cells.columns = (int)ceil((box->high[s.u] - box->low[s.u]) / cell);
    s.cells.rows = (int)ceil((box->high[s.v] - box->low[s.v]) / cell);
    return s;
}

static double between(const view_room_box *box, int axis, int i, int n)
{
    return i == n ? box->high[axis]
                  : box->low[axis] + (box->high[axis] - box->low[axis]) * i / n;
}

static void add_side_vertices(view_room_mesh *mesh, const side *s)
{
    const view_room_box *box = s->box;
    const grid g = s->cells;

    for (int i = 0; i < grid_vertices(g); i++) {
        const int x = i % (g.columns + 1), y = i / (g.columns + 1);
        view_room_vertex *to = &mesh->vertices[mesh->vertex_count++];
        to->position[s->axis] =
            (float)(s->high ? box->high : box->low)[s->axis];
        to->position[s->u] = (float)between(box, s->u, x, g.columns);
        to->position[s->v] = (float)between(box, s->v, y, g.rows);
        to->normal[s->axis] = s->high ? 1 : -1;
        to->material = box->material;
    }
}

static view_room_range add_sides(view_room_mesh *mesh, bool whole)
{
    const int before = mesh->index_count;
    int first = 0;

    for (int i = 0; i < side_count(); i++) {
        const grid g = side_of(i).cells;
        add_quads(mesh, g, first, whole ? g.columns : 1, whole ? g.rows : 1);
        first += grid_vertices(g);
    }
    return (view_room_range){before, mesh->index_count - before};
}

/* ---- spheres ----------------------------------------------------------- */

static view_room_range add_sphere(view_room_mesh *mesh, int i)
{
    const int before = mesh->index_count;

    add_quads(mesh, around, mesh->vertex_count, 1, 1);
    for (int k = 0; k < grid_vertices(around); k++) {
        const int x = k % (around.columns + 1), y = k / (around.columns + 1);
        const double theta = M_PI * y / around.rows;
        const double phi = 2 * M_PI * x / around.columns;
        view_room_vertex *to = &mesh->vertices[mesh->vertex_count++];
        to->position[0] = (float)(sin(theta) * sin(phi));
        to->position[1] = (float)-cos(theta);
        to->position[2] = (float)(sin(theta) * cos(phi));
        memcpy(to->normal, to->position, sizeof to->normal);
        to->material = *view_room_sphere_material(i);
    }
    return (view_room_range){before, mesh->index_count - before};
}

/* ---- the mesh ---------------------------------------------------------- */

static void allocate(view_room_mesh *mesh)
{
    int vertices = VIEW_ROOM_SPHERES * grid_vertices(around);
    int quads = VIEW_ROOM_SPHERES * around.columns * around.rows;

    for (int i = 0; i < side_count(); i++) {
        const grid g = side_of(i).cells;
        vertices += grid_vertices(g);
        quads += 1 + g.columns * g.rows;
    }
    mesh->vertices = ibl_need(calloc((size_t)vertices, sizeof *mesh->vertices));
    mesh->indices = ibl_need(calloc((size_t)quads, 6 * sizeof *mesh->indices));
}

void view_room_mesh_make(view_room_mesh *mesh)
{
    *mesh = (view_room_mesh){0};
    allocate(mesh);
    for (int i = 0; i < side_count(); i++) {
        const side s = side_of(i);
        add_side_vertices(mesh, &s);
    }
    mesh->sides = add_sides(mesh, true);
    mesh->cells = add_sides(mesh, false);
    for (int i = 0; i < VIEW_ROOM_SPHERES; i++)
        mesh->spheres[i] = add_sphere(mesh, i);
}

void view_room_mesh_free(view_room_mesh *mesh)
{
    free(mesh->indices);
    free(mesh->vertices);
    mesh->indices = NULL;
    mesh->vertices = NULL;
}
