/* SPDX-License-Identifier: MIT */
#include "cli/rendered.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>

const char *const ibl_shader_names[] = {"auto",  "split",    "bent", "fit",
                                        "table", "two-taps", NULL};
const char *const ibl_part_names[] = {"view", "levels", "texels", "table"};

enum {
    STAGES = IBL_PARTS + 1,
    SUMS = IBL_REFERENCE_BRDF
};

ibl_rendered_options ibl_rendered_options_default(void)
{
    return (ibl_rendered_options){
        .directions = IBL_RENDERED_DIRECTIONS,
        .seed = 1,
        .roughness_count = 8,
        .roughness = {0.1, 0.2, 0.3, 0.4, 0.5, 0.7, 0.85, 1},
        .f0_count = 2,
        .f0 = {1, 0.04}};
}

/* ---- pairs of a normal and a view ------------------------------------- */

typedef struct pairs {
    size_t count;
    double *normal, *view, *mirror; /* 3 each; mirror: R */
    double *n_dot_v, *weight;
} pairs;

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void normalise(double v[3])
{
    const double length = sqrt(dot(v, v));

    for (int k = 0; k < 3; k++)
        v[k] /= length;
}

/* The direction at an angle from axis, at an azimuth. */
static void around(const double axis[3], double cosine, double azimuth,
                   double out[3])
{
    double x[3] = {fabs(axis[0]) < 0.5, fabs(axis[0]) >= 0.5, 0}, y[3];
    const double sine = sqrt(fmax(1 - cosine * cosine, 0));
    const double along = dot(x, axis);

    for (int k = 0; k < 3; k++)
        x[k] -= along * axis[k];
    normalise(x);
    for (int k = 0; k < 3; k++)
        y[k] = axis[(k + 1) % 3] * x[(k + 2) % 3] -
               axis[(k + 2) % 3] * x[(k + 1) % 3];
    for (int k = 0; k < 3; k++)
        out[k] = cosine * axis[k] +
                 sine * (cos(azimuth) * x[k] + sin(azimuth) * y[k]);
}

/* Point i of an evenly spread sequence in four dimensions (Roberts 2018, "The
 * unreasonable effectiveness of quasirandom sequences"). */
static void spread_point(int seed, unsigned stream, size_t i, double u[4])
{
    double step = 1;

    for (unsigned k = 0; k < 4; k++) {
        step /= 1.1673039782614187; /* the root of x^5 = x + 1 */
        const double x = ibl_pick_random(seed, stream, k) + (double)i * step;
        u[k] = x - floor(x);
    }
}

/* Of 20 pairs, half have R anywhere, the others within a cap around the light,
 * which narrow lobes would else miss: 5, 3 and 2 of them. */
enum {
    CAPS = 4,
    PERIOD = 20
};
static const double caps_deg[CAPS] = {180, 20, 7, 2.5};
static const int pattern[PERIOD] = {0, 1, 0, 2, 0, 1, 0, 3, 0, 1,
                                    0, 2, 0, 1, 0, 3, 0, 1, 0, 2};

static double cap_cosine(int cap)
{
    return cos(caps_deg[cap] * M_PI / 180);
}

/* The density of R over the sphere, in parts of 1 / 4 pi. */
static double density(double cosine)
{
    double sum = 0;

    for (int i = 0; i < PERIOD; i++)
        if (cosine >= cap_cosine(pattern[i]) - 1e-12)
            sum += 2.0 / PERIOD / (1 - cap_cosine(pattern[i]));
    return sum;
}

/* R is drawn first, uniform in its cap. With N at a distance of acos(N.V) from
 * it in any direction, N is uniform over the sphere as well. N.V is drawn
 * evenly: at grazing angles F0 = .04 reflects most. */
