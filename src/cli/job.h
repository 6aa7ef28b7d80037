/* SPDX-License-Identifier: MIT */
/* A job bakes one environment, its source, into sets of outputs: a set for each
 * target. bake.c has its way from the command line to the files. */
#ifndef CLI_JOB_H
#define CLI_JOB_H

#include "cli/console.h"
#include "cli/judge.h"
#include "cli/scenes.h"
#include "cli/shard.h"
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
    int filament;             /* 1: KTX as Filament reads it: ibl_texture */
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
    int sync;    /* 1: flush the files to the disk */
    int timings; /* 1: write stage times into the sidecar */
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

/* An output file. path is set before the bake, the rest when the file is
 * written. */
typedef struct ibl_output {
    char *path;               /* NULL: not wanted; the first of several */
    char **more;              /* paths of the others, in ibl_output_set.faces */
    int count;                /* of files */
    size_t bytes;             /* of the file */
    char hash[IBL_FILE_HASH]; /* of the first */
    ibl_texture shape;        /* of the texture, without data and keys */
    ibl_overflow_report overflow;
    ibl_pixel_error error[IBL_MAX_LEVELS]; /* of cubes */
} ibl_output;

/* The environment of a bake, and what its sets of files are made from. */
typedef struct ibl_bake_source {
    const ibl_opts *opts; /* those that all sets have in common count */
    ibl_console *console;
    const struct ibl_job *run; /* that reads it */
    FILE *print; /* for the report of --verify; NULL: it is not judged */
    ibl_ctx *ctx;
    ibl_bake_options bake;                        /* all that any set needs */
    ibl_specular_options chains[IBL_MAX_TARGETS]; /* of levels, all different */
    int chain_count;
    int width, height; /* in pixels */
    ibl_image env;     /* the environment, for --verify and --preview */
    ibl_image rest;    /* the environment without lights, for --verify */
    ibl_light lights[IBL_MAX_LIGHTS]; /* what was taken, the strongest first */
    int light_count;
    ibl_read_report report; /* of reading the environment */
    ibl_scenes *scenes;     /* that were read, or NULL */
    ibl_judge *judge[2];    /* by env and by rest; NULL until --verify judges a
                               cube by it */
    ibl_bake_result made;   /* cubes and coefficients, specular of the first
                               chain; empty if not wanted */
} ibl_bake_source;

/* A set of files of a bake. It owns its files' paths, tables and report. */
typedef struct ibl_output_set {
    const ibl_opts *opts;
    ibl_console *console;
    ibl_ctx *ctx;
    ibl_outputs *outputs;
    ibl_bake_source *from;
    /* The set of another bake that has the tables that environments share, and
     * owns lut and lobes; NULL: they are this bake's. */
    const struct ibl_output_set *tables;
    char *root;           /* of what all maps share */
    char *directory;      /* of the others: the root, or a folder below it */
    int chain;            /* of the source's chains; -1: none */
    ibl_bake_result made; /* its part of what the source has, in the world's
                             axes, but sh in those of its outputs */
    double *sh;           /* made.sh if that is the set's own, else NULL */
    ibl_choice *choice;   /* NULL: none was asked */
    ibl_lut lut;
    ibl_lobe_table lobes;            /* empty if not wanted */
    ibl_specular_layout lobe_layout; /* of the chain of the lobe table */
    ibl_report judged;               /* empty without --verify */
    ibl_output files[IBL_OUTPUT_COUNT];
    char *sh_path;              /* of --sh-format; NULL: none */
    char *faces[IBL_MAX_FACES]; /* paths of other files than the first */
    int face_count;
} ibl_output_set;

/* A bake of one environment: its sets, and what they are made from. line,
 * console, from.ctx, from.print and tables are set before it begins. */
typedef struct ibl_job {
    const ibl_cmdline *line;
    const ibl_opts *opts; /* the first set's */
    ibl_console console;
    ibl_bake_source from;
    ibl_outputs *outputs;
    ibl_output_set *sets;
    const ibl_output_set *tables; /* of each set; NULL: it makes its own */
    const struct ibl_maps *maps;  /* all of the batch, or NULL */
    ibl_choice *choices;          /* of each set; NULL: none are asked */
    ibl_opts sheen; /* of a set that a scene needs beside the one */
    int count;
} ibl_job;

/* Bytes of memory that a bake takes of a map of that size whose source takes
 * `reader` bytes (ibl_source_memory); 0 after a message. */
