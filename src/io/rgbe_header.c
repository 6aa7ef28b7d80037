/* SPDX-License-Identifier: MIT */
/* The header of a Radiance picture: lines of text, then the resolution. */
#include <float.h>
#include <math.h>
#include <stdint.h>
#include <string.h>

#include "core/context.h"
#include "io/rgbe.h"

struct text {
    const unsigned char *at, *end;
};

/* The values of the lines; EXPOSURE and COLORCORR multiply. */
struct variables {
    bool has_format, xyz;
    double exposure;
    double correction[3];
    double primaries[8]; /* xy of red, green, blue, white */
    bool bad_primaries;
};

static const double default_primaries[8] = {0.640, 0.330, 0.290,     0.600,
                                            0.150, 0.060, 1.0 / 3.0, 1.0 / 3.0};

enum {
    QUOTE = 48, /* bytes of a file that a message repeats, with the NUL */
    BEYOND_BYTES = 1 << 20 /* after the pixels */
};

/* Printable text of a line, cut where it is long. */
static const char *quote(struct text line, char out[QUOTE])
{
    size_t n = 0;
    for (; line.at < line.end && n < QUOTE - 4; line.at++)
        out[n++] = *line.at >= 32 && *line.at < 127 ? (char)*line.at : '?';
    if (line.at < line.end) {
        memcpy(out + n, "...", 3);
        n += 3;
    }
    out[n] = '\0';
    return out;
}

static bool is_blank(unsigned char c)
{
    return c == ' ' || c == '\t';
}

static void skip_blanks(struct text *t)
{
    while (t->at < t->end && is_blank(*t->at))
        t->at++;
}

static bool take(struct text *t, const char *word)
{
    const size_t n = strlen(word);
    if ((size_t)(t->end - t->at) < n || memcmp(t->at, word, n))
        return false;
    t->at += n;
    return true;
}

static bool is_word(struct text t, const char *word)
{
    return take(&t, word) && t.at == t.end;
}

/* Takes a sign, if there is one; true for a minus. */
static bool take_sign(struct text *t)
{
    const bool minus = take(t, "-");
    if (!minus)
        take(t, "+");
    return minus;
}

static bool at_digit(const struct text *t)
{
    return t->at < t->end && *t->at >= '0' && *t->at <= '9';
}

/* A decimal number, the same in every locale. */
static bool take_number(struct text *t, double *value)
{
    uint64_t digits = 0;
    int exponent = 0, seen = 0;
    bool point = false;

    skip_blanks(t);
    const bool negative = take_sign(t);
    for (;; t->at++) {
        if (!point && t->at < t->end && *t->at == '.') {
            point = true;
            continue;
        }
        if (!at_digit(t))
            break;
        if (digits < UINT64_MAX / 10 - 1) {
            digits = digits * 10 + (*t->at - '0');
            exponent -= point;
        } else {
            exponent += !point;
        }
        seen++;
    }
    if (!seen)
        return false;

    struct text tail = *t;
    if (take(&tail, "e") || take(&tail, "E")) {
        const bool minus = take_sign(&tail);
        int e = 0;
        for (; at_digit(&tail); *t = tail) {
            e = e < 10000 ? e * 10 + (*tail.at - '0') : e;
            tail.at++;
        }
        exponent += minus ? -e : e;
    }
    if (!digits)
        exponent = 0; /* 0e9999 is 0, and not 0 * Inf */
    *value = exponent < 0 ? (double)digits / pow(10, -exponent)
                          : (double)digits * pow(10, exponent);
    if (negative)
        *value = -*value;
    return true;
}

/* Takes the next line, without its end. A file whose first line ends with a
 * bare CR has CR for line ends. */
static bool next_line(struct text *t, bool bare_cr, struct text *line)
{
    const unsigned char *end =
        memchr(t->at, bare_cr ? '\r' : '\n', (size_t)(t->end - t->at));
    if (!end)
        return false;
    *line = (struct text){t->at, end};
    if (line->end > line->at && line->end[-1] == '\r')
        line->end--;
    t->at = end + 1;
    return true;
}

static bool uses_bare_cr(struct text t)
{
    while (t.at < t.end && *t.at != '\r' && *t.at != '\n')
        t.at++;
    return t.end - t.at > 1 && t.at[0] == '\r' && t.at[1] != '\n';
}

/* NAME=, with blanks around the sign. A line that begins with blanks is the
 * history of a picture that this one was made from. */
static bool take_name(struct text *line, const char *name)
{
    struct text t = *line;
    if (!take(&t, name))
        return false;
    skip_blanks(&t);
    if (!take(&t, "="))
        return false;
    skip_blanks(&t);
    *line = t;
    return true;
}

/* Factors above 0. A 0, which Filament's cmgen writes for EXPOSURE, cannot have
 * been one: it is passed over. */
