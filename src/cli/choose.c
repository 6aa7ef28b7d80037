/* SPDX-License-Identifier: MIT */
/*
 * The choice by measuring. The truth of many samples is found once; then sets
 * are baked in memory and measured along the same samples (cli/rendered.h).
 * For each number of levels one step after the other is taken that makes a set
 * better, as long as there is any, then smaller ones: a part is made coarser or
 * finer, or the roughnesses are moved. Sets are compared by their bytes and
 * what they leave of the error that they may have: what is left counts less and
 * less (a logarithmic barrier).
 */
#include "cli/choose.h"

#include <math.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include "cli/candidate.h"
#include "common/signals.h"

/* What a set is made of. */
enum {
    EDGE, /* of the first level */
    LEVELS,
    PIXEL,
    LOBES, /* edge of the lobe table */
    IRRADIANCE,
    LUT,
    PARTS
};

enum {
    SAMPLES = 2048,
    STEPS = 128,    /* of roughness */
    SHARPEST = 16,  /* of these, but 0: sharper lobes take long */
    SHARPER = 4,    /* so is the second level, after one of 0 */
    OCTAVE = 8,     /* edges of levels in an octave */
    LEAST_EDGE = 4, /* of a level */
    FIT_EDGE = 64,  /* up to which roughnesses are fitted to the materials */
    MOST_LEVELS = 7,
    MOST_EDGE = 2048,
    VALUES = 96,
    SHEEN_LEAST = 5,  /* bin: shaders take smaller roughnesses for it */
    SHEEN_SIZE = 128, /* of Charlie's whole chain, of which a part is made */
    SHEEN_TABLE = 64,
    MADE = 16,       /* of a kind that are remembered, */
    KEPT_EDGE = 128, /* of larger cubes only the last one */
};

/* How near a set must be to the least error if that asked cannot be had: within
 * this part of it, or of what is drawn right. */
static const double beyond_least = 0.3;

/* Values that a part may take, the coarsest first. */
typedef struct values {
    int count, value[VALUES];
} values;

/* A set: indices of values. Errors are squared. */
typedef struct pick {
    int at[PARTS];
    int low, high; /* roughnesses of the first and last level, / STEPS */
    size_t bytes;
    double error; /* HUGE_VAL: there are no such levels */
} pick;

/* Cubes, or a table, that were made. */
typedef struct made {
    ibl_output_kind kind;       /* SPECULAR: all cubes, and harmonics */
    int size;                   /* of the table, or of irradiance */
    ibl_pixel pixel;            /* of cubes */
    ibl_specular_layout layout; /* but of BRDF tables */
    ibl_candidate set;
} made;

typedef struct search {
    const ibl_job *from;
    ibl_opts *o;
    ibl_truth truth;
    bool fits, lobes;   /* the levels' roughnesses are free; there are tables */
    double first, last; /* roughness of the materials */
    double most;        /* squared */
    size_t most_bytes;
    values part[PARTS];
    made made[IBL_OUTPUT_COUNT][MADE];
    int made_count[IBL_OUTPUT_COUNT];
    bool failed; /* after a message: all else is worth nothing */
} search;

static int value_of(const search *s, const pick *p, int part)
{
    return s->part[part].value[p->at[part]];
}

/* The index of the least value that is not below one, or of the last. */
static int index_of(const values *v, int value)
{
    int at = 0;

    while (at < v->count - 1 && v->value[at] < value)
        at++;
    return at;
}

/* Options of the set, whose first level has at least its edge. False: there are
 * no such levels. */
