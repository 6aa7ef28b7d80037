/* SPDX-License-Identifier: MIT */
/* The JSON of a .gltf or .glb file, its buffers, and the bytes of its images.
 */
#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>
#include <unistd.h>

#include "common/names.h"
#include "common/path.h"
#include "common/signals.h"
#include "core/alloc.h"
#include "core/context.h"
#include "scene/gltf_reader.h"
#include "json/json_load.h"
#include "json/text.h"

enum {
    HEADER = 12,    /* bytes of .glb before its chunks */
    CHUNK = 8,      /* bytes of a chunk before its data */
    MOST_NAMES = 64 /* of extensions */
};

/* Extensions that are read, and what it means that another is not, by words in
 * its name. */
static const char *const known[] = {"EXT_mesh_gpu_instancing",
                                    "EXT_meshopt_compression",
                                    "EXT_texture_webp",
                                    "KHR_draco_mesh_compression",
                                    "KHR_materials_anisotropy",
                                    "KHR_materials_clearcoat",
                                    "KHR_materials_emissive_strength",
                                    "KHR_materials_ior",
                                    "KHR_materials_pbrSpecularGlossiness",
                                    "KHR_materials_sheen",
                                    "KHR_materials_specular",
                                    "KHR_materials_transmission",
                                    "KHR_materials_unlit",
                                    "KHR_mesh_quantization",
                                    "KHR_node_visibility",
                                    "KHR_texture_transform",
                                    NULL};
static const struct {
    const char *word, *lost;
} meanings[] = {
    {"variants", "the materials of no variant are taken"},
    {"materials", "surfaces are drawn without it"},
    {"texture", "its images give way to others, or to their factors"},
    {"light", "its light is left out"},
    {"compression", "what it packs is left out"},
    {"animation", "nothing moves"},
    {"xmp", "it changes nothing that is drawn"},
    {"manifold", "it changes nothing that is drawn"},
    {"", "what it adds is left out"},
};

static uint32_t word(const unsigned char *p)
{
    return p[0] | (uint32_t)p[1] << 8 | (uint32_t)p[2] << 16 |
           (uint32_t)p[3] << 24;
}

/* ---- files and data URIs ---------------------------------------------- */

/* Adds an input that the scene keeps. */
static ibl_input *add_input(ibl_gltf *g)
{
    struct ibl_scene_store *s = ibl_need(calloc(1, sizeof *s));

    s->next = g->scene->store;
    s->in = ibl_input_of(g->ctx, g->path, NULL, 0);
    g->scene->store = s;
    return &s->in;
}

unsigned char *ibl_gltf_keep(ibl_gltf *g, size_t size)
{
    ibl_input *in = add_input(g);

    in->owned = ibl_need(ibl_alloc_zeroed(size + 1, 1));
    return in->owned;
}

/* Reads a file, which the scene keeps. */
static bool read_file(ibl_gltf *g, const char *path, ibl_gltf_bytes *out)
{
    ibl_scene *s = g->scene;
    ibl_input *in = add_input(g);
    char *name = ibl_need(strdup(path));

    s->files = ibl_need(
        realloc(s->files, ((size_t)s->file_count + 1) * sizeof *s->files));
    s->files[s->file_count++] = name;
    g->status = ibl_input_open(g->ctx, name, in);
    if (!g->status)
        g->status = ibl_input_load(in);
    *out = (ibl_gltf_bytes){in->bytes, in->size};
    return !g->status;
}

/* RFC 4648, as the Infra standard forgives: blanks do not count, text may end
 * in '='. Returns the bytes, in place, or SIZE_MAX. */
