/* SPDX-License-Identifier: MIT */
/* Services of a context: messages, jobs, progress, cancelling. */
#ifndef IBL_CORE_CONTEXT_H
#define IBL_CORE_CONTEXT_H

#include <stdbool.h>

#include "core/pool.h"
#include "ibl/ibl.h"

/* Logs an error and returns status, for `return ibl_fail(...)`. Does not log
 * without a context. */
ibl_status ibl_fail(ibl_ctx *ctx, ibl_status status, const char *fmt, ...)
    __attribute__((format(printf, 3, 4)));
void ibl_warn(ibl_ctx *ctx, const char *fmt, ...)
    __attribute__((format(printf, 2, 3)));
void ibl_info(ibl_ctx *ctx, const char *fmt, ...)
    __attribute__((format(printf, 2, 3)));
/* ibl_fail for a failed allocation; what names the memory. */
ibl_status ibl_no_memory(ibl_ctx *ctx, const char *what);

/* ibl_fail for a required pointer that is NULL; what names call and pointer, as
 * in "ibl_bake_sh: coeffs". */
ibl_status ibl_missing(ibl_ctx *ctx, const char *what);

bool ibl_cancelled(const ibl_ctx *ctx);

/* The context's limit; SIZE_MAX: none. */
size_t ibl_ctx_memory(const ibl_ctx *ctx);

/* Calls the progress callback. */
void ibl_progress(ibl_ctx *ctx, const char *stage, double done);

/* Begins what the callback gets as a whole: stages that begin with these names
 * share the whole by their weights; others do not count. */
enum {
    IBL_SHARES = 6
};
typedef struct ibl_share {
    const char *stage;
    double weight; /* 0: does not run */
} ibl_share;
void ibl_progress_begin(ibl_ctx *ctx, const ibl_share shares[IBL_SHARES]);
/* Until the next call stages whose names end in a number, 1 to last, are a part
 * of such stages, from..to of them. */
void ibl_progress_numbered(ibl_ctx *ctx, int last, double from, double to);
/* Reports that all is done, or, not ok, only ends it. */
void ibl_progress_end(ibl_ctx *ctx, bool ok);

/* Runs jobs on the context's pool and reports progress under stage (NULL:
 * silently). Jobs should take milliseconds, since cancelling waits for running
 * jobs. Returns IBL_OK or IBL_ERR_CANCELLED. A job must not call it. */
ibl_status ibl_run(ibl_ctx *ctx, const char *stage, int jobs, ibl_job_fn *fn,
                   void *arg);

/* ibl_pool_begin and ibl_pool_end. arg and the jobs' data must stay valid until
 * ibl_run_end has returned. ibl_run_end helps with each batch, reports the
 * progress given at its begin, and returns IBL_OK or IBL_ERR_CANCELLED. */
void ibl_run_begin(ibl_ctx *ctx, const char *stage, double done, int jobs,
                   ibl_job_fn *fn, void *arg);
ibl_status ibl_run_end(ibl_ctx *ctx);

/* ibl_pool_start and ibl_pool_finish. fn must not log: messages come from the
 * caller's thread. */
bool ibl_task_start(ibl_ctx *ctx, ibl_job_fn *fn, void *arg);
void ibl_task_finish(ibl_ctx *ctx);

/* The bridge's path from the context's options, or NULL. */
const char *ibl_ctx_bridge(const ibl_ctx *ctx);

#endif
