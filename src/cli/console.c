/* SPDX-License-Identifier: MIT */
#include "cli/console.h"

#include <errno.h>
#include <math.h>
#include <pthread.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "common/path.h"
#include "common/process.h"
#include "port/port.h"

#define REDRAW_SECONDS 0.2

/* Guards what is drawn where several consoles have one screen. */
static pthread_mutex_t screen = PTHREAD_MUTEX_INITIALIZER;

static void erase_bar(ibl_console *c)
{
    if (c->drawn)
        fputs("\r\033[K", stderr);
    c->drawn = false;
}

static void print_log(void *console, ibl_log_level level, const char *text)
{
    ibl_console *c = console;
    const char *kind = level == IBL_LOG_WARNING ? "warning: " : "";
    const bool names =
        !c->about || level == IBL_LOG_INFO || strstr(text, c->about);
    char line[IBL_LINE_BYTES];

    if (level == IBL_LOG_ERROR ? c->failed : c->quiet)
        return;
    if (level == IBL_LOG_INFO && !c->verbose)
        return;
    snprintf(line, sizeof line, "%s%s%s", names ? "" : c->about,
             names ? "" : ": ", text);
    pthread_mutex_lock(&screen);
    erase_bar(c->front ? c->front : c);
    ibl_print_line(kind, line);
    pthread_mutex_unlock(&screen);
    if (level != IBL_LOG_ERROR)
        return;
    c->failed = true;
    if (c->front)
        snprintf(c->error, sizeof c->error, "%s", text);
}

static void say(ibl_console *c, ibl_log_level level, const char *fmt,
                va_list ap)
{
    char text[IBL_LINE_BYTES];
    vsnprintf(text, sizeof text, fmt, ap);
    print_log(c, level, text);
}

bool ibl_console_fail(ibl_console *c, const char *fmt, ...)
{
    va_list ap;
    va_start(ap, fmt);
    say(c, IBL_LOG_ERROR, fmt, ap);
    va_end(ap);
    return false;
}

bool ibl_console_differ(ibl_console *c, const char *input, const char *output,
                        const char *other)
{
    const int same = ibl_path_same(input, output);

    if (same < 0)
        return ibl_console_fail(c, "%s: cannot be compared with %s: %s", input,
                                output, strerror(errno));
    return !same || ibl_console_fail(
                        c, "%s: is both input and output: choose another %s",
                        output, other);
}

void ibl_console_error(void *console, const char *text)
{
    ibl_console_fail(console, "%s", text);
}

void ibl_console_warn(ibl_console *c, const char *fmt, ...)
{
    va_list ap;
    va_start(ap, fmt);
    say(c, IBL_LOG_WARNING, fmt, ap);
    va_end(ap);
}

void ibl_console_info(ibl_console *c, const char *fmt, ...)
{
    va_list ap;
    va_start(ap, fmt);
    say(c, IBL_LOG_INFO, fmt, ap);
    va_end(ap);
}

/* Ends the running stage and starts another, which may have run before; NULL:
 * none. Returns the time. */
static double run_stage(ibl_console *c, const char *name)
{
    const double t = ibl_now();
    int i = 0;

    if (c->running >= 0)
        c->stages[c->running].seconds += t - c->stage_from;
    c->stage_from = t;
    c->running = -1;
    if (!name)
        return t;
    while (i < c->count &&
           strncmp(c->stages[i].name, name, sizeof c->stages[i].name - 1) != 0)
        i++;
    if (i == IBL_MAX_STAGES)
        i--;
    else if (i == c->count)
        snprintf(c->stages[c->count++].name, sizeof c->stages[i].name, "%s",
                 name);
    c->running = i;
    return t;
}

void ibl_console_init(ibl_console *c, bool quiet, bool verbose)
{
    *c = (ibl_console){.quiet = quiet, .verbose = verbose, .running = -1};
    c->terminal = !quiet && isatty(STDERR_FILENO);
    c->begun = run_stage(c, "start");
}

void ibl_console_progress(ibl_console *c, const char *stage, double done)
{
    static const char full[] = "##############################";
    const int width = (int)sizeof full - 1;
    const double t = run_stage(c, stage);

    done = fmin(fmax(done, 0), 1);
    if (ibl_port_progress && !c->front)
        ibl_port_progress(done);
    if (!c->terminal)
        return;
    if (done < c->share || c->share_from <= 0)
        c->share_from = t;
    c->share = done;
    if (c->drawn_at > 0 && t - c->drawn_at < REDRAW_SECONDS)
        return;
    const int filled = (int)(done * width);
    const double spent = t - c->share_from;
    pthread_mutex_lock(&screen);
    fprintf(stderr, "\r%-14.14s [%.*s%*s] %3d %%", stage, filled, full,
            width - filled, "", (int)(100 * done));
    if (done > 0.02 && spent > 0.5) { /* an early guess would be far off */
        const int left = (int)(spent * (1 - done) / done + 0.5);
        fprintf(stderr, "  %d:%02d left", left / 60, left % 60);
    }
    fputs("\033[K", stderr);
    fflush(stderr);
    c->drawn = true;
    pthread_mutex_unlock(&screen);
    c->drawn_at = t;
}

