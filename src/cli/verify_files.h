/* SPDX-License-Identifier: MIT */
/* Baked files, by iblbake or other programs, read for judging. */
#ifndef CLI_VERIFY_FILES_H
#define CLI_VERIFY_FILES_H

#include "cli/console.h"
#include "cli/judge_report.h"
#include "cli/rendered.h"

enum {
    IBL_VERIFY_KINDS = IBL_OUTPUT_LOBES + 1 /* outputs that can be judged */
};

/* Roughness of the levels as given by --roughness-map. */
typedef struct ibl_verify_map {
    int given; /* 0: use the files', else linear */
    ibl_roughness_map map;
    int count; /* length of list; 0: use map */
    double list[IBL_MAX_LEVELS];
} ibl_verify_map;

/* The lod of a roughness as given by --lod. */
typedef struct ibl_verify_lod {
    int given;   /* 0: use the files' */
    ibl_lod lod; /* of layout only the mapping */
} ibl_verify_lod;

/* The command line of iblbake verify. */
typedef struct ibl_verify_opts {
    ibl_common common;
    const char *input;     /* the environment; NULL: judge only a table */
    const char *directory; /* NULL: use only files */
    const char *name;      /* base name of the files in directory */
    const char *probe;     /* for messages: of a set's probe, or NULL */
    int layer;             /* of arrays of cubes; -1: none */
    const char *files[IBL_VERIFY_KINDS]; /* by kind; NULL: search */
    char face_names[IBL_FACES][16];
    ibl_verify_map roughness;
    int lobe;       /* 1 + ibl_lobe; 0: use the files', else GGX */
    double yaw_deg; /* NAN: use the files', else 0 */
    int axes[3];    /* our axis for the files' X, Y, Z: +-1, +-2, +-3; 0: use
                       what the files say, else ours */
    int scale;      /* 0: E/pi, 1: E */
    int table;      /* 1 + ibl_lut_kind; 0: use the files', else split */
    int geometry;   /* 1 + ibl_geometry; 0: use the files', else smith */
    int lights;     /* -1: use the files', else 0 */
    ibl_judge_options judge;
    int rendered; /* 1: judge what a shader draws, not texels */
    ibl_truth_options shading;
    ibl_shader shader;
    ibl_verify_lod lod;
    double max_rendered_error; /* NAN: no limit */
    const char *json;          /* "-": standard output */
    const char *heatmap;       /* NULL: none */
    double max_error;          /* largest accepted error; NAN: no limit */
    char stem[256];            /* buffer of name if it comes from input */
    ibl_given given;
} ibl_verify_opts;

typedef struct ibl_verify_files {
    char *path[IBL_VERIFY_KINDS]; /* file or pattern; NULL: none */
    int count;                    /* number of levels, sorted by kind */
    ibl_judge_level level[IBL_REPORT_ROWS];
    ibl_cube cube[IBL_REPORT_ROWS]; /* one level each, in our axes; their texels
                                       are in owned */
    ibl_cube owned[IBL_REPORT_ROWS];
    int owned_count;
    ibl_lut lut; /* empty if there is none */
    ibl_pixel lut_pixel;
    ibl_geometry geometry;
    ibl_lobe_table lobes; /* empty if there is none */
    double yaw_deg;
    ibl_read_options read; /* of the environment */
    ibl_lod lod;           /* of the specular chain */
    int lights; /* taken out of all but the skybox; -1: unknown so far */
} ibl_verify_files;

/* Finds and reads the files that opts names, and what describes them. False
 * after one message. ibl_verify_files_free is needed also then. */
bool ibl_verify_files_read(const ibl_verify_opts *opts, ibl_ctx *ctx,
                           ibl_console *console, ibl_verify_files *files);
/* Whether `more` bytes for the file of that name have room in --max-memory
 * beside what was read. False after a message. */
bool ibl_verify_fits(const ibl_verify_opts *opts, ibl_console *console,
                     const ibl_verify_files *files, const char *name,
                     double more);
void ibl_verify_files_free(ibl_verify_files *files);

/* Judges every level and the table by the report's options. map was read with
 * the files' yaw and lights, or is zeroed if there is only a table. False: as
 * for ibl_report_add. */
bool ibl_verify_judge(const ibl_verify_files *files, ibl_ctx *ctx,
                      const ibl_judged_map *map, ibl_console *console,
                      ibl_report *report);

#endif
