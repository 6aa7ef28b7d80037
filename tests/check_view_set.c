/* SPDX-License-Identifier: MIT */
/* Sets of the viewer: read from what iblbake writes, baked here, or refused,
 * and what paths and folders are. What ibl_set_open does is in check_set.c. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "files.h"
#include "maps.h"
#include "reference.h"
#include "sets.h"
#include "test.h"
#include "truth.h"
#include "view.h"
#include "view/baked_set.h"
#include "view/folder.h"

#define BARE "--irradiance-size 8 --lut-size 16"

/* ---- facts --------------------------------------------------------------- */

/* Of keys and sidecar that differ the keys hold; of files without keys the
 * sidecar does; without either defaults, with a line for each. */
TEST(two_accounts)
{
    static const char differ[] =
        "sed -i 's/\"linear\"/\"filament\"/; s/\"ggx\"/\"charlie\"/; "
        "s/\"smith\"/\"schlick-ibl\"/; s/\"E.pi\"/\"E\"/' "
        "keys/sky.json none/sky.json";
    ibl_ctx *ctx = view_test_ctx(2);
    baked_set keys, set;
    const ibl_set_file *f = set.baked.file;
    const ibl_set_facts *chain = &f[IBL_CONTENT_SPECULAR].facts;

    NEED(sets_bake("keys", "--mapping linear --roughness-range 0.1:0.7"));
    NEED(sets_bake("none", "--mapping linear --format dds --levels 4"));
    sets_open(ctx, "keys", &keys);
    NEED(file_run("%s", differ));
    sets_open(ctx, "keys", &set);
    sets_check_same(&set, &keys, "keys");
    sets_open(ctx, "none", &set);
    CHECK(chain->mapping == IBL_ROUGHNESS_FILAMENT &&
          chain->lobe == IBL_LOBE_CHARLIE &&
          f[IBL_CONTENT_LUT].facts.geometry == IBL_GEOMETRY_SCHLICK_IBL);
    CHECK_NEAR(f[IBL_CONTENT_IRRADIANCE].facts.irradiance_scale, 1 / M_PI,
               1e-15);
    NEED(file_run("rm keys/sky.json none/sky.json"));
    const char *said = sets_open(ctx, "keys", &set);
    CHECK(sets_lines(said) == 1 && strstr(said, "level 0 is of roughness"));
    for (int l = 0; l < chain->levels; l++)
        CHECK_NEAR(chain->roughness[l] * chain->lod_scale + chain->lod_offset,
                   l, 1e-6);
    said = sets_open(ctx, "none", &set);
    CHECK(sets_lines(said) == 3 && strstr(said, "linear mapping"));
    CHECK(chain->roughness[3] == 1 && chain->lod_scale == 3 &&
          set.sh_degree == -1);
}

/* By what the engine of a set lights matte surfaces, as iblbake-engines(7) has
 * it; of others what they have. */
TEST(diffuse_light)
{
    static const struct {
        const char *options;
        view_diffuse diffuse;
        bool map, sh;
    } cases[] = {
        {"--target three", VIEW_DIFFUSE_LAST, false, true},
        {"--target bevy", VIEW_DIFFUSE_MAP, true, true},
        {"--target gltf", VIEW_DIFFUSE_SH, false, true},
        {"--only specular,json --sh 3", VIEW_DIFFUSE_SH, false, true},
        {"--only specular,json --sh 1", VIEW_DIFFUSE_LAST, false, true},
        {"--only specular", VIEW_DIFFUSE_LAST, false, false},
    };
    ibl_ctx *ctx = view_test_ctx(2);
    baked_set set;

    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        NEED(file_run("rm -rf of && '%s' -q '%s' --size 32 %s -o of",
                      file_built("iblbake"), sets_file(), cases[i].options));
        const char *said = sets_open(ctx, "of", &set);
        CHECK_MSG(set.diffuse == cases[i].diffuse, "%s: %s", cases[i].options,
                  view_diffuse_names[set.diffuse]);
        CHECK_MSG(!view_set_lacks(&set, VIEW_DIFFUSE_MAP) == cases[i].map &&
                      !view_set_lacks(&set, VIEW_DIFFUSE_SH) == cases[i].sh,
                  "%s", cases[i].options);
        CHECK(set.baked.file[IBL_CONTENT_LUT].texture.data);
        CHECK(i < 3 || strstr(said, "has no BRDF table: made"));
    }
}

/* ---- files --------------------------------------------------------------- */

