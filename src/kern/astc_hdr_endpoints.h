/* SPDX-License-Identifier: MIT */
/*
 * ASTC's HDR colours. A texel lies between two endpoints, on a scale on which
 * an octave is 2048 steps ("q" below): 5 bits of exponent, 11 of mantissa, of
 * which three straight pieces approximate a logarithm. Endpoints have the upper
 * 12 bits of it. Khronos Data Format Specification 1.3, sections 23.14, 23.15
 * and 23.18.
 */
#ifndef IBL_KERN_ASTC_HDR_ENDPOINTS_H
#define IBL_KERN_ASTC_HDR_ENDPOINTS_H

#include <stdint.h>

/* The half, as bits, of q in [0, 65535]; at most the largest finite one. */
static inline uint16_t ibl_astc_half(int q)
{
    const int m = q & 2047;
    const int mantissa = m < 512    ? 3 * m
                         : m < 1536 ? 4 * m - 512
                                    : 5 * m - 2048;
    const int half = (q >> 11) << 10 | mantissa >> 3;
    return (uint16_t)(half < 0x7C00 ? half : 0x7BFF);
}

/*
 * The endpoint modes that HDR textures want.
 *   IBL_ASTC_SCALE   4 values: the brighter endpoint, and how much darker the
 *                    other is, the same in all channels
 *   IBL_ASTC_DIRECT  6 values: both endpoints
 * Each has forms, which share the bits of the values otherwise among fields:
 * the more precise, the nearer the channels must be. The last form of each has
 * no differences between channels.
 */
enum {
    IBL_ASTC_SCALE = 7,
    IBL_ASTC_DIRECT = 11,
    IBL_ASTC_SCALE_FORMS = 6,
    IBL_ASTC_DIRECT_FORMS = 9
};

/* A field of more bits than its value's byte has room for keeps some in others,
 * in these places, in turn. A code is a field, times 16, plus one of its bits.
 */
enum {
    IBL_ASTC_PLACES = 7
};
typedef struct ibl_astc_form {
    unsigned char drop;    /* a field's last bit is bit `drop` of 12 */
    unsigned char bits[6]; /* of the fields; the last two of
                              IBL_ASTC_DIRECT are signed */
    unsigned char codes[IBL_ASTC_PLACES];
} ibl_astc_form;
extern const ibl_astc_form ibl_astc_scale_forms[IBL_ASTC_SCALE_FORMS];
extern const ibl_astc_form ibl_astc_direct_forms[IBL_ASTC_DIRECT_FORMS - 1];
/* The places: a value, times 16, plus one of its bits. */
extern const unsigned char ibl_astc_scale_places[IBL_ASTC_PLACES];
extern const unsigned char ibl_astc_direct_places[IBL_ASTC_PLACES];

/* The largest endpoint below Inf. */
#define IBL_ASTC_LARGEST 3967

/* The endpoints, 12 bits each, of the 4 or 6 values of a mode. */
void ibl_astc_line_ends(int mode, const unsigned char *values, int e[2][3]);

#endif
