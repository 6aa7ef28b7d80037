/* SPDX-License-Identifier: MIT */
/*
 * k_l is the integral over the angle psi in 0..pi / 2 of
 *     2 pi K sin(psi) P_l(cos(psi)).
 * P_l behaves like a cosine of (l + 1/2) psi: a Gauss-Legendre panel of POINTS
 * points covers up to PHASE radians of the highest degree. Shorter panels
 * depend on the lobe:
 *
 *   GGX      analytic except for poles at about +-2 i alpha: the first panel
 *            is a multiple of alpha long, the next ones grow in proportion.
 *   Charlie  about exp(-s x), x from the horizon, which counts as a phase of
 *            s per radian. A narrow lobe is cut off where it is negligible.
 *            In a wide one psi^(2 s) at 0 is no polynomial: psi = u^2 there
 *            doubles the power.
 *   Phong    about a Gaussian of variance 1 / n. The same, mirrored:
 *            x^(n + 1) at the horizon if the lobe is wide.
 *
 * The horizon is always the end of a panel.
 */
#include "bake/spectral/lobe_coefficients.h"

#include <assert.h>
#include <math.h>
#include <stdbool.h>

#include "brdf/lobe.h"
#include "core/alloc.h"
#include "core/context.h"
#include "kern/legendre_sums.h"

enum {
    POINTS = 64 /* in a panel; a multiple of IBL_LEGENDRE_SUMS_POINTS */
};

static const double PHASE = 130;
/* Length of GGX's first panel over alpha; of the next over their distance. */
static const double FIRST = 16, GROWTH = 7;
/* Phase that Phong's Gaussian counts as, in radians over its width. */
static const double BEND = 12;
/* Values below exp(-NOTHING) of the peak are left out. */
static const double NOTHING = 46;
/* Powers above this are smooth enough for POINTS points. */
static const double SMOOTH = 16;

/* The 64-point rule on -1..1, abscissas above 0 and weights: Newton's method
 * on P_64 in 40 digits. */
static const double gauss[POINTS / 2][2] = {
    {0.024350292663424432509, 0.048690957009139720383},
    {0.07299312178779903945, 0.048575467441503426935},
    {0.12146281929612055447, 0.04834476223480295717},
    {0.16964442042399281804, 0.047999388596458307728},
    {0.21742364374000708415, 0.047540165714830308662},
    {0.26468716220876741637, 0.046968182816210017325},
    {0.31132287199021095616, 0.046284796581314417296},
    {0.35722015833766811595, 0.04549162792741814448},
    {0.4022701579639916037, 0.04459055816375656306},
    {0.44636601725346408798, 0.043583724529323453377},
    {0.48940314570705295748, 0.042473515123653589007},
    {0.53127946401989454566, 0.04126256324262352861},
    {0.57189564620263403428, 0.039953741132720341387},
    {0.61115535517239325025, 0.038550153178615629129},
    {0.64896547125465733986, 0.03705512854024004604},
    {0.68523631305423324256, 0.035472213256882383811},
    {0.71988185017161082685, 0.033805161837141609392},
    {0.75281990726053189661, 0.032057928354851553585},
    {0.78397235894334140761, 0.030234657072402478868},
    {0.81326531512279755974, 0.028339672614259483228},
    {0.84062929625258036275, 0.026377469715054658672},
    {0.86599939815409281976, 0.024352702568710873338},
    {0.88931544599511410585, 0.022270173808383254159},
    {0.91052213707850280576, 0.020134823153530209372},
    {0.92956917213193957582, 0.017951715775697343085},
    {0.94641137485840281606, 0.015726030476024719322},
    {0.96100879965205371892, 0.013463047896718642598},
    {0.97332682778991096374, 0.011168139460131128819},
    {0.98333625388462595693, 0.008846759826363947723},
    {0.99101337147674432074, 0.0065044579689783628561},
    {0.99634011677195527935, 0.0041470332605624676353},
    {0.99930504173577213946, 0.0017832807216964329473},
};

/* ---- points ------------------------------------------------------------ */

