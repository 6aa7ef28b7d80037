/* SPDX-License-Identifier: MIT */
/* Words of command lines, as a shell sees them. */
#ifndef CLI_SHELL_WORDS_H
#define CLI_SHELL_WORDS_H

/*
 * The words of text: separated by blanks, '...' and "..." keep blanks, a
 * backslash keeps the next character (not inside '...'). Nothing is expanded.
 * Ended by NULL; one block for free(). NULL: an open quote, or no memory.
 */
char **ibl_words_split(const char *text);

/* word so that a shell reads it as it is; the caller's to free, NULL: no
 * memory. */
char *ibl_words_quote(const char *word);

/* A replacement of {name} by text. */
typedef struct ibl_placeholder {
    const char *name, *text;
} ibl_placeholder;

/* text with every {name} out of count ones replaced; the rest, other braces
 * too, stays. The caller's to free, NULL: no memory. */
char *ibl_words_fill(const char *text, const ibl_placeholder *holders,
                     int count);

#endif
