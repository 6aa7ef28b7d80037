/* SPDX-License-Identifier: MIT */
/*
 * The error of sampled specular levels, beside those of cmgen of Filament.
 *
 *     make bench, or: build/tests/bench_quality --help
 *
 * Specular: at a set of texels per level, a third of them within 20 degrees
 * of the map's brightest pixel, the rest stratified over the sphere,
 *     nRMSE = sqrt(mean (x - t)^2) / sqrt(mean t^2)
 * over texels and channels, t the sum over every pixel of the source (level
 * 0: the source's average over the texel). Both programs are judged at the
 * same directions by the same code.
 */
#include "ibl/io.h"
#include "test.h"
#include "truth.h"

#include <getopt.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

static const double pi = 3.14159265358979323846;

typedef struct settings {
    const char *env; /* path */
    int texels;
    ibl_specular_options spec;
} settings;

/* One texel that is judged. */
typedef struct probe {
    int face, x, y, near; /* near: within 20 degrees of the brightest pixel */
    double dir[3], truth[3];
} probe;

typedef struct probes {
    int count, near;
    probe *list;
} probes;

typedef struct errors {
    double all, near, rest; /* nRMSE */
} errors;

static void *need(void *p)
{
    if (!p) {
        fprintf(stderr, "bench_quality: out of memory\n");
        exit(1);
    }
    return p;
}

/* ---- which texels ---------------------------------------------------- */

/* The texel that a direction falls in: the inverse of the cube rule. */
static void texel_of(int n, const double d[3], int *face, int *x, int *y)
{
    int axis = 0;
    for (int k = 1; k < 3; k++)
        if (fabs(d[k]) > fabs(d[axis]))
            axis = k;
    const int f = 2 * axis + (d[axis] < 0.0);
    const double u[6] = {-d[2], d[2], d[0], d[0], d[0], -d[0]};
    const double v[6] = {-d[1], -d[1], d[2], -d[2], -d[1], -d[1]};
    const double ma = fabs(d[axis]);
    const int i = (int)floor((u[f] / ma + 1.0) / 2.0 * n);
    const int j = (int)floor((v[f] / ma + 1.0) / 2.0 * n);
    *face = f;
    *x = i >= n ? n - 1 : i;
    *y = j >= n ? n - 1 : j;
}

static void brightest(const ibl_image *env, double dir[3])
{
    float best = -1.0f;
    int at = 0;
    for (int i = 0; i < env->width * env->height; i++) {
        const float *p = env->data + 3 * (size_t)i;
        if (p[0] + p[1] + p[2] > best) {
            best = p[0] + p[1] + p[2];
            at = i;
        }
    }
    truth_latlong_direction(env->width, env->height, at % env->width,
                            at / env->width, dir);
}

static probe probe_at(int n, int face, int x, int y, const double sun[3])
{
    probe p = {.face = face, .x = x, .y = y};
    truth_cube_direction(n, face, x, y, p.dir);
    p.near = p.dir[0] * sun[0] + p.dir[1] * sun[1] + p.dir[2] * sun[2] >
             cos(20.0 * pi / 180.0);
    return p;
}

/* Up to want of the texels near the sun, each once (selection sampling). */
static void pick_near(probes *set, int n, int want, const double sun[3],
                      test_random *r)
{
    int left = 0;
    for (int pass = 0; pass < 2; pass++) {
        for (int k = 0; k < 6 * n * n; k++) {
            const probe p = probe_at(n, k / (n * n), k % n, k / n % n, sun);
            if (!p.near)
                continue;
            if (pass == 0) {
                left++;
            } else if (test_random_unit(r) * left-- < want) {
                set->list[set->count++] = p;
                want--;
            }
        }
    }
    set->near = set->count;
}

/* One texel from each of `want` cells of equal solid angle, in a golden
 * spiral turned and shaken at random. */
static void pick_rest(probes *set, int n, int want, const double sun[3],
                      test_random *r)
{
    const double turn = test_random_unit(r);
    for (int k = 0; k < want; k++) {
        const double y = 1.0 - 2.0 * (k + test_random_unit(r)) / want;
        const double phi = 2.0 * pi * (turn + k * 0.6180339887498949);
        const double s = sqrt(1.0 - y * y);
        const double d[3] = {s * cos(phi), y, s * sin(phi)};
        int face, i, j;
        texel_of(n, d, &face, &i, &j);
        set->list[set->count++] = probe_at(n, face, i, j, sun);
    }
}

