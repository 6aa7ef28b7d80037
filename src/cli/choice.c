/* SPDX-License-Identifier: MIT */
#include "cli/choice.h"

#include <stdarg.h>
#include <string.h>

#include "json/json_text.h"

void ibl_choice_add(ibl_choice *c, bool chosen, const char *name,
                    const char *fmt, ...)
{
    va_list args;

    if (c->count == IBL_CHOICE_ROWS)
        return;
    c->row[c->count].chosen = chosen;
    c->row[c->count].name = name;
    va_start(args, fmt);
    vsnprintf(c->row[c->count].text, sizeof c->row->text, fmt, args);
    va_end(args);
    c->count++;
}

void ibl_choice_print(const ibl_choice *c, FILE *to)
{
    for (int chosen = 0; chosen < 2; chosen++) {
        const char *first = chosen ? "chosen" : "found";
        for (int i = 0; i < c->count; i++) {
            const char *text = c->row[i].text, *why = strchr(text, '\t');
            if (c->row[i].chosen != chosen)
                continue;
            fprintf(to, "%-7s %-14s %.*s%s%s\n", first, c->row[i].name,
                    why ? (int)(why - text) : (int)strlen(text), text,
                    why ? "  " : "", why ? why + 1 : "");
            first = "";
        }
    }
    fprintf(to,
            "%-22s %10s %10s\n%-22s %10zu %10zu\n"
            "%-22s %8.2f %% %8.2f %%  +- %.2g %%\n",
            "", "chosen", "default", "bytes of texels", c->bytes,
            c->usual_bytes, "rendered error", 100 * c->error,
            100 * c->usual_error, 100 * c->standard_error);
}

json_t *ibl_choice_json(const ibl_choice *c)
{
    json_t *rows[] = {json_array(), json_array()};

    for (int i = 0; i < c->count; i++) {
        const char *text = c->row[i].text, *why = strchr(text, '\t');
        json_t *j = json_pack("{ss ss%}", "name", c->row[i].name, "value", text,
                              why ? (size_t)(why - text) : strlen(text));
        if (why)
            put(&j, "why", json_string(why + 1));
        append(&rows[c->row[i].chosen], j);
    }
    return json_pack("{sf sb so so s{sI sf sf} s{sI sf}}", "asked_error",
                     c->asked, "reached", c->reached, "found", rows[0],
                     "chosen", rows[1], "set", "bytes", (json_int_t)c->bytes,
                     "rendered_error", ibl_json_digits(c->error),
                     "standard_error", ibl_json_digits(c->standard_error),
                     "default", "bytes", (json_int_t)c->usual_bytes,
                     "rendered_error", ibl_json_digits(c->usual_error));
}
