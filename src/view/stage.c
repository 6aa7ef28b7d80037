/* SPDX-License-Identifier: MIT */
#include "view/stage.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "view/message.h"
#include "view/volumes.h"

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
    view_volumes *volumes; /* made when they are to be drawn */
    view_capture *capture; /* in the mirror, of what moves too */
    view_capture *local[VIEW_STAGE_LOCAL];
    int locals;
    ibl_ctx *ctx;              /* made when the library is to filter */
    view_capture_options made; /* what capture was made by */
    bool limited;              /* and whether it was to see its box alone */
    view_room_draw draw;       /* of the frame that is being made */
    GLuint framebuffer, depth;
    int width, height; /* of depth */
    bool fresh;        /* a whole update was made, and nothing is another */
    bool sun, capture_shadows; /* of the settings that it was made by */
    bool begun;                /* an update that is spread over frames */
    bool failed; /* the last one: there is none until something changes */
    double begun_at, shown_at;
    int updates;
    bool timed[VIEW_PROBE_FILTERS];
    double ms[VIEW_PROBE_FILTERS][3]; /* of the last update by each */
};

/* The box that a probe is for; below 0 the mirror's. */
static void influence_of(int local, double centre[3], double half[3])
{
    for (int k = 0; k < 3; k++) {
        centre[k] = local < 0 ? view_room_centre[k] : places[local][k];
        half[k] = local < 0 ? view_room_half[k] + beyond : local_half[k];
    }
}

/* Where a capture that is limited to that box may end, a little behind its
 * farthest corner: what is on the border is in it. */
static double farthest(int local, const double position[3])
{
    double centre[3], half[3], sum = 0;

    influence_of(local, centre, half);
    for (int k = 0; k < 3; k++) {
        const double away = fabs(position[k] - centre[k]) + half[k];
        sum += away * away;
    }
    return 1.01 * sqrt(sum);
}

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
    view_volumes_free(st->volumes);
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

static void forget_times(view_stage *st)
{
    memset(st->timed, 0, sizeof st->timed);
    memset(st->ms, 0, sizeof st->ms);
}

static bool make_captures(view_stage *st, const view_settings *s)
{
    view_capture_options o = view_capture_options_default();
    const double whole = o.far;
    double mirror[3], radius;

    o.size = s->probe_size;
    o.kind = s->probe_capture == VIEW_PROBE_PARABOLOIDS
                 ? VIEW_CAPTURE_PARABOLOIDS
                 : VIEW_CAPTURE_FACES;
    o.timed = true;
    view_room_sphere(MIRROR, s->seconds, mirror, &radius);
    if (s->probe_filter == VIEW_PROBE_CPU) {
        if (!make_context(st))
            return false;
        o.cpu = st->ctx;
    }
    if (st->capture && o.size == st->made.size && o.kind == st->made.kind &&
        o.cpu == st->made.cpu && s->probes == st->locals &&
        s->probe_limit == st->limited)
        return true;
    drop_captures(st);
    o.far = s->probe_limit ? farthest(-1, mirror) : whole;
    /* Times compare filters of the same. */
    if (o.size != st->made.size || o.kind != st->made.kind ||
        s->probe_limit != st->limited)
        forget_times(st);
    st->made = o;
    st->limited = s->probe_limit;
    st->capture = view_capture_create(&o);
    for (; st->capture && st->locals < s->probes; st->locals++) {
        o.far = st->limited ? farthest(st->locals, places[st->locals]) : whole;
        if (!(st->local[st->locals] = view_capture_create(&o)))
            return false;
    }
    return st->capture;
}

/* ---- the probe --------------------------------------------------------- */

/* Whose capture it is: of st->local, or below 0 the mirror's. */
typedef struct shot {
    const view_stage *st;
    int local;
} shot;