static void draw_pair(pairs *p, int seed, size_t i, size_t drawn[CAPS],
                      const double light[3])
{
    const int cap = pattern[i % PERIOD];
    double u[4], *r = p->mirror + 3 * i, *n = p->normal + 3 * i;

    spread_point(seed, (unsigned)cap, drawn[cap]++, u);
    around(light, 1 - (1 - cap_cosine(cap)) * u[0], 2 * M_PI * u[1], r);
    p->n_dot_v[i] = u[2];
    p->weight[i] = 2 * u[2] / density(dot(r, light));
    around(r, p->n_dot_v[i], 2 * M_PI * u[3], n);
    for (int k = 0; k < 3; k++)
        p->view[3 * i + (size_t)k] = 2 * p->n_dot_v[i] * n[k] - r[k];
}

static void free_pairs(pairs *p)
{
    free(p->normal);
}

static bool draw_pairs(const ibl_image *env, double yaw_deg,
                       const ibl_rendered_options *o, pairs *p)
{
    const size_t n = (size_t)o->directions;
    size_t drawn[CAPS] = {0};
    double light[1][3];

    *p = (pairs){.count = n, .normal = malloc(11 * n * sizeof(double))};
    if (!p->normal)
        return false;
    p->view = p->normal + 3 * n;
    p->mirror = p->view + 3 * n;
    p->n_dot_v = p->mirror + 3 * n;
    p->weight = p->n_dot_v + n;
    ibl_find_lights(env, yaw_deg, 1, light);
    for (size_t i = 0; i < n; i++)
        draw_pair(p, o->seed, i, drawn, light[0]);
    return true;
}

/* ---- what the shader looks up ------------------------------------------ */

/* The light that a shader takes for one pair and roughness: the mean of its
 * taps, mixed with a share of irradiance / pi. */
typedef struct look {
    int taps;
    double dir[2][3];
    double roughness, lod, diffuse;
    /* exact: the lobe of that roughness, and those of the two levels; the mean
     * over the taps */
    double lobe[3], level[2][3];
} look;

typedef struct work {
    const ibl_verify_files *files;
    const ibl_judge_level *level; /* of the specular chain */
    const ibl_cube *cube;
    int levels;
    const ibl_cube *irradiance; /* NULL: none */
    double irradiance_scale;
    ibl_ctx *ctx;
    ibl_rendered_options options;
    int step; /* parts are measured at each step-th PERIOD of pairs */
    const ibl_judged_map *map;
    ibl_reference *ref;  /* of the environment */
    ibl_reference *rest; /* of what lights leave of it */
    double mean[3];      /* of the environment */
    pairs pairs;
    double *sums;             /* of ibl_reference_brdf, by pair and roughness */
    look *looks;              /* by pair and roughness */
    double *diffuse;          /* exact irradiance / pi at the normal, by pair */
    ibl_judged_texel *errors; /* by pair */
} work;

static bool uses_table(const work *w)
{
    return w->options.shader >= IBL_SHADER_TABLE;
}

/* Whether metals and others are looked up in different ways, with a share of
 * irradiance. */
static bool takes_irradiance(const work *w)
{
    return w->options.shader >= IBL_SHADER_FIT;
}

static bool has_parts(const work *w, size_t pair)
{
    return pair / PERIOD % (size_t)w->step == 0;
}

static double limited(double x, double low, double high)
{
    return fmin(fmax(x, low), high);
}

/* mix(R, N, share), normalised. */
static void bend(const work *w, size_t i, double share, double dir[3])
{
    const double *r = w->pairs.mirror + 3 * i, *n = w->pairs.normal + 3 * i;

    for (int k = 0; k < 3; k++)
        dir[k] = r[k] + share * (n[k] - r[k]);
    normalise(dir);
}

static double mix(double a, double b, double t)
{
    return a + t * (b - a);
}

