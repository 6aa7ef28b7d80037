/* SPDX-License-Identifier: MIT */
/*
 * stb_image (package libstb-dev) as a process of its own, to measure beside.
 *
 *     bench_stb FILE.hdr
 *
 * decodes the file and prints "ms N": reading it and decoding to floats, in
 * memory that the system hands out on the way.
 */
#include <stdio.h>
#include <time.h>

#include "test.h"

#if __has_include(<stb/stb_image.h>)
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wconversion"
#pragma GCC diagnostic ignored "-Wmissing-prototypes"
#pragma GCC diagnostic ignored "-Wunused-function"
#define STBI_ONLY_HDR
#define STB_IMAGE_IMPLEMENTATION
#include <stb/stb_image.h>
#pragma GCC diagnostic pop
#else
#error "package libstb-dev is missing"
#endif

static int decode(const char *path)
{
    int w, h, n;
    const double begin = test_ms(CLOCK_MONOTONIC);
    float *px = stbi_loadf(path, &w, &h, &n, 3);
    const double end = test_ms(CLOCK_MONOTONIC);

    if (!px) {
        fprintf(stderr, "%s: %s\n", path, stbi_failure_reason());
        return 1;
    }
    /* Not freed before the clock is read, and used. */
    if (px[3 * (size_t)w * (size_t)h / 2] >= 0)
        printf("ms %.3f\n", end - begin);
    stbi_image_free(px);
    return 0;
}

int main(int argc, char **argv)
{
    if (argc == 2)
        return decode(argv[1]);
    fprintf(stderr, "usage: bench_stb FILE.hdr\n");
    return 2;
}
