/* SPDX-License-Identifier: MIT */
#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "cli/common_options.h"
#include "common/process.h"
#include "common/signals.h"

static const ibl_command *const commands[] = {&ibl_bake_command,
                                              &ibl_verify_command,
                                              &ibl_bench_command,
                                              &ibl_probes_command,
                                              &ibl_info_command,
                                              &ibl_convert_command,
                                              NULL};

const ibl_program ibl_this_program = {"iblbake", commands};

int main(int argc, char **argv)
{
    ibl_signals_catch(argc, argv);
    /* Of two words, since sets of probes are what was merged. */
    const char *word =
        argc > 2 && !strcmp(argv[1], "probes") ? argv[2] : argv[1];
    if (word && !strcmp(word, "merge") && access(word, F_OK)) {
        ibl_misuse(
            "merge: is no more: a shard is of whole sets: iblbake probes "
            "--shard K/N SET.json... -o DIR");
        return 2;
    }
    int status = ibl_command_main(argc, argv);

    errno = 0;
    const char *why = ibl_unwritten(stdout);

    if (!why || status)
        return status;
    fprintf(stderr, "iblbake: standard output cannot be written: %s\n", why);
    return 1;
}