/* An ibl_progress_fn: shows the share of the bake, or of a stage outside one.
 */
static void on_progress(void *console, const char *stage, double done,
                        double whole)
{
    ibl_console_progress(console, stage, whole < 0 ? done : whole);
}

void ibl_console_finish(ibl_console *c)
{
    run_stage(c, NULL);
    pthread_mutex_lock(&screen);
    erase_bar(c);
    pthread_mutex_unlock(&screen);
}

int ibl_console_end(ibl_console *c, bool ok)
{
    ibl_console_finish(c);
    if (!ok)
        ibl_console_fail(c, "%s", ibl_status_text(IBL_ERR_MEMORY));
    if (ok && c->verbose && !c->front) {
        for (int i = 0; i < c->count; i++)
            fprintf(stderr, "%-16s %9.3f s\n", c->stages[i].name,
                    c->stages[i].seconds);
        fprintf(stderr, "%-16s %9.3f s\n", "total", ibl_now() - c->begun);
    }
    return ok ? 0 : 1;
}

/* ---- context ---------------------------------------------------------- */

ibl_status ibl_start(const ibl_common *common, ibl_console *console,
                     ibl_ctx **ctx)
{
    ibl_ctx_options opts = ibl_ctx_options_default();

    opts.threads = common->threads;
    opts.isa = common->isa;
    opts.memory = ibl_memory_most(common);
    opts.log = print_log;
    opts.log_cookie = console;
    opts.progress = on_progress;
    opts.progress_cookie = console;
    opts.bridge = ibl_bridge_beside();
    return ibl_ctx_create(&opts, ctx);
}

bool ibl_console_commit(ibl_console *console, ibl_outputs *outputs)
{
    errno = 0;
    const char *why = ibl_unwritten(stdout);
    if (why)
        return ibl_console_fail(console,
                                "standard output cannot be written: %s", why);
    ibl_console_progress(console, "write", 1);
    return !ibl_outputs_commit(outputs);
}

bool ibl_console_fits(ibl_console *console, const ibl_common *common,
                      const char *what, double need, const char *advice)
{
    const double most = (double)ibl_memory_most(common), mib = 1 << 20;

    return most <= 0 || need <= most ||
           ibl_console_fail(console,
                            "%s: takes %.0f MiB of memory, more than the %.0f "
                            "of --max-memory: %s",
                            what, ceil(need / mib), floor(most / mib), advice);
}

/* ---- warnings --------------------------------------------------------- */

/* A pure colour in rgb9e5 can lose half of 1/511 of each other component. */
static const double LEAST_LOST = 0.01;

void ibl_warn_of_small_faces(ibl_console *console,
                             const ibl_specular_layout *layout)
{
    const int last = ibl_cube_edge(layout->size, layout->levels - 1);

    if (layout->levels > 1 && last < 4)
        ibl_console_warn(console,
                         "the last level has faces of %dx%d: lookups between "
                         "texels are off by 10 %% on faces of 2x2 and by 20 to "
                         "30 %% on 1x1: take fewer --levels or a larger --size",
                         last, last);
}

void ibl_overflow_add(const ibl_overflow_level *level, ibl_overflow_level *sum)
{
    sum->texels += level->texels;
    sum->moved = fmax(sum->moved, level->moved);
    sum->lost = fmax(sum->lost, level->lost);
}

void ibl_warn_of_overflow(ibl_console *console, const char *file,
                          const ibl_texel_options *texels, const char *packed,
                          bool fixed, const ibl_overflow_level *sum)
{
    const double most = (double)ibl_pixel_max(texels->pixel);
    const double max = texels->largest > 0 ? fmin(texels->largest, most) : most;
    char moved[96] = "", lost[96] = "";

    if (!sum->texels)
        return;
    if (sum->moved > 0)
        snprintf(moved, sizeof moved,
                 ": %.3g %% of a level's light went to the texels around %s",
                 100 * sum->moved, sum->texels == 1 ? "it" : "them");
    if (sum->lost > 0)
        snprintf(lost, sizeof lost, ": %.3g %% of a level's light is lost%s",
                 100 * sum->lost,
                 texels->overflow == IBL_OVERFLOW_CLIP ? ""
                                                       : " for want of room");
    ibl_console_warn(
        console,
        "%s: %zu %s brighter than %.9g, the most that %s "
        "holds%s%s: %s",
        file, sum->texels, sum->texels == 1 ? "texel is" : "texels are", max,
        packed ? packed : ibl_pixel_name(texels->pixel), moved, lost,
        fixed ? "take suns out with --sun, or lower --exposure"
              : "--pixel rgba32f keeps it in its place");
}

void ibl_warn_of_underflow(ibl_console *console, const char *file,
                           const char *pixel, double lost)
{
    if (lost > LEAST_LOST)
        ibl_console_warn(console,
                         "%s: %.3g %% of a level's light is less than %s can "
                         "hold, and lost: a larger --exposure keeps it",
                         file, 100 * lost, pixel);
}
