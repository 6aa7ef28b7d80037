/* SPDX-License-Identifier: MIT */
#include "view/renderer.h"
#include "common/signals.h"
#include "view/frame.h"
#include "view/gl.h"
#include "view/message.h"
#include "view/truth.h"
#include "view/vector.h"

#include <math.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* One of two states that are compared, or the only one. */
typedef struct side {
    const baked_set *set; /* NULL: that of the first side */
    GLuint maps[IBL_CONTENTS];
    view_settings settings;   /* of the last draw */
    view_frame frame;         /* the same, at the pixels' centres */
    view_image picture, mean; /* of one place in the pixels; of all so far */
    view_truth *truth;        /* made on first use */
    view_scene *stage;        /* the same */
} side;

struct view_renderer {
    GLuint sampler; /* of maps that are shown */
    side side[2];
    int sides;                    /* of the last draw */
    int places;                   /* drawn */
    const view_probe_set *probes; /* of the scene, or NULL */
    view_model *model;            /* that was set, or NULL */
    view_image told;              /* of view_renderer_texel */
    bool knows_sun;               /* whether that is of the set */
    ibl_light sun;       /* the main one; irradiance 0: there is none */
    view_image depth[2]; /* of the model from it, from below */
    int samples;         /* of the reference per draw; 0: by the clock */
    GLuint backdrop;     /* the map of the set, or 0 */
    bool knows_backdrop;
    GLuint target;  /* framebuffer */
    view_area area; /* of the last draw; no width: nothing drawn yet */
    bool stale;     /* the linear pictures must be drawn again */
};

view_renderer *view_renderer_create(void)
{
    view_renderer *r = ibl_need(calloc(1, sizeof *r));

    gl.GenSamplers(1, &r->sampler);
    return r;
}

void view_renderer_free(view_renderer *r)
{
    if (!r)
        return;
    for (int i = 0; i < 2; i++) {
        view_truth_free(r->side[i].truth);
        view_scene_free(r->side[i].stage);
    }
    free(r);
}

/* ---- what is drawn ------------------------------------------------------- */

static const baked_set *set_of(const view_renderer *r, int i)
{
    return r->side[r->side[i].set ? i : 0].set;
}

static const GLuint *maps_of(const view_renderer *r, int i)
{
    return r->side[r->side[i].set ? i : 0].maps;
}

/* Replaces the maps of a set. */
static bool load_maps(side *to, const baked_set *set)
{
    GLuint maps[IBL_CONTENTS] = {0};

    for (int i = 0; i < IBL_CONTENTS; i++) {
        const ibl_set_file *f = &set->baked.file[i];
        if (!f->texture.data)
            continue; /* the sky and the lobes may be absent */
        maps[i] =
            view_upload(&f->texture, false,
                        f->path ? f->path : ibl_content_name((ibl_content)i));
        if (!maps[i]) {
            gl.DeleteTextures(IBL_CONTENTS, maps);
            return false;
        }
    }
    gl.DeleteTextures(IBL_CONTENTS, to->maps);
    memcpy(to->maps, maps, sizeof maps);
    to->set = set;
    return true;
}

bool view_renderer_load(view_renderer *r, const baked_set *set)
{
    if (!load_maps(&r->side[0], set))
        return false;
    r->knows_backdrop = r->knows_sun = false;
    view_renderer_probes(r, r->probes);
    for (int i = 0; i < 2; i++) {
        view_truth_free(r->side[i].truth); /* made again on its next use */
        r->side[i].truth = NULL;
    }
    return true;
}

bool view_renderer_against(view_renderer *r, const baked_set *set)
{
    r->stale = true;
    return load_maps(&r->side[1], set);
}

void view_renderer_probes(view_renderer *r, const view_probe_set *probes)
{
    r->probes = probes;
    r->stale = true;
    for (int i = 0; i < 2; i++)
        if (r->side[i].stage)
            view_scene_use(r->side[i].stage, probes);
}

void view_renderer_model(view_renderer *r, view_model *model)
{
    r->model = model;
    view_renderer_restart(r);
}

