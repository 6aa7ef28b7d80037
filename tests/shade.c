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
    const ibl_texel_options as = {.pixel = cubes,
                                  .overflow = IBL_OVERFLOW_SPREAD};
    ibl_texture *t = s->set.texture;

    for (int i = 0; i < VIEW_CONTENTS; i++)
        ibl_texture_free(&t[i]);
    need(!ibl_texture_from_cube(shade_ctx(), &s->specular, &as,
                                &t[VIEW_SPECULAR], NULL) &&
             !ibl_texture_from_cube(shade_ctx(), &s->irradiance, &as,
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
    need(!ibl_bake_lut(shade_ctx(), &(ibl_lut_options){.size = SHADE_TABLE},
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
    const ibl_irradiance_options diffuse = {.size = 32,
                                            .yaw_deg = opts->yaw_deg};

    begin_set(s);
    need(!ibl_bake_specular(shade_ctx(), map, opts, &s->specular, NULL) &&
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

/* ---- lookups ----------------------------------------------------------- */

void shade_cube(const ibl_cube *cube, double level, const double dir[3],
                double rgb[3])
{
    ibl_lookup_chain(cube, dir, level, rgb);
}

void shade_look_up(const shade_set *s, const view_settings *settings,
                   const view_sphere *sphere, const shade_pixel *p,
                   shade_light *light)
{
    const double r = sphere->roughness;
    const double x = s->set.mapping == IBL_ROUGHNESS_FILAMENT ? r * (2 - r) : r;
    double reflected[3], normal[3];

    view_turn(settings->turn, p->reflected, reflected);
    view_turn(settings->turn, p->normal, normal);
    shade_cube(&s->specular, x * s->set.lod_scale + s->set.lod_offset,
               reflected, light->specular);
    ibl_lookup_lut(&s->lut, p->n_v, r, light->table);
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
