/* SPDX-License-Identifier: MIT */
/*
 * walk [-e EVERY] [-k KIND] [-1op] PRELOAD BEFORE RUN COMMAND...
 *
 * Runs a command in folder RUN, which is made to be as BEFORE each time, with
 * each of its calls to the C library failing once (preload.c), and judges it:
 *   - status 0: files and what is printed are those of a run without a fault,
 *     or a note of iblview's says what the picture is without;
 *   - status 1: files are as before, or each is old or new if a rename or what
 *     follows it failed, and there is one line. It says what failed, and names
 * a file unless memory or a thread was missing;
 *   - killed by SIGKILL: each file is old or new, what else is there are
 *     temporaries, and the next run leaves what a run without a fault leaves;
 *   - by SIGTERM: files are all as before, or all new.
 * Prints a line for each fault that it finds, and at the end by kind how many
 * calls there are and how many runs.
 *   -e  of all runs, only each EVERYth, but some of each kind
 *   -k  only calls of this kind; can be repeated
 *   -o  only calls by the program's own code, not by libraries
 *   -1  only faults that come once
 *   -p  with status 1 or by SIGTERM, part of the files may be new
 */
#define _GNU_SOURCE
#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <ftw.h>
#include <signal.h>
#include <spawn.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include "faults.h"

extern char **environ;

enum {
    MAX_FILES = 256,
    PATH_BYTES = 1024,
    OUTPUT_BYTES = 1 << 16
};

/* ---- what is in a folder ------------------------------------------------- */

typedef struct entry {
    char *path; /* from the folder */
    char *bytes;
    size_t size; /* SIZE_MAX: a folder */
} entry;

typedef struct tree {
    entry file[MAX_FILES];
    int count;
} tree;

static _Noreturn void die(const char *what)
{
    perror(what);
    exit(2);
}

static char *load(const char *path, size_t *size)
{
    const int fd = open(path, O_RDONLY);
    struct stat st;

    if (fd < 0 || fstat(fd, &st))
        die(path);
    char *bytes = malloc((size_t)st.st_size + 1);
    *size = 0;
    for (ssize_t n; bytes && (n = read(fd, bytes + *size,
                                       (size_t)st.st_size + 1 - *size)) > 0;)
        *size += (size_t)n;
    if (!bytes || *size > (size_t)st.st_size)
        die(path);
    close(fd);
    return bytes;
}

static void tree_free(tree *t)
{
    for (int i = 0; i < t->count; i++) {
        free(t->file[i].path);
        free(t->file[i].bytes);
    }
    t->count = 0;
}

static const entry *tree_find(const tree *t, const char *path)
{
    for (int i = 0; i < t->count; i++)
        if (!strcmp(t->file[i].path, path))
            return &t->file[i];
    return NULL;
}

/* A folder comes before what is in it. */
static void tree_add(tree *t, const char *root, const char *below)
{
    char path[PATH_BYTES];
    struct stat st;

    snprintf(path, sizeof path, "%s/%s", root, below);
    if (lstat(path, &st) || t->count == MAX_FILES)
        die(path);
    if (*below) {
        entry *e = &t->file[t->count++];
        *e = (entry){.path = strdup(below), .size = SIZE_MAX};
        if (!S_ISDIR(st.st_mode))
            e->bytes = load(path, &e->size);
    }
    DIR *dir = S_ISDIR(st.st_mode) ? opendir(path) : NULL;
    for (struct dirent *d; dir && (d = readdir(dir));) {
        if (!strcmp(d->d_name, ".") || !strcmp(d->d_name, ".."))
            continue;
        snprintf(path, sizeof path, "%s%s%s", below, *below ? "/" : "",
                 d->d_name);
        tree_add(t, root, path);
    }
    if (dir)
        closedir(dir);
}

static tree tree_of(const char *root)
{
    tree t = {.count = 0};
    tree_add(&t, root, "");
    return t;
}

