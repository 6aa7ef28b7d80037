/* SPDX-License-Identifier: MIT */
#include "io/bridge.h"

#include <dlfcn.h>
#include <errno.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "core/alloc.h"
#include "core/context.h"
#include "io/bridge/bridge.h"
#include "io/container.h"

#ifndef IBL_BRIDGE
#define IBL_BRIDGE "/usr/local/lib/iblbake/libiblbridge.so"
#endif

/* The functions of bridge/bridge.h that dlsym found. */
typedef struct bridge_calls {
    int (*abi)(void);
    ibl_bridge_result (*open)(const ibl_bridge_request *, ibl_bridge **,
                              ibl_bridge_info *, char *);
    ibl_bridge_result (*read)(ibl_bridge *, int, int, float *, float *, char *);
    void (*close)(ibl_bridge *);
} bridge_calls;

/* The kind of the file, for the middle of a sentence. */
static const char *kind_of(const ibl_bridge_source *source, char text[96])
{
    if (!source->kind[0])
        return "is no Radiance .hdr or OpenEXR file, other kinds need";
    snprintf(text, 96, "is %s, which needs", source->kind);
    return text;
}

/* Reports a missing bridge; names the package, from dlopen's error. */
static ibl_status not_there(const ibl_bridge_source *source, const char *path,
                            const char *error)
{
    char text[96];
    const char *kind = kind_of(source, text);

    if (access(path, F_OK))
        return ibl_unsupported(
            source->in,
            "%s the image bridge, and %s is not there: install the package "
            "libopenimageio-dev and build iblbake again",
            kind, path);
    if (error && strstr(error, "libOpenImageIO"))
        return ibl_unsupported(source->in,
                               "%s the image bridge, which needs OpenImageIO: "
                               "install the package libopenimageio2.4 (%s)",
                               kind, error);
    return ibl_unsupported(source->in,
                           "%s the image bridge, which cannot be loaded: %s",
                           kind, error ? error : path);
}

const char *ibl_bridge_path(void)
{
    return IBL_BRIDGE;
}

/* POSIX lets a pointer from dlsym become a function pointer; C has no cast. */
static bool find(void *library, const char *name, void *call)
{
    void *symbol = dlsym(library, name);
    memcpy(call, &symbol, sizeof symbol);
    return symbol != NULL;
}

/* The library stays open: OpenImageIO's threads and statics do not survive
 * unloading. */
static ibl_status load(const ibl_bridge_source *source, bridge_calls *calls)
{
    const char *given = ibl_ctx_bridge(source->in->ctx);
    const char *path = given ? given : ibl_bridge_path();
    void *library = dlopen(path, RTLD_NOW | RTLD_LOCAL);
    if (!library)
        return not_there(source, path, dlerror());
    if (!find(library, "ibl_bridge_abi", &calls->abi) ||
        !find(library, "ibl_bridge_open", &calls->open) ||
        !find(library, "ibl_bridge_read", &calls->read) ||
        !find(library, "ibl_bridge_close", &calls->close) ||
        calls->abi() != IBL_BRIDGE_ABI)
        return ibl_unsupported(source->in,
                               "%s is not the image bridge of this version; "
                               "rebuild or reinstall it",
                               path);
    return IBL_OK;
}

/* Makes a temporary file with the bytes, for readers that need a file. Its name
 * is removed at once, so nothing stays behind however the program ends. path
 * receives the name of the descriptor. */
static int make_file(const ibl_bridge_request *request, char path[32])
{
    char name[] = P_tmpdir "/iblbake-XXXXXX";
    const int fd = mkstemp(name);
    size_t done = 0;

    if (fd < 0)
        return -1;
    unlink(name);
    while (done < request->size) {
        const ssize_t n =
            write(fd, request->bytes + done, request->size - done);
        if (n < 0 && errno != EINTR) {
            const int error = errno;
            close(fd);
            errno = error;
            return -1;
        }
        done += n > 0 ? (size_t)n : 0;
    }
    snprintf(path, 32, "/dev/fd/%d", fd);
    return fd;
}

