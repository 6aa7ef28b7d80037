/* SPDX-License-Identifier: MIT */
/* Shards of a set of probes: which layers one has, and iblbake merge. */
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <unistd.h>

#include "cli/probes.h"
#include "common/path.h"
#include "json/json_text.h"

/* ---- a shard ------------------------------------------------------------ */

/* Hashes what decides which layers a shard has and how they are baked. */
static bool hash_whole(ibl_probes_bake *p, const int *owner)
{
    struct {
        char set[IBL_HASH_SIZE];
        int owner[IBL_MAX_PROBES];
    } whole;

    memset(&whole, 0, sizeof whole);
    memcpy(whole.owner, owner, (size_t)p->set.layers * sizeof *owner);
    if (!ibl_probes_hash_set(p, whole.set))
        return false;
    ibl_hash_bytes(&whole, sizeof whole, p->whole);
    return true;
}

/* Opens all captures, whose warnings follow when they are baked. */
static bool count_pixels(const ibl_probes_bake *p, uint64_t *pixels)
{
    const bool quiet = p->console->quiet;
    bool ok = true;

    p->console->quiet = true;
    for (int i = 0; i < p->set.layers && ok; i++)
        ok = ibl_capture_pixels(p, i, &pixels[i]);
    p->console->quiet = quiet;
    return ok;
}

bool ibl_probes_take_shard(ibl_probes_bake *p)
{
    const ibl_shard *shard = &p->opts->shard;
    const bool global = p->set.layers > p->set.count;
    uint64_t pixels[IBL_MAX_PROBES];
    int owner[IBL_MAX_PROBES];

    if (shard->count > p->set.count)
        return ibl_console_fail(p->console,
                                "--shard %d/%d: %s has %d probes, and each "
                                "shard needs one: take at most %d shards",
                                shard->number, shard->count, p->opts->input,
                                p->set.count, p->set.count);
    if (!count_pixels(p, pixels))
        return false;
    if (!ibl_shard_deal(pixels, p->set.layers, global, shard->count, owner))
        return ibl_probes_no_memory(p);
    if (!hash_whole(p, owner))
        return false;
    ibl_probe_set_keep(&p->set, owner, shard->number);
    return true;
}

/* ---- the command line of iblbake merge ---------------------------------- */

typedef struct merge_opts {
    ibl_probes_opts probes; /* common, output and sync */
    int count;
    const char *shard[IBL_MAX_PROBES]; /* directories */
} merge_opts;

#define IBL_SETTINGS merge_opts

/* clang-format off */
static const ibl_option outputs[] = {
    {"output", 'o', IBL_DIR(probes.output), .standard = "",
     .help = "directory of the set, made if it is not there; required"},
    {"sync", 0, IBL_FLAG(probes.sync),
     .help = "wait until everything is on the disk, so that a power cut "
             "leaves whole files"},
};
/* clang-format on */

static const ibl_section *const sections[] = {
    IBL_SECTION("Outputs", outputs),
    &ibl_threads_section,
    &ibl_messages_section,
    NULL,
};

static void defaults(void *settings)
{
    merge_opts *o = settings;

    *o = (merge_opts){.probes.common = ibl_common_default()};
}

static bool take(void *settings, const char *word)
{
    merge_opts *o = settings;

    if (o->count == IBL_MAX_PROBES)
        return ibl_misuse("%s: more than %d shards, which no set has", word,
                          IBL_MAX_PROBES);
    if (!*word || !strcmp(word, "-"))
        return ibl_misuse("a shard is a directory: give its name");
    o->shard[o->count++] = word;
    o->probes.input = o->shard[0]; /* for messages */
    return true;
}

static bool validate(void *settings)
{
    const merge_opts *o = settings;

    if (!o->count)
        return ibl_misuse("no shard: iblbake merge [options] SHARD... -o DIR, "
                          "see iblbake merge --help");
    if (!o->probes.output)
        return ibl_misuse("no output directory: add -o DIR");
    return ibl_common_validate(&o->probes.common);
}

/* ---- reading shards ----------------------------------------------------- */

typedef struct shard {
    const char *directory;
    int held; /* of ibl_probes_hold */
    json_t *index;
    char *path[IBL_PROBES_TEXTURES]; /* NULL: the set has no such file */
    int number, of;
} shard;

