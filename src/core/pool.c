/* SPDX-License-Identifier: MIT */
/*
 * A batch is open from its description until no job is left; workers enter
 * while it is open, and the caller waits for those that did. A worker that
 * arrives after the batch closed (waking an idle core takes longer than a short
 * job) skips it; the caller does not wait. One atomic word holds both the open
 * bit and the number of workers inside, so that no worker enters a batch that
 * is being closed.
 *
 * The task and the begun batches stay open beside the one that is run; workers
 * look at them first.
 *
 * A waiting thread first spins, about as long as it takes to wake a thread, so
 * that waiting costs at most about twice the optimum.
 */
#include "core/pool.h"

#include <assert.h>
#include <pthread.h>
#include <sched.h>
#include <signal.h>
#include <stdatomic.h>
#include <stdint.h>
#include <time.h>

#include "core/alloc.h"

enum {
    SPIN_NS = 50000,
    LOOKS = 64 /* between two looks at the clock */
};

/* The batches: the task, those that were begun, and the one that is run. */
enum {
    TASK, /* of one job */
    BEGUN,
    RUN = BEGUN + IBL_POOL_BEGUN,
    BATCHES
};

/* The word: workers inside, whether the batch is open, how often it was. */
static const uint64_t inside_mask = 0xFFFF, open_bit = 0x10000,
                      turn_unit = 0x20000;

struct worker {
    ibl_pool *pool;
    pthread_t thread;
    int index;
};

/* All but the word is read only by workers that are inside. */
typedef struct batch {
    atomic_uint_fast64_t word;
    ibl_job_fn *fn;
    void *arg;
    int jobs;
    atomic_int next, done;
    atomic_bool stop;
} batch;

struct ibl_pool {
    int threads; /* the caller's included */
    int started; /* workers that have a thread */
    bool spins;
    struct worker *workers;
    batch batches[BATCHES];
    int begun;
    atomic_bool quit;
    pthread_mutex_t lock;
    pthread_cond_t work;  /* a batch is open, or quit */
    pthread_cond_t idle;  /* a closed batch is empty */
    atomic_int sleepers;  /* workers that wait for work */
    atomic_bool sleeping; /* the caller waits for idle */
    /* the task */
    bool has_task;
    ibl_task_fn *task_fn;
    void *task_arg;
};

/* ---- waiting -------------------------------------------------------- */

/* arg: state of the waiting thread. */
typedef bool ready_fn(const ibl_pool *pool, const void *arg);

static bool is_new(uint64_t word, uint64_t seen)
{
    return word & open_bit && word / turn_unit != seen;
}

/* For a worker that has seen these turns of the batches. */
static bool has_work(const ibl_pool *pool, const void *arg)
{
    const uint64_t *seen = arg;
    for (int i = 0; i < BATCHES; i++)
        if (is_new(atomic_load(&pool->batches[i].word), seen[i]))
            return true;
    return atomic_load(&pool->quit);
}

static bool is_empty(const ibl_pool *pool, const void *arg)
{
    const batch *b = arg;
    (void)pool;
    return !(atomic_load(&b->word) & inside_mask);
}

static int64_t nanoseconds(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (int64_t)t.tv_sec * 1000000000 + t.tv_nsec;
}

static void pause_briefly(void)
{
#if defined(__x86_64__)
    __builtin_ia32_pause();
#elif defined(__aarch64__)
    __asm__ volatile("yield");
#endif
}

/* Spins for a while. It yields the core in between: the thread that makes it
 * ready may need it. */
static bool becomes_ready(const ibl_pool *pool, ready_fn *ready,
                          const void *arg)
{
    if (ready(pool, arg))
        return true;
    if (!pool->spins)
        return false;
    const int64_t end = nanoseconds() + SPIN_NS;
    do {
        for (int i = 0; i < LOOKS; i++) {
            pause_briefly();
            if (ready(pool, arg))
                return true;
        }
        sched_yield();
    } while (nanoseconds() < end);
    return false;
}

static void wait_for_work(ibl_pool *pool, const uint64_t seen[BATCHES])
{
    if (becomes_ready(pool, has_work, seen))
        return;
    pthread_mutex_lock(&pool->lock);
    /* Counted before the word is looked at; the caller does it the other way
     * round, so one of the two sees the other. */
    atomic_fetch_add(&pool->sleepers, 1);
    while (!has_work(pool, seen))
        pthread_cond_wait(&pool->work, &pool->lock);
    atomic_fetch_sub(&pool->sleepers, 1);
    pthread_mutex_unlock(&pool->lock);
}

/* The caller, until workers have left a batch. */
static void wait_for_workers(ibl_pool *pool, const batch *b)
{
    if (becomes_ready(pool, is_empty, b))
        return;
    pthread_mutex_lock(&pool->lock);
    atomic_store(&pool->sleeping, true);
    while (!is_empty(pool, b))
        pthread_cond_wait(&pool->idle, &pool->lock);
    atomic_store(&pool->sleeping, false);
    pthread_mutex_unlock(&pool->lock);
}

