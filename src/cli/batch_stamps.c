/* SPDX-License-Identifier: MIT */
/*
 * Stamps of --incremental: what a map was baked of, so that the next run knows
 * whether anything changed. A stamp is a line with the hash of the options,
 * and one for each file with the hash of its contents, what stat() says of it,
 * and the name of an output below the directory. A file that stat() says is the
 * same is not read. A stamp of another version is none.
 */
#include <dirent.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#include "cli/batch.h"
#include "common/path.h"
#include "common/signals.h"
#include "port/port.h"
#include "json/text.h"

#define STAMP "iblbake stamp 3"

enum {
    IDENTITY_BYTES = 128
};

/* What a job is made of, and the files that it reads and makes. */
typedef struct stamp {
    char *folder, *path;         /* of all stamps; of this one */
    char options[IBL_FILE_HASH]; /* hash of all that decides what is made */
    ibl_files files;             /* what is read, then what the job makes */
} stamp;

/* Clocks of file systems tick up to every 10 ms. */
#define TICK_SECONDS 0.02

static void hash_options(const ibl_job *r, char hash[IBL_FILE_HASH])
{
    const ibl_opts *o = r->opts;
    char *text =
        ibl_settings_text(ibl_ctx_isa(r->ctx), &ibl_bake_command, &o->given);

    ibl_append(&text, "%s\nverify %d %.17g\n", o->input ? o->input : "",
               o->verify, o->max_error);
    for (int i = 0; i < r->count; i++)
        if (r->sets[i].opts->of)
            ibl_append(&text, "%s\n", r->sets[i].opts->of->options);
    ibl_hash_bytes(text, strlen(text), hash);
    free(text);
}

/* The path of a map's stamp: in one folder, whatever folder its outputs are in.
 */
static char *stamp_path(const char *folder, const char *name)
{
    char *path = ibl_need(ibl_format("%s/%s.map", folder, name));

    for (char *at = path + strlen(folder) + 1; *at; at++)
        if (*at == '/')
            *at = '%';
    return path;
}

/* False, after a message: no file fits a pattern. */
static bool begin(const ibl_job *r, stamp *s)
{
    const ibl_opts *o = r->opts;

    *s = (stamp){.folder = ibl_need(ibl_path_join(o->directory, IBL_STAMPS))};
    s->path = o->input ? stamp_path(s->folder, o->below)
                       : ibl_need(ibl_path_join(s->folder, "tables"));
    hash_options(r, s->options);
    return ibl_job_files(r, !o->input, &s->files);
}

static void end(stamp *s)
{
    ibl_files_free(&s->files);
    free(s->path);
    free(s->folder);
}

/* ---- the file ------------------------------------------------------------ */

/* What changes with a file: size, times of contents and of inode, inode. */
static void identify(const struct stat *st, char text[IDENTITY_BYTES])
{
    const struct timespec w = st->st_mtim, c = st->st_ctim;

    snprintf(text, IDENTITY_BYTES, "%lld:%lld.%09ld:%lld.%09ld:%llu",
             (long long)st->st_size, (long long)w.tv_sec, (long)w.tv_nsec,
             (long long)c.tv_sec, (long)c.tv_nsec,
             (unsigned long long)st->st_ino);
}

static bool is_same(const char *path, const char *hash, const char *identity)
{
    char now[IDENTITY_BYTES], content[IBL_FILE_HASH];
    struct stat st;

    if (stat(path, &st))
        return false;
    identify(&st, now);
    return !strcmp(now, identity) ||
           (!ibl_hash_file(path, content) && !strcmp(content, hash));
}

bool ibl_stamp_holds(const ibl_job *r)
{
    char hash[IBL_FILE_HASH], identity[IDENTITY_BYTES];
    struct stat st;
    stamp s;
    const bool there =
        begin(r, &s) && !stat(s.path, &st) && S_ISREG(st.st_mode);
    FILE *from = there ? fopen(s.path, "r") : NULL;
    int count = 0;

    bool same = from && fscanf(from, STAMP " %32s %d", hash, &count) == 2 &&
                !strcmp(hash, s.options) && count == s.files.count;
    for (int i = 0; i < s.files.count && same; i++)
        same = fscanf(from, "%32s %127s%*[^\n]", hash, identity) == 2 &&
               is_same(s.files.path[i], hash, identity);
    if (from)
        fclose(from);
    end(&s);
    return same;
}

