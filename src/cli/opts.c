/* SPDX-License-Identifier: MIT */
#include "cli/opts.h"

#include <errno.h>
#include <math.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include "cli/option.h"

bool ibl_opts_wants(const ibl_opts *o, ibl_output_kind kind)
{
    return (o->only & 1u << kind) && (kind != IBL_OUTPUT_SKYBOX || o->skybox);
}

ibl_pixel ibl_opts_lut_pixel(const ibl_opts *o)
{
    return o->pixel == IBL_PIXEL_RGBA32F ? IBL_PIXEL_RG32F : IBL_PIXEL_RG16F;
}

static bool misuse(const char *fmt, ...) __attribute__((format(printf, 1, 2)));
static bool misuse(const char *fmt, ...)
{
    va_list ap;

    fputs("iblbake: ", stderr);
    va_start(ap, fmt);
    vfprintf(stderr, fmt, ap);
    va_end(ap);
    fputc('\n', stderr);
    return false;
}

/* Edit distance: insertions, deletions and replacements. Names longer than
 * the row are as far as they are long. */
static size_t distance(const char *a, const char *b, size_t b_length)
{
    size_t row[32];

    if (b_length >= sizeof row / sizeof row[0])
        return b_length;
    for (size_t j = 0; j <= b_length; j++)
        row[j] = j;
    for (size_t i = 0; a[i]; i++) {
        size_t diagonal = row[0];
        row[0] = i + 1;
        for (size_t j = 0; j < b_length; j++) {
            size_t best = diagonal + (a[i] != b[j]);
            diagonal = row[j + 1];
            if (row[j] + 1 < best)
                best = row[j] + 1;
            if (diagonal + 1 < best)
                best = diagonal + 1;
            row[j + 1] = best;
        }
    }
    return row[b_length];
}

static bool unknown_long(const char *word, size_t length)
{
    const ibl_option *nearest = NULL;
    size_t least = length / 3 + 2;

    for (int i = 0; i < ibl_option_count; i++) {
        const size_t d = distance(ibl_option_table[i].name, word, length);
        if (d < least) {
            least = d;
            nearest = &ibl_option_table[i];
        }
    }
    if (nearest)
        return misuse("--%.*s: unknown option: did you mean --%s?", (int)length,
                      word, nearest->name);
    return misuse("--%.*s: unknown option: see iblbake --help", (int)length,
                  word);
}

static const ibl_option *find_long(const char *word, size_t length)
{
    for (int i = 0; i < ibl_option_count; i++)
        if (strlen(ibl_option_table[i].name) == length &&
            !memcmp(ibl_option_table[i].name, word, length))
            return &ibl_option_table[i];
    return NULL;
}

static const ibl_option *find_short(char letter)
{
    for (int i = 0; i < ibl_option_count; i++)
        if (ibl_option_table[i].letter == letter)
            return &ibl_option_table[i];
    return NULL;
}

static bool set_int(const ibl_option *opt, int *field, const char *value)
{
    char *end;

    errno = 0;
    const long n = strtol(value, &end, 10);
    if (end == value || *end || errno || (double)n < opt->low ||
        (double)n > opt->high)
        return false;
    *field = (int)n;
    return true;
}

static bool set_real(const ibl_option *opt, double *field, const char *value)
{
    char *end;
    const double x = strtod(value, &end);

    if (end == value || *end || !(x >= opt->low && x <= opt->high))
        return false;
    *field = x;
    return true;
}

static bool set_choice(const ibl_option *opt, int *field, const char *value)
{
    for (int i = 0; opt->choices[i]; i++)
        if (!strcmp(opt->choices[i], value)) {
            *field = i;
            return true;
        }
    return false;
}

/* Stores the value of an option; value is NULL for a flag. */
static bool set(ibl_opts *o, const ibl_option *opt, const char *value)
{
    void *field = (char *)o + opt->offset;
    char allowed[160];
    bool ok = false;

    switch (opt->kind) {
    case IBL_OPTION_FLAG:
        *(int *)field = 1;
        return true;
    case IBL_OPTION_INT:
        ok = set_int(opt, field, value);
        break;
    case IBL_OPTION_REAL:
        ok = set_real(opt, field, value);
        break;
    case IBL_OPTION_CHOICE:
        ok = set_choice(opt, field, value);
        break;
    case IBL_OPTION_TEXT:
        if (!*value)
            return misuse("--%s: is empty: give it a %s", opt->name,
                          opt->value);
        *(const char **)field = value;
        return true;
    case IBL_OPTION_OTHER:
        ok = opt->parse(o, value);
        break;
    }
    if (ok)
        return true;
    ibl_option_allowed(opt, allowed, sizeof allowed);
    return misuse("--%s %s: not a value of that option: it takes %s", opt->name,
                  value, allowed);
}

static bool no_value(const ibl_option *opt)
{
    char allowed[160];

    ibl_option_allowed(opt, allowed, sizeof allowed);
    return misuse("--%s: has no value: it takes %s%s%s", opt->name, opt->value,
                  *allowed ? ", " : "", allowed);
}

