/* SPDX-License-Identifier: MIT */
/*
 * What the scene's probes have captured, through `iblbake probes` and back into
 * cube arrays: every face the right way round, whatever the container and the
 * pixels, and the room lit by them as by what was captured; and what is said
 * about files that are damaged or do not belong together.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "files.h"
#include "room.h"
#include "sets.h"
#include "test.h"
#include "view.h"
#include "view/message.h"
#include "view/room.h"
#include "json/json_at.h"
#include "json/json_load.h"

enum {
    WIDE = 96,
    HIGH = 72,
    PROBES = 8
};

static ibl_ctx *ctx;
static room_stage on;
static view_room_draw own; /* lit by what is captured */
static ibl_probe mirror, saved[PROBES];
static float *rgb;                 /* faces of the captures */
static const float *alone, *shown; /* without local probes, and with them */

/* A sun behind windows. */
static void sunny(void *cookie, const double direction[3], float rgba[4])
{
    const float radiance = direction[0] > 0.9 ? 20 : 0.1f;

    (void)cookie;
    for (int k = 0; k < 4; k++)
        rgba[k] = k < 3 ? radiance : 1;
}

/* Captures, and saves a set to bake: RGB of the faces of each probe, one below
 * the other, and scene/set.json, from which priorities restore the order. */
static void begin(int size)
{
    static const float light[3] = {0.2f, 0.3f, 0.4f}, table[2] = {0.9f, 0.05f};
    const int texels = IBL_FACES * size * size;
    json_t *probes = json_array();

    room_stage_begin(&on, WIDE, HIGH, light, table);
    ctx = view_test_ctx(2);
    on.environment.specular = on.environment.sky = room_cube(16, sunny, NULL);
    on.s.seconds = 1.5;
    on.s.fov = 70;
    on.s.pitch = 15;
    on.s.yaw = 30;
    alone = room_stage_draw(&on);
    on.s.probes = PROBES;
    on.s.probe_size = ilogb(size) - 4;
    shown = room_stage_draw(&on);
    own = on.stage->draw;
    mirror = *own.dynamic.probe;
    own.dynamic.probe = &mirror;
    NEED(own.locals.count == PROBES && file_run("mkdir -p scene"));
    rgb = room_cubes_read(own.locals.specular, PROBES, 0, size);
    for (int i = 0; i < PROBES * texels; i++)
        memmove(rgb + 3 * i, rgb + 4 * i, 3 * sizeof *rgb);
    for (int i = PROBES - 1; i >= 0; i--) {
        const char *name = test_text("%d.exr", i);
        saved[i] = own.locals.probe[i];
        saved[i].priority = PROBES - i;
        NEED(view_picture_write(ctx, file_path(test_text("scene/%s", name)),
                                size, IBL_FACES * size, 3,
                                rgb + (size_t)3 * texels * i));
        json_t *one =
            json_pack("{ss s{ss}}", "name", name, "capture", "equirect", name);
        put_all(&one, ibl_json_probe_of(&saved[i]));
        append(&probes, one);
    }
    json_t *root =
        json_pack("{si s{si ss si} so}", "version", 1, "defaults", "size", size,
                  "mapping", "linear", "irradiance", 8, "probes", probes);
    NEED(root && !json_dump_file(root, file_path("scene/set.json"), 0));
    json_decref(root);
}

static bool bake(const char *to, const char *options)
{
    return file_run("'%s' probes -q scene/set.json -o %s %s",
                    file_built("iblbake"), to, options);
}

static view_probe_set *load(const char *dir)
{
    return view_probe_set_load(ctx, file_path(test_text("%s/index.json", dir)));
}

/* ---- loading ----------------------------------------------------------- */

/* The mean difference of two pictures of the scene, in parts of their mean,
 * where the mirror's probe has no part. */
static double apart(const float *a, const float *b)
{
    double sum = 0, off = 0, ray[3];

    for (int i = 0; i < WIDE * HIGH; i++) {
        view_test_ray(&own.camera, WIDE, HIGH, i % WIDE, i / WIDE, ray);
        const room_hit h = room_cast(&own, own.camera.eye, ray);
        if (h.what >= 0 && ibl_probe_influence(&mirror, h.point) > 0)
            continue;
        for (int k = 4 * i; k < 4 * i + 3; k++) {
            sum += (double)b[k];
            off += fabs((double)a[k] - (double)b[k]);
        }
    }
    return off / sum;
}

