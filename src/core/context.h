/* SPDX-License-Identifier: MIT */
/* Services of a context: messages, jobs, progress, cancelling. */
#ifndef IBL_CORE_CONTEXT_H
#define IBL_CORE_CONTEXT_H

#include <stdbool.h>

#include "core/pool.h"
#include "ibl/ibl.h"

/* Logs an error and returns status, so that `return ibl_fail(...)` reads.
 * Without a context nobody is told. */
ibl_status ibl_fail(ibl_ctx *ctx, ibl_status status, const char *fmt, ...)
    __attribute__((format(printf, 3, 4)));
void ibl_warn(ibl_ctx *ctx, const char *fmt, ...)
    __attribute__((format(printf, 2, 3)));
void ibl_info(ibl_ctx *ctx, const char *fmt, ...)
    __attribute__((format(printf, 2, 3)));
/* ibl_fail for memory that could not be had; what names it. */
ibl_status ibl_no_memory(ibl_ctx *ctx, const char *what);

/* ibl_fail for a pointer that a call needs and was not given; what names them,
 * as "ibl_bake_sh: coeffs". */
ibl_status ibl_missing(ibl_ctx *ctx, const char *what);

bool ibl_cancelled(const ibl_ctx *ctx);

/* Tells the progress callback. */
void ibl_progress(ibl_ctx *ctx, const char *stage, double done);

/* Runs jobs on the context's pool and reports progress under stage (NULL:
 * silently). Jobs should take milliseconds: a cancel waits for those that run.
 * Returns IBL_OK or IBL_ERR_CANCELLED. Never called from a job. */
ibl_status ibl_run(ibl_ctx *ctx, const char *stage, int jobs, ibl_job_fn *fn,
                   void *arg);

/* ibl_pool_begin: until ibl_run_end has returned, arg and the data of the jobs
 * are theirs. ibl_run_end takes part in each, reporting the progress that it
 * was begun with, and returns IBL_OK or IBL_ERR_CANCELLED. */
void ibl_run_begin(ibl_ctx *ctx, const char *stage, double done, int jobs,
                   ibl_job_fn *fn, void *arg);
ibl_status ibl_run_end(ibl_ctx *ctx);

/* ibl_pool_start and ibl_pool_finish. fn logs nothing: messages come from the
 * caller's thread. */
bool ibl_task_start(ibl_ctx *ctx, ibl_task_fn *fn, void *arg);
void ibl_task_finish(ibl_ctx *ctx);

/* Path of the bridge that the context was given, or NULL. */
const char *ibl_ctx_bridge(const ibl_ctx *ctx);

#endif
