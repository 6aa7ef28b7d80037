/* SPDX-License-Identifier: MIT */
#include "cli/verify_files.h"

#include <errno.h>
#include <jansson.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "cli/faces.h"
#include "common/memory_file.h"
#include "common/names.h"
#include "common/sidecar_load.h"

typedef struct reader {
    const ibl_verify_opts *opts;
    ibl_ctx *ctx;
    ibl_console *console;
    char *sidecar_path;
    json_t *sidecar; /* NULL: there is none */
    ibl_verify_files *files;
} reader;

const char *ibl_verify_content(ibl_verify_kind kind)
{
    static const char *const names[] = {"skybox", "specular", "irradiance",
                                        "brdf_lut"};
    return names[kind];
}

/* ---- finding --------------------------------------------------------- */

static char *join(const char *directory, const char *fmt, const char *name,
                  const char *content, const char *ext)
{
    const size_t size = strlen(directory) + strlen(fmt) + strlen(name) +
                        strlen(content) + strlen(ext) + 2;
    char *path = malloc(size);

    if (path) {
        const size_t used = (size_t)snprintf(path, size, "%s/", directory);
        snprintf(path + used, size - used, fmt, name, content, ext);
    }
    return path;
}

/* The sidecar's account of a file, or NULL. */
static json_t *find_output(const reader *r, ibl_verify_kind kind)
{
    json_t *outputs = json_object_get(r->sidecar, "outputs"), *output;
    size_t i;

    json_array_foreach(outputs, i, output)
    {
        const char *content =
            json_string_value(json_object_get(output, "content"));
        if (content && !strcmp(content, ibl_verify_content(kind)))
            return output;
    }
    return NULL;
}

static ibl_status open_sidecar(reader *r)
{
    const ibl_verify_opts *o = r->opts;
    ibl_json_why why;
    struct stat st;

    if (stat(o->directory, &st)) {
        ibl_console_fail(r->console, "%s: %s: give the directory of a bake",
                         o->directory, strerror(errno));
        return IBL_ERR_IO;
    }
    if (!S_ISDIR(st.st_mode)) {
        ibl_console_fail(r->console,
                         "%s: not a directory: give the environment first, "
                         "then the directory of its bake",
                         o->directory);
        return IBL_ERR_IO;
    }
    r->sidecar_path = join(o->directory, "%s%s.%s", o->name, "", "json");
    if (!r->sidecar_path)
        return IBL_ERR_MEMORY;
    if (access(r->sidecar_path, F_OK))
        return IBL_OK;
    r->sidecar = ibl_sidecar_load(r->sidecar_path, &why);
    if (r->sidecar)
        return IBL_OK;
    ibl_console_fail(r->console, "%s%s", why.line,
                     why.damaged ? ": bake again, or remove it and say what "
                                   "the files mean"
                                 : "");
    return why.damaged ? IBL_ERR_FORMAT : IBL_ERR_IO;
}

/* What the sidecar names; *path stays NULL if it names nothing. */
static ibl_status find_named(const reader *r, ibl_verify_kind kind, char **path)
{
    const char *file =
        json_string_value(json_object_get(find_output(r, kind), "file"));

    if (!file || strchr(file, '/'))
        return IBL_OK;
    *path = join(r->opts->directory, "%s%s%s", file, "", "");
    if (!*path)
        return IBL_ERR_MEMORY;
    if (access(*path, F_OK)) {
        ibl_console_fail(r->console,
                         "%s: %s names it, but it is not there: bake again",
                         *path, r->sidecar_path);
        return IBL_ERR_IO;
    }
    return IBL_OK;
}

