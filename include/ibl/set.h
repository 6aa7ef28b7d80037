/* SPDX-License-Identifier: MIT */
/*
 * iblbake: a baked set, read back: the textures of one environment, by this
 * program or another, and how they were baked.
 *
 * Programs that use it link libpng besides what <ibl/io.h> names.
 */
#ifndef IBL_SET_H
#define IBL_SET_H

#include "sidecar.h"

#ifdef __cplusplus
extern "C" {
#endif
IBL_API_BEGIN

enum {
    IBL_CONTENTS = IBL_CONTENT_LOBE_TABLE + 1,
    IBL_SET_DEGREE = 10, /* of a set's harmonics; higher ones are dropped */
    IBL_SET_HARMONICS = (IBL_SET_DEGREE + 1) * (IBL_SET_DEGREE + 1)
};

/* Bits of ibl_set_facts.known. */
enum {
    IBL_KNOWN_MAPPING = 1 << 0,
    IBL_KNOWN_ROUGHNESS = 1 << 1,
    IBL_KNOWN_LOD = 1 << 2,
    IBL_KNOWN_LOBE = 1 << 3,
    IBL_KNOWN_SCALE = 1 << 4,
    IBL_KNOWN_TABLE = 1 << 5,
    IBL_KNOWN_GEOMETRY = 1 << 6,
    IBL_KNOWN_AXES = 1 << 7,
    IBL_KNOWN_YAW = 1 << 8,
    IBL_KNOWN_LIGHTS = 1 << 9
};

/* How a texture was baked. What is not known is as said here, or 0. */
typedef struct ibl_set_facts {
    unsigned known; /* bits IBL_KNOWN_* of what follows */

    /* Of specular levels; roughness also of lobe tables. Not known: the mapping
     * is linear, or Filament's for files of its cmgen; the roughness that which
     * the mapping has for 0 to 1; the lobe GGX. */
    ibl_lobe lobe;
    ibl_roughness_map mapping;
    int levels; /* of roughness: as many as the texture has */
    double roughness[IBL_MAX_LEVELS];
    double lod_scale, lod_offset; /* as in ibl_specular_layout. Not known: the
                                     mapping's, if that is known or there is no
                                     roughness; else both 0: straight lines
                                     between levels. See ibl_set_lod */

    double irradiance_scale; /* E/pi is this times a texel: 1 (if not known),
                                or 1/pi */
    ibl_lut_kind table;      /* IBL_LUT_SPLIT */
    ibl_geometry geometry;   /* IBL_GEOMETRY_SMITH */

    ibl_axes axes;  /* the world's */
    double yaw_deg; /* 0 */
    int lights;     /* that were taken out of it; 0 */
} ibl_set_facts;

typedef struct ibl_set_file {
    char *path; /* NULL: the set has none, and all else is 0 */
    /* Of one layer. Levels and texels as in the file, but in the world's axes
     * and, if those of the file were blocks, as RGBA16F. Cubes and tables have
     * the shape of their content; flat maps stay flat. Engines' files are
     * RGBA32F. */
    ibl_texture texture;
    ibl_pixel pixel; /* of the file */
    ibl_set_facts facts;
    int holds;   /* the ibl_content that it says it holds, or else its name; -1:
                    neither says. Only files of the options hold another one
                    than they were taken for */
    int missing; /* 1: the sidecar names path, but it is not there */
} ibl_set_file;

typedef struct ibl_set {
    char *name;    /* what its files' names begin with, such as "sky"; NULL:
                      files were named one by one */
    char *sidecar; /* path of it, or of an index; NULL: there is none */
    ibl_set_file file[IBL_CONTENTS];

    /* The environment, as keys or the sidecar say. */
    char *source;          /* path as the sidecar has it, or, if no file is
                              there, beside the sidecar; NULL: not known or not
                              at hand */
    ibl_read_options read; /* how it was read, its colours changed and its
                              layout was found; reads engines' files, too */
    double source_peak;    /* ibl_read_report.peak; 0: not known */
    char source_hash[IBL_FILE_HASH]; /* "": not known */
    double yaw_deg;                  /* of the first file that says it; 0 */
    char target[32]; /* that it was baked for: iblbake-engines(7); "": none, or
                        not known */

    int sh_degree;                    /* 0..IBL_SET_DEGREE; -1: no harmonics */
    double sh[3 * IBL_SET_HARMONICS]; /* of radiance, as of ibl_bake_sh, in the
                                         world's axes */
    int light_count; /* that were taken out of all but the skybox; -1: not
                        known */
    ibl_light light[IBL_MAX_LIGHTS]; /* in the world's axes */
} ibl_set;

typedef struct ibl_set_options {
    const char *name; /* of the files of a directory, before "_specular";
                         NULL: there is only one set in it */
    /* Files in place of those that are found; NULL: find it. What the sidecar
     * says of a file that it does not name does not count. */
    const char *file[IBL_CONTENTS];
    unsigned leave; /* bits 1 << content of those that are not looked for */
    int layer;      /* of arrays of cubes; default -1: arrays are refused */
    const ibl_set_facts *facts; /* those that are known hold for all files,
                                   whatever they say; NULL: none */
} ibl_set_options;

ibl_set_options ibl_set_options_default(void);

/*
 * Finds and reads a set.
 *   path  a directory: the set of that name in it. Or NAME.json, its sidecar.
 *         Or one of its textures: of the content that its name says, else
 *         specular levels; the others of that NAME beside it are of the set,
 *         too. Or, of probes, index.json or its directory. NULL: only the files
 *         in opts
 *   opts  NULL for defaults
 *   set   to be freed with ibl_set_free; empty after an error
 * Files are those that the sidecar or index names, else NAME_specular,
 * NAME_irradiance, NAME_skybox, brdf_lut (brdf_lut_schlick-ibl, ...) and
 * NAME_lobe_lut or lobe_lut with .ktx2, .ktx or .dds, else NAME.env, NAME.gltf
 * or NAME_envatlas.png; of several the first, but before it the one in the
 * container of the texture that path names. A sidecar that another program
 * wrote is left out, with a warning, and so is a lobe table for other levels
 * than the specular ones.
 * The keys of a texture hold before what the sidecar says. What neither says is
 * not known, and no error.
 * IBL_ERR_IO: there is no such set, or several, or a file cannot be read.
 * IBL_ERR_FORMAT: a file is damaged, holds something else, or is of another
 * bake or version. IBL_ERR_ARGUMENT: no such layer, or nothing to open.
 * IBL_ERR_UNSUPPORTED as of ibl_texture_read. All say in one line what is wrong
 * and what to do.
 */
ibl_status ibl_set_open(ibl_ctx *ctx, const char *path,
                        const ibl_set_options *opts, ibl_set *set);
void ibl_set_free(ibl_set *set); /* NULL and zeroed are fine */

/* The lod of a roughness for a shader that looks up the specular levels with
 * these facts: 0..levels - 1. */
double ibl_set_lod(const ibl_set_facts *facts, double roughness);

IBL_API_END
#ifdef __cplusplus
}
#endif

#endif
