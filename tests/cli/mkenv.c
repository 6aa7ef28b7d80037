/* SPDX-License-Identifier: MIT */
/*
 * Writes a small environment to standard output:
 *   mkenv hdr W H        Radiance, flat RGBE: a sky, ground and a bright sun
 *   mkenv exr W H NAMES  OpenEXR, uncompressed floats, one scan line a chunk,
 *                        channels as named ("BGR" or "A", alphabetical): R, G
 *                        and B hold what sh_light says, A 1
 *   mkenv exr W H NAMES IN [OUT]
 *                        A is IN where z > 0.8, else OUT (1), and Y the same;
 *                        R, G and B are multiplied by it if it is from 0 to 1
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "float_exr.h"

static void direction(int w, int h, int i, int j, double d[3])
{
    const double pi = acos(-1.0);
    const double theta = pi * (j + 0.5) / h;
    const double phi = 2 * pi * ((i + 0.5) / w - 0.5);
    d[0] = sin(theta) * cos(phi);
    d[1] = cos(theta);
    d[2] = sin(theta) * sin(phi);
}

static void put_rgbe(const double rgb[3])
{
    const double most = fmax(rgb[0], fmax(rgb[1], rgb[2]));
    int e;
    const double scale = frexp(most, &e) * 256 / most;
    for (int c = 0; c < 3; c++)
        putchar((int)(rgb[c] * scale));
    putchar(e + 128);
}

static void hdr(int w, int h)
{
    printf("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y %d +X %d\n", h, w);
    for (int j = 0; j < h; j++)
        for (int i = 0; i < w; i++) {
            const double ground[3] = {0.2, 0.15, 0.1}, sky[3] = {0.4, 0.6, 1.1};
            const double sun[3] = {9e4, 8e4, 6e4};
            double d[3];
            direction(w, h, i, j, d);
            if (i == w * 3 / 4 && j == h / 4)
                put_rgbe(sun);
            else
                put_rgbe(d[1] > 0 ? sky : ground);
        }
}

static double alpha_in = 1, alpha_out = 1;

static double alpha(const double d[3])
{
    return d[2] > 0.8 ? alpha_in : alpha_out;
}

/* Bands 1 in R, 2 in G and B: the irradiance of each is known. */
static double sh_light(char channel, const double d[3])
{
    const double x = d[0], y = d[1], z = d[2];
    if (channel == 'R')
        return 1 + 0.5 * x + 0.2 * y + 0.1 * z;
    if (channel == 'G')
        return 1 + 0.4 * x * y + 0.3 * y * z + 0.2 * x * z;
    return 1 + 0.2 * (3 * z * z - 1) + 0.3 * (x * x - y * y);
}

static void exr(int w, int h, const char *names)
{
    float *samples = malloc(sizeof *samples * strlen(names) * (size_t)(w * h));
    float *to = samples;

    if (!samples)
        exit(1);
    for (const char *c = names; *c; c++)
        for (int i = 0; i < w * h; i++) {
            double d[3];
            direction(w, h, i % w, i / w, d);
            const double a = alpha(d);
            *to++ = (float)(strchr("AY", *c)   ? a
                            : a >= 0 && a <= 1 ? a * sh_light(*c, d)
                                               : sh_light(*c, d));
        }
    test_write_float_exr(stdout, w, h, names, samples);
    free(samples);
}

int main(int argc, char **argv)
{
    if (argc == 4 && !strcmp(argv[1], "hdr"))
        hdr(atoi(argv[2]), atoi(argv[3]));
    else if (argc >= 5 && argc <= 7 && !strcmp(argv[1], "exr")) {
        alpha_in = argc > 5 ? atof(argv[5]) : 1;
        alpha_out = argc > 6 ? atof(argv[6]) : 1;
        exr(atoi(argv[2]), atoi(argv[3]), argv[4]);
    } else
        return 2;
    return 0;
}