/* Uploads the map of the set, when it or the reference is first seen. */
static void find_backdrop(view_renderer *r, const view_settings *s)
{
    const bool seen = view_is_lit(s) && !set_of(r, 0)->own_sky &&
                      s->background == VIEW_BACKGROUND_MAP;

    if (r->knows_backdrop ||
        (!seen && !view_wants_reference(s) && s->mode != VIEW_SOURCE_MAP))
        return;
    gl.DeleteTextures(1, &r->backdrop);
    gl.ActiveTexture(GL_TEXTURE0 + VIEW_UNIT_BACKDROP);
    r->backdrop = view_upload_map(set_of(r, 0));
    r->knows_backdrop = true;
}

static void bind_maps(const GLuint maps[IBL_CONTENTS])
{
    const GLuint sky = maps[IBL_CONTENT_SKYBOX], cube = GL_TEXTURE_CUBE_MAP;
    const GLuint level0 = maps[IBL_CONTENT_SPECULAR];

    view_gl_bind(VIEW_UNIT_SPECULAR, cube, level0);
    view_gl_bind(VIEW_UNIT_IRRADIANCE, cube, maps[IBL_CONTENT_IRRADIANCE]);
    view_gl_bind(VIEW_UNIT_LUT, GL_TEXTURE_2D, maps[IBL_CONTENT_LUT]);
    view_gl_bind(VIEW_UNIT_SKY, cube, sky ? sky : level0);
    view_gl_bind(VIEW_UNIT_LOBES, GL_TEXTURE_2D_ARRAY,
                 maps[IBL_CONTENT_LOBE_TABLE]);
}

/* ---- the ground --------------------------------------------------------- */

/* A round matte ground below a model, which takes its shadows: of the main
 * light by a map of depth, and of the rest of the sky, as if that were even, by
 * another from below, whose texels are patches that hide it. sky.frag draws it
 * with what is behind the model: seen from above, the model is before all of
 * it. */
enum {
    GROUND_EDGE = 1024 /* of the maps, which show the sphere of the model */
};

/* Finds the main light: the first that was taken out of the set, or would be
 * out of its map, if that is at hand. */
static void find_light(view_renderer *r, const baked_set *set)
{
    const ibl_image *map = set->baked.light_count ? NULL : view_set_source(set);
    ibl_ctx *ctx = NULL;
    ibl_image copy;
    int count = set->baked.light_count;

    r->knows_sun = true;
    r->sun = set->baked.light[0];
    if (map && !ibl_ctx_create(NULL, &ctx) &&
        !ibl_image_alloc(ctx, map->width, map->height, &copy)) {
        memcpy(copy.data, map->data,
               3 * (size_t)map->width * (size_t)map->height *
                   sizeof *copy.data);
        if (ibl_image_take_lights(ctx, &copy, set->baked.yaw_deg, 1, &r->sun,
                                  &count))
            count = 0;
        ibl_image_free(&copy);
    }
    ibl_ctx_free(ctx);
    if (!count)
        r->sun = (ibl_light){.radius = 0};
}

/* Orthographic from far away in a unit direction: column-major, from the world
 * to clip space. */
static void look_from(const double d[3], float clip[16])
{
    const double beside[3] = {fabs(d[0]) < 0.9, fabs(d[0]) >= 0.9, 0};
    double x[3], y[3];

    cross3(beside, d, x);
    normalise3(x);
    cross3(d, x, y);
    for (int k = 0; k < 4; k++) {
        clip[4 * k] = k < 3 ? (float)(x[k] / VIEW_GROUND_HALF) : 0;
        clip[4 * k + 1] = k < 3 ? (float)(y[k] / VIEW_GROUND_HALF) : 0;
        clip[4 * k + 2] = k < 3 ? (float)(-d[k] / VIEW_GROUND_HALF) : 0;
        clip[4 * k + 3] = k == 3;
    }
}

static bool has_ground(const view_settings *s)
{
    return s->ground && s->mode == VIEW_MODEL;
}

