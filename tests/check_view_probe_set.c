/* SPDX-License-Identifier: MIT */
/*
 * Captures through `iblbake probes` and back into cube arrays: every face the
 * right way round, whatever the container and the pixels; the room lit by them
 * as by what was captured; and what is said about files that are damaged or do
 * not belong together.
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
    SIZE = 16,
    PROBES = 3
};

/* ---- what tests share -------------------------------------------------- */

static ibl_ctx *ctx;

static void begin(void)
{
    view_test_begin(16, 16);
    ctx = view_test_ctx(2);
}

/* Of texel (x, y) of a face: a colour of the face and the probe, brighter in
 * the upper left and darker at the left edge; sums of powers of 2, which every
 * pixel holds exactly. */
static double painted(int probe, int face, int x, int y, int channel)
{
    const double colour = channel == face % 3 ? 1 : face < 3 ? 0.25 : 0.5;
    const double shade = x < 4 && y < 4 ? 2 : x < 4 ? 0.5 : 1;

    return colour * shade * (1 << probe);
}

/* Of rising size, as in an index, but for the last, which has a priority. */
static void make_probes(ibl_probe probe[PROBES])
{
    for (int i = 0; i < PROBES; i++)
        probe[i] = (ibl_probe){
            .position = {i, 0.1, -1.0 / 3},
            .influence = {.centre = {i, 0, 0}, .half = {1 + i, 2, 1e-3}},
            .blend = 0.7e-3,
            .has_proxy = i != 1,
            .proxy = {.centre = {0.5, 0, 0}, .half = {9, 8, 7}}};
    probe[1].influence.shape = IBL_SHAPE_SPHERE;
    probe[1].influence.half[0] = 3;
    probe[2].priority = 5;
}

/* Writes a set to bake: RGB of the faces of each probe, one below the other,
 * and set.json. */
static void save(const char *dir, const ibl_probe *probe, int count, int size,
                 const float *rgb)
{
    json_t *probes = json_array();

    NEED(file_run("mkdir -p %s", dir));
    for (int i = 0; i < count; i++, rgb += (size_t)18 * size * size) {
        const char *name = test_text("%d.exr", i);
        const char *path = file_path(test_text("%s/%s", dir, name));
        NEED(view_picture_write(ctx, path, size, IBL_FACES * size, 3, rgb));
        json_t *one =
            json_pack("{ss s{ss}}", "name", name, "capture", "equirect", name);
        put_all(&one, ibl_json_probe_of(&probe[i]));
        append(&probes, one);
    }
    json_t *root =
        json_pack("{si s{si ss si} so}", "version", 1, "defaults", "size", size,
                  "mapping", "linear", "irradiance", 8, "probes", probes);
    NEED(root &&
         !json_dump_file(root, file_path(test_text("%s/set.json", dir)), 0));
    json_decref(root);
}

static bool bake_set(const char *from, const char *to, const char *options)
{
    return file_run("'%s' probes -q %s/set.json -o %s %s",
                    file_built("iblbake"), from, to, options);
}

/* Bakes the painted probes with some options into DIR. */
static bool bake(const char *dir, const char *options)
{
    enum {
        FLOATS = PROBES * IBL_FACES * SIZE * SIZE * 3
    };
    ibl_probe probe[PROBES];
    float *rgb = test_alloc(FLOATS, sizeof *rgb);

    for (int i = 0; i < FLOATS; i++) {
        const int at = i / 3, face = at / (SIZE * SIZE);
        rgb[i] = (float)painted(face / IBL_FACES, face % IBL_FACES, at % SIZE,
                                at / SIZE % SIZE, i % 3);
    }
    make_probes(probe);
    save("painted", probe, PROBES, SIZE, rgb);
    return bake_set("painted", dir, options);
}

static view_probe_set *load(const char *dir)
{
    return view_probe_set_load(ctx, file_path(test_text("%s/index.json", dir)));
}

/* ---- loading ----------------------------------------------------------- */

