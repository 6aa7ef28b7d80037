/* SPDX-License-Identifier: MIT */
#include "cli/scenes.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cli/json_text.h"

enum {
    BINS = IBL_SURVEY_BINS,
    SHEEN_SIZE = 32, /* of level 0 of Charlie's chain: its lobes are wide */
    SHEEN_TABLE = 64
};

/* ---- reading ---------------------------------------------------------- */

/* Moves the names of a scene's files. */
static bool take_files(ibl_scenes *s, ibl_scene *scene)
{
    const size_t count = (size_t)s->file_count,
                 more = (size_t)scene->file_count;
    char **all = realloc(s->files, (count + more) * sizeof *all);

    if (!all)
        return false;
    memcpy(all + count, scene->files, more * sizeof *all);
    s->files = all;
    s->file_count += scene->file_count;
    scene->file_count = 0;
    return true;
}

bool ibl_scenes_read(ibl_ctx *ctx, const ibl_opts *o, ibl_scenes *out)
{
    bool ok = true;

    *out = (ibl_scenes){0};
    for (int i = 0; i < o->scenes.count && ok; i++) {
        ibl_scene scene;
        ok = !ibl_scene_read(ctx, o->scenes.path[i], &scene) &&
             !ibl_scene_survey_add(ctx, &scene, &out->survey) &&
             take_files(out, &scene);
        ibl_scene_free(&scene);
    }
    return ok;
}

