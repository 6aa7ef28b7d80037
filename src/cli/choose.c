/* SPDX-License-Identifier: MIT */
/*
 * The search. The error of a chain with the best table that it could have is
 * known at once; that of the formats, irradiance and the BRDF table is what
 * they add to a usual chain's. So the cheapest set is found by these sums. Then
 * its lobe table is made and the whole set is judged; what it has more than the
 * sum says is remembered for that chain, and the search goes on until a set
 * has the error that is asked. At last its parts are made coarser one at a
 * time, while the judged error allows: the sums overstate that of some sets.
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
    MOST_PARTS = 2048,
    MOST_EDGE = 2048,
    LEAST_EDGE = 4, /* of a level */
    DESCENT = 6,    /* parts that are made coarser at last */
    ROUNDS = 48     /* sets whose lobe table is made */
};

/* How near to the least error a set must be if that asked cannot be had. */
static const double near = 1.2;

/* ---- formats --------------------------------------------------------------
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

static size_t chain_bytes(int size, int levels, ibl_pixel pixel)
{
    size_t bytes = 0;

    for (int l = 0; l < levels; l++)
        bytes += IBL_FACES * image_bytes(ibl_cube_edge(size, l), pixel);
    return bytes;
}

/* ---- the search -----------------------------------------------------------
 */

/* Values that an output may take, and the square of the error that each adds
 * to a set. */
typedef struct values {
    int count;
    int value[MOST];
    double error[MOST];
} values;

/* A chain that may be taken, with squared errors. */
typedef struct chain {
    ibl_specular_layout layout; /* levels 0: not yet known */
    double least;               /* with the best lobe table; -1: none */
    double judged[MOST_TABLES]; /* with a table of each size; 0: not yet */
} chain;

/* What there is besides the levels and their table, as indices of values. */
typedef struct parts {
    int pixel, irradiance, lut;
    size_t bytes;
    double error; /* squared */
} parts;

/* Indices of values. */
typedef struct pick {
    int size, levels, lobes;
    parts parts;
    size_t bytes;
    double error; /* squared */
} pick;

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
    values size, levels, pixel, irradiance, lut, lobes;
    ibl_lut luts[MOST];
    parts parts[MOST_PARTS]; /* by pixel and bytes; the more, the better */
    int part_count;
    /* Of squared errors, the least so far; 0: none was judged. */
    double usual;               /* judged with the finest table over least */
    double ratio[MOST_LEVELS];  /* the same, of each number of levels */
    double coarse[MOST_TABLES]; /* a table of a size over the finest one */
    chain chain[MOST][MOST_LEVELS];
} search;

static bool wants(const ibl_opts *o, ibl_output_kind kind)
{
    return o->only & 1u << kind;
}

static void add_value(values *v, int value)
{
    if (v->count < MOST)
        v->value[v->count++] = value;
}

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

/* Finds the layout of a chain and its error with the best table. */
static bool measure_chain(search *s, int edge, int count, chain *c)
{
    ibl_specular_options o = s->o->bake.specular_options;
    ibl_expected_set set = {.lookup =
                                s->table ? IBL_LOOKUP_TABLE : IBL_LOOKUP_SPLIT,
                            .irradiance = -1};
    double nrmse = 0;

    o.size = edge;
    o.levels = count;
    if (s->fits && ibl_expectation_fit(s->e, edge, count, &c->layout, &nrmse))
        return false;
    if (!s->fits && ibl_specular_layout_of(&o, &c->layout))
        return false;
    set.layout = c->layout;
    if (s->pixel.count == 1)
        format_errors((ibl_pixel)s->pixel.value[0], &set);
    if ((!s->fits || set.slope > 0) && ibl_expectation_of(s->e, &set, &nrmse))
        return false;
    c->least = fmax(nrmse * nrmse, 1e-12);
    return true;
}

static bool make_chain(search *s, int size, int levels);

