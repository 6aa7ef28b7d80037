/* SPDX-License-Identifier: MIT */
/* Loading, telling kinds apart, mending, and what goes through the bridge. */
#include <fcntl.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include "files.h"
#include "ibl/io.h"
#include "test.h"

static test_messages kept;

static ibl_status read_file(ibl_ctx *ctx, const char *path, ibl_image *img,
                            ibl_read_report *report)
{
    ibl_read_options opts = ibl_read_options_default();
    opts.any_aspect = 1;
    memset(&kept, 0, sizeof kept);
    *img = (ibl_image){0};
    return ibl_image_read(ctx, path, &opts, img, report);
}

/* An uncompressed .hdr, so that tests of loading need no other program. */
static size_t make_hdr(unsigned char *bytes, int width, int height)
{
    size_t n = (size_t)sprintf((char *)bytes,
                               "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y %d +X "
                               "%d\n",
                               height, width);
    for (int i = 0; i < width * height; i++, n += 4)
        memcpy(bytes + n,
               (unsigned char[]){(unsigned char)(128 + i % 100), 64, 32, 129},
               4);
    return n;
}

/* ---- mending -------------------------------------------------------- */

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

/* Mends a map, at most `most` rows a call, all to the same memory. */
static ibl_status mend(ibl_ctx *ctx, ibl_image *img, int most, test_random *r,
                       ibl_read_report *done)
{
    const size_t floats = 3 * (size_t)img->width;
    float *from = test_alloc(floats * (size_t)img->height, sizeof *from);
    float *call = test_alloc(floats * (size_t)most, sizeof *call);
    const ibl_pixels pixels = {.data = from,
                               .width = img->width,
                               .height = img->height,
                               .channels = 3};
    ibl_read_options opts = ibl_read_options_default();
    ibl_source *s;

    *done = (ibl_read_report){.format = ""};
    opts.any_aspect = 1;
    memcpy(from, img->data, floats * sizeof *from * (size_t)img->height);
    ibl_status status = ibl_source_of_pixels(ctx, "map", &pixels, &opts, &s);
    for (int y = 0, n; !status && y < img->height; y += n) {
        const int left = img->height - y;
        n = 1 + test_random_below(r, most);
        n = n < left ? n : left;
        status = ibl_source_read(s, n, call);
        memcpy(img->data + floats * (size_t)y, call,
               floats * sizeof *call * (size_t)n);
    }
    if (!status)
        *done = *ibl_source_report(s);
    ibl_source_close(s);
    return status;
}

TEST(mending)
{
    static const int sizes[][2] = {{1, 1},   {2, 1},   {1, 2},   {3, 2},
                                   {37, 33}, {64, 32}, {300, 49}};
    /* Shares of Inf, -Inf, NaN and negative values. */
    static const double shares[] = {0, 0.001, 0.2, 0.9, 1};
    test_random r = {77};

    for (int threads = 1; threads <= 3; threads += 2) {
        ibl_ctx *ctx = file_ctx(threads, &kept, NULL);
        for (int s = 0; s < 7 * 5 * 4; s++) {
            const int w = sizes[s % 7][0], h = sizes[s % 7][1];
            const int calls[] = {1, 3, 20, h};
            const size_t bytes = 3 * sizeof(float) * (size_t)w * (size_t)h;
            ibl_image a, b;
            ibl_read_report done;
            NEED(!ibl_image_alloc(ctx, w, h, &a));
            NEED(!ibl_image_alloc(ctx, w, h, &b));
            for (int i = 0; i < 3 * w * h; i++) {
                const float bad[] = {INFINITY, -INFINITY, NAN, -1.5f, -0.0f};
                const bool hit = test_random_unit(&r) < shares[s / 7 % 5];
                a.data[i] = hit ? bad[test_random_u64(&r) % 5]
                                : (float)test_random_unit(&r);
            }
            memcpy(b.data, a.data, bytes);
            const ibl_read_report want = truth(&b);
            NEED(!mend(ctx, &a, calls[s / 35], &r, &done));
            CHECK_MSG(done.nonfinite == want.nonfinite &&
                          done.negative == want.negative,
                      "%dx%d: %zu and %zu, not %zu and %zu", w, h,
                      done.nonfinite, done.negative, want.nonfinite,
                      want.negative);
            CHECK(done.peak == want.peak);
            for (int i = 0; i < 3 * w * h; i++) {
                if (a.data[i] == b.data[i] && !signbit(a.data[i]))
                    continue;
                test_fail(__FILE__, __LINE__, "%dx%d: %d is %g, not %g", w, h,
                          i, (double)a.data[i], (double)b.data[i]);
                break;
            }
            ibl_image_free(&a);
            ibl_image_free(&b);
        }
    }
}

