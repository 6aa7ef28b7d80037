/* SPDX-License-Identifier: MIT */
#include "cli/choose_set.h"

#include <math.h>
#include <string.h>

static const ibl_roughness_map ladders[] = {
    IBL_ROUGHNESS_BEST, IBL_ROUGHNESS_FILAMENT, IBL_ROUGHNESS_LINEAR};

/* ---- bytes --------------------------------------------------------------
 */

/*
 * Relative errors of texels, measured on the levels of five maps: of formats of
 * single texels wherever they are, of blocks of 4x4 mostly in proportion to the
 * differences within them.
 */
static void format_errors(ibl_pixel pixel, ibl_expected_set *set)
{
    const bool blocks = ibl_pixel_block(pixel) > 1;

    set->step = pixel == IBL_PIXEL_RGBA16F      ? 2e-4
                : pixel == IBL_PIXEL_RGB9E5     ? 1.1e-3
                : pixel == IBL_PIXEL_R11G11B10F ? 4.5e-3
                : blocks                        ? 3e-3
                                                : 0;
    set->slope = blocks ? 0.1 : 0;
}

/* The format of texels; an engine's own files have four bytes as well. */
static ibl_pixel pixel_of(const ibl_opts *o)
{
    return o->engine ? IBL_PIXEL_RGB9E5 : o->texels.pixel;
}

static size_t image_bytes(int edge, ibl_pixel pixel)
{
    const int block = ibl_pixel_block(pixel);
    const size_t blocks = (size_t)((edge + block - 1) / block);

    return blocks * blocks * ibl_pixel_bytes(pixel);
}

size_t ibl_chain_bytes(int size, int levels, ibl_pixel pixel)
{
    size_t bytes = 0;

    for (int l = 0; l < levels; l++)
        bytes += IBL_FACES * image_bytes(ibl_cube_edge(size, l), pixel);
    return bytes;
}

/* Bytes of the outputs that are wanted, but the skybox, with these parts. */
static size_t bytes_with(const ibl_opts *o, const int value[IBL_SET_PARTS])
{
    const ibl_pixel pixel = (ibl_pixel)value[IBL_SET_PIXEL];
    const int layers = IBL_LOBE_LAYERS / (o->lobe_f0 == IBL_F0_BOTH ? 1 : 2);
    size_t bytes = 0;

    if (ibl_opts_want(o, IBL_OUTPUT_SPECULAR))
        bytes +=
            ibl_chain_bytes(value[IBL_SET_SIZE], value[IBL_SET_LEVELS], pixel);
    if (ibl_opts_want(o, IBL_OUTPUT_LOBES))
        bytes +=
            (size_t)(value[IBL_SET_LOBES] * value[IBL_SET_LOBES] * layers) *
            ibl_pixel_bytes(IBL_PIXEL_RGBA16F);
    if (ibl_opts_want(o, IBL_OUTPUT_IRRADIANCE) &&
        value[IBL_SET_IRRADIANCE] > 0)
        bytes += ibl_chain_bytes(value[IBL_SET_IRRADIANCE], 1, pixel);
    if (ibl_opts_want(o, IBL_OUTPUT_LUT))
        bytes += (size_t)(value[IBL_SET_LUT] * value[IBL_SET_LUT]) *
                 ibl_pixel_bytes(ibl_lut_pixel(pixel, o->lut.kind));
    return bytes;
}

void ibl_set_given(const ibl_opts *o, int value[IBL_SET_PARTS])
{
    value[IBL_SET_SIZE] = o->bake.specular_options.size;
    value[IBL_SET_LEVELS] = o->bake.specular_options.levels;
    value[IBL_SET_PIXEL] = (int)pixel_of(o);
    value[IBL_SET_LOBES] = o->lobe_table_size;
    value[IBL_SET_IRRADIANCE] =
        o->bake.irradiance ? o->bake.irradiance_options.size : 0;
    value[IBL_SET_LUT] = o->lut.size;
}

