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
#include "common/signals.h"
#include "port/port.h"
#include "json/text.h"

/* ---- listing ------------------------------------------------------------- */

/* sub: the folder of its outputs below the directory of all, "" or "sub/". */
static bool add(ibl_maps *maps, const char *input, const char *sub,
                ibl_console *c)
{
    char stem[IBL_STEM_BYTES];

    if (!ibl_stem(input, stem, sizeof stem)) {
        c->failed = true; /* that was said */
        return false;
    }
    maps->list = ibl_need(
        realloc(maps->list, (size_t)(maps->count + 1) * sizeof *maps->list));
    ibl_map *m = &maps->list[maps->count++];
    *m = (ibl_map){.input = ibl_need(strdup(input)),
                   .name = ibl_need(ibl_format("%s%s", sub, stem))};
    if (stat(input, &m->file))
        m->file.st_ino = 0;
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
        if (*entry->d_name == '.')
            continue;
        char *path = ibl_need(ibl_path_join(folder, entry->d_name));
        if (all && !lstat(path, &st) && S_ISDIR(st.st_mode)) {
            char *below = ibl_need(ibl_format("%s%s/", sub, entry->d_name));
            ok = add_entries(maps, path, below, true, c);
            free(below);
        } else if (ibl_is_environment(entry->d_name) && !is_folder(path)) {
            ok = add(maps, path, sub, c);
        }
        free(path);
    }
    closedir(dir);
    return ok;
}

static bool add_given(ibl_maps *maps, const char *given, bool all,
                      ibl_console *c)
{
    const int first = maps->count;

    if (!strcmp(given, "-"))
        return ibl_console_fail(c, "-: standard input is one environment: bake "
                                   "it alone, or give ./- if that is its name");
    if (!is_folder(given))
        return add(maps, given, "", c);
    if (!add_entries(maps, given, "", all, c))
        return false;
    if (maps->count == first)
        return ibl_console_fail(c,
                                "%s: is a directory without environments (.hdr "
                                ".rgbe .pic .exr .pfm .tif .tiff): name the "
                                "files themselves%s",
                                given,
                                all ? ""
                                    : ", or add --recursive for those in "
                                      "folders below it");
    qsort(maps->list + first, (size_t)(maps->count - first), sizeof *maps->list,
          by_input);
    return true;
}

/* Adds the names of a list, which end in line breaks, or in NULs if there are
 * any. Lines may be blank, and the first have a byte order mark before it. */
static bool add_list(ibl_maps *maps, const char *path, bool all, ibl_console *c)
{
    FILE *from = strcmp(path, "-") != 0 ? fopen(path, "r") : stdin;
    const int before = maps->count;
    size_t size = 0, room = 0, got = 1;
    char *text = NULL, *end;
    bool ok = true;

    if (!from)
        return ibl_console_fail(c, "--from %s: cannot be opened: %s", path,
                                strerror(errno));
    for (; got; size += got) {
        if (size + 1 >= room)
            text = ibl_need(realloc(text, room = room ? 2 * room : 1 << 12));
        got = fread(text + size, 1, room - 1 - size, from);
    }
    if (ferror(from))
        ok = ibl_console_fail(c, "--from %s: cannot be read: %s", path,
                              strerror(errno));
    text[size] = '\0';
    const bool nul = memchr(text, '\0', size);
    for (char *name = text + (strncmp(text, "\xEF\xBB\xBF", 3) ? 0 : 3);
         ok && name < text + size; name = end + 1) {
        end = name + strcspn(name, nul ? "" : "\n");
        *end = '\0';
        if (!nul && end > name && end[-1] == '\r')
            end[-1] = '\0';
        ibl_port_use_slashes(name);
        ok = !name[strspn(name, nul ? "" : " \t")] ||
             add_given(maps, name, all, c);
    }
    free(text);
    if (from != stdin)
        fclose(from);
    return ok && (maps->count > before ||
                  ibl_console_fail(c, "--from %s: names no environment", path));
}

/* ---- names --------------------------------------------------------------- */

/* Refuses two maps with the same outputs. */
static bool check_names(const ibl_maps *maps, ibl_console *c)
{
    json_t *seen = json_object(); /* indices by name */
    bool ok = true;

    for (int i = 0; i < maps->count && ok; i++) {
        const ibl_map *m = &maps->list[i];
        const json_t *other = json_object_get(seen, m->name);
        const char *first = maps->list[json_integer_value(other)].input;
        if (other && ibl_path_same(first, m->input) > 0)
            ok = ibl_console_fail(c, "%s and %s: are one file: give it once",
                                  first, m->input);
        else if (other)
            ok = ibl_console_fail(c,
                                  "%s and %s: both would make the files of %s: "
                                  "rename one, or bake them into two "
                                  "directories",
                                  first, m->input, m->name);
        json_object_set_new_nocheck(seen, m->name, json_integer(i));
    }
    json_decref(seen);
    return ok;
}

static void free_map(ibl_map *m)
{
    free(m->input);
    free(m->name);
    free(m->printed);
    free(m->rule);
}

/* Keeps every Nth map from the Kth on. */
static bool take_shard(ibl_maps *maps, const ibl_shard *shard, ibl_console *c)
{
    const int count = maps->count;

    if (shard->count > count)
        return ibl_console_fail(c,
                                "--shard %d/%d: there are %d environments: "
                                "take at most %d shards",
                                shard->number, shard->count, count, count);
    maps->count = 0;
    for (int i = 0; i < count; i++) {
        if (ibl_shard_has(shard, i))
            maps->list[maps->count++] = maps->list[i];
        else
            free_map(&maps->list[i]);
    }
    return true;
}

bool ibl_maps_list(const ibl_cmdline *line, ibl_console *console,
                   ibl_maps *maps)
{
    const ibl_opts *o = line->set;
    bool ok = true;

    for (int i = 0; i < line->given_count && ok; i++)
        ok = add_given(maps, line->given[i], o->recursive, console);
    ok = ok && (!o->from || add_list(maps, o->from, o->recursive, console));
    if (ok && ibl_is_given(&o->given, "name")) {
        if (maps->count > 1)
            return ibl_console_fail(console,
                                    "--name: is for one environment, and these "
                                    "are %d: leave it out",
                                    maps->count);
        char *name = maps->list->name;
        maps->list->name = ibl_need(ibl_format(
            "%.*s%s", (int)(ibl_path_name(name) - name), name, o->name));
        free(name);
    }
    return ok && check_names(maps, console) &&
           take_shard(maps, &o->shard, console);
}

void ibl_maps_free(ibl_maps *maps)
{
    for (int i = 0; i < maps->count; i++)
        free_map(&maps->list[i]);
    free(maps->list);
}
