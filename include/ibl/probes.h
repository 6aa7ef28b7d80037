/* SPDX-License-Identifier: MIT */
/*
 * iblbake: reflection probes at run time.
 *
 * An environment map is one point, infinitely far away. A probe is one that was
 * captured somewhere: it holds for the points of its influence volume, and its
 * reflections are looked up as if they came from the walls of its proxy. What
 * is here decides which probes a point has, how much of each, and in which
 * direction to look; shaders/probes.glsl is the same for shaders, and tests
 * hold the two to each other. Needs the C library alone; nothing allocates,
 * nothing keeps state.
 *
 * Points and vectors are of the world (right-handed, +Y up) in any unit of
 * length; boxes stand along the axes.
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

/* "box" or "sphere". */
const char *ibl_shape_name(ibl_shape shape);

typedef struct ibl_volume {
    ibl_shape shape;
    double centre[3];
    double half[3]; /* of a box, > 0; of a sphere half[0] is its radius */
} ibl_volume;

typedef struct ibl_probe {
    double position[3];   /* where it was captured */
    ibl_volume influence; /* the points that it is for */
    double blend;         /* width inside the influence's border over which its
                             weight falls from 1 to 0; 0: at once */
    int has_proxy;        /* 0: reflections are infinitely far away */
    ibl_volume proxy;     /* where they come from */
    int priority;         /* the higher is first, whatever the volumes */
    int layer;            /* of the cube array */
} ibl_probe;

/* Probes that a point can have. */
#define IBL_MAX_PROBES_AT 4

/* Those of a point, weights 0..1. Their sum is 1, or 1 - rest. */
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
 */
double ibl_probe_influence(const ibl_probe *probe, const double point[3]);

/* Volume in cubic units of length, by which smaller ones go first. */
double ibl_volume_size(const ibl_volume *volume);

/*
 * The order in which ibl_probes_blend takes probes: priority falling, size of
 * the influence volume rising, then as they come. Writes count indices.
 */
void ibl_probes_order(const ibl_probe *probes, int count, int *order);

/* The probe whose position is nearest; -1 of none. */
int ibl_probes_nearest(const ibl_probe *probes, int count,
                       const double point[3]);

/*
 * The k nearest (1..IBL_MAX_PROBES_AT) positions, by inverse distance. Weights
 * are those of Franke and Little, ((R - d) / (R d))^2 with R the distance of
 * the one after the k nearest, so that a probe comes and goes with weight 0:
 * continuous wherever the point is not at two probes at once. On a probe its
 * weight is 1. rest is 0, or 1 of no probes.
 */
void ibl_probes_near(const ibl_probe *probes, int count, const double point[3],
                     int k, ibl_probe_mix *mix);

/*
 * By influence volumes: in the order of ibl_probes_order each probe takes its
 * influence, as long as there is something left of 1; what is left at the end
 * is the global environment's. alpha, if not NULL, of each probe (not in
 * order): how much of what is looked up the probe has really seen, 0..1, which
 * scales its share; others fill in. Only the first IBL_MAX_PROBES_AT that have
 * a share are kept; the rest gets theirs.
 */
void ibl_probes_blend(const ibl_probe *probes, int count, const int *order,
                      const double point[3], const double *alpha,
                      ibl_probe_mix *mix);

/*
 * Parallax: the direction from the probe's position to where the ray from point
 * along direction (any length but 0) meets the proxy from inside: unit. Returns
 * 1, or 0 with the direction itself, unit, where the proxy does not hold: there
 * is none, or point is outside of it. A point on the wall is inside. Never NaN
 * for finite arguments: a zero component is a ray along the wall. Lagarde and
 * Zanuttini 2012, "Local Image-based Lighting with Parallax-corrected Cubemap".
 */
int ibl_probe_parallax(const ibl_probe *probe, const double point[3],
                       const double direction[3], double lookup[3]);

/* ---- tiles of the screen ------------------------------------------------ */

/* Which probes the tiles of a picture need. */
typedef struct ibl_tiles {
    double clip[16]; /* world to clip space, column-major, w > 0 in front */
    int width, height;
    int tile; /* edge in pixels, >= 1; the last ones may be cut */
} ibl_tiles;

#define IBL_MAX_TILE_PROBES 64

int ibl_tiles_columns(const ibl_tiles *tiles);
int ibl_tiles_rows(const ibl_tiles *tiles);
/*
 * One mask for each tile, row by row from the lower left: bit i is probe i of
 * count, at most IBL_MAX_TILE_PROBES (else IBL_ERR_ARGUMENT). Conservative: a
 * probe is in every tile that a point of its influence volume is seen in, and
 * in few others.
 */
ibl_status ibl_tiles_cull(const ibl_tiles *tiles, const ibl_probe *probes,
                          int count, unsigned long long *masks);

#ifdef __cplusplus
}
#endif

#endif
