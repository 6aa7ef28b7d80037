/* SPDX-License-Identifier: MIT */
#include "view/probe_save.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/json_load.h"
#include "common/path.h"
#include "common/signals.h"
#include "ibl/io.h"
#include "view/message.h"
#include "view/picture.h"

_Static_assert(IBL_MAX_TILE_PROBES *IBL_FACES < IBL_MAX_OUTPUTS,
               "a set does not fit into one set of outputs");

enum {
    NAME_BYTES = 32
};

static void name_face(int probe, int face, char name[NAME_BYTES])
{
    static const char *const ends[IBL_FACES] = {"px", "nx", "py",
                                                "ny", "pz", "nz"};
    snprintf(name, NAME_BYTES, "probe_%02d_%s.exr", probe, ends[face]);
}

/* ---- faces ------------------------------------------------------------- */

static bool add_face(ibl_outputs *outputs, const char *dir,
                     const view_probe_captures *c, int probe, int face,
                     uint16_t *rgba)
{
    char name[NAME_BYTES];
    void *bytes = NULL;
    size_t size = 0;

    name_face(probe, face, name);
    char *path = ibl_path_join(dir, name);
    const bool ok =
        (path || view_fail("%s: no memory for names in it", dir)) &&
        c->face(c->cookie, probe, face, rgba) &&
        view_exr_encode(path, c->size, c->size, 4, rgba, &bytes, &size) &&
        !ibl_outputs_add(outputs, path, bytes, size);
    free(bytes);
    free(path);
    return ok;
}

static bool add_faces(ibl_outputs *outputs, const char *dir,
                      const view_probe_captures *c)
{
    uint16_t *rgba = malloc((size_t)c->size * (size_t)c->size * 4 * 2);
    bool ok = rgba != NULL;

    if (!rgba)
        view_fail("%s: no memory for faces of %d x %d pixels", dir, c->size,
                  c->size);
    for (int i = 0; i < c->count * IBL_FACES && ok; i++)
        ok = add_face(outputs, dir, c, i / IBL_FACES, i % IBL_FACES, rgba);
    free(rgba);
    return ok;
}

/* ---- the set ----------------------------------------------------------- */

static json_t *probe_json(const ibl_probe *p, int i)
{
    char name[NAME_BYTES];
    json_t *faces = json_array();

    for (int face = 0; face < IBL_FACES; face++) {
        name_face(i, face, name);
        json_array_append_new(faces, json_string(name));
    }
    snprintf(name, sizeof name, "probe_%02d", i);
    return json_pack("{ss so s{so} so sf so* si}", "name", name, "position",
                     ibl_json_triple_of(p->position), "capture", "faces", faces,
                     "influence", ibl_json_volume_of(&p->influence), "blend",
                     p->blend, "proxy",
                     p->has_proxy ? ibl_json_volume_of(&p->proxy) : NULL,
                     "priority", p->priority);
}

static bool add_set(ibl_outputs *outputs, const char *dir,
                    const view_probe_captures *c)
{
    char *path = ibl_path_join(dir, "set.json"), *text = NULL;
    json_t *probes = json_array();
    bool ok = path;

    for (int i = 0; i < c->count; i++)
        ok &= !json_array_append_new(probes, probe_json(&c->probe[i], i));
    json_t *root = json_pack("{si s{si ss si} so}", "version", 1, "defaults",
                             "size", c->size, "mapping", "linear", "irradiance",
                             c->irradiance, "probes", probes);
    text = ok ? ibl_json_text(root) : NULL;
    if (!text)
        view_fail("%s: no memory for its set.json", dir);
    ok = text && !ibl_outputs_add(outputs, path, text, strlen(text));
    json_decref(root);
    free(text);
    free(path);
    return ok;
}

bool view_probe_save(ibl_ctx *ctx, const char *dir,
                     const view_probe_captures *captures)
{
    ibl_outputs *outputs = NULL;
    const bool ok =
        !ibl_start_outputs(ctx, false, &outputs) &&
        !ibl_outputs_mkdir(outputs, dir) && add_faces(outputs, dir, captures) &&
        add_set(outputs, dir, captures) && !ibl_commit_outputs(outputs);

    ibl_end_outputs(outputs);
    return ok;
}
