/* SPDX-License-Identifier: MIT */
/* How files name and describe the pixel formats. */
#ifndef IBL_IO_PIXEL_FORMAT_H
#define IBL_IO_PIXEL_FORMAT_H

#include <stddef.h>
#include <stdint.h>

#include "ibl/io.h"

/* How each API calls a format. 0: it has no such format. */
typedef struct ibl_layout {
    ibl_pixel pixel; /* that it is read as */
    int texel_bytes; /* in the file; 3 channels become 4 when read */
    int word_bytes;  /* that a change of byte order reverses */
    uint32_t vk;     /* VkFormat */
    uint32_t dxgi;   /* DXGI_FORMAT */
    uint32_t d3d;    /* D3DFMT, in place of a FourCC */
    uint32_t gl_type, gl_format, gl_internal;
} ibl_layout;

enum {
    IBL_LAYOUT_RGB16F = IBL_PIXEL_COUNT, /* only read */
    IBL_LAYOUT_RGB32F,
    IBL_LAYOUT_COUNT
};

/* By ibl_pixel, then those that are only read. */
extern const ibl_layout ibl_layouts[IBL_LAYOUT_COUNT];

/* The layout whose member at an offset is number; NULL: none, or number is 0.
 */
const ibl_layout *ibl_layout_find(size_t member, uint32_t number);

/* Largest finite value of blue; ibl_pixel_max is that of red and green. */
float ibl_pixel_max_blue(ibl_pixel pixel);

/* The alpha of texel i, which is its last word; 1 in pixels without. */
void ibl_pixel_set_alpha(ibl_pixel pixel, unsigned char *texels, size_t i,
                         float alpha);
float ibl_pixel_get_alpha(ibl_pixel pixel, const unsigned char *texels,
                          size_t i);

enum {
    IBL_MAX_SAMPLES = 6
};

/* A part of a texel, as the data format descriptor of a KTX2 file has it. */
typedef struct ibl_sample {
    uint16_t offset; /* in bits */
    uint8_t last_bit, channel;
    uint32_t position;     /* 0: the texel's centre */
    uint32_t lower, upper; /* -1 or 0, and 1, as the part encodes them */
} ibl_sample;

/* Fills in s; returns the count. */
int ibl_pixel_samples(ibl_pixel pixel, ibl_sample s[IBL_MAX_SAMPLES]);

#endif
