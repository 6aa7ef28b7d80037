/* SPDX-License-Identifier: MIT */
#ifndef IBL_IO_SNIFF_H
#define IBL_IO_SNIFF_H

#include <stddef.h>

/* Tells by the first bytes what kind of image the bridge would have to read:
 * *kind is its name for people, *reader OpenImageIO's; NULL both if the bytes
 * are no known signature. Strings are static. */
void ibl_sniff(const unsigned char *bytes, size_t size, const char **kind,
               const char **reader);

#endif
