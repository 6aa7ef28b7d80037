/* SPDX-License-Identifier: MIT */
#include "view/report.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/process.h"
#include "common/signals.h"
#include "view/controls.h"
#include "view/message.h"
#include "view/sphere_grid.h"

/* Prints - for spheres outside the picture. */
static void print_error(view_error e)
{
    const double rmse = view_error_rmse(e);

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
            print_error(errors[row * s->columns + i]);
        putchar('\n');
    }
}

static view_error sum_of(const view_error *errors, int count)
{
    view_error all = {0};

    for (int i = 0; i < count; i++) {
        all.difference2 += errors[i].difference2;
        all.truth2 += errors[i].truth2;
        all.noise2 += errors[i].noise2;
        all.pixels += errors[i].pixels;
    }
    return all;
}

static void print_materials(const view_renderer *r, const view_error *errors,
                            int count)
{
    printf("   pixels   error material\n");
    for (int i = count > 1 ? 0 : count; i <= count; i++) {
        const view_error e = i < count ? errors[i] : sum_of(errors, count);
        char name[64];
        if (i < count && !e.pixels)
            continue;
        snprintf(name, sizeof name, "%s",
                 i < count ? view_renderer_part(r, i) : "(all)");
        ibl_one_line(name);
        printf("%9d", e.pixels);
        print_error(e);
        printf(" %s\n", name);
    }
}

void view_report_side(const view_settings *side, int i, const baked_set *set,
                      const baked_set *other, char *text, size_t size)
{
    const view_control *c;

    snprintf(text, size, "%.80s",
             other->baked.name ? (i ? other : set)->baked.name : "");
    for (int k = 0; (c = view_control_at(k)); k++) {
        char mine[80], its[80];
        if (!c->label || !(c->where & VIEW_OF_SIDE))
            continue;
        view_control_text(c, &side[i], mine);
        view_control_text(c, &side[!i], its);
        if (strcmp(mine, its) != 0)
            view_add(text, size, "%s%s %s", *text ? ", " : "", c->label, mine);
    }
}

/* NULL: nothing is compared; else to be freed. */
static view_error *errors_of(view_renderer *r, int *count)
{
    view_error *errors =
        ibl_need(calloc((size_t)view_renderer_parts(r), sizeof *errors));

    *count = view_renderer_errors(r, errors);
    if (*count)
        return errors;
    free(errors);
    return NULL;
}

void view_report_sum(view_renderer *r, char *text, size_t size)
{
    int count;
    view_error *errors = errors_of(r, &count);

    *text = '\0';
    if (errors) {
        const view_error all = sum_of(errors, count);
        const double noise = 100 * view_error_noise(all);
        snprintf(text, size, "RMSE %.2f %%", 100 * view_error_rmse(all));
        if (noise > 0)
            view_add(text, size, " (noise %.2g %%)", noise);
    }
    free(errors);
}

void view_report_print(view_renderer *r, const view_settings *s,
                       const char *const names[2])
{
    int count;
    view_error *errors = errors_of(r, &count);

    if (!errors)
        return;
    printf("relative RMSE of %s against %s", names[0], names[1]);
    if (view_renderer_environment(r))
        printf(", %d samples a pixel of %s", view_renderer_samples(r),
               view_renderer_environment(r));
    putchar('\n');
    if (s->mode == VIEW_SPHERES)
        print_grid(s, errors);
    else
        print_materials(r, errors, count);
    free(errors);
    fflush(stdout);
}

void view_report_set(const baked_set *set)
{
    for (int i = 0; i < IBL_CONTENTS; i++) {
        const ibl_set_file *f = &set->baked.file[i];
        const ibl_texture *t = &f->texture;
        if (t->data)
            view_tell("%s: %s, %dx%d, levels: %d, %s",
                      ibl_content_name((ibl_content)i),
                      f->path ? f->path : "made by the library", t->width,
                      t->height, t->levels,
                      ibl_pixel_name(f->path ? f->pixel : t->pixel));
    }
    fflush(stdout);
}

void view_report_probe_set(const view_probe_set *set, const char *path)
{
    view_tell("probes: %s, %d, levels: %d", path, set->index.count,
              set->index.specular.levels);
    fflush(stdout);
}

void view_stats_add(view_stats *t, double ms, double gpu)
{
    if (!t->frames)
        t->begun = ibl_now() - 1e-3 * ms;
    t->frames++;
    t->sum += ms;
    t->gpu += gpu;
    t->worst = fmax(t->worst, ms);
}

void view_stats_end(view_stats *t, const view_renderer *r,
                    const view_settings *s)
{
    const view_scene *stage = view_renderer_stage(r);

    if (s->mode == VIEW_SCENE) {
        printf("probe seconds=%.3f size=%d capture=%s ms=%.1f", stage->shown,
               s->probe_size, view_probe_capture_names[s->probe_capture],
               stage->ms);
    } else {
        printf("view mode=%s", view_mode_names[s->mode]);
    }
    printf(" frames=%d frame=%.1f worst=%.1f by=%s", t->frames,
           t->sum / t->frames, t->worst, view_screen_by());
    if (t->gpu > 0)
        printf(" gpu=%.1f", t->gpu / t->frames);
    putchar('\n');
    t->frames = 0;
    t->sum = t->worst = t->gpu = 0;
}

void view_stats_tell(view_stats *t, const view_renderer *r,
                     const view_settings *s)
{
    const view_scene *stage = view_renderer_stage(r);
    const int updates = stage ? stage->updates : 0;

    if (!t->frames || (s->mode == VIEW_SCENE ? updates == t->updates
                                             : ibl_now() - t->begun < 1))
        return;
    t->updates = updates;
    view_stats_end(t, r, s);
    fflush(stdout);
}
