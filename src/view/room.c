/* SPDX-License-Identifier: MIT */
#include "view/room.h"

#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/signals.h"
#include "view/gl.h"
#include "view/vector.h"

/* ---- what stands in the room ------------------------------------------- */

enum {
    WHITE = VIEW_ROOM_SPHERES,
    RED,
    GREEN,
    BLUE,
    YELLOW,
    DARK,
    LIGHT,
    STONE,
    ORANGE_LAMP,
    CYAN_LAMP,
    WARM_LAMP,
    PINK_LAMP,
    CEILING_LAMP,
    MATERIALS
};

/* No name, no textures. */
#define NONE                                                                   \
    {                                                                          \
        .image = -1                                                            \
    }
#define PLAIN                                                                  \
    .name = "", .normal_scale = 1, .specular_colour = {1, 1, 1},               \
    .base_colour_texture = NONE, .metallic_roughness_texture = NONE,           \
    .normal_texture = NONE, .occlusion_texture = NONE,                         \
    .emissive_texture = NONE, .specular_texture = NONE,                        \
    .specular_colour_texture = NONE
#define DIFFUSE(r, g, b, rough, refraction)                                    \
    {                                                                          \
        PLAIN, .base_colour = {r, g, b, 1}, .roughness = rough,                \
               .ior = refraction, .specular = 1                                \
    }
#define METAL(r, g, b, rough)                                                  \
    {                                                                          \
        PLAIN, .base_colour = {r, g, b, 1}, .metallic = 1, .roughness = rough  \
    }
/* Emits light and reflects none. */
#define LAMP(r, g, b)                                                          \
    {                                                                          \
        PLAIN, .roughness = 1, .emissive = { r, g, b }                         \
    }

const ibl_scene_material view_room_materials[MATERIALS] = {
    METAL(0.95f, 0.95f, 0.95f, 0),
    LAMP(12, 5, 1.5f),
    METAL(1, 0.78f, 0.34f, 0.25f),
    DIFFUSE(0.05f, 0.2f, 0.55f, 0.3f, 1.5f),
    [WHITE] = DIFFUSE(0.75f, 0.75f, 0.75f, 0.9f, 1.5f),
    [RED] = DIFFUSE(0.63f, 0.1f, 0.07f, 0.8f, 1.5f),
    [GREEN] = DIFFUSE(0.15f, 0.45f, 0.12f, 0.8f, 1.5f),
    [BLUE] = DIFFUSE(0.12f, 0.2f, 0.6f, 0.8f, 1.5f),
    [YELLOW] = DIFFUSE(0.6f, 0.5f, 0.18f, 0.8f, 1.5f),
    [DARK] = DIFFUSE(0.1f, 0.1f, 0.11f, 0.08f, 1.65f),
    [LIGHT] = DIFFUSE(0.3f, 0.29f, 0.27f, 0.08f, 1.65f),
    [STONE] = DIFFUSE(0.5f, 0.47f, 0.42f, 0.35f, 1.5f),
    [ORANGE_LAMP] = LAMP(5, 1.6f, 0.3f),
    [CYAN_LAMP] = LAMP(0.3f, 2.6f, 4),
    [WARM_LAMP] = LAMP(4, 3.6f, 3),
    [PINK_LAMP] = LAMP(4, 0.4f, 2.4f),
    [CEILING_LAMP] = LAMP(7, 6.6f, 6),
};

/* Thickness of walls, which are outside the room. */
#define WALL 0.25
#define OUT (5 + WALL)

const ibl_volume view_room_inside = {
    .shape = IBL_SHAPE_BOX, .centre = {0, 2, 0}, .half = {5, 2, 5}};

enum {
    TILES = 5 /* along an edge of the floor */
};

