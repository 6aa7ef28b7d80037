/* SPDX-License-Identifier: MIT */
#include "cli/verify_files.h"

#include <errno.h>
#include <float.h>
#include <jansson.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "cli/faces.h"
#include "common/json_load.h"
#include "common/names.h"
#include "common/path.h"
#include "common/text.h"

typedef struct reader {
    const ibl_verify_opts *opts;
    ibl_ctx *ctx;
    ibl_console *console;
    char *sidecar_path;
    json_t *sidecar; /* NULL: there is none */
    ibl_verify_files *files;
} reader;

/* ---- finding --------------------------------------------------------- */

/* The path of a file in the directory; NULL: no memory. */
static char *in_directory(const reader *r, const char *fmt, ...)
    __attribute__((format(printf, 2, 3)));
static char *in_directory(const reader *r, const char *fmt, ...)
{
    char name[1024];
    va_list ap;

    va_start(ap, fmt);
    vsnprintf(name, sizeof name, fmt, ap);
    va_end(ap);
    return ibl_path_join(r->opts->directory, name);
}

/* The sidecar's account of a file, or NULL. */
static json_t *find_output(const reader *r, ibl_output_kind kind)
{
    json_t *outputs = json_object_get(r->sidecar, "outputs"), *output;
    size_t i;

    json_array_foreach(outputs, i, output)
    {
        const char *content;
        if (!json_unpack(output, "{s:s}", "content", &content) &&
            !strcmp(content, ibl_output_content(kind)))
            return output;
    }
    return NULL;
}

static ibl_status open_sidecar(reader *r)
{
    const ibl_verify_opts *o = r->opts;
    ibl_json_why why;
    struct stat st;

    if (stat(o->directory, &st))
        return ibl_refuse(r->console, IBL_ERR_IO,
                          "%s: %s: give the directory of a bake", o->directory,
                          strerror(errno));
    if (!S_ISDIR(st.st_mode))
        return ibl_refuse(
            r->console, IBL_ERR_IO,
            "%s: not a directory: give the environment first, then "
            "the directory of its bake",
            o->directory);
    r->sidecar_path = in_directory(r, "%s.json", o->name);
    if (!r->sidecar_path)
        return IBL_ERR_MEMORY;
    if (access(r->sidecar_path, F_OK))
        return IBL_OK;
    r->sidecar = ibl_sidecar_load(r->sidecar_path, &why);
    if (r->sidecar)
        return IBL_OK;
    return ibl_refuse(r->console, why.damaged ? IBL_ERR_FORMAT : IBL_ERR_IO,
                      "%s%s", why.line,
                      why.damaged ? ": bake again, or remove it and say what "
                                    "the files mean"
                                  : "");
}

/* The file that the sidecar names; *path stays NULL if it names none. */
static ibl_status find_named(const reader *r, ibl_output_kind kind, char **path)
{
    const char *file;

    if (json_unpack(find_output(r, kind), "{s:s}", "file", &file) ||
        strchr(file, '/'))
        return IBL_OK;
    *path = in_directory(r, "%s", file);
    if (!*path)
        return IBL_ERR_MEMORY;
    if (access(*path, F_OK))
        return ibl_refuse(r->console, IBL_ERR_IO,
                          "%s: %s names it, but it is not there: bake again",
                          *path, r->sidecar_path);
    return IBL_OK;
}

/* The file of any container with this stem, which kind's outputs have. */
static ibl_status find_there(const reader *r, ibl_output_kind kind,
                             const char *stem, const char *suffix, char **path)
{
    for (int c = 0; c < IBL_CONTAINER_COUNT; c++) {
        char *candidate = in_directory(r, "%s%s.%s", stem, suffix,
                                       ibl_container_name((ibl_container)c));
        if (!candidate)
            return IBL_ERR_MEMORY;
        if (access(candidate, F_OK)) {
            free(candidate);
        } else if (!*path) {
            *path = candidate;
        } else {
            ibl_console_fail(r->console,
                             "%s: %s is there, too: name the one to judge with "
                             "--%s",
                             candidate, *path, ibl_output_name(kind));
            free(candidate);
            return IBL_ERR_ARGUMENT;
        }
    }
    return IBL_OK;
}