static bool same(const entry *a, const entry *b)
{
    return a && b && a->size == b->size &&
           (a->size == SIZE_MAX || !memcmp(a->bytes, b->bytes, a->size));
}

/* Makes the folder, which has `is`, have what `want` has. */
static void restore(const char *root, const tree *is, const tree *want)
{
    char path[PATH_BYTES];

    for (int i = is->count; i-- > 0;) {
        const entry *e = &is->file[i];
        snprintf(path, sizeof path, "%s/%s", root, e->path);
        if (!same(e, tree_find(want, e->path)) && remove(path))
            die(path);
    }
    for (int i = 0; i < want->count; i++) {
        const entry *e = &want->file[i];
        if (same(e, tree_find(is, e->path)))
            continue;
        snprintf(path, sizeof path, "%s/%s", root, e->path);
        if (e->size == SIZE_MAX) {
            if (mkdir(path, 0777))
                die(path);
            continue;
        }
        const int fd = open(path, O_WRONLY | O_CREAT | O_TRUNC, 0666);
        if (fd < 0 || write(fd, e->bytes, e->size) != (ssize_t)e->size ||
            close(fd))
            die(path);
    }
}

static bool is_temporary(const char *path)
{
    const size_t n = strlen(path);
    const char *name = strrchr(path, '/');

    name = name ? name + 1 : path;
    return *name == '.' && strstr(name, ".iblbake-") && n > 4 &&
           !strcmp(path + n - 4, ".tmp");
}

/* What is in a but not the same in b; NULL: nothing. */
static const char *missing(const tree *a, const tree *b, bool temporaries)
{
    for (int i = 0; i < a->count; i++)
        if (!same(&a->file[i], tree_find(b, a->file[i].path)) &&
            !(temporaries && is_temporary(a->file[i].path)))
            return a->file[i].path;
    return NULL;
}

static const char *differ(const tree *a, const tree *b, bool temporaries)
{
    const char *path = missing(a, b, temporaries);
    return path ? path : missing(b, a, temporaries);
}

/* ---- a run --------------------------------------------------------------- */

static struct {
    const char *preload, *root;
    char **command;
    bool own, once, parts;
    tree before, after;
    char printed[OUTPUT_BYTES], said[OUTPUT_BYTES];
    fault_counts *counts;
    int counts_fd, out_fd, err_fd;
} walk;

typedef struct result {
    int status; /* as of waitpid */
    tree files;
    char out[OUTPUT_BYTES], err[OUTPUT_BYTES];
} result;

static void take_output(int fd, char to[OUTPUT_BYTES])
{
    const ssize_t n = pread(fd, to, OUTPUT_BYTES - 1, 0);

    to[n < 0 ? 0 : n] = '\0';
    if (ftruncate(fd, 0))
        die("output");
    lseek(fd, 0, SEEK_SET);
}

/* Runs the command with a fault; NULL: with none, not even preloaded. */
static void run(const char *fault, result *r)
{
    const pid_t pid = fork();

    if (pid < 0)
        die("fork");
    if (!pid) {
        char fd[16];
        if (chdir(walk.root) || dup2(walk.out_fd, 1) < 0 ||
            dup2(walk.err_fd, 2) < 0)
            _exit(97);
        snprintf(fd, sizeof fd, "%d", walk.counts_fd);
        if (fault) {
            setenv("LD_PRELOAD", walk.preload, 1);
            setenv("FAULT", fault, 1);
            setenv("FAULT_COUNTS", fd, 1);
            if (walk.own)
                setenv("FAULT_FROM", "own", 1);
        }
        alarm(120); /* what hangs */
        execvp(walk.command[0], walk.command);
        _exit(96);
    }
    if (waitpid(pid, &r->status, 0) != pid)
        die("waitpid");
    take_output(walk.out_fd, r->out);
    take_output(walk.err_fd, r->err);
    r->files = tree_of(walk.root);
}

/* ---- judging it ---------------------------------------------------------- */

