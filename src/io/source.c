/* SPDX-License-Identifier: MIT */
#include <ctype.h>
#include <float.h>
#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "core/alloc.h"
#include "core/context.h"
#include "io/input.h"
#include "io/layout.h"
#include "io/mend.h"
#include "io/rows.h"

enum {
    BRIDGE_BYTES = 150 << 20, /* OpenImageIO and its libraries */
    IMAGE_ROWS = 512,         /* of an image that are read at once */
    SNIFF_BYTES = 64          /* enough to identify the kind of a file */
};

struct ibl_source {
    ibl_ctx *ctx;
    ibl_input in;
    ibl_rows *rows;
    ibl_mender mender;
    bool mended;       /* the rows are of mended pixels of another layout */
    ibl_status status; /* of the first read that failed */
    char name[];
};

ibl_read_options ibl_read_options_default(void)
{
    return (ibl_read_options){.part = -1};
}

/* ---- the kind of a file --------------------------------------------- */

static bool is_jpeg(const unsigned char *bytes, size_t size)
{
    return size > 3 && !memcmp(bytes, "\xff\xd8\xff", 3);
}

static bool is_other(const unsigned char *bytes, size_t size)
{
    (void)bytes;
    return size > 0;
}

static const struct {
    ibl_is_fn *is;
    ibl_open_fn *open;
} readers[] = {
    {ibl_rgbe_is, ibl_rgbe_open},       {ibl_exr_is, ibl_exr_open},
    {ibl_texture_is, ibl_texture_open}, {is_jpeg, ibl_jpeg_open},
    {is_other, ibl_other_image_open},
};

static ibl_status check_input(const ibl_input *in, const ibl_read_options *opts,
                              const unsigned char *first, size_t size)
{
    if ((opts->layer || opts->part > 0) && !ibl_exr_is(first, size))
        return ibl_bad_file(
            in, "has no %s: only OpenEXR files do, so do not ask for one",
            opts->layer ? "layers" : "parts");
    if (opts->layout == IBL_INPUT_FACES)
        return ibl_bad_file(in, "is one file; six of faces are named by a "
                                "pattern with %%f or a list with commas");
    if (opts->layout == IBL_INPUT_CUBE && !ibl_exr_is(first, size) &&
        !ibl_texture_is(first, size))
        return ibl_bad_file(
            in, "is no texture that can be read, KTX2, KTX or DDS, where the "
                "layout cube was asked for");
    return IBL_OK;
}

ibl_status ibl_rows_open(ibl_input *in, const ibl_read_options *opts,
                         ibl_rows **rows)
{
    unsigned char first[SNIFF_BYTES];
    size_t size, i = 0;

    if (!ibl_input_read(in, 0, sizeof first, first, &size) || !size)
        return ibl_reject(in, IBL_ERR_IO, "cannot be read");
    while (!readers[i].is(first, size))
        i++;
    ibl_status status = check_input(in, opts, first, size);
    if (!status)
        status = readers[i].open(in, opts, rows);
    if (status)
        return status;
    const ibl_rows *r = *rows;
    if (r->report.layout == IBL_INPUT_CUBE && opts->layout &&
        opts->layout != IBL_INPUT_CUBE)
        return ibl_bad_file(in, "is a cube, not in the layout %s",
                            ibl_input_layout_name(opts->layout));
    if (opts->transfer && !r->report.low_range)
        return ibl_bad_file(in, "holds floats, which are linear: leave out the "
                                "option input-transfer");
    return r->orientation > 1 && r->orientation <= 8
               ? ibl_rows_upright(in, rows)
               : IBL_OK;
}

/* ---- names of six files ---------------------------------------------- */

/* Names of the faces in the order +X -X +Y -Y +Z -Z, for files also with a
 * capital or in capitals. Where a program turns some of its faces, they do not
 * meet, which is warned of. */
