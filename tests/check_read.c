/* SPDX-License-Identifier: MIT */
/*
 * Maps that are read: the same floats from everywhere (memory, a file, a pipe,
 * rows in any batches, any number of threads, reads that come short), damage of
 * every reader, mending, kinds of files and what goes through the bridge. The
 * truth is the same file in memory read by one thread, floats and integers that
 * were saved, and the rule of <ibl/io.h> by a second implementation.
 */
#include <errno.h>
#include <math.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "files.h"
#include "ibl/io.h"
#include "maps.h"
#include "textures.h"

enum {
    W = 300,
    H = 150
};

static test_messages kept;

static size_t floats_of(const ibl_image *img, int rows)
{
    return 3 * (size_t)img->width * (size_t)rows;
}

/* All rows by ibl_source_read, batch at a time (0: all); img is freed after the
 * running test. */
static ibl_status by_rows(ibl_ctx *ctx, const char *path, int batch,
                          const ibl_read_options *opts, ibl_image *img,
                          ibl_read_report *report)
{
    ibl_source *s;

    memset(&kept, 0, sizeof kept);
    *img = (ibl_image){0};
    ibl_status status = ibl_source_open(ctx, path, opts, &s);
    if (status) {
        CHECK(!s);
        return status;
    }
    status =
        ibl_image_alloc(ctx, ibl_source_width(s), ibl_source_height(s), img);
    test_image(*img);
    for (int y = 0, n; !status && y < img->height; y += n) {
        const int left = img->height - y;
        n = batch && batch < left ? batch : left;
        status = ibl_source_read(s, n, img->data + floats_of(img, y));
    }
    if (report)
        *report = *ibl_source_report(s);
    float none[1];
    CHECK(!status || ibl_source_read(s, 1, none) == status);
    ibl_source_close(s);
    return status;
}

/* ---- files ---------------------------------------------------------- */

/* Noise that does not compress, with some of what has to be mended: now and
 * then a pixel, and whole rows around the borders of batches and blocks. */
static bool save_wild(const char *name)
{
    const float odd[] = {INFINITY, -INFINITY, NAN, -2.5f, -0.0f};
    ibl_image img = map_constant(file_ctx(1, &kept, NULL), W, H, 0);
    test_random r = {5};

    for (int y = 0; y < H; y++) {
        const bool all = y % 16 == 15 || y % 48 == 0 || y == 2;
        for (int i = 0; i < 3 * W; i++) {
            const double u = test_random_unit(&r);
            img.data[floats_of(&img, y) + (size_t)i] =
                (all && u < 0.7) || u < 0.002
                    ? odd[test_random_u64(&r) % 5]
                    : (float)(exp(8 * u) * test_random_unit(&r));
        }
    }
    return file_save_pfm(file_path(name), &img);
}

/* A flat .hdr of some numbers. */
static void save_flat(const char *name, int width, int height)
{
    NEED(file_run("{ printf '#?RADIANCE\\nFORMAT=32-bit_rle_rgbe\\n\\n-Y %d +X "
                  "%d\\n'; seq 99999 | head -c %d; } >%s",
                  height, width, 4 * width * height, name));
}

typedef struct made {
    const char *name, *how; /* what oiiotool is told; NULL: nothing */
} made;

/* By one call of oiiotool, each from the pixels of `from`. */
static void make(const made *files, size_t count, const char *from)
{
    const char *command = "oiiotool";

    for (size_t i = 0; i < count; i++)
        if (files[i].how)
            command = test_text("%s %s --scanline -d half %s -o %s", command,
                                from, files[i].how, files[i].name);
    NEED(file_run("%s", command));
}

/* ---- a file system that gives little at a time -------------------------- */

static struct {
    size_t most; /* bytes that a read gives; 0: all */
    bool on;     /* and off: every second read is interrupted */
    int left;    /* reads until one fails; -1: none does */
    atomic_int calls;
} slow = {.left = -1};

ssize_t __real_pread(int fd, void *to, size_t size, off_t offset);
ssize_t __wrap_pread(int fd, void *to, size_t size, off_t offset);
ssize_t __wrap_pread(int fd, void *to, size_t size, off_t offset)
{
    const int call = slow.calls++;
    if (slow.left >= 0 && call >= slow.left) {
        errno = EIO;
        return -1;
    }
    if (slow.on && call % 2) {
        errno = EINTR;
        return -1;
    }
    return __real_pread(
        fd, to, slow.most && slow.most < size ? slow.most : size, offset);
}

