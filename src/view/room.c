/* SPDX-License-Identifier: MIT */
#include "view/room.h"

#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "common/signals.h"
#include "view/gl.h"
#include "view/message.h"
#include "view/vector.h"

/* ---- what stands in the room ------------------------------------------- */

enum {
    WHITE,
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
    SPHERE_MATERIALS,
    MATERIALS = SPHERE_MATERIALS + VIEW_ROOM_SPHERES
};

#define DIFFUSE(r, g, b, rough, reflectance)                                   \
    {                                                                          \
        .albedo = {r, g, b}, .roughness = rough, .f0 = {                       \
            reflectance,                                                       \
            reflectance,                                                       \
            reflectance                                                        \
        }                                                                      \
    }
/* Emits light and reflects none. */
#define LAMP(r, g, b)                                                          \
    {                                                                          \
        .roughness = 1, .emission = { r, g, b }                                \
    }

static const view_room_material materials[MATERIALS] = {
    [WHITE] = DIFFUSE(0.75f, 0.75f, 0.75f, 0.9f, 0.04f),
    [RED] = DIFFUSE(0.63f, 0.1f, 0.07f, 0.8f, 0.04f),
    [GREEN] = DIFFUSE(0.15f, 0.45f, 0.12f, 0.8f, 0.04f),
    [BLUE] = DIFFUSE(0.12f, 0.2f, 0.6f, 0.8f, 0.04f),
    [YELLOW] = DIFFUSE(0.6f, 0.5f, 0.18f, 0.8f, 0.04f),
    [DARK] = DIFFUSE(0.1f, 0.1f, 0.11f, 0.08f, 0.06f),
    [LIGHT] = DIFFUSE(0.3f, 0.29f, 0.27f, 0.08f, 0.06f),
    [STONE] = DIFFUSE(0.5f, 0.47f, 0.42f, 0.35f, 0.04f),
    [ORANGE_LAMP] = LAMP(5, 1.6f, 0.3f),
    [CYAN_LAMP] = LAMP(0.3f, 2.6f, 4),
    [WARM_LAMP] = LAMP(4, 3.6f, 3),
    [PINK_LAMP] = LAMP(4, 0.4f, 2.4f),
    [CEILING_LAMP] = LAMP(7, 6.6f, 6),
    /* of spheres */
    {.f0 = {0.95f, 0.95f, 0.95f}},
    LAMP(12, 5, 1.5f),
    {.roughness = 0.25f, .f0 = {1, 0.78f, 0.34f}},
    DIFFUSE(0.05f, 0.2f, 0.55f, 0.3f, 0.04f),
};

/* Thickness of walls, which are outside the room. */
#define WALL 0.25
#define OUT (5 + WALL)

const double view_room_centre[3] = {0, 2, 0}, view_room_half[3] = {5, 2, 5};

/* A row of five tiles of the floor, from -X to +X. */
#define TILES(from, to, even, odd)                                             \
    {{-OUT, -WALL, from}, {-3, 0, to}, &materials[even]},                      \
        {{-3, -WALL, from}, {-1, 0, to}, &materials[odd]},                     \
        {{-1, -WALL, from}, {1, 0, to}, &materials[even]},                     \
        {{1, -WALL, from}, {3, 0, to}, &materials[odd]},                       \
    {                                                                          \
        {3, -WALL, from}, {OUT, 0, to}, &materials[even]                       \
    }

