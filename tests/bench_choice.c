/* SPDX-License-Identifier: MIT */
/*
 * The fewest bytes that --rendered-error and --scene could choose, found by
 * trying all sets, beside those that they do choose.
 *   bench_choice OPTION... MAP
 *                   those of iblbake, with --dry-run
 * A set is judged as the choice judges it. Tried are sizes in steps of an
 * eighth of an octave, all numbers of levels, fitted ladders and those of the
 * named mappings, all pixel formats, and edges of the tables and of irradiance
 * in steps of a quarter of an octave; of several levels the last has 4x4 texels
 * or more, below which iblbake warns. It is taken for granted that a set in
 * which one part is finer is not worse: what fails with the finest parts is not
 * tried with coarser ones, and coarser irradiance needs a BRDF table that is at
 * least as fine. What has no fewer bytes than the best is not judged.
 */
#include <stdio.h>

#include "cli/choose.h"
bool choose_by_search(ibl_bake_source *from, const ibl_materials *materials,
                      ibl_opts *o, ibl_choice *choice);
#define ibl_choose choose_by_search
#include "cli/choose.c"
#undef ibl_choose
#include "cli/main.c"

enum {
    TRIED = 80,
    PARTS = 4,
    LADDERS = 3,
    FAILED = 4096
};

/* Values of a part, of fewest bytes first. */
typedef struct range {
    int count, value[TRIED];
} range;

/* Parts of a set, as indices of their values. */
enum {
    LOBES,
    PIXEL,
    IRRADIANCE,
    LUT
};

typedef struct force {
    search *s;
    range size, levels, part[PARTS];
    ibl_lobe_table lobes[TRIED]; /* of the chain */
    double alone[TRIED];         /* its error with each; 0: not yet known */
    ibl_lut lut[TRIED];
    ibl_specular_layout layout;
    int failed[FAILED][PARTS], failed_count;
    double most;       /* error */
    double parts_most; /* that the others may add; 0: any */
    double now;        /* error of the set that was judged last */
    size_t bytes;      /* the fewest so far */
    double error;
    int best[PARTS];
    ibl_specular_layout best_layout;
    long judged, chains;
} force;

/* Edges from first to last, steps of them in each octave. */
static void fill(range *r, int first, int last, int steps)
{
    for (int octave = 1; octave <= last; octave *= 2)
        for (int i = 0; i < steps; i++) {
            const int edge = octave + octave * i / steps;
            if (edge >= first && edge <= last &&
                (!r->count || edge > r->value[r->count - 1]))
                r->value[r->count++] = edge;
        }
}

static void take(range *r, const values *v, bool reversed)
{
    r->count = v->count;
    for (int i = 0; i < v->count; i++)
        r->value[i] = v->value[reversed ? v->count - 1 - i : i];
}

/* As the search's, but finer where it has a choice. */
static void fill_ranges(force *f)
{
    const search *s = f->s;

    take(&f->size, &s->size, false);
    take(&f->levels, &s->levels, false);
    take(&f->part[PIXEL], &s->pixel, true);
    take(&f->part[IRRADIANCE], &s->irradiance, false);
    take(&f->part[LUT], &s->lut, false);
    take(&f->part[LOBES], &s->lobes, true);
    if (s->size.count > 1) {
        f->size.count = 0;
        fill(&f->size, 1, s->size.value[s->size.count - 1], 8);
    }
    if (s->irradiance.count > 1) {
        f->part[IRRADIANCE].count = s->irradiance.value[0] == 0;
        fill(&f->part[IRRADIANCE], 2, 32, 4);
    }
    if (s->lut.count > 1) {
        f->part[LUT].count = 0;
        fill(&f->part[LUT], 2, 256, 4);
    }
    if (s->lobes.count > 1) {
        f->part[LOBES].count = 0;
        fill(&f->part[LOBES], 4, 64, 4);
    }
}

static size_t bytes_of_parts(const force *f, const int at[PARTS])
{
    const ibl_opts *o = f->s->o;
    const ibl_pixel pixel = (ibl_pixel)f->part[PIXEL].value[at[PIXEL]];
    size_t bytes =
        small_bytes(o, pixel, f->part[IRRADIANCE].value[at[IRRADIANCE]],
                    f->part[LUT].value[at[LUT]]);

    if (wants(o, IBL_OUTPUT_SPECULAR))
        bytes += chain_bytes(f->layout.size, f->layout.levels, pixel);
    if (f->s->table)
        bytes += lobes_bytes(o, f->part[LOBES].value[at[LOBES]]);
    return bytes;
}

