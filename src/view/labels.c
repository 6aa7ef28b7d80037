/* SPDX-License-Identifier: MIT */
#include "view/labels.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "view/frame.h"
#include "view/inspect.h"
#include "view/message.h"
#include "view/sphere_grid.h"
#include "view/ui.h"
#include "view/vector.h"

enum {
    SPACE = 5,
    BYTES = 400
};

/* A point of a text, in fractions of its size. */
static const double upper_left[2] = {0, 0}, upper_right[2] = {1, 0},
                    upper[2] = {0.5, 0}, right[2] = {1, 0.5};

/* ---- lines that say what is shown ---------------------------------------- */

static void add_map(const view_settings *s, const baked_set *set, char *to)
{
    const ibl_texture *chain = &set->texture[VIEW_SPECULAR];

    if (s->mode == VIEW_TABLE)
        view_add(to, BYTES,
                 ", BRDF table: lines at 0.1 to 0.9, white scale, "
                 "blue bias");
    else if (s->mode == VIEW_IRRADIANCE_MAP)
        view_add(to, BYTES, ", irradiance by %s",
                 view_diffuse_names[view_diffuse_of(s, set)]);
    else if (s->mode == VIEW_LEVELS)
        view_add(to, BYTES, ", level %d of %d, roughness %.3g, %d x %d a face",
                 s->level, chain->levels, set->roughness[s->level],
                 ibl_cube_edge(chain->width, s->level),
                 ibl_cube_edge(chain->width, s->level));
    if (s->layout == VIEW_CROSS &&
        (s->mode == VIEW_LEVELS || s->mode == VIEW_IRRADIANCE_MAP))
        view_add(to, BYTES, ": +Y above, -X +Z +X -Z, -Y below");
    if (s->channel)
        view_add(to, BYTES, ", %s", view_channel_names[s->channel]);
}

static void write_title(const view_app *app, char text[BYTES])
{
    const view_settings *s = &app->side[0];
    const baked_set *set = app->set;

    snprintf(text, BYTES, "%.80s", set->name);
    if (set->layer)
        view_add(text, BYTES, ", layer %d", set->layer);
    if (s->mode == VIEW_SPHERES)
        view_add(text, BYTES, ", %s", view_material_names[s->material]);
    if (s->mode == VIEW_SCENE)
        view_add(text, BYTES, ", scene at %.3g s", s->seconds);
    else if (!view_is_lit(s))
        add_map(s, set, text);
    else if (!s->compare)
        view_add(text, BYTES, ", %s", view_reflection_names[s->reflection]);
    if (view_renderer_samples(app->renderer))
        view_add(text, BYTES, ", reference of %d samples",
                 view_renderer_samples(app->renderer));
    if (s->ev < 0 || s->ev > 0)
        view_add(text, BYTES, ", EV %+.3g", s->ev);
}

static void add_sides(const view_app *app, double left, double end, double top)
{
    const view_settings *s = &app->side[0];
    char text[2][BYTES], line[3 * BYTES];

    for (int i = 0; i < 2; i++)
        view_report_side(app->side, i, app->set, &app->other, text[i], BYTES);
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
    const int step = columns ? 1 : s->columns;
    const double bottom = app->height - area->y, line = VIEW_LINE * app->scale;
    double last = columns ? area->x : HUGE_VAL, at[2], w, h;
    char text[32];

    for (int i = 0; i < count; i++) {
        const view_sphere *b = &balls[i * step];
        snprintf(text, sizeof text, "%.2g",
                 columns ? b->roughness : b->metallic);
        place(app, area, b->centre, at);
        view_ui_measure(text, &w, &h);
        if (columns ? at[0] - w / 2 < last : at[1] + h > last)
            continue;
        if (columns)
            view_ui_text(at[0], bottom, upper, text);
        else
            view_ui_text(area->x - SPACE, at[1], right, text);
        last = columns ? at[0] + w : at[1];
    }
    if (columns)
        view_ui_text(0, bottom, upper_left, " roughness");
    else
        view_ui_text(0, bottom - area->height + line, upper_left, " metallic");
}

/* Names below a map: faces of a strip, directions of an equirectangular map. */
static void add_names(const view_app *app, const view_area *area)
{
    static const char *const turns[] = {"-X", "-Z", "+X", "+Z", "-X"};
    const view_settings *s = &app->side[0];
    const bool strip = s->layout == VIEW_STRIP && s->mode != VIEW_SOURCE_MAP;
    const int count = strip ? IBL_FACES : 5;
    const double shape = strip ? 6 : 2, middle = area->x + area->width / 2.0;
    const double wide = fmin(area->width, shape * area->height) * s->zoom;

    for (int i = 0; i < count; i++) {
        const double share = strip ? (i + 0.5) / 6 : i / 4.0;
        const double x = middle + (share - 0.5 - s->pan[0]) * wide;
        if (x >= area->x && x <= area->x + area->width)
            view_ui_text(x, app->height - area->y,
                         (double[2]){strip ? 0.5 : share, 0},
                         strip ? view_face_names[i] : turns[i]);
    }
}

static void add_table(const view_app *app, const view_area *area)
{
    const view_settings *s = &app->side[0];
    const double side = fmin(area->width, area->height) * s->zoom;
    const double left = area->x + area->width / 2.0 - side * (0.5 + s->pan[0]);
    const double bottom = app->height - area->y;

    view_ui_text(left, bottom, upper_left, "N.V 0");
    view_ui_text(left + side, bottom, upper_right, "1");
    view_ui_text(left - SPACE, bottom, (double[2]){1, 1}, "roughness 0");
    view_ui_text(left - SPACE, bottom - area->height, upper_right, "1");
}

/* ---- under the pointer ----------------------------------------------------
 */

/* The probe that lights what the pointer is at most, or the texel there. */
static void write_pointer(const view_app *app, const view_area *area,
                          char text[BYTES])
{
    const view_settings *s = &app->side[0];
    const double x = app->mouse[0] - area->x,
                 y = app->mouse[1] - (app->height - area->y - area->height);
    const view_scene *stage = view_renderer_stage(app->renderer);
    double weights[IBL_MAX_PROBES + 2];

    *text = '\0';
    if (x < 0 || y < 0 || x >= area->width || y >= area->height)
        return;
    if (s->mode != VIEW_SCENE) {
        const view_texel t =
            view_inspect(app->set, s, area->width, area->height, x, y);
        view_texel_text(&t, text, BYTES);
    } else if (stage && s->weights) {
        const int locals = view_scene_state_of(stage)->draw.locals.count;
        const int i = view_scene_probe_at(stage, s, area->width, area->height,
                                          x, y, weights);
        if (i == locals)
            snprintf(text, BYTES, "the mirror's probe: %.2f", weights[i]);
        else if (i >= 0)
            snprintf(text, BYTES, "probe %d: %.2f", i, weights[i]);
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
    } else if (s->mode == VIEW_TABLE) {
        add_table(app, area);
    } else {
        add_names(app, area);
    }
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
        view_report_sum(app->renderer, app->errors, sizeof app->errors);
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
