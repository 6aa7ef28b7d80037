/* SPDX-License-Identifier: MIT */
#include "io/repair.h"

#include <stdbool.h>
#include <stdint.h>
#include <string.h>

#include "core/alloc.h"
#include "core/context.h"
#include "kern/max_finite.h"

enum {
    ROWS = 16 /* of a job */
};

/* A halves' largest: what a clipped sun is worth at least. */
static const float clipped = 65504;

/* Rows that were read together. */
typedef struct batch {
    float *rgb;
    int width, count;
    uint32_t *most;             /* of each row */
    const float *above, *below; /* as they were; NULL beyond the poles */
    float *edges;       /* the first and last row of each job, as they were */
    float *copies;      /* 2 rows for each worker */
    ibl_repair *counts; /* of each job */
} batch;

static size_t row_floats(const batch *b)
{
    return 3 * (size_t)b->width;
}

static float *row_of(const batch *b, int y)
{
    return b->rgb + row_floats(b) * (size_t)y;
}

/* Whether the row has something that is not finite. Once signs are mended
 * that is all that most says of rows that needed it. */
static bool is_dirty(const batch *b, int y)
{
    return b->most[y] >= IBL_INFINITE_BITS;
}

static uint32_t bits_of(float f)
{
    uint32_t bits;
    memcpy(&bits, &f, sizeof bits);
    return bits;
}

static bool is_finite(float f)
{
    return (bits_of(f) & IBL_INFINITE_BITS) != IBL_INFINITE_BITS;
}

/* Zeroes what is negative and counts, pixel by pixel. */
static void mend_signs(float *p, size_t pixels, ibl_repair *count)
{
    for (size_t i = 0; i < pixels; i++, p += 3) {
        bool negative = false, nonfinite = false;
        for (int c = 0; c < 3; c++) {
            if (!is_finite(p[c])) {
                nonfinite = true;
            } else if (p[c] <= 0) { /* -0 too */
                negative |= p[c] < 0;
                p[c] = 0;
            } else if (p[c] > count->peak) {
                count->peak = p[c];
            }
        }
        count->negative += negative;
        count->nonfinite += nonfinite;
    }
}

static void signs_job(void *arg, int job, int worker)
{
    const batch *b = arg;
    ibl_repair count = {0};

    (void)worker;
    for (int y = job * ROWS; y < b->count && y < (job + 1) * ROWS; y++) {
        if (!is_dirty(b, y))
            continue;
        const size_t before = count.nonfinite;
        mend_signs(row_of(b, y), (size_t)b->width, &count);
        b->most[y] = count.nonfinite > before ? IBL_INFINITE_BITS : 0;
    }
    b->counts[job] = count;
}

/* The largest finite value of component c around column x of the three rows
 * (NULL beyond a pole); columns wrap. */
static float best_neighbour(const float *const rows[3], int width, int x, int c,
                            float otherwise)
{
    float best = otherwise;
    bool found = false;
    for (int r = 0; r < 3; r++) {
        if (!rows[r])
            continue;
        for (int dx = -1; dx <= 1; dx++) {
            const int column = (x + dx + width) % width;
            const float f = rows[r][3 * column + c];
            if ((r == 1 && column == x) || !is_finite(f) ||
                (found && f <= best))
                continue;
            best = f;
            found = true;
        }
    }
    return best;
}

static void mend_row(float *row, const float *const rows[3], int width,
                     float *peak)
{
    for (int x = 0; x < width; x++) {
        for (int c = 0; c < 3; c++) {
            float *f = &row[3 * x + c];
            if (is_finite(*f))
                continue;
            *f = best_neighbour(rows, width, x, c,
                                bits_of(*f) == IBL_INFINITE_BITS ? clipped : 0);
            if (*f > *peak)
                *peak = *f;
        }
    }
}

/* Where the first or last row of a job is set aside. */
static float *edge_of(const batch *b, int y)
{
    return b->edges + row_floats(b) * (size_t)(2 * (y / ROWS) + (y % ROWS > 0));
}

/* Row y of another job, as it was. */
static const float *other_row(const batch *b, int y)
{
    if (y < 0)
        return b->above;
    if (y >= b->count)
        return b->below;
    return is_dirty(b, y) ? edge_of(b, y) : row_of(b, y);
}

/* Neighbours are taken as they were before any was mended: the row above from
 * a copy, rows beyond the job's from the edges. */
static void nonfinite_job(void *arg, int job, int worker)
{
    const batch *b = arg;
    const size_t floats = row_floats(b);
    const int first = job * ROWS;
    const int end = first + ROWS < b->count ? first + ROWS : b->count;
    float *copies = b->copies + 2 * floats * (size_t)worker;
    const float *above = other_row(b, first - 1);

    for (int y = first; y < end; y++) {
        float *row = row_of(b, y), *copy = copies + (y & 1 ? floats : 0);
        const float *below = y + 1 < end ? row + floats : other_row(b, end);
        if (!is_dirty(b, y)) {
            above = row;
            continue;
        }
        memcpy(copy, row, floats * sizeof *copy);
        mend_row(row, (const float *const[3]){above, copy, below}, b->width,
                 &b->counts[job].peak);
        above = copy;
    }
}