static ibl_status translate(const ibl_bridge_source *source,
                            ibl_bridge_result result, const char *message)
{
    const ibl_input *in = source->in;
    const char *kind = source->kind;

    switch (result) {
    case IBL_BRIDGE_OK:
        return IBL_OK;
    case IBL_BRIDGE_MEMORY:
        return ibl_reject(in, IBL_ERR_MEMORY, "no memory to decode it");
    case IBL_BRIDGE_UNKNOWN:
        if (kind[0])
            return ibl_unsupported(in, "is %s, but %s", kind, message);
        return ibl_bad_file(in, "is no image: neither Radiance .hdr nor "
                                "OpenEXR nor anything that OpenImageIO knows");
    case IBL_BRIDGE_FORMAT:
    case IBL_BRIDGE_NEEDS_FILE:
        break;
    }
    return ibl_bad_file(in, "damaged or unsupported %s: %s",
                        kind[0] ? kind : "image", message);
}

/*
 * Limits the memory by the size of the file. Map and unpacked data of up to
 * 100 MB each are always accepted; else the map may be 64 times the data
 * window, and the data 2048 times the file. zlib reaches at most 1032:1.
 */
static ibl_status check_claims(const ibl_input *in, size_t size,
                               const ibl_read_options *opts,
                               const ibl_bridge_info *info)
{
    const double most = 2048.0 * (double)size;
    const double map = 12.0 * info->width * info->height;
    const double data = 12.0 * info->data_width * info->data_height;
    const bool lies = info->orientation > 4; /* rows are columns */
    const ibl_status status =
        ibl_map_check_size(in, opts, lies ? info->height : info->width,
                           lies ? info->width : info->height);
    if (status || (map <= 1e8 && info->raw_bytes <= 1e8))
        return status;
    if (map > 64 * data || info->raw_bytes > most)
        return ibl_bad_file(in,
                            "%zu bytes claim to hold %dx%d pixels of a %dx%d "
                            "map, which is taken for damage",
                            size, info->data_width, info->data_height,
                            info->width, info->height);
    return IBL_OK;
}

/* ---- rows ----------------------------------------------------------- */

enum {
    CALL_ROWS = 64, /* read between two checks of the cancel flag */
    DECODED = 34    /* bytes of a pixel that OpenImageIO takes at most: floats
                       of 4 channels, twice */
};

typedef struct bridge_rows {
    ibl_rows rows;
    bridge_calls calls;
    ibl_bridge *bridge;
    ibl_bridge_source source;
    unsigned char *picture; /* bytes for the bridge, if not the source's */
    int fd;                 /* of the temporary file, or -1 */
} bridge_rows;

static ibl_status rows_read(ibl_rows *rows, int count, float *rgb,
                            uint32_t *most)
{
    bridge_rows *r = (bridge_rows *)rows;
    const size_t floats = 3 * (size_t)rows->width;
    char message[IBL_BRIDGE_MESSAGE];

    for (int done = 0, n; done < count; done += n) {
        float *dst = rgb + floats * (size_t)done;
        float *alpha =
            rows->alpha
                ? rows->alpha + (size_t)rows->width * (size_t)(rows->row + done)
                : NULL;
        n = count - done < CALL_ROWS ? count - done : CALL_ROWS;
        if (ibl_cancelled(rows->ctx))
            return IBL_ERR_CANCELLED;
        const ibl_bridge_result result =
            r->calls.read(r->bridge, rows->row + done, n, dst, alpha, message);
        ibl_status status = translate(&r->source, result, message);
        if (!status)
            status = ibl_rows_look(rows->ctx, dst, rows->width, n, most + done);
        if (status)
            return status;
        ibl_rows_progress(rows, done + n);
    }
    return IBL_OK;
}

static void rows_close(ibl_rows *rows)
{
    bridge_rows *r = (bridge_rows *)rows;
    if (r->bridge)
        r->calls.close(r->bridge);
    if (r->fd >= 0)
        close(r->fd);
    ibl_free(r->picture);
    ibl_free(r);
}

/* ---- opening -------------------------------------------------------- */

