/* SPDX-License-Identifier: MIT */
/* Every option: what it is called, takes, defaults to and does. */
#include "cli/option.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

static const char *const format_names[] = {"ktx2", "ktx", "dds", NULL};
static const char *const pixel_names[] = {"rgba16f", "rgba32f", "rgb9e5",
                                          "r11g11b10f", NULL};
static const char *const mapping_names[] = {"linear", "filament", NULL};
static const char *const geometry_names[] = {"smith", "schlick-ibl", NULL};
static const char *const isa_names[] = {"auto", "c",      "sse2",
                                        "avx2", "avx512", NULL};
static const char *const no_yes[] = {"no", "yes", NULL};

/* Yaws that make faces look where another program's do. learnopengl and
 * threejs use the mapping of ibl/ibl.h; for cmgen (1.9, without --no-mirror)
 * it was measured: its +Z face shows the centre of the map and its +X face
 * what is a quarter of the width left of it. */
static const struct {
    const char *name;
    double yaw_deg;
} presets[] = {{"learnopengl", 0}, {"threejs", 0}, {"cmgen", -90}};

const char *ibl_output_name(ibl_output_kind kind)
{
    static const char *const names[] = {"skybox", "specular", "irradiance",
                                        "lut", "json"};
    return names[kind];
}

static bool parse_only(ibl_opts *o, const char *value)
{
    unsigned only = 0;

    while (*value) {
        const size_t length = strcspn(value, ",");
        int kind = 0;
        while (kind < IBL_OUTPUT_COUNT &&
               (strncmp(ibl_output_name(kind), value, length) != 0 ||
                ibl_output_name(kind)[length]))
            kind++;
        if (kind == IBL_OUTPUT_COUNT)
            return false;
        only |= 1u << kind;
        value += length;
        if (*value == ',' && !*++value)
            return false;
    }
    o->only = only;
    return only != 0;
}

static bool parse_rotate(ibl_opts *o, const char *value)
{
    char *end;

    for (size_t i = 0; i < sizeof presets / sizeof presets[0]; i++)
        if (!strcmp(value, presets[i].name)) {
            o->yaw_deg = presets[i].yaw_deg;
            return true;
        }
    o->yaw_deg = strtod(value, &end);
    return end != value && !*end && fabs(o->yaw_deg) <= 360;
}

/* LEVEL=N[,LEVEL=N]...; whether the levels exist is checked with --levels. */
static bool parse_level_samples(ibl_opts *o, const char *value)
{
    for (;;) {
        char *end;
        errno = 0;
        const long level = strtol(value, &end, 10);
        if (end == value || *end != '=' || level < 1 || level >= IBL_MAX_LEVELS)
            return false;
        value = end + 1;
        const long samples = strtol(value, &end, 10);
        if (end == value || errno || samples < 1 || samples > 1048576)
            return false;
        o->specular.level_samples[level] = (int)samples;
        if (!*end)
            return true;
        if (*end != ',')
            return false;
        value = end + 1;
    }
}

#define AT(field) .offset = offsetof(ibl_opts, field)
#define FLAG(field) .kind = IBL_OPTION_FLAG, AT(field)
#define TEXT(field, what) .kind = IBL_OPTION_TEXT, .value = (what), AT(field)
#define INT(field, lo, hi)                                                     \
    .kind = IBL_OPTION_INT, .value = "N", AT(field), .low = (lo), .high = (hi)
#define REAL(field, what, lo, hi)                                              \
    .kind = IBL_OPTION_REAL, .value = (what), AT(field), .low = (lo),          \
    .high = (hi)
#define CHOICE(field, names)                                                   \
    .kind = IBL_OPTION_CHOICE, .value = "NAME", AT(field), .choices = (names)
#define OTHER(what, function)                                                  \
    .kind = IBL_OPTION_OTHER, .value = (what), .parse = (function)

