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

enum {
    MOST = 80,       /* values of one output */
    MOST_LEVELS = 8, /* numbers of levels, from 1 */
    MOST_TABLES = 7, /* sizes of the lobe table */
    MOST_SMALL = 8192,
    MOST_EDGE = 2048,
    LEAST_EDGE = 4, /* of a level */
    ROUNDS = 48     /* sets whose lobe table is made */
};

/* How near to the least error a set must be if that asked cannot be had. */
static const double near = 1.2;

/* What a set is made of, in the order in which it is made coarser. */
enum {
    SIZE,
    LEVELS,
    PIXEL,
    LOBES, /* edge of the lobe table */
    IRRADIANCE,
    LUT,
    PARTS
};

/* ---- bytes --------------------------------------------------------------
 */

/*
 * Relative errors of texels, measured on the levels of five maps: of formats of
 * single texels wherever they are, of blocks of 4x4 mostly in proportion to the
 * differences within them.
 */
static void format_errors(ibl_pixel pixel, ibl_expected_set *set)
{
    const bool blocks = ibl_pixel_block(pixel) > 1;

    set->step = pixel == IBL_PIXEL_RGBA16F      ? 2e-4
                : pixel == IBL_PIXEL_RGB9E5     ? 1.1e-3
                : pixel == IBL_PIXEL_R11G11B10F ? 4.5e-3
                : blocks                        ? 3e-3
                                                : 0;
    set->slope = blocks ? 0.1 : 0;
}

/* The format of texels; an engine's own files have four bytes as well. */
static ibl_pixel pixel_of(const ibl_opts *o)
{
    return o->engine ? IBL_PIXEL_RGB9E5 : o->texels.pixel;
}

static size_t image_bytes(int edge, ibl_pixel pixel)
{
    const int block = ibl_pixel_block(pixel);
    const size_t blocks = (size_t)((edge + block - 1) / block);

    return blocks * blocks * ibl_pixel_bytes(pixel);
}

static bool wants(const ibl_opts *o, ibl_output_kind kind)
{
    return o->only & 1u << kind;
}

static size_t chain_bytes(int size, int levels, ibl_pixel pixel)
{
    size_t bytes = 0;

    for (int l = 0; l < levels; l++)
        bytes += IBL_FACES * image_bytes(ibl_cube_edge(size, l), pixel);
    return bytes;
}

/* Bytes of the outputs that are wanted, but the skybox, with these parts. */
static size_t bytes_with(const ibl_opts *o, const int value[PARTS])
{
    const ibl_pixel pixel = (ibl_pixel)value[PIXEL];
    const int layers = IBL_LOBE_LAYERS / (o->lobe_f0 == IBL_F0_BOTH ? 1 : 2);
    size_t bytes = 0;

    if (wants(o, IBL_OUTPUT_SPECULAR))
        bytes += chain_bytes(value[SIZE], value[LEVELS], pixel);
    if (wants(o, IBL_OUTPUT_LOBES))
        bytes += (size_t)(value[LOBES] * value[LOBES] * layers) *
                 ibl_pixel_bytes(IBL_PIXEL_RGBA16F);
    if (wants(o, IBL_OUTPUT_IRRADIANCE) && value[IRRADIANCE] > 0)
        bytes += chain_bytes(value[IRRADIANCE], 1, pixel);
    if (wants(o, IBL_OUTPUT_LUT))
        bytes += (size_t)(value[LUT] * value[LUT]) *
                 ibl_pixel_bytes(ibl_lut_pixel(pixel, o->lut.kind));
    return bytes;
}

/* The parts as the options have them; levels 0: the default number. */
static void given_values(const ibl_opts *o, int value[PARTS])
{
    value[SIZE] = o->bake.specular_options.size;
    value[LEVELS] = o->bake.specular_options.levels;
    value[PIXEL] = (int)pixel_of(o);
    value[LOBES] = o->lobe_table_size;
    value[IRRADIANCE] =
        o->bake.irradiance ? o->bake.irradiance_options.size : 0;
    value[LUT] = o->lut.size;
}

size_t ibl_opts_bytes(const ibl_opts *o)
{
    ibl_specular_layout l = {.levels = 0};
    int value[PARTS];

    given_values(o, value);
    ibl_specular_layout_of(&o->bake.specular_options, &l);
    value[LEVELS] = l.levels;
    return bytes_with(o, value);
}

/* ---- a set ----------------------------------------------------------------
 */

