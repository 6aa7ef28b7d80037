/* SPDX-License-Identifier: MIT */
#include "view/renderer.h"
#include "common/process.h"
#include "common/signals.h"
#include "view/frame.h"
#include "view/gl.h"
#include "view/ground.h"
#include "view/message.h"
#include "view/truth.h"

#include <math.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum {
    MAX_SPHERES = VIEW_MAX_GRID * VIEW_MAX_GRID
};

/* A view_sphere as attributes of sphere.vert. */
typedef struct instance {
    float value[12];
} instance;

_Static_assert(sizeof(view_sphere) == 12 * sizeof(double),
               "all are attributes");

/* One of two states that are compared, or the only one. */
typedef struct side {
    const baked_set *set; /* NULL: that of the first side */
    GLuint maps[VIEW_CONTENTS];
    view_settings settings;   /* of the last draw */
    view_frame frame;         /* the same, at the pixels' centres */
    view_image picture, mean; /* of one place in the pixels; of all so far */
    view_truth *truth;        /* made on first use */
    view_scene *stage;        /* the same */
    GLuint instances, buffer; /* of spheres */
    int count;
    instance sorted[MAX_SPHERES];
} side;

struct view_renderer {
    GLuint inspect, display, mean; /* programs */
    /* Made on first use: of each backdrop without ground and with it, of
     * spheres, and of tones for materials alone. */
    GLuint sky[2 * VIEW_BACKDROPS], spheres[VIEW_LIGHTINGS], tone[VIEW_TONES];
    GLuint nearest, smooth; /* samplers of maps */
    GLuint frame_buffer;
    side side[2];
    int sides;                    /* of the last draw */
    int places;                   /* drawn */
    const view_probe_set *probes; /* of the scene, or NULL */
    view_model *model;            /* that was set, or NULL */
    view_model *ball;             /* made on first use */
    view_ground ground;           /* of the model */
    int samples;     /* of the reference per draw; 0: by the clock */
    GLuint backdrop; /* the map of the set, or 0 */
    bool knows_backdrop;
    GLuint target;  /* framebuffer */
    view_area area; /* of the last draw; no width: nothing drawn yet */
    bool stale;     /* the linear pictures must be drawn again */
};

/* ---- what never changes ------------------------------------------------ */

static GLuint make_sampler(GLint filter)
{
    GLuint sampler;

    gl.GenSamplers(1, &sampler);
    gl.SamplerParameteri(sampler, GL_TEXTURE_MIN_FILTER,
                         filter == GL_LINEAR ? GL_LINEAR_MIPMAP_NEAREST
                                             : GL_NEAREST_MIPMAP_NEAREST);
    gl.SamplerParameteri(sampler, GL_TEXTURE_MAG_FILTER, filter);
    return sampler;
}

static bool make(view_renderer *r)
{
    r->inspect = view_program("full.vert", "inspect.frag");
    r->display = r->inspect ? view_program("full.vert", "display.frag") : 0;
    r->mean = r->display ? view_program("full.vert", "mean.frag") : 0;
    if (!r->mean)
        return false;
    for (int i = 0; i < 2; i++) {
        side *s = &r->side[i];
        gl.GenVertexArrays(1, &s->instances);
        gl.BindVertexArray(s->instances);
        s->buffer = view_gl_buffer(GL_ARRAY_BUFFER, sizeof s->sorted, NULL);
        for (GLuint k = 0; k < 3; k++)
            view_gl_attribute(k, 4, sizeof(instance), 4 * k * sizeof(float), 1);
    }
    gl.BindVertexArray(0);
    r->frame_buffer =
        view_gl_buffer(GL_UNIFORM_BUFFER, sizeof(view_frame), NULL);
    r->nearest = make_sampler(GL_NEAREST);
    r->smooth = make_sampler(GL_LINEAR);
    return view_gl_check("making the renderer");
}

view_renderer *view_renderer_create(void)
{
    view_renderer *r = ibl_need(calloc(1, sizeof *r));

    if (make(r))
        return r;
    view_renderer_free(r);
    return NULL;
}

void view_renderer_free(view_renderer *r)
{
    if (!r)
        return;
    for (int i = 0; i < 2; i++) {
        view_truth_free(r->side[i].truth);
        view_scene_free(r->side[i].stage);
    }
    view_model_free(r->ball);
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
    GLuint maps[VIEW_CONTENTS] = {0};

    for (int i = 0; i < VIEW_CONTENTS; i++) {
        const ibl_texture *tex = &set->texture[i];
        if (!tex->data)
            continue; /* the sky and the lobes may be absent */
        maps[i] = view_upload(
            tex, false, set->path[i] ? set->path[i] : view_content_names[i]);
        if (!maps[i]) {
            gl.DeleteTextures(VIEW_CONTENTS, maps);
            return false;
        }
    }
    gl.DeleteTextures(VIEW_CONTENTS, to->maps);
    memcpy(to->maps, maps, sizeof maps);
    to->set = set;
    return true;
}

