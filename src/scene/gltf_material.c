/* SPDX-License-Identifier: MIT */
/* Materials and textures of glTF, section 3.9, and the Khronos extensions of
 * materials. */
#include <stdlib.h>
#include <string.h>

#include "common/signals.h"
#include "scene/gltf_reader.h"

#define AT(field) offsetof(ibl_scene_material, field)

#define K "KHR_materials_"
#define GLOSSY K "pbrSpecularGlossiness"

enum {
    REPEAT = 10497 /* OpenGL's number */
};

/* Numbers of a material: the objects that they are in, from outside, their
 * key, and what they are clamped to. */
static const struct {
    const char *in, *key;
    size_t at;
    int count;
    double low, high;
} factors[] = {
    {"pbrMetallicRoughness", "baseColorFactor", AT(base_colour), 4, 0, 1},
    {"pbrMetallicRoughness", "metallicFactor", AT(metallic), 1, 0, 1},
    {"pbrMetallicRoughness", "roughnessFactor", AT(roughness), 1, 0, 1},
    {"", "emissiveFactor", AT(emissive), 3, 0, 1e30},
    {"", "alphaCutoff", AT(alpha_cutoff), 1, 0, 1e30},
    {"normalTexture", "scale", AT(normal_scale), 1, -1e30, 1e30},
    {"occlusionTexture", "strength", AT(occlusion_strength), 1, 0, 1},
    {K "ior", "ior", AT(ior), 1, 0, 1e30},
    {K "specular", "specularFactor", AT(specular), 1, 0, 1},
    {K "specular", "specularColorFactor", AT(specular_colour), 3, 0, 1e30},
    {K "clearcoat", "clearcoatFactor", AT(clearcoat), 1, 0, 1},
    {K "clearcoat", "clearcoatRoughnessFactor", AT(clearcoat_roughness), 1, 0,
     1},
    {K "sheen", "sheenColorFactor", AT(sheen_colour), 3, 0, 1},
    {K "sheen", "sheenRoughnessFactor", AT(sheen_roughness), 1, 0, 1},
    {K "anisotropy", "anisotropyStrength", AT(anisotropy), 1, 0, 1},
    {K "transmission", "transmissionFactor", AT(transmission), 1, 0, 1},
    {GLOSSY, "diffuseFactor", AT(base_colour), 4, 0, 1},
    {GLOSSY, "specularFactor", AT(specular_colour), 3, 0, 1},
    {GLOSSY, "glossinessFactor", AT(roughness), 1, 0, 1}, /* till it is read */
};

static const struct {
    const char *in, *key;
    size_t at;
} textures[] = {
    {"pbrMetallicRoughness", "baseColorTexture", AT(base_colour_texture)},
    {"pbrMetallicRoughness", "metallicRoughnessTexture",
     AT(metallic_roughness_texture)},
    {"", "normalTexture", AT(normal_texture)},
    {"", "occlusionTexture", AT(occlusion_texture)},
    {"", "emissiveTexture", AT(emissive_texture)},
    {K "specular", "specularTexture", AT(specular_texture)},
    {K "specular", "specularColorTexture", AT(specular_colour_texture)},
    {K "clearcoat", "clearcoatTexture", AT(clearcoat_texture)},
    {K "clearcoat", "clearcoatRoughnessTexture",
     AT(clearcoat_roughness_texture)},
    {K "clearcoat", "clearcoatNormalTexture", AT(clearcoat_normal_texture)},
    {K "sheen", "sheenColorTexture", AT(sheen_colour_texture)},
    {K "sheen", "sheenRoughnessTexture", AT(sheen_roughness_texture)},
    {K "transmission", "transmissionTexture", AT(transmission_texture)},
    {GLOSSY, "diffuseTexture", AT(base_colour_texture)},
    {GLOSSY, "specularGlossinessTexture", AT(specular_colour_texture)},
    {GLOSSY, "specularGlossinessTexture", AT(metallic_roughness_texture)},
};

/* The object of a table's row: "" is the material itself. False: it does not
 * count, or is wrong. One with specular and glossiness has no other of them. */
static bool part_of(ibl_json_at at, const char *in, bool glossy,
                    ibl_json_at *object)
{
    *object = at;
    if (!*in)
        return true;
    if (glossy && !strcmp(in, "pbrMetallicRoughness"))
        return false;
    return strncmp(in, "KHR_", 4) ? ibl_gltf_object(at, in, object)
                                  : ibl_gltf_extension(at, in, object);
}

