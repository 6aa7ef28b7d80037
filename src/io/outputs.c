/* SPDX-License-Identifier: MIT */
/*
 * Output files that appear all together or not at all.
 *
 * A temporary is in the directory of its target, so that both are on one file
 * system. If the target is a symbolic link, the file that it names is replaced
 * and the link stays, as with a shell's > and cp.
 *
 * Commit exchanges temporary and target where the file system can. The old
 * file then has the temporary's name until all is done, and a failure half-way
 * restores it.
 *
 * A process that is killed leaves temporaries, so each set locks the
 * directories of its targets (flock, shared). The first set in a directory that
 * nobody has locked removes what killed processes left there. Commits in a
 * directory follow one another, so that the files there are all of one set.
 *
 * ibl_outputs_abort may run in a signal handler at any point. It uses only
 * arrays of fixed size. A name is recorded before its file is made. Which of
 * two names a file has during a rename is not recorded: abort asks the file
 * system, by inode. If that fails, the last recorded state counts.
 */
#define _GNU_SOURCE
#include <errno.h>
#include <fcntl.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include "core/alloc.h"
#include "core/context.h"
#include "ibl/io.h"
#include "io/container.h"
#include "io/temporary.h"

enum {
    PATH_BYTES = 4096, /* a path and its zero, Linux's PATH_MAX */
    SUFFIX_BYTES = 64, /* maximum that a temporary's name is longer */
    MAX_LINKS = 40,    /* followed before they count as a loop */
    CHUNK = 1 << 22,   /* bytes written between two checks for a cancel */
    MAX_TRIES = 1000   /* of names for a temporary */
};

/* The state of a slot, and how abort undoes it. */
enum {
    UNUSED,  /* nothing to undo */
    NAMED,   /* remove the temporary if it exists */
    WRITTEN, /* the same; the file is complete */
    PLACING, /* find out which of the two names the file has, and undo that */
    PLACED   /* the same; the file has the target's name */
};

typedef struct slot {
    atomic_int state;
    atomic_bool replaces; /* commit found an old file at the target */
    dev_t device;         /* of the file, valid from WRITTEN on */
    ino_t inode;
    dev_t dir_device; /* of the target's directory */
    ino_t dir_inode;
    char *target; /* PATH_BYTES each; not a symbolic link */
    char *temporary;
} slot;

/* A directory that targets are in. */
typedef struct held_dir {
    dev_t device;
    ino_t inode;
    int fd;            /* locked, or -1 */
    atomic_int commit; /* the lock of its commits, NONE or OPENING */
} held_dir;

enum {
    NONE = -1,
    OPENING = -2 /* it may be there, not yet locked */
};

typedef struct made_dir {
    atomic_bool used;
    char *path;
} made_dir;

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
    ibl_ctx *ctx;
    writing later;
    int count; /* slots in use */
    int dir_count;
    bool sync;
    unsigned serial;       /* number for the next temporary's name */
    atomic_bool aborted;   /* permanent: no more files or renames */
    atomic_bool committed; /* all files are renamed; old files may be left */
    int held_count;
    held_dir held[IBL_MAX_OUTPUTS];
    slot slots[IBL_MAX_OUTPUTS];
    made_dir dirs[IBL_MAX_OUTPUT_DIRS];
    /* Two for each slot, then one for each directory. A separate array, not
     * touched before use: it takes 4 MiB. */
    char paths[2 * IBL_MAX_OUTPUTS + IBL_MAX_OUTPUT_DIRS][PATH_BYTES];
};

