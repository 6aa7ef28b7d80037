/* SPDX-License-Identifier: MIT */
/*
 * What libiblbridge.so exports: OpenImageIO behind plain C. The library opens
 * it with dlopen and calls these by name; programs use ibl/io.h.
 *
 * No call throws, prints or keeps a pointer that it was given beyond
 * ibl_bridge_close.
 */
#ifndef IBL_IO_BRIDGE_BRIDGE_H
#define IBL_IO_BRIDGE_BRIDGE_H

#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Changes with every change of this file. */
#define IBL_BRIDGE_ABI 3
#define IBL_BRIDGE_MESSAGE 512

typedef enum ibl_bridge_result {
    IBL_BRIDGE_OK,
    IBL_BRIDGE_NEEDS_FILE, /* this reader cannot read from memory: give path */
    IBL_BRIDGE_UNKNOWN,    /* no reader knows it */
    IBL_BRIDGE_FORMAT,
    IBL_BRIDGE_MEMORY
} ibl_bridge_result;

typedef struct ibl_bridge_request {
    const unsigned char *bytes;
    size_t size;
    const char *path;   /* a file with the same bytes, or NULL */
    const char *reader; /* OpenImageIO's name of the format; NULL: try all,
                           which needs path */
    int subimage;
    const char *channels[3]; /* all or none; may be the same thrice */
    int want_alpha;
    const char *alpha; /* the channel; NULL: what the file says is alpha, or
                          none where channels are named */
    int threads;
} ibl_bridge_request;

typedef struct ibl_bridge_info {
    int width, height;           /* of the display window, which is the map */
    int data_width, data_height; /* of the data window */
    double raw_bytes;            /* decoded, all channels */
    int low_range;               /* integers, which are decoded from sRGB */
    int has_alpha;               /* which was wanted and is there */
    int straight;                /* colours are not multiplied by it */
    char format[32];             /* "tiff, uint16" */
} ibl_bridge_info;

typedef struct ibl_bridge ibl_bridge;

int ibl_bridge_abi(void);

/* Opens and looks at the header. message: IBL_BRIDGE_MESSAGE bytes, one line
 * where the result is an error. *bridge is to be closed if it is OK. */
ibl_bridge_result ibl_bridge_open(const ibl_bridge_request *request,
                                  ibl_bridge **bridge, ibl_bridge_info *info,
                                  char *message);
/*
 * Fills rgb with `rows` rows of the map, of which row `first` is the first: 3
 * * width * rows linear floats, black outside the data window. Rows are asked
 * for in increasing order. Colours are taken as the file has them, neither
 * multiplied nor divided by alpha, which goes to alpha, as it is, width * rows
 * floats, 0 outside the data window; NULL: dropped. Memory: a strip of some
 * dozen rows.
 */
ibl_bridge_result ibl_bridge_read(ibl_bridge *bridge, int first, int rows,
                                  float *rgb, float *alpha, char *message);
void ibl_bridge_close(ibl_bridge *bridge); /* NULL is fine */

#ifdef __cplusplus
}
#endif

#endif
