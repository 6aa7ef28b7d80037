/* SPDX-License-Identifier: MIT */
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/process.h"
#include "common/signals.h"
#include "view/errors.h"
#include "view/frame.h"
#include "view/gl.h"
#include "view/message.h"
#include "view/picture.h"
#include "view/program.h"
#include "view/renderer.h"
#include "view/truth.h"
#include "view/upload.h"

enum {
    MAX_SPHERES = VIEW_MAX_GRID * VIEW_MAX_GRID,
    BLURRED = VIEW_BACKDROP_MAP + 1, /* of sky.frag */
    BACKDROPS
};

/* A model that moves has one sample of a pixel if all take longer. */
static const double slow_seconds = 0.1;

/* A view_sphere as attributes of sphere.vert. */
typedef struct instance {
    float value[12];
} instance;

_Static_assert(sizeof(view_sphere) == 12 * sizeof(double),
               "all are attributes");

struct view_renderer {
    GLuint sphere, inspect, display; /* programs */
    view_mean mean;
    /* Made on first use: of each backdrop, and of tones for materials alone. */
    GLuint sky[BACKDROPS], tone[VIEW_TONES];
    GLuint nearest; /* sampler of maps */
    GLuint instances, instance_buffer, frame_buffer;
    GLuint maps[2][VIEW_CONTENTS]; /* of set and other */
    /* Linear pictures of settings.reflection and against: of one place in the
     * pixels, and the mean of all places so far. */
    view_image picture[2], means[2];
    int places;        /* drawn */
    double seconds;    /* that the last picture with all its samples took */
    bool rough;        /* the picture has one sample of a pixel, for it moves */
    view_truth *truth; /* made on first use */
    view_scene *stage; /* the same */
    const view_probe_set *probes; /* probes of the stage, or NULL */
    view_model *model;            /* that was set, or NULL */
    view_model *ball;             /* made on first use */
    view_canvas canvas;           /* of the model */
    int samples; /* samples of the reference per draw; 0: by the clock */
    const baked_set *set;
    const baked_set *other; /* what the set is compared with, or NULL */
    GLuint backdrop;        /* the map of the set, or 0 */
    bool knows_backdrop;
    /* of the last draw */
    view_settings settings;
    view_frame frame;
    int width, height; /* 0: nothing drawn yet */
    bool has_truth;
    view_frame linear; /* frame of the linear picture, at the pixels' centres */
    bool stale;        /* the linear picture must be drawn again */
    int count;
    instance sorted[MAX_SPHERES];
};

/* ---- what never changes ------------------------------------------------ */

static bool make(view_renderer *r)
{
    r->sphere = view_program("sphere.vert", "sphere.frag");
    r->inspect = r->sphere ? view_program("full.vert", "inspect.frag") : 0;
    r->display = r->inspect ? view_program("full.vert", "display.frag") : 0;
    if (!r->display || !view_mean_make(&r->mean))
        return false;
    gl.GenVertexArrays(1, &r->instances);
    gl.BindVertexArray(r->instances);
    r->instance_buffer =
        view_gl_buffer(GL_ARRAY_BUFFER, sizeof r->sorted, NULL);
    for (GLuint i = 0; i < 3; i++)
        view_gl_attribute(i, 4, sizeof(instance), 4 * i * sizeof(float), 1);
    gl.BindVertexArray(0);
    r->frame_buffer = view_gl_buffer(GL_UNIFORM_BUFFER, sizeof r->frame, NULL);
    gl.GenSamplers(1, &r->nearest);
    gl.SamplerParameteri(r->nearest, GL_TEXTURE_MIN_FILTER,
                         GL_NEAREST_MIPMAP_NEAREST);
    gl.SamplerParameteri(r->nearest, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
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
    view_truth_free(r->truth);
    view_scene_free(r->stage);
    view_model_free(r->ball);
    free(r);
}

/* ---- the set ----------------------------------------------------------- */

/* Replaces the maps of a set. */
static bool load_maps(GLuint to[VIEW_CONTENTS], const baked_set *set)
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
    gl.DeleteTextures(VIEW_CONTENTS, to);
    memcpy(to, maps, sizeof maps);
    return true;
}