/* A third near the sun where the level has as many, at least 100 in all. */
static probes pick(const ibl_image *env, int n, int texels)
{
    probes set = {0, 0, need(calloc((size_t)texels, sizeof(probe)))};
    test_random r = {1};
    double sun[3];
    brightest(env, sun);
    pick_near(&set, n, texels / 3, sun, &r);
    const int rest = 2 * set.near < 100 - set.near ? 100 - set.near
                     : set.near == texels / 3      ? texels - set.near
                                                   : 2 * set.near;
    pick_rest(&set, n, rest, sun, &r);
    return set;
}

static void find_truth(probes *set, const ibl_image *env, int n, double r)
{
    for (int k = 0; k < set->count; k++) {
        probe *p = &set->list[k];
        if (r > 0.0)
            truth_specular(env, p->dir, r, p->truth);
        else
            truth_texel(env, n, p->face, p->x, p->y, 64, p->truth);
    }
}

/* ---- how far --------------------------------------------------------- */

static const float *texel(const ibl_cube *cube, int level, int face, int x,
                          int y)
{
    const size_t n = (size_t)ibl_cube_edge(cube->size, level);
    return ibl_cube_face(cube, level, face) + 3 * ((size_t)y * n + (size_t)x);
}

static double ratio(double squares, double norm)
{
    return norm > 0.0 ? sqrt(squares / norm) : 0.0;
}

static errors judge(const ibl_cube *cube, int level, const probes *set)
{
    double squares[2] = {0, 0}, norm[2] = {0, 0};
    for (int k = 0; k < set->count; k++) {
        const probe *p = &set->list[k];
        const float *x = texel(cube, level, p->face, p->x, p->y);
        for (int c = 0; c < 3; c++) {
            const double e = (double)x[c] - p->truth[c];
            squares[p->near] += e * e;
            norm[p->near] += p->truth[c] * p->truth[c];
        }
    }
    return (errors){ratio(squares[0] + squares[1], norm[0] + norm[1]),
                    ratio(squares[1], norm[1]), ratio(squares[0], norm[0])};
}

/* Mean radiance of a level over that of the source, over the channels. */
static double energy(const ibl_cube *cube, int level, const ibl_image *env)
{
    const int n = ibl_cube_edge(cube->size, level);
    double sum = 0.0, weights = 0.0, mean[3];
    for (int k = 0; k < 6 * n * n; k++) {
        const int x = k % n, y = k / n % n;
        const double u = (2 * x + 1.0) / n - 1.0, v = (2 * y + 1.0) / n - 1.0;
        const double w = pow(1.0 + u * u + v * v, -1.5);
        const float *p = texel(cube, level, k / (n * n), x, y);
        sum += w * ((double)p[0] + (double)p[1] + (double)p[2]);
        weights += w;
    }
    truth_mean(env, mean);
    return sum / weights / (mean[0] + mean[1] + mean[2]);
}

/* ---- cmgen ----------------------------------------------------------- */

/* Runs cmgen into dir; false if it is not there or fails. */
static bool run_cmgen(const settings *s, const char *dir)
{
    char ld[512], size[32], samples[48];
    int status;
    snprintf(ld, sizeof ld, "--ibl-ld=%s", dir);
    snprintf(size, sizeof size, "--size=%d", s->spec.size);
    snprintf(samples, sizeof samples, "--ibl-samples=%d", s->spec.samples);
    const pid_t pid = fork();
    if (pid == 0) {
        execlp("cmgen", "cmgen", "-q", "--format=exr", size, samples, ld,
               s->env, (char *)NULL);
        _exit(127);
    }
    return pid > 0 && waitpid(pid, &status, 0) == pid && status == 0;
}

/* Reads DIR/mLEVEL_FACE.exr as they are. */
static bool read_faces(ibl_ctx *ctx, const char *dir, ibl_cube *cube)
{
    static const char *const names[] = {"px", "nx", "py", "ny", "pz", "nz"};
    ibl_read_options opts = ibl_read_options_default();
    opts.any_aspect = 1;
    for (int k = 0; k < 6 * cube->levels; k++) {
        const int n = ibl_cube_edge(cube->size, k / 6);
        char path[600];
        ibl_image img;
        snprintf(path, sizeof path, "%s/m%d_%s.exr", dir, k / 6, names[k % 6]);
        if (ibl_image_read(ctx, path, &opts, &img, NULL))
            return false;
        const bool fits = img.width == n && img.height == n;
        if (fits)
            memcpy(ibl_cube_face(cube, k / 6, k % 6), img.data,
                   3 * sizeof(float) * (size_t)n * (size_t)n);
        ibl_image_free(&img);
        if (!fits) {
            fprintf(stderr, "%s: not %d x %d\n", path, n, n);
            return false;
        }
    }
    return true;
}

