/* SPDX-License-Identifier: MIT */
/* Sets that the viewer bakes, and files that change. */
#include <fcntl.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "files.h"
#include "sets.h"
#include "test.h"
#include "view.h"
#include "view/baked_set.h"

/* ---- bakes ------------------------------------------------------------- */

TEST(bake_is_that_of_the_program)
{
    ibl_ctx *ctx = view_test_ctx(2);
    baked_set read, made, image;

    if (TEST_RACES)
        test_skip("no threads, but half a minute");
    ibl_image map = sets_read_map(ctx);

    NEED(file_run("'%s' -q '%s' --sh 4 -o same", file_built("iblbake"),
                  sets_file()));
    sets_open(ctx, "same", &read);
    NEED(view_set_bake(ctx, &(view_request){.path = sets_file()}, &made));
    sets_check_same(&read, &made, "baked");
    CHECK(made.path[VIEW_MAP] && !strcmp(made.path[VIEW_MAP], sets_file()));
    CHECK(!view_set_changed(&made, 0));
    CHECK(made.seen[VIEW_MAP].size > 0);
    if (!TEST_SANITIZED) {
        NEED(sets_bake_image(ctx, "sky", &map, NULL, &image));
        sets_check_same(&read, &image, "baked from memory");
        CHECK(!image.path[VIEW_MAP]);
        view_set_free(&image);
    }
    view_set_free(&made);
}

/* A map that takes a while. */
static const char *large_map(void)
{
    static char path[512];
    const int width = TEST_SANITIZED ? 512 : 4096;
    FILE *f;

    if (*path)
        return path;
    snprintf(path, sizeof path, "%s/large.hdr", test_dir());
    f = fopen(path, "wb");
    if (!f)
        exit(1);
    fprintf(f, "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y %d +X %d\n", width / 2,
            width);
    test_random random = {3};
    for (int i = 0; i < width * width / 2; i++) {
        const uint64_t bits = test_random_u64(&random);
        const unsigned char rgbe[4] = {(unsigned char)(bits | 128),
                                       (unsigned char)(bits >> 8),
                                       (unsigned char)(bits >> 16), 128};
        fwrite(rgbe, 1, 4, f);
    }
    if (fclose(f))
        exit(1);
    return path;
}

static void pause_for(double seconds)
{
    const struct timespec t = {(time_t)seconds,
                               (long)(1e9 * (seconds - floor(seconds)))};
    nanosleep(&t, NULL);
}

TEST(baker_bakes)
{
    ibl_ctx *ctx = view_test_ctx(2);
    baked_set made, set;
    char stage[64] = "";
    int seen = 0;

    /* Who looks may be late, but not each time. */
    for (int attempt = 0; seen <= 2 && attempt < 10; attempt++) {
        double done, before = 0;
        view_baker *baker =
            view_baker_start(&(view_request){.path = large_map()});
        NEED(baker);
        if (attempt)
            view_set_free(&set);
        seen = 0;
        while (!view_baker_poll(baker, stage, &done)) {
            CHECK_MSG(done >= before && done <= 1, "%g after %g", done, before);
            seen += done > before;
            before = done;
            pause_for(0.002);
        }
        CHECK(done == 1 && *stage);
        NEED(view_baker_finish(baker, &set));
    }
    CHECK_MSG(seen > 2, "progress was seen to move %d times", seen);
    NEED(view_set_bake(ctx, &(view_request){.path = large_map()}, &made));
    sets_check_same(&made, &set, "beside the window");
    view_set_free(&made);
    view_set_free(&set);
}