size_t ibl_opts_bytes(const ibl_opts *o)
{
    ibl_specular_layout l = {.levels = 0};
    int value[IBL_SET_PARTS];

    ibl_set_given(o, value);
    ibl_specular_layout_of(&o->bake.specular_options, &l);
    value[IBL_SET_SIZE] = l.size; /* of a part of a chain, its first level */
    value[IBL_SET_LEVELS] = l.levels;
    return bytes_with(o, value);
}

bool ibl_set_next(const ibl_search *s, int first, int end, ibl_pick *p)
{
    for (int i = end - 1; i >= first; i--) {
        if (++p->at[i] < s->part[i].count)
            return true;
        p->at[i] = 0;
    }
    return false;
}

bool ibl_chain_next(const ibl_search *s, ibl_pick *p)
{
    return ibl_set_next(s, IBL_SET_SIZE, IBL_SET_LEVELS + 1, p);
}

bool ibl_set_layout(ibl_search *s, const ibl_pick *p,
                    ibl_specular_layout *layout)
{
    ibl_specular_options o = s->o->bake.specular_options;

    *layout = ibl_chain_of(s, p)->layout;
    if (!p->ladder)
        return true;
    o.size = layout->size;
    o.levels = layout->levels;
    o.mapping = ladders[p->ladder];
    return !ibl_specular_layout_of(&o, layout);
}

size_t ibl_set_bytes(ibl_search *s, const ibl_pick *p)
{
    int value[IBL_SET_PARTS];

    for (int i = 0; i < IBL_SET_PARTS; i++)
        value[i] = ibl_set_value(s, p, i);
    value[IBL_SET_LEVELS] = ibl_chain_of(s, p)->layout.levels;
    return bytes_with(s->o, value);
}

/* The BRDF table of a set, NULL if it is no matter of choice. */
static bool make_lut(ibl_search *s, const ibl_pick *p, const ibl_lut **lut)
{
    ibl_lut *own = &s->luts[p->at[IBL_SET_LUT]];
    const ibl_lut_options of = {.struct_size = sizeof of,
                                .size = ibl_set_value(s, p, IBL_SET_LUT)};

    *lut = NULL;
    if (!ibl_opts_want(s->o, IBL_OUTPUT_LUT) ||
        s->o->lut.kind != IBL_LUT_SPLIT || of.size < 2)
        return true;
    *lut = own;
    return own->data || !ibl_bake_lut(s->from->ctx, &of, own);
}

static bool make_lobes(ibl_search *s, int size,
                       const ibl_specular_layout *layout)
{
    ibl_lobe_table_options of = s->made;

    of.size = size;
    of.layout = *layout;
    if (s->lobes.data && !memcmp(&of, &s->made, sizeof of))
        return true;
    s->made = of;
    ibl_lobe_table_free(&s->lobes);
    return !ibl_bake_lobe_table(s->from->ctx, &of, &s->lobes);
}

bool ibl_set_error(ibl_search *s, const ibl_pick *p, unsigned exact,
                   double *square)
{
    ibl_expected_set set = {
        .lookup = s->table ? IBL_LOOKUP_TABLE : IBL_LOOKUP_SPLIT,
        .irradiance = exact & 1u << IBL_SET_IRRADIANCE
                          ? -1
                          : ibl_set_value(s, p, IBL_SET_IRRADIANCE)};
    double nrmse = 0;
    bool ok = ibl_set_layout(s, p, &set.layout);

    if (!(exact & 1u << IBL_SET_PIXEL))
        format_errors((ibl_pixel)ibl_set_value(s, p, IBL_SET_PIXEL), &set);
    if (!(exact & 1u << IBL_SET_LUT))
        ok = ok && make_lut(s, p, &set.lut);
    if (s->table && !(exact & 1u << IBL_SET_LOBES)) {
        ok = ok &&
             make_lobes(s, ibl_set_value(s, p, IBL_SET_LOBES), &set.layout);
        set.lobes = &s->lobes;
    }
    ok = ok && !ibl_expectation_of(s->e, &set, &nrmse);
    *square = nrmse * nrmse;
    return ok;
}

bool ibl_set_judge(ibl_search *s, ibl_pick *p)
{
    p->bytes = ibl_set_bytes(s, p);
    return ibl_set_error(s, p, 0, &p->error);
}

