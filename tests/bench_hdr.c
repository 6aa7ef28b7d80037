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
 * left is the decoding.
 */
#include <malloc.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include "io/rgbe.h"

#if __has_include(<stb/stb_image.h>)
#define STBI_ONLY_HDR
#define STBI_NO_STDIO
#define STB_IMAGE_IMPLEMENTATION
#include <stb/stb_image.h>
#else
#error "package libstb-dev is missing"
#endif

enum {
    MAX_ROUNDS = 99
};

struct input {
    unsigned char *bytes;
    size_t size;
};

static double now_ms(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec * 1e3 + (double)t.tv_nsec * 1e-6;
}

static double time_stb(const struct input *in)
{
    int w, h, n;
    const double begin = now_ms();
    float *px = stbi_loadf_from_memory(in->bytes, (int)in->size, &w, &h, &n, 3);
    const double end = now_ms();
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
    char format[64];
    const double begin = now_ms();
    const ibl_status status =
        ibl_rgbe_decode(ctx, "bench", in->bytes, in->size, &img, format);
    const double end = now_ms();
    if (status) {
        fprintf(stderr, "%s\n", ibl_status_text(status));
        exit(1);
    }
    ibl_image_free(&img);
    return end - begin;
}

static double time_scan(ibl_ctx *ctx, const struct input *in)
{
    ibl_rgbe_header header;
    ibl_rgbe_index index;
    const double begin = now_ms();
    if (ibl_rgbe_parse(ctx, "bench", in->bytes, in->size, &header) ||
        ibl_rgbe_scan(ctx, "bench", in->bytes, in->size, &header, &index))
        exit(1);
    const double end = now_ms();
    ibl_rgbe_index_free(&index);
    return end - begin;
}

static int compare(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static double median(double *t, int n)
{
    qsort(t, (size_t)n, sizeof *t, compare);
    return n % 2 ? t[n / 2] : (t[n / 2 - 1] + t[n / 2]) / 2;
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

static void compare_all(const char *title, const struct input *in, int rounds)
{
    static double t[6][MAX_ROUNDS];
    ibl_ctx *ctx[] = {
        context(1, IBL_ISA_AUTO), context(0, IBL_ISA_AUTO),
        context(1, IBL_ISA_C),
        context(1, ibl_isa_best() > IBL_ISA_C ? IBL_ISA_SSE2 : IBL_ISA_C)};
    static const char *const names[] = {"ibl, 1 thread", "ibl, all threads",
                                        "ibl, 1, plain C", "ibl, 1, sse2"};

    time_stb(in);
    time_ibl(ctx[0], in);
    for (int i = 0; i < rounds; i++) {
        t[0][i] = time_stb(in);
        for (int k = 0; k < 4; k++)
            t[1 + k][i] = time_ibl(ctx[k], in);
        t[5][i] = time_scan(ctx[0], in);
    }
    const double stb = median(t[0], rounds);
    printf("%s\n  %-18s %8.2f\n", title, "stb_image", stb);
    for (int k = 0; k < 4; k++) {
        const double ms = median(t[1 + k], rounds);
        printf("  %-18s %8.2f  %5.2f times as fast\n", names[k], ms, stb / ms);
        ibl_ctx_free(ctx[k]);
    }
    printf("  %-18s %8.2f\n", "its index alone", median(t[5], rounds));
}

int main(int argc, char **argv)
{
    const int rounds = argc > 2 ? atoi(argv[2]) : 11;
    struct input in = {0};
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
