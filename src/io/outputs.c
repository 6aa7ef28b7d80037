/* SPDX-License-Identifier: MIT */
/*
 * Output files that appear all together or not at all: each is written to a
 * temporary, and commit renames them. A temporary is in the directory of its
 * target, so that both are on one file system.
 *
 * A commit locks the directories of its targets (flock), so that the files
 * there are all of one set, and removes what killed processes left in them.
 *
 * ibl_outputs_abort_all may run in a signal handler at any point. It uses only
 * arrays of fixed size, and waits for the changes of other threads.
 */
#include <dirent.h>
#include <errno.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#include "core/alloc.h"
#include "core/context.h"
#include "ibl/io.h"
#include "io/container.h"
#include "io/input.h"
#include "port/port.h"

enum {
    PATH_BYTES = IBL_PORT_PATH,
    SUFFIX_BYTES = 64,     /* maximum that a temporary's name is longer */
    KEPT_NAME_BYTES = 128, /* most of the target's name in a temporary's */
    CHUNK = 1 << 22,       /* bytes written between two checks for a cancel */
    SEARCHED = 64          /* directories that are remembered */
};

/* A file of the set. */
typedef struct slot {
    struct stat dir; /* of the target */
    bool leads;      /* the first slot of that in a commit, which locks it */
    int lock;        /* of that, or -1 */
    char hash[IBL_FILE_HASH]; /* of the bytes */
    char target[PATH_BYTES];  /* not a symbolic link */
    char temporary[PATH_BYTES];
} slot;

/* A texture that another thread is writing. */
typedef struct writing {
    bool on;
    slot *s;
    int fd;
    ibl_texture tex;
    ibl_pieces file;
    const char *trouble; /* result of write_temporary */
    int error;           /* errno for trouble */
} writing;

struct ibl_outputs {
    _Atomic(ibl_outputs *) next; /* in all_sets */
    ibl_ctx *ctx;
    writing later;
    atomic_int count;     /* slots in use */
    atomic_int dir_count; /* directories that were made */
    bool sync;
    bool holds;          /* the caller has a directory locked */
    struct stat held;    /* that */
    atomic_bool aborted; /* permanent: no more files or renames */
    atomic_bool changes; /* on a thread that no signal stops */
    /* 4 MiB, not touched before use. */
    slot slots[IBL_MAX_OUTPUTS];
    char dirs[IBL_MAX_OUTPUT_DIRS][PATH_BYTES];
};

/* The sets that are not freed. A signal handler reads the list. */
static _Atomic(ibl_outputs *) all_sets;
static pthread_mutex_t list_lock = PTHREAD_MUTEX_INITIALIZER; /* for changes */
static atomic_bool ending; /* the program is: sets stay in memory */

/* Advice for the user by errno. */
static const char *advice(int error)
{
    switch (error) {
    case ENOSPC:
#ifdef EDQUOT
    case EDQUOT:
#endif
        return ": make room there or choose another directory";
    case EACCES:
    case EPERM:
    case EROFS:
    case ENOENT:
    case ENOTDIR:
        return ": choose another directory";
    case EEXIST:
        return ": choose another name";
    case ENAMETOOLONG:
        return ": choose a shorter name";
    case EFBIG:
        return ": raise the limit on files or ask for smaller outputs";
    default:
        return "";
    }
}

static ibl_status failed(const ibl_outputs *out, const char *path,
                         const char *what)
{
    const int error = errno;
    return ibl_fail(out->ctx, IBL_ERR_IO, "%s: %s: %s%s", path, what,
                    strerror(error), advice(error));
}

static ibl_status check_length(const ibl_outputs *out, const char *path)
{
    const size_t limit = PATH_BYTES - 1 - SUFFIX_BYTES;
    if (!path || !path[0])
        return ibl_fail(out->ctx, IBL_ERR_ARGUMENT, "an output without a path");
    if (strlen(path) > limit)
        return ibl_fail(out->ctx, IBL_ERR_ARGUMENT,
                        "%.40s...: a path of %zu bytes: the limit is %zu", path,
                        strlen(path), limit);
    return IBL_OK;
}

