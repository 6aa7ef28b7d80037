/* SPDX-License-Identifier: MIT */
/* The options that every command has. */
#include <ctype.h>
#include <jansson.h>
#include <png.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include <xxhash.h>
#include <zlib.h>
#include <zstd.h>

#include <ibl/sidecar.h>

#include "cli/common_options.h"
#include "common/names.h"
#include "common/path.h"
#include "common/signals.h"
#include "engine/set.h"
#include "json/text.h"

static void print_version(FILE *to)
{
    const char *beside = ibl_bridge_beside();
    const char *bridge = beside ? beside : ibl_bridge_path();
    const char *revision = IBL_REVISION;

    fprintf(to, "iblbake %s%s%s%s\n", IBL_VERSION, *revision ? " (" : "",
            revision, *revision ? ")" : "");
    fprintf(to, "compiler      %s\n", IBL_COMPILER);
    fprintf(to,
            "libraries     OpenEXRCore %s, libpng %s, zlib %s, jansson %s, "
            "xxHash %u.%u.%u, zstd %s\n",
            ibl_exr_version(), png_get_libpng_ver(NULL), zlibVersion(),
            jansson_version_str(), XXH_versionNumber() / 10000,
            XXH_versionNumber() / 100 % 100, XXH_versionNumber() % 100,
            ZSTD_versionString());
    /* Opening the bridge would take longer than everything else here. */
    if (access(bridge, R_OK))
        fprintf(to, "image bridge  none (%s)\n", bridge);
    else
        fprintf(to, "image bridge  %s\n", bridge);
    fprintf(to, "instructions  %s\n", ibl_isa_name(ibl_isa_best()));
    fprintf(to, "threads       %d\n", ibl_cpu_count());
}

static const char *const isa_names[] = {"auto", "c",    "sse2",
                                        "avx2", "neon", NULL};

const char *const ibl_output_names[] = {
    "skybox", "specular", "irradiance", "lut", "lobe-table", "json", NULL};

const char *ibl_output_content(ibl_output_kind kind)
{
    _Static_assert((int)IBL_OUTPUT_LOBES == (int)IBL_CONTENT_LOBE_TABLE,
                   "outputs begin with the contents of textures");
    return kind == IBL_OUTPUT_JSON ? ibl_output_names[kind]
                                   : ibl_content_name((ibl_content)kind);
}

ibl_pixel ibl_lut_pixel(ibl_pixel cubes, ibl_lut_kind kind)
{
    if (ibl_lut_channels(kind) == 3)
        return cubes == IBL_PIXEL_RGBA32F ? cubes : IBL_PIXEL_RGBA16F;
    return cubes == IBL_PIXEL_RGBA32F ? IBL_PIXEL_RG32F : IBL_PIXEL_RG16F;
}

int ibl_most_levels(int size)
{
    int levels = 1;

    while (size >> levels)
        levels++;
    return levels;
}

/* Takes the face out of a pattern's stem, with a separator beside it. */
static void drop_face(char *stem)
{
    char *at = strstr(stem, "%f");
    while (at && isalnum((unsigned char)at[2]))
        at = strstr(at + 2, "%f");
    char *end = at ? at + 2 : stem;

    if (at && at > stem && strchr("_-.", at[-1]))
        at--;
    else if (at == stem && *end && strchr("_-.", *end))
        end++;
    if (at)
        memmove(at, end, strlen(end) + 1);
    if (!*stem)
        strcpy(stem, "env");
}

bool ibl_stem(const char *input, char *stem, size_t size)
{
    const char *base = input ? ibl_path_name(input) : "";
    int commas = 0;

    for (const char *at = input; at && *at; at++)
        commas += *at == ',';
    if (!strcmp(base, "-") || !*base ||
        (commas == IBL_FACES - 1 && access(input, F_OK)))
        base = "env"; /* standard input, or a list of six files */
    const char *dot = strrchr(base, '.');
    const size_t length =
        dot && dot != base ? (size_t)(dot - base) : strlen(base);
    if (length >= size)
        return ibl_misuse("%s: the name is longer than %zu bytes: choose "
                          "another with --name",
                          input, size - 1);
    snprintf(stem, size, "%.*s", (int)length, base);
    drop_face(stem);
    return true;
}

bool ibl_shard_parse(void *shard, const char *value)
{
    ibl_shard s;
    const char *end;

    if (!ibl_number_int(value, 1, IBL_MOST_SHARDS, &s.number, &end) ||
        *end != '/' ||
        !ibl_number_int(end + 1, s.number, IBL_MOST_SHARDS, &s.count, &end) ||
        *end)
        return false;
    *(ibl_shard *)shard = s;
    return true;
}

bool ibl_shard_has(const ibl_shard *shard, int i)
{
    return !shard->count || i % shard->count + 1 == shard->number;
}

