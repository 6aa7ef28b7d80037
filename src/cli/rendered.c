/* SPDX-License-Identifier: MIT */
#include "cli/rendered.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

const char *const ibl_figure_names[] = {"nrmse", "median", "p95",  "ratio",
                                        "view",  "set",    "table"};

ibl_truth_options ibl_truth_options_default(void)
{
    return (ibl_truth_options){
        .directions = IBL_RENDERED_DIRECTIONS,
        .seed = 1,
        .roughness_count = 8,
        .roughness = {0.1, 0.2, 0.3, 0.4, 0.5, 0.7, 0.85, 1},
        .f0_count = 2,
        .f0 = {1, 0.04}};
}

void ibl_drawn_chain(ibl_drawn *set, const ibl_cube *chain,
                     const ibl_specular_layout *layout)
{
    set->levels = layout->levels;
    set->lod = (ibl_lod){.layout = *layout};
    for (int l = 0; l < layout->levels; l++) {
        set->roughness[l] = layout->roughness[l];
        set->level[l] = (ibl_cube){.size = ibl_cube_edge(chain->size, l),
                                   .levels = 1,
                                   .data = ibl_cube_face(chain, l, 0),
                                   .projection = chain->projection};
    }
}

bool ibl_drawn_needs_irradiance(const ibl_drawn *set)
{
    return !set->levels || set->shader >= IBL_SHADER_FIT;
}

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

/* ---- where the light is ---------------------------------------------------
 */

enum {
    COLUMNS = 64, /* of the reduced map, and half as many rows */
    CELLS = COLUMNS * COLUMNS / 2,
    DIMENSIONS = 6
};

/* A part of the map as one light. */
typedef struct cell {
    double direction[3];
    double share;  /* of the samples that are drawn towards lights */
    double spread; /* 1 - the cosine of a half vector's distance from the
                      normal, below which it makes no difference */
} cell;

/* Adds the light of the map's pixels to the cells: direction is the sum of
 * those times light, share the light. */
static void add_light(const ibl_image *env, double yaw_deg, cell *cells)
{
    const int columns = env->width < COLUMNS ? env->width : COLUMNS;
    const int rows = env->height < COLUMNS / 2 ? env->height : COLUMNS / 2;
    const float *p = env->data;

    for (long long y = 0; y < env->height; y++) {
        const double theta = M_PI * ((double)y + 0.5) / env->height;
        for (long long x = 0; x < env->width; x++, p += 3) {
            const double phi =
                (((double)x + 0.5) / env->width - 0.5) * 2 * M_PI -
                yaw_deg * M_PI / 180;
            const double light =
                sin(theta) * ((double)p[0] + (double)p[1] + (double)p[2]);
            cell *c = &cells[y * rows / env->height * COLUMNS +
                             x * columns / env->width];
            c->direction[0] += light * sin(theta) * cos(phi);
            c->direction[1] += light * cos(theta);
            c->direction[2] += light * sin(theta) * sin(phi);
            c->share += light;
        }
    }
}

/* Samples are drawn half by light, half by its square over the room that it
 * takes. Returns whether there is any light. */
static bool share_out(const ibl_image *env, cell *cells)
{
    const double pixel = M_PI / env->height;
    double light = 0, squares = 0;

    for (int i = 0; i < CELLS; i++) {
        cell *c = &cells[i];
        if (!(c->share > 0))
            continue;
        const double length = sqrt(dot(c->direction, c->direction));
        /* The half vector turns by half the angle. */
        c->spread =
            fmax(1 - length / c->share, 0) / 4 + pixel * pixel / 64 + 1e-6;
        for (int k = 0; k < 3; k++)
            c->direction[k] /= length;
        light += c->share;
        squares += c->share * c->share / (c->spread + 1e-4);
    }
    for (int i = 0; i < CELLS && light > 0; i++)
        cells[i].share *= 0.5 / light + 0.5 * cells[i].share /
                                            (cells[i].spread + 1e-4) / squares;
    return light > 0;
}