/* What has the name in the directory; stem is the table's, or NULL. */
static ibl_status find_there(const reader *r, ibl_verify_kind kind,
                             const char *stem, char **path)
{
    for (int c = 0; c < IBL_CONTAINER_COUNT; c++) {
        const char *ext = ibl_container_name((ibl_container)c);
        char *candidate =
            stem ? join(r->opts->directory, "%s%s.%s", stem, "", ext)
                 : join(r->opts->directory, "%s_%s.%s", r->opts->name,
                        ibl_verify_content(kind), ext);
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
                             candidate, *path,
                             kind == IBL_VERIFY_LUT ? "lut"
                                                    : ibl_verify_content(kind));
            free(candidate);
            return IBL_ERR_ARGUMENT;
        }
    }
    return IBL_OK;
}

static ibl_status find_file(const reader *r, ibl_verify_kind kind, char **path)
{
    const char *given = r->opts->files[kind];
    ibl_status status = IBL_OK;

    if (given) {
        *path = strdup(given);
        return *path ? IBL_OK : IBL_ERR_MEMORY;
    }
    if (!r->opts->directory)
        return IBL_OK;
    status = find_named(r, kind, path);
    if (kind != IBL_VERIFY_LUT)
        return status || *path ? status : find_there(r, kind, NULL, path);
    for (int i = 0; ibl_lut_stems[i] && !status && !*path; i++)
        status = find_there(r, kind, ibl_lut_stems[i], path);
    return status;
}

static ibl_status find_files(const reader *r)
{
    ibl_verify_files *f = r->files;
    bool cubes = false;

    for (int kind = 0; kind < IBL_VERIFY_COUNT; kind++) {
        char **path =
            kind == IBL_VERIFY_LUT ? &f->lut_path : &f->cubes[kind].path;
        const ibl_status status = find_file(r, (ibl_verify_kind)kind, path);
        if (status)
            return status;
        cubes |= kind != IBL_VERIFY_LUT && *path;
    }
    if (!cubes && r->opts->directory) {
        ibl_console_fail(r->console,
                         "%s: has no %s_specular, _irradiance or _skybox "
                         "(.ktx2, .ktx, .dds): give the --name of the bake",
                         r->opts->directory, r->opts->name);
        return IBL_ERR_IO;
    }
    return IBL_OK;
}

/* ---- what files say -------------------------------------------------- */

/* Reads "0,0.25,..."; how many there are, 0: it is no list of roughnesses. */
static int read_list(const char *text, double list[IBL_MAX_LEVELS])
{
    for (int i = 0; i < IBL_MAX_LEVELS; i++) {
        char *end;
        list[i] = strtod(text, &end);
        if (end == text || !(list[i] >= 0 && list[i] <= 1) ||
            (*end && *end != ','))
            return 0;
        if (!*end)
            return i + 1;
        text = end + 1;
    }
    return 0;
}

/* The same of an array of levels. */
static int read_levels(json_t *levels, double list[IBL_MAX_LEVELS])
{
    const size_t count = json_array_size(levels);

    for (size_t l = 0; l < count && count <= IBL_MAX_LEVELS; l++) {
        json_t *value = json_object_get(json_array_get(levels, l), "roughness");
        list[l] = json_number_value(value);
        if (!json_is_number(value) || !(list[l] >= 0 && list[l] <= 1))
            return 0;
    }
    return count <= IBL_MAX_LEVELS ? (int)count : 0;
}

/* Whether a list is that of the file's levels; else a line about it. */
static ibl_status check_count(const reader *r, const ibl_verify_file *f,
                              int count, const char *who)
{
    if (count == f->levels)
        return IBL_OK;
    if (count)
        ibl_console_fail(r->console,
                         "%s: has %d levels, but %s lists the roughness of "
                         "%d: bake it again, or say what it is with "
                         "--roughness-map",
                         f->path, f->levels, who, count);
    else
        ibl_console_fail(r->console,
                         "%s: %s lists no roughness that levels have: bake it "
                         "again, or say what it is with --roughness-map",
                         f->path, who);
    return IBL_ERR_FORMAT;
}

