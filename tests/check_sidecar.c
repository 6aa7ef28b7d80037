/* SPDX-License-Identifier: MIT */
/* The sidecar of a bake by the library is that of the program, for the same
 * map and options, to a reader of JSON that others wrote; and what is refused.
 */
#include <jansson.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "files.h"
#include "ibl/sidecar.h"
#include "test.h"

enum {
    SIZE = 32,
    OUTPUTS = 5
};

/* A bake like the program's; members that are 0 are its defaults. */
typedef struct like {
    const char *options; /* of the program, "--" and all */
    ibl_key_value given[12];
    ibl_axes axes;
    double yaw_deg, exposure, clamp;
    int most; /* lights; 0: none are taken */
    ibl_pixel pixel;
    int zstd;
    ibl_projection projection;
} like;

/* What a sidecar needs, kept. */
typedef struct bake {
    ibl_ctx *ctx;
    const like *of;
    ibl_read_options read;
    ibl_read_report report;
    ibl_bake_options options;
    ibl_bake_result made;
    ibl_light lights[IBL_MAX_LIGHTS];
    int light_count, width, height;
    ibl_texel_options texels;
    ibl_lut_options lut_options;
    ibl_lobe_table_options lobe_options;
    ibl_lobe_table lobes;
    ibl_texture texture[OUTPUTS];
    ibl_overflow_report overflow[OUTPUTS];
    ibl_pixel_error error[OUTPUTS][IBL_MAX_LEVELS];
    char hash[OUTPUTS][IBL_FILE_HASH];
    ibl_sidecar_output output[OUTPUTS];
    ibl_sidecar_options facts;
} bake;

/* ---- a bake by the library ----------------------------------------------- */

static void read_and_bake(bake *b, const char *map)
{
    ibl_image env, rest;

    b->read.hash = 1;
    b->read.exposure = b->of->exposure;
    b->read.clamp = b->of->clamp;
    NEED(!ibl_image_read(b->ctx, map, &b->read, &env, &b->report));
    b->width = env.width;
    b->height = env.height;
    b->options.skybox = SIZE;
    b->options.skybox_projection = b->of->projection;
    b->options.specular_options.projection = b->of->projection;
    b->options.irradiance_options.projection = b->of->projection;
    b->options.specular_options.size = SIZE;
    b->options.yaw_deg = b->of->yaw_deg;
    NEED(!ibl_image_alloc(b->ctx, env.width, env.height, &rest));
    memcpy(rest.data, env.data,
           (size_t)env.width * (size_t)env.height * 3 * sizeof *env.data);
    if (b->of->most)
        NEED(!ibl_image_take_lights(b->ctx, &rest, b->of->yaw_deg, b->of->most,
                                    b->lights, &b->light_count));
    NEED(!ibl_bake_environment(b->ctx, &(ibl_environment){.image = &rest},
                               &b->options, &b->made));
    ibl_image_free(&rest);
    /* The skybox keeps the lights. */
    ibl_bake_options sky = b->options;
    ibl_bake_result only;
    sky.specular = sky.irradiance = 0;
    sky.sh_degree = -1;
    NEED(!ibl_bake_environment(b->ctx, &(ibl_environment){.image = &env}, &sky,
                               &only));
    ibl_cube_free(&b->made.skybox);
    b->made.skybox = only.skybox;
    ibl_image_free(&env);
}

static void encode(bake *b, ibl_content content, const ibl_cube *cube)
{
    ibl_cube turned = {0};

    if (b->of->axes.mirror || b->of->axes.up) {
        NEED(!ibl_cube_turn_axes(b->ctx, cube, b->of->axes, 0, &turned));
        cube = &turned;
    }
    NEED(!ibl_texture_from_cube(b->ctx, cube, &b->texels, &b->texture[content],
                                &b->overflow[content]));
    NEED(!ibl_texture_errors(b->ctx, &b->texture[content], cube,
                             b->error[content]));
    ibl_cube_free(&turned);
}