/* ---- samples --------------------------------------------------------------
 */

/* Point i of an evenly spread sequence (Roberts 2018, "The unreasonable
 * effectiveness of quasirandom sequences"). */
static void spread_point(int seed, unsigned stream, size_t i,
                         double u[DIMENSIONS])
{
    double step = 1;

    for (unsigned k = 0; k < DIMENSIONS; k++) {
        step /= 1.1127756842787055; /* the root of x^7 = x + 1 */
        const double x = ibl_pick_random(seed, stream, k) + (double)i * step;
        u[k] = x - floor(x);
    }
}

/* The density of a normal at a distance of acos(cosine) from the half vector:
 * the same number in each octave of the distance. */
static double density_around(const cell *c, double cosine)
{
    const double e = c->spread, x = fmax(1 - cosine, 0);

    return 1 / (2 * M_PI * (x + e) * log((2 + e) / e));
}

/* Draws a normal and a view; u[0] says which way. */
static void draw(const cell *cells, const double u[DIMENSIONS], bool lights,
                 double normal[3], double view[3])
{
    const cell *c = cells;
    double up[3] = {0, 1, 0}, half[3], sum = 2 * u[0];

    if (!lights || u[0] >= 0.5) { /* R, then N, then V */
        around(up, 1 - 2 * u[1], 2 * M_PI * u[2], half);
        around(half, u[3], 2 * M_PI * u[4], normal);
        for (int k = 0; k < 3; k++)
            view[k] = 2 * u[3] * normal[k] - half[k];
        return;
    }
    for (; c < cells + CELLS - 1 && sum >= c->share; c++)
        sum -= c->share;
    while (!(c->share > 0)) /* the sum of shares is 1 up to rounding */
        c--;
    around(c->direction, 2 * u[1] * u[1] - 1, 2 * M_PI * u[2], view);
    for (int k = 0; k < 3; k++)
        half[k] = c->direction[k] + view[k];
    normalise(half);
    around(half, 1 + c->spread - c->spread * pow(2 / c->spread + 1, u[3]),
           2 * M_PI * u[4], normal);
}

/* What a pair stands for: its density, N.V / 4 pi^2, over that by which it is
 * drawn. */
static double weight_of(const cell *cells, bool lights, const double normal[3],
                        const double view[3])
{
    double density = 0;

    for (const cell *c = cells; c < cells + CELLS && lights; c++)
        if (c->share > 0) {
            double half[3];
            for (int k = 0; k < 3; k++)
                half[k] = c->direction[k] + view[k];
            normalise(half);
            density += c->share / fmax(dot(half, view), 1e-9) *
                       density_around(c, dot(half, normal));
        }
    const double even = 1 / M_PI;
    return 2 * dot(normal, view) /
           (lights ? 0.5 * even + 0.5 * density : even) / M_PI;
}

/* The material at u of the whole: bin i, F0 of f. */
static void pick_material(const ibl_materials *m, double u, ibl_sample *s)
{
    double sum = 0, share[IBL_MATERIAL_STEPS + 1][2];
    int at = 0;

    /* In proportion to what they add to a picture. */
    for (int i = 0; i < 2 * (IBL_MATERIAL_STEPS + 1); i++)
        sum += share[i / 2][i % 2] =
            m->weight[i / 2][i % 2] *
            (i % 2 ? m->diffuse[i / 2][1] + 0.1 : m->diffuse[i / 2][0] + 1);
    for (u *= sum; at < 2 * IBL_MATERIAL_STEPS + 1; at++) {
        if (u < share[at / 2][at % 2])
            break;
        u -= share[at / 2][at % 2];
    }
    while (at && !(share[at / 2][at % 2] > 0))
        at--;
    s->roughness = (double)(at / 2) / IBL_MATERIAL_STEPS;
    s->f0 = at % 2 ? 0.04 : 1;
    s->albedo = m->diffuse[at / 2][at % 2];
    s->weight *= m->weight[at / 2][at % 2] / share[at / 2][at % 2];
}