/* Boxes touch and do not overlap, so no two sides coincide. */
static const view_room_box boxes[VIEW_ROOM_BOXES] = {
    TILES(-OUT, -3, DARK, LIGHT),
    TILES(-3, -1, LIGHT, DARK),
    TILES(-1, 1, DARK, LIGHT),
    TILES(1, 3, LIGHT, DARK),
    TILES(3, OUT, DARK, LIGHT),
    {{-OUT, 4, -OUT},
     {OUT, 4 + WALL, OUT},
     &materials[WHITE]}, /* the ceiling */
    /* -X, with two windows: below, above, and three piers */
    {{-OUT, 0, -5}, {-5, 1, 5}, &materials[RED]},
    {{-OUT, 3, -5}, {-5, 4, 5}, &materials[RED]},
    {{-OUT, 1, -5}, {-5, 3, -3.8}, &materials[RED]},
    {{-OUT, 1, -1.2}, {-5, 3, 1.2}, &materials[RED]},
    {{-OUT, 1, 3.8}, {-5, 3, 5}, &materials[RED]},
    {{5, 0, -5}, {OUT, 4, 5}, &materials[GREEN]},      /* +X */
    {{-OUT, 0, -OUT}, {OUT, 4, -5}, &materials[BLUE]}, /* -Z */
    /* +Z, with two windows */
    {{-OUT, 0, 5}, {OUT, 1, OUT}, &materials[YELLOW]},
    {{-OUT, 3, 5}, {OUT, 4, OUT}, &materials[YELLOW]},
    {{-OUT, 1, 5}, {-3.8, 3, OUT}, &materials[YELLOW]},
    {{-1.2, 1, 5}, {1.2, 3, OUT}, &materials[YELLOW]},
    {{3.8, 1, 5}, {OUT, 3, OUT}, &materials[YELLOW]},
    /* pillars */
    {{-2.8, 0, -2.8}, {-2.2, 4, -2.2}, &materials[STONE]},
    {{2.2, 0, -2.8}, {2.8, 4, -2.2}, &materials[STONE]},
    {{-2.8, 0, 2.2}, {-2.2, 4, 2.8}, &materials[STONE]},
    {{2.2, 0, 2.2}, {2.8, 4, 2.8}, &materials[STONE]},
    {{3, 0, -5}, {3.15, 4, -2.9}, &materials[WHITE]}, /* a wall in a corner */
    /* panels */
    {{4.95, 0.8, -3.6}, {5, 3.2, -2}, &materials[ORANGE_LAMP]},
    {{4.95, 0.8, 1}, {5, 3.2, 2.6}, &materials[CYAN_LAMP]},
    {{-4, 1.2, -5}, {-1, 2.8, -4.95}, &materials[WARM_LAMP]},
    {{1.4, 0.6, -5}, {2, 3.4, -4.95}, &materials[PINK_LAMP]},
    {{-1.5, 3.95, -3.4}, {1.5, 4, -3}, &materials[CEILING_LAMP]},
    {{-1.5, 3.95, 3}, {1.5, 4, 3.4}, &materials[CEILING_LAMP]},
};

const view_room_box *view_room_box_at(int i)
{
    return &boxes[i];
}

/* Each swings along every axis as an independent sine. Phase is in turns. */
static const struct {
    double radius, middle[3], reach[3], seconds[3], phase[3];
} spheres[VIEW_ROOM_SPHERES] = {
    {.radius = 0.6, .middle = {0, 0.9, 0}, .seconds = {1, 1, 1}},
    {.radius = 0.22,
     .middle = {0, 1.1, 0},
     .reach = {1.8, 0.5, 1.8},
     .seconds = {8, 5, 8},
     .phase = {0.25, 0, 0}},
    {.radius = 0.45,
     .middle = {0, 0.45, 3.7},
     .reach = {3.6, 0, 0},
     .seconds = {11, 1, 1}},
    {.radius = 0.5,
     .middle = {-3.7, 1.2, 0},
     .reach = {0, 0.7, 2.4},
     .seconds = {1, 3, 13},
     .phase = {0, 0, 0.25}},
};

void view_room_sphere(int i, double seconds, double centre[3], double *radius)
{
    const double turn = 2 * M_PI;

    for (int k = 0; k < 3; k++) {
        const double turns =
            seconds / spheres[i].seconds[k] + spheres[i].phase[k];
        centre[k] =
            spheres[i].middle[k] + spheres[i].reach[k] * sin(turn * turns);
    }
    *radius = spheres[i].radius;
}

bool view_room_sphere_moves(int i)
{
    const double *reach = spheres[i].reach;

    return reach[0] != 0 || reach[1] != 0 || reach[2] != 0;
}

const view_room_material *view_room_sphere_material(int i)
{
    return &materials[SPHERE_MATERIALS + i];
}

