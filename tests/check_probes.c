/* SPDX-License-Identifier: MIT */
/* Which probes a point has, against definitions written out a second time. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "ibl/probes.h"
#include "test.h"

enum {
    MOST = 12
};

static void random_point(test_random *r, double reach, double p[3])
{
    for (int i = 0; i < 3; i++)
        p[i] = test_random_between(r, -reach, reach);
}

static ibl_probe random_probe(test_random *r)
{
    ibl_probe probe = {0};

    random_point(r, 2, probe.position);
    random_point(r, 2, probe.influence.centre);
    for (int i = 0; i < 3; i++)
        probe.influence.half[i] = test_random_between(r, 0.3, 2.5);
    probe.influence.shape =
        test_random_below(r, 2) ? IBL_SHAPE_BOX : IBL_SHAPE_SPHERE;
    probe.blend = test_random_between(r, 0.1, 1.5);
    probe.priority =
        test_random_below(r, 4) == 0 ? test_random_below(r, 3) - 1 : 0;
    return probe;
}

/* Probes of which some are one another's copies, within another, or share a
 * wall with one; in every third set many have a small share at once. */
static int random_set(test_random *r, ibl_probe *probes)
{
    const bool crowded = test_random_below(r, 3) == 0;
    const int count = crowded ? MOST : 1 + test_random_below(r, MOST);

    for (int i = 0; i < count; i++) {
        probes[i] = random_probe(r);
        if (crowded) {
            random_point(r, 0.5, probes[i].influence.centre);
            probes[i].blend = test_random_between(r, 3, 12);
            continue;
        }
        if (i == 0)
            continue;
        const ibl_volume *other = &probes[test_random_below(r, i)].influence;
        ibl_volume *mine = &probes[i].influence;
        switch (test_random_below(r, 4)) {
        case 0:
            *mine = *other;
            break;
        case 1:
            *mine = *other;
            for (int k = 0; k < 3; k++)
                mine->half[k] *= 0.6;
            break;
        case 2:
            *mine = *other;
            mine->centre[0] += 2 * other->half[0];
            break;
        default:
            break;
        }
    }
    return count;
}

static long double length3(const double a[3], const double b[3])
{
    const long double x = (long double)a[0] - b[0];
    const long double y = (long double)a[1] - b[1];
    const long double z = (long double)a[2] - b[2];

    return sqrtl(x * x + y * y + z * z);
}

static long double true_depth(const ibl_volume *v, const double p[3])
{
    long double least = HUGE_VALL;

    if (v->shape == IBL_SHAPE_SPHERE)
        return v->half[0] - length3(p, v->centre);
    for (int i = 0; i < 3; i++) {
        const long double low = p[i] - ((long double)v->centre[i] - v->half[i]);
        const long double high = (long double)v->centre[i] + v->half[i] - p[i];
        least = fminl(least, fminl(low, high));
    }
    return least;
}

static long double true_influence(const ibl_probe *probe, const double p[3])
{
    const long double depth = true_depth(&probe->influence, p);

    if (depth <= 0)
        return 0;
    if (depth >= probe->blend)
        return 1;
    const long double t = depth / probe->blend;
    return 3 * t * t - 2 * t * t * t;
}

/* ---- influence ---------------------------------------------------------- */

TEST(names_and_sizes)
{
    const ibl_volume box = {IBL_SHAPE_BOX, {1, 2, 3}, {1, 2, 3}};
    const ibl_volume ball = {IBL_SHAPE_SPHERE, {1, 2, 3}, {2, 0, 0}};

    CHECK(strcmp(ibl_shape_name(IBL_SHAPE_BOX), "box") == 0);
    CHECK(strcmp(ibl_shape_name(IBL_SHAPE_SPHERE), "sphere") == 0);
    CHECK(strcmp(ibl_shape_name((ibl_shape)7), "unknown") == 0);
    CHECK_NEAR(ibl_volume_size(&box), 48, 0);
    CHECK_NEAR(ibl_volume_size(&ball), 33.510321638291127877, 1e-14);
}

TEST(influence_without_blend)
{
    const ibl_probe probe = {
        .influence = {IBL_SHAPE_SPHERE, {10, 0, 0}, {1, 2, 3}}};

    CHECK(ibl_probe_influence(&probe, (double[]){10, 0.999, 0}) == 1);
    CHECK(ibl_probe_influence(&probe, (double[]){10, 1, 0}) == 0);
}

TEST(influence_everywhere)
{
    test_random r = {1};
    double p[3];

    for (int n = 0; n < 20000; n++) {
        const ibl_probe probe = random_probe(&r);
        random_point(&r, 4, p);
        CHECK_NEAR(ibl_probe_influence(&probe, p),
                   (double)true_influence(&probe, p), 4e-14);
    }
}

/* ---- order -------------------------------------------------------------- */

