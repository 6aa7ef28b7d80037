/* SPDX-License-Identifier: MIT */
/* iblbake info: says what textures and environments are. */
#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "cli/batch.h"
#include "cli/console.h"
#include "common/names.h"
#include "common/path.h"
#include "common/signals.h"
#include "engine/engine.h"
#include "set/about.h"
#include "json/json_text.h"

enum {
    TEXELS_AUTO,
    TEXELS_YES,
    TEXELS_NO
};

typedef struct info_opts {
    ibl_common common;
    char **path; /* of the command line's words */
    int count, texels, json;
} info_opts;

/* ---- options --------------------------------------------------------- */

static const char *const texels_names[] = {"auto", "yes", "no", NULL};

#define IBL_SETTINGS info_opts

/* clang-format off */
static const ibl_option results[] = {
    {"texels", 0, IBL_CHOICE(texels, texels_names),
     .help = "also what is in the pixels: peak, mean, what is not finite, "
             "suns; auto: of files that are named, not of a directory's"},
    {"json", 0, IBL_FLAG(json),
     .help = "print one JSON document in place of text"},
};
/* clang-format on */

static const ibl_section *const sections[] = {
    IBL_SECTION("Results", results),
    &ibl_input_section,
    &ibl_running_section,
    NULL,
};

static void defaults(void *settings)
{
    *(info_opts *)settings = (info_opts){.common = ibl_common_default()};
}

/* Moves the word to the front, where all have been read. */
static bool take(void *settings, const char *word)
{
    info_opts *o = settings;

    o->path[o->count++] = (char *)word;
    return *word || ibl_misuse("an empty argument: info takes files and "
                               "directories");
}

static bool validate(void *settings)
{
    const info_opts *o = settings;

    if (!o->count)
        return ibl_misuse("no file: iblbake info [options] FILE|DIR..., see "
                          "iblbake info --help");
    return ibl_common_validate(&o->common);
}

/* ---- texels ---------------------------------------------------------- */

typedef struct figures {
    double peak, sum[3], weight;
    json_int_t nonfinite, negative; /* texels */
} figures;

static void put_figures(json_t **j, const figures *f, int channels)
{
    json_t *mean = json_array();

    for (int c = 0; c < channels; c++)
        append(&mean, json_real(f->weight > 0 ? f->sum[c] / f->weight : 0));
    put_all(j, json_pack("{sf so sI sI}", "peak", f->peak, "mean", mean,
                         "nonfinite", f->nonfinite, "negative", f->negative));
}

/* Means of maps are by solid angle, those of tables are not. Texels that are
 * not finite count only as that. */
static void measure(const ibl_texture *t, int level,
                    const ibl_level_shape *shape, figures *f)
{
    const int width = ibl_cube_edge(t->width, level);
    const int height = ibl_cube_edge(t->height, level);
    const int channels = ibl_pixel_channels(t->pixel);
    const size_t bytes = (size_t)width * ibl_pixel_bytes(t->pixel);
    const bool sphere = shape->width == width && shape->height == height;
    float *row =
        ibl_need(malloc((size_t)width * (size_t)channels * sizeof *row));
    double *weight = ibl_need(malloc((size_t)width * sizeof *weight));

    for (int y = 0; y < height; y++) {
        for (int x = 0; x < width; x++)
            weight[x] = sphere ? ibl_level_solid_angle(shape, x, y) : 1;
        for (int k = 0; k < t->layers * t->faces; k++) {
            const unsigned char *face =
                t->data +
                ibl_texture_layer_offset(t, level, k / t->faces, k % t->faces);
            ibl_pixel_decode(t->pixel, face + (size_t)y * bytes, (size_t)width,
                             row);
            for (int x = 0; x < width; x++) {
                const float *texel = row + x * channels;
                bool finite = true, negative = false;
                for (int c = 0; c < channels; c++) {
                    finite &= isfinite(texel[c]) != 0;
                    negative |= texel[c] < 0;
                }
                f->nonfinite += !finite;
                f->negative += finite && negative;
                f->weight += finite ? weight[x] : 0;
                for (int c = 0; c < channels && finite; c++) {
                    f->sum[c] += weight[x] * (double)texel[c];
                    f->peak = fmax(f->peak, (double)texel[c]);
                }
            }
        }
    }
    free(row);
    free(weight);
}

/* ---- files ----------------------------------------------------------- */

typedef struct info {
    const info_opts *o;
    ibl_console console;
    ibl_ctx *ctx;
    json_t *files;
    bool failed;
} info;

/* Those that KTX2 files of environments have, by their numbers in the Khronos
 * data format specification. */
