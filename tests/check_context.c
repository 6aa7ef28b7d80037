/* SPDX-License-Identifier: MIT */
/* Contexts, their refusals, the pool and cancelling. */
#define _GNU_SOURCE
#include <limits.h>
#include <signal.h>
#include <stdatomic.h>
#include <stdio.h>
#include <string.h>
#include <time.h>

#include "core/context.h"
#include "files.h"
#include "maps.h"
#include "port/port.h"

static void keep_end(void *cookie, ibl_log_level level, const char *text)
{
    (void)level;
    snprintf(cookie, 16, "%s", text + strlen(text) - 4);
}

/* Two of the longest paths and some words arrive whole, and in one line. */
TEST(long_messages)
{
    static char path[PATH_MAX];
    ibl_ctx_options opts = ibl_ctx_options_default();
    char end[16] = {0};

    opts.log = keep_end;
    opts.log_cookie = end;
    ibl_ctx *ctx = test_ctx_of(&opts);
    memset(path, 'x', sizeof path - 1);
    ibl_warn(ctx, "%s: cannot be renamed to %s: no", path, path);
    CHECK(!strcmp(end, ": no"));
    ibl_warn(ctx, "no\n\x7f.hdr: 0\t1");
    CHECK(!strcmp(end, " 0?1"));
    ibl_warn(ctx, "no.\r\x7f\n\xc3");
    CHECK(!strcmp(end, "???\xc3"));
}

/* Systems as of the kernel's cgroup-v2.rst: CPUs and memory. */
TEST(quotas)
{
    static const struct {
        const char *groups;
        const char *files; /* made by a shell, in /sys/fs/cgroup */
        int cpus;
        unsigned long long bytes;
    } cases[] = {
        {"0::/a", "echo max >a/memory.max", 0, 0},
        {"0::/a/b", "echo 9000 >a/b/memory.max; echo 5000 >a/memory.max", 0,
         5000},
        {"", "true", 0, 0},
        {"0::/", "true", 0, 0},
        {"0::/a", "echo max 100000 >a/cpu.max", 0, 0},
        {"0::/a", "echo 150000 100000 >a/cpu.max", 2, 0},
        {"0::/a/b",
         "echo 900000 100000 >a/b/cpu.max; echo 300000 100000 >a/cpu.max", 3,
         0},
        /* what a container sees: its group is the root of what is there */
        {"4:cpuset:/z\n0::/docker/0123", "echo 400000 100000 >cpu.max", 4, 0},
        /* neither of version 1, nor one that is not this process's */
        {"10::/a\n0::/b", "echo 100000 100000 >a/cpu.max", 0, 0},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        NEED(file_run("rm -rf sys proc && mkdir -p proc/self && "
                      "printf '%s\n' >proc/self/cgroup && "
                      "mkdir -p sys/fs/cgroup/a/b && cd sys/fs/cgroup && %s",
                      cases[i].groups, cases[i].files));
        const int cpus = (int)ibl_port_quota(test_dir(), "cpu.max");
        CHECK_MSG(cpus == cases[i].cpus, "case %zu: %d", i, cpus);
        const uint64_t bytes = ibl_port_quota(test_dir(), "memory.max");
        CHECK_MSG(bytes == cases[i].bytes, "case %zu: %llu", i,
                  (unsigned long long)bytes);
    }
    CHECK(ibl_port_quota("nowhere", "cpu.max") == 0);
    CHECK(ibl_memory_allowed() > 0);
}

enum {
    JOBS = 5000
};

struct batch {
    ibl_ctx *ctx;
    int stop_at; /* the job that cancels, or -1 */
    atomic_int ran[JOBS];
    atomic_int inside[8]; /* jobs of each worker at once */
    atomic_bool wrong;
};

