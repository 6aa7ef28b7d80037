/* SPDX-License-Identifier: MIT */
#include "kern/reflection.h"

#include <math.h>
#include <stdbool.h>

static int place(const ibl_reflection_row *row, const double *cosine,
                 const double *sine, int n, ibl_reflection_points *p)
{
    int whole = 0;

    for (int i = 0; i < IBL_REFLECTION_BLOCK; i++) {
        double l[3];
        for (int k = 0; k < 3; k++)
            l[k] = row->at[k] + row->ahead[k] * cosine[i] +
                   row->aside[k] * sine[i];
        const double x = l[0] + row->sv, z = l[2] + row->nv;
        const double s2 = x * x + l[1] * l[1], c2 = z * z, h2 = s2 + c2;
        const double miss = 1 - 0.5 * sqrt(h2), miss2 = miss * miss;
        p->z[i] = l[2];
        p->s2[i] = s2;
        p->c2[i] = c2;
        const bool kept =
            i < n && s2 + row->wide * c2 >= row->least && l[2] >= row->low;
        p->mass[i] = kept ? row->solid_angle * l[2] * h2 * h2 : 0;
        p->fc[i] = miss2 * miss2 * miss;
        whole += kept;
    }
    return whole;
}

static double divisor(const ibl_reflection_shape *s, double z, double s2,
                      double c2)
{
    const double q = s2 + s->a2 * c2;

    switch (s->kind) {
    case IBL_REFLECTION_SMITH:
        return q * q * (s->v * z + s->nv * sqrt(s->a2 + (1 - s->a2) * z * z));
    case IBL_REFLECTION_SCHLICK:
        return q * q * (s->v + (1 - s->v) * z);
    case IBL_REFLECTION_LOBE:
        break;
    }
    return q * q;
}

static void add(const ibl_reflection_shape *shape,
                const ibl_reflection_points *p, const double *rgb,
                size_t stride, int count, double sum[8])
{
    for (int i = 0; i < count; i++) {
        if (!(p->mass[i] > 0))
            continue;
        const double w =
            p->mass[i] / divisor(shape, p->z[i], p->s2[i], p->c2[i]);
        for (int c = 0; c < 4; c++) {
            const double light =
                c < 3 ? w * rgb[(size_t)c * stride + (size_t)i] : w;
            sum[c] += light;
            if (shape->kind != IBL_REFLECTION_LOBE)
                sum[4 + c] += light * p->fc[i];
        }
    }
}

IBL_KERNEL(ibl_reflection, place, add)
