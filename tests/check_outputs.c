/* SPDX-License-Identifier: MIT */
/* Sets of output files: all, or nothing and no trace. */
#define _GNU_SOURCE
#include <dirent.h>
#include <errno.h>
#include <limits.h>
#include <linux/capability.h>
#include <linux/filter.h>
#include <linux/seccomp.h>
#include <signal.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/mount.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include "ibl/io.h"
#include "test.h"

static ibl_ctx *ctx;
static test_messages kept;

/* A path in a folder of the running test's own. */
static const char *at(const char *fmt, ...)
    __attribute__((format(printf, 1, 2)));

static const char *at(const char *fmt, ...)
{
    char path[PATH_MAX];
    va_list ap;
    va_start(ap, fmt);
    vsnprintf(path, sizeof path, fmt, ap);
    va_end(ap);
    return test_text("%s/%s", test_dir(), path);
}

static void put(const char *path, const char *text)
{
    FILE *f = fopen(path, "w");
    NEED(f);
    fputs(text, f);
    fclose(f);
}

static bool holds(const char *path, const char *text)
{
    char got[64] = {0};
    FILE *f = fopen(path, "r");
    if (!f)
        return false;
    got[fread(got, 1, sizeof got - 1, f)] = '\0';
    fclose(f);
    return !strcmp(got, text);
}

static bool exists(const char *path)
{
    struct stat st;
    return !lstat(path, &st);
}

/* Entries of a directory; -1: there is none. */
static int entries(const char *path)
{
    int n = -2;
    DIR *d = opendir(path);
    if (!d)
        return -1;
    while (readdir(d))
        n++;
    closedir(d);
    return n;
}

static bool said(const char *text)
{
    return strstr(kept.text[IBL_LOG_ERROR], text);
}

static void free_outputs(void *out)
{
    ibl_outputs_free(out);
}

/* Freed after the running test. */
static ibl_outputs *create(void)
{
    ibl_outputs *out;
    NEED(!ibl_outputs_create(ctx, &out));
    test_defer(free_outputs, out);
    return out;
}

static ibl_status add(ibl_outputs *out, const char *path, const char *text)
{
    return ibl_outputs_add(out, path, text, strlen(text));
}

TEST(committed)
{
    ibl_outputs *out;
    struct stat st;
    const mode_t mask = umask(007);
    NEED(!ibl_outputs_create(ctx, &out));
    NEED(!ibl_outputs_mkdir(out, at("c/d//e/")));
    NEED(!ibl_outputs_mkdir(out, at("c/d")));
    NEED(!ibl_outputs_mkdir(out, at("c/empty")));
    CHECK(!add(out, at("c/d/e/one"), "1"));
    CHECK(!add(out, at("c/two"), ""));
    CHECK(!exists(at("c/d/e/one")) && !exists(at("c/two")));
    CHECK(entries(at("c/d/e")) == 1);
    CHECK(!ibl_outputs_commit(out));
    CHECK(holds(at("c/d/e/one"), "1") && holds(at("c/two"), ""));
    CHECK(entries(at("c/d/e")) == 1 && entries(at("c")) == 3);
    CHECK(!stat(at("c/two"), &st) && (st.st_mode & 0777) == 0660);
    CHECK(!stat(at("c/d"), &st) && (st.st_mode & 0777) == 0770);
    /* Again with the same set, over the old ones. */
    CHECK(!add(out, at("c/two"), "new"));
    CHECK(holds(at("c/two"), ""));
    CHECK(!ibl_outputs_commit(out));
    CHECK(holds(at("c/two"), "new") && entries(at("c")) == 3);
    ibl_outputs_free(out);
    CHECK(holds(at("c/two"), "new") && entries(at("c/empty")) == 0);
    ibl_outputs_free(NULL);
    ibl_outputs_abort(NULL);
    umask(mask);
}

/* A file system that takes little at a time, and is interrupted. */
static struct {
    size_t most; /* bytes of a write; 0: all */
    int calls;
} slow;

ssize_t __real_write(int fd, const void *bytes, size_t size);
ssize_t __wrap_write(int fd, const void *bytes, size_t size);
ssize_t __wrap_write(int fd, const void *bytes, size_t size)
{
    if (slow.most && slow.calls++ % 2 == 0) {
        errno = EINTR;
        return -1;
    }
    return __real_write(fd, bytes,
                        slow.most && slow.most < size ? slow.most : size);
}

