/* SPDX-License-Identifier: MIT */
/*
 * Reads the scanlines of a Radiance picture in order.
 *
 * They have no table: the start of a scanline is known only after passing over
 * those before it. One job passes over a pack of scanlines while the other
 * jobs decode the previous pack.
 */
#include <errno.h>
#include <stdio.h>
#include <string.h>

#include "core/alloc.h"
#include "core/context.h"
#include "io/rgbe.h"
#include "kern/rgbe.h"

enum {
    PACK_BYTES = 1 << 20, /* read from a file at once */
    PACK_LINES = 512,
    CALL_LINES = 64,      /* lines of a pack if a call wants fewer */
    JOB_PIXELS = 1 << 14, /* about 0.05 ms of decoding */
    MIN_NEW = 8,          /* range of widths with new run lengths */
    MAX_NEW = 32767
};

bool ibl_rgbe_is(const unsigned char *bytes, size_t size)
{
    return size >= 2 && !memcmp(bytes, "#?", 2);
}

/* ---- where scanlines end -------------------------------------------- */

typedef enum fault {
    WHOLE,  /* no fault */
    CUT,    /* the bytes end within the scanline */
    DAMAGED /* runs of no pixels, or not as many pixels as it has */
} fault;

typedef struct scan {
    const unsigned char *bytes;
    size_t size, at;
    int width;
    bool is_new, is_old; /* coding of the scanline passed last */
} scan;

/* 2, 2 and a length: a normalised pixel never has these bytes. */
static bool marks_new(const unsigned char *p, int width)
{
    return width >= MIN_NEW && width <= MAX_NEW && p[0] == 2 && p[1] == 2 &&
           p[2] < 128;
}

static bool marks_repeat(const unsigned char *p)
{
    return p[0] == 1 && p[1] == 1 && p[2] == 1;
}

/* Passes over four components of runs and literals. Has no branch on run or
 * literal, which would be unpredictable. */
static fault pass_new(scan *s)
{
    const unsigned char *bytes = s->bytes;
    size_t at = s->at + 4;

    for (int c = 0; c < 4; c++) {
        int left = s->width;
        while (left > 0) {
            if (at >= s->size)
                return CUT;
            const int code = bytes[at];
            const int is_run = code > 128;
            left -= code - (-is_run & 128);
            at += (size_t)(is_run ? 2 : code + 1);
            if (!code)
                return DAMAGED;
        }
        if (left < 0)
            return DAMAGED;
    }
    if (at > s->size)
        return CUT;
    s->at = at;
    return WHOLE;
}

/* Passes over pixels and repeats (1, 1, 1, n) of the pixel before. Consecutive
 * repeats are bytes of one count, lowest first. The first four bytes of a
 * scanline are always a pixel: there is none before it to repeat. */
static fault pass_old(scan *s)
{
    const unsigned char *bytes = s->bytes;
    size_t at = s->at + 4;
    int left = s->width - 1, shift = 0, run = 0;

    for (; left > 0; at += 4) {
        if (s->size - at < 4)
            return CUT;
        if (!marks_repeat(bytes + at)) {
            if (shift && !run)
                return DAMAGED;
            shift = 0;
            left--;
            continue;
        }
        /* a fourth byte exceeds every width unless it is 0 */
        const int n = bytes[at + 3];
        const int count = shift < 24 ? n << shift : (n > 0) << 24;
        s->is_old = true;
        run = shift ? run + count : count;
        left -= count;
        if (shift >= 24 && !count)
            return DAMAGED;
        shift += 8;
    }
    s->at = at;
    return left < 0 ? DAMAGED : WHOLE;
}

/* Passes over the scanline at s->at and checks it. */
static fault pass(scan *s)
{
    const unsigned char *p = s->bytes + s->at;
    s->is_new = s->is_old = false;
    if (s->size - s->at < 4)
        return CUT;
    if (!marks_new(p, s->width))
        return pass_old(s);
    s->is_new = true;
    return (p[2] << 8 | p[3]) == s->width ? pass_new(s) : DAMAGED;
}

/* ---- their pixels ------------------------------------------------------ */

/* Bytes of one of the four planes of a scanline, which a worker has. */
static size_t plane_bytes(const ibl_rgbe_header *h)
{
    return ((size_t)h->row_px + IBL_RGBE_SLACK + 63) / 64 * 64;
}

/* Splits pixels into planes; expands repeats. */
static void split(const unsigned char *src, int count, unsigned char *planes,
                  size_t stride)
{
    int i = 0, shift = 0;
    for (; i < count; src += 4) {
        if (!i || !marks_repeat(src)) {
            for (int c = 0; c < 4; c++)
                planes[c * stride + i] = src[c];
            i++;
            shift = 0;
            continue;
        }
        const int n = src[3] << shift;
        for (int c = 0; c < 4; c++)
            memset(planes + c * stride + i, planes[c * stride + i - 1],
                   (size_t)n);
        i += n;
        shift += 8;
    }
}

/*
 * Decodes a scanline that was passed over to h->row_px RGB pixels.
 *   src   readable for IBL_RGBE_SLACK bytes beyond the scanline
 */
