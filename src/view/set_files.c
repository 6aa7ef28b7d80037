/* SPDX-License-Identifier: MIT */
/* Finds the files of a set by content and by name, and detects changes. */
#include "view/set_parts.h"

#include <dirent.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "common/names.h"
#include "common/path.h"
#include "engine/engine.h"
#include "view/message.h"

enum {
    MAGIC = 12
};

/* The viewer waits this many times longer for a file that is gone: it may
 * reappear. */
static const double GONE = 12;

static const struct {
    const char *begin;
    size_t size;
    const char *words; /* NULL: a texture */
} magics[] = {
    {"\xABKTX 20\xBB\r\n\x1A\n", MAGIC, NULL},
    {"\xABKTX 11\xBB\r\n\x1A\n", MAGIC, NULL},
    {"DDS ", 4, NULL},
    {"\x89PNG", 4, "a PNG picture"},
    {"\xFF\xD8\xFF", 3, "a JPEG picture"},
    {"#?", 2, "a Radiance map"},
    {"\x76\x2F\x31\x01", 4, "an OpenEXR map"},
    {"II*\0", 4, "a TIFF picture"},
    {"MM\0*", 4, "a TIFF picture"},
};

static const char *describe(const char *head)
{
    for (size_t i = 0; i < sizeof magics / sizeof *magics; i++)
        if (!memcmp(head, magics[i].begin, magics[i].size))
            return magics[i].words;
    return "of another kind";
}

view_file_kind view_file_look(const char *path, const char **words)
{
    char head[MAGIC + 1] = "";
    struct stat st;
    FILE *file;

    *words = "a directory";
    if (stat(path, &st))
        return VIEW_FILE_MISSING;
    if (S_ISDIR(st.st_mode))
        return VIEW_FILE_DIRECTORY;
    if (!S_ISREG(st.st_mode))
        return VIEW_FILE_PIPE;
    file = fopen(path, "rb");
    if (!file)
        return VIEW_FILE_MISSING;
    const size_t got = fread(head, 1, MAGIC, file);
    fclose(file);
    if (got && ibl_engine_of_name(path))
        return VIEW_FILE_TEXTURE;
    *words = "JSON";
    if (head[strspn(head, " \t\r\n")] == '{')
        return VIEW_FILE_JSON;
    *words = got ? describe(head) : "empty";
    return *words ? VIEW_FILE_OTHER : VIEW_FILE_TEXTURE;
}

bool view_is_map(const char *path, ibl_input_layout layout)
{
    const char *words;

    if (layout || !strcmp(path, "-"))
        return true;
    const view_file_kind kind = view_file_look(path, &words);
    if (kind == VIEW_FILE_MISSING)
        return strstr(path, "%f") || strchr(path, ',');
    return kind == VIEW_FILE_OTHER || kind == VIEW_FILE_PIPE;
}

static size_t stem_length(const char *name)
{
    const char *dot = strrchr(name, '.');
    return dot && dot > name ? (size_t)(dot - name) : strlen(name);
}

char *view_file_stem(const char *path)
{
    const char *name = ibl_path_name(path);
    return strndup(name, stem_length(name));
}

bool view_file_no_memory(const char *path)
{
    return view_fail("%s: no memory to open it", path);
}

view_content view_file_content(const char *path, size_t *length)
{
    const char *name = ibl_path_name(path);
    const size_t all = stem_length(name);

    *length = all;
    /* charlie_specular before specular */
    for (int i = VIEW_CONTENTS - 1; i >= 0; i--) {
        const char *word = view_content_names[i];
        const size_t size = strlen(word), before = all - size;
        if (all < size || memcmp(name + before, word, size) != 0)
            continue;
        if (before == 0 && i == VIEW_LUT)
            return VIEW_LUT;
        if (before < 2 || name[before - 1] != '_')
            continue;
        *length = before - 1;
        return (view_content)i;
    }
    return VIEW_CONTENTS;
}

static int choose_specular(const struct dirent *entry)
{
    const char *name = entry->d_name, *dot = strrchr(name, '.');
    size_t length;

    if (*name != '.' && ibl_engine_of_name(name))
        return true;
    return *name != '.' && dot &&
           ibl_names_find(ibl_array_container_names, dot + 1) >= 0 &&
           view_file_content(name, &length) == VIEW_SPECULAR;
}

/* "a, b, c and 5 more" */
static void fail_several(const char *path, struct dirent *const *found,
                         int count)
{
    char text[256] = "";
    size_t used = 0;
    int shown = 0;

    for (; shown < count; shown++) {
        const char *before = shown == 0           ? ""
                             : shown + 1 == count ? " and "
                                                  : ", ";
        const char *name = found[shown]->d_name;
        if (used + strlen(name) + 16 > sizeof text)
            break;
        used += (size_t)snprintf(text + used, sizeof text - used, "%s%s",
                                 before, name);
    }
    if (shown < count)
        snprintf(text + used, sizeof text - used, " and %d more",
                 count - shown);
    view_fail("%s: holds %d sets: name one of its files: %s", path, count,
              text);
}

/* The specular file of a directory; the caller must free it. */
static char *find_in_directory(const char *path)
{
    struct dirent **names = NULL;
    char *found = NULL;
    const int count = scandir(path, &names, choose_specular, alphasort);

    if (count < 0)
        view_fail("%s: cannot be read: %s", path, strerror(errno));
    else if (count == 0)
        view_fail("%s: has no NAME_specular.ktx2, .ktx or .dds: bake a map "
                  "into it (iblbake MAP -o %s), or name another directory, a "
                  "specular file or a map",
                  path, path);
    else if (count > 1)
        fail_several(path, names, count);
    else if (!(found = ibl_path_join(path, names[0]->d_name)))
        view_file_no_memory(path);
    for (int i = 0; i < count; i++)
        free(names[i]);
    free(names);
    return found;
}

char *view_file_specular(const char *path)
{
    const char *words;
    const view_file_kind kind = view_file_look(path, &words);
    char *found = NULL;

    if (kind == VIEW_FILE_DIRECTORY)
        return find_in_directory(path);
    if (kind == VIEW_FILE_JSON)
        view_fail("%s: is JSON, no texture: name the NAME_specular file beside "
                  "it, or the directory",
                  path);
    else if (!(found = strdup(path)))
        view_file_no_memory(path);
    return found;
}

void view_set_see(baked_set *set, int i)
{
    view_files_see(&set->path[i], 1, &set->seen[i]);
}

void view_set_seen(baked_set *set)
{
    view_files_see(set->path, VIEW_FILES, set->seen);
}

bool view_set_changed(const baked_set *set, double settle)
{
    return view_files_changed(set->path, VIEW_FILES, set->seen, settle,
                              GONE * settle);
}
