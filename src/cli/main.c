/* SPDX-License-Identifier: MIT */
#include "cli/bake.h"
#include "cli/opts.h"
#include "cli/version.h"

int main(int argc, char **argv)
{
    ibl_opts opts;
    int status = ibl_opts_parse(argc, argv, &opts);

    if (status)
        return status;
    if (opts.help)
        ibl_opts_help(stdout);
    else if (opts.version)
        ibl_version_print(stdout);
    else
        status = ibl_bake_run(&opts);
    if (fflush(stdout) || ferror(stdout)) {
        perror("iblbake: standard output");
        status = 1;
    }
    return status;
}
