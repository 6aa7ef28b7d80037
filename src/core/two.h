/* SPDX-License-Identifier: MIT */
/* Two doubles, in one vector on most CPUs: for loops that are too small for a
 * kernel. They have the operators of gcc and clang. */
#ifndef IBL_CORE_TWO_H
#define IBL_CORE_TWO_H

#include <string.h>

typedef double ibl_two __attribute__((vector_size(16)));

static inline ibl_two ibl_two_at(const double *p)
{
    ibl_two v;
    memcpy(&v, p, sizeof v);
    return v;
}

static inline void ibl_two_put(double *p, ibl_two v)
{
    memcpy(p, &v, sizeof v);
}

/* The same of floats. */
typedef float ibl_two_floats __attribute__((vector_size(8)));

static inline ibl_two ibl_two_at_floats(const float *p)
{
    ibl_two_floats v;
    memcpy(&v, p, sizeof v);
    return __builtin_convertvector(v, ibl_two);
}

static inline void ibl_two_put_floats(float *p, ibl_two v)
{
    const ibl_two_floats f = __builtin_convertvector(v, ibl_two_floats);
    memcpy(p, &f, sizeof f);
}

#endif
