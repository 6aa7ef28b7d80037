/* SPDX-License-Identifier: MIT */
/* Files by content and by name. */
#include "view/set_find.h"

#include <dirent.h>
#include <errno.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "common/path.h"
#include "view/message.h"

enum {
    MAGIC = 12
};

/* ---- what a file is -------------------------------------------------- */

static bool is_texture(const char *head)
{
    return !memcmp(head, "\xABKTX 20\xBB\r\n\x1A\n", MAGIC) ||
           !memcmp(head, "\xABKTX 11\xBB\r\n\x1A\n", MAGIC) ||
           !memcmp(head, "DDS ", 4);
}

/* What a file is that is no texture. */
static const char *describe(const char *head)
{
    if (!memcmp(head, "\x89PNG", 4))
        return "a PNG picture";
    if (!memcmp(head, "\xFF\xD8\xFF", 3))
        return "a JPEG picture";
    if (!memcmp(head, "#?", 2))
        return "a Radiance map";
    if (!memcmp(head, "\x76\x2F\x31\x01", 4))
        return "an OpenEXR map";
    if (!memcmp(head, "II*\0", 4) || !memcmp(head, "MM\0*", 4))
        return "a TIFF picture";
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
    if (is_texture(head))
        return VIEW_FILE_TEXTURE;
    *words = "JSON";
    if (head[strspn(head, " \t\r\n")] == '{')
        return VIEW_FILE_JSON;
    *words = got ? describe(head) : "empty";
    return VIEW_FILE_OTHER;
}

bool view_is_map(const char *path)
{
    const char *words;

    if (!strcmp(path, "-"))
        return true;
    const view_file_kind kind = view_file_look(path, &words);
    return kind == VIEW_FILE_OTHER || kind == VIEW_FILE_PIPE;
}

/* ---- names ----------------------------------------------------------- */

const char *view_file_name(const char *path)
{
    const char *slash = strrchr(path, '/');
    return slash ? slash + 1 : path;
}

char *view_set_stem(const char *path)
{
    const char *name = view_file_name(path);
    const char *dot = strrchr(name, '.');
    return dot && dot > name ? strndup(name, (size_t)(dot - name))
                             : strdup(name);
}

char *view_file_print(const char *fmt, ...)
{
    va_list ap;

    va_start(ap, fmt);
    const int length = vsnprintf(NULL, 0, fmt, ap);
    va_end(ap);
    char *text = length >= 0 ? malloc((size_t)length + 1) : NULL;
    if (text) {
        va_start(ap, fmt);
        vsnprintf(text, (size_t)length + 1, fmt, ap);
        va_end(ap);
    }
    return text;
}

bool view_file_no_memory(const char *path)
{
    return view_fail("%s: no memory to open it", path);
}

view_content view_file_content(const char *stem, size_t *length)
{
    const size_t all = strlen(stem);

    for (int i = 0; i < VIEW_CONTENTS; i++) {
        const char *word = view_content_name((view_content)i);
        const size_t size = strlen(word);
        *length = all - size;
        if (all < size || strcmp(stem + all - size, word) != 0)
            continue;
        if (all == size && i == VIEW_LUT)
            return VIEW_LUT;
        if (all > size + 1 && stem[--*length] == '_')
            return (view_content)i;
    }
    *length = all;
    return VIEW_CONTENTS;
}

/* ---- a directory ------------------------------------------------------ */

static bool is_specular(const char *name)
{
    for (int i = 0; i < IBL_CONTAINER_COUNT; i++) {
        char end[32];
        const int size = snprintf(end, sizeof end, "_specular.%s",
                                  ibl_container_name((ibl_container)i));
        const size_t length = strlen(name);
        if (*name != '.' && length > (size_t)size &&
            !strcmp(name + length - size, end))
            return true;
    }
    return false;
}

static int compare_names(const void *a, const void *b)
{
    return strcmp(*(char *const *)a, *(char *const *)b);
}

static void free_names(char **names, int count)
{
    for (int i = 0; i < count; i++)
        free(names[i]);
    free(names);
}

/* Names of the specular files in a directory, sorted. */
static bool list(const char *path, char ***out, int *count)
{
    DIR *directory = opendir(path);
    char **names = NULL;
    struct dirent *entry;

    *out = NULL;
    *count = 0;
    if (!directory)
        return view_fail("%s: cannot be read: %s", path, strerror(errno));
    while ((entry = readdir(directory))) {
        if (!is_specular(entry->d_name))
            continue;
        char **more = realloc(names, sizeof *names * (size_t)(*count + 1));
        if (more)
            names = more;
        if (!more || !(names[*count] = strdup(entry->d_name))) {
            free_names(names, *count);
            closedir(directory);
            return view_file_no_memory(path);
        }
        ++*count;
    }
    closedir(directory);
    if (names)
        qsort(names, (size_t)*count, sizeof *names, compare_names);
    *out = names;
    return true;
}

/* "a, b, c and 5 more" */
static bool fail_several(const char *path, char *const *names, int count)
{
    char text[256] = "";
    int shown = 0;

    for (; shown < count; shown++) {
        const size_t used = strlen(text);
        if (used + strlen(names[shown]) + 16 > sizeof text)
            break;
        snprintf(text + used, sizeof text - used, "%s%s",
                 shown == 0           ? ""
                 : shown + 1 == count ? " and "
                                      : ", ",
                 names[shown]);
    }
    if (shown < count)
        snprintf(text + strlen(text), sizeof text - strlen(text),
                 " and %d more", count - shown);
    return view_fail("%s: holds %d sets: name one of its files: %s", path,
                     count, text);
}

/* The specular file of a directory, for free(). */
static char *find_in_directory(const char *path)
{
    char **names, *found = NULL;
    int count;

    if (!list(path, &names, &count))
        return NULL;
    if (count == 0)
        view_fail("%s: has no NAME_specular.ktx2, .ktx or .dds: bake a map "
                  "into it (iblbake MAP -o %s), or name another directory, a "
                  "specular file or a map",
                  path, path);
    else if (count > 1)
        fail_several(path, names, count);
    else if (!(found = ibl_path_join(path, names[0])))
        view_file_no_memory(path);
    free_names(names, count);
    return found;
}

char *view_file_specular(const char *path)
{
    const char *words;
    char *found;

    switch (view_file_look(path, &words)) {
    case VIEW_FILE_DIRECTORY:
        return find_in_directory(path);
    case VIEW_FILE_MISSING:
        view_fail("%s: cannot be opened: %s", path, strerror(errno));
        return NULL;
    case VIEW_FILE_JSON:
        view_fail("%s: is JSON, no texture: name the NAME_specular file beside "
                  "it, or the directory",
                  path);
        return NULL;
    case VIEW_FILE_OTHER:
        view_fail("%s: is %s, where a baked specular file (KTX2, KTX or DDS) "
                  "is wanted: bake it first",
                  path, words);
        return NULL;
    case VIEW_FILE_TEXTURE:
    case VIEW_FILE_PIPE:
        break;
    }
    found = strdup(path);
    if (!found)
        view_file_no_memory(path);
    return found;
}
