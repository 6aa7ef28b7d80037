/* SPDX-License-Identifier: MIT */
#include "view/scene_locals.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "view/message.h"
#include "view/settings.h"

_Static_assert(VIEW_MAX_LOCALS == IBL_MAX_TILE_PROBES,
               "as many as tiles have bits");

static const double height = 1.5;
/* From what a probe would be in. */
static const double clearance = 0.25;
/* That influence goes beyond the walls, besides the blend width. */
static const double beyond = 0.25;
/* The blend width, of the shortest side of a cell. It is the same for all, so
 * neighbours sum to at least 1. */
static const double blend_part = 0.4;

struct view_scene_locals {
    view_capture *capture;
    GLuint specular, irradiance, source, target;
    int count;
    ibl_probe probe[VIEW_MAX_LOCALS];
};

/* ---- where they are ---------------------------------------------------- */

static bool is_in(const double point[3], const double low[3],
                  const double high[3])
{
    for (int k = 0; k < 3; k++)
        if (point[k] <= low[k] - clearance || point[k] >= high[k] + clearance)
            return false;
    return true;
}

/* To the nearest side, of equally near ones towards the middle. */
static void move_out(double point[3], const double low[3], const double high[3])
{
    double least = INFINITY, best = 0;
    int axis = 0;

    if (!is_in(point, low, high))
        return;
    for (int side = 0; side < 4; side++) {
        const int k = side < 2 ? 0 : 2;
        const double to = side % 2 ? high[k] + clearance : low[k] - clearance;
        const double cost = fabs(to - point[k]) + 1e-3 * fabs(to);
        if (cost < least) {
            least = cost;
            best = to;
            axis = k;
        }
    }
    point[axis] = best;
}

static void move_out_of_all(double point[3])
{
    double low[3], high[3], radius;

    for (int i = 0; i < view_room_boxes(); i++)
        move_out(point, view_room_box_at(i)->low, view_room_box_at(i)->high);
    view_room_sphere(0, 0, low, &radius);
    for (int k = 0; k < 3; k++) {
        high[k] = low[k] + radius;
        low[k] -= radius;
    }
    move_out(point, low, high);
}

/* One side of an influence: the wall's reaches beyond it. */
static double reach(double border, double outwards, double wall, double blend)
{
    const bool last = fabs(border - wall) < 1e-6;

    return border + outwards * (last ? blend + beyond : blend / 2);
}

/* Of the cell from low to high of the floor, x and z. */
static void place(ibl_probe *p, const double low[2], const double high[2],
                  double blend)
{
    const double *c = view_room_centre, *h = view_room_half;

    *p = (ibl_probe){.has_proxy = 1, .blend = blend};
    for (int k = 0; k < 3; k++) {
        const double wall[2] = {c[k] - h[k], c[k] + h[k]};
        const double from = k == 1 ? wall[0] : low[k / 2];
        const double to = k == 1 ? wall[1] : high[k / 2];
        const double first = reach(from, -1, wall[0], p->blend);
        const double last = reach(to, 1, wall[1], p->blend);
        p->position[k] = k == 1 ? height : (from + to) / 2;
        p->influence.centre[k] = (first + last) / 2;
        p->influence.half[k] = (last - first) / 2;
        p->proxy.centre[k] = c[k];
        p->proxy.half[k] = h[k];
    }
    move_out_of_all(p->position);
}

static double between(int k, int part, int parts)
{
    return view_room_centre[k] + view_room_half[k] * (2.0 * part / parts - 1);
}

void view_scene_place(ibl_probe *probes, int count)
{
    const int rows = (int)lround(sqrt(count));
    const int columns = (count + rows - 1) / rows; /* at most */
    const double blend =
        2 * blend_part *
        fmin(view_room_half[0] / columns, view_room_half[2] / rows);
    ibl_probe placed[VIEW_MAX_LOCALS];
    int order[VIEW_MAX_LOCALS];

    for (int row = 0; row < rows; row++) {
        const int first = count * row / rows, end = count * (row + 1) / rows;
        for (int i = first; i < end; i++) {
            const double low[2] = {between(0, i - first, end - first),
                                   between(2, row, rows)};
            const double high[2] = {between(0, i - first + 1, end - first),
                                    between(2, row + 1, rows)};
            place(&placed[i], low, high, blend);
        }
    }
    ibl_probes_order(placed, count, order);
    for (int i = 0; i < count; i++) {
        probes[i] = placed[order[i]];
        probes[i].layer = i;
    }
}

/* ---- what is kept ------------------------------------------------------ */

/* After the largest level: whether it was made. */
static bool has_room(int size, int count)
{
    return gl.GetError() == GL_NO_ERROR ||
           view_fail("%d local probes with faces of %d: this OpenGL has no "
                     "room for them: take fewer by --probes, or smaller ones "
                     "by --probe-size",
                     count, size);
}

