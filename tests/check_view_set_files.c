/* SPDX-License-Identifier: MIT */
/* Files that do not fit, or tell little or nonsense, as sets of the viewer. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "files.h"
#include "sets.h"
#include "test.h"
#include "view.h"
#include "view/baked_set.h"

/* One of several sets by name; a slash at the end; hidden files; a file of
 * another name. */
TEST(directories)
{
    ibl_ctx *ctx = view_test_ctx(2);
    baked_set set;

    NEED(sets_bake("one", "--format ktx"));
    NEED(file_run("cp -r one several && cp one/sky_specular.ktx "
                  "several/night_specular.ktx && mkdir hidden && cp "
                  "one/sky_specular.ktx hidden/.old_specular.ktx && cp "
                  "one/sky_specular.ktx lonely"));
    sets_refused(ctx, file_path("hidden"), "has no NAME_specular");
    sets_open(ctx, "several/sky_specular.ktx", &set);
    CHECK(!strcmp(set.name, "sky") && set.path[VIEW_SIDECAR]);
    CHECK(set.path[VIEW_IRRADIANCE] != NULL);
    sets_open(ctx, "one/", &set);
    CHECK(!strstr(set.path[VIEW_SPECULAR], "//"));
    CHECK(sets_lines(sets_open(ctx, "lonely", &set)) == 2);
    CHECK(!strcmp(set.name, "lonely") && !set.path[VIEW_SIDECAR]);
    CHECK(set.mapping == IBL_ROUGHNESS_FILAMENT && set.sh_degree == -1);
}

/* Files that are named in place of the set's. */
TEST(wrong_kinds)
{
    static const struct {
        const char *irradiance, *lut, *sky, *words;
    } named[] = {
        {"wrong/sky_specular.ktx2", NULL, NULL, "holds specular, where"},
        {"wrong/brdf_lut.ktx2", NULL, NULL, "flat texture"},
        {"picture.png", NULL, NULL, "not a texture"},
        {"wrong", NULL, NULL, "is a directory"},
        {NULL, "wrong/sky_specular.ktx2", NULL, "is a cube"},
        {NULL, "cut", NULL, "cut short"},
        {NULL, "nowhere", NULL, "No such file"},
        {NULL, NULL, "wrong/brdf_lut.ktx2", "where a skybox"},
    };
    ibl_ctx *ctx = view_test_ctx(2);

    NEED(sets_bake("wrong", ""));
    NEED(file_run("printf '\\211PNG\\r\\n' >picture.png; "
                  "head -c 1000 wrong/brdf_lut.ktx2 >cut"));
    for (size_t i = 0; i < sizeof named / sizeof *named; i++) {
        const char *names[] = {named[i].irradiance, named[i].lut, named[i].sky};
        const char *paths[3], *wrong = NULL;
        for (int k = 0; k < 3; k++) {
            paths[k] = names[k] ? file_path(names[k]) : NULL;
            wrong = paths[k] ? paths[k] : wrong;
        }
        const view_request what = {.path = file_path("wrong"),
                                   .irradiance = paths[0],
                                   .lut = paths[1],
                                   .sky = paths[2]};
        sets_check_refused(ctx, &what, wrong, named[i].words);
    }
}

/* Beside each other, a set has the table of its own; without a sidecar the one
 * that is there, of smith first. */
TEST(tables_of_two_geometries)
{
    ibl_ctx *ctx = view_test_ctx(2);
    baked_set set;
    NEED(sets_bake("two", "--name b --geometry schlick-ibl"));
    for (int i = 0; i < 3; i++) {
        static const ibl_geometry wanted[] = {IBL_GEOMETRY_SCHLICK_IBL,
                                              IBL_GEOMETRY_SCHLICK_IBL,
                                              IBL_GEOMETRY_SMITH};
        if (i == 0)
            NEED(sets_bake("two", "--name a"));
        if (i == 1)
            NEED(file_run("mv two/brdf_lut.ktx2 kept && rm two/b.json"));
        if (i == 2)
            NEED(file_run("mv kept two/brdf_lut.ktx2"));
        sets_open(ctx, "two/b_specular.ktx2", &set);
        CHECK_MSG(set.path[VIEW_LUT] && set.geometry == wanted[i], "%d: %s, %s",
                  i, set.path[VIEW_LUT], ibl_geometry_name(set.geometry));
    }
}

TEST(skies)
{
    ibl_ctx *ctx = view_test_ctx(2);
    const char *path = file_path("skies");
    const char *sky = file_path("skies/sky_irradiance.ktx2");
    baked_set set;

    NEED(sets_bake("skies", "--skybox 8"));
    /* Any cube is a sky to those who name it. */
    NEED(view_set_open(ctx, &(view_request){.path = path, .sky = sky}, &set));
    CHECK(!strcmp(set.path[VIEW_SKY], sky));
    CHECK(set.texture[VIEW_SKY].bytes == set.texture[VIEW_IRRADIANCE].bytes);
    view_set_free(&set);
}