static void make_tables(bake *b)
{
    ibl_lut lut;

    b->lobe_options.layout = b->made.report.layout;
    NEED(!ibl_bake_lut(b->ctx, &b->lut_options, &lut));
    NEED(!ibl_texture_from_lut(b->ctx, &lut, IBL_PIXEL_RG16F,
                               &b->texture[IBL_CONTENT_LUT], NULL));
    ibl_lut_free(&lut);
    NEED(!ibl_bake_lobe_table(b->ctx, &b->lobe_options, &b->lobes));
    NEED(!ibl_texture_from_lobe_table(b->ctx, &b->lobes,
                                      &b->texture[IBL_CONTENT_LOBE_TABLE]));
}

/* Files of the folder "out", whose sizes are the program's. */
static void list_outputs(bake *b)
{
    static const char *const files[OUTPUTS] = {
        "map_skybox.ktx2", "map_specular.ktx2", "map_irradiance.ktx2",
        "brdf_lut.ktx2", "map_lobe_lut.ktx2"};
    struct stat st;

    for (int i = 0; i < OUTPUTS; i++) {
        const bool found = !stat(file_path(test_text("out/%s", files[i])), &st);
        CHECK_MSG(found, "no %s", files[i]);
        CHECK(!ibl_hash_file(file_path(test_text("out/%s", files[i])),
                             b->hash[i]));
        b->texture[i].zstd = b->of->zstd;
        b->output[i] = (ibl_sidecar_output){
            .content = (ibl_content)i,
            .file = files[i],
            .container = ibl_container_name(IBL_CONTAINER_KTX2),
            .texture = &b->texture[i],
            .bytes = found ? (size_t)st.st_size : 0,
            .hash = b->hash[i],
            .projection = b->of->projection,
            .texels = &b->texels,
            .overflow = &b->overflow[i],
            .error = b->error[i],
        };
    }
}

static void free_bake(void *bake_of)
{
    bake *b = bake_of;

    for (int i = 0; i < OUTPUTS; i++)
        ibl_texture_free(&b->texture[i]);
    ibl_lobe_table_free(&b->lobes);
    ibl_bake_result_free(&b->made);
    free(b);
}

static bake *bake_like(const like *of, const char *map)
{
    bake *b = calloc(1, sizeof *b);
    int given = 0;

    NEED(b);
    test_defer(free_bake, b);
    b->ctx = test_ctx(2, IBL_ISA_AUTO);
    b->of = of;
    b->read = ibl_read_options_default();
    b->options = ibl_bake_options_default();
    b->texels = ibl_texel_options_default();
    b->texels.pixel = of->pixel;
    b->lut_options = ibl_lut_options_default();
    b->lobe_options = ibl_lobe_table_options_default();
    read_and_bake(b, map);
    encode(b, IBL_CONTENT_SKYBOX, &b->made.skybox);
    encode(b, IBL_CONTENT_SPECULAR, &b->made.specular);
    encode(b, IBL_CONTENT_IRRADIANCE, &b->made.irradiance);
    make_tables(b);
    NEED(!ibl_sh_turn_axes(b->ctx, 2, of->axes, 0, b->made.sh));
    while (of->given[given].key)
        given++;
    b->facts = ibl_sidecar_options_default();
    b->facts.source = map;
    b->facts.width = b->width;
    b->facts.height = b->height;
    b->facts.read = &b->read;
    b->facts.report = &b->report;
    b->facts.specular = &b->options.specular_options;
    b->facts.lobe_table = &b->lobe_options;
    b->facts.yaw_deg = of->yaw_deg;
    b->facts.axes = of->axes;
    b->facts.made = &b->made;
    b->facts.lights = b->lights;
    b->facts.light_count = of->most ? b->light_count : -1;
    b->facts.outputs = b->output;
    b->facts.output_count = OUTPUTS;
    b->facts.options = of->given;
    b->facts.option_count = given;
    return b;
}

/* ---- the same ---------------------------------------------------------- */

static void save_text(const bake *b, const char *name)
{
    char *text;

    NEED(!ibl_sidecar_text(b->ctx, &b->facts, &text));
    NEED(file_save(file_path(name), text, strlen(text)));
    ibl_bytes_free(text);
}

static void free_json(void *text)
{
    free(text);
}

