/* SPDX-License-Identifier: MIT */
/*
 * iblbake: reflection probes at run time.
 *
 * An environment map is one point, infinitely far away. A probe is one that was
 * captured somewhere: it holds for the points of its influence volume, and its
 * reflections are looked up as if they came from the walls of its proxy. What
 * is here decides which probes a point has, how much of each, and in which
 * direction to look; ibl/probes.glsl, installed beside this header, is the same
 * for shaders, and tests hold the two to each other. Needs the C library alone;
 * nothing allocates, nothing keeps state, so that any number of threads may
 * call at once.
 *
 * Points and vectors are of the world (right-handed, +Y up) in any unit of
 * length; boxes stand along the axes. Lengths and coordinates are finite and,
 * but for 0, of magnitudes from 1e-75 to 1e75; then no result is NaN.
 */
#ifndef IBL_PROBES_H
#define IBL_PROBES_H

#include "ibl.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef enum ibl_shape {
    IBL_SHAPE_BOX,
    IBL_SHAPE_SPHERE
} ibl_shape;

/* "box" or "sphere"; else "unknown". */
const char *ibl_shape_name(ibl_shape shape);

typedef struct ibl_volume {
    ibl_shape shape;
    double centre[3];
    double half[3]; /* of a box, > 0; of a sphere half[0] is its radius, and
                       the others are not looked at */
} ibl_volume;

typedef struct ibl_probe {
    double position[3];   /* where it was captured */
    ibl_volume influence; /* the points that it is for */
    double blend;         /* width inside the influence's border over which its
                             weight falls from 1 to 0; 0: at once. Wider than
                             the volume is deep, it never gets to 1. */
    int has_proxy;        /* 0: reflections are infinitely far away */
    ibl_volume proxy;     /* where they come from */
    int priority;         /* the higher is first, whatever the volumes */
    int layer;            /* of the cube array */
} ibl_probe;

/* Probes that a point can have. */
#define IBL_MAX_PROBES_AT 4

/* Those of a point, weights > 0 (of ibl_probes_near: >= 0). The sum of them and
 * rest is 1, to rounding. */
typedef struct ibl_probe_mix {
    int count;
    int probe[IBL_MAX_PROBES_AT]; /* indices */
    double weight[IBL_MAX_PROBES_AT];
    double rest; /* of the global environment, 0..1 */
} ibl_probe_mix;

/*
 * How far a point is under a probe's influence: 1 where it is at least `blend`
 * inside the volume, 0 on its border and outside, between them
 * smoothstep(depth / blend). A box's depth is the least of the distances to its
 * six faces, so the weight is continuous; its steepest slope is 1.5 / blend.
 * With a blend of 0 it jumps at the border.
 */
double ibl_probe_influence(const ibl_probe *probe, const double point[3]);

/* Volume in cubic units of length, by which smaller ones go first. */
double ibl_volume_size(const ibl_volume *volume);

/*
 * The order in which ibl_probes_blend takes probes: priority falling, size of
 * the influence volume rising, then as they come. Writes count indices.
 */
void ibl_probes_order(const ibl_probe *probes, int count, int *order);

/* The probe whose position is nearest, of equals the first; -1 of none. */
int ibl_probes_nearest(const ibl_probe *probes, int count,
                       const double point[3]);

/*
 * The k nearest positions (k is taken into 1..IBL_MAX_PROBES_AT), nearest
 * first, by inverse distance. Weights are those of Franke and Little 1980,
 * ((R - d) / (R d))^2 with R the distance of the one after the k nearest
 * (infinite, if there is none), over their sum: a probe comes and goes with
 * weight 0. On a probe its weight is 1; probes at one place share. rest is 0,
 * or 1 of no probes.
 *
 * With d1 and d2 the distances of the nearest two, no weight is steeper than
 * 8 (k - 1) R / (d2 (R - d1)). So weights are continuous except where R is d1,
 * the k + 1 nearest being equally far: there they are equal among the first k,
 * and jump. That is every plane in the middle between probes for k = 1, and the
 * middle of a regular grid's cells for any k here: no weights of k probes alone
 * that sum to 1 can do without. Where it shows, use volumes.
 */
