/* SPDX-License-Identifier: MIT */
#include "view/ground.h"

#include <math.h>
#include <string.h>

#include "view/gl.h"
#include "view/message.h"
#include "view/vector.h"

enum {
    EDGE = 1024 /* of the maps, which show the sphere that the model is in */
};

static const double radius = 2.5;

void view_ground_load(view_ground *g, const baked_set *set)
{
    const ibl_image *map =
        set->baked.light_count ? NULL : view_set_source(set, NULL);
    ibl_ctx *ctx = NULL;
    ibl_image copy;
    int count = set->baked.light_count;

    g->known = true;
    if (count)
        g->light = set->baked.light[0];
    if (map && !ibl_ctx_create(NULL, &ctx) &&
        !ibl_image_alloc(ctx, map->width, map->height, &copy)) {
        memcpy(copy.data, map->data,
               3 * (size_t)map->width * (size_t)map->height *
                   sizeof *copy.data);
        if (ibl_image_take_lights(ctx, &copy, set->baked.yaw_deg, 1, &g->light,
                                  &count))
            count = 0;
        ibl_image_free(&copy);
    }
    ibl_ctx_free(ctx);
    if (!count)
        g->light = (ibl_light){.radius = 0};
}

/* Orthographic from far away in a unit direction: column-major, from the world
 * to clip space. */
static void look_from(const double d[3], float clip[16])
{
    const double beside[3] = {fabs(d[0]) < 0.9, fabs(d[0]) >= 0.9, 0};
    double x[3], y[3];

    cross3(beside, d, x);
    normalise3(x);
    cross3(d, x, y);
    for (int k = 0; k < 4; k++) {
        clip[4 * k] = k < 3 ? (float)(x[k] / VIEW_GROUND_HALF) : 0;
        clip[4 * k + 1] = k < 3 ? (float)(y[k] / VIEW_GROUND_HALF) : 0;
        clip[4 * k + 2] = k < 3 ? (float)(-d[k] / VIEW_GROUND_HALF) : 0;
        clip[4 * k + 3] = k == 3;
    }
}

void view_ground_fill(const view_ground *g, const view_settings *s,
                      const baked_set *set, const view_model *model,
                      view_frame *f)
{
    /* Light that is in the maps alone is no part of these. */
    const bool in_all =
        s->parts == VIEW_PARTS_ALL || s->parts == VIEW_PARTS_DIFFUSE;
    double to[3];

    f->ground[0] = (float)view_model_floor(model);
    f->ground[1] = (float)radius;
    f->ground[2] = (float)tan(g->light.radius);
    view_turn(-s->turn, g->light.direction, to);
    if (to[1] <= 0 || (!in_all && !set->baked.light_count))
        return;
    for (int k = 0; k < 3; k++)
        f->ground_sun[k] = (float)(g->light.irradiance[k] * to[1] / M_PI);
    f->ground[3] = 1;
    look_from(to, f->ground_light);
}

static bool make(view_ground *g)
{
    gl.GenFramebuffers(1, &g->framebuffer);
    gl.GenTextures(2, g->depth);
    for (int i = 0; i < 2; i++) {
        view_gl_bind(VIEW_GROUND_UNIT + i, GL_TEXTURE_2D, g->depth[i]);
        gl.TexImage2D(GL_TEXTURE_2D, 0, GL_DEPTH_COMPONENT24, EDGE, EDGE, 0,
                      GL_DEPTH_COMPONENT, GL_FLOAT, NULL);
        view_gl_filter(GL_TEXTURE_2D, GL_NEAREST, 1);
    }
    return view_gl_check("the ground");
}

bool view_ground_draw(view_ground *g, const view_frame *f, view_model *model)
{
    static const double below[3] = {0, -1, 0};
    view_frame from = *f;
    bool ok = g->framebuffer || make(g);

    gl.BindFramebuffer(GL_FRAMEBUFFER, g->framebuffer);
    gl.DrawBuffer(GL_NONE);
    gl.Viewport(0, 0, EDGE, EDGE);
    for (int i = 0; i < 2 && ok; i++) {
        if (i)
            look_from(below, from.clip);
        else
            memcpy(from.clip, f->ground_light, sizeof from.clip);
        view_gl_block(VIEW_BLOCK_FRAME, &from, sizeof from);
        view_gl_bind(VIEW_GROUND_UNIT + i, GL_TEXTURE_2D, g->depth[i]);
        gl.FramebufferTexture2D(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT,
                                GL_TEXTURE_2D, g->depth[i], 0);
        ok = view_model_depth(model);
    }
    return ok;
}
