/* SPDX-License-Identifier: MIT */
/* The bake and every option of its own: what it is called, takes, defaults to
 * and does. */
#include <math.h>
#include <string.h>

#include "cli/bake.h"
#include "cli/opts.h"
#include "common/names.h"

static const char *const no_yes[] = {"no", "yes", NULL};

const char *ibl_output_name(ibl_output_kind kind)
{
    static const char *const names[] = {"skybox", "specular", "irradiance",
                                        "lut", "json"};
    return names[kind];
}

static bool parse_only(void *field, const char *value)
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
    *(unsigned *)field = only;
    return only != 0;
}

/* LEVEL=N[,LEVEL=N]...; whether the levels exist is checked with --levels. */
static bool parse_level_samples(void *field, const char *value)
{
    int *level_samples = field;

    for (;;) {
        const char *end;
        int level;
        if (!ibl_number_int(value, 0, IBL_MAX_LEVELS - 1, &level, &end) ||
            *end != '=' ||
            !ibl_number_int(end + 1, 1, 1048576, &level_samples[level], &end))
            return false;
        if (!*end)
            return true;
        if (*end != ',')
            return false;
        value = end + 1;
    }
}

/* A:B, each 0 to 1, the smaller first. */
static bool parse_range(void *field, const char *value)
{
    double *range = field;
    const char *end;

    return ibl_number_real(value, 0, 1, &range[0], &end) && *end == ':' &&
           ibl_number_real(end + 1, range[0], 1, &range[1], &end) && !*end;
}

#define FLAG(field) IBL_FLAG(ibl_opts, field)
#define TEXT(field, what) IBL_TEXT(ibl_opts, field, what)
#define INT(field, lo, hi) IBL_INT(ibl_opts, field, lo, hi)
#define REAL(field, what, lo, hi) IBL_REAL(ibl_opts, field, what, lo, hi)
#define CHOICE(field, names) IBL_CHOICE(ibl_opts, field, names)
#define OTHER(field, what, parse) IBL_OTHER(ibl_opts, field, what, parse)

/* clang-format off */
static const ibl_option outputs[] = {
    {"output", 'o', IBL_DIR(ibl_opts, directory), .standard = "",
     .help = "directory of the outputs, made if it is not there; required"},
    {"name", 0, TEXT(name, "NAME"),
     .standard = "ENV without directory and extension",
     .help = "outputs are NAME_specular.EXT and so on"},
    {"format", 0, CHOICE(format, ibl_container_names),
     .help = "container, and the extension of its files"},
    {"pixel", 0, CHOICE(pixel, ibl_pixel_names),
     .help = "texels of the cubes; the LUT is rg32f with rgba32f, else rg16f"},
    {"overflow", 0, CHOICE(overflow, ibl_overflow_names),
     .help = "light of texels brighter than the pixel holds: spread over the "
             "texels around them, or clip"},
    {"only", 0, OTHER(only, "LIST", parse_only),
     .allowed = "a list of specular, irradiance, lut, skybox, json",
     .standard = "all", .help = "make only these outputs"},
    {"skybox", 0, INT(skybox, 1, IBL_MAX_CUBE_SIZE),
     .standard = "none",
     .help = "the environment itself too, as a cube with mips, N texels "
             "along an edge"},
    {"preview", 0, IBL_PNG(ibl_opts, preview, "FILE"),
     .help = "a PNG picture of everything that was made"},
    {"depfile", 0, TEXT(depfile, "FILE"), .standard = "",
     .help = "a rule for make and ninja: outputs depend on ENV"},
    {"sync", 0, FLAG(sync),
     .help = "wait until everything is on the disk, so that a power cut "
             "leaves whole files"},
    {"timings", 0, FLAG(timings),
     .help = "note the time of each stage in the sidecar, which then differs "
             "from run to run"},
    {"verify", 0, FLAG(verify),
     .help = "judge what was written by the exact sums, as iblbake verify "
             "does, print the table and note it in the sidecar"},
    {"max-error", 0, REAL(max_error, "E", 0, 1000), .standard = "none",
     .help = "verify, and write nothing if the nRMSE of a level or the largest "
             "error of the table is above E"},
};

static const ibl_option input[] = {
    {"rotate", 0, OTHER(yaw_deg, "DEG", ibl_rotate_parse),
     .allowed = IBL_ROTATE_ALLOWED,
     .standard = "0",
     .help = "turn the environment about +Y, counter-clockwise from above"},
};

