/* SPDX-License-Identifier: MIT */
/*
 * Ultra HDR JPEGs, put together here of two JPEGs of OpenImageIO, Android's
 * text or ISO 21496-1's bytes, and an index of pictures. The truth is the
 * formula of both over what OpenImageIO reads in the two.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "files.h"
#include "ibl/io.h"
#include "io/colour_space.h"
#include "io/rows.h"
#include "test.h"

static test_messages kept;

typedef struct meaning {
    double min[3], max[3], gamma[3], base_offset[3], offset[3];
} meaning;

static const meaning of_grey = {{0, 0, 0},
                                {3.5, 3.5, 3.5},
                                {1, 1, 1},
                                {.015625, .015625, .015625},
                                {.015625, .015625, .015625}};
static const meaning of_three = {{-1, 0, 0.5},
                                 {2, 3, 4},
                                 {1, 2, 0.5},
                                 {.015625, .03125, .0625},
                                 {.03125, .015625, 0}};

typedef struct file {
    unsigned char bytes[1 << 17];
    size_t size;
} file;

static void put(file *f, const void *bytes, size_t size)
{
    NEED(f->size + size <= sizeof f->bytes);
    memcpy(f->bytes + f->size, bytes, size);
    f->size += size;
}

static void put_number(file *f, uint32_t n, int count)
{
    for (int i = count - 1; i >= 0; i--)
        put(f, &(unsigned char){(unsigned char)(n >> 8 * i)}, 1);
}

/* APPn with a name that a 0 ends, and what follows it. */
static void put_segment(file *f, int marker, const char *name,
                        const void *bytes, size_t size)
{
    put_number(f, 0xff00 | (uint32_t)marker, 2);
    put_number(f, (uint32_t)(size + strlen(name) + 3), 2);
    put(f, name, strlen(name) + 1);
    put(f, bytes, size);
}

static const char xmp[] = "http://ns.adobe.com/xap/1.0/";
static const char iso[] = "urn:iso:std:iso:ts:21496:-1";

/* Attributes for one channel, lists for three, as Android's guide has both. */
static void put_android(file *f, const meaning *m, bool three)
{
    static const char *const names[] = {"GainMapMin", "GainMapMax", "Gamma",
                                        "OffsetSDR", "OffsetHDR"};
    const double *values[] = {m->min, m->max, m->gamma, m->base_offset,
                              m->offset};
    const char *text = test_text(
        "<rdf:Description hdrgm:Version=\"1.0\" hdrgm:HDRCapacityMax=\"3.5\" "
        "hdrgm:BaseRenditionIsHDR=\"False\" ");

    if (!three)
        text = test_text("%shdrgm:GainMapMax=\"%.9g\"/>", text, m->max[0]);
    for (int i = 0; i < 5 && three; i++)
        text = test_text("%s%s<hdrgm:%s><rdf:Seq>\n<rdf:li>%.9g</rdf:li>"
                         "<rdf:li>%.9g</rdf:li><rdf:li>%.9g</rdf:li></rdf:Seq>"
                         "</hdrgm:%s>",
                         text, i ? "" : ">", names[i], values[i][0],
                         values[i][1], values[i][2], names[i]);
    put_segment(f, 0xe1, xmp, text, strlen(text));
}

/* Of a metadata's fractions one denominator, or each its own. */
static void put_fractions(file *f, const double *all, int count, bool one)
{
    for (int i = 0; i < count; i++) {
        put_number(f, (uint32_t)(int32_t)lrint(all[i] * 1024), 4);
        if (!one)
            put_number(f, 1024, 4);
    }
}

static void put_iso(file *f, const meaning *m, bool three, bool one)
{
    file box = {.size = 0};

    put_number(&box, 0, 4);
    put_number(&box, (three ? 128 : 0) | 64 | (one ? 8 : 0), 1);
    if (one)
        put_number(&box, 1024, 4);
    put_fractions(&box, (double[]){0, m->max[0]}, 2, one);
    for (int c = 0; c < (three ? 3 : 1); c++)
        put_fractions(&box,
                      (double[]){m->min[c], m->max[c], m->gamma[c],
                                 m->base_offset[c], m->offset[c]},
                      5, one);
    put_segment(f, 0xe2, iso, box.bytes, box.size);
}

/* A big-endian index with one directory: the list of two pictures. */
static void put_index(file *f, size_t second, size_t size)
{
    file mpf = {.size = 0};
    const size_t header = f->size + 4 + 4;

    put(&mpf, "MM\0\x2a\0\0\0\x08\0\x01\xb0\x02\0\x07", 14);
    put_number(&mpf, 32, 4);
    put_number(&mpf, 26, 4);
    for (int i = 0; i < 6; i++) /* the first picture, and of the second */
        put_number(&mpf, 0, 4);
    put_number(&mpf, (uint32_t)size, 4);
    put_number(&mpf, (uint32_t)(second - header), 4);
    put_number(&mpf, 0, 4);
    put_segment(f, 0xe2, "MPF", mpf.bytes, mpf.size);
}

