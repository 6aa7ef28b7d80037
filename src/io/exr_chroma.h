/* SPDX-License-Identifier: MIT */
#ifndef IBL_IO_EXR_CHROMA_H
#define IBL_IO_EXR_CHROMA_H

/* Turns count pixels of Y RY BY to R G B; luma: the weights of R, G, B in Y. */
void ibl_exr_line_to_rgb(const float luma[3], float *p, int count);

#endif
