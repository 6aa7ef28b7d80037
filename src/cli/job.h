/* SPDX-License-Identifier: MIT */
/* A job bakes one environment, its source, into sets of outputs: a set for each
 * target. bake.c has its way from the command line to the files. */
#ifndef CLI_JOB_H
#define CLI_JOB_H

#include "cli/console.h"
#include "cli/judge.h"
#include "cli/scenes.h"
#include "cli/targets.h"
#include "engine/engine.h"
#include "engine/harmonics.h"
#include "engine/picture.h"

/* Whether there is a lobe table. */
typedef enum ibl_lobes {
    IBL_LOBES_PRIOR,
    IBL_LOBES_NO,
    IBL_LOBES_USUAL /* if the levels are GGX */
} ibl_lobes;

enum {
    IBL_ALL_OUTPUTS = (1 << IBL_OUTPUT_COUNT) - 1,
    IBL_MAX_FACES = IBL_FACES * (IBL_MAX_LEVELS + 2), /* and of other cubes */
    IBL_LIGHTS_AUTO = -1
};

/* How a bake of many environments reports its progress. */
typedef enum ibl_progress_kind {
    IBL_PROGRESS_AUTO, /* a line on standard error if that is a terminal */
    IBL_PROGRESS_JSON  /* JSON objects on standard output, one a line */
} ibl_progress_kind;

/* The options of a set of files. Strings point into argv; name may point to
 * stem. */
typedef struct ibl_opts {
    ibl_common common;
    unsigned targets;     /* those of --target, of ibl_targets_parse */
    int explain;          /* 1: print how the target loads its files */
    int preset;           /* in the names of --preset; 0: none */
    const ibl_target *of; /* the one of this set; NULL: none */
    const char *input;    /* "-": standard input; NULL: none (only the LUT) */
    const char *directory;
    const char *name;
    int file; /* what --format says, in ibl_format_names */
    ibl_container format;
    ibl_engine engine;        /* the files are an engine's own; or NONE */
    ibl_picture picture;      /* the files are pictures; or NONE */
    ibl_tone tone;            /* of PNG */
    int layout;               /* in ibl_layout_names */
    int zstd;                 /* level of Zstandard; 0: none */
    ibl_texel_options texels; /* of the cubes */
    unsigned only;            /* bit n: ibl_output_kind n is wanted */
    unsigned asked;           /* the same before what there is none of */
    int prefiltered;          /* 1: the environment may be a baked map */
    ibl_bake_options bake;
    ibl_axes axes; /* of the outputs */
    ibl_sh_format sh_format;
    double sh_window; /* of ibl_sh_window; 0: the widest without ringing */
    int lights;       /* most that are taken out of the environment, or AUTO */
    ibl_lut_options lut;
    ibl_lobes lobe_table;
    int lobe_table_size;
    ibl_f0 lobe_f0; /* of the lobe table; by the scene */
    const char *preview;
    const char *depfile;
    int sync; /* 1: flush the files to the disk */
    int verify;
    double max_error; /* limit for verify; NAN: none */
    ibl_scene_list scenes;
    double rendered_error; /* what the choice is for; NAN: nothing is chosen */
    int dry_run;           /* 1: only print the choice */
    const char *from;      /* a list of environments; NULL: none */
    int recursive;
    int keep_going;
    ibl_shard shard;
    int incremental;
    int prune;
    ibl_progress_kind progress;
    ibl_judge_options judge;
    char stem[IBL_STEM_BYTES]; /* input's name without directory, extension */
    const char *below; /* the same in a batch, below directory: "sub/env" */
    ibl_given given;
} ibl_opts;

/* The command line: options of one set, or of a set for each target, which are
 * equal in all that is of no set. */
