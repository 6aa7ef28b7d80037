/* SPDX-License-Identifier: MIT */
/*
 * Spheres of F0 = 1 and roughness 0.15 to 1 under a map: what the viewer draws
 * of them, in each of its ways to look up a reflection, against a picture by
 * Cycles.
 *
 *     cycles scene       what is to be rendered, as JSON
 *     cycles map MAP     the map as the library reads it, as PFM: without the
 *                        negative pixels that some have
 *     cycles compare MAP LINEAR SET PICTURE
 *                        errors of both sets of the map, with the linear
 *                        mapping of levels and the default one
 *     cycles scene MODEL, cycles compare SET MODEL PICTURE
 *                        the same of a model, whose materials alternate between
 *                        white metals of three roughnesses and matte ones
 *
 * Blender 3.4 multiplies the shadowing of N.L by the masking of N.V, where the
 * viewer has the height-correlated form of both. Cycles' pixels are multiplied
 * by the ratio of both reflections, summed over the map. Pixels whose
 * neighbours see another sphere, or none, are left out.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "ibl/io.h"
#include "scene/scene.h"
#include "truth.h"
#include "view.h"
#include "view/renderer.h"
#include "view/vector.h"
#include "json/text.h"

enum {
    WIDTH = 600,
    HEIGHT = 100,
    PIXELS = WIDTH * HEIGHT,
    SPHERES = 6,
    SAMPLES = 1024,
    ROWS = 64, /* of lights, and twice as many columns */
    LOOKUPS = 6,
    MODEL_WIDTH = 300, /* of the picture of a model */
    MODEL_HEIGHT = PIXELS / MODEL_WIDTH
};

/* Of the reference's mean over a sphere: noise of both. */
static const double bound = 0.01;
static const double model_bound = 0.05;

/* From what everyone draws to the truth. */
static const struct {
    const char *name;
    bool linear; /* mapping of levels */
    view_reflection reflection;
    double most; /* of the nRMSE of the one before, mean over the spheres */
} lookups[LOOKUPS] = {
    {"split, linear", true, VIEW_SPLIT_SUM, INFINITY},
    {"split", false, VIEW_SPLIT_SUM, 1},
    {"fit", false, VIEW_FIT, 0.88},
    {"table", false, VIEW_TABLE_LOBES, 1},
    {"four-taps", false, VIEW_FOUR_TAPS, 0.95},
    {"reference", false, VIEW_REFERENCE, 0.7},
};

static view_settings scene(void)
{
    view_settings s = view_settings_default();
    s.rows = 1;
    s.columns = SPHERES;
    s.metallic[0] = s.metallic[1] = 1;
    s.fov = 6; /* nearly parallel rays */
    s.roughness[0] = 0.15;
    s.roughness[1] = 1;
    s.multiscatter = false;
    s.light_count = 0;
    s.material = ibl_names_find(view_material_names, "white");
    return s;
}

static void print_vector(const char *name, const double v[3])
{
    printf("\"%s\": [%.9g, %.9g, %.9g]", name, v[0], v[1], v[2]);
}

static void print_camera(const view_settings *s, int width, int height)
{
    const view_camera c = view_camera_of(s, width, height);
    const double up =
        sqrt(c.up[0] * c.up[0] + c.up[1] * c.up[1] + c.up[2] * c.up[2]);
    printf("{\"width\": %d, \"height\": %d, \"fov\": %.9g,\n", width, height,
           2 * atan(up));
    print_vector("eye", c.eye);
    printf(", ");
    print_vector("right", c.right);
    printf(",\n");
    print_vector("up", c.up);
    printf(", ");
    print_vector("forward", c.forward);
}

static int print_scene(void)
{
    const view_settings s = scene();
    view_sphere spheres[VIEW_MAX_GRID * VIEW_MAX_GRID];
    const int count = view_grid(&s, spheres);
    print_camera(&s, WIDTH, HEIGHT);
    printf(",\n\"spheres\": [\n");
    for (int i = 0; i < count; i++) {
        printf("{\"radius\": %.9g, \"roughness\": %.9g, ", spheres[i].radius,
               spheres[i].roughness);
        print_vector("centre", spheres[i].centre);
        printf("}%s\n", i + 1 < count ? "," : "]}");
    }
    return 0;
}

/* The light of a patch of the map, and the direction of its middle. */
typedef struct patch {
    double light, direction[3];
} patch;

