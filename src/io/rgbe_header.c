/* SPDX-License-Identifier: MIT */
/* The header of a Radiance picture: lines of text, then the resolution. */
#include <errno.h>
#include <float.h>
#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "core/alloc.h"
#include "core/context.h"
#include "io/colour_space.h"
#include "io/input.h"
#include "io/rgbe.h"

/* Values of header lines; repeated EXPOSURE and COLORCORR multiply. */
struct variables {
    bool has_format, xyz;
    double exposure;
    double correction[3];
    double primaries[8]; /* xy of red, green, blue, white */
    bool has_primaries, bad_primaries;
};

static const double default_primaries[8] = {0.640, 0.330, 0.290,     0.600,
                                            0.150, 0.060, 1.0 / 3.0, 1.0 / 3.0};

enum {
    FIRST_BYTES = 1 << 16, /* most headers are shorter */
    MOST_BYTES = 1 << 26   /* longer headers are taken for damage */
};

static bool is_blank(char c)
{
    return c == ' ' || c == '\t';
}

static void skip_blanks(char **t)
{
    while (is_blank(**t))
        ++*t;
}

static bool take(char **t, const char *word)
{
    const size_t n = strlen(word);
    if (strncmp(*t, word, n))
        return false;
    *t += n;
    return true;
}

/* The line end: CR if the first line ends with a CR without LF, else LF. */
static char line_end(const char *text, size_t size)
{
    size_t n = 0;
    while (n < size && text[n] != '\r' && text[n] != '\n')
        n++;
    return n + 1 < size && text[n] == '\r' && text[n + 1] != '\n' ? '\r' : '\n';
}

/* Takes the next line and removes its end; NULL: no line end found. */
static char *next_line(char **rest, char end)
{
    char *line = *rest, *stop = strchr(line, end);
    if (!stop)
        return NULL;
    *rest = stop + 1;
    if (stop > line && stop[-1] == '\r')
        stop--;
    *stop = '\0';
    return line;
}

/* Takes NAME=, with blanks around the sign. Lines that begin with blanks are
 * the history of the source picture and do not match. */
