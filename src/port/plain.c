/* SPDX-License-Identifier: MIT */
/* Systems where the program loads nothing: OpenEXRCore is a part of it. */
#include "port/port.h"

#include <string.h>

#include "io/bridge/openexr.h"

const bool ibl_port_loads = false;

bool ibl_port_load(const char *library, const char *name, void *function,
                   char why[IBL_PORT_WHY])
{
    ibl_openexr_unpack *const unpack = ibl_openexr_unpack_1;

    (void)library;
    strcpy(why, "there is none");
    if (strcmp(name, IBL_OPENEXR_UNPACK) != 0)
        return false;
    memcpy(function, &unpack, sizeof unpack);
    return true;
}

/* What waits can be ended by Ctrl-C there. */
bool ibl_port_readable(int file, int milliseconds)
{
    (void)file;
    (void)milliseconds;
    return true;
}

bool ibl_port_flush_folder(const char *path)
{
    (void)path;
    return true;
}
