/* SPDX-License-Identifier: MIT */
#include "io/layout.h"

#include <string.h>

#include "core/alloc.h"
#include "core/context.h"
#include "image/cube.h"
#include "image/image.h"

/* Columns and rows of a layout's faces, and the place of each face. */
typedef struct sheet {
    int columns, rows;
    signed char place[IBL_FACES][2];
    unsigned char last; /* the code of -Z */
} sheet;

/* clang-format off */
#define FACES_DOWN {{0, 0}, {0, 1}, {0, 2}, {0, 3}, {0, 4}, {0, 5}}
enum {
    NZ = 5, NZ_180 = 2 * IBL_FACES + NZ
};
static const sheet sheets[] = {
    [IBL_INPUT_CUBE] = {1, 6, FACES_DOWN, NZ},
    [IBL_INPUT_FACES] = {1, 6, FACES_DOWN, NZ},
    [IBL_INPUT_HCROSS] =
        {4, 3, {{2, 1}, {0, 1}, {1, 0}, {1, 2}, {1, 1}, {3, 1}}, NZ},
    [IBL_INPUT_VCROSS] =
        {3, 4, {{2, 1}, {0, 1}, {1, 0}, {1, 2}, {1, 1}, {1, 3}}, NZ_180},
    [IBL_INPUT_HSTRIP] =
        {6, 1, {{0, 0}, {1, 0}, {2, 0}, {3, 0}, {4, 0}, {5, 0}}, NZ},
    [IBL_INPUT_VSTRIP] = {1, 6, FACES_DOWN, NZ},
};
/* clang-format on */

const char *ibl_input_layout_name(ibl_input_layout layout)
{
    static const char *const names[] = {"auto",   "equirect", "cube",
                                        "faces",  "hcross",   "vcross",
                                        "hstrip", "vstrip",   "octahedral"};
    return names[layout];
}

/* ---- by shape ---------------------------------------------------------- */

static bool has_shape(ibl_input_layout layout, long long width,
                      long long height)
{
    const sheet *s = &sheets[layout];

    if (layout == IBL_INPUT_EQUIRECT)
        return true;
    if (layout == IBL_INPUT_OCTAHEDRAL)
        return width == height;
    return width % s->columns == 0 && width / s->columns * s->rows == height;
}

ibl_input_layout ibl_input_layout_of(const ibl_read_options *opts,
                                     long long width, long long height)
{
    if (opts->layout)
        return has_shape(opts->layout, width, height) ? opts->layout
                                                      : IBL_INPUT_AUTO;
    if (width == 2 * height || opts->any_aspect)
        return IBL_INPUT_EQUIRECT;
    for (int l = IBL_INPUT_HCROSS; l <= IBL_INPUT_VSTRIP; l++)
        if (has_shape((ibl_input_layout)l, width, height))
            return (ibl_input_layout)l;
    return IBL_INPUT_AUTO;
}

/* ---- faces ------------------------------------------------------------- */

ibl_status ibl_faces_from_edges(ibl_ctx *ctx, ibl_image *strip)
{
    const int n = strip->width;
    const size_t row = 3 * (size_t)n;
    float *line = ibl_alloc_array(row, sizeof *line);

    if (!line)
        return ibl_no_memory(ctx, "a row of a cube");
    for (int i = 0; i < 2 * IBL_FACES * n && n > 1; i++) {
        /* rows of all faces, then columns of each */
        const bool is_row = i < IBL_FACES * n;
        const size_t k = (size_t)(i - (is_row ? 0 : IBL_FACES * n));
        const size_t step = is_row ? 3 : row;
        float *to = strip->data + (is_row ? k * row
                                          : k / (size_t)n * row * (size_t)n +
                                                3 * (k % (size_t)n));
        for (size_t x = 0; x < row; x++)
            line[x] = to[x / 3 * step + x % 3];
        for (int x = 0; x < n; x++) {
            const double at = (x + .5) * (n - 1) / n;
            const int from = (int)at;
            for (int c = 0; c < 3; c++) {
                const float *p = line + 3 * from + c;
                to[(size_t)x * step + (size_t)c] =
                    (float)((double)p[0] + (at - from) * (double)(p[3] - p[0]));
            }
        }
    }
    ibl_free(line);
    return IBL_OK;
}

/* A strip is stored as a cube's faces are, so it is one if none moves. */
static ibl_status unwrap_sheet(ibl_ctx *ctx, const char *name, const sheet *s,
                               const unsigned char given[IBL_FACES],
                               const ibl_image *img, ibl_cube *faces,
                               ibl_image *map)
{
    const unsigned char usual[IBL_FACES] = {0, 1, 2, 3, 4, s->last};
    const unsigned char *order = given[0] + given[1] ? given : usual;
    const int n = img->width / s->columns, width = ibl_latlong_width(n);
    const size_t row = 3 * (size_t)img->width;
    const bool strip =
        !faces && s->columns == 1 && !memcmp(order, usual, sizeof usual);
    const int levels = faces ? ibl_cube_most_levels(n) : 1;
    ibl_cube cube = {.size = n, .levels = 1, .data = img->data};
    ibl_status status = strip ? IBL_OK : ibl_cube_alloc(ctx, n, levels, &cube);

    for (int f = 0; f < IBL_FACES && !strip && !status; f++)
        ibl_face_put(img->data + row * (size_t)(n * s->place[f][1]) +
                         3 * (size_t)(n * s->place[f][0]),
                     row, order[f], &cube);
    if (!status && name)
        status = ibl_faces_check(ctx, name, &cube, order);
    if (!status)
        status = ibl_image_alloc(ctx, width, width / 2, map);
    if (!status)
        status = ibl_latlong_from_cube(ctx, &cube, map);
    if (faces)
        *faces = cube;
    else if (!strip)
        ibl_cube_free(&cube);
    return status;
}

ibl_status ibl_unwrap(ibl_ctx *ctx, const char *name, ibl_input_layout layout,
                      const unsigned char order[IBL_FACES],
                      const ibl_image *img, ibl_cube *faces, ibl_image *map)
{
    ibl_status status;

    if (layout == IBL_INPUT_OCTAHEDRAL) {
        const int width = ibl_latlong_width((img->width + 1) / 2);
        status = ibl_image_alloc(ctx, width, width / 2, map);
        if (!status)
            status = ibl_latlong_from_octahedral(ctx, img, map);
    } else {
        status =
            unwrap_sheet(ctx, name, &sheets[layout], order, img, faces, map);
    }
    if (status)
        ibl_image_free(map);
    return status;
}
