/* SPDX-License-Identifier: MIT */
/* Targets: the engines that load what is baked. The build makes their table of
 * man/iblbake-engines.7, where a section has all of a target. */
#ifndef CLI_TARGETS_H
#define CLI_TARGETS_H

#include <stdbool.h>
#include <stdio.h>

#include <ibl/ibl.h>

enum {
    IBL_MAX_TARGETS = 16, /* room for them */
    IBL_TARGET_LIST = 1 << IBL_MAX_TARGETS
};

typedef struct ibl_target {
    const char *name, *engine;
    const char *takes; /* words: what its loader takes of --format/--pixel, and
                          zstd if that may compress them */
    const char *axes;  /* the world's axis of each of the engine's: "-z y x" */
    bool filament;     /* the member of ibl_texture */
    bool whole;        /* levels must be all, from a power of two */
    bool harmonics;    /* matte surfaces are lit by nine coefficients */
    bool filters;      /* the engine makes the levels, of a map */
    double intensity;  /* of a light with an irradiance of 1 */
    const char *options; /* words that stand before those of the user */
    /* The program before its lights, with {specular}, {irradiance}, {skybox}
     * and {sh}: the files. */
    const char *load;
    const char *background; /* what follows of it then; NULL: nothing */
    const char *skybox;     /* what follows if there is one; NULL: the same */
    /* Lines for a light, with {x} {y} {z}: the unit vector towards it, {-x}
     * {-y} {-z}: the way it shines, {r} {g} {b}: its colour, at most 1,
     * {intensity}, {degrees}, its radius, and {n}, its number from 1 */
    const char *light;
    const char *end; /* of the program; NULL: nothing */
} ibl_target;

extern const ibl_target ibl_targets[IBL_MAX_TARGETS];
extern const int ibl_target_count;
extern const char ibl_targets_allowed[]; /* values of --target in words */

/* For an option: the targets of a list of their names as bits of an unsigned,
 * or all of them; IBL_TARGET_LIST for "list". False: another word. */
bool ibl_targets_parse(void *targets, const char *value);

/* Prints what each target sets. */
void ibl_targets_print(FILE *to);

/* What a program names: files, and lights in the world's axes. */
typedef struct ibl_target_files {
    const char *specular, *irradiance, *sh, *skybox; /* "": there is none */
    const ibl_light *lights; /* NULL: unknown; their lines are not filled in */
    int light_count;
} ibl_target_files;

/* Prints the program that loads the files and adds the lights. */
void ibl_target_explain(const ibl_target *target, const ibl_target_files *files,
                        FILE *to);

#endif
