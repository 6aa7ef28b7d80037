/* SPDX-License-Identifier: MIT */
/*
 * write_textures DIR: one file of every container, pixel format and shape,
 * for programs that others wrote to read. Beside each NAME.ktx2, NAME.ktx and
 * NAME.dds lies NAME.raw, the texels as ibl_texture has them, beside blocks of
 * them NAME.half, their R, G and B; NAME-zstd.ktx2 is NAME.ktx2 compressed.
 * Containers that cannot hold a format are left out. NAME is PIXEL-SHAPE, SHAPE
 * is cubeSIZExLEVELS, alphaSIZExLEVELS (a cube whose colours are multiplied by
 * alpha) or flatSIZEx1, or one of these with xLAYERS behind.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "ibl/io.h"
#include "test.h"

static ibl_ctx *ctx;
static ibl_outputs *out;

static void need(ibl_status status)
{
    if (status)
        exit(1);
}

/* Values of many sizes, 0 and what saturates among them. */
static void fill(float *data, size_t count)
{
    test_random r = {31};
    for (size_t i = 0; i < count; i++)
        data[i] = i % 17
                      ? (float)ldexp(test_random_unit(&r), (int)(i % 40) - 20)
                      : (float)(i % 3) * 1e5f;
}

static void write_file(const ibl_texture *tex, ibl_container container,
                       const char *path)
{
    void *bytes;
    size_t size;
    need(ibl_texture_encode(ctx, tex, container, &bytes, &size));
    need(ibl_outputs_add(out, path, bytes, size));
    ibl_bytes_free(bytes);
}

static void write_halves(const ibl_texture *tex, const char *path)
{
    ibl_texture plain = *tex;
    plain.data = malloc(tex->bytes);
    if (!plain.data)
        exit(1);
    memcpy(plain.data, tex->data, tex->bytes);
    need(ibl_texture_unblock(ctx, &plain));
    unsigned char *to = plain.data;
    for (size_t i = 0; i < plain.bytes; i += 8, to += 6)
        memmove(to, plain.data + i, 6);
    need(ibl_outputs_add(out, path, plain.data, plain.bytes / 8 * 6));
    ibl_bytes_free(plain.data);
}

static void write_all(const ibl_texture *tex, const char *dir,
                      const char *shape)
{
    ibl_texture packed = *tex;
    const char *pixel = ibl_pixel_name(tex->pixel);
    char path[1000];
    snprintf(path, sizeof path, "%s/%s-%s.raw", dir, pixel, shape);
    need(ibl_outputs_add(out, path, tex->data, tex->bytes));
    for (ibl_container c = 0; c < IBL_CONTAINER_DDS_LEGACY; c++) {
        snprintf(path, sizeof path, "%s/%s-%s.%s", dir, pixel, shape,
                 ibl_container_name(c));
        if (ibl_container_holds(c, tex->pixel))
            write_file(tex, c, path);
    }
    packed.zstd = 9;
    snprintf(path, sizeof path, "%s/%s-%s-zstd.ktx2", dir, pixel, shape);
    write_file(&packed, IBL_CONTAINER_KTX2, path);
    snprintf(path, sizeof path, "%s/%s-%s.half", dir, pixel, shape);
    if (ibl_pixel_block(tex->pixel) > 1)
        write_halves(tex, path);
    need(ibl_outputs_commit(out));
}

static void set_keys(ibl_texture *tex)
{
    need(ibl_texture_set(ctx, tex, "iblRoughness", "0 0.25 0.5 1"));
    need(ibl_texture_set(ctx, tex, "Odd", "\xC3\xA9"));
}

