/* SPDX-License-Identifier: MIT */
/* Frames of the window when all has been seen once: none of our own code asks
 * for memory, nothing is made or compiled, and a
 * program is used once for what it draws. The linker puts the functions below
 * before those of the C library for our own objects, not for OpenGL's. */
#define _DEFAULT_SOURCE /* malloc_trim */
#include <dirent.h>
#include <malloc.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "files.h"
#include "maps.h"
#include "sets.h"
#include "test.h"
#include "view.h"
#include "view/app.h"
#include "view/ui.h"

enum {
    WIDTH = 64,
    HEIGHT = 48,
    WARM = 4, /* frames until all has been seen */
    STEADY = 4
};

/* ---- what is counted ---------------------------------------------------- */

/* Volatile: compilers know that calloc changes no variable. */
static volatile int allocations, makings, uses;

/* A function of the C library, of that name, counted. */
#define COUNT(result, name, parameters, arguments)                             \
    result __real_##name parameters;                                           \
    result __wrap_##name parameters;                                           \
    result __wrap_##name parameters                                            \
    {                                                                          \
        allocations++;                                                         \
        return __real_##name arguments;                                        \
    }
COUNT(void *, malloc, (size_t size), (size))
COUNT(void *, calloc, (size_t count, size_t size), (count, size))
COUNT(void *, realloc, (void *old, size_t size), (old, size))
COUNT(void *, aligned_alloc, (size_t to, size_t size), (to, size))
COUNT(int, posix_memalign, (void **at, size_t to, size_t size), (at, to, size))
COUNT(char *, strdup, (const char *text), (text))

/* OpenGL as it was loaded, and functions of it that are counted. */
static view_gl real;
#define COUNT_GL(counter, result, name, parameters, arguments)                 \
    static result APIENTRY count_##name parameters                             \
    {                                                                          \
        counter++;                                                             \
        return real.name arguments;                                            \
    }
COUNT_GL(makings, void, GenTextures, (GLsizei n, GLuint *to), (n, to))
COUNT_GL(makings, void, GenBuffers, (GLsizei n, GLuint *to), (n, to))
COUNT_GL(makings, void, TexImage2D,
         (GLenum target, GLint level, GLint internal, GLsizei x, GLsizei y,
          GLint border, GLenum format, GLenum type, const void *texels),
         (target, level, internal, x, y, border, format, type, texels))
COUNT_GL(makings, GLuint, CreateShader, (GLenum type), (type))
COUNT_GL(uses, void, UseProgram, (GLuint program), (program))

static void count_calls(void)
{
    real = gl;
    gl.GenTextures = count_GenTextures;
    gl.GenBuffers = count_GenBuffers;
    gl.TexImage2D = count_TexImage2D;
    gl.CreateShader = count_CreateShader;
    gl.UseProgram = count_UseProgram;
}

/* ---- a window in memory -------------------------------------------------- */

static view_app app;
static view_options options;

static void end(void *unused)
{
    (void)unused;
    view_app_end(&app);
    view_ui_free();
}

static void begin(void)
{
    view_test_begin(WIDTH, HEIGHT);
    view_test_app(&app, &options, WIDTH, HEIGHT);
    app.side[0].probe_size = 0;
    app.mouse[0] = app.mouse[1] = 3; /* a texel is read out */
    test_defer(end, NULL);
    count_calls();
    NEED(view_ui_make(1) && view_app_make(&app) &&
         view_renderer_load(app.renderer, app.set));
}

/* A sixtieth of a second after the last. */
static bool frame(void)
{
    app.side[0].seconds += 1.0 / 60;
    if (!view_app_draw(&app, true))
        return false;
    view_labels_draw(&app);
    gl.Finish();
    return true;
}

/* Frames by app.side; most: programs that one uses. */
static void stay(const char *what, int most)
{
    for (int i = 0; i < WARM; i++)
        CHECK(frame());
    allocations = makings = uses = 0;
    for (int i = 0; i < STEADY; i++)
        CHECK(frame());
    CHECK_MSG(!allocations && !makings && uses <= most * STEADY,
              "%s: %d allocations, %d things made, %d programs in %d frames",
              what, allocations, makings, uses, STEADY);
}

/* Programs are of the sky, spheres, display and text, or of the map; the
 * reference gathers samples, and each frame of a scene captures, or none. */
