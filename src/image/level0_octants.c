/* SPDX-License-Identifier: MIT */
#include "image/level0_octants.h"

#include <math.h>
#include <string.h>

#include "core/alloc.h"
#include "core/context.h"
#include "image/image.h"

enum {
    MOST_KEPT = 2 << 20,        /* bytes of spans */
    SHARED = IBL_OCTANT_RGB + 1 /* doubles of a shared texel: sums, weight */
};

/* ---- where octants are ------------------------------------------------ */

/* Position of psi = 0 in columns; whole numbers are borders. Snaps to half
 * pixels, as a yaw in degrees is rounded. */
static double octant_start(int k, int columns, double yaw_deg)
{
    const double turns = yaw_deg / 360 - floor(yaw_deg / 360);
    const double at = (turns + 0.25 * ((k + 1) / 2) + 0.5) * columns;
    const double snapped = floor(2 * at + 0.5) / 2;
    return fabs(at - snapped) < 1e-9 ? snapped : at;
}

/* The part of the first pixel that lies before psi = 0, and its column. */
static double first_pixel(int k, int columns, double yaw_deg, int *column)
{
    const double at = octant_start(k, columns, yaw_deg);
    if (k % 2) {
        *column = (int)ceil(at) - 1;
        return ceil(at) - at;
    }
    *column = (int)floor(at);
    return at - floor(at);
}

/* ---- groups ----------------------------------------------------------- */

/* Sets the columns of the wedge's pixels in each lane, times scale. */
static void set_columns(ibl_octant_group *g, int columns, double yaw_deg,
                        int scale)
{
    for (int m = 0; m < IBL_OCTANTS; m++) {
        const int k = g->octant[m < g->octants ? m : 0];
        int column;
        first_pixel(k, columns, yaw_deg, &column);
        for (int i = 0; i < g->wedge.pixels; i++)
            g->column[i * IBL_OCTANTS + m] =
                scale * ibl_wrap(k % 2 ? column - i : column + i, columns);
    }
}

/* A line's shared texel: on the diagonal or, with axis (n odd), at psi = 0. */
static double *shared_texel(const ibl_octant_group *g, int line, bool axis)
{
    const int each = 1 + g->wedge.size % 2;
    return g->shared + ((size_t)line * (size_t)each + axis) * SHARED;
}

/* The largest number of lines that a row touches. */
static int ring_size(const ibl_wedge *w, int rows)
{
    int most = 1;
    for (int i = 0; i <= rows / 2; i++) {
        ibl_wedge_row row;
        if (ibl_wedge_row_init(w, rows, i, false, &row) &&
            row.last_line - row.first_line + 1 > most)
            most = row.last_line - row.first_line + 1;
    }
    return most;
}

/* Parts differ in width, as near the poles all pixels are in the first part. */
static bool init_parts(ibl_octant_group *g, int ring, int room)
{
    static const int ends[IBL_OCTANT_PARTS] = {1, 2, 4, 6, 8, 10, 13, 16};
    int begin = 0;
    for (int i = 0; i < IBL_OCTANT_PARTS; i++) {
        const int end = g->wedge.half * ends[i] / 16;
        if (end == begin)
            continue;
        ibl_octant_sums *s = &g->sums[g->parts++];
        const size_t slots = (size_t)ring * (size_t)(end - begin);
        s->part = (ibl_wedge_part){begin, end, ring};
        s->sums = ibl_alloc_zeroed(slots, IBL_OCTANT_RGB * sizeof(double));
        s->weights = ibl_alloc_zeroed(slots, sizeof(double));
        s->kept = ibl_alloc_array((size_t)room, sizeof *s->kept);
        s->room = room;
        if (!s->sums || !s->weights || !s->kept)
            return false;
        begin = end;
    }
    return true;
}

static ibl_status init_group(ibl_ctx *ctx, int columns, int rows,
                             double yaw_deg, int size, bool offsets, int room,
                             ibl_octant_group *g)
{
    int column;
    const double before = first_pixel(g->octant[0], columns, yaw_deg, &column);
    const ibl_status status =
        ibl_wedge_init(ctx, size, columns, before, &g->wedge);
    if (status)
        return status;
    const int ring = ring_size(&g->wedge, rows);
    g->column = ibl_alloc_array((size_t)g->wedge.pixels,
                                IBL_OCTANTS * sizeof *g->column);
    g->shared = ibl_alloc_array((size_t)g->wedge.lines * (1 + size % 2),
                                SHARED * sizeof *g->shared);
    if (!g->column || !g->shared || !init_parts(g, ring, room))
        return ibl_no_memory(ctx, "level 0's sums");
    set_columns(g, columns, yaw_deg, offsets ? 3 : 1);
    return IBL_OK;
}

ibl_status ibl_octants_init(ibl_ctx *ctx, const ibl_cube *cube, int columns,
                            int rows, double yaw_deg, bool offsets,
                            ibl_octant_set *set)
{
    double before[IBL_OCTANTS];
    ibl_status status = IBL_OK;
    *set = (ibl_octant_set){0};
    ibl_octants_dsp_init(&set->dsp, ibl_ctx_isa(ctx));
    for (int k = 0; k < IBL_OCTANTS; k++) {
        int column, to = 0;
        const double b = first_pixel(k, columns, yaw_deg, &column);
        for (int f = IBL_OCTANT_TOP; f <= IBL_OCTANT_BOTTOM; f++)
            set->place[k][f] = ibl_octant_place_of(cube, k, (ibl_octant_face)f);
        while (to < set->groups && fabs(before[to] - b) > 1e-9)
            to++;
        if (to == set->groups)
            before[set->groups++] = b;
        ibl_octant_group *g = &set->group[to];
        set->of[k] = to;
        set->lane[k] = g->octants;
        g->octant[g->octants++] = k;
    }
    for (int i = 0; i < set->groups && !status; i++) {
        status = init_group(ctx, columns, rows, yaw_deg, cube->size, offsets,
                            MOST_KEPT / (int)sizeof(ibl_octant_span) /
                                IBL_OCTANT_PARTS / set->groups,
                            &set->group[i]);
    }
    if (status)
        ibl_octants_free(set);
    return status;
}

