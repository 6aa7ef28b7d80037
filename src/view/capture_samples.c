/* SPDX-License-Identifier: MIT */
/*
 * The sample sets of filtered levels: what ibl_bake_specular does where it
 * samples. Points through the part of GGX's half vectors that lies above the
 * horizon (Walter et al. 2007, eq. 35, 36), weights N.L (Karis 2013), each
 * looked up where a texel's solid angle is that of the sample, 1 / (n pdf)
 * (Krivanek and Colbert 2008).
 *
 * Two things differ, for these samples are few. The angle from the axis has
 * Hammersley's regular coordinate, but the turn about it goes by the golden
 * angle, and lookups are not a level further: of 64 samples in a room with a
 * bright panel the error is a half and less of what it was.
 */
#include "view/capture_parts.h"

#include <math.h>
#include <stdlib.h>

#include "view/message.h"

static const double pi = 3.14159265358979323846;

/* Of a turn: the golden ratio's fraction. */
static const double golden = 0.6180339887498949;

typedef struct lobe {
    double alpha;
    int count;
    double texel; /* mean solid angle of one of level 0 */
    int last;     /* level of the lookups */
} lobe;

/*
 * An angle from the normal, moved by what takes the blur of its lookup back.
 * With variance v of a lookup along an axis, a lobe k = D N.L turns into
 * k + laplace(v k) / 2; moving its samples by s, k s = grad(v k) / 2, undoes
 * that. In texels h of level 0, which here are the source's pixels themselves,
 * v is h^2 (4^lod 5/12 - 1/4): 1/12 for the step from the source to level 0,
 * which was none, less than what the library's levels have. The part that
 * grows as 4^lod is as 1/D, so that only N.L has a gradient; the constant one
 * adds half of it times d(ln D).
 */
static double moved(const lobe *b, double sin_h, double cos_h, double lod)
{
    const double angle = 2 * atan2(sin_h, cos_h), h2 = b->texel;
    const double a2 = b->alpha * b->alpha, q = sin_h * sin_h;
    const double slope = -2 * (1 - a2) / (q + a2 * (1 - q)) * sin_h * cos_h;
    double grown = 0, constant = h2 / 6;

    if (lod > 0) {
        grown = h2 * 5 / 12 * pow(4, fmin(lod, b->last));
        constant = -h2 / 4;
    }
    double move = 0.5 * constant * slope;
    move = fmin(fmax(move, -0.5 * angle), fmin(0.5 * angle, 0.5 * pi - angle));
    return asin(fmin(sin(angle + move), 1) / sqrt(1 + grown + constant));
}

/* x, y, weight and level of point i; its weight. */
static double draw(const lobe *b, int i, float sample[4])
{
    const double a2 = b->alpha * b->alpha, part = 1 / (1 + a2);
    const double u = (i + 0.5) / b->count * part;
    const double s2 = a2 * u, c2 = 1 - u;
    const double sin_h = sqrt(s2 / (s2 + c2)), cos_h = sqrt(c2 / (s2 + c2));
    const double t = sin_h * sin_h + a2 * cos_h * cos_h;
    const double pdf = a2 / (pi * t * t) / (4 * part);
    const double lod = 0.5 * log2(1 / (b->count * pdf * b->texel));
    const double angle = moved(b, sin_h, cos_h, lod);
    const double phi = 2 * pi * fmod(i * golden, 1);
    const double weight = (cos_h - sin_h) * (cos_h + sin_h);

    sample[0] = (float)(sin(angle) * cos(phi));
    sample[1] = (float)(sin(angle) * sin(phi));
    sample[2] = (float)weight;
    sample[3] = (float)fmin(fmax(lod, 0), b->last);
    return weight;
}

static void draw_all(const lobe *b, float *samples)
{
    double sum = 0;

    for (int i = 0; i < b->count; i++)
        sum += draw(b, i, samples + 4 * i);
    for (int i = 0; i < b->count; i++)
        samples[4 * i + 2] = (float)(samples[4 * i + 2] / sum);
}

static int last_level(int size)
{
    int level = 0;

    while (size >> (level + 1))
        level++;
    return level;
}

int view_capture_diffuse_samples(const view_capture *c)
{
    /* There are few of its texels, and they are to be as good as a level's. */
    return c->options.samples < 128 ? 128 : c->options.samples;
}

bool view_capture_make_samples(view_capture *c)
{
    const int size = c->options.size, levels = c->options.levels;
    const int width = view_capture_diffuse_samples(c);
    float *all = calloc((size_t)width * levels, 4 * sizeof *all);

    if (!all)
        return view_fail("no memory for the samples of a capture");
    for (int l = 1; l <= levels; l++) {
        const bool diffuse = l == levels;
        const double r =
            diffuse ? 1 : ibl_level_roughness(IBL_ROUGHNESS_LINEAR, l, levels);
        const lobe b = {.alpha = r * r,
                        .count = diffuse ? width : c->options.samples,
                        .texel = 4 * pi / (6.0 * size * size),
                        .last = last_level(size)};
        draw_all(&b, all + (size_t)4 * width * (l - 1));
    }
    view_capture_source(VIEW_CAPTURE_UNIT_MORE, GL_TEXTURE_2D, c->samples);
    gl.TexImage2D(GL_TEXTURE_2D, 0, GL_RGBA32F, width, levels, 0, GL_RGBA,
                  GL_FLOAT, all);
    gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAX_LEVEL, 0);
    gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    free(all);
    return true;
}
