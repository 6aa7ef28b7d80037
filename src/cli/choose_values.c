/* SPDX-License-Identifier: MIT */
/* What may be chosen, and what each value adds to the error of a chain of a
 * middling size. */
#include <math.h>

#include "cli/choose_set.h"

enum {
    MOST_EDGE = 2048
};

static void add_value(ibl_values *v, int value)
{
    if (v->count < IBL_SET_VALUES)
        v->value[v->count++] = value;
}

/* Adds edges, from a power of two to a last one, in steps of a part of each
 * octave: whole numbers. */
static void add_edges(ibl_values *v, int first, int last, int steps)
{
    for (int octave = first; octave <= last; octave *= 2)
        for (int i = 0; i < steps; i++)
            if (octave * i % steps == 0 && octave + octave * i / steps <= last)
                add_value(v, octave + octave * i / steps);
}

/* Edges up to twice the map's detail, or the default, or twice what the
 * sharpest lobe needs (ibl_specular_layout_of). */
static void list_sizes(ibl_search *s, const ibl_materials *m)
{
    double edge = fmax(s->from->width / 2.0, s->o->bake.specular_options.size);
    int sharpest = 0, last = s->fits ? 8 : 32;

    while (m->weight[sharpest][0] <= 0 && m->weight[sharpest][1] <= 0)
        sharpest++;
    const double r = (double)sharpest / IBL_MATERIAL_STEPS;
    if (r > 0)
        edge = fmin(edge, 5 * M_PI / (r * r));
    while (last < edge && last < MOST_EDGE)
        last *= 2;
    s->part[IBL_SET_SIZE].count = 0;
    add_edges(&s->part[IBL_SET_SIZE], s->fits ? IBL_SET_LEAST_EDGE : 32, last,
              s->fits ? 8 : 1);
}

static void list_levels(ibl_search *s)
{
    s->part[IBL_SET_LEVELS].count = 0;
    for (int levels = s->fits ? 1 : 2; levels < IBL_SET_COUNTS; levels++)
        add_value(&s->part[IBL_SET_LEVELS], levels);
}

/* Of most bytes first. */
static void list_pixels(ibl_search *s)
{
    static const ibl_pixel pixels[] = {IBL_PIXEL_RGBA16F, IBL_PIXEL_R11G11B10F,
                                       IBL_PIXEL_RGB9E5};

    s->part[IBL_SET_PIXEL].count = 0;
    for (int i = 0; i < 3; i++)
        if (ibl_container_holds(s->o->format, pixels[i]))
            add_value(&s->part[IBL_SET_PIXEL], (int)pixels[i]);
}

/* A set without a cube has harmonics, in the sidecar. */
static void list_irradiance(ibl_search *s)
{
    s->part[IBL_SET_IRRADIANCE].count = 0;
    if (s->o->bake.sh_degree >= 2 && !ibl_is_given(&s->o->given, "only"))
        add_value(&s->part[IBL_SET_IRRADIANCE], 0);
    add_edges(&s->part[IBL_SET_IRRADIANCE], 4, 32, 4);
}

static void list_all(ibl_search *s, const ibl_materials *materials)
{
    const ibl_opts *o = s->o;
    const bool fixed = o->of || o->engine;

    if (!ibl_is_given(&o->given, "size"))
        list_sizes(s, materials);
    if (!o->bake.specular_options.levels && !fixed)
        list_levels(s);
    if (!ibl_is_given(&o->given, "pixel") && !fixed)
        list_pixels(s);
    if (o->bake.irradiance && !ibl_is_given(&o->given, "irradiance-size") &&
        !fixed && !(o->bake.irradiance_options.step > 0))
        list_irradiance(s);
    if (o->lut.kind == IBL_LUT_SPLIT && ibl_opts_want(o, IBL_OUTPUT_LUT) &&
        !ibl_is_given(&o->given, "lut-size")) {
        s->part[IBL_SET_LUT].count = 0;
        add_edges(&s->part[IBL_SET_LUT], 4, 256, 4);
    }
    if (s->table && !ibl_is_given(&o->given, "lobe-table-size")) {
        s->part[IBL_SET_LOBES].count = 0;
        add_edges(&s->part[IBL_SET_LOBES], 4, 32, 2);
    }
}

/* Between powers of two, errors are taken to be a power of the edge. */
static void blend_errors(ibl_values *v)
{
    int low = -1, high = 0;

    for (int i = 0; i < v->count; i++) {
        if (ibl_is_power(v->value[i])) {
            low = i;
            continue;
        }
        for (high = i + 1; !ibl_is_power(v->value[high]);)
            high++;
        const double t = log((double)v->value[i] / v->value[low]) /
                         log((double)v->value[high] / v->value[low]);
        v->error[i] = pow(fmax(v->error[low], 1e-12), 1 - t) *
                      pow(fmax(v->error[high], 1e-12), t);
    }
}

/* What the values of a part add to the error of a chain with the finest. */
static bool find_errors(ibl_search *s, const ibl_pick *of, int part)
{
    ibl_values *v = &s->part[part];
    const int last = part == IBL_SET_PIXEL ? 0 : v->count - 1;
    ibl_pick p = *of;
    bool ok = true;

    for (int i = 0; i < v->count && ok; i++)
        if (part == IBL_SET_PIXEL || ibl_is_power(v->value[i])) {
            p.at[part] = i;
            ok = ibl_set_error(s, &p, ibl_beside_chain(s) & ~(1u << part),
                               &v->error[i]);
        }
    for (int i = 0; i < v->count; i++)
        if (i != last)
            v->error[i] = fmax(v->error[i] - v->error[last], 0);
    v->error[last] = 0;
    if (part != IBL_SET_PIXEL)
        blend_errors(v);
    return ok;
}

/* What the others add to the error of a chain of a middling size. */
static bool find_all_errors(ibl_search *s)
{
    ibl_pick p = {.at = {[IBL_SET_SIZE] = s->part[IBL_SET_SIZE].count / 2,
                         [IBL_SET_LEVELS] = s->part[IBL_SET_LEVELS].count - 1}};

    while (p.at[IBL_SET_LEVELS] > 0 && !ibl_chain_make(s, &p))
        p.at[IBL_SET_LEVELS]--;
    if (!ibl_chain_make(s, &p))
        return true; /* and find() finds none */
    bool ok = true;
    for (int i = 0; i < IBL_SET_PARTS && ok; i++)
        if (ibl_set_is_small(s, i))
            ok = find_errors(s, &p, i);
    return ok;
}

bool ibl_search_list(ibl_search *s, const ibl_materials *materials)
{
    list_all(s, materials);
    return find_all_errors(s);
}
