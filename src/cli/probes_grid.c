/* SPDX-License-Identifier: MIT */
/* --grid: makes a set of probes in a regular grid; the user adds captures. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cli/probes.h"
#include "cli/shell_words.h"
#include "common/signals.h"
#include "json/json_text.h"

enum {
    MOST_ALONG = 1000 /* cells along an axis */
};

typedef struct grid {
    ibl_json_at root;
    double low[3], high[3];
    int counts[3];
    double cell[3];
    const char *name;
    ibl_capture_kind kind;
    const char *capture[IBL_FACES]; /* as in ibl_set_capture */
    double (*solid)[2][3];          /* low and high corners of boxes */
    size_t solids;
    double blend;
    int priority;
    json_t *probes; /* of the new set */
    int made, skipped;
} grid;

/* ---- reading ----------------------------------------------------------- */

static bool take_box(ibl_json_at at, double low[3], double high[3])
{
    const ibl_json_at max = ibl_json_member(&at, "max");

    if (!ibl_json_place(ibl_json_member(&at, "min"), low) ||
        !ibl_json_place(max, high))
        return false;
    for (size_t k = 0; k < 3; k++)
        if (high[k] <= low[k])
            return ibl_json_wrong(ibl_json_element(&max, k),
                                  "a number above min's %.10g", low[k]);
    return true;
}

/* Takes counts, or the fewest cells that are no larger than the spacing. */
static bool take_cells(ibl_json_at root, grid *g)
{
    const ibl_json_at counts = ibl_json_member(&root, "counts");
    const ibl_json_at spacing = ibl_json_member(&root, "spacing");
    double largest[3] = {0};
    bool ok;

    if (!spacing.value == !counts.value)
        return ibl_json_wrong(root, "one of spacing and counts");
    if (counts.value)
        ok = ibl_json_array(counts, 3, 3);
    else if (json_is_array(spacing.value))
        ok = ibl_json_triple(spacing, 0, IBL_JSON_FARTHEST, true, largest);
    else
        ok = ibl_json_real(spacing, 0, IBL_JSON_FARTHEST, true, largest);
    for (size_t k = 0; k < 3 && ok; k++) {
        const double size = g->high[k] - g->low[k];
        if (counts.value) {
            ok = ibl_json_int(ibl_json_element(&counts, k), 1, MOST_ALONG,
                              &g->counts[k]);
        } else {
            /* The factor is for rounding: 2.1 / 0.3 is a little above 7. */
            const double n =
                ceil(size / largest[largest[k] > 0 ? k : 0] * (1 - 1e-12));
            if (n > MOST_ALONG)
                return ibl_json_wrong(spacing, "at most %d cells along an axis",
                                      MOST_ALONG);
            g->counts[k] = n > 1 ? (int)n : 1;
        }
        g->cell[k] = size / g->counts[k];
    }
    return ok;
}

static bool take_name(ibl_json_at at, grid *g)
{
    static const char *const holders[] = {"{x}", "{y}", "{z}"};

    g->name = "probe_{x}_{y}_{z}";
    if (!ibl_json_text_at(at, &g->name))
        return false;
    for (int k = 0; k < 3; k++)
        if (g->counts[k] > 1 && !strstr(g->name, holders[k]))
            return ibl_json_wrong(
                at, "a name with %s, as there are %d cells along that axis",
                holders[k], g->counts[k]);
    return true;
}

static bool take_solid(ibl_json_at at, grid *g)
{
    static const char *const keys[] = {"min", "max", NULL};
    const size_t count = json_array_size(at.value);
    bool ok = ibl_json_array(at, 0, 1000000);

    g->solid = calloc(count + 1, sizeof *g->solid);
    for (; ok && g->solid && g->solids < count; g->solids++) {
        const ibl_json_at box = ibl_json_element(&at, g->solids);
        ok = ibl_json_object(box, keys) &&
             take_box(box, g->solid[g->solids][0], g->solid[g->solids][1]);
    }
    return ok && g->solid;
}

