/* SPDX-License-Identifier: MIT */
/*
 * Maps read row by row: the same floats however they are divided into calls,
 * by however many threads and from wherever they come; files that are damaged
 * or cut while they are read; and how much memory it takes.
 */
#include <errno.h>
#include <math.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "exr.h"
#include "files.h"
#include "float_exr.h"
#include "ibl/io.h"
#include "test.h"
#include "textures.h"

enum {
    W = 300,
    H = 150
};

static test_messages kept;

/* ---- reading -------------------------------------------------------- */

static size_t floats_of(const ibl_image *img, int rows)
{
    return 3 * (size_t)img->width * (size_t)rows;
}

/* All rows by ibl_source_read, batch at a time (0: all). */
static ibl_status by_rows(ibl_ctx *ctx, const char *path, int batch,
                          const ibl_read_options *opts, ibl_image *img,
                          ibl_read_report *report)
{
    ibl_source *s;
    ibl_status status;

    memset(&kept, 0, sizeof kept);
    *img = (ibl_image){0};
    status = ibl_source_open(ctx, path, opts, &s);
    if (status) {
        CHECK(!s);
        return status;
    }
    status =
        ibl_image_alloc(ctx, ibl_source_width(s), ibl_source_height(s), img);
    for (int y = 0, n; !status && y < img->height; y += n) {
        const int left = img->height - y;
        n = batch && batch < left ? batch : left;
        status = ibl_source_read(s, n, img->data + floats_of(img, y));
    }
    if (report)
        *report = *ibl_source_report(s);
    if (status) {
        float none[1];
        CHECK(ibl_source_read(s, 1, none) == status);
        ibl_image_free(img);
    }
    ibl_source_close(s);
    return status;
}

static bool same_report(const ibl_read_report *a, const ibl_read_report *b)
{
    return !strcmp(a->format, b->format) && a->nonfinite == b->nonfinite &&
           a->negative == b->negative && a->peak == b->peak &&
           a->low_range == b->low_range && a->bridged == b->bridged;
}

/* A file by rows in every way beside the same bytes as a whole. */
static void every_way(const char *path)
{
    static const int batches[] = {1, 3, 16, 64, 0}, threads[] = {1, 2, 7};
    ibl_read_options opts = ibl_read_options_default();
    ibl_read_report want, got;
    ibl_image whole = {0}, img;
    size_t size;
    unsigned char *bytes = file_load(path, &size);
    ibl_ctx *ctx = file_ctx(1, &kept, file_bridge());

    opts.any_aspect = 1;
    CHECK_MSG(
        !ibl_image_decode(ctx, "whole", bytes, size, &opts, &whole, &want),
        "%s: %s", path, kept.text[0]);
    NEED(whole.data);
    for (int i = 0; i < 15; i += TEST_SANITIZED ? 4 : 1) {
        ctx = file_ctx(threads[i / 5], &kept, file_bridge());
        const ibl_status status =
            by_rows(ctx, path, batches[i % 5], &opts, &img, &got);
        CHECK_MSG(!status, "%s: %s", path, kept.text[0]);
        if (!status) {
            CHECK_MSG(
                img.width == whole.width && img.height == whole.height &&
                    !memcmp(img.data, whole.data,
                            floats_of(&whole, whole.height) * sizeof(float)),
                "%s: rows of %d, %d threads differ", path, batches[i % 5],
                threads[i / 5]);
            CHECK_MSG(same_report(&got, &want), "%s: %s, %zu, %zu, %g", path,
                      got.format, got.nonfinite, got.negative,
                      (double)got.peak);
        }
        ibl_image_free(&img);
    }
    ibl_image_free(&whole);
}

/* ---- files ---------------------------------------------------------- */

/* Noise that does not compress, with some of what has to be mended: now and
 * then a pixel, and whole rows around the borders of batches and blocks. */