static void draw_samples(const cell *cells, bool lights,
                         const ibl_materials *materials, ibl_truth *t)
{
    const ibl_truth_options *o = &t->options;
    size_t point = 0;
    unsigned batch = 0;

    for (int i = 0; i < o->directions; i++) {
        const unsigned of =
            (unsigned)((long long)i * IBL_BATCHES / o->directions);
        ibl_sample *s = &t->sample[i];
        double u[DIMENSIONS];
        if (of != batch)
            point = 0;
        batch = of;
        do { /* views from below the surface are drawn again */
            spread_point(o->seed, batch, point++, u);
            draw(cells, u, lights, s->normal, s->view);
            s->n_dot_v = dot(s->normal, s->view);
        } while (s->n_dot_v < 1e-4);
        s->weight = weight_of(cells, lights, s->normal, s->view);
        for (int k = 0; k < 3; k++)
            s->mirror[k] = 2 * s->n_dot_v * s->normal[k] - s->view[k];
        if (materials)
            pick_material(materials, u[5], s);
    }
    for (int row = 0; row < t->rows && !materials; row++)
        for (int i = 0; i < o->directions; i++) {
            ibl_sample *s = &t->sample[row * o->directions + i];
            *s = t->sample[i];
            s->roughness = o->roughness[row % o->roughness_count];
            s->f0 = o->f0[row / o->roughness_count];
        }
}

/* ---- the truth -------------------------------------------------------------
 */

/* Exact colours of the samples whose roughness is among `roughness`: all of a
 * grid, along the directions; one of materials. */
static bool find_some(const ibl_reference *ref, ibl_truth *t,
                      const double *roughness, int n, double *buffer)
{
    const size_t pairs = (size_t)t->options.directions;
    double *normal = buffer, *view = normal + 3 * pairs;
    double *sums = view + 3 * pairs;
    size_t count = 0;

    for (size_t i = 0; i < pairs; i++)
        if (t->rows > 1 || t->sample[i].roughness == roughness[0]) {
            memcpy(normal + 3 * count, t->sample[i].normal, 3 * sizeof *normal);
            memcpy(view + 3 * count++, t->sample[i].view, 3 * sizeof *view);
        }
    if (count && ibl_reference_brdf(ref, t->options.geometry, roughness, n,
                                    normal, view, count, sums))
        return false;
    for (size_t row = 0; row < (size_t)t->rows; row++)
        for (size_t i = 0, at = 0; i < pairs; i++) {
            ibl_sample *s = &t->sample[row * pairs + i];
            if (t->rows == 1 && s->roughness != roughness[0])
                continue;
            const double *sum = sums + IBL_REFERENCE_BRDF *
                                           (at++ * (size_t)n + row % (size_t)n);
            for (int c = 0; c < 3; c++)
                s->truth[c] += s->f0 * sum[c] + sum[4 + c];
            s->table[0] = sum[3];
            s->table[1] = sum[7];
        }
    return true;
}

static bool find_truth(const ibl_reference *ref, bool materials, ibl_truth *t)
{
    const ibl_truth_options *o = &t->options;
    const size_t pairs = (size_t)o->directions;
    double *buffer =
        malloc(pairs * sizeof *buffer *
               (size_t)(9 + IBL_REFERENCE_BRDF *
                                (materials ? 1 : o->roughness_count)));
    bool ok = buffer && !ibl_reference_mean(ref, t->mean);

    if (ok && materials) {
        double *diffuse = buffer + 3 * pairs;
        for (size_t i = 0; i < pairs; i++)
            memcpy(buffer + 3 * i, t->sample[i].normal, 3 * sizeof *buffer);
        ok = !ibl_reference_irradiance(ref, buffer, pairs, diffuse);
        for (size_t i = 0; i < 3 * pairs && ok; i++)
            t->sample[i / 3].truth[i % 3] =
                t->sample[i / 3].albedo * diffuse[i];
        for (int k = 0; k <= IBL_MATERIAL_STEPS && ok; k++) {
            const double roughness = (double)k / IBL_MATERIAL_STEPS;
            ok = find_some(ref, t, &roughness, 1, buffer);
        }
    } else if (ok) {
        ok = find_some(ref, t, o->roughness, o->roughness_count, buffer);
    }
    free(buffer);
    return ok;
}

