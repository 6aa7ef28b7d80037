/* SPDX-License-Identifier: MIT */
/*
 * Exports of libiblbridge.so: OpenImageIO with a C interface. The library
 * loads it with dlopen and finds these functions by name; programs use
 * ibl/io.h.
 *
 * No function throws or prints, or keeps a pointer argument after
 * ibl_bridge_close.
 */
#ifndef IBL_IO_BRIDGE_BRIDGE_H
#define IBL_IO_BRIDGE_BRIDGE_H

#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Increase it with every change of the interface. */
#define IBL_BRIDGE_ABI 6
#define IBL_BRIDGE_MESSAGE 512

typedef enum ibl_bridge_result {
    IBL_BRIDGE_OK,
    IBL_BRIDGE_NEEDS_FILE, /* this reader cannot read from memory: set path */
    IBL_BRIDGE_UNKNOWN,    /* no reader accepts the file */
    IBL_BRIDGE_FORMAT,
    IBL_BRIDGE_MEMORY
} ibl_bridge_result;

typedef struct ibl_bridge_request {
    const unsigned char *bytes;
    size_t size;
    const char *path;   /* path of a file with the same bytes, or NULL */
    const char *reader; /* OpenImageIO's name of the format; NULL: try all
                           readers, which needs path */
    int subimage;
    const char *channels[3]; /* three names or three NULLs; a name may repeat */
    int want_alpha;
    int encoded; /* integers become fractions of the largest: 1: always; 0:
                    they are decoded from sRGB; -1: where the file says that
                    they are linear, else they are decoded */
    int threads;
} ibl_bridge_request;

typedef struct ibl_bridge_info {
    int width, height; /* pixels of the display window, which is the map */
    int data_width, data_height; /* pixels of the data window */
    double raw_bytes;            /* size of all channels after decoding */
    int low_range;               /* integers: 1: decoded from sRGB, 2: not */
    int has_alpha;               /* alpha was requested and the file has it */
    int straight;                /* colours are not multiplied by alpha */
    int orientation;             /* of EXIF, 1 to 8 */
    int cube;                    /* six faces below one another */
    char format[32];             /* "tiff, uint16" */
} ibl_bridge_info;

typedef struct ibl_bridge ibl_bridge;

int ibl_bridge_abi(void);

/* Opens the file and reads its header. message: IBL_BRIDGE_MESSAGE bytes, one
 * line after an error. The caller must close *bridge if the result is OK. */
ibl_bridge_result ibl_bridge_open(const ibl_bridge_request *request,
                                  ibl_bridge **bridge, ibl_bridge_info *info,
                                  char *message);
/*
 * Reads `rows` rows of the map, from row `first` on. Calls must ask for rows
 * in increasing order. Keeps a strip of some dozen rows in memory.
 *   rgb    3 * width * rows linear floats, as the file has them, neither
 *          multiplied nor divided by alpha; black outside the data window
 *   alpha  width * rows floats, as the file has them, 0 outside the data
 *          window; may be NULL
 */
ibl_bridge_result ibl_bridge_read(ibl_bridge *bridge, int first, int rows,
                                  float *rgb, float *alpha, char *message);
void ibl_bridge_close(ibl_bridge *bridge); /* accepts NULL */

#ifdef __cplusplus
}
#endif

#endif
