/* SPDX-License-Identifier: MIT */
/* Streams into memory: all that was written, or nothing. */
#define _GNU_SOURCE
#include <stdlib.h>

static int left; /* calls of realloc until one fails */
static void *scarce(void *old, size_t size)
{
    return left-- == 0 ? NULL : realloc(old, size);
}
#define realloc scarce
#include "json/json_text.c"
#undef realloc

#include "test.h"

static char *write_numbers(int count, ibl_memory_file *file)
{
    FILE *to = ibl_memory_open(file);

    for (int i = 0; to && i < count; i++)
        fprintf(to, "%07d\n", i);
    return ibl_memory_close(to, file);
}

TEST(all_of_it)
{
    static const int counts[] = {0, 1, 511, 512, 513, 20000};

    for (size_t k = 0; k < sizeof counts / sizeof *counts; k++) {
        ibl_memory_file file;
        left = -1;
        char *text = write_numbers(counts[k], &file);
        NEED(text);
        CHECK(file.size == (size_t)counts[k] * 8 && strlen(text) == file.size);
        CHECK(file.room > file.size);
        for (int i = 0; i < counts[k]; i++)
            CHECK(atoi(text + 8 * (size_t)i) == i);
        free(text);
    }
}

/* What comes after there is memory again does not hide it. */
TEST(or_nothing)
{
    for (int at = 0;; at++) {
        ibl_memory_file file;
        left = at;
        char *text = write_numbers(20000, &file);
        if (left >= 0) {
            CHECK(text && at > 3);
            free(text);
            return;
        }
        CHECK(!text);
    }
}

TEST(none_is_none)
{
    ibl_memory_file file;

    CHECK(!ibl_memory_close(NULL, &file));
}