static void fill_ground(const view_renderer *r, const view_settings *s,
                        view_frame *f)
{
    /* Light that is in the maps alone is no part of these. */
    const bool in_all =
        s->parts == VIEW_PARTS_ALL || s->parts == VIEW_PARTS_DIFFUSE;
    double to[3];

    f->ground[0] = (float)view_model_floor(r->model);
    f->ground[1] = 2.5F;
    f->ground[2] = (float)tan(r->sun.radius);
    view_turn(-s->turn, r->sun.direction, to);
    if (to[1] <= 0 || (!in_all && !r->side[0].set->baked.light_count))
        return;
    for (int k = 0; k < 3; k++)
        f->ground_sun[k] = (float)(r->sun.irradiance[k] * to[1] / M_PI);
    f->ground[3] = 1;
    look_from(to, f->ground_light);
}

/* ---- frames ------------------------------------------------------------ */

/* Backdrop and main light are those of the first set for both. */
static void fill_frame(const view_renderer *r, int i, const view_settings *s,
                       view_frame *f)
{
    view_frame_fill(f, s, set_of(r, i), r->area.width, r->area.height);
    f->diffuse[3] = (float)view_set_lit_by(set_of(r, 0));
    if (has_ground(s))
        fill_ground(r, s, f);
    if (!r->backdrop)
        return;
    if (f->shading[2] == VIEW_BACKDROP_CUBE && !set_of(r, 0)->own_sky)
        f->shading[2] = VIEW_BACKDROP_MAP;
    f->diffuse[2] = (float)(set_of(r, 0)->baked.yaw_deg / 360);
}

/* Captures what is due for the scene; the picture begins anew if that changes
 * it. */
static bool update_stage(view_renderer *r, int i, const view_settings *s)
{
    side *of = &r->side[i];
    const GLuint *maps = maps_of(r, i), level0 = maps[IBL_CONTENT_SPECULAR];
    view_room_environment e = {
        .specular = level0,
        .irradiance = maps[IBL_CONTENT_IRRADIANCE],
        .sky = maps[IBL_CONTENT_SKYBOX] ? maps[IBL_CONTENT_SKYBOX] : level0,
        .map = r->backdrop && !set_of(r, 0)->own_sky};

    fill_frame(r, i, s, &e.frame);
    if (!of->stage && (of->stage = view_scene_create())) {
        view_scene_use(of->stage, r->probes);
        of->stage->told = i && !r->side[1].set; /* about the same set */
    }
    return of->stage &&
           view_scene_update(of->stage, s, &e, maps[IBL_CONTENT_LUT], r->model,
                             &r->stale);
}

/* Prepares what the mode shows. False, with a message. */
static bool update(view_renderer *r, int i, const view_settings *state)
{
    side *to = &r->side[i];
    view_settings at = *state, *s = &at;
    view_frame frame;

    if (has_ground(s) && !r->knows_sun)
        find_light(r, set_of(r, 0));
    if (s->mode == VIEW_MODEL) {
        view_model_place(r->model, (const double[3]){0}, 1);
        s->pose = view_model_camera(r->model, s->file_camera - 1);
    }
    if (s->mode == VIEW_SCENE && !update_stage(r, i, s))
        return false;
    fill_frame(r, i, s, &frame);
    if (memcmp(&frame, &to->frame, VIEW_FRAME_LINEAR) != 0)
        r->stale = true;
    to->frame = frame;
    to->settings = *s;
    return true;
}

/* ---- passes ------------------------------------------------------------ */

/* Binds the maps of depth, after drawing them for a frame unless they are those
 * of the last place. */
static bool draw_depths(view_renderer *r, const view_frame *f, bool again)
{
    static const double below[3] = {0, -1, 0};
    view_frame from = *f;
    bool ok = true;

    memcpy(from.clip, f->ground_light, sizeof from.clip);
    for (int i = 0; i < 2 && again && ok; i++) {
        view_gl_block(VIEW_BLOCK_FRAME, &from, sizeof from);
        ok = view_image_make(&r->depth[i], GROUND_EDGE, GROUND_EDGE);
        view_image_begin(&r->depth[i]);
        ok = ok && view_model_depth(r->model);
        look_from(below, from.clip);
    }
    for (int i = 0; i < 2; i++)
        view_gl_bind(VIEW_GROUND_UNIT + i, GL_TEXTURE_2D, r->depth[i].depth);
    return ok;
}

/* Draws a map; pointer: with a third of 1 what is under that pixel, for
 * view_renderer_texel. */
