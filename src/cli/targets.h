/* SPDX-License-Identifier: MIT */
/* Targets: the engines that load what is baked. Each is a row of a table:
 * options of the command line, and the lines of the engine's language that load
 * the files. */
#ifndef CLI_TARGETS_H
#define CLI_TARGETS_H

#include <stdbool.h>
#include <stdio.h>

#include <ibl/ibl.h>

enum {
    IBL_MAX_TARGETS = 8
};

typedef struct ibl_target {
    const char *name, *engine;
    const char *options; /* words that stand before those of the user */
    const char *load;    /* lines with {specular}, {irradiance} and {sh}: the
                            files */
    /* Lines for a light, with {x} {y} {z}: the unit vector towards it, {-x}
     * {-y} {-z}: the way it shines, {r} {g} {b}: its colour, at most 1,
     * {intensity}, {degrees}, its radius, and {n}, its number from 1. NULL:
     * none */
    const char *light;
    const char *axes; /* the world's axis of each of the engine's: "-z y x" */
    bool filament;    /* the member of ibl_texture */
    double intensity; /* of a light with an irradiance of 1 */
} ibl_target;

/* Rows of the table, by the bits of a set of targets. */
extern const ibl_target ibl_targets[IBL_MAX_TARGETS];

/* For an option: the targets of a list of their names as an unsigned, or all
 * of them; 1 << IBL_MAX_TARGETS for "list". False: another word. */
#define IBL_TARGETS_ALLOWED                                                    \
    "three, babylon, babylon-env, filament, bevy, playcanvas, gltf, cesium, "  \
    "several of them with commas, all or list"
bool ibl_targets_parse(void *targets, const char *value);

/* Prints what each target sets. */
void ibl_targets_print(FILE *to);

/* What lines name: files, and lights in the world's axes. */
typedef struct ibl_target_files {
    const char *specular, *irradiance, *sh;
    const ibl_light *lights; /* NULL: unknown; their lines are not filled in */
    int light_count;
} ibl_target_files;

/* Prints the lines that load the files and add the lights. */
void ibl_target_explain(const ibl_target *target, const ibl_target_files *files,
                        FILE *to);

#endif
