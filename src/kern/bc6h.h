/* SPDX-License-Identifier: MIT */
/*
 * BC6H: blocks of 4x4 texels of 3 halves in 16 bytes. Sources: Direct3D 11.3
 * functional specification, section 19.5.14 (BC6H); Khronos Data Format
 * Specification 1.3, section 20.2 (BPTC, floating-point).
 */
#ifndef IBL_KERN_BC6H_H
#define IBL_KERN_BC6H_H

#include "kern/blocks.h"
#include "kern/isa.h"

/* The largest half, which is the format's largest value too. */
#define IBL_BC6H_MAX 65504.0f

/* Encodes to BC6H_UF16. All versions give the same bytes. */
typedef struct ibl_bc6h_dsp {
    ibl_encode_blocks_fn *encode;
} ibl_bc6h_dsp;

IBL_DECLARE_KERNEL(ibl_bc6h);

/* BC6H_UF16, and BC6H_SF16 for files of others. A block of a reserved mode is
 * not valid; its texels are 0. Unsigned texels are never Inf or NaN; signed
 * ones can be -Inf. */
ibl_decode_block_fn ibl_bc6h_decode_block, ibl_bc6h_decode_signed_block;

#endif
