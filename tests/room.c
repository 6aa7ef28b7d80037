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

static GLuint texture(GLenum target)
{
    GLuint t;

    gl.GenTextures(1, &t);
    view_gl_bind(0, target, t);
    view_gl_filter(target, GL_LINEAR, 1);
    return t;
}

/* All faces, one after the other. */
static float *fill_faces(int size, room_texel *texel, void *cookie)
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
    const GLuint cube = texture(GL_TEXTURE_CUBE_MAP);
    const float *texels = fill_faces(size, texel, cookie);

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

static GLuint table_of(float r, float g)
{
    const GLuint table = texture(GL_TEXTURE_2D);
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

void room_cube_read(GLuint cubes, const ibl_cube *cube)
{
    for (int l = 0; l < cube->levels; l++) {
        const int n = ibl_cube_edge(cube->size, l);
        const float *rgba = room_cubes_read(cubes, 1, l, n);
        for (int i = 0; i < IBL_FACES * n * n; i++)
            memcpy(ibl_cube_face(cube, l, 0) + (size_t)3 * i, rgba + 4 * i,
                   3 * sizeof *rgba);
    }
}

/* ---- pictures ---------------------------------------------------------- */

static void free_image(void *image)
{
    view_image_free(image);
}

static void make_image(view_image *image, int width, int height)
{
    test_defer(free_image, image);
    *image = (view_image){0};
    NEED(view_image_make(image, width, height));
}

static float *read_image(const view_image *image)
{
    const size_t row = 4 * (size_t)image->width;
    float *rgba = test_alloc(row * image->height, sizeof *rgba);

    gl.BindFramebuffer(GL_FRAMEBUFFER, image->framebuffer);
    gl.ReadPixels(0, 0, image->width, image->height, GL_RGBA, GL_FLOAT, rgba);
    view_picture_flip(rgba, row * sizeof *rgba, image->height);
    return rgba;
}

/* ---- the room in white light ------------------------------------------- */

lit_room lit;

static void sky_texel(void *cookie, const double direction[3], float rgba[4])
{
    (void)cookie;
    for (int k = 0; k < 3; k++)
        rgba[k] = (float)(0.5 + 0.5 * direction[k]);
    rgba[3] = 1;
}

static void lit_end(void *unused)
{
    (void)unused;
    CHECK(view_gl_check("drawing the room"));
    view_room_free(lit.room);
}

void lit_begin(int width, int height)
{
    view_test_begin(width, height);
    test_defer(lit_end, NULL);
    memset(&lit, 0, sizeof lit);
    lit.room = view_room_create();
    make_image(&lit.image, width, height);
    lit.black = room_cube_of(0, 0, 0, 1);
    const GLuint white = room_cube_of(1, 1, 1, 1);
    lit.draw = (view_room_draw){
        .settings = view_settings_default(),
        .camera = {.near = 0.05, .far = 40},
        .moving = true,
        .mirror = true,
        .table = table_of(1, 0),
        .environment = {.specular = white,
                        .irradiance = white,
                        .sky = room_cube(64, sky_texel, NULL),
                        .frame = {.diffuse = {1}, .turn = {1}}}};
    lit.draw.settings.reflection = VIEW_SPLIT_SUM;
    NEED(lit.room);
}

void lit_turn(double turn)
{
    lit.draw.environment.frame.turn[0] = (float)cos(turn * M_PI / 180);
    lit.draw.environment.frame.turn[1] = (float)sin(turn * M_PI / 180);
}

/* Layers of a cube array. */
static GLuint layers(int first, int count)
{
    const GLuint array = texture(GL_TEXTURE_CUBE_MAP_ARRAY);
    const int size = lit.directions ? 64 : 1, one = IBL_FACES * size * size;
    float *texels = test_alloc((size_t)one * count, 4 * sizeof *texels);

    for (int i = 0; i < one * count && !lit.directions; i++)
        memcpy(texels + 4 * (size_t)i, lit.colour[first + i / one],
               sizeof lit.colour[0]);
    gl.TexImage3D(GL_TEXTURE_CUBE_MAP_ARRAY, 0, GL_RGBA32F, size, size,
                  IBL_FACES * count, 0, GL_RGBA, GL_FLOAT,
                  lit.directions ? fill_faces(size, sky_texel, NULL) : texels);
    return array;
}

void lit_probes(const ibl_probe *probes, int count, bool dynamic)
{
    const int locals = dynamic ? count - 1 : count;
    view_probe_maps *to[2] = {&lit.draw.locals, &lit.draw.dynamic};

    for (int i = 0; i < 2; i++) {
        *to[i] = (view_probe_maps){.count = i ? count - locals : locals,
                                   .probe = probes + (i ? locals : 0),
                                   .irradiance_scale = 1};
        if (to[i]->count)
            to[i]->specular = to[i]->irradiance =
                layers(i ? locals : 0, to[i]->count);
    }
}

float *lit_render(void)
{
    NEED(view_room_render(lit.room, &lit.draw, &lit.image));
    return read_image(&lit.image);
}

/* In the colours of weights: hues by the golden ratio. */
static double hue(int probe, int k)
{
    static const double shift[3] = {0, 2.0 / 3, 1.0 / 3};
    const double turn = fmod((sqrt(5) - 1) / 2 * probe + shift[k], 1);

    return probe == lit.draw.locals.count
               ? 1
               : fmin(fmax(fabs(6 * turn - 3) - 1, 0), 1);
}

/* What a surface reflects of a probe: its specular and its matte light. */
static void colours_of(int i, const room_hit *h, const double ray[3],
                       double specular[3], double matte[3])
{
    const view_room_draw *d = &lit.draw;
    const double cosine = test_dot(ray, h->normal);
    ibl_probe p = i < d->locals.count ? d->locals.probe[i] : *d->dynamic.probe;
    double mirrored[3], lookup[3];

    for (int k = 0; k < 3; k++)
        mirrored[k] = ray[k] - 2 * cosine * h->normal[k];
    if (d->settings.parallax == VIEW_PARALLAX_NONE)
        p.has_proxy = 0;
    if (d->settings.parallax == VIEW_PARALLAX_SPHERE) {
        p.proxy.half[0] = sqrt(test_dot(p.proxy.half, p.proxy.half));
        p.proxy.shape = IBL_SHAPE_SPHERE;
    }
    ibl_probe_parallax(&p, h->point, mirrored, lookup);
    for (int k = 0; k < 3; k++) {
        const float *c = lit.colour[i];
        specular[k] = matte[k] = (double)c[k] / (double)c[3];
        if (lit.directions) {
            specular[k] = 0.5 + 0.5 * lookup[k];
            matte[k] = 0.5 + 0.5 * h->normal[k];
        }
        if (d->settings.weights)
            matte[k] = hue(i, k);
    }
}

static void shade(const room_hit *h, const double ray[3], double rgb[3])
{
    const view_room_draw *d = &lit.draw;
    const float *turn = d->environment.frame.turn;
    const double c = (double)turn[0], s = (double)turn[1];
    const double sky[3] = {c * ray[0] - s * ray[2], ray[1],
                           s * ray[0] + c * ray[2]};
    const int all = d->locals.count + d->dynamic.count;
    double alpha[MOST] = {0}, w[MOST + 1], seen[3], light[3];

    for (int i = 0; i < all; i++)
        alpha[i] = lit.directions ? 1 : (double)lit.colour[i][3];
    room_weights(d, h->point, alpha, w);
    for (int k = 0; k < 3; k++) {
        seen[k] = w[d->locals.count + 1];
        light[k] = seen[k] * (d->settings.weights ? 0.2 : 1);
    }
    for (int i = 0; i < all; i++) {
        double specular[3], matte[3];
        if (w[i] <= 0)
            continue;
        colours_of(i, h, ray, specular, matte);
        for (int k = 0; k < 3; k++) {
            seen[k] += w[i] * specular[k];
            light[k] += w[i] * matte[k];
        }
    }
    for (int k = 0; k < 3; k++)
        rgb[k] = h->what < 0 ? 0.5 + 0.5 * sky[k]
                 : d->settings.weights
                     ? light[k]
                     : h->f0[k] * seen[k] +
                           (1 - h->f0[k]) * h->albedo[k] * light[k] +
                           h->emission[k];
}

bool lit_shows(const float *rgb, int size, int face, double x, double y,
               double around, double tolerance)
{
    const view_camera *c = &lit.draw.camera;
    int first = -2;

    for (int i = 0; i < 9; i++) {
        const double at_x = x + around * ((i + 1) % 3 - 1);
        const double at_y = y + around * ((i + 4) / 3 % 3 - 1);
        double ray[3], truth[3], worst = 0;
        if (size)
            truth_cube_direction(size, face, at_x, at_y, ray);
        else
            view_test_ray(c, lit.image.width, lit.image.height, at_x, at_y,
                          ray);
        const room_hit h = room_cast(&lit.draw, c->eye, ray);
        /* The sky is a filtered texture, spheres are of triangles. */
        const double exact = h.what < 0                  ? 1e-3
                             : h.what >= VIEW_ROOM_BOXES ? 5 * tolerance
                                                         : tolerance;
        shade(&h, ray, truth);
        for (int k = 0; k < 3; k++)
            worst =
                fmax(worst, fabs((double)rgb[k] - truth[k]) / (1 + truth[k]));
        if (worst < fmax(exact, tolerance) || (i && h.what != first))
            return true;
        first = h.what;
    }
    return false;
}

/* ---- captures ---------------------------------------------------------- */

static void free_capture(void *capture)
{
    room_capture *c = capture;

    view_probe_maps_free(&c->cubes);
    view_capture_free(c->capture);
}

room_capture *room_capture_begin(view_probe_capture kind, int size,
                                 const double eye[3])
{
    room_capture *c = test_alloc(1, sizeof *c);

    c->capture = view_capture_create(kind, size);
    test_defer(free_capture, c);
    NEED(c->capture && view_probe_maps_make(&c->cubes, size, 1));
    memcpy(lit.draw.camera.eye, eye, sizeof lit.draw.camera.eye);
    return c;
}

void room_capture_update(room_capture *c)
{
    view_capture_update(c->capture, lit.room, &lit.draw, &c->cubes, 0);
}

/* The room is too far away to be seen. */
void room_capture_sky(room_capture *c, GLuint sky)
{
    lit.draw.camera.eye[1] = 1000;
    lit.draw.environment.sky = sky;
    room_capture_update(c);
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
                       .table = table_of(table[0], table[1])};
    on->s.mode = VIEW_SCENE;
    make_image(&on->image, width, height);
    on->stage = view_scene_create();
    NEED(on->stage);
    test_defer(free_scene, on->stage);
}

float *room_stage_draw(room_stage *on)
{
    on->anew = false;
    if (!view_scene_update(on->stage, &on->s, &on->environment, on->table,
                           on->guest, &on->anew) ||
        !view_scene_draw(on->stage, &on->s, &on->image))
        return NULL;
    return read_image(&on->image);
}
