/* SPDX-License-Identifier: MIT */
#include "cli/batch.h"

#include <ctype.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "common/names.h"
#include "common/path.h"
#include "set/about.h"
#include "json/text.h"

/* Whether the lobe table is the one of the default levels. */
static bool is_usual_table(const ibl_opts *o)
{
    const ibl_specular_options usual = ibl_specular_options_default();
    ibl_specular_layout a, b;

    return o->lobe_table == IBL_LOBES_PRIOR && o->lobe_f0 == IBL_F0_BOTH &&
           !ibl_specular_layout_of(&usual, &a) &&
           !ibl_specular_layout_of(&o->bake.specular_options, &b) &&
           a.size == b.size && a.levels == b.levels &&
           !memcmp(a.roughness, b.roughness, sizeof a.roughness);
}

/* Whether a file has the name of the environment and its own. The others are
 * the same for many environments, or the sidecar. */
static bool is_own(const ibl_opts *o, ibl_output_kind kind)
{
    return kind < IBL_OUTPUT_LUT ||
           (kind == IBL_OUTPUT_LOBES && o->input && !is_usual_table(o));
}

bool ibl_set_is_shared(const ibl_opts *o, ibl_output_kind kind)
{
    return !is_own(o, kind) && kind != IBL_OUTPUT_JSON;
}

/* The number of files of an output, and of its pictures a level. */
static int files_of(const ibl_opts *o, ibl_output_kind kind, int *each)
{
    ibl_specular_layout layout = {.levels = 1};

    if (kind == IBL_OUTPUT_SPECULAR)
        ibl_specular_layout_of(&o->bake.specular_options, &layout);
    *each = kind < IBL_OUTPUT_LUT && !o->layout ? IBL_FACES : 1;
    if (o->picture && kind != IBL_OUTPUT_JSON)
        return layout.levels * *each;
    return 1 + (kind == IBL_OUTPUT_SPECULAR
                    ? ibl_engine_faces(o->engine, layout.levels)
                    : 0);
}

/* The path of one of them; NULL: no memory. */
static char *make_path(const ibl_output_set *b, ibl_output_kind kind, int index)
{
    const ibl_opts *o = b->opts;
    int each;
    const int files = files_of(o, kind, &each);
    const char *extension =
        kind == IBL_OUTPUT_JSON ? "json" : ibl_container_extension(o->format);
    const char *shared = kind == IBL_OUTPUT_LUT
                             ? o->lut.kind ? ibl_table_stems[o->lut.kind]
                                           : ibl_lut_stems[o->lut.geometry]
                         : kind == IBL_OUTPUT_LOBES ? ibl_output_content(kind)
                                                    : o->name;
    char *stem = is_own(o, kind)
                     ? ibl_format("%s_%s", o->name, ibl_output_content(kind))
                     : ibl_format("%s", shared);
    char *name =
        kind == IBL_OUTPUT_SPECULAR && o->engine
            ? index ? ibl_engine_face_name(o->name, index - 1)
                    : ibl_format("%s%s", o->name, ibl_engine_suffix(o->engine))
        : o->picture && kind != IBL_OUTPUT_JSON
            ? ibl_picture_name(stem, o->picture, files / each, each, index)
            : ibl_format("%s.%s", stem, extension);
    const char *directory = ibl_set_is_shared(o, kind) ? b->root : b->directory;
    char *path = stem && name ? ibl_path_join(directory, name) : NULL;

    free(stem);
    free(name);
    return path;
}

static char *make_sh_path(const ibl_output_set *b)
{
    char *name = ibl_format("%s_sh.txt", b->opts->name);
    char *path = name ? ibl_path_join(b->directory, name) : NULL;

    free(name);
    return path;
}

bool ibl_set_name_files(ibl_output_set *b)
{
    int each;
    bool ok = true;

    while (b->face_count) /* tables of a batch are named twice */
        free(b->faces[--b->face_count]);
    for (int kind = 0; kind < IBL_OUTPUT_COUNT && ok; kind++) {
        ibl_output *file = &b->files[kind];
        if (!(b->opts->only & 1u << kind))
            continue;
        free(file->path);
        file->path = make_path(b, (ibl_output_kind)kind, 0);
        file->more = &b->faces[b->face_count];
        file->count = files_of(b->opts, (ibl_output_kind)kind, &each);
        ok = file->path != NULL;
        for (int i = 1; i < file->count && ok; i++) {
            char *path = make_path(b, (ibl_output_kind)kind, i);
            ok = path != NULL;
            if (ok)
                b->faces[b->face_count++] = path;
        }
    }
    if (ok && b->opts->sh_format)
        ok = (b->sh_path = make_sh_path(b)) != NULL;
    return ok || ibl_console_fail(b->console, "no memory for file names");
}