static const char *const face_names[][IBL_FACES] = {
    {"px", "nx", "py", "ny", "pz", "nz"},
    {"posx", "negx", "posy", "negy", "posz", "negz"},
    {"posX", "negX", "posY", "negY", "posZ", "negZ"},
    {"+x", "-x", "+y", "-y", "+z", "-z"},
    {"right", "left", "top", "bottom", "front", "back"},
    {"right", "left", "up", "down", "front", "back"},
    {"rt", "lf", "up", "dn", "ft", "bk"},
    {"r", "l", "u", "d", "f", "b"},
    {"c00", "c01", "c02", "c03", "c04", "c05"}, /* HDRShop's */
    {"0", "1", "2", "3", "4", "5"},
    {"1", "2", "3", "4", "5", "6"},
};

enum {
    SETS = sizeof face_names / sizeof *face_names,
    WAYS = 3 /* as above, with a capital, in capitals */
};

static char *joined(const char *a, size_t length, const char *b, const char *c)
{
    char *text = ibl_alloc_array(length + strlen(b) + strlen(c) + 1, 1);

    if (text)
        sprintf(text, "%.*s%s%s", (int)length, a, b, c);
    return text;
}

/* The %f of a pattern, which no letter or digit follows; NULL: none. */
static const char *find_pattern(const char *path)
{
    const char *at = strstr(path, "%f");

    while (at && isalnum((unsigned char)at[2]))
        at = strstr(at + 2, "%f");
    return at;
}

/* path with the name of a face in place of the %f at `at`. set: of names, in
 * one of the ways. */
static char *replaced(const char *path, const char *at, int set, int face)
{
    char name[16];

    strcpy(name, face_names[set / WAYS][face]);
    for (int i = 0; name[i] && (set % WAYS == 2 || i < set % WAYS); i++)
        name[i] = (char)toupper((unsigned char)name[i]);
    return joined(path, (size_t)(at - path), name, at + 2);
}

/* The first set of names that most files have; SETS * WAYS: no file has any. */
static int find_set(const char *path, const char *at)
{
    int best = SETS * WAYS, most = 0;

    for (int set = 0; set < SETS * WAYS && most < IBL_FACES; set++) {
        int count = 0;
        for (int f = 0; f < IBL_FACES; f++) {
            char *file = replaced(path, at, set, f);
            count += file && !access(file, F_OK);
            ibl_free(file);
        }
        if (count > most)
            best = set;
        most = count > most ? count : most;
    }
    return best;
}

ibl_status ibl_input_files(ibl_ctx *ctx, const char *path,
                           char *files[IBL_FACES], int *count)
{
    int commas = 0, set = 0;

    if (!ctx || !path || !files || !count)
        return ibl_missing(ctx, "ibl_input_files: path, files or count");
    for (const char *c = path; *c; c++)
        commas += *c == ',';
    const char *at = find_pattern(path);
    const bool one = !access(path, F_OK) || (!at && commas != 5);
    if (!one && at)
        set = find_set(path, at);
    for (int f = 0; f < IBL_FACES; f++)
        files[f] = NULL;
    if (set == SETS * WAYS)
        return ibl_fail(ctx, IBL_ERR_IO,
                        "%s: no file has px, posx, +x, right, rt, c00 or 0 in "
                        "place of %%f",
                        path);
    *count = one ? 1 : IBL_FACES;
    for (int f = 0; f < *count; f++) {
        const size_t length = strcspn(path, one || at ? "" : ",");
        files[f] = !one && at ? replaced(path, at, set, f)
                              : joined(path, length, "", "");
        if (!files[f]) {
            ibl_input_files_free(files);
            return ibl_no_memory(ctx, "names of files");
        }
        if (path[length])
            path += length + 1;
    }
    return IBL_OK;
}

void ibl_input_files_free(char *files[IBL_FACES])
{
    for (int f = 0; f < IBL_FACES; f++) {
        ibl_free(files[f]);
        files[f] = NULL;
    }
}

/* ---- six files ------------------------------------------------------ */

/* Reads a face behind those before it in the strip of all, of which it makes
 * the rows if it is the first. Alpha of the faces before the first with any is
 * 1. */
