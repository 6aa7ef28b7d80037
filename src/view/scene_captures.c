/* SPDX-License-Identifier: MIT */
#include "view/scene_captures.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "view/message.h"
#include "view/probe_save.h"
#include "view/scene_locals.h"
#include "view/volumes.h"

enum {
    BOUNCES = 3, /* captures of a whole update, each lit by the one before */
    ALL = 1 << 20
};

/* Nearer than any sphere comes to the mirror on that side. */
const double view_scene_distance = 3.1;
static const double from_wall = 0.3; /* least distance of the camera */

/* The box of a probe for all of the room reaches a little beyond the walls. */
static const double beyond = 1;
/* Beside local probes, which leave out what moves, the probe of the mirror
 * comes first near it. */
static const double near_half[3] = {1.5, 1.8, 1.5}, near_blend = 0.6;

struct view_scene {
    view_room *room;
    view_volumes *volumes;     /* made when they are first drawn */
    view_capture *capture;     /* in the mirror, of what moves too */
    view_scene_locals *locals; /* NULL: none */
    int local_count;
    int due;  /* of them, the last, which are still to be captured anew */
    int seen; /* the first, which have been captured */
    const view_probe_set *set; /* baked probes; then there are no locals */
    ibl_ctx *ctx;              /* made when the library is to filter */
    view_capture_options made; /* what capture was made by */
    bool limited;              /* whether probes see only their boxes */
    view_room_draw draw;       /* of the frame that is being made */
    GLuint framebuffer, depth;
    int width, height;         /* of depth */
    bool fresh;                /* a whole update fits what is asked for */
    bool sun, capture_shadows; /* the settings that it was made by */
    bool still;                /* captures leave out what moves */
    bool begun;                /* an update that is spread over frames */
    bool failed; /* the last one: there is none until something changes */
    double begun_at, shown_at;
    int updates;
    bool timed[VIEW_PROBE_FILTERS];
    double ms[VIEW_PROBE_FILTERS][3];     /* of the last update by each */
    ibl_probe wired[VIEW_MAX_LOCALS + 1]; /* whose volumes are drawn */
};

/* ---- life -------------------------------------------------------------- */

void view_scene_drop_captures(view_scene *st)
{
    view_capture_free(st->capture);
    st->capture = NULL;
    view_scene_locals_free(st->locals);
    st->locals = NULL;
    st->local_count = st->due = st->seen = 0;
    st->fresh = st->begun = false;
}

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
    view_gl_filter(GL_TEXTURE_2D, GL_NEAREST, 1);
    gl.TexImage2D(GL_TEXTURE_2D, 0, GL_DEPTH_COMPONENT24, width, height, 0,
                  GL_DEPTH_COMPONENT, GL_UNSIGNED_INT, NULL);
    st->width = width;
    st->height = height;
    return view_gl_check("making the scene's depth");
}

static bool make_context(view_scene *st)
{
    ibl_ctx_options o = ibl_ctx_options_default();

    o.log = view_log;
    return st->ctx || !ibl_ctx_create(&o, &st->ctx);
}

static bool make_captures(view_scene *st, const view_settings *s)
{
    view_capture_options o = view_capture_options_default();
    const int locals = st->set ? 0 : s->probes;

    o.size = s->probe_size;
    o.kind = s->probe_capture;
    o.timed = true;
    if (s->probe_filter == VIEW_PROBE_CPU) {
        if (!make_context(st))
            return false;
        o.cpu = st->ctx;
    }
    const bool alike = o.size == st->made.size && o.kind == st->made.kind &&
                       s->probe_limit == st->limited;
    if (st->capture && alike && o.cpu == st->made.cpu &&
        locals == st->local_count)
        return true;
    view_scene_drop_captures(st);
    if (!alike) /* times compare filters of the same */
        memset(st->timed, 0, sizeof st->timed);
    st->made = o;
    st->limited = s->probe_limit;
    st->capture = view_capture_create(&o);
    if (!st->capture || !locals)
        return st->capture;
    o.timed = false;
    st->locals = view_scene_locals_create(&o, locals);
    st->local_count = st->locals ? locals : 0;
    return st->locals;
}

/* ---- the probe --------------------------------------------------------- */

/* Of the mirror. It comes last while local probes are missing, and where they
 * leave to others what they do not see. */
