/* SPDX-License-Identifier: MIT */
/* Chooses the outputs of fewest bytes whose expected rendered error is at most
 * that of --rendered-error, and keeps what was found and chosen as a table. */
#ifndef CLI_CHOICE_H
#define CLI_CHOICE_H

#include <jansson.h>

#include "cli/bake_record.h"

enum {
    IBL_CHOICE_ROWS = 48,
    IBL_CHOICE_BYTES = 160
};

typedef struct ibl_choice_row {
    bool chosen; /* false: found */
    char name[32], value[IBL_CHOICE_BYTES];
    char why[IBL_CHOICE_BYTES]; /* "": no reason */
} ibl_choice_row;

/* What was found and chosen, and the figures beside those of the defaults. */
typedef struct ibl_choice {
    int count;
    ibl_choice_row row[IBL_CHOICE_ROWS];
    double asked; /* error; NAN: there is no choice */
    bool reached;
    double error, usual_error;
    size_t bytes, usual_bytes; /* of texels, without containers */
} ibl_choice;

/* Add a row; rows beyond IBL_CHOICE_ROWS are dropped, long texts are cut. */
void ibl_choice_found(ibl_choice *c, const char *name, const char *fmt, ...)
    __attribute__((format(printf, 3, 4)));
void ibl_choice_chose(ibl_choice *c, const char *name, const char *value,
                      const char *fmt, ...)
    __attribute__((format(printf, 4, 5)));

void ibl_choice_print(const ibl_choice *c, FILE *to);
json_t *ibl_choice_json(const ibl_choice *c); /* NULL: no memory */

/* Bytes of texels in the outputs that o asks for, but the skybox. */
size_t ibl_opts_bytes(const ibl_opts *o);

/*
 * Chooses size, levels, mapping, pixel format, irradiance or harmonics and the
 * sizes of the tables, other than those that the user or the target fixed, and
 * changes the options accordingly. What cannot be reached is replaced by the
 * nearest that can, of fewest bytes within 5 %.
 *   from  its environment was read
 */
bool ibl_choose(ibl_bake_source *from, const ibl_materials *materials,
                ibl_opts *o, ibl_choice *choice);

#endif