/* Standard input is what a command prints after a pause. */
static ibl_status by_pipe(ibl_ctx *ctx, const char *name, const char *command,
                          const ibl_read_options *opts, ibl_image *img,
                          ibl_read_report *report)
{
    const int saved = dup(STDIN_FILENO);
    FILE *pipe =
        popen(test_text("sleep .02; cd '%s'; %s", test_dir(), command), "r");

    NEED(pipe && dup2(fileno(pipe), STDIN_FILENO) == STDIN_FILENO);
    const ibl_status status = by_rows(ctx, name, 16, opts, img, report);
    dup2(saved, STDIN_FILENO); /* the command sees it closed */
    close(saved);
    pclose(pipe);
    return status;
}

/* ---- the same from everywhere ------------------------------------------- */

static bool same_report(const ibl_read_report *a, const ibl_read_report *b)
{
    return !strcmp(a->format, b->format) && a->nonfinite == b->nonfinite &&
           a->negative == b->negative && a->peak == b->peak &&
           a->has_alpha == b->has_alpha && a->alpha_beyond == b->alpha_beyond &&
           a->low_range == b->low_range && a->bridged == b->bridged;
}

static const struct {
    int batch, threads;
    size_t most;
    bool interrupted;
    const char *pipe;
} ways[] = {{0, 2, 0, false, NULL},     {1, 1, 0, false, NULL},
            {3, 7, 0, false, NULL},     {16, 2, 0, false, "-"},
            {64, 7, 0, false, NULL},    {16, 1, 0, false, "/dev/stdin"},
            {16, 2, 1009, false, NULL}, {64, 7, 1009, true, NULL}};

static void every_way(const char *name)
{
    ibl_read_options opts = ibl_read_options_default();
    ibl_read_report want, got;
    ibl_image whole = {0}, img;
    size_t size;
    const char *path = file_path(name);
    unsigned char *bytes = file_load(path, &size);
    ibl_ctx *ctx = file_ctx(1, &kept, file_bridge());

    opts.any_aspect = 1;
    opts.alpha = IBL_ALPHA_STRAIGHT; /* by which colours are multiplied */
    memset(&kept, 0, sizeof kept);
    CHECK_MSG(
        !ibl_image_decode(ctx, "whole", bytes, size, &opts, &whole, &want),
        "%s: %s", path, kept.text[0]);
    NEED(whole.data);
    test_image(whole);
    for (size_t i = 0; i < sizeof ways / sizeof *ways; i++) {
        ctx = file_ctx(ways[i].threads, &kept, file_bridge());
        slow.most = ways[i].most;
        slow.on = ways[i].interrupted;
        const ibl_status status =
            ways[i].pipe ? by_pipe(ctx, ways[i].pipe, test_text("cat %s", name),
                                   &opts, &img, &got)
                         : by_rows(ctx, path, ways[i].batch, &opts, &img, &got);
        slow.most = 0;
        slow.on = false;
        CHECK_MSG(!status, "%s, way %zu: %s", name, i, kept.text[0]);
        if (status)
            continue;
        CHECK_MSG(map_same(&img, &whole), "%s, way %zu: differs", name, i);
        CHECK_MSG(same_report(&got, &want), "%s, way %zu: %s, %zu, %zu, %g",
                  name, i, got.format, got.nonfinite, got.negative,
                  (double)got.peak);
    }
}

/* Blocks of one, 16 and 32 scan lines, tiles, windows that begin and end within
 * blocks, scanlines that are columns, and what goes through the bridge; what is
 * in them is the matter of check_exr and check_hdr. The first seven are those
 * that need no other program's threads. */
static const made corpus[] = {
    {"flat.hdr", NULL},
    {"coded.hdr", ""},
    {"columns.hdr", NULL},
    {"tall.hdr", "--rotate90"},
    {"zips.exr", "-d float --compression zips"},
    {"zip.exr", "--ch R,G,B,A=G --compression zip --tile 32 16"},
    {"none.exr", "--compression none"},
    {"rle.exr", "--compression rle"},
    {"piz.exr", "-d float --compression piz"},
    {"pxr24.exr", "-d float --tile 17 150 --compression pxr24"},
    {"b44.exr", "--compression b44"},
    {"dwab.exr", "--ch R,G,B,A=G --compression dwab"},
    {"less.exr",
     "--ch R,G,B,A=G -d float --fullsize 300x150-20-13 --compression zip"},
    {"more.exr", "-d float --fullsize 300x150+31+21 --tile 64 32"},
    {"far.exr", "-d float --fullsize 350x170-20-10 --compression none"},
    {"crop.exr", "-d float --fullsize 100x40+7+75 --compression zip"},
    {"float.tif", "--ch R,G,B,A=G -d float --tile 32 32"},
    {"bytes.png", "--ch R,G,B,A=G -d uint8"},
    {"wild.pfm", NULL},
};

enum {
    FILES = sizeof corpus / sizeof *corpus,
    OURS = 7 /* of them */
};

