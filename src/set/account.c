/* SPDX-License-Identifier: MIT */
#include "set/account.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/names.h"
#include "common/path.h"
#include "core/context.h"
#include "core/pi.h"
#include "io/input.h"
#include "json/json_text.h"

/* Where sidecars say it. */
enum {
    OF_FILE,
    OF_ORIENTATION,
    OF_COLOUR,
    OF_NONE
};

static const char *const content_names[] = {
    "skybox", "specular", "irradiance", "brdf_lut", "lobe_lut", NULL};
static const char *const scale_names[] = {"E/pi", "E", NULL};

static const struct {
    unsigned known; /* bit of ibl_set_facts */
    int place;
    const char *key, *member;
    const char *const *names; /* of words */
    double low, high;         /* of numbers */
} facts[IBL_FACTS] = {
    [IBL_FACT_CONTENT] = {0, OF_FILE, "content", "content", content_names},
    [IBL_FACT_LOBE] = {IBL_KNOWN_LOBE, OF_FILE, "lobe", "lobe", ibl_lobe_names},
    [IBL_FACT_MAPPING] = {IBL_KNOWN_MAPPING, OF_FILE, "mapping", "mapping",
                          ibl_mapping_names},
    [IBL_FACT_LOD_SCALE] = {IBL_KNOWN_LOD, OF_FILE, "lod_scale", "lod_scale",
                            NULL, 0, FLT_MAX},
    [IBL_FACT_LOD_OFFSET] = {IBL_KNOWN_LOD, OF_FILE, "lod_offset", "lod_offset",
                             NULL, -FLT_MAX, FLT_MAX},
    [IBL_FACT_SCALE] = {IBL_KNOWN_SCALE, OF_FILE, "irradiance_scale", "scale",
                        scale_names},
    [IBL_FACT_TABLE] = {IBL_KNOWN_TABLE, OF_FILE, "table", "table",
                        ibl_lut_names},
    [IBL_FACT_GEOMETRY] = {IBL_KNOWN_GEOMETRY, OF_FILE, "geometry", "geometry",
                           ibl_geometry_names},
    [IBL_FACT_MIRROR] = {IBL_KNOWN_AXES, OF_ORIENTATION, "mirror", "mirror",
                         ibl_mirror_names},
    [IBL_FACT_UP] = {IBL_KNOWN_AXES, OF_ORIENTATION, "up", "up", ibl_up_names},
    [IBL_FACT_YAW] = {IBL_KNOWN_YAW, OF_ORIENTATION, "yaw_deg", "yaw_deg", NULL,
                      -FLT_MAX, FLT_MAX},
    [IBL_FACT_LIGHTS] = {IBL_KNOWN_LIGHTS, OF_NONE, "lights", "lights", NULL, 0,
                         IBL_MAX_LIGHTS},
    [IBL_FACT_PRIMARIES] = {0, OF_COLOUR, "primaries", "primaries",
                            ibl_primaries_names},
    [IBL_FACT_TRANSFER] = {0, OF_COLOUR, "transfer", "transfer",
                           ibl_transfer_names},
    [IBL_FACT_EXPOSURE] = {0, OF_COLOUR, "exposure", "exposure_ev", NULL,
                           -IBL_MAX_EXPOSURE, IBL_MAX_EXPOSURE},
    [IBL_FACT_CLAMP] = {0, OF_COLOUR, "clamp", "clamp", NULL, 0, FLT_MAX},
};

static void say(ibl_account *a, int i, double value, const char *word)
{
    a->said |= 1u << i;
    a->value[i] =
        word && facts[i].names ? ibl_names_find(facts[i].names, word) : value;
    a->word[i] = word;
}

/* Reads up to `most` numbers between commas; 0: they are not that. */
static int numbers(const char *text, double *to, int most)
{
    char *at = (char *)text;
    int count = 0;

    while (count < most && ibl_take_number(&at, &to[count++]) && *at == ',')
        at++;
    return count && at > text && at[-1] != ',' && !*at ? count : 0;
}

ibl_account ibl_account_of_keys(const ibl_texture *tex, const char *path)
{
    ibl_account a = {.who = path};
    const char *list = ibl_texture_get(tex, "iblbake.roughness");

    for (int i = 0; i < IBL_FACTS; i++) {
        char key[40];
        double x;
        snprintf(key, sizeof key, "iblbake.%s", facts[i].key);
        const char *text = ibl_texture_get(tex, key);
        if (text)
            say(&a, i, numbers(text, &x, 1) ? x : NAN, text);
    }
    if (list && !(a.levels = numbers(list, a.roughness, IBL_MAX_LEVELS)))
        a.levels = -1;
    return a;
}

