/* SPDX-License-Identifier: MIT */
/* What was found and chosen for --rendered-error, as a table. */
#ifndef CLI_CHOICE_H
#define CLI_CHOICE_H

#include <jansson.h>
#include <stdbool.h>
#include <stdio.h>

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
    double least; /* error there is, if that asked is not reached */
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

#endif
