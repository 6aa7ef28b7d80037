/* SPDX-License-Identifier: MIT */
#include "view/scene_parts.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "view/message.h"

/* Nearer than any sphere comes to the mirror on that side. */
const double view_scene_distance = 3.1;
static const double from_wall = 0.3; /* that the camera stays away */

/* ---- what is kept ------------------------------------------------------ */

view_scene *view_scene_create(void)
{
    view_scene *st = calloc(1, sizeof *st);

    if (!st) {
        view_fail("not enough memory for the scene");
        return NULL;
    }
    st->room = view_room_create();
    if (!st->room) {
        view_scene_free(st);
        return NULL;
    }
    gl.GenFramebuffers(1, &st->framebuffer);
    return st;
}

void view_scene_free(view_scene *st)
{
    if (!st)
        return;
    view_scene_drop_captures(st);
    ibl_ctx_free(st->ctx);
    view_volumes_free(st->volumes);
    view_room_free(st->room);
    gl.DeleteFramebuffers(1, &st->framebuffer);
    gl.DeleteTextures(1, &st->depth);
    free(st);
}

void view_scene_use(view_scene *st, const view_probe_set *probes)
{
    st->set = probes;
    st->fresh = false;
}

void view_scene_restart(view_scene *st)
{
    st->fresh = false;
}

static bool resize(view_scene *st, int width, int height)
{
    if (st->depth && width == st->width && height == st->height)
        return true;
    gl.DeleteTextures(1, &st->depth);
    gl.GenTextures(1, &st->depth);
    view_gl_bind(0, GL_TEXTURE_2D, st->depth);
    gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAX_LEVEL, 0);
    gl.TexImage2D(GL_TEXTURE_2D, 0, GL_DEPTH_COMPONENT24, width, height, 0,
                  GL_DEPTH_COMPONENT, GL_UNSIGNED_INT, NULL);
    st->width = width;
    st->height = height;
    return view_gl_check("making the scene's depth");
}

/* ---- frames ------------------------------------------------------------ */

view_camera view_scene_camera(const view_settings *s, int width, int height)
{
    view_settings about = *s;
    double middle[3], radius;

    if (about.distance <= 0)
        about.distance = view_scene_distance;
    view_camera c = view_camera_of(&about, width, height);
    view_room_sphere(VIEW_SCENE_MIRROR, 0, middle, &radius);
    for (int k = 0; k < 3; k++) {
        const double most = view_room_half[k] - from_wall;
        c.eye[k] = fmin(fmax(c.eye[k] + middle[k], view_room_centre[k] - most),
                        view_room_centre[k] + most);
    }
    c.near = 0.05;
    c.far = 40;
    return c;
}

/* Light that bounces is another with these, and what lights too. */
static bool is_stale(const view_scene *st, const view_settings *s)
{
    const view_room_draw *d = &st->draw;

    return !st->fresh || d->environment.turn < s->turn ||
           d->environment.turn > s->turn || d->parallax != s->parallax ||
           d->sharp == s->blend || st->sun != s->sun ||
           st->capture_shadows != s->capture_shadows;
}

static void look(view_scene *st, const view_settings *s, int width, int height)
{
    const view_camera c = view_scene_camera(s, width, height);

    view_camera_matrix(&c, st->draw.clip);
    memcpy(st->draw.eye, c.eye, sizeof c.eye);
}

/* What of a box is in the room, a little away from the walls, where proxies
 * are: of what is beyond them no wire would be seen. */
static void clip_to_room(ibl_volume *box)
{
    const double inset = 0.03;

    for (int k = 0; k < 3; k++) {
        const double wall = view_room_half[k] - inset;
        const double low =
            fmax(box->centre[k] - box->half[k], view_room_centre[k] - wall);
        const double high =
            fmin(box->centre[k] + box->half[k], view_room_centre[k] + wall);
        box->centre[k] = 0.5 * (low + high);
        box->half[k] = 0.5 * fmax(high - low, 0);
    }
}

static void add_volumes(view_scene *st, int i, const ibl_probe *p)
{
    st->wired[i] = *p;
    st->wired[i].has_proxy = p->has_proxy && st->draw.parallax;
    if (p->influence.shape == IBL_SHAPE_BOX)
        clip_to_room(&st->wired[i].influence);
}

static bool draw_volumes(view_scene *st, double ev)
{
    const view_room_locals *l = &st->draw.locals;
    view_volumes_draw d = {.ev = ev, .count = l->count + 1, .probe = st->wired};

    if (!st->volumes && !(st->volumes = view_volumes_create()))
        return false;
    for (int i = 0; i < l->count; i++)
        add_volumes(st, i, &l->probe[i]);
    add_volumes(st, l->count, &st->draw.dynamic.probe);
    memcpy(d.clip, st->draw.clip, sizeof d.clip);
    memcpy(d.eye, st->draw.eye, sizeof d.eye);
    view_volumes_render(st->volumes, &d);
    return true;
}

bool view_scene_draw(view_scene *st, const view_settings *s,
                     const view_room_environment *environment, GLuint table,
                     GLuint picture, int width, int height)
{
    double position[3], radius;

    if (!resize(st, width, height) || !view_scene_make_captures(st, s))
        return false;
    const bool stale = is_stale(st, s);
    st->draw = (view_room_draw){.seconds = s->seconds,
                                .moving = true,
                                .shadows = true,
                                .environment = *environment,
                                .table = table,
                                .parallax = s->parallax,
                                .sharp = !s->blend};
    st->draw.environment.turn = s->turn;
    if (!s->sun)
        st->draw.environment.sun = (view_room_sun){0};
    st->sun = s->sun;
    st->capture_shadows = s->capture_shadows;
    look(st, s, width, height);
    view_room_sphere(VIEW_SCENE_MIRROR, s->seconds, position, &radius);
    if (!(stale ? view_scene_capture_whole : view_scene_refresh)(st, s,
                                                                 position))
        return false;
    gl.BindFramebuffer(GL_FRAMEBUFFER, st->framebuffer);
    gl.FramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D,
                            picture, 0);
    gl.FramebufferTexture2D(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_TEXTURE_2D,
                            st->depth, 0);
    gl.Viewport(0, 0, width, height);
    view_room_render(st->room, &st->draw);
    if (s->volumes && !draw_volumes(st, s->ev))
        return false;
    return view_gl_check("drawing the scene");
}

const view_room_draw *view_scene_drawn(const view_scene *st)
{
    return &st->draw;
}