/* tex may be NULL. */
static ibl_status set_roughness(const reader *r, const ibl_texture *tex,
                                ibl_verify_file *f)
{
    const ibl_verify_map *m = &r->opts->roughness;
    const char *key = tex ? ibl_texture_get(tex, "iblbake.roughness") : NULL;
    json_t *levels =
        r->opts->files[IBL_VERIFY_SPECULAR]
            ? NULL
            : json_object_get(find_output(r, IBL_VERIFY_SPECULAR), "levels");

    if (m->count && m->count != f->levels) {
        ibl_console_fail(r->console,
                         "%s: has %d levels, but --roughness-map lists %d",
                         f->path, f->levels, m->count);
        return IBL_ERR_ARGUMENT;
    }
    if (!m->given && key)
        return check_count(r, f, read_list(key, f->roughness),
                           "its key iblbake.roughness");
    if (!m->given && levels)
        return check_count(r, f, read_levels(levels, f->roughness),
                           r->sidecar_path);
    for (int l = 0; l < f->levels; l++)
        f->roughness[l] =
            m->count ? m->list[l] : ibl_level_roughness(m->map, l, f->levels);
    return IBL_OK;
}

/* tex may be NULL. */
static ibl_status set_lobe(const reader *r, const ibl_texture *tex,
                           ibl_verify_file *f)
{
    const bool own = !r->opts->files[IBL_VERIFY_SPECULAR];
    const char *name = tex ? ibl_texture_get(tex, "iblbake.lobe") : NULL;

    if (!name && own)
        name = json_string_value(
            json_object_get(find_output(r, IBL_VERIFY_SPECULAR), "lobe"));
    f->lobe = IBL_LOBE_GGX;
    if (r->opts->lobe) {
        f->lobe = (ibl_lobe)(r->opts->lobe - 1);
    } else if (name) {
        while (f->lobe <= IBL_LOBE_PHONG &&
               strcmp(name, ibl_lobe_name(f->lobe)) != 0)
            f->lobe++;
        if (f->lobe > IBL_LOBE_PHONG) {
            ibl_console_fail(r->console,
                             "%s: of a lobe %s, which is not known: say what "
                             "it is with --lobe",
                             f->path, name);
            return IBL_ERR_FORMAT;
        }
    }
    return IBL_OK;
}

static ibl_status note_yaw(const reader *r, const ibl_texture *tex,
                           const char *path)
{
    const char *text = ibl_texture_get(tex, "iblbake.yaw_deg");
    const double asked = r->opts->yaw_deg;
    char *end;

    if (!text)
        return IBL_OK;
    const double yaw = strtod(text, &end);
    if (end == text || *end || !isfinite(yaw))
        return IBL_OK;
    if (!isnan(asked)) {
        if (yaw != asked)
            ibl_console_warn(r->console,
                             "%s: says --rotate %g, but is judged by --rotate "
                             "%g as asked",
                             path, yaw, asked);
        return IBL_OK;
    }
    if (!isnan(r->files->yaw_deg) && yaw != r->files->yaw_deg) {
        ibl_console_fail(r->console,
                         "%s: baked with --rotate %g, another file with %g: "
                         "judge one at a time",
                         path, yaw, r->files->yaw_deg);
        return IBL_ERR_ARGUMENT;
    }
    r->files->yaw_deg = yaw;
    return IBL_OK;
}

/* What neither an option nor a file has said. */
static void settle_yaw(const reader *r)
{
    json_t *yaw =
        json_object_get(json_object_get(r->sidecar, "orientation"), "yaw_deg");

    if (!isnan(r->opts->yaw_deg))
        r->files->yaw_deg = r->opts->yaw_deg;
    else if (isnan(r->files->yaw_deg))
        r->files->yaw_deg =
            json_is_number(yaw) && isfinite(json_number_value(yaw))
                ? json_number_value(yaw)
                : 0;
}

/* ---- reading --------------------------------------------------------- */

