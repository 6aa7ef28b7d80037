/* SPDX-License-Identifier: MIT */
/*
 * Blocks of 4x4 source pixels are the leaves of a quadtree whose nodes know
 * the light that they hold, where its centre is and how far it spreads from
 * there. For one direction the lobe is evaluated at the centres of nodes: the
 * first order of what that leaves out vanishes by the choice of the centre,
 * the second is at most
 *     1/2 spread sup |K''|,   spread = sum e_i |d_i - c|^2,
 * over the node. A node is opened where that is above its share of the
 * accuracy. A sun in a node has no spread and is taken where it is, however
 * large the node; a sky far from the peak is taken in large pieces. This is
 * the idea of lightcuts (Walter et al. 2005) with a zonal kernel.
 */
#include "bake/tree.h"

#include <math.h>
#include <stdbool.h>

#include "brdf/lobe.h"
#include "core/alloc.h"
#include "core/context.h"

enum {
    LEAF = 4, /* pixels along the edge of a leaf */
    MAX_DEPTH = 16,
    SUBDIVISIONS = 32, /* of a pixel's edge, at most */
    MAX_PASSES = 4
};

typedef struct node {
    float rgb[3]; /* sum of L dO, above the floor, in units */
    float at[3];  /* centre of light */
    float spread; /* sum over pixels of (R + G + B) dO |d - at|^2 */
    float unused; /* 32 bytes */
} node;

typedef struct grid {
    int width, height; /* in nodes */
    double radius;     /* no pixel of a node is further from its centre */
    node *nodes;
} grid;

struct ibl_tree {
    const ibl_image *env;
    float floor[3];
    double unit; /* the peak's power of two: all light fits into a float */
    int depth;   /* grids */
    grid grids[MAX_DEPTH];          /* [0]: leaves */
    double *column;                 /* cos(phi), sin(phi) of each */
    double *row;                    /* sin(theta), cos(theta), solid angle */
    double pixel_width, phi_offset; /* radians */
};

/* ---- building --------------------------------------------------------- */

/* Light of one pixel. */
static void pixel_light(const ibl_tree *t, int x, int y, double rgb[3])
{
    const float *p =
        t->env->data + 3 * ((size_t)y * (size_t)t->env->width + (size_t)x);
    for (int c = 0; c < 3; c++)
        rgb[c] =
            ((double)p[c] - (double)t->floor[c]) / t->unit * t->row[3 * y + 2];
}

static void pixel_place(const ibl_tree *t, int x, int y, double at[3])
{
    at[0] = t->row[3 * y] * t->column[2 * x];
    at[1] = t->row[3 * y + 1];
    at[2] = t->row[3 * y] * t->column[2 * x + 1];
}

/* Light gathered from pixels or nodes; moments about the origin lose digits,
 * so a second pass takes the spread about the centre. */
typedef struct gathered {
    double rgb[3], at[3], energy, spread;
} gathered;

static void add_light(gathered *g, const double rgb[3], const double at[3])
{
    const double e = rgb[0] + rgb[1] + rgb[2];
    for (int c = 0; c < 3; c++) {
        g->rgb[c] += rgb[c];
        g->at[c] += e * at[c];
    }
    g->energy += e;
}

static void add_spread(gathered *g, double energy, const double at[3])
{
    double d2 = 0;
    for (int c = 0; c < 3; c++)
        d2 += (at[c] - g->at[c]) * (at[c] - g->at[c]);
    g->spread += energy * d2;
}

static void find_centre(gathered *g)
{
    for (int c = 0; c < 3 && g->energy > 0; c++)
        g->at[c] /= g->energy;
}

static node node_of(const gathered *g)
{
    return (node){.rgb = {(float)g->rgb[0], (float)g->rgb[1], (float)g->rgb[2]},
                  .at = {(float)g->at[0], (float)g->at[1], (float)g->at[2]},
                  .spread = (float)g->spread};
}

static int least(int a, int b)
{
    return a < b ? a : b;
}

