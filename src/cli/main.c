/* SPDX-License-Identifier: MIT */
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>

#include "cli/common_options.h"

static const ibl_command *const commands[] = {
    &ibl_bake_command, &ibl_verify_command, &ibl_bench_command,
    &ibl_probes_command, NULL};

const ibl_program ibl_this_program = {"iblbake", commands};

/* Opens those of descriptors 0 to 2 that the caller closed, in the wrong
 * direction so that they stay unusable. Otherwise an output would get such a
 * number, and messages would be written into it. */
static void keep_standard(void)
{
    for (int fd = 0; fd < 3; fd++)
        if (fcntl(fd, F_GETFD) < 0 && errno == EBADF)
            if (open("/dev/null", fd ? O_RDONLY : O_WRONLY) < 0)
                return; /* then nothing else can be opened either */
}

int main(int argc, char **argv)
{
    keep_standard();
    int status = ibl_command_main(argc, argv);

    if (fflush(stdout) || ferror(stdout)) {
        perror("iblbake: standard output");
        status = 1;
    }
    return status;
}
