/* SPDX-License-Identifier: MIT */
/*
 * The search. The error of a chain with the best table that it could have is
 * known at once; that of the formats, irradiance and the BRDF table is what
 * they add to a usual chain's. So the cheapest set is found by these sums. Then
 * its lobe table is made and the whole set is judged; what it has more than the
 * sum says is remembered for that chain, and the search goes on until a set
 * holds.
 */
#include "cli/choose.h"

#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

enum {
    MOST = 20, /* values of one output */
    MOST_EDGE = 2048,
    LEAST_EDGE = 4, /* of the last level */
    MOST_LEVELS = 7,
    ROUNDS = 24, /* sets whose lobe table is made */
    USUAL_LOBES = 16
};

/* How near to the least error a set must be if that asked cannot be had. */
static const double near = 1.1;

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
    double least;               /* with the best lobe table */
    double judged[MOST];        /* with a table of each size; 0: not yet */
} chain;

/* Indices of values. */
typedef struct pick {
    int size, levels, pixel, irradiance, lut, lobes;
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
    bool fits;  /* the levels' roughnesses are free */
    bool table; /* there are lobe tables */
    values size, levels, pixel, irradiance, lut, lobes;
    ibl_lut luts[MOST];
    double usual; /* the least judged over least so far; 0: none was judged */
    double ratio[MOST][MOST]; /* the same, of each number of levels and size of
                                 table; 0: none was judged */
    chain chain[MOST][MOST];
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

/* The chain of a pick as options. */
static ibl_specular_options options_of(const search *s, int size, int levels)
{
    ibl_specular_options o = s->o->bake.specular_options;

    o.size = s->size.value[size];
    o.levels = s->levels.value[levels];
    return o;
}

/* Finds the layout of a chain and its error with the best table. False: there
 * is no such chain, or after a message. */
static bool make_chain(search *s, int size, int levels)
{
    chain *c = &s->chain[size][levels];
    const int edge = s->size.value[size], count = s->levels.value[levels];
    const ibl_specular_options o = options_of(s, size, levels);
    ibl_expected_set set = {.lookup =
                                s->table ? IBL_LOOKUP_TABLE : IBL_LOOKUP_SPLIT,
                            .irradiance = -1};
    double nrmse = 0;

    if (c->layout.levels)
        return c->least >= 0;
    c->layout.levels = 1;
    c->least = -1;
    if (count > ibl_most_levels(edge) ||
        (s->levels.count > 1 && count > 1 && edge >> (count - 1) < LEAST_EDGE))
        return false;
    if (s->fits && ibl_expectation_fit(s->e, edge, count, &c->layout, &nrmse))
        return false;
    if (!s->fits && ibl_specular_layout_of(&o, &c->layout))
        return false;
    set.layout = c->layout;
    if (s->pixel.count == 1)
        format_errors((ibl_pixel)s->pixel.value[0], &set);
    if ((!s->fits || set.slope > 0) && ibl_expectation_of(s->e, &set, &nrmse))
        return false;
    c->least = nrmse * nrmse;
    return true;
}

/* A chain that was not judged is taken to be off from its least error as the
 * best of those of as many levels with a table of that size, or as the best of
 * all: none is passed over that may hold. */
static double chain_error(const search *s, int size, int levels, int lobes)
{
    const chain *c = &s->chain[size][levels];

    if (c->judged[lobes] > 0)
        return c->judged[lobes];
    const double ratio = s->ratio[levels][lobes];
    return c->least * (ratio > 0 ? ratio : s->usual > 0 ? s->usual : 1);
}

static size_t bytes_of(const search *s, const pick *p)
{
    const ibl_opts *o = s->o;
    const ibl_pixel pixel = (ibl_pixel)s->pixel.value[p->pixel];
    const chain *c = &s->chain[p->size][p->levels];
    const size_t lobes = (size_t)s->lobes.value[p->lobes];
    const size_t lut = (size_t)s->lut.value[p->lut];
    size_t bytes = 0;

    if (wants(o, IBL_OUTPUT_SPECULAR))
        bytes += chain_bytes(c->layout.size, c->layout.levels, pixel);
    if (wants(o, IBL_OUTPUT_IRRADIANCE) &&
        s->irradiance.value[p->irradiance] > 0)
        bytes += chain_bytes(s->irradiance.value[p->irradiance], 1, pixel);
    if (wants(o, IBL_OUTPUT_LUT))
        bytes += lut * lut * ibl_pixel_bytes(ibl_lut_pixel(pixel, o->lut.kind));
    if (s->table)
        bytes += lobes * lobes * IBL_LOBE_LAYERS *
                 ibl_pixel_bytes(IBL_PIXEL_RGBA16F);
    return bytes;
}

/* Keeps a pick if it is better: of fewer bytes, if its error is at most
 * `most`, or of less error, if most is 0. */
static void keep_better(const search *s, double most, pick *p, pick *best)
{
    p->bytes = bytes_of(s, p);
    p->error = chain_error(s, p->size, p->levels, p->lobes) +
               s->pixel.error[p->pixel] + s->lut.error[p->lut] +
               s->irradiance.error[p->irradiance];
    const bool fewer = p->bytes < best->bytes ||
                       (p->bytes == best->bytes && p->error < best->error);
    if (p->bytes > s->most_bytes)
        return;
    if (most > 0 ? p->error <= most && fewer : p->error < best->error)
        *best = *p;
}

/* All sets with one chain. */
static void try_others(const search *s, double most, pick *p, pick *best)
{
    for (p->pixel = 0; p->pixel < s->pixel.count; p->pixel++)
        for (p->irradiance = 0; p->irradiance < s->irradiance.count;
             p->irradiance++)
            for (p->lut = 0; p->lut < s->lut.count; p->lut++)
                for (p->lobes = 0; p->lobes < s->lobes.count; p->lobes++)
                    keep_better(s, most, p, best);
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
            if ((most <= 0 || least < best->bytes) && make_chain(s, i, k))
                try_others(s, most, &p, best);
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

/* Judges a pick, and keeps what its chain has of the error. */
static bool judge_pick(search *s, pick *p, double *nrmse)
{
    chain *c = &s->chain[p->size][p->levels];
    ibl_opts o = *s->o;
    ibl_expected_set set = {.layout = c->layout,
                            .irradiance = s->irradiance.value[p->irradiance],
                            .lut =
                                s->luts[p->lut].data ? &s->luts[p->lut] : NULL};

    o.lobe_table_size = s->lobes.value[p->lobes];
    format_errors((ibl_pixel)s->pixel.value[p->pixel], &set);
    if (!judge(s, &o, &set, nrmse))
        return false;
    const double others =
        p->error - chain_error(s, p->size, p->levels, p->lobes);
    c->judged[p->lobes] = fmax(*nrmse * *nrmse - others, 1e-12);
    const double ratio = c->judged[p->lobes] / fmax(c->least, 1e-12);
    double *same = &s->ratio[p->levels][p->lobes];
    *same = *same > 0 ? fmin(*same, ratio) : ratio;
    s->usual = s->usual > 0 ? fmin(s->usual, ratio) : ratio;
    p->error = *nrmse * *nrmse;
    return true;
}

/* Judges the sets that promise the fewest bytes with a squared error of at most
 * `most`, until no other promises fewer. *best is the one that holds or, before
 * there is any, the one of least error. False: after a message. */
static bool judge_sets(search *s, double most, pick *best)
{
    bool holds = best->error <= most;
    double nrmse = 0;
    pick p;

    for (int i = 0; i < ROUNDS && find(s, most, &p); i++) {
        if (holds && p.bytes >= best->bytes)
            return true;
        if (!judge_pick(s, &p, &nrmse))
            return false;
        const bool now = p.error <= most;
        if (now > holds || (now == holds && (now ? p.bytes < best->bytes
                                                 : p.error < best->error)))
            *best = p;
        holds |= now;
    }
    return true;
}

/* Finds the set of fewest bytes with the error that is asked or, if that cannot
 * be had, nearly the least. */
static bool search_all(search *s, ibl_choice *choice, pick *best)
{
    const double asked = choice->asked * choice->asked;
    double nrmse;
    pick least;

    *best = (pick){.error = HUGE_VAL};
    if (!judge_sets(s, asked, best))
        return false;
    choice->reached = best->error <= asked;
    if (choice->reached)
        return true;
    if (!find(s, 0, &least))
        return ibl_console_fail(s->from->console,
                                "--rendered-error %g: there is no chain of "
                                "such sizes and levels",
                                choice->asked);
    if (!judge_pick(s, &least, &nrmse))
        return false;
    if (least.error < best->error)
        *best = least;
    choice->reached = best->error <= asked;
    return judge_sets(s, choice->reached ? asked : near * near * best->error,
                      best);
}

/* ---- what may be chosen ---------------------------------------------------
 */

/* Edges up to twice the map's detail, or twice what the sharpest lobe needs
 * (ibl_specular_layout_of). */
static void list_sizes(search *s, const ibl_materials *m)
{
    const ibl_opts *o = s->o;
    double edge = s->from->width / 2.0;
    int sharpest = 0;

    if (ibl_opts_given(o, "size")) {
        add_value(&s->size, o->bake.specular_options.size);
        return;
    }
    while (m->weight[sharpest][0] <= 0 && m->weight[sharpest][1] <= 0)
        sharpest++;
    const double r = (double)sharpest / IBL_MATERIAL_STEPS;
    if (r > 0)
        edge = fmin(edge, 5 * M_PI / (r * r));
    for (int size = s->fits ? 8 : 32; size <= MOST_EDGE; size *= 2) {
        add_value(&s->size, size);
        if (size >= edge)
            break;
        if (s->fits)
            add_value(&s->size, size / 2 * 3);
    }
}

static void list_levels(search *s)
{
    const int given = s->o->bake.specular_options.levels;

    if (given || s->o->of || s->o->engine) {
        add_value(&s->levels, given);
        return;
    }
    for (int levels = s->fits ? 1 : 2; levels <= MOST_LEVELS; levels++)
        add_value(&s->levels, levels);
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
    for (int edge = 4; edge <= 32; edge *= 2)
        add_value(&s->irradiance, edge);
}

static void list_tables(search *s)
{
    const ibl_opts *o = s->o;

    if (o->lut.kind != IBL_LUT_SPLIT || !wants(o, IBL_OUTPUT_LUT) ||
        ibl_opts_given(o, "lut-size"))
        add_value(&s->lut, o->lut.size);
    else
        for (int size = 16; size <= 256; size *= 2)
            add_value(&s->lut, size);
    if (!s->table || ibl_opts_given(o, "lobe-table-size"))
        add_value(&s->lobes, o->lobe_table_size);
    else
        for (int size = 64; size >= 8; size /= 2)
            add_value(&s->lobes, size);
}

/* What the others add to the error of a chain of a middling size. */
static bool find_errors(search *s)
{
    ibl_expected_set set = {.irradiance = -1};
    double alone, nrmse = 0;
    int i = s->size.count / 2, k = s->levels.count - 1;

    while (k > 0 && !make_chain(s, i, k))
        k--;
    if (!make_chain(s, i, k))
        return true; /* and find() finds none */
    set.layout = s->chain[i][k].layout;
    set.lookup = s->table ? IBL_LOOKUP_TABLE : IBL_LOOKUP_SPLIT;
    bool ok = !ibl_expectation_of(s->e, &set, &alone);
    for (i = 0; i < s->pixel.count && ok && s->pixel.count > 1; i++) {
        ibl_expected_set other = set;
        format_errors((ibl_pixel)s->pixel.value[i], &other);
        ok = !ibl_expectation_of(s->e, &other, &nrmse);
        s->pixel.error[i] = nrmse * nrmse - alone * alone;
    }
    for (i = 0; i < s->irradiance.count && ok; i++) {
        ibl_expected_set other = set;
        other.irradiance = s->irradiance.value[i];
        ok = !ibl_expectation_of(s->e, &other, &nrmse);
        s->irradiance.error[i] = nrmse * nrmse - alone * alone;
    }
    for (i = 0; i < s->lut.count && ok && s->o->lut.kind == IBL_LUT_SPLIT &&
                wants(s->o, IBL_OUTPUT_LUT);
         i++) {
        const ibl_lut_options o = {.size = s->lut.value[i]};
        ibl_expected_set other = set;
        ok = !ibl_bake_lut(s->from->ctx, &o, &s->luts[i]);
        other.lut = o.size > 1 ? &s->luts[i] : NULL;
        ok = ok && !ibl_expectation_of(s->e, &other, &nrmse);
        s->lut.error[i] = nrmse * nrmse - alone * alone;
    }
    return ok;
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
    const int irradiance = s->irradiance.value[p->irradiance];

    if (wants(o, IBL_OUTPUT_SPECULAR))
        set_chain(s, p);
    if (!o->engine)
        o->texels.pixel = (ibl_pixel)s->pixel.value[p->pixel];
    if (irradiance > 0)
        o->bake.irradiance_options.size = irradiance;
    else
        o->only &= ~(1u << IBL_OUTPUT_IRRADIANCE);
    o->lut.size = s->lut.value[p->lut];
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
                     s->fits ? "fitted to map and materials" : "as asked");
    snprintf(text, sizeof text, "%d", l->size);
    ibl_choice_chose(choice, "size", text, "%s",
                     s->size.count > 1 ? "the smallest that holds"
                                       : "as asked");
}

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
        "%s", s->pixel.count > 1 ? "the smallest that holds" : "as asked");
    snprintf(text, sizeof text, "%d", o->bake.irradiance_options.size);
    ibl_choice_chose(choice, "irradiance",
                     s->irradiance.value[p->irradiance] ? text : "harmonics",
                     "adds %.2g %%",
                     100 * sqrt(fmax(s->irradiance.error[p->irradiance], 0)));
    snprintf(text, sizeof text, "%d", o->lut.size);
    if (wants(o, IBL_OUTPUT_LUT))
        ibl_choice_chose(choice, "BRDF table", text, "adds %.2g %%",
                         100 * sqrt(fmax(s->lut.error[p->lut], 0)));
    snprintf(text, sizeof text, "%d", o->lobe_table_size);
    if (s->table)
        ibl_choice_chose(choice, "lobe table", text, "%s",
                         "fitted to the levels");
}

