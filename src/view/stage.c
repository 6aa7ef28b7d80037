/* SPDX-License-Identifier: MIT */
#include "view/stage.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "view/message.h"

enum {
    MIRROR = 0,  /* sphere that the probe is in */
    BOUNCES = 3, /* captures of a whole update, each lit by the one before */
    ALL = 1 << 20
};

/* Nearer than any sphere comes to the mirror on that side. */
const double view_stage_distance = 3.1;
static const double from_wall = 0.3; /* that the camera stays away */
/* The probe is for all of the room: its box goes a little beyond the walls. */
static const double beyond = 1;
/* Local probes, beside the mirror and not in it. */
static const double places[VIEW_STAGE_LOCAL][3] = {
    {-2.5, 1.5, 0.4}, {2.5, 1.5, -0.6}, {-0.3, 1.5, 3.4}};
/* From beneath the floor to above the ceiling, so that both have them. */
static const double local_half[3] = {1.8, 4, 1.8};

struct view_stage {
    view_room *room;
    view_capture *capture; /* in the mirror, of what moves too */
    view_capture *local[VIEW_STAGE_LOCAL];
    int locals;
    ibl_ctx *ctx;              /* made when the library is to filter */
    view_capture_options made; /* what capture was made by */
    view_room_draw draw;       /* of the frame that is being made */
    GLuint framebuffer, depth;
    int width, height; /* of depth */
    bool fresh;        /* a whole update was made, and nothing is another */
    bool begun;        /* an update that is spread over frames */
    double begun_at, shown_at;
};

/* ---- what is kept ------------------------------------------------------ */

view_stage *view_stage_create(void)
{
    view_stage *st = calloc(1, sizeof *st);

    if (!st) {
        view_fail("not enough memory for the scene");
        return NULL;
    }
    st->room = view_room_create();
    if (!st->room) {
        view_stage_free(st);
        return NULL;
    }
    gl.GenFramebuffers(1, &st->framebuffer);
    return st;
}

static void drop_captures(view_stage *st)
{
    view_capture_free(st->capture);
    st->capture = NULL;
    for (int i = 0; i < VIEW_STAGE_LOCAL; i++) {
        view_capture_free(st->local[i]);
        st->local[i] = NULL;
    }
    st->locals = 0;
    st->fresh = st->begun = false;
}

void view_stage_free(view_stage *st)
{
    if (!st)
        return;
    drop_captures(st);
    ibl_ctx_free(st->ctx);
    view_room_free(st->room);
    gl.DeleteFramebuffers(1, &st->framebuffer);
    gl.DeleteTextures(1, &st->depth);
    free(st);
}

void view_stage_restart(view_stage *st)
{
    st->fresh = false;
}

static bool resize(view_stage *st, int width, int height)
{
    if (st->depth && width == st->width && height == st->height)
        return true;
    gl.DeleteTextures(1, &st->depth);
    gl.GenTextures(1, &st->depth);
    gl.ActiveTexture(GL_TEXTURE0);
    gl.BindTexture(GL_TEXTURE_2D, st->depth);
    gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAX_LEVEL, 0);
    gl.TexImage2D(GL_TEXTURE_2D, 0, GL_DEPTH_COMPONENT24, width, height, 0,
                  GL_DEPTH_COMPONENT, GL_UNSIGNED_INT, NULL);
    st->width = width;
    st->height = height;
    return view_gl_check("making the scene's depth");
}

static bool make_context(view_stage *st)
{
    ibl_ctx_options o = ibl_ctx_options_default();

    o.log = view_log;
    return st->ctx || !ibl_ctx_create(&o, &st->ctx);
}

static bool make_captures(view_stage *st, const view_settings *s)
{
    view_capture_options o = view_capture_options_default();

    o.size = s->probe_size;
    o.kind = s->probe_capture == VIEW_PROBE_PARABOLOIDS
                 ? VIEW_CAPTURE_PARABOLOIDS
                 : VIEW_CAPTURE_FACES;
    o.timed = true;
    if (s->probe_filter == VIEW_PROBE_CPU) {
        if (!make_context(st))
            return false;
        o.cpu = st->ctx;
    }
    if (st->capture && o.size == st->made.size && o.kind == st->made.kind &&
        o.cpu == st->made.cpu && s->probes == st->locals)
        return true;
    drop_captures(st);
    st->made = o;
    st->capture = view_capture_create(&o);
    for (; st->capture && st->locals < s->probes; st->locals++)
        if (!(st->local[st->locals] = view_capture_create(&o)))
            return false;
    return st->capture;
}

/* ---- the probe --------------------------------------------------------- */

/* A room as it is captured, seen by clip from eye. */
static void draw_captured(const view_stage *st, view_room_draw d,
                          const double clip[16], const double eye[3], int side)
{
    memcpy(d.clip, clip, sizeof d.clip);
    memcpy(d.eye, eye, sizeof d.eye);
    d.paraboloid = side >= 0;
    view_room_render(st->room, &d);
}

static void capture_scene(void *cookie, const double clip[16],
                          const double eye[3], int size, int side)
{
    const view_stage *st = cookie;
    view_room_draw d = st->draw;

    (void)size;
    d.hidden = MIRROR;
    /* All of an update is of one moment. */
    d.seconds = st->begun_at;
    draw_captured(st, d, clip, eye, side);
}

