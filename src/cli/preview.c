/* SPDX-License-Identifier: MIT */
#include "cli/job.h"

#include <math.h>
#include <stdio.h>

#include "cli/sheet.h"

enum {
    MAX_PANELS = IBL_MAX_LEVELS + 4
};

/* ---- tones ----------------------------------------------------------- */

static double luminance(const float *rgb)
{
    return 0.2126 * (double)rgb[0] + 0.7152 * (double)rgb[1] +
           0.0722 * (double)rgb[2];
}

/*
 * Exposure that maps the logarithmic mean of the luminance to middle grey
 * (Reinhard et al. 2002, eq. 1 and 2). It is limited so that the plain mean,
 * which the rough levels show, is at most 0.35: without the limit a dark room
 * with a few lamps gives white panels.
 */
static double find_exposure(const ibl_image *env)
{
    const double pi = acos(-1.0);
    double mean = 0, log_mean = 0;

    for (int pass = 0; pass < 2; pass++)
        for (int j = 0; j < env->height; j++) {
            const float *row = env->data + 3 * (size_t)j * (size_t)env->width;
            const double weight =
                (cos(pi * j / env->height) - cos(pi * (j + 1) / env->height)) /
                (2.0 * env->width);
            double sum = 0;
            for (int i = 0; i < env->width; i++) {
                const double y = luminance(row + 3 * i);
                sum += pass == 0 ? y : log(y + 1e-3 * mean);
            }
            *(pass == 0 ? &mean : &log_mean) += weight * sum;
            if (pass == 0 && j == env->height - 1 && !(mean > 0))
                return 1;
        }
    return fmin(0.18 / exp(log_mean), 0.35 / mean);
}

/* ---- layout ---------------------------------------------------------- */

static int list_panels(const ibl_output_set *b, ibl_panel panels[MAX_PANELS])
{
    const ibl_bake_result *made = &b->made;
    int n = 0;

    if (b->job->env.data) {
        ibl_panel *p = &panels[n++];
        *p = (ibl_panel){.map = &b->job->env, .text = {"environment"}};
        snprintf(p->text[1], sizeof p->text[1], "%d x %d", b->job->env.width,
                 b->job->env.height);
    }
    if (made->skybox.data)
        panels[n++] = (ibl_panel){.cube = &made->skybox, .text = {"skybox"}};
    for (int l = 0; l < made->specular.levels; l++) {
        ibl_panel *p = &panels[n++];
        *p = (ibl_panel){.cube = &made->specular, .level = l};
        snprintf(p->text[0], sizeof p->text[0], "specular %d", l);
        snprintf(p->text[1], sizeof p->text[1], "r = %.3g",
                 made->report.layout.roughness[l]);
    }
    if (made->irradiance.data)
        panels[n++] =
            (ibl_panel){.cube = &made->irradiance, .text = {"irradiance"}};
    if (b->lut.data)
        panels[n++] =
            (ibl_panel){.lut = &b->lut, .text = {"BRDF table", "r over N.V"}};
    return n;
}

bool ibl_preview_png(const ibl_output_set *b, void **png, size_t *size)
{
    ibl_panel panels[MAX_PANELS];
    const int count = list_panels(b, panels);

    ibl_sheet_png(panels, count,
                  b->job->env.data ? find_exposure(&b->job->env) : 1, png,
                  size);
    return true;
}
