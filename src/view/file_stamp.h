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

/* The present state of files whose paths are not NULL. */
void view_files_see(char *const *paths, int count, view_file_stamp *seen);
/* Whether a file is another than the one that was seen, and all such were left
 * alone for settle seconds, or settle_gone if one is gone. Never while the
 * first that has a path is missing. */
bool view_files_changed(char *const *paths, int count,
                        const view_file_stamp *seen, double settle,
                        double settle_gone);

#endif
