/* SPDX-License-Identifier: MIT */
/* The sphere grid, its materials and the camera, for shaders and tests; errors
 * of pictures, for each sphere or material. */
#ifndef VIEW_SPHERE_GRID_H
#define VIEW_SPHERE_GRID_H

#include "view/settings.h"

typedef struct view_material {
    double metal[3];      /* F0 of the metal end, linear Rec. 709 */
    double dielectric_f0; /* of the other end */
    double diffuse; /* 1 if the dielectric end has metal as its diffuse colour,
                       0 if it has none */
} view_material;

enum {
    VIEW_MATERIALS = 12
};

/* The first is the default; names end with NULL. */
extern const view_material view_materials[VIEW_MATERIALS];
extern const char *const view_material_names[VIEW_MATERIALS + 1];

/* As shaders/sphere.vert has it. */
typedef struct view_sphere {
    double centre[3], radius;
    double f0[3]; /* mix of dielectric_f0 and metal by metallic */
    double metallic;
    double albedo[3]; /* diffuse: albedo (1 - metallic) */
    double roughness;
} view_sphere;

/* Spheres of the grid, row by row from the bottom left: rows * columns. */
int view_grid(const view_settings *s,
              view_sphere spheres[VIEW_MAX_GRID * VIEW_MAX_GRID]);

/* The ray through (x, y), each -1..1 from the lower left, is along
 * forward + x right + y up. */
typedef struct view_camera {
    double eye[3], right[3], up[3], forward[3];
    double near, far;
    double shift[2]; /* of view_settings.pixel and .covered: what is at
                        x + shift appears at x */
} view_camera;

view_camera view_camera_of(const view_settings *s, int width, int height);
/* World to clip space, column-major. */
void view_camera_matrix(const view_camera *c, double matrix[16]);
/* Turns a direction of the world into the frame of an environment that is
 * turned by turn_deg; -turn_deg turns it back. */
void view_turn(double turn_deg, const double world[3], double env[3]);

#endif
