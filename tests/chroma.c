/* SPDX-License-Identifier: MIT */
/*
 * chroma FILE EXACT LEVEL MOST: says which texels of a level of a cube have
 * another chroma than those of another file, by more than MOST in CIE Lab, if
 * the mean luminance of the level is 0.4.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include <ibl/io.h>

/* a and b of the light that a screen shows: at most 1. */
static void chroma(const float rgb[3], double scale, double ab[2])
{
    double c[3], f[3];

    for (int i = 0; i < 3; i++)
        c[i] = fmin((double)rgb[i] * scale, 1);
    const double xyz[3] = {
        (0.4124 * c[0] + 0.3576 * c[1] + 0.1805 * c[2]) / 0.9505,
        0.2126 * c[0] + 0.7152 * c[1] + 0.0722 * c[2],
        (0.0193 * c[0] + 0.1192 * c[1] + 0.9505 * c[2]) / 1.089};
    for (int i = 0; i < 3; i++)
        f[i] = xyz[i] > 0.008856 ? cbrt(xyz[i]) : 7.787 * xyz[i] + 16.0 / 116;
    ab[0] = 500 * (f[0] - f[1]);
    ab[1] = 200 * (f[1] - f[2]);
}

static int read_cube(ibl_ctx *ctx, const char *path, ibl_cube *cube)
{
    ibl_texture tex = {0};
    const int failed = ibl_texture_read(ctx, path, &tex, NULL) ||
                       ibl_texture_to_cube(ctx, &tex, cube);

    ibl_texture_free(&tex);
    return failed;
}

int main(int argc, char **argv)
{
    ibl_ctx *ctx = NULL;
    ibl_cube got = {0}, want = {0};
    double mean = 0, worst = 0;

    if (argc != 5 || ibl_ctx_create(NULL, &ctx) ||
        read_cube(ctx, argv[1], &got) || read_cube(ctx, argv[2], &want) ||
        got.size != want.size || got.levels != want.levels)
        return fprintf(stderr, "not two cubes alike\n"), 2;
    const int level = atoi(argv[3]), n = ibl_cube_edge(got.size, level);
    const float *a = ibl_cube_face(&got, level, 0);
    const float *b = ibl_cube_face(&want, level, 0);
    const int count = 6 * n * n;
    for (int i = 0; i < count; i++)
        mean += (0.2126 * (double)b[3 * i] + 0.7152 * (double)b[3 * i + 1] +
                 0.0722 * (double)b[3 * i + 2]) /
                count;
    for (int i = 0; i < count; i++) {
        double p[2], q[2];
        chroma(a + (size_t)3 * i, 0.4 / mean, p);
        chroma(b + (size_t)3 * i, 0.4 / mean, q);
        worst = fmax(worst, hypot(p[0] - q[0], p[1] - q[1]));
    }
    if (!(worst <= atof(argv[4])))
        printf("%s: level %d of %dx%d: a chroma off by %.2f\n", argv[1], level,
               n, n, worst);
    if (getenv("IBL_TEST_VERBOSE"))
        fprintf(stderr, "%.2f of %s\n", worst, argv[4]);
    ibl_cube_free(&got);
    ibl_cube_free(&want);
    ibl_ctx_free(ctx);
    return 0;
}
