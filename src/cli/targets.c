/* SPDX-License-Identifier: MIT */
#include "cli/targets.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static char *make_path(const ibl_opts *o, ibl_output_kind kind)
{
    const char *ext = kind == IBL_OUTPUT_JSON
                          ? "json"
                          : ibl_container_name((ibl_container)o->format);
    const size_t length = strlen(o->directory);
    const char *slash = o->directory[length - 1] == '/' ? "" : "/";
    const size_t size = length + strlen(o->name) + 32;
    char *path = malloc(size);

    if (!path)
        return NULL;
    if (kind == IBL_OUTPUT_LUT)
        snprintf(path, size, "%s%sbrdf_lut.%s", o->directory, slash, ext);
    else if (kind == IBL_OUTPUT_JSON)
        snprintf(path, size, "%s%s%s.%s", o->directory, slash, o->name, ext);
    else
        snprintf(path, size, "%s%s%s_%s.%s", o->directory, slash, o->name,
                 ibl_output_name(kind), ext);
    return path;
}

ibl_status ibl_targets_name(ibl_bake *b)
{
    for (int kind = 0; kind < IBL_OUTPUT_COUNT; kind++) {
        if (!ibl_opts_wants(b->opts, (ibl_output_kind)kind))
            continue;
        b->files[kind].path = make_path(b->opts, (ibl_output_kind)kind);
        if (!b->files[kind].path) {
            ibl_console_fail(b->console, "no memory for file names");
            return IBL_ERR_MEMORY;
        }
    }
    return IBL_OK;
}

/* Whether files may be made in the directory of path; errno if not. */
static bool is_open_directory(const char *path)
{
    const char *slash = strrchr(path, '/');
    char *directory = NULL;

    if (slash)
        directory = strndup(path, slash == path ? 1 : (size_t)(slash - path));
    if (slash && !directory)
        return false;
    const bool ok = !access(slash ? directory : ".", W_OK | X_OK);
    const int saved = errno;
    free(directory);
    errno = saved;
    return ok;
}

static bool is_link(const char *path)
{
    struct stat st;
    return !lstat(path, &st) && S_ISLNK(st.st_mode);
}

static ibl_status check_target(const ibl_bake *b, const char *path)
{
    const char *input = b->opts->input;
    struct stat in, out;
    const int error = stat(path, &out) ? errno : 0;

    if (!error && !S_ISREG(out.st_mode)) {
        ibl_console_fail(b->console, "%s: is a %s: choose another name", path,
                         S_ISDIR(out.st_mode) ? "directory"
                                              : "device, pipe or socket");
        return IBL_ERR_IO;
    }
    /* Where a link leads is for the set of outputs to find out. */
    if (!is_link(path) && !is_open_directory(path)) {
        ibl_console_fail(b->console,
                         "%s: cannot be written: %s: choose another directory",
                         path, strerror(errno));
        return IBL_ERR_IO;
    }
    if (error) {
        if (error != ENAMETOOLONG)
            return IBL_OK;
        ibl_console_fail(b->console,
                         "%s: %s: choose a shorter one, the outputs' with "
                         "--name",
                         path, strerror(error));
        return IBL_ERR_IO;
    }
    if (input && strcmp(input, "-") != 0 && !stat(input, &in) &&
        in.st_dev == out.st_dev && in.st_ino == out.st_ino) {
        ibl_console_fail(b->console,
                         "%s: is both input and output: choose another --name "
                         "or directory",
                         path);
        return IBL_ERR_ARGUMENT;
    }
    return IBL_OK;
}

/* Neither make nor ninja can quote one. */
static ibl_status check_line_break(const ibl_bake *b, const char *path)
{
    if (!strchr(path, '\n'))
        return IBL_OK;
    ibl_console_fail(b->console,
                     "%s: has a line break, which no depfile can name: "
                     "choose another name or leave out --depfile",
                     path);
    return IBL_ERR_ARGUMENT;
}

ibl_status ibl_targets_check(const ibl_bake *b)
{
    const char *paths[IBL_OUTPUT_COUNT + 3];
    ibl_status status = IBL_OK;
    int count = 0;

    for (int kind = 0; kind < IBL_OUTPUT_COUNT; kind++)
        paths[count++] = b->files[kind].path;
    paths[count++] = b->opts->preview;
    paths[count++] = b->opts->depfile;
    for (int i = 0; i < count && !status; i++)
        if (paths[i])
            status = check_target(b, paths[i]);
    if (b->opts->depfile && b->opts->input)
        paths[count++] = b->opts->input;
    for (int i = 0; i < count && !status && b->opts->depfile; i++)
        if (paths[i])
            status = check_line_break(b, paths[i]);
    return status;
}
