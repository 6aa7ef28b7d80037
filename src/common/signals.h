/* SPDX-License-Identifier: MIT */
/* Programs that a signal or missing memory ends leave no temporary files. */
#ifndef COMMON_SIGNALS_H
#define COMMON_SIGNALS_H

/* First of all in main. Opens standard streams that are closed. Catches the
 * signals that end a program by default, HUP to XCPU, except those that are
 * ignored already: it dies of them after ibl_outputs_abort_all. Ignores XFSZ:
 * write() then fails at a file-size limit, and that is reported. From then on
 * jansson's memory is ibl_need's, too. */
void ibl_signals_catch(int argc, char **argv);

/* Returns p. NULL, which means that there was no memory for it: prints a line,
 * removes temporary files and ends the program with status 1. */
void *ibl_need(void *p) __attribute__((returns_nonnull));

/* Appends to a text, NULL at first, which the caller must free. Ends the
 * program in the same way. */
void ibl_append(char **text, const char *fmt, ...)
    __attribute__((format(printf, 2, 3)));

#endif
