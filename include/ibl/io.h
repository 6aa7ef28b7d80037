/* SPDX-License-Identifier: MIT */
/*
 * iblbake: reading images, reading and writing textures.
 *
 * Conventions, status codes and thread rules: <ibl/ibl.h>. Programs that use
 * ibl_image_read, ibl_image_decode or ibl_source_open also link OpenEXRCore
 * and, if the library was built with it, libdeflate. Programs that use textures
 * link libzstd. Everything else here needs only the C library.
 */
#ifndef IBL_IO_H
#define IBL_IO_H

#include <stddef.h>
#include <stdint.h>

#include "ibl.h"

#ifdef __cplusplus
extern "C" {
#endif
IBL_API_BEGIN

/* ---- images in ------------------------------------------------------ */

/*
 * Handling of an alpha channel. Alpha is the covered share of a pixel, 0..1.
 * Filters process alpha and the colours multiplied by alpha; their quotient is
 * the colour of the covered part.
 */
typedef enum ibl_alpha {
    IBL_ALPHA_IGNORE,  /* dropped: colours stay as in the file */
    IBL_ALPHA_FILE,    /* kept. Colours are multiplied by it, unless the format
                          defines them as multiplied already: OpenEXR always,
                          TIFF and others if the file says so */
    IBL_ALPHA_STRAIGHT /* kept. Colours are always multiplied by it: for files
                          that break the rule of their format */
} ibl_alpha;

/* How a file holds an environment. All but equirectangular maps are turned into
 * such a map when they are read. */
typedef enum ibl_input_layout {
    IBL_INPUT_AUTO,      /* by the file's kind and shape */
    IBL_INPUT_EQUIRECT,  /* any shape, as with any_aspect */
    IBL_INPUT_CUBE,      /* a KTX2, KTX or DDS texture */
    IBL_INPUT_FACES,     /* a file for each face; see ibl_image_read */
    IBL_INPUT_HCROSS,    /* 4 by 3 faces, in rows of +Y; -X +Z +X -Z; -Y. +Y and
                            -Y are in the second column */
    IBL_INPUT_VCROSS,    /* 3 by 4 faces, in rows of +Y; -X +Z +X; -Y; -Z, which
                            is turned by 180 degrees. All but -X and +X are in
                            the second column */
    IBL_INPUT_HSTRIP,    /* 6 by 1 faces: +X -X +Y -Y +Z -Z */
    IBL_INPUT_VSTRIP,    /* 1 by 6 */
    IBL_INPUT_OCTAHEDRAL /* square, +Y in the middle, +X at the middle of the
                            right edge, +Z of the lower one, -Y in the corners
                          */
} ibl_input_layout;

/* "auto", "equirect", "cube", "faces", "hcross", "vcross", "hstrip", "vstrip"
 * or "octahedral". */
const char *ibl_input_layout_name(ibl_input_layout layout);

/*
 * Primaries to convert the colours of a file to. White stays R = G = B: where
 * the white points differ, colours are adapted by Bradford's transform (Lam
 * 1985). A file has the primaries that it names: EXR chromaticities, PRIMARIES
 * of a .hdr, the ICC profile of an Ultra HDR JPEG. If it names none, they are
 * Rec.709's.
 */
typedef enum ibl_primaries {
    IBL_PRIMARIES_KEEP,   /* the file's, whatever they are: no conversion */
    IBL_PRIMARIES_REC709, /* ITU-R BT.709 and sRGB, white D65 */
    IBL_PRIMARIES_ACESCG, /* AP1, white of ACES (about D60) */
    IBL_PRIMARIES_REC2020 /* ITU-R BT.2020, white D65 */
} ibl_primaries;

/* "keep", "rec709", "acescg" or "rec2020"; else "unknown". */
const char *ibl_primaries_name(ibl_primaries primaries);

#define IBL_MAX_EXPOSURE 64 /* of ibl_read_options, up and down */

/* Reads a file as a cube, as ibl_texture_decode does. */
struct ibl_texture;
typedef ibl_status ibl_unpack_fn(ibl_ctx *ctx, const char *name,
                                 const void *bytes, size_t size,
                                 struct ibl_texture *tex);

/* How the integers of a file become light. Floats are linear. */
typedef enum ibl_transfer {
    IBL_TRANSFER_FILE,   /* sRGB's curve, or what the file says: a PNG may be
                            linear by its gAMA */
    IBL_TRANSFER_LINEAR, /* they are proportional to light */
    IBL_TRANSFER_SRGB
} ibl_transfer;

enum {
    IBL_FACE_ORDER = 64 /* bytes of its text */
};

/*
 * What the faces of a cube are, in the order in which a layout has them: for
 * each, +X -X +Y -Y +Z -Z as 0 to 5, and 6 for each quarter by which it is
 * turned clockwise; 24 more if it is mirrored left to right before. As text
 * "px,nx,py,ny,pz,nz", each with one of /90 /180 /270 /m /m90 /m180 /m270
 * behind it if it is turned. 0: the text is no order of the six faces.
 */
int ibl_face_order_parse(const char *text, unsigned char order[IBL_FACES]);
void ibl_face_order_text(const unsigned char order[IBL_FACES],
                         char text[IBL_FACE_ORDER]);

/* Colours are repaired, then converted, then exposed, then clamped. */
typedef struct ibl_read_options {
    const char *layer;       /* EXR: channels LAYER.R, LAYER.G, ..., a part of
                                that name, or a layer whose name ends in
                                .LAYER; NULL: the only one with R, G and B, else
                                with Y alone, and of several the unnamed one.
                                Other formats have none: IBL_ERR_FORMAT */
    int part;                /* EXR: part of a multi-part file, from 0; -1: the
                                one with that layer (default). Others: 0 */
    int strict;              /* 1: refuse non-finite and negative pixels */
    int refuse_prefiltered;  /* 1: refuse, 0 (default): warn of textures that
                                are baked maps by their key */
    int any_aspect;          /* 1: accept maps that are not 2:1: with AUTO,
                                images of any shape are equirectangular */
    ibl_input_layout layout; /* default IBL_INPUT_AUTO */
    ibl_alpha alpha;         /* default IBL_ALPHA_IGNORE; see
                                ibl_source_alpha */
    ibl_primaries primaries; /* default IBL_PRIMARIES_KEEP. Colours outside the
                                gamut get their luminance's grey mixed in until
                                no component is negative */
    double exposure;         /* EV: colours are multiplied by 2^exposure;
                                -IBL_MAX_EXPOSURE..IBL_MAX_EXPOSURE */
    double clamp; /* > 0: the largest component allowed; a pixel above it is
                     scaled down as a whole and keeps its hue. 0: none */
    int hash;     /* 1: the report gets the hash of the file */
    ibl_unpack_fn *env; /* reads Babylon's .env, whose images this library does
                           not; NULL: they are refused */
    ibl_transfer transfer;               /* default IBL_TRANSFER_FILE */
    unsigned char face_order[IBL_FACES]; /* of layouts with faces; zeros: as the
                                            layout says (default) */
    ibl_cube *faces; /* two empty cubes, or NULL: the first gets the faces of a
                        layout with faces, the second those of alpha, as level 0
                        of all levels down to 1x1. The caller frees both, also
                        after an error */
} ibl_read_options;

ibl_read_options ibl_read_options_default(void);

enum {
    IBL_FILE_HASH = 33 /* 32 hexadecimal digits and a 0 */
};

/* XXH3 of 128 bits as xxh128sum prints it: detects changes, not forgery. */
void ibl_hash_bytes(const void *bytes, size_t size, char hash[IBL_FILE_HASH]);
/* The same of a regular file. 0, or an errno: it cannot be read; EISDIR: it is
 * a directory; EINVAL: it is neither. */
int ibl_hash_file(const char *path, char hash[IBL_FILE_HASH]);

/* Properties of the file, and counts of repaired pixels. */
typedef struct ibl_read_report {
    char format[64];  /* "Radiance RGBE", "OpenEXR, ZIP", .. */
    size_t nonfinite; /* pixels that held Inf or NaN */
    size_t negative;  /* pixels that held a finite value below 0 */
    float peak;       /* largest component after repair, before conversion */
    int low_range; /* 8 or 16-bit integers, 1: decoded from sRGB, 2: linear */
    int bridged;   /* 1: read by OpenImageIO */
    ibl_input_layout layout; /* of the file */
    int has_alpha;           /* 1: the file has alpha, and it was read */
    float alpha_least; /* the smallest and largest alpha after repair; both 1 */
    float alpha_most;  /*   without alpha */
    size_t alpha_nonfinite;  /* pixels whose alpha was Inf or NaN */
    size_t alpha_beyond;     /* pixels whose alpha was more than 0.001 below 0
                                or above 1 */
    size_t alpha_hidden;     /* pixels with alpha 0 and a colour that the file
                                has multiplied by alpha; it became 0 */
    int has_primaries;       /* 1: the file names its primaries */
    double primaries[8];     /* of the file: xy of red, green, blue and white */
    char primaries_name[24]; /* "Rec.709", "ACEScg", ...; "": others */
    double luma[3]; /* luminance of the R, G and B that are read, white is 1 */
    size_t outside; /* pixels that were outside the gamut of opts->primaries */
    size_t clamped; /* pixels that opts->clamp scaled down */
    double clamp_removed; /* the share of the map's luminance, summed over the
                             sphere, that this took away; in other layouts than
                             equirectangular, summed over the pixels */
    char hash[IBL_FILE_HASH]; /* with opts->hash: ibl_hash_file's; of six
                                 files, that of their hashes' digits; else "" */
} ibl_read_report;

/*
 * Reads an environment as an equirectangular map of linear RGB floats. The
 * format is detected from the content, never from the name; iblbake(1) says
 * what is read of each:
 *   Radiance .hdr  RGBE; EXPOSURE and COLORCORR are undone
 *   OpenEXR        the display window of scan lines and tiles (level 0): R G B
 *                  or Y alone, or a cube by its attribute envmap. Compressions
 *                  other than ZIP take libiblexr.so, beside the bridge
 *   Ultra HDR JPEG through the bridge, at the full gain; 1 is the white of the
 *                  JPEG alone
 *   others         formats of OpenImageIO that their first bytes tell, through
 *                  the bridge: a shared object that is opened only if needed.
 *                  Integers are decoded as opts->transfer says, EXIF's
 *                  orientation is obeyed; AVIF and HEIF of linear, PQ's or
 *                  HLG's values are refused
 *   textures       KTX2, KTX and DDS of one layer: level 0 of a cube, or of a
 *                  flat texture as an image, with iblbake's keys for axes and
 *                  layouts and KTX2's primaries. What has their key of a baked
 *                  map is warned of, or refused. The bridge reads DDS files,
 *                  and cubes, in other formats
 * Images of 2:1 are equirectangular maps, others what their shape says: 4:3 and
 * 3:4 are crosses, 6:1 and 1:6 strips. A square is ambiguous, so opts must say
 * the layout. The map of a cube has the width ibl_latlong_width; its pixels are
 * those of ibl_latlong_from_cube, made after repair. The map of an octahedral
 * image of n x n pixels is 4 n wide, at least 256, and its integral is the
 * same. Besides the map (384 bytes for each texel of a face, 96 for each
 * octahedral pixel), making it takes the memory of the file's pixels. Alpha is
 * dropped; to read it: ibl_source_alpha.
 * A non-finite component becomes the larger one of its neighbours in the row
 * (columns wrap) that are finite. If there is none, +Inf becomes 65504, others
 * 0. Negative components become 0. Both repairs are counted, with a warning; of
 * negative ones only above 1e-4 of the light. Other warnings name primaries
 * that are not Rec.709's and are kept, a map that is black, and faces of a cube
 * that do not meet though they would in another order.
 *   path     a file, also a pipe by name (a FIFO, /dev/stdin, a shell's
 *            <(command)), or "-" for standard input. If there is no such file,
 *            six files of square faces of the same size: a pattern, whose %f
 *            stands for px nx py ny pz nz or another set of names (iblbake(1));
 *            or six names separated by commas, +X -X +Y -Y +Z -Z
 *   opts     NULL for defaults
 *   img      empty; filled here, to be freed with ibl_image_free
 *   report   may be NULL
 * IBL_ERR_IO: cannot be opened or read. IBL_ERR_FORMAT: not an image,
 * corrupt, truncated, of no layout's shape, not of the layout that opts says,
 * repaired pixels with strict.
 * IBL_ERR_UNSUPPORTED: needs the bridge or libiblexr.so, which is missing or
 * cannot read it.
 * IBL_ERR_MEMORY: the pixels, or a file that must be read as a whole, exceed
 * the machine's memory. A stream is IBL_ERR_FORMAT if it exceeds 4 GiB, or half
 * of the memory that is allowed.
 */
ibl_status ibl_image_read(ibl_ctx *ctx, const char *path,
                          const ibl_read_options *opts, ibl_image *img,
                          ibl_read_report *report);

/* The same from memory; messages use name. If the bridge cannot read the
 * format from memory, it reads a temporary file whose name is removed before
 * it is read. */
ibl_status ibl_image_decode(ibl_ctx *ctx, const char *name, const void *bytes,
                            size_t size, const ibl_read_options *opts,
                            ibl_image *img, ibl_read_report *report);

/* The names of the files that a path of ibl_image_read means: 1 or 6. Free them
 * with ibl_input_files_free. IBL_ERR_IO: no file's name fits a pattern. */
ibl_status ibl_input_files(ibl_ctx *ctx, const char *path,
                           char *files[IBL_FACES], int *count);
void ibl_input_files_free(char *files[IBL_FACES]);

/* Version of the OpenEXRCore in use, as "3.1.5". */
const char *ibl_exr_version(void);
/* Path of the image bridge for a context that was given none. */
const char *ibl_bridge_path(void);

/* ---- images in, row by row ------------------------------------------- */

/*
 * A map that is read from the zenith down, some rows at a time, so that the
 * whole map is not in memory. Memory besides the rows of a call:
 *   Radiance .hdr  1 MiB of the file; the whole image if scanlines are columns
 *                  or run from the bottom
 *   OpenEXR        for each thread a block or tile, packed and unpacked; one
 *                  row of blocks or tiles, or as many rows as keep the threads
 *                  busy within 32 MiB
 *   others         the whole map, and while it is opened the file and what
 *                  OpenImageIO takes
 *   pipes, standard input, files below 64 KiB: the file
 *   textures, layouts other than equirectangular: the whole map
 */
typedef struct ibl_source ibl_source;

/*
 * Opens any file of ibl_image_read and reads its header. A truncated file may
 * be detected only when all rows have been read.
 *   path   as in ibl_image_read; copied
 *   opts   NULL for defaults; not needed afterwards
 *   out    to be closed with ibl_source_close before ctx is freed; NULL after
 *          an error
 * Errors as in ibl_image_read.
 */
ibl_status ibl_source_open(ibl_ctx *ctx, const char *path,
                           const ibl_read_options *opts, ibl_source **out);

/* Pixels in a program's memory, rows from the top. */
typedef struct ibl_pixels {
    const void *data; /* need not be aligned */
    int width, height;
    int channels;        /* 3: R, G, B; 4: R, G, B, A */
    int half;            /* 1: halves; 0: floats */
    ptrdiff_t row_bytes; /* from a row to the next, below 0 where the rows lie
                            upside down; 0: nothing lies between them */
} ibl_pixels;

/*
 * Opens a map in memory, which is then mended or refused, turned from any
 * layout and changed in colour as a file would be. Without primaries of its own
 * it is in Rec. 709. A program's own data that are finite and not negative need
 * no source: bakes take them as they are in an ibl_image.
 *   name    for messages; copied
 *   pixels  copied, with its data
 *   opts    NULL for defaults; alpha: with FILE colours are multiplied by it
 * IBL_ERR_ARGUMENT: pixels of no such kind, or a layer, part, hash or transfer
 * in opts.
 * Other errors as in ibl_image_read.
 */
ibl_status ibl_source_of_pixels(ibl_ctx *ctx, const char *name,
                                const ibl_pixels *pixels,
                                const ibl_read_options *opts, ibl_source **out);

/* Reads all rows, none of which was read before, into an empty image. */
ibl_status ibl_source_image(ibl_source *source, ibl_image *img);
/* Bytes of memory that the source takes until it is closed, rounded up. */
size_t ibl_source_memory(const ibl_source *source);
int ibl_source_width(const ibl_source *source);
int ibl_source_height(const ibl_source *source);

/*
 * Reads the next rows, repaired as in ibl_image_read. The floats do not depend
 * on the division into calls. Runs on the context's pool and reports progress
 * as stage "decode".
 *   rows   1 to the number of rows left, else IBL_ERR_ARGUMENT
 *   rgb    3 * width * rows floats
 * Errors as in ibl_image_read. strict reports its error with the last row, so
 * do not use rows before all are read. After an error other than
 * IBL_ERR_ARGUMENT, rgb is unspecified and each later call returns the same
 * status.
 */
ibl_status ibl_source_read(ibl_source *source, int rows, float *rgb);

/*
 * Alpha, if the options request it and the file has it: width * height floats
 * from the zenith down, owned by source. Only the rows read so far are valid.
 * NULL: no alpha; it is 1 everywhere.
 *
 * Alpha is channel A of the colour's layer (OpenEXR), outside the data window
 * 0, or the alpha channel that OpenImageIO names; it is never decoded from
 * sRGB. Non-finite values become 0, others are limited to 0..1. Repairs of more
 * than 0.001 are counted, with a warning, and refused with strict. Colours with
 * alpha 0 become 0. Takes 4 bytes of memory for each pixel of the map.
 */
const float *ibl_source_alpha(const ibl_source *source);

/* The source as the input of ibl_bake_environment, which reads all its rows.
 * source must stay open during the bake. */
ibl_environment ibl_source_environment(ibl_source *source);

/* The report, complete when all rows have been read. Owned by source. */
const ibl_read_report *ibl_source_report(const ibl_source *source);

void ibl_source_close(ibl_source *source); /* NULL is fine */

/* ---- textures ------------------------------------------------------- */

/* The formats of cubes come first. */
typedef enum ibl_pixel {
    IBL_PIXEL_RGBA16F,    /* 8 bytes: 4 halves */
    IBL_PIXEL_RGBA32F,    /* 16 bytes: 4 floats */
    IBL_PIXEL_RGB9E5,     /* 4 bytes: 3 x 9 bits, shared 5-bit exponent */
    IBL_PIXEL_R11G11B10F, /* 4 bytes: unsigned floats of 11, 11, 10 bits */
    IBL_PIXEL_BC6H,       /* blocks of 4x4 texels in 16 bytes: unsigned */
    IBL_PIXEL_UASTC_HDR,  /*   the same: the part of ASTC that Basis Universal's
                             transcoders take; KTX2 alone marks it */
    IBL_PIXEL_ASTC4X4HDR, /*   the same blocks, marked as ASTC; KTX2 and KTX */
    IBL_PIXEL_RG16F,      /* 4 bytes: 2 halves (the LUT) */
    IBL_PIXEL_RG32F,      /* 8 bytes: 2 floats (the LUT) */
    IBL_PIXEL_COUNT
} ibl_pixel;

/* "rgba16f", "rgba32f", "rgb9e5", "r11g11b10f", "bc6h", "uastc-hdr",
 * "astc4x4hdr", "rg16f", "rg32f". */
const char *ibl_pixel_name(ibl_pixel pixel);
/* Edge of a block in texels: 4, or 1 if each texel has bytes of its own. */
int ibl_pixel_block(ibl_pixel pixel);
/* Bytes of one block: of one texel, if blocks are not larger. */
size_t ibl_pixel_bytes(ibl_pixel pixel);
/* Floats of one decoded texel: 3 (RGB), 2 (RG). */
int ibl_pixel_channels(ibl_pixel pixel);
/* 1: it also has alpha, encoded as 1: see ibl_texture_set_alpha. */
int ibl_pixel_has_alpha(ibl_pixel pixel);
/* Largest finite value of red: 65504, FLT_MAX, 65408, 65024 or 65216. */
float ibl_pixel_max(ibl_pixel pixel);

/*
 * The numbers of a pixel format in graphics APIs; 0: the API has no such
 * format. Blocks of UASTC HDR are blocks of ASTC to Vulkan; other APIs have to
 * transcode them. Sources: vulkan_core.h, dxgiformat.h, OpenGL's registry.
 */
typedef struct ibl_pixel_numbers {
    uint32_t vk;                 /* VkFormat */
    uint32_t dxgi;               /* DXGI_FORMAT */
    uint32_t gl_internal;        /* of glTexStorage2D, or of blocks of
                                    glCompressedTexImage2D */
    uint32_t gl_format, gl_type; /* of glTexSubImage2D; 0 of blocks */
} ibl_pixel_numbers;
ibl_pixel_numbers ibl_pixel_numbers_of(ibl_pixel pixel);

/*
 * Decodes count texels to ibl_pixel_channels(pixel) floats each, without alpha.
 * Of blocks count is a multiple of 16: all texels of a block, row by row, come
 * before those of the next.
 * Encoders round to nearest, ties to even (RGB9E5: as in
 * EXT_texture_shared_exponent), and keep denormals. Values above the largest
 * finite value, including +Inf, become that value. In halves and floats, values
 * below its negative become the negative; in other pixels, all negative values
 * become 0. NaN becomes 0.
 */
void ibl_pixel_decode(ibl_pixel pixel, const void *src, size_t count,
                      float *dst);

/* Time that encoders of blocks take, for a smaller error. */
typedef enum ibl_quality {
    IBL_QUALITY_FAST,
    IBL_QUALITY_NORMAL, /* the default */
    IBL_QUALITY_BEST
} ibl_quality;

typedef struct ibl_key_value {
    char *key;
    char *value;
} ibl_key_value;

/* What OpenGL 4 and Direct3D 11 guarantee, where each face of a cube counts. */
#define IBL_MAX_LAYERS 2048

#define IBL_MAX_ZSTD 22 /* the levels of Zstandard begin with 1 */

/*
 * A texture in memory, in upload order: levels from the largest, then the
 * layers of a level, the faces of a layer, and the rows of a face from the top,
 * without padding. Blocks of more than a texel are rows of blocks instead;
 * those at the right and lower edge may have texels beyond it. Cubes have width
 * == height and 6 faces in the order +X -X +Y -Y +Z -Z; flat textures have 1
 * face. All layers of an array have the same shape; other textures have 1
 * layer. A zeroed texture is empty. Free with ibl_texture_free.
 */
#define IBL_UNKNOWN_PRIMARIES (-1)

typedef struct ibl_texture {
    ibl_pixel pixel;
    int width, height; /* of level 0, in texels, >= 1 */
    int levels;        /* >= 1 */
    int layers;        /* 1..IBL_MAX_LAYERS */
    int faces;         /* 6 or 1 */
    size_t bytes;      /* of data */
    unsigned char *data;
    int premultiplied; /* 1: colours are multiplied by an alpha that is not 1
                          everywhere. KTX2 stores this in its descriptor; KTX
                          and DDS cannot store it and are read back with 0 */
    int zstd;          /* 1..IBL_MAX_ZSTD: level of Zstandard (supercompression
                          scheme 2) in KTX2 files; others cannot be written.
                          0: none, as after reading and in new arrays */
    int filament;      /* 1: KTX stores the internal format of r11g11b10f as
                          glType and glBaseInternalFormat, with a glTypeSize of
                          1: Filament reads only that. 0: what the
                          specification says, as after reading */
    int primaries;     /* colorPrimaries of KTX2 files, by the Khronos data
                          format specification; IBL_UNKNOWN_PRIMARIES: none of
                          these. 0: Rec.709's, as after reading KTX and DDS,
                          which cannot store any */
    ibl_key_value *keys; /* metadata, sorted by key, no key twice */
    int key_count;
} ibl_texture;

void ibl_texture_free(ibl_texture *tex); /* NULL and zeroed are fine */

/* Offset in tex->data of a level's face, of layer 0 or any, and its bytes. */
size_t ibl_texture_offset(const ibl_texture *tex, int level, int face);
size_t ibl_texture_layer_offset(const ibl_texture *tex, int level, int layer,
                                int face);
size_t ibl_texture_face_bytes(const ibl_texture *tex, int level);

/* Copies one layer, with all keys. out: empty, to be freed by the caller.
 * IBL_ERR_ARGUMENT: tex has no such layer or is incomplete. */
ibl_status ibl_texture_layer(ibl_ctx *ctx, const ibl_texture *tex, int layer,
                             ibl_texture *out);
/*
 * An array filled layer by layer, so that only one other layer must be in
 * memory at a time. begin makes it (out: as above, without keys) with `layers`
 * layers of the shape of tex and undefined texels. put copies tex into a layer.
 * IBL_ERR_ARGUMENT: tex is incomplete, has more than one layer or differs from
 * the array; or the array has no such layer or more than IBL_MAX_LAYERS.
 */
ibl_status ibl_texture_array_begin(ibl_ctx *ctx, const ibl_texture *tex,
                                   int layers, ibl_texture *out);
ibl_status ibl_texture_array_put(ibl_ctx *ctx, ibl_texture *array, int layer,
                                 const ibl_texture *tex);

/* Sets a key to a value (both copied; UTF-8, key 1..255 bytes, at most 4096
 * keys, else IBL_ERR_ARGUMENT). */
ibl_status ibl_texture_set(ibl_ctx *ctx, ibl_texture *tex, const char *key,
                           const char *value);
/* The value of a key, owned by tex; NULL if there is no such key. */
const char *ibl_texture_get(const ibl_texture *tex, const char *key);

/*
 * Handling of cube texels that exceed the largest value of their pixel.
 *   SPREAD  The excess goes to the surrounding texels, separately in each
 *           channel and level, from the brightest texel down (the first of
 *           equals). It goes to the ring around the connected full texels, also
 *           across the cube's edges; then, while some is left, to the ring
 *           around that. A level keeps its mean radiance by solid angle, except
 *           for the rounding to the pixel and for light that exceeds the
 *           capacity of the whole level. Nothing becomes darker.
 *   CLIP    The texels become the largest value; the excess is lost.
 * In both cases Inf becomes the largest value and counts as that.
 */
typedef enum ibl_overflow {
    IBL_OVERFLOW_SPREAD,
    IBL_OVERFLOW_CLIP
} ibl_overflow;

/* For a level: the number of texels with a component above the largest value,
 * and the shares of the light of all texels (R + G + B, by solid angle) that
 * moved to other texels or were lost. */
typedef struct ibl_overflow_level {
    size_t texels;
    double moved, lost;
} ibl_overflow_level;

typedef struct ibl_overflow_report {
    size_t values; /* components above the largest value, in all levels */
    ibl_overflow_level level[IBL_MAX_LEVELS];
} ibl_overflow_report;

/* How the texels of a cube are encoded. */
typedef struct ibl_texel_options {
    ibl_pixel pixel;       /* of 3 channels; default IBL_PIXEL_RGBA16F */
    ibl_overflow overflow; /* default IBL_OVERFLOW_SPREAD */
    double largest;        /* if above 0 and below the pixel's largest value, in
                              its place for overflow; default 0 */
    ibl_quality quality;   /* of blocks; default IBL_QUALITY_NORMAL */
    /* 1: blocks of UASTC HDR and ASTC repeat bytes of others where that costs
     * little, so that Zstandard makes 5 to 20 % fewer bytes of them; their mean
     * error grows by some percent of itself. No effect on faces of less than 64
     * texels and with IBL_QUALITY_BEST. Default 0. */
    int alike;
} ibl_texel_options;

ibl_texel_options ibl_texel_options_default(void);

/*
 * Cube or LUT to texture and back. A flat map (ibl_projection) becomes a flat
 * texture with the key iblbake.layout, its projection's name; without the key a
 * flat texture is read as octahedral if it is square, as equirectangular if its
 * width is twice its height. A cube takes the 3-channel pixels, a LUT those
 * of its ibl_lut_channels that are no blocks, else IBL_ERR_ARGUMENT, as for an
 * unknown quality. The key iblbake.table is the kind of a LUT if not split.
 * opts NULL: defaults. Texels of blocks beyond the edge of a face repeat its
 * last ones. report may be NULL; *saturated, if not NULL, counts
 * components that became the largest value or its negative. If no component is
 * above the largest value, overflow has no effect and no cost; else spreading
 * uses 17 bytes of temporary memory for each texel of a level. Decoding returns
 * IBL_ERR_ARGUMENT for a texture of the other kind, and for an array of more
 * than one layer: ibl_texture_layer extracts one. IBL_ERR_UNSUPPORTED: blocks
 * of ASTC that are none of UASTC HDR.
 */
ibl_status ibl_texture_from_cube(ibl_ctx *ctx, const ibl_cube *cube,
                                 const ibl_texel_options *opts,
                                 ibl_texture *tex, ibl_overflow_report *report);
ibl_status ibl_texture_from_lut(ibl_ctx *ctx, const ibl_lut *lut,
                                ibl_pixel pixel, ibl_texture *tex,
                                size_t *saturated);
/* A lobe table is an array of flat textures of RGBA16F. IBL_ERR_ARGUMENT: of
 * other than IBL_LOBE_LAYERS layers, or half as many. */
ibl_status ibl_texture_from_lobe_table(ibl_ctx *ctx,
                                       const ibl_lobe_table *table,
                                       ibl_texture *tex);
ibl_status ibl_texture_to_cube(ibl_ctx *ctx, const ibl_texture *tex,
                               ibl_cube *cube);
ibl_status ibl_texture_to_lut(ibl_ctx *ctx, const ibl_texture *tex,
                              ibl_lut *lut);

/* How a texture lies on the sphere, if it is of one: by its faces, the key or
 * its aspect, as ibl_texture_to_cube has it. */
ibl_projection ibl_texture_projection(const ibl_texture *tex);

/* Replaces blocks by RGBA16F texels of the same values, in place; other pixels
 * stay as they are. tex is unchanged after an error, as ibl_texture_to_cube. */
ibl_status ibl_texture_unblock(ibl_ctx *ctx, ibl_texture *tex);

/* The error of the pixel format at a level, with what the overflow did: t is a
 * texel of the cube, d the same texel decoded, |.| over R, G and B. */
typedef struct ibl_pixel_error {
    double nrmse;    /* sqrt(sum |d - t|^2 / sum |t|^2) */
    double relative; /* mean of |d - t| / |t|; for a black t 0 if d is black,
                        else 1 */
    double lost;     /* share of the level's light, summed over texels and
                        components, in components that the format makes 0 */
} ibl_pixel_error;

/*
 * Compares a texture of one layer with the cube that it was made from, of any
 * projection: errors of all levels. Texels of the cube that are not finite, or
 * beyond 1e19, are left out; below 1e-23 they count as black. IBL_ERR_ARGUMENT:
 * tex is not a cube of one layer, or cube has another shape.
 */
ibl_status ibl_texture_errors(ibl_ctx *ctx, const ibl_texture *tex,
                              const ibl_cube *cube,
                              ibl_pixel_error error[IBL_MAX_LEVELS]);

/*
 * Sets the alpha of a cube's texels; the colours are already multiplied by it.
 * Uses the red of each texel of alpha, which has the shape of tex. NaN and
 * values below 0 become 0, values above 1 become 1. Makes tex premultiplied.
 * IBL_ERR_ARGUMENT: tex is not a cube of one layer, its pixels have no alpha
 * (ibl_pixel_has_alpha), or alpha has another shape; tex is unchanged.
 */
ibl_status ibl_texture_set_alpha(ibl_ctx *ctx, ibl_texture *tex,
                                 const ibl_cube *alpha);
/* The inverse: alpha in all three components; 1 if pixels have none. alpha:
 * empty, to be freed with ibl_cube_free. Errors as in ibl_texture_to_cube. */
ibl_status ibl_texture_get_alpha(ibl_ctx *ctx, const ibl_texture *tex,
                                 ibl_cube *alpha);

typedef enum ibl_container {
    IBL_CONTAINER_KTX2,       /* Khronos KTX 2.0; tex->zstd compresses it */
    IBL_CONTAINER_KTX,        /* Khronos KTX 1.1, little endian */
    IBL_CONTAINER_DDS,        /* DDS with the DX10 header; no key/values */
    IBL_CONTAINER_DDS_LEGACY, /* DDS with a float format of Direct3D 9 in place
                                 of a FourCC: half or float of 2 or 4 channels;
                                 no arrays */
    IBL_CONTAINER_COUNT
} ibl_container;

/* "ktx2", "ktx", "dds", "dds-legacy". */
const char *ibl_container_name(ibl_container container);
/* The same, but "dds" for both of DDS. */
const char *ibl_container_extension(ibl_container container);
/* 1: files of that kind can hold the pixel format. */
int ibl_container_holds(ibl_container container, ibl_pixel pixel);

/*
 * The bytes of a file in that container. Free *bytes with ibl_bytes_free. KTX2
 * and KTX get KTXorientation and KTXwriter besides the keys of tex; DDS drops
 * them. A texture of one layer is not written as an array. Levels are packed by
 * Zstandard on the context's pool. IBL_ERR_ARGUMENT: tex is incomplete.
 * IBL_ERR_UNSUPPORTED: the container does not hold the pixel format, or no
 * array; KTX with a face of 4 GiB, or with a level of 4 GiB in an array.
 */
ibl_status ibl_texture_encode(ibl_ctx *ctx, const ibl_texture *tex,
                              ibl_container container, void **bytes,
                              size_t *size);
void ibl_bytes_free(void *bytes);

/*
 * Reads a KTX2, KTX or DDS file (detected by content) with the pixel formats of
 * ibl_pixel: cube, 2D or an array of either, with or without levels; of KTX
 * only little endian. RGB of halves or floats is widened to 4 channels, signed
 * BC6H becomes RGBA16F. Files that this library wrote are read back bit for
 * bit, with keys. Keys are read if their value is text, except KTXorientation:
 * if by that rows do not begin at the top, a flat texture is flipped and a cube
 * is IBL_ERR_UNSUPPORTED, as are more layers than IBL_MAX_LAYERS, 3D, other
 * pixel formats and supercompressions, which the message names. IBL_ERR_FORMAT:
 * a damaged file. Never reads outside [bytes, size), and allocates little more
 * than size, or than the most that Zstandard can have packed in it.
 *   container   may be NULL
 */
ibl_status ibl_texture_decode(ibl_ctx *ctx, const char *name, const void *bytes,
                              size_t size, ibl_texture *tex,
                              ibl_container *container);
/* The same from a file, standard input or pipe, as in ibl_image_read.
 * IBL_ERR_IO: cannot be opened or read. */
ibl_status ibl_texture_read(ibl_ctx *ctx, const char *path, ibl_texture *tex,
                            ibl_container *container);

/* ---- files that appear together or not at all ------------------------ */

/*
 * A set of output files. Each is written to a temporary file
 * beside its target (".NAME.iblbake-PLACE-PID-N.tmp", mode 0666 & ~umask), and
 * commit renames them all: until then existing files are as they were, also
 * after a failure of the program, a signal or a full disk. What the system has
 * not yet written to the disk is lost in a power cut: sync prevents that.
 *
 * A commit waits until no other has its directories, by flock, so that of two
 * sets with the same targets all files are those of one; file systems without
 * such locks (NFS) are not locked. A process that is killed (SIGKILL) leaves
 * temporaries and, during commit, some files new and some old, each complete.
 * The first commit of another process to the same directory removes the
 * temporaries, unless a process has their PID; those of other hosts and
 * containers stay.
 *
 * If a target is a symbolic link, the file that it names is replaced. Targets
 * that are not files (directories, devices, pipes, links to nothing) and files
 * without write permission are refused with IBL_ERR_IO and stay unchanged.
 *
 * A path has at most 4031 bytes; relative ones are valid while the working
 * directory stays the same. With RLIMIT_FSIZE, SIGXFSZ must be ignored.
 */
typedef struct ibl_outputs ibl_outputs;

#define IBL_MAX_OUTPUTS 512    /* files in one set */
#define IBL_MAX_OUTPUT_DIRS 64 /* directories made for it */

/* Makes an empty set; it uses ctx for messages and cancellation. sync 1: files
 * are on the disk before add returns, directories before commit does. 0: the
 * system writes them when it likes. */
ibl_status ibl_outputs_create(ibl_ctx *ctx, int sync, ibl_outputs **out);
/* Makes directory path and missing parents (mode 0777 & ~umask).
 * IBL_ERR_IO: cannot be made, or exists and is not a directory. */
ibl_status ibl_outputs_mkdir(ibl_outputs *out, const char *path);
/* Writes a file of the set. IBL_ERR_IO: not writable, disk full, or the target
 * cannot be replaced. IBL_ERR_ARGUMENT: the set is full, aborted or already has
 * the target (by any path), or path is too long. An error leaves the set
 * unchanged. */
ibl_status ibl_outputs_add(ibl_outputs *out, const char *path,
                           const void *bytes, size_t size);
/* The same of the bytes of ibl_texture_encode; *size, if not NULL, is their
 * number. Takes tex: it is empty afterwards, for any status. The file may still
 * be written when this returns, on a thread of the context, one file at a time;
 * wait or commit returns the error. */
ibl_status ibl_outputs_take_texture(ibl_outputs *out, const char *path,
                                    ibl_texture *tex, ibl_container container,
                                    size_t *size);
/* XXH3 of 128 bits of a file of the set, 32 hexadecimal digits, until the set
 * is freed; waits until it is written. "": there is none. */
const char *ibl_outputs_hash(ibl_outputs *out, const char *path);
/* Waits until all added files are written. */
ibl_status ibl_outputs_wait(ibl_outputs *out);
/* Renames every file to its target, in the order in which they were added. The
 * set is then empty and can be reused. Signals to the calling thread wait
 * meanwhile. IBL_ERR_IO: a rename failed, or with sync a flush; files that were
 * renamed before stay so, and the set is aborted. */
ibl_status ibl_outputs_commit(ibl_outputs *out);
/* Removes all files not committed, and empty directories made for the set.
 * NULL is fine. */
void ibl_outputs_free(ibl_outputs *out);
/* Does so for all sets of the process, which then must end: nothing can be
 * added any more, and a commit that renames is waited for. It makes only system
 * calls, so a signal handler may call it on any thread; errno is kept. */
void ibl_outputs_abort_all(void);
/* The caller has this directory locked by flock, exclusively, until the set is
 * freed: commit does not wait for it. */
void ibl_outputs_hold(ibl_outputs *out, const char *directory);

IBL_API_END
#ifdef __cplusplus
}
#endif

#endif
