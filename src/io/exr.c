/* SPDX-License-Identifier: MIT */
#include <errno.h>
#include <stdio.h>
#include <string.h>

#include "core/alloc.h"
#include "core/context.h"
#include "core/half.h"
#include "io/exr_file.h"
#include "io/layout.h"

enum {
    JOB_BYTES = 1 << 17,  /* about 0.2 ms of inflating */
    BAND_BYTES = 1 << 25, /* of a band, but it has at least a row of blocks */
    LIBRARY_BYTES = 8 << 20, /* OpenEXR's C++ library, measured */
    DECODED = 5 /* blocks of memory in which it decodes one, measured */
};

bool ibl_exr_is(const unsigned char *bytes, size_t size)
{
    return size >= 4 && !memcmp(bytes, "\x76\x2f\x31\x01", 4);
}

/* ---- the file ------------------------------------------------------- */

static int64_t size_fn(exr_const_context_t exr, void *user)
{
    (void)exr;
    return (int64_t)((const ibl_exr_file *)user)->in->size;
}

static int64_t read_fn(exr_const_context_t exr, void *user, void *buffer,
                       uint64_t size, uint64_t offset,
                       exr_stream_error_func_ptr_t error)
{
    ibl_exr_file *file = user;
    size_t got;
    if (ibl_input_read(file->in, offset, (size_t)size, buffer, &got))
        return (int64_t)got;
    file->error = errno;
    error(exr, EXR_ERR_READ_IO, "%s", strerror(file->error));
    return -1;
}

/* Keeps the first error text of OpenEXRCore: it names the cause, later texts
 * come from its callers. Also records that memory ran out: OpenEXRCore then
 * continues without some data, even without the list of channels. */
static void error_fn(exr_const_context_t exr, exr_result_t code,
                     const char *text)
{
    void *user = NULL;
    if (!exr || exr_get_user_data(exr, &user) || !user)
        return;
    ibl_exr_file *file = user;
    file->no_memory |= code == EXR_ERR_OUT_OF_MEMORY;
    if (!file->text[0])
        snprintf(file->text, sizeof file->text, "%s", text);
}

static void *allocate(size_t bytes)
{
    return ibl_alloc_sparse(bytes, 1);
}

static ibl_status open_file(ibl_exr_file *file)
{
    exr_context_initializer_t init = EXR_DEFAULT_CONTEXT_INITIALIZER;
    init.error_handler_fn = error_fn;
    init.user_data = file;
    init.read_fn = read_fn;
    init.size_fn = size_fn;
    init.alloc_fn = allocate;
    init.free_fn = ibl_free;
    init.flags = EXR_CONTEXT_FLAG_DISABLE_CHUNK_RECONSTRUCTION;
    const exr_result_t rv = exr_start_read(&file->exr, "input", &init);
    if (rv)
        file->exr = NULL;
    if (rv == EXR_ERR_OUT_OF_MEMORY || file->no_memory)
        return ibl_no_memory(file->in->ctx, "the header of an EXR");
    if (!rv)
        return IBL_OK;
    if (file->error)
        return ibl_input_unread(file->in, file->error);
    return ibl_bad_file(file->in, "EXR header damaged or cut short: %s",
                        file->text[0] ? file->text
                                      : exr_get_default_error_message(rv));
}

/* ---- pixels --------------------------------------------------------- */

/* Chunks to decode to `rows` rows of the map, from `row` on. */
typedef struct decoding {
    ibl_exr_file *r;
    int first, count; /* chunks */
    int row, rows;
    float *rgb;
} decoding;

/* Converts count samples to floats; uints keep their value. */
static void to_floats(const unsigned char *src, exr_pixel_type_t type,
                      int count, float *dst, int dst_step)
{
    uint16_t half;
    uint32_t number;

    for (int i = 0; i < count; i++, dst += dst_step) {
        if (type == EXR_PIXEL_HALF) {
            memcpy(&half, src + 2 * i, sizeof half);
            *dst = ibl_half_to_float(half);
        } else if (type == EXR_PIXEL_FLOAT) {
            memcpy(dst, src + 4 * i, sizeof *dst);
        } else {
            memcpy(&number, src + 4 * i, sizeof number);
            *dst = (float)number;
        }
    }
}