/* "--name", "--name=value" or "--name value"; *next is the argument after. */
static bool take_long(ibl_opts *o, const char *word, char **argv, int *next)
{
    const size_t length = strcspn(word, "=");
    const ibl_option *opt = find_long(word, length);
    const char *value = word[length] ? word + length + 1 : NULL;

    if (!opt)
        return unknown_long(word, length);
    if (!opt->value && value)
        return misuse("--%s=%s: the option takes no value: leave out =%s",
                      opt->name, value, value);
    if (opt->value && !value) {
        if (!argv[*next])
            return no_value(opt);
        value = argv[(*next)++];
    }
    return set(o, opt, value);
}

/* "-qv", "-j4", "-j 4". */
static bool take_short(ibl_opts *o, const char *word, char **argv, int *next)
{
    for (; *word; word++) {
        const ibl_option *opt = find_short(*word);
        if (!opt)
            return misuse("-%c: unknown option: see iblbake --help", *word);
        if (opt->value) {
            const char *value = word[1] ? word + 1 : argv[*next];
            if (!value)
                return no_value(opt);
            *next += !word[1];
            return set(o, opt, value);
        }
        set(o, opt, NULL);
    }
    return true;
}

static bool take_input(ibl_opts *o, const char *word)
{
    if (o->input)
        return misuse("%s: a second environment after %s: bake one at a time",
                      word, o->input);
    if (!*word)
        return misuse("the environment's name is empty: give a file, or - for "
                      "standard input");
    o->input = word;
    return true;
}

/* The input's name without directory and extension. */
static bool find_name(ibl_opts *o)
{
    if (!o->name) {
        const char *slash = o->input ? strrchr(o->input, '/') : NULL;
        const char *base = slash ? slash + 1 : o->input;
        if (!base || !strcmp(base, "-") || !*base)
            base = "env";
        const char *dot = strrchr(base, '.');
        const size_t length =
            dot && dot != base ? (size_t)(dot - base) : strlen(base);
        if (length >= sizeof o->stem)
            return misuse("%s: the name is longer than %zu bytes: choose "
                          "another with --name",
                          o->input, sizeof o->stem - 1);
        memcpy(o->stem, base, length);
        o->stem[length] = '\0';
        o->name = o->stem;
    }
    if (strchr(o->name, '/'))
        return misuse("--name %s: has a '/': the directory is set by --output",
                      o->name);
    return true;
}

static bool check_levels(const ibl_opts *o)
{
    int most = 1;

    while (o->specular.size >> most)
        most++;
    if (o->specular.levels > most)
        return misuse("--levels %d: a cube of size %d has 1 to %d levels",
                      o->specular.levels, o->specular.size, most);
    const int levels = o->specular.levels
                           ? o->specular.levels
                           : ibl_default_levels(o->specular.size);
    for (int l = levels; l < IBL_MAX_LEVELS; l++)
        if (o->specular.level_samples[l])
            return misuse("--level-samples %d=%d: there is no such level: they "
                          "are 0 to %d",
                          l, o->specular.level_samples[l], levels - 1);
    return true;
}

/* What can only be judged with every option known. */
static bool finish(ibl_opts *o)
{
    const unsigned lut = 1u << IBL_OUTPUT_LUT;

    if (!o->input && o->only != lut)
        return misuse("no environment: iblbake [options] ENV -o DIR, see "
                      "iblbake --help");
    if (!o->directory)
        return misuse("no output directory: add -o DIR");
    if ((o->only & 1u << IBL_OUTPUT_SKYBOX) &&
        o->only != ibl_opts_default().only && !o->skybox)
        return misuse("--only skybox: its size is not known: add --skybox N");
    if (o->quiet && o->verbose)
        return misuse("--quiet and --verbose: choose one");
    if (!check_levels(o) || !find_name(o))
        return false;
    o->specular.mapping = (ibl_roughness_map)o->mapping;
    o->specular.pdf_mip = o->pdf_mip;
    o->specular.yaw_deg = o->yaw_deg;
    o->irradiance.yaw_deg = o->yaw_deg;
    o->lut.geometry = (ibl_geometry)o->geometry;
    return true;
}

int ibl_opts_parse(int argc, char **argv, ibl_opts *o)
{
    bool ended = false;

    *o = ibl_opts_default();
    for (int next = 1; next < argc;) {
        const char *word = argv[next++];
        bool ok;
        if (ended || word[0] != '-' || !word[1])
            ok = take_input(o, word);
        else if (!strcmp(word, "--"))
            ok = ended = true;
        else if (word[1] == '-')
            ok = take_long(o, word + 2, argv, &next);
        else
            ok = take_short(o, word + 1, argv, &next);
        if (!ok)
            return 2;
        if (o->help || o->version)
            return 0;
    }
    return finish(o) ? 0 : 2;
}
