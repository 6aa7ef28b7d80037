/* SPDX-License-Identifier: MIT */
/*
 * Images that OpenImageIO reads: which kind a file is, and what has to be done
 * before it gets the bytes. Version 2.4 reads the missing rest of a TIFF, JPEG
 * or IFF as black without an error, and libpng prints to stderr.
 */
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <zlib.h>

#include "core/alloc.h"
#include "core/context.h"
#include "io/bridge.h"
#include "io/container.h"

/* `size` bytes at `offset` in a file identify its kind. */
static const struct {
    unsigned char offset, size;
    char bytes[14];
    ibl_image_kind kind;
} signatures[] = {
    {0, 8, "\x89PNG\r\n\x1a\n", {"PNG", "png"}},
    {0, 3, "\xff\xd8\xff", {"JPEG", "jpeg"}},
    {0, 4, "II*\0", {"TIFF", "tiff"}},
    {0, 4, "MM\0*", {"TIFF", "tiff"}},
    {0, 4, "II+\0", {"BigTIFF", "tiff"}},
    {0, 4, "MM\0+", {"BigTIFF", "tiff"}},
    {0, 4, "8BPS", {"Photoshop", "psd"}},
    {0, 6, "GIF87a", {"GIF", "gif"}},
    {0, 6, "GIF89a", {"GIF", "gif"}},
    {8, 4, "WEBP", {"WebP", "webp"}},
    {0, 4, "DDS ", {"DDS", "dds"}},
    {0, 12, "\0\0\0\x0cjP  \r\n\x87\n", {"JPEG 2000", "jpeg2000"}},
    {0, 4, "\xff\x4f\xff\x51", {"JPEG 2000", "jpeg2000"}},
    {4, 8, "ftypheic", {"HEIF", "heif"}},
    {4, 8, "ftypheix", {"HEIF", "heif"}},
    {4, 8, "ftypmif1", {"HEIF", "heif"}},
    {4, 8, "ftypavif", {"AVIF", "heif"}},
    {4, 8, "ftypavis", {"AVIF", "heif"}},
    {0, 12, "\0\0\0\x0cJXL \r\n\x87\n", {"JPEG XL", "jpegxl"}},
    {0, 2, "\xff\x0a", {"JPEG XL", "jpegxl"}},
    {0, 4, "SDPX", {"DPX", "dpx"}},
    {0, 4, "XPDS", {"DPX", "dpx"}},
    {0, 4, "\x80\x2a\x5f\xd7", {"Cineon", "cineon"}},
    {0, 9, "SIMPLE  =", {"FITS", "fits"}},
    {0, 2, "\x01\xda", {"SGI", "sgi"}},
    {0, 4, "\x53\x80\xf6\x34", {"Softimage", "softimage"}},
    {0, 4, "FOR4", {"Maya IFF", "iff"}},
    {0, 2, "BM", {"BMP", "bmp"}},
};

static const ibl_image_kind *kind_of(const unsigned char *b, size_t size)
{
    static const ibl_image_kind pnm = {"PNM", "pnm"}, pfm = {"PFM", "pnm"},
                                targa = {"Targa", "targa"};

    for (size_t i = 0; i < sizeof signatures / sizeof signatures[0]; i++)
        if (size >= (size_t)signatures[i].offset + signatures[i].size &&
            !memcmp(b + signatures[i].offset, signatures[i].bytes,
                    signatures[i].size))
            return &signatures[i].kind;
    if (size > 2 && b[0] == 'P' && b[1] && strchr("123456Ff", b[1]) && b[2] &&
        strchr(" \t\r\n#", b[2]))
        return b[1] >= 'F' ? &pfm : &pnm;
    /* no signature, but few types of colour map, pixels and bits */
    return size > 18 && b[1] <= 1 && (b[2] & ~8) >= 1 && (b[2] & ~8) <= 3 &&
                   b[16] && b[16] <= 32 && (b[16] + 1) % 8 <= 1
               ? &targa
               : NULL;
}

/* ---- whole files --------------------------------------------------------- */

typedef struct file {
    const unsigned char *bytes;
    size_t size;
    bool little_endian;
    bool cut; /* something lies past the end */
} file;

