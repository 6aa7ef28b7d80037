/* SPDX-License-Identifier: MIT */
#include <stdio.h>

#include "cli/option.h"

int main(int argc, char **argv)
{
    int status = ibl_command_main(argc, argv);

    if (fflush(stdout) || ferror(stdout)) {
        perror("iblbake: standard output");
        status = 1;
    }
    return status;
}
