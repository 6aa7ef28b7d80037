/* SPDX-License-Identifier: MIT */
#include "view/scene_captures.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "common/signals.h"
#include "view/message.h"
#include "view/program.h"

enum {
    BOUNCES = 3, /* mirror captures in an update, each lit by the last */
    WHOLE = 0    /* `steps` of view_capture_update */
};

/* No sphere on that side comes so near to the mirror. */
const double view_scene_distance = 3.1;
static const double from_wall = 0.3; /* minimum for the camera */

static const double whole_room_far = 100; /* far plane of captures */
/* Margin of a whole-room influence beyond the walls. */
static const double beyond = 1;
/* Influence of the mirror's probe beside local probes. It comes before those
 * that leave out moving objects, but not before a set's. */
static const double near_half[3] = {1.5, 1.8, 1.5}, near_blend = 0.6;

struct view_scene {
    view_room *room;
    GLuint wires;          /* program of view_volumes_render */
    view_capture *capture; /* for all probes */
    view_cubes mirror;     /* two cubes, with moving objects */
    int shown;             /* index of the one to draw with */
    ibl_probe probe;       /* the mirror's, in the last draw */
    view_cubes locals;
    ibl_probe local[VIEW_MAX_LOCALS];
    int local_count;
    int due;  /* number of locals, from the end, to capture again */
    int seen; /* number of locals, from the start, that were captured */
    const view_probe_set *set; /* baked probes replace locals */
    view_settings made;        /* settings of the captures */
    view_scene_state now;      /* its draw is the one in progress */
    view_canvas canvas;
    bool fresh;  /* the captures match the settings */
    bool begun;  /* an update in several frames has begun */
    bool failed; /* the last update; no other one before a change */
    double begun_at;
};

/* ---- create and free --------------------------------------------------- */

static void drop_captures(view_scene *st)
{
    view_capture_free(st->capture);
    st->capture = NULL;
    view_cubes_free(&st->mirror);
    view_cubes_free(&st->locals);
    st->local_count = st->due = st->seen = 0;
    st->fresh = st->begun = false;
}

view_scene *view_scene_create(void)
{
    view_scene *st = ibl_need(calloc(1, sizeof *st));

    if ((st->room = view_room_create()))
        return st;
    view_scene_free(st);
    return NULL;
}

void view_scene_free(view_scene *st)
{
    if (!st)
        return;
    drop_captures(st);
    view_room_free(st->room);
    free(st);
}

void view_scene_use(view_scene *st, const view_probe_set *probes)
{
    st->set = probes;
    st->fresh = false;
}

/* Makes cubes for count local probes and places the probes. */
static bool make_locals(view_scene *st, int size, int count)
{
    GLint most = 0;

    gl.GetIntegerv(GL_MAX_ARRAY_TEXTURE_LAYERS, &most);
    if (IBL_FACES * count > most)
        return view_fail(
            "%d probes are %d layers of a texture, this OpenGL has "
            "%d: take %d probes",
            count, IBL_FACES * count, most, most / IBL_FACES);
    if (!view_cubes_make(&st->locals, size, count))
        return view_fail("%d local probes with faces of %d: this OpenGL has no "
                         "room for them: take fewer by --probes, or smaller "
                         "ones by --probe-size",
                         count, size);
    view_scene_place(st->local, count);
    st->local_count = count;
    return true;
}

static bool make_cubes(view_scene *st, int size, int count)
{
    return (view_cubes_make(&st->mirror, size, 2) ||
            view_fail("this OpenGL has no room for a probe with faces of %d",
                      size)) &&
           (!count || make_locals(st, size, count));
}