/* The chain between two that are fitted: the square of the error is taken to be
 * a power of the edge. */
static bool blend_chain(search *s, int size, int levels, chain *c)
{
    const int *edge = s->size.value;
    int low = size - 1, high = size + 1;

    while (!is_fitted(edge[low]))
        low--;
    while (!is_fitted(edge[high]))
        high++;
    if (!make_chain(s, low, levels) || !make_chain(s, high, levels))
        return false;
    const chain *a = &s->chain[low][levels], *b = &s->chain[high][levels];
    const double t = log((double)edge[size] / edge[low]) /
                     log((double)edge[high] / edge[low]);
    c->layout = b->layout;
    c->layout.size = edge[size];
    c->least = pow(a->least, 1 - t) * pow(b->least, t);
    return true;
}

/* False: there is no such chain, or after a message. */
static bool make_chain(search *s, int size, int levels)
{
    chain *c = &s->chain[size][levels];
    const int edge = s->size.value[size], count = s->levels.value[levels];

    if (c->layout.levels)
        return c->least >= 0;
    c->layout.levels = 1;
    c->least = -1;
    if (count > ibl_most_levels(edge) ||
        (s->levels.count > 1 && edge >> (count - 1) < LEAST_EDGE))
        return false;
    return s->fits && s->size.count > 1 && !is_fitted(edge)
               ? blend_chain(s, size, levels, c)
               : measure_chain(s, edge, count, c);
}

/* A chain that was not judged is taken to be off from its least error as the
 * best of those of as many levels, or as the best of all, and a coarser table
 * to add as little as it ever did: none is passed over that may do. */
static double chain_error(const search *s, int size, int levels, int lobes)
{
    const chain *c = &s->chain[size][levels];
    const double ratio = s->ratio[levels] > 0 ? s->ratio[levels]
                         : s->usual > 0       ? s->usual
                                              : 1;
    const double finest = c->judged[s->lobes.count - 1];

    if (c->judged[lobes] > 0)
        return c->judged[lobes];
    return (finest > 0 ? finest : c->least * ratio) * fmax(s->coarse[lobes], 1);
}

/* Bytes of an irradiance cube, none if edge is 0, and of the BRDF table. */
static size_t small_bytes(const ibl_opts *o, ibl_pixel pixel, int irradiance,
                          int lut)
{
    size_t bytes = 0;

    if (wants(o, IBL_OUTPUT_IRRADIANCE) && irradiance > 0)
        bytes += chain_bytes(irradiance, 1, pixel);
    if (wants(o, IBL_OUTPUT_LUT))
        bytes += (size_t)(lut * lut) *
                 ibl_pixel_bytes(ibl_lut_pixel(pixel, o->lut.kind));
    return bytes;
}

static parts parts_of(const search *s, int pixel, int irradiance, int lut)
{
    return (parts){pixel, irradiance, lut,
                   small_bytes(s->o, (ibl_pixel)s->pixel.value[pixel],
                               s->irradiance.value[irradiance],
                               s->lut.value[lut]),
                   s->pixel.error[pixel] + s->irradiance.error[irradiance] +
                       s->lut.error[lut]};
}

static size_t lobes_bytes(const ibl_opts *o, int edge)
{
    const int layers = IBL_LOBE_LAYERS / (o->lobe_f0 == IBL_F0_BOTH ? 1 : 2);

    return (size_t)(edge * edge * layers) * ibl_pixel_bytes(IBL_PIXEL_RGBA16F);
}

static size_t bytes_of(const search *s, const pick *p)
{
    const ibl_pixel pixel = (ibl_pixel)s->pixel.value[p->parts.pixel];
    const ibl_specular_layout *l = &s->chain[p->size][p->levels].layout;
    size_t bytes = p->parts.bytes;

    if (wants(s->o, IBL_OUTPUT_SPECULAR))
        bytes += chain_bytes(l->size, l->levels, pixel);
    if (s->table)
        bytes += lobes_bytes(s->o, s->lobes.value[p->lobes]);
    return bytes;
}

