/* SPDX-License-Identifier: MIT */
#include "bake/spectral/bright.h"

#include <math.h>
#include <stdbool.h>
#include <string.h>

#include "bake/spectral/gauss.h"
#include "core/alloc.h"
#include "core/context.h"
#include "core/pi.h"
#include "image/cube.h"

enum {
    MIN_BITS = 3, /* pieces an octave, as a power of two */
    MAX_BITS = 7,
    MIN_OCTAVES = 2, /* from 2^-k to 1 */
    MAX_OCTAVES = 40,
    NODES = IBL_GAUSS_POINTS,
    GROUP = 4 /* lights that are looked at together */
};

/* One side of a lobe: by v = q from the peak or v = 2 - q from the horizon. */
typedef struct side {
    ibl_chord_fn *weight;
    const void *arg;
    int horizon;
    int octaves; /* start is 2^-octaves */
} side;

static double value(const side *s, double v)
{
    const double q = s->horizon ? 2 - v : v;
    return s->weight(sqrt(q > 0 ? q : 0), s->arg);
}

static double start_of(const side *s)
{
    return ldexp(1, -s->octaves);
}

/* ---- the integral ------------------------------------------------------ */

static double panel(const side *s, double from, double width)
{
    double sum = 0;
    for (int k = 0; k < NODES; k++)
        sum += ibl_gauss_mass[k] * value(s, from + ibl_gauss_node[k] * width);
    return sum * width;
}

/* Of v from 0 to 1: a solid angle is pi dq. */
static double integral(const side *s)
{
    const double start = start_of(s);
    double sum = 0;
    for (int k = 0; k < 8; k++)
        sum += panel(s, start * k / 8, start / 8);
    for (double from = start; from < 1; from *= 2)
        for (int k = 0; k < 8; k++)
            sum += panel(s, from + from * k / 8, from / 8);
    return IBL_PI * sum;
}

/* ---- the table --------------------------------------------------------- */

/* The largest weight, near enough. */
static double peak_of(const side s[2])
{
    double peak = 0;
    for (int h = 0; h < 2; h++) {
        peak = fmax(peak, value(&s[h], 0));
        for (int k = 0; k <= 2 * MAX_OCTAVES; k++)
            peak = fmax(peak, value(&s[h], exp2(-0.5 * k)));
    }
    return peak;
}

/* Octaves go down to where the lobe is near enough to its end. */
static int octaves_of(const side *s, double peak)
{
    const double end = value(s, 0);
    int k = MIN_OCTAVES;
    while (k < MAX_OCTAVES &&
           fabs(value(s, ldexp(1, -k)) - end) > fmax(0.25 * end, 1e-6 * peak))
        k++;
    return k;
}

static int pieces_of(const side *s, int bits)
{
    /* t runs to 1 + start. */
    return (s->octaves << bits) + (int)(start_of(s) * (1 << bits)) + 1;
}

/* The cubic of x = 0..1 through the lobe at the nodes of a piece. */
static void fit(const side *s, int bits, int piece, double c[4])
{
    const double octave = ldexp(1, (piece >> bits) - s->octaves);
    const double width = octave / (1 << bits);
    const double from =
        octave + width * (piece & ((1 << bits) - 1)) - start_of(s);
    double f[NODES], poly[NODES] = {0};
    for (int k = 0; k < NODES; k++)
        f[k] = value(s, from + ibl_gauss_node[k] * width);
    for (int j = 1; j < NODES; j++)
        for (int i = NODES - 1; i >= j; i--)
            f[i] =
                (f[i] - f[i - 1]) / (ibl_gauss_node[i] - ibl_gauss_node[i - j]);
    for (int i = NODES - 1; i >= 0; i--) {
        for (int k = NODES - 1; k > 0; k--)
            poly[k] = poly[k - 1] - ibl_gauss_node[i] * poly[k];
        poly[0] = f[i] - ibl_gauss_node[i] * poly[0];
    }
    memcpy(c, poly, sizeof poly);
}

/* Whether a piece is as near to the lobe as ibl_radial_table says. What lies
 * before the first whole octave, where a lobe that ends in a fractional power
 * of v has fallen to a millionth, may be a little off. */