int ibl_set_files(const ibl_output_set *b, bool shared,
                  const char *paths[IBL_SET_PATHS])
{
    int count = 0;

    for (int kind = 0; kind < IBL_OUTPUT_COUNT; kind++)
        if (b->files[kind].path &&
            (shared || !ibl_set_is_shared(b->opts, (ibl_output_kind)kind)))
            paths[count++] = b->files[kind].path;
    if (b->sh_path)
        paths[count++] = b->sh_path;
    for (int i = 0; i < b->face_count; i++)
        paths[count++] = b->faces[i];
    return count;
}

ibl_status ibl_set_inputs(const ibl_output_set *b, char *files[IBL_FACES],
                          int *count)
{
    const char *input = b->opts->input;

    *count = 0;
    for (int f = 0; f < IBL_FACES; f++)
        files[f] = NULL;
    return input && strcmp(input, "-") != 0
               ? ibl_input_files(b->ctx, input, files, count)
               : IBL_OK;
}

static bool check_inputs(const ibl_output_set *b, const char *path)
{
    static const char other[] = "--name or directory";
    const ibl_scenes *scenes = b->from->scenes;
    char *files[IBL_FACES];
    int count;
    bool ok = !ibl_set_inputs(b, files, &count);

    for (int i = 0; i < count && ok; i++)
        ok = ibl_console_differ(b->console, files[i], path, other);
    ibl_input_files_free(files);
    for (int i = 0; scenes && i < scenes->file_count && ok; i++)
        ok = ibl_console_differ(b->console, scenes->files[i], path, other);
    return ok;
}

/* ---- what cannot be written ------------------------------------------ */

static bool is_link(const char *path)
{
    struct stat st;
    return !lstat(path, &st) && S_ISLNK(st.st_mode);
}

/* Whether no map of the batch is read from this file. */
static bool check_maps(const ibl_output_set *b, const char *path,
                       const struct stat *out)
{
    const ibl_maps *maps = b->from->run->maps;

    for (int i = 0; maps && i < maps->count; i++)
        if (maps->list[i].inode == out->st_ino &&
            maps->list[i].device == out->st_dev)
            return ibl_console_fail(b->console,
                                    "%s: would be replaced by %s, an output: "
                                    "choose another directory",
                                    maps->list[i].input, path);
    return true;
}

static bool check_target(const ibl_output_set *b, const char *path)
{
    struct stat out;
    const int error = stat(path, &out) ? errno : 0;

    if (!error && !S_ISREG(out.st_mode))
        return ibl_console_fail(
            b->console, "%s: is a %s: choose another name", path,
            S_ISDIR(out.st_mode) ? "directory" : "device, pipe or socket");
    /* A link's target is checked by the set of outputs. */
    if (!is_link(path) && !ibl_path_is_open(path))
        return ibl_console_fail(
            b->console, "%s: cannot be written: %s: choose another directory",
            path, strerror(errno));
    if (error == ENAMETOOLONG)
        return ibl_console_fail(
            b->console,
            "%s: %s: choose a shorter one, the outputs' with --name", path,
            strerror(error));
    if (error == EIO)
        return ibl_console_fail(b->console, "%s: cannot be looked at: %s", path,
                                strerror(error));
    return error || (check_inputs(b, path) && check_maps(b, path, &out));
}

/* Whether the source that a sidecar names is the input: the same file, or the
 * same name if one of the two cannot be looked at here. */
static bool is_source(const char *was, const char *input)
{
    int same = -1;

    if (strcmp(was, "-") != 0 && strcmp(input, "-") != 0 &&
        !access(was, F_OK) && !access(input, F_OK))
        same = ibl_path_same(was, input);
    if (same >= 0)
        return same;
    return !strcmp(ibl_path_name(was), ibl_path_name(input));
}

