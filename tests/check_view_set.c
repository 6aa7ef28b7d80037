/* SPDX-License-Identifier: MIT */
/* Sets of the viewer: read from what iblbake writes, and baked here. */
#include <fcntl.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#include "files.h"
#include "maps.h"
#include "test.h"
#include "truth.h"
#include "view.h"
#include "view/set.h"

#define PI 3.14159265358979323846

/* A smooth sky with a sun, none of it zero. */
static ibl_image sky_map(ibl_ctx *ctx, int width, double sun)
{
    const int height = width / 2;
    ibl_image map = map_constant(ctx, width, height, 0.1F);

    for (int y = 0; y < height; y++) {
        for (int x = 0; x < width; x++) {
            double d[3];
            truth_latlong_direction(width, height, x, y, d);
            map_set(&map, x, y, (float)(1 + 0.5 * d[1] + 0.2 * d[0]),
                    (float)(1 + 0.4 * d[1] * d[2]),
                    (float)(1.5 - 0.7 * d[2] + 0.3 * d[0] * d[1]));
        }
    }
    if (sun > 0)
        map_set(&map, width / 5, height / 4, (float)sun, (float)sun,
                (float)(sun / 2));
    return map;
}

/* That map as a flat Radiance file. */
static const char *map_file(void)
{
    static char path[512];
    ibl_ctx *ctx;
    ibl_image map;

    if (*path)
        return path;
    snprintf(path, sizeof path, "%s/sky.hdr", test_dir());
    ctx = view_test_ctx(2);
    map = sky_map(ctx, 64, 60);
    FILE *f = fopen(path, "wb");
    if (f)
        fprintf(f, "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 32 +X 64\n");
    for (size_t i = 0; f && i < 64 * 32; i++) {
        const float *p = map.data + 3 * i;
        unsigned char rgbe[4];
        int e;
        frexp(fmax((double)p[0], fmax((double)p[1], (double)p[2])), &e);
        for (int c = 0; c < 3; c++)
            rgbe[c] = (unsigned char)ldexp((double)p[c], 8 - e);
        rgbe[3] = (unsigned char)(e + 128);
        fwrite(rgbe, 1, 4, f);
    }
    if (!f || fclose(f)) {
        printf("%s: cannot be written\n", path);
        exit(1);
    }
    ibl_image_free(&map);
    ibl_ctx_free(ctx);
    return path;
}

/* Runs the program into a directory of that name. */
static bool bake(const char *directory, const char *options)
{
    return file_run("'%s' -q '%s' --size 32 --irradiance-size 8 --lut-size 16 "
                    "-o %s %s",
                    file_built("iblbake"), map_file(), directory, options);
}

static bool open_at(ibl_ctx *ctx, const char *name, view_set *set)
{
    const char *path = file_path(name);
    const view_request what = {.path = path};
    return view_set_open(ctx, &what, set);
}

static int lines(const char *text)
{
    int count = 0;
    for (; *text; text++)
        count += *text == '\n';
    return count;
}

/* Whether opening fails with one line that holds the words. */
static void check_refused(ibl_ctx *ctx, const view_request *what,
                          const char *file, const char *words)
{
    view_set set, zero;

    memset(&set, 1, sizeof set);
    memset(&zero, 0, sizeof zero);
    view_test_catch();
    const bool ok = view_set_open(ctx, what, &set);
    const char *said = view_test_caught();
    const char *line = said;
    int errors = 0;
    for (; *line; line = strchr(line, '\n') + 1)
        errors += strncmp(line, "iblview: note: ", 15) != 0;
    CHECK_MSG(!ok && errors == 1 && strstr(said, words) && strstr(said, file),
              "%s: wanted one line with \"%s\" and \"%s\", got %d: %s",
              what->path, file, words, ok, said);
    CHECK(!memcmp(&set, &zero, sizeof set));
    if (ok)
        view_set_free(&set);
}

static void refused(ibl_ctx *ctx, const char *path, const char *words)
{
    const view_request what = {.path = path};
    check_refused(ctx, &what, path, words);
}

/* ---- what iblbake writes --------------------------------------------- */

static void check_same(const view_set *a, const view_set *b, const char *what)
{
    for (int i = 0; i < VIEW_CONTENTS; i++) {
        const ibl_texture *s = &a->texture[i], *t = &b->texture[i];
        CHECK_MSG(s->pixel == t->pixel && s->width == t->width &&
                      s->levels == t->levels && s->bytes == t->bytes &&
                      (!s->bytes || !memcmp(s->data, t->data, s->bytes)),
                  "%s: texture %d is another", what, i);
    }
    CHECK_MSG(!strcmp(a->name, b->name) && a->mapping == b->mapping &&
                  a->lobe == b->lobe && a->geometry == b->geometry &&
                  a->irradiance_scale == b->irradiance_scale &&
                  a->sh_degree == b->sh_degree && a->peak == b->peak,
              "%s: facts differ", what);
    CHECK_NEAR(a->lod_scale, b->lod_scale, 1e-7);
    CHECK_NEAR(a->lod_offset, b->lod_offset, 1e-7);
    for (int l = 0; l < a->texture[VIEW_SPECULAR].levels; l++)
        CHECK_NEAR(a->roughness[l], b->roughness[l], 1e-8);
    for (int i = 0; i < 3 * (a->sh_degree + 1) * (a->sh_degree + 1); i++)
        CHECK_NEAR(a->sh[i], b->sh[i], 1e-12);
}