/* ---- a batch -------------------------------------------------------- */

static int jobs_of(const batch *b)
{
    return (b->count + ROWS - 1) / ROWS;
}

static void add_counts(const batch *b, ibl_repair *done)
{
    for (int j = 0; j < jobs_of(b); j++) {
        done->nonfinite += b->counts[j].nonfinite;
        done->negative += b->counts[j].negative;
        if (b->counts[j].peak > done->peak)
            done->peak = b->counts[j].peak;
    }
}

static ibl_status run(ibl_ctx *ctx, batch *b, ibl_job_fn *job, ibl_repair *done)
{
    b->counts = ibl_alloc_zeroed((size_t)jobs_of(b), sizeof *b->counts);
    if (!b->counts)
        return ibl_no_memory(ctx, "looking over an image");
    const ibl_status status = ibl_run(ctx, NULL, jobs_of(b), job, b);
    add_counts(b, done);
    ibl_free(b->counts);
    return status;
}

/* Zeroes what is negative; what is not finite stays. */
static ibl_status mend_batch_signs(ibl_ctx *ctx, batch *b, ibl_repair *done)
{
    bool needed = false;
    for (int y = 0; y < b->count; y++) {
        if (is_dirty(b, y)) {
            needed = true;
            continue;
        }
        float most;
        memcpy(&most, &b->most[y], sizeof most);
        if (most > done->peak)
            done->peak = most;
    }
    return needed ? run(ctx, b, signs_job, done) : IBL_OK;
}

static ibl_status mend_batch_nonfinite(ibl_ctx *ctx, batch *b, ibl_repair *done)
{
    const size_t bytes = row_floats(b) * sizeof(float);
    const int jobs = jobs_of(b);
    ibl_status status = IBL_ERR_MEMORY;

    b->edges = ibl_alloc_array(2 * (size_t)jobs, bytes);
    b->copies = ibl_alloc_array(2 * (size_t)ibl_ctx_threads(ctx), bytes);
    if (!b->edges || !b->copies) {
        ibl_no_memory(ctx, "mending non-finite pixels");
        goto done;
    }
    for (int y = 0; y < b->count; y++) {
        if ((y % ROWS == 0 || y % ROWS == ROWS - 1) && is_dirty(b, y))
            memcpy(edge_of(b, y), row_of(b, y), bytes);
    }
    status = run(ctx, b, nonfinite_job, done);
done:
    ibl_free(b->copies);
    ibl_free(b->edges);
    return status;
}

/* ---- rows in order -------------------------------------------------- */

ibl_status ibl_mender_init(ibl_mender *m, ibl_rows *rows)
{
    const size_t bytes = 3 * sizeof(float) * (size_t)rows->width;

    *m = (ibl_mender){.rows = rows};
    m->most = ibl_alloc_array((size_t)rows->height, sizeof *m->most);
    m->above = ibl_alloc_array(1, bytes);
    m->spare = ibl_alloc_array(1, bytes);
    m->ahead = ibl_alloc_array(1, bytes);
    if (!m->most || !m->above || !m->spare || !m->ahead)
        return ibl_no_memory(rows->ctx, "rows of an image");
    return IBL_OK;
}

/* Reads count rows from the map's row on, and mends their signs. */
static ibl_status read_new(ibl_mender *m, int count, float *rgb)
{
    ibl_rows *rows = m->rows;
    batch b = {.rgb = rgb,
               .width = rows->width,
               .count = count,
               .most = m->most + rows->row};
    if (!count)
        return IBL_OK;
    const ibl_status status = ibl_rows_read(rows, count, rgb, b.most);
    return status ? status : mend_batch_signs(rows->ctx, &b, &m->done);
}

ibl_status ibl_mender_read(ibl_mender *m, int count, float *rgb)
{
    ibl_rows *rows = m->rows;
    const size_t floats = 3 * (size_t)rows->width;
    const int first = rows->row - m->has_ahead, left = rows->height - first;
    batch b = {.rgb = rgb,
               .width = rows->width,
               .count = count,
               .most = m->most + first,
               .above = first ? m->above : NULL};
    bool needed = false;
    ibl_status status;

    if (m->has_ahead)
        memcpy(rgb, m->ahead, floats * sizeof *rgb);
    status =
        read_new(m, count - m->has_ahead, rgb + (m->has_ahead ? floats : 0));
    if (status)
        return status;
    memcpy(m->spare, row_of(&b, count - 1), floats * sizeof *rgb);
    m->has_ahead = is_dirty(&b, count - 1) && count < left;
    if (m->has_ahead) {
        b.below = m->ahead;
        status = read_new(m, 1, m->ahead);
    }
    for (int y = 0; y < count; y++)
        needed |= is_dirty(&b, y);
    if (!status && needed)
        status = mend_batch_nonfinite(rows->ctx, &b, &m->done);
    float *swap = m->above;
    m->above = m->spare;
    m->spare = swap;
    return status;
}

void ibl_mender_free(ibl_mender *m)
{
    ibl_free(m->ahead);
    ibl_free(m->spare);
    ibl_free(m->above);
    ibl_free(m->most);
    *m = (ibl_mender){0};
}
