/* SPDX-License-Identifier: MIT */
/*
 * legendre.h for vectors of VD rings: sums with the functions of
 * legendre_lanes.h. As many sums stay in registers as there are, so
 * that the multiply-adds are what takes time: over rings in the analysis, for
 * two k at a time with 32 registers; over k in the synthesis, for two vectors
 * of rings.
 */
#include <string.h>

#include "kern/legendre_lanes.h"

enum {
    /* k in the analysis, vectors of rings in the synthesis: 24 sums in the 32
     * registers of AVX-512, else 12 in 16. */
    AT_ONCE = VD == 8 ? 2 : 1
};

/* ---- six sums at a time --------------------------------------------- */

/* Named, not an array: they are to stay in registers. */
struct six {
    vd a, b, c, d, e, f;
};

static inline struct six six_zero(void)
{
    const vd z = vd_all(0.0);

    return (struct six){z, z, z, z, z, z};
}

/* acc + r data, six vectors. */
static inline struct six six_fma(struct six acc, vd r, const double *data)
{
    return (struct six){vd_fma(r, vd_load(data), acc.a),
                        vd_fma(r, vd_load(data + VD), acc.b),
                        vd_fma(r, vd_load(data + 2 * VD), acc.c),
                        vd_fma(r, vd_load(data + 3 * VD), acc.d),
                        vd_fma(r, vd_load(data + 4 * VD), acc.e),
                        vd_fma(r, vd_load(data + 5 * VD), acc.f)};
}

/* acc + r coefficient, six numbers. */
static inline struct six six_fma_all(struct six acc, vd r, const double *c)
{
    return (struct six){
        vd_fma(r, vd_all(c[0]), acc.a), vd_fma(r, vd_all(c[1]), acc.b),
        vd_fma(r, vd_all(c[2]), acc.c), vd_fma(r, vd_all(c[3]), acc.d),
        vd_fma(r, vd_all(c[4]), acc.e), vd_fma(r, vd_all(c[5]), acc.f)};
}

static inline void six_store(vd *to, struct six s)
{
    to[0] = s.a;
    to[1] = s.b;
    to[2] = s.c;
    to[3] = s.d;
    to[4] = s.e;
    to[5] = s.f;
}

static inline struct six six_load(const vd *from)
{
    return (struct six){from[0], from[1], from[2], from[3], from[4], from[5]};
}

/* ---- analysis ------------------------------------------------------- */

/* The differences of the rows on both sides of VD edges and of their mirror
 * images, from north j on. */
static inline void load_pairs(const ibl_legendre_rings *r, int j,
                              const float *ring, vd *north, vd *south)
{
    const int mirror = r->count - VD - j;

    if (j + VD <= r->count / 2) {
        *north = vd_load_floats(ring + j + 1) - vd_load_floats(ring + j);
        *south = vd_reverse(vd_load_floats(ring + mirror + 1) -
                            vd_load_floats(ring + mirror));
        return;
    }
    *north = *south = vd_all(0.0);
    for (int i = 0; i < VD && j + i < r->pairs; i++) {
        const float *n = ring + j + i, *s = ring + mirror + VD - 1 - i;
        (*north)[i] = (double)n[1] - (double)n[0];
        if (j + i < r->count / 2)
            (*south)[i] = (double)s[1] - (double)s[0];
    }
}

/* Asks for the input of the chunk that begins with j. */
static void prefetch_chunk(const ibl_legendre_rings *r, int j, const float *f,
                           size_t stride)
{
    const int left = r->pairs - j, count = left < CHUNK ? left : CHUNK;

    for (int part = 0; part < 6 && left > 0; part++, f += stride) {
        for (int i = 0; i < count; i += 16) {
            __builtin_prefetch(f + j + i);
            __builtin_prefetch(f + (r->count - 1 - j - i));
        }
    }
}

