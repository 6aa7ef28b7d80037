/* SPDX-License-Identifier: MIT */
#include "view/room.h"

#include <math.h>
#include <stdlib.h>

#include "common/process.h"
#include "common/signals.h"
#include "view/gl.h"
#include "view/message.h"

enum {
    BOUNCES = 3 /* mirror captures in an update, each lit by the last */
};

/* No sphere on that side comes so near to the mirror. */
const double view_scene_distance = 3.1;
static const double from_wall = 0.3; /* minimum for the camera */

static const double whole_room_far = 100; /* far plane of captures */
/* Influence of the mirror's probe: how far beyond the whole room, and beside
 * local probes, where it comes before those that leave out moving objects, but
 * not before a set's. */
static const double beyond_room = 1;
static const ibl_volume near_mirror = {.centre = {0, 0.9, 0},
                                       .half = {1.5, 1.8, 1.5}};
static const double near_blend = 0.6;

/* ---- create and free --------------------------------------------------- */

static void drop_captures(view_scene *st)
{
    view_capture_free(st->capture);
    st->capture = NULL;
    view_probe_maps_free(&st->mirror);
    view_probe_maps_free(&st->locals);
    st->made.nearest = 0;
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
    st->made.nearest = 0;
    st->told = false;
}

/* Whether captures are not those that settings ask for, at any time. */
static bool is_stale(const view_scene *st, const view_settings *s)
{
    const view_settings *m = &st->made;

    return fabs(m->turn - s->turn) > 0 || m->reflection != s->reflection ||
           m->diffuse != s->diffuse || m->parallax != s->parallax ||
           m->probe_choice != s->probe_choice || m->nearest != s->nearest ||
           m->probes != s->probes || m->probe_size != s->probe_size ||
           m->probe_capture != s->probe_capture ||
           m->probe_limit != s->probe_limit;
}

/* Makes cubes for settings, unless they are there. */
static bool make_captures(view_scene *st, const view_settings *c)
{
    const int size = 16 << c->probe_size;

    if (st->capture && c->probes == st->made.probes &&
        c->probe_size == st->made.probe_size &&
        c->probe_capture == st->made.probe_capture)
        return true;
    drop_captures(st);
    if (!view_probe_maps_make(&st->mirror, size, 2) ||
        (c->probes && !view_probe_maps_make(&st->locals, size, c->probes)))
        view_fail("this OpenGL has no room for %d probes with faces of %d: "
                  "take fewer by --probes, or smaller ones by --probe-size",
                  c->probes + 1, size);
    else if ((st->capture = view_capture_create(c->probe_capture, size))) {
        st->mirror.count = 1;
        st->mirror.probe = &st->probe;
        st->locals.probe = st->local;
        if (c->probes)
            view_scene_place(st->local, c->probes);
        return true;
    }
    drop_captures(st);
    return false;
}

/* ---- the probes -------------------------------------------------------- */

/* Lights the draw by the last captures: of the mirror, and others or not. The
 * mirror's probe covers the room, and comes last, while local probes are
 * missing or where they leave holes. */
static void use_probes(view_scene *st, bool others)
{
    const view_probe_maps *all = st->set ? &st->set->maps : &st->locals;
    const bool whole =
        !others || !all->count || all->holes || all->count < st->made.probes;
    const view_room_sphere mirror = view_room_sphere_at(0, 0);
    st->probe = (ibl_probe){
        .position = {mirror.centre[0], mirror.centre[1], mirror.centre[2]},
        .has_proxy = 1,
        .proxy = view_room_inside,
        .influence = whole ? view_room_inside : near_mirror,
        .blend = whole ? 0 : near_blend,
        .priority = whole || st->set ? -1 : 1,
        .layer = st->probe.layer};
    for (int k = 0; k < 3 && whole; k++)
        st->probe.influence.half[k] += beyond_room;
    st->draw.dynamic = st->mirror;
    st->draw.locals = *all;
    if (!others)
        st->draw.locals.count = 0;
}

/* Captures a probe into its layer. A limited capture ends a little behind the
 * farthest corner of its box. It has alpha 0 beyond, as where it sees the
 * environment. */