static void capture_scene(void *cookie, const double clip[16],
                          const double eye[3], int size, int side)
{
    const shot *s = cookie;
    view_room_draw d = s->st->draw;

    (void)size;
    if (s->local < 0)
        d.hidden = MIRROR;
    /* What stands still alone. */
    d.moving = s->local < 0;
    /* All of an update is of one moment. */
    d.seconds = s->st->begun_at;
    d.shadows = s->st->capture_shadows;
    d.limited = s->st->limited;
    influence_of(s->local, d.limit_centre, d.limit_half);
    memcpy(d.clip, clip, sizeof d.clip);
    memcpy(d.eye, eye, sizeof d.eye);
    d.paraboloid = side >= 0;
    view_room_render(s->st->room, &d);
}

static void use_probe(view_room_probe *p, const view_capture *c, int local,
                      const double position[3])
{
    double centre[3], half[3];

    influence_of(local, centre, half);
    *p = (view_room_probe){.specular = view_capture_specular(c),
                           .irradiance = view_capture_irradiance(c)};
    p->last_level = (float)(view_capture_levels(c) - 1);
    p->lod_scale = p->last_level;
    for (int k = 0; k < 3; k++) {
        p->position[k] = (float)position[k];
        p->influence_centre[k] = (float)centre[k];
        p->influence_half[k] = (float)half[k];
        p->proxy_centre[k] = (float)view_room_centre[k];
        p->proxy_half[k] = (float)view_room_half[k];
    }
    p->blend = local < 0 ? 0 : 1;
}

/* The last whole updates light what is drawn: local ones come first, and what
 * they leave is the mirror's. */
static void use_probes(view_stage *st, const double position[3])
{
    for (int i = 0; i < st->locals; i++)
        use_probe(&st->draw.probe[i], st->local[i], i, places[i]);
    use_probe(&st->draw.probe[st->locals], st->capture, -1, position);
    st->draw.probe_count = st->locals + 1;
}

static void note_times(view_stage *st, const view_capture *c,
                       view_probe_filter filter)
{
    view_capture_times(c, st->ms[filter]);
    st->timed[filter] = true;
}

/* The mirror's capture is a whole one again. */
static void note_update(view_stage *st)
{
    st->shown_at = st->begun_at;
    st->updates++;
    note_times(st, st->capture, st->made.cpu ? VIEW_PROBE_CPU : VIEW_PROBE_GPU);
}

/* Everything at once, beginning with what the environment alone lights. */
static bool capture_whole(view_stage *st, const double position[3])
{
    shot mirror = {st, -1};

    st->draw.probe_count = 0;
    st->begun_at = st->draw.seconds;
    st->failed = false;
    for (int bounce = 0; bounce < BOUNCES; bounce++) {
        if (!view_capture_update(st->capture, position, capture_scene, &mirror))
            return false;
        for (int i = 0; i < st->locals; i++) {
            shot local = {st, i};
            if (!view_capture_update(st->local[i], places[i], capture_scene,
                                     &local))
                return false;
        }
        use_probes(st, position);
    }
    st->begun = false;
    st->fresh = true;
    note_update(st);
    return true;
}

/* Seconds that go back are another time as well. */
static bool is_due(const view_stage *st, const view_settings *s)
{
    const double now = s->seconds;

    return (now < st->begun_at || now - st->begun_at >= s->probe_interval) &&
           view_room_moved(st->shown_at, now, view_room_centre, view_room_half);
}

/* An update that fails would fail, and say so, in each frame. */
static void give_up(view_stage *st)
{
    st->failed = view_capture_failed(st->capture);
    if (!st->failed)
        return;
    st->begun = false;
    view_note("the scene's probe stays as it is until it is asked for in "
              "another way");
}