static const char *primaries_of(const ibl_texture *t)
{
    static const char *const names[] = {
        [1] = "Rec.709", [4] = "Rec.2020", [6] = "ACES",
        [7] = "ACEScg",  [10] = "P3-D65",
    };
    const int count = sizeof names / sizeof *names, n = t->primaries;

    return n > 0 && n < count && names[n] ? names[n] : "unknown";
}

/* What the sidecar beside a file says of it: DDS files have no keys. NULL:
 * nothing; else the caller frees it. */
static json_t *beside(const char *path, ibl_about *about)
{
    const char *name = ibl_path_name(path), *end = strrchr(name, '_');
    char *side =
        ibl_need(ibl_format("%.*s.json", end ? (int)(end - path) : 0, path));
    struct stat st;
    ibl_json_why why;
    json_t *root =
        end && !stat(side, &st) ? ibl_json_load(side, 0, &why) : NULL;

    *about =
        ibl_about_sidecar(root, ibl_sidecar_entry(root, "file", name), path);
    free(side);
    return root;
}

static void put_levels(const ibl_texture *t, const ibl_about *about,
                       bool texels, json_t **j)
{
    const char *content = about->word[IBL_FACT_CONTENT];
    const bool map = content ? !strstr(content, "_lut")
                             : t->faces == 6 || t->width == 2 * t->height;
    const ibl_projection projection = ibl_texture_projection(t);
    const int unit = ibl_level_shape_of(projection, 1).width;
    json_t *levels = json_array();
    figures all = {0};
    const int channels = ibl_pixel_channels(t->pixel);

    if (map)
        put(j, "projection", json_string(ibl_projection_name(projection)));
    for (int l = 0; l < t->levels; l++) {
        const int width = ibl_cube_edge(t->width, l);
        const ibl_level_shape shape =
            ibl_level_shape_of(projection, map ? (width - 1) / unit + 1 : 1);
        json_t *level = json_pack("{si si}", "width", width, "height",
                                  ibl_cube_edge(t->height, l));
        figures f = {0};
        if (about->levels == t->levels && isfinite(about->roughness[l]))
            put(&level, "roughness", json_real(about->roughness[l]));
        if (texels) {
            measure(t, l, &shape, &f);
            put_figures(&level, &f, channels);
            all.peak = fmax(all.peak, f.peak);
            all.nonfinite += f.nonfinite;
            all.negative += f.negative;
        }
        if (!l)
            all = f;
        append(&levels, level);
    }
    if (texels)
        put_figures(j, &all, channels);
    put(j, "levels", levels);
}

static bool put_texture(const info *v, const char *path, ibl_texture *t,
                        bool texels, json_t **j)
{
    const ibl_engine engine = ibl_engine_of_name(path);
    ibl_about about = ibl_about_keys(t, path);
    json_t *keys = json_object();
    json_t *sidecar = t->key_count ? NULL : beside(path, &about);

    put_all(j, json_pack(
                   "{ss si si si si sI sb}", "pixel",
                   engine ? ibl_engine_pixel(engine) : ibl_pixel_name(t->pixel),
                   "width", t->width, "height", t->height, "faces", t->faces,
                   "layers", t->layers, "texel_bytes", (json_int_t)t->bytes,
                   "premultiplied", t->premultiplied));
    if (t->primaries)
        put(j, "primaries", json_string(primaries_of(t)));
    if (about.word[IBL_FACT_CONTENT])
        put(j, "content", ibl_json_string(about.word[IBL_FACT_CONTENT]));
    for (int i = 0; i < t->key_count; i++)
        put(&keys, t->keys[i].key, ibl_json_string(t->keys[i].value));
    put(j, "keys", keys);
    const bool ok = !texels || !ibl_texture_unblock(v->ctx, t);
    if (ok)
        put_levels(t, &about, texels, j);
    json_decref(sidecar);
    return ok;
}