bool view_renderer_load(view_renderer *r, const baked_set *set)
{
    if (!load_maps(&r->side[0], set))
        return false;
    r->knows_backdrop = r->ground.known = false;
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

/* What VIEW_MODEL shows. */
static view_model *model(const view_renderer *r)
{
    return r->model ? r->model : r->ball;
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

static void bind_maps(const GLuint maps[VIEW_CONTENTS])
{
    const GLuint sky = maps[VIEW_SKY], cube = GL_TEXTURE_CUBE_MAP;
    const GLuint level0 = maps[VIEW_SPECULAR];

    view_gl_bind(VIEW_UNIT_SPECULAR, cube, level0);
    view_gl_bind(VIEW_UNIT_IRRADIANCE, cube, maps[VIEW_IRRADIANCE]);
    view_gl_bind(VIEW_UNIT_LUT, GL_TEXTURE_2D, maps[VIEW_LUT]);
    view_gl_bind(VIEW_UNIT_SKY, cube, sky ? sky : level0);
    view_gl_bind(VIEW_UNIT_LOBES, GL_TEXTURE_2D_ARRAY, maps[VIEW_LOBES]);
    view_gl_bind(VIEW_UNIT_SHEEN, cube, maps[VIEW_SHEEN]);
    view_gl_bind(VIEW_UNIT_SHEEN_TABLE, GL_TEXTURE_2D, maps[VIEW_SHEEN_TABLE]);
}

/* ---- spheres ----------------------------------------------------------- */

static double distance2(const view_sphere *p, const double eye[3])
{
    double sum = 0;

    for (int k = 0; k < 3; k++)
        sum += (p->centre[k] - eye[k]) * (p->centre[k] - eye[k]);
    return sum;
}

/* From back to front: among spheres of equal radius, a farther centre is never
 * in front. Sorted by insertion, since the order hardly changes. */
static void update_spheres(view_renderer *r, side *to, const view_settings *s)
{
    const view_camera camera = view_camera_of(s, r->area.width, r->area.height);
    view_sphere spheres[MAX_SPHERES];
    instance sorted[MAX_SPHERES];
    int order[MAX_SPHERES];
    const int count = view_grid(s, spheres);
    const size_t bytes = count * sizeof *sorted;

    for (int i = 0; i < count; i++) {
        int at = i;
        const double d = distance2(&spheres[i], camera.eye);
        for (; at && distance2(&spheres[order[at - 1]], camera.eye) < d; at--)
            order[at] = order[at - 1];
        order[at] = i;
    }
    for (int i = 0; i < count; i++) {
        double values[12];
        memcpy(values, &spheres[order[i]], sizeof values);
        for (int k = 0; k < 12; k++)
            sorted[i].value[k] = (float)values[k];
    }
    if (count == to->count && !memcmp(sorted, to->sorted, bytes))
        return;
    view_renderer_restart(r);
    to->count = count;
    memcpy(to->sorted, sorted, bytes);
    gl.BindBuffer(GL_ARRAY_BUFFER, to->buffer);
    gl.BufferSubData(GL_ARRAY_BUFFER, 0, (GLsizeiptr)bytes, sorted);
}

/* ---- frames ------------------------------------------------------------ */

static void upload_frame(const view_renderer *r, const view_frame *f)
{
    gl.BindBuffer(GL_UNIFORM_BUFFER, r->frame_buffer);
    gl.BufferSubData(GL_UNIFORM_BUFFER, 0, sizeof *f, f);
    gl.BindBufferBase(GL_UNIFORM_BUFFER, VIEW_BLOCK_FRAME, r->frame_buffer);
}

static bool has_ground(const view_settings *s)
{
    return s->ground && s->mode == VIEW_MODEL;
}

/* Backdrop and main light are those of the first set for both. */
static void fill_frame(const view_renderer *r, int i, const view_settings *s,
                       view_frame *f)
{
    view_frame_fill(f, s, set_of(r, i), r->area.width, r->area.height);
    if (has_ground(s))
        view_ground_fill(&r->ground, s, set_of(r, 0), model(r), f);
    if (!r->backdrop)
        return;
    if (f->shading[2] == VIEW_BACKDROP_CUBE && !set_of(r, 0)->own_sky)
        f->shading[2] = VIEW_BACKDROP_MAP;
    f->diffuse[2] = (float)(set_of(r, 0)->source_yaw / 360);
    f->diffuse[3] = 1;
}

/* Captures what is due for the scene; the picture begins anew if that changes
 * it. */
static bool update_stage(view_renderer *r, int i, const view_settings *s)
{
    side *of = &r->side[i];
    const GLuint *maps = maps_of(r, i), level0 = maps[VIEW_SPECULAR];
    view_room_environment e = {.specular = level0,
                               .irradiance = maps[VIEW_IRRADIANCE],
                               .sky = maps[VIEW_SKY] ? maps[VIEW_SKY] : level0,
                               .map = r->backdrop && !set_of(r, 0)->own_sky};

    fill_frame(r, i, s, &e.frame);
    if (!of->stage && (of->stage = view_scene_create())) {
        view_scene_use(of->stage, r->probes);
        of->stage->told = i && !r->side[1].set; /* about the same set */
    }
    return of->stage && view_scene_update(of->stage, s, &e, maps[VIEW_LUT],
                                          r->model, &r->stale);
}

/* Prepares what the mode shows. False, with a message. */
static bool update(view_renderer *r, int i, const view_settings *state)
{
    side *to = &r->side[i];
    view_settings at = *state, *s = &at;
    view_frame frame;

    if (!r->model && s->mode == VIEW_MODEL)
        s->override = VIEW_MATERIAL;
    if (has_ground(s) && !r->ground.known)
        view_ground_load(&r->ground, set_of(r, 0));

    if (s->mode == VIEW_SPHERES)
        update_spheres(r, to, s);
    if (s->mode == VIEW_MODEL && !r->model && !r->ball &&
        !(r->ball = view_model_ball()))
        return false;
    if (s->mode == VIEW_MODEL) {
        view_model_place(model(r), (const double[3]){0}, 1);
        s->pose = view_model_camera(model(r), s->file_camera - 1);
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

/* The program of what is behind materials. */
static GLuint *sky_of(view_renderer *r, const side *of)
{
    return &r->sky[2 * of->frame.shading[2] + has_ground(&of->settings)];
}

/* Whether the tone curve is all that is to display. */
static bool is_plain(const view_renderer *r)
{
    const view_settings *s = &r->side[0].settings;

    return view_is_lit(s) && r->sides == 1 && !s->false_colour &&
           s->background != VIEW_BACKGROUND_TRANSPARENT;
}

/* Makes the programs of the frame. */
static bool make_variants(view_renderer *r)
{
    const view_settings *s = &r->side[0].settings;
    char define[64];

    for (int i = 0; i < r->sides && view_shows_materials(s); i++) {
        const side *of = &r->side[i];
        snprintf(define, sizeof define, "#define BACKDROP %d\n%s",
                 of->frame.shading[2],
                 has_ground(&of->settings) ? VIEW_GROUND_DEFINE : "");
        if (!*sky_of(r, of))
            *sky_of(r, of) = view_program_from(view_shader_files, define,
                                               "full.vert", "sky.frag");
        if (!*sky_of(r, of))
            return false;
    }
    snprintf(define, sizeof define, "#define TONE %d\n", (int)s->tone);
    if (is_plain(r) && !r->tone[s->tone])
        r->tone[s->tone] = view_program_from(view_shader_files, define,
                                             "full.vert", "display.frag");
    return !is_plain(r) || r->tone[s->tone];
}

static view_subject subject(view_renderer *r, const side *of)
{
    const bool shows_model = of->settings.mode == VIEW_MODEL;

    return (view_subject){.sky = *sky_of(r, of),
                          .instances = of->instances,
                          .count = of->count,
                          .programs = r->spheres,
                          .model = shows_model ? model(r) : NULL,
                          .width = r->area.width,
                          .height = r->area.height,
                          .eye = of->frame.eye,
                          .frame = r->frame_buffer,
                          .mean = r->mean};
}

/* Draws a map. */
static void inspect(const view_renderer *r, const side *of)
{
    const GLuint sampler = of->settings.filter ? r->smooth : r->nearest;
    static const GLuint units[] = {VIEW_UNIT_SPECULAR, VIEW_UNIT_IRRADIANCE,
                                   VIEW_UNIT_BACKDROP};

    gl.BindFramebuffer(GL_FRAMEBUFFER, of->picture.framebuffer);
    for (int i = 0; i < 3; i++)
        gl.BindSampler(units[i], sampler);
    view_gl_draw_full(r->inspect);
    for (int i = 0; i < 3; i++)
        gl.BindSampler(units[i], 0);
}

/* Uploads the frame of the next place of a state. */
static view_settings set_place(const view_renderer *r, int i)
{
    view_settings at = r->side[i].settings;
    view_frame frame;

    view_set_place(&at, r->places % view_places(&at));
    fill_frame(r, i, &at, &frame);
    upload_frame(r, &frame);
    return at;
}

/* Draws one place of a state. */
static bool draw_place(view_renderer *r, int i)
{
    side *of = &r->side[i];
    const view_subject seen = subject(r, of);
    const view_settings at = set_place(r, i);
    const view_lighting light = {.reflection = at.reflection,
                                 .diffuse = view_diffuse_of(&at, set_of(r, i)),
                                 .parts = at.parts,
                                 .rough_fresnel = at.rough_fresnel,
                                 .override = at.override != VIEW_AS_IS,
                                 .sheen =
                                     set_of(r, i)->texture[VIEW_SHEEN].data};

    if (at.mode == VIEW_SCENE)
        return view_scene_draw(of->stage, &at, &of->picture);
    if (view_shows_materials(&at))
        return view_subject_draw(&seen, &light, &of->picture);
    inspect(r, of);
    return true;
}

static bool draw_truth(view_renderer *r, int i)
{
    side *of = &r->side[i];
    const view_subject seen = subject(r, of);

    if (!of->truth)
        of->truth = view_truth_create(set_of(r, 0));
    set_place(r, i);
    return of->truth &&
           view_truth_draw(of->truth, &of->frame, &seen, r->samples);
}

/* Adds a place, or samples of the reference, to the picture of a state. */
static bool draw_side(view_renderer *r, int i)
{
    side *of = &r->side[i];
    const int all = view_places(&of->settings);

    bind_maps(maps_of(r, i));
    if (has_ground(&of->settings) &&
        !view_ground_draw(&r->ground, &of->frame, model(r),
                          r->places == 0 || r->sides > 1))
        return false;
    view_gl_bind(VIEW_UNIT_BACKDROP, GL_TEXTURE_2D, r->backdrop);
    gl.Viewport(0, 0, r->area.width, r->area.height);
    gl.Disable(GL_BLEND);
    if (view_wants_reference(&of->settings))
        return draw_truth(r, i);
    if (r->places >= all)
        return true;
    return view_image_make(&of->picture, r->area.width, r->area.height) &&
           draw_place(r, i) &&
           (all == 1 || view_mean_add(r->mean, &of->picture,
                                      1 / (1 + (float)r->places), &of->mean));
}

static GLuint picture_of(const view_renderer *r, int i)
{
    const side *of = &r->side[i];

    return view_wants_reference(&of->settings) ? view_truth_texture(of->truth)
           : view_places(&of->settings) > 1    ? of->mean.texture
                                               : of->picture.texture;
}

static void display_pass(const view_renderer *r, GLuint framebuffer, int x,
                         int y)
{
    const GLuint program =
        is_plain(r) ? r->tone[r->side[0].settings.tone] : r->display;

    gl.BindFramebuffer(GL_FRAMEBUFFER, framebuffer);
    gl.Viewport(x, y, r->area.width, r->area.height);
    gl.Disable(GL_BLEND);
    view_gl_bind(VIEW_UNIT_PICTURE, GL_TEXTURE_2D, picture_of(r, 0));
    view_gl_bind(VIEW_UNIT_OTHER, GL_TEXTURE_2D,
                 r->sides > 1 ? picture_of(r, 1) : 0);
    gl.UseProgram(program);
    gl.Uniform2f(gl.GetUniformLocation(program, "origin"), (float)x, (float)y);
    view_gl_draw_full(program);
}

bool view_renderer_draw(view_renderer *r, const view_settings state[2],
                        const view_area *area)
{
    bool ok = true;

    if (!set_of(r, 0))
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
    ok = ok && make_variants(r);
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
    upload_frame(r, &r->side[0].frame);
    display_pass(r, r->target, area->x, area->y);
    return view_gl_check("drawing");
}

void view_renderer_target(view_renderer *r, GLuint framebuffer)
{
    r->target = framebuffer;
}

void view_renderer_show(view_renderer *r, double ev)
{
    r->side[0].settings.ev = ev;
    r->side[0].frame.display[0] = (float)exp2(ev);
    upload_frame(r, &r->side[0].frame);
    display_pass(r, r->target, r->area.x, r->area.y);
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
    upload_frame(r, &raw);
    bool ok = view_image_make(&shown, width, height);
    if (ok) {
        display_pass(r, shown.framebuffer, 0, 0);
        ok = read_floats(r, shown.texture, GL_RGB, rgb);
    }
    view_image_free(&shown);
    upload_frame(r, &r->side[0].frame);
    return ok;
}

view_scene *view_renderer_stage(const view_renderer *r)
{
    return r->side[0].stage;
}

/* The side that is the reference, or NULL. */
static const side *sampled(const view_renderer *r)
{
    for (int i = 0; i < r->sides; i++)
        if (view_wants_reference(&r->side[i].settings) && r->side[i].truth)
            return &r->side[i];
    return NULL;
}

int view_renderer_samples(const view_renderer *r)
{
    return sampled(r) ? view_truth_samples(sampled(r)->truth) : 0;
}

const char *view_renderer_environment(const view_renderer *r)
{
    return sampled(r) ? view_truth_environment(sampled(r)->truth) : NULL;
}

void view_renderer_restart(view_renderer *r)
{
    r->stale = true;
    for (int i = 0; i < 2; i++)
        if (r->side[i].truth)
            view_truth_restart(r->side[i].truth);
}

void view_renderer_pace(view_renderer *r, int samples)
{
    r->samples = samples;
}

/* What each pixel shows: a sphere of the grid, an opaque material of the model,
 * of other pictures 0 where there is something; -1: nothing. */
static bool find_shown(view_renderer *r, int *shown)
{
    side *of = &r->side[0];
    const view_settings *s = &of->settings;
    const size_t count = (size_t)r->area.width * (size_t)r->area.height;
    const view_lighting number = {.parts = VIEW_PARTS_COUNT};
    view_subject seen = subject(r, of);
    view_image picture = {0};
    bool ok = true;

    if (s->mode == VIEW_SPHERES) {
        view_errors_spheres(s, r->area.width, r->area.height, shown);
        return true;
    }
    float *value = ibl_need(malloc(count * sizeof *value));
    if (s->mode == VIEW_MODEL) {
        gl.Viewport(0, 0, r->area.width, r->area.height);
        upload_frame(r, &of->frame);
        seen.sky = 0;
        ok = view_image_make(&picture, r->area.width, r->area.height) &&
             view_subject_draw(&seen, &number, &picture) &&
             read_floats(r, picture.texture, GL_RED, value);
        view_image_free(&picture);
    } else {
        ok = read_floats(r, of->picture.texture, GL_ALPHA, value);
    }
    for (size_t i = 0; i < count; i++)
        shown[i] = s->mode == VIEW_MODEL ? (int)value[i] - 1 : -(value[i] <= 0);
    free(value);
    return ok;
}

int view_renderer_parts(const view_renderer *r)
{
    const view_settings *s = &r->side[0].settings;

    return s->mode == VIEW_MODEL     ? view_model_materials(model(r))
           : s->mode == VIEW_SPHERES ? s->rows * s->columns
                                     : 1;
}

const char *view_renderer_part(const view_renderer *r, int i)
{
    return r->side[0].settings.mode == VIEW_MODEL
               ? view_model_material(model(r), i)
               : "";
}

int view_renderer_errors(view_renderer *r, view_error *errors)
{
    const int count = view_renderer_parts(r);
    const size_t pixels = (size_t)r->area.width * (size_t)r->area.height;
    const side *of = sampled(r);
    double factor = 0;
    const GLuint second = of ? view_truth_second(of->truth, &factor) : 0;

    if (r->sides < 2)
        return 0;
    float *rgb = ibl_need(malloc(9 * pixels * sizeof *rgb));
    int *shown = ibl_need(malloc(pixels * sizeof *shown));
    const float *const pictures[4] = {
        rgb, rgb + 3 * pixels, of == &r->side[0] ? rgb : rgb + 3 * pixels,
        second ? rgb + 6 * pixels : NULL};
    const bool ok =
        view_renderer_read(r, 0, rgb) &&
        view_renderer_read(r, 1, rgb + 3 * pixels) &&
        (!second || read_floats(r, second, GL_RGB, rgb + 6 * pixels)) &&
        find_shown(r, shown);
    if (ok)
        view_errors(shown, count, r->area.width, r->area.height, pictures,
                    errors);
    for (int i = 0; ok && i < count; i++)
        errors[i].noise2 *= factor;
    free(shown);
    free(rgb);
    return ok ? count : 0;
}