static ibl_status read_face(ibl_input *in, const ibl_read_options *opts,
                            int face, ibl_rows **face_rows, ibl_rows **all)
{
    ibl_status status = ibl_rows_open(in, opts, face_rows);
    const ibl_rows *r = *face_rows;
    ibl_image strip = {0};

    if (status)
        return status;
    const int n = r->width;
    const size_t texels = (size_t)n * (size_t)n, at = (size_t)face * texels;
    if (n != r->height || n > IBL_MAX_CUBE_SIZE)
        return ibl_bad_file(in, "%dx%d pixels: a face is square, %d at most", n,
                            r->height, IBL_MAX_CUBE_SIZE);
    if (*all && n != (*all)->width)
        return ibl_bad_file(in, "%d pixels wide, but the faces before it %d", n,
                            (*all)->width);
    if (!*all) {
        status = ibl_map_alloc(in, n, IBL_FACES * n, &strip);
        if (!status)
            status = ibl_rows_of_image(in->ctx, &strip, r, all);
        if (status)
            return status;
        (*all)->report.layout = IBL_INPUT_FACES;
    }
    ibl_rows *s = *all;
    status = ibl_rows_read(*face_rows, n, s->whole.data + 3 * at);
    if (!status && r->alpha && !s->alpha) {
        status = ibl_rows_alloc_alpha(s);
        for (size_t i = 0; i < IBL_FACES * texels && !status; i++)
            s->alpha[i] = 1;
    }
    if (!status && r->alpha)
        memcpy(s->alpha + at, r->alpha, texels * sizeof *s->alpha);
    s->report.bridged |= r->report.bridged;
    if (r->report.low_range)
        s->report.low_range = r->report.low_range;
    return status;
}

/* Reads six files, one for each face, into rows of the faces one below the
 * other, as ibl_open_fn says. Their format, primaries and kind of alpha are the
 * first file's. name: of all of them, for messages. */
static ibl_status open_six_files(ibl_ctx *ctx, const char *name,
                                 char *const files[IBL_FACES],
                                 const ibl_read_options *opts, ibl_rows **out)
{
    const size_t digits = IBL_FILE_HASH - 1;
    char hashes[IBL_FACES * (IBL_FILE_HASH - 1) + 1];
    ibl_read_options flat = *opts;
    ibl_status status = IBL_OK;

    flat.layout = IBL_INPUT_EQUIRECT; /* as they are */
    flat.any_aspect = 1;
    if (opts->layout && opts->layout != IBL_INPUT_FACES)
        status = ibl_fail(ctx, IBL_ERR_FORMAT,
                          "%s: are files of faces, not in the layout %s", name,
                          ibl_input_layout_name(opts->layout));
    for (int f = 0; f < IBL_FACES && !status; f++) {
        ibl_input in;
        ibl_rows *rows = NULL;
        status = ibl_input_open(ctx, files[f], &in);
        if (status)
            break;
        if (opts->hash)
            status = ibl_file_hash(&in, hashes + digits * (size_t)f);
        if (!status)
            status = read_face(&in, &flat, f, &rows, out);
        ibl_rows_close(rows);
        ibl_input_close(&in);
    }
    if (status || !opts->hash)
        return status;
    const ibl_input all = ibl_input_of(ctx, name, hashes, IBL_FACES * digits);
    return ibl_file_hash(&all, (*out)->report.hash);
}

/* ---- opening -------------------------------------------------------- */

static bool is_ordered(const ibl_read_options *opts)
{
    return opts->face_order[0] + opts->face_order[1] > 0;
}

static ibl_status check_options(ibl_ctx *ctx, const ibl_read_options *opts)
{
    unsigned found = 0;

    if (opts->part < -1)
        return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                        "part %d: must be -1 or the number of a part, from 0",
                        opts->part);
    if (opts->alpha > IBL_ALPHA_STRAIGHT ||
        opts->primaries > IBL_PRIMARIES_REC2020 ||
        opts->layout > IBL_INPUT_OCTAHEDRAL ||
        opts->transfer > IBL_TRANSFER_SRGB)
        return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                        "alpha %d, primaries %d, layout %d or transfer %d: not "
                        "one of the values that there are",
                        (int)opts->alpha, (int)opts->primaries,
                        (int)opts->layout, (int)opts->transfer);
    if (!(fabs(opts->exposure) <= IBL_MAX_EXPOSURE))
        return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                        "an exposure of %g: must be from -%d to %d",
                        opts->exposure, IBL_MAX_EXPOSURE, IBL_MAX_EXPOSURE);
    if (!(opts->clamp >= 0) || !isfinite(opts->clamp))
        return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                        "a clamp of %g: must be above 0, or 0 for none",
                        opts->clamp);
    for (int i = 0; i < IBL_FACES; i++)
        found |= opts->face_order[i] < 8 * IBL_FACES
                     ? 1u << opts->face_order[i] % IBL_FACES
                     : 0;
    if (is_ordered(opts) && found != (1u << IBL_FACES) - 1)
        return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                        "face order: must have each of six faces once");
    return IBL_OK;
}