/* What stands still alone. */
static void capture_still(void *cookie, const double clip[16],
                          const double eye[3], int size, int side)
{
    const view_stage *st = cookie;
    view_room_draw d = st->draw;

    (void)size;
    d.moving = false;
    draw_captured(st, d, clip, eye, side);
}

static void use_probe(view_room_probe *p, const view_capture *c,
                      const double position[3])
{
    *p = (view_room_probe){.specular = view_capture_specular(c),
                           .irradiance = view_capture_irradiance(c)};
    p->last_level = (float)(view_capture_levels(c) - 1);
    p->lod_scale = p->last_level;
    for (int k = 0; k < 3; k++) {
        p->position[k] = (float)position[k];
        p->influence_centre[k] = p->proxy_centre[k] =
            (float)view_room_centre[k];
        p->proxy_half[k] = (float)view_room_half[k];
        p->influence_half[k] = (float)(view_room_half[k] + beyond);
    }
}

/* The last whole updates light what is drawn: local ones come first, and what
 * they leave is the mirror's. */
static void use_probes(view_stage *st, const double position[3])
{
    for (int i = 0; i < st->locals; i++) {
        view_room_probe *p = &st->draw.probe[i];
        use_probe(p, st->local[i], places[i]);
        p->blend = 1;
        for (int k = 0; k < 3; k++) {
            p->influence_centre[k] = p->position[k];
            p->influence_half[k] = (float)local_half[k];
        }
    }
    use_probe(&st->draw.probe[st->locals], st->capture, position);
    st->draw.probe_count = st->locals + 1;
}

/* Everything at once, beginning with what the environment alone lights. */
static bool capture_whole(view_stage *st, const double position[3])
{
    st->draw.probe_count = 0;
    st->begun_at = st->draw.seconds;
    for (int bounce = 0; bounce < BOUNCES; bounce++) {
        if (!view_capture_update(st->capture, position, capture_scene, st))
            return false;
        for (int i = 0; i < st->locals; i++)
            if (!view_capture_update(st->local[i], places[i], capture_still,
                                     st))
                return false;
        use_probes(st, position);
    }
    st->begun = false;
    st->fresh = true;
    st->shown_at = st->begun_at;
    return true;
}

/* Seconds that go back are another time as well. */
static bool is_due(const view_stage *st, const view_settings *s)
{
    const double now = s->seconds;

    return (now < st->begun_at || now - st->begun_at >= s->probe_interval) &&
           view_room_moved(st->shown_at, now, view_room_centre, view_room_half);
}

static void refresh(view_stage *st, const view_settings *s,
                    const double position[3])
{
    use_probes(st, position);
    if (!st->begun) {
        if (!is_due(st, s))
            return;
        st->begun = true;
        st->begun_at = s->seconds;
    }
    if (!view_capture_advance(st->capture, position, capture_scene, st,
                              s->probe_faces ? s->probe_faces : ALL))
        return;
    st->begun = false;
    st->shown_at = st->begun_at;
    use_probes(st, position);
}

/* ---- frames ------------------------------------------------------------ */

view_camera view_stage_camera(const view_settings *s, int width, int height)
{
    view_settings about = *s;
    double middle[3], radius;

    if (about.distance <= 0)
        about.distance = view_stage_distance;
    view_camera c = view_camera_of(&about, width, height);
    view_room_sphere(MIRROR, 0, middle, &radius);
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
static bool is_stale(const view_stage *st, const view_settings *s)
{
    const view_room_draw *d = &st->draw;

    return !st->fresh || d->environment.turn < s->turn ||
           d->environment.turn > s->turn || d->parallax != s->parallax;
}

static void look(view_stage *st, const view_settings *s, int width, int height)
{
    const view_camera c = view_stage_camera(s, width, height);

    view_camera_matrix(&c, st->draw.clip);
    memcpy(st->draw.eye, c.eye, sizeof c.eye);
}

bool view_stage_draw(view_stage *st, const view_settings *s,
                     const view_room_environment *environment, GLuint table,
                     GLuint picture, int width, int height)
{
    double position[3], radius;

    if (!resize(st, width, height) || !make_captures(st, s))
        return false;
    const bool stale = is_stale(st, s);
    st->draw = (view_room_draw){.seconds = s->seconds,
                                .moving = true,
                                .hidden = -1,
                                .environment = *environment,
                                .table = table,
                                .parallax = s->parallax};
    st->draw.environment.turn = s->turn;
    look(st, s, width, height);
    view_room_sphere(MIRROR, s->seconds, position, &radius);
    if (!stale)
        refresh(st, s, position);
    else if (!capture_whole(st, position))
        return false;
    gl.BindFramebuffer(GL_FRAMEBUFFER, st->framebuffer);
    gl.FramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D,
                            picture, 0);
    gl.FramebufferTexture2D(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_TEXTURE_2D,
                            st->depth, 0);
    gl.Viewport(0, 0, width, height);
    view_room_render(st->room, &st->draw);
    return view_gl_check("drawing the scene");
}

void view_stage_times(const view_stage *st, double ms[3])
{
    view_capture_times(st->capture, ms);
}

double view_stage_shown(const view_stage *st)
{
    return st->shown_at;
}
