/* SPDX-License-Identifier: MIT */
#include "shade.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "truth.h"
#include "view.h"

static view_renderer *renderer;
static ibl_ctx *ctx;
shade_set shade_sets[SHADE_SETS];
static int picture_width, picture_height;

static void need(bool ok, const char *what)
{
    if (!ok) {
        fprintf(stderr, "shade: %s\n", what);
        exit(1);
    }
}

static void free_set(shade_set *s)
{
    for (int i = 0; i < VIEW_CONTENTS; i++)
        ibl_texture_free(&s->set.texture[i]);
    ibl_cube_free(&s->specular);
    ibl_cube_free(&s->irradiance);
    ibl_lut_free(&s->lut);
    *s = (shade_set){0};
}

static void end(void *unused)
{
    (void)unused;
    for (int i = 0; i < SHADE_SETS; i++)
        free_set(&shade_sets[i]);
    view_renderer_free(renderer);
    ctx = NULL;
}

view_renderer *shade_begin(int width, int height)
{
    view_test_begin(width, height);
    test_defer(end, NULL);
    renderer = view_renderer_create();
    need(renderer, "no renderer");
    picture_width = width;
    picture_height = height;
    return renderer;
}

view_renderer *shade_renderer(void)
{
    return renderer;
}

ibl_ctx *shade_ctx(void)
{
    if (!ctx)
        ctx = test_ctx(1, IBL_ISA_AUTO);
    return ctx;
}

/* ---- sets -------------------------------------------------------------- */

void shade_pack(shade_set *s, ibl_pixel cubes, ibl_pixel lut)
{
    ibl_texture *t = s->set.texture;

    for (int i = 0; i < VIEW_CONTENTS; i++)
        ibl_texture_free(&t[i]);
    need(!ibl_texture_from_cube(
             shade_ctx(), &s->specular,
             &(ibl_texel_options){.struct_size = sizeof(ibl_texel_options),
                                  .pixel = cubes,
                                  .overflow = IBL_OVERFLOW_SPREAD},
             &t[VIEW_SPECULAR], NULL) &&
             !ibl_texture_from_cube(
                 shade_ctx(), &s->irradiance,
                 &(ibl_texel_options){.struct_size = sizeof(ibl_texel_options),
                                      .pixel = cubes,
                                      .overflow = IBL_OVERFLOW_SPREAD},
                 &t[VIEW_IRRADIANCE], NULL) &&
             !ibl_texture_unblock(shade_ctx(), &t[VIEW_SPECULAR]) &&
             !ibl_texture_unblock(shade_ctx(), &t[VIEW_IRRADIANCE]) &&
             !ibl_texture_from_lut(shade_ctx(), &s->lut, lut, &t[VIEW_LUT],
                                   NULL),
         "textures");
}

static void begin_set(shade_set *s)
{
    static char name[] = "test";

    free_set(s);
    *s = (shade_set){.set = {.name = name, .irradiance_scale = 1}};
    need(
        !ibl_bake_lut(shade_ctx(),
                      &(ibl_lut_options){.struct_size = sizeof(ibl_lut_options),
                                         .size = SHADE_TABLE},
                      &s->lut),
        "table");
}

static void end_set(shade_set *s)
{
    s->set.lod_scale = s->specular.levels - 1;
    shade_pack(s, IBL_PIXEL_RGBA32F, IBL_PIXEL_RG32F);
}

static void fill(const ibl_cube *cube, const float rgb[3])
{
    const size_t texels = ibl_cube_texels(cube->size, cube->levels);

    for (size_t i = 0; i < 3 * texels; i++)
        cube->data[i] = rgb[i % 3];
}

void shade_constant(shade_set *s, const float rgb[3])
{
    begin_set(s);
    need(!ibl_cube_alloc(shade_ctx(), 32, 4, &s->specular) &&
             !ibl_cube_alloc(shade_ctx(), 8, 1, &s->irradiance),
         "cubes");
    fill(&s->specular, rgb);
    fill(&s->irradiance, rgb);
    for (int k = 0; k < 3; k++)
        s->set.sh[k] = rgb[k] * sqrt(4 * acos(-1.0));
    end_set(s);
}