/* An array of a texture, each layer turned by some bytes or blocks. */
static void write_array(const ibl_texture *tex, int count, const char *dir,
                        const char *shape)
{
    /* Blocks stay whole: others are not read. */
    const size_t step =
        ibl_pixel_block(tex->pixel) > 1 ? ibl_pixel_bytes(tex->pixel) : 1;
    ibl_texture layer, array;
    char name[40];
    need(ibl_texture_array_begin(ctx, tex, count, &array));
    for (int i = 0; i < count; i++) {
        need(ibl_texture_layer(ctx, tex, 0, &layer));
        for (size_t k = 0; k < tex->bytes; k++)
            layer.data[k] = tex->data[(k + (size_t)i * step) % tex->bytes];
        need(ibl_texture_array_put(ctx, &array, i, &layer));
        ibl_texture_free(&layer);
    }
    set_keys(&array);
    snprintf(name, sizeof name, "%sx%d", shape, count);
    write_all(&array, dir, name);
    ibl_texture_free(&array);
}

/* A texture with keys, alone and in arrays. */
static void write_set(ibl_texture *tex, bool arrays, const char *dir,
                      const char *shape)
{
    set_keys(tex);
    write_all(tex, dir, shape);
    for (int count = 2; arrays && count <= 5; count += 3)
        write_array(tex, count, dir, shape);
    ibl_texture_free(tex);
}

/* alpha: colours multiplied by one, of the pixels that have it. */
static void write_cubes(const char *dir, int size, int levels, bool alpha)
{
    const size_t floats = 3 * ibl_cube_texels(size, levels);
    char shape[32];
    ibl_cube cube, by;
    snprintf(shape, sizeof shape, "%s%dx%d", alpha ? "alpha" : "cube", size,
             levels);
    need(ibl_cube_alloc(ctx, size, levels, &cube));
    need(ibl_cube_alloc(ctx, size, levels, &by));
    fill(cube.data, floats);
    for (size_t i = 0; i < floats; i++)
        by.data[i] = (float)(i % 101) / 100;
    for (ibl_pixel p = 0; p <= IBL_PIXEL_ASTC4X4HDR; p++) {
        ibl_texture tex;
        const ibl_texel_options o = {.pixel = p, .overflow = IBL_OVERFLOW_CLIP};
        if (alpha && !ibl_pixel_has_alpha(p))
            continue;
        need(ibl_texture_from_cube(ctx, &cube, &o, &tex, NULL));
        if (alpha)
            need(ibl_texture_set_alpha(ctx, &tex, &by));
        write_set(&tex, true, dir, shape);
    }
    ibl_cube_free(&cube);
    ibl_cube_free(&by);
}

static void write_luts(const char *dir)
{
    float data[2 * 5 * 5];
    fill(data, sizeof data / sizeof data[0]);
    const ibl_lut lut = {.size = 5, .data = data};
    for (ibl_pixel p = IBL_PIXEL_RG16F; p <= IBL_PIXEL_RG32F; p++) {
        ibl_texture tex;
        need(ibl_texture_from_lut(ctx, &lut, p, &tex, NULL));
        write_set(&tex, true, dir, "flat5x1");
    }
}

static void write_lobes(const char *dir)
{
    float data[IBL_LOBE_LAYERS * 4 * 6 * 6];
    ibl_texture tex;
    fill(data, sizeof data / sizeof data[0]);
    const ibl_lobe_table table = {6, data, IBL_LOBE_LAYERS};
    need(ibl_texture_from_lobe_table(ctx, &table, &tex));
    write_set(&tex, false, dir, "flat6x1x4");
}

int main(int argc, char **argv)
{
    if (argc != 2) {
        fprintf(stderr, "usage: write_textures DIR\n");
        return 2;
    }
    ctx = test_ctx(1, IBL_ISA_AUTO);
    need(ibl_outputs_create(ctx, 0, &out));
    need(ibl_outputs_mkdir(out, argv[1]));
    write_cubes(argv[1], 8, 4, false);
    write_cubes(argv[1], 6, 2, false);
    write_cubes(argv[1], 1, 1, false);
    write_cubes(argv[1], 8, 4, true);
    write_luts(argv[1]);
    write_lobes(argv[1]);
    ibl_outputs_free(out);
    ibl_ctx_free(ctx);
    return 0;
}