static bool names_a_file(const char *line, const tree *t)
{
    for (int i = 0; i < t->count; i++) {
        const char *slash = strrchr(t->file[i].path, '/');
        if (strstr(line, slash ? slash + 1 : t->file[i].path))
            return true;
    }
    return strchr(line, '/') != NULL;
}

/* What is wrong with the line that a failure left; NULL: nothing. */
static const char *judge_line(const char *line, int kind, int error)
{
    while (!strncmp(line, "iblview: note: ", 15) && strchr(line, '\n'))
        line = strchr(line, '\n') + 1;
    const char *end = strchr(line, '\n');
    /* Where memory stays away, the program may end while it reports that. */
    if (end && kind == FAULT_MEMORY && strstr(end, ": no memory: "))
        end = strchr(end + 1, '\n');

    if (!end || end[1])
        return "not one line";
    if (strncmp(line, "iblbake: ", 9) && strncmp(line, "iblview: ", 9))
        return "not a line of the program's";
    if (kind == FAULT_MEMORY)
        return strstr(line, "memory") ? NULL : "does not say memory";
    if (kind == FAULT_THREAD)
        return strstr(line, "thread") ? NULL : "does not say threads";
    if (!strstr(line, strerror(error)))
        return "does not say why";
    if (!names_a_file(line, &walk.before) && !names_a_file(line, &walk.after))
        return "names no file";
    return NULL;
}

/* Of a run that was killed: every file is an old or a new one, or with
 * temporaries one of those. */
static const char *judge_parts(const result *r, bool temporaries)
{
    for (int i = 0; i < r->files.count; i++) {
        const entry *e = &r->files.file[i];
        if (!same(e, tree_find(&walk.before, e->path)) &&
            !same(e, tree_find(&walk.after, e->path)) &&
            !(temporaries && is_temporary(e->path)))
            return e->path;
    }
    for (int i = 0; i < walk.before.count; i++) {
        const char *path = walk.before.file[i].path;
        if (!tree_find(&r->files, path) && tree_find(&walk.after, path))
            return path;
    }
    return NULL;
}

static void complain(const char *fault, const result *r, const char *what,
                     const char *path)
{
    printf("FAULT=\"%s\"%s: %s%s%s", fault, walk.own ? " FAULT_FROM=own" : "",
           what, path ? " " : "", path ? path : "");
    if (WIFSIGNALED(r->status))
        printf("; signal %d", WTERMSIG(r->status));
    else
        printf("; status %d", WEXITSTATUS(r->status));
    printf("; %s%s", r->err, *r->err ? "" : "no line\n");
    printf("    from");
    for (int i = 0; i < FAULT_PLACES && walk.counts->place[i]; i++)
        printf(" 0x%lx", (unsigned long)walk.counts->place[i]);
    putchar('\n');
}

/* Judges what a run left that failed at error, or by signal -error. */
static bool judge(const char *fault, int kind, int error, const result *r)
{
    const char *what = NULL, *path = NULL;
    const bool left = kind == FAULT_REMOVE;
    const bool parts =
        walk.parts || kind == FAULT_RENAME || kind == FAULT_FLUSH;

    if (WIFSIGNALED(r->status) && WTERMSIG(r->status) == -error) {
        what = "files are neither old nor new:";
        if (error == -SIGKILL || walk.parts)
            path = judge_parts(r, error == -SIGKILL);
        else if ((path = differ(&r->files, &walk.before, false)))
            path = differ(&r->files, &walk.after, false) ? path : NULL;
    } else if (r->status == 0 && !strncmp(r->err, "iblview: note: ", 15)) {
        path = NULL; /* it says what it does without */
    } else if (WIFEXITED(r->status) && WEXITSTATUS(r->status) == 0) {
        what = "not the files of a good run:";
        path = differ(&r->files, &walk.after, left);
        if (!path && strcmp(r->out, walk.printed) != 0)
            path = "standard output";
        if (!path && strcmp(r->err, walk.said) != 0)
            path = "standard error";
    } else if (WIFEXITED(r->status) && WEXITSTATUS(r->status) == 1) {
        what = "old files are not as they were:";
        path = parts ? judge_parts(r, left)
                     : differ(&r->files, &walk.before, left);
        if (!path && (path = judge_line(r->err, kind, error)))
            what = "the line";
    } else {
        what = "ended strangely";
        path = "";
    }
    if (path)
        complain(fault, r, what, path);
    return !path;
}

