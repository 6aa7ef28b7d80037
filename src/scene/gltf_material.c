/* SPDX-License-Identifier: MIT */
/* Materials and textures of glTF, section 3.9, and the Khronos extensions of
 * materials. */
#include <stdlib.h>
#include <string.h>

#include "scene/gltf_reader.h"

#define AT(field) offsetof(ibl_scene_material, field)

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
    {"KHR_materials_ior", "ior", AT(ior), 1, 0, 1e30},
    {"KHR_materials_specular", "specularFactor", AT(specular), 1, 0, 1},
    {"KHR_materials_specular", "specularColorFactor", AT(specular_colour), 3, 0,
     1e30},
    {"KHR_materials_clearcoat", "clearcoatFactor", AT(clearcoat), 1, 0, 1},
    {"KHR_materials_clearcoat", "clearcoatRoughnessFactor",
     AT(clearcoat_roughness), 1, 0, 1},
    {"KHR_materials_sheen", "sheenColorFactor", AT(sheen_colour), 3, 0, 1},
    {"KHR_materials_sheen", "sheenRoughnessFactor", AT(sheen_roughness), 1, 0,
     1},
    {"KHR_materials_anisotropy", "anisotropyStrength", AT(anisotropy), 1, 0, 1},
    {"KHR_materials_transmission", "transmissionFactor", AT(transmission), 1, 0,
     1},
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
    {"KHR_materials_specular", "specularTexture", AT(specular_texture)},
    {"KHR_materials_specular", "specularColorTexture",
     AT(specular_colour_texture)},
    {"KHR_materials_clearcoat", "clearcoatTexture", AT(clearcoat_texture)},
    {"KHR_materials_clearcoat", "clearcoatRoughnessTexture",
     AT(clearcoat_roughness_texture)},
    {"KHR_materials_clearcoat", "clearcoatNormalTexture",
     AT(clearcoat_normal_texture)},
    {"KHR_materials_sheen", "sheenColorTexture", AT(sheen_colour_texture)},
    {"KHR_materials_sheen", "sheenRoughnessTexture",
     AT(sheen_roughness_texture)},
    {"KHR_materials_transmission", "transmissionTexture",
     AT(transmission_texture)},
};

/* A member that is absent or an object. */
static bool object_in(ibl_json_at at, const char *key, ibl_json_at *object)
{
    *object = ibl_json_optional(&at, key);
    return !object->value || json_is_object(object->value) ||
           ibl_json_wrong(*object, "an object");
}

static bool extension_in(ibl_json_at at, const char *name, ibl_json_at *object)
{
    ibl_json_at all;

    return object_in(at, "extensions", &all) && object_in(all, name, object);
}

/* The object of a table's row: "" is the material itself. */
static bool part_of(ibl_json_at at, const char *in, ibl_json_at *object)
{
    *object = at;
    if (!*in)
        return true;
    return strncmp(in, "KHR_", 4) ? object_in(at, in, object)
                                  : extension_in(at, in, object);
}

/* ---- textures --------------------------------------------------------- */

