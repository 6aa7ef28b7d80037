/* SPDX-License-Identifier: MIT */
/*
 * Exports of libiblscene.so: decoders of what glTF packs, with a C interface.
 * Programs load it with dlopen when a file needs it. No function throws or
 * prints. What it was built without fails.
 */
#ifndef SCENE_BRIDGE_SCENE_BRIDGE_H
#define SCENE_BRIDGE_SCENE_BRIDGE_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Increase it with every change of the interface. */
#define IBL_SCENE_BRIDGE_ABI 1

typedef enum ibl_scene_decoder {
    IBL_SCENE_MESHOPT,
    IBL_SCENE_DRACO,
    IBL_SCENE_WEBP
} ibl_scene_decoder;

int ibl_scene_bridge_abi(void);
/* Whether it was built with a decoder. */
int ibl_scene_bridge_has(ibl_scene_decoder d);

/* EXT_meshopt_compression.
 *   mode    0 ATTRIBUTES, 1 TRIANGLES, 2 INDICES
 *   filter  0 NONE, 1 OCTAHEDRAL, 2 QUATERNION, 3 EXPONENTIAL
 *   out     count * stride bytes
 * 0: it is damaged, or the stride is not one of the mode's and the filter's. */
int ibl_scene_meshopt(int mode, int filter, const unsigned char *bytes,
                      size_t size, size_t count, size_t stride, void *out);

/* The size of a WebP. 0: it is none. */
int ibl_scene_webp_size(const unsigned char *bytes, size_t size, int *width,
                        int *height);
/* Its pixels, 4 * width * height bytes. 0: it is damaged, or animated. */
int ibl_scene_webp(const unsigned char *bytes, size_t size, int width,
                   int height, unsigned char *rgba);

/* Triangles of Draco. */
typedef struct ibl_draco ibl_draco;
/* NULL: damaged, no triangles, or its memory would be out of proportion. */
ibl_draco *ibl_scene_draco(const unsigned char *bytes, size_t size,
                           uint32_t *vertices, uint32_t *triangles);
/* vertices * components floats of the attribute with a unique id; integers are
 * divided by unit. 0: there is none of so many components. */
int ibl_scene_draco_floats(const ibl_draco *mesh, int id, double unit,
                           int components, float *out);
/* 3 * triangles indices, all below vertices. */
void ibl_scene_draco_indices(const ibl_draco *mesh, uint32_t *out);
void ibl_scene_draco_free(ibl_draco *mesh); /* NULL is fine */

#ifdef __cplusplus
}
#endif

#endif