TEST(mended_and_strict)
{
    static const float odd[] = {INFINITY, NAN, -3, 3};
    ibl_ctx *ctx = file_ctx(2, &kept, NULL);
    ibl_read_options opts = ibl_read_options_default();
    const char *path = file_path("bad.exr");
    ibl_read_report report;
    ibl_image img, back = {0};
    NEED(!ibl_image_alloc(ctx, 8, 4, &img));
    test_image(img);
    for (int i = 0; i < 96; i++)
        img.data[i] = (float)i;
    img.data[3 * 11] = INFINITY;
    img.data[3 * 12 + 1] = -3;
    img.data[3 * 13 + 2] = NAN;
    NEED(file_save_exr(path, &img, NULL));
    memset(&kept, 0, sizeof kept);
    NEED(!ibl_image_read(ctx, path, &opts, &back, &report));
    CHECK(report.nonfinite == 2 && report.negative == 1);
    CHECK(back.data[3 * 11] == 36 && back.data[3 * 12 + 1] == 0);
    CHECK(back.data[3 * 13 + 2] == 44 && report.peak == 95);
    CHECK(strstr(kept.text[IBL_LOG_WARNING], "1 pixels were negative") != NULL);
    ibl_image_free(&back);
    opts.strict = 1;
    CHECK(ibl_image_read(ctx, path, &opts, &back, &report) == IBL_ERR_FORMAT);
    CHECK_MSG(strstr(kept.text[0], "2 pixels") && !back.data, "%s",
              kept.text[0]);
    /* One alone, or none. */
    img.data[3 * 11] = img.data[3 * 13 + 2] = 1;
    for (int i = 0; i < 4; i++) {
        img.data[3 * 12 + 1] = odd[i];
        NEED(file_save_exr(path, &img, NULL));
        CHECK_MSG(ibl_image_read(ctx, path, &opts, &back, NULL) ==
                      (i < 3 ? IBL_ERR_FORMAT : IBL_OK),
                  "strict with %g", (double)odd[i]);
        ibl_image_free(&back);
    }
}

/* ---- loading -------------------------------------------------------- */

static void refused(ibl_ctx *ctx, const char *path, ibl_status want,
                    const char *text)
{
    ibl_image img;
    const ibl_status status = read_file(ctx, path, &img, NULL);
    CHECK_MSG(status == want, "%s: %d", path, status);
    CHECK_MSG(strstr(kept.text[0], text) && !strchr(kept.text[0], '\n'),
              "%s: %s", path, kept.text[0]);
    CHECK_MSG(!strcmp(path, "-") || strstr(kept.text[0], path), "%s",
              kept.text[0]);
    CHECK(!img.data);
}

TEST(not_to_be_opened)
{
    ibl_ctx *ctx = file_ctx(1, &kept, NULL);

    refused(ctx, "/nonexistent/x.hdr", IBL_ERR_IO, "No such file");
    refused(ctx, test_text("%s", test_dir()), IBL_ERR_IO, "is a directory");
    NEED(file_save(file_path("empty.hdr"), "", 0));
    refused(ctx, file_path("empty.hdr"), IBL_ERR_FORMAT, "is empty");
    refused(ctx, "/dev/zero", IBL_ERR_IO, "is a device");
}

