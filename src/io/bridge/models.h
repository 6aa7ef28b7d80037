/* SPDX-License-Identifier: MIT */
/*
 * libiblscene.so: decoders of what models pack, as functions of C. Programs
 * load it with dlopen when a file needs it. No function throws or prints.
 */
#ifndef IBL_IO_BRIDGE_MODELS_H
#define IBL_IO_BRIDGE_MODELS_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Increase it with every change of the interface. */
#define IBL_DECODERS_ABI 1

/* Triangles of Draco. */
typedef struct ibl_draco ibl_draco;

/* NULL: it was built without. */
typedef struct ibl_decoders {
    /* EXT_meshopt_compression.
     *   mode    0 ATTRIBUTES, 1 TRIANGLES, 2 INDICES
     *   filter  0 NONE, 1 OCTAHEDRAL, 2 QUATERNION, 3 EXPONENTIAL
     *   out     count * stride bytes
     * 0: damaged, or the stride is not one of the mode's and the filter's. */
    int (*meshopt)(int mode, int filter, const unsigned char *bytes,
                   size_t size, size_t count, size_t stride, void *out);

    /* The size of a WebP. 0: it is none. */
    int (*webp_size)(const unsigned char *bytes, size_t size, int *width,
                     int *height);
    /* Its pixels, 4 * width * height bytes. 0: damaged, or animated. */
    int (*webp)(const unsigned char *bytes, size_t size, int width, int height,
                unsigned char *rgba);

    /* NULL: damaged, no triangles, or out of proportion to its size. */
    ibl_draco *(*draco)(const unsigned char *bytes, size_t size,
                        uint32_t *vertices, uint32_t *triangles);
    /* vertices * components floats of the attribute with a unique id; integers
     * are divided by the largest if they are normalized, here or there. 0:
     * there is none of so many components. */
    int (*draco_floats)(const ibl_draco *mesh, int id, int normalized,
                        int components, float *out);
    /* 3 * triangles indices, all below vertices. */
    void (*draco_indices)(const ibl_draco *mesh, uint32_t *out);
    void (*draco_free)(ibl_draco *mesh);
} ibl_decoders;

/* NULL: this is another version of the interface. */
const ibl_decoders *ibl_decoders_of(int abi);

#ifdef __cplusplus
}
#endif

#endif
