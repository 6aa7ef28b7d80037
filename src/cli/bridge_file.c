/* SPDX-License-Identifier: MIT */
#include "cli/bridge_file.h"

#include <string.h>
#include <unistd.h>

char *ibl_bridge_beside(void)
{
    static const char name[] = "libiblbridge.so";
    char path[4096];
    const ssize_t length = readlink("/proc/self/exe", path, sizeof path);

    if (length <= 0 || (size_t)length >= sizeof path - sizeof name)
        return NULL;
    path[length] = '\0';
    strcpy(strrchr(path, '/') + 1, name);
    return access(path, R_OK) ? NULL : strdup(path);
}