void shade_bake(shade_set *s, const ibl_image *map,
                const ibl_specular_options *opts)
{
    const ibl_irradiance_options diffuse = {
        .struct_size = sizeof diffuse, .size = 32, .yaw_deg = opts->yaw_deg};

    begin_set(s);
    need(!ibl_bake_specular(shade_ctx(), map, opts, &s->specular) &&
             !ibl_bake_irradiance(shade_ctx(), map, &diffuse, &s->irradiance) &&
             !ibl_bake_sh(shade_ctx(), map, VIEW_SH_DEGREE, opts->yaw_deg,
                          s->set.sh),
         "bake");
    s->set.sh_degree = VIEW_SH_DEGREE;
    for (int l = 0; l <= VIEW_SH_DEGREE; l++)
        for (int k = 3 * l * l; k < 3 * (l + 1) * (l + 1); k++)
            s->set.sh[k] *= ibl_sh_cosine(l);
    s->set.mapping = opts->mapping;
    end_set(s);
}

/* ---- pictures ---------------------------------------------------------- */

float *shade_draw(const baked_set *set, const view_settings *s)
{
    float *rgb =
        test_alloc((size_t)(picture_width * picture_height), 3 * sizeof *rgb);

    need(view_renderer_load(renderer, set) &&
             view_renderer_draw(renderer, s, picture_width, picture_height) &&
             view_renderer_read(renderer, false, rgb),
         "no picture");
    return rgb;
}

int shade_width(void)
{
    return picture_width;
}

int shade_height(void)
{
    return picture_height;
}

int shade_material(const char *name)
{
    for (int i = 0; i < VIEW_MATERIALS; i++)
        if (!strcmp(view_materials[i].name, name))
            return i;
    need(false, name);
    return 0;
}

shade_pixel *shade_pixels(const view_settings *s)
{
    const int w = picture_width, h = picture_height;
    const view_camera c = view_camera_of(s, w, h);
    static view_sphere spheres[VIEW_MAX_GRID * VIEW_MAX_GRID];
    const int count = view_grid(s, spheres);
    shade_pixel *all = test_alloc((size_t)(w * h), sizeof *all);
    int *hit = test_alloc((size_t)((w + 2) * (h + 2)), sizeof *hit);

    for (int i = 0; i < (w + 2) * (h + 2); i++) {
        const int x = i % (w + 2) - 1, y = i / (w + 2) - 1;
        const bool in = x >= 0 && y >= 0 && x < w && y < h;
        double ray[3], normal[3] = {0, 0, 0};
        view_camera_ray(&c, w, h, x, y, ray);
        hit[i] = view_grid_hit(spheres, count, c.eye, ray, normal);
        shade_pixel *p = in ? &all[y * w + x] : NULL;
        for (int k = 0; in && k < 3; k++) {
            p->normal[k] = normal[k];
            p->view[k] = -ray[k];
            p->reflected[k] = ray[k] - 2 * test_dot(ray, normal) * normal[k];
        }
        if (in)
            p->n_v = test_dot(p->normal, p->view);
    }
    for (int i = 0; i < w * h; i++) {
        const int *at = hit + (i / w + 1) * (w + 2) + i % w + 1;
        all[i].sphere = *at;
        for (int k = 0; k < 9; k++)
            if (at[(k / 3 - 1) * (w + 2) + k % 3 - 1] != *at)
                all[i].sphere = -2;
    }
    return all;
}

int shade_centre(const view_settings *s, const view_sphere *sphere)
{
    const int w = picture_width, h = picture_height;
    const view_camera c = view_camera_of(s, w, h);
    double m[16], clip[4];

    view_camera_matrix(&c, m);
    for (int i = 0; i < 4; i++)
        clip[i] = m[i] * sphere->centre[0] + m[4 + i] * sphere->centre[1] +
                  m[8 + i] * sphere->centre[2] + m[12 + i];
    return (int)((0.5 - 0.5 * clip[1] / clip[3]) * h) * w +
           (int)((0.5 + 0.5 * clip[0] / clip[3]) * w);
}

/* ---- lookups ----------------------------------------------------------- */

