/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE /* versionsort */
#include "view/folder.h"

#include <dirent.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>

#include "common/names.h"
#include "common/path.h"
#include "common/signals.h"
#include "engine/engine.h"
#include "view/message.h"

bool view_is_model(const char *path)
{
    const char *dot = strrchr(path, '.');

    return dot && (!strcasecmp(dot, ".glb") ||
                   (!strcasecmp(dot, ".gltf") && !ibl_gltf_is_light(path)));
}

/* Whether a file is a texture or JSON. */
static bool is_of_set(const char *path)
{
    char head[12 + 1] = "";
    FILE *file = fopen(path, "rb");
    const size_t got = file ? fread(head, 1, 12, file) : 0;

    if (file)
        fclose(file);
    return (got && ibl_engine_of_name(path)) ||
           head[strspn(head, " \t\r\n")] == '{' ||
           !memcmp(head, "\xABKTX 20\xBB\r\n\x1A\n", 12) ||
           !memcmp(head, "\xABKTX 11\xBB\r\n\x1A\n", 12) ||
           !memcmp(head, "DDS ", 4);
}

/* What a file of a folder is, by its name. */
static view_kind kind_by_name(const char *path)
{
    static const char *const maps[] = {"exr", "hdr",  "pic",
                                       "tif", "tiff", NULL};
    static const char chain[] = "_specular.";
    const char *name = ibl_path_name(path), *dot = strrchr(name, '.');
    const char *end = strstr(name, chain);

    if (!strcmp(name, "index.json"))
        return VIEW_KIND_PROBES;
    if (view_is_model(path))
        return VIEW_KIND_MODEL;
    if (ibl_engine_of_name(name) ||
        (end &&
         ibl_names_find(ibl_array_container_names, end + sizeof chain - 1) >=
             0 &&
         !strstr(name, "_charlie_specular")))
        return VIEW_KIND_SET;
    for (int i = 0; dot && maps[i]; i++)
        if (!strcasecmp(dot + 1, maps[i]))
            return VIEW_KIND_MAP;
    return VIEW_KIND_NONE;
}

static view_kind kind_of_directory(const char *path, const char **why);

static int is_visible(const struct dirent *e)
{
    return *e->d_name != '.';
}

/* Lists a directory; deep: looks into those in it. */
static bool list(const char *path, bool deep, view_folder *f)
{
    struct dirent **names;
    const int all = scandir(path, &names, is_visible, versionsort);
    int folders = 0;

    *f = (view_folder){0};
    if (all < 0)
        return false;
    f->path = ibl_need(strdup(path));
    f->entry = ibl_need(calloc((size_t)all + 1, sizeof *f->entry));
    for (int i = 0; i < all; i++) {
        char *at = ibl_need(ibl_path_join(path, names[i]->d_name));
        struct stat st;
        const char *why;
        const view_kind kind = stat(at, &st) || !S_ISDIR(st.st_mode)
                                   ? kind_by_name(at)
                               : deep ? kind_of_directory(at, &why)
                                      : VIEW_KIND_FOLDER;
        if (kind) {
            view_entry *to =
                f->entry + (kind == VIEW_KIND_FOLDER ? folders++ : f->count);
            memmove(to + 1, to,
                    (size_t)(f->entry + f->count++ - to) * sizeof *to);
            *to = (view_entry){ibl_need(strdup(names[i]->d_name)), kind};
        }
        free(at);
        free(names[i]);
    }
    free(names);
    return true;
}

/* A directory of probes, of a set, or with something to choose from. */
static view_kind kind_of_directory(const char *path, const char **why)
{
    view_kind kind = VIEW_KIND_NONE;
    const char *first = NULL; /* name of a set */
    bool several = false;
    view_folder f;

    *why = list(path, false, &f) ? NULL : strerror(errno);
    for (const view_entry *e = f.entry; e < f.entry + f.count; e++) {
        if (e->kind == VIEW_KIND_SET) {
            char *end = strstr(e->name, "_specular.");
            *(end ? end : strrchr(e->name, '.')) = '\0';
            several |= first && strcmp(first, e->name) != 0;
            first = e->name;
        }
        if (e->kind == VIEW_KIND_PROBES ||
            (e->kind == VIEW_KIND_SET && kind != VIEW_KIND_PROBES))
            kind = e->kind;
        else if (!kind)
            kind = VIEW_KIND_FOLDER;
    }
    if (!kind && !*why)
        *why = "there is no map, set or model in it";
    view_folder_free(&f);
    return several && kind == VIEW_KIND_SET ? VIEW_KIND_FOLDER : kind;
}

view_kind view_kind_of(const char *path, const char **why)
{
    struct stat st;

    *why = NULL;
    if (view_is_model(path))
        return VIEW_KIND_MODEL;
    if (!strcmp(path, "-"))
        return VIEW_KIND_MAP;
    if (stat(path, &st)) {
        if (errno == ENOENT && (strstr(path, "%f") || strchr(path, ',')))
            return VIEW_KIND_MAP;
        *why = strerror(errno);
        return VIEW_KIND_NONE;
    }
    if (S_ISDIR(st.st_mode))
        return kind_of_directory(path, why);
    if (!S_ISREG(st.st_mode) || !is_of_set(path))
        return VIEW_KIND_MAP;
    return strcmp(ibl_path_name(path), "index.json") ? VIEW_KIND_SET
                                                     : VIEW_KIND_PROBES;
}

bool view_folder_read(const char *path, view_folder *f)
{
    return list(path, true, f) ||
           view_fail("%s: cannot be listed: %s", path, strerror(errno));
}

void view_folder_free(view_folder *f)
{
    for (int i = 0; i < f->count; i++)
        free(f->entry[i].name);
    free(f->entry);
    free(f->path);
    *f = (view_folder){0};
}

int view_folder_step(const view_folder *f, view_kind kind, const char *name,
                     int step)
{
    int first = 0;

    for (int i = 0; i < f->count; i++)
        first = strcmp(f->entry[i].name, name) ? first : i;
    for (int k = 1; k <= f->count; k++) {
        const int at = (first + (step < 0 ? f->count - k : k)) % f->count;
        if (f->entry[at].kind == kind)
            return at;
    }
    return -1;
}

const char *view_shipped_map(void)
{
    /* Installed; in a build, and of its tests. */
    static const char *const places[] = {"../share/iblbake/forest.exr",
                                         "../data/forest.exr",
                                         "../../data/forest.exr"};
    static char path[IBL_PART_BYTES];

    for (size_t i = 0; i < sizeof places / sizeof *places; i++)
        if (ibl_path_of_part(places[i], path))
            return path;
    view_fail("a model alone is lit by forest.exr of this program, which is "
              "not beside it: name a map or a set, too");
    return NULL;
}
