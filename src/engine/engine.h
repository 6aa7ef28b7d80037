/* SPDX-License-Identifier: MIT */
/*
 * Files of engines that hold a whole set: the levels of a specular cube with
 * harmonics or irradiance.
 *   ENV         Babylon's .env, version 2: JSON and PNG images of RGBD
 *   GLTF        glTF 2.0 with EXT_lights_image_based: a .gltf, and a PNG of
 * RGBD for each face of each level PLAYCANVAS  the atlas of PlayCanvas: a PNG
 * of 512x512 texels of RGBP Each also has the keys of the texture, which
 * engines pass over: "iblbake" in the JSON of ENV, "extras" of GLTF, text
 * chunks of PLAYCANVAS.
 */
#ifndef ENGINE_ENGINE_H
#define ENGINE_ENGINE_H

#include "engine/set.h"

typedef enum ibl_engine {
    IBL_ENGINE_NONE,
    IBL_ENGINE_ENV,
    IBL_ENGINE_GLTF,
    IBL_ENGINE_PLAYCANVAS
} ibl_engine;

/* What follows the stem in the name of the file: ".env", ".gltf" or
 * "_envatlas.png". */
const char *ibl_engine_suffix(ibl_engine engine);
/* The kind of file that a name says; NONE: another. */
ibl_engine ibl_engine_of_name(const char *name);
/* Whether a file is glTF that holds a light of GLTF and nothing to draw. */
bool ibl_gltf_is_light(const char *path);
/* "rgbd" or "rgbp". */
const char *ibl_engine_pixel(ibl_engine engine);
/* The largest component of a texel that the files hold. */
float ibl_engine_max(ibl_engine engine);
/* Number of files beside the main one, for so many levels. */
int ibl_engine_faces(ibl_engine engine, int levels);
/* The name of one of them: STEM_LEVEL_FACE.png, with px, nx, ... The caller
 * must free it; NULL: no memory. */
char *ibl_engine_face_name(const char *stem, int index);

/*
 * Encodes the files, PNG images on the context's pool; the same bytes for any
 * number of threads.
 *   faces  ibl_engine_faces() of them
 * main and faces must be freed by the caller, after errors too.
 * IBL_ERR_ARGUMENT: set has no cubes, or other texels than RGBA32F.
 */
ibl_status ibl_engine_encode(ibl_ctx *ctx, ibl_engine engine,
                             const ibl_engine_set *set, ibl_blob *main,
                             ibl_blob *faces);

/*
 * ibl_texture_read that also reads those files, found by content: a cube of
 * RGBA32F, with keys as iblbake writes them. Of files by others the keys have
 * the roughness of the levels. IBL_ERR_UNSUPPORTED: images that are not PNG, a
 * rotation, or images inside of a .gltf.
 *   layer  of an array of cubes, to read alone; -1: all
 */
ibl_status ibl_engine_read(ibl_ctx *ctx, const char *path, int layer,
                           ibl_texture *tex);

/*
 * Reads an engine's file, found by its name, or a KTX2, KTX or DDS file, found
 * by content. texels false: of a large one of these only the header and keys;
 * data of tex may then be NULL, and damage to its texels is seen only if the
 * file is too short for them. *format is an index of ibl_format_names; -1, with
 * tex empty: the file is of another kind. Errors as of ibl_texture_read.
 */
ibl_status ibl_engine_look(ibl_ctx *ctx, const char *path, bool texels,
                           ibl_texture *tex, int *format);

#endif
