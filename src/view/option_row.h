/* SPDX-License-Identifier: MIT */
/* Rows of the tables of options, and what is made from them. */
#ifndef VIEW_OPTION_ROW_H
#define VIEW_OPTION_ROW_H

#include <stdio.h>

#include "view/options.h"

typedef enum view_option_kind {
    VIEW_OPTION_ON,     /* bool, set; no value */
    VIEW_OPTION_OFF,    /* bool, cleared; no value */
    VIEW_OPTION_INT,    /* int in low..high */
    VIEW_OPTION_REAL,   /* double in low..high */
    VIEW_OPTION_CHOICE, /* int or enumeration: index of a name */
    VIEW_OPTION_TEXT,   /* const char *, not empty */
    VIEW_OPTION_OTHER,  /* parse decides */
    VIEW_OPTION_KEYS,
    VIEW_OPTION_MATERIALS,
    VIEW_OPTION_HELP,
    VIEW_OPTION_VERSION /* these four print and end */
} view_option_kind;

typedef struct view_option {
    const char *name; /* without the dashes */
    char letter;      /* short form, or 0 */
    view_option_kind kind;
    const char *value; /* what the value is called; NULL for a flag */
    size_t offset;     /* of the field in view_options */
    double low, high;
    const char *(*choice)(int i); /* NULL after the last */
    /* Takes a value into the options, or returns false. */
    bool (*parse)(void *options, const char *value);
    const char *allowed;  /* allowed values in words; NULL: from the rest */
    const char *standard; /* the default in words; NULL: from the field,
                             "": none to speak of */
    const char *help;
} view_option;

/* Options under one heading of --help. */
typedef struct view_section {
    const char *title;
    const view_option *options;
    int count;
} view_section;

extern const view_section view_sections[]; /* ended by a NULL title */

view_options view_options_default(void);
/* Checks what can only be judged with every option known. */
bool view_options_finish(view_options *o);

/* The values that an option takes, in words; "" for a flag or text. */
void view_option_allowed(const view_option *opt, char *text, size_t size);
/* The whole --help, at most 80 columns. */
void view_options_help(FILE *to);

#endif