/* Opens from memory, or through a temporary file if the reader needs one. */
static ibl_status open_either(bridge_rows *r, ibl_bridge_info *info)
{
    ibl_bridge_request *request = &r->source.request;
    char message[IBL_BRIDGE_MESSAGE], path[32];

    ibl_bridge_result result =
        r->calls.open(request, &r->bridge, info, message);
    if (result == IBL_BRIDGE_NEEDS_FILE) {
        r->fd = make_file(request, path);
        if (r->fd < 0)
            return ibl_reject(
                r->source.in, IBL_ERR_IO,
                "no temporary file for the image bridge in %s: %s", P_tmpdir,
                strerror(errno));
        request->path = path;
        result = r->calls.open(request, &r->bridge, info, message);
        request->path = NULL;
    }
    return translate(&r->source, result, message);
}

/* Copies a file whose bytes OpenImageIO would not understand as they are. */
static ibl_status clean(bridge_rows *r)
{
    static const struct {
        const char *reader;
        size_t (*copy)(const unsigned char *, size_t, unsigned char *);
    } kinds[] = {{"png", ibl_png_picture},
                 {"pnm", ibl_pnm_picture},
                 {"dds", ibl_dds_picture}};
    ibl_bridge_request *request = &r->source.request;

    for (size_t i = 0; request->reader && i < 3; i++) {
        if (strcmp(request->reader, kinds[i].reader) != 0)
            continue;
        r->picture = ibl_alloc_array(request->size, 1);
        if (!r->picture)
            return ibl_no_memory(r->rows.ctx, "an image");
        request->size =
            kinds[i].copy(request->bytes, request->size, r->picture);
        request->bytes = r->picture;
    }
    return IBL_OK;
}

static ibl_status check_and_open(bridge_rows *r, const ibl_read_options *opts)
{
    const ibl_input *in = r->source.in;
    ibl_read_report *report = &r->rows.report;
    ibl_bridge_request *request = &r->source.request;
    ibl_bridge_info info;
    ibl_status status = load(&r->source, &r->calls);
    if (status)
        return status;
    const char *missing =
        ibl_truncation_check(request->reader, in->bytes, in->size);
    if (missing)
        return ibl_bad_file(in, "damaged %s: %s", r->source.kind, missing);
    request->bytes = in->bytes;
    request->size = in->size;
    request->want_alpha = opts->alpha != IBL_ALPHA_IGNORE;
    request->threads = ibl_ctx_threads(in->ctx);
    if (!request->encoded)
        request->encoded = opts->transfer == IBL_TRANSFER_FILE     ? -1
                           : opts->transfer == IBL_TRANSFER_LINEAR ? 1
                                                                   : 0;
    status = clean(r);
    if (!status)
        status = open_either(r, &info);
    if (!status)
        status = check_claims(in, request->size, opts, &info);
    if (status)
        return status;
    r->rows.width = info.width;
    r->rows.height = info.height;
    r->rows.straight = info.straight;
    report->bridged = 1;
    report->low_range = info.low_range;
    if (info.cube)
        report->layout = IBL_INPUT_CUBE;
    r->rows.orientation = info.orientation;
    snprintf(report->format, sizeof report->format, "%s by OpenImageIO",
             info.format);
    return info.has_alpha ? ibl_rows_alloc_alpha(&r->rows) : IBL_OK;
}

ibl_status ibl_bridge_rows(const ibl_bridge_source *source,
                           const ibl_read_options *opts, ibl_rows **rows)
{
    ibl_ctx *ctx = source->in->ctx;
    bridge_rows *r = ibl_alloc_zeroed(1, sizeof *r);

    *rows = NULL;
    if (!r)
        return ibl_no_memory(ctx, "an image");
    r->rows = (ibl_rows){
        .ctx = ctx, .read = rows_read, .close = rows_close, .held = DECODED};
    r->source = *source;
    r->fd = -1;
    const ibl_status status = check_and_open(r, opts);
    if (status)
        ibl_rows_close(&r->rows);
    else
        *rows = &r->rows;
    return status;
}
