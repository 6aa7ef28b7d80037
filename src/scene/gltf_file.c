/* SPDX-License-Identifier: MIT */
/* The JSON of a .gltf or .glb file, its buffers, and the bytes of its images.
 */
#include <stdlib.h>
#include <string.h>

#include "common/names.h"
#include "common/path.h"
#include "core/alloc.h"
#include "scene/gltf_reader.h"
#include "json/json_load.h"
#include "json/text.h"

enum {
    HEADER = 12, /* bytes of .glb before its chunks */
    CHUNK = 8    /* bytes of a chunk before its data */
};

/* What is known, or can be left out of a scene that needs it. */
static const char *const known[] = {"EXT_mesh_manifold",
                                    "KHR_animation_pointer",
                                    "KHR_lights_punctual",
                                    "KHR_materials_anisotropy",
                                    "KHR_materials_clearcoat",
                                    "KHR_materials_dispersion",
                                    "KHR_materials_emissive_strength",
                                    "KHR_materials_ior",
                                    "KHR_materials_iridescence",
                                    "KHR_materials_sheen",
                                    "KHR_materials_specular",
                                    "KHR_materials_transmission",
                                    "KHR_materials_unlit",
                                    "KHR_materials_variants",
                                    "KHR_materials_volume",
                                    "KHR_mesh_quantization",
                                    "KHR_texture_transform",
                                    "KHR_xmp_json_ld",
                                    NULL};

static uint32_t word(const unsigned char *p)
{
    return p[0] | (uint32_t)p[1] << 8 | (uint32_t)p[2] << 16 |
           (uint32_t)p[3] << 24;
}

/* ---- files and data URIs ---------------------------------------------- */

/* Adds an input that the scene keeps; NULL: no memory. */
static ibl_input *add_input(ibl_gltf *g)
{
    struct ibl_scene_store *s = calloc(1, sizeof *s);

    if (!s) {
        ibl_gltf_no_memory(g);
        return NULL;
    }
    s->next = g->scene->store;
    s->in = ibl_input_of(g->ctx, g->path, NULL, 0);
    g->scene->store = s;
    return &s->in;
}

static bool add_path(ibl_gltf *g, const char *path)
{
    ibl_scene *s = g->scene;
    char **files =
        realloc(s->files, ((size_t)s->file_count + 1) * sizeof *files);

    if (files)
        s->files = files;
    if (!files || !(files[s->file_count] = strdup(path)))
        return ibl_gltf_no_memory(g);
    s->file_count++;
    return true;
}

/* Reads a file, which the scene keeps. */
static bool read_file(ibl_gltf *g, const char *path, ibl_gltf_bytes *out)
{
    ibl_input *in = add_input(g);

    if (!in || !add_path(g, path))
        return false;
    g->status = ibl_input_open(
        g->ctx, g->scene->files[g->scene->file_count - 1], NULL, in);
    if (!g->status)
        g->status = ibl_input_load(in);
    *out = (ibl_gltf_bytes){in->bytes, in->size};
    return !g->status;
}

/* RFC 4648; text may end in '='. Returns the bytes, or SIZE_MAX. */
static size_t decode_base64(const char *text, unsigned char *out)
{
    static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopq"
                                 "rstuvwxyz0123456789+/";
    uint32_t bits = 0;
    size_t size = 0;
    int count = 0;

    for (; *text && *text != '='; text++) {
        const char *digit = strchr(digits, *text);
        if (!digit)
            return SIZE_MAX;
        bits = bits << 6 | (uint32_t)(digit - digits);
        if ((count += 6) < 8)
            continue;
        count -= 8;
        out[size++] = (unsigned char)(bits >> count);
    }
    return text[strspn(text, "=")] ? SIZE_MAX : size;
}

static bool read_data(ibl_gltf *g, ibl_json_at at, const char *uri,
                      ibl_gltf_bytes *out)
{
    const char *comma = strchr(uri, ',');
    ibl_input *in = add_input(g);

    if (!in)
        return false;
    if (!comma || comma - uri < 7 || strncmp(comma - 7, ";base64", 7) != 0)
        return ibl_json_complain(at, "expected a data URI of base64");
    unsigned char *bytes = ibl_alloc_array(strlen(comma), 1);
    if (!bytes)
        return ibl_gltf_no_memory(g);
    in->owned = bytes;
    *out = (ibl_gltf_bytes){bytes, decode_base64(comma + 1, bytes)};
    return out->size != SIZE_MAX ||
           ibl_json_complain(at, "damaged: its data are no base64");
}