static bool set_options(const search *s, const pick *p, ibl_opts *o)
{
    ibl_specular_options *to = &o->bake.specular_options;
    ibl_specular_layout l;

    *o = *s->o;
    if (!o->engine)
        o->texels.pixel = (ibl_pixel)value_of(s, p, PIXEL);
    o->lut.size = value_of(s, p, LUT);
    o->lobe_table_size = value_of(s, p, LOBES);
    if (value_of(s, p, IRRADIANCE))
        o->bake.irradiance_options.size = value_of(s, p, IRRADIANCE);
    else
        o->only &= ~(1u << IBL_OUTPUT_IRRADIANCE);
    ibl_opts_select(o);
    to->levels = value_of(s, p, LEVELS);
    to->size = value_of(s, p, EDGE);
    if (!s->fits)
        return !ibl_specular_layout_of(to, &l);
    to->roughness_min = (double)p->low / STEPS;
    to->roughness_max = (double)p->high / STEPS;
    if (p->low > p->high || (p->low > 0 && p->low < SHARPEST) ||
        (p->low == p->high) != (to->levels == 1))
        return false;
    /* The smallest whole chain of which they are a part, or a large one. */
    for (; to->size <= 2 * MOST_EDGE; to->size += 1 + to->size / 16)
        if (!ibl_specular_layout_of(to, &l) &&
            (l.size >= value_of(s, p, EDGE) || to->size > MOST_EDGE))
            return s->part[LEVELS].count < 2 ||
                   (l.size >> (l.levels - 1) >= LEAST_EDGE &&
                    (l.levels < 2 || l.roughness[1] * STEPS >= SHARPER));
    return false;
}

/* ---- measuring ---------------------------------------------------------- */

/* Outputs of o as the files give them back: SPECULAR, or a table. */
static const ibl_candidate *find_made(search *s, const ibl_opts *o,
                                      ibl_output_kind kind)
{
    const bool cubes = kind == IBL_OUTPUT_SPECULAR;
    made key = {.kind = kind};
    ibl_opts part = *o;
    made *const all = s->made[kind], *m = all;

    if (kind != IBL_OUTPUT_LUT)
        ibl_specular_layout_of(&o->bake.specular_options, &key.layout);
    if (cubes) {
        key.size = o->bake.irradiance ? o->bake.irradiance_options.size : 0;
        key.pixel = o->texels.pixel;
    } else {
        key.size = kind == IBL_OUTPUT_LUT ? o->lut.size : o->lobe_table_size;
        part.only = 1u << kind;
        part.bake.specular = part.bake.irradiance = 0;
        part.bake.sh_degree = -1;
    }
    while (m < all + MADE && memcmp(m, &key, offsetof(made, set)) != 0)
        m++;
    if (m < all + MADE)
        return &m->set;
    m = all;
    if (!cubes || key.layout.size <= KEPT_EDGE)
        m += 1 + s->made_count[kind]++ % (MADE - 1);
    ibl_candidate_free(&m->set);
    *m = key;
    return ibl_candidate_bake(s->from->ctx,
                              o->lights ? &s->from->rest : &s->from->env, &part,
                              &m->set) &&
                   ibl_candidate_round(s->from->ctx, &part, &m->set)
               ? &m->set
               : NULL;
}

/* Measures the set of some options. */
static bool measure(search *s, const ibl_opts *o, ibl_measured *m)
{
    ibl_opts cubes = *o;
    const ibl_candidate none = {0}, *c, *lut = &none, *lobes = &none;
    ibl_drawn d = {.sh_degree = 2,
                   .lights = s->from->lights,
                   .light_count = s->from->light_count};

    /* Cubes stand for flat levels, and all sets have light that is diffuse. */
    cubes.only &= ~(1u << IBL_OUTPUT_LUT | 1u << IBL_OUTPUT_LOBES);
    cubes.bake.specular_options.projection = IBL_PROJECTION_CUBE;
    cubes.bake.irradiance_options.projection = IBL_PROJECTION_CUBE;
    cubes.bake.irradiance |= cubes.bake.sh_degree < 2;
    if (ibl_opts_want(o, IBL_OUTPUT_LUT) && !o->lut.kind && o->lut.size > 1)
        lut = find_made(s, o, IBL_OUTPUT_LUT);
    if (s->lobes)
        lobes = find_made(s, o, IBL_OUTPUT_LOBES);
    c = find_made(s, &cubes, IBL_OUTPUT_SPECULAR);
    if (!lut || !lobes || !c)
        return false;
    ibl_candidate_draw(&d, c);
    d.lut = lut->lut;
    d.lobes = lobes->lobes;
    d.shader = s->lobes ? IBL_SHADER_TABLE : IBL_SHADER_SPLIT;
    if (!d.irradiance.data || (o->of && o->of->harmonics))
        d.sh = c->made.sh;
    ibl_measure(&s->truth, &d, m);
    return true;
}

