/* SPDX-License-Identifier: MIT */
#include "json/word_list.h"

#include <stdio.h>
#include <string.h>

void ibl_names_text(const char *const *names, char *text, size_t size)
{
    *text = '\0';
    for (int i = 0; names[i]; i++) {
        const size_t used = strlen(text);
        const char *between = i == 0 ? "" : names[i + 1] ? ", " : " or ";
        snprintf(text + used, size - used, "%s%s", between, names[i]);
    }
}

int ibl_names_find(const char *const *names, const char *word)
{
    for (int i = 0; names[i]; i++)
        if (!strcmp(names[i], word))
            return i;
    return -1;
}