bool ibl_truth_make(ibl_ctx *ctx, const ibl_image *env, double yaw_deg,
                    const ibl_truth_options *options, ibl_truth *out)
{
    const ibl_materials *materials = options->materials;
    cell *cells = calloc(CELLS, sizeof *cells);
    ibl_reference *ref = NULL;

    *out = (ibl_truth){
        .options = *options,
        .rows = materials ? 1 : options->roughness_count * options->f0_count};
    out->options.materials = NULL;
    out->sample =
        calloc((size_t)(out->rows * options->directions), sizeof *out->sample);
    bool ok =
        cells && out->sample && !ibl_reference_create(ctx, env, yaw_deg, &ref);
    if (ok) {
        add_light(env, yaw_deg, cells);
        draw_samples(cells, share_out(env, cells), materials, out);
        ok = find_truth(ref, materials, out);
    }
    ibl_reference_free(ref);
    free(cells);
    return ok;
}

void ibl_truth_free(ibl_truth *t)
{
    free(t->sample);
    *t = (ibl_truth){0};
}

/* ---- what the shader looks up ------------------------------------------ */

/* The light that a shader takes for a sample: the mean of its taps, mixed with
 * a share of irradiance / pi. */
typedef struct look {
    int taps;
    double dir[2][3];
    double roughness, lod, diffuse;
} look;

static double limited(double x, double low, double high)
{
    return fmin(fmax(x, low), high);
}

static double mix(double a, double b, double t)
{
    return a + t * (b - a);
}

/* mix(R, N, share), normalised. */
static void bend(const ibl_sample *s, double share, double dir[3])
{
    for (int k = 0; k < 3; k++)
        dir[k] = mix(s->mirror[k], s->normal[k], share);
    normalise(dir);
}

/* The roughness of a lod, by halving; the lod rises with it. */
static double roughness_of(const ibl_drawn *set, double lod)
{
    double low = set->roughness[0], high = set->roughness[set->levels - 1];

    for (int k = 0; k < 40; k++) {
        const double middle = 0.5 * (low + high);
        *(ibl_lod_of(&set->lod, middle) < lod ? &low : &high) = middle;
    }
    return 0.5 * (low + high);
}

/* ibl_lobe_fetch of ibl/ibl.glsl. */
static void aim_by_table(const ibl_drawn *set, const ibl_sample *s,
                         double metallic, look *l)
{
    const int taps = set->shader == IBL_SHADER_TWO_TAPS ? 2 : 1;
    const double last = set->levels - 1;
    double q[4];

    ibl_lookup_lobes(&set->lobes, taps, metallic, s->n_dot_v, s->roughness, q);
    l->taps = q[3] > 0 ? 2 : 1;
    bend(s, q[0] - q[3], l->dir[0]);
    bend(s, q[0] + q[3], l->dir[1]);
    l->diffuse = q[2];
    l->lod = fmin(
        limited(q[1], 0, 1) * last,
        limited(ibl_lod_of(&set->lod, fmin(1.25 * s->roughness, 1)), 0, last));
    l->roughness = roughness_of(set, l->lod);
}

