/* SPDX-License-Identifier: MIT */
/* The header of a Radiance picture: lines of text, then the resolution. */
#include <errno.h>
#include <float.h>
#include <math.h>
#include <string.h>

#include "core/alloc.h"
#include "core/context.h"
#include "io/colour_space.h"
#include "io/input.h"
#include "io/rgbe.h"

/* Values of header lines; repeated EXPOSURE and COLORCORR multiply. */
struct variables {
    bool has_format;
    double exposure;
    double correction[3];
    double primaries[8]; /* xy of red, green, blue, white */
    bool has_primaries;
};

enum {
    MOST_BYTES = 1 << 20 /* longer headers are taken for damage */
};

static const char blanks[] = " \t";

/* What follows NAME=, with blanks around the sign; NULL: another line. Lines
 * that begin with blanks are the history of the source picture. */
static char *value_of(char *line, const char *name)
{
    const size_t length = strlen(name);

    if (strncmp(line, name, length) != 0)
        return NULL;
    line += length + strspn(line + length, blanks);
    return *line == '=' ? line + 1 + strspn(line + 1, blanks) : NULL;
}

/* Reads positive factors. Ignores a 0: it cannot have been a factor, but
 * Filament's cmgen writes it for EXPOSURE. */
static ibl_status take_factors(const ibl_input *in, const char *what,
                               char *value, double *factors, int count)
{
    const char *all = value;
    char text[IBL_QUOTE_BYTES];
    for (int i = 0; i < count; i++) {
        double f;
        if (!ibl_take_number(&value, &f) || !(f >= 0) || isinf(f))
            return ibl_bad_file(in, "%s is \"%s\": must be %s above 0", what,
                                ibl_quote(all, text),
                                count > 1 ? "three numbers" : "a number");
        if (f > 0)
            factors[i] *= f;
        else
            ibl_warn(in->ctx, "%s: %s of 0 is ignored", in->name, what);
    }
    return IBL_OK;
}

static ibl_status take_line(const ibl_input *in, char *line,
                            struct variables *v)
{
    char *value, text[IBL_QUOTE_BYTES];
    double gamma;

    if ((value = value_of(line, "EXPOSURE")))
        return take_factors(in, "EXPOSURE", value, &v->exposure, 1);
    if ((value = value_of(line, "COLORCORR")))
        return take_factors(in, "COLORCORR", value, v->correction, 3);
    if ((value = value_of(line, "PRIMARIES"))) {
        v->has_primaries = true;
        for (int i = 0; i < 8; i++)
            v->has_primaries &= ibl_take_number(&value, &v->primaries[i]);
    } else if ((value = value_of(line, "FORMAT"))) {
        value[strcspn(value, blanks)] = '\0';
        v->has_format = true;
        if (strcmp(value, "32-bit_rle_rgbe") != 0)
            return ibl_unsupported(in,
                                   "FORMAT is \"%s\": must be "
                                   "32-bit_rle_rgbe; Radiance's ra_xyze -r "
                                   "makes it of XYZE",
                                   ibl_quote(value, text));
    } else if ((value = value_of(line, "GAMMA")) &&
               ibl_take_number(&value, &gamma) && gamma != 1) {
        ibl_warn(in->ctx,
                 "%s: GAMMA=%g is ignored: the pixels are taken as linear",
                 in->name, gamma);
    }
    return IBL_OK;
}

/* Whether only a resolution begins so: +X, -X, +Y or -Y, then a blank. */
static bool is_resolution(const char *line, size_t size)
{
    return size > 2 && (line[0] == '+' || line[0] == '-') &&
           (line[1] == 'X' || line[1] == 'Y') &&
           (line[2] == ' ' || line[2] == '\t');
}

/* Reads one of the eight orientations. X grows to the right and Y up: rows in
 * -Y order begin at the top. */