/* Of sets and tables beside each other, each goes with its own. */
TEST(same_container)
{
    ibl_ctx *ctx = view_test_ctx(2);
    baked_set set;

    for (int i = 0; i < IBL_CONTAINER_COUNT; i++) {
        const ibl_container as = (ibl_container)i;
        NEED(sets_bake("mixed",
                       test_text("--format %s", ibl_container_name(as))));
    }
    NEED(file_run("rm mixed/sky.json"));
    for (int i = 0; i < IBL_CONTAINER_COUNT; i++) {
        const char *end = ibl_container_extension((ibl_container)i);
        sets_open(ctx, test_text("mixed/sky_specular.%s", end), &set);
        CHECK(!strcmp(
            strrchr(set.baked.file[IBL_CONTENT_IRRADIANCE].path, '.') + 1,
            end));
        CHECK(!strcmp(strrchr(set.baked.file[IBL_CONTENT_LUT].path, '.') + 1,
                      end));
    }
    NEED(sets_bake("two", "--name b --geometry schlick-ibl --skybox 8") &&
         sets_bake("two", "--name a"));
    sets_open(ctx, "two/b_specular.ktx2", &set);
    CHECK(set.baked.file[IBL_CONTENT_LUT].facts.geometry ==
              IBL_GEOMETRY_SCHLICK_IBL &&
          !strcmp(set.baked.name, "b"));
    CHECK(set.baked.file[IBL_CONTENT_SKYBOX].texture.width == 8 &&
          !set.own_sky);
}

/* Files that are named in place of the set's. */
TEST(wrong_kinds)
{
    static const struct {
        const char *option, *file, *words;
    } named[] = {
        {"irradiance", "wrong/sky_specular.ktx2", "holds specular, where"},
        {"irradiance", "picture.png", "not a texture"},
        {"irradiance", "wrong", "is a directory"},
        {"lut", "wrong/sky_specular.ktx2", "is a cube"},
        {"lut", "cut", "cut short"},
        {"sky", "wrong/brdf_lut.ktx2", "where a skybox"},
    };
    ibl_ctx *ctx = view_test_ctx(2);

    NEED(sets_bake("wrong", "") &&
         file_run("printf '\\211PNG\\r\\n' >picture.png; "
                  "head -c 1000 wrong/brdf_lut.ktx2 >cut; "
                  "cp wrong/sky_irradiance.ktx2 a_irradiance.ktx2"));
    for (size_t i = 0; i < sizeof named / sizeof *named; i++) {
        const char *file = file_path(named[i].file), *to = named[i].option;
        const view_request what = {
            file_path("wrong"), .irradiance = *to == 'i' ? file : NULL,
            .lut = *to == 'l' ? file : NULL, .sky = *to == 's' ? file : NULL};
        sets_check_refused(ctx, &what, file, named[i].words);
    }
    sets_refused(ctx, file_path("a_irradiance.ktx2"), "no specular");
}

TEST(kinds_and_folders)
{
    static const struct {
        const char *name;
        view_kind kind;
    } all[] = {
        {"d/sky.exr", VIEW_KIND_MAP},      {"d/map 2.HDR", VIEW_KIND_MAP},
        {"d/odd.dds", VIEW_KIND_MAP},      {"-", VIEW_KIND_MAP},
        {"d/x.glb", VIEW_KIND_MODEL},      {"d/index.json", VIEW_KIND_PROBES},
        {"d/set", VIEW_KIND_SET},          {"d/set/sky.json", VIEW_KIND_SET},
        {"d/set/sky.gltf", VIEW_KIND_SET}, {"d/maps", VIEW_KIND_FOLDER},
        {"d/empty", VIEW_KIND_NONE},       {"d/nowhere", VIEW_KIND_NONE},
        {"d", VIEW_KIND_PROBES},           {"d/set/sky.png", VIEW_KIND_MAP},
        {"d/maps/sets", VIEW_KIND_FOLDER},
    };
    static const char *const listed[] = {
        "maps", "index.json", "map 2.HDR", "map 10.hdr",
        "set",  "sky.exr",    "x.glb"};
    view_folder f;
    const char *why;

    NEED(file_run(
        "'%s' -q '%s' --target gltf --size 16 -o d/set && cd d && mkdir "
        "maps empty .hidden && cp '%s' sky.exr && cp sky.exr maps && "
        "mkdir maps/sets && touch maps/sets/a_specular.dds maps/sets/b.env && "
        "cp sky.exr .hidden.exr && cp sky.exr 'map 2.HDR' && cp "
        "sky.exr 'map 10.hdr' && cp sky.exr set/sky.png && "
        "echo x >odd.dds && echo '{}' >index.json && touch x.glb",
        file_built("iblbake"), sets_file(), sets_file()));
    for (size_t i = 0; i < sizeof all / sizeof *all; i++) {
        const bool in = all[i].name[0] == 'd';
        const view_kind kind =
            view_kind_of(in ? file_path(all[i].name) : "-", &why);
        CHECK_MSG(kind == all[i].kind && !why == (kind != VIEW_KIND_NONE),
                  "%s: %d", all[i].name, kind);
    }
    NEED(view_folder_read(file_path("d"), &f) && f.count == 7);
    for (int i = 0; i < 7; i++)
        CHECK_MSG(!strcmp(f.entry[i].name, listed[i]), "%s", f.entry[i].name);
    CHECK(f.entry[4].kind == VIEW_KIND_SET &&
          f.entry[0].kind == VIEW_KIND_FOLDER);
    CHECK(view_folder_step(&f, VIEW_KIND_MAP, "map 10.hdr", 1) == 5);
    CHECK(view_folder_step(&f, VIEW_KIND_MAP, "sky.exr", 1) == 2);
    CHECK(view_folder_step(&f, VIEW_KIND_MAP, "map 2.HDR", -1) == 5);
    view_folder_free(&f);
    CHECK(view_folder_step(&f, VIEW_KIND_MAP, "sky.exr", 1) == -1);
    view_test_catch();
    CHECK(!view_folder_read(file_path("d/nowhere"), &f) && !f.entry);
    CHECK(strstr(view_test_caught(), "nowhere: cannot be listed"));
    const char *shipped = view_shipped_map();
    CHECK(shipped && view_kind_of(shipped, &why) == VIEW_KIND_MAP);
}

