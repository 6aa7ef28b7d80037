/* SPDX-License-Identifier: MIT */
/* --mode scene: its probe follows what moves within the interval; captures that
 * end, a model in the room, and places in pixels. */
#include "room.h"
#include "sets.h"
#include "shade.h"
#include "view.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "view/room.h"

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
    on.s.probe_size = 1;
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

/* What is shown is of the last capture, which an interval and a jump end; time
 * that goes back is another one at once. */
TEST(follows_within_the_interval)
{
    static const struct {
        double interval, seconds, shown;
    } frames[] = {{0.5, 0, 0},     {0.5, 0.4, 0}, {0.5, 0.5, 0.5},
                  {0.5, 0.9, 0.5}, {0.5, 2, 2},   {9, 2.6, 2},
                  {0.5, 2.6, 2.6}, {0, 2.7, 2.7}, {9, 1, 1}};

    begin();
    for (size_t i = 0; i < sizeof frames / sizeof *frames; i++) {
        on.s.probe_interval = frames[i].interval;
        draw(frames[i].seconds);
        CHECK_NEAR(on.stage->shown, frames[i].shown, 0);
    }
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
    gl.Clear = real_clear;
}

/* The mirror shows what moves, alone and with local probes, which do not. Its
 * probe is before those. */
TEST_SLOW(moves_among_locals)
{
    begin();
    for (on.s.probes = 0; on.s.probes <= 4; on.s.probes += 4) {
        draw(0);
        CHECK(on.stage->draw.locals.count == on.s.probes);
        CHECK(!on.s.probes || on.stage->draw.dynamic.probe->priority == 1);
        draw(2);
        CHECK_MSG(changed() > 0.01, "%d: %g", on.s.probes, changed());
    }
}

/* Of the texels of a local probe's cube those that have not the alpha of what a
 * ray meets: 1 before the far plane of its face, else 0. *seen: of all. */
