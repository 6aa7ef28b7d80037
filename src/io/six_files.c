/* SPDX-License-Identifier: MIT */
#include "io/layout.h"

#include <ctype.h>
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "core/alloc.h"
#include "core/context.h"
#include "io/input.h"
#include "io/rows.h"

/* ---- names ------------------------------------------------------------- */

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

/* The part of a list before its next comma; *list moves behind the comma. */
static char *next_of(const char **list)
{
    const size_t length = strcspn(*list, ",");
    char *text = joined(*list, length, "", "");

    *list += length + ((*list)[length] == ',');
    return text;
}

static int count_commas(const char *path)
{
    int count = 0;

    for (; *path; path++)
        count += *path == ',';
    return count;
}

ibl_status ibl_input_files(ibl_ctx *ctx, const char *path,
                           char *files[IBL_FACES], int *count)
{
    if (!ctx || !path || !files || !count)
        return ibl_missing(ctx, "ibl_input_files: path, files or count");
    const char *at = find_pattern(path);
    const bool one = !access(path, F_OK) || (!at && count_commas(path) != 5);
    const int set = one || !at ? 0 : find_set(path, at);

    for (int f = 0; f < IBL_FACES; f++)
        files[f] = NULL;
    if (set == SETS * WAYS)
        return ibl_fail(ctx, IBL_ERR_IO,
                        "%s: no file has px, posx, +x, right, rt, c00 or 0 in "
                        "place of %%f",
                        path);
    *count = one ? 1 : IBL_FACES;
    for (int f = 0; f < *count; f++) {
        files[f] = one  ? joined(path, strlen(path), "", "")
                   : at ? replaced(path, at, set, f)
                        : next_of(&path);
        if (!files[f])
            break;
    }
    if (files[*count - 1])
        return IBL_OK;
    ibl_input_files_free(files);
    return ibl_no_memory(ctx, "names of files");
}

void ibl_input_files_free(char *files[IBL_FACES])
{
    for (int f = 0; f < IBL_FACES; f++) {
        ibl_free(files[f]);
        files[f] = NULL;
    }
}

/* ---- faces ------------------------------------------------------------- */

/* The faces below one another, and what the files' reports add up to. */
typedef struct strip {
    ibl_image img;
    float *alpha; /* NULL: no file has any */
    ibl_read_report report;
    char hashes[IBL_FACES][IBL_FILE_HASH - 1]; /* of the files */
} strip;

/* What the first file has counts for all. */
static void take_report(const ibl_read_report *r, ibl_read_report *all)
{
    memcpy(all->format, r->format, sizeof r->format);
    all->has_primaries = r->has_primaries;
    memcpy(all->primaries, r->primaries, sizeof r->primaries);
    memcpy(all->primaries_name, r->primaries_name, sizeof r->primaries_name);
    memcpy(all->luma, r->luma, sizeof r->luma);
}

static void add_report(const ibl_read_report *r, ibl_read_report *sum)
{
    sum->nonfinite += r->nonfinite;
    sum->negative += r->negative;
    sum->peak = fmaxf(sum->peak, r->peak);
    sum->low_range = r->low_range ? r->low_range : sum->low_range;
    sum->bridged |= r->bridged;
    sum->has_alpha |= r->has_alpha;
    sum->alpha_least = fminf(sum->alpha_least, r->alpha_least);
    sum->alpha_most = fmaxf(sum->alpha_most, r->alpha_most);
    sum->alpha_nonfinite += r->alpha_nonfinite;
    sum->alpha_beyond += r->alpha_beyond;
    sum->alpha_hidden += r->alpha_hidden;
    sum->outside += r->outside;
}

/* Alpha of a face; those before it are opaque if it is the first with any. */
static bool put_alpha(strip *s, int face, const float *alpha)
{
    const size_t n = (size_t)s->img.width, texels = n * n;

    if (!alpha && !s->alpha)
        return true;
    if (!s->alpha) {
        s->alpha = ibl_alloc_array(IBL_FACES * texels, sizeof *s->alpha);
        for (size_t i = 0; i < IBL_FACES * texels && s->alpha; i++)
            s->alpha[i] = 1;
    }
    if (s->alpha && alpha)
        memcpy(s->alpha + (size_t)face * texels, alpha, texels * sizeof *alpha);
    return s->alpha;
}

static ibl_status check_face(ibl_ctx *ctx, const char *file, int width,
                             int height, strip *s)
{
    const int n = s->img.width ? s->img.width : width;

    if (width != height || width > IBL_MAX_CUBE_SIZE)
        return ibl_fail(ctx, IBL_ERR_FORMAT,
                        "%s: %dx%d pixels: a face is square, %d at most", file,
                        width, height, IBL_MAX_CUBE_SIZE);
    if (width != n)
        return ibl_fail(ctx, IBL_ERR_FORMAT,
                        "%s: %d pixels wide, but the faces before it %d", file,
                        width, n);
    const ibl_input name = {.ctx = ctx, .name = file};
    return s->img.data ? IBL_OK
                       : ibl_map_alloc(&name, n, IBL_FACES * n, &s->img);
}

static ibl_status read_face(ibl_ctx *ctx, const char *file, int face,
                            const ibl_read_options *opts, strip *s)
{
    ibl_source *source;
    ibl_status status = ibl_source_open(ctx, file, opts, &source);
    if (status)
        return status;
    const int n = ibl_source_width(source);
    status = check_face(ctx, file, n, ibl_source_height(source), s);
    if (!status)
        status = ibl_source_read(
            source, n, s->img.data + 3 * (size_t)face * (size_t)n * (size_t)n);
    if (!status && !put_alpha(s, face, ibl_source_alpha(source)))
        status = ibl_no_memory(ctx, "alpha");
    if (!status && !face)
        take_report(ibl_source_report(source), &s->report);
    if (!status)
        add_report(ibl_source_report(source), &s->report);
    if (!status)
        memcpy(s->hashes[face], ibl_source_report(source)->hash,
               sizeof s->hashes[face]);
    ibl_source_close(source);
    return status;
}

ibl_status ibl_six_files_open(ibl_ctx *ctx, const char *name,
                              char *const files[IBL_FACES],
                              const ibl_read_options *opts, ibl_rows **out)
{
    strip s = {.report = {.alpha_least = 1, .layout = IBL_INPUT_FACES}};
    ibl_read_options flat = *opts;
    ibl_status status = IBL_OK;

    flat.layout = IBL_INPUT_EQUIRECT; /* as they are */
    flat.clamp = 0;                   /* the caller clamps all of them */
    memset(flat.face_order, 0, sizeof flat.face_order);
    if (opts->layout && opts->layout != IBL_INPUT_FACES)
        status = ibl_fail(ctx, IBL_ERR_FORMAT,
                          "%s: are files of faces, not in the layout %s", name,
                          ibl_input_layout_name(opts->layout));
    for (int f = 0; f < IBL_FACES && !status; f++)
        status = read_face(ctx, files[f], f, &flat, &s);
    const ibl_input hashes = ibl_input_of(ctx, name, s.hashes, sizeof s.hashes);
    if (!status && opts->hash)
        status = ibl_file_hash(&hashes, s.report.hash);
    if (status)
        ibl_image_free(&s.img);
    else
        status = ibl_rows_of_image(ctx, &s.img, out);
    if (status) {
        ibl_free(s.alpha);
        return status;
    }
    (*out)->report = s.report;
    (*out)->alpha = s.alpha;
    return IBL_OK;
}
