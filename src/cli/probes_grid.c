/* SPDX-License-Identifier: MIT */
/* --grid: makes a set of probes in a regular grid; the user adds captures. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cli/probes.h"
#include "cli/words.h"
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
    double (*solid)[2][3]; /* low and high corners of boxes */
    size_t solids;
    double blend;
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

/* What probes take over as it is, is checked when the set is baked. */
static bool take_grid(ibl_json_at root, grid *g)
{
    static const char *const keys[] = {
        "version", "min",   "max",      "spacing",  "counts", "solid", "name",
        "capture", "blend", "priority", "defaults", "global", "proxy", NULL};
    static const char *const box_keys[] = {"min", "max", NULL};
    static const char *const holders[] = {"{x}", "{y}", "{z}"};
    const ibl_json_at solid = ibl_json_optional(&root, "solid");
    const ibl_json_at name = ibl_json_optional(&root, "name");
    const size_t solids = json_array_size(solid.value);
    int version;

    if (ibl_json_member(&root, "probes").value)
        return ibl_json_complain(root, "is a set already: leave out --grid");
    if (!ibl_json_object(root, keys) ||
        !ibl_json_int(ibl_json_member(&root, "version"), IBL_SET_VERSION,
                      IBL_SET_VERSION, &version) ||
        !take_box(root, g->low, g->high) || !take_cells(root, g) ||
        !ibl_json_array(solid, 0, 1000000))
        return false;
    g->solid = ibl_need(calloc(solids + 1, sizeof *g->solid));
    for (; g->solids < solids; g->solids++) {
        const ibl_json_at box = ibl_json_element(&solid, g->solids);
        if (!ibl_json_object(box, box_keys) ||
            !take_box(box, g->solid[g->solids][0], g->solid[g->solids][1]))
            return false;
    }
    g->name = "probe_{x}_{y}_{z}";
    if (!ibl_json_text_at(name, &g->name))
        return false;
    for (int k = 0; k < 3; k++)
        if (g->counts[k] > 1 && !strstr(g->name, holders[k]))
            return ibl_json_wrong(
                name, "a name with %s, as there are %d cells along that axis",
                holders[k], g->counts[k]);
    const double least = fmin(g->cell[0], fmin(g->cell[1], g->cell[2]));
    g->blend = least / 2;
    return ibl_json_real(ibl_json_optional(&root, "blend"), 0, least, false,
                         &g->blend);
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

/* Fills {name} in, in all strings. */
static void fill(json_t *j, const ibl_placeholder *name)
{
    const char *key;
    json_t *part;
    size_t i;

    if (json_is_string(j)) {
        char *text = ibl_need(ibl_words_fill(json_string_value(j), name, 1));
        json_string_set(j, text);
        free(text);
    }
    json_array_foreach(j, i, part) fill(part, name);
    json_object_foreach(j, key, part) fill(part, name);
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

/* A probe in the middle p of its cell. */
static json_t *make_probe(const grid *g, const int at[3], const double p[3])
{
    const json_t *given = json_object_get(g->root.value, "capture");
    json_t *capture =
        given ? json_deep_copy(given)
              : json_pack("{ss}", "equirect", "captures/{name}.exr");
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
    char *name = ibl_need(ibl_words_fill(g->name, holders, 3));
    fill(capture, &(ibl_placeholder){"name", name});
    json_t *probe =
        json_pack("{ss s[fff] so s{s{s[fff] s[fff]}} sf sO* sO*}", "name", name,
                  "position", p[0], p[1], p[2], "capture", capture, "influence",
                  "box", "centre", centre[0], centre[1], centre[2], "half",
                  half[0], half[1], half[2], "blend", g->blend, "proxy",
                  json_object_get(g->root.value, "proxy"), "priority",
                  json_object_get(g->root.value, "priority"));
    free(name);
    return probe;
}

/* A probe in each free cell, x fastest, then y, then z. NULL after a message.
 */
static json_t *make_probes(const grid *g)
{
    const int *n = g->counts, cells = n[0] * n[1] * n[2];
    json_t *probes = json_array();

    for (int cell = 0; cell < cells; cell++) {
        const int at[3] = {cell % n[0], cell / n[0] % n[1], cell / n[0] / n[1]};
        double p[3];
        for (int k = 0; k < 3; k++)
            p[k] = middle(g, k, at[k]);
        if (is_solid(g, p))
            continue;
        if (json_array_size(probes) == IBL_MAX_PROBES) {
            ibl_json_complain(g->root,
                              "expected a grid of at most %d probes, found "
                              "more: choose a wider spacing",
                              IBL_MAX_PROBES);
            json_decref(probes);
            return NULL;
        }
        json_array_append_new(probes, make_probe(g, at, p));
    }
    if (json_array_size(probes))
        return probes;
    json_decref(probes);
    ibl_json_complain(
        g->root, "expected a cell that is free, found all %d solid", cells);
    return NULL;
}

/* ---- the command -------------------------------------------------------- */

bool ibl_probes_grid(const ibl_probes_opts *opts, ibl_console *console,
                     ibl_ctx *ctx)
{
    ibl_json_file file = {
        .name = opts->input[0], .fail = ibl_console_error, .cookie = console};
    ibl_outputs *outputs = NULL;
    grid g = {0};
    json_t *probes = NULL;

    bool ok = ibl_json_open(&file);
    g.root = ibl_json_root(&file);
    ok = ok && take_grid(g.root, &g) && (probes = make_probes(&g));
    if (ok) {
        const int cells = g.counts[0] * g.counts[1] * g.counts[2];
        const int placed = (int)json_array_size(probes);
        json_t *set = json_pack(
            "{si sO* sO* so}", "version", IBL_SET_VERSION, "defaults",
            json_object_get(g.root.value, "defaults"), "global",
            json_object_get(g.root.value, "global"), "probes", probes);
        char *text = ibl_need(ibl_json_text(set));
        if (opts->output)
            ok = ibl_console_differ(console, opts->input[0], opts->output,
                                    "file") &&
                 !ibl_outputs_create(ctx, opts->sync, &outputs) &&
                 !ibl_outputs_add(outputs, opts->output, text, strlen(text)) &&
                 !ibl_outputs_commit(outputs);
        else
            fputs(text, stdout);
        if (ok)
            ibl_console_info(console,
                             "placed %d probes, left out %d solid cells",
                             placed, cells - placed);
        ibl_outputs_free(outputs);
        free(text);
        json_decref(set);
    }
    json_decref(file.root);
    free(g.solid);
    return ok;
}