/* ibl_metallic of ibl/ibl.glsl, with the exact table. */
static double metallic_of(const work *w, size_t i, int k, double f0)
{
    const double *sum =
        w->sums + SUMS * (i * (size_t)w->options.roughness_count + (size_t)k);

    return limited((f0 - 0.04) / 0.96 * (sum[3] + sum[7]) /
                       fmax(f0 * sum[3] + sum[7], 1e-20),
                   0, 1);
}

/* ibl_lobe_fit of ibl/ibl.glsl. */
static void aim_fit(const work *w, size_t i, double metallic, look *l)
{
    const double nv = w->pairs.n_dot_v[i], r = l->roughness;
    const double a = mix(0.56, 0.68, metallic), b = mix(0.53, 0.38, metallic);
    const double c = mix(2.3, 1.5, metallic), d = mix(1.75, 1.95, metallic);

    bend(w, i, mix(1.4, 3.3, metallic) * pow(r, 3) * (1 - r) * (1 - nv),
         l->dir[0]);
    l->roughness = fmin(r * (a + b * nv), 1);
    l->diffuse = fmin(mix(0.4 + 0.8 * nv, 1, metallic) * pow(r, c + d * nv), 1);
}

/* ibl_lobe_bent of ibl/ibl.glsl. */
static void aim_bent(const work *w, size_t i, look *l)
{
    const double nv = w->pairs.n_dot_v[i], r = l->roughness;

    bend(w, i, pow(r, 2.1 + 1.8 * nv), l->dir[0]);
    l->roughness = fmin(r * (0.75 + 0.28 * nv + 0.27 * r * r), 1);
}

/* The roughness of a lod, by halving; the lod rises with it. */
static double roughness_of(const work *w, double lod)
{
    double low = w->level[0].roughness,
           high = w->level[w->levels - 1].roughness;

    for (int k = 0; k < 40; k++) {
        const double middle = 0.5 * (low + high);
        *(ibl_lod_of(&w->files->lod, middle) < lod ? &low : &high) = middle;
    }
    return 0.5 * (low + high);
}

/* ibl_lobe_fetch of ibl/ibl.glsl. */
static void aim_by_table(const work *w, size_t i, double metallic, look *l)
{
    const int taps = w->options.shader == IBL_SHADER_TWO_TAPS ? 2 : 1;
    double q[4];

    ibl_lookup_lobes(&w->files->lobes, taps, metallic, w->pairs.n_dot_v[i],
                     l->roughness, q);
    l->taps = q[3] > 0 ? 2 : 1;
    bend(w, i, q[0] - q[3], l->dir[0]);
    bend(w, i, q[0] + q[3], l->dir[1]);
    l->diffuse = q[2];
    const double most =
        ibl_lod_of(&w->files->lod, fmin(1.25 * l->roughness, 1));
    l->lod = fmin(limited(q[1], 0, 1) * (w->levels - 1),
                  limited(most, 0, w->levels - 1));
    l->roughness = roughness_of(w, l->lod);
}

static void aim(const work *w, size_t i, int k, double f0, look *l)
{
    const double metallic = metallic_of(w, i, k, f0);

    *l = (look){.taps = 1, .roughness = w->options.roughness[k]};
    switch (w->options.shader) {
    case IBL_SHADER_AUTO:
    case IBL_SHADER_SPLIT:
        bend(w, i, 0, l->dir[0]);
        break;
    case IBL_SHADER_BENT:
        aim_bent(w, i, l);
        break;
    case IBL_SHADER_FIT:
        aim_fit(w, i, metallic, l);
        break;
    case IBL_SHADER_TABLE:
    case IBL_SHADER_TWO_TAPS:
        aim_by_table(w, i, metallic, l);
        break;
    }
    if (!uses_table(w))
        l->lod =
            limited(ibl_lod_of(&w->files->lod, l->roughness), 0, w->levels - 1);
}

/* The level that a lod is in or above, or the one after it. */
static int level_of(const work *w, const look *l, int next)
{
    const int at = (int)l->lod + next;

    return at < w->levels ? at : w->levels - 1;
}

