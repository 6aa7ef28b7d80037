/* SPDX-License-Identifier: MIT */
#include <math.h>
#include <string.h>

#include "view/frame.h"

static void copy3(float to[4], const double from[3])
{
    for (int k = 0; k < 3; k++)
        to[k] = (float)from[k];
}

static void fill_camera(view_frame *f, const view_settings *s, int width,
                        int height)
{
    const view_camera c = view_camera_of(s, width, height);
    const double turn = s->turn * (M_PI / 180);
    double matrix[16];

    view_camera_matrix(&c, matrix);
    for (int i = 0; i < 16; i++)
        f->clip[i] = (float)matrix[i];
    copy3(f->eye, c.eye);
    copy3(f->right, c.right);
    copy3(f->up, c.up);
    copy3(f->forward, c.forward);
    for (int k = 0; k < 3; k++)
        f->forward[k] +=
            (float)(c.shift[0] * c.right[k] + c.shift[1] * c.up[k]);
    f->viewport[0] = (float)width;
    f->viewport[1] = (float)height;
    f->viewport[2] = 1.0f / (float)width;
    f->viewport[3] = 1.0f / (float)height;
    f->turn[0] = (float)cos(turn);
    f->turn[1] = (float)sin(turn);
    f->turn[2] = (float)view_widening(s);
    f->turn[3] = (float)(1.0 / sqrt(view_places(s)));
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

void view_frame_fill(view_frame *f, const view_settings *s,
                     const baked_set *set, int width, int height)
{
    memset(f, 0, sizeof *f);
    fill_camera(f, s, width, height);
    fill_set(f, set);
    for (int i = 0; i < s->light_count; i++) {
        copy3(f->light_position[i], s->light[i].position);
        f->light_position[i][3] = 1;
        copy3(f->light_intensity[i], s->light[i].intensity);
    }
    f->shading[0] = s->multiscatter;
    f->shading[1] = s->light_count;
    f->shading[2] = s->sky;
    f->diffuse[3] = (float)s->blur;
    f->shading[3] = set->texture[VIEW_SKY].levels > 1;
    f->choice[0] = (int)s->mode;
    f->choice[1] = (int)s->diffuse;
    f->choice[2] = (int)s->layout;
    f->choice[3] = s->mode == VIEW_LEVELS ? s->level : 0;
    f->reflection[0] = (int)s->reflection;
    f->reflection[1] = view_compares(s) ? (int)s->against : 0;
    f->inspect_at[0] = (float)s->zoom;
    f->inspect_at[1] = (float)s->pan[0];
    f->inspect_at[2] = (float)s->pan[1];
    f->inspect_at[3] = (float)s->rows;
    f->display[0] = (float)exp2(s->ev);
    f->display[1] = (float)s->split;
    f->display[2] = (float)s->gain;
    f->show[0] = (int)s->tone;
    f->show[1] = s->false_colour;
    f->show[2] = (int)s->compare;
    f->show[3] = s->mode == VIEW_SPHERES ? s->columns : 0;
}
