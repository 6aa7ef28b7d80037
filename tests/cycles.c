/* SPDX-License-Identifier: MIT */
/*
 * Spheres of F0 = 1, from smooth to rough, under a map: what the viewer's
 * reference and its split sum make of them against a picture by Cycles.
 *
 *     cycles scene                what is to be rendered, as JSON
 *     cycles map MAP              the map as the library reads it, as PFM:
 *                                 without the negative pixels that some have
 *     cycles compare MAP PICTURE  a line for each sphere
 *
 * Blender 3.4 multiplies the shadowing of N.L by the masking of N.V, where the
 * viewer has the height-correlated form of both. Their directional albedos are
 * computed here, and Cycles' pixels are multiplied by what the albedo of the
 * one is to that of the other: exact under a constant sky, within the bound
 * under others. Pixels whose neighbours see another sphere, or none, are left
 * out.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "ibl/io.h"
#include "sets.h"
#include "view.h"
#include "view/renderer.h"

enum {
    WIDTH = 640,
    HEIGHT = 160,
    SPHERES = 6,
    SAMPLES = 256,
    ANGLES = 64
};

/* Of the mean over a sphere: noise of both, and the ratio of albedos under a
 * sky that is not constant. */
static const double bound = 0.02;

static view_settings scene(void)
{
    view_settings s = view_settings_default();
    s.rows = 1;
    s.columns = SPHERES;
    s.metallic[0] = s.metallic[1] = 1;
    s.roughness[0] = 0;
    s.roughness[1] = 1;
    s.multiscatter = false;
    s.light_count = 0;
    s.compare = VIEW_SPLIT;
    for (int i = 0; i < VIEW_MATERIALS; i++)
        if (!strcmp(view_materials[i].name, "white"))
            s.material = i;
    return s;
}

static void print_vector(const char *name, const double v[3])
{
    printf("\"%s\": [%.9g, %.9g, %.9g]", name, v[0], v[1], v[2]);
}

static int print_scene(void)
{
    const view_settings s = scene();
    const view_camera c = view_camera_of(&s, WIDTH, HEIGHT);
    view_sphere spheres[VIEW_MAX_GRID * VIEW_MAX_GRID];
    const int count = view_grid(&s, spheres);
    const double up =
        sqrt(c.up[0] * c.up[0] + c.up[1] * c.up[1] + c.up[2] * c.up[2]);
    printf("{\"width\": %d, \"height\": %d, \"fov\": %.9g,\n", WIDTH, HEIGHT,
           2 * atan(up));
    print_vector("eye", c.eye);
    printf(", ");
    print_vector("right", c.right);
    printf(",\n");
    print_vector("up", c.up);
    printf(", ");
    print_vector("forward", c.forward);
    printf(",\n\"spheres\": [\n");
    for (int i = 0; i < count; i++) {
        printf("{\"radius\": %.9g, \"roughness\": %.9g, ", spheres[i].radius,
               spheres[i].roughness);
        print_vector("centre", spheres[i].centre);
        printf("}%s\n", i + 1 < count ? "," : "]}");
    }
    return 0;
}

/* Directional albedo of F = 1 by the distribution's own samples. */
static double albedo(double nv, double alpha, bool correlated)
{
    enum {
        STEPS = 256
    };
    const double a2 = alpha * alpha, s = sqrt(1 - nv * nv);
    double sum = 0;
    for (int i = 0; i < STEPS; i++) {
        const double u = (i + 0.5) / STEPS;
        const double nh = sqrt((1 - u) / (1 + (a2 - 1) * u));
        for (int j = 0; j < STEPS; j++) {
            const double phi = 2 * acos(-1) * (j + 0.5) / STEPS;
            const double vh = s * sqrt(1 - nh * nh) * cos(phi) + nv * nh;
            const double nl = 2 * vh * nh - nv;
            if (vh <= 0 || nl <= 0)
                continue;
            const double v = sqrt(a2 + (1 - a2) * nv * nv);
            const double l = sqrt(a2 + (1 - a2) * nl * nl);
            const double g = correlated ? 2 * nl * nv / (nl * v + nv * l)
                                        : 4 * nl * nv / ((nv + v) * (nl + l));
            sum += g * vh / (nv * nh);
        }
    }
    return sum / STEPS / STEPS;
}

/* The PFM's rows run from the bottom, its floats are those of this machine. */
static int print_map(const char *path)
{
    ibl_ctx *ctx;
    ibl_image image;
    const unsigned one = 1;
    if (ibl_ctx_create(NULL, &ctx) ||
        ibl_image_read(ctx, path, NULL, &image, NULL))
        return 1;
    const size_t row = 3 * (size_t)image.width;
    printf("PF\n%d %d\n%d\n", image.width, image.height,
           *(const unsigned char *)&one ? -1 : 1);
    for (int y = image.height - 1; y >= 0; y--)
        fwrite(image.data + row * (size_t)y, sizeof(float), row, stdout);
    ibl_image_free(&image);
    ibl_ctx_free(ctx);
    return fflush(stdout) != 0;
}

typedef struct tally {
    int pixels;
    double sum[3], square[2]; /* Cycles, reference, split sum; their errors */
} tally;

static double luminance(const float *rgb)
{
    return 0.2126 * (double)rgb[0] + 0.7152 * (double)rgb[1] +
           0.0722 * (double)rgb[2];
}

