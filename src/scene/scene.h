/* SPDX-License-Identifier: MIT */
/*
 * Scenes of glTF 2.0 (.gltf, .glb): triangles, materials, images and cameras.
 * Skins are
 * in the pose of the file's nodes, without animation; lights, lines and points
 * are left out.
 */
#ifndef SCENE_SCENE_H
#define SCENE_SCENE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include <ibl/ibl.h>

enum {
    IBL_SCENE_TEXCOORDS = 4, /* sets that a material may use */
    IBL_SCENE_JOINTS = 2     /* sets of four joints that move a vertex */
};

/* A reference to an image. A texture coordinate t is taken to
 * offset + R(rotation) (scale t) before the lookup, with R turning from +v to
 * +u (KHR_texture_transform); v = 0 is the image's first row. */
typedef struct ibl_scene_texture {
    int image;    /* -1: none, which stands for white */
    int texcoord; /* the set, of the primitive's texcoord */
    int wrap_s, wrap_t, filter_min, filter_mag; /* OpenGL's numbers; the
                                                   filters may be 0: any */
    double offset[2], scale[2], rotation;       /* radians */
} ibl_scene_texture;

typedef enum ibl_scene_alpha {
    IBL_SCENE_OPAQUE,
    IBL_SCENE_MASK,
    IBL_SCENE_BLEND
} ibl_scene_alpha;

/* A material of metallic-roughness, with the defaults of glTF and of the
 * extensions that it does not use. One of specular and glossiness is a
 * dielectric whose ior of 0 makes specular_colour its F0, and is `glossy`.
 * Textures multiply the factors: in the channels that glTF and its extensions
 * say. Colours of factors are linear, those of base colour, emissive, specular
 * colour and sheen colour images are sRGB. */
typedef struct ibl_scene_material {
    char *name;                    /* "" if it has none */
    int sets[IBL_SCENE_TEXCOORDS]; /* the file's numbers of the sets of texture
                                      coordinates; the first is 0, -1: none */
    float base_colour[4];
    float metallic, roughness;
    float emissive[3]; /* with its strength */
    float normal_scale, occlusion_strength;
    ibl_scene_alpha alpha_mode;
    float alpha_cutoff;
    bool double_sided, unlit;
    bool glossy; /* roughness is 1 - (1 - factor) A, A of its texture */
    float ior, specular, specular_colour[3];
    float clearcoat, clearcoat_roughness, clearcoat_normal_scale;
    float sheen_colour[3], sheen_roughness; /* colour 0: no sheen */
    float anisotropy;
    float transmission;
    ibl_scene_texture base_colour_texture;
    ibl_scene_texture metallic_roughness_texture; /* G roughness, B metallic */
    ibl_scene_texture normal_texture;
    ibl_scene_texture occlusion_texture; /* R */
    ibl_scene_texture emissive_texture;
    ibl_scene_texture specular_texture; /* A */
    ibl_scene_texture specular_colour_texture;
    ibl_scene_texture clearcoat_texture;           /* R */
    ibl_scene_texture clearcoat_roughness_texture; /* G */
    ibl_scene_texture clearcoat_normal_texture;
    ibl_scene_texture sheen_colour_texture;
    ibl_scene_texture sheen_roughness_texture; /* A */
    ibl_scene_texture transmission_texture;    /* R */
} ibl_scene_material;

/* Without a name, textures and any extension. */
ibl_scene_material ibl_scene_material_default(void);

/* Triangles of one material. */
typedef struct ibl_scene_primitive {
    int material; /* an index; never -1: glTF's default is the last one */
    uint32_t vertex_count, index_count; /* index_count: a multiple of 3 */
    float *position;                    /* 3 each */
    float *normal;  /* 3 each; flat ones if the file has none */
    float *tangent; /* 4 each, w the sign of the bitangent; or NULL */
    float *texcoord[IBL_SCENE_TEXCOORDS]; /* 2 each, or NULL */
    float *colour;                        /* 4 each, linear; or NULL */
    uint32_t *index;                      /* all below vertex_count */
    /* 4 each, or NULL: only while it is read. */
    float *joints[IBL_SCENE_JOINTS], *weights[IBL_SCENE_JOINTS];
} ibl_scene_primitive;

/* A primitive in the world, which may be far from its origin. A matrix is
 * stored by columns. */
typedef struct ibl_scene_draw {
    int primitive;
    double to_world[16];
} ibl_scene_draw;

/* A perspective camera of the default scene, which looks along its -Z, +Y up;
 * orthographic ones are left out. */
typedef struct ibl_scene_camera {
    char *name;    /* of the camera, else of its node; "" if neither has one */
    double yfov;   /* radians, 0..pi */
    double aspect; /* width by height; 0: that of the picture */
    double to_world[16];
} ibl_scene_camera;

typedef struct ibl_scene_image {
    char *name;                   /* for messages: its file, or "image 3" */
    const unsigned char *encoded; /* PNG, JPEG or another, in its buffer */
    size_t encoded_size;
    int width, height;   /* of rgba; 0 before it is decoded */
    unsigned char *rgba; /* rows from the top; NULL before it is decoded */
} ibl_scene_image;

typedef struct ibl_scene {
    ibl_scene_primitive *primitives;
    ibl_scene_material *materials; /* at least one */
    ibl_scene_draw *draws;         /* of the default scene */
    ibl_scene_image *images;
    ibl_scene_camera *cameras; /* in the order of the nodes */
    int primitive_count, material_count, draw_count, image_count, camera_count;
    double bounds[2][3]; /* lowest and highest place in the world of what is
                            drawn; 0 if nothing is */
    char **files;        /* all that were read, the scene's own first: for
                            --depfile, and for reading again */
    int file_count;
    bool strict;
    struct ibl_scene_store *store; /* what images point into */
} ibl_scene;

/*
 * Reads a scene, its buffers and the bytes of its images, which are not decoded
 * yet. Sizes are checked before memory is allocated.
 *   strict  a part that is wrong or that cannot be read is an error
 *   out     zeroed or uninitialised; to be freed with ibl_scene_free, after
 *           errors too
 * Else warns of what is left out: parts that are wrong, files that are not
 * there, extensions that are not read, lines and points.
 * IBL_ERR_IO: the file cannot be read. IBL_ERR_FORMAT: no glTF 2.0, damaged, or
 * without triangles. IBL_ERR_MEMORY.
 * Source: Khronos, glTF 2.0 specification, version 2.0.1.
 */
ibl_status ibl_scene_read(ibl_ctx *ctx, const char *path, bool strict,
                          ibl_scene *out);
void ibl_scene_free(ibl_scene *scene); /* zeroed is fine */

/*
 * Decodes images to 8 bits a channel, on the context's pool, with values as in
 * the files. What is decoded stays as it is. An image that cannot be decoded is
 * warned of and taken out of all materials; strict: an error.
 *   images  count of their numbers
 *   reduce  1, or 2, 4, 8: a JPEG may become so many times smaller, the mean of
 *           its pixels, which is faster
 * IBL_ERR_FORMAT, also where memory ran out; IBL_ERR_MEMORY.
 */
ibl_status ibl_scene_decode_all(ibl_ctx *ctx, ibl_scene *scene,
                                const int *images, int count, int reduce);

#endif