static void wild(ibl_image *img)
{
    const float odd[] = {INFINITY, -INFINITY, NAN, -2.5f, -0.0f};
    test_random r = {5};
    for (int y = 0; y < img->height; y++) {
        const bool all = y % 16 == 15 || y % 48 == 0 || y == 2;
        for (int i = 0; i < 3 * img->width; i++) {
            const double u = test_random_unit(&r);
            img->data[floats_of(img, y) + (size_t)i] =
                (all && u < 0.7) || u < 0.002
                    ? odd[test_random_u64(&r) % 5]
                    : (float)(exp(8 * u) * test_random_unit(&r));
        }
    }
}

static bool save_wild(const char *name)
{
    ibl_ctx *ctx = file_ctx(1, &kept, NULL);
    ibl_image img;
    if (ibl_image_alloc(ctx, W, H, &img))
        return false;
    wild(&img);
    const bool ok = file_save_pfm(file_path(name), &img);
    ibl_image_free(&img);
    return ok;
}

/* A flat or run-length encoded picture of W x H scanlines in any order. */
static void save_hdr(const char *path, const char *resolution, bool coded)
{
    test_random r = {6};
    FILE *f = fopen(path, "wb");
    fprintf(f, "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\nEXPOSURE=1e-30\n\n%s\n",
            resolution);
    const bool by_column = resolution[1] == 'X';
    const int px = by_column ? H : W, lines = by_column ? W : H;
    for (int y = 0; y < lines; y++) {
        if (coded)
            fwrite((unsigned char[]){2, 2, (unsigned char)(px >> 8),
                                     (unsigned char)px},
                   1, 4, f);
        for (int left = coded ? 4 * px : 0, plane = px; left > 0;) {
            const int most = plane < 127 ? plane : 127;
            const int n = 1 + (int)(test_random_u64(&r) % (uint64_t)most);
            const bool run = test_random_u64(&r) % 3 == 0;
            fputc(run ? 128 + n : n, f);
            for (int i = 0; i < (run ? 1 : n); i++)
                fputc((int)(test_random_u64(&r) % 256), f);
            left -= n;
            plane -= n;
            plane += plane ? 0 : px;
        }
        for (int i = 0; !coded && i < px; i++)
            fwrite((unsigned char[]){(unsigned char)(128 | (i * 3)),
                                     (unsigned char)y, (unsigned char)i,
                                     (unsigned char)(120 + i % 16 * (y % 9))},
                   1, 4, f);
    }
    fclose(f);
}

TEST(radiance)
{
    static const char *const resolutions[] = {
        "-Y 150 +X 300", "-Y 150 -X 300", "+Y 150 +X 300", "+Y 150 -X 300",
        "+X 300 -Y 150", "+X 300 +Y 150", "-X 300 -Y 150", "-X 300 +Y 150"};
    for (int i = 0; i < 16; i += TEST_RACES ? 5 : 1) {
        save_hdr(file_path("x.hdr"), resolutions[i / 2], i % 2);
        every_way(file_path("x.hdr"));
    }
}

/* Blocks of one, 16 and 32 scan lines, tiles, windows that begin and end within
 * blocks, and what goes through the bridge; check_exr reads more kinds. */
TEST(other_formats)
{
    static const char *const options[] = {
        "-d half --compression rle -o 0.exr",
        "-d float --compression zips -o 1.exr --compression piz -o 2.exr",
        "-d half --tile 32 16 --compression zip -o 3.exr",
        "-d float --tile 17 150 --compression pxr24 -o 4.exr",
        "-d half --compression b44 -o 5.exr --compression dwab -o 6.exr",
        "-d float --fullsize 300x150-20-13 --compression zip -o 7.exr",
        "-d float --fullsize 300x150+31+21 --tile 64 32 -o 8.exr",
        "-d float --fullsize 350x170-20-10 --compression none -o 9.exr",
        "-d float --fullsize 100x40+7+75 --compression zip -o 10.exr",
        "-d float --tile 32 32 -o 11.tif",
        "--scanline -d uint8 -o 12.png"};
    static const char *const names[] = {
        "0.exr", "1.exr", "2.exr", "3.exr",  "4.exr",  "5.exr",  "6.exr",
        "7.exr", "8.exr", "9.exr", "10.exr", "11.tif", "12.png", "w.pfm"};
    char command[2000] = "oiiotool";
    file_need_oiio();
    NEED(save_wild("w.pfm"));
    for (size_t i = 0; i < sizeof options / sizeof *options; i++)
        sprintf(command + strlen(command), " w.pfm --scanline %s", options[i]);
    NEED(file_run("%s", command));
    for (size_t i = 0; i < sizeof names / sizeof *names; i++)
#if defined(__SANITIZE_THREAD__)
        if (i != 6 && i < 11) /* OpenImageIO's threads are not built for it */
#endif
            every_way(file_path(names[i]));
}

