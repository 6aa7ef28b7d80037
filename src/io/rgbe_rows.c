/* SPDX-License-Identifier: MIT */
/*
 * The scanlines of a Radiance picture in order.
 *
 * They have no table: where one begins is known once those before it have
 * been passed over, which is done a pack at a time, by one job, while the
 * others decode the pack before.
 */
#include <errno.h>
#include <stdio.h>
#include <string.h>

#include "core/alloc.h"
#include "core/context.h"
#include "io/rgbe.h"
#include "kern/max_finite.h"

enum {
    PACK_BYTES = 1 << 20, /* of a file that are read at once */
    PACK_LINES = 512,
    CALL_LINES = 64,       /* in a pack, where a call wants fewer */
    JOB_PIXELS = 1 << 14,  /* about 0.05 ms of decoding */
    JOB_COLUMNS = 8,       /* scanlines that are turned into columns at once */
    HEADER_BYTES = 1 << 16 /* where a header has mostly ended */
};

/* Scanlines that have been passed over. */
typedef struct pack {
    unsigned char *buffer; /* NULL: bytes are those of the input */
    const unsigned char *bytes;
    size_t size;                 /* of bytes, IBL_RGBE_SLACK are beyond it */
    size_t line[PACK_LINES + 1]; /* where they begin, and the last one ends */
    int lines, used;
    bool is_full; /* has been filled */
    /* what came after its last scanline */
    bool ambiguous; /* one that may be coded or flat */
    ibl_rgbe_fault fault;
    int value; /* of the fault */
    int error; /* errno where reading failed */
} pack;

typedef struct rgbe_rows {
    ibl_rows rows;
    const ibl_input *in;
    ibl_rgbe_header h;
    ibl_rgbe_dsp dsp;
    ibl_max_finite_fn *look;
    pack packs[2]; /* the one in use, and the next */
    size_t room;   /* of their buffers */
    int now;       /* the one in use */
    /* the end of what has been passed over */
    size_t at;
    int line;
    int pack_lines; /* that the next pack is to have */
    bool flat;      /* no scanline is coded, whatever it looks like */
    bool settled;   /* it is known whether it is flat */
    bool has_new, has_old;
    unsigned char *scratch; /* one of scratch_bytes for each worker */
    size_t scratch_bytes;
} rgbe_rows;

static void describe(const rgbe_rows *r, char format[64])
{
    snprintf(format, 64, "Radiance %s, %s", r->h.xyz ? "XYZE" : "RGBE",
             r->has_new   ? "run-length"
             : r->has_old ? "old run-length"
                          : "flat");
}

/* ---- packs ---------------------------------------------------------- */

/* Gets bytes from r->at on. False: p->error says why not. */
static bool load_pack(const rgbe_rows *r, pack *p)
{
    if (!p->buffer) {
        p->bytes = r->in->bytes + r->at;
        p->size = r->in->size - r->at;
        return true;
    }
    p->bytes = p->buffer;
    if (ibl_input_read(r->in, r->at, r->room, p->buffer, &p->size))
        return true;
    p->error = errno;
    return false;
}

/* Passes over the next scanlines. Runs in a job: what goes wrong is left in
 * the pack, for when its scanlines have been used. */
static void fill_pack(rgbe_rows *r, pack *p)
{
    ibl_rgbe_scan s = {.width = r->h.row_px};
    const int left = r->h.rows - r->line;
    const int want = left < r->pack_lines ? left : r->pack_lines;
    const size_t flat_bytes = 4 * (size_t)r->h.row_px;

    p->lines = p->used = 0;
    p->line[0] = 0;
    p->ambiguous = false;
    p->fault = IBL_RGBE_WHOLE;
    p->error = 0;
    p->is_full = true;
    if (!load_pack(r, p))
        return;
    s.bytes = p->bytes;
    s.size = p->size;
    while (p->lines < want) {
        if (r->flat && s.size - s.at < flat_bytes)
            p->fault = IBL_RGBE_CUT;
        else if (r->flat)
            s.at += flat_bytes;
        else
            p->fault = ibl_rgbe_pass(&s);
        p->ambiguous = !r->settled && (s.is_new || s.is_old);
        if (p->ambiguous || p->fault)
            break;
        r->has_new |= s.is_new;
        r->has_old |= s.is_old;
        p->line[++p->lines] = s.at;
    }
    p->value = s.value;
    r->at += p->line[p->lines];
    r->line += p->lines;
    /* The next pack begins with the scanline that this one has not whole. */
    if (p->ambiguous || (p->fault == IBL_RGBE_CUT && p->lines))
        p->fault = IBL_RGBE_WHOLE;
}

