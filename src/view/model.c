/* SPDX-License-Identifier: MIT */
#include "view/model.h"

#include <math.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/signals.h"
#include "view/gl.h"
#include "view/message.h"
#include "view/vector.h"

/* ---- tables -------------------------------------------------------------- */

/* Textures of a material, in the order of their units and of surface.frag. */
static const struct {
    size_t at;   /* in ibl_scene_material */
    bool colour; /* sRGB */
} slots[] = {
#define SLOT(field, colour)                                                    \
    {                                                                          \
        offsetof(ibl_scene_material, field##_texture), colour                  \
    }
    SLOT(base_colour, true),
    SLOT(metallic_roughness, false),
    SLOT(normal, false),
    SLOT(occlusion, false),
    SLOT(emissive, true),
    SLOT(specular, false),
    SLOT(specular_colour, true),
    SLOT(clearcoat, false),
    SLOT(clearcoat_roughness, false),
    SLOT(clearcoat_normal, false),
#undef SLOT
};

enum {
    SLOTS = sizeof slots / sizeof *slots,
    COAT_SLOT = 7, /* the first of three */
    /* What a program does, above the bits of the textures that it has. */
    HAS_MASK = 1 << SLOTS,
    HAS_BLEND = 2 << SLOTS,
    HAS_UNLIT = 4 << SLOTS,
    HAS_TANGENTS = 8 << SLOTS,
    HAS_COAT = 16 << SLOTS,
    HAS_GLOSS = 32 << SLOTS,
    DEPTH_ONLY = 64 << SLOTS
};

/* What these bits define, from HAS_MASK on. */
static const char *const features[] = {"MASK", "BLEND", "UNLIT", "TANGENTS",
                                       "COAT", "GLOSS", "DEPTH"};

/* Attributes of model.vert. */
enum {
    POSITION,
    NORMAL,
    TANGENT,
    TEXCOORD,
    COLOUR = TEXCOORD + IBL_SCENE_TEXCOORDS,
    TO_WORLD
};

/* Uniform block "Material" of surface.frag, std140. */
typedef struct model_block {
    float base_colour[4];
    float emissive[4];
    float surface[4];
    float specular[4];
    float coat[4];
    float rows[SLOTS][2][4];
} model_block;

typedef struct model_material {
    char *name;
    int key; /* what its programs do */
    bool blended, double_sided;
    model_block block;
    GLuint texture[SLOTS], sampler[SLOTS]; /* 0: none */
} model_material;

typedef struct model_part {
    GLuint array, vertices, indices;
    GLsizei count;
    int material, key;
    float middle[3];
} model_part;

typedef struct model_draw {
    const model_part *part;
    double in_file[16];
    float to_world[16], middle[3], distance2; /* of the middle from the eye */
    bool mirrored;
} model_draw;

struct view_model {
    model_part *parts;
    model_material *materials;
    model_draw *draws;
    model_draw **order; /* from back to front */
    view_pose *cameras;
    /* Textures of images, [0] as numbers and [1] as colours. */
    GLuint *images[2];
    int part_count, material_count, draw_count, image_count, camera_count;
    /* Of the file: the middle of its box, its height below that, the distance
     * of its farthest vertex. */
    double middle[3], below, radius;
};

/* ---- materials ----------------------------------------------------------- */

static const ibl_scene_texture *texture_at(const ibl_scene_material *s, int i)
{
    return (const void *)((const char *)s + slots[i].at);
}

static bool wants_slot(const ibl_scene_material *s, int i)
{
    return texture_at(s, i)->image >= 0 && (i == 0 || !s->unlit) &&
           (i < COAT_SLOT || s->clearcoat > 0);
}

/* The texture of an image, made on first use; 0, with a message. */
static GLuint texture_of(view_model *m, const ibl_scene *scene, int i,
                         bool colour)
{
    const ibl_scene_image *image = &scene->images[i];
    GLuint *texture = &m->images[colour][i];

    if (*texture)
        return *texture;
    if (!view_gl_takes(GL_MAX_TEXTURE_SIZE, image->width, image->height,
                       image->name))
        return 0;
    gl.GenTextures(1, texture);
    gl.BindTexture(GL_TEXTURE_2D, *texture);
    gl.TexImage2D(GL_TEXTURE_2D, 0, colour ? GL_SRGB8_ALPHA8 : GL_RGBA8,
                  image->width, image->height, 0, GL_RGBA, GL_UNSIGNED_BYTE,
                  image->rgba);
    gl.GenerateMipmap(GL_TEXTURE_2D);
    return *texture;
}

static model_block block_of(const ibl_scene_material *s, int index)
{
    const float r = (s->ior - 1) / (s->ior + 1);
    /* 0 stands for a surface without a Fresnel effect. */
    const float f0 = s->ior == 0 ? 1 : r * r;
    model_block b = {.emissive = {s->emissive[0], s->emissive[1],
                                  s->emissive[2], (float)(1 + index)},
                     .surface = {s->metallic, s->roughness, s->normal_scale,
                                 s->occlusion_strength},
                     .specular = {f0 * s->specular_colour[0],
                                  f0 * s->specular_colour[1],
                                  f0 * s->specular_colour[2], s->specular},
                     .coat = {s->clearcoat, s->clearcoat_roughness,
                              s->clearcoat_normal_scale, s->alpha_cutoff}};

    memcpy(b.base_colour, s->base_colour, sizeof b.base_colour);
    for (int i = 0; i < SLOTS; i++) {
        /* offset + R(rotation) (scale t), R turning from +v to +u */
        const ibl_scene_texture *t = texture_at(s, i);
        const double c = cos(t->rotation), sine = sin(t->rotation);
        const double turn[2][2] = {{c, sine}, {-sine, c}};
        for (int row = 0; row < 2; row++) {
            float *to = b.rows[i][row];
            to[0] = (float)(turn[row][0] * t->scale[0]);
            to[1] = (float)(turn[row][1] * t->scale[1]);
            to[2] = (float)t->offset[row];
            to[3] = (float)t->texcoord;
        }
    }
    return b;
}

static bool make_material(view_model *m, const ibl_scene *scene, int i)
{
    const ibl_scene_material *s = &scene->materials[i];
    model_material *to = &m->materials[i];

    to->blended = s->alpha_mode == IBL_SCENE_BLEND;
    to->double_sided = s->double_sided;
    to->key = (s->alpha_mode == IBL_SCENE_MASK ? HAS_MASK : 0) |
              (to->blended ? HAS_BLEND : 0) | (s->unlit ? HAS_UNLIT : 0) |
              (s->clearcoat > 0 && !s->unlit ? HAS_COAT : 0) |
              (s->glossy && !s->unlit ? HAS_GLOSS : 0);
    to->block = block_of(s, i);
    for (int slot = 0; slot < SLOTS; slot++) {
        const ibl_scene_texture *t = texture_at(s, slot);
        if (!wants_slot(s, slot))
            continue;
        to->key |= 1 << slot;
        gl.GenSamplers(1, &to->sampler[slot]);
        const GLuint sampler = to->sampler[slot];
        const GLint min =
            t->filter_min ? t->filter_min : GL_LINEAR_MIPMAP_LINEAR;
        const GLint mag = t->filter_mag ? t->filter_mag : GL_LINEAR;
        gl.SamplerParameteri(sampler, GL_TEXTURE_WRAP_S, t->wrap_s);
        gl.SamplerParameteri(sampler, GL_TEXTURE_WRAP_T, t->wrap_t);
        gl.SamplerParameteri(sampler, GL_TEXTURE_MIN_FILTER, min);
        gl.SamplerParameteri(sampler, GL_TEXTURE_MAG_FILTER, mag);
        to->texture[slot] = texture_of(m, scene, t->image, slots[slot].colour);
        if (!to->texture[slot])
            return false;
    }
    return true;
}

/* ---- parts --------------------------------------------------------------- */

static void add_attribute(GLuint at, int size, const float *from,
                          uint32_t count, size_t *offset)
{
    const size_t bytes = (size_t)size * count * sizeof *from;

    if (!from)
        return;
    gl.BufferSubData(GL_ARRAY_BUFFER, (GLintptr)*offset, (GLsizeiptr)bytes,
                     from);
    view_gl_attribute(at, size, (size_t)size * sizeof *from, *offset);
    *offset += bytes;
}

static void make_part(const ibl_scene_primitive *p, model_part *to)
{
    const uint32_t n = p->vertex_count;
    size_t offset = 0;

    gl.GenVertexArrays(1, &to->array);
    gl.BindVertexArray(to->array);
    to->vertices =
        view_gl_buffer(GL_ARRAY_BUFFER, (size_t)n * 22 * sizeof(float), NULL);
    add_attribute(POSITION, 3, p->position, n, &offset);
    add_attribute(NORMAL, 3, p->normal, n, &offset);
    add_attribute(TANGENT, 4, p->tangent, n, &offset);
    for (GLuint i = 0; i < IBL_SCENE_TEXCOORDS; i++)
        add_attribute(TEXCOORD + i, 2, p->texcoord[i], n, &offset);
    add_attribute(COLOUR, 4, p->colour, n, &offset);
    to->indices = view_gl_buffer(GL_ELEMENT_ARRAY_BUFFER,
                                 p->index_count * sizeof *p->index, p->index);
    gl.BindVertexArray(0);
    to->count = (GLsizei)p->index_count;
    to->material = p->material;
    to->key = p->tangent ? HAS_TANGENTS : 0;
    for (int k = 0; k < 3; k++) {
        float low = INFINITY, high = -INFINITY;
        for (uint32_t i = 0; i < n; i++) {
            low = fminf(low, p->position[3 * i + k]);
            high = fmaxf(high, p->position[3 * i + k]);
        }
        to->middle[k] = 0.5F * (low + high);
    }
}

/* ---- the model ----------------------------------------------------------- */

static void transform(const double m[16], const float p[3], double to[3])
{
    for (int k = 0; k < 3; k++)
        to[k] = m[k] * p[0] + m[4 + k] * p[1] + m[8 + k] * p[2] + m[12 + k];
}

/* The largest distance of a vertex from the middle; 1 if all are there. */
static double radius_of(const ibl_scene *scene, const double middle[3])
{
    double most = 0, p[3];

    for (int i = 0; i < scene->draw_count; i++) {
        const ibl_scene_draw *d = &scene->draws[i];
        const ibl_scene_primitive *from = &scene->primitives[d->primitive];
        for (uint32_t v = 0; v < from->vertex_count; v++) {
            transform(d->to_world, from->position + 3 * (size_t)v, p);
            for (int k = 0; k < 3; k++)
                p[k] -= middle[k];
            most = fmax(most, dot3(p, p));
        }
    }
    return most > 0 ? sqrt(most) : 1;
}

/* A point p of the file is drawn at scale (p - middle) + at. */
static void place_draw(model_draw *d, const double middle[3],
                       const double at[3], double scale)
{
    double across[3], p[3];

    for (int k = 0; k < 16; k++) {
        const double x = d->in_file[k];
        d->to_world[k] =
            (float)(k % 4 == 3 ? x
                    : k < 12   ? scale * x
                               : scale * (x - middle[k % 4]) + at[k % 4]);
    }
    cross3(d->in_file, d->in_file + 4, across);
    d->mirrored = dot3(across, d->in_file + 8) < 0;
    transform(d->in_file, d->part->middle, p);
    for (int k = 0; k < 3; k++)
        d->middle[k] = (float)(scale * (p[k] - middle[k]) + at[k]);
}

void view_model_place(view_model *m, const double at[3], double radius)
{
    for (int i = 0; i < m->draw_count; i++)
        place_draw(&m->draws[i], m->middle, at ? at : m->middle,
                   at ? radius / m->radius : 1);
}

void view_model_move(view_model *m, int draw, const double at[3], double scale)
{
    place_draw(&m->draws[draw], (const double[3]){0}, at, scale);
}

static void make_draws(view_model *m, const ibl_scene *scene)
{
    for (int k = 0; k < 3; k++)
        m->middle[k] = 0.5 * (scene->bounds[0][k] + scene->bounds[1][k]);
    m->below = m->middle[1] - scene->bounds[0][1];
    m->radius = radius_of(scene, m->middle);
    for (int i = 0; i < scene->camera_count; i++) {
        const ibl_scene_camera *from = &scene->cameras[i];
        view_pose *to = &m->cameras[i];
        to->yfov = from->yfov;
        to->aspect = from->aspect;
        for (int k = 0; k < 3; k++) {
            memcpy(to->axes[k], from->to_world + 4 * k, sizeof to->axes[k]);
            normalise3(to->axes[k]);
            to->eye[k] = (from->to_world[12 + k] - m->middle[k]) / m->radius;
        }
    }
    m->draw_count = scene->draw_count;
    for (int i = 0; i < m->draw_count; i++) {
        m->order[i] = &m->draws[i];
        m->draws[i].part = &m->parts[scene->draws[i].primitive];
        memcpy(m->draws[i].in_file, scene->draws[i].to_world,
               sizeof m->draws[i].in_file);
    }
}

/* Decodes the images of the materials that are drawn. */
static bool decode_images(ibl_ctx *ctx, view_model *m, ibl_scene *scene)
{
    int *images =
        ibl_need(calloc((size_t)scene->image_count + 1, sizeof *images));
    int count = 0;

    for (int i = 0; i < SLOTS * m->draw_count; i++) {
        const ibl_scene_material *s =
            &scene->materials[m->draws[i / SLOTS].part->material];
        if (wants_slot(s, i % SLOTS))
            images[texture_at(s, i % SLOTS)->image] = true;
    }
    for (int i = 0; i < scene->image_count; i++)
        if (images[i] && !scene->images[i].rgba)
            images[count++] = i;
    const bool ok =
        !count || !ibl_scene_decode_all(ctx, scene, images, count, 1);
    free(images);
    return ok;
}

static bool make_materials(view_model *m, const ibl_scene *scene)
{
    bool beyond = false;

    m->material_count = scene->material_count;
    m->image_count = scene->image_count;
    gl.ActiveTexture(GL_TEXTURE0 + VIEW_MODEL_UNITS);
    for (int i = 0; i < m->material_count; i++)
        m->materials[i].name = ibl_need(strdup(scene->materials[i].name));
    /* Only those that are drawn. */
    for (int i = 0; i < m->draw_count; i++) {
        const int material = m->draws[i].part->material;
        const ibl_scene_material *s = &scene->materials[material];
        if (m->materials[material].block.emissive[3] == 0 &&
            !make_material(m, scene, material))
            return false;
        beyond = beyond || s->transmission > 0 || s->anisotropy > 0 ||
                 s->sheen_colour[0] > 0 || s->sheen_colour[1] > 0 ||
                 s->sheen_colour[2] > 0;
    }
    if (beyond)
        view_note("KHR_materials_transmission, _anisotropy and _sheen are not "
                  "drawn: surfaces are opaque, reflections round");
    return true;
}

static void *zeroed(int count, size_t size)
{
    return ibl_need(calloc((size_t)count + 1, size));
}

view_model *view_model_create(ibl_ctx *ctx, ibl_scene *scene, const char *name)
{
    if (!scene->draw_count) {
        view_fail("%s: there are no triangles to draw", name);
        return NULL;
    }
    view_model *m = zeroed(1, sizeof *m);
    m->parts = zeroed(scene->primitive_count, sizeof *m->parts);
    m->materials = zeroed(scene->material_count, sizeof *m->materials);
    m->draws = zeroed(scene->draw_count, sizeof *m->draws);
    m->order = zeroed(scene->draw_count, sizeof *m->order);
    for (int i = 0; i < 2; i++)
        m->images[i] = zeroed(scene->image_count, sizeof *m->images[i]);
    m->cameras = zeroed(scene->camera_count, sizeof *m->cameras);
    m->camera_count = scene->camera_count;
    m->part_count = scene->primitive_count;
    for (int i = 0; i < m->part_count; i++)
        make_part(&scene->primitives[i], &m->parts[i]);
    make_draws(m, scene);
    if (decode_images(ctx, m, scene) && make_materials(m, scene) &&
        view_gl_check(name))
        return m;
    view_model_free(m);
    return NULL;
}

void view_model_free(view_model *m)
{
    if (!m)
        return;
    for (int i = 0; i < m->part_count; i++) {
        gl.DeleteVertexArrays(1, &m->parts[i].array);
        gl.DeleteBuffers(1, &m->parts[i].vertices);
        gl.DeleteBuffers(1, &m->parts[i].indices);
    }
    for (int i = 0; i < m->material_count; i++) {
        gl.DeleteSamplers(SLOTS, m->materials[i].sampler);
        free(m->materials[i].name);
    }
    for (int i = 0; i < 2; i++) {
        gl.DeleteTextures(m->image_count, m->images[i]);
        free(m->images[i]);
    }
    free(m->parts);
    free(m->materials);
    free(m->draws);
    free(m->order);
    free(m->cameras);
    free(m);
}

const char *view_model_material(const view_model *m, int i)
{
    return i < m->material_count ? m->materials[i].name : NULL;
}

/* ---- drawing ------------------------------------------------------------- */

static GLuint program_of(int key, const view_lighting *light)
{
    char text[512] = "";

    view_add(text, sizeof text, "#define MODEL\n#define HAS %d\n",
             key & (HAS_MASK - 1));
    for (size_t i = 0; i < sizeof features / sizeof *features; i++)
        if (key & HAS_MASK << i)
            view_add(text, sizeof text, "#define %s\n", features[i]);
    view_lighting_define(light, text, sizeof text);
    return view_program(text, "model.vert", "surface.frag");
}

/* Draws what is blended, or the rest, with the programs of their materials, or
 * only its depth. */
static bool draw_all(view_model *m, bool blended, bool depth,
                     const view_lighting *light)
{
    const view_lighting none = {.probes = light->probes};
    int used = -1;

    for (int i = 0; i < m->draw_count; i++) {
        const model_draw *d = m->order[i];
        const model_part *part = d->part;
        const model_material *material = &m->materials[part->material];
        int key = material->key | part->key;
        if (material->blended != blended)
            continue;
        if (depth)
            key = DEPTH_ONLY | (key & HAS_MASK ? key & (HAS_MASK | 1) : 0);
        else if (light->override)
            key &= ~(HAS_UNLIT | HAS_COAT);
        if (key != used) {
            const GLuint program = program_of(key, depth ? &none : light);
            if (!program)
                return false;
            gl.UseProgram(program);
            used = key;
        }
        view_gl_block(VIEW_BLOCK_MATERIAL, &material->block,
                      sizeof material->block);
        for (int slot = 0; slot < SLOTS; slot++)
            if (material->texture[slot]) {
                view_gl_bind(VIEW_MODEL_UNITS + slot, GL_TEXTURE_2D,
                             material->texture[slot]);
                gl.BindSampler((GLuint)(VIEW_MODEL_UNITS + slot),
                               material->sampler[slot]);
            }
        gl.BindVertexArray(part->array);
        for (int k = 0; k < 4; k++)
            gl.VertexAttrib4f((GLuint)(TO_WORLD + k), d->to_world[4 * k],
                              d->to_world[4 * k + 1], d->to_world[4 * k + 2],
                              d->to_world[4 * k + 3]);
        gl.FrontFace(d->mirrored != light->mirrored ? GL_CW : GL_CCW);
        if (!material->double_sided)
            gl.Enable(GL_CULL_FACE);
        else if (blended) {
            /* What is seen through the front. */
            gl.Enable(GL_CULL_FACE);
            gl.CullFace(GL_FRONT);
            gl.DrawElements(GL_TRIANGLES, part->count, GL_UNSIGNED_INT, NULL);
            gl.CullFace(GL_BACK);
        }
        gl.DrawElements(GL_TRIANGLES, part->count, GL_UNSIGNED_INT, NULL);
        gl.Disable(GL_CULL_FACE);
    }
    return true;
}

static int compare_order(const void *a, const void *b)
{
    const float x = (*(model_draw *const *)a)->distance2;
    const float y = (*(model_draw *const *)b)->distance2;

    return (x < y) - (x > y);
}

/* Draws the depth of what is opaque, and leaves the test of depth on. */
static bool draw_depth(view_model *m, const view_lighting *light)
{
    gl.Enable(GL_DEPTH_TEST);
    gl.ColorMask(GL_FALSE, GL_FALSE, GL_FALSE, GL_FALSE);
    const bool ok = draw_all(m, false, true, light);
    gl.ColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
    return ok;
}

/* Depth first, so that each pixel is shaded once but for what is blended. */
bool view_model_draw(view_model *m, const view_lighting *light,
                     const float eye[3])
{
    for (int i = 0; i < m->draw_count; i++) {
        model_draw *d = &m->draws[i];
        d->distance2 = 0;
        for (int k = 0; k < 3; k++)
            d->distance2 += powf(d->middle[k] - eye[k], 2);
    }
    qsort(m->order, (size_t)m->draw_count, sizeof *m->order, compare_order);
    gl.DepthFunc(GL_LEQUAL);
    for (GLuint i = TANGENT; i < COLOUR; i++)
        gl.VertexAttrib4f(i, 0, 0, 0, 0);
    gl.VertexAttrib4f(COLOUR, 1, 1, 1, 1);
    gl.Disable(GL_BLEND);
    bool ok = draw_depth(m, light);
    gl.DepthMask(GL_FALSE);
    ok = ok && draw_all(m, false, false, light);
    gl.Enable(GL_BLEND);
    ok = ok &&
         (light->parts == VIEW_PARTS_COUNT || draw_all(m, true, false, light));
    gl.DepthMask(GL_TRUE);
    gl.Disable(GL_BLEND);
    gl.Disable(GL_DEPTH_TEST);
    gl.DepthFunc(GL_LESS);
    gl.FrontFace(GL_CCW);
    for (int i = 0; i < SLOTS; i++)
        gl.BindSampler((GLuint)(VIEW_MODEL_UNITS + i), 0);
    return ok && view_gl_check("drawing the model");
}

const view_pose *view_model_camera(const view_model *m, int i)
{
    return i >= 0 && i < m->camera_count ? &m->cameras[i] : NULL;
}

double view_model_floor(const view_model *m)
{
    return -m->below / m->radius;
}

bool view_model_depth(view_model *m)
{
    static const view_lighting none;

    const bool ok = draw_depth(m, &none);
    gl.Disable(GL_DEPTH_TEST);
    gl.FrontFace(GL_CCW);
    return ok && view_gl_check("drawing the shadows");
}

/* ---- models or spheres --------------------------------------------------- */

bool view_subject_draw(const view_subject *s, view_image *picture)
{
    const view_frame *f = s->frame;
    char text[256];

    view_gl_block(VIEW_BLOCK_FRAME, f, sizeof *f);
    view_image_begin(picture);
    gl.Disable(GL_BLEND);
    if (s->light.parts == VIEW_PARTS_COUNT) {
        gl.ClearColor(0, 0, 0, 0);
        gl.Clear(GL_COLOR_BUFFER_BIT);
    } else {
        snprintf(text, sizeof text, "#define BACKDROP %d\n", f->shading[2]);
        if (f->parts[3])
            view_add(text, sizeof text, "#define GROUND %g\n",
                     VIEW_GROUND_HALF);
        const GLuint sky = view_program(text, "full.vert", "sky.frag");
        if (!sky)
            return false;
        view_gl_draw_full(sky);
    }
    if (s->model)
        return view_model_draw(s->model, &s->light, f->eye);
    *text = '\0';
    view_lighting_define(&s->light, text, sizeof text);
    const GLuint spheres = view_program(text, "sphere.vert", "surface.frag");
    gl.Enable(GL_BLEND);
    if (spheres)
        view_gl_draw_quads(spheres, f->grid[0] * f->grid[1]);
    gl.Disable(GL_BLEND);
    return spheres;
}