static bool put_pixels(info *v, ibl_source *source, json_t **j)
{
    const ibl_read_report *report = ibl_source_report(source);
    const double *luma = report->luma;
    json_t *list = json_array();
    ibl_light light[IBL_MAX_LIGHTS];
    figures f = {.weight = 2};
    ibl_image map = {0};
    int count = 0;
    bool ok = !ibl_source_image(source, &map);

    for (int y = 0; y < map.height && ok; y++) {
        const double weight =
            cos(M_PI * y / map.height) - cos(M_PI * (y + 1) / map.height);
        const float *row = map.data + 3 * (size_t)y * (size_t)map.width;
        for (int k = 0; k < 3 * map.width; k++)
            f.sum[k % 3] += weight * (double)row[k] / map.width;
    }
    f.peak = (double)report->peak;
    f.nonfinite = (json_int_t)report->nonfinite;
    f.negative = (json_int_t)report->negative;
    put_figures(j, &f, 3);
    v->console.quiet = true; /* not told how many there are not */
    ok = ok &&
         !ibl_image_take_lights(v->ctx, &map, 0, IBL_MAX_LIGHTS, light, &count);
    v->console.quiet = v->o->common.quiet;
    for (int i = 0; i < count && ok; i++) {
        const double *d = light[i].direction, *e = light[i].irradiance;
        double own = 0, all = 0;
        for (int c = 0; c < 3; c++) {
            own += luma[c] * e[c];
            all += luma[c] * f.sum[c] * 2 * M_PI;
        }
        append(&list,
               json_pack("{s[fff] sf s[fff] sf}", "direction", d[0], d[1], d[2],
                         "radius_deg", light[i].radius * 180 / M_PI,
                         "irradiance", e[0], e[1], e[2], "share", own / all));
    }
    put(j, "lights", list);
    ibl_image_free(&map);
    return ok;
}

static bool put_map(info *v, const char *path, bool texels, json_t **j)
{
    ibl_source *source;

    if (ibl_source_open(v->ctx, path, &v->o->common.read, &source))
        return false;
    const ibl_read_report *r = ibl_source_report(source);
    put_all(j, json_pack("{ss si si ss}", "format",
                         *r->format ? r->format : "Radiance", "width",
                         ibl_source_width(source), "height",
                         ibl_source_height(source), "layout",
                         ibl_input_layout_name(r->layout)));
    if (r->low_range)
        put(j, "integers", json_string(r->low_range == 1 ? "srgb" : "linear"));
    if (r->has_primaries)
        put(j, "primaries",
            json_string(*r->primaries_name ? r->primaries_name : "others"));
    const bool ok = !texels || put_pixels(v, source, j);
    if (texels) /* known only now of Radiance's */
        put(j, "format", json_string(r->format));
    ibl_source_close(source);
    return ok;
}

/* NULL: failed, after a message. */
static json_t *describe(info *v, const char *path, bool named)
{
    const bool texels =
        v->o->texels == TEXELS_AUTO ? named : v->o->texels == TEXELS_YES;
    json_t *j = json_pack("{so}", "file", ibl_json_string(path));
    int format = -1;
    ibl_texture t = {0};
    struct stat st;
    bool ok = true;

    if (!stat(path, &st) && S_ISREG(st.st_mode)) {
        put(&j, "bytes", json_integer(st.st_size));
        ok = !ibl_engine_look(v->ctx, path, texels, &t, &format);
    }
    if (format >= 0)
        put(&j, "format", json_string(ibl_format_names[format]));
    ok = ok && (format >= 0 ? put_texture(v, path, &t, texels, &j)
                            : put_map(v, path, texels, &j));
    ibl_texture_free(&t);
    if (!ok)
        json_decref(j);
    return ok ? j : NULL;
}

/* ---- text ------------------------------------------------------------ */

/* Prints and frees a line. */
static void print_line(char *line)
{
    ibl_one_line(line);
    puts(line);
    free(line);
}

/* Members of objects as "KEY VALUE", two blanks between them. */
static void append_value(char **line, const json_t *value)
{
    const char *key, *between = "";
    json_t *member;
    size_t i;

    if (json_is_string(value))
        ibl_append(line, "%s", json_string_value(value));
    else if (json_is_integer(value))
        ibl_append(line, "%lld", (long long)json_integer_value(value));
    else if (json_is_real(value))
        ibl_append(line, "%.6g", json_real_value(value));
    else if (json_is_array(value) && !json_array_size(value))
        ibl_append(line, "none");
    else if (json_is_boolean(value))
        ibl_append(line, json_is_true(value) ? "yes" : "no");
    json_array_foreach(value, i, member)
    {
        ibl_append(line, "%s", i ? " " : "");
        append_value(line, member);
    }
    json_object_foreach((json_t *)value, key, member)
    {
        ibl_append(line, "%s%s ", between, key);
        append_value(line, member);
        between = "  ";
    }
}

/* Members of objects, and of lists of objects, have a line each. */
static void print_member(const char *name, json_t *value)
{
    const bool list = json_is_object(json_array_get(value, 0));
    const char *key;
    char *line = NULL;
    json_t *part;
    size_t i;

    json_object_foreach(value, key, part)
    {
        print_member(key, part);
    }
    json_array_foreach(list ? value : NULL, i, part)
    {
        line = NULL;
        ibl_append(&line, "%.*s %-12zu", (int)strlen(name) - 1, name, i);
        append_value(&line, part);
        print_line(line);
    }
    if (list || json_is_object(value))
        return;
    ibl_append(&line, "%-17s ", name);
    append_value(&line, value);
    print_line(line);
}

