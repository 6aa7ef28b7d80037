/* SPDX-License-Identifier: MIT */
#include "cli/judge_report.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "cli/sheet.h"
#include "engine/png.h"
#include "json/json_text.h"

bool ibl_report_add(ibl_report *report, ibl_judge *judge,
                    const ibl_judge_level *level)
{
    assert(report->count < IBL_REPORT_ROWS);
    const bool ok =
        ibl_judge_cube_level(judge, level, &report->rows[report->count]);

    report->count += ok;
    return ok;
}

void ibl_report_free(ibl_report *report)
{
    for (int i = 0; i < report->count; i++)
        ibl_verdict_free(&report->rows[i]);
    report->count = 0;
}

static const char *content(const ibl_verdict *v)
{
    return ibl_output_content(v->level.content);
}

bool ibl_report_passes(const ibl_report *report, double max_error, char *why,
                       size_t size)
{
    const ibl_lut_verdict *lut = &report->lut;

    *why = '\0';
    if (isnan(max_error))
        return true;
    for (int i = 0; i < report->count && !*why; i++) {
        const ibl_verdict *v = &report->rows[i];
        if (v->nonfinite)
            snprintf(why, size, "level %d of %s has %zu texels of NaN or Inf",
                     v->level.number, content(v), v->nonfinite);
        else if (!(v->nrmse <= max_error))
            snprintf(why, size,
                     "level %d of %s has an nRMSE of %.3g, above %g%s",
                     v->level.number, content(v), v->nrmse, max_error,
                     v->overflow_share > 0.5
                         ? ": most of it is light that its pixel cannot hold: "
                           "use --pixel rgba32f"
                         : "");
    }
    if (*why || !report->has_lut)
        return !*why;
    if (lut->nonfinite)
        snprintf(why, size, "the BRDF table has %zu texels of NaN or Inf",
                 lut->nonfinite);
    else if (!(lut->max <= max_error))
        snprintf(why, size,
                 "the BRDF table is off by %.3g at N.V = %.3g, r = %.3g, more "
                 "than %g",
                 lut->max, lut->worst_n_dot_v, lut->worst_roughness, max_error);
    return !*why;
}

/* ---- table ----------------------------------------------------------- */

static void print_row(const ibl_verdict *v, FILE *to)
{
    fprintf(to, "%-10s %2d", content(v), v->level.number);
    if (v->level.content == IBL_OUTPUT_SPECULAR)
        fprintf(to, " %6.4f", v->level.roughness);
    else
        fprintf(to, " %6s", "-");
    fprintf(to,
            " %5d %7zu  %8.2e %8.2e %8.2e %8.2e  (%+.2f %+.2f %+.2f)"
            "  %+9.1e %5zu",
            v->level.size, v->error.count, v->nrmse, v->error.median,
            v->error.p95, v->error.worst, v->worst_dir[0], v->worst_dir[1],
            v->worst_dir[2], v->bias, v->nonfinite);
    if (isnan(v->rounding_share))
        fprintf(to, " %7s\n", "-");
    else
        fprintf(to, " %5.1f %%\n", 100 * v->rounding_share);
}

static void print_dark(const ibl_verdict *v, FILE *to)
{
    fprintf(to, "%-10s %2d %13s %7zu  %8s %8.2e %8.2e %8.2e\n", content(v),
            v->level.number, "", v->dark.count, "", v->dark.median, v->dark.p95,
            v->dark.worst);
}

/* Prints the errors with and without the pixel format's overflow. */
static void print_overflow(const ibl_verdict *v, FILE *to)
{
    if (v->overflow > 0)
        fprintf(to,
                "%-10s %2d light above %.9g, the most that %s holds, makes "
                "%.1f %% of the squared error: without it nRMSE is %.2e\n",
                content(v), v->level.number,
                (double)ibl_pixel_max(v->level.pixel),
                ibl_pixel_name(v->level.pixel), 100 * v->overflow_share,
                v->nrmse * sqrt(fmax(0, 1 - v->overflow_share)));
}

static void print_each(const ibl_report *report, FILE *to,
                       void (*print)(const ibl_verdict *v, FILE *to))
{
    for (int i = 0; i < report->count; i++)
        print(&report->rows[i], to);
}

void ibl_report_print(const ibl_report *report, FILE *to)
{
    const ibl_lut_verdict *lut = &report->lut;

    if (report->count) {
        fprintf(to, "%-13s %6s %5s %7s  %8s %8s %8s %8s  %-19s  %9s %5s %7s\n",
                "level", "r", "size", "texels", "nRMSE", "median", "p95",
                "worst", "towards", "bias", "NaN", "rounded");
        print_each(report, to, print_row);
        fprintf(to, "%-26s %7s  %8s %8s %8s %8s\n", "darkest tenth", "texels",
                "", "median", "p95", "worst");
        print_each(report, to, print_dark);
        print_each(report, to, print_overflow);
    }
    if (report->has_lut)
        fprintf(to,
                "BRDF table   size %d, %zu texels: largest error %.2e at N.V "
                "= %.3f, r = %.3f; rms %.2e (rounding alone %.2e); NaN %zu\n",
                lut->size, lut->count, lut->max, lut->worst_n_dot_v,
                lut->worst_roughness, lut->rms, lut->rounding, lut->nonfinite);
    /* Keeps the table before later messages on standard error in a log. */
    fflush(to);
}

/* ---- JSON ------------------------------------------------------------ */

static json_t *spread_json(const ibl_error_spread *s)
{
    return json_pack("{sI sf sf sf}", "texels", (json_int_t)s->count, "median",
                     ibl_json_digits(s->median), "p95", ibl_json_digits(s->p95),
                     "worst", ibl_json_digits(s->worst));
}

