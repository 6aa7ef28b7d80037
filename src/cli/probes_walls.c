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
    double most; /* of their weights from outside; 0: there are none */
    double low[3], high[3];
    double away; /* largest distance from the middle of the influence */
} leak;

typedef struct walls {
    int count;
    ibl_probe probe[IBL_MAX_PROBES];
    int order[IBL_MAX_PROBES]; /* as they are */
    leak leak[IBL_MAX_PROBES];
} walls;

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

/* Of the probes with the walls of probe i the first, or, with a point, the
 * nearest. */
static int find(const walls *w, int i, const double *p)
{
    const ibl_probe *a = w->probe;
    int best = -1;

    for (int j = 0; j < w->count && (p || best < 0); j++)
        if (a[j].has_proxy && a[j].proxy.shape == a[i].proxy.shape &&
            !memcmp(a[j].proxy.centre, a[i].proxy.centre, sizeof(double[3])) &&
            !memcmp(a[j].proxy.half, a[i].proxy.half, sizeof(double[3])) &&
            (best < 0 ||
             distance(a[j].position, p) < distance(a[best].position, p)))
            best = j;
    return best;
}

static void find_leaks(walls *w, int i)
{
    const ibl_volume *proxy = &w->probe[i].proxy;
    double p[3], behind[3]; /* there an influence that ends at p is over */
    ibl_probe_mix mix;

    for (int n = 0; n < POINTS; n++) {
        wall_point(proxy, n, p);
        for (int k = 0; k < 3; k++)
            behind[k] = p[k] + 1e-9 * (p[k] - proxy->centre[k]);
        ibl_probes_blend(w->probe, w->count, w->order, behind, NULL, &mix);
        if (mix.rest <= least)
            continue;
        const int owner = find(w, i, p);
        leak *l = &w->leak[owner];
        for (int k = 0; k < 3; k++) {
            l->low[k] = l->most > 0 ? fmin(l->low[k], p[k]) : p[k];
            l->high[k] = l->most > 0 ? fmax(l->high[k], p[k]) : p[k];
        }
        l->away = fmax(l->away, distance(p, w->probe[owner].influence.centre));
        l->most = fmax(l->most, mix.rest);
    }
}

/* Writes the influence, with these points, as a member of the set. */
static void write_influence(const ibl_probe *p, const leak *l, char to[256])
{
    const ibl_volume *v = &p->influence;
    const double *w = p->proxy.half, *h = v->half;
    const double beyond =
        p->blend > 0 ? p->blend : 0.01 * fmin(w[0], fmin(w[1], w[2]));
    double c[3], half[3];

    for (int k = 0; k < 3; k++) {
        const double low = fmin(v->centre[k] - h[k], l->low[k] - beyond);
        const double high = fmax(v->centre[k] + h[k], l->high[k] + beyond);
        c[k] = v->shape == IBL_SHAPE_BOX ? (low + high) / 2 : v->centre[k];
        half[k] = (high - low) / 2;
    }
    const int length =
        snprintf(to, 256, "{\"%s\": {\"centre\": [%.8g, %.8g, %.8g], ",
                 ibl_shape_name(v->shape), c[0], c[1], c[2]);
    if (v->shape == IBL_SHAPE_BOX)
        snprintf(to + length, 256 - length, "\"half\": [%.8g, %.8g, %.8g]}}",
                 half[0], half[1], half[2]);
    else
        snprintf(to + length, 256 - length, "\"radius\": %.8g}}",
                 fmax(h[0], l->away + beyond));
}

bool ibl_probes_check_walls(const ibl_probes_bake *p)
{
    walls *w = calloc(1, sizeof *w);
    char influence[256], others[64] = "", line[IBL_LINE_BYTES];
    int worst = 0, more = -1;

    for (int i = 0; i < p->set.count && w; i++) {
        w->probe[i] = p->set.entry[i].probe;
        w->order[w->count++] = i;
    }
    for (int i = 0; w && i < w->count; i++)
        if (find(w, i, NULL) == i &&
            ibl_volume_size(&w->probe[i].proxy) <
                far * ibl_volume_size(&w->probe[i].influence))
            find_leaks(w, i);
    for (int i = 0; w && i < w->count; i++) {
        more += w->leak[i].most > 0;
        worst = w->leak[i].most > w->leak[worst].most ? i : worst;
    }
    if (more < 0) {
        const bool ok = w;
        free(w);
        return ok;
    }
    write_influence(&w->probe[worst], &w->leak[worst], influence);
    if (more)
        snprintf(others, sizeof others, "; such probes: %d more", more);
    snprintf(line, sizeof line,
             "%s: probe \"%.60s\": up to %.0f %% of the light on the walls of "
             "its proxy comes from outside all probes: make it "
             "\"influence\": %s%s",
             p->input, p->set.entry[worst].name, 100 * w->leak[worst].most,
             influence, others);
    free(w);
    if (p->opts->common.read.strict)
        return ibl_console_fail(p->console, "%s", line);
    ibl_console_warn(p->console, "%s", line);
    return true;
}