/* north + south, and x (north - south), of the chunk that begins with j. */
static void gather_chunk(struct work *w, int j, const float *f, size_t stride)
{
    const ibl_legendre_rings *r = w->rings;

    for (int v = w->active; v < w->vectors; v++) {
        const int at = j + v * VD;
        const vd x = vd_load(r->x + at);
        const vd sine = vd_load(r->sine + at), weight = sine * sine;
        double *to = w->data + (size_t)v * SUMS * VD;
        for (int part = 0; part < 6; part++, to += VD) {
            vd n, s;
            load_pairs(r, at, f + (size_t)part * stride, &n, &s);
            n *= weight;
            s *= weight;
            vd_store(to, n + s);
            vd_store(to + 6 * VD, x * (n - s));
        }
    }
}

/* Adds the totals of count vectors to sums. */
static inline void add_totals(const vd *acc, int count, double *sums)
{
    for (int i = 0; i < count; i += VD)
        vd_store(sums + i, vd_load(sums + i) + vd_totals(acc + i));
}

/* Sums over the chunk for AT_ONCE k from k on. */
static void sum_over_rings(struct work *w, int j, int k, int v)
{
    const double *x2 = w->rings->x2 + j + v * VD;
    double *now = w->now + v * VD, *last = w->last + v * VD;
    const double *data = w->data + (size_t)v * SUMS * VD;
    const double *end = w->data + (size_t)w->vectors * SUMS * VD;
    struct six even[AT_ONCE], odd[AT_ONCE];
    vd alpha[AT_ONCE], beta[AT_ONCE], totals[AT_ONCE * SUMS];

#pragma GCC unroll 2
    for (int i = 0; i < AT_ONCE; i++) {
        alpha[i] = vd_all(w->alpha[k + i]);
        beta[i] = vd_all(w->beta[k + i]);
        even[i] = odd[i] = six_zero();
    }
    for (; data < end; data += SUMS * VD, now += VD, last += VD, x2 += VD) {
        const vd x = vd_load(x2);
        vd r[AT_ONCE + 2] = {vd_load(last), vd_load(now)};
#pragma GCC unroll 2
        for (int i = 0; i < AT_ONCE; i++)
            r[i + 2] = vd_fma(vd_fma(alpha[i], x, beta[i]), r[i + 1], r[i]);
        vd_store(last, r[AT_ONCE]);
        vd_store(now, r[AT_ONCE + 1]);
#pragma GCC unroll 2
        for (int i = 0; i < AT_ONCE; i++) {
            even[i] = six_fma(even[i], r[i + 1], data);
            odd[i] = six_fma(odd[i], r[i + 1], data + 6 * VD);
        }
    }
#pragma GCC unroll 2
    for (int i = 0; i < AT_ONCE; i++) {
        six_store(totals + i * SUMS, even[i]);
        six_store(totals + i * SUMS + 6, odd[i]);
    }
    add_totals(totals, AT_ONCE * SUMS, w->sums + (size_t)k * SUMS);
}

static void analyse_chunk(struct work *w, int j)
{
    for (int b = 0; b < w->blocks; b++) {
        int v = w->vectors;
        for (int i = w->active; i < w->vectors; i++) {
            if (b)
                come_in(w, i, b);
            if (w->from_block[i] <= b && i < v)
                v = i;
        }
        for (int k = b * BLOCK; k < (b + 1) * BLOCK && k < w->terms;
             k += AT_ONCE)
            sum_over_rings(w, j, k, v);
    }
}

/* to = p a + q b, six numbers. */
static inline void blend_six(double p, const double *a, double q,
                             const double *b, double *to)
{
    const __m128d u = _mm_set1_pd(p), v = _mm_set1_pd(q);

    for (int i = 0; i < 6; i += 2)
        _mm_storeu_pd(to + i,
                      u * _mm_loadu_pd(a + i) + v * _mm_loadu_pd(b + i));
}

