/* SPDX-License-Identifier: MIT */
/* What engines' files are made of, and how each kind is written and read. */
#ifndef ENGINE_SET_H
#define ENGINE_SET_H

#include <jansson.h>

#include "engine/harmonics.h"
#include "engine/png.h"
#include "json/json_load.h"

/* What the files are made of. */
typedef struct ibl_engine_set {
    ibl_texture *specular; /* cube of RGBA32F with keys; gets what the files
                              give back */
    const ibl_cube *irradiance; /* E/pi: of ENV and PLAYCANVAS */
    const double *sh;           /* nine coefficients of radiance or more, as of
                                   ibl_bake_sh: not of PLAYCANVAS */
    const char *stem;           /* of face names */
} ibl_engine_set;

/* [[x, y, z], ...] */
json_t *ibl_engine_triples(const double (*triples)[3], int count);
/* The keys of a texture as an object of texts, and back. */
json_t *ibl_engine_keys(const ibl_texture *tex);
ibl_status ibl_engine_set_keys(ibl_ctx *ctx, const json_t *keys,
                               ibl_texture *tex);
/* Sets the keys of a specular cube whose levels have these roughnesses. */
ibl_status ibl_engine_set_roughness(ibl_ctx *ctx, const double *roughness,
                                    ibl_texture *tex);
/* Adds an object's text; takes its reference, too. False: no memory. */
bool ibl_engine_put_json(json_t *root, ibl_blob *blob);

/* Writers: see ibl_engine_encode. */
ibl_status ibl_env_encode(ibl_ctx *ctx, const ibl_engine_set *set,
                          ibl_blob *main);
ibl_status ibl_gltf_encode(ibl_ctx *ctx, const ibl_engine_set *set,
                           ibl_blob *main, ibl_blob *faces);
ibl_status ibl_atlas_encode(ibl_ctx *ctx, const ibl_engine_set *set,
                            ibl_blob *main);

/* Readers: ibl_env_decode is an ibl_unpack_fn. name is for messages and, of
 * GLTF, the path; tex is empty, and left so after errors. */
bool ibl_env_is(const unsigned char *bytes, size_t size);
ibl_status ibl_env_decode(ibl_ctx *ctx, const char *name, const void *bytes,
                          size_t size, ibl_texture *tex);
ibl_status ibl_gltf_decode(ibl_ctx *ctx, const char *name,
                           const unsigned char *bytes, size_t size,
                           ibl_texture *tex);
ibl_status ibl_atlas_decode(ibl_ctx *ctx, const char *name,
                            const unsigned char *bytes, size_t size,
                            ibl_texture *tex);

#endif
