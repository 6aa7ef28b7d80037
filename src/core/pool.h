/* SPDX-License-Identifier: MIT */
/*
 * A fixed set of threads that run numbered jobs. Nothing else in the library
 * starts a thread.
 */
#ifndef IBL_CORE_POOL_H
#define IBL_CORE_POOL_H

#include <stdbool.h>

typedef struct ibl_pool ibl_pool;

/* Runs one job. worker is 0..threads-1, no two jobs at once have the same:
 * it indexes scratch that the caller keeps one of for each worker. */
typedef void ibl_job_fn(void *arg, int job, int worker);
/* Called on the thread of ibl_pool_run after each of its own jobs. Returning
 * false keeps jobs from starting that have not. */
typedef bool ibl_tick_fn(void *arg, int done, int jobs);

/* NULL if memory or threads cannot be had. One of the threads is the one that
 * calls ibl_pool_run; the others block signals. spins: the machine has a core
 * for each of them, so that one who waits may look for some microseconds before
 * it sleeps. */
ibl_pool *ibl_pool_create(int threads, bool spins);
void ibl_pool_free(ibl_pool *pool); /* NULL is fine */
int ibl_pool_threads(const ibl_pool *pool);

/*
 * Runs jobs 0..jobs-1 in any order and returns when all have ended. Each job
 * writes only what is its own. tick may be NULL. False if tick stopped it.
 * Costs about 10 us where a thread has to be woken, else far less than 1 us;
 * threads that wake too late for a job are not waited for.
 */
bool ibl_pool_run(ibl_pool *pool, int jobs, ibl_job_fn *fn, void *arg,
                  ibl_tick_fn *tick, void *tick_arg);

enum {
    IBL_POOL_BEGUN = 20 /* level 0, the sky, the analysis, each level */
};

/*
 * Lets the threads begin with jobs while the caller goes on, with runs of the
 * pool for one: up to IBL_POOL_BEGUN times. Then the caller takes its share
 * of each (counted from 0 as they were begun; false if tick stopped it), and
 * waits for the end of all.
 */
void ibl_pool_begin(ibl_pool *pool, int jobs, ibl_job_fn *fn, void *arg);
bool ibl_pool_help(ibl_pool *pool, int i, ibl_tick_fn *tick, void *tick_arg);
void ibl_pool_end(ibl_pool *pool);

/*
 * Gives one of the threads something to do beside batches, which go on without
 * it. False, and nothing happens, if there is no other thread or the last such
 * task was not waited for.
 */
typedef void ibl_task_fn(void *arg);
bool ibl_pool_start(ibl_pool *pool, ibl_task_fn *fn, void *arg);
/* Waits until the task has ended, or does it here if none has begun. Nothing
 * if none was started. */
void ibl_pool_finish(ibl_pool *pool);

#endif
