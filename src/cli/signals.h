/* SPDX-License-Identifier: MIT */
/* Interrupted, the program leaves no temporary files and dies of the signal,
 * at once: nothing waits for the bake. */
#ifndef CLI_SIGNALS_H
#define CLI_SIGNALS_H

#include <signal.h>
#include <sys/types.h>

#include <ibl/io.h>

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