static void capture(view_scene *st, const ibl_probe *p,
                    const view_probe_maps *to, bool moving)
{
    view_room_draw d = st->draw;
    double sum = 0;

    d.settings.weights = false;
    d.moving = moving;
    d.environment.map = false;
    d.environment.frame.turn[2] = 0;
    d.guest = NULL;
    d.bare = st->made.probe_limit;
    for (int k = 0; k < 3; k++) {
        d.camera.eye[k] = p->position[k];
        sum += pow(fabs(p->position[k] - p->influence.centre[k]) +
                       p->influence.half[k],
                   2);
    }
    d.camera.near = 0.05;
    d.camera.far = d.bare ? 1.01 * sqrt(sum) : whole_room_far;
    view_capture_update(st->capture, st->room, &d, to, p->layer);
}

/* The mirror, into its cube that is not drawn with. It is invisible from
 * inside: surfaces have one side. */
static void capture_mirror(view_scene *st, bool moving)
{
    const double started = ibl_now();
    ibl_probe p = st->probe;

    p.layer = !p.layer;
    capture(st, &p, &st->mirror, moving);
    gl.Finish();
    st->ms = 1e3 * (ibl_now() - started);
    st->probe = p;
    st->draw.dynamic = st->mirror;
}

/* Captures local probes once each, lit by the mirror's bounces, without moving
 * objects: one a call if settings spread them. Afterwards, or with baked ones,
 * captures the mirror again. */
static void capture_due(view_scene *st, const view_settings *s)
{
    use_probes(st, false);
    while (st->locals.count < st->made.probes) {
        capture(st, &st->local[st->locals.count], &st->locals, false);
        st->locals.count++;
        if (s->spread)
            break;
    }
    use_probes(st, true);
    if (st->locals.count < st->made.probes)
        return;
    capture_mirror(st, true);
    st->shown = s->seconds;
    st->updates++;
}

/* The environment lights the first bounce, the mirror's probe the next ones. */
static void capture_whole(view_scene *st, const view_settings *s)
{
    const bool has_others = st->made.probes || st->set;

    st->locals.count = 0;
    st->mirror.holes = st->locals.holes = st->made.probe_limit;
    use_probes(st, false);
    st->draw.dynamic.count = 0;
    for (int bounce = has_others ? 0 : 1; bounce < BOUNCES; bounce++)
        capture_mirror(st, !has_others);
    capture_due(st, s);
}

/* ---- frames ------------------------------------------------------------ */

view_camera view_scene_camera(const view_settings *s, int width, int height)
{
    const view_room_sphere mirror = view_room_sphere_at(0, 0);
    view_settings about = *s;

    if (about.distance <= 0)
        about.distance = view_scene_distance;
    view_camera c = view_camera_of(&about, width, height);
    for (int k = 0; k < 3; k++) {
        const double middle = view_room_inside.centre[k];
        const double most = view_room_inside.half[k] - from_wall;
        c.eye[k] = fmin(fmax(c.eye[k] + mirror.centre[k], middle - most),
                        middle + most);
    }
    c.near = 0.05;
    c.far = 40;
    return c;
}

bool view_scene_update(view_scene *st, const view_settings *s,
                       const view_room_environment *environment, GLuint table,
                       view_model *guest, bool *anew)
{
    const view_room_sphere mirror = view_room_sphere_at(0, 0);
    const double since = s->seconds - st->shown;
    const int lights = environment->frame.reflection[2];
    const view_settings *last = &st->draw.settings;
    view_settings now = *s;

    now.probes = st->set ? 0 : s->probes;
    if (!make_captures(st, &now))
        return false;
    if (lights && !st->told)
        view_note("the set has %d light%s beside its maps, left out in the "
                  "room: --mode spheres and model show %s",
                  lights, lights > 1 ? "s" : "", lights > 1 ? "them" : "it");
    st->told = true;
    const bool stale = is_stale(st, &now) || guest != st->guest;
    st->guest = guest;
    if (guest) {
        /* From the floor to the top of the mirror. */
        const double radius = 0.5 * (mirror.centre[1] + mirror.radius);
        view_model_place(guest,
                         (double[3]){mirror.centre[0],
                                     -radius * view_model_floor(guest),
                                     mirror.centre[2]},
                         radius);
    }
    *anew = *anew || last->weights != s->weights ||
            fabs(last->seconds - s->seconds) > 0;
    st->draw = (view_room_draw){.settings = *s,
                                .moving = true,
                                .mirror = !guest,
                                .environment = *environment,
                                .table = table};
    st->made = now;
    if (stale) {
        capture_whole(st, s);
    } else if (st->locals.count < now.probes || since < 0 ||
               (since > 0 && since >= s->probe_interval)) {
        capture_due(st, s);
    } else {
        use_probes(st, true);
        return true;
    }
    *anew = true;
    return view_gl_check("capturing the scene");
}