/* Keeps a pick if it is better: of fewer bytes, if its error is at most
 * `most`, or of less error, if most is 0. */
static void keep_better(const search *s, double most, pick *p, pick *best)
{
    if (most > 0 && p->error > most)
        return;
    p->bytes = bytes_of(s, p);
    const bool fewer = p->bytes < best->bytes ||
                       (p->bytes == best->bytes && p->error < best->error);
    if (p->bytes <= s->most_bytes &&
        (most > 0 ? fewer : p->error <= best->error))
        *best = *p;
}

/* All sets with one chain. */
static void try_parts(const search *s, double most, pick *p, pick *best)
{
    for (p->lobes = 0; p->lobes < s->lobes.count; p->lobes++) {
        const double own = chain_error(s, p->size, p->levels, p->lobes);
        for (int i = 0; i < s->part_count && (most <= 0 || own <= most); i++) {
            p->parts = s->parts[i];
            p->error = own + p->parts.error;
            if (p->parts.error <= s->most_parts)
                keep_better(s, most, p, best);
        }
    }
}

/* The set of fewest bytes with a squared error of at most `most` or, if that is
 * 0, of the least error. False: there is none. */
static bool find(search *s, double most, pick *best)
{
    *best = (pick){.bytes = SIZE_MAX, .error = HUGE_VAL};
    for (int i = 0; i < s->size.count; i++)
        for (int k = 0; k < s->levels.count; k++) {
            pick p = {.size = i, .levels = k};
            const size_t least =
                chain_bytes(s->size.value[i], 1,
                            (ibl_pixel)s->pixel.value[s->pixel.count - 1]);
            if (least <= s->most_bytes && (most <= 0 || least < best->bytes) &&
                make_chain(s, i, k))
                try_parts(s, most, &p, best);
        }
    return best->bytes < SIZE_MAX;
}

/* ---- judging --------------------------------------------------------------
 */

/* The error of a set, with the lobe table that it will have. */
static bool judge(const search *s, const ibl_opts *o, ibl_expected_set *set,
                  double *nrmse)
{
    ibl_ctx *ctx = s->from->ctx;
    ibl_lobe_table_options of = ibl_lobe_table_options_default();
    ibl_lobe_table lobes = {0};
    bool ok = true;

    of.size = o->lobe_table_size;
    of.f0 = o->lobe_f0;
    of.layout = set->layout;
    if (o->lobe_table == IBL_LOBES_FITTED) {
        of.power = s->power;
        of.power_degree = s->degree;
    }
    set->lookup = s->table ? IBL_LOOKUP_TABLE : IBL_LOOKUP_SPLIT;
    if (s->table)
        ok = !ibl_bake_lobe_table(ctx, &of, &lobes);
    set->lobes = s->table ? &lobes : NULL;
    ok = ok && !ibl_expectation_of(s->e, set, nrmse);
    ibl_lobe_table_free(&lobes);
    return ok;
}

/* The BRDF table of a size, NULL if it is no matter of choice. */
static bool make_lut(search *s, int i, const ibl_lut **lut)
{
    const ibl_lut_options of = {.size = s->lut.value[i]};

    *lut = NULL;
    if (!wants(s->o, IBL_OUTPUT_LUT) || s->o->lut.kind != IBL_LUT_SPLIT ||
        of.size < 2)
        return true;
    *lut = &s->luts[i];
    return s->luts[i].data || !ibl_bake_lut(s->from->ctx, &of, &s->luts[i]);
}

static void keep_least(double *least, double value)
{
    *least = *least > 0 ? fmin(*least, value) : value;
}

