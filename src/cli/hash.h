/* SPDX-License-Identifier: MIT */
#ifndef CLI_HASH_H
#define CLI_HASH_H

#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>

#include <ibl/ibl.h>

#include "common/option.h"

/* Hashes of contents: 128 bits of XXH3, as 32 hexadecimal digits and a NUL.
 * They detect changes, not forgery. */
enum {
    IBL_HASH_SIZE = 33
};

void ibl_hash_bytes(const void *bytes, size_t size, char hash[IBL_HASH_SIZE]);

/* Hashes a regular file. False, with errno: it cannot be read; EISDIR: it is a
 * directory; EINVAL: it is neither. */
bool ibl_hash_file(const char *path, char hash[IBL_HASH_SIZE]);

/* Prints what decides what is made beside the inputs: program, arithmetic, and
 * the options of the command line that are not aside, in their tables' order.
 */
void ibl_print_settings(FILE *to, ibl_isa isa, const ibl_given *given);

#endif