/* Layer by layer what was painted, to within what a pixel can hold. */
static void check_painted(const char *dir, const view_probe_set *set,
                          int layers)
{
    const view_probe_maps *l = &set->maps;
    static const int was[PROBES] = {2, 0, 1}; /* priority, then size */
    static const int at[][2] = {{8, 8}, {1, 1}, {1, 14}, {14, 1}, {14, 14}};
    ibl_probe probe[PROBES];
    float *rgba = room_cubes_read(l->specular, layers, 0, SIZE);

    make_probes(probe);
    CHECK(l->count == PROBES);
    for (int i = 0; i < PROBES; i++) {
        const ibl_probe *p = &l->probe[i], *q = &probe[was[i]];
        CHECK(p->layer == i && p->priority == q->priority &&
              p->has_proxy == q->has_proxy &&
              p->influence.shape == q->influence.shape);
        for (int k = 0; k < 3; k++)
            CHECK_NEAR(p->position[k], q->position[k], 1e-14);
        CHECK_NEAR(p->blend, q->blend, 0);
        CHECK_NEAR(p->influence.half[0], q->influence.half[0], 0);
        CHECK_NEAR(p->proxy.half[2], q->has_proxy ? 7 : 0, 0);
        for (int k = 0; k < 5 * 6 * 3; k++) {
            const int x = at[k % 5][0], y = at[k % 5][1], f = k / 5 % 6;
            const double want = painted(was[i], f, x, y, k / 30);
            const float *got =
                rgba + 4 * (((i * IBL_FACES + f) * SIZE + y) * SIZE + x);
            CHECK_MSG(fabs(got[k / 30] - want) < 0.02 * want,
                      "%s: probe %d, face %d, (%d, %d): %g, not %g", dir, i, f,
                      x, y, got[k / 30], want);
            CHECK_NEAR(got[3], 1, 0);
        }
    }
}

TEST(faces_are_the_right_way_round)
{
    static const char *const options[] = {
        "",
        "--container ktx --pixel rgba32f",
        "--container dds --pixel rgb9e5",
        "--pixel r11g11b10f --irradiance sh",
    };

    begin();
    for (int i = 0; i < 4; i++) {
        char dir[16];
        snprintf(dir, sizeof dir, "way%d", i);
        NEED(bake(dir, options[i]));
        view_probe_set *set = load(dir);
        NEED(set);
        check_painted(dir, set, PROBES);
        const view_probe_maps *l = &set->maps;
        CHECK_NEAR(l->lod[0], 1, 0);
        CHECK_NEAR(l->lod[2], 1, 0);
        CHECK_NEAR(l->irradiance_scale, 1, 0);
        view_probe_set_free(set);
    }
}

/* It has a layer, which no probe has. */
TEST(the_global_environment_is_left_out)
{
    begin();
    NEED(bake("without", ""));
    NEED(file_run("sed -i 's/\"probes\": \\[/\"global\": {\"capture\": "
                  "{\"equirect\": \"0.exr\"}},&/' painted/set.json") &&
         bake_set("painted", "global", "--irradiance sh"));
    view_probe_set *set = load("global");
    NEED(set);
    check_painted("global", set, PROBES + 1);
    view_probe_set_free(set);
}