TEST(order_by_definition)
{
    test_random r = {2};
    ibl_probe probes[MOST];
    int order[MOST], ties = 0;

    for (int n = 0; n < 2000; n++) {
        const int count = random_set(&r, probes);
        bool seen[MOST] = {false};

        ibl_probes_order(probes, count, order);
        for (int i = 0; i < count; i++) {
            NEED(order[i] >= 0 && order[i] < count && !seen[order[i]]);
            seen[order[i]] = true;
            if (i == 0)
                continue;
            const int a = order[i - 1], b = order[i];
            const double size_a = ibl_volume_size(&probes[a].influence);
            const double size_b = ibl_volume_size(&probes[b].influence);
            CHECK(probes[a].priority >= probes[b].priority);
            if (probes[a].priority != probes[b].priority)
                continue;
            CHECK(size_a <= size_b);
            CHECK(size_a != size_b || a < b);
            ties += size_a == size_b;
        }
    }
    CHECK(ties > 1000);
    ibl_probes_order(probes, 0, NULL);
}

static void dense(const ibl_probe_mix *mix, double *weights)
{
    memset(weights, 0, MOST * sizeof *weights);
    for (int i = 0; i < mix->count; i++)
        weights[mix->probe[i]] += mix->weight[i];
}

static void check_mix(const ibl_probe_mix *mix, int count)
{
    double sum = mix->rest;
    unsigned seen = 0;

    CHECK(mix->count >= 0 && mix->count <= IBL_MAX_PROBES_AT);
    CHECK(mix->rest >= 0 && mix->rest <= 1);
    for (int i = 0; i < mix->count; i++) {
        CHECK(mix->probe[i] >= 0 && mix->probe[i] < count);
        CHECK(!(seen >> mix->probe[i] & 1));
        seen |= 1U << mix->probe[i];
        CHECK(mix->weight[i] >= 0 && mix->weight[i] <= 1);
        sum += mix->weight[i];
    }
    CHECK_NEAR(sum, 1, 1e-15);
}

/* ---- volumes ------------------------------------------------------------ */

/* The shares, from sums that are never over 1; returns how many have one. */
static int true_shares(const ibl_probe *probes, int count, const int *order,
                       const double p[3], const double *alpha,
                       long double *share)
{
    long double sum = 0;
    int some = 0;

    for (int i = 0; i < count; i++) {
        const long double before = fminl(sum, 1);

        sum += true_influence(&probes[order[i]], p) *
               (alpha ? alpha[order[i]] : 1);
        share[order[i]] = fminl(sum, 1) - before;
        some += share[order[i]] > 0;
    }
    return some;
}

static long double next_share(const long double *share, int count)
{
    for (int i = 0; i < count; i++) {
        int larger = 0;

        for (int j = 0; j < count; j++)
            larger += share[j] > share[i] || (share[j] == share[i] && j < i);
        if (larger == IBL_MAX_PROBES_AT)
            return share[i];
    }
    return 0;
}

TEST(blend_by_definition)
{
    test_random r = {6};
    ibl_probe probes[MOST];
    ibl_probe_mix mix;
    long double share[MOST];
    double p[3], weights[MOST], alpha[MOST];
    int order[MOST], crowded = 0;

    for (int n = 0; n < 20000; n++) {
        const int count = random_set(&r, probes);
        const double *seen = n % 2 ? alpha : NULL;

        for (int i = 0; i < count; i++)
            alpha[i] = test_random_below(&r, 3) ? test_random_unit(&r) : 0;
        ibl_probes_order(probes, count, order);
        random_point(&r, 2.5, p);
        crowded += true_shares(probes, count, order, p, seen, share) >
                   IBL_MAX_PROBES_AT;
        const long double next = next_share(share, count);
        long double all = 0, kept = 0;
        for (int i = 0; i < count; i++) {
            all += share[i];
            kept += fmaxl(share[i] - next, 0);
        }
        ibl_probes_blend(probes, count, order, p, seen, &mix);
        check_mix(&mix, count);
        dense(&mix, weights);
        for (int i = 0; i < count; i++)
            CHECK_NEAR(weights[i] * (double)kept,
                       (double)(fmaxl(share[i] - next, 0) * all), 1e-13);
        CHECK_NEAR(mix.rest, (double)(1 - all), 1e-13);
        for (int i = 0; i < mix.count; i++)
            CHECK(mix.weight[i] > 0);
        for (int i = 1; i < mix.count; i++) {
            int a = 0, b = 0;
            while (order[a] != mix.probe[i - 1])
                a++;
            while (order[b] != mix.probe[i])
                b++;
            CHECK(a < b);
        }
    }
    CHECK_MSG(crowded > 100, "only %d points with many", crowded);
}

