/* SPDX-License-Identifier: MIT */
#ifndef CLI_START_H
#define CLI_START_H

#include "cli/console.h"
#include "cli/option.h"

/* A context for the settings, that reports to the console. */
ibl_status ibl_start(const ibl_common *common, ibl_console *console,
                     ibl_ctx **ctx);

#endif
