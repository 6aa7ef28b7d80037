/* SPDX-License-Identifier: MIT */
/* Sets of output files: all, or nothing and no trace. */
#define _GNU_SOURCE
#include <dirent.h>
#include <errno.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include "files.h"
#include "ibl/io.h"
#include "test.h"
#include "textures.h"

static ibl_ctx *ctx;
static test_messages kept;

/* A path in a folder of the running test's own. */
#define at(...) file_path(test_text(__VA_ARGS__))

static void put(const char *path, const char *text)
{
    NEED(file_save(path, text, strlen(text)));
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

static void free_outputs(void *out)
{
    ibl_outputs_free(out);
}

/* Freed after the running test. */
static ibl_outputs *create(void)
{
    ibl_outputs *out;
    NEED(!ibl_outputs_create(ctx, 0, &out));
    test_defer(free_outputs, out);
    return out;
}

static ibl_status add(ibl_outputs *out, const char *path, const char *text)
{
    return ibl_outputs_add(out, path, text, strlen(text));
}

/* FNV-1a of the names of the host and of the namespace of PIDs. */
static unsigned here(void)
{
    char name[512] = "";
    uint64_t hash = 2166136261u;
    gethostname(name, 255);
    const size_t n = strlen(name);
    NEED(readlink("/proc/self/ns/pid", name + n, sizeof name - n - 1) > 0);
    for (const char *c = name; *c; c++)
        hash = ((hash ^ (unsigned char)*c) * 16777619u) % (1ull << 32);
    return (unsigned)hash;
}

/* What a process that is gone left goes with the next commit to that directory;
 * what others are writing, or only looks like it, stays. The first test: a
 * process searches a directory once. */
TEST(swept)
{
    const char *const files[] = {
        at("k/.a.iblbake-%08x-999999999-0.tmp", here()),
        at("k/.a.iblbake-%08x-1-0.tmp", here()), /* of process 1, which lives */
        at("k/.a.iblbake-%08x-x-0.tmp", here()),
        at("k/.a.iblbake-%08x-999999999-0.tmp.c", here()),
        at("k/a.iblbake-%08x-999999999-0.tmp", here()),
        at("k/.a.iblbake-%08x-999999999-0.tmp", here() + 1)}; /* elsewhere */
    ibl_outputs *first = create(), *second = create();

    NEED(!mkdir(at("k"), 0777));
    for (int i = 0; i < 6; i++)
        put(files[i], "other");
    CHECK(!add(first, at("k/mine"), "mine"));
    CHECK(!add(second, at("k/b"), "b") && entries(at("k")) == 8);
    CHECK(!ibl_outputs_commit(second) && entries(at("k")) == 7);
    CHECK(!ibl_outputs_commit(first) && entries(at("k")) == 7);
    CHECK(holds(at("k/mine"), "mine"));
    for (int i = 0; i < 6; i++)
        CHECK(holds(files[i], "other") == (i > 0));
}

TEST(committed)
{
    ibl_outputs *out;
    struct stat st;
    const mode_t mask = umask(007);
    NEED(!ibl_outputs_create(ctx, 0, &out));
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
    umask(mask);
}

/* More than is written between two looks whether to stop, by parts. */
TEST(large)
{
    enum {
        NUMBERS = 2500000
    };
    uint32_t *numbers = test_alloc(NUMBERS, sizeof *numbers);
    const size_t size = NUMBERS * sizeof *numbers;
    ibl_outputs *out = create();
    size_t got;

    for (uint32_t i = 0; i < NUMBERS; i++)
        numbers[i] = i;
    CHECK(!ibl_outputs_add(out, at("large"), numbers, size));
    CHECK(!ibl_outputs_commit(out));
    const void *bytes = file_load(at("large"), &got);
    CHECK(got == size && !memcmp(bytes, numbers, size));
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
        CHECK_MSG(status == cases[i].status &&
                      test_said(&kept, cases[i].text) &&
                      test_said(&kept, cases[i].path),
                  "%s: status %d: %s", cases[i].path, (int)status,
                  kept.text[IBL_LOG_ERROR]);
    }
    memset(path, 'p', sizeof path);
    path[4032] = '\0';
    CHECK(add(out, path, "x") == IBL_ERR_ARGUMENT && test_said(&kept, "4031"));
    CHECK(ibl_outputs_mkdir(out, path) == IBL_ERR_ARGUMENT);
    CHECK(ibl_outputs_mkdir(out, at("r/file")) == IBL_ERR_IO);
    CHECK(test_said(&kept, "no directory"));
    CHECK(ibl_outputs_mkdir(out, at("r/file/sub")) == IBL_ERR_IO);
    CHECK(ibl_outputs_mkdir(out, "/proc/iblbake/out") == IBL_ERR_IO);
    NEED(!symlink("gone", at("r/link")));
    CHECK(ibl_outputs_mkdir(out, at("r/link")) == IBL_ERR_IO);
    CHECK(test_said(&kept, "choose another name"));
    NEED(!unlink(at("r/link")));
    CHECK(!add(out, at("r/good"), "g") && !ibl_outputs_commit(out));
    CHECK(holds(at("r/good"), "g") && holds(at("r/file"), "f"));
    CHECK(entries(at("r")) == 4 && !exists("/proc/iblbake"));
}

