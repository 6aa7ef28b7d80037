/* SPDX-License-Identifier: MIT */
/* What every command sets up: a context, outputs, and signals. Interrupted,
 * the program leaves no temporary files and dies of the signal, at once. */
#ifndef CLI_SESSION_H
#define CLI_SESSION_H

#include <signal.h>
#include <sys/types.h>

#include "cli/common_options.h"
#include "cli/console.h"

/* A context for the settings, that reports to the console. */
ibl_status ibl_start(const ibl_common *common, ibl_console *console,
                     ibl_ctx **ctx);

/* Outputs that a signal aborts, until they are committed or have ended. */
ibl_status ibl_start_outputs(ibl_ctx *ctx, int sync, ibl_outputs **outputs);
/* A signal waits until all of them are in place. */
ibl_status ibl_commit_outputs(ibl_outputs *outputs);
/* Removes what was not committed, and frees them; NULL is fine. */
void ibl_end_outputs(ibl_outputs *outputs);

/* Adds a level to the sum of several: all their texels, and the largest
 * shares. */
void ibl_overflow_add(const ibl_overflow_level *level, ibl_overflow_level *sum);
/* Warns of a file whose levels together overflow, if they do. */
void ibl_warn_of_overflow(ibl_console *console, const char *file,
                          ibl_pixel pixel, ibl_overflow overflow,
                          const ibl_overflow_level *sum);

/* Warns of levels with so few texels that lookups between them are wrong. */
void ibl_warn_of_small_faces(ibl_console *console,
                             const ibl_specular_layout *layout);

/* Catches what ends a program by default, from HUP to XCPU, where it was not
 * ignored already. */
void ibl_signals_catch(void);
/* Gives those signals to another handler, or to SIG_DFL. */
void ibl_signals_pass(void (*handler)(int number));
/* The set that a signal aborts; NULL: none. */
void ibl_signals_guard(ibl_outputs *outputs);
/* The process group that a signal kills along with us, led by a child of this
 * process; 0: none. */
void ibl_signals_group(pid_t group);
/* Holds those signals back, or lets them through again. */
void ibl_signals_hold(void);
void ibl_signals_release(void);

#endif
