/* SPDX-License-Identifier: MIT */
#include "io/bridge.h"

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "io/input.h"

/* An integer of 1 to 8 bytes; the caller has checked the offset. */
static uint64_t get(const ibl_input *in, uint64_t offset, int count)
{
    uint64_t n = 0;
    for (int i = 0; i < count; i++)
        n = n << 8 |
            in->bytes[offset + (uint64_t)(in->swap ? i : count - 1 - i)];
    return n;
}

/* ---- PNG: W3C "Portable Network Graphics", 5.2 to 5.4 ---------------- */

static const uint64_t png_header = 8;

static uint32_t png_crc(const unsigned char *p, size_t n)
{
    uint32_t crc = 0xffffffffu;
    while (n--) {
        crc ^= *p++;
        for (int k = 0; k < 8; k++)
            crc = crc >> 1 ^ (crc & 1 ? 0xedb88320u : 0);
    }
    return ~crc;
}

static bool is_chunk(const ibl_input *in, uint64_t at, const char *type)
{
    return !memcmp(in->bytes + at + 4, type, 4);
}

/* Checks IHDR, the first chunk: size, depth and colour type. */
static const char *check_png_header(const ibl_input *in, uint64_t at,
                                    uint64_t length)
{
    static const unsigned char depths[7] = {0x1f, 0, 0x18, 0x0f, 0x18, 0, 0x18};
    if (!is_chunk(in, at, "IHDR") || length != 13)
        return "its first chunk is not IHDR";
    const uint64_t width = get(in, at + 8, 4), height = get(in, at + 12, 4);
    const unsigned depth = in->bytes[at + 16], colour = in->bytes[at + 17];
    if (!width || !height || width >> 31 || height >> 31)
        return "its width or height is 0 or absurd";
    if (colour > 6 || depth > 16 || !depth || depth & (depth - 1) ||
        !(depths[colour] * 1u & depth))
        return "its depth and colour type do not go together";
    return NULL;
}

static const char *check_png(const ibl_input *in)
{
    for (uint64_t at = png_header;;) {
        if (!ibl_input_has(in, at, 12))
            return "it is cut short";
        const uint64_t length = get(in, at, 4);
        if (!ibl_input_has(in, at, length + 12))
            return "it is cut short";
        if (png_crc(in->bytes + at + 4, (size_t)length + 4) !=
            get(in, at + 8 + length, 4))
            return "the check sum of a chunk is wrong";
        if (at == png_header) {
            const char *text = check_png_header(in, at, length);
            if (text)
                return text;
        }
        if (is_chunk(in, at, "IEND"))
            return NULL;
        at += length + 12;
    }
}

size_t ibl_png_picture(const unsigned char *bytes, size_t size,
                       unsigned char *dst)
{
    static const char kept[][5] = {"IHDR", "PLTE", "tRNS",
                                   "IDAT", "IEND", "gAMA"};
    bool has_curve = false; /* gAMA counts without sRGB or iCCP before it */
    ibl_input v = ibl_input_of(NULL, NULL, bytes, size);
    v.swap = true;
    size_t done = png_header;

    memcpy(dst, bytes, png_header);
    for (uint64_t at = png_header; ibl_input_has(&v, at, 12);) {
        const uint64_t whole = get(&v, at, 4) + 12;
        for (size_t i = 0; i < sizeof kept / sizeof kept[0]; i++) {
            if (!is_chunk(&v, at, kept[i]) ||
                (i == 5 && (has_curve || whole != 16)))
                continue;
            memcpy(dst + done, bytes + at, (size_t)whole);
            done += (size_t)whole;
        }
        has_curve |= is_chunk(&v, at, "sRGB") || is_chunk(&v, at, "iCCP") ||
                     is_chunk(&v, at, "gAMA");
        if (is_chunk(&v, at, "IEND"))
            break;
        at += whole;
    }
    return done;
}

size_t ibl_pnm_picture(const unsigned char *bytes, size_t size,
                       unsigned char *dst)
{
    char text[132] = "", kind, most[16];
    int width, height, end = 0;

    memcpy(dst, bytes, size);
    memcpy(text, bytes, size < 128 ? size : 128);
    if (sscanf(text, "P%c %9d %9d %15s%n", &kind, &width, &height, most, &end) <
            4 ||
        memcmp(text + end, "\r\n", 2) != 0)
        return size;
    const double bytes_each =
        kind == 'F'   ? 12
        : kind == 'f' ? 4
                      : (kind == '6' ? 3 : 1) * (atoi(most) > 255 ? 2 : 1);
    if (end + 2 + bytes_each * width * height != (double)size)
        return size;
    memcpy(dst + end, bytes + end + 1, size - (size_t)end - 1);
    return size - 1;
}

/* ---- JPEG: ITU T.81, annex B ----------------------------------------- */