static bool write_exr(const char *path, int w, int h, exr_compression_t comp)
{
    static const test_exr_channel channels[] = {{"B", EXR_PIXEL_HALF, 1, NULL},
                                                {"G", EXR_PIXEL_HALF, 1, NULL},
                                                {"R", EXR_PIXEL_HALF, 1, NULL}};
    return test_exr_write(path, w, h, comp, channels, 3, NULL, -1);
}

/* ---- pixels in memory ------------------------------------------------ */

/* What a file of the same pixels gives, damaged ones included, in any way that
 * they may lie in memory, some rows at a time; and the same counts. */
TEST(pixels_in_memory)
{
    enum {
        WIDE = 64,
        HIGH = 32,
        GAP = 5 /* bytes */
    };
    float *rgba = test_alloc(4 * WIDE * HIGH, sizeof *rgba);
    float *planes = test_alloc(4 * WIDE * HIGH, sizeof *planes);
    ibl_ctx *ctx = test_keeping_ctx(2, &kept);
    ibl_read_options o = ibl_read_options_default();
    ibl_read_report of_file, report;
    test_random r = {5};
    ibl_image img;

    for (int i = 0; i < 4 * WIDE * HIGH; i++)
        rgba[i] = (float)(1 + test_random_below(&r, 1024)) / 1024;
    rgba[4 * 70] = NAN;
    rgba[4 * 700 + 2] = INFINITY;
    rgba[4 * 900 + 1] = -2;
    for (int i = 0; i < 4 * WIDE * HIGH; i++)
        planes[i] = rgba[i % (WIDE * HIGH) * 4 + 3 - i / (WIDE * HIGH)];
    FILE *file = fopen(file_path("pixels.exr"), "wb");
    NEED(file && test_write_float_exr(file, WIDE, HIGH, "ABGR", planes));
    NEED(!fclose(file));
    for (int k = 0; k < 16; k++) {
        const int channels = k & 1 ? 4 : 3, half = k >> 1 & 1,
                  down = k >> 2 & 1;
        const int bytes = half ? 2 : 4;
        const ptrdiff_t row = WIDE * channels * bytes + (k & 8 ? GAP : 0);
        unsigned char *data = test_alloc((size_t)row, HIGH);
        const ibl_pixels pixels = {.data = data + (down ? (HIGH - 1) * row : 0),
                                   .width = WIDE,
                                   .height = HIGH,
                                   .channels = channels,
                                   .half = half,
                                   .row_bytes = down    ? -row
                                                : k & 8 ? row
                                                        : 0};
        for (int i = 0; i < channels * WIDE * HIGH; i++) {
            const int y = i / channels / WIDE, x = i / channels % WIDE;
            const float f = rgba[4 * (y * WIDE + x) + i % channels];
            uint16_t texel[4];
            texels_encode(IBL_PIXEL_RGBA16F, (float[]){f, f, f}, 1, texel);
            texel[0] = isnan(f) ? 0x7e00 : isinf(f) ? 0x7c00 : texel[0];
            memcpy(data + (down ? HIGH - 1 - y : y) * row +
                       (x * channels + i % channels) * bytes,
                   half ? (void *)texel : (void *)&f, (size_t)bytes);
        }
        o.alpha = channels == 4 ? IBL_ALPHA_STRAIGHT : IBL_ALPHA_IGNORE;
        NEED(!ibl_image_read(ctx, file_path("pixels.exr"), &o, &img, &of_file));
        ibl_source *s;
        float *rgb = test_alloc(3 * WIDE * HIGH, sizeof *rgb);
        NEED(!ibl_source_of_pixels(ctx, "mine", &pixels, &o, &s));
        NEED(!ibl_source_read(s, 3, rgb) &&
             !ibl_source_read(s, HIGH - 3, rgb + (size_t)3 * 3 * WIDE));
        CHECK_MSG(!memcmp(rgb, img.data, 3 * WIDE * HIGH * sizeof *rgb),
                  "layout %d", k);
        report = *ibl_source_report(s);
        CHECK(report.nonfinite == 2 && report.negative == 1 &&
              report.nonfinite == of_file.nonfinite &&
              report.has_alpha == of_file.has_alpha &&
              !memcmp(&report.peak, &of_file.peak, sizeof report.peak));
        ibl_source_close(s);
        ibl_image_free(&img);
        o.strict = 1;
        NEED(!ibl_source_of_pixels(ctx, "mine", &pixels, &o, &s));
        CHECK(ibl_source_read(s, HIGH, rgb) == IBL_ERR_FORMAT);
        CHECK(
            strstr(kept.text[IBL_LOG_ERROR], "mine: 2 pixels are not finite"));
        ibl_source_close(s);
        o.strict = 0;
    }
    ibl_source *none;
    const ibl_pixels bad[] = {{rgba, WIDE, HIGH, 2, 0, 0},
                              {rgba, WIDE, WIDE, 4, 0, 0},
                              {rgba, -WIDE, HIGH, 4, 0, 0},
                              {rgba, WIDE, HIGH, 4, 2, 0},
                              {rgba, WIDE, HIGH, 4, 0, 16 * WIDE - 4},
                              {rgba, WIDE, HIGH, 4, 0, 4 - 16 * WIDE},
                              {rgba, WIDE, HIGH, 4, 0, (ptrdiff_t)1 << 62},
                              {rgba, WIDE, HIGH, 4, 0, PTRDIFF_MIN}};
    for (size_t k = 0; k < sizeof bad / sizeof *bad; k++) {
        const ibl_status status =
            ibl_source_of_pixels(ctx, "bad", &bad[k], NULL, &none);
        CHECK_MSG(!none &&
                      status == (k == 1 ? IBL_ERR_FORMAT : IBL_ERR_ARGUMENT),
                  "pixels %zu: %s", k, ibl_status_text(status));
    }
}

