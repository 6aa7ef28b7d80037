/* SPDX-License-Identifier: MIT */
/* A picture of all outputs: panels in rows, with labels. */
#include "cli/job.h"

#include <ctype.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "cli/lookup.h"
#include "common/signals.h"

enum {
    BACKGROUND = 24, /* sRGB value of the grey */
    FACE = 96,       /* pixels along a face's edge */
    WIDTH = 4 * FACE,
    HEIGHT = 3 * FACE, /* of a panel */
    GAP = 16,
    DOT = 2,         /* pixels along a dot; a letter has 3 by 5 dots */
    GLYPH = 4 * DOT, /* pixels from letter to letter */
    LINE = 8 * DOT
};

typedef struct sheet {
    int columns, count; /* of panels; count: begun */
    int width, height;
    unsigned char *pixels; /* sRGB, 3 bytes each */
    double exposure;
} sheet;

static unsigned char *pixel(const sheet *s, int x, int y)
{
    return s->pixels + 3 * ((size_t)y * (size_t)s->width + (size_t)x);
}

static unsigned char byte_of(double x)
{
    return (unsigned char)(255 * fmin(fmax(x, 0), 1) + 0.5);
}

static void put_light(const sheet *s, int x, int y, const double rgb[3])
{
    for (int c = 0; c < 3; c++)
        pixel(s, x, y)[c] =
            byte_of(ibl_tone_value(IBL_TONE_FILM, rgb[c] * s->exposure));
}

/* ---- letters ----------------------------------------------------------- */

/* Glyphs of 3 by 5 dots: one octal digit per row, from the top. */
static const struct {
    char character;
    unsigned rows;
} font[] = {{'0', 075557}, {'1', 026227}, {'2', 071747}, {'3', 071717},
            {'4', 055711}, {'5', 074717}, {'6', 074757}, {'7', 071111},
            {'8', 075757}, {'9', 075717}, {'.', 000002}, {'-', 000700},
            {'=', 007070}, {'A', 025755}, {'B', 065656}, {'C', 034443},
            {'D', 065556}, {'E', 074647}, {'F', 074644}, {'G', 034553},
            {'H', 055755}, {'I', 072227}, {'K', 055655}, {'L', 044447},
            {'M', 057755}, {'N', 065555}, {'O', 025552}, {'P', 065644},
            {'R', 065655}, {'S', 034216}, {'T', 072222}, {'U', 055557},
            {'V', 055552}, {'W', 055775}, {'X', 055255}, {'Y', 055222}};

/* Writes text in capitals, with its upper left corner at left, top. Characters
 * without a glyph stay blank. */
static void write_text(const sheet *s, int left, int top, const char *text)
{
    for (; *text; text++, left += GLYPH) {
        unsigned rows = 0;
        for (size_t i = 0; i < sizeof font / sizeof *font; i++)
            if (font[i].character == toupper((unsigned char)*text))
                rows = font[i].rows;
        for (int y = 0; y < 5 * DOT; y++)
            for (int x = 0; x < 3 * DOT; x++) {
                const int dot = 3 * (y / DOT) + x / DOT;
                if (rows >> (14 - dot) & 1 && left + x < s->width)
                    memset(pixel(s, left + x, top + y), 200, 3);
            }
    }
}

/* ---- panels ------------------------------------------------------------ */

/* The upper left corner of the next panel, whose label, two lines of text, is
 * at x, y in it. */
static void begin_panel(sheet *s, int x, int y, const char *name,
                        const char *more, int *left, int *top)
{
    *left = GAP + s->count % s->columns * (WIDTH + GAP);
    *top = GAP + s->count++ / s->columns * (HEIGHT + GAP);
    write_text(s, *left + x, *top + y, name);
    write_text(s, *left + x, *top + y + LINE, more);
}

/* The mean of what lies under pixel x, y of n x m pixels; of what is smaller,
 * the nearest. */
static void find_mean(const float *image, int width, int height, int x, int y,
                      int n, int m, double rgb[3])
{
    const int x0 = (int)((long long)x * width / n);
    const int y0 = (int)((long long)y * height / m);
    const int x1 = (int)fmax((double)((x + 1LL) * width / n), x0 + 1);
    const int y1 = (int)fmax((double)((y + 1LL) * height / m), y0 + 1);

    rgb[0] = rgb[1] = rgb[2] = 0;
    for (int j = y0; j < y1; j++) {
        const float *p = image + 3 * ((size_t)j * (size_t)width + (size_t)x0);
        for (int k = 0; k < 3 * (x1 - x0); k++)
            rgb[k % 3] += (double)p[k] / (double)(x1 - x0) / (y1 - y0);
    }
}