static double square(double x)
{
    return x * x;
}

/* Measures a set, or sets s->failed. */
static void try_pick(search *s, pick *p)
{
    ibl_specular_layout l;
    ibl_measured m;
    ibl_opts o;

    p->error = HUGE_VAL;
    if (s->failed || !set_options(s, p, &o) ||
        ibl_specular_layout_of(&o.bake.specular_options, &l))
        return;
    p->bytes = ibl_candidate_bytes(&o);
    if (s->fits)
        p->at[EDGE] = index_of(&s->part[EDGE], l.size);
    s->failed = !measure(s, &o, &m);
    if (!s->failed)
        p->error = square(m.value[IBL_FIGURE_NRMSE]);
}

/* ---- what may be chosen ------------------------------------------------- */

/* Lists edges from a power of two to a last one, in steps of a part of each
 * octave: whole numbers. */
static void list_edges(values *v, int first, double last, int steps)
{
    for (int octave = first; octave <= last; octave *= 2)
        for (int i = 0; i < steps && v->count < VALUES; i++)
            if (octave * i % steps == 0 && octave + octave * i / steps <= last)
                v->value[v->count++] = octave + octave * i / steps;
}

/* Lists the values of the parts that neither the user nor the target fixed. */
static void list_values(search *s)
{
    const ibl_opts *o = s->o;
    const ibl_specular_options *levels = &o->bake.specular_options;
    const ibl_given *given = &o->given;
    const bool open = !o->of && !o->engine,
               cube = ibl_opts_want(o, IBL_OUTPUT_IRRADIANCE);
    const int irradiance = cube ? o->bake.irradiance_options.size : 0;
    const int as_given[PARTS] = {levels->size,         levels->levels,
                                 (int)o->texels.pixel, o->lobe_table_size,
                                 irradiance,           o->lut.size};
    values *all = s->part;
    /* Twice the default, or the map's detail, or twice what the sharpest lobe
     * needs. */
    double edge = fmax(s->from->width / 4.0, 2 * levels->size);

    if (s->first > 0)
        edge = fmin(edge, 10 * M_PI / square(s->first));
    if (!ibl_is_given(given, "size"))
        list_edges(&all[EDGE], s->fits ? LEAST_EDGE : 32,
                   fmin(fmax(edge, s->fits ? 8 : 32), MOST_EDGE),
                   s->fits ? OCTAVE : 1);
    for (int l = 1; l <= MOST_LEVELS && s->fits && !levels->levels; l++)
        all[LEVELS].value[all[LEVELS].count++] = l;
    if (open && !ibl_is_given(given, "pixel") &&
        ibl_container_holds(o->format, IBL_PIXEL_R11G11B10F))
        all[PIXEL] = (values){2,
                              {ibl_container_holds(o->format, IBL_PIXEL_RGB9E5)
                                   ? IBL_PIXEL_RGB9E5
                                   : IBL_PIXEL_R11G11B10F,
                               IBL_PIXEL_RGBA16F}};
    if (s->lobes && !ibl_is_given(given, "lobe-table-size"))
        list_edges(&all[LOBES], 4, 16, 2);
    if (cube && open && !ibl_is_given(given, "irradiance-size") &&
        !(o->bake.irradiance_options.step > 0)) {
        /* 0: harmonics, in the sidecar. */
        all[IRRADIANCE].count =
            o->bake.sh_degree >= 2 && ibl_opts_want(o, IBL_OUTPUT_JSON);
        list_edges(&all[IRRADIANCE], 4, 32, 4);
    }
    if (!o->lut.kind && ibl_opts_want(o, IBL_OUTPUT_LUT) &&
        !ibl_is_given(given, "lut-size"))
        list_edges(&all[LUT], 4, 256, 4);
    for (int i = 0; i < PARTS; i++)
        if (!all[i].count)
            all[i] = (values){1, {as_given[i]}};
}

