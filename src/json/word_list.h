/* SPDX-License-Identifier: MIT */
/* Lists of words, each ended by NULL. */
#ifndef IBL_JSON_WORD_LIST_H
#define IBL_JSON_WORD_LIST_H

#include <stddef.h>

/* "a, b or c" */
void ibl_names_text(const char *const *names, char *text, size_t size);
/* The index of word in names; -1: not found. */
int ibl_names_find(const char *const *names, const char *word);

#endif
