/* SPDX-License-Identifier: MIT */
#include "view/probe_save.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/path.h"
#include "common/signals.h"
#include "common/text.h"
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

/* Returns dir/name; the caller must free it. */
static char *path_of(const char *dir, const char *name)
{
    char *path = ibl_path_join(dir, name);

    if (!path)
        view_fail("%s: no memory for a name in it", dir);
    return path;
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
    char *path = path_of(dir, name);
    const bool ok =
        path && c->face(c->cookie, probe, face, rgba) &&
        view_exr_encode(path, c->size, c->size, rgba, &bytes, &size) &&
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

/* Writes one number, or an array of numbers. */
static void put_numbers(FILE *to, const double *v, int count)
{
    char text[IBL_NUMBER_BYTES];

    for (int k = 0; k < count; k++) {
        ibl_number_text(v[k], text);
        fprintf(to, "%s%s", count == 1 ? "" : k ? ", " : "[", text);
    }
    fputs(count == 1 ? "" : "]", to);
}

static void put_volume(FILE *to, const char *name, const ibl_volume *v)
{
    const bool box = v->shape == IBL_SHAPE_BOX;

    fprintf(to, ",\n      \"%s\": {\"%s\": {\"centre\": ", name,
            ibl_shape_name(v->shape));
    put_numbers(to, v->centre, 3);
    fputs(box ? ", \"half\": " : ", \"radius\": ", to);
    put_numbers(to, v->half, box ? 3 : 1);
    fputs("}}", to);
}

static void put_probe(FILE *to, const ibl_probe *p, int i)
{
    char name[NAME_BYTES];

    fprintf(to,
            "%s    {\n      \"name\": \"probe_%02d\",\n      \"position\": ",
            i ? ",\n" : "", i);
    put_numbers(to, p->position, 3);
    fputs(",\n      \"capture\": {\"faces\": [", to);
    for (int face = 0; face < IBL_FACES; face++) {
        name_face(i, face, name);
        fprintf(to, "%s\"%s\"",
                face == 0       ? ""
                : face % 2 == 0 ? ",\n                            "
                                : ", ",
                name);
    }
    fputs("]}", to);
    put_volume(to, "influence", &p->influence);
    fputs(",\n      \"blend\": ", to);
    put_numbers(to, &p->blend, 1);
    if (p->has_proxy)
        put_volume(to, "proxy", &p->proxy);
    fprintf(to, ",\n      \"priority\": %d\n    }", p->priority);
}

static bool add_set(ibl_outputs *outputs, const char *dir,
                    const view_probe_captures *c)
{
    char *path = path_of(dir, "set.json");
    ibl_memory_file file;
    FILE *to = path ? ibl_memory_open(&file) : NULL;

    if (to) {
        fprintf(to,
                "{\n  \"version\": 1,\n  \"defaults\": {\"size\": %d, "
                "\"mapping\": \"linear\", \"irradiance\": %d},\n"
                "  \"probes\": [\n",
                c->size, c->irradiance);
        for (int i = 0; i < c->count; i++)
            put_probe(to, &c->probe[i], i);
        fputs("\n  ]\n}\n", to);
    }
    char *text = ibl_memory_close(to, &file);
    if (path && !text)
        view_fail("%s: no memory for it", path);
    const bool ok = text && !ibl_outputs_add(outputs, path, text, file.size);
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