/* ---- the search --------------------------------------------------------- */

/* How good a set is; less is better. left: what the error that it leaves is
 * worth; HUGE_VAL: only its error counts. */
static double worth(const search *s, const pick *p, double left)
{
    if (p->error == HUGE_VAL || p->bytes > s->most_bytes)
        return HUGE_VAL;
    return p->error < s->most && left < HUGE_VAL
               ? log((double)p->bytes) - left * log(1 - p->error / s->most)
               : 1e3 + log(p->error);
}

/* Improves a set by steps of parts, if their bytes count, and of roughness. */
static void improve(search *s, int step, double left, pick *best)
{
    static const int moves[][2] = {{-1, 0}, {1, 0},   {0, -1},    {0, 1},
                                   {1, 1},  {-1, -1}, {-STEPS, 0}};
    bool better = true;

    while (better) {
        better = false;
        for (int m = 0; m < 2 * PARTS + 7; m++) {
            const int part = m / 2;
            pick p = *best;
            if (part < PARTS) {
                const int to = p.at[part] + (m % 2 ? step : -step);
                const int last = s->part[part].count - 1;
                p.at[part] = to < 0 ? 0 : to > last ? last : to;
                if (left == HUGE_VAL || part == LEVELS ||
                    p.at[part] == best->at[part])
                    continue;
            } else {
                const int *move = moves[m - 2 * PARTS];
                p.low += 2 * step * move[0];
                p.low = p.low < SHARPEST ? 0 : p.low;
                p.high = (int)fmin(p.high + 2 * step * move[1], STEPS);
                if (!s->fits || (p.low == best->low && p.high == best->high))
                    continue;
            }
            try_pick(s, &p);
            if (worth(s, &p, left) <
                worth(s, best, left) - (part < PARTS ? 1e-4 : 0.01)) {
                *best = p;
                better = true;
            }
        }
    }
}

/* The set that is as fine as by default, or finer, with levels for the
 * materials. */
static pick make_fine(search *s, size_t usual)
{
    const int low = (int)(0.6 * s->first * STEPS);
    pick p = {.low = low < SHARPEST ? 0 : low,
              .high = (int)fmin(1.1 * s->last * STEPS, STEPS)};
    pick fine;

    for (int i = 0; i < PARTS; i++)
        p.at[i] = s->part[i].count - 1;
    p.at[EDGE] = index_of(&s->part[EDGE], FIT_EDGE);
    do {
        if (value_of(s, &p, LEVELS) == 1)
            p.low = p.high = (p.low + p.high) / 2;
        try_pick(s, &p);
    } while (p.error == HUGE_VAL && p.at[LEVELS]-- > 0);
    if (p.error == HUGE_VAL) {
        s->failed = true;
        ibl_console_fail((ibl_console *)&s->from->console,
                         "--%s: leaves no levels of %dx%d or more to choose "
                         "from: add --levels N, or take a larger one",
                         ibl_is_given(&s->o->given, "roughness-range")
                             ? "roughness-range"
                             : "size",
                         LEAST_EDGE, LEAST_EDGE);
        return p;
    }
    improve(s, 8, HUGE_VAL, &p);
    improve(s, 4, HUGE_VAL, &p);
    /* Larger faces, beyond the default's bytes only for the error that was
     * asked. */
    for (fine = p; p.error > s->most; fine = p.bytes <= usual ? p : fine) {
        const int edge = p.at[EDGE];
        p.at[EDGE] += s->fits ? OCTAVE : 1;
        if (p.at[EDGE] >= s->part[EDGE].count)
            return fine;
        pick mirror = p; /* which pays from some size on */
        mirror.low = 0;
        try_pick(s, &p);
        if (s->fits)
            try_pick(s, &mirror);
        if (s->fits && mirror.error < p.error)
            p = mirror;
        /* Of rough levels there are none as large as all edges. */
        if (p.at[EDGE] <= edge || p.bytes > s->most_bytes)
            return fine;
    }
    return p;
}