static void make_corpus(void)
{
    static bool written;

    file_need_oiio();
    NEED(written || save_wild("wild.pfm"));
    if (written)
        return;
    save_flat("flat.hdr", W, H);
    make(corpus, FILES, "wild.pfm");
    NEED(file_run("LC_ALL=C sed '1,9s/^-Y 150 +X 300$/+X 150 +Y 300/' "
                  "coded.hdr >columns.hdr"));
    written = true;
}

TEST(everywhere)
{
    make_corpus();
    for (int i = 0; i < (TEST_RACES ? OURS : FILES);
         i += TEST_SANITIZED && !TEST_RACES ? 2 : 1)
        every_way(corpus[i].name);
}

/* Of a stream nothing comes, or more than the pixels. */
TEST(streams_without_an_end)
{
    ibl_ctx *ctx = file_ctx(1, &kept, NULL);
    ibl_image img;

    CHECK(by_pipe(ctx, "-", "true", NULL, &img, NULL) == IBL_ERR_FORMAT);
    CHECK(test_said(&kept, "standard input: is empty"));
    save_flat("a.hdr", 18, 9);
    CHECK_MSG(!by_pipe(ctx, "-", "cat a.hdr /dev/zero | head -c 500000", NULL,
                       &img, NULL),
              "%s", kept.text[0]);
}

/* ---- pixels in memory, and mending ---------------------------------- */

/* The rule of ibl/io.h, by looking at every pixel's neighbours in a copy. */
static ibl_read_report truth(ibl_image *img)
{
    const int w = img->width, h = img->height;
    const size_t bytes = 3 * sizeof(float) * (size_t)w * (size_t)h;
    float *was = malloc(bytes);
    ibl_read_report count = {.format = ""};
    memcpy(was, img->data, bytes);
    for (int y = 0; y < h; y++) {
        for (int x = 0; x < w; x++) {
            bool bad = false, negative = false;
            for (int c = 0; c < 3; c++) {
                float *f = &img->data[3 * (y * w + x) + c];
                if (!isfinite(*f)) {
                    float best = -INFINITY;
                    for (int i = x - 1; i <= x + 1; i += 2) {
                        const float n = was[3 * (y * w + (i + w) % w) + c];
                        if (isfinite(n) && n > best)
                            best = n;
                    }
                    if (best == -INFINITY)
                        best = *f > 0 ? 65504 : 0;
                    bad = true;
                    *f = best;
                } else if (*f < 0) {
                    negative = true;
                }
                if (!(*f > 0))
                    *f = 0;
                if (*f > count.peak)
                    count.peak = *f;
            }
            count.nonfinite += bad;
            count.negative += negative;
        }
    }
    free(was);
    return count;
}

/* How pixels may lie in memory: with alpha, as halves, from the bottom, with a
 * gap behind each row. */
enum {
    ALPHA = 1,
    HALF = 2,
    DOWN = 4,
    GAP = 8,
    LAYOUTS = 16
};

/* The memory of a map and its alpha in a layout. */
static ibl_pixels lay_out(const ibl_image *img, const float *alpha, int layout)
{
    const int w = img->width, h = img->height, n = layout & ALPHA ? 4 : 3;
    const int bytes = layout & HALF ? 2 : 4;
    const ptrdiff_t row = (ptrdiff_t)w * n * bytes + (layout & GAP ? 5 : 0);
    unsigned char *data = test_alloc((size_t)row, (size_t)h);

    for (int i = 0; i < n * w * h; i++) {
        const int at = i / n, y = at / w, c = i % n;
        const float f = c < 3 ? img->data[3 * at + c] : alpha[at];
        uint16_t texel[4];
        texels_encode(IBL_PIXEL_RGBA16F, (float[]){f, f, f}, 1, texel);
        texel[0] = isnan(f)   ? 0x7e00
                   : isinf(f) ? (f > 0 ? 0x7c00 : 0xfc00)
                              : texel[0];
        memcpy(data + (layout & DOWN ? h - 1 - y : y) * row +
                   (at % w * n + c) * bytes,
               layout & HALF ? (void *)texel : (void *)&f, (size_t)bytes);
    }
    return (ibl_pixels){.data = data + (layout & DOWN ? (h - 1) * row : 0),
                        .width = w,
                        .height = h,
                        .channels = n,
                        .half = (layout & HALF) != 0,
                        .row_bytes = layout & DOWN  ? -row
                                     : layout & GAP ? row
                                                    : 0};
}

/* Reads them, at most `most` rows a call, all to the same memory. */
static ibl_status read_pixels(ibl_ctx *ctx, const ibl_pixels *pixels,
                              const ibl_read_options *opts, int most,
                              float *rgb, ibl_read_report *report)
{
    static test_random r = {77};
    const size_t floats = 3 * (size_t)pixels->width;
    float *call = malloc(floats * (size_t)most * sizeof *call);
    ibl_source *s = NULL;

    memset(&kept, 0, sizeof kept);
    ibl_status status = ibl_source_of_pixels(ctx, "mine", pixels, opts, &s);
    for (int y = 0, n; !status && y < pixels->height; y += n) {
        const int left = pixels->height - y;
        n = 1 + test_random_below(&r, most);
        n = n < left ? n : left;
        status = ibl_source_read(s, n, call);
        memcpy(rgb + floats * (size_t)y, call,
               floats * sizeof *call * (size_t)n);
    }
    if (!status)
        *report = *ibl_source_report(s);
    ibl_source_close(s);
    free(call);
    return status;
}

