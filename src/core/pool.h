/* SPDX-License-Identifier: MIT */
/* A fixed set of threads that run numbered jobs: the library's only threads. */
#ifndef IBL_CORE_POOL_H
#define IBL_CORE_POOL_H

#include <stdbool.h>

typedef struct ibl_pool ibl_pool;

/* Runs one job. worker is 0..threads-1 and differs between concurrent jobs: it
 * can index the caller's scratch memory. */
typedef void ibl_job_fn(void *arg, int job, int worker);
/* Called on the thread of ibl_pool_run after each of its own jobs. Returning
 * false prevents further jobs from starting. */
typedef bool ibl_tick_fn(void *arg, int done, int jobs);

/* NULL: no memory. The thread that calls ibl_pool_run is one of the threads;
 * the others start when there is work and block signals; a system may have
 * fewer. */
ibl_pool *ibl_pool_create(int threads);
void ibl_pool_free(ibl_pool *pool); /* NULL is allowed */

/* Runs jobs 0..jobs-1 in any order; returns when all have ended, false if tick
 * stopped them. tick may be NULL. Costs about 10 us if a thread must be woken,
 * else far less than 1 us. Does not wait for threads that wake too late. */
bool ibl_pool_run(ibl_pool *pool, int jobs, ibl_job_fn *fn, void *arg,
                  ibl_tick_fn *tick, void *tick_arg);

enum {
    IBL_POOL_BEGUN = 20 /* level 0, the sky, the analysis and each level */
};

/* begin lets the threads start jobs while the caller continues; it may also
 * call ibl_pool_run. Up to IBL_POOL_BEGUN batches can be begun. help runs the
 * remaining jobs of batch i, counted from 0 in order of begin (false if tick
 * stopped it). end waits for all. */
void ibl_pool_begin(ibl_pool *pool, int jobs, ibl_job_fn *fn, void *arg);
bool ibl_pool_help(ibl_pool *pool, int i, ibl_tick_fn *tick, void *tick_arg);
void ibl_pool_end(ibl_pool *pool);

/* Gives a thread one job beside the batches. Returns false without effect if
 * there is no other thread or the last one was not finished. */
bool ibl_pool_start(ibl_pool *pool, ibl_job_fn *fn, void *arg);
/* Waits until it has ended, or runs it here if no thread took it. No effect
 * without one. */
void ibl_pool_finish(ibl_pool *pool);

#endif
