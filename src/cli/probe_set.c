/* SPDX-License-Identifier: MIT */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cli/probes.h"
#include "common/names.h"
#include "common/path.h"

const char *const ibl_set_alphas[] = {"ignore", "file", "straight", NULL};
const char *const ibl_capture_names[] = {"equirect", "cross", "faces", NULL};

ibl_alpha ibl_probes_alpha(const ibl_probe_set *set, int layer)
{
    return layer < set->count ? set->bake.alpha : IBL_ALPHA_IGNORE;
}

/* ---- captures ---------------------------------------------------------- */

bool ibl_set_capture(ibl_json_at at, ibl_capture_kind *kind,
                     const char *file[IBL_FACES])
{
    int found = 0;
    bool ok = true;

    if (!ibl_json_object(at, ibl_capture_names))
        return false;
    if (json_object_size(at.value) != 1)
        return ibl_json_wrong(at, "one of equirect, cross and faces");
    while (!json_object_get(at.value, ibl_capture_names[found]))
        found++;
    *kind = (ibl_capture_kind)found;
    const ibl_json_at files = ibl_json_member(&at, ibl_capture_names[found]);
    if (*kind != IBL_CAPTURE_FACES)
        return ibl_json_text_at(files, &file[0]);
    if (json_array_size(files.value) != IBL_FACES)
        return ibl_json_wrong(files, "an array of 6 files, +X -X +Y -Y +Z -Z");
    for (size_t i = 0; i < IBL_FACES && ok; i++)
        ok = ibl_json_text_at(ibl_json_element(&files, i), &file[i]);
    return ok;
}

static bool no_memory(ibl_json_at at)
{
    return ibl_json_complain(at, "no memory for it");
}

static bool take_capture(ibl_json_at at, ibl_capture *c)
{
    const char *file[IBL_FACES];

    if (!ibl_set_capture(at, &c->kind, file))
        return false;
    snprintf(c->place, sizeof c->place, "%s", at.path);
    const int count = c->kind == IBL_CAPTURE_FACES ? IBL_FACES : 1;
    for (; c->count < count; c->count++) {
        c->file[c->count] = ibl_path_beside(at.file->name, file[c->count]);
        if (!c->file[c->count])
            return no_memory(at);
    }
    return true;
}

/* ---- probes ------------------------------------------------------------ */

static bool is_inside(const ibl_volume *v, const double p[3])
{
    double square = 0;

    for (int k = 0; k < 3; k++) {
        const double d = fabs(p[k] - v->centre[k]);
        if (v->shape == IBL_SHAPE_BOX && d > v->half[k])
            return false;
        square += d * d;
    }
    return v->shape == IBL_SHAPE_BOX || square <= v->half[0] * v->half[0];
}

/* Checks how its volumes go together. */
static bool check_probe(ibl_json_at at, const ibl_probe *p)
{
    const double *half = p->influence.half;
    const double widest = fmin(half[0], fmin(half[1], half[2]));

    if (p->blend > widest)
        return ibl_json_wrong(ibl_json_member(&at, "blend"),
                              "at most %.10g, half the influence's least width",
                              widest);
    return !p->has_proxy || is_inside(&p->proxy, p->position) ||
           ibl_json_complain(ibl_json_member(&at, "proxy"),
                             "expected a volume around the probe's position, "
                             "found it outside");
}

static bool take_name(ibl_json_at at, const ibl_probe_set *set,
                      ibl_set_entry *e)
{
    if (!ibl_json_text_at(at, &e->name))
        return false;
    for (int i = 0; i < set->count; i++)
        if (!strcmp(set->entry[i].name, e->name))
            return ibl_json_complain(
                at,
                "expected a name of its own, found \"%.60s\", which "
                "probes[%d] has",
                e->name, i);
    return true;
}

static bool take_probe(ibl_json_at at, const ibl_probe_set *set,
                       ibl_set_entry *e)
{
    static const char *const keys[] = {"name",      "position", "capture",
                                       "influence", "blend",    "proxy",
                                       "priority",  NULL};

    return ibl_json_object(at, keys) &&
           take_name(ibl_json_member(&at, "name"), set, e) &&
           take_capture(ibl_json_member(&at, "capture"), &e->capture) &&
           ibl_json_probe(at, &e->probe) && check_probe(at, &e->probe);
}

static bool take_global(ibl_json_at at, ibl_set_entry *e)
{
    static const char *const keys[] = {"capture", NULL};

    e->name = "";
    return ibl_json_object(at, keys) &&
           take_capture(ibl_json_member(&at, "capture"), &e->capture);
}

/* ---- the rest of a set ------------------------------------------------- */

static ibl_set_bake bake_default(void)
{
    ibl_set_bake b = {.options = ibl_bake_options_default(),
                      .alpha = IBL_ALPHA_FILE,
                      .texels = ibl_texel_options_default(),
                      .lut_size = ibl_lut_options_default().size};

    b.options.specular_options.size = 128;
    b.options.irradiance_options.size = 16;
    return b;
}

static bool take_int(ibl_json_at at, const char *key, int low, int high,
                     int *value)
{
    return ibl_json_int(ibl_json_optional(&at, key), low, high, value);
}

static const char *const mappings[] = {"linear", "filament", NULL};

