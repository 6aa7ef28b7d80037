/* SPDX-License-Identifier: MIT */
/*
 * legendre.h for vectors of VD rings: sums with the functions of
 * legendre_lanes.h. As many sums as possible stay in registers, so that
 * multiply-adds take most of the time. Sums over rings are of four lanes of
 * doubles or eight of floats, whatever VD is.
 */
#include <string.h>

#include "kern/legendre_lanes.h"

enum {
    VECTORS = 2 * RINGS / VF /* of floats, in two groups */
};

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

    w->active = 0;
    w->groups = (ring_pairs(w, j) + RINGS - 1) / RINGS;
    for (int v = 0; v < w->groups * PARTS; v++) {
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

/* Adds the lanes of sums to those of k: (0 + 1) + (2 + 3). */
static inline void add_lanes(struct work *w, int k, vd sums[PARTS][SUMS])
{
#pragma GCC unroll 12
    for (int i = 0; i < SUMS; i += VD) {
        double *to = w->sums + (size_t)k * SUMS + i;
        vd total = vd_totals(sums[0] + i);
#pragma GCC unroll 2
        for (int h = 1; h < PARTS; h++)
            total += vd_totals(sums[h] + i);
        vd_store(to, vd_load(to) + total);
    }
}

/* Adds groups v..until - 1 to the sums of k. */
static void sum_over_rings(struct work *w, int j, int k, int v, int until)
{
    const vd alpha = vd_all(w->alpha[k]), beta = vd_all(w->beta[k]);
    vd all[PARTS][SUMS];

    for (int h = 0; h < PARTS; h++) {
        vd sums[SUMS] = {{0}};
        for (int i = v * PARTS + h; i < until * PARTS; i += PARTS) {
            const double *data = w->data + (size_t)i * SUMS * VD;
            const vd now = vd_load(w->now + i * VD);
            const vd t =
                vd_fma(alpha, vd_load(w->rings->x2 + j + i * VD), beta);
            vd_store(w->now + i * VD,
                     vd_fma(t, now, vd_load(w->last + i * VD)));
            vd_store(w->last + i * VD, now);
#pragma GCC unroll 12
            for (int p = 0; p < SUMS; p++)
                sums[p] = vd_fma(now, vd_load(data + p * VD), sums[p]);
        }
        memcpy(all[h], sums, sizeof sums);
    }
    add_lanes(w, k, all);
}

/* The same in floats for the groups from v on; lane i + 4 is added to lane i.
 */
static void sum_singles(struct work *w, int k, int v)
{
    const vf alpha = vf_all((float)w->alpha[k]),
             beta = vf_all((float)w->beta[k]);
    vd all[PARTS][SUMS] = {{{0}}};

    for (int u = 0; u < VECTORS; u++) {
        vf sums[SUMS] = {{0}};
        for (int i = v * RINGS + u * VF; i < w->groups * RINGS;
             i += 2 * RINGS) {
            const float *data = w->data_single + (size_t)i * SUMS;
            const vf now = vf_load(w->now_single + i);
            const vf t = vf_fma(alpha, vf_load(w->x2_single + i), beta);
            vf_store(w->now_single + i,
                     vf_fma(t, now, vf_load(w->last_single + i)));
            vf_store(w->last_single + i, now);
#pragma GCC unroll 3
            for (int p = 0; p < SUMS; p += 4) {
                vf d[4];
                vf_load_four(data + p * VF, d);
#pragma GCC unroll 4
                for (int n = 0; n < 4; n++)
                    sums[p + n] = vf_fma(now, d[n], sums[p + n]);
            }
        }
#pragma GCC unroll 12
        for (int p = 0; p < SUMS; p++) {
            vd half[2];
            vf_widen(sums[p], half);
            all[0][p] += half[0];
            all[PARTS - 1][p] += half[1];
        }
    }
    add_lanes(w, k, all);
}

/* Turns groups v and v + 1 and their data into floats. Rings that never join
 * are zero. */
static void become_single(struct work *w, int j, int v)
{
    to_single(w, j, v);
    for (int i = v * RINGS; i < (v + 2) * RINGS; i += VD) {
        const double *from = w->data + (size_t)i * SUMS;
        float *to = w->data_single + (size_t)(i / VF * VF) * SUMS + i % VF;
        if (i < w->active * RINGS) {
            vd_store_floats(w->now_single + i, vd_all(0.0));
            vd_store_floats(w->last_single + i, vd_all(0.0));
        }
        const vl none = (vl)vd_all(0.0);
        const vl joins = i < w->active * RINGS ? none : ~none;
#pragma GCC unroll 12
        for (int p = 0; p < SUMS; p++)
            vd_store_floats(to + p * VF,
                            vd_only(joins, vd_load(from + p * VD)));
    }
}

static void analyse_chunk(struct work *w, int j)
{
    int single;

    if (w->groups % 2) {
        make_empty(w, w->groups);
        memset(w->data + (size_t)w->groups++ * SUMS * RINGS, 0,
               SUMS * RINGS * sizeof *w->data);
    }
    single = w->groups;
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
        for (int k = b * BLOCK; k < (b + 1) * BLOCK && k < w->terms; k++) {
            if (v < single)
                sum_over_rings(w, j, k, v, single);
            if (single < w->groups)
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
    for (int j = 0; j < o->rings->pairs; j += CHUNK) {
        gather_chunk(&w, j, f, stride);
        start_chunk(&w, j);
        analyse_chunk(&w, j);
    }
    finish(&w, a);
}

static void add_rows(const double *edge, int from, int until, int rows,
                     const float *f, size_t stride, double sum[6])
{
    vd sums[PARTS][6] = {{{0}}};
    int j = from;

    for (; j + RINGS <= until; j += RINGS)
#pragma GCC unroll 2
        for (int h = 0; h < PARTS; h++) {
            const int at = j + h * VD;
            const vd mass = vd_load(edge + at) - vd_load(edge + at + 1);
            const float *north = f + at, *south = f + rows - VD - at;
#pragma GCC unroll 6
            for (int p = 0; p < 6; p++, north += stride, south += stride)
                sums[h][p] = vd_fma(mass,
                                    vd_load_floats(north) +
                                        vd_reverse(vd_load_floats(south)),
                                    sums[h][p]);
        }
    for (int p = 0; p < 6; p++, f += stride) {
        for (int i = 0; i < RINGS; i++)
            sum[p] += sums[i / VD][p][i % VD];
        for (int i = j; i < until; i++)
            sum[p] += (edge[i] - edge[i + 1]) *
                      ((double)f[i] + (double)f[rows - 1 - i]);
    }
}

/* ---- synthesis ------------------------------------------------------ */

/* Computes the coefficients of R_k in the sums: from P_m+2k and P_m+2k+2, which
 * both contain R_k, and from P_m+2k+1. */
static void combine(struct work *w, const float *a, const double *factor)
{
    const int count = w->o->degree - w->o->m + 1;
    float end[2 * SUMS] = {0}; /* the last three degrees, and zeros */
    double *c = w->sums;

    factor += w->o->m;
    for (int l = 0; l < count; l += 2, a += SUMS, c += SUMS) {
        const int k = l / 2;
        const double even = w->even[k] * factor[l];
        const double odd = l + 1 < count ? w->odd[k] * factor[l + 1] : 0;
        const double next =
            l + 2 < count ? w->before[k + 1] * factor[l + 2] : 0;
        const float *from = a;
        if (l + 3 >= count)
            from = memcpy(end, a, (size_t)(count - l) * 6 * sizeof *a);
#pragma GCC unroll 6
        for (int i = 0; i < SUMS; i += VD) {
            vd p = vd_all(even), q = vd_all(next);
#pragma GCC unroll 4
            for (int n = 0; n < VD; n++)
                if (i + n >= 6) {
                    p[n] = odd;
                    q[n] = 0;
                }
            vd_store(c + i, p * vd_load_floats(from + i) +
                                q * vd_load_floats(from + SUMS + i));
        }
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

/* Sums the terms from k on, which is even, in floats for the vector of rings
 * from i on. Two values take turns as the last one. */
static void sum_singles_over_k(const struct work *w, int i, int k, vf out[SUMS])
{
    const vf x2 = vf_load(w->x2_single + i);
    vf r = vf_load(w->now_single + i);
    vf last = vf_load(w->last_single + i), sums[SUMS] = {{0}};

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
static inline void add_term(const struct work *w, int k, const double *c, vd x,
                            vd now, vd *last, vd sums[SUMS])
{
#pragma GCC unroll 6
    for (int p = 0; p < SUMS; p += 2)
        vd_add_two(now, c + p, sums + p);
    recur(w, k, x, now, last);
}

/* Adds the terms k = from..until - 1 for the vector of rings from i on to acc.
 */
static void sum_over_k(struct work *w, int j, int i, int from, int until,
                       vd acc[SUMS])
{
    const double *c = w->sums + (size_t)from * SUMS;
    const vd x = vd_load(w->rings->x2 + j + i);
    vd r = vd_load(w->now + i), last = vd_load(w->last + i), sums[SUMS];

#pragma GCC unroll 12
    for (int p = 0; p < SUMS; p++)
        sums[p] = acc[p];
    for (int k = from; k < until; k += 2, c += 2 * SUMS) {
        add_term(w, k, c, x, r, &last, sums);
        if (k + 1 < until) {
            add_term(w, k + 1, c + SUMS, x, last, &r, sums);
        } else {
            const vd next = last;
            last = r;
            r = next;
        }
    }
    vd_store(w->now + i, r);
    vd_store(w->last + i, last);
#pragma GCC unroll 12
    for (int p = 0; p < SUMS; p++)
        acc[p] = sums[p];
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

/* Adds the terms before k = end for group v to acc, block by block while rings
 * join. */
static void synthesise_group(struct work *w, int j, int v, int end,
                             vd acc[PARTS][SUMS])
{
    const int until = w->until_block[v];

    for (int b = w->from_block[v]; b <= until && b * BLOCK < end; b++) {
        const int to = b < until ? (b + 1) * BLOCK : end;
        if (b)
            come_in(w, v, b);
        for (int h = 0; h < PARTS; h++)
            sum_over_k(w, j, v * RINGS + h * VD, b * BLOCK, to, acc[h]);
    }
}

/* Writes the rings of groups v and v + 1. */
static void synthesise_pair(struct work *w, int j, int v, float *g,
                            size_t stride)
{
    const int from = single_from(w, v) * BLOCK;
    const int end = from < w->terms ? from : w->terms;
    vd acc[2 * PARTS][SUMS] = {{{0}}};

    for (int i = 0; i < 2; i++)
        synthesise_group(w, j, v + i, end, acc + i * PARTS);
    if (end < w->terms) {
        to_single(w, j, v);
        for (int u = 0; u < VECTORS; u++) {
            vf rest[SUMS];
            sum_singles_over_k(w, v * RINGS + u * VF, end, rest);
#pragma GCC unroll 12
            for (int p = 0; p < SUMS; p++) {
                vd half[2];
                vf_widen(rest[p], half);
                acc[2 * u][p] += half[0];
                acc[2 * u + 1][p] += half[1];
            }
        }
    }
    for (int i = 0; i < 2 * PARTS; i++)
        store_vector(w->rings, j + v * RINGS + i * VD, acc[i], g, stride);
}

/* Writes zeros to the rings of `groups` groups, from north j on. */
static void store_nothing(const ibl_legendre_rings *r, int j, int groups,
                          float *g, size_t stride)
{
    const int left = r->pairs - j;
    const size_t n = (size_t)(left < groups * RINGS ? left : groups * RINGS);

    for (int part = 0; part < 6; part++, g += stride) {
        memset(g + j, 0, n * sizeof *g);
        memset(g + (size_t)(r->count - j) - n, 0, n * sizeof *g);
    }
}

static void synthesise_chunk(struct work *w, int j, float *g, size_t stride)
{
    const int active = w->active / 2 * 2;

    store_nothing(w->rings, j, active, g, stride);
    /* Rounded to pairs. */
    if (w->active > active)
        make_empty(w, active);
    w->active = active;
    if (w->groups % 2)
        make_empty(w, w->groups++);
    for (int v = active; v < w->groups; v += 2)
        synthesise_pair(w, j, v, g, stride);
}

static void synthesise(const ibl_legendre_order *o, const float *a,
                       const double *factor, float *g, size_t stride)
{
    struct work w = layout(o);

    fill_coefficients(&w);
    combine(&w, a, factor);
    fill_rows(&w);
    for (int j = 0; j < o->rings->pairs; j += CHUNK) {
        w.active = 0;
        w.groups = (ring_pairs(&w, j) + RINGS - 1) / RINGS;
        start_chunk(&w, j);
        synthesise_chunk(&w, j, g, stride);
    }
}

IBL_VECTOR_KERNEL(ibl_legendre, analyse, synthesise, add_rows)
