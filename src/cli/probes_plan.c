/* SPDX-License-Identifier: MIT */
/* What of a set has to be baked: what has changed since the last time. */
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>

#include "cli/probes.h"
#include "common/path.h"
#include "common/text.h"

/* ---- one run at a time ------------------------------------------------- */

bool ibl_probes_hold(ibl_probes_bake *p)
{
    const char *directory = p->opts->output;

    p->held = open(directory, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (p->held < 0)
        return errno != ENOENT;
    /* File systems without locks say so by other errors, and have none. */
    if (flock(p->held, LOCK_EX | LOCK_NB) && errno == EWOULDBLOCK) {
        ibl_console_warn(p->console,
                         "%s: another run is at work there: waiting for it",
                         directory);
        while (flock(p->held, LOCK_EX) && errno == EINTR)
            continue;
    }
    return true;
}

/* ---- hashes ------------------------------------------------------------ */

ibl_alpha ibl_probes_alpha(const ibl_probe_set *set, int layer)
{
    return layer < set->count ? (ibl_alpha)set->bake.alpha : IBL_ALPHA_IGNORE;
}

/* What the texels of a layer depend on besides the files. */
static void describe(const ibl_probes_bake *p, ibl_alpha alpha, FILE *to)
{
    const ibl_set_bake *b = &p->set.bake;
    const ibl_specular_options *s = &p->options.specular_options;
    const ibl_read_options *r = &p->opts->common.read;

    fprintf(to,
            "iblbake %s %s %s\nsize %d levels %d mapping %d method %d "
            "samples %d tolerance %.17g pixel %d overflow %d irradiance %d\n"
            "part %d strict %d any_aspect %d alpha %s layer %s\n",
            IBL_VERSION, IBL_REVISION, ibl_isa_name(p->isa), s->size, s->levels,
            (int)s->mapping, (int)s->method, s->samples, s->tolerance, b->pixel,
            b->overflow, b->irradiance, r->part, r->strict, r->any_aspect,
            ibl_alpha_name(alpha), r->layer ? r->layer : "");
}

static ibl_status hash_capture(const ibl_probes_bake *p, const ibl_capture *c,
                               ibl_alpha alpha, char hash[IBL_HASH_SIZE])
{
    ibl_memory_file file;
    FILE *to = ibl_memory_open(&file);
    ibl_status status = IBL_OK;

    if (!to)
        return ibl_probes_no_memory(p);
    describe(p, alpha, to);
    fputs(ibl_capture_name(c->kind), to);
    for (int i = 0; i < c->count && !status; i++) {
        char one[IBL_HASH_SIZE];
        status = ibl_probes_check_input(p, c->file[i]);
        if (!status && !ibl_hash_file(c->file[i], one)) {
            char element[16] = "";
            if (c->count > 1)
                snprintf(element, sizeof element, "[%d]", i);
            ibl_console_fail(p->console,
                             "%s: %s.%s%s: expected a file that can be read, "
                             "found %s: %s",
                             p->opts->input, c->place,
                             ibl_capture_name(c->kind), element, c->file[i],
                             errno == EINVAL ? "no regular file"
                                             : strerror(errno));
            status = IBL_ERR_IO;
        }
        if (!status)
            fprintf(to, " %s", one);
    }
    char *text = ibl_memory_close(to, &file);
    if (!text && !status)
        status = ibl_probes_no_memory(p);
    if (!status)
        ibl_hash_bytes(text, file.size, hash);
    free(text);
    return status;
}

ibl_status ibl_probes_hash_inputs(ibl_probes_bake *p)
{
    char lut[128];
    ibl_status status = IBL_OK;

    for (int i = 0; i < p->layers && !status; i++)
        status =
            hash_capture(p, &p->set.entry[i].capture,
                         ibl_probes_alpha(&p->set, i), p->index.layer[i].hash);
    const int n =
        snprintf(lut, sizeof lut, "iblbake %s %s %s\nlut %d %d", IBL_VERSION,
                 IBL_REVISION, ibl_isa_name(p->isa), p->set.bake.lut_size,
                 p->set.bake.pixel == IBL_PIXEL_RGBA32F);
    ibl_hash_bytes(lut, (size_t)n, p->index.file[IBL_PROBES_LUT].inputs);
    return status;
}

ibl_status ibl_probes_look_back(ibl_probes_bake *p)
{
    ibl_probes_index_read(p->path[IBL_PROBES_INDEX], &p->set, &p->old_text,
                          &p->old);
    for (int kind = 0; kind < IBL_PROBES_TEXTURES; kind++) {
        const ibl_probes_texture *t = &p->old.file[kind];
        char *path = *t->name ? ibl_path_join(p->opts->output, t->name) : NULL;
        char hash[IBL_HASH_SIZE];
        if (!path && *t->name)
            return ibl_probes_no_memory(p);
        p->whole[kind] =
            path && ibl_hash_file(path, hash) && !strcmp(hash, t->hash);
        free(path);
    }
    return IBL_OK;
}

/* ---- plan -------------------------------------------------------------- */

/* The first of some layers with that hash of the inputs; -1: none. */
static int find_layer(const ibl_probes_layer *layers, int count,
                      const char *hash)
{
    for (int i = 0; i < count; i++)
        if (!strcmp(layers[i].hash, hash))
            return i;
    return -1;
}

/* The old layer with the same inputs, its own place first; -1: none. */
static int find_old(const ibl_probes_index *old, int layer, const char *hash)
{
    if (layer < old->layers && !strcmp(old->layer[layer].hash, hash))
        return layer;
    return find_layer(old->layer, old->layers, hash);
}

void ibl_probes_plan(ibl_probes_bake *p)
{
    const bool usable =
        !p->opts->force && p->whole[IBL_PROBES_SPECULAR] &&
        (!p->set.bake.irradiance || p->whole[IBL_PROBES_IRRADIANCE]);
    bool moved = p->old.layers != p->layers;

    for (int i = 0; i < p->layers; i++) {
        const char *hash = p->index.layer[i].hash;
        const int old = usable ? find_old(&p->old, i, hash) : -1;
        const int twin = find_layer(p->index.layer, i, hash);
        p->source[i] = old >= 0    ? (ibl_probes_source){IBL_FROM_OLD, old}
                       : twin >= 0 ? (ibl_probes_source){IBL_FROM_TWIN, twin}
                                   : (ibl_probes_source){IBL_FROM_BAKE, -1};
        moved |= old != i;
    }
    for (int kind = 0; kind < IBL_PROBES_TEXTURES; kind++)
        p->same[kind] =
            !p->opts->force && p->whole[kind] &&
            !strcmp(p->old.file[kind].name, p->index.file[kind].name) &&
            (kind == IBL_PROBES_LUT
                 ? !strcmp(p->old.file[kind].inputs, p->index.file[kind].inputs)
                 : !moved);
}
