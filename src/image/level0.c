/* SPDX-License-Identifier: MIT */
/*
 * Level 0: the average of an equirectangular map over each texel of a cube,
 * row by row.
 *
 * In the chart (phi, c = cos theta) solid angle is plain area, a source pixel
 * is a rectangle, and a texel is a region bounded by four curves. Each pixel
 * is cut by the curves that cross it (image/level0_geometry.h). Its parts are
 * added to their texels, in double and with weights >= 0 that sum to the
 * pixel's area, but for rounding: nothing cancels. Sums are kept only for
 * texels that later rows can still reach; the texels before are in the cube
 * (image/level0_octants.h). Dividing by the sum of weights gives the average,
 * and keeps a constant map constant to rounding.
 *
 * A source whose pixels are larger than the texels is first interpolated to a
 * finer grid (image/upsample.h).
 *
 * A job is a part of the horizon, so that no two jobs write the same sums. It
 * takes the rows of a batch in order. So the bytes do not depend on the number
 * of threads and on the batches.
 */
#include <assert.h>
#include <math.h>
#include <string.h>

#include "core/alloc.h"
#include "core/context.h"
#include "image/cube.h"
#include "image/image.h"
#include "image/level0.h"
#include "image/level0_octants.h"
#include "image/upsample.h"

enum {
    PIXELS_PER_RUN = 1 << 21, /* of the fine grid; keeps jobs short */
    MAX_ROWS_PER_RUN = 256
};

/* A fine row, or its part on one side of the equator. */
struct work_row {
    ibl_wedge_row cut;
    int from_pole; /* rows between it and its pole */
    ibl_octant_blend between;
};

/* State of a worker: collects spans and adds them to a job's sums. */
struct adder {
    ibl_wedge_sink sink; /* must be first: take_spans casts it to adder */
    const ibl_octants_dsp *dsp;
    double *pixels;
    ibl_octant_sums *sums; /* the job's sums */
    bool keeps;            /* whether the row's spans are kept */
};

struct ibl_level0 {
    ibl_ctx *ctx;
    ibl_upsample fine;
    ibl_octant_set set;
    float *last;   /* row of the source before the next one */
    float *latest; /* buffer for the last row of the next batch */
    int added;     /* rows of the source added so far */
    int done;      /* fine rows taken so far */
    struct work_row *rows;
    int row_count;
    struct adder *adders; /* one for each worker */
};

static void take_spans(ibl_wedge_sink *sink)
{
    struct adder *a = (struct adder *)(void *)sink;
    ibl_octant_sums *s = a->sums;
    a->dsp->add(sink->spans, sink->count, a->pixels, s->sums, s->weights);
    a->keeps = a->keeps && sink->count < s->room - s->kept_spans;
    if (a->keeps) {
        memcpy(s->kept + s->kept_spans, sink->spans,
               (size_t)sink->count * sizeof *sink->spans);
        s->kept_spans += sink->count;
    }
    sink->count = 0;
}

static void collect(const ibl_level0 *l, const struct work_row *r,
                    const int *column, int count, int lanes, double *pixels)
{
    if (l->fine.taps)
        l->set.dsp.blend(&r->between, column, count, lanes, pixels);
    else
        l->set.dsp.collect(r->between.source[0], column, count, pixels);
}

/* Cuts strips of a row, adds its spans, and keeps them if there is room. */
static void cut_row(const struct work_row *r, const ibl_wedge *w, int begin,
                    int end, struct adder *a)
{
    ibl_octant_sums *s = a->sums;
    const int before = s->kept_spans;
    a->keeps =
        !r->cut.south && r->from_pole == s->kept_rows && before < s->room;
    if (begin < end)
        ibl_wedge_cut(w, &r->cut, &s->part, begin, end, &a->sink);
    if (!a->keeps) {
        s->kept_spans = before;
        return;
    }
    s->kept[s->kept_spans].slot = s->kept_spans - before;
    s->kept_spans++;
    s->kept_rows++;
}

/* Adds the spans of the last row that is kept, and drops them. */
static void add_kept(struct adder *a)
{
    ibl_octant_sums *s = a->sums;
    const int count = s->kept[s->kept_spans - 1].slot;
    s->kept_rows--;
    s->kept_spans -= 1 + count;
    a->dsp->add(s->kept + s->kept_spans, count, a->pixels, s->sums, s->weights);
}

