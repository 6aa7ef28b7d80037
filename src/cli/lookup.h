/* SPDX-License-Identifier: MIT */
/* Lookups in baked textures as a GPU does them for a shader (OpenGL 4.6,
 * sections 8.13.1 and 8.14, with seamless cube maps), in double precision. */
#ifndef CLI_LOOKUP_H
#define CLI_LOOKUP_H

#include <stdbool.h>

#include <ibl/ibl.h>

/* The lookups of <ibl/ibl.glsl>. */
typedef enum ibl_shader {
    IBL_SHADER_AUTO,  /* the table, if the files have one, else split */
    IBL_SHADER_SPLIT, /* along R, with roughness r */
    IBL_SHADER_BENT,  /* nearer to the normal and blurred, by a formula */
    IBL_SHADER_FIT,   /* the same and irradiance */
    IBL_SHADER_TABLE, /* by the lobe table, one lookup */
    IBL_SHADER_TWO_TAPS,
    IBL_SHADER_THREE_TAPS,
    IBL_SHADER_FOUR_TAPS
} ibl_shader;

/*
 * textureLod(map, dir, level): bilinear. Beyond an edge of a face, the
 * texels are those of the next face; beyond a corner, the mean of the three
 * texels there.
 *   dir  of any length but 0
 */
void ibl_lookup_cube(const ibl_cube *map, int level, const double dir[3],
                     double rgb[3]);

/* The same between two levels: linear. lod is limited to those of the map. */
void ibl_lookup_chain(const ibl_cube *map, const double dir[3], double lod,
                      double rgb[3]);

/* Irradiance / pi from the radiance's harmonics, as ibl_bake_sh has them, not
 * below 0: ibl_irradiance_sh of any degree. normal is a unit vector. */
void ibl_lookup_sh(const double *sh, int degree, const double normal[3],
                   double rgb[3]);

/* texture(lut, vec2(n_dot_v, roughness)): bilinear, clamped to the edge. */
void ibl_lookup_lut(const ibl_lut *lut, double n_dot_v, double roughness,
                    double scale_bias[2]);

/* The four channels of a lobe table for 1 to 4 taps, as in ibl_bake_lobe_table.
 */
void ibl_lookup_lobes(const ibl_lobe_table *lobes, int taps, double metallic,
                      double n_dot_v, double roughness, double q[4]);

#endif