typedef struct ibl_cmdline {
    ibl_opts set[IBL_MAX_TARGETS]; /* the first as the parser's settings */
    int count;                     /* of sets; 1 without targets */
    char **words;
    bool batch;         /* many environments, or what is done for many */
    const char **given; /* the arguments that are environments or folders */
    int given_count;
} ibl_cmdline;

/* An output. paths and count are set before the bake, the rest when it is
 * written. */
typedef struct ibl_output {
    char **paths;             /* of its files; NULL: not wanted */
    int count;                /* of files */
    size_t bytes;             /* of all */
    char hash[IBL_FILE_HASH]; /* of the first */
    ibl_texture shape;        /* of the texture, without data and keys */
    ibl_overflow_report overflow;
    ibl_pixel_error error[IBL_MAX_LEVELS]; /* of cubes */
} ibl_output;

/* A set of files of a job. It owns its files' paths, tables and report. */
typedef struct ibl_output_set {
    const ibl_opts *opts;
    struct ibl_job *job;
    /* The set of another job that has the tables that environments share, and
     * owns lut and lobes; NULL: they are this one's. */
    const struct ibl_output_set *tables;
    char *root;           /* of what all maps share */
    char *directory;      /* of the others: the root, or a folder below it */
    int chain;            /* of the levels of all sets; -1: none */
    ibl_bake_result made; /* its part of what the job has, in the world's
                             axes, but sh in those of its outputs */
    double *sh;           /* made.sh if that is the set's own, else NULL */
    ibl_choice *choice;   /* NULL: none was asked */
    ibl_lut lut;
    ibl_lobe_table_options lobe_table; /* for the set's levels */
    ibl_lobe_table lobes;              /* empty if not wanted */
    ibl_report judged;                 /* empty without --verify */
    ibl_output files[IBL_OUTPUT_COUNT];
    char *sh_path; /* of --sh-format; NULL: none */
} ibl_output_set;

/* A bake of one environment: the sets, and what they are made from. line,
 * console, ctx, verdicts, tables and maps are set before it begins. */
typedef struct ibl_job {
    const ibl_cmdline *line;
    const ibl_opts *opts; /* the first set's: what all have in common counts */
    ibl_console console;
    ibl_ctx *ctx;
    char **verdicts; /* takes the tables of --verify; NULL: they are printed */
    const ibl_output_set *tables; /* of each set; NULL: it makes its own */
    const struct ibl_maps *maps;  /* all of the batch, or NULL */
    ibl_output_set *sets;
    int count;
    ibl_outputs *outputs;
    ibl_scenes *scenes; /* that were read, or NULL */
    ibl_opts sheen;     /* of a set that a scene needs beside the one */
    int width, height;  /* of the environment, in pixels */
    ibl_specular_options chains[IBL_MAX_TARGETS]; /* all different */
    ibl_bake_options need; /* what all sets need: specular is the first chain,
                              more are the others */
    ibl_image env;         /* the environment, for --verify and --preview */
    ibl_image rest;        /* the environment without lights, for --verify */
    ibl_light lights[IBL_MAX_LIGHTS]; /* what was taken, the strongest first */
    int light_count;
    ibl_read_report report; /* of reading the environment */
    ibl_judge *judge[2];    /* by env and by rest; NULL until --verify judges a
                               cube by it */
    ibl_bake_result made;   /* cubes and coefficients of all sets, specular of
                               the first chain; empty if not wanted */
} ibl_job;

/* Whether an output is asked for. */
static inline bool ibl_opts_want(const ibl_opts *o, ibl_output_kind kind)
{
    return o->only & 1u << kind;
}

/* Whether nothing that is wanted depends on an environment. */
bool ibl_opts_of_none(const ibl_opts *o);
/* Switches off the parts of the bake that no output needs. */
void ibl_opts_select(ibl_opts *o);
/* These refuse, after a line on stderr, options that cannot be together; those
 * with which a target's engine would not load the files, or show them wrongly
 * (want: the target's own options); options that mean nothing in any set. */
