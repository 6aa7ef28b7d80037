/* SPDX-License-Identifier: MIT */
#include "cli/probe_capture.h"

#include <stdlib.h>
#include <string.h>

#include "cli/faces.h"

enum {
    COLOUR = IBL_CAPTURE_COLOUR,
    ALPHA = IBL_CAPTURE_ALPHA,
    PARTS = IBL_CAPTURE_PARTS
};

typedef struct taker {
    ibl_ctx *ctx;
    ibl_console *console;
    const char *set;
    const ibl_capture *capture;
    const ibl_read_options *read;
    const ibl_bake_options *options;
    ibl_bake_result *made;
} taker;

/* Whether alpha needs a bake; from the least and the most of a capture. */
static ibl_status check_alpha(const taker *t, float least, float most,
                              bool *needed)
{
    *needed = least < IBL_CAPTURE_OPAQUE;
    if (most > 0)
        return IBL_OK;
    return ibl_refuse(t->console, IBL_ERR_FORMAT,
                      "%s: %s: alpha is 0 everywhere, so nothing would be "
                      "seen of this probe: save it with alpha 1 where "
                      "something is, or take --alpha ignore",
                      t->set, t->capture->place);
}

/* ---- maps -------------------------------------------------------------- */

static ibl_status read_rows(void *cookie, int rows, float *rgb)
{
    return ibl_source_read(cookie, rows, rgb);
}

/* Rows of alpha as rows of greys. */
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

static ibl_status bake_source(const taker *t, ibl_source *source)
{
    greys grey = {ibl_source_alpha(source), ibl_source_width(source)};
    ibl_environment rows = {.width = ibl_source_width(source),
                            .height = ibl_source_height(source),
                            .read = read_rows,
                            .cookie = source};
    ibl_status status =
        ibl_bake_environment(t->ctx, &rows, t->options, &t->made[COLOUR]);
    bool needed = false;

    if (!status && grey.alpha) {
        const ibl_read_report *r = ibl_source_report(source);
        status = check_alpha(t, r->alpha_least, r->alpha_most, &needed);
    }
    if (!status && needed) {
        rows.read = read_greys;
        rows.cookie = &grey;
        status =
            ibl_bake_environment(t->ctx, &rows, t->options, &t->made[ALPHA]);
    }
    return status;
}

static ibl_status bake_equirect(const taker *t)
{
    ibl_source *source = NULL;
    ibl_status status =
        ibl_source_open(t->ctx, t->capture->file[0], t->read, &source);

    if (!status)
        status = bake_source(t, source);
    ibl_source_close(source);
    return status;
}

/* ---- cubes ------------------------------------------------------------- */

/* Colours and alpha of a file, without texels where it has none. */
static ibl_status read_view(const taker *t, const char *file,
                            ibl_image view[PARTS])
{
    ibl_read_options read = *t->read;
    ibl_source *source = NULL;

    read.any_aspect = 1;
    ibl_status status = ibl_source_open(t->ctx, file, &read, &source);
    if (status)
        return status;
    greys grey = {ibl_source_alpha(source), ibl_source_width(source)};
    for (int part = 0; part < PARTS && !status; part++)
        if (part == COLOUR || grey.alpha)
            status = ibl_image_alloc(t->ctx, grey.width,
                                     ibl_source_height(source), &view[part]);
    if (!status)
        status =
            ibl_source_read(source, view[COLOUR].height, view[COLOUR].data);
    if (!status && grey.alpha)
        read_greys(&grey, view[ALPHA].height, view[ALPHA].data);
    ibl_source_close(source);
    return status;
}

static void free_view(ibl_image view[PARTS])
{
    for (int part = 0; part < PARTS; part++)
        ibl_image_free(&view[part]);
}

static ibl_status wrong_shape(const taker *t, int i, const ibl_image *img,
                              const char *expected)
{
    char place[160];

    if (t->capture->count > 1)
        snprintf(place, sizeof place, "%s.faces[%d]", t->capture->place, i);
    else
        snprintf(place, sizeof place, "%s.cross", t->capture->place);
    return ibl_refuse(t->console, IBL_ERR_FORMAT,
                      "%s: %s: %s: expected %s, found %d x %d", t->set, place,
                      t->capture->file[i], expected, img->width, img->height);
}

/* Cubes of faces of n, with alpha 1. */
static ibl_status alloc_cubes(const taker *t, int n, ibl_cube cubes[PARTS])
{
    const int levels = ibl_most_levels(n);
    ibl_status status = ibl_cube_alloc(t->ctx, n, levels, &cubes[COLOUR]);

    if (!status)
        status = ibl_cube_alloc(t->ctx, n, levels, &cubes[ALPHA]);
    for (size_t i = 0; !status && i < 3 * ibl_cube_texels(n, 1); i++)
        cubes[ALPHA].data[i] = 1;
    return status;
}

/* Copies a face from the place in a picture whose upper left texel is (x, y);
 * turned: by half a turn. */
static void cut_face(const ibl_image *img, int x, int y, bool turned, int n,
                     float *face)
{
    for (int j = 0; j < n; j++)
        for (int i = 0; i < n; i++, face += 3) {
            const int from_x = x + (turned ? n - 1 - i : i);
            const int from_y = y + (turned ? n - 1 - j : j);
            memcpy(face,
                   img->data + 3 * ((size_t)from_y * (size_t)img->width +
                                    (size_t)from_x),
                   3 * sizeof *face);
        }
}

