/* SPDX-License-Identifier: MIT */
/* Walls, those of proxies, that a set leaves to the light from outside. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "cli/probes.h"
#include "common/signals.h"

enum {
    SIDE = 13, /* points along an edge of a wall */
    POINTS = IBL_FACES * SIDE * SIDE
};

static const double least = 0.01; /* weight from outside that is told of */
/* A proxy so many times as large as the influence stands for infinity. */
static const double far = 1000;

/* A point of a box's wall, or the one in its direction on a sphere; a little
 * behind it, where an influence that ends there is over. */
static void wall_point(const ibl_volume *v, int n, double p[3])
{
    const int face = n / SIDE / SIDE, axis = face / 2;
    double at[3], scale = 1 + 1e-9;

    at[axis] = face % 2 ? 1 : -1;
    at[(axis + 1) % 3] = 2.0 * (n % SIDE) / (SIDE - 1) - 1;
    at[(axis + 2) % 3] = 2.0 * (n / SIDE % SIDE) / (SIDE - 1) - 1;
    if (v->shape == IBL_SHAPE_SPHERE)
        scale /= hypot(hypot(at[0], at[1]), at[2]);
    for (int k = 0; k < 3; k++)
        p[k] = v->centre[k] + scale * at[k] * v->half[k];
}

bool ibl_probes_check_walls(const ibl_probes_bake *p)
{
    const int count = p->set.count;
    const ibl_probe *probes = p->set.probe;
    int *order = ibl_need(calloc((size_t)count, sizeof *order));
    char line[IBL_LINE_BYTES];
    double most = least;
    int worst = -1;

    for (int i = 0; i < count; i++)
        order[i] = i; /* as they are */
    for (int i = 0; i < count; i++) {
        const ibl_volume *proxy = &probes[i].proxy;
        bool skip = !probes[i].has_proxy ||
                    ibl_volume_size(proxy) >=
                        far * ibl_volume_size(&probes[i].influence);
        for (int j = 0; j < i; j++) /* probes of a room have its walls */
            skip |= probes[j].has_proxy &&
                    !memcmp(&probes[j].proxy, proxy, sizeof *proxy);
        if (skip)
            continue;
        for (int n = 0; n < POINTS; n++) {
            ibl_probe_mix mix;
            double point[3];
            wall_point(proxy, n, point);
            ibl_probes_blend(probes, count, order, point, NULL, &mix);
            if (mix.rest > most) {
                most = mix.rest;
                worst = i;
            }
        }
    }
    free(order);
    if (worst < 0)
        return true;
    snprintf(line, sizeof line,
             "%s: probe \"%.60s\": up to %.0f %% of the light on the walls "
             "of its proxy comes from outside all probes: let its "
             "influence, or those of others, reach beyond them by the "
             "blend%s",
             p->input, p->set.entry[worst].name, 100 * most,
             probes[worst].blend > 0 ? "" : ", or by a little without one");
    if (p->opts->common.read.strict)
        return ibl_console_fail(p->console, "%s", line);
    ibl_console_warn(p->console, "%s", line);
    return true;
}