static void decode_line(const ibl_rgbe_dsp *dsp, const ibl_rgbe_header *h,
                        const unsigned char *src, unsigned char *planes,
                        float *dst)
{
    const size_t stride = plane_bytes(h);
    const float *m = h->matrix;

    if (!marks_new(src, h->row_px)) {
        split(src, h->row_px, planes, stride);
    } else {
        src += 4;
        for (int c = 0; c < 4; c++)
            src = dsp->expand(src, h->row_px, planes + c * stride);
    }
    dsp->to_rgb(planes, stride, h->row_px, h->scale, dst);
    for (int i = 0; i < h->row_px && h->xyz; i++, dst += 3) {
        const float x = dst[0], y = dst[1], z = dst[2];
        for (int c = 0; c < 3; c++)
            dst[c] = m[3 * c] * x + m[3 * c + 1] * y + m[3 * c + 2] * z;
    }
}

/* ---- packs ---------------------------------------------------------- */

/* Scanlines that were passed over. */
typedef struct pack {
    unsigned char *bytes; /* read from the file, and IBL_RGBE_SLACK more */
    size_t line[PACK_LINES + 1]; /* offsets in bytes; the last is the end */
    int lines, used;
    bool is_full; /* fill_pack has run */
    fault fault;  /* of the scanline after the last one */
    int error;    /* errno if reading failed, or 0 */
} pack;

typedef struct rgbe_rows {
    ibl_rows rows;
    const ibl_input *in;
    ibl_rgbe_header h;
    ibl_rgbe_dsp dsp;
    pack packs[2]; /* the current pack and the next one */
    size_t room;   /* of bytes in each pack */
    int now;       /* index of the current pack */
    /* end of the scanlines passed over: offset, number */
    size_t at;
    int line;
    int pack_lines; /* maximum lines of the next pack */
    bool has_new, has_old;
    unsigned char *planes; /* of each worker */
} rgbe_rows;

/* Passes over the next scanlines. Runs in a job: stores errors in the pack, to
 * report after its scanlines are used. */
static void fill_pack(rgbe_rows *r, pack *p)
{
    scan s = {.bytes = p->bytes, .width = r->h.row_px};
    const int left = r->h.rows - r->line;
    const int want = left < r->pack_lines ? left : r->pack_lines;

    p->lines = p->used = 0;
    p->line[0] = 0;
    p->fault = WHOLE;
    p->error = 0;
    p->is_full = true;
    if (!ibl_input_read(r->in, r->at, r->room, p->bytes, &s.size)) {
        p->error = errno;
        return;
    }
    while (p->lines < want) {
        p->fault = pass(&s);
        if (p->fault)
            break;
        r->has_new |= s.is_new;
        r->has_old |= s.is_old;
        p->line[++p->lines] = s.at;
    }
    r->at += p->line[p->lines];
    r->line += p->lines;
    /* The next pack begins with the scanline that is cut off here. */
    if (p->fault == CUT && p->lines)
        p->fault = WHOLE;
}

/* Reports the error after the last scanline of a pack, if there is one. */
static ibl_status report(const rgbe_rows *r, const pack *p)
{
    const int line = r->line + 1, lines = r->h.rows;

    if (p->error)
        return ibl_input_unread(r->in, p->error);
    if (p->fault == CUT)
        return ibl_bad_file(r->in,
                            "the file ends in scanline %d of %d: it is cut "
                            "short: copy it again",
                            line, lines);
    if (p->fault)
        return ibl_bad_file(r->in,
                            "the file is damaged: the runs of scanline %d of "
                            "%d are not its %d pixels",
                            line, lines, r->h.row_px);
    return IBL_OK;
}

/* Passes over the rest of the file without decoding it, then rewinds. */
static ibl_status look_through(rgbe_rows *r)
{
    pack *p = &r->packs[!r->now];

    r->pack_lines = PACK_LINES;
    do {
        if (ibl_cancelled(r->rows.ctx))
            return IBL_ERR_CANCELLED;
        fill_pack(r, p);
    } while (r->line < r->h.rows && !p->fault && !p->error);
    if (p->fault || p->error)
        return report(r, p);
    p->is_full = r->has_new = r->has_old = false;
    r->at = r->h.data;
    r->line = 0;
    return IBL_OK;
}

/* ---- decoding ------------------------------------------------------- */

/* Scanlines of the current pack to decode together. */
typedef struct step {
    rgbe_rows *r;
    const pack *p;
    pack *next;           /* pack to fill meanwhile, or NULL */
    int count, job_lines; /* scanlines, from p->used on */
    float *rgb;
} step;

/* Job 0 fills the next pack, if there is one; the other jobs decode. */
static void decode_job(void *arg, int job, int worker)
{
    const step *s = arg;
    rgbe_rows *r = s->r;
    const size_t floats = 3 * (size_t)r->h.row_px;
    unsigned char *planes = r->planes + 4 * plane_bytes(&r->h) * (size_t)worker;

    if (s->next && job-- == 0) {
        fill_pack(r, s->next);
        return;
    }
    const int first = job * s->job_lines;
    for (int i = first; i < s->count && i < first + s->job_lines; i++) {
        float *line = s->rgb + floats * (size_t)i;
        decode_line(&r->dsp, &r->h, s->p->bytes + s->p->line[s->p->used + i],
                    planes, line);
    }
}

