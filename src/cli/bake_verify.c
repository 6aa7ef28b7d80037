/* SPDX-License-Identifier: MIT */
#include <math.h>
#include <stdio.h>

#include "cli/job.h"

static bool judge_lut(ibl_output_set *b, const ibl_texture *tex)
{
    ibl_lut lut = {0};
    const bool ok =
        !ibl_texture_to_lut(b->ctx, tex, &lut) &&
        ibl_report_lut(&b->judged, b->ctx, &lut, b->opts->lut.geometry);

    ibl_lut_free(&lut);
    return ok;
}

static bool judge_cube(ibl_output_set *b, ibl_output_kind kind,
                       const ibl_texture *tex)
{
    const ibl_opts *o = b->opts;
    ibl_cube cube = {0};

    const bool rest = o->lights && kind != IBL_OUTPUT_SKYBOX;
    ibl_judge **judge = &b->from->judge[rest];

    if (!*judge)
        *judge = ibl_judge_create(b->ctx, rest ? &b->from->rest : &b->from->env,
                                  o->bake.yaw_deg, &o->judge);
    bool ok = *judge && !ibl_texture_to_cube(b->ctx, tex, &cube) &&
              ibl_bake_turn_back(b, &cube);
    const ibl_judged judged = {.content = kind,
                               .chain = cube,
                               .levels = tex->levels,
                               .lobe = o->bake.specular_options.lobe,
                               .roughness =
                                   kind == IBL_OUTPUT_SPECULAR
                                       ? b->made.report.layout.roughness
                                       : NULL,
                               .scale = 1,
                               .pixel = tex->pixel};
    ok = ok && ibl_report_levels(&b->judged, *judge, &judged);
    ibl_cube_free(&cube);
    return ok;
}

bool ibl_bake_judge(ibl_output_set *b, ibl_output_kind kind,
                    const ibl_texture *tex)
{
    bool ok = true;

    ibl_console_progress(b->console, "verify", 0);
    b->judged.options = b->opts->judge;
    if (kind == IBL_OUTPUT_LUT)
        ok = judge_lut(b, tex);
    else if (kind != IBL_OUTPUT_LOBES) /* no texel of it has a truth */
        ok = judge_cube(b, kind, tex);
    ibl_console_progress(b->console, "write", 0);
    return ok;
}

bool ibl_bake_judged(const ibl_output_set *b)
{
    char why[160];

    ibl_console_finish(b->console);
    if (!b->opts->common.quiet)
        ibl_report_print(&b->judged, b->from->print);
    return ibl_report_passes(&b->judged, b->opts->max_error, NAN, why,
                             sizeof why) ||
           ibl_console_fail(b->console, "%s: nothing was written", why);
}
