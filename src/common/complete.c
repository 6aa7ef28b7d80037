/* SPDX-License-Identifier: MIT */
/* Completes a command line, for the shells' scripts in src/completion. */
#include <string.h>

#include "common/option.h"

/* Prints WORD, a tab and what it is. */
static void print(const char *dashes, const char *word, const char *help)
{
    printf("%s%s\t%.*s\n", dashes, word, (int)strcspn(help, ":;,("), help);
}

void ibl_complete(char **words)
{
    const ibl_command *const *all = ibl_this_program.commands;
    const ibl_command *cmd = *all;
    const ibl_option *before = NULL, *o;
    const char *last = "";
    int count = 0;

    while (words[count])
        count++;
    if (count)
        last = words[count - 1];
    for (int i = 1; all[i] && count; i++) {
        if (count > 1 && !strcmp(words[0], all[i]->name))
            cmd = all[i];
        if (count == 1 && *last != '-')
            print("", all[i]->name, all[i]->brief);
    }
    if (count > 1 && words[count - 2][0] == '-') {
        const char *word = words[count - 2] + 1;
        before = *word == '-'
                     ? ibl_option_find(cmd, word + 1, strlen(word + 1), '\0')
                 : *word && !word[1] ? ibl_option_find(cmd, NULL, 0, *word)
                                     : NULL;
    }
    if (before && before->value) { /* files where it lists none */
        for (const char *const *c = before->choices; c && *c; c++)
            print("", *c, before->name);
        return;
    }
    for (int n = 0; *last == '-' && (o = ibl_option_at(cmd, n)); n++)
        print("--", o->name, o->help);
}