/* The k-th of the 48 symmetries of the cube: signs and order of the axes. */
static void symmetry(int k, const double d[3], double e[3])
{
    static const int order[6][3] = {{0, 1, 2}, {0, 2, 1}, {1, 0, 2},
                                    {1, 2, 0}, {2, 0, 1}, {2, 1, 0}};
    for (int c = 0; c < 3; c++)
        e[c] = (k >> c & 1 ? -1.0 : 1.0) * d[order[k / 8][c]];
}

/* dst's texel at d is src's at symmetry(d). */
static void turn_level(const ibl_cube *src, int level, int sym, ibl_cube *dst)
{
    const int n = ibl_cube_edge(src->size, level);
    float *out = ibl_cube_face(dst, level, 0);
    for (int k = 0; k < 6 * n * n; k++) {
        double d[3], e[3];
        int face, x, y;
        truth_cube_direction(n, k / (n * n), k % n, k / n % n, d);
        symmetry(sym, d, e);
        texel_of(n, e, &face, &x, &y);
        memcpy(out + 3 * (size_t)k, texel(src, level, face, x, y),
               3 * sizeof(float));
    }
}

/*
 * Which way cmgen's cube lies is measured: of the 48 symmetries the one whose
 * level 1 is nearest to the truth. Turns all levels of raw into cube.
 */
static void align(const ibl_cube *raw, const probes *set, ibl_cube *cube)
{
    double best = INFINITY, next = INFINITY, axes[3];
    const double xyz[3] = {1, 2, 3};
    const int level = raw->levels > 1;
    int sym = 0;
    for (int k = 0; k < 48; k++) {
        turn_level(raw, level, k, cube);
        const double e = judge(cube, level, set).all;
        if (e < best) {
            next = best;
            best = e;
            sym = k;
        } else {
            next = fmin(next, e);
        }
    }
    for (int l = 0; l < raw->levels; l++)
        turn_level(raw, l, sym, cube);
    symmetry(sym, xyz, axes);
    printf("cmgen's cube: its x y z are our");
    for (int c = 0; c < 3; c++)
        printf(" %c%c", axes[c] < 0 ? '-' : '+', "xyz"[(int)fabs(axes[c]) - 1]);
    printf("; level %d nRMSE %.3f so, %.3f the next best way\n", level, best,
           next);
}

/* cmgen's levels in our convention; false with a word if there are none. */
static bool cmgen_cube(ibl_ctx *ctx, const settings *s, const probes *set,
                       ibl_cube *cube)
{
    const char *stem = strrchr(s->env, '/');
    char dir[512];
    ibl_cube raw = {0};
    bool ok = false;
    stem = stem ? stem + 1 : s->env;
    const double start = test_ms(CLOCK_MONOTONIC);
    if (!run_cmgen(s, test_dir())) {
        printf("cmgen (Debian: libfilament-tools) did not run\n");
        return false;
    }
    printf("cmgen --ibl-ld: %.3f s with its start, decoding, level 0\n",
           1e-3 * (test_ms(CLOCK_MONOTONIC) - start));
    snprintf(dir, sizeof dir, "%s/%.*s", test_dir(), (int)strcspn(stem, "."),
             stem);
    if (ibl_cube_alloc(ctx, s->spec.size, s->spec.levels, &raw) == 0 &&
        ibl_cube_alloc(ctx, s->spec.size, s->spec.levels, cube) == 0 &&
        read_faces(ctx, dir, &raw)) {
        align(&raw, set, cube);
        ok = true;
    }
    ibl_cube_free(&raw);
    return ok;
}

/* ---- specular -------------------------------------------------------- */

static void print_row(const errors e[2], const double power[2], int programs)
{
    printf("  %7.4f %7.4f %7.4f %7.4f", e[0].all, e[0].near, e[0].rest,
           power[0]);
    if (programs == 2)
        printf("  %7.4f %7.4f %7.4f %7.4f  %7.4f", e[1].all, e[1].near,
               e[1].rest, power[1], e[0].all / e[1].all);
    putchar('\n');
}

static void print_head(int programs)
{
    printf("nRMSE over texels and channels; near: within 20 degrees of the "
           "brightest pixel\n");
    printf("                     iblbake                        ");
    if (programs == 2)
        printf("  cmgen                            ");
    printf("\nlevel  r      texels   all    near    rest  energy");
    if (programs == 2)
        printf("     all    near    rest  energy   ratio");
    putchar('\n');
}