static void is_the_hdr(const ibl_image *img, int width, int height)
{
    NEED(img->data && img->width == width && img->height == height);
    for (int i = 0; i < width * height; i++)
        CHECK(fabsf(img->data[3 * i] - (float)(128 + i % 100) / 128) < 0.01f);
}

/* Reads what another process sends to standard input after a pause, in parts;
 * by its name, or "-". */
static ibl_status read_stdin(ibl_ctx *ctx, const char *name, const void *bytes,
                             size_t size, ibl_image *img)
{
    const struct timespec pause = {0, 20000000};
    const int saved = dup(STDIN_FILENO);
    int ends[2], code;

    if (pipe(ends) || fflush(NULL))
        exit(1);
    dup2(ends[0], STDIN_FILENO);
    close(ends[0]);
    const pid_t child = fork();
    if (!child) {
        close(STDIN_FILENO);
        nanosleep(&pause, NULL);
        for (ssize_t n = 1; n > 0 && size; size -= (size_t)n) {
            n = write(ends[1], bytes, size < 50000 ? size : 50000);
            bytes = (const char *)bytes + n;
        }
        _exit(0);
    }
    close(ends[1]);
    const ibl_status status = read_file(ctx, name, img, NULL);
    dup2(saved, STDIN_FILENO); /* the writer sees it closed */
    close(saved);
    waitpid(child, &code, 0);
    return status;
}

TEST_OF(streams, "streams", TEST_RACES || !TEST_SANITIZED)
{
    static unsigned char bytes[400000];
    const size_t size = make_hdr(bytes, 300, 150);
    ibl_ctx *ctx = file_ctx(1, &kept, NULL);
    ibl_image img;

    for (int i = 0; i < 2; i++) {
        CHECK_MSG(!read_stdin(ctx, i ? "/dev/stdin" : "-", bytes, size, &img),
                  "%s", kept.text[0]);
        is_the_hdr(&img, 300, 150);
        ibl_image_free(&img);
    }
    CHECK(read_stdin(ctx, "-", "", 0, &img) == IBL_ERR_FORMAT);
    CHECK(test_said(&kept, "standard input: is empty"));
}

/* What comes after the pixels is ignored. */
TEST(streams_that_go_on)
{
    static unsigned char bytes[500000];
    ibl_ctx *ctx = file_ctx(1, &kept, NULL);
    ibl_image img;

    memset(bytes, 128, sizeof bytes);
    make_hdr(bytes, 2, 1);
    CHECK_MSG(!read_stdin(ctx, "-", bytes, sizeof bytes, &img), "%s",
              kept.text[0]);
    ibl_image_free(&img);
}

/* A header of 48 GiB of floats in front of 786 kB, in both directions. */
TEST(more_than_the_file_has)
{
    static const char *const heads[] = {
        "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 65536 +X 65536\n",
        "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n+X 32767 -Y 65536\n"};
    static unsigned char bytes[786432 + 64];
    ibl_ctx *ctx = file_ctx(1, &kept, NULL);

    for (int i = 0; i < 2; i++) {
        memcpy(bytes, heads[i], strlen(heads[i]));
        NEED(file_save(file_path("run.hdr"), bytes, sizeof bytes));
        refused(ctx, file_path("run.hdr"), IBL_ERR_FORMAT,
                i ? "cannot hold 32767 scanlines" : "cannot hold 65536");
    }
}