/* More than is written between two looks whether to stop, and by parts. */
TEST(large)
{
    enum {
        NUMBERS = 2500000
    };
    uint32_t *numbers = test_alloc(NUMBERS, sizeof *numbers), number;
    ibl_outputs *out;
    size_t same = 0;

    for (uint32_t i = 0; i < NUMBERS; i++)
        numbers[i] = i;
    for (size_t most = 0; most < 200000; most += 100003, same = 0) {
        NEED(!ibl_outputs_create(ctx, &out));
        slow.most = most;
        CHECK(!ibl_outputs_add(out, at("large"), numbers,
                               NUMBERS * sizeof *numbers));
        slow.most = 0;
        CHECK(!ibl_outputs_commit(out));
        ibl_outputs_free(out);
        FILE *f = fopen(at("large"), "r");
        NEED(f);
        while (fread(&number, sizeof number, 1, f) == 1 && number == same)
            same++;
        CHECK_MSG(same == NUMBERS && feof(f), "%zu numbers", same);
        fclose(f);
        remove(at("large"));
    }
}

TEST(aborted)
{
    NEED(!mkdir(at("a"), 0777));
    put(at("a/old"), "old");
    ibl_outputs *out = create();
    NEED(!ibl_outputs_mkdir(out, at("a/b/c")));
    NEED(!ibl_outputs_mkdir(out, at("a/mine")));
    CHECK(!add(out, at("a/old"), "new"));
    CHECK(!add(out, at("a/b/c/x"), "x"));
    put(at("a/mine/other"), "o");
    CHECK(holds(at("a/old"), "old"));
    errno = 77;
    ibl_outputs_abort(out);
    CHECK(errno == 77);
    CHECK(holds(at("a/old"), "old") && !exists(at("a/b")));
    CHECK(holds(at("a/mine/other"), "o") && entries(at("a")) == 2);
    CHECK(add(out, at("a/y"), "y") == IBL_ERR_ARGUMENT);
    CHECK(entries(at("a")) == 2);
}

/* What cannot be a target stays as it is, and the set goes on. */
TEST(refused)
{
    char path[5000];
    NEED(!mkdir(at("r"), 0777) && !mkdir(at("r/dir"), 0777));
    NEED(!mkfifo(at("r/pipe"), 0666));
    put(at("r/file"), "f");
    ibl_outputs *out = create();
    const struct {
        const char *path, *text;
        ibl_status status;
    } cases[] = {
        {at("r/dir"), "is a directory", IBL_ERR_IO},
        {at("r/new/"), "ends in /", IBL_ERR_IO},
        {at("r/pipe"), "is a pipe", IBL_ERR_IO},
        {"/dev/null", "is a device", IBL_ERR_IO},
        {"/dev/full", "is a device", IBL_ERR_IO},
        {at("r/file/x"), "Not a directory", IBL_ERR_IO},
        {at("r/none/x"), "No such file", IBL_ERR_IO},
        {"/proc/iblbake", "cannot be created", IBL_ERR_IO},
        {"", "without a path", IBL_ERR_ARGUMENT},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        const ibl_status status = add(out, cases[i].path, "x");
        CHECK_MSG(status == cases[i].status && said(cases[i].text) &&
                      said(cases[i].path),
                  "%s: status %d: %s", cases[i].path, (int)status,
                  kept.text[IBL_LOG_ERROR]);
    }
    memset(path, 'p', sizeof path);
    path[4032] = '\0';
    CHECK(add(out, path, "x") == IBL_ERR_ARGUMENT && said("4031"));
    CHECK(ibl_outputs_mkdir(out, path) == IBL_ERR_ARGUMENT);
    CHECK(ibl_outputs_mkdir(out, at("r/file")) == IBL_ERR_IO);
    CHECK(said("no directory"));
    CHECK(ibl_outputs_mkdir(out, at("r/file/sub")) == IBL_ERR_IO);
    CHECK(ibl_outputs_mkdir(out, "/proc/iblbake/out") == IBL_ERR_IO);
    NEED(!symlink("gone", at("r/link")));
    CHECK(ibl_outputs_mkdir(out, at("r/link")) == IBL_ERR_IO);
    CHECK(said("choose another name"));
    NEED(!unlink(at("r/link")));
    CHECK(!add(out, at("r/good"), "g") && !ibl_outputs_commit(out));
    CHECK(holds(at("r/good"), "g") && holds(at("r/file"), "f"));
    CHECK(entries(at("r")) == 4 && !exists("/proc/iblbake"));
}