/* ---- calls ---------------------------------------------------------- */

TEST(arguments)
{
    static const struct {
        int rows;
        ibl_status status;
    } reads[] = {{0, IBL_ERR_ARGUMENT},     {-1, IBL_ERR_ARGUMENT},
                 {H + 1, IBL_ERR_ARGUMENT}, {H - 1, IBL_OK},
                 {2, IBL_ERR_ARGUMENT},     {1, IBL_OK},
                 {1, IBL_ERR_ARGUMENT}};
    ibl_ctx *ctx = file_ctx(2, &kept, NULL);
    static float rgb[3 * W * H];
    ibl_read_options opts = ibl_read_options_default();
    ibl_source *s;

    save_hdr(file_path("a.hdr"), "-Y 150 +X 300", false);
    NEED(!ibl_source_open(ctx, file_path("a.hdr"), NULL, &s));
    CHECK(ibl_source_width(s) == W && ibl_source_height(s) == H);
    for (size_t i = 0; i < sizeof reads / sizeof *reads; i++)
        CHECK(ibl_source_read(s, reads[i].rows, rgb) == reads[i].status);
    CHECK(!strcmp(ibl_source_report(s)->format, "Radiance RGBE"));
    ibl_source_close(s);
    /* closed before the end */
    NEED(!ibl_source_open(ctx, file_path("a.hdr"), NULL, &s));
    CHECK(!ibl_source_read(s, 7, rgb));
    ibl_source_close(s);
    ibl_source_close(NULL);
    opts.layer = "x";
    CHECK(ibl_source_open(ctx, file_path("a.hdr"), &opts, &s) ==
              IBL_ERR_FORMAT &&
          !s);
}

typedef struct canceller {
    ibl_ctx *ctx;
    double at;
    int calls;
} canceller;