/* What jansson reads, in its order, but for the program's revision. */
static const char *read_json(const char *name)
{
    json_t *root = json_load_file(file_path(name), 0, NULL);

    json_object_del(json_object_get(root, "generator"), "revision");
    char *text = json_dumps(root, JSON_INDENT(1));
    json_decref(root);
    NEED(text);
    test_defer(free_json, text);
    return text;
}

static void expect_same(const char *a, const char *b, const char *what)
{
    const char *x = read_json(a), *y = read_json(b);
    size_t at = 0;

    while (x[at] && x[at] == y[at])
        at++;
    CHECK_MSG(x[at] == y[at], "%s: %.60s, not %.60s", what, x + at, y + at);
}

/* The keys of the program's files are the library's, but for KTX's own. */
static void expect_same_keys(bake *b)
{
    for (int i = 0; i < OUTPUTS; i++) {
        ibl_texture *ours = &b->texture[i], file;
        int count = 0;
        NEED(!ibl_texture_describe(b->ctx, ours, &b->facts, &b->output[i]));
        NEED(!ibl_texture_read(
            b->ctx, file_path(test_text("out/%s", b->output[i].file)), &file,
            NULL));
        for (int k = 0; k < file.key_count; k++) {
            const char *key = file.keys[k].key;
            const char *mine = ibl_texture_get(ours, key);
            const bool own = strncmp(key, "iblbake.", 8) != 0;
            CHECK_MSG(own || (mine && !strcmp(mine, file.keys[k].value)),
                      "%s: %s is %s, not %s", b->output[i].file, key,
                      mine ? mine : "not set", file.keys[k].value);
            count += !own;
        }
        CHECK_MSG(count >= 2 && count == ours->key_count, "%s: %d keys of %d",
                  b->output[i].file, count, ours->key_count);
        ibl_texture_free(&file);
    }
}

TEST(what_the_library_says_the_program_says)
{
    static const like all[] = {
        {"", {{0}}, .pixel = IBL_PIXEL_RGBA16F},
        {"--lights 3 --mirror x --up z --rotate 30 --exposure 12 --pixel "
         "rgb9e5",
         {{"lights", "3"},
          {"mirror", "x"},
          {"up", "z"},
          {"rotate", "30"},
          {"exposure", "12"},
          {"pixel", "rgb9e5"}},
         .most = 3,
         .axes = {IBL_MIRROR_X, IBL_UP_Z},
         .yaw_deg = 30,
         .exposure = 12,
         .pixel = IBL_PIXEL_RGB9E5},
        {"--exposure -1 --clamp 4 --pixel bc6h --zstd 3",
         {{"exposure", "-1"}, {"clamp", "4"}, {"pixel", "bc6h"}, {"zstd", "3"}},
         .exposure = -1,
         .clamp = 4,
         .pixel = IBL_PIXEL_BC6H,
         .zstd = 3},
        {"--layout octahedral",
         {{"layout", "octahedral"}},
         .pixel = IBL_PIXEL_RGBA16F,
         .projection = IBL_PROJECTION_OCTAHEDRAL},
    };
    const char *map = file_path("map.exr");

    NEED(file_run("cp '%s/data/sky.exr' map.exr", getenv("PWD")));
    for (size_t i = 0; i < sizeof all / sizeof *all; i++) {
        like of = all[i];
        ibl_key_value *o = of.given;
        while (o->key)
            o++;
        *o++ = (ibl_key_value){"size", "32"};
        *o++ = (ibl_key_value){"skybox", "32"};
        *o = (ibl_key_value){NULL, NULL};
        NEED(file_run("rm -rf out; '%s' '%s' -q -o out %s --size 32 --skybox "
                      "32",
                      file_built("iblbake"), map, all[i].options));
        bake *b = bake_like(&of, map);
        list_outputs(b);
        save_text(b, "ours.json");
        expect_same("out/map.json", "ours.json", all[i].options);
        expect_same_keys(b);
    }
}

/* ---- what is said in words --------------------------------------------- */

static int lines;

