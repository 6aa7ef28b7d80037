/* SPDX-License-Identifier: MIT */
#include "cli/batch.h"
#include "common/signals.h"

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
#include "json/json_text.h"

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

bool ibl_set_is_named(const ibl_opts *o)
{
    bool named = o->sh_format;

    for (int kind = 0; kind < IBL_OUTPUT_COUNT; kind++)
        named |= ibl_opts_want(o, (ibl_output_kind)kind) &&
                 !ibl_set_is_shared(o, (ibl_output_kind)kind);
    return named;
}

/* The path of a file of an output that has so many levels, and so many pictures
 * of each. */
static char *make_path(const ibl_output_set *b, ibl_output_kind kind,
                       int levels, int faces, int index)
{
    const ibl_opts *o = b->opts;
    const char *shared = kind == IBL_OUTPUT_LUT
                             ? o->lut.kind ? ibl_table_stems[o->lut.kind]
                                           : ibl_lut_stems[o->lut.geometry]
                         : kind == IBL_OUTPUT_LOBES ? ibl_output_content(kind)
                                                    : o->name;
    char *stem = ibl_need(
        is_own(o, kind) ? ibl_format("%s_%s", o->name, ibl_output_content(kind))
                        : strdup(shared));
    char *name;

    if (kind == IBL_OUTPUT_JSON)
        name = ibl_format("%s.json", stem);
    else if (kind == IBL_OUTPUT_SPECULAR && o->engine)
        name = index
                   ? ibl_engine_face_name(o->name, index - 1)
                   : ibl_format("%s%s", o->name, ibl_engine_suffix(o->engine));
    else if (o->picture)
        name = ibl_picture_name(stem, o->picture, levels, faces, index);
    else
        name = ibl_format("%s.%s", stem, ibl_container_extension(o->format));
    char *path = ibl_need(ibl_path_join(
        ibl_set_is_shared(o, kind) ? b->root : b->directory, ibl_need(name)));

    free(stem);
    free(name);
    return path;
}

void ibl_set_name_files(ibl_output_set *b)
{
    const ibl_opts *o = b->opts;

    ibl_set_forget_names(b);
    for (int k = 0; k < IBL_OUTPUT_COUNT; k++) {
        const ibl_output_kind kind = (ibl_output_kind)k;
        const int faces = kind < IBL_OUTPUT_LUT && !o->layout ? IBL_FACES : 1;
        ibl_specular_layout layout = {.levels = 1};
        ibl_output *file = &b->files[kind];
        if (!ibl_opts_want(o, kind))
            continue;
        if (kind == IBL_OUTPUT_SPECULAR)
            ibl_specular_layout_of(&o->bake.specular_options, &layout);
        file->count = 1;
        if (o->picture && kind != IBL_OUTPUT_JSON)
            file->count = layout.levels * faces;
        else if (o->engine && kind == IBL_OUTPUT_SPECULAR)
            file->count += ibl_engine_faces(o->engine, layout.levels);
        file->paths =
            ibl_need(calloc((size_t)file->count, sizeof *file->paths));
        for (int i = 0; i < file->count; i++)
            file->paths[i] = make_path(b, kind, layout.levels, faces, i);
    }
    if (o->sh_format)
        b->sh_path =
            ibl_need(ibl_format("%s/%s_sh.txt", b->directory, o->name));
}

void ibl_set_forget_names(ibl_output_set *b)
{
    for (int k = 0; k < IBL_OUTPUT_COUNT; k++) {
        for (int i = 0; i < b->files[k].count; i++)
            free(b->files[k].paths[i]);
        free(b->files[k].paths);
        b->files[k].paths = NULL;
        b->files[k].count = 0;
    }
    free(b->sh_path);
    b->sh_path = NULL;
}

static void add_path(ibl_files *f, const char *path)
{
    if (!path)
        return;
    f->path =
        ibl_need(realloc(f->path, ((size_t)f->count + 1) * sizeof *f->path));
    f->path[f->count++] = ibl_need(strdup(path));
}

