/* SPDX-License-Identifier: MIT */
#include "common/json_load.h"

#include <ctype.h>
#include <errno.h>
#include <fcntl.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static void *fail(ibl_json_why *why, bool damaged, const char *fmt, ...)
    __attribute__((format(printf, 3, 4)));
static void *fail(ibl_json_why *why, bool damaged, const char *fmt, ...)
{
    va_list ap;

    va_start(ap, fmt);
    vsnprintf(why->line, sizeof why->line, fmt, ap);
    va_end(ap);
    why->damaged = damaged;
    return NULL;
}

static void *no_memory(const char *path, ibl_json_why *why)
{
    return fail(why, false, "%s: no memory to read it", path);
}

/* ---- bytes ------------------------------------------------------------- */

static void *too_large(const char *path, ibl_json_why *why)
{
    return fail(why, true, "%s: over %d MiB, which no such file has", path,
                IBL_JSON_BYTES >> 20);
}

/* Reads until the end, whatever size the system reported. */
static char *read_all(int fd, const char *path, size_t *size, ibl_json_why *why)
{
    char *bytes = NULL;
    size_t room = 0;

    for (*size = 0;;) {
        if (*size > IBL_JSON_BYTES) {
            free(bytes);
            return too_large(path, why);
        }
        if (room - *size < 2) {
            char *more = realloc(bytes, room = 2 * room + 4096);
            if (!more) {
                free(bytes);
                return no_memory(path, why);
            }
            bytes = more;
        }
        const ssize_t got = read(fd, bytes + *size, room - *size - 1);
        if (got < 0 && errno != EINTR) {
            free(bytes);
            return fail(why, false, "%s: cannot be read: %s", path,
                        strerror(errno));
        }
        if (!got)
            break;
        *size += got > 0 ? (size_t)got : 0;
    }
    bytes[*size] = '\0';
    return bytes;
}

char *ibl_json_bytes(const char *path, size_t *size, ibl_json_why *why)
{
    /* A FIFO would be waited for. */
    const int fd = open(path, O_RDONLY | O_NONBLOCK | O_NOCTTY | O_CLOEXEC);
    struct stat st;
    char *bytes = NULL;

    if (fd < 0 || fstat(fd, &st))
        fail(why, false, "%s: cannot be read: %s", path, strerror(errno));
    else if (S_ISDIR(st.st_mode))
        fail(why, false, "%s: is a directory: give the name of a file in it",
             path);
    else if (!S_ISREG(st.st_mode))
        fail(why, false,
             "%s: is no file, but a pipe or a device: give the name of a file",
             path);
    else if (st.st_size > IBL_JSON_BYTES)
        too_large(path, why);
    else
        bytes = read_all(fd, path, size, why);
    if (fd >= 0)
        close(fd);
    return bytes;
}

/* ---- JSON -------------------------------------------------------------- */

/* Whether memory was missing: jansson reports nothing then, or an invalid
 * token. */
static _Thread_local bool starved;

static void *allocate(size_t size)
{
    void *p = malloc(size);

    starved |= !p;
    return p;
}

json_t *ibl_json_parse(const char *path, const char *bytes, size_t size,
                       size_t flags, ibl_json_why *why)
{
    json_error_t error;

    starved = false;
    json_set_alloc_funcs(allocate, free);
    json_t *root = json_loadb(bytes, size, flags, &error);
    if (root && !starved)
        return root;
    json_decref(root);
    if (starved)
        return no_memory(path, why);
    return fail(why, true, "%s:%d:%d: no JSON: %s", path, error.line,
                error.column, error.text);
}

json_t *ibl_json_load(const char *path, size_t flags, ibl_json_why *why)
{
    size_t size;
    char *bytes = ibl_json_bytes(path, &size, why);
    json_t *root = bytes ? ibl_json_parse(path, bytes, size, flags, why) : NULL;

    free(bytes);
    return root;
}

/* ---- sidecars ---------------------------------------------------------- */

/* The name's inverse of ibl_json_encoded, in place. */
static void decode(char *name)
{
    char *to = name;

    for (const char *from = name; *from; to++) {
        char hex[3] = "";
        if (*from == '%')
            strncpy(hex, from + 1, 2);
        const bool is_code =
            isxdigit((unsigned char)hex[0]) && isxdigit((unsigned char)hex[1]);
        *to = is_code ? (char)strtol(hex, NULL, 16) : *from;
        from += is_code ? 3 : 1;
    }
    *to = '\0';
}

static void decode_member(json_t *object, const char *key)
{
    json_t *value = json_object_get(object, key);
    char *name =
        json_is_string(value) ? strdup(json_string_value(value)) : NULL;

    if (name) {
        decode(name);
        json_string_set_nocheck(value, name);
    }
    free(name);
}

json_t *ibl_sidecar_load(const char *path, ibl_json_why *why)
{
    json_t *root = ibl_json_load(path, 0, why), *output;
    const char *names = json_string_value(json_object_get(root, "names"));
    size_t i;

    if (!names || strcmp(names, IBL_NAMES_ENCODED) != 0)
        return root;
    decode_member(json_object_get(root, "source"), "path");
    json_array_foreach(json_object_get(root, "outputs"), i, output)
    {
        decode_member(output, "file");
    }
    return root;
}
