/* SPDX-License-Identifier: MIT */
/*
 * Stamps of --incremental: what a map was baked of, so that the next run knows
 * whether anything changed. A stamp is a line with the hash of the options,
 * and one for each file with the hash of its contents, what stat() says of it,
 * and the name of an output below the directory. A file that stat() says is the
 * same is not read. A stamp of another version is none.
 */
#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include "cli/batch.h"
#include "common/path.h"
#include "json/text.h"

#define STAMP "iblbake stamp 2"

enum {
    IDENTITY_BYTES = 128
};

/* Clocks of file systems tick up to every 10 ms. */
#define TICK_SECONDS 0.02

/* ---- what decides -------------------------------------------------------- */

static bool hash_options(const ibl_job *r, ibl_isa isa,
                         char hash[IBL_FILE_HASH])
{
    const ibl_opts *o = r->opts;
    ibl_memory_file file;
    FILE *to = ibl_memory_open(&file);

    if (!to)
        return false;
    ibl_print_settings(to, isa, &ibl_bake_command, &o->given);
    fprintf(to, "%s\nverify %d %.17g timings %d\n", o->input ? o->input : "",
            o->verify, o->max_error, o->timings);
    for (int i = 0; i < r->count; i++)
        if (r->sets[i].opts->of)
            fprintf(to, "%s\n", r->sets[i].opts->of->options);
    char *text = ibl_memory_close(to, &file);
    if (text)
        ibl_hash_bytes(text, file.size, hash);
    free(text);
    return text;
}

/* ---- files --------------------------------------------------------------- */

/* The path of a map's stamp: in one folder, whatever folder its outputs are in.
 * NULL: no memory. */
static char *stamp_path(const char *folder, const char *name)
{
    char *path = ibl_format("%s/%s.map", folder, name);

    for (char *at = path ? path + strlen(folder) + 1 : ""; *at; at++)
        if (*at == '/')
            *at = '%';
    return path;
}

bool ibl_stamp_of(const ibl_job *r, ibl_isa isa, ibl_stamp *s)
{
    const ibl_opts *o = r->opts;
    ibl_files files;
    const bool ok = ibl_job_files(r, !o->input, &files);

    *s = (ibl_stamp){.files = files.path,
                     .count = files.count,
                     .inputs = files.inputs,
                     .directory = o->directory,
                     .folder = ibl_path_join(o->directory, IBL_STAMPS),
                     .held = -1};
    if (s->folder)
        s->path = o->input ? stamp_path(s->folder, o->below)
                           : ibl_path_join(s->folder, "tables");
    return ok && s->path && hash_options(r, isa, s->options);
}

void ibl_stamp_free(ibl_stamp *s)
{
    for (int i = 0; i < s->count; i++)
        free(s->files[i]);
    if (s->path && s->held >= 0)
        close(s->held);
    free(s->files);
    free(s->path);
    free(s->folder);
    *s = (ibl_stamp){0};
}

/* ---- the file ------------------------------------------------------------ */

/* What changes with a file: size, times of contents and of inode, inode. */
static void identify(const struct stat *st, char text[IDENTITY_BYTES])
{
    snprintf(text, IDENTITY_BYTES, "%lld:%lld.%09ld:%lld.%09ld:%llu",
             (long long)st->st_size, (long long)st->st_mtim.tv_sec,
             st->st_mtim.tv_nsec, (long long)st->st_ctim.tv_sec,
             st->st_ctim.tv_nsec, (unsigned long long)st->st_ino);
}

static bool is_same(const char *path, const char *hash, const char *identity,
                    bool *moved)
{
    char now[IDENTITY_BYTES], content[IBL_FILE_HASH];
    struct stat st;

    if (stat(path, &st) || !S_ISREG(st.st_mode))
        return false;
    identify(&st, now);
    if (!strcmp(now, identity))
        return true;
    *moved = true;
    return !ibl_hash_file(path, content) && !strcmp(content, hash);
}

bool ibl_stamp_holds(const ibl_stamp *s, bool *moved)
{
    char hash[IBL_FILE_HASH], identity[IDENTITY_BYTES];
    struct stat st;
    const bool there = !stat(s->path, &st) && S_ISREG(st.st_mode);
    FILE *from = there ? fopen(s->path, "r") : NULL;
    int count = 0;

    *moved = false;
    if (!from)
        return false;
    bool same = fscanf(from, STAMP " %32s %d", hash, &count) == 2 &&
                !strcmp(hash, s->options) && count == s->count;
    for (int i = 0; i < s->count && same; i++)
        same = fscanf(from, "%32s %127s%*[^\n]", hash, identity) == 2 &&
               is_same(s->files[i], hash, identity, moved);
    fclose(from);
    return same;
}

