/* SPDX-License-Identifier: MIT */
/* Sets that the program writes, read back and compared with bakes in memory, in
 * every container, layout and target; and those that are damaged, or say little
 * or nonsense. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "files.h"
#include "ibl/set.h"
#include "maps.h"
#include "test.h"
#include "textures.h"
#include "truth.h"

static test_messages said;

static ibl_ctx *context(void)
{
    said = (test_messages){0};
    return file_ctx(2, &said, NULL);
}

static void free_set(void *set)
{
    ibl_set_free(set);
}

/* A set that must open, until the running test has ended. */
static ibl_set *open_it(ibl_ctx *ctx, const char *path,
                        const ibl_set_options *opts)
{
    ibl_set *set = test_alloc(1, sizeof *set);
    const ibl_status status =
        ibl_set_open(ctx, path ? file_path(path) : NULL, opts, set);

    CHECK_MSG(!status, "%s: %s", path, said.text[IBL_LOG_ERROR]);
    if (status)
        test_leave();
    test_defer(free_set, set);
    return set;
}

/* A smooth sky with a sun. */
static ibl_image sky(ibl_ctx *ctx)
{
    static const double sun[3] = {-0.48, 0.6, 0.64};
    ibl_image map = map_constant(ctx, 64, 32, 0);

    for (int i = 0; i < 64 * 32; i++) {
        double d[3];
        truth_latlong_direction(64, 32, i % 64, i / 64, d);
        const double s = fmax(d[0] * sun[0] + d[1] * sun[1] + d[2] * sun[2], 0);
        map_set(&map, i % 64, i / 64, (float)(1 + .5 * d[1] + .2 * d[0]),
                (float)(1 + .4 * d[1] * d[2] + pow(s, 20)),
                (float)(1.5 - .7 * d[2] + .3 * d[0] * d[1]));
    }
    return map;
}

static const char *saved_sky(ibl_ctx *ctx)
{
    static char path[512];
    const ibl_image map = sky(ctx);

    if (!*path)
        snprintf(path, sizeof path, "%s", file_path("sky.exr"));
    NEED(file_save_exr(path, &map, NULL));
    return path;
}

/* Compares a map of the set with one that was baked. */
static void check_map(ibl_ctx *ctx, const ibl_set_file *f,
                      const ibl_cube *truth, double most, const char *what)
{
    ibl_cube cube = {0};

    if (ibl_texture_to_cube(ctx, &f->texture, &cube) ||
        cube.size != truth->size || cube.levels != truth->levels ||
        cube.projection != truth->projection) {
        test_fail(__FILE__, __LINE__, "%s: %s: another shape: %s", what,
                  f->path, said.text[IBL_LOG_ERROR]);
        return;
    }
    test_cube(cube);
    for (int l = 0; l < cube.levels; l++) {
        const ibl_level_shape s =
            ibl_level_shape_of(cube.projection, ibl_cube_edge(cube.size, l));
        const float *a = ibl_cube_face(&cube, l, 0);
        const float *b = ibl_cube_face(truth, l, 0);
        double wrong = 0, all = 0;
        for (int i = 0; i < 3 * s.faces * s.width * s.height; i++) {
            wrong += pow((double)a[i] - (double)b[i], 2);
            all += pow((double)b[i], 2);
        }
        CHECK_MSG(sqrt(wrong / all) <= most,
                  "%s: %s: level %d is off by %g of itself", what, f->path, l,
                  sqrt(wrong / all));
        test_measured("level", sqrt(wrong / all), most);
    }
}

/* Compares a set with a bake of the shape and the meaning that it is said to
 * have: texels of another meaning are far away. */