static void leaf_job(void *arg, int j, int worker)
{
    const ibl_tree *t = arg;
    const grid *leaves = &t->grids[0];
    const int y1 = least(LEAF * (j + 1), t->env->height);
    (void)worker;
    for (int i = 0; i < leaves->width; i++) {
        const int x1 = least(LEAF * (i + 1), t->env->width);
        gathered g = {0};
        double rgb[3], at[3];
        for (int y = LEAF * j; y < y1; y++) {
            for (int x = LEAF * i; x < x1; x++) {
                pixel_light(t, x, y, rgb);
                pixel_place(t, x, y, at);
                add_light(&g, rgb, at);
            }
        }
        find_centre(&g);
        for (int y = LEAF * j; y < y1; y++) {
            for (int x = LEAF * i; x < x1; x++) {
                pixel_light(t, x, y, rgb);
                pixel_place(t, x, y, at);
                add_spread(&g, rgb[0] + rgb[1] + rgb[2], at);
            }
        }
        leaves->nodes[(size_t)j * (size_t)leaves->width + (size_t)i] =
            node_of(&g);
    }
}

static node merge(const node *children[4], int count)
{
    gathered g = {0};
    for (int pass = 0; pass < 2; pass++) {
        for (int k = 0; k < count; k++) {
            const node *n = children[k];
            const double rgb[3] = {(double)n->rgb[0], (double)n->rgb[1],
                                   (double)n->rgb[2]};
            const double at[3] = {(double)n->at[0], (double)n->at[1],
                                  (double)n->at[2]};
            if (!pass) {
                add_light(&g, rgb, at);
            } else {
                add_spread(&g, rgb[0] + rgb[1] + rgb[2], at);
                g.spread += (double)n->spread;
            }
        }
        if (!pass)
            find_centre(&g);
    }
    return node_of(&g);
}

static void build_grid(const grid *fine, const grid *coarse)
{
    for (int j = 0; j < coarse->height; j++) {
        for (int i = 0; i < coarse->width; i++) {
            const node *children[4];
            int count = 0;
            for (int k = 0; k < 4; k++) {
                const int x = 2 * i + k % 2, y = 2 * j + k / 2;
                if (x < fine->width && y < fine->height)
                    children[count++] =
                        &fine->nodes[(size_t)y * (size_t)fine->width +
                                     (size_t)x];
            }
            coarse->nodes[(size_t)j * (size_t)coarse->width + (size_t)i] =
                merge(children, count);
        }
    }
}

static void find_range(ibl_tree *t)
{
    const float *p = t->env->data;
    const size_t pixels = (size_t)t->env->width * (size_t)t->env->height;
    float peak = 0;
    for (int c = 0; c < 3; c++)
        t->floor[c] = p[c];
    for (size_t i = 0; i < pixels; i++) {
        for (int c = 0; c < 3; c++) {
            const float v = p[3 * i + c];
            t->floor[c] = v < t->floor[c] ? v : t->floor[c];
            peak = v > peak ? v : peak;
        }
    }
    t->unit = peak > 0 ? ldexp(1, ilogb((double)peak)) : 1;
}

static void fill_tables(ibl_tree *t, double yaw_deg)
{
    const int w = t->env->width, h = t->env->height;
    const double yaw = (yaw_deg - 360 * floor(yaw_deg / 360)) * (IBL_PI / 180);
    t->pixel_width = 2 * IBL_PI / w;
    t->phi_offset = -IBL_PI - yaw;
    for (int x = 0; x < w; x++) {
        const double phi = t->pixel_width * (x + 0.5) + t->phi_offset;
        t->column[2 * x] = cos(phi);
        t->column[2 * x + 1] = sin(phi);
    }
    for (int y = 0; y < h; y++) {
        const double theta = IBL_PI * (y + 0.5) / h;
        t->row[3 * y] = sin(theta);
        t->row[3 * y + 1] = cos(theta);
        /* cos(a) - cos(b) = 2 sin((a + b) / 2) sin((b - a) / 2) */
        t->row[3 * y + 2] =
            t->pixel_width * 2 * sin(theta) * sin(IBL_PI / (2 * h));
    }
}

/* Grid k has nodes of edge LEAF << k; the last is a few nodes. */
static bool shape_grids(ibl_tree *t)
{
    int w = (t->env->width + LEAF - 1) / LEAF;
    int h = (t->env->height + LEAF - 1) / LEAF;
    for (t->depth = 0; t->depth < MAX_DEPTH; t->depth++) {
        grid *g = &t->grids[t->depth];
        const double edge = (double)(LEAF << t->depth) / 2;
        *g = (grid){.width = w, .height = h};
        /* From the middle of the block to a corner, and as far again to the
         * centre of light. */
        g->radius = fmin(2, 2 * hypot(edge * 2 * IBL_PI / t->env->width,
                                      edge * IBL_PI / t->env->height));
        g->nodes = ibl_alloc_array((size_t)w * (size_t)h, sizeof(node));
        if (!g->nodes)
            return false;
        if (w <= 4 && h <= 4) {
            t->depth++;
            break;
        }
        w = (w + 1) / 2;
        h = (h + 1) / 2;
    }
    return true;
}

