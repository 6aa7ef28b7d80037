/* SPDX-License-Identifier: MIT */
#include "view/picture.h"

#include <OpenEXR/openexr.h>
#include <stdlib.h>
#include <string.h>

#include "view/message.h"

enum {
    CHANNELS = 4,
    PIXEL_BYTES = 2 * CHANNELS
};

/* In alphabetical order, as files have them; and where each is in a pixel. */
static const char *const names[CHANNELS] = {"A", "B", "G", "R"};
static const int places[CHANNELS] = {3, 2, 1, 0};

/* The file in zeroed memory that is large enough, and the first error. */
typedef struct stream {
    unsigned char *bytes;
    size_t size, room;
    char why[200];
} stream;

/* Headers and the table of blocks take less; ZIP never makes a block larger. */
static size_t room_for(int width, int height)
{
    return 4096 + (size_t)height * (16 + (size_t)width * PIXEL_BYTES);
}

static int64_t write_fn(exr_const_context_t exr, void *user, const void *from,
                        uint64_t size, uint64_t offset,
                        exr_stream_error_func_ptr_t error)
{
    const size_t end = (size_t)(offset + size);
    stream *s = user;

    if (end > s->room) {
        error(exr, EXR_ERR_OUT_OF_MEMORY, "no memory");
        return -1;
    }
    memcpy(s->bytes + offset, from, (size_t)size);
    if (end > s->size)
        s->size = end;
    return (int64_t)size;
}

static void error_fn(exr_const_context_t exr, exr_result_t code,
                     const char *text)
{
    void *user = NULL;

    (void)code;
    if (!exr || exr_get_user_data(exr, &user) || !user)
        return;
    stream *s = user;
    if (!s->why[0])
        strncpy(s->why, text, sizeof s->why - 1);
}

/* A block of lines. Each is packed by a pipeline of its own. */
static exr_result_t write_block(exr_context_t exr, int width, int y,
                                const uint16_t *rgba)
{
    exr_encode_pipeline_t pipe = EXR_ENCODE_PIPELINE_INITIALIZER;
    exr_chunk_info_t chunk;
    exr_result_t rv = exr_write_scanline_chunk_info(exr, 0, y, &chunk);

    if (rv)
        return rv;
    rv = exr_encoding_initialize(exr, 0, &chunk, &pipe);
    if (rv)
        return rv;
    for (int i = 0; i < CHANNELS; i++) {
        exr_coding_channel_info_t *c = &pipe.channels[i];
        c->encode_from_ptr =
            (const uint8_t *)(rgba + (size_t)y * (size_t)width * CHANNELS +
                              places[i]);
        c->user_bytes_per_element = 2;
        c->user_data_type = EXR_PIXEL_HALF;
        c->user_pixel_stride = PIXEL_BYTES;
        c->user_line_stride = PIXEL_BYTES * width;
    }
    rv = exr_encoding_choose_default_routines(exr, 0, &pipe);
    if (!rv)
        rv = exr_encoding_run(exr, 0, &pipe);
    exr_encoding_destroy(exr, &pipe);
    return rv;
}

static exr_result_t write_picture(exr_context_t exr, int width, int height,
                                  const uint16_t *rgba)
{
    int part;
    int32_t lines = 0;
    exr_result_t rv = exr_add_part(exr, NULL, EXR_STORAGE_SCANLINE, &part);

    if (!rv)
        rv = exr_initialize_required_attr_simple(exr, part, width, height,
                                                 EXR_COMPRESSION_ZIP);
    for (int i = 0; i < CHANNELS && !rv; i++)
        rv = exr_add_channel(exr, part, names[i], EXR_PIXEL_HALF,
                             EXR_PERCEPTUALLY_LOGARITHMIC, 1, 1);
    if (!rv)
        rv = exr_write_header(exr);
    if (!rv)
        rv = exr_get_scanlines_per_chunk(exr, part, &lines);
    for (int y = 0; y < height && !rv; y += lines)
        rv = write_block(exr, width, y, rgba);
    return rv;
}

bool view_exr_encode(const char *name, int width, int height,
                     const uint16_t *rgba, void **bytes, size_t *size)
{
    exr_context_initializer_t init = EXR_DEFAULT_CONTEXT_INITIALIZER;
    exr_context_t exr = NULL;
    stream s = {.room = room_for(width, height)};

    *bytes = NULL;
    s.bytes = calloc(1, s.room);
    if (!s.bytes)
        return view_fail("%s: no EXR of %d x %d pixels is made of it: no "
                         "memory",
                         name, width, height);
    init.error_handler_fn = error_fn;
    init.user_data = &s;
    init.write_fn = write_fn;
    exr_result_t rv =
        exr_start_write(&exr, name, EXR_WRITE_FILE_DIRECTLY, &init);
    if (!rv)
        rv = write_picture(exr, width, height, rgba);
    /* The table of where blocks are is written last. */
    const exr_result_t end = exr_finish(&exr);
    if (!rv)
        rv = end;
    if (!rv) {
        *bytes = s.bytes;
        *size = s.size;
        return true;
    }
    free(s.bytes);
    return view_fail("%s: no EXR of %d x %d pixels is made of it: %s", name,
                     width, height,
                     s.why[0] ? s.why : exr_get_default_error_message(rv));
}
