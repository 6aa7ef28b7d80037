/* SPDX-License-Identifier: MIT */
#include "io/repair.h"

#include <stdbool.h>
#include <stdint.h>
#include <string.h>

#include "core/alloc.h"
#include "core/context.h"

enum {
    ROWS = 16,  /* of a job */
    BLOCK = 768 /* floats that are looked at together */
};

#define INFINITE_BITS 0x7f800000u
/* A halves' largest: what a clipped sun is worth at least. */
static const float clipped = 65504;

typedef struct scan {
    ibl_image *img;
    float *edges;       /* the first and last row of each job, as they were */
    float *rows;        /* 2 rows for each worker */
    ibl_repair *counts; /* of each job */
} scan;

/*
 * The largest of the floats as bits, where the sign is set larger than any
 * other: up to FLT_MAX's if and only if all are finite and none has a sign,
 * and then it is their maximum. 16 lanes, for the vectoriser.
 */
static uint32_t largest_bits(const float *src, size_t count)
{
    uint32_t lane[16] = {0}, bits, most = 0;
    uint32_t sign = 0;
    size_t i = 0;

    for (; i + 16 <= count; i += 16) {
        for (int j = 0; j < 16; j++) {
            memcpy(&bits, src + i + j, sizeof bits);
            sign |= bits;
            bits &= 0x7fffffffu;
            lane[j] = (int32_t)bits > (int32_t)lane[j] ? bits : lane[j];
        }
    }
    for (; i < count; i++) {
        memcpy(&bits, src + i, sizeof bits);
        sign |= bits;
        bits &= 0x7fffffffu;
        most = bits > most ? bits : most;
    }
    for (int j = 0; j < 16; j++)
        most = lane[j] > most ? lane[j] : most;
    return most | (sign & 0x80000000u);
}

static uint32_t bits_of(float f)
{
    uint32_t bits;
    memcpy(&bits, &f, sizeof bits);
    return bits;
}

static bool is_finite(float f)
{
    return (bits_of(f) & INFINITE_BITS) != INFINITE_BITS;
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

static void scan_job(void *arg, int job, int worker)
{
    const scan *s = arg;
    const int first = job * ROWS;
    const int end =
        first + ROWS < s->img->height ? first + ROWS : s->img->height;
    float *p = s->img->data + 3 * (size_t)first * (size_t)s->img->width;
    size_t left = 3 * (size_t)(end - first) * (size_t)s->img->width;
    ibl_repair count = {0};

    (void)worker;
    while (left) {
        const size_t n = left < BLOCK ? left : BLOCK;
        const uint32_t bits = largest_bits(p, n);
        float most;
        memcpy(&most, &bits, sizeof most);
        if (bits >= INFINITE_BITS)
            mend_signs(p, n / 3, &count);
        else if (most > count.peak)
            count.peak = most;
        p += n;
        left -= n;
    }
    s->counts[job] = count;
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
                                bits_of(*f) == INFINITE_BITS ? clipped : 0);
            if (*f > *peak)
                *peak = *f;
        }
    }
}

/* Neighbours are taken as they were before any was mended: the row above from
 * a copy, rows beyond the job's from the edges that were set aside. */
static void mend_job(void *arg, int job, int worker)
{
    const scan *s = arg;
    const int width = s->img->width, height = s->img->height;
    const size_t floats = 3 * (size_t)width, bytes = floats * sizeof(float);
    const int first = job * ROWS;
    const int end = first + ROWS < height ? first + ROWS : height;
    float *copies[2] = {s->rows + 2 * floats * (size_t)worker,
                        s->rows + 2 * floats * (size_t)worker + floats};
    const float *above = job ? s->edges + floats * (2 * (size_t)job - 1) : NULL;

    for (int y = first; y < end; y++) {
        float *row = s->img->data + floats * (size_t)y;
        float *copy = copies[y & 1];
        const float *below = row + floats;
        memcpy(copy, row, bytes);
        if (y + 1 == height)
            below = NULL;
        else if (y + 1 == end)
            below = s->edges + floats * (2 * (size_t)job + 2);
        mend_row(row, (const float *const[3]){above, copy, below}, width,
                 &s->counts[job].peak);
        above = copy;
    }
}

static ibl_status mend_nonfinite(ibl_ctx *ctx, scan *s, int jobs)
{
    const size_t floats = 3 * (size_t)s->img->width;
    const int height = s->img->height;
    ibl_status status = IBL_ERR_MEMORY;

    s->edges = ibl_alloc_array(2 * (size_t)jobs, floats * sizeof(float));
    s->rows = ibl_alloc_array(2 * (size_t)ibl_ctx_threads(ctx),
                              floats * sizeof(float));
    if (!s->edges || !s->rows) {
        ibl_no_memory(ctx, "mending non-finite pixels");
        goto done;
    }
    for (int j = 0; j < jobs; j++) {
        const int end = (j + 1) * ROWS < height ? (j + 1) * ROWS : height;
        memcpy(s->edges + floats * 2 * (size_t)j,
               s->img->data + floats * (size_t)(j * ROWS),
               floats * sizeof(float));
        memcpy(s->edges + floats * (2 * (size_t)j + 1),
               s->img->data + floats * (size_t)(end - 1),
               floats * sizeof(float));
    }
    status = ibl_run(ctx, NULL, jobs, mend_job, s);
done:
    ibl_free(s->rows);
    ibl_free(s->edges);
    return status;
}

ibl_status ibl_image_repair(ibl_ctx *ctx, ibl_image *img, ibl_repair *done)
{
    const int jobs = (img->height + ROWS - 1) / ROWS;
    scan s = {.img = img};
    ibl_status status;

    *done = (ibl_repair){0};
    s.counts = ibl_alloc_zeroed((size_t)jobs, sizeof *s.counts);
    if (!s.counts)
        return ibl_no_memory(ctx, "looking over an image");
    status = ibl_run(ctx, NULL, jobs, scan_job, &s);
    for (int j = 0; j < jobs; j++) {
        done->nonfinite += s.counts[j].nonfinite;
        done->negative += s.counts[j].negative;
    }
    if (!status && done->nonfinite)
        status = mend_nonfinite(ctx, &s, jobs);
    for (int j = 0; j < jobs; j++) {
        if (s.counts[j].peak > done->peak)
            done->peak = s.counts[j].peak;
    }
    ibl_free(s.counts);
    return status;
}