TEST(twice)
{
    NEED(!mkdir(at("t"), 0777) && !symlink("x", at("t/link")) &&
         !symlink("t", at("t2")) && !mkdir(at("t/d"), 0777));
    ibl_outputs *out = create();
    CHECK(!add(out, at("t/x"), "1") && !add(out, at("t/d/x"), "6"));
    CHECK(add(out, at("t/x"), "2") == IBL_ERR_ARGUMENT &&
          said("give each its own"));
    CHECK(add(out, at("t//.//x"), "3") == IBL_ERR_ARGUMENT);
    CHECK(add(out, at("t/link"), "4") == IBL_ERR_ARGUMENT);
    CHECK(add(out, at("t2/x"), "5") == IBL_ERR_ARGUMENT);
    CHECK(!ibl_outputs_commit(out));
    CHECK(holds(at("t/x"), "1") && entries(at("t")) == 3);
    CHECK(holds(at("t/d/x"), "6"));
}

TEST(too_many)
{
    NEED(!mkdir(at("m"), 0777));
    ibl_outputs *out = create();
    for (int i = 0; i < IBL_MAX_OUTPUTS; i++)
        CHECK(!add(out, at("m/%d", i), "m"));
    CHECK(add(out, at("m/more"), "m") == IBL_ERR_ARGUMENT);
    CHECK(!ibl_outputs_commit(out));
    CHECK(entries(at("m")) == IBL_MAX_OUTPUTS);
}

static bool rival; /* makes directories just before we do */

int __real_mkdir(const char *path, mode_t mode);
int __wrap_mkdir(const char *path, mode_t mode);
int __wrap_mkdir(const char *path, mode_t mode)
{
    const int result = __real_mkdir(path, mode);
    if (!rival || result)
        return result;
    errno = EEXIST;
    return -1;
}

/* A directory that another program makes meanwhile is there, and not ours. */
TEST(made_by_others)
{
    ibl_outputs *out;
    NEED(!ibl_outputs_create(ctx, &out));
    rival = true;
    CHECK(!ibl_outputs_mkdir(out, at("theirs/too")));
    rival = false;
    CHECK(!add(out, at("theirs/too/file"), "x"));
    ibl_outputs_free(out);
    CHECK(entries(at("theirs")) == 1 && entries(at("theirs/too")) == 0);
}

/* A name may be as long as the file system lets it be. */
TEST(long_names)
{
    char name[NAME_MAX + 1];
    ibl_outputs *out;
    for (int n = NAME_MAX - 80; n <= NAME_MAX; n += 40) {
        memset(name, 'n', (size_t)n);
        name[n] = '\0';
        NEED(!ibl_outputs_create(ctx, &out));
        CHECK_MSG(!add(out, at("%s", name), "long") &&
                      !ibl_outputs_commit(out) && holds(at("%s", name), "long"),
                  "a name of %d bytes", n);
        ibl_outputs_free(out);
    }
}

TEST(links)
{
    struct stat st;
    NEED(!mkdir(at("l"), 0777) && !mkdir(at("l/far"), 0777));
    put(at("l/far/file"), "old");
    NEED(!symlink("far/file", at("l/link")) &&
         !symlink("far/not-yet", at("l/dangling")) &&
         !symlink("loop", at("l/loop")) && !symlink("far", at("l/dir")));
    ibl_outputs *out = create();
    CHECK(!add(out, at("l/link"), "new"));
    CHECK(!add(out, at("l/dangling"), "made"));
    CHECK(add(out, at("l/loop"), "x") == IBL_ERR_IO);
    CHECK(add(out, at("l/dir"), "x") == IBL_ERR_IO && said("directory"));
    CHECK(!ibl_outputs_commit(out));
    CHECK(!lstat(at("l/link"), &st) && S_ISLNK(st.st_mode));
    CHECK(!lstat(at("l/dangling"), &st) && S_ISLNK(st.st_mode));
    CHECK(holds(at("l/far/file"), "new") && holds(at("l/far/not-yet"), "made"));
    CHECK(entries(at("l/far")) == 2 && entries(at("l")) == 5);
}

/* The third rename fails: the second file goes, the first is as before. */
TEST(taken_back)
{
    ibl_outputs *out;
    NEED(!mkdir(at("b"), 0777));
    put(at("b/first"), "old");
    NEED(!ibl_outputs_create(ctx, &out));
    NEED(!ibl_outputs_mkdir(out, at("b/made")));
    CHECK(!add(out, at("b/first"), "new"));
    CHECK(!add(out, at("b/made/second"), "new"));
    CHECK(!add(out, at("b/third"), "new"));
    CHECK(!add(out, at("b/fourth"), "new"));
    NEED(!mkdir(at("b/third"), 0777));
    CHECK(ibl_outputs_commit(out) == IBL_ERR_IO && said("third"));
    CHECK(holds(at("b/first"), "old") && !exists(at("b/made")));
    CHECK(!exists(at("b/fourth")) && entries(at("b")) == 2);
    CHECK(entries(at("b/third")) == 0);
    ibl_outputs_free(out);
    CHECK(entries(at("b")) == 2);
}

