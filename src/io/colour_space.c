/* SPDX-License-Identifier: MIT */
#include "io/colour_space.h"

#include <math.h>
#include <stddef.h>
#include <string.h>

/* The inverse times the determinant, which is returned. */
static double adjugate(const double m[9], double inv[9])
{
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++) {
            const int a = (j + 1) % 3, b = (j + 2) % 3;
            const int c = (i + 1) % 3, d = (i + 2) % 3;
            inv[3 * i + j] =
                m[3 * a + c] * m[3 * b + d] - m[3 * a + d] * m[3 * b + c];
        }
    }
    return m[0] * inv[0] + m[1] * inv[3] + m[2] * inv[6];
}

static void invert(const double m[9], double inv[9])
{
    const double det = adjugate(m, inv);
    for (int i = 0; i < 9; i++)
        inv[i] /= det;
}

/* The columns of P are the XYZ of the primaries, each up to a factor. W = P s
 * gives the factors: R = G = B with Y = 1 is white. The result is the inverse
 * of P diag(s). */
bool ibl_colour_space(const double xy[8], double rgb_from_xyz[9], float luma[3])
{
    double p[9], inv[9];
    for (int i = 0; i < 3; i++) {
        p[i] = xy[2 * i];
        p[3 + i] = xy[2 * i + 1];
        p[6 + i] = 1 - p[i] - p[3 + i];
    }
    const double det = adjugate(p, inv);
    const double x = xy[6], y = xy[7];
    if (!(fabs(det) > 1e-6) || !(fabs(y) > 1e-6))
        return false;
    for (int i = 0; i < 3; i++) {
        const double s = (inv[3 * i] * x + inv[3 * i + 1] * y +
                          inv[3 * i + 2] * (1 - x - y)) /
                         (det * y);
        if (!(fabs(s) > 1e-6))
            return false;
        for (int j = 0; j < 3; j++)
            rgb_from_xyz[3 * i + j] = inv[3 * i + j] / (det * s);
        if (luma)
            luma[i] = (float)(p[3 + i] * s);
    }
    for (int i = 0; i < 9; i++)
        if (!(fabs(rgb_from_xyz[i]) < 1e6))
            return false;
    return true;
}

typedef struct space {
    const char *name;
    double xy[8];
    int khronos; /* number in the data format specification 1.3, 5.6 */
} space;

static const space spaces[] = {
    {"Rec.709", {.64, .33, .30, .60, .15, .06, .3127, .3290}, 1},
    {"ACEScg", {.713, .293, .165, .830, .128, .044, .32168, .33767}, 7},
    {"Rec.2020", {.708, .292, .170, .797, .131, .046, .3127, .3290}, 4},
    {"ACES2065-1", {.7347, .2653, 0, 1, .0001, -.077, .32168, .33767}, 6},
    {"Display P3", {.680, .320, .265, .690, .150, .060, .3127, .3290}, 10},
    {"DCI-P3", {.680, .320, .265, .690, .150, .060, .314, .351}, 0},
    {"Adobe RGB", {.64, .33, .21, .71, .15, .06, .3127, .3290}, 11},
    {"Radiance's", {.640, .330, .290, .600, .150, .060, 1 / 3., 1 / 3.}, 0},
    {"Rec.601 (625 lines)", {.64, .33, .29, .60, .15, .06, .3127, .3290}, 2},
    {"Rec.601 (525 lines)", {.63, .34, .31, .595, .155, .07, .3127, .3290}, 3},
    {"CIE XYZ", {1, 0, 0, 1, 0, 0, 1 / 3., 1 / 3.}, 5},
    {"NTSC 1953", {.67, .33, .21, .71, .14, .08, .310, .316}, 8},
};

const char *ibl_primaries_name(ibl_primaries primaries)
{
    static const char *const names[] = {"keep", "rec709", "acescg", "rec2020"};
    return (unsigned)primaries <= IBL_PRIMARIES_REC2020 ? names[primaries]
                                                        : "unknown";
}

const double *ibl_primaries_xy(ibl_primaries primaries)
{
    return spaces[primaries - IBL_PRIMARIES_REC709].xy;
}

static const space *find_space(const double xy[8])
{
    for (size_t i = 0; i < sizeof spaces / sizeof *spaces; i++) {
        bool equal = true;
        for (int k = 0; k < 8; k++)
            equal &= fabs(xy[k] - spaces[i].xy[k]) <= 0.002;
        if (equal)
            return &spaces[i];
    }
    return NULL;
}

const char *ibl_colour_space_name(const double xy[8])
{
    const space *s = find_space(xy);
    return s ? s->name : NULL;
}

int ibl_khronos_number(const double xy[8])
{
    const space *s = find_space(xy);
    return s && s->khronos ? s->khronos : IBL_UNKNOWN_PRIMARIES;
}

const double *ibl_khronos_xy(int number)
{
    for (size_t i = 0; i < sizeof spaces / sizeof spaces[0]; i++)
        if (number > 0 && spaces[i].khronos == number)
            return spaces[i].xy;
    return NULL;
}

static void multiply(const double a[9], const double b[9], double out[9])
{
    double m[9];
    for (int i = 0; i < 9; i++)
        m[i] = a[i / 3 * 3] * b[i % 3] + a[i / 3 * 3 + 1] * b[3 + i % 3] +
               a[i / 3 * 3 + 2] * b[6 + i % 3];
    memcpy(out, m, sizeof m);
}

/* XYZ under one white to XYZ that looks the same under the other, by their cone
 * responses. False: a y or a response is 0. */
static bool adapt(const double from[2], const double to[2], double matrix[9])
{
    static const double cones[9] = {0.8951, 0.2664, -0.1614, -0.7502, 1.7135,
                                    0.0367, 0.0389, -0.0685, 1.0296};
    double gains[9] = {0};

    if (!(fabs(from[1]) > 1e-6) || !(fabs(to[1]) > 1e-6))
        return false;
    for (int i = 0; i < 3; i++) {
        double response[2];
        for (int k = 0; k < 2; k++) {
            const double *white = k ? to : from;
            const double x = white[0] / white[1];
            const double z = (1 - white[0]) / white[1] - 1;
            response[k] =
                cones[3 * i] * x + cones[3 * i + 1] + cones[3 * i + 2] * z;
            if (!(fabs(response[k]) > 1e-6))
                return false;
        }
        gains[4 * i] = response[1] / response[0];
    }
    invert(cones, matrix);
    multiply(matrix, gains, matrix);
    multiply(matrix, cones, matrix);
    return true;
}

bool ibl_colour_matrix(const double from[8], const double to[8],
                       double matrix[9], float luma[3])
{
    double rgb_from_xyz[9], xyz_from_rgb[9], adaptation[9];

    if (!ibl_colour_space(from, rgb_from_xyz, NULL))
        return false;
    invert(rgb_from_xyz, xyz_from_rgb);
    if (!ibl_colour_space(to, rgb_from_xyz, luma) ||
        !adapt(from + 6, to + 6, adaptation))
        return false;
    multiply(rgb_from_xyz, adaptation, matrix);
    multiply(matrix, xyz_from_rgb, matrix);
    return true;
}