static bool make_captures(view_scene *st, const view_settings *s)
{
    const int locals = st->set ? 0 : s->probes;

    if (st->capture && locals == st->local_count &&
        s->probe_size == st->made.probe_size &&
        s->probe_capture == st->made.probe_capture &&
        s->probe_limit == st->made.probe_limit)
        return true;
    drop_captures(st);
    st->made = *s;
    st->capture = view_capture_create(s->probe_capture, s->probe_size);
    if (st->capture && make_cubes(st, s->probe_size, locals))
        return true;
    drop_captures(st);
    return false;
}

/* ---- the probe --------------------------------------------------------- */

/* The mirror's probe. It covers the room, and comes last unless asked
 * otherwise, while local probes are missing or where they leave holes. */
static ibl_probe mirror_probe(const view_scene *st)
{
    const view_probe_maps *l = &st->now.draw.locals;
    const bool whole = !l->count || st->seen < st->local_count || l->holes;
    ibl_probe p = {.has_proxy = 1,
                   .blend = whole ? 0 : near_blend,
                   .priority = st->made.mirror_priority,
                   .layer = st->shown};
    double radius;

    if (p.priority == VIEW_MIRROR_AUTO)
        p.priority = whole || st->set ? -1 : 1;
    view_room_sphere(VIEW_SCENE_MIRROR, 0, p.position, &radius);
    for (int k = 0; k < 3; k++) {
        p.proxy.centre[k] = view_room_centre[k];
        p.proxy.half[k] = view_room_half[k];
        p.influence.centre[k] = whole ? view_room_centre[k] : p.position[k];
        p.influence.half[k] = whole ? view_room_half[k] + beyond : near_half[k];
    }
    return p;
}

/* A limited capture ends a little behind the farthest corner of its box. It has
 * alpha 0 beyond, as where it sees the environment. */
static double far_plane(const view_scene *st, const ibl_probe *p)
{
    double sum = 0;

    if (!st->made.probe_limit)
        return whole_room_far;
    for (int k = 0; k < 3; k++) {
        const double away = fabs(p->position[k] - p->influence.centre[k]) +
                            p->influence.half[k];
        sum += away * away;
    }
    return 1.01 * sqrt(sum);
}

/* A capture of a probe into its layer. */
static view_capture_shot probe_shot(const view_scene *st, const ibl_probe *p,
                                    const view_cubes *to)
{
    view_capture_shot s = {.room = st->room,
                           .draw = st->now.draw,
                           .far = far_plane(st, p),
                           .to = to,
                           .layer = p->layer};
    view_room_draw *d = &s.draw;

    d->moving = false;
    d->widening = 0;
    d->map = false;
    d->bare = st->made.probe_limit;
    d->seconds = st->begun_at; /* the same for all steps of an update */
    d->shadows = st->made.capture_shadows;
    memcpy(d->eye, p->position, sizeof d->eye);
    return s;
}

/* A capture into the mirror's cube that is not drawn with. The mirror is
 * invisible from inside: surfaces have one side. */
static view_capture_shot mirror_shot(const view_scene *st, bool moving)
{
    ibl_probe p = mirror_probe(st);

    p.layer = !st->shown;
    view_capture_shot s = probe_shot(st, &p, &st->mirror);
    s.draw.moving = moving;
    s.timed = true;
    return s;
}

static view_capture_state capture_mirror(view_scene *st, bool moving, int steps)
{
    const view_capture_shot s = mirror_shot(st, moving);
    const view_capture_state state =
        view_capture_update(st->capture, &s, steps);

    if (state == VIEW_CAPTURE_DONE)
        st->shown = !st->shown;
    return state;
}

static view_probe_maps maps_of(const view_scene *st, const view_cubes *cubes,
                               const ibl_probe *probe, int count)
{
    const float last = (float)(ibl_default_levels(st->made.probe_size) - 1);

    return (view_probe_maps){.count = count,
                             .probe = probe,
                             .holes = st->made.probe_limit,
                             .specular = cubes->specular,
                             .irradiance = cubes->irradiance,
                             .lod_scale = last,
                             .last_level = last,
                             .irradiance_scale = 1};
}

