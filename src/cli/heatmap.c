/* SPDX-License-Identifier: MIT */
#include "cli/heatmap.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cli/sheet.h"

enum {
    FACE = IBL_SHEET_FACE,
    DOT = IBL_SHEET_DOT,
    GLYPH = IBL_SHEET_GLYPH,
    BAR = 14, /* height of the scale */
    FOOTER = BAR + 6 * DOT + IBL_SHEET_GAP,
    DECADES = 4 /* of the scale, up to 1 */
};

/* ---- colours --------------------------------------------------------- */

/* The map "inferno" of matplotlib (van der Walt and Smith 2015), whose
 * lightness grows evenly, in the polynomial fit of Zucker 2019. */
static void inferno(double t, unsigned char rgb[3])
{
    static const double c[7][3] = {
        {0.0002189403691192265, 0.001651004631001012, -0.01948089843709184},
        {0.1065134194856116, 0.5639564367884091, 3.932712388889277},
        {11.60249308247187, -3.972853965665698, -15.9423941062914},
        {-41.70399613139459, 17.43639888205313, 44.35414519872813},
        {77.162935699427, -33.40235894210092, -81.80730925738993},
        {-71.31942824499214, 32.62606426397723, 73.20951985803202},
        {25.13112622477341, -12.24266895238567, -23.07032500287172}};

    for (int k = 0; k < 3; k++) {
        double x = 0;
        for (int i = 6; i >= 0; i--)
            x = x * t + c[i][k];
        rgb[k] = (unsigned char)(255 * fmin(fmax(x, 0), 1) + 0.5);
    }
}

/* Where a relative error is on the scale: 0 at 1e-4 and below, 1 at 1. */
static double place(double error)
{
    return error > 0 ? fmin(fmax(1 + log10(error) / DECADES, 0), 1) : 0;
}

/* ---- panels ---------------------------------------------------------- */

/* Relative errors of a face's pixels; below 0 where no texel was judged. */
typedef struct field {
    float error[FACE * FACE];
    int seeds[FACE * FACE]; /* pixels with a judged texel */
    int count;
} field;

static void collect(const ibl_verdict *v, int face, field *f)
{
    f->count = 0;
    for (int i = 0; i < FACE * FACE; i++)
        f->error[i] = -1;
    for (size_t i = 0; i < v->count; i++) {
        const ibl_judged_texel *t = &v->texels[i];
        if (t->at.face != face)
            continue;
        const int x = (int)((t->at.x + 0.5) * FACE / v->size);
        const int y = (int)((t->at.y + 0.5) * FACE / v->size);
        float *e = &f->error[y * FACE + x];
        if (*e < 0)
            f->seeds[f->count++] = y * FACE + x;
        *e = fmaxf(*e, (float)t->error);
    }
}

static float nearest(const field *f, int x, int y)
{
    int best = 0, least = 4 * FACE * FACE;

    for (int i = 0; i < f->count; i++) {
        const int dx = f->seeds[i] % FACE - x, dy = f->seeds[i] / FACE - y;
        if (dx * dx + dy * dy < least) {
            least = dx * dx + dy * dy;
            best = f->seeds[i];
        }
    }
    return f->error[best];
}

static void draw_face(const ibl_sheet *s, int left, int top, const field *f)
{
    for (int y = 0; y < FACE && f->count; y++)
        for (int x = 0; x < FACE; x++) {
            const float e = f->error[y * FACE + x];
            inferno(place((double)(e < 0 ? nearest(f, x, y) : e)),
                    ibl_sheet_pixel(s, left + x, top + y));
        }
}

static void draw_row(const ibl_sheet *s, int left, int top,
                     const ibl_report_row *row, field *f)
{
    char text[64];

    for (int face = 0; face < IBL_FACES; face++) {
        collect(&row->verdict, face, f);
        draw_face(s, left + FACE * ibl_cross_place[face][0],
                  top + FACE * ibl_cross_place[face][1], f);
    }
    snprintf(text, sizeof text, "%s %d", row->content, row->level);
    ibl_sheet_write(s, left + 2 * FACE + GLYPH, top, text);
    if (row->verdict.role == IBL_ROLE_SPECULAR) {
        snprintf(text, sizeof text, "r = %.4g", row->verdict.roughness);
        ibl_sheet_write(s, left + 2 * FACE + GLYPH, top + IBL_SHEET_LINE, text);
    }
}

static void draw_scale(const ibl_sheet *s)
{
    static const char *const labels[DECADES + 1] = {"1E-4", "1E-3", "1E-2",
                                                    "1E-1", "1"};
    const int left = IBL_SHEET_GAP, width = s->width - 2 * IBL_SHEET_GAP;
    const int top = s->height - FOOTER;

    for (int y = 0; y < BAR; y++)
        for (int x = 0; x < width; x++)
            inferno((double)x / (width - 1),
                    ibl_sheet_pixel(s, left + x, top + y));
    for (int i = 0; i <= DECADES; i++) {
        const int length = (int)strlen(labels[i]) * GLYPH - DOT;
        int x = left + i * (width - 1) / DECADES - length / 2;
        x = x < left ? left : x;
        x = x > left + width - length ? left + width - length : x;
        ibl_sheet_write(s, x, top + BAR + DOT, labels[i]);
    }
}

bool ibl_heatmap_png(const ibl_report *report, void **png, size_t *size)
{
    ibl_sheet s = {0};
    field *f = malloc(sizeof *f);
    bool ok = f && ibl_sheet_create(&s, report->count, FOOTER);

    if (ok) {
        for (int i = 0; i < report->count; i++) {
            int left, top;
            ibl_sheet_place(&s, i, &left, &top);
            draw_row(&s, left, top, &report->rows[i], f);
        }
        draw_scale(&s);
        ok = ibl_sheet_png(&s, png, size);
    }
    ibl_sheet_free(&s);
    free(f);
    return ok;
}
