/* SPDX-License-Identifier: MIT */
#include <math.h>
#include <string.h>

#include "view/frame.h"
#include "view/message.h"

static void copy3(float to[4], const double from[3])
{
    for (int k = 0; k < 3; k++)
        to[k] = (float)from[k];
}

void view_frame_camera(view_frame *f, const view_camera *c, int width,
                       int height)
{
    double matrix[16];

    view_camera_matrix(c, matrix);
    for (int i = 0; i < 16; i++)
        f->clip[i] = (float)matrix[i];
    copy3(f->eye, c->eye);
    copy3(f->right, c->right);
    copy3(f->up, c->up);
    for (int k = 0; k < 3; k++)
        f->forward[k] = (float)(c->forward[k] + c->shift[0] * c->right[k] +
                                c->shift[1] * c->up[k]);
    f->viewport[0] = (float)width;
    f->viewport[1] = (float)height;
    f->viewport[2] = 1.0f / (float)width;
    f->viewport[3] = 1.0f / (float)height;
}

static void fill_set(view_frame *f, const baked_set *set)
{
    const ibl_set_file *file = set->baked.file;
    const ibl_set_file *chain = &file[IBL_CONTENT_SPECULAR];
    const int lights = set->baked.light_count;
    const int terms = (set->sh_degree + 1) * (set->sh_degree + 1);

    f->lod[0] = (float)chain->facts.lod_scale;
    f->lod[1] = (float)chain->facts.lod_offset;
    f->lod[2] = (float)(chain->texture.levels - 1);
    f->lod[3] = (float)chain->facts.mapping;
    f->diffuse[0] = (float)file[IBL_CONTENT_IRRADIANCE].facts.irradiance_scale;
    f->diffuse[1] = (float)file[IBL_CONTENT_LUT].facts.geometry;
    for (int i = 0; i < terms; i++)
        copy3(f->sh[i], set->sh + 3 * i);
    for (int i = 0; i < lights; i++) {
        copy3(f->disc_direction[i], set->baked.light[i].direction);
        copy3(f->disc_irradiance[i], set->baked.light[i].irradiance);
        f->disc_direction[i][3] = (float)set->baked.light[i].radius;
    }
    f->reflection[2] = lights;
    f->reflection[3] = file[IBL_CONTENT_SKYBOX].texture.data ? 0 : lights;
}

/* All levels have the same mean; this one has texels enough for it. */
static void fill_constant(view_frame *f, const baked_set *set)
{
    const ibl_texture *map = &set->baked.file[IBL_CONTENT_SPECULAR].texture;
    double sum[3] = {0};
    float texel[4];
    int level = 0;

    while (level + 1 < map->levels && ibl_cube_edge(map->width, level) > 32)
        level++;
    const int n = ibl_cube_edge(map->width, level);
    for (int i = 0; i < IBL_FACES * n * n; i++) {
        const int face = i / (n * n), at = i % (n * n);
        ibl_pixel_decode(map->pixel,
                         map->data + ibl_texture_offset(map, level, face) +
                             (size_t)at * ibl_pixel_bytes(map->pixel),
                         1, texel);
        for (int k = 0; k < 3; k++)
            sum[k] +=
                texel[k] * ibl_cube_solid_angle(n, at % n, at / n) / (4 * M_PI);
    }
    copy3(f->constant, sum);
}

static void fill_background(view_frame *f, const view_settings *s,
                            const baked_set *set)
{
    const view_background kind = s->background;
    const ibl_set_file *chain = &set->baked.file[IBL_CONTENT_SPECULAR];
    float *to = f->background;

    f->shading[2] =
        kind == VIEW_BACKGROUND_MAP ? VIEW_BACKDROP_CUBE
        : kind == VIEW_BACKGROUND_BLUR || kind == VIEW_BACKGROUND_LEVEL
            ? VIEW_BACKDROP_LEVEL
            : VIEW_BACKDROP_COLOUR;
    if (kind == VIEW_BACKGROUND_COLOUR) {
        copy3(to, s->background_colour);
        to[3] = 1;
    } else if (kind == VIEW_BACKGROUND_BLUR) {
        to[0] = -1;
        to[1] = (float)s->blur;
    } else if (kind == VIEW_BACKGROUND_LEVEL) {
        const int last = chain->texture.levels - 1;
        const int level =
            s->background_level < last ? s->background_level : last;
        to[0] = (float)level;
        to[1] = (float)chain->facts.roughness[level];
    }
}

