/* SPDX-License-Identifier: MIT */
/* iblbake verify: baked files against the exact sums. */
#ifndef CLI_VERIFY_H
#define CLI_VERIFY_H

#include "cli/console.h"
#include "cli/judge.h"
#include "cli/common_options.h"

/* What can be judged, in the order of the table. */
typedef enum ibl_verify_kind {
    IBL_VERIFY_SKYBOX,
    IBL_VERIFY_SPECULAR,
    IBL_VERIFY_IRRADIANCE,
    IBL_VERIFY_LUT,
    IBL_VERIFY_COUNT
} ibl_verify_kind;

/* "skybox", "specular", "irradiance" or "brdf_lut", as in the sidecar. */
const char *ibl_verify_content(ibl_verify_kind kind);

/* Roughness of the levels as --roughness-map has it. */
typedef struct ibl_verify_map {
    int given; /* 0: what the files say, else linear */
    ibl_roughness_map map;
    int count; /* of list; 0: by map */
    double list[IBL_MAX_LEVELS];
} ibl_verify_map;

typedef struct ibl_verify_opts {
    ibl_common common;
    const char *input;                   /* NULL: a table alone */
    const char *directory;               /* NULL: only the files below */
    const char *name;                    /* of the files in directory */
    const char *files[IBL_VERIFY_COUNT]; /* NULL: look in directory */
    char face_names[IBL_FACES][16];
    ibl_verify_map roughness;
    int lobe;       /* 0: what the files say, else GGX; 1 + ibl_lobe */
    double yaw_deg; /* NAN: what the files say, else 0 */
    int axes[3];    /* +-1, 2, 3: our axis that the files' X, Y, Z are */
    int scale;      /* 0: E/pi, 1: E */
    int geometry;   /* 0: what the files say, else smith; 1 + ibl_geometry */
    ibl_judge_options judge;
    const char *json;    /* "-": standard output */
    const char *heatmap; /* NULL: none */
    double max_error;    /* NAN: none */
    char stem[256];      /* holds name when it comes from input */
} ibl_verify_opts;

int ibl_verify_run(const void *opts);

#endif
