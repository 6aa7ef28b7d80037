/* SPDX-License-Identifier: MIT */
/* Wires of probes: along the edges of their volumes, where nothing of the room
 * is before them, and nowhere else. */
#include "room.h"
#include "view.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "view/scene_captures.h"

enum {
    WIDTH = 160,
    HEIGHT = 120,
    PIXELS = WIDTH * HEIGHT
};

static GLuint volumes;

static void free_volumes(void *unused)
{
    (void)unused;
    gl.DeleteProgram(volumes);
    volumes = 0;
}

static void begin(void)
{
    lit_begin(WIDTH, HEIGHT);
    test_defer(free_volumes, NULL);
}

/* ---- which pixels are drawn --------------------------------------------- */

typedef struct wires {
    view_camera camera;
    view_room_draw draw;
    unsigned char drawn[PIXELS];  /* 1 influence, 2 proxy */
    unsigned char may_be[PIXELS]; /* the same, a bit each: a wire is near */
    int missing, checked;
} wires;

static bool is_colour(const float *pixel, const float colour[3], float scale)
{
    for (int k = 0; k < 3; k++)
        if (fabsf(pixel[k] - scale * colour[k]) > 1e-5F)
            return false;
    return true;
}

/* What differs from the room alone has one of two colours. */
static void draw(wires *w, const ibl_probe *probes, int count, double ev)
{
    const float scale = (float)exp2(-ev);
    int other = 0;

    float *before = lit_render(&w->draw);
    for (int i = 0; i < count; i++)
        if (probes[i].has_proxy)
            view_volumes_render(&volumes, ev, &probes[i].proxy,
                                view_volumes_proxy);
    for (int i = 0; i < count; i++)
        view_volumes_render(&volumes, ev, &probes[i].influence,
                            view_volumes_influence);
    float *after = room_target_read(&lit.target);
    for (int i = 0; i < PIXELS; i++) {
        const float *a = after + 4 * i;
        w->drawn[i] = !memcmp(before + 4 * i, a, 4 * sizeof *a)     ? 0
                      : is_colour(a, view_volumes_influence, scale) ? 1
                      : is_colour(a, view_volumes_proxy, scale)     ? 2
                                                                    : 3;
        other += w->drawn[i] == 3;
    }
    CHECK_MSG(other == 0, "%d pixels of other colours", other);
}

/* Where a point of the world is, pixels from the upper left. False behind the
 * camera or outside of the picture. */
static bool place(const wires *w, const double p[3], double *x, double *y)
{
    double clip[4];

    for (int i = 0; i < 4; i++) {
        clip[i] = w->draw.clip[12 + i];
        for (int k = 0; k < 3; k++)
            clip[i] += w->draw.clip[4 * k + i] * p[k];
    }
    *x = (0.5 + 0.5 * clip[0] / clip[3]) * WIDTH;
    *y = (0.5 - 0.5 * clip[1] / clip[3]) * HEIGHT;
    return clip[3] > 0.06 && *x > 2 && *y > 2 && *x < WIDTH - 2 &&
           *y < HEIGHT - 2;
}

/* How far before a point the camera's ray is blocked; below 0: it is not. */
static double hidden_by(const wires *w, const double p[3])
{
    double ray[3], away = 0;

    for (int k = 0; k < 3; k++) {
        ray[k] = p[k] - w->camera.eye[k];
        away += ray[k] * ray[k];
    }
    away = sqrt(away);
    for (int k = 0; k < 3; k++)
        ray[k] /= away;
    const room_hit h = room_cast(&w->draw, w->camera.eye, ray);
    return (away - h.distance) / away;
}

/* A point of a wire: there is a pixel of it near by, if it is to be seen. */
static void check_point(wires *w, const double p[3], int kind)
{
    double x, y;
    bool found = false;

    if (!place(w, p, &x, &y))
        return;
    const double behind = hidden_by(w, p);
    for (int i = 0; i < 9; i++) {
        const int at = ((int)y + i / 3 - 1) * WIDTH + (int)x + i % 3 - 1;
        /* Proxies are drawn first. */
        found = found || w->drawn[at] == kind || w->drawn[at] == 1;
        if (behind < 0.02)
            w->may_be[at] |= (unsigned char)kind;
    }
    if (behind < -0.02) {
        w->missing += !found;
        w->checked++;
    }
}