/* Whether the bake writes the sidecar or any file that it names. */
static bool replaces(const ibl_output_set *b, const json_t *sidecar)
{
    const json_t *outputs = json_object_get(sidecar, "outputs"), *output;
    size_t i;

    if (b->files[IBL_OUTPUT_JSON].path)
        return true;
    json_array_foreach((json_t *)outputs, i, output)
    {
        const char *file = json_string_value(json_object_get(output, "file"));
        for (int kind = 0; file && kind < IBL_OUTPUT_COUNT; kind++)
            if (is_own(b->opts, (ibl_output_kind)kind) && b->files[kind].path &&
                !strcmp(ibl_path_name(b->files[kind].path), file))
                return true;
    }
    return false;
}

/* A name given by the user may replace any files. A name derived from the input
 * must not replace files of another environment. */
static bool check_sidecar(const ibl_output_set *b, const char *path)
{
    const ibl_opts *o = b->opts;
    const char *writer, *was;
    ibl_json_why why;
    struct stat st;

    if (stat(path, &st) || !S_ISREG(st.st_mode))
        return true;
    json_t *sidecar = ibl_json_load(path, 0, &why);
    const bool ok =
        json_unpack(sidecar, "{s:{s:s},s:{s:s}}", "generator", "name", &writer,
                    "source", "path", &was) ||
        strcmp(writer, "iblbake") != 0 || is_source(was, o->input) ||
        !replaces(b, sidecar) ||
        ibl_console_fail(b->console,
                         "%s: was made from %s, and %s would replace its "
                         "files: choose another --name or directory, or "
                         "--name %s to replace them",
                         path, was, o->input, o->name);
    json_decref(sidecar);
    return ok;
}

static bool check_source(const ibl_output_set *b)
{
    if (!b->opts->input || b->opts->name != b->opts->stem)
        return true;
    char *path = make_path(b, IBL_OUTPUT_JSON, 0);
    const bool ok = path && check_sidecar(b, path);

    free(path);
    return ok;
}

/* ---- the depfile ------------------------------------------------------ */

enum {
    WHY_BYTES = 32
};

/*
 * Quotes as GCC's -MD does; make and ninja both understand it. A dollar is
 * doubled, '#', ':' and blanks get a backslash, and backslashes before a blank
 * are doubled. Names that cannot be quoted were refused before.
 */
static void put_path(FILE *to, const char *path)
{
    size_t backslashes = 0;

    for (; *path; path++) {
        if (*path == ' ')
            for (size_t i = 0; i <= backslashes; i++)
                fputc('\\', to);
        else if (*path == '#' || *path == ':')
            fputc('\\', to);
        else if (*path == '$')
            fputc('$', to);
        backslashes = *path == '\\' ? backslashes + 1 : 0;
        fputc(*path, to);
    }
}

/*
 * Characters that cannot be quoted. Make takes '=' for a variable, '|' and ';'
 * for the end of the prerequisites, '%' for a pattern, a last ')' for an
 * archive member and '~' for a home; ninja ends a name at most others.
 */
static bool is_unquotable(const char *path, char why[WHY_BYTES])
{
    const size_t length = strlen(path);
    const char last = length ? path[length - 1] : 'a';
    const char *at = path;

    while (*at && !iscntrl((unsigned char)*at) &&
           !strchr("\"%&'*;<=>?^`|", *at))
        at++;
    if (*at == '\n')
        snprintf(why, WHY_BYTES, "a line break");
    else if (iscntrl((unsigned char)*at) && *at)
        snprintf(why, WHY_BYTES, "a control character");
    else if (*at)
        snprintf(why, WHY_BYTES, "a %c", *at);
    else if (*path == '~')
        snprintf(why, WHY_BYTES, "a ~ at its beginning");
    else if (strchr(" \\:)", last))
        snprintf(why, WHY_BYTES, "'%c' at its end", last);
    else
        return false;
    return true;
}

static bool check_depfile(const ibl_output_set *b, const char *path)
{
    char why[WHY_BYTES];

    return !is_unquotable(path, why) ||
           ibl_console_fail(
               b->console,
               "%s: has %s, which make or ninja cannot read in a depfile: "
               "choose another name or leave out --depfile",
               path, why);
}

