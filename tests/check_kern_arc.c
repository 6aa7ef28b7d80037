/* SPDX-License-Identifier: MIT */
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "kern/arc.h"
#include "test.h"

static const double pi = 3.14159265358979323846;

enum {
    ROWS = 3,
    GUARD = 16
};

static double *doubles(size_t n)
{
    double *p = malloc(n * sizeof *p);

    if (!p)
        exit(1);
    return p;
}

/* A random value now and then replaced by a hostile one. */
static float hostile(test_random *rnd)
{
    static const float values[] = {0.0f, 1e-45f, 1e-38f, 65504.0f, 3.4e38f};
    const uint64_t pick = test_random_u64(rnd) % 40;

    return pick < 5 ? values[pick] : (float)test_random_unit(rnd);
}

typedef struct rows {
    int width;
    double *turn, *sums;
    float *rgb;
} rows;

static rows make_rows(int width, bool wild, test_random *rnd)
{
    const size_t w = (size_t)width;
    rows r = {width, doubles(2 * w),
              doubles(ROWS * (w + 1) * IBL_ARC_LANES + GUARD),
              malloc(3 * w * ROWS * sizeof(float))};

    if (!r.rgb)
        exit(1);
    for (int i = 0; i < width; i++) {
        const double phi = 2.0 * pi * ((i + 0.5) / width - 0.5);
        r.turn[2 * i] = cos(phi);
        r.turn[2 * i + 1] = sin(phi);
    }
    for (size_t k = 0; k < 3 * w * ROWS; k++)
        r.rgb[k] = wild ? hostile(rnd) : (float)test_random_unit(rnd);
    return r;
}

static void free_rows(rows *r)
{
    free(r->turn);
    free(r->sums);
    free(r->rgb);
}

static void prefix_rows(const ibl_arc_dsp *dsp, const rows *r)
{
    for (int k = 0; k < ROWS; k++)
        dsp->prefix(r->rgb + 3 * (size_t)k * (size_t)r->width, r->width,
                    r->turn, 0.7 + k, 0.3 - 0.4 * k,
                    r->sums +
                        (size_t)k * ((size_t)r->width + 1) * IBL_ARC_LANES);
}

/* Record i of a row as the plain sum, and the sum of absolute terms. */
static void plain_record(const rows *r, int row, int i, double sum[],
                         double size[])
{
    const double level = 0.7 + row, rise = 0.3 - 0.4 * row;

    memset(sum, 0, IBL_ARC_LANES * sizeof *sum);
    memset(size, 0, IBL_ARC_LANES * sizeof *size);
    for (int c = 0; c < i; c++) {
        const double d[3] = {level * r->turn[2 * c], level * r->turn[2 * c + 1],
                             rise};
        for (int k = 0; k < IBL_ARC_LANES; k++) {
            const float *px = r->rgb + 3 * (row * r->width + c);
            const double term = d[k / 4] * (k % 4 < 3 ? px[k % 4] : 1.0);
            sum[k] += term;
            size[k] += fabs(term);
        }
    }
}

static void prefix(void)
{
    test_random rnd = {11};

    for (int isa = IBL_ISA_C; isa <= (int)ibl_isa_best(); isa++) {
        ibl_arc_dsp dsp;
        ibl_arc_dsp_init(&dsp, (ibl_isa)isa);
        for (int width = 1; width <= 70; width += width < 20 ? 1 : 7) {
            rows r = make_rows(width, width % 2, &rnd);
            const size_t used = ROWS * ((size_t)width + 1) * IBL_ARC_LANES;
            for (int k = 0; k < GUARD; k++)
                r.sums[used + (size_t)k] = 123.0;
            prefix_rows(&dsp, &r);
            for (int k = 0; k < GUARD; k++)
                CHECK(r.sums[used + (size_t)k] == 123.0);
            for (int row = 0; row < ROWS; row++) {
                for (int i = 0; i <= width; i++) {
                    double sum[IBL_ARC_LANES], size[IBL_ARC_LANES];
                    const double *got =
                        r.sums +
                        (size_t)(row * (width + 1) + i) * IBL_ARC_LANES;
                    plain_record(&r, row, i, sum, size);
                    for (int k = 0; k < IBL_ARC_LANES; k++)
                        CHECK_MSG(fabs(got[k] - sum[k]) <=
                                      (width + 3) * DBL_EPSILON * size[k],
                                  "%s width %d row %d record %d lane %d",
                                  ibl_isa_name((ibl_isa)isa), width, row, i, k);
                }
            }
            free_rows(&r);
        }
    }
}