/* Whether a draw shows a sphere. */
static bool has_sphere(const view_room_draw *d, int i)
{
    return view_room_sphere_moves(i) ? d->moving : d->mirror;
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
        const uint32_t first = p->vertex_count, row = (uint32_t)columns + 1;
        const size_t count = first + row * ((size_t)rows + 1);
        p->position = ibl_need(realloc(p->position, 12 * count));
        p->normal = ibl_need(realloc(p->normal, 12 * count));
        p->index = ibl_need(realloc(
            p->index, 4 * (p->index_count + (size_t)6 * columns * rows)));
        for (int k = 0; k < (int)row * (rows + 1); k++) {
            float *at = p->position + (size_t)3 * p->vertex_count;
            float *normal = p->normal + (size_t)3 * p->vertex_count++;
            const double x = (double)(k % (int)row) / columns;
            const double y = (double)(k / (int)row) / rows;
            double place[3] = {0}, out[3] = {0};
            place[axis] = (far ? high : low)[axis];
            place[u] = low[u] + (high[u] - low[u]) * x;
            place[v] = low[v] + (high[v] - low[v]) * y;
            out[axis] = far ? 1 : -1;
            if (round)
                normalise3(place);
            for (int j = 0; j < 3; j++) {
                at[j] = (float)place[j];
                normal[j] = (float)(round ? place : out)[j];
            }
        }
        for (int k = 0; k < columns * rows; k++) {
            const uint32_t a =
                first + (uint32_t)(k / columns) * row + (uint32_t)(k % columns);
            const uint32_t corners[6] = {a, a + 1,       a + row + 1,
                                         a, a + row + 1, a + row};
            memcpy(p->index + p->index_count, corners, sizeof corners);
            p->index_count += 6;
        }
    }
}

static ibl_scene_material material_of(const view_room_material *from)
{
    const bool metal = from->f0[0] > 0.1f, lamp = from->f0[0] <= 0;
    const float r = sqrtf(metal ? 0 : from->f0[0]);
    ibl_scene_material m = ibl_scene_material_default();

    memcpy(m.base_colour, metal ? from->f0 : from->albedo, sizeof from->f0);
    memcpy(m.emissive, from->emission, sizeof m.emissive);
    m.metallic = metal;
    m.roughness = from->roughness;
    m.ior = (1 + r) / (1 - r);
    m.specular = !lamp;
    return m;
}