void ibl_probes_near(const ibl_probe *probes, int count, const double point[3],
                     int k, ibl_probe_mix *mix);

/*
 * By influence volumes: in the order of ibl_probes_order each probe takes its
 * influence, or what is left of 1; what is left at the end is the global
 * environment's. alpha, if not NULL, of each probe (not in order): how much of
 * what is looked up the probe has really seen, 0..1, which scales its
 * influence; later ones fill in. Of more than IBL_MAX_PROBES_AT with a share
 * the largest are kept, each less the largest share that is not, so that one
 * comes and goes with weight 0; the global environment gets the difference.
 *
 * Continuous if no blend is 0 (and alpha is). With G the sum of 1.5 / blend of
 * the probes in whose blend width the point is, no weight is steeper than G;
 * 2 G, and rest 5 G, where more than IBL_MAX_PROBES_AT have a share.
 */
void ibl_probes_blend(const ibl_probe *probes, int count, const int *order,
                      const double point[3], const double *alpha,
                      ibl_probe_mix *mix);

/*
 * Parallax: the direction from the probe's position to where the ray from point
 * along direction (any length but 0) meets the proxy from inside: unit. Returns
 * 1, or 0 with the direction itself, unit, where the proxy does not hold: there
 * is none, point is outside of it, or the probe is itself where the ray meets.
 * A point outside by no more than 1/1024 of the half width (or radius) is on
 * the wall, and what is on the wall is inside: a floor that is the wall is not
 * lost by rounding. From there a ray outwards meets at once. A zero component
 * is a ray along the wall; a direction of 0 is looked up as it is. Lagarde and
 * Zanuttini 2012, "Local Image-based Lighting with Parallax-corrected Cubemap".
 */
int ibl_probe_parallax(const ibl_probe *probe, const double point[3],
                       const double direction[3], double lookup[3]);

/* ---- tiles of the screen ------------------------------------------------ */

/* Which probes the tiles of a picture need. */
typedef struct ibl_tiles {
    double clip[16];   /* world to clip space, column-major; x and y are seen
                          from -w to w, w > 0 in front. z may be any. */
    int width, height; /* pixels, 1..IBL_MAX_EDGE */
    int tile;          /* edge in pixels, >= 1; the last ones may be cut */
} ibl_tiles;

#define IBL_MAX_TILE_PROBES 64

int ibl_tiles_columns(const ibl_tiles *tiles);
int ibl_tiles_rows(const ibl_tiles *tiles);
/*
 * One mask for each tile, row by row from the lower left (y of -w): bit i is
 * probe i of count, at most IBL_MAX_TILE_PROBES. Conservative: a probe is in
 * every tile in which a point of its influence volume is seen, however far or
 * near, and to rounding in no other. masks holds columns x rows.
 * IBL_ERR_ARGUMENT: tiles or count out of range, masks untouched.
 */
ibl_status ibl_tiles_cull(const ibl_tiles *tiles, const ibl_probe *probes,
                          int count, unsigned long long *masks);

/* ---- for shaders -------------------------------------------------------- */

#define IBL_PROBE_FLOATS 20

/*
 * What ibl/probes.glsl reads, IBL_PROBE_FLOATS for each of count probes, in
 * order: texels of RGBA32F, in a buffer texture, are
 *
 *     influence's centre, blend
 *     influence's half, 1 for a sphere
 *     proxy's centre, 1 for has_proxy
 *     proxy's half, 1 for a sphere
 *     position, layer
 *
 * An index in the shader is a place in order. For masks that agree with it give
 * ibl_tiles_cull the probes themselves in order.
 */
void ibl_probes_pack(const ibl_probe *probes, int count, const int *order,
                     float *texels);

#ifdef __cplusplus
}
#endif

#endif