/* One more than are kept, none of them least. */
TEST(blend_of_equals)
{
    ibl_probe probes[IBL_MAX_PROBES_AT + 1];
    int order[IBL_MAX_PROBES_AT + 1];
    ibl_probe_mix mix;

    for (int i = 0; i <= IBL_MAX_PROBES_AT; i++)
        probes[i] = (ibl_probe){
            .influence = {IBL_SHAPE_SPHERE, {0, 0, 0}, {1, 1, 1}}, .blend = 8};
    ibl_probes_order(probes, IBL_MAX_PROBES_AT + 1, order);
    ibl_probes_blend(probes, IBL_MAX_PROBES_AT + 1, order, (double[]){0, 0, 0},
                     NULL, &mix);
    CHECK(mix.count == IBL_MAX_PROBES_AT);
    for (int i = 0; i < mix.count; i++)
        CHECK_NEAR(mix.weight[i],
                   0.04296875 * (IBL_MAX_PROBES_AT + 1) / IBL_MAX_PROBES_AT,
                   1e-15);
}

/* ---- for shaders -------------------------------------------------------- */

TEST(packed)
{
    ibl_probe probes[2] = {{.blend = 0.25, .layer = 7, .priority = 1},
                           {.blend = 0.5, .has_proxy = 2, .layer = 2047}};
    const int order[2] = {1, 0};
    float texels[2 * IBL_PROBE_FLOATS + 1];
    const float expected[IBL_PROBE_FLOATS] = {
        1, 2, 3, 0.5F, 4, 5, 6, 1, 7, 8, 9, 1, 10, 11, 12, 0, 13, 14, 15, 2047};

    probes[1].influence = (ibl_volume){IBL_SHAPE_SPHERE, {1, 2, 3}, {4, 5, 6}};
    probes[1].proxy = (ibl_volume){IBL_SHAPE_BOX, {7, 8, 9}, {10, 11, 12}};
    for (int i = 0; i < 3; i++)
        probes[1].position[i] = 13 + i;
    texels[2 * IBL_PROBE_FLOATS] = -1;
    ibl_probes_pack(probes, 2, order, texels);
    for (int i = 0; i < IBL_PROBE_FLOATS; i++)
        CHECK(texels[i] == expected[i]);
    CHECK(texels[IBL_PROBE_FLOATS + 3] == 0.25F);
    CHECK(texels[IBL_PROBE_FLOATS + 11] == 0);
    CHECK(texels[IBL_PROBE_FLOATS + 19] == 7);
    CHECK(texels[2 * IBL_PROBE_FLOATS] == -1);
}

/* ---- hostile ------------------------------------------------------------ */

static double hostile(test_random *r, bool positive)
{
    static const double values[] = {0,   1e-75, 1e75, 1,    0.5, 2,
                                    -0., 1e-30, 1e30, 3e-9, 7e8, 1e-75};
    double v = values[test_random_below(r, 12)];

    if (test_random_below(r, 2))
        v = test_random_between(r, 0, 4);
    if (positive)
        return v > 0 ? v : 1;
    return test_random_below(r, 2) ? v : -v;
}

TEST(no_nan)
{
    test_random r = {8};
    ibl_probe probes[6] = {0};
    ibl_probe_mix mix;
    int order[6];
    const int rounds = TEST_SANITIZED ? 5000 : 50000;
    int corrected = 0;

    for (int n = 0; n < rounds; n++) {
        double p[3], d[3], lookup[3];
        for (int i = 0; i < 3; i++)
            p[i] = hostile(&r, false);
        for (int j = 0; j < 6; j++) {
            for (int i = 0; i < 3; i++) {
                probes[j].position[i] = hostile(&r, false);
                probes[j].influence.centre[i] = hostile(&r, false);
                probes[j].influence.half[i] = hostile(&r, true);
                probes[j].proxy.centre[i] = hostile(&r, false);
                probes[j].proxy.half[i] = hostile(&r, true);
                d[i] = hostile(&r, false);
            }
            probes[j].has_proxy = 1;
            probes[j].proxy.shape = (ibl_shape)test_random_below(&r, 2);
            probes[j].blend = fabs(hostile(&r, false));
            probes[j].influence.shape = (ibl_shape)test_random_below(&r, 2);
            if (test_random_below(&r, 3) == 0)
                memcpy(p, probes[j].position, sizeof p);
            else if (test_random_below(&r, 2))
                memcpy(p, probes[j].proxy.centre, sizeof p);
            d[n % 3] = d[n % 3] != 0 ? d[n % 3] : 5e-324;
            corrected += ibl_probe_parallax(&probes[j], p, d, lookup);
            CHECK_NEAR((double)length3(lookup, (double[]){0, 0, 0}), 1, 4e-16);
        }
        ibl_probes_order(probes, 6, order);
        ibl_probes_blend(probes, 6, order, p, NULL, &mix);
        check_mix(&mix, 6);
    }
    CHECK_MSG(corrected > rounds, "%d", corrected);
}
