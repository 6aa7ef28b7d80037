/* SPDX-License-Identifier: MIT */
#include "cli/rendered.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "common/signals.h"

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
    set->chain = (ibl_set_facts){.levels = layout->levels,
                                 .mapping = layout->mapping,
                                 .lod_scale = layout->lod_scale,
                                 .lod_offset = layout->lod_offset};
    memcpy(set->chain.roughness, layout->roughness, sizeof layout->roughness);
    set->specular = *chain;
}

/* ---- samples --------------------------------------------------------------
 */

static void half_of(const double a[3], const double b[3], double half[3])
{
    for (int k = 0; k < 3; k++)
        half[k] = a[k] + b[k];
    ibl_normalise(half);
}

enum {
    GRAZING = 10 /* the most that small V.H are drawn more often than others */
};
#define LIT 0.65 /* share of the samples that lights have */

/* What a spot spreads of half vectors, which turn by half its angle, across the
 * plane of V and L by 1 / V.H times that. */
static double half_spread(const ibl_spot *spot, double c)
{
    return fmin(spot->spread / (4 * c * c), 0.1);
}

/* Draws a normal and a view; returns what they stand for: their density,
 * N.V / 4 pi^2, over that by which they are drawn. 0: from below the surface.
 */
static double draw(const ibl_spot *spots, const double u[IBL_DIMENSIONS],
                   ibl_sample *s)
{
    const ibl_spot *spot = ibl_spot_at(spots, u[0] / LIT);
    const double even = 1 / M_PI;
    double half[3], density = 0;

    if (spot && u[0] < LIT) { /* V, then N around the half vector */
        const double c = (pow(1 + GRAZING, u[1]) - 1) / GRAZING;
        ibl_around(spot->direction, 2 * c * c - 1, 2 * M_PI * u[2], s->view);
        half_of(spot->direction, s->view, half);
        ibl_around(half, ibl_spot_draw(half_spread(spot, c), u[3]),
                   2 * M_PI * u[4], s->normal);
    } else { /* R, then N, then V */
        ibl_around(NULL, 1 - 2 * u[1], 2 * M_PI * u[2], s->mirror);
        ibl_around(s->mirror, u[3], 2 * M_PI * u[4], s->normal);
        for (int k = 0; k < 3; k++)
            s->view[k] = 2 * u[3] * s->normal[k] - s->mirror[k];
    }
    s->n_dot_v = ibl_dot(s->normal, s->view);
    for (int k = 0; k < 3; k++)
        s->mirror[k] = 2 * s->n_dot_v * s->normal[k] - s->view[k];
    if (s->n_dot_v < 1e-4)
        return 0;
    for (const ibl_spot *p = spots; spot && p < spots + IBL_SPOTS; p++)
        if (p->share > 0) {
            half_of(p->direction, s->view, half);
            const double c = fmax(ibl_dot(half, s->view), 1e-6);
            density +=
                p->share *
                ibl_spot_density(half_spread(p, c), ibl_dot(half, s->normal)) /
                (c * (c + 1.0 / GRAZING) * log(1 + GRAZING));
        }
    return 2 * s->n_dot_v / M_PI /
           (spot ? (1 - LIT) * even + LIT * density : even);
}

/* The material at u, 0..1, of all, in proportion to what they add to a picture,
 * and to how wrong sharp reflections are. */
static void pick_material(const ibl_materials *m, double u, ibl_sample *s)
{
    double sum = 0, share[2 * (IBL_MATERIAL_STEPS + 1)];
    int at = -1;

    for (int i = 0; i < 2 * (IBL_MATERIAL_STEPS + 1); i++)
        sum += share[i] = m->weight[i / 2][i % 2] *
                          (m->diffuse[i / 2][i % 2] + (i % 2 ? 0.1 : 1)) /
                          (i / 2 + 0.05 * IBL_MATERIAL_STEPS);
    u *= sum;
    for (int i = 0; i < 2 * (IBL_MATERIAL_STEPS + 1) && u >= 0; i++)
        if (share[i] > 0) {
            u -= share[i];
            at = i;
        }
    s->roughness = (double)(at / 2) / IBL_MATERIAL_STEPS;
    s->f0 = at % 2 ? 0.04 : 1;
    s->albedo = m->diffuse[at / 2][at % 2];
    s->weight *= m->weight[at / 2][at % 2] / share[at];
}

