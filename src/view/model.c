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
#include "view/sphere_grid.h"
#include "view/vector.h"

/* ---- tables -------------------------------------------------------------- */

/* Textures of a material, as surface.frag names them. */
static const struct {
    const char *name;
    size_t at;   /* in ibl_scene_material */
    bool colour; /* sRGB */
} slots[] = {
#define SLOT(name, field, colour)                                              \
    {                                                                          \
        name, offsetof(ibl_scene_material, field##_texture), colour            \
    }
    SLOT("base", base_colour, true),
    SLOT("rough", metallic_roughness, false),
    SLOT("normal", normal, false),
    SLOT("occlusion", occlusion, false),
    SLOT("emissive", emissive, true),
    SLOT("weight", specular, false),
    SLOT("f0", specular_colour, true),
    SLOT("coat", clearcoat, false),
    SLOT("coat_rough", clearcoat_roughness, false),
    SLOT("coat_normal", clearcoat_normal, false),
    SLOT("sheen", sheen_colour, true),
    SLOT("sheen_rough", sheen_roughness, false),
#undef SLOT
};

enum {
    SLOTS = sizeof slots / sizeof *slots,
    COAT_SLOT = 7, /* the first of three */
    SHEEN_SLOT = 10,
    SET_MAPS = 9, /* that a program looks up besides, at most */
    /* Bits of a program's key above those of the textures it has, and, from
     * FEATURE_BITS, its view_lighting_key. */
    HAS_MASK = 1 << SLOTS,
    HAS_BLEND = 2 << SLOTS,
    HAS_UNLIT = 4 << SLOTS,
    HAS_TANGENTS = 8 << SLOTS,
    HAS_COAT = 16 << SLOTS,
    HAS_SHEEN = 32 << SLOTS,
    DEPTH_ONLY = 64 << SLOTS,
    HAS_GLOSS = 128 << SLOTS,
    BY_PROBES = 256 << SLOTS,
    FEATURE_BITS = SLOTS + 9
};

/* What these bits define, from HAS_MASK on. */
static const char *const features[] = {"MASK",     "BLEND", "UNLIT",
                                       "TANGENTS", "COAT",  "SHEEN",
                                       "DEPTH",    "GLOSS", "PROBES"};

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
    float sheen[4];
    float rows[SLOTS][2][4];
} model_block;

