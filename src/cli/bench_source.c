/* SPDX-License-Identifier: MIT */
/* The maps of a run: the environments, and each resampled. */
#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include "cli/bench.h"
#include "cli/resample.h"
#include "cli/signals.h"
#include "cli/session.h"

enum {
    LARGEST = 8192 /* width that nobody asked for by a list */
};

/* What the child tells of one map. */
typedef struct found {
    int width, height;
} found;

static char *source_path(const ibl_bench *b, int env, int width)
{
    const size_t size = strlen(b->directory) + 48;
    char *path = malloc(size);

    if (path)
        snprintf(path, size, "%s/source-%d-%d.hdr", b->directory, env, width);
    return path;
}

static bool write_source(const ibl_bench *b, int env, const ibl_image *image,
                         found f)
{
    char *path = source_path(b, env, f.width);
    FILE *to = path ? fopen(path, "wb") : NULL;
    int why = to ? ibl_resample_write(image, f.width, f.height, to) : errno;

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

/* In the child: reads an environment, writes what it is resampled to, tells
 * the sizes: of the file, then of each. */
static bool make(const ibl_bench *b, int env, int report)
{
    found f[IBL_BENCH_VALUES + 1];
    ibl_common common = b->opts->common;
    ibl_image image = {0};
    ibl_ctx *ctx = NULL;
    size_t n = 0;

    common.threads = 1;
    bool ok = !ibl_start(&common, b->console, &ctx) &&
              !ibl_image_read(ctx, b->opts->envs[env], &b->opts->common.read,
                              &image, NULL);
    if (ok) {
        const ibl_bench_list list = widths(b, &image);
        f[n++] = (found){image.width, image.height};
        for (int i = 0; i < list.count && ok; i++) {
            const double ratio = (double)image.height / image.width;
            const double height = list.values[i] * ratio + 0.5;
            f[n] = (found){list.values[i], height < 1 ? 1 : (int)height};
            ok = write_source(b, env, &image, f[n++]);
        }
    } else {
        ibl_console_fail(b->console, "%s: cannot be read", b->opts->envs[env]);
    }
    if (ok)
        ok = write(report, f, n * sizeof *f) == (ssize_t)(n * sizeof *f);
    ibl_image_free(&image);
    ibl_ctx_free(ctx);
    return ok;
}

/* Runs make in a child; the number of sizes that it told, 0: failed. */
static int make_apart(const ibl_bench *b, int env, found *f, size_t size)
{
    int report[2], status = 1;
    ssize_t got;

    if (pipe(report)) {
        ibl_console_fail(b->console, "no pipe can be made: %s",
                         strerror(errno));
        return 0;
    }
    ibl_signals_hold();
    const pid_t pid = fork();
    if (pid == 0) {
        setpgid(0, 0);
        ibl_signals_pass(SIG_DFL);
        ibl_signals_release();
        close(report[0]);
        _exit(!make(b, env, report[1]));
    }
    close(report[1]);
    if (pid > 0) {
        setpgid(pid, pid);
        ibl_signals_group(pid);
    }
    ibl_signals_release();
    got = pid > 0 ? read(report[0], f, size) : 0;
    close(report[0]);
    if (pid < 0)
        ibl_console_fail(b->console, "no process can be made: %s",
                         strerror(errno));
    else
        while (waitpid(pid, &status, 0) < 0 && errno == EINTR)
            ;
    ibl_signals_group(0);
    if (pid > 0 && WIFSIGNALED(status))
        ibl_console_fail(b->console, "%s: reading it ended by signal %d",
                         b->opts->envs[env], WTERMSIG(status));
    return !status && got > 0 ? (int)((size_t)got / sizeof *f) : 0;
}

/* A name that no command takes for an option. */
static char *env_path(const char *name)
{
    const size_t size = strlen(name) + 3;
    char *path = malloc(size);

    if (path)
        snprintf(path, size, "%s%s", *name == '-' ? "./" : "", name);
    return path;
}

static bool keep(ibl_bench *b, int env, found f, bool resampled)
{
    ibl_bench_source *s = &b->sources[b->source_count++];

    *s = (ibl_bench_source){env, f.width, f.height, resampled, NULL};
    s->path =
        resampled ? source_path(b, env, f.width) : env_path(b->opts->envs[env]);
    if (!s->path)
        ibl_console_fail(b->console, "no memory for the list of maps");
    return s->path;
}

bool ibl_bench_sources_make(ibl_bench *b)
{
    b->sources = calloc((size_t)b->opts->env_count * (IBL_BENCH_VALUES + 1),
                        sizeof *b->sources);
    if (!b->sources) {
        ibl_console_fail(b->console, "no memory for the list of maps");
        return false;
    }
    for (int env = 0; env < b->opts->env_count; env++) {
        found f[IBL_BENCH_VALUES + 1];
        ibl_console_progress(b->console, "resample",
                             (double)env / b->opts->env_count);
        const int n = make_apart(b, env, f, sizeof f);
        if (!n)
            return false;
        for (int i = 0; i < n; i++)
            if (!keep(b, env, f[i], i > 0))
                return false;
    }
    return true;
}
