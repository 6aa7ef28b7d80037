/* SPDX-License-Identifier: MIT */
/* What is packed in glTF: EXT_meshopt_compression and
 * KHR_draco_mesh_compression; and the decoders for it, which are loaded when
 * a file needs them. */
#include "scene/packed.h"

#include <dlfcn.h>
#include <pthread.h>
#include <string.h>

#include "common/path.h"
#include "scene/gltf_reader.h"

#ifndef IBL_SCENE_BRIDGE
#define IBL_SCENE_BRIDGE "/usr/local/lib/iblbake/libiblscene.so"
#endif

static ibl_scene_decoders loaded;
static char reason[256];
static pthread_once_t once = PTHREAD_ONCE_INIT;

/* POSIX lets a pointer from dlsym become a function pointer; C has no cast. */
static bool find(void *library, const char *name, void *call)
{
    void *symbol = dlsym(library, name);
    memcpy(call, &symbol, sizeof symbol);
    return symbol != NULL;
}

/* It stays open: statics of its libraries do not survive unloading. */
static void load(void)
{
    char path[IBL_PART_BYTES];
    int (*abi)(void);
    ibl_scene_decoders d;

    if (!ibl_path_of_part("libiblscene.so", path))
        strcpy(path, IBL_SCENE_BRIDGE);
    void *library = dlopen(path, RTLD_NOW | RTLD_LOCAL);
    if (!library)
        snprintf(reason, sizeof reason,
                 "%.180s: install or build iblbake again", dlerror());
    else if (!find(library, "ibl_scene_bridge_abi", &abi) ||
             abi() != IBL_SCENE_BRIDGE_ABI ||
             !find(library, "ibl_scene_bridge_has", &d.has) ||
             !find(library, "ibl_scene_meshopt", &d.meshopt) ||
             !find(library, "ibl_scene_webp_size", &d.webp_size) ||
             !find(library, "ibl_scene_webp", &d.webp) ||
             !find(library, "ibl_scene_draco", &d.draco) ||
             !find(library, "ibl_scene_draco_floats", &d.draco_floats) ||
             !find(library, "ibl_scene_draco_indices", &d.draco_indices) ||
             !find(library, "ibl_scene_draco_free", &d.draco_free))
        snprintf(reason, sizeof reason, "%.200s is of another version", path);
    else
        loaded = d;
}

const ibl_scene_decoders *ibl_scene_decoders_for(ibl_scene_decoder d,
                                                 const char **why)
{
    static const char *const missing[] = {
        [IBL_SCENE_MESHOPT] = "built without meshoptimizer: install "
                              "libmeshoptimizer-dev and build iblbake again",
        [IBL_SCENE_DRACO] = "built without Draco: install libdraco-dev and "
                            "build iblbake again",
        [IBL_SCENE_WEBP] = "built without WebP: install libwebp-dev and build "
                           "iblbake again"};

    pthread_once(&once, load);
    *why = loaded.has ? missing[d] : reason;
    return loaded.has && loaded.has(d) ? &loaded : NULL;
}

/* The same, reported for the first part that needs it. */
static const ibl_scene_decoders *decoders(ibl_gltf *g, ibl_json_at at,
                                          ibl_scene_decoder d)
{
    const char *why;
    const ibl_scene_decoders *all = ibl_scene_decoders_for(d, &why);

    if (all)
        return all;
    if (g->lacked & 1u << d)
        g->wrong++;
    else
        ibl_json_complain(at, "%s; all such parts are", why);
    g->lacked |= 1u << d;
    return NULL;
}

/* ---- meshoptimizer ---------------------------------------------------- */

bool ibl_gltf_unpack(ibl_gltf *g, ibl_json_at at, ibl_gltf_bytes *out,
                     int *stride)
{
    static const char *const modes[] = {"ATTRIBUTES", "TRIANGLES", "INDICES",
                                        NULL};
    static const char *const filters[] = {"NONE", "OCTAHEDRAL", "QUATERNION",
                                          "EXPONENTIAL", NULL};
    int mode = 0, filter = 0, count = 0;
    ibl_gltf_bytes packed;

    if (!ibl_json_int(ibl_json_member(&at, "byteStride"), 1, 256, stride))
        return false;
    if (out->bytes)
        return true;
    const ibl_scene_decoders *d = decoders(g, at, IBL_SCENE_MESHOPT);
    if (!d)
        return false;
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
    if (!to)
        return false;
    if (!d->meshopt(mode, filter, packed.bytes, packed.size, (size_t)count,
                    (size_t)*stride, to))
        return ibl_json_complain(at, "damaged: it cannot be unpacked");
    *out = (ibl_gltf_bytes){to, (size_t)bytes};
    return true;
}

/* ---- Draco ------------------------------------------------------------ */

bool ibl_gltf_draco(ibl_gltf *g, ibl_json_at at, ibl_draco **mesh,
                    uint32_t *vertices, uint32_t *corners)
{
    ibl_gltf_bytes packed;
    uint32_t triangles;
    int stride = 0;
    const ibl_scene_decoders *d = decoders(g, at, IBL_SCENE_DRACO);

    if (!d ||
        !ibl_gltf_view(g, ibl_json_member(&at, "bufferView"), &packed, &stride))
        return false;
    *mesh = d->draco(packed.bytes, packed.size, vertices, &triangles);
    if (!*mesh)
        return ibl_json_complain(at, "damaged: no triangles of Draco");
    if (triangles <= UINT32_MAX / 3 &&
        ibl_gltf_count(g, at, 3 * (uint64_t)triangles + *vertices)) {
        *corners = 3 * triangles;
        return true;
    }
    d->draco_free(*mesh);
    *mesh = NULL;
    return false;
}