ibl_status ibl_outputs_create(ibl_ctx *ctx, int sync, ibl_outputs **out)
{
    if (!ctx || !out)
        return ibl_missing(ctx, "ibl_outputs_create: out");
    ibl_outputs *set = ibl_alloc_sparse(1, sizeof *set);
    *out = NULL;
    if (!set)
        return ibl_no_memory(ctx, "a set of outputs");
    memset(set, 0, offsetof(ibl_outputs, slots));
    set->ctx = ctx;
    set->sync = sync;
    pthread_mutex_lock(&list_lock);
    set->next = all_sets;
    all_sets = set;
    pthread_mutex_unlock(&list_lock);
    *out = set;
    return IBL_OK;
}

void ibl_outputs_hold(ibl_outputs *out, const char *directory)
{
    if (out)
        out->holds = !stat(directory, &out->held);
}

/* Between these no signal stops the thread, and ibl_outputs_abort_all waits, so
 * that it finds each file of the set. False: the set is aborted. */
static bool begin_change(ibl_outputs *out)
{
    ibl_port_hold_signals(true);
    out->changes = true;
    return !out->aborted;
}

static void end_change(ibl_outputs *out)
{
    out->changes = false;
    ibl_port_hold_signals(false);
}

/* ---- directories ---------------------------------------------------- */

/* Makes a directory and those above it that are missing. */
static ibl_status make_dir(ibl_outputs *out, char *path)
{
    char *slash = strrchr(path, '/');
    struct stat st;
    if (!stat(path, &st)) {
        if (S_ISDIR(st.st_mode))
            return IBL_OK;
        return ibl_fail(out->ctx, IBL_ERR_IO,
                        "%s: is there and is no directory: choose another name",
                        path);
    }
    if (errno != ENOENT && errno != ENOTDIR)
        return failed(out, path, "cannot be looked at");
    if (slash && slash > path) {
        *slash = '\0';
        const ibl_status status = make_dir(out, path);
        *slash = '/';
        if (status || !slash[1])
            return status;
    }
    if (out->dir_count == IBL_MAX_OUTPUT_DIRS)
        return ibl_fail(out->ctx, IBL_ERR_ARGUMENT,
                        "%s: over %d directories to make", path,
                        IBL_MAX_OUTPUT_DIRS);

    memcpy(out->dirs[out->dir_count], path, strlen(path) + 1);
    if (!mkdir(path, 0777)) {
        out->dir_count++;
        return IBL_OK;
    }
    const int error = errno;
    if (error == EEXIST && !stat(path, &st) && S_ISDIR(st.st_mode))
        return IBL_OK; /* another process made it */
    errno = error;
    return failed(out, path, "cannot be made");
}

ibl_status ibl_outputs_mkdir(ibl_outputs *out, const char *path)
{
    char copy[PATH_BYTES];
    if (!out)
        return ibl_missing(NULL, "ibl_outputs_mkdir: out");
    ibl_status status = check_length(out, path);
    if (status)
        return status;
    memcpy(copy, path, strlen(path) + 1);
    status = begin_change(out) ? make_dir(out, copy) : IBL_ERR_CANCELLED;
    end_change(out);
    return status;
}

/* Length of the directory part of a path, including the slash. */
static size_t dir_length(const char *path)
{
    const char *slash = strrchr(path, '/');
    return slash ? (size_t)(slash + 1 - path) : 0;
}

static void name_dir(const char *path, char dir[PATH_BYTES])
{
    const size_t n = dir_length(path);
    memcpy(dir, path, n);
    memcpy(dir + n, ".", 2);
}

/* ---- names of temporaries -------------------------------------------- */

static const char mark[] = ".iblbake-";