ibl_status ibl_tree_create(ibl_ctx *ctx, const ibl_image *env, double yaw_deg,
                           ibl_tree **out)
{
    ibl_tree *t = ibl_alloc_zeroed(1, sizeof *t);
    ibl_status status = IBL_ERR_MEMORY;
    *out = NULL;
    if (!t)
        return ibl_no_memory(ctx, "a tree of the source");
    t->env = env;
    t->column = ibl_alloc_array((size_t)env->width, 2 * sizeof *t->column);
    t->row = ibl_alloc_array((size_t)env->height, 3 * sizeof *t->row);
    if (!t->column || !t->row || !shape_grids(t)) {
        ibl_no_memory(ctx, "a tree of the source");
        goto fail;
    }
    fill_tables(t, yaw_deg);
    find_range(t);
    status = ibl_run(ctx, NULL, t->grids[0].height, leaf_job, t);
    if (status)
        goto fail;
    for (int k = 1; k < t->depth; k++)
        build_grid(&t->grids[k - 1], &t->grids[k]);
    *out = t;
    return IBL_OK;
fail:
    ibl_tree_free(t);
    return status;
}

void ibl_tree_free(ibl_tree *t)
{
    if (!t)
        return;
    for (int k = 0; k < MAX_DEPTH; k++)
        ibl_free(t->grids[k].nodes);
    ibl_free(t->column);
    ibl_free(t->row);
    ibl_free(t);
}

/* ---- summing ---------------------------------------------------------- */

typedef struct summing {
    const ibl_tree *tree;
    const double *dir;
    const ibl_lobe_shape *lobe;
    double share; /* of the error, in energy times lobe, for each node */
    double rgb[3];
} summing;

static double chord2(const double a[3], const double b[3])
{
    const double x = a[0] - b[0], y = a[1] - b[1], z = a[2] - b[2];
    return x * x + y * y + z * z;
}

/* K at a distance from the peak. */
static double lobe_at(const summing *s, double d2)
{
    return ibl_lobe_value(s->lobe, d2 / 4, 1 - d2 / 2);
}

static void add(summing *s, const double rgb[3], double k)
{
    for (int c = 0; c < 3; c++)
        s->rgb[c] += k * rgb[c];
}

/* A pixel that the lobe is narrow for, as a constant patch. */
static void add_patch(summing *s, int x, int y, const double rgb[3], int parts)
{
    const ibl_tree *t = s->tree;
    const double height = IBL_PI / t->env->height;
    double sum = 0, weight = 0;
    for (int j = 0; j < parts; j++) {
        const double theta = height * (y + (j + 0.5) / parts);
        const double w = sin(theta);
        for (int i = 0; i < parts; i++) {
            const double phi =
                t->pixel_width * (x + (i + 0.5) / parts) + t->phi_offset;
            const double at[3] = {w * cos(phi), cos(theta), w * sin(phi)};
            sum += w * lobe_at(s, chord2(at, s->dir));
            weight += w;
        }
    }
    add(s, rgb, sum / weight);
}

/*
 * Pixels of at most this edge may stand in their centres: by the lobe's
 * curvature that leaves a hundredth of their weight or less. GGX changes over
 * a distance of 2 sqrt(t), t = q + alpha^2 nearly; Phong, a Gaussian, by
 * 1 / n = 2 alpha^2 about its peak, next to which the rest is nothing; Charlie
 * over 1 / s = 2 alpha.
 */
static double fine_edge(const ibl_lobe_shape *lobe, double q)
{
    const double alpha = lobe->alpha;
    return lobe->lobe == IBL_LOBE_GGX     ? sqrt(q + alpha * alpha) / 2
           : lobe->lobe == IBL_LOBE_PHONG ? alpha * sqrt(0.5)
                                          : alpha * sqrt(2);
}

/* Whether nothing of the lobe is within reach of a place. */
static bool is_nothing(const ibl_lobe_shape *lobe, double d, double reach)
{
    const double near = fmax(d - reach, 0), far = fmin(d + reach, sqrt(2));
    const double at = lobe->lobe == IBL_LOBE_CHARLIE ? far : near;
    return lobe->lobe != IBL_LOBE_GGX &&
           ibl_lobe_d(lobe, at * at / 4, fmax(1 - at * at / 2, 0)) < 1e-12;
}