/* Cubes made of harmonics nearly match: irradiance is mostly degree 0 to 2. */
TEST(harmonics_become_cubes)
{
    const int count = 4 * 16 * 16 * IBL_FACES * PROBES;
    const float *texels[2];
    double worst = 0, mean = 0;

    begin();
    NEED(bake("set0", "--irradiance 16") && bake("set1", "--irradiance sh"));
    for (int i = 0; i < 2; i++) {
        view_probe_set *set = load(test_text("set%d", i));
        NEED(set);
        texels[i] = room_cubes_read(set->maps.irradiance, PROBES, 0, 16);
        view_probe_set_free(set);
    }
    for (int i = 0; i < count; i++) {
        const double d = fabs((double)texels[0][i] / (double)texels[1][i] - 1);
        worst = fmax(worst, d);
        mean += d / count;
    }
    CHECK_MSG(worst < 0.12 && mean < 0.02, "%g, %g", worst, mean);
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

    begin();
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

/* ---- a captured room --------------------------------------------------- */

enum {
    WIDE = 96,
    HIGH = 72
};

/* The mean difference of two pictures of the scene, in parts of their mean,
 * where the mirror's probe has no part. */
static double apart(const view_room_draw *d, const float *a, const float *b)
{
    double sum = 0, off = 0, ray[3];

    for (int i = 0; i < WIDE * HIGH; i++) {
        view_test_ray(&d->camera, WIDE, HIGH, i % WIDE, i / WIDE, ray);
        const room_hit h = room_cast(d, d->camera.eye, ray);
        if (h.what >= 0 && ibl_probe_influence(d->dynamic.probe, h.point) > 0)
            continue;
        for (int k = 4 * i; k < 4 * i + 3; k++) {
            sum += (double)b[k];
            off += fabs((double)a[k] - (double)b[k]);
        }
    }
    return off / sum;
}

/* A sun behind windows. */
static void sunny(void *cookie, const double direction[3], float rgba[4])
{
    const float radiance = direction[0] > 0.9 ? 20 : 0.1f;

    (void)cookie;
    for (int k = 0; k < 4; k++)
        rgba[k] = k < 3 ? radiance : 1;
}

/* What the scene's probes have captured, baked, lights it as they do, but for
 * the mirror's, which comes after a set's. What is left is 64 samples a texel
 * against the exact levels, blocks, and nine harmonics. */
TEST_SLOW(a_scene_is_lit_the_same)
{
    static const struct {
        const char *options;
        double bound; /* of apart */
    } ways[] = {{"", 0.002},
                {"--pixel bc6h --quality fast --zstd 1", 0.003},
                {"--container dds --pixel r11g11b10f --irradiance sh", 0.007}};
    static const float light[3] = {0.2f, 0.3f, 0.4f}, table[2] = {0.9f, 0.05f};
    static room_stage on;

    room_stage_begin(&on, WIDE, HIGH, light, table);
    ctx = view_test_ctx(2);
    on.environment.specular = on.environment.sky = room_cube(16, sunny, NULL);
    on.s.seconds = 1.5;
    on.s.fov = 70;
    on.s.pitch = 15;
    on.s.yaw = 30;
    const float *alone = room_stage_draw(&on);
    on.s.probes = 8;
    on.s.probe_size = 32;
    const float *shown = room_stage_draw(&on);
    view_room_draw own = on.stage->draw;
    const ibl_probe mirror = *own.dynamic.probe;
    own.dynamic.probe = &mirror;
    NEED(own.locals.count == 8);
    float *rgb = room_cubes_read(own.locals.specular, 8, 0, 32);
    for (int i = 0; i < 8 * IBL_FACES * 32 * 32; i++)
        memmove(rgb + 3 * i, rgb + 4 * i, 3 * sizeof *rgb);
    save("scene", own.locals.probe, 8, 32, rgb);
    CHECK_MSG(apart(&own, alone, shown) > 0.02, "%g",
              apart(&own, alone, shown));
    for (size_t i = 0; i < sizeof ways / sizeof *ways;
         i += TEST_SANITIZED ? 2 : 1) {
        NEED(bake_set("scene", "baked", ways[i].options));
        view_probe_set *set = load("baked");
        NEED(set);
        view_scene_use(on.stage, set);
        const double by = apart(&own, room_stage_draw(&on), shown);
        CHECK(on.stage->probe.priority == -1);
        CHECK_MSG(by <= ways[i].bound, "%s: %g apart", ways[i].options, by);
        test_measured("apart", by, ways[i].bound);
        view_scene_use(on.stage, NULL);
        view_probe_set_free(set);
    }
}

/* ---- files that will not do -------------------------------------------- */

/* Says one line with all the words, which are parted by "|". */
static void refuses(const char *dir, const char *words)
{
    char list[400], *rest = NULL;

    snprintf(list, sizeof list, "%s", words);
    view_test_catch();
    view_probe_set *set = load(dir);
    const char *said = view_test_caught();
    CHECK_MSG(!set, "%s: is loaded", words);
    view_probe_set_free(set);
    const char *end = strchr(said, '\n');
    CHECK_MSG(end && !end[1], "not one line: %s", said);
    for (char *word = strtok_r(list, "|", &rest); word;
         word = strtok_r(NULL, "|", &rest))
        CHECK_MSG(strstr(said, word), "no \"%s\" in: %s", word, said);
}

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
        {"sed -i 's/\"layers\": 3/\"layers\": 300/' index.json",
         "its index says, 300 cubes of 16"},
        {"sed -i 's/\"size\": 16/\"size\": 32/' index.json",
         "of 32 texels with levels: 2"},
        {"sed -i 's/\"levels\": 2/\"levels\": 5/' index.json",
         "of 16 texels with levels: 5"},
        {"sed -i 's/\"rgba16f\"/\"rgb9e5\"/' index.json", "levels: 2, rgb9e5"},
        {"cp brdf_lut.ktx2 probes_specular.ktx2",
         "probes_specular.ktx2: is not as|bake the probes again"},
        {"cp probes_irradiance.ktx2 probes_specular.ktx2",
         "3 cubes of 16 texels with levels: 2"},
        {"truncate -s 500 probes_specular.ktx2", "probes_specular.ktx2"},
        {"rm probes_irradiance.ktx2", "probes_irradiance.ktx2"},
    };

    begin();
    NEED(bake("whole", ""));
    for (size_t i = 0; i < sizeof edits / sizeof *edits; i++) {
        NEED(file_run("rm -rf bad && cp -r whole bad && cd bad && %s",
                      edits[i].command));
        refuses("bad", edits[i].words);
    }
}