/* clang-format off */
const ibl_option ibl_option_table[] = {
    {"Outputs", "output", 'o', TEXT(directory, "DIR"), .standard = "",
     .help = "directory of the outputs, made if it is not there; required"},
    {"Outputs", "name", 0, TEXT(name, "NAME"),
     .standard = "ENV without directory and extension",
     .help = "outputs are NAME_specular.EXT and so on"},
    {"Outputs", "format", 0, CHOICE(format, format_names),
     .help = "container, and the extension of its files"},
    {"Outputs", "pixel", 0, CHOICE(pixel, pixel_names),
     .help = "texels of the cubes; the LUT is rg32f with rgba32f, else rg16f"},
    {"Outputs", "only", 0, OTHER("LIST", parse_only),
     .allowed = "a list of specular, irradiance, lut, skybox, json",
     .standard = "all", .help = "make these outputs alone"},
    {"Outputs", "skybox", 0, INT(skybox, 1, IBL_MAX_CUBE_SIZE),
     .standard = "none",
     .help = "the environment itself too, as a cube with mips, N texels "
             "along an edge"},
    {"Outputs", "preview", 0, TEXT(preview, "FILE"), .standard = "",
     .help = "a PNG picture of everything that was made"},
    {"Outputs", "depfile", 0, TEXT(depfile, "FILE"), .standard = "",
     .help = "a rule for make and ninja: outputs depend on ENV"},
    {"Outputs", "timings", 0, FLAG(timings),
     .help = "note the time of each stage in the sidecar, which then differs "
             "from run to run"},

    {"Input", "rotate", 0, OTHER("DEG", parse_rotate),
     .allowed = "-360 to 360, learnopengl, threejs (both 0) or cmgen (-90)",
     .standard = "0",
     .help = "turn the environment about +Y, counter-clockwise from above"},
    {"Input", "layer", 0, TEXT(read.layer, "NAME"),
     .standard = "the unnamed or only one", .help = "layer of an EXR file"},
    {"Input", "part", 0, INT(read.part, 0, 65535),
     .standard = "the first with colour",
     .help = "part of a multi-part EXR file, from 0"},
    {"Input", "any-aspect", 0, FLAG(read.any_aspect),
     .help = "take maps whose width is not twice their height"},
    {"Input", "strict", 0, FLAG(read.strict),
     .help = "refuse infinite, NaN and negative pixels, which are otherwise "
             "mended"},

    {"Specular", "size", 0, INT(specular.size, 1, IBL_MAX_CUBE_SIZE),
     .help = "edge of the largest level in texels"},
    {"Specular", "levels", 0, INT(specular.levels, 1, IBL_MAX_LEVELS),
     .standard = "down to 8x8", .help = "number of levels"},
    {"Specular", "mapping", 0, CHOICE(mapping, mapping_names),
     .help = "roughness of the levels: lod = r (levels - 1), or "
             "r (2 - r) (levels - 1)"},
    {"Specular", "samples", 0, INT(specular.samples, 1, 1048576),
     .help = "samples for each texel"},
    {"Specular", "level-samples", 0, OTHER("LIST", parse_level_samples),
     .allowed = "LEVEL=N,..., with levels from 1 and N from 1 to 1048576",
     .standard = "",
     .help = "samples of single levels, instead of --samples"},
    {"Specular", "lod-bias", 0, REAL(specular.lod_bias, "BIAS", -4, 4),
     .help = "added to the mip level of each sample's lookup"},
    {"Specular", "jitter", 0, FLAG(specular.jitter),
     .help = "turn the sample pattern from texel to texel: noise instead of "
             "structure, the same in every run"},
    {"Specular", "pdf-mip", 0, CHOICE(pdf_mip, no_yes),
     .help = "choose the mip level of a lookup by the sample's density; no: "
             "always the full resolution"},

    {"Irradiance and spherical harmonics", "irradiance-size", 0,
     INT(irradiance.size, 1, IBL_MAX_CUBE_SIZE),
     .help = "edge of the faces in texels"},
    {"Irradiance and spherical harmonics", "irradiance-step", 0,
     REAL(irradiance.step, "RAD", 0.001, 0.5),
     .standard = "the sum over every pixel",
     .help = "the classic grid over the hemisphere, with this step in radians"},
    {"Irradiance and spherical harmonics", "sh", 0,
     INT(sh_degree, 0, IBL_MAX_SH_DEGREE),
     .help = "degree of the coefficients in the sidecar; 2 gives 9 of them"},

    {"BRDF table", "lut-size", 0, INT(lut.size, 1, 4096),
     .help = "edge in texels"},
    {"BRDF table", "lut-samples", 0, INT(lut.samples, 0, 1048576),
     .help = "sampled with N points for each texel; 0: exact quadrature"},
    {"BRDF table", "geometry", 0, CHOICE(geometry, geometry_names),
     .help = "shadowing and masking: Smith height-correlated, or Schlick "
             "with k = r r / 2"},

    {"Running", "threads", 'j', INT(threads, 0, 1024),
     .help = "threads; 0: as many as there are CPUs for this process. The "
             "outputs are the same for any number"},
    {"Running", "isa", 0, CHOICE(isa, isa_names),
     .help = "instruction set of the hot loops; auto: the best of this CPU"},
    {"Running", "quiet", 'q', FLAG(quiet), .help = "print errors alone"},
    {"Running", "verbose", 'v', FLAG(verbose),
     .help = "print what was done and the time of each stage"},
    {"Running", "help", 'h', FLAG(help), .help = "print this text"},
    {"Running", "version", 0, FLAG(version),
     .help = "print the version and what it was built with"},
};
/* clang-format on */

const int ibl_option_count =
    (int)(sizeof ibl_option_table / sizeof ibl_option_table[0]);

ibl_opts ibl_opts_default(void)
{
    ibl_opts o = {
        .format = IBL_CONTAINER_KTX2,
        .pixel = IBL_PIXEL_RGBA16F,
        .only = (1u << IBL_OUTPUT_COUNT) - 1,
        .specular = ibl_specular_options_default(),
        .irradiance = ibl_irradiance_options_default(),
        .lut = ibl_lut_options_default(),
        .sh_degree = 2,
        .read = ibl_read_options_default(),
        .isa = IBL_ISA_AUTO,
    };

    /* Enumerations and flags of the library, as ints that the table sets. */
    o.mapping = (int)o.specular.mapping;
    o.pdf_mip = o.specular.pdf_mip;
    o.geometry = (int)o.lut.geometry;
    return o;
}