static void refresh(view_stage *st, const view_settings *s,
                    const double position[3])
{
    shot mirror = {st, -1};

    use_probes(st, position);
    if (st->failed)
        return;
    if (!st->begun) {
        if (!is_due(st, s))
            return;
        st->begun = true;
        st->begun_at = s->seconds;
    }
    if (!view_capture_advance(st->capture, position, capture_scene, &mirror,
                              s->probe_faces ? s->probe_faces : ALL)) {
        give_up(st);
        return;
    }
    st->begun = false;
    note_update(st);
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
           d->environment.turn > s->turn || d->parallax != s->parallax ||
           st->sun != s->sun || st->capture_shadows != s->capture_shadows;
}

static void look(view_stage *st, const view_settings *s, int width, int height)
{
    const view_camera c = view_stage_camera(s, width, height);

    view_camera_matrix(&c, st->draw.clip);
    memcpy(st->draw.eye, c.eye, sizeof c.eye);
}

/* The probes of what was drawn, as the library has them. */
static int list_probes(const view_stage *st, ibl_probe *probes)
{
    const view_room_draw *d = &st->draw;

    for (int i = 0; i < d->probe_count; i++) {
        const view_room_probe *p = &d->probe[i];
        probes[i] =
            (ibl_probe){.blend = (double)p->blend, .has_proxy = d->parallax};
        for (int k = 0; k < 3; k++) {
            probes[i].position[k] = (double)p->position[k];
            probes[i].influence.centre[k] = (double)p->influence_centre[k];
            probes[i].influence.half[k] = (double)p->influence_half[k];
            probes[i].proxy.centre[k] = (double)p->proxy_centre[k];
            probes[i].proxy.half[k] = (double)p->proxy_half[k];
        }
    }
    return d->probe_count;
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

static bool draw_volumes(view_stage *st, double ev)
{
    ibl_probe probes[VIEW_ROOM_PROBES];
    view_volumes_draw d = {.ev = ev, .probe = probes};

    if (!st->volumes && !(st->volumes = view_volumes_create()))
        return false;
    memcpy(d.clip, st->draw.clip, sizeof d.clip);
    memcpy(d.eye, st->draw.eye, sizeof d.eye);
    d.count = list_probes(st, probes);
    for (int i = 0; i < d.count; i++)
        if (probes[i].influence.shape == IBL_SHAPE_BOX)
            clip_to_room(&probes[i].influence);
    view_volumes_render(st->volumes, &d);
    return true;
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
                                .shadows = true,
                                .environment = *environment,
                                .table = table,
                                .parallax = s->parallax};
    st->draw.environment.turn = s->turn;
    if (!s->sun)
        st->draw.environment.sun = (view_room_sun){0};
    st->sun = s->sun;
    st->capture_shadows = s->capture_shadows;
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
    if (s->volumes && !draw_volumes(st, s->ev))
        return false;
    return view_gl_check("drawing the scene");
}

int view_stage_updates(const view_stage *st)
{
    return st->updates;
}

bool view_stage_times(const view_stage *st, view_probe_filter filter,
                      double ms[3])
{
    memcpy(ms, st->ms[filter], sizeof st->ms[filter]);
    return st->timed[filter];
}

bool view_stage_measure(view_stage *st, view_probe_filter filter)
{
    view_capture_options o = st->made;
    shot mirror = {st, -1};
    double position[3], radius;

    if (filter == VIEW_PROBE_CPU && !make_context(st))
        return false;
    o.cpu = filter == VIEW_PROBE_CPU ? st->ctx : NULL;
    view_room_sphere(MIRROR, st->begun_at, position, &radius);
    view_capture *c = view_capture_create(&o);
    bool ok = c;
    /* With the first one, OpenGL compiles what it draws with. */
    for (int i = 0; i < 2 && ok; i++)
        ok = view_capture_update(c, position, capture_scene, &mirror);
    if (ok)
        note_times(st, c, filter);
    view_capture_free(c);
    return ok;
}

double view_stage_shown(const view_stage *st)
{
    return st->shown_at;
}

const view_room_draw *view_stage_drawn(const view_stage *st)
{
    return &st->draw;
}

ibl_ctx *view_stage_context(view_stage *st)
{
    return st->ctx;
}