/* A system call fails from here on; argument >= 0: only with that value. */
static bool forbid(int call, int argument, unsigned value, unsigned error)
{
    struct sock_filter filter[] = {
        BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(struct seccomp_data, nr)),
        BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, (unsigned)call, 0, 3),
        BPF_STMT(BPF_LD | BPF_W | BPF_ABS,
                 argument < 0 ? (unsigned)offsetof(struct seccomp_data, nr)
                              : (unsigned)offsetof(struct seccomp_data, args) +
                                    8 * (unsigned)argument), /* little endian */
        BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K,
                 argument < 0 ? (unsigned)call : value, 0, 1),
        BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ERRNO | error),
        BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ALLOW),
    };
    const struct sock_fprog program = {sizeof filter / sizeof filter[0],
                                       filter};
    return !prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) &&
           !prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &program);
}

static unsigned refusal; /* errno where names cannot be exchanged */

/* As taken_back, in a process of its own; its exit status is the line of what
 * went wrong. There an old file stays replaced, but nothing is lost. */
static int replace_plainly(void)
{
    ibl_outputs *out;
    if (!forbid(SYS_renameat2, 4, 2 /* RENAME_EXCHANGE */, refusal))
        return 255;
    if (ibl_outputs_create(ctx, &out) || add(out, at("p/zero"), "new") ||
        ibl_outputs_commit(out) || !holds(at("p/zero"), "new") ||
        entries(at("p")) != 2)
        return 1;
    if (add(out, at("p/first"), "new") || add(out, at("p/second"), "new") ||
        add(out, at("p/third"), "new") || mkdir(at("p/third"), 0777) ||
        ibl_outputs_commit(out) != IBL_ERR_IO)
        return 2;
    if (!holds(at("p/first"), "new") || exists(at("p/second")) ||
        entries(at("p")) != 3)
        return 3;
    return 0;
}

/* Runs a test in a process of its own, for what cannot be undone. */
static void in_child(int (*steps)(void))
{
    int result;
    const pid_t child = fork();
    NEED(child >= 0);
    if (!child)
        _exit(steps());
    waitpid(child, &result, 0);
    NEED(WIFEXITED(result));
    if (WEXITSTATUS(result) == 255)
        test_skip("the system does not let it");
    else
        CHECK_MSG(!WEXITSTATUS(result), "step %d", WEXITSTATUS(result));
}

TEST(without_exchange)
{
    static const unsigned refusals[] = {EINVAL, ENOSYS, EPERM, EOPNOTSUPP};
    NEED(!mkdir(at("p"), 0777));
    for (int i = 0; i < 4; i++) {
        refusal = refusals[i];
        put(at("p/zero"), "old");
        put(at("p/first"), "old");
        in_child(replace_plainly);
        remove(at("p/third"));
    }
}

/* A disk that fails when it is flushed: what asked for that notices it, and
 * leaves nothing; what did not never flushes. */
static int flush_in_vain(void)
{
    ibl_outputs *out;
    if (!forbid(SYS_fsync, -1, 0, EIO))
        return 255;
    if (ibl_outputs_create(ctx, &out) || add(out, at("f/a"), "new") ||
        ibl_outputs_commit(out) || !holds(at("f/a"), "new"))
        return 1;
    ibl_outputs_sync(out, 1);
    if (add(out, at("f/a"), "newer") != IBL_ERR_IO || !said("flushed") ||
        entries(at("f")) != 1)
        return 2;
    ibl_outputs_sync(out, 0);
    if (add(out, at("f/a"), "newer") || add(out, at("f/b"), "new"))
        return 3;
    ibl_outputs_sync(out, 1); /* the directory's flush fails */
    if (ibl_outputs_commit(out) != IBL_ERR_IO || !said("directory") ||
        !holds(at("f/a"), "new") || entries(at("f")) != 1)
        return 4;
    return 0;
}

/* What has been flushed, and how often. */
static struct {
    struct stat of[32];
    int count;
    int error; /* errno that every second call fails with, or 0 */
} flushes;