static void containers_agree(void)
{
    static const char *const names[] = {"ktx2", "ktx", "dds"};
    ibl_ctx *ctx = view_test_ctx(2);
    view_set sets[3];

    for (int i = 0; i < 3; i++) {
        char options[128], path[64];
        snprintf(options, sizeof options,
                 "--format %s --skybox 16 --mapping filament --sh 4", names[i]);
        snprintf(path, sizeof path, "same_%s", names[i]);
        NEED(bake(path, options));
        view_test_catch();
        const bool ok = open_at(ctx, path, &sets[i]);
        const char *said = view_test_caught();
        CHECK_MSG(!*said, "%s: said %s", path, said);
        NEED(ok);
    }
    CHECK(sets[0].texture[VIEW_SKY].width == 16);
    CHECK(sets[0].mapping == IBL_ROUGHNESS_FILAMENT);
    CHECK(sets[0].sh_degree == 4);
    CHECK(!strcmp(sets[0].name, "sky"));
    CHECK(sets[0].sidecar && sets[0].path[VIEW_LUT] && !sets[0].map);
    check_same(&sets[0], &sets[1], "ktx");
    check_same(&sets[0], &sets[2], "dds");
    for (int i = 0; i < 3; i++)
        view_set_free(&sets[i]);
    ibl_ctx_free(ctx);
}

/* Floats of level 0. */
static float *decode(const ibl_texture *tex)
{
    const size_t n = (size_t)tex->faces * tex->width * tex->height;
    float *rgb = malloc(3 * sizeof *rgb * n);

    if (rgb)
        ibl_pixel_decode(tex->pixel, tex->data, n, rgb);
    return rgb;
}

static void pixels_hold_the_map(void)
{
    /* Half the last bit of a mantissa, of the texel's largest component for the
     * shared exponent; a little more where rounding reaches the next one. */
    static const struct {
        const char *name;
        double step;
    } pixels[] = {{"rgba32f", 0x1p-23},
                  {"rgba16f", 0x1p-11},
                  {"rgb9e5", 0x1p-9},
                  {"r11g11b10f", 0x1p-6}};
    ibl_ctx *ctx = view_test_ctx(2);
    float *exact = NULL;

    for (int i = 0; i < 4; i++) {
        char options[64], path[64];
        view_set set;
        snprintf(options, sizeof options, "--pixel %s", pixels[i].name);
        snprintf(path, sizeof path, "pixel_%s", pixels[i].name);
        NEED(bake(path, options));
        NEED(open_at(ctx, path, &set));
        const ibl_texture *tex = &set.texture[VIEW_SPECULAR];
        CHECK(!strcmp(ibl_pixel_name(tex->pixel), pixels[i].name));
        CHECK(!strcmp(ibl_pixel_name(set.texture[VIEW_LUT].pixel),
                      i ? "rg16f" : "rg32f"));
        float *rgb = decode(tex);
        double peak = 0;
        for (int t = 0; t < 6 * 32 * 32; t++) {
            const float *p = rgb + 3 * t;
            const float *q = exact ? exact + 3 * t : p;
            const double most =
                fmax((double)q[0], fmax((double)q[1], (double)q[2]));
            for (int c = 0; c < 3; c++) {
                CHECK_NEAR((double)p[c], (double)q[c],
                           1.01 * most * pixels[i].step);
                peak = fmax(peak, (double)p[c]);
            }
        }
        CHECK(set.peak == peak);
        if (exact)
            free(rgb);
        else
            exact = rgb;
        view_set_free(&set);
    }
    free(exact);
    ibl_ctx_free(ctx);
}

/* ---- roughness ------------------------------------------------------- */

static void check_lod(const view_set *set, double low, double high)
{
    const int last = set->texture[VIEW_SPECULAR].levels - 1;
    const bool linear = set->mapping == IBL_ROUGHNESS_LINEAR;
    const double from = linear ? low : low * (2 - low);
    const double to = linear ? high : high * (2 - high);

    for (int l = 0; l <= last; l++) {
        const double x = last ? from + (to - from) * l / last : from;
        CHECK_NEAR(set->roughness[l], linear ? x : 1 - sqrt(1 - x), 1e-8);
        CHECK_NEAR(view_set_lod(set, set->roughness[l]), l, 1e-6);
    }
    CHECK(view_set_lod(set, 0) >= 0);
    CHECK(view_set_lod(set, 0) <= 1e-6 || low == 0);
    CHECK_NEAR(view_set_lod(set, 1), last, 1e-6);
}

static void mappings_and_ranges(void)
{
    static const struct {
        const char *options;
        ibl_roughness_map mapping;
        double low, high;
    } cases[] = {
        {"--mapping linear", IBL_ROUGHNESS_LINEAR, 0, 1},
        {"--mapping filament --levels 5", IBL_ROUGHNESS_FILAMENT, 0, 1},
        {"--roughness-range 0.2:0.8 --levels 4", IBL_ROUGHNESS_LINEAR, 0.2,
         0.8},
        {"--mapping filament --roughness-range 0.1:0.6 --levels 3",
         IBL_ROUGHNESS_FILAMENT, 0.1, 0.6},
        {"--roughness-range 0.5:0.5", IBL_ROUGHNESS_LINEAR, 0.5, 0.5},
    };
    ibl_ctx *ctx = view_test_ctx(2);

    for (int i = 0; i < 5; i++) {
        view_set set;
        char path[32], options[128];
        /* By the sidecar alone, by the keys alone. */
        for (int dds = 0; dds < 2; dds++) {
            snprintf(path, sizeof path, "lod%d%d", i, dds);
            snprintf(options, sizeof options, "%s --format %s",
                     cases[i].options, dds ? "dds" : "ktx");
            NEED(bake(path, options));
            if (!dds)
                NEED(file_run("rm %s/sky.json", path));
            view_test_catch();
            const bool ok = open_at(ctx, path, &set);
            const char *said = view_test_caught();
            CHECK_MSG(lines(said) == (cases[i].low > 0), "%s: said %s", path,
                      said);
            CHECK(!*said || strstr(said, "level 0 is of roughness"));
            NEED(ok);
            CHECK(set.mapping == cases[i].mapping);
            CHECK(set.sh_degree == (dds ? 2 : -1));
            check_lod(&set, cases[i].low, cases[i].high);
            view_set_free(&set);
        }
    }
    ibl_ctx_free(ctx);
}

