/* SPDX-License-Identifier: MIT */
/*
 * Commands in turns, A B C A B C, so that what disturbs the machine for a
 * while disturbs all of them.
 *
 *     bench_turns ROUNDS NAME COMMAND [ARGUMENT...] [, NAME COMMAND ...]...
 *
 * A comma of its own stands between commands, which run without a shell. One
 * round is not counted. Prints a line for each,
 *     NAME ROUNDS wall MEDIAN MIN cpu MEDIAN MIN said MEDIAN MIN peak MIB
 * in milliseconds: whole processes from start to end, their user and system
 * time, and what they said of themselves in a line "ms NUMBER" on standard
 * output, or - -, and the most memory of a round. A command that fails ends
 * all, with its name.
 */
#define _GNU_SOURCE /* wait4, pipe2 */

#include <fcntl.h>
#include <math.h>
#include <spawn.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include "test.h"

extern char **environ;

enum {
    MAX_COMMANDS = 16,
    MAX_ROUNDS = 999
};

typedef enum measure {
    WALL,
    CPU,
    SAID,
    PEAK,
    MEASURES
} measure;

typedef struct command {
    const char *name;
    char **argv; /* ended by NULL */
    double ms[MEASURES][MAX_ROUNDS];
} command;

static command commands[MAX_COMMANDS];

static double timeval_ms(struct timeval t)
{
    return (double)t.tv_sec * 1e3 + (double)t.tv_usec * 1e-3;
}

/* What a child says into a pipe; NAN unless it is "ms NUMBER". */
static double listen_to(int fd)
{
    char text[256] = "";
    size_t length = 0;
    ssize_t got;
    double ms;

    while ((got = read(fd, text + length, sizeof text - 1 - length)) > 0)
        length += (size_t)got;
    text[length] = '\0';
    return sscanf(text, "ms %lf", &ms) == 1 ? ms : (double)NAN;
}

/* False after a word on stderr. */
static bool run(const command *c, double ms[MEASURES])
{
    posix_spawn_file_actions_t actions;
    struct rusage used;
    int ends[2], status = 0;
    pid_t pid;

    if (pipe2(ends, O_CLOEXEC))
        return false;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_adddup2(&actions, ends[1], STDOUT_FILENO);
    const double begin = test_ms(CLOCK_MONOTONIC);
    const int why =
        posix_spawnp(&pid, c->argv[0], &actions, NULL, c->argv, environ);
    close(ends[1]);
    if (!why) {
        ms[SAID] = listen_to(ends[0]);
        wait4(pid, &status, 0, &used);
        ms[WALL] = test_ms(CLOCK_MONOTONIC) - begin;
        ms[CPU] = timeval_ms(used.ru_utime) + timeval_ms(used.ru_stime);
        ms[PEAK] = (double)used.ru_maxrss / 1024;
    }
    close(ends[0]);
    posix_spawn_file_actions_destroy(&actions);
    if (why)
        fprintf(stderr, "%s: %s: %s\n", c->name, c->argv[0], strerror(why));
    else if (status)
        fprintf(stderr, "%s: %s failed\n", c->name, c->argv[0]);
    return !why && !status;
}

static void print(const char *what, double *ms, int rounds)
{
    if (isnan(ms[0])) {
        printf(" %s - -", what);
        return;
    }
    const double median = test_median(ms, rounds);
    printf(" %s %.3f %.3f", what, median, ms[0]);
}

/* Cuts the arguments at the commas; 0: wrong. */
static int parse(char **argv)
{
    int count = 0;

    while (*argv && count < MAX_COMMANDS) {
        command *c = &commands[count++];
        c->name = *argv++;
        c->argv = argv;
        while (*argv && strcmp(*argv, ",") != 0)
            argv++;
        if (c->argv == argv)
            return 0;
        if (*argv)
            *argv++ = NULL;
    }
    return *argv ? 0 : count;
}

int main(int argc, char **argv)
{
    const int rounds = argc > 3 ? atoi(argv[1]) : 0;
    const int count = rounds > 0 && rounds <= MAX_ROUNDS ? parse(argv + 2) : 0;

    if (!count) {
        fprintf(stderr,
                "usage: bench_turns 1..%d NAME COMMAND [, NAME COMMAND]...\n",
                MAX_ROUNDS);
        return 2;
    }
    for (int round = -1; round < rounds; round++)
        for (int i = 0; i < count; i++) {
            command *c = &commands[i];
            double ms[MEASURES];
            if (!run(c, ms))
                return 1;
            for (int k = 0; k < MEASURES && round >= 0; k++)
                c->ms[k][round] = ms[k];
        }
    for (int i = 0; i < count; i++) {
        printf("%s %d", commands[i].name, rounds);
        print("wall", commands[i].ms[WALL], rounds);
        print("cpu", commands[i].ms[CPU], rounds);
        print("said", commands[i].ms[SAID], rounds);
        test_median(commands[i].ms[PEAK], rounds);
        printf(" peak %.1f\n", commands[i].ms[PEAK][rounds - 1]);
    }
    return 0;
}
