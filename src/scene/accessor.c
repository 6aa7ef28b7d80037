/* SPDX-License-Identifier: MIT */
/* Accessors of glTF, section 3.6.2: typed numbers in a buffer, some of which
 * another list may replace. */
#include <limits.h>
#include <math.h>
#include <string.h>

#include "common/signals.h"
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

static bool is_index(component type)
{
    return type == U8 || type == U16 || type == U32;
}

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

    if (!e->count)
        return true;
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
    static const char *const names[] = {"SCALAR", "VEC2", "VEC3", "VEC4",
                                        "MAT2",   "MAT3", "MAT4", NULL};
    static const int components[] = {1, 2, 3, 4, 4, 9, 16};
    int kind = 0, count = 0;

    if (!take_type(at, &e->type) ||
        !ibl_json_choice(ibl_json_member(&at, "type"), names, &kind) ||
        !ibl_json_int(ibl_json_member(&at, "count"), 0, IBL_SCENE_VALUES,
                      &count))
        return false;
    e->components = components[kind];
    e->count = (uint32_t)count;
    e->normalized = json_is_true(json_object_get(at.value, "normalized"));
    return true;
}

static bool find(ibl_gltf *g, ibl_json_at index, ibl_json_at *at, elements *e)
{
    ibl_json_at array;
    const int count = ibl_gltf_array(g, "accessors", &array);
    int i;

    *e = (elements){0};
    if (!ibl_gltf_index(index, count, &i))
        return false;
    *at = ibl_json_element(&array, (size_t)i);
    return take_form(*at, e);
}

bool ibl_gltf_normalized(ibl_gltf *g, ibl_json_at index)
{
    ibl_json_at at;
    elements e;

    return find(g, index, &at, &e) && e.normalized;
}

bool ibl_gltf_count(ibl_gltf *g, ibl_json_at at, uint64_t values)
{
    if (values > IBL_SCENE_VALUES - g->values)
        return ibl_json_complain(at, "over %d million numbers: simplify it",
                                 IBL_SCENE_VALUES / 1000000);
    g->values += values;
    return true;
}

/* ---- values ----------------------------------------------------------- */

void ibl_gltf_mend(ibl_gltf *g, float *values, size_t count)
{
    for (size_t i = 0; i < count; i++)
        if (!isfinite(values[i])) {
            values[i] = 0;
            g->mended++;
        }
}

/* Numbers that are asked for: floats, or else indices. */
typedef struct wanted {
    bool floats;
    int most;
    void *out;
} wanted;

/* Puts element i in the place of number to. */
static void put(const elements *e, uint32_t i, const wanted *w, size_t to)
{
    const unsigned char *p = e->bytes ? e->bytes + i * e->stride : NULL;
    float *f = (float *)w->out + to * (size_t)w->most;

    if (!w->floats) {
        ((uint32_t *)w->out)[to] = p ? word_of(p, e->type) : 0;
        return;
    }
    for (int c = 0; c < w->most; c++)
        f[c] = c >= e->components ? 1
               : p ? number_of(p + (size_t)c * size_of(e->type), e)
                   : 0;
}

/* Replaces the elements that "sparse" lists: section 3.6.2.3. */
static bool replace(ibl_gltf *g, ibl_json_at at, const elements *e,
                    const wanted *w)
{
    const ibl_json_at indices = ibl_json_member(&at, "indices");
    elements from = *e, where = {.components = 1};
    int count = 0;

    if (!ibl_json_int(ibl_json_member(&at, "count"), 0, (int)e->count,
                      &count) ||
        !take_type(indices, &where.type))
        return false;
    if (!is_index(where.type))
        return ibl_json_complain(indices, "expected unsigned numbers");
    from.count = where.count = (uint32_t)count;
    if (!take_bytes(g, indices, &where) ||
        !take_bytes(g, ibl_json_member(&at, "values"), &from))
        return false;
    for (uint32_t i = 0; i < from.count; i++) {
        const uint32_t to = word_of(where.bytes + i * where.stride, where.type);
        if (to >= e->count)
            return ibl_json_complain(indices, "damaged: element %u of %u", to,
                                     e->count);
        put(&from, i, w, to);
    }
    return true;
}

/* Reads an accessor with least to most components. */
static bool read_wanted(ibl_gltf *g, ibl_json_at index, int least, wanted *w,
                        uint32_t *count)
{
    ibl_json_at at;
    elements e;

    if (!find(g, index, &at, &e))
        return false;
    if (e.components < least || e.components > w->most)
        return ibl_json_complain(index,
                                 "expected %d to %d components, found "
                                 "%d in %s",
                                 least, w->most, e.components, at.path);
    if (!w->floats && !is_index(e.type))
        return ibl_json_complain(at, "expected unsigned numbers");
    /* Zeros cost a file nothing. */
    const bool stored = ibl_json_member(&at, "bufferView").value;
    if (!ibl_gltf_count(
            g, at, (stored ? 1 : 16) * (uint64_t)e.count * (unsigned)w->most) ||
        (stored && !take_bytes(g, at, &e)))
        return false;
    *count = e.count;
    w->out =
        ibl_need(ibl_alloc_array((size_t)e.count * (size_t)w->most + 1, 4));
    for (uint32_t i = 0; i < e.count; i++)
        put(&e, i, w, i);
    const ibl_json_at sparse = ibl_json_member(&at, "sparse");
    if (!sparse.value || replace(g, sparse, &e, w))
        return true;
    ibl_free(w->out);
    w->out = NULL;
    return false;
}

bool ibl_gltf_floats(ibl_gltf *g, ibl_json_at index, int least, int most,
                     float **out, uint32_t *count)
{
    wanted w = {.floats = true, .most = most};
    const bool ok = read_wanted(g, index, least, &w, count);

    *out = w.out;
    return ok;
}

bool ibl_gltf_indices(ibl_gltf *g, ibl_json_at index, uint32_t **out,
                      uint32_t *count)
{
    wanted w = {.most = 1};
    const bool ok = read_wanted(g, index, 1, &w, count);

    *out = w.out;
    return ok;
}
