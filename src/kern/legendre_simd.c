/* SPDX-License-Identifier: MIT */
/*
 * legendre.h for vectors of VD rings: sums with the functions of
 * legendre_recurrence_lanes.h. As many sums stay in registers as there are, so
 * that the multiply-adds are what takes time: over rings in the analysis, for
 * two k at a time with 32 registers; over k in the synthesis, for two vectors
 * of rings.
 */
#include <string.h>

#include "kern/lanes.h"
#include "kern/legendre.h"
#include "kern/legendre_recurrence_lanes.h"

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

/* F of VD rings and of their mirror images, from north j on. */
static inline void load_pairs(const ibl_legendre_rings *r, int j,
                              const float *ring, vd *north, vd *south)
{
    const int mirror = r->count - VD - j;
    const bool edges = r->kind == IBL_RINGS_EDGES;

    if (j + VD <= r->count / 2) {
        *north = vd_load_floats(ring + j);
        *south = vd_load_floats(ring + mirror);
        if (edges) {
            *north = vd_load_floats(ring + j + 1) - *north;
            *south = vd_load_floats(ring + mirror + 1) - *south;
        }
        *south = vd_reverse(*south);
        return;
    }
    *north = *south = vd_all(0.0);
    for (int i = 0; i < VD && j + i < r->pairs; i++) {
        const float *n = ring + j + i, *s = ring + mirror + VD - 1 - i;
        (*north)[i] = (double)n[edges] - (edges ? (double)n[0] : 0.0);
        if (j + i < r->count / 2)
            (*south)[i] = (double)s[edges] - (edges ? (double)s[0] : 0.0);
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
        const vd weight_n = vd_load(r->north + at);
        const vd weight_s = vd_load(r->south + at);
        double *to = w->data + (size_t)v * SUMS * VD;
        for (int part = 0; part < 6; part++, to += VD) {
            vd n, s;
            load_pairs(r, at, f + (size_t)part * stride, &n, &s);
            n *= weight_n;
            s *= weight_s;
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

#if VD == 8
enum {
    AT_ONCE = 2 /* k: 24 sums in 32 registers */
};

/* Sums over the chunk for k and k + 1. */
static void sum_over_rings(struct work *w, int j, int k, int v)
{
    const vd alpha = vd_all(w->alpha[k]), beta = vd_all(w->beta[k]);
    const vd alpha1 = vd_all(w->alpha[k + 1]), beta1 = vd_all(w->beta[k + 1]);
    const double *x2 = w->rings->x2 + j + v * VD;
    double *now = w->now + v * VD, *last = w->last + v * VD;
    const double *data = w->data + (size_t)v * SUMS * VD;
    const double *end = w->data + (size_t)w->vectors * SUMS * VD;
    struct six p = six_zero(), q = p, r = p, s = p;
    vd totals[2 * SUMS];

    for (; data < end; data += SUMS * VD, now += VD, last += VD, x2 += VD) {
        const vd r0 = vd_load(now), x = vd_load(x2);
        const vd r1 = vd_fma(vd_fma(alpha, x, beta), r0, vd_load(last));
        vd_store(last, r1);
        vd_store(now, vd_fma(vd_fma(alpha1, x, beta1), r1, r0));
        p = six_fma(p, r0, data);
        q = six_fma(q, r0, data + 6 * VD);
        r = six_fma(r, r1, data);
        s = six_fma(s, r1, data + 6 * VD);
    }
    six_store(totals, p);
    six_store(totals + 6, q);
    six_store(totals + 12, r);
    six_store(totals + 18, s);
    add_totals(totals, 2 * SUMS, w->sums + (size_t)k * SUMS);
}
#else
enum {
    AT_ONCE = 1 /* k: 12 sums in 16 registers */
};

static void sum_over_rings(struct work *w, int j, int k, int v)
{
    const vd alpha = vd_all(w->alpha[k]), beta = vd_all(w->beta[k]);
    const double *x2 = w->rings->x2 + j + v * VD;
    double *now = w->now + v * VD, *last = w->last + v * VD;
    const double *data = w->data + (size_t)v * SUMS * VD;
    const double *end = w->data + (size_t)w->vectors * SUMS * VD;
    struct six p = six_zero(), q = p;
    vd totals[SUMS];

    for (; data < end; data += SUMS * VD, now += VD, last += VD, x2 += VD) {
        const vd r = vd_load(now);
        const vd t = vd_fma(alpha, vd_load(x2), beta);
        vd_store(now, vd_fma(t, r, vd_load(last)));
        vd_store(last, r);
        p = six_fma(p, r, data);
        q = six_fma(q, r, data + 6 * VD);
    }
    six_store(totals, p);
    six_store(totals + 6, q);
    add_totals(totals, SUMS, w->sums + (size_t)k * SUMS);
}
#endif

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

/* Sums for k from..until - 1 of SIDE vectors from v on, added to acc or, if
 * fresh, in its place. */
#if VD == 8
enum {
    SIDE = 2 /* vectors at once: 24 sums in 32 registers */
};

static void sum_over_k(struct work *w, int j, int v, int from, int until,
                       bool fresh, vd acc[SIDE * SUMS])
{
    const double *c = w->sums + (size_t)from * SUMS;
    const double *x2 = w->rings->x2 + j + v * VD;
    const vd x = vd_load(x2), y = vd_load(x2 + VD);
    double *now = w->now + v * VD, *last = w->last + v * VD;
    vd r = vd_load(now), r_last = vd_load(last);
    vd s = vd_load(now + VD), s_last = vd_load(last + VD);
    struct six p = six_zero(), q = p, t = p, u = p;

    if (!fresh) {
        p = six_load(acc);
        q = six_load(acc + 6);
        t = six_load(acc + 12);
        u = six_load(acc + 18);
    }
    for (int k = from; k < until; k++, c += SUMS) {
        p = six_fma_all(p, r, c);
        t = six_fma_all(t, s, c);
        q = six_fma_all(q, r, c + 6);
        u = six_fma_all(u, s, c + 6);
        recur(w, k, x, &r, &r_last);
        recur(w, k, y, &s, &s_last);
    }
    vd_store(now, r);
    vd_store(last, r_last);
    vd_store(now + VD, s);
    vd_store(last + VD, s_last);
    six_store(acc, p);
    six_store(acc + 6, q);
    six_store(acc + 12, t);
    six_store(acc + 18, u);
}
#else
enum {
    SIDE = 1 /* 12 sums in 16 registers */
};

static void sum_over_k(struct work *w, int j, int v, int from, int until,
                       bool fresh, vd acc[SIDE * SUMS])
{
    const double *c = w->sums + (size_t)from * SUMS;
    const double *x2 = w->rings->x2 + j + v * VD;
    const vd x = vd_load(x2);
    double *now = w->now + v * VD, *last = w->last + v * VD;
    vd r = vd_load(now), r_last = vd_load(last);
    struct six p = six_zero(), q = p;

    if (!fresh) {
        p = six_load(acc);
        q = six_load(acc + 6);
    }
    for (int k = from; k < until; k++, c += SUMS) {
        p = six_fma_all(p, r, c);
        q = six_fma_all(q, r, c + 6);
        recur(w, k, x, &r, &r_last);
    }
    vd_store(now, r);
    vd_store(last, r_last);
    six_store(acc, p);
    six_store(acc + 6, q);
}
#endif

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

/* SIDE vectors from v on: stretches of k between which rings come in. */
static void synthesise_side(struct work *w, int j, int v, vd acc[SIDE * SUMS])
{
    int b = w->blocks, until = 0;
    bool fresh = true;

    for (int i = v; i < v + SIDE; i++) {
        b = w->from_block[i] < b ? w->from_block[i] : b;
        until = w->until_block[i] > until ? w->until_block[i] : until;
    }
    for (; b < until; b++, fresh = false) {
        for (int i = v; i < v + SIDE; i++)
            come_in(w, i, b);
        sum_over_k(w, j, v, b * BLOCK, (b + 1) * BLOCK, fresh, acc);
    }
    for (int i = v; i < v + SIDE && b; i++)
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
    const int active = w->active / SIDE * SIDE;
    vd acc[SIDE * SUMS];

    store_nothing(w->rings, j, active, g, stride);
    /* To a multiple of SIDE: the others do not come in. */
    for (int v = active; v < w->active; v++)
        w->from_block[v] = NEVER;
    for (; w->vectors % SIDE; w->vectors++) {
        w->from_block[w->vectors] = NEVER;
        w->until_block[w->vectors] = -1;
        vd_store(w->now + w->vectors * VD, vd_all(0.0));
        vd_store(w->last + w->vectors * VD, vd_all(0.0));
    }
    for (int v = active; v < w->vectors; v += SIDE) {
        synthesise_side(w, j, v, acc);
        for (int i = 0; i < SIDE; i++)
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

void IBL_FOR_ISA(ibl_legendre_init)(ibl_legendre_dsp *dsp)
{
    *dsp = (ibl_legendre_dsp){analyse, synthesise};
}