static ibl_probe mirror_probe(const view_scene *st, const double position[3])
{
    const bool holes =
        st->limited || (st->set && view_probe_set_holes(st->set));
    const bool all = st->seen == st->local_count;
    const bool whole = !st->draw.locals.count || !all || holes;
    ibl_probe p = {.has_proxy = 1,
                   .blend = whole ? 0 : near_blend,
                   .priority = whole ? -1 : 1,
                   .layer = -1};

    for (int k = 0; k < 3; k++) {
        p.position[k] = position[k];
        p.proxy.centre[k] = view_room_centre[k];
        p.proxy.half[k] = view_room_half[k];
        p.influence.centre[k] = whole ? view_room_centre[k] : position[k];
        p.influence.half[k] = whole ? view_room_half[k] + beyond : near_half[k];
    }
    return p;
}

/* Whose capture it is: the mirror's, or a local one's. */
typedef struct shot {
    const view_scene *st;
    ibl_probe probe;
    bool local;
} shot;

static void capture_scene(void *cookie, const double clip[16],
                          const double eye[3], int size, int side)
{
    const shot *s = cookie;
    view_room_draw d = s->st->draw;

    (void)size;
    /* From within, the mirror is not seen: it has one side. */
    d.moving = !s->local && !s->st->still;
    /* All of an update is of one moment. */
    d.seconds = s->st->begun_at;
    d.shadows = s->st->capture_shadows;
    d.limited = s->st->limited;
    memcpy(d.limit_centre, s->probe.influence.centre, sizeof d.limit_centre);
    memcpy(d.limit_half, s->probe.influence.half, sizeof d.limit_half);
    memcpy(d.clip, clip, sizeof d.clip);
    memcpy(d.eye, eye, sizeof d.eye);
    d.paraboloid = side >= 0;
    view_room_render(s->st->room, &d);
}

/* The far plane for a probe: limited to its box, a little behind the farthest
 * corner, since its border is in it. */
static double end_of(const view_scene *st, const ibl_probe *p)
{
    double sum = 0;

    if (!st->limited)
        return view_capture_options_default().far;
    for (int k = 0; k < 3; k++) {
        const double away = fabs(p->position[k] - p->influence.centre[k]) +
                            p->influence.half[k];
        sum += away * away;
    }
    return 1.01 * sqrt(sum);
}

static void use_capture(view_scene *st, const double position[3])
{
    const float last = (float)(view_capture_levels(st->capture) - 1);

    st->draw.dynamic =
        (view_room_dynamic){.specular = view_capture_specular(st->capture),
                            .irradiance = view_capture_irradiance(st->capture),
                            .lod_scale = last,
                            .last_level = last,
                            .probe = mirror_probe(st, position)};
}

/* The last whole updates light what is drawn. */
static void use_probes(view_scene *st, const double position[3])
{
    if (st->set)
        st->draw.locals = *view_probe_set_locals(st->set);
    else if (st->seen)
        st->draw.locals = view_scene_locals_drawn(st->locals);
    if (!st->set)
        st->draw.locals.count = st->seen;
    use_capture(st, position);
}

static void note_times(view_scene *st, const view_capture *c,
                       view_probe_filter filter)
{
    view_capture_times(c, st->ms[filter]);
    st->timed[filter] = true;
}

static bool capture_mirror(view_scene *st, const double position[3])
{
    shot mirror = {st, mirror_probe(st, position), false};

    view_capture_set_far(st->capture, end_of(st, &mirror.probe));
    return view_capture_update(st->capture, position, capture_scene, &mirror);
}

/* Lit at first by the environment alone, then by itself. */
static bool capture_bounces(view_scene *st, const double position[3])
{
    for (int bounce = 0; bounce < BOUNCES; bounce++) {
        if (!capture_mirror(st, position))
            return false;
        use_capture(st, position);
    }
    return true;
}

static bool capture_local(view_scene *st, int i)
{
    const ibl_probe p = view_scene_locals_drawn(st->locals).probe[i];
    shot local = {st, p, true};

    return view_scene_locals_capture(st->locals, i, end_of(st, &p),
                                     capture_scene, &local);
}

/* The mirror's capture is a whole one again. */
static void show_update(view_scene *st, const double position[3])
{
    use_probes(st, position);
    st->shown_at = st->begun_at;
    st->updates++;
    note_times(st, st->capture, st->made.cpu ? VIEW_PROBE_CPU : VIEW_PROBE_GPU);
}

/* Each of the local probes is captured only once, in the light of the mirror's
 * bounces, without what moves. The mirror's is captured again after them, and
 * after baked ones. */
static bool capture_due(view_scene *st, const view_settings *s,
                        const double position[3])
{
    use_capture(st, position);
    for (int left = s->spread && st->due ? 1 : st->due; left; left--) {
        if (!capture_local(st, st->local_count - st->due))
            return false;
        st->due--;
        if (st->seen < st->local_count - st->due)
            st->seen = st->local_count - st->due;
    }
    use_probes(st, position);
    if (st->due)
        return true;
    st->begun_at = st->draw.seconds;
    if (!capture_mirror(st, position))
        return false;
    show_update(st, position);
    return true;
}