/* A hash of what a PID is valid in, FNV-1a of 32 bits. */
static unsigned place(void)
{
    char names[IBL_PORT_PATH];
    uint32_t hash = 2166136261u;

    ibl_port_place(names);
    for (const char *c = names; *c; c++)
        hash = (hash ^ (unsigned char)*c) * 16777619u;
    return hash;
}

/* Sets the temporary's name: ".NAME.iblbake-PLACE-PID-N.tmp". */
static void name_temporary(slot *s)
{
    static atomic_uint serial;
    const size_t dir = dir_length(s->target);

    memcpy(s->temporary, s->target, dir);
    snprintf(s->temporary + dir, PATH_BYTES - dir, ".%.*s%s%08x-%ld-%u.tmp",
             KEPT_NAME_BYTES, s->target + dir, mark, place(), (long)getpid(),
             atomic_fetch_add(&serial, 1));
}

/* Whether a name is that of a temporary of a process that was killed. */
static bool is_left(const char *name, unsigned here)
{
    const char *last = NULL;
    unsigned made_by, serial;
    int end = 0;
    long pid;

    for (const char *at = name; (at = strstr(at, mark)); at++)
        last = at;
    return name[0] == '.' && last && last > name &&
           sscanf(last + sizeof mark - 1, "%8x-%ld-%u.tmp%n", &made_by, &pid,
                  &serial, &end) == 3 &&
           end && !last[sizeof mark - 1 + (size_t)end] && made_by == here &&
           ibl_port_is_gone(pid);
}

/* Removes temporaries of killed processes. */
static void sweep(const char *directory)
{
    DIR *dir = opendir(directory);
    const unsigned here = place();
    char path[2 * PATH_BYTES];
    const struct dirent *d;

    while (dir && (d = readdir(dir))) {
        snprintf(path, sizeof path, "%s/%s", directory, d->d_name);
        if (is_left(d->d_name, here))
            unlink(path);
    }
    if (dir)
        closedir(dir);
}

/* ---- adding --------------------------------------------------------- */

/* Refuses existing targets that cannot be replaced. */
static ibl_status check_existing(const ibl_outputs *out, const char *path)
{
    struct stat st;
    if (stat(path, &st))
        return IBL_OK; /* if the directory is missing, create fails */
    if (S_ISDIR(st.st_mode))
        return ibl_fail(
            out->ctx, IBL_ERR_IO,
            "%s: is a directory, a file cannot replace it: choose another name",
            path);
    if (!S_ISREG(st.st_mode))
        return ibl_fail(out->ctx, IBL_ERR_IO,
                        "%s: is a %s; outputs are renamed into place and can "
                        "only replace files",
                        path,
                        S_ISCHR(st.st_mode) || S_ISBLK(st.st_mode) ? "device"
                        : S_ISFIFO(st.st_mode)                     ? "pipe"
                                                                   : "socket");
    if (access(path, W_OK))
        return failed(out, path, "cannot be replaced");
    return IBL_OK;
}

/* The order in which all processes lock directories, so that none waits for one
 * that waits for it; 0: the same directory. */
static int compare_dirs(const struct stat *a, const struct stat *b)
{
    if (a->st_dev != b->st_dev)
        return a->st_dev < b->st_dev ? -1 : 1;
    return a->st_ino < b->st_ino ? -1 : a->st_ino > b->st_ino;
}

static bool is_link(const char *path)
{
    struct stat st;
    return !lstat(path, &st) && S_ISLNK(st.st_mode);
}

/* Sets the target of s, the identity of its directory, and the temporary's
 * name. Of a link the file that it names is the target. */