static ibl_status take_resolution(const ibl_input *in, char *line,
                                  ibl_rgbe_header *h)
{
    /* by which of scanlines and pixels run from the bottom or right */
    static const int rows_of[] = {1, 2, 4, 3}, columns_of[] = {5, 8, 6, 7};
    const bool by_column = line[1] == 'X';
    char text[IBL_QUOTE_BYTES], *t = line;
    bool down[2] = {false, false}, ok = true;
    double edge[2] = {0, 0};

    for (int i = 0; i < 2 && ok; i++) {
        t += strspn(t, blanks);
        down[i] = *t == '-';
        ok = (down[i] || *t == '+') && t[1] == (by_column != i ? 'X' : 'Y');
        t += ok ? 2 : 0;
        ok = ok && ibl_take_number(&t, &edge[i]) && edge[i] == floor(edge[i]);
    }
    if (!ok || t[strspn(t, blanks)])
        return ibl_bad_file(
            in,
            "the resolution line is \"%s\": must be like \"-Y 512 +X 1024\"",
            ibl_quote(line, text));
    for (int i = 0; i < 2; i++)
        ok = ok && edge[i] >= 1 && edge[i] <= IBL_MAX_EDGE;
    if (!ok)
        return ibl_bad_file(
            in,
            "the resolution line is \"%s\": each edge must be 1 to %d pixels",
            ibl_quote(line, text), IBL_MAX_EDGE);
    h->rows = (int)edge[0];
    h->row_px = (int)edge[1];
    h->orientation = by_column ? columns_of[2 * down[0] + !down[1]]
                               : rows_of[2 * !down[0] + down[1]];
    return IBL_OK;
}

/* Computes the factors for the pixels from the variables. */
static ibl_status set_factors(const ibl_input *in, const struct variables *v,
                              ibl_rgbe_header *h)
{
    double matrix[9];

    for (int c = 0; c < 3; c++) {
        const double scale = 1 / (v->exposure * v->correction[c]);
        if (!(scale >= FLT_MIN && scale <= FLT_MAX))
            return ibl_bad_file(in,
                                "EXPOSURE and COLORCORR multiply to %g: must "
                                "be between 1e-38 and 1e38",
                                v->exposure * v->correction[c]);
        h->scale[c] = (float)scale;
    }
    h->has_primaries =
        v->has_primaries && ibl_colour_space(v->primaries, matrix, NULL);
    if (h->has_primaries)
        memcpy(h->primaries, v->primaries, sizeof h->primaries);
    return IBL_OK;
}

/* Parses a text of `size` bytes, which it changes: lines up to the resolution,
 * or to the first one after a blank one. */
static ibl_status parse(const ibl_input *in, char *text, size_t size,
                        ibl_rgbe_header *h)
{
    struct variables v = {.exposure = 1, .correction = {1, 1, 1}};
    char quoted[IBL_QUOTE_BYTES], *line = text;
    bool blank = false;

    for (;;) {
        char *end = memchr(line, '\n', size - (size_t)(line - text));
        if (!end)
            return ibl_bad_file(
                in, "the file ends in its header, before the resolution line: "
                    "it is cut short: copy it again");
        const bool is_last = blank || is_resolution(line, (size_t)(end - line));
        for (char *c = line; c < end; c++)
            *c = *c ? *c : '?';
        end[end > line && end[-1] == '\r' ? -1 : 0] = '\0';
        h->data = (size_t)(end + 1 - text);
        if (is_last)
            break;
        blank = !*line;
        const ibl_status status = take_line(in, line, &v);
        if (status)
            return status;
        line = end + 1;
    }
    if (!is_resolution(line, strlen(line)))
        return ibl_bad_file(in,
                            "no resolution line after the header but \"%s\": "
                            "must be like \"-Y 512 +X 1024\"",
                            ibl_quote(line, quoted));
    const ibl_status status = take_resolution(in, line, h);
    if (status)
        return status;
    if (!v.has_format)
        ibl_warn(in->ctx, "%s: no FORMAT line: taken as 32-bit_rle_rgbe",
                 in->name);
    return set_factors(in, &v, h);
}

ibl_status ibl_rgbe_parse(const ibl_input *in, ibl_rgbe_header *h)
{
    char *text = ibl_alloc_array(MOST_BYTES, 1);
    ibl_status status;
    size_t size;

    *h = (ibl_rgbe_header){.data = 0};
    if (!text)
        return ibl_no_memory(in->ctx, "the header of a picture");
    if (ibl_input_read(in, 0, MOST_BYTES, text, &size))
        status = parse(in, text, size, h);
    else
        status = ibl_input_unread(in, errno);
    ibl_free(text);
    return status;
}