/* ---- exact lobes ------------------------------------------------------- */

/* Adds share times what ibl_reference_lobes gave. */
static void add_lobes(look *l, const double *lobe, const double *level0,
                      const double *level1)
{
    for (int c = 0; c < 3; c++) {
        l->lobe[c] += lobe[c] / l->taps;
        l->level[0][c] += level0[c] / l->taps;
        l->level[1][c] += level1[c] / l->taps;
    }
}

/* Each look has directions of its own. */
static bool find_each(const work *w, size_t looks)
{
    const size_t n = (size_t)w->options.roughness_count;
    double *dirs = malloc(2 * looks * 15 * sizeof *dirs);
    double *roughness = dirs + 6 * looks, *rgb = dirs + 12 * looks;
    size_t count = 0;

    if (!dirs)
        return false;
    for (size_t i = 0; i < looks; i++) {
        const look *l = &w->looks[i];
        for (int t = 0; t < l->taps && has_parts(w, i / n); t++) {
            for (int k = 0; k < 3; k++)
                dirs[3 * count + (size_t)k] = l->dir[t][k];
            roughness[3 * count] = l->roughness;
            for (int k = 0; k < 2; k++)
                roughness[3 * count + 1 + (size_t)k] =
                    w->level[level_of(w, l, k)].roughness;
            count++;
        }
    }
    const bool ok =
        !ibl_reference_lobes(w->rest, roughness, 3, dirs, count, rgb);
    const double *next = rgb;
    for (size_t i = 0; i < looks && ok; i++)
        for (int t = 0; t < w->looks[i].taps && has_parts(w, i / n);
             t++, next += 9)
            add_lobes(&w->looks[i], next, next + 3, next + 6);
    free(dirs);
    return ok;
}

/* All looks of a pair are along R: every roughness and level at once. */
static bool find_shared(const work *w, size_t looks)
{
    const int n = w->options.roughness_count, all = n + w->levels;
    const size_t count = w->pairs.count * (size_t)all;
    double *roughness = malloc(count * 4 * sizeof *roughness);
    double *rgb = roughness + count;

    if (!roughness)
        return false;
    for (size_t i = 0; i < count; i++) {
        const int k = (int)(i % (size_t)all);
        roughness[i] =
            k < n ? w->options.roughness[k] : w->level[k - n].roughness;
    }
    const bool ok = !ibl_reference_lobes(w->rest, roughness, all,
                                         w->pairs.mirror, w->pairs.count, rgb);
    for (size_t i = 0; i < looks && ok; i++) {
        const double *of = rgb + i / (size_t)n * (size_t)all * 3;
        look *l = &w->looks[i];
        add_lobes(l, of + 3 * (i % (size_t)n), of + 3 * (n + level_of(w, l, 0)),
                  of + 3 * (n + level_of(w, l, 1)));
    }
    free(roughness);
    return ok;
}

static bool find_diffuse(const work *w)
{
    return !ibl_reference_irradiance(w->rest, w->pairs.normal, w->pairs.count,
                                     w->diffuse);
}

static bool find_looks(const work *w, double f0)
{
    const int n = w->options.roughness_count;
    const size_t looks = w->pairs.count * (size_t)n;

    for (size_t i = 0; i < w->pairs.count; i++)
        for (int k = 0; k < n; k++)
            aim(w, i, k, f0, &w->looks[i * (size_t)n + (size_t)k]);
    return w->options.shader == IBL_SHADER_SPLIT ? find_shared(w, looks)
                                                 : find_each(w, looks);
}

/* ---- stages ------------------------------------------------------------ */

