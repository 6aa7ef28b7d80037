/* SPDX-License-Identifier: MIT */
#include "cli/choice.h"

#include <stdarg.h>

#include "json/json_text.h"

static ibl_choice_row *add_row(ibl_choice *c, const char *name)
{
    static ibl_choice_row beyond;
    ibl_choice_row *row =
        c->count < IBL_CHOICE_ROWS ? &c->row[c->count++] : &beyond;
    snprintf(row->name, sizeof row->name, "%s", name);
    return row;
}

void ibl_choice_found(ibl_choice *c, const char *name, const char *fmt, ...)
{
    ibl_choice_row *row = add_row(c, name);
    va_list args;

    va_start(args, fmt);
    vsnprintf(row->value, sizeof row->value, fmt, args);
    va_end(args);
}

void ibl_choice_chose(ibl_choice *c, const char *name, const char *value,
                      const char *fmt, ...)
{
    ibl_choice_row *row = add_row(c, name);
    va_list args;

    row->chosen = true;
    snprintf(row->value, sizeof row->value, "%s", value);
    va_start(args, fmt);
    vsnprintf(row->why, sizeof row->why, fmt, args);
    va_end(args);
}

static void print_rows(const ibl_choice *c, bool chosen, FILE *to)
{
    bool first = true;

    for (int i = 0; i < c->count; i++) {
        const ibl_choice_row *row = &c->row[i];
        if (row->chosen != chosen)
            continue;
        fprintf(to, "%-7s %-14s %s%s%s\n",
                !first   ? ""
                : chosen ? "chosen"
                         : "found",
                row->name, row->value, *row->why ? "  " : "", row->why);
        first = false;
    }
}

void ibl_choice_print(const ibl_choice *c, FILE *to)
{
    print_rows(c, false, to);
    print_rows(c, true, to);
    fprintf(to, "%-22s %10s %10s\n%-22s %10zu %10zu\n%-22s %8.2f %% %8.2f %%\n",
            "", "chosen", "default", "bytes of texels", c->bytes,
            c->usual_bytes, "expected error", 100 * c->error,
            100 * c->usual_error);
}

static json_t *json_rows(const ibl_choice *c, bool chosen)
{
    json_t *rows = json_array();

    for (int i = 0; i < c->count; i++) {
        const ibl_choice_row *row = &c->row[i];
        json_t *j =
            json_pack("{ss ss}", "name", row->name, "value", row->value);
        if (*row->why)
            put(&j, "why", json_string(row->why));
        if (row->chosen == chosen)
            append(&rows, j);
        else
            json_decref(j);
    }
    return rows;
}

json_t *ibl_choice_json(const ibl_choice *c)
{
    return json_pack("{sf sb so so s{sI sf} s{sI sf}}", "asked_error", c->asked,
                     "reached", c->reached, "found", json_rows(c, false),
                     "chosen", json_rows(c, true), "set", "bytes",
                     (json_int_t)c->bytes, "expected_error",
                     ibl_json_digits(c->error), "default", "bytes",
                     (json_int_t)c->usual_bytes, "expected_error",
                     ibl_json_digits(c->usual_error));
}
