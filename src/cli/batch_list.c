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

enum {
    MOST_LIST_BYTES = 1 << 28 /* of --from: a million long names */
};

static bool no_memory(ibl_console *c)
{
    return ibl_console_fail(c, "no memory for the list of environments");
}

/* ---- listing ------------------------------------------------------------- */

/* Takes input, which may be NULL: no memory. */
static bool add(ibl_maps *maps, char *input, ibl_console *c)
{
    if (input && maps->count == maps->room) {
        const int room = maps->room ? 2 * maps->room : 64;
        ibl_map *list = realloc(maps->list, (size_t)room * sizeof *list);
        if (list) {
            maps->list = list;
            maps->room = room;
        }
    }
    if (!input || maps->count == maps->room) {
        free(input);
        return no_memory(c);
    }
    maps->list[maps->count++] = (ibl_map){.input = input};
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

static int by_name(const void *a, const void *b)
{
    return strcmp(((const ibl_map *)a)->input, ((const ibl_map *)b)->input);
}

static bool add_folder(ibl_maps *maps, const char *folder, ibl_console *c)
{
    const int first = maps->count;
    DIR *dir = opendir(folder);
    const struct dirent *entry;
    bool ok = true;

    if (!dir)
        return ibl_console_fail(c, "%s: cannot be listed: %s", folder,
                                strerror(errno));
    while (ok && (entry = readdir(dir))) {
        if (!ibl_is_environment(entry->d_name))
            continue;
        char *path = ibl_path_join(folder, entry->d_name);
        if (path && is_folder(path))
            free(path);
        else
            ok = add(maps, path, c);
    }
    closedir(dir);
    if (ok && maps->count == first)
        return ibl_console_fail(c,
                                "%s: is a directory without environments (.hdr "
                                ".rgbe .pic .exr .pfm .tif .tiff): name the "
                                "files themselves",
                                folder);
    if (ok)
        qsort(maps->list + first, (size_t)(maps->count - first),
              sizeof *maps->list, by_name);
    return ok;
}

static bool add_given(ibl_maps *maps, const char *given, ibl_console *c)
{
    if (!strcmp(given, "-"))
        return ibl_console_fail(c, "-: standard input is one environment: bake "
                                   "it alone, or give ./- if that is its name");
    if (is_folder(given))
        return add_folder(maps, given, c);
    return add(maps, strdup(given), c);
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
static bool add_names(ibl_maps *maps, char *text, size_t size, ibl_console *c)
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
        ok = !at[strspn(at, last ? " \t" : "")] || add_given(maps, at, c);
        at = next;
    }
    return ok;
}

static bool add_list(ibl_maps *maps, const char *path, ibl_console *c)
{
    const bool standard_input = !strcmp(path, "-");
    FILE *from = standard_input ? stdin : fopen(path, "r");
    const int before = maps->count;
    size_t size;

    if (!from)
        return ibl_console_fail(c, "--from %s: cannot be opened: %s", path,
                                strerror(errno));
    char *text = read_list(path, from, &size, c);
    const bool ok = text && add_names(maps, text, size, c);
    free(text);
    if (!standard_input)
        fclose(from);
    return ok && (maps->count > before ||
                  ibl_console_fail(c, "--from %s: names no environment", path));
}

bool ibl_maps_list(const ibl_bake_line *line, ibl_console *console,
                   ibl_maps *maps)
{
    bool ok = true;

    for (int i = 0; i < line->given_count && ok; i++)
        ok = add_given(maps, line->given[i], console);
    ok = ok && (!line->set->from || add_list(maps, line->set->from, console));
    return ok &&
           (maps->count == 1 || !ibl_is_given(&line->set->given, "name") ||
            ibl_console_fail(console,
                             "--name: is for one environment, and "
                             "these are %d: leave it out",
                             maps->count));
}