/* Of all threads of this process, which waiting does not change. */
static double processor_seconds(void)
{
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

TEST(baker_is_cancelled)
{
    static const double after[] = {0, 0.001, 0.01, 0.05};
    const char *path = large_map();
    baked_set set;
    double spent = -processor_seconds();
    NEED(view_baker_finish(view_baker_start(&(view_request){.path = path}),
                           &set));
    spent += processor_seconds();
    view_set_free(&set);
    for (int i = 0; i < 4; i++) {
        view_baker *baker = view_baker_start(&(view_request){.path = path});
        NEED(baker);
        pause_for(after[i]);
        view_test_catch();
        double more = -processor_seconds();
        CHECK(!view_baker_finish(baker, NULL));
        more += processor_seconds();
        CHECK(!*view_test_caught());
        CHECK_MSG(more < 0.5 * spent,
                  "cancelled, it works %g s more; all of it takes %g", more,
                  spent);
    }
    /* One that has ended already. */
    view_baker *baker = view_baker_start(&(view_request){.path = sets_file()});
    char stage[64];
    double done;
    NEED(baker);
    while (!view_baker_poll(baker, stage, &done))
        pause_for(0.002);
    CHECK(!view_baker_finish(baker, NULL));
}

TEST(baker_fails_with_a_line)
{
    static const char *const names[] = {"map.hdr", "not there.hdr"};

    NEED(file_run("echo nonsense >map.hdr"));
    for (int i = 0; i < 2; i++) {
        baked_set set;
        memset(&set, 1, sizeof set);
        view_test_catch();
        view_baker *baker =
            view_baker_start(&(view_request){.path = file_path(names[i])});
        const bool ok = baker && view_baker_finish(baker, &set);
        const char *said = view_test_caught();
        CHECK(!ok && !set.name && !set.texture[VIEW_LUT].data);
        CHECK_MSG(sets_lines(said) == 1 && strstr(said, names[i]), "%s", said);
    }
}

/* ---- files that change ------------------------------------------------ */

/* Whether a change is seen within some seconds. */
static bool comes(const baked_set *set, double settle)
{
    for (int i = 0; i < 200; i++) {
        if (view_set_changed(set, settle))
            return true;
        pause_for(0.01);
    }
    return false;
}

/* Where another file is gone, one that has just changed is not enough once it
 * is as old as the time to settle. Judged only if it is not much older by then;
 * else it changes again. */
static bool waits_longer(const baked_set *set, const char *name)
{
    for (int n = 0; n < 100; n++) {
        char path[1000];
        double settle = 0, age;
        snprintf(path, sizeof path, "%s", file_path(name));
        while (settle < 0.01)
            view_file_stamp_of(path, &settle);
        const bool changed = view_set_changed(set, settle);
        view_file_stamp_of(path, &age);
        if (age < 10 * settle)
            return !changed;
        CHECK(file_run("touch %s", name));
    }
    return false;
}

TEST(stamps)
{
    ibl_ctx *ctx = view_test_ctx(2);
    baked_set set;

    NEED(sets_bake("stamp", ""));
    sets_open(ctx, "stamp", &set);
    for (int i = 0; i < VIEW_FILES; i++)
        CHECK(!set.path[i] || set.seen[i].size > 0);
    CHECK(!view_set_changed(&set, 0));
    /* Renamed over with the same size and time: another file all the same. */
    NEED(file_run("cd stamp && cp -p brdf_lut.ktx2 x && mv x brdf_lut.ktx2"));
    CHECK(comes(&set, 0));
    CHECK(!view_set_changed(&set, 60));
    CHECK(comes(&set, 0.2));
    view_set_seen(&set);
    CHECK(!view_set_changed(&set, 0));
    /* Written anew by the program itself. */
    NEED(sets_bake("stamp", "--levels 2"));
    CHECK(comes(&set, 0));
    /* One that is gone alone is about to come back, or so it may be. */
    view_set_seen(&set);
    NEED(file_run("mv stamp/sky.json away"));
    CHECK(!view_set_changed(&set, 0));
    NEED(file_run("touch stamp/brdf_lut.ktx2"));
    CHECK(!view_set_changed(&set, 60));
    CHECK(waits_longer(&set, "stamp/brdf_lut.ktx2"));
    CHECK(comes(&set, 0));
    CHECK(comes(&set, 0.02));
    /* Without the specular file there is no set. */
    NEED(file_run("mv stamp/sky_specular.ktx2 specular"));
    CHECK(!view_set_changed(&set, 0));
    NEED(file_run("mv specular stamp/sky_specular.ktx2"));
    NEED(file_run("mv away stamp/sky.json"));
    CHECK(comes(&set, 0));
    /* A map that was baked here. */
    NEED(file_run("cp '%s' map_of_stamp.hdr", sets_file()));
    set = (baked_set){.path[VIEW_MAP] = strdup(file_path("map_of_stamp.hdr"))};
    view_set_seen(&set);
    CHECK(!view_set_changed(&set, 0));
    NEED(file_run("touch -d 2001-02-03 map_of_stamp.hdr"));
    CHECK(comes(&set, 0));
    view_set_free(&set);
}