static ibl_status tell(const rgbe_rows *r, const pack *p)
{
    if (p->error)
        return ibl_fail(r->rows.ctx, IBL_ERR_IO, "%s: cannot be read: %s",
                        r->in->name, strerror(p->error));
    return p->fault ? ibl_rgbe_tell(r->rows.ctx, r->in->name, p->fault, r->line,
                                    &r->h, p->value)
                    : IBL_OK;
}

static bool has_flat_size(const rgbe_rows *r)
{
    const size_t bytes = r->in->size - r->h.data;
    return bytes % 4 == 0 &&
           bytes / 4 == (size_t)r->h.row_px * (size_t)r->h.rows;
}

/*
 * Passes over all that is left, without decoding it. Pixels may only look
 * like codes: the size has the last word.
 */
static ibl_status settle(rgbe_rows *r)
{
    pack *p = &r->packs[!r->now];
    const size_t at = r->at;
    const int line = r->line;

    r->settled = true;
    r->pack_lines = PACK_LINES;
    do {
        if (ibl_cancelled(r->rows.ctx))
            return IBL_ERR_CANCELLED;
        fill_pack(r, p);
    } while (r->line < r->h.rows && !p->fault && !p->error);
    if (!p->error && (p->fault || r->at != r->in->size) && has_flat_size(r)) {
        r->flat = true;
        r->has_new = r->has_old = false;
    } else if (p->fault || p->error) {
        return tell(r, p);
    }
    p->is_full = false;
    r->at = at;
    r->line = line;
    return IBL_OK;
}

/* Makes r->packs[r->now] one that has scanlines to use. */
static ibl_status next_pack(rgbe_rows *r)
{
    for (;;) {
        pack *p = &r->packs[r->now];
        ibl_status status = IBL_OK;

        if (p->used < p->lines)
            return IBL_OK;
        if (p->fault || p->error)
            return tell(r, p);
        p->is_full = false;
        if (p->ambiguous && !r->settled)
            status = settle(r);
        if (status)
            return status;
        r->now = !r->now;
        if (!r->packs[r->now].is_full)
            fill_pack(r, &r->packs[r->now]);
    }
}

/* ---- decoding ------------------------------------------------------- */

/* Scanlines of a pack that are decoded together. */
typedef struct step {
    rgbe_rows *r;
    const pack *p;
    pack *next;           /* to be filled meanwhile, or NULL */
    int count, job_lines; /* from p->used on */
    float *dst;
    ptrdiff_t stride; /* floats from one to the next */
    uint32_t *most;   /* or NULL */
    float *columns;   /* JOB_COLUMNS scanlines for each worker */
    int done;         /* scanlines of the call, before these */
} step;

static void reverse(float *px, int count)
{
    for (float *a = px, *b = px + 3 * (count - 1); a < b; a += 3, b -= 3) {
        for (int c = 0; c < 3; c++) {
            const float t = a[c];
            a[c] = b[c];
            b[c] = t;
        }
    }
}

static void decode_line(const step *s, int i, int worker, float *dst)
{
    const rgbe_rows *r = s->r;
    const pack *p = s->p;
    const int k = p->used + i;
    const bool has_slack =
        p->buffer || p->size - p->line[k + 1] >= IBL_RGBE_SLACK;

    ibl_rgbe_row(&r->dsp, &r->h, p->bytes + p->line[k], r->flat, has_slack,
                 r->scratch + (size_t)worker * r->scratch_bytes, dst);
}

/* Job 0 fills the next pack, if there is one to fill. False if it was that;
 * else *job counts the others. */
static bool is_decoding(const step *s, int *job)
{
    if (!s->next)
        return true;
    if (*job == 0)
        fill_pack(s->r, s->next);
    return (*job)-- > 0;
}

static void rows_job(void *arg, int job, int worker)
{
    const step *s = arg;
    const ibl_rgbe_header *h = &s->r->h;

    if (!is_decoding(s, &job))
        return;
    const int first = job * s->job_lines;
    for (int i = first; i < s->count && i < first + s->job_lines; i++) {
        float *dst = s->dst + s->stride * i;
        decode_line(s, i, worker, dst);
        if (h->reverse_pixels)
            reverse(dst, h->row_px);
        if (s->most)
            s->most[i] = s->r->look(dst, 3 * (size_t)h->row_px);
    }
}

