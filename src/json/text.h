/* SPDX-License-Identifier: MIT */
/* Texts, and lists of words, each ended by NULL. */
#ifndef IBL_JSON_TEXT_H
#define IBL_JSON_TEXT_H

#include <stdio.h>

/* Prints into a string that the caller must free; NULL: no memory. */
char *ibl_format(const char *fmt, ...) __attribute__((format(printf, 1, 2)));

enum {
    IBL_LINE_BYTES = 2 * 4096 + 1024 /* two paths and a message about them */
};

/* "a, b or c" */
void ibl_names_text(const char *const *names, char *text, size_t size);
/* The index of word in names; -1: not found. */
int ibl_names_find(const char *const *names, const char *word);

#endif
