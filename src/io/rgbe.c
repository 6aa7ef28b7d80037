/* SPDX-License-Identifier: MIT */
/*
 * Radiance pictures (.hdr, .pic): RGBE, flat or run-length. A header, lines of
 * text, then scanlines. They have no table: the start of a scanline is known
 * only after passing over those before it. One job passes over a pack of
 * scanlines while the other jobs decode the previous pack.
 *
 * Format: Radiance reference manual, "Picture files"; Ward 1991, "Real
 * Pixels", Graphics Gems II.
 */
#include <errno.h>
#include <float.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "core/alloc.h"
#include "core/context.h"
#include "io/colour_space.h"
#include "io/rows.h"
#include "kern/rgbe.h"

enum {
    MOST_HEADER = 1 << 20, /* longer ones are taken for damage */
    PACK_BYTES = 1 << 20,  /* read from a file at once */
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

/* Scanlines that were passed over. */
typedef struct pack {
    unsigned char *bytes; /* read from the file, and IBL_RGBE_SLACK more */
    size_t line[PACK_LINES + 1]; /* offsets in bytes; the last is the end */
    int lines, used;
    bool is_full; /* fill_pack has run */
    int fault;    /* of the scanline after the last one */
} pack;

/* Rows of the map are scanlines, as they lie in the file. */
typedef struct rgbe_rows {
    ibl_rows rows;
    const ibl_input *in;
    /* of the header: repeated EXPOSURE and COLORCORR multiply */
    double exposure, correction[3];
    float scale[3]; /* their inverse */
    bool has_format;
    size_t data; /* offset of the first scanline, in bytes */

    ibl_rgbe_dsp dsp;
    pack packs[2]; /* the current pack and the next one */
    size_t room;   /* of bytes in each pack */
    int now;       /* index of the current pack */
    /* end of the scanlines passed over: offset, number */
    size_t at;
    int line;
    unsigned char *planes; /* of each worker, four for a scanline */
    size_t stride;         /* bytes of a plane */
} rgbe_rows;

/* ---- the header ---------------------------------------------------------- */

static const char blanks[] = " \t";

/* What follows NAME=, with blanks around the sign; NULL: another line. Lines
 * that begin with blanks are the history of the source picture. */
static char *value_of(char *line, const char *name)
{
    const size_t length = strlen(name);

    if (strncmp(line, name, length) != 0)
        return NULL;
    line += length + strspn(line + length, blanks);
    return *line == '=' ? line + 1 + strspn(line + 1, blanks) : NULL;
}

/* Reads positive factors. Ignores a 0: it cannot have been a factor, but
 * Filament's cmgen writes it for EXPOSURE. */
static ibl_status take_factors(const ibl_input *in, const char *what,
                               char *value, double *factors, int count)
{
    const char *all = value;
    char text[IBL_QUOTE_BYTES];
    for (int i = 0; i < count; i++) {
        double f;
        if (!ibl_take_number(&value, &f) || !(f >= 0) || isinf(f))
            return ibl_bad_file(in, "%s is \"%s\": must be %s above 0", what,
                                ibl_quote(all, text),
                                count > 1 ? "three numbers" : "a number");
        if (f > 0)
            factors[i] *= f;
        else
            ibl_warn(in->ctx, "%s: %s of 0 is ignored", in->name, what);
    }
    return IBL_OK;
}

static ibl_status take_line(rgbe_rows *r, char *line)
{
    const ibl_input *in = r->in;
    char *value, text[IBL_QUOTE_BYTES];
    double xy[8], unused[9];

    if ((value = value_of(line, "EXPOSURE")))
        return take_factors(in, "EXPOSURE", value, &r->exposure, 1);
    if ((value = value_of(line, "COLORCORR")))
        return take_factors(in, "COLORCORR", value, r->correction, 3);
    if ((value = value_of(line, "PRIMARIES"))) {
        bool ok = true;
        for (int i = 0; i < 8; i++)
            ok = ok && ibl_take_number(&value, &xy[i]);
        if (ok && ibl_colour_space(xy, unused, NULL)) {
            r->rows.report.has_primaries = 1;
            memcpy(r->rows.report.primaries, xy, sizeof xy);
        }
    } else if ((value = value_of(line, "FORMAT"))) {
        value[strcspn(value, blanks)] = '\0';
        r->has_format = true;
        if (strcmp(value, "32-bit_rle_rgbe") != 0)
            return ibl_unsupported(in,
                                   "FORMAT is \"%s\": must be "
                                   "32-bit_rle_rgbe; Radiance's ra_xyze -r "
                                   "makes it of XYZE",
                                   ibl_quote(value, text));
    }
    return IBL_OK;
}

/* Whether only a resolution begins so: +X, -X, +Y or -Y, then a blank. */
static bool is_resolution(const char *line, size_t size)
{
    return size > 2 && (line[0] == '+' || line[0] == '-') &&
           (line[1] == 'X' || line[1] == 'Y') &&
           (line[2] == ' ' || line[2] == '\t');
}

/* Reads one of the eight orientations. X grows to the right and Y up: rows in
 * -Y order begin at the top. */
static ibl_status take_resolution(rgbe_rows *r, const char *line)
{
    /* by which of scanlines and pixels run from the bottom or right */
    static const int rows_of[] = {1, 2, 4, 3}, columns_of[] = {5, 8, 6, 7};
    char text[IBL_QUOTE_BYTES], sign[2], axis[2];
    long edge[2];
    int end = 0;

    if (!is_resolution(line, strlen(line)) ||
        sscanf(line, "%c%c %9ld %c%c %9ld %n", &sign[0], &axis[0], &edge[0],
               &sign[1], &axis[1], &edge[1], &end) < 6 ||
        line[end] || axis[0] + axis[1] != 'X' + 'Y' ||
        (sign[1] != '+' && sign[1] != '-'))
        return ibl_bad_file(
            r->in,
            "the resolution line is \"%s\": must be like \"-Y 512 +X 1024\"",
            ibl_quote(line, text));
    if (edge[0] < 1 || edge[0] > IBL_MAX_EDGE || edge[1] < 1 ||
        edge[1] > IBL_MAX_EDGE)
        return ibl_bad_file(
            r->in,
            "the resolution line is \"%s\": each edge must be 1 to %d pixels",
            ibl_quote(line, text), IBL_MAX_EDGE);
    const bool by_column = axis[0] == 'X';
    const bool down[] = {sign[0] == '-', sign[1] == '-'};
    r->rows.height = (int)edge[0];
    r->rows.width = (int)edge[1];
    r->rows.orientation = by_column ? columns_of[2 * down[0] + !down[1]]
                                    : rows_of[2 * !down[0] + down[1]];
    return IBL_OK;
}

/* Parses a text of `size` bytes, which it changes: lines up to the resolution,
 * or to the first one after a blank one. */
static ibl_status parse(rgbe_rows *r, char *text, size_t size)
{
    const ibl_input *in = r->in;
    char *line = text;
    bool blank = false;

    for (;;) {
        char *end = memchr(line, '\n', size - (size_t)(line - text));
        if (!end)
            return ibl_bad_file(
                in, "the file ends in its header, before the resolution line: "
                    "it is cut short: copy it again");
        const bool is_last = blank || is_resolution(line, (size_t)(end - line));
        for (char *c = line; c < end; c++)
            *c = *c ? *c : '?';
        end[end > line && end[-1] == '\r' ? -1 : 0] = '\0';
        r->data = (size_t)(end + 1 - text);
        if (is_last)
            break;
        blank = !*line;
        const ibl_status status = take_line(r, line);
        if (status)
            return status;
        line = end + 1;
    }
    const ibl_status status = take_resolution(r, line);
    if (status)
        return status;
    if (!r->has_format)
        ibl_warn(in->ctx, "%s: no FORMAT line: taken as 32-bit_rle_rgbe",
                 in->name);
    for (int c = 0; c < 3; c++) {
        const double factor = r->exposure * r->correction[c];
        if (!(1 / factor >= FLT_MIN && 1 / factor <= FLT_MAX))
            return ibl_bad_file(in,
                                "EXPOSURE and COLORCORR multiply to %g: must "
                                "be between 1e-38 and 1e38",
                                factor);
        r->scale[c] = (float)(1 / factor);
    }
    return IBL_OK;
}

static ibl_status parse_header(rgbe_rows *r)
{
    char *text = ibl_alloc_array(MOST_HEADER, 1);
    ibl_status status;
    size_t size;

    if (!text)
        return ibl_no_memory(r->rows.ctx, "the header of a picture");
    if (ibl_input_read(r->in, 0, MOST_HEADER, text, &size))
        status = parse(r, text, size);
    else
        status = ibl_input_unread(r->in, errno);
    ibl_free(text);
    return status;
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

/*
 * Decodes a scanline that was passed over.
 *   src     readable for IBL_RGBE_SLACK bytes beyond the scanline
 *   planes  four, of stride bytes each
 */
static void decode_line(const rgbe_rows *r, const unsigned char *src,
                        unsigned char *planes, float *dst)
{
    const size_t stride = r->stride;
    const int width = r->rows.width;

    if (has_runs(src, width)) {
        src += 4;
        for (size_t c = 0; c < 4; c++)
            src = r->dsp.expand(src, width, planes + c * stride);
    } else {
        for (size_t i = 0; i < (size_t)width; i++)
            for (size_t c = 0; c < 4; c++)
                planes[c * stride + i] = *src++;
    }
    r->dsp.to_rgb(planes, stride, width, r->scale, dst);
}

/* ---- packs ---------------------------------------------------------- */

/* Passes over the next scanlines. Runs in a job: stores errors in the pack, to
 * report after its scanlines are used. */
static void fill_pack(rgbe_rows *r, pack *p)
{
    const int left = r->rows.height - r->line;
    const int want = left < PACK_LINES ? left : PACK_LINES;
    size_t size, at = 0;

    p->lines = p->used = 0;
    p->line[0] = 0;
    p->is_full = true;
    p->fault =
        ibl_input_read(r->in, r->at, r->room, p->bytes, &size) ? 0 : errno;
    while (!p->fault && p->lines < want) {
        p->fault = pass(p->bytes, size, r->rows.width, &at);
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
    const int line = r->line + 1, lines = r->rows.height;

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
                        line, lines, r->rows.width);
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
    const size_t floats = 3 * (size_t)r->rows.width;
    unsigned char *planes = r->planes + 4 * r->stride * (size_t)worker;

    if (s->next && job-- == 0) {
        fill_pack(r, s->next);
        return;
    }
    const int first = job * s->job_lines;
    for (int i = first; i < s->count && i < first + s->job_lines; i++) {
        float *line = s->rgb + floats * (size_t)i;
        decode_line(r, s->p->bytes + s->p->line[s->p->used + i], planes, line);
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
    const int px = r->rows.width, end = rows->row + count;
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
        const bool fill =
            !next->is_full && r->line < r->rows.height && !p->fault;
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
    ibl_rows *rows = *out = &r->rows;
    *rows = (ibl_rows){.ctx = in->ctx, .read = rows_read, .close = rows_close};
    r->in = in;
    r->exposure = 1;
    for (int c = 0; c < 3; c++)
        r->correction[c] = 1;
    ibl_status status = parse_header(r);
    const int width = rows->width, height = rows->height;
    const bool lies = rows->orientation > 4;
    if (!status)
        status = ibl_map_check_size(in, opts, lies ? height : width,
                                    lies ? width : height);
    if (status)
        return status;
    const size_t bytes = in->size - r->data, px = (size_t)width;
    const size_t least = px < MIN_RUNS || px > MAX_RUNS
                             ? 4 * px
                             : 4 + 8 * ((px + LONGEST_RUN - 1) / LONGEST_RUN);
    if (bytes / least < (size_t)height)
        return ibl_bad_file(in,
                            "%zu bytes of pixels cannot hold %d scanlines: the "
                            "file is cut short: copy it again",
                            bytes, height);
    r->room = 8 * px + 64; /* runs of 1 take two bytes for each of a pixel's */
    if (r->room < PACK_BYTES)
        r->room = PACK_BYTES;
    r->stride = (px + IBL_RGBE_SLACK + 63) / 64 * 64;
    for (int i = 0; i < 2; i++)
        r->packs[i].bytes = ibl_alloc_array(r->room + IBL_RGBE_SLACK, 1);
    r->planes = ibl_alloc_array(4 * threads, r->stride);
    if (!r->packs[0].bytes || !r->packs[1].bytes || !r->planes)
        return ibl_no_memory(in->ctx, "scanlines");
    r->at = r->data;
    ibl_rgbe_dsp_init(&r->dsp, ibl_ctx_isa(in->ctx));
    strcpy(rows->report.format, "Radiance RGBE");
    return IBL_OK;
}