static void free_map(ibl_map *m)
{
    free(m->input);
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

/* ---- names --------------------------------------------------------------- */

static bool aim(ibl_opts *o, const char *input)
{
    o->input = input;
    if (o->name && o->given.count && ibl_is_given(&o->given, "name"))
        return true;
    o->name = o->stem;
    return ibl_stem(input, o->stem, sizeof o->stem);
}

bool ibl_map_line(const ibl_bake_line *all, const char *input,
                  ibl_bake_line *own)
{
    *own = *all;
    bool ok = true;
    for (int i = 0; i < own->count && ok; i++)
        ok = aim(&own->set[i], input);
    return ok;
}

/* A file that a map makes. */
typedef struct target {
    char *path;
    int map;
} target;

typedef struct targets {
    target *list;
    size_t count, room;
} targets;

/* A file that a map is read from. */
typedef struct origin {
    dev_t device;
    ino_t inode;
    int map;
} origin;

static bool add_target(targets *t, const char *path, int map)
{
    if (t->count == t->room) {
        const size_t room = t->room ? 2 * t->room : 256;
        target *list = realloc(t->list, room * sizeof *list);
        if (!list)
            return false;
        t->list = list;
        t->room = room;
    }
    char *copy = strdup(path);
    if (copy)
        t->list[t->count++] = (target){copy, map};
    return copy;
}

/* Adds the files of a set, but those that all maps share. */
static bool add_set(targets *t, const ibl_bake *b, int map)
{
    const char *paths[IBL_SET_PATHS];
    const int count = ibl_bake_files(b, false, paths);
    bool ok = true;

    for (int i = 0; i < count && ok; i++)
        ok = add_target(t, paths[i], map);
    return ok;
}

static bool add_targets(const ibl_bake_line *line, ibl_ctx *ctx,
                        ibl_console *console, const ibl_maps *maps, targets *t)
{
    ibl_bake_line *own = malloc(sizeof *own);
    ibl_map_bake *r = malloc(sizeof *r);
    bool ok = own && r, named = true;

    for (int m = 0; m < maps->count && ok && named; m++) {
        *r = (ibl_map_bake){.line = own, .from.ctx = ctx};
        named = ibl_map_line(line, maps->list[m].input, own);
        if (!named)
            break;
        ok = ibl_bake_begin(r) && ibl_bake_names(r);
        for (int i = 0; ok && i < r->count; i++)
            ok = add_set(t, &r->sets[i], m);
        named = !ok || !line->set->depfile ||
                ibl_bake_check_depfile(r->sets, r->count);
        console->failed |= r->console.failed; /* it was reported */
        ibl_bake_end(r);
    }
    free(own);
    free(r);
    console->failed |= !named;
    return ok ? named : no_memory(console);
}

static int by_path(const void *a, const void *b)
{
    const target *x = a, *y = b;
    const int order = strcmp(x->path, y->path);
    return order ? order : x->map - y->map;
}

static int by_file(const void *a, const void *b)
{
    const origin *x = a, *y = b;
    if (x->device != y->device)
        return x->device < y->device ? -1 : 1;
    return x->inode < y->inode ? -1 : x->inode > y->inode;
}

/* Two maps that make a file. */
static bool fail_twins(const char *a, const char *b, const char *path,
                       ibl_console *c)
{
    if (ibl_path_same(a, b) > 0)
        return ibl_console_fail(c, "%s and %s: are one file: give it once", a,
                                b);
    return ibl_console_fail(c,
                            "%s and %s: both would make %s: rename one, or "
                            "bake them into two directories",
                            a, b, path);
}

static bool check_twins(const targets *t, const ibl_maps *maps, ibl_console *c)
{
    bool ok = true;

    for (size_t i = 1; i < t->count && ok; i++) {
        const target *a = &t->list[i - 1], *b = &t->list[i];
        if (!strcmp(a->path, b->path))
            ok = fail_twins(maps->list[a->map].input, maps->list[b->map].input,
                            a->path, c);
    }
    return ok;
}

/* A map's own input is checked before it is baked. */
static bool check_origins(const targets *t, const ibl_maps *maps,
                          ibl_console *c)
{
    origin *list = malloc((size_t)maps->count * sizeof *list);
    size_t count = 0;
    struct stat st;
    bool ok = true;

    if (!list)
        return no_memory(c);
    for (int m = 0; m < maps->count; m++)
        if (!stat(maps->list[m].input, &st))
            list[count++] = (origin){st.st_dev, st.st_ino, m};
    qsort(list, count, sizeof *list, by_file);
    for (size_t i = 0; i < t->count && ok; i++) {
        if (stat(t->list[i].path, &st))
            continue;
        const origin key = {st.st_dev, st.st_ino, 0};
        const origin *from = bsearch(&key, list, count, sizeof *list, by_file);
        if (from)
            ok = ibl_console_fail(c,
                                  "%s: would be replaced by %s, an output of "
                                  "%s: choose another directory",
                                  maps->list[from->map].input, t->list[i].path,
                                  maps->list[t->list[i].map].input);
    }
    free(list);
    return ok;
}

bool ibl_maps_check(const ibl_bake_line *line, ibl_ctx *ctx,
                    ibl_console *console, const ibl_maps *maps)
{
    targets t = {0};
    bool ok = add_targets(line, ctx, console, maps, &t);

    if (ok)
        qsort(t.list, t.count, sizeof *t.list, by_path);
    ok = ok && check_twins(&t, maps, console) &&
         check_origins(&t, maps, console);
    for (size_t i = 0; i < t.count; i++)
        free(t.list[i].path);
    free(t.list);
    return ok;
}