/* The roughness of levels, of which chains of other maps have none, or the
 * levels that a lobe table is for. */
static void take_levels(ibl_account *a, const json_t *entry)
{
    const json_t *list = json_object_get(entry, "level_roughness"), *level;
    size_t l;

    if (!list)
        list = json_object_get(entry, "levels");
    level = json_array_get(list, 0);
    if (!json_is_number(level) && !json_object_get(level, "roughness"))
        return;
    json_array_foreach((json_t *)list, l, level)
    {
        const json_t *r =
            json_is_number(level) ? level : json_object_get(level, "roughness");
        if (l == IBL_MAX_LEVELS || !json_is_number(r)) {
            a->levels = -1;
            return;
        }
        a->roughness[a->levels++] = json_number_value(r);
    }
}

ibl_account ibl_account_of_sidecar(const json_t *sidecar, const json_t *entry,
                                   const char *path)
{
    const json_t *const places[] = {
        [OF_FILE] = entry,
        [OF_ORIENTATION] = json_object_get(sidecar, "orientation"),
        [OF_COLOUR] = json_object_get(sidecar, "colour"),
        [OF_NONE] = NULL};
    ibl_account a = {.who = path};

    for (int i = 0; i < IBL_FACTS; i++) {
        const json_t *j =
            json_object_get(places[facts[i].place], facts[i].member);
        if (facts[i].names ? json_is_string(j) : json_is_number(j))
            say(&a, i, json_number_value(j), json_string_value(j));
    }
    if (entry)
        take_levels(&a, entry);
    return a;
}

/* ---- what is known in the end ---------------------------------------------
 */

/* Keys have nine digits. */
static bool is_other(double x, double y)
{
    return fabs(x - y) > 1e-6 * (1 + fabs(x));
}

static ibl_status check(ibl_ctx *ctx, const ibl_account *a, int i)
{
    const double x = a->value[i];
    char text[160];

    if (facts[i].names ? x >= 0 : x >= facts[i].low && x <= facts[i].high)
        return IBL_OK;
    if (!facts[i].names)
        return ibl_fail(ctx, IBL_ERR_FORMAT,
                        "%s: has %s %g, which no bake has: bake it again, or "
                        "say what it is",
                        a->who, facts[i].member, x);
    ibl_names_text(facts[i].names, text, sizeof text);
    return ibl_fail(ctx, IBL_ERR_FORMAT,
                    "%s: its %s is \"%.40s\", which is none of %s: bake it "
                    "again with iblbake " IBL_VERSION ", or say what it is",
                    a->who, facts[i].member, a->word[i], text);
}

static ibl_status add_levels(ibl_ctx *ctx, ibl_account *known,
                             const ibl_account *other, int *differs)
{
    const double *r = other->roughness;

    if (known->skip >> IBL_FACTS & 1)
        return IBL_OK;
    for (int l = 0; l < other->levels && known->levels; l++)
        *differs |= l >= known->levels || is_other(known->roughness[l], r[l]);
    if (known->levels || !other->levels)
        return IBL_OK;
    for (int l = 0; l < other->levels; l++)
        if (!(r[l] >= (l ? r[l - 1] : 0) && r[l] <= 1))
            return ibl_fail(ctx, IBL_ERR_FORMAT,
                            "%s: has roughness %g at level %d, which has to be "
                            "%g to 1: bake it again, or say what it is",
                            other->who, r[l], l, l ? r[l - 1] : 0);
    if (other->levels < 0)
        return ibl_fail(ctx, IBL_ERR_FORMAT,
                        "%s: its list of the roughness of levels is damaged: "
                        "bake it again, or say what it is",
                        other->who);
    memcpy(known->roughness, r, sizeof known->roughness);
    known->levels = other->levels;
    return IBL_OK;
}

ibl_status ibl_account_add(ibl_ctx *ctx, ibl_account *known,
                           const ibl_account *other, int *differs)
{
    ibl_status status = add_levels(ctx, known, other, differs);

    for (int i = 0; i < IBL_FACTS && !status; i++) {
        if (!(other->said & ~known->skip & 1u << i))
            continue;
        if (known->said >> i & 1) {
            *differs |= i != IBL_FACT_CONTENT &&
                        is_other(known->value[i], other->value[i]);
            continue;
        }
        status = check(ctx, other, i);
        say(known, i, other->value[i], other->word[i]);
    }
    return status;
}

/* The world's axis that each of the file's is. */
static void axes_of(const ibl_account *a, int axes[3])
{
    const ibl_axes turn = {(ibl_mirror)a->value[IBL_FACT_MIRROR],
                           (ibl_up)a->value[IBL_FACT_UP]};

    for (int k = 0; k < 3; k++) {
        double d[3] = {k == 0, k == 1, k == 2};
        ibl_axes_turn(turn, 1, d, d);
        axes[k] = (int)(d[0] + 2 * d[1] + 3 * d[2]);
    }
}

