/* SPDX-License-Identifier: MIT */
/*
 * Probes at run time, on one thread, medians: culling the tiles of a picture
 * of 1920x1080, how many probes a tile has then, and mixing and correcting for
 * a point.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "ibl/probes.h"
#include "test.h"

enum {
    RUNS = 9,
    POINTS = 20000,
    WIDTH = 1920,
    HEIGHT = 1080
};

static const int counts[] = {1, 8, 64};
static const int edges[] = {8, 16, 32};
static unsigned long long masks[(WIDTH / 8) * (HEIGHT / 8)];
static double sink; /* keeps what is measured */

/* Rooms of a building, 40 by 40, looked at from a corner. */
static void make_probes(ibl_probe *probes)
{
    test_random r = {1};

    for (int i = 0; i < IBL_MAX_TILE_PROBES; i++) {
        ibl_volume v = {.shape = (ibl_shape)(i % 2)};
        for (int k = 0; k < 3; k++) {
            v.centre[k] = (k == 1 ? 2 : 40) * (test_random_unit(&r) - 0.5);
            v.half[k] = 1 + 3 * test_random_unit(&r);
        }
        probes[i] = (ibl_probe){.influence = v, .proxy = v, .blend = 0.5};
        probes[i].has_proxy = 1;
        memcpy(probes[i].position, v.centre, sizeof v.centre);
    }
}

static void measure_tiles(const ibl_probe *probes, int count, int edge)
{
    const ibl_tiles tiles = {
        {.97, 0, 0, 0, 0, 1.73, 0, 0, 0, 0, -1, -1, 0, 0, 0, 22},
        WIDTH,
        HEIGHT,
        edge};
    const int n = ibl_tiles_columns(&tiles) * ibl_tiles_rows(&tiles);
    double ms[RUNS];
    long set = 0;

    for (int run = 0; run < RUNS; run++) {
        const double start = test_ms(CLOCK_THREAD_CPUTIME_ID);
        if (ibl_tiles_cull(&tiles, probes, count, masks))
            exit(1);
        ms[run] = test_ms(CLOCK_THREAD_CPUTIME_ID) - start;
    }
    for (int i = 0; i < n; i++)
        set += __builtin_popcountll(masks[i]);
    printf("%2d probes, %5d tiles of %2d: %7.3f ms, %5.2f probes a tile\n",
           count, n, edge, test_median(ms, RUNS), (double)set / n);
}

/* What a point needs: its mix, and a direction corrected for each of that. */
static void measure_points(const ibl_probe *probes, int count)
{
    double ms[2][RUNS];
    ibl_probe_mix mix;
    int order[IBL_MAX_TILE_PROBES];

    ibl_probes_order(probes, count, order);
    for (int run = 0; run < 2 * RUNS; run++) {
        test_random r = {2};
        const double start = test_ms(CLOCK_THREAD_CPUTIME_ID);
        for (int i = 0; i < POINTS; i++) {
            const double p[3] = {40 * test_random_unit(&r) - 20,
                                 2 * test_random_unit(&r) - 1,
                                 40 * test_random_unit(&r) - 20};
            const double d[3] = {p[2], 1, p[0]};
            double lookup[3];
            if (run % 2)
                ibl_probes_near(probes, count, p, IBL_MAX_PROBES_AT, &mix);
            else
                ibl_probes_blend(probes, count, order, p, NULL, &mix);
            for (int k = 0; k < mix.count; k++) {
                ibl_probe_parallax(&probes[mix.probe[k]], p, d, lookup);
                sink += lookup[0] * mix.weight[k];
            }
        }
        ms[run % 2][run / 2] = test_ms(CLOCK_THREAD_CPUTIME_ID) - start;
    }
    printf("%2d probes: a point by volumes %6.0f ns, by distance %6.0f ns\n",
           count, test_median(ms[0], RUNS) * 1e6 / POINTS,
           test_median(ms[1], RUNS) * 1e6 / POINTS);
}

int main(void)
{
    ibl_probe probes[IBL_MAX_TILE_PROBES];

    make_probes(probes);
    for (int e = 0; e < 3; e++) {
        for (int c = 0; c < 3; c++)
            measure_tiles(probes, counts[c], edges[e]);
    }
    for (int c = 0; c < 3; c++)
        measure_points(probes, counts[c]);
    return sink == 0.123;
}
