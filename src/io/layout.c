/* SPDX-License-Identifier: MIT */
#include "io/layout.h"

#include <string.h>

#include "core/context.h"
#include "image/image.h"

/* Columns and rows of a layout's faces, and the place of each face. */
typedef struct sheet {
    int columns, rows;
    signed char place[IBL_FACES][2];
    bool turned; /* -Z is turned by 180 degrees */
} sheet;

/* clang-format off */
#define FACES_DOWN {{0, 0}, {0, 1}, {0, 2}, {0, 3}, {0, 4}, {0, 5}}
static const sheet sheets[] = {
    [IBL_INPUT_CUBE] = {1, 6, FACES_DOWN, false},
    [IBL_INPUT_FACES] = {1, 6, FACES_DOWN, false},
    [IBL_INPUT_HCROSS] =
        {4, 3, {{2, 1}, {0, 1}, {1, 0}, {1, 2}, {1, 1}, {3, 1}}, false},
    [IBL_INPUT_VCROSS] =
        {3, 4, {{2, 1}, {0, 1}, {1, 0}, {1, 2}, {1, 1}, {1, 3}}, true},
    [IBL_INPUT_HSTRIP] =
        {6, 1, {{0, 0}, {1, 0}, {2, 0}, {3, 0}, {4, 0}, {5, 0}}, false},
    [IBL_INPUT_VSTRIP] = {1, 6, FACES_DOWN, false},
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

static void cut_face(const sheet *s, const ibl_image *img, int face,
                     ibl_cube *cube)
{
    const int n = cube->size;
    const bool turned = s->turned && face == IBL_FACES - 1;
    float *to = ibl_cube_face(cube, 0, face);

    for (int y = 0; y < n; y++) {
        const int row = n * s->place[face][1] + (turned ? n - 1 - y : y);
        const float *from = img->data + 3 * ((size_t)row * (size_t)img->width +
                                             (size_t)(n * s->place[face][0]));
        for (int x = 0; x < n; x++, to += 3)
            memcpy(to, from + 3 * (turned ? n - 1 - x : x), 3 * sizeof *to);
    }
}

static ibl_status unwrap_sheet(ibl_ctx *ctx, const sheet *s,
                               const ibl_image *img, ibl_image *map)
{
    const bool strip = s->columns == 1; /* stored as a cube's faces are */
    const int n = img->width / s->columns, width = ibl_latlong_width(n);
    ibl_cube cube = {.size = n, .levels = 1, .data = img->data};
    ibl_status status = strip ? IBL_OK : ibl_cube_alloc(ctx, n, 1, &cube);

    for (int f = 0; f < IBL_FACES && !strip && !status; f++)
        cut_face(s, img, f, &cube);
    if (!status)
        status = ibl_image_alloc(ctx, width, width / 2, map);
    if (!status)
        status = ibl_latlong_from_cube(ctx, &cube, map);
    if (!strip)
        ibl_cube_free(&cube);
    return status;
}

static ibl_status unwrap_octahedral(ibl_ctx *ctx, const ibl_image *img,
                                    ibl_image *map)
{
    const int width = ibl_latlong_width((img->width + 1) / 2);
    const ibl_status status = ibl_image_alloc(ctx, width, width / 2, map);

    return status ? status : ibl_latlong_from_octahedral(ctx, img, map);
}

ibl_status ibl_unwrap(ibl_ctx *ctx, ibl_input_layout layout,
                      const ibl_image *img, ibl_image *map)
{
    const ibl_status status =
        layout == IBL_INPUT_OCTAHEDRAL
            ? unwrap_octahedral(ctx, img, map)
            : unwrap_sheet(ctx, &sheets[layout], img, map);

    if (status)
        ibl_image_free(map);
    return status;
}
