/* SPDX-License-Identifier: MIT */
/* kern/strip_coverage.h in vectors of any width. */
#include "kern/lanes.h"
#include "kern/strip_coverage.h"

/* a < b ? x : y */
#if VD == 8
static inline vd if_less(vd a, vd b, vd x, vd y)
{
    return _mm512_mask_blend_pd(_mm512_cmp_pd_mask(a, b, _CMP_LT_OQ), y, x);
}
#elif VD == 4
static inline vd if_less(vd a, vd b, vd x, vd y)
{
    return _mm256_blendv_pd(y, x, _mm256_cmp_pd(a, b, _CMP_LT_OQ));
}
#else
static inline vd if_less(vd a, vd b, vd x, vd y)
{
    const vd mask = _mm_cmplt_pd(a, b);
    return _mm_or_pd(_mm_and_pd(mask, x), _mm_andnot_pd(mask, y));
}
#endif

struct points {
    vd q, r;
    vd cosine, slope;
};

static inline struct points points_at(vd a, vd q, vd r)
{
    const vd inverse = vd_all(1) / vd_sqrt(a * a + q * q);
    const vd slope = -(r * (a * a)) * (inverse * inverse * inverse);
    return (struct points){q, r, q * inverse, slope};
}

static inline struct points crossings(vd a, double cosine, double tangent)
{
    const vd q = a / vd_all(tangent), r2 = vd_all(1) - q * q;
    const vd r = vd_sqrt(if_less(vd_all(0), r2, r2, vd_all(0)));
    const double sine = cosine * tangent;
    return (struct points){q, r, vd_all(cosine),
                           -r * vd_all(sine * sine * sine) / a};
}

/* a < b ? x : y */
static inline struct points pick(vd a, vd b, struct points x, struct points y)
{
    return (struct points){if_less(a, b, x.q, y.q), if_less(a, b, x.r, y.r),
                           if_less(a, b, x.cosine, y.cosine),
                           if_less(a, b, x.slope, y.slope)};
}

static inline vd angles_between(struct points a, struct points b)
{
    const vd s = b.r * a.q - b.q * a.r, s2 = s * s;
    return s * (vd_all(1) + s2 * (vd_all(1.0 / 6) + s2 * vd_all(3.0 / 40)));
}

static inline vd shares_of(const ibl_coverage_row *row,
                           const ibl_coverage_cuts *c, int i)
{
    const vd top = vd_all(row->top), bottom = vd_all(row->bottom);
    const vd a = vd_load(c->a + i), zero = vd_all(0), one = vd_all(1);
    const struct points begin =
        points_at(a, vd_load(c->q[0] + i), vd_load(c->r[0] + i));
    const struct points end =
        points_at(a, vd_load(c->q[1] + i), vd_load(c->r[1] + i));
    const struct points leave = crossings(a, row->bottom, row->bottom_tan);
    const struct points enter = crossings(a, row->top, row->top_tan);
    const vd below =
        if_less(end.cosine, bottom, angles_between(leave, end), zero);
    const struct points low = pick(end.cosine, bottom, leave, end);
    const struct points high = pick(top, begin.cosine, enter, begin);
    const vd inside = angles_between(high, low);
    const vd mean = vd_all(0.5) * (high.cosine + low.cosine) +
                    (high.slope - low.slope) * inside * vd_all(1.0 / 12);
    const vd per_cosine = vd_all(1 / (row->top - row->bottom));
    vd share =
        (inside * ((top - mean) * per_cosine) + below) / vd_load(c->width + i);
    share = if_less(share, zero, zero, share);
    share = if_less(one, share, one, share);
    share = if_less(bottom, begin.cosine, share, one);
    return if_less(end.cosine, top, share, zero);
}

static void shares(const ibl_coverage_row *row, const ibl_coverage_cuts *cuts,
                   int count, double *share)
{
    for (int i = 0; i < count; i += VD)
        vd_store(share + i, shares_of(row, cuts, i));
}

IBL_VECTOR_KERNEL(ibl_coverage, shares)
