/* SPDX-License-Identifier: MIT */
#include "view/file_stamp.h"

#include <sys/stat.h>

view_file_stamp view_file_stamp_of(const char *path, double *age)
{
    struct timespec now;
    struct stat st;

    *age = 0;
    if (stat(path, &st))
        return (view_file_stamp){.size = -1};
    /* Not the time of the content, which copies and archives keep: that of the
     * last change of any kind, a rename over the old file too. */
    clock_gettime(CLOCK_REALTIME, &now);
    *age = (double)(now.tv_sec - st.st_ctim.tv_sec) +
           1e-9 * (double)(now.tv_nsec - st.st_ctim.tv_nsec);
    return (view_file_stamp){st.st_mtim, st.st_size, (long long)st.st_ino};
}

bool view_file_stamp_same(const view_file_stamp *a, const view_file_stamp *b)
{
    return a->size == b->size && a->inode == b->inode &&
           a->written.tv_sec == b->written.tv_sec &&
           a->written.tv_nsec == b->written.tv_nsec;
}
