/* SPDX-License-Identifier: MIT */
#include "io/exr.h"

#include <errno.h>
#include <pthread.h>
#include <stdio.h>
#include <string.h>

#include "core/alloc.h"
#include "core/context.h"
#include "io/exr_file.h"

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
    if (file->deaf)
        return;
    file->no_memory |= code == EXR_ERR_OUT_OF_MEMORY;
    if (file->text[0])
        return;
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
    file->text[0] = 0;
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

/* ---- rows in order --------------------------------------------------
 *
 * Blocks hold some rows each, or, as tiles, parts of some rows. Those that lie
 * within what a call wants are decoded to where it wants them, others to a band
 * that calls copy from.
 */

enum {
    GROUPS = 8,              /* decoded between two checks of the cancel flag */
    LIBRARY_BYTES = 8 << 20, /* OpenEXR's C++ library, measured */
    DECODED = 5 /* blocks of memory in which it decodes one, measured */
};

/* Limit of a band, but a band holds at least one row of blocks. */
static const size_t band_bytes = (size_t)32 << 20;

typedef struct exr_rows {
    ibl_rows rows;
    ibl_exr_decoder *d;
    bool framed;    /* the data window does not cover the map */
    int begin, end; /* rows of the map that the blocks cover */
    int group;      /* number of rows of blocks that keeps all threads busy */
    float *band;
    uint32_t *band_most;
    int band_row, band_count;
} exr_rows;

/* The map's row after the last row of a row of blocks. */
static int row_after(const exr_rows *r, int blocks)
{
    const ibl_exr_table *table = &r->d->table;
    const int y = table->chunks[0].start_y + (blocks + 1) * table->lines;
    const int row = y - r->d->pick.display.y0;
    return row < r->end ? row : r->end;
}

static ibl_status decode_blocks(exr_rows *r, int blocks, int count,
                                const ibl_exr_target *t)
{
    const int columns = r->d->table.columns;
    ibl_exr_target part = *t;
    ibl_status status;

    part.alpha = r->rows.alpha;
    if (columns > 1) /* a tile has no whole row to examine */
        part.most = NULL;
    if (r->framed)
        memset(t->rgb, 0,
               3 * sizeof(float) * (size_t)r->rows.width * (size_t)t->count);
    status =
        ibl_exr_decode_chunks(r->d, blocks * columns, count * columns, &part);
    if (status || columns == 1)
        return status;
    return ibl_rows_look(r->rows.ctx, t->rgb, r->rows.width, t->count, t->most);
}

static ibl_status fill_band(exr_rows *r, int blocks, int row)
{
    const size_t needed = (size_t)r->group * (size_t)r->d->table.lines;
    const size_t height = (size_t)r->rows.height;
    const size_t lines = needed < height ? needed : height;
    const int left = r->d->table.count / r->d->table.columns - blocks;
    const int count = left < r->group ? left : r->group;

    if (!r->band) {
        r->band =
            ibl_alloc_array(3 * sizeof(float) * lines, (size_t)r->rows.width);
        r->band_most = ibl_alloc_array(lines, sizeof *r->band_most);
        if (!r->band || !r->band_most)
            return ibl_no_memory(r->rows.ctx, "the blocks of an EXR");
    }
    r->band_row = row;
    r->band_count = row_after(r, blocks + count - 1) - row;
    const ibl_exr_target t = {.rgb = r->band,
                              .row = row,
                              .count = r->band_count,
                              .most = r->band_most};
    return decode_blocks(r, blocks, count, &t);
}

/* Decodes from `row`, where a row of blocks begins. Decodes as many blocks as
 * fit before *end straight to rgb and sets *end behind them. If fewer than a
 * group fit, fills the band and sets *end to row. */
static ibl_status decode_some(exr_rows *r, int row, int *end, float *rgb,
                              uint32_t *most)
{
    const ibl_exr_table *table = &r->d->table;
    const int all = table->count / table->columns;
    const int blocks =
        (row + r->d->pick.display.y0 - table->chunks[0].start_y) / table->lines;
    int count = 0;

    while (count < GROUPS * r->group && blocks + count < all &&
           row_after(r, blocks + count) <= *end)
        count++;
    if (count < r->group && blocks + count < all) {
        *end = row;
        return fill_band(r, blocks, row);
    }
    *end = row_after(r, blocks + count - 1);
    const ibl_exr_target t = {
        .rgb = rgb, .row = row, .count = *end - row, .most = most};
    return decode_blocks(r, blocks, count, &t);
}

