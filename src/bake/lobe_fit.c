/* SPDX-License-Identifier: MIT */
#include "bake/lobe_fit.h"

#include <math.h>
#include <string.h>

enum {
    ANGLES = IBL_LOBE_ANGLES,
    WINDOW = IBL_LOBE_WINDOW,
    DIFFUSE = IBL_LOBE_DIFFUSE,
    MOST = IBL_LOBE_MOST_TAPS,
    STEPS = 7 /* of a search */
};

/* Half the angles' range, in mean deviations of the lobe from its mean. */
static const double reach = 3.5;

/* Costs of a bend, taps apart and irradiance, each of 1, in the power of a
 * level's lobe. They decide where lookups are alike: next to N.V = 1 and r = 1.
 */
static const double bend_cost = 1e-4, half_cost = 2e-3, weight_cost = 1e-4;

/* The most irradiance at r = 1. More than 1 makes a lobe that is broader than a
 * cosine, less some of a narrower one. Below r = 1 it is 1: there such lookups
 * are little better than others, and between the two kinds, where a table is
 * interpolated, both are wrong. */
static const double most_weight = 2.5;

/* ---- the true lobe ------------------------------------------------------ */

/* The level next below a roughness. */
static int level_below(const ibl_specular_layout *layout, double roughness)
{
    int l = 0;
    while (l + 1 < layout->levels && layout->roughness[l + 1] < roughness)
        l++;
    return l;
}

static void choose_window(ibl_lobe_view *v, double roughness)
{
    const ibl_specular_layout *layout = &v->kernels->layout;
    const int most = layout->levels - WINDOW;
    int base = level_below(layout, 0.85 * roughness) - 1;
    if (base > most)
        base = most;
    v->base = base > 0 ? base : 0;
    v->count = layout->levels < WINDOW ? layout->levels : WINDOW;
}

/* Chooses the angles: around the means of both lobes. */
static void choose_angles(ibl_lobe_view *v, const ibl_true_lobe *lobe)
{
    double low = 10, high = -10;
    for (int f = 0; f < 2; f++) {
        double x = 0, z = 0, spread = 0;
        for (int i = 0; i < lobe->count; i++) {
            x += (double)(lobe->share[f][i] * lobe->x[i]);
            z += (double)(lobe->share[f][i] * lobe->z[i]);
        }
        const double mean = atan2(x, z);
        for (int i = 0; i < lobe->count; i++)
            spread += (double)lobe->share[f][i] *
                      fabs(cos(mean) * (double)lobe->x[i] -
                           sin(mean) * (double)lobe->z[i]);
        low = fmin(low, mean - reach * spread);
        high = fmax(high, mean + reach * spread);
    }
    v->first = low;
    v->step = (high - low) / (ANGLES - 1);
}

/* Four numbers, in one vector on most CPUs: those of points, or of the levels
 * of the window. */
typedef float four __attribute__((vector_size(16)));
typedef int32_t four_bits __attribute__((vector_size(16)));

_Static_assert(WINDOW == 4 && IBL_TRUE_LOBE_ANGLES % 4 == 0, "vectors of four");

static four load(const float *p)
{
    four v;
    memcpy(&v, p, sizeof v);
    return v;
}

/* ibl_lobe_place_of for four q. */
static void places_of(four q, four_bits *row, four *t)
{
    const int first = (127 - IBL_LOBE_OCTAVES) << IBL_LOBE_BITS;
    const int shift = 23 - IBL_LOBE_BITS;
    const four_bits bits = (four_bits)(q + 1.0f / (1 << IBL_LOBE_OCTAVES));
    *row = ((bits >> shift) - first) * IBL_LOBE_SLOTS;
    *t = __builtin_convertvector(bits & ((1 << shift) - 1), four) *
         (1.0f / (1 << shift));
}

/* Products of the points with the levels of the window about the direction
 * (x, 0, z). */
