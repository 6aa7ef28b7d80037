/* SPDX-License-Identifier: MIT */
/* The maps of a run: each environment, original and resampled. */
#define _DEFAULT_SOURCE /* MAP_ANONYMOUS */
#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/wait.h>

#include "cli/bench.h"
#include "cli/child.h"
#include "cli/console.h"
#include "cli/resample.h"
#include "json/text.h"

enum {
    LARGEST = 8192, /* largest default width */
    MOST = IBL_BENCH_NAMED * (IBL_BENCH_VALUES + 1)
};

/* The child's work, in memory shared with this process. */
typedef struct job {
    ibl_bench *b;
    int env; /* index of the current environment */
    int count;
    ibl_bench_source sources[MOST]; /* paths are not filled in */
} job;

static bool no_memory(const ibl_bench *b)
{
    return ibl_console_fail(b->console, "no memory for the list of maps");
}

static char *source_path(const ibl_bench *b, const ibl_bench_source *s)
{
    if (s->resampled)
        return ibl_format("%s/source-%d-%d.hdr", b->directory, s->env,
                          s->width);
    /* The "./" keeps a command from taking the name for an option. */
    return ibl_format("%s%s", *b->opts->envs[s->env] == '-' ? "./" : "",
                      b->opts->envs[s->env]);
}

static bool write_source(const ibl_bench *b, const ibl_image *image,
                         const ibl_bench_source *s)
{
    char *path = source_path(b, s);
    FILE *to = path ? fopen(path, "wb") : NULL;
    int why = to ? ibl_resample_write(image, s->width, s->height, to) : errno;

    if (to && fclose(to) && !why)
        why = errno;
    if (why)
        ibl_console_fail(b->console, "%s: cannot be written: %s",
                         path ? path : b->directory, strerror(why));
    free(path);
    return !why;
}

/* Widths to resample an image to. */
static ibl_bench_list widths(const ibl_bench *b, const ibl_image *image)
{
    ibl_bench_list list = b->opts->lists[IBL_BENCH_SOURCE];
    const int halves[] = {image->width / 2, image->width, 2 * image->width,
                          4 * image->width};

    if (list.count == 1 && !list.values[0])
        list.count = 0;
    else if (!list.count)
        for (int i = 0; i < 4; i++)
            if (halves[i] >= 2 && halves[i] <= LARGEST)
                list.values[list.count++] = halves[i];
    return list;
}

static bool resample(job *j, const ibl_image *image)
{
    const ibl_bench_list list = widths(j->b, image);
    const double ratio = (double)image->height / image->width;
    bool ok = true;

    j->sources[j->count++] = (ibl_bench_source){
        .env = j->env, .width = image->width, .height = image->height};
    for (int i = 0; i < list.count && ok; i++) {
        ibl_bench_source *s = &j->sources[j->count++];
        const double height = list.values[i] * ratio + 0.5;
        *s = (ibl_bench_source){.env = j->env,
                                .width = list.values[i],
                                .height = height < 1 ? 1 : (int)height,
                                .resampled = true};
        ok = write_source(j->b, image, s);
    }
    return ok;
}

/* Runs in the child: reads the environments and writes the resampled maps. */
static bool make(void *cookie)
{
    job *j = cookie;
    const ibl_bench_opts *opts = j->b->opts;
    ibl_common common = opts->common;
    ibl_ctx *ctx = NULL;

    common.threads = 1;
    bool ok = !ibl_start(&common, j->b->console, &ctx);
    for (; j->env < opts->env_count && ok; j->env++) {
        ibl_image image = {0};
        ibl_console_progress(j->b->console, "resample",
                             (double)j->env / opts->env_count);
        ok = !ibl_image_read(ctx, opts->envs[j->env], &common.read, &image,
                             NULL);
        if (!ok)
            ibl_console_fail(j->b->console, "%s: cannot be read",
                             opts->envs[j->env]);
        ok = ok && resample(j, &image);
        ibl_image_free(&image);
    }
    ibl_ctx_free(ctx);
    return ok;
}

/* b->sources stays in the memory shared with the child. */
bool ibl_bench_sources_make(ibl_bench *b)
{
    job *j = mmap(NULL, sizeof *j, PROT_READ | PROT_WRITE,
                  MAP_SHARED | MAP_ANONYMOUS, -1, 0);

    if (j == MAP_FAILED)
        return no_memory(b);
    *j = (job){.b = b};
    const int status = ibl_child_call(make, j);
    if (status == -1)
        return ibl_console_fail(b->console, "no process can be made: %s",
                                strerror(errno));
    if (WIFSIGNALED(status))
        return ibl_console_fail(b->console, "%s: reading it ended by signal %d",
                                b->opts->envs[j->env], WTERMSIG(status));
    b->sources = j->sources;
    for (; !status && b->source_count < j->count; b->source_count++) {
        ibl_bench_source *s = &b->sources[b->source_count];
        s->path = source_path(b, s);
        if (!s->path)
            return no_memory(b);
    }
    return !status;
}