TEST(twice)
{
    NEED(!mkdir(at("t"), 0777) && !symlink("x", at("t/link")) &&
         !symlink("t", at("t2")) && !mkdir(at("t/d"), 0777));
    put(at("t/x"), "0");
    ibl_outputs *out = create();
    CHECK(!add(out, at("t/x"), "1") && !add(out, at("t/d/x"), "6"));
    CHECK(add(out, at("t/x"), "2") == IBL_ERR_ARGUMENT &&
          test_said(&kept, "give each its own"));
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

/* A name may be as long as the file system lets it be. */
TEST(long_names)
{
    char name[NAME_MAX + 1];
    ibl_outputs *out;
    for (int n = NAME_MAX - 80; n <= NAME_MAX; n += 40) {
        memset(name, 'n', (size_t)n);
        name[n] = '\0';
        NEED(!ibl_outputs_create(ctx, 0, &out));
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
         !symlink("far/none", at("l/dangling")) &&
         !symlink("loop", at("l/loop")) && !symlink("far", at("l/dir")));
    ibl_outputs *out = create();
    CHECK(!add(out, at("l/link"), "new"));
    CHECK(add(out, at("l/dangling"), "x") == IBL_ERR_IO &&
          test_said(&kept, "choose another name"));
    CHECK(add(out, at("l/loop"), "x") == IBL_ERR_IO);
    CHECK(add(out, at("l/dir"), "x") == IBL_ERR_IO &&
          test_said(&kept, "directory"));
    CHECK(!ibl_outputs_commit(out));
    CHECK(!lstat(at("l/link"), &st) && S_ISLNK(st.st_mode));
    CHECK(holds(at("l/far/file"), "new"));
    CHECK(entries(at("l/far")) == 1 && entries(at("l")) == 5);
}

/* ---- a system that fails, which check-faults.sh walks, too ----------------
 */

/* A file system that cannot flush, or directories that another program makes
 * just before we do: what is no failure. */
static bool odd_system;

/* What has been flushed, and how often. */
static struct {
    struct stat of[32];
    int count;
} flushes;

int __real_fsync(int fd);
int __wrap_fsync(int fd);
int __wrap_fsync(int fd)
{
    if (flushes.count < 32 && !fstat(fd, &flushes.of[flushes.count]))
        flushes.count++;
    errno = EINVAL;
    return odd_system ? -1 : __real_fsync(fd);
}

int __real_mkdir(const char *path, mode_t mode);
int __wrap_mkdir(const char *path, mode_t mode);
int __wrap_mkdir(const char *path, mode_t mode)
{
    const int result = __real_mkdir(path, mode);
    errno = result ? errno : EEXIST;
    return odd_system ? -1 : result;
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

/* Each file, and each directory that something was put or made in; on an odd
 * system, too. */
TEST(flushed)
{
    static const char *const paths[] = {"f/a", "f/x/y/b", "f/x/y/c",
                                        "f",   "f/x",     "f/x/y"};
    NEED(!mkdir(at("f"), 0777));
    for (int n = 0; n < 3; n++) {
        const int sync = n > 0;
        ibl_outputs *out;
        flushes.count = 0;
        odd_system = n == 2;
        NEED(!ibl_outputs_create(ctx, sync, &out));
        NEED(!ibl_outputs_mkdir(out, at("f/x/y")));
        for (int i = 0; i < 3; i++)
            CHECK(!add(out, at("%s", paths[i]), paths[i]));
        CHECK(flushes.count == 3 * sync);
        CHECK(!ibl_outputs_commit(out));
        ibl_outputs_free(out);
        for (int i = 0; i < 6; i++)
            /* What another program made is flushed by it. */
            CHECK_MSG((n == 2 && i == 4) ||
                          !times_flushed(at("%s", paths[i])) == !sync,
                      "%s was flushed %d times", paths[i],
                      times_flushed(at("%s", paths[i])));
        for (int i = 0; i < 3; i++)
            CHECK(holds(at("%s", paths[i]), paths[i]) &&
                  !remove(at("%s", paths[i])));
        CHECK(!rmdir(at("f/x/y")) && !rmdir(at("f/x")));
        odd_system = false;
    }
}

/* ---- other processes ------------------------------------------------- */

/* A commit waits for whoever has locked its directory, but for its program. */
TEST(two_at_once)
{
    const struct timespec nap = {0, 30000000};
    int result;

    NEED(!mkdir(at("two"), 0777));
    const int fd = open(at("two"), O_RDONLY);
    NEED(fd >= 0 && !flock(fd, LOCK_SH));
    const pid_t child = fork();
    NEED(child >= 0);
    if (!child) {
        ibl_outputs *other = NULL;
        close(fd);
        _exit(ibl_outputs_create(ctx, 0, &other) ||
              add(other, at("two/a"), "x") || ibl_outputs_commit(other));
    }
    nanosleep(&nap, NULL);
    CHECK(!exists(at("two/a")));
    NEED(!flock(fd, LOCK_UN));
    NEED(waitpid(child, &result, 0) == child);
    CHECK(!result && holds(at("two/a"), "x") && entries(at("two")) == 1);

    ibl_outputs *out = create();
    NEED(!flock(fd, LOCK_EX));
    ibl_outputs_hold(out, at("two"));
    alarm(60);
    CHECK(!add(out, at("two/a"), "y") && !ibl_outputs_commit(out));
    alarm(0);
    close(fd);
}

void test_setup(void)
{
    ctx = test_keeping_ctx(1, &kept);
}
