/* SPDX-License-Identifier: MIT */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cli/probes.h"
#include "common/names.h"
#include "common/path.h"
#include "common/signals.h"
#include "json/text.h"

ibl_alpha ibl_probes_alpha(const ibl_probe_set *set, int layer)
{
    return layer < set->count ? set->bake.alpha : IBL_ALPHA_IGNORE;
}

/* ---- captures ---------------------------------------------------------- */

/* Joins the names of six faces by commas, as ibl_input_files takes them. */
static bool take_capture(ibl_json_at at, ibl_set_entry *e)
{
    static const char *const kinds[] = {"equirect", "cross", "faces", NULL};
    int kind = 0;

    if (!ibl_json_object(at, kinds))
        return false;
    if (json_object_size(at.value) != 1)
        return ibl_json_wrong(at, "one of equirect, cross and faces");
    while (!json_object_get(at.value, kinds[kind]))
        kind++;
    e->cube = kind > 0;
    snprintf(e->place, sizeof e->place, "%s", at.path);
    const ibl_json_at files = ibl_json_member(&at, kinds[kind]);
    const bool faces = kind == 2;
    if (faces && json_array_size(files.value) != IBL_FACES)
        return ibl_json_wrong(files, "an array of 6 files, +X -X +Y -Y +Z -Z");
    for (size_t i = 0; i < (faces ? IBL_FACES : 1); i++) {
        const char *file;
        if (!ibl_json_text_at(faces ? ibl_json_element(&files, i) : files,
                              &file))
            return false;
        char *path = ibl_need(ibl_path_beside(at.file->name, file));
        const bool comma = faces && strchr(path, ',');
        ibl_append(&e->capture, "%s%s", i ? "," : "", path);
        free(path);
        if (comma)
            return ibl_json_wrong(at, "faces without commas in their paths");
    }
    return true;
}

/* ---- probes ------------------------------------------------------------ */

/* Checks how its volumes go together. */
static bool check_probe(ibl_json_at at, const ibl_probe *p)
{
    const double *half = p->influence.half;
    const double widest = fmin(half[0], fmin(half[1], half[2]));
    ibl_probe walls = {.influence = p->proxy};

    for (int k = 0; k < 3; k++)
        walls.influence.half[k] *= 1 + 1e-9; /* they are inside */
    if (p->blend > widest)
        return ibl_json_wrong(ibl_json_member(&at, "blend"),
                              "at most %.10g, half the influence's least width",
                              widest);
    return !p->has_proxy || ibl_probe_influence(&walls, p->position) > 0 ||
           ibl_json_complain(ibl_json_member(&at, "proxy"),
                             "expected a volume around the probe's position, "
                             "found it outside");
}

/* Takes the probe after those that the set has. */
static bool take_probe(ibl_json_at at, ibl_probe_set *set)
{
    static const char *const keys[] = {"name",      "position", "capture",
                                       "influence", "blend",    "proxy",
                                       "priority",  NULL};
    const ibl_json_at name = ibl_json_member(&at, "name");
    ibl_set_entry *e = &set->entry[set->count];
    ibl_probe *p = &set->probe[set->count];

    if (!ibl_json_object(at, keys) || !ibl_json_text_at(name, &e->name))
        return false;
    for (int i = 0; i < set->count; i++)
        if (!strcmp(set->entry[i].name, e->name))
            return ibl_json_complain(
                name,
                "expected a name of its own, found \"%.60s\", which "
                "probes[%d] has",
                e->name, i);
    return take_capture(ibl_json_member(&at, "capture"), e) &&
           ibl_json_probe(at, p) && check_probe(at, p);
}

/* ---- the rest of a set ------------------------------------------------- */

/* Sorts the probes by ibl_probes_order and numbers their layers. */
static void sort(ibl_probe_set *set)
{
    const size_t count = (size_t)set->count;
    int *order = ibl_need(calloc(count, sizeof *order));
    ibl_probe *probe = ibl_need(calloc(count, sizeof *probe));
    ibl_set_entry *entry = ibl_need(calloc(count + 1, sizeof *entry));

    ibl_probes_order(set->probe, set->count, order);
    entry[count] = set->entry[count];
    for (int i = 0; i < set->count; i++) {
        entry[i] = set->entry[order[i]];
        probe[i] = set->probe[order[i]];
        probe[i].layer = i;
    }
    free(order);
    free(set->probe);
    free(set->entry);
    set->probe = probe;
    set->entry = entry;
}

static bool take_set(ibl_json_at root, ibl_probe_set *set)
{
    static const char *const keys[] = {"version", "defaults", "global",
                                       "probes", NULL};
    static const char *const global_keys[] = {"capture", NULL};
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
        !ibl_probes_defaults(ibl_json_optional(&root, "defaults"),
                             &set->bake) ||
        !ibl_json_array(probes, 1, most))
        return false;
    const size_t count = json_array_size(probes.value);
    set->entry = ibl_need(calloc(count + 1, sizeof *set->entry));
    set->probe = ibl_need(calloc(count, sizeof *set->probe));
    for (size_t i = 0; i < count; i++) {
        const bool ok = take_probe(ibl_json_element(&probes, i), set);
        set->count = ++set->layers;
        if (!ok)
            return false;
    }
    if (global.value) {
        ibl_set_entry *e = &set->entry[set->layers++];
        e->name = "";
        if (!ibl_json_object(global, global_keys) ||
            !take_capture(ibl_json_member(&global, "capture"), e))
            return false;
    }
    sort(set);
    return true;
}

bool ibl_probe_set_read(const char *path, ibl_console *console,
                        ibl_probe_set *set)
{
    ibl_json_file file = {
        .name = path, .fail = ibl_console_error, .cookie = console};

    *set =
        (ibl_probe_set){.bake = {.options = ibl_bake_options_default(),
                                 .alpha = IBL_ALPHA_FILE,
                                 .texels = ibl_texel_options_default(),
                                 .lut_size = ibl_lut_options_default().size}};
    set->bake.options.specular_options.size = 128;
    set->bake.options.irradiance_options.size = 16;
    if (!ibl_json_open(&file))
        return false;
    set->root = file.root;
    return take_set(ibl_json_root(&file), set);
}

void ibl_probe_set_free(ibl_probe_set *set)
{
    for (int i = 0; i < set->layers; i++) {
        free(set->entry[i].capture);
        json_decref(set->entry[i].note);
    }
    free(set->entry);
    free(set->probe);
    json_decref(set->root);
    *set = (ibl_probe_set){0};
}