bool view_scene_draw(view_scene *st, const view_settings *s, view_image *to)
{
    view_room_draw *d = &st->draw;

    d->camera = view_scene_camera(s, to->width, to->height);
    d->guest = st->guest;
    return view_room_render(st->room, d, to) &&
           view_gl_check("drawing the scene");
}

int view_scene_probe_at(view_scene *st, const view_settings *s, int width,
                        int height, double x, double y, double *weight)
{
    view_room_draw d = st->draw;
    float seen[4] = {0};

    /* A picture of that pixel alone. */
    d.camera = view_scene_camera(s, width, height);
    d.camera.shift[0] = width * d.camera.shift[0] + 2 * x + 1 - width;
    d.camera.shift[1] = height * d.camera.shift[1] - 2 * y - 1 + height;
    for (int k = 0; k < 3; k++) {
        d.camera.right[k] /= width;
        d.camera.up[k] /= height;
    }
    d.largest = true;
    d.guest = NULL;
    d.bare = true;
    if (view_image_make(&st->pixel, 1, 1) &&
        view_room_render(st->room, &d, &st->pixel))
        gl.ReadPixels(0, 0, 1, 1, GL_RGBA, GL_FLOAT, seen);
    *weight = (double)seen[1];
    return seen[3] > 0 ? (int)lroundf(seen[0]) : VIEW_SCENE_NOWHERE;
}

/* ---- local probes -------------------------------------------------------- */

static const double eye_level = 1.5;
/* Distance to keep from boxes and the mirror. */
static const double clearance = 0.25;
/* Extent of influence beyond walls, besides the blend width. */
static const double overlap = 0.25;
/* Blend width relative to the shortest side of a cell. It is the same for all
 * probes, so neighbours sum to at least 1. */
static const double blend_part = 0.4;

/* Whether a probe there would be in a box or the mirror. */
static bool is_blocked(const double p[3])
{
    const view_room_sphere m = view_room_sphere_at(0, 0);
    bool any =
        hypot(p[0] - m.centre[0], p[2] - m.centre[2]) < m.radius + clearance;

    for (int i = 0; i < VIEW_ROOM_BOXES && !any; i++) {
        const view_room_box b = view_room_box_at(i);
        any = true;
        for (int k = 0; k < 3; k++)
            any = any && p[k] > b.low[k] - clearance &&
                  p[k] < b.high[k] + clearance;
    }
    return any;
}

void view_scene_place(ibl_probe *probes, int count)
{
    const double *c = view_room_inside.centre, *h = view_room_inside.half;
    const int rows = (int)lround(sqrt(count));
    const int columns = (count + rows - 1) / rows; /* maximum of a row */
    const double blend = 2 * blend_part * fmin(h[0] / columns, h[2] / rows);
    ibl_probe placed[VIEW_MAX_LOCALS] = {0};
    int order[VIEW_MAX_LOCALS];

    for (int i = 0; i < count; i++) {
        ibl_probe *p = &placed[i];
        const int row = (rows * (i + 1) - 1) / count;
        const int first = count * row / rows;
        const int cell[3] = {i - first, 0, row};
        const int cells[3] = {count * (row + 1) / rows - first, 1, rows};
        *p = (ibl_probe){
            .has_proxy = 1, .proxy = view_room_inside, .blend = blend};
        for (int k = 0; k < 3; k++) {
            const double middle =
                c[k] + h[k] * ((2.0 * cell[k] + 1) / cells[k] - 1);
            p->position[k] = k == 1 ? eye_level : middle;
            /* Beyond walls, or into neighbours. */
            const double before = cell[k] ? blend / 2 : blend + overlap;
            const double after =
                cell[k] < cells[k] - 1 ? blend / 2 : blend + overlap;
            p->influence.centre[k] = middle + (after - before) / 2;
            p->influence.half[k] = h[k] / cells[k] + (after + before) / 2;
        }
        /* The nearest free place, to either side. */
        const double x = p->position[0];
        for (int n = 1; is_blocked(p->position); n++)
            p->position[0] = x + (n % 2 ? 0.025 : -0.025) * (n + 1);
    }
    ibl_probes_order(placed, count, order);
    for (int i = 0; i < count; i++) {
        probes[i] = placed[order[i]];
        probes[i].layer = i;
    }
}
