/* SPDX-License-Identifier: MIT */
#include "scene/survey.h"

#include <math.h>
#include <stdlib.h>

#include "common/signals.h"
#include "core/context.h"

enum {
    PLACES = 1 << 16,
    REDUCE = 4, /* of JPEG: a renderer's mip maps average, too */
    CLAMP = 33071,
    MIRRORED = 33648 /* OpenGL's numbers */
};

/* What is looked at, and the sums so far. */
typedef struct surveyor {
    const ibl_scene *scene;
    ibl_scene_survey *out;
    double linear[256]; /* of the values of sRGB */
    double place;       /* area between two places */
    double done;        /* area of triangles so far */
    double weight;      /* of a place */
    unsigned number;    /* of the next place */
} surveyor;

/* ---- textures --------------------------------------------------------- */

static int wrap(double x, int size, int how)
{
    double turns = x - floor(x);

    if (how == CLAMP)
        turns = fmin(fmax(x, 0), 1);
    else if (how == MIRRORED && fmod(floor(x), 2) != 0)
        turns = 1 - turns;
    const int i = (int)(turns * size);
    return i < size ? i : size - 1;
}

/* The texel at texture coordinates, or white; colours are of sRGB. */
static void look_up(const surveyor *y, const ibl_scene_texture *t,
                    const double uv[][2], bool colours, double texel[4])
{
    const ibl_scene_image *image =
        t->image < 0 ? NULL : &y->scene->images[t->image];

    texel[0] = texel[1] = texel[2] = texel[3] = 1;
    if (!image)
        return;
    const double *at = uv[t->texcoord];
    const double u = t->scale[0] * at[0];
    const double v = t->scale[1] * at[1];
    const double c = cos(t->rotation), s = sin(t->rotation);
    const int column =
        wrap(t->offset[0] + c * u + s * v, image->width, t->wrap_s);
    const int row =
        wrap(t->offset[1] - s * u + c * v, image->height, t->wrap_t);
    const unsigned char *p =
        image->rgba + 4 * ((size_t)row * (size_t)image->width + (size_t)column);
    for (int k = 0; k < 4; k++)
        texel[k] = colours && k < 3 ? y->linear[p[k]] : p[k] / 255.0;
}

/* ---- a place ---------------------------------------------------------- */

/* A place on a surface. */
typedef struct place {
    double uv[IBL_SCENE_TEXCOORDS][2];
    double colour[4];
} place;

static double luminance(const double c[3])
{
    return 0.2126 * c[0] + 0.7152 * c[1] + 0.0722 * c[2];
}

static double coverage(const ibl_scene_material *m, double alpha)
{
    if (m->alpha_mode == IBL_SCENE_MASK)
        return alpha >= (double)m->alpha_cutoff;
    return m->alpha_mode == IBL_SCENE_BLEND ? fmin(alpha, 1) : 1;
}

static void add(ibl_survey_bin bins[], double roughness, double share,
                double power, double diffuse)
{
    if (!(share > 0))
        return;
    ibl_survey_bin *b = &bins[(int)(64 * fmin(fmax(roughness, 0), 1) + 0.5)];

    b->share += share;
    b->power += share * power;
    b->diffuse += share * diffuse;
}

/* F0 of a dielectric: KHR_materials_ior and _specular. */
static double reflectance(const surveyor *y, const ibl_scene_material *m,
                          const place *p)
{
    const double ior = (double)m->ior;
    const double f0 = ior > 0 ? pow((ior - 1) / (ior + 1), 2) : 1;
    double tint[4], strength[4], colour[3];

    look_up(y, &m->specular_colour_texture, p->uv, true, tint);
    look_up(y, &m->specular_texture, p->uv, false, strength);
    for (int k = 0; k < 3; k++)
        colour[k] = fmin(f0 * (double)m->specular_colour[k] * tint[k], 1);
    return luminance(colour) * (double)m->specular * strength[3];
}

/* What lies over the others. */
static void add_layers(const surveyor *y, const ibl_scene_material *m,
                       const place *p, double weight)
{
    double amount[4], roughness[4], colour[3];

    if (m->clearcoat > 0) {
        look_up(y, &m->clearcoat_texture, p->uv, false, amount);
        look_up(y, &m->clearcoat_roughness_texture, p->uv, false, roughness);
        const double coat = (double)m->clearcoat * amount[0];
        add(y->out->clearcoat, (double)m->clearcoat_roughness * roughness[1],
            weight * coat, coat, 0);
    }
    look_up(y, &m->sheen_colour_texture, p->uv, true, amount);
    look_up(y, &m->sheen_roughness_texture, p->uv, false, roughness);
    for (int k = 0; k < 3; k++)
        colour[k] = (double)m->sheen_colour[k] * amount[k];
    const double sheen = luminance(colour);
    if (sheen > 0)
        add(y->out->sheen, (double)m->sheen_roughness * roughness[3], weight,
            sheen * sheen, 0);
    if (m->anisotropy > 0)
        y->out->anisotropic += weight;
}