/* A draw for each material: those of boxes, then the spheres. */
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

    for (int i = 0; i < VIEW_ROOM_BOXES; i++)
        add_box(&primitive[boxes[i].material - materials], boxes[i].low,
                boxes[i].high, box_cell, false);
    for (int i = 0; i < MATERIALS; i++) {
        if (i >= SPHERE_MATERIALS)
            add_box(&primitive[i], minus, one, sphere_cell, true);
        material[i] = material_of(&materials[i]);
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

/* ---- rays and weights --------------------------------------------------- */

double view_room_cast(const view_room_draw *d, const double from[3],
                      const double direction[3])
{
    double nearest = INFINITY;

    for (int i = 0; i < VIEW_ROOM_BOXES; i++) {
        double enter = 0, leave = INFINITY;
        for (int k = 0; k < 3; k++) {
            const double way = direction[k] == 0 ? 1e-12 : direction[k];
            const double low = (boxes[i].low[k] - from[k]) / way;
            const double high = (boxes[i].high[k] - from[k]) / way;
            enter = fmax(enter, fmin(low, high));
            leave = fmin(leave, fmax(low, high));
        }
        if (enter > 0 && enter < leave)
            nearest = fmin(nearest, enter);
    }
    for (int i = 0; i < VIEW_ROOM_SPHERES; i++) {
        double to[3], radius;
        view_room_sphere(i, d->seconds, to, &radius);
        for (int k = 0; k < 3; k++)
            to[k] -= from[k];
        const double along = dot3(to, direction);
        const double half2 = along * along - dot3(to, to) + radius * radius;
        if (has_sphere(d, i) && half2 > 0 && along > sqrt(half2))
            nearest = fmin(nearest, along - sqrt(half2));
    }
    return nearest;
}

/* A local probe, or the dynamic one behind them, with the proxy that counts. */
static ibl_probe probe_of(const view_room_draw *d, int i)
{
    ibl_probe p = i < d->locals.count ? d->locals.probe[i] : *d->dynamic.probe;

    if (d->parallax == VIEW_PARALLAX_NONE)
        p.has_proxy = 0;
    if (d->parallax == VIEW_PARALLAX_SPHERE && p.proxy.shape == IBL_SHAPE_BOX) {
        p.proxy.shape = IBL_SHAPE_SPHERE;
        p.proxy.half[0] = sqrt(dot3(p.proxy.half, p.proxy.half));
    }
    return p;
}

/* How many locals are mixed because they are near; 0: by influence. */
static int nearest_of(const view_room_draw *d)
{
    return !d->locals.count || d->choice == VIEW_PROBES_BLEND ? 0
           : d->choice == VIEW_PROBES_NEAREST                 ? 1
                                                              : d->nearest;
}

/* Number of local probes that come before the dynamic one. */
static int dynamic_place(const view_room_draw *d)
{
    int before = 0, order[2] = {0};

    for (; before < d->locals.count && d->dynamic.count; before++) {
        const ibl_probe pair[2] = {d->locals.probe[before], *d->dynamic.probe};
        ibl_probes_order(pair, 2, order);
        if (order[0] == 1)
            break;
    }
    return nearest_of(d) && before ? d->locals.count : before;
}

/* Weights of the locals by the distances of the nearest, as in
 * shaders/room_light.glsl. */
static void weigh_nearest(const view_room_draw *d, const double point[3],
                          double *weights)
{
    const int count = d->locals.count;
    double away[IBL_MAX_PROBES], reach = 0, sum = 0;

    for (int i = 0; i < count; i++) {
        double off[3];
        for (int k = 0; k < 3; k++)
            off[k] = d->locals.probe[i].position[k] - point[k];
        away[i] = fmax(sqrt(dot3(off, off)), 1e-6);
    }
    for (int n = 0; n < nearest_of(d); n++) {
        double next = INFINITY;
        for (int i = 0; i < count; i++)
            next = away[i] > reach ? fmin(next, away[i]) : next;
        reach = next;
    }
    for (int i = 0; i < count; i++)
        sum += away[i] <= reach ? 1 / away[i] : 0;
    for (int i = 0; i < count; i++)
        weights[i] = away[i] <= reach ? 1 / away[i] / sum : 0;
}

void view_room_weights(const view_room_draw *d, const double point[3],
                       double *weights)
{
    const int count = d->locals.count, place = dynamic_place(d);
    double left = 1, scale = 1;

    weights[count] =
        d->dynamic.count ? ibl_probe_influence(d->dynamic.probe, point) : 0;
    if (nearest_of(d)) {
        weigh_nearest(d, point, weights);
        scale = place ? 1 : 1 - weights[count];
    } else {
        for (int i = 0; i < count; i++)
            weights[i] = ibl_probe_influence(&d->locals.probe[i], point);
    }
    for (int n = 0; n <= count; n++) {
        const int i = n < place ? n : n == place ? count : n - 1;
        weights[i] = fmin(weights[i] * (i < count ? scale : 1), left);
        left -= weights[i];
    }
    weights[count + 1] = left;
}

void view_room_hue(const view_room_draw *d, int probe, float rgb[3])
{
    for (int k = 0; k < 3; k++) {
        const double turn = 0.618033988749895 * probe + (3 - k) % 3 / 3.0;
        const double wave = fabs(6 * (turn - floor(turn)) - 3) - 1;
        rgb[k] = probe < 0 ? 0.2F : (float)fmin(fmax(wave, 0), 1);
        if (probe == d->locals.count)
            rgb[k] = 1;
    }
}

/* ---- drawing ------------------------------------------------------------ */

enum {
    FLOATS = (IBL_MAX_PROBES + 1) * IBL_PROBE_FLOATS,
    /* Boxes that hide lights; the floor is one. */
    HIDING = VIEW_ROOM_BOXES - VIEW_ROOM_TILES + 1
};

/* Uniform block "Room" (shaders/room.glsl), std140. */
typedef struct room_block {
    int order[4];  /* locals before the dynamic probe, locals, nearest_of, 1:
                      weights are drawn */
    int hiding[4]; /* boxes and spheres that hide lights, 1 with the dynamic
                      probe, 1: a paraboloid */
    float boxes[2 * HIDING][4];          /* low and high of each */
    float spheres[VIEW_ROOM_SPHERES][4]; /* centre, radius */
    float local_lod[4], dynamic_lod[4];  /* as view_frame.lod */
    float scales[4];                     /* irradiance: locals, dynamic one */
} room_block;

struct view_room {
    view_model *model;
    GLuint sky;            /* a program */
    GLuint frame, block;   /* buffers of uniforms */
    GLuint probes, texels; /* packed probes, and their buffer texture */
    GLuint none;           /* array of one black cube */
};

view_room *view_room_create(void)
{
    static const float black[4 * IBL_FACES];
    view_room *r = ibl_need(calloc(1, sizeof *r));

    r->sky = view_program("", "full.vert", "room.frag");
    if (!r->sky || !(r->model = make_model()))
        goto fail;
    r->frame = view_gl_buffer(GL_UNIFORM_BUFFER, sizeof(view_frame), NULL);
    r->block = view_gl_buffer(GL_UNIFORM_BUFFER, sizeof(room_block), NULL);
    r->probes = view_gl_buffer(GL_TEXTURE_BUFFER, FLOATS * sizeof(float), NULL);
    gl.GenTextures(1, &r->texels);
    view_gl_bind(VIEW_ROOM_UNIT_BUFFER, GL_TEXTURE_BUFFER, r->texels);
    gl.TexBuffer(GL_TEXTURE_BUFFER, GL_RGBA32F, r->probes);
    gl.GenTextures(1, &r->none);
    view_gl_bind(VIEW_ROOM_UNIT_LOCALS, GL_TEXTURE_CUBE_MAP_ARRAY, r->none);
    view_gl_filter(GL_TEXTURE_CUBE_MAP_ARRAY, GL_LINEAR, 1);
    gl.TexImage3D(GL_TEXTURE_CUBE_MAP_ARRAY, 0, GL_RGBA16F, 1, 1, IBL_FACES, 0,
                  GL_RGBA, GL_FLOAT, black);
    return r;
fail:
    view_room_free(r);
    return NULL;
}

void view_room_free(view_room *r)
{
    if (r)
        view_model_free(r->model);
    free(r);
}

/* Returns whether the picture is mirrored. */
static bool fill_frame(view_frame *f, const view_room_draw *d, int width,
                       int height)
{
    const view_camera *c = &d->camera;
    const double turn = d->environment.turn * (M_PI / 180);
    const double *axes[3] = {c->right, c->up, c->forward};
    double right_up[3];

    *f = d->environment.frame;
    view_frame_camera(f, c, width, height);
    /* As shaders/paraboloid.glsl has it, distances in units of far. */
    for (int i = 0; i < 16 && d->paraboloid; i++) {
        const double *axis = axes[i % 4 % 3];
        f->clip[i] =
            (float)(i % 4 == 3 ? (i == 15 ? c->near : 0) / c->far
                               : (i < 12 ? axis[i / 4] : -dot3(axis, c->eye)) /
                                     c->far);
    }
    f->turn[0] = (float)cos(turn);
    f->turn[1] = (float)sin(turn);
    f->shading[2] = d->map ? VIEW_BACKDROP_MAP : VIEW_BACKDROP_CUBE;
    cross3(c->right, c->up, right_up);
    return dot3(right_up, c->forward) > 0;
}

static void fill_lod(float lod[4], const view_probe_maps *m)
{
    lod[0] = m->lod_scale;
    lod[1] = m->lod_offset;
    lod[2] = m->last_level;
    lod[3] = m->filament;
}

static room_block block_of(const view_room_draw *d)
{
    room_block b = {
        .order = {dynamic_place(d), d->locals.count, nearest_of(d), d->weights},
        .hiding = {d->shadows ? HIDING : 0, 0, d->dynamic.count, d->paraboloid},
        .scales = {d->locals.irradiance_scale, d->dynamic.irradiance_scale}};

    for (int i = 0; i < HIDING; i++)
        for (int k = 0; k < 3; k++) {
            const int box = VIEW_ROOM_TILES - 1 + i;
            b.boxes[2 * i][k] = (float)boxes[i ? box : 0].low[k];
            b.boxes[2 * i + 1][k] = (float)boxes[box].high[k];
        }
    for (int i = 0; i < VIEW_ROOM_SPHERES && d->shadows; i++) {
        float *sphere = b.spheres[b.hiding[1]];
        double centre[3], radius;
        view_room_sphere(i, d->seconds, centre, &radius);
        for (int k = 0; k < 3; k++)
            sphere[k] = (float)centre[k];
        sphere[3] = (float)radius;
        b.hiding[1] += has_sphere(d, i);
    }
    fill_lod(b.local_lod, &d->locals);
    fill_lod(b.dynamic_lod, &d->dynamic);
    return b;
}

static void upload_probes(const view_room *r, const view_room_draw *d)
{
    static const int first = 0;
    float packed[FLOATS] = {0};

    for (int i = 0; i < d->locals.count + d->dynamic.count; i++) {
        const ibl_probe probe = probe_of(d, i);
        ibl_probes_pack(&probe, 1, &first, packed + i * IBL_PROBE_FLOATS);
    }
    gl.BindBuffer(GL_TEXTURE_BUFFER, r->probes);
    gl.BufferSubData(GL_TEXTURE_BUFFER, 0, sizeof packed, packed);
}

/* Unused samplers get a black cube: drivers warn about empty ones, or recompile
 * once they are filled. */
static void bind_probes(const view_room *r, const view_probe_maps *m, int unit)
{
    const GLenum target = GL_TEXTURE_CUBE_MAP_ARRAY;

    view_gl_bind(unit, target, m->count ? m->specular : r->none);
    view_gl_bind(unit + 1, target, m->count ? m->irradiance : r->none);
}

bool view_room_render(view_room *r, const view_room_draw *d, view_image *to)
{
    const view_room_environment *e = &d->environment;
    const float eye[3] = {(float)d->camera.eye[0], (float)d->camera.eye[1],
                          (float)d->camera.eye[2]};
    const room_block block = block_of(d);
    view_frame frame;
    view_lighting light = d->light;

    light.probes = true;
    light.mirrored = fill_frame(&frame, d, to->width, to->height);
    if (d->weights)
        light.parts = VIEW_PARTS_ALL;
    gl.Disable(GL_BLEND);
    gl.BindBufferBase(GL_UNIFORM_BUFFER, VIEW_BLOCK_FRAME, r->frame);
    gl.BufferSubData(GL_UNIFORM_BUFFER, 0, sizeof frame, &frame);
    upload_probes(r, d);
    gl.BindBufferBase(GL_UNIFORM_BUFFER, VIEW_BLOCK_ROOM, r->block);
    gl.BufferSubData(GL_UNIFORM_BUFFER, 0, sizeof block, &block);
    view_gl_bind(VIEW_UNIT_SPECULAR, GL_TEXTURE_CUBE_MAP, e->specular);
    view_gl_bind(VIEW_UNIT_IRRADIANCE, GL_TEXTURE_CUBE_MAP, e->irradiance);
    view_gl_bind(VIEW_UNIT_SKY, GL_TEXTURE_CUBE_MAP, e->sky);
    view_gl_bind(VIEW_UNIT_LUT, GL_TEXTURE_2D, d->table);
    bind_probes(r, &d->dynamic, VIEW_ROOM_UNIT_DYNAMIC);
    bind_probes(r, &d->locals, VIEW_ROOM_UNIT_LOCALS);
    view_gl_bind(VIEW_ROOM_UNIT_BUFFER, GL_TEXTURE_BUFFER, r->texels);
    view_image_begin(to);
    gl.ClearColor(0, 0, 0, 0);
    if (d->bare)
        gl.Clear(GL_COLOR_BUFFER_BIT);
    if (d->paraboloid)
        gl.Enable(GL_CLIP_DISTANCE0);
    for (int i = 0; i < VIEW_ROOM_SPHERES; i++) {
        double centre[3], radius;
        view_room_sphere(i, d->seconds, centre, &radius);
        view_model_move(r->model, SPHERE_MATERIALS + i, centre,
                        has_sphere(d, i) ? radius : 0);
    }
    view_lighting own = light;
    own.override = false;
    const bool ok = view_model_draw(r->model, &own, eye) &&
                    (!d->guest || view_model_draw(d->guest, &light, eye));
    gl.Disable(GL_CLIP_DISTANCE0);
    gl.Enable(GL_DEPTH_TEST);
    gl.DepthFunc(GL_LEQUAL); /* the sky has the cleared depth */
    if (!d->bare)
        view_gl_draw_full(r->sky);
    gl.DepthFunc(GL_LESS);
    gl.Disable(GL_DEPTH_TEST);
    return ok;
}
