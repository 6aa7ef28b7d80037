/* SPDX-License-Identifier: MIT */
#include "cli/bake_record.h"

#include <math.h>
#include <stdio.h>

#include "cli/faces.h"
#include "cli/sheet.h"
#include "engine/picture.h"

enum {
    FACE = IBL_SHEET_FACE,
    PANEL_WIDTH = IBL_PANEL_WIDTH,
    PANEL_HEIGHT = IBL_PANEL_HEIGHT,
    MAX_PANELS = IBL_MAX_LEVELS + 4
};

typedef struct sheet {
    ibl_sheet on;
    double exposure;
} sheet;

/* ---- tones ----------------------------------------------------------- */

static double luminance(const float *rgb)
{
    return 0.2126 * (double)rgb[0] + 0.7152 * (double)rgb[1] +
           0.0722 * (double)rgb[2];
}

/*
 * Exposure that maps the logarithmic mean of the luminance to middle grey
 * (Reinhard et al. 2002, eq. 1 and 2). It is limited so that the plain mean,
 * which the rough levels show, is at most 0.35: without the limit a dark room
 * with a few lamps gives white panels.
 */
static double find_exposure(const ibl_image *env)
{
    const double pi = acos(-1.0);
    double mean = 0, log_mean = 0;

    for (int pass = 0; pass < 2; pass++)
        for (int j = 0; j < env->height; j++) {
            const float *row = env->data + 3 * (size_t)j * (size_t)env->width;
            const double weight =
                (cos(pi * j / env->height) - cos(pi * (j + 1) / env->height)) /
                (2.0 * env->width);
            double sum = 0;
            for (int i = 0; i < env->width; i++) {
                const double y = luminance(row + 3 * i);
                sum += pass == 0 ? y : log(y + 1e-3 * mean);
            }
            *(pass == 0 ? &mean : &log_mean) += weight * sum;
            if (pass == 0 && j == env->height - 1 && !(mean > 0))
                return 1;
        }
    return fmin(0.18 / exp(log_mean), 0.35 / mean);
}

static void put_radiance(const sheet *s, int x, int y, const double rgb[3])
{
    unsigned char *p = ibl_sheet_pixel(&s->on, x, y);
    for (int c = 0; c < 3; c++)
        p[c] = ibl_tone_byte(IBL_TONE_FILM, rgb[c] * s->exposure);
}

/* ---- cubes ----------------------------------------------------------- */

/* A texel of a face. Coordinates beyond an edge continue on the neighbour. */
static const float *texel(const ibl_cube *cube, int level, int face, int i,
                          int j)
{
    const int n = ibl_cube_edge(cube->size, level);

    if (i < 0 || j < 0 || i >= n || j >= n) {
        double dir[3];
        ibl_face_direction(face, 2 * (i + 0.5) / n - 1, 2 * (j + 0.5) / n - 1,
                           dir);
        const ibl_texel at = ibl_face_texel(n, dir);
        face = at.face, i = at.x, j = at.y;
    }
    return ibl_cube_face(cube, level, face) + 3 * ((size_t)j * (size_t)n + i);
}

/* Pixel (x, y) of a face: the mean of the texels it covers, or the
 * interpolation of the nearest four where it is smaller than a texel. */
static void face_pixel(const ibl_cube *cube, int level, int face, int x, int y,
                       double rgb[3])
{
    const int n = ibl_cube_edge(cube->size, level);
    const double u = (x + 0.5) * n / FACE - 0.5, v = (y + 0.5) * n / FACE - 0.5;
    const int i = (int)floor(u), j = (int)floor(v);

    if (n >= FACE) {
        ibl_mean_rgb(ibl_cube_face(cube, level, face), n, x * n / FACE,
                     (x + 1) * n / FACE, y * n / FACE, (y + 1) * n / FACE, rgb);
        return;
    }
    rgb[0] = rgb[1] = rgb[2] = 0;
    for (int k = 0; k < 4; k++) {
        const double w =
            (k & 1 ? u - i : i + 1 - u) * (k & 2 ? v - j : j + 1 - v);
        const float *t = texel(cube, level, face, i + (k & 1), j + k / 2);
        for (int c = 0; c < 3; c++)
            rgb[c] += w * (double)t[c];
    }
}

static void draw_cube(const sheet *s, int left, int top, const ibl_cube *cube,
                      int level)
{
    for (int face = 0; face < IBL_FACES; face++)
        for (int y = 0; y < FACE; y++)
            for (int x = 0; x < FACE; x++) {
                double rgb[3];
                face_pixel(cube, level, face, x, y, rgb);
                put_radiance(s, left + FACE * ibl_cross_place[face][0] + x,
                             top + FACE * ibl_cross_place[face][1] + y, rgb);
            }
}

/* ---- the other panels ------------------------------------------------ */