static ibl_status aim(ibl_outputs *out, const char *path, slot *s)
{
    char dir[PATH_BYTES];
    ibl_status status = check_length(out, path);
    if (!status)
        status = check_existing(out, path);
    if (status)
        return status;
    memcpy(s->target, path, strlen(path) + 1);
    if (is_link(path)) {
        if (!realpath(path, s->target))
            return ibl_fail(out->ctx, IBL_ERR_IO,
                            "%s: is a link that cannot be followed: %s: choose "
                            "another name",
                            path, strerror(errno));
        status = check_length(out, s->target);
        if (status)
            return status;
    }
    if (!s->target[dir_length(s->target)])
        return ibl_fail(out->ctx, IBL_ERR_IO, "%s: ends in /, a file is needed",
                        path);

    name_dir(s->target, dir);
    if (stat(dir, &s->dir))
        return failed(out, path, "its directory cannot be reached");
    s->lock = -1;
    s->leads = false;
    for (int i = 0; i < out->count; i++)
        if (!compare_dirs(&out->slots[i].dir, &s->dir) &&
            !strcmp(out->slots[i].target + dir_length(out->slots[i].target),
                    s->target + dir_length(s->target)))
            return ibl_fail(
                out->ctx, IBL_ERR_ARGUMENT,
                "%s: is the name of another output too: give each its own",
                path);
    name_temporary(s);
    return IBL_OK;
}

static const char cancelled[] = "cancelled";

static const char *write_piece(const ibl_outputs *out, int fd, ibl_piece piece)
{
    const unsigned char *bytes = piece.bytes;
    while (piece.size) {
        const size_t chunk = piece.size < CHUNK ? piece.size : CHUNK;
        const ssize_t n = write(fd, bytes, chunk);
        if (ibl_cancelled(out->ctx))
            return cancelled;
        if (n < 0 && errno == EINTR)
            continue;
        if (n < 0)
            return "cannot be written";
        bytes += n;
        piece.size -= (size_t)n;
    }
    return NULL;
}

/* Writes and closes a temporary. Returns NULL, `cancelled`, or what failed,
 * with errno. Runs on any thread; the caller's thread reports the failure. */
static const char *write_temporary(const ibl_outputs *out, slot *s, int fd,
                                   const ibl_pieces *file)
{
    const char *trouble = NULL;
    ibl_hash hash;

    ibl_hash_begin(&hash);
    for (int i = 0; i < file->count && !trouble; i++) {
        trouble = write_piece(out, fd, file->piece[i]);
        ibl_hash_add(&hash, file->piece[i].bytes, file->piece[i].size);
    }
    ibl_hash_end(&hash, s->hash);
    if (!trouble && out->sync && fsync(fd) && errno != EINVAL)
        trouble = "cannot be flushed to the disk";
    const int error = errno;
    /* NFS reports a full disk only here. */
    if (close(fd) && errno != EINTR && !trouble)
        return "cannot be written";
    errno = error;
    return trouble;
}

static ibl_status report(const ibl_outputs *out, const char *path,
                         const char *trouble)
{
    return trouble == cancelled ? IBL_ERR_CANCELLED
                                : failed(out, path, trouble);
}

/* Creates an empty temporary in the next slot. */
static ibl_status begin_file(ibl_outputs *out, const char *path, slot **s,
                             int *fd)
{
    if (ibl_cancelled(out->ctx))
        return IBL_ERR_CANCELLED;
    if (out->count == IBL_MAX_OUTPUTS)
        return ibl_fail(out->ctx, IBL_ERR_ARGUMENT,
                        "%s: over %d outputs in one set", path,
                        IBL_MAX_OUTPUTS);
    *s = &out->slots[out->count];
    ibl_status status = aim(out, path, *s);
    if (status)
        return status;
    if (!begin_change(out)) {
        status = ibl_fail(out->ctx, IBL_ERR_ARGUMENT,
                          "%s: its set of outputs was aborted", path);
    } else {
        unlink((*s)->temporary); /* of a killed process that had our PID */
        *fd = ibl_port_create((*s)->temporary);
        if (*fd >= 0)
            out->count++;
        else
            status = failed(out, path, "cannot be created");
    }
    end_change(out);
    return status;
}

