/* SPDX-License-Identifier: MIT */
/* A set of files in memory, as a shader gets it. */
#ifndef CLI_CANDIDATE_H
#define CLI_CANDIDATE_H

#include "cli/job.h"
#include "cli/rendered.h"

typedef struct ibl_candidate {
    ibl_bake_result made; /* of the cubes that the files have, and harmonics */
    ibl_lut lut;          /* these two empty if they are not wanted */
    ibl_lobe_table lobes;
} ibl_candidate;

/*
 * Makes the outputs of o->only, as ibl_opts_select left the options, of a map
 * without the lights that are taken out of it; in the world's axes.
 * False after a message through ctx.
 *   out  to be freed with ibl_candidate_free, also then
 */
bool ibl_candidate_bake(ibl_ctx *ctx, const ibl_image *map, const ibl_opts *o,
                        ibl_candidate *out);

/* Replaces the values by those that the files give back, of o's pixel format or
 * engine. */
bool ibl_candidate_round(ibl_ctx *ctx, const ibl_opts *o, ibl_candidate *c);

/* The bytes of texels, without containers, of the outputs of o->only but the
 * skybox, of which none is made. */
size_t ibl_candidate_bytes(const ibl_opts *o);

/* Draws with what a candidate has; what it lacks stays as it is. */
void ibl_candidate_draw(ibl_drawn *set, const ibl_candidate *c);

void ibl_candidate_free(ibl_candidate *c); /* zeroed is fine */

#endif
