/* SPDX-License-Identifier: MIT */
/*
 * The search. The error of a chain with the best table that it could have is
 * known at once; that of a table's size, format, irradiance and the BRDF table
 * is what they add to a usual chain's. So the cheapest set is found by these
 * sums. Then its lobe table is made and the whole set is judged; what it has
 * more than the sum says is remembered for that chain, and the search goes on
 * until a set has the error that is asked. At last its parts are made coarser
 * one at a time, while the judged error allows: the sums overstate that of some
 * sets.
 */
#include "cli/choose.h"

#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "cli/choose_set.h"

enum {
    ROUNDS = 48 /* sets whose lobe table is made */
};

/* How near to the least error a set must be if that asked cannot be had. */
static const double near = 1.2;

/* What a chain may have of the squared error that others make one expect. */
static const double far = 0.8;

/* ---- by the sums ----------------------------------------------------------
 */

static double error_by_sums(const ibl_search *s, const ibl_pick *p, int part)
{
    return s->part[part].error[p->at[part]];
}

static void add_errors(const ibl_search *s, ibl_pick *p)
{
    p->sum = 0;
    for (int i = IBL_SET_PIXEL; i < IBL_SET_PARTS; i++)
        p->sum += error_by_sums(s, p, i);
}

static int by_bytes(const void *a, const void *b)
{
    const ibl_pick *x = a, *y = b;

    if (x->at[IBL_SET_PIXEL] != y->at[IBL_SET_PIXEL])
        return x->at[IBL_SET_PIXEL] < y->at[IBL_SET_PIXEL] ? -1 : 1;
    if (x->bytes != y->bytes)
        return x->bytes < y->bytes ? -1 : 1;
    return x->sum < y->sum ? -1 : x->sum > y->sum;
}

/* Lists what may be had besides a chain that no other of the same format is
 * better than, in bytes and error. */
static void list_small(ibl_search *s)
{
    ibl_pick p = {.ladder = 0}, *all = s->small;
    int count = 0;

    do {
        add_errors(s, &p);
        if (p.sum - error_by_sums(s, &p, IBL_SET_LOBES) > s->most_parts ||
            count == IBL_SET_SMALL)
            continue;
        p.bytes = ibl_set_bytes(s, &p);
        all[count++] = p;
    } while (ibl_set_next(s, IBL_SET_PIXEL, IBL_SET_PARTS, &p));
    qsort(all, (size_t)count, sizeof *all, by_bytes);
    s->small_count = 0;
    for (int i = 0; i < count; i++) {
        const ibl_pick *last = &all[s->small_count - 1];
        if (!s->small_count ||
            all[i].at[IBL_SET_PIXEL] != last->at[IBL_SET_PIXEL] ||
            all[i].sum < last->sum)
            all[s->small_count++] = all[i];
    }
}

/* A chain that was not judged is taken to be off from its least error as the
 * best of all: none is passed over that may do. */
static double own_error(const ibl_search *s, const ibl_chain *c, int table)
{
    const double finest = c->own[s->part[IBL_SET_LOBES].count - 1];

    return c->own[table] > 0 ? c->own[table]
           : finest > 0      ? finest
                             : c->least * (s->ratio > 0 ? s->ratio : 1);
}

static ibl_pick with_chain(const ibl_pick *of, const ibl_pick *small)
{
    ibl_pick p = *small;

    p.at[IBL_SET_SIZE] = of->at[IBL_SET_SIZE];
    p.at[IBL_SET_LEVELS] = of->at[IBL_SET_LEVELS];
    return p;
}

/* Keeps the set of fewest bytes with a chain and an error of at most `most`. */
static void try_small(ibl_search *s, double most, const ibl_pick *of,
                      ibl_pick *best)
{
    const ibl_chain *c = ibl_chain_of(s, of);

    for (int i = 0; i < s->small_count; i++) {
        ibl_pick p = with_chain(of, &s->small[i]);
        p.error = own_error(s, c, p.at[IBL_SET_LOBES]) + p.sum;
        if (p.error > most)
            continue;
        p.bytes = ibl_set_bytes(s, &p);
        if (p.bytes <= s->most_bytes &&
            (p.bytes < best->bytes ||
             (p.bytes == best->bytes && p.error < best->error)))
            *best = p;
    }
}