static void lobe_and_geometry(void)
{
    ibl_ctx *ctx = view_test_ctx(2);

    for (int dds = 0; dds < 2; dds++) {
        view_set set;
        char path[32], options[128];
        snprintf(path, sizeof path, "lobe%d", dds);
        snprintf(options, sizeof options,
                 "--lobe charlie --geometry schlick-ibl --format %s",
                 dds ? "dds" : "ktx2");
        NEED(bake(path, options));
        NEED(open_at(ctx, path, &set));
        CHECK(set.lobe == IBL_LOBE_CHARLIE);
        CHECK(set.geometry == IBL_GEOMETRY_SCHLICK_IBL);
        CHECK(set.irradiance_scale == 1);
        view_set_free(&set);
    }
    ibl_ctx_free(ctx);
}

/* Neither keys nor sidecar: defaults, and a line for each. */
static void nothing_is_told(void)
{
    ibl_ctx *ctx = view_test_ctx(2);
    view_set set;

    NEED(bake("bare", "--format dds --levels 4 --mapping filament"));
    NEED(file_run("rm bare/sky.json"));
    view_test_catch();
    const bool ok = open_at(ctx, "bare", &set);
    const char *said = view_test_caught();
    NEED(ok);
    CHECK(lines(said) == 3 && strstr(said, "linear mapping") &&
          strstr(said, "irradiance / pi") && strstr(said, "smith"));
    CHECK(set.mapping == IBL_ROUGHNESS_LINEAR && set.sh_degree == -1);
    check_lod(&set, 0, 1);
    view_set_free(&set);
    ibl_ctx_free(ctx);
}

/* ---- what a set has not ----------------------------------------------- */

/* The map that the file has, as the library reads it. */
static ibl_image read_map(ibl_ctx *ctx)
{
    ibl_image map = {0};
    if (ibl_image_read(ctx, map_file(), NULL, &map, NULL))
        exit(1);
    return map;
}

static void check_irradiance(ibl_ctx *ctx, const view_set *set, double bound)
{
    const ibl_texture *tex = &set->texture[VIEW_IRRADIANCE];
    ibl_image map = read_map(ctx);
    float *rgb = decode(tex);
    double worst = 0;

    for (int face = 0; face < 6; face++) {
        for (int i = 0; i < tex->width * tex->width; i += 7) {
            double n[3], truth[3];
            const float *p = rgb + 3 * (face * tex->width * tex->width + i);
            truth_cube_direction(tex->width, face, i % tex->width,
                                 i / tex->width, n);
            truth_irradiance(&map, n, truth);
            for (int c = 0; c < 3; c++)
                worst = fmax(
                    worst,
                    fabs((double)p[c] * set->irradiance_scale / truth[c] - 1));
        }
    }
    CHECK_MSG(worst <= bound, "irradiance is off by %g of itself", worst);
    if (getenv("IBL_TEST_VERBOSE"))
        printf("irradiance %g of %g\n", worst, bound);
    free(rgb);
    ibl_image_free(&map);
}

static void table_is_made(void)
{
    ibl_ctx *ctx = view_test_ctx(2);
    view_set set;

    NEED(bake("table", "--geometry schlick-ibl"));
    NEED(file_run("rm table/brdf_lut.ktx2"));
    view_test_catch();
    const bool ok = open_at(ctx, "table", &set);
    const char *said = view_test_caught();
    NEED(ok);
    CHECK(lines(said) == 1 && strstr(said, "no BRDF table"));
    CHECK(set.geometry == IBL_GEOMETRY_SMITH && !set.path[VIEW_LUT]);
    const ibl_texture *tex = &set.texture[VIEW_LUT];
    for (int i = 3; i < tex->width; i += 50) {
        float pair[2];
        double truth[2];
        ibl_pixel_decode(tex->pixel,
                         tex->data + ibl_pixel_bytes(tex->pixel) *
                                         ((size_t)i * tex->width + 40),
                         1, pair);
        truth_lut(40.5 / tex->width, (i + 0.5) / tex->width, IBL_GEOMETRY_SMITH,
                  truth);
        /* The quadrature's 5e-5 and half a bit of a half. */
        CHECK_NEAR((double)pair[0], truth[0], 5e-5 + 0x1p-12);
        CHECK_NEAR((double)pair[1], truth[1], 5e-5 + 0x1p-12);
    }
    view_set_free(&set);
    ibl_ctx_free(ctx);
}

/* Bounds: the sum puts what is in a texel of 2.8 degrees in its centre, at most
 * 2 degrees beside, which is 0.035 of what the sun adds (a tenth of the light
 * here); harmonics to degree 4 miss at most 5 % of a sun (l = 6: 13/64 of 17/4
 * at the pole); a level of roughness 0.3 has its light 2 alpha, 10 degrees,
 * away from where it was, and some of it in GGX's tails. */
static void irradiance_is_made(void)
{
    static const struct {
        const char *options, *from;
        double bound;
    } cases[] = {
        {"", "level 0", 0.01},
        {"--levels 1", "level 0", 0.01},
        {"--roughness-range 0.3:1 --levels 2 --size 64", "last specular level",
         0.01},
        {"--roughness-range 0.3:0.8 --levels 2 --sh 4", "spherical harmonics",
         0.02},
        {"--roughness-range 0.3:0.8 --levels 2 --sh 1", "blurred", 0.05},
    };
    ibl_ctx *ctx = view_test_ctx(2);

    for (int i = 0; i < 5; i++) {
        char path[32], name[64];
        view_set set;
        snprintf(path, sizeof path, "light%d", i);
        NEED(bake(path, cases[i].options));
        snprintf(name, sizeof name, "%s/sky_irradiance.ktx2", path);
        NEED(!unlink(file_path(name)));
        view_test_catch();
        const bool ok = open_at(ctx, path, &set);
        const char *said = view_test_caught();
        NEED(ok);
        CHECK_MSG(lines(said) == 1 + (set.roughness[0] > 0) &&
                      strstr(said, cases[i].from),
                  "%s: %s", cases[i].options, said);
        check_irradiance(ctx, &set, cases[i].bound);
        view_set_free(&set);
    }
    ibl_ctx_free(ctx);
}

