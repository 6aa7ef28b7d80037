/* SPDX-License-Identifier: MIT */
#include "common/path.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

const char *ibl_path_name(const char *path)
{
    const char *slash = strrchr(path, '/');
    return slash ? slash + 1 : path;
}

char *ibl_path_join(const char *directory, const char *name)
{
    const size_t size = strlen(directory) + strlen(name) + 2;
    char *path = malloc(size);

    if (path)
        snprintf(path, size, "%s%s%s", directory,
                 directory[strlen(directory) - 1] == '/' ? "" : "/", name);
    return path;
}

char *ibl_path_beside(const char *file, const char *name)
{
    const char *slash = strrchr(file, '/');
    const size_t length =
        slash && *name != '/' ? (size_t)(slash - file) + 1 : 0;
    char *path = malloc(length + strlen(name) + 1);

    if (path) {
        memcpy(path, file, length);
        strcpy(path + length, name);
    }
    return path;
}