static void print_row(json_t *file)
{
    static const char *const names[] = {"peak", "mean", "nonfinite",
                                        "negative"};
    int width = 0, height = 0, faces = 1;
    json_int_t bytes = 0;
    char size[64], kind[80], *line = NULL;

    json_unpack(file, "{s?I s?i s?i s?i}", "bytes", &bytes, "width", &width,
                "height", &height, "faces", &faces);
    snprintf(size, sizeof size, "%dx%d%s", width, height,
             faces == IBL_FACES ? "x6" : "");
    snprintf(kind, sizeof kind, "%s %s", text_of(file, "format"),
             text_of(file, "pixel"));
    ibl_append(&line, "%12lld  %-12s %2zu  %-26s  %s", (long long)bytes, size,
               json_array_size(json_object_get(file, "levels")), kind,
               text_of(file, "file"));
    for (size_t i = 0; i < 4 && json_object_get(file, "peak"); i++) {
        ibl_append(&line, "  %s ", names[i]);
        append_value(&line, json_object_get(file, names[i]));
    }
    print_line(line);
}

/* ---- the command ------------------------------------------------------ */

static void look_at(info *v, const char *path, bool named)
{
    json_t *j = describe(v, path, named);

    ibl_console_finish(&v->console);
    v->failed |= !j;
    v->console.failed = false; /* that was of this file */
    if (j && v->o->json) {
        append(&v->files, j);
        return;
    }
    if (j && !v->o->common.quiet && named) {
        print_member("", j);
        fputs(v->o->count > 1 ? "\n" : "", stdout);
    } else if (j && !v->o->common.quiet)
        print_row(j);
    json_decref(j);
}

/* Whether a file may be a texture or an environment, by its name. */
static bool is_candidate(const char *name)
{
    const char *dot = strrchr(name, '.');

    return *name != '.' && dot &&
           (ibl_is_environment(name) || ibl_engine_of_name(name) ||
            ibl_names_find(ibl_array_container_names, dot + 1) >= 0);
}

static void look_into(info *v, const char *folder)
{
    char **list;
    const int count = ibl_path_list(folder, is_candidate, &list);
    struct stat st;

    v->failed |= count <= 0;
    if (count < 0)
        ibl_console_fail(&v->console, "%s: cannot be listed: %s", folder,
                         strerror(errno));
    else if (!count)
        ibl_console_fail(&v->console,
                         "%s: is a directory without textures and "
                         "environments: name the files themselves",
                         folder);
    v->console.failed = false;
    for (int i = 0; i < count; i++) {
        char *path = ibl_need(ibl_path_join(folder, list[i]));
        if (!stat(path, &st) && S_ISREG(st.st_mode) &&
            (ibl_engine_of_name(path) != IBL_ENGINE_GLTF ||
             ibl_gltf_is_light(path)))
            look_at(v, path, false);
        free(path);
        free(list[i]);
    }
    free(list);
}

static int run(const void *settings)
{
    const info_opts *o = settings;
    info v = {.o = o, .files = json_array()};
    struct stat st;

    ibl_console_init(&v.console, o->common.quiet, o->common.verbose);
    const bool ok = !ibl_start(&o->common, &v.console, &v.ctx);
    for (int i = 0; i < o->count && ok; i++) {
        if (!stat(o->path[i], &st) && S_ISDIR(st.st_mode))
            look_into(&v, o->path[i]);
        else
            look_at(&v, o->path[i], true);
    }
    json_t *root = json_pack("{so}", "files", v.files);
    char *text = ibl_need(ibl_json_text(root));
    if (o->json && ok)
        fputs(text, stdout);
    free(text);
    json_decref(root);
    const int status = ibl_console_end(&v.console, ok);
    ibl_ctx_free(v.ctx);
    return status || v.failed;
}

const ibl_command ibl_info_command = {
    .name = "info",
    .usage = "[options] FILE|DIR...",
    .brief = "say what textures and environments are",
    .intro = "Prints the container, size, levels, pixel format and keys of "
             "textures, the\n"
             "format of environments, what is in their pixels, and a line for "
             "each file of a\n"
             "directory.\n",
    .statuses = "0 done, 1 a file cannot be read, 2 wrong usage",
    .sections = sections,
    .settings_size = sizeof(info_opts),
    .defaults = defaults,
    .words = offsetof(info_opts, path),
    .take = take,
    .validate = validate,
    .run = run,
};