static bool take_name(char **line, const char *name)
{
    char *t = *line;
    if (!take(&t, name))
        return false;
    skip_blanks(&t);
    if (!take(&t, "="))
        return false;
    skip_blanks(&t);
    *line = t;
    return true;
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

static ibl_status take_format(const ibl_input *in, char *value,
                              struct variables *v)
{
    char text[IBL_QUOTE_BYTES];
    size_t n = strlen(value);
    while (n && is_blank(value[n - 1]))
        value[--n] = '\0';
    v->has_format = true;
    v->xyz = !strcmp(value, "32-bit_rle_xyze");
    if (v->xyz || !strcmp(value, "32-bit_rle_rgbe"))
        return IBL_OK;
    return ibl_unsupported(
        in, "FORMAT is \"%s\": must be 32-bit_rle_rgbe or 32-bit_rle_xyze",
        ibl_quote(value, text));
}

static ibl_status take_line(const ibl_input *in, char *line,
                            struct variables *v)
{
    double gamma;

    if (take_name(&line, "FORMAT"))
        return take_format(in, line, v);
    if (take_name(&line, "EXPOSURE"))
        return take_factors(in, "EXPOSURE", line, &v->exposure, 1);
    if (take_name(&line, "COLORCORR"))
        return take_factors(in, "COLORCORR", line, v->correction, 3);
    if (take_name(&line, "PRIMARIES")) {
        v->has_primaries = true;
        v->bad_primaries = false;
        for (int i = 0; i < 8; i++)
            v->bad_primaries |= !ibl_take_number(&line, &v->primaries[i]);
    } else if (take_name(&line, "GAMMA") && ibl_take_number(&line, &gamma) &&
               gamma != 1) {
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
           (line[1] == 'X' || line[1] == 'Y') && is_blank(line[2]);
}

/* Reads one axis and its edge, any decimal number. Values above INT_MAX become
 * INT_MAX, which is equally wrong. */
static bool take_axis(char **t, char axis, bool *decreasing, int *edge)
{
    double value;
    skip_blanks(t);
    *decreasing = take(t, "-");
    if ((!*decreasing && !take(t, "+")) || !take(t, (char[]){axis, 0}) ||
        !ibl_take_number(t, &value))
        return false;
    value = fmin(fmax(value, INT32_MIN), INT32_MAX);
    *edge = (int)value;
    return *edge == value;
}

/* Reads one of the eight orientations. X grows to the right and Y up: rows in
 * -Y order begin at the top. False: no resolution (*is_one is false too), or an
 * edge that is not allowed. */
static bool take_edges(char *line, ibl_rgbe_header *h, bool *is_one)
{
    char *t = line;
    bool x_down, y_down;

    h->by_column = line[1] == 'X';
    *is_one = h->by_column ? take_axis(&t, 'X', &x_down, &h->width) &&
                                 take_axis(&t, 'Y', &y_down, &h->height)
                           : take_axis(&t, 'Y', &y_down, &h->height) &&
                                 take_axis(&t, 'X', &x_down, &h->width);
    skip_blanks(&t);
    *is_one = *is_one && !*t;
    if (!*is_one || h->width < 1 || h->width > IBL_MAX_EDGE || h->height < 1 ||
        h->height > IBL_MAX_EDGE)
        return false;
    h->row_px = h->by_column ? h->height : h->width;
    h->rows = h->by_column ? h->width : h->height;
    h->reverse_rows = h->by_column ? x_down : !y_down;
    h->reverse_pixels = h->by_column ? !y_down : x_down;
    return true;
}

static ibl_status take_resolution(const ibl_input *in, char *line,
                                  ibl_rgbe_header *h)
{
    char text[IBL_QUOTE_BYTES];
    bool is_one;

    if (take_edges(line, h, &is_one))
        return IBL_OK;
    if (is_one)
        return ibl_bad_file(
            in,
            "the resolution line is \"%s\": each edge must be 1 to %d pixels",
            ibl_quote(line, text), IBL_MAX_EDGE);
    return ibl_bad_file(
        in, "the resolution line is \"%s\": must be like \"-Y 512 +X 1024\"",
        ibl_quote(line, text));
}

/* Computes the factors for the pixels from the variables. */
static ibl_status set_factors(const ibl_input *in, const struct variables *v,
                              ibl_rgbe_header *h)
{
    double matrix[9], scale[3];

    for (int c = 0; c < 3; c++) {
        scale[c] = 1 / (v->exposure * v->correction[c]);
        if (!(scale[c] >= FLT_MIN && scale[c] <= FLT_MAX))
            return ibl_bad_file(in,
                                "EXPOSURE and COLORCORR multiply to %g: must "
                                "be between 1e-38 and 1e38",
                                v->exposure * v->correction[c]);
    }
    h->xyz = v->xyz;
    for (int c = 0; c < 3; c++)
        h->scale[c] = v->xyz ? 1.0f : (float)scale[c];
    h->has_primaries = v->has_primaries && !v->bad_primaries &&
                       ibl_colour_space(v->primaries, matrix, NULL);
    if (h->has_primaries)
        memcpy(h->primaries, v->primaries, sizeof h->primaries);
    if (!v->xyz)
        return IBL_OK;
    if (!h->has_primaries) {
        if (v->has_primaries)
            ibl_warn(in->ctx,
                     "%s: PRIMARIES is no triangle with a white: Radiance's "
                     "default ones are taken",
                     in->name);
        memcpy(h->primaries, default_primaries, sizeof h->primaries);
        ibl_colour_space(default_primaries, matrix, NULL);
    }
    for (int i = 0; i < 9; i++)
        h->matrix[i] = (float)(matrix[i] * scale[i % 3]);
    return IBL_OK;
}

/* Finds the resolution line, or the first line after a blank one, and the
 * offset after it. False: the text ends before that. */
static bool find_end(const char *text, size_t size, size_t *last, size_t *after)
{
    const char end = line_end(text, size);
    bool blank = false;

    for (*last = 0;; *last = *after) {
        const char *line = text + *last;
        const char *stop = memchr(line, end, size - *last);
        if (!stop)
            return false;
        *after = (size_t)(stop + 1 - text);
        if (blank || is_resolution(line, (size_t)(stop - line)))
            return true;
        blank = stop == line || (stop == line + 1 && *line == '\r');
    }
}

/* Parses a zero-terminated text up to the line at `last`. */
static ibl_status parse_text(const ibl_input *in, char *text, size_t last,
                             bool ends, ibl_rgbe_header *h)
{
    struct variables v = {.exposure = 1, .correction = {1, 1, 1}};
    const char end = line_end(text, strlen(text));
    char *rest = text, *line;
    char quoted[IBL_QUOTE_BYTES];
    ibl_status status = IBL_OK;

    memcpy(v.primaries, default_primaries, sizeof v.primaries);
    while (!status && rest < text + last && (line = next_line(&rest, end)))
        status = take_line(in, line, &v);
    if (status)
        return status;
    if (!ends)
        return ibl_bad_file(in,
                            "the file ends in its header, before the "
                            "resolution line: it is cut short: copy it again");
    line = next_line(&rest, end);
    if (!is_resolution(line, strlen(line)))
        return ibl_bad_file(in,
                            "no resolution line after the header but \"%s\": "
                            "must be like \"-Y 512 +X 1024\"",
                            ibl_quote(line, quoted));
    status = take_resolution(in, line, h);
    if (status)
        return status;
    if (!v.has_format)
        ibl_warn(in->ctx, "%s: no FORMAT line: taken as 32-bit_rle_rgbe",
                 in->name);
    return set_factors(in, &v, h);
}

/* Tries to parse the first `room` bytes of the file; false: too few. */
static bool parse_first(const ibl_input *in, size_t room, ibl_rgbe_header *h,
                        ibl_status *status)
{
    char *text = ibl_alloc_array(room + 1, 1);
    size_t size, last, after;
    bool enough = true;

    if (!text) {
        *status = ibl_no_memory(in->ctx, "the header of a picture");
    } else if (!ibl_input_read(in, 0, room, text, &size)) {
        *status = ibl_input_unread(in, errno);
    } else {
        const bool ends = find_end(text, size, &last, &after);
        if (!ends)
            last = after = size;
        for (size_t i = 0; i < after; i++)
            text[i] = text[i] ? text[i] : '?';
        text[after] = '\0';
        *h = (ibl_rgbe_header){.data = after};
        enough = ends || size < room || room >= MOST_BYTES;
        if (enough)
            *status = parse_text(in, text, last, ends, h);
    }
    ibl_free(text);
    return enough;
}

ibl_status ibl_rgbe_parse(const ibl_input *in, ibl_rgbe_header *header)
{
    ibl_status status;
    size_t room = FIRST_BYTES;

    while (!parse_first(in, room, header, &status))
        room *= 2;
    return status;
}
