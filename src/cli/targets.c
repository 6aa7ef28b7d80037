/* SPDX-License-Identifier: MIT */
#include "cli/targets.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "cli/depfile.h"
#include "common/names.h"
#include "common/sidecar_load.h"

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
        snprintf(path, size, "%s%s%s.%s", o->directory, slash,
                 ibl_lut_stems[o->lut.geometry], ext);
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

static const char *base_name(const char *path)
{
    const char *slash = strrchr(path, '/');
    return slash ? slash + 1 : path;
}

/* Whether what a sidecar calls its source is the input: the same file, or of
 * the same name if it is not to be found from here. */
static bool is_source(const char *was, const char *input)
{
    struct stat a, b;

    if (strcmp(was, "-") != 0 && strcmp(input, "-") != 0 && !stat(was, &a) &&
        !stat(input, &b))
        return a.st_dev == b.st_dev && a.st_ino == b.st_ino;
    return !strcmp(base_name(was), base_name(input));
}

/* Whether the bake writes the sidecar or any file that it tells of. */
static bool replaces(const ibl_bake *b, const json_t *sidecar)
{
    const json_t *outputs = json_object_get(sidecar, "outputs"), *output;
    size_t i;

    if (b->files[IBL_OUTPUT_JSON].path)
        return true;
    json_array_foreach((json_t *)outputs, i, output)
    {
        const char *file = json_string_value(json_object_get(output, "file"));
        for (int kind = 0; file && kind < IBL_OUTPUT_LUT; kind++)
            if (b->files[kind].path &&
                !strcmp(base_name(b->files[kind].path), file))
                return true;
    }
    return false;
}

static ibl_status check_sidecar(const ibl_bake *b, const char *path,
                                const json_t *sidecar)
{
    const ibl_opts *o = b->opts;
    const char *writer = json_string_value(
        json_object_get(json_object_get(sidecar, "generator"), "name"));
    const char *was = json_string_value(
        json_object_get(json_object_get(sidecar, "source"), "path"));

    if (!writer || strcmp(writer, "iblbake") != 0 || !was ||
        is_source(was, o->input) || !replaces(b, sidecar))
        return IBL_OK;
    ibl_console_fail(b->console,
                     "%s: was made from %s, and %s would replace its files: "
                     "choose another --name or directory, or --name %s to "
                     "replace them",
                     path, was, o->input, o->name);
    return IBL_ERR_ARGUMENT;
}

/* A name that was asked for may be anybody's; one that follows from the input
 * may not be that of another's outputs. */
static ibl_status check_source(const ibl_bake *b)
{
    struct stat st;
    ibl_status status = IBL_OK;

    if (!b->opts->input || b->opts->name != b->opts->stem)
        return IBL_OK;
    char *path = make_path(b->opts, IBL_OUTPUT_JSON);
    if (path && !stat(path, &st) && S_ISREG(st.st_mode)) {
        ibl_json_why why;
        json_t *sidecar = ibl_sidecar_load(path, &why);
        status = check_sidecar(b, path, sidecar);
        json_decref(sidecar);
    }
    free(path);
    return status;
}

static ibl_status check_depfile(const ibl_bake *b, const char *path)
{
    char why[IBL_DEPFILE_WHY];

    if (!ibl_depfile_refuses(path, why))
        return IBL_OK;
    ibl_console_fail(b->console,
                     "%s: has %s, which make or ninja cannot read in a "
                     "depfile: choose another name or leave out --depfile",
                     path, why);
    return IBL_ERR_ARGUMENT;
}

ibl_status ibl_targets_check(const ibl_bake *b)
{
    const ibl_opts *o = b->opts;
    const char *named[IBL_OUTPUT_COUNT + 2]; /* in a depfile */
    ibl_status status = IBL_OK;
    int count = 0;

    for (int kind = 0; kind < IBL_OUTPUT_COUNT; kind++)
        named[count++] = b->files[kind].path;
    named[count++] = o->preview;
    for (int i = 0; i < count && !status; i++)
        if (named[i])
            status = check_target(b, named[i]);
    if (!status)
        status = check_source(b);
    if (status || !o->depfile)
        return status;
    status = check_target(b, o->depfile);
    if (o->input && strcmp(o->input, "-") != 0)
        named[count++] = o->input;
    for (int i = 0; i < count && !status; i++)
        if (named[i])
            status = check_depfile(b, named[i]);
    return status;
}