TEST(mending)
{
    static const int sizes[][2] = {{1, 1},   {2, 1},   {1, 2},   {3, 2},
                                   {37, 33}, {64, 32}, {300, 49}};
    /* Shares of Inf, -Inf, NaN and negative values. */
    static const double shares[] = {0, 0.001, 0.2, 0.9, 1};
    const float bad[] = {INFINITY, -INFINITY, NAN, -1.5f, -0.0f};
    ibl_read_options opts = ibl_read_options_default();
    test_random r = {77};

    opts.any_aspect = 1;
    for (int k = 0; k < 7 * 5 * 8; k++) {
        const int w = sizes[k % 7][0], h = sizes[k % 7][1];
        const int calls[] = {1, 3, 20, h}, layout = k % LAYOUTS;
        ibl_ctx *ctx = file_ctx(k % 2 ? 3 : 1, &kept, NULL);
        ibl_image img = map_constant(ctx, w, h, 0);
        float *alpha = test_alloc((size_t)(w * h), sizeof *alpha);
        float *rgb = test_alloc(map_floats(&img), sizeof *rgb);
        ibl_read_report done = {.format = ""};
        for (int i = 0; i < 3 * w * h; i++)
            img.data[i] = test_random_unit(&r) < shares[k / 7 % 5]
                              ? bad[test_random_below(&r, 5)]
                              : (float)test_random_below(&r, 1024) / 1024;
        for (int i = 0; i < w * h; i++)
            alpha[i] = (float)test_random_below(&r, 8) / 8;
        const ibl_pixels pixels = lay_out(&img, alpha, layout);
        opts.alpha = layout & ALPHA ? IBL_ALPHA_STRAIGHT : IBL_ALPHA_IGNORE;
        const ibl_read_report want = truth(&img);
        NEED(!read_pixels(ctx, &pixels, &opts, calls[k / 35 % 4], rgb, &done));
        CHECK_MSG(
            done.nonfinite == want.nonfinite &&
                done.negative == want.negative && done.peak == want.peak &&
                done.has_alpha == (layout & ALPHA),
            "%dx%d, layout %d: %zu and %zu, not %zu and %zu", w, h, layout,
            done.nonfinite, done.negative, want.nonfinite, want.negative);
        for (int i = 0; i < 3 * w * h; i++) {
            const float a = layout & ALPHA ? alpha[i / 3] : 1;
            if (rgb[i] == img.data[i] * a && !signbit(rgb[i]))
                continue;
            test_fail(__FILE__, __LINE__, "%dx%d, layout %d: %d is %g, not %g",
                      w, h, layout, i, (double)rgb[i],
                      (double)(img.data[i] * a));
            break;
        }
        opts.strict = 1;
        const bool whole = !want.nonfinite && !want.negative;
        CHECK(read_pixels(ctx, &pixels, &opts, h, rgb, &done) ==
                  (whole ? IBL_OK : IBL_ERR_FORMAT) &&
              (whole || test_said(&kept, "mine: ")));
        opts.strict = 0;
    }
}

TEST(wrong_pixels)
{
    static const float rgba[4 * 8 * 4];
    const ibl_pixels bad[] = {{rgba, 8, 4, 2, 0, 0},
                              {rgba, 8, 8, 4, 0, 0},
                              {rgba, -8, 4, 4, 0, 0},
                              {rgba, 8, 4, 4, 2, 0},
                              {rgba, 8, 4, 4, 0, 124},
                              {rgba, 8, 4, 4, 0, -124},
                              {rgba, 8, 4, 4, 0, PTRDIFF_MAX / 2},
                              {rgba, 8, 4, 4, 0, PTRDIFF_MIN}};
    ibl_source *s;

    for (size_t k = 0; k < sizeof bad / sizeof *bad; k++)
        CHECK_MSG(ibl_source_of_pixels(test_keeping_ctx(1, &kept), "bad",
                                       &bad[k], NULL, &s) ==
                          (k == 1 ? IBL_ERR_FORMAT : IBL_ERR_ARGUMENT) &&
                      !s,
                  "pixels %zu: %s", k, kept.text[0]);
}

/* ---- calls ---------------------------------------------------------- */