/* The set of fewest bytes that promises a squared error of at most `most`.
 * False: there is none. */
static bool find(ibl_search *s, double most, ibl_pick *best)
{
    const ibl_values *pixel = &s->part[IBL_SET_PIXEL];
    ibl_pick p = {.ladder = 0};

    *best = (ibl_pick){.bytes = SIZE_MAX};
    do {
        const size_t least =
            ibl_chain_bytes(ibl_set_value(s, &p, IBL_SET_SIZE), 1,
                            (ibl_pixel)pixel->value[pixel->count - 1]);
        if (least <= s->most_bytes && least < best->bytes &&
            ibl_chain_make(s, &p))
            try_small(s, most, &p, best);
    } while (ibl_chain_next(s, &p));
    return best->bytes < SIZE_MAX;
}

/* The set of a chain whose parts add the least, of no more bytes than there may
 * be. False: there is none. */
static bool finest_of(ibl_search *s, const ibl_pick *of, ibl_pick *finest)
{
    *finest = (ibl_pick){.sum = HUGE_VAL};
    if (!ibl_chain_make(s, of))
        return false;
    for (int i = 0; i < s->small_count; i++) {
        const ibl_pick p = with_chain(of, &s->small[i]);
        if (p.sum < finest->sum && ibl_set_bytes(s, &p) <= s->most_bytes)
            *finest = p;
    }
    return finest->sum < HUGE_VAL;
}

/* ---- by judging -----------------------------------------------------------
 */

/* Sets *sum to what format, irradiance and BRDF table add to a set that was
 * judged, and takes that for what they add to others. */
static bool sum_of_added(ibl_search *s, const ibl_pick *p, double *sum)
{
    bool ok = true;

    *sum = 0;
    for (int i = 0; i < IBL_SET_PARTS && ok; i++)
        if (ibl_set_is_small(s, i) && i != IBL_SET_LOBES) {
            double *added = &s->part[i].error[p->at[i]];
            ok = ibl_set_added(s, p, i, added);
            *sum += *added;
        }
    return ok;
}

/* Whether a set that was judged has an error of at most `most`, and its parts
 * add no more than they may. */
static bool is_enough(ibl_search *s, double most, const ibl_pick *p,
                      bool *enough)
{
    double sum = 0;
    const bool ok = p->error > most || s->most_parts == HUGE_VAL ||
                    sum_of_added(s, p, &sum);

    *enough = p->error <= most && sum <= s->most_parts;
    return ok;
}

/* Judges a pick, and keeps what its chain has of the error. The finest table
 * comes first: *p then has that. */
static bool judge_pick(ibl_search *s, ibl_pick *p)
{
    const int finest = s->part[IBL_SET_LOBES].count - 1;
    ibl_chain *c = ibl_chain_of(s, p);

    if (!(c->own[finest] > 0))
        p->at[IBL_SET_LOBES] = finest;
    add_errors(s, p);
    if (!ibl_set_judge(s, p))
        return false;
    c->own[p->at[IBL_SET_LOBES]] = fmax(p->error - p->sum, 1e-12);
    const double ratio = c->own[finest] / c->least;
    s->ratio = s->ratio > 0 ? fmin(s->ratio, ratio) : ratio;
    return true;
}

/* Judges of each number of levels the chain of least error with its best table,
 * with the finest parts, unless it is far from the best so far. *best is that
 * of least error; HUGE_VAL: there is none. False: after a message. */