int __real_fsync(int fd);
int __wrap_fsync(int fd);
int __wrap_fsync(int fd)
{
    if (flushes.count < 32 && !fstat(fd, &flushes.of[flushes.count]))
        flushes.count++;
    if (flushes.error && flushes.count % 2) {
        errno = flushes.error;
        return -1;
    }
    return __real_fsync(fd);
}

static int times_flushed(const char *path)
{
    struct stat st;
    int times = 0;
    if (stat(path, &st))
        return -1;
    for (int i = 0; i < flushes.count; i++)
        times += flushes.of[i].st_dev == st.st_dev &&
                 flushes.of[i].st_ino == st.st_ino;
    return times;
}

/* Each file, and each directory that something was put or made in. */
TEST(flushed)
{
    static const char *const paths[] = {"f/a", "f/x/y/b", "f/x/y/c",
                                        "f",   "f/x",     "f/x/y"};
    NEED(!mkdir(at("f"), 0777));
    in_child(flush_in_vain);
    for (int sync = 0; sync < 2; sync++) {
        ibl_outputs *out;
        flushes.count = 0;
        NEED(!ibl_outputs_create(ctx, &out));
        ibl_outputs_sync(out, sync);
        NEED(!ibl_outputs_mkdir(out, at("f/x/y")));
        for (int i = 0; i < 3; i++)
            CHECK(!add(out, at("%s", paths[i]), paths[i]));
        CHECK(flushes.count == 3 * sync);
        CHECK(!ibl_outputs_commit(out));
        ibl_outputs_free(out);
        for (int i = 0; i < 6; i++)
            CHECK_MSG(!times_flushed(at("%s", paths[i])) == !sync,
                      "%s was flushed %d times", paths[i],
                      times_flushed(at("%s", paths[i])));
        for (int i = 0; i < 3; i++)
            CHECK(holds(at("%s", paths[i]), paths[i]) &&
                  !remove(at("%s", paths[i])));
        CHECK(!rmdir(at("f/x/y")) && !rmdir(at("f/x")));
    }
}

/* A flush that is interrupted is done again; what cannot be flushed is not. */
TEST(flushed_again)
{
    static const int errors[] = {EINTR, EINVAL};
    NEED(!mkdir(at("g"), 0777));
    for (int i = 0; i < 2; i++) {
        ibl_outputs *out;
        NEED(!ibl_outputs_create(ctx, &out));
        ibl_outputs_sync(out, 1);
        flushes.count = 0;
        flushes.error = errors[i];
        CHECK(!add(out, at("g/a"), "new"));
        flushes.error = 0;
        CHECK(flushes.count == (i ? 1 : 2));
        CHECK(!ibl_outputs_commit(out) && holds(at("g/a"), "new"));
        ibl_outputs_free(out);
    }
}

/* A file system that tells only now of a disk that is full. */
static int close_in_vain(void)
{
    ibl_outputs *out;
    if (!forbid(SYS_close, -1, 0, EDQUOT))
        return 255;
    if (ibl_outputs_create(ctx, &out) ||
        add(out, at("n/new"), "x") != IBL_ERR_IO ||
        !said("new: cannot be written") || !said("make room"))
        return 1;
    if (ibl_outputs_commit(out) || entries(at("n")))
        return 2;
    return 0;
}

TEST(not_closed)
{
    NEED(!mkdir(at("n"), 0777));
    in_child(close_in_vain);
}

/* ---- a file system that does not say what is there --------------------- */

static int answers = -1; /* that lstat still gives; -1: all */

int __real_lstat(const char *path, struct stat *st);
int __wrap_lstat(const char *path, struct stat *st);
int __wrap_lstat(const char *path, struct stat *st)
{
    if (!answers) {
        errno = EIO;
        return -1;
    }
    answers -= answers > 0;
    return __real_lstat(path, st);
}

/* Whichever answer is the last: all files are new or all old; nothing else. */
TEST(no_answers)
{
    static const char *const names[] = {"a", "b", "sub/c", "sub/d"};
    int whole = 0;
    NEED(!mkdir(at("q"), 0777) && !mkdir(at("q/sub"), 0777));
    for (int n = 0; n < 12; n++) {
        ibl_outputs *out;
        put(at("q/a"), "old");
        put(at("q/sub/c"), "old");
        NEED(!ibl_outputs_create(ctx, &out));
        for (int i = 0; i < 4; i++)
            CHECK(!add(out, at("q/%s", names[i]), "new"));
        answers = n;
        const ibl_status status = ibl_outputs_commit(out);
        ibl_outputs_free(out);
        answers = -1;
        whole += !status;
        CHECK_MSG(!status || status == IBL_ERR_IO, "%d answers", n);
        for (int i = 0; i < 4; i++)
            CHECK_MSG(status && i % 2
                          ? !exists(at("q/%s", names[i]))
                          : holds(at("q/%s", names[i]), status ? "old" : "new"),
                      "%d answers: %s", n, names[i]);
        CHECK_MSG(entries(at("q")) == (status ? 2 : 3) &&
                      entries(at("q/sub")) == (status ? 1 : 2),
                  "%d answers: something is left", n);
        remove(at("q/b"));
        remove(at("q/sub/d"));
    }
    CHECK(whole > 0 && whole < 12);
}

