/* SPDX-License-Identifier: MIT */
/*
 * Engines' own files: what the texels that they pack are off by, and files that
 * are damaged or lie. check-clients.sh has the engines read them.
 */
#define _GNU_SOURCE /* memmem */
#include "engine/engine.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "engine/harmonics.h"
#include "engine/picture.h"
#include "engine/rgbd.h"
#include "engine/set.h"
#include "files.h"
#include "test.h"
#include "textures.h"
#include "truth.h"

enum {
    SIZE = 8,
    MAX_FILES = 6 * IBL_MAX_LEVELS
};

static ibl_ctx *ctx;   /* prints its errors */
static ibl_ctx *quiet; /* keeps them in kept */
static test_messages kept;

void test_setup(void)
{
    ctx = test_ctx(2, IBL_ISA_AUTO);
    quiet = test_keeping_ctx(1, &kept);
}

/* A cube of RGBA32F of values from 1e-3 to 200. */
static ibl_texture make(int levels)
{
    const int shape[4] = {SIZE, SIZE, levels, 6};
    ibl_texture tex = texture_random(ctx, IBL_PIXEL_RGBA32F, shape, 1);
    float *texels = (float *)(void *)tex.data;
    test_random r = {7};

    for (size_t i = 0; i < tex.bytes / sizeof *texels; i++)
        texels[i] = (float)exp(test_random_unit(&r) * 12.2 - 6.9);
    NEED(!ibl_texture_set(ctx, &tex, "iblbake.content", "specular"));
    return texture_owned(tex);
}

/* Writes NAME.env or .gltf; what it holds is in tex. */
static const char *save(ibl_engine engine, ibl_texture *tex)
{
    const double sh[27] = {1, 2, 3, 0.5};
    ibl_cube matte = {0};
    const ibl_engine_set set = {tex, &matte, sh, "a b%"};
    ibl_blob file, faces[MAX_FILES] = {0};

    NEED(!ibl_cube_alloc(ctx, 4, 1, &matte));
    for (int i = 0; i < 6 * 4 * 4 * 3; i++)
        matte.data[i] = 0.5f;
    NEED(!ibl_engine_encode(ctx, engine, &set, &file, faces));
    ibl_cube_free(&matte);
    const char *path = file_path(engine == IBL_ENGINE_ENV ? "x.env" : "x.gltf");
    NEED(file_save(path, file.bytes, file.size));
    ibl_blob_free(&file);
    for (int i = 0; i < ibl_engine_faces(engine, tex->levels); i++) {
        char *name = ibl_engine_face_name("a b%", i);
        NEED(file_save(file_path(name), faces[i].bytes, faces[i].size));
        ibl_blob_free(&faces[i]);
        free(name);
    }
    return path;
}

/* The bytes are within half a step of 255 in the curve, so that a value is off
 * by 2.2 / 510 of itself at most where its byte is 255, and in turn more. */
TEST(rgbd)
{
    test_random r = {3};

    for (int i = 0; i < 100000; i++) {
        float texel[4], back[4];
        unsigned char rgbd[4];
        const double scale = exp(test_random_unit(&r) * 20 - 14.4);
        for (int c = 0; c < 3; c++)
            texel[c] = (float)fmin(test_random_unit(&r) * scale, 255);
        ibl_rgbd_encode(texel, 1, rgbd);
        ibl_rgbd_decode(rgbd, 1, back);
        for (int c = 0; c < 3; c++) {
            const double d = rgbd[3] / 255.0, want = (double)texel[c];
            const double g = pow(want * d, 1 / 2.2), step = 0.5001 / 255;
            CHECK((double)back[c] <= pow(g + step, 2.2) / d &&
                  (double)back[c] >= pow(fmax(g - step, 0), 2.2) / d);
        }
        CHECK(rgbd[3] >= 1 && back[3] == 1);
    }
    const float odd[3][4] = {
        {INFINITY, 0, 1, 0}, {NAN, -1, 0, 0}, {1e30F, 300, 255, 0}};
    unsigned char rgbd[12];
    ibl_rgbd_encode(odd[0], 3, rgbd);
    CHECK(rgbd[0] == 255 && rgbd[3] == 1 && rgbd[1] == 0);
    CHECK(rgbd[4] == 0 && rgbd[5] == 0 && rgbd[6] == 0);
    CHECK(rgbd[8] == 255 && rgbd[9] == 255 && rgbd[10] == 255 && rgbd[11] == 1);
}

