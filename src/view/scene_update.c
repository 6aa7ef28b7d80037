/* SPDX-License-Identifier: MIT */
/* What the stage's probes capture, when, and what it took. */
#include "view/scene_parts.h"

#include <math.h>
#include <string.h>

#include "view/message.h"
#include "view/probe_save.h"

enum {
    BOUNCES = 3, /* captures of a whole update, each lit by the one before */
    ALL = 1 << 20
};

/* Alone the probe is for all of the room: its box goes a little beyond the
 * walls. */
static const double beyond = 1;
/* With local ones, which see all of the room but not what moves in it, it comes
 * before them near the mirror: for all of that and what is about it. */
static const double near_half[3] = {1.5, 1.8, 1.5}, near_blend = 0.6;

/* ---- what is kept ------------------------------------------------------ */

void view_scene_drop_captures(view_scene *st)
{
    view_capture_free(st->capture);
    st->capture = NULL;
    view_scene_locals_free(st->locals);
    st->locals = NULL;
    st->local_count = st->due = st->seen = 0;
    st->fresh = st->begun = false;
}

static bool make_context(view_scene *st)
{
    ibl_ctx_options o = ibl_ctx_options_default();

    o.log = view_log;
    return st->ctx || !ibl_ctx_create(&o, &st->ctx);
}

static void forget_times(view_scene *st)
{
    memset(st->timed, 0, sizeof st->timed);
    memset(st->ms, 0, sizeof st->ms);
}

bool view_scene_make_captures(view_scene *st, const view_settings *s)
{
    view_capture_options o = view_capture_options_default();
    const int locals = st->set ? 0 : s->probes;

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
        o.cpu == st->made.cpu && locals == st->local_count &&
        s->probe_limit == st->limited)
        return true;
    view_scene_drop_captures(st);
    /* Times compare filters of the same. */
    if (o.size != st->made.size || o.kind != st->made.kind ||
        s->probe_limit != st->limited)
        forget_times(st);
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

/* Of the mirror. The first bounces of light come before there are local ones,
 * and until there are all of them, and where they leave to others what they do
 * not see, it is the last of all. */
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
    /* The mirror is in the way of its own, but has one side alone: from within
     * it is not seen. */
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

/* Where a capture that is limited to its probe's box may end, a little behind
 * its farthest corner: what is on the border is in it. */
static double farthest(const ibl_probe *p)
{
    double sum = 0;

    for (int k = 0; k < 3; k++) {
        const double away = fabs(p->position[k] - p->influence.centre[k]) +
                            p->influence.half[k];
        sum += away * away;
    }
    return 1.01 * sqrt(sum);
}

static double end_of(const view_scene *st, const ibl_probe *p)
{
    return st->limited ? farthest(p) : view_capture_options_default().far;
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

/* The mirror's capture is a whole one again. */
static void note_update(view_scene *st)
{
    st->shown_at = st->begun_at;
    st->updates++;
    note_times(st, st->capture, st->made.cpu ? VIEW_PROBE_CPU : VIEW_PROBE_GPU);
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

static void show_update(view_scene *st, const double position[3])
{
    use_probes(st, position);
    note_update(st);
}

/* There may be many, so that each is captured but once, in the light that the
 * mirror's has after its bounces, without what moves as they are; the mirror's
 * goes on when there are all. It is the same with those that are baked. */
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

bool view_scene_capture_whole(view_scene *st, const view_settings *s,
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

bool view_scene_refresh(view_scene *st, const view_settings *s,
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

/* ---- what is told ------------------------------------------------------ */

int view_scene_updates(const view_scene *st)
{
    return st->updates;
}

bool view_scene_times(const view_scene *st, view_probe_filter filter,
                      double ms[3])
{
    memcpy(ms, st->ms[filter], sizeof st->ms[filter]);
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

static bool read_face(void *cookie, int probe, int face, uint16_t *rgba)
{
    return view_scene_locals_face(cookie, probe, face, rgba);
}

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
                               .face = read_face,
                               .cookie = st->locals});
}