static bool judge_finest(ibl_search *s, ibl_pick *best)
{
    *best = (ibl_pick){.error = HUGE_VAL};
    for (int k = s->part[IBL_SET_LEVELS].count - 1; k >= 0; k--) {
        ibl_pick of = {.at = {[IBL_SET_LEVELS] = k}};
        ibl_pick p, finest = {.ladder = 0};
        double least = HUGE_VAL;
        for (of.at[IBL_SET_SIZE] = 0;
             of.at[IBL_SET_SIZE] < s->part[IBL_SET_SIZE].count;
             of.at[IBL_SET_SIZE]++)
            if (finest_of(s, &of, &p) && ibl_chain_of(s, &p)->least < least) {
                least = ibl_chain_of(s, &p)->least;
                finest = p;
            }
        if (least == HUGE_VAL || far * least * s->ratio > best->error)
            continue;
        if (!judge_pick(s, &finest))
            return false;
        if (finest.error < best->error)
            *best = finest;
    }
    return true;
}

/* Judges the sets that promise the fewest bytes with a squared error of at most
 * `most`, until no other promises fewer. *best is the one that holds or, before
 * there is any, the one of least error. False: after a message. */
static bool judge_sets(ibl_search *s, double most, ibl_pick *best)
{
    bool holds = best->error <= most, now;
    ibl_pick p;

    for (int i = 0; i < ROUNDS && find(s, most, &p); i++) {
        if (holds && p.bytes >= best->bytes)
            return true;
        if (!judge_pick(s, &p) || !is_enough(s, most, &p, &now))
            return false;
        if (now > holds || (now == holds && (now ? p.bytes < best->bytes
                                                 : p.error < best->error)))
            *best = p;
        holds |= now;
        if (p.error <= most && !now)
            list_small(s);
    }
    return true;
}

/* Takes the ladder of a named mapping where the set as a whole has less error
 * with it: the fit does not know the lobe table's size. */
static bool try_mappings(ibl_search *s, ibl_pick *best)
{
    ibl_pick p = *best;

    if (!s->fits || ibl_chain_of(s, best)->layout.levels < 2)
        return true;
    for (p.ladder = 1; p.ladder < 3; p.ladder++) {
        if (!ibl_set_judge(s, &p))
            return false;
        if (p.error < best->error)
            *best = p;
    }
    return true;
}

/* Makes one of the parts of a set coarser by steps of its values. False: there
 * is no such set, or it has no fewer bytes. */
static bool coarsen(ibl_search *s, int part, int steps, ibl_pick *p)
{
    const size_t before = p->bytes;
    int *at = &p->at[part];

    *at += part == IBL_SET_PIXEL ? steps : -steps;
    if (*at < 0 || *at >= s->part[part].count || !ibl_chain_make(s, p))
        return false;
    if (part == IBL_SET_SIZE || part == IBL_SET_LEVELS)
        p->ladder = 0;
    p->bytes = ibl_set_bytes(s, p);
    return p->bytes < before;
}

/* Bytes saved for the error that it costs. */
static double saving(const ibl_pick *from, const ibl_pick *to)
{
    return (double)(from->bytes - to->bytes) /
           fmax(to->error - from->error, 1e-12);
}

/* Makes a part of a set coarser by at most *steps, which are halved until it
 * holds: *p; 0: it does not. */
static bool try_part(ibl_search *s, double most, const ibl_pick *from, int part,
                     int *steps, ibl_pick *p)
{
    for (bool enough = false; *steps; *steps /= 2) {
        *p = *from;
        if (!coarsen(s, part, *steps, p))
            continue;
        if (!ibl_set_judge(s, p) || !is_enough(s, most, p, &enough))
            return false;
        if (enough)
            break;
    }
    return true;
}

/* Makes the parts of a set coarser while it holds, each time that part which
 * saves most bytes for the error. Its next steps are twice as many. */
static bool shrink(ibl_search *s, double most, ibl_pick *best)
{
    int steps[IBL_SET_PARTS] = {1, 1, 1, 1, 1, 1};

    for (;;) {
        ibl_pick next = *best, p;
        int which = -1;
        for (int part = 0; part < IBL_SET_PARTS; part++) {
            if (!try_part(s, most, best, part, &steps[part], &p))
                return false;
            if (steps[part] &&
                (which < 0 || saving(best, &p) > saving(best, &next))) {
                next = p;
                which = part;
            }
        }
        if (which < 0)
            return true;
        *best = next;
        steps[which] *= 2;
    }
}

