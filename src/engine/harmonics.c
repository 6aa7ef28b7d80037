/* SPDX-License-Identifier: MIT */
#include "engine/harmonics.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "ibl/ibl.h"

const char *const ibl_sh_format_names[] = {[IBL_SH_NONE] = "none",
                                           [IBL_SH_CMGEN] = "cmgen",
                                           [IBL_SH_THREE] = "three",
                                           [IBL_SH_CESIUM] = "cesium",
                                           NULL};

/* Degree of each coefficient, and the square of its basis constant, times pi:
 * sqrt(1/4pi), sqrt(3/4pi), sqrt(15/4pi), sqrt(5/16pi), sqrt(15/16pi). */
static const int degree[IBL_SH_NINE] = {0, 1, 1, 1, 2, 2, 2, 2, 2};
static const double square[IBL_SH_NINE] = {1.0 / 4,  3.0 / 4,  3.0 / 4,
                                           3.0 / 4,  15.0 / 4, 15.0 / 4,
                                           5.0 / 16, 15.0 / 4, 15.0 / 16};

void ibl_sh_shader(const double *sh, double shader[IBL_SH_NINE][3])
{
    for (int i = 0; i < IBL_SH_NINE; i++)
        for (int c = 0; c < 3; c++)
            shader[i][c] = sh[3 * i + c] * ibl_sh_cosine(degree[i]) *
                               sqrt(square[i] / M_PI) +
                           0.0; /* no -0 */
}

/* x y z are of l = 1. l = 0 is spread over xx yy zz, whose sum is 1. */
void ibl_sh_polynomial(const double *sh, double polynomial[IBL_SH_NINE][3])
{
    const double one = ibl_sh_cosine(1), two = ibl_sh_cosine(2);
    double s[IBL_SH_NINE][3];

    ibl_sh_shader(sh, s);
    for (int c = 0; c < 3; c++) {
        const double p[IBL_SH_NINE] = {one * s[3][c],
                                       one * s[1][c],
                                       one * s[2][c],
                                       s[0][c] + two * (s[8][c] - s[6][c]),
                                       s[0][c] - two * (s[8][c] + s[6][c]),
                                       s[0][c] + two * 2 * s[6][c],
                                       two * s[5][c],
                                       two * s[7][c],
                                       two * s[4][c]};
        for (int i = 0; i < IBL_SH_NINE; i++)
            polynomial[i][c] = p[i] + 0.0;
    }
}

void ibl_sh_gltf(const double *sh, double gltf[IBL_SH_NINE][3])
{
    static const int sign[IBL_SH_NINE] = {1, -1, 1, -1, 1, -1, 1, -1, 1};

    for (int i = 0; i < IBL_SH_NINE; i++)
        for (int c = 0; c < 3; c++)
            gltf[i][c] =
                sign[i] * M_PI * ibl_sh_cosine(degree[i]) * sh[3 * i + c] + 0.0;
}

void ibl_sh_least(const double *sh, double least[3])
{
    const int n = 16;
    double s[IBL_SH_NINE][3], d[3];

    ibl_sh_shader(sh, s);
    for (int c = 0; c < 3; c++)
        least[c] = INFINITY;
    for (int i = 0; i < IBL_FACES * n * n; i++) {
        ibl_cube_direction(n, i / (n * n), i % n, i / n % n, d);
        const double x = d[0], y = d[1], z = d[2];
        for (int c = 0; c < 3; c++)
            least[c] =
                fmin(least[c], s[0][c] + s[1][c] * y + s[2][c] * z +
                                   s[3][c] * x + s[4][c] * x * y +
                                   s[5][c] * y * z + s[6][c] * (3 * z * z - 1) +
                                   s[7][c] * z * x + s[8][c] * (x * x - y * y));
    }
}

void ibl_sh_window(int last, double window, double *sh)
{
    for (int l = 1; l <= last; l++) {
        const double x = M_PI * l / window;
        const double w = l >= window ? 0 : x > 0 ? pow(sin(x) / x, 4) : 1;
        for (int i = 3 * l * l; i < 3 * (l + 1) * (l + 1); i++)
            sh[i] *= w;
    }
}

double ibl_sh_widest_window(const double *sh)
{
    double low = 1, high = 64, least[3]; /* 64 takes .5 % off l = 2 */
    double nine[3 * IBL_SH_NINE];

    ibl_sh_least(sh, least);
    if (fmin(fmin(least[0], least[1]), least[2]) >= 0)
        return INFINITY;
    while (high - low > 1e-6) {
        const double middle = (low + high) / 2;
        memcpy(nine, sh, sizeof nine);
        ibl_sh_window(2, middle, nine);
        ibl_sh_least(nine, least);
        if (fmin(fmin(least[0], least[1]), least[2]) >= 0)
            low = middle;
        else
            high = middle;
    }
    return low;
}

char *ibl_sh_text(ibl_sh_format format, const double *sh)
{
    char text[IBL_SH_NINE * 256] = "";
    double s[IBL_SH_NINE][3];

    ibl_sh_shader(sh, s);
    for (int i = 0, l = 0; i < IBL_SH_NINE; i++) {
        const size_t used = strlen(text), left = sizeof text - used;
        const char *begin = i ? "  " : "[ ";
        const char *end = i < IBL_SH_NINE - 1 ? ",\n" : " ]\n";
        l += i > l * (l + 2);
        if (format == IBL_SH_NONE)
            snprintf(text + used, left, "%.9g %.9g %.9g\n", s[i][0], s[i][1],
                     s[i][2]);
        else if (format == IBL_SH_CMGEN)
            snprintf(text + used, left,
                     "(%18.15f, %18.15f, %18.15f); // L%d%d, irradiance, "
                     "pre-scaled base\n",
                     s[i][0], s[i][1], s[i][2], l, i - l * (l + 1));
        else if (format == IBL_SH_CESIUM)
            snprintf(text + used, left, "%s%.9g, %.9g, %.9g%s", begin, s[i][0],
                     s[i][1], s[i][2], end);
        else
            snprintf(text + used, left, "%s%.9g, %.9g, %.9g%s", begin,
                     sh[3 * i] + 0.0, sh[3 * i + 1] + 0.0, sh[3 * i + 2] + 0.0,
                     end);
    }
    return strdup(text);
}