static double wrong_alpha(const float *rgba, int size, int i, double *seen)
{
    const view_room_draw *draw = &on.stage->draw;
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
 * mirror's fills in. */
TEST_SLOW(limited_captures)
{
    const int size = 32, texels = IBL_FACES * size * size;
    double seen = 0;

    begin();
    on.s.probes = 9;
    on.s.probe_limit = true;
    draw(0);
    const view_room_draw *drawn = &on.stage->draw;
    const float *rgba = room_cubes_read(drawn->locals.specular, 9, 0, size);
    for (int i = 0; i < 9; i++) {
        const double wrong = wrong_alpha(rgba + 4 * texels * i, size, i, &seen);
        CHECK_MSG(wrong < 0.02, "probe %d: %g of the texels", i, wrong);
    }
    CHECK_MSG(seen < 0.95 * 9 * texels, "%g of %d", seen, 9 * texels);
    CHECK(drawn->dynamic.probe->priority == -1);
}

/* Spread over frames, each has a probe more than the one before, and then what
 * is shown is what is captured at once; another change begins anew. */
TEST_SLOW(locals_are_spread_over_frames)
{
    float first[FLOATS];

    begin();
    on.s.probes = 5;
    draw(1);
    memcpy(first, rgb, sizeof first);
    on.s.spread = true;
    for (int again = 0; again < 2; again++) {
        int frames = 0;
        on.s.probes = 4;
        draw(1);
        on.s.probes = 5;
        const int updates = on.stage->updates;
        for (; frames < 99 && on.stage->updates == updates; frames++) {
            draw(1);
            CHECK(on.stage->draw.locals.count == frames + 1);
        }
        CHECK_MSG(frames == 5 && !memcmp(rgb, first, sizeof first), "%d",
                  frames);
        on.s.parallax = VIEW_PARALLAX_NONE;
        draw(1);
        on.s.parallax = VIEW_PARALLAX_BOX;
    }
}

/* ---- what stands in place of the mirror -----------------------------------
 */

/* A flat ball, of half the height of the mirror's top, stands on the floor;
 * captures, and so the light of the rest, are as if nothing was there. */
TEST(a_model_stands_in_the_room)
{
    const size_t cube = (size_t)4 * IBL_FACES * 32 * 32;
    const view_room_draw *d = NULL;
    const float *seen[2];
    int bad = 0, ball = 0;

    begin();
    on.guest = shade_ball(0.5);
    NEED(on.guest);
    for (int i = 0; i < 2; i++) {
        draw(1);
        d = &on.stage->draw;
        seen[i] = room_cubes_read(d->dynamic.specular, 2, 0, 32) +
                  cube * d->dynamic.probe->layer;
        CHECK(d->mirror == i && (d->guest == NULL) == i);
        view_model_free(on.guest);
        on.guest = NULL;
    }
    CHECK(!memcmp(seen[0], seen[1], cube * sizeof *seen[0]));
    for (int i = 0; i < WIDTH * HEIGHT; i++) {
        double ray[3], to[3];
        view_test_ray(&d->camera, WIDTH, HEIGHT, i % WIDTH, i / WIDTH, ray);
        const room_hit h = room_cast(d, d->camera.eye, ray);
        for (int k = 0; k < 3; k++)
            to[k] = (k == 1 ? 0.75 - 2 * d->camera.eye[k] : -d->camera.eye[k]);
        ray[1] *= 2;
        const double along = test_dot(to, ray) / sqrt(test_dot(ray, ray));
        const double miss = sqrt(test_dot(to, to) - along * along) - 0.75;
        if (fabs(miss) < 0.05 || h.what == VIEW_ROOM_BOXES)
            continue;
        ball += miss < 0;
        bad += (memcmp(before + 3 * i, rgb + 3 * i, 12) != 0) != (miss < 0);
    }
    CHECK_MSG(ball > 20 && bad < 9, "%d, %d", ball, bad);
}

/* Lights that were taken out of the environment's maps are left out, which is
 * said once. */
TEST(lights_are_left_out)
{
    float without[FLOATS];

    begin();
    draw(0);
    memcpy(without, rgb, sizeof without);
    for (int k = 0; k < 3; k++)
        on.environment.frame.disc_irradiance[0][k] = 9;
    on.environment.frame.disc_direction[0][1] = 1;
    on.environment.frame.reflection[2] = 1;
    on.environment.frame.reflection[3] = 1;
    view_scene_use(on.stage, NULL);
    view_test_catch();
    draw(0);
    draw(0);
    const char *said = view_test_caught();
    CHECK_MSG(strstr(said, "1 light ") &&
                  strchr(said, '\n') == said + strlen(said) - 1,
              "%s", said);
    CHECK(!memcmp(rgb, without, sizeof rgb));
}

/* ---- for the user interface ------------------------------------------------
 */

/* The probe under a pixel is that with most weight where a ray meets the room.
 */
TEST(probe_under_a_pixel)
{
    double w[IBL_MAX_PROBES + 2], weight;
    int named[6] = {0};

    begin();
    on.s.probes = 4;
    on.s.fov = 110;
    draw(1);
    const view_room_draw *d = &on.stage->draw;
    for (int i = 0; i < WIDTH * HEIGHT; i += 13) {
        double ray[3];
        int best = 5;
        view_test_ray(&d->camera, WIDTH, HEIGHT, i % WIDTH, i / WIDTH, ray);
        const room_hit h = room_cast(d, d->camera.eye, ray);
        const int probe = view_scene_probe_at(on.stage, &on.s, WIDTH, HEIGHT,
                                              i % WIDTH, i / WIDTH, &weight);
        CHECK((h.what < 0) == (probe == VIEW_SCENE_NOWHERE));
        if (h.what < 0)
            continue;
        room_weights(d, h.point, NULL, w);
        for (int p = 0; p < 5; p++)
            best = w[p] > w[best] ? p : best;
        CHECK(probe == (best == 5 ? -1 : best));
        CHECK_NEAR(weight, w[best], 0.02);
        named[best]++;
    }
    CHECK(named[0] && named[1] && named[2] && named[3] && named[4]);
}

TEST(camera_stays_inside)
{
    view_settings s = view_settings_default();

    s.distance = 1000;
    for (s.yaw = 0; s.yaw < 360; s.yaw += 30)
        for (s.pitch = -89; s.pitch < 90; s.pitch += 44) {
            const view_camera c = view_scene_camera(&s, 16, 9);
            for (int k = 0; k < 3; k++)
                CHECK(fabs(c.eye[k] - view_room_inside.centre[k]) <
                      view_room_inside.half[k] - 0.1);
        }
}

/* ---- through the renderer --------------------------------------------------
 */

/* Of a set whose faces have a colour each, a mirror shows only these colours
 * with seams, and mixes of two without. */
TEST(seams)
{
    static const float rgb0[3] = {1, 1, 1};
    shade_set *set = &shade_sets[0];
    int mixed[2] = {0};

    shade_begin(WIDTH, HEIGHT);
    shade_constant(set, rgb0);
    shade_constant(&shade_sets[1], rgb0);
    for (int l = 0; l < set->specular.levels; l++) {
        const int n = ibl_cube_edge(set->specular.size, l);
        for (int i = 0; i < 3 * IBL_FACES * n * n; i++)
            ibl_cube_face(&set->specular, l, 0)[i] =
                (float)(1 + i / (3 * n * n));
    }
    shade_pack(set, IBL_PIXEL_RGBA32F, IBL_PIXEL_RG32F);
    view_settings s = view_settings_default();
    s.reflection = VIEW_SPLIT_SUM;
    s.multiscatter = false;
    s.rows = s.columns = s.antialias = 1;
    s.metallic[0] = s.roughness[0] = 1;
    for (int i = 0; i < 2; i++) {
        s.seams = i;
        const float *white = shade_draw(&shade_sets[1].set, &s);
        const float *p = shade_draw(&set->set, &s);
        for (int y = HEIGHT / 2 - 12; y < HEIGHT / 2 + 12; y++)
            for (int x = WIDTH / 2 - 12; x < WIDTH / 2 + 12; x++) {
                const int k = 3 * (y * WIDTH + x);
                const float face = p[k] / white[k];
                mixed[i] += fabsf(face - roundf(face)) > 0.02F;
            }
    }
    CHECK_MSG(mixed[0] > 20 && !mixed[1], "%d, %d", mixed[0], mixed[1]);
}

/* While time stands still places in the pixels are added, and then the picture
 * stays; another time begins anew. */
TEST(places_while_time_stands)
{
    static const float grey[3] = {0.5F, 0.5F, 0.5F};
    view_settings s = view_settings_default();
    view_renderer *r = shade_begin(WIDTH, HEIGHT);
    const float *last = NULL;

    shade_constant(&shade_sets[0], grey);
    NEED(view_renderer_load(r, &shade_sets[0].set));
    s.mode = VIEW_SCENE;
    s.antialias = 2;
    s.probe_size = 0;
    for (int i = 0; i < 9; i++) {
        s.seconds = i < 5 ? 0 : 1;
        NEED(view_test_draw(r, &s, WIDTH, HEIGHT));
        CHECK_MSG(view_renderer_complete(r) == (i % 5 >= 3), "draw %d", i);
        float *now = test_alloc(FLOATS, sizeof *now);
        NEED(view_renderer_read(r, 0, now));
        if (i == 1 || i == 5)
            CHECK(memcmp(now, last, FLOATS * sizeof *now));
        CHECK(i != 4 || !memcmp(now, last, FLOATS * sizeof *now));
        last = now;
    }
}
