/* SPDX-License-Identifier: MIT */
/* What `iblbake probes` bakes, read by the library: the probes that went in,
 * and the light of captures whose harmonics are known. check-probes.sh: texels
 * are those of bakes of one map. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <jansson.h>

#include "files.h"
#include "ibl/probes.h"
#include "test.h"

enum {
    PROBES = 3
};

/* In the order of an index: a priority, then a rising size. Each sees the same
 * everywhere, the radiance of its place in this list; the last sees a half. */
static const struct {
    const char *name, *places;
} given[PROBES] = {
    {"K\u00fcche", "\"priority\": 5, \"influence\": {\"box\": {\"centre\": "
                   "[1, 2, 3], \"half\": [9, 8, 7]}}, \"proxy\": {\"sphere\": "
                   "{\"centre\": [0, 0.1, 0], \"radius\": 2.5}}"},
    {"small", "\"influence\": {\"sphere\": {\"centre\": [0, 0, -0.3], "
              "\"radius\": 1e-3}}, \"blend\": 0.7e-3"},
    {"large", "\"influence\": {\"box\": {\"centre\": [0, 0, 0], "
              "\"half\": [4, 4, 4]}}"},
};

static const float colours[PROBES + 1][3] = {
    {1, 0.5f, 0.25f}, {2, 2, 2}, {0, 0.75f, 3}, {0.125f, 8, 1}};

/* 1 / Y(0, 0): the coefficient of what is 1 everywhere. */
static const double constant = 3.5449077018110318;

static void save_capture(int i, double alpha)
{
    enum {
        WIDE = 16,
        TEXELS = WIDE * WIDE / 2
    };
    float rgb[3 * TEXELS], a[TEXELS];
    const ibl_image image = {WIDE, WIDE / 2, rgb};

    for (int k = 0; k < 3 * TEXELS; k++)
        rgb[k] = (float)alpha * colours[i][k % 3];
    for (int k = 0; k < TEXELS; k++)
        a[k] = (float)alpha;
    NEED(file_save_exr(file_path(test_text("%d.exr", i)), &image, a));
}

/* Bakes them, in another order, into a folder. */
static const char *bake(const char *folder, const char *mapping,
                        const char *options)
{
    static const int order[PROBES] = {2, 0, 1};
    FILE *file = fopen(file_path("set.json"), "w");

    NEED(file);
    fprintf(file,
            "{\"version\": 1, \"defaults\": {\"mapping\": \"%s\"}, \"global\": "
            "{\"capture\": {\"equirect\": "
            "\"3.exr\"}}, \"probes\": [",
            mapping);
    for (int k = 0; k < PROBES; k++) {
        const int i = order[k];
        fprintf(file,
                "%s{\"name\": \"%s\", \"capture\": {\"equirect\": \"%d.exr\"}, "
                "\"position\": [%d, 0.1, -0.2], %s}",
                k ? ", " : "", given[i].name, i, i, given[i].places);
        save_capture(i, i == PROBES - 1 ? 0.5 : 1);
    }
    save_capture(PROBES, 1);
    fprintf(file, "]}");
    NEED(!fclose(file));
    NEED(file_run("'%s' probes -q set.json -o %s --size 16 %s",
                  file_built("iblbake"), folder, options));
    return file_path(test_text("%s/index.json", folder));
}

static void free_index(void *index)
{
    ibl_probe_index_free(index);
}

static ibl_probe_index read_index(const char *path)
{
    ibl_probe_index x;

    NEED(!ibl_probe_index_read(test_ctx(1, IBL_ISA_C), path, &x));
    test_defer_copy(free_index, &x, sizeof x);
    return x;
}