/* Rows from `row` up to *end; sets *end lower if it returns fewer. */
static ibl_status next_rows(exr_rows *r, int row, int *end, float *rgb,
                            uint32_t *most)
{
    const size_t floats = 3 * (size_t)r->rows.width;
    const int in_band = row - r->band_row, left = r->band_count - in_band;
    const bool is_black = row < r->begin || row >= r->end;

    if (is_black) {
        if (row < r->begin && r->begin < *end)
            *end = r->begin;
        const size_t count = (size_t)(*end - row);
        memset(rgb, 0, floats * count * sizeof *rgb);
        memset(most, 0, count * sizeof *most);
        return IBL_OK;
    }
    if (in_band < 0 || left <= 0)
        return decode_some(r, row, end, rgb, most);
    if (*end - row > left)
        *end = row + left;
    const size_t count = (size_t)(*end - row);
    memcpy(rgb, r->band + floats * (size_t)in_band,
           floats * count * sizeof *rgb);
    memcpy(most, r->band_most + in_band, count * sizeof *most);
    return IBL_OK;
}

static void free_decoder(exr_rows *r)
{
    ibl_exr_decoder_free(r->d);
    ibl_free(r->band);
    ibl_free(r->band_most);
    r->d = NULL;
    r->band = NULL;
    r->band_most = NULL;
}

static ibl_status rows_read(ibl_rows *rows, int count, float *rgb,
                            uint32_t *most)
{
    exr_rows *r = (exr_rows *)rows;
    const size_t floats = 3 * (size_t)rows->width;

    for (int done = 0; done < count;) {
        const int row = rows->row + done;
        int end = rows->row + count;
        const ibl_status status =
            next_rows(r, row, &end, rgb + floats * (size_t)done, most + done);
        if (status)
            return status;
        done += end - row;
        ibl_rows_progress(rows, done);
    }
    if (rows->row + count == rows->height)
        free_decoder(r);
    return IBL_OK;
}

static void rows_close(ibl_rows *rows)
{
    free_decoder((exr_rows *)rows);
    ibl_free(rows);
}

static void lay_out(exr_rows *r)
{
    const ibl_exr_window *map = &r->d->pick.display, *data = &r->d->pick.data;
    const ibl_exr_table *table = &r->d->table;
    const size_t row_bytes = 3 * sizeof(float) * (size_t)map->width;
    const size_t most = band_bytes / (row_bytes * (size_t)table->lines);
    const int wanted = r->d->threads * r->d->per_job;

    r->framed = data->x0 > map->x0 || data->y0 > map->y0 ||
                data->x1 < map->x1 || data->y1 < map->y1;
    r->begin = data->y0 > map->y0 ? data->y0 - map->y0 : 0;
    r->end = (data->y1 < map->y1 ? data->y1 : map->y1) - map->y0 + 1;
    r->group = (wanted + table->columns - 1) / table->columns;
    if ((size_t)r->group > most)
        r->group = most ? (int)most : 1;
}

/* Makes the rows of a part without half-size chroma. They own d, even after an
 * error. */
static ibl_status open_rows(ibl_exr_decoder *d, ibl_rows **rows)
{
    ibl_ctx *ctx = d->file.in->ctx;
    exr_rows *r = ibl_alloc_zeroed(1, sizeof *r);
    ibl_status status = IBL_OK;

    if (!r) {
        ibl_exr_decoder_free(d);
        return ibl_no_memory(ctx, "an EXR");
    }
    r->rows = (ibl_rows){.ctx = ctx,
                         .width = d->pick.display.width,
                         .height = d->pick.display.height,
                         .read = rows_read,
                         .close = rows_close};
    r->d = d;
    lay_out(r);
    if (d->library)
        r->rows.held = (LIBRARY_BYTES +
                        DECODED * (double)d->threads * d->table.most_unpacked) /
                       ((double)r->rows.width * r->rows.height);
    if (d->pick.alpha >= 0)
        status = ibl_rows_alloc_alpha(&r->rows);
    if (status)
        ibl_rows_close(&r->rows);
    else
        *rows = &r->rows;
    return status;
}

/* ---- opening -------------------------------------------------------- */

/* Opens the file and finds the part, channels and chunks to read. */
static ibl_status choose(const ibl_read_options *opts, ibl_exr_decoder *d)
{
    ibl_status status = open_file(&d->file);
    ibl_read_options own = *opts;
    if (!status)
        status = ibl_exr_choose(&d->file, opts, &d->pick);
    if (d->pick.cube && !own.layout)
        own.layout = IBL_INPUT_CUBE;
    d->pick.cube = own.layout == IBL_INPUT_CUBE && d->pick.cube;
    if (!status && own.layout == IBL_INPUT_CUBE && !d->pick.cube)
        status = ibl_bad_file(d->file.in, "is an OpenEXR file that does not "
                                          "say that it holds a cube");
    if (!status)
        status = ibl_map_check_size(d->file.in, &own, d->pick.display.width,
                                    d->pick.display.height);
    if (!status)
        status = ibl_exr_list_chunks(&d->file, &d->pick, &d->table);
    if (!status)
        status = ibl_exr_decoder_init(d);
    return status;
}

