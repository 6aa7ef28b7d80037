/* SPDX-License-Identifier: MIT */
/*
 * Keys and values of a texture, and those that say what it holds and how
 * shaders look it up. KTX and KTX2 store them as
 *     uint32 size of key, its zero and value; key; 0; value; padding to 4
 */
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "core/alloc.h"
#include "core/context.h"
#include "io/colour_space.h"
#include "io/container.h"
#include "io/sidecar_facts.h"
#include "json/json_text.h"

enum {
    MAX_KEYS = 4096,
    MAX_KEY_BYTES = 255
};

static const char orientation_key[] = "KTXorientation";
static const char writer_key[] = "KTXwriter";
static const char writer[] = "iblbake " IBL_VERSION;

static char *copy_text(const void *text, size_t n)
{
    char *copy = ibl_alloc_array(n + 1, 1);
    if (copy) {
        memcpy(copy, text, n);
        copy[n] = '\0';
    }
    return copy;
}

/* Whether there is a key. *at: its index, or where it belongs. */
static bool find_key(const ibl_texture *tex, const char *key, int *at)
{
    int low = 0, high = tex->key_count;
    while (low < high) {
        const int middle = (low + high) / 2;
        if (strcmp(tex->keys[middle].key, key) < 0)
            low = middle + 1;
        else
            high = middle;
    }
    *at = low;
    return low < tex->key_count && !strcmp(tex->keys[low].key, key);
}

const char *ibl_texture_get(const ibl_texture *tex, const char *key)
{
    int at;
    return find_key(tex, key, &at) ? tex->keys[at].value : NULL;
}

static void remove_key(ibl_texture *tex, int at)
{
    ibl_free(tex->keys[at].key);
    ibl_free(tex->keys[at].value);
    tex->key_count--;
    memmove(tex->keys + at, tex->keys + at + 1,
            (size_t)(tex->key_count - at) * sizeof *tex->keys);
}

/* Inserts copies of a key and of a value of n bytes. Allocates a new array. */
static bool insert_pair(ibl_texture *tex, int at, const char *key,
                        const void *value, size_t n)
{
    const size_t count = (size_t)tex->key_count, before = (size_t)at;
    ibl_key_value *keys = ibl_alloc_array(count + 1, sizeof *keys);
    const ibl_key_value pair = {copy_text(key, strlen(key)),
                                copy_text(value, n)};
    if (!keys || !pair.key || !pair.value) {
        ibl_free(pair.value);
        ibl_free(pair.key);
        ibl_free(keys);
        return false;
    }
    if (count) {
        memcpy(keys, tex->keys, before * sizeof *keys);
        memcpy(keys + before + 1, tex->keys + before,
               (count - before) * sizeof *keys);
    }
    keys[before] = pair;
    ibl_free(tex->keys);
    tex->keys = keys;
    tex->key_count++;
    return true;
}

ibl_status ibl_texture_set(ibl_ctx *ctx, ibl_texture *tex, const char *key,
                           const char *value)
{
    if (!ctx || !tex || !key || !value)
        return ibl_missing(ctx, "ibl_texture_set: tex, key or value");
    const size_t n = strlen(key);
    if (n < 1 || n > MAX_KEY_BYTES)
        return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                        "a texture's key of %zu bytes: must be 1 to %d", n,
                        MAX_KEY_BYTES);
    if (!ibl_json_is_text(key) || !ibl_json_is_text(value))
        return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                        "a texture's key or its value is not UTF-8");
    if (strlen(value) > INT32_MAX - MAX_KEY_BYTES - 2)
        return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                        "a value of %zu bytes: the limit is 2 GiB",
                        strlen(value));
    if (tex->key_count >= MAX_KEYS)
        return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                        "a texture's keys: the limit is %d", MAX_KEYS);
    int at;
    if (find_key(tex, key, &at))
        remove_key(tex, at);
    return insert_pair(tex, at, key, value, strlen(value))
               ? IBL_OK
               : ibl_no_memory(ctx, "a texture's keys");
}