static ibl_status take_factors(const ibl_input *in, const char *what,
                               struct text value, double *factors, int count)
{
    const struct text all = value;
    char text[QUOTE];
    for (int i = 0; i < count; i++) {
        double f;
        if (!take_number(&value, &f) || !(f >= 0) || isinf(f))
            return ibl_bad_file(in, "%s is \"%s\": must be %s above 0", what,
                                quote(all, text),
                                count > 1 ? "three numbers" : "a number");
        if (f > 0)
            factors[i] *= f;
        else
            ibl_warn(in->ctx, "%s: %s of 0 is ignored", in->name, what);
    }
    return IBL_OK;
}

static ibl_status take_format(const ibl_input *in, struct text value,
                              struct variables *v)
{
    char text[QUOTE];
    while (value.end > value.at && is_blank(value.end[-1]))
        value.end--;
    v->has_format = true;
    v->xyz = is_word(value, "32-bit_rle_xyze");
    if (v->xyz || is_word(value, "32-bit_rle_rgbe"))
        return IBL_OK;
    return ibl_unsupported(
        in, "FORMAT is \"%s\": must be 32-bit_rle_rgbe or 32-bit_rle_xyze",
        quote(value, text));
}

static void take_primaries(struct text value, struct variables *v)
{
    v->bad_primaries = false;
    for (int i = 0; i < 8; i++)
        v->bad_primaries |= !take_number(&value, &v->primaries[i]);
}

static ibl_status take_line(const ibl_input *in, struct text line,
                            struct variables *v)
{
    struct text value = line;
    double gamma;

    if (take_name(&value, "FORMAT"))
        return take_format(in, value, v);
    if (take_name(&value, "EXPOSURE"))
        return take_factors(in, "EXPOSURE", value, &v->exposure, 1);
    if (take_name(&value, "COLORCORR"))
        return take_factors(in, "COLORCORR", value, v->correction, 3);
    if (take_name(&value, "PRIMARIES"))
        take_primaries(value, v);
    else if (take_name(&value, "GAMMA") && take_number(&value, &gamma) &&
             gamma != 1)
        ibl_warn(in->ctx,
                 "%s: GAMMA=%g is ignored: the pixels are taken as linear",
                 in->name, gamma);
    return IBL_OK;
}

/* Whether a line can only be the resolution: +X, -X, +Y or -Y, a blank. */
static bool is_resolution(struct text line)
{
    return line.end - line.at > 2 && (line.at[0] == '+' || line.at[0] == '-') &&
           (line.at[1] == 'X' || line.at[1] == 'Y') && is_blank(line.at[2]);
}

/* An edge, which may be any text of digits; more than int holds is as wrong
 * as INT_MAX. */
static bool take_axis(struct text *t, char axis, bool *decreasing, int *edge)
{
    double value;
    skip_blanks(t);
    *decreasing = take(t, "-");
    if ((!*decreasing && !take(t, "+")) || !take(t, (char[]){axis, 0}) ||
        !take_number(t, &value))
        return false;
    value = fmin(fmax(value, INT32_MIN), INT32_MAX);
    *edge = (int)value;
    return *edge == value;
}

/* The eight orientations. The picture's X grows to the right and its Y up, so
 * rows that run with -Y begin at the top. False: it is no resolution, or has an
 * edge of no map. */
static bool take_edges(struct text line, ibl_rgbe_header *h, bool *is_one)
{
    struct text t = line;
    bool x_down, y_down;

    h->by_column = line.end - line.at > 1 && line.at[1] == 'X';
    *is_one = h->by_column ? take_axis(&t, 'X', &x_down, &h->width) &&
                                 take_axis(&t, 'Y', &y_down, &h->height)
                           : take_axis(&t, 'Y', &y_down, &h->height) &&
                                 take_axis(&t, 'X', &x_down, &h->width);
    skip_blanks(&t);
    *is_one = *is_one && t.at == t.end;
    if (!*is_one || h->width < 1 || h->width > IBL_MAX_EDGE || h->height < 1 ||
        h->height > IBL_MAX_EDGE)
        return false;
    h->row_px = h->by_column ? h->height : h->width;
    h->rows = h->by_column ? h->width : h->height;
    h->reverse_rows = h->by_column ? x_down : !y_down;
    h->reverse_pixels = h->by_column ? !y_down : x_down;
    return true;
}

static ibl_status take_resolution(const ibl_input *in, struct text line,
                                  ibl_rgbe_header *h)
{
    char text[QUOTE];
    bool is_one;

    if (take_edges(line, h, &is_one))
        return IBL_OK;
    if (is_one)
        return ibl_bad_file(
            in,
            "the resolution line is \"%s\": each edge must be 1 to %d pixels",
            quote(line, text), IBL_MAX_EDGE);
    return ibl_bad_file(
        in, "the resolution line is \"%s\": must be like \"-Y 512 +X 1024\"",
        quote(line, text));
}