/* Samples from..to - 1 of n under pixel x of a row of `pixels`; one or more. */
static void span(int x, int pixels, int n, int *from, int *to)
{
    *from = (int)((long long)x * n / pixels);
    *to = (int)((long long)(x + 1) * n / pixels);
    if (*to == *from)
        ++*to;
}

static void draw_map(const sheet *s, int left, int top, const ibl_image *env)
{
    const int height = 2 * FACE;

    top += (PANEL_HEIGHT - height) / 2;
    for (int y = 0; y < height; y++)
        for (int x = 0; x < PANEL_WIDTH; x++) {
            double rgb[3];
            int i0, i1, j0, j1;
            span(x, PANEL_WIDTH, env->width, &i0, &i1);
            span(y, height, env->height, &j0, &j1);
            ibl_mean_rgb(env->data, env->width, i0, i1, j0, j1, rgb);
            put_radiance(s, left + x, top + y, rgb);
        }
}

/* Draws the stored values untouched: channels as red, green and blue. */
static void draw_lut(const sheet *s, int left, int top, const ibl_lut *lut)
{
    const int channels = ibl_lut_channels(lut->kind);

    for (int y = 0; y < PANEL_HEIGHT; y++)
        for (int x = 0; x < PANEL_HEIGHT; x++) {
            const int i = x * lut->size / PANEL_HEIGHT;
            const int j = (PANEL_HEIGHT - 1 - y) * lut->size / PANEL_HEIGHT;
            const float *t =
                lut->data +
                (size_t)channels * ((size_t)j * (size_t)lut->size + (size_t)i);
            unsigned char *p = ibl_sheet_pixel(&s->on, left + x, top + y);
            p[2] = 0;
            for (int c = 0; c < channels; c++)
                p[c] = ibl_tone_byte(IBL_TONE_RAW, (double)t[c]);
        }
}

/* ---- layout ---------------------------------------------------------- */

typedef struct panel {
    const ibl_image *map; /* one of map, cube and lut is set */
    const ibl_cube *cube;
    const ibl_lut *lut;
    int level;
    char text[2][32]; /* two lines of label */
} panel;

static int list_panels(const ibl_bake *b, panel panels[MAX_PANELS])
{
    const ibl_bake_result *made = &b->made;
    int n = 0;

    if (b->from->env.data) {
        panel *p = &panels[n++];
        *p = (panel){.map = &b->from->env, .text = {"environment"}};
        snprintf(p->text[1], sizeof p->text[1], "%d x %d", b->from->env.width,
                 b->from->env.height);
    }
    if (made->skybox.data)
        panels[n++] = (panel){.cube = &made->skybox, .text = {"skybox"}};
    for (int l = 0; l < made->specular.levels; l++) {
        panel *p = &panels[n++];
        *p = (panel){.cube = &made->specular, .level = l};
        snprintf(p->text[0], sizeof p->text[0], "specular %d", l);
        snprintf(p->text[1], sizeof p->text[1], "r = %.3g",
                 made->report.layout.roughness[l]);
    }
    if (made->irradiance.data)
        panels[n++] =
            (panel){.cube = &made->irradiance, .text = {"irradiance"}};
    if (b->lut.data)
        panels[n++] =
            (panel){.lut = &b->lut, .text = {"BRDF table", "r over N.V"}};
    return n;
}

/* Writes over a map, or to the right of a cube's upper face or the table. */
static void write_label(const sheet *s, int left, int top, const panel *p)
{
    if (p->map)
        top += (PANEL_HEIGHT - 2 * FACE) / 2 - 2 * IBL_SHEET_LINE;
    else
        left += (p->cube ? 2 * FACE : PANEL_HEIGHT) + IBL_SHEET_GLYPH;
    for (int line = 0; line < 2; line++)
        ibl_sheet_write(&s->on, left, top + line * IBL_SHEET_LINE,
                        p->text[line]);
}

bool ibl_preview_png(const ibl_bake *b, void **png, size_t *size)
{
    panel panels[MAX_PANELS];
    const int count = list_panels(b, panels);
    sheet s = {.exposure =
                   b->from->env.data ? find_exposure(&b->from->env) : 1};

    if (!ibl_sheet_create(&s.on, count, 0))
        return false;
    for (int i = 0; i < count; i++) {
        int left, top;
        ibl_sheet_place(&s.on, i, &left, &top);
        if (panels[i].map)
            draw_map(&s, left, top, panels[i].map);
        else if (panels[i].cube)
            draw_cube(&s, left, top, panels[i].cube, panels[i].level);
        else
            draw_lut(&s, left, top, panels[i].lut);
        write_label(&s, left, top, &panels[i]);
    }
    const bool ok =
        ibl_png_encode_rgb(s.on.pixels, s.on.width, s.on.height, png, size);
    ibl_sheet_free(&s.on);
    return ok;
}
