/* SPDX-License-Identifier: MIT */
#include "view/truth.h"

#include <stdlib.h>
#include <string.h>

#include "common/clock.h"
#include "view/aim.h"
#include "view/canvas.h"
#include "view/message.h"
#include "view/program.h"
#include "view/settings.h"
#include "view/upload.h"

/* Targets: sky and spheres of one pass; the mean of all passes. */
enum {
    PASS,
    MEAN,
    TARGETS
};

/* Most samples of a draw call: systems reset a GPU that is busy for seconds. */
#define MOST_SAMPLES 16
/* With samples set by the clock: most samples of a frame, and the time limits
 * between which their number stays. A changed picture starts with few, so only
 * a still picture takes that long. */
#define MOST_BY_CLOCK 64
static const double quick_seconds = 0.05, slow_seconds = 0.1;

struct view_truth {
    GLuint spheres, sky, mean; /* programs */
    GLint first_sample, sample_count, part, environment, aim_edge, discs;
    GLuint tokens, chance,
        map;                /* textures; map 0: a texture of the set is it */
    const char *what;       /* what the environment is */
    view_model *model;      /* or NULL */
    view_canvas canvas;     /* of the model */
    view_model_light light; /* of the model */
    GLuint target[TARGETS], framebuffer[TARGETS];
    int width, height;
    view_frame shown; /* frame of the samples so far */
    int samples;      /* in the mean; 0: the targets hold nothing */
    int by_clock;     /* samples of the next frame */
};

static bool make(view_truth *t)
{
    t->spheres = view_program("sphere.vert", "truth.frag");
    t->sky = t->spheres ? view_program("full.vert", "sky.frag") : 0;
    t->mean = t->sky ? view_program("full.vert", "truth_mean.frag") : 0;
    if (!t->mean)
        return false;
    t->first_sample = gl.GetUniformLocation(t->spheres, "first_sample");
    t->sample_count = gl.GetUniformLocation(t->spheres, "sample_count");
    t->environment = gl.GetUniformLocation(t->spheres, "environment_map");
    t->aim_edge = gl.GetUniformLocation(t->spheres, "aim_edge");
    t->discs = gl.GetUniformLocation(t->spheres, "discs");
    t->part = gl.GetUniformLocation(t->mean, "part");
    gl.GenTextures(1, &t->tokens);
    gl.GenTextures(1, &t->chance);
    gl.GenFramebuffers(TARGETS, t->framebuffer);
    t->by_clock = 1;
    return true;
}

view_truth *view_truth_create(const baked_set *set)
{
    view_truth *t = calloc(1, sizeof *t);

    if (!t)
        view_fail("no memory for the reference");
    else if (make(t) && view_truth_load(t, set))
        return t;
    view_truth_free(t);
    return NULL;
}

void view_truth_free(view_truth *t)
{
    if (!t)
        return;
    view_canvas_free(&t->canvas);
    gl.DeleteFramebuffers(TARGETS, t->framebuffer);
    gl.DeleteTextures(1, &t->map);
    gl.DeleteTextures(1, &t->chance);
    gl.DeleteTextures(1, &t->tokens);
    gl.DeleteTextures(TARGETS, t->target);
    gl.DeleteProgram(t->mean);
    gl.DeleteProgram(t->sky);
    gl.DeleteProgram(t->spheres);
    free(t);
}

static void upload_aim(view_truth *t, const view_aim *aim)
{
    view_gl_bind(VIEW_TRUTH_UNIT_TOKENS, GL_TEXTURE_2D, t->tokens);
    gl.TexImage2D(GL_TEXTURE_2D, 0, GL_R32F, VIEW_AIM_ROW, VIEW_AIM_ROW, 0,
                  GL_RED, GL_FLOAT, aim->tokens);
    view_gl_filter(GL_TEXTURE_2D, GL_NEAREST, 1);
    view_gl_bind(VIEW_TRUTH_UNIT_CHANCE, GL_TEXTURE_2D_ARRAY, t->chance);
    gl.TexImage3D(GL_TEXTURE_2D_ARRAY, 0, GL_R32F, aim->edge, aim->edge, 6, 0,
                  GL_RED, GL_FLOAT, aim->chance);
    view_gl_filter(GL_TEXTURE_2D_ARRAY, GL_LINEAR, 1);
    gl.ActiveTexture(GL_TEXTURE0);
}

/* Uploads the map itself, if there is one, and returns its texture unit. */
static int upload_map(view_truth *t, const ibl_texture *map, int unit)
{
    gl.DeleteTextures(1, &t->map);
    t->map = 0;
    if (!map->data)
        return unit;
    gl.ActiveTexture(GL_TEXTURE0 + VIEW_TRUTH_UNIT_MAP);
    t->map = view_upload(map, false, t->what);
    gl.ActiveTexture(GL_TEXTURE0);
    return VIEW_TRUTH_UNIT_MAP;
}

bool view_truth_load(view_truth *t, const baked_set *set)
{
    /* If level 0 is rough, a skybox has the sharper environment. */
    const bool sky = set->roughness[0] > 0.0 && set->texture[VIEW_SKY].data;
    ibl_texture map;
    view_aim aim;

    if (!view_set_environment(set, &map, &t->what))
        return false;
    const ibl_texture *from =
        map.data ? &map : &set->texture[sky ? VIEW_SKY : VIEW_SPECULAR];
    const bool ok = view_aim_make(from, &aim);
    if (ok && aim.edge)
        upload_aim(t, &aim);
    const int unit =
        upload_map(t, &map, sky ? VIEW_UNIT_SKY : VIEW_UNIT_SPECULAR);
    ibl_texture_free(&map);
    if (!ok || (unit == VIEW_TRUTH_UNIT_MAP && !t->map))
        return false;
    t->light = (view_model_light){
        .reflection = VIEW_REFERENCE,
        .sheen = set->texture[VIEW_SHEEN].data,
        .environment = unit,
        .aim_edge = aim.edge,
        .discs = unit == VIEW_UNIT_SPECULAR ? set->light_count : 0};
    gl.UseProgram(t->spheres);
    gl.Uniform1i(t->environment, unit);
    gl.Uniform1i(t->aim_edge, aim.edge);
    gl.Uniform1i(t->discs, t->light.discs);
    gl.UseProgram(0);
    view_aim_free(&aim);
    view_truth_restart(t);
    return view_gl_check("the table of the environment's lights");
}

