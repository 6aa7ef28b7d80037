/* SPDX-License-Identifier: MIT */
/* Signals and the outputs that they abort. Interrupted, a program leaves no
 * temporary files and dies of the signal, at once. */
#ifndef COMMON_SIGNALS_H
#define COMMON_SIGNALS_H

#include <signal.h>
#include <sys/types.h>

#include "ibl/io.h"

/* Catches what ends a program by default, from HUP to XCPU, where it was not
 * ignored already. */
void ibl_signals_catch(void);
/* Gives those signals to another handler, or to SIG_DFL. */
void ibl_signals_pass(void (*handler)(int number));
/* The process group that a signal kills along with us, led by a child of this
 * process; 0: none. */
void ibl_signals_group(pid_t group);
/* Holds those signals back, or lets them through again. */
void ibl_signals_hold(void);
void ibl_signals_release(void);

/* Outputs that a signal aborts, until they are committed or have ended. */
ibl_status ibl_start_outputs(ibl_ctx *ctx, int sync, ibl_outputs **outputs);
/* A signal waits until all of them are in place. */
ibl_status ibl_commit_outputs(ibl_outputs *outputs);
/* Removes what was not committed, and frees them; NULL is fine. */
void ibl_end_outputs(ibl_outputs *outputs);

#endif
