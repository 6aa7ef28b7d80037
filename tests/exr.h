/* SPDX-License-Identifier: MIT */
/* What the tests of the EXR reader share. */
#ifndef TESTS_EXR_H
#define TESTS_EXR_H

#include "ibl/io.h"
#include "io/rows.h"
#include "test.h"

/* What the contexts of these tests say. */
extern test_messages test_exr_kept;

/* As oiiotool calls those that need no bridge, and pixels. */
extern const char *const test_exr_compressions[8], *const test_exr_types[3];

/* Whether the image bridge and oiiotool are here; else the test is skipped. */
bool test_exr_ready(void);

/* Values of every size, signs, zeros, denormal halves; no two rows alike. */
ibl_image test_exr_source(ibl_ctx *ctx, int width, int height);

/* All rows, in calls of a few at a time, and what was found in each. */
ibl_status test_exr_read_rows(ibl_rows *rows, ibl_image *img);

/* The reader alone, pixels not mended. */
ibl_status test_exr_decode(ibl_ctx *ctx, const char *path, const char *layer,
                           int part, ibl_image *img, ibl_read_report *report);
ibl_status test_exr_decode_bytes(ibl_ctx *ctx, const void *bytes, size_t size,
                                 const ibl_read_options *opts, ibl_image *img,
                                 ibl_read_report *report);

/* To the bit. */
bool test_exr_same(const ibl_image *a, const ibl_image *b);

#endif