bool ibl_job_files(const ibl_job *r, bool shared, ibl_files *f)
{
    const ibl_opts *o = r->opts;
    char *inputs[IBL_FACES] = {NULL};
    int count = 0;
    bool ok = true;

    *f = (ibl_files){0};
    if (o->input && strcmp(o->input, "-") != 0)
        ok = !ibl_input_files(r->ctx, o->input, inputs, &count);
    for (int i = 0; i < count && ok; i++)
        add_path(f, inputs[i]);
    ibl_input_files_free(inputs);
    for (int i = 0; r->scenes && i < r->scenes->file_count; i++)
        add_path(f, r->scenes->files[i]);
    f->inputs = f->count;
    for (int i = 0; i < r->count; i++) {
        const ibl_output_set *b = &r->sets[i];
        for (int kind = 0; kind < IBL_OUTPUT_COUNT; kind++)
            if (shared || !ibl_set_is_shared(b->opts, (ibl_output_kind)kind))
                for (int n = 0; n < b->files[kind].count; n++)
                    add_path(f, b->files[kind].paths[n]);
        add_path(f, b->sh_path);
    }
    add_path(f, o->preview);
    return ok;
}

void ibl_files_free(ibl_files *f)
{
    for (int i = 0; i < f->count; i++)
        free(f->path[i]);
    free(f->path);
}

/* ---- what cannot be written ------------------------------------------ */

/* Whether a file can be made of that name, and is none that is read. */
static bool check_made(ibl_job *r, const ibl_files *f, const char *path)
{
    ibl_console *c = &r->console;
    struct stat out, own;
    const int error = stat(path, &out) ? errno : 0;
    const bool link = !lstat(path, &own) && S_ISLNK(own.st_mode);

    if (!error && !S_ISREG(out.st_mode))
        return ibl_console_fail(
            c, "%s: is a %s: choose another name", path,
            S_ISDIR(out.st_mode) ? "directory" : "device, pipe or socket");
    /* A link's target is checked by the set of outputs. */
    if (!link && !ibl_path_is_open(path))
        return ibl_console_fail(
            c, "%s: cannot be written: %s: choose another directory", path,
            strerror(errno));
    if (error == ENAMETOOLONG)
        return ibl_console_fail(
            c, "%s: %s: choose a shorter one, the outputs' with --name", path,
            strerror(error));
    if (error)
        return true;
    for (int i = 0; i < f->inputs; i++)
        if (!ibl_console_differ(c, f->path[i], path, "--name or directory"))
            return false;
    for (int i = 0; r->maps && i < r->maps->count; i++)
        if (r->maps->list[i].file.st_ino == out.st_ino &&
            r->maps->list[i].file.st_dev == out.st_dev)
            return ibl_console_fail(c,
                                    "%s: would be replaced by %s, an output: "
                                    "choose another directory",
                                    r->maps->list[i].input, path);
    return true;
}

/* A name given by the user may replace any files. A name derived from the input
 * must not replace files of another environment: of another file or, if one of
 * the two cannot be looked at here, of another name. */
static bool check_source(ibl_output_set *b)
{
    const ibl_opts *o = b->opts;
    const char *writer, *was;
    ibl_json_why why;

    if (!o->input || o->name != o->stem || !ibl_set_is_named(o))
        return true;
    char *path = make_path(b, IBL_OUTPUT_JSON, 1, 1, 0);
    json_t *sidecar = access(path, F_OK) ? NULL : ibl_json_load(path, 0, &why);
    bool ok = json_unpack(sidecar, "{s:{s:s},s:{s:s}}", "generator", "name",
                          &writer, "source", "path", &was) ||
              strcmp(writer, "iblbake") != 0;
    if (!ok && !access(was, F_OK) && !access(o->input, F_OK))
        ok = ibl_path_same(was, o->input) > 0;
    else if (!ok)
        ok = !strcmp(ibl_path_name(was), ibl_path_name(o->input));
    if (!ok)
        ibl_console_fail(&b->job->console,
                         "%s: was made from %s, and %s would replace its "
                         "files: choose another --name or directory, or "
                         "--name %s to replace them",
                         path, was, o->input, o->name);
    json_decref(sidecar);
    free(path);
    return ok;
}

