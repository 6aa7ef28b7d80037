/* SPDX-License-Identifier: MIT */
/*
 * Bakes many environments: small ones side by side, each by one thread; large
 * ones, and all where threads share no files, one after the other, by all
 * threads. The tables, which all share, are made once. Each environment has its
 * own set of outputs, so those of finished ones stay if a later one fails.
 */
#include <math.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>

#include "cli/batch.h"
#include "common/path.h"
#include "common/process.h"
#include "common/signals.h"
#include "port/port.h"
#include "json/json_text.h"

#define LARGE_PIXELS (4096.0 * 2048) /* more are baked by all threads */
#define REDRAW_NS 200000000
#define EVENT_FLAGS (JSON_COMPACT | JSON_REAL_PRECISION(6))

struct batch;

/* A context, and the map that it bakes. */
typedef struct worker {
    struct batch *batch;
    pthread_t thread;
    ibl_ctx *ctx; /* reports to run.console */
    ibl_cmdline line;
    ibl_job run;
    double since; /* CLOCK_REALTIME when the bake began */
} worker;

typedef struct batch {
    const ibl_cmdline *line;
    const ibl_opts *opts; /* the first set's */
    bool json;            /* --progress json */
    ibl_console console;
    ibl_maps maps;
    ibl_console nobody; /* prints nothing */
    ibl_ctx *silent;    /* reports there: looks at maps before they are baked */
    int count;          /* of threads, and workers of one thread */
    worker *workers;    /* these, then: */
    worker *large;      /* of all threads, for large maps */
    worker *shared;     /* of all threads, for what all maps share */
    int started;
    ibl_outputs *outputs; /* folders, removed if they are empty; the depfile */
    const ibl_output_set *tables; /* that shared has made; NULL: none */
    bool tables_kept;             /* their files are there */
    int *order; /* of the maps to bake, the large ones first */
    int to_bake;
    double begun, all_pixels;
    double most_bytes;    /* of memory that bakes may take at once */
    pthread_mutex_t lock; /* guards the maps and all below */
    pthread_cond_t changed;
    int next;     /* in order */
    int busy;     /* threads that bake */
    double bytes; /* of memory that they take */
    int running;
    int baked, kept, failed, pruned, printed;
    double pixels; /* of the maps that are done */
    bool stopped;
} batch;

/* ---- reports ------------------------------------------------------------- */

/* Prints an object of --progress json, and frees it. */
static void print_event(const batch *b, json_t *event)
{
    if (b->json && !json_dumpf(event, stdout, EVENT_FLAGS)) {
        putchar('\n');
        fflush(stdout);
    }
    json_decref(event);
}

static void print_map(const batch *b, const ibl_map *m, double seconds,
                      const char *error)
{
    static const char *const states[] = {"waits", "kept", "baked", "failed"};
    const double spent = ibl_now() - b->begun;
    json_t *event = json_pack(
        "{ss so ss si si sf}", "event", "map", "map", ibl_json_string(m->input),
        "state", states[m->state], "done", b->baked + b->kept + b->failed,
        "maps", b->maps.count, "seconds", seconds);
    if (*error)
        json_object_set_new(event, "error", ibl_json_string(error));
    if (b->pixels > 0) {
        json_object_set_new(event, "maps_per_second",
                            json_real(b->baked / spent));
        json_object_set_new(
            event, "seconds_left",
            json_real(spent * (b->all_pixels - b->pixels) / b->pixels));
    }
    print_event(b, event);
}

/* The last lines: which maps failed, whose reasons were printed, and counts. */
static void print_sum(const batch *b)
{
    char pruned[32] = "", text[160];

    if (b->opts->keep_going && b->failed) {
        snprintf(text, sizeof text, "%d of %d maps failed:", b->failed,
                 b->maps.count);
        ibl_print_line("", text);
        for (int i = 0; i < b->maps.count; i++)
            if (b->maps.list[i].state == IBL_MAP_FAILED)
                ibl_print_line("failed: ", b->maps.list[i].input);
    }
    if (b->opts->prune)
        snprintf(pruned, sizeof pruned, ", removed %d", b->pruned);
    snprintf(text, sizeof text, "baked %d maps, kept %d, %d failed%s: %.3g s",
             b->baked, b->kept, b->failed, pruned,
             ibl_now() - b->console.begun);
    if (!b->opts->common.quiet && !b->json &&
        (b->baked + b->kept || (b->opts->keep_going && b->failed)))
        ibl_print_line("", text);
}

