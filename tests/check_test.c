/* SPDX-License-Identifier: MIT */
/* What becomes of a test that ends the program: it is named, and ends it. */
#define _XOPEN_SOURCE 700
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "files.h"
#include "test.h"

static volatile int zero;

static void reads_nothing(void)
{
    zero = *(volatile int *)(uintptr_t)zero;
}

static void leaves(void)
{
    exit(3);
}

/* In a process of its own, which the shell becomes. */
TEST(ends)
{
    static const struct {
        void (*crash)(void);
        const char *by; /* that, or a sanitizer */
        int status, signal;
    } ends[] = {
        {reads_nothing, "SIGSEGV", 0, SIGSEGV},
        {abort, "SIGABRT", 0, SIGABRT},
        {leaves, "exit()", 3, 0},
    };
    const char *end = getenv("IBL_TEST_END");
    const char *self = file_built("tests/check_test");
    char said[4096];

    if (end) {
        const struct rlimit none = {0, 0};
        setrlimit(RLIMIT_CORE, &none);
        CHECK(end[0]);
        ends[atoi(end)].crash();
    }
    const int line = __LINE__ - 3;
    NEED(self);
    for (int i = 0; i < 3; i++) {
        FILE *run = popen(test_text("IBL_TEST_END=%d exec '%s' ends "
                                    "2>/dev/null",
                                    i, self),
                          "r");
        NEED(run);
        const size_t size = fread(said, 1, sizeof said - 1, run);
        const int status = pclose(run);
        said[size] = '\0';
        const char *want = test_text("%s:%d: ends: ended here or after it by ",
                                     __FILE__, line);
        CHECK_MSG(!strncmp(said, want, strlen(want)) &&
                      (TEST_SANITIZED || strstr(said, ends[i].by)) &&
                      strchr(said, '\n') == said + size - 1,
                  "%d: %s", i, said);
        CHECK_MSG(
            TEST_SANITIZED ? status != 0
            : ends[i].signal
                ? WIFSIGNALED(status) && WTERMSIG(status) == ends[i].signal
                : WIFEXITED(status) && WEXITSTATUS(status) == ends[i].status,
            "%d: status %x", i, (unsigned)status);
    }
}

/* A name that is none is told, also beside one that is. */
TEST(names)
{
    CHECK(file_run("! %s names none >said && grep -q '^none: no test' said",
                   file_built("tests/check_test")));
}
