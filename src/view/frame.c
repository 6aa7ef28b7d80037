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
    const int terms = (set->sh_degree + 1) * (set->sh_degree + 1);

    f->lod[0] = (float)set->lod_scale;
    f->lod[1] = (float)set->lod_offset;
    f->lod[2] = (float)(set->texture[VIEW_SPECULAR].levels - 1);
    f->lod[3] = (float)set->mapping;
    f->diffuse[0] = (float)set->irradiance_scale;
    f->diffuse[1] = (float)set->geometry;
    for (int i = 0; i < terms; i++)
        copy3(f->sh[i], set->sh + 3 * i);
    for (int i = 0; i < set->light_count; i++) {
        copy3(f->disc_direction[i], set->light[i].direction);
        copy3(f->disc_irradiance[i], set->light[i].irradiance);
        f->disc_direction[i][3] = (float)set->light[i].radius;
    }
    f->reflection[2] = set->light_count;
    f->reflection[3] = set->texture[VIEW_SKY].data ? 0 : set->light_count;
}

/* By the harmonics, whose first is its mean, or else by the last level, which
 * has the same mean. */
static void fill_constant(view_frame *f, const baked_set *set)
{
    const ibl_texture *map = &set->texture[VIEW_SPECULAR];
    const int level = map->levels - 1, n = ibl_cube_edge(map->width, level);
    double sum[3] = {0};
    float texel[4];

    for (int k = 0; set->sh_degree >= 0 && k < 3; k++)
        sum[k] = set->sh[k] / sqrt(4 * M_PI);
    for (int i = 0; set->sh_degree < 0 && i < IBL_FACES * n * n; i++) {
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
        const int last = set->texture[VIEW_SPECULAR].levels - 1;
        const int level =
            s->background_level < last ? s->background_level : last;
        to[0] = (float)level;
        to[1] = (float)set->roughness[level];
    }
}

/* Chromium's F0: Real-Time Rendering, 4th edition, table 9.2. */
static void fill_override(view_frame *f, const view_settings *s)
{
    static const view_material chosen[] = {{{0.5, 0.5, 0.5}, 0.04, 1},
                                           {{0.55, 0.556, 0.554}, 0.04, 1}};
    view_material m = view_materials[s->material];
    double metallic = s->metallic[1];
    double roughness = 0.5 * (s->roughness[0] + s->roughness[1]);

    if (s->override == VIEW_CLAY || s->override == VIEW_CHROME) {
        m = chosen[s->override == VIEW_CHROME];
        metallic = s->override == VIEW_CHROME;
        roughness = s->override == VIEW_CHROME ? 0.05 : 0.6;
    }
    copy3(f->override_colour, m.metal);
    f->override_colour[3] = (float)roughness;
    for (int k = 0; k < 3; k++)
        f->override_f0[k] = (float)m.dielectric_f0;
    /* Those without a diffuse colour have the same F0 at both ends. */
    f->override_f0[3] = m.diffuse > 0 ? (float)metallic : 1;
}

view_diffuse view_diffuse_of(const view_settings *s, const baked_set *set)
{
    return s->diffuse == VIEW_DIFFUSE_AUTO ? set->diffuse : s->diffuse;
}

int view_lighting_key(const view_lighting *l)
{
    return (((int)l->reflection * VIEW_DIFFUSE_AUTO + (int)l->diffuse) *
                (VIEW_PARTS_COUNT + 1) +
            (int)l->parts) *
               4 +
           2 * l->rough_fresnel + l->override;
}

void view_lighting_define(int key, char *text, size_t size)
{
    const int parts = key / 4 % (VIEW_PARTS_COUNT + 1);
    const int rest = key / 4 / (VIEW_PARTS_COUNT + 1);
    const int reflection = rest / VIEW_DIFFUSE_AUTO;

    view_add(text, size,
             "#define REFLECTION %d\n#define DIFFUSE %d\n#define PARTS %d\n"
             "%s%s%s",
             reflection, rest % VIEW_DIFFUSE_AUTO, parts,
             reflection == VIEW_REFERENCE ? "#define INTEGRAL\n" : "",
             key & 2 ? "#define ROUGH_FRESNEL\n" : "",
             key & 1 ? "#define OVERRIDE\n" : "");
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
    f->turn[2] = (float)view_widening(s);
    f->turn[3] = (float)(1.0 / sqrt(view_places(s)));
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
    f->parts[3] = s->ground;
    if (s->parts == VIEW_PARTS_AMBIENT)
        fill_constant(f, set);
    fill_background(f, s, set);
    fill_override(f, s);
    f->shading[3] = set->texture[VIEW_SKY].levels > 1;
    f->choice[0] = (int)s->mode;
    f->choice[1] = (int)view_diffuse_of(s, set);
    f->choice[2] = (int)s->layout;
    f->choice[3] = s->level;
    f->reflection[0] = (int)s->reflection;
    f->inspect_at[0] = (float)s->zoom;
    f->inspect_at[1] = (float)s->pan[0];
    f->inspect_at[2] = (float)s->pan[1];
    f->inspect_at[3] = (float)s->rows;
    f->looks[0] = (int)s->channel;
    f->looks[1] = s->filter;
    f->looks[2] = s->background == VIEW_BACKGROUND_TRANSPARENT;
    f->display[0] = (float)exp2(s->ev);
    f->display[1] = (float)s->split;
    f->display[2] = (float)s->gain;
    f->show[0] = (int)s->tone;
    f->show[1] = s->false_colour;
    f->show[2] = (int)s->compare;
    f->show[3] = s->mode == VIEW_SPHERES ? s->columns : 0;
}