/* Puts the visible part of a chunk's line, y, in place. */
static void put_line(const decoding *g, const exr_chunk_info_t *chunk, int y,
                     const unsigned char *src)
{
    const ibl_exr_file *r = g->r;
    const ibl_exr_window *map = &r->display;
    const int end = chunk->start_x + chunk->width - 1;
    const int x0 = chunk->start_x > map->x0 ? chunk->start_x : map->x0;
    const int count = (end < map->x1 ? end : map->x1) - x0 + 1;
    const int line = y - map->y0, row = line - g->row;
    const size_t width = (size_t)map->width, at = (size_t)(x0 - map->x0);
    const unsigned char *plane[4];
    exr_pixel_type_t type[4];

    if (count < 1 || row < 0 || row >= g->rows)
        return;
    for (int c = 0; c < 4; c++) {
        const int channel = c < 3 ? r->channel[c] : r->alpha;
        type[c] = r->channels->entries[channel < 0 ? 0 : channel].pixel_type;
        plane[c] = src + (size_t)r->before[c] * (size_t)chunk->width +
                   (type[c] == EXR_PIXEL_HALF ? 2 : 4) * (x0 - chunk->start_x);
    }
    float *rgb = g->rgb + 3 * (width * (size_t)row + at);
    if (r->halves)
        r->dsp.to_rgb(plane, count, rgb);
    for (int c = 0; c < 3 && !r->halves; c++)
        to_floats(plane[c], type[c], count, rgb + c, 3);
    if (r->rows.alpha)
        to_floats(plane[3], type[3], count,
                  r->rows.alpha + width * (size_t)line + at, 1);
}

static void decode_job(void *arg, int job, int worker)
{
    const decoding *g = arg;
    const ibl_exr_file *file = g->r;
    ibl_exr_worker *u = &file->workers[worker];
    const int first = job * file->per_job;

    for (int i = first; i < first + file->per_job && i < g->count; i++) {
        const exr_chunk_info_t *chunk = &file->chunks[g->first + i];
        const int fault = ibl_exr_unpack(file, chunk, u);
        if (fault) {
            if (!u->fault || chunk->start_y < u->y) {
                u->fault = fault;
                u->y = chunk->start_y;
            }
            return;
        }
        const size_t bytes = (size_t)chunk->width * (size_t)file->all;
        for (int line = 0; line < chunk->height; line++)
            put_line(g, chunk, chunk->start_y + line,
                     u->pixels + bytes * (size_t)line);
    }
}

static ibl_status report(const ibl_exr_file *file, const ibl_exr_worker *o)
{
    if (o->fault > 0)
        return ibl_input_unread(file->in, o->fault);
    if (o->fault == IBL_EXR_CUT)
        return ibl_exr_cut(file, o->y);
    if (o->fault == IBL_EXR_NO_MEMORY)
        return ibl_no_memory(file->in->ctx, "decoding an EXR");
    return ibl_bad_file(
        file->in, "damaged EXR: the %s block of line %d cannot be unpacked",
        ibl_exr_compression_name(file->compression), o->y);
}

/* ---- rows in order --------------------------------------------------
 *
 * Blocks hold some rows each, or, as tiles, parts of some rows. Those that lie
 * within what a call wants are decoded to where it wants them, others to a band
 * that calls copy from.
 */

/* The map's row after the last row of a row of blocks. */
static int row_after(const ibl_exr_file *r, int blocks)
{
    const int row =
        r->chunks[0].start_y + (blocks + 1) * r->lines - r->display.y0;
    return row < r->end ? row : r->end;
}

/* Decodes from `row`, where a row of blocks begins, as many as fit before *end
 * straight to rgb, and sets *end behind them; if fewer than a group fit, a
 * group to the band. */
static ibl_status decode_some(ibl_exr_file *r, int row, int *end, float *rgb)
{
    const int blocks = (row + r->display.y0 - r->chunks[0].start_y) / r->lines;
    const int left = r->count / r->columns - blocks;
    const int group = left < r->group ? left : r->group;
    decoding g = {.r = r, .first = blocks * r->columns, .row = row, .rgb = rgb};
    int count = 0;

    while (count < left && row_after(r, blocks + count) <= *end)
        count++;
    const bool fits = count >= group;
    count = fits ? count : group;
    g.count = count * r->columns;
    g.rows = row_after(r, blocks + count - 1) - row;
    *end = fits ? row + g.rows : row;
    if (!fits) {
        const int needed = r->group * r->lines, height = r->rows.height;
        const size_t line = 3 * (size_t)r->rows.width;
        if (!r->band)
            r->band = ibl_alloc_array(
                (size_t)(needed < height ? needed : height) * line,
                sizeof *r->band);
        if (!r->band)
            return ibl_no_memory(r->rows.ctx, "the blocks of an EXR");
        r->band_row = row;
        r->band_count = g.rows;
        g.rgb = r->band;
        if (r->framed)
            memset(g.rgb, 0, line * (size_t)g.rows * sizeof *g.rgb);
    }
    const int jobs = (g.count + r->per_job - 1) / r->per_job;
    const ibl_status status = ibl_run(r->rows.ctx, NULL, jobs, decode_job, &g);
    /* The first line: the report does not depend on threads. */
    const ibl_exr_worker *first = NULL;
    for (int i = 0; i < r->threads; i++) {
        const ibl_exr_worker *u = &r->workers[i];
        if (u->fault && (!first || u->y < first->y))
            first = u;
    }
    return status || !first ? status : report(r, first);
}

