/* SPDX-License-Identifier: MIT */
/* Detects that a file was replaced or rewritten. */
#ifndef VIEW_FILE_STAMP_H
#define VIEW_FILE_STAMP_H

#include <stdbool.h>
#include <time.h>

typedef struct view_file_stamp {
    struct timespec written;
    long long size, inode; /* size -1: there is no file */
} view_file_stamp;

/* Stamp of the file at path; NULL: none. *age, unless age is NULL: seconds
 * since the file was written or renamed, 0 if it is gone; negative if another
 * machine's clock is ahead. */
view_file_stamp view_file_stamp_of(const char *path, double *age);

/* Stores the present stamps of files whose paths are not NULL. */
void view_files_see(char *const *paths, int count, view_file_stamp *seen);
/* Whether a file differs from its stamp, and all such files are unchanged for
 * `settle` seconds, or settle_gone if one is gone. Never while the first that
 * has a path is missing. */
bool view_files_changed(char *const *paths, int count,
                        const view_file_stamp *seen, double settle,
                        double settle_gone);

#endif
