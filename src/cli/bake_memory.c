/* SPDX-License-Identifier: MIT */
/* The memory that a bake takes: a bound by arithmetic, before it starts. */
#include <math.h>
#include <stdio.h>

#include "cli/bake_record.h"

/* The stack and buffers of a thread. */
#define THREAD_BYTES (0.25 * (1 << 20))
/* Freed blocks wait for others of their size: these of the bake while files are
 * made, and a share that the C library keeps. */
#define KEPT_BYTES (32.0 * (1 << 20))
#define KEPT_SHARE 0.1

/* Bytes by what asks for them, and the option that lowers each. */
typedef struct needs {
    double map;    /* if it stays in memory */
    double reader; /* of the file */
    double bake;
    double files; /* beside the results */
} needs;

static double cube_texels(const ibl_opts *o, int size, int levels)
{
    const bool cube = o->bake.skybox_projection == IBL_PROJECTION_CUBE;
    double texels = 0;

    for (int l = 0; l < levels; l++)
        texels += pow(ibl_cube_edge(size, l), 2);
    return texels * (cube ? 6 : 8);
}

/* What becomes a file: its texels, what is spread of level 0, what turned cubes
 * and --verify have, and what is compressed. */
static double file_bytes(const ibl_opts *o, int size, int levels)
{
    const int block = ibl_pixel_block(o->texels.pixel);
    const double texels = cube_texels(o, size, levels);
    const double data =
        texels * (double)ibl_pixel_bytes(o->texels.pixel) / (block * block);
    const bool spreads = o->texels.pixel != IBL_PIXEL_RGBA32F ||
                         o->texels.largest > 0 || o->engine;
    const bool turns = o->axes.mirror || o->axes.up;

    return data * (1 + (o->zstd > 0) + 2 * (o->verify != 0)) +
           (spreads ? 16 * cube_texels(o, size, 1) : 0) +
           (o->picture ? 48 * pow(size, 2) * (o->layout ? 8 : 1) : 0) +
           12 * texels * ((o->verify != 0) + turns);
}

static double files_of(const ibl_bake *b)
{
    const ibl_opts *o = b->opts;
    ibl_specular_layout layout = {0};
    double specular = 0, skybox = 0;

    if (o->bake.specular &&
        !ibl_specular_layout_of(&o->bake.specular_options, &layout))
        specular = file_bytes(o, layout.size, layout.levels);
    if (o->bake.skybox)
        skybox = file_bytes(o, o->bake.skybox, 16);
    /* The one may still be written while the other is made. */
    return o->bake.skybox && specular > 0 ? specular + skybox
                                          : fmax(specular, skybox);
}

/* What the results of all chains take. */
static double results_of(const ibl_bake_source *s)
{
    ibl_specular_layout layout;
    double bytes = 16 * cube_texels(s->opts, s->bake.skybox, 1);

    for (int i = 0; i < s->chain_count; i++)
        if (!ibl_specular_layout_of(&s->chains[i], &layout))
            bytes += 12 * cube_texels(s->opts, layout.size, layout.levels);
    return bytes;
}

static bool keeps_map(const ibl_opts *o)
{
    return o->lights || o->verify || o->preview || !isnan(o->rendered_error);
}

/* The option that lowers the largest need. */
static const char *advice(const ibl_opts *o, const needs *n)
{
    static const char *const keeps[] = {"lights",        "sun",     "verify",
                                        "scene",         "preview", "max-error",
                                        "rendered-error"};
    static _Thread_local char text[160];
    const double bake = fmax(n->bake, n->files);
    size_t used = 0;

    if (n->map > bake && n->map > n->reader) {
        for (size_t i = 0; i < sizeof keeps / sizeof *keeps; i++)
            if (ibl_is_given(&o->given, keeps[i]))
                used +=
                    (size_t)snprintf(text + used, sizeof text - used, "%s--%s",
                                     used ? ", " : "leave out ", keeps[i]);
        snprintf(text + used, sizeof text - used,
                 ", which need the map in memory, or scale the map down");
        return text;
    }
    if (n->reader > bake)
        return "convert the file to .hdr or to EXR in ZIP, which are read row "
               "by row, or scale it down";
    if (o->bake.skybox > o->bake.specular_options.size)
        return "ask for a smaller --skybox";
    return o->bake.specular ? "ask for a smaller --size, or scale the map down"
                            : "scale the map down";
}

size_t ibl_bake_bytes(const ibl_map_bake *r, ibl_ctx *ctx, size_t reader,
                      int width, int height, const char **lower)
{
    const ibl_bake_source *s = &r->from;
    const double pixels = (double)width * (double)height;
    const bool chooses =
        !isnan(s->opts->rendered_error) || s->opts->lights == IBL_LIGHTS_AUTO;
    ibl_bake_options all = s->bake;
    needs n = {.reader = (double)reader};
    size_t bake = 0;

    all.specular = s->chain_count > 0;
    if (s->chain_count)
        all.specular_options = s->chains[0];
    all.more = s->chains + 1;
    all.more_count = s->chain_count > 1 ? s->chain_count - 1 : 0;
    *lower = "";
    if (ibl_bake_memory(ctx, width, height, &all, &bake))
        return 0;
    n.bake = (double)bake;
    if (keeps_map(s->opts)) /* and what was taken out of it, or is left */
        n.map =
            pixels * (!s->opts->lights                                ? 12
                      : s->bake.skybox || s->opts->preview || chooses ? 26
                                                                      : 14) +
            (chooses ? 4 * pixels : 0); /* the map's halves */
    for (int i = 0; i < r->count; i++)
        n.files = fmax(n.files, files_of(&r->sets[i]));
    *lower = advice(s->opts, &n);
    const double results = results_of(s);
    const double files =
        results + n.files + fmin(fmax(n.bake - results, 0), KEPT_BYTES);
    const double work = n.map + fmax(n.reader + n.bake, files);
    return (size_t)(IBL_PROGRAM_BYTES + THREAD_BYTES * ibl_ctx_threads(ctx) +
                    (1 + KEPT_SHARE) * work);
}

bool ibl_bake_fits(const ibl_map_bake *r, size_t reader, int width, int height)
{
    const ibl_opts *o = r->opts;
    const size_t most = ibl_memory_most(&o->common);
    const char *lower;
    const size_t need =
        ibl_bake_bytes(r, r->from.ctx, reader, width, height, &lower);

    ibl_console_info((ibl_console *)&r->console, "plans %.0f MiB of memory",
                     (double)need / (1 << 20));
    if (!need)
        return false;
    return !most || need <= most ||
           ibl_console_fail((ibl_console *)&r->console,
                            "%s: takes %.0f MiB of memory, more than the %.0f "
                            "of --max-memory: %s",
                            o->input, ceil((double)need / (1 << 20)),
                            floor((double)most / (1 << 20)), lower);
}