bool ibl_set_added(ibl_search *s, const ibl_pick *p, int part, double *added)
{
    double without = 0;
    const bool ok = ibl_set_error(s, p, 1u << part, &without);

    *added = fmax(p->error - without, 0);
    return ok;
}

bool ibl_set_is_small(const ibl_search *s, int part)
{
    return part != IBL_SET_SIZE && part != IBL_SET_LEVELS &&
           s->part[part].count > 1;
}

/* ---- chains ---------------------------------------------------------------
 */

/* Whether ladders are fitted to faces of an edge: others take the ladder of the
 * next such edge. */
static bool is_fitted(int edge)
{
    return ibl_is_power(edge) || (edge % 3 == 0 && ibl_is_power(edge / 3));
}

unsigned ibl_beside_chain(const ibl_search *s)
{
    unsigned parts = 1u << IBL_SET_LOBES;

    for (int i = 0; i < IBL_SET_PARTS; i++)
        if (ibl_set_is_small(s, i))
            parts |= 1u << i;
    return parts;
}

bool ibl_chain_measure(ibl_search *s, const ibl_pick *p, ibl_chain *c)
{
    ibl_specular_options o = s->o->bake.specular_options;
    double nrmse = 0;

    o.size = ibl_set_value(s, p, IBL_SET_SIZE);
    o.levels = ibl_set_value(s, p, IBL_SET_LEVELS);
    if (s->fits
            ? ibl_expectation_fit(s->e, o.size, o.levels, &c->layout, &nrmse)
            : ibl_specular_layout_of(&o, &c->layout))
        return false;
    c->least = nrmse * nrmse;
    /* The fit knows no formats, of which blocks matter. */
    if ((!s->fits || (s->part[IBL_SET_PIXEL].count == 1 &&
                      ibl_pixel_block((ibl_pixel)ibl_set_value(
                          s, p, IBL_SET_PIXEL)) > 1)) &&
        !ibl_set_error(s, p, ibl_beside_chain(s), &c->least))
        return false;
    c->least = fmax(c->least, 1e-12);
    return true;
}

/* The chain between two that are fitted: the square of the error is taken to be
 * a power of the edge. */
static bool blend_chain(ibl_search *s, const ibl_pick *p, ibl_chain *c)
{
    const int *edge = s->part[IBL_SET_SIZE].value;
    ibl_pick low = *p, high = *p;

    while (!is_fitted(edge[low.at[IBL_SET_SIZE]]))
        low.at[IBL_SET_SIZE]--;
    while (!is_fitted(edge[high.at[IBL_SET_SIZE]]))
        high.at[IBL_SET_SIZE]++;
    if (!ibl_chain_make(s, &low) || !ibl_chain_make(s, &high))
        return false;
    const ibl_chain *a = ibl_chain_of(s, &low), *b = ibl_chain_of(s, &high);
    const double t =
        log((double)ibl_set_value(s, p, IBL_SET_SIZE) / a->layout.size) /
        log((double)b->layout.size / a->layout.size);
    c->layout = b->layout;
    c->layout.size = ibl_set_value(s, p, IBL_SET_SIZE);
    c->least = pow(a->least, 1 - t) * pow(b->least, t);
    return true;
}

bool ibl_chain_make(ibl_search *s, const ibl_pick *p)
{
    ibl_chain *c = ibl_chain_of(s, p);
    const int edge = ibl_set_value(s, p, IBL_SET_SIZE),
              count = ibl_set_value(s, p, IBL_SET_LEVELS);

    if (c->layout.levels)
        return c->least >= 0;
    c->layout.levels = 1;
    c->least = -1;
    if (count > ibl_most_levels(edge) ||
        (s->part[IBL_SET_LEVELS].count > 1 &&
         edge >> (count - 1) < IBL_SET_LEAST_EDGE))
        return false;
    return s->fits && s->part[IBL_SET_SIZE].count > 1 && !is_fitted(edge)
               ? blend_chain(s, p, c)
               : ibl_chain_measure(s, p, c);
}
