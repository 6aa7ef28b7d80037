/* SPDX-License-Identifier: MIT */
/* The report as one page: bench_page.html with the measurements in it. */
#include <stdlib.h>
#include <string.h>

#include "cli/bench.h"
#include "common/memory_file.h"

/* Made by the build. */
extern const char ibl_bench_page[];

/* JSON inside a script element: nothing in a string may end the element. */
static void put_json(const char *json, FILE *to)
{
    for (; *json; json++)
        if (*json == '<')
            fputs("\\u003c", to);
        else
            fputc(*json, to);
}

char *ibl_bench_html(const ibl_bench *b)
{
    static const char marker[] = "@JSON@";
    const char *place = strstr(ibl_bench_page, marker);
    char *json = ibl_bench_json(b);
    ibl_memory_file page;
    FILE *to = json ? ibl_memory_open(&page) : NULL;

    if (to) {
        fwrite(ibl_bench_page, 1, (size_t)(place - ibl_bench_page), to);
        put_json(json, to);
        fputs(place + sizeof marker - 1, to);
    }
    free(json);
    return to ? ibl_memory_close(to, &page) : NULL;
}
