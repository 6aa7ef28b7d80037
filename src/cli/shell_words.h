/* SPDX-License-Identifier: MIT */
/* Words of command lines, as a shell sees them. */
#ifndef CLI_SHELL_WORDS_H
#define CLI_SHELL_WORDS_H

/*
 * Splits text into words at blanks. '...' and "..." keep blanks; a backslash
 * keeps the next character (not inside '...'). Nothing is expanded. The words
 * end with NULL and are one block, which the caller must free. NULL: a quote is
 * not closed.
 */
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
