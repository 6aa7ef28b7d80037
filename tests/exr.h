/* SPDX-License-Identifier: MIT */
/* What the tests of the EXR reader share. */
#ifndef TESTS_EXR_H
#define TESTS_EXR_H

#include <OpenEXR/openexr.h>

#include "ibl/io.h"
#include "io/rows.h"
#include "test.h"

/* What the contexts of these tests say. */
extern test_messages test_exr_kept;

/* As oiiotool calls those that need no bridge, and pixels. */
extern const char *const test_exr_compressions[8], *const test_exr_types[3];

/* The context of these tests and test_exr_source(), which is s.pfm of
 * test_dir(); the test is skipped without the image bridge and oiiotool. */
extern ibl_ctx *test_exr_ctx;
extern ibl_image test_exr_img;
void test_exr_begin(int threads, int width, int height);

/* Values of every size, signs, zeros, denormal halves; no two rows alike. */
ibl_image test_exr_source(ibl_ctx *ctx, int width, int height);

/* A number for each pixel and channel, exact as a half. */
float test_exr_pattern(int x, int y, int channel);

typedef struct test_exr_channel {
    const char *name;
    exr_pixel_type_t type;
    int step;          /* one sample for so many rows and columns */
    const float *data; /* the samples; NULL: test_exr_pattern, R being 0 */
} test_exr_channel;

/* Writes a file by OpenEXRCore, a chunk of scan lines at a time. Channels are
 * in the alphabet's order; chroma: NULL for none; envmap: -1 for none. */
bool test_exr_write(const char *path, int width, int height,
                    exr_compression_t compression,
                    const test_exr_channel *channels, int count,
                    const exr_attr_chromaticities_t *chroma, int envmap);

/* A file of test_dir() by the reader alone, pixels not mended, freed after the
 * running test; report: or NULL. Of bytes the caller frees img. */
ibl_status test_exr_decode(const char *name, const char *layer, int part,
                           ibl_image *img, ibl_read_report *report);
ibl_status test_exr_decode_bytes(const void *bytes, size_t size,
                                 const ibl_read_options *opts, ibl_image *img,
                                 ibl_read_report *report);

/* Checks that a file is refused with these words, * between them for any. */
void test_exr_refused(const char *name, const char *layer, int part,
                      ibl_status want, const char *words);

/* To the bit. */
bool test_exr_same(const ibl_image *a, const ibl_image *b);

#endif
