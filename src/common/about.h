/* SPDX-License-Identifier: MIT */
/* How a texture was baked: what its keys iblbake.* say, else the sidecar. */
#ifndef COMMON_ABOUT_H
#define COMMON_ABOUT_H

#include <jansson.h>
#include <stdbool.h>

#include <ibl/io.h>

/* What is said by a word. */
enum {
    IBL_ABOUT_CONTENT,
    IBL_ABOUT_MAPPING,
    IBL_ABOUT_LOBE,
    IBL_ABOUT_GEOMETRY,
    IBL_ABOUT_SCALE,
    IBL_ABOUT_TABLE,
    IBL_ABOUT_MIRROR, /* these two hold for all outputs of a sidecar */
    IBL_ABOUT_UP,
    IBL_ABOUT_WORDS
};

/* Names in a container and in a sidecar, and for messages. names NULL: any. */
extern const struct ibl_about_word {
    const char *key, *member, *what;
    const char *const *names;
} ibl_about_words[IBL_ABOUT_WORDS];

typedef struct ibl_about {
    const char *word[IBL_ABOUT_WORDS]; /* NULL: not said */
    int value[IBL_ABOUT_WORDS];        /* index in names; 0: not said, or names
                                          is NULL; -1: no such name */
    bool has_lod;
    double lod_scale, lod_offset; /* NAN: no number */
    int levels; /* that have a roughness; 0: not said, -1: damaged */
    double roughness[IBL_MAX_LEVELS];
    bool differ; /* keys and sidecar do, but for the content */
} ibl_about;

/* Keys hold where both say something. entry: of the texture in the sidecar;
 * NULL: none. Texts belong to tex and sidecar. */
void ibl_about_read(const ibl_texture *tex, const json_t *sidecar,
                    const json_t *entry, ibl_about *a);

/* Whether it is for levels of these roughnesses, as far as it says. */
bool ibl_about_fits(const ibl_about *a, const double *roughness, int levels);

/* The axes that are said; of the world else. */
ibl_axes ibl_about_axes(const ibl_about *a);

#endif