static bool finish(ibl_search *s, double most, ibl_pick *best)
{
    return try_mappings(s, best) && shrink(s, most, best);
}

/* Starts from small chains that hold with the finest parts, too, and not only
 * from the set of least error. */
static bool try_chains(ibl_search *s, double most, ibl_pick *best)
{
    ibl_pick of = {.ladder = 0};

    do {
        const int edge = ibl_set_value(s, &of, IBL_SET_SIZE);
        ibl_pick p;
        if (!ibl_is_power(edge) ||
            ibl_chain_bytes(edge, 1, IBL_PIXEL_RGB9E5) >= best->bytes ||
            !finest_of(s, &of, &p))
            continue;
        if (!ibl_set_judge(s, &p) || (p.error <= most && !finish(s, most, &p)))
            return false;
        if (p.error <= most && p.bytes < best->bytes)
            *best = p;
    } while (ibl_chain_next(s, &of));
    return true;
}

/* Finds the set of fewest bytes with the error that is asked or, if that cannot
 * be had, near to the least. */
static bool search_all(ibl_search *s, ibl_choice *choice, ibl_pick *best)
{
    double most = choice->asked * choice->asked;
    ibl_pick least;

    *best = (ibl_pick){.error = HUGE_VAL};
    if (!judge_sets(s, most, best))
        return false;
    if (best->error > most) {
        if (!judge_finest(s, &least))
            return false;
        if (least.error == HUGE_VAL)
            return ibl_console_fail(
                s->from->console,
                "--%s: leaves no levels of %dx%d or more "
                "to choose from: add --levels N, or take "
                "a larger one",
                ibl_is_given(&s->o->given, "roughness-range")
                    ? "roughness-range"
                    : "size",
                IBL_SET_LEAST_EDGE, IBL_SET_LEAST_EDGE);
        if (least.error < best->error)
            *best = least;
        choice->least = sqrt(best->error);
        if (best->error <= most &&
            !(finish(s, most, best) && try_chains(s, most, best)))
            return false;
    }
    choice->reached = best->error <= most;
    if (!choice->reached) {
        if (!sum_of_added(s, &least, &s->most_parts))
            return false;
        s->most_parts = fmax(s->most_parts, most);
        list_small(s);
        most = near * near * best->error;
        if (!judge_sets(s, most, best))
            return false;
    }
    return finish(s, most, best);
}

/* ---- what was chosen ------------------------------------------------------
 */

static bool set_options(ibl_search *s, const ibl_pick *p)
{
    ibl_opts *o = s->o;
    ibl_specular_options *to = &o->bake.specular_options;
    const int irradiance = ibl_set_value(s, p, IBL_SET_IRRADIANCE);
    ibl_specular_layout layout;

    if (!ibl_set_layout(s, p, &layout))
        return false;
    if (ibl_opts_want(o, IBL_OUTPUT_SPECULAR)) {
        to->size = ibl_set_value(s, p, IBL_SET_SIZE);
        to->levels = ibl_set_value(s, p, IBL_SET_LEVELS);
    }
    if (ibl_opts_want(o, IBL_OUTPUT_SPECULAR) && s->fits) {
        memcpy(o->roughness, layout.roughness, sizeof o->roughness);
        to->roughness = o->roughness;
    }
    if (!o->engine)
        o->texels.pixel = (ibl_pixel)ibl_set_value(s, p, IBL_SET_PIXEL);
    if (irradiance > 0)
        o->bake.irradiance_options.size = irradiance;
    else
        o->only &= ~(1u << IBL_OUTPUT_IRRADIANCE);
    o->lut.size = ibl_set_value(s, p, IBL_SET_LUT);
    o->lobe_table_size = ibl_set_value(s, p, IBL_SET_LOBES);
    ibl_opts_select(o);
    return true;
}

