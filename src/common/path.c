/* SPDX-License-Identifier: MIT */
#include "common/path.h"

#include <ctype.h>
#include <dirent.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "port/port.h"
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
    const bool drive = isalpha((unsigned char)*name) && name[1] == ':' &&
                       (name[2] == '/' || name[2] == '\\');
    const int length = *name == '/' || drive ? 0 : (int)(last - file);

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

static int by_bytes(const void *a, const void *b)
{
    return strcmp(*(char *const *)a, *(char *const *)b);
}

int ibl_path_list(const char *folder, bool (*want)(const char *name),
                  char ***names)
{
    DIR *dir = opendir(folder);
    const struct dirent *entry;
    char **list = NULL, **more = NULL;
    int count = 0;
    bool ok = dir;

    while (ok && (entry = readdir(dir))) {
        if (!want(entry->d_name))
            continue;
        more = realloc(list, ((size_t)count + 1) * sizeof *list);
        list = more ? more : list;
        ok = more && (list[count] = strdup(entry->d_name));
        count += ok;
    }
    if (dir)
        closedir(dir);
    while (!ok && count)
        free(list[--count]);
    if (count)
        qsort(list, (size_t)count, sizeof *list, by_bytes);
    *names = list;
    return ok ? count : -1;
}

size_t ibl_uri_bytes(char *text)
{
    char *to = text;

    for (const char *at = text; *at; at++) {
        unsigned byte = (unsigned char)*at;
        if (*at == '%' && strspn(at + 1, "0123456789abcdefABCDEF") >= 2 &&
            sscanf(at + 1, "%2x", &byte) == 1)
            at += 2;
        *to++ = (char)byte;
    }
    *to = '\0';
    return (size_t)(to - text);
}

bool ibl_uri_decode(char *text)
{
    return ibl_uri_bytes(text) == strlen(text);
}

bool ibl_path_of_part(const char *name, char path[IBL_PART_BYTES])
{
    /* In a build, and of its tests; installed under any prefix. */
    static const char *const places[] = {"", "../lib/iblbake/", "../"};
    char program[IBL_PORT_PATH];

    if (!realpath("/proc/self/exe", program))
        return false;
    *strrchr(program, '/') = '\0';
    for (size_t i = 0; i < sizeof places / sizeof *places; i++) {
        snprintf(path, IBL_PART_BYTES, "%s/%s%s", program, places[i], name);
        if (!access(path, R_OK))
            return true;
    }
    return false;
}

const char *ibl_bridge_beside(void)
{
    static char path[IBL_PART_BYTES + 16];

    /* libiblexr.so is looked for beside it, and is in every build. */
    if (!ibl_path_of_part("libiblexr.so", path))
        return NULL;
    strcpy(strrchr(path, '/'), "/libiblbridge.so");
    return path;
}