static void count_job(void *arg, int job, int worker)
{
    struct batch *b = arg;
    if (worker < 0 || worker >= ibl_ctx_threads(b->ctx) ||
        atomic_fetch_add(&b->inside[worker], 1))
        atomic_store(&b->wrong, true);
    atomic_fetch_add(&b->ran[job], 1);
    if (job == b->stop_at)
        ibl_ctx_cancel(b->ctx);
    atomic_fetch_sub(&b->inside[worker], 1);
}

struct begun_job {
    struct batch *b; /* that checks workers */
    int first;       /* of its jobs, in b->ran */
};

static void begun_job(void *arg, int job, int worker)
{
    const struct begun_job *j = arg;
    count_job(j->b, j->first + job, worker);
}

/* Up to three batches that were begun go on beside runs: every job once, a
 * worker in one of them at a time, and all ended when the end has been waited
 * for. */
TEST(begun_beside_runs)
{
    static struct batch b;
    const struct timespec nap = {0, 200000};
    for (int threads = 1; threads <= 8; threads *= 2) {
        const struct begun_job part[4] = {
            {&b, 0}, {&b, 12}, {&b, 24}, {&b, 36}};
        static int want[JOBS];
        b.ctx = test_ctx(threads, IBL_ISA_AUTO);
        b.stop_at = -1;
        memset(b.ran, 0, sizeof b.ran);
        memset(want, 0, sizeof want);
        for (int n = 0; n < 1000; n++) {
            const int count = n % 4;
            int jobs[4];
            for (int k = 0; k < 4; k++) {
                jobs[k] = (n / 4 + 5 * k) % 12;
                if (k == 3 && n % 100 == 1)
                    jobs[k] = JOBS - 36;
                for (int i = 0; i < jobs[k] && (k < count || k == 3); i++)
                    want[12 * k + i]++;
            }
            for (int k = 0; k < count; k++)
                ibl_run_begin(b.ctx, "begun", 0, jobs[k], begun_job,
                              (void *)(uintptr_t)&part[k]);
            CHECK(!ibl_run(b.ctx, NULL, jobs[3], begun_job,
                           (void *)(uintptr_t)&part[3]));
            bool right = true;
            for (int i = 36; i < JOBS; i++)
                right &= b.ran[i] == want[i];
            CHECK(!ibl_run_end(b.ctx));
            for (int i = 0; i < JOBS; i++)
                right &= b.ran[i] == want[i];
            NEED(right);
            if (n % 16 == 0) /* the threads fall asleep */
                nanosleep(&nap, NULL);
        }
        CHECK(!b.wrong);
        b.stop_at = 3;
        ibl_run_begin(b.ctx, "begun", 0, 12, begun_job,
                      (void *)(uintptr_t)&part[0]);
        CHECK(ibl_run_end(b.ctx) == IBL_ERR_CANCELLED);
    }
}

struct slow {
    atomic_int runs;
    int microseconds;
};

static void slow_task(void *arg, int job, int worker)
{
    struct slow *s = arg;
    (void)job;
    (void)worker;
    const struct timespec nap = {0, 1000L * s->microseconds};
    nanosleep(&nap, NULL);
    atomic_fetch_add(&s->runs, 1);
}

/* A task runs once, beside batches that lose nothing by it; a second one only
 * after the first was waited for; alone there is nobody to do it. */
TEST(task_beside_batches)
{
    static struct batch b;
    struct slow s = {0};
    for (int threads = 1; threads <= 4; threads++) {
        ibl_ctx_options opts = ibl_ctx_options_default();
        opts.threads = threads;
        NEED(!ibl_ctx_create(&opts, &b.ctx));
        b.stop_at = -1;
        ibl_task_finish(b.ctx);
        for (int n = 0; n < 300; n++) {
            memset(b.ran, 0, sizeof b.ran);
            atomic_store(&s.runs, 0);
            s.microseconds = n % 3 * 40;
            const bool started = ibl_task_start(b.ctx, slow_task, &s);
            CHECK(started == (threads > 1));
            CHECK(!started || !ibl_task_start(b.ctx, slow_task, &s));
            for (int k = 0; k < n % 4; k++)
                CHECK(ibl_run(b.ctx, NULL, 5, count_job, &b) == IBL_OK);
            ibl_task_finish(b.ctx);
            CHECK(atomic_load(&s.runs) == started);
            for (int i = 0; i < 5; i++)
                CHECK(b.ran[i] == n % 4);
        }
        atomic_store(&s.runs, 0);
        const bool started = ibl_task_start(b.ctx, slow_task, &s);
        ibl_ctx_free(b.ctx); /* waits for it, or does it */
        CHECK(atomic_load(&s.runs) == started);
    }
}

