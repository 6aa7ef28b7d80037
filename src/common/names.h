/* SPDX-License-Identifier: MIT */
/* Lists of the names that a value may be, each ended by NULL. */
#ifndef COMMON_NAMES_H
#define COMMON_NAMES_H

#include <stddef.h>

/* "a, b or c" */
void ibl_names_text(const char *const *names, char *text, size_t size);
/* The number of a word; -1: it is none of them. */
int ibl_names_find(const char *const *names, const char *word);

#endif