/* ---- in a file ------------------------------------------------------ */

/* Adds a pair of `bytes` bytes, without padding, unless it is no text. */
static ibl_status read_pair(const ibl_input *in, const char *key,
                            uint64_t bytes, ibl_texture *tex)
{
    const size_t n = strnlen(key, bytes);
    const char *value = key + n + 1;
    char text[IBL_QUOTE_BYTES];

    if (!n || n == bytes)
        return ibl_bad_file(in, "damaged: a key of its metadata has no end");
    size_t length = bytes - n - 1;
    if (length && !value[length - 1])
        length--;
    if (n > MAX_KEY_BYTES || memchr(value, 0, length) || !ibl_json_is_text(key))
        return IBL_OK;
    if (tex->key_count == MAX_KEYS)
        return ibl_unsupported(in, "over %d keys of metadata", MAX_KEYS);
    int at;
    if (find_key(tex, key, &at))
        return ibl_bad_file(in, "damaged: the key \"%s\" is there twice",
                            ibl_quote(key, text));
    if (!insert_pair(tex, at, key, value, length))
        return ibl_no_memory(in->ctx, "a texture's keys");
    if (!ibl_json_is_text(tex->keys[at].value))
        remove_key(tex, at);
    return IBL_OK;
}

ibl_status ibl_keys_read(const ibl_input *in, uint64_t at, uint64_t size,
                         const char *down, const char *up, ibl_texture *tex,
                         bool *bottom_up)
{
    char text[IBL_QUOTE_BYTES];

    *bottom_up = false;
    if (!ibl_input_has(in, at, size))
        return ibl_input_short(in, "its metadata");
    for (const uint64_t end = at + size; at < end;) {
        const uint64_t bytes = end - at < 4 ? 0 : ibl_input_u32(in, at);
        if (bytes < 2 || bytes > end - at - 4)
            return ibl_bad_file(in, "damaged: a value of its metadata does not "
                                    "end where it should");
        const ibl_status status =
            read_pair(in, (const char *)in->bytes + at + 4, bytes, tex);
        if (status)
            return status;
        at += 4 + (bytes + 3) / 4 * 4; /* some omit the padding of the last */
    }
    /* Rows of textures start at the top: after they are flipped the key would
     * be wrong. */
    int found;
    if (!find_key(tex, orientation_key, &found))
        return IBL_OK;
    const char *value = tex->keys[found].value;
    *bottom_up = !strcmp(value, up);
    if (strcmp(value, down) && !(*bottom_up && tex->faces == 1))
        return ibl_unsupported(
            in, "%s \"%s\": only \"%s\", and \"%s\" of flat textures, are read",
            orientation_key, ibl_quote(value, text), down, up);
    remove_key(tex, found);
    return IBL_OK;
}

/* Writes a pair, if dst is not NULL; returns its bytes. */
static size_t write_pair(const ibl_key_value *pair, unsigned char *dst)
{
    const size_t key = strlen(pair->key) + 1, value = strlen(pair->value) + 1;
    const uint32_t bytes = (uint32_t)(key + value);
    const size_t padded = (key + value + 3) / 4 * 4;
    if (dst) {
        memset(dst, 0, 4 + padded);
        memcpy(dst, &bytes, 4);
        memcpy(dst + 4, pair->key, key);
        memcpy(dst + 4 + key, pair->value, value);
    }
    return 4 + padded;
}

