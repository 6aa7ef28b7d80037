/* SPDX-License-Identifier: MIT */
/*
 * libiblexr.so: OpenEXR's C++ library, for compressions that OpenEXRCore does
 * not undo. The library loads it with dlopen when a file needs it. No function
 * throws or prints.
 */
#ifndef IBL_IO_BRIDGE_OPENEXR_H
#define IBL_IO_BRIDGE_OPENEXR_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Increase it with every change of the interface. */
#define IBL_OPENEXR_ABI 1

typedef struct ibl_openexr_file ibl_openexr_file;

/* Reads size bytes at an offset of the file; 0: it cannot. */
typedef int ibl_openexr_read(const void *cookie, uint64_t offset, size_t size,
                             void *dst);

typedef struct ibl_openexr {
    /* Opens a part of a file of size bytes; it starts no threads. NULL: it is
     * damaged, or there is no memory. */
    ibl_openexr_file *(*open)(ibl_openexr_read *read, const void *cookie,
                              uint64_t size, int part, int tiled);
    /* Undoes the compression of a block or tile, whose first pixel is x, y: its
     * lines, in each the channels by name, as the file's types. bytes: of
     * pixels, the room there. 0: it is damaged, or there is no memory. */
    int (*unpack)(ibl_openexr_file *file, int x, int y, int width, int height,
                  void *pixels, size_t bytes);
    void (*close)(ibl_openexr_file *file); /* accepts NULL */
} ibl_openexr;

/* NULL: this is another version of the interface. */
const ibl_openexr *ibl_openexr_of(int abi);

#ifdef __cplusplus
}
#endif

#endif