/* Divides a surface between metals and dielectrics of F0 = .04, as a shader
 * with a lobe table does. */
static void add_base(const surveyor *y, const ibl_scene_material *m,
                     const place *p, const double base[3], double weight)
{
    double mr[4], through[4];

    look_up(y, &m->metallic_roughness_texture, p->uv, false, mr);
    look_up(y, &m->transmission_texture, p->uv, false, through);
    const double roughness = m->glossy ? 1 - (1 - (double)m->roughness) * mr[3]
                                       : (double)m->roughness * mr[1];
    const double metallic = (double)m->metallic * mr[2];
    const double f0 = reflectance(y, m, p), tint = luminance(base);
    /* an ior of 1.5 is not exactly .04 in float */
    const double bright = f0 < 0.0401 ? 0 : fmin((f0 - 0.04) / 0.96, 1);
    const double dull = f0 > 0.0399 ? 1 : f0 / 0.04;
    const double clear = (double)m->transmission * through[0];
    const double rest = weight * (1 - metallic);

    y->out->transmission += rest * clear;
    add(y->out->metal, roughness, weight * metallic, tint * tint, 0);
    add(y->out->metal, roughness, rest * bright, 1, 0);
    add(y->out->dielectric, roughness, rest * (1 - bright), dull * dull,
        tint * (1 - clear));
}

static void add_place(const surveyor *y, const ibl_scene_material *m,
                      const place *p)
{
    double texel[4], base[3];

    look_up(y, &m->base_colour_texture, p->uv, true, texel);
    const double weight = y->weight * coverage(m, (double)m->base_colour[3] *
                                                      texel[3] * p->colour[3]);
    for (int k = 0; k < 3; k++)
        base[k] = fmin((double)m->base_colour[k] * texel[k] * p->colour[k], 1);
    if (m->unlit) {
        y->out->unlit += weight;
        return;
    }
    add_base(y, m, p, base, weight);
    add_layers(y, m, p, weight);
}

/* ---- triangles -------------------------------------------------------- */

/* The area of a triangle in the world; 0 if it has none. */
static double area_of(const ibl_scene_draw *d, const ibl_scene_primitive *p,
                      const uint32_t corner[3])
{
    double edge[2][3], world[2][3], square = 0;

    for (int k = 0; k < 3; k++)
        for (int e = 0; e < 2; e++)
            edge[e][k] = (double)p->position[3 * (size_t)corner[e + 1] + k] -
                         (double)p->position[3 * (size_t)corner[0] + k];
    for (int k = 0; k < 3; k++)
        for (int e = 0; e < 2; e++)
            world[e][k] = d->to_world[k] * edge[e][0] +
                          d->to_world[4 + k] * edge[e][1] +
                          d->to_world[8 + k] * edge[e][2];
    for (int k = 0; k < 3; k++) {
        const int a = (k + 1) % 3, b = (k + 2) % 3;
        square += pow(world[0][a] * world[1][b] - world[0][b] * world[1][a], 2);
    }
    const double area = sqrt(square) / 2;
    return isfinite(area) ? area : 0;
}

/* A vertex's weight in a place. */
static void blend(const ibl_scene_primitive *p, uint32_t vertex, double share,
                  place *to)
{
    for (int i = 0; i < IBL_SCENE_TEXCOORDS; i++)
        for (size_t k = 0; k < 2 && p->texcoord[i]; k++)
            to->uv[i][k] +=
                share * (double)p->texcoord[i][2 * (size_t)vertex + k];
    for (size_t k = 0; k < 4; k++)
        to->colour[k] +=
            share * (p->colour ? (double)p->colour[4 * (size_t)vertex + k] : 1);
}

/* Two numbers of 0..1 for each place, evenly spread: multiples of powers of the
 * plastic number (M. Roberts, 2018, "The unreasonable effectiveness of
 * quasirandom sequences"). */
static void spread(unsigned number, double at[2])
{
    at[0] = fmod(0.5 + number * 0.7548776662466927, 1);
    at[1] = fmod(0.5 + number * 0.5698402909980532, 1);
    if (at[0] + at[1] <= 1)
        return;
    at[0] = 1 - at[0];
    at[1] = 1 - at[1];
}