bool ibl_stamp_commit(ibl_job *r, double since)
{
    ibl_outputs *outputs = NULL;
    char *text = NULL;
    const struct timespec nap = {.tv_nsec = 2000000};
    int lock = -1;
    stamp s;

    if (!r->opts->incremental)
        return ibl_job_commit(r);
    bool ok = begin(r, &s), known = ok;
    if (ok) {
        while (!ibl_port_lock_folder(s.folder, &lock))
            nanosleep(&nap, NULL);
        ok = known = ibl_job_commit(r);
    }
    ibl_append(&text, STAMP " %s %d\n", s.options, s.files.count);
    for (int i = 0; i < s.files.count && known; i++) {
        const char *path = s.files.path[i], *name = "";
        char identity[IDENTITY_BYTES], hash[IBL_FILE_HASH];
        struct stat st;
        known = !stat(path, &st);
        if (i >= s.files.inputs) {
            name = path + strlen(r->opts->directory);
            name += strspn(name, "/");
            known &= !strchr(name, '\n'); /* which would end the line */
        } else if (known) {
            known =
                (double)st.st_ctim.tv_sec + 1e-9 * (double)st.st_ctim.tv_nsec <=
                since - TICK_SECONDS;
        }
        known = known && !ibl_hash_file(path, hash);
        if (known) {
            identify(&st, identity);
            ibl_append(&text, "%s %s %s\n", hash, identity, name);
        }
    }
    if (known) {
        ok = !ibl_outputs_create(r->ctx, 0, &outputs);
        if (lock >= 0)
            ibl_outputs_hold(outputs, s.folder);
        ok = ok && !ibl_outputs_add(outputs, s.path, text, strlen(text)) &&
             !ibl_outputs_commit(outputs);
        ibl_outputs_free(outputs);
    }
    free(text);
    if (lock >= 0)
        close(lock);
    end(&s);
    return ok;
}

/* ---- --prune ------------------------------------------------------------- */

/* Removes a map's outputs that are as its stamp says, and their folders if
 * nothing else is there. False: one is another's now, or stays. */
static bool remove_outputs(const char *directory, FILE *from,
                           ibl_console *console)
{
    char hash[IBL_FILE_HASH], identity[IDENTITY_BYTES], name[4096];
    bool ok = fscanf(from, STAMP " %32s %*d", hash) == 1;

    while (ok && fscanf(from, "%32s %127s", hash, identity) == 2) {
        fgetc(from);
        if (!fgets(name, sizeof name, from))
            break;
        name[strcspn(name, "\n")] = '\0';
        char *path = ibl_need(ibl_path_join(directory, name));
        if (*name && !access(path, F_OK)) {
            ok = is_same(path, hash, identity) && !unlink(path);
            if (!ok)
                ibl_console_warn(console,
                                 "%s: its map is gone, but it changed since it "
                                 "was made: remove it, if it is not needed",
                                 path);
            *strrchr(path, '/') = '\0';
            rmdir(path);
        }
        free(path);
    }
    return ok;
}

int ibl_stamps_prune(const char *directory, const ibl_maps *maps,
                     ibl_console *console)
{
    char *folder = ibl_need(ibl_path_join(directory, IBL_STAMPS));
    DIR *dir = opendir(folder);
    const struct dirent *entry;
    json_t *known = json_object();
    int pruned = 0;

    for (int i = 0; i < maps->count; i++) {
        char *path = stamp_path(folder, maps->list[i].name);
        json_object_set_new_nocheck(known, path, json_true());
        free(path);
    }
    while (dir && (entry = readdir(dir))) {
        const char *end = strrchr(entry->d_name, '.');
        char *path = ibl_need(ibl_path_join(folder, entry->d_name));
        const bool gone =
            end && !strcmp(end, ".map") && !json_object_get(known, path);
        FILE *from = gone ? fopen(path, "r") : NULL;
        if (from && remove_outputs(directory, from, console))
            pruned += !unlink(path);
        if (from)
            fclose(from);
        free(path);
    }
    if (dir)
        closedir(dir);
    json_decref(known);
    free(folder);
    return pruned;
}
