/* SPDX-License-Identifier: MIT */
/*
 * A batch has work until its last job was taken or it was stopped. Under the
 * lock, workers look for a batch with work and enter it; the caller waits for
 * the workers inside. A worker that arrives after the last job was taken
 * (waking an idle core takes longer than a short job) skips the batch; the
 * caller does not wait.
 *
 * The task and the begun batches exist beside the batch that is run; workers
 * look at them first.
 */
#include "core/pool.h"

#include <assert.h>
#include <pthread.h>
#include <stdatomic.h>

#include "core/alloc.h"
#include "port/port.h"

/* Indices of the batches: the task, the begun ones, and the one being run. */
enum {
    TASK, /* a batch of one job */
    BEGUN,
    RUN = BEGUN + IBL_POOL_BEGUN,
    BATCHES
};

struct worker {
    ibl_pool *pool;
    pthread_t thread;
    int index;
};

typedef struct batch {
    ibl_job_fn *fn;
    void *arg;
    int jobs;
    atomic_int next, done;
    atomic_bool stop;
    int inside; /* workers in the batch; guarded by the lock */
} batch;

struct ibl_pool {
    int threads, started; /* that may be started, and are: the caller's not */
    struct worker *workers;
    int begun;
    pthread_mutex_t lock; /* guards opening of batches and all fields below */
    batch batches[BATCHES];
    bool quit;
    int sleepers;        /* workers waiting for work */
    pthread_cond_t work; /* signalled when a batch opens, or to quit */
    pthread_cond_t idle; /* signalled when the last worker leaves a batch */
    bool has_task;
};

/* Waits until all workers have left a batch. */
static void wait_for_workers(ibl_pool *pool, const batch *b)
{
    pthread_mutex_lock(&pool->lock);
    while (b->inside)
        pthread_cond_wait(&pool->idle, &pool->lock);
    pthread_mutex_unlock(&pool->lock);
}

/* ---- working -------------------------------------------------------- */

static bool run_next(batch *b, int worker)
{
    if (atomic_load(&b->stop))
        return false;
    const int job = atomic_fetch_add(&b->next, 1);
    if (job >= b->jobs)
        return false;
    b->fn(b->arg, job, worker);
    atomic_fetch_add(&b->done, 1);
    return true;
}

/* Enters the first batch with work; NULL: none has any. The caller holds the
 * lock. A worker counts as inside before it looks for work: once a batch has
 * none and nobody is inside, nobody enters it any more. */
static batch *enter_batch(ibl_pool *pool)
{
    for (batch *b = pool->batches; b < pool->batches + BATCHES; b++) {
        b->inside++;
        if (atomic_load(&b->next) < b->jobs && !atomic_load(&b->stop))
            return b;
        b->inside--;
    }
    return NULL;
}

static void *worker_main(void *arg)
{
    const struct worker *self = arg;
    ibl_pool *pool = self->pool;

    pthread_mutex_lock(&pool->lock);
    while (!pool->quit) {
        batch *b = enter_batch(pool);
        if (!b) {
            pool->sleepers++;
            pthread_cond_wait(&pool->work, &pool->lock);
            pool->sleepers--;
            continue;
        }
        pthread_mutex_unlock(&pool->lock);
        while (run_next(b, self->index))
            ;
        pthread_mutex_lock(&pool->lock);
        if (--b->inside == 0)
            pthread_cond_signal(&pool->idle);
    }
    pthread_mutex_unlock(&pool->lock);
    return NULL;
}

/* ---- the calls ------------------------------------------------------ */

ibl_pool *ibl_pool_create(int threads)
{
    ibl_pool *pool = ibl_alloc_zeroed(1, sizeof *pool);
    if (!pool)
        return NULL;
    pthread_mutex_init(&pool->lock, NULL);
    pthread_cond_init(&pool->work, NULL);
    pthread_cond_init(&pool->idle, NULL);
    pool->workers = ibl_alloc_zeroed((size_t)threads, sizeof *pool->workers);
    if (!pool->workers) {
        ibl_pool_free(pool);
        return NULL;
    }
    pool->threads = threads - 1;
    return pool;
}

