/* SPDX-License-Identifier: MIT */
/* Sizes and roughnesses of the levels of the specular chain. */
#include <math.h>
#include <stdbool.h>

#include "bake/options.h"
#include "core/context.h"
#include "core/pi.h"
#include "ibl/ibl.h"
#include "image/cube.h"

const char *ibl_roughness_map_name(ibl_roughness_map map)
{
    return map == IBL_ROUGHNESS_LINEAR     ? "linear"
           : map == IBL_ROUGHNESS_FILAMENT ? "filament"
                                           : "babylon";
}

const char *ibl_specular_report_method(const ibl_specular_report *report)
{
    bool sampled = false, spectral = false;

    for (int l = 0; l < report->layout.levels; l++) {
        const ibl_specular_level *level = &report->level[l];
        sampled |= level->samples > 0;
        spectral |= level->degree > 0;
    }
    if (sampled)
        return spectral ? "mixed" : "sampled";
    return spectral ? "spectral" : "environment";
}

/* The quantity that grows in equal steps from level to level. */
static double x_of(ibl_roughness_map map, double r)
{
    return map == IBL_ROUGHNESS_LINEAR ? r : r * (2 - r);
}

static double roughness_of(ibl_roughness_map map, double x)
{
    return map == IBL_ROUGHNESS_LINEAR ? x : 1 - sqrt(1 - x);
}

/* Levels of Babylon.js for each halving of alpha: its lodGenerationScale. */
static const double babylon_scale = 0.8;

static double babylon_roughness(int level, double size)
{
    return level ? sqrt(fmin(exp2(level / babylon_scale) / size, 1)) : 0;
}

double ibl_level_roughness(ibl_roughness_map map, int level, int levels)
{
    if (map == IBL_ROUGHNESS_BABYLON)
        return babylon_roughness(level, exp2(levels - 1));
    return roughness_of(map, levels > 1 ? (double)level / (levels - 1) : 0);
}

int ibl_default_levels(int size)
{
    const int last = size < 8 ? 1 : 8;
    int levels = 1;
    while (size >> levels >= last)
        levels++;
    return levels;
}

/* ---- parts of the range ----------------------------------------------- */

/*
 * Texels along an edge that the lobe of roughness r needs, in a chain whose
 * level 0 has `size`.
 *
 * A prefiltered level is the environment convolved with its lobe, whose
 * spectrum falls like exp(-2 alpha l). Above the degree l = ln(1 / eps) / (2
 * alpha) less than eps is left. Texels pi / l apart hold the rest: l / 2 along
 * an edge of 90 degrees. A shader, however, only interpolates. The image of a
 * small light is the lobe (1 + (angle / 2 alpha)^2)^-2, with the curvature
 * -1 / alpha^2 at the peak in each direction. Between four texels h apart,
 * bilinear interpolation is too low by h^2 / (4 alpha^2). One percent of loss
 * allows h = alpha / 5, that is an edge of 5 pi / (2 alpha) and l = 5
 * pi / alpha. Then eps = exp(-10 pi) is negligible, and r = 1 needs 8 texels,
 * where ibl_default_levels() ends.
 *
 * The whole chain halves its edge at every level, whatever the lobe. Its edge
 * at the lod of r is the upper limit.
 */
static double edge_for(ibl_roughness_map map, int size, double r)
{
    const double lod = x_of(map, r) * (ibl_default_levels(size) - 1);
    const double chain = size * exp2(-lod);
    return r > 0 ? fmin(chain, 5 * IBL_PI / (2 * r * r)) : size;
}

static int default_levels(const ibl_specular_options *o, double edge)
{
    const double last = edge_for(o->mapping, o->size, o->roughness_max);
    int levels = 1;
    if (o->roughness_min <= 0 && o->roughness_max >= 1)
        return ibl_default_levels(o->size);
    if (o->roughness_min >= o->roughness_max)
        return 1;
    /* The nearest number of halvings keeps the roughnesses close together. If
     * it is rounded up, interpolation takes at most 2 % of a small light. */
    while (levels < IBL_MAX_LEVELS && edge * exp2(-levels) >= last * sqrt(0.5))
        levels++;
    return levels > 1 || edge < 2 ? levels : 2;
}

/* The smallest multiple of 2^(levels - 1) that is not below edge. */
static int round_up(double edge, int levels)
{
    const int step = 1 << (levels - 1);
    return (int)ceil((edge - 1e-6) / step) * step;
}

double ibl_lod_of_roughness(const ibl_specular_layout *l, double r)
{
    const double x = l->mapping == IBL_ROUGHNESS_BABYLON
                         ? 2 * log2(fmax(r, 1e-6))
                         : x_of(l->mapping, r);
    return fmin(fmax(x * l->lod_scale + l->lod_offset, 0), l->levels - 1);
}

static void layout_babylon(const ibl_specular_options *o,
                           ibl_specular_layout *layout)
{
    const int levels = o->levels ? o->levels : ibl_cube_most_levels(o->size);
    *layout =
        (ibl_specular_layout){.size = o->size,
                              .levels = levels,
                              .mapping = o->mapping,
                              .lod_scale = babylon_scale,
                              .lod_offset = babylon_scale * log2(o->size)};
    for (int l = 0; l < levels; l++)
        layout->roughness[l] = babylon_roughness(l, o->size);
}

ibl_status ibl_specular_layout_of(const ibl_specular_options *o,
                                  ibl_specular_layout *layout)
{
    if (!o || !layout || ibl_check_roughness(NULL, o) || o->size < 1 ||
        o->size > IBL_MAX_CUBE_SIZE || o->levels < 0 ||
        o->levels > ibl_cube_most_levels(o->size))
        return IBL_ERR_ARGUMENT;
    if (o->mapping == IBL_ROUGHNESS_BABYLON) {
        layout_babylon(o, layout);
        return IBL_OK;
    }
    const double edge = edge_for(o->mapping, o->size, o->roughness_min);
    const int levels = o->levels ? o->levels : default_levels(o, edge);
    const double low = x_of(o->mapping, o->roughness_min);
    const double range = x_of(o->mapping, o->roughness_max) - low;
    ibl_specular_layout l = {
        .size = o->size, .levels = levels, .mapping = o->mapping};
    if (o->roughness_min > 0 && round_up(edge, levels) < o->size)
        l.size = round_up(edge, levels);
    for (int i = 0; i < levels; i++) {
        const double t = levels > 1 ? (double)i / (levels - 1) : 0;
        l.roughness[i] = roughness_of(o->mapping, low + range * t);
    }
    if (levels > 1) {
        l.lod_scale = (levels - 1) / range;
        l.lod_offset = 0 - low * l.lod_scale; /* 0, not -0 */
    }
    *layout = l;
    return IBL_OK;
}
