/* SPDX-License-Identifier: MIT */
#include "view/report.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "common/process.h"
#include "common/signals.h"
#include "view/message.h"
#include "view/sphere_grid.h"

/* Prints - for spheres outside the picture. */
static void print_error(double rmse)
{
    if (rmse < 0)
        printf(" %7s", "-");
    else
        printf(" %7.4f", rmse);
}

static void print_grid(const view_settings *s, const view_error *errors)
{
    view_sphere spheres[VIEW_MAX_GRID * VIEW_MAX_GRID];

    view_grid(s, spheres);
    printf("metallic \\ roughness");
    for (int i = 0; i < s->columns; i++)
        printf(" %7.3f", spheres[i].roughness);
    putchar('\n');
    for (int row = s->rows - 1; row >= 0; row--) {
        printf("%20.3f", spheres[row * s->columns].metallic);
        for (int i = 0; i < s->columns; i++)
            print_error(view_error_rmse(errors[row * s->columns + i]));
        putchar('\n');
    }
}

static void print_material(const char *name, view_error e)
{
    char text[64];

    snprintf(text, sizeof text, "%s", name);
    ibl_one_line(text);
    printf("%9d", e.pixels);
    print_error(view_error_rmse(e));
    printf(" %s\n", text);
}

static void print_materials(const view_renderer *r, const view_error *errors,
                            int count)
{
    view_error all = {0};

    printf("   pixels   error material\n");
    for (int i = 0; i < count; i++) {
        if (errors[i].pixels)
            print_material(view_renderer_part(r, i), errors[i]);
        all.difference2 += errors[i].difference2;
        all.truth2 += errors[i].truth2;
        all.pixels += errors[i].pixels;
    }
    print_material("(all)", all);
}

bool view_report_print(view_renderer *r, const view_settings *s)
{
    char side[2][200];

    if (!view_compares(s))
        return false;
    view_error *errors =
        ibl_need(calloc((size_t)view_renderer_parts(r), sizeof *errors));
    const int count = view_renderer_errors(r, errors);
    if (!count) {
        free(errors);
        return false;
    }
    printf("relative RMSE of %s against %s",
           view_renderer_side(r, s, false, side[0], sizeof side[0]),
           view_renderer_side(r, s, true, side[1], sizeof side[1]));
    if (view_renderer_environment(r))
        printf(", %d samples a pixel of %s", view_renderer_samples(r),
               view_renderer_environment(r));
    putchar('\n');
    if (s->mode == VIEW_MODEL)
        print_materials(r, errors, count);
    else
        print_grid(s, errors);
    free(errors);
    fflush(stdout);
    return true;
}

void view_report_set(const baked_set *set)
{
    for (int i = 0; i < VIEW_CONTENTS; i++) {
        const ibl_texture *t = &set->texture[i];
        if (t->data)
            view_tell("%s: %s, %dx%d, levels: %d, %s", view_content_names[i],
                      set->path[i] ? set->path[i] : "made by the library",
                      t->width, t->height, t->levels,
                      ibl_pixel_name(set->path[i] ? set->pixel[i] : t->pixel));
    }
    fflush(stdout);
}

void view_report_probe_set(const view_probe_set *set, const char *path)
{
    const view_probe_maps *l = view_probe_set_locals(set);

    view_tell("probes: %s, %d, levels: %g", path, l->count,
              (double)l->last_level + 1);
    fflush(stdout);
}

void view_stats_add(view_stats *t, double ms)
{
    if (!t->frames)
        t->begun = ibl_now() - 1e-3 * ms;
    t->frames++;
    t->sum += ms;
    t->worst = fmax(t->worst, ms);
}

void view_stats_end(view_stats *t, const view_renderer *r,
                    const view_settings *s)
{
    const view_scene *stage = view_renderer_stage(r);

    if (s->mode == VIEW_SCENE) {
        const view_scene_state *state = view_scene_state_of(stage);
        const double *ms = state->ms;
        printf("probe seconds=%.3f size=%d capture=%s ms=%.1f drawing=%.1f "
               "levels=%.1f irradiance=%.1f",
               state->shown, s->probe_size,
               view_probe_capture_names[s->probe_capture],
               ms[0] + ms[1] + ms[2], ms[0], ms[1], ms[2]);
    } else {
        printf("view mode=%s", view_mode_names[s->mode]);
    }
    printf(" frames=%d frame=%.1f worst=%.1f\n", t->frames, t->sum / t->frames,
           t->worst);
    t->frames = 0;
    t->sum = t->worst = 0;
}

void view_stats_tell(view_stats *t, const view_renderer *r,
                     const view_settings *s)
{
    const view_scene *stage = view_renderer_stage(r);
    const int updates = stage ? view_scene_state_of(stage)->updates : 0;

    if (!t->frames || (s->mode == VIEW_SCENE ? updates == t->updates
                                             : ibl_now() - t->begun < 1))
        return;
    t->updates = updates;
    view_stats_end(t, r, s);
    fflush(stdout);
}
