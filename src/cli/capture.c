/* SPDX-License-Identifier: MIT */
#include "cli/capture.h"

#include <stdlib.h>
#include <string.h>

#include "cli/faces.h"

typedef struct taker {
    ibl_ctx *ctx;
    ibl_console *console;
    const char *set;
    const ibl_capture *capture;
    const ibl_read_options *read;
    ibl_bake_result *made, *alpha;
} taker;

/* ---- alpha ------------------------------------------------------------- */

/* Whether alpha is worth a bake; the least and the most of a capture. */
static ibl_status look_at_alpha(const taker *t, float least, float most,
                                bool *needed)
{
    *needed = least < IBL_CAPTURE_OPAQUE;
    if (most > 0)
        return IBL_OK;
    ibl_console_fail(t->console,
                     "%s: %s: alpha is 0 everywhere, so nothing would be seen "
                     "of this probe: save it with alpha 1 where something is, "
                     "or take --alpha ignore",
                     t->set, t->capture->place);
    return IBL_ERR_FORMAT;
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

/* ---- maps -------------------------------------------------------------- */

static ibl_status read_rows(void *cookie, int rows, float *rgb)
{
    return ibl_source_read(cookie, rows, rgb);
}

static ibl_status bake_source(const taker *t, ibl_source *source,
                              const ibl_bake_options *options)
{
    greys grey = {ibl_source_alpha(source), ibl_source_width(source)};
    ibl_environment rows = {.width = ibl_source_width(source),
                            .height = ibl_source_height(source),
                            .read = read_rows,
                            .cookie = source};
    ibl_status status = ibl_bake_environment(t->ctx, &rows, options, t->made);
    bool needed = false;

    if (!status && grey.alpha) {
        const ibl_read_report *r = ibl_source_report(source);
        status = look_at_alpha(t, r->alpha_least, r->alpha_most, &needed);
    }
    if (!status && needed) {
        rows.read = read_greys;
        rows.cookie = &grey;
        status = ibl_bake_environment(t->ctx, &rows, options, t->alpha);
    }
    return status;
}

static ibl_status bake_equirect(const taker *t, const ibl_bake_options *options)
{
    ibl_source *source = NULL;
    ibl_status status =
        ibl_source_open(t->ctx, t->capture->file[0], t->read, &source);

    if (!status)
        status = bake_source(t, source, options);
    ibl_source_close(source);
    return status;
}

/* ---- cubes ------------------------------------------------------------- */

/* What was read of a file, and of all files: level 0 of two cubes. */
typedef struct view {
    ibl_image colour, alpha; /* alpha in greys; empty: 1 */
} view;

typedef struct cubes {
    ibl_cube colour, alpha;
} cubes;

static void free_view(view *v)
{
    ibl_image_free(&v->colour);
    ibl_image_free(&v->alpha);
}

static ibl_status read_alpha(const taker *t, const ibl_source *source, view *v)
{
    greys grey = {ibl_source_alpha(source), ibl_source_width(source)};
    ibl_status status;

    if (!grey.alpha)
        return IBL_OK;
    status = ibl_image_alloc(t->ctx, grey.width, ibl_source_height(source),
                             &v->alpha);
    if (!status)
        status = read_greys(&grey, v->alpha.height, v->alpha.data);
    return status;
}

static ibl_status read_view(const taker *t, const char *file, view *v)
{
    ibl_read_options read = *t->read;
    ibl_source *source = NULL;

    read.any_aspect = 1;
    ibl_status status = ibl_source_open(t->ctx, file, &read, &source);
    if (status)
        return status;
    status = ibl_image_alloc(t->ctx, ibl_source_width(source),
                             ibl_source_height(source), &v->colour);
    if (!status)
        status = ibl_source_read(source, v->colour.height, v->colour.data);
    if (!status)
        status = read_alpha(t, source, v);
    ibl_source_close(source);
    return status;
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

/* Both, alpha all 1 for files that have none. */
static ibl_status alloc_cubes(const taker *t, int n, cubes *c)
{
    int levels = 1;

    while (n >> levels)
        levels++;
    ibl_status status = ibl_cube_alloc(t->ctx, n, levels, &c->colour);
    if (!status)
        status = ibl_cube_alloc(t->ctx, n, levels, &c->alpha);
    for (size_t i = 0; !status && i < 3 * ibl_cube_texels(n, 1); i++)
        c->alpha.data[i] = 1;
    return status;
}

/* One face of a picture whose upper left texel is (x, y); turned: by half a
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

static void cut_view(const view *v, int x, int y, bool turned, int face,
                     cubes *c)
{
    const int n = c->colour.size;

    cut_face(&v->colour, x, y, turned, n, ibl_cube_face(&c->colour, 0, face));
    if (v->alpha.data)
        cut_face(&v->alpha, x, y, turned, n, ibl_cube_face(&c->alpha, 0, face));
}

static ibl_status read_faces(const taker *t, cubes *c)
{
    ibl_status status = IBL_OK;

    for (int f = 0; f < IBL_FACES && !status; f++) {
        const int size = c->colour.size;
        view v = {0};
        char expected[64] = "a square";
        status = read_view(t, t->capture->file[f], &v);
        const ibl_image *img = &v.colour;
        if (!status && size)
            snprintf(expected, sizeof expected, "%d x %d as faces[0]", size,
                     size);
        if (!status &&
            (img->width != img->height || img->width > IBL_MAX_CUBE_SIZE ||
             (size && img->width != size)))
            status = wrong_shape(t, f, img, expected);
        if (!status && !size)
            status = alloc_cubes(t, img->width, c);
        if (!status)
            cut_view(&v, 0, 0, false, f, c);
        free_view(&v);
    }
    return status;
}

/* Both crosses are those of cli/faces.h but for -Z, which in the upright one
 * hangs below -Y and stands on its head. */
static ibl_status read_cross(const taker *t, cubes *c)
{
    view v = {0};
    ibl_status status = read_view(t, t->capture->file[0], &v);
    const ibl_image *img = &v.colour;
    const bool lying = img->width > img->height;
    const int n = lying ? img->width / 4 : img->width / 3;

    if (!status &&
        (n < 1 || n > IBL_MAX_CUBE_SIZE || img->width != n * (lying ? 4 : 3) ||
         img->height != n * (lying ? 3 : 4)))
        status = wrong_shape(t, 0, img, "a cross of 4 x 3 or 3 x 4 faces");
    if (!status)
        status = alloc_cubes(t, n, c);
    for (int f = 0; f < IBL_FACES && !status; f++) {
        const bool last = f == 5 && !lying;
        cut_view(&v, n * (last ? 1 : ibl_cross_place[f][0]),
                 n * (last ? 3 : ibl_cross_place[f][1]), last, f, c);
    }
    free_view(&v);
    return status;
}

/* Level 0 is the faces where it can be; else it has no texels. */
static ibl_status find_level0(const taker *t, ibl_cube *cube, int size,
                              ibl_cube *level0)
{
    int level = 0;

    *level0 = (ibl_cube){0};
    while (level + 1 < cube->levels && cube->size >> level > size)
        level++;
    if (size << level != cube->size)
        return IBL_OK;
    *level0 = (ibl_cube){size, 1, ibl_cube_face(cube, level, 0)};
    return level ? ibl_cube_build_mips(t->ctx, cube) : IBL_OK;
}

/* Colours or alpha. */
static ibl_status bake_cube(const taker *t, ibl_cube *cube,
                            const ibl_bake_options *options,
                            ibl_bake_result *made)
{
    const int width = ibl_latlong_width(cube->size);
    ibl_bake_options own = *options;
    ibl_image map = {0};
    ibl_cube level0;

    ibl_status status = ibl_image_alloc(t->ctx, width, width / 2, &map);
    if (!status)
        status = ibl_latlong_from_cube(t->ctx, cube, &map);
    if (!status)
        status = find_level0(t, cube, own.specular_options.size, &level0);
    if (!status) {
        const ibl_environment env = {.image = &map};
        own.level0 = level0.data ? &level0 : NULL;
        status = ibl_bake_environment(t->ctx, &env, &own, made);
    }
    ibl_image_free(&map);
    return status;
}

/* Of the faces alone: a cross has transparent pixels beside them. */
static ibl_status look_at_cube(const taker *t, const cubes *c, bool *needed)
{
    const size_t texels = ibl_cube_texels(c->alpha.size, 1);
    float least = 1, most = 0;

    for (size_t i = 0; i < texels; i++) {
        const float a = c->alpha.data[3 * i];
        least = a < least ? a : least;
        most = a > most ? a : most;
    }
    return look_at_alpha(t, least, most, needed);
}

static ibl_status bake_cubes(const taker *t, const ibl_bake_options *options)
{
    cubes c = {0};
    bool needed = false;
    ibl_status status = t->capture->kind == IBL_CAPTURE_FACES
                            ? read_faces(t, &c)
                            : read_cross(t, &c);

    if (!status)
        status = look_at_cube(t, &c, &needed);
    if (!status)
        status = bake_cube(t, &c.colour, options, t->made);
    if (!status && needed)
        status = bake_cube(t, &c.alpha, options, t->alpha);
    ibl_cube_free(&c.colour);
    ibl_cube_free(&c.alpha);
    return status;
}

ibl_status ibl_capture_bake(ibl_ctx *ctx, ibl_console *console, const char *set,
                            const ibl_capture *capture,
                            const ibl_read_options *read,
                            const ibl_bake_options *options,
                            ibl_bake_result *made, ibl_bake_result *alpha)
{
    const taker t = {ctx, console, set, capture, read, made, alpha};

    ibl_console_progress(console, "decode", 0);
    const ibl_status status = capture->kind == IBL_CAPTURE_EQUIRECT
                                  ? bake_equirect(&t, options)
                                  : bake_cubes(&t, options);
    if (status) {
        ibl_bake_result_free(made);
        ibl_bake_result_free(alpha);
    }
    return status;
}