/* A sun that halves do not hold: the last level knows what it gave. */
static void clipped_sun(void)
{
    ibl_ctx *ctx = view_test_ctx(2);
    ibl_specular_options opts = ibl_specular_options_default();
    ibl_image map = sky_map(ctx, 128, 1e7);
    view_set baked, set;

    /* A set without irradiance, written from one that was baked. */
    opts.size = 64;
    opts.levels = 4;
    view_test_catch();
    const bool ok = view_set_bake_image(ctx, "sun", &map, &opts, &baked);
    const char *said = view_test_caught();
    NEED(ok);
    CHECK(strstr(said, "beyond 65504"));
    ibl_outputs *out;
    NEED(!ibl_outputs_create(ctx, &out));
    NEED(!ibl_outputs_mkdir(out, file_path("sun")));
    NEED(!ibl_outputs_add_texture(out, file_path("sun/sun_specular.ktx2"),
                                  &baked.texture[VIEW_SPECULAR],
                                  IBL_CONTAINER_KTX2, NULL));
    NEED(!ibl_outputs_commit(out));
    ibl_outputs_free(out);
    view_test_catch();
    NEED(open_at(ctx, "sun", &set));
    said = view_test_caught();
    CHECK(strstr(said, "the last specular level"));
    CHECK(set.texture[VIEW_IRRADIANCE].width == 8);
    float *last = decode(&set.texture[VIEW_IRRADIANCE]);
    for (int i = 0; i < 6 * 64; i += 5) {
        double n[3], truth[3];
        truth_cube_direction(8, i / 64, i % 8, i / 8 % 8, n);
        truth_irradiance(&map, n, truth);
        CHECK_NEAR((double)last[3 * i], truth[0], 0.02 * truth[0]);
    }
    free(last);
    view_set_free(&baked);
    view_set_free(&set);
    ibl_image_free(&map);
    ibl_ctx_free(ctx);
}

/* ---- harmonics -------------------------------------------------------- */

/* L = 1 + a.d + b d_x d_y has E/pi = 1 + 2/3 a.d + 1/4 b d_x d_y. */
static void harmonics_are_irradiance(void)
{
    ibl_ctx *ctx = view_test_ctx(2);
    ibl_image map = map_constant(ctx, 256, 128, 0);
    const double a[3] = {0.2, -0.3, 0.4};
    ibl_specular_options opts = ibl_specular_options_default();
    view_set set;

    for (int y = 0; y < map.height; y++) {
        for (int x = 0; x < map.width; x++) {
            double d[3];
            truth_latlong_direction(map.width, map.height, x, y, d);
            const double ad = a[0] * d[0] + a[1] * d[1] + a[2] * d[2];
            map_set(&map, x, y, (float)(1 + ad), (float)(1 + 0.5 * d[0] * d[1]),
                    (float)(1 + 0.25 * d[2] * d[1]));
        }
    }
    opts.size = 16;
    NEED(view_set_bake_image(ctx, "linear", &map, &opts, &set));
    CHECK(set.sh_degree == VIEW_SH_DEGREE);
    for (int face = 0; face < 6; face++) {
        double d[3], rgb[3];
        truth_cube_direction(16, face, 5, 11, d);
        view_set_sh_irradiance(&set, d, rgb);
        const double ad = a[0] * d[0] + a[1] * d[1] + a[2] * d[2];
        /* Pixel centres stand for pixels: (pi/128)^2 / 24 of the map. */
        CHECK_NEAR(rgb[0], 1 + 2 * ad / 3, 1e-4);
        CHECK_NEAR(rgb[1], 1 + 0.125 * d[0] * d[1], 1e-4);
        CHECK_NEAR(rgb[2], 1 + 0.0625 * d[2] * d[1], 1e-4);
    }
    view_set_free(&set);
    ibl_image_free(&map);
    ibl_ctx_free(ctx);
}

/* Each Y_lm against tests/truth.c. */
static void harmonics_basis(void)
{
    const double d[][3] = {
        {0.36, 0.48, 0.8}, {-0.8, 0.36, 0.48}, {0.48, -0.8, -0.36}};

    for (int l = 0, i = 0; l <= VIEW_SH_DEGREE; l++) {
        for (int m = -l; m <= l; m++, i++) {
            view_set set = {.sh_degree = VIEW_SH_DEGREE};
            set.sh[3 * i + 1] = 1;
            for (int k = 0; k < 3; k++) {
                double rgb[3];
                view_set_sh_irradiance(&set, d[k], rgb);
                CHECK_NEAR(rgb[1], truth_sh(l, m, d[k]), 1e-12);
                CHECK(rgb[0] == 0 && rgb[2] == 0);
            }
        }
    }
}

/* ---- directories and files that do not fit ---------------------------- */

