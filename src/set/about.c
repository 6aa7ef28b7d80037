/* SPDX-License-Identifier: MIT */
#include "set/about.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "common/names.h"
#include "common/path.h"
#include "core/context.h"
#include "core/pi.h"
#include "io/input.h"
#include "json/json_text.h"

static const char *const content_names[] = {
    "skybox", "specular", "irradiance", "brdf_lut", "lobe_lut", NULL};
static const char *const scale_names[] = {"E/pi", "E", NULL};

/* The key is the member but for two. Without a place the entry has it. */
static const struct {
    unsigned known; /* bit of ibl_set_facts */
    const char *place, *member;
    const char *const *names; /* of words */
    double low, high;         /* of numbers */
} facts[IBL_FACTS] = {
    {0, NULL, "content", content_names, 0, 0},
    {IBL_KNOWN_LOBE, NULL, "lobe", ibl_lobe_names, 0, 0},
    {IBL_KNOWN_MAPPING, NULL, "mapping", ibl_mapping_names, 0, 0},
    {IBL_KNOWN_LOD, NULL, "lod_scale", NULL, 0, FLT_MAX},
    {IBL_KNOWN_LOD, NULL, "lod_offset", NULL, -FLT_MAX, FLT_MAX},
    {IBL_KNOWN_SCALE, NULL, "scale", scale_names, 0, 0},
    {IBL_KNOWN_TABLE, NULL, "table", ibl_lut_names, 0, 0},
    {IBL_KNOWN_GEOMETRY, NULL, "geometry", ibl_geometry_names, 0, 0},
    {IBL_KNOWN_AXES, "orientation", "mirror", ibl_mirror_names, 0, 0},
    {IBL_KNOWN_AXES, "orientation", "up", ibl_up_names, 0, 0},
    {IBL_KNOWN_YAW, "orientation", "yaw_deg", NULL, -FLT_MAX, FLT_MAX},
    {IBL_KNOWN_LIGHTS, "", "lights", NULL, 0, IBL_MAX_LIGHTS},
    {0, "colour", "primaries", ibl_primaries_names, 0, 0},
    {0, "colour", "transfer", ibl_transfer_names, 0, 0},
    {0, "colour", "exposure_ev", NULL, -IBL_MAX_EXPOSURE, IBL_MAX_EXPOSURE},
    {0, "colour", "clamp", NULL, 0, FLT_MAX},
};

static void say(ibl_about *a, int i, double value, const char *word)
{
    a->said |= 1u << i;
    a->value[i] =
        word && facts[i].names ? ibl_names_find(facts[i].names, word) : value;
    a->word[i] = word;
}

/* Reads up to `most` numbers between commas; 0: the text is not that. */
static int numbers(const char *text, double *to, int most)
{
    char *at = (char *)text;

    for (int i = 0; i < most && ibl_take_number(&at, &to[i]); i++)
        if (*at++ != ',')
            return at[-1] ? 0 : i + 1;
    return 0;
}

ibl_about ibl_about_keys(const ibl_texture *tex, const char *path)
{
    ibl_about a = {.who = path};
    const char *list = ibl_texture_get(tex, "iblbake.roughness");

    for (int i = 0; i < IBL_FACTS; i++) {
        char key[40];
        double x;
        snprintf(key, sizeof key, "iblbake.%s",
                 i == IBL_FACT_SCALE      ? "irradiance_scale"
                 : i == IBL_FACT_EXPOSURE ? "exposure"
                                          : facts[i].member);
        const char *text = ibl_texture_get(tex, key);
        if (text)
            say(&a, i, numbers(text, &x, 1) ? x : NAN, text);
    }
    if (list && !(a.levels = numbers(list, a.roughness, IBL_MAX_LEVELS)))
        a.levels = -1;
    return a;
}

/* Levels are numbers in an index and of lobe tables; chains of other maps have
 * levels without. */
static void take_levels(ibl_about *a, const json_t *entry)
{
    static const char *const members[] = {"levels", "level_roughness",
                                          "roughness"};
    const json_t *level;
    size_t l;

    for (int i = 0; i < 3 && !a->levels; i++)
        json_array_foreach(json_object_get(entry, members[i]), l, level)
        {
            const json_t *r = i ? level : json_object_get(level, "roughness");
            if (!i && !l && !r)
                break;
            if (l == IBL_MAX_LEVELS || !json_is_number(r)) {
                a->levels = -1;
                return;
            }
            a->roughness[a->levels++] = json_number_value(r);
        }
}

ibl_about ibl_about_sidecar(const json_t *sidecar, const json_t *entry,
                            const char *path)
{
    const json_t *lights = json_object_get(sidecar, "lights");
    ibl_about a = {.who = path};

    for (int i = 0; i < IBL_FACTS; i++) {
        const char *place = facts[i].place;
        const json_t *j = json_object_get(
            place ? json_object_get(sidecar, place) : entry, facts[i].member);
        if (facts[i].names ? json_is_string(j) : json_is_number(j))
            say(&a, i, json_number_value(j), json_string_value(j));
    }
    if (lights && entry && (a.value[IBL_FACT_CONTENT] != IBL_CONTENT_SKYBOX))
        say(&a, IBL_FACT_LIGHTS, (double)json_array_size(lights), NULL);
    take_levels(&a, entry);
    return a;
}