/* Boxes touch and do not overlap, so no two sides coincide. */
static const view_room_box boxes[VIEW_ROOM_BOXES - TILES * TILES] = {
    {{-OUT, 4, -OUT}, {OUT, 4 + WALL, OUT}, WHITE}, /* the ceiling */
    /* -X, with two windows: below, above, and three piers */
    {{-OUT, 0, -5}, {-5, 1, 5}, RED},
    {{-OUT, 3, -5}, {-5, 4, 5}, RED},
    {{-OUT, 1, -5}, {-5, 3, -3.8}, RED},
    {{-OUT, 1, -1.2}, {-5, 3, 1.2}, RED},
    {{-OUT, 1, 3.8}, {-5, 3, 5}, RED},
    {{5, 0, -5}, {OUT, 4, 5}, GREEN},      /* +X */
    {{-OUT, 0, -OUT}, {OUT, 4, -5}, BLUE}, /* -Z */
    /* +Z, with two windows */
    {{-OUT, 0, 5}, {OUT, 1, OUT}, YELLOW},
    {{-OUT, 3, 5}, {OUT, 4, OUT}, YELLOW},
    {{-OUT, 1, 5}, {-3.8, 3, OUT}, YELLOW},
    {{-1.2, 1, 5}, {1.2, 3, OUT}, YELLOW},
    {{3.8, 1, 5}, {OUT, 3, OUT}, YELLOW},
    /* pillars */
    {{-2.8, 0, -2.8}, {-2.2, 4, -2.2}, STONE},
    {{2.2, 0, -2.8}, {2.8, 4, -2.2}, STONE},
    {{-2.8, 0, 2.2}, {-2.2, 4, 2.8}, STONE},
    {{2.2, 0, 2.2}, {2.8, 4, 2.8}, STONE},
    {{3, 0, -5}, {3.15, 4, -2.9}, WHITE}, /* a wall in a corner */
    /* panels */
    {{4.95, 0.8, -3.6}, {5, 3.2, -2}, ORANGE_LAMP},
    {{4.95, 0.8, 1}, {5, 3.2, 2.6}, CYAN_LAMP},
    {{-4, 1.2, -5}, {-1, 2.8, -4.95}, WARM_LAMP},
    {{1.4, 0.6, -5}, {2, 3.4, -4.95}, PINK_LAMP},
    {{-1.5, 3.95, -3.4}, {1.5, 4, -3}, CEILING_LAMP},
    {{-1.5, 3.95, 3}, {1.5, 4, 3.4}, CEILING_LAMP},
};

view_room_box view_room_box_at(int i)
{
    static const double edges[TILES + 1] = {-OUT, -3, -1, 1, 3, OUT};
    const int x = i % TILES, z = i / TILES;

    if (i >= TILES * TILES)
        return boxes[i - TILES * TILES];
    return (view_room_box){{edges[x], -WALL, edges[z]},
                           {edges[x + 1], 0, edges[z + 1]},
                           i % 2 ? LIGHT : DARK};
}

/* Each swings along every axis as an independent sine. Phase is in turns. */
view_room_sphere view_room_sphere_at(int i, double seconds)
{
    static const struct {
        double radius, middle[3], reach[3], seconds[3], phase[3];
    } spheres[VIEW_ROOM_SPHERES] = {
        {0.6, {0, 0.9, 0}, {0}, {1, 1, 1}, {0}},
        {0.22, {0, 1.1, 0}, {1.8, 0.5, 1.8}, {8, 5, 8}, {0.25, 0, 0}},
        {0.45, {0, 0.45, 3.7}, {3.6, 0, 0}, {11, 1, 1}, {0}},
        {0.5, {-3.7, 1.2, 0}, {0, 0.7, 2.4}, {1, 3, 13}, {0, 0, 0.25}},
    };
    view_room_sphere s = {.radius = spheres[i].radius};

    for (int k = 0; k < 3; k++) {
        const double turns =
            seconds / spheres[i].seconds[k] + spheres[i].phase[k];
        s.centre[k] =
            spheres[i].middle[k] + spheres[i].reach[k] * sin(2 * M_PI * turns);
    }
    return s;
}

