/* SPDX-License-Identifier: MIT */
/* Reads and bakes the capture of a probe. */
#include <stdlib.h>
#include <string.h>

#include "cli/probes.h"
#include "cli/sheet.h"

enum {
    COLOUR = IBL_CAPTURE_COLOUR,
    ALPHA = IBL_CAPTURE_ALPHA,
    PARTS = IBL_CAPTURE_PARTS
};

static const ibl_capture *capture_of(const ibl_probes_bake *p, int layer)
{
    return &p->set.entry[layer].capture;
}

static bool open_file(const ibl_probes_bake *p, int layer, int i,
                      ibl_alpha alpha, ibl_source **source)
{
    const ibl_capture *c = capture_of(p, layer);
    ibl_read_options read = p->opts->common.read;

    read.alpha = alpha;
    if (c->kind != IBL_CAPTURE_EQUIRECT)
        read.layout = IBL_INPUT_EQUIRECT; /* as it is */
    return !ibl_source_open(p->ctx, c->file[i], &read, source);
}

bool ibl_capture_pixels(const ibl_probes_bake *p, int layer, uint64_t *pixels)
{
    const ibl_capture *c = capture_of(p, layer);
    ibl_source *source = NULL;
    const bool ok = open_file(p, layer, 0, IBL_ALPHA_IGNORE, &source);

    if (ok)
        *pixels = (uint64_t)ibl_source_width(source) *
                  (uint64_t)ibl_source_height(source) * (uint64_t)c->count;
    ibl_source_close(source);
    return ok;
}

/* *needed: whether alpha, from least to most, must be baked. */
static bool check_alpha(const ibl_probes_bake *p, int layer, float least,
                        float most, bool *needed)
{
    *needed = least < IBL_CAPTURE_OPAQUE;
    return most > 0 ||
           ibl_console_fail(p->console,
                            "%s: %s: alpha is 0 everywhere, so nothing would "
                            "be seen of this probe: save it with alpha 1 where "
                            "something is, or take --alpha ignore",
                            p->opts->input, capture_of(p, layer)->place);
}

/* ---- maps -------------------------------------------------------------- */

/* The cookie of read_greys; alpha is the next row. */
typedef struct greys {
    const float *alpha;
    int width;
} greys;

static ibl_status read_greys(void *cookie, int rows, float *rgb)
{
    greys *g = cookie;
    const size_t count = (size_t)rows * (size_t)g->width;

    for (size_t i = 0; i < 3 * count; i++)
        rgb[i] = g->alpha[i / 3];
    g->alpha += count;
    return IBL_OK;
}

static bool bake_source(const ibl_probes_bake *p, int layer, ibl_source *source,
                        ibl_bake_result made[PARTS])
{
    const ibl_read_report *r = ibl_source_report(source);
    const ibl_bake_options *options = &p->set.bake.options;
    ibl_environment rows = ibl_source_environment(source);
    greys grey = {ibl_source_alpha(source), rows.width};
    bool needed = false;

    if (ibl_bake_environment(p->ctx, &rows, options, &made[COLOUR]) ||
        (grey.alpha &&
         !check_alpha(p, layer, r->alpha_least, r->alpha_most, &needed)))
        return false;
    rows.read = read_greys;
    rows.cookie = &grey;
    return !needed ||
           !ibl_bake_environment(p->ctx, &rows, options, &made[ALPHA]);
}

static bool bake_equirect(const ibl_probes_bake *p, int layer,
                          ibl_bake_result made[PARTS])
{
    ibl_source *source = NULL;
    const bool ok =
        open_file(p, layer, 0, ibl_probes_alpha(&p->set, layer), &source) &&
        bake_source(p, layer, source, made);

    ibl_source_close(source);
    return ok;
}

/* ---- cubes ------------------------------------------------------------- */

/* An image of one face, or a cross of all six. */
typedef struct view {
    ibl_source *source;
    ibl_image img;
    const float *alpha; /* of each pixel, owned by source; NULL: none */
    bool cross;
} view;

