/* SPDX-License-Identifier: MIT */
/*
 * The mip chain. A texel of a level covers 2x2 texels of the level above or,
 * where the edge above is odd, parts of 3x3: with n texels above and m below,
 * texel x covers x n/m to (x + 1) n/m of them. Each part is weighted by its
 * solid angle, so every level has the energy of the one above.
 */
#include "core/alloc.h"
#include "core/context.h"
#include "image/cube.h"

enum {
    MAX_TAPS = 3
};

typedef struct mips {
    const ibl_cube *cube;
    int level;       /* index of the level to fill */
    int n, m;        /* edge of the level above and of this level */
    int taps;        /* texels above that one texel covers along an edge */
    double *scratch; /* scratch_size doubles for each worker */
    size_t scratch_size;
} mips;

/* Position in -1..1 of border k = 0..taps * m of the parts. Those of texel x
 * begin at k = taps * x. */
static double cut(const mips *a, int k)
{
    const int x = k / a->taps, i = k % a->taps;
    /* Along an odd edge the first part begins inside a texel. */
    const double at = i ? 2.0 * x + i : x * (double)a->n / a->m;
    return 2 * at / a->n - 1;
}

/*
 * Weights of the parts of row y: taps * taps for each texel, summing to 1.
 * lines: scratch of taps + 1 rows of taps * m + 1.
 */
static void row_weights(const mips *a, int y, double *lines, double *weights)
{
    const int taps = a->taps, cuts = taps * a->m + 1;
    for (int j = 0; j <= taps; j++) {
        const double v = cut(a, taps * y + j);
        for (int k = 0; k < cuts; k++)
            lines[j * cuts + k] = ibl_face_angle(cut(a, k), v);
    }
    for (int x = 0; x < a->m; x++) {
        double *w = weights + x * taps * taps, sum = 0;
        for (int j = 0; j < taps; j++) {
            const double *top = lines + j * cuts + x * taps;
            const double *bottom = top + cuts;
            for (int i = 0; i < taps; i++) {
                const double angle =
                    (bottom[i + 1] - bottom[i]) - (top[i + 1] - top[i]);
                w[j * taps + i] = angle;
                sum += angle;
            }
        }
        for (int k = 0; k < taps * taps; k++)
            w[k] /= sum;
    }
}

/* flip: use the weights of the mirrored row. */
static void fill_row(const mips *a, int face, int y, bool flip,
                     const double *weights)
{
    const int taps = a->taps;
    const float *above = ibl_cube_face(a->cube, a->level - 1, face);
    float *dst =
        ibl_cube_face(a->cube, a->level, face) + 3 * (size_t)y * (size_t)a->m;
    for (int x = 0; x < a->m; x++) {
        double r = 0, g = 0, b = 0;
        for (int j = 0; j < taps; j++) {
            const double *w =
                weights + (x * taps + (flip ? taps - 1 - j : j)) * taps;
            const float *src =
                above + 3 * ((size_t)(2 * y + j) * (size_t)a->n + 2 * x);
            for (int i = 0; i < taps; i++) {
                r += w[i] * src[3 * i];
                g += w[i] * src[3 * i + 1];
                b += w[i] * src[3 * i + 2];
            }
        }
        dst[3 * x] = (float)r;
        dst[3 * x + 1] = (float)g;
        dst[3 * x + 2] = (float)b;
    }
}

/* Fills row y and its mirror image, on every face: they share weights. */
static void fill_job(void *arg, int y, int worker)
{
    const mips *a = arg;
    double *weights = a->scratch + a->scratch_size * (size_t)worker;
    const int mirror = a->m - 1 - y;
    row_weights(a, y, weights + a->taps * a->taps * a->m, weights);
    for (int face = 0; face < IBL_FACES; face++) {
        fill_row(a, face, y, false, weights);
        if (mirror != y)
            fill_row(a, face, mirror, true, weights);
    }
}

ibl_status ibl_cube_build_mips(ibl_ctx *ctx, ibl_cube *cube)
{
    mips a = {.cube = cube};
    ibl_status status = ibl_check_cube(ctx, cube);
    if (status)
        return status;

    /* Enough for the level with the most texels and taps; see row_weights. */
    const size_t m = (size_t)cube->size / 2;
    a.scratch_size =
        m * MAX_TAPS * MAX_TAPS + (MAX_TAPS + 1) * (MAX_TAPS * m + 1);
    a.scratch = ibl_alloc_array(a.scratch_size * ibl_ctx_threads(ctx),
                                sizeof *a.scratch);
    if (!a.scratch)
        return ibl_no_memory(ctx, "a mip chain");

    ibl_progress(ctx, "mips", 0);
    for (a.level = 1; a.level < cube->levels && !status; a.level++) {
        a.n = ibl_cube_edge(cube->size, a.level - 1);
        a.m = ibl_cube_edge(cube->size, a.level);
        a.taps = a.n % 2 ? 3 : 2;
        status = ibl_run(ctx, NULL, (a.m + 1) / 2, fill_job, &a);
    }
    if (!status)
        ibl_progress(ctx, "mips", 1);
    ibl_free(a.scratch);
    return status;
}