static void check_set(ibl_ctx *ctx, const ibl_set *set, double yaw, double most,
                      const char *what)
{
    const ibl_set_file *file = set->file, *f = &file[IBL_CONTENT_SPECULAR];
    const ibl_texture *matte = &file[IBL_CONTENT_IRRADIANCE].texture;
    const ibl_texture *back = &file[IBL_CONTENT_SKYBOX].texture;
    const ibl_image map = sky(ctx);
    ibl_bake_options o = ibl_bake_options_default();
    const ibl_projection projection = ibl_texture_projection(&f->texture);
    const int times = ibl_level_shape_of(projection, 1).width;

    o.yaw_deg = yaw;
    o.specular_options.size = f->texture.width / times;
    o.specular_options.levels = f->texture.levels;
    o.specular_options.mapping = f->facts.mapping;
    o.specular_options.projection = projection;
    o.irradiance = matte->data != NULL;
    o.irradiance_options.projection = projection;
    o.skybox_projection = projection;
    if (matte->data)
        o.irradiance_options.size = matte->width / times;
    o.skybox = back->width / times;
    ibl_bake_result made = map_bake(ctx, &map, &o);
    CHECK_MSG(f->facts.levels == f->texture.levels &&
                  f->facts.lobe == IBL_LOBE_GGX,
              "%s: %d levels of %d", what, f->facts.levels, f->facts.lobe);
    for (int l = 0; l < f->facts.levels; l++) {
        const double r = f->facts.roughness[l];
        CHECK_NEAR(r, made.report.layout.roughness[l], 1e-8);
        /* Babylon's formula stays below the last one, of roughness 1, too. */
        if (f->facts.mapping != IBL_ROUGHNESS_BABYLON || r < 1)
            CHECK_NEAR(ibl_set_lod(&f->facts, r), l, 1e-6);
    }
    check_map(ctx, f, &made.specular, most, what);
    if (matte->data)
        check_map(ctx, &file[IBL_CONTENT_IRRADIANCE], &made.irradiance, most,
                  what);
    if (back->data)
        check_map(ctx, &file[IBL_CONTENT_SKYBOX], &made.skybox, most, what);
    ibl_lut lut = {0};
    CHECK_MSG(
        !file[IBL_CONTENT_LUT].path ||
            (!ibl_texture_to_lut(ctx, &file[IBL_CONTENT_LUT].texture, &lut) &&
             lut.kind == file[IBL_CONTENT_LUT].facts.table),
        "%s: %s", what, said.text[IBL_LOG_ERROR]);
    ibl_lut_free(&lut);
    CHECK_NEAR(set->yaw_deg, yaw, 1e-6);
    if (!set->sidecar || strstr(set->sidecar, "index.json"))
        return;
    CHECK(set->sh_degree == 2 && set->light_count <= 0 &&
          !strcmp(set->source, saved_sky(ctx)) && set->source_hash[31]);
    for (int i = 0; i < 27; i++)
        CHECK_NEAR(set->sh[i], made.sh[i], 1e-9);
}

#define SMALL "--size 16 --irradiance-size 8 --lut-size 16 --rotate 30 "

/* By its folder, its sidecar and its levels; without a sidecar by the keys. */
TEST(what_was_baked)
{
    static const struct {
        const char *options;
        double most;
        int keys; /* are there */
    } all[] = {
        {SMALL "--format ktx2 --skybox 8", 3e-4, 1},
        {SMALL "--format ktx --skybox 8 --mapping linear", 3e-4, 1},
        {SMALL "--format dds --skybox 8 --mapping linear", 3e-4, 0},
        {SMALL "--format dds-legacy --geometry schlick-ibl", 3e-4, 0},
        {SMALL "--pixel rgba32f --zstd 3 --lut-kind charlie", 1e-6, 1},
        {SMALL "--pixel rgb9e5 --mirror x", 3e-3, 1},
        {SMALL "--pixel r11g11b10f --mirror xz --format dds", 1e-2, 0},
        {SMALL "--pixel bc6h --mirror z --up z --skybox 8", 0.06, 1},
        {SMALL "--pixel uastc-hdr --skybox 8", 0.08, 1},
        {SMALL "--pixel astc4x4hdr --format ktx", 0.06, 1},
        {SMALL "--layout octahedral --mirror x --skybox 8", 3e-4, 1},
        {SMALL "--layout equirect --mirror xz --format dds", 3e-4, 0},
        {"--size 16 --rotate 30 --format env --mapping babylon", 0.02, 1},
        {"--size 16 --rotate 30 --format gltf --mapping linear", 0.02, 1},
        {"--target three --size 16 --levels 2 --rotate 30", 0.03, 1},
        {"--target babylon --size 16 --rotate 30", 1e-2, 0},
        {"--target filament --size 16 --levels 3 --rotate 30", 1e-2, 1},
        {"--target bevy --size 16 --levels 2 --rotate 30", 1e-2, 1},
        {"--target gltf --size 16 --levels 2 --rotate 30", 0.02, 1},
    };
    ibl_ctx *ctx = context();
    const char *map = saved_sky(ctx);

    for (size_t i = 0; i < sizeof all / sizeof *all; i++) {
        const char *what = all[i].options;
        if (TEST_SANITIZED && i % 3)
            continue;
        NEED(file_run("rm -rf out && '%s' -q '%s' -o out %s",
                      file_built("iblbake"), map, what));
        const ibl_set *set = open_it(ctx, "out", NULL);
        CHECK_MSG(!strcmp(set->name, "sky") && set->sidecar, "%s", what);
        check_set(ctx, set, 30, all[i].most, what);
        for (int c = 0; c < IBL_CONTENTS; c++)
            CHECK_MSG(!set->file[c].path || set->file[c].holds == c,
                      "%s: content %d", what, c);
        for (int c = 0; c < 2; c++) {
            const char *path =
                c ? set->file[IBL_CONTENT_SPECULAR].path : set->sidecar;
            const ibl_set *same =
                open_it(ctx, path + strlen(test_dir()) + 1, NULL);
            check_set(ctx, same, 30, all[i].most, path);
        }
        if (!all[i].keys)
            continue;
        NEED(file_run("rm out/sky.json"));
        check_set(ctx, open_it(ctx, "out", NULL), 30, all[i].most, "keys");
    }
    CHECK_MSG(!*said.text[IBL_LOG_WARNING], "%s", said.text[IBL_LOG_WARNING]);
}

