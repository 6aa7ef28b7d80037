/* SPDX-License-Identifier: MIT */
/* The room's boxes and spheres as triangles, for room_render.c. */
#ifndef VIEW_ROOM_GEOMETRY_H
#define VIEW_ROOM_GEOMETRY_H

#include "view/room.h"

typedef struct view_room_vertex {
    float position[3], normal[3];
    view_room_material material;
} view_room_vertex;

/* Triangles, counter-clockwise seen from outside. */
typedef struct view_room_mesh {
    view_room_vertex *vertices;
    GLuint *indices;
    int vertex_count, index_count;
    int coarse; /* of the indices, the first: the boxes' sides whole; after
                   them the same sides in cells, as a paraboloid bends them */
} view_room_mesh;

/* Boxes in their places; a sphere of radius 1 about 0 without material, coarse
 * = index_count. False, with a message, and *mesh zeroed. */
bool view_room_mesh_boxes(view_room_mesh *mesh);
bool view_room_mesh_sphere(view_room_mesh *mesh);
void view_room_mesh_free(view_room_mesh *mesh); /* zeroed is fine */

#endif
