/* SPDX-License-Identifier: MIT */
/*
 * iblbake bench: the plan of a run, its measurements and the results.
 *
 * A run is a list of points. A point is one command: a bake of ours with one
 * value on each axis, a variant (the base bake with more options) or a peer
 * (another tool). All points run in turns, A B C A B C, each in a child
 * process; then the output of the last round is judged.
 */
#ifndef CLI_BENCH_H
#define CLI_BENCH_H

#include <jansson.h>
#include <time.h>

#include "cli/common_options.h"
#include "cli/console.h"

enum {
    IBL_BENCH_VALUES = 32, /* values in one list */
    IBL_BENCH_NAMED = 16,  /* variants, peers, environments */
    IBL_BENCH_NAME = 32,   /* bytes of a series' name */
    IBL_BENCH_SERIES = 64, /* series of a point: three, and its stages */
    IBL_BENCH_ROUNDS = 999
};

/* How a bake computes the specular levels. */
typedef enum ibl_bench_method {
    IBL_BENCH_AUTO,
    IBL_BENCH_SPECTRAL,
    IBL_BENCH_SAMPLED, /* with a mip level chosen from the sample's density */
    IBL_BENCH_SAMPLED_NOMIP, /* --pdf-mip no */
    IBL_BENCH_METHODS
} ibl_bench_method;

extern const char *const ibl_bench_method_names[];
/* Whether the samples axis applies to a method: false for the first two. */
bool ibl_bench_takes_samples(int method);

/* The swept axes. While one varies, the others stay at their base value. */
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
/* Writes a value of an axis as its option spells it. */
void ibl_bench_value(int axis, int value, char *text, size_t size);

typedef struct ibl_bench_list {
    ibl_bench_axis axis;
    int count;
    int values[IBL_BENCH_VALUES];
} ibl_bench_list;

/* NAME=TEXT options; each may be given several times. */
typedef struct ibl_bench_names {
    int count;
    char name[IBL_BENCH_NAMED][48];
    const char *text[IBL_BENCH_NAMED];
} ibl_bench_names;

/* Index of the first entry with that name, or -1. */
int ibl_bench_find_name(const ibl_bench_names *names, const char *name);

typedef struct ibl_bench_opts {
    ibl_common common; /* threads and isa apply to the judging */
    int env_count;
    const char *envs[IBL_BENCH_NAMED];
    /* For sources: widths, 0 for none. An empty list means the defaults. */
    ibl_bench_list lists[IBL_BENCH_AXES];
    const char *bake; /* more options for every bake of ours, or NULL */
    ibl_bench_names variants, peers, outputs;
    int full;    /* every combination instead of one axis at a time */
    int formats; /* also every pixel format */
    int rounds;
    double timeout_s;
    int texels;   /* texels judged in each level; 0: no judging */
    int rendered; /* directions of --rendered of verify; 0: not judged so */
    const char *csv, *json, *html;
} ibl_bench_opts;

typedef enum ibl_bench_kind {
    IBL_BENCH_BAKE,
    IBL_BENCH_VARIANT,
    IBL_BENCH_FORMAT, /* the base bake in a pixel format */
    IBL_BENCH_PEER
} ibl_bench_kind;

extern const char *const ibl_bench_kind_names[];

/* One measured quantity over the rounds. */
typedef struct ibl_bench_series {
    char name[IBL_BENCH_NAME];
    double *rounds;           /* one value per round, 0 where not reported */
    double low, median, high; /* low and high are the quartiles */
} ibl_bench_series;

/* The first series of a point; the rest are seconds per stage. */
enum {
    IBL_BENCH_WALL_S,
    IBL_BENCH_CPU_S,
    IBL_BENCH_PEAK_BYTES,
    IBL_BENCH_STAGES
};

/* A map to bake: an environment, original or resampled. */
typedef struct ibl_bench_source {
    int env; /* index of ibl_bench_opts.envs */
    int width, height;
    bool resampled;
    char *path;
} ibl_bench_source;