static void draw_map(sheet *s, const ibl_image *map)
{
    const int margin = HEIGHT / 6; /* above it, with the label */
    char size[32];
    double rgb[3];
    int left, top;

    snprintf(size, sizeof size, "%d x %d", map->width, map->height);
    begin_panel(s, 0, margin - 2 * LINE, "environment", size, &left, &top);
    for (int i = 0; i < WIDTH * 2 * FACE; i++) {
        const int x = i % WIDTH, y = i / WIDTH;
        find_mean(map->data, map->width, map->height, x, y, WIDTH, 2 * FACE,
                  rgb);
        put_light(s, left + x, top + margin + y, rgb);
    }
}

/*
 * An unfolded cube is a cross of 4 by 3 faces, +Y on top, -X +Z +X -Z in the
 * middle row, -Y below, so that neighbours in the cross are neighbours on the
 * cube.
 */
static void draw_cube(sheet *s, const ibl_cube *cube, int level,
                      const char *name, const char *more)
{
    /* The column and row of each face. */
    static const int place[IBL_FACES][2] = {{2, 1}, {0, 1}, {1, 0},
                                            {1, 2}, {1, 1}, {3, 1}};
    const int size = ibl_cube_edge(cube->size, level);
    double dir[3], rgb[3];
    int left, top;

    begin_panel(s, 2 * FACE + GLYPH, 0, name, more, &left, &top);
    for (int i = 0; i < IBL_FACES * FACE * FACE; i++) {
        const int face = i / FACE / FACE, y = i / FACE % FACE, x = i % FACE;
        ibl_cube_direction(FACE, face, x, y, dir);
        if (size >= FACE)
            find_mean(ibl_cube_face(cube, level, face), size, size, x, y, FACE,
                      FACE, rgb);
        else
            ibl_lookup_cube(cube, level, dir, rgb);
        put_light(s, left + FACE * place[face][0] + x,
                  top + FACE * place[face][1] + y, rgb);
    }
}

static void draw_lut(sheet *s, const ibl_lut *lut)
{
    const int channels = ibl_lut_channels(lut->kind), n = lut->size;
    int left, top;

    begin_panel(s, HEIGHT + GLYPH, 0, "BRDF table", "r over N.V", &left, &top);
    for (int i = 0; i < HEIGHT * HEIGHT; i++) {
        const int x = i % HEIGHT, y = i / HEIGHT;
        const size_t at = (size_t)((HEIGHT - 1 - y) * n / HEIGHT) * (size_t)n +
                          (size_t)(x * n / HEIGHT);
        unsigned char *p = pixel(s, left + x, top + y);
        p[2] = 0;
        for (int c = 0; c < channels; c++)
            p[c] =
                byte_of((double)lut->data[(size_t)channels * at + (size_t)c]);
    }
}

/* ---- the picture -------------------------------------------------------- */

ibl_blob ibl_preview_png(const ibl_output_set *b)
{
    const ibl_bake_result *made = &b->made;
    const ibl_image *env = &b->job->env;
    const int count = (env->data != NULL) + (made->skybox.data != NULL) +
                      made->specular.levels + (made->irradiance.data != NULL) +
                      (b->lut.data != NULL);
    const int most = count > 9 ? 4 : 3, columns = count < most ? count : most;
    sheet s = {.columns = columns,
               .width = GAP + columns * (WIDTH + GAP),
               .height = GAP + (count + columns - 1) / columns * (HEIGHT + GAP),
               .exposure = 1};
    const size_t bytes = 3 * (size_t)s.width * (size_t)s.height;
    ibl_blob png = {0};

    s.pixels = ibl_need(malloc(bytes));
    memset(s.pixels, BACKGROUND, bytes);
    if (env->data) {
        double mean[3];
        find_mean(env->data, env->width, env->height, 0, 0, 1, 1, mean);
        const double y = 0.2126 * mean[0] + 0.7152 * mean[1] + 0.0722 * mean[2];
        s.exposure = y > 0 ? 0.35 / y : 1;
        draw_map(&s, env);
    }
    if (made->skybox.data)
        draw_cube(&s, &made->skybox, 0, "skybox", "");
    for (int l = 0; l < made->specular.levels; l++) {
        char name[32], roughness[32];
        snprintf(name, sizeof name, "specular %d", l);
        snprintf(roughness, sizeof roughness, "r = %.3g",
                 made->report.layout.roughness[l]);
        draw_cube(&s, &made->specular, l, name, roughness);
    }
    if (made->irradiance.data)
        draw_cube(&s, &made->irradiance, 0, "irradiance", "");
    if (b->lut.data)
        draw_lut(&s, &b->lut);
    if (!ibl_png_encode(s.pixels, 3, s.width, s.height, NULL, &png))
        ibl_need(NULL);
    free(s.pixels);
    return png;
}