static void count_line(void *cookie, ibl_log_level level, const char *text)
{
    lines += level == IBL_LOG_ERROR && !strchr(text, '\n');
    test_keep(cookie, level, text);
}

static ibl_ctx *counting(test_messages *kept)
{
    ibl_ctx_options o = ibl_ctx_options_default();

    o.threads = 1;
    o.log = count_line;
    o.log_cookie = kept;
    lines = 0;
    return test_ctx_of(&o);
}

static const ibl_read_report no_report;
static const ibl_bake_result no_bake;

/* As little as there can be. */
static ibl_sidecar_options least(void)
{
    ibl_sidecar_options o = ibl_sidecar_options_default();

    o.source = "a map";
    o.report = &no_report;
    o.made = &no_bake;
    return o;
}

TEST(strings_of_any_bytes)
{
    static const ibl_key_value options[] = {{"a \"key\"\n", "\xff"},
                                            {"plain", NULL}};
    const ibl_texture flat = {.pixel = IBL_PIXEL_RG16F,
                              .width = 4,
                              .height = 4,
                              .levels = 1,
                              .layers = 1,
                              .faces = 1};
    const ibl_sidecar_output output = {.content = IBL_CONTENT_LUT,
                                       .file = "50%.dds",
                                       .container = "dds",
                                       .texture = &flat};
    ibl_sidecar_options o = least();
    test_messages kept;
    char *text;
    const char *source, *file, *revision, *target, *value, *own;
    int plain, count;

    o.outputs = &output;
    o.output_count = 1;
    o.options = options;
    o.option_count = 2;
    o.revision = "r \xc3\xa9";
    o.target = "\xfd";
    o.more = "{\"mine\": {\"of\": \"a program\"}}";
    NEED(!ibl_sidecar_text(counting(&kept), &o, &text));
    json_t *root = json_loads(text, JSON_REJECT_DUPLICATES, NULL);
    NEED(root);
    CHECK(text[strlen(text) - 1] == '\n');
    CHECK(!json_unpack(root,
                       "{s:{s:s}, s:[{s:s}], s:{s:s}, s:s, s:{s:s, s:b}, "
                       "s:{s:s}}",
                       "source", "path", &source, "outputs", "file", &file,
                       "generator", "revision", &revision, "target", &target,
                       "options", options[0].key, &value, "plain", &plain,
                       "mine", "of", &own));
    CHECK(!strcmp(source, "a map") && !strcmp(file, "50%.dds"));
    CHECK(!strcmp(own, "a program"));
    CHECK(!strcmp(revision, "r \xc3\xa9") && plain);
    CHECK(!strcmp(target, "\xef\xbf\xbd") && !strcmp(value, "\xef\xbf\xbd"));
    count = (int)json_object_size(root);
    CHECK_MSG(count == 9 && !json_object_get(root, "sh") &&
                  !json_object_get(root, "lights"),
              "%d members", count);
    json_decref(root);
    ibl_bytes_free(text);
}

/* ---- what will not do -------------------------------------------------- */

