/* SPDX-License-Identifier: MIT */
#include "view/contact.h"

#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "view/gl.h"
#include "view/message.h"
#include "view/overlay.h"
#include "view/picture.h"
#include "view/still.h"

enum {
    GAP = 4, /* pixels between pictures and around them */
    SHADE = 32
};

static int axis_count(view_axis axis, const baked_set *set)
{
    switch (axis) {
    case VIEW_AXIS_MATERIAL:
        return view_material_count();
    case VIEW_AXIS_TURN:
        return 4;
    case VIEW_AXIS_TONE:
        return VIEW_TONES;
    case VIEW_AXIS_EV:
        return 5;
    case VIEW_AXIS_LEVEL:
        return set->texture[VIEW_SPECULAR].levels;
    case VIEW_AXIS_COMPARE:
        return VIEW_COMPARES;
    case VIEW_AXES:
        break;
    }
    return 0;
}

/* Makes the settings those of place i along an axis; puts what that is called
 * into label. */
static void axis_apply(view_axis axis, const baked_set *set, int i,
                       view_settings *s, char *label, size_t size)
{
    switch (axis) {
    case VIEW_AXIS_MATERIAL:
        s->material = i;
        snprintf(label, size, "%s", view_materials[i].name);
        break;
    case VIEW_AXIS_TURN:
        s->turn += 90 * i;
        snprintf(label, size, "turn %g", s->turn);
        break;
    case VIEW_AXIS_TONE:
        s->tone = (view_tone)i;
        snprintf(label, size, "%s", view_tone_names[s->tone]);
        break;
    case VIEW_AXIS_EV:
        s->ev += i - 2;
        snprintf(label, size, "EV %+g", s->ev);
        break;
    case VIEW_AXIS_LEVEL:
        s->mode = VIEW_LEVELS;
        s->level = i;
        snprintf(label, size, "level %d, r %.3g", i, set->roughness[i]);
        break;
    case VIEW_AXIS_COMPARE:
        s->compare = (view_compare)i;
        snprintf(label, size, "%s", view_compare_names[s->compare]);
        break;
    case VIEW_AXES:
        break;
    }
}

typedef struct sheet {
    const view_options *o;
    const baked_set *set;
    view_renderer *renderer;
    view_overlay *overlay;
    int rows, columns;
    int width, height;  /* of the whole */
    unsigned char *rgb; /* of the whole */
    view_stats stats;
} sheet;

static bool prepare(sheet *h)
{
    const int w = h->o->size[0], height = h->o->size[1];
    const long long wide = GAP + (long long)h->columns * (w + GAP),
                    high = GAP + (long long)h->rows * (height + GAP);

    if (wide > IBL_MAX_EDGE || high > IBL_MAX_EDGE)
        return view_fail("%s: a sheet of %lldx%lld pixels: more than %d along "
                         "an edge: choose a smaller --size",
                         h->o->contact_sheet, wide, high, IBL_MAX_EDGE);
    h->width = (int)wide;
    h->height = (int)high;
    h->rgb = malloc((size_t)(3 * wide) * (size_t)high);
    if (!h->rgb)
        return view_fail("%s: no memory for a sheet of %lldx%lld pixels: "
                         "choose a smaller --size",
                         h->o->contact_sheet, wide, high);
    memset(h->rgb, SHADE, (size_t)(3 * wide) * (size_t)high);
    h->overlay = view_overlay_create();
    return h->overlay;
}

/* Draws a picture with its label and copies it to its place. */
static bool draw_tile(sheet *h, int row, int column, double *ms)
{
    const view_options *o = h->o;
    const int w = o->size[0], height = o->size[1];
    view_settings s = o->settings;
    char row_label[64] = "", column_label[64] = "", label[160];

    axis_apply((view_axis)o->rows, h->set, row, &s, row_label,
               sizeof row_label);
    axis_apply((view_axis)o->columns, h->set, column, &s, column_label,
               sizeof column_label);
    if (!view_still_draw(h->renderer, o, &s, ms, &h->stats))
        return false;
    snprintf(label, sizeof label, "%s, %s", row_label, column_label);
    gl.BindFramebuffer(GL_FRAMEBUFFER, 0);
    view_overlay_text(h->overlay, 4, 4, w < 640 ? 1 : 2, label);
    view_overlay_draw(h->overlay, w, height);

    unsigned char *tile = view_picture_read(0, w, height);
    if (!tile)
        return false;
    for (int y = 0; y < height; y++) {
        const size_t to_row = (size_t)GAP + (size_t)row * (height + GAP) + y,
                     to = to_row * h->width + GAP + (size_t)column * (w + GAP);
        memcpy(h->rgb + 3 * to, tile + (size_t)3 * y * w, (size_t)3 * w);
    }
    free(tile);
    return true;
}

static bool draw_all(sheet *h)
{
    double ms = 0;

    for (int row = 0; row < h->rows; row++)
        for (int column = 0; column < h->columns; column++)
            if (!draw_tile(h, row, column, &ms))
                return false;
    if (h->o->verbose)
        printf("%d pictures, the last one %.1f ms a frame\n",
               h->rows * h->columns, ms);
    return true;
}

bool view_contact_sheet(ibl_ctx *ctx, const view_options *o,
                        const baked_set *set, view_renderer *r)
{
    sheet h = {.o = o, .set = set, .renderer = r};
    bool ok;

    h.rows = axis_count((view_axis)o->rows, set);
    h.columns = axis_count((view_axis)o->columns, set);
    ok = prepare(&h) && draw_all(&h) &&
         view_picture_write(ctx, o->contact_sheet, h.width, h.height, h.rgb) &&
         (!o->stats || view_stats_end(&h.stats, r, &o->settings));
    view_overlay_free(h.overlay);
    free(h.rgb);
    return ok;
}
