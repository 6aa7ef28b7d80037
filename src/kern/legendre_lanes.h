/* SPDX-License-Identifier: MIT */
/*
 * Legendre functions on groups of RINGS rings, in vectors of VD: an order's
 * coefficients, and how rings start. What a group does depends on all of its
 * rings, so that results do not depend on VD. The sums are in legendre_simd.c.
 *
 * Even and odd l - m from one recurrence in x^2 (Ishioka 2018, "A new
 * recurrence formula for efficient computation of spherical harmonic
 * transform", J. Met. Soc. Japan 96). With
 *     e_l = sqrt((l^2 - m^2) / (4 l^2 - 1)),   x P_l = e_l+1 P_l+1 + e_l P_l-1,
 *     r_k = P_m+2k+1 / x,   even in x,
 * the recurrence taken once and twice is
 *     P_m+2k  = e_m+2k+1 r_k + e_m+2k r_k-1
 *     x^2 r_k = A_k r_k+1 + B_k r_k + A_k-1 r_k-1,
 *     A_k = e_m+2k+2 e_m+2k+3,   B_k = e_m+2k+2^2 + e_m+2k+1^2,
 * and with r_k = s_k R_k, s_k+1 = -s_k-1 A_k-1 / A_k,
 *     R_k+1 = (alpha_k x^2 + beta_k) R_k + R_k-1,
 *     alpha_k = s_k / (A_k s_k+1),   beta_k = -B_k alpha_k:
 * two products for two degrees. The sums use R_k only: the input or output
 * of odd l - m contains x, and the coefficients combine r_k and r_k-1.
 */
#ifndef IBL_KERN_LEGENDRE_LANES_H
#define IBL_KERN_LEGENDRE_LANES_H

#include <math.h>
#include <string.h>

#include "kern/lanes.h"
#include "kern/legendre.h"

enum {
    RINGS = 4,          /* in a group */
    PARTS = RINGS / VD, /* vectors of a group */
    BLOCK = 8,          /* in k: rings join at multiples of it */
    CHUNK = 256, /* pairs of rings, whose data fit the first-level cache */
    CHUNK_GROUPS = CHUNK / RINGS,
    SUMS = 12,       /* 6 parts for even l - m, 6 for odd */
    ROW = 16,        /* floats for a k in the synthesis: SUMS, alpha, beta */
    NEVER = 1 << 30, /* block of rings that never join */
    STARTS_AT = -36  /* exponent of R_k from which rings join: s_k <= 2^7 */
};

typedef unsigned long long vu __attribute__((vector_size(8 * VD)));

/* ---- what lanes.h has not ------------------------------------------- */

/* vd_signs(mask) is not 0 if a lane of a mask is set. */

#if VD == 4
static inline unsigned vd_signs(vd v)
{
    return (unsigned)_mm256_movemask_pd(v);
}

static inline vd vd_reverse(vd v)
{
    return _mm256_permute4x64_pd(v, 0x1B);
}

static inline vd vd_totals(const vd v[VD])
{
    const vd a = _mm256_hadd_pd(v[0], v[1]), b = _mm256_hadd_pd(v[2], v[3]);

    return _mm256_permute2f128_pd(a, b, 0x20) +
           _mm256_permute2f128_pd(a, b, 0x31);
}
#else
static inline unsigned vd_signs(vd v)
{
#ifdef IBL_NEON
    return vmaxvq_u32((uint32x4_t)v);
#else
    const vl signs = (vl)v < 0;

    return (unsigned)((signs[0] & 1) | (signs[1] & 2));
#endif
}

static inline vd vd_reverse(vd v)
{
    return (vd){v[1], v[0]};
}

static inline vd vd_totals(const vd v[VD])
{
#ifdef IBL_NEON
    return vpaddq_f64(v[0], v[1]);
#else
    return (vd){v[0][0], v[1][0]} + (vd){v[0][1], v[1][1]};
#endif
}
#endif

/* The e with |v| = f 2^e, 1 <= f < 2; v must be normal. */
static inline vd vd_exponent(vd v)
{
    const vu field = ((vu)v << 1) >> 53;

    return (vd)(field | 0x4330000000000000) - vd_all(0x1p52 + 1023);
}

