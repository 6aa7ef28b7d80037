/* SPDX-License-Identifier: MIT */
#include "cli/lookup.h"

#include <math.h>
#include <stddef.h>
#include <string.h>

/* ---- cubes ----------------------------------------------------------- */

/* Of each face the centre and where u and v grow. */
static const double axes[IBL_FACES][3][3] = {
    {{1, 0, 0}, {0, 0, -1}, {0, -1, 0}}, {{-1, 0, 0}, {0, 0, 1}, {0, -1, 0}},
    {{0, 1, 0}, {1, 0, 0}, {0, 0, 1}},   {{0, -1, 0}, {1, 0, 0}, {0, 0, -1}},
    {{0, 0, 1}, {1, 0, 0}, {0, -1, 0}},  {{0, 0, -1}, {-1, 0, 0}, {0, -1, 0}}};

/* Adds texel (x, y) of a face. Beyond an edge it is that of the next face,
 * beyond a corner the mean of the three texels there. */
static void add_tap(const ibl_cube *map, int level, int face, int x, int y,
                    double weight, double rgb[3])
{
    const int n = ibl_cube_edge(map->size, level);
    const int in_x = x < 0 ? 0 : x < n ? x : n - 1;
    const int in_y = y < 0 ? 0 : y < n ? y : n - 1;
    int at[3] = {face, x, y};

    if (x != in_x && y != in_y) {
        add_tap(map, level, face, in_x, in_y, weight / 3, rgb);
        add_tap(map, level, face, in_x, y, weight / 3, rgb);
        add_tap(map, level, face, x, in_y, weight / 3, rgb);
        return;
    }
    if (x != in_x ||
        y != in_y) { /* seen beyond the edge, in the face's plane */
        const ibl_level_shape shape =
            ibl_level_shape_of(IBL_PROJECTION_CUBE, n);
        double dir[3];
        ibl_cube_direction(n, face, x, y, dir);
        ibl_level_texel(&shape, dir, at);
    }
    const float *texel = ibl_cube_face(map, level, at[0]) +
                         3 * ((size_t)at[2] * (size_t)n + (size_t)at[1]);
    for (int c = 0; c < 3; c++)
        rgb[c] += weight * (double)texel[c];
}

void ibl_lookup_cube(const ibl_cube *map, int level, const double dir[3],
                     double rgb[3])
{
    const ibl_level_shape shape = ibl_level_shape_of(map->projection, 1);
    const int n = ibl_cube_edge(map->size, level);
    double along[3] = {0};
    int at[3];

    if (map->projection != IBL_PROJECTION_CUBE) {
        ibl_flat_lookup(map, level, dir, rgb);
        return;
    }
    ibl_level_texel(&shape, dir, at);
    for (int k = 0; k < 9; k++)
        along[k / 3] += axes[at[0]][k / 3][k % 3] * dir[k % 3];
    const double x = 0.5 * (along[1] / along[0] + 1) * n - 0.5;
    const double y = 0.5 * (along[2] / along[0] + 1) * n - 0.5;
    const int i = (int)floor(x), j = (int)floor(y);
    memset(rgb, 0, 3 * sizeof *rgb);
    for (int k = 0; k < 4; k++)
        add_tap(map, level, at[0], i + k % 2, j + k / 2,
                (k % 2 ? x - i : i + 1 - x) * (k / 2 ? y - j : j + 1 - y), rgb);
}

void ibl_lookup_chain(const ibl_cube *map, const double dir[3], double lod,
                      double rgb[3])
{
    const double at = fmin(fmax(lod, 0), map->levels - 1);
    const int l = (int)at;
    double next[3];

    ibl_lookup_cube(map, l, dir, rgb);
    if (l + 1 == map->levels)
        return;
    ibl_lookup_cube(map, l + 1, dir, next);
    for (int c = 0; c < 3; c++)
        rgb[c] += (at - l) * (next[c] - rgb[c]);
}

/* ---- harmonics ------------------------------------------------------- */

void ibl_lookup_sh(const double *sh, int degree, const double normal[3],
                   double rgb[3])
{
    double y[(IBL_MAX_SH_DEGREE + 1) * (IBL_MAX_SH_DEGREE + 1)];

    ibl_sh_at(degree, normal, y);
    rgb[0] = rgb[1] = rgb[2] = 0;
    for (int l = 0, i = 0; l <= degree; l++)
        for (const double cosine = ibl_sh_cosine(l); i < (l + 1) * (l + 1); i++)
            for (int c = 0; c < 3; c++)
                rgb[c] += cosine * y[i] * sh[3 * i + c];
    for (int c = 0; c < 3; c++)
        rgb[c] = fmax(rgb[c], 0);
}

/* ---- tables ---------------------------------------------------------- */

/* The two texels along an edge of n around x in 0..1, and the share of the
 * second. */
static double between(int n, double x, int at[2])
{
    const double y = fmin(fmax(x * n - 0.5, 0), n - 1);

    at[0] = (int)y;
    at[1] = at[0] + 1 < n ? at[0] + 1 : at[0];
    return y - at[0];
}

/* Adds a weight times the texel at u, v of a table of n x n. */
static void add_table(const float *data, int n, int channels, double u,
                      double v, double weight, double *out)
{
    int x[2], y[2];
    const double p = between(n, u, x), q = between(n, v, y);

    for (int k = 0; k < 4; k++) {
        const float *texel =
            data + (size_t)channels *
                       ((size_t)y[k / 2] * (size_t)n + (size_t)x[k % 2]);
        const double share = (k % 2 ? p : 1 - p) * (k / 2 ? q : 1 - q);
        for (int c = 0; c < channels; c++)
            out[c] += weight * share * (double)texel[c];
    }
}

void ibl_lookup_lut(const ibl_lut *lut, double n_dot_v, double roughness,
                    double scale_bias[2])
{
    scale_bias[0] = scale_bias[1] = 0;
    add_table(lut->data, lut->size, 2, n_dot_v, roughness, 1, scale_bias);
}

void ibl_lookup_lobes(const ibl_lobe_table *lobes, int taps, double metallic,
                      double n_dot_v, double roughness, double q[4])
{
    const int n = lobes->size, half = lobes->layers / 2;
    const double four = sqrt((taps - 1) / 3.0);

    q[0] = q[1] = q[2] = q[3] = 0;
    for (int k = 0; k < 4; k++) {
        const int layer = k / 2 * half + k % 2 * (half - 1);
        add_table(
            lobes->data + 4 * (size_t)layer * (size_t)(n * n), n, 4,
            (n_dot_v * (n - 1) + 0.5) / n, (roughness * (n - 1) + 0.5) / n,
            (k / 2 ? four : 1 - four) * (k % 2 ? 1 - metallic : metallic), q);
    }
}
