/* SPDX-License-Identifier: MIT */
/* What is packed in glTF: EXT_meshopt_compression and
 * KHR_draco_mesh_compression; and the decoders for it and for WebP, which are
 * loaded when a file needs them. */
#include <pthread.h>
#include <stdio.h>
#include <string.h>

#include "common/path.h"
#include "port/port.h"
#include "scene/gltf_reader.h"

#ifndef IBL_SCENE_BRIDGE
#define IBL_SCENE_BRIDGE "/usr/local/lib/iblbake/libiblscene.so"
#endif

static const ibl_decoders none;
static const ibl_decoders *loaded = &none;
static char reason[256]; /* empty: the decoders are there */

/* It stays open: statics of its libraries do not survive unloading. */
static void load(void)
{
    const ibl_decoders *(*of)(int) = NULL;
    char path[IBL_PART_BYTES], why[IBL_PORT_WHY];

    if (!ibl_port_loads) {
        strcpy(reason, "this build has no decoder for it: save the model "
                       "without it, or use iblbake on Linux");
        return;
    }
    if (!ibl_path_of_part("libiblscene.so", path))
        strcpy(path, IBL_SCENE_BRIDGE);
    if (ibl_port_load(path, "ibl_decoders_of", &of, why) &&
        of(IBL_DECODERS_ABI))
        loaded = of(IBL_DECODERS_ABI);
    else
        snprintf(reason, sizeof reason,
                 "%.180s: install or build iblbake again",
                 *why ? why : "libiblscene.so is of another version");
}

const ibl_decoders *ibl_gltf_decoders(void)
{
    static pthread_once_t once = PTHREAD_ONCE_INIT;

    pthread_once(&once, load);
    return loaded;
}

/* Reports that a decoder is missing, for the first part that needs it. */
static bool lacks(ibl_gltf *g, ibl_json_at at, int decoder, const char *package)
{
    if (g->lacked & 1u << decoder)
        g->wrong++;
    else if (*reason)
        ibl_json_complain(at, "%s; all such parts are", reason);
    else
        ibl_json_complain(at,
                          "built without its decoder: install %s and build "
                          "iblbake again; all such parts are",
                          package);
    g->lacked |= 1u << decoder;
    return false;
}

bool ibl_gltf_unpack(ibl_gltf *g, ibl_json_at at, ibl_gltf_bytes *out,
                     int *stride)
{
    static const char *const modes[] = {"ATTRIBUTES", "TRIANGLES", "INDICES",
                                        NULL};
    static const char *const filters[] = {"NONE", "OCTAHEDRAL", "QUATERNION",
                                          "EXPONENTIAL", NULL};
    const ibl_decoders *d = ibl_gltf_decoders();
    int mode = 0, filter = 0, count = 0;
    ibl_gltf_bytes packed;

    if (!ibl_json_int(ibl_json_member(&at, "byteStride"), 1, 256, stride))
        return false;
    if (out->bytes)
        return true;
    if (!d->meshopt)
        return lacks(g, at, 0, "libmeshoptimizer-dev");
    if (!ibl_json_choice(ibl_json_member(&at, "mode"), modes, &mode) ||
        !ibl_json_choice(ibl_json_optional(&at, "filter"), filters, &filter) ||
        !ibl_json_int(ibl_json_member(&at, "count"), 1, IBL_SCENE_VALUES,
                      &count) ||
        !ibl_gltf_slice(g, at, &packed))
        return false;
    const uint64_t bytes = (uint64_t)count * (unsigned)*stride;
    /* Two bits stand for at least 16 bytes, of which at most all are 0. */
    if (bytes > 256 * (uint64_t)packed.size + 4096)
        return ibl_json_complain(at, "damaged: %zu bytes hold %llu",
                                 packed.size, (unsigned long long)bytes);
    if (!ibl_gltf_count(g, at, bytes / 4))
        return false;
    unsigned char *to = ibl_gltf_keep(g, (size_t)bytes);
    if (!d->meshopt(mode, filter, packed.bytes, packed.size, (size_t)count,
                    (size_t)*stride, to))
        return ibl_json_complain(at, "damaged: it cannot be unpacked");
    *out = (ibl_gltf_bytes){to, (size_t)bytes};
    return true;
}

bool ibl_gltf_draco(ibl_gltf *g, ibl_json_at at, ibl_draco **mesh,
                    uint32_t *vertices, uint32_t *corners)
{
    const ibl_decoders *d = ibl_gltf_decoders();
    ibl_gltf_bytes packed;
    uint32_t triangles;
    int stride = 0;

    if (!d->draco)
        return lacks(g, at, 1, "libdraco-dev");
    if (!ibl_gltf_view(g, ibl_json_member(&at, "bufferView"), &packed, &stride))
        return false;
    *mesh = d->draco(packed.bytes, packed.size, vertices, &triangles);
    if (!*mesh)
        return ibl_json_complain(at, "damaged: no triangles of Draco");
    *corners = 3 * triangles;
    if (triangles <= UINT32_MAX / 3 &&
        ibl_gltf_count(g, at, 3 * (uint64_t)triangles + *vertices))
        return true;
    d->draco_free(*mesh);
    *mesh = NULL;
    return false;
}