typedef struct parts {
    unsigned char *base, *gain;
    size_t base_size, gain_size;
    unsigned char *base_ppm, *gain_ppm; /* what is in them: 8 bits, RGB */
} parts;

/* 32x16 of gradients, and a gain map of 16x8. */
static parts make_parts(bool three)
{
    size_t size;
    parts p = {0};
    file_need_oiio();
    NEED(file_run(
        "oiiotool --create 32x16 3 --fill:topleft=.1,.2,.9:topright=.9,.3,.5:"
        "bottomleft=0,.6,.2:bottomright=1,1,.1 32x16 --attrib jpeg:subsampling "
        "4:4:4 -d uint8 --compression jpeg:99 -o base.jpg --create 16x8 3 "
        "--fill:topleft=0,.2,.9:topright=1,.3,.5:bottomleft=.3,.6,.2:"
        "bottomright=.6,1,.1 16x8 %s --attrib jpeg:subsampling 4:4:4 -o "
        "gain.jpg base.jpg -o base.ppm gain.jpg %s -o gain.ppm",
        three ? "" : "--ch R", three ? "" : "--ch 0,0,0"));
    p.base = file_load(file_path("base.jpg"), &p.base_size);
    p.gain = file_load(file_path("gain.jpg"), &p.gain_size);
    p.base_ppm = file_load(file_path("base.ppm"), &size);
    p.base_ppm += size - 3 * 32 * 16;
    p.gain_ppm = file_load(file_path("gain.ppm"), &size);
    p.gain_ppm += size - 3 * 16 * 8;
    return p;
}

typedef enum form {
    ANDROID,
    ISO,
    ISO_ONE /* denominator */
} form;

/* more: bytes that the index claims beyond the gain map. */
static file build(const parts *p, const meaning *m, bool three, form as,
                  size_t more)
{
    static const char version[] = "<x hdrgm:Version=\"1.0\"/>";
    file gain = {.size = 0}, f = {.size = 0};

    put(&gain, p->gain, 2);
    if (as)
        put_iso(&gain, m, three, as == ISO_ONE);
    else
        put_android(&gain, m, three);
    put(&gain, p->gain + 2, p->gain_size - 2);
    put(&f, p->base, 2);
    if (as)
        put_segment(&f, 0xe2, iso, "\0\0\0\0", 4);
    else
        put_segment(&f, 0xe1, xmp, version, strlen(version));
    put_index(&f, f.size + 4 + 4 + 58 + p->base_size - 2, gain.size + more);
    put(&f, p->base + 2, p->base_size - 2);
    put(&f, gain.bytes, gain.size);
    return f;
}

static double to_linear(double v)
{
    return v <= 0.04045 ? v / 12.92 : pow((v + 0.055) / 1.055, 2.4);
}

static double gain_at(const parts *p, int x, int y, int c)
{
    const double u = (x + .5) / 2 - .5, v = (y + .5) / 2 - .5;
    double sum = 0;

    for (int j = (int)floor(v); j <= (int)floor(v) + 1; j++)
        for (int i = (int)floor(u); i <= (int)floor(u) + 1; i++) {
            const int row = j < 0 ? 0 : j > 7 ? 7 : j;
            sum += (1 - fabs(u - i)) * (1 - fabs(v - j)) *
                   p->gain_ppm[3 * (16 * row + (i + 16) % 16) + c] / 255;
        }
    return sum;
}

static void check_values(const parts *p, const meaning *m, const ibl_image *img)
{
    for (int i = 0; i < 32 * 16 * 3; i++) {
        const int c = i % 3;
        const double g =
            pow(gain_at(p, i / 3 % 32, i / 96, c), 1 / m->gamma[c]);
        const double sdr = to_linear(p->base_ppm[i] / 255.0);
        const double hdr = (sdr + m->base_offset[c]) *
                               exp2(m->min[c] + (m->max[c] - m->min[c]) * g) -
                           m->offset[c];
        CHECK_NEAR((double)img->data[i], fmax(hdr, 0), 1e-5 * (1 + hdr));
    }
}

static ibl_status decode(ibl_ctx *ctx, const file *f, ibl_image *img,
                         ibl_read_report *report)
{
    memset(&kept, 0, sizeof kept);
    *img = (ibl_image){0};
    const ibl_status status =
        ibl_image_decode(ctx, "u.jpg", f->bytes, f->size, NULL, img, report);
    test_image(*img);
    return status;
}

TEST_SLOW(metadata_of_one_and_three_channels)
{
    ibl_ctx *ctx = file_ctx(2, &kept, file_bridge());

    for (int three = 0; three < 2; three++) {
        const parts p = make_parts(three);
        const meaning *m = three ? &of_three : &of_grey;
        for (form f = ANDROID; f <= ISO_ONE; f++) {
            const file made = build(&p, m, three, f, 0);
            ibl_read_report report;
            ibl_image img;
            NEED(!decode(ctx, &made, &img, &report));
            CHECK(strstr(report.format, "Ultra HDR JPEG, gain map of ") &&
                  strstr(report.format, f ? "ISO 21496-1" : "Android"));
            CHECK(!report.low_range && !*kept.text[IBL_LOG_WARNING]);
            CHECK(report.peak > 2);
            check_values(&p, m, &img);
        }
    }
}

