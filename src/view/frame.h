/* SPDX-License-Identifier: MIT */
/* Uniform block "Frame", std140; shaders/frame.glsl has the same members. */
#ifndef VIEW_FRAME_H
#define VIEW_FRAME_H

#include <stddef.h>

#include "view/baked_set.h"
#include "view/sphere_grid.h"

/* What is behind everything. */
enum view_backdrop {
    VIEW_BACKDROP_COLOUR,
    VIEW_BACKDROP_CUBE,  /* the skybox or level 0 */
    VIEW_BACKDROP_MAP,   /* the map of the set, which the renderer finds */
    VIEW_BACKDROP_LEVEL, /* the specular chain */
    VIEW_BACKDROPS
};

/* Half the width of the ground's maps, whose edges are free of the model;
 * GROUND of shaders. */
#define VIEW_GROUND_HALF 1.02

typedef struct view_frame {
    float clip[16]; /* world to clip space, column-major */
    float eye[4];
    float right[4], up[4], forward[4]; /* of view_camera */
    float viewport[4];                 /* width, height, 1/width, 1/height */
    float turn[4];    /* cosine and sine of settings.turn, width of a place in
                         pixels */
    float lod[4];     /* scale, offset, last level, mapping (baked_set) */
    float diffuse[4]; /* scale of the irradiance map, geometry of the table
                         (ibl_geometry), yaw of the map in turns,
                         view_environment */
    float sh[25][4];  /* RGB of each (l, m), E/pi; zeros beyond sh_degree */
    float disc_direction[IBL_MAX_LIGHTS][4]; /* of the set's lights, in the
                                                environment; their radius */
    float disc_irradiance[IBL_MAX_LIGHTS][4];
    float light_position[4][4];  /* world, 1 */
    float light_intensity[4][4]; /* RGB, 0 */
    float background[4]; /* colour, times alpha, and alpha; or a level, below
                            0: of the roughness; the roughness */
    float constant[4];   /* mean radiance of the set, for VIEW_PARTS_AMBIENT */
    float metal[4];      /* colour of the chosen material or view_override;
                            its roughness on models */
    float plastic[4];    /* its F0; its metallic on models */
    float ranges[4];     /* of metallic over rows, of roughness over columns */
    int grid[4]; /* columns, 0: no spheres are shown; rows; 1 if the dielectric
                    has a diffuse colour */
    float ground_light[16]; /* from the main light, as clip */
    float ground_sun[4];    /* its irradiance / pi there */
    float ground[4]; /* height, radius, tangent of the light's radius, 1 with
                        the light */
    int parts[4];    /* view_parts, rough_fresnel, view_override, ground */
    int shading[4]; /* multiscatter, lights, view_backdrop, 1 if the sky texture
                       has filterable levels, else 0 */
    int choice[4];  /* mode, diffuse, layout, level */
    int reflection[4];   /* view_reflection; that of the other picture; number
                            of discs; number that the sky lacks */
    float inspect_at[4]; /* zoom, pan x, pan y */
    int looks[4];        /* view_channel; filter; 1 if the background is
                            transparent */
    float display[4];    /* 2^ev, split, gain, 0 */
    int show[4];         /* tone, below 0: linear values; false_colour;
                            compare */
    int sampling[4];     /* of the reference (truth.h): first sample, number;
                            1: there is a table of lights; discs
                            that its environment lacks */
} view_frame;

/* Number of leading bytes that the reference depends on, and the linear
 * picture. */
enum {
    VIEW_FRAME_REFERENCE = offsetof(view_frame, choice),
    VIEW_FRAME_LINEAR = offsetof(view_frame, display)
};

/* What a program of surface.frag is for: each has variants, for software draws
 * all branches of a pixel. */
typedef struct view_lighting {
    view_reflection reflection; /* VIEW_REFERENCE: by samples (truth.h) */
    view_diffuse diffuse;       /* never AUTO */
    view_parts parts;           /* VIEW_PARTS_COUNT: numbers of materials */
    bool rough_fresnel, override;
    bool probes;   /* the room's, in its uniforms: shaders/room_light.glsl */
    bool mirrored; /* the picture is */
} view_lighting;

/* Adds what defines the variant. */
void view_lighting_define(const view_lighting *l, char *text, size_t size);

/* How diffuse light of the settings is looked up: never AUTO. */
view_diffuse view_diffuse_of(const view_settings *s, const baked_set *set);
/* What it says of the camera and the size of the picture. */
void view_frame_camera(view_frame *f, const view_camera *c, int width,
                       int height);
void view_frame_fill(view_frame *f, const view_settings *s,
                     const baked_set *set, int width, int height);

#endif