static void use_mirror(view_scene *st)
{
    st->probe = mirror_probe(st);
    st->now.draw.dynamic = maps_of(st, &st->mirror, &st->probe, 1);
}

/* Lights the draw by the last complete captures. */
static void use_probes(view_scene *st)
{
    st->now.draw.locals = st->set
                              ? *view_probe_set_locals(st->set)
                              : maps_of(st, &st->locals, st->local, st->seen);
    use_mirror(st);
}

/* Draws with the mirror's new capture. */
static void show_update(view_scene *st)
{
    use_probes(st);
    st->begun = false;
    st->now.shown = st->begun_at;
    st->now.updates++;
    memcpy(st->now.ms, view_capture_times(st->capture), sizeof st->now.ms);
}

/* Captures local probes once each, lit by the mirror's bounces, without moving
 * objects: one a call if settings spread them. Afterwards, or with baked ones,
 * captures the mirror again. */
static bool capture_due(view_scene *st, const view_settings *s)
{
    use_mirror(st);
    for (int left = s->spread && st->due ? 1 : st->due; left; left--) {
        const int i = st->local_count - st->due;
        const view_capture_shot shot =
            probe_shot(st, &st->local[i], &st->locals);
        if (view_capture_update(st->capture, &shot, WHOLE) != VIEW_CAPTURE_DONE)
            return false;
        st->due--;
        if (st->seen <= i)
            st->seen = i + 1;
    }
    use_probes(st);
    if (st->due)
        return true;
    st->begun_at = st->now.draw.seconds;
    if (capture_mirror(st, true, WHOLE) != VIEW_CAPTURE_DONE)
        return false;
    show_update(st);
    return true;
}

/* The environment lights the first bounce, the mirror's probe the next ones. */
static bool capture_whole(view_scene *st, const view_settings *s)
{
    const bool has_others = st->local_count || st->set;
    bool ok = true;

    st->made = *s;
    st->begun_at = st->now.draw.seconds;
    st->begun = st->failed = st->fresh = false;
    st->due = st->local_count;
    for (int bounce = 0; bounce < BOUNCES && ok; bounce++) {
        ok = capture_mirror(st, !has_others, WHOLE) == VIEW_CAPTURE_DONE;
        use_mirror(st);
    }
    if (ok && has_others)
        ok = capture_due(st, s);
    else if (ok)
        show_update(st);
    st->fresh = ok;
    return ok;
}

/* Objects move when the time changes, also if it goes back. */
static bool is_due(const view_scene *st, const view_settings *s)
{
    const double now = s->seconds, shown = st->now.shown;

    return (now < st->begun_at || now - st->begun_at >= s->probe_interval) &&
           (now < shown || now > shown);
}