/* 2^e; e must be whole, -1022..1023. */
static inline vd vd_power_of_two(vd e)
{
    return (vd)((vu)(e + vd_all(0x1p52 + 1023)) << 52);
}

static inline vd vd_only(vl mask, vd v)
{
    return (vd)(mask & (vl)v);
}

/* ---- an order's coefficients ---------------------------------------- */

/* Arrays are in the caller's scratch. Tables over k have `blocks` whole blocks
 * and room for another vector. */
struct work {
    const ibl_legendre_order *o;
    const ibl_legendre_rings *rings;
    int terms;             /* number of k */
    int blocks;            /* blocks of BLOCK terms */
    double *alpha, *beta;  /* coefficients of the recurrence */
    double *odd;           /* s_k: P_m+2k+1 = x odd R_k */
    double *even, *before; /* P_m+2k = even R_k + before R_k-1 */
    double first;          /* R_0 / (sin theta)^m */
    double *sums;          /* [k][SUMS] */
    /* for a chunk of rings: */
    double *now, *last;            /* R_k and R_k-1; 0 before the ring joins */
    double *late_now, *late_last;  /* their values when it joins */
    double *block;                 /* block in which it joins, or NEVER */
    double *data;                  /* [vector][SUMS][VD] */
    int from_block[CHUNK_GROUPS];  /* first block in which a ring joins */
    int until_block[CHUNK_GROUPS]; /* last block in which one does */
    int groups, active;            /* groups before `active` never join */
    int late;                      /* those from here on join at once */
    /* In floats, for blocks from `single` on and rings that have joined: */
    int single;
    float *rows; /* [k][ROW] */
    float *x2_single, *now_single, *last_single;
    float *data_single; /* [vector][SUMS][VF] */
};

static struct work layout(const ibl_legendre_order *o)
{
    const int terms = (o->degree - o->m) / 2 + 1;
    const int blocks = (terms + BLOCK - 1) / BLOCK;
    const size_t size = ((size_t)blocks + 2) * BLOCK;
    double *p = o->scratch;

    return (struct work){
        .o = o,
        .rings = o->rings,
        .terms = terms,
        .blocks = blocks,
        .alpha = p,
        .beta = p + size,
        .odd = p + 2 * size,
        .even = p + 3 * size,
        .before = p + 4 * size,
        .sums = p + 5 * size,
        .now = p + 17 * size,
        .last = p + 17 * size + CHUNK,
        .late_now = p + 17 * size + 2 * CHUNK,
        .late_last = p + 17 * size + 3 * CHUNK,
        .block = p + 17 * size + 4 * CHUNK,
        .data = p + 17 * size + 5 * CHUNK,
        .single = o->single > o->m
                      ? (o->single - o->m + 2 * BLOCK - 1) / (2 * BLOCK)
                      : 0,
        .rows = (float *)(p + 17 * size + 17 * CHUNK),
        .x2_single = (float *)(p + 25 * size + 17 * CHUNK),
        .now_single = (float *)(p + 25 * size + 17 * CHUNK) + CHUNK,
        .last_single = (float *)(p + 25 * size + 17 * CHUNK) + 2 * CHUNK,
        .data_single = (float *)(p + 25 * size + 17 * CHUNK) + 4 * CHUNK,
    };
}

static inline vd counting(double from, double by)
{
    vd v;

    for (int i = 0; i < VD; i++)
        v[i] = from + by * i;
    return v;
}

/* Writes e_m+2k to before, e_m+2k+1 to even, -B_k to beta: with l = m + 2k,
 *     e_l^2   = (l - m) (l + m) (2l + 3) / d
 *     e_l+1^2 = (l + 1 - m) (l + 1 + m) (2l - 1) / d
 *     d       = (2l - 1) (2l + 1) (2l + 3). */
