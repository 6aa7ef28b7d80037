// SPDX-License-Identifier: MIT
// The one C++ file of models: meshoptimizer, Draco and libwebp behind a C
// interface. Those that the Makefile did not find are left out.
#include "scene/bridge/scene_bridge.h"

#include <cstdlib>
#include <cstring>
#include <memory>
#include <new>

#ifndef IBL_HAS_MESHOPT
#define IBL_HAS_MESHOPT 0
#endif
#ifndef IBL_HAS_WEBP
#define IBL_HAS_WEBP 0
#endif
#ifndef IBL_HAS_DRACO
#define IBL_HAS_DRACO 0
#endif

#if IBL_HAS_MESHOPT
#include <meshoptimizer.h>
#endif
#if IBL_HAS_WEBP
#include <webp/decode.h>
#endif
#if IBL_HAS_DRACO
#include <malloc.h>

#include <draco/compression/decode.h>
#endif

#define VISIBLE __attribute__((visibility("default")))
#define EXPORT extern "C" VISIBLE

EXPORT int ibl_scene_bridge_abi()
{
    return IBL_SCENE_BRIDGE_ABI;
}

EXPORT int ibl_scene_bridge_has(ibl_scene_decoder d)
{
    return d == IBL_SCENE_MESHOPT ? IBL_HAS_MESHOPT
           : d == IBL_SCENE_DRACO ? IBL_HAS_DRACO
                                  : IBL_HAS_WEBP;
}

/* ---- meshoptimizer ---------------------------------------------------- */

#if IBL_HAS_MESHOPT
static bool decode_meshopt(int mode, const unsigned char *bytes, size_t size,
                           size_t count, size_t stride, void *out)
{
    if (mode == 0)
        return stride % 4 == 0 && stride <= 256 &&
               !meshopt_decodeVertexBuffer(out, count, stride, bytes, size);
    if (stride != 2 && stride != 4)
        return false;
    if (mode == 1)
        return count % 3 == 0 &&
               !meshopt_decodeIndexBuffer(out, count, stride, bytes, size);
    return !meshopt_decodeIndexSequence(out, count, stride, bytes, size);
}

EXPORT int ibl_scene_meshopt(int mode, int filter, const unsigned char *bytes,
                             size_t size, size_t count, size_t stride,
                             void *out)
{
    if (!count || !stride ||
        !decode_meshopt(mode, bytes, size, count, stride, out))
        return false;
    if (filter == 1 && (stride == 4 || stride == 8))
        meshopt_decodeFilterOct(out, count, stride);
    else if (filter == 2 && stride == 8)
        meshopt_decodeFilterQuat(out, count, stride);
    else if (filter == 3 && stride % 4 == 0)
        meshopt_decodeFilterExp(out, count, stride);
    else
        return filter == 0;
    return true;
}
#else
EXPORT int ibl_scene_meshopt(int, int, const unsigned char *, size_t, size_t,
                             size_t, void *)
{
    return false;
}
#endif

/* ---- libwebp ---------------------------------------------------------- */

#if IBL_HAS_WEBP
EXPORT int ibl_scene_webp_size(const unsigned char *bytes, size_t size,
                               int *width, int *height)
{
    return WebPGetInfo(bytes, size, width, height);
}

EXPORT int ibl_scene_webp(const unsigned char *bytes, size_t size, int width,
                          int height, unsigned char *rgba)
{
    return WebPDecodeRGBAInto(bytes, size, rgba,
                              4 * size_t(width) * size_t(height),
                              4 * width) != nullptr;
}
#else
EXPORT int ibl_scene_webp_size(const unsigned char *, size_t, int *, int *)
{
    return false;
}
EXPORT int ibl_scene_webp(const unsigned char *, size_t, int, int,
                          unsigned char *)
{
    return false;
}
#endif

/* ---- Draco ------------------------------------------------------------ */

