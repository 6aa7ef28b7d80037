/* SPDX-License-Identifier: MIT */
#include <math.h>
#include <sys/stat.h>
#include <time.h>

#include "view/set_about.h"

/* A file that the new set may not have, or that is still to come, is waited for
 * this much longer. */
static const double GONE = 12;

static const char *path_of(const view_set *set, int i)
{
    return i < VIEW_CONTENTS    ? set->path[i]
           : i == VIEW_CONTENTS ? set->sidecar
                                : set->map;
}

/* Fills entry i; *age is how long ago the file was written or came to its
 * name, in seconds. */
static void take(const view_set *set, int i, view_stamp *stamp, double *age)
{
    const char *path = path_of(set, i);
    struct timespec now;
    struct stat st;

    *age = 0;
    stamp->seconds[i] = stamp->nanoseconds[i] = stamp->inode[i] = 0;
    stamp->size[i] = -1;
    if (!path || stat(path, &st))
        return;
    stamp->seconds[i] = st.st_mtim.tv_sec;
    stamp->nanoseconds[i] = st.st_mtim.tv_nsec;
    stamp->size[i] = st.st_size;
    stamp->inode[i] = (long long)st.st_ino;
    /* Not the time of the content, which copies and archives keep: that of the
     * last change of any kind, a rename over the old file too. */
    clock_gettime(CLOCK_REALTIME, &now);
    *age = (double)(now.tv_sec - st.st_ctim.tv_sec) +
           1e-9 * (double)(now.tv_nsec - st.st_ctim.tv_nsec);
}

void view_stamp_read(view_set *set, int i)
{
    double age;
    take(set, i, &set->read, &age);
}

void view_stamp_take(const view_set *set, view_stamp *stamp)
{
    double age;

    for (int i = 0; i < VIEW_STAMPS; i++)
        take(set, i, stamp, &age);
}

bool view_stamp_changed(const view_set *set, const view_stamp *stamp,
                        double settle)
{
    bool changed = false, gone = false;
    double nearest = INFINITY;

    for (int i = 0; i < VIEW_STAMPS; i++) {
        view_stamp now;
        double age;
        if (!path_of(set, i))
            continue;
        take(set, i, &now, &age);
        const bool same = now.seconds[i] == stamp->seconds[i] &&
                          now.nanoseconds[i] == stamp->nanoseconds[i] &&
                          now.size[i] == stamp->size[i] &&
                          now.inode[i] == stamp->inode[i];
        if (same)
            continue;
        if (now.size[i] < 0 && (i == VIEW_SPECULAR || i > VIEW_CONTENTS))
            return false;
        if (now.size[i] < 0) {
            gone = true;
            continue;
        }
        /* In the future: by another machine's clock, which says nothing. */
        nearest = fmin(nearest, fabs(age));
        changed = true;
    }
    return changed && nearest >= (gone ? GONE * settle : settle);
}