static bool read_view(const ibl_probes_bake *p, int layer, int i, view *v)
{
    *v = (view){.cross = capture_of(p, layer)->kind == IBL_CAPTURE_CROSS};
    if (!open_file(p, layer, i, ibl_probes_alpha(&p->set, layer), &v->source))
        return false;
    v->alpha = ibl_source_alpha(v->source);
    return !ibl_image_alloc(p->ctx, ibl_source_width(v->source),
                            ibl_source_height(v->source), &v->img) &&
           !ibl_source_read(v->source, v->img.height, v->img.data);
}

static void free_view(view *v)
{
    ibl_image_free(&v->img);
    ibl_source_close(v->source);
}

/* The edge of a view's faces in pixels; 0: the view has a wrong shape. */
static int face_edge(const view *v)
{
    const int width = v->img.width, height = v->img.height;
    const bool wide = width > height;
    const int columns = !v->cross ? 1 : wide ? 4 : 3;
    const int rows = !v->cross ? 1 : wide ? 3 : 4;
    const int n = width / columns;
    const bool fits = width == n * columns && height == n * rows;

    return fits && n <= IBL_MAX_CUBE_SIZE ? n : 0;
}

static bool wrong_shape(const ibl_probes_bake *p, int layer, int i,
                        const view *v, int size)
{
    const ibl_capture *c = capture_of(p, layer);
    char place[16] = "", expected[64];

    if (!v->cross)
        snprintf(place, sizeof place, "[%d]", i);
    if (size)
        snprintf(expected, sizeof expected, "%d x %d as faces[0]", size, size);
    else
        snprintf(expected, sizeof expected,
                 v->cross ? "a cross of 4 x 3 or 3 x 4 faces" : "a square");
    return ibl_console_fail(
        p->console, "%s: %s.%s%s: %s: expected %s, found %d x %d",
        p->opts->input, c->place, ibl_capture_name(c->kind), place, c->file[i],
        expected, v->img.width, v->img.height);
}

/* Allocates cubes with faces of n x n texels and all mips; sets alpha to 1. */
static bool alloc_cubes(const ibl_probes_bake *p, int n, ibl_cube cubes[PARTS])
{
    const int levels = ibl_most_levels(n);

    if (ibl_cube_alloc(p->ctx, n, levels, &cubes[COLOUR]) ||
        ibl_cube_alloc(p->ctx, n, levels, &cubes[ALPHA]))
        return false;
    for (size_t i = 0; i < 3 * ibl_cube_texels(n, 1); i++)
        cubes[ALPHA].data[i] = 1;
    return true;
}

/* Copies a face. Faces are placed as in the cross of cli/faces.h, except that
 * an upright cross has -Z below -Y, turned by 180 degrees. */
static void cut_face(const view *v, int face, ibl_cube cubes[PARTS])
{
    const ibl_image *img = &v->img;
    const bool turned = v->cross && face == 5 && img->height > img->width;
    const int n = cubes[COLOUR].size;
    const int column = turned ? 1 : v->cross ? ibl_cross_place[face][0] : 0;
    const int row = turned ? 3 : v->cross ? ibl_cross_place[face][1] : 0;
    float *colour = ibl_cube_face(&cubes[COLOUR], 0, face);
    float *alpha = ibl_cube_face(&cubes[ALPHA], 0, face);

    for (int y = 0; y < n; y++)
        for (int x = 0; x < n; x++, colour += 3, alpha += 3) {
            const int from_x = n * column + (turned ? n - 1 - x : x);
            const int from_y = n * row + (turned ? n - 1 - y : y);
            const size_t from =
                (size_t)from_y * (size_t)img->width + (size_t)from_x;
            memcpy(colour, img->data + 3 * from, 3 * sizeof *colour);
            for (int k = 0; k < 3 && v->alpha; k++)
                alpha[k] = v->alpha[from];
        }
}

