/* SPDX-License-Identifier: MIT */
/*
 * Metadata: keys and values of a texture. KTX and KTX2 store them as
 *     uint32 size of key, its zero and value; key; 0; value; padding to 4
 */
#include <string.h>

#include "core/alloc.h"
#include "io/container.h"

static const char orientation_key[] = "KTXorientation";
static const char writer_key[] = "KTXwriter";
static const char writer[] = "iblbake " IBL_VERSION;

size_t ibl_utf8_length(const void *text, size_t n)
{
    const unsigned char *p = text;
    static const uint32_t least[] = {0, 0, 0x80, 0x800, 0x10000};
    const size_t length = !n                  ? 0
                          : p[0] < 0x80       ? 1
                          : p[0] >> 5 == 0x06 ? 2
                          : p[0] >> 4 == 0x0E ? 3
                          : p[0] >> 3 == 0x1E ? 4
                                              : 0;
    if (length < 2 || length > n)
        return length > n ? 0 : length;
    uint32_t code = p[0] & (0x7Fu >> length);
    for (size_t i = 1; i < length; i++) {
        if (p[i] >> 6 != 2)
            return 0;
        code = code << 6 | (p[i] & 0x3F);
    }
    const bool surrogate = code >> 11 == 0xD800 >> 11;
    return code < least[length] || code > 0x10FFFF || surrogate ? 0 : length;
}

static bool is_utf8(const void *text, size_t n)
{
    const unsigned char *p = text;
    for (size_t length; n; p += length, n -= length) {
        length = ibl_utf8_length(p, n);
        if (!length)
            return false;
    }
    return true;
}

static char *copy_text(const void *text, size_t n)
{
    char *copy = ibl_alloc_array(n + 1, 1);
    if (copy) {
        memcpy(copy, text, n);
        copy[n] = '\0';
    }
    return copy;
}

/* Index of the first key that is not less than `key`. */
static int find_key(const ibl_texture *tex, const char *key)
{
    int low = 0, high = tex->key_count;
    while (low < high) {
        const int middle = (low + high) / 2;
        if (strcmp(tex->keys[middle].key, key) < 0)
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

static bool has_key(const ibl_texture *tex, int at, const char *key)
{
    return at < tex->key_count && !strcmp(tex->keys[at].key, key);
}

const char *ibl_texture_get(const ibl_texture *tex, const char *key)
{
    const int at = find_key(tex, key);
    return has_key(tex, at, key) ? tex->keys[at].value : NULL;
}

static ibl_status check_pair(ibl_ctx *ctx, const ibl_texture *tex,
                             const char *key, const char *value)
{
    const size_t n = strlen(key);
    if (n < 1 || n > IBL_MAX_KEY_BYTES)
        return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                        "a texture's key of %zu bytes: must be 1 to %d", n,
                        IBL_MAX_KEY_BYTES);
    if (!is_utf8(key, n) || !is_utf8(value, strlen(value)))
        return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                        "a texture's key or its value is not UTF-8");
    if (strlen(value) > INT32_MAX - IBL_MAX_KEY_BYTES - 2)
        return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                        "a value of %zu bytes: the limit is 2 GiB",
                        strlen(value));
    if (tex->key_count >= IBL_MAX_KEYS)
        return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                        "a texture's keys: the limit is %d", IBL_MAX_KEYS);
    return IBL_OK;
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
    const ibl_status status = check_pair(ctx, tex, key, value);
    if (status)
        return status;
    const int at = find_key(tex, key);
    if (!has_key(tex, at, key))
        return insert_pair(tex, at, key, value, strlen(value))
                   ? IBL_OK
                   : ibl_no_memory(ctx, "a texture's keys");
    char *copy = copy_text(value, strlen(value));
    if (!copy)
        return ibl_no_memory(ctx, "a texture's keys");
    ibl_free(tex->keys[at].value);
    tex->keys[at].value = copy;
    return IBL_OK;
}

/* ---- in a file ------------------------------------------------------ */

/* One pair in a file, without padding. */
typedef struct stored_pair {
    const char *key; /* ends in a zero; value may not */
    const unsigned char *value;
    size_t key_bytes, value_bytes;
} stored_pair;