/* Parses bytes, with K, M or G for powers of 1024, into a size_t. */
static bool parse_size(void *bytes, const char *value)
{
    const char *end;
    double size;

    if (!ibl_number_real(value, 0, 1e15, &size, &end))
        return false;
    const int shift = *end == 'K'   ? 10
                      : *end == 'M' ? 20
                      : *end == 'G' ? 30
                                    : 0;
    size *= (double)(1 << shift);
    if (end[shift > 0] || size < 1 << 20 || size > 1e15)
        return false;
    *(size_t *)bytes = (size_t)size;
    return true;
}

size_t ibl_memory_most(const ibl_common *c)
{
    return c->max_memory ? c->max_memory : ibl_memory_allowed() / 4 * 3;
}

static bool parse_face_order(void *order, const char *value)
{
    return ibl_face_order_parse(value, order);
}

#define IBL_SETTINGS ibl_common

/* clang-format off */
static const ibl_option input[] = {
    {"layer", 0, IBL_TEXT(read.layer, "NAME"),
     .standard = "the unnamed or only one",
     .help = "layer or part of an EXR file"},
    {"part", 0, IBL_INT(read.part, 0, 65535),
     .standard = "the one with colour",
     .help = "part of a multi-part EXR file, from 0"},
    {"any-aspect", 0, IBL_FLAG(read.any_aspect),
     .help = "accept maps whose width is not twice their height"},
    {"input-layout", 0, IBL_CHOICE(read.layout, ibl_input_names),
     .help = "how the file holds the environment; auto: by its kind and shape. "
             "Squares are equirect or octahedral, so they need this"},
    {"face-order", 0, IBL_OTHER(read.face_order, "LIST", parse_face_order),
     .allowed = IBL_FACE_ORDER_ALLOWED,
     .standard = "the layout's",
     .help = "which faces a cube's are: turned clockwise, mirrored before"},
    {"input-transfer", 0, IBL_CHOICE(read.transfer, ibl_transfer_names),
     .help = "the curve of integers; file: sRGB, or what a PNG says"},
    {"strict", 0, IBL_FLAG(read.strict),
     .help = "refuse infinite, NaN and negative pixels, which are otherwise "
             "repaired"},
    {"primaries", 0, IBL_CHOICE(read.primaries, ibl_primaries_names),
     .help = "primaries to convert the colours of the file to, from those "
             "that it names, or from Rec. 709"},
    {"exposure", 0,
     IBL_REAL(read.exposure, "EV", -IBL_MAX_EXPOSURE, IBL_MAX_EXPOSURE),
     .help = "multiply the environment by 2^EV"},
    {"clamp", 0, IBL_REAL(read.clamp, "MAX", 1e-6, 1e30), .standard = "none",
     .help = "scale pixels down whose largest component is above MAX, after "
             "the exposure; says how much light that takes"},
};

static const ibl_option running[] = {
    {"threads", 'j', IBL_INT(threads, 0, 1024),
     .help = "threads; 0: one for each CPU that this process may use. The "
             "outputs do not depend on the number",
     .aside = true},
    {"isa", 0, IBL_CHOICE(isa, isa_names),
     .help = "instruction set of the hot loops; auto: the best of this CPU",
     .aside = true},
    {"max-memory", 0, IBL_OTHER(max_memory, "SIZE", parse_size),
     .allowed = "1M or more, in bytes or with K, M or G",
     .standard = "3/4 of the machine's or its control group's",
     .help = "memory that may be taken; what needs more is refused before it "
             "starts",
     .aside = true},
    {"quiet", 'q', IBL_FLAG(quiet), .help = "print only errors",
     .aside = true},
    {"verbose", 'v', IBL_FLAG(verbose),
     .help = "print what was done and the time of each stage",
     .aside = true},
    {"help", 'h', .kind = IBL_OPTION_HELP, .help = "print this text",
     .aside = true},
    {"version", 0, .kind = IBL_OPTION_PRINT, .print = print_version,
     .help = "print the version and what it was built with",
     .aside = true},
};
/* clang-format on */

const ibl_section ibl_input_section = {
    "Input", input, sizeof input / sizeof *input, sizeof *input};
const ibl_section ibl_running_section = {
    "Running", running, sizeof running / sizeof *running, sizeof *running};

ibl_common ibl_common_default(void)
{
    ibl_read_options read = ibl_read_options_default();

    read.env = ibl_env_decode;
    return (ibl_common){.read = read, .isa = IBL_ISA_AUTO};
}

char *ibl_settings_text(ibl_isa isa, const ibl_command *command,
                        const ibl_given *given)
{
    const ibl_option *o;
    char *text = NULL;

    ibl_append(&text, "iblbake %s %s %s\n", IBL_VERSION, IBL_REVISION,
               ibl_isa_arithmetic(isa));
    for (int n = 0; (o = ibl_option_at(command, n)); n++) {
        const char *value = ibl_given_value(given, o->name);
        if (value && !o->aside)
            ibl_append(&text, "--%s=%s\n", o->name, value);
    }
    return text;
}

bool ibl_common_validate(const ibl_common *c)
{
    if (c->quiet && c->verbose)
        return ibl_misuse("--quiet and --verbose: choose one");
    return true;
}