TEST(arguments)
{
    static const int reads[][2] = {
        {0, IBL_ERR_ARGUMENT},     {-1, IBL_ERR_ARGUMENT},
        {H + 1, IBL_ERR_ARGUMENT}, {H - 1, IBL_OK},
        {2, IBL_ERR_ARGUMENT},     {1, IBL_OK},
        {1, IBL_ERR_ARGUMENT}};
    static const ibl_status parts[] = {IBL_ERR_ARGUMENT, IBL_OK, IBL_OK,
                                       IBL_ERR_FORMAT}; /* -2 to 1 */
    ibl_ctx *ctx = file_ctx(2, &kept, NULL);
    static float rgb[3 * W * H];
    ibl_read_options opts = ibl_read_options_default();
    ibl_source *s;
    ibl_image img;

    save_flat("a.hdr", 300, 150);
    const char *path = file_path("a.hdr");
    NEED(!ibl_source_open(ctx, path, NULL, &s));
    CHECK(ibl_source_width(s) == W && ibl_source_height(s) == H);
    for (size_t i = 0; i < sizeof reads / sizeof *reads; i++)
        CHECK((int)ibl_source_read(s, reads[i][0], rgb) == reads[i][1]);
    CHECK(!strcmp(ibl_source_report(s)->format, "Radiance RGBE"));
    ibl_source_close(s);
    ibl_source_close(NULL);
    for (int i = 0; i < 4; i++) {
        opts.part = i - 2;
        CHECK(by_rows(ctx, path, 0, &opts, &img, NULL) == parts[i]);
    }
    opts.part = -1;
    opts.layer = "x";
    CHECK(by_rows(ctx, path, 0, &opts, &img, NULL) == IBL_ERR_FORMAT);
    save_flat("a.hdr", 90, 60);
    CHECK(by_rows(ctx, path, 0, NULL, &img, NULL) == IBL_ERR_FORMAT);
}

static void cancel(void *cookie, const char *stage, double done, double whole)
{
    ibl_ctx **ctx = cookie;

    CHECK(whole < 0 && !strcmp(stage, "decode"));
    if (done >= 0.3)
        ibl_ctx_cancel(*ctx);
}

/* ---- damage --------------------------------------------------------- */

/* Files that are cut, or whose reads fail or are cancelled, while they are
 * read. */
TEST(damage_while_read)
{
    static const int victims[] = {0, 1, 5, 6};
    static float rgb[3 * W * H];
    ibl_ctx *ctx = file_ctx(2, &kept, NULL);
    ibl_image img;

    make_corpus();
    const int free_file = dup(STDIN_FILENO);
    close(free_file);
    for (int k = 0; k < 4; k++) {
        const char *name = corpus[victims[k]].name;
        size_t size;
        unsigned char *bytes = file_load(file_path(name), &size);
        slow.calls = 0;
        NEED(!by_rows(ctx, file_path(name), 16, NULL, &img, NULL));
        const int calls = slow.calls;
        for (int i = 0; i < calls; i++) {
            slow.calls = 0;
            slow.left = i;
            CHECK_MSG(by_rows(ctx, file_path(name), 16, NULL, &img, NULL) ==
                              IBL_ERR_IO &&
                          test_said(&kept, "cannot be read"),
                      "%s, read %d: %s", name, i, kept.text[0]);
        }
        slow.left = -1;
        ibl_ctx_options stops = ibl_ctx_options_default();
        ibl_ctx *stopped;
        stops.progress = cancel;
        stops.progress_cookie = &stopped;
        stopped = test_ctx_of(&stops);
        CHECK(by_rows(stopped, file_path(name), 16, NULL, &img, NULL) ==
              IBL_ERR_CANCELLED);
        for (int rows = 0; rows < H; rows += 49) {
            ibl_source *s;
            memset(&kept, 0, sizeof kept);
            NEED(file_save(file_path("cut"), bytes, size));
            NEED(!ibl_source_open(ctx, file_path("cut"), NULL, &s));
            CHECK(!rows || !ibl_source_read(s, rows, rgb));
            NEED(!truncate(file_path("cut"), (off_t)size / 9));
            const ibl_status status = ibl_source_read(s, H - rows, rgb);
            /* what has been read ahead may be all */
            CHECK_MSG(status ? status == IBL_ERR_FORMAT && kept.text[0][0] &&
                                   !strchr(kept.text[0], '\n')
                             : k < 3,
                      "%s at %d: %d, \"%s\"", name, rows, status, kept.text[0]);
            ibl_source_close(s);
        }
    }
    CHECK(dup(STDIN_FILENO) == free_file); /* all are closed */
    close(free_file);
}

/* Decodes bytes in memory of just their size, so that a sanitizer sees every
 * byte too far. True if it went well or was refused with one line. */
