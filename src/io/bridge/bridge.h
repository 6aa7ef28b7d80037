/* SPDX-License-Identifier: MIT */
/*
 * The one export of libiblbridge.so: OpenImageIO as a C function. The library
 * loads it with dlopen and finds it by name; programs use ibl/io.h.
 */
#ifndef IBL_IO_BRIDGE_BRIDGE_H
#define IBL_IO_BRIDGE_BRIDGE_H

#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

/* The number in its name increases with every change. */
#define IBL_BRIDGE_READ "ibl_bridge_read_9"

enum {
    IBL_BRIDGE_MESSAGE = 512
};

typedef enum ibl_bridge_result {
    IBL_BRIDGE_OK,
    IBL_BRIDGE_FORMAT,
    IBL_BRIDGE_MEMORY,
    IBL_BRIDGE_STOPPED /* by begin or go_on */
} ibl_bridge_result;

typedef struct ibl_bridge_info {
    int width, height;
    double raw_bytes; /* size of all channels after decoding */
    int low_range;    /* integers: 1: decoded from sRGB, 2: not */
    int has_alpha;    /* alpha was requested and the file has it */
    int straight;     /* colours are not multiplied by alpha */
    int orientation;  /* of EXIF, 1 to 8 */
    int cube;         /* six faces below one another */
    char format[32];  /* "tiff, uint16" */
} ibl_bridge_info;

typedef struct ibl_bridge_request {
    const unsigned char *bytes;
    size_t size;
    const char *reader; /* OpenImageIO's name of the format */
    int want_alpha;
    int encoded; /* integers become fractions of the largest: 1: always; 0:
                    they are decoded from sRGB; -1: where the file says that
                    they are linear, else they are decoded */
    int threads;
    void *user;
    /*
     * Called before any pixel is read: gives memory for what the header says.
     * 0: stop.
     *   rgb    receives 3 * width * height linear floats, as the file has them,
     *          neither multiplied nor divided by alpha
     *   alpha  width * height values, if info->has_alpha
     */
    int (*begin)(void *user, const ibl_bridge_info *info, float **rgb,
                 float **alpha);
    int (*go_on)(void *user); /* called now and then. 0: stop */
} ibl_bridge_request;

/* Reads a picture. Does not throw or print. message: IBL_BRIDGE_MESSAGE bytes,
 * one line after an error. */
typedef ibl_bridge_result ibl_bridge_read_fn(const ibl_bridge_request *request,
                                             char *message);
ibl_bridge_read_fn ibl_bridge_read_9;

#ifdef __cplusplus
}
#endif

#endif