/* Reads what a URI names. */
static bool read_uri(ibl_gltf *g, ibl_json_at at, ibl_gltf_bytes *out)
{
    const char *uri;

    if (!ibl_json_text_at(at, &uri))
        return false;
    if (!strncmp(uri, "data:", 5))
        return read_data(g, at, uri, out);
    char *name = strdup(uri), *path = NULL;
    bool ok = name || ibl_gltf_no_memory(g);
    ok = ok &&
         (ibl_uri_decode(name) || ibl_json_wrong(at, "a URI without %%00"));
    if (ok) {
        path = ibl_path_beside(g->path, name);
        ok = path ? read_file(g, path, out) : ibl_gltf_no_memory(g);
    }
    free(name);
    free(path);
    return ok;
}

/* ---- the JSON --------------------------------------------------------- */

/* Finds the chunks of .glb; of .gltf the JSON is all. */
static bool find_chunks(ibl_gltf *g, ibl_gltf_bytes all, ibl_gltf_bytes *json)
{
    const unsigned char *b = all.bytes;

    *json = all;
    if (all.size < HEADER || memcmp(b, "glTF", 4) != 0)
        return true;
    if (word(b + 4) != 2)
        return ibl_json_complain(g->root, "glTF of version %u: only 2 is read",
                                 word(b + 4));
    const size_t end = word(b + 8);
    if (end > all.size || end < HEADER + CHUNK ||
        memcmp(b + HEADER + 4, "JSON", 4) != 0 ||
        word(b + HEADER) > end - HEADER - CHUNK)
        return ibl_json_complain(g->root, "damaged: a .glb that is cut short");
    *json = (ibl_gltf_bytes){b + HEADER + CHUNK, word(b + HEADER)};
    const size_t at = HEADER + CHUNK + json->size;
    if (end - at < CHUNK || memcmp(b + at + 4, "BIN\0", 4) != 0)
        return true;
    if (word(b + at) > end - at - CHUNK)
        return ibl_json_complain(g->root, "damaged: its bytes are cut short");
    g->chunk = (ibl_gltf_bytes){b + at + CHUNK, word(b + at)};
    return true;
}

static bool parse(ibl_gltf *g, ibl_gltf_bytes json)
{
    ibl_json_why why;

    while (json.size && !json.bytes[json.size - 1])
        json.size--;
    g->json.root = ibl_json_parse(g->json.name, json.bytes, json.size, 0, &why);
    g->root = ibl_json_root(&g->json);
    if (!g->json.root)
        g->json.fail(g->json.cookie, why.line);
    return g->json.root;
}

static bool check_version(ibl_gltf *g)
{
    const ibl_json_at asset = ibl_json_member(&g->root, "asset");
    const ibl_json_at at = ibl_json_member(&asset, "version");
    const char *version;

    return ibl_json_text_at(at, &version) &&
           (!strncmp(version, "2.", 2) ||
            ibl_json_wrong(at, "glTF 2.0, to which others are converted"));
}

static bool check_extensions(ibl_gltf *g)
{
    ibl_json_at array;
    int count;

    if (!ibl_gltf_array(g, "extensionsRequired", &array, &count))
        return false;
    for (int i = 0; i < count; i++) {
        const ibl_json_at at = ibl_json_element(&array, (size_t)i);
        const char *name;
        if (!ibl_json_text_at(at, &name))
            return false;
        if (ibl_names_find(known, name) < 0)
            return ibl_json_complain(at, "%.60s is not read: export it without",
                                     name);
    }
    return true;
}

/* ---- buffers ---------------------------------------------------------- */