static size_t decode_base64(char *text)
{
    static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopq"
                                 "rstuvwxyz0123456789+/";
    uint32_t bits = 0;
    char *first = text, *to = text;
    int count = 0;

    for (; *text && *text != '='; text++) {
        const char *digit = strchr(digits, *text);
        if (strchr(" \t\n\f\r", *text))
            continue;
        if (!digit)
            return SIZE_MAX;
        bits = bits << 6 | (uint32_t)(digit - digits);
        if ((count += 6) < 8)
            continue;
        count -= 8;
        *to++ = (char)(bits >> count);
    }
    return text[strspn(text, "= \t\n\f\r")] ? SIZE_MAX : (size_t)(to - first);
}

/* A data URI: the Fetch standard, "data: URL processor". */
static bool read_data(ibl_gltf *g, ibl_json_at at, const char *uri,
                      ibl_gltf_bytes *out)
{
    const char *comma = strchr(uri, ',');

    if (!comma)
        return ibl_json_complain(at, "damaged: a data URI without a comma");
    char *bytes = (char *)ibl_gltf_keep(g, strlen(comma));
    strcpy(bytes, comma + 1);
    *out = (ibl_gltf_bytes){(unsigned char *)bytes, ibl_uri_bytes(bytes)};
    while (comma > uri && comma[-1] == ' ')
        comma--;
    if (comma - uri >= 6 && !strncasecmp(comma - 6, "base64", 6))
        out->size = decode_base64(bytes);
    return out->size != SIZE_MAX ||
           ibl_json_complain(at, "damaged: its data are no base64");
}

/* Reads what a URI names, as browsers do: a backslash is a slash, and what
 * follows ? or # is no part of the name of a file. */