static void check_probes(const ibl_probe_index *x)
{
    const ibl_probe *p = x->probe;

    CHECK(x->count == PROBES && x->global == PROBES && x->holes == 1);
    for (int i = 0; i < PROBES; i++) {
        CHECK_MSG(!strcmp(x->name[i], given[i].name), "%s", x->name[i]);
        CHECK(p[i].layer == i && p[i].has_proxy == !i);
        CHECK(p[i].priority == (i ? 0 : 5));
        CHECK(p[i].influence.shape ==
              (i == 1 ? IBL_SHAPE_SPHERE : IBL_SHAPE_BOX));
        CHECK_NEAR(p[i].position[0], i, 0);
        CHECK_NEAR(p[i].position[1], 0.1, 0);
        CHECK_NEAR(p[i].position[2], -0.2, 0);
    }
    CHECK_NEAR(p[0].influence.centre[1], 2, 0);
    CHECK_NEAR(p[0].influence.half[2], 7, 0);
    CHECK(p[0].proxy.shape == IBL_SHAPE_SPHERE);
    CHECK_NEAR(p[0].proxy.half[0], 2.5, 0);
    CHECK_NEAR(p[0].proxy.centre[1], 0.1, 0);
    CHECK_NEAR(p[1].influence.centre[2], -0.3, 0);
    CHECK_NEAR(p[1].influence.half[0], 1e-3, 0);
    CHECK_NEAR(p[1].blend, 0.7e-3, 0);
}

/* A file is what the index says. */
static void check_file(const char *folder, const ibl_probe_file *f)
{
    ibl_texture tex;

    NEED(f->name);
    NEED(!ibl_texture_read(test_ctx(1, IBL_ISA_C),
                           file_path(test_text("%s/%s", folder, f->name)), &tex,
                           NULL));
    CHECK(tex.pixel == f->pixel && tex.width == f->size &&
          tex.levels == f->levels && tex.layers == f->layers);
    ibl_texture_free(&tex);
}

TEST(what_went_in_comes_out)
{
    const ibl_probe_index x =
        read_index(bake("cubes", "linear",
                        "--levels 4 --irradiance 8 "
                        "--container ktx --pixel rgba32f"));

    check_probes(&x);
    check_file("cubes", &x.specular);
    check_file("cubes", &x.irradiance);
    CHECK(x.specular.pixel == IBL_PIXEL_RGBA32F && x.specular.size == 16 &&
          x.specular.levels == 4 && x.specular.layers == PROBES + 1);
    CHECK(x.irradiance.size == 8 && x.irradiance.levels == 1);
    CHECK(x.lut && !strncmp(x.lut, "brdf_lut", 8) && !x.sh);
    CHECK(x.mapping == IBL_ROUGHNESS_LINEAR);
    CHECK_NEAR(x.lod_scale, 3, 0);
    CHECK_NEAR(x.lod_offset, 0, 0);
    CHECK_NEAR(x.irradiance_scale, 1, 0);
}

/* E / pi of what is the same everywhere is its radiance. */
TEST(harmonics_are_of_each_layer)
{
    const ibl_probe_index x =
        read_index(bake("sums", "filament", "--irradiance sh"));

    check_probes(&x);
    CHECK(x.mapping == IBL_ROUGHNESS_FILAMENT && !x.irradiance.name);
    NEED(x.sh);
    for (int layer = 0; layer <= PROBES; layer++)
        for (int k = 0; k < 4 * IBL_PROBE_SH; k++) {
            const double seen = layer == PROBES - 1 ? 0.5 : 1;
            const double of =
                seen * (k % 4 == 3 ? 1 : (double)colours[layer][k % 4]);
            CHECK_NEAR(x.sh[layer][k], k < 4 ? constant * of : 0, 1e-4);
        }
}

TEST(an_edited_index_is_sorted)
{
    const char *path = bake("edited", "filament", "--irradiance sh");
    json_t *root = json_load_file(path, 0, NULL);
    json_t *probes = json_object_get(root, "probes");

    json_array_append(probes, json_array_get(probes, 0));
    json_array_remove(probes, 0);
    json_object_set_new(json_object_get(root, "irradiance"), "scale",
                        json_string("E"));
    NEED(!json_dump_file(root, path, 0));
    json_decref(root);
    const ibl_probe_index x = read_index(path);
    check_probes(&x);
    CHECK_NEAR(x.irradiance_scale, 0.31830988618379067, 1e-15);
}

/* Of a cross only its faces count: the rest has no alpha, for which rgb9e5 has
 * no room. */