static void cancel_at(void *cookie, const char *stage, double done,
                      double whole)
{
    CHECK(whole < 0);
    canceller *c = cookie;
    CHECK(!strcmp(stage, "decode"));
    c->calls++;
    if (done >= c->at)
        ibl_ctx_cancel(c->ctx);
}

TEST(cancelled)
{
    save_hdr(file_path("c0"), "-Y 150 +X 300", true);
    save_hdr(file_path("c1"), "-X 300 +Y 150", true);
    NEED(write_exr(file_path("c2"), W, H, EXR_COMPRESSION_ZIPS));
    for (int i = 0; i < 3 * 2 * 3; i++) {
        char name[] = "c0";
        canceller c = {.at = (double[]){0, 0.3, 2}[i / 6]};
        ibl_ctx_options opts = ibl_ctx_options_default();
        ibl_image img;
        opts.progress = cancel_at;
        opts.progress_cookie = &c;
        c.ctx = test_ctx_of(&opts);
        name[1] = (char)('0' + i % 3);
        const ibl_status status = by_rows(c.ctx, file_path(name),
                                          i / 3 % 2 ? 16 : 0, NULL, &img, NULL);
        /* of a whole image nothing but the copying is left, maybe */
        CHECK_MSG(status == (c.at < 2 ? IBL_ERR_CANCELLED : IBL_OK) ||
                      (i / 3 % 2 == 0 && c.at > 0),
                  "%s at %g: %d", name, c.at, status);
        CHECK(c.calls > 0);
        ibl_image_free(&img);
    }
}

/* ---- damage --------------------------------------------------------- */

static const char *const victims[] = {"v0", "v1", "v2", "v3"};

static void make_victims(void)
{
    save_hdr(file_path("v0"), "-Y 150 +X 300", true);
    save_hdr(file_path("v1"), "-Y 150 +X 300", false);
    NEED(write_exr(file_path("v2"), W, H, EXR_COMPRESSION_ZIP));
    NEED(write_exr(file_path("v3"), W, H, EXR_COMPRESSION_NONE));
}

