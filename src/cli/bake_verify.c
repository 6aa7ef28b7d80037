/* SPDX-License-Identifier: MIT */
#include "cli/bake_record.h"

static ibl_status judge_lut(ibl_bake *b, const ibl_texture *tex)
{
    ibl_lut lut = {0};
    ibl_status status = ibl_texture_to_lut(b->ctx, tex, &lut);

    if (!status)
        status = ibl_judge_lut(b->ctx, &lut, tex->pixel, b->opts->lut.geometry,
                               &b->opts->judge, &b->judged.lut);
    b->judged.has_lut = !status;
    ibl_lut_free(&lut);
    return status;
}

static ibl_status judge_cube(ibl_bake *b, ibl_output_kind kind,
                             const ibl_texture *tex)
{
    ibl_cube cube = {0};
    ibl_status status = IBL_OK;

    if (!b->judge)
        status = ibl_judge_create(b->ctx, &b->env, b->opts->bake.yaw_deg,
                                  &b->opts->judge, &b->judge);
    if (!status)
        status = ibl_texture_to_cube(b->ctx, tex, &cube);
    for (int l = 0; l < tex->levels && !status; l++) {
        const ibl_judge_level level = {
            .role = (ibl_role)kind,
            .lobe = b->opts->bake.specular_options.lobe,
            .roughness = kind == IBL_OUTPUT_SPECULAR
                             ? b->made.report.layout.roughness[l]
                             : 0,
            .scale = 1,
            .size = ibl_cube_edge(cube.size, l),
            .base = cube.size,
            .texels = ibl_cube_face(&cube, l, 0),
            .pixel = tex->pixel};
        status = ibl_report_add(&b->judged, b->judge, kind, l, &level);
    }
    ibl_cube_free(&cube);
    return status;
}

ibl_status ibl_bake_judge(ibl_bake *b, ibl_output_kind kind,
                          const ibl_texture *tex)
{
    ibl_texture read = {0};
    void *bytes = NULL;
    size_t size;

    ibl_status status =
        ibl_texture_encode(b->ctx, tex, b->opts->format, &bytes, &size);
    ibl_console_progress(b->console, "verify", 0);
    b->judged.options = b->opts->judge;
    if (!status)
        status = ibl_texture_decode(b->ctx, b->files[kind].path, bytes, size,
                                    &read, NULL);
    if (!status)
        status = kind == IBL_OUTPUT_LUT ? judge_lut(b, &read)
                                        : judge_cube(b, kind, &read);
    ibl_texture_free(&read);
    ibl_bytes_free(bytes);
    return status;
}

ibl_status ibl_bake_judged(const ibl_bake *b)
{
    char why[160];

    ibl_console_finish(b->console);
    if (!b->opts->common.quiet)
        ibl_report_print(&b->judged, stdout);
    if (ibl_report_passes(&b->judged, b->opts->max_error, why, sizeof why))
        return IBL_OK;
    return ibl_refuse(b->console, IBL_ERR_ARGUMENT, "%s: nothing was written",
                      why);
}
