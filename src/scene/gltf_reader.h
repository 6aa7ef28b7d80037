/* SPDX-License-Identifier: MIT */
/* The state of reading a glTF file, and the parts of its reader. Each function
 * that returns a bool has set the reader's status, after a message, when it
 * returns false. */
#ifndef SCENE_GLTF_READER_H
#define SCENE_GLTF_READER_H

#include "io/input.h"
#include "scene/scene.h"
#include "json/json_at.h"

enum {
    /* Numbers in all attributes and indices, 1 GiB of them: an accessor may
     * take no bytes, and a buffer may be used many times. */
    IBL_SCENE_VALUES = 1 << 28,
    IBL_SCENE_DRAWS = 1 << 20
};

/* Memory that the scene keeps: files and data URIs. */
struct ibl_scene_store {
    struct ibl_scene_store *next;
    ibl_input in;
};

typedef struct ibl_gltf_bytes {
    const unsigned char *bytes;
    size_t size;
} ibl_gltf_bytes;

typedef struct ibl_gltf {
    ibl_ctx *ctx;
    const char *path;
    ibl_scene *scene;
    ibl_json_file json;
    ibl_json_at root;
    ibl_status status;
    ibl_gltf_bytes chunk; /* the binary chunk of .glb */
    ibl_gltf_bytes *buffers;
    int buffer_count;
    int *mesh_first; /* primitive with which a mesh begins; one more in all */
    int mesh_count;
    uint64_t values; /* that were read */
    uint64_t mended; /* values among them that were no numbers */
    int left_out;    /* primitives that are no triangles */
} ibl_gltf;

/* Reports that memory ran out; returns false. */
bool ibl_gltf_no_memory(ibl_gltf *g);

/* Elements of an array of the root; absent: an empty one. */
bool ibl_gltf_array(ibl_gltf *g, const char *key, ibl_json_at *array,
                    int *count);
/* An index below count; optional and absent: -1. */
bool ibl_gltf_index(ibl_json_at at, int count, int *index);
/* Numbers, as many as there must be, clamped to low..high; optional and absent:
 * they stay. */
bool ibl_gltf_reals(ibl_json_at at, int count, double low, double high,
                    float *out);

/* gltf_file.c: the JSON, buffers and bytes of images. */
bool ibl_gltf_open(ibl_gltf *g);
bool ibl_gltf_view(ibl_gltf *g, ibl_json_at index, ibl_gltf_bytes *view,
                   int *stride);
bool ibl_gltf_images(ibl_gltf *g);

/* accessor.c: index names an accessor. *out, which ibl_free frees, has most
 * components an element; those that the file has not are 1. */
bool ibl_gltf_floats(ibl_gltf *g, ibl_json_at index, int least, int most,
                     float **out, uint32_t *count);
bool ibl_gltf_indices(ibl_gltf *g, ibl_json_at index, uint32_t **out,
                      uint32_t *count);

bool ibl_gltf_materials(ibl_gltf *g); /* gltf_material.c */
bool ibl_gltf_meshes(ibl_gltf *g);    /* gltf_mesh.c */
bool ibl_gltf_nodes(ibl_gltf *g);     /* gltf_node.c */

#endif