/* Files that are cut while they are read. */
TEST(cut_while_read)
{
    static float rgb[3 * W * H];
    ibl_ctx *ctx = file_ctx(2, &kept, NULL);

    make_victims();
    for (int k = 0; k < 4; k++) {
        size_t size;
        unsigned char *bytes = file_load(file_path(victims[k]), &size);
        for (int rows = 0; rows < H; rows += 49) {
            ibl_source *s;
            memset(&kept, 0, sizeof kept);
            NEED(file_save(file_path("cut"), bytes, size));
            NEED(!ibl_source_open(ctx, file_path("cut"), NULL, &s));
            CHECK(!rows || !ibl_source_read(s, rows, rgb));
            NEED(!truncate(file_path("cut"), (off_t)size / 9));
            const ibl_status status = ibl_source_read(s, H - rows, rgb);
            /* what has been read ahead, and small files, may be all */
            CHECK_MSG(status ? status == IBL_ERR_FORMAT && kept.text[0][0] &&
                                   !strchr(kept.text[0], '\n')
                             : k < 3,
                      "%s at %d: %d, \"%s\"", victims[k], rows, status,
                      kept.text[0]);
            ibl_source_close(s);
        }
    }
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

/* Short or interrupted reads continue; a read that fails fails the whole. */
TEST(short_reads)
{
    ibl_ctx *ctx = file_ctx(2, &kept, NULL);

    make_victims();
    const int free_file = dup(STDIN_FILENO);
    close(free_file);
    for (int k = 0; k < 4; k++) {
        ibl_image want, got;
        slow.calls = 0;
        NEED(!by_rows(ctx, file_path(victims[k]), 16, NULL, &want, NULL));
        const int calls = slow.calls;
        for (int on = 0; on < 2; on++) {
            slow.on = on;
            slow.most = 1009;
            CHECK_MSG(
                !by_rows(ctx, file_path(victims[k]), 16, NULL, &got, NULL) &&
                    !memcmp(want.data, got.data,
                            floats_of(&want, H) * sizeof(float)),
                "%s: %s", victims[k], kept.text[0]);
            ibl_image_free(&got);
        }
        slow.most = 0;
        slow.on = false;
        for (int i = 0; i < calls; i++) {
            slow.calls = 0;
            slow.left = i;
            CHECK_MSG(by_rows(ctx, file_path(victims[k]), 16, NULL, &got,
                              NULL) == IBL_ERR_IO &&
                          strstr(kept.text[0], "cannot be read"),
                      "%s, read %d: %s", victims[k], i, kept.text[0]);
        }
        slow.left = -1;
        ibl_image_free(&want);
    }
    CHECK(dup(STDIN_FILENO) == free_file); /* all are closed */
    close(free_file);
}

/* A header of any length. */
TEST(long_header)
{
    ibl_ctx *ctx = file_ctx(1, &kept, NULL);
    const char *path = file_path("long.hdr");
    ibl_image img;
    FILE *f = fopen(path, "wb");
    NEED(f);
    fprintf(f, "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n");
    for (int i = 0; i < 30000; i++)
        fprintf(f, "\tpfilt -1 -e +%d\n", i);
    fprintf(f, "\n-Y 4 +X 8\n");
    for (int i = 0; i < 32; i++)
        fwrite((unsigned char[]){128, 64, 32, 129}, 1, 4, f);
    NEED(!fclose(f));
    NEED(!by_rows(ctx, path, 1, NULL, &img, NULL));
    CHECK(img.data[0] == 1 && img.data[95] == 0.25f);
    ibl_image_free(&img);
}

/* ---- memory --------------------------------------------------------- */

/* A whole map takes at most what the context may: 12 bytes a pixel. */
TEST(whole_maps_are_bounded)
{
    ibl_ctx_options with = ibl_ctx_options_default();
    ibl_image img;

    save_hdr(file_path("a.hdr"), "-Y 150 +X 300", false);
    with.log = test_keep;
    with.log_cookie = &kept;
    with.memory = 12 * W * H;
    CHECK(!ibl_image_read(test_ctx_of(&with), file_path("a.hdr"), NULL, &img,
                          NULL));
    ibl_image_free(&img);
    with.memory--;
    CHECK(ibl_image_read(test_ctx_of(&with), file_path("a.hdr"), NULL, &img,
                         NULL) == IBL_ERR_MEMORY);
    CHECK(test_said(&kept, "a.hdr: takes 1 MiB of memory, more than the 0"));
}

/* Reads path by 64 rows: what its memory grew by in MiB, or 255. */
static int growth(const char *path)
{
    enum {
        BATCH = 64
    };
    struct rusage before, after;
    ibl_source *s;

    getrusage(RUSAGE_SELF, &before);
    if (ibl_source_open(file_ctx(2, &kept, NULL), path, NULL, &s))
        return 255;
    const int w = ibl_source_width(s), h = ibl_source_height(s);
    float *rgb = malloc(sizeof *rgb * 3 * (size_t)w * BATCH);
    for (int y = 0; y < h; y += BATCH) {
        if (ibl_source_read(s, BATCH, rgb))
            return 255;
        for (int x = 0; x < 3 * w; x += 17)
            if (rgb[x] != test_exr_pattern(x / 3, y, x % 3))
                return 254;
    }
    getrusage(RUSAGE_SELF, &after);
    const long mib = (after.ru_maxrss - before.ru_maxrss) / 1024;
    return mib < 253 ? (int)mib : 253;
}

/* A process of its own reads a map that would take 96 MiB, or 1.5 GiB. */
TEST_SLOW(memory)
{
    const char *large = getenv("IBL_TEST_LARGE");
    const int times = large && *large ? 4 : 1;
    const char *path = file_path("large.exr");
    int code;

    if (TEST_SANITIZED)
        test_skip("sanitizers need memory of their own");
    NEED(write_exr(path, 4096 * times, 2048 * times, EXR_COMPRESSION_ZIP));
    const pid_t pid = fork();
    if (!pid)
        _exit(growth(path));
    NEED(waitpid(pid, &code, 0) == pid && WIFEXITED(code));
    remove(path);
    test_measured("MiB", WEXITSTATUS(code), 25 * times);
    CHECK_MSG(WEXITSTATUS(code) <= 25 * times, "%d MiB", WEXITSTATUS(code));
}
