/* SPDX-License-Identifier: MIT */
/* Targets: the engines that load what is baked. Each is a row of a table; its
 * options of the command line, and the lines of the engine's language that load
 * the files, are those of man/iblbake-engines.7. */
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
    const char *takes; /* words: what its loader takes of --format/--pixel, and
                          zstd if that may compress them */
    const char *axes;  /* the world's axis of each of the engine's: "-z y x" */
    bool filament;     /* the member of ibl_texture */
    bool whole;        /* levels must be all, from a power of two */
    bool harmonics;    /* matte surfaces are lit by nine coefficients */
    double intensity;  /* of a light with an irradiance of 1 */
} ibl_target;

/* Lines of the manual page of engines, of a target. */
typedef struct ibl_target_program {
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
} ibl_target_program;

/* Rows of the table, by the bits of a set of targets. */
extern const ibl_target ibl_targets[IBL_MAX_TARGETS];
/* Generated from the page by the build. */
extern const ibl_target_program ibl_target_programs[IBL_MAX_TARGETS];

static inline const ibl_target_program *
ibl_target_program_of(const ibl_target *target)
{
    return &ibl_target_programs[target - ibl_targets];
}

/* For an option: the targets of a list of their names as an unsigned, or all
 * of them; 1 << IBL_MAX_TARGETS for "list". False: another word. */
#define IBL_TARGETS_ALLOWED                                                    \
    "three, babylon, babylon-env, filament, bevy, playcanvas, gltf, cesium, "  \
    "several of them with commas, all or list"
bool ibl_targets_parse(void *targets, const char *value);

/* Prints what each target sets. */
void ibl_targets_print(FILE *to);

/* What a program names: files, and lights in the world's axes. */
typedef struct ibl_target_files {
    const char *specular, *irradiance, *sh;
    const char *skybox;      /* NULL: there is none */
    const ibl_light *lights; /* NULL: unknown; their lines are not filled in */
    int light_count;
} ibl_target_files;

/* Prints the program that loads the files and adds the lights. */
void ibl_target_explain(const ibl_target *target, const ibl_target_files *files,
                        FILE *to);

#endif