static ibl_status find_file(const reader *r, ibl_output_kind kind, char **path)
{
    static const char *const suffixes[] = {"_skybox", "_specular",
                                           "_irradiance"};
    const char *given = r->opts->files[kind];

    if (given) {
        *path = strdup(given);
        return *path ? IBL_OK : IBL_ERR_MEMORY;
    }
    if (!r->opts->directory)
        return IBL_OK;
    ibl_status status = find_named(r, kind, path);
    if (!status && !*path && kind != IBL_OUTPUT_LUT)
        return find_there(r, kind, r->opts->name, suffixes[kind], path);
    for (int i = 0; ibl_lut_stems[i] && !status && !*path; i++)
        status = find_there(r, kind, ibl_lut_stems[i], "", path);
    return status;
}

static ibl_status find_files(const reader *r)
{
    char **path = r->files->path;

    for (int kind = 0; kind < IBL_VERIFY_KINDS; kind++) {
        const ibl_status status =
            find_file(r, (ibl_output_kind)kind, &path[kind]);
        if (status)
            return status;
    }
    if (!r->opts->directory || path[IBL_OUTPUT_SKYBOX] ||
        path[IBL_OUTPUT_SPECULAR] || path[IBL_OUTPUT_IRRADIANCE])
        return IBL_OK;
    return ibl_refuse(r->console, IBL_ERR_IO,
                      "%s: has no %s_specular, _irradiance or _skybox (.ktx2, "
                      ".ktx, .dds): give the --name of the bake",
                      r->opts->directory, r->opts->name);
}

/* ---- what files say -------------------------------------------------- */

int ibl_roughness_list(const char *text, double list[IBL_MAX_LEVELS])
{
    for (int i = 0; i < IBL_MAX_LEVELS; i++) {
        const char *end;
        if (!ibl_number_real(text, 0, 1, &list[i], &end))
            return 0;
        if (!*end)
            return i + 1;
        if (*end != ',')
            return 0;
        text = end + 1;
    }
    return 0;
}

/* The same of an array of levels. */
static int read_levels(json_t *levels, double list[IBL_MAX_LEVELS])
{
    json_t *level;
    size_t l;

    json_array_foreach(levels, l, level)
    {
        if (l == IBL_MAX_LEVELS ||
            json_unpack(level, "{s:F}", "roughness", &list[l]) ||
            !(list[l] >= 0 && list[l] <= 1))
            return 0;
    }
    return (int)json_array_size(levels);
}

/* The value of the texture's key, else of the sidecar if it found the file. */
static const char *said(const reader *r, ibl_output_kind kind,
                        const ibl_texture *tex, const char *key)
{
    char name[64];

    snprintf(name, sizeof name, "iblbake.%s", key);
    const char *text = ibl_texture_get(tex, name);
    if (text || r->opts->files[kind])
        return text;
    return json_string_value(json_object_get(find_output(r, kind), key));
}

/* The roughness of each level; list has at least those of the chain. */
static ibl_status find_roughness(const reader *r, const ibl_texture *tex,
                                 int levels, double list[IBL_MAX_LEVELS])
{
    const ibl_verify_map *m = &r->opts->roughness;
    const char *path = r->files->path[IBL_OUTPUT_SPECULAR];
    const char *key = ibl_texture_get(tex, "iblbake.roughness");
    const char *who = key ? "its key iblbake.roughness" : r->sidecar_path;
    json_t *array = NULL;

    if (m->count && m->count != levels)
        return ibl_refuse(r->console, IBL_ERR_ARGUMENT,
                          "%s: has %d levels, but --roughness-map lists %d",
                          path, levels, m->count);
    if (!r->opts->files[IBL_OUTPUT_SPECULAR])
        array = json_object_get(find_output(r, IBL_OUTPUT_SPECULAR), "levels");
    if (m->given || (!key && !array)) {
        for (int l = 0; l < levels; l++)
            list[l] =
                m->count ? m->list[l] : ibl_level_roughness(m->map, l, levels);
        return IBL_OK;
    }
    const int count =
        key ? ibl_roughness_list(key, list) : read_levels(array, list);
    if (count == levels)
        return IBL_OK;
    if (count)
        return ibl_refuse(r->console, IBL_ERR_FORMAT,
                          "%s: has %d levels, but %s lists the roughness of "
                          "%d: bake it again, or say what it is with "
                          "--roughness-map",
                          path, levels, who, count);
    return ibl_refuse(r->console, IBL_ERR_FORMAT,
                      "%s: %s lists no roughness that levels have: bake it "
                      "again, or say what it is with --roughness-map",
                      path, who);
}