/* Copies a level of `from` to a cube of one level whose axes are ours. */
static ibl_status take_level(const reader *r, const ibl_cube *from, int level,
                             ibl_verify_file *f)
{
    const int n = ibl_cube_edge(from->size, level);
    ibl_cube *to = &f->level[f->levels];
    const ibl_status status = ibl_cube_alloc(r->ctx, n, 1, to);

    if (status)
        return status;
    f->levels++;
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
    return IBL_OK;
}

static ibl_status check_single(const reader *r, const ibl_texture *tex,
                               const char *path, const char *content)
{
    if (tex->layers == 1)
        return IBL_OK;
    ibl_console_fail(r->console,
                     "%s: an array of %d layers: %s is a single one", path,
                     tex->layers, content);
    return IBL_ERR_FORMAT;
}

static ibl_status read_container(const reader *r, ibl_verify_kind kind,
                                 ibl_verify_file *f)
{
    ibl_texture tex = {0};
    ibl_cube cube = {0};
    ibl_status status;

    if (strstr(f->path, "%l") && access(f->path, F_OK)) {
        ibl_console_fail(r->console,
                         "%s: has %%l but no %%f: put %%f where the names of "
                         "the faces are",
                         f->path);
        return IBL_ERR_ARGUMENT;
    }
    status = ibl_texture_read(r->ctx, f->path, &tex, NULL);
    if (status)
        return status;
    if (tex.faces != IBL_FACES) {
        ibl_console_fail(r->console, "%s: a flat texture: %s is a cube",
                         f->path, ibl_verify_content(kind));
        status = IBL_ERR_FORMAT;
    }
    if (!status)
        status = check_single(r, &tex, f->path, ibl_verify_content(kind));
    if (!status)
        status = ibl_texture_to_cube(r->ctx, &tex, &cube);
    /* Mips of an irradiance map are for minification, nothing to judge. */
    const int levels = kind == IBL_VERIFY_IRRADIANCE ? 1 : cube.levels;
    for (int l = 0; l < levels && !status; l++)
        status = take_level(r, &cube, l, f);
    f->pixel = tex.pixel;
    if (!status)
        status = note_yaw(r, &tex, f->path);
    if (!status && kind == IBL_VERIFY_SPECULAR)
        status = set_lobe(r, &tex, f);
    if (!status && kind == IBL_VERIFY_SPECULAR)
        status = set_roughness(r, &tex, f);
    ibl_cube_free(&cube);
    ibl_texture_free(&tex);
    return status;
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
    if (image->width != image->height || image->width > IBL_MAX_CUBE_SIZE) {
        ibl_console_fail(r->console,
                         "%s: %dx%d pixels: a face is square, %d at most", path,
                         image->width, image->height, IBL_MAX_CUBE_SIZE);
        return IBL_ERR_FORMAT;
    }
    if (!cube->data) {
        const ibl_status status = ibl_cube_alloc(r->ctx, image->width, 1, cube);
        if (status)
            return status;
    }
    if (image->width != cube->size) {
        ibl_console_fail(r->console,
                         "%s: %d pixels wide, but the faces before it %d", path,
                         image->width, cube->size);
        return IBL_ERR_FORMAT;
    }
    memcpy(ibl_cube_face(cube, 0, face), image->data,
           3 * (size_t)cube->size * (size_t)cube->size * sizeof(float));
    return IBL_OK;
}