static void put_outputs(FILE *to, const ibl_output_set *sets, int count)
{
    const char *paths[IBL_SET_PATHS], *between = "";

    for (int s = 0; s < count; s++) {
        const int files = ibl_set_files(&sets[s], true, paths);
        for (int i = 0; i < files; i++) {
            fputs(between, to);
            put_path(to, paths[i]);
            between = " \\\n  ";
        }
    }
    if (sets->opts->preview) {
        fputs(between, to);
        put_path(to, sets->opts->preview);
    }
}

char *ibl_depfile_text(const ibl_output_set *sets, int count)
{
    char *inputs[IBL_FACES];
    int input_count;
    ibl_memory_file file;
    FILE *to = ibl_memory_open(&file);

    if (!to)
        return NULL;
    put_outputs(to, sets, count);
    fputc(':', to);
    const bool ok = !ibl_set_inputs(sets, inputs, &input_count);
    for (int i = 0; i < input_count && ok; i++) {
        fputs(input_count > 1 ? " \\\n  " : " ", to);
        put_path(to, inputs[i]);
    }
    ibl_input_files_free(inputs);
    for (int i = 0; sets->from->scenes && i < sets->from->scenes->file_count;
         i++) {
        fputs(" \\\n  ", to);
        put_path(to, sets->from->scenes->files[i]);
    }
    fputc('\n', to);
    char *text = ibl_memory_close(to, &file);
    if (ok)
        return text;
    free(text);
    return NULL;
}

/* Checks a file that is made, and that the depfile can name it. */
static bool check_file(const ibl_output_set *b, const char *path)
{
    return check_target(b, path) &&
           (!b->opts->depfile || check_depfile(b, path));
}

static bool plan_set(ibl_output_set *b)
{
    const char *paths[IBL_SET_PATHS];
    bool ok = ibl_set_name_files(b);
    const int count = ok ? ibl_set_files(b, true, paths) : 0;

    for (int i = 0; i < count && ok; i++)
        ok = check_target(b, paths[i]);
    return ok && check_source(b);
}

/* Checks what a set makes: that the depfile can name it, and is none of it. */
static bool check_set_depfile(const ibl_output_set *b, const char *depfile)
{
    const char *paths[IBL_SET_PATHS];
    const int count = ibl_set_files(b, true, paths);
    bool ok = true;

    for (int i = 0; i < count && ok; i++) {
        ok = check_depfile(b, paths[i]);
        if (ok && (!strcmp(paths[i], depfile) ||
                   ibl_path_same(paths[i], depfile) > 0))
            ok = ibl_console_fail(b->console,
                                  "%s: is the name of another output too: "
                                  "give each its own",
                                  depfile);
    }
    return ok;
}

bool ibl_bake_check_depfile(const ibl_output_set *sets, int count)
{
    const ibl_scenes *scenes = sets->from->scenes;
    const char *depfile = sets->opts->depfile;
    char *inputs[IBL_FACES];
    int input_count;
    const ibl_status status = ibl_set_inputs(sets, inputs, &input_count);
    bool ok = true;

    if (status == IBL_ERR_MEMORY)
        return ibl_console_fail(sets->console, "no memory for names of files");
    if (status)
        input_count = 0; /* the bake says what is missing */
    for (int i = 0; i < count && ok; i++)
        ok = check_set_depfile(&sets[i], depfile);
    for (int i = 0; i < input_count && ok; i++)
        ok = ibl_console_differ(sets->console, inputs[i], depfile,
                                "--depfile") &&
             check_depfile(sets, inputs[i]);
    ibl_input_files_free(inputs);
    for (int i = 0; scenes && i < scenes->file_count && ok; i++)
        ok = check_depfile(sets, scenes->files[i]);
    return ok;
}

bool ibl_bake_plan(ibl_output_set *sets, int count)
{
    const ibl_opts *o = sets->opts;
    char *inputs[IBL_FACES];
    int input_count;
    bool ok = !ibl_set_inputs(sets, inputs, &input_count);

    ibl_input_files_free(inputs);
    for (int i = 0; i < count && ok; i++)
        ok = plan_set(&sets[i]);
    return ok && (!o->preview || check_file(sets, o->preview)) &&
           (!o->depfile || (check_target(sets, o->depfile) &&
                            ibl_bake_check_depfile(sets, count)));
}
