/* SPDX-License-Identifier: MIT */
#include "cli/scenes.h"

#include <math.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include "common/signals.h"
#include "json/json_text.h"

enum {
    BINS = IBL_SURVEY_BINS
};

/* ---- reading ---------------------------------------------------------- */

bool ibl_scenes_read(ibl_ctx *ctx, const ibl_scene_list *list, bool strict,
                     ibl_scenes *out)
{
    bool ok = true;

    *out = (ibl_scenes){0};
    for (int i = 0; i < list->count && ok; i++) {
        const size_t count = (size_t)out->file_count;
        ibl_scene scene;
        ok = !ibl_scene_read(ctx, list->path[i], strict, &scene) &&
             !ibl_scene_survey_add(ctx, &scene, &out->survey);
        if (ok) { /* moves the names of its files */
            const size_t more = (size_t)scene.file_count;
            out->files = ibl_need(
                realloc(out->files, (count + more) * sizeof *out->files));
            memcpy(out->files + count, scene.files, more * sizeof *out->files);
            out->file_count += scene.file_count;
            scene.file_count = 0;
        }
        ibl_scene_free(&scene);
    }
    return ok;
}

void ibl_scenes_free(ibl_scenes *s)
{
    for (int i = 0; i < s->file_count; i++)
        free(s->files[i]);
    free(s->files);
    free(s);
}

/* ---- what the choice is for ------------------------------------------- */

bool ibl_scenes_materials(const ibl_scenes *s, ibl_materials *m)
{
    const ibl_scene_survey *y = &s->survey;
    double all = 0;

    *m = (ibl_materials){0};
    for (int i = 0; i < BINS; i++) {
        const ibl_survey_bin *d = &y->dielectric[i];
        m->weight[i][0] = y->metal[i].power;
        m->weight[i][1] = d->power + y->clearcoat[i].power;
        m->diffuse[i][1] = d->share > 0 ? d->diffuse / d->share : 0;
        all += m->weight[i][0] + m->weight[i][1];
    }
    return all > 1e-9;
}

/* ---- what was found --------------------------------------------------- */

/* The roughness that a share of what reflects does not exceed. */
static double quantile(const ibl_scene_survey *y, double share)
{
    const double all =
        ibl_survey_share(y->metal) + ibl_survey_share(y->dielectric);
    double below = 0;
    int i = -1;

    while (i < BINS - 1 && below <= share * all) {
        i++;
        below += y->metal[i].share + y->dielectric[i].share;
    }
    return i / (BINS - 1.0);
}

void ibl_scenes_tell(const ibl_scenes *s, ibl_choice *c)
{
    const ibl_scene_survey *y = &s->survey;
    const double metals = ibl_survey_share(y->metal);
    const double others = ibl_survey_share(y->dielectric);
    const struct {
        const char *name;
        double share;
    } shares[] = {{"metals", metals},
                  {"dielectrics", others},
                  {"clearcoat", ibl_survey_share(y->clearcoat)},
                  {"sheen", ibl_survey_share(y->sheen)},
                  {"transmission", y->transmission},
                  {"anisotropic", y->anisotropic},
                  {"unlit", y->unlit}};
    double diffuse = 0;
    char albedo[40] = "";

    for (int i = 0; i < BINS; i++)
        diffuse += y->dielectric[i].diffuse;
    if (others > 0)
        snprintf(albedo, sizeof albedo, ", mean albedo %.2g", diffuse / others);
    ibl_choice_add(c, false, "scene",
                   "%d file%s: %d material%s, %d triangles, %d image%s",
                   y->scenes, y->scenes > 1 ? "s" : "", y->materials,
                   y->materials > 1 ? "s" : "", y->triangles, y->images,
                   y->images != 1 ? "s" : "");
    if (metals + others > 0 && quantile(y, 0) >= quantile(y, 1 - 1e-9))
        ibl_choice_add(c, false, "roughness", "%.2g", quantile(y, 0));
    else if (metals + others > 0)
        ibl_choice_add(c, false, "roughness",
                       "%.2g to %.2g, half of it %.2g to %.2g", quantile(y, 0),
                       quantile(y, 1 - 1e-9), quantile(y, 0.25),
                       quantile(y, 0.75));
    for (size_t i = 0; i < sizeof shares / sizeof *shares; i++)
        if (shares[i].share > 0)
            ibl_choice_add(c, false, shares[i].name, "%.3g %% of the area%s",
                           100 * shares[i].share, i == 1 ? albedo : "");
}

/* ---- the sidecar ------------------------------------------------------ */

static json_t *shares(const ibl_survey_bin bins[BINS])
{
    json_t *list = json_array();

    for (int i = 0; i < BINS; i++)
        json_array_append_new(list, json_real(ibl_json_digits(bins[i].share)));
    return list;
}

json_t *ibl_scenes_json(const ibl_scenes *s)
{
    const ibl_scene_survey *y = &s->survey;
    json_t *files = json_array();

    for (int i = 0; i < s->file_count; i++)
        json_array_append_new(files, ibl_json_string(s->files[i]));
    return json_pack(
        "{so si si so so so so sf sf sf}", "files", files, "materials",
        y->materials, "triangles", y->triangles, "metal", shares(y->metal),
        "dielectric", shares(y->dielectric), "clearcoat", shares(y->clearcoat),
        "sheen", shares(y->sheen), "unlit", ibl_json_digits(y->unlit),
        "transmission", ibl_json_digits(y->transmission), "anisotropic",
        ibl_json_digits(y->anisotropic));
}

/* ---- what was found and chosen ---------------------------------------- */

void ibl_choice_add(ibl_choice *c, bool chosen, const char *name,
                    const char *fmt, ...)
{
    char text[320];
    va_list args;

    va_start(args, fmt);
    vsnprintf(text, sizeof text, fmt, args);
    va_end(args);
    char *why = strchr(text, '\t');
    if (why)
        *why++ = '\0';
    ibl_append(&c->table, "%-7s %-14s %s%s%s\n",
               c->rows[chosen]++ ? ""
               : chosen          ? "chosen"
                                 : "found",
               name, text, why && *why ? "  " : "", why ? why : "");
}

void ibl_choice_print(const ibl_choice *c, FILE *to)
{
    fprintf(to,
            "%s%-22s %10s %10s\n%-22s %10zu %10zu\n"
            "%-22s %8.2f %% %8.2f %%  +- %.2g %%\n",
            c->table ? c->table : "", "", "chosen", "default",
            "bytes of texels", c->bytes, c->usual_bytes, "rendered error",
            100 * c->error, 100 * c->usual_error, 100 * c->standard_error);
}

json_t *ibl_choice_json(const ibl_choice *c)
{
    return json_pack("{sf sb s{sI sf sf} s{sI sf}}", "asked_error", c->asked,
                     "reached", c->reached, "set", "bytes",
                     (json_int_t)c->bytes, "rendered_error",
                     ibl_json_digits(c->error), "standard_error",
                     ibl_json_digits(c->standard_error), "default", "bytes",
                     (json_int_t)c->usual_bytes, "rendered_error",
                     ibl_json_digits(c->usual_error));
}