static bool take_grid(ibl_json_at root, grid *g)
{
    static const char *const keys[] = {
        "version", "min",   "max",      "spacing",  "counts", "solid", "name",
        "capture", "blend", "priority", "defaults", "global", "proxy", NULL};
    ibl_volume volume;
    int version;

    if (ibl_json_member(&root, "probes").value)
        return ibl_json_complain(root, "is a set already: leave out --grid");
    if (!ibl_json_object(root, keys) ||
        !ibl_json_int(ibl_json_member(&root, "version"), IBL_SET_VERSION,
                      IBL_SET_VERSION, &version) ||
        !take_box(root, g->low, g->high) || !take_cells(root, g) ||
        !take_solid(ibl_json_optional(&root, "solid"), g) ||
        !take_name(ibl_json_optional(&root, "name"), g) ||
        !ibl_set_capture(ibl_json_optional(&root, "capture"), &g->kind,
                         g->capture))
        return false;
    const double least = fmin(g->cell[0], fmin(g->cell[1], g->cell[2]));
    g->blend = least / 2;
    return ibl_json_real(ibl_json_optional(&root, "blend"), 0, least, false,
                         &g->blend) &&
           ibl_json_int(ibl_json_optional(&root, "priority"),
                        -IBL_JSON_PRIORITY, IBL_JSON_PRIORITY, &g->priority) &&
           ibl_json_volume(ibl_json_optional(&root, "proxy"), &volume);
}

/* ---- making ------------------------------------------------------------ */

static bool is_solid(const grid *g, const double p[3])
{
    for (size_t i = 0; i < g->solids; i++) {
        const double *low = g->solid[i][0], *high = g->solid[i][1];
        int k = 0;
        while (k < 3 && p[k] >= low[k] && p[k] <= high[k])
            k++;
        if (k == 3)
            return true;
    }
    return false;
}

/* The capture of a probe, with its name for {name}; NULL: no memory. */
static json_t *make_capture(const grid *g, const char *name)
{
    const ibl_placeholder holder = {"name", name};
    const bool faces = g->kind == IBL_CAPTURE_FACES;
    json_t *files = json_array();

    for (int i = 0; i < (faces ? IBL_FACES : 1); i++) {
        char *file = ibl_words_fill(g->capture[i], &holder, 1);
        append(&files, file ? json_string(file) : NULL);
        free(file);
    }
    json_t *capture = json_pack("{sO}", ibl_capture_names[g->kind],
                                faces ? files : json_array_get(files, 0));
    json_decref(files);
    return capture;
}

static double middle(const grid *g, int axis, int at)
{
    return g->low[axis] + (at + 0.5) * g->cell[axis];
}

/* How far the influence of a cell's probe reaches beyond its cell to a side:
 * half the blend into a neighbour, so that their weights sum to 1. Where there
 * is none its weight is 1 on the walls: of the grid, or in a solid cell up to
 * its middle, or all of it if nothing reaches there from behind. */
static double reach(const grid *g, const int at[3], int axis, int side)
{
    bool free[2];
    double p[3];

    for (int k = 0; k < 3; k++)
        p[k] = middle(g, k, at[k]);
    for (int n = 0; n < 2; n++) {
        const int there = at[axis] + (n + 1) * side;
        p[axis] = middle(g, axis, there);
        free[n] = there >= 0 && there < g->counts[axis] && !is_solid(g, p);
    }
    if (free[0])
        return g->blend / 2;
    if (at[axis] == (side < 0 ? 0 : g->counts[axis] - 1))
        return g->blend;
    return g->blend + g->cell[axis] / (free[1] ? 2 : 1);
}

