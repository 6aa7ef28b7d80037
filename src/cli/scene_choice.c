/* SPDX-License-Identifier: MIT */
#include "cli/scene_choice.h"

#include <math.h>
#include <stdio.h>

#include "cli/choose_set.h"

enum {
    BINS = IBL_SURVEY_BINS,
    SHEEN_LEAST = 5, /* bin: shaders take smaller roughnesses of sheen for it */
    SHEEN_SIZE = 128, /* of Charlie's whole chain, of which a part is made */
    SHEEN_TABLE = 64
};

void ibl_scenes_drop(const ibl_scenes *s, ibl_opts *o, ibl_choice *c)
{
    const unsigned tables = 1u << IBL_OUTPUT_LUT | 1u << IBL_OUTPUT_LOBES;
    const bool lit = ibl_survey_share(s->survey.dielectric) > 0;

    c->usual_bytes = c->bytes = ibl_opts_bytes(o);
    if (o->of || o->engine || ibl_is_given(&o->given, "only")) {
        ibl_choice_chose(c, "outputs", "as asked", "though nothing reflects");
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

/* Levels for the roughnesses of sheen alone. */
static void set_charlie(const ibl_survey_bin sheen[BINS],
                        ibl_specular_options *levels)
{
    const ibl_projection projection = levels->projection;
    int first = 0, last = BINS - 1;

    while (sheen[first].share <= 0)
        first++;
    while (sheen[last].share <= 0)
        last--;
    *levels = ibl_specular_options_default();
    levels->lobe = IBL_LOBE_CHARLIE;
    levels->size = SHEEN_SIZE;
    levels->projection = projection;
    levels->roughness_min = fmax(first, SHEEN_LEAST) / (BINS - 1.0);
    levels->roughness_max = fmax(last, SHEEN_LEAST) / (BINS - 1.0);
}

static void set_sheen(const ibl_scenes *s, const ibl_opts *o, ibl_opts *sheen)
{
    *sheen = *o;
    sheen->only &= 1u << IBL_OUTPUT_SPECULAR | 1u << IBL_OUTPUT_JSON |
                   /* which a set of that table has */
                   (o->lut.kind != IBL_LUT_CHARLIE) << IBL_OUTPUT_LUT;
    sheen->lobe_table = IBL_LOBES_NO;
    sheen->lut = ibl_lut_options_default(); /* what was given is of split */
    sheen->lut.kind = IBL_LUT_CHARLIE;
    sheen->lut.size = SHEEN_TABLE;
    sheen->bake.skybox = 0;
    sheen->sh_format = IBL_SH_NONE;
    sheen->preview = NULL;
    set_charlie(s->survey.sheen, &sheen->bake.specular_options);
    ibl_opts_select(sheen);
    snprintf(sheen->stem, sizeof sheen->stem, "%.240s_charlie", o->name);
    sheen->name = sheen->stem;
}

bool ibl_scenes_sheen(const ibl_scenes *s, const ibl_opts *o, ibl_opts *sheen,
                      ibl_choice *c)
{
    ibl_specular_layout l;
    char value[64];

    if (!(ibl_survey_share(s->survey.sheen) > 0))
        return false;
    if (o->of || o->engine || !(o->only & 1u << IBL_OUTPUT_SPECULAR)) {
        ibl_choice_chose(
            c, "sheen", "none",
            "not in such files: bake it apart with --lobe charlie");
        return false;
    }
    set_sheen(s, o, sheen);
    if (ibl_specular_layout_of(&sheen->bake.specular_options, &l))
        return false;
    c->bytes += ibl_opts_bytes(sheen);
    snprintf(value, sizeof value, "Charlie, size %d, %d level%s", l.size,
             l.levels, l.levels > 1 ? "s" : "");
    ibl_choice_chose(c, "sheen", value,
                     "fitted to its roughness; not in the expected error");
    return true;
}

void ibl_scenes_advise(const ibl_scenes *s, const ibl_opts *o, ibl_choice *c)
{
    if (o->bake.skybox)
        return;
    ibl_choice_chose(c, "skybox", "none", "%s",
                     s->survey.transmission > 0
                         ? "add --skybox N: what transmits light shows it"
                         : "add --skybox N to draw it behind");
}
