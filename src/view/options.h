/* SPDX-License-Identifier: MIT */
/* The command line. */
#ifndef VIEW_OPTIONS_H
#define VIEW_OPTIONS_H

#include <stdbool.h>
#include <stdio.h>

#include "common/option.h"
#include "view/baked_set.h"
#include "view/controls.h"

typedef struct view_options {
    view_settings settings; /* the first member: see view_control */
    view_settings other;    /* of --against */
    view_request request;
    const char *offscreen;     /* picture to write, or NULL */
    const char *contact_sheet; /* or NULL */
    const char *against;       /* options of the other side, or NULL */
    const char *against_set;   /* another set to compare with, or NULL */
    const char *model;         /* scene to show, or NULL */
    const char *probe_set;     /* index of baked probes, or NULL */
    int size[2];               /* 0 until the default is set */
    int frames, samples;       /* 0: not given */
    int turntable;             /* pictures of a turn, 0: none */
    double texel[2];           /* pixel to report; negative: none */
    bool mean_exposure;        /* settings.ev is what makes the mean grey */
    bool labels, panel;        /* in pictures */
    bool quiet, verbose, stats;
    ibl_given given;
} view_options;

enum {
    VIEW_DEFAULT_ANTIALIAS = 2,
    VIEW_DEFAULT_SAMPLES = 256, /* of the reference in a picture */
    VIEW_FRAME_SAMPLES = 16     /* added by each frame of a picture */
};

/* Parses the words of the command line, ended by NULL; strings point into them.
 * False: the program must exit with *status, after --help or a message. */
bool view_options_parse(char **words, view_options *o, int *status);

/* False, with a message, if nothing is at PATH or an option does not fit it;
 * reads only the first bytes. */
bool view_options_may(const view_options *o);
/* False, with a message, if the options ask for what a set does not have. */
bool view_options_suit(const view_options *o, const baked_set *set);

#endif
