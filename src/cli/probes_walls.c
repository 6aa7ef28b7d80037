/* SPDX-License-Identifier: MIT */
/* Walls, those of proxies, that a set leaves to the light from outside. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cli/probes.h"

enum {
    SIDE = 13, /* points along an edge of a wall */
    POINTS = IBL_FACES * SIDE * SIDE
};

static const double least = 0.01; /* weight from outside that is told of */
/* A proxy so many times as large as the influence stands for infinity. */
static const double far = 1000;

/* Points that are lit from outside and nearest to a probe. */
typedef struct leak {
    double sum, most; /* of the weights from outside */
    double low[3], high[3];
    double away; /* largest distance from the middle of the influence */
} leak;

static double distance(const double a[3], const double b[3])
{
    return hypot(hypot(a[0] - b[0], a[1] - b[1]), a[2] - b[2]);
}

/* A point of a box's wall, or the one in its direction on a sphere. */
static void wall_point(const ibl_volume *v, int n, double p[3])
{
    const int face = n / SIDE / SIDE, axis = face / 2;
    const bool round = v->shape == IBL_SHAPE_SPHERE;
    double at[3];

    at[axis] = face % 2 ? 1 : -1;
    at[(axis + 1) % 3] = 2.0 * (n % SIDE) / (SIDE - 1) - 1;
    at[(axis + 2) % 3] = 2.0 * (n / SIDE % SIDE) / (SIDE - 1) - 1;
    const double scale = round ? 1 / distance(at, (double[3]){0}) : 1;
    for (int k = 0; k < 3; k++)
        p[k] = v->centre[k] + scale * at[k] * v->half[k];
}

static bool share_walls(const ibl_probe *a, const ibl_probe *b)
{
    const ibl_volume *v = &a->proxy, *w = &b->proxy;

    return a->has_proxy && b->has_proxy && v->shape == w->shape &&
           !memcmp(v->centre, w->centre, sizeof v->centre) &&
           !memcmp(v->half, w->half, sizeof v->half);
}

/* Of the probes with the walls of probe i, the nearest to a point. */
static int nearest(const ibl_probe *probes, int count, int i, const double p[3])
{
    int best = i;

    for (int j = i + 1; j < count; j++)
        if (share_walls(&probes[i], &probes[j]) &&
            distance(probes[j].position, p) <
                distance(probes[best].position, p))
            best = j;
    return best;
}

static void find_leaks(const ibl_probe *probes, const int *order, int count,
                       int i, leak *leaks)
{
    const ibl_volume *walls = &probes[i].proxy;
    double p[3], behind[3]; /* there an influence that ends at p is over */
    ibl_probe_mix mix;

    for (int n = 0; n < POINTS; n++) {
        wall_point(walls, n, p);
        for (int k = 0; k < 3; k++)
            behind[k] = p[k] + 1e-9 * (p[k] - walls->centre[k]);
        ibl_probes_blend(probes, count, order, behind, NULL, &mix);
        if (mix.rest <= least)
            continue;
        const int owner = nearest(probes, count, i, p);
        leak *l = &leaks[owner];
        for (int k = 0; k < 3; k++) {
            l->low[k] = l->sum > 0 ? fmin(l->low[k], p[k]) : p[k];
            l->high[k] = l->sum > 0 ? fmax(l->high[k], p[k]) : p[k];
        }
        l->away = fmax(l->away, distance(p, probes[owner].influence.centre));
        l->most = fmax(l->most, mix.rest);
        l->sum += mix.rest;
    }
}

/* Writes the influence, with these points, as a member of the set. */
static void write_influence(const ibl_probe *p, const leak *l, char *to,
                            size_t size)
{
    const ibl_volume *v = &p->influence, *w = &p->proxy;
    const double beyond =
        p->blend > 0 ? p->blend
                     : 0.01 * fmin(w->half[0], fmin(w->half[1], w->half[2]));
    double centre[3], half[3];

    for (int k = 0; k < 3; k++) {
        const double low = fmin(v->centre[k] - v->half[k], l->low[k] - beyond);
        const double high =
            fmax(v->centre[k] + v->half[k], l->high[k] + beyond);
        centre[k] = (low + high) / 2;
        half[k] = (high - low) / 2;
    }
    if (v->shape == IBL_SHAPE_SPHERE)
        snprintf(to, size,
                 "{\"sphere\": {\"centre\": [%.8g, %.8g, %.8g], "
                 "\"radius\": %.8g}}",
                 v->centre[0], v->centre[1], v->centre[2],
                 fmax(v->half[0], l->away + beyond));
    else
        snprintf(to, size,
                 "{\"box\": {\"centre\": [%.8g, %.8g, %.8g], "
                 "\"half\": [%.8g, %.8g, %.8g]}}",
                 centre[0], centre[1], centre[2], half[0], half[1], half[2]);
}

/* Reports the probe with the most light from outside, and how many have some.
 */
static bool report(const ibl_probes_bake *p, const ibl_probe *probes,
                   const leak *leaks)
{
    char influence[256], others[64] = "", line[IBL_LINE_BYTES];
    int worst = 0, count = 0;

    for (int i = 0; i < p->set.count; i++) {
        count += leaks[i].sum > 0;
        worst = leaks[i].sum > leaks[worst].sum ? i : worst;
    }
    if (!count)
        return true;
    write_influence(&probes[worst], &leaks[worst], influence, sizeof influence);
    if (count > 1)
        snprintf(others, sizeof others, "; %d more such probe%s", count - 1,
                 count > 2 ? "s" : "");
    snprintf(line, sizeof line,
             "%s: probe \"%.60s\": up to %.0f %% of the light on the walls of "
             "its proxy comes from outside all probes: make it "
             "\"influence\": %s%s",
             p->opts->input, p->set.entry[worst].name, 100 * leaks[worst].most,
             influence, others);
    if (p->opts->common.read.strict)
        return ibl_console_fail(p->console, "%s", line);
    ibl_console_warn(p->console, "%s", line);
    return true;
}

bool ibl_probes_check_walls(const ibl_probes_bake *p)
{
    const int count = p->set.count;
    ibl_probe *probes = calloc((size_t)count, sizeof *probes);
    leak *leaks = calloc((size_t)count, sizeof *leaks);
    int *order = calloc((size_t)count, sizeof *order);
    bool ok = probes && leaks && order;

    for (int i = 0; i < count && ok; i++) {
        probes[i] = p->set.entry[i].probe;
        order[i] = i;
    }
    for (int i = 0; i < count && ok; i++) {
        bool first = probes[i].has_proxy;
        for (int j = 0; j < i && first; j++)
            first = !share_walls(&probes[j], &probes[i]);
        if (first && ibl_volume_size(&probes[i].proxy) <
                         far * ibl_volume_size(&probes[i].influence))
            find_leaks(probes, order, count, i, leaks);
    }
    ok = ok ? report(p, probes, leaks) : ibl_probes_no_memory(p);
    free(probes);
    free(leaks);
    free(order);
    return ok;
}
