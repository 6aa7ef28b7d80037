/* SPDX-License-Identifier: MIT */
#include "cli/rendered_report.h"

#include <math.h>
#include <stdlib.h>

#include "json/json_text.h"

const char *const ibl_shader_names[] = {"auto",  "split",    "bent", "fit",
                                        "table", "two-taps", NULL};

/* ---- the files ---------------------------------------------------------- */

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

/* Finds what the shader draws with. */
static bool find_set(const ibl_verify_files *f, const ibl_judged_map *map,
                     ibl_console *console, ibl_drawn *set)
{
    set->lod = f->lod;
    set->lights = map->lights;
    set->light_count = map->light_count;
    set->lobes = f->lobes;
    if (!f->lut.kind)
        set->lut = f->lut;
    for (int i = 0; i < f->count; i++) {
        const ibl_judge_level *level = &f->level[i];
        if (level->content == IBL_OUTPUT_IRRADIANCE) {
            set->irradiance = f->cube[i];
            set->irradiance_scale = level->scale;
        } else if (level->content == IBL_OUTPUT_SPECULAR) {
            if (level->lobe != IBL_LOBE_GGX)
                return ibl_console_fail(
                    console, "%s: of the lobe %s: --rendered judges ggx",
                    f->path[IBL_OUTPUT_SPECULAR], ibl_lobe_name(level->lobe));
            set->roughness[set->levels] = level->roughness;
            set->level[set->levels++] = f->cube[i];
        }
    }
    if (!set->levels)
        return ibl_console_fail(console,
                                "no specular cube, which is what --rendered "
                                "judges: add --specular");
    if (set->shader == IBL_SHADER_AUTO)
        set->shader = f->lobes.data && set->irradiance.data ? IBL_SHADER_TABLE
                                                            : IBL_SHADER_SPLIT;
    if (set->shader >= IBL_SHADER_TABLE && !f->lobes.data)
        return ibl_console_fail(console,
                                "--shader %s: there is no lobe table: name it "
                                "with --lobe-table",
                                ibl_shader_names[set->shader]);
    return !ibl_drawn_needs_irradiance(set) || set->irradiance.data ||
           ibl_console_fail(console,
                            "--shader %s: there is no irradiance map: name it "
                            "with --irradiance",
                            ibl_shader_names[set->shader]);
}

bool ibl_rendered_judge(const ibl_verify_files *files, ibl_ctx *ctx,
                        const ibl_judged_map *map,
                        const ibl_truth_options *options, ibl_shader shader,
                        ibl_console *console, ibl_rendered *out)
{
    const int n = options->roughness_count, rows = n * options->f0_count;
    ibl_measured *measured = malloc((size_t)rows * sizeof *measured);
    ibl_drawn set = {.shader = shader};
    ibl_reference *rest = NULL;
    ibl_truth truth = {0};

    *out = (ibl_rendered){
        .options = *options,
        .rows = malloc((size_t)(rows + options->f0_count) * sizeof *out->rows)};
    out->options.geometry = files->geometry;
    ibl_console_progress(console, "truth", 0);
    bool ok =
        measured && out->rows && check_finite(files, console) &&
        find_set(files, map, console, &set) &&
        ibl_truth_make(ctx, &map->env, map->yaw_deg, &out->options, &truth);
    ibl_console_progress(console, "parts", 0);
    ok = ok &&
         !ibl_reference_create(ctx, ibl_judged_map_rest(map), map->yaw_deg,
                               &rest) &&
         ibl_measure(&truth, &set, rest, measured, NULL);
    out->shader = set.shader;
    for (int f = 0; f < options->f0_count && ok; f++) {
        for (int k = 0; k < n; k++)
            out->rows[out->count++] = (ibl_rendered_row){
                options->f0[f], options->roughness[k], measured[f * n + k]};
        out->rows[out->count++] = (ibl_rendered_row){
            options->f0[f], NAN, ibl_measured_mean(measured + f * n, n)};
    }
    ibl_reference_free(rest);
    ibl_truth_free(&truth);
    free(measured);
    return ok;
}

void ibl_rendered_free(ibl_rendered *rendered)
{
    free(rendered->rows);
    *rendered = (ibl_rendered){0};
}

bool ibl_rendered_passes(const ibl_rendered *rendered, double most, char *why,
                         size_t size)
{
    *why = '\0';
    for (int i = 0; i < rendered->count; i++) {
        const ibl_rendered_row *row = &rendered->rows[i];
        const ibl_measured *m = &row->measured;
        if (!*why && isnan(row->roughness) && m->value[IBL_FIGURE_NRMSE] > most)
            snprintf(why, size,
                     "rendered with F0 = %g, the files have an nRMSE of %.3g "
                     "+- %.1g, above %g",
                     row->f0, m->value[IBL_FIGURE_NRMSE],
                     m->error[IBL_FIGURE_NRMSE], most);
    }
    return !*why;
}

/* ---- table ----------------------------------------------------------- */

void ibl_rendered_print(const ibl_rendered *rendered, FILE *to)
{
    fprintf(to,
            "as rendered by %s: %d directions; %% +- standard error\n"
            "%-5s %6s",
            ibl_shader_names[rendered->shader], rendered->options.directions,
            "F0", "r");
    for (int f = 0; f < IBL_FIGURES; f++)
        fprintf(to, "  %14s", ibl_figure_names[f]);
    fputc('\n', to);
    for (int i = 0; i < rendered->count; i++) {
        const ibl_rendered_row *row = &rendered->rows[i];
        fprintf(to, "%-5g ", row->f0);
        if (isnan(row->roughness))
            fprintf(to, "%6s", "mean");
        else
            fprintf(to, "%6.4f", row->roughness);
        for (int f = 0; f < IBL_FIGURES; f++)
            fprintf(to, "  %6.3g +- %-4.1g", 100 * row->measured.value[f],
                    100 * row->measured.error[f]);
        fputc('\n', to);
    }
    fflush(to);
}

/* ---- JSON ------------------------------------------------------------ */

static json_t *figures_json(const double figures[IBL_FIGURES])
{
    json_t *j = json_object();

    for (int f = 0; f < IBL_FIGURES; f++)
        put(&j, ibl_figure_names[f], json_real(ibl_json_digits(figures[f])));
    return j;
}

json_t *ibl_rendered_json(const ibl_rendered *rendered)
{
    json_t *j = json_object(), *rows = json_array(), *means = json_array();

    put(&j, "shader", json_string(ibl_shader_names[rendered->shader]));
    put(&j, "directions", json_integer(rendered->options.directions));
    put(&j, "seed", json_integer(rendered->options.seed));
    for (int i = 0; i < rendered->count; i++) {
        const ibl_rendered_row *row = &rendered->rows[i];
        json_t *r = json_object();
        put(&r, "f0", json_real(row->f0));
        if (!isnan(row->roughness))
            put(&r, "roughness", json_real(row->roughness));
        put_all(&r, figures_json(row->measured.value));
        put(&r, "standard_error", figures_json(row->measured.error));
        append(isnan(row->roughness) ? &means : &rows, r);
    }
    put(&j, "rows", rows);
    put(&j, "means", means);
    return j;
}