/* Values that a part may take, and what each adds to the square of a set's
 * error that the finest does not, 0 or more. */
typedef struct values {
    int count;
    int value[MOST];
    double error[MOST];
} values;

/* A chain that may be taken, with squared errors. */
typedef struct chain {
    ibl_specular_layout layout; /* levels 0: not yet known */
    double least;               /* with the best lobe table; -1: none */
    /* Judged with a table of each size, less what the parts add; 0: not yet */
    double own[MOST_TABLES];
} chain;

/* A set: indices of values. Errors are squared. */
typedef struct pick {
    int at[PARTS];
    int ladder; /* 0: its chain's; or of a named mapping, see ladders */
    size_t bytes;
    double sum;   /* what its parts add by the sums */
    double error; /* of the whole set */
} pick;

static const ibl_roughness_map ladders[] = {
    IBL_ROUGHNESS_BEST, IBL_ROUGHNESS_FILAMENT, IBL_ROUGHNESS_LINEAR};

typedef struct search {
    ibl_bake_source *from;
    ibl_opts *o;
    ibl_expectation *e;
    double power[IBL_POWER + 1];
    int degree; /* of the power */
    size_t most_bytes;
    double most_parts; /* squared error that the parts may add */
    bool fits;         /* the levels' roughnesses are free */
    bool table;        /* there are lobe tables */
    values part[PARTS];
    ibl_lut luts[MOST];
    ibl_lobe_table lobes; /* the last, and the options that it was made for */
    ibl_lobe_table_options made;
    pick small[MOST_SMALL]; /* by pixel and bytes; the more, the better */
    int small_count;
    double ratio; /* the least of chains' own over least; 0: none was judged */
    chain chain[MOST][MOST_LEVELS];
} search;

static chain *chain_of(search *s, const pick *p)
{
    return &s->chain[p->at[SIZE]][p->at[LEVELS]];
}

static int value_of(const search *s, const pick *p, int part)
{
    return s->part[part].value[p->at[part]];
}

/* The sets of all values of the parts first..end - 1, one after the other, *p
 * beginning with zeros. False: there is no other. */
static bool next_set(const search *s, int first, int end, pick *p)
{
    for (int i = end - 1; i >= first; i--) {
        if (++p->at[i] < s->part[i].count)
            return true;
        p->at[i] = 0;
    }
    return false;
}

static bool next_chain(const search *s, pick *p)
{
    return next_set(s, SIZE, LEVELS + 1, p);
}

static bool layout_of(search *s, const pick *p, ibl_specular_layout *layout)
{
    ibl_specular_options o = s->o->bake.specular_options;

    *layout = chain_of(s, p)->layout;
    if (!p->ladder)
        return true;
    o.size = layout->size;
    o.levels = layout->levels;
    o.mapping = ladders[p->ladder];
    return !ibl_specular_layout_of(&o, layout);
}

static size_t bytes_of(search *s, const pick *p)
{
    int value[PARTS];

    for (int i = 0; i < PARTS; i++)
        value[i] = value_of(s, p, i);
    value[LEVELS] = chain_of(s, p)->layout.levels;
    return bytes_with(s->o, value);
}

/* The BRDF table of a set, NULL if it is no matter of choice. */
static bool make_lut(search *s, const pick *p, const ibl_lut **lut)
{
    ibl_lut *own = &s->luts[p->at[LUT]];
    const ibl_lut_options of = {.size = value_of(s, p, LUT)};

    *lut = NULL;
    if (!wants(s->o, IBL_OUTPUT_LUT) || s->o->lut.kind != IBL_LUT_SPLIT ||
        of.size < 2)
        return true;
    *lut = own;
    return own->data || !ibl_bake_lut(s->from->ctx, &of, own);
}

static bool make_lobes(search *s, int size, const ibl_specular_layout *layout)
{
    ibl_lobe_table_options of = s->made;

    of.size = size;
    of.layout = *layout;
    if (s->lobes.data && !memcmp(&of, &s->made, sizeof of))
        return true;
    s->made = of;
    ibl_lobe_table_free(&s->lobes);
    return !ibl_bake_lobe_table(s->from->ctx, &of, &s->lobes);
}

/* The squared error of a set, of which the parts of a mask are as exact as can
 * be. */