/* Columns one by one against add, at centres and widths that meet no column's
 * centre, round the seam, none and all. */
static void add_once(const ibl_arc_dsp *dsp, const rows *r, double centre,
                     const double half[ROWS], const char *isa)
{
    double got[IBL_ARC_LANES], want[IBL_ARC_LANES], size[IBL_ARC_LANES];
    const ibl_arc_rows all = {r->sums, ROWS, r->width};

    for (int k = 0; k < IBL_ARC_LANES; k++)
        want[k] = got[k] = k, size[k] = 100.0;
    for (int row = 0; row < ROWS; row++) {
        const double *sums =
            r->sums + (size_t)row * ((size_t)r->width + 1) * IBL_ARC_LANES;
        for (int i = 0; i < r->width; i++) {
            double gap = fabs(i + 0.5 - centre);
            if (gap > 0.5 * r->width)
                gap = r->width - gap;
            for (int k = 0; k < IBL_ARC_LANES; k++) {
                const double *p = sums + (size_t)i * IBL_ARC_LANES + k;
                const double term = p[IBL_ARC_LANES] - p[0];
                want[k] += gap < half[row] ? term : 0.0;
                size[k] += fabs(p[0]) + fabs(term);
            }
        }
    }
    dsp->add(&all, centre, half, got);
    for (int k = 0; k < IBL_ARC_LANES; k++)
        CHECK_MSG(fabs(got[k] - want[k]) <= 8 * DBL_EPSILON * size[k],
                  "%s width %d centre %.17g half %.17g %.17g %.17g lane %d: "
                  "%.17g, not %.17g",
                  isa, r->width, centre, half[0], half[1], half[2], k, got[k],
                  want[k]);
}

static void add(void)
{
    test_random rnd = {12};

    for (int isa = IBL_ISA_C; isa <= (int)ibl_isa_best(); isa++) {
        const char *name = ibl_isa_name((ibl_isa)isa);
        ibl_arc_dsp dsp;
        ibl_arc_dsp_init(&dsp, (ibl_isa)isa);
        for (int width = 1; width <= 40; width++) {
            rows r = make_rows(width, false, &rnd);
            prefix_rows(&dsp, &r);
            for (int n = 0; n < 60; n++) {
                const double centre = width * test_random_unit(&rnd);
                double half[ROWS];
                for (int k = 0; k < ROWS; k++) {
                    const uint64_t pick = test_random_u64(&rnd) % 8;
                    half[k] = 0.5 * width * test_random_unit(&rnd);
                    if (pick == 0)
                        half[k] = INFINITY;
                    else if (pick == 1)
                        half[k] = 0.0;
                    else if (pick == 2)
                        half[k] = -1e-17;
                    else if (pick == 3)
                        half[k] *= 1e-3;
                }
                add_once(&dsp, &r, centre, half, name);
            }
            free_rows(&r);
        }
    }
}

/* An arc of half the row at any centre, its ends on columns' centres to the
 * last bit or beside them: reads stay inside, and at most the two columns at
 * the ends are in doubt. */
static void add_at_the_ends(void)
{
    test_random rnd = {13};

    for (int isa = IBL_ISA_C; isa <= (int)ibl_isa_best(); isa++) {
        ibl_arc_dsp dsp;
        ibl_arc_dsp_init(&dsp, (ibl_isa)isa);
        for (int width = 1; width <= 33; width++) {
            rows r = make_rows(width, false, &rnd);
            prefix_rows(&dsp, &r);
            const ibl_arc_rows one = {r.sums, 1, width};
            for (int n = 0; n < 4 * width; n++) {
                double centre = 0.25 * n, sum[IBL_ARC_LANES] = {0};
                const double half = 0.5 * width;
                if (n % 3 == 1)
                    centre = nextafter(centre, 1e9);
                else if (n % 3 == 2)
                    centre = nextafter(centre, 0.0);
                dsp.add(&one, centre, &half, sum);
                /* The lane that counts columns, in units of rise. */
                const double columns = sum[11] / 0.3;
                CHECK_NEAR(columns, width, 1.0 + 1e-9);
            }
            free_rows(&r);
        }
    }
}

static const test tests[] = {TEST(prefix), TEST(add), TEST(add_at_the_ends)};
TEST_MAIN(tests)
