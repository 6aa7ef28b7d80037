/* SPDX-License-Identifier: MIT */
#include "view/app.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/process.h"
#include "view/frame.h"
#include "view/message.h"
#include "view/sphere_grid.h"
#include "view/ui.h"

enum {
    SPACE = 5,
    BYTES = 400
};

static const char *const face_names[IBL_FACES] = {"+X", "-X", "+Y",
                                                  "-Y", "+Z", "-Z"};
/* A point of a text, in fractions of its size. */
static const double upper_left[2] = {0, 0}, upper_right[2] = {1, 0},
                    upper[2] = {0.5, 0}, right[2] = {1, 0.5};

/* ---- lines that say what is shown ---------------------------------------- */

static void write_title(const view_app *app, char text[BYTES])
{
    const view_settings *s = &app->side[0];
    const baked_set *set = app->set;
    const ibl_texture *chain = &set->baked.file[IBL_CONTENT_SPECULAR].texture;
    const int samples = view_renderer_samples(app->renderer);

    snprintf(text, BYTES, "%.80s", set->baked.name);
    if (set->layer)
        view_add(text, BYTES, ", layer %d", set->layer);
    if (s->mode == VIEW_SPHERES)
        view_add(text, BYTES, ", %s", view_material_names[s->material]);
    if (view_shows_materials(s) && !s->compare)
        view_add(text, BYTES, ", %s", view_reflection_names[s->reflection]);
    if (s->mode == VIEW_SCENE)
        view_add(text, BYTES, ", scene at %.3g s", s->seconds);
    if (s->mode == VIEW_TABLE)
        view_add(text, BYTES, ", BRDF table: red scale, green bias");
    if (s->mode == VIEW_IRRADIANCE_MAP)
        view_add(text, BYTES, ", irradiance by %s",
                 view_diffuse_names[view_diffuse_of(s, set)]);
    if (s->mode == VIEW_LEVELS)
        view_add(
            text, BYTES, ", level %d of %d, roughness %.3g, faces of %d",
            s->level, chain->levels,
            set->baked.file[IBL_CONTENT_SPECULAR].facts.roughness[s->level],
            ibl_cube_edge(chain->width, s->level));
    if (s->layout == VIEW_CROSS &&
        (s->mode == VIEW_LEVELS || s->mode == VIEW_IRRADIANCE_MAP))
        view_add(text, BYTES, ": +Y above, -X +Z +X -Z, -Y below");
    if (!view_is_lit(s) && s->channel)
        view_add(text, BYTES, ", %s", view_channel_names[s->channel]);
    if (samples)
        view_add(text, BYTES, ", reference of %d samples", samples);
    if (s->ev < 0 || s->ev > 0)
        view_add(text, BYTES, ", EV %+.3g", s->ev);
}

/* What a side shows that the other does not, as "reflection split". */
static void write_side(const view_app *app, int i, char text[BYTES])
{
    const view_control *c;
    const char *other = app->other.baked.name;

    snprintf(text, BYTES, "%.80s",
             other ? (i ? &app->other : app->set)->baked.name : "");
    for (int k = 0; (c = view_control_at(k)); k++) {
        char mine[80], its[80];
        if (!c->label || !view_control_of_side(c))
            continue;
        view_control_text(c, &app->side[i], mine);
        view_control_text(c, &app->side[!i], its);
        if (strcmp(mine, its) != 0)
            view_add(text, BYTES, "%s%s %s", *text ? ", " : "", c->label, mine);
    }
}

static void add_sides(const view_app *app, double left, double end, double top)
{
    const view_settings *s = &app->side[0];
    char text[2][BYTES], line[3 * BYTES];

    for (int i = 0; i < 2; i++)
        write_side(app, i, text[i]);
    if (s->compare == VIEW_SPLIT) {
        snprintf(line, sizeof line, "left: %s", text[0]);
        view_ui_text(left, top, upper_left, line);
        snprintf(line, sizeof line, "right: %s", text[1]);
        view_ui_text(end, top, upper_right, line);
        view_ui_text(0.5 * (left + end), top, upper, app->errors);
    } else {
        snprintf(line, sizeof line, "|%s - %s| x %.3g   %s", text[0], text[1],
                 s->gain, app->errors);
        view_ui_text(left, top, upper_left, line);
    }
}

/* ---- axes -------------------------------------------------------------- */

