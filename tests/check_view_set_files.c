/* SPDX-License-Identifier: MIT */
/* Files that do not fit, or tell little or nonsense, as sets of the viewer. */
#include <fcntl.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "files.h"
#include "sets.h"
#include "test.h"
#include "textures.h"
#include "view.h"
#include "view/baked_set.h"

/* ---- directories and files that do not fit ---------------------------- */

TEST(directories)
{
    ibl_ctx *ctx = view_test_ctx(2);
    baked_set set;

    NEED(file_run("mkdir -p empty several many hidden"));
    sets_refused(ctx, file_path("empty"), "has no NAME_specular");
    sets_refused(ctx, file_path("nowhere"), "No such file");
    NEED(sets_bake("one", "--format ktx"));
    NEED(file_run("cp one/* several && cp several/sky_specular.ktx "
                  "several/night_specular.ktx"));
    sets_refused(ctx, file_path("several"), "from night to sky");
    NEED(
        file_run("for i in $(seq 100); do : >many/map${i}_specular.dds; done"));
    sets_refused(ctx, file_path("many"),
                 "holds several sets, from map100 to map9");
    NEED(file_run("cp one/sky_specular.ktx hidden/.old_specular.ktx"));
    sets_refused(ctx, file_path("hidden"), "has no NAME_specular");
    /* One of several, by name; a slash at the end; a file of another name. */
    sets_open(ctx, "several/sky_specular.ktx", &set);
    CHECK(!strcmp(set.name, "sky") && set.path[VIEW_SIDECAR]);
    CHECK(set.path[VIEW_IRRADIANCE] != NULL);
    sets_open(ctx, "one/", &set);
    CHECK(!strstr(set.path[VIEW_SPECULAR], "//"));
    NEED(file_run("cp one/sky_specular.ktx lonely"));
    CHECK(sets_lines(sets_open(ctx, "lonely", &set)) == 2);
    CHECK(!strcmp(set.name, "lonely") && !set.path[VIEW_SIDECAR]);
    CHECK(set.mapping == IBL_ROUGHNESS_FILAMENT && set.sh_degree == -1);
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

/* What a probe set holds: each layer is what was put there. */
TEST(arrays)
{
    ibl_ctx *ctx = view_test_ctx(2);
    ibl_texture one[2] = {{0}}, lut = {0};
    baked_set set;

    for (int i = 0; i < 2; i++) {
        NEED(sets_bake("one", i ? "--exposure 1" : ""));
        NEED(!ibl_texture_read(ctx, file_path("one/sky_specular.ktx2"), &one[i],
                               NULL));
        texture_owned(one[i]);
    }
    const ibl_texture *const layers[] = {&one[0], &one[1]};
    const ibl_texture two = texture_array(ctx, layers, 2);
    NEED(sets_save(ctx, "a_specular.ktx2", &two, IBL_CONTAINER_KTX2));
    view_request what = {.path = file_path("a_specular.ktx2")};
    for (; what.layer < 2; what.layer++) {
        const ibl_texture *tex = &set.texture[VIEW_SPECULAR];
        NEED(view_set_open(ctx, &what, &set));
        CHECK(set.layer == what.layer && tex->layers == 1);
        CHECK(tex->bytes == one[what.layer].bytes &&
              !memcmp(tex->data, one[what.layer].data, tex->bytes));
        view_set_free(&set);
    }
    view_test_catch();
    CHECK(!view_set_open(ctx, &what, &set));
    CHECK(strstr(view_test_caught(), "has no layer 2, but 0 to 1: choose"));
    NEED(!ibl_texture_read(ctx, file_path("one/brdf_lut.ktx2"), &lut, NULL));
    texture_owned(lut);
    const ibl_texture *const tables[] = {&lut, &lut};
    const ibl_texture more = texture_array(ctx, tables, 2);
    NEED(sets_save(ctx, "tables.ktx2", &more, IBL_CONTAINER_KTX2));
    sets_refused(ctx, file_path("tables.ktx2"), "holds a BRDF table");
}

TEST(wrong_kinds)
{
    ibl_ctx *ctx = view_test_ctx(2);

    NEED(sets_bake("wrong", "--skybox 8"));
    NEED(sets_bake("wrongd", "--skybox 8 --format dds"));
    NEED(file_run("printf %%20s >blank; printf hello >text; : >nothing; printf "
                  "'\\211PNG\\r\\n' "
                  ">picture.png; printf '\\377\\330\\377\\340' >picture.jpg"));
    for (int i = 0; i < 3; i++) {
        static const char *const ext[] = {"ktx2", "dds", "ktx"};
        NEED(sets_bake("cut", test_text("--format %s", ext[i])));
        NEED(
            file_run("head -c 1000 cut/sky_specular.%s >cut%d.bin", ext[i], i));
        sets_refused(ctx, file_path(test_text("cut%d.bin", i)), "cut short");
    }
    sets_refused(ctx, file_path("wrong/brdf_lut.ktx2"), "no specular");
    sets_refused(ctx, file_path("text"), "not a texture");
    sets_refused(ctx, file_path("blank"), "not a texture");
    sets_refused(ctx, file_path("nothing"), "is empty");
    sets_refused(ctx, file_path("picture.png"), "not a texture");
    sets_refused(ctx, file_path("picture.jpg"), "not a texture");
    sets_refused(ctx, sets_file(), "not a texture");

    static const struct {
        const char *irradiance, *lut, *words;
    } named[] = {
        {"wrong/sky_specular.ktx2", NULL, "holds specular, where"},
        {"wrong/brdf_lut.ktx2", NULL, "flat texture"},
        {"wrongd/sky_specular.dds", NULL, "holds specular, where"},
        {"picture.png", NULL, "not a texture"},
        {"wrong", NULL, "is a directory"},
        {"nowhere", NULL, "No such file"},
        {NULL, "wrong/sky_specular.ktx2", "is a cube"},
        {NULL, "wrongd/sky_irradiance.dds", "is a cube"},
        {NULL, "picture.png", "not a texture"},
        {NULL, "cut0.bin", "cut short"},
        {NULL, "nowhere", "No such file"},
    };
    for (size_t i = 0; i < sizeof named / sizeof *named; i++) {
        const char *irradiance = named[i].irradiance, *lut = named[i].lut;
        const view_request what = {
            .path = file_path("wrong"),
            .irradiance = irradiance ? file_path(irradiance) : NULL,
            .lut = lut ? file_path(lut) : NULL};
        sets_check_refused(ctx, &what, lut ? what.lut : what.irradiance,
                           named[i].words);
    }
}

TEST(skies)
{
    ibl_ctx *ctx = view_test_ctx(2);
    const char *path = file_path("skies");
    const char *sky = file_path("skies/sky_irradiance.ktx2");
    const char *table = file_path("skies/brdf_lut.ktx2");
    baked_set set;

    NEED(sets_bake("skies", "--skybox 8"));
    /* Any cube is a sky to those who name it. */
    NEED(view_set_open(ctx, &(view_request){.path = path, .sky = sky}, &set));
    CHECK(!strcmp(set.path[VIEW_SKY], sky));
    CHECK(set.texture[VIEW_SKY].bytes == set.texture[VIEW_IRRADIANCE].bytes);
    view_set_free(&set);
    sets_check_refused(ctx, &(view_request){.path = path, .sky = table}, table,
                       "where a skybox");
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

/* Whatever a sidecar holds: a set, or one line. */
TEST(hostile_sidecars)
{
    const int rounds = TEST_SANITIZED ? 150 : 600;
    ibl_ctx *ctx = view_test_ctx(2);
    test_random random = {7};
    size_t size;

    NEED(sets_bake("hostile", "--format dds"));
    const char *path = file_path("hostile/sky.json");
    const view_request what = {.path = file_path("hostile")};
    unsigned char *bytes = file_load(path, &size);
    unsigned char *bad = test_alloc(1, size);
    for (int i = 0; i < rounds; i++) {
        static const char marks[] = "0123456789-+.eE\"[]{},:x";
        baked_set set;
        memcpy(bad, bytes, size);
        for (int n = 0; n < 1 + i % 3; n++)
            bad[test_random_u64(&random) % size] = (unsigned char)
                marks[test_random_u64(&random) % (sizeof marks - 1)];
        NEED(file_save(path, bad, size));
        view_test_catch();
        const bool ok = view_set_open(ctx, &what, &set);
        const char *said = view_test_caught();
        CHECK_MSG(ok || sets_lines(said) >= 1, "round %d: no word", i);
        if (!ok)
            continue;
        for (int l = 0; l < set.texture[VIEW_SPECULAR].levels; l++)
            CHECK(set.roughness[l] >= 0 && set.roughness[l] <= 1);
        CHECK(isfinite(set.lod_scale) && isfinite(set.lod_offset));
        for (int k = 0; k < 75; k++)
            CHECK(isfinite(set.sh[k]));
        view_set_free(&set);
    }
}

TEST(maps_are_told)
{
    NEED(sets_bake("told", "--format dds"));
    NEED(sets_bake("told", "--format ktx"));
    NEED(sets_bake("told", "--format ktx2"));
    NEED(file_run("cp told/sky_specular.dds told/sky.hdr; echo x >x.dds"));
    CHECK(view_is_map(sets_file(), IBL_INPUT_AUTO));
    CHECK(view_is_map(file_path("x.dds"), IBL_INPUT_AUTO));
    CHECK(view_is_map("-", IBL_INPUT_AUTO));
    CHECK(!view_is_map(file_path("told/sky.hdr"), IBL_INPUT_AUTO));
    CHECK(!view_is_map(file_path("told/sky_specular.ktx"), IBL_INPUT_AUTO));
    CHECK(!view_is_map(file_path("told/sky_specular.ktx2"), IBL_INPUT_AUTO));
    CHECK(!view_is_map(file_path("told/sky.json"), IBL_INPUT_AUTO));
    CHECK(!view_is_map(file_path("told"), IBL_INPUT_AUTO));
    CHECK(!view_is_map(file_path("not here"), IBL_INPUT_AUTO));
}
