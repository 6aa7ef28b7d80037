/* SPDX-License-Identifier: MIT */
/*
 * What starting a program costs over starting nothing: runs `PROGRAM
 * --version` and an empty C program in turns, prints both medians.
 *     bench_startup PROGRAM EMPTY [ROUNDS]
 */
#include <fcntl.h>
#include <spawn.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

extern char **environ;

enum {
    MAX_ROUNDS = 10000
};

static double milliseconds(char *program, char *argument)
{
    char *argv[] = {program, argument, NULL};
    posix_spawn_file_actions_t silent;
    struct timespec a, b;
    pid_t pid;
    int status = 0;

    posix_spawn_file_actions_init(&silent);
    posix_spawn_file_actions_addopen(&silent, 1, "/dev/null", O_WRONLY, 0);
    clock_gettime(CLOCK_MONOTONIC, &a);
    if (posix_spawn(&pid, program, &silent, NULL, argv, environ) ||
        waitpid(pid, &status, 0) != pid || status) {
        fprintf(stderr, "bench_startup: %s failed\n", program);
        exit(1);
    }
    clock_gettime(CLOCK_MONOTONIC, &b);
    posix_spawn_file_actions_destroy(&silent);
    return 1e3 * (double)(b.tv_sec - a.tv_sec) +
           1e-6 * (double)(b.tv_nsec - a.tv_nsec);
}

static int by_value(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

int main(int argc, char **argv)
{
    static double program[MAX_ROUNDS], empty[MAX_ROUNDS];
    const int rounds = argc > 3 ? atoi(argv[3]) : 200;
    char version[] = "--version";

    if (argc < 3 || rounds < 1 || rounds > MAX_ROUNDS) {
        fprintf(stderr, "usage: bench_startup PROGRAM EMPTY [ROUNDS]\n");
        return 2;
    }
    for (int i = 0; i < rounds; i++) {
        program[i] = milliseconds(argv[1], version);
        empty[i] = milliseconds(argv[2], NULL);
    }
    qsort(program, (size_t)rounds, sizeof *program, by_value);
    qsort(empty, (size_t)rounds, sizeof *empty, by_value);
    printf("%s --version %.2f ms, an empty C program %.2f ms: medians of %d "
           "in turns\n",
           argv[1], program[rounds / 2], empty[rounds / 2], rounds);
    return 0;
}
