/* SPDX-License-Identifier: MIT */
/* Words of our own command lines, and texts with places to fill in. */
#ifndef CLI_WORDS_H
#define CLI_WORDS_H

/* Splits text into words at blanks; quotes are characters like others. The
 * words end with NULL and are one block, which the caller must free. */
char **ibl_words_split(const char *text);

/* {name} is replaced by text. */
typedef struct ibl_placeholder {
    const char *name, *text;
} ibl_placeholder;

/* Copies text with the {name} of count holders replaced; other braces stay. The
 * caller must free the result. */
char *ibl_words_fill(const char *text, const ibl_placeholder *holders,
                     int count);

#endif