static ibl_status add_file(ibl_outputs *out, const char *path,
                           const ibl_pieces *file)
{
    slot *s;
    int fd;
    ibl_status status = begin_file(out, path, &s, &fd);
    if (status)
        return status;
    const char *trouble = write_temporary(out, s, fd, file);
    if (!trouble)
        return IBL_OK;
    status = report(out, path, trouble);
    if (begin_change(out)) {
        unlink(s->temporary);
        out->count--;
    }
    end_change(out);
    return status;
}

ibl_status ibl_outputs_add(ibl_outputs *out, const char *path,
                           const void *bytes, size_t size)
{
    if (!out || !path || (!bytes && size))
        return ibl_missing(out ? out->ctx : NULL,
                           "ibl_outputs_add: path or bytes");
    ibl_piece whole = {bytes, size};
    const ibl_pieces file = {.piece = &whole, .size = size, .count = 1};
    return add_file(out, path, &file);
}

static ibl_status add_texture(ibl_outputs *out, const char *path,
                              const ibl_texture *tex, ibl_container container,
                              size_t *size)
{
    ibl_pieces file = {0};
    ibl_status status = ibl_texture_pieces(out->ctx, tex, container, &file);
    if (!status)
        status = add_file(out, path, &file);
    if (!status && size)
        *size = file.size;
    ibl_pieces_free(&file);
    return status;
}

/* Removes what is not committed, by system calls only. */
static void abort_set(ibl_outputs *out)
{
    const int saved = errno;

    out->aborted = true;
    for (; out->count > 0; out->count--)
        unlink(out->slots[out->count - 1].temporary);
    for (; out->dir_count > 0; out->dir_count--)
        rmdir(out->dirs[out->dir_count - 1]); /* fails if files are in it */
    errno = saved;
}

/* ---- writing on another thread --------------------------------------- */

static void write_later(void *arg, int job, int worker)
{
    ibl_outputs *out = arg;
    (void)job;
    (void)worker;
    writing *w = &out->later;
    w->trouble = write_temporary(out, w->s, w->fd, &w->file);
    w->error = errno;
}

ibl_status ibl_outputs_take_texture(ibl_outputs *out, const char *path,
                                    ibl_texture *tex, ibl_container container,
                                    size_t *size)
{
    if (!out || !path || !tex)
        return ibl_missing(out ? out->ctx : NULL,
                           "ibl_outputs_take_texture: path or tex");
    writing w = {.on = true, .tex = *tex};
    ibl_status status;

    *tex = (ibl_texture){0};
    if (out->later.on) {
        status = add_texture(out, path, &w.tex, container, size);
        goto done;
    }
    status = ibl_texture_pieces(out->ctx, &w.tex, container, &w.file);
    if (status || (status = begin_file(out, path, &w.s, &w.fd)))
        goto done;
    if (size)
        *size = w.file.size;
    out->later = w;
    if (!ibl_port_shares_files || !ibl_task_start(out->ctx, write_later, out))
        write_later(out, 0, 0);
    return IBL_OK;

done:
    ibl_pieces_free(&w.file);
    ibl_texture_free(&w.tex);
    return status;
}

static void end_writing(ibl_outputs *out)
{
    if (!out->later.on)
        return;
    ibl_task_finish(out->ctx);
    out->later.on = false;
    ibl_pieces_free(&out->later.file);
    ibl_texture_free(&out->later.tex);
}

ibl_status ibl_outputs_wait(ibl_outputs *out)
{
    if (!out)
        return ibl_missing(NULL, "ibl_outputs_wait: out");
    const writing *w = &out->later;
    end_writing(out);
    if (!w->trouble)
        return IBL_OK;
    abort_set(out);
    errno = w->error;
    const ibl_status status = report(out, w->s->target, w->trouble);
    out->later.trouble = NULL;
    return status;
}

const char *ibl_outputs_hash(ibl_outputs *out, const char *path)
{
    char real[PATH_BYTES];

    if (!out || !path)
        return "";
    end_writing(out);
    if (is_link(path) && realpath(path, real))
        path = real; /* the target of a link */
    for (int i = 0; i < out->count; i++)
        if (!strcmp(out->slots[i].target, path))
            return out->slots[i].hash;
    return "";
}