static void add_row(const ibl_level0 *l, const struct work_row *r,
                    const ibl_octant_group *g, struct adder *a)
{
    int begin, end;
    const ibl_wedge_strips *strips =
        ibl_wedge_range(&g->wedge, &r->cut, &a->sums->part, &begin, &end);
    if (begin < end) {
        const int first = strips->strip[begin].pixel;
        collect(l, r, g->column + (size_t)first * IBL_OCTANTS,
                strips->strip[end - 1].pixel + 1 - first, g->octants,
                a->pixels + (size_t)first * IBL_OCTANT_RGB);
    }
    if (r->cut.south && r->from_pole < a->sums->kept_rows)
        add_kept(a);
    else
        cut_row(r, &g->wedge, begin, end, a);
}

static void add_rows(void *arg, int job, int worker)
{
    ibl_level0 *l = arg;
    const int part = job / l->set.groups;
    ibl_octant_group *g = &l->set.group[job % l->set.groups];
    struct adder *a = &l->adders[worker];
    a->sums = &g->sums[part];
    for (int i = 0; i < l->row_count; i++) {
        const struct work_row *r = &l->rows[i];
        ibl_octants_finish(&l->set, g, part,
                           ibl_wedge_lines_before(&g->wedge, &r->cut));
        add_row(l, r, g, a);
    }
}

static void write_rest(void *arg, int job, int worker)
{
    ibl_level0 *l = arg;
    ibl_octant_group *g = &l->set.group[job % l->set.groups];
    (void)worker;
    ibl_octants_finish(&l->set, g, job / l->set.groups, g->wedge.lines);
}

static int job_count(const ibl_level0 *l)
{
    return l->set.groups * l->set.group[0].parts;
}

/* ---- rows ------------------------------------------------------------- */

/* Takes the next fine row if its source rows have arrived; false: not yet. rgb
 * begins with source row l->added. */
static bool next_row(ibl_level0 *l, int rows, const float *rgb)
{
    struct work_row r;
    int source[2];
    if (l->done == l->fine.rows)
        return false;
    r.between = ibl_upsample_between(&l->fine, l->done, source);
    for (int k = 0; k < 2; k++) {
        const int j = source[k];
        if (j >= l->added + rows)
            return false;
        r.between.source[k] = j < l->added ? l->last
                                           : rgb + 3 * (size_t)l->fine.width *
                                                       (size_t)(j - l->added);
    }
    for (int south = 0; south < 2; south++) {
        r.from_pole = south ? l->fine.rows - 1 - l->done : l->done;
        if (ibl_wedge_row_init(&l->set.group[0].wedge, l->fine.rows, l->done,
                               south, &r.cut))
            l->rows[l->row_count++] = r;
    }
    l->done++;
    return true;
}

/* Moves available fine rows to l->rows, `most` at most; returns their number.
 */
static int take_rows(ibl_level0 *l, int most, int rows, const float *rgb)
{
    int taken = 0;
    l->row_count = 0;
    while (taken < most && next_row(l, rows, rgb))
        taken++;
    return taken;
}

static int rows_per_run(const ibl_level0 *l)
{
    const int rows = PIXELS_PER_RUN / l->fine.columns;
    return rows < 1 ? 1 : rows < MAX_ROWS_PER_RUN ? rows : MAX_ROWS_PER_RUN;
}

ibl_status ibl_level0_add(ibl_level0 *l, int rows, const float *rgb)
{
    const size_t row = 3 * (size_t)l->fine.width;
    const int most = rows_per_run(l);
    ibl_status status = IBL_OK;
    assert(rows >= 0 && rows <= l->fine.height - l->added);
    while (take_rows(l, most, rows, rgb) == most && !status)
        status = ibl_run(l->ctx, NULL, job_count(l), add_rows, l);
    if (status)
        return status;
    ibl_run_begin(l->ctx, "level 0", (double)l->added / l->fine.height,
                  job_count(l), add_rows, l);
    if (rows > 0) {
        float *const latest = l->latest;
        memcpy(latest, rgb + (size_t)(rows - 1) * row, row * sizeof *rgb);
        l->latest = l->last;
        l->last = latest;
    }
    l->added += rows;
    return IBL_OK;
}