static bool error_of(search *s, const pick *p, unsigned exact, double *square)
{
    ibl_expected_set set = {
        .lookup = s->table ? IBL_LOOKUP_TABLE : IBL_LOOKUP_SPLIT,
        .irradiance =
            exact & 1u << IRRADIANCE ? -1 : value_of(s, p, IRRADIANCE)};
    double nrmse = 0;
    bool ok = layout_of(s, p, &set.layout);

    if (!(exact & 1u << PIXEL))
        format_errors((ibl_pixel)value_of(s, p, PIXEL), &set);
    if (!(exact & 1u << LUT))
        ok = ok && make_lut(s, p, &set.lut);
    if (s->table && !(exact & 1u << LOBES)) {
        ok = ok && make_lobes(s, value_of(s, p, LOBES), &set.layout);
        set.lobes = &s->lobes;
    }
    ok = ok && !ibl_expectation_of(s->e, &set, &nrmse);
    *square = nrmse * nrmse;
    return ok;
}

/* Sets the bytes of a set and its error as a whole. */
static bool judge(search *s, pick *p)
{
    p->bytes = bytes_of(s, p);
    return error_of(s, p, 0, &p->error);
}

/* What a part adds to the squared error of a set that was judged, 0 or more. */
static bool added_by(search *s, const pick *p, int part, double *added)
{
    double without = 0;
    const bool ok = error_of(s, p, 1u << part, &without);

    *added = fmax(p->error - without, 0);
    return ok;
}

/* Whether a part is none of the chain, and may be chosen. */
static bool is_small(const search *s, int part)
{
    return part != SIZE && part != LEVELS && s->part[part].count > 1;
}

/* Sets *sum to what format, irradiance and BRDF table add to a set that was
 * judged, and takes that for what they add to others. */
static bool sum_of_added(search *s, const pick *p, double *sum)
{
    bool ok = true;

    *sum = 0;
    for (int i = 0; i < PARTS && ok; i++)
        if (is_small(s, i) && i != LOBES) {
            double *added = &s->part[i].error[p->at[i]];
            ok = added_by(s, p, i, added);
            *sum += *added;
        }
    return ok;
}

/* Whether a set that was judged has an error of at most `most`, and its parts
 * add no more than they may. */
static bool is_enough(search *s, double most, const pick *p, bool *enough)
{
    double sum = 0;
    const bool ok = p->error > most || s->most_parts == HUGE_VAL ||
                    sum_of_added(s, p, &sum);

    *enough = p->error <= most && sum <= s->most_parts;
    return ok;
}

/* ---- chains ---------------------------------------------------------------
 */

/* 0 counts as one. */
static bool is_power(int edge)
{
    return (edge & (edge - 1)) == 0;
}

/* Whether ladders are fitted to faces of an edge: others take the ladder of the
 * next such edge. */
static bool is_fitted(int edge)
{
    return is_power(edge) || (edge % 3 == 0 && is_power(edge / 3));
}

/* The parts that the error of a chain alone leaves out: those that may be
 * chosen, and the table. */
static unsigned beside_chain(const search *s)
{
    unsigned parts = 1u << LOBES;

    for (int i = 0; i < PARTS; i++)
        if (is_small(s, i))
            parts |= 1u << i;
    return parts;
}

/* Finds the layout of a chain and its error with the best table. */
static bool measure_chain(search *s, const pick *p, chain *c)
{
    ibl_specular_options o = s->o->bake.specular_options;
    double nrmse = 0;

    o.size = value_of(s, p, SIZE);
    o.levels = value_of(s, p, LEVELS);
    if (s->fits
            ? ibl_expectation_fit(s->e, o.size, o.levels, &c->layout, &nrmse)
            : ibl_specular_layout_of(&o, &c->layout))
        return false;
    c->least = nrmse * nrmse;
    /* The fit knows no formats, of which blocks matter. */
    if ((!s->fits || (s->part[PIXEL].count == 1 &&
                      ibl_pixel_block((ibl_pixel)value_of(s, p, PIXEL)) > 1)) &&
        !error_of(s, p, beside_chain(s), &c->least))
        return false;
    c->least = fmax(c->least, 1e-12);
    return true;
}

static bool make_chain(search *s, const pick *p);

/* The chain between two that are fitted: the square of the error is taken to be
 * a power of the edge. */