void ibl_octants_free(ibl_octant_set *set)
{
    for (int i = 0; i < set->groups; i++) {
        ibl_octant_group *g = &set->group[i];
        for (int k = 0; k < g->parts; k++) {
            ibl_free(g->sums[k].sums);
            ibl_free(g->sums[k].weights);
            ibl_free(g->sums[k].kept);
        }
        ibl_free(g->column);
        ibl_free(g->shared);
        ibl_wedge_free(&g->wedge);
    }
    *set = (ibl_octant_set){0};
}

/* ---- into the cube ---------------------------------------------------- */

/* The face of a line; *line becomes the line's index on it. */
static ibl_octant_face face_of(const ibl_wedge *w, int *line)
{
    if (*line < w->half)
        return IBL_OCTANT_TOP;
    if (*line < w->half + w->size) {
        *line -= w->half;
        return IBL_OCTANT_SIDE;
    }
    *line = w->lines - 1 - *line;
    return IBL_OCTANT_BOTTOM;
}

/* Writes the texels of a line from z on, in the octants of all lanes. */
static void write_texels(const ibl_octant_set *set, const ibl_octant_group *g,
                         ibl_octant_face face, int line, int z, int count,
                         double *sums, double *weights)
{
    float nowhere[3], *out[IBL_OCTANTS];
    ptrdiff_t step[IBL_OCTANTS];
    for (int m = 0; m < IBL_OCTANTS; m++) {
        out[m] = nowhere;
        step[m] = 0;
        if (m < g->octants) {
            const ibl_octant_place *p = &set->place[g->octant[m]][face];
            out[m] = p->base + line * p->line + z * p->step;
            step[m] = p->step;
        }
    }
    set->dsp.write(sums, weights, count, out, step);
}

static void keep_shared(const ibl_octant_group *g, int line, bool axis,
                        double *sum, double *weight)
{
    double *to = shared_texel(g, line, axis);
    memcpy(to, sum, IBL_OCTANT_RGB * sizeof *to);
    memset(sum, 0, IBL_OCTANT_RGB * sizeof *to);
    to[IBL_OCTANT_RGB] = *weight;
    *weight = 0;
}

/* Writes a line of a part to the cube and clears its sums. Half texels at its
 * ends are kept as shared: on the diagonal of top and bottom and, with n odd,
 * at psi = 0. */
static void finish_line(const ibl_octant_set *set, ibl_octant_group *g,
                        ibl_octant_sums *s, int line)
{
    const int width = s->part.end_z - s->part.first_z;
    const int slot = ibl_wedge_slot(&g->wedge, &s->part, line);
    double *sums = s->sums + IBL_OCTANT_RGB * (size_t)slot;
    double *weights = s->weights + slot;
    int i = line, begin = 0, end = width;
    const ibl_octant_face face = face_of(&g->wedge, &i);
    if (face != IBL_OCTANT_SIDE && i < s->part.end_z) {
        end = i - s->part.first_z;
        if (end >= 0)
            keep_shared(g, line, false, sums + IBL_OCTANT_RGB * (size_t)end,
                        weights + end);
    }
    if (g->wedge.size % 2 && s->part.first_z == 0 && end > 0) {
        keep_shared(g, line, true, sums, weights);
        begin = 1;
    }
    if (end > begin)
        write_texels(set, g, face, i, s->part.first_z + begin, end - begin,
                     sums + IBL_OCTANT_RGB * (size_t)begin, weights + begin);
}

void ibl_octants_finish(const ibl_octant_set *set, ibl_octant_group *g,
                        int part, int line)
{
    ibl_octant_sums *s = &g->sums[part];
    while (s->written < line)
        finish_line(set, g, s, s->written++);
}

/* Writes a texel shared by the octants first..first + count - 1. */
static void join_texel(const ibl_octant_set *set, int line, bool axis,
                       int first, int count)
{
    double rgb[3] = {0, 0, 0}, weight = 0;
    int i = line;
    const ibl_octant_face face = face_of(&set->group[0].wedge, &i);
    for (int k = first; k < first + count; k++) {
        const int octant = k % IBL_OCTANTS, lane = set->lane[octant];
        const double *from =
            shared_texel(&set->group[set->of[octant]], line, axis);
        for (int c = 0; c < 3; c++)
            rgb[c] += from[c * IBL_OCTANTS + lane];
        weight += from[IBL_OCTANT_RGB];
    }
    const ibl_octant_place *p = &set->place[first][face];
    float *out = p->base + i * p->line + (axis ? 0 : i) * p->step;
    for (int c = 0; c < 3; c++)
        out[c] = (float)(rgb[c] / weight);
}

void ibl_octants_join(const ibl_octant_set *set)
{
    const ibl_wedge *w = &set->group[0].wedge;
    const bool odd = w->size % 2;
    for (int line = 0; line < w->lines; line++) {
        int i = line;
        const bool side = face_of(w, &i) == IBL_OCTANT_SIDE;
        if (!side && i == 0 && odd) { /* the face's middle texel */
            join_texel(set, line, false, 0, IBL_OCTANTS);
            continue;
        }
        for (int k = 0; k < IBL_OCTANTS; k += 2) {
            if (!side)
                join_texel(set, line, false, k, 2);
            if (odd)
                join_texel(set, line, true, k + 1, 2);
        }
    }
}
