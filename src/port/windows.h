/* SPDX-License-Identifier: MIT */
/* What the C library of Windows lacks and of which the C library of others has
 * the declarations; read before each file. */
#ifndef IBL_PORT_WINDOWS_H
#define IBL_PORT_WINDOWS_H

#include <stddef.h>

char *strcasestr(const char *text, const char *part);
void *memmem(const void *bytes, size_t size, const void *part, size_t length);

#endif