#if IBL_HAS_DRACO
// Draco believes the sizes that a file claims. Its memory comes from these
// operators, since libraries that are loaded with this one look here first, and
// may be so much.
static thread_local bool limited;
static thread_local size_t left;

VISIBLE void *operator new(size_t size)
{
    if (limited && size > left)
        throw std::bad_alloc();
    void *p = std::malloc(size ? size : 1);
    if (!p)
        throw std::bad_alloc();
    if (limited) {
        const size_t taken = malloc_usable_size(p);
        left -= taken < left ? taken : left;
    }
    return p;
}

VISIBLE void operator delete(void *p) noexcept
{
    if (limited && p)
        left += malloc_usable_size(p);
    std::free(p);
}

VISIBLE void operator delete(void *p, size_t) noexcept
{
    operator delete(p);
}

struct ibl_draco {
    std::unique_ptr<draco::Mesh> mesh;
};

EXPORT ibl_draco *ibl_scene_draco(const unsigned char *bytes, size_t size,
                                  uint32_t *vertices, uint32_t *triangles)
{
    ibl_draco *out = nullptr;

    // Even planes take a byte for a hundred vertices of 30 bytes.
    left = (size_t(64) << 20) + 4096 * (size < (1 << 18) ? size : 1 << 18);
    left += 256 * size;
    limited = true;
    try {
        draco::DecoderBuffer buffer;
        draco::Decoder decoder;
        buffer.Init(reinterpret_cast<const char *>(bytes), size);
        auto mesh = decoder.DecodeMeshFromBuffer(&buffer);
        if (mesh.ok() && mesh.value()) {
            out = new ibl_draco{std::move(mesh).value()};
            *vertices = out->mesh->num_points();
            *triangles = out->mesh->num_faces();
            for (uint32_t i = 0; i < *triangles && out; i++)
                for (int k = 0; k < 3 && out; k++)
                    if (out->mesh->face(draco::FaceIndex(i))[k].value() >=
                        *vertices) {
                        delete out;
                        out = nullptr;
                    }
        }
    } catch (...) {
        out = nullptr;
    }
    limited = false;
    return out;
}

EXPORT int ibl_scene_draco_floats(const ibl_draco *mesh, int id, double unit,
                                  int components, float *out)
{
    const draco::PointAttribute *a =
        id < 0 ? nullptr : mesh->mesh->GetAttributeByUniqueId(uint32_t(id));
    const uint32_t count = mesh->mesh->num_points();

    if (!a || a->num_components() > components)
        return false;
    const bool plain = a->data_type() == draco::DT_FLOAT32 || a->normalized();
    const double by = plain ? 1 : 1 / unit;
    for (uint32_t i = 0; i < count; i++) {
        float *to = out + size_t(i) * size_t(components);
        const auto at = a->mapped_index(draco::PointIndex(i));
        if (at.value() >= a->size() ||
            !a->ConvertValue<float>(at, int8_t(components), to))
            return false;
        for (int k = 0; k < components; k++)
            to[k] = k < a->num_components() ? float(to[k] * by) : 1;
    }
    return true;
}

EXPORT void ibl_scene_draco_indices(const ibl_draco *mesh, uint32_t *out)
{
    for (uint32_t i = 0; i < mesh->mesh->num_faces(); i++)
        for (int k = 0; k < 3; k++)
            *out++ = mesh->mesh->face(draco::FaceIndex(i))[k].value();
}

EXPORT void ibl_scene_draco_free(ibl_draco *mesh)
{
    delete mesh;
}
#else
EXPORT ibl_draco *ibl_scene_draco(const unsigned char *, size_t, uint32_t *,
                                  uint32_t *)
{
    return nullptr;
}
EXPORT int ibl_scene_draco_floats(const ibl_draco *, int, double, int, float *)
{
    return false;
}
EXPORT void ibl_scene_draco_indices(const ibl_draco *, uint32_t *)
{
}
EXPORT void ibl_scene_draco_free(ibl_draco *)
{
}
#endif