/* ---- textures --------------------------------------------------------- */

static bool read_sampler(ibl_gltf *g, ibl_json_at index, ibl_scene_texture *t)
{
    ibl_json_at array;
    const int count = ibl_gltf_array(g, "samplers", &array);
    int i;

    if (!ibl_gltf_index(index, count, &i))
        return false;
    if (i < 0)
        return true;
    const ibl_json_at at = ibl_json_element(&array, (size_t)i);
    return ibl_json_int(ibl_json_optional(&at, "wrapS"), 10497, 33648,
                        &t->wrap_s) &&
           ibl_json_int(ibl_json_optional(&at, "wrapT"), 10497, 33648,
                        &t->wrap_t) &&
           ibl_json_int(ibl_json_optional(&at, "minFilter"), 9728, 9987,
                        &t->filter_min) &&
           ibl_json_int(ibl_json_optional(&at, "magFilter"), 9728, 9987,
                        &t->filter_mag);
}

/* *set: the file's number of the texture coordinates. */
static bool read_transform(ibl_json_at at, ibl_scene_texture *t, int *set)
{
    ibl_json_at k;

    return ibl_gltf_extension(at, "KHR_texture_transform", &k) &&
           ibl_gltf_reals(ibl_json_optional(&k, "offset"), 2, -1e30, 1e30,
                          t->offset) &&
           ibl_gltf_reals(ibl_json_optional(&k, "scale"), 2, -1e30, 1e30,
                          t->scale) &&
           ibl_gltf_reals(ibl_json_optional(&k, "rotation"), 1, -1e30, 1e30,
                          &t->rotation) &&
           ibl_json_int(ibl_json_optional(&k, "texCoord"), 0, INT32_MAX, set);
}

/* The image of a texture, by an extension or its source. Of WebP the source is
 * taken where there is no decoder; else in place of what is not read. */
static bool read_source(ibl_gltf *g, ibl_json_at at, int *image)
{
    static const char *const names[] = {"EXT_texture_webp", "EXT_texture_avif",
                                        "KHR_texture_basisu",
                                        "MSFT_texture_dds"};
    const int count = g->scene->image_count;
    ibl_json_at in;

    if (!ibl_gltf_index(ibl_json_optional(&at, "source"), count, image))
        return false;
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        if (!ibl_gltf_extension(at, names[i], &in))
            return false;
        if (!in.value || (*image >= 0 && (i || !ibl_gltf_decoders()->webp)))
            continue;
        if (!ibl_gltf_index(ibl_json_member(&in, "source"), count, image))
            return false;
        break;
    }
    if (*image >= 0 && !g->scene->images[*image].encoded)
        *image = -1; /* a warning said so */
    return true;
}

static bool read_texture(ibl_gltf *g, ibl_json_at at, ibl_scene_material *m,
                         ibl_scene_texture *t)
{
    ibl_json_at array;
    const int count = ibl_gltf_array(g, "textures", &array);
    int i, set = 0, slot = 0;

    if (!at.value)
        return true;
    if (!ibl_gltf_index(ibl_json_member(&at, "index"), count, &i) ||
        !ibl_json_int(ibl_json_optional(&at, "texCoord"), 0, INT32_MAX, &set) ||
        !read_transform(at, t, &set))
        return false;
    while (slot < IBL_SCENE_TEXCOORDS && m->sets[slot] >= 0 &&
           m->sets[slot] != set)
        slot++;
    if (slot == IBL_SCENE_TEXCOORDS)
        return ibl_json_complain(at,
                                 "its material uses over %d sets of texture "
                                 "coordinates",
                                 IBL_SCENE_TEXCOORDS);
    const ibl_json_at texture = ibl_json_element(&array, (size_t)i);
    if (!read_sampler(g, ibl_json_optional(&texture, "sampler"), t) ||
        !read_source(g, texture, &t->image))
        return false;
    m->sets[slot] = set;
    t->texcoord = slot;
    return true;
}

/* ---- materials -------------------------------------------------------- */

static const ibl_scene_texture no_texture = {
    .image = -1, .wrap_s = REPEAT, .wrap_t = REPEAT, .scale = {1, 1}};

static ibl_scene_texture *texture_at(ibl_scene_material *m, int i)
{
    return (ibl_scene_texture *)(void *)((char *)m + textures[i].at);
}

