/* SPDX-License-Identifier: MIT */
#include "io/container.h"

#include <stdatomic.h>
#include <zstd.h>

#include "core/alloc.h"

/* ---- writing -------------------------------------------------------- */

enum {
    CHUNK = 1 << 18 /* compressed between two looks for a cancelled context */
};

typedef struct packing {
    ibl_ctx *ctx;
    const ibl_texture *tex;
    ibl_piece *frames;
    unsigned char *at[IBL_MAX_TEXTURE_LEVELS];
    atomic_bool failed;
} packing;

/* Compresses a level into out. The chunks are the same in every run, and so are
 * the bytes. Returns false if memory ran out. */
static bool pack(const packing *p, ZSTD_CCtx *z, ZSTD_outBuffer *out, int level)
{
    const size_t bytes = ibl_texture_level_bytes(p->tex, level);
    ZSTD_inBuffer in = {p->tex->data + ibl_texture_offset(p->tex, level, 0), 0,
                        0};
    size_t left = 1;

    if (ZSTD_isError(
            ZSTD_CCtx_setParameter(z, ZSTD_c_compressionLevel, p->tex->zstd)) ||
        ZSTD_isError(ZSTD_CCtx_setPledgedSrcSize(z, bytes)))
        return false;
    while (left && out->pos < out->size && !ibl_cancelled(p->ctx)) {
        in.size = bytes - in.pos > CHUNK ? in.pos + CHUNK : bytes;
        const bool last = in.size == bytes;
        left = ZSTD_compressStream2(z, out, &in,
                                    last ? ZSTD_e_end : ZSTD_e_continue);
        if (ZSTD_isError(left))
            return false;
        left += !last;
    }
    return !left || ibl_cancelled(p->ctx);
}

static void pack_job(void *arg, int level, int worker)
{
    packing *p = arg;
    const size_t room =
        ZSTD_compressBound(ibl_texture_level_bytes(p->tex, level));
    ZSTD_outBuffer out = {p->at[level], room, 0};
    ZSTD_CCtx *z = ZSTD_createCCtx();

    (void)worker;
    if (!z || !pack(p, z, &out, level))
        p->failed = true;
    ZSTD_freeCCtx(z);
    p->frames[level] = (ibl_piece){out.dst, out.pos};
}

ibl_status ibl_zstd_pack(ibl_ctx *ctx, const ibl_texture *tex,
                         unsigned char **packed,
                         ibl_piece frames[IBL_MAX_TEXTURE_LEVELS])
{
    packing p = {.ctx = ctx, .tex = tex, .frames = frames};
    size_t at[IBL_MAX_TEXTURE_LEVELS + 1] = {0};

    for (int l = 0; l < tex->levels; l++)
        at[l + 1] = at[l] + ZSTD_compressBound(ibl_texture_level_bytes(tex, l));
    *packed = ibl_alloc_array(at[tex->levels], 1);
    if (!*packed)
        return ibl_no_memory(ctx, "a compressed texture");
    for (int l = 0; l < tex->levels; l++)
        p.at[l] = *packed + at[l];
    const ibl_status status = ibl_run(ctx, NULL, tex->levels, pack_job, &p);
    if (!status && ibl_cancelled(ctx)) /* jobs may have stopped for it */
        return IBL_ERR_CANCELLED;
    if (!status && p.failed)
        return ibl_no_memory(ctx, "Zstandard: take a lower level");
    return status;
}

/* ---- reading -------------------------------------------------------- */

/* The least block: a header of 3 bytes and a byte that is repeated. */
enum {
    BLOCK_BYTES = 4,
    BLOCK_HOLDS = 1 << 17
};

static ibl_status damaged(const ibl_input *in, int level, const char *why)
{
    return ibl_bad_file(in,
                        "damaged: level %d is not Zstandard's: %s: copy or "
                        "make it again",
                        level, why);
}

ibl_status ibl_zstd_check(const ibl_input *in, int level, uint64_t at,
                          uint64_t packed, uint64_t bytes)
{
    const unsigned char *frame = in->bytes + at, *end = frame + packed;
    uint64_t stated = 0;
    bool all = true; /* frames state their size */

    if (packed / BLOCK_BYTES < (bytes + BLOCK_HOLDS - 1) / BLOCK_HOLDS)
        return damaged(in, level, "too short for its texels");
    while (frame < end) {
        const size_t size =
            ZSTD_findFrameCompressedSize(frame, (size_t)(end - frame));
        if (ZSTD_isError(size))
            return damaged(in, level, ZSTD_getErrorName(size));
        const unsigned long long holds = ZSTD_getFrameContentSize(frame, size);
        if (holds == ZSTD_CONTENTSIZE_ERROR)
            return damaged(in, level, "a frame of no known kind");
        if (holds == ZSTD_CONTENTSIZE_UNKNOWN)
            all = false;
        else if (holds > bytes - stated)
            return damaged(in, level, "it says that it is longer");
        else
            stated += holds;
        frame += size;
    }
    return all && stated < bytes
               ? damaged(in, level, "it says that it is shorter")
               : IBL_OK;
}

ibl_status ibl_zstd_unpack(const ibl_input *in, int level, uint64_t at,
                           uint64_t packed, uint64_t bytes,
                           unsigned char **unpacked)
{
    unsigned char *to = ibl_alloc_array(bytes, 1);

    *unpacked = NULL;
    if (!to)
        return ibl_no_memory(in->ctx, "a texture's level");
    const size_t got = ZSTD_decompress(to, bytes, in->bytes + at, packed);
    if (got == bytes) {
        *unpacked = to;
        return IBL_OK;
    }
    ibl_free(to);
    return damaged(in, level,
                   ZSTD_isError(got) ? ZSTD_getErrorName(got)
                                     : "it is shorter");
}