TEST(plain_jpeg_stays_plain)
{
    const parts p = make_parts(false);
    ibl_ctx *ctx = file_ctx(1, &kept, file_bridge());

    for (int i = 0; i < 2; i++) {
        file f = {.size = 0};
        ibl_read_report report;
        ibl_image img;
        put(&f, p.base, 2);
        if (i)
            put_segment(&f, 0xe1, xmp, "hdrgm:Version=\"1.0\"", 19);
        put(&f, p.base + 2, p.base_size - 2);
        NEED(!decode(ctx, &f, &img, &report));
        CHECK(report.low_range && strstr(report.format, "jpeg"));
    }
}

TEST(truncation_and_lies)
{
    static const struct {
        double max, gamma;
        form as;
        size_t more;
        ibl_status status;
        const char *said;
    } lies[] = {
        {3.5, 1, false, 1, IBL_ERR_FORMAT, "picture 2 lies behind the end"},
        {25, 1, ANDROID, 0, IBL_ERR_UNSUPPORTED, "its gains, gamma or offsets"},
        {3.5, 0, ISO, 0, IBL_ERR_UNSUPPORTED, "gamma"},
        {-1, 1, ISO, 0, IBL_ERR_UNSUPPORTED, ""}};
    const parts p = make_parts(false);
    ibl_ctx *ctx = file_ctx(1, &kept, file_bridge());
    ibl_image img;
    file f = build(&p, &of_grey, false, ISO, 0);
    const size_t size = f.size;

    for (size_t cut = 1; cut < size; cut += cut < p.gain_size ? 97 : 301) {
        f.size = size - cut;
        CHECK_MSG(decode(ctx, &f, &img, NULL) == IBL_ERR_FORMAT &&
                      !strchr(kept.text[IBL_LOG_ERROR], '\n'),
                  "%zu", cut);
    }
    for (int i = 0; i < 4; i++) {
        meaning m = of_grey;
        m.max[0] = m.max[1] = m.max[2] = lies[i].max; /* the headroom too */
        m.gamma[0] = lies[i].gamma;
        f = build(&p, &m, false, lies[i].as, lies[i].more);
        CHECK_MSG(decode(ctx, &f, &img, NULL) == lies[i].status &&
                      test_said(&kept, lies[i].said),
                  "%d: %s", i, kept.text[IBL_LOG_ERROR]);
    }
}

/* OpenImageIO would give their code values for sRGB's. */
TEST(curves_of_heif)
{
    static const struct {
        uint32_t transfer;
        const char *said;
    } cases[] = {{16, "is AVIF with the curve PQ,"},
                 {18, "is AVIF with the curve HLG,"},
                 {8, "is AVIF with the curve linear,"}};

    for (int i = 0; i < 3; i++) {
        file f = {.size = 0};
        ibl_image img;
        put(&f,
            "\0\0\0\x1c"
            "ftypavif\0\0\0\0colrnclx\0\x09",
            26);
        put_number(&f, cases[i].transfer, 2);
        CHECK(decode(file_ctx(1, &kept, file_bridge()), &f, &img, NULL) ==
              IBL_ERR_UNSUPPORTED);
        CHECK(test_said(&kept, cases[i].said));
    }
}

/* ---- profiles --------------------------------------------------------- */

/* Colorants as published, rows R, G, B of X, Y, Z: of the profiles of HP and
 * Microsoft (sRGB) and of Apple; and of none. */
TEST(profiles)
{
    static const char names[3][5] = {"rXYZ", "gXYZ", "bXYZ"};
    static const struct {
        const char *name;
        double xyz[9];
    } cases[] = {
        {"Rec.709",
         {.4360747, .2225045, .0139322, .3850649, .7168786, .0971045, .1430804,
          .0606169, .7141733}},
        {"Display P3",
         {.5151, .2412, -.0011, .2920, .6922, .0419, .1571, .0666, .7841}},
        {NULL, {.6, .3, 0, .2, .6, .1, .1, .1, .6}}};
    double xy[8];

    for (int k = 0; k < 3; k++) {
        file f = {.size = 128};
        memset(f.bytes, 0, 128);
        put_number(&f, 3, 4);
        for (uint32_t i = 0; i < 3; i++) {
            put(&f, names[i], 4);
            put_number(&f, 168 + 20 * i, 4);
            put_number(&f, 20, 4);
        }
        for (int i = 0; i < 9; i++) {
            if (i % 3 == 0)
                put(&f, "XYZ \0\0\0\0", 8);
            put_number(&f, (uint32_t)(int32_t)lrint(cases[k].xyz[i] * 65536),
                       4);
        }
        CHECK(ibl_icc_primaries(f.bytes, f.size, xy) == !!cases[k].name);
        CHECK(!cases[k].name ||
              !strcmp(ibl_colour_space_name(xy), cases[k].name));
        for (size_t size = 0; size < f.size; size += 5)
            CHECK(!ibl_icc_primaries(f.bytes, size, xy));
    }
}
