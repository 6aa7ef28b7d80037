/* SPDX-License-Identifier: MIT */
/* Names and numbers of the pixel formats in files. */
#ifndef IBL_IO_PIXEL_FORMAT_H
#define IBL_IO_PIXEL_FORMAT_H

#include <stddef.h>
#include <stdint.h>

#include "ibl/io.h"

/* The number of a format in each API; 0: the API has no such format. */
typedef struct ibl_layout {
    ibl_pixel pixel; /* the pixel format after reading */
    int block_bytes; /* in the file; 3 channels become 4 when read */
    int word_bytes;  /* size of the words that byte swapping reverses */
    uint32_t vk;     /* VkFormat */
    uint32_t dxgi;   /* DXGI_FORMAT */
    uint32_t d3d;    /* D3DFMT, stored in place of a FourCC */
    uint32_t gl_type, gl_format, gl_internal; /* 0: not in KTX 1.1 */
    int block_edge; /* in texels. If it is not 1, files have no gl_type, and
                       gl_format is the base format */
} ibl_layout;

enum {
    IBL_LAYOUT_RGB16F = IBL_PIXEL_COUNT, /* these can only be read */
    IBL_LAYOUT_RGB32F,
    IBL_LAYOUT_BC6H_SIGNED,
    IBL_LAYOUT_COUNT
};

/* Indexed by ibl_pixel; the formats that can only be read follow. */
extern const ibl_layout ibl_layouts[IBL_LAYOUT_COUNT];

/* Blocks along `texels` texels. */
static inline size_t ibl_layout_blocks(const ibl_layout *l, size_t texels)
{
    const size_t edge = (size_t)l->block_edge;
    return (texels + edge - 1) / edge;
}

/* The first layout whose member at this offset equals number; NULL: none, or
 * number is 0. */
const ibl_layout *ibl_layout_find(size_t member, uint32_t number);

/* Largest finite value of blue; ibl_pixel_max is for red and green. */
float ibl_pixel_max_blue(ibl_pixel pixel);

/* The alpha of texel i, its last word; 1 in formats without alpha. */
void ibl_pixel_set_alpha(ibl_pixel pixel, unsigned char *texels, size_t i,
                         float alpha);
float ibl_pixel_get_alpha(ibl_pixel pixel, const unsigned char *texels,
                          size_t i);

enum {
    IBL_MAX_SAMPLES = 6
};

/* A channel, mantissa or exponent of a texel, as KTX2 files describe it. */
typedef struct ibl_sample {
    uint16_t offset; /* in bits */
    uint8_t last_bit, channel;
    uint32_t position;     /* 0: centre of the texel */
    uint32_t lower, upper; /* encoded values of -1 or 0, and of 1 */
} ibl_sample;

/* The colour model of the Khronos data format specification. */
enum {
    IBL_MODEL_RGBSDA = 1,
    IBL_MODEL_BC6H = 133,
    IBL_MODEL_ASTC = 162,
    IBL_MODEL_UASTC_HDR = 167 /* KTX-Specification#216 */
};
int ibl_pixel_model(ibl_pixel pixel);

/* Fills in s; returns the number of samples. */
int ibl_pixel_samples(ibl_pixel pixel, ibl_sample s[IBL_MAX_SAMPLES]);

#endif
