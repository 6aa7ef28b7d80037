/* SPDX-License-Identifier: MIT */
/* --help, from the tables of options.c. */
#include <string.h>

#include "view/option_row.h"

enum {
    WIDTH = 80, /* columns of a line */
    INDENT = 27 /* where the explanations begin */
};

void view_option_allowed(const view_option *opt, char *text, size_t size)
{
    *text = '\0';
    if (opt->allowed) {
        snprintf(text, size, "%s", opt->allowed);
    } else if (opt->kind == VIEW_OPTION_INT || opt->kind == VIEW_OPTION_REAL) {
        snprintf(text, size, "%.10g to %.10g", opt->low, opt->high);
    } else if (opt->kind == VIEW_OPTION_CHOICE) {
        for (int i = 0; opt->choice(i); i++) {
            const size_t used = strlen(text);
            const char *between = i == 0               ? ""
                                  : opt->choice(i + 1) ? ", "
                                                       : " or ";
            snprintf(text + used, size - used, "%s%s", between, opt->choice(i));
        }
    }
}

static void standard_of(const view_option *opt, const view_options *o,
                        char *text, size_t size)
{
    const void *field = (const char *)o + opt->offset;
    int index;

    *text = '\0';
    if (opt->standard) {
        snprintf(text, size, "%s", opt->standard);
    } else if (opt->kind == VIEW_OPTION_INT) {
        snprintf(text, size, "%d", *(const int *)field);
    } else if (opt->kind == VIEW_OPTION_REAL) {
        snprintf(text, size, "%.10g", *(const double *)field);
    } else if (opt->kind == VIEW_OPTION_CHOICE) {
        memcpy(&index, field, sizeof index);
        snprintf(text, size, "%s", opt->choice(index));
    }
}

/* Prints text from column INDENT on, broken at spaces; column is where the
 * cursor is. */
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
        column +=
            fprintf(to, "%*s%.*s", first ? INDENT - column : 1, "", word, text);
        text += word;
        text += *text == ' ';
    }
    fputc('\n', to);
}

static void print_option(FILE *to, const view_option *opt,
                         const view_options *o)
{
    char allowed[200], standard[80], text[640];
    int column;

    view_option_allowed(opt, allowed, sizeof allowed);
    standard_of(opt, o, standard, sizeof standard);
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

void view_options_help(FILE *to)
{
    const view_options o = view_options_default();

    fputs("Usage: iblview [options] PATH\n\n"
          "Shows what materials look like under a baked environment, or the "
          "maps\n"
          "themselves. PATH is a directory that iblbake has written, a "
          "specular cube\n"
          "(KTX2, KTX, DDS), or an environment (.hdr, .exr), which is baked "
          "first.\n"
          "In the window ? lists the keys.\n",
          to);
    for (const view_section *s = view_sections; s->title; s++) {
        fprintf(to, "\n%s:\n", s->title);
        for (int i = 0; i < s->count; i++)
            print_option(to, &s->options[i], &o);
    }
    fputs("\nExit status: 0 done, 1 failed, 2 wrong usage.\n"
          "Manual: man iblview\n",
          to);
}