static void end_decoding(ibl_exr_file *r)
{
    ibl_exr_end(r);
    ibl_free(r->band);
    r->band = NULL;
}

static ibl_status rows_read(ibl_rows *rows, int count, float *rgb)
{
    ibl_exr_file *r = (ibl_exr_file *)rows;
    const size_t floats = 3 * (size_t)rows->width;
    const int last = rows->row + count, stop = last < r->end ? last : r->end;
    ibl_status status = IBL_OK;

    if (r->framed)
        memset(rgb, 0, floats * (size_t)count * sizeof *rgb);
    for (int row = rows->row > r->begin ? rows->row : r->begin, end;
         row < stop && !status; row = end) {
        const int in_band = row - r->band_row, left = r->band_count - in_band;
        float *to = rgb + floats * (size_t)(row - rows->row);
        end = stop;
        if (in_band < 0 || left <= 0) {
            status = decode_some(r, row, &end, to);
            continue;
        }
        end = end - row > left ? row + left : end;
        memcpy(to, r->band + floats * (size_t)in_band,
               floats * (size_t)(end - row) * sizeof *to);
    }
    if (last == rows->height)
        end_decoding(r);
    return status;
}

static void rows_close(ibl_rows *rows)
{
    end_decoding((ibl_exr_file *)rows);
    ibl_free(rows);
}

/* ---- opening -------------------------------------------------------- */

/* The faces of OpenEXR's cubes (ImfEnvmap.h), turned so that a cube shows what
 * its latitude-longitude map does when that is read. */
static const char envmap_faces[] = "nz/m,pz/m,py/m90,ny/m270,px/m,nx/m";

ibl_status ibl_exr_open(ibl_input *in, const ibl_read_options *opts,
                        ibl_rows **out)
{
    ibl_exr_file *r = ibl_alloc_zeroed(1, sizeof *r);

    *out = NULL;
    if (!r)
        return ibl_no_memory(in->ctx, "an EXR");
    ibl_rows *rows = *out = &r->rows;
    *rows = (ibl_rows){.ctx = in->ctx, .read = rows_read, .close = rows_close};
    r->in = in;
    ibl_read_options own = *opts;
    ibl_status status = open_file(r);
    if (!status)
        status = ibl_exr_choose(r, opts);
    if (status)
        return status;
    if (r->cube && !own.layout)
        own.layout = IBL_INPUT_CUBE;
    if (own.layout == IBL_INPUT_CUBE && !r->cube)
        return ibl_bad_file(in, "is an OpenEXR file that does not say that it "
                                "holds a cube");
    r->cube = own.layout == IBL_INPUT_CUBE;
    status = ibl_map_check_size(in, &own, r->display.width, r->display.height);
    if (!status)
        status = ibl_exr_list_chunks(r);
    if (!status)
        status = ibl_exr_begin(r);
    if (status)
        return status;
    const ibl_exr_window *map = &r->display, *data = &r->data;
    const size_t block_bytes =
        3 * sizeof(float) * (size_t)map->width * (size_t)r->lines;
    const uint64_t each = r->unpacked / (uint64_t)r->count;
    r->framed = data->x0 > map->x0 || data->y0 > map->y0 ||
                data->x1 < map->x1 || data->y1 < map->y1;
    r->begin = data->y0 > map->y0 ? data->y0 - map->y0 : 0;
    r->end = (data->y1 < map->y1 ? data->y1 : map->y1) - map->y0 + 1;
    r->per_job = each < JOB_BYTES ? (int)(JOB_BYTES / (each ? each : 1)) : 1;
    r->group = (r->threads * r->per_job + r->columns - 1) / r->columns;
    if ((size_t)r->group > BAND_BYTES / block_bytes)
        r->group = (int)(BAND_BYTES / block_bytes);
    r->group = r->group ? r->group : 1;
    r->halves = true;
    for (int c = 0; c < 3; c++)
        r->halves &=
            r->channels->entries[r->channel[c]].pixel_type == EXR_PIXEL_HALF;
    rows->width = map->width;
    rows->height = map->height;
    if (r->library)
        rows->held = (LIBRARY_BYTES +
                      DECODED * (double)r->threads * (double)r->most_unpacked) /
                     ((double)rows->width * rows->height);
    snprintf(rows->report.format, sizeof rows->report.format, "OpenEXR, %s%s%s",
             ibl_exr_compression_name(r->compression),
             r->tiled ? ", tiled" : "", r->grey ? ", Y" : "");
    if (r->cube) {
        rows->report.layout = IBL_INPUT_CUBE;
        rows->to_edges = true;
        ibl_face_order_parse(envmap_faces, rows->face_order);
    }
    return r->alpha < 0 ? IBL_OK : ibl_rows_alloc_alpha(rows);
}

/* ---- the library ---------------------------------------------------- */

const char *ibl_exr_version(void)
{
    return OPENEXR_VERSION_STRING;
}
