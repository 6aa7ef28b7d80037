/* SPDX-License-Identifier: MIT */
/* Boxes and spheres of the room as triangles. */
#ifndef VIEW_ROOM_PARTS_H
#define VIEW_ROOM_PARTS_H

#include "view/room.h"

typedef struct view_room_vertex {
    float position[3], normal[3];
    view_room_material material;
} view_room_vertex;

/* A range of indices. */
typedef struct view_room_range {
    int first, count;
} view_room_range;

/* Triangles, counter-clockwise seen from outside. Boxes are at their places;
 * spheres have radius 1 and centre 0. */
typedef struct view_room_mesh {
    view_room_vertex *vertices;
    GLuint *indices;
    int vertex_count, index_count;
    view_room_range sides; /* whole sides of boxes */
    view_room_range cells; /* the same divided into cells, for paraboloids */
    view_room_range spheres[VIEW_ROOM_SPHERES];
} view_room_mesh;

void view_room_mesh_make(view_room_mesh *mesh);
/* Frees vertices and indices but keeps the ranges. */
void view_room_mesh_free(view_room_mesh *mesh); /* zeroed is fine */

#endif
