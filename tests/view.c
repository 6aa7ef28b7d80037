/* SPDX-License-Identifier: MIT */
#include "view.h"

#include "common/signals.h"
#include "sets.h"
#include "view/gl.h"
#include "view/message.h"
#include "view/ui.h"
#include "view/vector.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#if defined(__has_feature)
#define THREAD_SANITIZER __has_feature(thread_sanitizer)
#elif defined(__SANITIZE_THREAD__)
#define THREAD_SANITIZER 1
#else
#define THREAD_SANITIZER 0
#endif

/* OSMesa does not free some hundreds of bytes of each framebuffer that it has
 * drawn into. The sanitizer's library looks for this name. */
__attribute__((visibility("default"))) const char *
__lsan_default_suppressions(void);
const char *__lsan_default_suppressions(void)
{
    return "leak:libOSMesa.so\n";
}

void view_test_close(void)
{
    view_screen_close();
}

static void close_screen(void *unused)
{
    (void)unused;
    view_test_close();
}

void view_test_begin(int width, int height)
{
    if (THREAD_SANITIZER)
        test_skip("OSMesa compiles as it runs, which the thread sanitizer "
                  "does not follow");
    view_test_close();
    test_defer(close_screen, NULL);
    view_test_catch();
    const bool ok = view_screen_memory(width, height, NULL);
    const char *said = view_test_caught();
    if (!ok)
        test_skip("%.*s", (int)strcspn(said, "\n"), said);
}

const char *view_test_shader(const char *name)
{
    const view_shader_file *f = view_shader_files;

    while (strcmp(f->name, name) != 0)
        f++;
    return f->text;
}

GLuint view_test_program(const char *fragment)
{
    const view_shader_file files[] = {
        {"full.vert", view_test_shader("full.vert")}, {"test.frag", fragment}};
    const GLuint program =
        view_program_from(files, "", "full.vert", "test.frag");

    NEED(program);
    return program;
}

ibl_ctx *view_test_ctx(int threads)
{
    ibl_ctx_options opts = ibl_ctx_options_default();

    opts.threads = threads;
    opts.log = view_log;
    return test_ctx_of(&opts);
}

void view_test_app(view_app *app, view_options *options, int width, int height)
{
    char name[] = "map", *words[] = {name, NULL};
    baked_set *set = ibl_need(calloc(1, sizeof *set));
    int status;

    memset(app, 0, sizeof *app);
    test_defer(free, set);
    NEED(view_options_parse(words, options, &status));
    app->options = options;
    app->side[0] = options->settings;
    app->side[1] = options->other;
    app->paused = true;
    app->labels = true;
    app->mouse[0] = app->mouse[1] = -1;
    app->width = width;
    app->height = height;
    app->scale = 1;
    sets_white(set);
    app->set = set;
}

bool view_test_draw(view_renderer *r, const view_settings *s, int width,
                    int height)
{
    view_settings side[2] = {*s, *s};

    side[1].reflection = VIEW_REFERENCE;
    return view_renderer_draw(r, side, &(view_area){0, 0, width, height});
}

/* ---- standard error -------------------------------------------------- */

static int saved = -1;
static FILE *kept;

static void need(bool ok, const char *what)
{
    if (!ok) {
        perror(what);
        exit(1);
    }
}

void view_test_catch(void)
{
    fflush(stderr);
    kept = tmpfile();
    need(kept, "temporary file");
    saved = dup(STDERR_FILENO);
    need(saved >= 0 && dup2(fileno(kept), STDERR_FILENO) >= 0, "dup");
}

const char *view_test_caught(void)
{
    static char text[8192];

    fflush(stderr);
    need(dup2(saved, STDERR_FILENO) >= 0, "dup");
    close(saved);
    rewind(kept);
    text[fread(text, 1, sizeof text - 1, kept)] = 0;
    fclose(kept);
    return text;
}

void view_test_false_colour(double stops, double srgb[3])
{
    const double at = fmin(fmax(stops + VIEW_STOPS, 0), 2 * VIEW_STOPS - 1e-9);
    const double share =
        (floor(at) + 0.5 * (at - floor(at))) / (2 * VIEW_STOPS);
    const double level = 0.1 + 0.8 * share;
    const double angle = 2 * M_PI * (0.5 / 3 + 1 - 1.5 * level);
    const double swing = level * (1 - level) / 2;
    const double c = swing * cos(angle), s = swing * sin(angle);

    srgb[0] = level - 0.14861 * c + 1.78277 * s;
    srgb[1] = level - 0.29227 * c - 0.90649 * s;
    srgb[2] = level + 1.97294 * c;
    for (int i = 0; i < 3; i++)
        srgb[i] = fmin(fmax(srgb[i], 0), 1);
}
void view_test_ray(const view_camera *c, int width, int height, double x,
                   double y, double direction[3])
{
    const double u = 2 * (x + 0.5) / width - 1 + c->shift[0];
    const double v = 1 - 2 * (y + 0.5) / height + c->shift[1];

    for (int k = 0; k < 3; k++)
        direction[k] = c->forward[k] + u * c->right[k] + v * c->up[k];
    normalise3(direction);
}

int view_test_hit(const view_sphere *spheres, int count, const double eye[3],
                  const double direction[3], double normal[3])
{
    double nearest = INFINITY;
    int hit = -1;

    for (int i = 0; i < count; i++) {
        const view_sphere *p = &spheres[i];
        double to[3], off[3];
        for (int k = 0; k < 3; k++)
            to[k] = p->centre[k] - eye[k];
        const double along = dot3(to, direction);
        for (int k = 0; k < 3; k++)
            off[k] = along * direction[k] - to[k];
        const double half2 = p->radius * p->radius - dot3(off, off);
        if (half2 < 0)
            continue;
        const double half = sqrt(half2);
        if (along - half <= 0 || along - half >= nearest)
            continue;
        nearest = along - half;
        hit = i;
        for (int k = 0; normal && k < 3; k++)
            normal[k] = (off[k] - half * direction[k]) / p->radius;
    }
    return hit;
}
