/* SPDX-License-Identifier: MIT */
/* --mode scene: its probe follows what moves within the interval, at once or a
 * face at a time, and settings change the picture. */
#include "room.h"
#include "sets.h"
#include "view.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "view/scene_captures.h"

enum {
    WIDTH = 96,
    HEIGHT = 64,
    FLOATS = 3 * WIDTH * HEIGHT
};

/* The stage, and pictures of it. */
static room_stage on;
static float rgb[FLOATS], before[FLOATS];

static void begin(void)
{
    static const float light[3] = {0.5F, 0.6F, 0.8F}, table[2] = {0.9F, 0.05F};

    room_stage_begin(&on, WIDTH, HEIGHT, light, table);
    on.s.probe_size = 32;
}

static void draw(double seconds)
{
    memcpy(before, rgb, sizeof rgb);
    on.s.seconds = seconds;
    const float *rgba = room_stage_draw(&on);
    NEED(rgba);
    for (int i = 0; i < FLOATS; i++)
        rgb[i] = rgba[4 * (i / 3) + i % 3];
}

/* Mean difference of what is in the middle, in the mirror. */
static double changed(void)
{
    double sum = 0;
    int count = 0;

    for (int y = HEIGHT / 2 - 6; y < HEIGHT / 2 + 6; y++)
        for (int x = 3 * (WIDTH / 2 - 6); x < 3 * (WIDTH / 2 + 6); x++) {
            const int i = 3 * WIDTH * y + x;
            sum += fabs((double)rgb[i] - (double)before[i]);
            count++;
        }
    return sum / count;
}

/* A capture within the interval is nearly that of a stage made then. */
TEST(follows_within_the_interval)
{
    float late[FLOATS], stale[FLOATS];

    begin();
    draw(0);
    CHECK_NEAR(view_scene_state_of(on.stage)->shown, 0, 0);
    draw(0.4);
    CHECK_NEAR(view_scene_state_of(on.stage)->shown, 0, 0);
    draw(0.5);
    CHECK_NEAR(view_scene_state_of(on.stage)->shown, 0.5, 0);
    draw(0.9);
    CHECK_NEAR(view_scene_state_of(on.stage)->shown, 0.5, 0);
    /* A jump is followed: the mirror has the lamp where it is then. */
    draw(2);
    CHECK(changed() > 0.01);
    on.s.probe_interval = 9;
    draw(2.6);
    memcpy(stale, rgb, sizeof stale);
    on.s.probe_interval = 0.5;
    draw(2.6);
    memcpy(late, rgb, sizeof late);
    view_scene_use(on.stage, NULL);
    draw(2.6);
    /* Only the light's later bounces are behind. */
    memcpy(before, stale, sizeof stale);
    const double behind = changed();
    memcpy(before, late, sizeof late);
    CHECK_MSG(changed() < 0.25 * behind, "%g, %g", changed(), behind);
    on.s.probe_interval = 0;
    draw(2.7);
    CHECK_NEAR(view_scene_state_of(on.stage)->shown, 2.7, 0);
    /* Time that goes back is another one at once. */
    on.s.probe_interval = 9;
    draw(1);
    CHECK_NEAR(view_scene_state_of(on.stage)->shown, 1, 0);
}

/* A face at a time it takes many frames, which all show the last whole one,
 * and then gives what all at once gives. */
TEST(is_spread_over_frames)
{
    int frames = 1;

    begin();
    draw(0);
    on.s.probe_faces = 1;
    draw(1);
    for (; frames < 200 && view_scene_state_of(on.stage)->shown < 1; frames++) {
        CHECK(frames < 2 || !memcmp(rgb, before, sizeof rgb));
        draw(1);
    }
    CHECK_MSG(frames > 12 && frames < 200, "%d", frames);
    CHECK_NEAR(view_scene_state_of(on.stage)->shown, 1, 0);
    draw(1);
    float spread[FLOATS];
    memcpy(spread, rgb, sizeof spread);
    view_scene_use(on.stage, NULL);
    draw(0);
    on.s.probe_faces = 0;
    draw(1);
    memcpy(before, spread, sizeof spread);
    CHECK_MSG(changed() < 1e-6, "%g", changed());
}