double ibl_bake_bytes(const ibl_job *r, size_t reader, int width, int height);
/* False, after a message, if that is more than --max-memory. */
bool ibl_bake_fits(const ibl_job *r, size_t reader, int width, int height);

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

/* These return false after a message, or if memory ran out. ibl_job_end, which
 * leaves the context, is needed also then. */
bool ibl_job_begin(ibl_job *r);
/* Names the files, without making any. */
bool ibl_job_names(ibl_job *r);
/* Does everything else, but leaves the files beside their places. */
bool ibl_job_make(ibl_job *r);
bool ibl_job_commit(ibl_job *r);
/* Logs what was read and written. */
void ibl_job_log(const ibl_job *r);
void ibl_job_end(ibl_job *r);

/* Adds what a set needs to what is baked, and sets its chain. */
void ibl_bake_source_add(ibl_bake_source *s, ibl_output_set *set);

/* Reads the environment, and takes lights out of it. ibl_bake_source_free is
 * needed also after a failure. */
bool ibl_bake_source_read(ibl_bake_source *s);

/* Reads the environment, if there is one and it was not read, and bakes. */
bool ibl_bake_source_make(ibl_bake_source *s);
void ibl_bake_source_free(ibl_bake_source *s);

/* What a set's files make of texels of that format. */
const char *ibl_baked_pixel(const ibl_opts *o, ibl_pixel pixel);

/* Sets the keys of a texture: see FILES in the manual page. */
bool ibl_texture_metadata(const ibl_output_set *b, ibl_output_kind kind,
                          ibl_texture *tex);

/* Those of the lobe table, of b->lobe_layout. */
ibl_lobe_table_options ibl_bake_lobe_options(const ibl_output_set *b);

/* The text of NAME.json: see FILES in the manual page. Without --timings it has
 * neither threads nor times, so equal bakes give equal bytes. The caller must
 * free it with ibl_bytes_free; NULL: no memory, perhaps after a message. */
char *ibl_set_sidecar(const ibl_output_set *b);

/*
 * A contact sheet as a PNG file: the environment, each specular level, the
 * skybox and the irradiance as unfolded cubes (+Y on top, -X +Z +X -Z in the
 * middle row, -Y below), the LUT with N.V to the right and roughness upwards.
 * All radiance has the same exposure. The caller must free *png. False: no
 * memory.
 */
bool ibl_preview_png(const ibl_output_set *b, void **png, size_t *size);

/* Whether an output is the same for all environments. */
bool ibl_set_is_shared(const ibl_opts *o, ibl_output_kind kind);

enum {
    IBL_SET_PATHS = IBL_OUTPUT_COUNT + 1 + IBL_MAX_FACES /* files of a set */
};
/* Lists the files of a set, without `shared` only those of its environment;
 * returns their number. */
int ibl_set_files(const ibl_output_set *b, bool shared,
                  const char *paths[IBL_SET_PATHS]);
/* Lists the files of the environment: 1 or 6, 0 for standard input or nothing;
 * free them with ibl_input_files_free. IBL_ERR_IO, after a message: a pattern
 * fits none. */
ibl_status ibl_set_inputs(const ibl_output_set *b, char *files[IBL_FACES],
                          int *count);

/* Sets the path of every wanted file. False, after a message: no memory. */
bool ibl_set_name_files(ibl_output_set *b);

/* Does so for all sets, whose directories must exist. False, after a message: a
 * file cannot be written, or would replace the input or, without --name, the
 * outputs of another environment. */
bool ibl_bake_plan(ibl_output_set *sets, int count);

/* Checks that --depfile can name the files of all sets, whose names are known,
 * and is none of them. False after a message. */
bool ibl_bake_check_depfile(const ibl_output_set *sets, int count);

/* A rule "outputs: input" for make and ninja, without the input if it is
 * standard input. The caller must free the text; NULL: no memory. */
char *ibl_depfile_text(const ibl_output_set *sets, int count);

/* Whether an output is a table that another job has for all environments. */
static inline bool ibl_set_takes(const ibl_output_set *b, ibl_output_kind kind)
{
    return b->tables && ibl_set_is_shared(b->opts, kind);
}
/* Hands all outputs of a set, of what its source has, to the job's files.
 * Judges them if --verify asks for it. False after a message, or if memory ran
 * out. */
bool ibl_set_write(ibl_output_set *b);
/* Adds a text to the files, and frees it; NULL: there was no memory for `what`.
 */
bool ibl_set_write_text(ibl_output_set *b, const char *path, char *text,
                        const char *what);

#endif
