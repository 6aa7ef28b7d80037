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

static ibl_status report(const rgbe_rows *r, const pack *p)
{
    if (p->error)
        return ibl_input_unread(r->in, p->error);
    return p->fault ? ibl_rgbe_report(r->in, p->fault, r->line, &r->h, p->value)
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
        return report(r, p);
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
            return report(r, p);
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
    pack *next;                      /* to be filled meanwhile, or NULL */
    int count, job_lines;            /* from p->used on */
    float *dst;                      /* the first pixel of the first */
    ptrdiff_t line_step, pixel_step; /* floats from one to the next */
    uint32_t *most;                  /* of each, or NULL */
} step;

/* Where scanlines go in rows of the picture, whose first is at rgb. */
static step step_of(rgbe_rows *r, float *rgb)
{
    const ibl_rgbe_header *h = &r->h;
    const ptrdiff_t row = 3 * (ptrdiff_t)h->width;
    step s = {.r = r,
              .job_lines = h->row_px < JOB_PIXELS ? JOB_PIXELS / h->row_px : 1,
              .dst = rgb,
              .line_step = h->by_column ? 3 : row,
              .pixel_step = h->by_column ? row : 3};
    if (h->reverse_rows) {
        s.dst += s.line_step * (h->rows - 1);
        s.line_step = -s.line_step;
    }
    if (h->reverse_pixels) {
        s.dst += s.pixel_step * (h->row_px - 1);
        s.pixel_step = -s.pixel_step;
    }
    return s;
}

/* Job 0 fills the next pack, if there is one to fill; the others decode. */
static void decode_job(void *arg, int job, int worker)
{
    const step *s = arg;
    rgbe_rows *r = s->r;
    const pack *p = s->p;
    unsigned char *scratch = r->scratch + (size_t)worker * r->scratch_bytes;
    void *spare = scratch + ibl_rgbe_scratch(&r->h);

    if (s->next && job-- == 0) {
        fill_pack(r, s->next);
        return;
    }
    const int first = job * s->job_lines;
    for (int i = first; i < s->count && i < first + s->job_lines; i++) {
        const int k = p->used + i;
        const bool has_slack =
            p->buffer || p->size - p->line[k + 1] >= IBL_RGBE_SLACK;
        float *to = s->dst + s->line_step * i;
        float *line = s->pixel_step == 3 ? to : spare;

        ibl_rgbe_row(&r->dsp, &r->h, p->bytes + p->line[k], r->flat, has_slack,
                     scratch, line);
        if (s->most)
            s->most[i] = r->look(line, 3 * (size_t)r->h.row_px);
        for (ptrdiff_t j = 0; line != to && j < r->h.row_px; j++)
            memcpy(to + s->pixel_step * j, line + 3 * j, 3 * sizeof *to);
    }
}

static ibl_status decode(step *s, int count)
{
    rgbe_rows *r = s->r;

    for (int done = 0; done < count; done += s->count) {
        const int wanted = count - done;
        r->pack_lines = wanted < CALL_LINES   ? CALL_LINES
                        : wanted < PACK_LINES ? wanted
                                              : PACK_LINES;
        ibl_status status = next_pack(r);
        if (status)
            return status;
        pack *p = &r->packs[r->now], *next = &r->packs[!r->now];
        const int left = p->lines - p->used;
        s->p = p;
        s->next = !next->is_full && r->line < r->h.rows && !p->fault &&
                          !p->error && !p->ambiguous
                      ? next
                      : NULL;
        s->count = wanted < left ? wanted : left;
        const int jobs = (s->count + s->job_lines - 1) / s->job_lines;
        status =
            ibl_run(r->rows.ctx, NULL, jobs + (s->next != NULL), decode_job, s);
        if (status)
            return status;
        p->used += s->count;
        ibl_progress(r->rows.ctx, "decode",
                     (double)(r->rows.row + done + s->count) / r->h.rows);
        s->dst += s->line_step * s->count;
        if (s->most)
            s->most += s->count;
    }
    return IBL_OK;
}

static ibl_status rows_read(ibl_rows *rows, int count, float *rgb,
                            uint32_t *most)
{
    rgbe_rows *r = (rgbe_rows *)rows;
    step s = step_of(r, rgb);
    s.most = most;
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

/* Parses the header; of a file as much is read as that takes. */
static ibl_status parse(const ibl_input *in, ibl_rgbe_header *h)
{
    if (in->bytes)
        return ibl_rgbe_parse(in, in->bytes, in->size, h);
    for (size_t room = HEADER_BYTES;; room *= 2) {
        unsigned char *bytes = ibl_alloc_array(room, 1);
        size_t got;
        if (!bytes)
            return ibl_no_memory(in->ctx, "the header of a picture");
        const bool is_read = ibl_input_read(in, 0, room, bytes, &got);
        const bool enough = !is_read || got < room ||
                            room >= IBL_RGBE_MOST_HEADER ||
                            ibl_rgbe_has_header(bytes, got);
        ibl_status status = IBL_OK;
        if (!is_read)
            status = ibl_input_unread(in, errno);
        else if (enough)
            status = ibl_rgbe_parse(in, bytes, got, h);
        ibl_free(bytes);
        if (enough)
            return status;
    }
}

static ibl_status check_length(const rgbe_rows *r)
{
    const size_t bytes = r->in->size - r->h.data;
    if (!bytes)
        return ibl_refuse(
            r->in, IBL_ERR_FORMAT,
            "the file ends after its header: it is cut short: copy it again");
    /* no scanline is shorter than a pixel */
    if (bytes / 4 < (size_t)r->h.rows)
        return ibl_refuse(r->in, IBL_ERR_FORMAT,
                          "%zu bytes of pixels cannot hold %d scanlines: the "
                          "file is cut short: copy it again",
                          bytes, r->h.rows);
    return IBL_OK;
}

static ibl_status alloc_packs(rgbe_rows *r)
{
    const size_t threads = (size_t)ibl_ctx_threads(r->rows.ctx);
    const size_t line_bytes = 3 * sizeof(float) * (size_t)r->h.row_px;

    r->scratch_bytes = ibl_rgbe_scratch(&r->h) + (line_bytes + 63) / 64 * 64;
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

/* Decodes what does not come in the order of rows to a whole image. */
static ibl_status decode_whole(rgbe_rows *r, ibl_rows **out)
{
    ibl_image img;
    ibl_status status = ibl_map_alloc(r->in, r->h.width, r->h.height, &img);
    if (!status)
        status = ibl_rows_of_image(r->rows.ctx, &img, out);
    if (status)
        return status;
    step s = step_of(r, (*out)->whole.data);
    status = decode(&s, r->h.rows);
    describe(r, (*out)->report.format);
    if (status) {
        ibl_rows_close(*out);
        *out = NULL;
    }
    return status;
}

ibl_status ibl_rgbe_open(const ibl_input *in, const ibl_read_options *opts,
                         ibl_rows **out)
{
    rgbe_rows *r = ibl_alloc_zeroed(1, sizeof *r);
    ibl_rgbe_header *h;
    ibl_status status;

    *out = NULL;
    if (!r)
        return ibl_no_memory(in->ctx, "a picture");
    h = &r->h;
    r->in = in;
    r->rows =
        (ibl_rows){.ctx = in->ctx, .read = rows_read, .close = rows_close};
    status = parse(in, h);
    if (!status)
        status = ibl_map_check_size(in, opts, h->width, h->height);
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
    ibl_rgbe_dsp_init(&r->dsp, ibl_ctx_isa(in->ctx));
    r->look = ibl_max_finite(ibl_ctx_isa(in->ctx));
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