typedef struct merge {
    ibl_probes_bake p; /* its set has only what the files need */
    const merge_opts *opts;
    shard shard[IBL_MAX_PROBES];
    int count;
    json_t *layer[IBL_MAX_PROBES]; /* entries, owned by the shards */
} merge;

static json_t *about(const shard *s)
{
    return json_object_get(s->index, "shard");
}

/* Whether a shard belongs to the first one, and is given once. */
static bool check_shard(const merge *m, const shard *s)
{
    const shard *first = m->shard;
    ibl_console *console = m->p.console;

    if (!json_equal(json_object_get(s->index, "generator"),
                    json_object_get(first->index, "generator")))
        return ibl_console_fail(console,
                                "%s: is of another version or arithmetic "
                                "than %s: bake all shards with one, such as "
                                "--isa avx2",
                                s->directory, first->directory);
    if (s->of != first->of ||
        strcmp(text_of(about(s), "whole"), text_of(about(first), "whole")) != 0)
        return ibl_console_fail(console,
                                "%s: is of another set or of other options "
                                "than %s: bake it again as the others",
                                s->directory, first->directory);
    for (const shard *other = first; other < s; other++)
        if (other->number == s->number)
            return ibl_console_fail(console,
                                    "%s: is shard %d/%d, as %s is: give each "
                                    "once",
                                    s->directory, s->number, s->of,
                                    other->directory);
    return true;
}

/* Whether the files of a shard are those of its index. */
static bool check_files(const merge *m, shard *s)
{
    const json_t *files = json_object_get(s->index, "files");
    char hash[IBL_HASH_SIZE];

    for (int kind = 0; kind < IBL_PROBES_TEXTURES; kind++) {
        const json_t *file = json_object_get(files, ibl_probes_keys[kind]);
        if (!file)
            continue;
        s->path[kind] = ibl_path_join(s->directory, text_of(file, "file"));
        if (!s->path[kind])
            return ibl_probes_no_memory(&m->p);
        if (!ibl_hash_file(s->path[kind], hash))
            return ibl_console_fail(m->p.console, "%s: cannot be read: %s",
                                    s->path[kind], strerror(errno));
        if (strcmp(hash, text_of(file, "hash")) != 0)
            return ibl_console_fail(m->p.console,
                                    "%s: is not the file that its index.json "
                                    "describes: bake shard %d/%d again",
                                    s->path[kind], s->number, s->of);
    }
    return true;
}

/* Sets the number of the shard of an index; false: it is of none. */
static bool find_number(shard *s)
{
    s->number = (int)json_integer_value(json_object_get(about(s), "number"));
    s->of = (int)json_integer_value(json_object_get(about(s), "of"));
    return s->number >= 1 && s->number <= s->of && s->of <= IBL_MAX_PROBES;
}

static bool read_shard(merge *m, const char *directory)
{
    shard *s = &m->shard[m->count++];
    char *path = ibl_path_join(directory, "index.json");
    ibl_probe_index index;

    *s = (shard){.directory = directory};
    s->held = ibl_probes_hold(m->p.console, directory, LOCK_SH);
    if (path) {
        s->index = ibl_probes_index_load(path, m->p.ctx, m->p.console, &index);
        ibl_probe_index_free(&index);
    }
    free(path);
    if (!path)
        return ibl_probes_no_memory(&m->p);
    if (!s->index)
        return false;
    if (!find_number(s))
        return ibl_console_fail(m->p.console,
                                "%s: has a whole set, no shard: bake one with "
                                "iblbake probes --shard",
                                directory);
    return check_shard(m, s) && check_files(m, s);
}

/* Fails if a shard is missing; names all that are. */
static bool check_complete(const merge *m)
{
    const int of = m->shard->of;
    bool has[IBL_MAX_PROBES + 2] = {false};
    char missing[4 * IBL_MAX_PROBES] = "", *to = missing;

    for (int i = 0; i < m->count; i++)
        has[m->shard[i].number] = true;
    for (int i = 1, end; i <= of; i = end) {
        for (end = i + 1; end <= of && has[end] == has[i];)
            end++;
        if (!has[i])
            to += sprintf(to, end - i > 1 ? "%s%d-%d" : "%s%d",
                          to > missing ? "," : "", i, end - 1);
    }
    return to == missing ||
           ibl_console_fail(m->p.console,
                            "%s: missing shards of %d: %s: bake them, and "
                            "give the directories of all",
                            m->opts->probes.output, of, missing);
}

