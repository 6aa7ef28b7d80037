// SPDX-License-Identifier: MIT
// The one C++ file of models: meshoptimizer, Draco and libwebp behind a C
// interface. Those that the Makefile did not find are left out.
#include "io/bridge/models.h"

#include <cstdlib>
#include <memory>
#include <new>

#ifdef IBL_HAS_MESHOPT
#include <meshoptimizer.h>
#endif
#ifdef IBL_HAS_WEBP
#include <webp/decode.h>
#endif
#ifdef IBL_HAS_DRACO
#include <malloc.h>

#include <draco/compression/decode.h>
#endif

#define VISIBLE __attribute__((visibility("default")))

#ifdef IBL_HAS_MESHOPT
static int decode_meshopt(int mode, int filter, const unsigned char *bytes,
                          size_t size, size_t count, size_t stride, void *out)
{
    const bool indices = stride == 2 || stride == 4;

    if (mode == 0 &&
        (stride % 4 || stride > 256 ||
         meshopt_decodeVertexBuffer(out, count, stride, bytes, size)))
        return false;
    if (mode == 1 &&
        (!indices || count % 3 ||
         meshopt_decodeIndexBuffer(out, count, stride, bytes, size)))
        return false;
    if (mode == 2 && (!indices || meshopt_decodeIndexSequence(
                                      out, count, stride, bytes, size)))
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
#endif

#ifdef IBL_HAS_WEBP
static int decode_webp(const unsigned char *bytes, size_t size, int width,
                       int height, unsigned char *rgba)
{
    return WebPDecodeRGBAInto(bytes, size, rgba,
                              4 * size_t(width) * size_t(height),
                              4 * width) != nullptr;
}
#endif

#ifdef IBL_HAS_DRACO
// Draco believes the sizes that a file claims. Its memory comes from these
// operators, since libraries that are loaded with this one look here first, and
// may be so much.
static thread_local bool limited;
static thread_local size_t left;

VISIBLE void *operator new(size_t size)
{
    void *p = limited && size > left ? nullptr : std::malloc(size ? size : 1);

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

static bool in_range(const draco::Mesh &mesh)
{
    for (uint32_t i = 0; i < mesh.num_faces(); i++)
        for (int k = 0; k < 3; k++)
            if (mesh.face(draco::FaceIndex(i))[k].value() >= mesh.num_points())
                return false;
    return true;
}

static ibl_draco *decode_draco(const unsigned char *bytes, size_t size,
                               uint32_t *vertices, uint32_t *triangles)
{
    ibl_draco *out = nullptr;

    // A plane takes a byte for a hundred vertices of 30 bytes.
    left = (size_t(64) << 20) + 256 * size +
           4096 * (size < (1 << 18) ? size : 1 << 18);
    limited = true;
    try {
        draco::DecoderBuffer buffer;
        draco::Decoder decoder;
        buffer.Init(reinterpret_cast<const char *>(bytes), size);
        auto mesh = decoder.DecodeMeshFromBuffer(&buffer);
        if (mesh.ok() && mesh.value() && in_range(*mesh.value())) {
            *vertices = mesh.value()->num_points();
            *triangles = mesh.value()->num_faces();
            out = new ibl_draco{std::move(mesh).value()};
        }
    } catch (...) {
    }
    limited = false;
    return out;
}

static int draco_floats(const ibl_draco *mesh, int id, int normalized,
                        int components, float *out)
{
    const auto *a = mesh->mesh->GetAttributeByUniqueId(uint32_t(id));
    const uint32_t count = mesh->mesh->num_points();
    double unit = 1;

    if (!a || a->num_components() > components)
        return false;
    // Types of integers alternate: signed, unsigned, from one byte on.
    if (normalized && !a->normalized() && a->data_type() < draco::DT_INT32)
        unit = (1 << (8 * draco::DataTypeLength(a->data_type()) -
                      a->data_type() % 2)) -
               1;
    for (uint32_t i = 0; i < count; i++, out += components) {
        const auto at = a->mapped_index(draco::PointIndex(i));
        if (at.value() >= a->size() ||
            !a->ConvertValue<float>(at, int8_t(components), out))
            return false;
        for (int k = 0; k < components; k++)
            out[k] = k < a->num_components() ? float(out[k] / unit) : 1;
    }
    return true;
}

static void draco_indices(const ibl_draco *mesh, uint32_t *out)
{
    for (uint32_t i = 0; i < mesh->mesh->num_faces(); i++)
        for (int k = 0; k < 3; k++)
            *out++ = mesh->mesh->face(draco::FaceIndex(i))[k].value();
}

static void draco_free(ibl_draco *mesh)
{
    delete mesh;
}
#endif

static const ibl_decoders decoders = {
#ifdef IBL_HAS_MESHOPT
    decode_meshopt,
#else
    nullptr,
#endif
#ifdef IBL_HAS_WEBP
    WebPGetInfo,    decode_webp,
#else
    nullptr, nullptr,
#endif
#ifdef IBL_HAS_DRACO
    decode_draco,   draco_floats, draco_indices,
    draco_free
#else
    nullptr, nullptr, nullptr,
    nullptr
#endif
};

extern "C" VISIBLE const ibl_decoders *ibl_decoders_of(int abi)
{
    return abi == IBL_DECODERS_ABI ? &decoders : nullptr;
}
