/* SPDX-License-Identifier: MIT */
#include "io/layout.h"

#include <ctype.h>
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

/* ---- faces ------------------------------------------------------------- */

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

ibl_status ibl_six_files_open(ibl_ctx *ctx, const char *name,
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
