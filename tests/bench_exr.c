/* SPDX-License-Identifier: MIT */
/*
 * OpenEXRCore, with its own zlib, as a process of its own, to measure beside.
 *
 *     bench_exr FILE.exr [THREADS]
 *
 * decodes the scan lines of the first part's R, G and B, prints "ms N":
 * reading the file and decoding to floats, in memory that the system hands out
 * on the way. THREADS: one for each processor. bench.sh makes such a file.
 */
#include <openexr.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "test.h"

enum {
    MAX_THREADS = 256
};

typedef struct picture {
    exr_context_t exr;
    int y0, width, height, lines; /* lines of a chunk */
    float *rgb;
    atomic_int next; /* chunk */
    atomic_bool failed;
} picture;

/* Where a chunk's first line begins. */
static void aim(const picture *p, int line, exr_decode_pipeline_t *pipe)
{
    for (int i = 0; i < pipe->channel_count; i++) {
        exr_coding_channel_info_t *c = &pipe->channels[i];
        const char *at = strchr("RGB", c->channel_name[0]);
        if (!at || c->channel_name[1])
            continue;
        c->decode_to_ptr = (uint8_t *)(p->rgb + (at - "RGB") +
                                       3 * (size_t)line * (size_t)p->width);
        c->user_bytes_per_element = 4;
        c->user_data_type = EXR_PIXEL_FLOAT;
        c->user_pixel_stride = 12;
        c->user_line_stride = 12 * p->width;
    }
}

static void *decode(void *arg)
{
    picture *p = arg;
    exr_decode_pipeline_t pipe = EXR_DECODE_PIPELINE_INITIALIZER;
    exr_chunk_info_t info;
    bool made = false;
    int line;

    while ((line = p->lines * atomic_fetch_add(&p->next, 1)) < p->height) {
        bool ok =
            !exr_read_scanline_chunk_info(p->exr, 0, p->y0 + line, &info) &&
            !(made ? exr_decoding_update(p->exr, 0, &info, &pipe)
                   : exr_decoding_initialize(p->exr, 0, &info, &pipe));
        if (ok) {
            aim(p, line, &pipe);
            ok =
                made || !exr_decoding_choose_default_routines(p->exr, 0, &pipe);
            made = true;
        }
        if (!ok || exr_decoding_run(p->exr, 0, &pipe))
            p->failed = true;
    }
    exr_decoding_destroy(p->exr, &pipe);
    return NULL;
}

static bool open_picture(const char *path, picture *p)
{
    const exr_context_initializer_t init = EXR_DEFAULT_CONTEXT_INITIALIZER;
    exr_attr_box2i_t data;

    if (exr_start_read(&p->exr, path, &init))
        return false;
    if (exr_get_data_window(p->exr, 0, &data) ||
        exr_get_scanlines_per_chunk(p->exr, 0, &p->lines))
        return false;
    p->y0 = data.min.y;
    p->width = data.max.x - data.min.x + 1;
    p->height = data.max.y - data.min.y + 1;
    p->rgb = malloc(3 * sizeof(float) * (size_t)p->width * (size_t)p->height);
    return p->rgb;
}

int main(int argc, char **argv)
{
    const int threads =
        argc == 3 ? atoi(argv[2]) : (int)sysconf(_SC_NPROCESSORS_ONLN);
    pthread_t thread[MAX_THREADS];
    picture p = {.failed = false};
    int started = 0;

    if (argc < 2 || argc > 3 || threads < 1 || threads > MAX_THREADS) {
        fprintf(stderr, "usage: bench_exr FILE.exr [1..%d]\n", MAX_THREADS);
        return 2;
    }
    const double begin = test_ms(CLOCK_MONOTONIC);
    if (!open_picture(argv[1], &p))
        return 1;
    while (started < threads - 1 &&
           !pthread_create(&thread[started], NULL, decode, &p))
        started++;
    decode(&p);
    while (started > 0)
        pthread_join(thread[--started], NULL);
    const double end = test_ms(CLOCK_MONOTONIC);
    /* Not freed before the clock is read, and used. */
    if (!p.failed && p.rgb[3 * (size_t)p.width * (size_t)p.height / 2] >= 0)
        printf("ms %.3f\n", end - begin);
    free(p.rgb);
    exr_finish(&p.exr);
    return p.failed;
}