/* ---- sidecars --------------------------------------------------------- */

/* Files in three containers beside each other: each goes with its own. */
TEST(same_container)
{
    ibl_ctx *ctx = view_test_ctx(2);

    for (int i = 0; i < IBL_CONTAINER_COUNT; i++) {
        const char *name = ibl_container_name((ibl_container)i);
        NEED(sets_bake("mixed", test_text("--format %s", name)));
    }
    NEED(file_run("rm mixed/sky.json"));
    for (int i = 0; i < IBL_CONTAINER_COUNT; i++) {
        const char *end = ibl_container_extension((ibl_container)i);
        baked_set set;
        sets_open(ctx, test_text("mixed/sky_specular.%s", end), &set);
        CHECK(!strcmp(strrchr(set.path[VIEW_IRRADIANCE], '.') + 1, end));
        CHECK(!strcmp(strrchr(set.path[VIEW_LUT], '.') + 1, end));
    }
}

/* Keys and sidecar of two bakes, which differ in one thing: the keys hold. Of
 * files without keys the sidecar does. */
TEST(two_accounts)
{
    static const char *const seds[] = {
        "s/\"filament\"/\"linear\"/",
        "s/\"lod_scale\": [0-9.]*/\"lod_scale\": 1.5/",
        "s/\"lod_offset\": [0-9.]*/\"lod_offset\": 0.25/",
        "s/\"roughness\": 0.0/\"roughness\": 0.01/",
        "s/\"ggx\"/\"charlie\"/",
        "s/\"smith\"/\"schlick-ibl\"/",
        "s/\"E.pi\"/\"E\"/",
    };
    const int count = (int)(sizeof seds / sizeof *seds);
    ibl_ctx *ctx = view_test_ctx(2);
    baked_set keys, side;

    NEED(sets_bake("keys", "--mapping filament"));
    NEED(sets_bake("none", "--mapping filament --format dds"));
    sets_open(ctx, "keys", &keys);
    NEED(file_run("cp keys/sky.json k && cp none/sky.json n"));
    for (int i = 0; i < count; i++) {
        baked_set set;
        NEED(file_run("sed '%s' k >keys/sky.json; sed '%s' n >none/sky.json",
                      seds[i], seds[i]));
        sets_open(ctx, "keys", &set);
        sets_check_same(&set, &keys, seds[i]);
        CHECK(set.roughness[0] == 0 && set.irradiance_scale == 1);
        sets_open(ctx, "none", &side);
        CHECK((side.mapping == IBL_ROUGHNESS_LINEAR) == (i == 0));
        CHECK((side.lod_scale == 1.5) == (i == 1));
        CHECK_NEAR(side.lod_offset, i == 2 ? 0.25 : 0, 0);
        CHECK_NEAR(side.roughness[0], i == 3 ? 0.01 : 0, 0);
        CHECK((side.lobe == IBL_LOBE_CHARLIE) == (i == 4));
        CHECK((side.geometry == IBL_GEOMETRY_SCHLICK_IBL) == (i == 5));
        CHECK_NEAR(side.irradiance_scale, i == 6 ? 1 / M_PI : 1, 1e-15);
    }
}

/* A table for other levels is left out, as when another bake in the same
 * directory has replaced it. */
TEST(lobes_of_other_levels)
{
    ibl_ctx *ctx = view_test_ctx(2);
    baked_set set;

    NEED(sets_bake("lobes", "--mapping filament --lobe-table prior"));
    sets_open(ctx, "lobes", &set);
    CHECK(set.texture[VIEW_LOBES].data);
    NEED(sets_bake("lobes", "--mapping linear --lobe-table prior "
                            "--only lobe-table"));
    const char *said = sets_open(ctx, "lobes", &set);
    CHECK_MSG(!set.texture[VIEW_LOBES].data && strstr(said, "left out"), "%s",
              said);
}

TEST(maps_are_told)
{
    static const char *const sets[] = {
        "sky.hdr", "sky_specular.ktx", "sky_specular.ktx2", "sky.json",
        "",        "not here"};

    for (int i = 0; i < 3; i++)
        NEED(sets_bake("told", test_text("--format %s", ibl_container_name((
                                                            ibl_container)i))));
    NEED(file_run("cp told/sky_specular.dds told/sky.hdr; echo x >x.dds"));
    CHECK(view_is_map(sets_file(), IBL_INPUT_AUTO));
    CHECK(view_is_map(file_path("x.dds"), IBL_INPUT_AUTO));
    CHECK(view_is_map("-", IBL_INPUT_AUTO));
    for (int i = 0; i < 6; i++)
        CHECK(!view_is_map(file_path(test_text("told/%s", sets[i])),
                           IBL_INPUT_AUTO));
}
