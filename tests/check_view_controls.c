/* SPDX-License-Identifier: MIT */
/* Settings by the command line, keys and panel: each row of the table changes
 * the picture where it says so and is refused elsewhere; labels stand beside
 * the picture. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "files.h"
#include "sets.h"
#include "test.h"
#include "view.h"
#include "view/gl.h"
#include "view/ui.h"

enum {
    WIDTH = 72,
    HEIGHT = 48,
    PIXELS = WIDTH * HEIGHT
};

static struct {
    view_renderer *renderer;
    view_model *model;
    baked_set set;
} on;

/* ---- what is drawn ------------------------------------------------------- */

static void end(void *unused)
{
    (void)unused;
    view_renderer_free(on.renderer);
    view_model_free(on.model);
}

/* A square and a camera that sees it from the side. */
static const char model[] =
    "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0,1]"
    "}],\"nodes\":[{\"mesh\":0},{\"camera\":0,\"translation\":[0.5,0,3]}],"
    "\"cameras\":[{\"type\":\"perspective\",\"perspective\":{\"yfov\":0.9,"
    "\"znear\":0.1}}],\"meshes\":[{\"primitives\":[{\"attributes\":{"
    "\"POSITION\":0}}]}],\"buffers\":[{\"byteLength\":72,\"uri\":\"data:"
    "application/octet-stream;base64,"
    "AACAvwAAgL8AAAAAAACAPwAAgL8AAAAAAACAPwAAgD8AAAAAAACAvwAAgL8AAAAAAACAPwAAgD"
    "8AAAAAAACAvwAAgD8AAAAA\"}],\"bufferViews\":[{\"buffer\":0,\"byteLength\":"
    "72"
    "}],\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":6,"
    "\"type\":\"VEC3\",\"min\":[-1,-1,0],\"max\":[1,1,0]}]}";

static void begin(void)
{
    ibl_ctx *ctx = view_test_ctx(2);
    const char *path = test_text("%s/square.gltf", test_dir());
    ibl_scene scene;

    NEED(sets_bake("controls", "--lobe-table prior --lights 1"));
    sets_open(ctx, "controls", &on.set);
    view_test_begin(WIDTH, HEIGHT);
    on.renderer = view_renderer_create();
    on.model = NULL;
    test_defer(end, NULL);
    NEED(on.renderer && view_renderer_load(on.renderer, &on.set));
    FILE *f = fopen(path, "w");
    NEED(f && fputs(model, f) >= 0 && !fclose(f));
    NEED(!ibl_scene_read(ctx, path, false, &scene));
    on.model = view_model_create(ctx, &scene, path);
    ibl_scene_free(&scene);
    NEED(on.model);
    view_renderer_model(on.renderer, on.model);
}

/* Framebuffer 0, to be freed. */
static unsigned char *draw(const view_settings *a, const view_settings *b)
{
    const view_settings side[2] = {*a, *b};

    view_renderer_restart(on.renderer);
    for (int i = 0; i < view_places(a); i++)
        NEED(view_renderer_draw(on.renderer, side,
                                &(view_area){0, 0, WIDTH, HEIGHT}));
    return view_picture_read(0, WIDTH, HEIGHT, 4);
}

/* A row of a setting, not of what else the command line has. */
static bool is_setting(const view_control *c)
{
    return c->option.offset < sizeof(view_settings) &&
           c->option.kind < IBL_OPTION_HELP;
}