/* Adds a probe in the middle p of its cell. */
static void add_probe(grid *g, const int at[3], const double p[3])
{
    char number[3][16];
    const ibl_placeholder holders[] = {
        {"x", number[0]}, {"y", number[1]}, {"z", number[2]}};
    double centre[3], half[3];

    for (int k = 0; k < 3; k++) {
        const double below = reach(g, at, k, -1), above = reach(g, at, k, 1);
        snprintf(number[k], sizeof number[k], "%d", at[k]);
        centre[k] = p[k] + (above - below) / 2;
        half[k] = (g->cell[k] + above + below) / 2;
    }
    char *name = ibl_words_fill(g->name, holders, 3);
    json_t *probe =
        name ? json_pack("{ss s[fff] so s{s{s[fff] s[fff]}} sf sO*}", "name",
                         name, "position", p[0], p[1], p[2], "capture",
                         make_capture(g, name), "influence", "box", "centre",
                         centre[0], centre[1], centre[2], "half", half[0],
                         half[1], half[2], "blend", g->blend, "proxy",
                         json_object_get(g->root.value, "proxy"))
             : NULL;
    free(name);
    if (g->priority)
        put(&probe, "priority", json_integer(g->priority));
    append(&g->probes, probe);
}

/* The text of a set with a probe in each free cell, x fastest, then y, then z.
 * NULL after a line on stderr, or without memory. */
static char *make_set(grid *g)
{
    const int *n = g->counts;

    g->probes = json_array();
    for (int cell = 0; cell < n[0] * n[1] * n[2]; cell++) {
        const int at[3] = {cell % n[0], cell / n[0] % n[1], cell / n[0] / n[1]};
        double p[3];
        for (int k = 0; k < 3; k++)
            p[k] = middle(g, k, at[k]);
        if (is_solid(g, p)) {
            g->skipped++;
            continue;
        }
        if (++g->made > IBL_MAX_PROBES) {
            ibl_json_complain(g->root,
                              "expected a grid of at most %d probes, found "
                              "more: choose a wider spacing",
                              IBL_MAX_PROBES);
            break;
        }
        add_probe(g, at, p);
    }
    if (!g->made)
        ibl_json_complain(g->root,
                          "expected a cell that is free, found all %d solid",
                          g->skipped);
    json_t *set = json_pack(
        "{si sO* sO* so}", "version", IBL_SET_VERSION, "defaults",
        json_object_get(g->root.value, "defaults"), "global",
        json_object_get(g->root.value, "global"), "probes", g->probes);
    const bool ok = g->made && g->made <= IBL_MAX_PROBES;
    char *text = ok ? ibl_json_text(set) : NULL;
    json_decref(set);
    return text;
}

/* ---- the command -------------------------------------------------------- */

static bool write_set(const ibl_probes_opts *opts, ibl_console *console,
                      const char *text)
{
    ibl_ctx *ctx = NULL;
    ibl_outputs *outputs = NULL;
    ibl_common common = opts->common;

    ibl_signals_catch();
    common.threads = 1;
    const bool ok =
        ibl_console_differ(console, opts->input[0], opts->output, "file") &&
        !ibl_start(&common, console, &ctx) &&
        !ibl_outputs_create(ctx, opts->sync, &outputs) &&
        !ibl_outputs_add(outputs, opts->output, text, strlen(text)) &&
        !ibl_outputs_commit(outputs);
    ibl_outputs_free(outputs);
    ibl_ctx_free(ctx);
    return ok;
}

int ibl_probes_grid(const ibl_probes_opts *opts)
{
    ibl_console console;
    ibl_json_file file = {
        .name = opts->input[0], .fail = ibl_console_error, .cookie = &console};
    grid g = {.capture = {"captures/{name}.exr"}};

    ibl_console_init(&console, opts->common.quiet, opts->common.verbose);
    bool ok = ibl_json_open(&file);
    g.root = ibl_json_root(&file);
    char *text = ok && take_grid(g.root, &g) ? make_set(&g) : NULL;
    ok = text && (!opts->output || write_set(opts, &console, text));
    if (ok && !opts->output)
        fputs(text, stdout);
    const int status = ibl_console_end(&console, ok);
    if (ok)
        ibl_console_info(&console, "placed %d probes, left out %d solid cells",
                         g.made, g.skipped);
    json_decref(file.root);
    free(g.solid);
    free(text);
    return status;
}
