/* SPDX-License-Identifier: MIT */
#include "cli/capture.h"

#include <stdlib.h>
#include <string.h>

#include "cli/cube_map.h"
#include "cli/faces.h"

typedef struct taker {
    ibl_ctx *ctx;
    ibl_console *console;
    const char *set;
    const ibl_capture *capture;
    const ibl_read_options *read;
} taker;

static ibl_status read_rows(void *cookie, int rows, float *rgb)
{
    return ibl_source_read(cookie, rows, rgb);
}

static ibl_status bake_equirect(const taker *t, const ibl_bake_options *options,
                                ibl_bake_result *made)
{
    ibl_source *source = NULL;
    ibl_status status =
        ibl_source_open(t->ctx, t->capture->file[0], t->read, &source);

    if (status)
        return status;
    const ibl_environment rows = {.width = ibl_source_width(source),
                                  .height = ibl_source_height(source),
                                  .read = read_rows,
                                  .cookie = source};
    status = ibl_bake_environment(t->ctx, &rows, options, made);
    ibl_source_close(source);
    return status;
}

/* ---- cubes ------------------------------------------------------------- */

static ibl_status read_image(const taker *t, const char *file, ibl_image *img)
{
    ibl_read_options read = *t->read;

    read.any_aspect = 1;
    return ibl_image_read(t->ctx, file, &read, img, NULL);
}

static ibl_status wrong_shape(const taker *t, int i, const ibl_image *img,
                              const char *expected)
{
    char place[160];

    if (t->capture->count > 1)
        snprintf(place, sizeof place, "%s.faces[%d]", t->capture->place, i);
    else
        snprintf(place, sizeof place, "%s.cross", t->capture->place);
    ibl_console_fail(t->console, "%s: %s: %s: expected %s, found %d x %d",
                     t->set, place, t->capture->file[i], expected, img->width,
                     img->height);
    return IBL_ERR_FORMAT;
}

static ibl_status alloc_cube(const taker *t, int n, ibl_cube *cube)
{
    int levels = 1;

    while (n >> levels)
        levels++;
    return ibl_cube_alloc(t->ctx, n, levels, cube);
}

static ibl_status read_faces(const taker *t, ibl_cube *cube)
{
    ibl_status status = IBL_OK;

    for (int f = 0; f < IBL_FACES && !status; f++) {
        ibl_image img = {0};
        char expected[64] = "a square";
        status = read_image(t, t->capture->file[f], &img);
        if (!status && cube->size)
            snprintf(expected, sizeof expected, "%d x %d as faces[0]",
                     cube->size, cube->size);
        if (!status &&
            (img.width != img.height || img.width > IBL_MAX_CUBE_SIZE ||
             (cube->size && img.width != cube->size)))
            status = wrong_shape(t, f, &img, expected);
        if (!status && !cube->size)
            status = alloc_cube(t, img.width, cube);
        if (!status)
            memcpy(ibl_cube_face(cube, 0, f), img.data,
                   3 * sizeof(float) * (size_t)img.width * (size_t)img.width);
        ibl_image_free(&img);
    }
    return status;
}

/* One face of a cross whose upper left texel is (x, y); turned: by half a
 * turn. */
static void cut_face(const ibl_image *img, int x, int y, bool turned, int n,
                     float *face)
{
    for (int j = 0; j < n; j++)
        for (int i = 0; i < n; i++) {
            const int from_x = x + (turned ? n - 1 - i : i);
            const int from_y = y + (turned ? n - 1 - j : j);
            memcpy(face + 3 * ((size_t)j * (size_t)n + (size_t)i),
                   img->data + 3 * ((size_t)from_y * (size_t)img->width +
                                    (size_t)from_x),
                   3 * sizeof(float));
        }
}

/* Both crosses are those of cli/faces.h but for -Z, which in the upright one
 * hangs below -Y and stands on its head. */
static ibl_status read_cross(const taker *t, ibl_cube *cube)
{
    ibl_image img = {0};
    ibl_status status = read_image(t, t->capture->file[0], &img);
    const bool lying = img.width > img.height;
    const int n = lying ? img.width / 4 : img.width / 3;

    if (!status &&
        (n < 1 || n > IBL_MAX_CUBE_SIZE || img.width != n * (lying ? 4 : 3) ||
         img.height != n * (lying ? 3 : 4)))
        status = wrong_shape(t, 0, &img, "a cross of 4 x 3 or 3 x 4 faces");
    if (!status)
        status = alloc_cube(t, n, cube);
    for (int f = 0; f < IBL_FACES && !status; f++) {
        const bool last = f == 5 && !lying;
        cut_face(&img, n * (last ? 1 : ibl_cross_place[f][0]),
                 n * (last ? 3 : ibl_cross_place[f][1]), last, n,
                 ibl_cube_face(cube, 0, f));
    }
    ibl_image_free(&img);
    return status;
}

/* Level 0 from the faces where it can be. */
static ibl_status put_level0(const taker *t, ibl_cube *cube, ibl_cube *specular)
{
    int level = 0;

    while (level + 1 < cube->levels && cube->size >> level > specular->size)
        level++;
    if (specular->size << level != cube->size)
        return IBL_OK;
    const ibl_status status =
        level ? ibl_cube_build_mips(t->ctx, cube) : IBL_OK;
    if (!status)
        memcpy(specular->data, ibl_cube_face(cube, level, 0),
               3 * sizeof(float) * ibl_cube_texels(specular->size, 1));
    return status;
}

static ibl_status bake_cube(const taker *t, const ibl_bake_options *options,
                            ibl_bake_result *made)
{
    ibl_cube cube = {0};
    ibl_image map = {0};
    ibl_status status = t->capture->kind == IBL_CAPTURE_FACES
                            ? read_faces(t, &cube)
                            : read_cross(t, &cube);

    if (!status) {
        const int width = ibl_cube_map_width(cube.size);
        ibl_console_progress(t->console, "map", 0);
        status = ibl_image_alloc(t->ctx, width, width / 2, &map);
    }
    if (!status && !ibl_cube_map_fill(&cube, &map)) {
        ibl_console_fail(t->console, "%s: no memory for the map",
                         t->capture->file[0]);
        status = IBL_ERR_MEMORY;
    }
    if (!status) {
        const ibl_environment env = {
            .width = map.width, .height = map.height, .image = &map};
        status = ibl_bake_environment(t->ctx, &env, options, made);
    }
    if (!status && options->specular)
        status = put_level0(t, &cube, &made->specular);
    if (status)
        ibl_bake_result_free(made);
    ibl_image_free(&map);
    ibl_cube_free(&cube);
    return status;
}

ibl_status ibl_capture_bake(ibl_ctx *ctx, ibl_console *console, const char *set,
                            const ibl_capture *capture,
                            const ibl_read_options *read,
                            const ibl_bake_options *options,
                            ibl_bake_result *made)
{
    const taker t = {ctx, console, set, capture, read};

    ibl_console_progress(console, "decode", 0);
    return capture->kind == IBL_CAPTURE_EQUIRECT
               ? bake_equirect(&t, options, made)
               : bake_cube(&t, options, made);
}