static bool capture_whole(view_scene *st, const view_settings *s,
                          const double position[3])
{
    const bool others = st->locals || st->set;

    st->begun_at = st->draw.seconds;
    st->begun = st->failed = st->fresh = false;
    st->due = st->local_count;
    st->still = others;
    bool ok = capture_bounces(st, position);
    st->still = false;
    if (ok && others)
        ok = capture_due(st, s, position);
    else if (ok)
        show_update(st, position);
    st->fresh = ok;
    return ok;
}

/* Seconds that go back are another time as well. */
static bool is_due(const view_scene *st, const view_settings *s)
{
    const double now = s->seconds;

    return (now < st->begun_at || now - st->begun_at >= s->probe_interval) &&
           view_room_moved(st->shown_at, now, view_room_centre, view_room_half);
}

/* An update that fails would fail, and say so, in each frame. */
static void give_up(view_scene *st)
{
    st->failed = view_capture_failed(st->capture);
    if (!st->failed)
        return;
    st->begun = false;
    view_note("the scene's probe stays as it is until it is asked for in "
              "another way");
}

static bool refresh(view_scene *st, const view_settings *s,
                    const double position[3])
{
    if (st->due)
        return capture_due(st, s, position);
    use_probes(st, position);
    if (st->failed)
        return true;
    if (!st->begun) {
        if (!is_due(st, s))
            return true;
        st->begun = true;
        st->begun_at = s->seconds;
    }
    shot mirror = {st, st->draw.dynamic.probe, false};
    view_capture_set_far(st->capture, end_of(st, &mirror.probe));
    if (!view_capture_advance(st->capture, position, capture_scene, &mirror,
                              s->probe_faces ? s->probe_faces : ALL)) {
        give_up(st);
        return true;
    }
    st->begun = false;
    show_update(st, position);
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

/* Light that bounces is another with these, and what lights too. */
static bool is_stale(const view_scene *st, const view_settings *s)
{
    const view_room_draw *d = &st->draw;

    return !st->fresh || d->environment.turn < s->turn ||
           d->environment.turn > s->turn || d->parallax != s->parallax ||
           d->sharp == s->blend || st->sun != s->sun ||
           st->capture_shadows != s->capture_shadows;
}

/* The part of a box in the room, a little away from the walls, where proxies
 * are: no wire beyond them would be seen. */
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

    if (!resize(st, width, height) || !make_captures(st, s))
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
    const view_camera camera = view_scene_camera(s, width, height);
    view_camera_matrix(&camera, st->draw.clip);
    memcpy(st->draw.eye, camera.eye, sizeof camera.eye);
    view_room_sphere(VIEW_SCENE_MIRROR, s->seconds, position, &radius);
    if (!(stale ? capture_whole : refresh)(st, s, position))
        return false;
    view_gl_target(st->framebuffer, picture);
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

/* ---- what is told ------------------------------------------------------ */

int view_scene_updates(const view_scene *st)
{
    return st->updates;
}

bool view_scene_times(const view_scene *st, view_probe_filter filter,
                      double ms[3])
{
    for (int k = 0; k < 3; k++)
        ms[k] = st->timed[filter] ? st->ms[filter][k] : 0;
    return st->timed[filter];
}

bool view_scene_measure(view_scene *st, view_probe_filter filter)
{
    view_capture_options o = st->made;
    shot mirror = {st, st->draw.dynamic.probe, false};
    double position[3], radius;

    if (filter == VIEW_PROBE_CPU && !make_context(st))
        return false;
    o.cpu = filter == VIEW_PROBE_CPU ? st->ctx : NULL;
    o.far = end_of(st, &mirror.probe);
    view_room_sphere(VIEW_SCENE_MIRROR, st->begun_at, position, &radius);
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

double view_scene_shown(const view_scene *st)
{
    return st->shown_at;
}

ibl_ctx *view_scene_context(view_scene *st)
{
    return st->ctx;
}

/* ---- captures as files ------------------------------------------------- */

bool view_scene_save(const view_scene *st, ibl_ctx *ctx, const char *dir)
{
    if (!st || !st->locals)
        return view_fail("%s: there are no local probes to be written", dir);
    const view_room_locals l = view_scene_locals_drawn(st->locals);
    return view_probe_save(
        ctx, dir,
        &(view_probe_captures){.probe = l.probe,
                               .count = l.count,
                               .size = view_capture_size(st->capture),
                               .irradiance = VIEW_CAPTURE_IRRADIANCE,
                               .face = view_scene_locals_face,
                               .cookie = st->locals});
}