static bool survives(ibl_ctx *ctx, const unsigned char *bytes, size_t size,
                     ibl_status *status)
{
    ibl_read_options opts = ibl_read_options_default();
    ibl_image img = {0};
    unsigned char *copy = malloc(size ? size : 1);

    memcpy(copy, bytes, size);
    memset(&kept, 0, sizeof kept);
    opts.any_aspect = 1;
    opts.alpha = IBL_ALPHA_FILE;
    *status = ibl_image_decode(ctx, "f", copy, size, &opts, &img, NULL);
    free(copy);
    const bool ok = !*status || (kept.text[0][0] && !img.data &&
                                 !strchr(kept.text[0], '\n'));
    ibl_image_free(&img);
    return ok;
}

/* Smooth, or blocks would be stored as they are. */
static const made small[] = {
    {"a.hdr", NULL},
    {"c.hdr", ""},
    {"a_zip.exr", "--compression zip"},
    {"a_piz.exr", "--compression piz"},
    {"a_b44.exr", "--tile 16 16 --compression b44"},
    {"dwaa.exr", "--compression dwaa"},
    {"a_dwab.exr", "--tile 32 32 --compression dwab"},
    {"parts.exr", "--compression zip smooth.pfm --siappend"},
    {"n.png", "-d uint8"},
    {"n.tif", "-d float --tile 16 16"},
    {"n.jpg", "-d uint8"},
};

/* Every file cut anywhere is refused; with a wrong bit it may be. */
TEST(damaged)
{
    ibl_ctx *ctx = file_ctx(2, &kept, file_bridge());
    ibl_image img = map_constant(ctx, 64, 72, 0);
    test_random r = {2025};

    file_need_oiio();
    for (int i = 0; i < 3 * 64 * 72; i++)
        img.data[i] = 0.01f * (float)(i / 96);
    NEED(file_save_pfm(file_path("smooth.pfm"), &img));
    save_flat("a.hdr", 19, 6);
    make(small, sizeof small / sizeof *small, "smooth.pfm");
    for (size_t i = 0; i < sizeof small / sizeof *small; i++) {
        const char *name = small[i].name;
        size_t size;
        unsigned char *bytes = file_load(file_path(name), &size);
        ibl_status status;
        int refused = 0;
        /* The first of several parts may be whole in a cut file. */
        const size_t end = strcmp(name, "parts.exr") ? size : size / 2;
        for (size_t n = 0; n < end;
             n += (n < 600 ? 1 : 13) * (TEST_SANITIZED ? 12 : 1))
            CHECK_MSG(survives(ctx, bytes, n, &status) &&
                          status == IBL_ERR_FORMAT,
                      "%s at %zu: %d %s", name, n, status, kept.text[0]);
        for (int round = 0; round < (TEST_SANITIZED ? 40 : 200); round++) {
            const int range = round % 2 || size < 700 ? (int)size : 700;
            unsigned char *at = bytes + test_random_below(&r, range);
            const int bit = 1 << test_random_below(&r, 8);
            *at ^= (unsigned char)bit;
            CHECK_MSG(survives(ctx, bytes, size, &status), "%s round %d", name,
                      round);
            refused += status != IBL_OK;
            *at ^= (unsigned char)bit;
        }
        CHECK_MSG(refused > 0, "%s: no bit matters", name);
    }
}

/* ---- memory --------------------------------------------------------- */

/* A whole map takes at most what the context may: 12 bytes a pixel. */
TEST(whole_maps_are_bounded)
{
    ibl_ctx_options with = ibl_ctx_options_default();

    save_flat("a.hdr", 300, 150);
    with.log = test_keep;
    with.log_cookie = &kept;
    for (int less = 0; less < 2; less++) {
        ibl_image img = {0};
        with.memory = (size_t)(12 * W * H - less);
        CHECK(ibl_image_read(test_ctx_of(&with), file_path("a.hdr"), NULL, &img,
                             NULL) == (less ? IBL_ERR_MEMORY : IBL_OK));
        ibl_image_free(&img);
    }
    CHECK(test_said(&kept, "a.hdr: takes 1 MiB of memory, more than the 0"));
}

/* ---- kinds, and the bridge ------------------------------------------- */

static void refused(ibl_ctx *ctx, const char *path, ibl_status want,
                    const char *words)
{
    ibl_image img;
    const ibl_status status = by_rows(ctx, path, 0, NULL, &img, NULL);

    CHECK_MSG(status == want && test_said(&kept, words) &&
                  test_said(&kept, path) && !strchr(kept.text[0], '\n'),
              "%s: %d %s", path, status, kept.text[0]);
}

