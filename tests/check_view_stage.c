/* SPDX-License-Identifier: MIT */
/* --mode scene: its probe follows what moves within the interval, at once or a
 * face at a time, and settings change the picture. */
#include "room.h"
#include "view.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "view/program.h"
#include "view/stage.h"

enum {
    WIDTH = 96,
    HEIGHT = 64,
    FLOATS = 3 * WIDTH * HEIGHT
};

/* The stage by a uniform environment, and pictures of it. */
typedef struct look {
    view_stage *stage;
    view_settings s;
    view_room_environment environment;
    GLuint table;
    room_target target;
    float rgb[FLOATS], before[FLOATS];
} look;

static look *begin(void)
{
    look *l = calloc(1, sizeof *l);

    if (!l || !view_test_begin(WIDTH, HEIGHT)) {
        free(l);
        return NULL;
    }
    const GLuint grey = room_cube_of(0.5F, 0.6F, 0.8F, 1);
    l->s = view_settings_default();
    l->s.mode = VIEW_SCENE;
    l->s.probe_size = 32;
    l->environment = (view_room_environment){.specular = grey,
                                             .irradiance = grey,
                                             .sky = grey,
                                             .irradiance_scale = 1};
    l->table = room_table_of(0.9F, 0.05F);
    room_target_make(&l->target, WIDTH, HEIGHT);
    l->stage = view_stage_create();
    return l;
}

static void end(look *l)
{
    if (!l)
        return;
    view_stage_free(l->stage);
    room_target_free(&l->target);
    view_test_end();
    free(l);
}

static bool draw(look *l, double seconds)
{
    memcpy(l->before, l->rgb, sizeof l->rgb);
    l->s.seconds = seconds;
    if (!view_stage_draw(l->stage, &l->s, &l->environment, l->table,
                         l->target.colour, WIDTH, HEIGHT))
        return false;
    float *rgba = room_target_read(&l->target);
    for (int i = 0; i < FLOATS; i++)
        l->rgb[i] = rgba[4 * (i / 3) + i % 3];
    free(rgba);
    return true;
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
    NEED(l->stage);
    CHECK(draw(l, 0));
    CHECK_NEAR(view_stage_shown(l->stage), 0, 0);
    CHECK(draw(l, 0.4));
    CHECK_NEAR(view_stage_shown(l->stage), 0, 0);
    CHECK(draw(l, 0.5));
    CHECK_NEAR(view_stage_shown(l->stage), 0.5, 0);
    CHECK(draw(l, 0.9));
    CHECK_NEAR(view_stage_shown(l->stage), 0.5, 0);
    /* A jump is followed: the mirror has the lamp where it is then. */
    CHECK(draw(l, 2));
    CHECK(changed(l) > 0.01);
    l->s.probe_interval = 9;
    CHECK(draw(l, 2.6));
    memcpy(stale, l->rgb, sizeof stale);
    l->s.probe_interval = 0.5;
    CHECK(draw(l, 2.6));
    memcpy(late, l->rgb, sizeof late);
    view_stage_restart(l->stage);
    CHECK(draw(l, 2.6));
    /* Only the light's later bounces are behind. */
    memcpy(l->before, stale, sizeof stale);
    const double behind = changed(l);
    memcpy(l->before, late, sizeof late);
    CHECK_MSG(changed(l) < 0.25 * behind, "%g, %g", changed(l), behind);
    l->s.probe_interval = 0;
    CHECK(draw(l, 2.7));
    CHECK_NEAR(view_stage_shown(l->stage), 2.7, 0);
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
    NEED(l->stage);
    CHECK(draw(l, 0));
    l->s.probe_faces = 1;
    CHECK(draw(l, 1));
    for (; frames < 200 && view_stage_shown(l->stage) < 1; frames++)
        CHECK(draw(l, 1));
    CHECK_MSG(frames > 12 && frames < 200, "%d", frames);
    CHECK_NEAR(view_stage_shown(l->stage), 1, 0);
    CHECK(draw(l, 1));
    float spread[FLOATS];
    memcpy(spread, l->rgb, sizeof spread);
    view_stage_restart(l->stage);
    CHECK(draw(l, 0));
    l->s.probe_faces = 0;
    CHECK(draw(l, 1));
    memcpy(l->before, spread, sizeof spread);
    CHECK_MSG(changed(l) < 1e-6, "%g", changed(l));
    end(l);
}

