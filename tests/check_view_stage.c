/* SPDX-License-Identifier: MIT */
/* --mode scene: its probe follows what moves within the interval, at once or a
 * face at a time, and settings change the picture. */
#include "room.h"
#include "view.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "view/scene_captures.h"
#include "view/volumes.h"

enum {
    WIDTH = 96,
    HEIGHT = 64,
    FLOATS = 3 * WIDTH * HEIGHT
};

/* The stage, and pictures of it. */
typedef struct look {
    room_stage on;
    float rgb[FLOATS], before[FLOATS];
} look;

static look *begin(void)
{
    static const float light[3] = {0.5F, 0.6F, 0.8F}, table[2] = {0.9F, 0.05F};
    look *l = calloc(1, sizeof *l);

    if (!l || !room_stage_begin(&l->on, WIDTH, HEIGHT, light, table)) {
        free(l);
        return NULL;
    }
    l->on.s.probe_size = 32;
    return l;
}

static void end(look *l)
{
    room_stage_end(&l->on);
    free(l);
}

static bool draw(look *l, double seconds)
{
    memcpy(l->before, l->rgb, sizeof l->rgb);
    l->on.s.seconds = seconds;
    float *rgba = room_stage_draw(&l->on);
    for (int i = 0; rgba && i < FLOATS; i++)
        l->rgb[i] = rgba[4 * (i / 3) + i % 3];
    const bool ok = rgba != NULL;
    free(rgba);
    return ok;
}

/* Mean difference of what is in the middle, in the mirror. */
static double changed(const look *l)
{
    double sum = 0;
    int count = 0;

    for (int y = HEIGHT / 2 - 6; y < HEIGHT / 2 + 6; y++)
        for (int x = 3 * (WIDTH / 2 - 6); x < 3 * (WIDTH / 2 + 6); x++) {
            const int i = 3 * WIDTH * y + x;
            sum += fabs((double)l->rgb[i] - (double)l->before[i]);
            count++;
        }
    return sum / count;
}

/* What is captured within the interval is nearly what a stage shows that is
 * made then. */
static void follows_within_the_interval(void)
{
    look *l = begin();
    float late[FLOATS], stale[FLOATS];

    if (!l)
        return;
    NEED(l->on.stage);
    CHECK(draw(l, 0));
    CHECK_NEAR(view_scene_shown(l->on.stage), 0, 0);
    CHECK(draw(l, 0.4));
    CHECK_NEAR(view_scene_shown(l->on.stage), 0, 0);
    CHECK(draw(l, 0.5));
    CHECK_NEAR(view_scene_shown(l->on.stage), 0.5, 0);
    CHECK(draw(l, 0.9));
    CHECK_NEAR(view_scene_shown(l->on.stage), 0.5, 0);
    /* A jump is followed: the mirror has the lamp where it is then. */
    CHECK(draw(l, 2));
    CHECK(changed(l) > 0.01);
    l->on.s.probe_interval = 9;
    CHECK(draw(l, 2.6));
    memcpy(stale, l->rgb, sizeof stale);
    l->on.s.probe_interval = 0.5;
    CHECK(draw(l, 2.6));
    memcpy(late, l->rgb, sizeof late);
    view_scene_restart(l->on.stage);
    CHECK(draw(l, 2.6));
    /* Only the light's later bounces are behind. */
    memcpy(l->before, stale, sizeof stale);
    const double behind = changed(l);
    memcpy(l->before, late, sizeof late);
    CHECK_MSG(changed(l) < 0.25 * behind, "%g, %g", changed(l), behind);
    l->on.s.probe_interval = 0;
    CHECK(draw(l, 2.7));
    CHECK_NEAR(view_scene_shown(l->on.stage), 2.7, 0);
    /* Time that goes back is another one at once. */
    l->on.s.probe_interval = 9;
    CHECK(draw(l, 1));
    CHECK_NEAR(view_scene_shown(l->on.stage), 1, 0);
    end(l);
}

/* A face at a time it takes many frames, which all show the last whole one,
 * and then gives what all at once gives. */
static void is_spread_over_frames(void)
{
    look *l = begin();
    int frames = 1;

    if (!l)
        return;
    NEED(l->on.stage);
    CHECK(draw(l, 0));
    l->on.s.probe_faces = 1;
    CHECK(draw(l, 1));
    for (; frames < 200 && view_scene_shown(l->on.stage) < 1; frames++)
        CHECK(draw(l, 1));
    CHECK_MSG(frames > 12 && frames < 200, "%d", frames);
    CHECK_NEAR(view_scene_shown(l->on.stage), 1, 0);
    CHECK(draw(l, 1));
    float spread[FLOATS];
    memcpy(spread, l->rgb, sizeof spread);
    view_scene_restart(l->on.stage);
    CHECK(draw(l, 0));
    l->on.s.probe_faces = 0;
    CHECK(draw(l, 1));
    memcpy(l->before, spread, sizeof spread);
    CHECK_MSG(changed(l) < 1e-6, "%g", changed(l));
    end(l);
}

static PFNGLCLEARPROC real_clear;
static int pictures;