ibl_about ibl_about_asked(const ibl_set_facts *asked)
{
    const double value[IBL_FACTS] = {[IBL_FACT_LOBE] = asked->lobe,
                                     [IBL_FACT_MAPPING] = asked->mapping,
                                     [IBL_FACT_LOD_SCALE] = asked->lod_scale,
                                     [IBL_FACT_LOD_OFFSET] = asked->lod_offset,
                                     [IBL_FACT_SCALE] =
                                         asked->irradiance_scale < 1,
                                     [IBL_FACT_TABLE] = asked->table,
                                     [IBL_FACT_GEOMETRY] = asked->geometry,
                                     [IBL_FACT_MIRROR] = asked->axes.mirror,
                                     [IBL_FACT_UP] = asked->axes.up,
                                     [IBL_FACT_YAW] = asked->yaw_deg,
                                     [IBL_FACT_LIGHTS] = asked->lights};
    /* A mapping gives the roughness, and each of them the lod. */
    const unsigned chain = IBL_KNOWN_MAPPING | IBL_KNOWN_ROUGHNESS;
    const unsigned firm =
        asked->known | (asked->known & chain ? chain | IBL_KNOWN_LOD : 0);
    ibl_about a = {.who = NULL};

    for (int i = 0; i < IBL_FACTS; i++) {
        if (asked->known & facts[i].known)
            say(&a, i, value[i], NULL);
        a.firm |= firm & facts[i].known ? 1u << i : 0;
    }
    if (firm & IBL_KNOWN_ROUGHNESS)
        a.firm |= 1u << IBL_FACTS;
    if (asked->known & IBL_KNOWN_ROUGHNESS) {
        a.levels = asked->levels;
        memcpy(a.roughness, asked->roughness, sizeof a.roughness);
    }
    return a;
}

/* ---- what is known in the end ---------------------------------------------
 */

static ibl_status check(ibl_ctx *ctx, const ibl_about *a, int i)
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
                    "%s: its %s is \"%.40s\", which this version does not "
                    "know, but %s: bake it again, or say what it is",
                    a->who, facts[i].member, a->word[i], text);
}

static ibl_status add_levels(ibl_ctx *ctx, ibl_about *known,
                             const ibl_about *other)
{
    const double *r = other->roughness;

    if (other->levels < 0)
        return ibl_fail(ctx, IBL_ERR_FORMAT,
                        "%s: its list of the roughness of levels is damaged: "
                        "bake it again, or say what it is",
                        other->who);
    for (int l = 0; l < other->levels; l++)
        if (!(r[l] >= (l ? r[l - 1] : 0) && r[l] <= 1))
            return ibl_fail(ctx, IBL_ERR_FORMAT,
                            "%s: has roughness %g at level %d, which has to be "
                            "%g to 1: bake it again, or say what it is",
                            other->who, r[l], l, l ? r[l - 1] : 0);
    memcpy(known->roughness, r, sizeof known->roughness);
    known->levels = other->levels;
    return IBL_OK;
}

ibl_status ibl_about_add(ibl_ctx *ctx, ibl_about *known, const ibl_about *other)
{
    const unsigned fresh = other->said & ~known->said & ~known->firm;
    ibl_status status = known->levels || known->firm >> IBL_FACTS
                            ? IBL_OK
                            : add_levels(ctx, known, other);

    for (int i = 0; i < IBL_FACTS && !status; i++)
        if (fresh >> i & 1) {
            status = check(ctx, other, i);
            say(known, i, other->value[i], other->word[i]);
        }
    return status;
}

ibl_set_facts ibl_about_facts(const ibl_about *a)
{
    const double *v = a->value;
    ibl_set_facts f = {
        .known = a->levels ? IBL_KNOWN_ROUGHNESS : 0,
        .lobe = (ibl_lobe)v[IBL_FACT_LOBE],
        .mapping = (ibl_roughness_map)v[IBL_FACT_MAPPING],
        .levels = a->levels,
        .lod_scale = v[IBL_FACT_LOD_SCALE],
        .lod_offset = v[IBL_FACT_LOD_OFFSET],
        .irradiance_scale = v[IBL_FACT_SCALE] > 0 ? 1 / IBL_PI : 1,
        .table = (ibl_lut_kind)v[IBL_FACT_TABLE],
        .geometry = (ibl_geometry)v[IBL_FACT_GEOMETRY],
        .axes = {(ibl_mirror)v[IBL_FACT_MIRROR], (ibl_up)v[IBL_FACT_UP]},
        .yaw_deg = v[IBL_FACT_YAW],
        .lights = (int)v[IBL_FACT_LIGHTS],
    };

    memcpy(f.roughness, a->roughness, sizeof f.roughness);
    for (int i = 0; i < IBL_FACTS; i++)
        f.known |= a->said >> i & 1 ? facts[i].known : 0;
    return f;
}

/* ---- sidecars ---------------------------------------------------------- */

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