static void directories(void)
{
    ibl_ctx *ctx = view_test_ctx(2);
    view_set set;

    NEED(file_run("mkdir -p empty several many hidden"));
    refused(ctx, file_path("empty"), "has no NAME_specular");
    refused(ctx, file_path("nowhere"), "No such file");
    NEED(bake("one", "--format ktx"));
    NEED(file_run("cp one/* several && cp several/sky_specular.ktx "
                  "several/night_specular.ktx"));
    refused(ctx, file_path("several"),
            "night_specular.ktx and sky_specular.ktx");
    NEED(
        file_run("for i in $(seq 100); do : >many/map${i}_specular.dds; done"));
    refused(ctx, file_path("many"), "holds 100 sets");
    NEED(file_run("cp one/sky_specular.ktx hidden/.old_specular.ktx"));
    refused(ctx, file_path("hidden"), "has no NAME_specular");
    /* One of several, by name; with a slash at the end; a file whose name says
     * nothing. */
    NEED(open_at(ctx, "several/sky_specular.ktx", &set));
    CHECK(!strcmp(set.name, "sky") && set.sidecar);
    CHECK(set.path[VIEW_IRRADIANCE] != NULL);
    view_set_free(&set);
    NEED(open_at(ctx, "one/", &set));
    CHECK(!strstr(set.path[VIEW_SPECULAR], "//"));
    view_set_free(&set);
    NEED(file_run("cp one/sky_specular.ktx lonely"));
    view_test_catch();
    const bool ok = open_at(ctx, "lonely", &set);
    CHECK(lines(view_test_caught()) == 2);
    NEED(ok);
    CHECK(!strcmp(set.name, "lonely") && !set.sidecar);
    CHECK(set.mapping == IBL_ROUGHNESS_LINEAR && set.sh_degree == -1);
    view_set_free(&set);
    ibl_ctx_free(ctx);
}

/* What a probe set holds. */
static void arrays(void)
{
    ibl_ctx *ctx = view_test_ctx(2);
    ibl_texture one = {0}, two = {0};
    ibl_outputs *out;
    NEED(bake("one", ""));
    NEED(
        !ibl_texture_read(ctx, file_path("one/sky_specular.ktx2"), &one, NULL));
    const ibl_texture *const layers[] = {&one, &one};
    NEED(!ibl_texture_array(ctx, layers, 2, &two));
    NEED(!ibl_outputs_create(ctx, &out));
    CHECK(!ibl_outputs_add_texture(out, file_path("array.ktx2"), &two,
                                   IBL_CONTAINER_KTX2, NULL));
    CHECK(!ibl_outputs_commit(out));
    refused(ctx, file_path("array.ktx2"), "an array of 2 layers");
    ibl_outputs_free(out);
    ibl_texture_free(&one);
    ibl_texture_free(&two);
    ibl_ctx_free(ctx);
}

static void wrong_kinds(void)
{
    ibl_ctx *ctx = view_test_ctx(2);

    NEED(bake("wrong", "--skybox 8"));
    NEED(bake("wrongd", "--skybox 8 --format dds"));
    NEED(file_run("cp wrongd/sky_irradiance.dds a_irradiance.dds"));
    NEED(file_run("printf %%20s >blank; printf hello >text; : >nothing; printf "
                  "'\\211PNG\\r\\n' "
                  ">picture.png; printf '\\377\\330\\377\\340' >picture.jpg"));
    for (int i = 0; i < 3; i++) {
        static const char *const ext[] = {"ktx2", "dds", "ktx"};
        char name[32];
        NEED(bake("cut", i == 0   ? "--format ktx2"
                         : i == 1 ? "--format dds"
                                  : "--format ktx"));
        NEED(
            file_run("head -c 1000 cut/sky_specular.%s >cut%d.bin", ext[i], i));
        snprintf(name, sizeof name, "cut%d.bin", i);
        refused(ctx, file_path(name), "cut short");
    }
    refused(ctx, file_path("wrong/brdf_lut.ktx2"), "flat texture");
    refused(ctx, file_path("wrong/sky_irradiance.ktx2"), "irradiance map");
    refused(ctx, file_path("wrong/sky_skybox.ktx2"), "holds a skybox");
    refused(ctx, file_path("wrongd/sky_irradiance.dds"), "irradiance map");
    refused(ctx, file_path("wrongd/sky_skybox.dds"), "holds a skybox");
    refused(ctx, file_path("a_irradiance.dds"), "irradiance map");
    refused(ctx, file_path("wrong/sky.json"), "JSON");
    refused(ctx, file_path("text"), "of another kind");
    refused(ctx, file_path("blank"), "of another kind");
    refused(ctx, file_path("nothing"), "is empty");
    refused(ctx, file_path("picture.png"), "PNG");
    refused(ctx, file_path("picture.jpg"), "JPEG");
    refused(ctx, map_file(), "Radiance");

    static const struct {
        const char *irradiance, *lut, *words;
    } named[] = {
        {"wrong/sky_specular.ktx2", NULL, "holds a specular chain"},
        {"wrong/brdf_lut.ktx2", NULL, "flat texture"},
        {"wrongd/sky_specular.dds", NULL, "holds a specular chain"},
        {"picture.png", NULL, "PNG"},
        {"wrong", NULL, "directory"},
        {"nowhere", NULL, "No such file"},
        {NULL, "wrong/sky_specular.ktx2", "is a cube"},
        {NULL, "wrongd/sky_irradiance.dds", "is a cube"},
        {NULL, "picture.png", "PNG"},
        {NULL, "cut0.bin", "cut short"},
        {NULL, "nowhere", "No such file"},
    };
    for (size_t i = 0; i < sizeof named / sizeof *named; i++) {
        char path[512], irradiance[512], lut[512];
        snprintf(path, sizeof path, "%s/wrong", test_dir());
        snprintf(irradiance, sizeof irradiance, "%s/%s", test_dir(),
                 named[i].irradiance ? named[i].irradiance : "");
        snprintf(lut, sizeof lut, "%s/%s", test_dir(),
                 named[i].lut ? named[i].lut : "");
        const view_request what = {.path = path,
                                   .irradiance =
                                       named[i].irradiance ? irradiance : NULL,
                                   .lut = named[i].lut ? lut : NULL};
        check_refused(ctx, &what, named[i].lut ? lut : irradiance,
                      named[i].words);
    }
    ibl_ctx_free(ctx);
}

