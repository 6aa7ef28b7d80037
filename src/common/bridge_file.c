/* SPDX-License-Identifier: MIT */
#include "common/bridge_file.h"

#include <stdio.h>
#include <string.h>
#include <unistd.h>

char *ibl_bridge_beside(void)
{
    /* As built, and as installed under any prefix. */
    static const char *const places[] = {"libiblbridge.so",
                                         "../lib/iblbake/libiblbridge.so"};
    char program[2048], path[2304];
    const ssize_t length = readlink("/proc/self/exe", program, sizeof program);

    if (length <= 0 || (size_t)length >= sizeof program)
        return NULL;
    program[length] = '\0';
    *strrchr(program, '/') = '\0';
    for (size_t i = 0; i < sizeof places / sizeof *places; i++) {
        snprintf(path, sizeof path, "%s/%s", program, places[i]);
        if (!access(path, R_OK))
            return strdup(path);
    }
    return NULL;
}
