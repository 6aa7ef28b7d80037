/* SPDX-License-Identifier: MIT */
/*
 * libiblexr.so: OpenEXR's C++ library, for all compressions but ZIP. The
 * library loads it with dlopen when a file needs it.
 */
#ifndef IBL_IO_BRIDGE_OPENEXR_H
#define IBL_IO_BRIDGE_OPENEXR_H

#include <OpenEXR/openexr.h>

#ifdef __cplusplus
extern "C" {
#endif

/* The number in its name increases with every change. */
#define IBL_OPENEXR_UNPACK "ibl_openexr_unpack_1"
/* Of that kind, for DWA, which OpenEXRCore alone does not undo. */
#define IBL_OPENEXR_UNPACK_DWA "ibl_openexr_unpack_dwa_1"

/*
 * Undoes the compression of a block or tile, in the calling thread. Does not
 * throw or print.
 *   channels  of the part; all of them have samples at every pixel
 *   pixels    receives chunk->unpacked_size bytes
 * 0: it is damaged, or there is no memory.
 */
typedef int ibl_openexr_unpack(const exr_attr_chlist_t *channels,
                               const exr_chunk_info_t *chunk,
                               const void *packed, void *pixels);
ibl_openexr_unpack ibl_openexr_unpack_1, ibl_openexr_unpack_dwa_1;

#ifdef __cplusplus
}
#endif

#endif
