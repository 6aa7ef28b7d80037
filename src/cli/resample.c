/* SPDX-License-Identifier: MIT */
#include "cli/resample.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Solid angle of the band between rows a and b of h, per radian of azimuth. */
static double band(double a, double b, int h)
{
    return cos(M_PI * a / h) - cos(M_PI * b / h);
}

static void add_row(const ibl_image *env, int y, double weight, double *row)
{
    const int last = env->height - 1;
    const float *src = env->data + 3 * (size_t)env->width *
                                       (size_t)(y < 0      ? 0
                                                : y > last ? last
                                                           : y);
    for (size_t i = 0; i < 3 * (size_t)env->width; i++)
        row[i] += weight * (double)src[i];
}

/* Row y of `height` resampled rows, still as wide as the source. */
static void resample_rows(const ibl_image *env, int y, int height, double *row)
{
    const double scale = (double)env->height / height;

    memset(row, 0, 3 * (size_t)env->width * sizeof *row);
    if (scale <= 1) {
        const double at = (y + 0.5) * scale - 0.5, low = floor(at);
        add_row(env, (int)low, 1 - (at - low), row);
        add_row(env, (int)low + 1, at - low, row);
        return;
    }
    const double top = y * scale, bottom = (y + 1) * scale;
    const double all = band(top, bottom, env->height);
    for (int i = (int)top; i < bottom && i < env->height; i++)
        add_row(env, i,
                band(fmax(i, top), fmin(i + 1, bottom), env->height) / all,
                row);
}

/* Pixel x of `width` resampled pixels from a row of `from` pixels. */
static void resample_pixel(const double *row, int from, int x, int width,
                           double *rgb)
{
    const double scale = (double)from / width;

    rgb[0] = rgb[1] = rgb[2] = 0;
    if (scale <= 1) {
        const double at = (x + 0.5) * scale - 0.5, low = floor(at);
        const int i = (int)low < 0 ? from - 1 : (int)low;
        const int j = (int)low + 1 == from ? 0 : (int)low + 1;
        for (int c = 0; c < 3; c++)
            rgb[c] = (1 - (at - low)) * row[3 * (size_t)i + c] +
                     (at - low) * row[3 * (size_t)j + c];
        return;
    }
    const double left = x * scale, right = (x + 1) * scale;
    for (int i = (int)left; i < right && i < from; i++)
        for (int c = 0; c < 3; c++)
            rgb[c] += (fmin(i + 1, right) - fmax(i, left)) / scale *
                      row[3 * (size_t)i + c];
}

/* Ward's shared exponent encoding. */
static void encode(const double *rgb, unsigned char *rgbe)
{
    const double most = fmax(rgb[0], fmax(rgb[1], rgb[2]));
    int exponent;

    memset(rgbe, 0, 4);
    if (!(most > 1e-38))
        return;
    const double scale = frexp(fmin(most, 1.6e38), &exponent) * 256 / most;
    for (int c = 0; c < 3; c++)
        rgbe[c] = (unsigned char)fmin(scale * fmax(rgb[c], 0), 255);
    rgbe[3] = (unsigned char)(exponent + 128);
}

int ibl_resample_write(const ibl_image *env, int width, int height, FILE *to)
{
    double *row = calloc(3 * (size_t)env->width, sizeof *row);

    if (!row)
        return ENOMEM;
    fprintf(to, "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y %d +X %d\n", height,
            width);
    for (int y = 0; y < height; y++) {
        resample_rows(env, y, height, row);
        for (int x = 0; x < width; x++) {
            unsigned char rgbe[4];
            double rgb[3];
            resample_pixel(row, env->width, x, width, rgb);
            encode(rgb, rgbe);
            fwrite(rgbe, 1, sizeof rgbe, to);
        }
    }
    free(row);
    return fflush(to) || ferror(to) ? (errno ? errno : EIO) : 0;
}