/* Looks for the best set of a number of levels, from the smallest chain on with
 * which a set is near that is fine else. */
static void try_levels(search *s, const pick *fine, int levels, pick *best)
{
    pick p = *fine;
    ibl_opts o;

    p.at[LEVELS] = levels;
    if (s->fits && value_of(s, &p, LEVELS) == 1)
        p.low = p.high = (p.low + p.high) / 2;
    p.error = HUGE_VAL;
    for (int edge = 0; p.error >= 4 * s->most; edge += s->fits ? OCTAVE : 1) {
        if (edge >= s->part[EDGE].count)
            return;
        p.at[EDGE] = edge;
        if (!set_options(s, &p, &o))
            continue;
        o.only &= 1u << IBL_OUTPUT_SPECULAR;
        if (ibl_candidate_bytes(&o) / 2 > best->bytes)
            return; /* texels may have half the bytes */
        try_pick(s, &p);
    }
    double left = 1;
    for (int step = 8; step; step /= 2, left /= 4) {
        improve(s, step, left, &p);
        if (p.error >= s->most || worth(s, &p, left) > worth(s, best, left) + 1)
            return;
    }
    if (p.bytes < best->bytes)
        *best = p;
}

/* ---- what was chosen ---------------------------------------------------- */

/* What a part adds to the error of a set that has its finest value. */
static const char *why(search *s, const pick *p, int part, char text[40])
{
    pick fine = *p;

    fine.at[part] = s->part[part].count - 1;
    if (!fine.at[part])
        return "as asked";
    try_pick(s, &fine);
    snprintf(text, 40, "adds %.2g %% of error",
             100 * sqrt(fmax(p->error - fine.error, 0)));
    return text;
}

/* Adds rows of the parts. */
static void tell_found(search *s, const pick *p, const ibl_opts *o,
                       ibl_choice *c)
{
    static const char *const of_f0[] = {"", ", for metals only",
                                        ", for dielectrics only"};
    const int irradiance = value_of(s, p, IRRADIANCE);
    char list[160] = "", text[40];
    ibl_specular_layout l;

    if (ibl_specular_layout_of(&o->bake.specular_options, &l))
        return;
    for (int i = 0, used = 0; i < l.levels; i++)
        used += snprintf(list + used, sizeof list - (size_t)used, " %.3g",
                         l.roughness[i]);
    ibl_choice_add(c, true, "roughness", "%d level%s:%s\t%s", l.levels,
                   l.levels > 1 ? "s" : "", list,
                   s->fits ? "fitted to map and materials" : "as asked");
    ibl_choice_add(c, true, "size", "%d\t%s", l.size,
                   s->part[EDGE].count > 1 ? "the smallest exact enough"
                                           : "as asked");
    ibl_choice_add(c, true, "texels", "%s\t%s",
                   o->engine ? ibl_engine_pixel(o->engine)
                             : ibl_pixel_name(o->texels.pixel),
                   why(s, p, PIXEL, text));
    snprintf(list, sizeof list, irradiance ? "%d" : "harmonics", irradiance);
    ibl_choice_add(c, true, "irradiance", "%s\t%s", list,
                   why(s, p, IRRADIANCE, text));
    if (ibl_opts_want(o, IBL_OUTPUT_LUT))
        ibl_choice_add(c, true, "BRDF table", "%d\t%s", o->lut.size,
                       why(s, p, LUT, text));
    if (s->lobes)
        ibl_choice_add(c, true, "lobe table", "%d\t%s%s", o->lobe_table_size,
                       why(s, p, LOBES, text), of_f0[o->lobe_f0]);
}