/* null: not known. */
static json_t *known(double x)
{
    return isnan(x) ? json_null() : json_real(ibl_json_digits(x));
}

static json_t *row_json(const ibl_verdict *v)
{
    json_t *j = json_pack("{ss si si}", "content", content(v), "level",
                          v->level.number, "size", v->level.size);

    if (v->level.content == IBL_OUTPUT_SPECULAR) {
        put(&j, "lobe", json_string(ibl_lobe_name(v->level.lobe)));
        put(&j, "roughness", json_real(v->level.roughness));
    }
    put_all(&j,
            json_pack(
                "{sI sf sf sf sf s[fff] so sf sI so so sf sf}", "texels",
                (json_int_t)v->error.count, "nrmse", ibl_json_digits(v->nrmse),
                "median", ibl_json_digits(v->error.median), "p95",
                ibl_json_digits(v->error.p95), "worst",
                ibl_json_digits(v->error.worst), "worst_direction",
                ibl_json_digits(v->worst_dir[0]),
                ibl_json_digits(v->worst_dir[1]),
                ibl_json_digits(v->worst_dir[2]), "darkest_tenth",
                spread_json(&v->dark), "bias", ibl_json_digits(v->bias),
                "nonfinite", (json_int_t)v->nonfinite, "rounding_nrmse",
                known(v->rounding), "rounding_share", known(v->rounding_share),
                "overflow_nrmse", ibl_json_digits(v->overflow),
                "overflow_share", ibl_json_digits(v->overflow_share)));
    return j;
}

static json_t *lut_json(const ibl_lut_verdict *v)
{
    return json_pack("{si sI sf sf sf sf sf sI}", "size", v->size, "texels",
                     (json_int_t)v->count, "max", ibl_json_digits(v->max),
                     "worst_n_dot_v", ibl_json_digits(v->worst_n_dot_v),
                     "worst_roughness", ibl_json_digits(v->worst_roughness),
                     "rms", ibl_json_digits(v->rms), "rounding_rms",
                     ibl_json_digits(v->rounding), "nonfinite",
                     (json_int_t)v->nonfinite);
}

json_t *ibl_report_json(const ibl_report *report)
{
    const ibl_judge_options *o = &report->options;
    json_t *j = json_object(), *levels = json_array();

    put(&j, "texels", o->all ? json_string("all") : json_integer(o->texels));
    put(&j, "seed", json_integer(o->seed));
    for (int i = 0; i < report->count; i++)
        append(&levels, row_json(&report->rows[i]));
    put(&j, "levels", levels);
    if (report->has_lut)
        put(&j, "lut", lut_json(&report->lut));
    return j;
}

/* ---- picture ---------------------------------------------------------- */

enum {
    FACE = IBL_SHEET_FACE,
    DOT = IBL_SHEET_DOT,
    GLYPH = IBL_SHEET_GLYPH,
    BAR = 14, /* height of the scale in pixels */
    FOOTER = BAR + 6 * DOT + IBL_SHEET_GAP,
    DECADES = 4 /* decades of error on the scale; its upper end is 1 */
};

/* The colour map "inferno" of matplotlib (van der Walt and Smith 2015), with
 * evenly growing lightness; polynomial fit of Zucker 2019. */
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

/* Position of a relative error on the scale: 0 at 1e-4 and below, 1 at 1. */
static double place(double error)
{
    return error > 0 ? fmin(fmax(1 + log10(error) / DECADES, 0), 1) : 0;
}

/* Relative errors of a face's pixels; below 0 where no texel was judged. */
typedef struct field {
    float error[FACE * FACE];
    int seeds[FACE * FACE]; /* pixels with a judged texel */
    int count;
} field;

/* The pixel of a judged texel on the faces of a cube. */
static ibl_texel place_on_cube(const ibl_judge_level *level, ibl_texel at)
{
    const ibl_level_shape s =
        ibl_level_shape_of(level->projection, level->size);
    double d[3];

    if (level->projection == IBL_PROJECTION_CUBE)
        return (ibl_texel){at.face, (int)((at.x + 0.5) * FACE / level->size),
                           (int)((at.y + 0.5) * FACE / level->size)};
    ibl_level_direction(&s, 0, at.x, at.y, d);
    return ibl_face_texel(FACE, d);
}

static void collect(const ibl_verdict *v, int face, field *f)
{
    f->count = 0;
    for (int i = 0; i < FACE * FACE; i++)
        f->error[i] = -1;
    for (size_t i = 0; i < v->error.count; i++) {
        const ibl_judged_texel *t = &v->texels[i];
        const ibl_texel at = place_on_cube(&v->level, t->at);
        const int x = at.x, y = at.y;
        if (at.face != face)
            continue;
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
                     const ibl_verdict *v, field *f)
{
    char text[64];

    for (int face = 0; face < IBL_FACES; face++) {
        collect(v, face, f);
        draw_face(s, left + FACE * ibl_cross_place[face][0],
                  top + FACE * ibl_cross_place[face][1], f);
    }
    snprintf(text, sizeof text, "%s %d", content(v), v->level.number);
    ibl_sheet_write(s, left + 2 * FACE + GLYPH, top, text);
    if (v->level.content == IBL_OUTPUT_SPECULAR) {
        snprintf(text, sizeof text, "r = %.4g", v->level.roughness);
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
        ok = ibl_png_encode_rgb(s.pixels, s.width, s.height, png, size);
    }
    ibl_sheet_free(&s);
    free(f);
    return ok;
}