ibl_status ibl_level0_finish(ibl_level0 *l)
{
    assert(l->added == l->fine.height);
    const ibl_status status =
        ibl_run(l->ctx, NULL, job_count(l), write_rest, l);
    if (!status)
        ibl_octants_join(&l->set);
    return status;
}

/* ---- from beginning to end -------------------------------------------- */

static bool init_adders(ibl_level0 *l)
{
    const int threads = ibl_ctx_threads(l->ctx);
    const size_t pixels = (size_t)l->fine.columns / 8 + 2;
    l->adders = ibl_alloc_zeroed((size_t)threads, sizeof *l->adders);
    for (int i = 0; l->adders && i < threads; i++) {
        struct adder *a = &l->adders[i];
        a->dsp = &l->set.dsp;
        a->pixels =
            ibl_alloc_zeroed(pixels, IBL_OCTANT_RGB * sizeof *a->pixels);
        a->sink.full = take_spans;
        if (!a->pixels)
            return false;
    }
    return l->adders;
}

ibl_status ibl_level0_create(ibl_ctx *ctx, int width, int height,
                             double yaw_deg, ibl_cube *cube, ibl_level0 **out)
{
    *out = NULL;
    assert(isfinite(yaw_deg));
    ibl_level0 *l = ibl_alloc_zeroed(1, sizeof *l);
    if (!l)
        return ibl_no_memory(ctx, "level 0");
    l->ctx = ctx;
    ibl_status status =
        ibl_upsample_init(ctx, width, height, cube->size, &l->fine);
    if (!status)
        status = ibl_octants_init(ctx, cube, l->fine.columns, l->fine.rows,
                                  yaw_deg, !l->fine.taps, &l->set);
    if (status)
        goto fail;
    l->last = ibl_alloc_array((size_t)width, 3 * sizeof *l->last);
    l->latest = ibl_alloc_array((size_t)width, 3 * sizeof *l->latest);
    l->rows = ibl_alloc_array(2 * MAX_ROWS_PER_RUN, sizeof *l->rows);
    if (!l->last || !l->latest || !l->rows || !init_adders(l)) {
        status = ibl_no_memory(ctx, "level 0");
        goto fail;
    }
    *out = l;
    return IBL_OK;
fail:
    ibl_level0_free(l);
    return status;
}

void ibl_level0_free(ibl_level0 *l)
{
    if (!l)
        return;
    for (int i = 0; l->adders && i < ibl_ctx_threads(l->ctx); i++)
        ibl_free(l->adders[i].pixels);
    ibl_free(l->adders);
    ibl_free(l->rows);
    ibl_free(l->last);
    ibl_free(l->latest);
    ibl_octants_free(&l->set);
    ibl_upsample_free(&l->fine);
    ibl_free(l);
}

ibl_status ibl_cube_from_latlong(ibl_ctx *ctx, const ibl_image *env,
                                 double yaw_deg, ibl_cube *cube)
{
    enum {
        STEPS = 16 /* batches, and thus reports of progress */
    };
    ibl_level0 *l;
    ibl_status status = ibl_check_image(ctx, env);
    if (!status)
        status = ibl_check_cube(ctx, cube);
    if (!status && !isfinite(yaw_deg))
        status = ibl_fail(ctx, IBL_ERR_ARGUMENT, "the yaw must be finite");
    if (!status)
        status =
            ibl_level0_create(ctx, env->width, env->height, yaw_deg, cube, &l);
    if (status)
        return status;
    const int rows = env->height / STEPS + 1;
    for (int j = 0; j < env->height && !status; j += rows) {
        const int left = env->height - j;
        status = ibl_level0_add(l, rows < left ? rows : left,
                                env->data + 3 * (size_t)j * (size_t)env->width);
        if (!status)
            status = ibl_run_end(ctx);
    }
    if (!status)
        status = ibl_level0_finish(l);
    if (!status)
        ibl_progress(ctx, "level 0", 1);
    ibl_level0_free(l);
    return status;
}
