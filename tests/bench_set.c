/* SPDX-License-Identifier: MIT */
/*
 * Writes a set of captures for `iblbake probes`: six faces each, of a room with
 * tiles and lamps seen from the points of a grid.
 *
 *     bench_set DIR COUNT SIZE
 *
 * makes DIR/set.json and DIR/N_F.hdr (RGBE, flat).
 */
#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>

#include "ibl/ibl.h"

static const double half[3] = {8, 2, 8};

static double noise(int a, int b, int c)
{
    unsigned x = (unsigned)a * 73856093u ^ (unsigned)b * 19349663u ^
                 (unsigned)c * 83492791u;

    x ^= x >> 13;
    x *= 0x5bd1e995u;
    return (double)((x ^ x >> 15) & 0xFFFF) / 65536;
}

/* What a ray from inside meets: tiles of noise and of different shades, on the
 * ceiling lamps, and windows with a sky. */
static void trace(const double from[3], const double dir[3], float rgb[3])
{
    double t = HUGE_VAL, at[3];
    int axis = 0;

    for (int k = 0; k < 3; k++) {
        const double to = (copysign(half[k], dir[k]) - from[k]) / dir[k];
        if (fabs(dir[k]) > 1e-12 && to < t)
            t = to, axis = k;
    }
    for (int k = 0; k < 3; k++)
        at[k] = from[k] + t * dir[k];
    const double u = at[axis ? 0 : 1], v = at[axis == 2 ? 1 : 2];
    const bool lamp =
        axis == 1 && dir[1] > 0 && fmod(u + 20, 4) < 0.5 && fmod(v + 20, 4) < 1;
    const bool window = axis != 1 && at[1] > -0.5 && at[1] < 1.2 &&
                        fmod(at[axis ? 0 : 2] + 20, 3) < 1;
    const double tile =
        0.3 + 0.4 * noise((int)floor(2 * u), (int)floor(2 * v), axis) +
        0.2 * noise((int)floor(40 * u), (int)floor(40 * v), axis);
    for (int k = 0; k < 3; k++)
        rgb[k] = (float)(lamp     ? 60 - 12 * k
                         : window ? 4 + 2 * k + 3 * dir[1]
                                  : tile * (k == axis ? 0.9 : 0.5));
}

/* ---- files ------------------------------------------------------------- */

static bool write_hdr(const char *path, int n, const float *rgb)
{
    FILE *f = fopen(path, "wb");

    if (!f)
        return false;
    fprintf(f, "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y %d +X %d\n", n, n);
    for (int i = 0; i < n * n; i++, rgb += 3) {
        int e;
        const double most = fmax(rgb[0], fmax(rgb[1], rgb[2]));
        const double scale = frexp(most, &e) * 256 / most;
        for (int k = 0; k < 3; k++)
            putc((int)(rgb[k] * scale), f);
        putc(e + 128, f);
    }
    return !fclose(f);
}

/* ---- the set ----------------------------------------------------------- */

typedef struct set {
    const char *directory;
    int count, size;
    FILE *json;
} set;

static bool write_faces(const set *s, int probe, const double at[3])
{
    const int n = s->size;
    float *rgb = malloc(3 * sizeof *rgb * (size_t)n * (size_t)n);
    bool ok = rgb;

    for (int f = 0; f < IBL_FACES && ok; f++) {
        char path[4096];
        for (int i = 0; i < n * n; i++) {
            double dir[3];
            ibl_cube_direction(n, f, i % n, i / n, dir);
            trace(at, dir, rgb + 3 * i);
        }
        snprintf(path, sizeof path, "%s/%d_%d.hdr", s->directory, probe, f);
        ok = write_hdr(path, n, rgb);
    }
    free(rgb);
    return ok;
}

static bool write_probe(const set *s, int i)
{
    const int edge = (int)ceil(sqrt(s->count));
    const double at[3] = {7.0 * (2 * (i % edge) + 1) / edge - 7, 0.1,
                          7.0 * (2 * (i / edge) + 1) / edge - 7};

    fprintf(
        s->json,
        "%s\n{\"name\": \"p%d\", \"position\": [%g, %g, %g],\n \"influence\":"
        " {\"box\": {\"centre\": [%g, %g, %g], \"half\": [2, 2, 2]}},\n"
        " \"capture\": {\"faces\": [",
        i ? "," : "", i, at[0], at[1], at[2], at[0], at[1], at[2]);
    for (int f = 0; f < IBL_FACES; f++)
        fprintf(s->json, "%s\"%d_%d.hdr\"", f ? ", " : "", i, f);
    fprintf(s->json, "]}}");
    return write_faces(s, i, at);
}

int main(int argc, char **argv)
{
    char path[4096];
    set s = {0};

    if (argc == 4)
        s = (set){argv[1], atoi(argv[2]), atoi(argv[3]), NULL};
    if (s.count < 1 || s.size < 1 || s.size > 4096) {
        fprintf(stderr, "usage: bench_set DIR COUNT SIZE\n");
        return 2;
    }
    snprintf(path, sizeof path, "%s/set.json", s.directory);
    s.json = fopen(path, "w");
    if (!s.json) {
        perror(path);
        return 1;
    }
    fprintf(s.json,
            "{\"version\": 1, \"defaults\": {\"size\": %d},\n"
            " \"probes\": [",
            s.size);
    for (int i = 0; i < s.count; i++)
        if (!write_probe(&s, i)) {
            fprintf(stderr, "%s: cannot write the captures\n", s.directory);
            return 1;
        }
    fprintf(s.json, "]}\n");
    return fclose(s.json) ? 1 : 0;
}
