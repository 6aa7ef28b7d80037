/* SPDX-License-Identifier: MIT */
/* Text in memory, and lists of words, each ended by NULL. */
#ifndef IBL_JSON_TEXT_H
#define IBL_JSON_TEXT_H

#include <stdio.h>

/* A stream into memory. Not open_memstream: if memory runs out, glibc's loses
 * text, and neither ferror nor fclose reports it. */
typedef struct ibl_memory_file {
    char *text;
    size_t size, room; /* bytes used and allocated */
} ibl_memory_file;

/* NULL: no memory. */
FILE *ibl_memory_open(ibl_memory_file *m);
/* Closes the stream. Returns its text, m->size bytes and a NUL, which the
 * caller must free; NULL: memory ran out, or to is NULL. */
char *ibl_memory_close(FILE *to, ibl_memory_file *m);

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
