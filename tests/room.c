/* SPDX-License-Identifier: MIT */
#include "room.h"

#include <math.h>
#include <string.h>

#include "ibl/ibl.h"
#include "truth.h"
#include "view.h"
#include "view/gl.h"
#include "view/vector.h"

enum {
    MOST = IBL_MAX_PROBES + 1
};

/* ---- rays --------------------------------------------------------------- */

view_camera room_camera(const double eye[3], const double at[3], double fov,
                        int width, int height)
{
    view_camera c = {.near = 0.05, .far = 40};
    const double scale = tan(fov * acos(-1.0) / 360);

    for (int k = 0; k < 3; k++) {
        c.eye[k] = eye[k];
        c.forward[k] = at[k] - eye[k];
    }
    normalise3(c.forward);
    const bool upright = fabs(c.forward[1]) < 0.99;
    const double up[3] = {0, upright, !upright};
    cross3(c.forward, up, c.right);
    normalise3(c.right);
    cross3(c.right, c.forward, c.up);
    for (int k = 0; k < 3; k++) {
        c.right[k] *= scale * width / height;
        c.up[k] *= scale;
    }
    return c;
}

static void meet(room_hit *h, int what, double distance, int material)
{
    const ibl_scene_material *m = &view_room_materials[material];
    const double r = ((double)m->ior - 1) / ((double)m->ior + 1);

    h->what = what;
    h->distance = distance;
    h->roughness = (double)m->roughness;
    for (int k = 0; k < 3; k++) {
        const double base = (double)m->base_colour[k];
        h->f0[k] = m->metallic > 0 ? base : (double)m->specular * r * r;
        h->albedo[k] = m->metallic > 0 ? 0 : base;
        h->emission[k] = (double)m->emissive[k];
    }
}

room_hit room_cast(const view_room_draw *draw, const double eye[3],
                   const double direction[3])
{
    room_hit h = {.what = -1, .distance = INFINITY};

    for (int i = 0; i < VIEW_ROOM_BOXES; i++) {
        const view_room_box b = view_room_box_at(i);
        double enter = 0, leave = INFINITY;
        int axis = -1;
        for (int k = 0; k < 3; k++) {
            const double low = (b.low[k] - eye[k]) / direction[k];
            const double high = (b.high[k] - eye[k]) / direction[k];
            if (fmin(low, high) > enter) {
                enter = fmin(low, high);
                axis = k;
            }
            leave = fmin(leave, fmax(low, high));
        }
        if (axis < 0 || enter >= leave || enter >= h.distance)
            continue;
        meet(&h, i, enter, b.material);
        memset(h.normal, 0, sizeof h.normal);
        h.normal[axis] = direction[axis] < 0 ? 1 : -1;
    }
    for (int i = 0; i < VIEW_ROOM_SPHERES; i++) {
        const view_room_sphere s =
            view_room_sphere_at(i, draw->settings.seconds);
        double to[3];
        for (int k = 0; k < 3; k++)
            to[k] = s.centre[k] - eye[k];
        const double along = test_dot(to, direction);
        const double half2 =
            along * along - test_dot(to, to) + s.radius * s.radius;
        const double t = half2 > 0 ? along - sqrt(half2) : -1;
        if ((i && !draw->moving) || t <= 0 || t >= h.distance)
            continue;
        meet(&h, VIEW_ROOM_BOXES + i, t, i);
        for (int k = 0; k < 3; k++)
            h.normal[k] = (t * direction[k] - to[k]) / s.radius;
    }
    for (int k = 0; k < 3 && h.what >= 0; k++)
        h.point[k] = eye[k] + h.distance * direction[k];
    return h;
}

/* ---- weights ------------------------------------------------------------- */

/* Weights of count probes by the inverse distances of the nearest. */
static void weigh_nearest(const ibl_probe *probes, int count, int nearest,
                          const double point[3], double *weights)
{
    double away[MOST], sum = 0;
    bool taken[MOST] = {false};

    for (int i = 0; i < count; i++) {
        away[i] = 0;
        for (int k = 0; k < 3; k++)
            away[i] += pow(probes[i].position[k] - point[k], 2);
    }
    for (int n = 0; n < nearest && n < count; n++) {
        int next = -1;
        for (int i = 0; i < count; i++)
            if (!taken[i] && (next < 0 || away[i] < away[next]))
                next = i;
        taken[next] = true;
        sum += 1 / sqrt(away[next]);
    }
    for (int i = 0; i < count; i++)
        weights[i] = taken[i] ? 1 / sqrt(away[i]) / sum : 0;
}

