/* SPDX-License-Identifier: MIT */
/*
 * Our blocks beside a peer's: errors, sizes with Zstandard 19, processor time.
 *
 *     bench_blocks DIR NAME UASTC_SECONDS BC6H_SECONDS
 *
 * reads the cubes DIR/rgba32f_specular.ktx2 and, of the peer,
 * DIR/peer_bc6h.ktx2 and DIR/peer_uastc-hdr.ktx2, which took it those seconds,
 * and prints a Markdown table.
 */
#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>

#include "ibl/io.h"
#include "test.h"

static const char *dir;
static ibl_ctx *ctx; /* of one thread */
static ibl_cube exact;

static void must(bool good, const char *what)
{
    if (!good) {
        fprintf(stderr, "bench_blocks: %s: %s\n", dir, what);
        exit(1);
    }
}

static void read_texture(const char *name, ibl_texture *tex)
{
    char path[4096];

    snprintf(path, sizeof path, "%s/%s.ktx2", dir, name);
    must(!ibl_texture_read(ctx, path, tex, NULL), name);
}

static double error_of(const ibl_pixel_error *e, bool relative)
{
    return relative ? e->relative : e->nrmse;
}

/* The geometric mean of e to the peer's over the levels, and the largest. */
static void tell_ratio(const ibl_pixel_error *e, const ibl_pixel_error *peer,
                       bool relative)
{
    double sum = 0, worst = 0;

    for (int l = 0; l < exact.levels; l++) {
        const double ratio =
            error_of(&e[l], relative) / error_of(&peer[l], relative);
        sum += log(ratio);
        worst = fmax(worst, ratio);
    }
    printf(" %.2f (%.2f) |", exp(sum / exact.levels), worst);
}

static void tell(const char *name, ibl_texture *tex, double ms,
                 const ibl_pixel_error *peer)
{
    ibl_pixel_error e[IBL_MAX_LEVELS];
    size_t bytes;
    void *file;

    tex->zstd = 19;
    must(!ibl_texture_errors(ctx, tex, &exact, e) &&
             !ibl_texture_encode(ctx, tex, IBL_CONTAINER_KTX2, &file, &bytes),
         name);
    ibl_bytes_free(file);
    printf("| %s | %.2f | %.1f |", name, ms / 1e3, (double)bytes / 1e3);
    for (int l = 0; l < exact.levels; l++)
        printf(" %.2f", 100 * e[l].nrmse);
    printf(" |");
    for (int l = 0; l < exact.levels; l++)
        printf(" %.2f", 100 * e[l].relative);
    printf(" |");
    tell_ratio(e, peer, false);
    tell_ratio(e, peer, true);
    printf("\n");
}

/* Prints the rows of a format. */
static void compare(ibl_pixel pixel, const char *seconds)
{
    const char *const names[] = {"fast", "normal", "best", "alike"};
    const int kinds = pixel == IBL_PIXEL_UASTC_HDR ? 4 : 3;
    ibl_texture peer = {0};
    ibl_pixel_error e[IBL_MAX_LEVELS];
    char name[64];

    snprintf(name, sizeof name, "peer_%s", ibl_pixel_name(pixel));
    read_texture(name, &peer);
    must(!ibl_texture_errors(ctx, &peer, &exact, e), name);
    for (int q = 0; q < kinds; q++) {
        ibl_texel_options o = {.pixel = pixel,
                               .quality =
                                   q < 3 ? (ibl_quality)q : IBL_QUALITY_NORMAL,
                               .alike = q == 3};
        ibl_texture tex = {0};
        const double begin = test_ms(CLOCK_PROCESS_CPUTIME_ID);
        must(!ibl_texture_from_cube(ctx, &exact, &o, &tex, NULL), "encoding");
        const double ms = test_ms(CLOCK_PROCESS_CPUTIME_ID) - begin;
        snprintf(name, sizeof name, "%s %s", ibl_pixel_name(pixel), names[q]);
        tell(name, &tex, ms, e);
        ibl_texture_free(&tex);
    }
    snprintf(name, sizeof name, "%s, peer", ibl_pixel_name(pixel));
    tell(name, &peer, 1e3 * strtod(seconds, NULL), e);
    ibl_texture_free(&peer);
}

int main(int argc, char **argv)
{
    ibl_texture tex = {0};

    if (argc != 5) {
        fprintf(stderr, "usage: bench_blocks DIR NAME SECONDS SECONDS\n");
        return 2;
    }
    dir = argv[1];
    ctx = test_ctx(1, IBL_ISA_AUTO);
    read_texture("rgba32f_specular", &tex);
    must(!ibl_texture_to_cube(ctx, &tex, &exact), "no cube");
    printf("| %s | s | kB | nRMSE of levels, %% | relative, %% | nRMSE to the "
           "peer's | relative |\n|---|---|---|---|---|---|---|\n",
           argv[2]);
    compare(IBL_PIXEL_UASTC_HDR, argv[3]);
    compare(IBL_PIXEL_BC6H, argv[4]);
    printf("\n");
    return 0;
}
