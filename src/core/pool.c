/* SPDX-License-Identifier: MIT */
#include "core/pool.h"

#include <pthread.h>
#include <stdatomic.h>

#include "core/alloc.h"

struct worker {
    ibl_pool *pool;
    pthread_t thread;
    int index;
};

struct ibl_pool {
    int threads; /* the caller's included */
    int started; /* workers that have a thread */
    struct worker *workers;
    pthread_mutex_t lock;
    pthread_cond_t work; /* a batch has begun, or quit */
    pthread_cond_t idle; /* the last worker of a batch is out of it */
    unsigned long batch; /* counts batches */
    int busy;            /* workers inside the batch */
    bool quit;
    /* the batch */
    ibl_job_fn *fn;
    void *arg;
    int jobs;
    atomic_int next, done;
    atomic_bool stop;
};

static bool run_next(ibl_pool *pool, int worker)
{
    if (atomic_load(&pool->stop))
        return false;
    const int job = atomic_fetch_add(&pool->next, 1);
    if (job >= pool->jobs)
        return false;
    pool->fn(pool->arg, job, worker);
    atomic_fetch_add(&pool->done, 1);
    return true;
}

static void *worker_main(void *arg)
{
    const struct worker *self = arg;
    ibl_pool *pool = self->pool;
    unsigned long seen = 0;

    pthread_mutex_lock(&pool->lock);
    for (;;) {
        while (!pool->quit && pool->batch == seen)
            pthread_cond_wait(&pool->work, &pool->lock);
        if (pool->quit)
            break;
        seen = pool->batch;
        pthread_mutex_unlock(&pool->lock);
        while (run_next(pool, self->index))
            ;
        pthread_mutex_lock(&pool->lock);
        if (!--pool->busy)
            pthread_cond_signal(&pool->idle);
    }
    pthread_mutex_unlock(&pool->lock);
    return NULL;
}

ibl_pool *ibl_pool_create(int threads)
{
    ibl_pool *pool = ibl_alloc_zeroed(1, sizeof *pool);
    if (!pool)
        return NULL;
    pool->threads = threads;
    pthread_mutex_init(&pool->lock, NULL);
    pthread_cond_init(&pool->work, NULL);
    pthread_cond_init(&pool->idle, NULL);
    pool->workers = ibl_alloc_zeroed((size_t)threads, sizeof *pool->workers);
    if (!pool->workers)
        goto fail;
    for (int i = 1; i < threads; i++) {
        struct worker *w = &pool->workers[pool->started];
        w->pool = pool;
        w->index = i;
        if (pthread_create(&w->thread, NULL, worker_main, w))
            goto fail;
        pool->started++;
    }
    return pool;
fail:
    ibl_pool_free(pool);
    return NULL;
}

void ibl_pool_free(ibl_pool *pool)
{
    if (!pool)
        return;
    pthread_mutex_lock(&pool->lock);
    pool->quit = true;
    pthread_cond_broadcast(&pool->work);
    pthread_mutex_unlock(&pool->lock);
    for (int i = 0; i < pool->started; i++)
        pthread_join(pool->workers[i].thread, NULL);
    pthread_cond_destroy(&pool->idle);
    pthread_cond_destroy(&pool->work);
    pthread_mutex_destroy(&pool->lock);
    ibl_free(pool->workers);
    ibl_free(pool);
}

int ibl_pool_threads(const ibl_pool *pool)
{
    return pool->threads;
}

bool ibl_pool_run(ibl_pool *pool, int jobs, ibl_job_fn *fn, void *arg,
                  ibl_tick_fn *tick, void *tick_arg)
{
    pthread_mutex_lock(&pool->lock);
    pool->fn = fn;
    pool->arg = arg;
    pool->jobs = jobs;
    atomic_store(&pool->next, 0);
    atomic_store(&pool->done, 0);
    atomic_store(&pool->stop, false);
    pool->busy = pool->started;
    pool->batch++;
    pthread_cond_broadcast(&pool->work);
    pthread_mutex_unlock(&pool->lock);

    while (run_next(pool, 0)) {
        if (tick && !tick(tick_arg, atomic_load(&pool->done), jobs))
            atomic_store(&pool->stop, true);
    }

    pthread_mutex_lock(&pool->lock);
    while (pool->busy)
        pthread_cond_wait(&pool->idle, &pool->lock);
    pthread_mutex_unlock(&pool->lock);
    return !atomic_load(&pool->stop);
}