/* An integer of 0 to 8 bytes. */
static uint64_t get(file *f, uint64_t at, int count)
{
    uint64_t n = 0;

    if (at > f->size || f->size - at < (size_t)count) {
        f->cut = true;
        return 0;
    }
    for (int i = 0; i < count; i++)
        n = n << 8 |
            f->bytes[at + (uint64_t)(f->little_endian ? count - 1 - i : i)];
    return n;
}

/* ITU T.81, annex B: passes over segments to the end of the image. */
static void look_through_jpeg(file *f)
{
    for (uint64_t at = 2; !f->cut;) {
        const uint64_t marker = get(f, at, 2);
        if (marker == 0xffd9)
            return;
        if (marker >> 8 != 0xff || marker == 0xffff)
            at++; /* entropy-coded data, stuffing or fill bytes */
        else if (marker <= 0xff01 || (marker >= 0xffd0 && marker <= 0xffd8))
            at += 2; /* stuffed zero, TEM, RSTn, SOI: no length */
        else
            at += 2 + get(f, at + 2, 2);
    }
}

/* TIFF 6.0, and BigTIFF: the strips or tiles of the first directory. */
static void look_through_tiff(file *f)
{
    struct {
        uint64_t count, at;
        int size;       /* of a number */
    } lists[2] = {{0}}; /* offsets, bytes */

    f->little_endian = f->bytes[0] == 'I';
    const bool big = get(f, 2, 2) == 43;
    const int word = big ? 8 : 4, counter = big ? 8 : 2;
    const uint64_t directory = get(f, big ? 8 : 4, word);
    const uint64_t entries = get(f, directory, counter);
    uint64_t at = directory + (uint64_t)counter;
    for (uint64_t i = 0; i < entries && !f->cut; i++, at += big ? 20 : 12) {
        const uint64_t tag = get(f, at, 2), type = get(f, at + 2, 2);
        const int size = type == 3 ? 2 : type == 4 ? 4 : type == 16 ? 8 : 0;
        const uint64_t count = size ? get(f, at + 4, word) : 0;
        const uint64_t here = at + 4 + (uint64_t)word;
        const bool fits = count <= (uint64_t)(word / (size ? size : 1));
        const int list = tag == 279 || tag == 325;
        if (!list && tag != 273 && tag != 324)
            continue;
        lists[list].count = count;
        lists[list].size = size;
        lists[list].at = fits ? here : get(f, here, word);
    }
    for (uint64_t i = 0; i < lists[0].count && !f->cut; i++) {
        const uint64_t from =
            get(f, lists[0].at + i * (uint64_t)lists[0].size, lists[0].size);
        const uint64_t bytes =
            i < lists[1].count
                ? get(f, lists[1].at + i * (uint64_t)lists[1].size,
                      lists[1].size)
                : 0;
        f->cut |= from > f->size || bytes > f->size - from;
    }
}

/* ---- copies without what OpenImageIO does not understand ---------------- */

/* The chunks that libpng needs for the picture, so that it prints no warnings,
 * and gAMA, which counts without sRGB or iCCP before it. */
static size_t copy_png(file *f, unsigned char *dst)
{
    static const char kept[][5] = {"IHDR", "PLTE", "tRNS",
                                   "IDAT", "IEND", "gAMA"};
    bool has_curve = false;
    size_t done = 8;

    memcpy(dst, f->bytes, done);
    for (uint64_t at = done;;) {
        const uint64_t whole = get(f, at, 4) + 12;
        const unsigned char *type = f->bytes + at + 4;
        const uint64_t crc = get(f, at + whole - 4, 4);
        if (f->cut || crc != crc32(0, type, (uInt)whole - 8)) {
            f->cut = true;
            break;
        }
        for (int i = 0; i < 6; i++)
            if (!memcmp(type, kept[i], 4) &&
                (i < 5 || (!has_curve && whole == 16))) {
                memcpy(dst + done, f->bytes + at, (size_t)whole);
                done += (size_t)whole;
            }
        if (!memcmp(type, "IEND", 4))
            break;
        has_curve |= !memcmp(type, "sRGB", 4) || !memcmp(type, "iCCP", 4) ||
                     !memcmp(type, "gAMA", 4);
        at += whole;
    }
    return done;
}