static void draw_samples(const ibl_spot *spots, const ibl_materials *materials,
                         ibl_truth *t)
{
    const ibl_truth_options *o = &t->options;
    const size_t n = (size_t)o->directions;
    size_t points = 0; /* of the sequence, that were tried */

    for (size_t i = 0; i < n; i++) {
        ibl_sample *s = &t->sample[i];
        double u[IBL_DIMENSIONS];
        *s = (ibl_sample){.albedo = 0};
        do
            ibl_spread(o->seed, points++, u);
        while (!((s->weight = draw(spots, u, s)) > 0));
        if (materials)
            pick_material(materials, u[5], s);
        for (int k = t->rows; k-- > 0 && !materials;) { /* its own last */
            s->roughness = o->roughness[k % o->roughness_count];
            s->f0 = o->f0[k / o->roughness_count];
            t->sample[(size_t)k * n + i] = *s;
        }
    }
}

/* ---- the truth ------------------------------------------------------------
 */

static bool find_truth(const ibl_reference *ref, bool materials, ibl_truth *t)
{
    const ibl_truth_options *o = &t->options;
    const size_t n = (size_t)o->directions;
    const int kinds = materials ? IBL_MATERIAL_STEPS + 1 : o->roughness_count;
    /* Each F0 of a grid has the same integrals. */
    const size_t own = materials ? n : n * (size_t)kinds;
    double *normal = ibl_need(malloc(14 * n * sizeof *normal));
    double *view = normal + 3 * n, *sums = view + 3 * n;
    bool ok = !ibl_reference_mean(ref, t->mean);

    for (int k = 0; k < kinds && ok; k++) {
        const double roughness =
            materials ? (double)k / IBL_MATERIAL_STEPS : o->roughness[k];
        const double *sum = sums;
        size_t count = 0;
        for (size_t i = 0; i < own; i++)
            if (t->sample[i].roughness == roughness) {
                const ibl_sample *s = &t->sample[i];
                memcpy(normal + 3 * count, s->normal, sizeof s->normal);
                memcpy(view + 3 * count++, s->view, sizeof s->view);
            }
        ok = !count || !ibl_reference_brdf(ref, o->geometry, &roughness, 1,
                                           normal, view, count, sums);
        for (size_t i = 0; i < own && ok; i++)
            if (t->sample[i].roughness == roughness) {
                for (size_t at = i; at < n * (size_t)t->rows; at += own) {
                    ibl_sample *s = &t->sample[at];
                    for (int c = 0; c < 3; c++)
                        s->truth[c] = s->f0 * sum[c] + sum[4 + c];
                    s->table[0] = sum[3];
                    s->table[1] = sum[7];
                }
                sum += IBL_REFERENCE_BRDF;
            }
    }
    for (size_t i = 0; i < n && ok && materials; i++)
        memcpy(normal + 3 * i, t->sample[i].normal, 3 * sizeof *normal);
    ok = ok && (!materials || !ibl_reference_irradiance(ref, normal, n, view));
    for (size_t i = 0; i < 3 * n && ok && materials; i++)
        t->sample[i / 3].truth[i % 3] += t->sample[i / 3].albedo * view[i];
    free(normal);
    return ok;
}

bool ibl_truth_make(ibl_ctx *ctx, const ibl_image *env, double yaw_deg,
                    const ibl_truth_options *options, ibl_truth *out)
{
    const ibl_materials *materials = options->materials;
    ibl_spot *spots = ibl_spots_of(env, yaw_deg);
    ibl_reference *ref = NULL;

    ibl_truth_free(out);
    out->options = *options;
    out->options.materials = NULL;
    out->rows = materials ? 1 : options->roughness_count * options->f0_count;
    out->sample = ibl_need(malloc(
        (size_t)out->rows * (size_t)options->directions * sizeof *out->sample));
    bool ok = !ibl_reference_create(ctx, env, yaw_deg, &ref);
    if (ok) {
        ibl_reference_coarsen(ref);
        draw_samples(spots, materials, out);
        ok = find_truth(ref, materials, out);
    }
    ibl_reference_free(ref);
    free(spots);
    return ok;
}

void ibl_truth_free(ibl_truth *t)
{
    free(t->sample);
    *t = (ibl_truth){0};
}

/* ---- what the shader looks up ------------------------------------------ */

enum {
    TAPS = 4 /* the most */
};

/* The light that a shader takes for a sample: the mean of its taps, mixed with
 * a share of irradiance / pi. */
typedef struct look {
    int taps;
    double dir[TAPS][3];
    double lod, diffuse;
} look;

static double mix(double a, double b, double t)
{
    return a + t * (b - a);
}

/* mix(R, N, share), normalised. */
static void bend(const ibl_sample *s, double share, double dir[3])
{
    for (int k = 0; k < 3; k++)
        dir[k] = mix(s->mirror[k], s->normal[k], share);
    ibl_normalise(dir);
}