int shade_face(const double d[3], double *s, double *t)
{
    const double x = fabs(d[0]), y = fabs(d[1]), z = fabs(d[2]);

    if (x >= y && x >= z) {
        *s = (d[0] > 0 ? -d[2] : d[2]) / x;
        *t = -d[1] / x;
        return d[0] > 0 ? 0 : 1;
    }
    if (y >= z) {
        *s = d[0] / y;
        *t = (d[1] > 0 ? d[2] : -d[2]) / y;
        return d[1] > 0 ? 2 : 3;
    }
    *s = (d[2] > 0 ? d[0] : -d[0]) / z;
    *t = -d[1] / z;
    return d[2] > 0 ? 4 : 5;
}

static void texel(const ibl_cube *cube, int level, int face, int x, int y,
                  double rgb[3])
{
    const int n = ibl_cube_edge(cube->size, level);
    const float *px = ibl_cube_face(cube, level, face) + 3 * (y * n + x);

    for (int k = 0; k < 3; k++)
        rgb[k] = px[k];
}

/* A texel beyond an edge is the one behind it on the face that is there: the
 * place as far down the side as it was out. */
static void texel_beyond(const ibl_cube *cube, int level, int face, int x,
                         int y, double rgb[3])
{
    const int n = ibl_cube_edge(cube->size, level);
    const double in = 1 - 1.0 / n;
    double middle[3], right[3], down[3], d[3], s, t;
    double u = 2 * (x + 0.5) / n - 1, v = 2 * (y + 0.5) / n - 1, out = 1;

    truth_cube_direction(1, face, 0, 0, middle);
    truth_cube_direction(1, face, 0.5, 0, right);
    truth_cube_direction(1, face, 0, 0.5, down);
    if (fabs(u) > 1) {
        u = u > 0 ? 1 : -1;
        out = in;
    }
    if (fabs(v) > 1) {
        v = v > 0 ? 1 : -1;
        out = in;
    }
    for (int k = 0; k < 3; k++)
        d[k] = out * middle[k] + u * (right[k] * sqrt(2) - middle[k]) +
               v * (down[k] * sqrt(2) - middle[k]);
    const int other = shade_face(d, &s, &t);
    texel(cube, level, other, (int)floor((s + 1) / 2 * n),
          (int)floor((t + 1) / 2 * n), rgb);
}

static void tap(const ibl_cube *cube, int level, int face, int x, int y,
                double rgb[3])
{
    const int n = ibl_cube_edge(cube->size, level);
    const bool out_x = x < 0 || x >= n, out_y = y < 0 || y >= n;
    const int at_x = x < 0 ? 0 : n - 1, at_y = y < 0 ? 0 : n - 1;
    double three[3][3];

    if (!out_x && !out_y) {
        texel(cube, level, face, x, y, rgb);
    } else if (!out_x || !out_y) {
        texel_beyond(cube, level, face, x, y, rgb);
    } else {
        /* No texel is at a corner: the mean of the three around it. */
        texel(cube, level, face, at_x, at_y, three[0]);
        texel_beyond(cube, level, face, x, at_y, three[1]);
        texel_beyond(cube, level, face, at_x, y, three[2]);
        for (int k = 0; k < 3; k++)
            rgb[k] = (three[0][k] + three[1][k] + three[2][k]) / 3;
    }
}

static void bilinear(const ibl_cube *cube, int level, const double dir[3],
                     double rgb[3])
{
    const int n = ibl_cube_edge(cube->size, level);
    double s, t, four[4][3];
    const int face = shade_face(dir, &s, &t);
    const double x = (s + 1) / 2 * n - 0.5, y = (t + 1) / 2 * n - 0.5;
    const double fx = x - floor(x), fy = y - floor(y);

    for (int i = 0; i < 4; i++)
        tap(cube, level, face, (int)floor(x) + i % 2, (int)floor(y) + i / 2,
            four[i]);
    for (int k = 0; k < 3; k++)
        rgb[k] = (1 - fy) * ((1 - fx) * four[0][k] + fx * four[1][k]) +
                 fy * ((1 - fx) * four[2][k] + fx * four[3][k]);
}

