/* SPDX-License-Identifier: MIT */
/* In vectors of any width. */
#include "kern/lanes.h"
#include "kern/reflection.h"

static inline vd component(const ibl_reflection_row *row, int k, vd cosine,
                           vd sine)
{
    return vd_fma(vd_all(row->ahead[k]), cosine,
                  vd_fma(vd_all(row->aside[k]), sine, vd_all(row->at[k])));
}

static int place(const ibl_reflection_row *row, const double *cosine,
                 const double *sine, int n, ibl_reflection_points *p)
{
    static const double count[8] = {0, 1, 2, 3, 4, 5, 6, 7};
    vl whole = {0};

    for (int i = 0; i < IBL_REFLECTION_BLOCK; i += VD) {
        const vd cos_phi = vd_load(cosine + i), sin_phi = vd_load(sine + i);
        const vd lz = component(row, 2, cos_phi, sin_phi);
        const vd x = component(row, 0, cos_phi, sin_phi) + row->sv;
        const vd y = component(row, 1, cos_phi, sin_phi), z = lz + row->nv;
        const vd s2 = vd_fma(x, x, y * y), c2 = z * z, h2 = s2 + c2;
        const vd miss = 1 - 0.5 * vd_sqrt(h2), miss2 = miss * miss;
        const vl kept = (s2 + row->wide * c2 >= row->least) & (lz >= row->low) &
                        (vd_load(count) < (double)(n - i));
        vd_store(p->z + i, lz);
        vd_store(p->s2 + i, s2);
        vd_store(p->c2 + i, c2);
        vd_store(p->mass + i,
                 (vd)(kept & (vl)(row->solid_angle * lz * (h2 * h2))));
        vd_store(p->fc + i, miss2 * miss2 * miss);
        whole -= kept;
    }
    int sum = 0;
    for (int k = 0; k < VD; k++)
        sum += (int)whole[k];
    return sum;
}

/* Of a mass of 0 the quotient can be NaN: z may be below the horizon. */
static inline vd weight(const ibl_reflection_shape *s, ibl_reflection_kind kind,
                        const ibl_reflection_points *p, int i)
{
    const vd z = vd_load(p->z + i), mass = vd_load(p->mass + i);
    const vd q = vd_fma(vd_all(s->a2), vd_load(p->c2 + i), vd_load(p->s2 + i));
    vd d = q * q;

    if (kind == IBL_REFLECTION_SMITH)
        d *= s->v * z +
             s->nv * vd_sqrt(vd_fma((1 - s->a2) * z, z, vd_all(s->a2)));
    if (kind == IBL_REFLECTION_SCHLICK)
        d *= s->v + (1 - s->v) * z;
    return (vd)((mass > 0) & (vl)(mass / d));
}

static inline double total(vd v)
{
    double sum = 0;

    for (int k = 0; k < VD; k++)
        sum += v[k];
    return sum;
}

/* For a kind that is known to the compiler. */
static inline __attribute__((always_inline)) void
add_kind(const ibl_reflection_shape *shape, ibl_reflection_kind kind,
         const ibl_reflection_points *p, const double *rgb, size_t stride,
         int count, double sum[8])
{
    const size_t sums = kind == IBL_REFLECTION_LOBE ? 4 : 8;
    vd part[8];

    for (size_t k = 0; k < sums; k++)
        part[k] = vd_all(0);
    for (int i = 0; i < count; i += VD) {
        const vd w = weight(shape, kind, p, i);
        const vd wf = w * vd_load(p->fc + i);
#pragma GCC unroll 3
        for (size_t c = 0; c < 3; c++) {
            const vd light = vd_load(rgb + c * stride + i);
            part[c] = vd_fma(w, light, part[c]);
            if (sums == 8)
                part[4 + c] = vd_fma(wf, light, part[4 + c]);
        }
        part[3] += w;
        if (sums == 8)
            part[7] += wf;
    }
    for (size_t k = 0; k < sums; k++)
        sum[k] += total(part[k]);
}

static void add(const ibl_reflection_shape *shape,
                const ibl_reflection_points *p, const double *rgb,
                size_t stride, int count, double sum[8])
{
    switch (shape->kind) {
    case IBL_REFLECTION_SMITH:
        add_kind(shape, IBL_REFLECTION_SMITH, p, rgb, stride, count, sum);
        break;
    case IBL_REFLECTION_SCHLICK:
        add_kind(shape, IBL_REFLECTION_SCHLICK, p, rgb, stride, count, sum);
        break;
    case IBL_REFLECTION_LOBE:
        add_kind(shape, IBL_REFLECTION_LOBE, p, rgb, stride, count, sum);
        break;
    }
}

IBL_VECTOR_KERNEL(ibl_reflection, place, add)
