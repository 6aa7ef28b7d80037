/* SPDX-License-Identifier: MIT */
/* What a file was, to tell whether it is another one now. */
#ifndef VIEW_FILE_STAMP_H
#define VIEW_FILE_STAMP_H

#include <stdbool.h>
#include <time.h>

typedef struct view_file_stamp {
    struct timespec written;
    long long size, inode; /* size -1: it is gone */
} view_file_stamp;

/* Of what path names now. *age: seconds since it was written or came to its
 * name, 0 if it is gone; below 0 by another machine's clock. */
view_file_stamp view_file_stamp_of(const char *path, double *age);
bool view_file_stamp_same(const view_file_stamp *a, const view_file_stamp *b);

#endif