/* A file of another program, of which a program says what it means; and the
 * lod where only the roughness of levels is known. */
TEST(what_others_mean)
{
    ibl_ctx *ctx = context();
    const char *map = saved_sky(ctx);
    ibl_set_options o = ibl_set_options_default();
    ibl_set_facts facts = {.known = IBL_KNOWN_AXES | IBL_KNOWN_MAPPING |
                                    IBL_KNOWN_YAW | IBL_KNOWN_SCALE,
                           .axes = {IBL_MIRROR_X, IBL_UP_Z},
                           .yaw_deg = 30,
                           .irradiance_scale = 1 / M_PI,
                           .mapping = IBL_ROUGHNESS_LINEAR};

    NEED(file_run("'%s' -q '%s' -o out --format dds --mirror x --up z "
                  "--mapping linear --levels 3 " SMALL,
                  file_built("iblbake"), map));
    o.file[IBL_CONTENT_SPECULAR] = file_path("out/sky_specular.dds");
    o.file[IBL_CONTENT_IRRADIANCE] = file_path("out/sky_irradiance.dds");
    o.facts = &facts;
    const ibl_set *set = open_it(ctx, NULL, &o);
    check_set(ctx, set, 30, 3e-4, "named");
    CHECK(!set->name && !set->sidecar && !set->file[IBL_CONTENT_LUT].path &&
          set->file[IBL_CONTENT_IRRADIANCE].facts.irradiance_scale < 0.32 &&
          set->file[IBL_CONTENT_SPECULAR].facts.known == facts.known);
    facts = (ibl_set_facts){.known = IBL_KNOWN_ROUGHNESS,
                            .levels = set->file[1].texture.levels,
                            .roughness = {0, 0.25}};
    for (int l = 2; l < facts.levels; l++)
        facts.roughness[l] = 1;
    const ibl_set_facts *f =
        &open_it(ctx, NULL, &o)->file[IBL_CONTENT_SPECULAR].facts;
    CHECK_NEAR(ibl_set_lod(f, 0.125), 0.5, 1e-9);
    CHECK_NEAR(ibl_set_lod(f, 0.25), 1, 1e-9);
    CHECK_NEAR(ibl_set_lod(f, 0.625), 1.5, 1e-9);
}