static void add_points(const ibl_lobe_view *v, const ibl_true_lobe *lobe,
                       float x, float z, float sum[2][WINDOW])
{
    const float *table = v->kernels->point + v->base;
    four total[2] = {{0}};
    for (int i = 0; i < lobe->count; i += 4) {
        const four dx = load(lobe->x + i) - x, dz = load(lobe->z + i) - z;
        const four y = load(lobe->y + i);
        four_bits row;
        four t;
        places_of(0.25f * (dx * dx + y * y + dz * dz), &row, &t);
#pragma GCC unroll 4
        for (int k = 0; k < 4; k++) {
            const float *low = table + row[k];
            const four at = load(low), next = load(low + IBL_LOBE_SLOTS);
            const four value = at + t[k] * (next - at);
            total[0] += lobe->share[0][i + k] * value;
            total[1] += lobe->share[1][i + k] * value;
        }
    }
    memcpy(sum, total, sizeof total);
}

static void add_diffuse(const ibl_lobe_view *v, const ibl_true_lobe *lobe,
                        double sum[2])
{
    sum[0] = sum[1] = 0;
    for (int i = 0; i < lobe->count; i++) {
        const ibl_lobe_place p = ibl_lobe_place_of(0.5f - 0.5f * lobe->z[i]);
        const float k = ibl_lobe_at(v->kernels->point, p, DIFFUSE);
        sum[0] += (double)(lobe->share[0][i] * k);
        sum[1] += (double)(lobe->share[1][i] * k);
    }
}

void ibl_lobe_view_make(const ibl_lobe_kernels *k,
                        const ibl_true_lobe_rule *rule, double n_dot_v,
                        double roughness, ibl_lobe_view *v)
{
    ibl_true_lobe lobe;
    *v = (ibl_lobe_view){.kernels = k,
                         .angle = acos(n_dot_v),
                         .sine = sqrt((1 - n_dot_v) * (1 + n_dot_v)),
                         .cosine = n_dot_v,
                         .most_weight = roughness < 1 ? 1 : most_weight};
    ibl_true_lobe_make(rule, n_dot_v, roughness * roughness, &lobe);
    choose_window(v, roughness);
    choose_angles(v, &lobe);
    for (int i = 0; i < ANGLES; i++) {
        const double angle = v->first + i * v->step;
        float sum[2][WINDOW];
        add_points(v, &lobe, (float)sin(angle), (float)cos(angle), sum);
        for (int l = 0; l < WINDOW; l++) {
            v->h[0][l][i] = (double)sum[0][l];
            v->h[1][l][i] = (double)sum[1][l];
        }
    }
    add_diffuse(v, &lobe, v->diffuse);
}

/* ---- the cost ----------------------------------------------------------- */

/* Products of the lobes of a window of levels, as means over taps. */
typedef struct products {
    double h[WINDOW];      /* with the true lobe */
    double same[WINDOW];   /* with themselves */
    double next[WINDOW];   /* with the next level */
    double cosine[WINDOW]; /* with the cosine */
    double both, diffuse;  /* of the cosine with itself and the true lobe */
} products;

/* A direction in the plane of N and V: towards R's side, and along N. */
typedef struct direction {
    double x, z;
} direction;

/* mix(R, N, bend), normalised. */
static direction bent(const ibl_lobe_view *v, double bend)
{
    const double x = (1 - bend) * v->sine, z = (1 - bend) * v->cosine + bend;
    const double inverse = 1 / sqrt(x * x + z * z);
    return (direction){x * inverse, z * inverse};
}

/* Cubic interpolation of h; constant beyond its angles. */
static void weights_at(const ibl_lobe_view *v, double angle, int *from,
                       double w[4])
{
    const double x = fmin(fmax((angle - v->first) / v->step, 0), ANGLES - 1);
    int i = (int)floor(x) - 1;
    i = i < 0 ? 0 : i > ANGLES - 4 ? ANGLES - 4 : i;
    const double u = x - i;
    *from = i;
    w[0] = (u - 1) * (u - 2) * (u - 3) / -6;
    w[1] = u * (u - 2) * (u - 3) / 2;
    w[2] = u * (u - 1) * (u - 3) / -2;
    w[3] = u * (u - 1) * (u - 2) / 6;
}