void ibl_scenes_free(ibl_scenes *s)
{
    for (int i = 0; s && i < s->file_count; i++)
        free(s->files[i]);
    if (s)
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

static double sum(const ibl_survey_bin bins[BINS])
{
    double all = 0;

    for (int i = 0; i < BINS; i++)
        all += bins[i].share;
    return all;
}

static double share_at(const ibl_scene_survey *y, int i)
{
    return y->metal[i].share + y->dielectric[i].share;
}

/* The roughness that a share of what reflects does not exceed. */
static double quantile(const ibl_scene_survey *y, double share)
{
    const double all = sum(y->metal) + sum(y->dielectric);
    double below = 0;
    int i = -1;

    while (i < BINS - 1 && below <= share * all)
        below += share_at(y, ++i);
    return i / (BINS - 1.0);
}

static void tell_share(ibl_choice *c, const char *name, double share)
{
    if (share > 0)
        ibl_choice_found(c, name, "%.3g %% of the area", 100 * share);
}

void ibl_scenes_tell(const ibl_scenes *s, ibl_choice *c)
{
    const ibl_scene_survey *y = &s->survey;
    double diffuse = 0;
    const double rest = sum(y->dielectric);

    for (int i = 0; i < BINS; i++)
        diffuse += y->dielectric[i].diffuse;
    ibl_choice_found(c, "scene",
                     "%d file%s: %d material%s, %d triangles, %d image%s",
                     y->scenes, y->scenes > 1 ? "s" : "", y->materials,
                     y->materials > 1 ? "s" : "", y->triangles, y->images,
                     y->images != 1 ? "s" : "");
    if (sum(y->metal) + rest > 0 && quantile(y, 0) >= quantile(y, 1 - 1e-9))
        ibl_choice_found(c, "roughness", "%.2g", quantile(y, 0));
    else if (sum(y->metal) + rest > 0)
        ibl_choice_found(c, "roughness",
                         "%.2g to %.2g, half of it %.2g to %.2g",
                         quantile(y, 0), quantile(y, 1 - 1e-9),
                         quantile(y, 0.25), quantile(y, 0.75));
    tell_share(c, "metals", sum(y->metal));
    if (rest > 0)
        ibl_choice_found(c, "dielectrics",
                         "%.3g %% of the area, mean albedo %.2g", 100 * rest,
                         diffuse / rest);
    tell_share(c, "clearcoat", sum(y->clearcoat));
    tell_share(c, "sheen", sum(y->sheen));
    tell_share(c, "transmission", y->transmission);
    tell_share(c, "anisotropic", y->anisotropic);
    tell_share(c, "unlit", y->unlit);
}

/* ---- decisions -------------------------------------------------------- */

void ibl_scenes_drop(const ibl_scenes *s, ibl_opts *o, ibl_choice *c)
{
    const unsigned tables = 1u << IBL_OUTPUT_LUT | 1u << IBL_OUTPUT_LOBES;
    const bool lit = sum(s->survey.dielectric) > 0;

    c->usual_bytes = c->bytes = ibl_opts_bytes(o);
    if (o->of || o->engine) {
        ibl_choice_chose(c, "outputs", "as usual",
                         "nothing reflects, but they are of one kind");
        return;
    }
    ibl_choice_chose(c, "specular", "none", "nothing reflects");
    o->only &= ~(tables | 1u << IBL_OUTPUT_SPECULAR);
    if (!lit)
        o->only &= ~(1u << IBL_OUTPUT_IRRADIANCE);
    ibl_choice_chose(c, "irradiance", lit ? "as usual" : "none", "%s",
                     lit ? "" : "all is unlit");
    ibl_opts_select(o);
    c->bytes = ibl_opts_bytes(o);
}

bool ibl_scenes_sheen(const ibl_scenes *s, const ibl_opts *o, ibl_opts *sheen,
                      ibl_choice *c)
{
    const unsigned kinds = 1u << IBL_OUTPUT_SPECULAR | 1u << IBL_OUTPUT_LUT |
                           1u << IBL_OUTPUT_JSON;
    ibl_specular_options *levels = &sheen->bake.specular_options;
    char value[64];

    if (!(sum(s->survey.sheen) > 0))
        return false;
    if (o->of || o->engine) {
        ibl_choice_chose(c, "sheen", "none",
                         "has no place here: add a bake with --lobe charlie");
        return false;
    }
    *sheen = *o;
    sheen->only &= kinds;
    sheen->lobe_table = IBL_LOBES_NO;
    sheen->lut.kind = IBL_LUT_CHARLIE;
    sheen->lut.size = SHEEN_TABLE;
    *levels = ibl_specular_options_default();
    levels->lobe = IBL_LOBE_CHARLIE;
    levels->size = SHEEN_SIZE;
    levels->projection = o->bake.specular_options.projection;
    sheen->bake.skybox = 0;
    sheen->sh_format = IBL_SH_NONE;
    sheen->preview = NULL;
    ibl_opts_select(sheen);
    snprintf(sheen->stem, sizeof sheen->stem, "%.240s_charlie", o->name);
    sheen->name = sheen->stem;
    c->bytes += ibl_opts_bytes(sheen);
    snprintf(value, sizeof value, "Charlie, size %d", SHEEN_SIZE);
    ibl_choice_chose(c, "sheen", value,
                     "its lobes are wide; not in the expected error");
    return true;
}

void ibl_scenes_advise(const ibl_scenes *s, const ibl_opts *o, ibl_choice *c)
{
    if (o->bake.skybox)
        return;
    ibl_choice_chose(c, "skybox", "none", "%s",
                     s->survey.transmission > 0
                         ? "add --skybox N: what transmits shows it"
                         : "add --skybox N to draw it behind");
}

/* ---- the sidecar ------------------------------------------------------ */

static json_t *shares(const ibl_survey_bin bins[BINS])
{
    json_t *list = json_array();

    for (int i = 0; i < BINS; i++)
        append(&list, json_real(ibl_json_digits(bins[i].share)));
    return list;
}

json_t *ibl_scenes_json(const ibl_scenes *s)
{
    const ibl_scene_survey *y = &s->survey;
    json_t *files = json_array(), *scene = json_object();

    for (int i = 0; i < s->file_count; i++)
        append(&files, ibl_json_string(s->files[i]));
    put(&scene, "files", files);
    put(&scene, "materials", json_integer(y->materials));
    put(&scene, "triangles", json_integer(y->triangles));
    put(&scene, "metal", shares(y->metal));
    put(&scene, "dielectric", shares(y->dielectric));
    put(&scene, "clearcoat", shares(y->clearcoat));
    put(&scene, "sheen", shares(y->sheen));
    put(&scene, "unlit", json_real(ibl_json_digits(y->unlit)));
    put(&scene, "transmission", json_real(ibl_json_digits(y->transmission)));
    put(&scene, "anisotropic", json_real(ibl_json_digits(y->anisotropic)));
    return scene;
}
