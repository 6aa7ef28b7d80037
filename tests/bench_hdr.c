/* SPDX-License-Identifier: MIT */
/*
 * The Radiance reader beside stb_image (package libstb-dev), in turns.
 *
 *     make DEPS=no build/tests/bench_hdr
 *     build/tests/bench_hdr FILE.hdr [ROUNDS]
 *
 * A FILE of 4096x2048:
 *     oiiotool ../shared/data/quarry_01_1k.hdr --resize 4096x2048 -o FILE.hdr
 *
 * Medians in milliseconds, from bytes in memory to floats. Fresh memory is
 * what a program sees that reads one picture: the system hands out each page
 * of the result at its first touch. In memory that was used before, what is
 * left is the decoding. By rows: from the file, 64 rows at a time to the same
 * memory, as a bake reads it.
 */
#include <malloc.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include "ibl/io.h"
#include "test.h"

#if __has_include(<stb/stb_image.h>)
#define STBI_ONLY_HDR
#define STBI_NO_STDIO
#define STB_IMAGE_IMPLEMENTATION
#include <stb/stb_image.h>
#else
#error "package libstb-dev is missing"
#endif

enum {
    MAX_ROUNDS = 99,
    BATCH = 64 /* rows that are read at once */
};

struct input {
    const char *path;
    unsigned char *bytes;
    size_t size;
};

static double time_stb(const struct input *in)
{
    int w, h, n;
    const double begin = test_ms(CLOCK_MONOTONIC);
    float *px = stbi_loadf_from_memory(in->bytes, (int)in->size, &w, &h, &n, 3);
    const double end = test_ms(CLOCK_MONOTONIC);
    if (!px) {
        fprintf(stderr, "stb: %s\n", stbi_failure_reason());
        exit(1);
    }
    stbi_image_free(px);
    return end - begin;
}

static double time_ibl(ibl_ctx *ctx, const struct input *in)
{
    ibl_image img;
    ibl_read_options opts = ibl_read_options_default();
    opts.any_aspect = 1;
    const double begin = test_ms(CLOCK_MONOTONIC);
    const ibl_status status =
        ibl_image_decode(ctx, "bench", in->bytes, in->size, &opts, &img, NULL);
    const double end = test_ms(CLOCK_MONOTONIC);
    if (status) {
        fprintf(stderr, "%s\n", ibl_status_text(status));
        exit(1);
    }
    ibl_image_free(&img);
    return end - begin;
}

/* From the file, in calls of BATCH rows to the same memory, as a bake reads
 * it; opening and closing included. */
static double time_source(ibl_ctx *ctx, const struct input *in)
{
    ibl_read_options opts = ibl_read_options_default();
    ibl_source *source;
    ibl_status status;
    opts.any_aspect = 1;

    const double begin = test_ms(CLOCK_MONOTONIC);
    status = ibl_source_open(ctx, in->path, &opts, &source);
    if (status)
        exit(1);
    const int width = ibl_source_width(source);
    float *rgb = malloc((size_t)width * BATCH * 3 * sizeof *rgb);
    for (int left = ibl_source_height(source); left && !status;) {
        const int rows = left < BATCH ? left : BATCH;
        status = ibl_source_read(source, rows, rgb);
        left -= rows;
    }
    ibl_source_close(source);
    free(rgb);
    const double end = test_ms(CLOCK_MONOTONIC);
    if (status)
        exit(1);
    return end - begin;
}

static ibl_ctx *context(int threads, ibl_isa isa)
{
    ibl_ctx_options opts = ibl_ctx_options_default();
    ibl_ctx *ctx;
    opts.threads = threads;
    opts.isa = isa;
    if (ibl_ctx_create(&opts, &ctx))
        exit(1);
    return ctx;
}

/* Ways to read the picture: one of the contexts, whole or by rows. */
static const struct way {
    const char *name;
    int ctx;
    bool by_rows;
} ways[] = {{"whole, 1 thread", 0, false},   {"whole, all threads", 1, false},
            {"whole, 1, plain C", 2, false}, {"whole, 1, sse2", 3, false},
            {"by rows, 1 thread", 0, true},  {"by rows, all threads", 1, true}};

enum {
    WAYS = sizeof ways / sizeof ways[0]
};

static void compare_all(const char *title, const struct input *in, int rounds)
{
    static double t[1 + WAYS][MAX_ROUNDS];
    ibl_ctx *ctx[] = {
        context(1, IBL_ISA_AUTO), context(0, IBL_ISA_AUTO),
        context(1, IBL_ISA_C),
        context(1, ibl_isa_best() > IBL_ISA_C ? IBL_ISA_SSE2 : IBL_ISA_C)};

    for (int i = -1; i < rounds; i++) {
        const int at = i < 0 ? 0 : i;
        t[0][at] = time_stb(in);
        for (int k = 0; k < WAYS; k++)
            t[1 + k][at] = (ways[k].by_rows ? time_source
                                            : time_ibl)(ctx[ways[k].ctx], in);
    }
    const double stb = test_median(t[0], rounds);
    printf("%s\n  %-20s %8.2f\n", title, "stb_image", stb);
    for (int k = 0; k < WAYS; k++) {
        const double ms = test_median(t[1 + k], rounds);
        printf("  %-20s %8.2f  %5.2f times as fast\n", ways[k].name, ms,
               stb / ms);
    }
    for (int k = 0; k < 4; k++)
        ibl_ctx_free(ctx[k]);
}

int main(int argc, char **argv)
{
    const int rounds = argc > 2 ? atoi(argv[2]) : 11;
    struct input in = {.path = argc > 1 ? argv[1] : ""};
    FILE *f = argc > 1 ? fopen(argv[1], "rb") : NULL;

    if (!f || rounds < 1 || rounds > MAX_ROUNDS) {
        fprintf(stderr, "usage: bench_hdr FILE.hdr [1..%d]\n", MAX_ROUNDS);
        return 2;
    }
    fseek(f, 0, SEEK_END);
    in.size = (size_t)ftell(f);
    rewind(f);
    in.bytes = malloc(in.size);
    if (!in.bytes || fread(in.bytes, 1, in.size, f) != in.size)
        return 1;
    fclose(f);
    compare_all("fresh memory", &in, rounds);
    mallopt(M_MMAP_MAX, 0);
    mallopt(M_TRIM_THRESHOLD, 1 << 30);
    mallopt(M_TOP_PAD, 1 << 28);
    compare_all("memory that was used before", &in, rounds);
    free(in.bytes);
    return 0;
}
