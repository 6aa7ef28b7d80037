/* SPDX-License-Identifier: MIT */
/* What the harnesses of libFuzzer share. Each is a file fuzz_NAME.c with
 * fuzz_begin and fuzz_one. */
#ifndef FUZZ_H
#define FUZZ_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "ibl/io.h"

/* The bytes of a run. The last ones are choices, the rest a file, so that a
 * file with some bytes behind it is a seed. */
typedef struct fuzz_input {
    const unsigned char *bytes;
    size_t size;
} fuzz_input;

/* Runs once before all others; may be empty. */
void fuzz_begin(void);
/* A run. */
void fuzz_one(fuzz_input in);

/* Removes the last byte; returns it modulo count. 0 if there is none. */
int fuzz_choice(fuzz_input *in, int count);

/* Ends the program, as a crash does, if expr is false. */
#define FUZZ_NEED(expr) ((expr) ? (void)0 : fuzz_fail(__LINE__, #expr))
void fuzz_fail(int line, const char *expr) __attribute__((noreturn));

/* The context of a run: one thread, and by the length of the input the kernels
 * of plain C or those of this CPU. */
extern ibl_ctx *fuzz_ctx;
/* Checks that an error left a line since the last call, and success none. */
void fuzz_said(bool failed);

/* The path of a name in a folder of this process. Static storage, overwritten
 * by the fourth call after it. */
const char *fuzz_path(const char *name);
/* Writes such a file and returns its path. */
const char *fuzz_save(const char *name, const void *bytes, size_t size);

/* While this is above 0, no read returns more bytes. */
extern size_t fuzz_longest_read;

/* A texture of such texels without keys: random bytes, or 0.5 in floats.
 * The caller must free it. */
ibl_texture fuzz_texture(ibl_pixel pixel, int size, int levels, int faces);

#endif