TEST(frames)
{
    view_settings *s = &app.side[0];

    allocations = makings = uses = 0;
    begin();
    CHECK(frame() && allocations > 0 && makings > 0 && uses > 0);
    stay("spheres", 4);
    s->light_count = VIEW_MAX_LIGHTS;
    s->false_colour = true;
    stay("lights and false colours", 4);
    app.help = true;
    view_app_notice(&app, "a notice");
    stay("list of keys", 4);
    for (int mode = VIEW_LEVELS; mode <= VIEW_TABLE; mode++) {
        s->mode = (view_mode)mode;
        stay(view_mode_names[mode], 3);
    }
    s->mode = VIEW_SPHERES;
    s->compare = VIEW_DIFFERENCE;
    stay("reference", 1000);
    s->compare = VIEW_ALONE;
    s->mode = VIEW_SCENE;
    s->probe_interval = 0;
    s->probes = 1;
    stay("scene, captured whole", 1000);
    s->probe_capture = VIEW_PROBE_PARABOLOIDS;
    stay("scene, paraboloids", 1000);
    s->probe_interval = 1000;
    stay("scene, no capture", 20);
}

/* ---- a long run -----------------------------------------------------------
 */

static int lines_in(const char *folder)
{
    DIR *dir = opendir(folder);
    int n = 0;

    while (dir && readdir(dir))
        n++;
    if (dir)
        closedir(dir);
    return n;
}

static double resident_mib(void)
{
    FILE *f = fopen("/proc/self/statm", "r");
    long pages = 0;

    malloc_trim(0);
    NEED(f && fscanf(f, "%*d %ld", &pages) == 1);
    fclose(f);
    return (double)pages * (double)sysconf(_SC_PAGESIZE) / (1 << 20);
}

/* A bake from the beginning, its threads included, by way of a file. */
static void bake_once(const ibl_image *map, const char *path, baked_set *set)
{
    ibl_specular_options o = ibl_specular_options_default();
    ibl_ctx_options with = ibl_ctx_options_default();
    ibl_outputs *out = NULL;
    ibl_texture read = {0};
    ibl_ctx *ctx;

    o.size = 16;
    o.levels = 3;
    with.threads = 2;
    NEED(!ibl_ctx_create(&with, &ctx) &&
         sets_bake_image(ctx, "soak", map, &o, set) &&
         !ibl_outputs_create(ctx, 0, &out) &&
         !ibl_outputs_take_texture(
             out, path, &set->baked.file[IBL_CONTENT_SPECULAR].texture,
             IBL_CONTAINER_KTX2, NULL) &&
         !ibl_outputs_commit(out) && !ibl_texture_read(ctx, path, &read, NULL));
    ibl_texture_free(&set->baked.file[IBL_CONTENT_SPECULAR].texture);
    set->baked.file[IBL_CONTENT_SPECULAR].texture = read;
    ibl_outputs_free(out);
    ibl_ctx_free(ctx);
}

/* Bakes and pictures, one after the other in one process:
 * IBL_TEST_SOAK=2000 of them (make soak), 60 without. */
TEST(soak)
{
    const char *given = getenv("IBL_TEST_SOAK");
    const int rounds = given ? atoi(given) : 60;
    view_settings s = view_settings_default();
    const char *path = file_path("soak.ktx2");
    double first = 0;
    int open = 0, threads = 0;

    if (TEST_SANITIZED)
        test_skip("sanitizers keep what is freed");
    view_test_begin(WIDTH, HEIGHT);
    view_renderer *r = view_renderer_create();
    const ibl_image map = map_constant(view_test_ctx(1), 16, 8, 1);
    NEED(r);
    for (int i = 0; i < rounds; i++) {
        baked_set set;
        bake_once(&map, path, &set);
        s.turn = i;
        NEED(view_renderer_load(r, &set) &&
             view_test_draw(r, &s, WIDTH, HEIGHT));
        view_set_free(&set);
        if (i == rounds / 10 + 20)
            first = resident_mib(), open = lines_in("/proc/self/fd"),
            threads = lines_in("/proc/self/task");
    }
    const double last = resident_mib();
    view_renderer_free(r);
    CHECK(open == lines_in("/proc/self/fd") &&
          threads == lines_in("/proc/self/task"));
    CHECK_MSG(last < first + 1, "%.2f MiB, then %.2f", first, last);
    if (given)
        printf("%d rounds: %.2f MiB resident, %.2f after a tenth\n", rounds,
               last, first);
}
