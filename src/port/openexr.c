/* SPDX-License-Identifier: MIT */
/*
 * libiblexr.so's function for systems that the program brings OpenEXRCore to,
 * instead of loading OpenEXR: by the functions that OpenEXRCore undoes
 * compressions with, DWA's apart, which it has not.
 */
#include "io/bridge/openexr.h"

#include <stdlib.h>
#include <string.h>

#include <OpenEXR/openexr_decode.h>

typedef exr_result_t undo(exr_decode_pipeline_t *, const void *, uint64_t,
                          void *, uint64_t);
undo internal_exr_undo_rle, internal_exr_undo_piz, internal_exr_undo_pxr24,
    internal_exr_undo_b44, internal_exr_undo_b44a;

static void *take(exr_transcoding_pipeline_buffer_id_t which, size_t size)
{
    (void)which;
    return malloc(size);
}

static void give(exr_transcoding_pipeline_buffer_id_t which, void *p)
{
    (void)which;
    free(p);
}

int ibl_openexr_unpack_1(const exr_attr_chlist_t *channels,
                         const exr_chunk_info_t *chunk, const void *packed,
                         void *pixels)
{
    static undo *const all[EXR_COMPRESSION_LAST_TYPE] = {
        [EXR_COMPRESSION_RLE] = internal_exr_undo_rle,
        [EXR_COMPRESSION_PIZ] = internal_exr_undo_piz,
        [EXR_COMPRESSION_PXR24] = internal_exr_undo_pxr24,
        [EXR_COMPRESSION_B44] = internal_exr_undo_b44,
        [EXR_COMPRESSION_B44A] = internal_exr_undo_b44a};
    undo *const by = all[chunk->compression];
    exr_coding_channel_info_t *each =
        calloc((size_t)channels->num_channels, sizeof *each);
    exr_decode_pipeline_t decode = {.channels = each,
                                    .channel_count =
                                        (int16_t)channels->num_channels,
                                    .chunk = *chunk,
                                    .alloc_fn = take,
                                    .free_fn = give};

    for (int i = 0; each && i < channels->num_channels; i++) {
        const exr_attr_chlist_entry_t *from = &channels->entries[i];
        const int bytes = from->pixel_type == EXR_PIXEL_HALF ? 2 : 4;
        each[i] = (exr_coding_channel_info_t){
            .channel_name = from->name.str,
            .width = chunk->width,
            .height = chunk->height,
            .x_samples = 1,
            .y_samples = 1,
            .p_linear = from->p_linear,
            .bytes_per_element = (int8_t)bytes,
            .data_type = (uint16_t)from->pixel_type};
    }
    const int ok = each && by &&
                   by(&decode, packed, chunk->packed_size, pixels,
                      chunk->unpacked_size) == EXR_ERR_SUCCESS;
    free(decode.scratch_buffer_1);
    free(decode.scratch_buffer_2);
    free(each);
    return ok;
}