/* What the shader finds in the files. */
static void look_up(const work *w, size_t i, const look *l, double rgb[3])
{
    double tap[3], diffuse[3];

    rgb[0] = rgb[1] = rgb[2] = 0;
    for (int t = 0; t < l->taps; t++) {
        ibl_lookup_chain(w->cube, w->levels, l->dir[t], l->lod, tap);
        for (int c = 0; c < 3; c++)
            rgb[c] += tap[c] / l->taps;
    }
    if (!(l->diffuse > 0))
        return;
    ibl_lookup_cube(w->irradiance, w->pairs.normal + 3 * i, diffuse);
    for (int c = 0; c < 3; c++)
        rgb[c] += l->diffuse * (diffuse[c] / w->irradiance_scale - rgb[c]);
}

/* What the lights that were taken out of the map give. */
static void add_lights(const work *w, size_t i, int k, double f0, double rgb[3])
{
    const double r = w->options.roughness[k];

    for (int n = 0; n < w->map->light_count; n++) {
        const ibl_light *light = &w->map->lights[n];
        const double f = ibl_disc_brdf(w->files->geometry, r * r, f0,
                                       light->radius, w->pairs.normal + 3 * i,
                                       w->pairs.view + 3 * i, light->direction);
        for (int c = 0; c < 3; c++)
            rgb[c] += f * light->irradiance[c];
    }
}

/* The colour at each stage of rendered.h. */
static void shade(const work *w, size_t i, int k, double f0,
                  double stage[STAGES][3])
{
    const size_t at = i * (size_t)w->options.roughness_count + (size_t)k;
    const double *sum = w->sums + SUMS * at;
    const look *l = &w->looks[at];
    const double exact = f0 * sum[3] + sum[7], t = l->lod - floor(l->lod);
    double found[3], lit[3] = {0}, table[2] = {sum[3], sum[7]};

    look_up(w, i, l, found);
    add_lights(w, i, k, f0, lit);
    if (w->files->lut.data && !w->files->lut.kind)
        ibl_lookup_lut(&w->files->lut, w->pairs.n_dot_v[i],
                       w->options.roughness[k], table);
    for (int c = 0; c < 3; c++) {
        const double diffuse =
            l->diffuse > 0 ? l->diffuse * w->diffuse[3 * i + (size_t)c] : 0;
        const double blend =
            l->level[0][c] + t * (l->level[1][c] - l->level[0][c]);
        stage[0][c] = f0 * sum[c] + sum[4 + c];
        stage[1][c] =
            lit[c] + exact * ((1 - l->diffuse) * l->lobe[c] + diffuse);
        stage[2][c] = lit[c] + exact * ((1 - l->diffuse) * blend + diffuse);
        stage[3][c] = lit[c] + exact * found[c];
        stage[4][c] = lit[c] + (f0 * table[0] + table[1]) * found[c];
    }
}

static double distance2(const double a[3], const double b[3])
{
    double sum = 0;

    for (int c = 0; c < 3; c++)
        sum += (a[c] - b[c]) * (a[c] - b[c]);
    return sum;
}

/* Weighted sums over the pairs. */
typedef struct squares {
    double truth, wrong, light[2];
    double part_truth, part[IBL_PARTS]; /* at each step-th pair */
} squares;

static void add_pair(const work *w, size_t i, double stage[STAGES][3],
                     squares *s)
{
    static const double black[3] = {0};
    const double weight = w->pairs.weight[i];
    const double truth = weight * distance2(stage[0], black);

    s->truth += truth;
    s->wrong += weight * distance2(stage[0], stage[STAGES - 1]);
    for (int c = 0; c < 3; c++) {
        s->light[0] += weight * stage[0][c];
        s->light[1] += weight * stage[STAGES - 1][c];
    }
    if (!has_parts(w, i))
        return;
    s->part_truth += truth;
    for (int p = 0; p < IBL_PARTS; p++)
        s->part[p] += weight * distance2(stage[p], stage[p + 1]);
}

static double root_share(double part, double all)
{
    return sqrt(part / fmax(all, (double)FLT_MIN * (double)FLT_MIN));
}

