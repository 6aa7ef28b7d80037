/* SPDX-License-Identifier: MIT */
#include "core/context.h"

#include <math.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "core/alloc.h"
#include "core/cpu.h"

enum {
    MAX_THREADS = 1024,
    MESSAGE_BYTES = 2 * 4096 + 1024 /* for two paths and some words */
};

/* Progress of a begun batch; ibl_run_end reports it. */
struct begun {
    const char *stage;
    double done;
};

struct ibl_ctx {
    ibl_pool *pool;
    struct begun begun[IBL_POOL_BEGUN];
    int begun_count;
    ibl_ctx_options opts; /* isa and threads in use; bridge is not used */
    char *bridge;
    atomic_bool cancel;

    char stage[32]; /* the last of the running bake */
    ibl_share shares[IBL_SHARES];
    double reached[IBL_SHARES]; /* of each, 0..1 */
    int last;                   /* number of numbered stages */
    double from, to;            /* what they are of such stages */
    double whole;               /* -1: of no bake */
};

const char *ibl_version(void)
{
    return IBL_VERSION;
}

const char *ibl_status_text(ibl_status status)
{
    static const char *const texts[] = {
        "success",
        "argument out of range",
        "out of memory",
        "input/output error",
        "bad or damaged file",
        "not supported",
        "cancelled",
    };
    return (unsigned)status <= IBL_ERR_CANCELLED ? texts[status]
                                                 : "unknown status";
}

ibl_ctx_options ibl_ctx_options_default(void)
{
    return (ibl_ctx_options){.isa = IBL_ISA_AUTO};
}

ibl_status ibl_ctx_create(const ibl_ctx_options *opts, ibl_ctx **out)
{
    const ibl_ctx_options usual = ibl_ctx_options_default();
    if (!opts)
        opts = &usual;
    ibl_ctx early = {.opts = *opts}; /* logs until the context exists */

    if (!out)
        return ibl_missing(&early, "ibl_ctx_create: ctx");
    *out = NULL;
    if (opts->threads < 0 || opts->threads > MAX_THREADS)
        return ibl_fail(&early, IBL_ERR_ARGUMENT,
                        "%d threads: must be 1 to %d, or 0", opts->threads,
                        MAX_THREADS);
    if ((unsigned)opts->isa >= IBL_ISA_COUNT)
        return ibl_fail(&early, IBL_ERR_ARGUMENT,
                        "instruction set %d: must be %d to %d", (int)opts->isa,
                        IBL_ISA_AUTO, IBL_ISA_COUNT - 1);
    const ibl_isa isa = opts->isa == IBL_ISA_AUTO ? ibl_isa_best() : opts->isa;
    if (!ibl_isa_supported(isa))
        return ibl_fail(&early, IBL_ERR_UNSUPPORTED,
                        "this CPU has no %s; the best it has is %s",
                        ibl_isa_name(isa), ibl_isa_name(ibl_isa_best()));
    const int threads = opts->threads ? opts->threads : ibl_cpu_count();

    ibl_alloc_hold();
    ibl_ctx *ctx = ibl_alloc_zeroed(1, sizeof *ctx);
    if (!ctx) {
        ibl_alloc_release();
        return ibl_fail(&early, IBL_ERR_MEMORY, "no memory for a context");
    }
    ctx->opts = *opts;
    ctx->opts.isa = isa;
    ctx->opts.threads = threads;
    ctx->whole = -1;
    if (opts->bridge) {
        const size_t bytes = strlen(opts->bridge) + 1;
        ctx->bridge = ibl_alloc_array(bytes, 1);
        if (!ctx->bridge)
            goto no_memory;
        memcpy(ctx->bridge, opts->bridge, bytes);
    }
    ctx->pool = ibl_pool_create(threads);
    if (!ctx->pool)
        goto no_memory;
    *out = ctx;
    return IBL_OK;

no_memory:
    ibl_ctx_free(ctx);
    return ibl_fail(&early, IBL_ERR_MEMORY,
                    "no memory for a context of %d threads: ask for fewer",
                    threads);
}

void ibl_ctx_free(ibl_ctx *ctx)
{
    if (!ctx)
        return;
    ibl_pool_free(ctx->pool);
    ibl_free(ctx->bridge);
    ibl_free(ctx);
    ibl_alloc_release();
}

int ibl_ctx_threads(const ibl_ctx *ctx)
{
    return ctx->opts.threads;
}

ibl_isa ibl_ctx_isa(const ibl_ctx *ctx)
{
    return ctx->opts.isa;
}

const char *ibl_ctx_bridge(const ibl_ctx *ctx)
{
    return ctx->bridge;
}

size_t ibl_ctx_memory(const ibl_ctx *ctx)
{
    return ctx && ctx->opts.memory ? ctx->opts.memory : SIZE_MAX;
}

void ibl_ctx_cancel(ibl_ctx *ctx)
{
    atomic_store(&ctx->cancel, true);
}

bool ibl_cancelled(const ibl_ctx *ctx)
{
    return atomic_load(&ctx->cancel);
}

static void say(ibl_ctx *ctx, ibl_log_level level, const char *fmt, va_list ap)
{
    char text[MESSAGE_BYTES];
    if (!ctx || !ctx->opts.log)
        return;
    vsnprintf(text, sizeof text, fmt, ap);
    /* Names of files and what files say may have newlines. */
    for (char *c = text; *c; c++)
        if ((unsigned char)*c < ' ' || *c == 0x7f)
            *c = '?';
    ctx->opts.log(ctx->opts.log_cookie, level, text);
}

