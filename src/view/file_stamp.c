/* SPDX-License-Identifier: MIT */
#include "view/file_stamp.h"

#include <math.h>
#include <sys/stat.h>

view_file_stamp view_file_stamp_of(const char *path, double *age)
{
    struct timespec now;
    struct stat st;

    if (age)
        *age = 0;
    if (!path || stat(path, &st))
        return (view_file_stamp){.size = -1};
    /* Copies and archives keep st_mtim. st_ctim also changes when a file is
     * renamed over the old one. */
    clock_gettime(CLOCK_REALTIME, &now);
    if (age)
        *age = (double)(now.tv_sec - st.st_ctim.tv_sec) +
               1e-9 * (double)(now.tv_nsec - st.st_ctim.tv_nsec);
    return (view_file_stamp){st.st_mtim, st.st_size, (long long)st.st_ino};
}

static bool same(const view_file_stamp *a, const view_file_stamp *b)
{
    return a->size == b->size && a->inode == b->inode &&
           a->written.tv_sec == b->written.tv_sec &&
           a->written.tv_nsec == b->written.tv_nsec;
}

void view_files_see(char *const *paths, int count, view_file_stamp *seen)
{
    for (int i = 0; i < count; i++)
        seen[i] = view_file_stamp_of(paths[i], NULL);
}

bool view_files_changed(char *const *paths, int count,
                        const view_file_stamp *seen, double settle,
                        double settle_gone)
{
    bool first = true, changed = false, gone = false;
    double nearest = INFINITY;

    for (int i = 0; i < count; i++) {
        double age;
        if (!paths[i])
            continue;
        const view_file_stamp now = view_file_stamp_of(paths[i], &age);
        if (now.size < 0 && first)
            return false;
        first = false;
        if (same(&now, &seen[i]))
            continue;
        gone = gone || now.size < 0;
        changed = changed || now.size >= 0;
        /* Negative if another machine's clock is ahead. */
        if (now.size >= 0)
            nearest = fmin(nearest, fabs(age));
    }
    return changed && nearest >= (gone ? settle_gone : settle);
}