/* The sphere that a pixel and its neighbours see, with N.V; -1: not one. */
static int sphere_at(const view_sphere *spheres, int count,
                     const view_camera *c, int x, int y, double *nv)
{
    int found = -2;
    for (int j = -1; j <= 1; j++)
        for (int i = -1; i <= 1; i++) {
            double d[3], n[3];
            view_camera_ray(c, WIDTH, HEIGHT, x + i, y + j, d);
            const int k = view_grid_hit(spheres, count, c->eye, d, n);
            if (found != -2 && k != found)
                return -1;
            found = k;
            if (!i && !j)
                *nv = -(n[0] * d[0] + n[1] * d[1] + n[2] * d[2]);
        }
    return found;
}

static bool render(const char *map, const view_settings *s, float *truth,
                   float *split)
{
    baked_set set;
    ibl_ctx *ctx = NULL;
    ibl_image image = {0};
    ibl_specular_options o = ibl_specular_options_default();
    bool ok = !ibl_ctx_create(NULL, &ctx) &&
              !ibl_image_read(ctx, map, NULL, &image, NULL);
    o.size = 512;
    ok = ok && sets_bake_image(ctx, "map", &image, &o, &set);
    ibl_image_free(&image);
    if (!ok)
        return false;
    view_renderer *r = view_renderer_create();
    ok = r && view_renderer_load(r, &set);
    do
        ok = ok && view_renderer_draw(r, s, WIDTH, HEIGHT);
    while (ok && view_renderer_samples(r) < SAMPLES);
    ok = ok && view_renderer_read(r, true, truth) &&
         view_renderer_read(r, false, split);
    view_renderer_free(r);
    view_set_free(&set);
    ibl_ctx_free(ctx);
    return ok;
}

static bool read_picture(const char *path, ibl_image *image)
{
    ibl_ctx *ctx;
    ibl_read_options o = ibl_read_options_default();
    o.any_aspect = 1;
    if (ibl_ctx_create(NULL, &ctx))
        return false;
    const bool ok = !ibl_image_read(ctx, path, &o, image, NULL) &&
                    image->width == WIDTH && image->height == HEIGHT;
    ibl_ctx_free(ctx);
    return ok;
}

/* In a mirror a sun is some pixels, and where they are sampled decides what
 * they have of it: what is above most counts as that. */
static void add(tally *t, const float *cycles, const float *truth,
                const float *split, double gain, double most)
{
    const double c = fmin(luminance(cycles) * gain, most);
    const double r = fmin(luminance(truth), most);
    const double s = fmin(luminance(split), most);
    t->pixels++;
    t->sum[0] += c;
    t->sum[1] += r;
    t->sum[2] += s;
    t->square[0] += (r - c) * (r - c);
    t->square[1] += (s - c) * (s - c);
}

static int compare(const char *map, const char *picture)
{
    static float truth[3 * WIDTH * HEIGHT], split[3 * WIDTH * HEIGHT];
    const view_settings s = scene();
    const view_camera c = view_camera_of(&s, WIDTH, HEIGHT);
    view_sphere spheres[VIEW_MAX_GRID * VIEW_MAX_GRID];
    const int count = view_grid(&s, spheres);
    double gain[SPHERES][ANGLES + 1];
    tally tallies[SPHERES] = {0};
    ibl_image cycles = {0};
    int worse = 0;

    view_test_begin(WIDTH, HEIGHT);
    if (!read_picture(picture, &cycles) || !render(map, &s, truth, split)) {
        fprintf(stderr, "cycles: %s and %s cannot be compared\n", map, picture);
        return 1;
    }
    for (int k = 0; k < count; k++)
        for (int i = 0; i <= ANGLES; i++) {
            const double nv = i ? (double)i / ANGLES : 0.5 / ANGLES;
            const double alpha = spheres[k].roughness * spheres[k].roughness;
            gain[k][i] =
                alpha > 0 ? albedo(nv, alpha, true) / albedo(nv, alpha, false)
                          : 1;
        }
    for (int y = 0; y < HEIGHT; y++)
        for (int x = 0; x < WIDTH; x++) {
            double nv = 0;
            const int k = sphere_at(spheres, count, &c, x, y, &nv);
            const size_t at = 3 * ((size_t)y * WIDTH + (size_t)x);
            if (k < 0)
                continue;
            const int i = (int)(nv * ANGLES);
            const double t = nv * ANGLES - i;
            add(&tallies[k], cycles.data + at, truth + at, split + at,
                i < ANGLES ? gain[k][i] * (1 - t) + gain[k][i + 1] * t
                           : gain[k][ANGLES],
                spheres[k].roughness > 0 ? INFINITY : 10);
        }
    printf("sphere roughness  pixels  reference / Cycles  split sum / Cycles"
           "  nRMSE of both\n");
    for (int k = 0; k < count; k++) {
        const tally *t = &tallies[k];
        const double mean = t->sum[0] / t->pixels;
        printf("%6d %9.2f %7d %19.4f %19.4f %8.4f %.4f\n", k,
               spheres[k].roughness, t->pixels, t->sum[1] / t->sum[0],
               t->sum[2] / t->sum[0], sqrt(t->square[0] / t->pixels) / mean,
               sqrt(t->square[1] / t->pixels) / mean);
        worse += !(fabs(t->sum[1] / t->sum[0] - 1) <= bound);
    }
    ibl_image_free(&cycles);
    view_test_close();
    if (worse)
        printf("check-cycles: %d spheres are further from Cycles than %g\n",
               worse, bound);
    return worse > 0;
}

int main(int argc, char **argv)
{
    if (argc == 2 && !strcmp(argv[1], "scene"))
        return print_scene();
    if (argc == 3 && !strcmp(argv[1], "map"))
        return print_map(argv[2]);
    if (argc == 4 && !strcmp(argv[1], "compare"))
        return compare(argv[2], argv[3]);
    fprintf(stderr, "usage: cycles scene | map MAP | compare MAP PICTURE\n");
    return 2;
}
