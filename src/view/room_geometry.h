/* SPDX-License-Identifier: MIT */
/* The room's boxes and spheres as triangles, for room_render.c. */
#ifndef VIEW_ROOM_GEOMETRY_H
#define VIEW_ROOM_GEOMETRY_H

#include "view/room.h"

typedef struct view_room_vertex {
    float position[3], normal[3];
    view_room_material material;
} view_room_vertex;

/* Of the indices. */
typedef struct view_room_range {
    int first, count;
} view_room_range;

/* Triangles, counter-clockwise seen from outside. Boxes are in their places;
 * spheres have radius 1 and their centre at 0. */
typedef struct view_room_mesh {
    view_room_vertex *vertices;
    GLuint *indices;
    int vertex_count, index_count;
    view_room_range sides; /* the boxes' sides whole */
    view_room_range cells; /* the same in cells, as a paraboloid bends them */
    view_room_range spheres[VIEW_ROOM_SPHERES];
} view_room_mesh;

/* False, with a message, and *mesh zeroed. */
bool view_room_mesh_make(view_room_mesh *mesh);
/* Frees the vertices and indices, and keeps the ranges. */
void view_room_mesh_free(view_room_mesh *mesh); /* zeroed is fine */

#endif