static PFNGLCLEARPROC real_clear;
static int pictures;

static void APIENTRY count_clear(GLbitfield mask)
{
    pictures += mask == GL_DEPTH_BUFFER_BIT;
    real_clear(mask);
}

/* Six faces for each of three bounces of light, then of each local probe and of
 * the mirror, and the picture itself; only that where nothing is new. */
TEST_SLOW(light_bounces_three_times)
{
    begin();
    real_clear = gl.Clear;
    gl.Clear = count_clear;
    for (int locals = 0; locals < 3; locals++) {
        on.s.probes = locals;
        pictures = 0;
        draw(1);
        const int all = 6 * (3 + (locals ? locals + 1 : 0)) + 1;
        CHECK_MSG(pictures == all, "%d, %d", locals, pictures);
        draw(1);
        CHECK(pictures == all + 1);
    }
    /* So with each setting by which light is another. */
    on.s.probes = 0;
    draw(1);
    bool *const switches[] = {&on.s.parallax, &on.s.blend,
                              &on.s.capture_shadows};
    for (int i = 0; i < 4; i++) {
        if (i < 3)
            *switches[i] = !*switches[i];
        else
            on.s.turn = 15;
        pictures = 0;
        draw(1);
        CHECK_MSG(pictures == 6 * 3 + 1, "setting %d: %d", i, pictures);
    }
    gl.Clear = real_clear;
}

/* Of a volume that goes beyond the walls wires are in the room. */
TEST(wires_are_seen)
{
    begin();
    on.s.volumes = true;
    on.s.fov = 100;
    draw(1);
    int count = 0;
    for (int i = 0; i < FLOATS; i += 3)
        count += !memcmp(rgb + i, view_volumes_influence,
                         sizeof view_volumes_influence);
    CHECK_MSG(count > 50, "%d", count);
}

/* A sun through the windows is seen in captures with its shadows or without,
 * which make no difference where there is none. */
TEST(sun_counts)
{
    view_frame *f = &on.environment.frame;

    begin();
    draw(1);
    on.s.capture_shadows = false;
    draw(1);
    CHECK(!memcmp(rgb, before, sizeof rgb));
    memcpy(f->disc_direction[0], (float[3]){-0.64F, 0.48F, 0.6F}, 12);
    memcpy(f->disc_irradiance[0], (float[3]){6, 5, 4}, 12);
    f->reflection[2] = 1;
    view_scene_use(on.stage, NULL);
    draw(1);
    CHECK_MSG(changed() > 0.03, "without shadows: %g", changed());
    on.s.capture_shadows = true;
    draw(1);
    CHECK_MSG(changed() > 0.03, "with them: %g", changed());
    double sum[2] = {0};
    for (int i = 0; i < FLOATS; i++) {
        sum[0] += (double)before[i];
        sum[1] += (double)rgb[i];
    }
    CHECK_MSG(sum[1] < 0.95 * sum[0], "%g, %g", sum[1], sum[0]);
}

/* With local probes, which do not, the mirror shows what moves, too. Its probe
 * is before those, or where it is told to be; without them it is as before. */
TEST_SLOW(moves_among_locals)
{
    float alone[FLOATS];

    begin();
    draw(0);
    memcpy(alone, rgb, sizeof alone);
    on.s.probes = 4;
    draw(0);
    CHECK(view_scene_state_of(on.stage)->draw.locals.count == 4);
    CHECK(view_scene_state_of(on.stage)->draw.dynamic.probe->priority == 1);
    draw(2);
    CHECK_MSG(changed() > 0.01, "%g", changed());
    on.s.probes = 0;
    draw(0);
    memcpy(before, alone, sizeof alone);
    CHECK_MSG(changed() < 1e-6, "%g", changed());
    on.s.probes = 4;
    on.s.mirror_priority = -3;
    view_scene_use(on.stage, NULL);
    draw(0);
    CHECK(view_scene_state_of(on.stage)->draw.dynamic.probe->priority == -3);
}

/* Of the texels of a local probe's cube those that have not the alpha of what a
 * ray meets: 1 before the far plane of its face, else 0. *seen: of all. */
