/* SPDX-License-Identifier: MIT */
/* How a texture was baked: what its keys iblbake.* say, and a sidecar. */
#ifndef SET_ABOUT_H
#define SET_ABOUT_H

#include "ibl/set.h"
#include "json/json_load.h"

/* What is said by a word or a number. */
enum {
    IBL_FACT_CONTENT,
    IBL_FACT_LOBE,
    IBL_FACT_MAPPING,
    IBL_FACT_LOD_SCALE,
    IBL_FACT_LOD_OFFSET,
    IBL_FACT_SCALE,
    IBL_FACT_TABLE,
    IBL_FACT_GEOMETRY,
    IBL_FACT_MIRROR,
    IBL_FACT_UP,
    IBL_FACT_YAW,
    IBL_FACT_LIGHTS,
    IBL_FACT_PRIMARIES,
    IBL_FACT_TRANSFER,
    IBL_FACT_EXPOSURE,
    IBL_FACT_CLAMP,
    IBL_FACTS
};

typedef struct ibl_about {
    const char *who;         /* path of the file that says it */
    unsigned said;           /* bits 1 << fact */
    unsigned firm;           /* those that a program says, and no file can;
                                1 << IBL_FACTS: the roughness */
    double value[IBL_FACTS]; /* a number, or NAN if it is none; of a word its
                                index among those that there are, or -1; 0: not
                                said */
    const char *word[IBL_FACTS];
    int levels; /* that have a roughness; 0: not said, -1: damaged */
    double roughness[IBL_MAX_LEVELS];
} ibl_about;

/* Words belong to tex or the sidecar. */
ibl_about ibl_about_keys(const ibl_texture *tex, const char *path);
/* entry: what it says of a file; NULL: only what is said of all. */
ibl_about ibl_about_sidecar(const json_t *sidecar, const json_t *entry,
                            const char *path);
ibl_about ibl_about_asked(const ibl_set_facts *facts);

/* Adds what another says. What is known already holds. IBL_ERR_FORMAT: it says
 * what has no meaning. */
ibl_status ibl_about_add(ibl_ctx *ctx, ibl_about *known,
                         const ibl_about *other);

ibl_set_facts ibl_about_facts(const ibl_about *a);

/* ---- sidecars ---------------------------------------------------------- */

/* What it says of the output whose member has that value; NULL: nothing. */
json_t *ibl_sidecar_entry(const json_t *sidecar, const char *member,
                          const char *value);

#endif
