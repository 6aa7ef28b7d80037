/* SPDX-License-Identifier: MIT */
/* Notices when a file is replaced or written anew. */
#ifndef VIEW_FILE_STAMP_H
#define VIEW_FILE_STAMP_H

#include <stdbool.h>
#include <time.h>

typedef struct view_file_stamp {
    struct timespec written;
    long long size, inode; /* size -1: there is no file */
} view_file_stamp;

/* Of the file at path; NULL: none. *age, unless age is NULL: seconds since it
 * was written or got its name, 0 if it is gone; below 0 by another machine's
 * clock. */
view_file_stamp view_file_stamp_of(const char *path, double *age);
bool view_file_stamp_same(const view_file_stamp *a, const view_file_stamp *b);

typedef struct view_watched_file {
    const char *path; /* NULL: none */
    bool needed;      /* without it nothing has changed */
    const view_file_stamp *seen;
} view_watched_file;

/* Whether a file differs from its stamp, and all that differ were left alone
 * for settle seconds, or settle_gone if one is gone. */
bool view_files_changed(const view_watched_file *files, int count,
                        double settle, double settle_gone);

#endif