ibl_status ibl_source_image(ibl_source *s, ibl_image *img)
{
    if (!s || !img)
        return ibl_missing(s ? s->ctx : NULL, "ibl_source_image: img");
    ibl_rows *rows = s->rows;
    ibl_image all = rows->whole;
    ibl_status status = IBL_OK;

    if (!all.data)
        status = ibl_map_alloc(&s->in, rows->width, rows->height, &all);
    while (!status && rows->row < all.height) {
        const int left = all.height - rows->row;
        status = ibl_source_read(s, left < IMAGE_ROWS ? left : IMAGE_ROWS,
                                 all.data +
                                     3 * (size_t)all.width * (size_t)rows->row);
    }
    if (!status)
        *img = all;
    else if (!rows->whole.data)
        ibl_image_free(&all);
    if (!status)
        rows->whole = (ibl_image){0};
    return status;
}

/* Makes the map of alpha, in the memory of the file's colours. */
static ibl_status unwrap_alpha(const ibl_source *s,
                               const unsigned char order[IBL_FACES],
                               ibl_cube *faces, ibl_image *grey, float **alpha)
{
    const size_t pixels = (size_t)grey->width * (size_t)grey->height;
    ibl_image map = {0};

    for (size_t i = 0; i < 3 * pixels; i++)
        grey->data[i] = s->rows->alpha[i / 3];
    const ibl_status status = ibl_unwrap(s->ctx, NULL, s->rows->report.layout,
                                         order, grey, faces, &map);
    for (size_t i = 0; i < (size_t)map.width * (size_t)map.height; i++)
        map.data[i] = map.data[3 * i];
    *alpha = map.data;
    return status;
}

/* Replaces the rows of another layout by those of its map. */
static ibl_status unwrap(ibl_source *s, const ibl_read_options *opts)
{
    ibl_rows *rows = s->rows;
    const unsigned char *order =
        is_ordered(opts) ? opts->face_order : rows->face_order;
    ibl_image flat = {0}, map = {0};
    float *alpha = NULL;
    ibl_rows *made = NULL;
    ibl_status status = ibl_source_image(s, &flat);

    if (!status && rows->to_edges)
        status = ibl_faces_from_edges(s->ctx, &flat);
    if (!status)
        status = ibl_unwrap(s->ctx, s->in.name, rows->report.layout, order,
                            &flat, opts->faces, &map);
    for (size_t i = 0; i < 3 * (size_t)map.width * (size_t)map.height; i++)
        if (!isfinite(map.data[i])) /* a sum of the largest floats */
            map.data[i] = FLT_MAX;
    if (!status && rows->alpha)
        status = unwrap_alpha(s, order, opts->faces ? opts->faces + 1 : NULL,
                              &flat, &alpha);
    ibl_image_free(&flat);
    if (status)
        ibl_image_free(&map);
    else
        status = ibl_rows_of_image(s->ctx, &map, rows, &made);
    if (status) {
        ibl_free(alpha);
        return status;
    }
    made->alpha = alpha;
    ibl_rows_close(rows);
    ibl_input_close(&s->in);
    s->rows = made;
    s->mended = true;
    return IBL_OK;
}