/* Points on the edges of -1..1, or circles of radius 1. */
static void walk(wires *w, const ibl_volume *v, int kind)
{
    const bool sphere = v->shape == IBL_SHAPE_SPHERE;

    for (int wire = 0; wire < (sphere ? 3 : 12); wire++)
        for (int i = 0; i <= 2000; i++) {
            const double t = i / 1000.0 - 1;
            double p[3];
            const int axis = wire % 3, a = (axis + 1) % 3, b = (axis + 2) % 3;
            p[axis] = sphere ? 0 : t;
            p[a] = sphere ? cos(3.14159265358979 * t) : wire / 3 % 2 ? 1 : -1;
            p[b] = sphere ? sin(3.14159265358979 * t) : wire / 6 ? 1 : -1;
            for (int k = 0; k < 3; k++)
                p[k] = v->centre[k] + p[k] * v->half[sphere ? 0 : k];
            check_point(w, p, kind);
        }
}

static wires *look(const double eye[3], const double at[3])
{
    wires *w = test_alloc(1, sizeof *w);

    w->camera = room_camera(eye, at, 70, WIDTH, HEIGHT);
    w->draw = lit_draw(&w->camera);
    w->draw.seconds = 1;
    return w;
}

/* Each pixel of a wire lies on one, and each visible wire has pixels. */
static void check_wires(wires *w, const ibl_probe *probes, int count,
                        int at_least)
{
    int stray = 0;

    for (int i = 0; i < count; i++) {
        walk(w, &probes[i].influence, 1);
        if (probes[i].has_proxy)
            walk(w, &probes[i].proxy, 2);
    }
    for (int i = 0; i < PIXELS; i++) {
        const int x = i % WIDTH, y = i / WIDTH;
        const bool inside = x > 2 && y > 2 && x < WIDTH - 3 && y < HEIGHT - 3;
        stray += inside && (w->drawn[i] & ~w->may_be[i]);
    }
    CHECK_MSG(stray == 0, "%d pixels where no wire is", stray);
    CHECK_MSG(w->missing == 0, "%d of %d points", w->missing, w->checked);
    CHECK_MSG(w->checked > at_least, "%d points", w->checked);
}

/* Partly behind pillars and the mirror, and in the floor. */
static const ibl_probe some[] = {
    {.influence = {IBL_SHAPE_BOX, {-2, 1.2, 0.4}, {1.5, 0.9, 1.2}},
     .has_proxy = 1,
     .proxy = {IBL_SHAPE_BOX, {0, 2, 0}, {5, 2, 5}}},
    {.influence = {IBL_SHAPE_SPHERE, {1.5, 1, -1.5}, {1.4, 0, 0}},
     .has_proxy = 1,
     .proxy = {IBL_SHAPE_SPHERE, {0.4, 1.6, 0.3}, {1.2, 0, 0}}},
    {.influence = {IBL_SHAPE_BOX, {0, 2, 0}, {6, 3, 6}}}, /* behind walls */
};

TEST(are_where_volumes_are)
{
    static const double eyes[][3] = {{0.3, 2.4, 4.6}, {4.4, 1.4, 1.2}};
    const double at[3] = {-0.2, 1.1, -0.4};

    begin();
    for (int i = 0; i < 2; i++) {
        wires *w = look(eyes[i], at);
        draw(w, some, 3, 0);
        check_wires(w, some, 3, 5000);
    }
}

/* Of a proxy that does not count there is none, and at another exposure there
 * is as much more light. */
TEST(proxies_and_exposure)
{
    const double eye[3] = {0.3, 2.4, 4.6}, at[3] = {0, 1, 0};

    begin();
    wires *w = look(eye, at);
    ibl_probe p = some[0];
    p.has_proxy = 0;
    draw(w, &p, 1, -2);
    check_wires(w, &p, 1, 2000);
}