/* Scanline i goes to column x_of(i), its pixel j to row y_of(j). */
static void columns_job(void *arg, int job, int worker)
{
    const step *s = arg;
    const ibl_rgbe_header *h = &s->r->h;
    const size_t line = 3 * (size_t)h->row_px;
    float *columns = s->columns + (size_t)worker * line * JOB_COLUMNS;

    if (!is_decoding(s, &job))
        return;
    const int first = job * s->job_lines, begin = s->done + first;
    const int left = s->count - first;
    const int count = left < s->job_lines ? left : s->job_lines;

    for (int i = 0; i < count; i++)
        decode_line(s, first + i, worker, columns + i * line);
    for (int j = 0; j < h->row_px; j++) {
        const int y = h->reverse_pixels ? h->row_px - 1 - j : j;
        float *row = s->dst + (size_t)y * 3 * (size_t)h->width;
        for (int i = 0; i < count; i++) {
            const int x = h->reverse_rows ? h->rows - 1 - begin - i : begin + i;
            memcpy(row + 3 * x, columns + i * line + 3 * j, 3 * sizeof *row);
        }
    }
}

/* Decodes count scanlines. s->dst is where the first of them goes, or, with
 * s->columns, the whole picture. */
static ibl_status decode(step *s, int count)
{
    rgbe_rows *r = s->r;
    ibl_status status = IBL_OK;

    while (count && !status) {
        r->pack_lines = count < CALL_LINES   ? CALL_LINES
                        : count < PACK_LINES ? count
                                             : PACK_LINES;
        status = next_pack(r);
        if (status)
            return status;
        pack *p = &r->packs[r->now], *next = &r->packs[!r->now];
        const int left = p->lines - p->used;
        s->p = p;
        s->next = !next->is_full && r->line < r->h.rows && !p->fault &&
                          !p->error && !p->ambiguous
                      ? next
                      : NULL;
        s->count = count < left ? count : left;
        const int jobs = (s->count + s->job_lines - 1) / s->job_lines;
        status = ibl_run(r->rows.ctx, NULL, jobs + (s->next != NULL),
                         s->columns ? columns_job : rows_job, s);
        p->used += s->count;
        count -= s->count;
        s->done += s->count;
        ibl_progress(r->rows.ctx, "decode",
                     (double)(r->rows.row + s->done) / r->h.rows);
        s->dst += s->stride * s->count;
        if (s->most)
            s->most += s->count;
    }
    return status;
}

static int job_lines(const ibl_rgbe_header *h)
{
    return h->row_px < JOB_PIXELS ? JOB_PIXELS / h->row_px : 1;
}

static ibl_status rows_read(ibl_rows *rows, int count, float *rgb,
                            uint32_t *most)
{
    rgbe_rows *r = (rgbe_rows *)rows;
    step s = {.r = r,
              .job_lines = job_lines(&r->h),
              .dst = rgb,
              .stride = 3 * (ptrdiff_t)r->h.row_px,
              .most = most};
    const ibl_status status = decode(&s, count);
    if (!status && rows->row + count == rows->height)
        describe(r, rows->report.format);
    return status;
}

static void rows_close(ibl_rows *rows)
{
    rgbe_rows *r = (rgbe_rows *)rows;
    ibl_free(r->packs[0].buffer);
    ibl_free(r->packs[1].buffer);
    ibl_free(r->scratch);
    ibl_free(r);
}

/* ---- opening -------------------------------------------------------- */

/* The header of a file, of which as much is read as it takes. */
static ibl_status parse_file(ibl_ctx *ctx, const ibl_input *in,
                             ibl_rgbe_header *h)
{
    for (size_t room = HEADER_BYTES;; room *= 2) {
        unsigned char *bytes = ibl_alloc_array(room, 1);
        size_t got;
        ibl_status status;
        if (!bytes)
            return ibl_no_memory(ctx, "the header of a picture");
        if (!ibl_input_read(in, 0, room, bytes, &got)) {
            status = ibl_fail(ctx, IBL_ERR_IO, "%s: cannot be read: %s",
                              in->name, strerror(errno));
        } else if (got < room || room >= IBL_RGBE_MOST_HEADER ||
                   ibl_rgbe_has_header(bytes, got)) {
            status = ibl_rgbe_parse(ctx, in->name, bytes, got, h);
        } else {
            ibl_free(bytes);
            continue;
        }
        ibl_free(bytes);
        return status;
    }
}

