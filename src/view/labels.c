/* SPDX-License-Identifier: MIT */
#include "view/labels.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "view/inspect.h"
#include "view/message.h"
#include "view/sphere_grid.h"
#include "view/vector.h"

static const double MARGIN = 4; /* pixels at scale 1 */

/* A picture that gets labels. */
typedef struct page {
    view_overlay *overlay;
    const view_settings *s;
    const baked_set *set;
    int width, height;
    double scale; /* of text: whole, so strokes are sharp */
} page;

/* ---- a line that says what is shown ------------------------------------ */

static void add_compared(const view_settings *s, const view_renderer *r,
                         char *to)
{
    char text[2][200];
    const char *one = view_renderer_side(r, s, false, text[0], sizeof *text);
    const char *other = view_renderer_side(r, s, true, text[1], sizeof *text);

    if (s->compare == VIEW_SPLIT)
        view_add(to, VIEW_LABEL_BYTES, "\n%sleft: %s,%sright: %s",
                 s->mode == VIEW_SPHERES ? "of each sphere " : "", one,
                 one == text[0] ? "\n" : " ", other);
    else if (s->compare == VIEW_DIFFERENCE && s->false_colour)
        view_add(to, VIEW_LABEL_BYTES, "\n|%s - %s| x %.3g", one, other,
                 s->gain);
    else if (s->compare == VIEW_DIFFERENCE)
        view_add(to, VIEW_LABEL_BYTES, "\n|%s - %s|", one, other);
    else
        view_add(to, VIEW_LABEL_BYTES, ", %s",
                 view_reflection_names[s->reflection]);
    if (view_renderer_environment(r))
        view_add(to, VIEW_LABEL_BYTES, " of %d samples",
                 view_renderer_samples(r));
}

static void add_map(const view_settings *s, const baked_set *set, char *to)
{
    const ibl_texture *chain = &set->texture[VIEW_SPECULAR];

    if (s->mode == VIEW_TABLE)
        view_add(to, VIEW_LABEL_BYTES,
                 ", BRDF table: roughness upwards\nlines at 0.1 to "
                 "0.9: white scale, blue bias");
    else if (s->mode == VIEW_IRRADIANCE_MAP)
        view_add(to, VIEW_LABEL_BYTES, ", irradiance, %d x %d a face",
                 set->texture[VIEW_IRRADIANCE].width,
                 set->texture[VIEW_IRRADIANCE].width);
    else
        view_add(to, VIEW_LABEL_BYTES,
                 ", level %d of %d, roughness %.3g, %d x %d a face", s->level,
                 chain->levels, set->roughness[s->level],
                 ibl_cube_edge(chain->width, s->level),
                 ibl_cube_edge(chain->width, s->level));
}

void view_labels_title(const view_settings *s, const view_renderer *r,
                       const baked_set *set, char text[VIEW_LABEL_BYTES])
{
    snprintf(text, VIEW_LABEL_BYTES, "%.80s", set->name);
    if (set->layer)
        view_add(text, VIEW_LABEL_BYTES, ", layer %d", set->layer);
    if (s->mode == VIEW_SPHERES)
        view_add(text, VIEW_LABEL_BYTES, ", %s",
                 view_materials[s->material].name);
    if (s->mode == VIEW_SCENE)
        view_add(text, VIEW_LABEL_BYTES, ", scene at %.3g s", s->seconds);
    else if (view_shows_materials(s))
        add_compared(s, r, text);
    else
        add_map(s, set, text);
    if (s->ev < 0 || s->ev > 0)
        view_add(text, VIEW_LABEL_BYTES, ", EV %+.3g", s->ev);
}

/* ---- axes -------------------------------------------------------------- */

/* Where a point of the world is, in pixels from the upper left. */
static void place(const page *p, const double world[3], double at[2])
{
    const view_camera c = view_camera_of(p->s, p->width, p->height);
    double m[16], clip[4];

    view_camera_matrix(&c, m);
    for (int i = 0; i < 4; i++)
        clip[i] = m[i] * world[0] + m[4 + i] * world[1] + m[8 + i] * world[2] +
                  m[12 + i];
    at[0] = (0.5 + 0.5 * clip[0] / clip[3]) * p->width;
    at[1] = (0.5 - 0.5 * clip[1] / clip[3]) * p->height;
}

/* The middle of an edge of a sphere, to the left or below. */
static void edge_of(const page *p, const view_sphere *ball, int axis,
                    double at[2])
{
    double world[3];

    memcpy(world, ball->centre, sizeof world);
    world[axis] -= ball->radius;
    place(p, world, at);
}

/* Draws text with that point in the middle of its upper or right edge, moved
 * into the picture. */
static void write_at(const page *p, const double at[2], bool below,
                     const char *text)
{
    double w, h;

    view_overlay_measure(text, p->scale, &w, &h);
    const double x = below ? at[0] - w / 2 : at[0] - w;
    const double y = below ? at[1] : at[1] - h / 2;
    view_overlay_text(p->overlay, fmin(fmax(x, 0), p->width - w),
                      fmin(fmax(y, 0), p->height - h), p->scale, text);
}