static void describe(const ibl_exr_pick *pick, char format[64])
{
    static const char *const colours[] = {"", ", Y", ", Y RY BY"};
    snprintf(format, 64, "OpenEXR, %s%s%s",
             ibl_exr_compression_name(pick->compression),
             pick->tiled ? ", tiled" : "", colours[pick->colour]);
}

static ibl_status alloc_chroma(ibl_ctx *ctx, const ibl_exr_pick *pick,
                               ibl_exr_chroma *chroma)
{
    chroma->width = pick->data.width / 2;
    chroma->height = pick->data.height / 2;
    for (int i = 0; i < 2; i++) {
        chroma->plane[i] = ibl_alloc_array(
            (size_t)chroma->width * (size_t)chroma->height, sizeof(float));
        if (!chroma->plane[i])
            return ibl_no_memory(ctx, "the chroma of an EXR");
    }
    return IBL_OK;
}

/* Decodes a whole part with half-size chroma; the filter needs many lines. */
static ibl_status decode_whole(ibl_exr_decoder *d, ibl_rows **out)
{
    ibl_ctx *ctx = d->file.in->ctx;
    const int width = d->pick.display.width, height = d->pick.display.height;
    ibl_exr_chroma chroma = {0};
    ibl_rows *rows = NULL;
    ibl_image img;
    ibl_status status = ibl_image_alloc(ctx, width, height, &img);
    if (!status)
        status = ibl_rows_of_image(ctx, &img, &rows);
    if (!status)
        status = alloc_chroma(ctx, &d->pick, &chroma);
    if (!status && d->pick.alpha >= 0)
        status = ibl_rows_alloc_alpha(rows);
    if (!status) {
        img = rows->whole;
        memset(img.data, 0, 3 * sizeof(float) * (size_t)width * (size_t)height);
        const ibl_exr_target target = {.rgb = img.data,
                                       .count = height,
                                       .alpha = rows->alpha,
                                       .chroma = &chroma};
        status = ibl_exr_decode_chunks(d, 0, d->table.count, &target);
    }
    if (!status)
        status = ibl_exr_to_rgb(ctx, &d->pick, &chroma, &img);
    if (status)
        ibl_rows_close(rows);
    else
        *out = rows;
    ibl_free(chroma.plane[0]);
    ibl_free(chroma.plane[1]);
    return status;
}

/* The faces of OpenEXR's cubes (ImfEnvmap.h), turned so that a cube shows what
 * its latitude-longitude map does when that is read. */
static const char envmap_faces[] = "nz/m,pz/m,py/m90,ny/m270,px/m,nx/m";

ibl_status ibl_exr_open(ibl_input *in, const ibl_read_options *opts,
                        ibl_rows **rows)
{
    ibl_exr_decoder *d = ibl_alloc_zeroed(1, sizeof *d);
    char format[64];
    double primaries[8];
    bool named, cube;
    ibl_status status;

    *rows = NULL;
    if (!d)
        return ibl_no_memory(in->ctx, "an EXR");
    d->file.in = in;
    status = choose(opts, d);
    if (status)
        goto done;
    describe(&d->pick, format);
    named = d->pick.has_primaries;
    cube = d->pick.cube;
    memcpy(primaries, d->pick.primaries, sizeof primaries);
    if (d->pick.chroma_step > 1) {
        status = decode_whole(d, rows);
    } else {
        status = open_rows(d, rows);
        d = NULL;
    }
    if (!status) {
        memcpy((*rows)->report.format, format, sizeof format);
        memcpy((*rows)->primaries, primaries, sizeof primaries);
        (*rows)->has_primaries = named;
        if (cube) {
            (*rows)->report.layout = IBL_INPUT_CUBE;
            (*rows)->to_edges = true;
            ibl_face_order_parse(envmap_faces, (*rows)->face_order);
        }
    }
done:
    ibl_exr_decoder_free(d);
    return status;
}

/* ---- the library ---------------------------------------------------- */

static char version[48];

static void find_version(void)
{
    int major = 0, minor = 0, patch = 0;
    const char *extra = NULL;

    exr_get_library_version(&major, &minor, &patch, &extra);
    snprintf(version, sizeof version, "%d.%d.%d%s%s", major, minor, patch,
             extra && *extra ? "-" : "", extra ? extra : "");
}

const char *ibl_exr_version(void)
{
    static pthread_once_t once = PTHREAD_ONCE_INIT;
    pthread_once(&once, find_version);
    return version;
}
