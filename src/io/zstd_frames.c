/* SPDX-License-Identifier: MIT */
#include "io/container.h"

#include <stdatomic.h>
#include <zstd.h>

#include "core/alloc.h"

typedef struct packing {
    const ibl_texture *tex;
    ibl_piece *frames;
    unsigned char *at[IBL_MAX_TEXTURE_LEVELS + 1];
    atomic_bool failed;
} packing;

static void pack_job(void *arg, int level, int worker)
{
    packing *p = arg;
    ZSTD_CCtx *z = ZSTD_createCCtx();
    const size_t packed =
        z ? ZSTD_compressCCtx(
                z, p->at[level], (size_t)(p->at[level + 1] - p->at[level]),
                p->tex->data + ibl_texture_offset(p->tex, level, 0),
                ibl_texture_level_bytes(p->tex, level), p->tex->zstd)
          : 0;

    (void)worker;
    if (!z || ZSTD_isError(packed))
        p->failed = true;
    ZSTD_freeCCtx(z);
    p->frames[level] = (ibl_piece){p->at[level], packed};
}

ibl_status ibl_zstd_pack(ibl_ctx *ctx, const ibl_texture *tex,
                         unsigned char **packed,
                         ibl_piece frames[IBL_MAX_TEXTURE_LEVELS])
{
    packing p = {.tex = tex, .frames = frames};
    size_t room = 0;

    for (int l = 0; l < tex->levels; l++)
        room += ZSTD_compressBound(ibl_texture_level_bytes(tex, l));
    *packed = p.at[0] = ibl_alloc_array(room, 1);
    if (!*packed)
        return ibl_no_memory(ctx, "a compressed texture");
    for (int l = 0; l < tex->levels; l++)
        p.at[l + 1] =
            p.at[l] + ZSTD_compressBound(ibl_texture_level_bytes(tex, l));
    const ibl_status status = ibl_run(ctx, NULL, tex->levels, pack_job, &p);
    return !status && p.failed
               ? ibl_no_memory(ctx, "Zstandard: take a lower level")
               : status;
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

ibl_status ibl_zstd_check(const ibl_input *in, int level, uint64_t packed,
                          uint64_t bytes)
{
    return packed / BLOCK_BYTES < (bytes + BLOCK_HOLDS - 1) / BLOCK_HOLDS
               ? damaged(in, level, "too short for its texels")
               : IBL_OK;
}

ibl_status ibl_zstd_unpack(const ibl_input *in, int level, uint64_t at,
                           uint64_t packed, uint64_t bytes,
                           unsigned char **unpacked)
{
    *unpacked = ibl_alloc_array(bytes, 1);
    if (!*unpacked)
        return ibl_no_memory(in->ctx, "a texture's level");
    const size_t got =
        ZSTD_decompress(*unpacked, bytes, in->bytes + at, packed);
    if (got == bytes)
        return IBL_OK;
    return damaged(in, level,
                   ZSTD_isError(got) ? ZSTD_getErrorName(got)
                                     : "it is shorter");
}
