/* SPDX-License-Identifier: MIT */
/* Signals and the outputs that they abort. An interrupted program dies of the
 * signal at once and leaves no temporary files. */
#ifndef COMMON_SIGNALS_H
#define COMMON_SIGNALS_H

#include <signal.h>

#include "ibl/io.h"

/* Catches the signals that end a program by default, HUP to XCPU, except those
 * that are ignored already. Ignores XFSZ. */
void ibl_signals_catch(void);
/* Sets another handler, SIG_DFL or SIG_IGN for those signals. */
void ibl_signals_pass(void (*handler)(int number));
/* Block and unblock those signals. */
void ibl_signals_hold(void);
void ibl_signals_release(void);

/* Makes outputs that a signal aborts, until they are ended. */
ibl_status ibl_start_outputs(ibl_ctx *ctx, int sync, ibl_outputs **outputs);
/* Removes files not committed and frees the outputs; NULL is fine. */
void ibl_end_outputs(ibl_outputs *outputs);

#endif
