/* SPDX-License-Identifier: MIT */
/* Parts of room_render.c: boxes and spheres as triangles, probes. */
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

/* False, with a message; *mesh is then zeroed. */
bool view_room_mesh_make(view_room_mesh *mesh);
/* Frees vertices and indices but keeps the ranges. */
void view_room_mesh_free(view_room_mesh *mesh); /* zeroed is fine */

/* ---- probes of a draw (room_probes.c) ---------------------------------- */

typedef struct view_room_probes {
    GLuint program;
    GLuint buffer, texels; /* packed probes, and their buffer texture */
    GLuint none;           /* array of one black cube */
    GLuint masks, framebuffer;
    int columns, rows; /* size of masks */
} view_room_probes;

/* The last members of the uniform block "Room", std140. */
typedef struct view_room_probe_block {
    int picture_size[4]; /* width, height, tile edge or 0: no masks, locals */
    int order[4];        /* locals before the dynamic one, rows of tiles */
    float local_lod[4], dynamic_lod[4]; /* as view_frame.lod */
    float scales[4]; /* irradiance: locals, dynamic one; then 1 with dynamic */
} view_room_probe_block;

/* *p must be zeroed. False, with a message. */
bool view_room_probes_make(view_room_probes *p);
void view_room_probes_free(view_room_probes *p); /* zeroed is fine */

void view_room_probes_block(view_room_probe_block *b, const view_room_draw *d,
                            const GLint size[2]);
/* Binds everything that the shaders read. Renders masks if the draw uses them,
 * which changes framebuffer and viewport. The blocks must be uploaded; depth
 * test, culling and blending must be off. */
void view_room_probes_use(view_room_probes *p, const view_room_draw *d,
                          const GLint size[2]);

#endif