static void tell_chain(ibl_search *s, const ibl_pick *p, ibl_choice *choice)
{
    ibl_specular_layout l;
    char text[IBL_CHOICE_BYTES];

    if (!ibl_set_layout(s, p, &l))
        return;
    int used = snprintf(text, sizeof text, "%d level%s:", l.levels,
                        l.levels > 1 ? "s" : "");
    for (int i = 0; i < l.levels; i++)
        used += snprintf(text + used, sizeof text - (size_t)used, " %.3g",
                         l.roughness[i]);
    ibl_choice_chose(choice, "roughness", text, "%s",
                     !s->fits    ? "as asked"
                     : p->ladder ? "exacter than the fitted ones"
                                 : "fitted to map and materials");
    snprintf(text, sizeof text, "%d", l.size);
    ibl_choice_chose(choice, "size", text, "%s",
                     s->part[IBL_SET_SIZE].count > 1
                         ? "the smallest exact enough"
                         : "as asked");
}

static bool tell_added(ibl_search *s, const ibl_pick *p, int part,
                       const char *name, ibl_choice *choice)
{
    char text[16] = "harmonics";
    double added;

    if (!ibl_set_added(s, p, part, &added))
        return false;
    if (ibl_set_value(s, p, part))
        snprintf(text, sizeof text, "%d", ibl_set_value(s, p, part));
    ibl_choice_chose(choice, name, text, "adds %.2g %% of error",
                     100 * sqrt(added));
    return true;
}

static bool tell(ibl_search *s, const ibl_pick *p, ibl_choice *choice)
{
    static const char *const of_f0[] = {"", ", for metals only",
                                        ", for dielectrics only"};
    const ibl_opts *o = s->o;
    char text[16];

    if (ibl_opts_want(o, IBL_OUTPUT_SPECULAR))
        tell_chain(s, p, choice);
    ibl_choice_chose(choice, "texels",
                     o->engine ? ibl_engine_pixel(o->engine)
                               : ibl_pixel_name(o->texels.pixel),
                     "%s",
                     s->part[IBL_SET_PIXEL].count > 1
                         ? "the smallest exact enough"
                         : "as asked");
    bool ok = tell_added(s, p, IBL_SET_IRRADIANCE, "irradiance", choice) &&
              (!ibl_opts_want(o, IBL_OUTPUT_LUT) ||
               tell_added(s, p, IBL_SET_LUT, "BRDF table", choice));
    snprintf(text, sizeof text, "%d", o->lobe_table_size);
    if (s->table)
        ibl_choice_chose(choice, "lobe table", text, "fitted to the levels%s",
                         of_f0[o->lobe_f0]);
    return ok;
}

/* The least error of chains of a size. */
static double least_of_size(ibl_search *s, int size)
{
    double least = HUGE_VAL;
    ibl_pick p = {.at = {[IBL_SET_SIZE] = size}};

    for (; p.at[IBL_SET_LEVELS] < s->part[IBL_SET_LEVELS].count;
         p.at[IBL_SET_LEVELS]++)
        if (ibl_chain_make(s, &p))
            least = fmin(least, ibl_chain_of(s, &p)->least);
    return least;
}

/* Why the error that was asked is not reached: larger faces would, or none. */
static void tell_limit(ibl_search *s, ibl_choice *choice)
{
    const ibl_values *size = &s->part[IBL_SET_SIZE];
    const int last = size->count - 1;
    int half = last;
    char text[IBL_CHOICE_BYTES];

    while (half > 0 && 2 * size->value[half] > size->value[last])
        half--;
    snprintf(text, sizeof text,
             "%.3g %% cannot be reached, the least is %.3g %%",
             100 * choice->asked, 100 * choice->least);
    const char *why =
        least_of_size(s, half) <= 1.2 * least_of_size(s, last)
            ? "with any size: a lookup sees another lobe than the surface "
              "reflects; under suns --lights helps"
        : s->most_bytes < SIZE_MAX
            ? "in the default's bytes: --rendered-error E may take more"
            : "without larger faces";
    ibl_choice_chose(choice, "limit", text, "%s", why);
}

/* ---- the call -------------------------------------------------------------
 */

/* The figures of the options as they are, whose parts are the only values so
 * far. */