/* The end of a panel where psi = u^2 makes a power smooth. */
typedef enum bend {
    STRAIGHT,
    BENT_LOW,
    BENT_HIGH
} bend;

typedef struct points {
    ibl_lobe_shape shape;
    bool from_horizon; /* angles are measured from there, else from R */
    double *y, *w;     /* NULL: only count */
    int count;
} points;

static void add_point(points *p, double angle, double mass)
{
    const double s = sin(p->from_horizon ? angle : 0.5 * angle);
    const double q = p->from_horizon ? 0.5 - 0.5 * s : s * s;
    const double cosine = p->from_horizon ? s : 1 - 2 * q;
    p->y[p->count] = 2 * q;
    /* sin(psi) = 2 sqrt(q (1 - q)). */
    p->w[p->count++] = mass * 4 * IBL_PI * sqrt(q * (1 - q)) *
                       ibl_lobe_value(&p->shape, q, cosine);
}

static void add_panel(points *p, double from, double to, bend bent)
{
    const double length = to - from;
    if (!p->y) {
        p->count += POINTS;
        return;
    }
    for (int i = 0; i < POINTS; i++) {
        const double *g = gauss[i < POINTS / 2 ? i : i - POINTS / 2];
        const double u = 0.5 * (i < POINTS / 2 ? 1 - g[0] : 1 + g[0]);
        const double mass = 0.5 * length * g[1];
        if (bent == BENT_LOW)
            add_point(p, from + length * u * u, mass * 2 * u);
        else if (bent == BENT_HIGH)
            add_point(p, to - length * u * u, mass * 2 * u);
        else
            add_point(p, from + length * u, mass);
    }
}

/* Panels of equal length, none longer than step. */
static void add_panels(points *p, double from, double to, double step)
{
    const double wanted = ceil((to - from) / step - 1e-9);
    const int count = wanted > 1 ? (int)wanted : 1;
    for (int i = 0; i < count; i++)
        add_panel(p, from + (to - from) * i / count,
                  i + 1 < count ? from + (to - from) * (i + 1) / count : to,
                  STRAIGHT);
}

static void add_ggx(points *p, int degree)
{
    const double step = PHASE / (degree + 1), end = IBL_PI / 2;
    double at = 0;
    for (;;) {
        const double growth = at > 0 ? GROWTH * at : FIRST * p->shape.alpha;
        if (growth >= step || at + growth >= end)
            break;
        add_panel(p, at, at + growth, STRAIGHT);
        at += growth;
    }
    add_panels(p, at, end, step);
}

static void add_charlie(points *p, int degree)
{
    const double s = p->shape.power, step = PHASE / (degree + s + 1);
    if (s > SMOOTH) {
        /* (1 - cos(psi))^s is negligible beyond this. */
        p->from_horizon = true;
        add_panels(p, 0, asin(-expm1(-NOTHING / s)), step);
        return;
    }
    const double first = fmin(0.5 * step, IBL_PI / 2);
    add_panel(p, 0, first, BENT_LOW);
    if (first < IBL_PI / 2)
        add_panels(p, first, IBL_PI / 2, step);
}

static void add_phong(points *p, int degree)
{
    const double n = p->shape.power + 1;
    const double step = PHASE / (degree + BEND * sqrt(n) + 1);
    /* cos(psi)^n is negligible beyond this. */
    const double stop = 2 * asin(sqrt(-0.5 * expm1(-NOTHING / n)));
    if (n > SMOOTH) {
        add_panels(p, 0, stop, step);
        return;
    }
    const double last = IBL_PI / 2 - fmin(0.5 * step, IBL_PI / 2);
    if (last > 0)
        add_panels(p, 0, last, step);
    add_panel(p, last, IBL_PI / 2, BENT_HIGH);
}

static void add_points(points *p, int degree)
{
    p->count = 0;
    switch (p->shape.lobe) {
    case IBL_LOBE_CHARLIE:
        add_charlie(p, degree);
        break;
    case IBL_LOBE_PHONG:
        add_phong(p, degree);
        break;
    case IBL_LOBE_GGX:
        add_ggx(p, degree);
        break;
    }
}

