/* SPDX-License-Identifier: MIT */
#include "view/model.h"

#include <math.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/signals.h"
#include "view/message.h"
#include "view/program.h"
#include "view/sphere_grid.h"

/* ---- tables -------------------------------------------------------------- */

/* Textures of a material, as model.glsl names them. */
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
    SET_MAPS = 6, /* that a program looks up besides, at most */
    /* Bits of a program's key above those of the textures it has, and, from
     * FEATURE_BITS, the reflection that it draws. */
    HAS_MASK = 1 << SLOTS,
    HAS_BLEND = 2 << SLOTS,
    HAS_UNLIT = 4 << SLOTS,
    HAS_TANGENTS = 8 << SLOTS,
    HAS_COAT = 16 << SLOTS,
    HAS_SHEEN = 32 << SLOTS,
    DEPTH_ONLY = 64 << SLOTS,
    HARMONICS = 128 << SLOTS,
    HAS_GLOSS = 256 << SLOTS,
    FEATURE_BITS = SLOTS + 9
};

static const struct {
    int bit;
    const char *name;
} features[] = {{HAS_MASK, "MASK"},   {HAS_BLEND, "BLEND"},
                {HAS_UNLIT, "UNLIT"}, {HAS_TANGENTS, "TANGENTS"},
                {HAS_COAT, "COAT"},   {HAS_SHEEN, "SHEEN"},
                {HAS_GLOSS, "GLOSS"}, {DEPTH_ONLY, "DEPTH"}};

/* Attributes of model.vert. */
enum {
    POSITION,
    NORMAL,
    TANGENT,
    TEXCOORD,
    COLOUR = TEXCOORD + IBL_SCENE_TEXCOORDS,
    TO_WORLD
};

/* Uniform block "Material" of model.glsl, std140. */
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
    float to_world[16], middle[3];
    bool mirrored;
    float distance2; /* of the middle from the eye */
} model_draw;

typedef struct model_program {
    int key;
    GLuint program;
} model_program;

struct view_model {
    model_part *parts;
    model_material *materials;
    model_draw *draws;
    model_program *programs;
    /* Textures of images, [0] as numbers and [1] as colours. */
    GLuint *images[2];
    int part_count, material_count, draw_count, program_count, image_count;
    GLuint blocks; /* buffer of all blocks, block_step bytes apart */
    GLint block_step;
};

/* ---- programs ------------------------------------------------------------ */

static void define_slot(char *text, size_t size, int i, bool has)
{
    const char *n = slots[i].name;

    if (has)
        view_add(text, size,
                 "#define has_%s\n#define place_%s placed(%d)\n"
                 "#define look_%s texture(%s_map, placed(%d))\n",
                 n, n, i, n, n, i);
    else
        view_add(text, size, "#define look_%s vec4(1.0)\n", n);
}

static GLuint make_program(int key)
{
    const int reflection = key >> FEATURE_BITS;
    char text[4096] = "";

    view_add(text, sizeof text,
             "#define TEXTURES %d\n#define REFLECTION %d\n#define DIFFUSE %d\n",
             SLOTS, reflection,
             key & HARMONICS ? VIEW_DIFFUSE_SH : VIEW_DIFFUSE_MAP);
    for (size_t i = 0; i < sizeof features / sizeof *features; i++)
        if (key & features[i].bit)
            view_add(text, sizeof text, "#define %s\n", features[i].name);
    for (int i = 0; i < SLOTS; i++)
        define_slot(text, sizeof text, i, key & 1 << i);
    return view_program_from(view_shader_files, text, "model.vert",
                             reflection == VIEW_REFERENCE ? "model_truth.frag"
                                                          : "model.frag");
}

static void bind_samplers(GLuint program)
{
    char name[32];

    gl.UseProgram(program);
    for (int i = 0; i < SLOTS; i++) {
        snprintf(name, sizeof name, "%s_map", slots[i].name);
        gl.Uniform1i(gl.GetUniformLocation(program, name),
                     VIEW_MODEL_UNITS + i);
    }
}