static bool read_shards(merge *m)
{
    bool ok = true;

    ibl_console_progress(m->p.console, "look", 0);
    for (int i = 0; i < m->opts->count && ok; i++)
        ok = ibl_console_differ(m->p.console, m->opts->probes.output,
                                m->opts->shard[i], "directory") &&
             read_shard(m, m->opts->shard[i]);
    return ok && check_complete(m);
}

/* ---- one set of all ------------------------------------------------------ */

/* The number in the whole set of layer i of a shard; -1: it has none. */
static int place_of(const merge *m, const shard *s, int i)
{
    const json_t *places = json_object_get(about(s), "layers");
    const json_t *place = json_array_get(places, (size_t)i);
    const json_int_t n = json_integer_value(place);

    return json_is_integer(place) && n >= 0 && n < m->p.set.layers ? (int)n
                                                                   : -1;
}

/* Finds the entries of a shard's layers. */
static bool take_entries(merge *m, const shard *s)
{
    json_t *entries = json_object_get(s->index, "probes"), *entry;
    json_t *global = json_object_get(s->index, "global");
    size_t i;

    if (global)
        json_array_append(entries, global);
    if (json_array_size(entries) !=
        json_array_size(json_object_get(about(s), "layers")))
        return false;
    json_array_foreach(entries, i, entry)
    {
        const int n = place_of(m, s, (int)i);
        if (n < 0 || m->layer[n])
            return false;
        m->layer[n] = entry;
        m->p.set.entry[n].alpha = json_is_true(json_object_get(entry, "alpha"));
    }
    return true;
}

/* Finds all layers, and the names of the files. */
static bool take_set(merge *m)
{
    const shard *first = m->shard;
    ibl_probes_bake *p = &m->p;

    for (int i = 0; i < m->count; i++)
        p->set.layers += (int)json_array_size(
            json_object_get(about(&m->shard[i]), "layers"));
    p->set.entry = calloc((size_t)p->set.layers + 1, sizeof *p->set.entry);
    if (!p->set.entry)
        return ibl_probes_no_memory(p);
    for (int i = 0; i < m->count; i++)
        if (p->set.layers < 1 || p->set.layers > IBL_MAX_PROBES ||
            !take_entries(m, &m->shard[i]))
            return ibl_console_fail(p->console,
                                    "%s: its index.json has other layers than "
                                    "its shard: bake it again",
                                    m->shard[i].directory);
    p->set.bake.zstd = (int)json_integer_value(json_object_get(
        json_object_get(json_object_get(first->index, "files"), "specular"),
        "zstd"));
    for (int kind = 0; kind < IBL_PROBES_FILES; kind++) {
        const char *name =
            kind == IBL_PROBES_INDEX ? "index.json" : first->path[kind];
        if (!name)
            continue;
        p->file[kind].path =
            ibl_path_join(p->opts->output, ibl_path_name(name));
        if (!p->file[kind].path)
            return ibl_probes_no_memory(p);
    }
    return true;
}

/* Copies the layers of a shard, and the keys of the first one. */
static bool copy_shard(merge *m, int kind, const shard *s)
{
    ibl_texture *array = &m->p.array[kind], from = {0};
    const bool first = s == m->shard;
    bool ok = !ibl_texture_read(m->p.ctx, s->path[kind], &from,
                                &m->p.set.bake.container);

    for (int i = 0; ok && place_of(m, s, i) >= 0; i++)
        ok = ibl_probes_copy_layer(&m->p, kind, place_of(m, s, i), i, &from);
    for (int i = 0; ok && first && i < from.key_count; i++)
        ok = !ibl_texture_set(m->p.ctx, array, from.keys[i].key,
                              from.keys[i].value);
    ibl_texture_free(&from);
    return ok;
}

static bool merge_arrays(merge *m)
{
    bool ok = true;

    for (int kind = 0; kind < IBL_PROBES_ARRAYS; kind++) {
        if (!m->shard->path[kind])
            continue;
        for (int i = 0; i < m->count && ok; i++)
            ok = m->shard[i].path[kind] && copy_shard(m, kind, &m->shard[i]);
        ok = ok && ibl_probes_put_texture(&m->p, (ibl_probes_kind)kind,
                                          &m->p.array[kind]);
    }
    return ok;
}

