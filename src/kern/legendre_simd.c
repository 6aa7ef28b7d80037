/* SPDX-License-Identifier: MIT */
/*
 * legendre.h for vectors of VD rings: sums with the functions of
 * legendre_lanes.h. As many sums as possible stay in registers, so that
 * multiply-adds take most of the time. The analysis sums over rings, for two k
 * at a time with 32 registers; the synthesis sums over k, for two vectors of
 * rings.
 */
#include <string.h>

#include "kern/legendre_lanes.h"

enum {
    /* k in the analysis, vectors of rings in the synthesis: 32 registers hold
     * 24 sums, 16 hold 12. */
    AT_ONCE = REGISTERS / 16
};
_Static_assert(AT_ONCE *SUMS % VD == 0, "analysis adds whole vectors");

/* ---- analysis ------------------------------------------------------- */

/* The differences of the rows beside VD edges. */
static inline vd differences(const float *rows)
{
    return vd_load_floats(rows + 1) - vd_load_floats(rows);
}

/* What gather_chunk computes, for fewer than VD edges from north j on. */
static void gather_last(const ibl_legendre_rings *r, int j, const float *f,
                        size_t stride, double *to)
{
    memset(to, 0, SUMS * VD * sizeof *to);
    for (int i = j; i < j + VD && i < r->pairs; i++, to++)
        for (size_t part = 0; part < 6; part++) {
            const float *north = f + part * stride + i;
            const float *south = f + part * stride + (r->count - 1 - i);
            const double weight = r->sine[i] * r->sine[i];
            const double n = ((double)north[1] - (double)north[0]) * weight;
            const double s = ((double)south[1] - (double)south[0]) * weight;
            const bool twin = i < r->count / 2; /* its mirror image */
            to[part * VD] = twin ? n + s : n;
            to[(6 + part) * VD] = r->x[i] * (twin ? n - s : n);
        }
}

/* Computes north + south, x (north - south) for the chunk from ring j on. */
static void gather_chunk(struct work *w, int j, const float *f, size_t stride)
{
    const ibl_legendre_rings *r = w->rings;
    const int begin = w->o->first - j, end = w->o->end - j;

    w->active = begin > 0 ? begin / VD : 0;
    w->vectors = ((end < CHUNK ? end : CHUNK) + VD - 1) / VD;
    for (int v = w->active; v < w->vectors; v++) {
        const int at = j + v * VD;
        const vd sine = vd_load(r->sine + at), weight = sine * sine;
        const vd x = vd_load(r->x + at);
        const float *north = f + at, *south = f + (r->count - VD - at);
        double *to = w->data + (size_t)v * SUMS * VD;

        if (at + VD > r->count / 2) {
            gather_last(r, at, f, stride, to);
            continue;
        }
#pragma GCC unroll 6
        for (int p = 0; p < 6; p++, north += stride, south += stride) {
            const vd n = differences(north) * weight;
            const vd s = vd_reverse(differences(south)) * weight;
            vd_store(to + p * VD, n + s);
            vd_store(to + (6 + p) * VD, x * (n - s));
        }
    }
}

/* Adds vectors v..until - 1 to the sums of AT_ONCE k, from k on. */
static void sum_over_rings(struct work *w, int j, int k, int v, int until)
{
    const double *x2 = w->rings->x2 + j + v * VD;
    double *now = w->now + v * VD, *last = w->last + v * VD;
    const double *data = w->data + (size_t)v * SUMS * VD;
    const double *end = w->data + (size_t)until * SUMS * VD;
    vd alpha[AT_ONCE], beta[AT_ONCE], sums[AT_ONCE][SUMS] = {{{0}}};

#pragma GCC unroll 2
    for (int i = 0; i < AT_ONCE; i++) {
        alpha[i] = vd_all(w->alpha[k + i]);
        beta[i] = vd_all(w->beta[k + i]);
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
        for (int i = 0; i < AT_ONCE; i++)
#pragma GCC unroll 12
            for (int p = 0; p < SUMS; p++)
                sums[i][p] =
                    vd_fma(r[i + 1], vd_load(data + p * VD), sums[i][p]);
    }
#pragma GCC unroll 12
    for (int i = 0; i < AT_ONCE * SUMS; i += VD) {
        double *to = w->sums + (size_t)k * SUMS + i;
        vd_store(to, vd_load(to) + vd_totals(sums[0] + i));
    }
}

