/* SPDX-License-Identifier: MIT */
/* The table that directions to lights are drawn from. */
#include <math.h>
#include <stdlib.h>

#include "test.h"
#include "view/aim.h"

/* A cube of RGBA32F with all texels value. */
static bool make_cube(int edge, float value, ibl_texture *cube)
{
    const size_t texels = (size_t)6 * edge * edge;
    float *rgba = test_alloc(4 * texels, sizeof *rgba);

    *cube = (ibl_texture){.pixel = IBL_PIXEL_RGBA32F,
                          .width = edge,
                          .height = edge,
                          .levels = 1,
                          .layers = 1,
                          .faces = 6,
                          .bytes = 16 * texels,
                          .data = (unsigned char *)rgba};
    for (size_t i = 0; rgba && i < 4 * texels; ++i)
        rgba[i] = value;
    return rgba != NULL;
}

static void set_texel(ibl_texture *cube, int face, int x, int y, float value)
{
    const int edge = cube->width;
    float *rgba = (float *)(void *)cube->data;

    for (int c = 0; c < 3; ++c)
        rgba[4 * ((face * edge + y) * edge + x) + c] = value;
}

TEST(nothing_outshines)
{
    ibl_texture cube;
    view_aim aim;

    for (int edge = 1; edge < 40; edge += 13) {
        NEED(make_cube(edge, 0.7F, &cube));
        NEED(view_aim_make(&cube, &aim));
        CHECK(aim.edge == 0 && !aim.chance && !aim.tokens);
    }
    NEED(make_cube(8, 0.0F, &cube));
    NEED(view_aim_make(&cube, &aim));
    CHECK(aim.edge == 0);
}

/* Chances are the tokens' shares, and in proportion to light above the mean. */
TEST(chances)
{
    const int edge = 19;
    const size_t count = (size_t)6 * edge * edge;
    double *light = test_alloc(count, sizeof *light), all = 0.0, mean = 0.0;
    int *tokens = test_alloc(count, sizeof *tokens);
    test_random random = {3};
    ibl_texture cube;
    view_aim aim;

    NEED(light && tokens && make_cube(edge, 0.0F, &cube));
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
    NEED(view_aim_make(&cube, &aim));
    NEED(aim.edge == edge);
    for (int i = 0; i < VIEW_AIM_TOKENS; ++i)
        ++tokens[(int)aim.tokens[i]];
    for (size_t i = 0; i < count; ++i) {
        CHECK((double)aim.chance[i] * VIEW_AIM_TOKENS == tokens[i]);
        CHECK_NEAR(tokens[i], light[i] / all * VIEW_AIM_TOKENS, 1.01);
    }
    /* Of the first faces together there are the nearest whole number. */
    double before = 0.0;
    int given = 0;
    for (size_t i = 0; i < count; ++i) {
        before += light[i] / all * VIEW_AIM_TOKENS;
        given += tokens[i];
        if ((i + 1) % (count / 6) == 0)
            CHECK_NEAR(given, before, 0.55);
    }
    view_aim_free(&aim);
}

/* The cell of the direction, by looking at all. */
static size_t nearest_cell(int edge, const double d[3])
{
    double best = -2.0;
    size_t cell = 0;

    for (size_t i = 0; i < (size_t)6 * edge * edge; ++i) {
        double c[3];
        ibl_cube_direction(edge, (int)i / edge / edge, (int)i % edge,
                           (int)i / edge % edge, c);
        const double cosine = c[0] * d[0] + c[1] * d[1] + c[2] * d[2];
        if (cosine > best) {
            best = cosine;
            cell = i;
        }
    }
    return cell;
}

/* A light at a face's edge shines on the next one, which has half the draws. */
TEST(lights_on_edges)
{
    const int edge = 8;

    for (int face = 0; face < 6; ++face)
        for (int side = 0; side < 4; ++side)
            for (int k = 1; k < edge - 1; ++k) {
                const int x = side == 0 ? 0 : side == 1 ? edge - 1 : k;
                const int y = side == 2 ? 0 : side == 3 ? edge - 1 : k;
                const int in_x = side == 0 ? 1 : side == 1 ? edge - 2 : k;
                const int in_y = side == 2 ? 1 : side == 3 ? edge - 2 : k;
                double own[3], inner[3], next[3];
                ibl_texture cube;
                view_aim aim;
                NEED(make_cube(edge, 0.0F, &cube));
                set_texel(&cube, face, x, y, 1.0F);
                NEED(view_aim_make(&cube, &aim) && aim.edge == edge);
                ibl_cube_direction(edge, face, x, y, own);
                ibl_cube_direction(edge, face, in_x, in_y, inner);
                for (int c = 0; c < 3; ++c)
                    next[c] = 2.0 * own[c] - inner[c];
                const double length = sqrt(
                    next[0] * next[0] + next[1] * next[1] + next[2] * next[2]);
                for (int c = 0; c < 3; ++c)
                    next[c] /= length;
                const size_t at = nearest_cell(edge, next);
                CHECK((int)at / edge / edge != face);
                CHECK_NEAR(aim.chance[at], 0.5, 0.02);
                CHECK_NEAR(aim.chance[(face * edge + y) * edge + x], 0.5, 0.02);
                view_aim_free(&aim);
            }
}

/* More texels than cells: a light is where it was. */
TEST(large_cube)
{
    const int edge = 700, x = 333, y = 87;
    const size_t at =
        ((size_t)3 * VIEW_AIM_EDGE + (2 * y + 1) * VIEW_AIM_EDGE / (2 * edge)) *
            VIEW_AIM_EDGE +
        (2 * x + 1) * VIEW_AIM_EDGE / (2 * edge);
    ibl_texture cube;
    view_aim aim;

    NEED(make_cube(edge, 1.0F, &cube));
    set_texel(&cube, 3, x, y, 1e7F);
    NEED(view_aim_make(&cube, &aim));
    CHECK(aim.edge == VIEW_AIM_EDGE);
    CHECK_NEAR(aim.chance[at], 1.0, 1e-6);
    view_aim_free(&aim);
}

/* What no light can be is none. */
TEST(hostile_texels)
{
    static const float values[] = {INFINITY, -INFINITY, NAN, -1e30F};
    ibl_texture cube;
    view_aim aim;

    NEED(make_cube(16, 1.0F, &cube));
    for (int i = 0; i < 4; ++i)
        set_texel(&cube, i, 5, 5, values[i]);
    set_texel(&cube, 5, 3, 3, 1e6F);
    NEED(view_aim_make(&cube, &aim) && aim.edge == 16);
    CHECK_NEAR(aim.chance[(5 * 16 + 3) * 16 + 3], 1.0, 1e-6);
    view_aim_free(&aim);
}