bool view_renderer_load(view_renderer *r, const baked_set *set)
{
    if (!load_maps(r->maps[0], set))
        return false;
    r->set = set;
    r->knows_backdrop = false;
    view_renderer_probes(r, r->probes);
    view_truth_free(r->truth); /* made again on its next use */
    r->truth = NULL;
    r->has_truth = false;
    return true;
}

/* Uploads the map of the set, when it or the reference is first seen. */
static void find_backdrop(view_renderer *r, const view_settings *s)
{
    const bool seen = (s->mode == VIEW_SPHERES || s->mode == VIEW_MODEL ||
                       s->mode == VIEW_SCENE) &&
                      s->sky && !r->set->own_sky && s->blur <= 0;

    if (r->knows_backdrop || (!seen && !view_wants_reference(s)))
        return;
    gl.DeleteTextures(1, &r->backdrop);
    gl.ActiveTexture(GL_TEXTURE0 + VIEW_UNIT_OTHER);
    r->backdrop = view_upload_map(r->set);
    r->knows_backdrop = true;
}

bool view_renderer_against(view_renderer *r, const baked_set *set)
{
    if (!load_maps(r->maps[1], set))
        return false;
    r->other = set;
    r->stale = true;
    return true;
}

/* A set by its specular file's folder, if two have the same name. */
const char *view_renderer_side(const view_renderer *r, const view_settings *s,
                               bool other, char *text, size_t size)
{
    const view_reflection way = other ? s->against : s->reflection;
    const baked_set *set = other ? r->other : r->set;
    const char *name = view_reflection_names[way];

    if (!r->other || (other && way == VIEW_REFERENCE))
        return name;
    if (strcmp(r->set->name, r->other->name) || !set->path[VIEW_SPECULAR])
        snprintf(text, size, "%s of %.80s", name, set->name);
    else
        snprintf(text, size, "%s of %.160s", name, set->path[VIEW_SPECULAR]);
    return text;
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

/* Sorts from back to front: among spheres of equal radius, a farther centre is
 * never in front. By insertion, since the order hardly changes. */
static void sort_spheres(const view_sphere *spheres, int count,
                         const double eye[3], int *order)
{
    for (int i = 0; i < count; i++) {
        int at = i;
        const double d = distance2(&spheres[i], eye);
        for (; at && distance2(&spheres[order[at - 1]], eye) < d; at--)
            order[at] = order[at - 1];
        order[at] = i;
    }
}

static void update_spheres(view_renderer *r, const view_settings *s, int width,
                           int height)
{
    const view_camera camera = view_camera_of(s, width, height);
    view_sphere spheres[MAX_SPHERES];
    instance sorted[MAX_SPHERES];
    int order[MAX_SPHERES];
    const int count = view_grid(s, spheres);
    const size_t bytes = count * sizeof *sorted;

    sort_spheres(spheres, count, camera.eye, order);
    for (int i = 0; i < count; i++) {
        double values[12];
        memcpy(values, &spheres[order[i]], sizeof values);
        for (int k = 0; k < 12; k++)
            sorted[i].value[k] = (float)values[k];
    }
    if (count == r->count && !memcmp(sorted, r->sorted, bytes))
        return;
    view_renderer_restart(r);
    r->count = count;
    memcpy(r->sorted, sorted, bytes);
    gl.BindBuffer(GL_ARRAY_BUFFER, r->instance_buffer);
    gl.BufferSubData(GL_ARRAY_BUFFER, 0, (GLsizeiptr)bytes, sorted);
}

/* ---- passes ------------------------------------------------------------ */

static void upload_frame(const view_renderer *r, const view_frame *f)
{
    gl.BindBuffer(GL_UNIFORM_BUFFER, r->frame_buffer);
    gl.BufferSubData(GL_UNIFORM_BUFFER, 0, sizeof *f, f);
}

/* Whether the linear pictures can stay: all places are drawn. Without them,
 * only while the reference gathers samples; the scene moves. */
static bool stays(const view_renderer *r)
{
    const int all = view_places(&r->settings);

    return r->places >= all && view_shows_materials(&r->settings) &&
           (all > 1 || view_wants_reference(&r->settings));
}

/* The backdrop is that of the first set for both. */
static void fill_frame(const view_renderer *r, const view_settings *s,
                       const baked_set *set, view_frame *f)
{
    view_frame_fill(f, s, set, r->width, r->height);
    if (!r->backdrop)
        return;
    if (s->sky && !r->set->own_sky)
        f->shading[2] = VIEW_BACKDROP_MAP;
    f->diffuse[2] = (float)(r->set->source_yaw / 360);
    f->display[3] = 1;
}

/* Begins anew if the picture has changed; sets the next place in the pixels
 * for all that is drawn. A model that moves has fewer samples if all of them
 * are slow. */
static void choose_place(view_renderer *r, const view_settings *s)
{
    const int all = view_places(s);
    view_settings at = *s;
    view_frame frame;

    fill_frame(r, s, r->set, &r->frame);
    const bool moves =
        r->stale || memcmp(&r->frame, &r->linear, VIEW_FRAME_LINEAR) != 0;
    if (moves || r->rough || (s->mode == VIEW_SCENE && r->places >= all))
        r->places = 0;
    r->rough = moves && s->mode == VIEW_MODEL && s->multisample > 1 &&
               r->seconds > slow_seconds;
    if (r->rough)
        at.multisample = 1;
    r->linear = r->frame;
    r->stale = false;
    frame = r->frame;
    if (all > 1) {
        view_set_place(&at, r->places % all);
        fill_frame(r, &at, r->set, &frame);
    }
    r->settings = at;
    upload_frame(r, &frame);
    gl.BindBufferBase(GL_UNIFORM_BUFFER, VIEW_BLOCK_FRAME, r->frame_buffer);
}

void view_renderer_probes(view_renderer *r, const view_probe_set *probes)
{
    r->probes = probes;
    r->stale = true;
    if (r->stage)
        view_scene_use(r->stage, probes);
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

/* Makes the ball, if it is shown, of the settings. False, with a message. */
static bool make_subject(view_renderer *r, const view_settings *s)
{
    if (r->model)
        return true;
    if (!r->ball)
        r->ball = view_model_ball();
    if (r->ball && view_model_paint(r->ball, s))
        view_renderer_restart(r);
    return r->ball;
}

static bool draw_stage(view_renderer *r)
{
    const GLuint *maps = r->maps[0], level0 = maps[VIEW_SPECULAR],
                 sky = maps[VIEW_SKY];
    const view_room_environment e = {.specular = level0,
                                     .irradiance = maps[VIEW_IRRADIANCE],
                                     .sky = sky ? sky : level0,
                                     .frame = r->frame,
                                     .map = r->backdrop && !r->set->own_sky};

    if (!r->stage && (r->stage = view_scene_create()))
        view_scene_use(r->stage, r->probes);
    if (!r->stage)
        return false;
    return view_scene_draw(r->stage, &r->settings, &e, maps[VIEW_LUT],
                           r->picture[0].framebuffer, r->width, r->height);
}

/* Draws a map with unfiltered texels. */
static void inspect(const view_renderer *r)
{
    gl.BindSampler(VIEW_UNIT_SPECULAR, r->nearest);
    gl.BindSampler(VIEW_UNIT_IRRADIANCE, r->nearest);
    view_gl_draw_full(r->inspect);
    gl.BindSampler(VIEW_UNIT_SPECULAR, 0);
    gl.BindSampler(VIEW_UNIT_IRRADIANCE, 0);
}

static view_reflection reflection_of(const view_renderer *r, int side)
{
    return side ? r->settings.against : r->settings.reflection;
}

/* Draws what follows by the maps of a set. */
static void use_set(view_renderer *r, int i)
{
    view_frame frame;

    fill_frame(r, &r->settings, i ? r->other : r->set, &frame);
    upload_frame(r, &frame);
    bind_maps(r->maps[i]);
}

static int backdrop_of(const view_renderer *r)
{
    const int kind = r->frame.shading[2];

    return kind != VIEW_BACKDROP_NONE && r->frame.diffuse[3] > 0 ? BLURRED
                                                                 : kind;
}

static bool is_plain(const view_settings *s)
{
    return view_shows_materials(s) && !view_compares(s) && !s->false_colour;
}

/* Makes the program of a constant. */
static bool make_variant(GLuint *program, const char *file, const char *name,
                         int value)
{
    char define[40];

    snprintf(define, sizeof define, "#define %s %d\n", name, value);
    if (!*program)
        *program =
            view_program_from(view_shader_files, define, "full.vert", file);
    return *program;
}

/* Makes the programs of the frame. */
static bool make_variants(view_renderer *r)
{
    const view_settings *s = &r->settings;
    const int kind = backdrop_of(r);

    return (!view_shows_materials(s) ||
            make_variant(&r->sky[kind], "sky.frag", "BACKDROP", kind)) &&
           (!is_plain(s) || make_variant(&r->tone[s->tone], "display.frag",
                                         "TONE", (int)s->tone));
}

static view_subject subject(const view_renderer *r)
{
    return (view_subject){.sky = r->sky[backdrop_of(r)],
                          .instances = r->instances,
                          .count = r->count,
                          .model =
                              r->settings.mode == VIEW_MODEL ? model(r) : NULL,
                          .width = r->width,
                          .height = r->height,
                          .eye = r->frame.eye,
                          .frame = r->frame_buffer,
                          .mean = &r->mean};
}

/* Draws spheres or the model over the sky. */
static bool draw_materials(view_renderer *r, int side)
{
    const baked_set *set = side && r->other ? r->other : r->set;
    const view_subject seen = subject(r);
    const view_model_light light = {.reflection = (int)reflection_of(r, side),
                                    .sheen = set->texture[VIEW_SHEEN].data,
                                    .harmonics =
                                        r->settings.diffuse == VIEW_DIFFUSE_SH};
    const int reflection = light.reflection;

    if (!view_image_make(&r->picture[side], r->width, r->height))
        return false;
    gl.BindBuffer(GL_UNIFORM_BUFFER, r->frame_buffer);
    gl.BufferSubData(GL_UNIFORM_BUFFER, offsetof(view_frame, reflection),
                     sizeof reflection, &reflection);
    return view_subject_draw(&seen, &light, r->sphere, &r->picture[side],
                             &r->canvas, r->settings.multisample);
}

static bool draw_side(view_renderer *r, int side)
{
    if (r->settings.mode == VIEW_SCENE)
        return draw_stage(r);
    if (view_shows_materials(&r->settings))
        return draw_materials(r, side);
    inspect(r);
    return true;
}

static bool draw_sides(view_renderer *r)
{
    const int sides = view_compares(&r->settings) ? 2 : 1;

    gl.BindFramebuffer(GL_FRAMEBUFFER, r->picture[0].framebuffer);
    gl.Viewport(0, 0, r->width, r->height);
    gl.Disable(GL_BLEND);
    for (int side = 0; side < sides; side++) {
        if (side && r->other)
            use_set(r, 1);
        if ((!view_shows_materials(&r->settings) ||
             reflection_of(r, side) != VIEW_REFERENCE) &&
            (!draw_side(r, side) ||
             (view_places(&r->settings) > 1 &&
              !view_mean_add(&r->mean, &r->picture[side],
                             1 / (1 + (float)r->places), &r->means[side]))))
            return false;
    }
    if (r->other)
        use_set(r, 0);
    return true;
}

static bool linear_pass(view_renderer *r)
{
    const bool timed = r->settings.multisample > 1 && !r->places;
    const double start = timed ? ibl_now() : 0;

    if (!view_image_make(&r->picture[0], r->width, r->height))
        return false;
    if (stays(r))
        return true;
    if (!draw_sides(r))
        return false;
    if (timed) {
        gl.Finish();
        r->seconds = ibl_now() - start;
    }
    return true;
}

static bool truth_pass(view_renderer *r)
{
    const view_subject seen = subject(r);

    r->has_truth = false;
    if (!view_wants_reference(&r->settings))
        return true;
    if (!r->truth)
        r->truth = view_truth_create(r->set);
    r->has_truth =
        r->truth && view_truth_draw(r->truth, &r->frame, &seen, r->samples);
    return r->has_truth;
}

/* What a side shows. */
static GLuint picture_of(const view_renderer *r, int side)
{
    return view_shows_materials(&r->settings) &&
                   reflection_of(r, side) == VIEW_REFERENCE
               ? view_truth_texture(r->truth)
           : view_places(&r->settings) > 1 ? r->means[side].texture
                                           : r->picture[side].texture;
}

static void display_pass(const view_renderer *r, GLuint framebuffer)
{
    gl.BindFramebuffer(GL_FRAMEBUFFER, framebuffer);
    gl.Viewport(0, 0, r->width, r->height);
    gl.Disable(GL_BLEND);
    gl.BindBufferBase(GL_UNIFORM_BUFFER, VIEW_BLOCK_FRAME, r->frame_buffer);
    view_gl_bind(VIEW_UNIT_PICTURE, GL_TEXTURE_2D, picture_of(r, 0));
    view_gl_bind(VIEW_UNIT_OTHER, GL_TEXTURE_2D,
                 view_compares(&r->settings) ? picture_of(r, 1) : 0);
    view_gl_draw_full(is_plain(&r->settings) ? r->tone[r->settings.tone]
                                             : r->display);
}

bool view_renderer_draw(view_renderer *r, const view_settings *s, int width,
                        int height)
{
    if (!r->set)
        return view_fail("nothing is loaded that could be drawn");
    r->stale |= width != r->width || height != r->height;
    r->width = width;
    r->height = height;
    update_spheres(r, s, width, height);
    if (s->mode == VIEW_MODEL && !make_subject(r, s))
        return false;
    find_backdrop(r, s);
    choose_place(r, s);
    bind_maps(r->maps[0]);
    view_gl_bind(VIEW_UNIT_OTHER, GL_TEXTURE_2D, r->backdrop);
    if (!make_variants(r) || !linear_pass(r) || !truth_pass(r))
        return false;
    r->places++;
    r->settings = *s;
    display_pass(r, 0);
    return view_gl_check("drawing");
}

bool view_renderer_complete(const view_renderer *r)
{
    return !r->rough && r->places >= view_places(&r->settings);
}

/* ---- reading back ------------------------------------------------------- */

/* Reads RGB or alpha of a picture. */
static bool read_floats(const view_renderer *r, GLuint picture, GLenum format,
                        float *to)
{
    const size_t row = (size_t)r->width * (format == GL_RGB ? 3 : 1);

    view_gl_bind(VIEW_UNIT_PICTURE, GL_TEXTURE_2D, picture);
    gl.GetTexImage(GL_TEXTURE_2D, 0, format, GL_FLOAT, to);
    view_picture_flip(to, row * sizeof *to, r->height);
    return view_gl_check("reading the picture");
}

bool view_renderer_read(const view_renderer *r, bool other, float *rgb)
{
    if (!r->picture[0].width || (other && !view_compares(&r->settings)))
        return view_fail("there is no picture to read");
    return read_floats(r, picture_of(r, other), GL_RGB, rgb);
}

/* Displays the last picture in a buffer of its own: colours and framebuffer. */
static bool draw_again(const view_renderer *r, GLenum format, GLuint made[2])
{
    gl.GenRenderbuffers(1, &made[0]);
    gl.BindRenderbuffer(GL_RENDERBUFFER, made[0]);
    gl.RenderbufferStorage(GL_RENDERBUFFER, format, r->width, r->height);
    gl.GenFramebuffers(1, &made[1]);
    gl.BindFramebuffer(GL_FRAMEBUFFER, made[1]);
    gl.FramebufferRenderbuffer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0,
                               GL_RENDERBUFFER, made[0]);
    display_pass(r, made[1]);
    return view_gl_check("drawing a picture");
}

static void free_drawn(const GLuint made[2])
{
    gl.DeleteFramebuffers(1, &made[1]);
    gl.DeleteRenderbuffers(1, &made[0]);
}

unsigned char *view_renderer_picture(const view_renderer *r)
{
    unsigned char *rgb = NULL;
    GLuint made[2];

    if (draw_again(r, GL_RGBA8, made))
        rgb = view_picture_read(made[1], r->width, r->height);
    free_drawn(made);
    return rgb;
}

bool view_renderer_linear(const view_renderer *r, float *rgb)
{
    view_frame raw = r->frame;
    GLuint made[2];

    raw.show[0] = -1;
    upload_frame(r, &raw);
    const bool ok = draw_again(r, GL_RGBA32F, made);
    if (ok)
        gl.ReadPixels(0, 0, r->width, r->height, GL_RGB, GL_FLOAT, rgb);
    free_drawn(made);
    upload_frame(r, &r->frame);
    view_picture_flip(rgb, 3 * (size_t)r->width * sizeof *rgb, r->height);
    return ok && view_gl_check("reading a picture");
}

view_scene *view_renderer_stage(const view_renderer *r)
{
    return r->stage;
}

int view_renderer_samples(const view_renderer *r)
{
    return r->has_truth ? view_truth_samples(r->truth) : 0;
}

const char *view_renderer_environment(const view_renderer *r)
{
    return r->has_truth ? view_truth_environment(r->truth) : NULL;
}

void view_renderer_restart(view_renderer *r)
{
    r->stale = true;
    if (r->truth)
        view_truth_restart(r->truth);
}

void view_renderer_pace(view_renderer *r, int samples)
{
    r->samples = samples;
}

/* Reads what the pixels show of a model: the number of a material; -1: none, or
 * what is seen through. */
static bool read_materials(view_renderer *r, int *shown)
{
    const size_t count = (size_t)r->width * (size_t)r->height;
    const int side = r->settings.reflection == VIEW_REFERENCE;
    float *alpha = ibl_need(malloc(count * sizeof *alpha));
    const bool ok = read_floats(r, r->picture[side].texture, GL_ALPHA, alpha);
    for (size_t i = 0; i < count; i++)
        shown[i] = alpha[i] >= 2 ? (int)alpha[i] - 2 : -1;
    free(alpha);
    return ok;
}

/* What each pixel shows: a sphere of the grid or a material of the model. */
static bool find_shown(view_renderer *r, int *shown)
{
    if (r->settings.mode == VIEW_MODEL)
        return read_materials(r, shown);
    view_errors_spheres(&r->settings, r->width, r->height, shown);
    return true;
}

int view_renderer_parts(const view_renderer *r)
{
    const view_settings *s = &r->settings;

    return s->mode == VIEW_MODEL ? view_model_materials(model(r))
                                 : s->rows * s->columns;
}

const char *view_renderer_part(const view_renderer *r, int i)
{
    return view_model_material(model(r), i);
}

int view_renderer_errors(view_renderer *r, view_error *errors)
{
    const size_t pixels = (size_t)r->width * (size_t)r->height;

    if (!r->picture[0].width || !view_compares(&r->settings))
        return 0;
    float *pictures = ibl_need(malloc(6 * pixels * sizeof *pictures));
    int *shown = ibl_need(malloc(pixels * sizeof *shown));
    const bool ok = view_renderer_read(r, false, pictures) &&
                    view_renderer_read(r, true, pictures + 3 * pixels) &&
                    find_shown(r, shown);
    if (ok)
        view_errors(shown, view_renderer_parts(r), r->width, r->height,
                    pictures, pictures + 3 * pixels, errors);
    free(shown);
    free(pictures);
    return ok ? view_renderer_parts(r) : 0;
}