/* ---- one map ------------------------------------------------------------- */

/* Begins a bake of a map; NULL: of w->line. The context reports to the batch's
 * screen. */
static void begin(worker *w, ibl_map *map, ibl_ctx *ctx)
{
    const batch *b = w->batch;
    ibl_job *r = &w->run;
    struct timespec now;

    clock_gettime(CLOCK_REALTIME, &now);
    w->since = (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
    if (map)
        w->line = *b->line;
    for (int i = 0; i < w->line.count && map; i++) {
        ibl_opts *o = &w->line.set[i];
        o->input = map->input;
        o->below = map->name;
        if (!ibl_is_given(&o->given, "name")) {
            /* Of stem, as it was derived: it replaces no other map's files. */
            o->name = o->stem;
            snprintf(o->stem, sizeof o->stem, "%s", ibl_path_name(map->name));
        }
    }
    *r = (ibl_job){.line = &w->line,
                   .ctx = ctx,
                   .verdicts = map ? &map->printed : NULL,
                   .tables = b->tables,
                   .maps = &b->maps};
    ibl_console_init(&r->console, b->opts->common.quiet,
                     b->opts->common.verbose);
    r->console.front = (ibl_console *)&b->console;
    r->console.about = w->line.set->input;
    r->console.terminal = false;
    ibl_job_begin(r);
}

static bool bake_map(worker *w, ibl_map *m)
{
    const batch *b = w->batch;

    begin(w, m, w->ctx);
    bool ok = ibl_job_make(&w->run) && ibl_stamp_commit(&w->run, w->since);
    if (ok && b->opts->depfile)
        ok = (m->rule = ibl_depfile_text(&w->run)) != NULL;
    ok = !ibl_console_end(&w->run.console, ok);
    if (ok && b->opts->common.verbose)
        ibl_job_log(&w->run);
    ibl_job_end(&w->run);
    return ok;
}

/* ---- all maps ------------------------------------------------------------ */

/* Waits until the next map can be baked; NULL: there is none. The caller holds
 * the lock. */
static ibl_map *take(batch *b, worker **w)
{
    while (!b->stopped && b->next < b->to_bake) {
        ibl_map *m = &b->maps.list[b->order[b->next]];
        const bool large = !ibl_port_shares_files || m->pixels > LARGE_PIXELS ||
                           b->to_bake < b->count;
        m->threads = large ? b->count : 1;
        if (!b->busy || (b->busy + m->threads <= b->count &&
                         b->bytes + m->bytes <= b->most_bytes)) {
            if (m->threads > 1)
                *w = b->large;
            b->busy += m->threads;
            b->bytes += m->bytes;
            b->next++;
            return m;
        }
        pthread_cond_wait(&b->changed, &b->lock);
    }
    return NULL;
}

static void *work(void *arg)
{
    worker *own = arg, *w = own;
    batch *b = own->batch;
    ibl_map *m;

    pthread_mutex_lock(&b->lock);
    while ((m = take(b, &w))) {
        const double begun = ibl_now();
        pthread_mutex_unlock(&b->lock);
        const bool ok = bake_map(w, m);
        pthread_mutex_lock(&b->lock);
        m->state = ok ? IBL_MAP_BAKED : IBL_MAP_FAILED;
        b->baked += ok;
        b->failed += !ok;
        b->pixels += m->pixels;
        b->stopped |= !ok && !b->opts->keep_going;
        b->busy -= m->threads;
        b->bytes -= m->bytes;
        print_map(b, m, ibl_now() - begun, ok ? "" : w->run.console.error);
        /* What maps have for standard output, in their order. */
        for (; b->printed < b->maps.count &&
               b->maps.list[b->printed].state != IBL_MAP_WAITS;
             b->printed++) {
            m = &b->maps.list[b->printed];
            if (m->printed && !b->json)
                printf("%s\n%s\n", m->input, m->printed);
            free(m->printed);
            m->printed = NULL;
        }
        pthread_cond_broadcast(&b->changed);
        w = own;
    }
    b->running--;
    pthread_cond_broadcast(&b->changed);
    pthread_mutex_unlock(&b->lock);
    return NULL;
}

/* Bakes all maps; the calling thread draws the progress. */
static bool bake_maps(batch *b)
{
    struct timespec until;

    b->begun = ibl_now();
    for (; b->started < b->count && b->started < b->to_bake; b->started++)
        if (!ibl_port_shares_files ||
            pthread_create(&b->workers[b->started].thread, NULL, work,
                           &b->workers[b->started]))
            break;
    if (!b->started) { /* there are no threads to have */
        b->running = 1;
        work(b->workers);
    }
    pthread_mutex_lock(&b->lock);
    b->running += b->started;
    while (b->running) {
        ibl_console_progress(&b->console, "maps",
                             b->all_pixels > 0 ? b->pixels / b->all_pixels : 1);
        clock_gettime(CLOCK_REALTIME, &until);
        until.tv_nsec += REDRAW_NS;
        until.tv_sec += until.tv_nsec / 1000000000;
        until.tv_nsec %= 1000000000;
        pthread_cond_timedwait(&b->changed, &b->lock, &until);
    }
    pthread_mutex_unlock(&b->lock);
    for (int i = 0; i < b->started; i++)
        pthread_join(b->workers[i].thread, NULL);
    return !b->failed;
}

/* ---- before -------------------------------------------------------------- */

static bool start(batch *b)
{
    ibl_common common = b->opts->common;
    const size_t most = ibl_memory_most(&common);

    b->most_bytes = most ? (double)most - IBL_PROGRAM_BYTES : HUGE_VAL;
    b->count = common.threads ? common.threads : ibl_cpu_count();
    b->workers = ibl_need(calloc((size_t)b->count + 2, sizeof *b->workers));
    b->large = &b->workers[b->count];
    b->shared = b->large + 1;
    bool ok = true;
    for (worker *w = b->workers; w <= b->shared && ok; w++) {
        w->batch = b;
        ibl_console_init(&w->run.console, common.quiet, false);
        w->run.console.front = &b->console;
        common.threads = w < b->large ? 1 : b->count;
        ok = !ibl_start(&common, &w->run.console, &w->ctx);
    }
    common.threads = 1;
    b->nobody = (ibl_console){.quiet = true, .failed = true, .running = -1};
    return ok && !ibl_start(&common, &b->nobody, &b->silent);
}

/* Looks at a map before it is baked: whether it is unchanged since its stamp
 * was written, else its size. Errors are reported when it is baked; but false,
 * after a message: its files cannot be in the depfile. */
static bool look(batch *b, ibl_map *m)
{
    const ibl_opts *o = b->opts;
    worker *w = b->workers;
    ibl_job *r = &w->run;
    ibl_source *source;
    struct stat st;

    begin(w, m, b->silent);
    const bool ok = !o->depfile || ibl_job_check_depfile(r);
    if (ok && o->incremental && ibl_stamp_holds(r) &&
        (!o->depfile || (m->rule = ibl_depfile_text(r))))
        m->state = IBL_MAP_KEPT;
    if (ok && m->state != IBL_MAP_KEPT && !stat(m->input, &st) &&
        S_ISREG(st.st_mode) &&
        !ibl_source_open(b->silent, m->input, &o->common.read, &source)) {
        const int width = ibl_source_width(source);
        const int height = ibl_source_height(source);
        m->pixels = (double)width * (double)height;
        m->bytes = fmax(
            0, ibl_bake_bytes(r, ibl_source_memory(source), width, height) -
                   IBL_PROGRAM_BYTES);
        ibl_source_close(source);
    }
    ibl_job_end(r);
    return ok;
}

/* Finds what is to be baked, and in which order. */
static bool plan(batch *b)
{
    for (int i = 0; i < b->maps.count; i++) {
        if (!look(b, &b->maps.list[i]))
            return false;
        b->all_pixels += b->maps.list[i].pixels;
    }
    b->order = ibl_need(calloc((size_t)b->maps.count, sizeof *b->order));
    for (int large = 1; large >= 0; large--)
        for (int i = 0; i < b->maps.count; i++)
            if (b->maps.list[i].state != IBL_MAP_KEPT &&
                (b->maps.list[i].pixels > LARGE_PIXELS) == large)
                b->order[b->to_bake++] = i;
    b->kept = b->maps.count - b->to_bake;
    return true;
}

/* Makes the outputs of all sets that do not depend on the environment, which
 * all maps share. Unchanged files of them are kept. */
static bool make_tables(batch *b)
{
    worker *w = b->shared;
    unsigned any = 0;

    w->line = *b->line;
    for (int i = 0; i < w->line.count; i++) {
        ibl_opts *o = &w->line.set[i];
        unsigned shared = 0;
        for (int kind = 0; kind < IBL_OUTPUT_COUNT; kind++)
            if (ibl_set_is_shared(o, (ibl_output_kind)kind))
                shared |= 1u << kind;
        any |= o->only &= shared;
        o->input = o->depfile = NULL;
        o->sh_format = IBL_SH_NONE;
        o->lights = o->bake.skybox = 0;
        ibl_opts_select(o);
    }
    b->tables_kept = !any;
    if (!any)
        return true;
    begin(w, NULL, w->ctx);
    b->tables_kept = b->opts->incremental && ibl_stamp_holds(&w->run);
    const bool ok = (b->tables_kept && !b->to_bake) || ibl_job_make(&w->run);
    b->tables = w->run.sets;
    return !ibl_console_end(&w->run.console, ok);
}

/* ---- the command --------------------------------------------------------- */

static bool run(batch *b)
{
    const char *directory = b->opts->directory;
    char *stamps = ibl_need(ibl_path_join(directory, IBL_STAMPS));

    print_event(b, json_pack("{ss si si sI}", "event", "begin", "maps",
                             b->maps.count, "kept", b->kept, "pixels",
                             (json_int_t)b->all_pixels));
    for (int i = 0; i < b->maps.count; i++)
        if (b->maps.list[i].state == IBL_MAP_KEPT)
            print_map(b, &b->maps.list[i], 0, "");
    bool ok =
        !ibl_outputs_create(b->shared->ctx, 0, &b->outputs) &&
        !ibl_outputs_mkdir(b->outputs, directory) &&
        (!b->opts->incremental || !ibl_outputs_mkdir(b->outputs, stamps)) &&
        make_tables(b);
    free(stamps);
    if (!ok)
        return false;
    ok = bake_maps(b);
    /* The tables get their names once a map has its files, so that nothing is
     * left where nothing was done. */
    if (!b->tables_kept && b->baked + b->kept)
        ok &= ibl_stamp_commit(&b->shared->run, b->shared->since);
    if (b->opts->depfile && (ok || b->opts->keep_going)) {
        char *rules = ibl_need(strdup("")); /* of all maps that are done */
        for (int i = 0; i < b->maps.count; i++)
            if (b->maps.list[i].rule)
                ibl_append(&rules, "%s", b->maps.list[i].rule);
        ok &= !ibl_outputs_add(b->outputs, b->opts->depfile, rules,
                               strlen(rules)) &&
              !ibl_outputs_commit(b->outputs);
        free(rules);
    }
    if (ok && b->opts->prune)
        b->pruned = ibl_stamps_prune(directory, &b->maps, &b->console);
    print_event(b, json_pack("{ss si si si sf}", "event", "end", "baked",
                             b->baked, "kept", b->kept, "failed", b->failed,
                             "seconds", ibl_now() - b->console.begun));
    return ok;
}

int ibl_batch_run(const ibl_cmdline *line)
{
    batch b = {.line = line,
               .opts = line->set,
               .json = line->set->progress == IBL_PROGRESS_JSON,
               .lock = PTHREAD_MUTEX_INITIALIZER,
               .changed = PTHREAD_COND_INITIALIZER};

    ibl_console_init(&b.console, line->set->common.quiet,
                     line->set->common.verbose);
    b.console.terminal &= !b.json;
    const bool ok = start(&b) && ibl_maps_list(line, &b.console, &b.maps) &&
                    plan(&b) && run(&b);
    for (worker *w = b.workers; w <= b.shared; w++)
        b.console.failed |= w->run.console.failed || b.failed; /* was told */
    const int status = ibl_console_end(&b.console, ok);
    print_sum(&b);
    if (b.tables)
        ibl_job_end(&b.shared->run);
    ibl_outputs_free(b.outputs);
    for (worker *w = b.workers; w <= b.shared; w++)
        ibl_ctx_free(w->ctx);
    ibl_ctx_free(b.silent);
    free(b.workers);
    free(b.order);
    ibl_maps_free(&b.maps);
    return status;
}
