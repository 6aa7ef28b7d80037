/* SPDX-License-Identifier: MIT */
/* Files for tests: made by other programs, loaded, damaged. */
#ifndef FILES_H
#define FILES_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "ibl/io.h"
#include "io/rows.h"

/* Path of a file in test_dir(), until the running test ends. */
const char *file_path(const char *name);
/* Runs a shell command in test_dir(), quietly; true if it exits with 0. */
bool file_run(const char *fmt, ...) __attribute__((format(printf, 1, 2)));
/* Whether a program is there to be run. */
bool file_have(const char *program);
/* A file's bytes until the running test ends; exits if it cannot be read. */
unsigned char *file_load(const char *path, size_t *size);
bool file_save(const char *path, const void *bytes, size_t size);
/* Four bytes of a header, the least significant first. */
uint32_t file_u32(const unsigned char *p);
void file_set_u32(unsigned char *p, uint32_t value);
/* Writes an image as PFM, whose rows run from the bottom. */
bool file_save_pfm(const char *path, const ibl_image *img);

/* Writes uncompressed OpenEXR floats B, G, R, and A if alpha is not NULL. */
bool file_save_exr(const char *path, const ibl_image *img, const float *alpha);

/* All rows, in calls of a few at a time. */
ibl_status file_read_rows(ibl_rows *rows, ibl_image *img);

/* A file of this build, beside the folder of the test programs; NULL if it is
 * not there. Static storage, overwritten by each call. */
const char *file_built(const char *name);
/* The image bridge of this build; NULL if it has not been built. */
const char *file_bridge(void);
/* Skips the running test without that bridge and oiiotool. */
void file_need_oiio(void);
/* A context with messages in *kept and that bridge (NULL: none); or exits. */
ibl_ctx *file_ctx(int threads, void *kept, const char *bridge);

#endif
