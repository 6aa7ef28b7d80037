/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE /* wait4, pipe2 */
#include "cli/child.h"

#include <errno.h>
#include <fcntl.h>
#include <ftw.h>
#include <math.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include "cli/console.h"
#include "common/clock.h"
#include "common/signals.h"

/* ---- commands -------------------------------------------------------- */

static double seconds(struct timeval t)
{
    return (double)t.tv_sec + 1e-6 * (double)t.tv_usec;
}

/* Forks a child that leads a process group and has the default handlers. A
 * signal that ends this program also kills the group. Returns as fork does. */
static pid_t fork_group(void)
{
    /* A signal must not end this program before ibl_signals_group. */
    ibl_signals_hold();
    const pid_t pid = fork();
    const int why = errno;

    if (pid == 0)
        ibl_signals_pass(SIG_DFL);
    if (pid >= 0)
        setpgid(pid, pid); /* in both: either may run first */
    if (pid > 0)
        ibl_signals_group(pid);
    ibl_signals_release();
    errno = why;
    return pid;
}

/* In the child: runs argv with this signal mask. */
static void run(char *const *argv, const char *log, const sigset_t *mask)
{
    const int in = open("/dev/null", O_RDONLY | O_CLOEXEC);
    const int out = open(log, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);

    signal(SIGXFSZ, SIG_DFL);
    sigprocmask(SIG_SETMASK, mask, NULL);
    if (dup2(in, STDIN_FILENO) >= 0 && dup2(out, STDOUT_FILENO) >= 0 &&
        dup2(out, STDERR_FILENO) >= 0)
        execv(argv[0], argv);
    dprintf(STDERR_FILENO, "cannot be run: %s\n", strerror(errno));
    _exit(127);
}

/* Waits for pid until the time `end`, then kills its group and returns true.
 * The caller must have blocked SIGCHLD. */
static bool await(pid_t pid, double end, int *status, struct rusage *usage)
{
    sigset_t set;

    sigemptyset(&set);
    sigaddset(&set, SIGCHLD);
    while (wait4(pid, status, WNOHANG, usage) == 0) {
        const double left = end - ibl_now();
        if (left <= 0) {
            kill(-pid, SIGKILL);
            while (wait4(pid, status, 0, usage) < 0 && errno == EINTR)
                ;
            return true;
        }
        const struct timespec wait = {(time_t)left,
                                      (long)(1e9 * (left - floor(left)))};
        sigtimedwait(&set, NULL, &wait);
    }
    return false;
}

/* The last line of a file that is not blank; control characters become ' '. */
static void last_line(const char *path, char *line, size_t size)
{
    char tail[1024];
    FILE *f = fopen(path, "rb");
    size_t n = 0;

    *line = '\0';
    if (!f)
        return;
    if (fseek(f, -(long)sizeof tail + 1, SEEK_END))
        rewind(f);
    n = fread(tail, 1, sizeof tail - 1, f);
    fclose(f);
    while (n && (unsigned char)tail[n - 1] <= ' ')
        n--;
    tail[n] = '\0';
    char *start = tail;
    for (size_t i = 0; i < n; i++)
        if (tail[i] == '\n' || tail[i] == '\r')
            start = tail + i + 1;
        else if ((unsigned char)tail[i] < ' ')
            tail[i] = ' ';
    snprintf(line, size, "%.*s", (int)size - 1, start);
}

/* Writes why a command with this status failed; nothing if it did not. */
static void explain(int status, const char *log, char *text, size_t size)
{
    char line[400];

    if (WIFEXITED(status) && WEXITSTATUS(status) == 0)
        return;
    last_line(log, line, sizeof line);
    snprintf(text, size, "%s %d%s%s",
             WIFSIGNALED(status) ? "killed by signal" : "exit status",
             WIFSIGNALED(status) ? WTERMSIG(status) : WEXITSTATUS(status),
             *line ? ": " : "", line);
}