/* Wakes as many workers as there is work for. */
static void wake(ibl_pool *pool, int wanted)
{
    if (wanted < 1 || !atomic_load(&pool->sleepers))
        return;
    /* Through the lock, so that the counted sleepers are waiting. */
    pthread_mutex_lock(&pool->lock);
    const int sleepers = atomic_load(&pool->sleepers);
    pthread_mutex_unlock(&pool->lock);
    if (wanted >= sleepers)
        pthread_cond_broadcast(&pool->work);
    else
        for (int i = 0; i < wanted; i++)
            pthread_cond_signal(&pool->work);
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

/* Into a batch, if it still is open and was not seen. */
static bool enter(batch *b, uint64_t *seen)
{
    uint_fast64_t word = atomic_load(&b->word);
    do {
        if (!is_new(word, *seen))
            return false;
    } while (!atomic_compare_exchange_weak(&b->word, &word, word + 1));
    *seen = word / turn_unit;
    return true;
}

static void leave(ibl_pool *pool, batch *b)
{
    const uint64_t word = atomic_fetch_sub(&b->word, 1) - 1;
    if (word & (inside_mask | open_bit) || !atomic_load(&pool->sleeping))
        return;
    pthread_mutex_lock(&pool->lock);
    pthread_mutex_unlock(&pool->lock);
    pthread_cond_signal(&pool->idle);
}

static void *worker_main(void *arg)
{
    const struct worker *self = arg;
    ibl_pool *pool = self->pool;
    uint64_t seen[BATCHES] = {0};

    for (;;) {
        wait_for_work(pool, seen);
        if (atomic_load(&pool->quit))
            return NULL;
        for (int i = 0; i < BATCHES; i++) {
            batch *b = &pool->batches[i];
            if (!enter(b, &seen[i]))
                continue;
            while (run_next(b, self->index))
                ;
            leave(pool, b);
        }
    }
}

/* ---- the calls ------------------------------------------------------ */

/* Starts a worker that no signal finds but those of its own faults: what a
 * program's handler interrupts is the program's own thread. */
static int start_worker(struct worker *w)
{
    static const int faults[] = {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGTRAP};
    sigset_t blocked, before;

    sigfillset(&blocked);
    for (size_t i = 0; i < sizeof faults / sizeof faults[0]; i++)
        sigdelset(&blocked, faults[i]);
    pthread_sigmask(SIG_BLOCK, &blocked, &before);
    const int error = pthread_create(&w->thread, NULL, worker_main, w);
    pthread_sigmask(SIG_SETMASK, &before, NULL);
    return error;
}

ibl_pool *ibl_pool_create(int threads, bool spins)
{
    ibl_pool *pool = ibl_alloc_zeroed(1, sizeof *pool);
    if (!pool)
        return NULL;
    pool->threads = threads;
    pool->spins = spins;
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
        if (start_worker(w))
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
    ibl_pool_finish(pool);
    atomic_store(&pool->quit, true);
    wake(pool, pool->started);
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

static void open_batch(batch *b, int jobs, ibl_job_fn *fn, void *arg)
{
    b->fn = fn;
    b->arg = arg;
    b->jobs = jobs;
    atomic_store(&b->next, 0);
    atomic_store(&b->done, 0);
    atomic_store(&b->stop, false);
    atomic_fetch_add(&b->word, turn_unit | open_bit);
}

/* Runs the jobs that are left, until tick stops it. */
static void close_batch(batch *b, ibl_tick_fn *tick, void *tick_arg)
{
    while (run_next(b, 0)) {
        if (tick && !tick(tick_arg, atomic_load(&b->done), b->jobs))
            atomic_store(&b->stop, true);
    }
    atomic_fetch_sub(&b->word, open_bit);
}

bool ibl_pool_run(ibl_pool *pool, int jobs, ibl_job_fn *fn, void *arg,
                  ibl_tick_fn *tick, void *tick_arg)
{
    batch *b = &pool->batches[RUN];
    open_batch(b, jobs, fn, arg);
    wake(pool, jobs - 1 < pool->started ? jobs - 1 : pool->started);
    close_batch(b, tick, tick_arg);
    wait_for_workers(pool, b);
    return !atomic_load(&b->stop);
}

void ibl_pool_begin(ibl_pool *pool, int jobs, ibl_job_fn *fn, void *arg)
{
    assert(pool->begun < IBL_POOL_BEGUN);
    open_batch(&pool->batches[BEGUN + pool->begun++], jobs, fn, arg);
    wake(pool, jobs < pool->started ? jobs : pool->started);
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

static void task_job(void *arg, int job, int worker)
{
    const ibl_pool *pool = arg;
    (void)job;
    (void)worker;
    pool->task_fn(pool->task_arg);
}

bool ibl_pool_start(ibl_pool *pool, ibl_task_fn *fn, void *arg)
{
    if (!pool->started || pool->has_task)
        return false;
    pool->has_task = true;
    pool->task_fn = fn;
    pool->task_arg = arg;
    open_batch(&pool->batches[TASK], 1, task_job, pool);
    wake(pool, 1);
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