static void APIENTRY count_clear(GLbitfield mask)
{
    pictures += mask == (GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
    real_clear(mask);
}

/* Six faces for each of three bounces of light, then of each local probe and of
 * the mirror; nothing where nothing is new. */
static void light_bounces_three_times(void)
{
    look *l = begin();

    if (!l)
        return;
    NEED(l->on.stage);
    real_clear = gl.Clear;
    gl.Clear = count_clear;
    for (int locals = 0; locals < 3; locals++) {
        l->on.s.probes = locals;
        pictures = 0;
        CHECK(draw(l, 1));
        CHECK_MSG(pictures == 6 * (3 + (locals ? locals + 1 : 0)), "%d, %d",
                  locals, pictures);
        CHECK(draw(l, 1));
        CHECK(pictures == 6 * (3 + (locals ? locals + 1 : 0)));
    }
    /* So with each setting by which light is another. */
    l->on.s.probes = 0;
    CHECK(draw(l, 1));
    bool *const switches[] = {&l->on.s.parallax, &l->on.s.blend, &l->on.s.sun,
                              &l->on.s.capture_shadows};
    for (int i = 0; i < 5; i++) {
        if (i < 4)
            *switches[i] = !*switches[i];
        else
            l->on.s.turn = 15;
        pictures = 0;
        CHECK(draw(l, 1));
        CHECK_MSG(pictures == 6 * 3, "setting %d: %d", i, pictures);
    }
    gl.Clear = real_clear;
    end(l);
}

/* Of a volume that goes beyond the walls wires are in the room. */
static void wires_are_seen(void)
{
    look *l = begin();

    if (!l)
        return;
    NEED(l->on.stage);
    l->on.s.volumes = true;
    l->on.s.fov = 100;
    CHECK(draw(l, 1));
    int count = 0;
    for (int i = 0; i < FLOATS; i += 3)
        count += !memcmp(l->rgb + i, view_volumes_influence,
                         sizeof view_volumes_influence);
    CHECK_MSG(count > 50, "%d", count);
    end(l);
}

/* Time that stands still needs no capture, whatever the interval. */
static void settings_count(void)
{
    look *l = begin();

    if (!l)
        return;
    NEED(l->on.stage);
    CHECK(draw(l, 1));
    CHECK(draw(l, 1));
    CHECK(changed(l) < 1e-9);
    l->on.s.parallax = false;
    CHECK(draw(l, 1));
    CHECK(changed(l) > 0.01);
    l->on.s.parallax = true;
    CHECK(draw(l, 1));
    l->on.s.probe_capture = VIEW_PROBE_PARABOLOIDS;
    CHECK(draw(l, 1));
    CHECK_MSG(changed(l) > 0 && changed(l) < 0.2, "%g", changed(l));
    l->on.s.probe_capture = VIEW_PROBE_FACES;
    l->on.s.probe_filter = VIEW_PROBE_CPU;
    CHECK(draw(l, 1));
    l->on.s.probe_filter = VIEW_PROBE_GPU;
    CHECK(draw(l, 1));
    CHECK_MSG(changed(l) > 0 && changed(l) < 0.05, "%g", changed(l));
    l->on.s.probe_size = 64;
    CHECK(draw(l, 1));
    CHECK(changed(l) > 0);
    l->on.s.yaw = 40;
    CHECK(draw(l, 1));
    CHECK(changed(l) > 0.01);
    end(l);
}

static int lines(const char *text)
{
    int count = 0;

    for (; *text; text++)
        count += *text == '\n';
    return count;
}

/* What the library cannot filter it says once, and goes on with what there is,
 * until there is something else to do. */
static void failure_is_said_once(void)
{
    look *l = begin();

    if (!l)
        return;
    NEED(l->on.stage);
    l->on.s.probe_filter = VIEW_PROBE_CPU;
    l->on.s.probe_interval = 0;
    CHECK(draw(l, 0));
    CHECK(draw(l, 1));
    CHECK_NEAR(view_scene_shown(l->on.stage), 1, 0);
    NEED(view_scene_context(l->on.stage));
    ibl_ctx_cancel(view_scene_context(l->on.stage));
    view_test_catch();
    for (int i = 2; i < 8; i++)
        CHECK(draw(l, i));
    const char *said = view_test_caught();
    CHECK_MSG(lines(said) <= 2 && strstr(said, "probe stays"), "%s", said);
    CHECK_NEAR(view_scene_shown(l->on.stage), 1, 0);
    l->on.s.probe_filter = VIEW_PROBE_GPU;
    CHECK(draw(l, 8));
    CHECK(draw(l, 9));
    CHECK_NEAR(view_scene_shown(l->on.stage), 9, 0);
    end(l);
}

/* A sun through the windows is seen in captures with its shadows or without,
 * and no sun is no different from one that is not wanted. */
static void sun_counts(void)
{
    look *l = begin();

    if (!l)
        return;
    NEED(l->on.stage);
    CHECK(draw(l, 1));
    l->on.s.sun = l->on.s.capture_shadows = false;
    CHECK(draw(l, 1));
    CHECK(!memcmp(l->rgb, l->before, sizeof l->rgb));
    l->on.environment.sun = (view_room_sun){.direction = {-0.64, 0.48, 0.6},
                                            .irradiance = {6, 5, 4},
                                            .limit = 9,
                                            .cosine = 0.98};
    CHECK(draw(l, 1));
    CHECK(!memcmp(l->rgb, l->before, sizeof l->rgb));
    l->on.s.sun = true;
    CHECK(draw(l, 1));
    CHECK_MSG(changed(l) > 0.03, "without shadows: %g", changed(l));
    l->on.s.capture_shadows = true;
    CHECK(draw(l, 1));
    CHECK_MSG(changed(l) > 0.03, "with them: %g", changed(l));
    double sum[2] = {0};
    for (int i = 0; i < FLOATS; i++) {
        sum[0] += (double)l->before[i];
        sum[1] += (double)l->rgb[i];
    }
    CHECK_MSG(sum[1] < 0.95 * sum[0], "%g, %g", sum[1], sum[0]);
    end(l);
}

/* The mirror shows what moves with local probes, too, which do not, whether
 * these see the whole room or leave to it what they do not see. */
static void moves_among_locals(void)
{
    look *l = begin();
    float alone[FLOATS];

    if (!l)
        return;
    NEED(l->on.stage);
    CHECK(draw(l, 0));
    memcpy(alone, l->rgb, sizeof alone);
    for (int i = 0; i < 2; i++) {
        l->on.s.probes = 9;
        l->on.s.probe_limit = i;
        CHECK(draw(l, 0));
        CHECK(view_scene_drawn(l->on.stage)->locals.count == 9);
        CHECK(draw(l, 2));
        CHECK_MSG(changed(l) > 0.01, "%g", changed(l));
        /* Where they leave something to the mirror's it is the last. */
        CHECK(view_scene_drawn(l->on.stage)->dynamic.probe.priority ==
              (i ? -1 : 1));
    }
    l->on.s.probes = 0;
    l->on.s.probe_limit = false;
    CHECK(draw(l, 0));
    memcpy(l->before, alone, sizeof alone);
    CHECK_MSG(changed(l) < 1e-6, "%g", changed(l));
    end(l);
}

/* Frames until an update is shown, each with a probe more than the one before,
 * or all of them where there were all. */
static int frames_of_update(look *l, bool all)
{
    const int updates = view_scene_updates(l->on.stage);
    int frames = 0;

    while (view_scene_updates(l->on.stage) == updates && frames < 99) {
        CHECK(draw(l, 1));
        frames++;
        const int count = view_scene_drawn(l->on.stage)->locals.count;
        CHECK_MSG(count == (all ? l->on.s.probes : frames), "%d", count);
    }
    return frames;
}

/* What is then shown is what is captured at once. */
static void locals_are_spread_over_frames(void)
{
    look *l = begin();
    float first[FLOATS], turned[FLOATS];

    if (!l)
        return;
    NEED(l->on.stage);
    l->on.s.probes = 5;
    CHECK(draw(l, 1));
    memcpy(first, l->rgb, sizeof first);
    l->on.s.parallax = false;
    CHECK(draw(l, 1));
    memcpy(turned, l->rgb, sizeof turned);
    l->on.s.spread = true;
    l->on.s.parallax = true;
    CHECK(frames_of_update(l, true) == 5);
    CHECK(!memcmp(l->rgb, first, sizeof first));
    view_scene_drop_captures(l->on.stage);
    CHECK(frames_of_update(l, false) == 5);
    CHECK(!memcmp(l->rgb, first, sizeof first));
    /* Another change begins anew, and a picture waits for nothing. */
    l->on.s.parallax = false;
    CHECK(draw(l, 1) && draw(l, 1));
    CHECK(memcmp(l->rgb, turned, sizeof turned));
    l->on.s.parallax = true;
    CHECK(frames_of_update(l, true) == 5);
    CHECK(!memcmp(l->rgb, first, sizeof first));
    l->on.s.parallax = false;
    CHECK(draw(l, 1));
    l->on.s.spread = false;
    CHECK(draw(l, 1));
    CHECK(!memcmp(l->rgb, turned, sizeof turned));
    end(l);
}

static void camera_stays_inside(void)
{
    view_settings s = view_settings_default();

    s.distance = 1000;
    for (s.yaw = 0; s.yaw < 360; s.yaw += 30)
        for (s.pitch = -89; s.pitch < 90; s.pitch += 44) {
            const view_camera c = view_scene_camera(&s, 16, 9);
            for (int k = 0; k < 3; k++)
                CHECK(fabs(c.eye[k] - view_room_centre[k]) <
                      view_room_half[k] - 0.1);
        }
}

static const test tests[] = {
    TEST(follows_within_the_interval),
    TEST(is_spread_over_frames),
    TEST(light_bounces_three_times),
    TEST(wires_are_seen),
    TEST(settings_count),
    TEST(sun_counts),
    TEST(failure_is_said_once),
    TEST(moves_among_locals),
    TEST(locals_are_spread_over_frames),
    TEST(camera_stays_inside),
};
TEST_MAIN(tests)