/* Probes: an array by its index or folder, one layer of it. */
TEST(probes)
{
    ibl_ctx *ctx = context();
    ibl_set_options o = ibl_set_options_default();
    const char *map = saved_sky(ctx);
    ibl_image twice = sky(ctx);
    ibl_set wrong;

    for (int i = 0; i < (int)map_floats(&twice); i++)
        twice.data[i] *= 2;
    NEED(file_save_exr(file_path("twice.exr"), &twice, NULL));
    NEED(file_run(
        "rm -rf out; echo '{\"version\": 1, \"defaults\": {\"size\": 16, "
        "\"levels\": 3, \"irradiance\": 8, \"lut_size\": 16, \"container\": "
        "\"dds\"}, "
        "\"global\": {\"capture\": {\"equirect\": \"twice.exr\"}}, "
        "\"probes\": [{\"name\": \"a\", \"position\": [0, 0, 0], \"capture\": "
        "{\"equirect\": \"%s\"}, \"influence\": {\"sphere\": "
        "{\"centre\": [0, 0, 0], \"radius\": 1}}}]}' >set.json && "
        "'%s' probes -q set.json -o out",
        map, file_built("iblbake")));
    CHECK(ibl_set_open(ctx, file_path("out"), NULL, &wrong) == IBL_ERR_FORMAT &&
          test_said(&said, "2 layers, where a specular chain"));
    o.layer = 0;
    check_set(ctx, open_it(ctx, "out", &o), 0, 3e-4, "probe 0");
    check_set(ctx, open_it(ctx, "out/index.json", &o), 0, 3e-4, "index");
    o.layer = 2;
    CHECK(ibl_set_open(ctx, file_path("out"), &o, &wrong) == IBL_ERR_ARGUMENT &&
          test_said(&said, "has no layer 2, but 0 to 1"));
}

/* Keys that no bake writes. */
TEST(wrong_keys)
{
    static const char *const all[][3] = {
        {"iblbake.roughness", "0,0.5,1",
         "has 2 levels, and the roughness of 3"},
        {"iblbake.roughness", "0", "has 2 levels, and the roughness of 1"},
        {"iblbake.roughness", "0,1x", "roughness of levels is damaged"},
        {"iblbake.lod_scale", "1.5x", "has lod_scale nan"},
        {"iblbake.lod_offset", "", "has lod_offset nan"},
        {"iblbake.lobe", "wax", "its lobe is \"wax\", which"},
        {"iblbake.lights", "99", "has lights 99"},
        {"iblbake.content", "wood", "its content is \"wood\", which"}};
    ibl_ctx *ctx = context();
    const char *map = saved_sky(ctx);

    NEED(file_run("rm -rf out; '%s' -q '%s' -o out --levels 2 " SMALL,
                  file_built("iblbake"), map));
    for (size_t i = 0; i < sizeof all / sizeof *all; i++) {
        ibl_set_options o = ibl_set_options_default();
        ibl_texture tex = {0};
        size_t size;
        ibl_set set;
        NEED(!ibl_texture_read(ctx, file_path("out/sky_specular.ktx2"), &tex,
                               NULL) &&
             !ibl_texture_set(ctx, &tex, all[i][0], all[i][1]));
        texture_owned(tex);
        const void *bytes =
            texture_encode(ctx, &tex, IBL_CONTAINER_KTX2, &size);
        NEED(file_save(file_path("key_specular.ktx2"), bytes, size));
        CHECK_MSG(ibl_set_open(ctx, file_path("key_specular.ktx2"), NULL,
                               &set) == IBL_ERR_FORMAT &&
                      test_said(&said, all[i][2]),
                  "%s %s: %s", all[i][0], all[i][1], said.text[IBL_LOG_ERROR]);
        /* Unless a program knows better. */
        o.facts = &(ibl_set_facts){.known = IBL_KNOWN_MAPPING | IBL_KNOWN_LOBE |
                                            IBL_KNOWN_LIGHTS};
        if (i < 7)
            open_it(ctx, "key_specular.ktx2", &o);
    }
    NEED(file_run("echo '{\"name\": \"sky\"}' >out/sky.json"));
    const ibl_set *set = open_it(ctx, "out", NULL);
    CHECK(!set->sidecar && set->sh_degree < 0 &&
          strstr(said.text[IBL_LOG_WARNING], "not written by iblbake"));
}