TEST(crosses_have_alpha_in_their_faces)
{
    enum {
        FACE = 8,
        MOST = 12 * FACE * FACE
    };
    float rgb[3 * MOST], alpha[MOST];

    bake("sums", "filament", "--irradiance sh");
    for (int upright = 0; upright < 2; upright++) {
        const int w = (upright ? 3 : 4) * FACE, h = 7 * FACE - w;
        for (int i = 0; i < 3 * w * h; i++)
            rgb[i] = alpha[i / 3] =
                i / 3 % w / FACE == 1 || i / 3 / w / FACE == 1;
        NEED(file_save_exr(file_path("cross.exr"), &(ibl_image){w, h, rgb},
                           alpha));
        NEED(file_run("sed 's/equirect\": \"[0-9]/cross\": \"cross/g' "
                      "set.json >cross.json && '%s' probes -q cross.json -o "
                      "crosses --pixel rgb9e5 --size 8 --any-aspect",
                      file_built("iblbake")));
    }
}

/* ---- what will not do --------------------------------------------------- */

static int lines;

static void keep(void *cookie, ibl_log_level level, const char *text)
{
    lines += level == IBL_LOG_ERROR;
    test_keep(cookie, level, text);
}

/* Of what sed makes of it. The viewer's tests have more. */
TEST(damaged_ones_are_refused_in_one_line)
{
    static const struct {
        const char *make, *said;
        ibl_status status;
    } cases[] = {
        {"true", "bad.json: cannot be read: No such file", IBL_ERR_IO},
        {"mkdir bad.json", "bad.json: is a directory", IBL_ERR_IO},
        {"head -c 900 sums/index.json >bad.json", "bad.json:", IBL_ERR_FORMAT},
        {"echo '[]' >bad.json", "expected an object", IBL_ERR_FORMAT},
        {"cp set.json bad.json", "is a set to bake", IBL_ERR_FORMAT},
        {"sed 's/\"version\": 1,/\"version\": 2,/' sums/index.json >bad.json",
         "bad.json: version: expected 1 (bake the set again), found 2",
         IBL_ERR_FORMAT},
        {"sed 's/: \"small\"/: 7/' sums/index.json >bad.json",
         "bad.json: probes[1].name: expected a string that is not empty, "
         "found 7",
         IBL_ERR_FORMAT},
        {"sed 's/\"layer\": 3/\"layer\": 4/' sums/index.json >bad.json",
         "bad.json: global.layer: expected a whole number from 0 to 3, found 4",
         IBL_ERR_FORMAT},
        {"sed '/\"irradiance\": {/,/}/s/\"layers\": 4/\"layers\": 5/' "
         "cubes/index.json >bad.json",
         "bad.json: files.irradiance.layers: expected 4, as many as "
         "files.specular has, found 5",
         IBL_ERR_FORMAT},
        {"sed 's/: \"probes_/: \"..\\/probes_/' sums/index.json >bad.json",
         "bad.json: files.specular.file: expected the name of a file beside "
         "the index",
         IBL_ERR_FORMAT},
        {"sed 's/\"small\"/\"a\\\\nb\"/; s/\"blend\": 0,/\"blend\": -1/' "
         "sums/index.json | tr -d '\\n' | sed 's/\"priority\": 5/"
         "\"priority\": \"a\\\\nb\"/' >bad.json",
         "probes[0].priority: expected a whole number", IBL_ERR_FORMAT},
    };
    test_messages kept = {0};
    ibl_ctx_options o = ibl_ctx_options_default();
    ibl_probe_index x;

    bake("sums", "filament", "--irradiance sh");
    bake("cubes", "filament", "--irradiance 2");
    o.log = keep;
    o.log_cookie = &kept;
    ibl_ctx *ctx = test_ctx_of(&o);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        NEED(file_run("rm -rf bad.json; %s", cases[i].make));
        lines = 0;
        memset(&x, 0x55, sizeof x);
        const ibl_status status =
            ibl_probe_index_read(ctx, file_path("bad.json"), &x);
        CHECK_MSG(status == cases[i].status && lines == 1 &&
                      test_said(&kept, cases[i].said),
                  "%s: %s, %d lines: %s", cases[i].make,
                  ibl_status_text(status), lines, kept.text[IBL_LOG_ERROR]);
        CHECK(!x.count && !x.probe && !x.name && !x.sh && !x.specular.name);
        lines = 0;
        CHECK(ibl_probe_index_read(NULL, file_path("bad.json"), &x) == status);
        CHECK(lines == 0);
        ibl_probe_index_free(&x);
    }
}