/* Where a point of the world is, in pixels from the upper left. */
static void place(const view_app *app, const view_area *area,
                  const double world[3], double at[2])
{
    const view_camera c =
        view_camera_of(&app->side[0], area->width, area->height);
    double m[16], clip[4];

    view_camera_matrix(&c, m);
    for (int i = 0; i < 4; i++)
        clip[i] = m[i] * world[0] + m[4 + i] * world[1] + m[8 + i] * world[2] +
                  m[12 + i];
    at[0] = area->x + (0.5 + 0.5 * clip[0] / clip[3]) * area->width;
    at[1] =
        app->height - area->y - (0.5 + 0.5 * clip[1] / clip[3]) * area->height;
}

/* Labels each column or row whose spheres are far enough apart. */
static void add_axis(const view_app *app, const view_area *area,
                     const view_sphere *balls, bool columns)
{
    const view_settings *s = &app->side[0];
    const int count = columns ? s->columns : s->rows;
    const double bottom = app->height - area->y, line = VIEW_LINE * app->scale;
    double last = HUGE_VAL, at[2];
    char text[32];

    for (int i = 0; i < count; i++) {
        const view_sphere *b = &balls[columns ? i : i * s->columns];
        place(app, area, b->centre, at);
        if (fabs(at[!columns] - last) < (columns ? 2 : 1) * line)
            continue;
        last = at[!columns];
        snprintf(text, sizeof text, "%.2g",
                 columns ? b->roughness : b->metallic);
        if (columns)
            view_ui_text(at[0], bottom, upper, text);
        else
            view_ui_text(area->x - SPACE, at[1], right, text);
    }
    if (columns)
        view_ui_text(0, bottom, upper_left, " roughness");
    else
        view_ui_text(0, bottom - area->height + line, upper_left, " metallic");
}

/* Names below a map: faces of a strip, directions of an equirectangular map,
 * ends of the table, which has names beside it, too. */
static void add_names(const view_app *app, const view_area *area)
{
    static const char *const turns[] = {"-X", "-Z", "+X", "+Z", "-X"};
    static const char *const ends[] = {"N.V 0", "1"};
    const view_settings *s = &app->side[0];
    const bool table = s->mode == VIEW_TABLE;
    const bool strip = s->layout == VIEW_STRIP && s->mode != VIEW_SOURCE_MAP;
    const char *const *names = table ? ends : strip ? face_names : turns;
    const int count = table ? 2 : strip ? IBL_FACES : 5;
    const double bottom = app->height - area->y;
    double size[2];

    view_app_map_size(app, size);
    const double left =
        area->x + 0.5 * area->width - size[0] * (0.5 + s->pan[0]);
    for (int i = 0; i < count; i++) {
        const double share =
            names == face_names ? (i + 0.5) / count : i / (count - 1.0);
        const double x = left + share * size[0];
        if (x >= area->x && x <= area->x + area->width)
            view_ui_text(x, bottom,
                         (double[2]){names == face_names ? 0.5 : share, 0},
                         names[i]);
    }
    if (table) {
        view_ui_text(left - SPACE, bottom, (double[2]){1, 1}, "roughness 0");
        view_ui_text(left - SPACE, bottom - area->height, upper_right, "1");
    }
}

/* ---- under the pointer --------------------------------------------------- */

static void write_texel(const view_app *app, int x, int y, char text[BYTES])
{
    const view_settings *s = &app->side[0];
    float told[3][4];
    const float *at = told[0], *d = told[1], *value = told[2];

    if (!view_renderer_texel(app->renderer, x, y, told))
        return;
    if (at[0] >= 0)
        snprintf(text, BYTES, "level %g  %s ", at[1], face_names[(int)at[0]]);
    if (s->mode == VIEW_TABLE)
        snprintf(text, BYTES,
                 "(%g, %g)  N.V %.4f roughness %.4f  R %.5g G %.5g", at[2],
                 at[3], d[0], d[1], value[0], value[1]);
    else
        view_add(text, BYTES,
                 "(%g, %g)  dir %.3f %.3f %.3f  rgb %.4g %.4g %.4g", at[2],
                 at[3], d[0], d[1], d[2], value[0], value[1], value[2]);
}

/* The texel there, or the probe that lights what is there most. */
static void write_pointer(const view_app *app, const view_area *area,
                          char text[BYTES])
{
    const view_settings *s = &app->side[0];
    const double x = app->mouse[0] - area->x,
                 y = app->mouse[1] - (app->height - area->y - area->height);
    view_scene *stage = view_renderer_stage(app->renderer);
    double weight;

    *text = '\0';
    if (x < 0 || y < 0 || x >= area->width || y >= area->height)
        return;
    if (!view_is_lit(s)) {
        write_texel(app, (int)x, area->height - 1 - (int)y, text);
    } else if (s->mode == VIEW_SCENE && stage && s->weights) {
        const int locals = stage->draw.locals.count;
        const int i = view_scene_probe_at(stage, s, area->width, area->height,
                                          x, y, &weight);
        if (i == locals)
            snprintf(text, BYTES, "the mirror's probe: %.2f", weight);
        else if (i >= 0)
            snprintf(text, BYTES, "probe %d: %.2f", i, weight);
        else if (i != VIEW_SCENE_NOWHERE)
            snprintf(text, BYTES, "the environment");
    }
}