/* Parses "--NAME VALUE", a value that is not that of prepare, over o. */
static void give(const view_control *c, view_options *o, char *words[3])
{
    static const char *const values[][2] = {
        {"zoom", "2"},        {"pan", "0.2,0.1"},      {"metallic", "1:0.5"},
        {"grid", "2x4"},      {"roughness", "0.3:.9"}, {"turn", "40"},
        {"lights", "2"},      {"split", "0.3"},        {"gain", "100"},
        {"seconds", "3"},     {"yaw", "20"},           {"pitch", "30"},
        {"distance", "2.5"},  {"fov", "50"},           {"blur", "0.5"},
        {"colour", ".2,1,0"}, {"probe-size", "32"},    {"antialias", "2"}};
    static const ibl_command one = {.usage = "",
                                    .sections = view_control_sections,
                                    .settings_size = sizeof *o};
    const char *value = c->option.choices ? c->option.choices[1] : "1";

    for (size_t i = 0; i < sizeof values / sizeof *values; i++)
        if (!strcmp(values[i][0], c->option.name))
            value = values[i][1];
    words[0] = (char *)test_text("--%s", c->option.name);
    words[1] = c->option.value ? (char *)test_text("%s", value) : NULL;
    words[2] = NULL;
    NEED(ibl_command_line(&one, words, o, NULL));
}

/* What a row needs besides its mode. */
static view_options prepare(const view_control *c, int mode)
{
    view_options o = {.settings = view_settings_default(),
                      .offscreen = "p.png"};
    view_settings *s = &o.settings;
    const char *name = c->option.name;

    s->mode = (view_mode)mode;
    s->probe_size = 0;
    s->rows = s->columns = 3;
    s->light_count = 1;
    if (strcmp(name, "override") != 0)
        s->override = VIEW_MATERIAL;
    if (c->of)
        *(int *)view_control_field(view_control_of(c), s) = c->is;
    if (!strcmp(name, "seams"))
        s->yaw = 45; /* a square shows an edge of the cube */
    if (!strcmp(name, "nearest") || !strcmp(name, "probe-limit"))
        s->probes = 4;
    if (!strcmp(name, "probe-choice"))
        s->probes = 9;
    return o;
}

/* By one of the values of a choice at least. */
static bool is_changed(const view_control *c, view_options *o)
{
    view_settings other = o->settings, s;
    bool changed = false;
    char *words[3];

    other.background = VIEW_BACKGROUND_COLOUR;
    other.level = 2;
    other.diffuse = VIEW_DIFFUSE_SH;
    other.reflection = VIEW_FIT;
    other.parallax = VIEW_PARALLAX_NONE;
    unsigned char *from = draw(&o->settings, &other);
    give(c, o, words);
    s = o->settings;
    for (int i = 1;
         !changed && (i == 1 || (c->option.choices && c->option.choices[i]));
         i++) {
        unsigned char *to = draw(&s, &other);
        changed = memcmp(from, to, 4 * PIXELS) != 0;
        free(to);
        view_control_step(c, &s, 1);
    }
    free(from);
    return changed;
}

TEST(each_setting_changes_the_picture)
{
    const view_control *c;

    begin();
    view_renderer_model(on.renderer, on.model);
    for (int i = 0; (c = view_control_at(i)); i++)
        for (int mode = 0; mode < VIEW_MODES && is_setting(c); mode++) {
            view_options o = prepare(c, mode);
            if (view_control_why(c, &o.settings, false, &o) ||
                !strcmp(c->option.name, "array-layer") ||
                /* Both sides are alike. */
                (c->of && !strcmp(c->of, "compare") &&
                 (mode == VIEW_TABLE || mode == VIEW_SOURCE_MAP)))
                continue;
            CHECK_MSG(is_changed(c, &o), "--%s changes nothing in %s",
                      c->option.name, view_mode_names[mode]);
        }
}

/* ---- the command line ---------------------------------------------------- */

/* In one line, and only where the table says so: a choice that an option is of
 * is implied, and a state is not compared with itself. */