/* ---- killed processes ---------------------------------------------------- */

static int die_in_commit(void)
{
    ibl_outputs *out;
    if (ibl_outputs_create(ctx, &out) || add(out, at("k/a"), "new") ||
        add(out, at("k/b"), "new"))
        return 1;
    raise(SIGKILL);
    return 2;
}

/* FNV-1a of the host's name. */
static unsigned host(void)
{
    char name[256] = "";
    uint64_t hash = 2166136261u;
    gethostname(name, sizeof name - 1);
    for (const char *c = name; *c; c++)
        hash = ((hash ^ (unsigned char)*c) * 16777619u) % (1ull << 32);
    return (unsigned)hash;
}

/* What a killed process left goes with the next set in that directory, unless
 * another is in it; what only looks like it stays. */
TEST(swept)
{
    const unsigned here = host();
    const char *const others[] = {
        at("k/.a.iblbake-%08x-1-0.tmp", here), /* of process 1, which lives */
        at("k/.a.iblbake-%08x-x-0.tmp", here),
        at("k/.a.iblbake-%08x-999999999-0.tmp.c", here),
        at("k/a.iblbake-%08x-999999999-0.tmp", here),
        at("k/.a.iblbake-%08x-999999999-0.tmp", here + 1)}; /* another host */
    ibl_outputs *first, *second;
    int status;

    NEED(!mkdir(at("k"), 0777) && !mkdir(at("k/sub"), 0777));
    put(at("k/a"), "old");
    for (int i = 0; i < 5; i++)
        put(others[i], "other");
    for (int i = 0; i < 2; i++) {
        NEED(!ibl_outputs_create(ctx, &first));
        if (i) /* a set that is still there when the process dies */
            CHECK(!add(first, at("k/sub/../mine"), "mine"));
        const pid_t pid = fork();
        if (!pid)
            _exit(die_in_commit());
        NEED(waitpid(pid, &status, 0) == pid && WIFSIGNALED(status));
        CHECK(entries(at("k")) == 9 + i);
        NEED(!ibl_outputs_create(ctx, &second));
        CHECK(!add(second, at("k/sub/x"), "x"));
        CHECK(entries(at("k")) == 9 + i);
        CHECK(!add(second, at("k/b"), "b"));
        CHECK(entries(at("k")) == (i ? 11 : 8));
        ibl_outputs_free(second);
        CHECK(!ibl_outputs_commit(first));
        ibl_outputs_free(first);
        CHECK(entries(at("k")) == (i ? 10 : 7));
    }
    NEED(!ibl_outputs_create(ctx, &first));
    CHECK(!add(first, at("k/a"), "new") && !ibl_outputs_commit(first));
    ibl_outputs_free(first);
    CHECK(entries(at("k")) == 8 && holds(at("k/a"), "new") &&
          holds(at("k/mine"), "mine"));
    for (int i = 0; i < 5; i++)
        CHECK(holds(others[i], "other"));
}

TEST(cancelled)
{
    ibl_ctx *other = test_ctx(1, IBL_ISA_C);
    ibl_outputs *out;
    NEED(!ibl_outputs_create(other, &out));
    CHECK(!add(out, at("cancelled"), "x"));
    ibl_ctx_cancel(other);
    CHECK(add(out, at("more"), "x") == IBL_ERR_CANCELLED);
    CHECK(ibl_outputs_commit(out) == IBL_ERR_CANCELLED);
    CHECK(!exists(at("cancelled")) && !exists(at("more")));
    ibl_outputs_free(out);
}

static void fill(const char *dir)
{
    ibl_outputs *out;
    static char bytes[1 << 20];
    put(at("%s/old", dir), "old");
    NEED(!ibl_outputs_create(ctx, &out));
    CHECK(!add(out, at("%s/small", dir), "s"));
    CHECK(ibl_outputs_add(out, at("%s/old", dir), bytes, sizeof bytes) ==
          IBL_ERR_IO);
    CHECK(said("old: cannot be written"));
    CHECK(entries(at("%s", dir)) == 2);
    ibl_outputs_free(out);
    CHECK(holds(at("%s/old", dir), "old") && entries(at("%s", dir)) == 1);
}