/* ---- commit and abort ----------------------------------------------- */

void ibl_outputs_abort_all(void)
{
    const struct timespec nap = {.tv_nsec = 1000000};

    ending = true;
    for (ibl_outputs *out = all_sets; out; out = out->next)
        out->aborted = true;
    for (ibl_outputs *out = all_sets; out; out = out->next) {
        while (out->changes)
            nanosleep(&nap, NULL);
        abort_set(out);
    }
}

void ibl_outputs_free(ibl_outputs *out)
{
    if (!out)
        return;
    end_writing(out);
    abort_set(out);
    pthread_mutex_lock(&list_lock);
    _Atomic(ibl_outputs *) *at = &all_sets;
    while (*at != out)
        at = &(*at)->next;
    *at = (ibl_outputs *)out->next;
    pthread_mutex_unlock(&list_lock);
    if (!ending) /* else a handler may still be at it */
        ibl_free(out);
}

/* Waits for the lock of the slot's directory and sweeps it. What has no locks
 * is not locked, as a directory of NFS. */
static void lock_dir(ibl_outputs *out, slot *s)
{
    /* One search of a directory by a process, not for each of its sets. */
    static _Atomic uint64_t searched[SEARCHED];
    const uint64_t id = (uint64_t)s->dir.st_dev << 48 ^ s->dir.st_ino;
    const struct timespec nap = {.tv_nsec = 2000000};
    const bool mine = out->holds && !compare_dirs(&out->held, &s->dir);
    char dir[PATH_BYTES];

    s->leads = true;
    name_dir(s->target, dir);
    while (!mine && !ibl_port_lock_folder(dir, &s->lock) &&
           !ibl_cancelled(out->ctx))
        nanosleep(&nap, NULL);
    if (atomic_exchange(&searched[id % SEARCHED], id) != id)
        sweep(dir);
}

static void lock_dirs(ibl_outputs *out)
{
    slot *next, *last = NULL;

    do {
        next = NULL;
        for (int i = 0; i < out->count; i++) {
            slot *s = &out->slots[i];
            if ((!last || compare_dirs(&s->dir, &last->dir) > 0) &&
                (!next || compare_dirs(&s->dir, &next->dir) < 0))
                next = s;
        }
        if (next)
            lock_dir(out, next);
        last = next;
    } while (next);
}

static ibl_status rename_all(ibl_outputs *out)
{
    for (int i = 0; i < out->count; i++) {
        const slot *s = &out->slots[i];
        if (rename(s->temporary, s->target))
            return failed(
                out, s->target,
                i ? "cannot be put in place, as others of its set were"
                  : "cannot be put in place");
    }
    return IBL_OK;
}

/* Flushes the directory of path. */
static ibl_status flush_dir(ibl_outputs *out, const char *path)
{
    char dir[PATH_BYTES];
    name_dir(path, dir);
    return ibl_port_flush_folder(dir)
               ? IBL_OK
               : failed(out, path, "its directory cannot be flushed");
}

ibl_status ibl_outputs_commit(ibl_outputs *out)
{
    ibl_status status = ibl_outputs_wait(out);
    if (status)
        return status;

    const int count = out->count; /* an abort may come */
    lock_dirs(out);
    status = !begin_change(out) || ibl_cancelled(out->ctx) ? IBL_ERR_CANCELLED
                                                           : rename_all(out);
    for (int i = 0; i < count; i++) {
        slot *s = &out->slots[i];
        if (s->leads && !status && out->sync)
            status = flush_dir(out, s->target);
        if (s->lock >= 0)
            close(s->lock);
        s->lock = -1;
        s->leads = false;
    }
    for (int i = 0; !status && out->sync && i < out->dir_count; i++)
        status = flush_dir(out, out->dirs[i]);
    if (!status)
        out->count = out->dir_count = 0;
    else
        abort_set(out);
    end_change(out);
    return status;
}
