/* SPDX-License-Identifier: MIT */
/* Reads and bakes the capture of a probe. */
#include <math.h>

#include "cli/probes.h"

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

/* Bakes rows; level 0 is that of faces with its size, if there is one. */
static bool bake(const ibl_probes_bake *p, const ibl_environment *rows,
                 ibl_cube *faces, ibl_bake_result *made)
{
    ibl_bake_options options = p->set.bake.options;
    const int size = options.specular_options.size;
    ibl_cube level0 = {.size = size, .levels = 1};
    int level = 0;

    while (level + 1 < faces->levels && faces->size >> level > size)
        level++;
    if (faces->data && size << level == faces->size) {
        if (level && ibl_cube_build_mips(p->ctx, faces))
            return false;
        level0.data = ibl_cube_face(faces, level, 0);
        options.level0 = &level0;
    }
    return !ibl_bake_environment(p->ctx, rows, &options, made);
}

/* Bakes the alpha of a source that was read, if some of it is not 1. */
static bool bake_alpha(const ibl_probes_bake *p, const ibl_set_entry *e,
                       const ibl_source *source, ibl_cube *faces,
                       ibl_bake_result *made)
{
    const int width = ibl_source_width(source);
    const int height = ibl_source_height(source);
    greys grey = {ibl_source_alpha(source), width};
    const ibl_environment rows = {
        .width = width, .height = height, .read = read_greys, .cookie = &grey};
    const size_t pixels = (size_t)width * (size_t)height;
    float least = 1, most = 0;

    for (size_t i = 0; i < pixels && grey.alpha; i++) {
        least = fminf(least, grey.alpha[i]);
        most = fmaxf(most, grey.alpha[i]);
    }
    if (least >= IBL_CAPTURE_OPAQUE)
        return true;
    return most > 0
               ? bake(p, &rows, faces, made)
               : ibl_console_fail(
                     p->console,
                     "%s: %s: alpha is 0 everywhere, so nothing would be seen "
                     "of this probe: save it with alpha 1 where something is, "
                     "or take --alpha ignore",
                     p->input, e->place);
}

/* Whether the arrays of all layers, and the bake of a map of width x height
 * pixels, which is in memory with its alpha and its faces, fit in
 * --max-memory. */
static bool fits(const ibl_probes_bake *p, int width, int height)
{
    const ibl_set_bake *b = &p->set.bake;
    const ibl_pixel pixel = b->texels.pixel;
    const int size = p->layout.size, block = ibl_pixel_block(pixel);
    const double most = (double)ibl_memory_most(&p->opts->common);
    const double level0 = (double)ibl_cube_texels(size, 1);
    const double texels = (double)ibl_cube_texels(size, p->layout.levels);
    const int edge = b->options.irradiance_options.size;
    const double arrays = (texels + (double)ibl_cube_texels(edge, 1)) *
                          (double)ibl_pixel_bytes(pixel) / (block * block) *
                          p->set.layers * (b->zstd ? 2 : 1);
    size_t bake;

    if (ibl_bake_memory(p->ctx, width, height, &b->options, &bake))
        return false;
    const double need = IBL_PROGRAM_BYTES +
                        1.1 * (arrays + (double)bake + 28.0 * width * height +
                               16 * level0 + 12 * texels);
    return most <= 0 || need <= most ||
           ibl_console_fail(p->console,
                            "%s: takes %.0f MiB of memory, more than the %.0f "
                            "of --max-memory: ask for a smaller --size, or "
                            "make two sets of it",
                            p->input, ceil(need / (1 << 20)),
                            floor(most / (1 << 20)));
}

bool ibl_capture_bake(const ibl_probes_bake *p, int layer,
                      ibl_bake_result *colour, ibl_bake_result *alpha)
{
    const ibl_set_entry *e = &p->set.entry[layer];
    ibl_read_options read = p->opts->common.read;
    ibl_source *source = NULL;
    ibl_cube faces[2] = {0}; /* of colours and alpha */
    ibl_environment rows;

    read.alpha = ibl_probes_alpha(&p->set, layer);
    read.faces = faces;
    if (e->cube) {
        read.layout = IBL_INPUT_AUTO;
        read.any_aspect = 0; /* with which no cross is found */
    }
    ibl_console_progress(p->console, "decode", 0);
    bool ok = !ibl_source_open(p->ctx, e->capture, &read, &source);
    if (ok)
        rows = ibl_source_environment(source);
    ok = ok && fits(p, rows.width, rows.height) &&
         bake(p, &rows, &faces[0], colour) &&
         bake_alpha(p, e, source, &faces[1], alpha);
    ibl_cube_free(&faces[0]);
    ibl_cube_free(&faces[1]);
    ibl_source_close(source);
    return ok;
}