/* ibl_lobe_split and so on of ibl/ibl.glsl. */
static void aim(const ibl_drawn *set, const ibl_sample *s, look *l)
{
    const double nv = s->n_dot_v, r = s->roughness;
    /* ibl_metallic, with the exact table. */
    const double m =
        limited((s->f0 - 0.04) / 0.96 * (s->table[0] + s->table[1]) /
                    fmax(s->f0 * s->table[0] + s->table[1], 1e-20),
                0, 1);
    double share = 0;

    *l = (look){.taps = 1, .roughness = r};
    if (!set->levels) {
        l->taps = 0;
        l->diffuse = 1;
        return;
    }
    if (set->shader >= IBL_SHADER_TABLE) {
        aim_by_table(set, s, m, l);
        return;
    }
    if (set->shader == IBL_SHADER_BENT) {
        share = pow(r, 2.1 + 1.8 * nv);
        l->roughness = fmin(r * (0.75 + 0.28 * nv + 0.27 * r * r), 1);
    } else if (set->shader == IBL_SHADER_FIT) {
        share = mix(1.4, 3.3, m) * pow(r, 3) * (1 - r) * (1 - nv);
        l->roughness =
            fmin(r * (mix(0.56, 0.68, m) + mix(0.53, 0.38, m) * nv), 1);
        l->diffuse =
            fmin(mix(0.4 + 0.8 * nv, 1, m) *
                     pow(r, mix(2.3, 1.5, m) + mix(1.75, 1.95, m) * nv),
                 1);
    }
    bend(s, share, l->dir[0]);
    l->lod = limited(ibl_lod_of(&set->lod, l->roughness), 0, set->levels - 1);
}

/* ---- exact lobes ------------------------------------------------------- */

/* What parts are measured by: exact lobes at the looks and irradiance / pi at
 * the normals, of each sample. */
static double *find_exact(const ibl_truth *t, const ibl_drawn *set,
                          const ibl_reference *rest)
{
    const size_t pairs = (size_t)t->options.directions;
    const size_t samples = (size_t)t->rows * pairs;
    /* Without a share of irradiance F0 makes no difference. */
    const size_t own = set->shader < IBL_SHADER_FIT && t->rows > 1
                           ? pairs * (size_t)t->options.roughness_count
                           : samples;
    double *exact = calloc(20 * samples, sizeof *exact);
    double *dirs = exact + 6 * samples, *roughness = dirs + 6 * samples;
    double *rgb = roughness + 2 * samples;
    size_t count = 0;
    look l;

    if (!exact)
        return NULL;
    for (size_t i = 0; i < own; i++) {
        aim(set, &t->sample[i], &l);
        for (int k = 0; k < l.taps; k++, count++) {
            memcpy(dirs + 3 * count, l.dir[k], sizeof l.dir[k]);
            roughness[count] = l.roughness;
        }
    }
    bool ok = !ibl_reference_lobes(rest, roughness, 1, dirs, count, rgb);
    const double *next = rgb;
    for (size_t i = 0; i < own; i++) {
        aim(set, &t->sample[i], &l);
        for (int k = 0; k < 3 * l.taps; k++)
            exact[6 * i + (size_t)(k % 3)] += *next++ / l.taps;
    }
    for (size_t i = own; i < samples; i++)
        memcpy(exact + 6 * i, exact + 6 * (i - own), 3 * sizeof *exact);
    for (size_t i = 0; i < pairs; i++)
        memcpy(dirs + 3 * i, t->sample[i].normal, 3 * sizeof *dirs);
    ok = ok && !ibl_reference_irradiance(rest, dirs, pairs, rgb);
    for (size_t i = 0; i < samples; i++)
        memcpy(exact + 6 * i + 3, rgb + 3 * (i % pairs), 3 * sizeof *exact);
    if (ok)
        return exact;
    free(exact);
    return NULL;
}

/* ---- colours ------------------------------------------------------------ */

enum {
    STAGES = 4, /* truth, exact lookups, lookups in the set, its table */
    LAST = STAGES - 1
};

/* What the lights that were taken out of the map give. */
static void add_lights(const ibl_truth *t, const ibl_drawn *set,
                       const ibl_sample *s, double rgb[3])
{
    for (const ibl_light *l = set->lights; l < set->lights + set->light_count;
         l++) {
        const double f =
            ibl_disc_brdf(t->options.geometry, s->roughness * s->roughness,
                          s->f0, l->radius, s->normal, s->view, l->direction) +
            s->albedo / M_PI * fmax(dot(s->normal, l->direction), 0);
        for (int c = 0; c < 3; c++)
            rgb[c] += f * l->irradiance[c];
    }
}

