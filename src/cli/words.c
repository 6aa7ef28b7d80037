/* SPDX-License-Identifier: MIT */
#include "cli/words.h"

#include <stdlib.h>
#include <string.h>

#include "common/signals.h"

char **ibl_words_split(const char *text)
{
    const size_t length = strlen(text);
    /* A word and the blank after it have two characters or more. The words'
     * text follows the pointers. */
    const size_t most = length / 2 + 2;
    char **words = ibl_need(malloc(most * sizeof *words + length + 1));
    char *from = strcpy((char *)(words + most), text), *rest;
    size_t n = 0;

    while ((words[n] = strtok_r(n ? NULL : from, " \t\n", &rest)))
        n++;
    return words;
}

bool ibl_words_bits(const char *list, const char *const *names, unsigned *bits)
{
    *bits = 0;
    do {
        const size_t length = strcspn(list, ",");
        int i = 0;
        while (names[i] &&
               (strncmp(names[i], list, length) != 0 || names[i][length]))
            i++;
        if (!names[i])
            return false;
        *bits |= 1u << i;
        list += length;
    } while (*list++);
    return true;
}

char *ibl_words_fill(const char *text, const ibl_placeholder *holders,
                     int count)
{
    char *all = ibl_need(strdup(""));

    while (*text) {
        const size_t before = strcspn(text, "{");
        size_t length = text[before] == '{';
        const char *put = length ? "{" : "";
        for (int i = 0; i < count && length == 1; i++) {
            const size_t n = strlen(holders[i].name);
            if (!strncmp(text + before + 1, holders[i].name, n) &&
                text[before + 1 + n] == '}') {
                put = holders[i].text;
                length = n + 2;
            }
        }
        ibl_append(&all, "%.*s%s", (int)before, text, put);
        text += before + length;
    }
    return all;
}
