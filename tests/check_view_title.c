/* SPDX-License-Identifier: MIT */
/* What the window's title tells: the controls that were changed; how long a
 * capture took; --stats; and what is drawn where there is no room for what was
 * asked for. */
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "common/process.h"
#include "sets.h"
#include "test.h"
#include "view.h"
#include "view/app.h"
#include "view/gl.h"
#include "view/key_bindings.h"

enum {
    WIDTH = 32,
    HEIGHT = 24
};

/* Everyone's clock, and how much it goes on by whenever it is looked at. */
static double now, tick;

double __wrap_ibl_now(void);

double __wrap_ibl_now(void)
{
    return now += tick;
}

static view_app app;
static view_options options;
static const char *const title = app.title;

static void end(void *unused)
{
    (void)unused;
    view_renderer_free(app.renderer);
}

static void begin(void)
{
    view_test_begin(WIDTH, HEIGHT);
    view_test_app(&app, &options, WIDTH, HEIGHT);
    app.settings.mode = VIEW_SCENE;
    app.settings.probe_size = 16;
    app.renderer = view_renderer_create();
    test_defer(end, NULL);
    NEED(app.renderer && view_renderer_load(app.renderer, app.set));
}

static bool has(const char *part)
{
    return strstr(title, part) != NULL;
}

/* Each step of an update takes a millisecond: six faces or two paraboloids are
 * drawn; what is looked up is made, and six faces of each level; and six of
 * irradiance. An update is not longer than the one before. */
TEST(times_are_of_one_update)
{
    begin();
    tick = 1e-3;
    const int levels = 1 + 6 * (ibl_default_levels(16) - 1);
    for (int i = 0; i < 4; i++) {
        app.settings.probe_capture = (view_probe_capture)(i / 2);
        app.settings.seconds = i;
        CHECK(view_renderer_draw(app.renderer, &app.settings, WIDTH, HEIGHT));
        const double *ms =
            view_scene_state_of(view_renderer_stage(app.renderer))->ms;
        CHECK_NEAR(ms[0], i < 2 ? 6 : 2, 1e-6);
        CHECK_NEAR(ms[1], levels, 1e-6);
        CHECK_NEAR(ms[2], 6, 1e-6);
    }
    tick = 0;
}

/* The title has part after a change and had not before. */
static void tells(const view_settings *changed, const char *part)
{
    app.settings = view_settings_default();
    app.settings.mode = changed->mode;
    view_app_title(&app);
    CHECK_MSG(!has(part), "%s", title);
    app.settings = *changed;
    view_app_title(&app);
    CHECK_MSG(has(part), "not \"%s\": %s", part, title);
}

#define TELLS(where, what, value, part)                                        \
    do {                                                                       \
        view_settings changed = view_settings_default();                       \
        changed.mode = (where);                                                \
        changed.what = (value);                                                \
        tells(&changed, part);                                                 \
    } while (0)

/* Each in the modes that it matters to. */
TEST(tells_what_changed)
{
    begin();
    for (int i = 0; i < 2; i++) {
        const view_mode mode = i ? VIEW_SCENE : VIEW_SPHERES;
        TELLS(mode, turn, -20, "| environment -20 |");
        TELLS(mode, turn, 3600, "| environment 3600 |");
        TELLS(mode, ev, 2, "| exposure 2 |");
        TELLS(mode, tone, VIEW_TONE_ACES, "| tone aces |");
        TELLS(mode, false_colour, true, "| false colour on |");
    }
    TELLS(VIEW_SPHERES, material, 1, view_materials[1].name);
    TELLS(VIEW_SPHERES, rows, 3, "| rows 3 |");
    TELLS(VIEW_SPHERES, columns, 3, "| columns 3 |");
    TELLS(VIEW_SPHERES, metallic[0], 0.5, "| metallic from 0.5 |");
    TELLS(VIEW_SPHERES, roughness[1], 0.5, "| roughness to 0.5 |");
    TELLS(VIEW_SPHERES, diffuse, VIEW_DIFFUSE_SH, "| diffuse sh |");
    TELLS(VIEW_SPHERES, light_count, 2, "| lights 2 |");
    TELLS(VIEW_SPHERES, sky, false, "| sky off |");
    TELLS(VIEW_MODEL, reflection, VIEW_FIT, "| mode model | reflection fit |");
    TELLS(VIEW_SPHERES, compare, VIEW_SPLIT, "| compare split |");
    TELLS(VIEW_LEVELS, level, 1, "| level 1 |");
    TELLS(VIEW_LEVELS, layout, VIEW_STRIP, "| layout strip |");
    TELLS(VIEW_SCENE, parallax, false, "| parallax off |");
    TELLS(VIEW_SCENE, probes, 8, "| probes 8 |");
    TELLS(VIEW_SCENE, walls, false, "| walls off |");
    TELLS(VIEW_SCENE, volumes, true, "| volumes on |");
    /* A name is what it is, but on one line. */
    app.sets[0].name[1] = '\n';
    view_app_title(&app);
    CHECK_MSG(strstr(title, "m?p | ") == title, "%s", title);
}