static ibl_texture make_texture(int size)
{
    ibl_texture tex = {.pixel = IBL_PIXEL_RGBA16F,
                       .width = size,
                       .height = size,
                       .levels = 1,
                       .layers = 1,
                       .faces = 6,
                       .bytes = 48 * (size_t)size * (size_t)size};
    tex.data = aligned_alloc(64, tex.bytes);
    if (!tex.data)
        exit(1);
    memset(tex.data, 7, tex.bytes);
    return tex;
}

/* Textures that are taken over: written when waited for, by one thread or
 * more, and not left behind where nobody commits. */
TEST(taken_over)
{
    test_messages messages = {0};
    NEED(!mkdir(at("over"), 0777));
    for (int threads = 1; threads <= 3; threads++) {
        ibl_ctx *some = test_keeping_ctx(threads, &messages);
        for (int n = 0; n < 12; n++) {
            ibl_outputs *out;
            size_t size[3] = {0};
            NEED(!ibl_outputs_create(some, &out));
            for (int i = 0; i < 3; i++) {
                ibl_texture tex = make_texture(8 << (2 * i));
                CHECK(!ibl_outputs_take_texture(out, at("over/%d", i), &tex,
                                                IBL_CONTAINER_DDS, &size[i]));
                CHECK(!tex.data && size[i] == 148 + (3072u << (4 * i)));
            }
            CHECK(add(out, at("over/0"), "x") == IBL_ERR_ARGUMENT);
            CHECK(!add(out, at("over/3"), "beside"));
            if (n % 3 == 1)
                CHECK(!ibl_outputs_wait(out));
            if (n % 3 == 2)
                ibl_outputs_abort(out);
            else if (n % 3 == 1 || n % 2)
                CHECK(!ibl_outputs_commit(out));
            ibl_outputs_free(out);
            CHECK(entries(at("over")) == (n ? 4 : 0));
        }
        for (int i = 0; i < 4; i++)
            remove(at("over/%d", i));
    }
}

/* What fails on another thread fails the commit, or the wait before it. */
static void fill_later(const char *dir, bool waits)
{
    ibl_outputs *out;
    ibl_texture tex = make_texture(128);
    test_messages said_there = {0};
    ibl_ctx *two = test_keeping_ctx(2, &said_there);
    put(at("%s/old", dir), "old");
    NEED(!ibl_outputs_create(two, &out));
    CHECK(!add(out, at("%s/small", dir), "s"));
    CHECK(!ibl_outputs_take_texture(out, at("%s/old", dir), &tex,
                                    IBL_CONTAINER_KTX2, NULL));
    CHECK((waits ? ibl_outputs_wait(out) : ibl_outputs_commit(out)) ==
          IBL_ERR_IO);
    CHECK_MSG(strstr(said_there.text[IBL_LOG_ERROR], "old: cannot be written"),
              "%s", said_there.text[IBL_LOG_ERROR]);
    CHECK(holds(at("%s/old", dir), "old") && entries(at("%s", dir)) == 1);
    ibl_outputs_free(out);
    CHECK(entries(at("%s", dir)) == 1);
}

TEST(file_limit)
{
    struct rlimit limit, less;
    NEED(!mkdir(at("limit"), 0777));
    NEED(!getrlimit(RLIMIT_FSIZE, &limit));
    less = limit;
    less.rlim_cur = 100000;
    signal(SIGXFSZ, SIG_IGN);
    NEED(!setrlimit(RLIMIT_FSIZE, &less));
    fill("limit");
    fill_later("limit", false);
    fill_later("limit", true);
    setrlimit(RLIMIT_FSIZE, &limit);
    signal(SIGXFSZ, SIG_DFL);
}

TEST(full_disk)
{
    NEED(!mkdir(at("disk"), 0777));
    if (mount("none", at("disk"), "tmpfs", 0, "size=200k"))
        test_skip("cannot mount a small disk: %s", strerror(errno));
    fill("disk");
    CHECK(said("make room"));
    fill_later("disk", false);
    CHECK(!umount(at("disk")));
}

/* From here on permissions are root's, too. */
static bool drop_capabilities(void)
{
    struct __user_cap_header_struct header = {.version =
                                                  _LINUX_CAPABILITY_VERSION_3};
    struct __user_cap_data_struct none[2] = {0};
    return !syscall(SYS_capset, &header, none);
}

