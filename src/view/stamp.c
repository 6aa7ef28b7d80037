/* SPDX-License-Identifier: MIT */
#include <math.h>

#include "view/set_about.h"

/* A file that the new set may not have, or that is still to come, is waited for
 * this much longer. */
static const double GONE = 12;

static const char *path_of(const baked_set *set, int i)
{
    return i < VIEW_CONTENTS    ? set->path[i]
           : i == VIEW_CONTENTS ? set->sidecar
                                : set->map;
}

/* *age: as view_file_stamp_of has it. */
static view_file_stamp take(const baked_set *set, int i, double *age)
{
    const char *path = path_of(set, i);

    *age = 0;
    return path ? view_file_stamp_of(path, age) : (view_file_stamp){.size = -1};
}

void view_stamp_read(baked_set *set, int i)
{
    double age;
    set->read.file[i] = take(set, i, &age);
}

void view_stamp_take(const baked_set *set, view_stamp *stamp)
{
    double age;

    for (int i = 0; i < VIEW_STAMPS; i++)
        stamp->file[i] = take(set, i, &age);
}

bool view_stamp_changed(const baked_set *set, const view_stamp *stamp,
                        double settle)
{
    bool changed = false, gone = false;
    double nearest = INFINITY;

    for (int i = 0; i < VIEW_STAMPS; i++) {
        double age;
        if (!path_of(set, i))
            continue;
        const view_file_stamp now = take(set, i, &age);
        if (view_file_stamp_same(&now, &stamp->file[i]))
            continue;
        if (now.size < 0 && (i == VIEW_SPECULAR || i > VIEW_CONTENTS))
            return false;
        if (now.size < 0) {
            gone = true;
            continue;
        }
        /* In the future: by another machine's clock, which says nothing. */
        nearest = fmin(nearest, fabs(age));
        changed = true;
    }
    return changed && nearest >= (gone ? GONE * settle : settle);
}