/* What is wrong is said in one line, and leaves nothing. */
TEST(what_is_refused)
{
    static const struct {
        const char *change, *path, *words;
    } all[] = {
        {":", "odd0.ktx2", "where a specular chain"},
        {":", "odd1.ktx2", "where a specular chain"},
        {":", "odd2.ktx2", "where a specular chain"},
        {":", "odd3.ktx2", "where a specular chain"},
        {":", "gone", "gone: cannot be opened: No such file"},
        {"mkdir empty", "empty", "empty: has no NAME_specular"},
        {"cp out/sky_specular.ktx2 out/night_specular.ktx2", "out",
         "several sets, from night to sky: name one"},
        {"echo hello >out/text", "out/text", "out/text"},
        {"mv out/brdf_lut.ktx2 out/sky_irradiance.ktx2", "out",
         "holds a BRDF table (flat, square, two channels, of multiscatter "
         "three), where an irradiance map"},
        {"cp out/sky_skybox.dds out/brdf_lut.dds", "dds",
         "brdf_lut.dds: is a cube of 8x8 texels of rgba16f, 1 layer, where a "
         "BRDF table (flat, square, two "},
        {"head -c 900 out/sky_specular.ktx2 >a && mv a "
         "out/sky_specular.ktx2",
         "out", "cut short"},
        {"head -c 900 out/sky.json >a && mv a out/sky.json", "out", "no JSON"},
        {"rm out/*_irradiance*; sed -i s/filament/filAment/ "
         "out/sky_specular.ktx2 "
         "out/sky_specular.dds out/sky.json",
         "out",
         "its mapping is \"filAment\", which this version does not know, but "
         "linear, "},
        {"sed -i 's/\"lod_scale\": [0-9.]*/\"lod_scale\": -1/' out/sky.json",
         "dds", "has lod_scale -1, which no bake has: bake it again"},
        {"sed -i 's/\"roughness\": 1.0/\"roughness\": 2/' out/sky.json", "dds",
         "has roughness 2 at level 1, which has to be 0 to 1"},
        {"sed -i 's/\"roughness\": 1.0/\"roughness\": 0.5/; "
         "s/\"roughness\": 0.0/\"roughness\": 0.9/' out/sky.json",
         "dds", "has roughness 0.5 at level 1, which has to be 0.9 to 1"},
        {"sed -i 's/\"roughness\": 1.0/\"roughness\": \"\"/' out/sky.json",
         "dds", "roughness of levels is damaged: bake it again"},
        {"sed -i 's/\"degree\": 2/\"degree\": 3/' out/sky.json", "out",
         "harmonics are not as many"},
        {"sed -i 's/\"degree\": 2/\"degree\": -9223372036854775807/' "
         "out/sky.json",
         "out", "harmonics are not as many"},
        {"sed -i 's/\"orientation\"/\"lights\": [3], \"orientation\"/' "
         "out/sky.json",
         "out", "lights are damaged: bake the set again"},
    };
    ibl_ctx *ctx = context();
    const char *map = saved_sky(ctx);
    static const ibl_set none;

    /* Flat textures that no map has the shape of, which are to be turned. */
    for (int i = 0; i < 4; i++) {
        static const int shapes[][4] = {
            {6, 3, 1, 1}, {8, 4, 4, 1}, {2, 2, 2, 1}, {1, 1, 1, 1}};
        ibl_texture tex = texture_random(ctx, IBL_PIXEL_RGBA16F, shapes[i], 1);
        size_t size;
        NEED(!ibl_texture_set(ctx, &tex, "iblbake.mirror", "x"));
        texture_owned(tex);
        const void *bytes =
            texture_encode(ctx, &tex, IBL_CONTAINER_KTX2, &size);
        NEED(file_save(file_path(test_text("odd%d.ktx2", i)), bytes, size));
    }
    NEED(file_run("for f in dds ktx2; do '%s' -q '%s' -o kept --levels 2 "
                  "--skybox 8 --format $f " SMALL " && mv kept/sky.json $f; "
                  "done; mv ktx2 kept/sky.json",
                  file_built("iblbake"), map));
    for (size_t i = 0; i < sizeof all / sizeof *all; i++) {
        const bool dds = !strcmp(all[i].path, "dds");
        ibl_set set;
        memset(&set, 1, sizeof set);
        said = (test_messages){0};
        NEED(file_run("rm -rf out; cp -r kept out; %s; %s; :",
                      dds ? "rm out/*.ktx2; cp dds out/sky.json" : ":",
                      all[i].change));
        const ibl_status status =
            ibl_set_open(ctx, file_path(dds ? "out" : all[i].path), NULL, &set);
        CHECK_MSG(status && test_said(&said, all[i].words) &&
                      !strchr(said.text[IBL_LOG_ERROR], '\n'),
                  "%s: %s", all[i].change, said.text[IBL_LOG_ERROR]);
        CHECK(!memcmp(&set, &none, sizeof set));
    }
}