/* The same in floats for the vectors from v on. */
static void sum_singles(struct work *w, int k, int v)
{
    const float *x2 = w->x2_single + v * VD;
    float *now = w->now_single + v * VD, *last = w->last_single + v * VD;
    const float *data = w->data_single + (size_t)v * SUMS * VD;
    const float *end = w->data_single + (size_t)w->vectors * SUMS * VD;
    vf alpha[AT_ONCE], beta[AT_ONCE], sums[AT_ONCE][SUMS] = {{{0}}};
    vd total[AT_ONCE * SUMS];

#pragma GCC unroll 2
    for (int i = 0; i < AT_ONCE; i++) {
        alpha[i] = vf_all((float)w->alpha[k + i]);
        beta[i] = vf_all((float)w->beta[k + i]);
    }
    for (; data < end; data += SUMS * VF, now += VF, last += VF, x2 += VF) {
        const vf x = vf_load(x2);
        vf r[AT_ONCE + 2] = {vf_load(last), vf_load(now)};
#pragma GCC unroll 2
        for (int i = 0; i < AT_ONCE; i++)
            r[i + 2] = vf_fma(vf_fma(alpha[i], x, beta[i]), r[i + 1], r[i]);
        vf_store(last, r[AT_ONCE]);
        vf_store(now, r[AT_ONCE + 1]);
#pragma GCC unroll 3
        for (int p = 0; p < SUMS; p += 4) {
            vf d[4];
            vf_load_four(data + p * VF, d);
#pragma GCC unroll 8
            for (int n = 0; n < 4 * AT_ONCE; n++)
                sums[n / 4][p + n % 4] =
                    vf_fma(r[n / 4 + 1], d[n % 4], sums[n / 4][p + n % 4]);
        }
    }
#pragma GCC unroll 2
    for (int i = 0; i < AT_ONCE; i++)
#pragma GCC unroll 12
        for (int p = 0; p < SUMS; p++)
            total[i * SUMS + p] = vf_halves_added(sums[i][p]);
#pragma GCC unroll 12
    for (int i = 0; i < AT_ONCE * SUMS; i += VD) {
        double *to = w->sums + (size_t)k * SUMS + i;
        vd_store(to, vd_load(to) + vd_totals(total + i));
    }
}

/* Turns vectors v and v + 1 and their data into floats. Lanes of rings that
 * never join are zero. */
static void become_single(struct work *w, int j, int v)
{
    const double *from = w->data + (size_t)v * SUMS * VD;
    float *to = w->data_single + (size_t)v * SUMS * VD;

    to_single(w, j, v);
    for (int i = 0; i < 2; i++, from += SUMS * VD) {
        if (v + i < w->active) {
            vd_store_floats(w->now_single + (v + i) * VD, vd_all(0.0));
            vd_store_floats(w->last_single + (v + i) * VD, vd_all(0.0));
        }
        const vl none = (vl)vd_all(0.0);
        const vl joins = v + i < w->active ? none : ~none;
#pragma GCC unroll 12
        for (int p = 0; p < SUMS; p++)
            vd_store_floats(to + p * VF + i * VD,
                            vd_only(joins, vd_load(from + p * VD)));
    }
}

static void analyse_chunk(struct work *w, int j)
{
    const int doubles = w->vectors;
    int single = (w->vectors + 1) / 2 * 2;

    pad_vectors(w, 2);
    memset(w->data + (size_t)doubles * SUMS * VD, 0,
           (size_t)(w->vectors - doubles) * SUMS * VD * sizeof *w->data);
    for (int b = 0; b < w->blocks; b++) {
        int v = w->late;
        for (int i = w->active; i < w->late && i < single; i++) {
            if (b)
                come_in(w, i, b);
            if (w->from_block[i] <= b && i < v)
                v = i;
        }
        for (; single > w->active && single_from(w, single - 2) <= b;
             single -= 2)
            become_single(w, j, single - 2);
        for (int k = b * BLOCK; k < (b + 1) * BLOCK && k < w->terms;
             k += AT_ONCE) {
            if (v < single)
                sum_over_rings(w, j, k, v, single);
            if (single < w->vectors)
                sum_singles(w, k, single);
        }
    }
}

/* to = p a + q b for six numbers. */
static inline void blend_six(double p, const double *a, double q,
                             const double *b, double *restrict to)
{
#pragma GCC unroll 6
    for (int i = 0; i < 6; i++)
        to[i] = p * a[i] + q * b[i];
}

/* Computes the coefficients from the sums with R_k. */
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

    fill_coefficients(&w);
    memset(w.sums, 0, (size_t)w.blocks * BLOCK * SUMS * sizeof *w.sums);
    for (int j = o->first / CHUNK * CHUNK; j < o->end; j += CHUNK) {
        gather_chunk(&w, j, f, stride);
        start_chunk(&w, j);
        analyse_chunk(&w, j);
    }
    finish(&w, a);
}

