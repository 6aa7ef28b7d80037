/* SPDX-License-Identifier: MIT */
/* How a texture was baked: what its keys iblbake.* say, and a sidecar. */
#ifndef SET_ACCOUNT_H
#define SET_ACCOUNT_H

#include <stdbool.h>

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

typedef struct ibl_account {
    const char *who; /* path of the file that says it, for messages */
    unsigned said;   /* bits 1 << fact */
    unsigned skip;   /* those that are not added; 1 << IBL_FACTS: roughness */
    double value[IBL_FACTS]; /* a number, or NAN if it is none; of a word its
                                index among those that there are, or -1 */
    const char *word[IBL_FACTS];
    int levels; /* that have a roughness; 0: not said, -1: damaged */
    double roughness[IBL_MAX_LEVELS];
} ibl_account;

/* Texts of both belong to tex, or to the sidecar. */
ibl_account ibl_account_of_keys(const ibl_texture *tex, const char *path);
/* entry: of the texture; NULL: what the sidecar says of all. */
ibl_account ibl_account_of_sidecar(const json_t *sidecar, const json_t *entry,
                                   const char *path);

/* Adds what another says to what is known. What is known holds: *differs is set
 * where they differ. IBL_ERR_FORMAT: something new has no meaning. */
ibl_status ibl_account_add(ibl_ctx *ctx, ibl_account *known,
                           const ibl_account *other, int *differs);

/* The facts that need not be added, since a program says them. */
unsigned ibl_account_skip(const ibl_set_facts *asked);
/* What is known in the end. */
ibl_set_facts ibl_account_facts(const ibl_account *known,
                                const ibl_set_facts *asked);

/* ---- sidecars ---------------------------------------------------------- */

/* ibl_json_load of a sidecar; decodes its file names, to any bytes. */
json_t *ibl_sidecar_load(const char *path, ibl_json_why *why);

/* The entry of the output whose member has that value; NULL: none. */
json_t *ibl_sidecar_entry(const json_t *sidecar, const char *member,
                          const char *value);

#endif