static bool table_of(force *f, int i)
{
    const search *s = f->s;
    ibl_lobe_table_options of = ibl_lobe_table_options_default();

    of.size = f->part[LOBES].value[i];
    of.layout = f->layout;
    of.f0 = s->o->lobe_f0;
    if (s->o->lobe_table == IBL_LOBES_FITTED) {
        of.power = s->power;
        of.power_degree = s->degree;
    }
    return f->lobes[i].data ||
           !ibl_bake_lobe_table(s->from->ctx, &of, &f->lobes[i]);
}

/* The error of a set; exact: but for its levels and lobe table. */
static double error_of(force *f, const int at[PARTS], bool exact)
{
    const search *s = f->s;
    ibl_expected_set set = {
        .layout = f->layout,
        .lookup = s->table ? IBL_LOOKUP_TABLE : IBL_LOOKUP_SPLIT,
        .irradiance = exact ? -1 : f->part[IRRADIANCE].value[at[IRRADIANCE]]};
    double nrmse = HUGE_VAL;

    f->judged++;
    if (!exact || f->part[PIXEL].count == 1)
        format_errors((ibl_pixel)f->part[PIXEL].value[at[PIXEL]], &set);
    if (s->table && table_of(f, at[LOBES]))
        set.lobes = &f->lobes[at[LOBES]];
    if (!exact && f->lut[at[LUT]].data)
        set.lut = &f->lut[at[LUT]];
    ibl_expectation_of(s->e, &set, &nrmse);
    return nrmse;
}

/* Whether a set has the error that is wanted and, if that asked cannot be had,
 * whether the others add no more than it to the levels. */
static bool holds(force *f, const int at[PARTS])
{
    double *alone = &f->alone[at[LOBES]];

    f->now = error_of(f, at, false);
    if (f->now > f->most || f->parts_most <= 0)
        return f->now <= f->most;
    if (*alone <= 0)
        *alone = error_of(f, at, true);
    return f->now * f->now - *alone * *alone <= f->parts_most * f->parts_most;
}

/* Whether a set that is finer in all parts is known to fail. */
static bool must_fail(const force *f, const int at[PARTS])
{
    for (int i = f->failed_count - 1; i >= 0; i--) {
        bool finer = true;
        for (int k = 0; k < PARTS; k++)
            finer &= f->failed[i][k] >= at[k];
        if (finer)
            return true;
    }
    return false;
}

/* False: a set fails that would have the fewest bytes so far. */
static bool try_set(force *f, const int at[PARTS])
{
    const size_t bytes = bytes_of_parts(f, at);

    if (bytes >= f->bytes)
        return true;
    if (must_fail(f, at))
        return false;
    if (holds(f, at)) {
        f->bytes = bytes;
        f->error = f->now;
        memcpy(f->best, at, sizeof f->best);
        f->best_layout = f->layout;
        return true;
    }
    if (f->failed_count < FAILED)
        memcpy(f->failed[f->failed_count++], at, sizeof f->best);
    return false;
}

/* All sets with a lobe table and a format, from the finest irradiance and the
 * coarsest BRDF table on. */
static void try_small(force *f, const int coarsest[PARTS],
                      const int finest[PARTS], int at[PARTS])
{
    at[LUT] = coarsest[LUT];
    for (int i = finest[IRRADIANCE]; i >= coarsest[IRRADIANCE]; i--) {
        at[IRRADIANCE] = i;
        while (!try_set(f, at))
            if (++at[LUT] > finest[LUT])
                return;
    }
}

/* The first value of a part that holds beside the finest others. */
static int first_that_holds(force *f, const int finest[PARTS], int part)
{
    int at[PARTS];

    memcpy(at, finest, sizeof at);
    for (at[part] = finest[part]; at[part] > 0; at[part]--) {
        at[part]--;
        const bool still = holds(f, at);
        at[part]++;
        if (!still)
            break;
    }
    return at[part];
}