/* Layer by layer the probes and their texels; bound: of the brightest. */
static double texels_apart(const view_probe_set *set, int layers, int size)
{
    const int floats = 3 * IBL_FACES * size * size;
    const float *rgba = room_cubes_read(set->maps.specular, layers, 0, size);
    double worst = 0;

    CHECK(set->maps.count == PROBES && set->maps.irradiance_scale == 1 &&
          set->maps.lod[0] == set->maps.lod[2]);
    for (int i = 0; i < PROBES; i++) {
        const ibl_probe *p = &set->maps.probe[i], *q = &saved[i];
        CHECK(p->layer == i && p->priority == q->priority && p->has_proxy);
        CHECK_NEAR(p->blend, q->blend, 1e-14);
        for (int k = 0; k < 3; k++) {
            CHECK_NEAR(p->position[k], q->position[k], 1e-14);
            CHECK_NEAR(p->influence.half[k], q->influence.half[k], 1e-14);
            CHECK_NEAR(p->proxy.centre[k], q->proxy.centre[k], 1e-14);
        }
    }
    for (int i = 0; i < PROBES * floats; i += 3)
        for (int k = 0; k < 3; k++) {
            const double most = fmaxf(fmaxf(rgb[i], rgb[i + 1]), rgb[i + 2]);
            const double seen = (double)rgba[4 * (i / 3) + k];
            worst = fmax(worst, fabs(seen - (double)rgb[i + k]) / most);
        }
    return worst;
}

/* Lit by baked probes the room is as by its own, but for the mirror's, which
 * comes after a set's. What is left is 64 samples a texel against the exact
 * levels, blocks, and nine harmonics. A global environment has a layer, which
 * no probe has. */
TEST_SLOW(a_scene_is_lit_the_same)
{
    static const struct {
        const char *options;
        double texels, bound; /* of texels_apart and apart */
    } ways[] = {
        {"", 1e-3, 0.002},
        {"--container ktx --pixel rgba32f", 1e-6, 0.002},
        {"--container dds --pixel rgb9e5", 0.01, 0.003},
        {"--pixel bc6h --quality fast --zstd 1", 9, 0.003},
        {"--container dds --pixel r11g11b10f --irradiance sh", 0.03, 0.007}};
    const int count = sizeof ways / sizeof *ways;

    begin(32);
    CHECK_MSG(apart(alone, shown) > 0.02, "%g", apart(alone, shown));
    for (int i = 0; i < count; i += TEST_SANITIZED ? 2 : 1) {
        const bool global = i == count - 1;
        NEED(!global || file_run("sed -i 's/\"probes\": \\[/\"global\": "
                                 "{\"capture\": {\"equirect\": \"0.exr\"}},&/' "
                                 "scene/set.json"));
        NEED(bake("baked", ways[i].options));
        view_probe_set *set = load("baked");
        NEED(set);
        const double by = texels_apart(set, PROBES + global, 32);
        CHECK_MSG(by < ways[i].texels, "%s: texels %g apart", ways[i].options,
                  by);
        view_scene_use(on.stage, set);
        const double off = apart(room_stage_draw(&on), shown);
        CHECK(on.stage->probe.priority == -1);
        CHECK_MSG(off <= ways[i].bound, "%s: %g apart", ways[i].options, off);
        test_measured("apart", off, ways[i].bound);
        view_scene_use(on.stage, NULL);
        view_probe_set_free(set);
    }
}