size_t ibl_keys_write(const ibl_texture *tex, const char *orientation,
                      unsigned char *dst)
{
    const ibl_key_value own[] = {{(char *)orientation_key, (char *)orientation},
                                 {(char *)writer_key, (char *)writer}};
    const ibl_key_value *key = tex->keys;
    const ibl_key_value *end = key ? key + tex->key_count : NULL;
    size_t size = 0;

    for (int i = 0; i < 2 || key < end;) {
        const int order = key == end ? 1
                          : i == 2   ? -1
                                     : strcmp(key->key, own[i].key);
        if (order < 0)
            size += write_pair(key, dst ? dst + size : NULL);
        else
            size += write_pair(&own[i++], dst ? dst + size : NULL);
        if (order <= 0)
            key++;
    }
    return size;
}

/* ---- what a texture holds ----------------------------------------------- */

/* Sets keys until one fails; status keeps that failure. */
typedef struct setter {
    ibl_ctx *ctx;
    ibl_texture *tex;
    ibl_status status;
} setter;

static void set(setter *s, const char *name, const char *fmt, ...)
    __attribute__((format(printf, 3, 4)));
static void set(setter *s, const char *name, const char *fmt, ...)
{
    char key[40], value[512];
    va_list ap;

    snprintf(key, sizeof key, "iblbake.%s", name);
    va_start(ap, fmt);
    vsnprintf(value, sizeof value, fmt, ap);
    va_end(ap);
    if (!s->status)
        s->status = ibl_texture_set(s->ctx, s->tex, key, value);
}

/* Appends a number to a list, after a comma if the list is not empty. */
static void add_number(char *list, size_t size, int digits, double x)
{
    const size_t used = strlen(list);
    snprintf(list + used, size - used, "%s%.*g", used ? "," : "", digits, x);
}

/* ---- what sidecars say, too --------------------------------------------- */

static const struct {
    const char *member, *key, *between; /* elements of an array */
} shared[] = {
    {"axes", "axes", NULL},
    {"geometry", "geometry", NULL},
    {"jitter", "jitter", NULL},
    {"layers", "layers", ";"},
    {"level_roughness", "roughness", ","},
    {"lobe", "lobe", NULL},
    {"lod_bias", "lod_bias", NULL},
    {"lod_offset", "lod_offset", NULL},
    {"lod_scale", "lod_scale", NULL},
    {"mapping", "mapping", NULL},
    {"method", "method", NULL},
    {"pdf_mip", "pdf_mip", NULL},
    {"roughness_range", "roughness_range", ":"},
    {"samples", "samples", NULL},
    {"scale", "irradiance_scale", NULL},
    {"step_rad", "step", NULL},
    {"tolerance", "tolerance", NULL},
};

static void add_value(char *text, size_t size, const json_t *j)
{
    const size_t used = strlen(text);
    if (json_is_number(j))
        snprintf(text + used, size - used, "%.9g", json_number_value(j));
    else
        snprintf(text + used, size - used, "%s",
                 json_is_string(j) ? json_string_value(j)
                 : json_is_true(j) ? "yes"
                                   : "no");
}

static void set_shared(setter *s, const ibl_sidecar_facts *f,
                       ibl_content content)
{
    json_t *all = json_object();

    ibl_sidecar_put_content(f, content, &all);
    if (!all && !s->status)
        s->status = ibl_no_memory(s->ctx, "a texture's keys");
    for (size_t i = 0; i < sizeof shared / sizeof *shared; i++) {
        const json_t *j = json_object_get(all, shared[i].member);
        char text[512] = "";
        for (size_t k = 0; k < json_array_size(j); k++) {
            if (k)
                strcat(text, shared[i].between);
            add_value(text, sizeof text - 1, json_array_get(j, k));
        }
        if (!json_is_array(j))
            add_value(text, sizeof text, j);
        if (j)
            set(s, shared[i].key, "%s", text);
    }
    json_decref(all);
}

/* ---- the others ---------------------------------------------------------- */

