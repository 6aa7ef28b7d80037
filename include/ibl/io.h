/* SPDX-License-Identifier: MIT */
/*
 * iblbake: reading images, reading and writing textures.
 *
 * Conventions, status codes and thread rules: <ibl/ibl.h>. Programs that use
 * ibl_image_read, ibl_image_decode or ibl_source_open link OpenEXRCore and
 * libdeflate too (zlib where the library was built without libdeflate);
 * everything else here needs only the C library.
 */
#ifndef IBL_IO_H
#define IBL_IO_H

#include <stddef.h>

#include "ibl.h"

#ifdef __cplusplus
extern "C" {
#endif

/* ---- images in ------------------------------------------------------ */

/*
 * What becomes of an alpha channel: how much of a pixel is there, 0..1. What
 * filters an image filters colours multiplied by alpha, and alpha; quotients
 * are the colours of what is there.
 */
typedef enum ibl_alpha {
    IBL_ALPHA_IGNORE,  /* dropped: colours are what the file has */
    IBL_ALPHA_FILE,    /* kept. Colours are multiplied by it, or taken as they
                          are where they are so by the rule of the format:
                          OpenEXR always, TIFF and others where they say so */
    IBL_ALPHA_STRAIGHT /* kept. Colours are multiplied by it, whatever the
                          format's rule: for files that break it */
} ibl_alpha;

/* "ignore", "file" or "straight". */
const char *ibl_alpha_name(ibl_alpha alpha);

typedef struct ibl_read_options {
    const char *layer; /* EXR: channels LAYER.R, LAYER.G, ...; NULL: the
                          unnamed layer, else the file's only one. Files of
                          other kinds have none: IBL_ERR_FORMAT */
    int part;          /* EXR: part of a multi-part file, from 0; -1: the
                          first that has colour (default). Others have 0 */
    int strict;        /* 1: refuse non-finite and negative pixels */
    int any_aspect;    /* 1: take maps that are not 2:1 */
    ibl_alpha alpha;   /* what to do with alpha, default IBL_ALPHA_IGNORE:
                          see ibl_source_alpha */
} ibl_read_options;

ibl_read_options ibl_read_options_default(void);

/* What was read and what had to be mended. */
typedef struct ibl_read_report {
    char format[64];   /* "Radiance RGBE, run-length", "OpenEXR, ZIP", .. */
    size_t nonfinite;  /* pixels that held Inf or NaN */
    size_t negative;   /* pixels that held a finite value below 0 */
    float peak;        /* largest component after repair, before alpha */
    int low_range;     /* 1: 8 or 16-bit integers, decoded from sRGB */
    int bridged;       /* 1: read by OpenImageIO */
    int has_alpha;     /* 1: alpha is there and was read */
    float alpha_least; /* the smallest and largest alpha after repair; both 1 */
    float alpha_most;  /*   without alpha */
    size_t alpha_nonfinite; /* pixels whose alpha was Inf or NaN */
    size_t alpha_beyond;    /* pixels whose alpha was below 0 or above 1 */
    size_t alpha_hidden;    /* pixels that had lost their colour to alpha 0
                               although it was said to be multiplied by it */
} ibl_read_report;

/*
 * Reads an equirectangular map as linear RGB floats. The kind of file is told
 * by its content, never its name:
 *   Radiance .hdr  RGBE and XYZE (converted to RGB with the file's PRIMARIES
 *                  or the format's default ones), new and old run lengths and
 *                  flat, all eight orientations, EXPOSURE and COLORCORR
 *                  undone
 *   OpenEXR        scan lines and tiles (level 0), half, float and uint,
 *                  R G B, or Y, or Y RY BY; the display window is the map,
 *                  pixels outside the data window are black
 *   others         whatever OpenImageIO reads, and EXR compressions that
 *                  OpenEXRCore lacks, through the bridge: a shared object
 *                  opened only then. 8 and 16-bit integers are decoded from
 *                  sRGB.
 * Alpha is dropped and colours are what the file has, neither multiplied nor
 * divided by it; ibl_source_alpha has more.
 * Non-finite components become the largest finite one among the 8 neighbours
 * (columns wrap; 65504 if there is none and it was +Inf, else 0), negative
 * ones 0; both are counted and warned of.
 *   path     a file, or "-" for standard input; a pipe by name (a FIFO,
 *            /dev/stdin, what a shell makes of <(command)) is read if somebody
 *            has it open for writing, devices and directories are refused
 *   opts     NULL for defaults
 *   img      empty; filled, the caller's to free with ibl_image_free
 *   report   may be NULL
 * IBL_ERR_IO: cannot be opened or read. IBL_ERR_FORMAT: not an image,
 * corrupt, cut short, not 2:1 without any_aspect, mended pixels with strict.
 * IBL_ERR_UNSUPPORTED: needs the bridge, which is not there or cannot.
 * IBL_ERR_MEMORY: its pixels, or a file that is read as a whole, are more than
 * the machine's memory. A stream that goes on for over 1 MiB after the longest
 * that its header allows (Radiance), or ends beyond 65 GiB (other images) or
 * 256 MiB (anything else), is IBL_ERR_FORMAT.
 */
ibl_status ibl_image_read(ibl_ctx *ctx, const char *path,
                          const ibl_read_options *opts, ibl_image *img,
                          ibl_read_report *report);

/* The same from memory; name stands in messages. What the bridge's reader of
 * the format cannot read from memory goes through a temporary file that has
 * no name any more when it is read. */
ibl_status ibl_image_decode(ibl_ctx *ctx, const char *name, const void *bytes,
                            size_t size, const ibl_read_options *opts,
                            ibl_image *img, ibl_read_report *report);

/* Version of the OpenEXRCore that reads EXR here, as "3.1.5". */
const char *ibl_exr_version(void);
/* Where the image bridge is looked for by a context that was given none. */
const char *ibl_bridge_path(void);

/* ---- images in, row by row ------------------------------------------- */

/*
 * A map that is read from the zenith down, some rows at a time, so that it
 * never is in memory as a whole. What is in memory beside the rows of a call:
 *   Radiance .hdr  1 MiB of the file; the whole image where scanlines are
 *                  columns or run from the bottom
 *   OpenEXR        for each thread a block or tile, packed and unpacked; a
 *                  row of blocks or tiles, or as many as keep the threads at
 *                  work within 32 MiB; the whole image where RY and BY have
 *                  half the size
 *   others         the file, and a strip of 64 rows, or of a row of tiles
 *   pipes, standard input, files below 64 KiB: the file
 */
typedef struct ibl_source ibl_source;

/*
 * Opens what ibl_image_read reads and looks at its header; that the file is
 * whole is known only when all rows have been read.
 *   path   as in ibl_image_read; copied
 *   opts   NULL for defaults; not needed afterwards
 *   out    to be closed with ibl_source_close before ctx is freed; NULL after
 *          an error
 * Errors as those of ibl_image_read.
 */
ibl_status ibl_source_open(ibl_ctx *ctx, const char *path,
                           const ibl_read_options *opts, ibl_source **out);

int ibl_source_width(const ibl_source *source);
int ibl_source_height(const ibl_source *source);

/*
 * Reads the next rows, mended as ibl_image_read says: the same floats however
 * they are divided into calls. Runs on the context's pool; progress is told
 * as stage "decode".
 *   rows   1 to as many as are left, else IBL_ERR_ARGUMENT
 *   rgb    3 * width * rows floats
 * Errors as those of ibl_image_read; that strict reading refuses comes with
 * the last row, so nothing should be made of rows before all are there. After
 * an error other than IBL_ERR_ARGUMENT what rgb holds is unspecified, and each
 * later call has the same status.
 */
ibl_status ibl_source_read(ibl_source *source, int rows, float *rgb);

/*
 * Alpha, where the options ask for it and the file has it: width * height
 * floats from the zenith down, of which those of the rows that were read are
 * there; owned by source. NULL: there is none, and alpha is 1 everywhere.
 *
 * It is the channel A of the layer that colour is from (OpenEXR), or what
 * OpenImageIO says is alpha; never decoded from sRGB, which colours are before
 * they are multiplied by it. Outside an OpenEXR file's data window it is 0.
 * What is not finite becomes 0, as if nothing had been seen, and what is below
 * 0 or above 1 that; both are counted and warned of, and refused by strict.
 * Colours where alpha is 0 become 0: were they kept, what is divided by the
 * alpha of a neighbourhood would be brighter than anything in it.
 *
 * Takes 4 bytes of memory for each pixel of the map.
 */
const float *ibl_source_alpha(const ibl_source *source);

/* What was read: complete once all rows have been. Owned by source. */
const ibl_read_report *ibl_source_report(const ibl_source *source);

void ibl_source_close(ibl_source *source); /* NULL is fine */

/* ---- textures ------------------------------------------------------- */

typedef enum ibl_pixel {
    IBL_PIXEL_RGBA16F,    /* 8 bytes: 4 halves */
    IBL_PIXEL_RGBA32F,    /* 16 bytes: 4 floats */
    IBL_PIXEL_RGB9E5,     /* 4 bytes: 3 x 9 bits, shared 5-bit exponent */
    IBL_PIXEL_R11G11B10F, /* 4 bytes: unsigned floats of 11, 11, 10 bits */
    IBL_PIXEL_RG16F,      /* 4 bytes: 2 halves (the LUT) */
    IBL_PIXEL_RG32F,      /* 8 bytes: 2 floats (the LUT) */
    IBL_PIXEL_COUNT
} ibl_pixel;

/* "rgba16f", "rgba32f", "rgb9e5", "r11g11b10f", "rg16f", "rg32f". */
const char *ibl_pixel_name(ibl_pixel pixel);
/* Bytes of one texel. */
size_t ibl_pixel_bytes(ibl_pixel pixel);
/* Floats that one texel is encoded from and decoded to: 3 (RGB), 2 (RG). */
int ibl_pixel_channels(ibl_pixel pixel);
/* 1: it has alpha, too, which is encoded as 1: see ibl_texture_set_alpha. */
int ibl_pixel_has_alpha(ibl_pixel pixel);
/* Largest finite value the pixel's red holds: 65504, FLT_MAX, 65408, 65024. */
float ibl_pixel_max(ibl_pixel pixel);

/*
 * Encodes count texels of ibl_pixel_channels(pixel) floats each. Rounds to
 * nearest, ties to even (RGB9E5: as EXT_texture_shared_exponent says);
 * denormals are kept; values beyond the largest finite one, +Inf too, become
 * that, negative ones and NaN become 0 where the pixel has no sign (halves
 * and floats keep a sign, NaN becomes 0). Returns how many components were
 * beyond. dst: count * ibl_pixel_bytes(pixel) bytes, any alignment.
 */
size_t ibl_pixel_encode(ibl_pixel pixel, const float *src, size_t count,
                        void *dst);
/* The inverse; dst: count * ibl_pixel_channels(pixel) floats. Alpha is
 * dropped. */
void ibl_pixel_decode(ibl_pixel pixel, const void *src, size_t count,
                      float *dst);

typedef struct ibl_key_value {
    char *key;
    char *value;
} ibl_key_value;

/*
 * What OpenGL 4 and Direct3D 11 promise for arrays of flat textures. Of a cube
 * array they count the faces: where they take no more than they promise, 341
 * cubes can be uploaded as one.
 */
#define IBL_MAX_LAYERS 2048

/*
 * A texture in memory, as an API would upload it: levels from the largest, in
 * a level the layers, in a layer the faces, in a face the rows from the top,
 * no padding. Cubes have 6 faces in the order +X -X +Y -Y +Z -Z and width ==
 * height; flat textures 1 face. An array has layers, all of one shape; other
 * textures have 1. Zeroed is empty. Free with ibl_texture_free.
 */
typedef struct ibl_texture {
    ibl_pixel pixel;
    int width, height; /* of level 0, in texels, >= 1 */
    int levels;        /* >= 1 */
    int layers;        /* 1..IBL_MAX_LAYERS */
    int faces;         /* 6 or 1 */
    size_t bytes;      /* of data */
    unsigned char *data;
    int premultiplied;   /* 1: colours are multiplied by an alpha that is not 1
                            everywhere. KTX2 says so in its descriptor; KTX and
                            DDS have no place for it and are read back with 0 */
    ibl_key_value *keys; /* metadata, sorted by key, no key twice */
    int key_count;
} ibl_texture;

void ibl_texture_free(ibl_texture *tex); /* NULL and zeroed are fine */

/* Offset in bytes of a level's face in tex->data, of layer 0 or of any, and
 * its size. */
size_t ibl_texture_offset(const ibl_texture *tex, int level, int face);
size_t ibl_texture_layer_offset(const ibl_texture *tex, int level, int layer,
                                int face);
size_t ibl_texture_face_bytes(const ibl_texture *tex, int level);

/*
 * An array of textures that have pixel, size, levels and faces in common; of
 * those that are arrays themselves all layers follow one another. Copies.
 *   layers  count textures, count >= 1
 *   out     empty, to be freed with ibl_texture_free; it gets the keys that
 *           all have with the same value, and is premultiplied if one is.
 *           Empty after an error
 * IBL_ERR_ARGUMENT: one is no whole texture or differs from the first, or
 * there would be more than IBL_MAX_LAYERS.
 */
ibl_status ibl_texture_array(ibl_ctx *ctx, const ibl_texture *const *layers,
                             int count, ibl_texture *out);
/* A copy of one layer, with all keys. out: as above. IBL_ERR_ARGUMENT: tex
 * has no such layer or is no whole texture. */
ibl_status ibl_texture_layer(ibl_ctx *ctx, const ibl_texture *tex, int layer,
                             ibl_texture *out);
/*
 * An array that is filled layer by layer, so that there need be one layer
 * besides at a time: begin makes it (out: as above, without keys) for `layers`
 * ones of the shape of tex, texels undefined, and put copies tex into one.
 * IBL_ERR_ARGUMENT: tex is no whole texture of one layer, or differs from the
 * array, or the array has no such layer or more than IBL_MAX_LAYERS.
 */
ibl_status ibl_texture_array_begin(ibl_ctx *ctx, const ibl_texture *tex,
                                   int layers, ibl_texture *out);
ibl_status ibl_texture_array_put(ibl_ctx *ctx, ibl_texture *array, int layer,
                                 const ibl_texture *tex);

/* Sets a key to a value (both copied; UTF-8, key 1..255 bytes, at most 4096
 * keys, else IBL_ERR_ARGUMENT). */
ibl_status ibl_texture_set(ibl_ctx *ctx, ibl_texture *tex, const char *key,
                           const char *value);
/* The value of a key, owned by tex; NULL if it is not there. */
const char *ibl_texture_get(const ibl_texture *tex, const char *key);

/*
 * What becomes of light in texels of a cube that are brighter than the largest
 * value of their pixel.
 *   SPREAD  What they have too much goes to the texels around them, each
 *           channel for itself, from the brightest texel down (the first of
 *           equals): to the ring around all full texels that hang together
 *           with it, over the cube's edges too; then, while some is left, to
 *           the ring around that. A level keeps its mean radiance by solid
 *           angle, but for the rounding to the pixel and for what it cannot
 *           hold as a whole. Nothing becomes darker. Levels are on their own.
 *   CLIP    They become the largest value; what they had more is lost.
 * Either way Inf becomes the largest value and counts as that.
 */
typedef enum ibl_overflow {
    IBL_OVERFLOW_SPREAD,
    IBL_OVERFLOW_CLIP
} ibl_overflow;

/* "spread" or "clip". */
const char *ibl_overflow_name(ibl_overflow overflow);

/* Of a level: how many texels had a component beyond the largest value, and
 * what share of the light of all texels (R + G + B, by solid angle) went to
 * others or is lost. */
typedef struct ibl_overflow_level {
    size_t texels;
    double moved, lost;
} ibl_overflow_level;

typedef struct ibl_overflow_report {
    size_t values; /* components beyond the largest value, of all levels */
    ibl_overflow_level level[IBL_MAX_LEVELS];
} ibl_overflow_report;

/*
 * Cube or LUT to texture and back. A cube takes the four 3-channel pixels, a
 * LUT the two 2-channel ones, else IBL_ERR_ARGUMENT. report may be NULL;
 * *saturated, if not NULL, is the count of ibl_pixel_encode. Where nothing is
 * beyond the largest value, overflow is without effect and costs nothing; else
 * spreading takes 17 bytes of memory for each texel of a level meanwhile.
 * Decoding gives IBL_ERR_ARGUMENT for a texture of the other kind, and for an
 * array of more than one layer: ibl_texture_layer takes one out.
 */
ibl_status ibl_texture_from_cube(ibl_ctx *ctx, const ibl_cube *cube,
                                 ibl_pixel pixel, ibl_overflow overflow,
                                 ibl_texture *tex, ibl_overflow_report *report);
ibl_status ibl_texture_from_lut(ibl_ctx *ctx, const ibl_lut *lut,
                                ibl_pixel pixel, ibl_texture *tex,
                                size_t *saturated);
ibl_status ibl_texture_to_cube(ibl_ctx *ctx, const ibl_texture *tex,
                               ibl_cube *cube);
ibl_status ibl_texture_to_lut(ibl_ctx *ctx, const ibl_texture *tex,
                              ibl_lut *lut);

/*
 * Alpha of a cube's texels, with colours that are multiplied by it already.
 * Takes the red of each texel of alpha, which has the shape of tex: what is
 * below 0 or NaN as 0, above 1 as 1. Makes tex premultiplied.
 * IBL_ERR_ARGUMENT: tex is no cube of one layer, its pixels have no alpha
 * (ibl_pixel_has_alpha), or alpha has another shape; tex is untouched.
 */
ibl_status ibl_texture_set_alpha(ibl_ctx *ctx, ibl_texture *tex,
                                 const ibl_cube *alpha);
/* The inverse: alpha in all three components; 1 where pixels have none. alpha:
 * empty, to be freed with ibl_cube_free. Errors as of ibl_texture_to_cube. */
ibl_status ibl_texture_get_alpha(ibl_ctx *ctx, const ibl_texture *tex,
                                 ibl_cube *alpha);

typedef enum ibl_container {
    IBL_CONTAINER_KTX2, /* Khronos KTX 2.0, no supercompression */
    IBL_CONTAINER_KTX,  /* Khronos KTX 1.1, little endian */
    IBL_CONTAINER_DDS,  /* DDS with the DX10 header; no key/values */
    IBL_CONTAINER_COUNT
} ibl_container;

/* "ktx2", "ktx", "dds": the name and the file extension. */
const char *ibl_container_name(ibl_container container);

/*
 * The bytes of a file of that kind. *bytes is the caller's to free with
 * ibl_bytes_free. KTX2 and KTX get KTXorientation and KTXwriter; tex's own
 * keys follow, but for those two. DDS has no room for keys and drops them.
 * A texture of one layer is written as no array.
 * IBL_ERR_ARGUMENT: tex is no whole texture. IBL_ERR_UNSUPPORTED: KTX and a
 * face of 4 GiB, or a level of 4 GiB of an array.
 */
ibl_status ibl_texture_encode(ibl_ctx *ctx, const ibl_texture *tex,
                              ibl_container container, void **bytes,
                              size_t *size);
void ibl_bytes_free(void *bytes);
/* Gives the same bytes to fn, piece by piece in their order, without a copy of
 * the texels in memory. */
typedef void ibl_bytes_fn(void *cookie, const void *bytes, size_t size);
ibl_status ibl_texture_visit(ibl_ctx *ctx, const ibl_texture *tex,
                             ibl_container container, ibl_bytes_fn *fn,
                             void *cookie);

/*
 * Reads a KTX2, KTX or DDS file (told by content) of our pixel formats: cube
 * or 2D or an array of either, with or without levels, either byte order for
 * KTX. KTX and KTX2 files of 3-channel 16 or 32-bit floats are widened to 4.
 * What we write is read back bit for bit, keys included. More layers than
 * IBL_MAX_LAYERS, 3D, other pixel formats and supercompression give
 * IBL_ERR_UNSUPPORTED with the name or number of what was found; a damaged
 * file IBL_ERR_FORMAT. Never reads outside [bytes, size),
 * and allocates little more than size. DDS files may also name a float format
 * of Direct3D 9 in place of a FourCC, and hold RGB floats.
 * Keys: those whose value is text; KTXwriter comes along, KTXorientation does
 * not: rows are turned to begin at the top where a flat texture says that
 * they do not, a cube that says so is IBL_ERR_UNSUPPORTED.
 *   container   may be NULL
 */
ibl_status ibl_texture_decode(ibl_ctx *ctx, const char *name, const void *bytes,
                              size_t size, ibl_texture *tex,
                              ibl_container *container);
/* The same from a file, standard input or pipe as ibl_image_read takes them.
 * IBL_ERR_IO: cannot be opened or read. */
ibl_status ibl_texture_read(ibl_ctx *ctx, const char *path, ibl_texture *tex,
                            ibl_container *container);

/* ---- files that appear together or not at all ------------------------ */

/*
 * A set of output files. Each is written to a temporary beside its target
 * (".NAME.iblbake-PID-N.tmp", mode 0666 & ~umask); commit renames them all,
 * abort removes them and any directory that was made for them. Until commit
 * nothing old is touched. What a program's failure, a signal or a full disk
 * leaves is all of the set, or nothing and what was there before.
 *
 * A crash of the system or a power cut is another matter: as with any file
 * that a program writes, what the system has not brought to the disk by then
 * (it takes about half a minute) is lost, and a new file may be found empty
 * or short where an old one was. ibl_outputs_sync is against that.
 *
 * A target that is a symbolic link is followed: the file that it names is
 * replaced, or made. Other things than files (directories, devices, pipes)
 * and files that may not be written are refused with IBL_ERR_IO, and nothing
 * has happened to them.
 *
 * A path has at most 4031 bytes. Relative ones hold as long as the working
 * directory stays. Where RLIMIT_FSIZE is set, a program that wants a status
 * and not a signal ignores SIGXFSZ.
 */
typedef struct ibl_outputs ibl_outputs;

#define IBL_MAX_OUTPUTS 512    /* files in one set */
#define IBL_MAX_OUTPUT_DIRS 64 /* directories made for it */

/* An empty set; it uses ctx for messages and to see a cancel. */
ibl_status ibl_outputs_create(ibl_ctx *ctx, ibl_outputs **out);
/*
 * 1: add and wait bring the files to the disk, commit the directories, before
 * they return; a power cut during commit may leave some files old and some
 * new, each whole. Takes as long as the disk does. 0 (default): neither. Asked
 * for before the first add.
 */
void ibl_outputs_sync(ibl_outputs *out, int sync);
/* Makes directory path with its parents where missing (mode 0777 & ~umask).
 * IBL_ERR_IO: cannot be made, or is there and no directory. */
ibl_status ibl_outputs_mkdir(ibl_outputs *out, const char *path);
/*
 * Writes a file of the set. bytes is not needed afterwards. IBL_ERR_IO: not
 * writable, disk full, or the target cannot be replaced. IBL_ERR_ARGUMENT:
 * the set is full, aborted or has the target already (by whatever path), or
 * path is too long. After an error the set is as before.
 */
ibl_status ibl_outputs_add(ibl_outputs *out, const char *path,
                           const void *bytes, size_t size);
/*
 * Writes a texture as a file of the set: the bytes of ibl_texture_encode,
 * without a second copy of its texels in memory. tex is not needed afterwards.
 * The errors of both; size, if not NULL, is the file's.
 */
ibl_status ibl_outputs_add_texture(ibl_outputs *out, const char *path,
                                   const ibl_texture *tex,
                                   ibl_container container, size_t *size);
/*
 * The same, but takes tex over: it is empty afterwards, whatever the status.
 * The file may still be written when this returns, on a thread of the context,
 * one file at a time; what then goes wrong is what ibl_outputs_wait or
 * ibl_outputs_commit returns, and the set is aborted.
 */
ibl_status ibl_outputs_take_texture(ibl_outputs *out, const char *path,
                                    ibl_texture *tex, ibl_container container,
                                    size_t *size);
/* Waits until all that was added is written. */
ibl_status ibl_outputs_wait(ibl_outputs *out);
/*
 * Renames every file to its target. The set is empty then and may be used
 * again. If one cannot be renamed, those that were are taken back, old files
 * return to their places, the set is aborted and the status is IBL_ERR_IO.
 * (Only on a file system that cannot exchange two names, such as NFS or FAT,
 * an old file that was replaced before the failure stays replaced.)
 */
ibl_status ibl_outputs_commit(ibl_outputs *out);
/*
 * Removes what was not committed, and directories made for the set that are
 * empty; in the midst of a commit it takes that back as above. Makes only
 * system calls: safe in a signal handler on any thread, after which the
 * program should end; errno is kept. Nothing can be added afterwards. NULL is
 * fine.
 */
void ibl_outputs_abort(ibl_outputs *out);
void ibl_outputs_free(ibl_outputs *out); /* aborts first; NULL is fine */

#ifdef __cplusplus
}
#endif

#endif