static void look_up_irradiance(const ibl_drawn *set, const double normal[3],
                               double rgb[3])
{
    if (set->sh) {
        ibl_lookup_sh(set->sh, set->sh_degree, normal, rgb);
        return;
    }
    ibl_lookup_cube(&set->irradiance, normal, rgb);
    for (int c = 0; c < 3; c++)
        rgb[c] /= set->irradiance_scale;
}

/* Colours of the stages; those between the first and the last only if there are
 * exact lobes. */
static void shade(const ibl_truth *t, const ibl_drawn *set, const ibl_sample *s,
                  const double *exact, double stage[STAGES][3])
{
    double seen[3] = {0}, lit[3] = {0}, diffuse[3] = {0}, tap[3];
    double table[2] = {s->table[0], s->table[1]};
    look l;

    aim(set, s, &l);
    for (int k = 0; k < l.taps; k++) {
        ibl_lookup_chain(set->level, set->levels, l.dir[k], l.lod, tap);
        for (int c = 0; c < 3; c++)
            seen[c] += tap[c] / l.taps;
    }
    if (l.diffuse > 0 || s->albedo > 0)
        look_up_irradiance(set, s->normal, diffuse);
    if (set->lut.data)
        ibl_lookup_lut(&set->lut, s->n_dot_v, s->roughness, table);
    add_lights(t, set, s, lit);
    const double reflects = s->f0 * s->table[0] + s->table[1];
    for (int c = 0; c < 3; c++) {
        const double found = mix(seen[c], diffuse[c], l.diffuse);
        const double rest = lit[c] + s->albedo * diffuse[c];
        stage[0][c] = s->truth[c];
        stage[1][c] =
            exact ? lit[c] + s->albedo * exact[3 + c] +
                        reflects * mix(exact[c], exact[3 + c], l.diffuse)
                  : 0;
        stage[2][c] = rest + reflects * found;
        stage[3][c] = rest + (s->f0 * table[0] + table[1]) * found;
    }
}

/* ---- figures --------------------------------------------------------------
 */

/* Weighted sums over the samples of a batch. */
typedef struct sums {
    double truth, wrong, light[2], part[LAST];
} sums;

typedef struct seen {
    double error, weight;
    int batch;
} seen;

static int by_error(const void *a, const void *b)
{
    const seen *x = a, *y = b;
    return (x->error > y->error) - (x->error < y->error);
}

/* The least error that a part of the weight does not exceed, without a batch.
 * The list is sorted. */
static double quantile(const seen *list, int count, int batch, double part)
{
    double total = 0, sum = 0;

    for (int i = 0; i < count; i++)
        total += list[i].batch == batch ? 0 : list[i].weight;
    for (int i = 0; i < count; i++) {
        sum += list[i].batch == batch ? 0 : list[i].weight;
        if (sum >= part * total)
            return list[i].error;
    }
    return 0;
}

/* The figures without a batch; -1: of all. */
static void find_figures(const sums of[IBL_BATCHES], const seen *list,
                         int count, int batch, double value[IBL_FIGURES])
{
    sums all = {0};

    for (int b = 0; b < IBL_BATCHES; b++) {
        if (b == batch)
            continue;
        all.truth += of[b].truth;
        all.wrong += of[b].wrong;
        for (int k = 0; k < 2; k++)
            all.light[k] += of[b].light[k];
        for (int k = 0; k < LAST; k++)
            all.part[k] += of[b].part[k];
    }
    const double truth = fmax(all.truth, (double)FLT_MIN * (double)FLT_MIN);
    value[IBL_FIGURE_NRMSE] = sqrt(all.wrong / truth);
    value[IBL_FIGURE_MEDIAN] = quantile(list, count, batch, 0.5);
    value[IBL_FIGURE_P95] = quantile(list, count, batch, 0.95);
    value[IBL_FIGURE_RATIO] =
        all.light[0] > 0 ? all.light[1] / all.light[0] : 1;
    for (int k = 0; k < LAST; k++)
        value[IBL_FIGURE_VIEW + k] = sqrt(all.part[k] / truth);
}

