/* SPDX-License-Identifier: MIT */
/* The sets that may be chosen for --rendered-error: what they are made of,
 * their bytes, and the error that can be expected of them. */
#ifndef CLI_CHOOSE_SET_H
#define CLI_CHOOSE_SET_H

#include "cli/bake_record.h"

enum {
    IBL_SET_VALUES = 80,   /* of one part */
    IBL_SET_COUNTS = 8,    /* numbers of levels, from 1 */
    IBL_SET_TABLES = 7,    /* sizes of the lobe table */
    IBL_SET_SMALL = 8192,  /* all but chains */
    IBL_SET_LEAST_EDGE = 4 /* of a level */
};

/* What a set is made of, in the order in which it is made coarser. */
enum {
    IBL_SET_SIZE,
    IBL_SET_LEVELS,
    IBL_SET_PIXEL,
    IBL_SET_LOBES, /* edge of the lobe table */
    IBL_SET_IRRADIANCE,
    IBL_SET_LUT,
    IBL_SET_PARTS
};

/* Values that a part may take, and what each adds to the square of a set's
 * error that the finest does not, 0 or more. */
typedef struct ibl_values {
    int count;
    int value[IBL_SET_VALUES];
    double error[IBL_SET_VALUES];
} ibl_values;

/* A chain that may be taken, with squared errors. */
typedef struct ibl_chain {
    ibl_specular_layout layout; /* levels 0: not yet known */
    double least;               /* with the best lobe table; -1: none */
    /* Judged with a table of each size, less what the parts add; 0: not yet */
    double own[IBL_SET_TABLES];
} ibl_chain;

/* A set: indices of values. Errors are squared. */
typedef struct ibl_pick {
    int at[IBL_SET_PARTS];
    int ladder; /* of levels; 0: its chain's, 1: Filament's, 2: linear */
    size_t bytes;
    double sum;   /* what its parts add by the sums */
    double error; /* of the whole set */
} ibl_pick;

typedef struct ibl_search {
    ibl_bake_source *from;
    ibl_opts *o;
    ibl_expectation *e;
    double power[IBL_MAX_POWER_DEGREE + 1];
    int degree; /* of the power */
    size_t most_bytes;
    double most_parts; /* squared error that the parts may add */
    bool fits;         /* the levels' roughnesses are free */
    bool table;        /* there are lobe tables */
    ibl_values part[IBL_SET_PARTS];
    ibl_lut luts[IBL_SET_VALUES];
    ibl_lobe_table lobes; /* the last, and the options that it was made for */
    ibl_lobe_table_options made;
    /* All parts but chains, by pixel and bytes; the more, the better. */
    ibl_pick small[IBL_SET_SMALL];
    int small_count;
    double ratio; /* the least of chains' own over least; 0: none was judged */
    ibl_chain chain[IBL_SET_VALUES][IBL_SET_COUNTS];
} ibl_search;

static inline bool ibl_opts_want(const ibl_opts *o, ibl_output_kind kind)
{
    return o->only & 1u << kind;
}

/* 0 counts as one. */
static inline bool ibl_is_power(int edge)
{
    return (edge & (edge - 1)) == 0;
}

static inline ibl_chain *ibl_chain_of(ibl_search *s, const ibl_pick *p)
{
    return &s->chain[p->at[IBL_SET_SIZE]][p->at[IBL_SET_LEVELS]];
}

static inline int ibl_set_value(const ibl_search *s, const ibl_pick *p,
                                int part)
{
    return s->part[part].value[p->at[part]];
}

/* Bytes of texels in the outputs that o asks for, but the skybox. */
size_t ibl_opts_bytes(const ibl_opts *o);

size_t ibl_chain_bytes(int size, int levels, ibl_pixel pixel);

/* The parts as the options have them; levels 0: the default number. */
void ibl_set_given(const ibl_opts *o, int value[IBL_SET_PARTS]);

/* The sets of all values of the parts first..end - 1, one after the other, *p
 * beginning with zeros. False: there is no other. */
bool ibl_set_next(const ibl_search *s, int first, int end, ibl_pick *p);

/* The same of chains. */
bool ibl_chain_next(const ibl_search *s, ibl_pick *p);

/* Of the set's levels. False: after a message. */
bool ibl_set_layout(ibl_search *s, const ibl_pick *p,
                    ibl_specular_layout *layout);

size_t ibl_set_bytes(ibl_search *s, const ibl_pick *p);

/* The squared error of a set, of which the parts of a mask are as exact as can
 * be. */
bool ibl_set_error(ibl_search *s, const ibl_pick *p, unsigned exact,
                   double *square);

/* Sets the bytes of a set and its error as a whole. */
bool ibl_set_judge(ibl_search *s, ibl_pick *p);

/* What a part adds to the squared error of a set that was judged, 0 or more. */
bool ibl_set_added(ibl_search *s, const ibl_pick *p, int part, double *added);

/* Whether a part is none of the chain, and may be chosen. */
bool ibl_set_is_small(const ibl_search *s, int part);

/* The parts that the error of a chain alone leaves out: those that may be
 * chosen, and the table. */
unsigned ibl_beside_chain(const ibl_search *s);

/* Finds the layout of a chain and its error with the best table. */
bool ibl_chain_measure(ibl_search *s, const ibl_pick *p, ibl_chain *c);

/* False: there is no such chain, or after a message. */
bool ibl_chain_make(ibl_search *s, const ibl_pick *p);

/* Lists the values of the parts that neither the user nor the target fixed, and
 * what each adds to the error. */
bool ibl_search_list(ibl_search *s, const ibl_materials *materials);

#endif
