/* SPDX-License-Identifier: MIT */
/* --help, and the words for an option's values and default. */
#include <string.h>

#include "cli/option.h"

enum {
    WIDTH = 80, /* columns of a line */
    INDENT = 27 /* where the explanations begin */
};

void ibl_option_allowed(const ibl_option *opt, char *text, size_t size)
{
    *text = '\0';
    if (opt->allowed) {
        snprintf(text, size, "%s", opt->allowed);
    } else if (opt->kind == IBL_OPTION_INT || opt->kind == IBL_OPTION_REAL) {
        snprintf(text, size, "%.10g to %.10g", opt->low, opt->high);
    } else if (opt->kind == IBL_OPTION_CHOICE) {
        for (int i = 0; opt->choices[i]; i++) {
            const size_t used = strlen(text);
            const char *between = i == 0                ? ""
                                  : opt->choices[i + 1] ? ", "
                                                        : " or ";
            snprintf(text + used, size - used, "%s%s", between,
                     opt->choices[i]);
        }
    }
}

void ibl_option_standard(const ibl_option *opt, char *text, size_t size)
{
    const ibl_opts defaults = ibl_opts_default();
    const void *field = (const char *)&defaults + opt->offset;

    *text = '\0';
    if (opt->standard)
        snprintf(text, size, "%s", opt->standard);
    else if (opt->kind == IBL_OPTION_INT)
        snprintf(text, size, "%d", *(const int *)field);
    else if (opt->kind == IBL_OPTION_REAL)
        snprintf(text, size, "%.10g", *(const double *)field);
    else if (opt->kind == IBL_OPTION_CHOICE)
        snprintf(text, size, "%s", opt->choices[*(const int *)field]);
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

static void print_option(FILE *to, const ibl_option *opt)
{
    char allowed[160], standard[80], text[640];
    int column;

    ibl_option_allowed(opt, allowed, sizeof allowed);
    ibl_option_standard(opt, standard, sizeof standard);
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

void ibl_opts_help(FILE *to)
{
    const char *group = "";

    fputs("Usage: iblbake [options] ENV -o DIR\n"
          "\n"
          "Bakes an equirectangular HDR environment (.hdr, .exr and others; - "
          "reads\n"
          "standard input) into the textures of image-based lighting:\n"
          "  DIR/NAME_specular.EXT    prefiltered cube, one roughness per "
          "level\n"
          "  DIR/NAME_irradiance.EXT  diffuse cube, E/pi\n"
          "  DIR/brdf_lut.EXT         scale and bias of F0 over N.V and "
          "roughness\n"
          "  DIR/NAME.json            spherical harmonics and what was done\n",
          to);
    for (int i = 0; i < ibl_option_count; i++) {
        const ibl_option *opt = &ibl_option_table[i];
        if (strcmp(group, opt->group) != 0) {
            group = opt->group;
            fprintf(to, "\n%s:\n", group);
        }
        print_option(to, opt);
    }
    fputs("\nExit status: 0 done, 1 failed, 2 wrong usage. Manual: man "
          "iblbake\n",
          to);
}
