/* SPDX-License-Identifier: MIT */
/*
 * iblbake bench: what is measured, and the results.
 *
 * A run is a list of points. A point is one command: a bake of ours with one
 * setting of everything that is swept, a variant (the base bake with more
 * options) or a peer (another tool). All points run in turns, A B C A B C,
 * each in a child process; then the output of the last round is judged.
 */
#ifndef CLI_BENCH_H
#define CLI_BENCH_H

#include <jansson.h>
#include <time.h>

#include "cli/common_options.h"
#include "cli/console.h"

enum {
    IBL_BENCH_VALUES = 32, /* of one list */
    IBL_BENCH_NAMED = 16,  /* variants, peers, environments */
    IBL_BENCH_NAME = 32,   /* bytes of the name of a quantity */
    IBL_BENCH_SERIES = 64, /* quantities of a point: three, and its stages */
    IBL_BENCH_ROUNDS = 999
};

/* What a bake computes the specular levels with. */
typedef enum ibl_bench_method {
    IBL_BENCH_AUTO,
    IBL_BENCH_SPECTRAL,
    IBL_BENCH_SAMPLED,       /* mip level of a lookup by the sample's density */
    IBL_BENCH_SAMPLED_NOMIP, /* --pdf-mip no */
    IBL_BENCH_METHODS
} ibl_bench_method;

extern const char *const ibl_bench_method_names[];
/* Whether samples are swept with it: not with the first two. */
bool ibl_bench_takes_samples(int method);

/* What is swept; the values of one axis are those of the others' base. */
typedef enum ibl_bench_axis {
    IBL_BENCH_METHOD,
    IBL_BENCH_SAMPLES,
    IBL_BENCH_SIZE,
    IBL_BENCH_THREADS,
    IBL_BENCH_ISA,
    IBL_BENCH_SOURCE,
    IBL_BENCH_AXES
} ibl_bench_axis;

/* "method", "samples", "size", "threads", "isa", "source". */
const char *ibl_bench_axis_name(int axis);
/* A value of an axis as its option has it. */
void ibl_bench_value(int axis, int value, char *text, size_t size);

typedef struct ibl_bench_list {
    ibl_bench_axis axis;
    int count;
    int values[IBL_BENCH_VALUES];
} ibl_bench_list;

/* NAME=TEXT options, each may be given several times. */
typedef struct ibl_bench_names {
    int count;
    char name[IBL_BENCH_NAMED][48];
    const char *text[IBL_BENCH_NAMED];
} ibl_bench_names;

/* The first of that name; -1: none. */
int ibl_bench_find_name(const ibl_bench_names *names, const char *name);

typedef struct ibl_bench_opts {
    ibl_common common; /* threads and isa: of the judging */
    int env_count;
    const char *envs[IBL_BENCH_NAMED];
    /* Sources: widths, 0 for none; without values: defaults. */
    ibl_bench_list lists[IBL_BENCH_AXES];
    const char *bake; /* more options of every bake of ours, or NULL */
    ibl_bench_names variants, peers, outputs;
    int full; /* every combination, not one axis at a time */
    int rounds;
    double timeout_s;
    int texels; /* judged in each level; 0: no judging */
    const char *csv, *json, *html;
} ibl_bench_opts;

typedef enum ibl_bench_kind {
    IBL_BENCH_BAKE,
    IBL_BENCH_VARIANT,
    IBL_BENCH_PEER
} ibl_bench_kind;

extern const char *const ibl_bench_kind_names[];

/* A measured quantity over the rounds. */
typedef struct ibl_bench_series {
    char name[IBL_BENCH_NAME];
    double *rounds;           /* 0 where a round did not report it */
    double low, median, high; /* low, high: the quartiles */
} ibl_bench_series;

/* The first of a point's series; the others are seconds of its stages. */
enum {
    IBL_BENCH_WALL_S,
    IBL_BENCH_CPU_S,
    IBL_BENCH_PEAK_BYTES,
    IBL_BENCH_STAGES
};

/* A map that is baked: an environment, or one resampled. */
typedef struct ibl_bench_source {
    int env; /* index of ibl_bench_opts.envs */
    int width, height;
    bool resampled;
    char *path;
} ibl_bench_source;

typedef struct ibl_bench_point {
    char name[64]; /* "auto", "sampled 1024", "auto, size 512", the variant's,
                      the peer's */
    ibl_bench_kind kind;
    const char *given;      /* the variant's options, the peer's command */
    int source;             /* of ibl_bench.sources */
    int at[IBL_BENCH_AXES]; /* settings of a bake; -1: does not apply */
    unsigned sweeps;        /* bit n: this point belongs to axis n's sweep */
    bool base;
    char **argv; /* of ibl_words_split */
    char *directory;

    ibl_bench_series series[IBL_BENCH_SERIES];
    int series_count;
    size_t output_bytes; /* of all files that it left */

    json_t *levels;   /* of the JSON report; NULL: not judged */
    bool judged;      /* and has specular levels with r > 0: */
    double error;     /* rms over these of nRMSE */
    double worst_p95; /* worst 95th percentile of these */
    bool pareto;      /* no other point of this map is faster and better */
} ibl_bench_point;

typedef struct ibl_bench {
    const ibl_bench_opts *opts;
    ibl_console *console;
    const char *directory; /* private, removed by its maker */
    json_t *machine;       /* what the times depend on */
    char date[32];
    int base[IBL_BENCH_AXES];
    ibl_bench_source *sources;
    int source_count;
    ibl_bench_point *points;
    int point_count;
    double seconds; /* that the timing took */
} ibl_bench;

/* The whole command; returns the exit status. */
int ibl_bench_run(const void *opts);

/* The machine and its load now; NULL: no memory. */
json_t *ibl_bench_machine(void);

/* The parts of a run, in this order. They return false after one line on
 * stderr. */
/* Resamples the environments: fills b->sources. In a child process, so that
 * this one stays small: see ibl_child_run. */
bool ibl_bench_sources_make(ibl_bench *b);
/* Fills b->points. */
bool ibl_bench_plan(ibl_bench *b);
/* text with {env}, {out} and {name} of a point filled in, as words of a shell;
 * of a bake of ours also {layer}, {bake} and {variant}. For free(); NULL: no
 * memory. */
char *ibl_bench_fill(const ibl_bench *b, const ibl_bench_point *p,
                     const char *text);
bool ibl_bench_measure(ibl_bench *b);
/* Checks the arguments that a point's output is judged by, as far as possible
 * before it has run. */
bool ibl_bench_check_output(const ibl_bench *b, const ibl_bench_point *p);
bool ibl_bench_judge(ibl_bench *b);

/* Whether a point counts for error against time: judged, on a map as it is,
 * and a peer, a variant or a bake that differs from the base only by method or
 * samples. */
bool ibl_bench_is_rival(const ibl_bench *b, const ibl_bench_point *p);
/* Whether a point has its levels and stages listed: the base, bakes that
 * differ from it only by the method, variants and peers. */
bool ibl_bench_is_special(const ibl_bench *b, const ibl_bench_point *p);

/* ---- reports --------------------------------------------------------- */

void ibl_bench_print(const ibl_bench *b, FILE *to);
/* All that was measured, and texts of it, for free(); NULL: no memory. */
json_t *ibl_bench_document(const ibl_bench *b);
char *ibl_bench_csv(const json_t *document);
char *ibl_bench_html(const json_t *document);

#endif