/* ---- without room ------------------------------------------------------- */

static PFNGLTEXIMAGE3DPROC real_image;
static int most_layers;

static void APIENTRY scarce_image(GLenum target, GLint level, GLint format,
                                  GLsizei width, GLsizei height, GLsizei depth,
                                  GLint border, GLenum from, GLenum type,
                                  const void *pixels)
{
    real_image(target, level, format, depth > most_layers ? -1 : width, height,
               depth, border, from, type, pixels);
}

static void press_without_room(void)
{
    view_keys_press(&app, 'h');
    CHECK(app.settings.probes == 4);
    view_test_catch();
    CHECK(view_app_draw(&app, false));
    const char *said = view_test_caught();
    CHECK_MSG(strstr(said, "4 local probes with faces of 16: this OpenGL has "
                           "no room for them"),
              "%s", said);
    CHECK(!strcmp(app.notice, "as it was before: the terminal says why"));
    view_app_title(&app);
    CHECK_MSG(has("| probes 2 |"), "%s", title);
}

/* What a key asks for and cannot be made leaves what was there. */
TEST(goes_back_without_room)
{
    begin();
    real_image = gl.TexImage3D;
    gl.TexImage3D = scarce_image;
    most_layers = 2 * IBL_FACES;
    app.begun = ibl_now();
    app.settings.probes = 2;
    CHECK(view_app_draw(&app, false));
    for (int i = 0; i < 2; i++)
        press_without_room();
    CHECK(view_scene_state_of(view_renderer_stage(app.renderer))
              ->draw.locals.count == 2);
    most_layers = 4 * IBL_FACES;
    view_keys_press(&app, 'h');
    CHECK(view_app_draw(&app, false));
    CHECK(app.settings.probes == 4);
    /* With room for neither there is nothing left to show. */
    most_layers = 0;
    view_keys_press(&app, 'h');
    view_test_catch();
    CHECK(!view_app_draw(&app, false));
    CHECK(strstr(view_test_caught(), "no room for the cubes"));
    gl.TexImage3D = real_image;
}

/* ---- --stats ------------------------------------------------------------ */

/* What is printed after a frame, "" for nothing. */
static const char *printed(view_stats *stats)
{
    static char text[1000];
    FILE *kept = tmpfile();
    const int saved = dup(STDOUT_FILENO);

    if (!kept || saved < 0)
        return "no temporary file";
    fflush(stdout);
    dup2(fileno(kept), STDOUT_FILENO);
    view_stats_tell(stats, app.renderer, &app.settings);
    fflush(stdout);
    dup2(saved, STDOUT_FILENO);
    close(saved);
    rewind(kept);
    text[fread(text, 1, sizeof text - 1, kept)] = '\0';
    fclose(kept);
    return text;
}

static const char *frame(view_stats *stats, double seconds)
{
    app.settings.seconds = seconds;
    CHECK(view_renderer_draw(app.renderer, &app.settings, WIDTH, HEIGHT));
    view_stats_add(stats, 10 * (1 + seconds));
    return printed(stats);
}

/* One line for each update of the probe, with the frames since the last. */
TEST(a_line_for_each_update)
{
    view_stats stats = {0};

    begin();
    const char *line = frame(&stats, 0);
    CHECK_MSG(strstr(line, "probe seconds=0.000 size=16 capture=faces "
                           "ms=") == line &&
                  strstr(line, " frames=1 frame=10.0 worst=10.0\n"),
              "%s", line);
    CHECK(!*frame(&stats, 0.1));
    CHECK(!*frame(&stats, 0.4));
    line = frame(&stats, 1);
    CHECK_MSG(strstr(line, "probe seconds=1.000 ") == line &&
                  strstr(line, " frames=3 frame=15.0 worst=20.0\n"),
              "%s", line);
}

/* Without a probe they are of a second each. */
TEST(a_line_for_each_second)
{
    view_stats stats = {0};

    begin();
    app.settings.mode = VIEW_SPHERES;
    /* From the beginning of the first one. */
    CHECK(!*frame(&stats, 49));
    now += 0.4;
    CHECK(!*frame(&stats, 0));
    now += 0.2;
    const char *line = frame(&stats, 1);
    CHECK_MSG(!strcmp(line, "view mode=spheres frames=3 frame=176.7 "
                            "worst=500.0\n"),
              "%s", line);
    CHECK(!*frame(&stats, 0));
    now += 1;
    line = frame(&stats, 1);
    CHECK_MSG(strstr(line, "frames=2 frame=15.0 worst=20.0"), "%s", line);
}