double ibl_jackknife(const double without[IBL_BATCHES])
{
    double mean = 0, square = 0;

    for (int b = 0; b < IBL_BATCHES; b++)
        mean += without[b] / IBL_BATCHES;
    for (int b = 0; b < IBL_BATCHES; b++)
        square += (without[b] - mean) * (without[b] - mean);
    return sqrt(square * (IBL_BATCHES - 1) / IBL_BATCHES);
}

static void find_errors(ibl_measured *m)
{
    for (int f = 0; f < IBL_FIGURES; f++) {
        double without[IBL_BATCHES];
        for (int b = 0; b < IBL_BATCHES; b++)
            without[b] = m->without[b][f];
        m->error[f] = ibl_jackknife(without);
    }
}

static double distance2(const double a[3], const double b[3])
{
    double sum = 0;

    for (int c = 0; c < 3; c++)
        sum += (a[c] - b[c]) * (a[c] - b[c]);
    return sum;
}

static void measure_row(const ibl_truth *t, const ibl_drawn *set,
                        const ibl_sample *samples, const double *exact,
                        seen *list, double *square, ibl_measured *out)
{
    const int n = t->options.directions;
    sums of[IBL_BATCHES] = {{0}};

    for (int i = 0; i < n; i++) {
        const ibl_sample *s = &samples[i];
        const int batch = (int)((long long)i * IBL_BATCHES / n);
        double stage[STAGES][3];
        sums *to = &of[batch];
        shade(t, set, s, exact ? exact + 6 * i : NULL, stage);
        const double wrong = s->weight * distance2(stage[LAST], stage[0]);
        to->truth += s->weight * dot(stage[0], stage[0]);
        to->wrong += wrong;
        for (int c = 0; c < 3; c++) {
            to->light[0] += s->weight * stage[0][c];
            to->light[1] += s->weight * stage[LAST][c];
        }
        for (int k = 0; k < LAST && exact; k++)
            to->part[k] += s->weight * distance2(stage[k], stage[k + 1]);
        if (square)
            square[i] = wrong;
        list[i] = (seen){ibl_relative_error(stage[LAST], stage[0], t->mean),
                         s->weight, batch};
    }
    qsort(list, (size_t)n, sizeof *list, by_error);
    find_figures(of, list, n, -1, out->value);
    for (int b = 0; b < IBL_BATCHES; b++)
        find_figures(of, list, n, b, out->without[b]);
    find_errors(out);
}

bool ibl_measure(const ibl_truth *truth, const ibl_drawn *set,
                 const ibl_reference *rest, ibl_measured *rows, double *square)
{
    const int n = truth->options.directions;
    seen *list = malloc((size_t)n * sizeof *list);
    double *exact = rest ? find_exact(truth, set, rest) : NULL;
    const bool ok = list && (exact || !rest);

    for (int row = 0; row < truth->rows && ok; row++)
        measure_row(truth, set, truth->sample + row * n,
                    exact ? exact + 6 * row * n : NULL, list,
                    square ? square + row * n : NULL, &rows[row]);
    free(list);
    free(exact);
    return ok;
}

ibl_measured ibl_measured_mean(const ibl_measured *rows, int count)
{
    ibl_measured mean = {.value = {0}};

    for (int k = 0; k < count; k++)
        for (int f = 0; f < IBL_FIGURES; f++) {
            mean.value[f] += rows[k].value[f] / count;
            for (int b = 0; b < IBL_BATCHES; b++)
                mean.without[b][f] += rows[k].without[b][f] / count;
        }
    find_errors(&mean);
    return mean;
}