static void skies(void)
{
    ibl_ctx *ctx = view_test_ctx(2);
    char path[512], sky[512], table[512];
    view_set set;

    NEED(bake("skies", "--skybox 8"));
    snprintf(path, sizeof path, "%s/skies", test_dir());
    snprintf(sky, sizeof sky, "%s/skies/sky_irradiance.ktx2", test_dir());
    snprintf(table, sizeof table, "%s/skies/brdf_lut.ktx2", test_dir());
    /* Any cube is a sky to those who name it. */
    NEED(view_set_open(ctx, &(view_request){.path = path, .sky = sky}, &set));
    CHECK(!strcmp(set.path[VIEW_SKY], sky));
    CHECK(set.texture[VIEW_SKY].bytes == set.texture[VIEW_IRRADIANCE].bytes);
    view_set_free(&set);
    check_refused(ctx, &(view_request){.path = path, .sky = table}, table,
                  "leave --sky out");
    ibl_ctx_free(ctx);
}

/* A table with four channels, one that is not square. */
static void wrong_tables(void)
{
    ibl_ctx *ctx = view_test_ctx(2);
    const ibl_texture tables[] = {
        {.pixel = IBL_PIXEL_RGBA16F, .width = 16, .height = 16},
        {.pixel = IBL_PIXEL_RG16F, .width = 16, .height = 8}};
    static const char *const words[] = {"two channels", "square"};

    NEED(bake("tables", ""));
    for (int i = 0; i < 2; i++) {
        ibl_texture tex = tables[i];
        ibl_outputs *out;
        char path[512], lut[512];
        tex.levels = tex.layers = tex.faces = 1;
        tex.bytes = ibl_pixel_bytes(tex.pixel) * (size_t)tex.width * tex.height;
        tex.data = calloc(1, tex.bytes);
        snprintf(path, sizeof path, "%s/tables", test_dir());
        snprintf(lut, sizeof lut, "%s/table%d.dds", test_dir(), i);
        NEED(!ibl_outputs_create(ctx, &out));
        NEED(!ibl_outputs_add_texture(out, lut, &tex, IBL_CONTAINER_DDS, NULL));
        NEED(!ibl_outputs_commit(out));
        ibl_outputs_free(out);
        free(tex.data);
        const view_request what = {.path = path, .lut = lut};
        check_refused(ctx, &what, lut, words[i]);
    }
    ibl_ctx_free(ctx);
}

/* ---- sidecars --------------------------------------------------------- */

static void sidecars(void)
{
    ibl_ctx *ctx = view_test_ctx(2);
    view_set set;

    NEED(bake("side", "--format dds"));
    NEED(bake("other", "--format dds --size 64 --levels 5"));
    const view_request what = {.path = file_path("side")};
    /* Of another bake. */
    NEED(file_run("cp side/sky.json keep.json && cp other/sky.json side"));
    check_refused(ctx, &what, "side/sky.json", "5 from 64");
    /* Cut, not by us, damaged inside. */
    NEED(file_run("head -c 700 keep.json >side/sky.json"));
    check_refused(ctx, &what, "side/sky.json", "JSON");
    NEED(file_run("sed 's/\"linear\"/\"cubic\"/' keep.json >side/sky.json"));
    check_refused(ctx, &what, "side/sky.json", "cubic");
    NEED(file_run("sed 's/\"degree\": 2/\"degree\": 3/' keep.json "
                  ">side/sky.json"));
    check_refused(ctx, &what, "side/sky.json", "harmonics");
    NEED(file_run("sed 's/\"lod_scale\": [0-9.]*/\"lod_scale\": -1/' keep.json "
                  ">side/sky.json"));
    check_refused(ctx, &what, "side/sky.json", "lod_scale");
    NEED(file_run("echo '{\"name\": \"sky\"}' >side/sky.json"));
    view_test_catch();
    NEED(view_set_open(ctx, &what, &set));
    CHECK(strstr(view_test_caught(), "not written by iblbake"));
    CHECK(!set.sidecar && set.sh_degree == -1);
    view_set_free(&set);
    /* Keys and sidecar of two bakes. */
    NEED(bake("keys", "--mapping filament"));
    NEED(file_run("sed 's/\"filament\"/\"linear\"/' keys/sky.json >k && mv k "
                  "keys/sky.json"));
    view_test_catch();
    NEED(open_at(ctx, "keys", &set));
    CHECK(strstr(view_test_caught(), "taken as the file says"));
    CHECK(set.mapping == IBL_ROUGHNESS_FILAMENT);
    view_set_free(&set);
    ibl_ctx_free(ctx);
}

/* Whatever a sidecar holds: a set, or one line. */
static void hostile_sidecars(void)
{
    const int rounds = TEST_SANITIZED ? 150 : 600;
    ibl_ctx *ctx = view_test_ctx(2);
    test_random random = {7};
    size_t size;

    NEED(bake("hostile", "--format dds"));
    char path[512], directory[512];
    snprintf(path, sizeof path, "%s/hostile/sky.json", test_dir());
    snprintf(directory, sizeof directory, "%s/hostile", test_dir());
    unsigned char *bytes = file_load(path, &size);
    unsigned char *bad = malloc(size);
    for (int i = 0; i < rounds; i++) {
        static const char marks[] = "0123456789-+.eE\"[]{},:x";
        const view_request what = {.path = directory};
        view_set set;
        memcpy(bad, bytes, size);
        for (int n = 0; n < 1 + i % 3; n++)
            bad[test_random_u64(&random) % size] = (unsigned char)
                marks[test_random_u64(&random) % (sizeof marks - 1)];
        NEED(file_save(path, bad, size));
        view_test_catch();
        const bool ok = view_set_open(ctx, &what, &set);
        const char *said = view_test_caught();
        CHECK_MSG(ok || lines(said) >= 1, "round %d: no word", i);
        if (!ok)
            continue;
        for (int l = 0; l < set.texture[VIEW_SPECULAR].levels; l++)
            CHECK(set.roughness[l] >= 0 && set.roughness[l] <= 1);
        CHECK(isfinite(set.lod_scale) && isfinite(set.lod_offset));
        for (int k = 0; k < 75; k++)
            CHECK(isfinite(set.sh[k]));
        view_set_free(&set);
    }
    free(bytes);
    free(bad);
    ibl_ctx_free(ctx);
}

