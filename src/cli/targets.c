/* SPDX-License-Identifier: MIT */
#include "cli/targets.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "cli/shell_words.h"
#include "json/text.h"

/* ---- lists --------------------------------------------------------------- */

static int find(const char *name, size_t length)
{
    for (int i = 0; i < ibl_target_count; i++)
        if (strlen(ibl_targets[i].name) == length &&
            !memcmp(ibl_targets[i].name, name, length))
            return i;
    return -1;
}

/* False: a name that there is not. */
static bool take_names(unsigned *bits, const char *value)
{
    for (;;) {
        const size_t length = strcspn(value, ",");
        const int i = find(value, length);
        if (i < 0)
            return false;
        *bits |= 1u << i;
        if (!value[length])
            return true;
        value += length + 1;
    }
}

bool ibl_targets_parse(void *targets, const char *value)
{
    unsigned bits = 0;

    if (!strcmp(value, "list"))
        bits = IBL_TARGET_LIST;
    else if (!strcmp(value, "all"))
        bits = (1u << ibl_target_count) - 1;
    else if (!take_names(&bits, value))
        return false;
    *(unsigned *)targets = bits;
    return true;
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
    char *text = ibl_words_fill(lines, holders, count);

    fputs(text ? text : lines, to);
    free(text);
}

/* The component of a direction that one of an engine's axes has: 'x', 'y' or
 * 'z', after '-' for its opposite. */
static double along(const char *axis, const double world[3])
{
    const bool negative = *axis == '-';
    const double x = world[axis[negative] - 'x'];
    return negative ? -x : x;
}

/* The engine's axes are words between single blanks. */
static void turn(const char *axes, const double world[3], double to[3])
{
    for (int i = 0; i < 3; i++) {
        to[i] = along(axes, world);
        axes += strcspn(axes, " ") + (i < 2);
    }
}

enum {
    NUMBERS = 12,
    NUMBER_BYTES = 32
};

typedef struct numbers {
    char text[NUMBERS][NUMBER_BYTES];
    ibl_placeholder holders[NUMBERS];
    int count;
} numbers;

/* Languages take 1.0 for a float, and not all of them 1. */
static void add_number(numbers *n, const char *name, const char *fmt, double x)
{
    snprintf(n->text[n->count], NUMBER_BYTES, fmt, x + 0.0);
    n->holders[n->count] = (ibl_placeholder){name, n->text[n->count]};
    n->count++;
}

static void print_light(const ibl_target *target, const ibl_light *light,
                        int number, FILE *to)
{
    static const char *const names[3][3] = {
        {"x", "y", "z"}, {"-x", "-y", "-z"}, {"r", "g", "b"}};
    static const char *const fmt = "%#.6g";
    const double *e = light->irradiance;
    const double most = fmax(fmax(e[0], e[1]), e[2]);
    double d[3];
    numbers n = {.count = 0};

    turn(target->axes, light->direction, d);
    for (int i = 0; i < 3; i++) {
        add_number(&n, names[0][i], fmt, d[i]);
        add_number(&n, names[1][i], fmt, -d[i]);
        add_number(&n, names[2][i], fmt, e[i] / most);
    }
    add_number(&n, "intensity", fmt, most * target->intensity);
    add_number(&n, "degrees", fmt, light->radius * 180 / M_PI);
    add_number(&n, "n", "%.0f", number);
    print_lines(target->light, n.holders, n.count, to);
}

void ibl_target_explain(const ibl_target *target, const ibl_target_files *files,
                        FILE *to)
{
    const char *skybox = files->skybox ? files->skybox : files->specular;
    const ibl_placeholder holders[] = {{"specular", files->specular},
                                       {"irradiance", files->irradiance},
                                       {"skybox", skybox},
                                       {"sh", files->sh}};
    const char *background =
        files->skybox && target->skybox ? target->skybox : target->background;

    print_lines(target->load, holders, 4, to);
    print_lines(background ? background : "", holders, 4, to);
    if (!files->lights && files->light_count)
        fputs(target->light, to);
    for (int i = 0; i < files->light_count && files->lights; i++)
        print_light(target, &files->lights[i], i + 1, to);
    fputs(target->end ? target->end : "", to);
}