/* Lists of the levels, which a sidecar has one by one. */
static void set_levels(setter *s, const ibl_sidecar_facts *f)
{
    const ibl_specular_report *made = f->o.made ? &f->o.made->report : NULL;
    const ibl_specular_layout *layout = made ? &made->layout : &f->layout;
    char roughness[IBL_MAX_LEVELS * 24] = "", errors[IBL_MAX_LEVELS * 24] = "";
    char samples[IBL_MAX_LEVELS * 12] = "", degrees[IBL_MAX_LEVELS * 12] = "";

    for (int l = 0; l < layout->levels; l++)
        add_number(roughness, sizeof roughness, 9, layout->roughness[l]);
    set(s, "roughness", "%s", roughness);
    for (int l = 0; made && l < layout->levels; l++) {
        const ibl_specular_level *level = &made->level[l];
        add_number(samples, sizeof samples, 9, level->samples);
        add_number(degrees, sizeof degrees, 9, level->degree);
        add_number(errors, sizeof errors, 3, fmax(level->error, 0));
    }
    if (!made)
        return;
    set(s, "degrees", "%s", degrees);
    set(s, "estimate", "%s", errors);
    if (made->lookup_size)
        set(s, "samples", "%s", samples);
}

/* What was done to the environment. */
static void set_environment(setter *s, const ibl_sidecar_facts *f)
{
    const ibl_sidecar_options *o = &f->o;
    const ibl_read_options *read = &f->read;

    set(s, "yaw_deg", "%.9g", o->yaw_deg);
    if (o->axes.mirror)
        set(s, "mirror", "%s", ibl_mirror_name(o->axes.mirror));
    if (o->axes.up)
        set(s, "up", "%s", ibl_up_name(o->axes.up));
    if (read->primaries)
        set(s, "primaries", "%s", ibl_primaries_name(read->primaries));
    if (read->transfer)
        set(s, "transfer", "%s",
            read->transfer == IBL_TRANSFER_LINEAR ? "linear" : "srgb");
    if (read->exposure < 0 || read->exposure > 0)
        set(s, "exposure", "%.17g", read->exposure);
    if (read->clamp > 0)
        set(s, "clamp", "%.17g", read->clamp);
    if (read->primaries || o->report)
        s->tex->primaries = ibl_khronos_number(
            read->primaries ? ibl_primaries_xy(read->primaries)
                            : o->report->primaries);
}

ibl_status ibl_texture_describe(ibl_ctx *ctx, ibl_texture *tex,
                                const ibl_sidecar_options *facts,
                                const ibl_sidecar_output *output)
{
    ibl_sidecar_facts f = {0};
    setter s = {ctx, tex, IBL_OK};

    if (!tex || !facts || !output)
        return ibl_missing(ctx, "ibl_texture_describe: tex, facts or output");
    const ibl_content content = output->content;
    s.status = ibl_sidecar_take(ctx, facts, &f);
    if (!s.status)
        s.status = ibl_sidecar_check_content(ctx, output);
    if (!s.status && content == IBL_CONTENT_SPECULAR && !f.o.made &&
        ibl_specular_layout_of(&f.specular, &f.layout))
        s.status = ibl_fail(ctx, IBL_ERR_ARGUMENT,
                            "specular options that give no levels");
    if (s.status)
        return s.status;
    set(&s, "content", "%s", ibl_content_name(content));
    set_shared(&s, &f, content);
    if (content == IBL_CONTENT_SPECULAR)
        set_levels(&s, &f);
    if (!f.o.made)
        return s.status;
    if (content < IBL_CONTENT_LUT) {
        set_environment(&s, &f);
        if (content != IBL_CONTENT_SKYBOX && f.o.light_count >= 0)
            set(&s, "lights", "%d", f.o.light_count);
    }
    if (ibl_pixel_block(tex->pixel) > 1) {
        set(&s, "pixel", "%s", ibl_pixel_name(tex->pixel));
        set(&s, "quality", "%s",
            ibl_quality_name(output->texels
                                 ? output->texels->quality
                                 : ibl_texel_options_default().quality));
    }
    return s.status;
}
