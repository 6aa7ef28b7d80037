/* SPDX-License-Identifier: MIT */
/* Prints --help; describes an option's values and default. */
#include <stdlib.h>
#include <string.h>

#include "common/names.h"
#include "common/option.h"
#include "common/signals.h"

enum {
    WIDTH = 80, /* columns of a line */
    INDENT = 27 /* where the explanations begin */
};

void ibl_option_allowed(const ibl_option *opt, char *text, size_t size)
{
    *text = '\0';
    if (opt->allowed) {
        snprintf(text, size, "%s", opt->allowed);
    } else if (opt->kind == IBL_OPTION_PNG) {
        snprintf(text, size, "a name that ends in .png");
    } else if (opt->kind == IBL_OPTION_INT || opt->kind == IBL_OPTION_REAL) {
        snprintf(text, size, "%.10g to %.10g", opt->low, opt->high);
    } else if (opt->kind == IBL_OPTION_CHOICE) {
        ibl_names_text(opt->choices, text, size);
    }
}

/* The default in words, "" if not shown; settings hold the defaults. */
static void describe_standard(const ibl_option *opt, const void *settings,
                              char *text, size_t size)
{
    const void *field = (const char *)settings + opt->offset;
    const bool whole =
        opt->kind == IBL_OPTION_INT || opt->kind == IBL_OPTION_CHOICE;
    const int i = whole ? *(const int *)field : 0;

    *text = '\0';
    if (opt->standard)
        snprintf(text, size, "%s", opt->standard);
    else if (opt->kind == IBL_OPTION_INT)
        snprintf(text, size, "%d", i);
    else if (opt->kind == IBL_OPTION_REAL)
        snprintf(text, size, "%.10g", *(const double *)field);
    else if (opt->kind == IBL_OPTION_CHOICE)
        snprintf(text, size, "%s", opt->choices[i]);
}

/* Prints text from column INDENT on, broken at spaces; the cursor is at
 * column. */
static void wrap(FILE *to, const char *text, int column)
{
    while (*text) {
        const int word = (int)strcspn(text, " ");
        const bool first = column <= INDENT;
        if (!first && column + 1 + word > WIDTH) {
            fputc('\n', to);
            column = 0;
            continue;
        }
        if (first)
            column += fprintf(to, "%*s", INDENT - column, "");
        else
            column += fprintf(to, " ");
        column += fprintf(to, "%.*s", word, text);
        text += word;
        text += *text == ' ';
    }
    fputc('\n', to);
}

static void print_option(FILE *to, const ibl_option *opt, const void *settings)
{
    char allowed[160], standard[80], text[640];
    int column;

    ibl_option_allowed(opt, allowed, sizeof allowed);
    describe_standard(opt, settings, standard, sizeof standard);
    snprintf(text, sizeof text, "%s%s%s%s%s%s%s", opt->help,
             *allowed || *standard ? " (" : "", allowed,
             *allowed && *standard ? "; " : "", *standard ? "default " : "",
             standard, *allowed || *standard ? ")" : "");

    if (opt->letter)
        column = fprintf(to, "  -%c, --%s", opt->letter, opt->name);
    else
        column = fprintf(to, "      --%s", opt->name);
    if (opt->value)
        column += fprintf(to, " %s", opt->value);
    if (column >= INDENT) {
        fputc('\n', to);
        column = 0;
    }
    wrap(to, text, column);
}

/* Lists all commands but the first, for the first one's --help. */
static void print_commands(FILE *to)
{
    const ibl_command *const *all = ibl_this_program.commands;

    if (!all[1])
        return;
    fputs("\nCommands (as the first argument; a file of that name is given as "
          "./NAME):\n",
          to);
    for (int i = 1; all[i]; i++)
        fprintf(to, "  %s %s %s\n      %s\n", ibl_this_program.name,
                all[i]->name, all[i]->usage, all[i]->brief);
}

void ibl_command_help(const ibl_command *cmd, FILE *to)
{
    const char *const program = ibl_this_program.name;
    const char *title = "", *name = cmd->name ? cmd->name : "";
    void *settings = ibl_need(calloc(1, cmd->settings_size));

    cmd->defaults(settings);
    fprintf(to, "Usage: %s %s%s%s\n\n%s", program, name, *name ? " " : "",
            cmd->usage, cmd->intro);
    if (!cmd->name)
        print_commands(to);
    for (const ibl_section *const *s = cmd->sections; *s; s++) {
        if (strcmp(title, (*s)->title) != 0)
            fprintf(to, "\n%s:\n", (*s)->title);
        title = (*s)->title;
        for (int i = 0; i < (*s)->count; i++)
            print_option(to, ibl_section_at(*s, i), settings);
    }
    free(settings);
    fprintf(to, "\nExit status: %s.\nManual: man %s%s%s\n", cmd->statuses,
            program, *name ? "-" : "", name);
}
