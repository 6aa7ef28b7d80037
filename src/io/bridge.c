/* SPDX-License-Identifier: MIT */
#include "io/bridge.h"

#include <stdio.h>
#include <string.h>

#include "core/alloc.h"
#include "core/context.h"
#include "io/bridge/bridge.h"
#include "port/port.h"

#ifndef IBL_BRIDGE
#define IBL_BRIDGE "/usr/local/lib/iblbake/libiblbridge.so"
#endif

enum {
    DECODED = 34 /* bytes of a pixel that OpenImageIO takes at most: floats of
                    4 channels, twice */
};

const char *ibl_bridge_path(void)
{
    return IBL_BRIDGE;
}

ibl_status ibl_bridge_find(const ibl_input *in, const char *object,
                           const char *needs, const char *function, void *call)
{
    const char *given = ibl_ctx_bridge(in->ctx);
    const char *bridge = given ? given : ibl_bridge_path();
    const char *slash = strrchr(bridge, '/');
    char path[IBL_PORT_PATH], why[IBL_PORT_WHY];

    snprintf(path, sizeof path, "%.*s%s",
             object && slash ? (int)(slash + 1 - bridge) : 0, bridge,
             object ? object : bridge);
    if (ibl_port_load(path, function, call, why))
        return IBL_OK;
    if (!ibl_port_loads)
        return ibl_unsupported(
            in, "%s, which this build does not read: %s, or bake it on Linux",
            needs,
            object ? "save it with the compression ZIP"
                   : "save it as .hdr or .exr");
    if (!*why)
        return ibl_unsupported(in,
                               "%s is not the image bridge of this version: "
                               "install or build iblbake again",
                               path);
    return ibl_unsupported(
        in, "%s, which needs %s, which cannot be loaded: %s: %s", needs,
        object ? object : "the image bridge", why,
        object ? "install or build iblbake again"
               : "install the package libopenimageio2.4, or "
                 "libopenimageio-dev and build iblbake again");
}

/* A picture that the bridge reads. */
typedef struct picture {
    const ibl_input *in;
    const ibl_read_options *opts;
    ibl_status status; /* of begin or go_on */
    ibl_rows *rows;
} picture;

/*
 * Limits the memory by the size of the file. Unpacked data of up to 100 MB are
 * always accepted; else they may be 2048 times the file. zlib reaches at most
 * 1032:1.
 */
static int begin(void *user, const ibl_bridge_info *info, float **rgb,
                 float **alpha)
{
    picture *p = user;
    const bool lies = info->orientation > 4; /* rows are columns */
    const size_t pixels = (size_t)info->width * (size_t)info->height;

    ibl_image img = {0};

    p->status =
        ibl_map_check_size(p->in, p->opts, lies ? info->height : info->width,
                           lies ? info->width : info->height);
    if (!p->status && info->raw_bytes > 1e8 &&
        info->raw_bytes > 2048.0 * (double)p->in->size)
        p->status = ibl_bad_file(p->in,
                                 "%zu bytes claim to hold %dx%d pixels, which "
                                 "is taken for damage",
                                 p->in->size, info->width, info->height);
    if (!p->status)
        p->status = ibl_allow(p->in, (12 + DECODED) * pixels);
    if (!p->status)
        p->status = ibl_map_alloc(p->in, info->width, info->height, &img);
    if (!p->status)
        p->status = ibl_rows_of_image(p->in->ctx, &img, NULL, &p->rows);
    if (!p->status && info->has_alpha)
        p->status = ibl_rows_alloc_alpha(p->rows);
    if (p->status)
        return 0;
    ibl_rows *r = p->rows;
    r->straight = info->straight;
    r->orientation = info->orientation;
    r->report.bridged = 1;
    r->report.low_range = info->low_range;
    if (info->cube)
        r->report.layout = IBL_INPUT_CUBE;
    snprintf(r->report.format, sizeof r->report.format, "%s by OpenImageIO",
             info->format);
    *rgb = r->whole.data;
    *alpha = r->alpha;
    return 1;
}

static int go_on(void *user)
{
    picture *p = user;

    p->status = ibl_cancelled(p->in->ctx) ? IBL_ERR_CANCELLED : IBL_OK;
    return !p->status;
}

ibl_status ibl_bridge_rows(const ibl_input *in, const ibl_image_kind *kind,
                           const ibl_read_options *opts, ibl_rows **rows)
{
    picture p = {.in = in, .opts = opts};
    const ibl_bridge_request request = {
        .bytes = in->bytes,
        .size = in->size,
        .reader = kind->reader,
        .want_alpha = opts->alpha != IBL_ALPHA_IGNORE,
        .encoded = opts->transfer == IBL_TRANSFER_FILE     ? -1
                   : opts->transfer == IBL_TRANSFER_LINEAR ? 1
                                                           : 0,
        .threads = ibl_ctx_threads(in->ctx),
        .user = &p,
        .begin = begin,
        .go_on = go_on};
    char message[IBL_BRIDGE_MESSAGE], text[64];
    ibl_bridge_read_fn *read;

    snprintf(text, sizeof text, "is %s", kind->name);
    const ibl_status status =
        ibl_bridge_find(in, NULL, text, IBL_BRIDGE_READ, &read);
    if (status)
        return status;
    const ibl_bridge_result result = read(&request, message);
    *rows = p.rows;
    if (result == IBL_BRIDGE_MEMORY)
        return ibl_reject(in, IBL_ERR_MEMORY, "no memory to decode it");
    if (result == IBL_BRIDGE_FORMAT)
        return ibl_bad_file(in, "damaged or unsupported %s: %s", kind->name,
                            message);
    return p.status;
}