ibl_scene_material ibl_scene_material_default(void)
{
    static char unnamed[] = "";
    ibl_scene_material m = {.name = unnamed,
                            .base_colour = {1, 1, 1, 1},
                            .metallic = 1,
                            .roughness = 1,
                            .normal_scale = 1,
                            .occlusion_strength = 1,
                            .alpha_cutoff = 0.5f,
                            .ior = 1.5f,
                            .specular = 1,
                            .specular_colour = {1, 1, 1},
                            .clearcoat_normal_scale = 1};

    for (int i = 1; i < IBL_SCENE_TEXCOORDS; i++)
        m.sets[i] = -1;
    for (size_t i = 0; i < sizeof textures / sizeof *textures; i++)
        *texture_at(&m, (int)i) = no_texture;
    return m;
}

static void set_default(ibl_scene_material *m, const char *name)
{
    *m = ibl_scene_material_default();
    m->name = ibl_need(strdup(name ? name : m->name));
}

static void read_factors(ibl_json_at at, ibl_scene_material *m)
{
    for (size_t i = 0; i < sizeof factors / sizeof *factors; i++) {
        float *to = (float *)(void *)((char *)m + factors[i].at);
        const int count = factors[i].count;
        ibl_json_at in;
        double x[4];
        if (!part_of(at, factors[i].in, m->glossy, &in) ||
            !json_object_get(in.value, factors[i].key) ||
            !ibl_gltf_reals(ibl_json_member(&in, factors[i].key), count,
                            factors[i].low, factors[i].high, x))
            continue;
        for (int k = 0; k < count; k++)
            to[k] = (float)x[k];
    }
}

static void read_textures(ibl_gltf *g, ibl_json_at at, ibl_scene_material *m)
{
    for (size_t i = 0; i < sizeof textures / sizeof *textures; i++) {
        ibl_scene_texture *t = texture_at(m, (int)i);
        ibl_json_at in, texture;
        if (part_of(at, textures[i].in, m->glossy, &in) &&
            (!ibl_gltf_object(in, textures[i].key, &texture) ||
             !read_texture(g, texture, m, t)))
            *t = no_texture;
    }
}

static void read_switches(ibl_json_at at, ibl_scene_material *m)
{
    static const char *const modes[] = {"OPAQUE", "MASK", "BLEND", NULL};
    ibl_json_at unlit, strength;
    double times = 1;

    ibl_json_choice(ibl_json_optional(&at, "alphaMode"), modes, &m->alpha_mode);
    if (ibl_gltf_extension(at, "KHR_materials_unlit", &unlit))
        m->unlit = unlit.value;
    if (ibl_gltf_extension(at, "KHR_materials_emissive_strength", &strength))
        ibl_gltf_reals(ibl_json_optional(&strength, "emissiveStrength"), 1, 0,
                       1e30, &times);
    m->double_sided = json_is_true(json_object_get(at.value, "doubleSided"));
    for (int k = 0; k < 3; k++)
        m->emissive[k] = (float)(m->emissive[k] * times);
    if (m->glossy) {
        m->roughness = 1 - m->roughness;
        m->metallic = m->ior = 0;
    }
}

static void read_material(ibl_gltf *g, ibl_json_at at)
{
    ibl_scene *s = g->scene;
    ibl_scene_material *m = &s->materials[s->material_count];
    ibl_json_at glossy;

    set_default(m, json_string_value(json_object_get(at.value, "name")));
    s->material_count++;
    if (!json_is_object(at.value)) {
        ibl_json_wrong(at, "an object");
        return;
    }
    m->glossy = ibl_gltf_extension(at, GLOSSY, &glossy) && glossy.value;
    read_factors(at, m);
    read_textures(g, at, m);
    read_switches(at, m);
}

void ibl_gltf_materials(ibl_gltf *g)
{
    ibl_scene *s = g->scene;
    ibl_json_at array;
    const int count = ibl_gltf_array(g, "materials", &array);

    s->materials = ibl_need(calloc((size_t)count + 1, sizeof *s->materials));
    for (int i = 0; i < count && !g->status; i++)
        read_material(g, ibl_json_element(&array, (size_t)i));
    if (!g->status)
        set_default(&s->materials[s->material_count++], NULL);
}

void ibl_scene_forget(ibl_scene *s, int image)
{
    for (int i = 0; i < s->material_count; i++)
        for (size_t k = 0; k < sizeof textures / sizeof *textures; k++)
            if (texture_at(&s->materials[i], (int)k)->image == image)
                texture_at(&s->materials[i], (int)k)->image = -1;
}