/* ---- the depfile ------------------------------------------------------ */

/*
 * Whether make and ninja can read a name when it is quoted. Make takes '=' for
 * a variable, '|' and ';' for the end of the prerequisites, '%' for a pattern,
 * a last ')' for an archive member and '~' for a home; ninja ends a name at
 * most others.
 */
static bool check_quotable(ibl_job *r, const char *path)
{
    const char *at = path;

    while (*at && !iscntrl((unsigned char)*at) &&
           !strchr("\"%&'*;<=>?^`|", *at))
        at++;
    if (!*at && *path == '~')
        at = path;
    if (!*at && at > path && strchr(" \\:)", at[-1]))
        at--;
    const bool control = iscntrl((unsigned char)*at);
    return !*at ||
           ibl_console_fail(
               &r->console,
               "%s: has a %s%.*s, which make or ninja cannot read in a "
               "depfile: choose another name or leave out --depfile",
               path, control ? "control character" : "", control ? 0 : 1, at);
}

/* Checks that the depfile can name the files, and is none of them. */
static bool check_depfile(ibl_job *r, const ibl_files *f)
{
    const char *depfile = r->opts->depfile;
    bool ok = true;

    for (int i = 0; i < f->count && ok; i++) {
        const char *path = f->path[i];
        if (i < f->inputs)
            ok = ibl_console_differ(&r->console, path, depfile, "--depfile");
        else if (!strcmp(path, depfile) || ibl_path_same(path, depfile) > 0)
            ok = ibl_console_fail(&r->console,
                                  "%s: is the name of another output too: "
                                  "give each its own",
                                  depfile);
        ok = ok && check_quotable(r, path);
    }
    return ok;
}

bool ibl_job_check_depfile(ibl_job *r)
{
    ibl_files f;

    ibl_job_files(r, true, &f); /* the bake says what is missing */
    const bool ok = check_depfile(r, &f);
    ibl_files_free(&f);
    return ok;
}

/*
 * Appends a name, quoted as GCC's -MD does; make and ninja both understand it.
 * A dollar is doubled, '#', ':' and blanks get a backslash, and backslashes
 * before a blank are doubled.
 */
static void append_path(char **text, const char *path)
{
    char *quoted = ibl_need(malloc(2 * strlen(path) + 1)), *to = quoted;
    size_t backslashes = 0;

    for (; *path; path++) {
        if (*path == ' ')
            for (size_t i = 0; i <= backslashes; i++)
                *to++ = '\\';
        else if (strchr("#:$", *path))
            *to++ = *path == '$' ? '$' : '\\';
        backslashes = *path == '\\' ? backslashes + 1 : 0;
        *to++ = *path;
    }
    ibl_append(text, "%.*s", (int)(to - quoted), quoted);
    free(quoted);
}

char *ibl_depfile_text(const ibl_job *r)
{
    static const char next[] = " \\\n  ";
    ibl_files f;
    const bool ok = ibl_job_files(r, true, &f);
    char *text = NULL;

    for (int i = f.inputs; i < f.count; i++) {
        ibl_append(&text, "%s", i > f.inputs ? next : "");
        append_path(&text, f.path[i]);
    }
    ibl_append(&text, ":");
    for (int i = 0; i < f.inputs; i++) {
        ibl_append(&text, "%s", f.inputs > 1 ? next : " ");
        append_path(&text, f.path[i]);
    }
    ibl_append(&text, "\n");
    ibl_files_free(&f);
    if (ok)
        return text;
    free(text);
    return NULL;
}

/* ---- the plan ---------------------------------------------------------- */

bool ibl_job_plan(ibl_job *r)
{
    const char *depfile = r->opts->depfile;
    ibl_files f;
    bool ok = ibl_job_files(r, true, &f);

    for (int i = f.inputs; i < f.count && ok; i++)
        ok = check_made(r, &f, f.path[i]);
    for (int i = 0; i < r->count && ok; i++)
        ok = check_source(&r->sets[i]);
    if (ok && depfile)
        ok = check_depfile(r, &f) && check_made(r, &f, depfile);
    ibl_files_free(&f);
    return ok;
}