static void add_rows(const double *edge, int from, int until, int rows,
                     const float *f, size_t stride, double sum[6])
{
    vd sums[6] = {{0}};
    int j = from;

    for (; j + VD <= until; j += VD) {
        const vd mass = vd_load(edge + j) - vd_load(edge + j + 1);
        const float *north = f + j, *south = f + rows - VD - j;
#pragma GCC unroll 6
        for (int p = 0; p < 6; p++, north += stride, south += stride)
            sums[p] = vd_fma(
                mass, vd_load_floats(north) + vd_reverse(vd_load_floats(south)),
                sums[p]);
    }
    for (int p = 0; p < 6; p++, f += stride) {
        for (int i = 0; i < VD; i++)
            sum[p] += sums[p][i];
        for (int i = j; i < until; i++)
            sum[p] += (edge[i] - edge[i + 1]) *
                      ((double)f[i] + (double)f[rows - 1 - i]);
    }
}

/* ---- synthesis ------------------------------------------------------ */

/* Computes the coefficients of R_k in the sums: from P_m+2k and P_m+2k+2, which
 * both contain R_k, and from P_m+2k+1. */
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

/* Copies what floats need of every k, and zeros after the last. */
static void fill_rows(struct work *w)
{
    for (int k = w->single * BLOCK; k < w->terms; k++) {
        const double *c = w->sums + (size_t)k * SUMS;
        float *row = w->rows + (size_t)k * ROW;
        for (int i = 0; i < SUMS; i++)
            row[i] = (float)c[i];
        row[SUMS] = (float)w->alpha[k];
        row[SUMS + 1] = (float)w->beta[k];
    }
    memset(w->rows + (size_t)w->terms * ROW, 0, ROW * sizeof *w->rows);
}

/* Sums the terms from k on, which is even, in floats for vectors v and v + 1.
 * Two values take turns as the last one. */
static void sum_singles_over_k(const struct work *w, int v, int k, vf out[SUMS])
{
    const vf x2 = vf_load(w->x2_single + v * VD);
    vf r = vf_load(w->now_single + v * VD);
    vf last = vf_load(w->last_single + v * VD), sums[SUMS] = {{0}};

    for (const float *row = w->rows + (size_t)k * ROW; k < w->terms; k += 2)
#pragma GCC unroll 2
        for (int n = 0; n < 2; n++, row += ROW) {
            const vf t = vf_fma(vf_all(row[SUMS]), x2, vf_all(row[SUMS + 1]));
            const vf next = vf_fma(t, r, last);
#pragma GCC unroll 3
            for (int p = 0; p < SUMS; p += 4)
                vf_add_four(r, row + p, sums + p);
            last = r;
            r = next;
        }
#pragma GCC unroll 12
    for (int p = 0; p < SUMS; p++)
        out[p] = sums[p];
}

/* Adds the term of R_k to the sums; R_k-1 becomes R_k+1. */
static inline void add_term(const struct work *w, int k, const double *c,
                            const vd x[AT_ONCE], const vd now[AT_ONCE],
                            vd last[AT_ONCE], vd sums[AT_ONCE][SUMS])
{
#pragma GCC unroll 2
    for (int i = 0; i < AT_ONCE; i++)
#pragma GCC unroll 6
        for (int p = 0; p < SUMS; p += 2)
            vd_add_two(now[i], c + p, sums[i] + p);
#pragma GCC unroll 2
    for (int i = 0; i < AT_ONCE; i++)
        recur(w, k, x[i], now[i], &last[i]);
}

static inline void swap(vd a[AT_ONCE], vd b[AT_ONCE])
{
#pragma GCC unroll 2
    for (int i = 0; i < AT_ONCE; i++) {
        const vd v = a[i];
        a[i] = b[i];
        b[i] = v;
    }
}

/* Adds the terms k = from..until - 1 for AT_ONCE vectors, from v on, to acc. */
static void sum_over_k(struct work *w, int j, int v, int from, int until,
                       vd acc[AT_ONCE][SUMS])
{
    const double *c = w->sums + (size_t)from * SUMS;
    const double *x2 = w->rings->x2 + j + v * VD;
    double *now = w->now + v * VD, *last = w->last + v * VD;
    vd x[AT_ONCE], r[AT_ONCE], r_last[AT_ONCE], sums[AT_ONCE][SUMS];

#pragma GCC unroll 2
    for (int i = 0; i < AT_ONCE; i++) {
        x[i] = vd_load(x2 + i * VD);
        r[i] = vd_load(now + i * VD);
        r_last[i] = vd_load(last + i * VD);
#pragma GCC unroll 12
        for (int p = 0; p < SUMS; p++)
            sums[i][p] = acc[i][p];
    }
    for (int k = from; k < until; k += 2, c += 2 * SUMS) {
        add_term(w, k, c, x, r, r_last, sums);
        if (k + 1 < until)
            add_term(w, k + 1, c + SUMS, x, r_last, r, sums);
        else
            swap(r, r_last);
    }
#pragma GCC unroll 2
    for (int i = 0; i < AT_ONCE; i++) {
        vd_store(now + i * VD, r[i]);
        vd_store(last + i * VD, r_last[i]);
#pragma GCC unroll 12
        for (int p = 0; p < SUMS; p++)
            acc[i][p] = sums[i][p];
    }
}