void ibl_pool_free(ibl_pool *pool)
{
    if (!pool)
        return;
    ibl_pool_finish(pool);
    pthread_mutex_lock(&pool->lock);
    pool->quit = true;
    pthread_mutex_unlock(&pool->lock);
    pthread_cond_broadcast(&pool->work);
    for (int i = 0; i < pool->started; i++)
        pthread_join(pool->workers[i].thread, NULL);
    pthread_cond_destroy(&pool->idle);
    pthread_cond_destroy(&pool->work);
    pthread_mutex_destroy(&pool->lock);
    ibl_free(pool->workers);
    ibl_free(pool);
}

/* Opens a batch; wakes up to `wanted` workers, and starts those that lack. */
static void open_batch(ibl_pool *pool, int which, int jobs, int wanted,
                       ibl_job_fn *fn, void *arg)
{
    batch *b = &pool->batches[which];
    while (pool->started < pool->threads && pool->started < wanted) {
        struct worker *w = &pool->workers[pool->started];
        *w = (struct worker){.pool = pool, .index = pool->started + 1};
        ibl_port_hold_signals(true); /* it takes none */
        if (pthread_create(&w->thread, NULL, worker_main, w))
            pool->threads = pool->started;
        else
            pool->started++;
        ibl_port_hold_signals(false);
    }
    pthread_mutex_lock(&pool->lock);
    b->fn = fn;
    b->arg = arg;
    b->jobs = jobs;
    atomic_store(&b->next, 0);
    atomic_store(&b->done, 0);
    atomic_store(&b->stop, false);
    if (wanted > pool->sleepers)
        wanted = pool->sleepers;
    pthread_mutex_unlock(&pool->lock);
    for (int i = 0; i < wanted; i++)
        pthread_cond_signal(&pool->work);
}

/* Runs the remaining jobs on the calling thread, until tick stops the batch. */
static void close_batch(batch *b, ibl_tick_fn *tick, void *tick_arg)
{
    while (run_next(b, 0)) {
        if (tick && !tick(tick_arg, atomic_load(&b->done), b->jobs))
            atomic_store(&b->stop, true);
    }
}

bool ibl_pool_run(ibl_pool *pool, int jobs, ibl_job_fn *fn, void *arg,
                  ibl_tick_fn *tick, void *tick_arg)
{
    batch *b = &pool->batches[RUN];
    open_batch(pool, RUN, jobs, jobs - 1, fn, arg);
    close_batch(b, tick, tick_arg);
    wait_for_workers(pool, b);
    return !atomic_load(&b->stop);
}

void ibl_pool_begin(ibl_pool *pool, int jobs, ibl_job_fn *fn, void *arg)
{
    assert(pool->begun < IBL_POOL_BEGUN);
    open_batch(pool, BEGUN + pool->begun++, jobs, jobs, fn, arg);
}

bool ibl_pool_help(ibl_pool *pool, int i, ibl_tick_fn *tick, void *tick_arg)
{
    batch *b = &pool->batches[BEGUN + i];
    close_batch(b, tick, tick_arg);
    return !atomic_load(&b->stop);
}

void ibl_pool_end(ibl_pool *pool)
{
    for (int i = 0; i < pool->begun; i++)
        wait_for_workers(pool, &pool->batches[BEGUN + i]);
    pool->begun = 0;
}

bool ibl_pool_start(ibl_pool *pool, ibl_job_fn *fn, void *arg)
{
    if (!pool->threads || pool->has_task)
        return false;
    pool->has_task = true;
    open_batch(pool, TASK, 1, 1, fn, arg);
    return true;
}

void ibl_pool_finish(ibl_pool *pool)
{
    if (!pool->has_task)
        return;
    close_batch(&pool->batches[TASK], NULL, NULL);
    wait_for_workers(pool, &pool->batches[TASK]);
    pool->has_task = false;
}