static int write_unwritable(void)
{
    ibl_outputs *out;
    if (!drop_capabilities())
        return 255;
    if (ibl_outputs_create(ctx, &out) ||
        add(out, at("u/file"), "x") != IBL_ERR_IO || !said("denied"))
        return 1;
    if (chmod(at("u"), 0555) || add(out, at("u/new"), "x") != IBL_ERR_IO ||
        !said("denied") || chmod(at("u"), 0777))
        return 2;
    ibl_outputs_free(out);
    return 0;
}

TEST(unwritable)
{
    NEED(!mkdir(at("u"), 0777));
    put(at("u/file"), "f");
    NEED(!chmod(at("u/file"), 0444));
    in_child(write_unwritable);
    CHECK(holds(at("u/file"), "f") && entries(at("u")) == 1);
}

/* ---- other processes ------------------------------------------------- */

static int write_one(void)
{
    ibl_outputs *out;

    if (ibl_outputs_create(ctx, &out) || add(out, at("two/file"), "x") ||
        ibl_outputs_commit(out))
        return 1;
    ibl_outputs_free(out);
    return 0;
}

/* A commit waits for that of another process, which may remove its lock. */
TEST(two_at_once)
{
    const struct timespec nap = {0, 30000000};
    int result;

    NEED(!mkdir(at("two"), 0777));
    for (int removes = 0; removes < 2; removes++) {
        const int fd = open(at("two/.iblbake.lock"), O_RDWR | O_CREAT, 0666);
        NEED(fd >= 0 && !flock(fd, LOCK_EX));
        const pid_t child = fork();
        NEED(child >= 0);
        if (!child) {
            close(fd);
            _exit(write_one());
        }
        nanosleep(&nap, NULL);
        CHECK(access(at("two/file"), F_OK));
        if (removes)
            remove(at("two/.iblbake.lock"));
        close(fd);
        waitpid(child, &result, 0);
        CHECK(!result && holds(at("two/file"), "x") && entries(at("two")) == 1);
        remove(at("two/file"));
    }
}

/* ---- signals -------------------------------------------------------- */

enum {
    FILES = 4
};

static ibl_outputs *victim;

static void on_signal(int number)
{
    (void)number;
    ibl_outputs_abort(victim);
    _exit(0);
}

/* Writes one generation after the other until it is told to stop. */
static void write_generations(void)
{
    char text[32];
    signal(SIGTERM, on_signal);
    for (int n = 1;; n++) {
        if (ibl_outputs_create(ctx, &victim) ||
            ibl_outputs_mkdir(victim, at("s/sub")))
            _exit(1);
        snprintf(text, sizeof text, "%d", n);
        for (int i = 0; i < FILES; i++) {
            if (add(victim, at("s/%s%d", i % 2 ? "sub/" : "", i), text))
                _exit(1);
        }
        if (ibl_outputs_commit(victim))
            _exit(1);
    }
}

static long generation(int i)
{
    char text[32] = {0};
    FILE *f = fopen(at("s/%s%d", i % 2 ? "sub/" : "", i), "r");
    if (!f)
        return 0;
    if (!fgets(text, sizeof text, f))
        text[0] = '\0';
    fclose(f);
    return strtol(text, NULL, 10);
}

/* Ended at any moment, it leaves files of one generation and no others. */
TEST(interrupted)
{
    test_random r = {21};
    NEED(!mkdir(at("s"), 0777));
    for (int n = 0; n < 150; n++) {
        const struct timespec nap = {0, (long)(test_random_u64(&r) % 3000000)};
        const pid_t child = fork();
        int result;
        NEED(child >= 0);
        if (!child)
            write_generations();
        nanosleep(&nap, NULL);
        kill(child, SIGTERM);
        waitpid(child, &result, 0);
        for (int i = 1; i < FILES; i++)
            CHECK_MSG(generation(i) == generation(0),
                      "file %d of generation %ld beside %ld", i, generation(i),
                      generation(0));
        const bool some = generation(0) > 0;
        const int inside = entries(at("s/sub"));
        CHECK_MSG(entries(at("s")) == (some         ? 3
                                       : inside < 0 ? 0
                                                    : 1),
                  "%d entries left", entries(at("s")));
        CHECK_MSG(some ? inside == 2 : inside <= 0, "%d entries inside",
                  inside);
        if (n % 10 == 9) { /* and from nothing */
            for (int i = 0; i < FILES; i++)
                remove(at("s/%s%d", i % 2 ? "sub/" : "", i));
            rmdir(at("s/sub"));
        }
    }
}

void test_setup(void)
{
    ctx = test_keeping_ctx(1, &kept);
}