static void find_patches(const ibl_image *map, patch patches[2 * ROWS * ROWS])
{
    const int w = map->width, h = map->height;

    for (int y = 0; y < h; y++)
        for (int x = 0; x < w; x++) {
            const float *rgb =
                map->data + 3 * ((size_t)y * (size_t)w + (size_t)x);
            const int column = (int)(2LL * ROWS * x / w);
            patch *p =
                &patches[(int)((long long)ROWS * y / h) * 2 * ROWS + column];
            double d[3];
            const double light =
                truth_latlong_solid_angle(w, h, y) *
                ((double)rgb[0] + (double)rgb[1] + (double)rgb[2]);
            truth_latlong_direction(w, h, x, y, d);
            p->light += light;
            for (int k = 0; k < 3; k++)
                p->direction[k] += light * d[k];
        }
    for (int i = 0; i < 2 * ROWS * ROWS; i++)
        if (patches[i].light > 0)
            normalise3(patches[i].direction);
}

/* What a sphere reflects with the height-correlated shadowing, over the
 * reflection with the product of both. */
static double gain(const patch *patches, const double n[3], const double v[3],
                   double alpha)
{
    const double a2 = alpha * alpha, nv = dot3(n, v);
    const double lv = sqrt(a2 + (1 - a2) * nv * nv);
    double correlated = 0, product = 0;

    for (const patch *p = patches; p < patches + 2 * ROWS * ROWS; p++) {
        const double nl = dot3(n, p->direction);
        if (nl <= 0 || p->light <= 0)
            continue;
        const double vl = dot3(v, p->direction);
        const double nh2 = (nl + nv) * (nl + nv) / (2 + 2 * vl);
        const double t = 1 - (1 - a2) * nh2, d = p->light / (t * t);
        const double ll = sqrt(a2 + (1 - a2) * nl * nl);
        correlated += d * nl / (2 * (nl * lv + nv * ll));
        product += d * nl / ((nl + ll) * (nv + lv));
    }
    return product > 0 ? correlated / product : 1;
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

/* The sphere that a pixel and its neighbours see, with the normal and the
 * direction to the eye; -1: not one. */
static int sphere_at(const view_sphere *spheres, int count,
                     const view_camera *c, int x, int y, double normal[3],
                     double view[3])
{
    int found = -2;
    for (int j = -1; j <= 1; j++)
        for (int i = -1; i <= 1; i++) {
            double d[3], n[3];
            view_test_ray(c, WIDTH, HEIGHT, x + i, y + j, d);
            const int k = view_test_hit(spheres, count, c->eye, d, n);
            if (found != -2 && k != found)
                return -1;
            found = k;
            for (int m = 0; m < 3 && !i && !j; m++) {
                normal[m] = n[m];
                view[m] = -d[m];
            }
        }
    return found;
}

/* Which sphere each pixel shows, and Cycles' picture as if its shadowing were
 * the viewer's. */
static void find_spheres(const view_settings *s, const ibl_image *map,
                         float *cycles, int *shown)
{
    static patch patches[2 * ROWS * ROWS];
    const view_camera c = view_camera_of(s, WIDTH, HEIGHT);
    view_sphere spheres[VIEW_MAX_GRID * VIEW_MAX_GRID];
    const int count = view_grid(s, spheres);

    find_patches(map, patches);
    for (int at = 0; at < PIXELS; at++) {
        double n[3], v[3];
        const int k =
            sphere_at(spheres, count, &c, at % WIDTH, at / WIDTH, n, v);

        shown[at] = k;
        if (k < 0)
            continue;
        const double r = spheres[k].roughness, g = gain(patches, n, v, r * r);
        for (int j = 3 * at; j < 3 * at + 3; j++)
            cycles[j] = (float)(cycles[j] * g);
    }
}

static bool draw(const baked_set *set, view_reflection reflection, float *rgb)
{
    view_settings s = scene();
    view_renderer *r = view_renderer_create();
    bool ok = r && view_renderer_load(r, set);

    s.reflection = reflection;
    do
        ok = ok && view_test_draw(r, &s, WIDTH, HEIGHT);
    while (ok && reflection == VIEW_REFERENCE &&
           view_renderer_samples(r) < SAMPLES);
    ok = ok && view_renderer_read(r, false, rgb);
    view_renderer_free(r);
    return ok;
}

typedef struct figures {
    double mean, nrmse, median, p95; /* % */
} figures;

static int compare_doubles(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* Errors of the pixels of a sphere, as lengths over R, G and B. */
static figures measure(const float *picture, const float *truth,
                       const int *shown, int sphere)
{
    static double error[PIXELS];
    double seen = 0, whole = 0, square = 0, power = 0;
    int count = 0;

    for (int i = 0; i < PIXELS; i++) {
        double d2 = 0, t2 = 0;
        for (int j = 3 * i; j < 3 * i + 3 && shown[i] == sphere; j++) {
            const double p = picture[j], t = truth[j];
            seen += p;
            whole += t;
            d2 += (p - t) * (p - t);
            t2 += t * t;
        }
        square += d2;
        power += t2;
        if (t2 > 0)
            error[count++] = 100 * sqrt(d2 / t2);
    }
    qsort(error, (size_t)count, sizeof *error, compare_doubles);
    return (figures){100 * (seen / whole - 1), 100 * sqrt(square / power),
                     error[count / 2], error[count * 95 / 100]};
}

/* Returns whether a bound does not hold. */
static int print_figures(const char *name, figures f, bool holds)
{
    printf("  %-14s %+6.1f %6.1f %6.1f %6.1f%s\n", name, f.mean, f.nrmse,
           f.median, f.p95, holds ? "" : " !");
    return !holds;
}

/* A block for each sphere, and one of their means. Returns the number of
 * bounds that do not hold. */
static int print_errors(figures f[LOOKUPS][SPHERES])
{
    const view_settings s = scene();
    view_sphere spheres[VIEW_MAX_GRID * VIEW_MAX_GRID];
    double before = 1;
    int broken = 0;

    view_grid(&s, spheres);
    printf("%%                mean  nRMSE median    p95\n");
    for (int k = 0; k < SPHERES; k++) {
        printf("roughness %.2f\n", spheres[k].roughness);
        for (int i = 0; i < LOOKUPS; i++)
            broken += print_figures(lookups[i].name, f[i][k],
                                    lookups[i].reflection != VIEW_REFERENCE ||
                                        fabs(f[i][k].mean) <= 100 * bound);
    }
    printf("means, of |mean|, too\n");
    for (int i = 0; i < LOOKUPS; i++) {
        figures m = {0};
        for (int k = 0; k < SPHERES; k++) {
            m.mean += fabs(f[i][k].mean) / SPHERES;
            m.nrmse += f[i][k].nrmse / SPHERES;
            m.median += f[i][k].median / SPHERES;
            m.p95 += f[i][k].p95 / SPHERES;
        }
        broken += print_figures(lookups[i].name, m,
                                m.nrmse <= lookups[i].most * before);
        before = m.nrmse;
    }
    return broken;
}

static int compare(const char *const paths[2], char *const sets[2])
{
    static float rgb[3 * PIXELS];
    static int shown[PIXELS];
    const view_settings s = scene();
    ibl_read_options o = ibl_read_options_default();
    figures f[LOOKUPS][SPHERES];
    static baked_set set[2];
    ibl_image map = {0}, cycles = {0};
    ibl_ctx *ctx = view_test_ctx(0);

    view_test_begin(WIDTH, HEIGHT);
    o.any_aspect = 1;
    bool ok = !ibl_image_read(ctx, paths[0], NULL, &map, NULL) &&
              !ibl_image_read(ctx, paths[1], &o, &cycles, NULL) &&
              cycles.width == WIDTH && cycles.height == HEIGHT;
    for (int i = 0; ok && i < 2; i++)
        ok = view_set_open(ctx, &(view_request){.path = sets[i]}, &set[i]);
    if (ok)
        find_spheres(&s, &map, cycles.data, shown);
    for (int i = 0; ok && i < LOOKUPS; i++) {
        ok = draw(&set[!lookups[i].linear], lookups[i].reflection, rgb);
        for (int k = 0; ok && k < SPHERES; k++)
            f[i][k] = measure(rgb, cycles.data, shown, k);
    }
    const int broken = ok ? print_errors(f) : 1;
    ibl_image_free(&map);
    ibl_image_free(&cycles);
    for (int i = 0; i < 2; i++)
        view_set_free(&set[i]);
    view_test_close();
    if (!ok)
        fprintf(stderr, "cycles: %s cannot be compared\n", paths[1]);
    else if (broken)
        printf("check-cycles: %d lines are beyond the bounds of tests/cycles.c "
               "(!)\n",
               broken);
    return broken > 0;
}

/* ---- a model -------------------------------------------------------------
 */

/* At these roughnesses both forms of shadowing differ by less than 1 % but at
 * the limb. */
static float roughness_of(int material)
{
    static const float all[] = {0.15F, 0.3F, 0.45F};
    return material % 2 ? -1 : all[material / 2 % 3]; /* -1: matte */
}

static bool read_model(ibl_ctx *ctx, const char *path, ibl_scene *out)
{
    if (ibl_scene_read(ctx, path, false, out))
        return false;
    for (int i = 0; i < out->material_count; i++) {
        ibl_scene_material *m = &out->materials[i];
        const bool metal = roughness_of(i) > 0;
        m->metallic = metal;
        m->roughness = metal ? roughness_of(i) : 1;
        m->specular = metal;
        for (int k = 0; k < 3 && metal; k++)
            m->base_colour[k] = 1;
        m->double_sided = true; /* as Cycles draws */
    }
    return true;
}

static view_settings model_settings(void)
{
    view_settings s = view_settings_default();
    s.mode = VIEW_MODEL;
    s.background = VIEW_BACKGROUND_COLOUR;
    s.multiscatter = false;
    s.antialias = 1;
    s.yaw = 30;
    s.pitch = 25;
    return s;
}

static int print_model(const char *path)
{
    ibl_scene m;
    const view_settings s = model_settings();
    const bool ok = read_model(view_test_ctx(0), path, &m);
    if (ok) {
        print_camera(&s, MODEL_WIDTH, MODEL_HEIGHT);
        printf(",\n\"materials\": [");
        for (int i = 0; i < m.material_count; i++)
            printf("%s{\"roughness\": %g, \"colour\": [%.9g, %.9g, %.9g]}",
                   i ? ",\n" : "", (double)roughness_of(i),
                   (double)m.materials[i].base_colour[0],
                   (double)m.materials[i].base_colour[1],
                   (double)m.materials[i].base_colour[2]);
        printf("]}\n");
    }
    ibl_scene_free(&m);
    return !ok;
}

/* What both draw of the model; elsewhere they are black. */
static void find_model(const float *rgb, const float *cycles, int *shown)
{
    for (int i = 0; i < PIXELS; i++)
        shown[i] = rgb[3 * i + 1] > 0 && cycles[3 * i + 1] > 0 ? 0 : -1;
}

static int compare_model(const char *set_path, const char *model_path,
                         const char *picture)
{
    static float rgb[3 * PIXELS];
    static int shown[PIXELS];
    ibl_ctx *ctx = view_test_ctx(0);
    ibl_read_options o = ibl_read_options_default();
    view_settings s = model_settings();
    baked_set set = {0};
    ibl_scene scene = {0};
    ibl_image cycles = {0};
    int broken = 0;

    view_test_begin(MODEL_WIDTH, MODEL_HEIGHT);
    o.any_aspect = 1;
    view_renderer *r = view_renderer_create();
    bool ok = !ibl_image_read(ctx, picture, &o, &cycles, NULL) &&
              cycles.width == MODEL_WIDTH && cycles.height == MODEL_HEIGHT &&
              view_set_open(ctx, &(view_request){.path = set_path}, &set) &&
              read_model(ctx, model_path, &scene);
    view_model *m = ok ? view_model_create(ctx, &scene, model_path) : NULL;
    ok = m && view_renderer_load(r, &set);
    if (ok)
        view_renderer_model(r, m);
    view_renderer_pace(r, SAMPLES / 4);
    printf("%%                mean  nRMSE median    p95\n");
    for (int i = 1; ok && i < LOOKUPS; i++) {
        s.reflection = lookups[i].reflection;
        do
            ok = view_test_draw(r, &s, MODEL_WIDTH, MODEL_HEIGHT);
        while (ok && s.reflection == VIEW_REFERENCE &&
               view_renderer_samples(r) < SAMPLES / 4);
        ok = ok && view_renderer_read(r, false, rgb);
        find_model(rgb, cycles.data, shown);
        const figures f = measure(rgb, cycles.data, shown, 0);
        broken += print_figures(
            lookups[i].name, f,
            s.reflection != VIEW_REFERENCE ||
                (fabs(f.mean) <= 100 * bound && f.nrmse <= 100 * model_bound));
    }
    view_model_free(m);
    view_renderer_free(r);
    ibl_scene_free(&scene);
    ibl_image_free(&cycles);
    view_set_free(&set);
    view_test_close();
    return !ok || broken;
}

int main(int argc, char **argv)
{
    if (argc == 2 && !strcmp(argv[1], "scene"))
        return print_scene();
    if (argc == 3 && !strcmp(argv[1], "scene"))
        return print_model(argv[2]);
    if (argc == 5 && !strcmp(argv[1], "compare"))
        return compare_model(argv[2], argv[3], argv[4]);
    if (argc == 3 && !strcmp(argv[1], "map"))
        return print_map(argv[2]);
    if (argc == 6 && !strcmp(argv[1], "compare"))
        return compare((const char *[]){argv[2], argv[5]}, argv + 3);
    fprintf(stderr, "usage: cycles scene [MODEL] | map MAP | compare MAP "
                    "LINEAR SET PICTURE | compare SET MODEL PICTURE\n");
    return 2;
}
