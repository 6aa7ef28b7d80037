/* SPDX-License-Identifier: MIT */
/* The table that the parser and --help are made from. */
#ifndef CLI_OPTION_H
#define CLI_OPTION_H

#include "cli/opts.h"

typedef enum ibl_option_kind {
    IBL_OPTION_FLAG,   /* int, set to 1; no value */
    IBL_OPTION_INT,    /* int in low..high */
    IBL_OPTION_REAL,   /* double in low..high */
    IBL_OPTION_CHOICE, /* int, the index of the value in choices */
    IBL_OPTION_TEXT,   /* const char *, not empty */
    IBL_OPTION_OTHER   /* parse decides */
} ibl_option_kind;

typedef struct ibl_option {
    const char *group; /* heading in --help, the same string for all of it */
    const char *name;  /* without the dashes */
    char letter;       /* short form, or 0 */
    ibl_option_kind kind;
    const char *value; /* what the value is called; NULL for a flag */
    size_t offset;     /* of the field in ibl_opts */
    double low, high;
    const char *const *choices; /* ended by NULL */
    /* Takes a value or returns false. */
    bool (*parse)(ibl_opts *o, const char *value);
    const char *allowed;  /* allowed values in words; NULL: from the rest */
    const char *standard; /* the default in words; NULL: from the field,
                             "": none to speak of */
    const char *help;
} ibl_option;

extern const ibl_option ibl_option_table[];
extern const int ibl_option_count;

/* Options before any argument was seen. */
ibl_opts ibl_opts_default(void);
/* The values that an option takes, in words ("" for a flag or text). */
void ibl_option_allowed(const ibl_option *opt, char *text, size_t size);
/* Its default in words ("" if there is none to speak of). */
void ibl_option_standard(const ibl_option *opt, char *text, size_t size);

#endif