bool ibl_opts_check(const ibl_opts *o);
bool ibl_opts_fit_target(const ibl_opts *o, const ibl_opts *want);
bool ibl_opts_check_uses(const ibl_cmdline *line);

/* Runs the bake with settings, an ibl_cmdline; returns the exit status. */
int ibl_bake_run(const void *settings);

/* ---- the steps of a job ------------------------------------------------- */

/* Begins its sets and names their files. ibl_job_end, which leaves the context,
 * is needed then. The others return false after a message. */
void ibl_job_begin(ibl_job *r);
/* Does everything else, but leaves the files beside their places. */
bool ibl_job_make(ibl_job *r);
bool ibl_job_commit(ibl_job *r);
/* Logs what was read and written. */
void ibl_job_log(ibl_job *r);
void ibl_job_end(ibl_job *r);

/* Checks the files of all sets, whose directories must exist. False: one cannot
 * be written, or would replace the input or, without --name, the outputs of
 * another environment. */
bool ibl_job_plan(ibl_job *r);
/* Checks that --depfile can name the files, and is none of them. */
bool ibl_job_check_depfile(ibl_job *r);
/* Bytes of memory that a bake takes of a map of that size whose source takes
 * `reader` bytes (ibl_source_memory); 0 after a message. */
double ibl_bake_bytes(const ibl_job *r, size_t reader, int width, int height);
/* Hands all outputs of a set to the job's files. Judges them if --verify asks
 * for it. */
bool ibl_set_write(ibl_output_set *b);

/* ---- files -------------------------------------------------------------- */

/* Sets the paths of every output that is wanted, in place of those it had. */
void ibl_set_name_files(ibl_output_set *b);
void ibl_set_forget_names(ibl_output_set *b);

typedef struct ibl_files {
    char **path;
    int count, inputs; /* the first `inputs` are read, the others made */
} ibl_files;

/* Lists the files of a job but the depfile; `shared` with those that are the
 * same for all environments. False, after a message: a pattern of the
 * environment fits none. Free them also then. */
bool ibl_job_files(const ibl_job *r, bool shared, ibl_files *files);
void ibl_files_free(ibl_files *files);

/* A rule "outputs: inputs" for make and ninja. The caller must free the text;
 * NULL: as of ibl_job_files. */
char *ibl_depfile_text(const ibl_job *r);

/* Whether an output is the same for all environments. */
bool ibl_set_is_shared(const ibl_opts *o, ibl_output_kind kind);
/* Whether any file of a set has the name of its environment. */
bool ibl_set_is_named(const ibl_opts *o);
/* Whether it is one that another job has for all environments. */
static inline bool ibl_set_takes(const ibl_output_set *b, ibl_output_kind kind)
{
    return b->tables && ibl_set_is_shared(b->opts, kind);
}

/* ---- what is written ---------------------------------------------------- */

/* Encodes a texture as the pictures of an output. Of options, kind, tone, cross
 * and equirect are set. */
bool ibl_output_pictures(ibl_output *file, ibl_ctx *ctx, ibl_outputs *to,
                         const ibl_texture *tex, ibl_picture_options options);
/* Warns of light that the texels of an output cannot hold; packed and fixed as
 * in ibl_warn_of_overflow. */
void ibl_output_warn(const ibl_output *file, ibl_console *console,
                     const ibl_texel_options *texels, const char *packed,
                     bool fixed);

/* What a set's files make of texels of that format. */
const char *ibl_baked_pixel(const ibl_opts *o, ibl_pixel pixel);

/*
 * A contact sheet as a PNG file: the environment, each specular level, the
 * skybox and the irradiance as unfolded cubes (+Y on top, -X +Z +X -Z in the
 * middle row, -Y below), the LUT with N.V to the right and roughness upwards.
 * All radiance has the same exposure. The caller must free its bytes.
 */
ibl_blob ibl_preview_png(const ibl_output_set *b);

#endif