/* Advice for the user by errno. */
static const char *advice(int error)
{
    switch (error) {
    case ENOSPC:
    case EDQUOT:
        return ": make room there or choose another directory";
    case EACCES:
    case EPERM:
    case EROFS:
    case ENOENT:
    case ENOTDIR:
        return ": choose another directory";
    case EEXIST: /* a dangling link */
    case ELOOP:
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

ibl_status ibl_outputs_create(ibl_ctx *ctx, ibl_outputs **out)
{
    if (!ctx || !out)
        return ibl_missing(ctx, "ibl_outputs_create: out");
    ibl_outputs *set = ibl_alloc_sparse(1, sizeof *set);
    *out = NULL;
    if (!set)
        return ibl_no_memory(ctx, "a set of outputs");
    memset(set, 0, offsetof(ibl_outputs, paths));
    set->ctx = ctx;
    for (int i = 0; i < IBL_MAX_OUTPUTS; i++) {
        set->slots[i].target = set->paths[2 * i];
        set->slots[i].temporary = set->paths[2 * i + 1];
    }
    for (int i = 0; i < IBL_MAX_OUTPUT_DIRS; i++)
        set->dirs[i].path = set->paths[2 * IBL_MAX_OUTPUTS + i];
    /* A signal handler may use the set once *out is written. */
    atomic_signal_fence(memory_order_seq_cst);
    *out = set;
    return IBL_OK;
}

void ibl_outputs_sync(ibl_outputs *out, int sync)
{
    out->sync = sync;
}

/* ---- directories ---------------------------------------------------- */

/* Makes one directory; its parent must exist. */
static ibl_status make_dir(ibl_outputs *out, const char *path)
{
    struct stat st;
    if (!stat(path, &st)) {
        if (S_ISDIR(st.st_mode))
            return IBL_OK;
        return ibl_fail(out->ctx, IBL_ERR_IO,
                        "%s: is there and is no directory: choose another name",
                        path);
    }
    if (errno != ENOENT)
        return failed(out, path, "cannot be looked at");
    if (out->dir_count == IBL_MAX_OUTPUT_DIRS)
        return ibl_fail(out->ctx, IBL_ERR_ARGUMENT,
                        "%s: over %d directories to make", path,
                        IBL_MAX_OUTPUT_DIRS);

    /* Record the name before mkdir. The directory is ours: it did not exist. */
    made_dir *dir = &out->dirs[out->dir_count];
    memcpy(dir->path, path, strlen(path) + 1);
    atomic_store(&dir->used, true);
    if (!mkdir(path, 0777)) {
        out->dir_count++;
        return IBL_OK;
    }
    atomic_store(&dir->used, false);
    const int error = errno;
    if (error == EEXIST && !stat(path, &st) && S_ISDIR(st.st_mode))
        return IBL_OK; /* another process made it */
    errno = error;
    return failed(out, path, "cannot be made");
}

ibl_status ibl_outputs_mkdir(ibl_outputs *out, const char *path)
{
    char prefix[PATH_BYTES];
    if (!out)
        return ibl_missing(NULL, "ibl_outputs_mkdir: out");
    ibl_status status = check_length(out, path);
    size_t n = 0;

    while (!status && path[n]) {
        n += strspn(path + n, "/");
        n += strcspn(path + n, "/");
        memcpy(prefix, path, n);
        prefix[n] = '\0';
        status = make_dir(out, prefix);
    }
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

/* Locks a directory, once, and sweeps it if no other set has. Does not wait: a
 * lock that is not had only keeps the directory from being swept. */
static void lock_dir(ibl_outputs *out, const char *dir, const struct stat *st)
{
    for (int i = 0; i < out->held_count; i++)
        if (out->held[i].device == st->st_dev &&
            out->held[i].inode == st->st_ino)
            return;
    if (out->held_count == IBL_MAX_OUTPUTS)
        return;
    int fd = open(dir, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (fd >= 0 && !flock(fd, LOCK_EX | LOCK_NB))
        ibl_outputs_sweep(fd);
    if (fd >= 0 && flock(fd, LOCK_SH | LOCK_NB)) {
        close(fd);
        fd = -1;
    }
    /* In an order that all processes have, so that none waits for another. */
    int i = out->held_count++;
    for (; i > 0 && (out->held[i - 1].device > st->st_dev ||
                     (out->held[i - 1].device == st->st_dev &&
                      out->held[i - 1].inode > st->st_ino));
         i--)
        out->held[i] = out->held[i - 1];
    out->held[i] = (held_dir){st->st_dev, st->st_ino, fd, NONE};
}

/* A file, for the time of a commit: directories are locked for longer. */
static const char commit_lock[] = ".iblbake.lock";

static int open_lock(int dir, int flags)
{
    return openat(dir, commit_lock,
                  O_RDWR | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC | flags, 0666);
}

/* Waits until no other set is being committed in a directory. Without the file
 * there is no lock. */
static void lock_commits(held_dir *h)
{
    struct stat named, opened;

    for (int i = 0; i < MAX_TRIES; i++) {
        atomic_store(&h->commit, OPENING);
        const int fd = open_lock(h->fd, O_CREAT);
        atomic_store(&h->commit, fd < 0 ? NONE : fd);
        if (fd < 0)
            return;
        while (flock(fd, LOCK_EX) && errno == EINTR)
            ;
        /* The one before may have removed the file. */
        if (!fstatat(h->fd, commit_lock, &named, AT_SYMLINK_NOFOLLOW) &&
            !fstat(fd, &opened) && named.st_dev == opened.st_dev &&
            named.st_ino == opened.st_ino)
            return;
        atomic_store(&h->commit, NONE);
        close(fd);
    }
}

/* Only system calls. Leaves the file to one who has locked it. */
static void unlock_commits(ibl_outputs *out)
{
    for (int i = 0; i < out->held_count; i++) {
        held_dir *h = &out->held[i];
        int fd = atomic_load(&h->commit);
        if (fd == OPENING)
            fd = open_lock(h->fd, 0);
        if (fd >= 0) {
            if (!flock(fd, LOCK_EX | LOCK_NB) || errno != EWOULDBLOCK)
                unlinkat(h->fd, commit_lock, 0);
            close(fd);
        }
        atomic_store(&h->commit, NONE);
    }
}

static void unlock_dirs(ibl_outputs *out)
{
    for (int i = 0; i < out->held_count; i++)
        if (out->held[i].fd >= 0)
            close(out->held[i].fd);
    out->held_count = 0;
}

void ibl_outputs_hold(ibl_outputs *out, const char *directory)
{
    struct stat st;
    if (out && directory && !stat(directory, &st))
        lock_dir(out, directory, &st);
}

/* ---- adding --------------------------------------------------------- */

/* Replaces a target that is a symbolic link by the path it names, which may not
 * exist. */
static ibl_status follow_links(const ibl_outputs *out, char *target)
{
    int error = ELOOP;
    for (int i = 0; i < MAX_LINKS && error == ELOOP; i++) {
        char link[PATH_BYTES];
        const ssize_t n = readlink(target, link, sizeof link - 1);
        if (n < 0)
            return IBL_OK; /* not a link, or does not exist */
        link[n] = '\0';
        const size_t dir = link[0] == '/' ? 0 : dir_length(target);
        if (dir + (size_t)n >= PATH_BYTES - SUFFIX_BYTES)
            error = ENAMETOOLONG;
        else
            memcpy(target + dir, link, (size_t)n + 1);
    }
    errno = error;
    return failed(out, target, "is a link that cannot be followed");
}

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

static bool same_target(const slot *a, const slot *b)
{
    return a->dir_device == b->dir_device && a->dir_inode == b->dir_inode &&
           !strcmp(a->target + dir_length(a->target),
                   b->target + dir_length(b->target));
}

/* Sets the target of s and the identity of its directory. */
static ibl_status aim(ibl_outputs *out, const char *path, slot *s)
{
    struct stat st;
    ibl_status status = check_length(out, path);
    if (!status)
        status = check_existing(out, path);
    if (status)
        return status;
    memcpy(s->target, path, strlen(path) + 1);
    status = follow_links(out, s->target);
    if (status)
        return status;
    if (!s->target[dir_length(s->target)])
        return ibl_fail(out->ctx, IBL_ERR_IO, "%s: ends in /, a file is needed",
                        path);

    char dir[PATH_BYTES];
    name_dir(s->target, dir);
    if (stat(dir, &st))
        return failed(out, path, "its directory cannot be reached");
    s->dir_device = st.st_dev;
    s->dir_inode = st.st_ino;
    for (int i = 0; i < out->count; i++) {
        if (atomic_load(&out->slots[i].state) != UNUSED &&
            same_target(&out->slots[i], s))
            return ibl_fail(
                out->ctx, IBL_ERR_ARGUMENT,
                "%s: is the name of another output too: give each its own",
                path);
    }
    lock_dir(out, dir, &st);
    return IBL_OK;
}

/* Creates the temporary, with an unused name. */
static int create_temporary(ibl_outputs *out, slot *s)
{
    const size_t dir = dir_length(s->target);
    int fd = -1;
    memcpy(s->temporary, s->target, dir);
    for (int i = 0; i < MAX_TRIES; i++) {
        ibl_temporary_name(s->temporary + dir, PATH_BYTES - dir,
                           s->target + dir, out->serial++);
        atomic_store(&s->state, NAMED);
        fd = open(s->temporary,
                  O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0666);
        if (fd >= 0)
            break;
        atomic_store(&s->state, UNUSED);
        if (errno != EEXIST)
            break;
    }
    return fd;
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

/* File systems that cannot flush return EINVAL. */
static const char *flush_file(int fd)
{
    while (fsync(fd)) {
        if (errno == EINVAL)
            break;
        if (errno != EINTR)
            return "cannot be flushed to the disk";
    }
    return NULL;
}

/* Writes and closes a temporary; removes it on failure. Returns NULL,
 * `cancelled`, or what failed, with errno. Runs on any thread;
 * the caller's thread reports the failure. */
static const char *write_temporary(ibl_outputs *out, slot *s, int fd,
                                   const ibl_pieces *file)
{
    struct stat st;
    const char *trouble = fstat(fd, &st) ? "cannot be written" : NULL;
    for (int i = 0; i < file->count && !trouble; i++)
        trouble = write_piece(out, fd, file->piece[i]);
    if (!trouble && out->sync)
        trouble = flush_file(fd);
    int error = errno;
    /* NFS reports a full disk only here. */
    if (close(fd) && errno != EINTR && !trouble) {
        trouble = "cannot be written";
        error = errno;
    }
    if (trouble) {
        unlink(s->temporary);
        atomic_store(&s->state, UNUSED);
        errno = error;
        return trouble;
    }
    s->device = st.st_dev;
    s->inode = st.st_ino;
    atomic_store(&s->replaces, false);
    atomic_store(&s->state, WRITTEN);
    return NULL;
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
    if (atomic_load(&out->aborted))
        return ibl_fail(out->ctx, IBL_ERR_ARGUMENT,
                        "%s: its set of outputs was aborted", path);
    if (out->count == IBL_MAX_OUTPUTS)
        return ibl_fail(out->ctx, IBL_ERR_ARGUMENT,
                        "%s: over %d outputs in one set", path,
                        IBL_MAX_OUTPUTS);
    *s = &out->slots[out->count];
    const ibl_status status = aim(out, path, *s);
    if (status)
        return status;
    out->count++; /* from now on abort checks this slot */
    *fd = create_temporary(out, *s);
    if (*fd >= 0)
        return IBL_OK;
    out->count--;
    return failed(out, path, "cannot be created");
}

static ibl_status add_file(ibl_outputs *out, const char *path,
                           const ibl_pieces *file)
{
    slot *s;
    int fd;
    const ibl_status status = begin_file(out, path, &s, &fd);
    if (status)
        return status;
    const char *trouble = write_temporary(out, s, fd, file);
    if (!trouble)
        return IBL_OK;
    out->count--;
    return report(out, path, trouble);
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

ibl_status ibl_outputs_add_texture(ibl_outputs *out, const char *path,
                                   const ibl_texture *tex,
                                   ibl_container container, size_t *size)
{
    if (!out || !path)
        return ibl_missing(out ? out->ctx : NULL,
                           "ibl_outputs_add_texture: path");
    ibl_pieces file = {0};
    ibl_status status = ibl_texture_pieces(out->ctx, tex, container, &file);
    if (!status)
        status = add_file(out, path, &file);
    if (!status && size)
        *size = file.size;
    ibl_pieces_free(&file);
    return status;
}

/* ---- writing on another thread --------------------------------------- */

static void write_later(void *arg)
{
    ibl_outputs *out = arg;
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
        status = ibl_outputs_add_texture(out, path, &w.tex, container, size);
        goto done;
    }
    status = ibl_texture_pieces(out->ctx, &w.tex, container, &w.file);
    if (!status)
        status = begin_file(out, path, &w.s, &w.fd);
    if (status)
        goto done;
    if (size)
        *size = w.file.size;
    out->later = w;
    if (!ibl_task_start(out->ctx, write_later, out))
        write_later(out);
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
    ibl_outputs_abort(out);
    errno = w->error;
    const ibl_status status = report(out, w->s->target, w->trouble);
    out->later.trouble = NULL;
    return status;
}

/* ---- commit and abort ----------------------------------------------- */

/* Exchanges two names. ENOSYS or EINVAL: not supported. */
static int exchange(const char *a, const char *b)
{
    return renameat2(AT_FDCWD, a, AT_FDCWD, b, RENAME_EXCHANGE);
}

/* Whether path is the slot's file. errno if not: 0 if it is another file,
 * ENOENT if there is none, else unknown. */
static bool is_ours(const slot *s, const char *path)
{
    struct stat st;
    errno = 0;
    return !lstat(path, &st) && st.st_dev == s->device && st.st_ino == s->inode;
}

/* Restores the old file. If the file system cannot exchange names, rename has
 * removed the old file: then the new one stays. */
static void take_back(slot *s)
{
    if (!atomic_load(&s->replaces)) {
        unlink(s->target);
        return;
    }
    atomic_store(&s->state, PLACING);
    if (exchange(s->temporary, s->target)) {
        rename(s->temporary, s->target); /* the file system cannot exchange */
        return;
    }
    atomic_store(&s->state, WRITTEN);
    unlink(s->temporary);
}

/* Removes one file of the set and restores the old one. Only system calls. */
static void undo(slot *s)
{
    const int state = atomic_load(&s->state);
    if (state == UNUSED)
        return;
    if (state < PLACING || is_ours(s, s->temporary))
        unlink(s->temporary);
    else if (is_ours(s, s->target) ||
             (state == PLACED && errno && errno != ENOENT))
        take_back(s);
    atomic_store(&s->state, UNUSED);
}

/* Removes old files after a commit; they have the temporaries' names. */
static void remove_old(ibl_outputs *out)
{
    for (int i = 0; i < IBL_MAX_OUTPUTS; i++) {
        if (atomic_load(&out->slots[i].state) != UNUSED)
            unlink(out->slots[i].temporary);
        atomic_store(&out->slots[i].state, UNUSED);
    }
    for (int i = 0; i < IBL_MAX_OUTPUT_DIRS; i++)
        atomic_store(&out->dirs[i].used, false);
}

void ibl_outputs_abort(ibl_outputs *out)
{
    if (!out)
        return;
    const int saved = errno;
    if (atomic_load(&out->committed)) {
        unlock_commits(out);
        remove_old(out);
        errno = saved;
        return;
    }
    atomic_store(&out->aborted, true);
    for (int i = IBL_MAX_OUTPUTS - 1; i >= 0; i--)
        undo(&out->slots[i]);
    unlock_commits(out);
    for (int i = IBL_MAX_OUTPUT_DIRS - 1; i >= 0; i--) {
        if (atomic_load(&out->dirs[i].used))
            rmdir(out->dirs[i].path); /* fails if other files are in it */
        atomic_store(&out->dirs[i].used, false);
    }
    errno = saved;
}

void ibl_outputs_free(ibl_outputs *out)
{
    if (out)
        end_writing(out);
    ibl_outputs_abort(out);
    if (out)
        unlock_dirs(out);
    ibl_free(out);
}

/* Exchanges temporary and target; renames where that is impossible. */
static int give_name(const slot *s)
{
    if (!atomic_load(&s->replaces))
        return rename(s->temporary, s->target);
    if (!exchange(s->temporary, s->target))
        return 0;
    if (errno != EINVAL && errno != ENOSYS && errno != EPERM &&
        errno != EOPNOTSUPP)
        return -1;
    return rename(s->temporary, s->target);
}

/* Gives the file its target's name. After it the temporary's name belongs to
 * the old file, or to none. */
static int put_in_place(slot *s)
{
    struct stat st;
    const bool replaces = !lstat(s->target, &st);
    if (!replaces && errno != ENOENT)
        return -1;
    if (replaces && S_ISDIR(st.st_mode)) {
        errno = EISDIR; /* exchange would replace a directory */
        return -1;
    }
    atomic_store(&s->replaces, replaces);
    atomic_store(&s->state, PLACING);
    if (give_name(s))
        return -1;
    atomic_store(&s->state, PLACED);
    return 0;
}

/* Flushes the directory of path. Ignores directories that cannot be flushed. */
static ibl_status flush_dir(ibl_outputs *out, const char *path)
{
    ibl_status status = IBL_OK;
    char dir[PATH_BYTES];
    name_dir(path, dir);
    const int fd = open(dir, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (fd < 0)
        return IBL_OK; /* the directory is writable but not readable */
    if (fsync(fd) && errno == EIO)
        status = failed(out, path, "its directory cannot be flushed");
    close(fd);
    return status;
}

static ibl_status flush_dirs(ibl_outputs *out)
{
    ibl_status status = IBL_OK;
    for (int i = 0; !status && i < out->count; i++) {
        bool known = false;
        for (int j = 0; j < i; j++)
            known |= out->slots[i].dir_device == out->slots[j].dir_device &&
                     out->slots[i].dir_inode == out->slots[j].dir_inode;
        if (!known)
            status = flush_dir(out, out->slots[i].target);
    }
    for (int i = 0; !status && i < out->dir_count; i++)
        status = flush_dir(out, out->dirs[i].path);
    return status;
}

ibl_status ibl_outputs_commit(ibl_outputs *out)
{
    ibl_status status = ibl_outputs_wait(out);
    for (int i = 0; !status && i < out->held_count; i++)
        if (out->held[i].fd >= 0)
            lock_commits(&out->held[i]);
    for (int i = 0; !status && i < out->count; i++) {
        if (ibl_cancelled(out->ctx) || atomic_load(&out->aborted))
            status = IBL_ERR_CANCELLED;
        else if (put_in_place(&out->slots[i]))
            status =
                failed(out, out->slots[i].target, "cannot be put in place");
    }
    if (!status && out->sync)
        status = flush_dirs(out);
    if (status) {
        ibl_outputs_abort(out);
        return status;
    }
    atomic_store(&out->committed, true);
    unlock_commits(out);
    remove_old(out);
    out->count = out->dir_count = 0;
    atomic_store(&out->committed, false);
    return IBL_OK;
}
