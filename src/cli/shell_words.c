/* SPDX-License-Identifier: MIT */
#include "cli/shell_words.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/signals.h"
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
    char **words = ibl_need(malloc(most * sizeof *words + length + 2));
    char *to = (char *)(words + most);
    size_t n = 0;

    for (; *(text += strspn(text, blanks)); n++) {
        words[n] = to;
        to = take_word(&text, to);
        if (!to) {
            free(words);
            return NULL;
        }
    }
    words[n] = NULL;
    return words;
}

char *ibl_words_fill(const char *text, const ibl_placeholder *holders,
                     int count)
{
    char *all = ibl_need(strdup(text)), *at = all;

    while ((at = strchr(at, '{'))) {
        int i = 0;
        size_t length = 0;
        for (; i < count; i++) {
            length = strlen(holders[i].name);
            if (!strncmp(at + 1, holders[i].name, length) &&
                at[1 + length] == '}')
                break;
        }
        const size_t before = (size_t)(at - all);
        at++;
        if (i == count)
            continue;
        char *filled = ibl_need(ibl_format("%.*s%s%s", (int)before, all,
                                           holders[i].text, at + length + 1));
        free(all);
        all = filled;
        at = all + before + strlen(holders[i].text);
    }
    return all;
}