ibl_status ibl_fail(ibl_ctx *ctx, ibl_status status, const char *fmt, ...)
{
    va_list ap;
    va_start(ap, fmt);
    say(ctx, IBL_LOG_ERROR, fmt, ap);
    va_end(ap);
    return status;
}

void ibl_warn(ibl_ctx *ctx, const char *fmt, ...)
{
    va_list ap;
    va_start(ap, fmt);
    say(ctx, IBL_LOG_WARNING, fmt, ap);
    va_end(ap);
}

void ibl_info(ibl_ctx *ctx, const char *fmt, ...)
{
    va_list ap;
    va_start(ap, fmt);
    say(ctx, IBL_LOG_INFO, fmt, ap);
    va_end(ap);
}

ibl_status ibl_no_memory(ibl_ctx *ctx, const char *what)
{
    return ibl_fail(ctx, IBL_ERR_MEMORY,
                    "no memory for %s: ask for less, or free some", what);
}

ibl_status ibl_missing(ibl_ctx *ctx, const char *what)
{
    return ibl_fail(ctx, IBL_ERR_ARGUMENT, "%s is NULL: must be given", what);
}

void ibl_progress_begin(ibl_ctx *ctx, const ibl_share shares[IBL_SHARES])
{
    memcpy(ctx->shares, shares, sizeof ctx->shares);
    memset(ctx->reached, 0, sizeof ctx->reached);
    ctx->last = 0;
    *ctx->stage = '\0';
    ctx->whole = 0;
}

void ibl_progress_numbered(ibl_ctx *ctx, int last, double from, double to)
{
    ctx->last = last;
    ctx->from = from;
    ctx->to = to;
}

void ibl_progress_end(ibl_ctx *ctx, bool ok)
{
    if (ok && *ctx->stage && ctx->opts.progress)
        ctx->opts.progress(ctx->opts.progress_cookie, ctx->stage, 1, 1);
    ctx->whole = -1;
}

/* Stages run side by side, some twice: each counts as far as it has come. */
static void note_whole(ibl_ctx *ctx, const char *stage, double done)
{
    const int number = atoi(stage + strcspn(stage, "0123456789"));
    double whole = 0, all = 0;

    if (number && ctx->last)
        done =
            ctx->from + (ctx->to - ctx->from) * (number - 1 + done) / ctx->last;
    for (int i = 0; i < IBL_SHARES; i++) {
        const ibl_share *s = &ctx->shares[i];
        if (!s->stage)
            continue;
        if (!strncmp(stage, s->stage, strlen(s->stage)))
            ctx->reached[i] = fmax(ctx->reached[i], fmin(done, 1));
        whole += s->weight * ctx->reached[i];
        all += s->weight;
    }
    snprintf(ctx->stage, sizeof ctx->stage, "%s", stage);
    if (all > 0)
        ctx->whole = fmax(ctx->whole, whole / all);
}

void ibl_progress(ibl_ctx *ctx, const char *stage, double done)
{
    if (!ctx->opts.progress)
        return;
    if (ctx->whole >= 0)
        note_whole(ctx, stage, done);
    ctx->opts.progress(ctx->opts.progress_cookie, stage, done, ctx->whole);
}

struct tick {
    ibl_ctx *ctx;
    const char *stage;
};

static bool tick(void *arg, int done, int jobs)
{
    const struct tick *t = arg;
    if (t->stage && done < jobs)
        ibl_progress(t->ctx, t->stage, (double)done / jobs);
    return !ibl_cancelled(t->ctx);
}

ibl_status ibl_run(ibl_ctx *ctx, const char *stage, int jobs, ibl_job_fn *fn,
                   void *arg)
{
    struct tick t = {ctx, stage};
    if (ibl_cancelled(ctx))
        return IBL_ERR_CANCELLED;
    if (stage)
        ibl_progress(ctx, stage, 0);
    if (!ibl_pool_run(ctx->pool, jobs, fn, arg, tick, &t))
        return IBL_ERR_CANCELLED;
    if (stage)
        ibl_progress(ctx, stage, 1);
    return IBL_OK;
}

void ibl_run_begin(ibl_ctx *ctx, const char *stage, double done, int jobs,
                   ibl_job_fn *fn, void *arg)
{
    ctx->begun[ctx->begun_count++] = (struct begun){stage, done};
    ibl_pool_begin(ctx->pool, jobs, fn, arg);
}

ibl_status ibl_run_end(ibl_ctx *ctx)
{
    struct tick t = {ctx, NULL};
    bool whole = true;
    for (int i = 0; i < ctx->begun_count; i++) {
        ibl_progress(ctx, ctx->begun[i].stage, ctx->begun[i].done);
        whole &= ibl_pool_help(ctx->pool, i, tick, &t);
    }
    ibl_pool_end(ctx->pool);
    ctx->begun_count = 0;
    return whole && !ibl_cancelled(ctx) ? IBL_OK : IBL_ERR_CANCELLED;
}

bool ibl_task_start(ibl_ctx *ctx, ibl_job_fn *fn, void *arg)
{
    return ibl_pool_start(ctx->pool, fn, arg);
}

void ibl_task_finish(ibl_ctx *ctx)
{
    ibl_pool_finish(ctx->pool);
}
