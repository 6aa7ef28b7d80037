/* SPDX-License-Identifier: MIT */
/* The state of reading a glTF file, and the parts of its reader. Each function
 * that returns a bool has said what is wrong when it returns false. That costs
 * the part of the scene that it reads, and a warning; the file only if the
 * reader's status is set, too. */
#ifndef SCENE_GLTF_READER_H
#define SCENE_GLTF_READER_H

#include "io/bridge/models.h"
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
    int (*mesh)[2]; /* of each the first primitive and the last's number + 2;
                       0: it is not read yet */
    ibl_gltf_bytes *views; /* that were unpacked; else without bytes */
    bool strict;     /* what is wrong with a part is an error of the file */
    uint64_t values; /* that were read */
    uint64_t drawn;  /* vertices and corners of all draws */
    uint64_t mended; /* values that were no numbers */
    int left_out;    /* primitives that are no triangles */
    unsigned lacked; /* bits of decoders that are not there */
    int wrong;       /* parts that were warned of */
} ibl_gltf;

/* Reports an error of the whole file; returns false. */
bool ibl_gltf_refuse(ibl_gltf *g, const char *fmt, ...)
    __attribute__((format(printf, 2, 3)));

/* The number of elements of an array of the root; absent or none: 0. */
int ibl_gltf_array(ibl_gltf *g, const char *key, ibl_json_at *array);
/* An index below count; optional and absent: -1. */
bool ibl_gltf_index(ibl_json_at at, int count, int *index);
/* Numbers, as many as there must be, clamped to low..high; optional and absent:
 * they stay. */
bool ibl_gltf_reals(ibl_json_at at, int count, double low, double high,
                    double *out);
/* A member that is an object or absent; an extension of an object. */
bool ibl_gltf_object(ibl_json_at at, const char *key, ibl_json_at *object);
bool ibl_gltf_extension(ibl_json_at at, const char *name, ibl_json_at *object);

/* gltf_file.c: the JSON, buffers and bytes of images. */
bool ibl_gltf_open(ibl_gltf *g);
bool ibl_gltf_view(ibl_gltf *g, ibl_json_at index, ibl_gltf_bytes *view,
                   int *stride);
/* The bytes of a buffer that an object with byteOffset and byteLength names. */
bool ibl_gltf_slice(ibl_gltf *g, ibl_json_at at, ibl_gltf_bytes *slice);
/* Memory that the scene keeps, zeroed. */
unsigned char *ibl_gltf_keep(ibl_gltf *g, size_t size);
void ibl_gltf_images(ibl_gltf *g);

/* accessor.c: index names an accessor. *out, which ibl_free frees, has most
 * components an element; those that the file has not are 1. */
bool ibl_gltf_floats(ibl_gltf *g, ibl_json_at index, int least, int most,
                     float **out, uint32_t *count);
bool ibl_gltf_indices(ibl_gltf *g, ibl_json_at index, uint32_t **out,
                      uint32_t *count);
bool ibl_gltf_normalized(ibl_gltf *g, ibl_json_at index);
/* Makes 0 of what is not finite, and counts it. */
void ibl_gltf_mend(ibl_gltf *g, float *values, size_t count);
/* Counts numbers before they take memory. False: they are too many. */
bool ibl_gltf_count(ibl_gltf *g, ibl_json_at at, uint64_t values);

/* gltf_packed.c: decoders that are loaded on demand, on any thread; those that
 * are missing are NULL. */
const ibl_decoders *ibl_gltf_decoders(void);
/* Unpacks the bytes of a bufferView with EXT_meshopt_compression. */
bool ibl_gltf_unpack(ibl_gltf *g, ibl_json_at extension, ibl_gltf_bytes *out,
                     int *stride);
/* Unpacks a primitive with KHR_draco_mesh_compression: *mesh, which its decoder
 * frees, with so many vertices and indices. */
bool ibl_gltf_draco(ibl_gltf *g, ibl_json_at extension, ibl_draco **mesh,
                    uint32_t *vertices, uint32_t *corners);

void ibl_gltf_materials(ibl_gltf *g); /* gltf_material.c */
/* Takes an image out of all materials. */
void ibl_scene_forget(ibl_scene *s, int image);
/* gltf_mesh.c: adds the primitives of a mesh, once; skinned: anew, with joints
 * and weights. */
bool ibl_gltf_mesh(ibl_gltf *g, int mesh, bool skinned, int *first, int *end);
/* Drops triangles with a vertex that is nowhere. False: none is left. */
bool ibl_gltf_drop_nowhere(ibl_gltf *g, ibl_scene_primitive *p);
void ibl_gltf_nodes(ibl_gltf *g); /* gltf_node.c */
/* gltf_skin.c: moves the primitives from the first to the last as a skin does,
 * by the places of nodes; they stand at origin then. False: they are freed. */
bool ibl_gltf_skin(ibl_gltf *g, ibl_json_at skin, const double (*world)[16],
                   int nodes, int first, double origin[3]);
void ibl_scene_primitive_free(ibl_scene_primitive *p);

#endif