/* No file, no bridge, and a bridge that is something else. */
TEST(not_to_be_opened)
{
    static const unsigned char png[] = "\x89PNG\r\n\x1a\n\0\0\0\0IEND"
                                       "\xae\x42\x60\x82";
    ibl_ctx *ctx = file_ctx(1, &kept, NULL);
    const char *path = file_path("x.png");

    refused(ctx, test_text("%s", test_dir()), IBL_ERR_IO, "is a directory");
    refused(ctx, "/dev/zero", IBL_ERR_IO, "is a device");
    NEED(file_save(path, png, 0));
    refused(ctx, path, IBL_ERR_FORMAT, "is empty");
    NEED(file_save(path, png, sizeof png - 1));
    refused(ctx, path, IBL_ERR_UNSUPPORTED,
            "is PNG, which needs the image bridge");
    CHECK(test_said(&kept, "libopenimageio-dev"));
    refused(file_ctx(1, &kept, path), path, IBL_ERR_UNSUPPORTED,
            "cannot be loaded");
    if (file_built("libiblexr.so"))
        refused(file_ctx(1, &kept, file_built("libiblexr.so")), path,
                IBL_ERR_UNSUPPORTED, "is not the image");
}

/* Messages name a file's format by its whole signature, per its standard; what
 * is no image is told from what is damaged; and headers of up to 48 GiB of
 * floats are refused. */
TEST(kinds)
{
#define B(text) text, sizeof text - 1
#define RGBE "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n"
    static const struct {
        const char *bytes;
        size_t size;
        const char *said; /* and not of a byte less, in capitals */
    } cases[] = {
        {B("\x89PNG\r\n\x1a\n"), "PNG"},
        {B("\xff\xd8\xff"), "JPEG"},
        {B("II\x2a\0"), "TIFF"},
        {B("II\x2b\0"), "BigTIFF"},
        {B("PF\n"), "PFM"},
        {B("P6\n"), "PNM"},
        {B("8BPS"), "Photoshop"},
        {B("GIF89a"), "GIF"},
        {B("RIFF\x1a\0\0\0WEBP"), "WebP"},
        {B("\0\0\0\x0cjP  \r\n\x87\n"), "JPEG 2000"},
        {B("\0\0\0\030ftypheic"), "HEIF"},
        {B("\0\0\0\034ftypavif"), "AVIF"},
        {B("SDPX"), "DPX"},
        {B("\x01\xda"), "SGI"},
        {B("\x53\x80\xf6\x34"), "Softimage"},
        {B("BM"), "BMP"},
        {B(RGBE "-Y 65536 +X 65536\n"), "cannot hold 65536 scanlines"},
        {B(RGBE "+X 32767 -Y 65536\n"), "cannot hold 32767 scanlines"},
        {B("PF\n64 32\n-1.0\n1234567890"), ""},
        {B("PF\n60000 30000\n-1.0\n1234567890"), ""},
        {B("PF\n600000 300000\n-1.0\n1234567890"), ""},
        {B("once upon a time there was a text\n"), "is no image: neither"},
        {B("\7\33\1\5\2\200\377\40\1\2\3"), "is no image"},
        {B("version https://git-lfs.github.com/spec/v1\n"), "Git LFS"},
        {B("\xef\xbb\xbf\n<!DOCTYPE HTML>\n<html><head>"), "HTML"},
        {B("<?xml version=\"1.0\"?><Error>"), "HTML"},
    };
    enum {
        SIGNATURES = 16 /* of them */
    };
    static unsigned char bytes[786432];
    ibl_ctx *none = file_ctx(1, &kept, NULL);
    ibl_ctx *with = file_ctx(1, &kept, file_bridge());
    ibl_status status;

    file_need_oiio();
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        const size_t size = cases[i].size;
        const bool lies = !strncmp(cases[i].bytes, RGBE, sizeof RGBE - 1);
        memset(bytes, 0, 60 + size);
        memcpy(bytes, cases[i].bytes, size);
        CHECK_MSG(survives(with, bytes, lies ? sizeof bytes : size, &status) &&
                      status == IBL_ERR_FORMAT &&
                      test_said(&kept, cases[i].said),
                  "%zu: %d %s", i, status, kept.text[0]);
        for (size_t k = 0; k < 2 && i < SIGNATURES; k++) {
            CHECK(survives(none, bytes, k ? size - 1 : 80, &status) && status);
            CHECK_MSG(test_said(&kept, cases[i].said) != k, "%zu of %s: %s", k,
                      cases[i].said, kept.text[0]);
        }
    }
}

/* The definition, in double: IEC 61966-2-1. */
static double to_linear(double v)
{
    return v <= 0.04045 ? v / 12.92 : pow((v + 0.055) / 1.055, 2.4);
}

/* A 16x16 ramp with every 8-bit value, as PPM; and as other formats, whose
 * integers are of sRGB and whose floats are light. Straight alpha multiplies
 * light if it is asked for. */