/* ---- others' ---------------------------------------------------------- */

static void of_cmgen(void)
{
    ibl_ctx *ctx;
    view_set set;

    if (!file_have("cmgen")) {
        test_skip("cmgen (package filament) is not installed");
        return;
    }
    ctx = view_test_ctx(2);
    NEED(file_run("mkdir -p cm && timeout 100 cmgen -q --format=ktx --size=64 "
                  "--ibl-samples=64 --deploy=cm '%s'",
                  map_file()));
    view_test_catch();
    const bool ok = open_at(ctx, "cm/cm_ibl.ktx", &set);
    const char *said = view_test_caught();
    NEED(ok);
    CHECK_MSG(strstr(said, "as cmgen has it"), "%s", said);
    CHECK(set.mapping == IBL_ROUGHNESS_FILAMENT);
    CHECK(set.irradiance_scale == 1);
    check_lod(&set, 0, 1);
    view_set_free(&set);
    refused(ctx, file_path("cm/cm_skybox.ktx"), "holds a skybox");
    ibl_ctx_free(ctx);
}

static void maps_are_told(void)
{
    NEED(bake("told", "--format dds"));
    NEED(bake("told", "--format ktx"));
    NEED(bake("told", "--format ktx2"));
    NEED(file_run("cp told/sky_specular.dds told/sky.hdr; echo x >x.dds"));
    CHECK(view_is_map(map_file()));
    CHECK(view_is_map(file_path("x.dds")));
    CHECK(view_is_map("-"));
    CHECK(!view_is_map(file_path("told/sky.hdr")));
    CHECK(!view_is_map(file_path("told/sky_specular.ktx")));
    CHECK(!view_is_map(file_path("told/sky_specular.ktx2")));
    CHECK(!view_is_map(file_path("told/sky.json")));
    CHECK(!view_is_map(file_path("told")));
    CHECK(!view_is_map(file_path("not here")));
}

/* ---- bakes
 * ---------------------------------------------------------------------------
 */

static void bake_is_that_of_the_program(void)
{
    ibl_ctx *ctx = view_test_ctx(2);
    view_set read, made, image;
    ibl_image map = read_map(ctx);

    NEED(file_run("'%s' -q '%s' --sh 4 -o same", file_built("iblbake"),
                  map_file()));
    NEED(open_at(ctx, "same", &read));
    NEED(view_set_bake(ctx, map_file(), &made));
    check_same(&read, &made, "baked");
    CHECK(made.map && !strcmp(made.map, map_file()));
    CHECK(!view_stamp_changed(&made, &made.read, 0));
    CHECK(made.read.file[VIEW_CONTENTS + 1].size > 0);
    if (!TEST_SANITIZED) {
        NEED(view_set_bake_image(ctx, "sky", &map, NULL, &image));
        check_same(&read, &image, "baked from memory");
        CHECK(!image.map);
        view_set_free(&image);
    }
    view_set_free(&read);
    view_set_free(&made);
    ibl_image_free(&map);
    ibl_ctx_free(ctx);
}

static void bake_fails_with_a_line(void)
{
    ibl_ctx *ctx = view_test_ctx(2);
    view_set set;

    NEED(file_run("echo nonsense >map.hdr"));
    static const char *const names[] = {"map.hdr", "no.hdr"};
    for (int i = 0; i < 2; i++) {
        view_test_catch();
        const bool ok = view_set_bake(ctx, file_path(names[i]), &set);
        const char *said = view_test_caught();
        CHECK_MSG(!ok && lines(said) == 1 && strstr(said, names[i]), "%s",
                  said);
        CHECK(!set.name && !set.texture[VIEW_SPECULAR].data);
    }
    ibl_ctx_free(ctx);
}

/* A map that takes a while. */
static const char *large_map(void)
{
    static char path[512];
    const int width = TEST_SANITIZED ? 512 : 4096;
    FILE *f;

    if (*path)
        return path;
    snprintf(path, sizeof path, "%s/large.hdr", test_dir());
    f = fopen(path, "wb");
    if (!f)
        exit(1);
    fprintf(f, "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y %d +X %d\n", width / 2,
            width);
    test_random random = {3};
    for (int i = 0; i < width * width / 2; i++) {
        const uint64_t bits = test_random_u64(&random);
        const unsigned char rgbe[4] = {(unsigned char)(bits | 128),
                                       (unsigned char)(bits >> 8),
                                       (unsigned char)(bits >> 16), 128};
        fwrite(rgbe, 1, 4, f);
    }
    if (fclose(f))
        exit(1);
    return path;
}

static void pause_for(double seconds)
{
    const struct timespec t = {(time_t)seconds,
                               (long)(1e9 * (seconds - floor(seconds)))};
    nanosleep(&t, NULL);
}

static void baker_bakes(void)
{
    ibl_ctx *ctx = view_test_ctx(2);
    view_set made, set;
    char stage[64] = "";
    double done, before = 0;
    int seen = 0;

    view_baker *baker = view_baker_start(large_map());
    NEED(baker);
    while (!view_baker_poll(baker, stage, &done)) {
        CHECK_MSG(done >= before && done <= 1, "%g after %g", done, before);
        seen += done > before;
        before = done;
        pause_for(0.002);
    }
    CHECK(done == 1 && *stage);
    CHECK_MSG(seen > 2, "progress was seen to move %d times", seen);
    NEED(view_baker_finish(baker, &set));
    NEED(view_set_bake(ctx, large_map(), &made));
    check_same(&made, &set, "beside the window");
    view_set_free(&made);
    view_set_free(&set);
    ibl_ctx_free(ctx);
}

