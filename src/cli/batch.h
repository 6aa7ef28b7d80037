/* SPDX-License-Identifier: MIT */
/* A bake of many environments: what batch.c lists, stamps and bakes. */
#ifndef CLI_BATCH_H
#define CLI_BATCH_H

#include <sys/stat.h>

#include "cli/job.h"

typedef enum ibl_map_state {
    IBL_MAP_WAITS,
    IBL_MAP_KEPT, /* --incremental: it is unchanged */
    IBL_MAP_BAKED,
    IBL_MAP_FAILED
} ibl_map_state;

typedef struct ibl_map {
    char *input;
    char *name; /* of its outputs, below the directory of all: "sub/env" */
    struct stat file; /* st_ino 0: there is none of that name */
    ibl_map_state state;
    double pixels; /* 0: not known before it is read, as are bytes */
    double bytes;  /* of memory that its bake takes, beside the program */
    int threads;   /* that bake it */
    char *printed; /* text for standard output, or NULL */
    char *rule;    /* for the depfile, or NULL */
} ibl_map;

typedef struct ibl_maps {
    ibl_map *list;
    int count;
} ibl_maps;

/* Runs a line with `batch`; returns the exit status. */
int ibl_batch_run(const ibl_cmdline *line);

/* Whether a file in a folder is an environment, by its name: those of high
 * range, and no textures, which may be outputs. */
bool ibl_is_environment(const char *name);
/* Lists the environments of a line: its arguments, what is in those that are
 * folders, and those of --from; with --shard those of that part. False after a
 * message, as of two that make the same files; free them also then. */
bool ibl_maps_list(const ibl_cmdline *line, ibl_console *console,
                   ibl_maps *maps);
void ibl_maps_free(ibl_maps *maps);

/* ---- --incremental ------------------------------------------------------- */

/* The folder of the stamps, in that of the outputs. */
#define IBL_STAMPS ".iblbake"

/* Of jobs whose files have names. */

/* Whether a job's stamp was written for the same options and files, and every
 * file is as it was then. */
bool ibl_stamp_holds(const ibl_job *r);
/* ibl_job_commit; then with --incremental writes the stamp, unless what is read
 * changed after `since`, seconds of the real-time clock. Meanwhile no other run
 * does so, where the file system can lock the folder: a stamp is of the run
 * whose files are there. False after a message. */
bool ibl_stamp_commit(ibl_job *r, double since);

/* Removes the stamps that are of none of the maps, and their outputs, unless
 * they changed since. Returns the number of such maps. */
int ibl_stamps_prune(const char *directory, const ibl_maps *maps,
                     ibl_console *console);

#endif
