/* SPDX-License-Identifier: MIT */
/* The table that directions to lights are drawn from. */
#include <math.h>

#include "test.h"
#include "view/aim.h"

/* A cube of RGBA32F with all texels value. */
static ibl_texture make_cube(int edge, float value)
{
    const size_t floats = (size_t)24 * edge * edge;
    float *rgba = test_alloc(floats, sizeof *rgba);

    for (size_t i = 0; i < floats; ++i)
        rgba[i] = value;
    return (ibl_texture){.pixel = IBL_PIXEL_RGBA32F,
                         .width = edge,
                         .height = edge,
                         .levels = 1,
                         .layers = 1,
                         .faces = 6,
                         .bytes = 4 * floats,
                         .data = (unsigned char *)rgba};
}

/* Returns the texel's place among all. */
static size_t set_texel(ibl_texture *cube, int face, int x, int y, float value)
{
    const int edge = cube->width;
    const size_t at = ((size_t)face * edge + y) * edge + x;

    for (int c = 0; c < 3; ++c)
        ((float *)(void *)cube->data)[4 * at + c] = value;
    return at;
}

/* Chances are the tokens' shares, and in proportion to light above the mean. */
TEST(chances)
{
    const int edge = 19;
    const size_t count = (size_t)6 * edge * edge;
    double *light = test_alloc(count, sizeof *light), all = 0.0, mean = 0.0;
    int *tokens = test_alloc(count, sizeof *tokens);
    test_random random = {3};
    ibl_texture cube = make_cube(edge, 0.0F);
    view_aim aim;

    for (size_t i = 0; i < count; ++i) {
        const int x = (int)i % edge, y = (int)i / edge % edge;
        const bool inner = x && y && x < edge - 1 && y < edge - 1;
        /* Rows at the edges of faces all alike: their cells are the means
           with the next face's. */
        light[i] = inner ? pow(test_random_unit(&random), 4.0) : 0.01;
        set_texel(&cube, (int)i / edge / edge, x, y, (float)light[i]);
        mean +=
            light[i] * ibl_cube_solid_angle(edge, x, y) / (4.0 * acos(-1.0));
    }
    for (size_t i = 0; i < count; ++i) {
        light[i] =
            fmax(light[i] - mean, 0.0) *
            ibl_cube_solid_angle(edge, (int)i % edge, (int)i / edge % edge);
        all += light[i];
    }
    view_aim_make(&cube, &aim);
    NEED(aim.edge == edge);
    for (int i = 0; i < VIEW_AIM_TOKENS; ++i)
        ++tokens[(int)aim.tokens[i]];
    /* Of the first faces together there are the nearest whole number. */
    double before = 0.0;
    int given = 0;
    for (size_t i = 0; i < count; ++i) {
        CHECK((double)aim.chance[i] * VIEW_AIM_TOKENS == tokens[i]);
        CHECK_NEAR(tokens[i], light[i] / all * VIEW_AIM_TOKENS, 1.01);
        before += light[i] / all * VIEW_AIM_TOKENS;
        given += tokens[i];
        if ((i + 1) % (count / 6) == 0)
            CHECK_NEAR(given, before, 0.55);
    }
    view_aim_free(&aim);
}

/* A light at a face's edge has half the draws, the cell beside it on the next
 * face the others. */
TEST(lights_on_edges)
{
    const int edge = 8, last = edge - 1;

    for (int face = 0; face < 6; ++face)
        for (int i = 0; i < 4; ++i) {
            const int x = i < 2 ? i * last : 3, y = i < 2 ? 3 : i % 2 * last;
            ibl_texture cube = make_cube(edge, 0.0F);
            const size_t at = set_texel(&cube, face, x, y, 1.0F);
            double own[3], other[3];
            size_t next = 0;
            view_aim aim;
            view_aim_make(&cube, &aim);
            NEED(aim.edge == edge);
            while (next < 383 && (next == at || aim.chance[next] <= 0.0F))
                ++next;
            const int k = (int)next;
            ibl_cube_direction(edge, face, x, y, own);
            ibl_cube_direction(edge, k / 64, k % 8, k / 8 % 8, other);
            CHECK(k / 64 != face && test_dot(own, other) > 0.96);
            CHECK_NEAR(aim.chance[next], 0.5, 0.02);
            CHECK_NEAR(aim.chance[at], 0.5, 0.02);
            view_aim_free(&aim);
        }
}

/* Of more texels than cells a light is where it was; what no light can be is
 * none; where nothing outshines the rest there is no table. */
TEST(one_light)
{
    static const float values[] = {INFINITY, -INFINITY, NAN, -1e30F, 0, 1};
    const int edge = 700, x = 333, y = 87, n = VIEW_AIM_EDGE;
    ibl_texture cube = make_cube(edge, 1.0F);
    view_aim aim;

    for (int i = 0; i < 4; ++i)
        set_texel(&cube, i, 5, 5, values[i]);
    set_texel(&cube, 3, x, y, 1e7F);
    view_aim_make(&cube, &aim);
    NEED(aim.edge == n);
    const int row = 3 * n + (2 * y + 1) * n / (2 * edge);
    CHECK_NEAR(aim.chance[row * n + (2 * x + 1) * n / (2 * edge)], 1.0, 1e-6);
    view_aim_free(&aim);
    for (int i = 4; i < 6; ++i) {
        cube = make_cube(14, values[i]);
        view_aim_make(&cube, &aim);
        CHECK(aim.edge == 0 && !aim.chance && !aim.tokens);
    }
}
