/* SPDX-License-Identifier: MIT */
#include "cli/opts.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

bool ibl_opts_wants(const ibl_opts *o, ibl_output_kind kind)
{
    return (o->only & 1u << kind) && (kind != IBL_OUTPUT_SKYBOX || o->skybox);
}

ibl_pixel ibl_opts_lut_pixel(const ibl_opts *o)
{
    return o->pixel == IBL_PIXEL_RGBA32F ? IBL_PIXEL_RG32F : IBL_PIXEL_RG16F;
}

bool ibl_opts_take(void *settings, const char *word)
{
    ibl_opts *o = settings;

    if (o->input)
        return ibl_misuse(
            "%s: a second environment after %s: bake one at a time", word,
            o->input);
    if (!*word)
        return ibl_misuse(
            "the environment's name is empty: give a file, or - for "
            "standard input");
    o->input = word;
    return true;
}

bool ibl_stem(const char *input, char *stem, size_t size)
{
    const char *slash = input ? strrchr(input, '/') : NULL;
    const char *base = slash ? slash + 1 : input;

    if (!base || !strcmp(base, "-") || !*base)
        base = "env";
    const char *dot = strrchr(base, '.');
    const size_t length =
        dot && dot != base ? (size_t)(dot - base) : strlen(base);
    if (length >= size)
        return ibl_misuse("%s: the name is longer than %zu bytes: choose "
                          "another with --name",
                          input, size - 1);
    memcpy(stem, base, length);
    stem[length] = '\0';
    return true;
}

static bool find_name(ibl_opts *o)
{
    if (!o->name) {
        if (!ibl_stem(o->input, o->stem, sizeof o->stem))
            return false;
        o->name = o->stem;
    }
    if (strchr(o->name, '/'))
        return ibl_misuse("--name %s: has a '/': the directory is set by "
                          "--output",
                          o->name);
    return true;
}

static void note_sampling(ibl_opts *o, bool given, const char *name)
{
    const size_t used = strlen(o->sampling);

    if (given)
        snprintf(o->sampling + used, sizeof o->sampling - used, "%s%s",
                 used ? ", " : "", name);
}

/* Before what was not given is filled in. */
static void note_samplings(ibl_opts *o)
{
    const ibl_opts d = ibl_opts_default();
    const double bias = o->specular.lod_bias, usual = d.specular.lod_bias;

    note_sampling(o, o->specular.samples != d.specular.samples, "--samples");
    note_sampling(o, bias < usual || bias > usual, "--lod-bias");
    note_sampling(o, o->specular.jitter, "--jitter");
    note_sampling(o, o->pdf_mip != d.pdf_mip, "--pdf-mip");
}

/* The numbers of the specular chain, into the library's options. */
static bool finish_specular(ibl_opts *o)
{
    ibl_specular_options *s = &o->specular;
    ibl_specular_layout layout;
    int most = 1;

    note_samplings(o);
    s->method = (ibl_method)o->method;
    s->lobe = (ibl_lobe)o->lobe;
    s->mapping = (ibl_roughness_map)o->mapping;
    s->pdf_mip = o->pdf_mip;
    s->roughness_min = o->roughness[0];
    s->roughness_max = o->roughness[1];
    while (s->size >> most)
        most++;
    if (s->levels > most)
        return ibl_misuse("--levels %d: a cube of size %d has 1 to %d levels",
                          s->levels, s->size, most);
    if (ibl_specular_layout_of(s, &layout))
        return ibl_misuse("--levels %d: --roughness-range %g:%g is one "
                          "roughness, which has one level",
                          s->levels, s->roughness_min, s->roughness_max);
    if (s->level_samples[0] && s->roughness_min <= 0)
        return ibl_misuse("--level-samples 0=%d: level 0 is the environment "
                          "itself and takes none: levels from 1 do",
                          s->level_samples[0]);
    for (int l = 0; l < IBL_MAX_LEVELS; l++)
        if (s->level_samples[l] && s->method == IBL_METHOD_SPECTRAL)
            return ibl_misuse("--level-samples %d=%d: --method spectral "
                              "samples no level: leave one of them out",
                              l, s->level_samples[l]);
    for (int l = layout.levels; l < IBL_MAX_LEVELS; l++)
        if (s->level_samples[l])
            return ibl_misuse(
                "--level-samples %d=%d: there is no such level: they "
                "are 0 to %d",
                l, s->level_samples[l], layout.levels - 1);
    return true;
}

bool ibl_opts_finish(void *settings)
{
    ibl_opts *o = settings;
    const unsigned lut = 1u << IBL_OUTPUT_LUT;

    if (!o->input && o->only != lut)
        return ibl_misuse("no environment: iblbake [options] ENV -o DIR, see "
                          "iblbake --help");
    if (!o->directory)
        return ibl_misuse("no output directory: add -o DIR");
    if ((o->only & 1u << IBL_OUTPUT_SKYBOX) &&
        o->only != ibl_opts_default().only && !o->skybox)
        return ibl_misuse(
            "--only skybox: its size is not known: add --skybox N");
    if (!ibl_common_finish(&o->common) || !finish_specular(o) || !find_name(o))
        return false;
    o->verify |= !isnan(o->max_error);
    o->lut.geometry = (ibl_geometry)o->geometry;
    return true;
}
