/* SPDX-License-Identifier: MIT */
/* EXR files by the reader alone, pixels not mended. */
#ifndef TESTS_EXR_H
#define TESTS_EXR_H

#include "ibl/io.h"
#include "io/rows.h"
#include "test.h"

/* Makes the context of these tests, whose messages are kept, and values of
 * every size, signs, zeros, denormal halves, no two rows alike, which are s.pfm
 * of test_dir(); skips the test without the image bridge and oiiotool. */
extern test_messages test_exr_kept;
extern ibl_ctx *test_exr_ctx;
extern ibl_image test_exr_img;
void test_exr_begin(int threads, int width, int height);

/* A file of test_dir(), or bytes; img is freed after the running test. report:
 * or NULL. */
ibl_status test_exr_decode(const char *name, const char *layer, int part,
                           ibl_image *img, ibl_read_report *report);
ibl_status test_exr_decode_bytes(const void *bytes, size_t size,
                                 const ibl_read_options *opts, ibl_image *img,
                                 ibl_read_report *report);

/* To the bit; not if one has failed. */
bool test_exr_same(const ibl_image *a, const ibl_image *b);

#endif
