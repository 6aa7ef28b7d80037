/* SPDX-License-Identifier: MIT */
/* Bakes on a thread with its own context while the window keeps drawing. `lock`
 * guards the data that the thread and its caller share. */
#include <math.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/path.h"
#include "common/signals.h"
#include "view/baked_set.h"
#include "view/message.h"

enum {
    STAGE_BYTES = 64
};

struct view_baker {
    char *path;
    view_request what;
    ibl_ctx *ctx;
    pthread_t thread;
    baked_set set; /* belongs to the thread until it is joined */
    bool ok;       /* the same */

    pthread_mutex_t lock;
    char stage[STAGE_BYTES];
    double whole; /* the finished share */
    bool ended;
    char message[1024]; /* the error */
};

/* ---- progress -------------------------------------------------------- */

static void on_progress(void *cookie, const char *stage, double done,
                        double whole)
{
    view_baker *b = cookie;

    (void)done;
    pthread_mutex_lock(&b->lock);
    snprintf(b->stage, sizeof b->stage, "%s", stage);
    b->whole = fmax(b->whole, whole);
    pthread_mutex_unlock(&b->lock);
}

/* The caller prints an error when it takes the set; warnings appear at once. */
static void on_log(void *cookie, ibl_log_level level, const char *text)
{
    view_baker *b = cookie;

    if (level == IBL_LOG_WARNING)
        view_note("%s", text);
    if (level != IBL_LOG_ERROR)
        return;
    pthread_mutex_lock(&b->lock);
    snprintf(b->message, sizeof b->message, "%s", text);
    pthread_mutex_unlock(&b->lock);
}

bool view_baker_poll(view_baker *baker, char *stage, double *done)
{
    pthread_mutex_lock(&baker->lock);
    const bool ended = baker->ended;
    memcpy(stage, baker->stage, sizeof baker->stage);
    *done = ended ? 1 : baker->whole;
    pthread_mutex_unlock(&baker->lock);
    return ended;
}

/* ---- the thread ------------------------------------------------------ */

static void *run(void *cookie)
{
    view_baker *b = cookie;

    b->ok = view_set_bake(b->ctx, &b->what, &b->set);
    pthread_mutex_lock(&b->lock);
    b->ended = true;
    pthread_mutex_unlock(&b->lock);
    return NULL;
}

static void baker_free(view_baker *b)
{
    ibl_ctx_free(b->ctx);
    pthread_mutex_destroy(&b->lock);
    free(b->path);
    free(b);
}

view_baker *view_baker_start(const view_request *what)
{
    const char *path = what->path;
    ibl_ctx_options opts = ibl_ctx_options_default();
    view_baker *b = ibl_need(calloc(1, sizeof *b));

    pthread_mutex_init(&b->lock, NULL);
    opts.log = on_log;
    opts.memory = ibl_memory_allowed() / 4 * 3;
    opts.log_cookie = b;
    opts.progress = on_progress;
    opts.progress_cookie = b;
    opts.bridge = ibl_bridge_beside();
    b->path = ibl_need(strdup(path));
    b->what = *what;
    b->what.path = b->path;
    if (ibl_ctx_create(&opts, &b->ctx) ||
        pthread_create(&b->thread, NULL, run, b)) {
        view_fail("%s: no memory or no threads to bake it", path);
        baker_free(b);
        return NULL;
    }
    return b;
}

bool view_baker_finish(view_baker *baker, baked_set *set)
{
    if (!set)
        ibl_ctx_cancel(baker->ctx);
    pthread_join(baker->thread, NULL);
    const bool ok = set && baker->ok;
    if (set)
        *set = baker->set;
    else
        view_set_free(&baker->set);
    if (set && !ok && *baker->message)
        view_fail("%s", baker->message);
    baker_free(baker);
    return ok;
}
