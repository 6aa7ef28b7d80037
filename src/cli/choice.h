/* SPDX-License-Identifier: MIT */
/* What was found and chosen for --rendered-error, as a table. */
#ifndef CLI_CHOICE_H
#define CLI_CHOICE_H

#include <jansson.h>
#include <stdbool.h>
#include <stdio.h>

enum {
    IBL_CHOICE_ROWS = 48
};

/* What was found and chosen, and the figures beside those of the defaults. */
typedef struct ibl_choice {
    int count;
    struct {
        bool chosen; /* false: found */
        const char *name;
        char text[320]; /* a value, then perhaps a tab and why */
    } row[IBL_CHOICE_ROWS];
    double asked; /* error; NAN: there is no choice */
    bool reached;
    double error, standard_error, usual_error; /* as measured */
    size_t bytes, usual_bytes; /* of texels, without containers */
} ibl_choice;

/* Add a row; rows beyond IBL_CHOICE_ROWS are dropped, long texts are cut. */
void ibl_choice_add(ibl_choice *c, bool chosen, const char *name,
                    const char *fmt, ...) __attribute__((format(printf, 4, 5)));

void ibl_choice_print(const ibl_choice *c, FILE *to);
json_t *ibl_choice_json(const ibl_choice *c); /* NULL: no memory */

#endif
