/* SPDX-License-Identifier: MIT */
#include "engine/set.h"

#include <stdlib.h>

json_t *ibl_engine_triples(const double (*triples)[3], int count)
{
    json_t *list = json_array();

    for (int i = 0; i < count; i++)
        append(&list,
               json_pack("[fff]", triples[i][0], triples[i][1], triples[i][2]));
    return list;
}

json_t *ibl_engine_keys(const ibl_texture *tex)
{
    json_t *keys = json_object();

    for (int i = 0; i < tex->key_count; i++)
        put(&keys, tex->keys[i].key, json_string(tex->keys[i].value));
    return keys;
}

ibl_status ibl_engine_set_keys(ibl_ctx *ctx, const json_t *keys,
                               ibl_texture *tex)
{
    const char *key;
    json_t *value;

    json_object_foreach((json_t *)keys, key, value)
    {
        const ibl_status status =
            json_is_string(value)
                ? ibl_texture_set(ctx, tex, key, json_string_value(value))
                : IBL_OK;
        if (status)
            return status;
    }
    return IBL_OK;
}

ibl_status ibl_engine_set_roughness(ibl_ctx *ctx, const double *roughness,
                                    ibl_texture *tex)
{
    char list[IBL_MAX_LEVELS * 24] = "";
    size_t used = 0;

    for (int l = 0; l < tex->levels; l++)
        used += (size_t)snprintf(list + used, sizeof list - used, "%s%.9g",
                                 l ? "," : "", roughness[l]);
    const ibl_status status =
        ibl_texture_set(ctx, tex, "iblbake.roughness", list);
    return status ? status
                  : ibl_texture_set(ctx, tex, "iblbake.content", "specular");
}

typedef struct json_out {
    ibl_blob *blob;
    bool ok; /* there was memory for all */
} json_out;

static int add_text(const char *bytes, size_t size, void *data)
{
    json_out *out = data;

    out->ok = out->ok && ibl_blob_add(out->blob, bytes, size);
    return out->ok ? 0 : -1;
}

/* json_dumps does not notice missing memory, and goes on in the middle of a
 * string when the callback fails. */
bool ibl_engine_put_json(json_t *root, ibl_blob *blob)
{
    json_out out = {blob, root != NULL};
    const int status =
        root ? json_dump_callback(root, add_text, &out,
                                  JSON_COMPACT | JSON_REAL_PRECISION(9))
             : -1;

    json_decref(root);
    return !status && out.ok;
}