static const ibl_option specular[] = {
    {"size", 0, INT(specular.size, 1, IBL_MAX_CUBE_SIZE),
     .help = "edge of the largest level in texels"},
    {"levels", 0, INT(specular.levels, 1, IBL_MAX_LEVELS),
     .standard = "down to 8x8", .help = "number of levels"},
    {"lobe", 0, CHOICE(lobe, ibl_lobe_names),
     .help = "what the levels are convolved with: GGX, sheen as of glTF, or a "
             "cosine power"},
    {"mapping", 0, CHOICE(mapping, ibl_mapping_names),
     .help = "roughness of the levels: lod = r (levels - 1), or "
             "r (2 - r) (levels - 1)"},
    {"roughness-range", 0, OTHER(roughness, "A:B", parse_range),
     .allowed = "two numbers from 0 to 1, the smaller first",
     .standard = "0:1",
     .help = "make only what materials of these roughnesses need"},
    {"method", 0, CHOICE(method, ibl_method_names),
     .help = "how levels are made: exactly (spectral), or by importance "
             "sampling; auto: exactly, but for the levels of "
             "--level-samples"},
    {"samples", 0, INT(specular.samples, 1, 1048576),
     .help = "samples for each texel of a sampled level"},
    {"level-samples", 0, OTHER(specular.level_samples, "LIST",
     parse_level_samples),
     .allowed = "LEVEL=N,..., with N from 1 to 1048576",
     .standard = "",
     .help = "samples of single levels, whatever --samples says; auto samples "
             "them"},
    {"tolerance", 0, REAL(specular.tolerance, "E", 1e-6, 1),
     .help = "relative error that is accepted of 95 % of the texels of each "
             "level; a larger one takes less time"},
    {"lod-bias", 0, REAL(specular.lod_bias, "BIAS", -4, 4),
     .help = "added to the mip level of each sample's lookup"},
    {"jitter", 0, FLAG(specular.jitter),
     .help = "turn the sample pattern from texel to texel: noise instead of "
             "structure, the same in every run"},
    {"pdf-mip", 0, CHOICE(pdf_mip, no_yes),
     .help = "choose the mip level of a lookup by the sample's density; no: "
             "always the full resolution"},
};

static const ibl_option irradiance[] = {
    {"irradiance-size", 0,
     INT(irradiance.size, 1, IBL_MAX_CUBE_SIZE),
     .help = "edge of the faces in texels"},
    {"irradiance-step", 0,
     REAL(irradiance.step, "RAD", 0.001, 0.5),
     .standard = "none: exact",
     .help = "the classic grid over the hemisphere, with this step in radians"},
    {"sh", 0,
     INT(sh_degree, 0, IBL_MAX_SH_DEGREE),
     .help = "degree of the coefficients in the sidecar; 2 gives 9 of them"},
};

static const ibl_option lut[] = {
    {"lut-size", 0, INT(lut.size, 1, 4096),
     .help = "edge in texels"},
    {"lut-samples", 0, INT(lut.samples, 0, 1048576),
     .help = "sampled with N points for each texel; 0: exact quadrature"},
    {"geometry", 0, CHOICE(geometry, ibl_geometry_names),
     .help = "shadowing and masking: Smith height-correlated, or Schlick "
             "with k = r r / 2"},
};
/* clang-format on */

static const ibl_section *const sections[] = {
    IBL_SECTION("Outputs", outputs),
    IBL_SECTION("Input", input),
    &ibl_input_section,
    IBL_SECTION("Specular", specular),
    IBL_SECTION("Irradiance and spherical harmonics", irradiance),
    IBL_SECTION("BRDF table", lut),
    &ibl_running_section,
    NULL,
};

ibl_opts ibl_opts_default(void)
{
    ibl_opts o = {
        .common = ibl_common_default(),
        .format = IBL_CONTAINER_KTX2,
        .pixel = IBL_PIXEL_RGBA16F,
        .only = (1u << IBL_OUTPUT_COUNT) - 1,
        .specular = ibl_specular_options_default(),
        .irradiance = ibl_irradiance_options_default(),
        .lut = ibl_lut_options_default(),
        .sh_degree = 2,
        .max_error = NAN,
        .judge = ibl_judge_options_default(),
    };

    /* Enumerations and flags of the library, as ints that the table sets. */
    o.roughness[0] = o.specular.roughness_min;
    o.roughness[1] = o.specular.roughness_max;
    o.method = (int)o.specular.method;
    o.lobe = (int)o.specular.lobe;
    o.mapping = (int)o.specular.mapping;
    o.pdf_mip = o.specular.pdf_mip;
    o.geometry = (int)o.lut.geometry;
    return o;
}

static void defaults(void *settings)
{
    *(ibl_opts *)settings = ibl_opts_default();
}

static int run(const void *settings)
{
    return ibl_bake_run(settings);
}

const ibl_command ibl_bake_command = {
    .usage = "[options] ENV -o DIR",
    .intro =
        "Bakes an equirectangular HDR environment (.hdr, .exr and others; - "
        "reads\n"
        "standard input) into the textures of image-based lighting:\n"
        "  DIR/NAME_specular.EXT    prefiltered cube, one roughness per "
        "level\n"
        "  DIR/NAME_irradiance.EXT  diffuse cube, E/pi\n"
        "  DIR/brdf_lut.EXT         scale and bias of F0 over N.V and "
        "roughness\n"
        "  DIR/NAME.json            spherical harmonics and what was done\n",
    .statuses = "0 done, 1 failed, 2 wrong usage",
    .sections = sections,
    .settings_size = sizeof(ibl_opts),
    .defaults = defaults,
    .take = ibl_opts_take,
    .finish = ibl_opts_finish,
    .run = run,
};