/* 0, with a message, if there is no room for it. */
static GLuint make_array(int size, int levels, int count)
{
    const GLenum target = GL_TEXTURE_CUBE_MAP_ARRAY;
    GLuint array;

    gl.GenTextures(1, &array);
    view_gl_bind(0, target, array);
    for (int l = 0; l < levels; l++) {
        const int n = ibl_cube_edge(size, l);
        gl.TexImage3D(target, l, GL_RGBA16F, n, n, IBL_FACES * count, 0,
                      GL_RGBA, GL_FLOAT, NULL);
        if (l == 0 && !has_room(size, count)) {
            gl.DeleteTextures(1, &array);
            return 0;
        }
    }
    view_gl_filter(target, GL_LINEAR, levels);
    return array;
}

static bool fits(int count)
{
    GLint most = 0;

    gl.GetIntegerv(GL_MAX_ARRAY_TEXTURE_LAYERS, &most);
    return IBL_FACES * count <= most ||
           view_fail("%d probes are %d layers of a texture, this OpenGL has "
                     "%d: take %d probes",
                     count, IBL_FACES * count, most, most / IBL_FACES);
}

view_scene_locals *view_scene_locals_create(const view_capture_options *options,
                                            int count)
{
    view_scene_locals *l = calloc(1, sizeof *l);

    if (!l) {
        view_fail("no memory for %d probes", count);
        return NULL;
    }
    l->count = count;
    view_scene_place(l->probe, count);
    if (!fits(count) || !(l->capture = view_capture_create(options)))
        goto fail;
    l->specular =
        make_array(options->size, view_capture_levels(l->capture), count);
    if (l->specular)
        l->irradiance = make_array(VIEW_CAPTURE_IRRADIANCE, 1, count);
    if (!l->irradiance)
        goto fail;
    gl.GenFramebuffers(1, &l->source);
    gl.GenFramebuffers(1, &l->target);
    if (!view_gl_check("the cubes of local probes"))
        goto fail;
    return l;

fail:
    view_scene_locals_free(l);
    return NULL;
}

void view_scene_locals_free(view_scene_locals *l)
{
    if (!l)
        return;
    gl.DeleteFramebuffers(1, &l->target);
    gl.DeleteFramebuffers(1, &l->source);
    gl.DeleteTextures(1, &l->irradiance);
    gl.DeleteTextures(1, &l->specular);
    view_capture_free(l->capture);
    free(l);
}

view_room_locals view_scene_locals_drawn(const view_scene_locals *l)
{
    const float last = (float)(view_capture_levels(l->capture) - 1);

    return (view_room_locals){.count = l->count,
                              .probe = l->probe,
                              .specular = l->specular,
                              .irradiance = l->irradiance,
                              .lod_scale = last,
                              .last_level = last,
                              .irradiance_scale = 1};
}

/* ---- captures ---------------------------------------------------------- */

/* A level of a cube into its layer, all faces; framebuffers are bound. */
static void copy(GLuint cube, GLuint array, int layer, int level, int n)
{
    for (int f = 0; f < IBL_FACES; f++) {
        gl.FramebufferTexture2D(GL_READ_FRAMEBUFFER, GL_COLOR_ATTACHMENT0,
                                view_gl_face(f), cube, level);
        gl.FramebufferTextureLayer(GL_DRAW_FRAMEBUFFER, GL_COLOR_ATTACHMENT0,
                                   array, level, IBL_FACES * layer + f);
        view_gl_copy(n);
    }
}

static void copy_all(const view_scene_locals *l, int layer)
{
    const GLuint specular = view_capture_specular(l->capture);

    gl.BindFramebuffer(GL_READ_FRAMEBUFFER, l->source);
    gl.BindFramebuffer(GL_DRAW_FRAMEBUFFER, l->target);
    for (int level = 0; level < view_capture_levels(l->capture); level++)
        copy(specular, l->specular, layer, level,
             ibl_cube_edge(view_capture_size(l->capture), level));
    copy(view_capture_irradiance(l->capture), l->irradiance, layer, 0,
         VIEW_CAPTURE_IRRADIANCE);
}

bool view_scene_locals_capture(view_scene_locals *l, int i, double far,
                               view_capture_scene *scene, void *cookie)
{
    view_capture_set_far(l->capture, far);
    if (!view_capture_update(l->capture, l->probe[i].position, scene, cookie))
        return false;
    copy_all(l, l->probe[i].layer);
    return view_gl_check("capturing local probes");
}

bool view_scene_locals_face(void *locals, int probe, int face, uint16_t *rgba)
{
    const view_scene_locals *l = locals;
    const int n = view_capture_size(l->capture);

    gl.BindFramebuffer(GL_READ_FRAMEBUFFER, l->source);
    gl.FramebufferTextureLayer(GL_READ_FRAMEBUFFER, GL_COLOR_ATTACHMENT0,
                               l->specular, 0,
                               IBL_FACES * l->probe[probe].layer + face);
    gl.PixelStorei(GL_PACK_ALIGNMENT, 4);
    gl.ReadPixels(0, 0, n, n, GL_RGBA, GL_HALF_FLOAT, rgba);
    return view_gl_check("reading a local probe");
}
