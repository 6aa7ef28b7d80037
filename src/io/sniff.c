/* SPDX-License-Identifier: MIT */
#include "io/sniff.h"

#include <string.h>

/* size bytes at offset of the file. */
typedef struct signature {
    unsigned char offset, size;
    char bytes[14];
    const char *kind, *reader;
} signature;

static const signature signatures[] = {
    {0, 8, "\x89PNG\r\n\x1a\n", "PNG", "png"},
    {0, 3, "\xff\xd8\xff", "JPEG", "jpeg"},
    {0, 4, "II*\0", "TIFF", "tiff"},
    {0, 4, "MM\0*", "TIFF", "tiff"},
    {0, 4, "II+\0", "BigTIFF", "tiff"},
    {0, 4, "MM\0+", "BigTIFF", "tiff"},
    {0, 3, "PF\n", "PFM", "pnm"},
    {0, 3, "Pf\n", "PFM", "pnm"},
    {0, 3, "PF\r", "PFM", "pnm"},
    {0, 3, "PF ", "PFM", "pnm"},
    {0, 3, "Pf ", "PFM", "pnm"},
    {0, 4, "8BPS", "Photoshop", "psd"},
    {0, 6, "GIF87a", "GIF", "gif"},
    {0, 6, "GIF89a", "GIF", "gif"},
    {8, 4, "WEBP", "WebP", "webp"},
    {0, 4, "DDS ", "DDS", "dds"},
    {0, 12, "\0\0\0\x0cjP  \r\n\x87\n", "JPEG 2000", "jpeg2000"},
    {0, 4, "\xff\x4f\xff\x51", "JPEG 2000", "jpeg2000"},
    {4, 8, "ftypheic", "HEIF", "heif"},
    {4, 8, "ftypheix", "HEIF", "heif"},
    {4, 8, "ftypmif1", "HEIF", "heif"},
    {4, 8, "ftypavif", "AVIF", "heif"},
    {0, 4, "SDPX", "DPX", "dpx"},
    {0, 4, "XPDS", "DPX", "dpx"},
    {0, 4, "\x80\x2a\x5f\xd7", "Cineon", "cineon"},
    {0, 9, "SIMPLE  =", "FITS", "fits"},
    {0, 2, "\x01\xda", "SGI", "sgi"},
    {0, 4, "\x53\x80\xf6\x34", "Softimage", "softimage"},
    {0, 4, "FOR4", "Maya IFF", "iff"},
    {0, 2, "BM", "BMP", "bmp"},
};

static int is_pnm(const unsigned char *b, size_t size)
{
    return size > 2 && b[0] == 'P' && b[1] >= '1' && b[1] <= '6' &&
           (b[2] == ' ' || b[2] == '\n' || b[2] == '\r' || b[2] == '\t' ||
            b[2] == '#');
}

void ibl_sniff(const unsigned char *bytes, size_t size, const char **kind,
               const char **reader)
{
    *kind = *reader = NULL;
    for (size_t i = 0; i < sizeof signatures / sizeof signatures[0]; i++) {
        const signature *s = &signatures[i];
        if (size < (size_t)s->offset + s->size ||
            memcmp(bytes + s->offset, s->bytes, s->size) != 0)
            continue;
        *kind = s->kind;
        *reader = s->reader;
        return;
    }
    if (is_pnm(bytes, size)) {
        *kind = "PNM";
        *reader = "pnm";
    }
}
