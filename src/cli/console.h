/* SPDX-License-Identifier: MIT */
/* Messages, progress bar and stage times on standard error; a context that
 * reports there; warnings of several commands. */
#ifndef CLI_CONSOLE_H
#define CLI_CONSOLE_H

#include "cli/common_options.h"
#include "common/process.h"

enum {
    IBL_MAX_STAGES = 64
};

typedef struct ibl_stage_time {
    char name[32];
    double seconds;
} ibl_stage_time;

/* A stage runs from its progress report to that of the next stage, so the times
 * of all stages add up to the total. Times are those of ibl_now. */
typedef struct ibl_console {
    struct ibl_console *front; /* the one that has the screen; NULL: this */
    const char *about; /* with front: what errors and warnings are about */
    bool quiet, verbose;
    bool terminal;     /* draw the bar */
    bool drawn;        /* the bar is on the screen now */
    bool failed;       /* an error was printed */
    double share;      /* that the bar shows */
    double share_from; /* since when it rises */
    double drawn_at;   /* time of the last redraw */
    double begun;      /* start of the first stage */
    double stage_from; /* start of the running stage */
    int running;       /* index of the running stage, or -1 */
    int count;
    ibl_stage_time stages[IBL_MAX_STAGES];
    char error[IBL_LINE_BYTES]; /* the first, with front */
} ibl_console;

void ibl_console_init(ibl_console *c, bool quiet, bool verbose);
/* Begins or continues a stage: its finished share is shown. */
void ibl_console_progress(ibl_console *c, const char *stage, double done);
/* Prints "iblbake: ..." and a newline, but only for the first error: later ones
 * follow from it. Returns false. */
bool ibl_console_fail(ibl_console *c, const char *fmt, ...)
    __attribute__((format(printf, 2, 3)));
/* False, after such a line: output is the file input, or that is not known.
 * other: what to choose another of. */
bool ibl_console_differ(ibl_console *c, const char *input, const char *output,
                        const char *other);
/* ibl_console_fail, as `fail` of an ibl_json_file whose cookie is the console.
 */
void ibl_console_error(void *console, const char *text);
void ibl_console_warn(ibl_console *c, const char *fmt, ...)
    __attribute__((format(printf, 2, 3)));
/* Prints a line if -v was given. */
void ibl_console_info(ibl_console *c, const char *fmt, ...)
    __attribute__((format(printf, 2, 3)));
/* Ends the running stage and erases the bar. */
void ibl_console_finish(ibl_console *c);
/* The same at the end of a command. If it failed without a message, reports
 * that memory ran out; else prints the time of each stage with -v. Returns the
 * exit status. */
int ibl_console_end(ibl_console *c, bool ok);

/* Makes a context with these settings that reports to the console. */
ibl_status ibl_start(const ibl_common *common, ibl_console *console,
                     ibl_ctx **ctx);

/* Waits until the outputs are written, then commits them, unless what
 * was printed on standard output is lost. */
bool ibl_console_commit(ibl_console *console, ibl_outputs *outputs);

/* False, after a line about `what` that ends with the advice, if `need` bytes
 * are more than --max-memory. */
bool ibl_console_fits(ibl_console *console, const ibl_common *common,
                      const char *what, double need, const char *advice);

/* Adds a level's texels to those of sum, which keeps the largest shares. */
void ibl_overflow_add(const ibl_overflow_level *level, ibl_overflow_level *sum);
/* packed: what an engine's file packs the texels into, or NULL. fixed: the
 * pixel format is an engine's. Warns if sum, over the levels of a file, has
 * texels that overflow. */
void ibl_warn_of_overflow(ibl_console *console, const char *file,
                          const ibl_texel_options *texels, const char *packed,
                          bool fixed, const ibl_overflow_level *sum);
/* Warns if a level lost that share of its light, in components that the format
 * makes 0. */
void ibl_warn_of_underflow(ibl_console *console, const char *file,
                           const char *pixel, double lost);

/* Warns if the last level has too few texels to interpolate between them. */
void ibl_warn_of_small_faces(ibl_console *console,
                             const ibl_specular_layout *layout);

#endif