void shade_cube(const ibl_cube *cube, double level, const double dir[3],
                double rgb[3])
{
    const int below = (int)fmin(floor(level), cube->levels - 1);
    const int above = below + 1 < cube->levels ? below + 1 : below;
    double a[3], b[3];

    bilinear(cube, below, dir, a);
    bilinear(cube, above, dir, b);
    for (int k = 0; k < 3; k++)
        rgb[k] = a[k] + (level - below) * (b[k] - a[k]);
}

static double clamp(double x, double low, double high)
{
    return fmin(fmax(x, low), high);
}

void shade_table(const ibl_lut *lut, double n_v, double roughness, double rg[2])
{
    const int n = lut->size, last = n - 1;
    const double x = clamp(n_v * n - 0.5, 0, last);
    const double y = clamp(roughness * n - 0.5, 0, last);
    const int i = (int)x, j = (int)y;
    const int i1 = i < last ? i + 1 : i, j1 = j < last ? j + 1 : j;

    for (int k = 0; k < 2; k++) {
        const float *d = lut->data + k;
        const double top =
            d[2 * (j * n + i)] * (1 - (x - i)) + d[2 * (j * n + i1)] * (x - i);
        const double bottom = d[2 * (j1 * n + i)] * (1 - (x - i)) +
                              d[2 * (j1 * n + i1)] * (x - i);
        rg[k] = top + (y - j) * (bottom - top);
    }
}

/* Turned by angle about +Y, clockwise seen from above. */
static void turn(double deg, const double from[3], double to[3])
{
    const double a = deg * acos(-1.0) / 180;

    to[0] = cos(a) * from[0] - sin(a) * from[2];
    to[1] = from[1];
    to[2] = sin(a) * from[0] + cos(a) * from[2];
}

/* x of ibl_specular_layout. */
static double mapped(const shade_set *s, double r)
{
    if (s->set.mapping == IBL_ROUGHNESS_BABYLON)
        return log2(fmax(r * r, 1e-12));
    return s->set.mapping == IBL_ROUGHNESS_FILAMENT ? r * (2 - r) : r;
}

void shade_look_up(const shade_set *s, const view_settings *settings,
                   const view_sphere *sphere, const shade_pixel *p,
                   shade_light *light)
{
    const double r = sphere->roughness;
    const double level =
        clamp(mapped(s, r) * s->set.lod_scale + s->set.lod_offset, 0,
              s->specular.levels - 1);
    double reflected[3], normal[3];

    turn(settings->turn, p->reflected, reflected);
    turn(settings->turn, p->normal, normal);
    shade_cube(&s->specular, level, reflected, light->specular);
    shade_table(&s->lut, p->n_v, r, light->table);
    shade_cube(&s->irradiance, 0, normal, light->irradiance);
    for (int k = 0; k < 3; k++) {
        light->irradiance[k] *= s->set.irradiance_scale;
        if (settings->diffuse == VIEW_DIFFUSE_MAP)
            continue;
        light->irradiance[k] = 0;
        for (int l = 0; l <= s->set.sh_degree; l++)
            for (int m = -l; m <= l; m++)
                light->irradiance[k] +=
                    s->set.sh[3 * (l * l + l + m) + k] * truth_sh(l, m, normal);
        light->irradiance[k] = fmax(light->irradiance[k], 0);
    }
}

/* Karis 2013 and Fdez-Aguera 2019, written anew. */
void shade_split_sum(const view_settings *settings, const view_sphere *sphere,
                     const shade_light *light, double rgb[3])
{
    const double white = light->table[0] + light->table[1];

    for (int k = 0; k < 3; k++) {
        const double f0 = sphere->f0[k];
        const double once = f0 * light->table[0] + light->table[1];
        /* Each bounce after the first reflects the hemispherical mean of
         * Fresnel and loses the share 1 - white again: a geometric series. */
        const double mean = f0 + (1 - f0) / 21, lost = 1 - white;
        const double again =
            settings->multiscatter ? once * mean * lost / (1 - mean * lost) : 0;
        rgb[k] = once * light->specular[k] +
                 (again + sphere->albedo[k] * (1 - once - again)) *
                     light->irradiance[k];
    }
}