/* ---- the room as a model ----------------------------------------------- */

/* Maximum edge of a cell, in units, for paraboloids, which keep the edges of
 * triangles straight; of a sphere's, in radii. */
static const double box_cell = 0.5, sphere_cell = 2.0 / 24;

/* Adds the sides of a box in cells, counter-clockwise seen from outside. round:
 * of the box -1..1, moved to the sphere of radius 1. */
static void add_box(ibl_scene_primitive *p, const double low[3],
                    const double high[3], double cell, bool round)
{
    for (int i = 0; i < 6; i++) {
        const int axis = i / 2, far = i % 2; /* u x v is the normal */
        const int u = (axis + 2 - far) % 3, v = (axis + 1 + far) % 3;
        const int columns = (int)ceil((high[u] - low[u]) / cell);
        const int rows = (int)ceil((high[v] - low[v]) / cell);
        const uint32_t row = (uint32_t)columns + 1;
        const size_t count = p->vertex_count + row * ((size_t)rows + 1);
        p->position = ibl_need(realloc(p->position, 12 * count));
        p->normal = ibl_need(realloc(p->normal, 12 * count));
        p->index = ibl_need(realloc(
            p->index, 4 * (p->index_count + (size_t)6 * columns * rows)));
        for (int k = 0; k < (int)row * (rows + 1); k++) {
            const uint32_t a = p->vertex_count++;
            const int x = k % (int)row, y = k / (int)row;
            const uint32_t corners[6] = {a, a + 1,       a + row + 1,
                                         a, a + row + 1, a + row};
            double place[3], out[3] = {0};
            place[axis] = (far ? high : low)[axis];
            place[u] = low[u] + (high[u] - low[u]) * x / columns;
            place[v] = low[v] + (high[v] - low[v]) * y / rows;
            out[axis] = far ? 1 : -1;
            if (round)
                normalise3(place);
            for (int j = 0; j < 3; j++) {
                p->position[3 * a + (uint32_t)j] = (float)place[j];
                p->normal[3 * a + (uint32_t)j] =
                    (float)(round ? place : out)[j];
            }
            if (x == columns || y == rows)
                continue;
            memcpy(p->index + p->index_count, corners, sizeof corners);
            p->index_count += 6;
        }
    }
}

/* A draw for each material. */
static view_model *make_model(void)
{
    static const double one[3] = {1, 1, 1}, minus[3] = {-1, -1, -1};
    ibl_scene_primitive primitive[MATERIALS] = {{0}};
    ibl_scene_material material[MATERIALS];
    ibl_scene_draw draw[MATERIALS] = {{0}};
    ibl_scene scene = {.primitives = primitive,
                       .materials = material,
                       .draws = draw,
                       .primitive_count = MATERIALS,
                       .material_count = MATERIALS,
                       .draw_count = MATERIALS};

    memcpy(material, view_room_materials, sizeof material);
    for (int i = 0; i < VIEW_ROOM_SPHERES; i++)
        add_box(&primitive[i], minus, one, sphere_cell, true);
    for (int i = 0; i < VIEW_ROOM_BOXES; i++) {
        const view_room_box b = view_room_box_at(i);
        add_box(&primitive[b.material], b.low, b.high, box_cell, false);
    }
    for (int i = 0; i < MATERIALS; i++) {
        primitive[i].material = draw[i].primitive = i;
        for (int k = 0; k < 16; k += 5)
            draw[i].to_world[k] = 1;
    }
    view_model *m = view_model_create(NULL, &scene, "the room");
    for (int i = 0; i < MATERIALS; i++) {
        free(primitive[i].position);
        free(primitive[i].normal);
        free(primitive[i].index);
    }
    if (m)
        view_model_place(m, NULL, 0);
    return m;
}

/* ---- drawing ------------------------------------------------------------ */

enum {
    MOST = IBL_MAX_PROBES + 1
};

