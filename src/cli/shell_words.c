/* SPDX-License-Identifier: MIT */
#include "cli/shell_words.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "json/text.h"

static const char blanks[] = " \t\n";

/* Copies the word at *text to `to` without its quotes and moves *text behind
 * it. Returns the end of the copy; NULL: a quote is not closed. */
static char *take_word(const char **text, char *to)
{
    const char *s = *text;
    char quote = '\0';

    for (; *s && (quote || !strchr(blanks, *s)); s++) {
        if (quote ? *s == quote : *s == '\'' || *s == '"')
            quote = quote ? '\0' : *s;
        else if (*s == '\\' && quote != '\'' && s[1])
            *to++ = *++s;
        else
            *to++ = *s;
    }
    *to++ = '\0';
    *text = s;
    return quote ? NULL : to;
}

char **ibl_words_split(const char *text)
{
    const size_t length = strlen(text);
    /* A word and the blank after it have two characters or more. The words'
     * text follows the pointers. */
    const size_t most = length / 2 + 2;
    char **words = malloc(most * sizeof *words + length + 2);
    char *to = words ? (char *)(words + most) : NULL;
    size_t n = 0;

    while (words) {
        text += strspn(text, blanks);
        if (!*text)
            break;
        words[n++] = to;
        to = take_word(&text, to);
        if (!to) {
            free(words);
            return NULL;
        }
    }
    if (words)
        words[n] = NULL;
    return words;
}

char *ibl_words_fill(const char *text, const ibl_placeholder *holders,
                     int count)
{
    ibl_memory_file file;
    FILE *to = ibl_memory_open(&file);

    if (!to)
        return NULL;
    while (*text) {
        int i = 0;
        size_t length = 0;
        for (; *text == '{' && i < count; i++) {
            length = strlen(holders[i].name);
            if (!strncmp(text + 1, holders[i].name, length) &&
                text[1 + length] == '}')
                break;
        }
        if (*text == '{' && i < count) {
            fputs(holders[i].text, to);
            text += length + 2;
        } else {
            fputc(*text++, to);
        }
    }
    return ibl_memory_close(to, &file);
}