TEST(others_are_refused)
{
    static char name[] = "map", picture[] = "--offscreen", png[] = "x.png",
                in[] = "--mode", with[] = "--model", none[] = "x.glb";
    const view_control *c;

    for (int i = 1; (c = view_control_at(i)); i++)
        for (int mode = 0; mode < VIEW_MODES && is_setting(c); mode++) {
            char *words[11] = {name, picture, png, in,
                               (char *)view_mode_names[mode]};
            view_options o, expected = {.settings = view_settings_default(),
                                        .offscreen = png};
            int status;
            expected.settings.mode = (view_mode)mode;
            give(c, &expected, words + 5);
            for (int k = 5;
                 mode == VIEW_MODEL && strcmp(c->option.name, "mode"); k++)
                if (!words[k]) {
                    words[k] = with, words[k + 1] = none;
                    break;
                }
            if (c->of)
                *(int *)view_control_field(view_control_of(c),
                                           &expected.settings) = c->is;
            const bool fits =
                !view_control_why(c, &expected.settings, false, &expected);
            view_test_catch();
            const bool ok = view_options_parse(words, &o, &status);
            const char *said = view_test_caught();
            CHECK_MSG(ok || (status == 2 && sets_lines(said) == 1 &&
                             strstr(said, "--")),
                      "--%s in %s: %s", c->option.name, view_mode_names[mode],
                      said);
            CHECK_MSG(ok == fits || (fits && strstr(said, "with itself")),
                      "--%s in %s is %s: %s", c->option.name,
                      view_mode_names[mode], ok ? "taken" : "refused", said);
        }
}

/* ---- keys ---------------------------------------------------------------- */

static view_options options;
static view_app app;

/* A key changes its own setting and says so, or says why not; the other one
 * takes it back. */
TEST(keys_change_one_setting)
{
    const view_control *c;

    view_test_app(&app, &options, 320, 240);
    for (int i = 0; (c = view_control_at(i)); i++)
        for (int mode = 0; mode < VIEW_MODES && c->key; mode++) {
            app.side[0] = app.side[1] = options.settings;
            app.side[0].mode = (view_mode)mode;
            app.side[0].compare = VIEW_SPLIT;
            view_app_fit(&app);
            const view_settings before = app.side[0];
            view_settings undone = before;
            const char *why = view_app_why(&app, c);
            app.notice[0] = '\0';
            view_keys_press(&app, c->key);
            CHECK(app.notice[0]);
            const bool changed =
                memcmp(&before, &app.side[0], sizeof before) != 0;
            CHECK_MSG(!why == changed || !strcmp(c->option.name, "array-layer"),
                      "%c in %s: %s", c->key, view_mode_names[mode],
                      app.notice);
            if (why || !c->back || c->option.kind == IBL_OPTION_INT)
                continue;
            view_keys_press(&app, c->back);
            undone.split = app.side[0].split;
            CHECK_MSG(!memcmp(&undone, &app.side[0], sizeof undone),
                      "%c and %c in %s", c->key, c->back,
                      view_mode_names[mode]);
        }
}

/* Escape closes what is open, and never quits; q quits. */
TEST(escape_closes)
{
    view_test_app(&app, &options, 320, 240);
    view_keys_press(&app, '?');
    view_keys_press(&app, 'p');
    CHECK(app.help && app.panel);
    view_keys_press(&app, VIEW_KEY(256));
    CHECK(!app.help && app.panel);
    for (int i = 0; i < 3; i++)
        view_keys_press(&app, VIEW_KEY(256));
    CHECK(!app.panel && !app.quit);
    view_keys_press(&app, 'q');
    CHECK(app.quit);
}

/* A comparison begins with the reference. What both sides share follows the
 * first; the rest stays of each. */
TEST(sides_differ_only_where_they_may)
{
    view_test_app(&app, &options, 320, 240);
    view_keys_press(&app, 'n');
    view_keys_press(&app, 'f');
    CHECK(app.side[1].reflection == VIEW_REFERENCE &&
          app.side[1].material == app.side[0].material);
    view_keys_press(&app, '0');
    view_keys_press(&app, 'C');
    CHECK(app.side[0].compare == VIEW_SPLIT && app.edited == 1);
    view_keys_press(&app, 'r');
    CHECK(app.side[0].reflection == VIEW_SPLIT_SUM &&
          app.side[1].reflection == VIEW_FIT);
    view_keys_press(&app, 'e');
    CHECK(app.side[0].ev == 0.25 && app.side[1].ev == 0.25);
    view_keys_press(&app, VIEW_KEY(268));
    CHECK(app.side[0].compare == VIEW_ALONE && app.side[1].ev == 0);
}

