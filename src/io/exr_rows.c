/* SPDX-License-Identifier: MIT */
/*
 * The rows of an EXR part in order: its blocks hold some rows each, or, as
 * tiles, parts of some rows. Those that lie within what a call wants are
 * decoded to where it wants them, others to a band that calls copy from.
 */
#include <string.h>

#include "core/alloc.h"
#include "core/context.h"
#include "io/exr_file.h"

enum {
    GROUPS = 8 /* decoded between two looks at the cancel flag */
};

/* Of a band, if that is enough for one row of blocks. */
static const size_t band_bytes = (size_t)32 << 20;

typedef struct exr_rows {
    ibl_rows rows;
    ibl_exr_decoder *d;
    bool framed;    /* the data window leaves some of the map black */
    int begin, end; /* the map's rows that blocks have something of */
    int group;      /* rows of blocks that keep all threads at work */
    float *band;
    uint32_t *band_most;
    int band_row, band_count;
} exr_rows;

/* The map's row after those that a row of blocks has. */
static int row_after(const exr_rows *r, int blocks)
{
    const ibl_exr_table *table = &r->d->table;
    const int y = table->chunks[0].y + (blocks + 1) * table->lines;
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
    if (columns > 1) /* a tile has no whole row to look at */
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

/* Rows from row on, which is where blocks begin, up to *end: fewer, or none
 * but to the band, as it suits. */
static ibl_status decode_some(exr_rows *r, int row, int *end, float *rgb,
                              uint32_t *most)
{
    const ibl_exr_table *table = &r->d->table;
    const int all = table->count / table->columns;
    const int blocks =
        (row + r->d->pick.display.y0 - table->chunks[0].y) / table->lines;
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

/* Rows from row on up to *end, or fewer. */
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
    return IBL_OK;
}

static void rows_close(ibl_rows *rows)
{
    exr_rows *r = (exr_rows *)rows;
    ibl_exr_decoder_free(r->d);
    ibl_free(r->band);
    ibl_free(r->band_most);
    ibl_free(r);
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

ibl_status ibl_exr_rows(ibl_exr_decoder *d, ibl_rows **rows)
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
    if (d->pick.alpha >= 0)
        status = ibl_rows_alloc_alpha(&r->rows);
    if (status)
        ibl_rows_close(&r->rows);
    else
        *rows = &r->rows;
    return status;
}