static bool inspect(const view_renderer *r, const side *of,
                    const view_image *to, bool filter, const GLfloat pointer[3])
{
    static const GLuint units[] = {VIEW_UNIT_SPECULAR, VIEW_UNIT_IRRADIANCE,
                                   VIEW_UNIT_BACKDROP};
    const GLuint program = view_program("", "full.vert", "inspect.frag");

    if (!program)
        return false;
    gl.SamplerParameteri(r->sampler, GL_TEXTURE_MIN_FILTER,
                         filter ? GL_LINEAR_MIPMAP_NEAREST
                                : GL_NEAREST_MIPMAP_NEAREST);
    gl.SamplerParameteri(r->sampler, GL_TEXTURE_MAG_FILTER,
                         filter ? GL_LINEAR : GL_NEAREST);
    view_gl_block(VIEW_BLOCK_FRAME, &of->frame, sizeof of->frame);
    view_image_begin(to);
    gl.Disable(GL_BLEND);
    gl.UseProgram(program);
    gl.Uniform4f(gl.GetUniformLocation(program, "pointer"), pointer[0],
                 pointer[1], pointer[2], 0);
    for (int i = 0; i < 3; i++)
        gl.BindSampler(units[i], r->sampler);
    view_gl_draw_full(program);
    for (int i = 0; i < 3; i++)
        gl.BindSampler(units[i], 0);
    return true;
}

bool view_renderer_texel(view_renderer *r, int x, int y, float told[3][4])
{
    const GLfloat pointer[3] = {(float)x + 0.5F, (float)y + 0.5F, 1};

    bind_maps(maps_of(r, 0));
    view_gl_bind(VIEW_UNIT_BACKDROP, GL_TEXTURE_2D, r->backdrop);
    if (!view_image_make(&r->told, 3, 1) ||
        !inspect(r, &r->side[0], &r->told, false, pointer))
        return false;
    gl.ReadPixels(0, 0, 3, 1, GL_RGBA, GL_FLOAT, told);
    return told[2][3] >= 0;
}

/* Draws the next place of a state, or samples of the reference. */
static bool draw_place(view_renderer *r, int i, view_image *to)
{
    side *of = &r->side[i];
    view_settings at = of->settings;
    view_frame frame;
    const view_subject seen = {
        .frame = &frame,
        .model = at.mode == VIEW_MODEL ? r->model : NULL,
        .light = {.reflection = at.reflection,
                  .diffuse = view_diffuse_of(&at, set_of(r, i)),
                  .parts = at.parts,
                  .rough_fresnel = at.rough_fresnel,
                  .override = at.override != VIEW_AS_IS}};

    view_set_place(&at, r->places % view_places(&at));
    fill_frame(r, i, &at, &frame);
    if (at.mode == VIEW_SCENE)
        return view_scene_draw(of->stage, &at, to);
    if (!view_shows_materials(&at))
        return inspect(r, of, to, at.filter, (const GLfloat[3]){0});
    if (!view_wants_reference(&at))
        return view_subject_draw(&seen, to);
    if (!of->truth)
        of->truth = view_truth_create(set_of(r, 0));
    return of->truth &&
           view_truth_draw(of->truth, &of->frame, &seen, r->samples);
}

/* Adds a place, or samples of the reference, to the picture of a state. */
static bool draw_side(view_renderer *r, int i)
{
    side *of = &r->side[i];
    const int all = view_places(&of->settings);
    const bool sampled = view_wants_reference(&of->settings);
    view_image *to = r->places ? &of->picture : &of->mean;

    if (r->places >= all && !sampled)
        return true;
    bind_maps(maps_of(r, i));
    if (has_ground(&of->settings) &&
        !draw_depths(r, &of->frame, r->places == 0 || r->sides > 1))
        return false;
    view_gl_bind(VIEW_UNIT_BACKDROP, GL_TEXTURE_2D, r->backdrop);
    return (sampled || view_image_make(to, r->area.width, r->area.height)) &&
           draw_place(r, i, to) &&
           (sampled || to == &of->mean ||
            view_mean_add(&of->picture, 1 / (1 + (float)r->places), &of->mean));
}

static GLuint picture_of(const view_renderer *r, int i)
{
    const side *of = &r->side[i];

    return view_wants_reference(&of->settings) ? of->truth->mean.texture
                                               : of->mean.texture;
}