/* ---- the user interface ---------------------------------------------------
 */

static void end_window(void *unused)
{
    (void)unused;
    view_renderer_free(app.renderer);
    view_folder_free(&app.folder);
    view_ui_free();
}

/* A screen as of a window, black. */
static void begin_window(int width, int height)
{
    view_test_app(&app, &options, width, height);
    view_test_begin(width, height);
    test_defer(end_window, NULL);
    app.renderer = view_renderer_create();
    NEED(app.renderer && view_renderer_load(app.renderer, app.set) &&
         view_ui_make(1));
    gl.BindFramebuffer(GL_FRAMEBUFFER, 0);
    gl.ClearColor(0, 0, 0, 1);
    gl.Clear(GL_COLOR_BUFFER_BIT);
    view_ui_begin(width, height);
}

TEST(legends_show_their_scale)
{
    enum {
        W = 340,
        H = 60
    };
    int bad = 0;

    begin_window(W, H);
    view_ui_legend(10, 5, 320, 0);
    view_ui_legend(10, 35, 320, 4);
    view_ui_end(0);
    unsigned char *rgb = view_picture_read(0, W, H, 3);
    for (int x = 12; x < 328; x++) {
        const double share = (x - 10 + 0.5) / 320;
        double c[3];
        view_test_false_colour(VIEW_STOPS * (2 * share - 1), c);
        for (int k = 0; k < 3; k++)
            bad += !(fabs(rgb[3 * (10 * W + x) + k] - 255 * c[k]) <= 2);
        const double grey = share <= 0.0031308
                                ? 12.92 * share
                                : 1.055 * pow(share, 1 / 2.4) - 0.055;
        bad += !(fabs(rgb[3 * (40 * W + x)] - 255 * grey) <= 2);
    }
    CHECK_MSG(bad <= 2 * 16 * 3, "%d of a scale", bad); /* at steps of stops */
    free(rgb);
}

/* Labels change nothing of the picture, and are around it. */
TEST_SLOW(labels_are_beside_the_picture)
{
    enum {
        W = 640,
        H = 400
    };
    begin_window(W, H);
    view_ui_end(0);
    for (int i = 0; i < 2 * VIEW_MODES; i++) {
        if (i / 2 == VIEW_MODEL)
            continue; /* as spheres, without axes */
        for (int k = 0; k < 2; k++) {
            view_settings *s = &app.side[k];
            s->mode = (view_mode)(i / 2);
            s->probe_size = 0;
            s->layout = i % 2 ? VIEW_STRIP : VIEW_EQUIRECT;
            s->false_colour = i % 2;
            s->compare = i % 2 ? VIEW_SPLIT : VIEW_ALONE;
            s->reflection = k ? VIEW_FIT : VIEW_SPLIT_SUM;
        }
        const view_area a = view_app_area(&app);
        NEED(view_app_draw(&app, false));
        unsigned char *before = view_picture_read(0, W, H, 3);
        view_labels_draw(&app);
        unsigned char *after = view_picture_read(0, W, H, 3);
        int inside = 0, ink = 0;
        for (int n = 0; n < W * H; n++) {
            const int x = n % W, y = H - 1 - n / W;
            const bool in =
                x >= a.x && y >= a.y && x < a.x + a.width && y < a.y + a.height;
            const bool changed = memcmp(before + 3 * n, after + 3 * n, 3) != 0;
            /* beside a map that does not fill it */
            inside +=
                in && changed && (before[3 * n] < 25 || before[3 * n] > 26);
            ink += !in && changed;
        }
        CHECK_MSG(!inside && ink > 50, "%s: %d in the picture, %d beside",
                  view_mode_names[i / 2], inside, ink);
        free(before);
        free(after);
    }
}
