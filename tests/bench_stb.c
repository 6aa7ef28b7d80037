/* SPDX-License-Identifier: MIT */
/*
 * stb_image (package libstb-dev) as a process of its own, to measure beside.
 *
 *     bench_stb FILE.hdr              decodes it, prints "ms N": reading the
 *                                     file and decoding to floats, in memory
 *                                     that the system hands out on the way
 *     bench_stb --grow N FILE.hdr OUT.hdr
 *                                     N times as wide and high
 *
 * A grown map is interpolated bilinearly, wrapped in longitude, and every
 * value of it multiplied by 1 + e, e normal with a deviation of 0.5 %: without
 * noise neighbours would have the same bytes, which no camera's picture has,
 * and run lengths would make reading easier than it is. With that deviation
 * quarry_01_1k.hdr of 2.82 bytes for each pixel grows to 4096x2048 of 2.83;
 * what comes of a file is printed.
 */
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>

#include "test.h"

#if __has_include(<stb/stb_image_write.h>)
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wconversion"
#pragma GCC diagnostic ignored "-Wmissing-prototypes"
#pragma GCC diagnostic ignored "-Wunused-function"
#define STBI_ONLY_HDR
#define STB_IMAGE_IMPLEMENTATION
#include <stb/stb_image.h>
#define STB_IMAGE_WRITE_IMPLEMENTATION
#include <stb/stb_image_write.h>
#pragma GCC diagnostic pop
#else
#error "package libstb-dev is missing"
#endif

#define NOISE 0.005

static float *load(const char *path, int *w, int *h)
{
    int n;
    float *px = stbi_loadf(path, w, h, &n, 3);

    if (!px)
        fprintf(stderr, "%s: %s\n", path, stbi_failure_reason());
    return px;
}

static int decode(const char *path)
{
    int w, h;
    const double begin = test_ms(CLOCK_MONOTONIC);
    float *px = load(path, &w, &h);
    const double end = test_ms(CLOCK_MONOTONIC);

    if (!px)
        return 1;
    /* Not freed before the clock is read, and used. */
    if (px[3 * (size_t)w * (size_t)h / 2] >= 0)
        printf("ms %.3f\n", end - begin);
    stbi_image_free(px);
    return 0;
}

/* ---- grow ------------------------------------------------------------- */

static double unit(uint64_t *state)
{
    uint64_t x = *state += 0x9E3779B97F4A7C15u;
    x = (x ^ (x >> 30)) * 0xBF58476D1CE4E5B9u;
    x = (x ^ (x >> 27)) * 0x94D049BB133111EBu;
    return (double)((x ^ (x >> 31)) >> 11) / 9007199254740992.0;
}

/* Box and Muller. */
static double normal(uint64_t *state)
{
    const double radius = sqrt(-2 * log(1 - unit(state)));
    return radius * cos(6.283185307179586 * unit(state));
}

static void grow_row(const float *px, int w, int h, int n, int y, float *out,
                     uint64_t *state)
{
    const double v = fmax(0, fmin(h - 1, (y + 0.5) / n - 0.5));
    const int j = (int)v, below = j + 1 < h ? j + 1 : j;

    for (int x = 0; x < n * w; x++) {
        const double u = (x + 0.5) / n - 0.5 + w;
        const int i = (int)u % w, right = (i + 1) % w;
        const double fu = u - floor(u), fv = v - j;
        for (int c = 0; c < 3; c++) {
            const double top = (1 - fu) * px[3 * (j * w + i) + c] +
                               fu * px[3 * (j * w + right) + c];
            const double low = (1 - fu) * px[3 * (below * w + i) + c] +
                               fu * px[3 * (below * w + right) + c];
            out[3 * x + c] = (float)(((1 - fv) * top + fv * low) *
                                     fmax(0, 1 + NOISE * normal(state)));
        }
    }
}

static double bytes_per_pixel(const char *path, int w, int h)
{
    struct stat st;
    return stat(path, &st) ? (double)NAN : (double)st.st_size / ((double)w * h);
}

static int grow(int n, const char *from, const char *to)
{
    uint64_t state = 1;
    int w, h;
    float *px = load(from, &w, &h);

    if (!px)
        return 1;
    float *out = malloc(3 * sizeof *out * (size_t)(n * w) * (size_t)(n * h));
    for (int y = 0; out && y < n * h; y++)
        grow_row(px, w, h, n, y, out + 3 * (size_t)y * (size_t)(n * w), &state);
    const int ok = out && stbi_write_hdr(to, n * w, n * h, 3, out);
    if (ok)
        printf("%dx%d: %.2f bytes for each pixel; %dx%d, which it grew from: "
               "%.2f\n",
               n * w, n * h, bytes_per_pixel(to, n * w, n * h), w, h,
               bytes_per_pixel(from, w, h));
    else
        fprintf(stderr, "%s: not written\n", to);
    free(out);
    stbi_image_free(px);
    return !ok;
}

int main(int argc, char **argv)
{
    if (argc == 2)
        return decode(argv[1]);
    if (argc == 5 && !strcmp(argv[1], "--grow") && atoi(argv[2]) > 0 &&
        atoi(argv[2]) <= 16)
        return grow(atoi(argv[2]), argv[3], argv[4]);
    fprintf(stderr, "usage: bench_stb [--grow 1..16] FILE.hdr [OUT.hdr]\n");
    return 2;
}
