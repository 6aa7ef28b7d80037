/* SPDX-License-Identifier: MIT */
#include "cli/candidate.h"

ibl_status ibl_candidate_bake(ibl_ctx *ctx, const ibl_image *map,
                              const ibl_opts *o, ibl_candidate *out)
{
    const ibl_environment env = {.image = map};
    ibl_bake_options bake = o->bake;
    ibl_status status = IBL_OK;

    *out = (ibl_candidate){0};
    bake.skybox = 0;
    if (bake.specular || bake.irradiance || bake.sh_degree >= 0)
        status = ibl_bake_environment(ctx, &env, &bake, &out->made);
    if (!status && ibl_opts_want(o, IBL_OUTPUT_LUT))
        status = ibl_bake_lut(ctx, &o->lut, &out->lut);
    if (!status && ibl_opts_want(o, IBL_OUTPUT_LOBES)) {
        ibl_lobe_table_options lobes = ibl_lobe_table_options_default();
        lobes.size = o->lobe_table_size;
        lobes.f0 = o->lobe_f0;
        status = ibl_specular_layout_of(&bake.specular_options, &lobes.layout);
        if (!status)
            status = ibl_bake_lobe_table(ctx, &lobes, &out->lobes);
    }
    return status;
}

/* A texture's values as its file gives them back; engine: of the levels. */
static ibl_status round_cube(ibl_ctx *ctx, const ibl_opts *o,
                             const ibl_engine_set *engine, ibl_cube *cube)
{
    ibl_texture tex = {0};
    ibl_cube read = {0};
    ibl_blob main = {0}, faces[IBL_MAX_FACES] = {0};
    ibl_status status =
        ibl_texture_from_cube(ctx, cube, &o->texels, &tex, NULL);

    if (!status && engine) {
        ibl_engine_set set = *engine;
        set.specular = &tex;
        status = ibl_engine_encode(ctx, o->engine, &set, &main, faces);
    }
    if (!status)
        status = ibl_texture_to_cube(ctx, &tex, &read);
    if (!status) {
        ibl_cube_free(cube);
        *cube = read;
    }
    ibl_texture_free(&tex);
    ibl_blob_free(&main);
    for (int i = 0; i < IBL_MAX_FACES; i++)
        ibl_blob_free(&faces[i]);
    return status;
}

static ibl_status round_lut(ibl_ctx *ctx, const ibl_opts *o, ibl_lut *lut)
{
    ibl_texture tex = {0};
    ibl_lut read = {0};
    size_t saturated;
    ibl_status status = ibl_texture_from_lut(
        ctx, lut, ibl_lut_pixel(o->texels.pixel, lut->kind), &tex, &saturated);

    if (!status)
        status = ibl_texture_set(ctx, &tex, "iblbake.table",
                                 ibl_lut_name(lut->kind));
    if (!status)
        status = ibl_texture_to_lut(ctx, &tex, &read);
    if (!status) {
        ibl_lut_free(lut);
        *lut = read;
    }
    ibl_texture_free(&tex);
    return status;
}

ibl_status ibl_candidate_round(ibl_ctx *ctx, const ibl_opts *o,
                               ibl_candidate *c)
{
    const ibl_engine_set set = {NULL, &c->made.irradiance, c->made.sh, "set"};
    ibl_status status = IBL_OK;

    if (c->made.specular.data)
        status = round_cube(ctx, o, o->engine ? &set : NULL, &c->made.specular);
    /* An engine's own files have harmonics or their own levels for it. */
    if (!status && c->made.irradiance.data && !o->engine)
        status = round_cube(ctx, o, NULL, &c->made.irradiance);
    if (!status && c->lut.data)
        status = round_lut(ctx, o, &c->lut);
    return status; /* lobe tables are halves */
}

void ibl_candidate_draw(ibl_drawn *set, const ibl_candidate *c)
{
    if (c->made.specular.data) {
        ibl_drawn_chain(set, &c->made.specular, &c->made.report.layout);
        set->lobes = c->lobes;
        set->shader = c->lobes.data ? IBL_SHADER_TABLE : IBL_SHADER_SPLIT;
    }
    if (c->made.irradiance.data)
        set->irradiance = c->made.irradiance;
    if (c->lut.data)
        set->lut = c->lut;
}

static size_t bytes_of(ibl_pixel pixel, ibl_level_shape s, int levels,
                       int layers)
{
    const ibl_texture t = {.pixel = pixel,
                           .width = s.width,
                           .height = s.height,
                           .levels = levels,
                           .layers = layers,
                           .faces = s.faces};

    return ibl_texture_offset(&t, levels, 0);
}

size_t ibl_candidate_bytes(const ibl_opts *o)
{
    /* An engine's own files have four bytes a texel as well. */
    const ibl_pixel pixel = o->engine ? IBL_PIXEL_RGB9E5 : o->texels.pixel;
    const ibl_projection p = o->bake.specular_options.projection;
    const ibl_level_shape lut = {p, o->lut.size, o->lut.size, 1};
    const ibl_level_shape lobes = {p, o->lobe_table_size, o->lobe_table_size,
                                   1};
    ibl_specular_layout l = {.levels = 0};
    size_t bytes = 0;

    ibl_specular_layout_of(&o->bake.specular_options, &l);
    if (ibl_opts_want(o, IBL_OUTPUT_SPECULAR))
        bytes += bytes_of(pixel, ibl_level_shape_of(p, l.size), l.levels, 1);
    if (ibl_opts_want(o, IBL_OUTPUT_IRRADIANCE))
        bytes += bytes_of(
            pixel, ibl_level_shape_of(p, o->bake.irradiance_options.size), 1,
            1);
    if (ibl_opts_want(o, IBL_OUTPUT_LUT))
        bytes +=
            bytes_of(ibl_lut_pixel(o->texels.pixel, o->lut.kind), lut, 1, 1);
    if (ibl_opts_want(o, IBL_OUTPUT_LOBES))
        bytes +=
            bytes_of(IBL_PIXEL_RGBA16F, lobes, 1,
                     IBL_LOBE_LAYERS / (o->lobe_f0 == IBL_F0_BOTH ? 1 : 2));
    return bytes;
}

void ibl_candidate_free(ibl_candidate *c)
{
    ibl_bake_result_free(&c->made);
    ibl_lut_free(&c->lut);
    ibl_lobe_table_free(&c->lobes);
    *c = (ibl_candidate){0};
}
