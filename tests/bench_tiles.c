/* SPDX-License-Identifier: MIT */
/*
 * Milliseconds to find the probes that each tile of a picture has, by
 * ibl_tiles_cull on one thread and by ibl_tile_cull as a pass of OpenGL, a
 * pixel a tile of 16 x 16; of 8 and 64 probes, by turns, medians.
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "ibl/probes.h"
#include "view.h"
#include "view/clock.h"
#include "view/gl.h"
#include "view/program.h"

enum {
    RUNS = 15,
    TILE = 16,
    COLUMNS = 1920 / TILE,
    ROWS = (1080 + TILE - 1) / TILE,
    MOST = IBL_MAX_TILE_PROBES
};

/* From beyond a side along -Z across all of it. */
static const double clip[16] = {.97, 0, 0,  0,  0, 1.73, 0, 0,
                                0,   0, -1, -1, 0, 0,    0, 22};

static const char fragment_text[] =
    "#include \"probes.glsl\"\n"
    "uniform samplerBuffer probes;\n"
    "uniform vec2 lens;\n"
    "uniform int count, width, height, tile;\n"
    "layout(location = 0) out uvec2 mask;\n"
    "void main()\n"
    "{\n"
    "    mat4 clip = mat4(lens.x, 0, 0, 0, 0, lens.y, 0, 0,\n"
    "                     0, 0, -1, -1, 0, 0, 0, 22);\n"
    "    mask = ibl_tile_cull(probes, count, clip, ivec2(width, height),\n"
    "                         tile, ivec2(gl_FragCoord.xy));\n"
    "}\n";

typedef struct bench {
    GLuint program;
    ibl_probe probes[MOST];
    unsigned long long masks[COLUMNS * ROWS];
} bench;

static const char *text_of(const char *name)
{
    const view_shader_file *f = view_shader_files;

    while (f->name && strcmp(f->name, name) != 0)
        f++;
    return f->text;
}

static void set(const bench *b, const char *name, int value)
{
    gl.Uniform1i(gl.GetUniformLocation(b->program, name), value);
}

static void make_program(bench *b)
{
    const view_shader_file files[] = {{"probes.glsl", text_of("probes.glsl")},
                                      {"full.vert", text_of("full.vert")},
                                      {"tiles.frag", fragment_text},
                                      {NULL, NULL}};

    b->program = view_program_from(files, "full.vert", "tiles.frag");
    if (!b->program)
        exit(1);
    gl.UseProgram(b->program);
    gl.Uniform2f(gl.GetUniformLocation(b->program, "lens"), (float)clip[0],
                 (float)clip[5]);
    set(b, "tile", TILE);
}

/* Rooms of a building, 40 by 40. */
static void make_probes(bench *b)
{
    GLuint buffer, texels, masks, target, corners;
    float packed[MOST * IBL_PROBE_FLOATS];
    int order[MOST];
    test_random r = {1};

    for (int i = 0; i < MOST; i++) {
        ibl_volume v = {.shape = (ibl_shape)(i % 2)};
        for (int k = 0; k < 3; k++) {
            v.centre[k] = (k == 1 ? 2 : 40) * (test_random_unit(&r) - 0.5);
            v.half[k] = 1 + 3 * test_random_unit(&r);
        }
        b->probes[i] = (ibl_probe){.influence = v, .blend = 0.5};
        order[i] = i;
    }
    ibl_probes_pack(b->probes, MOST, order, packed);
    gl.GenBuffers(1, &buffer);
    gl.BindBuffer(GL_TEXTURE_BUFFER, buffer);
    gl.BufferData(GL_TEXTURE_BUFFER, sizeof packed, packed, GL_STATIC_DRAW);
    gl.GenTextures(1, &texels);
    gl.BindTexture(GL_TEXTURE_BUFFER, texels);
    gl.TexBuffer(GL_TEXTURE_BUFFER, GL_RGBA32F, buffer);
    gl.GenTextures(1, &masks);
    gl.BindTexture(GL_TEXTURE_2D, masks);
    gl.TexImage2D(GL_TEXTURE_2D, 0, GL_RG32UI, COLUMNS, ROWS, 0, GL_RG_INTEGER,
                  GL_UNSIGNED_INT, NULL);
    gl.GenFramebuffers(1, &target);
    gl.BindFramebuffer(GL_FRAMEBUFFER, target);
    gl.FramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D,
                            masks, 0);
    gl.GenVertexArrays(1, &corners);
    gl.BindVertexArray(corners);
}

static double by_library(bench *b, const ibl_tiles *tiles, int count)
{
    const double begin = view_clock();

    if (ibl_tiles_cull(tiles, b->probes, count, b->masks))
        exit(1);
    return 1e3 * (view_clock() - begin);
}

static double by_shader(bench *b, const ibl_tiles *tiles, int count)
{
    const int columns = ibl_tiles_columns(tiles), rows = ibl_tiles_rows(tiles);

    gl.Finish();
    const double begin = view_clock();
    set(b, "count", count);
    set(b, "width", tiles->width);
    set(b, "height", tiles->height);
    gl.Viewport(0, 0, columns, rows);
    gl.DrawArrays(GL_TRIANGLES, 0, 3);
    gl.Finish();
    return 1e3 * (view_clock() - begin);
}

/* Of the words that the shader wrote, the bits. */
static long count_bits(int columns, int rows)
{
    static unsigned words[2 * COLUMNS * ROWS];
    long bits = 0;

    gl.PixelStorei(GL_PACK_ALIGNMENT, 4);
    gl.ReadPixels(0, 0, columns, rows, GL_RG_INTEGER, GL_UNSIGNED_INT, words);
    for (int i = 0; i < 2 * columns * rows; i++)
        bits += __builtin_popcount(words[i]);
    return bits;
}

static void measure(bench *b, int width, int height, int count)
{
    ibl_tiles tiles = {.width = width, .height = height, .tile = TILE};
    const int columns = ibl_tiles_columns(&tiles);
    const int n = columns * ibl_tiles_rows(&tiles);
    double library[RUNS], shader[RUNS];
    long bits = 0;

    for (int i = 0; i < 16; i++)
        tiles.clip[i] = clip[i];
    for (int run = -1; run < RUNS; run++) {
        const double a = by_library(b, &tiles, count);
        const double c = by_shader(b, &tiles, count);
        library[run < 0 ? 0 : run] = a;
        shader[run < 0 ? 0 : run] = c;
    }
    for (int i = 0; i < n; i++)
        bits += __builtin_popcountll(b->masks[i]);
    printf("%4d x %-4d %2d probes %10.3f %10.3f   %5.2f %5.2f\n", width, height,
           count, test_median(library, RUNS), test_median(shader, RUNS),
           (double)bits / n, (double)count_bits(columns, n / columns) / n);
}

int main(void)
{
    static bench b;

    if (!view_test_begin(32, 32))
        return 1;
    make_program(&b);
    make_probes(&b);
    printf("tiles of %d x %d, %s\n%-21s %10s %10s   probes a tile by either\n",
           TILE, TILE, view_test_about(), "", "library ms", "shader ms");
    measure(&b, 1280, 720, 8);
    measure(&b, 1280, 720, MOST);
    measure(&b, 1920, 1080, 8);
    measure(&b, 1920, 1080, MOST);
    const bool ok = view_gl_check("culling tiles");
    view_test_end();
    return !ok;
}
