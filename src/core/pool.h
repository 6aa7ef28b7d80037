/* SPDX-License-Identifier: MIT */
/*
 * A fixed set of threads that run numbered jobs. Nothing else in the library
 * starts a thread.
 */
#ifndef IBL_CORE_POOL_H
#define IBL_CORE_POOL_H

#include <stdbool.h>

typedef struct ibl_pool ibl_pool;

/* Runs one job. worker is 0..threads-1; no two concurrent jobs have the same,
 * so it indexes scratch of which the caller keeps one for each worker. */
typedef void ibl_job_fn(void *arg, int job, int worker);
/* Called on the thread of ibl_pool_run after each of its own jobs. False: no
 * further jobs start. */
typedef bool ibl_tick_fn(void *arg, int done, int jobs);

/* NULL if memory or threads are missing. One of the threads is the caller of
 * ibl_pool_run; the others block signals. spins: the machine has a core for
 * each, so that a waiting thread spins for some microseconds before it
 * sleeps. */
ibl_pool *ibl_pool_create(int threads, bool spins);
void ibl_pool_free(ibl_pool *pool); /* NULL is fine */
int ibl_pool_threads(const ibl_pool *pool);

/* Runs jobs 0..jobs-1 in any order and returns when all have ended. tick may be
 * NULL. False if tick stopped it. Costs about 10 us if a thread must be woken,
 * else far less than 1 us; threads that wake too late are not waited for. */
bool ibl_pool_run(ibl_pool *pool, int jobs, ibl_job_fn *fn, void *arg,
                  ibl_tick_fn *tick, void *tick_arg);

enum {
    IBL_POOL_BEGUN = 20 /* level 0, the sky, the analysis, each level */
};

/* begin, up to IBL_POOL_BEGUN times, lets the threads start jobs while the
 * caller continues, also with ibl_pool_run. help runs the rest of batch i, from
 * 0 as they were begun (false if tick stopped it); end waits for all. */
void ibl_pool_begin(ibl_pool *pool, int jobs, ibl_job_fn *fn, void *arg);
bool ibl_pool_help(ibl_pool *pool, int i, ibl_tick_fn *tick, void *tick_arg);
void ibl_pool_end(ibl_pool *pool);

/* Gives one of the threads a task beside the batches. False, and nothing
 * happens, if there is no other thread or the last task was not waited for. */
typedef void ibl_task_fn(void *arg);
bool ibl_pool_start(ibl_pool *pool, ibl_task_fn *fn, void *arg);
/* Waits until the task has ended, or runs it here if no thread took it. Nothing
 * if none was started. */
void ibl_pool_finish(ibl_pool *pool);

#endif
