/* SPDX-License-Identifier: MIT */
/* Hashes of contents in pieces; ibl/io.h has those of whole ones. */
#ifndef CORE_HASH_H
#define CORE_HASH_H

#include "ibl/io.h"

/* A hash of several pieces: begin, add each, end. */
typedef struct ibl_hash {
    _Alignas(64) unsigned char state[576]; /* XXH3's own */
} ibl_hash;
void ibl_hash_begin(ibl_hash *h);
void ibl_hash_add(ibl_hash *h, const void *bytes, size_t size);
void ibl_hash_end(const ibl_hash *h, char text[IBL_FILE_HASH]);

#endif