/* All sets of a chain that could have fewer bytes. */
static void try_chain(force *f)
{
    int finest[PARTS], coarsest[PARTS] = {0}, at[PARTS];

    f->failed_count = 0;
    memset(f->alone, 0, sizeof f->alone);
    for (int k = 0; k < PARTS; k++)
        finest[k] = f->part[k].count - 1;
    if (bytes_of_parts(f, coarsest) >= f->bytes)
        return;
    f->chains++;
    if (holds(f, finest)) {
        for (int k = 0; k < PARTS; k++)
            coarsest[k] = first_that_holds(f, finest, k);
        for (at[LOBES] = coarsest[LOBES]; at[LOBES] <= finest[LOBES];
             at[LOBES]++)
            for (at[PIXEL] = coarsest[PIXEL]; at[PIXEL] <= finest[PIXEL];
                 at[PIXEL]++)
                try_small(f, coarsest, finest, at);
    }
    for (int i = 0; i < TRIED; i++)
        ibl_lobe_table_free(&f->lobes[i]);
}

/* The ladders of a chain: fitted ones, or those of the mappings. */
static bool make_ladder(force *f, int size, int levels, int which)
{
    search *s = f->s;
    ibl_specular_options o = s->o->bake.specular_options;
    double nrmse;

    if (which == 0 && s->fits)
        return !ibl_expectation_fit(s->e, size, levels, &f->layout, &nrmse);
    if (which > 0 && !s->fits)
        return false;
    o.size = size;
    o.levels = levels;
    if (which > 0)
        o.mapping = which == 1 ? IBL_ROUGHNESS_FILAMENT : IBL_ROUGHNESS_LINEAR;
    return !ibl_specular_layout_of(&o, &f->layout);
}

static void try_all(force *f)
{
    for (int i = 0; i < f->size.count; i++)
        for (int k = 0; k < f->levels.count; k++)
            for (int which = 0; which < LADDERS; which++) {
                const int size = f->size.value[i], n = f->levels.value[k];
                const size_t bytes = chain_bytes(
                    size, n > 1 ? n : 1, (ibl_pixel)f->part[PIXEL].value[0]);
                if ((n <= 1 || size >> (n - 1) >= LEAST_EDGE) &&
                    n <= ibl_most_levels(size) && bytes < f->bytes &&
                    make_ladder(f, size, n, which))
                    try_chain(f);
            }
}

/* The set of fewest bytes so far. */
static void tell_best(const force *f)
{
    printf("fewest: size %d, roughness", f->best_layout.size);
    for (int l = 0; l < f->best_layout.levels; l++)
        printf(" %.3g", f->best_layout.roughness[l]);
    printf(", %s, irradiance %d, BRDF table %d, lobe table %d\n",
           ibl_pixel_name((ibl_pixel)f->part[PIXEL].value[f->best[PIXEL]]),
           f->part[IRRADIANCE].value[f->best[IRRADIANCE]],
           f->part[LUT].value[f->best[LUT]],
           f->part[LOBES].value[f->best[LOBES]]);
}

/* Prints the fewest bytes that hold what the choice holds. */
static void report(const force *f, const ibl_choice *c)
{
    printf("%.3g %%: chosen %zu bytes, %.4g %%; fewest %zu bytes, %.4g %%; "
           "ratio %.2f; %ld chains, %ld sets\n",
           100 * f->most, c->bytes, 100 * c->error, f->bytes, 100 * f->error,
           (double)c->bytes / (double)f->bytes, f->chains, f->judged);
    if (f->bytes == c->bytes)
        return;
    tell_best(f);
}

bool ibl_choose(ibl_bake_source *from, const ibl_materials *materials,
                ibl_opts *o, ibl_choice *choice)
{
    static search s;
    static force f;
    ibl_opts given = *o;
    ibl_choice scratch = {.asked = o->rendered_error};

    if (!choose_by_search(from, materials, o, choice) ||
        !search_open(&s, from, materials, &given, &scratch))
        return false;
    f = (force){.s = &s, .bytes = choice->bytes, .error = choice->error};
    fill_ranges(&f);
    for (int i = 0; i < f.part[LUT].count && s.lut.count > 1; i++) {
        const ibl_lut_options of = {.size = f.part[LUT].value[i]};
        if (ibl_bake_lut(from->ctx, &of, &f.lut[i]))
            return false;
    }
    f.most = choice->asked;
    if (!choice->reached) {
        f.bytes = s.most_bytes;
        try_all(&f);
        if (f.bytes < s.most_bytes) {
            printf("%g can be had, in %zu bytes: ", f.most, f.bytes);
            tell_best(&f);
        }
        f.bytes = choice->bytes;
        f.most = near * choice->least;
        f.parts_most = choice->asked;
    }
    try_all(&f);
    report(&f, choice);
    for (int i = 0; i < TRIED; i++)
        ibl_lut_free(&f.lut[i]);
    search_close(&s);
    return true;
}