static void free_packs(rgbe_rows *r)
{
    ibl_free(r->packs[0].bytes);
    ibl_free(r->packs[1].bytes);
    ibl_free(r->planes);
    r->packs[0].bytes = r->packs[1].bytes = r->planes = NULL;
}

static ibl_status rows_read(ibl_rows *rows, int count, float *rgb)
{
    rgbe_rows *r = (rgbe_rows *)rows;
    const int px = r->h.row_px, end = rows->row + count;
    step s = {.r = r, .job_lines = px < JOB_PIXELS ? JOB_PIXELS / px : 1};

    for (int row = rows->row; row < end;) {
        pack *p = &r->packs[r->now], *next = &r->packs[!r->now];
        const int wanted = end - row;
        r->pack_lines = wanted < CALL_LINES   ? CALL_LINES
                        : wanted < PACK_LINES ? wanted
                                              : PACK_LINES;
        if (p->used == p->lines) {
            if (p->fault || p->error)
                return report(r, p);
            p->is_full = false;
            r->now = !r->now;
            if (!next->is_full)
                fill_pack(r, next);
            continue;
        }
        const int left = p->lines - p->used;
        const bool fill =
            !next->is_full && r->line < r->h.rows && !p->fault && !p->error;
        s.p = p;
        s.next = fill ? next : NULL;
        s.count = wanted < left ? wanted : left;
        s.rgb = rgb + 3 * (size_t)px * (size_t)(row - rows->row);
        const int jobs = (s.count + s.job_lines - 1) / s.job_lines;
        const ibl_status status =
            ibl_run(rows->ctx, NULL, jobs + fill, decode_job, &s);
        if (status)
            return status;
        p->used += s.count;
        row += s.count;
        ibl_rows_progress(rows, row - rows->row);
    }
    if (end < rows->height)
        return IBL_OK;
    snprintf(rows->report.format, sizeof rows->report.format, "Radiance %s, %s",
             r->h.xyz ? "XYZE" : "RGBE",
             r->has_new   ? "run-length"
             : r->has_old ? "old run-length"
                          : "flat");
    free_packs(r);
    return IBL_OK;
}

static void rows_close(ibl_rows *rows)
{
    free_packs((rgbe_rows *)rows);
    ibl_free(rows);
}

/* ---- opening -------------------------------------------------------- */

ibl_status ibl_rgbe_open(ibl_input *in, const ibl_read_options *opts,
                         ibl_rows **out)
{
    rgbe_rows *r = ibl_alloc_zeroed(1, sizeof *r);
    const size_t threads = (size_t)ibl_ctx_threads(in->ctx);

    *out = NULL;
    if (!r)
        return ibl_no_memory(in->ctx, "a picture");
    ibl_rgbe_header *h = &r->h;
    ibl_rows *rows = *out = &r->rows;
    *rows = (ibl_rows){.ctx = in->ctx, .read = rows_read, .close = rows_close};
    r->in = in;
    ibl_status status = ibl_rgbe_parse(in, h);
    const bool lies = h->orientation > 4;
    if (!status)
        status = ibl_map_check_size(in, opts, lies ? h->rows : h->row_px,
                                    lies ? h->row_px : h->rows);
    if (status)
        return status;
    const size_t bytes = in->size - h->data;
    if (bytes / 4 < (size_t)h->rows) /* a scanline has the bytes of a pixel */
        return ibl_bad_file(in,
                            "%zu bytes of pixels cannot hold %d scanlines: the "
                            "file is cut short: copy it again",
                            bytes, h->rows);
    /* New run lengths need at most two bytes for each byte of a pixel. The old
     * ones need at most four for a pixel, and 12 for zero counts before a
     * fault. */
    r->room = 8 * (size_t)h->row_px + 64;
    if (r->room < PACK_BYTES)
        r->room = PACK_BYTES;
    for (int i = 0; i < 2; i++)
        r->packs[i].bytes = ibl_alloc_array(r->room + IBL_RGBE_SLACK, 1);
    r->planes = ibl_alloc_array(4 * threads, plane_bytes(h));
    if (!r->packs[0].bytes || !r->packs[1].bytes || !r->planes)
        return ibl_no_memory(in->ctx, "scanlines");
    r->at = h->data;
    ibl_rgbe_dsp_init(&r->dsp, ibl_ctx_isa(in->ctx));
    rows->width = h->row_px;
    rows->height = h->rows;
    rows->orientation = h->orientation;
    rows->has_primaries = h->has_primaries;
    memcpy(rows->primaries, h->primaries, sizeof h->primaries);
    /* Before taking much memory, check that the file has all scanlines. */
    return 12.0 * h->rows * h->row_px > 64.0 * (double)in->size
               ? look_through(r)
               : IBL_OK;
}