static bool display_pass(const view_renderer *r, const view_frame *f,
                         GLuint framebuffer, int x, int y)
{
    const view_settings *s = &r->side[0].settings;
    /* Whether the tone curve is all that is to display. */
    const bool plain = view_is_lit(s) && r->sides == 1 && !s->false_colour &&
                       s->background != VIEW_BACKGROUND_TRANSPARENT;
    char text[32];

    snprintf(text, sizeof text, "#define TONE %d\n", f->show[0]);
    const GLuint program = view_program(plain && f->show[0] >= 0 ? text : "",
                                        "full.vert", "display.frag");
    if (!program)
        return false;
    view_gl_block(VIEW_BLOCK_FRAME, f, sizeof *f);
    gl.BindFramebuffer(GL_FRAMEBUFFER, framebuffer);
    gl.Viewport(x, y, r->area.width, r->area.height);
    gl.Disable(GL_BLEND);
    view_gl_bind(VIEW_UNIT_PICTURE, GL_TEXTURE_2D, picture_of(r, 0));
    view_gl_bind(VIEW_UNIT_OTHER, GL_TEXTURE_2D,
                 r->sides > 1 ? picture_of(r, 1) : 0);
    gl.UseProgram(program);
    view_gl_draw_full(program);
    return true;
}

bool view_renderer_draw(view_renderer *r, const view_settings state[2],
                        const view_area *area)
{
    bool ok = true;

    if (!set_of(r, 0) || (state->mode == VIEW_MODEL && !r->model))
        return view_fail("nothing is loaded that could be drawn");
    r->stale |= area->width != r->area.width ||
                area->height != r->area.height ||
                r->sides != (state[0].compare ? 2 : 1);
    r->area = *area;
    r->sides = state[0].compare ? 2 : 1;
    for (int i = 0; i < r->sides && ok; i++) {
        r->stale |= state[i].seams != r->side[i].settings.seams;
        find_backdrop(r, &state[i]);
        ok = update(r, i, &state[i]);
    }
    if (r->stale)
        r->places = 0;
    r->stale = false;
    for (int i = 0; i < r->sides && ok; i++) {
        if (state[i].seams)
            gl.Disable(GL_TEXTURE_CUBE_MAP_SEAMLESS);
        ok = draw_side(r, i);
        gl.Enable(GL_TEXTURE_CUBE_MAP_SEAMLESS);
    }
    if (!ok) {
        r->stale = true;
        return false;
    }
    r->places++;
    return display_pass(r, &r->side[0].frame, r->target, area->x, area->y) &&
           view_gl_check("drawing");
}

void view_renderer_target(view_renderer *r, GLuint framebuffer)
{
    r->target = framebuffer;
}

void view_renderer_show(view_renderer *r, double ev)
{
    r->side[0].settings.ev = ev;
    r->side[0].frame.display[0] = (float)exp2(ev);
    display_pass(r, &r->side[0].frame, r->target, r->area.x, r->area.y);
}

bool view_renderer_complete(const view_renderer *r)
{
    return r->places >= view_places(&r->side[0].settings);
}

/* ---- reading back ------------------------------------------------------- */

/* Reads RGB or alpha of a picture. */
static bool read_floats(const view_renderer *r, GLuint picture, GLenum format,
                        float *to)
{
    const size_t row = (size_t)r->area.width * (format == GL_RGB ? 3 : 1);

    view_gl_bind(VIEW_UNIT_PICTURE, GL_TEXTURE_2D, picture);
    gl.GetTexImage(GL_TEXTURE_2D, 0, format, GL_FLOAT, to);
    view_picture_flip(to, row * sizeof *to, r->area.height);
    return view_gl_check("reading the picture");
}

bool view_renderer_read(const view_renderer *r, int i, float *rgb)
{
    if (i >= r->sides)
        return view_fail("there is no picture to read");
    return read_floats(r, picture_of(r, i), GL_RGB, rgb);
}