/* Every level of an array is that of its file, bit for bit. */
static void check_levels(const view_probe_set *set, const char *file)
{
    ibl_texture tex = {0};

    NEED(!ibl_texture_read(ctx, file_path(file), &tex, NULL));
    gl.BindTexture(GL_TEXTURE_CUBE_MAP_ARRAY, set->maps.specular);
    for (int level = 0; level < tex.levels; level++) {
        const size_t bytes =
            PROBES * IBL_FACES * ibl_texture_face_bytes(&tex, level);
        void *got = malloc(bytes);
        gl.GetTexImage(GL_TEXTURE_CUBE_MAP_ARRAY, level, GL_RGBA, GL_HALF_FLOAT,
                       got);
        CHECK_MSG(
            !memcmp(got, tex.data + ibl_texture_offset(&tex, level, 0), bytes),
            "level %d", level);
        free(got);
    }
    gl.BindTexture(GL_TEXTURE_CUBE_MAP_ARRAY, 0);
    ibl_texture_free(&tex);
}

/* The lookups of levels and irradiance follow an index that sed has changed. */
TEST(lookups_are_as_told)
{
    static const struct {
        const char *sed;
        double scale, offset, irradiance;
        bool filament;
    } told[] = {
        {"", 2, 0, 1, false},
        {"s/\"linear\"/\"filament\"/", 2, 0, 1, true},
        {"s/\"lod_scale\": 2.0/\"lod_scale\": 2.5/", 2.5, 0, 1, false},
        {"s/\"lod_offset\": 0.0/\"lod_offset\": -0.5/", 2, -0.5, 1, false},
        {"s/\"scale\": \"E.pi\"/\"scale\": \"E\"/", 2, 0, 1 / M_PI, false},
    };

    begin(16);
    NEED(bake("told", "--levels 3") &&
         file_run("cp told/index.json index.json"));
    for (size_t i = 0; i < sizeof told / sizeof *told; i++) {
        NEED(file_run("sed '%s' index.json >told/index.json", told[i].sed));
        view_probe_set *set = load("told");
        NEED(set);
        const view_probe_maps *l = &set->maps;
        CHECK_NEAR(l->lod[0], told[i].scale, 0);
        CHECK_NEAR(l->lod[1], told[i].offset, 0);
        CHECK_NEAR(l->irradiance_scale, told[i].irradiance, 1e-7);
        CHECK_NEAR(l->lod[2], 2, 0);
        CHECK_NEAR(l->lod[3], told[i].filament, 0);
        check_levels(set, "told/probes_specular.ktx2");
        view_probe_set_free(set);
    }
}

/* ---- files that will not do -------------------------------------------- */

/* An index and arrays that do not fit each other; what an index may hold is
 * tested with its reader. */
TEST(files_that_do_not_fit)
{
    static const struct {
        const char *command, *words; /* in a copy of the set */
    } edits[] = {
        {"mkfifo x && mv x index.json", "index.json: is no file"},
        {"sed -i 's/probes_specular/probes_none/' index.json",
         "probes_none.ktx2"},
        {"sed -i 's/\"layers\": 8/\"layers\": 300/' index.json",
         "its index says, 300 cubes of 16"},
        {"sed -i 's/\"size\": 16/\"size\": 32/' index.json",
         "of 32 texels with levels: 2"},
        {"sed -i 's/\"levels\": 2/\"levels\": 5/' index.json",
         "of 16 texels with levels: 5"},
        {"sed -i 's/\"rgba16f\"/\"rgb9e5\"/' index.json", "levels: 2, rgb9e5"},
        {"cp brdf_lut.ktx2 probes_specular.ktx2",
         "probes_specular.ktx2: is not as its index says"},
        {"cp probes_irradiance.ktx2 probes_specular.ktx2",
         "8 cubes of 16 texels with levels: 2"},
        {"truncate -s 500 probes_specular.ktx2", "probes_specular.ktx2"},
        {"rm probes_irradiance.ktx2", "probes_irradiance.ktx2"},
    };

    begin(16);
    NEED(bake("whole", ""));
    for (size_t i = 0; i < sizeof edits / sizeof *edits; i++) {
        NEED(file_run("rm -rf bad && cp -r whole bad && cd bad && %s",
                      edits[i].command));
        view_test_catch();
        CHECK_MSG(!load("bad"), "%s: is loaded", edits[i].command);
        const char *said = view_test_caught();
        CHECK_MSG(sets_lines(said) == 1 && strstr(said, edits[i].words),
                  "no \"%s\" in: %s", edits[i].words, said);
    }
}