static void fill_roots(struct work *w)
{
    const vd m = vd_all(w->o->m), one = vd_all(1.0);
    const int count = w->blocks * BLOCK;
    double *alpha = w->alpha, *beta = w->beta;
    double *before = w->before, *even = w->even;

    for (int k = 0; k < count + BLOCK; k += VD) {
        const vd i = counting(2.0 * k, 2.0), l = i + m, l2 = l + l;
        const vd low = l2 - one, high = l2 + vd_all(3.0);
        const vd inverse = one / (low * (l2 + one) * high);
        const vd e = i * (l + m) * high * inverse;
        const vd e1 = (i + one) * (l + m + one) * low * inverse;
        vd_store(before + k, vd_sqrt(e));
        vd_store(even + k, vd_sqrt(e1));
        vd_store(beta + k, e1);
        vd_store(alpha + k, e);
    }
    for (int k = 0; k < count; k += VD)
        vd_store(beta + k,
                 vd_all(0.0) - vd_load(beta + k) - vd_load(alpha + k + 1));
}

/* A_k, computed from before and even. */
static inline vd product(const struct work *w, int k)
{
    return vd_load(w->before + k + 1) * vd_load(w->even + k + 1);
}

/* s_0 = s_1 = 1 / sqrt(A_0), then s_k+1 = -s_k-1 A_k-1 / A_k. Leaves A_k in the
 * memory of the sums. */
static void fill_scales(struct work *w)
{
    const int count = w->blocks * BLOCK;
    double *a = w->sums, *s = w->odd;

    for (int k = 0; k < count; k += VD)
        vd_store(a + k, product(w, k));
    s[0] = s[1] = 1.0 / sqrt(a[0]);
    for (int k = 1; k + 1 < count; k += VD)
        vd_store(s + k + 1, vd_load(a + k - 1) / vd_load(a + k));
    for (int k = 2; k < count; k++)
        s[k] *= -s[k - 2];
    s[count] = -s[count - 2] * a[count - 2] / a[count - 1];
}

static void fill_coefficients(struct work *w)
{
    const double *a = w->sums, *odd = w->odd; /* A_k, left by fill_scales */
    double *alpha = w->alpha, *beta = w->beta;
    double *before = w->before, *even = w->even;

    fill_roots(w);
    fill_scales(w);
    w->first = w->rings->start[w->o->m] / (w->even[0] * w->odd[0]);
    for (int k = w->blocks * BLOCK - VD; k >= 0; k -= VD) {
        const vd s = vd_load(odd + k), next = vd_load(odd + k + 1);
        const vd of_x2 = s / (vd_load(a + k) * next);
        vd_store(alpha + k, of_x2);
        vd_store(beta + k, vd_load(beta + k) * of_x2);
        vd_store(even + k, vd_load(even + k) * s);
        /* The s of before[k + 1] is that of k. */
        vd_store(before + k + 1, vd_load(before + k + 1) * s);
    }
    w->before[0] = 0.0;
}

/* ---- how rings start ------------------------------------------------ */

/* R_k = now 2^exponent and R_k-1 = last 2^exponent. */
struct scaled {
    vd now, last, exponent;
};

static inline struct scaled normalised(struct scaled s)
{
    const vd now = vd_abs(s.now), last = vd_abs(s.last);
    const vd e = vd_exponent(vd_either((vl)(now > last), now, last));
    const vd scale = vd_power_of_two(vd_all(0.0) - e);

    return (struct scaled){s.now * scale, s.last * scale, s.exponent + e};
}

/* v^n. */
static inline vd power(vd v, int n)
{
    vd p = n & 1 ? v : vd_all(1.0);

    while (n >>= 1) {
        v *= v;
        if (n & 1)
            p *= v;
    }
    return p;
}

/* R_0 of the rings j..j + VD - 1, in the north. */
static inline struct scaled at_first(const struct work *w, int j)
{
    const int m = w->o->m, low = m & 511, high = m >> 9;
    const ibl_legendre_rings *r = w->rings;
    struct scaled s = {.now = vd_all(w->first) *
                              power(vd_load(r->mantissa + j), low),
                       .last = vd_all(0.0),
                       .exponent = vd_all(m) * vd_load(r->exponent + j)};

    if (high) {
        s.now *= power(vd_load(r->mantissa_512 + j), high);
        s.exponent += vd_all(high) * vd_load(r->exponent_512 + j);
    }
    return normalised(s);
}

