/* SPDX-License-Identifier: MIT */
#include "view/room_parts.h"

#include <math.h>
#include <string.h>

#include "view/program.h"
#include "view/sphere_grid.h"
#include "view/vector.h"

enum {
    EDGE = 2048 /* of the depth map; texels of 5 to 9 mm if a unit is 1 m */
};

/* Uniform block "Sun" (shaders/sun.glsl), std140. */
typedef struct sun_block {
    float clip[16];
    float direction[4], irradiance[4], right[4], up[4], limit[4];
} sun_block;

/* ---- view of the sun ---------------------------------------------------- */

/* Axes of the sun, and the box along them that holds the room. */
typedef struct shadow_view {
    double axes[3][3];         /* right, up, towards the sun: unit vectors */
    double centre[3], half[3]; /* centre and half size along them */
} shadow_view;

static void set_axes(const double direction[3], double axes[3][3])
{
    const bool steep = fabs(direction[1]) > 0.999;
    const double up[3] = {steep, !steep, 0};

    memcpy(axes[2], direction, sizeof axes[2]);
    cross3(up, direction, axes[0]);
    normalise3(axes[0]);
    cross3(direction, axes[0], axes[1]);
}

/* Walls, floor and ceiling fill a box; spheres stay inside it. */
static void fit_room(shadow_view *v)
{
    for (int i = 0; i < 3; i++) {
        v->centre[i] = dot3(v->axes[i], view_room_centre);
        v->half[i] = 0;
        for (int k = 0; k < 3; k++)
            v->half[i] +=
                fabs(v->axes[i][k]) * (view_room_half[k] + view_room_wall);
        v->half[i] *= 1 + 2.0 / EDGE;
    }
}

static shadow_view view_from(const view_room_sun *sun, double turn)
{
    double direction[3];
    shadow_view v;

    view_turn(-turn, sun->direction, direction);
    set_axes(direction, v.axes);
    fit_room(&v);
    return v;
}

/* ---- resources ---------------------------------------------------------- */

static void set_edge(const view_room_shadow *s, int edge)
{
    view_gl_bind(VIEW_ROOM_UNIT_SHADOW, GL_TEXTURE_2D, s->depth);
    gl.TexImage2D(GL_TEXTURE_2D, 0, GL_DEPTH_COMPONENT24, edge, edge, 0,
                  GL_DEPTH_COMPONENT, GL_UNSIGNED_INT, NULL);
}

/* One texel until a shadow is drawn. */
static void make_depth(view_room_shadow *s)
{
    gl.GenTextures(1, &s->depth);
    set_edge(s, 1);
    view_gl_filter(GL_TEXTURE_2D, GL_NEAREST, 1);
    gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_COMPARE_MODE,
                     GL_COMPARE_REF_TO_TEXTURE);
    gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_COMPARE_FUNC, GL_LEQUAL);
}

bool view_room_shadow_make(view_room_shadow *s)
{
    s->program = view_program("room_shadow.vert", "room_shadow.frag");
    make_depth(s);
    gl.GenFramebuffers(1, &s->framebuffer);
    s->buffer = view_gl_buffer(GL_UNIFORM_BUFFER, sizeof(sun_block), NULL);
    return s->program;
}

void view_room_shadow_free(view_room_shadow *s)
{
    gl.DeleteBuffers(1, &s->buffer);
    gl.DeleteFramebuffers(1, &s->framebuffer);
    gl.DeleteTextures(1, &s->depth);
    gl.DeleteProgram(s->program);
}

/* ---- uniforms and target ------------------------------------------------ */

static void fill_clip(float clip[16], const shadow_view *v)
{
    memset(clip, 0, 16 * sizeof *clip);
    clip[15] = 1;
    for (int i = 0; i < 3; i++) {
        /* Depth grows away from the sun. */
        const double scale = (i < 2 ? 1 : -1) / v->half[i];
        for (int k = 0; k < 3; k++)
            clip[4 * k + i] = (float)(scale * v->axes[i][k]);
        clip[12 + i] = (float)(-scale * v->centre[i]);
    }
}

static void fill_block(sun_block *b, const view_room_draw *d,
                       const shadow_view *v)
{
    const view_room_sun *sun = &d->environment.sun;

    fill_clip(b->clip, v);
    for (int k = 0; k < 3; k++) {
        b->direction[k] = (float)v->axes[2][k];
        b->irradiance[k] = (float)sun->irradiance[k];
        b->right[k] = (float)(v->axes[0][k] * 2 * v->half[0] / EDGE);
        b->up[k] = (float)(v->axes[1][k] * 2 * v->half[1] / EDGE);
    }
    b->direction[3] = d->shadows;
    b->irradiance[3] = 1;
    b->right[3] = EDGE;
    b->up[3] = (float)(0.5 / v->half[2]);
    b->limit[0] = (float)sun->limit;
    b->limit[1] = (float)sun->cosine;
    b->limit[2] = sun->apart;
    b->limit[3] = (float)sun->radius;
}

static void set_target(view_room_shadow *s)
{
    if (!s->made)
        set_edge(s, EDGE);
    s->made = true;
    gl.BindFramebuffer(GL_FRAMEBUFFER, s->framebuffer);
    gl.FramebufferTexture2D(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_TEXTURE_2D,
                            s->depth, 0);
    gl.DrawBuffer(GL_NONE);
    gl.ReadBuffer(GL_NONE);
    gl.Viewport(0, 0, EDGE, EDGE);
    gl.Clear(GL_DEPTH_BUFFER_BIT);
    gl.Enable(GL_DEPTH_TEST);
    gl.DepthFunc(GL_LESS);
    gl.Enable(GL_CULL_FACE);
    gl.FrontFace(GL_CCW);
}

GLuint view_room_shadow_use(view_room_shadow *s, const view_room_draw *d)
{
    const view_room_sun *sun = &d->environment.sun;
    double key[5] = {d->moving, d->moving ? d->seconds : 0};
    sun_block block = {0};

    view_gl_bind(VIEW_ROOM_UNIT_SHADOW, GL_TEXTURE_2D, s->depth);
    gl.BindBufferBase(GL_UNIFORM_BUFFER, VIEW_BLOCK_SUN, s->buffer);
    if (view_room_sun_shines(sun)) {
        const shadow_view v = view_from(sun, d->environment.turn);
        memcpy(key + 2, v.axes[2], sizeof v.axes[2]);
        fill_block(&block, d, &v);
    }
    gl.BufferSubData(GL_UNIFORM_BUFFER, 0, sizeof block, &block);
    if (!view_room_sun_shines(sun) || !d->shadows ||
        (s->made && !memcmp(key, s->key, sizeof key)))
        return 0;
    set_target(s);
    memcpy(s->key, key, sizeof key);
    return s->program;
}