/* Sets the bytes of a pick and its error as a whole. */
static bool judge_whole(search *s, pick *p)
{
    ibl_opts o = *s->o;
    ibl_expected_set set = {.layout = s->chain[p->size][p->levels].layout,
                            .irradiance =
                                s->irradiance.value[p->parts.irradiance]};
    double nrmse = 0;

    p->bytes = bytes_of(s, p);
    o.lobe_table_size = s->lobes.value[p->lobes];
    format_errors((ibl_pixel)s->pixel.value[p->parts.pixel], &set);
    const bool ok =
        make_lut(s, p->parts.lut, &set.lut) && judge(s, &o, &set, &nrmse);
    p->error = nrmse * nrmse;
    return ok;
}

/* Judges a pick, and keeps what its chain has of the error. The finest table
 * comes first: *p then has that. */
static bool judge_pick(search *s, pick *p)
{
    const int finest = s->lobes.count - 1;
    chain *c = &s->chain[p->size][p->levels];

    if (!(c->judged[finest] > 0))
        p->lobes = finest;
    if (!judge_whole(s, p))
        return false;
    c->judged[p->lobes] = fmax(p->error - p->parts.error, 1e-12);
    if (p->lobes < finest) {
        keep_least(&s->coarse[p->lobes],
                   c->judged[p->lobes] / c->judged[finest]);
        return true;
    }
    keep_least(&s->ratio[p->levels], c->judged[finest] / c->least);
    keep_least(&s->usual, c->judged[finest] / c->least);
    return true;
}

/* Judges the sets that promise the fewest bytes with a squared error of at most
 * `most`, until no other promises fewer. *best is the one that holds or, before
 * there is any, the one of least error. False: after a message. */
static bool judge_sets(search *s, double most, pick *best)
{
    bool holds = best->error <= most;
    pick p;

    for (int i = 0; i < ROUNDS && find(s, most, &p); i++) {
        if (holds && p.bytes >= best->bytes)
            return true;
        if (!judge_pick(s, &p))
            return false;
        const bool now = p.error <= most;
        if (now > holds || (now == holds && (now ? p.bytes < best->bytes
                                                 : p.error < best->error)))
            *best = p;
        holds |= now;
    }
    return true;
}

/* Takes the ladder of a named mapping where the set as a whole has less error
 * with it: the fit does not know the lobe table's size. */
static bool try_mappings(search *s, pick *best)
{
    chain *c = &s->chain[best->size][best->levels];
    ibl_specular_options o = s->o->bake.specular_options;

    o.size = c->layout.size;
    o.levels = c->layout.levels;
    for (int i = 0; i < 2 && s->fits && o.levels > 1; i++) {
        const ibl_specular_layout fitted = c->layout;
        pick p = *best;
        o.mapping = i ? IBL_ROUGHNESS_LINEAR : IBL_ROUGHNESS_FILAMENT;
        if (ibl_specular_layout_of(&o, &c->layout) || !judge_whole(s, &p))
            return false;
        if (p.error < best->error)
            *best = p;
        else
            c->layout = fitted;
    }
    return true;
}

/* Makes one of the parts of a set coarser by steps of its values. False: there
 * is no such set, or it has no fewer bytes. */
static bool coarsen(search *s, int part, int steps, pick *p)
{
    int *const at[DESCENT] = {&p->size,  &p->levels,           &p->parts.pixel,
                              &p->lobes, &p->parts.irradiance, &p->parts.lut};
    const size_t before = p->bytes;

    *at[part] += at[part] == &p->parts.pixel ? steps : -steps;
    if (*at[part] < 0 || p->parts.pixel >= s->pixel.count ||
        !make_chain(s, p->size, p->levels))
        return false;
    p->parts = parts_of(s, p->parts.pixel, p->parts.irradiance, p->parts.lut);
    p->bytes = bytes_of(s, p);
    return p->bytes < before && p->parts.error <= s->most_parts;
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
    for (; *steps; *steps /= 2) {
        *p = *from;
        if (!coarsen(s, part, *steps, p))
            continue;
        if (!judge_whole(s, p))
            return false;
        if (p->error <= most)
            break;
    }
    return true;
}