void room_weights(const view_room_draw *d, const double point[3],
                  const double *alpha, double *weights)
{
    const int count = d->locals.count, all = count + d->dynamic.count;
    const bool near = count && d->settings.probe_choice != VIEW_PROBES_BLEND;
    static ibl_probe probes[MOST];
    int order[MOST];
    double left = 1, share = 1;

    for (int i = 0; i < all; i++) {
        probes[i] = i < count ? d->locals.probe[i] : *d->dynamic.probe;
        weights[i] = ibl_probe_influence(&probes[i], point);
        order[i] = i;
    }
    ibl_probes_order(probes, all, order);
    if (near)
        weigh_nearest(probes, count,
                      d->settings.probe_choice == VIEW_PROBES_NEAREST
                          ? 1
                          : d->settings.nearest,
                      point, weights);
    if (near && order[0] == count)
        share = 1 - weights[count] * (alpha ? alpha[count] : 1);
    for (int n = 0; n < all; n++) {
        const int i = near && order[0] != count ? n : order[n];
        if (near && i < count)
            weights[i] *= share;
        weights[i] = fmin(weights[i] * (alpha ? alpha[i] : 1), left);
        left -= weights[i];
    }
    if (!d->dynamic.count)
        weights[count] = 0;
    weights[count + 1] = left;
}

/* ---- maps -------------------------------------------------------------- */

GLuint room_texture(GLenum target)
{
    GLuint t;

    gl.GenTextures(1, &t);
    view_gl_bind(0, target, t);
    view_gl_filter(target, GL_LINEAR, 1);
    return t;
}

float *room_faces(int size, room_texel *texel, void *cookie)
{
    const int face = size * size;
    float *texels = test_alloc((size_t)IBL_FACES * face, 4 * sizeof *texels);

    for (int i = 0; i < IBL_FACES * face; i++) {
        double d[3];
        ibl_cube_direction(size, i / face, i % size, i % face / size, d);
        texel(cookie, d, texels + 4 * (size_t)i);
    }
    return texels;
}

GLuint room_cube(int size, room_texel *texel, void *cookie)
{
    const GLuint cube = room_texture(GL_TEXTURE_CUBE_MAP);
    const float *texels = room_faces(size, texel, cookie);

    for (int face = 0; face < IBL_FACES; face++)
        gl.TexImage2D(GL_TEXTURE_CUBE_MAP_POSITIVE_X + (GLenum)face, 0,
                      GL_RGBA32F, size, size, 0, GL_RGBA, GL_FLOAT,
                      texels + 4 * (size_t)(size * size * face));
    return cube;
}

static void same(void *cookie, const double direction[3], float rgba[4])
{
    (void)direction;
    memcpy(rgba, cookie, 4 * sizeof *rgba);
}

GLuint room_cube_of(float r, float g, float b, float a)
{
    float rgba[4] = {r, g, b, a};

    return room_cube(2, same, rgba);
}

GLuint room_table_of(float r, float g)
{
    const GLuint table = room_texture(GL_TEXTURE_2D);
    const float rg[2] = {r, g};

    gl.TexImage2D(GL_TEXTURE_2D, 0, GL_RG32F, 1, 1, 0, GL_RG, GL_FLOAT, rg);
    return table;
}

float *room_cubes_read(GLuint cubes, int count, int level, int n)
{
    const size_t floats = (size_t)4 * IBL_FACES * (size_t)(n * n);
    float *rgba = test_alloc(floats * (size_t)count, sizeof *rgba);

    view_gl_bind(0, GL_TEXTURE_CUBE_MAP_ARRAY, cubes);
    gl.GetTexImage(GL_TEXTURE_CUBE_MAP_ARRAY, level, GL_RGBA, GL_FLOAT, rgba);
    return rgba;
}

/* ---- pictures ---------------------------------------------------------- */

static void free_image(void *image)
{
    view_image_free(image);
}

void room_image_make(view_image *image, int width, int height)
{
    test_defer(free_image, image);
    *image = (view_image){0};
    NEED(view_image_make(image, width, height));
}

float *room_image_read(const view_image *image)
{
    const size_t row = 4 * (size_t)image->width;
    float *rgba = test_alloc(row * image->height, sizeof *rgba);

    gl.BindFramebuffer(GL_FRAMEBUFFER, image->framebuffer);
    gl.ReadPixels(0, 0, image->width, image->height, GL_RGBA, GL_FLOAT, rgba);
    view_picture_flip(rgba, row * sizeof *rgba, image->height);
    return rgba;
}

/* ---- the stage --------------------------------------------------------- */

static void free_scene(void *scene)
{
    view_scene_free(scene);
}

void room_stage_begin(room_stage *on, int width, int height,
                      const float light[3], const float table[2])
{
    view_test_begin(width, height);
    const GLuint all = room_cube_of(light[0], light[1], light[2], 1);
    *on = (room_stage){.s = view_settings_default(),
                       .environment = {.specular = all,
                                       .irradiance = all,
                                       .sky = all,
                                       .frame = {.diffuse = {1}, .turn = {1}}},
                       .table = room_table_of(table[0], table[1])};
    on->s.mode = VIEW_SCENE;
    room_image_make(&on->image, width, height);
    on->stage = view_scene_create();
    NEED(on->stage);
    test_defer(free_scene, on->stage);
}

float *room_stage_draw(room_stage *on)
{
    bool anew = false;

    if (!view_scene_update(on->stage, &on->s, &on->environment, on->table,
                           on->guest, &anew) ||
        !view_scene_draw(on->stage, &on->s, &on->image))
        return NULL;
    return room_image_read(&on->image);
}