static void print_table(const settings *s, const ibl_image *env,
                        const probes *sets, const ibl_cube *cubes, int programs)
{
    print_head(programs);
    /* Where level 0 magnifies, the library interpolates between pixels. */
    if (env->width < 4 * s->spec.size)
        printf("    0  0.0000      -  (the map's pixels are larger than its "
               "texels)\n");
    for (int l = env->width < 4 * s->spec.size; l < s->spec.levels; l++) {
        errors e[2];
        double power[2];
        for (int k = 0; k < programs; k++) {
            e[k] = judge(&cubes[k], l, &sets[l]);
            power[k] = energy(&cubes[k], l, env);
        }
        printf("%5d  %.4f %6d", l,
               ibl_level_roughness(s->spec.mapping, l, s->spec.levels),
               sets[l].count);
        print_row(e, power, programs);
    }
}

static int bench_specular(ibl_ctx *ctx, const settings *s, const ibl_image *env)
{
    const int levels = s->spec.levels;
    probes sets[IBL_MAX_LEVELS] = {{0, 0, NULL}};
    ibl_cube cubes[2] = {{0}, {0}};
    int programs = 1, failed = 1;
    for (int l = 0; l < levels; l++) {
        const int n = ibl_cube_edge(s->spec.size, l);
        sets[l] = pick(env, n, s->texels);
        find_truth(&sets[l], env, n,
                   ibl_level_roughness(s->spec.mapping, l, levels));
    }
    const double start = test_ms(CLOCK_MONOTONIC);
    if (ibl_bake_specular(ctx, env, &s->spec, &cubes[0]))
        goto done;
    printf("%s, %d x %d; size %d, %d levels, %s, %d samples, bias %g%s\n",
           s->env, env->width, env->height, s->spec.size, levels,
           ibl_roughness_map_name(s->spec.mapping), s->spec.samples,
           s->spec.lod_bias, s->spec.jitter ? ", jitter" : "");
    printf("ibl_bake_specular: %.3f s, %d threads, %s\n",
           1e-3 * (test_ms(CLOCK_MONOTONIC) - start), ibl_ctx_threads(ctx),
           ibl_isa_name(ibl_ctx_isa(ctx)));
    if (cmgen_cube(ctx, s, &sets[levels > 1], &cubes[1]))
        programs = 2;
    print_table(s, env, sets, cubes, programs);
    failed = 0;
done:
    for (int l = 0; l < levels; l++)
        free(sets[l].list);
    ibl_cube_free(&cubes[0]);
    ibl_cube_free(&cubes[1]);
    return failed;
}

static void usage(FILE *f)
{
    fputs("usage: bench_quality [options] [ENV]\n"
          "ENV defaults to ../shared/data/quarry_01_1k.hdr\n"
          "  --samples N       per texel, for both programs (1024)\n"
          "  --size N          edge of level 0 (256)\n"
          "  --levels N        (5: the number cmgen makes of 256)\n"
          "  --texels N        judged per level, at least 100 (999)\n",
          f);
}

static settings parse(int argc, char **argv)
{
    static const struct option options[] = {
        {"samples", 1, NULL, 's'}, {"size", 1, NULL, 'n'},
        {"levels", 1, NULL, 'l'},  {"texels", 1, NULL, 't'},
        {"help", 0, NULL, 'h'},    {NULL, 0, NULL, 0}};
    settings s = {.texels = 999, .spec = ibl_specular_options_default()};

    s.spec.method = IBL_METHOD_SAMPLED;
    s.spec.mapping = IBL_ROUGHNESS_FILAMENT;
    s.spec.size = 256;
    s.spec.levels = 5;
    for (int c; (c = getopt_long(argc, argv, "", options, NULL)) != -1;) {
        int *value = c == 's'   ? &s.spec.samples
                     : c == 'n' ? &s.spec.size
                     : c == 'l' ? &s.spec.levels
                     : c == 't' ? &s.texels
                                : NULL;
        if (!value) {
            usage(c == 'h' ? stdout : stderr);
            exit(c == 'h' ? 0 : 2);
        }
        *value = atoi(optarg);
    }
    s.env = optind < argc ? argv[optind] : test_shared_data("quarry_01_1k.hdr");
    if (s.texels < 100 || s.spec.levels < 1 || s.spec.levels > IBL_MAX_LEVELS) {
        usage(stderr);
        exit(2);
    }
    return s;
}

int main(int argc, char **argv)
{
    const settings s = parse(argc, argv);
    ibl_ctx *ctx = test_ctx(0, IBL_ISA_AUTO);
    ibl_image env;
    int failed = 0;

    setvbuf(stdout, NULL, _IOLBF, 0);
    if (!s.env) {
        printf("skipped: ../shared/data/quarry_01_1k.hdr is not here\n");
    } else if (!ibl_image_read(ctx, s.env, NULL, &env, NULL)) {
        failed = bench_specular(ctx, &s, &env);
        ibl_image_free(&env);
    } else {
        failed = 1;
    }
    ibl_ctx_free(ctx);
    return failed;
}