/* Fills a row but for its f0 and roughness. */
static void measure(const work *w, int k, ibl_rendered_row *row)
{
    squares sums = {0};

    for (size_t i = 0; i < w->pairs.count; i++) {
        double stage[STAGES][3];
        shade(w, i, k, row->f0, stage);
        add_pair(w, i, stage, &sums);
        w->errors[i] = (ibl_judged_texel){
            .weight = w->pairs.weight[i],
            .error = ibl_relative_error(stage[STAGES - 1], stage[0], w->mean)};
    }
    const ibl_error_spread spread =
        ibl_error_spread_of(w->errors, w->pairs.count);
    row->nrmse = root_share(sums.wrong, sums.truth);
    row->median = spread.median;
    row->p95 = spread.p95;
    row->ratio = sums.light[0] > 0 ? sums.light[1] / sums.light[0] : 1;
    for (int p = 0; p < IBL_PARTS; p++)
        row->part[p] = root_share(sums.part[p], sums.part_truth);
}

static void add_mean(ibl_rendered *out, int n)
{
    ibl_rendered_row *mean = &out->rows[out->count];

    *mean = (ibl_rendered_row){.f0 = mean[-1].f0, .roughness = NAN};
    for (int k = -n; k < 0; k++) {
        mean->nrmse += mean[k].nrmse / n;
        mean->median += mean[k].median / n;
        mean->p95 += mean[k].p95 / n;
        mean->ratio += mean[k].ratio / n;
        for (int p = 0; p < IBL_PARTS; p++)
            mean->part[p] += mean[k].part[p] / n;
    }
    out->count++;
}

static bool measure_all(const work *w, ibl_rendered *out)
{
    const ibl_rendered_options *o = &w->options;

    for (int f = 0; f < o->f0_count; f++) {
        if ((f == 0 || takes_irradiance(w)) && !find_looks(w, o->f0[f]))
            return false;
        for (int k = 0; k < o->roughness_count; k++) {
            ibl_rendered_row *row = &out->rows[out->count++];
            *row = (ibl_rendered_row){.f0 = o->f0[f],
                                      .roughness = o->roughness[k]};
            measure(w, k, row);
        }
        add_mean(out, o->roughness_count);
    }
    return true;
}

/* ---- the call ---------------------------------------------------------- */

/* Finds the specular chain and the irradiance. */
static bool find_cubes(work *w, ibl_console *console)
{
    const ibl_verify_files *f = w->files;

    for (int i = f->count - 1; i >= 0; i--) {
        if (f->level[i].content == IBL_OUTPUT_SPECULAR) {
            w->level = f->level + i;
            w->cube = f->cube + i;
            w->levels++;
        } else if (f->level[i].content == IBL_OUTPUT_IRRADIANCE) {
            w->irradiance = f->cube + i;
            w->irradiance_scale = f->level[i].scale;
        }
    }
    if (!w->levels)
        return ibl_console_fail(console,
                                "no specular cube, which is what --rendered "
                                "judges: add --specular");
    return w->level->lobe == IBL_LOBE_GGX ||
           ibl_console_fail(
               console, "%s: of the lobe %s: --rendered judges ggx",
               f->path[IBL_OUTPUT_SPECULAR], ibl_lobe_name(w->level->lobe));
}

static bool choose_shader(work *w, ibl_console *console)
{
    const bool table = w->files->lobes.data, both = table && w->irradiance;
    ibl_shader *shader = &w->options.shader;

    if (*shader == IBL_SHADER_AUTO)
        *shader = both ? IBL_SHADER_TABLE : IBL_SHADER_SPLIT;
    w->step = *shader == IBL_SHADER_TWO_TAPS ? 4 : takes_irradiance(w) ? 2 : 1;
    if (uses_table(w) && !table)
        return ibl_console_fail(console,
                                "--shader %s: there is no lobe table: name it "
                                "with --lobe-table",
                                ibl_shader_names[*shader]);
    return !takes_irradiance(w) || w->irradiance ||
           ibl_console_fail(console,
                            "--shader %s: there is no irradiance map: name it "
                            "with --irradiance",
                            ibl_shader_names[*shader]);
}