/* ---- all --------------------------------------------------------------- */

static void draw_labels(const view_app *app, const view_area *area)
{
    const view_settings *s = &app->side[0];
    const bool axes = s->mode == VIEW_SPHERES || s->mode == VIEW_TABLE;
    const double top = app->height - area->y - area->height;
    const double line = VIEW_LINE * app->scale, left = SPACE * app->scale;
    const double end = area->x + area->width - left;
    view_sphere balls[VIEW_MAX_GRID * VIEW_MAX_GRID];
    char text[BYTES];

    if (top < line)
        return; /* there is no room */
    write_pointer(app, area, text);
    view_ui_text(end, 2, upper_right, text);
    write_title(app, text);
    view_ui_text(left, 2, upper_left, app->caption ? app->caption : text);
    if (s->compare)
        add_sides(app, left, end, 2 + line);
    if (s->false_colour || s->compare == VIEW_DIFFERENCE) {
        const double wide = fmin(area->width / 2.0, 220 * app->scale);
        view_ui_legend(end - wide, 4 + line / 2, wide,
                       s->false_colour ? 0 : 1 / (s->gain * exp2(s->ev)));
    }
    if (axes ? !area->x : !area->y)
        return;
    if (s->mode == VIEW_SPHERES) {
        view_grid(s, balls);
        add_axis(app, area, balls, true);
        add_axis(app, area, balls, false);
    } else {
        add_names(app, area);
    }
}

/* The error of the whole picture, as "RMSE 2.7 % (noise .9 %)". */
static void write_errors(view_app *app)
{
    int count;
    view_error *errors = view_renderer_errors(app->renderer, &count);

    if (errors) {
        const double noise = 100 * view_error_noise(errors[count]);
        snprintf(app->errors, sizeof app->errors, "RMSE %.2f %%",
                 100 * view_error_rmse(errors[count]));
        if (noise > 0)
            view_add(app->errors, sizeof app->errors, " (noise %.2g %%)",
                     noise);
    }
    free(errors);
}

/* Errors of a picture at rest, anew with twice the samples. */
static void judge(view_app *app)
{
    const int samples = view_renderer_samples(app->renderer);

    if (!app->side[0].compare || !view_renderer_complete(app->renderer)) {
        app->judged = -1;
        *app->errors = '\0';
    } else if (app->judged < 0 || samples < app->judged ||
               samples >= 2 * app->judged + 1) {
        write_errors(app);
        app->judged = samples;
    }
}

void view_labels_draw(view_app *app)
{
    const view_area area = view_app_area(app);

    if (app->set)
        judge(app);
    view_ui_begin(app->width, app->height);
    if (app->set && app->labels)
        draw_labels(app, &area);
    view_ui_app(app);
    view_ui_end(app->target);
}

/* ---- on the terminal ----------------------------------------------------- */

void view_labels_print(const view_app *app)
{
    view_renderer *r = app->renderer;
    view_sphere spheres[VIEW_MAX_GRID * VIEW_MAX_GRID];
    char sides[2][BYTES];
    int count;
    view_error *errors = view_renderer_errors(r, &count);

    if (!errors)
        return;
    view_grid(&app->side[0], spheres);
    for (int i = 0; i < 2; i++)
        write_side(app, i, sides[i]);
    printf("relative RMSE of %s against %s", sides[0], sides[1]);
    if (view_renderer_truth(r))
        printf(", %d samples a pixel of %s", view_renderer_samples(r),
               view_renderer_truth(r)->environment);
    printf("\n   pixels   error of\n");
    for (int i = 0; i <= count; i++) {
        char part[64] = "(all)";
        if (!errors[i].pixels || (count == 1 && i == 0))
            continue;
        if (i < count && app->side[0].mode == VIEW_SPHERES)
            snprintf(part, sizeof part, "metallic %.3f, roughness %.3f",
                     spheres[i].metallic, spheres[i].roughness);
        else if (i < count)
            snprintf(part, sizeof part, "%s",
                     view_model_material(app->model, i));
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
