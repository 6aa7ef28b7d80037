/* SPDX-License-Identifier: MIT */
/* The memory that a bake takes: its largest blocks, added up before any is
 * taken. */
#include <math.h>

#include "cli/job.h"

/* The stack and buffers of a thread. */
#define THREAD_BYTES (0.25 * (1 << 20))
/* What the C library keeps of freed blocks, and small ones. */
#define KEPT_SHARE 0.1

/* Options that need the whole map in memory. */
static const char keep_map[] =
    "lights sun verify scene preview max-error rendered-error";

/* What becomes a file, beside its texels in floats: these as RGBA while light
 * is spread, turned or decoded again, and the file itself. */
static double file_bytes(const ibl_opts *o, int size, int levels)
{
    const bool again = o->verify || o->axes.mirror || o->axes.up || o->picture;
    double texels = 0;

    for (int l = 0; l < levels; l++)
        texels += 8 * pow(ibl_cube_edge(size, l), 2); /* 6 of a cube */
    return texels * (12 + 12 * again +
                     (double)ibl_pixel_bytes(o->texels.pixel) *
                         (1 + (o->zstd > 0) + 2 * o->verify));
}

double ibl_bake_bytes(const ibl_job *r, size_t reader, int width, int height)
{
    const ibl_bake_source *s = &r->from;
    const ibl_opts *o = r->opts;
    const double pixels = (double)width * (double)height;
    const bool chooses =
        !isnan(o->rendered_error) || o->lights == IBL_LIGHTS_AUTO;
    ibl_bake_options all = s->bake;
    double map = 0, files = 0;
    size_t bake = 0;

    all.specular = s->chain_count > 0;
    if (s->chain_count)
        all.specular_options = s->chains[0];
    all.more = s->chains + 1;
    all.more_count = s->chain_count > 1 ? s->chain_count - 1 : 0;
    if (ibl_bake_memory(s->ctx, width, height, &all, &bake))
        return 0;
    if (o->lights || o->verify || o->preview || chooses)
        map = pixels * (12 + 14 * (o->lights != 0) + 4 * chooses);
    for (int i = 0; i < r->count; i++) {
        const ibl_bake_options *set = &r->sets[i].opts->bake;
        ibl_specular_layout l;
        if (set->specular &&
            !ibl_specular_layout_of(&set->specular_options, &l))
            files = fmax(files, file_bytes(r->sets[i].opts, l.size, l.levels));
        if (set->skybox)
            files = fmax(files, file_bytes(r->sets[i].opts, set->skybox, 16));
    }
    return IBL_PROGRAM_BYTES + THREAD_BYTES * ibl_ctx_threads(s->ctx) +
           (1 + KEPT_SHARE) * (map + (double)reader + (double)bake + files);
}

bool ibl_bake_fits(const ibl_job *r, size_t reader, int width, int height)
{
    const ibl_opts *o = r->opts;
    ibl_console *console = (ibl_console *)&r->console;
    const double mib = 1 << 20, most = (double)ibl_memory_most(&o->common);
    const double need = ibl_bake_bytes(r, reader, width, height);
    const char *keeps = ibl_given_of(&o->given, keep_map);

    ibl_console_info(console, "plans %.0f MiB of memory", need / mib);
    if (!(need > 0))
        return false;
    return most <= 0 || need <= most ||
           ibl_console_fail(console,
                            "%s: takes %.0f MiB of memory, more than the %.0f "
                            "of --max-memory: ask for a smaller --size or "
                            "--skybox, or scale the map down%s%s",
                            o->input, ceil(need / mib), floor(most / mib),
                            keeps ? ", or leave out --" : "",
                            keeps ? keeps : "");
}