static ibl_status find_lobe(const reader *r, const ibl_texture *tex,
                            ibl_lobe *lobe)
{
    const char *name = said(r, IBL_OUTPUT_SPECULAR, tex, "lobe");
    const int found = name ? ibl_names_find(ibl_lobe_names, name) : 0;

    *lobe = (ibl_lobe)(r->opts->lobe ? r->opts->lobe - 1 : found);
    if (r->opts->lobe || found >= 0)
        return IBL_OK;
    return ibl_refuse(r->console, IBL_ERR_FORMAT,
                      "%s: of a lobe %s, which is not known: say what it is "
                      "with --lobe",
                      r->files->path[IBL_OUTPUT_SPECULAR], name);
}

/* Sets the lobe and the roughness of the levels. */
static ibl_status describe_specular(const reader *r, const ibl_texture *tex,
                                    ibl_verify_chain *c)
{
    double roughness[IBL_MAX_LEVELS];
    ibl_lobe lobe;
    ibl_status status = find_lobe(r, tex, &lobe);

    if (!status)
        status = find_roughness(r, tex, c->levels, roughness);
    for (int l = 0; l < c->levels && !status; l++) {
        c->level[l].lobe = lobe;
        c->level[l].roughness = roughness[l];
    }
    return status;
}

static ibl_status note_yaw(const reader *r, const ibl_texture *tex,
                           const char *path)
{
    const char *text = ibl_texture_get(tex, "iblbake.yaw_deg"), *end;
    const double asked = r->opts->yaw_deg, before = r->files->yaw_deg;
    double yaw;

    if (!text || !ibl_number_real(text, -DBL_MAX, DBL_MAX, &yaw, &end) || *end)
        return IBL_OK;
    if (!isnan(asked)) {
        if (yaw != asked)
            ibl_console_warn(r->console,
                             "%s: says --rotate %g, but is judged by --rotate "
                             "%g as asked",
                             path, yaw, asked);
        return IBL_OK;
    }
    if (!isnan(before) && yaw != before)
        return ibl_refuse(r->console, IBL_ERR_ARGUMENT,
                          "%s: baked with --rotate %g, another file with %g: "
                          "judge one at a time",
                          path, yaw, before);
    r->files->yaw_deg = yaw;
    return IBL_OK;
}

/* The rotation that neither an option nor a texture has given. */
static void settle_yaw(const reader *r)
{
    double *yaw = &r->files->yaw_deg;

    if (!isnan(r->opts->yaw_deg))
        *yaw = r->opts->yaw_deg;
    else if (isnan(*yaw) && json_unpack(r->sidecar, "{s:{s:F}}", "orientation",
                                        "yaw_deg", yaw))
        *yaw = 0;
}

/* ---- reading --------------------------------------------------------- */

/* Adds a level of `from` to the chain, with our axes. */
static ibl_status take_level(const reader *r, const ibl_cube *from, int level,
                             ibl_output_kind kind)
{
    ibl_verify_chain *c = &r->files->chain[kind];
    const int n = ibl_cube_edge(from->size, level);
    ibl_cube *to = &c->cube[c->levels];
    const ibl_status status = ibl_cube_alloc(r->ctx, n, 1, to);

    if (status)
        return status;
    for (int face = 0; face < IBL_FACES; face++)
        for (int y = 0; y < n; y++)
            for (int x = 0; x < n; x++) {
                double theirs[3], ours[3];
                ibl_cube_direction(n, face, x, y, theirs);
                for (int k = 0; k < 3; k++) {
                    const int axis = r->opts->axes[k];
                    ours[abs(axis) - 1] = axis < 0 ? -theirs[k] : theirs[k];
                }
                const ibl_texel t = ibl_face_texel(n, ours);
                const size_t size = (size_t)n;
                memcpy(ibl_cube_face(to, 0, t.face) +
                           3 * ((size_t)t.y * size + (size_t)t.x),
                       ibl_cube_face(from, level, face) +
                           3 * ((size_t)y * size + (size_t)x),
                       3 * sizeof(float));
            }
    const int first = c->cube[0].size;
    c->level[c->levels++] = (ibl_judge_level){
        .role = (ibl_role)kind,
        .scale = kind == IBL_OUTPUT_IRRADIANCE && r->opts->scale ? M_PI : 1,
        .size = n,
        .base = first > n ? first : n,
        .texels = to->data,
        .pixel = IBL_PIXEL_COUNT};
    return IBL_OK;
}