/* The program of a key, made on first use; 0, with a message. */
static GLuint program_of(view_model *m, int key)
{
    for (int i = 0; i < m->program_count; i++)
        if (m->programs[i].key == key)
            return m->programs[i].program;
    m->programs = ibl_need(realloc(m->programs, (size_t)(m->program_count + 1) *
                                                    sizeof *m->programs));
    const GLuint program = make_program(key);
    if (program) {
        bind_samplers(program);
        m->programs[m->program_count++] = (model_program){key, program};
    }
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

static GLuint make_sampler(const ibl_scene_texture *t)
{
    GLuint s;

    gl.GenSamplers(1, &s);
    gl.SamplerParameteri(s, GL_TEXTURE_WRAP_S, t->wrap_s);
    gl.SamplerParameteri(s, GL_TEXTURE_WRAP_T, t->wrap_t);
    gl.SamplerParameteri(s, GL_TEXTURE_MIN_FILTER,
                         t->filter_min ? t->filter_min
                                       : GL_LINEAR_MIPMAP_LINEAR);
    gl.SamplerParameteri(s, GL_TEXTURE_MAG_FILTER,
                         t->filter_mag ? t->filter_mag : GL_LINEAR);
    return s;
}

static GLuint upload_image(const ibl_scene_image *image, bool colour)
{
    GLuint texture = 0;
    GLint most = 0;

    gl.GetIntegerv(GL_MAX_TEXTURE_SIZE, &most);
    if (image->width > most || image->height > most)
        return view_fail("%s: %d x %d pixels, and this OpenGL takes %d x %d at "
                         "most: make it smaller",
                         image->name, image->width, image->height, (int)most,
                         (int)most);
    gl.GenTextures(1, &texture);
    gl.BindTexture(GL_TEXTURE_2D, texture);
    gl.TexImage2D(GL_TEXTURE_2D, 0, colour ? GL_SRGB8_ALPHA8 : GL_RGBA8,
                  image->width, image->height, 0, GL_RGBA, GL_UNSIGNED_BYTE,
                  image->rgba);
    gl.GenerateMipmap(GL_TEXTURE_2D);
    return texture;
}

static GLuint texture_of(view_model *m, const ibl_scene *scene, int image,
                         bool colour)
{
    GLuint *texture = &m->images[colour][image];

    if (!*texture)
        *texture = upload_image(&scene->images[image], colour);
    return *texture;
}

/* offset + R(rotation) (scale t), R turning from +v to +u. */
static void fill_rows(const ibl_scene_texture *t, float rows[2][4])
{
    const double c = cos(t->rotation), s = sin(t->rotation);
    const double turn[2][2] = {{c, s}, {-s, c}};

    for (int i = 0; i < 2; i++) {
        for (int k = 0; k < 2; k++)
            rows[i][k] = (float)(turn[i][k] * t->scale[k]);
        rows[i][2] = (float)t->offset[i];
        rows[i][3] = (float)t->texcoord;
    }
}

static float f0_of(float ior)
{
    const float r = (ior - 1) / (ior + 1);
    /* 0 stands for a surface without a Fresnel effect. */
    return ior == 0 ? 1 : r * r;
}

static model_block block_of(const ibl_scene_material *s, int index)
{
    const float f0 = f0_of(s->ior);
    model_block b = {.emissive = {s->emissive[0], s->emissive[1],
                                  s->emissive[2], (float)(2 + index)},
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
    for (int i = 0; i < SLOTS; i++)
        fill_rows(texture_at(s, i), b.rows[i]);
    return b;
}

static void upload_block(const view_model *m, int i)
{
    gl.BindBuffer(GL_UNIFORM_BUFFER, m->blocks);
    gl.BufferSubData(GL_UNIFORM_BUFFER, (GLintptr)i * m->block_step,
                     sizeof(model_block), &m->materials[i].block);
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
    upload_block(m, i);
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
        to->sampler[slot] = make_sampler(t);
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

static void place(const float m[16], const float p[3], float to[3])
{
    for (int k = 0; k < 3; k++)
        to[k] = m[k] * p[0] + m[4 + k] * p[1] + m[8 + k] * p[2] + m[12 + k];
}

/* The largest distance of a vertex from the middle; 1 if all are there. */
static double radius_of(const ibl_scene *scene, const double middle[3])
{
    double most = 0;

    for (int i = 0; i < scene->draw_count; i++) {
        const ibl_scene_draw *d = &scene->draws[i];
        const ibl_scene_primitive *p = &scene->primitives[d->primitive];
        for (uint32_t v = 0; v < p->vertex_count; v++) {
            const float *at = p->position + 3 * (size_t)v;
            double sum = 0;
            for (int k = 0; k < 3; k++) {
                const double *m = d->to_world + k;
                sum += pow(m[0] * at[0] + m[4] * at[1] + m[8] * at[2] +
                               (m[12] - middle[k]),
                           2);
            }
            most = fmax(most, sum);
        }
    }
    return most > 0 ? sqrt(most) : 1;
}

static bool is_mirrored(const float m[16])
{
    return m[0] * (m[5] * m[10] - m[6] * m[9]) -
               m[1] * (m[4] * m[10] - m[6] * m[8]) +
               m[2] * (m[4] * m[9] - m[5] * m[8]) <
           0;
}

static void make_draws(view_model *m, const ibl_scene *scene)
{
    double middle[3];

    for (int k = 0; k < 3; k++)
        middle[k] = 0.5 * (scene->bounds[0][k] + scene->bounds[1][k]);
    const double scale = 1 / radius_of(scene, middle);
    for (int i = 0; i < scene->draw_count; i++) {
        const ibl_scene_draw *from = &scene->draws[i];
        model_draw *to = &m->draws[i];
        to->part = &m->parts[from->primitive];
        for (int k = 0; k < 16; k++) {
            const double x = from->to_world[k];
            to->to_world[k] =
                (float)(k % 4 == 3 ? x
                                   : scale * (k < 12 ? x : x - middle[k % 4]));
        }
        to->mirrored = is_mirrored(to->to_world);
        place(to->to_world, to->part->middle, to->middle);
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

static bool make_model(ibl_ctx *ctx, view_model *m, ibl_scene *scene,
                       const char *name)
{
    if (!scene->draw_count)
        return view_fail("%s: there are no triangles to draw", name);
    m->parts =
        ibl_need(calloc((size_t)scene->primitive_count, sizeof *m->parts));
    m->materials =
        ibl_need(calloc((size_t)scene->material_count, sizeof *m->materials));
    m->draws = ibl_need(calloc((size_t)scene->draw_count, sizeof *m->draws));
    for (int i = 0; i < 2; i++)
        m->images[i] = ibl_need(
            calloc((size_t)scene->image_count + 1, sizeof *m->images[i]));
    m->part_count = scene->primitive_count;
    for (int i = 0; i < m->part_count; i++)
        make_part(&scene->primitives[i], &m->parts[i]);
    make_draws(m, scene);
    m->draw_count = scene->draw_count;
    return decode_images(ctx, m, scene) && make_materials(m, scene) &&
           view_gl_check(name);
}

view_model *view_model_create(ibl_ctx *ctx, ibl_scene *scene, const char *name)
{
    view_model *m = ibl_need(calloc(1, sizeof *m));

    if (make_model(ctx, m, scene, name))
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
    free(m->programs);
    free(m);
}

bool view_model_paint(view_model *m, const view_settings *s)
{
    const view_material *from = &view_materials[s->material];
    model_block *b = &m->materials[0].block, before = *b;

    for (int k = 0; k < 3; k++) {
        b->base_colour[k] = (float)from->metal[k];
        b->specular[k] = (float)from->dielectric_f0;
    }
    /* Those without a diffuse colour have the same F0 at both ends. */
    b->surface[0] = from->diffuse > 0 ? (float)s->metallic[1] : 1;
    b->surface[1] = (float)(0.5 * (s->roughness[0] + s->roughness[1]));
    if (!memcmp(b, &before, sizeof before))
        return false;
    upload_block(m, 0);
    return true;
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

static void bind_material(const view_model *m, int i)
{
    const model_material *material = &m->materials[i];

    gl.BindBufferRange(GL_UNIFORM_BUFFER, VIEW_BLOCK_MATERIAL, m->blocks,
                       (GLintptr)i * m->block_step, sizeof(model_block));
    for (int slot = 0; slot < SLOTS; slot++) {
        if (!material->texture[slot])
            continue;
        view_gl_bind(VIEW_MODEL_UNITS + slot, GL_TEXTURE_2D,
                     material->texture[slot]);
        gl.BindSampler((GLuint)(VIEW_MODEL_UNITS + slot),
                       material->sampler[slot]);
    }
}

/* Draws with the program of its material, as far as the pass needs it. */
static bool draw_one(view_model *m, const model_draw *d, bool depth,
                     const view_model_light *light)
{
    const model_part *part = d->part;
    const model_material *material = &m->materials[part->material];
    const int all = material->key | part->key;
    const int key =
        depth ? DEPTH_ONLY | (all & HAS_MASK ? all & (HAS_MASK | 1) : 0)
              : (all & ~(light->sheen ? 0 : HAS_SHEEN)) |
                    (light->harmonics ? HARMONICS : 0) |
                    (light->reflection << FEATURE_BITS);
    const GLuint program = program_of(m, key);

    if (!program)
        return false;
    gl.UseProgram(program);
    bind_material(m, part->material);
    gl.BindVertexArray(part->array);
    for (int i = 0; i < 4; i++)
        gl.VertexAttrib4f((GLuint)(TO_WORLD + i), d->to_world[4 * i],
                          d->to_world[4 * i + 1], d->to_world[4 * i + 2],
                          d->to_world[4 * i + 3]);
    gl.FrontFace(d->mirrored ? GL_CW : GL_CCW);
    if (!material->double_sided)
        gl.Enable(GL_CULL_FACE);
    else if (material->blended) {
        /* What is seen through the front. */
        gl.Enable(GL_CULL_FACE);
        gl.CullFace(GL_FRONT);
        gl.DrawElements(GL_TRIANGLES, part->count, GL_UNSIGNED_INT, NULL);
        gl.CullFace(GL_BACK);
    }
    gl.DrawElements(GL_TRIANGLES, part->count, GL_UNSIGNED_INT, NULL);
    gl.Disable(GL_CULL_FACE);
    return true;
}

static bool draw_all(view_model *m, bool blended, bool depth,
                     const view_model_light *light)
{
    for (int i = 0; i < m->draw_count; i++)
        if (m->materials[m->draws[i].part->material].blended == blended &&
            !draw_one(m, &m->draws[i], depth, light))
            return false;
    return true;
}

static int compare_draws(const void *a, const void *b)
{
    const float x = ((const model_draw *)a)->distance2;
    const float y = ((const model_draw *)b)->distance2;

    return (x < y) - (x > y);
}

/* From back to front. */
static void sort_draws(view_model *m, const float eye[3])
{
    for (int i = 0; i < m->draw_count; i++) {
        model_draw *d = &m->draws[i];
        d->distance2 = 0;
        for (int k = 0; k < 3; k++)
            d->distance2 += (d->middle[k] - eye[k]) * (d->middle[k] - eye[k]);
    }
    qsort(m->draws, (size_t)m->draw_count, sizeof *m->draws, compare_draws);
}

/* Depth first, so that each pixel is shaded once but for what is blended. */
static bool draw_passes(view_model *m, const view_model_light *light)
{
    gl.ColorMask(GL_FALSE, GL_FALSE, GL_FALSE, GL_FALSE);
    bool ok = draw_all(m, false, true, light);
    gl.ColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
    gl.DepthMask(GL_FALSE);
    gl.Disable(GL_BLEND);
    ok = ok && draw_all(m, false, false, light);
    gl.Enable(GL_BLEND);
    ok = ok && draw_all(m, true, false, light);
    gl.DepthMask(GL_TRUE);
    return ok;
}

static bool draw_model(view_model *m, const view_model_light *light,
                       const float eye[3])
{
    sort_draws(m, eye);
    gl.Enable(GL_DEPTH_TEST);
    gl.DepthFunc(GL_LEQUAL);
    gl.Clear(GL_DEPTH_BUFFER_BIT);
    for (GLuint i = TANGENT; i < COLOUR; i++)
        gl.VertexAttrib4f(i, 0, 0, 0, 0);
    gl.VertexAttrib4f(COLOUR, 1, 1, 1, 1);
    const bool ok = draw_passes(m, light);
    gl.Disable(GL_BLEND);
    gl.Disable(GL_DEPTH_TEST);
    gl.DepthFunc(GL_LESS);
    gl.FrontFace(GL_CCW);
    for (int i = 0; i < SLOTS; i++)
        gl.BindSampler((GLuint)(VIEW_MODEL_UNITS + i), 0);
    return ok && view_gl_check("drawing the model");
}

/* ---- models or spheres --------------------------------------------------- */

static bool draw_spheres(const view_subject *s, GLuint program)
{
    gl.Enable(GL_BLEND);
    gl.UseProgram(program);
    gl.BindVertexArray(s->instances);
    gl.DrawArraysInstanced(GL_TRIANGLE_STRIP, 0, 4, s->count);
    gl.Disable(GL_BLEND);
    return true;
}

bool view_subject_draw(const view_subject *s, const view_model_light *light,
                       GLuint spheres, const view_image *picture,
                       view_canvas *canvas, int samples)
{
    if (!s->model)
        gl.BindFramebuffer(GL_FRAMEBUFFER, picture->framebuffer);
    else if (!view_canvas_begin(canvas, s->width, s->height, samples))
        return false;
    view_gl_draw_full(s->sky);
    if (!s->model)
        return draw_spheres(s, spheres);
    const bool ok = draw_model(s->model, light, s->eye);
    view_canvas_end(canvas, picture->framebuffer);
    return ok;
}