const char *view_truth_environment(const view_truth *t)
{
    return t->what;
}

void view_truth_model(view_truth *t, view_model *model)
{
    if (model != t->model)
        view_truth_restart(t);
    t->model = model;
}

void view_truth_restart(view_truth *t)
{
    t->samples = 0;
}

static bool resize(view_truth *t, int width, int height)
{
    t->width = t->height = 0;
    gl.ActiveTexture(GL_TEXTURE0 + VIEW_TRUTH_UNIT_PASS);
    for (int i = 0; i < TARGETS; ++i) {
        gl.DeleteTextures(1, &t->target[i]);
        t->target[i] = view_float_target(width, height);
        if (!view_gl_target(t->framebuffer[i], t->target[i]))
            return view_fail("OpenGL has no picture of %dx%d RGBA floats for "
                             "the reference: make window or picture smaller",
                             width, height);
    }
    gl.ActiveTexture(GL_TEXTURE0);
    t->width = width;
    t->height = height;
    t->samples = 0;
    return view_gl_check("the reference's pictures");
}

/* Clears the mean, which may hold NaN. */
static void begin(view_truth *t, const view_frame *frame)
{
    t->shown = *frame;
    t->samples = 0;
    t->by_clock = t->by_clock > 4 ? t->by_clock / 4 : 1;
    gl.ClearColor(0.0F, 0.0F, 0.0F, 1.0F);
    gl.BindFramebuffer(GL_FRAMEBUFFER, t->framebuffer[MEAN]);
    gl.Clear(GL_COLOR_BUFFER_BIT);
}

/* Draws what is seen, with samples, into the target PASS. */
static bool draw_spheres(view_truth *t, GLuint instances, int count,
                         int samples)
{
    gl.BindFramebuffer(GL_FRAMEBUFFER, t->framebuffer[PASS]);
    view_gl_draw_full(t->sky);
    gl.Enable(GL_BLEND);
    gl.UseProgram(t->spheres);
    gl.Uniform1i(t->first_sample, t->samples);
    gl.Uniform1i(t->sample_count, samples);
    gl.BindVertexArray(instances);
    gl.DrawArraysInstanced(GL_TRIANGLE_STRIP, 0, 4, count);
    return true;
}

static bool draw_model(view_truth *t, int samples)
{
    t->light.first_sample = t->samples;
    t->light.sample_count = samples;
    if (!view_canvas_begin(&t->canvas, t->target[PASS], t->width, t->height, 1))
        return false;
    view_gl_draw_full(t->sky);
    const bool ok = view_model_draw(t->model, &t->light, t->shown.eye);
    view_canvas_end(&t->canvas);
    return ok;
}

/* Adds samples, at most MOST_SAMPLES. */
static bool draw_pass(view_truth *t, GLuint instances, int count, int samples)
{
    if (!(t->model ? draw_model(t, samples)
                   : draw_spheres(t, instances, count, samples)))
        return false;

    t->samples += samples;
    gl.Enable(GL_BLEND);
    gl.BindFramebuffer(GL_FRAMEBUFFER, t->framebuffer[MEAN]);
    view_gl_bind(VIEW_TRUTH_UNIT_PASS, GL_TEXTURE_2D, t->target[PASS]);
    gl.UseProgram(t->mean);
    gl.Uniform1f(t->part, (float)samples / (float)t->samples);
    view_gl_draw_full(t->mean);
    gl.Disable(GL_BLEND);
    return true;
}

/* Doubles or halves the samples, since a frame also has fixed costs. */
static int next_by_clock(int samples, double took)
{
    if (took < quick_seconds)
        return 2 * samples < MOST_BY_CLOCK ? 2 * samples : MOST_BY_CLOCK;
    return took > slow_seconds && samples > 1 ? samples / 2 : samples;
}

bool view_truth_draw(view_truth *t, const view_frame *frame, GLuint instances,
                     int count, int width, int height, int samples)
{
    const bool by_clock = samples == 0;
    const double start = by_clock ? ibl_now() : 0.0;

    if ((width != t->width || height != t->height) && !resize(t, width, height))
        return false;
    gl.Viewport(0, 0, width, height);
    gl.Disable(GL_BLEND);
    if (!t->samples || memcmp(frame, &t->shown, VIEW_FRAME_REFERENCE) != 0)
        begin(t, frame);
    if (by_clock)
        samples = t->by_clock;
    if (samples > VIEW_TRUTH_SAMPLES - t->samples)
        samples = VIEW_TRUTH_SAMPLES - t->samples;
    for (int left = samples; left > 0; left -= MOST_SAMPLES)
        if (!draw_pass(t, instances, count,
                       left < MOST_SAMPLES ? left : MOST_SAMPLES))
            return false;
    if (by_clock && samples > 0) {
        gl.Finish();
        t->by_clock = next_by_clock(samples, ibl_now() - start);
    }
    return true;
}

GLuint view_truth_texture(const view_truth *t)
{
    return t->width ? t->target[MEAN] : 0;
}

int view_truth_samples(const view_truth *t)
{
    return t->samples;
}