static bool take_choice(ibl_json_at at, const char *key,
                        const char *const *names, void *value)
{
    return ibl_json_choice(ibl_json_optional(&at, key), names, value);
}

static bool take_irradiance(ibl_json_at at, int *edge)
{
    const char *word = json_string_value(at.value);
    const bool harmonics = word && !strcmp(word, "sh");
    const json_int_t n = json_integer_value(at.value);

    if (!harmonics && (n < 1 || n > IBL_MAX_CUBE_SIZE))
        return ibl_json_wrong(at, "a whole number from 1 to %d or \"sh\"",
                              IBL_MAX_CUBE_SIZE);
    *edge = harmonics ? 0 : (int)n;
    return true;
}

/* Reads size before levels, which it limits. */
static bool take_defaults(ibl_json_at at, ibl_set_bake *b)
{
    static const char *const keys[] = {
        "size",      "levels",   "mapping",   "method",     "samples",
        "tolerance", "pixel",    "container", "irradiance", "lut_size",
        "alpha",     "overflow", "zstd",      "quality",    NULL};
    ibl_specular_options *s = &b->options.specular_options;

    return ibl_json_object(at, keys) &&
           take_int(at, "size", 1, IBL_MAX_CUBE_SIZE, &s->size) &&
           take_int(at, "levels", 1, ibl_most_levels(s->size), &s->levels) &&
           take_choice(at, "mapping", mappings, &s->mapping) &&
           take_choice(at, "method", ibl_method_names, &s->method) &&
           take_int(at, "samples", 1, 1048576, &s->samples) &&
           ibl_json_real(ibl_json_optional(&at, "tolerance"), 1e-6, 1, false,
                         &s->tolerance) &&
           take_choice(at, "pixel", ibl_pixel_names, &b->texels.pixel) &&
           take_choice(at, "quality", ibl_quality_names, &b->texels.quality) &&
           take_choice(at, "container", ibl_array_container_names,
                       &b->container) &&
           take_int(at, "zstd", 0, IBL_MAX_ZSTD, &b->zstd) &&
           take_irradiance(ibl_json_optional(&at, "irradiance"),
                           &b->options.irradiance_options.size) &&
           take_int(at, "lut_size", 1, 4096, &b->lut_size) &&
           take_choice(at, "alpha", ibl_set_alphas, &b->alpha) &&
           take_choice(at, "overflow", ibl_overflow_names, &b->texels.overflow);
}

/* Sorts the probes by ibl_probes_order and numbers their layers. */
static void sort(ibl_probe_set *set)
{
    for (int i = 0; i < set->count; i++) {
        const ibl_set_entry e = set->entry[i];
        int to = i;
        for (; to; to--) {
            const ibl_probe pair[2] = {set->entry[to - 1].probe, e.probe};
            int order[2];
            ibl_probes_order(pair, 2, order);
            if (!order[0])
                break;
            set->entry[to] = set->entry[to - 1];
        }
        set->entry[to] = e;
    }
    for (int i = 0; i < set->count; i++)
        set->entry[i].probe.layer = i;
}

static bool take_set(ibl_json_at root, ibl_probe_set *set)
{
    static const char *const keys[] = {"version", "defaults", "global",
                                       "probes", NULL};
    const ibl_json_at global = ibl_json_member(&root, "global");
    const ibl_json_at probes = ibl_json_member(&root, "probes");
    const size_t most = IBL_MAX_PROBES - (global.value != NULL);
    int version;

    if (!probes.value && ibl_json_member(&root, "min").value)
        return ibl_json_complain(root, "is a grid: add --grid, which makes a "
                                       "set of it");
    if (!ibl_json_object(root, keys) ||
        !ibl_json_int(ibl_json_member(&root, "version"), IBL_SET_VERSION,
                      IBL_SET_VERSION, &version) ||
        !take_defaults(ibl_json_optional(&root, "defaults"), &set->bake) ||
        !ibl_json_array(probes, 1, most))
        return false;
    const size_t count = json_array_size(probes.value);
    set->entry = calloc(count + 1, sizeof *set->entry);
    if (!set->entry)
        return no_memory(root);
    for (size_t i = 0; i < count; i++) {
        const bool ok =
            take_probe(ibl_json_element(&probes, i), set, &set->entry[i]);
        set->count = ++set->layers;
        if (!ok)
            return false;
    }
    if (global.value && !take_global(global, &set->entry[set->layers++]))
        return false;
    sort(set);
    return true;
}

bool ibl_probe_set_read(const char *path, ibl_console *console,
                        ibl_probe_set *set)
{
    ibl_json_file file = {
        .name = path, .fail = ibl_console_error, .cookie = console};

    *set = (ibl_probe_set){.bake = bake_default()};
    if (!ibl_json_open(&file))
        return false;
    set->root = file.root;
    return take_set(ibl_json_root(&file), set);
}

void ibl_probe_set_free(ibl_probe_set *set)
{
    for (int i = 0; i < set->layers; i++) {
        for (int k = 0; k < set->entry[i].capture.count; k++)
            free(set->entry[i].capture.file[k]);
        json_decref(set->entry[i].note);
    }
    free(set->entry);
    json_decref(set->root);
    *set = (ibl_probe_set){0};
}