static ibl_status check_single(const reader *r, const ibl_texture *tex,
                               const char *path, const char *content)
{
    if (tex->layers == 1)
        return IBL_OK;
    return ibl_refuse(r->console, IBL_ERR_FORMAT,
                      "%s: an array of %d layers: %s is a single one", path,
                      tex->layers, content);
}

static ibl_status read_container(const reader *r, ibl_output_kind kind,
                                 ibl_texture *tex)
{
    const char *path = r->files->path[kind];
    ibl_verify_chain *c = &r->files->chain[kind];
    ibl_cube cube = {0};

    if (strstr(path, "%l") && access(path, F_OK))
        return ibl_refuse(
            r->console, IBL_ERR_ARGUMENT,
            "%s: has %%l but no %%f: put %%f where the names of the "
            "faces are",
            path);
    ibl_status status = ibl_texture_read(r->ctx, path, tex, NULL);
    if (status)
        return status;
    if (tex->faces != IBL_FACES)
        return ibl_refuse(r->console, IBL_ERR_FORMAT,
                          "%s: a flat texture: %s is a cube", path,
                          ibl_output_content(kind));
    status = check_single(r, tex, path, ibl_output_content(kind));
    if (!status)
        status = ibl_texture_to_cube(r->ctx, tex, &cube);
    /* Mips of an irradiance map are for minification, nothing to judge. */
    const int levels = kind == IBL_OUTPUT_IRRADIANCE ? 1 : cube.levels;
    for (int l = 0; l < levels && !status; l++) {
        status = take_level(r, &cube, l, kind);
        c->level[l].pixel = tex->pixel;
    }
    ibl_cube_free(&cube);
    return status ? status : note_yaw(r, tex, path);
}

/* The pattern with %l as the level, %f as the face's name and %% as itself;
 * the caller's to free. */
static char *expand(const char *pattern, int level, const char *face)
{
    ibl_memory_file file;
    FILE *to = ibl_memory_open(&file);

    if (!to)
        return NULL;
    for (; *pattern; pattern++) {
        const char next = *pattern == '%' ? pattern[1] : '\0';
        if (next == 'l')
            fprintf(to, "%d", level);
        else if (next == 'f')
            fputs(face, to);
        else
            fputc(*pattern, to);
        pattern += next == 'l' || next == 'f' || next == '%';
    }
    return ibl_memory_close(to, &file);
}

static ibl_status copy_face(const reader *r, const char *path,
                            const ibl_image *image, int face, ibl_cube *cube)
{
    if (image->width != image->height || image->width > IBL_MAX_CUBE_SIZE)
        return ibl_refuse(r->console, IBL_ERR_FORMAT,
                          "%s: %dx%d pixels: a face is square, %d at most",
                          path, image->width, image->height, IBL_MAX_CUBE_SIZE);
    if (!cube->data) {
        const ibl_status status = ibl_cube_alloc(r->ctx, image->width, 1, cube);
        if (status)
            return status;
    }
    if (image->width != cube->size)
        return ibl_refuse(r->console, IBL_ERR_FORMAT,
                          "%s: %d pixels wide, but the faces before it %d",
                          path, image->width, cube->size);
    memcpy(ibl_cube_face(cube, 0, face), image->data,
           3 * (size_t)cube->size * (size_t)cube->size * sizeof(float));
    return IBL_OK;
}

static ibl_status read_faces(const reader *r, ibl_output_kind kind, int level)
{
    const ibl_read_options read = {.part = -1, .any_aspect = 1};
    ibl_cube cube = {0};
    ibl_status status = IBL_OK;
    size_t mended = 0;

    for (int face = 0; face < IBL_FACES && !status; face++) {
        ibl_image image = {0};
        ibl_read_report report = {0};
        char *path =
            expand(r->files->path[kind], level, r->opts->face_names[face]);
        if (!path) {
            status = IBL_ERR_MEMORY;
        } else {
            status = ibl_image_read(r->ctx, path, &read, &image, &report);
            if (!status)
                status = copy_face(r, path, &image, face, &cube);
            mended += report.nonfinite;
        }
        ibl_image_free(&image);
        free(path);
    }
    if (!status)
        status = take_level(r, &cube, 0, kind);
    if (!status)
        r->files->chain[kind].level[level].mended = mended;
    ibl_cube_free(&cube);
    return status;
}

