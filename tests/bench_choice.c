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
    FAILED = 4096
};

typedef struct force {
    ibl_search *s; /* with finer values */
    ibl_pick failed[FAILED];
    int failed_count;
    double most; /* squared error */
    ibl_pick best;
    long judged, chains;
} force;

/* The order in which a set's parts are tried. */
static const int inner[] = {IBL_SET_LOBES, IBL_SET_PIXEL, IBL_SET_IRRADIANCE,
                            IBL_SET_LUT};

/* Edges from first to last, steps of them in each octave. */
static void fill(ibl_values *v, int first, int last, int steps)
{
    v->count = first == 0; /* harmonics stay */
    for (int octave = 1; octave <= last; octave *= 2)
        for (int i = 0; i < steps; i++) {
            const int edge = octave + octave * i / steps;
            if (edge >= (first ? first : 2) && edge <= last &&
                (!v->count || edge > v->value[v->count - 1]))
                v->value[v->count++] = edge;
        }
}

/* As the search's, but finer where it has a choice. */
static void fill_values(ibl_search *s)
{
    ibl_values *const size = &s->part[IBL_SET_SIZE],
                      *irradiance = &s->part[IBL_SET_IRRADIANCE];

    if (size->count > 1)
        fill(size, 1, size->value[size->count - 1], 8);
    if (irradiance->count > 1)
        fill(irradiance, irradiance->value[0] ? 2 : 0, 32, 4);
    if (s->part[IBL_SET_LUT].count > 1)
        fill(&s->part[IBL_SET_LUT], 2, 256, 4);
    if (s->part[IBL_SET_LOBES].count > 1)
        fill(&s->part[IBL_SET_LOBES], 4, 64, 4);
    memset(s->chain, 0, sizeof s->chain);
    for (int i = 0; i < IBL_SET_VALUES; i++)
        ibl_lut_free(&s->luts[i]);
}

/* The finest or the coarsest value of a part. */
static int end_of(const ibl_search *s, int part, bool finest)
{
    return finest == (part != IBL_SET_PIXEL) ? s->part[part].count - 1 : 0;
}

static ibl_pick all_of(const ibl_search *s, const ibl_pick *of, bool finest)
{
    ibl_pick p = *of;
    for (int i = 0; i < 4; i++)
        p.at[inner[i]] = end_of(s, inner[i], finest);
    return p;
}

/* Whether a set has the error that is wanted. */
static bool holds(force *f, ibl_pick *p)
{
    bool enough = false;

    f->judged++;
    return ibl_set_judge(f->s, p) && is_enough(f->s, f->most, p, &enough) &&
           enough;
}

/* Whether a set that is finer in all parts is known to fail. */
static bool must_fail(const force *f, const ibl_pick *p)
{
    for (int i = f->failed_count - 1; i >= 0; i--) {
        const int *at = f->failed[i].at;
        if (at[IBL_SET_LOBES] >= p->at[IBL_SET_LOBES] &&
            at[IBL_SET_PIXEL] <= p->at[IBL_SET_PIXEL] &&
            at[IBL_SET_IRRADIANCE] >= p->at[IBL_SET_IRRADIANCE] &&
            at[IBL_SET_LUT] >= p->at[IBL_SET_LUT])
            return true;
    }
    return false;
}

/* False: a set fails that would have the fewest bytes so far. */
static bool try_set(force *f, ibl_pick *p)
{
    if (ibl_set_bytes(f->s, p) >= f->best.bytes)
        return true;
    if (must_fail(f, p))
        return false;
    if (holds(f, p)) {
        f->best = *p;
        return true;
    }
    if (f->failed_count < FAILED)
        f->failed[f->failed_count++] = *p;
    return false;
}

/* All sets with a lobe table and a format, from the finest irradiance and the
 * coarsest BRDF table on. */
static void try_tables(force *f, const ibl_pick *coarsest, ibl_pick p)
{
    p.at[IBL_SET_LUT] = coarsest->at[IBL_SET_LUT];
    for (; p.at[IBL_SET_IRRADIANCE] >= coarsest->at[IBL_SET_IRRADIANCE];
         p.at[IBL_SET_IRRADIANCE]--)
        while (!try_set(f, &p))
            if (++p.at[IBL_SET_LUT] >= f->s->part[IBL_SET_LUT].count)
                return;
}

/* The coarsest value of a part that holds beside the finest others. */
static int last_that_holds(force *f, const ibl_pick *finest, int part)
{
    const int step = part == IBL_SET_PIXEL ? 1 : -1;
    ibl_pick p = *finest;

    while (p.at[part] != end_of(f->s, part, false)) {
        p.at[part] += step;
        if (!holds(f, &p))
            return p.at[part] - step;
    }
    return p.at[part];
}

