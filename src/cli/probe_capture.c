/* SPDX-License-Identifier: MIT */
/* Reads and bakes the capture of a probe. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "cli/probes.h"
#include "cli/sheet.h"

enum {
    COLOUR = IBL_CAPTURE_COLOUR,
    ALPHA = IBL_CAPTURE_ALPHA,
    PARTS = IBL_CAPTURE_PARTS
};

/* Opens a map, or a face or cross as it is. */
static bool open_file(const ibl_probes_bake *p, int layer, int i,
                      ibl_source **source)
{
    const ibl_capture *c = &p->set.entry[layer].capture;
    ibl_read_options read = p->opts->common.read;

    read.alpha = ibl_probes_alpha(&p->set, layer);
    if (c->kind != IBL_CAPTURE_EQUIRECT)
        read.layout = IBL_INPUT_EQUIRECT;
    return !ibl_source_open(p->ctx, c->file[i], &read, source);
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
                            p->input, p->set.entry[layer].capture.place);
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

static bool bake_equirect(const ibl_probes_bake *p, int layer,
                          ibl_source *source, ibl_bake_result made[PARTS])
{
    const ibl_read_report *r = ibl_source_report(source);
    const ibl_bake_options *options = &p->set.bake.options;
    ibl_environment rows = ibl_source_environment(source);
    greys grey = {ibl_source_alpha(source), rows.width};
    bool needed = false;

    if (!ibl_probes_fit(p, rows.width, rows.height) ||
        ibl_bake_environment(p->ctx, &rows, options, &made[COLOUR]) ||
        (grey.alpha &&
         !check_alpha(p, layer, r->alpha_least, r->alpha_most, &needed)))
        return false;
    rows.read = read_greys;
    rows.cookie = &grey;
    return !needed ||
           !ibl_bake_environment(p->ctx, &rows, options, &made[ALPHA]);
}

/* ---- cubes ------------------------------------------------------------- */

/* Copies the face whose corner is at column x, row y of an image, as it is or
 * turned by 180 degrees. No alpha is 1. */
static void cut_face(const ibl_image *img, const float *alpha, int x, int y,
                     bool turned, int face, ibl_cube cubes[PARTS])
{
    const int n = cubes[COLOUR].size;
    float *colour = ibl_cube_face(&cubes[COLOUR], 0, face);
    float *grey = ibl_cube_face(&cubes[ALPHA], 0, face);

    for (int i = 0; i < n * n; i++, colour += 3, grey += 3) {
        const int at = turned ? n * n - 1 - i : i;
        const size_t from =
            (size_t)(y + at / n) * (size_t)img->width + (size_t)(x + at % n);
        memcpy(colour, img->data + 3 * from, 3 * sizeof *colour);
        grey[0] = grey[1] = grey[2] = alpha ? alpha[from] : 1;
    }
}

/* Copies the faces of file i of a capture, a face or a cross; allocates cubes
 * with all mips for the first. A cross has its faces as in cli/faces.h, but an
 * upright one -Z below -Y, turned. */
static bool take_faces(const ibl_probes_bake *p, int layer, int i,
                       const ibl_image *img, const float *alpha,
                       ibl_cube cubes[PARTS])
{
    const ibl_capture *c = &p->set.entry[layer].capture;
    const bool cross = c->kind == IBL_CAPTURE_CROSS;
    const bool upright = cross && img->height > img->width;
    const int columns = !cross ? 1 : upright ? 3 : 4;
    const int rows = !cross ? 1 : upright ? 4 : 3;
    const int n = img->width / columns, levels = ibl_most_levels(n);

    if (img->width != n * columns || img->height != n * rows ||
        n > IBL_MAX_CUBE_SIZE || (i && n != cubes[COLOUR].size))
        return ibl_console_fail(p->console,
                                "%s: %s: %s: expected %s, found %d x %d",
                                p->input, c->place, c->file[i],
                                cross ? "a cross of 4 x 3 or 3 x 4 faces"
                                : i   ? "a square as large as the first"
                                      : "a square",
                                img->width, img->height);
    if (!i &&
        (!ibl_probes_fit(p, ibl_latlong_width(n), ibl_latlong_width(n) / 2) ||
         ibl_cube_alloc(p->ctx, n, levels, &cubes[COLOUR]) ||
         ibl_cube_alloc(p->ctx, n, levels, &cubes[ALPHA])))
        return false;
    for (int f = cross ? 0 : i; f < (cross ? IBL_FACES : i + 1); f++) {
        const bool turned = upright && f == IBL_FACES - 1;
        const int *place = ibl_cross_place[f];
        cut_face(img, alpha, cross ? n * (turned ? 1 : place[0]) : 0,
                 cross ? n * (turned ? 3 : place[1]) : 0, turned, f, cubes);
    }
    return true;
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

/* Looks only at the alpha of faces: a cross has pixels beside them. */
static bool bake_cubes(const ibl_probes_bake *p, int layer,
                       ibl_cube cubes[PARTS], ibl_bake_result made[PARTS])
{
    const size_t texels = ibl_cube_texels(cubes[ALPHA].size, 1);
    float least = 1, most = 0;
    bool needed;

    for (size_t i = 0; i < texels; i++) {
        least = fminf(least, cubes[ALPHA].data[3 * i]);
        most = fmaxf(most, cubes[ALPHA].data[3 * i]);
    }
    return check_alpha(p, layer, least, most, &needed) &&
           bake_cube(p, &cubes[COLOUR], &made[COLOUR]) &&
           (!needed || bake_cube(p, &cubes[ALPHA], &made[ALPHA]));
}

bool ibl_capture_bake(const ibl_probes_bake *p, int layer,
                      ibl_bake_result made[PARTS])
{
    const ibl_capture *c = &p->set.entry[layer].capture;
    const bool map = c->kind == IBL_CAPTURE_EQUIRECT;
    ibl_cube cubes[PARTS] = {0};
    bool ok = true;

    ibl_console_progress(p->console, "decode", 0);
    for (int i = 0; i < c->count && ok; i++) {
        ibl_source *source = NULL;
        ibl_image img = {0};
        ok = open_file(p, layer, i, &source) &&
             (map ? bake_equirect(p, layer, source, made)
                  : !ibl_source_image(source, &img) &&
                        take_faces(p, layer, i, &img, ibl_source_alpha(source),
                                   cubes));
        ibl_image_free(&img);
        ibl_source_close(source);
    }
    ok = ok && (map || bake_cubes(p, layer, cubes, made));
    ibl_cube_free(&cubes[COLOUR]);
    ibl_cube_free(&cubes[ALPHA]);
    return ok;
}