static bool read_sampler(ibl_gltf *g, ibl_json_at index, ibl_scene_texture *t)
{
    ibl_json_at array;
    int count, i;

    if (!ibl_gltf_array(g, "samplers", &array, &count) ||
        !ibl_gltf_index(index, count, &i))
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

static bool read_transform(ibl_json_at at, ibl_scene_texture *t)
{
    ibl_json_at k;

    return extension_in(at, "KHR_texture_transform", &k) &&
           (!k.value || (ibl_gltf_reals(ibl_json_optional(&k, "offset"), 2,
                                        -1e30, 1e30, t->offset) &&
                         ibl_gltf_reals(ibl_json_optional(&k, "scale"), 2,
                                        -1e30, 1e30, t->scale) &&
                         ibl_gltf_reals(ibl_json_optional(&k, "rotation"), 1,
                                        -1e30, 1e30, &t->rotation) &&
                         ibl_json_int(ibl_json_optional(&k, "texCoord"), 0,
                                      INT32_MAX, &t->texcoord)));
}

static bool read_texture(ibl_gltf *g, ibl_json_at at, ibl_scene_texture *t)
{
    ibl_json_at array;
    int count, i;

    if (!at.value)
        return true;
    if (!ibl_gltf_array(g, "textures", &array, &count) ||
        !ibl_gltf_index(ibl_json_member(&at, "index"), count, &i) ||
        !ibl_json_int(ibl_json_optional(&at, "texCoord"), 0, 1, &t->texcoord) ||
        !read_transform(at, t))
        return false;
    const ibl_json_at texture = ibl_json_element(&array, (size_t)i);
    return read_sampler(g, ibl_json_optional(&texture, "sampler"), t) &&
           ibl_gltf_index(ibl_json_optional(&texture, "source"),
                          g->scene->image_count, &t->image);
}

/* ---- materials -------------------------------------------------------- */

static const ibl_scene_texture no_texture = {
    .image = -1, .wrap_s = REPEAT, .wrap_t = REPEAT, .scale = {1, 1}};

static ibl_scene_texture *texture_at(ibl_scene_material *m, int i)
{
    return (ibl_scene_texture *)(void *)((char *)m + textures[i].at);
}

static bool set_default(ibl_gltf *g, ibl_scene_material *m, const char *name)
{
    *m = (ibl_scene_material){.name = strdup(name ? name : ""),
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
    for (size_t i = 0; i < sizeof textures / sizeof *textures; i++)
        *texture_at(m, (int)i) = no_texture;
    return m->name || ibl_gltf_no_memory(g);
}

static bool read_factors(ibl_json_at at, ibl_scene_material *m)
{
    for (size_t i = 0; i < sizeof factors / sizeof *factors; i++) {
        float *to = (float *)(void *)((char *)m + factors[i].at);
        ibl_json_at in;
        if (!part_of(at, factors[i].in, &in) ||
            !ibl_gltf_reals(ibl_json_optional(&in, factors[i].key),
                            factors[i].count, factors[i].low, factors[i].high,
                            to))
            return false;
    }
    return true;
}

static bool read_textures(ibl_gltf *g, ibl_json_at at, ibl_scene_material *m)
{
    for (size_t i = 0; i < sizeof textures / sizeof *textures; i++) {
        ibl_json_at in, texture;
        if (!part_of(at, textures[i].in, &in) ||
            !object_in(in, textures[i].key, &texture) ||
            !read_texture(g, texture, texture_at(m, (int)i)))
            return false;
    }
    return true;
}

static bool read_switches(ibl_json_at at, ibl_scene_material *m)
{
    static const char *const modes[] = {"OPAQUE", "MASK", "BLEND", NULL};
    ibl_json_at unlit, strength;
    float times = 1;

    if (!ibl_json_choice(ibl_json_optional(&at, "alphaMode"), modes,
                         &m->alpha_mode) ||
        !extension_in(at, "KHR_materials_unlit", &unlit) ||
        !extension_in(at, "KHR_materials_emissive_strength", &strength) ||
        !ibl_gltf_reals(ibl_json_optional(&strength, "emissiveStrength"), 1, 0,
                        1e30, &times))
        return false;
    m->unlit = unlit.value;
    m->double_sided = json_is_true(json_object_get(at.value, "doubleSided"));
    for (int k = 0; k < 3; k++)
        m->emissive[k] *= times;
    return true;
}

static bool read_material(ibl_gltf *g, ibl_json_at at)
{
    ibl_scene *s = g->scene;
    ibl_scene_material *m = &s->materials[s->material_count];

    if (!json_is_object(at.value))
        return ibl_json_wrong(at, "an object");
    if (!set_default(g, m,
                     json_string_value(json_object_get(at.value, "name"))))
        return false;
    s->material_count++;
    return read_factors(at, m) && read_textures(g, at, m) &&
           read_switches(at, m);
}

bool ibl_gltf_materials(ibl_gltf *g)
{
    ibl_scene *s = g->scene;
    ibl_json_at array;
    int count;

    if (!ibl_gltf_array(g, "materials", &array, &count))
        return false;
    s->materials = calloc((size_t)count + 1, sizeof *s->materials);
    if (!s->materials)
        return ibl_gltf_no_memory(g);
    for (int i = 0; i < count; i++)
        if (!read_material(g, ibl_json_element(&array, (size_t)i)))
            return false;
    if (!set_default(g, &s->materials[count], NULL))
        return false;
    s->material_count++;
    return true;
}