/* R_k-1, in last, becomes R_k+1. */
static inline void recur(const struct work *w, int k, vd x2, vd now, vd *last)
{
    const vd t = vd_fma(vd_all(w->alpha[k]), x2, vd_all(w->beta[k]));
    *last = vd_fma(t, now, *last);
}

/* Sizes of `now` from which a lane joins or must be normalised; infinite for
 * lanes that have joined. `now` grows by less than 2^200 in a block. */
static inline vd look_at(vd exponent, vl done)
{
    const vd left = vd_all(STARTS_AT) - exponent, most = vd_all(200.0);

    return vd_either(done, vd_all(INFINITY),
                     vd_power_of_two(vd_either((vl)(left < most), left, most)));
}

/* A vector of a group some of whose rings do not matter yet at k = 0. A ring
 * joins with the first block in which it matters. */
struct follower {
    struct scaled s, begin; /* now, and when the block began */
    vd x2, late_now, late_last, at, look;
    vl done;
};

static inline struct follower follower_of(struct scaled s, vd x2)
{
    const vd zero = vd_all(0.0);
    return (struct follower){.s = s,
                             .x2 = x2,
                             .late_now = zero,
                             .late_last = zero,
                             .at = vd_all(NEVER),
                             .look = look_at(s.exponent, (vl)zero),
                             .done = (vl)zero};
}

/* Lets rings of group v join that matter after block b. */
static inline void join(struct work *w, int v, struct follower f[PARTS], int b)
{
    unsigned some = 0;

#pragma GCC unroll 2
    for (int h = 0; h < PARTS; h++)
        some |= vd_signs((vd)(vl)(vd_abs(f[h].s.now) >= f[h].look));
    if (!some)
        return;
    some = 0;
#pragma GCC unroll 2
    for (int h = 0; h < PARTS; h++) {
        struct follower *g = &f[h];
        g->s = normalised(g->s);
        const vl in = (vl)(g->s.exponent >= vd_all(STARTS_AT)) & ~g->done;
        const vd scale = vd_power_of_two(g->begin.exponent);
        g->done |= in;
        g->look = look_at(g->s.exponent, g->done);
        g->late_now = vd_either(in, g->begin.now * scale, g->late_now);
        g->late_last = vd_either(in, g->begin.last * scale, g->late_last);
        g->at = vd_either(in, vd_all(b), g->at);
        some |= vd_signs((vd)in);
    }
    if (!some)
        return;
    if (w->from_block[v] == NEVER)
        w->from_block[v] = b;
    w->until_block[v] = b;
}

static inline void keep(struct work *w, int v, const struct follower f[PARTS])
{
#pragma GCC unroll 2
    for (int h = 0; h < PARTS; h++) {
        const int i = v * RINGS + h * VD;
        const vl first = (vl)(f[h].at == vd_all(0.0));
        vd_store(w->now + i, vd_only(first, f[h].late_now));
        vd_store(w->last + i, vd_only(first, f[h].late_last));
        vd_store(w->late_now + i, f[h].late_now);
        vd_store(w->late_last + i, f[h].late_last);
        vd_store(w->block + i, f[h].at);
    }
}

/* Starts groups v and v - 1, if that is a group, by following them along k
 * until all their rings have joined, or to the end: a step waits for the last
 * one. Returns how many of them join. */
static int start_pair(struct work *w, int j, int v)
{
    const int group[2] = {v, v > w->active ? v - 1 : v};
    struct follower f[2 * PARTS];
    vl done = (vl)vd_all(0.0);

#pragma GCC unroll 4
    for (int i = 0; i < 2 * PARTS; i++) {
        const int at = j + group[i / PARTS] * RINGS + i % PARTS * VD;
        f[i] = follower_of(at_first(w, at), vd_load(w->rings->x2 + at));
    }
    w->from_block[v] = w->from_block[group[1]] = NEVER;
    w->until_block[v] = w->until_block[group[1]] = -1;
    for (int b = 0; b < w->blocks && vd_signs((vd)~done); b++) {
#pragma GCC unroll 4
        for (int i = 0; i < 2 * PARTS; i++)
            f[i].begin = f[i].s;
#pragma GCC unroll 4
        for (int k = b * BLOCK; k < (b + 1) * BLOCK; k += 2)
#pragma GCC unroll 4
            for (int i = 0; i < 2 * PARTS; i++) {
                recur(w, k, f[i].x2, f[i].s.now, &f[i].s.last);
                recur(w, k + 1, f[i].x2, f[i].s.last, &f[i].s.now);
            }
        join(w, v, f, b);
        join(w, group[1], f + PARTS, b);
        done = f[0].done;
#pragma GCC unroll 4
        for (int i = 1; i < 2 * PARTS; i++)
            done &= f[i].done;
    }
    keep(w, v, f);
    keep(w, group[1], f + PARTS);
    return w->from_block[v] == NEVER                          ? 0
           : group[1] < v && w->from_block[group[1]] != NEVER ? 2
                                                              : 1;
}