/* What stands in the way of a smaller error than that of the finest set:
 * levels, if half their edge costs much, or what they are looked up by. */
static void tell_limit(search *s, const pick *fine, double least, ibl_choice *c)
{
    pick half = *fine;

    half.at[EDGE] -= s->fits ? OCTAVE : 1;
    half.error = HUGE_VAL;
    if (half.at[EDGE] >= 0)
        try_pick(s, &half);
    ibl_choice_add(
        c, true, "limit", "%.3g %% cannot be reached, the least is %.3g %%\t%s",
        100 * c->asked, 100 * least,
        half.error < square(1.2) * fine->error
            ? "the lookup: it sees another lobe than the surface reflects; "
              "under suns --lights helps"
        : ibl_is_given(&s->o->given, "rendered-error")
            ? "the levels: larger faces, or more of them, help"
            : "the levels, in the default's bytes: --rendered-error E may take "
              "more");
}

/* ---- the call ----------------------------------------------------------- */

ibl_materials ibl_materials_all(void)
{
    ibl_materials m;

    for (int i = 0; i <= IBL_MATERIAL_STEPS; i++)
        for (int f = 0; f < 2; f++) {
            m.weight[i][f] = 1;
            m.diffuse[i][f] = f ? 0.18 : 0;
        }
    return m;
}

static void search_all(search *s, ibl_choice *c)
{
    pick best = {.bytes = SIZE_MAX};
    ibl_measured m;
    ibl_opts o;

    const pick fine = make_fine(s, c->usual_bytes);
    double least = fmin(sqrt(fine.error), c->usual_error);
    c->reached = least <= c->asked;
    if (!c->reached) {
        const double beyond = beyond_least * fmin(least, fmax(1 - least, 0));
        s->most = square(least + beyond);
        s->most_bytes = c->usual_bytes;
    }
    for (int l = 0; l < s->part[LEVELS].count && !s->failed; l++)
        try_levels(s, &fine, l, &best);
    if (best.bytes == SIZE_MAX && fine.error > s->most) {
        ibl_choice_add(c, true, "outputs", "as usual");
        return;
    }
    if (best.bytes == SIZE_MAX)
        best = fine;
    s->failed |= !set_options(s, &best, &o) || !measure(s, &o, &m);
    if (s->failed)
        return;
    best.error = square(m.value[IBL_FIGURE_NRMSE]);
    c->bytes = ibl_candidate_bytes(&o);
    c->error = m.value[IBL_FIGURE_NRMSE];
    c->standard_error = m.error[IBL_FIGURE_NRMSE];
    c->reached |= c->error <= c->asked;
    tell_found(s, &best, &o, c);
    if (!c->reached)
        tell_limit(s, &fine, fmin(least, c->error), c);
    *s->o = o;
}

/* Finds the truth and the figures of the options as they are, then searches.
 * Layers that no material looks up are left out. */
