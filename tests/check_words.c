/* SPDX-License-Identifier: MIT */
/* Words of text, and places in it that are filled in. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cli/words.c"
#include "test.h"

TEST(split)
{
    static const struct {
        const char *text, *words[4];
    } cases[] = {
        {"", {NULL}},
        {"  \t\n ", {NULL}},
        {"a", {"a"}},
        {" a  bc\td ", {"a", "bc", "d"}},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        char **words = ibl_words_split(cases[i].text);
        int n = 0;
        NEED(words);
        for (; words[n] && cases[i].words[n]; n++)
            CHECK_MSG(!strcmp(words[n], cases[i].words[n]), "%s: %s",
                      cases[i].text, words[n]);
        CHECK_MSG(!words[n] && !cases[i].words[n], "%s: %d words",
                  cases[i].text, n);
        free(words);
    }
}

TEST(placeholders)
{
    const ibl_placeholder holders[] = {{"env", "E"}, {"out", "O/{env}"}};
    char *text =
        ibl_words_fill("{env} {out}/{env}{ {no} ${x} {envy} {env", holders, 2);

    NEED(text);
    CHECK(!strcmp(text, "E O/{env}/E{ {no} ${x} {envy} {env"));
    free(text);
}
