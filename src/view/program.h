/* SPDX-License-Identifier: MIT */
/* Shaders: the build puts src/view/shaders into the program
 * (build/gen/shaders.c). Lines `#include "name.glsl"` put files, each once,
 * before the one that has them. Each shader begins with `#version 330 core`.
 * Messages have the line in the file that it is from. */
#ifndef VIEW_PROGRAM_H
#define VIEW_PROGRAM_H

#include "view/gl.h"

enum {
    VIEW_SHADER_PARTS = 16
};

/* The table that the build makes, ended by a NULL name. A file's text is what
 * it includes, in order, then its own, ended by NULL. */
typedef struct view_shader_file {
    const char *name, *text[VIEW_SHADER_PARTS];
} view_shader_file;
extern const view_shader_file view_shader_files[];

/* Compiles and links, and binds uniform blocks and samplers by name to the
 * places below. 0, with the compiler's first line as the message, after an
 * error. */
GLuint view_program(const char *vertex_file, const char *fragment_file);
/* The same from another table, with lines "#define NAME VALUE"
 * before both shaders. */
GLuint view_program_from(const view_shader_file *files, const char *defines,
                         const char *vertex_file, const char *fragment_file);

/* Bindings of uniform blocks: "Frame", "Room", "Material". */
enum {
    VIEW_BLOCK_FRAME,
    VIEW_BLOCK_ROOM,
    VIEW_BLOCK_MATERIAL
};

/* Texture units, and the names of their samplers. */
typedef enum view_unit {
    VIEW_UNIT_SPECULAR,    /* samplerCube specular_map */
    VIEW_UNIT_IRRADIANCE,  /* samplerCube irradiance_map */
    VIEW_UNIT_LUT,         /* sampler2D lut_map */
    VIEW_UNIT_SKY,         /* samplerCube sky_map */
    VIEW_UNIT_LOBES,       /* sampler2DArray lobe_map */
    VIEW_UNIT_SHEEN,       /* samplerCube sheen_chain */
    VIEW_UNIT_SHEEN_TABLE, /* sampler2D sheen_table */
    VIEW_UNIT_PICTURE,     /* sampler2D picture: the linear picture */
    VIEW_UNIT_OTHER,       /* sampler2D other: what it is compared with; while
                              it is made, backdrop_map: the map of the set */
    VIEW_UNIT_COUNT
} view_unit;

/* Texture units of the reference, of the room, and of captures, which draw the
 * room. */
enum {
    VIEW_TRUTH_UNIT_TOKENS = VIEW_UNIT_COUNT,
    VIEW_TRUTH_UNIT_CHANCE,
    VIEW_TRUTH_UNIT_MAP,                      /* samplerCube environment_map */
    VIEW_MODEL_UNITS,                         /* of view/model.c */
    VIEW_ROOM_UNIT_DYNAMIC = VIEW_UNIT_COUNT, /* specular, irradiance */
    VIEW_ROOM_UNIT_LOCALS = VIEW_ROOM_UNIT_DYNAMIC + 2, /* the same */
    VIEW_ROOM_UNIT_BUFFER = VIEW_ROOM_UNIT_LOCALS + 2,
    VIEW_ROOM_UNIT_MASKS,
    VIEW_CAPTURE_UNIT,      /* source */
    VIEW_CAPTURE_UNIT_MORE, /* samples, the other paraboloid */
    VIEW_ROOM_UNITS
};

#endif
