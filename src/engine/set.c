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

/* Not json_dumps, which does not notice missing memory. */
bool ibl_engine_put_json(json_t *root, ibl_blob *blob)
{
    const size_t flags = JSON_COMPACT | JSON_REAL_PRECISION(9);
    const size_t size = root ? json_dumpb(root, NULL, 0, flags) : 0;
    char *text = size ? malloc(size) : NULL;
    const bool ok = text && json_dumpb(root, text, size, flags) == size &&
                    ibl_blob_add(blob, text, size);

    free(text);
    json_decref(root);
    return ok;
}