/* Stores fewer than VD rings, from north j on, and their mirror images. */
static void store_last(const ibl_legendre_rings *r, int j, const vd acc[SUMS],
                       float *g, size_t stride)
{
    for (int i = 0; i < VD && j + i < r->pairs; i++)
        for (size_t part = 0; part < 6; part++) {
            const double odd = r->x[j + i] * acc[6 + part][i];
            float *ring = g + part * stride;
            ring[j + i] = (float)(acc[part][i] + odd);
            ring[r->count - 1 - j - i] = (float)(acc[part][i] - odd);
        }
}

static void store_vector(const ibl_legendre_rings *r, int j, const vd acc[SUMS],
                         float *g, size_t stride)
{
    const vd x = vd_load(r->x + j);
    float *north = g + j, *south = g + (r->count - VD - j);

    if (j + VD > r->count / 2) {
        store_last(r, j, acc, g, stride);
        return;
    }
#pragma GCC unroll 6
    for (int part = 0; part < 6; part++, north += stride, south += stride) {
        const vd odd = x * acc[6 + part];
        vd_store_floats(north, acc[part] + odd);
        vd_store_floats(south, vd_reverse(acc[part] - odd));
    }
}

/* Adds the terms before k = end for AT_ONCE vectors, from v on, to acc, block
 * by block while rings join. */
static void synthesise_side(struct work *w, int j, int v, int end,
                            vd acc[AT_ONCE][SUMS])
{
    int b = w->blocks, until = 0;

    for (int i = v; i < v + AT_ONCE; i++) {
        b = w->from_block[i] < b ? w->from_block[i] : b;
        until = w->until_block[i] > until ? w->until_block[i] : until;
    }
    for (; b < until; b++) {
        for (int i = v; i < v + AT_ONCE; i++)
            come_in(w, i, b);
        sum_over_k(w, j, v, b * BLOCK, (b + 1) * BLOCK, acc);
    }
    for (int i = v; i < v + AT_ONCE && b; i++)
        come_in(w, i, b);
    sum_over_k(w, j, v, b * BLOCK, end, acc);
}

/* Writes the rings of vectors v and v + 1. */
static void synthesise_pair(struct work *w, int j, int v, float *g,
                            size_t stride)
{
    const int from = single_from(w, v) * BLOCK;
    const int end = from < w->terms ? from : w->terms;
    vd acc[2][SUMS] = {{{0}}};

    for (int i = 0; i < 2; i += AT_ONCE)
        synthesise_side(w, j, v + i, end, acc + i);
    if (end < w->terms) {
        vf rest[SUMS];
        to_single(w, j, v);
        sum_singles_over_k(w, v, end, rest);
#pragma GCC unroll 12
        for (int p = 0; p < SUMS; p++) {
            vd half[2];
            vf_widen(rest[p], half);
            acc[0][p] += half[0];
            acc[1][p] += half[1];
        }
    }
    for (int i = 0; i < 2; i++)
        store_vector(w->rings, j + (v + i) * VD, acc[i], g, stride);
}

/* Writes zeros to the rings of `vectors` vectors, from north j on. */
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
    const int active = w->active / 2 * 2;

    store_nothing(w->rings, j, active, g, stride);
    /* Round to pairs; the added vectors never join. */
    for (int v = active; v < w->active; v++) {
        w->from_block[v] = NEVER;
        w->until_block[v] = -1;
        vd_store(w->now + v * VD, vd_all(0.0));
        vd_store(w->last + v * VD, vd_all(0.0));
    }
    w->active = active;
    pad_vectors(w, 2);
    for (int v = active; v < w->vectors; v += 2)
        synthesise_pair(w, j, v, g, stride);
}

static void synthesise(const ibl_legendre_order *o, const double *a,
                       const double *factor, float *g, size_t stride)
{
    struct work w = layout(o);

    fill_coefficients(&w);
    combine(&w, a, factor);
    fill_rows(&w);
    for (int j = 0; j < o->rings->pairs; j += CHUNK) {
        w.active = 0;
        w.vectors = (ring_pairs(&w, j) + VD - 1) / VD;
        start_chunk(&w, j);
        synthesise_chunk(&w, j, g, stride);
    }
}

IBL_VECTOR_KERNEL(ibl_legendre, analyse, synthesise, add_rows)