static void add_pixel(summing *s, int x, int y)
{
    const ibl_tree *t = s->tree;
    const double height = IBL_PI / t->env->height;
    const double width = t->pixel_width * t->row[3 * y];
    const double edge = fmax(height, width);
    double rgb[3], at[3];
    pixel_light(t, x, y, rgb);
    pixel_place(t, x, y, at);
    const double d2 = chord2(at, s->dir);
    const double fine = fine_edge(s->lobe, d2 / 4);
    if (edge < fine || is_nothing(s->lobe, sqrt(d2), edge)) {
        add(s, rgb, lobe_at(s, d2));
        return;
    }
    const double parts = fmin(ceil(2 * edge / fine), SUBDIVISIONS);
    add_patch(s, x, y, rgb, (int)parts);
}

static void add_leaf(summing *s, int i, int j)
{
    const ibl_tree *t = s->tree;
    const int x1 = least(LEAF * (i + 1), t->env->width);
    const int y1 = least(LEAF * (j + 1), t->env->height);
    for (int y = LEAF * j; y < y1; y++) {
        for (int x = LEAF * i; x < x1; x++)
            add_pixel(s, x, y);
    }
}

/* ---- bounds ------------------------------------------------------------ */

/*
 * What a node may leave out, for a unit of spread and of sqrt(spread energy):
 * half of the second derivative along the sphere, and the jump of the first
 * where the node lies across the horizon. By v = 1 - N.L the second derivative
 * is at most 2 v |K''| + |K'|.
 */
typedef struct bounds {
    double bend, jump;
} bounds;

/* |K''| is below 5 K / t and falls with t: largest at the point of the node
 * nearest to the peak. */
static bounds ggx_bounds(const ibl_lobe_shape *lobe, double near, bool across)
{
    const double a2 = lobe->alpha * lobe->alpha;
    const double t = near * near / 4 * (1 - a2) + a2;
    const double k = lobe->scale * ibl_ggx_d_t(t, lobe->alpha);
    return (bounds){k / t, across ? k : 0};
}

/* v^s (1 - v): |K'| <= v^(s-1) max(s, 1) and
 * v |K''| <= v^(s-1) s max(|s - 1|, 2). */
static bounds charlie_bounds(const ibl_lobe_shape *lobe, double near,
                             double far, bool across)
{
    const double s = lobe->power, at = s < 1 ? near : far;
    const double power = pow(fmin(at * at / 2, 1), s - 1);
    return (bounds){0.5 * lobe->scale * power *
                        (2 * s * fmax(fabs(s - 1), 2) + fmax(s, 1)),
                    across ? lobe->scale : 0};
}

/* c^m: |K'| <= m c^(m-1), |K''| <= m (m - 1) c^(m-2); with m < 2 that has no
 * limit on the horizon, and the first derivative has to do. */
static bounds phong_bounds(const ibl_lobe_shape *lobe, double near, double far,
                           bool across)
{
    const double m = lobe->power + 1;
    const double high = fmax(1 - near * near / 2, 0);
    const double low = fmax(1 - far * far / 2, 0);
    const double first = lobe->scale * m * pow(high, m - 1);
    /* Of the cosine, m = 1, 0: times no bound that would be NaN. */
    const double second =
        m > 1 ? lobe->scale * m * (m - 1) * pow(m < 2 ? low : high, m - 2) : 0;
    if (across && m < 2)
        return (bounds){0, first};
    return (bounds){0.5 * (2 * fmin(far * far / 2, 1) * second + first), 0};
}

static bounds bounds_of(const ibl_lobe_shape *lobe, double d2, double radius)
{
    const double near = fmax(sqrt(d2) - radius, 0), far = sqrt(d2) + radius;
    const bool across = fabs(1 - d2 / 2) < radius;
    switch (lobe->lobe) {
    case IBL_LOBE_CHARLIE:
        return charlie_bounds(lobe, near, far, across);
    case IBL_LOBE_PHONG:
        return phong_bounds(lobe, near, far, across);
    case IBL_LOBE_GGX:
        break;
    }
    return ggx_bounds(lobe, near, across);
}

/* Whether the lobe at the node's centre stands for the node. */
static bool is_fine(const summing *s, const node *n, double d2, double radius)
{
    const bounds b = bounds_of(s->lobe, d2, radius);
    const double spread = (double)n->spread;
    const double energy =
        (double)n->rgb[0] + (double)n->rgb[1] + (double)n->rgb[2];
    double error = b.jump * sqrt(spread * energy);
    /* 0 times no bound is 0: a sun alone is where it is. */
    if (spread > 0)
        error += b.bend * spread;
    return error <= s->share;
}

