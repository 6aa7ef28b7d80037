/* SPDX-License-Identifier: MIT */
/* Hashes of the inputs of a set, and the lock of its directory. */
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>

#include "cli/probes.h"
#include "json/json_load.h"
#include "json/text.h"

/* ---- one run at a time ------------------------------------------------- */

int ibl_probes_hold(ibl_console *console, const char *directory, int lock)
{
    const int fd = open(directory, O_RDONLY | O_DIRECTORY | O_CLOEXEC);

    int failed = fd < 0 || flock(fd, lock | LOCK_NB);
    if (fd >= 0 && failed && errno == EWOULDBLOCK) {
        ibl_console_warn(console,
                         "%s: another run is at work there: waiting for it",
                         directory);
        while ((failed = flock(fd, lock)) && errno == EINTR)
            continue;
    }
    /* After other errors there is no lock: the file system has none. */
    return fd;
}

/* ---- hashes of layers --------------------------------------------------- */

ibl_alpha ibl_probes_alpha(const ibl_probe_set *set, int layer)
{
    return layer < set->count ? set->bake.alpha : IBL_ALPHA_IGNORE;
}

/* Everything that the texels of a layer depend on, as text. The caller must
 * free it; NULL: no memory. */
static char *describe(const ibl_probes_bake *p, int layer, const char *files)
{
    const ibl_set_bake *b = &p->set.bake;
    const ibl_specular_options *s = &b->options.specular_options;
    char *reading = ibl_common_reading(&p->opts->common);
    char *text = ibl_format(
        "iblbake %s %s %s\nsize %d levels %d mapping %d method %d samples %d "
        "tolerance %.17g pixel %s overflow %d quality %d irradiance %d\n"
        "%s alpha %s%s\n%s",
        IBL_VERSION, IBL_REVISION, ibl_isa_arithmetic(p->isa), s->size,
        s->levels, (int)s->mapping, (int)s->method, s->samples, s->tolerance,
        ibl_pixel_name(b->texels.pixel), (int)b->texels.overflow,
        ibl_pixel_block(b->texels.pixel) > 1 ? (int)b->texels.quality : 0,
        b->options.irradiance_options.size,
        ibl_capture_name(p->set.entry[layer].capture.kind),
        ibl_alpha_name(ibl_probes_alpha(&p->set, layer)),
        reading ? reading : "", files);

    if (!reading) {
        free(text);
        return NULL;
    }
    free(reading);
    return text;
}

static bool hash_capture(const ibl_probes_bake *p, const ibl_capture *c, int i,
                         char hash[IBL_HASH_SIZE])
{
    char element[16] = "";

    if (!ibl_probes_check_input(p, c->file[i]))
        return false;
    if (ibl_hash_file(c->file[i], hash))
        return true;
    if (c->count > 1)
        snprintf(element, sizeof element, "[%d]", i);
    return ibl_console_fail(
        p->console,
        "%s: %s.%s%s: expected a file that can be read, found %s: %s",
        p->opts->input, c->place, ibl_capture_name(c->kind), element,
        c->file[i], errno == EINVAL ? "no regular file" : strerror(errno));
}

static bool hash_layer(const ibl_probes_bake *p, int layer)
{
    ibl_set_entry *e = &p->set.entry[layer];
    char files[IBL_FACES * IBL_HASH_SIZE]; /* their hashes, in order */

    for (int i = 0; i < e->capture.count; i++)
        if (!hash_capture(p, &e->capture, i, files + i * (IBL_HASH_SIZE - 1)))
            return false;
    char *text = describe(p, layer, files);
    if (text)
        ibl_hash_bytes(text, strlen(text), e->hash);
    free(text);
    return text || ibl_probes_no_memory(p);
}

bool ibl_probes_hash_set(const ibl_probes_bake *p, char hash[IBL_HASH_SIZE])
{
    const ibl_set_bake *b = &p->set.bake;
    char *options = describe(p, 0, ""), *set = ibl_json_text(p->set.root);
    char *text = options && set
                     ? ibl_format("%scontainer %d zstd %d lut %d\n%s", options,
                                  (int)b->container, b->zstd, b->lut_size, set)
                     : NULL;

    if (text)
        ibl_hash_bytes(text, strlen(text), hash);
    free(options);
    free(set);
    free(text);
    return text || ibl_probes_no_memory(p);
}

bool ibl_probes_hash_inputs(ibl_probes_bake *p)
{
    char lut[128];
    bool ok = true;

    for (int i = 0; i < p->set.layers && ok; i++)
        ok = hash_layer(p, i);
    const int n =
        snprintf(lut, sizeof lut, "iblbake %s %s %s\nlut %d %d", IBL_VERSION,
                 IBL_REVISION, ibl_isa_arithmetic(p->isa), p->set.bake.lut_size,
                 p->set.bake.texels.pixel == IBL_PIXEL_RGBA32F);
    ibl_hash_bytes(lut, (size_t)n, p->lut_inputs);
    return ok;
}
