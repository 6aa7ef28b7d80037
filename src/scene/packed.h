/* SPDX-License-Identifier: MIT */
/* Decoders of what glTF packs, which are loaded on demand. */
#ifndef SCENE_PACKED_H
#define SCENE_PACKED_H

#include "scene/bridge/scene_bridge.h"

/* The functions of bridge/scene_bridge.h that dlsym found. */
typedef struct ibl_scene_decoders {
    int (*has)(ibl_scene_decoder);
    int (*meshopt)(int, int, const unsigned char *, size_t, size_t, size_t,
                   void *);
    int (*webp_size)(const unsigned char *, size_t, int *, int *);
    int (*webp)(const unsigned char *, size_t, int, int, unsigned char *);
    ibl_draco *(*draco)(const unsigned char *, size_t, uint32_t *, uint32_t *);
    int (*draco_floats)(const ibl_draco *, int, double, int, float *);
    void (*draco_indices)(const ibl_draco *, uint32_t *);
    void (*draco_free)(ibl_draco *);
} ibl_scene_decoders;

/* Safe on many threads at once. NULL: *why says what is missing and how to get
 * it. */
const ibl_scene_decoders *ibl_scene_decoders_for(ibl_scene_decoder d,
                                                 const char **why);

#endif
