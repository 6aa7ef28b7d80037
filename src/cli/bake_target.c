/* SPDX-License-Identifier: MIT */
/* What an engine cannot show rightly of the options given beside its target. */
#include <math.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>

#include "cli/bake_record.h"
#include "common/names.h"
#include "common/path.h"

/* Options that an engine's shaders and loader decide. */
static const struct {
    const char *name, *of;
    size_t at; /* of an int or an enumeration in ibl_opts */
} decided[] = {
    {"mapping", "levels", offsetof(ibl_opts, bake.specular_options.mapping)},
    {"lobe", "levels", offsetof(ibl_opts, bake.specular_options.lobe)},
    {"mirror", "axes", offsetof(ibl_opts, axes.mirror)},
    {"up", "axes", offsetof(ibl_opts, axes.up)},
    {"layout", "cubes", offsetof(ibl_opts, layout)},
};

static const char *typed(const ibl_opts *o, const char *name)
{
    const char *value = ibl_given_value(&o->given, name);

    return value ? value : "";
}

/* No word of what is taken is a part of another. */
static bool check_files(const ibl_opts *o)
{
    const char *takes = o->of->takes, *format = ibl_format_names[o->file];
    const char *pixel = ibl_pixel_name(o->texels.pixel);
    const bool texture = o->file < IBL_CONTAINER_COUNT;
    char pair[64];

    snprintf(pair, sizeof pair, "%s%s", format, texture ? "/" : "");
    if (!strstr(takes, pair))
        return ibl_misuse("--format %s: the engine loads %s", format, takes);
    if (texture && !strstr(takes, strcat(pair, pixel)))
        return ibl_misuse("--pixel %s: the engine loads %s", pixel, takes);
    return !o->zstd || o->file != IBL_CONTAINER_KTX2 || strstr(takes, "zstd") ||
           ibl_misuse("--zstd %d: the engine loads %s without it", o->zstd,
                      takes);
}

static bool check_chain(const ibl_opts *o)
{
    const ibl_specular_options *s = &o->bake.specular_options;
    const int most = ibl_most_levels(s->size);
    const int levels = s->levels ? s->levels : most;

    if (s->roughness_min > 0 || s->roughness_max < 1)
        return ibl_misuse("--roughness-range %s: the engine looks up levels of "
                          "all roughnesses: leave it out",
                          typed(o, "roughness-range"));
    if (levels < 2)
        return ibl_misuse("--%s 1: is a mirror, for every roughness: take 2 or "
                          "more",
                          most < 2 ? "size" : "levels");
    if (o->of->whole && s->size & (s->size - 1))
        return ibl_misuse("--size %d: the engine needs a power of two",
                          s->size);
    if (o->of->whole && levels < most)
        return ibl_misuse("--levels %d: the engine needs all %d, down to 1x1",
                          levels, most);
    const int edge = ibl_pixel_block(o->texels.pixel);
    return edge == 1 || !(s->size % (edge << (levels - 1))) ||
           ibl_misuse(
               "--size %d: graphics need whole blocks of %dx%d texels in "
               "%d levels: take a multiple of %d",
               s->size, edge, edge, levels, edge << (levels - 1));
}

/* Whether a program's files are made. */
static bool check_program(const ibl_opts *o)
{
    static const ibl_output_kind kinds[] = {IBL_OUTPUT_SPECULAR,
                                            IBL_OUTPUT_IRRADIANCE};

    for (int i = 0; i < 2 && o->explain; i++) {
        const char *name = ibl_output_name(kinds[i]);
        char holder[32];
        snprintf(holder, sizeof holder, "{%s}", name);
        if (strstr(o->of->load, holder) && !(o->only & 1u << kinds[i]))
            return ibl_misuse("--explain: the program loads %s: add it to "
                              "--only",
                              name);
    }
    return true;
}

bool ibl_opts_fit_target(const ibl_opts *o, const ibl_opts *want)
{
    for (size_t i = 0; i < sizeof decided / sizeof *decided; i++)
        if (memcmp((const char *)o + decided[i].at,
                   (const char *)want + decided[i].at, sizeof(int)) != 0)
            return ibl_misuse("--%s %s: the engine has other %s: leave it out",
                              decided[i].name, typed(o, decided[i].name),
                              decided[i].of);
    if (o->of->harmonics && o->sh_format != want->sh_format)
        return ibl_misuse("--sh-format %s: the engine reads another: leave it "
                          "out",
                          typed(o, "sh-format"));
    if (o->filament && o->bake.sh_degree < 2)
        return ibl_misuse("--sh %d: the engine reads nine coefficients: leave "
                          "it out",
                          o->bake.sh_degree);
    return check_files(o) && check_chain(o) && check_program(o);
}

/* ---- harmonics -------------------------------------------------------- */

void ibl_warn_of_harmonics(const ibl_bake *b)
{
    const ibl_cube *cube = &b->made.irradiance;
    double exact[3] = {INFINITY, INFINITY, INFINITY}, least[3], d[3];
    double s[IBL_SH_NINE][3];
    const int n = cube->size;
    int worst = 0;

    memcpy(least, exact, sizeof least);
    ibl_sh_shader(b->from->made.sh, s);
    for (int i = 0; i < IBL_FACES * n * n; i++) {
        ibl_cube_direction(n, i / (n * n), i % n, i / n % n, d);
        const double x = d[0], y = d[1], z = d[2];
        for (int c = 0; c < 3; c++) {
            const double e = s[0][c] + s[1][c] * y + s[2][c] * z + s[3][c] * x +
                             s[4][c] * x * y + s[5][c] * y * z +
                             s[6][c] * (3 * z * z - 1) + s[7][c] * z * x +
                             s[8][c] * (x * x - y * y);
            exact[c] =
                fmin(exact[c], (double)ibl_cube_face(cube, 0, 0)[3 * i + c]);
            least[c] = fmin(least[c], e);
        }
    }
    for (int c = 1; c < 3; c++)
        if (least[c] * exact[worst] < least[worst] * exact[c])
            worst = c;
    if (least[worst] < exact[worst] / 2)
        ibl_console_warn(
            b->console,
            "%s: the engine lights matte surfaces by nine harmonics, which "
            "have %.3g of %s where the map has %.3g or more: a dark or "
            "coloured spot away from the sun: take it out with --sun",
            ibl_path_name(b->sh_path ? b->sh_path
                                     : b->files[IBL_OUTPUT_SPECULAR].path),
            least[worst], (const char *[]){"red", "green", "blue"}[worst],
            exact[worst]);
}
