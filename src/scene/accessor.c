/* SPDX-License-Identifier: MIT */
/* Accessors of glTF, section 3.6.2: typed numbers in a buffer, some of which
 * another list may replace. */
#include <float.h>
#include <limits.h>
#include <math.h>
#include <string.h>

#include "core/alloc.h"
#include "scene/gltf_reader.h"

typedef enum component {
    I8 = 5120,
    U8,
    I16,
    U16,
    U32 = 5125,
    F32
} component;

/* Elements in memory. */
typedef struct elements {
    const unsigned char *bytes; /* NULL: all are 0 */
    size_t stride;
    component type;
    bool normalized;
    int components;
    uint32_t count;
} elements;

static size_t size_of(component type)
{
    return type <= U8 ? 1 : type <= U16 ? 2 : 4;
}

static uint32_t word_of(const unsigned char *p, component type)
{
    uint32_t word = 0;

    for (size_t i = 0; i < size_of(type); i++)
        word |= (uint32_t)p[i] << 8 * i;
    return word;
}

static float number_of(const unsigned char *p, const elements *e)
{
    const uint32_t word = word_of(p, e->type);
    const int sign = e->type == I8 || e->type == I16;
    const int bits = 8 * (int)size_of(e->type);
    double x = word;
    float f;

    if (e->type == F32) {
        memcpy(&f, &word, sizeof f);
        return f;
    }
    if (sign && word >> (bits - 1))
        x -= (double)(1ull << bits);
    if (e->normalized)
        x = fmax(x / (double)((1ull << (bits - sign)) - 1), -1);
    return (float)x;
}

/* ---- the JSON --------------------------------------------------------- */

static bool take_type(ibl_json_at at, component *type)
{
    int n = 0;

    if (!ibl_json_int(ibl_json_member(&at, "componentType"), I8, F32, &n))
        return false;
    *type = (component)n;
    return n != 5124 || ibl_json_wrong(ibl_json_member(&at, "componentType"),
                                       "5120 to 5123, 5125 or 5126");
}

/* Takes the bytes of count elements, whose form is set. */
static bool take_bytes(ibl_gltf *g, ibl_json_at at, elements *e)
{
    const uint64_t one = size_of(e->type) * (uint64_t)e->components;
    ibl_gltf_bytes view;
    int offset = 0, stride = 0;

    if (!ibl_gltf_view(g, ibl_json_member(&at, "bufferView"), &view, &stride) ||
        !ibl_json_int(ibl_json_optional(&at, "byteOffset"), 0, INT_MAX,
                      &offset))
        return false;
    e->stride = stride ? (size_t)stride : (size_t)one;
    const uint64_t last = (uint64_t)offset + (e->count - 1) * e->stride + one;
    if (e->stride < one || last > view.size)
        return ibl_json_complain(at,
                                 "damaged: %u elements of %llu bytes, one "
                                 "each %zu, end behind their %zu bytes",
                                 e->count, (unsigned long long)one, e->stride,
                                 view.size);
    e->bytes = view.bytes + offset;
    return true;
}

static bool take_form(ibl_json_at at, elements *e)
{
    static const char *const names[] = {"SCALAR", "VEC2", "VEC3", "VEC4", NULL};
    const ibl_json_at normalized = ibl_json_optional(&at, "normalized");
    int kind = 0, count = 0;

    if (!take_type(at, &e->type) ||
        !ibl_json_choice(ibl_json_member(&at, "type"), names, &kind) ||
        !ibl_json_int(ibl_json_member(&at, "count"), 1, IBL_SCENE_VALUES,
                      &count))
        return false;
    e->components = kind + 1;
    e->count = (uint32_t)count;
    e->normalized = json_is_true(normalized.value);
    return json_is_boolean(normalized.value) ||
           ibl_json_wrong(normalized, "true or false");
}

/* Finds an accessor with least to most components. */
static bool find(ibl_gltf *g, ibl_json_at index, int least, int most,
                 ibl_json_at *at, elements *e)
{
    ibl_json_at array;
    int count, i;

    *e = (elements){0};
    if (!ibl_gltf_array(g, "accessors", &array, &count) ||
        !ibl_gltf_index(index, count, &i))
        return false;
    *at = ibl_json_element(&array, (size_t)i);
    if (!take_form(*at, e))
        return false;
    if (ibl_json_member(at, "sparse").value)
        return ibl_json_complain(*at, "sparse, which is not read");
    if (e->components < least || e->components > most)
        return ibl_json_complain(index,
                                 "expected %d to %d components, found "
                                 "%d in %s",
                                 least, most, e->components, at->path);
    g->values += (uint64_t)e->count * (unsigned)most;
    if (g->values > IBL_SCENE_VALUES)
        return ibl_json_complain(g->root,
                                 "over %d million numbers: simplify it",
                                 IBL_SCENE_VALUES / 1000000);
    return !ibl_json_member(at, "bufferView").value || take_bytes(g, *at, e);
}

/* ---- values ----------------------------------------------------------- */

static float mended(ibl_gltf *g, float x)
{
    if (x >= -FLT_MAX && x <= FLT_MAX)
        return x;
    g->mended++;
    return 0;
}

static void copy_element(ibl_gltf *g, const elements *e, uint32_t i, int most,
                         float *to)
{
    const unsigned char *p = e->bytes ? e->bytes + i * e->stride : NULL;

    for (int c = 0; c < most; c++)
        if (c >= e->components)
            to[c] = 1;
        else
            to[c] =
                p ? mended(g, number_of(p + (size_t)c * size_of(e->type), e))
                  : 0;
}

static bool is_index(component type)
{
    return type == U8 || type == U16 || type == U32;
}

bool ibl_gltf_floats(ibl_gltf *g, ibl_json_at index, int least, int most,
                     float **out, uint32_t *count)
{
    ibl_json_at at;
    elements e;

    if (!find(g, index, least, most, &at, &e))
        return false;
    *count = e.count;
    *out = ibl_alloc_array((size_t)e.count * (size_t)most, sizeof **out);
    if (!*out)
        return ibl_gltf_no_memory(g);
    for (uint32_t i = 0; i < e.count; i++)
        copy_element(g, &e, i, most, *out + (size_t)i * (size_t)most);
    return true;
}

bool ibl_gltf_indices(ibl_gltf *g, ibl_json_at index, uint32_t **out,
                      uint32_t *count)
{
    ibl_json_at at;
    elements e;

    if (!find(g, index, 1, 1, &at, &e))
        return false;
    if (!is_index(e.type))
        return ibl_json_complain(at, "expected unsigned numbers");
    *count = e.count;
    *out = ibl_alloc_array(e.count, sizeof **out);
    if (!*out)
        return ibl_gltf_no_memory(g);
    for (uint32_t i = 0; i < e.count; i++)
        (*out)[i] = e.bytes ? word_of(e.bytes + i * e.stride, e.type) : 0;
    return true;
}