/* Puts a changed file at the path of the first one and reads it. */
static ibl_status reread(const char *path, const void *bytes, size_t size)
{
    ibl_texture back;

    NEED(file_save(path, bytes, size));
    const ibl_status status = ibl_engine_read(quiet, path, -1, &back);
    ibl_texture_free(&back);
    return status;
}

/* Where text begins in a file. */
static size_t find(const unsigned char *bytes, size_t size, const char *text)
{
    const unsigned char *at = memmem(bytes, size, text, strlen(text));

    NEED(at);
    return (size_t)(at - bytes);
}

/* What is written is read; not what refers to other files, or to none, nor
 * parts. Other damage is the fuzzers'. */
TEST(lies)
{
    enum {
        BAD = IBL_ERR_FORMAT,
        ENV = IBL_ENGINE_ENV,
        GLTF = IBL_ENGINE_GLTF
    };
    static const struct {
        int engine;
        const char *was, *is; /* of the same length */
        int status;
    } lies[] = {{ENV, "\"width\":8", "\"width\":7", BAD},
                {ENV, "\"width\":8", "\"width\":4", BAD},
                {ENV, "\"position\":0", "\"position\":9", BAD},
                {ENV, "\"length\":", "\"lemgth\":", BAD},
                {ENV, "\"mipmaps\":[", "\"mipmaqs\":[", BAD},
                {ENV, "\"specular\":{\"m", "\"specular\":[\"m", BAD},
                {ENV, "image/png", "image/jpg", IBL_ERR_UNSUPPORTED},
                {GLTF, "a%20b", "data:", IBL_ERR_UNSUPPORTED},
                {GLTF, "a%20b", "a%zzb", IBL_ERR_IO}, /* which no file has */
                {GLTF, "a%20b", "a%00b", BAD},
                {GLTF, "EXT_lights_image_based\":{",
                 "EXT_lights_image_basee\":{", BAD}};

    for (size_t i = 0; i < sizeof lies / sizeof *lies; i++) {
        const ibl_engine engine = (ibl_engine)lies[i].engine;
        ibl_texture tex = make(engine == IBL_ENGINE_ENV ? 4 : 2);
        const char *path = save(engine, &tex);
        size_t size;
        unsigned char *b = file_load(path, &size);
        const size_t at = find(b, size, lies[i].was);
        ibl_texture back;
        NEED(!ibl_engine_read(ctx, path, -1, &back));
        texture_owned(back);
        CHECK(texture_same(&tex, &back) && texture_has(&back, "zeta", "last") &&
              texture_has(&back, "iblbake.content", "specular"));
        memcpy(b + at, lies[i].is, strlen(lies[i].is));
        const ibl_status status = reread(path, b, size);
        CHECK_MSG((int)status == lies[i].status, "%s: %d", lies[i].is, status);
        memcpy(b + at, lies[i].was, strlen(lies[i].was));
        for (size_t n = 1; n + 2 < size && i % 7 == 0; n += size / 40)
            CHECK(reread(path, b, n));
        NEED(file_save(path, b, size));
    }
    ibl_texture back;
    /* glTF of others is rougher by even steps. */
    ibl_texture tex = make(3);
    const char *path = save(IBL_ENGINE_GLTF, &tex);
    size_t size;
    unsigned char *b = file_load(path, &size);
    memcpy(b + find(b, size, "iblbake.content"), "another", 7);
    NEED(file_save(path, b, size) && !ibl_engine_read(ctx, path, -1, &back));
    texture_owned(back);
    CHECK(texture_has(&back, "iblbake.roughness", "0,0.5,1"));
    NEED(!unlink(file_path("a b%_0_pz.png")));
    CHECK(ibl_engine_read(quiet, file_path("x.gltf"), -1, &back) ==
              IBL_ERR_IO &&
          test_said(&kept, "a b%_0_pz.png"));
}

