/* SPDX-License-Identifier: MIT */
#include "view/inspect.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "view/frame.h"
#include "view/sphere_grid.h"

/* As in shaders/layout.glsl. */
#define ASIDE (1.0 / 32)

/* A map laid out flat in a window. */
typedef struct flat {
    const ibl_texture *map; /* NULL: the environment */
    const ibl_image *source;
    bool harmonics; /* in its place */
    int level;
    int edge;         /* of a face; 0: the map is flat */
    double size[2];   /* of the layout, in texels */
    double window[2]; /* in pixels */
    double scale;     /* pixels per texel */
} flat;

/* Uses floats where the shader does. */
static void fit(const view_settings *s, flat *f)
{
    f->scale = (float)s->zoom *
               fmin(f->window[0] / f->size[0], f->window[1] / f->size[1]);
}

static bool flatten(const baked_set *set, const view_settings *s, int width,
                    int height, flat *f)
{
    static const int faces[VIEW_LAYOUTS][2] = {{4, 3}, {6, 1}, {4, 2}};
    const bool matte = s->mode == VIEW_IRRADIANCE_MAP;
    const view_diffuse by = view_diffuse_of(s, set);
    const bool last = matte && by == VIEW_DIFFUSE_LAST;
    const ibl_content content = s->mode == VIEW_LEVELS || last
                                    ? IBL_CONTENT_SPECULAR
                                : matte ? IBL_CONTENT_IRRADIANCE
                                        : IBL_CONTENT_LUT;
    const ibl_texture *map = &set->baked.file[content].texture;

    *f = (flat){.window = {width, height}};
    if (view_is_lit(s))
        return false;
    if (s->mode == VIEW_SOURCE_MAP) {
        f->source = view_set_source(set, NULL);
        if (!f->source)
            return false;
        f->size[0] = f->source->width, f->size[1] = f->source->height;
        fit(s, f);
        return true;
    }
    f->harmonics = matte && by == VIEW_DIFFUSE_SH;
    if (!map->data && !f->harmonics)
        return false;
    f->map = map;
    f->size[0] = map->width, f->size[1] = map->height;
    if (content == IBL_CONTENT_SPECULAR)
        f->level = !last && s->level < map->levels ? s->level : map->levels - 1;
    if (content != IBL_CONTENT_LUT) {
        f->edge = f->harmonics ? VIEW_HARMONICS_EDGE
                               : ibl_cube_edge(map->width, f->level);
        for (int k = 0; k < 2; k++)
            f->size[k] = (double)faces[s->layout][k] * f->edge;
    }
    fit(s, f);
    return true;
}

/* The point of the layout, in texels, at a pixel of the window; pan is the
 * point in the middle. */
static void point(const flat *f, const view_settings *s, const double at[2],
                  double p[2])
{
    for (int k = 0; k < 2; k++)
        p[k] = f->size[k] * (0.5 + (float)s->pan[k]) +
               (at[k] - 0.5 * f->window[k]) / f->scale;
}

static int cross_face(int column, int row)
{
    static const int middle[4] = {1, 4, 0, 5};
    if (row == 1)
        return middle[column];
    return column != 1 ? -1 : row == 0 ? 2 : 3;
}

/* The texel of faces of edge x edge that a direction hits. */
static void hit(const double d[3], int edge, view_texel *t)
{
    const ibl_level_shape shape = ibl_level_shape_of(IBL_PROJECTION_CUBE, edge);
    int at[3];

    ibl_level_texel(&shape, d, at);
    t->face = at[0], t->x = at[1], t->y = at[2];
}

/* Row 0 is the zenith, the middle column is +X. */
static void unfold_equirect(const flat *f, const double p[2], view_texel *t)
{
    const double phi = 2 * M_PI * (p[0] / f->size[0] - 0.5);
    const double theta = M_PI * p[1] / f->size[1];
    const double d[3] = {sin(theta) * cos(phi), cos(theta),
                         sin(theta) * sin(phi)};
    hit(d, f->edge, t);
}

static void unfold_faces(const flat *f, view_layout layout, const double p[2],
                         view_texel *t)
{
    const int x = (int)p[0], y = (int)p[1];
    const int column = x / f->edge, row = y / f->edge;

    t->face = layout == VIEW_STRIP ? column : cross_face(column, row);
    t->x = x - column * f->edge;
    t->y = y - row * f->edge;
}

static void take(const ibl_texture *map, view_texel *t)
{
    const int face = t->face < 0 ? 0 : t->face;
    const int width =
        t->face < 0 ? map->width : ibl_cube_edge(map->width, t->level);
    const size_t at = (size_t)t->y * (size_t)width + (size_t)t->x;

    ibl_pixel_decode(map->pixel,
                     map->data + ibl_texture_offset(map, t->level, face) +
                         at * ibl_pixel_bytes(map->pixel),
                     1, t->value);
    if (t->face >= 0)
        ibl_cube_direction(width, t->face, t->x, t->y, t->direction);
}