TEST(formats)
{
#define STRAIGHT "--attrib oiio:UnassociatedAlpha 1 --ch "
    enum {
        GREY = 1, /* of the ramp's red */
        LIGHT = 2
    };
    static const struct {
        const char *name, *options;
        int kind;
        double tolerance, alpha; /* 0: none; below 0: multiplied by it */
    } cases[] = {
        {"r.png", "", 0, 1e-6, 0},
        {"r16.png", "-d uint16", 0, 1e-6, 0},
        {"r.tif", "", 0, 1e-6, 0},
        {"r.bmp", "", 0, 1e-6, 0},
        {"r.tga", "", 0, 1e-6, 0},
        {"r.sgi", "", 0, 1e-6, 0},
        {"r.dpx", "", 0, 1e-6, 0},
        {"r.gif", "", 0, 0.02, 0},
        {"r.jpg", "--compression jpeg:98", 0, 0.2, 0},
        {"r.webp", "--compression webp:100", 0, 0.2, 0},
        {"a.png", STRAIGHT "R,G,B,A=0.4", 0, 1e-6, 0.4},
        {"a16.png", "-d uint16 " STRAIGHT "R,G,B,A=0.2", 0, 1e-6, 0.2},
        {"a.tif", STRAIGHT "R,G,B,A=0.4", 0, 1e-6, 0.4},
        {"a16.tif", "-d uint16 " STRAIGHT "R,G,B,A=0.4", 0, 1e-6, 0.4},
        {"a.tga", STRAIGHT "R,G,B,A=0.4", 0, 1e-6, 0.4},
        {"p.tif", "--ch R,G,B,A=0.4", 0, 1e-6, -0.4},
        {"grey.png", "--ch R --chnames Y", GREY, 1e-6, 0},
        {"ya.png", STRAIGHT "Y=R,A=0.4", GREY, 1e-6, 0.4},
        {"f.pfm", NULL, LIGHT, 1e-7, 0},
        {"f.tif", "-d float", LIGHT, 1e-7, 0},
        {"f_tiled.tif", "-d float --tile 16 16", LIGHT, 1e-7, 0},
        {"f_alpha.tif", "-d float --ch R,G,B,A=0.5", LIGHT, 1e-7, -0.5},
        {"r.ppm", NULL, 0, 1e-6, 0}};
    const char *command = "oiiotool";
    unsigned char ppm[16 + 768];
    const int n = sprintf((char *)ppm, "P6\n16 16\n255\n");
    ibl_ctx *ctx = file_ctx(2, &kept, file_bridge());
    ibl_read_options opts = ibl_read_options_default();
    ibl_image ramp = map_constant(ctx, 16, 16, 0);

    file_need_oiio();
    opts.any_aspect = 1;
    for (int i = 0; i < 256; i++) {
        ppm[n + 3 * i] = (unsigned char)i;
        ppm[n + 3 * i + 1] = (unsigned char)(i / 2 + 64);
        ppm[n + 3 * i + 2] = (unsigned char)(255 - i);
        for (int c = 0; c < 3; c++)
            ramp.data[3 * i + c] = ppm[n + 3 * i + c] / 255.0f;
    }
    NEED(file_save_pfm(file_path("f.pfm"), &ramp));
    NEED(file_save(file_path("r.ppm"), ppm, (size_t)n + 768));
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++)
        if (cases[k].options)
            command = test_text("%s r.ppm --scanline -d uint8 %s -o %s",
                                command, cases[k].options, cases[k].name);
    NEED(file_run("%s", command));
    for (size_t k = 0; k < 2 * sizeof cases / sizeof *cases; k++) {
        const char *name = cases[k / 2].name;
        const int kind = cases[k / 2].kind, asked = k % 2;
        const double alpha = cases[k / 2].alpha;
        ibl_image img;
        ibl_read_report report;
        double worst = 0;
        opts.alpha = asked ? IBL_ALPHA_FILE : IBL_ALPHA_IGNORE;
        CHECK_MSG(!by_rows(ctx, file_path(name), 0, &opts, &img, &report),
                  "%s: %s", name, kept.text[0]);
        if (!img.data)
            continue;
        CHECK_MSG(report.low_range == !(kind & LIGHT) && report.bridged &&
                      strstr(report.format, "by OpenImageIO") &&
                      !(kind & LIGHT) == !!strstr(kept.text[IBL_LOG_WARNING],
                                                  "low dynamic range"),
                  "%s: %s", name, kept.text[IBL_LOG_WARNING]);
        const double seen = asked && alpha != 0 ? fabs(alpha) : 1;
        CHECK_NEAR((double)report.alpha_most, seen, 1e-6);
        CHECK_NEAR((double)report.alpha_least, seen, 1e-6);
        for (int i = 0; i < 3 * 256; i++) {
            const double v = ppm[n + (kind & GREY ? i / 3 * 3 : i)] / 255.0;
            const double light = kind & LIGHT ? v : to_linear(v);
            worst = fmax(worst, fabs((double)img.data[i] -
                                     light * (alpha > 0 ? seen : 1)));
        }
        CHECK_MSG(worst <= cases[k / 2].tolerance, "%s: off by %g", name,
                  worst);
    }
}