TEST(options)
{
    static unsigned char bytes[40000];
    const size_t size = make_hdr(bytes, 90, 60);
    static const ibl_status want[] = {IBL_ERR_ARGUMENT, IBL_OK, IBL_OK,
                                      IBL_ERR_FORMAT}; /* part -2 to 1 */
    ibl_ctx *ctx = file_ctx(1, &kept, NULL);
    ibl_read_options opts = ibl_read_options_default();
    ibl_read_report report;
    ibl_image img = {0};

    CHECK(!opts.layer && opts.part == -1 && !opts.strict && !opts.any_aspect);
    CHECK(ibl_image_decode(ctx, "m.hdr", bytes, size, NULL, &img, NULL) ==
          IBL_ERR_FORMAT);
    CHECK_MSG(test_said(&kept, "m.hdr: 90x60 is not 2:1") && !img.data, "%s",
              kept.text[0]);
    opts.any_aspect = 1;
    for (int i = 0; i < 4; i++) {
        opts.part = i - 2;
        CHECK(ibl_image_decode(ctx, "m.hdr", bytes, size, &opts, &img,
                               &report) == want[i]);
        if (want[i])
            continue;
        CHECK(strstr(report.format, "RGBE") && !report.bridged &&
              !report.low_range && report.peak > 1.7f && report.peak < 1.8f);
        is_the_hdr(&img, 90, 60);
        ibl_image_free(&img);
    }
    CHECK(ibl_image_decode(ctx, "m.hdr", bytes, 0, NULL, &img, NULL) ==
          IBL_ERR_FORMAT);
    /* The name means nothing. */
    NEED(file_save(file_path("really_hdr.exr"), bytes, size));
    CHECK(!read_file(ctx, file_path("really_hdr.exr"), &img, &report));
    ibl_image_free(&img);
}

/* ---- the bridge ----------------------------------------------------- */

/* None, a bridge whose OpenImageIO has gone, and what is something else. */
TEST(no_bridge)
{
    static const unsigned char png[] = "\x89PNG\r\n\x1a\n\0\0\0\0IEND"
                                       "\xae\x42\x60\x82";
    static const char text[] = "this is no image at all, but some text\n";
    const char *path = file_path("x.png");
    ibl_ctx *ctx = file_ctx(1, &kept, NULL);

    NEED(file_save(path, png, sizeof png - 1));
    refused(ctx, path, IBL_ERR_UNSUPPORTED,
            "is PNG, which needs the image bridge");
    CHECK_MSG(strstr(kept.text[0], "libopenimageio-dev"), "%s", kept.text[0]);
    refused(file_ctx(1, &kept, path), path, IBL_ERR_UNSUPPORTED,
            "cannot be loaded");
    NEED(file_save(file_path("x.txt"), text, sizeof text - 1));
    refused(ctx, file_path("x.txt"), IBL_ERR_FORMAT, "is no image: neither");
    if (!file_run("echo 'int oiio(void) { return 1; }' >o.c && echo 'int "
                  "oiio(void); int x(void) { return oiio(); }' >b.c && cc "
                  "-shared -fPIC -Wl,-soname,libOpenImageIO.so.2.4 -o "
                  "libOpenImageIO.so.2.4 o.c && cc -shared -fPIC -o gone.so "
                  "b.c ./libOpenImageIO.so.2.4 && cc -shared -fPIC -o other.so "
                  "o.c && rm libOpenImageIO.so.2.4"))
        test_skip("no compiler called cc");
    /* The real library, where it is installed, would stand in for ours. */
    const bool real =
        access("/usr/lib/x86_64-linux-gnu/libOpenImageIO.so.2.4", F_OK) == 0;
    refused(file_ctx(1, &kept, file_path("gone.so")), path, IBL_ERR_UNSUPPORTED,
            real ? "image bridge" : "libopenimageio2.4");
    refused(file_ctx(1, &kept, file_path("other.so")), path,
            IBL_ERR_UNSUPPORTED, "is not the image");
}

/* Floats come back as they were, right side up. */
TEST(float_formats)
{
    file_need_oiio();
    static const char *const names[] = {"f.pfm", "f.tif", "f_tiled.tif",
                                        "f_big.tif", "f_wrong.png"};
    ibl_ctx *ctx = file_ctx(2, &kept, file_bridge());
    test_random r = {3};
    ibl_image img, back;
    ibl_read_report report;

    NEED(!ibl_image_alloc(ctx, 66, 33, &img));
    for (int i = 0; i < 3 * 66 * 33; i++)
        img.data[i] = (float)exp(20 * test_random_unit(&r) - 10);
    NEED(file_save_pfm(file_path("f.pfm"), &img));
    NEED(file_run("oiiotool f.pfm -d float -o f.tif --tile 16 16 -o "
                  "f_tiled.tif --scanline f.pfm --ch R,G,B,A=0.5 -o f_big.tif "
                  "&& cp f.tif f_wrong.png"));
    for (int i = 0; i < 5; i++) {
        CHECK_MSG(!read_file(ctx, file_path(names[i]), &back, &report),
                  "%s: %s", names[i], kept.text[0]);
        NEED(back.data);
        CHECK(report.bridged && !report.low_range);
        CHECK_MSG(strstr(report.format, "float by OpenImageIO"), "%s",
                  report.format);
        CHECK_MSG(back.width == 66 && back.height == 33 &&
                      !memcmp(back.data, img.data, sizeof(float) * 3 * 66 * 33),
                  "%s: not what was saved", names[i]);
        ibl_image_free(&back);
    }
    ibl_image_free(&img);
}