/* Uniform block "Room" (shaders/room.glsl), std140. */
typedef struct room_block {
    int order[4]; /* index of the dynamic probe, or their number; number of
                     probes; of the nearest that are mixed, 0: by influence; 1:
                     weights are drawn, 2: the largest */
    float local_lod[4], dynamic_lod[4]; /* as view_frame.lod */
    float scales[4]; /* of irradiance: locals, dynamic probe; 1: a paraboloid */
} room_block;

struct view_room {
    view_model *model;
    GLuint probes, texels; /* packed probes, and their buffer texture */
    ibl_probe probe[MOST]; /* to pack: the dynamic one is the last */
};

view_room *view_room_create(void)
{
    view_room *r = ibl_need(calloc(1, sizeof *r));

    if (!(r->model = make_model())) {
        view_room_free(r);
        return NULL;
    }
    r->probes = view_gl_buffer(GL_TEXTURE_BUFFER,
                               sizeof(float) * IBL_PROBE_FLOATS * MOST, NULL);
    gl.GenTextures(1, &r->texels);
    view_gl_bind(VIEW_ROOM_UNIT_BUFFER, GL_TEXTURE_BUFFER, r->texels);
    gl.TexBuffer(GL_TEXTURE_BUFFER, GL_RGBA32F, r->probes);
    return r;
}

void view_room_free(view_room *r)
{
    if (r)
        view_model_free(r->model);
    free(r);
}

/* What a draw changes of the environment's frame. Returns whether the picture
 * is mirrored. */
static bool fill_frame(view_frame *f, const view_room_draw *d, int width,
                       int height)
{
    const view_camera *c = &d->camera;
    const double *axes[3] = {c->right, c->up, c->forward};
    double right_up[3];

    view_frame_camera(f, c, width, height);
    /* As shaders/room.glsl has it, distances in units of far. */
    for (int i = 0; i < 16 && d->paraboloid; i++) {
        const double *axis = axes[i % 4 % 3];
        f->clip[i] =
            (float)(i % 4 == 3 ? (i == 15 ? c->near : 0) / c->far
                               : (i < 12 ? axis[i / 4] : -dot3(axis, c->eye)) /
                                     c->far);
    }
    f->shading[1] = f->shading[3] = 0;       /* no point lights, only level 0 */
    f->reflection[2] = f->reflection[3] = 0; /* nor others */
    cross3(c->right, c->up, right_up);
    return dot3(right_up, c->forward) > 0;
}

/* Uploads probes in the order in which they count, with proxies that do. */
static void upload_probes(view_room *r, const view_room_draw *d)
{
    const view_settings *s = &d->settings;
    const int locals = d->locals.count, all = locals + d->dynamic.count;
    const int nearest = !locals || s->probe_choice == VIEW_PROBES_BLEND ? 0
                        : s->probe_choice == VIEW_PROBES_NEAREST        ? 1
                                                                 : s->nearest;
    float packed[MOST * IBL_PROBE_FLOATS];
    int order[MOST], place = 0;
    room_block b = {.scales = {d->locals.irradiance_scale,
                               d->dynamic.irradiance_scale,
                               (float)d->paraboloid}};

    for (int i = 0; i < all; i++) {
        ibl_probe *p = &r->probe[i];
        *p = i < locals ? d->locals.probe[i] : *d->dynamic.probe;
        p->has_proxy = p->has_proxy && s->parallax != VIEW_PARALLAX_NONE;
        if (s->parallax == VIEW_PARALLAX_SPHERE &&
            p->proxy.shape == IBL_SHAPE_BOX) {
            p->proxy.shape = IBL_SHAPE_SPHERE;
            p->proxy.half[0] = sqrt(dot3(p->proxy.half, p->proxy.half));
        }
    }
    ibl_probes_order(r->probe, all, order);
    while (place < all && order[place] < locals)
        place++;
    for (; nearest && place && place < locals; place++) /* behind them */
        order[place] = place, order[place + 1] = locals;
    ibl_probes_pack(r->probe, all, order, packed);
    memcpy(b.order, (int[4]){place, all, nearest, d->largest ? 2 : s->weights},
           sizeof b.order);
    memcpy(b.local_lod, d->locals.lod, sizeof b.local_lod);
    memcpy(b.dynamic_lod, d->dynamic.lod, sizeof b.dynamic_lod);
    gl.BindBuffer(GL_TEXTURE_BUFFER, r->probes);
    gl.BufferSubData(GL_TEXTURE_BUFFER, 0, sizeof packed, packed);
    view_gl_block(VIEW_BLOCK_ROOM, &b, sizeof b);
}