static bool blend_chain(search *s, const pick *p, chain *c)
{
    const int *edge = s->part[SIZE].value;
    pick low = *p, high = *p;

    while (!is_fitted(edge[low.at[SIZE]]))
        low.at[SIZE]--;
    while (!is_fitted(edge[high.at[SIZE]]))
        high.at[SIZE]++;
    if (!make_chain(s, &low) || !make_chain(s, &high))
        return false;
    const chain *a = chain_of(s, &low), *b = chain_of(s, &high);
    const double t = log((double)value_of(s, p, SIZE) / a->layout.size) /
                     log((double)b->layout.size / a->layout.size);
    c->layout = b->layout;
    c->layout.size = value_of(s, p, SIZE);
    c->least = pow(a->least, 1 - t) * pow(b->least, t);
    return true;
}

/* False: there is no such chain, or after a message. */
static bool make_chain(search *s, const pick *p)
{
    chain *c = chain_of(s, p);
    const int edge = value_of(s, p, SIZE), count = value_of(s, p, LEVELS);

    if (c->layout.levels)
        return c->least >= 0;
    c->layout.levels = 1;
    c->least = -1;
    if (count > ibl_most_levels(edge) ||
        (s->part[LEVELS].count > 1 && edge >> (count - 1) < LEAST_EDGE))
        return false;
    return s->fits && s->part[SIZE].count > 1 && !is_fitted(edge)
               ? blend_chain(s, p, c)
               : measure_chain(s, p, c);
}

/* ---- by the sums ----------------------------------------------------------
 */

static double error_by_sums(const search *s, const pick *p, int part)
{
    return s->part[part].error[p->at[part]];
}

static void add_errors(const search *s, pick *p)
{
    p->sum = 0;
    for (int i = PIXEL; i < PARTS; i++)
        p->sum += error_by_sums(s, p, i);
}

static int by_bytes(const void *a, const void *b)
{
    const pick *x = a, *y = b;

    if (x->at[PIXEL] != y->at[PIXEL])
        return x->at[PIXEL] < y->at[PIXEL] ? -1 : 1;
    if (x->bytes != y->bytes)
        return x->bytes < y->bytes ? -1 : 1;
    return x->sum < y->sum ? -1 : x->sum > y->sum;
}

/* Lists what may be had besides a chain that no other of the same format is
 * better than, in bytes and error. */
static void list_small(search *s)
{
    pick p = {.ladder = 0}, *all = s->small;
    int count = 0;

    do {
        add_errors(s, &p);
        if (p.sum - error_by_sums(s, &p, LOBES) > s->most_parts ||
            count == MOST_SMALL)
            continue;
        p.bytes = bytes_of(s, &p);
        all[count++] = p;
    } while (next_set(s, PIXEL, PARTS, &p));
    qsort(all, (size_t)count, sizeof *all, by_bytes);
    s->small_count = 0;
    for (int i = 0; i < count; i++) {
        const pick *last = &all[s->small_count - 1];
        if (!s->small_count || all[i].at[PIXEL] != last->at[PIXEL] ||
            all[i].sum < last->sum)
            all[s->small_count++] = all[i];
    }
}

/* A chain that was not judged is taken to be off from its least error as the
 * best of all: none is passed over that may do. */
static double own_error(const search *s, const chain *c, int table)
{
    const double finest = c->own[s->part[LOBES].count - 1];

    return c->own[table] > 0 ? c->own[table]
           : finest > 0      ? finest
                             : c->least * (s->ratio > 0 ? s->ratio : 1);
}

static pick with_chain(const pick *of, const pick *small)
{
    pick p = *small;

    p.at[SIZE] = of->at[SIZE];
    p.at[LEVELS] = of->at[LEVELS];
    return p;
}

/* Keeps the set of fewest bytes with a chain and an error of at most `most`. */
static void try_small(search *s, double most, const pick *of, pick *best)
{
    const chain *c = chain_of(s, of);

    for (int i = 0; i < s->small_count; i++) {
        pick p = with_chain(of, &s->small[i]);
        p.error = own_error(s, c, p.at[LOBES]) + p.sum;
        if (p.error > most)
            continue;
        p.bytes = bytes_of(s, &p);
        if (p.bytes <= s->most_bytes &&
            (p.bytes < best->bytes ||
             (p.bytes == best->bytes && p.error < best->error)))
            *best = p;
    }
}

/* The set of fewest bytes that promises a squared error of at most `most`.
 * False: there is none. */