bool ibl_choose(const ibl_job *from, const ibl_materials *materials,
                ibl_opts *o, ibl_choice *choice)
{
    search *s = ibl_need(calloc(1, sizeof *s));
    ibl_truth_options of = ibl_truth_options_default();
    ibl_measured usual;
    bool has[2] = {false, false};

    ibl_console_progress((ibl_console *)&from->console, "choice", 0);
    choice->asked = o->rendered_error;
    s->from = from;
    s->o = o;
    s->most = square(choice->asked);
    s->lobes = ibl_opts_want(o, IBL_OUTPUT_SPECULAR) &&
               ibl_opts_want(o, IBL_OUTPUT_LOBES);
    s->fits = !ibl_is_given(&o->given, "mapping") &&
              !ibl_is_given(&o->given, "roughness-range") && !o->of &&
              !o->engine;
    for (int i = IBL_MATERIAL_STEPS; i >= 0; i--)
        for (int f = 0; f < 2; f++)
            if (materials->weight[i][f] > 0) {
                has[f] = true;
                s->first = (double)i / IBL_MATERIAL_STEPS;
                s->last = fmax(s->last, s->first);
            }
    of.directions = SAMPLES;
    of.geometry = o->lut.geometry;
    of.materials = materials;
    s->failed = !ibl_truth_make(from->ctx, &from->env, o->bake.yaw_deg, &of,
                                &s->truth) ||
                !measure(s, o, &usual);
    if (!s->failed) {
        choice->usual_bytes = choice->bytes = ibl_candidate_bytes(o);
        choice->usual_error = choice->error = usual.value[IBL_FIGURE_NRMSE];
        choice->standard_error = usual.error[IBL_FIGURE_NRMSE];
        s->most_bytes = ibl_is_given(&o->given, "rendered-error")
                            ? SIZE_MAX
                            : choice->usual_bytes;
        o->lobe_f0 = has[0] && has[1] ? IBL_F0_BOTH
                     : has[0]         ? IBL_F0_METALS
                                      : IBL_F0_DIELECTRICS;
        list_values(s);
        search_all(s, choice);
    }
    for (int i = 0; i < IBL_OUTPUT_COUNT * MADE; i++)
        ibl_candidate_free(&s->made[i / MADE][i % MADE].set);
    ibl_truth_free(&s->truth);
    const bool ok = !s->failed;
    free(s);
    return ok;
}

/* ---- what follows from the materials alone ------------------------------ */

bool ibl_scenes_sheen(const ibl_scenes *s, const ibl_opts *o, ibl_opts *sheen,
                      ibl_choice *c)
{
    const ibl_survey_bin *bins = s->survey.sheen;
    ibl_specular_options *levels = &sheen->bake.specular_options;
    ibl_specular_layout l;
    int first = 0, last = IBL_SURVEY_BINS - 1;

    if (!(ibl_survey_share(bins) > 0))
        return false;
    if (o->of || o->engine || !ibl_opts_want(o, IBL_OUTPUT_SPECULAR)) {
        ibl_choice_add(c, true, "sheen",
                       "none\tnot in such files: bake it apart with --lobe "
                       "charlie");
        return false;
    }
    *sheen = *o;
    sheen->only &= 1u << IBL_OUTPUT_SPECULAR | 1u << IBL_OUTPUT_JSON |
                   /* which a set of that table has */
                   (o->lut.kind != IBL_LUT_CHARLIE) << IBL_OUTPUT_LUT;
    sheen->lobe_table = IBL_LOBES_NO;
    sheen->lut = ibl_lut_options_default(); /* what was given is of split */
    sheen->lut.kind = IBL_LUT_CHARLIE;
    sheen->lut.size = SHEEN_TABLE;
    sheen->bake.skybox = 0;
    sheen->sh_format = IBL_SH_NONE;
    sheen->preview = NULL;
    /* Levels for the roughnesses of sheen alone. */
    while (bins[first].share <= 0)
        first++;
    while (bins[last].share <= 0)
        last--;
    *levels = ibl_specular_options_default();
    levels->lobe = IBL_LOBE_CHARLIE;
    levels->size = SHEEN_SIZE;
    levels->projection = o->bake.specular_options.projection;
    levels->roughness_min = fmax(first, SHEEN_LEAST) / (IBL_SURVEY_BINS - 1.0);
    levels->roughness_max = fmax(last, SHEEN_LEAST) / (IBL_SURVEY_BINS - 1.0);
    ibl_opts_select(sheen);
    snprintf(sheen->stem, sizeof sheen->stem, "%.240s_charlie", o->name);
    sheen->name = sheen->stem;
    if (ibl_specular_layout_of(levels, &l))
        return false;
    c->bytes += ibl_candidate_bytes(sheen);
    ibl_choice_add(c, true, "sheen",
                   "Charlie, size %d, %d level%s\tfitted to its roughness; not "
                   "in the rendered error",
                   l.size, l.levels, l.levels > 1 ? "s" : "");
    return true;
}