/*
 * The mean of the lobe over a node whose light spreads evenly in all
 * directions of the tangent plane. In d^2, 4 q, with ' and '' of K to that,
 *     K + K' E[delta^2] + 1/2 K'' 4 E[(delta . (at - dir))^2],
 * the last the half of E[delta^2] times d^2 (1 - q), the squared sine.
 */
static double lobe_mean(const summing *s, const node *n, double d2)
{
    const double q = d2 / 4, cosine = 1 - d2 / 2;
    const double energy =
        (double)n->rgb[0] + (double)n->rgb[1] + (double)n->rgb[2];
    if (cosine <= 0)
        return 0;
    const double d = s->lobe->scale * ibl_lobe_d(s->lobe, q, cosine);
    if (!(n->spread > 0) || !(d > 0))
        return d * cosine;
    const ibl_lobe_bend b = ibl_lobe_bend_at(s->lobe, q, cosine);
    const double first = d * (b.first * cosine - 2);
    const double second = d * (b.second * cosine - 4 * b.first);
    return d * cosine +
           (double)n->spread / energy / 4 * (first + second * q * (1 - q));
}

static void visit(summing *s, int k, int i, int j)
{
    const grid *g = &s->tree->grids[k];
    const node *n = &g->nodes[(size_t)j * (size_t)g->width + (size_t)i];
    const double rgb[3] = {(double)n->rgb[0], (double)n->rgb[1],
                           (double)n->rgb[2]};
    const double at[3] = {(double)n->at[0], (double)n->at[1], (double)n->at[2]};
    const double d2 = chord2(at, s->dir);
    if (rgb[0] + rgb[1] + rgb[2] <= 0 || 1 - d2 / 2 < -g->radius)
        return;
    if (is_fine(s, n, d2, g->radius)) {
        add(s, rgb, lobe_mean(s, n, d2));
    } else if (!k) {
        add_leaf(s, i, j);
    } else {
        const grid *fine = g - 1;
        for (int c = 0; c < 4; c++) {
            const int x = 2 * i + c % 2, y = 2 * j + c / 2;
            if (x < fine->width && y < fine->height)
                visit(s, k - 1, x, y);
        }
    }
}

void ibl_tree_mean(const ibl_tree *tree, double rgb[3])
{
    const grid *top = &tree->grids[tree->depth - 1];
    for (int c = 0; c < 3; c++) {
        double sum = 0;
        for (int i = 0; i < top->width * top->height; i++)
            sum += (double)top->nodes[i].rgb[c];
        rgb[c] = sum * tree->unit / (4 * IBL_PI) + (double)tree->floor[c];
    }
}

/* One sum; share: of the error for each node. */
static double sum_nodes(summing *s, double share)
{
    const grid *top = &s->tree->grids[s->tree->depth - 1];
    s->share = share;
    s->rgb[0] = s->rgb[1] = s->rgb[2] = 0;
    for (int j = 0; j < top->height; j++) {
        for (int i = 0; i < top->width; i++)
            visit(s, s->tree->depth - 1, i, j);
    }
    return s->rgb[0] + s->rgb[1] + s->rgb[2];
}

void ibl_tree_specular(const ibl_tree *tree, const ibl_lobe_shape *lobe,
                       const double dir[3], double accuracy, double rgb[3])
{
    /* Measured: the bounds of the nodes are not reached, nor have their
     * errors one sign; 1/16 leaves half the accuracy in the median and less
     * than twice it everywhere. */
    const double share = accuracy / 16;
    summing s = {.tree = tree, .dir = dir, .lobe = lobe};
    double mean[3], floor = 0, expected = 0, found = INFINITY;
    ibl_tree_mean(tree, mean);
    for (int c = 0; c < 3; c++) {
        floor += (double)tree->floor[c] / tree->unit;
        expected += mean[c] / tree->unit;
    }
    /* The share is of the result: of the mean at first, and again if that was
     * far above. */
    for (int pass = 0; pass < MAX_PASSES && expected < 0.5 * found; pass++) {
        found = expected;
        expected = floor + sum_nodes(&s, share * found);
    }
    for (int c = 0; c < 3; c++)
        rgb[c] = s.rgb[c] * tree->unit + (double)tree->floor[c];
}