/* Time that stands still needs no capture, whatever the interval. */
static void settings_count(void)
{
    look *l = begin();

    if (!l)
        return;
    NEED(l->stage);
    CHECK(draw(l, 1));
    CHECK(draw(l, 1));
    CHECK(changed(l) < 1e-9);
    l->s.parallax = false;
    CHECK(draw(l, 1));
    CHECK(changed(l) > 0.01);
    l->s.parallax = true;
    CHECK(draw(l, 1));
    l->s.probe_capture = VIEW_PROBE_PARABOLOIDS;
    CHECK(draw(l, 1));
    CHECK_MSG(changed(l) > 0 && changed(l) < 0.2, "%g", changed(l));
    l->s.probe_capture = VIEW_PROBE_FACES;
    l->s.probe_filter = VIEW_PROBE_CPU;
    CHECK(draw(l, 1));
    l->s.probe_filter = VIEW_PROBE_GPU;
    CHECK(draw(l, 1));
    CHECK_MSG(changed(l) > 0 && changed(l) < 0.05, "%g", changed(l));
    l->s.probe_size = 64;
    CHECK(draw(l, 1));
    CHECK(changed(l) > 0);
    l->s.yaw = 40;
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
    NEED(l->stage);
    l->s.probe_filter = VIEW_PROBE_CPU;
    l->s.probe_interval = 0;
    CHECK(draw(l, 0));
    CHECK(draw(l, 1));
    CHECK_NEAR(view_stage_shown(l->stage), 1, 0);
    NEED(view_stage_context(l->stage));
    ibl_ctx_cancel(view_stage_context(l->stage));
    view_test_catch();
    for (int i = 2; i < 8; i++)
        CHECK(draw(l, i));
    const char *said = view_test_caught();
    CHECK_MSG(lines(said) <= 2 && strstr(said, "probe stays"), "%s", said);
    CHECK_NEAR(view_stage_shown(l->stage), 1, 0);
    l->s.probe_filter = VIEW_PROBE_GPU;
    CHECK(draw(l, 8));
    CHECK(draw(l, 9));
    CHECK_NEAR(view_stage_shown(l->stage), 9, 0);
    end(l);
}

/* A sun through the windows is seen in captures with its shadows or without,
 * and no sun is no different from one that is not wanted. */
static void sun_counts(void)
{
    look *l = begin();

    if (!l)
        return;
    NEED(l->stage);
    CHECK(draw(l, 1));
    l->s.sun = l->s.capture_shadows = false;
    CHECK(draw(l, 1));
    CHECK(!memcmp(l->rgb, l->before, sizeof l->rgb));
    l->environment.sun = (view_room_sun){.direction = {-0.64, 0.48, 0.6},
                                         .irradiance = {6, 5, 4},
                                         .limit = 9,
                                         .cosine = 0.98};
    CHECK(draw(l, 1));
    CHECK(!memcmp(l->rgb, l->before, sizeof l->rgb));
    l->s.sun = true;
    CHECK(draw(l, 1));
    CHECK_MSG(changed(l) > 0.03, "without shadows: %g", changed(l));
    l->s.capture_shadows = true;
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
    NEED(l->stage);
    CHECK(draw(l, 0));
    memcpy(alone, l->rgb, sizeof alone);
    for (int i = 0; i < 2; i++) {
        l->s.probes = 9;
        l->s.probe_limit = i;
        CHECK(draw(l, 0));
        CHECK(view_stage_drawn(l->stage)->locals.count == 9);
        CHECK(draw(l, 2));
        CHECK_MSG(changed(l) > 0.01, "%g", changed(l));
    }
    l->s.probes = 0;
    l->s.probe_limit = false;
    CHECK(draw(l, 0));
    memcpy(l->before, alone, sizeof alone);
    CHECK_MSG(changed(l) < 1e-6, "%g", changed(l));
    end(l);
}

static void camera_stays_inside(void)
{
    view_settings s = view_settings_default();

    s.distance = 1000;
    for (s.yaw = 0; s.yaw < 360; s.yaw += 30)
        for (s.pitch = -89; s.pitch < 90; s.pitch += 44) {
            const view_camera c = view_stage_camera(&s, 16, 9);
            for (int k = 0; k < 3; k++)
                CHECK(fabs(c.eye[k] - view_room_centre[k]) <
                      view_room_half[k] - 0.1);
        }
}

static const test tests[] = {
    TEST(follows_within_the_interval),
    TEST(is_spread_over_frames),
    TEST(settings_count),
    TEST(sun_counts),
    TEST(failure_is_said_once),
    TEST(moves_among_locals),
    TEST(camera_stays_inside),
};
TEST_MAIN(tests)
