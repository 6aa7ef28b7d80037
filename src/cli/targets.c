/* SPDX-License-Identifier: MIT */
#include "cli/targets.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "cli/words.h"
#include "common/signals.h"

/* ---- lists --------------------------------------------------------------- */

bool ibl_targets_parse(void *targets, const char *value)
{
    const char *names[IBL_MAX_TARGETS + 1] = {NULL};

    for (int i = 0; i < ibl_target_count; i++)
        names[i] = ibl_targets[i].name;
    if (!strcmp(value, "list") || !strcmp(value, "all")) {
        *(unsigned *)targets = *value == 'l' ? (unsigned)IBL_TARGET_LIST
                                             : (1u << ibl_target_count) - 1;
        return true;
    }
    return ibl_words_bits(value, names, targets);
}

void ibl_targets_print(FILE *to)
{
    for (int i = 0; i < ibl_target_count; i++) {
        fprintf(to, "%s: %s\n", ibl_targets[i].name, ibl_targets[i].engine);
        for (const char *line = ibl_targets[i].options; *line;) {
            const int length = (int)strcspn(line, "\n") + 1;
            fprintf(to, "    %.*s", length, line);
            line += length;
        }
    }
}

/* ---- lines for an engine --------------------------------------------------
 */

/* Prints lines with holders filled in. */
static void print_lines(const char *lines, const ibl_placeholder *holders,
                        int count, FILE *to)
{
    char *text = ibl_need(ibl_words_fill(lines, holders, count));

    fputs(text, to);
    free(text);
}

static void print_light(const ibl_target *target, const ibl_light *light,
                        int number, FILE *to)
{
    static const char *const names[] = {"x",  "y",         "z",       "-x",
                                        "-y", "-z",        "r",       "g",
                                        "b",  "intensity", "degrees", "n"};
    enum {
        COUNT = sizeof names / sizeof *names
    };
    const double *e = light->irradiance;
    const double most = fmax(fmax(e[0], e[1]), e[2]);
    const char *axis = target->axes; /* words between single blanks */
    double values[COUNT] = {[9] = most * target->intensity,
                            [10] = light->radius * 180 / M_PI,
                            [11] = number};
    char text[COUNT][32];
    ibl_placeholder holders[COUNT];

    for (int i = 0; i < 3; i++) {
        const bool negative = *axis == '-';
        const double along = light->direction[axis[negative] - 'x'];
        values[i] = negative ? -along : along;
        values[3 + i] = -values[i];
        values[6 + i] = e[i] / most;
        axis += strcspn(axis, " ") + (i < 2);
    }
    for (int i = 0; i < COUNT; i++) {
        /* Languages take 1.0 for a float, and not all of them 1. */
        snprintf(text[i], sizeof text[i], i < COUNT - 1 ? "%#.6g" : "%.0f",
                 values[i] + 0.0);
        holders[i] = (ibl_placeholder){names[i], text[i]};
    }
    print_lines(target->light, holders, COUNT, to);
}

void ibl_target_explain(const ibl_target *target, const ibl_target_files *files,
                        FILE *to)
{
    const char *skybox = *files->skybox ? files->skybox : files->specular;
    const ibl_placeholder holders[] = {{"specular", files->specular},
                                       {"irradiance", files->irradiance},
                                       {"skybox", skybox},
                                       {"sh", files->sh}};
    const char *background =
        *files->skybox && target->skybox ? target->skybox : target->background;

    print_lines(target->load, holders, 4, to);
    print_lines(background ? background : "", holders, 4, to);
    if (!files->lights && files->light_count)
        fputs(target->light, to);
    for (int i = 0; i < files->light_count && files->lights; i++)
        print_light(target, &files->lights[i], i + 1, to);
    fputs(target->end ? target->end : "", to);
}