static bool find(search *s, double most, pick *best)
{
    const values *pixel = &s->part[PIXEL];
    pick p = {.ladder = 0};

    *best = (pick){.bytes = SIZE_MAX};
    do {
        const size_t least =
            chain_bytes(value_of(s, &p, SIZE), 1,
                        (ibl_pixel)pixel->value[pixel->count - 1]);
        if (least <= s->most_bytes && least < best->bytes && make_chain(s, &p))
            try_small(s, most, &p, best);
    } while (next_chain(s, &p));
    return best->bytes < SIZE_MAX;
}

/* The set of a chain whose parts add the least, of no more bytes than there may
 * be. False: there is none. */
static bool finest_of(search *s, const pick *of, pick *finest)
{
    *finest = (pick){.sum = HUGE_VAL};
    if (!make_chain(s, of))
        return false;
    for (int i = 0; i < s->small_count; i++) {
        const pick p = with_chain(of, &s->small[i]);
        if (p.sum < finest->sum && bytes_of(s, &p) <= s->most_bytes)
            *finest = p;
    }
    return finest->sum < HUGE_VAL;
}

/* ---- by judging -----------------------------------------------------------
 */

/* Judges a pick, and keeps what its chain has of the error. The finest table
 * comes first: *p then has that. */
static bool judge_pick(search *s, pick *p)
{
    const int finest = s->part[LOBES].count - 1;
    chain *c = chain_of(s, p);

    if (!(c->own[finest] > 0))
        p->at[LOBES] = finest;
    add_errors(s, p);
    if (!judge(s, p))
        return false;
    c->own[p->at[LOBES]] = fmax(p->error - p->sum, 1e-12);
    const double ratio = c->own[finest] / c->least;
    s->ratio = s->ratio > 0 ? fmin(s->ratio, ratio) : ratio;
    return true;
}

/* Judges of each number of levels the chain of least error with its best table,
 * with the finest parts. *best is that of least error; HUGE_VAL: there is
 * none. False: after a message. */
