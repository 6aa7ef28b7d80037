/* SPDX-License-Identifier: MIT */
#include "lit_room.h"

#include <math.h>

#include "view.h"

lit_room lit;

static void sky_texel(void *cookie, const double direction[3], float rgba[4])
{
    (void)cookie;
    for (int k = 0; k < 3; k++)
        rgba[k] = (float)(0.5 + 0.5 * direction[k]);
    rgba[3] = 1;
}

bool lit_begin(int width, int height)
{
    if (!view_test_begin(width, height))
        return false;
    lit.room = view_room_create();
    room_target_make(&lit.target, width, height);
    lit.white = room_cube_of(1, 1, 1, 1);
    lit.black = room_cube_of(0, 0, 0, 1);
    lit.sky = room_cube(64, sky_texel, NULL);
    lit.table = room_table_of(1, 0);
    return CHECK(lit.room);
}

void lit_end(void)
{
    const GLuint maps[] = {lit.white, lit.black, lit.sky, lit.table};

    CHECK(view_gl_check("drawing the room"));
    gl.DeleteTextures(4, maps);
    room_target_free(&lit.target);
    view_room_free(lit.room);
    view_test_end();
}

view_room_draw lit_draw(const view_camera *camera)
{
    view_room_draw d = room_draw_by(camera);

    d.environment.specular = d.environment.irradiance = lit.white;
    d.environment.sky = lit.sky;
    d.table = lit.table;
    return d;
}

float *lit_render(const view_room_draw *draw)
{
    room_target_bind(&lit.target);
    view_room_render(lit.room, draw);
    return room_target_read(&lit.target);
}

static void material_colour(const room_hit *hit, double rgb[3])
{
    for (int k = 0; k < 3; k++) {
        if (hit->what < 0) {
            rgb[k] = 0.5 + 0.5 * hit->sky[k];
            continue;
        }
        const double f0 = (double)hit->material->f0[k];
        rgb[k] = f0 + (1 - f0) * (double)hit->material->albedo[k] +
                 (double)hit->material->emission[k];
    }
}

bool lit_has_colour(const float *pixel, const room_hit *hit, double tolerance)
{
    double rgb[3], most = 0;

    material_colour(hit, rgb);
    for (int k = 0; k < 3; k++)
        most = fmax(most, fabs((double)pixel[k] - rgb[k]) / (1 + rgb[k]));
    return most < (hit->what < 0 ? fmax(tolerance, 1e-3) : tolerance);
}
