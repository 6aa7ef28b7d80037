/* SPDX-License-Identifier: MIT */
#include "io/exr.h"

#include <stdio.h>
#include <string.h>

#include "core/alloc.h"
#include "core/context.h"
#include "io/bridge.h"
#include "io/exr_file.h"
#include "io/read.h"

bool ibl_exr_is(const void *bytes, size_t size)
{
    return size >= 4 && !memcmp(bytes, "\x76\x2f\x31\x01", 4);
}

/* ---- a file in memory ----------------------------------------------- */

static int64_t size_fn(exr_const_context_t exr, void *user)
{
    (void)exr;
    return (int64_t)((const ibl_exr_file *)user)->size;
}

static int64_t read_fn(exr_const_context_t exr, void *user, void *buffer,
                       uint64_t size, uint64_t offset,
                       exr_stream_error_func_ptr_t error)
{
    const ibl_exr_file *file = user;
    (void)exr;
    (void)error;
    if (offset >= file->size)
        return 0;
    if (size > file->size - offset)
        size = file->size - offset;
    memcpy(buffer, file->bytes + offset, size);
    return (int64_t)size;
}

/* Keeps what the core would print. The first text is the one that says what
 * was wrong, those after it come from its callers. */
static void error_fn(exr_const_context_t exr, exr_result_t code,
                     const char *text)
{
    void *user = NULL;
    (void)code;
    if (!exr || exr_get_user_data(exr, &user) || !user)
        return;
    ibl_exr_file *file = user;
    if (file->deaf || file->text[0])
        return;
    snprintf(file->text, sizeof file->text, "%s", text);
    for (char *c = file->text; *c; c++) {
        if ((unsigned char)*c < ' ')
            *c = ' ';
    }
}

void ibl_exr_listen(ibl_exr_file *file)
{
    file->text[0] = 0;
}

static ibl_status open_file(ibl_ctx *ctx, ibl_exr_file *file)
{
    exr_context_initializer_t init = EXR_DEFAULT_CONTEXT_INITIALIZER;
    init.error_handler_fn = error_fn;
    init.user_data = file;
    init.read_fn = read_fn;
    init.size_fn = size_fn;
    init.flags = EXR_CONTEXT_FLAG_DISABLE_CHUNK_RECONSTRUCTION;
    ibl_exr_listen(file);
    const exr_result_t rv = exr_start_read(&file->exr, "memory", &init);
    if (!rv)
        return IBL_OK;
    file->exr = NULL;
    if (rv == EXR_ERR_OUT_OF_MEMORY)
        return ibl_no_memory(ctx, "the header of an EXR");
    return ibl_fail(ctx, IBL_ERR_FORMAT,
                    "%s: EXR header damaged or cut short: %s", file->name,
                    file->text[0] ? file->text
                                  : exr_get_default_error_message(rv));
}

/* ---- decoding ------------------------------------------------------- */

static ibl_status alloc_chroma(ibl_ctx *ctx, const ibl_exr_pick *pick,
                               ibl_exr_chroma *chroma)
{
    if (pick->chroma_step == 1)
        return IBL_OK;
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

static bool covers(const ibl_exr_window *data, const ibl_exr_window *map)
{
    return data->x0 <= map->x0 && data->y0 <= map->y0 && data->x1 >= map->x1 &&
           data->y1 >= map->y1;
}

static ibl_status decode_here(ibl_ctx *ctx, ibl_exr_file *file,
                              const ibl_exr_pick *pick,
                              const ibl_exr_table *table, ibl_image *img)
{
    ibl_exr_chroma chroma = {0};
    ibl_status status = alloc_chroma(ctx, pick, &chroma);
    if (status)
        goto done;
    status =
        ibl_image_alloc(ctx, pick->display.width, pick->display.height, img);
    if (status)
        goto done;
    if (!covers(&pick->data, &pick->display))
        memset(img->data, 0,
               3 * sizeof(float) * (size_t)img->width * (size_t)img->height);
    status = ibl_exr_decode_chunks(ctx, file, pick, table, img, &chroma);
    if (!status && pick->colour == IBL_EXR_LUMA_CHROMA)
        status = ibl_exr_to_rgb(ctx, pick, &chroma, img);
    if (status)
        ibl_image_free(img);
done:
    ibl_free(chroma.plane[0]);
    ibl_free(chroma.plane[1]);
    return status;
}

static ibl_status decode_bridged(ibl_ctx *ctx, const ibl_exr_file *file,
                                 const ibl_exr_pick *pick,
                                 const ibl_read_options *opts, ibl_image *img,
                                 ibl_read_report *report)
{
    char kind[64];
    const ibl_bridge_source source = {
        .name = file->name,
        .bytes = file->bytes,
        .size = file->size,
        .kind = kind,
        .reader = "openexr",
        .subimage = pick->part,
        .channels = {pick->channels->entries[pick->channel[0]].name.str,
                     pick->channels->entries[pick->channel[1]].name.str,
                     pick->channels->entries[pick->channel[2]].name.str},
    };
    snprintf(kind, sizeof kind, "OpenEXR, %s",
             ibl_exr_compression_name(pick->compression));
    if (pick->chroma_step != 1)
        return ibl_fail(ctx, IBL_ERR_UNSUPPORTED,
                        "%s: neither OpenEXRCore nor the image bridge reads "
                        "%s with half-size RY and BY; save it as RGB",
                        file->name,
                        ibl_exr_compression_name(pick->compression));
    ibl_status status = ibl_bridge_decode(ctx, &source, opts, img, report);
    if (status)
        return status;
    if (pick->colour == IBL_EXR_LUMA_CHROMA) {
        status = ibl_exr_to_rgb(ctx, pick, NULL, img);
        if (status)
            ibl_image_free(img);
    }
    return status;
}

ibl_status ibl_exr_decode(ibl_ctx *ctx, const char *name,
                          const unsigned char *bytes, size_t size,
                          const ibl_read_options *opts, ibl_image *img,
                          ibl_read_report *report)
{
    static const char *const colours[] = {"", ", Y", ", Y RY BY"};
    ibl_exr_file file = {.name = name, .bytes = bytes, .size = size};
    ibl_exr_table table = {0};
    ibl_exr_pick pick;

    ibl_status status = open_file(ctx, &file);
    if (status)
        return status;
    status = ibl_exr_choose(ctx, &file, opts, &pick);
    if (!status)
        status = ibl_read_check_size(ctx, name, opts, pick.display.width,
                                     pick.display.height);
    if (!status)
        status = ibl_exr_list_chunks(ctx, &file, &pick, &table);
    if (status)
        goto done;
    snprintf(report->format, sizeof report->format, "OpenEXR, %s%s%s",
             ibl_exr_compression_name(pick.compression),
             pick.tiled ? ", tiled" : "", colours[pick.colour]);
    if (ibl_exr_can_decode(&file, &pick, &table))
        status = decode_here(ctx, &file, &pick, &table, img);
    else
        status = decode_bridged(ctx, &file, &pick, opts, img, report);
done:
    ibl_exr_table_free(&table);
    exr_finish(&file.exr);
    return status;
}