/* Takes the places in a triangle. */
static void take(surveyor *y, const ibl_scene_primitive *p,
                 const uint32_t corner[3], double area)
{
    for (y->done += area; (y->number + 0.5) * y->place < y->done;) {
        place at = {0};
        double share[2];
        spread(y->number++, share);
        blend(p, corner[0], 1 - share[0] - share[1], &at);
        blend(p, corner[1], share[0], &at);
        blend(p, corner[2], share[1], &at);
        add_place(y, &y->scene->materials[p->material], &at);
    }
}

/* Goes through all triangles; y NULL: only sums their areas. */
static double go_through(const ibl_scene *s, surveyor *y)
{
    double sum = 0;

    for (int i = 0; i < s->draw_count; i++) {
        const ibl_scene_draw *d = &s->draws[i];
        const ibl_scene_primitive *p = &s->primitives[d->primitive];
        for (uint32_t t = 0; t < p->index_count; t += 3) {
            const double area = area_of(d, p, p->index + t);
            sum += area;
            if (y)
                take(y, p, p->index + t, area);
        }
    }
    return sum;
}

/* ---- images ----------------------------------------------------------- */

#define AT(field) offsetof(ibl_scene_material, field)

/* Textures that decide what a material reflects, and how much. */
static const size_t textures[] = {
    AT(base_colour_texture),  AT(metallic_roughness_texture),
    AT(specular_texture),     AT(specular_colour_texture),
    AT(clearcoat_texture),    AT(clearcoat_roughness_texture),
    AT(sheen_colour_texture), AT(sheen_roughness_texture),
    AT(transmission_texture)};

/* Lists the images of what is drawn, each once; counts that. */
static int list_images(const ibl_scene *s, bool *seen, int *images,
                       ibl_scene_survey *out)
{
    bool *drawn = seen + s->image_count;
    int count = 0;

    for (int i = 0; i < s->draw_count; i++) {
        const ibl_scene_primitive *p = &s->primitives[s->draws[i].primitive];
        const char *m = (const char *)&s->materials[p->material];
        out->triangles += (int)(p->index_count / 3);
        out->materials += !drawn[p->material];
        drawn[p->material] = true;
        for (size_t k = 0; k < sizeof textures / sizeof *textures; k++) {
            const int image =
                ((const ibl_scene_texture *)(const void *)(m + textures[k]))
                    ->image;
            if (image < 0 || seen[image])
                continue;
            seen[image] = true;
            images[count++] = image;
        }
    }
    return count;
}

static ibl_status decode(ibl_ctx *ctx, ibl_scene *s, ibl_scene_survey *out)
{
    const size_t total = (size_t)s->image_count + (size_t)s->material_count;
    bool *seen = ibl_need(calloc(total, sizeof *seen));
    int *images = ibl_need(malloc(total * sizeof *images));
    const int count = list_images(s, seen, images, out);
    const ibl_status status =
        ibl_scene_decode_all(ctx, s, images, count, REDUCE);

    out->images += count;
    free(seen);
    free(images);
    return status;
}

/* ---- the calls --------------------------------------------------------- */

double ibl_survey_share(const ibl_survey_bin bins[])
{
    double all = 0;

    for (int i = 0; i < IBL_SURVEY_BINS; i++)
        all += bins[i].share;
    return all;
}

/* Makes room for another scene among shares that sum to 1. */
static void scale(ibl_scene_survey *out, double by)
{
    double *all = (double *)(void *)out;

    for (size_t i = offsetof(ibl_scene_survey, metal) / sizeof *all;
         i < offsetof(ibl_scene_survey, scenes) / sizeof *all; i++)
        all[i] *= by;
}

ibl_status ibl_scene_survey_add(ibl_ctx *ctx, ibl_scene *scene,
                                ibl_scene_survey *survey)
{
    const double area = go_through(scene, NULL), all = survey->area + area;
    surveyor y = {.scene = scene,
                  .out = survey,
                  .place = area / PLACES,
                  .weight = area / all / PLACES};

    if (!(area > 0) || !isfinite(all))
        return ibl_fail(ctx, IBL_ERR_FORMAT,
                        "%s: its triangles have no area, or an endless one",
                        scene->files[0]);
    const ibl_status status = decode(ctx, scene, survey);
    if (status)
        return status;
    for (int i = 0; i < 256; i++)
        y.linear[i] =
            i <= 10 ? i / 255.0 / 12.92 : pow((i / 255.0 + 0.055) / 1.055, 2.4);
    scale(survey, survey->area / all);
    go_through(scene, &y);
    survey->area = all;
    survey->scenes++;
    return IBL_OK;
}
