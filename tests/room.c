/* SPDX-License-Identifier: MIT */
#include "room.h"

#include <math.h>
#include <string.h>

#include "ibl/ibl.h"
#include "view.h"
#include "view/gl.h"
#include "view/vector.h"

/* ---- targets ----------------------------------------------------------- */

static GLuint texture(GLenum target)
{
    GLuint t;

    gl.GenTextures(1, &t);
    gl.ActiveTexture(GL_TEXTURE0);
    gl.BindTexture(target, t);
    gl.TexParameteri(target, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
    gl.TexParameteri(target, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    gl.TexParameteri(target, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    gl.TexParameteri(target, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
    gl.TexParameteri(target, GL_TEXTURE_MAX_LEVEL, 0);
    return t;
}

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

/* ---- cameras ----------------------------------------------------------- */

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

view_room_draw room_draw_by(const view_camera *camera)
{
    return (view_room_draw){.camera = *camera,
                            .moving = true,
                            .mirror = true,
                            .shadows = true,
                            .parallax = VIEW_PARALLAX_BOX,
                            .environment.frame.diffuse = {1}};
}

/* ---- rays -------------------------------------------------------------- */

static bool cast_box(const view_room_box *b, const double eye[3],
                     const double d[3], room_hit *h)
{
    double enter = 0, leave = INFINITY;
    int axis = -1;

    for (int k = 0; k < 3; k++) {
        const double t0 = (b->low[k] - eye[k]) / d[k];
        const double t1 = (b->high[k] - eye[k]) / d[k];
        if (fmin(t0, t1) > enter) {
            enter = fmin(t0, t1);
            axis = k;
        }
        leave = fmin(leave, fmax(t0, t1));
    }
    if (axis < 0 || enter >= leave || enter >= h->distance)
        return false;
    h->distance = enter;
    memset(h->normal, 0, sizeof h->normal);
    h->normal[axis] = d[axis] < 0 ? 1 : -1;
    h->material = b->material;
    return true;
}

static bool cast_sphere(int i, double seconds, const double eye[3],
                        const double d[3], room_hit *h)
{
    double centre[3], radius, to[3];

    view_room_sphere(i, seconds, centre, &radius);
    for (int k = 0; k < 3; k++)
        to[k] = centre[k] - eye[k];
    const double along = test_dot(to, d);
    const double half2 = along * along - test_dot(to, to) + radius * radius;
    const double t = half2 > 0 ? along - sqrt(half2) : -1;
    if (t <= 0 || t >= h->distance)
        return false;
    h->distance = t;
    for (int k = 0; k < 3; k++)
        h->normal[k] = (t * d[k] - to[k]) / radius;
    h->material = view_room_sphere_material(i);
    return true;
}

room_hit room_cast(const view_room_draw *draw, const double eye[3],
                   const double direction[3])
{
    room_hit h = {.what = -1, .distance = INFINITY};

    for (int i = 0; i < VIEW_ROOM_BOXES; i++)
        if (cast_box(view_room_box_at(i), eye, direction, &h))
            h.what = i;
    for (int i = 0; i < VIEW_ROOM_SPHERES; i++)
        if ((draw->moving || !view_room_sphere_moves(i)) &&
            cast_sphere(i, draw->seconds, eye, direction, &h))
            h.what = VIEW_ROOM_BOXES + i;
    for (int k = 0; k < 3 && h.what >= 0; k++)
        h.point[k] = eye[k] + h.distance * direction[k];
    view_turn(draw->environment.turn, direction, h.sky);
    return h;
}

bool room_is_floor(const room_hit *h)
{
    return h->what >= 0 && h->what < VIEW_ROOM_BOXES && h->normal[1] > 0.5 &&
           fabs(h->point[1]) < 1e-9;
}

/* ---- maps -------------------------------------------------------------- */

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

    gl.TexParameteri(GL_TEXTURE_CUBE_MAP, GL_TEXTURE_WRAP_R, GL_CLAMP_TO_EDGE);
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

GLuint room_cubes_of(int count, const float (*rgba)[4])
{
    const GLuint array = texture(GL_TEXTURE_CUBE_MAP_ARRAY);
    float *texels = test_alloc((size_t)IBL_FACES * count, 4 * sizeof *texels);

    for (int i = 0; i < IBL_FACES * count; i++)
        memcpy(texels + 4 * (size_t)i, rgba[i / IBL_FACES], sizeof rgba[0]);
    gl.TexImage3D(GL_TEXTURE_CUBE_MAP_ARRAY, 0, GL_RGBA32F, 1, 1,
                  IBL_FACES * count, 0, GL_RGBA, GL_FLOAT, texels);
    return array;
}

GLuint room_layer(int size, room_texel *texel, void *cookie)
{
    const GLuint array = texture(GL_TEXTURE_CUBE_MAP_ARRAY);

    gl.TexImage3D(GL_TEXTURE_CUBE_MAP_ARRAY, 0, GL_RGBA32F, size, size,
                  IBL_FACES, 0, GL_RGBA, GL_FLOAT,
                  fill_faces(size, texel, cookie));
    return array;
}

GLuint room_layer_of(float r, float g, float b, float a)
{
    return room_cubes_of(1, &(const float[4]){r, g, b, a});
}

GLuint room_table_of(float r, float g)
{
    const GLuint table = texture(GL_TEXTURE_2D);
    const float rg[2] = {r, g};

    gl.TexImage2D(GL_TEXTURE_2D, 0, GL_RG32F, 1, 1, 0, GL_RG, GL_FLOAT, rg);
    return table;
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
    lit.room = view_room_create();
    room_image_make(&lit.image, width, height);
    lit.white = room_cube_of(1, 1, 1, 1);
    lit.black = room_cube_of(0, 0, 0, 1);
    lit.white_layer = room_layer_of(1, 1, 1, 1);
    lit.black_layer = room_layer_of(0, 0, 0, 1);
    lit.sky = room_cube(64, sky_texel, NULL);
    lit.table = room_table_of(1, 0);
    NEED(lit.room);
}

view_room_draw lit_draw(const view_camera *camera)
{
    view_room_draw d = room_draw_by(camera);

    d.environment.specular = d.environment.irradiance = lit.white;
    d.environment.sky = lit.sky;
    d.table = lit.table;
    return d;
}

float *lit_render(const view_room_draw *draw)
{
    NEED(view_room_render(lit.room, draw, &lit.image));
    return room_image_read(&lit.image);
}

static void material_colour(const room_hit *hit, double rgb[3])
{
    for (int k = 0; k < 3; k++) {
        if (hit->what < 0) {
            rgb[k] = 0.5 + 0.5 * hit->sky[k];
            continue;
        }
        const double f0 = (double)hit->material->f0[k];
        rgb[k] = f0 + (1 - f0) * (double)hit->material->albedo[k] +
                 (double)hit->material->emission[k];
    }
}

bool lit_has_colour(const float *pixel, const room_hit *hit, double tolerance)
{
    double rgb[3], most = 0;

    material_colour(hit, rgb);
    for (int k = 0; k < 3; k++)
        most = fmax(most, fabs((double)pixel[k] - rgb[k]) / (1 + rgb[k]));
    return most < (hit->what < 0 ? fmax(tolerance, 1e-3) : tolerance);
}

/* ---- captures ---------------------------------------------------------- */

static void free_capture(void *capture)
{
    room_capture *c = capture;

    view_cubes_free(&c->cubes);
    view_capture_free(c->capture);
}

room_capture *room_capture_begin(view_probe_capture kind, int size,
                                 const double eye[3])
{
    const view_camera any = {.near = 0.05, .far = 40};

    room_capture *c = test_alloc(1, sizeof *c);
    c->capture = view_capture_create(kind, size);
    test_defer(free_capture, c);
    NEED(c->capture && view_cubes_make(&c->cubes, size, 1));
    c->draw = lit_draw(&any);
    memcpy(c->draw.camera.eye, eye, sizeof c->draw.camera.eye);
    return c;
}

void room_capture_update(room_capture *c)
{
    view_capture_update(c->capture, lit.room, &c->draw, &c->cubes, 0);
}

/* The room is too far away to be seen. */
void room_capture_sky(room_capture *c, GLuint sky)
{
    c->draw.camera.eye[1] = 1000;
    c->draw.environment.sky = sky;
    room_capture_update(c);
}

float *room_cubes_read(GLuint cubes, int count, int level, int n)
{
    const size_t floats = (size_t)4 * IBL_FACES * (size_t)(n * n);
    float *rgba = test_alloc(floats * (size_t)count, sizeof *rgba);

    gl.ActiveTexture(GL_TEXTURE0);
    gl.BindTexture(GL_TEXTURE_CUBE_MAP_ARRAY, cubes);
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
                                       .frame.diffuse = {1}},
                       .table = room_table_of(table[0], table[1])};
    on->s.mode = VIEW_SCENE;
    room_image_make(&on->image, width, height);
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
    return room_image_read(&on->image);
}
