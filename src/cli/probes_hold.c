/* SPDX-License-Identifier: MIT */
/* One run at a time in a directory: what one takes over from the old arrays
 * must not be replaced by another meanwhile, nor the files of both be mixed. */
#include <errno.h>
#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include "cli/probes_bake.h"

bool ibl_probes_hold(ibl_probes_bake *p)
{
    const char *directory = p->opts->output;

    p->held = open(directory, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (p->held < 0)
        return errno != ENOENT;
    /* File systems without locks say so by other errors, and have none. */
    if (flock(p->held, LOCK_EX | LOCK_NB) && errno == EWOULDBLOCK) {
        ibl_console_warn(p->console,
                         "%s: another run is at work there: waiting for it",
                         directory);
        while (flock(p->held, LOCK_EX) && errno == EINTR)
            continue;
    }
    return true;
}

void ibl_probes_release(ibl_probes_bake *p)
{
    if (p->held >= 0)
        close(p->held);
    p->held = -1;
}