TEST(wrong_facts_are_refused_in_one_line)
{
    const ibl_texture cube = {.levels = 3}, none = {.levels = 0};
    ibl_sidecar_output outputs[4];
    static const ibl_key_value option = {"\xff", "1"};
    static const char *const said[] = {
        "made is NULL",
        "source, report",
        "source, report",
        "facts of a bake: lights: 65",
        "facts of a bake: lights: 1: must be -1 to 0",
        "bake: outputs: -1",
        "mirror 9",
        "a key is no UTF-8",
        "more of a sidecar",
        "more of a sidecar",
        "degree of sh: ",
        "texture is NULL",
        "a: 0 levels: must be 1 to 15",
        "a: 3 levels: must be 1 to 0",
        "content 5: must be 0 to 4",
    };
    enum {
        CASES = sizeof said / sizeof *said,
        OF_OUTPUTS = CASES - (int)(sizeof outputs / sizeof *outputs)
    };
    static double sh[3];
    const ibl_bake_result lit = {.sh = sh};
    ibl_sidecar_options o[CASES];
    test_messages kept;
    ibl_ctx *ctx = counting(&kept);
    char *text = "";

    for (int i = 0; i < CASES; i++) {
        o[i] = least();
        o[i].outputs = i < OF_OUTPUTS ? NULL : &outputs[i - OF_OUTPUTS];
        o[i].output_count = i >= OF_OUTPUTS;
    }
    for (int i = 0; i < 4; i++)
        outputs[i] = (ibl_sidecar_output){
            .file = "a", .container = "ktx2", .texture = &cube};
    outputs[0].texture = NULL;
    outputs[1].texture = &none;
    outputs[2].content = IBL_CONTENT_SPECULAR;
    outputs[3].content = (ibl_content)5;
    o[0].made = NULL;
    o[1].source = NULL;
    o[2].report = NULL;
    o[3].light_count = 65;
    o[4].light_count = 1;
    o[5].output_count = -1;
    o[6].axes.mirror = (ibl_mirror)9;
    o[7].options = &option;
    o[7].option_count = 1;
    o[8].more = "[]";
    o[9].more = "{";
    o[10].sh_degree = IBL_MAX_SH_DEGREE + 1;
    o[10].made = &lit;
    for (int i = 0; i < CASES; i++) {
        lines = 0;
        CHECK(ibl_sidecar_text(ctx, &o[i], &text) == IBL_ERR_ARGUMENT);
        CHECK_MSG(lines == 1 && !text && test_said(&kept, said[i]),
                  "%d: %d lines: %s", i, lines, kept.text[IBL_LOG_ERROR]);
    }
    ibl_texture tex = {0};
    ibl_sidecar_output own = {.content = (ibl_content)5};
    o[0] = least();
    CHECK(ibl_texture_describe(ctx, &tex, &o[0], &own) == IBL_ERR_ARGUMENT);
    CHECK(test_said(&kept, "content 5: must be 0 to 4"));
    own.content = IBL_CONTENT_SKYBOX;
    CHECK(ibl_texture_describe(ctx, &tex, &o[6], &own) == IBL_ERR_ARGUMENT);
    CHECK(test_said(&kept, "mirror 9"));
    ibl_lobe_table_options table = ibl_lobe_table_options_default();
    o[0].lobe_table = &table;
    own.content = IBL_CONTENT_LOBE_TABLE;
    table.f0 = (ibl_f0)3;
    CHECK(ibl_texture_describe(ctx, &tex, &o[0], &own) == IBL_ERR_ARGUMENT);
    CHECK(test_said(&kept, "F0 of the lobe table: 3: must be 0 to 2"));
    table = ibl_lobe_table_options_default();
    table.layout.levels = IBL_MAX_LEVELS + 1;
    CHECK(ibl_texture_describe(ctx, &tex, &o[0], &own) == IBL_ERR_ARGUMENT);
    CHECK(test_said(&kept, "levels of the lobe table: 16"));
    CHECK(!tex.key_count);
    ibl_texture_free(&tex);
}

static int left = -1; /* of jansson's allocations, until one fails */

static void *scarce(size_t size)
{
    return left >= 0 && left-- == 0 ? NULL : malloc(size);
}

/* Whichever allocation fails: all of it, or nothing and a line. */
TEST(memory_may_run_out)
{
    ibl_sidecar_options o = least();
    test_messages kept;
    ibl_ctx *ctx = counting(&kept);
    char *whole = NULL;
    int failures = 0;

    o.light_count = 0;
    NEED(!ibl_sidecar_text(ctx, &o, &whole));
    json_set_alloc_funcs(scarce, free);
    left = 0;
    for (int n = 0; left < 0 || n == 0; n++) {
        char *text;
        left = n;
        lines = 0;
        const ibl_status status = ibl_sidecar_text(ctx, &o, &text);
        CHECK_MSG(status ? !text && lines == 1 && status == IBL_ERR_MEMORY
                         : !strcmp(text, whole) && !lines,
                  "after %d: %s", n, ibl_status_text(status));
        failures += status != IBL_OK;
        ibl_bytes_free(text);
    }
    left = -1;
    CHECK_MSG(failures > 50, "%d failures", failures);
    ibl_bytes_free(whole);
}