/* Opens the rows, as they are in the file or files. */
static ibl_status open_rows(ibl_source *s, const ibl_pixels *pixels,
                            const ibl_read_options *opts)
{
    char *files[IBL_FACES] = {NULL};
    int count = 1;
    ibl_status status = IBL_OK;

    if (pixels)
        return ibl_rows_of_pixels(&s->in, pixels, opts, &s->rows);
    if (!s->in.bytes)
        status = ibl_input_files(s->ctx, s->name, files, &count);
    if (!status && count == IBL_FACES)
        status = open_six_files(s->ctx, s->name, files, opts, &s->rows);
    else if (!status && !s->in.bytes)
        status = ibl_input_open(s->ctx, s->name, &s->in);
    if (!status && count == 1)
        status = ibl_rows_open(&s->in, opts, &s->rows);
    if (!status && count == 1 && opts->hash)
        status = ibl_file_hash(&s->in, s->rows->report.hash);
    ibl_input_files_free(files);
    return status;
}

/* memory: NULL, or the bytes of a file, which stay until all rows are read. */
static ibl_status open_source(ibl_ctx *ctx, const char *name,
                              const ibl_input *memory, const ibl_pixels *pixels,
                              const ibl_read_options *given, ibl_source **out)
{
    const ibl_read_options opts = given ? *given : ibl_read_options_default();
    const size_t name_bytes = strlen(name) + 1;
    ibl_status status = check_options(ctx, &opts);

    if (!status && pixels &&
        (opts.layer || opts.part > 0 || opts.hash || opts.transfer))
        status =
            ibl_fail(ctx, IBL_ERR_ARGUMENT,
                     "%s: pixels have no layer, part, hash or transfer", name);
    if (status)
        return status;
    ibl_source *s = ibl_alloc_zeroed(1, sizeof *s + name_bytes);
    if (!s)
        return ibl_no_memory(ctx, "a source");
    memcpy(s->name, name, name_bytes);
    s->ctx = ctx;
    s->in = memory ? *memory : ibl_input_of(ctx, s->name, NULL, 0);
    ibl_progress(ctx, "decode", 0);
    status = open_rows(s, pixels, &opts);
    ibl_rows *rows = s->rows;
    ibl_read_report *report = status ? NULL : &rows->report;
    if (!status && !report->layout)
        report->layout = ibl_input_layout_of(&opts, rows->width, rows->height);
    if (!status)
        status = ibl_mender_init(&s->mender, &s->in, rows, &opts);
    if (!status && rows->whole.data)
        ibl_input_close(&s->in);
    const ibl_input_layout layout = status ? IBL_INPUT_AUTO : report->layout;
    if ((layout == IBL_INPUT_EQUIRECT || layout == IBL_INPUT_OCTAHEDRAL) &&
        is_ordered(&opts))
        status = ibl_bad_file(&s->in,
                              "is %s, which has no faces to order: leave out "
                              "the option face-order",
                              ibl_input_layout_name(layout));
    if (!status && layout != IBL_INPUT_EQUIRECT)
        status = unwrap(s, &opts);
    if (status)
        ibl_source_close(s);
    else
        *out = s;
    return status;
}

ibl_status ibl_source_open(ibl_ctx *ctx, const char *path,
                           const ibl_read_options *opts, ibl_source **out)
{
    if (!ctx || !path || !out)
        return ibl_missing(ctx, "ibl_source_open: path or out");
    *out = NULL;
    return open_source(ctx, path, NULL, NULL, opts, out);
}

ibl_status ibl_source_of_pixels(ibl_ctx *ctx, const char *name,
                                const ibl_pixels *pixels,
                                const ibl_read_options *opts, ibl_source **out)
{
    const ibl_pixels *p = pixels;

    if (!ctx || !name || !p || !p->data || !out)
        return ibl_missing(ctx, "ibl_source_of_pixels: name, pixels or out");
    *out = NULL;
    const size_t row =
        p->row_bytes < 0 ? 0 - (size_t)p->row_bytes : (size_t)p->row_bytes;
    if ((p->channels != 3 && p->channels != 4) || (unsigned)p->half > 1 ||
        p->width < 1 || p->height < 1 ||
        (row &&
         (row < (size_t)p->width * (size_t)p->channels * (p->half ? 2 : 4) ||
          row > PTRDIFF_MAX / (size_t)p->height)))
        return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                        "%s: %dx%d pixels, %d channels, half %d, row_bytes "
                        "%td: must be 1x1 or more, 3 or 4, 0 or 1, and 0 or "
                        "what holds a row",
                        name, p->width, p->height, p->channels, p->half,
                        p->row_bytes);
    return open_source(ctx, name, NULL, p, opts, out);
}