static void add_direction(const ibl_lobe_view *v, int which, direction d,
                          double share, products *p)
{
    const float q = (float)(0.5 - 0.5 * d.z);
    const ibl_lobe_place place = ibl_lobe_place_of(q > 0 ? q : 0);
    double w[4];
    int from;
    weights_at(v, atan2(d.x, d.z), &from, w);
    for (int l = 0; l < WINDOW; l++) {
        const double *h = v->h[which][l] + from;
        p->h[l] +=
            share * (w[0] * h[0] + w[1] * h[1] + w[2] * h[2] + w[3] * h[3]);
        p->cosine[l] += share * (double)ibl_lobe_at(v->kernels->diffuse, place,
                                                    v->base + l);
    }
}

/* Directions whose squared distance is 4 q. */
static void add_apart(const ibl_lobe_view *v, double q, double share,
                      products *p)
{
    const ibl_lobe_place place = ibl_lobe_place_of((float)q);
    for (int l = 0; l < WINDOW; l++) {
        p->same[l] +=
            share * (double)ibl_lobe_at(v->kernels->same, place, v->base + l);
        p->next[l] +=
            share * (double)ibl_lobe_at(v->kernels->next, place, v->base + l);
    }
}

static products products_of(const ibl_lobe_view *v, int which, int taps,
                            const ibl_lobe_lookup *l)
{
    products p = {.both = (double)v->kernels->same[DIFFUSE],
                  .diffuse = v->diffuse[which]};
    direction d[MOST];
    for (int i = 0; i < taps; i++) {
        const double from_middle = taps > 1 ? 2.0 * i / (taps - 1) - 1 : 0;
        d[i] = bent(v, l->bend + l->half * from_middle);
        add_direction(v, which, d[i], 1.0 / taps, &p);
        for (int j = 0; j <= i; j++) {
            const double x = d[i].x - d[j].x, z = d[i].z - d[j].z;
            add_apart(v, 0.25 * (x * x + z * z),
                      (j < i ? 2.0 : 1.0) / (taps * taps), &p);
        }
    }
    return p;
}

/* The cost as a quadratic function of x, the weight of level a + 1, and w,
 * that of the cosine; level a has the rest. */
typedef struct quadratic {
    double c, x, w, xx, xw, ww;
} quadratic;

static quadratic quadratic_of(const products *p, int a)
{
    const double aa = p->same[a], ab = p->next[a], bb = p->same[a + 1];
    return (quadratic){.c = aa - 2 * p->h[a],
                       .x = 2 * (ab - aa - p->h[a + 1] + p->h[a]),
                       .w = 2 * (p->cosine[a] - aa - p->diffuse + p->h[a]),
                       .xx = aa - 2 * ab + bb,
                       .xw = 2 * (p->cosine[a + 1] - ab - p->cosine[a] + aa),
                       .ww =
                           aa - 2 * p->cosine[a] + p->both + weight_cost * aa};
}

static double value(const quadratic *q, double x, double w)
{
    return q->c + q->x * x + q->w * w + q->xx * x * x + q->xw * x * w +
           q->ww * w * w;
}

/* The least of slope x + bow x^2 in 0..most. */
static double limited(double slope, double bow, double most)
{
    if (!(bow > 0))
        return slope < 0 ? most : 0;
    return fmin(fmax(-0.5 * slope / bow, 0), most);
}

static void try_at(const quadratic *q, double x, double w, double *least,
                   double at[2])
{
    const double v = value(q, x, w);
    if (v < *least) {
        *least = v;
        at[0] = x;
        at[1] = w;
    }
}

/* Two triangles meet at w = 1: that where level a + 1 has 0..1 - w of the
 * lookup, and beyond w = 1 that where it has 1 - w..0. The least is in one of
 * them or on an edge. */