static bool is_there(const reader *r, const char *pattern, int level)
{
    char *path = expand(pattern, level, r->opts->face_names[0]);
    const bool there = path && !access(path, F_OK);

    free(path);
    return there;
}

static ibl_status read_pattern(const reader *r, ibl_output_kind kind)
{
    const char *pattern = r->files->path[kind];
    const bool levels =
        kind != IBL_OUTPUT_IRRADIANCE && strstr(pattern, "%l") != NULL;
    ibl_status status = read_faces(r, kind, 0);

    for (int l = 1; levels && l < IBL_MAX_LEVELS && !status; l++) {
        if (!is_there(r, pattern, l))
            break;
        status = read_faces(r, kind, l);
    }
    return status;
}

static ibl_status read_cube(const reader *r, ibl_output_kind kind)
{
    ibl_texture tex = {0}; /* empty for a pattern */
    ibl_status status = strstr(r->files->path[kind], "%f")
                            ? read_pattern(r, kind)
                            : read_container(r, kind, &tex);

    if (!status && kind == IBL_OUTPUT_SPECULAR)
        status = describe_specular(r, &tex, &r->files->chain[kind]);
    ibl_texture_free(&tex);
    return status;
}

static ibl_status read_lut(const reader *r)
{
    ibl_verify_files *f = r->files;
    const char *path = f->path[IBL_OUTPUT_LUT];
    ibl_texture tex = {0};
    ibl_status status = ibl_texture_read(r->ctx, path, &tex, NULL);

    if (status)
        return status;
    const char *name = said(r, IBL_OUTPUT_LUT, &tex, "geometry");
    const int found = name ? ibl_names_find(ibl_geometry_names, name) : 0;
    f->geometry = (ibl_geometry)(r->opts->geometry ? r->opts->geometry - 1
                                 : found > 0       ? found
                                                   : 0);
    f->lut_pixel = tex.pixel;
    if (tex.faces != 1 || tex.width != tex.height ||
        ibl_pixel_channels(tex.pixel) != 2) {
        ibl_console_fail(r->console,
                         "%s: no BRDF table: it must be flat, square and of "
                         "two channels",
                         path);
        status = IBL_ERR_FORMAT;
    }
    if (!status)
        status =
            check_single(r, &tex, path, ibl_output_content(IBL_OUTPUT_LUT));
    if (!status)
        status = ibl_texture_to_lut(r->ctx, &tex, &f->lut);
    ibl_texture_free(&tex);
    return status;
}

ibl_status ibl_verify_files_read(const ibl_verify_opts *opts, ibl_ctx *ctx,
                                 ibl_console *console, ibl_verify_files *files)
{
    reader r = {.opts = opts, .ctx = ctx, .console = console, .files = files};
    ibl_status status = IBL_OK;

    *files = (ibl_verify_files){.yaw_deg = NAN};
    if (opts->directory)
        status = open_sidecar(&r);
    if (!status)
        status = find_files(&r);
    for (int kind = 0; kind < IBL_OUTPUT_LUT && !status; kind++)
        if (files->path[kind])
            status = read_cube(&r, (ibl_output_kind)kind);
    if (!status && files->path[IBL_OUTPUT_LUT])
        status = read_lut(&r);
    settle_yaw(&r);
    json_decref(r.sidecar);
    free(r.sidecar_path);
    return status;
}

void ibl_verify_files_free(ibl_verify_files *files)
{
    for (int kind = 0; kind < IBL_OUTPUT_LUT; kind++)
        for (int l = 0; l < files->chain[kind].levels; l++)
            ibl_cube_free(&files->chain[kind].cube[l]);
    for (int kind = 0; kind < IBL_VERIFY_KINDS; kind++)
        free(files->path[kind]);
    ibl_lut_free(&files->lut);
}

ibl_status ibl_verify_judge(const ibl_verify_files *files, ibl_judge *judge,
                            ibl_console *console, ibl_report *report)
{
    ibl_status status = IBL_OK;

    for (int kind = 0; kind < IBL_OUTPUT_LUT; kind++) {
        const ibl_verify_chain *c = &files->chain[kind];
        for (int l = 0; l < c->levels && !status; l++) {
            char stage[32];
            snprintf(stage, sizeof stage, "%s %d",
                     ibl_output_name((ibl_output_kind)kind), l);
            ibl_console_progress(console, stage, 0);
            status = ibl_report_add(report, judge, (ibl_output_kind)kind, l,
                                    &c->level[l]);
        }
    }
    return status;
}