static bool alloc(work *w)
{
    const size_t n = w->pairs.count, k = (size_t)w->options.roughness_count;

    w->sums = malloc(n * k * SUMS * sizeof *w->sums);
    w->looks = malloc(n * k * sizeof *w->looks);
    w->diffuse = malloc(3 * n * sizeof *w->diffuse);
    w->errors = malloc(n * sizeof *w->errors);
    return w->sums && w->looks && w->diffuse && w->errors;
}

static bool find_truth(const work *w)
{
    const ibl_rendered_options *o = &w->options;

    return !ibl_reference_brdf(w->ref, w->files->geometry, o->roughness,
                               o->roughness_count, w->pairs.normal,
                               w->pairs.view, w->pairs.count, w->sums);
}

static bool is_finite(const float *values, size_t count)
{
    size_t i = 0;

    while (i < count && isfinite(values[i]))
        i++;
    return i == count;
}

/* An error of what is not finite has no figure, and would pass any bound. */
static bool check_finite(const ibl_verify_files *f, ibl_console *console)
{
    const size_t lut = (size_t)ibl_lut_channels(f->lut.kind) *
                       (size_t)f->lut.size * (size_t)f->lut.size;
    const size_t lobes = 4 * (size_t)f->lobes.layers * (size_t)f->lobes.size *
                         (size_t)f->lobes.size;
    int bad = -1;

    for (int i = 0; i < f->count; i++) {
        const ibl_level_shape s =
            ibl_level_shape_of(f->cube[i].projection, f->cube[i].size);
        if (!is_finite(f->cube[i].data, 3 * (size_t)s.faces * (size_t)s.width *
                                            (size_t)s.height))
            bad = (int)f->level[i].content;
    }
    if (f->lut.data && !is_finite(f->lut.data, lut))
        bad = IBL_OUTPUT_LUT;
    if (f->lobes.data && !is_finite(f->lobes.data, lobes))
        bad = IBL_OUTPUT_LOBES;
    return bad < 0 ||
           ibl_console_fail(console,
                            "%s: holds values that are not finite: --rendered "
                            "has no figures for them",
                            f->path[bad]);
}

bool ibl_rendered_judge(const ibl_verify_files *files, ibl_ctx *ctx,
                        const ibl_judged_map *map,
                        const ibl_rendered_options *options,
                        ibl_console *console, ibl_rendered *out)
{
    work w = {.files = files, .ctx = ctx, .map = map, .options = *options};

    out->count = 0;
    ibl_console_progress(console, "truth", 0);
    bool ok = check_finite(files, console) && find_cubes(&w, console) &&
              choose_shader(&w, console) &&
              draw_pairs(&map->env, map->yaw_deg, options, &w.pairs) &&
              alloc(&w) &&
              !ibl_reference_create(ctx, &map->env, map->yaw_deg, &w.ref) &&
              !ibl_reference_create(ctx, ibl_judged_map_rest(map), map->yaw_deg,
                                    &w.rest) &&
              !ibl_reference_mean(w.ref, w.mean) && find_truth(&w);
    out->options = w.options;
    ibl_console_progress(console, "parts", 0);
    ok = ok && (!takes_irradiance(&w) || find_diffuse(&w)) &&
         measure_all(&w, out);
    ibl_reference_free(w.ref);
    ibl_reference_free(w.rest);
    free_pairs(&w.pairs);
    free(w.sums);
    free(w.looks);
    free(w.diffuse);
    free(w.errors);
    return ok;
}

const ibl_rendered_row *ibl_rendered_mean(const ibl_rendered *rendered, int f0)
{
    return &rendered
                ->rows[(f0 + 1) * (rendered->options.roughness_count + 1) - 1];
}
