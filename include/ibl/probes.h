/* SPDX-License-Identifier: MIT */
/*
 * iblbake: reflection probes at run time.
 *
 * A probe is an environment map that was captured at a position. It lights the
 * points of its influence volume, and its reflections are looked up as if they
 * came from the walls of its proxy volume. These functions decide which probes
 * light a point, with which weights, and in which direction to look each up.
 * ibl/probes.glsl, installed beside this header, has the same functions for
 * shaders; tests compare the two. They need only the C library, allocate
 * nothing and keep no state: any number of threads may call them at once. Only
 * the reader of what `iblbake probes` baked, at the end, is different.
 *
 * Points and vectors are in world space (right-handed, +Y up) in any unit of
 * length; boxes are parallel to the axes. Lengths and coordinates are 0 or of
 * magnitudes from 1e-75 to 1e75; then no result is NaN.
 */
#ifndef IBL_PROBES_H
#define IBL_PROBES_H

#include "io.h"

#ifdef __cplusplus
extern "C" {
#endif
IBL_API_BEGIN

typedef enum ibl_shape {
    IBL_SHAPE_BOX,
    IBL_SHAPE_SPHERE
} ibl_shape;

/* "box" or "sphere"; else "unknown". */
const char *ibl_shape_name(ibl_shape shape);

typedef struct ibl_volume {
    ibl_shape shape;
    double centre[3];
    double half[3]; /* box: half its edges, > 0; sphere: half[0] is the radius,
                       half[1] and half[2] are ignored */
} ibl_volume;

typedef struct ibl_probe {
    double position[3];   /* where it was captured */
    ibl_volume influence; /* the points that it lights */
    double blend;         /* width inside the influence's border over which its
                             weight falls from 1 to 0; 0: a step. If it is wider
                             than the volume is deep, 1 is never reached. */
    int has_proxy;        /* 0: reflections are infinitely far away */
    ibl_volume proxy;     /* where reflections come from */
    int priority;         /* higher ones come first, whatever their volumes */
    int layer;            /* in the cube array */
} ibl_probe;

/* Largest number of probes that light a point: as many as the cells of a grid
 * that meet in a corner. */
#define IBL_MAX_PROBES_AT 8

/* The probes of a point, with weights > 0. The sum of the weights and rest is
 * 1, to rounding. */
typedef struct ibl_probe_mix {
    int count;
    int probe[IBL_MAX_PROBES_AT]; /* indices */
    double weight[IBL_MAX_PROBES_AT];
    double rest; /* weight of the global environment, 0..1 */
} ibl_probe_mix;

/*
 * A probe's influence on a point: 1 at least `blend` inside the volume, 0 on
 * its border and outside, between them smoothstep(depth / blend). The depth in
 * a box is the distance to the nearest of its six faces.
 */
double ibl_probe_influence(const ibl_probe *probe, const double point[3]);

/* Volume in cubic units of length. */
double ibl_volume_size(const ibl_volume *volume);

/*
 * The order in which ibl_probes_blend takes probes: by falling priority, then
 * by rising size of the influence volume, then by rising index. Writes count
 * indices.
 */
void ibl_probes_order(const ibl_probe *probes, int count, int *order);

/*
 * Weights by influence volumes. In the order of ibl_probes_order each probe
 * takes its influence, at most what is left of 1; the global environment gets
 * what remains. alpha, if not NULL, has for each probe (by index) the part 0..1
 * of the lookup that the probe has seen; it scales the influence, and later
 * probes fill in. A probe that a wall hides from the point has an alpha of 0:
 * volumes do not know walls. If more than IBL_MAX_PROBES_AT have a share, the
 * largest are kept, each reduced by the largest share that is not kept, so that
 * a probe appears and disappears with weight 0; then they are scaled to have
 * what all had. Where that leaves 0 of each, they stay as they were.
 * Else continuous, if no blend is 0 and alpha is continuous.
 */
void ibl_probes_blend(const ibl_probe *probes, int count, const int *order,
                      const double point[3], const double *alpha,
                      ibl_probe_mix *mix);

/*
 * Parallax: the unit direction from the probe's position to the point where the
 * ray from `point` along `direction` (any length) leaves the proxy. Returns 1.
 * Returns 0, with lookup the normalised direction (0 if it is 0), if there is
 * no proxy, the point is outside it, the ray leaves at the probe's position, or
 * the direction is 0.
 * Points on the wall are inside. Points outside by at most 1/1024 of the half
 * width (or radius) are moved to the wall, so that rounding does not lose a
 * floor that is a wall. A ray outwards from there leaves at once.
 * Lagarde and Zanuttini 2012, "Local Image-based Lighting with
 * Parallax-corrected Cubemap".
 */
int ibl_probe_parallax(const ibl_probe *probe, const double point[3],
                       const double direction[3], double lookup[3]);

/* ---- for shaders -------------------------------------------------------- */

#define IBL_PROBE_FLOATS 20

/*
 * Writes the buffer texture that ibl/probes.glsl reads, IBL_PROBE_FLOATS floats
 * for each of count probes, in order. Its RGBA32F texels are
 *
 *     influence's centre, blend
 *     influence's half, 1 for a sphere
 *     proxy's centre, 1 for has_proxy
 *     proxy's half, 1 for a sphere
 *     position, layer
 *
 * Index i in the shader is probe order[i].
 */
void ibl_probes_pack(const ibl_probe *probes, int count, const int *order,
                     float *texels);

/* ---- baked probes ------------------------------------------------------- */

/* As many as a cube array surely has layers for. */
#define IBL_MAX_PROBES (IBL_MAX_LAYERS / IBL_FACES)

#define IBL_PROBE_SH 9 /* coefficients of irradiance: l = 0, 1, 2 */

/* A cube array in a file beside the index. */
typedef struct ibl_probe_file {
    char *name; /* without a folder; NULL: there is no such file */
    ibl_pixel pixel;
    int size;   /* edge of level 0, in texels */
    int levels; /* 1..IBL_MAX_LEVELS */
    int layers; /* 1..IBL_MAX_LAYERS */
} ibl_probe_file;

/*
 * What lights a scene with probes that `iblbake probes` baked. Colours of the
 * layers are multiplied by alpha, the part that the probe has seen. A zeroed
 * index is empty. Free with ibl_probe_index_free.
 */
typedef struct ibl_probe_index {
    int count;        /* of probes, 1..IBL_MAX_PROBES */
    ibl_probe *probe; /* in the order of ibl_probes_order */
    char **name;      /* of each probe; NULL: the index has none */
    int global;       /* layer of the environment outside of all probes; -1: it
                         has none */
    int holes;        /* 0: alpha is 1 in all layers */

    ibl_probe_file specular;   /* levels of rising roughness */
    ibl_probe_file irradiance; /* of as many layers; without a name: see sh */
    char *lut; /* name of the file of a table, IBL_LUT_SPLIT; NULL: none */

    /* level = x * lod_scale + lod_offset, with x the roughness r, or r (2 - r)
     * if the mapping, one of these two, is not IBL_ROUGHNESS_LINEAR but
     * IBL_ROUGHNESS_FILAMENT. */
    ibl_roughness_map mapping;
    double lod_scale, lod_offset;

    double irradiance_scale; /* irradiance / pi is this times a texel, or times
                                the sum of coefficients and basis */
    /* Irradiance of each layer of specular: RGB and alpha of each coefficient,
     * in the basis and order of ibl_bake_sh. NULL: it is a file. */
    double (*sh)[4 * IBL_PROBE_SH];
} ibl_probe_index;

/*
 * Reads an index.json, see iblbake-probes(1). The names in it are of files in
 * its folder, for ibl_texture_read, which are not looked at.
 *   ctx    for the message of an error; NULL: there is none
 * IBL_ERR_IO: it cannot be read. IBL_ERR_FORMAT: it is damaged, of another
 * version, or no index. IBL_ERR_MEMORY. *index is empty after an error.
 */
ibl_status ibl_probe_index_read(ibl_ctx *ctx, const char *path,
                                ibl_probe_index *index);
void ibl_probe_index_free(ibl_probe_index *index); /* NULL, zeroed are fine */

IBL_API_END
#ifdef __cplusplus
}
#endif

#endif