/* All sets of a chain that could have fewer bytes. */
static void try_chain(force *f, const ibl_pick *of)
{
    const ibl_pick finest = all_of(f->s, of, true);
    ibl_pick coarsest = all_of(f->s, of, false), p = finest;

    f->failed_count = 0;
    if (ibl_set_bytes(f->s, &coarsest) >= f->best.bytes)
        return;
    f->chains++;
    if (!holds(f, &p))
        return;
    for (int i = 0; i < 4; i++)
        coarsest.at[inner[i]] = last_that_holds(f, &finest, inner[i]);
    for (p.at[IBL_SET_LOBES] = coarsest.at[IBL_SET_LOBES];
         p.at[IBL_SET_LOBES] <= finest.at[IBL_SET_LOBES]; p.at[IBL_SET_LOBES]++)
        for (p.at[IBL_SET_PIXEL] = coarsest.at[IBL_SET_PIXEL];
             p.at[IBL_SET_PIXEL] >= 0; p.at[IBL_SET_PIXEL]--)
            try_tables(f, &coarsest, p);
}

/* Fitted ladders, or those of the mappings. */
static void try_all(force *f)
{
    ibl_search *s = f->s;
    ibl_pick p = {.ladder = 0};

    do {
        const int size = ibl_set_value(s, &p, IBL_SET_SIZE),
                  n = ibl_set_value(s, &p, IBL_SET_LEVELS);
        ibl_chain *c = ibl_chain_of(s, &p);
        if ((n > 1 && size >> (n - 1) < IBL_SET_LEAST_EDGE) ||
            n > ibl_most_levels(size))
            continue;
        c->layout = (ibl_specular_layout){.size = size, .levels = n ? n : 1};
        const ibl_pick least = all_of(s, &p, false);
        if (ibl_set_bytes(s, &least) >= f->best.bytes ||
            !ibl_chain_measure(s, &p, c))
            continue;
        for (p.ladder = 0; p.ladder < (s->fits ? 3 : 1); p.ladder++)
            try_chain(f, &p);
        p.ladder = 0;
    } while (ibl_chain_next(s, &p));
}

/* The set of fewest bytes so far. */
static void tell_best(const force *f)
{
    const ibl_pick *p = &f->best;
    ibl_specular_layout l;

    if (!ibl_set_layout(f->s, p, &l))
        return;
    printf("fewest: size %d, roughness", l.size);
    for (int i = 0; i < l.levels; i++)
        printf(" %.3g", l.roughness[i]);
    printf(", %s, irradiance %d, BRDF table %d, lobe table %d\n",
           ibl_pixel_name((ibl_pixel)ibl_set_value(f->s, p, IBL_SET_PIXEL)),
           ibl_set_value(f->s, p, IBL_SET_IRRADIANCE),
           ibl_set_value(f->s, p, IBL_SET_LUT),
           ibl_set_value(f->s, p, IBL_SET_LOBES));
}

/* Prints the fewest bytes that hold what the choice holds. */
static void report(const force *f, const ibl_choice *c)
{
    printf("%.3g %%: chosen %zu bytes, %.4g %%; fewest %zu bytes, %.4g %%; "
           "ratio %.2f; %ld chains, %ld sets\n",
           100 * sqrt(f->most), c->bytes, 100 * c->error, f->best.bytes,
           100 * sqrt(f->best.error), (double)c->bytes / (double)f->best.bytes,
           f->chains, f->judged);
    if (f->best.bytes < c->bytes)
        tell_best(f);
}

bool ibl_choose(ibl_bake_source *from, const ibl_materials *materials,
                ibl_opts *o, ibl_choice *choice)
{
    static ibl_search s;
    static force f;
    ibl_opts given = *o;
    ibl_choice scratch = {.asked = o->rendered_error};

    if (!choose_by_search(from, materials, o, choice) ||
        !search_open(&s, from, materials, &given, &scratch))
        return false;
    fill_values(&s);
    f = (force){.s = &s,
                .most = choice->asked * choice->asked,
                .best = {.bytes = s.most_bytes}};
    if (!choice->reached) {
        try_all(&f);
        if (f.best.bytes < s.most_bytes) {
            printf("%g can be had, in %zu bytes: ", choice->asked,
                   f.best.bytes);
            tell_best(&f);
        }
        s.most_parts = f.most;
        f.most = near * near * choice->least * choice->least;
    }
    f.best = (ibl_pick){.bytes = choice->bytes,
                        .error = choice->error * choice->error};
    try_all(&f);
    report(&f, choice);
    search_close(&s);
    return true;
}