static ibl_status check_length(const rgbe_rows *r)
{
    const size_t bytes = r->in->size - r->h.data;
    if (!bytes)
        return ibl_fail(r->rows.ctx, IBL_ERR_FORMAT,
                        "%s: the file ends after its header: it is cut short: "
                        "copy it again",
                        r->in->name);
    /* no scanline is shorter than a pixel */
    if (bytes / 4 < (size_t)r->h.rows)
        return ibl_fail(r->rows.ctx, IBL_ERR_FORMAT,
                        "%s: %zu bytes of pixels cannot hold %d scanlines: "
                        "the file is cut short: copy it again",
                        r->in->name, bytes, r->h.rows);
    return IBL_OK;
}

static ibl_status alloc_packs(rgbe_rows *r)
{
    const size_t threads = (size_t)ibl_ctx_threads(r->rows.ctx);

    r->scratch_bytes = ibl_rgbe_scratch(&r->h);
    r->scratch = ibl_alloc_array(threads, r->scratch_bytes);
    if (!r->scratch)
        return ibl_no_memory(r->rows.ctx, "scanlines");
    if (r->in->bytes)
        return IBL_OK;
    r->room = ibl_rgbe_most_bytes(&r->h);
    if (r->room < PACK_BYTES)
        r->room = PACK_BYTES;
    for (int i = 0; i < 2; i++) {
        r->packs[i].buffer = ibl_alloc_array(r->room + IBL_RGBE_SLACK, 1);
        if (!r->packs[i].buffer)
            return ibl_no_memory(r->rows.ctx, "scanlines");
    }
    return IBL_OK;
}

/* Decodes what does not come in the order of rows, and puts a whole image in
 * r's place. */
static ibl_status decode_whole(rgbe_rows *r, ibl_rows **out)
{
    const ibl_rgbe_header *h = &r->h;
    const size_t threads = (size_t)ibl_ctx_threads(r->rows.ctx);
    step s = {.r = r, .job_lines = job_lines(h)};
    ibl_image img;
    ibl_read_report report = {.format = ""};
    ibl_status status =
        ibl_map_alloc(r->rows.ctx, r->in->name, h->width, h->height, &img);
    if (status)
        return status;
    s.dst = img.data;
    if (h->by_column) {
        s.job_lines = JOB_COLUMNS;
        s.columns = ibl_alloc_array(threads * JOB_COLUMNS,
                                    3 * sizeof(float) * (size_t)h->row_px);
        if (!s.columns)
            status = ibl_no_memory(r->rows.ctx, "scanlines");
    } else {
        s.stride = -3 * (ptrdiff_t)h->width;
        s.dst -= s.stride * (h->height - 1);
    }
    if (!status)
        status = decode(&s, h->rows);
    ibl_free(s.columns);
    describe(r, report.format);
    if (status) {
        ibl_image_free(&img);
        return status;
    }
    status = ibl_rows_of_image(r->rows.ctx, &img, out);
    if (!status)
        (*out)->report = report;
    return status;
}

ibl_status ibl_rgbe_open(ibl_ctx *ctx, const ibl_input *in,
                         const ibl_read_options *opts, ibl_rows **out)
{
    rgbe_rows *r = ibl_alloc_zeroed(1, sizeof *r);
    ibl_rgbe_header *h;
    ibl_status status;

    *out = NULL;
    if (!r)
        return ibl_no_memory(ctx, "a picture");
    h = &r->h;
    r->in = in;
    r->rows = (ibl_rows){.ctx = ctx, .read = rows_read, .close = rows_close};
    status = in->bytes ? ibl_rgbe_parse(ctx, in->name, in->bytes, in->size, h)
                       : parse_file(ctx, in, h);
    if (!status)
        status = ibl_map_check_size(ctx, in->name, opts, h->width, h->height);
    if (!status)
        status = check_length(r);
    if (!status)
        status = alloc_packs(r);
    if (status)
        goto fail;
    r->rows.width = h->width;
    r->rows.height = h->height;
    r->at = h->data;
    r->settled = !has_flat_size(r);
    ibl_rgbe_dsp_init(&r->dsp, ibl_ctx_isa(ctx));
    r->look = ibl_max_finite(ibl_ctx_isa(ctx));
    /* Large memory only for what is known to be there. */
    if ((double)h->width * h->height * 12 > 64.0 * (double)in->size)
        status = settle(r);
    if (!status && !h->by_column && !h->reverse_rows) {
        *out = &r->rows;
        return IBL_OK;
    }
    if (!status)
        status = decode_whole(r, out);
fail:
    rows_close(&r->rows);
    return status;
}