/* Reads the pair at *at, inside [*at, end), and moves *at behind it. */
static bool next_pair(const ibl_input *in, uint64_t *at, uint64_t end,
                      stored_pair *pair)
{
    if (end - *at < 4)
        return false;
    const uint64_t bytes = ibl_input_u32(in, *at);
    const uint64_t room = end - *at - 4;
    if (bytes < 2 || bytes > room)
        return false;
    pair->key = (const char *)in->bytes + *at + 4;
    const char *zero = memchr(pair->key, 0, (size_t)bytes);
    if (!zero || zero == pair->key)
        return false;
    pair->key_bytes = (size_t)(zero - pair->key);
    pair->value = (const unsigned char *)zero + 1;
    pair->value_bytes = (size_t)bytes - pair->key_bytes - 1;
    /* Some writers omit the padding of the last pair. */
    const uint64_t padded = (bytes + 3) / 4 * 4;
    *at += 4 + (padded < room ? padded : room);
    return true;
}

/* Whether key and value are UTF-8; removes one zero at the end of value. */
static bool is_text(stored_pair *pair)
{
    if (pair->value_bytes && !pair->value[pair->value_bytes - 1])
        pair->value_bytes--;
    return pair->key_bytes <= IBL_MAX_KEY_BYTES &&
           is_utf8(pair->key, pair->key_bytes) &&
           is_utf8(pair->value, pair->value_bytes) &&
           !memchr(pair->value, 0, pair->value_bytes);
}

static ibl_status read_pairs(const ibl_input *in, uint64_t at, uint64_t end,
                             ibl_texture *tex)
{
    char text[IBL_QUOTE_BYTES];
    while (at < end) {
        stored_pair pair;
        if (!next_pair(in, &at, end, &pair))
            return ibl_bad_file(in, "damaged: a key or value in its metadata "
                                    "does not end where it should");
        if (!is_text(&pair))
            continue;
        if (tex->key_count == IBL_MAX_KEYS)
            return ibl_unsupported(in, "over %d keys of metadata",
                                   IBL_MAX_KEYS);
        const int i = find_key(tex, pair.key);
        if (has_key(tex, i, pair.key))
            return ibl_bad_file(in, "damaged: the key \"%s\" is there twice",
                                ibl_quote(pair.key, text));
        if (!insert_pair(tex, i, pair.key, pair.value, pair.value_bytes))
            return ibl_no_memory(in->ctx, "a texture's keys");
    }
    return IBL_OK;
}

static void remove_key(ibl_texture *tex, int at)
{
    ibl_free(tex->keys[at].key);
    ibl_free(tex->keys[at].value);
    tex->key_count--;
    memmove(tex->keys + at, tex->keys + at + 1,
            (size_t)(tex->key_count - at) * sizeof *tex->keys);
}

/* Removes KTXorientation: texture rows start at the top, so the key would be
 * wrong after the rows are flipped. */
static ibl_status take_orientation(const ibl_input *in, const char *down,
                                   const char *up, ibl_texture *tex,
                                   bool *bottom_up)
{
    const int at = find_key(tex, orientation_key);
    char text[IBL_QUOTE_BYTES];
    if (!has_key(tex, at, orientation_key))
        return IBL_OK;
    const char *value = tex->keys[at].value;
    *bottom_up = !strcmp(value, up);
    if (strcmp(value, down) && !(*bottom_up && tex->faces == 1))
        return ibl_unsupported(
            in, "%s \"%s\": only \"%s\" is read%s%s%s", orientation_key,
            ibl_quote(value, text), down, tex->faces == 1 ? " and \"" : "",
            tex->faces == 1 ? up : "", tex->faces == 1 ? "\"" : " for cubes");
    remove_key(tex, at);
    return IBL_OK;
}

ibl_status ibl_keys_read(const ibl_input *in, uint64_t at, uint64_t size,
                         const char *down, const char *up, ibl_texture *tex,
                         bool *bottom_up)
{
    *bottom_up = false;
    if (!ibl_input_has(in, at, size))
        return ibl_input_short(in, "its metadata");
    const ibl_status status = read_pairs(in, at, at + size, tex);
    return status ? status : take_orientation(in, down, up, tex, bottom_up);
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