static int near_enough(const side *s, int bits, int piece, double peak)
{
    const double octave = ldexp(1, (piece >> bits) - s->octaves);
    const double width = octave / (1 << bits);
    const double from =
        octave + width * (piece & ((1 << bits) - 1)) - start_of(s);
    const double slack = piece >> bits ? 0 : 3e-8 * peak;
    double c[4];
    fit(s, bits, piece, c);
    for (int i = 0; i <= 2; i++) {
        const double x = 0.5 * i, truth = value(s, from + x * width);
        const double fitted = ((c[3] * x + c[2]) * x + c[1]) * x + c[0];
        const double limit = 8e-7 * fmax(truth, 1e-8 * peak) + slack;
        if (fabs(fitted - truth) > limit)
            return 0;
    }
    return 1;
}

/* The fewest pieces that do, as far as the first and the middle one of each
 * octave tell. */
static int bits_of(const side *s, double peak)
{
    int bits = MIN_BITS;
    for (int k = 0; k < s->octaves && bits < MAX_BITS;) {
        if (near_enough(s, bits, k << bits, peak) &&
            near_enough(s, bits, (2 * k + 1) << (bits - 1), peak))
            k++;
        else
            bits++;
    }
    return bits;
}

static int float_bits(float x, int shift)
{
    int word;
    memcpy(&word, &x, sizeof word);
    return word >> shift;
}

static void fill(const side *s, int bits, double scale, float *coef)
{
    for (int piece = 0; piece < pieces_of(s, bits); piece++) {
        double c[4];
        fit(s, bits, piece, c);
        /* Denormals would cost time and are nothing beside a peak. */
        for (int k = 0; k < 4; k++)
            coef[4 * piece + k] =
                fabs(c[k] * scale) < 1e-36 ? 0 : (float)(c[k] * scale);
    }
}

ibl_status ibl_radial_table(ibl_ctx *ctx, ibl_chord_fn *weight, const void *arg,
                            ibl_radial *out)
{
    side s[2] = {{weight, arg, 0, MAX_OCTAVES}, {weight, arg, 1, MAX_OCTAVES}};
    const double peak = peak_of(s);
    int bits = MIN_BITS;
    *out = (ibl_radial){0};
    for (int h = 0; h < 2; h++) {
        s[h].octaves = octaves_of(&s[h], peak);
        const int wanted = bits_of(&s[h], peak);
        bits = wanted > bits ? wanted : bits;
    }
    const double whole = integral(&s[0]) + integral(&s[1]);
    if (!(whole > 0 && whole < INFINITY))
        return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                        "a lobe whose integral is %g: must be positive and "
                        "finite",
                        whole);
    const int pieces = pieces_of(&s[0], bits);
    out->coef = ibl_alloc_array((size_t)(pieces + pieces_of(&s[1], bits)),
                                4 * sizeof *out->coef);
    if (!out->coef)
        return ibl_no_memory(ctx, "a lobe's table");
    out->bits = bits;
    fill(&s[0], bits, 1 / whole, out->coef);
    fill(&s[1], bits, 1 / whole, out->coef + 4 * (size_t)pieces);
    for (int h = 0; h < 2; h++) {
        out->start[h] = (float)start_of(&s[h]);
        out->base[h] = float_bits(out->start[h], 23 - bits) - h * pieces;
    }
    return IBL_OK;
}

void ibl_radial_free(ibl_radial *lobe)
{
    if (!lobe)
        return;
    ibl_free(lobe->coef);
    *lobe = (ibl_radial){0};
}

/* ---- GGX --------------------------------------------------------------- */

/* The formula of kern/radial.h with a peak of 1; arg is the slope. */
static double ggx_weight(double chord, const void *arg)
{
    const double q = chord * chord, t = 1 + *(const double *)arg * q;
    return (q < 2 ? 1 - 0.5 * q : 0) / (t * t);
}

/* sin^2 h + alpha^2 cos^2 h = alpha^2 + (1 - alpha^2) q / 4. */
void ibl_radial_ggx(double alpha, ibl_radial *out)
{
    const double a2 = alpha * alpha, slope = 0.25 * (1 - a2) / a2;
    side s[2] = {{ggx_weight, &slope, 0, 0}, {ggx_weight, &slope, 1, 0}};
    for (int h = 0; h < 2; h++)
        s[h].octaves = octaves_of(&s[h], 1);
    *out =
        (ibl_radial){.peak = (float)(1 / (integral(&s[0]) + integral(&s[1]))),
                     .slope = (float)slope};
}

