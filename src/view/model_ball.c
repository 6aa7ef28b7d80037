/* SPDX-License-Identifier: MIT */
/* The material ball, as if it had been read from a file. */
#include <math.h>
#include <stdlib.h>

#include "common/signals.h"
#include "view/message.h"
#include "view/model.h"

enum {
    ROWS = 48,
    COLUMNS = 2 * ROWS,
    ACROSS = COLUMNS + 1, /* the seam has two columns of vertices */
    VERTICES = (ROWS + 1) * ACROSS,
    WAVES = 20,  /* around the ball */
    HEIGHT = 256 /* of the normal map, which is twice as wide */
};

typedef struct ball {
    float position[VERTICES][3], texcoord[VERTICES][2];
    uint32_t index[ROWS * COLUMNS][6];
    unsigned char texels[HEIGHT][2 * HEIGHT][4];
} ball;

/* u goes around from the back, with +Z in its middle; v is down. */
static void put_vertex(ball *b, int row, int column)
{
    const double theta = M_PI * row / ROWS;
    const double phi = 2 * M_PI * column / COLUMNS - M_PI;
    const int i = row * ACROSS + column;

    b->position[i][0] = (float)(sin(theta) * sin(phi));
    b->position[i][1] = (float)cos(theta);
    b->position[i][2] = (float)(sin(theta) * cos(phi));
    b->texcoord[i][0] = (float)column / COLUMNS;
    b->texcoord[i][1] = (float)row / ROWS;
}

static void put_quad(ball *b, int row, int column)
{
    const uint32_t a = (uint32_t)(row * ACROSS + column), c = a + ACROSS;
    const uint32_t corners[6] = {a, c, a + 1, a + 1, c, c + 1};

    for (int i = 0; i < 6; i++)
        b->index[row * COLUMNS + column][i] = corners[i];
}

/* The normal of the height cos x cos y, in a belt around the equator. */
static void put_texel(ball *b, int row, int column)
{
    const double wave = 2 * M_PI * WAVES / (2.0 * HEIGHT);
    const double x = (column + 0.5) * wave, y = (row + 0.5) * wave;
    const double off = fabs(2 * (row + 0.5) / HEIGHT - 1);
    const double edge = fmin(fmax((0.35 - off) / 0.1, 0), 1);
    const double steep = 0.4 * edge * edge * (3 - 2 * edge);
    /* Green is against v. */
    const double n[3] = {steep * sin(x) * cos(y), -steep * cos(x) * sin(y), 1};
    const double length = sqrt(n[0] * n[0] + n[1] * n[1] + 1);

    for (int k = 0; k < 3; k++)
        b->texels[row][column][k] =
            (unsigned char)lrint(127.5 * (n[k] / length + 1));
    b->texels[row][column][3] = 255;
}

static void fill(ball *b)
{
    for (int row = 0; row <= ROWS; row++)
        for (int column = 0; column <= COLUMNS; column++)
            put_vertex(b, row, column);
    for (int row = 0; row < ROWS; row++)
        for (int column = 0; column < COLUMNS; column++)
            put_quad(b, row, column);
    for (int row = 0; row < HEIGHT; row++)
        for (int column = 0; column < 2 * HEIGHT; column++)
            put_texel(b, row, column);
}

static view_model *upload(ball *b)
{
    static const ibl_scene_texture none = {.image = -1};
    static char name[] = "material ball";
    ibl_scene_material material = {
        .name = name,
        .base_colour = {1, 1, 1, 1},
        .metallic = 1,
        .roughness = 1,
        .normal_scale = 1,
        .ior = 1.5F,
        .specular = 1,
        .specular_colour = {1, 1, 1},
        .base_colour_texture = none,
        .metallic_roughness_texture = none,
        .normal_texture = {.wrap_s = GL_REPEAT,
                           .wrap_t = GL_CLAMP_TO_EDGE,
                           .scale = {1, 1}},
        .occlusion_texture = none,
        .emissive_texture = none,
        .specular_texture = none,
        .specular_colour_texture = none,
    };
    ibl_scene_primitive primitive = {.vertex_count = VERTICES,
                                     .index_count = 6 * ROWS * COLUMNS,
                                     .position = b->position[0],
                                     .normal = b->position[0],
                                     .texcoord = {b->texcoord[0]},
                                     .index = b->index[0]};
    ibl_scene_draw draw = {.to_world = {[0] = 1, [5] = 1, [10] = 1, [15] = 1}};
    ibl_scene_image image = {.name = name,
                             .width = 2 * HEIGHT,
                             .height = HEIGHT,
                             .rgba = b->texels[0][0]};
    ibl_scene scene = {.primitives = &primitive,
                       .materials = &material,
                       .draws = &draw,
                       .images = &image,
                       .primitive_count = 1,
                       .material_count = 1,
                       .draw_count = 1,
                       .image_count = 1,
                       .bounds = {{-1, -1, -1}, {1, 1, 1}}};

    return view_model_create(NULL, &scene, name);
}

view_model *view_model_ball(void)
{
    ball *b = ibl_need(malloc(sizeof *b));

    fill(b);
    view_model *m = upload(b);
    free(b);
    return m;
}