static bool judge_finest(search *s, pick *best)
{
    pick of = {.ladder = 0};

    *best = (pick){.error = HUGE_VAL};
    for (; of.at[LEVELS] < s->part[LEVELS].count; of.at[LEVELS]++) {
        pick p, finest = {.ladder = 0};
        double least = HUGE_VAL;
        for (of.at[SIZE] = 0; of.at[SIZE] < s->part[SIZE].count; of.at[SIZE]++)
            if (finest_of(s, &of, &p) && chain_of(s, &p)->least < least) {
                least = chain_of(s, &p)->least;
                finest = p;
            }
        if (least == HUGE_VAL)
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
static bool judge_sets(search *s, double most, pick *best)
{
    bool holds = best->error <= most, now;
    pick p;

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
static bool try_mappings(search *s, pick *best)
{
    pick p = *best;

    if (!s->fits || chain_of(s, best)->layout.levels < 2)
        return true;
    for (p.ladder = 1; p.ladder < 3; p.ladder++) {
        if (!judge(s, &p))
            return false;
        if (p.error < best->error)
            *best = p;
    }
    return true;
}

/* Makes one of the parts of a set coarser by steps of its values. False: there
 * is no such set, or it has no fewer bytes. */
static bool coarsen(search *s, int part, int steps, pick *p)
{
    const size_t before = p->bytes;
    int *at = &p->at[part];

    *at += part == PIXEL ? steps : -steps;
    if (*at < 0 || *at >= s->part[part].count || !make_chain(s, p))
        return false;
    if (part == SIZE || part == LEVELS)
        p->ladder = 0;
    p->bytes = bytes_of(s, p);
    return p->bytes < before;
}

/* Bytes saved for the error that it costs. */
static double saving(const pick *from, const pick *to)
{
    return (double)(from->bytes - to->bytes) /
           fmax(to->error - from->error, 1e-12);
}

/* Makes a part of a set coarser by at most *steps, which are halved until it
 * holds: *p; 0: it does not. */
static bool try_part(search *s, double most, const pick *from, int part,
                     int *steps, pick *p)
{
    for (bool enough = false; *steps; *steps /= 2) {
        *p = *from;
        if (!coarsen(s, part, *steps, p))
            continue;
        if (!judge(s, p) || !is_enough(s, most, p, &enough))
            return false;
        if (enough)
            break;
    }
    return true;
}

/* Makes the parts of a set coarser while it holds, each time that part which
 * saves most bytes for the error. Its next steps are twice as many. */
static bool shrink(search *s, double most, pick *best)
{
    int steps[PARTS] = {1, 1, 1, 1, 1, 1};

    for (;;) {
        pick next = *best, p;
        int which = -1;
        for (int part = 0; part < PARTS; part++) {
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

static bool finish(search *s, double most, pick *best)
{
    return try_mappings(s, best) && shrink(s, most, best);
}

/* Starts from small chains that hold with the finest parts, too, and not only
 * from the set of least error. */
static bool try_chains(search *s, double most, pick *best)
{
    pick of = {.ladder = 0};

    do {
        const int edge = value_of(s, &of, SIZE);
        pick p;
        if (!is_power(edge) ||
            chain_bytes(edge, 1, IBL_PIXEL_RGB9E5) >= best->bytes ||
            !finest_of(s, &of, &p))
            continue;
        if (!judge(s, &p) || (p.error <= most && !finish(s, most, &p)))
            return false;
        if (p.error <= most && p.bytes < best->bytes)
            *best = p;
    } while (next_chain(s, &of));
    return true;
}

/* Finds the set of fewest bytes with the error that is asked or, if that cannot
 * be had, near to the least. */
static bool search_all(search *s, ibl_choice *choice, pick *best)
{
    double most = choice->asked * choice->asked;
    pick least;

    *best = (pick){.error = HUGE_VAL};
    if (!judge_sets(s, most, best))
        return false;
    if (best->error > most) {
        if (!judge_finest(s, &least))
            return false;
        if (least.error == HUGE_VAL)
            return ibl_console_fail(s->from->console,
                                    "--rendered-error %g: there is no chain of "
                                    "such sizes and levels",
                                    choice->asked);
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

/* ---- what may be chosen ---------------------------------------------------
 */

static void add_value(values *v, int value)
{
    if (v->count < MOST)
        v->value[v->count++] = value;
}

/* Adds edges, from a power of two to a last one, in steps of a part of each
 * octave: whole numbers. */
static void add_edges(values *v, int first, int last, int steps)
{
    for (int octave = first; octave <= last; octave *= 2)
        for (int i = 0; i < steps; i++)
            if (octave * i % steps == 0 && octave + octave * i / steps <= last)
                add_value(v, octave + octave * i / steps);
}

/* Edges up to twice the map's detail, or twice what the sharpest lobe needs
 * (ibl_specular_layout_of). */
static void list_sizes(search *s, const ibl_materials *m)
{
    double edge = s->from->width / 2.0;
    int sharpest = 0, last = s->fits ? 8 : 32;

    while (m->weight[sharpest][0] <= 0 && m->weight[sharpest][1] <= 0)
        sharpest++;
    const double r = (double)sharpest / IBL_MATERIAL_STEPS;
    if (r > 0)
        edge = fmin(edge, 5 * M_PI / (r * r));
    while (last < edge && last < MOST_EDGE)
        last *= 2;
    s->part[SIZE].count = 0;
    add_edges(&s->part[SIZE], s->fits ? LEAST_EDGE : 32, last, s->fits ? 8 : 1);
}

static void list_levels(search *s)
{
    s->part[LEVELS].count = 0;
    for (int levels = s->fits ? 1 : 2; levels < MOST_LEVELS; levels++)
        add_value(&s->part[LEVELS], levels);
}

/* Of most bytes first. */
static void list_pixels(search *s)
{
    static const ibl_pixel pixels[] = {IBL_PIXEL_RGBA16F, IBL_PIXEL_R11G11B10F,
                                       IBL_PIXEL_RGB9E5};

    s->part[PIXEL].count = 0;
    for (int i = 0; i < 3; i++)
        if (ibl_container_holds(s->o->format, pixels[i]))
            add_value(&s->part[PIXEL], (int)pixels[i]);
}

/* A set without a cube has harmonics, in the sidecar. */
static void list_irradiance(search *s)
{
    s->part[IRRADIANCE].count = 0;
    if (s->o->bake.sh_degree >= 2 && !ibl_opts_given(s->o, "only"))
        add_value(&s->part[IRRADIANCE], 0);
    add_edges(&s->part[IRRADIANCE], 4, 32, 4);
}

/* Lists the values of the parts that neither the user nor the target fixed. */
static void list_values(search *s, const ibl_materials *materials)
{
    const ibl_opts *o = s->o;
    const bool fixed = o->of || o->engine;

    if (!ibl_opts_given(o, "size"))
        list_sizes(s, materials);
    if (!o->bake.specular_options.levels && !fixed)
        list_levels(s);
    if (!ibl_opts_given(o, "pixel") && !fixed)
        list_pixels(s);
    if (o->bake.irradiance && !ibl_opts_given(o, "irradiance-size") && !fixed &&
        !(o->bake.irradiance_options.step > 0))
        list_irradiance(s);
    if (o->lut.kind == IBL_LUT_SPLIT && wants(o, IBL_OUTPUT_LUT) &&
        !ibl_opts_given(o, "lut-size")) {
        s->part[LUT].count = 0;
        add_edges(&s->part[LUT], 4, 256, 4);
    }
    if (s->table && !ibl_opts_given(o, "lobe-table-size")) {
        s->part[LOBES].count = 0;
        add_edges(&s->part[LOBES], 4, 32, 2);
    }
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

/* Between powers of two, errors are taken to be a power of the edge. */
static void blend_errors(values *v)
{
    int low = -1, high = 0;

    for (int i = 0; i < v->count; i++) {
        if (is_power(v->value[i])) {
            low = i;
            continue;
        }
        for (high = i + 1; !is_power(v->value[high]);)
            high++;
        const double t = log((double)v->value[i] / v->value[low]) /
                         log((double)v->value[high] / v->value[low]);
        v->error[i] = pow(fmax(v->error[low], 1e-12), 1 - t) *
                      pow(fmax(v->error[high], 1e-12), t);
    }
}

/* What the values of a part add to the error of a chain with the finest. */
static bool find_errors(search *s, const pick *of, int part)
{
    values *v = &s->part[part];
    const int last = part == PIXEL ? 0 : v->count - 1;
    pick p = *of;
    bool ok = true;

    for (int i = 0; i < v->count && ok; i++)
        if (part == PIXEL || is_power(v->value[i])) {
            p.at[part] = i;
            ok = error_of(s, &p, beside_chain(s) & ~(1u << part), &v->error[i]);
        }
    for (int i = 0; i < v->count; i++)
        if (i != last)
            v->error[i] = fmax(v->error[i] - v->error[last], 0);
    v->error[last] = 0;
    if (part != PIXEL)
        blend_errors(v);
    return ok;
}

/* What the others add to the error of a chain of a middling size. */
static bool find_all_errors(search *s)
{
    pick p = {.at = {[SIZE] = s->part[SIZE].count / 2,
                     [LEVELS] = s->part[LEVELS].count - 1}};

    while (p.at[LEVELS] > 0 && !make_chain(s, &p))
        p.at[LEVELS]--;
    if (!make_chain(s, &p))
        return true; /* and find() finds none */
    bool ok = true;
    for (int i = 0; i < PARTS && ok; i++)
        if (is_small(s, i))
            ok = find_errors(s, &p, i);
    return ok;
}

/* ---- what was chosen ------------------------------------------------------
 */

static bool set_options(search *s, const pick *p)
{
    ibl_opts *o = s->o;
    ibl_specular_options *to = &o->bake.specular_options;
    const int irradiance = value_of(s, p, IRRADIANCE);
    ibl_specular_layout layout;

    if (!layout_of(s, p, &layout))
        return false;
    if (wants(o, IBL_OUTPUT_SPECULAR)) {
        to->size = value_of(s, p, SIZE);
        to->levels = value_of(s, p, LEVELS);
    }
    if (wants(o, IBL_OUTPUT_SPECULAR) && s->fits) {
        memcpy(o->roughness, layout.roughness, sizeof o->roughness);
        to->roughness = o->roughness;
    }
    if (!o->engine)
        o->texels.pixel = (ibl_pixel)value_of(s, p, PIXEL);
    if (irradiance > 0)
        o->bake.irradiance_options.size = irradiance;
    else
        o->only &= ~(1u << IBL_OUTPUT_IRRADIANCE);
    o->lut.size = value_of(s, p, LUT);
    o->lobe_table_size = value_of(s, p, LOBES);
    ibl_opts_select(o);
    return true;
}

static void tell_chain(search *s, const pick *p, ibl_choice *choice)
{
    ibl_specular_layout l;
    char text[IBL_CHOICE_BYTES];

    if (!layout_of(s, p, &l))
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
                     s->part[SIZE].count > 1 ? "the smallest exact enough"
                                             : "as asked");
}

static bool tell_added(search *s, const pick *p, int part, const char *name,
                       ibl_choice *choice)
{
    char text[16] = "harmonics";
    double added;

    if (!added_by(s, p, part, &added))
        return false;
    if (value_of(s, p, part))
        snprintf(text, sizeof text, "%d", value_of(s, p, part));
    ibl_choice_chose(choice, name, text, "adds %.2g %% of error",
                     100 * sqrt(added));
    return true;
}

static bool tell(search *s, const pick *p, ibl_choice *choice)
{
    static const char *const of_f0[] = {"", ", for metals only",
                                        ", for dielectrics only"};
    const ibl_opts *o = s->o;
    char text[16];

    if (wants(o, IBL_OUTPUT_SPECULAR))
        tell_chain(s, p, choice);
    ibl_choice_chose(choice, "texels",
                     o->engine ? ibl_engine_pixel(o->engine)
                               : ibl_pixel_name(o->texels.pixel),
                     "%s",
                     s->part[PIXEL].count > 1 ? "the smallest exact enough"
                                              : "as asked");
    bool ok = tell_added(s, p, IRRADIANCE, "irradiance", choice) &&
              (!wants(o, IBL_OUTPUT_LUT) ||
               tell_added(s, p, LUT, "BRDF table", choice));
    snprintf(text, sizeof text, "%d", o->lobe_table_size);
    if (s->table)
        ibl_choice_chose(choice, "lobe table", text, "fitted to the levels%s",
                         of_f0[o->lobe_f0]);
    return ok;
}

/* The least error of chains of a size. */
static double least_of_size(search *s, int size)
{
    double least = HUGE_VAL;
    pick p = {.at = {[SIZE] = size}};

    for (; p.at[LEVELS] < s->part[LEVELS].count; p.at[LEVELS]++)
        if (make_chain(s, &p))
            least = fmin(least, chain_of(s, &p)->least);
    return least;
}

/* Why the error that was asked is not reached: larger faces would, or none. */
static void tell_limit(search *s, ibl_choice *choice)
{
    const values *size = &s->part[SIZE];
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
static bool judge_usual(search *s, ibl_choice *choice)
{
    pick p = {.ladder = 0};
    int value[PARTS];

    given_values(s->o, value);
    for (int i = 0; i < PARTS; i++)
        add_value(&s->part[i], value[i]);
    if (!make_chain(s, &p) || !judge(s, &p))
        return false;
    choice->usual_error = sqrt(p.error);
    choice->usual_bytes = p.bytes;
    memset(s->chain, 0, sizeof s->chain);
    ibl_lut_free(&s->luts[0]);
    return true;
}

/* The options of lobe tables, but for their size and chain. */
static void set_table(search *s)
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

/* Lists what may be chosen of options o, which lives as long as the search, and
 * sets the default's figures. search_close is needed also after a failure. */
static bool search_open(search *s, ibl_bake_source *from,
                        const ibl_materials *materials, ibl_opts *o,
                        ibl_choice *choice)
{
    double square;

    s->from = from;
    s->o = o;
    s->most_parts = HUGE_VAL;
    s->table = wants(o, IBL_OUTPUT_SPECULAR) && wants(o, IBL_OUTPUT_LOBES);
    if (!ibl_bake_source_power(from, s->power, &s->degree, &square) ||
        ibl_expectation_create(from->ctx, materials, s->power, s->degree,
                               from->width / 2, square, &s->e))
        return false;
    set_table(s);
    if (!judge_usual(s, choice))
        return false;
    s->most_bytes =
        ibl_opts_given(o, "rendered-error") ? SIZE_MAX : choice->usual_bytes;
    s->fits = s->table && !ibl_opts_given(o, "mapping") &&
              !ibl_opts_given(o, "roughness-range") && !o->of && !o->engine;
    if (s->table && !ibl_opts_given(o, "lobe-table"))
        o->lobe_table = IBL_LOBES_FITTED;
    o->lobe_f0 = f0_of(materials);
    set_table(s);
    list_values(s, materials);
    if (!find_all_errors(s))
        return false;
    list_small(s);
    return true;
}

static void search_close(search *s)
{
    for (int i = 0; i < MOST; i++)
        ibl_lut_free(&s->luts[i]);
    ibl_lobe_table_free(&s->lobes);
    ibl_expectation_free(s->e);
}

bool ibl_choose(ibl_bake_source *from, const ibl_materials *materials,
                ibl_opts *o, ibl_choice *choice)
{
    search *s = calloc(1, sizeof *s);
    pick best;

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