/* Labels each column or row whose spheres are far enough apart. The name is
 * before the first, if it has room. */
static void add_axis(const page *p, const view_sphere *balls, bool columns)
{
    const view_settings *s = p->s;
    const char *name = columns ? "roughness" : "metallic";
    const int count = columns ? s->columns : s->rows;
    const int step = columns ? 1 : s->columns;
    double last[2] = {-INFINITY, INFINITY}, at[2], w, h, name_width;
    char text[32];

    view_overlay_measure(name, p->scale, &name_width, &h);
    for (int i = 0; i < count; i++) {
        const view_sphere *b = &balls[i * step];
        snprintf(text, sizeof text, "%.2g",
                 columns ? b->roughness : b->metallic);
        edge_of(p, b, columns, at);
        view_overlay_measure(text, p->scale, &w, &h);
        if (columns ? at[0] - w / 2 < last[0] : at[1] + h / 2 > last[1])
            continue;
        write_at(p, at, columns, text);
        last[0] = at[0] + w / 2;
        last[1] = at[1] - h / 2;
        const double before = columns ? at[0] - w / 2 : at[0] - w;
        if (!i && before >= name_width)
            write_at(
                p,
                (double[2]){before, columns ? fmin(at[1], p->height - h) + h / 2
                                            : at[1]},
                false, name);
    }
}

static void add_grid(const page *p)
{
    view_sphere balls[VIEW_MAX_GRID * VIEW_MAX_GRID];

    view_grid(p->s, balls);
    add_axis(p, balls, true);
    add_axis(p, balls, false);
}

/* Names the faces that have room for it, in the middle of their lower edges. */
static void add_faces(const page *p)
{
    static const int cross[IBL_FACES][2] = {{2, 1}, {0, 1}, {1, 0},
                                            {1, 2}, {1, 1}, {3, 1}};
    const bool strip = p->s->layout == VIEW_STRIP;
    const int columns = strip ? 6 : 4, rows = strip ? 1 : 3;
    const double edge =
        fmin((double)p->width / columns, (double)p->height / rows) * p->s->zoom;

    for (int f = 0; f < IBL_FACES && edge > 40 * p->scale; f++) {
        const double x = (strip ? f : cross[f][0]) + 0.5, y = cross[f][1] + 1;
        const double at[2] = {
            p->width / 2.0 + (x - columns * (0.5 + p->s->pan[0])) * edge,
            p->height / 2.0 +
                ((strip ? 1 : y) - rows * (0.5 + p->s->pan[1])) * edge};
        if (at[0] > 0 && at[0] < p->width && at[1] > 0 &&
            at[1] < p->height + edge)
            write_at(p, (double[2]){at[0], at[1] - 6 * MARGIN * p->scale}, true,
                     view_face_names[f]);
    }
}

static void add_table(const page *p)
{
    const double side = fmin(p->width, p->height) * p->s->zoom;
    const double left = p->width / 2.0 - side * (0.5 + p->s->pan[0]);

    write_at(p, (double[2]){left, p->height}, true, "N.V 0, roughness 0");
    write_at(p, (double[2]){left + side, p->height}, true, "N.V 1");
}

/* Equirectangular maps: directions of columns. */
static void add_directions(const page *p)
{
    static const char *const names[] = {"-X", "-Z", "+X", "+Z", "-X"};
    const double wide = fmin(p->width, 2.0 * p->height) * p->s->zoom;

    for (int i = 0; i < 5; i++)
        write_at(
            p,
            (double[2]){p->width / 2.0 + (i / 4.0 - 0.5 - p->s->pan[0]) * wide,
                        p->height},
            true, names[i]);
}

/* ---- all --------------------------------------------------------------- */

static void add_scales(const page *p)
{
    const double width = fmin(p->width - 2 * MARGIN, 220 * p->scale);
    const double x = p->width - MARGIN - width, y = MARGIN;
    const view_settings *s = p->s;

    const bool greys = view_compares(s) && s->compare == VIEW_DIFFERENCE;

    if (s->false_colour || greys)
        view_overlay_legend(p->overlay, x, y, width, p->scale,
                            s->false_colour ? 0 : 1 / (s->gain * exp2(s->ev)));
}

void view_labels_draw(view_overlay *overlay, const view_settings *s,
                      const baked_set *set, int width, int height,
                      const char *title)
{
    const page p = {overlay, s,      set,
                    width,   height, fmax(1, floor(width / 640.0))};
    double w, h;

    view_overlay_measure(title, p.scale, &w, &h);
    if (w + 2 * MARGIN > width || 4 * h > height)
        return; /* there is no room to read it */
    view_overlay_begin(overlay, width, height);
    if (s->mode == VIEW_SPHERES)
        add_grid(&p);
    else if (s->mode == VIEW_LEVELS || s->mode == VIEW_IRRADIANCE_MAP)
        (s->layout == VIEW_EQUIRECT ? add_directions : add_faces)(&p);
    else if (s->mode == VIEW_TABLE)
        add_table(&p);
    view_overlay_text(overlay, MARGIN, MARGIN, p.scale, title);
    add_scales(&p);
    view_overlay_end(overlay);
}
