/* SPDX-License-Identifier: MIT */
/* Completes a command line, for the shells' scripts in src/completion. */
#include <string.h>

#include "common/option.h"

static const ibl_option *find(const ibl_command *cmd, const char *word)
{
    for (const ibl_section *const *s = cmd->sections; *s; s++)
        for (int i = 0; i < (*s)->count; i++) {
            const ibl_option *o = &(*s)->options[i];
            const bool is_long =
                !strncmp(word, "--", 2) && !strcmp(word + 2, o->name);
            if (is_long || (o->letter && word[0] == '-' &&
                            word[1] == o->letter && !word[2]))
                return o;
        }
    return NULL;
}

/* Prints WORD, a tab and what it is. */
static void print(const char *dashes, const char *word, const char *help)
{
    printf("%s%s\t%.*s\n", dashes, word, (int)strcspn(help, ":;,("), help);
}

void ibl_complete(char **words)
{
    const ibl_command *const *all = ibl_this_program.commands;
    const ibl_command *cmd = *all;
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
    const ibl_option *before = count > 1 ? find(cmd, words[count - 2]) : NULL;
    if (before && before->value) { /* files where it lists none */
        for (const char *const *c = before->choices; c && *c; c++)
            print("", *c, before->name);
        return;
    }
    for (const ibl_section *const *s = cmd->sections; *s && *last == '-'; s++)
        for (int i = 0; i < (*s)->count; i++)
            print("--", (*s)->options[i].name, (*s)->options[i].help);
}