/* The coefficients from sums with R_k. */
static void finish(const struct work *w, double *a)
{
    const int count = w->o->degree - w->o->m + 1;
    const double *now = w->sums, *before = now;

    for (int k = 0; k < w->terms; k++, a += SUMS) {
        blend_six(w->even[k], now, w->before[k], before, a);
        if (2 * k + 1 < count)
            blend_six(w->odd[k], now + 6, 0.0, now + 6, a + 6);
        before = now;
        now += SUMS;
    }
}

static void analyse(const ibl_legendre_order *o, const float *f, size_t stride,
                    double *a)
{
    struct work w = layout(o);

    prefetch_chunk(o->rings, 0, f, stride);
    fill_coefficients(&w);
    memset(w.sums, 0, (size_t)w.blocks * BLOCK * SUMS * sizeof *w.sums);
    for (int j = 0; j < o->rings->pairs; j += CHUNK) {
        start_chunk(&w, j);
        gather_chunk(&w, j, f, stride);
        prefetch_chunk(o->rings, j + CHUNK, f, stride);
        analyse_chunk(&w, j);
    }
    finish(&w, a);
}

/* ---- synthesis ------------------------------------------------------ */

/* The sums' coefficients of R_k: those of P_m+2k and P_m+2k+2, which both
 * hold it, and of P_m+2k+1. */
static void combine(struct work *w, const double *a, const double *factor)
{
    const int count = w->o->degree - w->o->m + 1;
    double *c = w->sums;

    factor += w->o->m;
    for (int l = 0; l < count; l += 2, a += SUMS, c += SUMS) {
        const int k = l / 2;
        const bool odd = l + 1 < count, after = l + 2 < count;
        blend_six(w->even[k] * factor[l], a,
                  after ? w->before[k + 1] * factor[l + 2] : 0.0,
                  after ? a + SUMS : a, c);
        blend_six(odd ? w->odd[k] * factor[l + 1] : 0.0, odd ? a + 6 : a, 0.0,
                  a, c + 6);
    }
}

/* Sums for k from..until - 1 of AT_ONCE vectors from v on, added to acc or, if
 * fresh, in its place. */
static void sum_over_k(struct work *w, int j, int v, int from, int until,
                       bool fresh, vd acc[AT_ONCE * SUMS])
{
    const double *c = w->sums + (size_t)from * SUMS;
    const double *x2 = w->rings->x2 + j + v * VD;
    double *now = w->now + v * VD, *last = w->last + v * VD;
    struct six even[AT_ONCE], odd[AT_ONCE];
    vd x[AT_ONCE], r[AT_ONCE], r_last[AT_ONCE];

#pragma GCC unroll 2
    for (int i = 0; i < AT_ONCE; i++) {
        x[i] = vd_load(x2 + i * VD);
        r[i] = vd_load(now + i * VD);
        r_last[i] = vd_load(last + i * VD);
        even[i] = fresh ? six_zero() : six_load(acc + i * SUMS);
        odd[i] = fresh ? six_zero() : six_load(acc + i * SUMS + 6);
    }
    for (int k = from; k < until; k++, c += SUMS) {
#pragma GCC unroll 2
        for (int i = 0; i < AT_ONCE; i++)
            even[i] = six_fma_all(even[i], r[i], c);
#pragma GCC unroll 2
        for (int i = 0; i < AT_ONCE; i++)
            odd[i] = six_fma_all(odd[i], r[i], c + 6);
#pragma GCC unroll 2
        for (int i = 0; i < AT_ONCE; i++)
            recur(w, k, x[i], &r[i], &r_last[i]);
    }
#pragma GCC unroll 2
    for (int i = 0; i < AT_ONCE; i++) {
        vd_store(now + i * VD, r[i]);
        vd_store(last + i * VD, r_last[i]);
        six_store(acc + i * SUMS, even[i]);
        six_store(acc + i * SUMS + 6, odd[i]);
    }
}