/* ---- all of them --------------------------------------------------------- */

/* What each kind of call fails with; "": the end. A + at the end: all from one
 * on. */
static const struct {
    int kind;
    const char *errors[8];
} plans[] = {
#define E(error) #error
#define TEXT(error) E(error)
    {FAULT_MEMORY, {TEXT(ENOMEM), TEXT(ENOMEM) "+"}},
    {FAULT_THREAD, {TEXT(EAGAIN)}},
    {FAULT_OPEN, {TEXT(EIO), TEXT(EMFILE)}},
    {FAULT_CREATE, {TEXT(ENOSPC), TEXT(EDQUOT), TEXT(EIO)}},
    {FAULT_READ, {TEXT(EIO), TEXT(EINTR), "short", "short+"}},
    {FAULT_WRITE,
     {TEXT(ENOSPC), TEXT(ENOSPC) "+", TEXT(EDQUOT), TEXT(EIO), TEXT(EINTR),
      "short", "short+"}},
    {FAULT_CLOSE, {TEXT(EIO), TEXT(ENOSPC), TEXT(EINTR)}},
    {FAULT_FLUSH, {TEXT(EIO), TEXT(ENOSPC), TEXT(EINTR)}},
    {FAULT_LOCK, {TEXT(EIO), TEXT(ENOLCK) "+", TEXT(EINTR)}},
    {FAULT_RENAME, {TEXT(EIO), TEXT(ENOSPC)}},
    {FAULT_REMOVE, {TEXT(EIO), TEXT(EIO) "+"}},
    {FAULT_MKDIR, {TEXT(ENOSPC), TEXT(EDQUOT), TEXT(EIO)}},
    {FAULT_STAT, {TEXT(EIO), TEXT(EACCES)}},
    {FAULT_FILE, {"-9", "-15"}},
};

static unsigned every = 1;
static int faults;
static unsigned wanted; /* bits of kinds */

/* One run and, if it was killed, the next. True if the fault came. */
static bool try(int kind, const char *error, unsigned n)
{
    static result r, next;
    char fault[64];
    const char *plus = strchr(error, '+');

    snprintf(fault, sizeof fault, "%s %.*s %u%s", fault_kinds[kind],
             (int)strcspn(error, "+"), error, n, plus ? plus : "");
    memset(walk.counts, 0, sizeof *walk.counts);
    run(fault, &r);
    const bool came = atomic_load(&walk.counts->failed);
    faults += !judge(fault, kind, atoi(error), &r);
    if (WIFSIGNALED(r.status)) {
        run(NULL, &next);
        const char *path = differ(&next.files, &walk.after, false);
        if (next.status || path)
            complain(fault, &next, "then the next run", path);
        faults += next.status || path;
        tree_free(&r.files);
        r.files = next.files;
        next.files.count = 0;
    }
    restore(walk.root, &r.files, &walk.before);
    tree_free(&r.files);
    return came;
}

/* Of few calls, or of those to be killed at, a larger part is tried. */
static unsigned step_of(int kind, unsigned total)
{
    const unsigned most = total / (kind == FAULT_FILE ? 12 : 4);
    return every < most ? every : most ? most : 1;
}

