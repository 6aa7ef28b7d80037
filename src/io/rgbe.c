/* SPDX-License-Identifier: MIT */
/*
 * Reads the scanlines of a Radiance picture in order.
 *
 * They have no table: the start of a scanline is known only after passing over
 * those before it. One job passes over a pack of scanlines while the other
 * jobs decode the previous pack.
 */
#include <errno.h>
#include <string.h>

#include "core/alloc.h"
#include "core/context.h"
#include "io/rgbe.h"
#include "kern/rgbe.h"

enum {
    PACK_BYTES = 1 << 20, /* read from a file at once */
    PACK_LINES = 256,
    JOB_PIXELS = 1 << 14, /* about 0.05 ms of decoding */
    MIN_RUNS = 8,         /* range of widths with run lengths */
    MAX_RUNS = 32767,
    LONGEST_RUN = 127
};

bool ibl_rgbe_is(const unsigned char *bytes, size_t size)
{
    return size >= 2 && !memcmp(bytes, "#?", 2);
}

/* ---- where scanlines end -------------------------------------------- */

/* Why there is no scanline; 0: there is one; above 0: errno. */
enum {
    CUT = -1,     /* the bytes end within it */
    DAMAGED = -2, /* runs of no pixels, or not as many pixels as it has */
    OLD = -3      /* another coding */
};

/* 2, 2 and a length: a normalised pixel never has these bytes. */
static bool has_runs(const unsigned char *p, int width)
{
    return width >= MIN_RUNS && width <= MAX_RUNS && p[0] == 2 && p[1] == 2 &&
           p[2] < 128;
}

/* Passes over four components of runs and literals. Has no branch on run or
 * literal, which would be unpredictable. */
static int pass_runs(const unsigned char *bytes, size_t size, int width,
                     size_t *line)
{
    size_t at = *line + 4;

    for (int c = 0; c < 4; c++) {
        int left = width;
        while (left > 0) {
            if (at >= size)
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
    if (at > size)
        return CUT;
    *line = at;
    return 0;
}

/* Passes over the scanline at *line, which becomes its end, and checks it. The
 * run lengths of before 1991 are pixels (1, 1, 1, n), which no encoder makes
 * of a colour. */
static int pass(const unsigned char *bytes, size_t size, int width,
                size_t *line)
{
    const unsigned char *p = bytes + *line;

    if (size - *line < 4)
        return CUT;
    if (has_runs(p, width))
        return (p[2] << 8 | p[3]) == width ? pass_runs(bytes, size, width, line)
                                           : DAMAGED;
    for (int i = 1; i < width; i++) {
        if (size - *line < 4 * (size_t)(i + 1))
            return CUT;
        if (p[4 * i] == 1 && p[4 * i + 1] == 1 && p[4 * i + 2] == 1)
            return OLD;
    }
    *line += 4 * (size_t)width;
    return 0;
}

/* ---- their pixels ------------------------------------------------------ */

/* Bytes of one of the four planes of a scanline, which a worker has. */
static size_t plane_bytes(const ibl_rgbe_header *h)
{
    return ((size_t)h->row_px + IBL_RGBE_SLACK + 63) / 64 * 64;
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

    if (has_runs(src, h->row_px)) {
        src += 4;
        for (int c = 0; c < 4; c++)
            src = dsp->expand(src, h->row_px, planes + (size_t)c * stride);
    } else {
        for (int i = 0; i < h->row_px; i++)
            for (size_t c = 0; c < 4; c++)
                planes[c * stride + (size_t)i] = *src++;
    }
    dsp->to_rgb(planes, stride, h->row_px, h->scale, dst);
}

/* ---- packs ---------------------------------------------------------- */

/* Scanlines that were passed over. */
typedef struct pack {
    unsigned char *bytes; /* read from the file, and IBL_RGBE_SLACK more */
    size_t line[PACK_LINES + 1]; /* offsets in bytes; the last is the end */
    int lines, used;
    bool is_full; /* fill_pack has run */
    int fault;    /* of the scanline after the last one */
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
    unsigned char *planes; /* of each worker */
} rgbe_rows;

/* Passes over the next scanlines. Runs in a job: stores errors in the pack, to
 * report after its scanlines are used. */
static void fill_pack(rgbe_rows *r, pack *p)
{
    const int left = r->h.rows - r->line;
    const int want = left < PACK_LINES ? left : PACK_LINES;
    size_t size, at = 0;

    p->lines = p->used = 0;
    p->line[0] = 0;
    p->is_full = true;
    p->fault =
        ibl_input_read(r->in, r->at, r->room, p->bytes, &size) ? 0 : errno;
    while (!p->fault && p->lines < want) {
        p->fault = pass(p->bytes, size, r->h.row_px, &at);
        if (!p->fault)
            p->line[++p->lines] = at;
    }
    r->at += p->line[p->lines];
    r->line += p->lines;
    /* The next pack begins with the scanline that is cut off here. */
    if (p->fault == CUT && p->lines)
        p->fault = 0;
}

/* Reports the fault after the last scanline of a pack. */
static ibl_status report(const rgbe_rows *r, const pack *p)
{
    const int line = r->line + 1, lines = r->h.rows;

    if (p->fault > 0)
        return ibl_input_unread(r->in, p->fault);
    if (p->fault == CUT)
        return ibl_bad_file(r->in,
                            "the file ends in scanline %d of %d: it is cut "
                            "short: copy it again",
                            line, lines);
    if (p->fault == OLD)
        return ibl_unsupported(r->in,
                               "scanline %d of %d has the run lengths of "
                               "before 1991, which are not read: save it by a "
                               "newer program",
                               line, lines);
    return ibl_bad_file(r->in,
                        "the file is damaged: the runs of scanline %d of %d "
                        "are not its %d pixels",
                        line, lines, r->h.row_px);
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
        if (p->used == p->lines) {
            if (p->fault)
                return report(r, p);
            p->is_full = false;
            r->now = !r->now;
            if (!next->is_full)
                fill_pack(r, next);
            continue;
        }
        const int left = p->lines - p->used;
        const bool fill = !next->is_full && r->line < r->h.rows && !p->fault;
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
    if (end == rows->height)
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
    const size_t bytes = in->size - h->data, px = (size_t)h->row_px;
    const size_t least = px < MIN_RUNS || px > MAX_RUNS
                             ? 4 * px
                             : 4 + 8 * ((px + LONGEST_RUN - 1) / LONGEST_RUN);
    if (bytes / least < (size_t)h->rows)
        return ibl_bad_file(in,
                            "%zu bytes of pixels cannot hold %d scanlines: the "
                            "file is cut short: copy it again",
                            bytes, h->rows);
    r->room = 8 * px + 64; /* runs of 1 take two bytes for each of a pixel's */
    if (r->room < PACK_BYTES)
        r->room = PACK_BYTES;
    for (int i = 0; i < 2; i++)
        r->packs[i].bytes = ibl_alloc_array(r->room + IBL_RGBE_SLACK, 1);
    r->planes = ibl_alloc_array(4 * threads, plane_bytes(h));
    if (!r->packs[0].bytes || !r->packs[1].bytes || !r->planes)
        return ibl_no_memory(in->ctx, "scanlines");
    r->at = h->data;
    ibl_rgbe_dsp_init(&r->dsp, ibl_ctx_isa(in->ctx));
    strcpy(rows->report.format, "Radiance RGBE");
    rows->width = h->row_px;
    rows->height = h->rows;
    rows->orientation = h->orientation;
    rows->has_primaries = h->has_primaries;
    memcpy(rows->primaries, h->primaries, sizeof h->primaries);
    return IBL_OK;
}