/* VD rings and their mirror images, from north j on. */
static inline void store_pairs(const ibl_legendre_rings *r, int j, float *ring,
                               vd north, vd south)
{
    const int mirror = r->count - VD - j;

    if (j + VD <= r->count / 2) {
        vd_store_floats(ring + j, north);
        vd_store_floats(ring + mirror, vd_reverse(south));
        return;
    }
    for (int i = 0; i < VD && j + i < r->pairs; i++) {
        ring[j + i] = (float)north[i];
        ring[mirror + VD - 1 - i] = (float)south[i];
    }
}

static void store_vector(const ibl_legendre_rings *r, int j, const vd acc[SUMS],
                         float *g, size_t stride)
{
    const vd x = vd_load(r->x + j);

    for (int part = 0; part < 6; part++) {
        const vd odd = x * acc[6 + part];
        store_pairs(r, j, g + (size_t)part * stride, acc[part] + odd,
                    acc[part] - odd);
    }
}

/* AT_ONCE vectors from v on: stretches of k between which rings come in. */
static void synthesise_side(struct work *w, int j, int v,
                            vd acc[AT_ONCE * SUMS])
{
    int b = w->blocks, until = 0;
    bool fresh = true;

    for (int i = v; i < v + AT_ONCE; i++) {
        b = w->from_block[i] < b ? w->from_block[i] : b;
        until = w->until_block[i] > until ? w->until_block[i] : until;
    }
    for (; b < until; b++, fresh = false) {
        for (int i = v; i < v + AT_ONCE; i++)
            come_in(w, i, b);
        sum_over_k(w, j, v, b * BLOCK, (b + 1) * BLOCK, fresh, acc);
    }
    for (int i = v; i < v + AT_ONCE && b; i++)
        come_in(w, i, b);
    sum_over_k(w, j, v, b * BLOCK, w->terms, fresh, acc);
}

/* The rings of `vectors` vectors from north j on, in which nothing comes in. */
static void store_nothing(const ibl_legendre_rings *r, int j, int vectors,
                          float *g, size_t stride)
{
    const int left = r->pairs - j;
    const size_t n = (size_t)(left < vectors * VD ? left : vectors * VD);

    for (int part = 0; part < 6; part++, g += stride) {
        memset(g + j, 0, n * sizeof *g);
        memset(g + (size_t)(r->count - j) - n, 0, n * sizeof *g);
    }
}

static void synthesise_chunk(struct work *w, int j, float *g, size_t stride)
{
    const int active = w->active / AT_ONCE * AT_ONCE;
    vd acc[AT_ONCE * SUMS];

    store_nothing(w->rings, j, active, g, stride);
    /* To a multiple of AT_ONCE: the others do not come in. */
    for (int v = active; v < w->active; v++)
        w->from_block[v] = NEVER;
    for (; w->vectors % AT_ONCE; w->vectors++) {
        w->from_block[w->vectors] = NEVER;
        w->until_block[w->vectors] = -1;
        vd_store(w->now + w->vectors * VD, vd_all(0.0));
        vd_store(w->last + w->vectors * VD, vd_all(0.0));
    }
    for (int v = active; v < w->vectors; v += AT_ONCE) {
        synthesise_side(w, j, v, acc);
        for (int i = 0; i < AT_ONCE; i++)
            store_vector(w->rings, j + (v + i) * VD, acc + i * SUMS, g, stride);
    }
}

static void synthesise(const ibl_legendre_order *o, const double *a,
                       const double *factor, float *g, size_t stride)
{
    struct work w = layout(o);

    fill_coefficients(&w);
    combine(&w, a, factor);
    for (int j = 0; j < o->rings->pairs; j += CHUNK) {
        start_chunk(&w, j);
        synthesise_chunk(&w, j, g, stride);
    }
}

IBL_VECTOR_KERNEL(ibl_legendre, analyse, synthesise)