static bool read_buffer(ibl_gltf *g, ibl_json_at at, int i)
{
    const ibl_json_at uri = ibl_json_member(&at, "uri");
    ibl_gltf_bytes *b = &g->buffers[i];
    int size = 0;

    if (!ibl_json_int(ibl_json_member(&at, "byteLength"), 1, INT32_MAX, &size))
        return false;
    if (uri.value) {
        if (!read_uri(g, uri, b))
            return false;
    } else if (i == 0 && g->chunk.bytes) {
        *b = g->chunk;
    } else {
        return ibl_json_wrong(uri, "a URI, since there is no binary chunk");
    }
    if ((size_t)size > b->size)
        return ibl_json_complain(ibl_json_member(&at, "byteLength"),
                                 "damaged: %d bytes, but there are only %zu",
                                 size, b->size);
    b->size = (size_t)size;
    return true;
}

bool ibl_gltf_open(ibl_gltf *g)
{
    ibl_gltf_bytes all, json;
    ibl_json_at array;

    if (!read_file(g, g->path, &all) || !find_chunks(g, all, &json) ||
        !parse(g, json) || !check_version(g) || !check_extensions(g) ||
        !ibl_gltf_array(g, "buffers", &array, &g->buffer_count))
        return false;
    g->buffers = calloc((size_t)g->buffer_count + 1, sizeof *g->buffers);
    if (!g->buffers)
        return ibl_gltf_no_memory(g);
    for (int i = 0; i < g->buffer_count; i++)
        if (!read_buffer(g, ibl_json_element(&array, (size_t)i), i))
            return false;
    return true;
}

bool ibl_gltf_view(ibl_gltf *g, ibl_json_at index, ibl_gltf_bytes *view,
                   int *stride)
{
    ibl_json_at array;
    int count, i, buffer, offset = 0, size;

    if (!ibl_gltf_array(g, "bufferViews", &array, &count) ||
        !ibl_gltf_index(index, count, &i))
        return false;
    const ibl_json_at at = ibl_json_element(&array, (size_t)i);
    if (!ibl_gltf_index(ibl_json_member(&at, "buffer"), g->buffer_count,
                        &buffer) ||
        !ibl_json_int(ibl_json_optional(&at, "byteOffset"), 0, INT32_MAX,
                      &offset) ||
        !ibl_json_int(ibl_json_member(&at, "byteLength"), 1, INT32_MAX,
                      &size) ||
        !ibl_json_int(ibl_json_optional(&at, "byteStride"), 0, 4096, stride))
        return false;
    const ibl_gltf_bytes *b = &g->buffers[buffer];
    if ((size_t)offset > b->size || (size_t)size > b->size - (size_t)offset)
        return ibl_json_complain(at,
                                 "damaged: bytes %d to %lld of a buffer "
                                 "of %zu",
                                 offset, (long long)offset + size, b->size);
    *view = (ibl_gltf_bytes){b->bytes + offset, (size_t)size};
    return true;
}

/* ---- images ----------------------------------------------------------- */

static bool read_image(ibl_gltf *g, ibl_json_at at, int i)
{
    const ibl_json_at uri = ibl_json_member(&at, "uri");
    ibl_scene_image *image = &g->scene->images[i];
    const int files = g->scene->file_count;
    ibl_gltf_bytes bytes;
    int stride = 0;

    if (uri.value ? !read_uri(g, uri, &bytes)
                  : !ibl_gltf_view(g, ibl_json_member(&at, "bufferView"),
                                   &bytes, &stride))
        return false;
    image->encoded = bytes.bytes;
    image->encoded_size = bytes.size;
    image->name = g->scene->file_count > files
                      ? strdup(g->scene->files[files])
                      : ibl_format("%s: %s", g->path, at.path);
    return image->name || ibl_gltf_no_memory(g);
}

bool ibl_gltf_images(ibl_gltf *g)
{
    ibl_scene *s = g->scene;
    ibl_json_at array;

    if (!ibl_gltf_array(g, "images", &array, &s->image_count))
        return false;
    s->images = calloc((size_t)s->image_count + 1, sizeof *s->images);
    if (!s->images)
        return ibl_gltf_no_memory(g);
    for (int i = 0; i < s->image_count; i++)
        if (!read_image(g, ibl_json_element(&array, (size_t)i), i))
            return false;
    return true;
}