static void cut_view(const ibl_image view[PARTS], int x, int y, bool turned,
                     int face, ibl_cube cubes[PARTS])
{
    for (int part = 0; part < PARTS; part++)
        if (view[part].data)
            cut_face(&view[part], x, y, turned, cubes[part].size,
                     ibl_cube_face(&cubes[part], 0, face));
}

static ibl_status read_faces(const taker *t, ibl_cube cubes[PARTS])
{
    ibl_status status = IBL_OK;

    for (int f = 0; f < IBL_FACES && !status; f++) {
        const int size = cubes[COLOUR].size;
        ibl_image view[PARTS] = {0};
        char expected[64] = "a square";
        status = read_view(t, t->capture->file[f], view);
        const ibl_image *img = &view[COLOUR];
        if (size)
            snprintf(expected, sizeof expected, "%d x %d as faces[0]", size,
                     size);
        if (!status &&
            (img->width != img->height || img->width > IBL_MAX_CUBE_SIZE ||
             (size && img->width != size)))
            status = wrong_shape(t, f, img, expected);
        if (!status && !size)
            status = alloc_cubes(t, img->width, cubes);
        if (!status)
            cut_view(view, 0, 0, false, f, cubes);
        free_view(view);
    }
    return status;
}

/* Both crosses are those of cli/faces.h but for -Z, which in the upright one
 * hangs below -Y and stands on its head. */
static ibl_status read_cross(const taker *t, ibl_cube cubes[PARTS])
{
    ibl_image view[PARTS] = {0};
    ibl_status status = read_view(t, t->capture->file[0], view);
    const ibl_image *img = &view[COLOUR];
    const bool lying = img->width > img->height;
    const int n = lying ? img->width / 4 : img->width / 3;

    if (!status &&
        (n < 1 || n > IBL_MAX_CUBE_SIZE || img->width != n * (lying ? 4 : 3) ||
         img->height != n * (lying ? 3 : 4)))
        status = wrong_shape(t, 0, img, "a cross of 4 x 3 or 3 x 4 faces");
    if (!status)
        status = alloc_cubes(t, n, cubes);
    for (int f = 0; f < IBL_FACES && !status; f++) {
        const bool last = f == 5 && !lying;
        cut_view(view, n * (last ? 1 : ibl_cross_place[f][0]),
                 n * (last ? 3 : ibl_cross_place[f][1]), last, f, cubes);
    }
    free_view(view);
    return status;
}

/* Level 0 is the faces where it can be; else it has no texels. */
static ibl_status find_level0(const taker *t, ibl_cube *cube, ibl_cube *level0)
{
    const int size = t->options->specular_options.size;
    int level = 0;

    *level0 = (ibl_cube){0};
    while (level + 1 < cube->levels && cube->size >> level > size)
        level++;
    if (size << level != cube->size)
        return IBL_OK;
    *level0 = (ibl_cube){size, 1, ibl_cube_face(cube, level, 0)};
    return level ? ibl_cube_build_mips(t->ctx, cube) : IBL_OK;
}

static ibl_status bake_cube(const taker *t, ibl_cube *cube,
                            ibl_bake_result *made)
{
    const int width = ibl_latlong_width(cube->size);
    ibl_bake_options options = *t->options;
    ibl_image map = {0};
    ibl_cube level0;

    ibl_status status = ibl_image_alloc(t->ctx, width, width / 2, &map);
    if (!status)
        status = ibl_latlong_from_cube(t->ctx, cube, &map);
    if (!status)
        status = find_level0(t, cube, &level0);
    if (!status) {
        const ibl_environment env = {.image = &map};
        options.level0 = level0.data ? &level0 : NULL;
        status = ibl_bake_environment(t->ctx, &env, &options, made);
    }
    ibl_image_free(&map);
    return status;
}

/* Of the faces alone: a cross has transparent pixels beside them. */
static ibl_status check_cube_alpha(const taker *t, const ibl_cube *alpha,
                                   bool *needed)
{
    const size_t texels = ibl_cube_texels(alpha->size, 1);
    float least = 1, most = 0;

    for (size_t i = 0; i < texels; i++) {
        const float a = alpha->data[3 * i];
        least = a < least ? a : least;
        most = a > most ? a : most;
    }
    return check_alpha(t, least, most, needed);
}

static ibl_status bake_cubes(const taker *t)
{
    ibl_cube cubes[PARTS] = {0};
    bool needed[PARTS] = {true};
    ibl_status status = t->capture->kind == IBL_CAPTURE_FACES
                            ? read_faces(t, cubes)
                            : read_cross(t, cubes);

    if (!status)
        status = check_cube_alpha(t, &cubes[ALPHA], &needed[ALPHA]);
    for (int part = 0; part < PARTS; part++) {
        if (!status && needed[part])
            status = bake_cube(t, &cubes[part], &t->made[part]);
        ibl_cube_free(&cubes[part]);
    }
    return status;
}

ibl_status ibl_capture_bake(ibl_ctx *ctx, ibl_console *console, const char *set,
                            const ibl_capture *capture,
                            const ibl_read_options *read,
                            const ibl_bake_options *options,
                            ibl_bake_result made[PARTS])
{
    const taker t = {ctx, console, set, capture, read, options, made};

    ibl_console_progress(console, "decode", 0);
    return capture->kind == IBL_CAPTURE_EQUIRECT ? bake_equirect(&t)
                                                 : bake_cubes(&t);
}