enum {
    SIGNALS = 10,
    FIRST_FAULT = 5 /* a thread's own: those are never blocked */
};
static const int kinds[SIGNALS] = {SIGHUP,  SIGTERM, SIGUSR1, SIGXCPU, SIGPIPE,
                                   SIGSEGV, SIGBUS,  SIGFPE,  SIGILL,  SIGTRAP};

struct masks {
    atomic_int inside;
    bool blocked[2][SIGNALS]; /* by worker */
};

/* Both are inside before one looks: each is a worker's only job. */
static void mask_job(void *arg, int job, int worker)
{
    struct masks *m = arg;
    sigset_t set;

    (void)job;
    atomic_fetch_add(&m->inside, 1);
    while (atomic_load(&m->inside) < 2)
        ;
    pthread_sigmask(SIG_BLOCK, NULL, &set);
    for (int i = 0; i < SIGNALS; i++)
        m->blocked[worker][i] = sigismember(&set, kinds[i]);
}

/* Signals never run in workers; those that the caller blocks stay blocked. */
TEST(signals)
{
    struct masks m = {0};
    ibl_ctx *ctx;
    sigset_t one;

    sigemptyset(&one);
    sigaddset(&one, SIGUSR1);
    pthread_sigmask(SIG_SETMASK, &one, NULL);
    ctx = test_ctx(2, IBL_ISA_AUTO);
    CHECK(!ibl_run(ctx, NULL, 2, mask_job, &m));
    for (int i = 0; i < SIGNALS; i++) {
        CHECK_MSG(m.blocked[0][i] == (kinds[i] == SIGUSR1), "signal %d",
                  kinds[i]);
        CHECK_MSG(m.blocked[1][i] == (i < FIRST_FAULT), "signal %d", kinds[i]);
    }
    sigemptyset(&one);
    pthread_sigmask(SIG_SETMASK, &one, NULL);
}

/* A cancel keeps jobs from starting, and everything later from running. */
TEST(cancel)
{
    static struct batch b;
    ibl_cube cube = {0};
    ibl_lut lut = {0};
    ibl_light light;
    double sh[3];

    b.ctx = test_ctx(1, IBL_ISA_AUTO);
    b.stop_at = 10;
    CHECK(ibl_run(b.ctx, NULL, JOBS, count_job, &b) == IBL_ERR_CANCELLED);
    for (int i = 0; i < JOBS; i++)
        CHECK(b.ran[i] == (i <= 10));
    CHECK(ibl_run(b.ctx, NULL, 1, count_job, &b) == IBL_ERR_CANCELLED);
    ibl_image img = map_constant(b.ctx, 16, 8, 1);
    CHECK(ibl_bake_specular(b.ctx, &img, NULL, &cube, NULL) ==
          IBL_ERR_CANCELLED);
    CHECK(ibl_bake_irradiance(b.ctx, &img, NULL, &cube) == IBL_ERR_CANCELLED);
    CHECK(!cube.data);
    CHECK(ibl_bake_sh(b.ctx, &img, 0, 0, sh) == IBL_ERR_CANCELLED);
    CHECK(ibl_bake_lut(b.ctx, NULL, &lut) == IBL_ERR_CANCELLED && !lut.data);
    map_set(&img, 0, 0, 1e9f, 1e9f, 1e9f);
    CHECK(ibl_image_take_lights(b.ctx, &img, 0, 1, &light, &b.stop_at) ==
          IBL_ERR_CANCELLED);
}