/* ibl_lobe_split and so on of ibl/ibl.glsl. */
static void aim(const ibl_drawn *set, const ibl_sample *s, look *l)
{
    const double nv = s->n_dot_v, r = s->roughness;
    /* ibl_metallic, with the exact table. */
    const double metallic = (s->f0 - 0.04) / 0.96 *
                            (s->table[0] + s->table[1]) /
                            fmax(s->f0 * s->table[0] + s->table[1], 1e-20);
    const double m = fmin(fmax(metallic, 0), 1);
    double share = 0, roughness = r, q[4];

    *l = (look){.taps = 1};
    if (!set->chain.levels) {
        l->taps = 0;
        l->diffuse = 1;
        return;
    }
    if (set->shader >= IBL_SHADER_TABLE) {
        const int taps = 1 + (int)(set->shader - IBL_SHADER_TABLE);
        ibl_lookup_lobes(&set->lobes, taps, m, nv, r, q);
        for (int i = 0; i < taps; i++)
            bend(s, q[0] + (taps > 1 ? q[3] * (2.0 * i / (taps - 1) - 1) : 0),
                 l->dir[i]);
        l->taps = taps;
        l->diffuse = q[2];
        l->lod = q[1] * (set->chain.levels - 1);
        return;
    }
    if (set->shader == IBL_SHADER_BENT) {
        share = pow(r, 2.1 + 1.8 * nv);
        roughness = fmin(r * (0.75 + 0.28 * nv + 0.27 * r * r), 1);
    } else if (set->shader == IBL_SHADER_FIT) {
        const double narrow =
            fmin(3 * r, 1) * (mix(0.55, 0.64, m) + mix(0.54, 0.44, m) * nv - 1);
        share = mix(3.1, 5.2, m) * pow(r, 3.5) * (1 - r) * (1 - nv);
        roughness = fmin(r + r * narrow, 1);
        l->diffuse =
            fmin((mix(0.49, 0.87, m) + mix(0.58, 0.43, m) * nv) *
                     pow(fmax((r - 0.15) / 0.85, 0), mix(2.6, 1 + 2.5 * nv, m)),
                 1);
    }
    bend(s, share, l->dir[0]);
    l->lod = ibl_set_lod(&set->chain, roughness);
}

/* ---- colours ------------------------------------------------------------ */

/* What the lights that were taken out of the map give. */
static void add_lights(const ibl_truth *t, const ibl_drawn *set,
                       const ibl_sample *s, double rgb[3])
{
    for (int i = 0; i < set->light_count; i++) {
        const ibl_light *l = &set->lights[i];
        const double f =
            ibl_disc_brdf(t->options.geometry, s->roughness * s->roughness,
                          s->f0, l->radius, s->normal, s->view, l->direction) +
            s->albedo / M_PI * fmax(ibl_dot(s->normal, l->direction), 0);
        for (int c = 0; c < 3; c++)
            rgb[c] += f * l->irradiance[c];
    }
}

/* The shader's colour. */
static void shade(const ibl_truth *t, const ibl_drawn *set, const ibl_sample *s,
                  double rgb[3])
{
    double seen[3] = {0}, diffuse[3] = {0}, tap[3];
    double table[2] = {s->table[0], s->table[1]};
    look l;

    aim(set, s, &l);
    for (int k = 0; k < l.taps; k++) {
        ibl_lookup_chain(&set->specular, l.dir[k], l.lod, tap);
        for (int c = 0; c < 3; c++)
            seen[c] += tap[c] / l.taps;
    }
    if (l.diffuse <= 0 && s->albedo <= 0)
        ; /* none is needed */
    else if (set->sh)
        ibl_lookup_sh(set->sh, set->sh_degree, s->normal, diffuse);
    else
        ibl_lookup_cube(&set->irradiance, 0, s->normal, diffuse);
    if (set->lut.data)
        ibl_lookup_lut(&set->lut, s->n_dot_v, s->roughness, table);
    for (int c = 0; c < 3; c++) {
        const double light = mix(seen[c], diffuse[c], l.diffuse);
        /* What is no number stays so. */
        rgb[c] = s->albedo * diffuse[c] +
                 (s->f0 * table[0] + table[1]) * (light < 0 ? 0 : light);
    }
    add_lights(t, set, s, rgb);
}

void ibl_measure(const ibl_truth *truth, const ibl_drawn *set,
                 ibl_measured *rows)
{
    const size_t n = (size_t)truth->options.directions;
    ibl_seen *seen = ibl_need(malloc(n * sizeof *seen));

    for (size_t i = 0; i < n * (size_t)truth->rows; i++) {
        const ibl_sample *s = &truth->sample[i];
        double rgb[3];
        shade(truth, set, s, rgb);
        seen[i % n] =
            (ibl_seen){.weight = s->weight, .batch = ibl_batch_of(i % n, n)};
        ibl_see(&seen[i % n], rgb, s->truth, truth->mean);
        if (i % n == n - 1)
            rows[i / n] = ibl_measured_of(seen, n);
    }
    free(seen);
}
