/* SPDX-License-Identifier: MIT */
/* The command line. */
#ifndef VIEW_OPTIONS_H
#define VIEW_OPTIONS_H

#include <stdbool.h>
#include <stdio.h>

#include "view/baked_set.h"
#include "view/settings.h"

/* What the rows or columns of a contact sheet go through. */
typedef enum view_axis {
    VIEW_AXIS_MATERIAL,
    VIEW_AXIS_TURN,    /* by quarters */
    VIEW_AXIS_TONE,    /* the tone curves */
    VIEW_AXIS_EV,      /* 2 stops down to 2 stops up */
    VIEW_AXIS_LEVEL,   /* the specular levels themselves */
    VIEW_AXIS_COMPARE, /* split sum, reference, both, difference */
    VIEW_AXES
} view_axis;

extern const char *const view_axis_names[VIEW_AXES + 1]; /* NULL at the end */

typedef struct view_options {
    view_request request;
    const char *offscreen;     /* picture to write, or NULL */
    const char *contact_sheet; /* or NULL */
    const char *probe_set;     /* index of baked probes, or NULL */
    const char *save_probes;   /* directory to write captures to, or NULL */
    int rows, columns;         /* view_axis of the contact sheet */
    int size[2];               /* 0: default of what is made */
    int grid[2];               /* rows, columns; 0 before it is settled */
    int frames, samples;       /* 0: not asked for */
    double texel[2];           /* pixel to tell of; negative: none */
    bool quiet, verbose, stats;
    view_settings settings;
} view_options;

enum {
    VIEW_DEFAULT_SAMPLES = 256, /* of the reference in pictures */
    VIEW_FRAME_SAMPLES = 16     /* that a frame of a picture adds */
};

/* From the words of the command line, ended by NULL; strings point into them.
 * False: the program ends with *status, after --help or a message. */
bool view_options_parse(char **words, view_options *o, int *status);

/* Prints what --keys asks for; key_bindings.c has the list. */
void view_print_keys(FILE *to);

/* False, with a message, if nothing is at PATH or an option does not fit what
 * is there; reads only the first bytes. */
bool view_options_may(const view_options *o);
/* False, with a message, if the options ask for what a set does not have. */
bool view_options_suit(const view_options *o, const baked_set *set);

#endif