/* Makes the parts of a set coarser while its error as a whole stays at most
 * `most`, each time that part which saves most bytes for the error. Its next
 * steps are twice as many. */
static bool shrink(search *s, double most, pick *best)
{
    int steps[DESCENT] = {1, 1, 1, 1, 1, 1};

    for (;;) {
        pick next = *best, p;
        int which = -1;
        for (int part = 0; part < DESCENT; part++) {
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
    for (int i = 0; i < s->size.count; i++)
        for (int k = 0; k < s->levels.count && is_power(s->size.value[i]);
             k++) {
            const int edge = s->size.value[i];
            pick p = {.size = i, .levels = k, .lobes = s->lobes.count - 1};
            p.parts = parts_of(s, 0, s->irradiance.count - 1, s->lut.count - 1);
            if (chain_bytes(edge, 1, IBL_PIXEL_RGB9E5) >= best->bytes ||
                !make_chain(s, i, k))
                continue;
            if (!judge_whole(s, &p))
                return false;
            if (p.error > most)
                continue;
            if (!finish(s, most, &p))
                return false;
            if (p.bytes < best->bytes)
                *best = p;
        }
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
        if (!find(s, 0, &least))
            return ibl_console_fail(s->from->console,
                                    "--rendered-error %g: there is no chain of "
                                    "such sizes and levels",
                                    choice->asked);
        if (!judge_pick(s, &least))
            return false;
        if (least.error < best->error)
            *best = least;
        choice->least = sqrt(best->error);
        if (best->error <= most &&
            !(finish(s, most, best) && try_chains(s, most, best)))
            return false;
    }
    choice->reached = best->error <= most;
    if (!choice->reached) {
        s->most_parts = most;
        most = near * near * best->error;
        if (!judge_sets(s, most, best))
            return false;
    }
    return finish(s, most, best);
}

/* ---- what may be chosen ---------------------------------------------------
 */

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
    const ibl_opts *o = s->o;
    double edge = s->from->width / 2.0;
    int sharpest = 0, last = s->fits ? 8 : 32;

    if (ibl_opts_given(o, "size")) {
        add_value(&s->size, o->bake.specular_options.size);
        return;
    }
    while (m->weight[sharpest][0] <= 0 && m->weight[sharpest][1] <= 0)
        sharpest++;
    const double r = (double)sharpest / IBL_MATERIAL_STEPS;
    if (r > 0)
        edge = fmin(edge, 5 * M_PI / (r * r));
    while (last < edge && last < MOST_EDGE)
        last *= 2;
    add_edges(&s->size, s->fits ? LEAST_EDGE : 32, last, s->fits ? 8 : 1);
}