/* The map is read once, though its file may be gone by then. */
TEST(source_is_read_once)
{
    ibl_ctx *ctx = view_test_ctx(2);
    const ibl_image truth = sets_read_map(ctx);
    baked_set set;

    NEED(file_run("mkdir once && cp '%s' once/map.exr && '%s' -q once/map.exr "
                  "-o once --size 32 " BARE,
                  sets_file(), file_built("iblbake")));
    sets_open(ctx, "once", &set);
    for (int i = 0; i < 2; i++) {
        const ibl_image *map = view_set_source(&set);
        NEED(map && map->width == truth.width);
        CHECK(!memcmp(map->data, truth.data,
                      3 * sizeof(float) * truth.width * truth.height));
        NEED(i || file_run("rm once/map.exr"));
    }
    ibl_image_free(&set.map);
    sets_open(ctx, "once", &set);
    CHECK(!view_set_source(&set));
    /* Another file of that name, though as bright, is another map. */
    ibl_image other = sets_map(ctx, 32, 60);
    NEED(file_save_exr(file_path("once/map.exr"), &other, NULL));
    sets_open(ctx, "once", &set);
    view_test_catch();
    CHECK(!view_set_source(&set) && !view_set_source(&set));
    const char *said = view_test_caught();
    CHECK(sets_lines(said) == 1 && strstr(said, "as it was"));
}

/* ---- harmonics -------------------------------------------------------------
 */

/* L = Y_lm, turned by 90 degrees with the map, has E/pi = A_l Y_lm / pi: each
 * coefficient alone, against tests/truth.c. */
TEST(harmonics_are_irradiance)
{
    static const double cosine[] = {1, 2.0 / 3, 0.25, 0, -1.0 / 24};
    const double d[3] = {0.36, 0.48, 0.8};
    baked_set set = {0};

    for (int l = 0, i = 0; l <= VIEW_SH_DEGREE; l++)
        for (int m = -l; m <= l; m++, i++) {
            double sh[3 * VIEW_SH_COUNT] = {0}, rgb[3];
            sh[3 * i + 1] = 1;
            view_set_harmonics(&set, VIEW_SH_DEGREE, sh);
            view_harmonics_sum(set.sh, VIEW_SH_COUNT, 3, d, rgb);
            CHECK_NEAR(rgb[1], cosine[l] * truth_sh(l, m, d), 1e-12);
            CHECK(rgb[0] == 0 && rgb[2] == 0);
        }
}

/* ---- bakes --------------------------------------------------------------- */

static void pause_for(double seconds)
{
    const struct timespec t = {0, (long)(1e9 * seconds)};
    nanosleep(&t, NULL);
}

/* A bake beside the window: the program's set, with progress that rises; or
 * none, soon, if it is cancelled; or one line. */
TEST(baker)
{
    ibl_ctx *ctx = view_test_ctx(2);
    double done, before = 0;
    int seen = 0;
    baked_set made, set;

    /* Bakes of a map that takes a while. */
    ibl_image large = sets_map(ctx, TEST_SANITIZED ? 256 : 2048, 60);
    const view_request what = {.path = file_path("large.exr")};
    NEED(file_save_exr(what.path, &large, NULL));
    view_baker *b = view_baker_start(&what);
    NEED(b);
    for (; !view_baker_poll(b, &done); before = done) {
        CHECK_MSG(done >= before && done <= 1, "%g after %g", done, before);
        seen += done > before;
        pause_for(0.002);
    }
    CHECK_MSG(done == 1 && seen > 2, "seen to move %d times", seen);
    NEED(view_baker_finish(b, &made) &&
         file_run("'%s' -q large.exr --sh 4 -o same", file_built("iblbake")));
    sets_open(ctx, "same", &set);
    sets_check_same(&set, &made, "beside the window");
    CHECK(!strcmp(made.baked.source, what.path) && !made.diffuse);
    view_set_free(&made);
    b = view_baker_start(&what);
    pause_for(0.005);
    view_test_catch();
    CHECK(!view_baker_finish(b, NULL) && !*view_test_caught());
    const view_request no = {.path = file_path("no.hdr")};
    view_test_catch();
    b = view_baker_start(&no);
    CHECK(b && !view_baker_finish(b, &set) && !set.baked.name);
    const char *said = view_test_caught();
    CHECK_MSG(sets_lines(said) == 1 && strstr(said, "no.hdr: "), "%s", said);
}