/* Why the error that was asked is not reached: larger faces would, or none. */
static void tell_limit(search *s, ibl_choice *choice)
{
    const int last = s->size.count - 1;
    double error[2] = {HUGE_VAL, HUGE_VAL};
    char text[IBL_CHOICE_BYTES];

    for (int k = 0; k < s->levels.count; k++)
        for (int i = 0; i < 2; i++)
            if (last >= i && make_chain(s, last - i, k))
                error[i] = fmin(error[i], s->chain[last - i][k].least);
    snprintf(text, sizeof text, "%.3g %% is not reached, nearest %.3g %%",
             100 * choice->asked, 100 * choice->error);
    const char *why =
        error[1] <= 1.2 * error[0]
            ? "by faces of any size: a lookup has another lobe than the "
              "surface; --lights helps under suns"
        : s->most_bytes < SIZE_MAX
            ? "in the default's bytes: --rendered-error E may take more"
            : "for want of larger faces";
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
    if (wants(o, IBL_OUTPUT_IRRADIANCE))
        bytes += chain_bytes(o->bake.irradiance_options.size, 1, pixel);
    if (wants(o, IBL_OUTPUT_LUT))
        bytes += (size_t)(o->lut.size * o->lut.size) *
                 ibl_pixel_bytes(ibl_lut_pixel(pixel, o->lut.kind));
    if (wants(o, IBL_OUTPUT_LOBES))
        bytes += (size_t)(o->lobe_table_size * o->lobe_table_size) *
                 IBL_LOBE_LAYERS * ibl_pixel_bytes(IBL_PIXEL_RGBA16F);
    return bytes;
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

static bool choose(search *s, const ibl_materials *m, ibl_choice *choice)
{
    ibl_opts *o = s->o;
    pick best = {.bytes = 0};

    s->table = wants(o, IBL_OUTPUT_SPECULAR) && wants(o, IBL_OUTPUT_LOBES);
    s->fits = s->table && !ibl_opts_given(o, "mapping") &&
              !ibl_opts_given(o, "roughness-range") && !o->of && !o->engine;
    if (!judge_usual(s, choice))
        return false;
    s->most_bytes =
        ibl_opts_given(o, "rendered-error") ? SIZE_MAX : choice->usual_bytes;
    if (s->table && !ibl_opts_given(o, "lobe-table"))
        o->lobe_table = IBL_LOBES_FITTED;
    list_sizes(s, m);
    list_levels(s);
    list_pixels(s);
    list_irradiance(s);
    list_tables(s);
    if (!find_errors(s) || !search_all(s, choice, &best))
        return false;
    choice->bytes = best.bytes;
    choice->error = sqrt(best.error);
    set_options(s, &best);
    tell(s, &best, choice);
    if (!choice->reached)
        tell_limit(s, choice);
    return true;
}

bool ibl_choose(ibl_bake_source *from, const ibl_materials *materials,
                ibl_opts *o, ibl_choice *choice)
{
    search *s = calloc(1, sizeof *s);

    choice->asked = o->rendered_error;
    if (!s)
        return ibl_console_fail(from->console, "no memory for the search");
    s->from = from;
    s->o = o;
    ibl_console_progress(from->console, "choice", 0);
    const bool ok =
        ibl_bake_source_power(from, s->power, &s->degree) &&
        !ibl_expectation_create(from->ctx, materials, s->power, s->degree,
                                from->width / 2, &s->e) &&
        choose(s, materials, choice);
    for (int i = 0; i < MOST; i++)
        ibl_lut_free(&s->luts[i]);
    ibl_expectation_free(s->e);
    free(s);
    return ok;
}
