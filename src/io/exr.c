/* SPDX-License-Identifier: MIT */
#include "io/exr.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>

#include "core/alloc.h"
#include "core/context.h"
#include "io/bridge.h"
#include "io/exr_file.h"

bool ibl_exr_is(const void *bytes, size_t size)
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

/* Keeps what the core would print. The first text is the one that says what
 * was wrong, those after it come from its callers. Its memory running out is
 * kept apart: the core then goes on without what it had no room for, be it the
 * list of channels. */
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
    for (char *c = file->text; *c; c++) {
        if ((unsigned char)*c < ' ')
            *c = ' ';
    }
}

void ibl_exr_listen(ibl_exr_file *file)
{
    file->text[0] = 0;
}

ibl_status ibl_exr_unread(ibl_ctx *ctx, const ibl_exr_file *file)
{
    return ibl_fail(ctx, IBL_ERR_IO, "%s: cannot be read: %s", file->in->name,
                    strerror(file->error));
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
    const exr_result_t rv = exr_start_read(&file->exr, "input", &init);
    if (rv)
        file->exr = NULL;
    if (rv == EXR_ERR_OUT_OF_MEMORY || file->no_memory)
        return ibl_no_memory(ctx, "the header of an EXR");
    if (!rv)
        return IBL_OK;
    if (file->error)
        return ibl_exr_unread(ctx, file);
    return ibl_fail(ctx, IBL_ERR_FORMAT,
                    "%s: EXR header damaged or cut short: %s", file->in->name,
                    file->text[0] ? file->text
                                  : exr_get_default_error_message(rv));
}

/* ---- opening -------------------------------------------------------- */

/* Opens the file and finds what is asked for. */
static ibl_status choose(ibl_ctx *ctx, const ibl_read_options *opts,
                         ibl_exr_decoder *d)
{
    const char *name = d->file.in->name;
    ibl_status status = open_file(ctx, &d->file);
    if (!status)
        status = ibl_exr_choose(ctx, &d->file, opts, &d->pick);
    if (!status)
        status = ibl_map_check_size(ctx, name, opts, d->pick.display.width,
                                    d->pick.display.height);
    if (!status)
        status = ibl_exr_list_chunks(ctx, &d->file, &d->pick, &d->table);
    if (!status)
        status = ibl_exr_decoder_init(ctx, d);
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

/* With chroma of half the size, whose filter wants many lines. */
static ibl_status decode_whole(ibl_ctx *ctx, ibl_exr_decoder *d,
                               ibl_rows **rows)
{
    const int width = d->pick.display.width, height = d->pick.display.height;
    ibl_rows plane = {.ctx = ctx, .width = width, .height = height};
    ibl_exr_chroma chroma = {0};
    ibl_image img = {0};
    ibl_status status = alloc_chroma(ctx, &d->pick, &chroma);
    if (!status)
        status = ibl_image_alloc(ctx, width, height, &img);
    if (!status && d->pick.alpha >= 0)
        status = ibl_rows_alloc_alpha(&plane);
    if (status)
        goto done;
    const ibl_exr_target target = {.rgb = img.data,
                                   .count = height,
                                   .alpha = plane.alpha,
                                   .chroma = &chroma};
    memset(img.data, 0, 3 * sizeof(float) * (size_t)width * (size_t)height);
    status = ibl_exr_decode_chunks(ctx, d, 0, d->table.count, &target);
    if (!status)
        status = ibl_exr_to_rgb(ctx, &d->pick, &chroma, &img);
    if (!status)
        status = ibl_rows_of_image(ctx, &img, rows);
    if (!status) {
        (*rows)->alpha = plane.alpha;
        plane.alpha = NULL;
    }
done:
    ibl_image_free(&img);
    ibl_free(plane.alpha);
    ibl_free(chroma.plane[0]);
    ibl_free(chroma.plane[1]);
    return status;
}

static ibl_status open_bridged(ibl_ctx *ctx, const ibl_exr_pick *pick,
                               ibl_input *in, const ibl_read_options *opts,
                               ibl_rows **rows)
{
    const exr_attr_chlist_entry_t *all = pick->channels->entries;
    const char *compression = ibl_exr_compression_name(pick->compression);
    char kind[64];
    ibl_status status;

    if (pick->chroma_step != 1)
        return ibl_fail(ctx, IBL_ERR_UNSUPPORTED,
                        "%s: neither OpenEXRCore nor the image bridge reads "
                        "%s with half-size RY and BY; save it as RGB",
                        in->name, compression);
    status = ibl_input_load(ctx, NULL, in);
    if (status)
        return status;
    const ibl_bridge_source source = {
        .name = in->name,
        .bytes = in->bytes,
        .size = in->size,
        .kind = kind,
        .reader = "openexr",
        .subimage = pick->part,
        .channels = {all[pick->channel[0]].name.str,
                     all[pick->channel[1]].name.str,
                     all[pick->channel[2]].name.str},
        .alpha = pick->alpha < 0 ? NULL : all[pick->alpha].name.str,
        .luma = pick->colour == IBL_EXR_LUMA_CHROMA ? pick->luma : NULL,
    };
    snprintf(kind, sizeof kind, "OpenEXR, %s", compression);
    return ibl_bridge_rows(ctx, &source, opts, rows);
}

ibl_status ibl_exr_open(ibl_ctx *ctx, ibl_input *in,
                        const ibl_read_options *opts, ibl_rows **rows)
{
    ibl_exr_decoder *d = ibl_alloc_zeroed(1, sizeof *d);
    char format[64];
    ibl_status status;

    *rows = NULL;
    if (!d)
        return ibl_no_memory(ctx, "an EXR");
    d->file.in = in;
    status = choose(ctx, opts, d);
    if (status)
        goto done;
    describe(&d->pick, format);
    if (!ibl_exr_can_decode(d)) {
        status = open_bridged(ctx, &d->pick, in, opts, rows);
    } else if (d->pick.chroma_step > 1) {
        status = decode_whole(ctx, d, rows);
    } else {
        status = ibl_exr_rows(ctx, d, rows);
        d = NULL;
    }
    if (!status)
        memcpy((*rows)->report.format, format, sizeof format);
done:
    ibl_exr_decoder_free(d);
    return status;
}
