/* SPDX-License-Identifier: MIT */
/* The environments of a batch, and the names of what they make. */
#include <dirent.h>
#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>

#include "cli/batch.h"
#include "common/path.h"
#include "json/text.h"

enum {
    MOST_LIST_BYTES = 1 << 28 /* of --from: a million long names */
};

/* ---- listing ------------------------------------------------------------- */

/* Takes input, which may be NULL: no memory. sub: the folder of its outputs
 * below the directory of all; "": that. */
static bool add(ibl_maps *maps, char *input, const char *sub, ibl_console *c)
{
    char stem[IBL_STEM_BYTES], *name = NULL;
    struct stat st;

    if (input && !ibl_stem(input, stem, sizeof stem))
        c->failed = true; /* that was said */
    else if (input)
        name = ibl_format("%s%s%s", sub, *sub ? "/" : "", stem);
    if (name && maps->count == maps->room) {
        const int room = maps->room ? 2 * maps->room : 64;
        ibl_map *list = realloc(maps->list, (size_t)room * sizeof *list);
        if (list) {
            maps->list = list;
            maps->room = room;
        }
    }
    if (!name || maps->count == maps->room) {
        free(name);
        free(input);
        return ibl_console_fail(c, "no memory for the list of environments");
    }
    ibl_map *m = &maps->list[maps->count++];
    *m = (ibl_map){.input = input, .name = name};
    if (!stat(input, &st)) {
        m->device = st.st_dev;
        m->inode = st.st_ino;
    }
    return true;
}

static bool is_folder(const char *path)
{
    struct stat st;

    return !stat(path, &st) && S_ISDIR(st.st_mode);
}

bool ibl_is_environment(const char *name)
{
    static const char *const endings[] = {".hdr", ".rgbe", ".pic", ".exr",
                                          ".pfm", ".tif",  ".tiff"};
    const char *dot = strrchr(name, '.');
    bool found = false;

    for (size_t i = 0; i < sizeof endings / sizeof *endings && dot; i++)
        found |= !strcasecmp(dot, endings[i]);
    return found && *name != '.';
}

static int by_input(const void *a, const void *b)
{
    return strcmp(((const ibl_map *)a)->input, ((const ibl_map *)b)->input);
}

/* Adds what is in a folder, and with `all` in those below it, but hidden ones
 * and links. */
static bool add_entries(ibl_maps *maps, const char *folder, const char *sub,
                        bool all, ibl_console *c)
{
    DIR *dir = opendir(folder);
    const struct dirent *entry;
    struct stat st;
    bool ok = true;

    if (!dir)
        return ibl_console_fail(c, "%s: cannot be listed: %s", folder,
                                strerror(errno));
    while (ok && (entry = readdir(dir))) {
        const char *name = entry->d_name;
        char *path = *name == '.' ? NULL : ibl_path_join(folder, name);
        if (*name == '.')
            continue;
        if (all && path && !lstat(path, &st) && S_ISDIR(st.st_mode)) {
            char *below = ibl_format("%s%s%s", sub, *sub ? "/" : "", name);
            ok = below && add_entries(maps, path, below, true, c);
            free(below);
        } else if (ibl_is_environment(name) && !(path && is_folder(path))) {
            ok = add(maps, path, sub, c);
            path = NULL;
        }
        free(path);
    }
    closedir(dir);
    return ok;
}

static bool add_folder(ibl_maps *maps, const char *folder, bool all,
                       ibl_console *c)
{
    const int first = maps->count;

    if (!add_entries(maps, folder, "", all, c))
        return false;
    if (maps->count == first)
        return ibl_console_fail(c,
                                "%s: is a directory without environments (.hdr "
                                ".rgbe .pic .exr .pfm .tif .tiff): name the "
                                "files themselves%s",
                                folder,
                                all ? ""
                                    : ", or add --recursive for those in "
                                      "folders below it");
    qsort(maps->list + first, (size_t)(maps->count - first), sizeof *maps->list,
          by_input);
    return true;
}

static bool add_given(ibl_maps *maps, const char *given, bool all,
                      ibl_console *c)
{
    if (!strcmp(given, "-"))
        return ibl_console_fail(c, "-: standard input is one environment: bake "
                                   "it alone, or give ./- if that is its name");
    if (is_folder(given))
        return add_folder(maps, given, all, c);
    return add(maps, strdup(given), "", c);
}

/* Reads a list to its end, and a NUL behind it. NULL after a message. */
static char *read_list(const char *path, FILE *from, size_t *size,
                       ibl_console *c)
{
    size_t room = 1 << 16, got = 1;
    char *text = malloc(room), *more;

    for (*size = 0; text && got; *size += got) {
        if (*size + 1 == room) {
            more = room < MOST_LIST_BYTES ? realloc(text, room * 2) : NULL;
            if (!more)
                break;
            text = more;
            room *= 2;
        }
        got = fread(text + *size, 1, room - *size - 1, from);
    }
    if (text && !got && !ferror(from)) {
        text[*size] = '\0';
        return text;
    }
    free(text);
    if (ferror(from))
        ibl_console_fail(c, "--from %s: cannot be read: %s", path,
                         strerror(errno));
    else
        ibl_console_fail(c, "--from %s: is too long, over %zu bytes", path,
                         *size);
    return NULL;
}