/* A PNM or PFM without the CR of a CRLF before the pixels. */
static size_t copy_pnm(const file *f, unsigned char *dst)
{
    char text[132] = "", kind, most[16];
    int width, height, end = 0;

    memcpy(dst, f->bytes, f->size);
    memcpy(text, f->bytes, f->size < 128 ? f->size : 128);
    if (sscanf(text, "P%c %9d %9d %15s%n", &kind, &width, &height, most, &end) <
            4 ||
        memcmp(text + end, "\r\n", 2) != 0)
        return f->size;
    const double bytes_each =
        kind == 'F'   ? 12
        : kind == 'f' ? 4
                      : (kind == '6' ? 3 : 1) * (atoi(most) > 255 ? 2 : 1);
    if (end + 2 + bytes_each * width * height != (double)f->size)
        return f->size;
    memcpy(dst + end, f->bytes + end + 1, f->size - (size_t)end - 1);
    return f->size - 1;
}

/* ---- opening ------------------------------------------------------------- */

/* The curve of a HEIF or AVIF file, by a box "colr" in its first bytes
 * (transfer characteristics of ITU-T H.273), if OpenImageIO would take its
 * values for sRGB's and be wrong. NULL: it is none. */
static const char *other_curve(const ibl_input *in)
{
    const size_t size = in->size < 1 << 16 ? in->size : 1 << 16;

    for (size_t at = 0; at + 12 <= size; at++) {
        if (memcmp(in->bytes + at, "colrnclx", 8) != 0)
            continue;
        const int transfer = in->bytes[at + 10] << 8 | in->bytes[at + 11];
        if (transfer == 8 || transfer == 16 || transfer == 18)
            return transfer == 8 ? "linear" : transfer == 16 ? "PQ" : "HLG";
    }
    return NULL;
}

/* Names what downloads often are in place of the file. */
static ibl_status refuse_unknown(const ibl_input *in)
{
    char first[256] = "";
    const char *text = first;

    memcpy(first, in->bytes,
           in->size < sizeof first ? in->size : sizeof first - 1);
    text += !strncmp(text, "\xef\xbb\xbf", 3) ? 3 : 0;
    text += strspn(text, " \t\r\n");
    if (!strncmp(text, "version https://git-lfs", 23))
        return ibl_bad_file(in, "is a pointer of Git LFS, not the file itself: "
                                "fetch it with git lfs pull");
    if (*text == '<')
        return ibl_bad_file(in, "is a web page (HTML or XML), not an image: "
                                "download the file itself");
    return ibl_bad_file(in, "is no image: neither Radiance .hdr nor OpenEXR "
                            "nor anything that OpenImageIO knows");
}

ibl_status ibl_other_image_open(ibl_input *in, const ibl_read_options *opts,
                                ibl_rows **rows)
{
    const ibl_status loaded = ibl_input_load(in);
    if (loaded)
        return loaded;
    const ibl_image_kind *kind = kind_of(in->bytes, in->size);
    if (!kind)
        return refuse_unknown(in);
    file f = {.bytes = in->bytes, .size = in->size};
    const char *reader = kind->reader;
    const char *curve = strcmp(reader, "heif") ? NULL : other_curve(in);
    if (curve)
        return ibl_unsupported(in,
                               "is %s with the curve %s, which the image "
                               "bridge does not decode: convert it to EXR",
                               kind->name, curve);
    unsigned char *copy = NULL;
    ibl_input cleaned = *in;
    if (!strcmp(reader, "png") || !strcmp(reader, "pnm") ||
        !strcmp(reader, "dds")) {
        copy = ibl_alloc_array(in->size, 1);
        if (!copy)
            return ibl_no_memory(in->ctx, "an image");
        cleaned.bytes = copy;
        cleaned.size = *reader == 'd' ? ibl_dds_picture(f.bytes, f.size, copy)
                       : reader[1] == 'n' && reader[2] == 'g'
                           ? copy_png(&f, copy)
                           : copy_pnm(&f, copy);
    } else if (!strcmp(reader, "jpeg")) {
        look_through_jpeg(&f);
    } else if (!strcmp(reader, "tiff")) {
        look_through_tiff(&f);
    } else if (!strcmp(reader, "iff")) {
        get(&f, 8 + get(&f, 4, 4), 0);
    }
    const ibl_status status =
        f.cut ? ibl_bad_file(in,
                             "damaged %s: it is cut short, or a check sum is "
                             "wrong: copy it again",
                             kind->name)
              : ibl_bridge_rows(&cleaned, kind, opts, rows);
    ibl_free(copy);
    return status;
}