/* The decoding of IEC 61966-2-1 gives back what was encoded; what is beyond is
 * clipped. */
TEST(tones)
{
    for (int i = -10; i <= 1010; i++) {
        const double x = i / 1000.0, y = ibl_tone_value(IBL_TONE_CLIP, x);
        CHECK_NEAR(y <= 0.04045 ? y / 12.92 : pow((y + 0.055) / 1.055, 2.4),
                   fmin(fmax(x, 0), 1), 1e-5);
    }
    CHECK(ibl_tone_value(IBL_TONE_FILM, 0) <= 0);
}

/* Of each harmonic the least over directions every three degrees. */
TEST(least_of_harmonics)
{
    static const double cosine[] = {1, 2.0 / 3, 1.0 / 4};

    for (int k = 0; k < 9; k++) {
        const int l = (k > 0) + (k > 3);
        double sh[27] = {0}, least[3], want = 1;
        sh[3 * k + k % 3] = 1;
        for (int i = 0; i < 60 * 120; i++) {
            const double theta = M_PI * (i / 120) / 60,
                         phi = M_PI * (i % 120) / 60;
            const double d[] = {sin(theta) * cos(phi), cos(theta),
                                sin(theta) * sin(phi)};
            want = fmin(want, cosine[l] * truth_sh(l, k - l * (l + 1), d));
        }
        ibl_sh_least(sh, least);
        for (int c = 0; c < 3; c++)
            CHECK_NEAR(least[c], c == k % 3 ? want : 0, 0.01);
    }
}

/* Three channels are a picture in sRGB, as the chunk after the header says;
 * four are numbers. */
TEST(spaces_of_pictures)
{
    const unsigned char dot[4] = {1, 2, 3, 255};
    ibl_blob png;

    for (int channels = 3; channels <= 4; channels++) {
        NEED(ibl_png_encode(dot, channels, 1, 1, NULL, &png));
        CHECK(!memcmp(png.bytes + 37, "sRGB", 4) == (channels == 3));
        ibl_blob_free(&png);
    }
}

/* An image that is cut short; a header of the largest cube, whose images are of
 * one texel, is refused before memory is taken. */
TEST(bomb)
{
    char text[8192] = "\x86\x16\x87\x96\xF6\xD6\x96\x36"
                      "{\"version\":2,\"width\":16384,\"specular\":{"
                      "\"mipmaps\":[";
    const unsigned char dot[4] = {1, 2, 3, 255};
    ibl_blob png;
    const size_t begin = strlen(text);

    NEED(ibl_png_encode(dot, 4, 1, 1, NULL, &png));
    for (size_t n = 0; n + 20 < png.size; n++) {
        unsigned char rgba[4];
        CHECK(!ibl_png_decode(png.bytes, n, 1, 1, rgba));
    }
    for (int big = 0; big < 2; big++) {
        size_t used = begin;
        for (int i = 0; i < 90; i++)
            used += (size_t)sprintf(text + used,
                                    "%s{\"length\":%zu,\"position\":0}",
                                    i ? "," : "", png.size);
        used += (size_t)sprintf(text + used, "]}}") + 1;
        memcpy(text + used, png.bytes, png.size);
        CHECK(reread(file_path("bomb.env"), text, used + png.size) ==
              IBL_ERR_FORMAT);
        CHECK(test_said(&kept, "16384x16384"));
        /* Now the image says that it is so large. */
        png.bytes[18] = png.bytes[22] = 0x40;
        png.bytes[19] = png.bytes[23] = 0;
    }
    ibl_blob_free(&png);
}