unsigned ibl_account_skip(const ibl_set_facts *asked)
{
    /* A mapping gives the roughness, and each of them the lod. */
    const unsigned chain = IBL_KNOWN_MAPPING | IBL_KNOWN_ROUGHNESS;
    const unsigned known =
        asked->known | (asked->known & chain ? chain | IBL_KNOWN_LOD : 0);
    unsigned skip = known & IBL_KNOWN_ROUGHNESS ? 1u << IBL_FACTS : 0;

    for (int i = 0; i < IBL_FACTS; i++)
        skip |= known & facts[i].known ? 1u << i : 0;
    return skip;
}

ibl_set_facts ibl_account_facts(const ibl_account *a,
                                const ibl_set_facts *asked)
{
    const double *v = a->value;
    const unsigned k = asked->known;
    ibl_set_facts f = {
        .known = k | (a->levels ? IBL_KNOWN_ROUGHNESS : 0),
        .lobe = k & IBL_KNOWN_LOBE ? asked->lobe : (ibl_lobe)v[IBL_FACT_LOBE],
        .mapping = k & IBL_KNOWN_MAPPING
                       ? asked->mapping
                       : (ibl_roughness_map)v[IBL_FACT_MAPPING],
        .levels = k & IBL_KNOWN_ROUGHNESS ? asked->levels : a->levels,
        .lod_scale =
            k & IBL_KNOWN_LOD ? asked->lod_scale : v[IBL_FACT_LOD_SCALE],
        .lod_offset =
            k & IBL_KNOWN_LOD ? asked->lod_offset : v[IBL_FACT_LOD_OFFSET],
        .irradiance_scale = k & IBL_KNOWN_SCALE     ? asked->irradiance_scale
                            : v[IBL_FACT_SCALE] > 0 ? 1 / IBL_PI
                                                    : 1,
        .table = k & IBL_KNOWN_TABLE ? asked->table
                                     : (ibl_lut_kind)v[IBL_FACT_TABLE],
        .geometry = k & IBL_KNOWN_GEOMETRY ? asked->geometry
                                           : (ibl_geometry)v[IBL_FACT_GEOMETRY],
        .yaw_deg = k & IBL_KNOWN_YAW ? asked->yaw_deg : v[IBL_FACT_YAW],
        .lights =
            k & IBL_KNOWN_LIGHTS ? asked->lights : (int)v[IBL_FACT_LIGHTS],
    };

    memcpy(f.roughness,
           k & IBL_KNOWN_ROUGHNESS ? asked->roughness : a->roughness,
           sizeof f.roughness);
    axes_of(a, f.axes);
    if (k & IBL_KNOWN_AXES)
        memcpy(f.axes, asked->axes, sizeof f.axes);
    for (int i = 0; i < IBL_FACTS; i++)
        f.known |= a->said >> i & 1 ? facts[i].known : 0;
    return f;
}

/* ---- sidecars ---------------------------------------------------------- */

/* Of JSON, which has no other bytes. */
static bool decode(json_t *object, const char *key)
{
    const char *value = json_string_value(json_object_get(object, key));
    char *name = value ? strdup(value) : NULL;
    bool ok = name || !value;

    if (name) {
        ibl_uri_bytes(name);
        ok = !json_string_set_nocheck(json_object_get(object, key), name);
    }
    free(name);
    return ok;
}

json_t *ibl_sidecar_load(const char *path, ibl_json_why *why)
{
    json_t *root = ibl_json_load(path, 0, why), *output;
    const char *names = json_string_value(json_object_get(root, "names"));
    size_t i;

    if (!names || strcmp(names, IBL_NAMES_ENCODED) != 0)
        return root;
    bool ok = decode(json_object_get(root, "source"), "path");
    json_array_foreach(json_object_get(root, "outputs"), i, output)
    {
        ok = decode(output, "file") && ok;
    }
    if (ok)
        return root;
    json_decref(root);
    why->status = IBL_ERR_MEMORY;
    snprintf(why->line, sizeof why->line, "%s: no memory to read it", path);
    return NULL;
}

json_t *ibl_sidecar_entry(const json_t *sidecar, const char *member,
                          const char *value)
{
    json_t *output;
    size_t i;

    json_array_foreach(json_object_get(sidecar, "outputs"), i, output)
    {
        const char *found = json_string_value(json_object_get(output, member));
        if (found && !strcmp(found, value))
            return output;
    }
    return NULL;
}