static double least_of(const products *p, int a, double most, double at[2])
{
    const quadratic q = quadratic_of(p, a);
    const double det = 4 * q.xx * q.ww - q.xw * q.xw;
    double least = HUGE_VAL;
    if (det > 1e-9 * q.xx * q.ww) {
        const double x = (q.xw * q.w - 2 * q.ww * q.x) / det;
        const double w = (q.xw * q.x - 2 * q.xx * q.w) / det;
        if (w >= 0 && w <= most && x * (1 - x - w) >= 0)
            try_at(&q, x, w, &least, at);
    }
    try_at(&q, limited(q.x, q.xx, 1), 0, &least, at);
    try_at(&q, 0, limited(q.w, q.ww, most), &least, at);
    const double s =
        limited(q.w - q.x + q.xw - 2 * q.xx, q.xx - q.xw + q.ww, most);
    try_at(&q, 1 - s, s, &least, at);
    return least;
}

/* Least cost of a direction over lods and weights. */
static double best_of(const ibl_lobe_view *v, int which, int taps,
                      ibl_lobe_lookup *lookup)
{
    const products p = products_of(v, which, taps, lookup);
    double least = HUGE_VAL;
    for (int a = 0; a + 1 < v->count; a++) {
        double at[2] = {0, 0};
        const double cost = least_of(&p, a, v->most_weight, at);
        if (cost < least) {
            least = cost;
            lookup->weight = at[1];
            lookup->lod = v->base + a + (at[1] == 1 ? 0 : at[0] / (1 - at[1]));
        }
    }
    const double b = lookup->bend, h = lookup->half;
    return least + p.same[0] * (bend_cost * b * b + half_cost * h * h);
}

/* ---- the search --------------------------------------------------------- */

typedef struct search {
    const ibl_lobe_view *view;
    int which, taps;
    ibl_lobe_lookup best;
    double cost;
} search;

static double attempt(search *s, double bend, double half)
{
    ibl_lobe_lookup l = {.bend = fmin(fmax(bend, 0), 1),
                         .half = fmin(fmax(half, 0), 1)};
    const double cost = best_of(s->view, s->which, s->taps, &l);
    if (cost < s->cost) {
        s->cost = cost;
        s->best = l;
    }
    return cost;
}

/* Where a parabola through the costs at -1, 0 and 1 is least, within these. */
static double vertex(double before, double here, double after)
{
    const double bow = before - 2 * here + after;
    if (!(bow > 0))
        return before < after ? -1 : 1;
    return fmin(fmax(0.5 * (before - after) / bow, -1), 1);
}

static void improve(search *s, double step)
{
    const ibl_lobe_lookup at = s->best;
    const double here = s->cost, h = at.half;
    const double dx = vertex(attempt(s, at.bend - step, h), here,
                             attempt(s, at.bend + step, h));
    double dy = 0;
    if (s->taps > 1)
        dy = vertex(attempt(s, at.bend, h - step), here,
                    attempt(s, at.bend, h + step));
    attempt(s, at.bend + dx * step, h + dy * step);
}

static void refine(search *s, double step)
{
    for (int i = 0; i < STEPS; i++, step *= 0.5)
        improve(s, step);
}

/* Bends of one tap are of every order; several are near, and apart by some of
 * the lobe's deviation. */
void ibl_lobe_fit(const ibl_lobe_view *v, int which, ibl_lobe_lookup best[2])
{
    search s = {.view = v, .which = which, .taps = 1, .cost = HUGE_VAL};
    attempt(&s, 0, 0);
    for (double bend = 1; bend > 0.002; bend *= 0.6)
        attempt(&s, bend, 0);
    refine(&s, 0.25 * fmax(s.best.bend, 0.004));
    best[0] = s.best;
    const double least = 0.25 * fmin(v->step / v->angle, 0.5);
    s.taps = MOST;
    s.cost = HUGE_VAL;
    for (double half = least; half < 40 * least; half *= 2)
        for (int i = 0; i < 3; i++)
            attempt(&s, 0.5 * i * best[0].bend, half);
    refine(&s, 0.5 * s.best.half);
    best[1] = s.best;
}