void ibl_stamp_hold(ibl_stamp *s)
{
    s->held = open(s->folder, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    while (s->held >= 0 && flock(s->held, LOCK_EX) && errno == EINTR)
        continue;
}

/* name: of an output, or "". A line break in it would end the line. */
static bool put_file(FILE *to, const char *path, const char *name, double since)
{
    char identity[IDENTITY_BYTES], hash[IBL_FILE_HASH];
    struct stat st;

    if (strchr(name, '\n') || stat(path, &st) || !S_ISREG(st.st_mode) ||
        (double)st.st_ctim.tv_sec + 1e-9 * (double)st.st_ctim.tv_nsec >
            since - TICK_SECONDS ||
        ibl_hash_file(path, hash))
        return false;
    identify(&st, identity);
    fprintf(to, "%s %s %s\n", hash, identity, name);
    return true;
}

/* An output's path below the directory. */
static const char *below(const ibl_stamp *s, const char *path)
{
    path += strlen(s->directory);
    return path + strspn(path, "/");
}

bool ibl_stamp_write(const ibl_stamp *s, double since, ibl_ctx *ctx)
{
    ibl_memory_file file;
    FILE *to = ibl_memory_open(&file);
    ibl_outputs *outputs = NULL;
    bool known = to;

    if (to)
        fprintf(to, STAMP " %s %d\n", s->options, s->count);
    for (int i = 0; i < s->count && known; i++)
        known = i < s->inputs ? put_file(to, s->files[i], "", since)
                              : put_file(to, s->files[i], below(s, s->files[i]),
                                         HUGE_VAL);
    char *text = ibl_memory_close(to, &file);
    bool ok = !text || !known;
    if (!ok && !ibl_outputs_create(ctx, 0, &outputs)) {
        ibl_outputs_hold(outputs, s->held);
        ok = !ibl_outputs_add(outputs, s->path, text, file.size) &&
             !ibl_outputs_commit(outputs);
    }
    ibl_outputs_free(outputs);
    free(text);
    return ok;
}

/* ---- --prune ------------------------------------------------------------- */

/* Removes a map's outputs that are as its stamp says, and their folders if
 * nothing else is there. False: one is another's now, or stays. */
static bool remove_outputs(const char *directory, FILE *stamp,
                           ibl_console *console)
{
    char hash[IBL_FILE_HASH], identity[IDENTITY_BYTES], name[4096];
    bool ok = fscanf(stamp, STAMP " %32s %*d", hash) == 1, moved;

    while (ok && fscanf(stamp, "%32s %127s", hash, identity) == 2) {
        fgetc(stamp);
        if (!fgets(name, sizeof name, stamp))
            break;
        name[strcspn(name, "\n")] = '\0';
        char *path = *name ? ibl_path_join(directory, name) : NULL;
        if (!path || access(path, F_OK)) {
            free(path);
            continue;
        }
        ok = is_same(path, hash, identity, &moved) && !unlink(path);
        if (!ok)
            ibl_console_warn(console,
                             "%s: its map is gone, but it changed since it was "
                             "made: remove it, if it is not needed",
                             path);
        *strrchr(path, '/') = '\0';
        rmdir(path);
        free(path);
    }
    return ok;
}

int ibl_stamps_prune(const char *directory, const ibl_maps *maps,
                     ibl_console *console)
{
    char *folder = ibl_path_join(directory, IBL_STAMPS);
    DIR *dir = folder ? opendir(folder) : NULL;
    const struct dirent *entry;
    int pruned = 0;

    while (dir && (entry = readdir(dir))) {
        const char *end = strrchr(entry->d_name, '.');
        char *path = ibl_path_join(folder, entry->d_name);
        bool known = !path || !end || strcmp(end, ".map") != 0;
        for (int i = 0; i < maps->count && !known; i++) {
            char *of = stamp_path(folder, maps->list[i].name);
            known = !of || !strcmp(of, path);
            free(of);
        }
        FILE *stamp = known ? NULL : fopen(path, "r");
        if (stamp && remove_outputs(directory, stamp, console))
            pruned += !unlink(path);
        if (stamp)
            fclose(stamp);
        free(path);
    }
    if (dir)
        closedir(dir);
    free(folder);
    return pruned;
}