bool view_renderer_linear(const view_renderer *r, float *rgb)
{
    const int width = r->area.width, height = r->area.height;
    view_frame raw = r->side[0].frame;
    view_image shown = {0};

    raw.show[0] = -1;
    const bool ok = view_image_make(&shown, width, height) &&
                    display_pass(r, &raw, shown.framebuffer, 0, 0) &&
                    read_floats(r, shown.texture, GL_RGB, rgb);
    view_image_free(&shown);
    return ok;
}

view_scene *view_renderer_stage(const view_renderer *r)
{
    return r->side[0].stage;
}

const view_truth *view_renderer_truth(const view_renderer *r)
{
    for (int i = 0; i < r->sides; i++)
        if (view_wants_reference(&r->side[i].settings))
            return r->side[i].truth;
    return NULL;
}

int view_renderer_samples(const view_renderer *r)
{
    const view_truth *truth = view_renderer_truth(r);

    return truth ? truth->samples : 0;
}

void view_renderer_restart(view_renderer *r)
{
    r->stale = true;
    for (int i = 0; i < 2; i++)
        if (r->side[i].truth)
            r->side[i].truth->samples = 0;
}

void view_renderer_pace(view_renderer *r, int samples)
{
    r->samples = samples;
}

/* What each pixel shows: a sphere of the grid, an opaque material of the model,
 * of other pictures 0 where there is something; -1: nothing. */
static bool find_shown(const view_renderer *r, int *shown)
{
    const side *of = &r->side[0];
    const bool numbers = view_shows_materials(&of->settings);
    const size_t count = (size_t)r->area.width * (size_t)r->area.height;
    const view_subject seen = {
        .frame = &of->frame,
        .model = of->settings.mode == VIEW_MODEL ? r->model : NULL,
        .light = {.parts = VIEW_PARTS_COUNT}};
    float *value = ibl_need(malloc(count * sizeof *value));
    view_image picture = {0};
    const bool ok = (!numbers || (view_image_make(&picture, r->area.width,
                                                  r->area.height) &&
                                  view_subject_draw(&seen, &picture))) &&
                    read_floats(r, numbers ? picture.texture : of->mean.texture,
                                numbers ? GL_RED : GL_ALPHA, value);

    view_image_free(&picture);
    for (size_t i = 0; i < count; i++)
        shown[i] = numbers ? (int)value[i] - 1 : -(value[i] <= 0);
    free(value);
    return ok;
}

/* Spheres, or materials of the model; of other pictures 1. */
static int count_parts(const view_renderer *r)
{
    const view_settings *s = &r->side[0].settings;
    int count = s->mode == VIEW_SPHERES ? s->rows * s->columns : 1;

    while (s->mode == VIEW_MODEL && view_model_material(r->model, count))
        count++;
    return count;
}

view_error *view_renderer_errors(view_renderer *r, int *number)
{
    const int count = *number = count_parts(r);
    const size_t pixels = (size_t)r->area.width * (size_t)r->area.height;
    const view_truth *truth = view_renderer_truth(r);
    double factor = 0;
    const GLuint second = truth ? view_truth_second(truth, &factor) : 0;

    if (r->sides < 2)
        return NULL;
    view_error *errors = ibl_need(calloc((size_t)count + 1, sizeof *errors));
    float *rgb = ibl_need(malloc(9 * pixels * sizeof *rgb));
    int *shown = ibl_need(malloc(pixels * sizeof *shown));
    const float *const pictures[4] = {
        rgb, rgb + 3 * pixels,
        truth && truth == r->side[0].truth ? rgb : rgb + 3 * pixels,
        second ? rgb + 6 * pixels : NULL};
    const bool ok =
        view_renderer_read(r, 0, rgb) &&
        view_renderer_read(r, 1, rgb + 3 * pixels) &&
        (!second || read_floats(r, second, GL_RGB, rgb + 6 * pixels)) &&
        find_shown(r, shown);
    if (ok)
        view_errors(shown, count, r->area.width, r->area.height, pictures,
                    errors);
    for (int i = 0; ok && i < count; i++) {
        errors[i].noise2 *= factor;
        errors[count].difference2 += errors[i].difference2;
        errors[count].truth2 += errors[i].truth2;
        errors[count].noise2 += errors[i].noise2;
        errors[count].pixels += errors[i].pixels;
    }
    free(shown);
    free(rgb);
    if (ok)
        return errors;
    free(errors);
    return NULL;
}
