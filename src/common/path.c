/* SPDX-License-Identifier: MIT */
#include "common/path.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "json/text.h"

const char *ibl_path_name(const char *path)
{
    const char *slash = strrchr(path, '/');
    return slash ? slash + 1 : path;
}

int ibl_path_same(const char *a, const char *b)
{
    struct stat x, y;

    if (stat(a, &x) || stat(b, &y))
        return errno == ENOENT || errno == ENOTDIR ? 0 : -1;
    return x.st_dev == y.st_dev && x.st_ino == y.st_ino;
}

char *ibl_path_join(const char *directory, const char *name)
{
    const char *slash = directory[strlen(directory) - 1] == '/' ? "" : "/";

    return ibl_format("%s%s%s", directory, slash, name);
}

char *ibl_path_beside(const char *file, const char *name)
{
    const char *last = ibl_path_name(file);
    const int length = *name != '/' ? (int)(last - file) : 0;

    return ibl_format("%.*s%s", length, file, name);
}

bool ibl_path_is_open(const char *path)
{
    char *directory = ibl_path_beside(path, ".");
    const bool ok = directory && !access(directory, W_OK | X_OK);
    const int saved = errno;

    free(directory);
    errno = saved;
    return ok;
}

bool ibl_uri_decode(char *text)
{
    char *to = text;

    for (const char *at = text; *at; at++) {
        unsigned byte = (unsigned char)*at;
        if (*at == '%') {
            if (strspn(at + 1, "0123456789abcdefABCDEF") < 2 ||
                sscanf(at + 1, "%2x", &byte) != 1 || !byte)
                return false;
            at += 2;
        }
        *to++ = (char)byte;
    }
    *to = '\0';
    return true;
}

const char *ibl_bridge_beside(void)
{
    /* In a build; installed under any prefix. */
    static const char *const places[] = {"libiblbridge.so",
                                         "../lib/iblbake/libiblbridge.so"};
    static char path[2304];
    char program[2048];
    const ssize_t length = readlink("/proc/self/exe", program, sizeof program);

    if (length <= 0 || (size_t)length >= sizeof program)
        return NULL;
    program[length] = '\0';
    *strrchr(program, '/') = '\0';
    for (size_t i = 0; i < sizeof places / sizeof *places; i++) {
        snprintf(path, sizeof path, "%s/%s", program, places[i]);
        if (!access(path, R_OK))
            return path;
    }
    return NULL;
}