static ibl_status read_faces(const reader *r, ibl_verify_file *f, int level)
{
    ibl_read_options read = {.part = -1, .any_aspect = 1};
    ibl_cube cube = {0};
    ibl_status status = IBL_OK;

    for (int face = 0; face < IBL_FACES && !status; face++) {
        ibl_image image = {0};
        ibl_read_report report = {0};
        char *path = expand(f->path, level, r->opts->face_names[face]);
        if (!path) {
            status = IBL_ERR_MEMORY;
        } else {
            status = ibl_image_read(r->ctx, path, &read, &image, &report);
            if (!status)
                status = copy_face(r, path, &image, face, &cube);
            f->mended[level] += report.nonfinite;
        }
        ibl_image_free(&image);
        free(path);
    }
    if (!status)
        status = take_level(r, &cube, 0, f);
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

static ibl_status read_pattern(const reader *r, ibl_verify_kind kind,
                               ibl_verify_file *f)
{
    const bool levels =
        kind != IBL_VERIFY_IRRADIANCE && strstr(f->path, "%l") != NULL;
    ibl_status status = read_faces(r, f, 0);

    f->pixel = IBL_PIXEL_COUNT;
    for (int l = 1; levels && l < IBL_MAX_LEVELS && !status; l++) {
        if (!is_there(r, f->path, l))
            break;
        status = read_faces(r, f, l);
    }
    if (!status && kind == IBL_VERIFY_SPECULAR)
        status = set_lobe(r, NULL, f);
    if (!status && kind == IBL_VERIFY_SPECULAR)
        status = set_roughness(r, NULL, f);
    return status;
}

static ibl_status read_lut(const reader *r)
{
    ibl_verify_files *f = r->files;
    ibl_texture tex = {0};
    ibl_status status = ibl_texture_read(r->ctx, f->lut_path, &tex, NULL);

    if (status)
        return status;
    const char *name = ibl_texture_get(&tex, "iblbake.geometry");
    if (!name && !r->opts->files[IBL_VERIFY_LUT])
        name = json_string_value(
            json_object_get(find_output(r, IBL_VERIFY_LUT), "geometry"));
    f->geometry = IBL_GEOMETRY_SMITH;
    if (r->opts->geometry)
        f->geometry = (ibl_geometry)(r->opts->geometry - 1);
    else if (name && !strcmp(name, ibl_geometry_name(IBL_GEOMETRY_SCHLICK_IBL)))
        f->geometry = IBL_GEOMETRY_SCHLICK_IBL;
    f->lut_pixel = tex.pixel;
    if (tex.faces != 1 || tex.width != tex.height ||
        ibl_pixel_channels(tex.pixel) != 2) {
        ibl_console_fail(r->console,
                         "%s: no BRDF table: it must be flat, square and of "
                         "two channels",
                         f->lut_path);
        status = IBL_ERR_FORMAT;
    }
    if (!status)
        status = check_single(r, &tex, f->lut_path,
                              ibl_verify_content(IBL_VERIFY_LUT));
    if (!status)
        status = ibl_texture_to_lut(r->ctx, &tex, &f->lut);
    ibl_texture_free(&tex);
    return status;
}

static ibl_status read_files(const reader *r)
{
    ibl_status status = IBL_OK;

    for (int kind = 0; kind < IBL_VERIFY_LUT && !status; kind++) {
        ibl_verify_file *f = &r->files->cubes[kind];
        if (!f->path)
            continue;
        f->scale = kind == IBL_VERIFY_IRRADIANCE && r->opts->scale ? M_PI : 1;
        status = strstr(f->path, "%f")
                     ? read_pattern(r, (ibl_verify_kind)kind, f)
                     : read_container(r, (ibl_verify_kind)kind, f);
    }
    if (!status && r->files->lut_path)
        status = read_lut(r);
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
    if (!status)
        status = read_files(&r);
    settle_yaw(&r);
    json_decref(r.sidecar);
    free(r.sidecar_path);
    return status;
}

void ibl_verify_files_free(ibl_verify_files *files)
{
    for (int kind = 0; kind < IBL_VERIFY_LUT; kind++) {
        ibl_verify_file *f = &files->cubes[kind];
        for (int l = 0; l < f->levels; l++)
            ibl_cube_free(&f->level[l]);
        free(f->path);
    }
    ibl_lut_free(&files->lut);
    free(files->lut_path);
}