/* ---- the calls --------------------------------------------------------- */

ibl_status ibl_lobe_coefficients(ibl_ctx *ctx, const ibl_lobe_shape *shape,
                                 int degree, double *k)
{
    ibl_legendre_sums_dsp dsp;
    points p = {.shape = *shape};
    add_points(&p, degree);
    const size_t count = (size_t)p.count, degrees = (size_t)degree + 1;
    double *memory = ibl_alloc_array(
        2 * count + (1 + IBL_LEGENDRE_SUMS_SCRATCH) * degrees, sizeof *memory);
    if (!memory)
        return ibl_no_memory(ctx, "the coefficients of a lobe");
    p.y = memory;
    p.w = p.y + count;
    double *inverse = p.w + count, *scratch = inverse + degrees;
    add_points(&p, degree);
    for (int l = 0; l <= degree; l++)
        inverse[l] = 1.0 / (l + 1);
    ibl_legendre_sums_dsp_init(&dsp, ibl_ctx_isa(ctx));
    dsp.sums(p.y, p.w, p.count, inverse, degree, scratch, k);
    ibl_free(memory);
    return IBL_OK;
}

static double energy(const double *k, int from, int to)
{
    double sum = 0;
    for (int l = to; l >= from; l--)
        sum += (2 * l + 1) * k[l] * k[l];
    return sum;
}

/* In the end the sum of (2 l + 1) k_l^2 from a degree on falls as
 * degree^-corner: a lobe that ends on the horizon as x^p has k_l ~
 * l^(-p - 3/2). */
static double corner_of(const ibl_lobe_shape *s)
{
    return 2 * s->end + 1;
}

/* Whether it already does: the last two octaves have that ratio. A faster fall
 * drowns in rounding instead. */
static bool is_corner(const double *k, int degree, double corner)
{
    const double last = energy(k, degree / 2 + 1, degree);
    const double before = energy(k, degree / 4 + 1, degree / 2);
    return degree >= 64 && last > 0 && fabs(log2(before / last) - corner) < 0.1;
}

/* The degree that ibl_lobe_degree wants, or -1 if k is too short. */
static int band_of(const double *k, int degree, double corner, double tail,
                   int limit)
{
    /* Too large before the corner's law holds. */
    double sum = energy(k, degree / 2 + 1, degree) / (exp2(corner) - 1);
    const double left = tail * tail * (energy(k, 0, degree) + sum);
    int l = degree;
    if (sum > left / 4 && is_corner(k, degree, corner))
        return (int)fmin(limit, ceil(degree * pow(sum / left, 1 / corner)));
    if (sum > left / 4)
        return -1;
    while (l > 0 && sum + (2 * l + 1) * k[l] * k[l] < left) {
        sum += (2 * l + 1) * k[l] * k[l];
        l--;
    }
    return l;
}

ibl_status ibl_lobe_degree(ibl_ctx *ctx, const ibl_lobe_shape *shape,
                           double tail, int limit, int *degree)
{
    assert(tail >= 1e-12 && tail <= 1);
    const double corner = corner_of(shape);
    /* Twice the l where GGX, which falls as exp(-2 alpha l), is the tail: the
     * second half of the degrees shows that. */
    const double guess =
        fmin((1.25 - 1.2 * log(tail)) / shape->alpha, 2.0 * limit);
    for (double n = guess < 64 ? 16 : guess;; n *= 2) {
        const int tried = (int)n;
        double *k = ibl_alloc_array((size_t)tried + 1, sizeof *k);
        if (!k)
            return ibl_no_memory(ctx, "the coefficients of a lobe");
        const ibl_status status = ibl_lobe_coefficients(ctx, shape, tried, k);
        const int band = status ? 0 : band_of(k, tried, corner, tail, limit);
        ibl_free(k);
        if (status)
            return status;
        if (band >= 0 || tried / 2 >= limit) {
            *degree = band >= 0 && band < limit ? band : limit;
            return IBL_OK;
        }
    }
}