/* The table is the same in all shards. */
static bool copy_lut(merge *m)
{
    ibl_texture lut = {0};
    const bool ok = !ibl_texture_read(m->p.ctx, m->shard->path[IBL_PROBES_LUT],
                                      &lut, NULL) &&
                    ibl_probes_put_texture(&m->p, IBL_PROBES_LUT, &lut);

    ibl_texture_free(&lut);
    return ok;
}

/* Changes the entries of files in the first shard's index. */
static bool describe_files(const merge *m, const json_t *files)
{
    bool ok = true;

    for (int kind = 0; kind < IBL_PROBES_TEXTURES && ok; kind++) {
        json_t *file = json_object_get(files, ibl_probes_keys[kind]);
        const char *hash = m->p.file[kind].hash;
        ok = !file || (!json_object_set_new(file, "hash", json_string(hash)) &&
                       (kind == IBL_PROBES_LUT ||
                        !json_object_set_new(file, "layers",
                                             json_integer(m->p.set.layers))));
    }
    return ok;
}

/* Makes the first shard's index that of the whole set. */
static char *index_text(const merge *m)
{
    json_t *root = json_incref(m->shard->index), *probes = json_array();
    json_t *last = json_incref(m->layer[m->p.set.layers - 1]);
    const bool global = !json_object_get(last, "name");
    bool ok = describe_files(m, json_object_get(root, "files"));

    for (int i = 0; i < m->p.set.layers && ok; i++) {
        ok = !json_object_set_new(m->layer[i], "layer", json_integer(i));
        if (m->layer[i] != last || !global)
            append(&probes, json_incref(m->layer[i]));
    }
    json_object_del(root, "shard");
    json_object_del(root, "global");
    put(&root, "probes", probes);
    if (global)
        put(&root, "global", json_incref(last));
    json_decref(last);
    if (ok)
        return ibl_probes_index_seal(root);
    json_decref(root);
    return NULL;
}

static bool put_index(merge *m)
{
    ibl_probes_bake *p = &m->p;
    char *text = index_text(m);
    const bool ok =
        text && !ibl_outputs_add(p->outputs, p->file[IBL_PROBES_INDEX].path,
                                 text, strlen(text));

    free(text);
    return ok;
}

static void free_merge(merge *m)
{
    for (int i = 0; i < m->count; i++) {
        shard *s = &m->shard[i];
        for (int kind = 0; kind < IBL_PROBES_TEXTURES; kind++)
            free(s->path[kind]);
        json_decref(s->index);
        if (s->held >= 0)
            close(s->held);
    }
    ibl_probes_free(&m->p);
    free(m);
}

static int run(const void *settings)
{
    const merge_opts *opts = settings;
    const ibl_common *common = &opts->probes.common;
    ibl_console console;
    merge *m = calloc(1, sizeof *m);

    ibl_console_init(&console, common->quiet, common->verbose);
    if (!m)
        return ibl_console_end(&console, false);
    m->opts = opts;
    m->p.opts = &opts->probes;
    m->p.console = &console;
    const bool ok = ibl_probes_start(&m->p) && read_shards(m) && take_set(m) &&
                    merge_arrays(m) && copy_lut(m) && put_index(m) &&
                    ibl_console_commit(&console, m->p.outputs);
    const int status = ibl_console_end(&console, ok);
    if (ok && common->verbose)
        ibl_console_print_times(&console);
    free_merge(m);
    return status;
}

const ibl_command ibl_merge_command = {
    .name = "merge",
    .usage = "[options] SHARD... -o DIR",
    .brief = "make one set of probes of its shards",
    .intro = "Makes the set of reflection probes of which each SHARD is a part "
             "that\n"
             "iblbake probes --shard K/N baked. The files are those that one "
             "run of\n"
             "iblbake probes makes.\n",
    .statuses = "0 done, 1 failed, 2 wrong usage",
    .sections = sections,
    .settings_size = sizeof(merge_opts),
    .defaults = defaults,
    .take = take,
    .validate = validate,
    .run = run,
};
