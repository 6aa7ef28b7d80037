/* SPDX-License-Identifier: MIT */
#include "cli/json_text.h"

#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cli/json_put.h"
#include "common/memory_file.h"
#include "common/number.h"

/* Length of the string that begins at the quote s, quotes included. */
static size_t string_length(const char *s)
{
    size_t n = 1;
    while (s[n] != '"')
        n += s[n] == '\\' ? 2 : 1;
    return n + 1;
}

/* Whether the array that begins at s holds no array or object. */
static int is_plain(const char *s)
{
    for (s++; *s != ']';) {
        if (*s == '[' || *s == '{')
            return 0;
        s += *s == '"' ? string_length(s) : 1;
    }
    return 1;
}

/* Prints the number at s with fewer digits if they do. Returns the length
 * that it has in s. */
static size_t put_number(const char *s, FILE *to)
{
    const size_t length = strspn(s, "+-.0123456789eE");
    const double x = strtod(s, NULL);
    char text[IBL_NUMBER_BYTES];

    if (!memchr(s, '.', length) && !memchr(s, 'e', length)) {
        fprintf(to, "%.*s", (int)length, s);
        return length;
    }
    ibl_number_text(x, text);
    /* Still a real, for readers that tell 1 from 1.0. */
    fprintf(to, "%s%s", text, strpbrk(text, ".e") ? "" : ".0");
    return length;
}

static void tidy(const char *s, FILE *to)
{
    int plain = 0;

    while (*s) {
        size_t length = 1;
        if (*s == '"') {
            length = string_length(s);
            fwrite(s, 1, length, to);
        } else if (strchr("-0123456789", *s)) {
            length = put_number(s, to);
        } else if (plain && *s == '\n') {
            length += strspn(s + 1, " ");
            if (s[-1] == ',')
                fputc(' ', to);
        } else {
            if (*s == '[')
                plain = is_plain(s);
            else if (*s == ']')
                plain = 0;
            fputc(*s, to);
        }
        s += length;
    }
    fputc('\n', to);
}

/* Not json_dumps, which does not notice that there is no memory for a key. */
char *ibl_json_dump(const json_t *root, size_t flags)
{
    ibl_memory_file file;
    FILE *to = ibl_memory_open(&file);

    if (to && json_dumpf(root, to, flags)) {
        free(ibl_memory_close(to, &file));
        return NULL;
    }
    return ibl_memory_close(to, &file);
}

char *ibl_json_text(const json_t *root)
{
    char *raw = ibl_json_dump(root, JSON_INDENT(2) | JSON_REAL_PRECISION(17));
    ibl_memory_file file;
    FILE *to = raw ? ibl_memory_open(&file) : NULL;

    if (to)
        tidy(raw, to);
    free(raw);
    return ibl_memory_close(to, &file);
}

/* Bytes of the character that jansson finds there; 0: it is not UTF-8. */
static size_t character_length(const char *bytes, size_t most)
{
    for (size_t n = 1; n <= 4 && n <= most; n++) {
        json_t *piece = json_stringn(bytes, n);
        json_decref(piece);
        if (piece)
            return n;
    }
    return 0;
}

/* A string of any bytes: those that are not UTF-8 become U+FFFD or, as '%' then
 * does, too, %XX. */
static json_t *mend(const char *bytes, bool percent)
{
    const size_t length = strlen(bytes);
    char *text = malloc(3 * length + 1), *to = text;

    if (!text)
        return NULL;
    for (size_t i = 0; i < length;) {
        const size_t n = character_length(bytes + i, length - i);
        if (percent && (!n || bytes[i] == '%')) {
            to += sprintf(to, "%%%02X", (unsigned char)bytes[i]);
        } else {
            memcpy(to, n ? bytes + i : "\xEF\xBF\xBD", n ? n : 3);
            to += n ? n : 3;
        }
        i += n ? n : 1;
    }
    json_t *string = json_stringn(text, (size_t)(to - text));
    free(text);
    return string;
}

json_t *ibl_json_string(const char *bytes)
{
    json_t *string = json_string(bytes);
    return string ? string : mend(bytes, false);
}

json_t *ibl_json_encoded(const char *bytes)
{
    return mend(bytes, true);
}

json_t *ibl_json_generator(ibl_isa isa)
{
    json_t *j = json_object();

    put(&j, "name", json_string("iblbake"));
    put(&j, "version", json_string(IBL_VERSION));
    if (*IBL_REVISION)
        put(&j, "revision", json_string(IBL_REVISION));
    put(&j, "isa", json_string(ibl_isa_name(isa)));
    return j;
}

void ibl_json_put_basis(json_t **object, int degree)
{
    put(object, "degree", json_integer(degree));
    put(object, "basis",
        json_string("real, orthonormal, polar axis +Z, no Condon-Shortley "
                    "phase: Y(1,-1), Y(1,0), Y(1,1) = +sqrt(3/4pi) y, z, x"));
    put(object, "order", json_string("coefficient l (l + 1) + m, [R, G, B]"));
}

json_t *ibl_json_overflow(const ibl_overflow_level *level)
{
    return json_pack("{s:I,s:f,s:f}", "texels", (json_int_t)level->texels,
                     "moved", level->moved, "lost", level->lost);
}