typedef struct model_material {
    char *name;
    int key; /* what it adds to the key of programs */
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

typedef struct model_program {
    int key;
    GLuint program;
} model_program;

struct view_model {
    model_part *parts;
    model_material *materials;
    model_draw *draws;
    model_draw **order; /* from back to front */
    model_program *programs;
    view_pose *cameras;
    /* Textures of images, [0] as numbers and [1] as colours. */
    GLuint *images[2];
    int part_count, material_count, draw_count, program_count, image_count,
        camera_count;
    GLuint blocks; /* buffer of all blocks, block_step bytes apart */
    GLint block_step;
    /* Of the file: the middle of its box, its height below that, the distance
     * of its farthest vertex. */
    double middle[3], below, radius;
};

/* ---- programs ------------------------------------------------------------ */

static GLuint make_program(int key)
{
    char text[4096] = "";

    view_add(text, sizeof text, "#define MODEL\n#define TEXTURES %d\n", SLOTS);
    view_lighting_define(key >> FEATURE_BITS, text, sizeof text);
    for (int i = 0; i < FEATURE_BITS - SLOTS; i++)
        if (key & HAS_MASK << i)
            view_add(text, sizeof text, "#define %s\n", features[i]);
    for (int i = 0; i < SLOTS; i++) {
        const char *n = slots[i].name;
        if (key & 1 << i)
            view_add(text, sizeof text,
                     "#define has_%s\n#define place_%s placed(%d)\n"
                     "#define look_%s texture(%s_map, placed(%d))\n",
                     n, n, i, n, n, i);
        else
            view_add(text, sizeof text, "#define look_%s vec4(1.0)\n", n);
    }
    return view_program_from(view_shader_files, text, "model.vert",
                             "surface.frag");
}

/* The program of a key, made on first use; 0, with a message. */
static GLuint program_of(view_model *m, int key)
{
    char name[32];

    for (int i = 0; i < m->program_count; i++)
        if (m->programs[i].key == key)
            return m->programs[i].program;
    m->programs = ibl_need(realloc(m->programs, (size_t)(m->program_count + 1) *
                                                    sizeof *m->programs));
    const GLuint program = make_program(key);
    if (!program)
        return 0;
    gl.UseProgram(program);
    for (int i = 0; i < SLOTS; i++) {
        snprintf(name, sizeof name, "%s_map", slots[i].name);
        gl.Uniform1i(gl.GetUniformLocation(program, name),
                     VIEW_MODEL_UNITS + i);
    }
    m->programs[m->program_count++] = (model_program){key, program};
    return program;
}

/* ---- materials ----------------------------------------------------------- */

static const ibl_scene_texture *texture_at(const ibl_scene_material *s, int i)
{
    return (const void *)((const char *)s + slots[i].at);
}

static bool has_sheen(const ibl_scene_material *s)
{
    return s->sheen_colour[0] > 0 || s->sheen_colour[1] > 0 ||
           s->sheen_colour[2] > 0;
}

static bool wants_slot(const ibl_scene_material *s, int i)
{
    return texture_at(s, i)->image >= 0 && (i == 0 || !s->unlit) &&
           (i < COAT_SLOT ||
            (i < SHEEN_SLOT ? s->clearcoat > 0 : has_sheen(s)));
}

/* The texture of an image, made on first use; 0, with a message. */
static GLuint texture_of(view_model *m, const ibl_scene *scene, int i,
                         bool colour)
{
    const ibl_scene_image *image = &scene->images[i];
    GLuint *texture = &m->images[colour][i];
    GLint most = 0;

    if (*texture)
        return *texture;
    gl.GetIntegerv(GL_MAX_TEXTURE_SIZE, &most);
    if (image->width > most || image->height > most)
        return view_fail("%s: %d x %d pixels, and this OpenGL takes %d x %d at "
                         "most: make it smaller",
                         image->name, image->width, image->height, (int)most,
                         (int)most);
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
                              s->clearcoat_normal_scale, s->alpha_cutoff},
                     .sheen = {s->sheen_colour[0], s->sheen_colour[1],
                               s->sheen_colour[2], s->sheen_roughness}};

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
    GLint left;

    to->blended = s->alpha_mode == IBL_SCENE_BLEND;
    to->double_sided = s->double_sided;
    to->key = (s->alpha_mode == IBL_SCENE_MASK ? HAS_MASK : 0) |
              (to->blended ? HAS_BLEND : 0) | (s->unlit ? HAS_UNLIT : 0) |
              (s->clearcoat > 0 && !s->unlit ? HAS_COAT : 0) |
              (has_sheen(s) && !s->unlit ? HAS_SHEEN : 0) |
              (s->glossy && !s->unlit ? HAS_GLOSS : 0);
    to->block = block_of(s, i);
    gl.BindBuffer(GL_UNIFORM_BUFFER, m->blocks);
    gl.BufferSubData(GL_UNIFORM_BUFFER, (GLintptr)i * m->block_step,
                     sizeof to->block, &to->block);
    gl.GetIntegerv(GL_MAX_TEXTURE_IMAGE_UNITS, &left);
    left -= SET_MAPS;
    for (int slot = 0; slot < SLOTS; slot++) {
        const ibl_scene_texture *t = texture_at(s, slot);
        if (!wants_slot(s, slot))
            continue;
        if (left-- <= 0) {
            view_note("material %s: its texture \"%s\" is left out: this "
                      "OpenGL has too few texture units",
                      s->name, slots[slot].name);
            continue;
        }
        to->key |= 1 << slot;
        gl.GenSamplers(1, &to->sampler[slot]);
        const GLint filters[4][2] = {
            {GL_TEXTURE_WRAP_S, t->wrap_s},
            {GL_TEXTURE_WRAP_T, t->wrap_t},
            {GL_TEXTURE_MIN_FILTER,
             t->filter_min ? t->filter_min : GL_LINEAR_MIPMAP_LINEAR},
            {GL_TEXTURE_MAG_FILTER, t->filter_mag ? t->filter_mag : GL_LINEAR}};
        for (int k = 0; k < 4; k++)
            gl.SamplerParameteri(to->sampler[slot], (GLenum)filters[k][0],
                                 filters[k][1]);
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
    view_gl_attribute(at, size, (size_t)size * sizeof *from, *offset, 0);
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

void view_model_stand(view_model *m, const double floor[3], double radius)
{
    const double at[3] = {floor[0], floor[1] + m->below * radius / m->radius,
                          floor[2]};

    view_model_place(m, at, radius);
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
    view_model_place(m, (const double[3]){0}, 1);
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
    gl.GetIntegerv(GL_UNIFORM_BUFFER_OFFSET_ALIGNMENT, &m->block_step);
    m->block_step = ((int)sizeof(model_block) + m->block_step - 1) /
                    m->block_step * m->block_step;
    m->blocks =
        view_gl_buffer(GL_UNIFORM_BUFFER,
                       (size_t)m->material_count * (size_t)m->block_step, NULL);
    gl.ActiveTexture(GL_TEXTURE0 + VIEW_MODEL_UNITS);
    for (int i = 0; i < m->material_count; i++)
        m->materials[i].name = ibl_need(strdup(scene->materials[i].name));
    /* Only those that are drawn. */
    for (int i = 0; i < m->draw_count; i++) {
        const int material = m->draws[i].part->material;
        if (m->materials[material].block.emissive[3] == 0 &&
            !make_material(m, scene, material))
            return false;
        beyond = beyond || scene->materials[material].transmission > 0 ||
                 scene->materials[material].anisotropy > 0;
    }
    if (beyond)
        view_note("KHR_materials_transmission and _anisotropy are not drawn: "
                  "surfaces are opaque, reflections round");
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
    for (int i = 0; i < m->program_count; i++)
        gl.DeleteProgram(m->programs[i].program);
    for (int i = 0; i < 2; i++) {
        gl.DeleteTextures(m->image_count, m->images[i]);
        free(m->images[i]);
    }
    gl.DeleteBuffers(1, &m->blocks);
    free(m->parts);
    free(m->materials);
    free(m->draws);
    free(m->order);
    free(m->programs);
    free(m->cameras);
    free(m);
}

int view_model_materials(const view_model *m)
{
    return m->material_count;
}

const char *view_model_material(const view_model *m, int i)
{
    return m->materials[i].name;
}

/* ---- drawing ------------------------------------------------------------- */

/* Draws what is blended, or the rest, with the programs of their materials, as
 * far as the pass needs these. */
static bool draw_all(view_model *m, bool blended, bool depth,
                     const view_lighting *light)
{
    const int off = light->override ? HAS_UNLIT | HAS_COAT | HAS_SHEEN
                    : light->sheen  ? 0
                                    : HAS_SHEEN;
    GLuint used = 0;

    for (int i = 0; i < m->draw_count; i++) {
        const model_draw *d = m->order[i];
        const model_part *part = d->part;
        const model_material *material = &m->materials[part->material];
        const int all = material->key | part->key;
        const int key =
            (light->probes ? BY_PROBES : 0) |
            (depth ? DEPTH_ONLY | (all & HAS_MASK ? all & (HAS_MASK | 1) : 0)
                   : (all & ~off) | view_lighting_key(light) << FEATURE_BITS);
        if (material->blended != blended)
            continue;
        const GLuint program = program_of(m, key);
        if (!program)
            return false;
        if (program != used)
            gl.UseProgram(program);
        used = program;
        gl.BindBufferRange(GL_UNIFORM_BUFFER, VIEW_BLOCK_MATERIAL, m->blocks,
                           (GLintptr)part->material * m->block_step,
                           sizeof(model_block));
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
    gl.Enable(GL_DEPTH_TEST);
    gl.DepthFunc(GL_LEQUAL);
    for (GLuint i = TANGENT; i < COLOUR; i++)
        gl.VertexAttrib4f(i, 0, 0, 0, 0);
    gl.VertexAttrib4f(COLOUR, 1, 1, 1, 1);
    gl.ColorMask(GL_FALSE, GL_FALSE, GL_FALSE, GL_FALSE);
    bool ok = draw_all(m, false, true, light);
    gl.ColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
    gl.DepthMask(GL_FALSE);
    gl.Disable(GL_BLEND);
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

    gl.Enable(GL_DEPTH_TEST);
    gl.Clear(GL_DEPTH_BUFFER_BIT);
    const bool ok = draw_all(m, false, true, &none);
    gl.Disable(GL_DEPTH_TEST);
    gl.FrontFace(GL_CCW);
    return ok && view_gl_check("drawing the shadows");
}

/* ---- models or spheres --------------------------------------------------- */

bool view_subject_draw(const view_subject *s, const view_lighting *light,
                       view_image *picture)
{
    const int key = view_lighting_key(light);
    char text[256] = "";

    gl.BindFramebuffer(GL_FRAMEBUFFER, picture->framebuffer);
    if (s->model)
        view_image_begin(picture);
    if (s->sky)
        view_gl_draw_full(s->sky);
    else {
        gl.ClearColor(0, 0, 0, 0);
        gl.Clear(GL_COLOR_BUFFER_BIT);
    }
    if (s->model)
        return view_model_draw(s->model, light, s->eye);
    view_lighting_define(key, text, sizeof text);
    if (!s->programs[key])
        s->programs[key] = view_program_from(view_shader_files, text,
                                             "sphere.vert", "surface.frag");
    if (!s->programs[key])
        return false;
    gl.Enable(GL_BLEND);
    gl.UseProgram(s->programs[key]);
    gl.BindVertexArray(s->instances);
    gl.DrawArraysInstanced(GL_TRIANGLE_STRIP, 0, 4, s->count);
    gl.Disable(GL_BLEND);
    return true;
}

/* ---- the material ball, as if it had been read from a file -----------------
 */

enum {
    ROWS = 48,
    COLUMNS = 2 * ROWS,
    ACROSS = COLUMNS + 1, /* the seam has two columns of vertices */
    VERTICES = (ROWS + 1) * ACROSS,
    WAVES = 20,  /* around the ball */
    HEIGHT = 256 /* of the normal map, which is twice as wide */
};

typedef struct ball {
    float position[VERTICES][3], texcoord[VERTICES][2];
    uint32_t index[ROWS * COLUMNS][6];
    unsigned char texels[HEIGHT][2 * HEIGHT][4];
} ball;

view_model *view_model_ball(void)
{
    static char name[] = "material ball";
    ball *b = ibl_need(malloc(sizeof *b));
    ibl_scene_material material = {
        VIEW_MODEL_PLAIN, .base_colour = {1, 1, 1, 1},
        .metallic = 1,    .roughness = 1,
        .ior = 1.5F,      .specular = 1};
    ibl_scene_primitive primitive = {.vertex_count = VERTICES,
                                     .index_count = 6 * ROWS * COLUMNS,
                                     .position = b->position[0],
                                     .normal = b->position[0],
                                     .texcoord = {b->texcoord[0]},
                                     .index = b->index[0]};
    ibl_scene_draw draw = {.to_world = {[0] = 1, [5] = 1, [10] = 1, [15] = 1}};
    ibl_scene_image image = {.name = name,
                             .width = 2 * HEIGHT,
                             .height = HEIGHT,
                             .rgba = b->texels[0][0]};
    ibl_scene scene = {.primitives = &primitive,
                       .materials = &material,
                       .draws = &draw,
                       .images = &image,
                       .primitive_count = 1,
                       .material_count = 1,
                       .draw_count = 1,
                       .image_count = 1,
                       .bounds = {{-1, -1, -1}, {1, 1, 1}}};

    material.name = name;
    material.normal_texture = (ibl_scene_texture){
        .wrap_s = GL_REPEAT, .wrap_t = GL_CLAMP_TO_EDGE, .scale = {1, 1}};
    /* u goes around from the back, with +Z in its middle; v is down. */
    for (int i = 0; i < VERTICES; i++) {
        const int row = i / ACROSS, column = i % ACROSS;
        const double theta = M_PI * row / ROWS;
        const double phi = 2 * M_PI * column / COLUMNS - M_PI;
        b->position[i][0] = (float)(sin(theta) * sin(phi));
        b->position[i][1] = (float)cos(theta);
        b->position[i][2] = (float)(sin(theta) * cos(phi));
        b->texcoord[i][0] = (float)column / COLUMNS;
        b->texcoord[i][1] = (float)row / ROWS;
    }
    for (int i = 0; i < ROWS * COLUMNS; i++) {
        const uint32_t a = (uint32_t)(i / COLUMNS * ACROSS + i % COLUMNS);
        const uint32_t corners[6] = {a,     a + ACROSS, a + 1,
                                     a + 1, a + ACROSS, a + ACROSS + 1};
        memcpy(b->index[i], corners, sizeof corners);
    }
    /* The normal of the height cos x cos y, in a belt around the equator. */
    for (int i = 0; i < 2 * HEIGHT * HEIGHT; i++) {
        const int row = i / (2 * HEIGHT), column = i % (2 * HEIGHT);
        const double wave = 2 * M_PI * WAVES / (2.0 * HEIGHT);
        const double x = (column + 0.5) * wave, y = (row + 0.5) * wave;
        const double off = fabs(2 * (row + 0.5) / HEIGHT - 1);
        const double edge = fmin(fmax((0.35 - off) / 0.1, 0), 1);
        const double steep = 0.4 * edge * edge * (3 - 2 * edge);
        /* Green is against v. */
        double n[3] = {steep * sin(x) * cos(y), -steep * cos(x) * sin(y), 1};
        normalise3(n);
        for (int k = 0; k < 3; k++)
            b->texels[row][column][k] =
                (unsigned char)lrint(127.5 * (n[k] + 1));
        b->texels[row][column][3] = 255;
    }
    view_model *m = view_model_create(NULL, &scene, name);
    free(b);
    return m;
}
