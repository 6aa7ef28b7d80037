/* SPDX-License-Identifier: MIT */
#include "view/report.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/process.h"
#include "common/signals.h"
#include "view/controls.h"
#include "view/gl.h"
#include "view/message.h"
#include "view/sphere_grid.h"

void view_report_side(const view_settings *side, int i, const baked_set *set,
                      const baked_set *other, char *text, size_t size)
{
    const view_control *c;

    snprintf(text, size, "%.80s",
             other->baked.name ? (i ? other : set)->baked.name : "");
    for (int k = 0; (c = view_control_at(k)); k++) {
        char mine[80], its[80];
        if (!c->label || !view_control_of_side(c))
            continue;
        view_control_text(c, &side[i], mine);
        view_control_text(c, &side[!i], its);
        if (strcmp(mine, its) != 0)
            view_add(text, size, "%s%s %s", *text ? ", " : "", c->label, mine);
    }
}

/* Errors of the parts and then their sum, to be freed; NULL: nothing is
 * compared. */
static view_error *errors_of(view_renderer *r, int *count)
{
    const size_t room = (size_t)view_renderer_parts(r) + 1;
    view_error *errors = ibl_need(calloc(room, sizeof *errors));

    *count = view_renderer_errors(r, errors);
    if (!*count) {
        free(errors);
        return NULL;
    }
    view_error all = {0};
    for (int i = 0; i < *count; i++) {
        all.difference2 += errors[i].difference2;
        all.truth2 += errors[i].truth2;
        all.noise2 += errors[i].noise2;
        all.pixels += errors[i].pixels;
    }
    errors[*count] = all;
    return errors;
}

void view_report_sum(view_renderer *r, char *text, size_t size)
{
    int count;
    view_error *errors = errors_of(r, &count);

    *text = '\0';
    if (errors) {
        const double noise = 100 * view_error_noise(errors[count]);
        snprintf(text, size, "RMSE %.2f %%",
                 100 * view_error_rmse(errors[count]));
        if (noise > 0)
            view_add(text, size, " (noise %.2g %%)", noise);
    }
    free(errors);
}

void view_report_print(view_renderer *r, const view_settings *s,
                       const baked_set *set, const baked_set *other)
{
    char sides[2][200];
    view_sphere spheres[VIEW_MAX_GRID * VIEW_MAX_GRID];
    int count;
    view_error *errors = errors_of(r, &count);

    if (!errors)
        return;
    view_grid(s, spheres);
    for (int i = 0; i < 2; i++)
        view_report_side(s, i, set, other, sides[i], sizeof sides[i]);
    printf("relative RMSE of %s against %s", sides[0], sides[1]);
    if (view_renderer_truth(r))
        printf(", %d samples a pixel of %s", view_renderer_samples(r),
               view_renderer_truth(r)->environment);
    printf("\n   pixels   error of\n");
    for (int i = 0; i <= count; i++) {
        char part[64] = "(all)";
        if (!errors[i].pixels || (count == 1 && i == 0))
            continue;
        if (i < count && s->mode == VIEW_SPHERES)
            snprintf(part, sizeof part, "metallic %.3f, roughness %.3f",
                     spheres[i].metallic, spheres[i].roughness);
        else if (i < count)
            snprintf(part, sizeof part, "%s", view_renderer_part(r, i));
        ibl_one_line(part);
        printf("%9d %7.4f %s\n", errors[i].pixels, view_error_rmse(errors[i]),
               part);
    }
    free(errors);
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

void view_stats_print(view_stats *t, const view_renderer *r,
                      const view_settings *s)
{
    printf("mode=%s frames=%d frame=%.1f worst=%.1f", view_mode_names[s->mode],
           t->frames, t->sum / t->frames, t->worst);
    if (t->gpu > 0)
        printf(" gpu=%.1f", t->gpu / t->frames);
    if (s->mode == VIEW_SCENE) {
        const view_scene *stage = view_renderer_stage(r);
        printf(" seconds=%.3f ms=%.1f", stage->shown, stage->ms);
    }
    printf(" by=%s %s\n", view_screen_by(),
           (const char *)gl.GetString(GL_RENDERER));
    fflush(stdout);
    *t = (view_stats){0};
}
