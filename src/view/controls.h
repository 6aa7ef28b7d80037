/* SPDX-License-Identifier: MIT */
/* What can be changed in a view: the command line, keys and the panel are made
 * from one table, with a row for each setting and option. */
#ifndef VIEW_CONTROLS_H
#define VIEW_CONTROLS_H

#include "common/option.h"
#include "view/baked_set.h"
#include "view/settings.h"

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
    int samples;               /* of the reference */
    int turntable;             /* pictures of a turn, 0: none */
    bool mean_exposure;        /* settings.ev is what makes the mean grey */
    bool labels, panel;        /* in pictures */
    bool quiet, stats;
    ibl_given given;
} view_options;

/* The picture or sheet to write; NULL: a window opens. */
static inline const char *view_options_file(const view_options *o)
{
    return o->contact_sheet ? o->contact_sheet : o->offscreen;
}

/* How the panel shows what ibl_option.parse reads. */
typedef enum view_shape {
    VIEW_AS_OPTION, /* by ibl_option.kind */
    VIEW_TWO_INTS,
    VIEW_TWO_REALS,
    VIEW_COLOUR3
} view_shape;

/* A key is a printable character or, above Unicode, a code of GLFW. */
#define VIEW_KEY(code) (0x110000 + (code))

typedef struct view_control {
    ibl_option option; /* its offset is that in view_options, which begins with
                          view_settings */
    const char *label; /* on the panel and in messages; NULL: not there */
    unsigned where;    /* modes and facts: see controls.c */
    const char *of;    /* besides, a choice must have a value; NULL: none */
    int is;            /* that value */
    int key, back;     /* the next value, the one before; 0: none */
    double step;       /* that a key adds to a real; 0: it doubles it */
    double slide[2];   /* ends of the slider; both 0: the option's limits */
    view_shape shape;
} view_control;

/* Rows under the headings of --help and the panel; ended by NULL. */
extern const ibl_section *const view_control_sections[];
/* Row number i of all sections; NULL: there are fewer. */
const view_control *view_control_at(int i);
/* The row that c->of names; NULL: it names none. */
const view_control *view_control_of(const view_control *c);

/* Why a row changes nothing in a state, and what to do, until the next call;
 * NULL: it does. probe_set: there is one of a file. */
const char *view_control_why(const view_control *c, const view_settings *s,
                             bool probe_set, const view_options *o);

/* What keys do besides. */
typedef enum view_act {
    VIEW_COPY_SIDE,
    VIEW_OTHER_SIDE,
    VIEW_MOVE_ACROSS,
    VIEW_MOVE_UP,
    VIEW_APPROACH,
    VIEW_PAUSE,
    VIEW_EXPOSE,
    VIEW_RESET,
    VIEW_LIST_FILES,
    VIEW_STEP_FILE,
    VIEW_OPEN_AGAIN,
    VIEW_WRITE_PICTURE,
    VIEW_SHOW_PANEL,
    VIEW_SHOW_KEYS,
    VIEW_FILL_SCREEN,
    VIEW_CLOSE,
    VIEW_QUIT
} view_act;

typedef struct view_action {
    const char *title, *keys, *what; /* in the list of keys */
    int key, back;                   /* 0: none */
    view_act act;
} view_action;
extern const view_action view_actions[]; /* ended by a NULL title */

/* A line of the list of keys. */
typedef struct view_key_line {
    const char *title; /* heading that it is under */
    char keys[32], what[120];
} view_key_line;
bool view_key_line_at(int i, view_key_line *line); /* false: there are fewer */
/* Prints the list for --keys. */
void view_print_keys(FILE *to);

void *view_control_field(const view_control *c, view_settings *s);
/* How many names a choice has. */
int view_control_choices(const view_control *c);
/* Changes a setting as its key does, step 1, or the other one, -1. */
void view_control_step(const view_control *c, view_settings *s, int step);
/* Its value in words. */
void view_control_text(const view_control *c, const view_settings *s,
                       char text[80]);
/* Whether it may differ between two states that are compared. */
bool view_control_of_side(const view_control *c);
/* Gives `to` all of `from` but that. */
void view_controls_share(const view_settings *from, view_settings *to);

/* ---- the command line (options.c) --------------------------------------- */

/* Parses the words of the command line, ended by NULL; strings point into them.
 * False: the program must exit with *status, after --help or a message. */
bool view_options_parse(char **words, view_options *o, int *status);

/* False, with a message, if nothing is at PATH or an option does not fit it;
 * reads only the first bytes. */
bool view_options_may(const view_options *o);
/* False, with a message, if the options ask for what a set does not have. */
bool view_options_suit(const view_options *o, const baked_set *set);

#endif