/* Pairs of rings in the chunk that begins with ring j. */
static inline int ring_pairs(const struct work *w, int j)
{
    const int left = w->rings->pairs - j;
    return left < CHUNK ? left : CHUNK;
}

/* Starts the groups active..groups - 1 of the chunk that begins with ring j:
 * R_0 of the rings that matter at k = 0, and the later start values of the
 * other rings. Runs from the equator to the pole and stops at the first group
 * whose rings never join: those nearer to the pole do not join either. */
static void start_chunk(struct work *w, int j)
{
    const vd nothing = vd_all(STARTS_AT);

    int v = w->groups - 1;
    for (; v >= w->active; v--) {
        struct scaled s[PARTS];
        unsigned early = 0;
#pragma GCC unroll 2
        for (int h = 0; h < PARTS; h++) {
            s[h] = at_first(w, j + v * RINGS + h * VD);
            early |= vd_signs((vd)(vl)(s[h].exponent < nothing));
        }
        if (early)
            break;
#pragma GCC unroll 2
        for (int h = 0; h < PARTS; h++) {
            const int i = v * RINGS + h * VD;
            vd_store(w->now + i, s[h].now * vd_power_of_two(s[h].exponent));
            vd_store(w->last + i, vd_all(0.0));
        }
        w->from_block[v] = 0;
        w->until_block[v] = 0;
    }
    w->late = v + 1;
    while (v >= w->active) {
        const int joined = start_pair(w, j, v);
        if (joined < 2 && v - joined >= w->active)
            w->active = v - joined + 1;
        v -= 2;
    }
}

/* Makes v a group without rings. */
static inline void make_empty(struct work *w, int v)
{
    w->from_block[v] = NEVER;
    w->until_block[v] = -1;
    memset(w->now + v * RINGS, 0, RINGS * sizeof *w->now);
    memset(w->last + v * RINGS, 0, RINGS * sizeof *w->last);
}

/* The block from which groups v and v + 1 are summed in floats. Those that
 * never join may be, too. */
static inline int single_from(const struct work *w, int v)
{
    int b = w->single;
    for (int i = v; i < v + 2; i++)
        if (i >= w->active && w->until_block[i] >= b)
            b = w->until_block[i] + 1;
    return b;
}

/* Turns the state of groups v and v + 1 into floats. */
static inline void to_single(struct work *w, int j, int v)
{
    for (int i = v * RINGS; i < (v + 2) * RINGS; i += VD) {
        vd_store_floats(w->x2_single + i, vd_load(w->rings->x2 + j + i));
        vd_store_floats(w->now_single + i, vd_load(w->now + i));
        vd_store_floats(w->last_single + i, vd_load(w->last + i));
    }
}

/* Starts the rings of group v that join with block b > 0. */
static inline void come_in(struct work *w, int v, int b)
{
    if (b < w->from_block[v] || b > w->until_block[v] || !w->until_block[v])
        return;
    for (int i = v * RINGS; i < (v + 1) * RINGS; i += VD) {
        const vl in = (vl)(vd_load(w->block + i) == vd_all(b));
        vd_store(w->now + i,
                 vd_either(in, vd_load(w->late_now + i), vd_load(w->now + i)));
        vd_store(w->last + i, vd_either(in, vd_load(w->late_last + i),
                                        vd_load(w->last + i)));
    }
}

#endif
