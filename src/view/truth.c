/* SPDX-License-Identifier: MIT */
#include "view/truth.h"

#include <stdlib.h>
#include <string.h>

#include "common/process.h"
#include "common/signals.h"
#include "view/aim.h"
#include "view/gl.h"
#include "view/message.h"
#include "view/program.h"
#include "view/settings.h"
#include "view/upload.h"

/* Most samples of a draw call: systems reset a GPU that is busy for seconds. */
#define MOST_SAMPLES 16
/* With samples set by the clock: most samples of a frame, and the time limits
 * between which their number stays. A changed picture starts with few, so only
 * a still picture takes that long. */
#define MOST_BY_CLOCK 64
static const double quick_seconds = 0.05, slow_seconds = 0.1;

struct view_truth {
    GLuint spheres; /* program */
    GLuint tokens, chance,
        map;                 /* textures; map 0: a texture of the set is it */
    const char *what;        /* what the environment is */
    const view_model *model; /* of the samples so far, or NULL */
    view_canvas canvas;      /* of the model */
    view_model_light light;
    int sampling[4];       /* of the frame */
    view_image pass, mean; /* sky and spheres of one pass, of all passes */
    view_frame shown;      /* frame of the samples so far */
    int samples;           /* in the mean; 0: it holds nothing */
    int by_clock;          /* samples of the next frame */
};

static bool make(view_truth *t)
{
    t->spheres = view_program("sphere.vert", "truth.frag");
    gl.GenTextures(1, &t->tokens);
    gl.GenTextures(1, &t->chance);
    t->by_clock = 1;
    t->light.reflection = VIEW_REFERENCE;
    return t->spheres;
}

void view_truth_free(view_truth *t)
{
    if (!t)
        return;
    view_canvas_free(&t->canvas);
    gl.DeleteTextures(1, &t->map);
    gl.DeleteTextures(1, &t->chance);
    gl.DeleteTextures(1, &t->tokens);
    view_image_free(&t->pass);
    view_image_free(&t->mean);
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

/* Binds the environment: the map itself or, without one, the set's cube that is
 * bound to a unit. */
static bool bind_map(view_truth *t, const ibl_texture *map, int unit)
{
    GLint cube = 0;

    gl.ActiveTexture(GL_TEXTURE0 + (GLenum)unit);
    gl.GetIntegerv(GL_TEXTURE_BINDING_CUBE_MAP, &cube);
    view_gl_bind(VIEW_TRUTH_UNIT_MAP, GL_TEXTURE_CUBE_MAP, (GLuint)cube);
    if (map->data)
        t->map = view_upload(map, false, t->what);
    gl.ActiveTexture(GL_TEXTURE0);
    return !map->data || t->map;
}

static bool load(view_truth *t, const baked_set *set)
{
    /* If level 0 is rough, a skybox has the sharper environment. */
    const bool sky = set->roughness[0] > 0.0 && set->texture[VIEW_SKY].data;
    ibl_texture map;
    view_aim aim;

    if (!view_set_environment(set, &map, &t->what))
        return false;
    const ibl_texture *from =
        map.data ? &map : &set->texture[sky ? VIEW_SKY : VIEW_SPECULAR];
    view_aim_make(from, &aim);
    if (aim.edge)
        upload_aim(t, &aim);
    const bool bound =
        bind_map(t, &map, sky ? VIEW_UNIT_SKY : VIEW_UNIT_SPECULAR);
    t->sampling[2] = aim.edge;
    t->sampling[3] = map.data || sky ? 0 : set->light_count;
    t->light.sheen = set->texture[VIEW_SHEEN].data;
    ibl_texture_free(&map);
    view_aim_free(&aim);
    return bound && view_gl_check("the table of the environment's lights");
}

view_truth *view_truth_create(const baked_set *set)
{
    view_truth *t = ibl_need(calloc(1, sizeof *t));

    if (make(t) && load(t, set))
        return t;
    view_truth_free(t);
    return NULL;
}

const char *view_truth_environment(const view_truth *t)
{
    return t->what;
}

void view_truth_restart(view_truth *t)
{
    t->samples = 0;
}

/* Adds samples, at most MOST_SAMPLES. */
static bool draw_pass(view_truth *t, const view_subject *seen, int samples)
{
    t->sampling[0] = t->samples;
    t->sampling[1] = samples;
    gl.BindBuffer(GL_UNIFORM_BUFFER, seen->frame);
    gl.BufferSubData(GL_UNIFORM_BUFFER, offsetof(view_frame, sampling),
                     sizeof t->sampling, t->sampling);
    if (!view_subject_draw(seen, &t->light, t->spheres, &t->pass, &t->canvas,
                           1))
        return false;
    t->samples += samples;
    return view_mean_add(seen->mean, &t->pass,
                         (float)samples / (float)t->samples, &t->mean);
}

/* Doubles or halves the samples, since a frame also has fixed costs. */
static int next_by_clock(int samples, double took)
{
    if (took < quick_seconds)
        return 2 * samples < MOST_BY_CLOCK ? 2 * samples : MOST_BY_CLOCK;
    return took > slow_seconds && samples > 1 ? samples / 2 : samples;
}

bool view_truth_draw(view_truth *t, const view_frame *frame,
                     const view_subject *seen, int samples)
{
    const bool by_clock = samples == 0;
    const double start = by_clock ? ibl_now() : 0.0;

    if (!view_image_make(&t->pass, seen->width, seen->height))
        return false;
    gl.Viewport(0, 0, seen->width, seen->height);
    gl.Disable(GL_BLEND);
    if (!t->samples || t->model != seen->model ||
        memcmp(frame, &t->shown, VIEW_FRAME_REFERENCE) != 0) {
        t->samples = 0;
        t->by_clock = t->by_clock > 4 ? t->by_clock / 4 : 1;
    }
    t->model = seen->model;
    t->shown = *frame;
    if (by_clock)
        samples = t->by_clock;
    if (samples > VIEW_TRUTH_SAMPLES - t->samples)
        samples = VIEW_TRUTH_SAMPLES - t->samples;
    for (int left = samples; left > 0; left -= MOST_SAMPLES)
        if (!draw_pass(t, seen, left < MOST_SAMPLES ? left : MOST_SAMPLES)) {
            t->samples = 0;
            return false;
        }
    if (by_clock && samples > 0) {
        gl.Finish();
        t->by_clock = next_by_clock(samples, ibl_now() - start);
    }
    return true;
}

GLuint view_truth_texture(const view_truth *t)
{
    return t->mean.texture;
}

int view_truth_samples(const view_truth *t)
{
    return t->samples;
}
