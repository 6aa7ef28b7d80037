/* SPDX-License-Identifier: MIT */
/* Milliseconds of the viewer's frames in OSMesa, by what they show, and of
 * what it does besides. Arguments: width and height, 1280 and 720 by default.
 */
#include "view.h"

#include "view/gl.h"
#include "view/message.h"
#include "view/picture.h"
#include "view/renderer.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum {
    RUNS = 15
};

typedef struct job {
    ibl_ctx *ctx;
    view_renderer *renderer;
    baked_set set;
    view_settings settings;
    int width, height;
} job;

/* ---- what is measured ------------------------------------------------ */

static void draw(job *j)
{
    if (!view_renderer_draw(j->renderer, &j->settings, j->width, j->height))
        exit(1);
    gl.Finish();
}

static void defaults(job *j)
{
    j->settings = view_settings_default();
}

static void plain(job *j)
{
    defaults(j);
    j->settings.multiscatter = false;
    j->settings.sky = false;
}

static void sky(job *j)
{
    defaults(j);
    j->settings.rows = j->settings.columns = 1;
    j->settings.distance = 50;
}

static void one(job *j)
{
    defaults(j);
    j->settings.rows = j->settings.columns = 1;
}

static void everything(job *j)
{
    defaults(j);
    j->settings.diffuse = VIEW_DIFFUSE_SH;
    j->settings.fresnel = VIEW_FRESNEL_LAGARDE;
    j->settings.light_count = VIEW_MAX_LIGHTS;
    for (int i = 0; i < VIEW_MAX_LIGHTS; i++)
        j->settings.light[i] = (view_light){{i, 3, 4}, {10, 10, 10}};
}

static void levels(job *j)
{
    defaults(j);
    j->settings.mode = VIEW_LEVELS;
}

static void table(job *j)
{
    defaults(j);
    j->settings.mode = VIEW_TABLE;
}

static void reference(job *j)
{
    defaults(j);
    j->settings.compare = VIEW_REFERENCE;
}

/* For what does something to a picture, how it looks matters. */
static void shown(job *j)
{
    defaults(j);
    draw(j);
}

static void load(job *j)
{
    if (!view_renderer_load(j->renderer, &j->set))
        exit(1);
    gl.Finish();
}

static void read_picture(job *j)
{
    free(view_picture_read(0, j->width, j->height));
}

static void write_picture(job *j)
{
    unsigned char *rgb = view_picture_read(0, j->width, j->height);
    char path[300];

    snprintf(path, sizeof path, "%s/picture.png", test_dir());
    if (!rgb || !view_picture_write(j->ctx, path, j->width, j->height, rgb))
        exit(1);
    free(rgb);
}

static const struct {
    const char *name;
    void (*set)(job *j); /* before the clock runs */
    void (*run)(job *j);
} cases[] = {
    {"spheres, as the viewer starts", defaults, draw},
    {"  no sky, single scattering", plain, draw},
    {"  harmonics, Lagarde, 4 lights", everything, draw},
    {"  one large sphere", one, draw},
    {"sky alone", sky, draw},
    {"a level as a cross", levels, draw},
    {"the table", table, draw},
    {"picture read", shown, read_picture},
    {"picture read and written", shown, write_picture},
    {"reference, one sample more", reference, draw},
    {"maps loaded", defaults, load}, /* with the reference's table of lights */
};
enum {
    CASES = sizeof cases / sizeof cases[0]
};

/* ---- measuring ------------------------------------------------------- */

/* The cases take turns, so that a busy machine is busy for all. */
static void measure(job *j)
{
    static double wall[CASES][RUNS], cpu[CASES][RUNS];

    for (int run = -1; run < RUNS; run++)
        for (int i = 0; i < CASES; i++) {
            cases[i].set(j);
            cases[i].run(j); /* what is made once, is made */
            const double wall0 = test_ms(CLOCK_MONOTONIC);
            const double cpu0 = test_ms(CLOCK_PROCESS_CPUTIME_ID);
            cases[i].run(j);
            if (run < 0)
                continue;
            wall[i][run] = test_ms(CLOCK_MONOTONIC) - wall0;
            cpu[i][run] = test_ms(CLOCK_PROCESS_CPUTIME_ID) - cpu0;
        }
    printf("%-32s %9s %9s\n", "", "ms", "cpu ms");
    for (int i = 0; i < CASES; i++)
        printf("%-32s %9.2f %9.2f\n", cases[i].name, test_median(wall[i], RUNS),
               test_median(cpu[i], RUNS));
}

int main(int argc, char **argv)
{
    job j = {.width = argc > 1 ? atoi(argv[1]) : 1280,
             .height = argc > 2 ? atoi(argv[2]) : 720};
    int status = 1;

    if (j.width < 1 || j.height < 1) {
        fprintf(stderr, "bench_view [WIDTH HEIGHT]\n");
        return 2;
    }
    j.ctx = test_ctx(0, IBL_ISA_AUTO);
    if (!view_test_begin(j.width, j.height))
        return 1;
    j.renderer = view_renderer_create();
    if (j.renderer && view_set_bake(j.ctx, test_data("sky.exr"), &j.set) &&
        view_renderer_load(j.renderer, &j.set)) {
        view_renderer_pace(j.renderer, 1);
        printf("%d x %d pixels, specular map of %d, %s\n", j.width, j.height,
               j.set.texture[VIEW_SPECULAR].width, view_test_about());
        measure(&j);
        status = 0;
    }
    view_renderer_free(j.renderer);
    view_set_free(&j.set);
    view_test_end();
    ibl_ctx_free(j.ctx);
    return status;
}