/* Of all threads of this process, which waiting does not change. */
static double processor_seconds(void)
{
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static void baker_is_cancelled(void)
{
    static const double after[] = {0, 0.001, 0.01, 0.05};
    const char *path = large_map();
    view_set set;
    double spent = -processor_seconds();
    NEED(view_baker_finish(view_baker_start(path), &set));
    spent += processor_seconds();
    view_set_free(&set);
    for (int i = 0; i < 4; i++) {
        double cancelled = -processor_seconds();
        view_baker *baker = view_baker_start(path);
        NEED(baker);
        pause_for(after[i]);
        view_test_catch();
        CHECK(!view_baker_finish(baker, NULL));
        CHECK(!*view_test_caught());
        cancelled += processor_seconds();
        CHECK_MSG(i > 0 || cancelled < 0.5 * spent,
                  "cancelled after %g s of work, all of it takes %g", cancelled,
                  spent);
    }
    /* One that has ended already. */
    view_baker *baker = view_baker_start(map_file());
    char stage[64];
    double done;
    NEED(baker);
    while (!view_baker_poll(baker, stage, &done))
        pause_for(0.002);
    CHECK(!view_baker_finish(baker, NULL));
}

static void baker_fails(void)
{
    view_set set;
    view_baker *baker;

    memset(&set, 1, sizeof set);
    view_test_catch();
    baker = view_baker_start(file_path("not there.hdr"));
    const bool ok = baker && view_baker_finish(baker, &set);
    const char *said = view_test_caught();
    CHECK(!ok && !set.name && !set.texture[VIEW_LUT].data);
    CHECK_MSG(lines(said) == 1 && strstr(said, "not there.hdr"), "%s", said);
}

/* ---- files that change ------------------------------------------------ */

/* Whether a change is seen within some seconds. */
static bool comes(const view_set *set, const view_stamp *stamp, double settle)
{
    for (int i = 0; i < 200; i++) {
        if (view_stamp_changed(set, stamp, settle))
            return true;
        pause_for(0.01);
    }
    return false;
}

static void stamps(void)
{
    ibl_ctx *ctx = view_test_ctx(2);
    view_set set;
    view_stamp stamp;

    NEED(bake("stamp", ""));
    NEED(open_at(ctx, "stamp", &set));
    view_stamp_take(&set, &stamp);
    for (int i = 0; i < VIEW_STAMPS; i++)
        CHECK(stamp.file[i].size < 0 ||
              view_file_stamp_same(&set.read.file[i], &stamp.file[i]));
    CHECK(!view_stamp_changed(&set, &set.read, 0));
    CHECK(!view_stamp_changed(&set, &stamp, 0));
    /* Renamed over with the same size and time: another file all the same. */
    NEED(file_run("cd stamp && cp -p brdf_lut.ktx2 x && mv x brdf_lut.ktx2"));
    CHECK(comes(&set, &stamp, 0));
    CHECK(!view_stamp_changed(&set, &stamp, 60));
    CHECK(comes(&set, &stamp, 0.2));
    view_stamp_take(&set, &stamp);
    CHECK(!view_stamp_changed(&set, &stamp, 0));
    /* Written anew by the program itself. */
    NEED(bake("stamp", "--levels 2"));
    CHECK(comes(&set, &stamp, 0));
    /* One that is gone alone is about to come back, or so it may be. */
    view_stamp_take(&set, &stamp);
    NEED(file_run("mv stamp/sky.json away"));
    CHECK(!view_stamp_changed(&set, &stamp, 0));
    NEED(file_run("touch stamp/brdf_lut.ktx2"));
    CHECK(!view_stamp_changed(&set, &stamp, 5));
    CHECK(comes(&set, &stamp, 0));
    CHECK(comes(&set, &stamp, 0.02));
    /* Without the specular file there is no set. */
    NEED(file_run("mv stamp/sky_specular.ktx2 specular"));
    CHECK(!view_stamp_changed(&set, &stamp, 0));
    NEED(file_run("mv specular stamp/sky_specular.ktx2"));
    NEED(file_run("mv away stamp/sky.json"));
    CHECK(comes(&set, &stamp, 0));
    view_set_free(&set);
    /* A map that was baked here. */
    NEED(file_run("cp '%s' map_of_stamp.hdr", map_file()));
    set.map = strdup(file_path("map_of_stamp.hdr"));
    view_stamp_take(&set, &stamp);
    CHECK(!view_stamp_changed(&set, &stamp, 0));
    NEED(file_run("touch -d 2001-02-03 map_of_stamp.hdr"));
    CHECK(comes(&set, &stamp, 0));
    view_set_free(&set);
    ibl_ctx_free(ctx);
}

static const test tests[] = {
    TEST(containers_agree),
    TEST(pixels_hold_the_map),
    TEST(mappings_and_ranges),
    TEST(lobe_and_geometry),
    TEST(nothing_is_told),
    TEST(table_is_made),
    TEST(irradiance_is_made),
    TEST(clipped_sun),
    TEST(harmonics_are_irradiance),
    TEST(harmonics_basis),
    TEST(directories),
    TEST(wrong_kinds),
    TEST(arrays),
    TEST(skies),
    TEST(wrong_tables),
    TEST(sidecars),
    TEST(hostile_sidecars),
    TEST(of_cmgen),
    TEST(maps_are_told),
    TEST(bake_is_that_of_the_program),
    TEST(bake_fails_with_a_line),
    TEST(baker_bakes),
    TEST(baker_is_cancelled),
    TEST(baker_fails),
    TEST(stamps),
};

int main(int argc, char **argv)
{
    const size_t count = sizeof tests / sizeof tests[0];
    size_t first = 0;

#ifdef __SANITIZE_THREAD__
    /* What has no threads takes a minute with it. */
    while (strcmp(tests[first].name, "bake_fails_with_a_line") != 0)
        first++;
#endif
    return test_main(argc, argv, tests + first, count - first);
}
