/* SPDX-License-Identifier: MIT */
/* Textures as environments: level 0 of KTX2, KTX, DDS and Babylon's .env. */
#include <stdio.h>
#include <string.h>

#include "core/context.h"
#include "io/bridge.h"
#include "io/colour_space.h"
#include "io/container.h"
#include "io/layout.h"
#include "io/rows.h"

static bool is_env(const unsigned char *bytes, size_t size)
{
    return size >= 8 && !memcmp(bytes, "\x86\x16\x87\x96\xF6\xD6\x96\x36", 8);
}

bool ibl_texture_is(const unsigned char *bytes, size_t size)
{
    return ibl_container_of(bytes, size) != IBL_CONTAINER_COUNT ||
           is_env(bytes, size);
}

/* The index of a key's value in names; 0, the first, without the key; -1: it is
 * none of them. */
static int find_value(const ibl_texture *tex, const char *key,
                      const char *const *names, int count)
{
    const char *value = ibl_texture_get(tex, key);
    int i = 0;

    while (value && i < count && strcmp(value, names[i]))
        i++;
    return i < count ? i : -1;
}

/* Turns the faces of a cube that iblbake wrote in other axes back. */
static ibl_status turn_back(const ibl_input *in, const ibl_texture *tex,
                            ibl_image *strip)
{
    static const char *const mirrors[] = {"none", "x", "z", "xz"};
    static const char *const ups[] = {"y", "z"};
    const int mirror = find_value(tex, "iblbake.mirror", mirrors, 4);
    const int up = find_value(tex, "iblbake.up", ups, 2);
    const ibl_cube from = {
        .size = strip->width, .levels = 1, .data = strip->data};
    ibl_cube turned = {0};

    if (tex->faces != IBL_FACES || (!mirror && !up))
        return IBL_OK;
    if (mirror < 0 || up < 0)
        return ibl_unsupported(in, "is in axes that are not known, by its keys "
                                   "iblbake.mirror and iblbake.up");
    const ibl_axes axes = {.mirror = (ibl_mirror)mirror, .up = (ibl_up)up};
    const ibl_status status =
        ibl_cube_turn_axes(in->ctx, &from, axes, 1, &turned);
    if (!status) {
        ibl_image_free(strip);
        *strip = (ibl_image){turned.size, IBL_FACES * turned.size, turned.data};
    }
    return status;
}

/* What iblbake baked would be blurred once more. */
static ibl_status check_baked(const ibl_input *in, const ibl_texture *tex,
                              const ibl_read_options *opts)
{
    const char *content = ibl_texture_get(tex, "iblbake.content");

    if (!content || (strcmp(content, "specular") != 0 &&
                     strcmp(content, "irradiance") != 0))
        return IBL_OK;
    if (opts->refuse_prefiltered)
        return ibl_bad_file(in,
                            "is a baked map (%s), not an environment: bake "
                            "the map that it was made of, or add --prefiltered",
                            content);
    ibl_warn(in->ctx,
             "%s: is a baked map (%s), whose level 0 is taken for the "
             "environment",
             in->name, content);
    return IBL_OK;
}

/* Level 0 as an image; the faces of a cube are below one another. Primaries are
 * by our keys, since KTX and DDS say nothing else, or by KTX2's descriptor. */
static ibl_status make_rows(const ibl_input *in, const ibl_texture *tex,
                            const ibl_read_options *opts, ibl_rows **rows)
{
    static const char *const names[] = {"", "rec709", "acescg", "rec2020"};
    const int key = find_value(tex, "iblbake.primaries", names, 4);
    const double *xy = key > 0 ? ibl_primaries_xy((ibl_primaries)key)
                               : ibl_khronos_xy(tex->primaries);
    const int height = tex->height * tex->faces;
    const size_t texels = (size_t)tex->width * (size_t)height;
    ibl_image img = {0};

    if (tex->layers > 1 || ibl_pixel_channels(tex->pixel) != 3)
        return ibl_bad_file(in,
                            "is a texture of %d layers and %d channels: an "
                            "environment has one layer of 3",
                            tex->layers, ibl_pixel_channels(tex->pixel));
    ibl_status status =
        tex->faces == 1 ? ibl_map_check_size(in, opts, tex->width, tex->height)
                        : IBL_OK;
    if (!status)
        status = ibl_map_alloc(in, tex->width, height, &img);
    if (!status)
        status = ibl_texels_decode(in->ctx, tex, 0, img.data);
    if (!status)
        status = turn_back(in, tex, &img);
    if (status)
        ibl_image_free(&img);
    else
        status = ibl_rows_of_image(in->ctx, &img, NULL, rows);
    if (status)
        return status;
    ibl_rows *r = *rows;
    r->report.has_primaries = xy != NULL;
    if (xy)
        memcpy(r->report.primaries, xy, sizeof r->report.primaries);
    if (!opts->alpha || !ibl_pixel_has_alpha(tex->pixel))
        return IBL_OK;
    r->straight = !tex->premultiplied;
    status = ibl_rows_alloc_alpha(r);
    for (size_t i = 0; i < texels && !status; i++)
        r->alpha[i] = ibl_pixel_get_alpha(tex->pixel, tex->data, i);
    return status;
}

ibl_status ibl_texture_open(ibl_input *in, const ibl_read_options *opts,
                            ibl_rows **rows)
{
    ibl_read_options own = *opts;
    ibl_texture tex = {0};
    ibl_status status = ibl_input_load(in);

    if (status)
        return status;
    const bool env = is_env(in->bytes, in->size);
    const ibl_container container = ibl_container_of(in->bytes, in->size);
    if (env && !opts->env)
        return ibl_unsupported(in, "a Babylon .env, which is not read here");
    if (!memcmp(in->bytes, "DDS ", 4)) { /* of other pixels: by the bridge */
        ibl_input silent = *in;
        silent.ctx = NULL;
        if (ibl_dds_decode(&silent, &tex) == IBL_ERR_UNSUPPORTED)
            return ibl_other_image_open(in, opts, rows);
        ibl_texture_free(&tex);
    }
    status = env ? opts->env(in->ctx, in->name, in->bytes, in->size, &tex)
                 : ibl_texture_decode(in->ctx, in->name, in->bytes, in->size,
                                      &tex, NULL);
    /* the layout of a flat texture that iblbake wrote is in its keys */
    const char *layout = ibl_texture_get(&tex, "iblbake.layout");
    if (!opts->layout && layout && !strcmp(layout, "octahedral"))
        own.layout = IBL_INPUT_OCTAHEDRAL;
    if (!status)
        status = check_baked(in, &tex, opts);
    if (!status)
        status = make_rows(in, &tex, &own, rows);
    if (!status) {
        ibl_read_report *r = &(*rows)->report;
        snprintf(r->format, sizeof r->format, "%s, %s",
                 env                               ? "Babylon .env"
                 : container == IBL_CONTAINER_KTX2 ? "KTX2"
                 : container == IBL_CONTAINER_KTX  ? "KTX"
                                                   : "DDS",
                 ibl_pixel_name(tex.pixel));
        r->layout = tex.faces == IBL_FACES
                        ? IBL_INPUT_CUBE
                        : ibl_input_layout_of(&own, tex.width, tex.height);
    }
    ibl_texture_free(&tex);
    return status;
}
