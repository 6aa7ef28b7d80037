/* SPDX-License-Identifier: MIT */
#include "view/room.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

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
/* Margin of a whole-room influence beyond the walls. */
static const double beyond = 1;
/* Influence of the mirror's probe beside local probes. It comes before those
 * that leave out moving objects, but not before a set's. */
static const double near_half[3] = {1.5, 1.8, 1.5}, near_blend = 0.6;

struct view_scene {
    view_room *room;
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
    view_model *guest;         /* in place of the mirror, or NULL */
    view_settings made;        /* settings of the captures */
    view_scene_state now;      /* its draw is the one in progress */
    bool fresh;                /* the captures match the settings */
};

/* ---- create and free --------------------------------------------------- */

static void drop_captures(view_scene *st)
{
    view_capture_free(st->capture);
    st->capture = NULL;
    view_cubes_free(&st->mirror);
    view_cubes_free(&st->locals);
    st->local_count = st->due = st->seen = 0;
    st->fresh = false;
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

/* Makes what the settings ask for, unless it is there. */
static bool make_captures(view_scene *st, const view_settings *s)
{
    const int count = st->set ? 0 : s->probes, size = s->probe_size;
    GLint most = 0;

    if (st->capture && count == st->local_count &&
        size == st->made.probe_size &&
        s->probe_capture == st->made.probe_capture &&
        s->probe_limit == st->made.probe_limit)
        return true;
    drop_captures(st);
    st->made = *s;
    gl.GetIntegerv(GL_MAX_ARRAY_TEXTURE_LAYERS, &most);
    if (IBL_FACES * count > most)
        view_fail("%d probes are %d layers of a texture, this OpenGL has %d: "
                  "take %d probes",
                  count, IBL_FACES * count, most, most / IBL_FACES);
    else if (!view_cubes_make(&st->mirror, size, 2) ||
             (count && !view_cubes_make(&st->locals, size, count)))
        view_fail("this OpenGL has no room for %d probes with faces of %d: "
                  "take fewer by --probes, or smaller ones by --probe-size",
                  count + 1, size);
    else if ((st->capture = view_capture_create(s->probe_capture, size))) {
        if (count)
            view_scene_place(st->local, count);
        st->local_count = count;
        return true;
    }
    drop_captures(st);
    return false;
}

/* ---- the probe --------------------------------------------------------- */

/* The mirror's probe. It covers the room, and comes last, while local probes
 * are missing or where they leave holes. */
static ibl_probe mirror_probe(const view_scene *st)
{
    const view_probe_maps *l = &st->now.draw.locals;
    const bool whole = !l->count || st->seen < st->local_count || l->holes;
    ibl_probe p = {.has_proxy = 1,
                   .blend = whole ? 0 : near_blend,
                   .priority = whole || st->set ? -1 : 1,
                   .layer = st->shown};
    double radius;

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
    for (int k = 0; k < 3; k++)
        sum += pow(fabs(p->position[k] - p->influence.centre[k]) +
                       p->influence.half[k],
                   2);
    return 1.01 * sqrt(sum);
}

/* Captures a probe into its layer. */
static void capture(view_scene *st, const ibl_probe *p, const view_cubes *to,
                    bool moving)
{
    view_room_draw d = st->now.draw;

    d.moving = moving;
    d.weights = d.map = false;
    d.light.parts = VIEW_PARTS_ALL;
    d.guest = NULL;
    d.bare = st->made.probe_limit;
    d.camera =
        (view_camera){.eye = {p->position[0], p->position[1], p->position[2]},
                      .near = 0.05,
                      .far = far_plane(st, p)};
    view_capture_update(st->capture, st->room, &d, to, p->layer);
}

/* The mirror, into its cube that is not drawn with. It is invisible from
 * inside: surfaces have one side. */
static void capture_mirror(view_scene *st, bool moving)
{
    const double started = ibl_now();
    ibl_probe p = mirror_probe(st);

    p.layer = st->shown = !st->shown;
    capture(st, &p, &st->mirror, moving);
    gl.Finish();
    st->now.ms = 1e3 * (ibl_now() - started);
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

/* Lights the draw by the last captures. */
static void use_probes(view_scene *st)
{
    st->now.draw.locals = st->set
                              ? *view_probe_set_locals(st->set)
                              : maps_of(st, &st->locals, st->local, st->seen);
    use_mirror(st);
}

/* Captures local probes once each, lit by the mirror's bounces, without moving
 * objects: one a call if settings spread them. Afterwards, or with baked ones,
 * captures the mirror again. */
static void capture_due(view_scene *st, const view_settings *s)
{
    use_mirror(st);
    for (int left = s->spread && st->due ? 1 : st->due; left; left--) {
        const int i = st->local_count - st->due--;
        capture(st, &st->local[i], &st->locals, false);
        if (st->seen <= i)
            st->seen = i + 1;
    }
    use_probes(st);
    if (st->due)
        return;
    capture_mirror(st, true);
    use_mirror(st);
    st->now.shown = s->seconds;
    st->now.updates++;
}

/* The environment lights the first bounce, the mirror's probe the next ones. */
static void capture_whole(view_scene *st, const view_settings *s)
{
    const bool has_others = st->local_count || st->set;

    st->made = *s;
    st->fresh = true;
    st->due = st->local_count;
    for (int bounce = has_others ? 0 : 1; bounce < BOUNCES; bounce++) {
        capture_mirror(st, !has_others);
        use_mirror(st);
    }
    capture_due(st, s);
}

/* Objects move when the time changes, also if it goes back. */
static void refresh(view_scene *st, const view_settings *s)
{
    const double now = s->seconds, shown = st->now.shown;

    if (!st->due)
        use_probes(st);
    if (st->due || now < shown ||
        (now > shown && now - shown >= s->probe_interval))
        capture_due(st, s);
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
           m->parallax != s->parallax || m->probe_choice != s->probe_choice ||
           m->nearest != s->nearest || m->reflection != s->reflection ||
           m->diffuse != s->diffuse;
}

bool view_scene_update(view_scene *st, const view_settings *s,
                       const view_room_environment *environment, GLuint table,
                       view_model *guest, bool *anew)
{
    const view_room_draw before = st->now.draw;
    const int updates = st->now.updates, seen = st->seen, due = st->due;

    if (!make_captures(st, s))
        return false;
    if (guest != st->guest)
        st->fresh = false;
    if ((st->guest = guest)) {
        double middle[3], radius;
        view_room_sphere(VIEW_SCENE_MIRROR, 0, middle, &radius);
        /* From the floor to the top of the mirror. */
        radius = 0.5 * (middle[1] + radius);
        middle[1] = -radius * view_model_floor(guest);
        view_model_place(guest, middle, radius);
    }
    st->now.draw = (view_room_draw){
        .seconds = s->seconds,
        .moving = true,
        .mirror = !guest,
        .shadows = true,
        .environment = *environment,
        .table = table,
        .light = {.reflection = s->reflection ? VIEW_FIT : VIEW_SPLIT_SUM,
                  .diffuse = (view_diffuse)environment->frame.choice[1],
                  .parts = s->parts,
                  .rough_fresnel = s->rough_fresnel,
                  .override = s->override != VIEW_AS_IS},
        .parallax = s->parallax,
        .choice = s->probe_choice,
        .nearest = s->nearest,
        .weights = s->weights};
    st->now.draw.environment.turn = s->turn;
    (is_stale(st, s) ? capture_whole : refresh)(st, s);
    *anew =
        *anew || updates != st->now.updates || seen != st->seen ||
        due != st->due || before.seconds < s->seconds ||
        before.seconds > s->seconds || before.weights != s->weights ||
        memcmp(&before.light, &st->now.draw.light, sizeof before.light) != 0;
    return view_gl_check("capturing the scene");
}

bool view_scene_draw(view_scene *st, const view_settings *s, view_image *to)
{
    view_room_draw *d = &st->now.draw;

    d->camera = view_scene_camera(s, to->width, to->height);
    d->map = d->environment.map;
    d->guest = st->guest;
    return view_room_render(st->room, d, to) &&
           view_gl_check("drawing the scene");
}

const view_scene_state *view_scene_state_of(const view_scene *st)
{
    return &st->now;
}

int view_scene_probe_at(const view_scene *st, const view_settings *s, int width,
                        int height, double x, double y, double *weights)
{
    const view_camera c = view_scene_camera(s, width, height);
    const view_room_draw *d = &st->now.draw;
    const int count = d->locals.count;
    int best = count + 1;
    double p[3];

    view_camera_ray(&c, width, height, x, y, p);
    const double far = view_room_cast(d, c.eye, p);
    if (isinf(far))
        return VIEW_SCENE_NOWHERE;
    for (int k = 0; k < 3; k++)
        p[k] = c.eye[k] + far * p[k];
    view_room_weights(d, p, weights);
    for (int i = 0; i <= count; i++)
        if (weights[i] > weights[best])
            best = i;
    return best > count ? -1 : best;
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
    double centre[3], radius;
    bool in = true, any = false;

    view_room_sphere(VIEW_SCENE_MIRROR, 0, centre, &radius);
    for (int k = 0; k < 3; k++)
        in = in && fabs(p[k] - centre[k]) < radius + clearance;
    for (int i = 0; i < VIEW_ROOM_BOXES && !any; i++) {
        const view_room_box *b = view_room_box_at(i);
        any = true;
        for (int k = 0; k < 3; k++)
            any = any && p[k] > b->low[k] - clearance &&
                  p[k] < b->high[k] + clearance;
    }
    return in || any;
}

void view_scene_place(ibl_probe *probes, int count)
{
    const double *c = view_room_centre, *h = view_room_half;
    const int rows = (int)lround(sqrt(count));
    const int columns = (count + rows - 1) / rows; /* maximum of a row */
    const double blend = 2 * blend_part * fmin(h[0] / columns, h[2] / rows);
    ibl_probe placed[VIEW_MAX_LOCALS] = {0};
    int order[VIEW_MAX_LOCALS];

    for (int i = 0, row = 0; i < count; i++) {
        ibl_probe *p = &placed[i];
        row += i == count * (row + 1) / rows;
        const int first = count * row / rows;
        const int cell[3] = {i - first, 0, row};
        const int cells[3] = {count * (row + 1) / rows - first, 1, rows};
        *p = (ibl_probe){.has_proxy = 1, .blend = blend};
        for (int k = 0; k < 3; k++) {
            const double half = h[k] / cells[k];
            const double middle =
                c[k] + h[k] * ((2.0 * cell[k] + 1) / cells[k] - 1);
            /* Beyond walls, or into neighbours. */
            const double before = cell[k] ? blend / 2 : blend + overlap;
            const double after =
                cell[k] < cells[k] - 1 ? blend / 2 : blend + overlap;
            p->position[k] = k == 1 ? eye_level : middle;
            p->influence.centre[k] = middle + (after - before) / 2;
            p->influence.half[k] = half + (after + before) / 2;
            p->proxy.centre[k] = c[k];
            p->proxy.half[k] = h[k];
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