static bool read_uri(ibl_gltf *g, ibl_json_at at, ibl_gltf_bytes *out)
{
    const char *uri;

    if (!ibl_json_text_at(at, &uri))
        return false;
    if (!strncasecmp(uri, "data:", 5))
        return read_data(g, at, uri, out);
    char *name = ibl_need(strdup(uri)), *path = NULL;
    name[strcspn(name, "?#")] = '\0';
    for (char *c = name; *c; c++)
        *c = *c == '\\' ? '/' : *c;
    bool ok = ibl_uri_decode(name) || ibl_json_wrong(at, "a URI without %%00");
    if (ok) {
        struct stat st;
        path = ibl_need(ibl_path_beside(g->path, name));
        if (access(path, R_OK) || stat(path, &st))
            ok = ibl_json_complain(at, "%.200s cannot be read: %s", path,
                                   strerror(errno));
        else if (!S_ISREG(st.st_mode) || !st.st_size)
            ok = ibl_json_complain(at, "%.200s is empty, or no file", path);
        else
            ok = read_file(g, path, out);
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
        return ibl_gltf_refuse(g,
                               "glTF of version %u: only 2 is read, to "
                               "which converters make it",
                               word(b + 4));
    const size_t end = word(b + 8);
    if (end > all.size || end < HEADER + CHUNK ||
        memcmp(b + HEADER + 4, "JSON", 4) != 0 ||
        word(b + HEADER) > end - HEADER - CHUNK)
        return ibl_gltf_refuse(g, "damaged: a .glb that is cut short");
    *json = (ibl_gltf_bytes){b + HEADER + CHUNK, word(b + HEADER)};
    const size_t at = HEADER + CHUNK + json->size;
    if (end - at < CHUNK || memcmp(b + at + 4, "BIN\0", 4) != 0)
        return true;
    if (word(b + at) > end - at - CHUNK)
        return ibl_gltf_refuse(g, "damaged: its bytes are cut short");
    g->chunk = (ibl_gltf_bytes){b + at + CHUNK, word(b + at)};
    return true;
}

static bool parse(ibl_gltf *g, ibl_gltf_bytes json)
{
    ibl_json_why why;

    while (json.size && !json.bytes[json.size - 1])
        json.size--;
    if (json.size >= 3 && !memcmp(json.bytes, "\xef\xbb\xbf", 3))
        json = (ibl_gltf_bytes){json.bytes + 3, json.size - 3};
    g->json.root =
        ibl_json_parse("glTF", json.bytes, json.size, JSON_ALLOW_NUL, &why);
    if (!g->json.root && why.status == IBL_ERR_FORMAT) {
        /* Names may be in another encoding, which browsers do not mind. */
        unsigned char *ascii = ibl_gltf_keep(g, json.size);
        for (size_t i = 0; i < json.size; i++)
            ascii[i] = json.bytes[i] < 0x80 ? json.bytes[i] : '?';
        g->json.root =
            ibl_json_parse("glTF", ascii, json.size, JSON_ALLOW_NUL, &why);
    }
    g->root = ibl_json_root(&g->json);
    return json_is_object(g->json.root) ||
           ibl_gltf_refuse(g, "no glTF: %s",
                           g->json.root ? "no object" : why.line);
}

/* Of 1.0 the version may be absent, and meshes are no array. */
static bool check_version(ibl_gltf *g)
{
    const json_t *asset = json_object_get(g->json.root, "asset");
    const char *version = json_string_value(json_object_get(asset, "version"));
    char quoted[IBL_QUOTE_BYTES];

    if (!version && json_is_object(json_object_get(g->json.root, "meshes")))
        version = "1.0";
    if (version && version[0] == '2')
        return true;
    return ibl_gltf_refuse(g,
                           "%s%s: only glTF 2.0 is read, to which "
                           "converters make others",
                           version ? "glTF "
                                   : "no glTF, since it has no "
                                     "asset.version",
                           version ? ibl_quote(version, quoted) : "");
}

/* Names each extension once that is not read; strict, refuses one that the file
 * needs. */
static void check_extensions(ibl_gltf *g)
{
    ibl_json_at list[2];
    const int used = ibl_gltf_array(g, "extensionsUsed", &list[0]);
    const int all = used + ibl_gltf_array(g, "extensionsRequired", &list[1]);
    const char *told[MOST_NAMES], *name;
    int count = 0, k;

    for (int i = 0; i < all && count < MOST_NAMES && !g->status; i++) {
        const bool needed = i >= used;
        name = json_string_value(json_array_get(
            list[needed].value, (size_t)(needed ? i - used : i)));
        for (k = 0; name && k < count && strcmp(name, told[k]); k++)
            ;
        if (!name || ibl_names_find(known, name) >= 0 ||
            (k < count && !(needed && g->strict)))
            continue;
        char quoted[IBL_QUOTE_BYTES];
        told[count++] = name;
        for (k = 0; !strstr(name, meanings[k].word); k++)
            ;
        if (needed && g->strict)
            ibl_gltf_refuse(g, "it needs %s, which is not read: %s",
                            ibl_quote(name, quoted), meanings[k].lost);
        else
            ibl_warn(g->ctx, "%s: %s is not read: %s", g->path,
                     ibl_quote(name, quoted), meanings[k].lost);
    }
}

/* ---- buffers ---------------------------------------------------------- */

static void read_buffer(ibl_gltf *g, ibl_json_at at, int i)
{
    const ibl_json_at uri = ibl_json_member(&at, "uri");
    ibl_gltf_bytes *b = &g->buffers[i], bytes = {0};
    int size = 0;

    if (!ibl_json_int(ibl_json_member(&at, "byteLength"), 0, INT32_MAX, &size))
        return;
    if (uri.value) {
        if (!read_uri(g, uri, &bytes))
            return;
    } else if (i == 0 && g->chunk.bytes) {
        bytes = g->chunk;
    } else if (json_object_get(at.value, "extensions")) {
        return; /* what EXT_meshopt_compression has in place of its bytes */
    } else {
        ibl_json_wrong(uri, "a URI, since there is no binary chunk");
        return;
    }
    *b = bytes;
    if ((size_t)size > bytes.size)
        ibl_json_complain(ibl_json_member(&at, "byteLength"),
                          "damaged: %d bytes, but there are only %zu: what is "
                          "behind them is",
                          size, bytes.size);
    else
        b->size = (size_t)size;
}

bool ibl_gltf_open(ibl_gltf *g)
{
    ibl_gltf_bytes all, json;
    ibl_json_at array, views;

    if (!read_file(g, g->path, &all) || !find_chunks(g, all, &json) ||
        !parse(g, json) || !check_version(g))
        return false;
    check_extensions(g);
    g->buffer_count = ibl_gltf_array(g, "buffers", &array);
    const int count = ibl_gltf_array(g, "bufferViews", &views);
    g->buffers =
        ibl_need(calloc((size_t)g->buffer_count + 1, sizeof *g->buffers));
    g->views = ibl_need(calloc((size_t)count + 1, sizeof *g->views));
    for (int i = 0; i < g->buffer_count && !g->status; i++)
        read_buffer(g, ibl_json_element(&array, (size_t)i), i);
    return !g->status;
}

bool ibl_gltf_slice(ibl_gltf *g, ibl_json_at at, ibl_gltf_bytes *slice)
{
    int buffer, offset = 0, size;

    if (!ibl_gltf_index(ibl_json_member(&at, "buffer"), g->buffer_count,
                        &buffer) ||
        !ibl_json_int(ibl_json_optional(&at, "byteOffset"), 0, INT32_MAX,
                      &offset) ||
        !ibl_json_int(ibl_json_member(&at, "byteLength"), 1, INT32_MAX, &size))
        return false;
    const ibl_gltf_bytes *b = &g->buffers[buffer];
    if ((size_t)offset > b->size || (size_t)size > b->size - (size_t)offset)
        return ibl_json_complain(at,
                                 "damaged: bytes %d to %lld of a buffer "
                                 "of %zu",
                                 offset, (long long)offset + size, b->size);
    *slice = (ibl_gltf_bytes){b->bytes + offset, (size_t)size};
    return true;
}

bool ibl_gltf_view(ibl_gltf *g, ibl_json_at index, ibl_gltf_bytes *view,
                   int *stride)
{
    ibl_json_at array, packed;
    const int count = ibl_gltf_array(g, "bufferViews", &array);
    int i;

    if (!ibl_gltf_index(index, count, &i))
        return false;
    const ibl_json_at at = ibl_json_element(&array, (size_t)i);
    if (!ibl_gltf_extension(at, "EXT_meshopt_compression", &packed))
        return false;
    if (packed.value) {
        if (!ibl_gltf_unpack(g, packed, &g->views[i], stride))
            return false;
        *view = g->views[i];
        return true;
    }
    return ibl_json_int(ibl_json_optional(&at, "byteStride"), 0, 4096,
                        stride) &&
           ibl_gltf_slice(g, at, view);
}

/* ---- images ----------------------------------------------------------- */

static void read_image(ibl_gltf *g, ibl_json_at at, int i)
{
    const ibl_json_at uri = ibl_json_member(&at, "uri");
    ibl_scene_image *image = &g->scene->images[i];
    const char *data = json_string_value(uri.value);
    ibl_gltf_bytes bytes = {0};
    int stride = 0;

    if (uri.value ? !read_uri(g, uri, &bytes)
                  : !ibl_gltf_view(g, ibl_json_member(&at, "bufferView"),
                                   &bytes, &stride))
        bytes = (ibl_gltf_bytes){0};
    image->encoded = bytes.bytes;
    image->encoded_size = bytes.size;
    image->name =
        ibl_need(data && strncasecmp(data, "data:", 5) != 0
                     ? ibl_format("%s: %s: %.200s", g->path, at.path, data)
                     : ibl_format("%s: %s", g->path, at.path));
}

void ibl_gltf_images(ibl_gltf *g)
{
    ibl_scene *s = g->scene;
    ibl_json_at array;

    s->image_count = ibl_gltf_array(g, "images", &array);
    s->images = ibl_need(calloc((size_t)s->image_count + 1, sizeof *s->images));
    for (int i = 0; i < s->image_count && !g->status; i++)
        read_image(g, ibl_json_element(&array, (size_t)i), i);
}