static bool judge_usual(ibl_search *s, ibl_choice *choice)
{
    ibl_pick p = {.ladder = 0};
    int value[IBL_SET_PARTS];

    ibl_set_given(s->o, value);
    for (int i = 0; i < IBL_SET_PARTS; i++)
        s->part[i] = (ibl_values){.count = 1, .value = {value[i]}};
    if (!ibl_chain_make(s, &p) || !ibl_set_judge(s, &p))
        return false;
    choice->usual_error = sqrt(p.error);
    choice->usual_bytes = p.bytes;
    memset(s->chain, 0, sizeof s->chain);
    ibl_lut_free(&s->luts[0]);
    return true;
}

/* The options of lobe tables, but for their size and chain. */
static void set_table(ibl_search *s)
{
    ibl_lobe_table_options *of = &s->made;
    *of = ibl_lobe_table_options_default();
    of->f0 = s->o->lobe_f0;
    if (s->o->lobe_table == IBL_LOBES_FITTED) {
        of->power = s->power;
        of->power_degree = s->degree;
    }
    ibl_lobe_table_free(&s->lobes);
}

/* The layers that no material looks up are left out. */
static ibl_f0 f0_of(const ibl_materials *m)
{
    bool has[2] = {false, false};

    for (int i = 0; i <= IBL_MATERIAL_STEPS; i++)
        for (int f = 0; f < 2; f++)
            has[f] |= m->weight[i][f] > 0;
    return has[0] && has[1] ? IBL_F0_BOTH
           : has[0]         ? IBL_F0_METALS
                            : IBL_F0_DIELECTRICS;
}

/* Lists what may be chosen of options o, which lives as long as the search, and
 * sets the default's figures. search_close is needed also after a failure. */
static bool search_open(ibl_search *s, ibl_bake_source *from,
                        const ibl_materials *materials, ibl_opts *o,
                        ibl_choice *choice)
{
    double square;

    s->from = from;
    s->o = o;
    s->most_parts = HUGE_VAL;
    s->table = ibl_opts_want(o, IBL_OUTPUT_SPECULAR) &&
               ibl_opts_want(o, IBL_OUTPUT_LOBES);
    if (!ibl_bake_source_power(from, s->power, &s->degree, &square) ||
        ibl_expectation_create(from->ctx, materials, s->power, s->degree,
                               from->width / 2, square, &s->e))
        return false;
    set_table(s);
    if (!judge_usual(s, choice))
        return false;
    s->most_bytes = ibl_is_given(&o->given, "rendered-error")
                        ? SIZE_MAX
                        : choice->usual_bytes;
    s->fits = s->table && !ibl_is_given(&o->given, "mapping") &&
              !ibl_is_given(&o->given, "roughness-range") && !o->of &&
              !o->engine;
    if (s->table && !ibl_is_given(&o->given, "lobe-table"))
        o->lobe_table = IBL_LOBES_FITTED;
    o->lobe_f0 = f0_of(materials);
    set_table(s);
    if (!ibl_search_list(s, materials))
        return false;
    list_small(s);
    return true;
}

static void search_close(ibl_search *s)
{
    for (int i = 0; i < IBL_SET_VALUES; i++)
        ibl_lut_free(&s->luts[i]);
    ibl_lobe_table_free(&s->lobes);
    ibl_expectation_free(s->e);
}

bool ibl_choose(ibl_bake_source *from, const ibl_materials *materials,
                ibl_opts *o, ibl_choice *choice)
{
    ibl_search *s = calloc(1, sizeof *s);
    ibl_pick best;

    choice->asked = o->rendered_error;
    if (!s)
        return ibl_console_fail(from->console, "no memory for the search");
    ibl_console_progress(from->console, "choice", 0);
    const bool ok = search_open(s, from, materials, o, choice) &&
                    search_all(s, choice, &best) && set_options(s, &best) &&
                    tell(s, &best, choice);
    if (ok) {
        choice->bytes = best.bytes;
        choice->error = sqrt(best.error);
    }
    if (ok && !choice->reached)
        tell_limit(s, choice);
    search_close(s);
    free(s);
    return ok;
}