bool view_room_render(view_room *r, const view_room_draw *d, view_image *to)
{
    const view_room_environment *e = &d->environment;
    const float eye[3] = {(float)d->camera.eye[0], (float)d->camera.eye[1],
                          (float)d->camera.eye[2]};
    const GLenum cube = GL_TEXTURE_CUBE_MAP, array = GL_TEXTURE_CUBE_MAP_ARRAY;
    char text[64];
    view_frame frame = e->frame;
    const view_lighting light = {
        .reflection = d->settings.reflection ? VIEW_FIT : VIEW_SPLIT_SUM,
        .diffuse = (view_diffuse)e->frame.choice[1],
        .probes = true,
        .mirrored = fill_frame(&frame, d, to->width, to->height)};

    snprintf(text, sizeof text, "#define PROBES\n#define BACKDROP %d\n",
             e->map ? VIEW_BACKDROP_MAP : VIEW_BACKDROP_CUBE);
    const GLuint sky = view_program(text, "full.vert", "sky.frag");
    if (!sky)
        return false;
    gl.Disable(GL_BLEND);
    view_gl_block(VIEW_BLOCK_FRAME, &frame, sizeof frame);
    upload_probes(r, d);
    view_gl_bind(VIEW_UNIT_SPECULAR, cube, e->specular);
    view_gl_bind(VIEW_UNIT_IRRADIANCE, cube, e->irradiance);
    view_gl_bind(VIEW_UNIT_SKY, cube, e->sky);
    view_gl_bind(VIEW_UNIT_LUT, GL_TEXTURE_2D, d->table);
    view_gl_bind(VIEW_ROOM_UNIT_LOCALS, array, d->locals.specular);
    view_gl_bind(VIEW_ROOM_UNIT_LOCALS_MATTE, array, d->locals.irradiance);
    view_gl_bind(VIEW_ROOM_UNIT_DYNAMIC, array, d->dynamic.specular);
    view_gl_bind(VIEW_ROOM_UNIT_DYNAMIC_MATTE, array, d->dynamic.irradiance);
    view_gl_bind(VIEW_ROOM_UNIT_BUFFER, GL_TEXTURE_BUFFER, r->texels);
    view_image_begin(to);
    gl.ClearColor(0, 0, 0, 0);
    if (d->bare)
        gl.Clear(GL_COLOR_BUFFER_BIT);
    if (d->paraboloid)
        gl.Enable(GL_CLIP_DISTANCE0);
    for (int i = 0; i < VIEW_ROOM_SPHERES; i++) {
        const view_room_sphere s = view_room_sphere_at(i, d->settings.seconds);
        const bool shown = i ? d->moving : d->mirror;
        view_model_move(r->model, i, s.centre, shown ? s.radius : 0);
    }
    const bool ok = view_model_draw(r->model, &light, eye) &&
                    (!d->guest || view_model_draw(d->guest, &light, eye));
    gl.Disable(GL_CLIP_DISTANCE0);
    gl.Enable(GL_DEPTH_TEST);
    gl.DepthFunc(GL_LEQUAL); /* the sky has the cleared depth */
    if (!d->bare)
        view_gl_draw_full(sky);
    gl.DepthFunc(GL_LESS);
    gl.Disable(GL_DEPTH_TEST);
    return ok;
}