/* The definition, in double: IEC 61966-2-1. */
static double to_linear(double v)
{
    return v <= 0.04045 ? v / 12.92 : pow((v + 0.055) / 1.055, 2.4);
}

/* A 16x16 ramp with every 8-bit value, as PPM; and as other formats. */
TEST(integer_formats)
{
    file_need_oiio();
    static const struct {
        const char *name;
        int grey;
        double tolerance;
    } cases[] = {{"r.ppm", 0, 1e-6},     {"r.png", 0, 1e-6},
                 {"r16.png", 0, 1e-6},   {"r.tif", 0, 1e-6},
                 {"r.bmp", 0, 1e-6},     {"r.tga", 0, 1e-6},
                 {"alpha.png", 0, 1e-6}, {"alpha16.tif", 0, 1e-6},
                 {"grey.png", 1, 1e-6},  {"greyalpha.png", 1, 1e-6},
                 {"r.gif", 0, 0.02},     {"r.sgi", 0, 1e-6},
                 {"r.dpx", 0, 1e-6},     {"r.webp", 0, 0.2},
                 {"r.jpg", 0, 0.2}};
    ibl_ctx *ctx = file_ctx(2, &kept, file_bridge());
    unsigned char ppm[16 + 768];
    int n = sprintf((char *)ppm, "P6\n16 16\n255\n");
    for (int i = 0; i < 256; i++) {
        ppm[n + 3 * i] = (unsigned char)i;
        ppm[n + 3 * i + 1] = (unsigned char)(i / 2 + 64);
        ppm[n + 3 * i + 2] = (unsigned char)(255 - i);
    }
    NEED(file_save(file_path("r.ppm"), ppm, (size_t)n + 768));
    NEED(file_run(
        "oiiotool r.ppm -o r.png -o r.tif -o r.bmp -o r.tga -o r.gif -o r.sgi "
        "-d uint16 -o r16.png -d uint8 -o r.dpx r.ppm --attrib "
        "oiio:UnassociatedAlpha 1 --ch R,G,B,A=0.2 -o alpha.png -d uint16 -o "
        "alpha16.tif -d uint8 r.ppm --ch R --chnames Y -o grey.png r.ppm "
        "--attrib oiio:UnassociatedAlpha 1 --ch Y=R,A=0.5 -o greyalpha.png "
        "r.ppm --compression jpeg:98 -o r.jpg --compression webp:100 -o "
        "r.webp"));
    for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++) {
        ibl_image img;
        ibl_read_report report;
        double worst = 0;
        CHECK_MSG(!read_file(ctx, file_path(cases[k].name), &img, &report),
                  "%s: %s", cases[k].name, kept.text[0]);
        if (!img.data)
            continue;
        CHECK_MSG(report.low_range && report.bridged, "%s", cases[k].name);
        CHECK_MSG(strstr(kept.text[IBL_LOG_WARNING], "low dynamic range"), "%s",
                  kept.text[IBL_LOG_WARNING]);
        for (int i = 0; i < 256; i++)
            for (int c = 0; c < 3; c++)
                worst = fmax(
                    worst,
                    fabs((double)img.data[3 * i + c] -
                         to_linear(ppm[n + 3 * i + (cases[k].grey ? 0 : c)] /
                                   255.0)));
        CHECK_MSG(worst <= cases[k].tolerance, "%s: off by %g", cases[k].name,
                  worst);
        ibl_image_free(&img);
    }
}

