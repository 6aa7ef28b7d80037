/* SPDX-License-Identifier: MIT */
#include "cli/scratch.h"

#include <errno.h>
#include <ftw.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include "cli/signals.h"

static volatile sig_atomic_t worker;

static int remove_entry(const char *path, const struct stat *st, int kind,
                        struct FTW *where)
{
    (void)st, (void)where;
    return (kind == FTW_DP ? rmdir(path) : unlink(path)) && errno != ENOENT;
}

bool ibl_scratch_remove(const char *path)
{
    const struct timespec pause = {0, 20000000};

    /* What was just killed may still be writing, or hold what is missing. */
    for (int attempt = 0; attempt < 50; attempt++) {
        if (!nftw(path, remove_entry, 16, FTW_DEPTH | FTW_PHYS) ||
            errno == ENOENT)
            return true;
        nanosleep(&pause, NULL);
    }
    return false;
}

static void pass_on(int number)
{
    const int saved = errno;
    if (worker > 0)
        kill((pid_t)worker, number);
    errno = saved;
}

static int begin(const char *path, int (*work)(void *, const char *),
                 void *cookie)
{
    const pid_t pid = fork();

    if (pid == 0) {
        ibl_signals_catch();
        ibl_signals_release();
        int status = work(cookie, path);
        if (fflush(stdout) || ferror(stdout)) {
            perror("iblbake: standard output");
            status = 1;
        }
        exit(status);
    }
    worker = pid;
    return pid < 0 ? errno : 0;
}

/* Waits for the worker; its exit status, or 1. */
static int await(int *killer)
{
    int status = 0;

    while (waitpid((pid_t)worker, &status, 0) < 0 && errno == EINTR)
        ;
    *killer = WIFSIGNALED(status) ? WTERMSIG(status) : 0;
    return WIFEXITED(status) ? WEXITSTATUS(status) : 1;
}

int ibl_scratch_run(int (*work)(void *cookie, const char *path), void *cookie)
{
    const char *parent = getenv("TMPDIR");
    char path[4096];
    int killer = 0, status = 1;

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
    if (!mkdtemp(path)) {
        fprintf(stderr,
                "iblbake: %s: no directory can be made there: %s: set "
                "TMPDIR to another\n",
                parent, strerror(errno));
        ibl_signals_release();
        return 1;
    }
    fflush(stdout);
    const int why = begin(path, work, cookie);
    if (why) {
        fprintf(stderr, "iblbake: no process can be made: %s\n", strerror(why));
    } else {
        ibl_signals_pass(pass_on);
        ibl_signals_release();
        status = await(&killer);
        ibl_signals_hold();
    }
    if (!ibl_scratch_remove(path)) {
        fprintf(stderr, "iblbake: %s: cannot be removed: %s\n", path,
                strerror(errno));
        status = 1;
    }
    ibl_signals_pass(SIG_DFL);
    ibl_signals_release();
    if (killer == SIGKILL || killer == SIGSEGV || killer == SIGBUS ||
        killer == SIGFPE || killer == SIGILL)
        fprintf(stderr,
                "iblbake: the measuring process was killed by signal "
                "%d\n",
                killer);
    else if (killer)
        raise(killer);
    return status;
}
