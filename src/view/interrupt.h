/* SPDX-License-Identifier: MIT */
/* A signal that ends the program leaves nothing that is half written. */
#ifndef VIEW_INTERRUPT_H
#define VIEW_INTERRUPT_H

#include "ibl/io.h"

/* Catches what ends a program by default, where it was not ignored already. */
void view_interrupt_catch(void);
/* The outputs that a signal aborts; NULL: none. */
void view_interrupt_guard(ibl_outputs *outputs);
/* Removes what of them was not committed, frees them, and guards none. */
void view_interrupt_end(ibl_outputs *outputs);

#endif