/* ---- the lights -------------------------------------------------------- */

/* What holds a group of lights, or the texels of a block. */
struct cap {
    double centre[3], sine, cosine; /* of its radius, at most pi / 2 */
};

/* Their points and, of each light, one for where it is far, by groups. */
struct group {
    struct cap cap;
    int near, far; /* the first of them */
};

struct ibl_bright {
    int count, groups;
    double sine, cosine;     /* of the distance from which lights are far */
    ibl_radial_light *light; /* in a face's axes: forward, right and down */
    ibl_radial_light *far;
    struct group *group; /* and one more, of each face */
    int lights;
};

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* About count directions. */
static struct cap cap_around(const double (*d)[3], int count)
{
    struct cap cap = {.sine = 1};
    double least = 1;

    for (int i = 0; i < count; i++)
        for (int k = 0; k < 3; k++)
            cap.centre[k] += d[i][k];
    const double length = sqrt(dot(cap.centre, cap.centre));
    if (!(length > 1e-3))
        return cap;
    for (int k = 0; k < 3; k++)
        cap.centre[k] /= length;
    for (int i = 0; i < count; i++)
        least = fmin(least, dot(cap.centre, d[i]));
    cap.cosine = fmax(least, 0);
    cap.sine = sqrt(fmax(1 - cap.cosine * cap.cosine, 0));
    return cap;
}

static void turn_light(const ibl_light *light, int face, ibl_radial_light *out)
{
    const ibl_face_axes *axes = &ibl_face[face];
    const double d[3] = {ibl_face_along(axes->forward, light->direction),
                         ibl_face_along(axes->right, light->direction),
                         ibl_face_along(axes->down, light->direction)};
    for (int k = 0; k < 3; k++) {
        out->at[k] = (float)d[k];
        out->rest[k] = (float)(d[k] - (double)out->at[k]);
        out->rgb[k] = light->energy[k];
    }
    out->rgb[3] = 0;
}

static double energy_of(const ibl_light *l)
{
    return (double)l->energy[0] + (double)l->energy[1] + (double)l->energy[2];
}

ibl_light ibl_light_middle(const ibl_light *points, int count)
{
    double direction[3] = {0}, energy[3] = {0};
    ibl_light out = points[0];

    for (int i = 0; i < count; i++)
        for (int k = 0; k < 3; k++) {
            direction[k] += points[i].direction[k] * energy_of(&points[i]);
            energy[k] += (double)points[i].energy[k];
        }
    const double length = sqrt(dot(direction, direction));
    for (int k = 0; k < 3 && count > 1; k++) {
        if (length > 0)
            out.direction[k] = direction[k] / length;
        out.energy[k] = (float)energy[k];
    }
    return out;
}

static int first_of(const int *first, int light)
{
    return first ? first[light] : light;
}

/* The end of a group: lights that are next to one another, so that what is far
 * from one is from all. */
static int end_of_group(const ibl_light *lights, const int *first, int count,
                        int from)
{
    const double *d = lights[first_of(first, from)].direction;
    int to = from + 1;
    while (to < count && to < from + GROUP &&
           dot(d, lights[first_of(first, to)].direction) > 1 - 5e-4)
        to++;
    return to;
}

/* A group of a face. */
static struct group turn_group(const ibl_bright *b, const ibl_light *lights,
                               const int *first, int from, int to, int face)
{
    struct group group = {.near = face * b->count + first_of(first, from),
                          .far = face * b->lights + from};
    double middle[GROUP][3], least = 1;

    for (int i = from; i < to; i++) {
        const int at = first_of(first, i);
        const ibl_light far =
            ibl_light_middle(lights + at, first_of(first, i + 1) - at);
        ibl_radial_light *out = &b->far[face * b->lights + i];
        turn_light(&far, face, out);
        for (int k = 0; k < 3; k++)
            middle[i - from][k] = (double)out->at[k];
    }
    group.cap = cap_around(middle, to - from);
    for (int i = first_of(first, from); i < first_of(first, to); i++) {
        ibl_radial_light *out = &b->light[face * b->count + i];
        turn_light(&lights[i], face, out);
        const double at[3] = {(double)out->at[0], (double)out->at[1],
                              (double)out->at[2]};
        least = fmin(least, dot(group.cap.centre, at));
    }
    group.cap.cosine = fmax(fmin(group.cap.cosine, least), 0);
    group.cap.sine = sqrt(1 - group.cap.cosine * group.cap.cosine);
    return group;
}

