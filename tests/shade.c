/* SPDX-License-Identifier: MIT */
#include "shade.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "truth.h"
#include "view.h"
#include "json/text.h"

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
    for (int i = 0; i < IBL_CONTENTS; i++)
        ibl_texture_free(&s->set.baked.file[i].texture);
    ibl_image_free(&s->set.map);
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
    ibl_set_file *f = s->set.baked.file;

    for (int i = 0; i < IBL_CONTENTS; i++)
        ibl_texture_free(&f[i].texture);
    need(!ibl_texture_from_cube(shade_ctx(), &s->specular, &as,
                                &f[IBL_CONTENT_SPECULAR].texture, NULL) &&
             !ibl_texture_from_cube(shade_ctx(), &s->irradiance, &as,
                                    &f[IBL_CONTENT_IRRADIANCE].texture, NULL) &&
             !ibl_texture_unblock(shade_ctx(),
                                  &f[IBL_CONTENT_SPECULAR].texture) &&
             !ibl_texture_unblock(shade_ctx(),
                                  &f[IBL_CONTENT_IRRADIANCE].texture) &&
             !ibl_texture_from_lut(shade_ctx(), &s->lut, lut,
                                   &f[IBL_CONTENT_LUT].texture, NULL),
         "textures");
}

static void begin_set(shade_set *s)
{
    static char name[] = "test";

    free_set(s);
    *s = (shade_set){.set.baked.name = name};
    s->set.baked.file[IBL_CONTENT_IRRADIANCE].facts.irradiance_scale = 1;
    need(!ibl_bake_lut(shade_ctx(), &(ibl_lut_options){.size = SHADE_TABLE},
                       &s->lut),
         "table");
}

static void end_set(shade_set *s)
{
    s->set.baked.file[IBL_CONTENT_SPECULAR].facts.lod_scale =
        s->specular.levels - 1;
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
    s->set.baked.file[IBL_CONTENT_SPECULAR].facts.mapping = opts->mapping;
    end_set(s);
}

void shade_kind(shade_set *s, ibl_roughness_map mapping, map_kind kind)
{
    ibl_specular_options opts = ibl_specular_options_default();
    test_random r = {5};
    const ibl_image map = map_of_kind(shade_ctx(), &r, kind, 128, 64);

    opts.size = 32;
    opts.mapping = mapping;
    shade_bake(s, &map, &opts);
}

/* ---- pictures ---------------------------------------------------------- */

bool shade_frame(const view_settings side[2])
{
    return view_renderer_draw(
        renderer, side, &(view_area){0, 0, picture_width, picture_height});
}

float *shade_read(int side)
{
    float *rgb =
        test_alloc((size_t)(picture_width * picture_height), 3 * sizeof *rgb);

    need(view_renderer_read(renderer, side, rgb), "no picture");
    return rgb;
}

float *shade_draw(const baked_set *set, const view_settings *s)
{
    need(view_renderer_load(renderer, set), "no set");
    for (int i = 0; i < view_places(s); i++)
        need(shade_frame(s), "no picture");
    return shade_read(0);
}

view_model *shade_ball(double height)
{
    enum {
        ROWS = 48,
        ACROSS = 2 * ROWS + 1 /* the seam has two columns of vertices */
    };
    static float position[(ROWS + 1) * ACROSS][3];
    static uint32_t index[6 * ROWS * 2 * ROWS];
    ibl_scene_material material = ibl_scene_material_default();
    ibl_scene_primitive primitive = {.vertex_count = (ROWS + 1) * ACROSS,
                                     .position = position[0],
                                     .normal = position[0],
                                     .index = index};
    ibl_scene_draw draw = {.to_world = {[0] = 1, [5] = 1, [10] = 1, [15] = 1}};
    ibl_scene scene = {.primitives = &primitive,
                       .materials = &material,
                       .draws = &draw,
                       .primitive_count = 1,
                       .material_count = 1,
                       .draw_count = 1,
                       .bounds = {{-1, -height, -1}, {1, height, 1}}};

    for (uint32_t i = 0; i < primitive.vertex_count; i++) {
        const double theta = M_PI * (i / ACROSS) / ROWS;
        const double phi = M_PI * (i % ACROSS) / ROWS;
        position[i][0] = (float)(sin(theta) * sin(phi));
        position[i][1] = (float)(height * cos(theta));
        position[i][2] = (float)(sin(theta) * cos(phi));
        for (int k = 0; k < 6 && i / ACROSS < ROWS && i % ACROSS + 1 < ACROSS;
             k++)
            index[primitive.index_count++] =
                i + (const uint32_t[]){0, ACROSS, 1, 1, ACROSS, ACROSS + 1}[k];
    }
    return view_model_create(NULL, &scene, "a ball");
}

