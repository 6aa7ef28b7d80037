/* SPDX-License-Identifier: MIT */
#ifndef IBL_IO_FILE_HASH_H
#define IBL_IO_FILE_HASH_H

#include "ibl/io.h"
#include "io/input.h"

/* XXH3 of 128 bits of the input's bytes, in hexadecimal digits. */
ibl_status ibl_file_hash(const ibl_input *in, char hash[IBL_FILE_HASH]);

#endif