static bool refresh(view_scene *st, const view_settings *s)
{
    if (st->due)
        return capture_due(st, s);
    use_probes(st);
    if (st->failed || (!st->begun && !is_due(st, s)))
        return true;
    if (!st->begun)
        st->begun_at = s->seconds;
    st->begun = true;
    switch (capture_mirror(st, true, s->probe_faces)) {
    case VIEW_CAPTURE_BEGUN:
        break;
    case VIEW_CAPTURE_DONE:
        show_update(st);
        break;
    case VIEW_CAPTURE_FAILED:
        /* A retry would fail, with a message, in every frame. */
        st->failed = true;
        st->begun = false;
        view_note("the scene's probe stays as it is until it is asked for in "
                  "another way");
    }
    return true;
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

/* These settings change the light of captures. */
static bool is_stale(const view_scene *st, const view_settings *s)
{
    const view_settings *m = &st->made;

    return !st->fresh || m->turn < s->turn || m->turn > s->turn ||
           m->parallax != s->parallax || m->blend != s->blend ||
           m->walls != s->walls || m->capture_shadows != s->capture_shadows;
}

/* ---- volumes of probes --------------------------------------------------- */

enum {
    EDGES = 12,
    PARTS = 64 /* lines of a circle */
};

const float view_volumes_influence[3] = {0, 0.7f, 0.7f};
const float view_volumes_proxy[3] = {0.7f, 0, 0.7f};

bool view_volumes_render(GLuint *program, double ev, const ibl_volume *volume,
                         const float colour[3])
{
    const bool sphere = volume->shape == IBL_SHAPE_SPHERE;
    const double *c = volume->centre, *half = volume->half;
    const float scale = (float)exp2(-ev);

    if (!*program)
        *program = view_program("volume.vert", "volume.frag");
    if (!*program)
        return false;
    gl.Disable(GL_BLEND);
    gl.Enable(GL_DEPTH_TEST);
    gl.DepthFunc(GL_LEQUAL);
    gl.DepthMask(GL_FALSE);
    gl.VertexAttrib4f(1, (float)c[0], (float)c[1], (float)c[2],
                      sphere ? PARTS : 0);
    gl.VertexAttrib4f(2, (float)half[0], (float)half[sphere ? 0 : 1],
                      (float)half[sphere ? 0 : 2], 1);
    gl.VertexAttrib4f(3, scale * colour[0], scale * colour[1],
                      scale * colour[2], 1);
    view_gl_draw(*program, GL_LINES, 2 * (sphere ? 3 * PARTS : EDGES));
    gl.DepthMask(GL_TRUE);
    gl.DepthFunc(GL_LESS);
    gl.Disable(GL_DEPTH_TEST);
    return true;
}

/* Cuts a box to the room, where its wires are visible, and keeps them off the
 * proxies at the walls. */
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

/* Proxies first, so influences are drawn over them. */
static bool draw_volumes(view_scene *st, double ev)
{
    const view_probe_maps *l = &st->now.draw.locals;
    bool ok = true;

    for (int i = 0; i <= l->count && st->now.draw.parallax && ok; i++) {
        const ibl_probe *p = i < l->count ? &l->probe[i] : &st->probe;
        ok = !p->has_proxy ||
             view_volumes_render(&st->wires, ev, &p->proxy, view_volumes_proxy);
    }
    for (int i = 0; i <= l->count && ok; i++) {
        ibl_volume v = (i < l->count ? &l->probe[i] : &st->probe)->influence;
        if (v.shape == IBL_SHAPE_BOX)
            clip_to_room(&v);
        ok = view_volumes_render(&st->wires, ev, &v, view_volumes_influence);
    }
    return ok;
}

bool view_scene_draw(view_scene *st, const view_settings *s,
                     const view_room_environment *environment, GLuint table,
                     GLuint framebuffer, int width, int height)
{
    if (!make_captures(st, s))
        return false;
    st->now.draw = (view_room_draw){.seconds = s->seconds,
                                    .moving = true,
                                    .shadows = true,
                                    .environment = *environment,
                                    .table = table,
                                    .parallax = s->parallax,
                                    .walls = s->walls,
                                    .sharp = !s->blend};
    st->now.draw.environment.turn = s->turn;
    const view_camera camera = view_scene_camera(s, width, height);
    view_camera_matrix(&camera, st->now.draw.clip);
    memcpy(st->now.draw.eye, camera.eye, sizeof camera.eye);
    if (!(is_stale(st, s) ? capture_whole : refresh)(st, s))
        return false;
    if (!view_canvas_begin(&st->canvas, width, height, s->multisample))
        return false;
    st->now.draw.widening = view_widening(s);
    st->now.draw.map = environment->map;
    view_room_render(st->room, &st->now.draw);
    if (s->volumes && !draw_volumes(st, s->ev))
        return false;
    view_canvas_end(&st->canvas, framebuffer);
    return view_gl_check("drawing the scene");
}

/* ---- state --------------------------------------------------- */

const view_scene_state *view_scene_state_of(const view_scene *st)
{
    return &st->now;
}