static double wrong_alpha(const float *rgba, int size, int i, double *seen)
{
    const view_room_draw *draw = &view_scene_state_of(on.stage)->draw;
    const ibl_probe *p = &draw->locals.probe[i];
    view_room_draw still = *draw;
    double far = 0, wrong = 0;

    still.moving = false;
    for (int k = 0; k < 3; k++)
        far += pow(fabs(p->position[k] - p->influence.centre[k]) +
                       p->influence.half[k],
                   2);
    for (int t = 0; t < IBL_FACES * size * size; t++) {
        const int face = t / size / size;
        double d[3];
        ibl_cube_direction(size, face, t % size, t / size % size, d);
        const room_hit hit = room_cast(&still, p->position, d);
        const bool near = hit.what >= 0 &&
                          hit.distance * fabs(d[face / 2]) < 1.01 * sqrt(far);
        *seen += near;
        wrong += !(fabsf(rgba[4 * t + 3] - (near ? 1 : 0)) < 1e-3F);
    }
    return wrong / (IBL_FACES * size * size);
}

/* Captures that end at the box of a local probe have alpha 0 beyond, where the
 * mirror's fills in: the white environment does not light the dark room. */
TEST_SLOW(limited_captures)
{
    const int size = 32, texels = IBL_FACES * size * size;
    float full[FLOATS];
    double sum = 0, off = 0, seen = 0;

    begin();
    on.s.probes = 9;
    draw(0);
    memcpy(full, rgb, sizeof full);
    on.s.probe_limit = true;
    draw(0);
    const view_room_draw *drawn = &view_scene_state_of(on.stage)->draw;
    const float *rgba = room_cubes_read(drawn->locals.specular, 9, 0, size);
    for (int i = 0; i < 9; i++) {
        const double wrong = wrong_alpha(rgba + 4 * texels * i, size, i, &seen);
        CHECK_MSG(wrong < 0.02, "probe %d: %g of the texels", i, wrong);
    }
    CHECK_MSG(seen < 0.95 * 9 * texels, "%g of %d", seen, 9 * texels);
    for (int i = 0; i < FLOATS; i++) {
        sum += (double)full[i];
        off += fabs((double)rgb[i] - (double)full[i]);
    }
    CHECK_MSG(off < 0.1 * sum, "%g of %g", off, sum);
    CHECK(drawn->dynamic.probe->priority == -1);
}

/* Frames until an update is shown, each with a probe more than the one before,
 * or all of them where there were all. */
static int frames_of_update(bool all)
{
    const int updates = view_scene_state_of(on.stage)->updates;
    int frames = 0;

    while (view_scene_state_of(on.stage)->updates == updates && frames < 99) {
        draw(1);
        frames++;
        const int count = view_scene_state_of(on.stage)->draw.locals.count;
        CHECK_MSG(count == (all ? on.s.probes : frames), "%d", count);
    }
    return frames;
}

/* What is then shown is what is captured at once. */
TEST_SLOW(locals_are_spread_over_frames)
{
    float first[FLOATS], turned[FLOATS];

    begin();
    on.s.probes = 5;
    draw(1);
    memcpy(first, rgb, sizeof first);
    on.s.parallax = false;
    draw(1);
    memcpy(turned, rgb, sizeof turned);
    on.s.spread = true;
    on.s.parallax = true;
    CHECK(frames_of_update(true) == 5);
    CHECK(!memcmp(rgb, first, sizeof first));
    on.s.probes = 4;
    draw(1);
    on.s.probes = 5;
    CHECK(frames_of_update(false) == 5);
    CHECK(!memcmp(rgb, first, sizeof first));
    /* Another change begins anew, and a picture waits for nothing. */
    on.s.parallax = false;
    draw(1);
    draw(1);
    CHECK(memcmp(rgb, turned, sizeof turned));
    on.s.parallax = true;
    CHECK(frames_of_update(true) == 5);
    CHECK(!memcmp(rgb, first, sizeof first));
    on.s.parallax = false;
    draw(1);
    on.s.spread = false;
    draw(1);
    CHECK(!memcmp(rgb, turned, sizeof turned));
}

TEST(camera_stays_inside)
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