/* Messages name a file's format by its whole signature, per its standard. */
TEST(kinds)
{
    static const struct {
        const char *kind, *begin;
        size_t size;
    } cases[] = {
        {"PNG", "\x89PNG\r\n\x1a\n", 8},
        {"JPEG", "\xff\xd8\xff", 3},
        {"TIFF", "II\x2a\0", 4},
        {"BigTIFF", "II\x2b\0", 4},
        {"PFM", "PF\n", 3},
        {"PNM", "P6\n", 3},
        {"Photoshop", "8BPS", 4},
        {"GIF", "GIF89a", 6},
        {"WebP", "RIFF\x1a\0\0\0WEBP", 12},
        {"JPEG 2000", "\0\0\0\x0cjP  \r\n\x87\n", 12},
        {"HEIF", "\0\0\0\030ftypheic", 12},
        {"AVIF", "\0\0\0\034ftypavif", 12},
        {"DPX", "SDPX", 4},
        {"SGI", "\x01\xda", 2},
        {"Softimage", "\x53\x80\xf6\x34", 4},
        {"BMP", "BM", 2},
    };
    ibl_ctx *ctx = file_ctx(1, &kept, NULL);

    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        unsigned char bytes[80] = {0};
        ibl_image img;
        for (size_t k = 0; k < 2; k++) {
            memcpy(bytes, cases[i].begin, cases[i].size);
            memset(&kept, 0, sizeof kept);
            CHECK(ibl_image_decode(ctx, "file", bytes,
                                   k ? cases[i].size - 1 : sizeof bytes, NULL,
                                   &img, NULL) != IBL_OK);
            CHECK_MSG((strstr(kept.text[0], cases[i].kind) == NULL) == k,
                      "%zu of %s: %s", k, cases[i].kind, kept.text[0]);
        }
    }
}

TEST(not_images)
{
    static const struct {
        const char *bytes;
        size_t size;
        const char *said;
    } cases[] = {
        {"once upon a time there was a text file\n", 39, "is no image"},
        {"\7\33\1\5\2\200\377\40\1\2\3", 11, "is no image"},
        {"\x89PNG\r\n\x1a\n", 8, "PNG"},
        {"II*\0\x08\0\0\0", 8, "TIFF"}};
    file_need_oiio();
    ibl_ctx *ctx = file_ctx(1, &kept, file_bridge());

    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        NEED(file_save(file_path("b.png"), cases[i].bytes, cases[i].size));
        refused(ctx, file_path("b.png"), IBL_ERR_FORMAT, cases[i].said);
    }
}

/* Cut short, and headers that claim much more than the file has. */
TEST(damaged_through_bridge)
{
    static const char *const names[] = {"n.png", "n.tif"};
    static const char *const pfms[] = {"PF\n64 32\n-1.0\n1234567890",
                                       "PF\n60000 30000\n-1.0\n1234567890",
                                       "PF\n600000 300000\n-1.0\n1234567890"};
    file_need_oiio();
    ibl_ctx *ctx = file_ctx(1, &kept, file_bridge());
    const char *path = file_path("damaged");

    NEED(file_run("oiiotool --pattern noise:seed=9 64x32 3 -d float "
                  "-o n.tif -d uint8 -o n.png"));
    for (int k = 0; k < 2; k++) {
        size_t size;
        unsigned char *bytes = file_load(file_path(names[k]), &size);
        for (size_t part = 1; part < 8; part++) {
            NEED(file_save(path, bytes, size * part / 8));
            refused(ctx, path, IBL_ERR_FORMAT, "");
        }
        bytes[18] = 200; /* a PNG's width, with a wrong check sum */
        NEED(file_save(path, bytes, size));
        if (!k)
            refused(ctx, path, IBL_ERR_FORMAT, "");
    }
    for (int i = 0; i < 3; i++) {
        NEED(file_save(path, pfms[i], strlen(pfms[i])));
        refused(ctx, path, IBL_ERR_FORMAT, "");
    }
}