/* Chromium's F0: Real-Time Rendering, 4th edition, table 9.2. */
static void fill_material(view_frame *f, const view_settings *s)
{
    static const struct {
        view_material material;
        float roughness, metallic;
    } overrides[] = {
        [VIEW_CLAY] = {{{0.5, 0.5, 0.5}, 0.04, 1}, 0.6F, 0},
        [VIEW_CHROME] = {{{0.55, 0.556, 0.554}, 0.04, 1}, 0.05F, 1}};
    const bool spheres = s->mode == VIEW_SPHERES;
    const bool fixed =
        !spheres && (s->override == VIEW_CLAY || s->override == VIEW_CHROME);
    const view_material *m =
        fixed ? &overrides[s->override].material : &view_materials[s->material];

    copy3(f->metal, m->metal);
    for (int k = 0; k < 3; k++)
        f->plastic[k] = (float)m->dielectric_f0;
    /* Those without a diffuse colour have the same F0 at both ends. */
    f->metal[3] = (float)(s->roughness[0] + s->roughness[1]) / 2;
    f->plastic[3] = m->diffuse > 0 ? (float)s->metallic[1] : 1;
    if (fixed) {
        f->metal[3] = overrides[s->override].roughness;
        f->plastic[3] = overrides[s->override].metallic;
    }
    for (int k = 0; k < 2; k++) {
        f->ranges[k] = (float)s->metallic[k];
        f->ranges[2 + k] = (float)s->roughness[k];
    }
    f->grid[0] = spheres ? s->columns : 0;
    f->grid[1] = s->rows;
    f->grid[2] = m->diffuse > 0;
}

view_diffuse view_diffuse_of(const view_settings *s, const baked_set *set)
{
    return s->diffuse == VIEW_DIFFUSE_AUTO ? set->diffuse : s->diffuse;
}

void view_lighting_define(const view_lighting *l, char *text, size_t size)
{
    view_add(text, size,
             "#define REFLECTION %d\n#define DIFFUSE %d\n#define PARTS %d\n"
             "%s%s%s%s",
             (int)l->reflection, (int)l->diffuse, (int)l->parts,
             l->reflection == VIEW_REFERENCE ? "#define INTEGRAL\n" : "",
             l->rough_fresnel ? "#define ROUGH_FRESNEL\n" : "",
             l->override ? "#define OVERRIDE\n" : "",
             l->probes ? "#define PROBES\n" : "");
}

void view_frame_fill(view_frame *f, const view_settings *s,
                     const baked_set *set, int width, int height)
{
    const view_camera camera = view_camera_of(s, width, height);
    const double turn = s->turn * (M_PI / 180);

    memset(f, 0, sizeof *f);
    view_frame_camera(f, &camera, width, height);
    f->turn[0] = (float)cos(turn);
    f->turn[1] = (float)sin(turn);
    f->turn[2] = (float)(1.0 / sqrt(view_places(s)));
    fill_set(f, set);
    for (int i = 0; i < s->light_count; i++) {
        copy3(f->light_position[i], s->light[i].position);
        f->light_position[i][3] = 1;
        copy3(f->light_intensity[i], s->light[i].intensity);
    }
    f->shading[0] = s->multiscatter;
    f->shading[1] = s->light_count;
    f->parts[0] = (int)s->parts;
    f->parts[1] = s->rough_fresnel;
    f->parts[2] = (int)s->override;
    f->parts[3] = s->ground && s->mode == VIEW_MODEL;
    if (s->parts == VIEW_PARTS_AMBIENT)
        fill_constant(f, set);
    fill_background(f, s, set);
    fill_material(f, s);
    f->shading[3] = set->baked.file[IBL_CONTENT_SKYBOX].texture.levels > 1;
    f->choice[0] = (int)s->mode;
    f->choice[1] = (int)view_diffuse_of(s, set);
    f->choice[2] = (int)s->layout;
    f->choice[3] = s->level;
    f->reflection[0] = (int)s->reflection;
    f->inspect_at[0] = (float)s->zoom;
    f->inspect_at[1] = (float)s->pan[0];
    f->inspect_at[2] = (float)s->pan[1];
    f->looks[0] = (int)s->channel;
    f->looks[1] = s->filter;
    f->looks[2] = s->background == VIEW_BACKGROUND_TRANSPARENT;
    f->display[0] = (float)exp2(s->ev);
    f->display[1] = (float)s->split;
    f->display[2] = (float)s->gain;
    f->show[0] = (int)s->tone;
    f->show[1] = s->false_colour;
    f->show[2] = (int)s->compare;
}
