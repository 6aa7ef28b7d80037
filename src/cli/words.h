/* SPDX-License-Identifier: MIT */
/* Words of our own command lines, lists, and texts with places to fill in. */
#ifndef CLI_WORDS_H
#define CLI_WORDS_H

#include <stdbool.h>

/* Splits text into words at blanks; quotes are characters like others. The
 * words end with NULL and are one block, which the caller must free. */
char **ibl_words_split(const char *text);

/* The names, with commas between them, that a list has, as bits by their place
 * in `names`, which ends with NULL. False: it has another, or none. */
bool ibl_words_bits(const char *list, const char *const *names, unsigned *bits);

/* {name} is replaced by text. */
typedef struct ibl_placeholder {
    const char *name, *text;
} ibl_placeholder;

/* Copies text with the {name} of count holders replaced; other braces stay. The
 * caller must free the result. */
char *ibl_words_fill(const char *text, const ibl_placeholder *holders,
                     int count);

#endif