void ibl_source_close(ibl_source *source)
{
    if (!source)
        return;
    ibl_mender_free(&source->mender);
    ibl_rows_close(source->rows);
    ibl_input_close(&source->in);
    ibl_free(source);
}

/* ---- reading -------------------------------------------------------- */

/* Beside the reader's, the bytes of a file in memory, alpha, and 4 MiB of
 * buffers. */
size_t ibl_source_memory(const ibl_source *source)
{
    const ibl_rows *r = source->rows;
    const double pixels = (double)r->width * (double)r->height;
    const double each =
        r->held + (r->whole.data ? 12 : 0) + (r->alpha ? sizeof(float) : 0);

    return (size_t)(pixels * each) + (4 << 20) +
           (r->report.bridged ? BRIDGE_BYTES : 0) +
           (source->in.bytes ? source->in.size : 0);
}

int ibl_source_width(const ibl_source *source)
{
    return source->rows->width;
}

int ibl_source_height(const ibl_source *source)
{
    return source->rows->height;
}

const float *ibl_source_alpha(const ibl_source *source)
{
    return source->rows->alpha;
}

const ibl_read_report *ibl_source_report(const ibl_source *source)
{
    return &source->rows->report;
}

ibl_status ibl_source_read(ibl_source *source, int rows, float *rgb)
{
    ibl_source *s = source;

    if (!s || !rgb)
        return ibl_missing(s ? s->ctx : NULL, "ibl_source_read: rgb");
    if (s->status)
        return s->status;
    const int left = s->rows->height - s->rows->row;
    if (rows < 1 || rows > left)
        return ibl_fail(s->ctx, IBL_ERR_ARGUMENT,
                        "%d rows: must be 1 to the %d that are left", rows,
                        left);
    s->status = s->mended ? ibl_rows_read(s->rows, rows, rgb)
                          : ibl_mender_read(&s->mender, rows, rgb);
    if (!s->status)
        ibl_progress(s->ctx, "decode", (double)s->rows->row / s->rows->height);
    return s->status;
}

static ibl_status read_source(void *cookie, int rows, float *rgb)
{
    return ibl_source_read(cookie, rows, rgb);
}

ibl_environment ibl_source_environment(ibl_source *source)
{
    return (ibl_environment){.width = source->rows->width,
                             .height = source->rows->height,
                             .read = read_source,
                             .cookie = source};
}

/* ---- whole images --------------------------------------------------- */

/* Reads all rows of a source and closes it. */
static ibl_status read_all(ibl_source *source, ibl_image *img,
                           ibl_read_report *report)
{
    const ibl_status status = ibl_source_image(source, img);

    if (report)
        *report = source->rows->report;
    ibl_source_close(source);
    return status;
}

ibl_status ibl_image_decode(ibl_ctx *ctx, const char *name, const void *bytes,
                            size_t size, const ibl_read_options *opts,
                            ibl_image *img, ibl_read_report *report)
{
    ibl_source *source;
    if (!ctx || !name || (!bytes && size) || !img)
        return ibl_missing(ctx, "ibl_image_decode: name, bytes or img");
    if (!size)
        return ibl_fail(ctx, IBL_ERR_FORMAT, "%s: is empty", name);
    const ibl_input memory = ibl_input_of(ctx, name, bytes, size);
    const ibl_status status =
        open_source(ctx, name, &memory, NULL, opts, &source);
    return status ? status : read_all(source, img, report);
}

ibl_status ibl_image_read(ibl_ctx *ctx, const char *path,
                          const ibl_read_options *opts, ibl_image *img,
                          ibl_read_report *report)
{
    ibl_source *source;
    if (!ctx || !img)
        return ibl_missing(ctx, "ibl_image_read: img");
    const ibl_status status = ibl_source_open(ctx, path, opts, &source);
    return status ? status : read_all(source, img, report);
}