static const char *check_jpeg(const ibl_input *in)
{
    uint64_t at = 2; /* after SOI */
    while (ibl_input_has(in, at, 2)) {
        const unsigned marker = in->bytes[at + 1];
        if (in->bytes[at] != 0xff) {
            at++; /* entropy-coded data, or stuffing */
        } else if (marker == 0xd9) {
            return NULL;
        } else if (marker == 0xff) {
            at++; /* fill bytes */
        } else if (marker <= 0x01 || (marker >= 0xd0 && marker <= 0xd8)) {
            at += 2; /* stuffed zero, TEM, RSTn, SOI: no length */
        } else if (!ibl_input_has(in, at, 4)) {
            break;
        } else {
            at += 2 + get(in, at + 2, 2);
        }
    }
    return "it is cut short";
}

/* ---- TIFF 6.0, and BigTIFF ------------------------------------------- */

enum {
    TIFF_STRIP_OFFSETS = 273,
    TIFF_STRIP_BYTES = 279,
    TIFF_TILE_OFFSETS = 324,
    TIFF_TILE_BYTES = 325
};

typedef struct tiff_array {
    uint64_t count, at;
    int size; /* bytes of an item; 0: the tag is missing */
} tiff_array;

static int tiff_type_size(unsigned type)
{
    return type == 3 ? 2 : type == 4 ? 4 : type == 16 ? 8 : 0;
}

/* Checks that the strips and tiles of a directory lie within the file. */
static const char *check_tiff_data(const ibl_input *in,
                                   const tiff_array *offsets,
                                   const tiff_array *bytes)
{
    if (!offsets->size || !bytes->size)
        return NULL; /* the reader reports this */
    if (offsets->count != bytes->count ||
        !ibl_input_has(in, offsets->at,
                       offsets->count * (uint64_t)offsets->size) ||
        !ibl_input_has(in, bytes->at, bytes->count * (uint64_t)bytes->size))
        return "its list of strips or tiles is damaged or cut short";
    for (uint64_t i = 0; i < offsets->count; i++) {
        const uint64_t at =
            get(in, offsets->at + i * (uint64_t)offsets->size, offsets->size);
        const uint64_t n =
            get(in, bytes->at + i * (uint64_t)bytes->size, bytes->size);
        if (!ibl_input_has(in, at, n))
            return "it is cut short: a strip or tile ends past the end of the "
                   "file";
    }
    return NULL;
}

static const char *check_tiff(ibl_input *in)
{
    tiff_array offsets = {0}, bytes = {0};
    in->swap = in->bytes[0] == 'M';
    const bool big = get(in, 2, 2) == 43;
    const int word = big ? 8 : 4, entry = big ? 20 : 12, counter = big ? 8 : 2;

    if (!ibl_input_has(in, 0, big ? 16 : 8))
        return "it is cut short";
    const uint64_t directory = get(in, big ? 8 : 4, word);
    if (!ibl_input_has(in, directory, (uint64_t)counter))
        return "it is cut short: its directory lies past the end of the file";
    const uint64_t entries = get(in, directory, counter);
    uint64_t at = directory + (uint64_t)counter;
    if (entries > in->size || !ibl_input_has(in, at, entries * (uint64_t)entry))
        return "its directory is damaged or cut short";
    for (uint64_t i = 0; i < entries; i++, at += (uint64_t)entry) {
        const uint64_t tag = get(in, at, 2);
        tiff_array a = {.size = tiff_type_size((unsigned)get(in, at + 2, 2)),
                        .count = get(in, at + 4, word),
                        .at = at + 4 + (uint64_t)word};
        if (a.count > in->size)
            a.size = 0;
        else if (a.count * (uint64_t)a.size > (uint64_t)word)
            a.at = get(in, a.at, word);
        if (tag == TIFF_STRIP_OFFSETS || tag == TIFF_TILE_OFFSETS)
            offsets = a;
        if (tag == TIFF_STRIP_BYTES || tag == TIFF_TILE_BYTES)
            bytes = a;
    }
    return check_tiff_data(in, &offsets, &bytes);
}

/* ---- Maya IFF -------------------------------------------------------- */

static const char *check_iff(const ibl_input *in)
{
    return !ibl_input_has(in, 0, 8) || !ibl_input_has(in, 8, get(in, 4, 4))
               ? "it is cut short"
               : NULL;
}

const char *ibl_truncation_check(const char *reader, const unsigned char *bytes,
                                 size_t size)
{
    ibl_input v = ibl_input_of(NULL, NULL, bytes, size);
    v.swap = true; /* except TIFF, which states its order */
    if (!reader || size < 4)
        return NULL;
    if (!strcmp(reader, "png"))
        return check_png(&v);
    if (!strcmp(reader, "jpeg"))
        return check_jpeg(&v);
    if (!strcmp(reader, "tiff"))
        return check_tiff(&v);
    if (!strcmp(reader, "iff"))
        return check_iff(&v);
    return NULL;
}
