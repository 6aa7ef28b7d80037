/* SPDX-License-Identifier: MIT */
#include "cli/candidate.h"

bool ibl_candidate_bake(ibl_ctx *ctx, const ibl_image *map, const ibl_opts *o,
                        ibl_candidate *out)
{
    const ibl_environment env = {.image = map};
    ibl_bake_options bake = o->bake;
    ibl_lobe_table_options lobes = ibl_lobe_table_options_default();

    *out = (ibl_candidate){0};
    bake.skybox = 0;
    lobes.size = o->lobe_table_size;
    lobes.f0 = o->lobe_f0;
    return ((!bake.specular && !bake.irradiance && bake.sh_degree < 0) ||
            !ibl_bake_environment(ctx, &env, &bake, &out->made)) &&
           (!ibl_opts_want(o, IBL_OUTPUT_LUT) ||
            !ibl_bake_lut(ctx, &o->lut, &out->lut)) &&
           (!ibl_opts_want(o, IBL_OUTPUT_LOBES) ||
            (!ibl_specular_layout_of(&bake.specular_options, &lobes.layout) &&
             !ibl_bake_lobe_table(ctx, &lobes, &out->lobes)));
}

/* A texture's values as its file gives them back. */
static bool round_cube(ibl_ctx *ctx, const ibl_opts *o, const ibl_candidate *c,
                       ibl_cube *cube)
{
    ibl_texture tex = {0};
    ibl_blob main = {0}, faces[IBL_MAX_FACES] = {0};
    bool ok = !ibl_texture_from_cube(ctx, cube, &o->texels, &tex, NULL);

    const ibl_engine_set set = {&tex, &c->made.irradiance, c->made.sh, "set"};

    if (ok && o->engine)
        ok = !ibl_engine_encode(ctx, o->engine, &set, &main, faces);
    ibl_cube_free(cube);
    ok = ok && !ibl_texture_to_cube(ctx, &tex, cube);
    ibl_texture_free(&tex);
    ibl_blob_free(&main);
    for (int i = 0; i < IBL_MAX_FACES; i++)
        ibl_blob_free(&faces[i]);
    return ok;
}

static bool round_lut(ibl_ctx *ctx, const ibl_opts *o, ibl_lut *lut)
{
    const ibl_lut_kind kind = lut->kind;
    ibl_texture tex = {0};
    size_t saturated;
    bool ok = !ibl_texture_from_lut(
        ctx, lut, ibl_lut_pixel(o->texels.pixel, kind), &tex, &saturated);

    ibl_lut_free(lut);
    ok = ok &&
         !ibl_texture_set(ctx, &tex, "iblbake.table", ibl_lut_name(kind)) &&
         !ibl_texture_to_lut(ctx, &tex, lut);
    ibl_texture_free(&tex);
    return ok;
}

bool ibl_candidate_round(ibl_ctx *ctx, const ibl_opts *o, ibl_candidate *c)
{
    bool ok = true;

    if (c->made.specular.data)
        ok = round_cube(ctx, o, c, &c->made.specular);
    /* An engine's own files have harmonics or their own levels for it. */
    if (c->made.irradiance.data && !o->engine)
        ok = ok && round_cube(ctx, o, c, &c->made.irradiance);
    if (c->lut.data)
        ok = ok && round_lut(ctx, o, &c->lut);
    return ok; /* lobe tables are halves */
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
    size_t sum = 0;

    ibl_specular_layout_of(&o->bake.specular_options, &l);
    const size_t bytes[] = {
        [IBL_OUTPUT_SPECULAR] =
            bytes_of(pixel, ibl_level_shape_of(p, l.size), l.levels, 1),
        [IBL_OUTPUT_IRRADIANCE] = bytes_of(
            pixel, ibl_level_shape_of(p, o->bake.irradiance_options.size), 1,
            1),
        [IBL_OUTPUT_LUT] =
            bytes_of(ibl_lut_pixel(o->texels.pixel, o->lut.kind), lut, 1, 1),
        [IBL_OUTPUT_LOBES] =
            bytes_of(IBL_PIXEL_RGBA16F, lobes, 1,
                     IBL_LOBE_LAYERS / (o->lobe_f0 == IBL_F0_BOTH ? 1 : 2))};
    for (int k = IBL_OUTPUT_SPECULAR; k <= IBL_OUTPUT_LOBES; k++)
        sum += ibl_opts_want(o, (ibl_output_kind)k) ? bytes[k] : 0;
    return sum;
}

void ibl_candidate_free(ibl_candidate *c)
{
    ibl_bake_result_free(&c->made);
    ibl_lut_free(&c->lut);
    ibl_lobe_table_free(&c->lobes);
    *c = (ibl_candidate){0};
}