/* Copies the faces of file i of a capture; allocates cubes for the first. */
static bool take_view(const ibl_probes_bake *p, int layer, int i, const view *v,
                      ibl_cube cubes[PARTS])
{
    const int n = face_edge(v), size = cubes[COLOUR].size;

    if (!n || (size && n != size))
        return wrong_shape(p, layer, i, v, size);
    if (!size && !alloc_cubes(p, n, cubes))
        return false;
    if (!v->cross)
        cut_face(v, i, cubes);
    for (int f = 0; f < IBL_FACES && v->cross; f++)
        cut_face(v, f, cubes);
    return true;
}

static bool read_cubes(const ibl_probes_bake *p, int layer,
                       ibl_cube cubes[PARTS])
{
    bool ok = true;

    for (int i = 0; i < capture_of(p, layer)->count && ok; i++) {
        view v;
        ok = read_view(p, layer, i, &v) && take_view(p, layer, i, &v, cubes);
        free_view(&v);
    }
    return ok;
}

/* Sets level0 to the level of cube with the specular size; empty: none. */
static bool find_level0(const ibl_probes_bake *p, ibl_cube *cube,
                        ibl_cube *level0)
{
    const int size = p->set.bake.options.specular_options.size;
    int level = 0;

    *level0 = (ibl_cube){0};
    while (level + 1 < cube->levels && cube->size >> level > size)
        level++;
    if (size << level != cube->size)
        return true;
    *level0 = (ibl_cube){
        .size = size, .levels = 1, .data = ibl_cube_face(cube, level, 0)};
    return !level || !ibl_cube_build_mips(p->ctx, cube);
}

static bool bake_cube(const ibl_probes_bake *p, ibl_cube *cube,
                      ibl_bake_result *made)
{
    const int width = ibl_latlong_width(cube->size);
    ibl_bake_options options = p->set.bake.options;
    ibl_image map = {0};
    const ibl_environment env = {.image = &map};
    ibl_cube level0;

    bool ok = !ibl_image_alloc(p->ctx, width, width / 2, &map) &&
              !ibl_latlong_from_cube(p->ctx, cube, &map) &&
              find_level0(p, cube, &level0);
    if (ok && level0.data)
        options.level0 = &level0;
    ok = ok && !ibl_bake_environment(p->ctx, &env, &options, made);
    ibl_image_free(&map);
    return ok;
}

/* Checks only the faces: a cross has transparent pixels beside them. */
static bool check_cube_alpha(const ibl_probes_bake *p, int layer,
                             const ibl_cube *alpha, bool *needed)
{
    const size_t texels = ibl_cube_texels(alpha->size, 1);
    float least = 1, most = 0;

    for (size_t i = 0; i < texels; i++) {
        const float a = alpha->data[3 * i];
        least = a < least ? a : least;
        most = a > most ? a : most;
    }
    return check_alpha(p, layer, least, most, needed);
}

static bool bake_cubes(const ibl_probes_bake *p, int layer,
                       ibl_bake_result made[PARTS])
{
    ibl_cube cubes[PARTS] = {0};
    bool needed[PARTS] = {true};
    bool ok = read_cubes(p, layer, cubes) &&
              check_cube_alpha(p, layer, &cubes[ALPHA], &needed[ALPHA]);

    for (int part = 0; part < PARTS; part++) {
        ok = ok && (!needed[part] || bake_cube(p, &cubes[part], &made[part]));
        ibl_cube_free(&cubes[part]);
    }
    return ok;
}

bool ibl_capture_bake(const ibl_probes_bake *p, int layer,
                      ibl_bake_result made[PARTS])
{
    ibl_console_progress(p->console, "decode", 0);
    return capture_of(p, layer)->kind == IBL_CAPTURE_EQUIRECT
               ? bake_equirect(p, layer, made)
               : bake_cubes(p, layer, made);
}