int shade_material(const char *name)
{
    const int i = ibl_names_find(view_material_names, name);

    need(i >= 0, name);
    return i;
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
        view_test_ray(&c, w, h, x, y, ray);
        hit[i] = view_test_hit(spheres, count, c.eye, ray, normal);
        shade_pixel *p = in ? &all[y * w + x] : NULL;
        for (int k = 0; in && k < 3; k++) {
            p->normal[k] = normal[k];
            p->view[k] = -ray[k];
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

void shade_see(const ibl_cube *specular, const shade_lobe *q, const double n[3],
               const double v[3], const double light[3], double seen[3])
{
    double sum[3] = {0};

    for (int i = 0; i < q->taps; i++) {
        const double at = q->taps > 1 ? 2.0 * i / (q->taps - 1) - 1 : 0;
        const double bend = q->bend + at * q->half_distance;
        double d[3], rgb[3];
        for (int k = 0; k < 3; k++)
            d[k] =
                (1 - bend) * (2 * test_dot(n, v) * n[k] - v[k]) + bend * n[k];
        ibl_lookup_chain(specular, d, q->lod, rgb);
        for (int k = 0; k < 3; k++)
            sum[k] += rgb[k] / q->taps;
    }
    for (int k = 0; k < 3; k++)
        seen[k] = fmax(sum[k] + q->diffuse * (light[k] - sum[k]), 0);
}

double shade_level(const baked_set *set, double r)
{
    return (set->baked.file[IBL_CONTENT_SPECULAR].facts.mapping ==
                    IBL_ROUGHNESS_FILAMENT
                ? r * (2 - r)
                : r) *
               set->baked.file[IBL_CONTENT_SPECULAR].facts.lod_scale +
           set->baked.file[IBL_CONTENT_SPECULAR].facts.lod_offset;
}

void shade_irradiance(const shade_set *s, view_diffuse by, const double n[3],
                      double rgb[3])
{
    if (by == VIEW_DIFFUSE_LAST) {
        ibl_lookup_chain(&s->specular, n, s->specular.levels, rgb);
        return;
    }
    ibl_lookup_chain(&s->irradiance, n, 0, rgb);
    for (int k = 0; k < 3; k++)
        rgb[k] *= by == VIEW_DIFFUSE_SH
                      ? 0
                      : s->set.baked.file[IBL_CONTENT_IRRADIANCE]
                            .facts.irradiance_scale;
    for (int l = 0; l <= s->set.sh_degree && by == VIEW_DIFFUSE_SH; l++)
        for (int i = 3 * l * l; i < 3 * (l + 1) * (l + 1); i++)
            rgb[i % 3] += s->set.sh[i] * truth_sh(l, i / 3 - l * l - l, n);
    for (int k = 0; k < 3; k++)
        rgb[k] = fmax(rgb[k], 0);
}

void shade_look_up(const shade_set *s, const view_settings *settings,
                   const view_sphere *sphere, const shade_pixel *p,
                   shade_light *light)
{
    const shade_lobe lobe = {.taps = 1,
                             .lod = shade_level(&s->set, sphere->roughness)};
    double n[3], v[3];

    view_turn(settings->turn, p->normal, n);
    view_turn(settings->turn, p->view, v);
    ibl_lookup_lut(&s->lut, p->n_v, sphere->roughness, light->table);
    light->n_v = p->n_v;
    shade_irradiance(s, settings->diffuse, n, light->irradiance);
    shade_see(&s->specular, &lobe, n, v, light->irradiance, light->specular);
}

/* Karis 2013 and Fdez-Aguera 2019, written anew. */
void shade_split_sum(const view_settings *settings, const view_sphere *sphere,
                     const shade_light *light, double rgb[3])
{
    const double white = light->table[0] + light->table[1];
    const double smooth = 1 - sphere->roughness, grazing = 1 - light->n_v;

    for (int k = 0; k < 3; k++) {
        const double f0 = sphere->f0[k];
        const double once = f0 * light->table[0] + light->table[1];
        /* Each bounce after the first reflects the hemispherical mean of
         * Fresnel and loses the share 1 - white again: a geometric series. */
        const double mean = f0 + (1 - f0) / 21, lost = 1 - white;
        const double again =
            settings->multiscatter ? once * mean * lost / (1 - mean * lost) : 0;
        /* LearnOpenGL, after Lagarde 2011. */
        const double f = f0 + (fmax(smooth, f0) - f0) * pow(grazing, 5);
        rgb[k] =
            settings->rough_fresnel
                ? (f * light->table[0] + light->table[1]) * light->specular[k] +
                      (1 - f) * sphere->albedo[k] * light->irradiance[k]
                : once * light->specular[k] +
                      (again + sphere->albedo[k] * (1 - once - again)) *
                          light->irradiance[k];
    }
}
