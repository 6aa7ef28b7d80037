/* SPDX-License-Identifier: MIT */
/*
 * Pictures of light, which other programs open:
 *   EXR  OpenEXR, halves or floats, ZIP, linear, with chromaticities and, of
 *        equirectangular maps, envmap
 *   HDR  Radiance RGBE, run lengths, linear
 *   PNG  8 bits, sRGB's curve after a tone curve
 * Files have R, G and B; of tables of two channels B is 0.
 */
#ifndef ENGINE_PICTURE_H
#define ENGINE_PICTURE_H

#include "engine/png.h"

typedef enum ibl_picture {
    IBL_PICTURE_NONE,
    IBL_PICTURE_EXR,
    IBL_PICTURE_HDR,
    IBL_PICTURE_PNG
} ibl_picture;

/* What PNG makes of light. */
typedef enum ibl_tone {
    IBL_TONE_FILM, /* a curve of film */
    IBL_TONE_CLIP, /* 1 is white, and so is what is above */
    IBL_TONE_RAW   /* of tables: no curve, sRGB's neither */
} ibl_tone;

/* "film", "clip", NULL */
extern const char *const ibl_tone_names[];

/* What a component of light becomes, 0..1. */
double ibl_tone_value(ibl_tone tone, double x);

typedef struct ibl_picture_options {
    ibl_picture kind;
    ibl_tone tone; /* of PNG */
    bool cross;    /* the faces of a cube as one, as IBL_INPUT_HCROSS has them;
                      else a picture each */
    bool halves;   /* of EXR; else floats */
    bool equirect; /* it is such a map */
    const ibl_texture *about; /* has primaries and keys, which EXR gets as
                                 attributes; NULL: Rec.709, none */
} ibl_picture_options;

/* Encodes RGB floats, rows from the top. name is for messages; *out is to be
 * freed, also after an error. */
ibl_status ibl_picture_encode(ibl_ctx *ctx, const char *name,
                              const ibl_picture_options *o, int width,
                              int height, const float *rgb, ibl_blob *out);

/* "exr", "hdr" or "png". */
const char *ibl_picture_extension(ibl_picture kind);
/* What a picture's pixels are: "rgbe", "rgb8"; NULL: those of the texture. */
const char *ibl_picture_pixel(ibl_picture kind);

/* The name of picture `index` of a texture with so many levels and pictures of
 * each: STEM[_LEVEL][_FACE].EXT, the level of several, the face (px, nx, ..) of
 * six. The caller must free it; NULL: no memory. */
char *ibl_picture_name(const char *stem, ibl_picture kind, int levels, int each,
                       int index);

/* Rounds texels of RGBA32F to what HDR holds; does nothing for others. */
void ibl_picture_round(ibl_picture kind, ibl_texture *tex);
/* Encodes picture `index` of a texture of one layer, which is not of blocks. */
ibl_status ibl_picture_of_texture(ibl_ctx *ctx, const char *name,
                                  const ibl_texture *tex,
                                  const ibl_picture_options *o, int index,
                                  ibl_blob *out);

#endif