/*
 * XYZ to RGB. The columns of P are the XYZ of the primaries up to a factor
 * each, which W = P s gives: white is R = G = B with Y = 1. Then the inverse
 * of P diag(s). False if the primaries have no such matrix.
 */
static bool rgb_from_xyz(const double primaries[8], double m[9])
{
    double p[9], inv[9];
    for (int i = 0; i < 3; i++) {
        p[i] = primaries[2 * i];
        p[3 + i] = primaries[2 * i + 1];
        p[6 + i] = 1 - p[i] - p[3 + i];
    }
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++) {
            const int a = (j + 1) % 3, b = (j + 2) % 3;
            const int c = (i + 1) % 3, d = (i + 2) % 3;
            inv[3 * i + j] =
                p[3 * a + c] * p[3 * b + d] - p[3 * a + d] * p[3 * b + c];
        }
    }
    const double det = p[0] * inv[0] + p[1] * inv[3] + p[2] * inv[6];
    const double x = primaries[6], y = primaries[7];
    if (!(fabs(det) > 1e-6) || !(fabs(y) > 1e-6))
        return false;
    for (int i = 0; i < 3; i++) {
        const double s = (inv[3 * i] * x + inv[3 * i + 1] * y +
                          inv[3 * i + 2] * (1 - x - y)) /
                         (det * y);
        if (!(fabs(s) > 1e-6))
            return false;
        for (int j = 0; j < 3; j++)
            m[3 * i + j] = inv[3 * i + j] / (det * s);
    }
    for (int i = 0; i < 9; i++)
        if (!(fabs(m[i]) < 1e6))
            return false;
    return true;
}

/* Turns the variables into the factors that the pixels need. */
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
    if (!v->xyz)
        return IBL_OK;
    if (v->bad_primaries || !rgb_from_xyz(v->primaries, matrix)) {
        ibl_warn(in->ctx,
                 "%s: PRIMARIES is no triangle with a white: Radiance's "
                 "default ones are taken",
                 in->name);
        rgb_from_xyz(default_primaries, matrix);
    }
    for (int i = 0; i < 9; i++)
        h->matrix[i] = (float)(matrix[i] * scale[i % 3]);
    return IBL_OK;
}

/* Finds the resolution, or the first line after a blank one, and what follows
 * it. False: the bytes end before that. */
static bool find_end(const unsigned char *bytes, size_t size, struct text *line,
                     struct text *rest)
{
    bool blank = false;

    *rest = (struct text){bytes, bytes + size};
    const bool bare_cr = uses_bare_cr(*rest);
    while (next_line(rest, bare_cr, line)) {
        if (blank || is_resolution(*line))
            return true;
        blank = line->at == line->end;
    }
    return false;
}

bool ibl_rgbe_has_header(const unsigned char *bytes, size_t size)
{
    struct text line, rest;
    return find_end(bytes, size, &line, &rest);
}

uint64_t ibl_rgbe_longest(const unsigned char *bytes, size_t size)
{
    struct text line, rest;
    ibl_rgbe_header h;
    bool is_one;

    if (!find_end(bytes, size, &line, &rest) || !is_resolution(line) ||
        !take_edges(line, &h, &is_one))
        return IBL_RGBE_MOST_HEADER;
    return (uint64_t)(rest.at - bytes) +
           (uint64_t)h.rows * ibl_rgbe_most_bytes(&h) + BEYOND_BYTES;
}

ibl_status ibl_rgbe_parse(const ibl_input *in, const unsigned char *bytes,
                          size_t size, ibl_rgbe_header *header)
{
    struct text rest = {bytes, bytes + size}, line, last, pixels;
    struct variables v = {.exposure = 1, .correction = {1, 1, 1}};
    const bool bare_cr = uses_bare_cr(rest);
    const bool ends = find_end(bytes, size, &last, &pixels);
    ibl_status status = IBL_OK;
    char text[QUOTE];

    memcpy(v.primaries, default_primaries, sizeof v.primaries);
    if (!ibl_rgbe_is(bytes, size))
        return ibl_bad_file(in, "no Radiance picture: must begin with \"#?\"");
    while (!status && next_line(&rest, bare_cr, &line) &&
           (!ends || line.at != last.at))
        status = take_line(in, line, &v);
    if (status)
        return status;
    if (!ends)
        return ibl_bad_file(in,
                            "the file ends in its header, before the "
                            "resolution line: it is cut short: copy it again");
    if (!is_resolution(last))
        return ibl_bad_file(in,
                            "no resolution line after the header but \"%s\": "
                            "must be like \"-Y 512 +X 1024\"",
                            quote(last, text));
    *header = (ibl_rgbe_header){.data = (size_t)(pixels.at - bytes)};
    status = take_resolution(in, last, header);
    if (status)
        return status;
    if (!v.has_format)
        ibl_warn(in->ctx, "%s: no FORMAT line: taken as 32-bit_rle_rgbe",
                 in->name);
    return set_factors(in, &v, header);
}