static view_texel take_flat(const baked_set *set, const view_settings *s,
                            int width, int height, double x, double y)
{
    const double at[2] = {x + 0.5 + ASIDE, y + 0.5 + ASIDE};
    view_texel t = {.face = -1};
    double p[2];
    flat f;

    if (!flatten(set, s, width, height, &f))
        return t;
    point(&f, s, at, p);
    if (!(p[0] >= 0 && p[0] < f.size[0] && p[1] >= 0 && p[1] < f.size[1]))
        return t;
    t.level = f.level;
    if (f.source) {
        const int w = f.source->width;
        const double u = (floor(p[0]) + 0.5) / w - set->baked.yaw_deg / 360;
        const double phi = 2 * M_PI * (u - 0.5);
        const double theta = M_PI * (floor(p[1]) + 0.5) / f.size[1];
        t.x = (int)p[0], t.y = (int)p[1];
        t.direction[0] = sin(theta) * cos(phi);
        t.direction[1] = cos(theta);
        t.direction[2] = sin(theta) * sin(phi);
        memcpy(t.value,
               f.source->data + 3 * ((size_t)t.y * (size_t)w + (size_t)t.x),
               sizeof t.value);
        t.face = VIEW_FACE_SOURCE;
        t.inside = true;
        return t;
    }
    if (!f.edge) {
        t.x = (int)p[0];
        t.y = (int)fmin(f.size[1] - p[1], f.map->height - 1);
        t.direction[0] = (t.x + 0.5) / f.map->width;
        t.direction[1] = (t.y + 0.5) / f.map->height;
    } else if (s->layout == VIEW_EQUIRECT) {
        unfold_equirect(&f, p, &t);
    } else {
        unfold_faces(&f, s->layout, p, &t);
    }
    t.inside = !f.edge || t.face >= 0;
    if (t.inside && !f.harmonics)
        take(f.map, &t);
    if (t.inside && f.harmonics) {
        double sum[3];
        ibl_cube_direction(f.edge, t.face, t.x, t.y, t.direction);
        view_harmonics_sum(set->sh, (set->sh_degree + 1) * (set->sh_degree + 1),
                           3, t.direction, sum);
        for (int k = 0; k < 3; k++)
            t.value[k] = (float)fmax(sum[k], 0);
    }
    return t;
}

static view_texel take_sky(const baked_set *set, const view_settings *s,
                           int width, int height, double x, double y)
{
    const ibl_texture *map = &set->baked.file[IBL_CONTENT_SKYBOX].texture;
    const view_camera c = view_camera_of(s, width, height);
    view_sphere spheres[VIEW_MAX_GRID * VIEW_MAX_GRID];
    view_texel t = {.face = -1};
    double world[3], d[3];

    if (!map->data)
        map = &set->baked.file[IBL_CONTENT_SPECULAR].texture;
    view_camera_ray(&c, width, height, x, y, world);
    if (s->background != VIEW_BACKGROUND_MAP || !map->data ||
        !(x >= 0 && x < width && y >= 0) || y >= height ||
        view_grid_hit(spheres, view_grid(s, spheres), c.eye, world, NULL) >= 0)
        return t;
    view_turn(s->turn, world, d);
    hit(d, map->width, &t);
    t.inside = true;
    take(map, &t);
    return t;
}

view_texel view_inspect(const baked_set *set, const view_settings *s, int width,
                        int height, double x, double y)
{
    x = floor(x);
    y = floor(y);
    return s->mode == VIEW_SPHERES ? take_sky(set, s, width, height, x, y)
                                   : take_flat(set, s, width, height, x, y);
}

const char *const view_face_names[IBL_FACES] = {"+X", "-X", "+Y",
                                                "-Y", "+Z", "-Z"};

void view_texel_text(const view_texel *t, char *text, int size)
{
    const double *d = t->direction;

    if (!t->inside)
        snprintf(text, (size_t)size, "%s", "");
    else if (t->face == VIEW_FACE_SOURCE)
        snprintf(text, (size_t)size,
                 "(%d, %d)  dir %.3f %.3f %.3f  rgb %.4g %.4g %.4g", t->x, t->y,
                 d[0], d[1], d[2], (double)t->value[0], (double)t->value[1],
                 (double)t->value[2]);
    else if (t->face < 0)
        snprintf(text, (size_t)size,
                 "table  (%d, %d)  N.V %.4f roughness %.4f  R %.5g G %.5g",
                 t->x, t->y, d[0], d[1], (double)t->value[0],
                 (double)t->value[1]);
    else
        snprintf(text, (size_t)size,
                 "level %d  %s (%d, %d)  dir %.3f %.3f %.3f  rgb %.4g %.4g "
                 "%.4g",
                 t->level, view_face_names[t->face], t->x, t->y, d[0], d[1],
                 d[2], (double)t->value[0], (double)t->value[1],
                 (double)t->value[2]);
}

static void keep_pan(view_settings *s)
{
    for (int k = 0; k < 2; k++)
        s->pan[k] = fmin(fmax(s->pan[k], -0.5), 0.5);
}

void view_inspect_drag(const baked_set *set, view_settings *s, int width,
                       int height, double dx, double dy)
{
    flat f;

    if (!flatten(set, s, width, height, &f))
        return;
    s->pan[0] -= dx / (f.scale * f.size[0]);
    s->pan[1] -= dy / (f.scale * f.size[1]);
    keep_pan(s);
}

void view_inspect_zoom(const baked_set *set, view_settings *s, int width,
                       int height, double x, double y, double factor)
{
    const double at[2] = {x, y};
    double before[2], after[2];
    flat f;

    if (!flatten(set, s, width, height, &f))
        return;
    const double most = fmin(width, height) / 4 / f.scale * (float)s->zoom;
    point(&f, s, at, before);
    s->zoom = fmax(fmin(s->zoom * factor, fmax(most, 1)), 0.25);
    fit(s, &f);
    point(&f, s, at, after);
    for (int k = 0; k < 2; k++)
        s->pan[k] += (before[k] - after[k]) / f.size[k];
    keep_pan(s);
}
