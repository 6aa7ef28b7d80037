/* SPDX-License-Identifier: MIT */
/* Standard error: messages, the progress bar, stage times; the context that
 * reports there, and warnings that several commands have. */
#ifndef CLI_CONSOLE_H
#define CLI_CONSOLE_H

#include "cli/common_options.h"
#include "common/stderr_line.h"

enum {
    IBL_MAX_STAGES = 64
};

typedef struct ibl_stage_time {
    char name[32];
    double seconds;
} ibl_stage_time;

/* A stage runs from its first report to the next stage's, so that the times
 * of all of them add up to the whole. */
typedef struct ibl_console {
    bool quiet, verbose;
    bool terminal;     /* draw the bar */
    bool drawn;        /* the bar is on the screen now */
    bool failed;       /* an error was printed */
    double drawn_at;   /* time of the last redraw */
    double begun;      /* of the first stage */
    double stage_from; /* start of the running stage */
    int running;       /* index of the running stage, or -1 */
    int count;
    ibl_stage_time stages[IBL_MAX_STAGES];
} ibl_console;

/* Seconds of a clock that nobody sets. */
double ibl_now(void);

void ibl_console_init(ibl_console *c, bool quiet, bool verbose);
/* An ibl_progress_fn whose cookie is the console. */
void ibl_console_progress(void *console, const char *stage, double done);
/* Prints an error, "iblbake: ..." with a newline, if it is the first, which is
 * the cause of the others. False. */
bool ibl_console_fail(ibl_console *c, const char *fmt, ...)
    __attribute__((format(printf, 2, 3)));
/* The same, for an ibl_json_file whose cookie is the console. */
void ibl_console_error(void *console, const char *text);
void ibl_console_warn(ibl_console *c, const char *fmt, ...)
    __attribute__((format(printf, 2, 3)));
/* Prints the same way what -v asks for. */
void ibl_console_info(ibl_console *c, const char *fmt, ...)
    __attribute__((format(printf, 2, 3)));
/* Ends the running stage and takes the bar off the screen. */
void ibl_console_finish(ibl_console *c);
/* The same at the end of a command. If it failed without a message, there was
 * no memory: prints that. Returns the exit status. */
int ibl_console_end(ibl_console *c, bool ok);
/* Prints the time of each stage. */
void ibl_console_print_times(const ibl_console *c);

/* A context for the settings, that reports to the console. */
ibl_status ibl_start(const ibl_common *common, ibl_console *console,
                     ibl_ctx **ctx);

/* Waits until the outputs are written, and puts them in their places. */
bool ibl_console_commit(ibl_console *console, ibl_outputs *outputs);

/* Adds a level to the sum of several: all their texels, and the largest
 * shares. */
void ibl_overflow_add(const ibl_overflow_level *level, ibl_overflow_level *sum);
/* Warns of a file whose levels together overflow, if they do. */
void ibl_warn_of_overflow(ibl_console *console, const char *file,
                          ibl_pixel pixel, ibl_overflow overflow,
                          const ibl_overflow_level *sum);

/* Warns of levels with so few texels that lookups between them are wrong. */
void ibl_warn_of_small_faces(ibl_console *console,
                             const ibl_specular_layout *layout);

#endif