ibl_status ibl_bright_create(ibl_ctx *ctx, const ibl_light *lights,
                             const int *first, int count, double distance,
                             ibl_bright **out)
{
    const size_t points = (size_t)first_of(first, count), n = (size_t)count;
    ibl_bright *b = *out = ibl_alloc_zeroed(1, sizeof *b);
    if (!b)
        return ibl_no_memory(ctx, "bright pixels");
    *b = (ibl_bright){.count = (int)points,
                      .lights = count,
                      .sine = distance < IBL_PI ? sin(distance) : 0,
                      .cosine = distance < IBL_PI ? cos(distance) : -INFINITY};
    for (int i = 0; i < count; i = end_of_group(lights, first, count, i))
        b->groups++;
    b->light = ibl_alloc_array(IBL_FACES * points + 1, sizeof *b->light);
    b->far = ibl_alloc_array(IBL_FACES * n + 1, sizeof *b->far);
    b->group =
        ibl_alloc_array(IBL_FACES * ((size_t)b->groups + 1), sizeof *b->group);
    if (!b->light || !b->far || !b->group) {
        ibl_bright_free(b);
        *out = NULL;
        return ibl_no_memory(ctx, "bright pixels");
    }
    for (int face = 0; face < IBL_FACES; face++) {
        struct group *group = b->group + face * (b->groups + 1);
        for (int i = 0, to; i < count; i = to) {
            to = end_of_group(lights, first, count, i);
            *group++ = turn_group(b, lights, first, i, to, face);
        }
        *group = (struct group){.near = (face + 1) * b->count,
                                .far = (face + 1) * count};
    }
    return IBL_OK;
}

void ibl_bright_free(ibl_bright *bright)
{
    if (!bright)
        return;
    ibl_free(bright->light);
    ibl_free(bright->far);
    ibl_free(bright->group);
    ibl_free(bright);
}

int ibl_bright_count(const ibl_bright *bright)
{
    return bright->count;
}

enum kind {
    BELOW,
    NEAR,
    FAR
};

/* Where a group is for a block: below the horizon of all of it, or else far
 * from all of it, or neither. */
static enum kind kind_of(const ibl_bright *b, const struct cap *block,
                         const struct cap *group)
{
    const double slack = 1e-6; /* points are floats */
    const double cosine = dot(block->centre, group->centre);
    /* Of the sum of the radii. */
    const double s = block->sine * group->cosine + block->cosine * group->sine;
    const double c = block->cosine * group->cosine - block->sine * group->sine;

    if (c <= 0)
        return NEAR;
    if (cosine < -s - slack)
        return BELOW;
    return cosine < c * b->cosine - s * b->sine ? FAR : NEAR;
}

void ibl_bright_add(const ibl_bright *bright, int face,
                    const ibl_radial_dsp *dsp, const ibl_radial *lobe,
                    const float *point, float *rgba)
{
    const struct group *group = bright->group + face * (bright->groups + 1);
    double end[2][3];

    for (int k = 0; k < 3; k++) {
        end[0][k] = (double)point[k * IBL_RADIAL_BLOCK];
        end[1][k] = (double)point[(k + 1) * IBL_RADIAL_BLOCK - 1];
    }
    /* A row of a face is a part of a great circle. */
    const struct cap block = cap_around(end, 2);
    for (int i = 0, next; i < bright->groups; i = next) {
        const enum kind kind = kind_of(bright, &block, &group[i].cap);
        next = i + 1;
        while (next < bright->groups &&
               kind_of(bright, &block, &group[next].cap) == kind)
            next++;
        const ibl_radial_light *light = kind == FAR
                                            ? bright->far + group[i].far
                                            : bright->light + group[i].near;
        const int count = kind == FAR ? group[next].far - group[i].far
                                      : group[next].near - group[i].near;
        if (kind != BELOW)
            dsp->add(lobe, light, count, point, IBL_RADIAL_BLOCK, rgba);
    }
}
