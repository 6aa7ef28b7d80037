/* SPDX-License-Identifier: MIT */
/*
 * iblbake: NAME.json, the sidecar in which iblbake says what its files hold and
 * how they were made. iblbake(1) has its keys in FILES. iblview and iblbake
 * verify read it, and so can the loader of an engine.
 */
#ifndef IBL_SIDECAR_H
#define IBL_SIDECAR_H

#include "io.h"

#ifdef __cplusplus
extern "C" {
#endif
IBL_API_BEGIN

/* What a file of a bake holds. */
typedef enum ibl_content {
    IBL_CONTENT_SKYBOX,
    IBL_CONTENT_SPECULAR,
    IBL_CONTENT_IRRADIANCE,
    IBL_CONTENT_LUT,
    IBL_CONTENT_LOBE_TABLE
} ibl_content;

/* "skybox", "specular", "irradiance", "brdf_lut" or "lobe_lut", as in sidecars
 * and in the key iblbake.content; else "unknown". */
const char *ibl_content_name(ibl_content content);

/* A file, of one layer. Members that are 0 are not said, or their default. */
typedef struct ibl_sidecar_output {
    ibl_content content;
    const char *file;           /* its name, in the folder of the sidecar */
    const char *container;      /* ibl_container_name, or others' */
    const ibl_texture *texture; /* its shape and pixel; texels and keys are not
                                   looked at */
    const char *pixel;          /* of files that are no container; NULL: that of
                                   the texture */
    size_t bytes;               /* of the file, or of all its files */
    const char *hash;           /* ibl_outputs_hash of file; NULL: not known */
    const char *const *more;    /* names of the others, if there are several,
                                   after directories, which are left out */
    int more_count;
    /* Not of tables: */
    ibl_projection projection;           /* of a texture of one face */
    const ibl_texel_options *texels;     /* as encoded */
    const ibl_overflow_report *overflow; /* of encoding; of tables, too */
    const ibl_pixel_error *error;        /* of each level: ibl_texture_errors */
} ibl_sidecar_output;

/* What a sidecar is made of: options are those of the bake, NULL for the
 * defaults. Strings may have any bytes. */
typedef struct ibl_sidecar_options {
    const char *source; /* path of the environment */
    int width, height;  /* of the environment, as it was read */
    const ibl_read_options *read;
    const ibl_read_report *report;

    const ibl_specular_options *specular;
    const ibl_irradiance_options *irradiance;
    const ibl_lut_options *lut;
    const ibl_lobe_table_options *lobe_table;
    double yaw_deg;
    ibl_axes axes; /* of the outputs */
    int sh_degree; /* of made->sh; default 2 */
    /* The bake: of cubes only whether there is a specular one counts, and the
     * report is that of the chain in this sidecar's files. sh are in the axes
     * of the outputs (ibl_sh_turn_axes). */
    const ibl_bake_result *made;
    const ibl_light *lights; /* that were taken out, in the axes of the world */
    int light_count; /* 0..IBL_MAX_LIGHTS; default -1: none were looked for */

    const ibl_sidecar_output *outputs;
    int output_count;

    const char *revision;         /* of the program; NULL: not said */
    const char *target;           /* that the files are for, as of --target */
    const ibl_key_value *options; /* the choices of a user, in words; a value of
                                     NULL is true */
    int option_count;
    const char *more; /* text of a JSON object, whose members follow; NULL */
} ibl_sidecar_options;

ibl_sidecar_options ibl_sidecar_options_default(void);

/*
 * The text of a sidecar, the same for the same facts.
 *   *text  UTF-8, ended by a newline and NUL; free it with ibl_bytes_free
 * IBL_ERR_ARGUMENT: made, report, source or text is NULL; a number is out of
 * range; or more is no object. IBL_ERR_MEMORY, IBL_ERR_CANCELLED.
 */
ibl_status ibl_sidecar_text(ibl_ctx *ctx, const ibl_sidecar_options *facts,
                            char **text);

/*
 * Sets the keys by which iblbake's textures say what they hold, for viewers,
 * for iblbake verify, and for loaders that make their shaders' constants of
 * them (manual: iblbake-engines). Textures of the library have none until then.
 *   all of a bake   content, orientation, changes of colour, lights that were
 *                   taken out; pixel and quality of blocks
 *   specular        lobe, mapping, roughness of the levels, lod_scale and
 *                   lod_offset; of a bake how each level was made
 *   irradiance      irradiance_scale; of a bake method and step
 *   lut             axes, geometry, method
 *   lobe_table      axes, layers, roughness
 *   facts    those of the sidecar, without source and report. made NULL: keys
 *            that follow from the options alone, as of arrays of many bakes
 *   output   its content, and texels if the pixel is of blocks
 * IBL_ERR_ARGUMENT: a pointer is NULL or a number out of range. Others as of
 * ibl_texture_set.
 */
ibl_status ibl_texture_describe(ibl_ctx *ctx, ibl_texture *tex,
                                const ibl_sidecar_options *facts,
                                const ibl_sidecar_output *output);

IBL_API_END
#ifdef __cplusplus
}
#endif

#endif