static int walk_kind(int kind, const char *const *errors, unsigned calls)
{
    int count = 0, runs = 0;

    while (count < 8 && errors[count] &&
           !(walk.once && strchr(errors[count], '+')))
        count++;
    const unsigned total = calls * (unsigned)count;
    const unsigned step = step_of(kind, total);
    for (unsigned i = step / 2; i < total; i += step) {
        runs++;
        if (!try(kind, errors[i / calls], i % calls)) /* no more calls */
            i += calls - i % calls - step;
    }
    return runs;
}

/* A run without a fault, which says what is right and counts the calls. */
static void learn(unsigned calls[FAULT_KINDS])
{
    static result r;

    for (int k = 0; k < 2; k++) { /* the second must not differ */
        memset(walk.counts, 0, sizeof *walk.counts);
        run("memory 12 4000000000", &r);
        if (r.status) {
            printf("without a fault: status %d, %s\n", r.status, r.err);
            exit(1);
        }
        if (k && differ(&r.files, &walk.after, false)) {
            printf("without a fault: %s differs from run to run\n",
                   differ(&r.files, &walk.after, false));
            exit(1);
        }
        restore(walk.root, &r.files, &walk.before);
        if (!k)
            walk.after = r.files;
        else
            tree_free(&r.files);
    }
    memcpy(walk.printed, r.out, sizeof r.out);
    memcpy(walk.said, r.err, sizeof r.err);
    for (int i = 0; i < FAULT_KINDS; i++)
        calls[i] = atomic_load(&walk.counts->calls[i]);
}

static unsigned kind_bit(const char *name)
{
    for (int i = 0; i < FAULT_KINDS; i++)
        if (!strcmp(name, fault_kinds[i]))
            return 1u << i;
    fprintf(stderr, "walk: %s: no kind of call\n", name);
    exit(2);
}

static double seconds(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static void options(int argc, char **argv)
{
    for (int o; (o = getopt(argc, argv, "+e:k:op1")) != -1;)
        switch (o) {
        case 'e':
            every = (unsigned)atoi(optarg);
            break;
        case 'k':
            wanted |= kind_bit(optarg);
            break;
        case 'o':
            walk.own = true;
            break;
        case 'p':
            walk.parts = true;
            break;
        case '1':
            walk.once = true;
            break;
        default:
            exit(2);
        }
    if (argc - optind < 4 || every < 1) {
        fputs("usage: walk [options] PRELOAD BEFORE RUN COMMAND...\n", stderr);
        exit(2);
    }
}

int main(int argc, char **argv)
{
    unsigned calls[FAULT_KINDS];

    setvbuf(stdout, NULL, _IOLBF, 0);
    options(argc, argv);
    walk.preload = argv[optind];
    walk.root = argv[optind + 2];
    walk.command = argv + optind + 3;
    walk.before = tree_of(argv[optind + 1]);
    walk.counts_fd = memfd_create("counts", 0);
    walk.out_fd = memfd_create("out", 0);
    walk.err_fd = memfd_create("err", 0);
    if (walk.counts_fd < 0 || walk.out_fd < 0 || walk.err_fd < 0 ||
        ftruncate(walk.counts_fd, sizeof *walk.counts))
        die("memfd_create");
    walk.counts = mmap(NULL, sizeof *walk.counts, PROT_READ | PROT_WRITE,
                       MAP_SHARED, walk.counts_fd, 0);
    if (walk.counts == MAP_FAILED)
        die("mmap");
    if (mkdir(walk.root, 0777))
        die(walk.root);
    restore(walk.root, &(tree){.count = 0}, &walk.before);
    learn(calls);
    const double begun = seconds();
    for (size_t i = 0; i < sizeof plans / sizeof *plans; i++) {
        const int kind = plans[i].kind;
        if (wanted && !(wanted >> kind & 1))
            continue;
        const int runs = walk_kind(kind, plans[i].errors, calls[kind]);
        fprintf(stderr, "%-9s %6u calls %6d runs\n", fault_kinds[kind],
                calls[kind], runs);
    }
    fprintf(stderr, "%d faults, %.1f s\n", faults, seconds() - begun);
    return faults > 0;
}