typedef struct ibl_bench_point {
    char name[64]; /* "auto", "sampled 1024", "auto, size 512", or the variant's
                      or peer's name */
    ibl_bench_kind kind;
    const char *given;      /* options of the variant or command of the peer */
    int source;             /* index in ibl_bench.sources */
    int at[IBL_BENCH_AXES]; /* values of a bake; -1: does not apply */
    unsigned sweeps; /* bit n: the point belongs to the sweep of axis n */
    bool base;
    char **argv; /* from ibl_words_split */
    char *directory;

    ibl_bench_series series[IBL_BENCH_SERIES];
    int series_count;
    size_t output_bytes;   /* total size of all files the command left */
    size_t specular_bytes; /* of that file alone; 0: no sidecar names it */
    ibl_pixel_error loss;  /* of its levels by their pixel format: rms of the
                              nRMSE, mean of the relative errors */

    json_t *levels;        /* from the JSON report; NULL: not judged */
    bool judged;           /* true if a level with roughness > 0 was judged */
    double whole_error;    /* rms of nRMSE over all specular levels */
    double error;          /* rms of nRMSE over the levels with roughness > 0 */
    double worst_p95;      /* worst 95th percentile of the same levels */
    double rendered;       /* mean nRMSE as rendered, if there are rows of it */
    json_t *rendered_rows; /* of verify --rendered; NULL: not judged so */
    bool pareto;           /* on the Pareto front of its map, see bench.c */
} ibl_bench_point;

typedef struct ibl_bench {
    const ibl_bench_opts *opts;
    ibl_console *console;
    const char *directory; /* private; its creator removes it */
    json_t *machine;       /* properties of the machine that affect times */
    char date[32];
    int base[IBL_BENCH_AXES];
    ibl_bench_source *sources;
    int source_count;
    ibl_bench_point *points;
    int point_count;
    double seconds; /* duration of the timing */
} ibl_bench;

/* Runs the whole command; returns the exit status. */
int ibl_bench_run(const void *opts);

/* The machine and its current load; NULL: no memory. */
json_t *ibl_bench_machine(void);

/* The steps of a run, in this order. Each returns false after printing one line
 * on stderr. */
/* Resamples the environments and fills b->sources. Works in a child process to
 * keep this one small: see ibl_child_run. */
bool ibl_bench_sources_make(ibl_bench *b);
/* Fills b->points. */
bool ibl_bench_plan(ibl_bench *b);
/* Fills {env}, {out} and {name} of a point into text, as shell words; for a
 * bake of ours also {layer}, {bake} and {variant}. The caller must free it;
 * NULL: no memory. */
char *ibl_bench_fill(const ibl_bench *b, const ibl_bench_point *p,
                     const char *text);
bool ibl_bench_measure(ibl_bench *b);
/* Checks the arguments for judging a point's output, as far as possible before
 * the point has run. */
bool ibl_bench_check_output(const ibl_bench *b, const ibl_bench_point *p);
bool ibl_bench_judge(ibl_bench *b);

/* Whether a point is compared by error against time: it is judged, its map is
 * not resampled, and it is a peer, a variant or a bake that differs from the
 * base only by method or samples. */
bool ibl_bench_is_rival(const ibl_bench *b, const ibl_bench_point *p);
/* Whether the levels and stages of a point are listed: true for the base, bakes
 * that differ from it only by the method, variants and peers. */
bool ibl_bench_is_special(const ibl_bench *b, const ibl_bench_point *p);

/* ---- reports --------------------------------------------------------- */

void ibl_bench_print(const ibl_bench *b, FILE *to);
/* All measurements, and two texts made from them. The caller must free them;
 * NULL: no memory. */
json_t *ibl_bench_document(const ibl_bench *b);
char *ibl_bench_csv(const json_t *document);
char *ibl_bench_html(const json_t *document);

#endif
