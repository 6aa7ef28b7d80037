/* SPDX-License-Identifier: MIT */
#include <math.h>
#include <stdlib.h>

#include "bake/spectral/lights.h"
#include "test.h"

enum {
    WIDTH = 37, /* no multiple of anything that is looked at together */
    ROWS = 5,
    MOST = 64
};

static void fill(float *rgb, test_random *r, double most)
{
    for (int i = 0; i < 3 * WIDTH * ROWS; i++)
        rgb[i] = (float)(most * test_random_unit(r));
}

TEST(ranges)
{
    float rgb[3 * WIDTH * ROWS];
    test_random r = {1};
    ibl_row_range range;
    double sum[3] = {0};
    float low[3] = {1, 1, 1}, high[3] = {0};

    fill(rgb, &r, 1);
    for (int i = 0; i < 3 * WIDTH * ROWS; i++) {
        const int c = i % 3;
        low[c] = fminf(low[c], rgb[i]);
        high[c] = fmaxf(high[c], rgb[i]);
        sum[c] += (double)rgb[i];
    }
    ibl_row_range_of(rgb, WIDTH, ROWS, &range);
    for (int c = 0; c < 3; c++) {
        CHECK(range.low[c] == low[c] && range.high[c] == high[c]);
        CHECK_NEAR(range.mean[c], sum[c] / (WIDTH * ROWS), 1e-6);
    }
}

/* Equal pixels outshine nobody, however small they are. */
TEST(equal)
{
    float rgb[3 * WIDTH * ROWS];
    ibl_row_range range;
    for (int e = -149; e < 128; e++) {
        for (int i = 0; i < 3 * WIDTH * ROWS; i++)
            rgb[i] = ldexpf(1, e);
        ibl_row_range_of(rgb, WIDTH, ROWS, &range);
        CHECK(!ibl_lights_any(&range, WIDTH * ROWS, MOST));
        ibl_pixel_light lights[MOST];
        const int n =
            ibl_lights_take(rgb, WIDTH, ROWS, 0, &range, MOST, lights);
        CHECK(n == 0);
    }
}

TEST(taken)
{
    float rgb[3 * WIDTH * ROWS];
    ibl_pixel_light lights[MOST];
    test_random r = {2};
    ibl_row_range range;
    const int at = 2 * WIDTH + 11;

    fill(rgb, &r, 1);
    rgb[3 * at] = 1000;
    ibl_row_range_of(rgb, WIDTH, ROWS, &range);
    CHECK(ibl_lights_any(&range, WIDTH * ROWS, MOST));
    const float red = rgb[3 * at], green = rgb[3 * at + 1];
    NEED(ibl_lights_take(rgb, WIDTH, ROWS, 48, &range, MOST, lights) == 1);
    CHECK(lights[0].row == 50 && lights[0].column == 11);
    CHECK_NEAR(lights[0].rgb[0] + rgb[3 * at], red, 1e-4);
    CHECK_NEAR(lights[0].rgb[1] + rgb[3 * at + 1], green, 1e-6);
    CHECK(rgb[3 * at] < 1);
}
