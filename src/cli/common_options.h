/* SPDX-License-Identifier: MIT */
/* The commands, and the options that they share. */
#ifndef CLI_COMMON_OPTIONS_H
#define CLI_COMMON_OPTIONS_H

#include <ibl/ibl.h>
#include <ibl/io.h>

#include "common/option.h"

extern const ibl_command ibl_bake_command;
extern const ibl_command ibl_verify_command;
extern const ibl_command ibl_bench_command;
extern const ibl_command ibl_probes_command;
extern const ibl_command ibl_info_command;
extern const ibl_command ibl_convert_command;

/* The first member of every command's settings. */
typedef struct ibl_common {
    ibl_read_options read;
    int threads;
    ibl_isa isa;
    size_t max_memory; /* bytes; 0: not given */
    int quiet;
    int verbose;
} ibl_common;

extern const ibl_section ibl_input_section; /* sets read of ibl_common */
/* The names of its options, for rules. */
#define IBL_INPUT_OPTIONS                                                      \
    "layer part any-aspect input-layout face-order input-transfer strict "     \
    "primaries exposure clamp"
extern const ibl_section ibl_running_section; /* the rest, --help, --version */

/* Rows of a table for ibl_texel_options texels of IBL_SETTINGS. */
/* clang-format off */
#define IBL_TEXEL_OPTIONS \
    {"quality", 0, IBL_CHOICE(texels.quality, ibl_quality_names), \
     .help = "of bc6h, uastc-hdr and astc4x4hdr: more time, less error"}, \
    {"overflow", 0, IBL_CHOICE(texels.overflow, ibl_overflow_names), \
     .help = "light above the largest value of the pixel format: spread over " \
             "the texels around it, or clip"}, \
    {"largest", 0, IBL_REAL(texels.largest, "MAX", 1e-6, 1e30), \
     .standard = "what the pixel format holds", \
     .help = "treat light above MAX in the same way"},
/* clang-format on */

ibl_common ibl_common_default(void);
/* Bytes of the program and its libraries. */
#define IBL_PROGRAM_BYTES (12.0 * (1 << 20))
/* Bytes that may be taken; 0: no limit is known. */
size_t ibl_memory_most(const ibl_common *c);
bool ibl_common_validate(const ibl_common *c);
/* What decides what is made beside the inputs: program, arithmetic, and the
 * command's options that were given and are not aside. The caller must free it.
 */
char *ibl_settings_text(ibl_isa isa, const ibl_command *command,
                        const ibl_given *given);
/* The outputs of a bake, in the order in which they are made. */
typedef enum ibl_output_kind {
    IBL_OUTPUT_SKYBOX,
    IBL_OUTPUT_SPECULAR,
    IBL_OUTPUT_IRRADIANCE,
    IBL_OUTPUT_LUT,
    IBL_OUTPUT_LOBES,
    IBL_OUTPUT_JSON,
    IBL_OUTPUT_COUNT
} ibl_output_kind;

/* "skybox", "specular", "irradiance", "lut", "lobe-table" or "json". */
extern const char *const ibl_output_names[];
/* The same name in sidecars and keys, where "lut" is "brdf_lut" and
 * "lobe-table" is "lobe_lut". */
const char *ibl_output_content(ibl_output_kind kind);

/* The pixel of the LUT: rg32f if the cubes have rgba32f, else rg16f. */
ibl_pixel ibl_lut_pixel(ibl_pixel cubes, ibl_lut_kind kind);

/* The number of levels of a cube of this size down to 1x1. */
int ibl_most_levels(int size);

enum {
    IBL_STEM_BYTES = 256
};
/* Copies input's name without directory, extension and, of a pattern of files,
 * %f; "env" for standard input, a list of files or NULL. False, after a line on
 * stderr: it does not fit. */
bool ibl_stem(const char *input, char *stem, size_t size);

/* --shard K/N: a part of the work of one command, for N runs on any machines.
 */
enum {
    IBL_MOST_SHARDS = 65536
};
#define IBL_SHARD_ALLOWED "1/1 to 65536/65536, K at most N"

typedef struct ibl_shard {
    int number; /* 1..count */
    int count;  /* 0: no --shard was given */
} ibl_shard;

/* Parses "K/N" into an ibl_shard. */
bool ibl_shard_parse(void *shard, const char *value);
/* Whether a shard has item i of a command: every count-th, from the number-th
 * on; all without --shard. */
bool ibl_shard_has(const ibl_shard *shard, int i);

/* The build defines IBL_REVISION, from git describe; "": unknown. */
#if defined(__clang__)
#define IBL_COMPILER "clang " __clang_version__
#elif defined(__GNUC__)
#define IBL_COMPILER "gcc " __VERSION__
#else
#define IBL_COMPILER "unknown"
#endif

#endif
