/* SPDX-License-Identifier: MIT */
/*
 * Blocks of 4x4 source pixels are the leaves of a quadtree whose nodes know
 * the light that they hold, where its centre is and how far it spreads from
 * there. For one direction the lobe is evaluated at the centres of nodes: the
 * first order of what that leaves out vanishes by the choice of the centre,
 * the second is at most
 *     1/2 spread sup |K''|,   spread = sum e_i |d_i - c|^2,
 * over the node. With K = (alpha / t)^2 N.L, t = sin^2 + alpha^2 cos^2 of the
 * half vector, |K''| is below 5 K / t and falls with t, so its value at the
 * point of the node nearest to the lobe's peak bounds it. A node is opened
 * where that bound is above its share of the accuracy. A sun in a node has no
 * spread and is taken where it is, however large the node; a sky far from the
 * peak is taken in large pieces. This is the idea of lightcuts (Walter et al.
 * 2005) with a zonal kernel.
 */
#include "bake/tree.h"

#include <math.h>
#include <stdbool.h>

#include "brdf/ggx.h"
#include "core/alloc.h"
#include "core/context.h"

enum {
    LEAF = 4, /* pixels along the edge of a leaf */
    MAX_DEPTH = 16,
    SUBDIVISIONS = 32, /* of a pixel's edge, at most */
    MAX_PASSES = 4
};

typedef struct node {
    float rgb[3]; /* sum of L dO, above the floor */
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
    int depth;                      /* grids */
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
        rgb[c] = ((double)p[c] - (double)t->floor[c]) * t->row[3 * y + 2];
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

static void find_floor(ibl_tree *t)
{
    const float *p = t->env->data;
    const size_t pixels = (size_t)t->env->width * (size_t)t->env->height;
    for (int c = 0; c < 3; c++)
        t->floor[c] = p[c];
    for (size_t i = 0; i < pixels; i++) {
        for (int c = 0; c < 3; c++)
            t->floor[c] =
                p[3 * i + c] < t->floor[c] ? p[3 * i + c] : t->floor[c];
    }
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
    find_floor(t);
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

/* In s = sin^2 of the half vector's angle the integral is
 * 4 pi int_0^1/2 (alpha / t)^2 (1 - 2 s) ds, and Walter's sampling has
 * du = (alpha / t)^2 ds: midpoints in u. */
ibl_tree_lobe ibl_tree_lobe_of(double alpha)
{
    enum {
        POINTS = 4096
    };
    const double a2 = alpha * alpha, part = 1 / (1 + a2);
    double sum = 0;
    for (int i = 0; i < POINTS; i++) {
        const double u = part * (i + 0.5) / POINTS;
        sum += 1 - 2 * a2 * u / (a2 * u + 1 - u);
    }
    return (ibl_tree_lobe){alpha, 4 * IBL_PI * part * sum / POINTS};
}

typedef struct summing {
    const ibl_tree *tree;
    const double *dir;
    double alpha;
    double share; /* of the error, in energy times lobe, for each node */
    double rgb[3];
} summing;

static double chord2(const double a[3], const double b[3])
{
    const double x = a[0] - b[0], y = a[1] - b[1], z = a[2] - b[2];
    return x * x + y * y + z * z;
}

/* (alpha / t)^2 N.L at a distance from the peak. */
static double lobe_at(const summing *s, double d2)
{
    const double a2 = s->alpha * s->alpha;
    const double sin2 = d2 / 4, k = s->alpha / (sin2 + a2 * (1 - sin2));
    return sin2 < 0.5 ? k * k * (1 - 2 * sin2) : 0;
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

static void add_pixel(summing *s, int x, int y)
{
    const ibl_tree *t = s->tree;
    const double a2 = s->alpha * s->alpha;
    const double height = IBL_PI / t->env->height;
    const double width = t->pixel_width * t->row[3 * y];
    const double edge = fmax(height, width);
    double rgb[3], at[3];
    pixel_light(t, x, y, rgb);
    pixel_place(t, x, y, at);
    const double d2 = chord2(at, s->dir);
    /* 2 sqrt(t) is the width over which the lobe changes. */
    const double wide = 2 * sqrt(d2 / 4 + a2);
    if (edge * 4 < wide) {
        add(s, rgb, lobe_at(s, d2));
        return;
    }
    const double parts = fmin(ceil(8 * edge / wide), SUBDIVISIONS);
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

/* Whether the lobe at the node's centre stands for the node. */
static bool is_fine(const summing *s, const node *n, double d2, double radius)
{
    const double a2 = s->alpha * s->alpha, spread = (double)n->spread;
    const double near = fmax(sqrt(d2) - radius, 0);
    const double t = near * near / 4 * (1 - a2) + a2;
    const double k = s->alpha / t * s->alpha / t;
    double error = spread * k / t;
    /* On the horizon the cosine has a corner. */
    if (fabs(1 - d2 / 2) < radius)
        error += k * sqrt(spread * ((double)n->rgb[0] + (double)n->rgb[1] +
                                    (double)n->rgb[2]));
    return error <= s->share;
}

/*
 * The mean of the lobe over a node whose light spreads evenly in all
 * directions of the tangent plane. In q = d^2, with q' and q'' of K,
 *     K + K' E[delta^2] + 1/2 K'' 4 E[(delta . (at - dir))^2]
 * and sin^2 of the angle is q (1 - q / 4).
 */
static double lobe_mean(const summing *s, const node *n, double q)
{
    const double a2 = s->alpha * s->alpha, slope = (1 - a2) / 4;
    const double t = a2 + slope * q, cosine = 1 - q / 2;
    const double k = s->alpha / t * s->alpha / t;
    const double k1 = -2 * k * slope / t,
                 k2 = 6 * k * (slope / t) * (slope / t);
    const double energy =
        (double)n->rgb[0] + (double)n->rgb[1] + (double)n->rgb[2];
    if (cosine <= 0)
        return 0;
    return k * cosine +
           (double)n->spread / energy *
               (k1 * cosine - k / 2 + (k2 * cosine - k1) * q * (1 - q / 4));
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
        rgb[c] = sum / (4 * IBL_PI) + (double)tree->floor[c];
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

void ibl_tree_specular(const ibl_tree *tree, const ibl_tree_lobe *lobe,
                       const double dir[3], double accuracy, double rgb[3])
{
    /* Measured: the bounds of the nodes are not reached, nor have their
     * errors one sign; 1/16 leaves half the accuracy in the median and less
     * than twice it everywhere. */
    const double share = accuracy / 16;
    summing s = {.tree = tree, .dir = dir, .alpha = lobe->alpha};
    double mean[3], floor = 0, expected = 0, found = INFINITY;
    ibl_tree_mean(tree, mean);
    for (int c = 0; c < 3; c++) {
        floor += lobe->norm * (double)tree->floor[c];
        expected += lobe->norm * mean[c];
    }
    /* The share is of the result: of the mean at first, and again if that was
     * far above. */
    for (int pass = 0; pass < MAX_PASSES && expected < 0.5 * found; pass++) {
        found = expected;
        expected = floor + sum_nodes(&s, share * found);
    }
    for (int c = 0; c < 3; c++)
        rgb[c] = s.rgb[c] / lobe->norm + (double)tree->floor[c];
}
