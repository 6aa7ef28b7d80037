/* SPDX-License-Identifier: MIT */
/* The command lines of both programs, a word a line; nothing is run. */
#include <stdlib.h>
#include <string.h>

#include "cli/common_options.h"
#include "fuzz.h"
#include "view/controls.h"

enum {
    MOST_WORDS = 64
};

void fuzz_begin(void)
{
}

static void parse(const ibl_command *cmd, char **words)
{
    int status = -1;
    void *settings = calloc(1, cmd->settings_size);

    FUZZ_NEED(settings);
    const bool ok = ibl_command_line(cmd, words, settings, &status);
    FUZZ_NEED(ok ? status == 0 : status == 0 || status == 2);
    fuzz_said(status);
    if (cmd->release)
        cmd->release(settings);
    free(settings);
}

static void parse_view(char **words)
{
    view_options o;
    int status = -1;

    const bool ok = view_options_parse(words, &o, &status);
    FUZZ_NEED(ok ? status == 0 : status == 0 || status == 2);
    fuzz_said(status);
}

void fuzz_one(fuzz_input in)
{
    static const ibl_command *const commands[] = {
        &ibl_bake_command,   &ibl_verify_command, &ibl_bench_command,
        &ibl_probes_command, &ibl_info_command,   &ibl_convert_command};
    const int program = fuzz_choice(&in, 7);
    char *text = malloc(in.size + 1), *words[MOST_WORDS + 1], *rest = text;
    int count = 0;

    FUZZ_NEED(text);
    memcpy(text, in.bytes, in.size);
    text[in.size] = '\0';
    while (rest && *rest && count < MOST_WORDS) {
        words[count++] = rest;
        rest = strchr(rest, '\n');
        if (rest)
            *rest++ = '\0';
    }
    words[count] = NULL;
    if (program == 6)
        parse_view(words);
    else
        parse(commands[program], words);
    free(text);
}
