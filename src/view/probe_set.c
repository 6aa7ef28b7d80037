/* SPDX-License-Identifier: MIT */
#include "view/room.h"

#include <math.h>
#include <stdlib.h>

#include "common/path.h"
#include "common/signals.h"
#include "view/gl.h"
#include "view/message.h"
#include "view/vector.h"

enum {
    SH_EDGE = 16 /* of cubes made from harmonics */
};

/* Cubes of the harmonics. Sums overshoot: a little below 0 in the dark, alpha
 * above 1. A layer without a probe stays black. */
static GLuint make_light(const ibl_probe_index *x, const char *name)
{
    const int texels = IBL_FACES * SH_EDGE * SH_EDGE;
    const int count = texels * x->specular.layers;
    float *to = ibl_need(malloc(4 * sizeof *to * (size_t)count));
    const ibl_texture light = {.pixel = IBL_PIXEL_RGBA32F,
                               .width = SH_EDGE,
                               .height = SH_EDGE,
                               .levels = 1,
                               .layers = x->specular.layers,
                               .faces = IBL_FACES,
                               .data = (unsigned char *)to};

    for (int i = 0; i < count; i++) {
        const int face = i % texels / (SH_EDGE * SH_EDGE);
        double d[3], sum[4];
        ibl_cube_direction(SH_EDGE, face, i % SH_EDGE, i / SH_EDGE % SH_EDGE,
                           d);
        view_harmonics_sum(x->sh[i / texels], IBL_PROBE_SH, 4, d, sum);
        for (int k = 0; k < 4; k++)
            to[4 * i + k] = (float)fmin(fmax(sum[k], 0), k < 3 ? INFINITY : 1);
    }
    const GLuint cubes = view_upload(&light, true, name);
    free(to);
    return cubes;
}

static GLuint load_array(ibl_ctx *ctx, const char *index,
                         const ibl_probe_file *file)
{
    char *path = ibl_need(ibl_path_beside(index, file->name));
    ibl_texture tex = {0};
    GLuint cubes = 0;

    if (ibl_texture_read(ctx, path, &tex, NULL))
        ;
    else if (tex.faces != IBL_FACES || tex.layers != file->layers ||
             tex.width != file->size || tex.levels != file->levels ||
             tex.pixel != file->pixel)
        view_fail("%s: is not as its index says, %d cubes of %d texels with "
                  "levels: %d, %s: bake the probes again",
                  path, file->layers, file->size, file->levels,
                  ibl_pixel_name(file->pixel));
    else if (!ibl_texture_unblock(ctx, &tex))
        cubes = view_upload(&tex, true, path);
    ibl_texture_free(&tex);
    free(path);
    return cubes;
}

view_probe_set *view_probe_set_load(ibl_ctx *ctx, const char *index)
{
    view_probe_set *set = ibl_need(calloc(1, sizeof *set));
    const ibl_probe_index *x = &set->index;

    if (!ibl_probe_index_read(ctx, index, &set->index)) {
        set->maps = (view_probe_maps){
            .count = x->count,
            .probe = x->probe,
            .holes = x->holes,
            .lod = {(float)x->lod_scale, (float)x->lod_offset,
                    (float)(x->specular.levels - 1), (float)x->mapping},
            .irradiance_scale = (float)x->irradiance_scale,
            .specular = load_array(ctx, index, &x->specular)};
        if (set->maps.specular)
            set->maps.irradiance = x->sh
                                       ? make_light(x, index)
                                       : load_array(ctx, index, &x->irradiance);
        gl.BindTexture(GL_TEXTURE_CUBE_MAP_ARRAY, 0);
    }
    if (set->maps.irradiance)
        return set;
    view_probe_set_free(set);
    return NULL;
}

void view_probe_set_free(view_probe_set *set)
{
    if (!set)
        return;
    view_probe_maps_free(&set->maps);
    ibl_probe_index_free(&set->index);
    free(set);
}