static void list_levels(search *s)
{
    const int given = s->o->bake.specular_options.levels;

    if (given || s->o->of || s->o->engine) {
        add_value(&s->levels, given);
        return;
    }
    for (int levels = s->fits ? 1 : 2; levels < MOST_LEVELS; levels++)
        add_value(&s->levels, levels);
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

/* Of most bytes first. */
static void list_pixels(search *s)
{
    static const ibl_pixel pixels[] = {IBL_PIXEL_RGBA16F, IBL_PIXEL_R11G11B10F,
                                       IBL_PIXEL_RGB9E5};
    const ibl_opts *o = s->o;

    if (ibl_opts_given(o, "pixel") || o->of || o->engine) {
        add_value(&s->pixel, (int)pixel_of(o));
        return;
    }
    for (int i = 0; i < 3; i++)
        if (ibl_container_holds(o->format, pixels[i]))
            add_value(&s->pixel, (int)pixels[i]);
}

/* A set without a cube has harmonics, in the sidecar. */
static void list_irradiance(search *s)
{
    const ibl_opts *o = s->o;
    const bool harmonics = o->bake.sh_degree >= 2;

    if (!wants(o, IBL_OUTPUT_IRRADIANCE) && !o->bake.irradiance) {
        add_value(&s->irradiance, 0);
        return;
    }
    if (ibl_opts_given(o, "irradiance-size") || o->of || o->engine ||
        o->bake.irradiance_options.step > 0) {
        add_value(&s->irradiance, o->bake.irradiance_options.size);
        return;
    }
    if (harmonics && !ibl_opts_given(o, "only"))
        add_value(&s->irradiance, 0);
    add_edges(&s->irradiance, 4, 32, 4);
}

static void list_tables(search *s)
{
    const ibl_opts *o = s->o;

    if (o->lut.kind != IBL_LUT_SPLIT || !wants(o, IBL_OUTPUT_LUT) ||
        ibl_opts_given(o, "lut-size"))
        add_value(&s->lut, o->lut.size);
    else
        add_edges(&s->lut, 4, 256, 4);
    if (!s->table || ibl_opts_given(o, "lobe-table-size"))
        add_value(&s->lobes, o->lobe_table_size);
    else
        add_edges(&s->lobes, 4, 32, 2);
}

/* What values of a part add to the square of a chain's error. */
static bool find_error(search *s, const ibl_expected_set *set, double alone,
                       double *error)
{
    double nrmse = 0;
    const bool ok = !ibl_expectation_of(s->e, set, &nrmse);

    *error = nrmse * nrmse - alone;
    return ok;
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

/* What the others add to the error of a chain of a middling size. */
static bool find_errors(search *s)
{
    ibl_expected_set set = {.irradiance = -1};
    double alone = 0;
    int i = s->size.count / 2, k = s->levels.count - 1;

    while (k > 0 && !make_chain(s, i, k))
        k--;
    if (!make_chain(s, i, k))
        return true; /* and find() finds none */
    set.layout = s->chain[i][k].layout;
    set.lookup = s->table ? IBL_LOOKUP_TABLE : IBL_LOOKUP_SPLIT;
    bool ok = find_error(s, &set, 0, &alone);
    for (i = 0; i < s->pixel.count && ok && s->pixel.count > 1; i++) {
        ibl_expected_set other = set;
        format_errors((ibl_pixel)s->pixel.value[i], &other);
        ok = find_error(s, &other, alone, &s->pixel.error[i]);
    }
    for (i = 0; i < s->irradiance.count && ok; i++) {
        ibl_expected_set other = set;
        other.irradiance = s->irradiance.value[i];
        if (s->irradiance.count == 1 || is_power(other.irradiance))
            ok = find_error(s, &other, alone, &s->irradiance.error[i]);
    }
    for (i = 0; i < s->lut.count && ok; i++) {
        ibl_expected_set other = set;
        if (s->lut.count == 1 || is_power(s->lut.value[i]))
            ok = make_lut(s, i, &other.lut) &&
                 find_error(s, &other, alone, &s->lut.error[i]);
    }
    if (s->irradiance.count > 1)
        blend_errors(&s->irradiance);
    if (s->lut.count > 1)
        blend_errors(&s->lut);
    return ok;
}

static int by_bytes(const void *a, const void *b)
{
    const parts *x = a, *y = b;

    if (x->pixel != y->pixel)
        return x->pixel < y->pixel ? -1 : 1;
    if (x->bytes != y->bytes)
        return x->bytes < y->bytes ? -1 : 1;
    return x->error < y->error ? -1 : x->error > y->error;
}

/* Lists the parts that no other of the same format is better than, in bytes and
 * error. */
static void list_parts(search *s)
{
    parts *all = s->parts;
    int count = 0;

    for (int p = 0; p < s->pixel.count; p++)
        for (int i = 0; i < s->irradiance.count; i++)
            for (int l = 0; l < s->lut.count; l++)
                all[count++] = parts_of(s, p, i, l);
    qsort(all, (size_t)count, sizeof *all, by_bytes);
    for (int i = 0; i < count; i++) {
        const parts *last = &all[s->part_count - 1];
        if (!s->part_count || all[i].pixel != last->pixel ||
            all[i].error < last->error)
            all[s->part_count++] = all[i];
    }
}

/* ---- what was chosen ------------------------------------------------------
 */

static void set_chain(search *s, const pick *p)
{
    ibl_opts *o = s->o;
    ibl_specular_options *to = &o->bake.specular_options;
    const chain *c = &s->chain[p->size][p->levels];

    to->size = s->size.value[p->size];
    to->levels = s->levels.value[p->levels];
    if (!s->fits)
        return;
    memcpy(o->roughness, c->layout.roughness, sizeof o->roughness);
    to->roughness = o->roughness;
}

static void set_options(search *s, const pick *p)
{
    ibl_opts *o = s->o;
    const int irradiance = s->irradiance.value[p->parts.irradiance];

    if (wants(o, IBL_OUTPUT_SPECULAR))
        set_chain(s, p);
    if (!o->engine)
        o->texels.pixel = (ibl_pixel)s->pixel.value[p->parts.pixel];
    if (irradiance > 0)
        o->bake.irradiance_options.size = irradiance;
    else
        o->only &= ~(1u << IBL_OUTPUT_IRRADIANCE);
    o->lut.size = s->lut.value[p->parts.lut];
    o->lobe_table_size = s->lobes.value[p->lobes];
    ibl_opts_select(o);
}

static void tell_chain(const search *s, const pick *p, ibl_choice *choice)
{
    const ibl_specular_layout *l = &s->chain[p->size][p->levels].layout;
    char text[IBL_CHOICE_BYTES];
    int used = snprintf(text, sizeof text, "%d level%s:", l->levels,
                        l->levels > 1 ? "s" : "");

    for (int i = 0; i < l->levels; i++)
        used += snprintf(text + used, sizeof text - (size_t)used, " %.3g",
                         l->roughness[i]);
    ibl_choice_chose(choice, "roughness", text, "%s",
                     !s->fits ? "as asked"
                     : l->mapping == IBL_ROUGHNESS_BEST
                         ? "fitted to map and materials"
                         : "exacter than the fitted ones");
    snprintf(text, sizeof text, "%d", l->size);
    ibl_choice_chose(choice, "size", text, "%s",
                     s->size.count > 1 ? "the smallest exact enough"
                                       : "as asked");
}

static const char *const f0_words[] = {
    "fitted to the levels", "fitted to the levels, for metals only",
    "fitted to the levels, for dielectrics only"};

static void tell(const search *s, const pick *p, ibl_choice *choice)
{
    const ibl_opts *o = s->o;
    char text[IBL_CHOICE_BYTES];

    if (wants(o, IBL_OUTPUT_SPECULAR))
        tell_chain(s, p, choice);
    ibl_choice_chose(
        choice, "texels",
        o->engine ? ibl_engine_pixel(o->engine)
                  : ibl_pixel_name(o->texels.pixel),
        "%s", s->pixel.count > 1 ? "the smallest exact enough" : "as asked");
    snprintf(text, sizeof text, "%d", o->bake.irradiance_options.size);
    ibl_choice_chose(
        choice, "irradiance",
        s->irradiance.value[p->parts.irradiance] ? text : "harmonics",
        "adds %.2g %% of error",
        100 * sqrt(fmax(s->irradiance.error[p->parts.irradiance], 0)));
    snprintf(text, sizeof text, "%d", o->lut.size);
    if (wants(o, IBL_OUTPUT_LUT))
        ibl_choice_chose(choice, "BRDF table", text, "adds %.2g %% of error",
                         100 * sqrt(fmax(s->lut.error[p->parts.lut], 0)));
    snprintf(text, sizeof text, "%d", o->lobe_table_size);
    if (s->table)
        ibl_choice_chose(choice, "lobe table", text, "%s",
                         f0_words[o->lobe_f0]);
}

/* The least error of chains of a size. */
static double least_of_size(search *s, int size)
{
    double least = HUGE_VAL;

    for (int k = 0; k < s->levels.count; k++)
        if (make_chain(s, size, k))
            least = fmin(least, s->chain[size][k].least);
    return least;
}

/* Why the error that was asked is not reached: larger faces would, or none. */
static void tell_limit(search *s, ibl_choice *choice)
{
    const int last = s->size.count - 1;
    int half = last;
    char text[IBL_CHOICE_BYTES];

    while (half > 0 && 2 * s->size.value[half] > s->size.value[last])
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

size_t ibl_opts_bytes(const ibl_opts *o)
{
    const ibl_pixel pixel = pixel_of(o);
    ibl_specular_layout l;
    size_t bytes = 0;

    if (wants(o, IBL_OUTPUT_SPECULAR) &&
        !ibl_specular_layout_of(&o->bake.specular_options, &l))
        bytes += chain_bytes(l.size, l.levels, pixel);
    if (wants(o, IBL_OUTPUT_LOBES))
        bytes += lobes_bytes(o, o->lobe_table_size);
    return bytes +
           small_bytes(o, pixel, o->bake.irradiance_options.size, o->lut.size);
}

/* The figures of the options as they were. */
static bool judge_usual(search *s, ibl_choice *choice)
{
    const ibl_opts *o = s->o;
    const ibl_pixel pixel = pixel_of(o);
    ibl_expected_set set = {.irradiance = wants(o, IBL_OUTPUT_IRRADIANCE)
                                              ? o->bake.irradiance_options.size
                                              : 0};
    ibl_lut lut = {0};
    const ibl_lut_options of = {.size = o->lut.size};

    format_errors(pixel, &set);
    bool ok = !ibl_specular_layout_of(&o->bake.specular_options, &set.layout);
    if (o->lut.kind == IBL_LUT_SPLIT && o->lut.size > 1) {
        ok = ok && !ibl_bake_lut(s->from->ctx, &of, &lut);
        set.lut = &lut;
    }
    ok = ok && judge(s, o, &set, &choice->usual_error);
    choice->usual_bytes = ibl_opts_bytes(o);
    ibl_lut_free(&lut);
    return ok;
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
    s->fits = s->table && !ibl_opts_given(o, "mapping") &&
              !ibl_opts_given(o, "roughness-range") && !o->of && !o->engine;
    if (!ibl_bake_source_power(from, s->power, &s->degree, &square) ||
        ibl_expectation_create(from->ctx, materials, s->power, s->degree,
                               from->width / 2, square, &s->e) ||
        !judge_usual(s, choice))
        return false;
    s->most_bytes =
        ibl_opts_given(o, "rendered-error") ? SIZE_MAX : choice->usual_bytes;
    if (s->table && !ibl_opts_given(o, "lobe-table"))
        o->lobe_table = IBL_LOBES_FITTED;
    o->lobe_f0 = f0_of(materials);
    list_sizes(s, materials);
    list_levels(s);
    list_pixels(s);
    list_irradiance(s);
    list_tables(s);
    if (!find_errors(s))
        return false;
    list_parts(s);
    return true;
}

static void search_close(search *s)
{
    for (int i = 0; i < MOST; i++)
        ibl_lut_free(&s->luts[i]);
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
                    search_all(s, choice, &best);
    if (ok) {
        choice->bytes = best.bytes;
        choice->error = sqrt(best.error);
        set_options(s, &best);
        tell(s, &best, choice);
    }
    if (ok && !choice->reached)
        tell_limit(s, choice);
    search_close(s);
    free(s);
    return ok;
}