bool ibl_child_run(char *const *argv, const char *log, double limit_s,
                   ibl_child *result)
{
    char *reason = result->reason;
    const size_t size = sizeof result->reason;
    struct rusage usage = {0};
    sigset_t chld, mask;
    int status = 0;

    *result = (ibl_child){0};
    signal(SIGCHLD, SIG_DFL); /* if it is ignored, wait4 gets no status */
    sigemptyset(&chld);
    sigaddset(&chld, SIGCHLD);
    sigprocmask(SIG_BLOCK, &chld, &mask);
    const double begin = ibl_now();
    const pid_t pid = fork_group();
    if (pid == 0)
        run(argv, log, &mask);
    if (pid < 0) {
        snprintf(reason, size, "cannot be run: %s", strerror(errno));
    } else {
        result->timed_out = await(pid, begin + limit_s, &status, &usage);
        if (result->timed_out)
            snprintf(reason, size, "no end within %g s", limit_s);
        else
            explain(status, log, reason, size);
        result->wall_s = ibl_now() - begin;
        result->cpu_s = seconds(usage.ru_utime) + seconds(usage.ru_stime);
        result->peak_bytes = (size_t)usage.ru_maxrss * 1024;
        kill(-pid, SIGKILL);
        ibl_signals_group(0);
    }
    sigprocmask(SIG_SETMASK, &mask, NULL);
    return !*reason;
}

static int wait_for(pid_t pid)
{
    int status = 0;

    while (waitpid(pid, &status, 0) < 0 && errno == EINTR)
        ;
    return status;
}

int ibl_child_call(bool (*work)(void *cookie), void *cookie)
{
    const pid_t pid = fork_group();

    if (pid == 0)
        _exit(!work(cookie));
    const int status = pid > 0 ? wait_for(pid) : -1;
    ibl_signals_group(0);
    return status;
}

/* ---- directory ------------------------------------------------------- */

static int remove_entry(const char *path, const struct stat *st, int kind,
                        struct FTW *where)
{
    (void)st, (void)where;
    return (kind == FTW_DP ? rmdir(path) : unlink(path)) && errno != ENOENT;
}

bool ibl_scratch_remove(const char *path)
{
    const struct timespec pause = {0, 20000000};

    /* A process that was just killed may still be writing. */
    for (int attempt = 0; attempt < 50; attempt++) {
        if (!nftw(path, remove_entry, 16, FTW_DEPTH | FTW_PHYS) ||
            errno == ENOENT)
            return true;
        nanosleep(&pause, NULL);
    }
    return false;
}

/* Waits until the program closes the other end of the pipe or ends in any way,
 * then removes the directory. */
static void remove_later(int end, const char *path)
{
    char byte;

    ibl_signals_pass(SIG_IGN);
    setpgid(0, 0);
    ibl_signals_release();
    while (read(end, &byte, 1) < 0 && errno == EINTR)
        ;
    if (ibl_scratch_remove(path))
        _exit(0);
    fprintf(stderr, "iblbake: %s: cannot be removed: %s\n", path,
            strerror(errno));
    _exit(1);
}

/* Makes a directory and a process that removes it when *end is closed. Returns
 * the process's id, or -1 after a line on stderr. */
static pid_t make_scratch(const char *parent, char *path, int *end)
{
    pid_t pid = -1;
    int ends[2];

    if (!mkdtemp(path)) {
        fprintf(stderr,
                "iblbake: %s: no directory can be made there: %s: set "
                "TMPDIR to another\n",
                parent, strerror(errno));
        return -1;
    }
    if (!pipe2(ends, O_CLOEXEC)) {
        pid = fork();
        if (pid)
            close(ends[0]);
        else
            close(ends[1]);
        *end = ends[1];
    }
    if (pid == 0)
        remove_later(ends[0], path);
    if (pid < 0) {
        fprintf(stderr, "iblbake: no process can be made: %s\n",
                strerror(errno));
        rmdir(path);
    }
    return pid;
}

int ibl_scratch_run(int (*work)(const void *cookie, const char *path),
                    const void *cookie)
{
    const char *parent = getenv("TMPDIR");
    char path[4096];
    int end;

    if (!parent || !*parent)
        parent = "/tmp";
    if (snprintf(path, sizeof path, "%s/iblbake-bench-XXXXXX", parent) >=
        (int)sizeof path - 256) {
        fprintf(stderr,
                "iblbake: %.40s...: the name is too long: set TMPDIR "
                "to another directory\n",
                parent);
        return 1;
    }
    ibl_signals_hold();
    const pid_t remover = make_scratch(parent, path, &end);
    ibl_signals_catch();
    ibl_signals_release();
    if (remover < 0)
        return 1;
    const int status = work(cookie, path);
    close(end);
    return wait_for(remover) ? 1 : status;
}