/* Names end in line breaks, or in NULs if there are any. Lines may be blank,
 * and the first have a byte order mark before it. */
static bool add_names(ibl_maps *maps, char *text, size_t size, bool all,
                      ibl_console *c)
{
    const char last = memchr(text, '\0', size) ? '\0' : '\n';
    const size_t mark = strncmp(text, "\xEF\xBB\xBF", 3) ? 0 : 3;
    bool ok = true;

    for (char *at = text + mark; ok && at < text + size;) {
        char *end = memchr(at, last, (size_t)(text + size - at));
        if (!end)
            end = text + size;
        char *next = end + 1;
        if (last && end > at && end[-1] == '\r')
            end--;
        *end = '\0';
        ok = !at[strspn(at, last ? " \t" : "")] || add_given(maps, at, all, c);
        at = next;
    }
    return ok;
}

static bool add_list(ibl_maps *maps, const char *path, bool all, ibl_console *c)
{
    const bool standard_input = !strcmp(path, "-");
    FILE *from = standard_input ? stdin : fopen(path, "r");
    const int before = maps->count;
    size_t size;

    if (!from)
        return ibl_console_fail(c, "--from %s: cannot be opened: %s", path,
                                strerror(errno));
    char *text = read_list(path, from, &size, c);
    const bool ok = text && add_names(maps, text, size, all, c);
    free(text);
    if (!standard_input)
        fclose(from);
    return ok && (maps->count > before ||
                  ibl_console_fail(c, "--from %s: names no environment", path));
}

static int by_name(const void *a, const void *b)
{
    return strcmp((*(const ibl_map *const *)a)->name,
                  (*(const ibl_map *const *)b)->name);
}

/* Refuses two maps with the same outputs. */
static bool check_names(const ibl_maps *maps, ibl_console *c)
{
    const size_t count = (size_t)maps->count;
    const ibl_map **order = malloc(count * sizeof *order);
    bool ok = true;

    if (!order)
        return ibl_console_fail(c, "no memory for the list of environments");
    for (size_t i = 0; i < count; i++)
        order[i] = &maps->list[i];
    qsort(order, count, sizeof *order, by_name);
    for (size_t i = 1; i < count && ok; i++) {
        const ibl_map *a = order[i - 1], *b = order[i];
        if (strcmp(a->name, b->name) != 0)
            continue;
        if (a > b) { /* the first of the line is named first */
            a = b;
            b = order[i - 1];
        }
        if (ibl_path_same(a->input, b->input) > 0)
            ok = ibl_console_fail(c, "%s and %s: are one file: give it once",
                                  a->input, b->input);
        else
            ok = ibl_console_fail(c,
                                  "%s and %s: both would make the files of %s: "
                                  "rename one, or bake them into two "
                                  "directories",
                                  a->input, b->input, a->name);
    }
    free(order);
    return ok;
}

bool ibl_maps_list(const ibl_cmdline *line, ibl_console *console,
                   ibl_maps *maps)
{
    const ibl_opts *o = line->set;
    bool ok = true;

    for (int i = 0; i < line->given_count && ok; i++)
        ok = add_given(maps, line->given[i], o->recursive, console);
    ok = ok && (!o->from || add_list(maps, o->from, o->recursive, console));
    if (ok && maps->count > 1 && ibl_is_given(&o->given, "name"))
        return ibl_console_fail(console,
                                "--name: is for one environment, and these are "
                                "%d: leave it out",
                                maps->count);
    if (ok && ibl_is_given(&o->given, "name")) {
        ibl_map *m = maps->list; /* the only one */
        char *name =
            ibl_format("%.*s%s", (int)(ibl_path_name(m->name) - m->name),
                       m->name, o->name);
        free(m->name);
        m->name = name;
        ok = name || ibl_console_fail(console, "no memory for a name");
    }
    return ok && check_names(maps, console);
}

static void free_map(ibl_map *m)
{
    free(m->input);
    free(m->name);
    free(m->printed);
    free(m->rule);
}

void ibl_maps_keep(ibl_maps *maps, const int *owner, int shard)
{
    const int count = maps->count;

    maps->count = 0;
    for (int i = 0; i < count; i++) {
        if (owner[i] == shard)
            maps->list[maps->count++] = maps->list[i];
        else
            free_map(&maps->list[i]);
    }
}

void ibl_maps_free(ibl_maps *maps)
{
    for (int i = 0; i < maps->count; i++)
        free_map(&maps->list[i]);
    free(maps->list);
}

void ibl_map_line(const ibl_cmdline *all, const ibl_map *map, ibl_cmdline *own)
{
    *own = *all;
    for (int i = 0; i < own->count; i++) {
        ibl_opts *o = &own->set[i];
        o->input = map->input;
        o->below = map->name;
        if (ibl_is_given(&o->given, "name"))
            continue;
        /* Of stem, as it was derived: it replaces no other map's files. */
        o->name = o->stem;
        snprintf(o->stem, sizeof o->stem, "%s", ibl_path_name(map->name));
    }
}
