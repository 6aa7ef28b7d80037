/* SPDX-License-Identifier: MIT */
/* wait4 is no part of POSIX. */
#define _DEFAULT_SOURCE

#include "cli/child.h"

#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include "cli/signals.h"

static double now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static void point_to(int fd, const char *path, int flags)
{
    const int file = open(path, flags, 0600);
    if (file >= 0) {
        dup2(file, fd);
        close(file);
    }
}

/* In the child: what argv sees, then argv. The reason why it does not start
 * goes into the pipe, which a start closes. */
static void become(const char *const *argv, const char *log,
                   const sigset_t *mask, int report)
{
    setpgid(0, 0);
    point_to(STDIN_FILENO, "/dev/null", O_RDONLY);
    point_to(STDOUT_FILENO, log, O_WRONLY | O_CREAT | O_TRUNC);
    dup2(STDOUT_FILENO, STDERR_FILENO);
    signal(SIGXFSZ, SIG_DFL);
    sigprocmask(SIG_SETMASK, mask, NULL);
    execv(argv[0], (char *const *)argv);
    const int why = errno;
    (void)!write(report, &why, sizeof why);
    _exit(127);
}

static double seconds(struct timeval t)
{
    return (double)t.tv_sec + 1e-6 * (double)t.tv_usec;
}

/* Waits for pid, at most until the end; SIGCHLD is blocked. */
static void await(pid_t pid, double end, ibl_child *result)
{
    struct rusage usage;
    sigset_t set;
    pid_t got;

    sigemptyset(&set);
    sigaddset(&set, SIGCHLD);
    while ((got = wait4(pid, &result->status, WNOHANG, &usage)) == 0) {
        const double left = end - now();
        if (left <= 0 || result->timed_out) {
            result->timed_out = true;
            kill(-pid, SIGKILL);
            while ((got = wait4(pid, &result->status, 0, &usage)) < 0 &&
                   errno == EINTR)
                ;
            break;
        }
        const struct timespec wait = {(time_t)left,
                                      (long)(1e9 * (left - floor(left)))};
        sigtimedwait(&set, NULL, &wait);
    }
    if (got < 0) {
        result->error = errno;
        return;
    }
    result->cpu_s = seconds(usage.ru_utime) + seconds(usage.ru_stime);
    result->peak_bytes = (size_t)usage.ru_maxrss * 1024;
}

void ibl_child_run(const char *const *argv, const char *log, double limit_s,
                   ibl_child *result)
{
    sigset_t chld, mask;
    int report[2], why;

    *result = (ibl_child){0};
    if (pipe(report)) {
        result->error = errno;
        return;
    }
    fcntl(report[1], F_SETFD, FD_CLOEXEC);
    signal(SIGCHLD, SIG_DFL); /* ignored, there would be nothing to wait for */
    sigemptyset(&chld);
    sigaddset(&chld, SIGCHLD);
    sigprocmask(SIG_BLOCK, &chld, &mask);
    /* Between the fork and the note of the group no signal may end us. */
    ibl_signals_hold();
    const double begin = now();
    const pid_t pid = fork();
    if (pid == 0) {
        close(report[0]);
        become(argv, log, &mask, report[1]);
    }
    close(report[1]);
    if (pid < 0) {
        result->error = errno;
        ibl_signals_release();
    } else {
        setpgid(pid, pid); /* here too: whoever comes first */
        ibl_signals_group(pid);
        ibl_signals_release();
        await(pid, begin + limit_s, result);
        result->wall_s = now() - begin;
        kill(-pid, SIGKILL);
        ibl_signals_group(0);
        if (read(report[0], &why, sizeof why) == sizeof why)
            result->error = why;
    }
    close(report[0]);
    sigprocmask(SIG_SETMASK, &mask, NULL);
}

/* The last line of a file that is not blank, without control characters. */
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

void ibl_child_reason(const ibl_child *c, const char *log, double limit_s,
                      char *text, size_t size)
{
    char line[400];

    *text = '\0';
    if (c->error) {
        snprintf(text, size, "cannot be run: %s", strerror(c->error));
        return;
    }
    if (c->timed_out) {
        snprintf(text, size, "no end within %g s", limit_s);
        return;
    }
    if (WIFEXITED(c->status) && WEXITSTATUS(c->status) == 0)
        return;
    last_line(log, line, sizeof line);
    if (WIFSIGNALED(c->status))
        snprintf(text, size, "killed by signal %d", WTERMSIG(c->status));
    else
        snprintf(text, size, "exit status %d", WEXITSTATUS(c->status));
    if (*line) {
        const size_t used = strlen(text);
        snprintf(text + used, size - used, ": %s", line);
    }
}
